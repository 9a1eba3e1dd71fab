// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Reaction of an alarm on a wheel at the part, and its source of energy.

use crate::machine::description_error::DescriptionError;

/// Retraction of the wheel by an alarm.
///
/// While the drives of C and X work, the axes come to rest on the path and X leaves it outwards meanwhile. If C's drive does
/// not, X goes outwards by itself; if X's does not, a brake stops the wheelhead and a weight or a spring draws it back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlarmRetract {
    /// Distance of the wheel from the farthest point of the lobe in front of it when it is off (mm).
    pub clearance_mm: f64,
    /// Energy that the drives have when mains power lost (J).
    pub buffered_energy_j: f64,
    /// Power that the drives and the control take from it in addition to what moves the axes (W).
    pub standby_w: f64,
    /// Acceleration that the weight or spring gives a wheelhead whose drive has no power (mm/s²); 0: there is none.
    pub drawback_mm_s2: f64,
}

impl Default for AlarmRetract {
    /// Ordinary figures (not a maker's): direct-current links of three drives hold some hundred joules.
    fn default() -> Self {
        Self { clearance_mm: 2.0, buffered_energy_j: 400.0, standby_w: 500.0, drawback_mm_s2: 2000.0 }
    }
}

impl AlarmRetract {
    pub(super) fn validate(&self) -> Result<(), DescriptionError> {
        for (what, value) in [
            ("clearance of the retract of an alarm (mm)", self.clearance_mm),
            ("buffered energy (J)", self.buffered_energy_j),
            ("standby power (W)", self.standby_w),
            ("drawback of the wheelhead (mm/s²)", self.drawback_mm_s2),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(DescriptionError::Negative { what, value });
            }
        }
        Ok(())
    }
}
