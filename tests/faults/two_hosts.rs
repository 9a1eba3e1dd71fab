// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A cell on two hosts: planner and page on one, machine, interpolator and recorder on the other, with the discovery range SUBNET. The cable
//! between them is clean, loses frames, or is unplugged in the middle of a job.
//!
//! Every job ends, and a job after the fault succeeds. Where a job ends early, its message names what was not received and from whom.

use crate::support;

use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};
use support::hosts::{Cable, Hosts};
use support::processes::{fresh_bag, in_domain};
use support::{Domain, Guarded, PATIENCE};

/// A job of some seconds at pace realtime.
const JOB: [&str; 4] =
    ["wheel_radius_mm=60.0", "infeed.per_block_um=0.02", "infeed.spark_out_turns=1", "infeed.total_mm=0.36"];
/// Port of the page: no other process of its host has one.
const PAGE: u16 = 8080;

/// Cell on two hosts.
struct SplitCell {
    /// Planner and page, then interpolator, machine and recorder: the order in which they end.
    nodes: Vec<(&'static str, Guarded)>,
    bag: PathBuf,
    domain: Domain,
    hosts: Hosts,
}

/// Adds what every process of the cell is started with.
fn in_subnet<'a>(command: &'a mut Command, domain: &Domain) -> &'a mut Command {
    command
        .current_dir(support::repository())
        .env("ROS_DOMAIN_ID", domain.id().to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
        .env("XDG_STATE_HOME", env!("CARGO_TARGET_TMPDIR"))
        .env_remove("ROS_LOCALHOST_ONLY")
        .env_remove("ROS_NAMESPACE")
}

impl SplitCell {
    fn start(hosts: Hosts, name: &str, pace: &str) -> Self {
        let (domain, bag) = (Domain::reserve(), fresh_bag(&format!("two-hosts-{name}")));
        let node = |name, command: &mut Command| (name, Guarded::start(name, in_subnet(command, &domain)));
        let mut planner = hosts.command(env!("CARGO_BIN_EXE_job_planner"));
        let mut page = hosts.command(env!("CARGO_BIN_EXE_camwright"));
        page.args(["page", "--port", &PAGE.to_string()]);
        let mut interpolator = hosts.command_outside(env!("CARGO_BIN_EXE_axis_interpolator"));
        let mut machine = hosts.command_outside(env!("CARGO_BIN_EXE_machine_sim"));
        machine.args(["--ros-args", "-p", "state_file:=none", "-p", &format!("pace:={pace}")]);
        machine.args(["-p", "machine_overrides:=[\"wheel.spin_up_s=0.2\", \"feedback_delay_ticks=500\"]"]);
        let mut recorder = hosts.command_outside(env!("CARGO_BIN_EXE_run_logger"));
        recorder.args(["--ros-args", "-p", &format!("bag_dir:={}", bag.display())]);
        let nodes = vec![
            node("job_planner", &mut planner),
            node("operator_page", &mut page),
            node("axis_interpolator", &mut interpolator),
            node("machine_sim", &mut machine),
            node("run_logger", &mut recorder),
        ];
        Self { nodes, bag, domain, hosts }
    }

    /// Starts a job as a user on the planner's host does.
    fn job(&self) -> Guarded {
        let mut command = self.hosts.command(env!("CARGO_BIN_EXE_camwright"));
        command.args(["run", "eccentric", "--attach", "--json"]);
        for over in JOB {
            command.args(["--set", over]);
        }
        Guarded::start("camwright run --attach", in_subnet(&mut command, &self.domain))
    }

    /// Status of the cell, as the page on the planner's host shows it.
    fn status(&self) -> Value {
        let snapshot = self.hosts.get_inside(PAGE, "/snapshot.json").unwrap_or_default();
        let mut snapshot: Value = serde_json::from_str(&snapshot).unwrap_or_default();
        snapshot["status"].take()
    }

    /// Waits for a state on the page.
    fn wait_for(&self, word: &str) -> Value {
        self.wait_until(word, |status| status["state"]["word"] == word)
    }

    fn wait_until(&self, what: &str, is_wanted: impl Fn(&Value) -> bool) -> Value {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let status = self.status();
            if is_wanted(&status) {
                return status;
            }
            assert!(Instant::now() < deadline, "the page does not show {what} within {PATIENCE:?}: {status}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Ends all nodes; the recorder lost nothing.
    fn end(mut self) {
        for (name, node) in &mut self.nodes {
            node.interrupt();
            let status = node.wait(PATIENCE);
            assert!(status.success(), "{name} ends with {status}{}", node.complaint());
        }
        let mut check = in_domain(env!("CARGO_BIN_EXE_camwright"), &self.domain);
        let check = check.args(["bag", "check"]).arg(&self.bag).output().expect("camwright runs");
        assert_eq!(check.status.code(), Some(0), "{}", String::from_utf8_lossy(&check.stdout));
        std::fs::remove_dir_all(&self.bag).expect("the bag is ours");
    }
}

/// Outcome of a job: exit code, and the report or the error.
fn outcome(mut run: Guarded) -> (Option<i32>, Value) {
    let code = run.wait(PATIENCE).code();
    let report = run.remaining_lines(PATIENCE).join("");
    (code, serde_json::from_str(&report).unwrap_or_else(|_| Value::String(run.stderr())))
}

fn succeeds(cell: &SplitCell) {
    let (_, report) = outcome(cell.job());
    assert_eq!(report["status"], "Succeeded", "{report}");
}

#[test]
fn a_cell_on_two_hosts_runs_a_job() {
    let Some(hosts) = Hosts::new("cell") else { return };
    let cell = SplitCell::start(hosts, "clean", "fast");
    succeeds(&cell);
    cell.wait_for("COMPLETE");
    cell.end();
}

/// 5 % of the frames are lost, 2 % come twice, 2 % come 20 ms too early.
#[test]
fn a_cell_on_two_hosts_runs_a_job_over_a_bad_network() {
    let Some((hosts, mut cable)) = Hosts::with_faulty_cable("bad") else { return };
    let _nothing_yet = cable.set(&json!({ "loss": 0.05, "delay_s": 0.02, "reorder": 0.02, "duplicate": 0.02 }));
    let cell = SplitCell::start(hosts, "bad", "fast");
    for _ in 0..2 {
        succeeds(&cell);
        cell.wait_for("COMPLETE");
    }
    let counts = cable.set(&json!({}));
    for fault in ["lost", "reordered", "duplicated"] {
        assert!(counts[fault].as_u64().is_some_and(|count| count > 20), "the cable was too good: {counts}");
    }
    cell.end();
}

/// Runs a job, and unplugs the cable for a time while the wheel cuts.
fn job_with_unplugged_cable(cell: &SplitCell, cable: &mut Cable, time: Duration) -> (Option<i32>, Value) {
    let run = cell.job();
    cell.wait_for("CUTTING");
    let _before = cable.set(&json!({ "plugged": false }));
    std::thread::sleep(time);
    let _while_unplugged = cable.set(&json!({ "plugged": true }));
    outcome(run)
}

/// The axes move on for 3 s without a planner; after 10 s both sides have ended the job for the same reason.
#[test]
fn an_unplugged_cable_is_survived_or_named() {
    let Some((hosts, mut cable)) = Hosts::with_faulty_cable("unplugged") else { return };
    let cell = SplitCell::start(hosts, "unplugged", "realtime");
    let (_, report) = job_with_unplugged_cable(&cell, &mut cable, Duration::from_secs(3));
    assert_eq!(report["status"], "Succeeded", "{report}");

    let (code, report) = job_with_unplugged_cable(&cell, &mut cable, Duration::from_secs(10));
    assert_eq!((code, &report["alarm"]), (Some(3), &json!(164)), "{report}");
    let message = report["message"].as_str().expect("a text");
    for words in ["no message from the axis interpolator on axis_interpolator/state for 6 s", "the network is lost"] {
        assert!(message.contains(words), "{message}");
    }
    let stopped = cell.wait_for("ALARM 164");
    let alarm = stopped["alarms"][0]["text"].as_str().expect("a text");
    assert!(alarm.contains("no message from the job planner on job_planner/cell_state for 5 s"), "{alarm}");
    let is_at_rest = |axis: &Value| axis["velocity"].as_f64().is_some_and(|velocity| velocity.abs() < 0.01);
    cell.wait_until("axes at rest", |status| status["axes"].as_array().is_some_and(|axes| axes.iter().all(is_at_rest)));

    let mut reset = cell.hosts.command(env!("CARGO_BIN_EXE_camwright"));
    let reset = in_subnet(reset.arg("reset"), &cell.domain).output().expect("camwright runs");
    assert_eq!(reset.status.code(), Some(0), "{}", String::from_utf8_lossy(&reset.stderr));
    succeeds(&cell);
    cell.end();
}
