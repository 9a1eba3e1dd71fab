// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Faults of the running cell: each ends the job with its alarm, latched until a reset, and a job goes on where it was stopped.

use crate::cell;

use camwright::machine::alarm::AlarmKind;
use camwright::motion::plan::SegmentKind;
use camwright_files::convert::mm_from_m;
use camwright_msgs::camwright_msgs::action::{Home, HomeGoal, RunJobFeedback, RunJobGoal};
use camwright_msgs::camwright_msgs::msg::{JobStatus, MachineAlarms};
use camwright_msgs::camwright_msgs::srv::{InjectFault, InjectFaultRequest};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest};
use camwright_planning::{PreparedJob, lobe_result, prepare};
use camwright_ros::{GoalStatus, Qos};
use cell::{Cell, PATIENCE};
use std::sync::mpsc;
use std::time::{Duration, Instant};

const GAUGE: &str = "gauge={kind: diameter, behind_wheel_deg: 90, resolution_um: 0.1, noise_um: 0.2}";
const SHORT: [&str; 2] = ["infeed.total_mm=0.072", "stock_mm=0.06"];
const ONE_LOBE: [&str; 3] = ["wheel_radius_mm=60.0", "infeed.per_block_um=0.05", "infeed.spark_out_turns=6"];

/// Tick of the job some seconds into the first cut of a lobe, as it is predicted.
fn in_the_cut(prepared: &PreparedJob, lobe: usize, seconds: u64) -> u64 {
    let segments = &prepared.planned.plan.segments;
    let cut = |kind: &SegmentKind| matches!(kind, SegmentKind::Cut(_));
    let before = segments.iter().take_while(|segment| !(segment.lobe == Some(lobe) && cut(&segment.kind)));
    before.map(|segment| segment.ticks).sum::<u64>() + 1000 * seconds
}

fn planned(job: &str, set: &[&str]) -> PreparedJob {
    let set: Vec<String> = set.iter().map(ToString::to_string).collect();
    prepare(job, &set, None).expect("a job")
}

/// Resets as soon as the axes rest.
fn reset(cell: &Cell) {
    let end = Instant::now() + PATIENCE;
    loop {
        let answer = cell.client.call::<Trigger>("machine/reset", &TriggerRequest::default());
        if answer.success {
            return;
        }
        assert!(Instant::now() < end, "{}", answer.message);
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// A reset behind the answer of the emergency stop finds it pressed or released, as it was ordered.
#[test]
fn an_answered_emergency_stop_is_applied() {
    let cell = Cell::start(&[]);
    let estop = |data: bool| assert!(cell.client.call::<SetBool>("machine/estop", &SetBoolRequest { data }).success);
    let reset = || cell.client.call::<Trigger>("machine/reset", &TriggerRequest::default());
    for round in 0..30 {
        estop(true);
        let refused = reset();
        assert!(!refused.success && refused.message.contains("emergency stop is pressed"), "{round}: {refused:?}");
        estop(false);
        let answer = reset();
        assert!(answer.success, "{round}: {answer:?}");
    }
    cell.stop();
}

#[test]
fn every_fault_ends_the_job_with_its_alarm_until_a_reset() {
    let cell = Cell::start(&[GAUGE]);
    let (sender, alarms) = mpsc::channel::<MachineAlarms>();
    let _alarms = cell.client.node.subscribe("machine/alarms", &Qos::latched(1).keep_last(50), move |message, _| {
        drop(sender.send(message));
    });
    let job_tick = in_the_cut(&planned("eccentric", &ONE_LOBE), 0, 3);
    for (fault, target, value, alarm) in [
        ("estop", "", 1.0, 1),
        ("power_loss", "", 1.0, 2),
        ("drive_gain", "x_axis", 0.0, 32),
        ("drive_fault", "c_axis", 1.0, 41),
        ("encoder_offset", "x_axis", 0.000_5, 45),
        ("lost_chunks", "", 1.0, 85),
        ("stuck_input", "origin", 0.0, 92),
        ("wheel_stall", "", 1.0, 100),
        ("wheel_overspeed", "", 1.3, 107),
        ("gauge_nan", "", 1.0, 140),
    ] {
        let inject = |active: bool, job_tick: u64| {
            let request = InjectFaultRequest { fault: fault.into(), target: target.into(), value, active, job_tick };
            let answer = cell.client.call::<InjectFault>("machine/inject_fault", &request);
            assert!(answer.success, "{fault}: {}", answer.message);
        };
        inject(true, job_tick);
        let (goal, _feedback) = cell.client.send("eccentric", &ONE_LOBE);
        assert!(goal.accepted(), "{fault}");
        let (status, result) = goal.result(PATIENCE).expect("a result");
        assert_eq!((status, result.alarm), (GoalStatus::Aborted, alarm), "{fault}: {}", result.message);
        let active = |message: &MachineAlarms| message.alarms.iter().any(|active| active.number == alarm);
        while !active(&alarms.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("{fault}: no alarm {alarm}"))) {}
        // No job before the reset, and none by it.
        let (refused, _feedback) = cell.client.send("eccentric", &ONE_LOBE);
        assert!(!refused.accepted(), "{fault}: a job before the reset");
        inject(false, 0);
        // A reading that is cured after the reset would be another jump: a tick at rest is 10 ms.
        std::thread::sleep(Duration::from_millis(200));
        reset(&cell);
        while !alarms.recv_timeout(PATIENCE).expect("news of the reset").alarms.is_empty() {}
    }
    cell.stop();
}

/// A drive trips in the second lobe; after reset and homing the job goes on with that lobe, on the part as it is.
#[test]
fn a_job_goes_on_at_the_lobe_where_a_fault_stopped_it() {
    let cell = Cell::start(&[]);
    let prepared = planned("four_lobe_camshaft", &SHORT);
    let fault = format!("faults=[{{kind: drive_fault, target: x_axis, at_tick: {}}}]", in_the_cut(&prepared, 1, 2));
    let (goal, _feedback) = cell.client.send("four_lobe_camshaft", &[SHORT[0], SHORT[1], &fault]);
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!((status, result.alarm), (GoalStatus::Aborted, 42), "{}", result.message);
    // The result has the lobe that was finished, and the alarm in words with its remedy.
    let finished: Vec<&str> = result.lobes.iter().map(|lobe| lobe.name.as_str()).collect();
    assert_eq!(finished, ["I1"], "{}", result.message);
    assert!(result.lobes[0].form_error_max.abs() < result.lobes[0].form_error_allowed, "{:?}", result.lobes[0]);
    assert!(result.lobes[0].turns > 0.0 && result.lobes[0].duration > 0.0, "{:?}", result.lobes[0]);
    let entry = AlarmKind::from_number(42).expect("a known alarm").entry();
    for words in [entry.remedy, "finished: 1 of 4 lobes (I1)"] {
        assert!(result.message.contains(words), "{words}: {}", result.message);
    }
    let ended = cell.client.status("is aborted", |status| status.state == JobStatus::ABORTED);
    assert_eq!(ended.message, result.message);
    // As text: a value that was not measured is NaN, which equals nothing.
    assert_eq!(format!("{:?}", ended.lobes), format!("{:?}", result.lobes));
    let cure =
        InjectFaultRequest { fault: "drive_fault".into(), target: "x_axis".into(), ..InjectFaultRequest::default() };
    assert!(cell.client.call::<InjectFault>("machine/inject_fault", &cure).success);
    reset(&cell);
    let home = cell.client.node.action_client::<Home>("axis_interpolator/home").expect("a client");
    home.wait_for_server(PATIENCE).expect("home");
    let homing = home.send_goal(HomeGoal::default(), drop, PATIENCE).expect("a decision");
    assert!(homing.accepted());
    let (status, homed) = homing.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", homed.message);

    let wanted = RunJobGoal {
        job: "four_lobe_camshaft".into(),
        overrides: SHORT.map(str::to_owned).into(),
        start_lobe: "2".into(),
    };
    let goal = cell.client.action.send_goal(wanted, drop, PATIENCE).expect("a decision");
    assert!(goal.accepted());
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    let ground: Vec<&str> = result.lobes.iter().map(|lobe| lobe.name.as_str()).collect();
    assert_eq!(ground, ["E1", "I2", "E2"], "those of this run");
    let mut errors: Vec<f64> = result.lobes.iter().map(|lobe| mm_from_m(lobe.form_error_max)).collect();
    // The first lobe is as the first run left it.
    let parts = cell.client.parts.lock().expect("not poisoned");
    let first = parts.iter().rev().find(|lobe| lobe.name == "I1").expect("it is on the part");
    let first = lobe_result(&prepared.planned.lobes[0].design, first).expect("an outline");
    errors.push(mm_from_m(first.form_error_max));
    drop(parts);
    assert!(errors.iter().all(|error| error.abs() < 0.005), "{errors:?}");
    cell.stop();
}

/// A job that is cancelled in its second lobe returns the first one with its form.
#[test]
fn a_cancelled_job_returns_its_finished_lobes() {
    let cell = Cell::start(&[]);
    let (goal, feedback) = cell.client.send("four_lobe_camshaft", &SHORT);
    assert!(goal.accepted());
    let in_second = |feedback: &RunJobFeedback| feedback.lobe_index == 1 && feedback.turn > 0.2;
    while !in_second(&feedback.recv_timeout(PATIENCE).expect("the job goes on")) {}
    goal.cancel(PATIENCE).expect("an answer");
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!((status, result.alarm), (GoalStatus::Canceled, 0), "{}", result.message);
    let finished: Vec<&str> = result.lobes.iter().map(|lobe| lobe.name.as_str()).collect();
    assert_eq!(finished, ["I1"], "{}", result.message);
    assert!(result.lobes[0].form_error_max.abs() < result.lobes[0].form_error_allowed, "{:?}", result.lobes[0]);
    assert!(result.message.ends_with("finished: 1 of 4 lobes (I1)"), "{}", result.message);
    cell.stop();
}
