// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Variants of a machine: without an effect, or with other drives.

use crate::machine::description::{Axis, DriveSettings, MachineDescription, WheelDescription};
use crate::machine::effect::Effect;

impl MachineDescription {
    /// This machine without an effect that leaves an error on the part.
    #[must_use]
    pub fn without(self, effect: Effect) -> Self {
        match effect {
            Effect::Servo => self.with_drives(DriveSettings::IDEAL),
            Effect::Thermal => Self { thermal: None, ..self },
            Effect::Unbalance => self.with_each_wheel(|wheel| WheelDescription { unbalance_mm: 0.0, ..wheel }),
            Effect::Quantisation => self.with_each_drive(DriveSettings::with_exact_encoder),
            Effect::Deflection => Self { contact: None, ..self },
            Effect::Wear => self.with_each_wheel(|wheel| WheelDescription { grinding_ratio: None, ..wheel }),
        }
    }

    /// This machine with the same drive settings on every axis.
    #[must_use]
    pub fn with_drives(self, drive: DriveSettings) -> Self {
        self.with_each_drive(|_| drive)
    }

    /// This machine with the good drive of every axis that has one; `None` where none has.
    #[must_use]
    pub fn with_good_drives(mut self) -> Option<Self> {
        if self.axes.iter().all(|axis| axis.good_drive.is_none()) {
            return None;
        }
        for axis in &mut self.axes {
            axis.drive = axis.good_drive.unwrap_or(axis.drive);
        }
        Some(self)
    }

    /// This machine with the good drive of one axis; `None` where that has none.
    #[must_use]
    pub fn with_good_drive(mut self, axis: Axis) -> Option<Self> {
        let axis = &mut self.axes[axis.index()];
        axis.drive = axis.good_drive?;
        Some(self)
    }

    fn with_each_drive(mut self, change: impl Fn(DriveSettings) -> DriveSettings) -> Self {
        for axis in &mut self.axes {
            axis.drive = change(axis.drive);
        }
        self
    }
}
