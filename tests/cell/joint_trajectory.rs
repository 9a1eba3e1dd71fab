// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Joint trajectories of other clients, as the joint trajectory controller of `ros2_control` serves them: refusals with reasons, tolerances,
//! stamps, replacement, cancel, deactivation, scaling, and progress topics.
#![allow(clippy::print_stdout, reason = "a test shows what it measured")]

use crate::cell;
use crate::support;
use crate::watched;

use camwright_msgs::builtin_interfaces::msg::{Duration as RosDuration, Time};
use camwright_msgs::camwright_msgs::action::{Home, HomeGoal};
use camwright_msgs::camwright_msgs::msg::MachineStream;
use camwright_msgs::cdr::message_from_sample;
use camwright_msgs::control_msgs::action::{
    FollowJointTrajectory, FollowJointTrajectoryFeedback, FollowJointTrajectoryFeedbackMessage,
    FollowJointTrajectoryGoal, FollowJointTrajectoryResult,
};
use camwright_msgs::control_msgs::msg::{JointTolerance, JointTrajectoryControllerState, SpeedScalingFactor};
use camwright_msgs::control_msgs::srv::{QueryTrajectoryState, QueryTrajectoryStateRequest};
use camwright_msgs::lifecycle_msgs::srv::{ChangeState, ChangeStateRequest};
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::std_msgs::msg::Header;
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint, MultiDOFJointTrajectoryPoint};
use camwright_msgs::unique_identifier_msgs::msg::UUID;
use camwright_ros::{ActionClient, CancelOutcome, ClientGoal, GoalStatus, ParameterValue, Publisher, Qos};
use cell::{Cell, PATIENCE};
use serde_json::json;
use std::sync::mpsc;
use watched::{LogLines, Watched};

type Codes = FollowJointTrajectoryResult;

fn seconds(s: f64) -> RosDuration {
    let duration = std::time::Duration::from_secs_f64(s);
    RosDuration { sec: i32::try_from(duration.as_secs()).expect("not that long"), nanosec: duration.subsec_nanos() }
}

/// From where the joint is, to rest at a place, at a time.
fn to(joint: &str, position: f64, time_s: f64) -> JointTrajectory {
    let point = JointTrajectoryPoint {
        positions: vec![position],
        time_from_start: seconds(time_s),
        ..JointTrajectoryPoint::default()
    };
    JointTrajectory { joint_names: vec![joint.into()], points: vec![point], ..JointTrajectory::default() }
}

fn goal(trajectory: JointTrajectory) -> FollowJointTrajectoryGoal {
    FollowJointTrajectoryGoal { trajectory, ..FollowJointTrajectoryGoal::default() }
}

fn tolerance(joint: &str, position: f64, velocity: f64) -> JointTolerance {
    JointTolerance { name: joint.into(), position, velocity, acceleration: 0.0 }
}

fn position(joints: &JointState, joint: &str) -> f64 {
    joints.position[joints.name.iter().position(|name| name == joint).expect("a joint of the machine")]
}

/// A client of the action.
struct Follower {
    client: ActionClient<FollowJointTrajectory>,
}

impl Follower {
    fn new(cell: &Cell) -> Self {
        let client = cell.client.node.action_client("axis_interpolator/follow_joint_trajectory").expect("a client");
        client.wait_for_server(PATIENCE).expect("follow_joint_trajectory");
        Self { client }
    }

    fn send(&self, goal: FollowJointTrajectoryGoal) -> ClientGoal<FollowJointTrajectory> {
        self.client.send_goal(goal, drop, PATIENCE).expect("a decision")
    }

    /// A goal on its way: its first feedback has come.
    fn moving(&self, goal: FollowJointTrajectoryGoal) -> ClientGoal<FollowJointTrajectory> {
        let (sender, feedback) = mpsc::channel();
        let send = move |feedback: FollowJointTrajectoryFeedback| drop(sender.send(feedback));
        let goal = self.client.send_goal(goal, send, PATIENCE).expect("a decision");
        assert!(goal.accepted());
        feedback.recv_timeout(PATIENCE).expect("feedback");
        goal
    }
}

fn result(goal: &ClientGoal<FollowJointTrajectory>) -> (GoalStatus, i32, String) {
    let (status, result) = goal.result(PATIENCE).expect("a result");
    (status, result.error_code, result.error_string)
}

#[test]
fn a_trajectory_is_followed_and_feedback_state_and_query_tell_how() {
    let cell = Cell::start(&[]);
    let follower = Follower::new(&cell);
    let state = "axis_interpolator/controller_state";
    let state = Watched::<JointTrajectoryControllerState>::new(&cell, state, &Qos::default_topic());
    let joints = Watched::<JointState>::new(&cell, "joint_states", &Qos::default_topic());
    let idle = state.until("the state of the controller at rest", |_| true);
    assert_eq!(
        (idle.joint_names.as_slice(), idle.speed_scaling_factor),
        (&["c_axis", "x_axis", "z_axis"].map(String::from)[..], 1.0)
    );

    let (sender, feedback) = mpsc::channel();
    let send = move |feedback: FollowJointTrajectoryFeedback| drop(sender.send(feedback));
    let moved = follower.client.send_goal(goal(to("z_axis", 0.05, 2.0)), send, PATIENCE).expect("a decision");
    assert!(moved.accepted());
    assert_eq!(result(&moved).0, GoalStatus::Succeeded);
    joints.until("the table stands at 50 mm", |joints| (position(joints, "z_axis") - 0.05).abs() < 1e-9);
    let received: Vec<FollowJointTrajectoryFeedback> = feedback.try_iter().collect();
    // 20 Hz over 2 s, and what settling takes; one message may be under way.
    assert!((38..=60).contains(&received.len()), "{} messages of feedback", received.len());
    let middle = &received[received.len() / 2];
    assert_eq!(middle.joint_names, ["z_axis"]);
    let (desired, actual, error) = (middle.desired.positions[0], middle.actual.positions[0], middle.error.positions[0]);
    // The table lags its setpoint, and the difference is reported.
    assert!((desired - actual - error).abs() < 1e-12 && error > 1e-6, "{desired} {actual} {error}");
    assert!(middle.desired.velocities[0] > 0.01 && middle.actual.velocities[0] > 0.01);

    // While a long one is followed: where it will be, and not where there is none.
    let query = |time: Time| {
        let name = "axis_interpolator/query_state";
        cell.client.call::<QueryTrajectoryState>(name, &QueryTrajectoryStateRequest { time })
    };
    let none = query(Time { sec: 1, nanosec: 0 });
    assert!(!none.success && !none.message.is_empty());
    let far = follower.moving(goal(to("z_axis", 0.3, 2000.0)));
    let now = state.until("it moves", |state| state.reference.velocities[2] > 0.0);
    let later = query(Time { sec: now.header.stamp.sec + 3000, ..now.header.stamp });
    assert!(later.success && later.name == ["c_axis", "x_axis", "z_axis"], "{}", later.message);
    assert!((later.position[2] - 0.3).abs() < 1e-9 && later.velocity[2].abs() < 1e-12, "{later:?}");
    assert_eq!(far.cancel(PATIENCE).expect("an answer"), CancelOutcome::Accepted);
    assert_eq!(result(&far).0, GoalStatus::Canceled);
    cell.stop();
}

#[test]
fn refusals_come_before_motion_with_a_logged_reason() {
    let cell = Cell::start(&[]);
    let (follower, log) = (Follower::new(&cell), LogLines::subscribe(&cell));
    let good = || to("z_axis", 0.05, 2.0);
    let with_point = |change: &dyn Fn(&mut JointTrajectoryPoint)| {
        let mut trajectory = good();
        change(&mut trajectory.points[0]);
        goal(trajectory)
    };
    let path = |tolerance| FollowJointTrajectoryGoal { path_tolerance: vec![tolerance], ..goal(good()) };
    let mut over = good();
    over.header.stamp = Time { sec: 1_000, nanosec: 0 };
    let mut twice = good();
    twice.points.push(twice.points[0].clone());
    let negative =
        FollowJointTrajectoryGoal { goal_time_tolerance: RosDuration { sec: -2, nanosec: 0 }, ..goal(good()) };
    let acceleration = JointTolerance { acceleration: 1.0, ..tolerance("z_axis", 0.0, 0.0) };
    let cases = [
        (goal(JointTrajectory::default()), "at least one joint"),
        (goal(to("y_axis", 0.05, 2.0)), "there is no joint \"y_axis\""),
        (goal(to("z_axis", 0.5, 1.0)), "z_axis at"),
        (goal(to("z_axis", f64::NAN, 1.0)), "not a finite number"),
        (with_point(&|point| point.positions.push(1.0)), "2 position values for 1 joints"),
        (with_point(&|point| point.effort = vec![1.0]), "gives efforts"),
        (with_point(&|point| point.velocities = vec![0.02]), "it must be at rest"),
        (goal(over), "by the stamp of its header"),
        (goal(twice), "does not increase"),
        (negative, "goal_time_tolerance is -2 s; allowed: a positive time, 0 for the default, -1 for unlimited"),
        (path(tolerance("z_axis", -2.0, 0.0)), "position tolerance -2 is negative"),
        (path(tolerance("y_axis", 1.0, 0.0)), "path_tolerance names \"y_axis\""),
        (path(acceleration), "does not measure"),
    ];
    for (goal, words) in cases {
        assert!(!follower.send(goal).accepted(), "{words}");
        log.line(&["axis_interpolator/follow_joint_trajectory rejected", words]);
    }
    let set = |value| cell.interpolator.node().parameters().set("allow_partial_joints_goal", value);
    set(ParameterValue::Bool(false)).expect("it may change");
    assert!(!follower.send(goal(good())).accepted());
    log.line(&["rejected", "c_axis is not named, and allow_partial_joints_goal is false"]);
    assert!(!cell.client.has_moved());
    cell.stop();
}

#[test]
fn what_is_refused_on_the_topic_is_logged_with_the_reason_and_repetitions_are_counted() {
    let cell = Cell::start(&[]);
    let log = LogLines::subscribe(&cell);
    let publisher =
        cell.client.node.publisher::<JointTrajectory>("axis_interpolator/joint_trajectory", &Qos::default_topic());
    let publisher = publisher.expect("a publisher");
    assert!(publisher.wait_matched(1, PATIENCE), "the interpolator subscribes");
    let mut long = to("z_axis", 0.05, 2.0);
    long.points[0].positions.push(1.0);
    let cases = [
        (JointTrajectory::default(), "at least one joint"),
        (to("z_axis", 5.0, 60.0), "z_axis"),
        (to("z_axis", 0.05, 0.02), "z_axis"),
        (to("y_axis", 0.05, 2.0), "there is no joint \"y_axis\""),
        (long, "2 position values for 1 joints"),
    ];
    for (trajectory, words) in cases {
        publisher.publish(&trajectory).expect("room");
        log.line(&["joint trajectory refused", words]);
    }
    for _ in 0..20 {
        publisher.publish(&JointTrajectory::default()).expect("room");
    }
    log.line(&["joint trajectory refused", "at least one joint", "more times in the last 5 s"]);
    assert!(!cell.client.has_moved());
    cell.stop();
}

#[test]
fn a_tolerance_that_is_broken_ends_the_goal_with_joint_amount_and_time() {
    let cell = Cell::start(&[]);
    let follower = Follower::new(&cell);
    // 50 mm in 1 s: the table comes some mm after its setpoint.
    let fast = |path: &[JointTolerance], at_end: &[JointTolerance], goal_time_s: f64| FollowJointTrajectoryGoal {
        path_tolerance: path.to_vec(),
        goal_tolerance: at_end.to_vec(),
        goal_time_tolerance: seconds(goal_time_s),
        ..goal(to("z_axis", 0.05, 1.0))
    };
    let broken = follower.send(fast(&[tolerance("z_axis", 1e-5, 0.0)], &[], 0.0));
    assert!(broken.accepted());
    let (status, code, text) = result(&broken);
    assert_eq!((status, code), (GoalStatus::Aborted, Codes::PATH_TOLERANCE_VIOLATED), "{text}");
    for words in ["z_axis: position error ", " mm exceeds 0.010000 mm by ", " s after the start"] {
        assert!(text.contains(words), "{text}");
    }
    let joints = Watched::<JointState>::new(&cell, "joint_states", &Qos::default_topic());
    let stopped = joints.until("it stops", |joints| joints.velocity.iter().all(|velocity| *velocity == 0.0));
    let stands = position(&stopped, "z_axis");
    assert!((0.001..0.049).contains(&stands), "on its way, at {stands} m");

    // Back, fast; of a tolerance that nobody can keep in 1 ms it says so, and how long after the end.
    let back = FollowJointTrajectoryGoal {
        trajectory: to("z_axis", 0.0, 0.8),
        ..fast(&[], &[tolerance("z_axis", 1e-9, -1.0)], 0.001)
    };
    let late = follower.send(back);
    assert!(late.accepted());
    let (status, code, text) = result(&late);
    assert_eq!((status, code), (GoalStatus::Aborted, Codes::GOAL_TOLERANCE_VIOLATED), "{text}");
    assert!(text.starts_with("z_axis: position error ") && text.ends_with(" s after the end"), "{text}");

    // The defaults are parameters, and -1 takes them away.
    let node = cell.interpolator.node();
    let set = |name: &str, value| node.parameters().set(name, ParameterValue::Double(value)).expect("in its range");
    set("constraints.z_axis.trajectory", 1e-5);
    let (status, code, _) = result(&follower.send(fast(&[], &[], 0.0)));
    assert_eq!((status, code), (GoalStatus::Aborted, Codes::PATH_TOLERANCE_VIOLATED));
    let (status, code, text) = result(&follower.send(fast(&[tolerance("z_axis", -1.0, 0.0)], &[], 0.0)));
    assert_eq!((status, code), (GoalStatus::Succeeded, Codes::SUCCESSFUL), "{text}");
    cell.stop();
}

/// A goal time of 0 is unlimited in ROS 2 Jazzy and Kilted and allows no time in Lyrical; a negative one is unlimited in both.
#[test]
fn a_goal_time_of_zero_has_the_meaning_of_a_parameter() {
    let cell = Cell::start(&[]);
    let follower = Follower::new(&cell);
    let node = cell.interpolator.node();
    let set = |name: &str, value| node.parameters().set(name, value).expect("in its range");
    let mut at_end = false;
    // At the end of such a motion the table still is farther away than this.
    let mut follow = |goal_time_s: i32| {
        at_end = !at_end;
        let trajectory = to("z_axis", if at_end { 0.05 } else { 0.0 }, 0.5);
        let goal = FollowJointTrajectoryGoal {
            goal_tolerance: vec![tolerance("z_axis", 1e-7, -1.0)],
            goal_time_tolerance: RosDuration { sec: goal_time_s, nanosec: 0 },
            ..goal(trajectory)
        };
        let sent = follower.send(goal);
        assert!(sent.accepted());
        let (status, code, text) = result(&sent);
        assert_eq!(status == GoalStatus::Succeeded, code == Codes::SUCCESSFUL, "{text}");
        (code, text)
    };
    let (code, text) = follow(0);
    assert_eq!(code, Codes::SUCCESSFUL, "0 is unlimited: {text}");
    set("constraints.goal_time_zero_is_unlimited", ParameterValue::Bool(false));
    let (code, text) = follow(0);
    assert_eq!(code, Codes::GOAL_TOLERANCE_VIOLATED, "0 allows no time: {text}");
    let (code, text) = follow(-1);
    assert_eq!(code, Codes::SUCCESSFUL, "-1 in the goal is unlimited: {text}");
    set("constraints.goal_time", ParameterValue::Double(-1.0));
    let (code, text) = follow(0);
    assert_eq!(code, Codes::SUCCESSFUL, "a negative default is unlimited: {text}");
    cell.stop();
}

/// Feedback as `control_msgs` 6.3 of ROS 2 Kilted defines it.
#[derive(Debug, serde::Deserialize)]
struct KiltedFeedback {
    _goal: UUID,
    _header: Header,
    joint_names: Vec<String>,
    desired: JointTrajectoryPoint,
    _actual: JointTrajectoryPoint,
    error: JointTrajectoryPoint,
    index: i32,
    multi_dof_joint_names: Vec<String>,
    multi_dof_desired: MultiDOFJointTrajectoryPoint,
    multi_dof_actual: MultiDOFJointTrajectoryPoint,
    multi_dof_error: MultiDOFJointTrajectoryPoint,
    multi_dof_index: i32,
}

/// One message serves clients of Jazzy and of Kilted, whose definition has two fields more.
#[test]
fn feedback_is_read_by_the_definitions_of_jazzy_and_of_kilted() {
    let cell = Cell::start(&[]);
    let follower = Follower::new(&cell);
    let (sender, samples) = mpsc::channel();
    let send = move |sample: &[u8], _: &_| drop(sender.send(sample.to_vec()));
    let topic = "axis_interpolator/follow_joint_trajectory/_action/feedback";
    let kind = "control_msgs/action/FollowJointTrajectory_FeedbackMessage";
    let feedback = cell.client.node.subscribe_raw(topic, kind, &Qos::default_topic(), send).expect("a subscription");
    assert!(feedback.wait_matched(1, PATIENCE), "the interpolator publishes feedback");
    let moving = follower.moving(goal(to("z_axis", 0.05, 2.0)));
    let sample = samples.recv_timeout(PATIENCE).expect("feedback");
    let kilted: KiltedFeedback = message_from_sample(&sample).expect("the definition of Kilted");
    let jazzy: FollowJointTrajectoryFeedbackMessage = message_from_sample(&sample).expect("the definition of Jazzy");
    assert_eq!((&kilted.joint_names[..], kilted.index, kilted.multi_dof_index), (&["z_axis".to_owned()][..], 0, 0));
    assert_eq!((&kilted.desired, &kilted.error), (&jazzy.feedback.desired, &jazzy.feedback.error));
    assert!(kilted.multi_dof_joint_names.is_empty());
    let none = MultiDOFJointTrajectoryPoint::default();
    for point in [&kilted.multi_dof_desired, &kilted.multi_dof_actual, &kilted.multi_dof_error] {
        assert_eq!(*point, none);
    }
    let (status, code, text) = result(&moving);
    assert_eq!((status, code), (GoalStatus::Succeeded, Codes::SUCCESSFUL), "{text}");
    cell.stop();
}

/// A new goal takes the place of the one before while the axes move; one that cannot be followed from there has no effect.
/// The goal in the guide, as a user of the `ros2` command line types it.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct TypedGoal {
    trajectory: TypedTrajectory,
    path_tolerance: Vec<TypedTolerance>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct TypedTrajectory {
    joint_names: Vec<String>,
    points: Vec<TypedPoint>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct TypedPoint {
    positions: Vec<f64>,
    time_from_start: TypedDuration,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct TypedDuration {
    sec: i32,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct TypedTolerance {
    name: String,
    position: f64,
}

impl From<TypedGoal> for FollowJointTrajectoryGoal {
    fn from(typed: TypedGoal) -> Self {
        let point = |point: TypedPoint| JointTrajectoryPoint {
            positions: point.positions,
            time_from_start: RosDuration { sec: point.time_from_start.sec, nanosec: 0 },
            ..JointTrajectoryPoint::default()
        };
        let points = typed.trajectory.points.into_iter().map(point).collect();
        let trajectory =
            JointTrajectory { joint_names: typed.trajectory.joint_names, points, ..JointTrajectory::default() };
        let tolerances = typed.path_tolerance.into_iter().map(|of| tolerance(&of.name, of.position, 0.0)).collect();
        FollowJointTrajectoryGoal { path_tolerance: tolerances, ..goal(trajectory) }
    }
}

/// The example of the guide succeeds within its own tolerance, and ends as the guide says with the smaller one.
#[test]
fn the_example_of_the_guide_keeps_its_tolerance() {
    let guide = std::fs::read_to_string(support::repository().join("docs/guides/cell.md")).expect("the guide");
    let command = guide.split("ros2 action send_goal --feedback /axis_interpolator/follow_joint_trajectory").nth(1);
    let text = command.and_then(|command| command.split('"').nth(1)).expect("a goal in quotes");
    let example: TypedGoal = serde_saphyr::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"));
    let example = FollowJointTrajectoryGoal::from(example);
    assert!(example.path_tolerance[0].position > 0.0, "{text}");
    let cell = Cell::start(&[]);
    let follower = Follower::new(&cell);
    let (sender, feedback) = mpsc::channel();
    let send = move |feedback: FollowJointTrajectoryFeedback| {
        let _is_over = sender.send(feedback.error.positions[0].abs());
    };
    let moved = follower.client.send_goal(example.clone(), send, PATIENCE).expect("a decision");
    assert!(moved.accepted());
    let (status, code, text) = result(&moved);
    let largest = feedback.try_iter().fold(0.0, f64::max);
    println!("largest error {:.1} um of {:.1} um", 1e6 * largest, 1e6 * example.path_tolerance[0].position);
    assert_eq!((status, code), (GoalStatus::Succeeded, Codes::SUCCESSFUL), "{text}");
    let back = goal(to("z_axis", 0.0, 2.0));
    assert_eq!(result(&follower.send(back)).0, GoalStatus::Succeeded);
    let narrow =
        FollowJointTrajectoryGoal { path_tolerance: vec![tolerance("z_axis", 0.000_01, 0.0)], ..example.clone() };
    let (status, code, text) = result(&follower.send(narrow));
    assert_eq!((status, code), (GoalStatus::Aborted, Codes::PATH_TOLERANCE_VIOLATED), "{text}");
    assert!(text.contains("z_axis: position error") && text.contains("exceeds 0.010000 mm by"), "{text}");
    cell.stop();
}

#[test]
fn a_new_goal_takes_the_place_of_the_one_before_without_a_stop() {
    let cell = Cell::start(&[]);
    let (follower, log) = (Follower::new(&cell), LogLines::subscribe(&cell));
    let state = "axis_interpolator/controller_state";
    let state = Watched::<JointTrajectoryControllerState>::new(&cell, state, &Qos::default_topic());
    let (sender, speeds) = mpsc::channel();
    let on_joints = move |joints: JointState, _: &_| {
        let _test_is_over = sender.send(joints.velocity[2]);
    };
    let _speeds = cell
        .client
        .node
        .subscribe("joint_states", &Qos::default_topic().keep_last(2000), on_joints)
        .expect("a subscription");
    let first = follower.moving(goal(to("z_axis", 0.3, 100.0)));
    state.until("it moves", |state| state.feedback.velocities[2] > 1e-3);
    let sharp = follower.send(goal(to("z_axis", 0.3, 0.1)));
    assert!(!sharp.accepted(), "0.3 m in 0.1 s");
    log.line(&["rejected", "z_axis at", "the machine allows"]);
    let other = follower.send(goal(to("x_axis", 0.06, 5.0)));
    assert!(!other.accepted());
    log.line(&["rejected", "joint z_axis still moves and the new trajectory does not name it"]);

    let second = follower.moving(goal(to("z_axis", 0.32, 60.0)));
    let (status, code, text) = result(&first);
    assert_eq!((status, code), (GoalStatus::Aborted, Codes::INVALID_GOAL), "{text}");
    assert!(text.starts_with("a joint trajectory replaced it at tick "), "{text}");
    // It never stopped: from when it moved on, no tick at rest.
    let fast: Vec<f64> = speeds.try_iter().skip_while(|speed| *speed <= 1e-3).collect();
    let slowest = fast.iter().copied().fold(f64::MAX, f64::min);
    assert!(fast.len() > 100 && slowest > 0.0, "{} ticks, the slowest at {slowest} m/s", fast.len());

    // The topic does the same, and is not asked.
    let topic: Publisher<JointTrajectory> =
        cell.client.node.publisher("axis_interpolator/joint_trajectory", &Qos::default_topic()).expect("a publisher");
    assert!(topic.wait_matched(1, PATIENCE));
    topic.publish(&to("z_axis", 0.2, 10.0)).expect("published");
    let (status, code, text) = result(&second);
    assert_eq!((status, code), (GoalStatus::Aborted, Codes::INVALID_GOAL), "{text}");
    assert!(text.starts_with("a joint trajectory of the topic by /"), "{text}");
    let joints = Watched::<JointState>::new(&cell, "joint_states", &Qos::default_topic());
    joints.until("the table stands at 200 mm", |joints| (position(joints, "z_axis") - 0.2).abs() < 1e-9);
    // The goal that comes while the one before is at its end begins after it.
    let (status, _, text) = result(&follower.send(goal(to("z_axis", 0.1, 3.0))));
    assert_eq!(status, GoalStatus::Succeeded, "{text}");
    cell.stop();
}

/// A goal is served as soon as it is accepted, though its motion waits until the axes stand still; one that arrives then replaces it.
#[test]
fn a_goal_that_follows_an_ended_motion_is_replaced() {
    let cell = Cell::start(&[]);
    let follower = Follower::new(&cell);
    let replacing = |before: &str, (position, time_s): (f64, f64)| {
        let slow = follower.moving(goal(to("z_axis", 0.2, 3600.0)));
        let fast = follower.moving(goal(to("z_axis", position, time_s)));
        let (status, code, text) = result(&slow);
        assert_eq!((status, code), (GoalStatus::Aborted, Codes::INVALID_GOAL), "after {before}: {text}");
        assert!(text.starts_with("a joint trajectory replaced it at tick "), "after {before}: {text}");
        fast
    };
    let succeeds = |goal: &ClientGoal<FollowJointTrajectory>| {
        let (status, _, text) = result(goal);
        assert_eq!(status, GoalStatus::Succeeded, "{text}");
    };
    succeeds(&replacing("nothing", (0.0, 2.0)));
    succeeds(&follower.send(goal(to("z_axis", 0.05, 1.0))));
    succeeds(&replacing("a complete goal", (0.1, 2.0)));

    let far = follower.moving(goal(to("z_axis", 0.3, 100.0)));
    assert_eq!(far.cancel(PATIENCE).expect("an answer"), CancelOutcome::Accepted);
    assert_eq!(result(&far).0, GoalStatus::Canceled);
    succeeds(&replacing("a cancelled goal", (0.05, 2.0)));

    let narrow = FollowJointTrajectoryGoal {
        path_tolerance: vec![tolerance("z_axis", 1e-5, 0.0)],
        ..goal(to("z_axis", 0.1, 1.0))
    };
    let (status, code, text) = result(&follower.send(narrow));
    assert_eq!((status, code), (GoalStatus::Aborted, Codes::PATH_TOLERANCE_VIOLATED), "{text}");
    succeeds(&replacing("an aborted goal", (0.1, 2.0)));

    let home = cell.client.node.action_client::<Home>("axis_interpolator/home").expect("a client");
    home.wait_for_server(PATIENCE).expect("home");
    let homing = home.send_goal(HomeGoal { joints: vec!["c_axis".into()] }, drop, PATIENCE).expect("a decision");
    let (status, homed) = homing.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", homed.message);
    // Two replacements in a row.
    let second = replacing("a homing", (0.15, 3600.0));
    let third = follower.moving(goal(to("z_axis", 0.1, 3.0)));
    let (status, _, text) = result(&second);
    assert_eq!(status, GoalStatus::Aborted, "{text}");
    assert!(text.starts_with("a joint trajectory replaced it at tick "), "{text}");
    succeeds(&third);
    let joints = Watched::<JointState>::new(&cell, "joint_states", &Qos::default_topic());
    joints.until("the table stands at 100 mm", |joints| (position(joints, "z_axis") - 0.1).abs() < 1e-9);
    cell.stop();
}

#[test]
fn a_trajectory_with_a_stamp_begins_at_its_time_and_a_late_one_with_what_is_left() {
    let cell = Cell::start(&[]);
    let (follower, log) = (Follower::new(&cell), LogLines::subscribe(&cell));
    let joints = Watched::<JointState>::new(&cell, "joint_states", &Qos::default_topic());
    let stream = Watched::<MachineStream>::new(&cell, "machine/stream", &Qos::default_topic().keep_last(1000));
    let ns = |time: &Time| i64::from(time.sec) * 1_000_000_000 + i64::from(time.nanosec);
    let at = |stamp: &Time, later_s: i32| Time { sec: stamp.sec + later_s, nanosec: stamp.nanosec };
    let stream_state = stream.until("the machine", |_| true);
    let mut later = to("z_axis", 0.05, 2.0);
    later.header.stamp = at(&stream_state.stamp, 20);
    assert_eq!(result(&follower.send(goal(later.clone()))).0, GoalStatus::Succeeded);
    let line = log.line(&["a joint trajectory by ", " is complete at tick"]);
    let last_tick: i64 = line.rsplit(' ').next().and_then(|tick| tick.parse().ok()).unwrap_or_else(|| panic!("{line}"));
    // 2 s from its stamp on, and until it is seen that it stands: the next tick that is measured, and the feedback delay of 100.
    let late_ticks = last_tick - (ns(&later.header.stamp) - ns(&stream_state.epoch)) / 1_000_000 - 2000;
    assert!((100..=130).contains(&late_ticks), "{late_ticks} ticks after its end");

    // Two points, of which the first is over: it goes to the second in the time that is left, from where it stands.
    let now = joints.until("it stands", |joints| joints.velocity[2] == 0.0).header.stamp;
    let mut late = to("z_axis", 0.3, 1.0);
    late.points.push(to("z_axis", 0.1, 60.0).points.remove(0));
    late.header.stamp = at(&now, -5);
    assert_eq!(result(&follower.send(goal(late))).0, GoalStatus::Succeeded);
    let stood = joints.until("the table stands at 100 mm", |joints| (position(joints, "z_axis") - 0.1).abs() < 1e-9);
    assert!(stood.velocity[2].abs() < 0.1);
    cell.stop();
}

/// Trajectory of a joint from a position to another, as planners send it: the first point at time 0 is the state they planned from.
fn planned(joint: &str, from: f64, position: f64, time_s: f64) -> JointTrajectory {
    let mut trajectory = to(joint, position, time_s);
    let first =
        JointTrajectoryPoint { positions: vec![from], velocities: vec![0.0], ..JointTrajectoryPoint::default() };
    trajectory.points[0].velocities = vec![0.0];
    trajectory.points.insert(0, first);
    trajectory
}

/// Planners begin with the measured positions, and send the next goal as soon as the one before is over: an axis is still settling then.
#[test]
fn goals_that_begin_with_the_measured_positions_are_followed_right_after_a_move() {
    let cell = Cell::start_realtime(&[]);
    let (follower, log) = (Follower::new(&cell), LogLines::subscribe(&cell));
    let joints = Watched::<JointState>::new(&cell, "joint_states", &Qos::default_topic());
    let places =
        [("z_axis", 0.03), ("x_axis", 0.12), ("c_axis", 1.5), ("z_axis", 0.0), ("x_axis", 0.15), ("c_axis", 0.0)];
    for (joint, place) in places.into_iter().chain(places) {
        let from = position(&joints.until("a position", |_| true), joint);
        let sent = follower.send(goal(planned(joint, from, place, 0.8)));
        assert!(sent.accepted(), "{joint} from {from} to {place}");
        let (status, code, text) = result(&sent);
        assert_eq!((status, code), (GoalStatus::Succeeded, Codes::SUCCESSFUL), "{text}");
    }
    // Farther away than the tolerance: refused with joint, position and what is allowed.
    let from = position(&joints.until("it stands", |joints| joints.velocity[2] == 0.0), "z_axis");
    assert!(!follower.send(goal(planned("z_axis", from + 0.002, 0.03, 0.8))).accepted());
    log.line(&["z_axis", "the point at time 0 is at", "allowed: 0.5 mm", "start tolerance"]);
    cell.stop();
}

/// The same by rclpy, as `MoveIt`'s controller manager would.
#[test]
fn goals_of_rclpy_that_begin_with_the_measured_positions_are_followed() {
    let Some(env) = support::peer_env() else { return };
    let cell = Cell::start_realtime(&[]);
    let mut peer = support::Peer::start(env, cell.domain(), "planner");
    let (states, action) = ("/joint_states", "/axis_interpolator/follow_joint_trajectory");
    let topic = json!({ "topic": states, "type": "sensor_msgs/msg/JointState", "qos": "best_effort" });
    peer.ask("subscribe", topic);
    for round in 0..12 {
        // What came during the last move is no longer true.
        let _before = peer.events_so_far("message");
        let measured = peer.message(states);
        let from = measured["position"][2].as_f64().expect("a position");
        let rest = json!([0.0]);
        let points = json!([
            { "positions": [from], "velocities": rest },
            { "positions": [if round % 2 == 0 { 0.03 } else { 0.0 }], "velocities": rest,
              "time_from_start": { "sec": 0, "nanosec": 800_000_000 } },
        ]);
        let goal = json!({ "trajectory": { "joint_names": ["z_axis"], "points": points } });
        let kind = "control_msgs/action/FollowJointTrajectory";
        let sent = peer.ask("send_goal", json!({ "action": action, "type": kind, "goal": goal }));
        assert_eq!(sent["accepted"], true, "goal {round} from {from}");
        let id = sent["goal"].clone();
        let result = peer.ask("result", json!({ "goal": id, "timeout": PATIENCE.as_secs() }));
        assert_eq!(result["status"], 4, "{result}");
    }
    drop(peer);
    cell.stop();
}

#[test]
fn a_goal_ends_by_cancel_by_deactivation_and_runs_at_the_scaling_that_is_asked() {
    let cell = Cell::start(&[]);
    let (follower, log) = (Follower::new(&cell), LogLines::subscribe(&cell));
    let state = "axis_interpolator/controller_state";
    let state = Watched::<JointTrajectoryControllerState>::new(&cell, state, &Qos::default_topic());
    let scaling: Publisher<SpeedScalingFactor> =
        cell.client.node.publisher("axis_interpolator/speed_scaling_input", &Qos::latched(1)).expect("a publisher");
    assert!(scaling.wait_matched(1, PATIENCE));
    let far = follower.moving(goal(to("z_axis", 0.3, 4000.0)));
    let fast = state.until("it moves", |state| state.reference.velocities[2] > 1e-6);
    scaling.publish(&SpeedScalingFactor { factor: 0.25 }).expect("published");
    let slow = state.until("a quarter of the speed", |state| (state.speed_scaling_factor - 0.25).abs() < 1e-9);
    assert!(slow.reference.positions[2] >= fast.reference.positions[2]);
    scaling.publish(&SpeedScalingFactor { factor: 1.5 }).expect("published");
    log.line(&["speed scaling 1.5 ignored"]);
    assert_eq!(far.cancel(PATIENCE).expect("an answer"), CancelOutcome::Accepted);
    let (status, code, _) = result(&far);
    assert_eq!((status, code), (GoalStatus::Canceled, Codes::SUCCESSFUL));
    state.until("at rest", |state| state.feedback.velocities.iter().all(|velocity| *velocity == 0.0));

    let far = follower.moving(goal(to("z_axis", 0.0, 4000.0)));
    let transition = |id: u8| {
        let mut request = ChangeStateRequest::default();
        request.transition.id = id;
        cell.client.call::<ChangeState>("axis_interpolator/change_state", &request).success
    };
    assert!(transition(4), "deactivate");
    let (status, code, text) = result(&far);
    assert_eq!((status, code), (GoalStatus::Aborted, Codes::INVALID_GOAL));
    assert!(text.contains("deactivated"), "{text}");
    assert!(!follower.send(goal(to("z_axis", 0.0, 9.0))).accepted());
    log.line(&["rejected", "the node is not active"]);
    assert!(transition(3), "activate");
    assert_eq!(result(&follower.send(goal(to("z_axis", 0.0, 9.0)))).0, GoalStatus::Succeeded);
    cell.stop();
}

/// With the clock, as a real machine: one goal after the other, each begins though the axes still settle from the one before.
#[test]
fn goals_follow_each_other_at_pace_realtime() {
    let cell = Cell::start_realtime(&[]);
    let follower = Follower::new(&cell);
    let joints = Watched::<JointState>::new(&cell, "joint_states", &Qos::default_topic());
    for (place, time_s) in [(0.02, 0.7), (0.0, 0.6), (0.01, 0.5)] {
        let (status, _, text) = result(&follower.send(goal(to("z_axis", place, time_s))));
        assert_eq!(status, GoalStatus::Succeeded, "{text}");
        joints.until("it is there", |joints| (position(joints, "z_axis") - place).abs() < 1e-4);
    }
    cell.stop();
}
