//! Seats of the page's viewers: bounded, and given up by whoever makes the least of one when somebody new comes.

use std::io::{self, ErrorKind, Write};
use std::net::{IpAddr, Shutdown, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Connections at the same time; a viewer holds one.
pub(super) const MAX_SEATS: usize = 32;
/// Connections of one other computer. Viewers on this one share an address and have all seats.
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
    /// Its request has come.
    has_asked: AtomicBool,
    /// It does not take what is being written to it.
    is_stalled: AtomicBool,
    written: AtomicU64,
}

impl Viewer {
    /// Who gives up a seat first: whoever does not read, who does not ask, who has not proven to read; of each the oldest.
    fn rank(&self) -> (u8, Instant) {
        let rank = if self.is_stalled.load(Ordering::Acquire) {
            0
        } else if !self.has_asked.load(Ordering::Acquire) {
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
struct Taken {
    seated: Vec<Arc<Viewer>>,
    /// Shut down, thread still there.
    ending: usize,
}

#[derive(Debug, Clone, Default)]
pub(super) struct Seats(Arc<Mutex<Taken>>);

fn lock(taken: &Mutex<Taken>) -> MutexGuard<'_, Taken> {
    taken.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Seats {
    /// A seat for a connection; another viewer is shut down for it where there is none. `None`: even that takes too long.
    pub(super) fn occupy(&self, stream: &TcpStream) -> Option<Seat> {
        let from = stream.peer_addr().ok()?.ip();
        let viewer = Viewer {
            stream: stream.try_clone().ok()?,
            from,
            since: Instant::now(),
            has_asked: AtomicBool::new(false),
            is_stalled: AtomicBool::new(false),
            written: AtomicU64::new(0),
        };
        let mut taken = lock(&self.0);
        let of_address = |viewer: &Arc<Viewer>| viewer.from == from;
        if !from.is_loopback() && taken.seated.iter().filter(|viewer| of_address(viewer)).count() >= MAX_OF_ADDRESS {
            evict(&mut taken, of_address);
        } else if taken.seated.len() >= MAX_SEATS {
            evict(&mut taken, |_| true);
        }
        if taken.ending > MAX_ENDING || taken.seated.len() >= MAX_SEATS {
            return None;
        }
        let viewer = Arc::new(viewer);
        taken.seated.push(Arc::clone(&viewer));
        Some(Seat { viewer, taken: Arc::clone(&self.0) })
    }
}

/// Shuts down the viewer of least rank among some.
fn evict(taken: &mut Taken, is_among: impl Fn(&Arc<Viewer>) -> bool) {
    let among = taken.seated.iter().enumerate().filter(|(_, viewer)| is_among(viewer));
    let Some((index, _)) = among.min_by_key(|(_, viewer)| viewer.rank()) else { return };
    let viewer = taken.seated.swap_remove(index);
    // Its thread finds its socket closed and ends; a browser asks again after a second.
    let _gone = viewer.stream.shutdown(Shutdown::Both);
    taken.ending += 1;
}

/// A viewer's seat, given up when it is dropped.
#[derive(Debug)]
pub(super) struct Seat {
    viewer: Arc<Viewer>,
    taken: Arc<Mutex<Taken>>,
}

impl Seat {
    /// The request has come.
    pub(super) fn asks(&self) {
        self.viewer.has_asked.store(true, Ordering::Release);
    }

    /// Writes all of it, within a time for the whole.
    pub(super) fn write(&self, mut stream: &TcpStream, mut bytes: &[u8], patience: Duration) -> io::Result<()> {
        let deadline = Instant::now() + patience;
        let stalled = |is_stalled| self.viewer.is_stalled.store(is_stalled, Ordering::Release);
        // Only a full socket marks the viewer as stalled, not a thread that waits for a processor.
        let mut is_full = false;
        while !bytes.is_empty() {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                // A viewer that reads a byte at a time would hold the seat for ever.
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

impl Drop for Seat {
    fn drop(&mut self) {
        let mut taken = lock(&self.taken);
        match taken.seated.iter().position(|viewer| Arc::ptr_eq(viewer, &self.viewer)) {
            Some(index) => drop(taken.seated.swap_remove(index)),
            None => taken.ending = taken.ending.saturating_sub(1),
        }
    }
}
