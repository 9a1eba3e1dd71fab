//! The axis interpolator among the nodes it works with: homing, trajectories of other clients, override, hold, who has command, alarms.

use crate::cell;
use crate::watched;

use camwright_msgs::builtin_interfaces::msg::Duration as RosDuration;
use camwright_msgs::camwright_msgs::action::{ExecutePlan, ExecutePlanGoal, Home, HomeFeedback, HomeGoal};
use camwright_msgs::camwright_msgs::msg::{InterpolatorState, MachineAlarms, PlanSegment};
use camwright_msgs::camwright_msgs::srv::{
    FeedHold, FeedHoldRequest, InjectFault, InjectFaultRequest, SetOverride, SetOverrideRequest,
};
use camwright_msgs::control_msgs::action::{FollowJointTrajectory, FollowJointTrajectoryGoal};
use camwright_msgs::control_msgs::msg::JointTolerance;
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};
use camwright_ros::{GoalStatus, Publisher, Qos};
use cell::{Cell, PATIENCE};
use std::sync::mpsc;
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
    assert_eq!((status, result.success, result.alarm), (GoalStatus::Succeeded, true, 0), "{}", result.message);
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
    let hold = |hold: bool| cell.client.call::<FeedHold>("axis_interpolator/feed_hold", &FeedHoldRequest { hold });
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
    let plan = ExecutePlanGoal { plan_hash: held.plan_hash.clone(), client: "somebody".into() };
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
    assert_eq!((status, result.success, result.alarm), (GoalStatus::Aborted, false, 90), "{}", result.message);
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
