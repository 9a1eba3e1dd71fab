// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Room kept back, so that a bag can still be closed when the disk is full.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

/// Size of the reserve (B): one chunk, its indexes, and the summary of several hours' chunks. A larger one would refuse
/// small disks, a smaller one could lose the summary.
pub const SPARE_BYTES: usize = 4 << 20;

/// A file that takes [`SPARE_BYTES`] on the disk and has no name, so that even a killed process leaves nothing behind.
/// Dropping it gives the room back.
#[derive(Debug)]
pub struct DiskReserve {
    _file: File,
}

impl DiskReserve {
    /// Keeps room back on the disk of `directory`.
    ///
    /// # Errors
    /// When the disk has less room than that, or the directory cannot be written.
    pub fn create(directory: &Path) -> io::Result<Self> {
        let path = directory.join(".spare");
        let mut file = OpenOptions::new().write(true).create_new(true).open(&path)?;
        let filled = fill(&mut file);
        let removed = fs::remove_file(&path);
        filled?;
        removed?;
        Ok(Self { _file: file })
    }
}

fn fill(file: &mut File) -> io::Result<()> {
    // Noise, since a compressing file system would keep no room for zeros (xorshift64).
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut block = Vec::with_capacity(SPARE_BYTES);
    while block.len() < SPARE_BYTES {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        block.extend_from_slice(&state.to_le_bytes());
    }
    file.write_all(&block)
}

/// Progress of a [`ReservedWriter`], visible while a library owns the stream.
#[derive(Debug, Default)]
pub struct DiskLevel {
    written: AtomicU64,
    full: OnceLock<String>,
}

impl DiskLevel {
    /// Bytes that the stream below has taken.
    pub fn written(&self) -> u64 {
        self.written.load(Ordering::Relaxed)
    }

    /// System error at the moment the disk ran full; the reserve is in use since then.
    pub fn full(&self) -> Option<&str> {
        self.full.get().map(String::as_str)
    }
}

/// A stream that gives back the spare room when the disk is full and tries once more, so that the writer above it sees no
/// failure in the middle of a record; [`DiskLevel::full`] then says that it is time to close.
#[derive(Debug)]
pub struct ReservedWriter<W, S> {
    inner: W,
    spare: Option<S>,
    level: Arc<DiskLevel>,
}

impl<W: Write, S> ReservedWriter<W, S> {
    /// `inner`, with `spare` given back when it is full.
    pub fn new(inner: W, spare: S) -> Self {
        Self { inner, spare: Some(spare), level: Arc::default() }
    }

    /// Handle to its progress.
    pub fn level(&self) -> Arc<DiskLevel> {
        self.level.clone()
    }

    pub fn into_inner(self) -> W {
        self.inner
    }
}

fn says_full(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge)
}

impl<W: Write, S> Write for ReservedWriter<W, S> {
    fn write(&mut self, buf: &[u8]) -> io::Result<usize> {
        let result = match self.inner.write(buf) {
            Err(error) if says_full(&error) => match self.spare.take() {
                Some(spare) => {
                    drop(spare);
                    // Only the first refusal is reported; there is only one reserve.
                    let _ = self.level.full.set(error.to_string());
                    self.inner.write(buf)
                }
                None => Err(error),
            },
            other => other,
        };
        if let Ok(n) = result {
            self.level.written.fetch_add(n as u64, Ordering::Relaxed);
        }
        result
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::rc::Rc;

    use super::*;

    /// A disk of so many bytes, some of which the spare takes.
    struct Disk {
        free: Rc<Cell<usize>>,
        content: Vec<u8>,
    }

    impl Write for Disk {
        fn write(&mut self, buf: &[u8]) -> io::Result<usize> {
            let n = buf.len().min(self.free.get());
            if n == 0 && !buf.is_empty() {
                return Err(io::ErrorKind::StorageFull.into());
            }
            self.free.set(self.free.get() - n);
            self.content.extend_from_slice(&buf[..n]);
            Ok(n)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    struct CountedBuffer(Rc<Cell<usize>>, usize);

    impl Drop for CountedBuffer {
        fn drop(&mut self) {
            self.0.set(self.0.get() + self.1);
        }
    }

    #[test]
    fn a_full_disk_costs_no_byte_while_the_spare_lasts() {
        let free = Rc::new(Cell::new(10));
        let disk = Disk { free: free.clone(), content: Vec::new() };
        let mut writer = ReservedWriter::new(disk, CountedBuffer(free, 6));
        writer.write_all(b"0123456789").expect("there is room");
        let level = writer.level();
        assert!(level.full().is_none());
        writer.write_all(b"abcdef").expect("the spare is room enough");
        assert!(level.full().is_some(), "the writer must learn that it is time to close");
        assert_eq!(level.written(), 16);
        writer.write_all(b"!").expect_err("nothing is left");
        assert_eq!(writer.into_inner().content, b"0123456789abcdef");
    }

    #[test]
    fn the_spare_has_no_name() {
        let dir = tempfile::TempDir::new().expect("a temporary directory");
        let spare = DiskReserve::create(dir.path()).expect("the disk of the temporary directory has 4 MiB");
        assert_eq!(fs::read_dir(dir.path()).expect("it is a directory").count(), 0);
        drop(spare);
    }
}
