// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Requested joint trajectory with its tolerances, read and checked by the rules of
//! `control_msgs/action/FollowJointTrajectory`.

use super::settings::TrajectorySettings;
use camwright::interpolator::join::StartTolerance;
use camwright::interpolator::tolerance::{FollowingTolerances, Tolerance};
use camwright::interpolator::trajectory::{TrajectoryPoint, TrajectoryStart};
use camwright::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use camwright_files::convert::core_from_si;
use camwright_files::convert::motion_record::MotionRecord;
use camwright_files::convert::time::{TickClock, ns_from_duration, ns_from_time};
use camwright_msgs::control_msgs::action::FollowJointTrajectoryGoal;
use camwright_msgs::control_msgs::msg::JointTolerance;
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};

/// Value of `goal_time_tolerance` that removes the limit: -1 s.
const UNLIMITED_NS: i64 = -1_000_000_000;

/// A joint trajectory that may be followed, as far as can be said without knowing where it begins.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RequestedTrajectory {
    joints: Vec<Axis>,
    points: Vec<TrajectoryPoint>,
    /// When its time begins (ns); `None`: when it begins.
    stamp_ns: Option<i64>,
    tolerances: FollowingTolerances,
    start_tolerance: StartTolerance,
}

impl RequestedTrajectory {
    /// Reads a goal of `~/follow_joint_trajectory`; `now_ns` is the time of the machine.
    pub(super) fn from_goal(
        goal: &FollowJointTrajectoryGoal,
        settings: &TrajectorySettings,
        machine: &MachineDescription,
        now_ns: i64,
    ) -> Result<Self, String> {
        let multi_dof = &goal.multi_dof_trajectory;
        if !multi_dof.joint_names.is_empty() || !multi_dof.points.is_empty() {
            return Err("the machine has no multi-dof joints".into());
        }
        if !goal.component_path_tolerance.is_empty() || !goal.component_goal_tolerance.is_empty() {
            return Err("the machine has no multi-dof joints, whose components could be given tolerances".into());
        }
        let mut wanted = Self::from_trajectory(&goal.trajectory, settings, machine, now_ns)?;
        tolerances("path_tolerance", &goal.path_tolerance, &mut wanted.tolerances.path)?;
        tolerances("goal_tolerance", &goal.goal_tolerance, &mut wanted.tolerances.goal)?;
        let goal_time_ns = ns_from_duration(&goal.goal_time_tolerance);
        match goal_time_ns {
            0 => {}
            UNLIMITED_NS => wanted.tolerances.goal_time_ticks = None,
            1.. => wanted.tolerances.goal_time_ticks = Some(ticks(seconds(goal_time_ns), machine)),
            _ => {
                return Err(format!(
                    "goal_time_tolerance is {} s; allowed: a positive time, 0 for the default, -1 for unlimited",
                    seconds(goal_time_ns)
                ));
            }
        }
        Ok(wanted)
    }

    /// Reads a trajectory without tolerances of its own.
    pub(super) fn from_trajectory(
        message: &JointTrajectory,
        settings: &TrajectorySettings,
        machine: &MachineDescription,
        now_ns: i64,
    ) -> Result<Self, String> {
        let joints = message
            .joint_names
            .iter()
            .map(|joint| Axis::from_joint(joint).ok_or_else(|| format!("there is no joint {joint:?}")))
            .collect::<Result<Vec<Axis>, String>>()?;
        if let Some(left_out) = Axis::ALL.into_iter().find(|axis| !settings.allow_partial && !joints.contains(axis)) {
            return Err(format!("{} is not named, and allow_partial_joints_goal is false", left_out.joint()));
        }
        if let Some(index) = message.points.iter().position(|point| !point.effort.is_empty()) {
            return Err(format!("point {index} gives efforts, the machine takes positions"));
        }
        let points: Vec<TrajectoryPoint> = message.points.iter().map(|point| core_point(point, &joints)).collect();
        // Joints that the goal does not move are not checked, unless a tolerance names them.
        let of_named = |all: &[Tolerance; AXIS_COUNT]| {
            Axis::ALL.map(|axis| if joints.contains(&axis) { all[axis.index()] } else { Tolerance::default() })
        };
        let (path, goal) = (of_named(&settings.path), of_named(&settings.goal));
        let stamp_ns = Some(ns_from_time(&message.header.stamp)).filter(|ns| *ns != 0);
        let wanted = Self {
            joints,
            points,
            stamp_ns,
            tolerances: FollowingTolerances {
                path,
                goal,
                goal_time_ticks: settings.goal_time_s.map(|time_s| ticks(time_s, machine)),
            },
            start_tolerance: settings.start,
        };
        wanted.must_not_be_over(now_ns)?;
        Ok(wanted)
    }

    /// A trajectory of which all lies in the past.
    fn must_not_be_over(&self, now_ns: i64) -> Result<(), String> {
        let (Some(stamp_ns), Some(last)) = (self.stamp_ns, self.points.last()) else { return Ok(()) };
        let over_s = seconds(now_ns.saturating_sub(stamp_ns)) - last.time_s;
        if over_s > 0.0 {
            return Err(format!("the trajectory ended {over_s:.3} s ago, by the stamp of its header"));
        }
        Ok(())
    }

    /// The first tick that it may begin with, if it can begin with `soonest`.
    pub(super) fn begins(&self, soonest: u64, clock: TickClock) -> u64 {
        let Some(stamp_ns) = self.stamp_ns else { return soonest };
        let cycle_ns = i64::from(clock.cycle_time_ns.max(1));
        let since = stamp_ns.saturating_sub(clock.epoch_ns);
        // The first tick that is not before the stamp.
        u64::try_from(since.saturating_add(cycle_ns - 1) / cycle_ns).unwrap_or(0).max(soonest)
    }

    /// The trajectory that begins with a tick; of one that should have begun before that is what is left.
    pub(super) fn record(
        &self,
        tick: u64,
        clock: TickClock,
        start: &TrajectoryStart,
        starts_at: Option<u64>,
    ) -> Result<MotionRecord, String> {
        let late_s = self.stamp_ns.map_or(0.0, |stamp_ns| seconds(clock.ns(tick).saturating_sub(stamp_ns)));
        // One that begins with the first tick after its stamp begins on time, with its first point.
        let is_on_time = late_s < f64::from(clock.cycle_time_ns) * 1e-9;
        let left = |(index, point): (usize, &TrajectoryPoint)| {
            let is_first = index == 0 && is_on_time && point.time_s == 0.0;
            let time_s = if is_first { 0.0 } else { point.time_s - late_s };
            (is_first || time_s > 0.0).then(|| TrajectoryPoint { time_s, ..point.clone() })
        };
        let points: Vec<TrajectoryPoint> = match self.stamp_ns {
            None => self.points.clone(),
            Some(_) => self.points.iter().enumerate().filter_map(left).collect(),
        };
        self.must_not_be_over(clock.ns(tick))?;
        let tolerances = (&self.tolerances, &self.start_tolerance);
        Ok(MotionRecord::trajectory(&self.joints, &points, start, tolerances, starts_at))
    }

    /// It has a time of its own to begin at.
    pub(super) fn has_stamp(&self) -> bool {
        self.stamp_ns.is_some()
    }
}

fn seconds(ns: i64) -> f64 {
    ns as f64 * 1e-9
}

#[allow(clippy::cast_possible_truncation, reason = "a time is not negative, the cast saturates")]
fn ticks(time_s: f64, machine: &MachineDescription) -> u64 {
    (time_s / machine.cycle_time_s()).ceil() as u64
}

/// The tolerances of a goal over the defaults.
fn tolerances(field: &str, asked: &[JointTolerance], over: &mut [Tolerance; AXIS_COUNT]) -> Result<(), String> {
    for tolerance in asked {
        let axis = Axis::from_joint(&tolerance.name)
            .ok_or_else(|| format!("{field} names {:?}, and there is no such joint", tolerance.name))?;
        if tolerance.acceleration > 0.0 {
            return Err(format!(
                "{field} of {} limits the error of acceleration, which the machine does not measure; 0 or -1",
                axis.joint()
            ));
        }
        let value = |value: f64| if value > 0.0 { core_from_si(axis, value) } else { value };
        let values = [tolerance.position, tolerance.velocity, tolerance.acceleration].map(value);
        let place = &mut over[axis.index()];
        *place = place.requested(axis, values).map_err(|error| format!("{field}: {error}"))?;
    }
    Ok(())
}

fn core_point(point: &JointTrajectoryPoint, joints: &[Axis]) -> TrajectoryPoint {
    let core = |values: &[f64]| -> Vec<f64> {
        // A list of the wrong length keeps it, so that the refusal can name it.
        let axes = joints.iter().copied().chain(std::iter::repeat(Axis::C));
        values.iter().zip(axes).map(|(value, axis)| core_from_si(axis, *value)).collect()
    };
    TrajectoryPoint {
        time_s: seconds(ns_from_duration(&point.time_from_start)),
        positions: core(&point.positions),
        velocities: core(&point.velocities),
        accelerations: core(&point.accelerations),
    }
}
