// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Contact of wheel and lobe: the sweep along a servo step, deflection, force, and the detectors that feel it.

use super::contact_modes::ContactModes;
use super::inputs::{Inputs, Sensing};
use super::probes::{GapWatch, engagement_mm};
use super::wheel::WheelSurface;
use super::workholding::{FacedSection, FacedSections};
use crate::cam::contour::LobeCentre;
use crate::machine::contact_law::{ContactLaw, EngagedWidth, shared_deflection_mm};
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use crate::machine::setpoint::Input;
use crate::math::units::TURN_RAD;
use crate::simulation::axis::{AxisState, Span};
use crate::simulation::force_monitor::ForceMonitor;
use crate::simulation::workpiece::{
    DeepestTouch, Deflection, Engagement, MAX_FACED, Removal, TouchedCut, WheelCentre, WheelPass, Workpiece,
};
use alloc::vec::Vec;

/// Height of the cusps that the sweep may leave where the part is straight or convex (mm); ten times that, 0.05 µm, on
/// a concave flank whose radius is the wheel's over 0.9, the tightest that is planned.
///
/// Between two positions of the wheel whose centres are d apart, seen from the part, a cusp of d² ρ/(8 R (ρ + R)) stays
/// (R wheel, ρ part, negative where concave): at most d²/(8 R) on convex parts, which gives the largest d.
const CUSP_MM: f64 = 5.0e-6;

/// Distance by which the deflection may change in a servo step without a new search for the contact (mm).
const DEFLECTS_MM: f64 = 0.005;

/// One servo step of the wheel along the sections in front of it.
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
    /// The wheel in the present tick, along the section nearest to its middle.
    pass: WheelPass,
    /// The same along the sections beside.
    beside: Vec<WheelPass>,
}

snapshot_groups!(ContactState {
    keep_force(fields: deflection, force_n, push_n, force_monitor),
    keep_gap(equipment: gap),
    keep_modes(equipment: modes),
} on { pass, beside });

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
            beside: alloc::vec![WheelPass::new(); MAX_FACED - 1],
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
        self.beside.iter_mut().for_each(WheelPass::begin);
    }

    /// Ends a tick along the sections of a lobe: makes the cuts that wait.
    pub(super) fn finish(&mut self, part: &mut Workpiece, faced: &FacedSections) -> Removal {
        let removal = part.lobe_mut(faced.main.lobe).finish(&mut self.pass);
        let beside = faced.beside().zip(&mut self.beside);
        beside.fold(removal, |removal, (section, pass)| removal.beside(part.lobe_mut(section.lobe).finish(pass)))
    }

    /// Sweeps the sections of a lobe along a servo step, in steps so small that the cusps between them do not matter.
    #[allow(clippy::cast_possible_truncation, reason = "clamped to u32 before the cast")]
    pub(super) fn grind(&mut self, part: &mut Workpiece, faced: &FacedSections, sweep: &LobeSweep<'_>) -> Removal {
        let LobeSweep { c, x, per_rad, per_mm, rotation_sense: sense, step_s, surface, cuts } = *sweep;
        let (main, law) = (faced.main.lobe, faced.main.law.as_ref());
        let turn = libm::round(TURN_RAD * per_rad);
        // Between its ends the cubic swings out by less than the speeds at its ends times the step.
        let swing = (x.from_velocity.abs() + x.to_velocity.abs()) * step_s;
        let vibration_mm = self.modes.as_ref().map_or(0.0, ContactModes::reach_mm);
        let nearest_mm =
            (x.from.min(x.to) - swing) / per_mm + surface.centre_mm - surface.maximum_thrown_mm() - vibration_mm;
        let reach_mm = |section: FacedSection| {
            part.lobes()[section.lobe].reach_mm() + part.lobes()[section.lobe].throw_mm() + section.rim_mm
        };
        if nearest_mm - surface.radius_mm >= faced.beside().map(reach_mm).fold(reach_mm(faced.main), f64::max) {
            let removal = self.finish(part, faced);
            part.lobe_mut(main).leave();
            faced.beside().for_each(|section| part.lobe_mut(section.lobe).leave());
            self.separate();
            return removal;
        }
        let throw = part.lobes()[main].centre();
        let centre = x.from.max(x.to) / per_mm + surface.centre_mm;
        let path = (c.to - c.from).abs() / per_rad * centre.abs() + (x.to - x.from).abs() / per_mm;
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
        part.lobes()[main].list_blocks(faced.main.wheel(begin), law.is_some(), margin_mm, &mut self.pass);
        for (section, pass) in faced.beside().zip(&mut self.beside) {
            part.lobes()[section.lobe].list_blocks(section.wheel(begin), law.is_some(), margin_mm, pass);
        }
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
                None if cuts && self.gap.is_none() => {
                    let taken = part.lobe_mut(main).pass_later(faced.main.wheel(wheel), &mut self.pass);
                    let beside = faced.beside().zip(&mut self.beside);
                    beside.fold(taken, |taken, (section, pass)| {
                        taken.beside(part.lobe_mut(section.lobe).pass_later(section.wheel(wheel), pass))
                    })
                }
                None => pass_all(part, faced, wheel, cuts),
                Some(law) if self.modes.is_some() => {
                    self.press_on_modes(part, faced, wheel, law, (cuts, step_s / f64::from(positions)))
                }
                Some(law) => {
                    let time_s = step_s / f64::from(positions);
                    let (taken, deflection) = self.press(part, faced, wheel, law, self.deflection, (cuts, time_s));
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
        part: &mut Workpiece,
        faced: &FacedSections,
        wheel: WheelCentre,
        law: &ContactLaw,
        (cuts, time_s): (bool, f64),
    ) -> Removal {
        let part_mm_n = faced.main.part_mm_n;
        let Some(step) = self.modes.as_ref().and_then(|modes| modes.begin(law, part_mm_n, time_s)) else {
            return pass_all(part, faced, wheel, cuts);
        };
        let normal = self.deflection.normal;
        let carried = wheel.carried(Deflection { mm: step.away_mm, normal });
        let before = Deflection { mm: self.deflection.mm - step.away_mm, normal };
        let (taken, deflection) = self.press(part, faced, carried, &step.law, before, (cuts, time_s));
        self.force_n = step.law.force_n(deflection.mm);
        self.deflection = Deflection { mm: step.away_mm + deflection.mm, ..deflection };
        if let Some(modes) = &mut self.modes {
            modes.finish((law, part_mm_n), time_s, self.force_n);
        }
        taken
    }

    /// The wheel presses on one section, or on several that deflect it together. `law` is that of the section nearest to its middle.
    fn press(
        &mut self,
        part: &mut Workpiece,
        faced: &FacedSections,
        wheel: WheelCentre,
        law: &ContactLaw,
        before: Deflection,
        (cuts, time_s): (bool, f64),
    ) -> (Removal, Deflection) {
        if faced.is_alone() {
            let (lobe, wheel) = (part.lobe_mut(faced.main.lobe), faced.main.wheel(wheel));
            return lobe.press(wheel, law, before, (cuts, time_s), &mut self.pass);
        }
        let mut removal = Removal::default();
        let mut touches: [Option<DeepestTouch>; MAX_FACED] = [None; MAX_FACED];
        let mut surfaces = [EngagedWidth { engagement_mm: 0.0, law: *law }; MAX_FACED];
        let mut count = 0;
        for (index, found) in touches.iter_mut().enumerate() {
            let Some((section, pass)) = self.section(faced, index) else { break };
            let (lobe, wheel) = (part.lobe_mut(section.lobe), section.wheel(wheel));
            let parted = match lobe.engage(wheel, before, pass) {
                Engagement::Clear => Removal::default(),
                Engagement::OverCentre => lobe.pass(wheel, cuts),
                Engagement::Apart => lobe.part_from(pass),
                Engagement::Touch(touch) => {
                    *found = Some(touch);
                    let own = section.law.filter(|_| index > 0).unwrap_or(*law);
                    surfaces[count] = EngagedWidth { engagement_mm: touch.depth_mm, law: own };
                    count += 1;
                    continue;
                }
            };
            removal = if index == 0 { removal.and(parted) } else { removal.beside(parted) };
        }
        let deepest = touches.iter().flatten().max_by(|a, b| a.depth_mm.total_cmp(&b.depth_mm));
        let Some(deepest) = deepest else { return (removal, Deflection::default()) };
        let mm = match cuts {
            true => shared_deflection_mm(law.machine_n_mm(), &mut surfaces[..count]),
            false => deepest.depth_mm,
        };
        let deflection = Deflection { mm, normal: deepest.normal };
        let force_n = law.force_n(deflection.mm);
        for (index, touch) in touches.iter().enumerate() {
            let (Some(touch), Some((section, pass))) = (touch, self.section(faced, index)) else { continue };
            let depth_mm = if cuts { (touch.depth_mm - mm).max(0.0) } else { 0.0 };
            let cut = TouchedCut { depth_mm, deflection, force_n, cuts, time_s };
            let taken = part.lobe_mut(section.lobe).cut_touched(section.wheel(wheel), *touch, &cut, pass);
            removal = if index == 0 { removal.and(taken) } else { removal.beside(taken) };
        }
        (removal, deflection)
    }

    /// A section with the wheel's pass along it: 0 is the one nearest to the middle of the wheel.
    fn section(&mut self, faced: &FacedSections, index: usize) -> Option<(FacedSection, &mut WheelPass)> {
        match index.checked_sub(1) {
            None => Some((faced.main, &mut self.pass)),
            Some(beside) => Some((faced.beside().nth(beside)?, self.beside.get_mut(beside)?)),
        }
    }
}

/// The wheel stands in all sections for a moment.
fn pass_all(part: &mut Workpiece, faced: &FacedSections, wheel: WheelCentre, cuts: bool) -> Removal {
    let removal = part.lobe_mut(faced.main.lobe).pass(faced.main.wheel(wheel), cuts);
    let beside = |removal: Removal, section: FacedSection| {
        removal.beside(part.lobe_mut(section.lobe).pass(section.wheel(wheel), cuts))
    };
    faced.beside().fold(removal, beside)
}

/// Azimuth of the wheel line seen from the part (rad), with C at so many counts of which `turn` are a turn.
pub(super) fn line_rad(counts: f64, turn: f64, sense: f64) -> f64 {
    sense * libm::fmod(counts, turn) / turn * TURN_RAD
}
