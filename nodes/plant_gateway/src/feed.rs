// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Present values of all data items, and the clients that receive their changes.
//!
//! One lock orders values and clients: a new client gets all values, then every change after them, and none twice.

use crate::items::Reading;
use crate::outbox::Outbox;
use crate::shdr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

#[derive(Debug, Default)]
struct State {
    prefix: String,
    readings: Vec<Option<Reading>>,
    clients: Vec<Arc<Outbox>>,
}

#[derive(Debug, Default)]
pub(super) struct ReadingFeed(Mutex<State>);

impl ReadingFeed {
    /// Feed with the values before the first message.
    pub(super) fn new(readings: Vec<Option<Reading>>) -> Self {
        Self(Mutex::new(State { prefix: String::new(), readings, clients: Vec::new() }))
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the first part of all ids. Clients that connected before it was known are disconnected and connect again.
    pub(super) fn set_prefix(&self, prefix: String) {
        let mut state = self.lock();
        if state.prefix != prefix {
            state.prefix = prefix;
            state.clients.drain(..).for_each(|client| client.close());
        }
    }

    /// Sends what has changed to all clients; samples only with `with_samples`.
    pub(super) fn publish(&self, readings: Vec<Option<Reading>>, with_samples: bool, time_ns: i64) {
        let mut state = self.lock();
        let text = shdr::changes(Some(&state.readings), &readings, with_samples, &state.prefix, time_ns);
        if with_samples {
            state.readings = readings;
        } else {
            shdr::keep_samples(&mut state.readings, readings);
        }
        if !text.is_empty() {
            // A client whose connection has ended leaves the list.
            state.clients.retain(|client| client.push(text.as_bytes()));
        }
    }

    /// Sends everything to a new client, and then every change.
    pub(super) fn join(&self, client: Arc<Outbox>, time_ns: i64) {
        let mut state = self.lock();
        let all = shdr::changes(None, &state.readings, true, &state.prefix, time_ns);
        if client.push((shdr::greeting() + &all).as_bytes()) {
            state.clients.retain(|client| !client.is_closed());
            state.clients.push(client);
        }
    }
}
