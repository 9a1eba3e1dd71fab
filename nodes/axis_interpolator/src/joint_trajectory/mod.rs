// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Trajectories of other ROS clients: the action `~/follow_joint_trajectory`, the topic `~/joint_trajectory`, and the topics that report
//! their progress. They behave as in the joint trajectory controller of `ros2_control`. In addition, an error names the joint, the
//! tolerance, the amount and the time, and every end of a trajectory stops it on its path within the limits.

pub(super) mod arrival;
pub(super) mod settings;
pub(super) mod tracking;
mod wanted;

use super::engine_messages::{PreparedMotion, ToEngine};
use super::goals::{RunningGoal, by};
use super::{Shared, lock};
use arrival::TrajectoryArrival;
use camwright::interpolator::MotionRequest;
use camwright::interpolator::trajectory::TrajectoryStart;
use camwright::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use camwright_msgs::control_msgs::action::{FollowJointTrajectory, FollowJointTrajectoryGoal};
use camwright_msgs::control_msgs::msg::SpeedScalingFactor;
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use camwright_ros::{ActionHandler, GoalDecision, GoalHandle, GoalId, Guid, Qos, RosError, Subscription};
use settings::TrajectorySettings;
use std::sync::Arc;
use wanted::RequestedTrajectory;

/// Who has command while a trajectory of this kind is executed.
const OF_A_GOAL: &str = "a joint trajectory";
const OF_THE_TOPIC: &str = "a joint trajectory of the topic";

/// Zero octets after the feedback of `~/follow_joint_trajectory`, for clients of ROS 2 Kilted and later.
///
/// `control_msgs` 6.3 inserts `index` before the fields of joints with several degrees of freedom and appends `multi_dof_index`. The machine
/// has no such joints, so all octets from there on are zero: with eight more both definitions read the message, and `index` is 0.
pub(super) const FEEDBACK_TRAILING_ZEROS: usize = 8;

/// Serves `~/follow_joint_trajectory`.
#[derive(Debug)]
pub(super) struct Handler(pub(super) Arc<Shared>);

impl ActionHandler<FollowJointTrajectory> for Handler {
    fn goal(&mut self, _id: GoalId, goal: &FollowJointTrajectoryGoal) -> GoalDecision {
        match self.0.wanted_of(goal) {
            Err(reason) => GoalDecision::Reject(reason),
            Ok(wanted) if self.0.is_following() => {
                let (decider, decision) = GoalDecision::later();
                self.0.arrive(TrajectoryArrival { wanted, decider: Some(decider), name: OF_A_GOAL.into() });
                decision
            }
            Ok(wanted) => match self.0.obstacle().map_or_else(|| self.0.motion_from_rest(&wanted).map(drop), Err) {
                Ok(()) => GoalDecision::Accept,
                Err(reason) => GoalDecision::Reject(reason),
            },
        }
    }

    fn accepted(&mut self, handle: GoalHandle<FollowJointTrajectory>) {
        // One that took the place of another moves already.
        let Some(handle) = lock(&self.0.served).start_arrived(handle) else { return };
        let motion = self.0.wanted_of(handle.goal()).and_then(|wanted| match self.0.obstacle() {
            None => self.0.motion_from_rest(&wanted),
            Some(reason) => Err(reason),
        });
        if lock(&self.0.served).is_busy() {
            // Another client has begun since the goal was accepted.
            super::goals::refuse_trajectory(&handle, &motion.err().unwrap_or_default());
            return;
        }
        let name = by(OF_A_GOAL, handle.client());
        lock(&self.0.served).begin(RunningGoal::Trajectory(handle), name, String::new());
        self.0.begin_made(motion);
    }

    fn cancel(&mut self, _id: GoalId) -> bool {
        self.0.request(MotionRequest::Cancel)
    }
}

/// Subscribes to trajectories on the topic, whose refusals are logged, and to the scaling of their speed.
pub(super) fn subscribe(shared: &Arc<Shared>) -> Result<Vec<Subscription>, RosError> {
    let this = Arc::clone(shared);
    let trajectories = shared.node.subscribe::<JointTrajectory>(
        "~/joint_trajectory",
        &Qos::default_topic(),
        move |message, info| {
            if !this.grant.accepts("~/joint_trajectory", &info.writer, &this.node) {
                return;
            }
            if let Err(reason) = this.accept_from_topic(&message, &info.writer) {
                this.warn_of_refusal(&reason);
            }
        },
    )?;
    let this = Arc::clone(shared);
    let scaling = shared.node.subscribe::<SpeedScalingFactor>(
        "~/speed_scaling_input",
        &Qos::latched(1),
        move |message, info| {
            if !this.grant.accepts("~/speed_scaling_input", &info.writer, &this.node) {
                return;
            }
            let factor = message.factor;
            if !(0.0..=1.0).contains(&factor) {
                let text = format!(
                    "speed scaling {factor} ignored; allowed: 0 to 1: a trajectory may use its limits to the full"
                );
                this.node.warn_once("speed scaling out of 0 to 1 ignored", &text);
            } else if !this.request(MotionRequest::SetOverride(factor)) {
                let text = "speed scaling ignored: no message from the machine yet";
                this.node.warn_once(text, text);
            }
        },
    )?;
    Ok(vec![trajectories, scaling])
}

impl Shared {
    fn wanted_of(&self, goal: &FollowJointTrajectoryGoal) -> Result<RequestedTrajectory, String> {
        let machine = self.machine().ok_or("no message from the machine yet")?;
        RequestedTrajectory::from_goal(
            goal,
            &TrajectorySettings::from_parameters(self.node.parameters()),
            &machine,
            self.machine_time_ns(),
        )
    }

    fn accept_from_topic(&self, message: &JointTrajectory, writer: &Guid) -> Result<(), String> {
        let machine = self.machine().ok_or("no message from the machine yet")?;
        let settings = TrajectorySettings::from_parameters(self.node.parameters());
        let wanted = RequestedTrajectory::from_trajectory(message, &settings, &machine, self.machine_time_ns())?;
        let name = by(OF_THE_TOPIC, &self.node.who(writer));
        if self.is_following() {
            self.arrive(TrajectoryArrival { wanted, decider: None, name });
            return Ok(());
        }
        if let Some(reason) = self.obstacle() {
            return Err(reason);
        }
        self.begin_from_topic(&wanted, name)
    }

    fn begin_from_topic(&self, wanted: &RequestedTrajectory, name: String) -> Result<(), String> {
        let motion = self.motion_from_rest(wanted)?;
        lock(&self.served).begin(RunningGoal::Topic, name, String::new());
        self.begin_made(Ok(motion));
        Ok(())
    }

    /// Logs why a trajectory of the topic is refused. The same reason again is counted and reported every few seconds.
    pub(super) fn warn_of_refusal(&self, reason: &str) {
        let text = format!("joint trajectory refused: {reason}");
        self.node.warn_once(&text, &text);
    }

    /// A joint trajectory has command, and the node may move axes.
    fn is_following(&self) -> bool {
        self.is_active() && lock(&self.served).is_trajectory()
    }

    /// A trajectory arrives while another has command.
    fn arrive(&self, arrival: TrajectoryArrival) {
        let mut place = lock(&self.arrival);
        let refused = match (place.is_some(), self.clock()) {
            (true, _) => Some((arrival, "another trajectory is about to begin")),
            (false, None) => Some((arrival, "no message from the machine yet")),
            (false, Some(clock)) => {
                let soonest = arrival.begins(0, clock);
                *place = Some(arrival);
                drop(place);
                if !self.send(ToEngine::Foresee { soonest }) {
                    self.refuse_arrival("the engine does not take anything any more");
                }
                None
            }
        };
        if let Some((arrival, reason)) = refused
            && let Some(reason) = arrival.refuse(reason)
        {
            self.warn_of_refusal(&reason);
        }
    }

    /// Refuses the waiting trajectory.
    pub(super) fn refuse_arrival(&self, reason: &str) {
        let arrival = lock(&self.arrival).take();
        if let Some(reason) = arrival.and_then(|arrival| arrival.refuse(reason)) {
            self.warn_of_refusal(&reason);
        }
    }

    /// The waiting trajectory has replaced the one before it.
    pub(super) fn arrived(&self, tick: u64) {
        let Some(arrival) = lock(&self.arrival).take() else { return };
        let is_goal = arrival.decider.is_some();
        let name = &arrival.name;
        self.node.logger().info(&format!("{name} replaces the previous trajectory at tick {tick}"));
        lock(&self.served).yield_to(is_goal, name, tick);
        if let Some(decider) = arrival.decider {
            decider.accept();
        }
    }

    /// Nothing is executed any more: what waits may begin.
    pub(super) fn begin_arrival(&self) {
        let Some(arrival) = lock(&self.arrival).take() else { return };
        match (self.obstacle(), arrival) {
            (Some(reason), arrival) => {
                if let Some(reason) = arrival.refuse(&reason) {
                    self.warn_of_refusal(&reason);
                }
            }
            (None, TrajectoryArrival { decider: Some(decider), wanted, .. }) => match self.motion_from_rest(&wanted) {
                Ok(_) => decider.accept(),
                Err(reason) => decider.reject(&reason),
            },
            (None, TrajectoryArrival { decider: None, wanted, name }) => {
                if let Err(reason) = self.begin_from_topic(&wanted, name) {
                    self.warn_of_refusal(&reason);
                }
            }
        }
    }

    /// The motion that begins where the axes rest.
    fn motion_from_rest(&self, wanted: &RequestedTrajectory) -> Result<PreparedMotion, String> {
        self.hindrance()?;
        let machine = self.machine().ok_or("no message from the machine yet")?;
        let clock = self.clock().ok_or("no message from the machine yet")?;
        // Later than any tick that the engine can begin with at once.
        let soonest = self.machine_tick() + u64::from(machine.feedback_delay_ticks);
        let tick = wanted.begins(soonest, clock);
        let starts_at = wanted.has_stamp().then_some(tick);
        PreparedMotion::new(wanted.record(tick, clock, &self.rest(&machine), starts_at)?, None, &machine)
    }

    /// Rest position of the axes (mm or rad).
    fn rest(&self, machine: &MachineDescription) -> TrajectoryStart {
        let counts = *lock(&self.rest_counts);
        let mut rest = [0.0; AXIS_COUNT];
        for axis in Axis::ALL {
            rest[axis.index()] = machine.axis(axis).scale.position(counts[axis.index()]);
        }
        TrajectoryStart::at_rest(rest)
    }
}
