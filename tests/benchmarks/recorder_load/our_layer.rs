// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The load from our own ROS layer: what a process of the benchmark does that was started with [`PUBLISH`].

use super::load::{LAST, NUMBER, PUBLISH};
use camwright_ros::{Node, NodeOptions, Qos, RosArgs};
use std::io::{BufRead, Read};
use std::time::{Duration, Instant};

const TYPE: &str = "std_msgs/msg/String";
/// The pause between the messages at the end, and that between bursts; as in `publish.py`.
const PAUSE: Duration = Duration::from_millis(20);
const BURST: Duration = Duration::from_micros(500);

/// Our ROS layer as a publisher, called and answering like `publish.py`.
pub fn publish(words: &[String]) {
    let [topic, octets, reliability] = words else { panic!("{PUBLISH} TOPIC OCTETS best_effort|reliable") };
    let (args, _rest) = RosArgs::parse(&[]).expect("the environment is ours");
    let node = Node::new(NodeOptions::new("load", &args)).expect("a node");
    let qos = Qos::default_topic().keep_all();
    let qos = if reliability == "reliable" { qos } else { qos.best_effort() };
    let publisher = node.raw_publisher(topic, TYPE, &qos).expect("a publisher");
    let _spin = node.spin_in_thread().expect("a thread");
    println!("our ROS layer (RustDDS)");
    while !publisher.wait_matched(1, Duration::from_secs(3600)) {}
    println!("matched");
    let mut order = String::new();
    std::io::stdin().lock().read_line(&mut order).expect("an order");
    let (rate, seconds) = order.trim().split_once(' ').expect("RATE SECONDS");
    let (rate, seconds) = (rate.parse::<u64>().expect("a rate"), seconds.parse::<u64>().expect("a time"));
    let mut sent = Numbered { message: message(octets.parse().expect("a length")), sent: 0, refused: 0 };
    let publish = |cdr: &[u8]| publisher.publish(cdr).is_ok();
    let begun = Instant::now();
    while sent.sent < rate * seconds {
        let due = u64::try_from(begun.elapsed().as_nanos() * u128::from(rate) / 1_000_000_000).unwrap_or(u64::MAX);
        sent.up_to(due.min(rate * seconds), publish);
        std::thread::sleep(BURST);
    }
    let took_s = begun.elapsed().as_secs_f64();
    std::thread::sleep(25 * PAUSE);
    for _ in 0..LAST {
        sent.up_to(sent.sent + 1, publish);
        std::thread::sleep(PAUSE);
    }
    let cpu_s = super::usage::cpu_s(std::process::id());
    let report = serde_json::json!({"sent": sent.sent, "refused": sent.refused, "took_s": took_s, "cpu_s": cpu_s});
    println!("{report}");
    let _end_of_input = std::io::stdin().read_to_end(&mut Vec::new());
}

/// A message of that length: text of ten digits, dots behind it.
fn message(octets: usize) -> Vec<u8> {
    let length = octets - NUMBER.start;
    let padded = octets.next_multiple_of(4);
    let mut message = vec![b'.'; padded];
    message[..4].copy_from_slice(&[0, 1, 0, 0]);
    message[4..8].copy_from_slice(&u32::try_from(length).expect("a short message").to_le_bytes());
    message[octets - 1..].fill(0);
    message
}

struct Numbered {
    message: Vec<u8>,
    sent: u64,
    refused: u64,
}

impl Numbered {
    fn up_to(&mut self, due: u64, publish: impl Fn(&[u8]) -> bool) {
        while self.sent < due {
            let digits = format!("{:010}", self.sent + 1);
            self.message[NUMBER].copy_from_slice(digits.as_bytes());
            if publish(&self.message) {
                self.sent += 1;
            } else {
                self.refused += 1;
            }
        }
    }
}
