// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The job planner among the nodes it works with: jobs run, refused, cancelled, previewed.
#![allow(clippy::print_stdout, reason = "a test shows what it measured")]

use crate::cell;

use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::camwright_msgs::action::RunJobFeedback;
use camwright_msgs::camwright_msgs::msg::{Alarm, CellState, JobStatus};
use camwright_msgs::camwright_msgs::srv::{
    CellCommand, CellCommandRequest, ListJobs, ListJobsRequest, LoadJob, LoadJobRequest, PreviewJob, PreviewJobRequest,
    ValidateJob, ValidateJobRequest, ValidateJobResponse,
};
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_planning as planning;
use camwright_ros::{CancelOutcome, GoalStatus, ParameterValue, Qos, Transition};
use cell::{Cell, PATIENCE};
use std::sync::mpsc;
use std::time::Instant;

/// One lobe, with the mounted wheel, in few turns.
const SHORT: [&str; 3] = ["wheel_radius_mm=60.0", "infeed.per_block_um=0.05", "infeed.spark_out_turns=6"];

#[test]
fn a_job_is_run_to_its_end_with_feedback_and_measured() {
    let cell = Cell::start(&[]);
    let (goal, feedback) = cell.client.send("eccentric", &SHORT);
    assert!(goal.accepted(), "{:?}", cell.client.statuses.try_iter().last());
    let (busy, _) = cell.client.send("eccentric", &SHORT);
    assert!(!busy.accepted(), "one job at a time");
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    assert_eq!(result.alarm, Alarm::NONE);
    assert_eq!(result.lobes.len(), 1);
    let lobe = &result.lobes[0];
    assert!(lobe.form_error_max.abs() < 5e-6, "{} m", lobe.form_error_max);
    assert!(lobe.form_error_rms <= lobe.form_error_max.abs());
    assert!((lobe.turns - 8.0).abs() < 1e-12, "2 turns with infeed and 6 without: {}", lobe.turns);
    assert!(lobe.duration > 8.0 && lobe.duration < result.duration, "{} of {} s", lobe.duration, result.duration);
    // Not predictable: the station's switch is heard of some ticks late, and C wakes up 42.75 deg at 20 rpm farther from
    // its origin than half a turn.
    let prepared = planning::prepare("eccentric", &SHORT.map(String::from), None).expect("the same plan");
    assert_eq!(prepared.plan_hash(), result.plan_hash);
    let times = planning::compare_times(&prepared, &result.lobes, result.duration);
    let late = |what: &str| times.iter().find(|time| time.what == what).expect("a lobe or the job").late_s();
    assert!((0.0..0.05).contains(&late("A")) && (0.0..0.05).contains(&(late("job") - 42.75 / 120.0)), "{times:?}");
    assert!(result.message.contains("predicted"), "{}", result.message);
    let feedback: Vec<RunJobFeedback> = feedback.try_iter().collect();
    let phases: Vec<&str> = feedback.iter().map(|feedback| feedback.phase_name.as_str()).collect();
    for phase in ["home", "index", "cut", "retract"] {
        assert!(phases.contains(&phase), "{phase} is not in {phases:?}");
    }
    assert!(feedback.iter().any(|feedback| feedback.lobe == "A" && feedback.stock > 0.0));
    let complete = cell.client.status("is complete", |status| status.state == JobStatus::COMPLETE);
    assert_eq!(complete.plan_hash, result.plan_hash);
    assert!(complete.job_source.contains("per_block_um: 0.05"), "overrides are written in: {}", complete.job_source);
    // As text: a value that was not measured is NaN, which equals nothing.
    assert_eq!(format!("{:?}", complete.lobes), format!("{:?}", result.lobes));

    // The same again, from the loaded plan, without a word more. Two runs of one plan give one part: C has a shorter way to its origin
    // now, so the noise of the encoders meets the cut elsewhere, and a count of X, 10 nm, is what that may come to.
    let load = LoadJobRequest { job: "eccentric".into(), overrides: SHORT.map(String::from).into() };
    let loaded = cell.client.call::<LoadJob>("job_planner/load_job", &load);
    assert!(loaded.success, "{}", loaded.message);
    assert_eq!(loaded.plan_hash, result.plan_hash);
    let (again, _) = cell.client.send("", &[]);
    assert!(again.accepted());
    let (status, second) = again.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", second.message);
    let error = (second.lobes[0].form_error_max - lobe.form_error_max).abs();
    assert!(error < 1e-8, "{error} m between two parts");
    cell.stop();
}

#[test]
fn a_cancelled_job_comes_to_rest_and_the_next_one_runs() {
    let cell = Cell::start(&[]);
    let (goal, feedback) = cell.client.send("eccentric", &SHORT);
    assert!(goal.accepted());
    loop {
        let feedback = feedback.recv_timeout(PATIENCE).expect("feedback");
        if feedback.phase_name == "cut" {
            break;
        }
    }
    assert_eq!(goal.cancel(PATIENCE).expect("an answer"), CancelOutcome::Accepted);
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Canceled, "{}", result.message);
    let expected = "was cancelled: the axes are at rest and the wheel is retracted";
    assert!(result.message.contains(expected), "{}", result.message);
    cell.client.status("is stopped", |status| status.state == JobStatus::STOPPED);
    let (goal, _) = cell.client.send("eccentric", &SHORT);
    assert!(goal.accepted());
    let stop = cell.client.call::<Trigger>("job_planner/stop", &TriggerRequest::default());
    assert!(stop.success, "{}", stop.message);
    assert_eq!(goal.result(PATIENCE).expect("a result").0, GoalStatus::Canceled);
    let (goal, _) = cell.client.send("eccentric", &SHORT);
    assert!(goal.accepted());
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    cell.stop();
}

#[test]
fn a_wheel_of_another_size_and_a_planner_at_rest_take_no_job() {
    let cell = Cell::start(&[]);
    let words = "wheel_radius_mm is 15, the wheel mounted on cam_grinder has 60";
    let (goal, _) = cell.client.send("eccentric", &[]);
    assert!(!goal.accepted());
    let status = cell.client.status(words, |status| status.message.contains(words));
    assert_eq!(status.state, JobStatus::IDLE);
    let request = ValidateJobRequest { job: "eccentric".into(), overrides: Vec::new() };
    let validated = cell.client.call::<ValidateJob>("job_planner/validate_job", &request);
    assert!(!validated.success && validated.message.contains(words), "{}", validated.message);
    cell.planner.lifecycle().trigger(Transition::Deactivate).expect("inactive");
    let (goal, _) = cell.client.send("eccentric", &SHORT);
    assert!(!goal.accepted());
    assert!(!cell.client.has_moved());
    cell.stop();
}

/// On an ideal machine the ground form is the design's within 1 µm, on an ordinary one it is honestly worse.
#[test]
fn an_ideal_machine_grinds_four_lobes_within_a_micrometre() {
    let ideal: Vec<String> = ["c_axis", "x_axis"]
        .iter()
        .flat_map(|axis| {
            ["velocity_feed_forward=1.0", "acceleration_feed_forward=1.0", "velocity_loop_hz=null"]
                .map(|setting| format!("{axis}.drive.{setting}"))
        })
        .chain(["contact=null".to_owned()])
        .collect();
    let ideal: Vec<&str> = ideal.iter().map(String::as_str).collect();
    let worst = |machine: &[&str]| {
        let cell = Cell::start(machine);
        let (goal, _) = cell.client.send("four_lobe_camshaft", &[]);
        assert!(goal.accepted());
        let (status, result) = goal.result(PATIENCE).expect("a result");
        assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
        assert_eq!(result.lobes.len(), 4);
        cell.stop();
        result.lobes.iter().map(|lobe| lobe.form_error_max.abs()).fold(0.0, f64::max)
    };
    let (ideal, ordinary) = (worst(&ideal), worst(&[]));
    assert!(ideal < 1e-6, "{ideal} m");
    assert!(ordinary > ideal, "{ordinary} m");
}

/// C turns on: every lobe after the first is met at the predicted phase, and the log says so.
#[test]
fn c_that_turns_on_arrives_at_every_lobe_as_predicted() {
    let cell = Cell::start(&[]);
    let settings = [
        "c_between_lobes=turns_on",
        "infeed.per_block_um=0.05",
        "speed.law=constant_removal_rate",
        "speed.removal_rate_mm2_s=10",
    ];
    let (goal, feedback) = cell.client.send("four_lobe_camshaft", &settings);
    assert!(goal.accepted(), "{:?}", cell.client.statuses.try_iter().last());
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    assert!(result.message.contains("with C stopping between lobes"), "{}", result.message);
    let prepared = planning::prepare("four_lobe_camshaft", &settings.map(String::from), None).expect("the same plan");
    assert_eq!(prepared.plan_hash(), result.plan_hash);
    assert!(prepared.planned.saved_by_turning_on_s().expect("C turns on") > 1.0);
    let times = planning::compare_times(&prepared, &result.lobes, result.duration);
    for lobe in ["E1", "I2", "E2"] {
        let time = times.iter().find(|time| time.what == lobe).expect("a lobe");
        assert!(time.late_s().abs() < 0.01, "{time}");
    }
    for lobe in &result.lobes {
        assert!(lobe.form_error_max.abs() < 5e-6, "{}: {} m", lobe.name, lobe.form_error_max);
    }
    // Approach and retract are parts of a cut now.
    let phases: Vec<String> = feedback.try_iter().map(|feedback| feedback.phase_name).collect();
    assert!(
        phases.iter().any(|phase| phase == "approach") && phases.iter().any(|phase| phase == "retract"),
        "{phases:?}"
    );
    cell.stop();
}

/// A goal's overrides beat parameters, which beat the file; a parameter that is unset leaves the file's value.
#[test]
fn settings_come_from_the_goal_then_the_parameters_then_the_file() {
    let cell = Cell::start(&[]);
    let duration = |overrides: &[&str]| {
        let overrides = overrides.iter().map(ToString::to_string).collect();
        let request =
            PreviewJobRequest { job: "four_lobe_camshaft".into(), overrides, points: 90, ..Default::default() };
        let preview = cell.client.call::<PreviewJob>("job_planner/preview_job", &request);
        assert!(preview.success, "{}", preview.message);
        assert_eq!((preview.contour_radius.len(), preview.turn.points.len()), (90, 90));
        assert!((preview.contour_radius[0] - 0.016).abs() < 1e-6, "the base circle of I1");
        preview.duration
    };
    let file = duration(&[]);
    let node = cell.planner.node();
    let set = |value: ParameterValue| node.parameters().set("work_speed_rpm", value);
    set(ParameterValue::Double(30.0)).expect("a setting");
    let slower = duration(&[]);
    assert!((slower - file - 56.0).abs() < 1.0, "56 turns take a second longer each: {file} s, {slower} s");
    let goal = duration(&["work_speed_rpm=60.0"]);
    assert!((goal - file).abs() < 1e-9, "{goal} {file}");
    set(ParameterValue::NotSet).expect("unset");
    assert!((duration(&[]) - file).abs() < 1e-9);
    assert!(set(ParameterValue::Double(f64::NAN)).is_err());
    let jobs = cell.client.call::<ListJobs>("job_planner/list_jobs", &ListJobsRequest::default());
    assert!(jobs.jobs.iter().any(|job| job == "four_lobe_camshaft"), "{:?}", jobs.jobs);
    cell.stop();
}

/// The digital switches DS0 … DS7 of JPS6156064B2 as parameters: the plan is that of the same settings in the file.
#[test]
fn every_switch_of_the_patent_is_a_parameter() {
    let cell = Cell::start(&[]);
    let node = cell.planner.node();
    let number = ParameterValue::Double;
    let switches = [
        ("rapid_advance_mm", number(45.0), "rapid_advance_mm=45.0"),
        ("rapid_speed_mm_s", number(80.0), "rapid_speed_mm_s=80.0"),
        ("infeed.total_mm", number(0.432), "infeed.total_mm=0.432"),
        ("infeed.per_block_um", number(0.02), "infeed.per_block_um=0.02"),
        ("infeed.spark_out_turns", ParameterValue::Integer(5), "infeed.spark_out_turns=5"),
        ("work_speed_rpm", number(50.0), "work_speed_rpm=50.0"),
        ("rotary_indexing", ParameterValue::Bool(true), "rotary_indexing=true"),
    ];
    let phases = [15.0, 100.0, 250.0, 359.9];
    let loaded = || {
        let load = LoadJobRequest { job: "four_lobe_camshaft".into(), overrides: Vec::new() };
        let loaded = cell.client.call::<LoadJob>("job_planner/load_job", &load);
        assert!(loaded.success, "{}", loaded.message);
        loaded.plan_hash
    };
    let mut before = loaded();
    let mut file: Vec<String> = Vec::new();
    let mut is_as_in_the_file = |name: &str, keys: Vec<String>| {
        file.extend(keys);
        let now = loaded();
        assert_ne!(now, before, "{name} changes the plan");
        let written = planning::prepare("four_lobe_camshaft", &file, None).expect("it can be made");
        assert_eq!(now, written.plan_hash(), "{name}");
        before = now;
    };
    for (name, value, key) in switches {
        node.parameters().set(name, value).expect("a setting");
        is_as_in_the_file(name, vec![key.to_owned()]);
    }
    node.parameters().set("phases_deg", ParameterValue::DoubleArray(phases.into())).expect("a setting");
    let lobes = phases.iter().enumerate().map(|(lobe, phase)| format!("lobes.{lobe}.phase_deg={phase:?}")).collect();
    is_as_in_the_file("phases_deg", lobes);
    cell.stop();
}

/// With `use_sim_time` the times of the cell's states are those of the machine, however fast it runs. A repeated message keeps the time of
/// its change, and its times go on.
#[test]
fn the_times_of_the_cell_are_ros_time() {
    let cell = Cell::start_with(&[], |args| {
        args.with_parameter(Some("job_planner"), "use_sim_time", ParameterValue::Bool(true))
    });
    let (sender, states) = mpsc::channel();
    let on_message = move |state: CellState, _: &_| drop(sender.send(state));
    let qos = Qos::latched(1).keep_last(1000);
    let _states = cell.client.node.subscribe("job_planner/cell_state", &qos, on_message).expect("a subscription");
    let next = || states.recv_timeout(PATIENCE).expect("the state of the cell, once a second");
    let (goal, _) = cell.client.send("eccentric", &SHORT);
    assert!(goal.accepted());
    let begun = Instant::now();
    let (status, result) = goal.result(PATIENCE).expect("a result");
    let real_s = begun.elapsed().as_secs_f64();
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    let mut end = next();
    while end.state != CellState::COMPLETE {
        end = next();
    }
    let executed_s = end.accumulated[usize::from(CellState::EXECUTE)];
    println!("{executed_s:.2} s in EXECUTE, {:.2} s of machine time, {real_s:.2} s of this computer", result.duration);
    let bounds = 0.95 * result.duration..1.1 * result.duration + 2.0;
    assert!(bounds.contains(&executed_s), "{executed_s} s in EXECUTE, {} s of machine time", result.duration);
    let all: f64 = end.accumulated[1..].iter().sum();
    assert!((all - end.accumulated[0]).abs() < 1e-6, "{:?}", end.accumulated);

    let ns = |stamp: &Time| i64::from(stamp.sec) * 1_000_000_000 + i64::from(stamp.nanosec);
    let mut first = next();
    // The parts of the job are counted after its end: a change, too.
    loop {
        let repeated = next();
        let plain = |state: &CellState| CellState {
            stamp: Time::default(),
            time_in_state: 0.0,
            accumulated: [0.0; 18],
            ..state.clone()
        };
        if plain(&repeated) != plain(&first) {
            assert!(ns(&repeated.stamp) >= ns(&first.stamp), "{repeated:?} after {first:?}");
            first = repeated;
            continue;
        }
        assert_eq!(repeated.stamp, first.stamp, "the time of the change");
        assert!(repeated.time_in_state >= first.time_in_state, "{} s", repeated.time_in_state);
        break;
    }
    let reset = CellCommandRequest { command: CellCommandRequest::RESET, ..CellCommandRequest::default() };
    let answer = cell.client.call::<CellCommand>("job_planner/cell_command", &reset);
    assert!(answer.success, "{}", answer.message);
    let mut idle = next();
    while idle.state != CellState::IDLE {
        idle = next();
    }
    assert!(ns(&idle.stamp) > ns(&first.stamp), "{idle:?} after {first:?}");
    cell.stop();
}

/// The list of jobs is answered while the planning thread works on a validation.
#[test]
fn the_list_of_jobs_does_not_wait_for_validations() {
    let cell = Cell::start(&[]);
    let client = cell.client.node.client::<ValidateJob>("job_planner/validate_job").expect("a client");
    client.wait_for_service(PATIENCE).expect("the service");
    let lister = cell.client.node.client::<ListJobs>("job_planner/list_jobs").expect("a client");
    lister.wait_for_service(PATIENCE).expect("the service");
    let (sender, answers) = mpsc::channel();
    let (begun, overrides) = (Instant::now(), vec!["infeed.spark_out_turns=900".to_owned()]);
    let request = ValidateJobRequest { job: "rough_and_finish".into(), overrides };
    let answered = move |answer: ValidateJobResponse| drop(sender.send((answer, Instant::now())));
    // It takes many times as long as a list.
    client.call_with(&request, answered).expect("sent");
    let list = lister.call(&ListJobsRequest::default(), PATIENCE).expect("an answer");
    let listed = Instant::now();
    assert!(list.jobs.iter().any(|job| job == "four_lobe_camshaft"), "{:?}", list.jobs);
    let (answer, validated) = answers.recv_timeout(PATIENCE).expect("an answer");
    assert!(answer.success, "{}", answer.message);
    println!("listed {:?}, validated {:?} after the request", listed - begun, validated - begun);
    assert!(listed < validated, "the list came {:?} after the validation", listed - validated);
    cell.stop();
}
