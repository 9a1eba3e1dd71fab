// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Events of discovery between the start of a participant and the first turn of its executor.
//!
//! `RustDDS` has room for 2048 events and drops the next ones. A node makes its endpoints before it spins; meanwhile three running cells of
//! four nodes announce more than that, and a match that is dropped is never reported again: the node waits for a service that is there.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use std::{io, mem};

/// Time between two looks: discovery reports some ten events in a millisecond.
const PERIOD: Duration = Duration::from_millis(5);

/// Takes events on a thread of its own until the executor does.
#[derive(Debug)]
pub(super) struct EarlyEvents<T> {
    events: Arc<Mutex<Vec<T>>>,
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl<T: Send + 'static> EarlyEvents<T> {
    /// Takes what `next` returns.
    pub(super) fn collect(mut next: impl FnMut() -> Option<T> + Send + 'static) -> io::Result<Self> {
        let (events, is_over) = (Arc::<Mutex<Vec<T>>>::default(), Arc::<AtomicBool>::default());
        let (into, ended) = (Arc::clone(&events), Arc::clone(&is_over));
        let collect = move || {
            while !ended.load(Ordering::Acquire) {
                while let Some(event) = next() {
                    into.lock().unwrap_or_else(PoisonError::into_inner).push(event);
                }
                std::thread::park_timeout(PERIOD);
            }
        };
        let thread = std::thread::Builder::new().name("early discovery".into()).spawn(collect)?;
        Ok(Self { events, is_over, thread: Some(thread) })
    }
}

impl<T> EarlyEvents<T> {
    /// Ends the thread; returns the events in their order. Later calls return none.
    pub(super) fn finish(&mut self) -> Vec<T> {
        self.is_over.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // It does not panic; if it did, the executor takes the next events.
            let _ended = thread.join();
        }
        mem::take(&mut *self.events.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl<T> Drop for EarlyEvents<T> {
    fn drop(&mut self) {
        drop(self.finish());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    /// The channel has room for 16 events; without a reader the 17th would wait for ever.
    #[test]
    fn a_small_channel_loses_nothing_and_keeps_the_order() {
        let (sender, receiver) = mpsc::sync_channel(16);
        let mut early = EarlyEvents::collect(move || receiver.try_recv().ok()).expect("a thread");
        for number in 0..1000_usize {
            sender.send(number).expect("the reader lives");
        }
        let taken = early.finish();
        // What the thread has not taken stays in the channel for the executor.
        assert!(taken.len() >= 1000 - 16, "{}", taken.len());
        assert!(taken.iter().copied().eq(0..taken.len()), "{taken:?}");
        assert!(early.finish().is_empty());
    }
}
