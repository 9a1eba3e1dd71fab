// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Power of the drives: mains, emergency stop, drive faults, orders.

use super::ResetRefused;
use crate::machine::description::{AXIS_COUNT, Axis};
use crate::machine::retract::AlarmRetract;

/// Power of the drives and what keeps it away.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Power {
    /// Axes whose drives have no power.
    dead: [bool; AXIS_COUNT],
    mains_lost: bool,
    /// Energy left when mains power lost (J).
    buffered_j: f64,
    drives_ordered: bool,
    powered: bool,
    power_off_due: bool,
    estop: bool,
    drive_faults: [bool; AXIS_COUNT],
}

snapshot_groups!(Power {
    keep_dead(fields: dead),
    keep_mains(fields: mains_lost, buffered_j),
    keep_orders(fields: drives_ordered, powered, power_off_due, estop, drive_faults),
} on {});

impl Power {
    /// Drives on, mains present.
    pub(super) fn new(retract: &AlarmRetract) -> Self {
        Self {
            dead: [false; AXIS_COUNT],
            mains_lost: false,
            buffered_j: retract.buffered_energy_j,
            drives_ordered: true,
            powered: true,
            power_off_due: false,
            estop: false,
            drive_faults: [false; AXIS_COUNT],
        }
    }

    pub(super) fn is_on(&self) -> bool {
        self.powered
    }

    pub(super) fn dead(&self) -> [bool; AXIS_COUNT] {
        self.dead
    }

    pub(super) fn is_dead(&self, axis: Axis) -> bool {
        self.dead[axis.index()]
    }

    pub(super) fn is_estop_pressed(&self) -> bool {
        self.estop
    }

    /// The wheel may be ordered to run.
    pub(super) fn allows_wheel(&self) -> bool {
        !self.estop && !self.mains_lost
    }

    pub(super) fn set_estop(&mut self, pressed: bool) {
        self.estop = pressed;
    }

    /// Mains lost or back. Returns true if they are lost now and were not before.
    pub(super) fn set_mains_lost(&mut self, lost: bool, retract: &AlarmRetract) -> bool {
        let begins = lost && !self.mains_lost;
        if begins {
            self.buffered_j = retract.buffered_energy_j;
        }
        self.mains_lost = lost;
        begins
    }

    pub(super) fn set_drive_fault(&mut self, axis: Axis, active: bool) {
        self.drive_faults[axis.index()] = active;
    }

    pub(super) fn order_drives(&mut self, on: bool) {
        self.drives_ordered = on;
        self.power_off_due |= !on;
    }

    pub(super) fn take_power_off(&mut self) -> bool {
        core::mem::take(&mut self.power_off_due)
    }

    /// Refuses a reset while the emergency stop is pressed or mains power lost.
    pub(super) fn check_supply(&self) -> Result<(), ResetRefused> {
        match (self.estop, self.mains_lost) {
            (true, _) => Err(ResetRefused::EStopPressed),
            (false, true) => Err(ResetRefused::PowerLost),
            (false, false) => Ok(()),
        }
    }

    /// Refuses a reset while the drive of this axis reports a fault.
    pub(super) fn check_drive(&self, axis: Axis) -> Result<(), ResetRefused> {
        if self.drive_faults[axis.index()] { Err(ResetRefused::DriveFault(axis)) } else { Ok(()) }
    }

    /// Gives the drives their power after a reset, if it is ordered.
    pub(super) fn reset(&mut self) {
        self.power_off_due = false;
        self.powered = self.drives_ordered;
        self.dead = [!self.powered; AXIS_COUNT];
    }

    pub(super) fn switch_on(&mut self) {
        self.powered = true;
        self.dead = [false; AXIS_COUNT];
    }

    /// Returns false if the drives have no power already.
    pub(super) fn switch_off(&mut self) -> bool {
        core::mem::replace(&mut self.powered, false)
    }

    /// Takes the power from one drive. Returns false if it has none already.
    pub(super) fn kill(&mut self, axis: Axis) -> bool {
        !core::mem::replace(&mut self.dead[axis.index()], true)
    }

    /// Lives on the buffered energy for one tick if mains power lost. `motors_w` is called only then. Returns true once the buffer is
    /// empty.
    pub(super) fn drain_buffer(
        &mut self,
        motors_w: impl FnOnce() -> f64,
        retract: &AlarmRetract,
        cycle_time_s: f64,
    ) -> bool {
        if !self.mains_lost || !self.powered {
            return false;
        }
        self.buffered_j -= (motors_w() + retract.standby_w) * cycle_time_s;
        self.buffered_j <= 0.0
    }
}
