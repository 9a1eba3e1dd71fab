//! The load: numbered messages of one topic, published by a process of its own.

use super::support::{Domain, Guarded, LOOPBACK, PATIENCE, PeerEnv};
use camwright_nodes::ros::{Node, NodeOptions, Qos, RosArgs};
use std::io::{BufRead, Read, Write};
use std::os::unix::process::CommandExt;
use std::process::{ChildStdin, Command};
use std::time::{Duration, Instant};

/// The word that makes the benchmark a publisher.
pub const PUBLISH: &str = "--publish";
pub const TOPIC: &str = "/load";
pub const TYPE: &str = "std_msgs/msg/String";
/// Where the number stands in a message, behind the head of CDR and the length of the text, and its digits.
const NUMBER: std::ops::Range<usize> = 8..18;
/// Messages at the end, one by one, and the pause between them; as in `publish.py`.
pub const LAST: u64 = 20;
const PAUSE: Duration = Duration::from_millis(20);
const BURST: Duration = Duration::from_micros(500);

/// Whose DDS publishes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Stack {
    Cyclone,
    Rclpy,
    Ours,
}

/// What is published.
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

/// What a publisher says of itself at its end.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sent {
    pub sent: u64,
    /// How often it had to wait for room.
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

    /// Waits until somebody is subscribed.
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
        let told: serde_json::Value = serde_json::from_str(&line).expect("what it says is JSON");
        let number = |key: &str| told[key].as_u64().unwrap_or_else(|| panic!("no {key} in {line}"));
        let seconds = |key: &str| told[key].as_f64().unwrap_or_else(|| panic!("no {key} in {line}"));
        Sent { sent: number("sent"), refused: number("refused"), took_s: seconds("took_s"), cpu_s: seconds("cpu_s") }
    }
}

/// Our ROS layer as a publisher, called and answering like `publish.py`.
pub fn publish_on_our_layer(words: &[String]) {
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
    let told = serde_json::json!({"sent": sent.sent, "refused": sent.refused, "took_s": took_s, "cpu_s": cpu_s});
    println!("{told}");
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
