// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Who records the load: our node `run_logger`, in a process of its own.

use super::account::ReportedCounts;
use super::load::TOPIC;
use super::support::{Domain, Guarded, PATIENCE, processes::in_domain};
use super::usage;
use camwright_msgs::camwright_msgs::msg::RecorderStatus;
use camwright_ros::{Node, NodeOptions, Qos, RosArgs, SpinThread, Subscription};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Queue depth of each recorder's subscription: the default of `run_logger`.
pub const DEPTH: u32 = 20_000;
/// Time of silence after which everything has arrived.
const QUIET: Duration = Duration::from_secs(2);

/// Resources used by a recorder's process.
#[derive(Debug, Clone, Copy, Default)]
pub struct ResourceUse {
    pub cpu_s: f64,
    pub peak_kb: u64,
    pub datagrams_dropped: u64,
}

pub fn used(process: &Guarded) -> ResourceUse {
    let id = process.id();
    ResourceUse {
        cpu_s: usage::cpu_s(id),
        peak_kb: usage::peak_kb(id),
        datagrams_dropped: usage::datagrams_dropped(id),
    }
}

/// `run_logger` in its process, and a node that hears its status.
pub struct RunLoggerProcess {
    pub process: Guarded,
    pub bag: PathBuf,
    status: Arc<(Mutex<RecorderStatus>, Condvar)>,
    _subscription: Subscription,
    _spin: SpinThread,
    pub node: Node,
}

impl RunLoggerProcess {
    /// Begins to record into `bag`: `topics`, or all when it names none.
    pub fn start(domain: &Domain, bag: &Path, topics: &[&str]) -> Self {
        let mut command = in_domain(env!("CARGO_BIN_EXE_run_logger"), domain);
        command.arg("--ros-args");
        Self::start_with(domain, bag, topics, command)
    }

    /// Same as [`RunLoggerProcess::start`], by a command that ends with arguments of ROS.
    pub fn start_with(domain: &Domain, bag: &Path, topics: &[&str], mut command: Command) -> Self {
        let _not_there = std::fs::remove_dir_all(bag);
        let node =
            Node::new(NodeOptions::new("watch", &RosArgs::default().with_domain_id(domain.id()))).expect("a node");
        let status: Arc<(Mutex<RecorderStatus>, Condvar)> = Arc::default();
        let into = Arc::clone(&status);
        let subscription = node
            .subscribe("run_logger/status", &Qos::default_topic(), move |message, _| {
                *into.0.lock().unwrap_or_else(PoisonError::into_inner) = message;
                into.1.notify_all();
            })
            .expect("a subscription");
        let spin = node.spin_in_thread().expect("a thread");
        command.args(["-p", &format!("bag_dir:={}", bag.display()), "-p", &format!("depth:={DEPTH}")]);
        if !topics.is_empty() {
            command.args(["-p", &format!("topics:=[{}]", topics.join(", "))]);
        }
        let process = Guarded::start("run_logger", command.process_group(0));
        Self { process, bag: bag.to_owned(), status, _subscription: subscription, _spin: spin, node }
    }

    /// Waits until the status fits; `false` if it does not within the time.
    pub fn wait_status(&self, time: Duration, fits: impl Fn(&RecorderStatus) -> bool) -> bool {
        let (status, changed) = &*self.status;
        let status = status.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = changed.wait_timeout_while(status, time, |status| !fits(status));
        fits(&waited.unwrap_or_else(PoisonError::into_inner).0)
    }

    /// Waits until it records these topics.
    pub fn wait_for_topics(&self, topics: &[&str]) {
        let has_all = |status: &RecorderStatus| topics.iter().all(|&t| status.topics.iter().any(|r| r.topic == t));
        assert!(self.wait_status(PATIENCE, has_all), "the recorder does not subscribe{}", self.process.complaint());
    }

    pub fn status(&self) -> RecorderStatus {
        self.status.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Recorder's status of the load.
    pub fn counts(&self) -> ReportedCounts {
        let status = self.status();
        let load = status.topics.iter().find(|record| record.topic == TOPIC);
        load.map_or_else(ReportedCounts::default, |t| ReportedCounts {
            received: t.received,
            written: t.written,
            dropped: t.dropped,
        })
    }

    /// Waits until it has all of the load, or nothing comes any more, and all that came has gone somewhere.
    pub fn wait_settled(&self, sent: u64) -> ReportedCounts {
        let deadline = Instant::now() + PATIENCE;
        let (mut last, mut since) = (self.counts(), Instant::now());
        loop {
            let _wait_for_the_next = self.wait_status(Duration::from_millis(100), |_| false);
            let counts = self.counts();
            if counts != last {
                (last, since) = (counts, Instant::now());
            }
            let is_through = counts.received == counts.written + counts.dropped;
            if is_through && (counts.received == sent || since.elapsed() > QUIET) {
                return counts;
            }
            assert!(Instant::now() < deadline, "the recorder does not come to rest: {counts:?}");
        }
    }

    /// Ctrl-C: it closes its bag and ends well.
    pub fn end(mut self) -> (PathBuf, ResourceUse) {
        let used = used(&self.process);
        self.process.interrupt();
        let status = self.process.wait(PATIENCE);
        assert!(status.success(), "run_logger ends with {status}{}", self.process.complaint());
        (self.bag, used)
    }
}
