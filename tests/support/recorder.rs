// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A recorder in the graph, and a node that manages it and listens to it.

#![allow(missing_debug_implementations, reason = "as above")]
#![allow(dead_code, reason = "each test target uses its part")]
#![allow(unreachable_pub, reason = "a module of test binaries has no outside")]

use super::support::{Domain, PATIENCE};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use camwright_bag::{Bag, BagMessage};
use camwright_msgs::camwright_msgs::msg::RecorderStatus;
use camwright_msgs::lifecycle_msgs::srv::{ChangeState, ChangeStateRequest};
use camwright_ros::{Node, NodeOptions, Qos, RosArgs, Shutdown, SpinThread};
use camwright_run_logger::RunLogger;

/// `lifecycle_msgs/msg/Transition`.
pub const CONFIGURE: u8 = 1;
pub const ACTIVATE: u8 = 3;
pub const DEACTIVATE: u8 = 4;

pub fn directory(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("recording-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&path).expect("the target directory is writable");
    path
}

pub fn args(domain: &Domain, words: &[&str]) -> RosArgs {
    let words: Vec<String> = words.iter().map(|&w| w.to_owned()).collect();
    RosArgs::parse_with(&words, |_| None).expect("they are valid").0.with_domain_id(domain.id())
}

pub fn until(what: &str, mut condition: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !condition() {
        assert!(Instant::now() < deadline, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A recorder in a thread, and a node that manages it and listens to it.
pub struct RecorderUnderTest {
    pub node: Node,
    _spinning: SpinThread,
    status: Arc<Mutex<RecorderStatus>>,
    shutdown: Shutdown,
    recorder: Option<std::thread::JoinHandle<()>>,
}

impl RecorderUnderTest {
    pub fn new(domain: &Domain, recorder: &[&str]) -> Self {
        let shutdown = Shutdown::new();
        let words = [recorder, &["-p", "autostart:=false"]].concat();
        let (ros, stop) = (args(domain, &words), shutdown.clone());
        let recorder = std::thread::spawn(move || {
            let recorder = RunLogger::start(&ros).expect("it joins the graph");
            stop.wait();
            recorder.stop();
        });
        let node = Node::new(NodeOptions::new("manager", &args(domain, &[]))).expect("it joins the graph");
        let spinning = node.spin_in_thread().expect("there are threads");
        let status = Arc::<Mutex<RecorderStatus>>::default();
        let seen = status.clone();
        let subscription = node
            .subscribe::<RecorderStatus>("/run_logger/status", &Qos::default_topic(), move |message, _| {
                *seen.lock().expect("nobody panics with it") = message;
            })
            .expect("the name is good");
        std::mem::forget(subscription);
        Self { node, _spinning: spinning, status, shutdown, recorder: Some(recorder) }
    }

    pub fn change_state(&self, transition: u8) -> bool {
        let client = self.node.client::<ChangeState>("/run_logger/change_state").expect("the name is good");
        client.wait_for_service(PATIENCE).expect("the recorder offers its life cycle");
        let mut request = ChangeStateRequest::default();
        request.transition.id = transition;
        client.call(&request, PATIENCE).expect("it answers").success
    }

    pub fn status(&self) -> RecorderStatus {
        self.status.lock().expect("nobody panics with it").clone()
    }

    pub fn wait_for_topics(&self, topics: &[&str]) {
        until("the recorder subscribes", || {
            let status = self.status();
            topics.iter().all(|t| status.topics.iter().any(|r| r.topic == *t))
        });
    }

    pub fn written(&self, topic: &str) -> u64 {
        self.status().topics.iter().find(|t| t.topic == topic).map_or(0, |t| t.written)
    }

    pub fn end(&mut self) {
        self.shutdown.request();
        if let Some(recorder) = self.recorder.take() {
            recorder.join().expect("the recorder ends well");
        }
    }
}

impl Drop for RecorderUnderTest {
    fn drop(&mut self) {
        self.shutdown.request();
    }
}

pub fn messages(bag: &Bag, topic: &str) -> Vec<BagMessage> {
    let index =
        bag.topics().iter().position(|t| t.name == topic).unwrap_or_else(|| panic!("{topic} is not in the bag"));
    let (mut reader, mut all) = (bag.messages(), Vec::new());
    while let Some(message) = reader.next_message().expect("the bag is readable") {
        if message.topic == index {
            all.push(message);
        }
    }
    all
}
