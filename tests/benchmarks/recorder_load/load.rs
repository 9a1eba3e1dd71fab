// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The load: numbered messages of one topic, published by a process of its own.

use super::support::{Domain, Guarded, LOOPBACK, PATIENCE, PeerEnv};
use std::io::Write;
use std::os::unix::process::CommandExt;
use std::process::{ChildStdin, Command};
use std::time::{Duration, Instant};

/// The word that makes the benchmark a publisher.
pub const PUBLISH: &str = "--publish";
pub const TOPIC: &str = "/load";
/// Offset of the number in a message, behind the head of CDR and the length of the text, and its digits.
pub const NUMBER: std::ops::Range<usize> = 8..18;
/// Messages at the end, one by one; as in `publish.py`.
pub const LAST: u64 = 20;

/// Whose DDS publishes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Stack {
    Cyclone,
    Rclpy,
    Ours,
}

/// Published load.
#[derive(Debug, Clone, Copy)]
pub struct Load {
    pub stack: Stack,
    pub is_reliable: bool,
    /// Length of a message as it travels (octets).
    pub octets: usize,
    pub per_second: u64,
    pub seconds: u64,
}

impl Load {
    pub fn reliability(&self) -> &'static str {
        if self.is_reliable { "reliable" } else { "best_effort" }
    }
}

/// Final report of a publisher.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sent {
    pub sent: u64,
    /// Number of waits for free space.
    pub refused: u64,
    pub took_s: f64,
    pub cpu_s: f64,
}

/// The number of a message; none if it is not one of ours.
pub fn number(cdr: &[u8]) -> Option<u64> {
    std::str::from_utf8(cdr.get(NUMBER)?).ok()?.parse().ok()
}

/// A publisher's process; ended when this is dropped.
pub struct Publisher {
    pub name: String,
    process: Guarded,
    stdin: ChildStdin,
    load: Load,
}

impl Publisher {
    pub fn start(load: Load, env: Option<&PeerEnv>, domain: &Domain) -> Self {
        let mut command = match (load.stack, env) {
            (Stack::Cyclone | Stack::Rclpy, Some(env)) => {
                let mut command = env.python("../benchmarks/recorder_load/publish.py", domain);
                command.arg(if load.stack == Stack::Rclpy { "rclpy" } else { "cyclone" });
                command.env("CYCLONEDDS_URI", LOOPBACK);
                command
            }
            _ => {
                let mut command = Command::new(std::env::current_exe().expect("this program"));
                command.arg(PUBLISH).env("ROS_DOMAIN_ID", domain.id().to_string());
                command
            }
        };
        command.args([TOPIC, &load.octets.to_string(), load.reliability()]);
        // Ctrl-C is for this program, which then ends the others.
        let mut process = Guarded::start("a publisher", command.process_group(0));
        let stdin = process.take_stdin();
        let name = process.line(PATIENCE).unwrap_or_else(|| panic!("a publisher ended{}", process.complaint()));
        Self { name, process, stdin, load }
    }

    /// Waits for a subscriber.
    pub fn wait_matched(&mut self) {
        let line = self.process.line(PATIENCE);
        assert_eq!(line.as_deref(), Some("matched"), "nobody is subscribed{}", self.process.complaint());
    }

    /// Has it publish; `each` is called again and again meanwhile. A reliable publisher may take many times as long as it should.
    pub fn publish(&mut self, mut each: impl FnMut()) -> Sent {
        writeln!(self.stdin, "{} {}", self.load.per_second, self.load.seconds).expect("it listens");
        let deadline = Instant::now() + 20 * Duration::from_secs(self.load.seconds) + PATIENCE;
        let line = loop {
            if let Some(line) = self.process.line_within(Duration::from_millis(200)) {
                break line;
            }
            assert!(self.process.is_running(), "the publisher ended{}", self.process.complaint());
            assert!(Instant::now() < deadline, "the publisher does not come to its end");
            each();
        };
        let report: serde_json::Value = serde_json::from_str(&line).expect("what it says is JSON");
        let number = |key: &str| report[key].as_u64().unwrap_or_else(|| panic!("no {key} in {line}"));
        let seconds = |key: &str| report[key].as_f64().unwrap_or_else(|| panic!("no {key} in {line}"));
        Sent { sent: number("sent"), refused: number("refused"), took_s: seconds("took_s"), cpu_s: seconds("cpu_s") }
    }
}
