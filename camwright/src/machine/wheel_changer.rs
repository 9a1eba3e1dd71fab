// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Changer of grinding wheels: a magazine with an arm, or a wheelhead that turns one of several wheels to the part.
//!
//! The machine keeps the offsets of its wheels: after a change `x_axis` is the distance of the new wheel's cutting point from the spindle axis,
//! as it is after a dress.

use crate::machine::description::{Axis, DescriptionError, MachineDescription};
use crate::machine::wheel::WheelDescription;
use crate::machine::wheel_state::WheelNow;
use alloc::string::String;
use alloc::vec::Vec;

/// Largest number of wheels of a changer.
pub const MAX_WHEELS: usize = 4;

/// A wheel of a changer.
#[derive(Debug, Clone, PartialEq)]
pub struct MagazineWheel {
    /// Name by which jobs ask for it.
    pub name: String,
    pub wheel: WheelDescription,
    /// Error of its stored offset before its first dress here (mm): how much nearer to the part its cutting point is than `x_axis` says.
    pub setting_error_mm: f64,
}

/// The changer with all wheels, the mounted one included.
#[derive(Debug, Clone, PartialEq)]
pub struct WheelChanger {
    /// Time of a change with the wheel at rest (s).
    pub change_s: f64,
    /// Smallest position of `x_axis` at which it changes (mm).
    pub min_x_mm: f64,
    /// Wheels by position, 2 to [`MAX_WHEELS`].
    pub wheels: Vec<MagazineWheel>,
    /// Index of the wheel that [`MachineDescription::wheel`] is.
    pub mounted: usize,
}

impl WheelChanger {
    /// Index of the wheel with this name.
    #[must_use]
    pub fn position(&self, name: &str) -> Option<usize> {
        self.wheels.iter().position(|wheel| wheel.name == name)
    }

    /// Length of a change (ticks), at least one: that of a dwell of the same time.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, reason = "clamped to u32 before the cast")]
    pub fn change_ticks(&self, cycle_time_s: f64) -> u32 {
        libm::ceil(self.change_s / cycle_time_s - 1e-6).clamp(1.0, f64::from(u32::MAX)) as u32
    }

    /// The changer with a change made to every wheel.
    fn with_each_wheel(mut self, change: impl Fn(WheelDescription) -> WheelDescription) -> Self {
        for wheel in &mut self.wheels {
            wheel.wheel = change(wheel.wheel);
        }
        self
    }

    /// Checks that the values describe a possible changer of this machine.
    ///
    /// # Errors
    /// The first value that does not.
    pub(super) fn validate(&self, machine: &MachineDescription) -> Result<(), DescriptionError> {
        let count = self.wheels.len();
        if !(2..=MAX_WHEELS).contains(&count) {
            return Err(DescriptionError::WheelCount { count });
        }
        if !(self.change_s > 0.0 && self.change_s.is_finite()) {
            return Err(DescriptionError::NotPositive { what: "time of a wheel change (s)", value: self.change_s });
        }
        let (what, value) = ("smallest x_axis of a wheel change (mm)", self.min_x_mm);
        let (low, high) = machine.axis(Axis::X).soft_limits.unwrap_or((f64::MIN, f64::MAX));
        if !(low..=high).contains(&value) {
            return Err(DescriptionError::Outside { what, value, low, high });
        }
        for (position, wheel) in self.wheels.iter().enumerate() {
            wheel.wheel.validate(false)?;
            if !wheel.setting_error_mm.is_finite() {
                let (what, value) = ("setting error of a wheel (mm)", wheel.setting_error_mm);
                return Err(DescriptionError::NotFinite { what, value });
            }
            if self.position(&wheel.name) != Some(position) {
                return Err(DescriptionError::WheelName { name: wheel.name.clone() });
            }
        }
        let mounted = self.wheels.get(self.mounted).ok_or(DescriptionError::NoSuchWheel { index: self.mounted })?;
        match mounted.wheel == machine.wheel {
            true => Ok(()),
            false => Err(DescriptionError::OtherMountedWheel { name: mounted.name.clone() }),
        }
    }
}

impl MachineDescription {
    /// Index of the mounted wheel; 0 on a machine without a changer.
    #[must_use]
    pub fn mounted_wheel(&self) -> usize {
        self.wheel_changer.as_ref().map_or(0, |changer| changer.mounted)
    }

    /// A wheel by position; without a changer, and beyond its last wheel, the mounted one.
    #[must_use]
    pub fn wheel_at(&self, index: usize) -> WheelDescription {
        let changer = self.wheel_changer.as_ref().filter(|changer| changer.mounted != index);
        changer.and_then(|changer| changer.wheels.get(index)).map_or(self.wheel, |wheel| wheel.wheel)
    }

    /// Name of a wheel of the changer; `None` without one.
    #[must_use]
    pub fn wheel_name(&self, index: usize) -> Option<&str> {
        Some(self.wheel_changer.as_ref()?.wheels.get(index)?.name.as_str())
    }

    /// Longest time of its wheels to reach their speed or to come to rest (s): whichever of them is mounted is there after it.
    #[must_use]
    pub fn longest_spin_up_s(&self) -> f64 {
        let wheels = self.wheel_changer.iter().flat_map(|changer| &changer.wheels);
        wheels.map(|wheel| wheel.wheel.spin_up_s).fold(self.wheel.spin_up_s, f64::max)
    }

    /// Mounts a wheel of the changer. It does not allocate.
    ///
    /// # Errors
    /// The machine has no such wheel.
    pub fn mount_wheel(&mut self, index: usize) -> Result<(), DescriptionError> {
        let Some(changer) = &mut self.wheel_changer else {
            return if index == 0 { Ok(()) } else { Err(DescriptionError::NoSuchWheel { index }) };
        };
        let wheel = changer.wheels.get(index).ok_or(DescriptionError::NoSuchWheel { index })?.wheel;
        changer.mounted = index;
        self.wheel = wheel;
        Ok(())
    }

    /// This machine with a change made to every wheel.
    #[must_use]
    pub(crate) fn with_each_wheel(self, change: impl Fn(WheelDescription) -> WheelDescription) -> Self {
        Self {
            wheel: change(self.wheel),
            wheel_changer: self.wheel_changer.map(|changer| changer.with_each_wheel(change)),
            ..self
        }
    }
}

/// State of the wheels of a machine at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelsNow {
    /// The mounted wheel.
    pub mounted: WheelNow,
    /// The wheels of a changer by position; `None`: as in the machine's description, new. The mounted one's entry is not used.
    pub stored: [Option<WheelNow>; MAX_WHEELS],
}

impl<T: Into<WheelNow>> From<T> for WheelsNow {
    fn from(mounted: T) -> Self {
        Self { mounted: mounted.into(), stored: [None; MAX_WHEELS] }
    }
}

impl WheelsNow {
    /// State of a wheel of a machine.
    #[must_use]
    pub fn wheel(&self, machine: &MachineDescription, index: usize) -> WheelNow {
        if index == machine.mounted_wheel() {
            return self.mounted;
        }
        let stored = self.stored.get(index).copied().flatten();
        stored.unwrap_or_else(|| WheelNow::dressed(machine.wheel_at(index).new_radius_mm))
    }
}
