// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! ROS domains that no other test on this machine uses at the same time.

use std::fs::{File, OpenOptions, TryLockError};
use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

/// Largest domain handed out. The UDP ports of domain d are 7400 + 250 d and on, which must stay below the ephemeral ports (32768); and
/// the tests of the ROS layer that need no peer have fixed domains from 60 on.
const LAST_DOMAIN: u16 = 59;

/// A ROS domain id that is ours until this is dropped (or the process ends, however it ends).
#[derive(Debug)]
pub struct Domain {
    id: u16,
    lock: Option<File>,
}

impl Drop for Domain {
    fn drop(&mut self) {
        // A test that fails leaves its nodes behind, and nobody else is to meet them: the domain stays taken until the process ends.
        if std::thread::panicking() {
            std::mem::forget(self.lock.take());
        }
    }
}

impl Domain {
    /// Takes a free domain of 1..=59. Domains belong to the machine and not to a source tree, so the locks lie in the system's
    /// directory for temporary files, where other checkouts look too.
    ///
    /// # Panics
    /// When all are taken, or the lock files cannot be opened.
    pub fn reserve() -> Self {
        let directory = std::env::temp_dir().join("camwright-test-domains");
        std::fs::create_dir_all(&directory).expect("the system's directory for temporary files can be written");
        // Not from the same end every time: a domain rests a while before the next test meets what the last one left in caches.
        static TAKEN: AtomicU32 = AtomicU32::new(0);
        let start = std::process::id().wrapping_add(TAKEN.fetch_add(1, Ordering::Relaxed));
        let first = u16::try_from(start % u32::from(LAST_DOMAIN)).expect("less than LAST_DOMAIN");
        for offset in 0..LAST_DOMAIN {
            let id = (first * 37 + offset * 7) % LAST_DOMAIN + 1;
            let file = open(&directory.join(id.to_string())).expect("a lock file can be opened");
            match file.try_lock() {
                Ok(()) => return Self { id, lock: Some(file) },
                Err(TryLockError::WouldBlock) => {}
                Err(TryLockError::Error(error)) => panic!("cannot lock a domain: {error}"),
            }
        }
        panic!("all {LAST_DOMAIN} test domains are taken; see {}", directory.display());
    }

    /// The number, for `ROS_DOMAIN_ID`.
    pub fn id(&self) -> u16 {
        self.id
    }
}

/// Another user's lock file can be read and locked though not written.
fn open(path: &Path) -> io::Result<File> {
    OpenOptions::new().create(true).truncate(false).write(true).open(path).or_else(|_| File::open(path))
}
