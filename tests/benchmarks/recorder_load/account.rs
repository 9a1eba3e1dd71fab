// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Account of every message of a load: from the bag, from the recorder's status, and the agreement of the two.

use super::load::{Sent, TOPIC, number};
use camwright_bag::check::{BagSeverity, check};
use camwright_bag::{Bag, BagMessage};
use std::path::Path;

/// Recorder's status of the topic.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ReportedCounts {
    pub received: u64,
    pub written: u64,
    pub dropped: u64,
}

/// The numbers of the load's messages in a bag.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Found {
    pub messages: u64,
    /// Numbers between the first and the last that are not there.
    pub missing: u64,
    pub first: u64,
    pub last: u64,
    /// Messages whose number is not greater than the one before: there twice, or out of order.
    pub disordered: u64,
    /// Messages without a number.
    pub foreign: u64,
}

impl Found {
    fn add(&mut self, message: &BagMessage) {
        let Some(number) = number(&message.data) else {
            self.foreign += 1;
            return;
        };
        if self.messages == 0 {
            self.first = number;
        } else if number <= self.last {
            self.disordered += 1;
        } else {
            self.missing += number - self.last - 1;
        }
        self.messages += 1;
        self.last = self.last.max(number);
    }
}

/// Reads a bag: of the messages of the load, their numbers.
pub fn find(bag: &Bag) -> Found {
    let topic = bag.topics().iter().position(|topic| topic.name == TOPIC);
    let (mut messages, mut found) = (bag.messages(), Found::default());
    while let Some(message) = messages.next_message().expect("the bag is readable") {
        if Some(message.topic) == topic {
            found.add(&message);
        }
    }
    found
}

/// Why messages are not in the bag, as the recorder says in it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ReportedLosses {
    pub total: u64,
    pub on_the_way: u64,
    pub queue_full: u64,
    pub not_taken: u64,
}

/// Duration of handing a message over (ns): p50, p99, p99.9, maximum.
pub type Enqueue = [u64; 4];

fn reported_in(bag: &Bag, key: &str) -> u64 {
    let text = bag.custom_data().get(&format!("camwright.{key}"));
    text.and_then(|text| text.parse().ok()).unwrap_or_else(|| panic!("the bag has no camwright.{key}"))
}

pub fn lost(bag: &Bag) -> ReportedLosses {
    let count = |key| reported_in(bag, key);
    ReportedLosses {
        total: count("lost_total"),
        on_the_way: count("lost_on_the_way"),
        queue_full: count("lost_queue_full"),
        not_taken: count("lost_not_taken"),
    }
}

pub fn enqueue(bag: &Bag) -> Enqueue {
    ["enqueue_p50_ns", "enqueue_p99_ns", "enqueue_p99_9_ns", "enqueue_max_ns"].map(|key| reported_in(bag, key))
}

/// Disagreements of a bag that our recorder made; empty if every message is accounted for, once.
pub fn disagreements(path: &Path, sent: &Sent, reported: ReportedCounts) -> Vec<String> {
    let bag = Bag::open(path).expect("it is closed");
    let (found, lost) = (find(&bag), lost(&bag));
    let mut wrong = Vec::new();
    let mut equal = |what: &str, one: u64, other: u64| {
        if one != other {
            wrong.push(format!("{what}: {one} is not {other}"));
        }
    };
    equal("sent = received + lost on the way", sent.sent, reported.received + lost.on_the_way);
    equal("received = written + dropped", reported.received, reported.written + reported.dropped);
    equal("written = in the bag", reported.written, found.messages);
    equal("dropped = by a full queue + by the bag", reported.dropped, lost.queue_full + lost.not_taken);
    equal("lost in all = on the way + dropped", lost.total, lost.on_the_way + reported.dropped);
    equal("missing numbers = lost in all", found.missing, lost.total);
    equal("first number", found.first, 1);
    equal("last number = sent", found.last, sent.sent);
    equal("twice, out of order or foreign", found.disordered + found.foreign, 0);
    let report = check(path).expect("there is a bag");
    // That messages were lost is itself a finding.
    let is_clean =
        if lost.total == 0 { report.findings.is_empty() } else { report.worst() != Some(BagSeverity::Error) };
    if !is_clean {
        wrong.push(format!("bag check: {}", report.to_text()));
    }
    wrong
}
