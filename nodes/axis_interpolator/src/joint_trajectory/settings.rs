// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Parameters of following joint trajectories; their names and meanings are those of the joint trajectory controller of `ros2_control`.

use camwright::interpolator::join::StartTolerance;
use camwright::interpolator::tolerance::Tolerance;
use camwright::machine::description::{AXIS_COUNT, Axis};
use camwright_files::convert::core_from_si;
use camwright_ros::{Parameter, Parameters};

/// Parameter that permits goals without all joints.
const PARTIAL: &str = "allow_partial_joints_goal";
const FEEDBACK_RATE: &str = "action_monitor_rate";
const STATE_RATE: &str = "state_publish_rate";
const GOAL_TIME: &str = "constraints.goal_time";
/// Meaning of a goal time of 0, which the controller changed with ROS 2 Lyrical.
const ZERO_IS_UNLIMITED: &str = "constraints.goal_time_zero_is_unlimited";
const STOPPED: &str = "constraints.stopped_velocity_tolerance";
/// Largest distance of a linear, of a rotary axis from the first point of its trajectory.
const START_LINEAR: &str = "start_tolerance_m";
const START_ROTARY: &str = "start_tolerance_rad";

/// Every parameter, at its default.
pub(crate) fn parameters() -> Vec<Parameter> {
    let mut all = vec![
        Parameter::bool(PARTIAL, true).describe("a trajectory may name some of the joints; the others stay at rest"),
        Parameter::double(FEEDBACK_RATE, 20.0)
            .describe("rate of feedback of follow_joint_trajectory in machine time (Hz)")
            .range(1.0, 1000.0),
        Parameter::double(STATE_RATE, 50.0)
            .describe("rate of ~/controller_state in machine time (Hz), at most the rate of machine/stream; 0: never")
            .range(0.0, 1000.0),
        Parameter::double(GOAL_TIME, 0.0)
            .describe(
                "maximum time from the end of a trajectory until its goal tolerances are met (s); negative: unlimited; \
                 0: see constraints.goal_time_zero_is_unlimited",
            )
            .range(-1.0, 3600.0),
        Parameter::bool(ZERO_IS_UNLIMITED, true).describe(
            "meaning of constraints.goal_time 0: true: unlimited, as in ROS 2 Jazzy and Kilted; false: tolerances must be met at the \
             end of the trajectory, as in Lyrical",
        ),
        Parameter::double(STOPPED, 0.01)
            .describe("maximum speed of a stopped joint at the end of a trajectory (m/s or rad/s); 0: not checked")
            .range(0.0, 100.0),
        Parameter::double(START_LINEAR, 0.0005)
            .describe("maximum distance of a linear axis from a first point at time 0 (m); 0: the same encoder count")
            .range(0.0, 0.01),
        Parameter::double(START_ROTARY, 0.01)
            .describe("maximum distance of a rotary axis from a first point at time 0 (rad); 0: the same encoder count")
            .range(0.0, 0.1),
    ];
    for axis in Axis::ALL {
        let unit = if axis == Axis::C { "rad" } else { "m" };
        let tolerance = |what: &str, when: &str| {
            Parameter::double(&format!("constraints.{}.{what}", axis.joint()), 0.0)
                .describe(&format!("position tolerance of {} {when} ({unit}); 0: not checked", axis.joint()))
                .range(0.0, 1000.0)
        };
        all.push(tolerance("trajectory", "on the path"));
        all.push(tolerance("goal", "at the end"));
    }
    all
}

/// Present values of the parameters.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TrajectorySettings {
    pub(super) allow_partial: bool,
    /// Tolerances of a goal that names none.
    pub(super) path: [Tolerance; AXIS_COUNT],
    pub(super) goal: [Tolerance; AXIS_COUNT],
    /// s; `None`: as long as it takes.
    pub(super) goal_time_s: Option<f64>,
    pub(super) start: StartTolerance,
}

impl TrajectorySettings {
    pub(super) fn from_parameters(parameters: &Parameters) -> Self {
        let some = |value: f64| (value > 0.0).then_some(value);
        let of_axis = |axis: Axis, what: &str| {
            some(core_from_si(axis, parameters.double(&format!("constraints.{}.{what}", axis.joint()))))
        };
        let (mut path, mut goal) = ([Tolerance::default(); AXIS_COUNT], [Tolerance::default(); AXIS_COUNT]);
        for axis in Axis::ALL {
            path[axis.index()].position = of_axis(axis, "trajectory");
            goal[axis.index()].position = of_axis(axis, "goal");
            goal[axis.index()].velocity = some(core_from_si(axis, parameters.double(STOPPED)));
        }
        let start = Axis::ALL.map(|axis| {
            let name = if axis == Axis::C { START_ROTARY } else { START_LINEAR };
            core_from_si(axis, parameters.double(name))
        });
        Self {
            allow_partial: parameters.bool(PARTIAL),
            path,
            goal,
            goal_time_s: goal_time_s(parameters.double(GOAL_TIME), parameters.bool(ZERO_IS_UNLIMITED)),
            start: StartTolerance(start),
        }
    }
}

/// Maximum time from the end of a trajectory until its goal tolerances are met (s); `None`: unlimited.
fn goal_time_s(value_s: f64, zero_is_unlimited: bool) -> Option<f64> {
    (value_s > 0.0 || (value_s == 0.0 && !zero_is_unlimited)).then_some(value_s)
}

/// Ticks between two messages of feedback, and of `~/controller_state`; `None`: never.
pub(crate) fn periods_ticks(parameters: &Parameters, cycle_s: f64) -> (u64, Option<u64>) {
    #[allow(clippy::cast_possible_truncation, reason = "rates are between 1 and 1000 Hz")]
    let ticks = |rate_hz: f64| (1.0 / (rate_hz * cycle_s)).round().max(1.0) as u64;
    let state_hz = parameters.double(STATE_RATE);
    (ticks(parameters.double(FEEDBACK_RATE)), (state_hz > 0.0).then(|| ticks(state_hz.max(1e-3))))
}
