// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The same job gives the same samples, bit for bit: at pace fast and realtime, in one process and in four, with messages
//! delayed at random, and in a simulation without any network.

use crate::support;

use camwright_analysis::rerun::rerun;
use camwright_bag::Bag;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;
use support::{Domain, Guarded};

/// A short version of the default job: one turn of infeed, spark-out until the force is steady, with a varying work speed, on all four lobes.
/// Setpoints run far ahead, so that a busy computer is no underrun.
const SHORT: [&str; 14] = [
    "--set",
    "infeed.total_mm=0.036",
    "--set",
    "infeed.spark_out_turns=6",
    "--set",
    "infeed.spark_out_until_n=300",
    "--set",
    "stock_mm=0.03",
    "--set",
    "speed_variation={slower_percent: 30, period_turns: 1.5}",
    "--set-machine",
    "wheel.spin_up_s=0.2",
    "--set-machine",
    "feedback_delay_ticks=500",
];

/// Output of `camwright run --json`.
struct Run {
    bag: PathBuf,
    first_tick: u64,
    last_tick: u64,
}

/// Everything of a sample but its stamp: names, positions, velocities, efforts, as they were on the wire.
type Samples = BTreeMap<u64, Vec<u8>>;

fn bag_directory(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("same-bits-{name}-{}", std::process::id()));
    let _not_there = std::fs::remove_dir_all(&path);
    path
}

fn camwright(domain: &Domain) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.env("ROS_DOMAIN_ID", domain.id().to_string()).env("XDG_STATE_HOME", env!("CARGO_TARGET_TMPDIR"));
    command
}

fn run_of(output: &std::process::Output, bag: PathBuf) -> Run {
    let text = String::from_utf8_lossy(&output.stdout);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}\n{complaint}");
    let report: serde_json::Value = serde_json::from_str(text.trim()).expect("one line of JSON");
    let turns: Vec<f64> =
        report["lobes"].as_array().into_iter().flatten().filter_map(|lobe| lobe["turns"].as_f64()).collect();
    assert!(turns.len() == 4 && turns.iter().all(|turns| *turns < 7.0), "no spark-out was cut short: {turns:?}");
    let tick = |key: &str| report[key].as_u64().expect("a tick");
    Run { bag, first_tick: tick("first_tick"), last_tick: tick("last_tick") }
}

/// The job in one process.
fn in_one_process(name: &str, pace: &str, delays: Option<&str>) -> Samples {
    let domain = Domain::reserve();
    let bag = bag_directory(name);
    let mut command = camwright(&domain);
    command.args(["run", "--json", "--pace", pace, "--bag"]).arg(&bag).args(SHORT);
    if let Some(delays) = delays {
        command.env("CAMWRIGHT_DELAY_INJECTION", delays);
    }
    samples(&run_of(&command.output().expect("camwright runs"), bag))
}

/// The job with each node in a process of its own.
fn in_four_processes(name: &str, pace: &str) -> Samples {
    let domain = Domain::reserve();
    let bag = bag_directory(name);
    let node = |binary: &str, parameters: &[String]| {
        let mut command = Command::new(binary);
        command.env("ROS_DOMAIN_ID", domain.id().to_string()).env("XDG_STATE_HOME", env!("CARGO_TARGET_TMPDIR"));
        command.arg("--ros-args");
        for parameter in parameters {
            command.args(["-p", parameter]);
        }
        Guarded::start(binary, &mut command)
    };
    let machine = [
        format!("pace:={pace}"),
        "machine_overrides:=[\"wheel.spin_up_s=0.2\", \"feedback_delay_ticks=500\"]".to_owned(),
    ];
    let mut nodes = [
        node(env!("CARGO_BIN_EXE_run_logger"), &[format!("bag_dir:={}", bag.display())]),
        node(env!("CARGO_BIN_EXE_machine_sim"), &machine),
        node(env!("CARGO_BIN_EXE_axis_interpolator"), &[]),
        node(env!("CARGO_BIN_EXE_job_planner"), &[]),
    ];
    let mut command = camwright(&domain);
    let of_job = SHORT.iter().take_while(|word| **word != "--set-machine");
    command.args(["run", "--json", "--attach"]).args(of_job);
    let run = run_of(&command.output().expect("camwright runs"), bag);
    for node in nodes.iter_mut().rev() {
        node.interrupt();
        let status = node.wait(Duration::from_secs(30));
        assert!(status.success(), "a node ends well on SIGINT: {}", node.complaint());
    }
    samples(&run)
}

/// The joint states of a bag from the job's first tick to its last, by the tick since the first.
fn samples(run: &Run) -> Samples {
    let bag = Bag::open(&run.bag).expect("a bag");
    let mut epoch = None;
    let mut stamped = Vec::new();
    let mut messages = bag.messages();
    while let Some(message) = messages.next_message().expect("a readable bag") {
        match bag.topics()[message.topic].name.as_str() {
            "/machine/stream" => epoch = Some(time_ns(&message.data[12..20])),
            "/joint_states" => stamped.push((time_ns(&message.data[4..12]), message.data[12..].to_vec())),
            _ => {}
        }
    }
    let epoch = epoch.expect("the machine spoke");
    let tick = |stamp: i64| u64::try_from((stamp - epoch) / 1_000_000).expect("a tick");
    let samples: Samples = stamped
        .into_iter()
        .map(|(stamp, data)| (tick(stamp), data))
        .filter(|(tick, _)| (run.first_tick..=run.last_tick).contains(tick))
        .map(|(tick, data)| (tick - run.first_tick, data))
        .collect();
    // Every run can be computed again from what machine and interpolator were given, to the bit.
    let verdict = rerun(&run.bag).expect("the bag holds what it takes");
    assert!(verdict.is_identical(), "{}", verdict.to_text());
    let expected = run.last_tick - run.first_tick + 1;
    assert_eq!(samples.len() as u64, expected, "every tick of the job is in the bag");
    std::fs::remove_dir_all(&run.bag).expect("the bag is ours");
    samples
}

fn time_ns(bytes: &[u8]) -> i64 {
    let sec = i32::from_le_bytes(bytes[..4].try_into().expect("four bytes"));
    let nanosec = u32::from_le_bytes(bytes[4..].try_into().expect("four bytes"));
    i64::from(sec) * 1_000_000_000 + i64::from(nanosec)
}

fn assert_same(name: &str, reference: &Samples, other: &Samples) {
    assert_eq!(reference.len(), other.len(), "{name}: number of ticks");
    for ((tick, expected), found) in reference.iter().zip(other.values()) {
        assert_eq!(expected, found, "{name}: first difference at tick {tick} of the job");
    }
}

/// Runs at pace realtime mostly wait, so they go beside the others.
#[test]
fn pace_processes_and_delays_change_no_bit() {
    std::thread::scope(|scope| {
        let realtime = scope.spawn(|| in_one_process("realtime", "realtime", None));
        let four_realtime = scope.spawn(|| in_four_processes("four-realtime", "realtime"));
        let reference = in_one_process("fast", "fast", None);
        assert_same("again", &reference, &in_one_process("again", "fast", None));
        assert_same("delayed", &reference, &in_one_process("delayed", "fast", Some("20261121:8")));
        assert_same("four processes", &reference, &in_four_processes("four", "fast"));
        assert_same("realtime", &reference, &realtime.join().expect("the run ends"));
        assert_same("four processes, realtime", &reference, &four_realtime.join().expect("the run ends"));
    });
}
