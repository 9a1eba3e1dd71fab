// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Setpoint chunks as joint trajectories, and back.
//!
//! A chunk is a `trajectory_msgs/JointTrajectory` whose stamp is the tick of its first point. Its dense part has one
//! point per tick; then come the points of a stop within limits, several ticks apart, that is used only if no further
//! chunk arrives. A chunk without such a stop, at rest at its last point, is the end of the motion.

use super::time::{TickClock, duration_from_ns, ns_from_duration};
use super::{core_from_si, counts_from_si, si_from_core, si_from_counts};
use camwright::interpolator::Interpolator;
use camwright::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use camwright::machine::setpoint::{Setpoint, StopPoint};
use camwright::simulation::buffer::{Chunk, TailPoint};
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};
use thiserror::Error;

/// A chunk of setpoints that owns its points.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChunkBuffer {
    /// Tick of the first setpoint.
    pub first_tick: u64,
    /// Setpoints of successive ticks, at least one.
    pub dense: Vec<Setpoint>,
    /// The stop that follows if no further chunk arrives.
    pub tail: Vec<TailPoint>,
    /// The motion ends with this chunk.
    pub is_final: bool,
}

impl ChunkBuffer {
    /// The chunk as the machine's buffer takes it.
    #[must_use]
    pub fn as_chunk(&self) -> Chunk<'_> {
        Chunk { first_tick: self.first_tick, dense: &self.dense, tail: &self.tail, is_final: self.is_final }
    }

    /// Empties it and keeps its room.
    pub fn clear(&mut self) {
        self.dense.clear();
        self.tail.clear();
        self.is_final = false;
    }
}

/// Why a trajectory is no chunk.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ChunkMessageError {
    /// Joints are not those of the machine.
    #[error("joints are {found:?}, the machine takes {wanted:?}")]
    Joints {
        /// Joints of the trajectory.
        found: Vec<String>,
        /// Joints of the machine.
        wanted: Vec<String>,
    },
    /// The stamp is not that of a tick.
    #[error("stamp {sec}.{nanosec:09} is not the time of a tick")]
    Stamp { sec: i32, nanosec: u32 },
    /// A point is not what it should be.
    #[error("point {index}: {what}")]
    Point {
        /// Index of the point.
        index: usize,
        what: String,
    },
}

/// Joint names in the order of the setpoint's values.
#[must_use]
pub fn joint_names() -> Vec<String> {
    Axis::ALL.iter().map(|axis| axis.joint().to_owned()).collect()
}

fn per_axis(values: impl Fn(usize, Axis) -> f64) -> Vec<f64> {
    Axis::ALL.iter().map(|axis| values(axis.index(), *axis)).collect()
}

/// A chunk as a joint trajectory.
#[must_use]
pub fn trajectory_from_chunk(chunk: &ChunkBuffer, machine: &MachineDescription, clock: TickClock) -> JointTrajectory {
    let cycle = i64::from(clock.cycle_time_ns);
    let point = |tick: u64, setpoint: &Setpoint| JointTrajectoryPoint {
        positions: per_axis(|i, axis| si_from_counts(machine.axis(axis).scale, setpoint.counts[i])),
        velocities: per_axis(|i, axis| si_from_core(axis, setpoint.velocity[i])),
        accelerations: per_axis(|i, axis| si_from_core(axis, setpoint.acceleration[i])),
        effort: Vec::new(),
        time_from_start: duration_from_ns(
            i64::try_from(tick.saturating_sub(chunk.first_tick)).unwrap_or(i64::MAX).saturating_mul(cycle),
        ),
    };
    let dense = (chunk.first_tick..).zip(&chunk.dense).map(|(tick, setpoint)| point(tick, setpoint));
    let tail = chunk.tail.iter().map(|tail| point(tail.tick, &tail.setpoint));
    let mut trajectory = JointTrajectory {
        joint_names: joint_names(),
        points: dense.chain(tail).collect(),
        ..JointTrajectory::default()
    };
    trajectory.header.stamp = clock.stamp(chunk.first_tick);
    trajectory
}

/// The chunk that a joint trajectory carries.
///
/// # Errors
/// Foreign joints, a stamp between ticks, points whose sizes, times or numbers make no chunk.
pub fn chunk_from_trajectory(
    trajectory: &JointTrajectory,
    machine: &MachineDescription,
    clock: TickClock,
) -> Result<ChunkBuffer, ChunkMessageError> {
    if trajectory.joint_names != joint_names() {
        return Err(ChunkMessageError::Joints { found: trajectory.joint_names.clone(), wanted: joint_names() });
    }
    let stamp = &trajectory.header.stamp;
    let first_tick = clock.tick(stamp).ok_or(ChunkMessageError::Stamp { sec: stamp.sec, nanosec: stamp.nanosec })?;
    let mut chunk = ChunkBuffer { first_tick, ..ChunkBuffer::default() };
    let mut previous: Option<u64> = None;
    for (index, point) in trajectory.points.iter().enumerate() {
        let refuse = |what: String| ChunkMessageError::Point { index, what };
        let since = point_tick(point, clock, previous).map_err(&refuse)?;
        let position = values("positions", &point.positions).map_err(&refuse)?;
        let mut setpoint = Setpoint {
            velocity: core_values(values("velocities", &point.velocities).map_err(&refuse)?),
            acceleration: core_values(values("accelerations", &point.accelerations).map_err(&refuse)?),
            ..Setpoint::default()
        };
        for axis in Axis::ALL {
            setpoint.counts[axis.index()] = counts_from_si(machine.axis(axis).scale, position[axis.index()]);
        }
        if chunk.tail.is_empty() && previous.is_none_or(|previous| since == previous + 1) {
            chunk.dense.push(setpoint);
        } else {
            chunk.tail.push(TailPoint { tick: first_tick.saturating_add(since), setpoint });
        }
        previous = Some(since);
    }
    chunk.is_final = chunk.tail.is_empty();
    Ok(chunk)
}

/// Ticks of a point after the first.
fn point_tick(point: &JointTrajectoryPoint, clock: TickClock, previous: Option<u64>) -> Result<u64, String> {
    let ns = ns_from_duration(&point.time_from_start);
    let cycle = i64::from(clock.cycle_time_ns);
    if cycle == 0 || ns < 0 || ns % cycle != 0 {
        return Err(format!("time_from_start is {ns} ns, not a multiple of the cycle time {cycle} ns"));
    }
    let tick = u64::try_from(ns / cycle).map_err(|error| error.to_string())?;
    match previous {
        None if tick != 0 => Err("time_from_start of the first point is not 0".into()),
        Some(previous) if tick <= previous => Err("time_from_start does not increase".into()),
        _ => Ok(tick),
    }
}

fn values(name: &str, values: &[f64]) -> Result<[f64; AXIS_COUNT], String> {
    let array: [f64; AXIS_COUNT] =
        values.try_into().map_err(|_| format!("{} {name}, the machine takes {AXIS_COUNT}", values.len()))?;
    match array.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(format!("{name} hold {value}")),
        None => Ok(array),
    }
}

fn core_values(si: [f64; AXIS_COUNT]) -> [f64; AXIS_COUNT] {
    let mut core = si;
    for axis in Axis::ALL {
        core[axis.index()] = core_from_si(axis, si[axis.index()]);
    }
    core
}
/// Setpoints of one chunk at most: with its stop it stays below 32 kB.
pub const CHUNK_TICKS: usize = 64;
/// Points of the stop that ends a chunk.
pub const STOP_POINTS: usize = 24;

/// The stop after a chunk's last tick, into room that there is for it.
pub fn add_stop(interpolator: &Interpolator, machine: &MachineDescription, last_tick: u64, chunk: &mut ChunkBuffer) {
    let mut points = [StopPoint::default(); STOP_POINTS];
    let count = interpolator.stop_tail(&mut points);
    for point in &points[..count] {
        let mut counts = [0; AXIS_COUNT];
        for axis in Axis::ALL {
            counts[axis.index()] = machine.axis(axis).scale.counts(point.position[axis.index()]);
        }
        let setpoint = Setpoint { counts, velocity: point.velocity, acceleration: point.acceleration };
        chunk.tail.push(TailPoint { tick: last_tick + u64::from(point.ticks), setpoint });
    }
    if count == 0 {
        // At rest already: a point of rest says that more will come.
        let counts = interpolator.setpoint().counts;
        chunk.tail.push(TailPoint { tick: last_tick + 2, setpoint: Setpoint { counts, ..Setpoint::default() } });
    }
}
