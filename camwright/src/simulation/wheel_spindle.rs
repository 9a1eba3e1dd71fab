// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The wheel spindle: it runs up, runs, and runs down. A clamped insert has none.

use crate::machine::description::MachineDescription;

/// The drive of the grinding wheel. Its speed changes linearly; it counts ticks, so that it is exactly at speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelSpindle {
    ordered: bool,
    stalled: bool,
    ticks: u32,
    ticks_to_speed: u32,
    surface_speed_mm_s: f64,
    /// True for a tool that does not rotate, and cuts at rest.
    is_clamped: bool,
}

crate::snapshot!(WheelSpindle { ordered, stalled, ticks } on { ticks_to_speed, surface_speed_mm_s, is_clamped } holds |wheel| {
    wheel.ticks <= wheel.ticks_to_speed => "the wheel is faster than it can be",
});

impl WheelSpindle {
    /// A wheel at rest.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, reason = "clamped to u32 before the cast")]
    pub fn new(description: &MachineDescription) -> Self {
        let ticks = libm::ceil(description.wheel.spin_up_s / description.cycle_time_s());
        Self {
            ordered: false,
            stalled: false,
            ticks: 0,
            ticks_to_speed: ticks.clamp(1.0, f64::from(u32::MAX)) as u32,
            surface_speed_mm_s: description.wheel.surface_speed_m_s * 1000.0,
            is_clamped: description.cuts_at_rest(),
        }
    }

    /// Takes up the speed and the run-up time of the wheel that is mounted now.
    pub fn mount(&mut self, description: &MachineDescription) {
        let Self { ordered, stalled, ticks, ticks_to_speed: _, surface_speed_mm_s: _, is_clamped: _ } = *self;
        let new = Self::new(description);
        *self = Self { ordered, stalled, ticks: ticks.min(new.ticks_to_speed), ..new };
    }

    /// Orders it to run or to come to rest. A clamped tool has no spindle to run.
    pub fn order(&mut self, run: bool) {
        self.ordered = run && !self.is_clamped;
    }

    /// A stalled wheel loses its speed whatever is ordered.
    pub fn stall(&mut self, stalled: bool) {
        self.stalled = stalled;
    }

    pub fn step(&mut self) {
        self.ticks = if self.ordered && !self.stalled {
            (self.ticks + 1).min(self.ticks_to_speed)
        } else {
            self.ticks.saturating_sub(1)
        };
    }

    /// A real spindle reports whether it has its speed: without it the wheel is just below, whatever time has passed.
    pub fn see_speed(&mut self, at_speed: bool) {
        if !at_speed {
            self.ticks = self.ticks.min(self.ticks_to_speed - 1);
        }
    }

    /// The wheel at speed at once, for an offline simulation that begins in the middle of a job.
    #[must_use]
    pub fn at_speed(mut self) -> Self {
        self.order(true);
        if self.ordered {
            self.ticks = self.ticks_to_speed;
        }
        self
    }

    /// Returns whether the spindle is commanded to run.
    #[must_use]
    pub fn is_ordered(&self) -> bool {
        self.ordered
    }

    /// Ticks from rest to its surface speed.
    #[must_use]
    pub fn ticks_to_speed(&self) -> u32 {
        self.ticks_to_speed
    }

    /// Returns whether the tool cuts: a clamped one always, another from half its speed on; below, it rubs.
    #[must_use]
    pub fn cuts(&self) -> bool {
        self.is_clamped || self.ticks.saturating_mul(2) > self.ticks_to_speed
    }

    /// Returns whether the tool does not rotate.
    #[must_use]
    pub fn is_clamped(&self) -> bool {
        self.is_clamped
    }

    /// Its speed as a share of that which it is to have.
    #[must_use]
    pub fn share_of_speed(&self) -> f64 {
        f64::from(self.ticks) / f64::from(self.ticks_to_speed)
    }

    /// Returns whether it stands still.
    #[must_use]
    pub fn is_still(&self) -> bool {
        self.ticks == 0
    }

    /// Returns whether it has its surface speed.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.ticks == self.ticks_to_speed
    }

    /// It runs up or down.
    #[must_use]
    pub fn is_changing(&self) -> bool {
        if self.ordered && !self.stalled { !self.is_running() } else { !self.is_still() }
    }

    /// Its angular speed (rad/s) with this radius (mm).
    #[must_use]
    pub fn rad_s(&self, radius_mm: f64) -> f64 {
        self.surface_speed_mm_s / radius_mm * f64::from(self.ticks) / f64::from(self.ticks_to_speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::reference::cam_grinder;

    #[test]
    fn it_is_at_speed_after_its_time_and_a_stall_takes_the_speed_away() {
        let description = cam_grinder();
        let mut wheel = WheelSpindle::new(&description);
        wheel.order(true);
        let ticks = libm::round(description.wheel.spin_up_s / description.cycle_time_s());
        let mut count = 0.0;
        while !wheel.is_running() {
            wheel.step();
            count += 1.0;
        }
        assert!((ticks - count).abs() < 1.5, "{ticks} {count}");
        assert!((wheel.rad_s(200.0) * 0.2 - description.wheel.surface_speed_m_s).abs() < 1e-9);
        wheel.stall(true);
        wheel.step();
        assert!(!wheel.is_running());
    }
}
