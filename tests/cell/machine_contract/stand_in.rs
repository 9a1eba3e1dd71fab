// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! In the place of `ros2_control`'s `joint_trajectory_controller` with drives that follow: it samples the newest trajectory at its own time,
//! by the spline through the positions, velocities and accelerations of two points, from where it was where the first point lies ahead, and
//! says 200 times a second where it is.
#![allow(missing_debug_implementations, reason = "as above")]
#![allow(unreachable_pub, reason = "a module of test binaries has no outside")]

use camwright_msgs::control_msgs::msg::JointTrajectoryControllerState;
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};
use camwright_ros::{Node, NodeOptions, Qos, RosArgs, SpinThread, Subscription, TimerHandle};
use std::sync::{Arc, Mutex};
use std::time::Duration;

const JOINTS: [&str; 3] = ["c_axis", "x_axis", "z_axis"];
/// Position of the axes after power-up (rad, m).
const START: [f64; 3] = [0.0, 0.15, 0.0];

/// Place, velocity and acceleration of the three axes at a time (ns).
#[derive(Clone, Copy)]
struct Point {
    ns: i64,
    state: [[f64; 3]; 3],
}

struct Controller {
    /// Points of the current trajectory in the order of their times, the first being the position at its arrival.
    points: Vec<Point>,
    now: Point,
}

pub struct StandIn {
    node: Node,
    controller: Arc<Mutex<Controller>>,
    _subscription: Subscription,
    _timer: TimerHandle,
    _spin: SpinThread,
}

impl StandIn {
    pub fn start(args: &RosArgs, name: &str) -> Self {
        let node = Node::new(NodeOptions::new(name, args)).expect("a node");
        let start = Point { ns: node.now_ns(), state: [START, [0.0; 3], [0.0; 3]] };
        let controller = Arc::new(Mutex::new(Controller { points: vec![start], now: start }));
        let (followed, publishing) = (Arc::clone(&controller), Arc::clone(&controller));
        let clock = node.clone();
        let qos = Qos::default_topic();
        let subscription = node.subscribe("~/joint_trajectory", &qos, move |trajectory: JointTrajectory, _| {
            followed.lock().expect("not poisoned").follow(&trajectory, clock.now_ns());
        });
        let publisher =
            node.publisher::<JointTrajectoryControllerState>("~/controller_state", &qos).expect("a publisher");
        let clock = node.clone();
        let timer = node.timer(Duration::from_millis(5), move || {
            let state = publishing.lock().expect("not poisoned").update(clock.now_ns());
            let mut message = JointTrajectoryControllerState {
                joint_names: JOINTS.map(str::to_owned).to_vec(),
                ..Default::default()
            };
            message.header.stamp = camwright_files::convert::time::time_from_ns(state.ns);
            let [positions, velocities, accelerations] = state.state.map(|values| values.to_vec());
            message.feedback = JointTrajectoryPoint { positions, velocities, accelerations, ..Default::default() };
            publisher.publish(&message).expect("it can be said");
        });
        let spin = node.spin_in_thread().expect("a thread");
        Self { node, controller, _subscription: subscription.expect("a subscription"), _timer: timer, _spin: spin }
    }

    /// Position of the axes.
    pub fn position(&self) -> [f64; 3] {
        self.controller.lock().expect("not poisoned").now.state[0]
    }

    pub fn stop(self) {
        self.node.shutdown();
    }
}

impl Controller {
    fn follow(&mut self, trajectory: &JointTrajectory, now_ns: i64) {
        assert_eq!(trajectory.joint_names, JOINTS, "the controller's joints");
        let begin = i64::from(trajectory.header.stamp.sec) * 1_000_000_000 + i64::from(trajectory.header.stamp.nanosec);
        let after = |point: &JointTrajectoryPoint| {
            i64::from(point.time_from_start.sec) * 1_000_000_000 + i64::from(point.time_from_start.nanosec)
        };
        let array = |values: &[f64]| <[f64; 3]>::try_from(values).expect("three of each");
        let points = trajectory.points.iter().map(|point| Point {
            ns: begin + after(point),
            state: [array(&point.positions), array(&point.velocities), array(&point.accelerations)],
        });
        let points: Vec<Point> = points.collect();
        let last = points.last().expect("points");
        // As the real one does: what is over, and what does not end at rest, is refused.
        assert!(last.ns > now_ns, "a trajectory ended {} ns ago", now_ns - last.ns);
        assert!(
            last.state[1].iter().all(|velocity| velocity.abs() < f64::MIN_POSITIVE),
            "a trajectory ends with the velocity {:?}",
            last.state[1]
        );
        self.update(now_ns);
        let is_ahead = self.now.ns < points[0].ns;
        self.points = is_ahead.then_some(self.now).into_iter().chain(points).collect();
    }

    fn update(&mut self, ns: i64) -> Point {
        let after = self.points.partition_point(|point| point.ns <= ns);
        self.now = match (after.checked_sub(1).and_then(|at| self.points.get(at)), self.points.get(after)) {
            (Some(before), Some(after)) => quintic(before, after, ns),
            (Some(before), None) => Point { state: [before.state[0], [0.0; 3], [0.0; 3]], ..*before },
            (None, _) => self.now,
        };
        self.now.ns = ns;
        self.now
    }
}

/// The polynomial of degree five through two points.
fn quintic(one: &Point, other: &Point, ns: i64) -> Point {
    let seconds = |ns: i64| ns as f64 * 1e-9;
    let (t, h) = (seconds(ns - one.ns), seconds(other.ns - one.ns));
    let mut at = Point { ns, state: [[0.0; 3]; 3] };
    for axis in 0..3 {
        let [p0, v0, a0] = one.state.map(|values| values[axis]);
        let [p1, v1, a1] = other.state.map(|values| values[axis]);
        let (d, w, b) = (p1 - p0 - v0 * h - 0.5 * a0 * h * h, (v1 - v0 - a0 * h) * h, (a1 - a0) * h * h);
        let c = [10.0 * d - 4.0 * w + 0.5 * b, -15.0 * d + 7.0 * w - b, 6.0 * d - 3.0 * w + 0.5 * b];
        let u = t / h;
        let (u2, u3) = (u * u, u * u * u);
        at.state[0][axis] = p0 + v0 * t + 0.5 * a0 * t * t + u3 * (c[0] + c[1] * u + c[2] * u2);
        at.state[1][axis] = v0 + a0 * t + u2 / h * (3.0 * c[0] + 4.0 * c[1] * u + 5.0 * c[2] * u2);
        at.state[2][axis] = a0 + u / (h * h) * (6.0 * c[0] + 12.0 * c[1] * u + 20.0 * c[2] * u2);
    }
    at
}
