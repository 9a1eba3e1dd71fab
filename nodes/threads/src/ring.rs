// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Between a cyclic thread and the rest of its node: a ring that wakes its reader.
//!
//! The cyclic thread only moves values; the other threads of the node build messages, publish and log. Values are
//! made before and dropped after, by the other side: the ring itself never allocates.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::{self, Thread};
use std::time::Duration;

/// Wakes one thread that waits for something to do.
#[derive(Debug, Clone, Default)]
pub struct Waker {
    inner: Arc<WakerState>,
}

#[derive(Debug, Default)]
struct WakerState {
    thread: OnceLock<Thread>,
    has_news: AtomicBool,
}

impl Waker {
    /// Names the calling thread as the one to wake; only the first call counts.
    pub fn adopt_current_thread(&self) {
        let _already_adopted = self.inner.thread.set(thread::current());
    }

    /// Wakes the thread, now or when it next waits.
    pub fn wake(&self) {
        self.inner.has_news.store(true, Ordering::Release);
        if let Some(thread) = self.inner.thread.get() {
            thread.unpark();
        }
    }

    /// Waits on the adopted thread until it is woken or the time is over; true if it was woken.
    #[must_use]
    pub fn wait(&self, at_most: Duration) -> bool {
        if !self.inner.has_news.swap(false, Ordering::Acquire) {
            thread::park_timeout(at_most);
            return self.inner.has_news.swap(false, Ordering::Acquire);
        }
        true
    }
}

/// The writing end of a ring.
#[derive(Debug)]
pub struct Sender<T> {
    ring: rtrb::Producer<T>,
    waker: Waker,
}

/// The reading end of a ring.
#[derive(Debug)]
pub struct Receiver<T> {
    ring: rtrb::Consumer<T>,
}

/// A ring of fixed capacity between two threads; every value sent wakes `waker`.
#[must_use]
pub fn ring<T>(capacity: usize, waker: &Waker) -> (Sender<T>, Receiver<T>) {
    let (producer, consumer) = rtrb::RingBuffer::new(capacity);
    (Sender { ring: producer, waker: waker.clone() }, Receiver { ring: consumer })
}

impl<T> Sender<T> {
    /// Sends a value.
    ///
    /// # Errors
    /// The ring is full; the value comes back.
    pub fn send(&mut self, value: T) -> Result<(), T> {
        match self.ring.push(value) {
            Ok(()) => {
                self.waker.wake();
                Ok(())
            }
            Err(rtrb::PushError::Full(value)) => Err(value),
        }
    }

    /// Sends a value that can wait until the next one that wakes the reader.
    ///
    /// # Errors
    /// The ring is full; the value comes back.
    pub fn send_quietly(&mut self, value: T) -> Result<(), T> {
        self.ring.push(value).map_err(|rtrb::PushError::Full(value)| value)
    }

    /// Values that fit now.
    #[must_use]
    pub fn free(&self) -> usize {
        self.ring.slots()
    }

    /// Returns whether the reader is gone.
    #[must_use]
    pub fn is_abandoned(&self) -> bool {
        self.ring.is_abandoned()
    }
}

impl<T> Receiver<T> {
    /// The next value, if there is one.
    pub fn receive(&mut self) -> Option<T> {
        self.ring.pop().ok()
    }

    /// Returns whether no value waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ring.is_empty()
    }

    /// Returns whether the writer is gone.
    #[must_use]
    pub fn is_abandoned(&self) -> bool {
        self.ring.is_abandoned()
    }
}
