//! Trajectories of other ROS clients: the action `~/follow_joint_trajectory` and the topic `~/joint_trajectory`.

use super::goals::Goal;
use super::{Shared, lock};
use crate::convert::core_from_si;
use crate::convert::time::ns_from_duration;
use crate::ros::{ActionHandler, GoalDecision, GoalHandle, GoalId, Qos, RosError, Subscription};
use camwright::interpolator::trajectory::{Trajectory, TrajectoryPoint};
use camwright::interpolator::{Motion, Request};
use camwright::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use camwright_msgs::control_msgs::action::{FollowJointTrajectory, FollowJointTrajectoryGoal};
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};
use std::sync::Arc;

/// Serves `~/follow_joint_trajectory`.
#[derive(Debug)]
pub(super) struct Handler(pub(super) Arc<Shared>);

impl ActionHandler<FollowJointTrajectory> for Handler {
    fn goal(&mut self, _id: GoalId, goal: &FollowJointTrajectoryGoal) -> GoalDecision {
        if let Some(reason) = self.0.obstacle() {
            return GoalDecision::Reject(reason);
        }
        if !goal.multi_dof_trajectory.joint_names.is_empty() || !goal.component_path_tolerance.is_empty() {
            return GoalDecision::Reject("the machine has no multi-dof joints".into());
        }
        match self.0.trajectory(&goal.trajectory) {
            Ok(_) => GoalDecision::Accept,
            Err(reason) => GoalDecision::Reject(reason),
        }
    }

    fn accepted(&mut self, handle: GoalHandle<FollowJointTrajectory>) {
        let trajectory = self.0.trajectory(&handle.goal().trajectory);
        lock(&self.0.served).begin(Goal::Trajectory(handle), "a joint trajectory".into(), String::new());
        match trajectory {
            Ok(trajectory) => self.0.begin(Motion::Trajectory(trajectory)),
            Err(reason) => lock(&self.0.served).refuse(&reason),
        }
    }

    fn cancel(&mut self, _id: GoalId) -> bool {
        self.0.request(Request::Cancel)
    }
}

/// Takes trajectories from the topic; what is refused is told in the log.
pub(super) fn subscribe(shared: &Arc<Shared>) -> Result<Subscription, RosError> {
    let this = Arc::clone(shared);
    shared.node.subscribe::<JointTrajectory>("~/joint_trajectory", &Qos::default_topic(), move |message, _| {
        let outcome = match this.obstacle() {
            Some(reason) => Err(reason),
            None => this.trajectory(&message),
        };
        match outcome {
            Ok(trajectory) => {
                lock(&this.served).begin(Goal::Topic, "a joint trajectory of the topic".into(), String::new());
                this.begin(Motion::Trajectory(trajectory));
            }
            Err(reason) => this.node.logger().warn(&format!("joint trajectory refused: {reason}")),
        }
    })
}

impl Shared {
    /// The trajectory of a message, beginning where the axes rest.
    fn trajectory(&self, message: &JointTrajectory) -> Result<Trajectory, String> {
        let machine = self.machine().ok_or("the machine has not been heard of yet")?;
        let joints = message
            .joint_names
            .iter()
            .map(|joint| Axis::from_joint(joint).ok_or_else(|| format!("there is no joint {joint:?}")))
            .collect::<Result<Vec<Axis>, String>>()?;
        let points: Vec<TrajectoryPoint> = message.points.iter().map(|point| core_point(point, &joints)).collect();
        Trajectory::from_points(&joints, &points, self.rest(&machine), &machine).map_err(|error| error.to_string())
    }

    /// Where the axes rest (mm or rad).
    fn rest(&self, machine: &MachineDescription) -> [f64; AXIS_COUNT] {
        let counts = *lock(&self.rest_counts);
        let mut rest = [0.0; AXIS_COUNT];
        for axis in Axis::ALL {
            rest[axis.index()] = machine.axis(axis).scale.position(counts[axis.index()]);
        }
        rest
    }
}

fn core_point(point: &JointTrajectoryPoint, joints: &[Axis]) -> TrajectoryPoint {
    let core = |values: &[f64]| -> Vec<f64> {
        // A list of the wrong length keeps it, so that the refusal can name it.
        let axes = joints.iter().copied().chain(std::iter::repeat(Axis::C));
        values.iter().zip(axes).map(|(value, axis)| core_from_si(axis, *value)).collect()
    };
    #[allow(clippy::cast_precision_loss, reason = "durations are far below 2^53 ns")]
    let time_s = ns_from_duration(&point.time_from_start) as f64 * 1e-9;
    TrajectoryPoint {
        time_s,
        positions: core(&point.positions),
        velocities: core(&point.velocities),
        accelerations: core(&point.accelerations),
    }
}
