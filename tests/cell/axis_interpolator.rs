// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The axis interpolator among the nodes it works with: homing, trajectories of other clients, override, hold, who has command, alarms.

use crate::cell;
use crate::watched;

use camwright_msgs::Action;
use camwright_msgs::builtin_interfaces::msg::{Duration as RosDuration, Time};
use camwright_msgs::camwright_msgs::action::{
    ExecutePlan, ExecutePlanGoal, Home, HomeFeedback, HomeGoal, Jog, JogGoal, MoveTo, MoveToGoal, Probe, ProbeGoal,
    RunJob, RunJobGoal,
};
use camwright_msgs::camwright_msgs::msg::{InterpolatorState, MachineAlarms, MachineStream, PlanSegment};
use camwright_msgs::camwright_msgs::srv::{InjectFault, InjectFaultRequest, SetOverride, SetOverrideRequest};
use camwright_msgs::control_msgs::action::{FollowJointTrajectory, FollowJointTrajectoryGoal};
use camwright_msgs::control_msgs::msg::JointTolerance;
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest};
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};
use camwright_ros::{GoalStatus, Node, Publisher, Qos};
use cell::{Cell, PATIENCE};
use std::sync::mpsc;
use std::time::Instant;
use watched::{LogLines, Watched};

/// From rest to rest, one joint to one place in a time.
fn to(joint: &str, position: f64, seconds: i32) -> JointTrajectory {
    let point = JointTrajectoryPoint {
        positions: vec![position],
        velocities: vec![0.0],
        accelerations: vec![0.0],
        time_from_start: RosDuration { sec: seconds, nanosec: 0 },
        ..JointTrajectoryPoint::default()
    };
    JointTrajectory { joint_names: vec![joint.into()], points: vec![point], ..JointTrajectory::default() }
}

fn goal(trajectory: JointTrajectory) -> FollowJointTrajectoryGoal {
    FollowJointTrajectoryGoal { trajectory, ..FollowJointTrajectoryGoal::default() }
}

fn position(joints: &JointState, joint: &str) -> f64 {
    joints.position[joints.name.iter().position(|name| name == joint).expect("a joint of the machine")]
}

#[test]
fn homing_reports_its_steps_and_zeroes_the_headstock_at_its_mark() {
    let cell = Cell::start(&[]);
    let state = Watched::<InterpolatorState>::new(&cell, "axis_interpolator/state", &Qos::latched(1));
    assert!(!state.until("a state", |_| true).is_homed);
    let home = cell.client.node.action_client::<Home>("axis_interpolator/home").expect("a client");
    home.wait_for_server(PATIENCE).expect("home");
    let (sender, feedback) = mpsc::channel();
    let send = move |feedback: HomeFeedback| drop(sender.send((feedback.joint, feedback.step)));
    let homing = home.send_goal(HomeGoal::default(), send, PATIENCE).expect("a decision");
    assert!(homing.accepted());
    let (status, result) = homing.result(PATIENCE).expect("a result");
    assert_eq!((status, result.alarm), (GoalStatus::Succeeded, 0), "{}", result.message);
    state.until("the axes are homed", |state| state.is_homed);
    let steps: Vec<(String, String)> = feedback.try_iter().collect();
    for step in ["search", "return"] {
        assert!(steps.contains(&("c_axis".into(), step.into())), "{step} is not in {steps:?}");
    }
    // It is back at the edge at which the detector saw the mark: within its window of 2 degrees.
    let joints = Watched::<JointState>::new(&cell, "joint_states", &Qos::default_topic());
    joints.until("C stands at its zero", |joints| position(joints, "c_axis").abs() < 2.0_f64.to_radians());
    let wrong = home.send_goal(HomeGoal { joints: vec!["y_axis".into()] }, drop, PATIENCE).expect("a decision");
    assert!(!wrong.accepted(), "there is no y_axis");
    cell.stop();
}

/// A client that wants to move the axes while a job is held is refused with the name of who has command.
#[test]
fn one_client_has_command_and_others_get_its_name() {
    let cell = Cell::start(&[]);
    let state = Watched::<InterpolatorState>::new(&cell, "axis_interpolator/state", &Qos::latched(1));
    let hold = |hold: bool| cell.client.call::<SetBool>("axis_interpolator/feed_hold", &SetBoolRequest { data: hold });
    let idle = hold(true);
    assert!(!idle.success && idle.message == "nothing is being executed", "{}", idle.message);
    let short = ["wheel_radius_mm=60.0", "infeed.per_block_um=0.05", "infeed.spark_out_turns=6"];
    let (job, _) = cell.client.send("eccentric", &short);
    assert!(job.accepted());
    state.until("the cut begins", |state| state.phase == PlanSegment::PHASE_CUT);
    assert!(hold(true).success);
    let held = state.until("the job is held", |state| state.state == InterpolatorState::HELD);
    assert!(held.holder.contains("/job_planner, job eccentric"), "{}", held.holder);

    let node = &cell.client.node;
    let log = LogLines::subscribe(&cell);
    let holder = format!("{} has command", held.holder);
    let home = node.action_client::<Home>("axis_interpolator/home").expect("a client");
    home.wait_for_server(PATIENCE).expect("home");
    assert!(!home.send_goal(HomeGoal::default(), drop, PATIENCE).expect("a decision").accepted());
    log.line(&["axis_interpolator/home rejected", &holder]);
    let execute = node.action_client::<ExecutePlan>("axis_interpolator/execute_plan").expect("a client");
    execute.wait_for_server(PATIENCE).expect("execute_plan");
    let plan = ExecutePlanGoal { plan_hash: held.plan_hash.clone(), client: "another_client".into() };
    assert!(!execute.send_goal(plan, drop, PATIENCE).expect("a decision").accepted());
    log.line(&["axis_interpolator/execute_plan rejected", &holder]);
    let follow = "axis_interpolator/follow_joint_trajectory";
    let follow = node.action_client::<FollowJointTrajectory>(follow).expect("a client");
    follow.wait_for_server(PATIENCE).expect("follow_joint_trajectory");
    assert!(!follow.send_goal(goal(to("z_axis", 0.05, 2)), drop, PATIENCE).expect("a decision").accepted());
    log.line(&["axis_interpolator/follow_joint_trajectory rejected", &holder]);
    let topic: Publisher<JointTrajectory> =
        node.publisher("axis_interpolator/joint_trajectory", &Qos::default_topic()).expect("a publisher");
    assert!(topic.wait_matched(1, PATIENCE));
    topic.publish(&to("z_axis", 0.05, 2)).expect("published");
    log.line(&["joint trajectory refused", &holder]);

    // Nobody was disturbed: the held job goes on, at half speed and then at full, to its end.
    let set = |feed_override: f64| {
        cell.client.call::<SetOverride>("axis_interpolator/set_override", &SetOverrideRequest { feed_override })
    };
    let refused = set(1.5);
    assert!(!refused.success && refused.message == "override 1.5; allowed: 0 to 1", "{}", refused.message);
    assert!(set(0.5).success);
    assert!(hold(false).success);
    state.until("half speed", |state| {
        (state.feed_override - 0.5).abs() < 1e-9 && state.state == InterpolatorState::EXECUTING
    });
    assert!(set(1.0).success);
    let (status, result) = job.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    assert!(result.lobes[0].form_error_max.abs() < 5e-6, "{} m", result.lobes[0].form_error_max);
    cell.stop();
}

/// An override set between motions is published at once, and applies to the next motion.
#[test]
fn an_override_that_is_set_between_motions_is_that_of_the_next() {
    let cell = Cell::start(&[]);
    let state = Watched::<InterpolatorState>::new(&cell, "axis_interpolator/state", &Qos::latched(1));
    let first = state.until("a state before the first motion", |_| true);
    assert_eq!((first.state, first.feed_override, first.is_homed), (InterpolatorState::IDLE, 1.0, false));
    let set = |feed_override: f64| {
        cell.client.call::<SetOverride>("axis_interpolator/set_override", &SetOverrideRequest { feed_override })
    };
    let follow = "axis_interpolator/follow_joint_trajectory";
    let client = cell.client.node.action_client::<FollowJointTrajectory>(follow).expect("a client");
    client.wait_for_server(PATIENCE).expect("follow_joint_trajectory");
    let log = LogLines::subscribe(&cell);
    let tick = |words: &str| {
        let line = log.line(&["a joint trajectory", words]);
        line.rsplit(' ').next().and_then(|tick| tick.parse::<u64>().ok()).unwrap_or_else(|| panic!("{line}"))
    };
    let ticks = |metres: f64| {
        // No tolerance at the end: it is over with its last setpoint.
        let any = JointTolerance { name: "z_axis".into(), position: -1.0, velocity: -1.0, acceleration: -1.0 };
        let goal = FollowJointTrajectoryGoal { goal_tolerance: vec![any], ..goal(to("z_axis", metres, 2)) };
        let moved = client.send_goal(goal, drop, PATIENCE).expect("a decision");
        assert!(moved.accepted());
        assert_eq!(moved.result(PATIENCE).expect("a result").0, GoalStatus::Succeeded);
        let begun = tick("begins at tick");
        tick("is complete at tick") - begun
    };
    let full = ticks(0.05);
    for value in [0.9, 0.25] {
        assert!(set(value).success);
    }
    state.until("the knob's last word", |state| (state.feed_override - 0.25).abs() < 1e-12);
    let slow = ticks(0.1);
    assert_eq!((full, slow), (2000, 8000), "2 s of motion at 1 ms a tick, and four times as long");
    let last = state.until("idle", |state| state.state == InterpolatorState::IDLE);
    assert!((last.feed_override - 0.25).abs() < 1e-9, "{last:?}");
    cell.stop();
}

/// The alarm of a stop by the interpolator itself is in the result, and on its alarm topic until the next motion begins.
#[test]
fn an_interpolator_alarm_is_reported_and_cleared_by_the_next_motion() {
    let cell = Cell::start(&[]);
    let alarms = Watched::<MachineAlarms>::new(&cell, "axis_interpolator/alarms", &Qos::latched(1));
    let stuck = |active: bool| {
        let request = InjectFaultRequest {
            fault: "stuck_input".into(),
            target: "origin".into(),
            value: 0.0,
            active,
            job_tick: 0,
        };
        let response = cell.client.call::<InjectFault>("machine/inject_fault", &request);
        assert!(response.success, "{}", response.message);
    };
    stuck(true);
    let home = cell.client.node.action_client::<Home>("axis_interpolator/home").expect("a client");
    home.wait_for_server(PATIENCE).expect("home");
    let homed = || {
        let homing = home.send_goal(HomeGoal::default(), drop, PATIENCE).expect("a decision");
        assert!(homing.accepted());
        homing.result(PATIENCE).expect("a result")
    };
    let (status, result) = homed();
    assert_eq!((status, result.alarm), (GoalStatus::Aborted, 90), "{}", result.message);
    let state = Watched::<InterpolatorState>::new(&cell, "axis_interpolator/state", &Qos::latched(1));
    state.until("an alarm is a fault until its reset", |state| state.state == InterpolatorState::FAULT);
    let list = alarms.until("the alarm", |list| list.alarms.iter().any(|alarm| alarm.number == 90));
    let alarm = &list.alarms[0];
    assert!(alarm.active && alarm.source == "axis_interpolator" && alarm.tick > 0, "{alarm:?}");
    assert!(!alarm.text.is_empty() && !alarm.remedy.is_empty() && result.message.contains(&alarm.text), "{alarm:?}");

    stuck(false);
    let reset = cell.client.call::<Trigger>("machine/reset", &TriggerRequest::default());
    assert!(reset.success, "{}", reset.message);
    state.until("the interpolator has heard of the reset", |state| state.state == InterpolatorState::IDLE);
    let (status, result) = homed();
    assert_eq!((status, result.alarm), (GoalStatus::Succeeded, 0), "{}", result.message);
    alarms.until("no alarm is left", |list| list.alarms.is_empty());
    cell.stop();
}

/// While an alarm waits for its reset no goal is accepted, and after the reset goals are accepted again. The same holds for a job that does
/// not exist. Every refusal has its reason in the log; that of a job is in the status of the planner too.
#[test]
fn goals_are_rejected_while_an_alarm_needs_a_reset() {
    let cell = Cell::start(&[]);
    let state = Watched::<InterpolatorState>::new(&cell, "axis_interpolator/state", &Qos::latched(1));
    let log = LogLines::subscribe(&cell);
    let (job, _) = cell.client.send("no_such_job", &[]);
    assert!(!job.accepted(), "there is no such job");
    cell.client.status("names the job", |status| status.message.contains("no_such_job"));
    let estop = |data: bool| assert!(cell.client.call::<SetBool>("machine/estop", &SetBoolRequest { data }).success);
    estop(true);
    state.until("an alarm is a fault until its reset", |state| state.state == InterpolatorState::FAULT);

    let node = &cell.client.node;
    let reason = "alarm 1 needs a reset: ";
    let move_to = MoveToGoal { joints: vec!["z_axis".into()], positions: vec![0.05], ..MoveToGoal::default() };
    is_rejected::<MoveTo>(node, &log, "axis_interpolator/move_to", move_to, reason);
    is_rejected::<Home>(node, &log, "axis_interpolator/home", HomeGoal::default(), reason);
    let jog = JogGoal { joint: "z_axis".into(), velocity: 0.01, distance: 0.001, ..JogGoal::default() };
    is_rejected::<Jog>(node, &log, "axis_interpolator/jog", jog, reason);
    let probe = ProbeGoal { joint: "z_axis".into(), input: "LS1".into(), target: 0.1, ..ProbeGoal::default() };
    is_rejected::<Probe>(node, &log, "axis_interpolator/probe", probe, reason);
    let plan = ExecutePlanGoal { plan_hash: "0123456789abcdef".into(), client: "another_client".into() };
    is_rejected::<ExecutePlan>(node, &log, "axis_interpolator/execute_plan", plan, reason);
    let follow = "axis_interpolator/follow_joint_trajectory";
    is_rejected::<FollowJointTrajectory>(node, &log, follow, goal(to("z_axis", 0.05, 2)), reason);
    let run = RunJobGoal { job: "eccentric".into(), ..RunJobGoal::default() };
    is_rejected::<RunJob>(node, &log, "job_planner/run_job", run, reason);
    let wheel = cell.client.call::<SetBool>("axis_interpolator/wheel", &SetBoolRequest { data: true });
    assert!(!wheel.success && wheel.message.starts_with(reason), "{}", wheel.message);

    estop(false);
    let deadline = Instant::now() + PATIENCE;
    while !cell.client.call::<Trigger>("machine/reset", &TriggerRequest::default()).success {
        assert!(Instant::now() < deadline, "the machine cannot be reset");
    }
    state.until("the interpolator has heard of the reset", |state| state.state == InterpolatorState::IDLE);
    let client = node.action_client::<FollowJointTrajectory>(follow).expect("a client");
    client.wait_for_server(PATIENCE).expect("follow_joint_trajectory");
    let moved = client.send_goal(goal(to("z_axis", 0.05, 2)), drop, PATIENCE).expect("a decision");
    assert!(moved.accepted());
    assert_eq!(moved.result(PATIENCE).expect("a result").0, GoalStatus::Succeeded);
    cell.stop();
}

fn is_rejected<A: Action>(node: &Node, log: &LogLines, action: &str, goal: A::Goal, reason: &str) {
    let client = node.action_client::<A>(action).expect("a client");
    client.wait_for_server(PATIENCE).expect("the action");
    assert!(!client.send_goal(goal, drop, PATIENCE).expect("a decision").accepted(), "{action}");
    log.line(&[&format!("{action} rejected: "), reason]);
}

/// The state comes every 50 ms of machine time in a motion, whatever the cycle time, and twice a second at rest with the machine's last tick.
/// Its stamp is the time of its tick.
#[test]
fn the_state_has_its_period_and_the_stamp_of_its_tick() {
    const CYCLE_NS: i64 = 2_000_000;
    let cell = Cell::start(&["cycle_time_us=2000"]);
    let node = &cell.client.node;
    let stream = Watched::<MachineStream>::new(&cell, "machine/stream", &Qos::default_topic());
    let (sender, states) = mpsc::channel();
    let on_message = move |state: InterpolatorState, _: &_| drop(sender.send(state));
    let _states = node
        .subscribe("axis_interpolator/state", &Qos::latched(1).keep_last(1000), on_message)
        .expect("a subscription");
    let ns = |stamp: &Time| i64::from(stamp.sec) * 1_000_000_000 + i64::from(stamp.nanosec);
    let epoch_ns = ns(&stream.until("the machine's time", |_| true).epoch);
    let next = || {
        let state = states.recv_timeout(PATIENCE).expect("a state");
        let tick = i64::try_from(state.tick).expect("not that long");
        assert_eq!(ns(&state.stamp), epoch_ns + tick * CYCLE_NS, "{state:?}");
        state
    };
    let follow = "axis_interpolator/follow_joint_trajectory";
    let client = node.action_client::<FollowJointTrajectory>(follow).expect("a client");
    client.wait_for_server(PATIENCE).expect("follow_joint_trajectory");
    let moved = client.send_goal(goal(to("z_axis", 0.05, 2)), drop, PATIENCE).expect("a decision");
    assert!(moved.accepted());
    let mut last = next();
    while last.state != InterpolatorState::EXECUTING {
        last = next();
    }
    let mut count = 0;
    loop {
        let state = next();
        if state.state != InterpolatorState::EXECUTING {
            last = state;
            break;
        }
        let ticks = state.tick - last.tick;
        assert!((1..=25).contains(&ticks), "{ticks} ticks of 2 ms between two states");
        (count, last) = (count + 1, state);
    }
    assert!(count >= 39, "{count} states in a motion of 2 s");
    // At rest: those that follow each other without a change.
    let deadline = Instant::now() + PATIENCE;
    let mut repetitions = 0;
    while repetitions < 2 {
        assert!(Instant::now() < deadline, "the state is not repeated at rest: {last:?}");
        let state = next();
        let is_same = |a: &InterpolatorState, b: &InterpolatorState| {
            InterpolatorState { stamp: Time::default(), tick: 0, ..a.clone() }
                == InterpolatorState { stamp: Time::default(), tick: 0, ..b.clone() }
        };
        repetitions +=
            u32::from(state.state == InterpolatorState::IDLE && is_same(&state, &last) && state.tick > last.tick);
        last = state;
    }
    cell.stop();
}
