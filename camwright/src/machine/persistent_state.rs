// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Persistent state of the machine between runs. The node stores it in a file; here it is a plain value.

use crate::machine::description::{DescriptionError, MachineDescription};
use crate::machine::wheel_changer::{MAX_WHEELS, WheelsNow};
use crate::machine::wheel_magazine::{StoredWheel, WheelMagazine};
use crate::machine::wheel_state::WheelNow;

/// Parts since some moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TravelCount {
    pub total: u64,
    /// Judged parts within every tolerance.
    pub good: u64,
    /// Not within every tolerance.
    pub bad: u64,
}

crate::snapshot!(TravelCount { total, good, bad } on {});

impl TravelCount {
    fn judge(&mut self, is_good: bool) {
        let of = if is_good { &mut self.good } else { &mut self.bad };
        *of = of.saturating_add(1);
    }
}

/// State that the machine retains from one run to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PersistentState {
    /// Radius of the wheel at its last dress (mm): what `x_axis` is counted with.
    pub wheel_radius_mm: f64,
    /// Wear of the wheel since then (mm).
    pub wheel_wear_mm: f64,
    /// Growth of the wheelhead towards the part (mm).
    pub growth_mm: f64,
    /// Growth at the wheel's last dress (mm).
    pub growth_at_dress_mm: f64,
    /// Lobes ground since then; one that is ground again after another counts again.
    pub lobes_since_dress: u32,
    /// Parts finished since then.
    pub parts_since_dress: u32,
    /// Times this wheel has been dressed.
    pub dress_count: u32,
    /// Distance by which the wheel's cutting point is nearer to the part than `x_axis` says (mm): the setting error of a wheel that has not
    /// been dressed here, then the error of X's zero at its last dress.
    pub wheel_zero_error_mm: f64,
    /// Wheels of a changer; `None`: the machine has one wheel.
    pub magazine: Option<WheelMagazine>,
    /// Parts since the machine was new.
    pub life: TravelCount,
    /// Parts of this shift.
    pub shift: TravelCount,
}

crate::snapshot!(PersistentState {
    wheel_radius_mm, wheel_wear_mm, growth_mm, growth_at_dress_mm, lobes_since_dress, parts_since_dress, dress_count, life, shift,
} on {
    // A keyframe holds them elsewhere.
    wheel_zero_error_mm, magazine,
} holds |lasting| {
    lasting.wheel_radius_mm > 0.0 => "the wheel has no radius",
});

impl PersistentState {
    /// A machine that has never run, with new wheels.
    #[must_use]
    pub fn new(description: &MachineDescription) -> Self {
        let changer = description.wheel_changer.as_ref();
        let mounted = changer.and_then(|changer| changer.wheels.get(changer.mounted));
        Self {
            wheel_radius_mm: description.wheel.new_radius_mm,
            wheel_wear_mm: 0.0,
            growth_mm: description.thermal.map_or(0.0, |thermal| thermal.start_mm()),
            growth_at_dress_mm: description.thermal.map_or(0.0, |thermal| thermal.start_mm()),
            lobes_since_dress: 0,
            parts_since_dress: 0,
            dress_count: 0,
            wheel_zero_error_mm: mounted.map_or(0.0, |wheel| wheel.setting_error_mm),
            magazine: WheelMagazine::new(description),
            life: TravelCount::default(),
            shift: TravelCount::default(),
        }
    }

    /// This state for a machine: the wheels of a changer that it does not have are new.
    ///
    /// # Errors
    /// A wheel without a radius; wheels that the machine does not have.
    pub fn for_machine(self, description: &MachineDescription) -> Result<Self, DescriptionError> {
        if !(self.wheel_radius_mm > 0.0 && self.wheel_radius_mm.is_finite()) {
            let (what, value) = ("present wheel radius (mm)", self.wheel_radius_mm);
            return Err(DescriptionError::NotPositive { what, value });
        }
        if !self.wheel_zero_error_mm.is_finite() {
            let (what, value) = ("zero error of the wheel (mm)", self.wheel_zero_error_mm);
            return Err(DescriptionError::NotFinite { what, value });
        }
        let magazine = self.magazine.or_else(|| WheelMagazine::new(description));
        magazine.map_or(Ok(()), |magazine| magazine.validate(description))?;
        Ok(Self { magazine, ..self })
    }

    /// Position of the mounted wheel in the changer; 0 without a changer.
    #[must_use]
    pub fn mounted_wheel(&self) -> usize {
        self.magazine.map_or(0, |magazine| magazine.mounted())
    }

    /// Mounts a wheel of the magazine. Returns false if the magazine does not hold it.
    #[must_use]
    pub(crate) fn mount_wheel(&mut self, position: usize) -> bool {
        let removed = self.mounted_state();
        match self.magazine.as_mut().and_then(|magazine| magazine.exchange(position, removed)) {
            Some(mounted) => {
                *self = self.with_mounted(mounted);
                true
            }
            None => false,
        }
    }

    /// State of the wheel at a position of the changer; `None`: it has none there.
    #[must_use]
    pub fn wheel_at(&self, position: usize) -> Option<StoredWheel> {
        match position == self.mounted_wheel() {
            true => Some(self.mounted_state()),
            false => self.magazine?.stored(position),
        }
    }

    const fn mounted_state(&self) -> StoredWheel {
        StoredWheel {
            radius_mm: self.wheel_radius_mm,
            wear_mm: self.wheel_wear_mm,
            growth_at_dress_mm: self.growth_at_dress_mm,
            zero_error_mm: self.wheel_zero_error_mm,
            lobes_since_dress: self.lobes_since_dress,
            parts_since_dress: self.parts_since_dress,
            dress_count: self.dress_count,
        }
    }

    const fn with_mounted(self, wheel: StoredWheel) -> Self {
        Self {
            wheel_radius_mm: wheel.radius_mm,
            wheel_wear_mm: wheel.wear_mm,
            growth_at_dress_mm: wheel.growth_at_dress_mm,
            wheel_zero_error_mm: wheel.zero_error_mm,
            lobes_since_dress: wheel.lobes_since_dress,
            parts_since_dress: wheel.parts_since_dress,
            dress_count: wheel.dress_count,
            ..self
        }
    }

    /// State of all wheels.
    #[must_use]
    pub fn wheels(&self) -> WheelsNow {
        let stored = |position| Some(self.magazine?.stored(position)?.now());
        WheelsNow { mounted: self.wheel(), stored: core::array::from_fn(stored) }
    }

    /// This state with other wheels. The magazine must hold those that are not mounted.
    #[must_use]
    pub fn with_wheels(self, wheels: &WheelsNow) -> Self {
        let mut state = self.with_wheel(wheels.mounted);
        if let Some(magazine) = &mut state.magazine {
            magazine.set_stored(&wheels.stored);
        }
        state
    }

    /// Counts a finished part. `ground` names the wheels of a changer that ground it.
    pub(crate) fn count_part(&mut self, ground: [bool; MAX_WHEELS]) {
        self.life.total = self.life.total.saturating_add(1);
        self.shift.total = self.shift.total.saturating_add(1);
        let is_counted = match &mut self.magazine {
            None => true,
            Some(magazine) => {
                magazine.count_part(ground);
                ground.get(magazine.mounted()).copied().unwrap_or(false)
            }
        };
        self.parts_since_dress = self.parts_since_dress.saturating_add(u32::from(is_counted));
    }

    /// Counts what a finished part was found to be.
    pub(crate) fn judge_part(&mut self, is_good: bool) {
        self.life.judge(is_good);
        self.shift.judge(is_good);
    }

    #[must_use]
    pub const fn wheel(&self) -> WheelNow {
        WheelNow {
            radius_mm: self.wheel_radius_mm,
            wear_mm: self.wheel_wear_mm,
            lobes_since_dress: self.lobes_since_dress,
            parts_since_dress: self.parts_since_dress,
        }
    }

    /// This state with another wheel.
    #[must_use]
    pub const fn with_wheel(self, wheel: WheelNow) -> Self {
        Self {
            wheel_radius_mm: wheel.radius_mm,
            wheel_wear_mm: wheel.wear_mm,
            lobes_since_dress: wheel.lobes_since_dress,
            parts_since_dress: wheel.parts_since_dress,
            ..self
        }
    }

    /// This state after a dress to a radius (mm) with an error of X's zero (mm).
    #[must_use]
    pub(crate) const fn dressed(self, radius_mm: f64, zero_error_mm: f64) -> Self {
        Self {
            wheel_radius_mm: radius_mm,
            wheel_zero_error_mm: zero_error_mm,
            wheel_wear_mm: 0.0,
            growth_at_dress_mm: self.growth_mm,
            lobes_since_dress: 0,
            parts_since_dress: 0,
            dress_count: self.dress_count.saturating_add(1),
            ..self
        }
    }
}
