//! A lathe's insert sweeps the part in the chuck along one servo step.

use super::Machine;
use super::sweep::line_rad;
use crate::machine::description::{AXIS_COUNT, Axis};
use crate::math::units::TURN_RAD;
use crate::simulation::axis::Span;
use crate::simulation::turned_part::{Insert, InsertMove, InsertPose, TurnedPart, TurnedRemoval};
use crate::simulation::workpiece::Removal;

/// A part in the chuck of a lathe.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Clamped {
    pub(super) part: TurnedPart,
    /// Where the insert's centre stands along the part when Z is 0 (mm).
    pub(super) zero_mm: f64,
}

impl Machine {
    /// The part in the chuck of a lathe.
    #[must_use]
    pub fn turned_part(&self) -> Option<&TurnedPart> {
        self.turned.as_ref().map(|clamped| &clamped.part)
    }

    /// Where the insert's centre stands along that part when Z is 0 (mm); 0 without one.
    #[must_use]
    pub fn part_zero_mm(&self) -> f64 {
        self.turned.as_ref().map_or(0.0, |clamped| clamped.zero_mm)
    }

    /// Whether a part is in the machine.
    pub(super) fn has_part(&self) -> bool {
        !self.part.is_empty() || self.turned.is_some()
    }

    fn edge(&self) -> Option<Insert> {
        let insert = self.description.insert?;
        Some(Insert { radius_mm: insert.radius_mm, height_mm: insert.height_mm })
    }

    /// The insert sweeps the part along a servo step, from where the axes truly were to where they are.
    pub(super) fn turn_part(&mut self, spans: &[Span; AXIS_COUNT]) -> TurnedRemoval {
        let (Some(insert), Some(clamped)) = (self.edge(), &mut self.turned) else { return TurnedRemoval::default() };
        let sense = f64::from(self.description.rotation_sense);
        let per_unit = |axis: Axis| self.axes[axis.index()].counts_per_unit;
        let turn = libm::round(TURN_RAD * per_unit(Axis::C));
        let units = [sense * TURN_RAD / turn, 1.0 / per_unit(Axis::X), 1.0 / per_unit(Axis::Z)];
        // Speeds are per second, slopes of the step per step.
        let slope = |speed: fn(&Span) -> f64| core::array::from_fn(|i| speed(&spans[i]) * self.step_s * units[i]);
        let from = InsertPose {
            turned_rad: line_rad(spans[Axis::C.index()].from, turn, sense),
            x_mm: spans[Axis::X.index()].from / per_unit(Axis::X),
            z_mm: spans[Axis::Z.index()].from / per_unit(Axis::Z) + clamped.zero_mm,
        };
        let way = core::array::from_fn(|i| (spans[i].to - spans[i].from) * units[i]);
        let motion = InsertMove::cubic(from, way, slope(|span| span.from_velocity), slope(|span| span.to_velocity));
        clamped.part.sweep(&insert, &motion, self.wheel.cuts())
    }

    /// A turned volume as a wheel's removal: per width of the tool, which is that of its edge.
    pub(super) fn as_of_a_wheel(&self, turned: &TurnedRemoval) -> Removal {
        Removal {
            area_mm2: turned.volume_mm3 / self.description.wheel.width_mm,
            depth_mm: turned.depth_mm,
            is_over_axis: turned.is_over_axis,
        }
    }

    /// How far out the insert's centre must be for its edge to be off the part's largest and its smallest radius (mm); none where it
    /// stands beside the part or there is none.
    pub(super) fn turned_off_mm(&self) -> Option<(f64, f64)> {
        let (insert, clamped) = (self.edge()?, self.turned.as_ref()?);
        let table = &self.axes[Axis::Z.index()];
        let z_mm = table.true_position() / table.counts_per_unit + clamped.zero_mm;
        let grid = clamped.part.grid();
        if z_mm + insert.radius_mm < grid.from_mm || z_mm - insert.radius_mm > grid.to_mm {
            return None;
        }
        let height_mm = insert.height_mm;
        let centre = |r: f64| libm::sqrt((r * r - height_mm * height_mm).max(0.0)) + insert.radius_mm;
        Some((centre(clamped.part.raw_reach_mm()), centre(clamped.part.least_mm())))
    }
}
