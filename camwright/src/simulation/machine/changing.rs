// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The wheel changer: an arm takes the mounted wheel off its spindle and mounts another.
//!
//! The arm finishes a change that it has begun, whatever stops the axes: no wheel is left half mounted. Until then the mounted wheel is the
//! old one.

use super::Machine;
use crate::machine::alarm::AlarmKind;
use crate::machine::description::{Axis, MAX_WHEELS, MachineDescription};
use crate::machine::persistent_state::PersistentState;
use crate::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use crate::simulation::workpiece::Removal;

/// Distance below the smallest position of `x_axis` within which it still stands there (mm): a following error.
const AT_CHANGER_MM: f64 = 0.05;

/// Arm of the changer.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct ChangerArm {
    /// Position of the wheel that it mounts, and the ticks until it is mounted.
    change: Option<(u32, u32)>,
    /// Wheels that have ground the part.
    ground: [bool; MAX_WHEELS],
}

impl ChangerArm {
    /// Goes through its state and that of the wheels; what is read is mounted in the description.
    pub(super) fn snapshot(
        &mut self,
        description: &mut MachineDescription,
        lasting: &mut PersistentState,
        codec: &mut SnapshotCodec<'_>,
    ) -> Result<(), SnapshotError> {
        codec.field("change", |codec| self.change.snapshot(codec))?;
        codec.field("ground", |codec| self.ground.snapshot(codec))?;
        if let Some(magazine) = &mut lasting.magazine {
            codec.field("magazine", |codec| magazine.snapshot(codec))?;
            if codec.is_reading() {
                let is_known = |wheel: usize| magazine.stored(wheel).is_some();
                if magazine.validate(description).is_err()
                    || !self.change.is_none_or(|(wheel, _)| is_known(wheel as usize))
                {
                    return Err(SnapshotError::Impossible("the changer has no such wheels"));
                }
                let mounted = description.mount_wheel(magazine.mounted());
                mounted.map_err(|_| SnapshotError::Impossible("the changer has no such wheel"))?;
            }
        }
        Ok(())
    }

    /// Wheels that have ground the part; from now on none has.
    pub(super) fn take_ground(&mut self) -> [bool; MAX_WHEELS] {
        core::mem::take(&mut self.ground)
    }

    /// The mounted wheel was dressed: what it ground before does not count.
    pub(super) fn forget_ground(&mut self, wheel: usize) {
        if let Some(ground) = self.ground.get_mut(wheel) {
            *ground = false;
        }
    }

    /// One tick; returns the position of a wheel that is mounted with its end.
    fn step(&mut self) -> Option<usize> {
        let (wheel, left) = self.change?;
        let left = left.saturating_sub(1);
        self.change = (left > 0).then_some((wheel, left));
        (left == 0).then_some(wheel as usize)
    }
}

impl Machine {
    /// The changer mounts a wheel.
    #[must_use]
    pub fn is_mounting(&self) -> bool {
        self.changer.as_ref().is_some_and(|arm| arm.change.is_some())
    }

    /// Position of X as it reads (mm), and whether it is clear of the changer; always clear without one.
    fn clearance_of_changer(&self) -> (f64, f64, bool) {
        let x = &self.axes[Axis::X.index()];
        let x_mm = x.true_value() - x.zero_value();
        let min_mm = self.description.wheel_changer.as_ref().map_or(f64::NEG_INFINITY, |changer| changer.min_x_mm);
        (x_mm, min_mm, x.homed && x_mm >= min_mm - AT_CHANGER_MM)
    }

    /// Raises the alarm of a change that is refused or disturbed.
    pub(super) fn refuse_wheel(&mut self) {
        let (x_mm, min_mm, _) = self.clearance_of_changer();
        self.raise(AlarmKind::WheelNotChanged, x_mm, min_mm);
    }

    /// Begins to mount a wheel; the mounted one takes no time. None is mounted while an alarm stops the machine.
    pub(super) fn change_wheel(&mut self, wheel: usize) {
        let mounted = self.description.mounted_wheel();
        if (wheel == mounted && !self.is_mounting()) || self.supervision.is_stopping() {
            return;
        }
        let wheels = self.description.wheel_changer.as_ref().map_or(1, |changer| changer.wheels.len());
        if wheel >= wheels {
            self.raise(AlarmKind::NoSuchWheel, wheel as f64 + 1.0, wheels as f64);
            return;
        }
        if !self.axes[Axis::X.index()].homed {
            self.raise(AlarmKind::NotHomed(Axis::X), 0.0, 0.0);
            return;
        }
        let (_, _, is_clear) = self.clearance_of_changer();
        if self.is_mounting() || self.wheel.turns() || !is_clear {
            self.refuse_wheel();
            return;
        }
        let cycle_time_s = self.description.cycle_time_s();
        let ticks = self.description.wheel_changer.as_ref().map_or(1, |changer| changer.change_ticks(cycle_time_s));
        if let Some(arm) = &mut self.changer {
            arm.change = u32::try_from(wheel).ok().map(|wheel| (wheel, ticks));
        }
    }

    /// Ends a tick of the changer. The removal is that of the mounted wheel.
    pub(super) fn step_changer(&mut self, removal: Removal) {
        let mounted = self.description.mounted_wheel();
        let (_, _, is_clear) = self.clearance_of_changer();
        let Some(arm) = &mut self.changer else { return };
        if let Some(ground) = arm.ground.get_mut(mounted) {
            *ground |= removal.area_mm2 > 0.0;
        }
        if arm.change.is_none() {
            return;
        }
        let done = arm.step();
        if !is_clear {
            self.refuse_wheel();
        }
        if let Some(wheel) = done
            && self.lasting.mount_wheel(wheel)
            && self.description.mount_wheel(wheel).is_ok()
        {
            self.wheel.mount(&self.description);
            self.workholding.change_wheel(self.description.wheel.surface_speed_m_s);
        }
    }
}
