// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Set-up work over DDS: jog, find the part's phase and grind by it, touch off, dress, dry run; and what is refused, with its reason.

use crate::cell;
use crate::watched;

use camwright_msgs::Action;
use camwright_msgs::camwright_msgs::action::{
    Jog, JogFeedback, JogGoal, JogResult, MoveTo, MoveToGoal, MoveToResult, Probe, ProbeGoal, RunJobGoal, RunJobResult,
};
use camwright_msgs::camwright_msgs::msg::{Alarm, MachineDescription};
use camwright_msgs::camwright_msgs::srv::{
    ChangeWheel, ChangeWheelRequest, Dress, DressRequest, FindPhase, FindPhaseRequest, LoadJob, LoadJobRequest,
    TouchOff, TouchOffRequest,
};
use camwright_msgs::std_msgs::msg::Empty;
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest};
use camwright_ros::{GoalStatus, Qos};
use cell::{Cell, PATIENCE};
use watched::{LogLines, Watched};

const MACHINE: [&str; 3] = [
    "gap_detector={holds_ms: 20}",
    "key_way_probe={at_deg: 140, width_deg: 16}",
    "dresser={x_mm: 60, z_mm: 480, width_mm: 2, infeed_speed_mm_s: 2, traverse_speed_mm_s: 10, dwell_s: 0.2, max_depth_um: 50}",
];

fn move_to(cell: &Cell, goal: MoveToGoal) -> (GoalStatus, MoveToResult) {
    let client = cell.client.node.action_client::<MoveTo>("axis_interpolator/move_to").expect("a client");
    client.wait_for_server(PATIENCE).expect("move_to");
    let sent = client.send_goal(goal, drop, PATIENCE).expect("a decision");
    assert!(sent.accepted(), "the log has the reason");
    sent.result(PATIENCE).expect("a result")
}

/// Sends a goal that can be judged without a motion: it is rejected, and the log has the reason.
fn is_rejected<A: Action>(cell: &Cell, log: &LogLines, action: &str, goal: A::Goal, words: &str) {
    let client = cell.client.node.action_client::<A>(action).expect("a client");
    client.wait_for_server(PATIENCE).expect("the action");
    assert!(!client.send_goal(goal, drop, PATIENCE).expect("a decision").accepted(), "{words}");
    log.line(&[&format!("{action} rejected: "), words]);
}

fn load(cell: &Cell, overrides: &[&str]) {
    let overrides = overrides.iter().map(ToString::to_string).collect();
    let loaded =
        cell.client.call::<LoadJob>("job_planner/load_job", &LoadJobRequest { job: "eccentric".into(), overrides });
    assert!(loaded.success, "{}", loaded.message);
}

fn run(cell: &Cell, start_lobe: &str, overrides: &[&str]) -> (GoalStatus, RunJobResult) {
    let overrides = overrides.iter().map(ToString::to_string).collect();
    let goal = RunJobGoal { start_lobe: start_lobe.into(), overrides, ..RunJobGoal::default() };
    let job = cell.client.action.send_goal(goal, drop, PATIENCE).expect("a decision");
    assert!(job.accepted(), "see the log of job_planner");
    job.result(PATIENCE).expect("a result")
}

#[test]
fn a_machine_is_set_up_over_ros() {
    let cell = Cell::start(&MACHINE);
    let to = |joint: &str, position: f64, relative| MoveToGoal {
        joints: vec![joint.into()],
        positions: vec![position],
        relative,
        ..MoveToGoal::default()
    };
    // Jog, and what is refused.
    let (status, moved) = move_to(&cell, to("z_axis", 0.05, false));
    assert_eq!(status, GoalStatus::Succeeded, "{}", moved.message);
    let (_, moved) = move_to(&cell, to("z_axis", -0.012_5, true));
    assert!((moved.positions[2] - 0.037_5).abs() < 1e-12 && moved.joints[2] == "z_axis", "{moved:?}");
    let log = LogLines::subscribe(&cell);
    for (goal, words) in [
        (to("x_axis", 0.2, false), "the target of x_axis is 200.0000 mm, the soft limit is 180 mm"),
        (to("y_axis", 1.0, false), "there is no joint \"y_axis\""),
        (MoveToGoal { positions: Vec::new(), ..to("z_axis", 0.0, false) }, "1 joints and 0 positions"),
    ] {
        is_rejected::<MoveTo>(&cell, &log, "axis_interpolator/move_to", goal, words);
    }
    // The engine decides whether a zero is known, at the start of the motion.
    let (status, refused) = move_to(&cell, to("c_axis", 1.0, false));
    assert_eq!((status, refused.alarm), (GoalStatus::Aborted, Alarm::NONE));
    assert!(refused.message.contains("c_axis is not homed"), "{}", refused.message);
    let client = cell.client.node.action_client::<Probe>("axis_interpolator/probe").expect("a client");
    client.wait_for_server(PATIENCE).expect("probe");
    let probe = |goal: ProbeGoal| {
        client.send_goal(goal, drop, PATIENCE).expect("a decision").result(PATIENCE).expect("a result")
    };
    let of = |joint: &str, input: &str, target| ProbeGoal {
        joint: joint.into(),
        input: input.into(),
        target,
        ..ProbeGoal::default()
    };
    let (status, found) = probe(of("z_axis", "LS1", 0.1));
    assert_eq!(status, GoalStatus::Succeeded, "{}", found.message);
    assert!((found.position - 0.08).abs() < 2e-6, "the switch stands at 80 mm: {}", found.position);
    let (action, other_axis) = ("axis_interpolator/probe", "origin catches the position of c_axis, not of z_axis");
    is_rejected::<Probe>(&cell, &log, action, of("z_axis", "origin", 0.0), other_axis);
    is_rejected::<Probe>(&cell, &log, action, of("z_axis", "LS9", 0.0), "there is no input \"LS9\"");

    // A part that is clamped 3 degrees askew is ground by the phase that is found.
    let short = ["wheel_radius_mm=60", "infeed.per_block_um=0.02", "raw_part.clamped_at_deg=3"];
    load(&cell, &short);
    let found = cell.client.call::<FindPhase>(
        "job_planner/find_phase",
        &FindPhaseRequest { load_part: true, ..FindPhaseRequest::default() },
    );
    assert!(found.success, "{}", found.message);
    assert!((found.phase.to_degrees() - 3.0).abs() < 1e-3, "{}", found.message);
    assert!((found.width.to_degrees() - 16.0).abs() < 1e-3, "{}", found.message);
    let (status, result) = run(&cell, "1", &[]);
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    // Fed fast and hardly sparked out it is off by 12 um; ground where its keyway should be it would be off by 220 um.
    assert!(result.lobes[0].form_error_max.abs() < 2e-5, "{} m", result.lobes[0].form_error_max);

    // A dry run leaves the part, and judges nothing.
    let (status, result) = run(&cell, "", &["dry_run.stand_off_mm=8"]);
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    assert!(result.message.starts_with("dry run in ") && result.lobes.is_empty(), "{}", result.message);

    // Touch off on a round blank: 20.3 mm, and a wheel that was dressed as warm as it is.
    let round = ["profiles.0.lift={round: true}", "profiles.0.base_radius_mm=20", "profiles.0.follower={kind: knife}"];
    load(&cell, &[&["wheel_radius_mm=60"], &round[..]].concat());
    let load_part = FindPhaseRequest { load_part: true, ..FindPhaseRequest::default() };
    let found = cell.client.call::<FindPhase>("job_planner/find_phase", &load_part);
    assert!(found.success && found.phase.abs() < 1e-4, "another part, another phase: {}", found.message);
    let lobe = TouchOffRequest { lobe: "A".into(), ..TouchOffRequest::default() };
    let touched = cell.client.call::<TouchOff>("job_planner/touch_off", &lobe);
    assert!(touched.success, "{}", touched.message);
    assert!((touched.radius - 0.0203).abs() < 1e-9 && touched.off.abs() < 2e-6, "{touched:?}");
    assert!((touched.correction - touched.off).abs() < 1e-9, "{touched:?}");
    let nowhere = cell.client.call::<TouchOff>("job_planner/touch_off", &TouchOffRequest::default());
    assert!(!nowhere.success && nowhere.message.contains("station and radius"), "{}", nowhere.message);

    // Dress now, and not more than the dresser may take.
    let dressed = cell.client.call::<Dress>("job_planner/dress", &DressRequest { depth: 1e-5 });
    assert!(dressed.success && (dressed.radius - 0.05999).abs() < 1e-6, "{}", dressed.message);
    let refused = cell.client.call::<Dress>("job_planner/dress", &DressRequest { depth: 1e-4 });
    assert!(!refused.success && refused.message.contains("the dresser is allowed 50.000 um"), "{}", refused.message);
    cell.stop();
}

fn jog(cell: &Cell, goal: JogGoal, feedback: impl FnMut(JogFeedback) + Send + 'static) -> (GoalStatus, JogResult) {
    let client = cell.client.node.action_client::<Jog>("axis_interpolator/jog").expect("a client");
    client.wait_for_server(PATIENCE).expect("jog");
    let sent = client.send_goal(goal, feedback, PATIENCE).expect("a decision");
    assert!(sent.accepted(), "the log has the reason");
    sent.result(PATIENCE).expect("a result")
}

#[test]
fn an_axis_is_jogged_while_it_is_held_and_the_wheel_is_started_by_hand() {
    let cell = Cell::start_realtime(&["wheel.spin_up_s=0.2"]);
    let of =
        |joint: &str, velocity, distance| JogGoal { joint: joint.into(), velocity, distance, ..JogGoal::default() };
    let (status, done) = jog(&cell, of("z_axis", 0.02, 0.003), drop);
    assert_eq!((status, done.message.as_str()), (GoalStatus::Succeeded, "it has gone its distance"));
    let from = done.position;

    // Held for 10 mm, then let go of: it rests after the time that it may go on unheld, the feedback delay and its stop.
    let hold = cell.client.node.publisher::<Empty>("axis_interpolator/hold_to_run", &Qos::default_topic());
    let hold = hold.expect("a publisher");
    assert!(hold.wait_matched(1, PATIENCE));
    let held = move |feedback: JogFeedback| {
        if feedback.position < from + 0.01 {
            hold.publish(&Empty::default()).expect("published");
        }
    };
    let goal = JogGoal { hold_to_run: 1.0, ..of("z_axis", 0.02, 0.0) };
    let (status, done) = jog(&cell, goal, held);
    let ended = (status, done.message.as_str());
    assert_eq!(ended, (GoalStatus::Succeeded, "it was let go of, and rests"));
    let way = done.position - from;
    // Of 20 mm/s: one second, two periods of feedback, a delay of half a second, and its stop; what a busy machine adds is not more than as
    // much again.
    assert!(way > 0.01 + 0.018 && way < 0.01 + 0.07, "{way} m");

    let log = LogLines::subscribe(&cell);
    for (goal, words) in [
        (of("y_axis", 0.01, 0.001), "there is no joint \"y_axis\""),
        (of("z_axis", 9.0, 0.001), "z_axis cannot move at 9000.000 mm/s; the speed must be above 0 and at most "),
        (of("z_axis", 0.01, 9.0), "the target of z_axis is "),
        (
            JogGoal { hold_to_run: 60.0, ..of("z_axis", 0.01, 0.0) },
            "hold_to_run is 60 s; it must be above 0 and at most 2 s",
        ),
        (
            JogGoal { hold_to_run: JogGoal::UNTIL_CANCEL, ..of("z_axis", 0.01, 0.0) },
            "z_axis does not move without being held",
        ),
        (of("c_axis", 10.0, 1.0), "the zero of c_axis is unknown, so its maximum speed is its search speed "),
    ] {
        is_rejected::<Jog>(&cell, &log, "axis_interpolator/jog", goal, words);
    }

    // The part spindle turns until it is cancelled; other clients have no command meanwhile, and their refusal names the holder.
    let client = cell.client.node.action_client::<Jog>("axis_interpolator/jog").expect("a client");
    client.wait_for_server(PATIENCE).expect("jog");
    let (sender, feedback) = std::sync::mpsc::channel();
    let on_feedback = move |feedback| drop(sender.send(feedback));
    let goal = JogGoal { hold_to_run: JogGoal::UNTIL_CANCEL, ..of("c_axis", 0.5, 0.0) };
    let turning = client.send_goal(goal, on_feedback, PATIENCE).expect("a decision");
    while feedback.recv_timeout(PATIENCE).expect("feedback with its speed").velocity < 0.49 {}
    let wheel = |data| cell.client.call::<SetBool>("axis_interpolator/wheel", &SetBoolRequest { data });
    let refused = wheel(true);
    assert_eq!((refused.success, refused.message.as_str()), (false, "a jog of c_axis by /operator has command"));
    let _answer = turning.cancel(PATIENCE).expect("an answer");
    assert_eq!(turning.result(PATIENCE).expect("a result").0, GoalStatus::Canceled);

    for (on, words) in [(true, "the wheel has its speed"), (false, "the wheel rests")] {
        let done = wheel(on);
        assert_eq!((done.success, done.message.as_str()), (true, words));
    }
    cell.stop();
}

const CHANGER: [&str; 2] = [
    "wheel.name=roughing",
    "wheel_changer={change_s: 0.8, min_x_mm: 140, wheels: [{name: finishing, new_radius_mm: 15, min_radius_mm: 12, \
     width_mm: 20, surface_speed_m_s: 60, spin_up_s: 0.5}]}",
];

/// The wheel is changed over ROS, back and forth, and the machine describes what is mounted.
#[test]
fn a_wheel_is_changed_over_ros() {
    let cell = Cell::start(&CHANGER);
    let described = Watched::<MachineDescription>::new(&cell, "machine/description", &Qos::latched(1));
    let first = described.until("a description", |_| true);
    assert_eq!((first.wheel.as_str(), first.wheels.len(), first.wheel_width), ("roughing", 2, 0.025));
    let change = |wheel: &str| {
        let request = ChangeWheelRequest { wheel: wheel.into() };
        cell.client.call::<ChangeWheel>("job_planner/change_wheel", &request)
    };
    for (wheel, radius, width) in [("finishing", 0.015, 0.02), ("roughing", 0.06, 0.025)] {
        let changed = change(wheel);
        assert!(changed.success && (changed.radius - radius).abs() < 1e-12, "{changed:?}");
        let now = described.until("the new wheel", |message| message.wheel == wheel);
        assert_eq!((now.wheel_radius, now.wheel_width), (changed.radius, width));
        let mounted: Vec<_> =
            now.wheels.iter().filter(|wheel| wheel.mounted).map(|wheel| wheel.name.as_str()).collect();
        assert_eq!(mounted, [wheel]);
        let again = change(wheel);
        assert!(!again.success && again.message == format!("wheel {wheel} is mounted already"), "{}", again.message);
    }
    let unknown = change("polishing");
    assert!(!unknown.success && unknown.message.contains("has roughing, finishing"), "{}", unknown.message);
    // The job asks for a wheel of 15 mm: it is planned for the wheel that is mounted, and refused with the other one.
    let request = LoadJobRequest { job: "eccentric".into(), overrides: Vec::new() };
    let refused = cell.client.call::<LoadJob>("job_planner/load_job", &request);
    assert!(
        !refused.success && refused.message.contains("the wheel mounted on cam_grinder has 60.0000"),
        "{refused:?}"
    );
    assert!(change("finishing").success);
    load(&cell, &[]);
    let (status, result) = run(&cell, "", &[]);
    assert_eq!((status, result.alarm), (GoalStatus::Succeeded, 0), "{}", result.message);
    cell.stop();
}

#[test]
fn a_machine_with_one_wheel_changes_none() {
    let cell = Cell::start(&[]);
    let request = ChangeWheelRequest { wheel: "finishing".into() };
    let refused = cell.client.call::<ChangeWheel>("job_planner/change_wheel", &request);
    assert!(!refused.success && refused.message.contains("has no wheel_changer"), "{}", refused.message);
    cell.stop();
}
