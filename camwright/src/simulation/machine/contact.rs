//! Contact of wheel and lobe: the sweep along a servo step, deflection, force, and the detectors that feel it.

use super::contact_modes::ContactModes;
use super::inputs::{Inputs, Sensing};
use super::probes::{GapWatch, engagement_mm};
use super::wheel::WheelSurface;
use crate::cam::contour::LobeCentre;
use crate::machine::contact_law::ContactLaw;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use crate::machine::setpoint::Input;
use crate::math::units::TURN_RAD;
use crate::simulation::axis::{AxisState, Span};
use crate::simulation::force_monitor::ForceMonitor;
use crate::simulation::workpiece::{Deflection, Lobe, Removal, WheelCentre, WheelPass};

/// Height of the cusps that the sweep may leave where the part is straight or convex (mm); ten times that, 0.05 µm, on
/// a concave flank whose radius is the wheel's over 0.9, the tightest that is planned.
///
/// Between two positions of the wheel whose centres are d apart, seen from the part, a cusp of d² ρ/(8 R (ρ + R)) stays
/// (R wheel, ρ part, negative where concave): at most d²/(8 R) on convex parts, which gives the largest d.
const CUSP_MM: f64 = 5.0e-6;

/// Distance by which the deflection may change in a servo step without a new search for the contact (mm).
const DEFLECTS_MM: f64 = 0.005;

/// One servo step of the wheel along the lobe in front of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct LobeSweep<'a> {
    pub(super) c: &'a Span,
    pub(super) x: &'a Span,
    pub(super) per_rad: f64,
    pub(super) per_mm: f64,
    pub(super) rotation_sense: f64,
    pub(super) step_s: f64,
    pub(super) surface: WheelSurface,
    /// The wheel is fast enough to cut.
    pub(super) cuts: bool,
}

/// Deflection and force between wheel and part.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ContactState {
    deflection: Deflection,
    /// Normal force of the wheel on the part (N).
    force_n: f64,
    /// Force with which a wheel that does not turn may press on the part (N).
    push_n: f64,
    force_monitor: ForceMonitor,
    gap: Option<GapWatch>,
    /// Vibration between wheel and part; `None`: they deflect without delay.
    modes: Option<ContactModes>,
    /// The wheel in the present tick.
    pass: WheelPass,
}

snapshot_groups!(ContactState {
    keep_force(fields: deflection, force_n, push_n, force_monitor),
    keep_gap(equipment: gap),
    keep_modes(equipment: modes),
} on { pass });

impl ContactState {
    pub(super) fn new(description: &MachineDescription) -> Self {
        Self {
            deflection: Deflection::default(),
            force_n: 0.0,
            push_n: 0.0,
            force_monitor: ForceMonitor::default(),
            gap: GapWatch::new(description),
            modes: description.contact.as_ref().and_then(ContactModes::new),
            pass: WheelPass::new(),
        }
    }

    pub(super) fn force_n(&self) -> f64 {
        self.force_n
    }

    /// Deflection of the part alone, which has this share of the compliance.
    pub(super) fn part_deflection(&self, part_share: f64) -> Deflection {
        Deflection { mm: part_share * self.deflection.mm, ..self.deflection }
    }

    /// Lets a wheel that does not turn press with this force (N); 0: not at all.
    pub(super) fn allow_push(&mut self, max_n: f64) {
        self.push_n = max_n;
    }

    pub(super) fn is_push_allowed(&self) -> bool {
        self.push_n > 0.0
    }

    /// The wheel presses within the allowed force.
    pub(super) fn pushes(&self) -> bool {
        self.is_push_allowed() && self.force_n <= self.push_n
    }

    pub(super) fn watch_force(&mut self, max_n: f64) {
        self.force_monitor.watch(max_n);
    }

    pub(super) fn is_force_steady(&self) -> bool {
        self.force_monitor.is_closed()
    }

    pub(super) fn is_gap_closed(&self) -> bool {
        self.gap.is_some_and(|gap| gap.is_closed())
    }

    /// Wheel and part are apart.
    pub(super) fn separate(&mut self) {
        (self.deflection, self.force_n) = (Deflection::default(), 0.0);
        if let Some(modes) = &mut self.modes {
            modes.rest();
        }
    }

    /// Something moves between wheel and part although no axis does.
    pub(super) fn vibrates(&self) -> bool {
        self.modes.as_ref().is_some_and(ContactModes::vibrates)
    }

    /// Forces of the contact on the axes (N of a slide, N m of the headstock): along its normal it pushes the wheelhead away, and turns
    /// the part away from the wheel by the arm that the normal's line has about the part's axis. `centre` is that of the lobe, where it is
    /// not the axis.
    pub(super) fn forces_on_axes(
        &self,
        axes: &[AxisState; AXIS_COUNT],
        wheel_radius_mm: f64,
        rotation_sense: f64,
        centre: Option<LobeCentre>,
    ) -> [f64; AXIS_COUNT] {
        if self.force_n == 0.0 {
            return [0.0; AXIS_COUNT];
        }
        let centre_mm = axes[Axis::X.index()].true_value() + wheel_radius_mm;
        let (mut along, mut across) = self.deflection.normal;
        if let Some(centre) = centre {
            // From the line that joins the centres of lobe and wheel to the wheel line.
            let line_rad = rotation_sense * axes[Axis::C.index()].true_value();
            let (sin, cos) = libm::sincos(centre.relative(centre_mm, line_rad).1 - line_rad);
            (along, across) = (along * cos - across * sin, along * sin + across * cos);
        }
        let mut forces = [0.0; AXIS_COUNT];
        forces[Axis::X.index()] = self.force_n * along;
        forces[Axis::C.index()] = rotation_sense * self.force_n * across * centre_mm * 1e-3;
        forces
    }

    /// Edge of the gap detector at the end of a tick.
    pub(super) fn sense_gap(&mut self, sensing: &mut Sensing<'_>) {
        let presses = self.force_n > 0.0;
        if let Some((closed, touched)) = self.gap.as_mut().and_then(|gap| gap.end_tick(presses)) {
            sensing.latch(Input::WheelContact, closed, touched);
        }
    }

    /// Edge of the force monitor at the end of a tick.
    pub(super) fn sense_force(&mut self, inputs: &mut Inputs, sensing: &mut Sensing<'_>) {
        let headstock = &sensing.axes[Axis::C.index()];
        let position = headstock.true_position();
        if let Some(closed) = self.force_monitor.tick(position / headstock.counts_per_unit, self.force_n) {
            inputs.catch(Input::SteadyForce, closed, position, sensing);
        }
    }

    /// A tick begins.
    pub(super) fn begin_tick(&mut self) {
        self.pass.begin();
    }

    /// Ends a tick along a lobe: makes the cuts that wait.
    pub(super) fn finish(&mut self, lobe: &mut Lobe) -> Removal {
        lobe.finish(&mut self.pass)
    }

    /// Sweeps the lobe along a servo step, in steps so small that the cusps between them do not matter.
    #[allow(clippy::cast_possible_truncation, reason = "clamped to u32 before the cast")]
    pub(super) fn grind(&mut self, lobe: &mut Lobe, law: Option<&ContactLaw>, sweep: &LobeSweep<'_>) -> Removal {
        let LobeSweep { c, x, per_rad, per_mm, rotation_sense: sense, step_s, surface, cuts } = *sweep;
        let turn = libm::round(TURN_RAD * per_rad);
        // Between its ends the cubic swings out by less than the speeds at its ends times the step.
        let swing = (x.from_velocity.abs() + x.to_velocity.abs()) * step_s;
        let vibration_mm = self.modes.as_ref().map_or(0.0, ContactModes::reach_mm);
        let nearest_mm =
            (x.from.min(x.to) - swing) / per_mm + surface.centre_mm - surface.maximum_thrown_mm() - vibration_mm;
        if nearest_mm - surface.radius_mm >= lobe.reach_mm() + lobe.throw_mm() {
            let removal = lobe.finish(&mut self.pass);
            lobe.leave();
            self.separate();
            return removal;
        }
        let throw = lobe.centre();
        let centre = x.from.max(x.to) / per_mm + surface.centre_mm;
        let path = (c.to - c.from).abs() / per_rad * centre + (x.to - x.from).abs() / per_mm;
        let longest = libm::sqrt(8.0 * surface.radius_mm * CUSP_MM);
        let by_modes = self.modes.as_ref().map_or(1.0, |modes| modes.steps(step_s));
        let positions = libm::ceil(path / longest).max(surface.positions()).max(by_modes).clamp(1.0, 10_000.0) as u32;
        let from_rad = line_rad(c.from, turn, sense);
        let begin = WheelCentre {
            azimuth_rad: from_rad,
            centre_mm: x.from / per_mm + surface.centre_mm,
            radius_mm: surface.radius_mm,
        }
        .seen_from(throw);
        let margin_mm = path + surface.maximum_thrown_mm() + self.deflection.mm.abs() + DEFLECTS_MM;
        lobe.list_blocks(begin, law.is_some(), margin_mm, &mut self.pass);
        let mut removal = Removal::default();
        for j in 1..=positions {
            let s = f64::from(j) / f64::from(positions);
            let wheel = WheelCentre {
                azimuth_rad: from_rad + sense * c.way(s, step_s) / turn * TURN_RAD,
                centre_mm: (x.from + x.way(s, step_s)) / per_mm + surface.centre_mm + surface.thrown_mm(s),
                radius_mm: surface.radius_mm,
            }
            .seen_from(throw);
            let taken = match law {
                // The gap detector feels the depth in its moment.
                None if cuts && self.gap.is_none() => lobe.pass_later(wheel, &mut self.pass),
                None => lobe.pass(wheel, cuts),
                Some(law) if self.modes.is_some() => {
                    self.press_on_modes(lobe, wheel, law, (cuts, step_s / f64::from(positions)))
                }
                Some(law) => {
                    let time_s = step_s / f64::from(positions);
                    let (taken, deflection) = lobe.press(wheel, law, self.deflection, (cuts, time_s), &mut self.pass);
                    (self.deflection, self.force_n) = (deflection, law.force_n(deflection.mm));
                    taken
                }
            };
            if let Some(gap) = &mut self.gap {
                let depth = engagement_mm(law, taken, self.deflection, cuts) * per_mm;
                gap.touch(x, x.from + x.way(s, step_s), depth);
            }
            removal = removal.and(taken);
        }
        removal
    }

    /// The wheel presses at a position of its path, from which the modes of the contact carry it away along the normal.
    fn press_on_modes(
        &mut self,
        lobe: &mut Lobe,
        wheel: WheelCentre,
        law: &ContactLaw,
        (cuts, time_s): (bool, f64),
    ) -> Removal {
        let Some(step) = self.modes.as_ref().and_then(|modes| modes.begin(law, time_s)) else {
            return lobe.pass(wheel, cuts);
        };
        let normal = self.deflection.normal;
        let carried = wheel.carried(Deflection { mm: step.away_mm, normal });
        let before = Deflection { mm: self.deflection.mm - step.away_mm, normal };
        let (taken, deflection) = lobe.press(carried, &step.law, before, (cuts, time_s), &mut self.pass);
        self.force_n = step.law.force_n(deflection.mm);
        self.deflection = Deflection { mm: step.away_mm + deflection.mm, ..deflection };
        if let Some(modes) = &mut self.modes {
            modes.finish(law, time_s, self.force_n);
        }
        taken
    }
}

/// Azimuth of the wheel line seen from the part (rad), with C at so many counts of which `turn` are a turn.
pub(super) fn line_rad(counts: f64, turn: f64, sense: f64) -> f64 {
    sense * libm::fmod(counts, turn) / turn * TURN_RAD
}
