// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! State of the wheels that a changer keeps in its magazine.

use crate::machine::description::{DescriptionError, MachineDescription};
use crate::machine::wheel_changer::MAX_WHEELS;
use crate::machine::wheel_state::WheelNow;

/// State of one wheel of a changer. A magazine holds it while another wheel is mounted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StoredWheel {
    /// Radius at its last dress (mm).
    pub radius_mm: f64,
    /// Wear since then (mm).
    pub wear_mm: f64,
    /// Growth of the wheelhead at its last dress (mm).
    pub growth_at_dress_mm: f64,
    /// Distance by which its cutting point is nearer to the part than `x_axis` says (mm).
    pub zero_error_mm: f64,
    pub lobes_since_dress: u32,
    pub parts_since_dress: u32,
    pub dress_count: u32,
}

crate::snapshot!(StoredWheel {
    radius_mm, wear_mm, growth_at_dress_mm, zero_error_mm, lobes_since_dress, parts_since_dress, dress_count,
} on {});

impl StoredWheel {
    #[must_use]
    pub const fn now(&self) -> WheelNow {
        WheelNow {
            radius_mm: self.radius_mm,
            wear_mm: self.wear_mm,
            lobes_since_dress: self.lobes_since_dress,
            parts_since_dress: self.parts_since_dress,
        }
    }

    /// Radius with its wear (mm).
    #[must_use]
    pub fn worn_mm(&self) -> f64 {
        self.radius_mm - self.wear_mm
    }
}

/// Position of the mounted wheel, and the state of the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelMagazine {
    mounted: u32,
    /// Wheels by position; `None`: mounted, or no wheel.
    stored: [Option<StoredWheel>; MAX_WHEELS],
}

crate::snapshot!(WheelMagazine { mounted, stored } on {});

impl WheelMagazine {
    /// New wheels of a machine's changer; `None`: the machine has no changer.
    #[must_use]
    pub fn new(description: &MachineDescription) -> Option<Self> {
        let changer = description.wheel_changer.as_ref()?;
        let growth_at_dress_mm = description.thermal.map_or(0.0, |thermal| thermal.start_mm());
        let stored = |position: usize| {
            let wheel = changer.wheels.get(position).filter(|_| position != changer.mounted)?;
            Some(StoredWheel {
                radius_mm: wheel.wheel.new_radius_mm,
                growth_at_dress_mm,
                zero_error_mm: wheel.setting_error_mm,
                ..StoredWheel::default()
            })
        };
        Some(Self::from_states(changer.mounted, core::array::from_fn(stored)))
    }

    /// Magazine with this wheel mounted.
    #[must_use]
    pub fn from_states(mounted: usize, mut stored: [Option<StoredWheel>; MAX_WHEELS]) -> Self {
        if let Some(state) = stored.get_mut(mounted) {
            *state = None;
        }
        Self { mounted: u32::try_from(mounted).unwrap_or(u32::MAX), stored }
    }

    /// Position of the mounted wheel.
    #[must_use]
    pub const fn mounted(&self) -> usize {
        self.mounted as usize
    }

    /// State of a wheel that is not mounted.
    #[must_use]
    pub fn stored(&self, position: usize) -> Option<StoredWheel> {
        self.stored.get(position).copied().flatten()
    }

    /// Checks that these are the wheels of a machine.
    ///
    /// # Errors
    /// Another number of wheels, or a wheel with an impossible state.
    pub fn validate(&self, description: &MachineDescription) -> Result<(), DescriptionError> {
        let wheels = description.wheel_changer.as_ref().map_or(0, |changer| changer.wheels.len());
        let is_complete = |position: usize| match position < wheels && position != self.mounted() {
            true => self.stored(position).is_some(),
            false => self.stored(position).is_none(),
        };
        if self.mounted() >= wheels || !(0..MAX_WHEELS).all(is_complete) {
            let states = self.stored.iter().flatten().count() + 1;
            return Err(DescriptionError::WheelStates { states, wheels });
        }
        for wheel in self.stored.iter().flatten() {
            if !(wheel.radius_mm > 0.0 && wheel.radius_mm.is_finite()) {
                return Err(DescriptionError::NotPositive {
                    what: "radius of a stored wheel (mm)",
                    value: wheel.radius_mm,
                });
            }
            for (what, value) in [
                ("wear of a stored wheel (mm)", wheel.wear_mm),
                ("growth at the dress of a stored wheel (mm)", wheel.growth_at_dress_mm),
                ("zero error of a stored wheel (mm)", wheel.zero_error_mm),
            ] {
                if !value.is_finite() {
                    return Err(DescriptionError::NotFinite { what, value });
                }
            }
        }
        Ok(())
    }

    /// Exchanges the mounted wheel, whose state is given, for the one at a position; `None`: it holds none there.
    pub(crate) fn exchange(&mut self, position: usize, removed: StoredWheel) -> Option<StoredWheel> {
        let mounted = self.stored.get_mut(position)?.take()?;
        if let Some(place) = self.stored.get_mut(self.mounted as usize) {
            *place = Some(removed);
        }
        self.mounted = u32::try_from(position).unwrap_or(u32::MAX);
        Some(mounted)
    }

    /// Counts a finished part for the wheels in the magazine that ground it.
    pub(crate) fn count_part(&mut self, ground: [bool; MAX_WHEELS]) {
        for (wheel, ground) in self.stored.iter_mut().zip(ground) {
            if let Some(wheel) = wheel {
                wheel.parts_since_dress = wheel.parts_since_dress.saturating_add(u32::from(ground));
            }
        }
    }

    pub(crate) fn set_stored(&mut self, wheels: &[Option<WheelNow>; MAX_WHEELS]) {
        for (stored, now) in self.stored.iter_mut().zip(wheels) {
            if let (Some(stored), Some(now)) = (stored, now) {
                *stored = StoredWheel {
                    radius_mm: now.radius_mm,
                    wear_mm: now.wear_mm,
                    lobes_since_dress: now.lobes_since_dress,
                    parts_since_dress: now.parts_since_dress,
                    ..*stored
                };
            }
        }
    }
}
