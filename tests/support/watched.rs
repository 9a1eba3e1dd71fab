// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Topics of a cell as a test waits for them.
#![allow(missing_debug_implementations, reason = "as above")]
#![allow(dead_code, reason = "each test target uses its part")]
#![allow(unreachable_pub, reason = "a module of test binaries has no outside")]

use crate::cell::{Cell, PATIENCE};
use camwright_msgs::rcl_interfaces::msg::Log;
use camwright_ros::{Qos, Subscription};
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

/// The last message of a topic, and every one of it.
pub struct Watched<M> {
    last: Arc<Mutex<Option<M>>>,
    _subscription: Subscription,
}

impl<M: camwright_msgs::Message + Clone> Watched<M> {
    pub fn new(cell: &Cell, topic: &str, qos: &Qos) -> Self {
        let last: Arc<Mutex<Option<M>>> = Arc::default();
        let place = Arc::clone(&last);
        let on_message = move |message, _: &_| *place.lock().expect("not poisoned") = Some(message);
        Self { last, _subscription: cell.client.node.subscribe::<M>(topic, qos, on_message).expect("a subscription") }
    }

    /// The last message, once it is as wanted.
    pub fn until(&self, what: &str, wanted: impl Fn(&M) -> bool) -> M {
        let deadline = Instant::now() + PATIENCE;
        loop {
            if let Some(message) = self.last.lock().expect("not poisoned").clone().filter(|message| wanted(message)) {
                return message;
            }
            assert!(Instant::now() < deadline, "{what}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Log lines of the cell.
pub struct LogLines {
    lines: mpsc::Receiver<String>,
    _subscription: Subscription,
}

impl LogLines {
    pub fn subscribe(cell: &Cell) -> Self {
        let (sender, lines) = mpsc::channel();
        let on_message = move |log: Log, _: &_| drop(sender.send(log.msg));
        let subscription = cell.client.node.subscribe("/rosout", &Qos::latched(1000), on_message);
        Self { lines, _subscription: subscription.expect("a subscription") }
    }

    /// The next line with these words.
    pub fn line(&self, words: &[&str]) -> String {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let line = self.lines.recv_timeout(left).unwrap_or_else(|_| panic!("no line with {words:?}"));
            if words.iter().all(|word| line.contains(word)) {
                return line;
            }
        }
    }
}
