//! The wheel sweeps the lobe in front of it along one servo step.

use super::Machine;
use super::probes::engagement_mm;
use crate::machine::contact_law::ContactLaw;
use crate::machine::description::{AXIS_COUNT, Axis};
use crate::math::units::TURN_RAD;
use crate::simulation::axis::Span;
use crate::simulation::workpiece::{Deflection, Lobe, Removal, WheelPosition};

/// Height of the cusps that the sweep may leave where the part is straight or convex (mm); ten times that, 0.05 µm, on
/// a concave flank whose radius is the wheel's over 0.9, the tightest that is planned.
///
/// Between two positions of the wheel whose centres are d apart, seen from the part, a cusp of d² ρ/(8 R (ρ + R)) stays
/// (R wheel, ρ part, negative where concave): at most d²/(8 R) on convex parts, which gives the largest d.
const CUSP_MM: f64 = 5.0e-6;

impl Machine {
    /// The lobe that stands in front of the wheel: the one whose width overlaps the wheel's, the nearest if several do.
    /// A lobe is centred on the wheel when the table stands at its station's position.
    pub(super) fn lobe_in_front(&self) -> Option<usize> {
        let distance = |lobe: &Lobe| self.beside_mm(lobe);
        self.part
            .lobes()
            .iter()
            .enumerate()
            .filter(|(_, lobe)| distance(lobe) < 0.5 * (lobe.width_mm() + self.description.wheel.width_mm))
            .min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)))
            .map(|(index, _)| index)
    }

    fn table_mm(&self) -> f64 {
        let table = &self.axes[Axis::Z.index()];
        table.true_position() / table.counts_per_unit
    }

    /// How far the middle of a lobe stands beside the wheel's (mm).
    fn beside_mm(&self, lobe: &Lobe) -> f64 {
        (self.table_mm() - self.description.stations[lobe.station()].position_mm).abs()
    }

    /// How wheel and lobe give way to each other over the width that both have in common; none where nothing does.
    pub(super) fn contact_law(&self, lobe: usize) -> Option<ContactLaw> {
        let contact = self.description.contact.as_ref()?;
        let lobe = &self.part.lobes()[lobe];
        let (lobe_mm, wheel_mm) = (lobe.width_mm(), self.description.wheel.width_mm);
        let common_mm = (0.5 * (lobe_mm + wheel_mm) - self.beside_mm(lobe)).min(lobe_mm).min(wheel_mm);
        contact.law(self.table_mm(), common_mm)
    }

    /// What the contact does to the axes (N of a slide, N m of the headstock): along its normal it pushes the wheelhead away, and turns
    /// the part out of the wheel's way by the arm that the normal's line has about the part's axis.
    pub(super) fn cutting_forces(&self) -> [f64; AXIS_COUNT] {
        if self.force_n == 0.0 {
            return [0.0; AXIS_COUNT];
        }
        let wheelhead = &self.axes[Axis::X.index()];
        let centre_mm = wheelhead.true_position() / wheelhead.counts_per_unit + self.lasting.wheel_radius_mm;
        let (along, across) = self.deflection.normal;
        let sense = f64::from(self.description.rotation_sense);
        let mut forces = [0.0; AXIS_COUNT];
        forces[Axis::X.index()] = self.force_n * along;
        forces[Axis::C.index()] = sense * self.force_n * across * centre_mm * 1e-3;
        forces
    }

    /// What the gauge reads at the end of a tick, while C turns.
    pub(super) fn gauge(&mut self, lobe: Option<usize>) -> [Option<f64>; 2] {
        let Some(gauge) = &mut self.gauge else { return [None; 2] };
        let headstock = &self.axes[Axis::C.index()];
        let Some(lobe) = lobe.filter(|_| !headstock.is_at_rest() || self.push_n > 0.0) else {
            gauge.rest();
            return [None; 2];
        };
        let sense = f64::from(self.description.rotation_sense);
        let turn = libm::round(TURN_RAD * headstock.counts_per_unit);
        let line_rad = line_rad(headstock.true_position(), turn, sense);
        let share = self.description.contact.as_ref().map_or(0.0, |contact| contact.part_share);
        let part = Deflection { mm: share * self.deflection.mm, ..self.deflection };
        gauge.read(&self.part.lobes()[lobe], line_rad, sense, part)
    }

    /// The wheel sweeps the lobe along a servo step, in steps so small that the cusps between them do not matter.
    #[allow(clippy::cast_possible_truncation, reason = "clamped to u32 before the cast")]
    pub(super) fn grind(
        &mut self,
        servo_step: u32,
        lobe: usize,
        law: Option<&ContactLaw>,
        spans: &[Span; AXIS_COUNT],
    ) -> Removal {
        let (c, x) = (&spans[Axis::C.index()], &spans[Axis::X.index()]);
        if c.is_still() && x.is_still() {
            return Removal::default();
        }
        let surface = self.surface(servo_step);
        let (per_mm, per_rad) =
            (self.axes[Axis::X.index()].counts_per_unit, self.axes[Axis::C.index()].counts_per_unit);
        let turn = libm::round(TURN_RAD * per_rad);
        let sense = f64::from(self.description.rotation_sense);
        let lobe = self.part.lobe_mut(lobe);
        // Between its ends the cubic swings out by less than the speeds at its ends times the step.
        let swing = (x.from_velocity.abs() + x.to_velocity.abs()) * self.step_s;
        let nearest_mm = (x.from.min(x.to) - swing) / per_mm + surface.centre_mm - surface.most_thrown_mm();
        if nearest_mm - surface.radius_mm >= lobe.reach_mm() {
            lobe.leave();
            (self.deflection, self.force_n) = (Deflection::default(), 0.0);
            return Removal::default();
        }
        let centre = x.from.max(x.to) / per_mm + surface.centre_mm;
        let path = (c.to - c.from).abs() / per_rad * centre + (x.to - x.from).abs() / per_mm;
        let longest = libm::sqrt(8.0 * surface.radius_mm * CUSP_MM);
        let positions = libm::ceil(path / longest).max(surface.positions()).clamp(1.0, 10_000.0) as u32;
        let cuts = self.wheel.cuts();
        let from_rad = line_rad(c.from, turn, sense);
        let mut removal = Removal::default();
        for j in 1..=positions {
            let s = f64::from(j) / f64::from(positions);
            let wheel = WheelPosition {
                azimuth_rad: from_rad + sense * c.way(s, self.step_s) / turn * TURN_RAD,
                centre_mm: (x.from + x.way(s, self.step_s)) / per_mm + surface.centre_mm + surface.thrown_mm(s),
                radius_mm: surface.radius_mm,
            };
            let taken = match law {
                None => lobe.pass(wheel, cuts),
                Some(law) => {
                    let time_s = self.step_s / f64::from(positions);
                    let (taken, deflection) = lobe.press(wheel, law, self.deflection, cuts, time_s);
                    (self.deflection, self.force_n) = (deflection, law.force_n(deflection.mm));
                    taken
                }
            };
            if let Some(gap) = &mut self.gap {
                let depth = engagement_mm(law, taken, self.deflection, cuts) * per_mm;
                gap.touch(x, x.from + x.way(s, self.step_s), depth);
            }
            removal = removal.and(taken);
        }
        removal
    }
}

/// Azimuth of the wheel line seen from the part (rad), with C at so many counts of which `turn` are a turn.
pub(super) fn line_rad(counts: f64, turn: f64, sense: f64) -> f64 {
    sense * libm::fmod(counts, turn) / turn * TURN_RAD
}
