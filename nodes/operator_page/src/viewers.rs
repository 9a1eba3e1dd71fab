// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Connections of viewers, bounded in number: a new viewer replaces one that does not read or does not ask.

use std::io::{self, ErrorKind, Write};
use std::net::{IpAddr, Shutdown, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Connections at the same time; a viewer holds one.
pub(super) const MAX_VIEWERS: usize = 32;
/// Connections of one other computer. Viewers on this one share an address and the full number.
const MAX_OF_ADDRESS: usize = 8;
/// Connections that were shut down and whose threads have not ended yet; beyond them new ones are refused.
const MAX_ENDING: usize = 64;
/// Written bytes that prove that a viewer reads: more than the sockets on both sides hold of unread data.
const PROVEN_BYTES: u64 = 8 << 20;

/// State of a viewer, shared with its thread.
#[derive(Debug)]
struct Viewer {
    stream: TcpStream,
    from: IpAddr,
    since: Instant,
    /// Its request has arrived.
    has_requested: AtomicBool,
    /// It does not read what is being written to it.
    is_stalled: AtomicBool,
    written: AtomicU64,
}

impl Viewer {
    /// Order in which viewers lose their slot: those that do not read, that do not ask, that have not proven to read; of each the oldest.
    fn rank(&self) -> (u8, Instant) {
        let rank = if self.is_stalled.load(Ordering::Acquire) {
            0
        } else if !self.has_requested.load(Ordering::Acquire) {
            1
        } else if self.written.load(Ordering::Acquire) < PROVEN_BYTES {
            2
        } else {
            3
        };
        (rank, self.since)
    }
}

#[derive(Debug, Default)]
struct Slots {
    connected: Vec<Arc<Viewer>>,
    /// Number that are shut down and whose threads still run.
    ending: usize,
}

#[derive(Debug, Clone, Default)]
pub(super) struct Viewers(Arc<Mutex<Slots>>);

fn lock(slots: &Mutex<Slots>) -> MutexGuard<'_, Slots> {
    slots.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Viewers {
    /// Returns a slot for a connection. If none is free, another viewer is shut down. `None`: too many are still ending.
    pub(super) fn occupy(&self, stream: &TcpStream) -> Option<ViewerSlot> {
        let from = stream.peer_addr().ok()?.ip();
        let viewer = Viewer {
            stream: stream.try_clone().ok()?,
            from,
            since: Instant::now(),
            has_requested: AtomicBool::new(false),
            is_stalled: AtomicBool::new(false),
            written: AtomicU64::new(0),
        };
        let mut slots = lock(&self.0);
        let of_address = |viewer: &Arc<Viewer>| viewer.from == from;
        if !from.is_loopback() && slots.connected.iter().filter(|viewer| of_address(viewer)).count() >= MAX_OF_ADDRESS {
            evict(&mut slots, of_address);
        } else if slots.connected.len() >= MAX_VIEWERS {
            evict(&mut slots, |_| true);
        }
        if slots.ending > MAX_ENDING || slots.connected.len() >= MAX_VIEWERS {
            return None;
        }
        let viewer = Arc::new(viewer);
        slots.connected.push(Arc::clone(&viewer));
        Some(ViewerSlot { viewer, slots: Arc::clone(&self.0) })
    }
}

/// Shuts down the viewer of least rank among some.
fn evict(slots: &mut Slots, is_among: impl Fn(&Arc<Viewer>) -> bool) {
    let among = slots.connected.iter().enumerate().filter(|(_, viewer)| is_among(viewer));
    let Some((index, _)) = among.min_by_key(|(_, viewer)| viewer.rank()) else { return };
    let viewer = slots.connected.swap_remove(index);
    // Its thread finds the socket closed and ends; a browser connects again after a second.
    let _gone = viewer.stream.shutdown(Shutdown::Both);
    slots.ending += 1;
}

/// Slot of a viewer; dropping it frees the slot.
#[derive(Debug)]
pub(super) struct ViewerSlot {
    viewer: Arc<Viewer>,
    slots: Arc<Mutex<Slots>>,
}

impl ViewerSlot {
    /// Notes that the request has arrived.
    pub(super) fn mark_requested(&self) {
        self.viewer.has_requested.store(true, Ordering::Release);
    }

    /// Writes all bytes within `patience`.
    pub(super) fn write(&self, mut stream: &TcpStream, mut bytes: &[u8], patience: Duration) -> io::Result<()> {
        let deadline = Instant::now() + patience;
        let stalled = |is_stalled| self.viewer.is_stalled.store(is_stalled, Ordering::Release);
        // Only a full socket marks the viewer as stalled, not a thread that waits for a processor.
        let mut is_full = false;
        while !bytes.is_empty() {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                // A viewer that reads a byte at a time would hold the slot for ever.
                return Err(ErrorKind::TimedOut.into());
            }
            stream.set_nonblocking(!is_full)?;
            stream.set_write_timeout(Some(left))?;
            match stream.write(bytes) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(count) => {
                    self.viewer.written.fetch_add(count as u64, Ordering::AcqRel);
                    bytes = bytes.get(count..).unwrap_or_default();
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock && !is_full => {
                    is_full = true;
                    stalled(true);
                }
                Err(error) => return Err(error),
            }
        }
        stream.set_nonblocking(false)?;
        stalled(false);
        Ok(())
    }
}

impl Drop for ViewerSlot {
    fn drop(&mut self) {
        let mut slots = lock(&self.slots);
        match slots.connected.iter().position(|viewer| Arc::ptr_eq(viewer, &self.viewer)) {
            Some(index) => drop(slots.connected.swap_remove(index)),
            None => slots.ending = slots.ending.saturating_sub(1),
        }
    }
}
