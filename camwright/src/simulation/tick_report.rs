// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Report of a machine tick.

use crate::machine::alarm::{ALARM_KINDS, Alarm, AlarmSeverity};
use crate::machine::description::AXIS_COUNT;
use crate::machine::setpoint::{Input, Latch};
use crate::math::fixed_list::FixedList;
use crate::simulation::turned_part::TurnedRemoval;
use crate::simulation::work_area::WorkAreaState;
use crate::simulation::workpiece::Removal;

/// Maximum number of edges in one tick; the dog passes one switch at a time, the headstock at most one mark.
pub const MAX_LATCHES: usize = 16;

/// State of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum MotionState {
    Off = 0,
    /// Every axis clamped at rest, no setpoint in this tick.
    Standstill = 1,
    /// Following setpoints, or settling on the last one.
    Running = 2,
    /// Coming to rest after an alarm.
    Stopping = 3,
    /// At rest after an alarm; needs a reset.
    Fault = 4,
}

/// One axis after a tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AxisReport {
    /// Setpoint (counts).
    pub setpoint_counts: i64,
    /// Reading of the encoder (counts).
    pub counts: i64,
    /// Reading of the encoder (mm or rad).
    pub position: f64,
    /// Velocity (mm/s or rad/s).
    pub velocity: f64,
    /// Mean force (N) or torque (N m) of the motor in this tick, positive in the positive direction of the axis, as its current shows it.
    /// It accelerates the axis, overcomes friction, and holds against the wheel's force on the part.
    pub effort: f64,
    /// Setpoint minus actual (mm or rad), finer than a count.
    pub following_error: f64,
    /// Clamped at its resting setpoint.
    pub is_at_rest: bool,
    /// Its zero is known.
    pub is_homed: bool,
    /// Its drive has power.
    pub is_powered: bool,
}

/// Inputs and outputs after a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct IoState {
    /// The origin detector sees its mark.
    pub origin: bool,
    /// Bit i: the switch of station i is closed.
    pub stations: u64,
    /// Bit i: the input i of [`Input::OTHERS`] is closed.
    pub others: u8,
    /// Hard limit of the wheelhead towards the part.
    pub overtravel_x_min: bool,
    /// Hard limit of the wheelhead away from the part.
    pub overtravel_x_max: bool,
    /// Hard limit of the table, negative end.
    pub overtravel_z_min: bool,
    /// Hard limit of the table, positive end.
    pub overtravel_z_max: bool,
    pub estop: bool,
    pub drives_on: bool,
    /// The wheel has its surface speed.
    pub wheel_running: bool,
    /// A part is between the centres.
    pub part_present: bool,
}

impl IoState {
    /// Returns whether input `index` of [`Input::OTHERS`] is closed.
    #[must_use]
    pub fn other(&self, index: usize) -> bool {
        index < Input::OTHERS.len() && self.others >> index & 1 == 1
    }

    /// Returns whether the switch of station `index` is closed.
    #[must_use]
    pub fn station(&self, index: usize) -> bool {
        index < 64 && self.stations >> index & 1 == 1
    }
}

/// Report of a machine tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TickReport {
    /// The tick that was executed.
    pub tick: u64,
    /// The axes, in the order of the setpoint.
    pub axes: [AxisReport; AXIS_COUNT],
    /// Edges caught, in order.
    pub latches: FixedList<Latch, MAX_LATCHES>,
    /// Inputs and outputs at the end of the tick.
    pub io: IoState,
    /// Alarms raised in this tick or since the one before.
    pub raised: FixedList<Alarm, ALARM_KINDS>,
    /// State of the motion.
    pub motion: MotionState,
    /// Index of the lobe that stands in front of the wheel.
    pub lobe: Option<usize>,
    /// Material removed by the wheel; for a lathe, material removed by the insert per width of the insert.
    pub removal: Removal,
    /// Material removed by a lathe's insert, and its deepest position.
    pub turned: TurnedRemoval,
    /// Normal force of the wheel on the part at the end of the tick (N); 0 on a rigid machine, where it is unknown.
    pub normal_force_n: f64,
    /// Reading of the gauge at the lobe in front of the wheel (mm), and of a second gauge, while C turns.
    pub gauge_mm: [Option<f64>; 2],
    /// Speed of the wheel (rad/s).
    pub wheel_rad_s: f64,
    /// Door, chuck and sensors of a machine that is loaded.
    pub work_area: Option<WorkAreaState>,
}

impl TickReport {
    /// First alarm of this tick that stops the motion.
    #[must_use]
    pub fn stopping_alarm(&self) -> Option<Alarm> {
        self.raised.iter().find(|alarm| alarm.kind.entry().severity > AlarmSeverity::Warning).copied()
    }
}
