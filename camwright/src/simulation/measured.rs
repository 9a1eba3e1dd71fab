// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Readings of a real machine, which take the place of simulated drives, switches and wheel spindle.
//!
//! Supervision, zeros, alarms, stops and the part are those of the simulated machine. The readings of a tick belong to the setpoints of
//! some ticks before: those after them are on their way to the drives.
//!
//! ```text
//! tick   A ──────────────── lag ───────────────► S
//!        readings, report                        setpoint sent
//! ```

use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription, WheelDescription};
use crate::machine::drive::DriveSettings;
use crate::machine::setpoint::Input;

/// Longest lag between a setpoint and the readings that show it (ticks).
pub const MAX_LAG_TICKS: u32 = 500;

/// Levels of the wired inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WiredInputs {
    /// Origin detector of C.
    pub origin: bool,
    /// Bit i: the switch of station i is closed.
    pub stations: u64,
    /// Bit i: the home switch of axis i is closed.
    pub homes: u8,
    /// Bit i: a limit switch of axis i is closed, whichever end it is of.
    pub limits: u8,
    /// The wheel has its speed.
    pub wheel_at_speed: bool,
}

impl WiredInputs {
    /// Level of an input; `None` if this kind of input is not wired.
    #[must_use]
    pub fn level(&self, input: Input) -> Option<bool> {
        match input {
            Input::Origin => Some(self.origin),
            Input::Station(index) => Some(index < 64 && self.stations >> index & 1 == 1),
            Input::Home(axis) => Some(self.homes >> axis.index() & 1 == 1),
            Input::Index(_) | Input::SteadyForce | Input::WheelContact | Input::KeyWay | Input::SizeReached => None,
        }
    }

    /// Returns whether a limit switch of this axis is closed.
    #[must_use]
    pub fn limit(&self, axis: Axis) -> bool {
        self.limits >> axis.index() & 1 == 1
    }
}

/// Readings of one servo period.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measurement {
    /// True counts of the encoders, independent of the zeros.
    pub counts: [i64; AXIS_COUNT],
    pub inputs: WiredInputs,
    /// True count of the index mark that each encoder passed in this period.
    pub marks: [Option<i64>; AXIS_COUNT],
    /// Reading of the gauge, and of a second one (mm); `None` where a gauge does not measure.
    pub gauge_mm: [Option<f64>; 2],
}

/// Orders for the drives and the wheel after a tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveOrders {
    /// True position of each axis (counts).
    pub positions: [f64; AXIS_COUNT],
    /// Bit i: the drive of axis i is to have power.
    pub powered: u8,
    pub wheel_runs: bool,
    /// Speed of the wheel when it runs (rad/s).
    pub wheel_rad_s: f64,
}

/// The description as supervision needs it for real drives: they follow as they do, and what the simulation would add (lag, deflection,
/// growth, unbalance, wear) is in the readings already or unknown. The gauge remains: its readings are supervised.
pub(super) fn without_simulated_effects(description: &MachineDescription) -> MachineDescription {
    let mut real = description.clone();
    for axis in &mut real.axes {
        axis.drive = DriveSettings::IDEAL;
    }
    real.contact = None;
    real.thermal = None;
    real.gap_detector = None;
    real.key_way_probe = None;
    real.loading = None;
    real.retract.drawback_mm_s2 = 0.0;
    real.with_each_wheel(|wheel| WheelDescription { unbalance_mm: 0.0, grinding_ratio: None, ..wheel })
}
