//! Persistent state of the machine between runs. The node stores it in a file; here it is a plain value.

use crate::machine::description::MachineDescription;
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
    /// Parts since the machine was new.
    pub life: TravelCount,
    /// Parts of this shift.
    pub shift: TravelCount,
}

crate::snapshot!(PersistentState {
    wheel_radius_mm, wheel_wear_mm, growth_mm, growth_at_dress_mm, lobes_since_dress, parts_since_dress, dress_count, life, shift,
} on {} holds |lasting| {
    lasting.wheel_radius_mm > 0.0 => "the wheel has no radius",
});

impl PersistentState {
    /// A machine that has never run, with a new wheel.
    #[must_use]
    pub fn new(description: &MachineDescription) -> Self {
        Self {
            wheel_radius_mm: description.wheel.new_radius_mm,
            wheel_wear_mm: 0.0,
            growth_mm: description.thermal.map_or(0.0, |thermal| thermal.start_mm()),
            growth_at_dress_mm: description.thermal.map_or(0.0, |thermal| thermal.start_mm()),
            lobes_since_dress: 0,
            parts_since_dress: 0,
            dress_count: 0,
            life: TravelCount::default(),
            shift: TravelCount::default(),
        }
    }

    /// Counts a finished part.
    pub(crate) fn count_part(&mut self) {
        self.life.total = self.life.total.saturating_add(1);
        self.shift.total = self.shift.total.saturating_add(1);
        self.parts_since_dress = self.parts_since_dress.saturating_add(1);
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

    /// This state after a dress to a radius (mm).
    #[must_use]
    pub(crate) const fn dressed(self, radius_mm: f64) -> Self {
        Self {
            wheel_radius_mm: radius_mm,
            wheel_wear_mm: 0.0,
            growth_at_dress_mm: self.growth_mm,
            lobes_since_dress: 0,
            parts_since_dress: 0,
            dress_count: self.dress_count.saturating_add(1),
            ..self
        }
    }
}
