// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Chunks of setpoints and their times, the same for both transports.

use super::Outcome;
use camwright_msgs::builtin_interfaces::msg::{Duration as RosDuration, Time};
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};
use std::io::BufRead as _;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

pub const TOPIC: &str = "/machine/setpoints";
/// Depth of the histories, as in the product.
pub const DEPTH: u32 = 1000;
/// The interpolator sends a chunk for every ten ticks of 1 ms.
const PERIOD: Duration = Duration::from_millis(10);
/// Longest wait for a partner.
pub const PATIENCE: Duration = Duration::from_secs(30);
/// Silence after which a receiver ends.
const SILENCE: Duration = Duration::from_secs(15);
/// Setpoints and points of the stop in a chunk, as in `tests/benchmarks/latency`.
const POINTS: i32 = 10 + 11;

pub fn now_ns() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
}

/// A chunk that carries its number and the time at which it leaves.
fn chunk(number: usize) -> JointTrajectory {
    let point = |index: i32| JointTrajectoryPoint {
        positions: vec![0.1; 3],
        velocities: vec![0.0; 3],
        accelerations: vec![0.0; 3],
        effort: Vec::new(),
        time_from_start: RosDuration { sec: 0, nanosec: u32::try_from(index * 1_000_000).unwrap_or(0) },
    };
    let mut chunk = JointTrajectory {
        joint_names: ["c_axis", "x_axis", "z_axis"].map(String::from).into(),
        points: (0..POINTS).map(point).collect(),
        ..JointTrajectory::default()
    };
    chunk.header.frame_id = format!("{number:08}");
    let (seconds, rest) = (now_ns() / 1_000_000_000, now_ns() % 1_000_000_000);
    chunk.header.stamp = Time { sec: i32::try_from(seconds).unwrap_or(0), nanosec: u32::try_from(rest).unwrap_or(0) };
    chunk
}

/// A chunk that arrived.
pub struct Arrival {
    number: String,
    sent_ns: i64,
    received_ns: i64,
}

impl Arrival {
    pub fn new(chunk: &JointTrajectory) -> Self {
        let stamp = &chunk.header.stamp;
        let sent_ns = i64::from(stamp.sec) * 1_000_000_000 + i64::from(stamp.nanosec);
        Self { number: chunk.header.frame_id.chars().take(8).collect(), sent_ns, received_ns: now_ns() }
    }
}

/// Sends a burst of chunks, one in each period, for every line of the standard input; returns at its end.
pub fn send_bursts(
    count: usize,
    wait_for_receiver: impl Fn() -> Outcome,
    mut publish: impl FnMut(&JointTrajectory) -> Outcome,
) -> Outcome {
    println!("ready");
    let mut number = 0;
    for line in std::io::stdin().lock().lines() {
        line?;
        wait_for_receiver()?;
        let start = Instant::now();
        for index in 0..u32::try_from(count)? {
            std::thread::sleep((PERIOD * index).saturating_sub(start.elapsed()));
            if let Err(error) = publish(&chunk(number)) {
                eprintln!("chunk {number}: {error}");
            }
            number += 1;
        }
        println!("sent {number}");
    }
    Ok(())
}

/// Prints what arrives until it is complete or nothing more comes.
pub fn print_arrivals(count: usize, arrivals: &Receiver<Result<Arrival, String>>) -> Outcome {
    println!("ready");
    let (mut good, mut wait) = (0, 2 * PATIENCE);
    let end = loop {
        if good == count {
            break "complete";
        }
        match arrivals.recv_timeout(wait) {
            Ok(Ok(Arrival { number, sent_ns, received_ns })) => {
                println!("chunk {number} {sent_ns} {received_ns}");
                (good, wait) = (good + 1, SILENCE);
            }
            Ok(Err(reason)) => println!("rejected {reason}"),
            Err(RecvTimeoutError::Timeout) => break "silence",
            Err(RecvTimeoutError::Disconnected) => break "the transport has ended",
        }
    };
    println!("end {end}");
    Ok(())
}
