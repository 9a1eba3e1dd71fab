// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Bytes for one client: a bounded buffer between the feed and the thread that writes to the socket.

use std::net::{Shutdown, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Unwritten bytes at which a client counts as not reading. A whole set of values is about 3 kB, so this is minutes of changes.
pub(super) const MAX_PENDING: usize = 1 << 20;

#[derive(Debug, Default)]
struct State {
    pending: Vec<u8>,
    is_closed: bool,
}

#[derive(Debug)]
pub(super) struct Outbox {
    stream: TcpStream,
    state: Mutex<State>,
    changed: Condvar,
    has_overflowed: AtomicBool,
}

impl Outbox {
    pub(super) fn new(stream: TcpStream) -> Self {
        Self { stream, state: Mutex::default(), changed: Condvar::new(), has_overflowed: AtomicBool::new(false) }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds bytes; false if the client is disconnected, now or before.
    pub(super) fn push(&self, bytes: &[u8]) -> bool {
        let mut state = self.lock();
        if state.is_closed {
            return false;
        }
        if state.pending.len() + bytes.len() > MAX_PENDING {
            self.mark_overflowed();
            self.close_locked(&mut state);
            return false;
        }
        state.pending.extend_from_slice(bytes);
        self.changed.notify_one();
        true
    }

    /// Waits for bytes; `None` after the end of the connection.
    pub(super) fn take(&self) -> Option<Vec<u8>> {
        let state = self.lock();
        let waited = self.changed.wait_while(state, |state| state.pending.is_empty() && !state.is_closed);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner);
        (!state.is_closed).then(|| std::mem::take(&mut state.pending))
    }

    /// Ends the connection; wakes both of its threads.
    pub(super) fn close(&self) {
        self.close_locked(&mut self.lock());
    }

    fn close_locked(&self, state: &mut State) {
        if !std::mem::replace(&mut state.is_closed, true) {
            state.pending = Vec::new();
            // The client may have closed it.
            let _gone = self.stream.shutdown(Shutdown::Both);
            self.changed.notify_all();
        }
    }

    pub(super) fn is_closed(&self) -> bool {
        self.lock().is_closed
    }

    /// Notes that the client does not read.
    pub(super) fn mark_overflowed(&self) {
        self.has_overflowed.store(true, Ordering::Release);
    }

    /// Returns true if the connection ended because the client did not read.
    pub(super) fn has_overflowed(&self) -> bool {
        self.has_overflowed.load(Ordering::Acquire)
    }

    pub(super) fn stream(&self) -> &TcpStream {
        &self.stream
    }
}
