// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A part that is turned by the whole cell: from the command line, twice the same, and what ends it before its end.

use crate::cell;
use crate::support;

use byteorder::LittleEndian;
use camwright_analysis::rerun::rerun;
use camwright_bag::Bag;
use camwright_msgs::camwright_msgs::action::{RunJob, RunJobFeedback};
use camwright_msgs::camwright_msgs::msg::{FormMap, JobStatus, MachineAlarms, TurnedPage};
use camwright_msgs::camwright_msgs::srv::{
    FindPhase, FindPhaseRequest, LoadBar, LoadBarRequest, LoadJob, LoadJobRequest,
};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest};
use camwright_ros::{ClientGoal, GoalStatus, ParameterValue, Qos};
use cell::{Cell, PATIENCE};
use serde_json::Value;
use std::process::{Command, Output};
use std::sync::mpsc;
use std::time::Instant;
use support::{Domain, Folder};

const JOB: &str = "turned_cam";
/// A short piece of the shipped part on a coarser grid.
const SHORT: [&str; 4] =
    ["turned.to_mm=22", "form_grid.azimuths=180", "finishing.along_z_mm=0.3", "roughing.along_z_mm=0.8"];

fn run(folder: &Folder, bag: &str, more: &[&str]) -> Output {
    let domain = Domain::reserve();
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.path()).args(["run", JOB, "--bag"]).arg(folder.join(bag));
    for over in SHORT {
        command.args(["--set", over]);
    }
    command.args(more).output().expect("camwright runs")
}

/// The report of a run, its bag's form maps, and the bits of the surface that it left.
fn turned(folder: &Folder, name: &str) -> (Value, Vec<FormMap>, Vec<u64>) {
    let output = run(folder, name, &["--json", "--causes"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (mut maps, mut pages) = (Vec::new(), Vec::new());
    let verdict = rerun(&folder.join(name)).expect("the bag holds what it takes");
    assert!(verdict.is_identical() && verdict.setpoints > 1000, "{}", verdict.to_text());
    let bag = Bag::open(&folder.join(name)).expect("a bag");
    let mut messages = bag.messages();
    while let Some(message) = messages.next_message().expect("a readable bag") {
        // Four octets say how the rest is encoded.
        let data = &message.data[4..];
        match bag.topics()[message.topic].name.as_str() {
            "/machine/turned_part" => {
                pages.push(cdr_encoding::from_bytes::<TurnedPage, LittleEndian>(data).expect("a page").0);
            }
            "/job_planner/form_map" => {
                maps.push(cdr_encoding::from_bytes::<FormMap, LittleEndian>(data).expect("a map").0);
            }
            _ => {}
        }
    }
    pages.sort_by_key(|page| page.page);
    assert_eq!(pages.len(), pages[0].pages as usize, "every page once");
    let bits = pages.iter().flat_map(|page| page.radius.iter().map(|radius| radius.to_bits())).collect();
    (serde_json::from_slice(&output.stdout).expect("a report"), maps, bits)
}

/// Over DDS, by nodes whose messages came at other times, the part is the same bit for bit; report and bag carry the same map.
#[test]
fn a_part_is_turned_over_dds_the_same_every_time_and_its_form_is_reported() {
    let folder = Folder::new("turned");
    let (report, maps, bits) = turned(&folder, "one");
    let part = &report["turned"];
    let um = |key: &str| part[key].as_f64().expect("a number");
    assert_eq!((report["good"].as_bool(), part["passes"].as_u64()), (Some(true), Some(3)));
    assert!(
        um("form_error_max_um").abs() > 2.0 && um("form_error_max_um").abs() < um("form_error_allowed_um"),
        "{part}"
    );
    let late_s =
        report["duration_s"].as_f64().zip(report["predicted_s"].as_f64()).map(|(took, predicted)| took - predicted);
    // The origin of C is found where it is, and predicted half a turn away.
    assert!(late_s.is_some_and(|late_s| late_s.abs() < 3.0), "{late_s:?} s");
    let list = |key: &str| -> Vec<f64> {
        report["form_map"][key].as_array().expect("a list").iter().filter_map(Value::as_f64).collect()
    };
    let farthest = list("lowest_um").into_iter().chain(list("highest_um")).fold(0.0_f64, |most, um| most.max(um.abs()));
    assert!((farthest / um("form_error_max_um").abs() - 1.0).abs() < 1e-5, "{farthest} um in the map, {part}");
    let [map] = maps.as_slice() else { panic!("{} maps in the bag", maps.len()) };
    assert_eq!(
        (map.highest.len(), map.tick),
        (list("highest_um").len(), report["last_tick"].as_u64().expect("a tick"))
    );
    let instead = report["form_error_instead"].as_object().expect("other machines");
    let rms = |name: &str| instead[name]["rms_um"].as_f64().expect("a number");
    assert!(
        rms("with good drives") < um("form_error_rms_um") && rms("without servo") < rms("with good drives"),
        "{instead:?}"
    );
    let (_, _, again) = turned(&folder, "two");
    assert!(bits == again, "two runs of one job left two surfaces");
}

#[test]
fn the_command_line_reports_a_verdict_and_refuses_grinding_options() {
    let folder = Folder::new("turned-verdict");
    let strict = run(&folder, "strict", &["--set", "tolerance_um=0.5", "--details", "--causes"]);
    let text = String::from_utf8_lossy(&strict.stdout);
    assert_eq!(strict.status.code(), Some(4), "{text}");
    assert!(
        text.starts_with("NOT GOOD: worst form error ") && text.contains("largest form error (um) by z (mm)"),
        "{text}"
    );
    for (flags, words) in [
        (["--parts", "2"].as_slice(), "--parts does not apply to turning job turned_cam: "),
        (
            &["--identify-only"],
            "--identify-only does not apply to turning job turned_cam: turning measures no stiffness",
        ),
        (&["--find-phase"], "--find-phase does not apply to turning job turned_cam: the raw part is a round bar"),
    ] {
        let refused = run(&folder, "refused", flags);
        let stderr = String::from_utf8_lossy(&refused.stderr);
        assert!(refused.status.code() == Some(1) && stderr.contains(words), "{flags:?}: {stderr}");
        assert!(!folder.join("refused").exists(), "a refused run leaves no bag");
    }
    // On a machine that grinds the planner says why, and nobody waits for a record of what it has not.
    let refused = run(&folder, "ground", &["--set", "machine=cam_grinder"]);
    let stderr = String::from_utf8_lossy(&refused.stderr);
    assert!(refused.status.code() == Some(1) && stderr.contains("the machine grinds with a wheel"), "{stderr}");
}

/// A tolerance that any drive keeps is kept by the smallest gain that is tried; good drives leave less than ordinary ones.
#[test]
fn required_drives_are_reported_for_turning_jobs() {
    let drives = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
        let output = command.current_dir(support::repository()).arg("drives").args(arguments).output();
        output.expect("camwright runs")
    };
    let mut arguments = vec![JOB, "--json", "--tolerance-um", "500"];
    SHORT.iter().for_each(|over| arguments.extend(["--set", over]));
    let output = drives(&arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let output: Value = serde_json::from_slice(&output.stdout).expect("a report in JSON");
    let beyond_um = |name: &str| output["drives"][name]["beyond_um"].as_f64().expect("a number");
    assert!(beyond_um("ideal drives").abs() < 1e-12, "they leave nothing beyond themselves");
    assert!(beyond_um("good drives") < 0.5 * beyond_um("the machine's drives"), "{}", output["drives"]);
    let least = |index: usize| &output["gain_of_x"][index]["result"]["least"];
    for index in 0..2 {
        assert_eq!(least(index)["kv_1_s"].as_f64().map(f64::round), Some(31.0), "{}", output["gain_of_x"]);
    }
    let refused = drives(&["eccentric"]);
    let stderr = String::from_utf8_lossy(&refused.stderr);
    assert!(refused.status.code() == Some(2) && stderr.contains("job eccentric grinds"), "{stderr}");
}

/// A cell with the lathe.
fn lathe() -> Cell {
    Cell::start_with(&[], |args| {
        args.with_parameter(Some("machine_sim"), "machine", ParameterValue::String("lathe".into()))
    })
}

/// Begins the job and waits until its first pass cuts.
fn cutting(cell: &Cell) -> (ClientGoal<RunJob>, mpsc::Receiver<RunJobFeedback>) {
    let (goal, feedback) = cell.client.send(JOB, &SHORT);
    assert!(
        goal.accepted(),
        "{:?}",
        cell.client.status("a status with the reason", |status| !status.message.is_empty()).message
    );
    loop {
        let progress = feedback.recv_timeout(PATIENCE).expect("feedback");
        if progress.phase_name == "cut" && progress.turn > 1.0 {
            return (goal, feedback);
        }
    }
}

#[test]
fn a_hold_a_cancel_and_an_emergency_stop_in_the_spiral_end_well_and_the_next_job_runs() {
    let cell = lathe();
    let (sender, alarms) = mpsc::channel::<MachineAlarms>();
    let _alarms = cell.client.node.subscribe("machine/alarms", &Qos::latched(1).keep_last(50), move |message, _| {
        drop(sender.send(message));
    });
    let (goal, _feedback) = cutting(&cell);
    let hold = |hold| cell.client.call::<SetBool>("axis_interpolator/feed_hold", &SetBoolRequest { data: hold });
    assert!(hold(true).success && hold(false).success);
    let (status, held) = goal.result(PATIENCE).expect("the job ends");
    assert_eq!((status, held.turned.len()), (GoalStatus::Succeeded, 1), "{}", held.message);

    let (goal, _feedback) = cutting(&cell);
    goal.cancel_with(|_| {}).expect("a cancel is asked for");
    let (status, cancelled) = goal.result(PATIENCE).expect("the job ends");
    assert_eq!((status, cancelled.turned.len()), (GoalStatus::Canceled, 0), "{}", cancelled.message);

    let (goal, _feedback) = cutting(&cell);
    let press = |data| cell.client.call::<SetBool>("machine/estop", &SetBoolRequest { data });
    assert!(press(true).success);
    let (status, stopped) = goal.result(PATIENCE).expect("the job ends");
    assert_eq!((status, stopped.alarm), (GoalStatus::Aborted, 1), "{}", stopped.message);
    while alarms.recv_timeout(PATIENCE).expect("the alarm").alarms.is_empty() {}
    assert!(press(false).success);
    let end = Instant::now() + PATIENCE;
    while !cell.client.call::<Trigger>("machine/reset", &TriggerRequest::default()).success {
        assert!(Instant::now() < end, "the machine is not reset");
    }
    while !alarms.recv_timeout(PATIENCE).expect("news of the reset").alarms.is_empty() {}

    let (goal, _feedback) = cutting(&cell);
    let (status, result) = goal.result(PATIENCE).expect("the job ends");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    let turned = &result.turned[0];
    assert!(turned.form_error_max.abs() <= turned.form_error_allowed, "{turned:?}");
    let complete = cell
        .client
        .status("ends the job", |status| status.state == JobStatus::COMPLETE && status.turned == result.turned);
    assert_eq!(complete.plan_hash, result.plan_hash);
    cell.stop();
}

#[test]
fn what_does_not_fit_a_lathe_or_its_job_is_refused_with_its_reason() {
    let cell = lathe();
    let load = |job: &str, set: &[&str]| {
        let overrides = set.iter().map(ToString::to_string).collect();
        cell.client.call::<LoadJob>("job_planner/load_job", &LoadJobRequest { job: job.into(), overrides })
    };
    let refused = load("eccentric", &[]);
    assert!(!refused.success && refused.message.contains("the cell has lathe"), "{}", refused.message);
    let refused = load(JOB, &["bar_radius_mm=21"]);
    assert!(
        refused.message.contains("turned_cam.yaml:") && refused.message.contains("the bar's radius"),
        "{}",
        refused.message
    );
    let loaded = load(JOB, &SHORT);
    assert!(loaded.success && loaded.duration > 5.0 && loaded.plan_hash.len() == 64, "{}", loaded.message);
    // The loaded job is a turning one: set-up work that is about lobes has none.
    let find = FindPhaseRequest { load_part: true, ..FindPhaseRequest::default() };
    assert!(!cell.client.call::<FindPhase>("job_planner/find_phase", &find).success);
    let bar = LoadBarRequest {
        name: "bar".into(),
        radius: -1.0,
        azimuths: 90,
        columns: 10,
        to_z: 0.01,
        ..LoadBarRequest::default()
    };
    let refused = cell.client.call::<LoadBar>("machine/load_bar", &bar);
    assert!(!refused.success && refused.message.contains("must be positive"), "{}", refused.message);
    cell.stop();

    let grinder = Cell::start(&[]);
    let refused = grinder.client.call::<LoadBar>("machine/load_bar", &LoadBarRequest { radius: 0.02, ..bar });
    assert!(!refused.success && refused.message.contains("grinds with a wheel"), "{}", refused.message);
    let (goal, _feedback) = grinder.client.send(JOB, &SHORT);
    assert!(!goal.accepted());
    let status = grinder.client.status("refuses", |status| status.message.contains("refused"));
    assert!(status.message.contains("the job is for machine lathe, the cell has cam_grinder"), "{}", status.message);
    assert!(!grinder.client.has_moved());
    grinder.stop();
}
