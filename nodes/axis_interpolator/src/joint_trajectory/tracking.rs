// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Path following of joint trajectories: feedback of the goal, `~/controller_state`, and `~/query_state`.

use crate::engine_messages::Tracking;
use camwright::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use camwright::machine::setpoint::Setpoint;
use camwright_files::convert::setpoints::joint_names;
use camwright_files::convert::time::TickClock;
use camwright_files::convert::{si_from_core, si_from_counts};
use camwright_msgs::control_msgs::action::FollowJointTrajectoryFeedback;
use camwright_msgs::control_msgs::msg::JointTrajectoryControllerState;
use camwright_msgs::control_msgs::srv::QueryTrajectoryStateResponse;
use camwright_msgs::trajectory_msgs::msg::JointTrajectoryPoint;

/// Joints of some axes at a tick: setpoints, measured values, and the difference.
struct TrackedPoint {
    joints: Vec<String>,
    reference: JointTrajectoryPoint,
    actual: JointTrajectoryPoint,
    error: JointTrajectoryPoint,
}

impl TrackedPoint {
    fn from_tracking(tracking: &Tracking, axes: &[Axis], machine: &MachineDescription) -> Self {
        let per_axis = |value: &dyn Fn(Axis) -> f64| -> Vec<f64> { axes.iter().map(|axis| value(*axis)).collect() };
        let (setpoint, measured) = (&tracking.setpoint, &tracking.measured);
        let reference = point(setpoint, axes, machine);
        let actual = JointTrajectoryPoint {
            positions: per_axis(&|axis| si_from_counts(machine.axis(axis).scale, measured.counts[axis.index()])),
            velocities: per_axis(&|axis| si_from_core(axis, measured.velocity[axis.index()])),
            ..JointTrajectoryPoint::default()
        };
        let error = JointTrajectoryPoint {
            positions: per_axis(&|axis| {
                let counts = setpoint.counts[axis.index()] - measured.counts[axis.index()];
                si_from_counts(machine.axis(axis).scale, counts)
            }),
            velocities: per_axis(&|axis| {
                si_from_core(axis, setpoint.velocity[axis.index()] - measured.velocity[axis.index()])
            }),
            ..JointTrajectoryPoint::default()
        };
        Self { joints: names(axes), reference, actual, error }
    }
}

fn names(axes: &[Axis]) -> Vec<String> {
    axes.iter().map(|axis| axis.joint().to_owned()).collect()
}

/// A setpoint of some axes as a point of a trajectory.
fn point(setpoint: &Setpoint, axes: &[Axis], machine: &MachineDescription) -> JointTrajectoryPoint {
    let si = |values: &[f64; AXIS_COUNT]| axes.iter().map(|axis| si_from_core(*axis, values[axis.index()])).collect();
    let position = |axis: &Axis| si_from_counts(machine.axis(*axis).scale, setpoint.counts[axis.index()]);
    JointTrajectoryPoint {
        positions: axes.iter().map(position).collect(),
        velocities: si(&setpoint.velocity),
        accelerations: si(&setpoint.acceleration),
        ..JointTrajectoryPoint::default()
    }
}

/// Feedback of a goal about the joints that it names.
pub(crate) fn feedback(
    tracking: &Tracking,
    joints: &[String],
    machine: &MachineDescription,
    clock: TickClock,
) -> FollowJointTrajectoryFeedback {
    let axes: Vec<Axis> = joints.iter().filter_map(|joint| Axis::from_joint(joint)).collect();
    let followed = TrackedPoint::from_tracking(tracking, &axes, machine);
    let mut message = FollowJointTrajectoryFeedback {
        joint_names: followed.joints,
        desired: followed.reference,
        actual: followed.actual,
        error: followed.error,
        ..FollowJointTrajectoryFeedback::default()
    };
    message.header.stamp = clock.stamp(tracking.measured.tick);
    message
}

/// `~/controller_state` of all axes.
pub(crate) fn state(
    tracking: &Tracking,
    feed_override: f64,
    machine: &MachineDescription,
    clock: TickClock,
) -> JointTrajectoryControllerState {
    let followed = TrackedPoint::from_tracking(tracking, &Axis::ALL, machine);
    let mut message = JointTrajectoryControllerState {
        joint_names: followed.joints,
        output: followed.reference.clone(),
        reference: followed.reference,
        feedback: followed.actual,
        error: followed.error,
        speed_scaling_factor: feed_override,
        ..JointTrajectoryControllerState::default()
    };
    message.header.stamp = clock.stamp(tracking.measured.tick);
    message
}

/// The answer of `~/query_state`.
pub(crate) fn answer(setpoint: Option<&Setpoint>, machine: &MachineDescription) -> QueryTrajectoryStateResponse {
    let Some(setpoint) = setpoint else {
        let message = "no joint trajectory is executed at that time, or it is too long ago".to_owned();
        return QueryTrajectoryStateResponse { success: false, message, ..QueryTrajectoryStateResponse::default() };
    };
    let point = point(setpoint, &Axis::ALL, machine);
    QueryTrajectoryStateResponse {
        success: true,
        message: String::new(),
        name: joint_names(),
        position: point.positions,
        velocity: point.velocities,
        acceleration: point.accelerations,
    }
}
