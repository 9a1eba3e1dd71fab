// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Depth of the wheel in the part, walked over the whole of a plan before anything moves.
//!
//! [`clearance`](super::clearance) keeps the wheel away from everything that a step does not grind. This walk looks at the lobe that it does
//! grind, and at nothing of how the plan was made:
//!
//! | step | must stay above |
//! |---|---|
//! | move of X or C before a lobe is cut | its raw surface |
//! | the same afterwards | its finished contour |
//! | push of a stopped wheel | what the job lets it push |
//! | cut | the path keeps to the contour; infeed and lead never go below the path, but for what a gauge-controlled size allows |
//! | correction of runout | the radius that the contact law leaves, over the whole way |
//!
//! Above a lobe with taper or crown, and under a rim with a profile, every section of the width counts: see
//! [`axial_profile`](crate::machine::axial_profile).

use super::error::PlanError;
use super::lobe::{PlannedLobe, extremes};
use super::outline::ContourPoints;
use crate::gauging::journal::JournalCorrection;
use crate::job::grinding::JobSpec;
use crate::machine::axial_profile::AXIAL_TOLERANCE_MM;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use crate::math::hermite::HermiteSpline;
use crate::math::hull::lowest;
use crate::math::units::{TURN_RAD, deg_from_rad, wrap_turn};
use crate::motion::plan::{CutSegment, Plan, PlanCommand, Segment, SegmentKind};
use alloc::vec::Vec;

/// Allowance for the rounding of positions to counts, between its knots, and between the points of an outline (mm): that
/// of the check of clearance, a hundred times what a path may leave its contour.
const ROUNDING_MM: f64 = 1e-4;
/// Depth below the path that rounding of infeed and lead may cause (mm), as [`check_plan`](crate::planner::plan_check::check_plan) has it.
const LAW_ROUNDING_MM: f64 = 1e-6;
/// Distance of the table from a plunge at which it stands there (mm).
const AT_PLUNGE_MM: f64 = 1e-3;
/// Places of a straight move that are looked at.
const MOVE_PLACES: u32 = 256;
/// Most places of a path that are looked at; four to a knot where it has fewer.
const MAX_PATH_PLACES: usize = 7200;

/// A plan, and the part that it is for.
#[derive(Clone, Copy)]
pub(super) struct GougeRequest<'a> {
    pub(super) job: &'a JobSpec,
    pub(super) machine: &'a MachineDescription,
    pub(super) lobes: &'a [PlannedLobe],
    pub(super) plan: &'a Plan,
    pub(super) start_counts: [i64; AXIS_COUNT],
    /// C knows its zero.
    pub(super) c_homed: bool,
    /// Material above each finished contour before the plan (mm).
    pub(super) stock_mm: &'a [f64],
    /// Correction of each lobe in the plan; none where the lobe is ground.
    pub(super) corrections: &'a [JournalCorrection],
}

/// Walks through a plan.
///
/// # Errors
/// The first place at which the wheel would be deeper in the part than allowed.
pub(super) fn check_gouges(request: &GougeRequest<'_>) -> Result<(), PlanError> {
    let lobes = request.lobes.len();
    let mut walk = GougeCheck {
        request,
        at: request.start_counts,
        knows_c: request.c_homed,
        is_cut: alloc::vec![false; lobes],
        wheel: request.machine.mounted_wheel(),
        pushes_mm: None,
        outlines: alloc::vec![None; request.job.profiles.len()],
        paths: Vec::new(),
    };
    request.plan.segments.iter().try_for_each(|segment| walk.step(segment))
}

struct GougeCheck<'a> {
    request: &'a GougeRequest<'a>,
    /// Positions of the axes (counts).
    at: [i64; AXIS_COUNT],
    /// C stands where `at` says.
    knows_c: bool,
    /// Lobes that have been cut.
    is_cut: Vec<bool>,
    /// Position of the mounted wheel in the changer.
    wheel: usize,
    /// Longest travel of the stopped wheel's push (mm).
    pushes_mm: Option<f64>,
    /// Contour of each profile, once it is needed.
    outlines: Vec<Option<ContourPoints>>,
    /// Paths that keep to the contour of a lobe.
    paths: Vec<(usize, usize)>,
}

/// A depth that is no number is deeper than any.
fn is_deeper(depth_mm: f64, allowed_mm: f64) -> bool {
    depth_mm.is_nan() || depth_mm > allowed_mm
}

/// A place where the wheel is too deep.
struct DeepestPoint {
    c_rad: f64,
    turn: Option<f64>,
    depth_mm: f64,
    allowed_mm: f64,
    surface: &'static str,
    why: &'static str,
}

impl GougeCheck<'_> {
    fn step(&mut self, segment: &Segment) -> Result<(), PlanError> {
        match &segment.kind {
            SegmentKind::Move(targets) => {
                let mut to = self.at;
                targets.iter().for_each(|target| to[target.axis.index()] = target.target_counts);
                self.line(segment, to)?;
                self.at = to;
            }
            SegmentKind::Search { axis, input, travel_counts, offset_counts, .. } => {
                let axis = *axis;
                let station = self.request.machine.station(input);
                if axis == Axis::C {
                    self.knows_c = false;
                    self.line(segment, self.at)?;
                }
                self.at[axis.index()] = station.map_or(self.at[axis.index()] + travel_counts, |station| {
                    self.request.machine.axis(axis).scale.counts(station.position_mm) + offset_counts
                });
            }
            SegmentKind::Command(PlanCommand::SetHome(axis)) => {
                self.at[axis.index()] = 0;
                self.knows_c |= *axis == Axis::C;
            }
            SegmentKind::Command(PlanCommand::Push { max_n }) => {
                let push_mm = self.request.job.identification.map_or(0.0, |identification| identification.push_mm);
                self.pushes_mm = (*max_n > 0).then_some(push_mm);
            }
            SegmentKind::Command(PlanCommand::ChangeWheel { wheel }) => self.wheel = *wheel as usize,
            SegmentKind::Command(PlanCommand::WheelStart) => self.pushes_mm = None,
            SegmentKind::Cut(cut) => self.cut(segment, cut)?,
            SegmentKind::Spiral(_)
            | SegmentKind::Dwell
            | SegmentKind::Wait
            | SegmentKind::Command(_)
            | SegmentKind::Home(_) => {}
        }
        Ok(())
    }

    fn position(&self, axis: Axis, counts: i64) -> f64 {
        self.request.machine.axis(axis).scale.position(counts)
    }

    /// Lobes that face the wheel, however little of them; of the visits to a lobe those of the mounted wheel. A wheel that stands at a plunge cuts its overlap with the neighbours too, and none
    /// of what only they cut.
    fn facing(&self, z_mm: f64) -> impl Iterator<Item = usize> + use<> {
        let machine = self.request.machine;
        let wheel_mm = machine.wheel_at(self.wheel).width_mm;
        let away_mm = |lobe: &PlannedLobe| lobe.design.z_mm(machine).map(|lobe_mm| (lobe_mm - z_mm).abs());
        let stands_at = |lobe: &&PlannedLobe| away_mm(lobe).is_some_and(|away_mm| away_mm < AT_PLUNGE_MM);
        let plunge = self.request.lobes.iter().filter(|lobe| lobe.design.plunge.is_some()).find(stands_at);
        let faces = self.request.lobes.iter().map(|lobe| {
            let is_beside =
                plunge.is_some_and(|plunge| plunge.design.is_of_one_lobe(&lobe.design) && !core::ptr::eq(plunge, lobe));
            if is_beside || lobe.design.wheel(machine) != self.wheel {
                return false;
            }
            let half_mm = 0.5 * (lobe.design.width_mm + wheel_mm);
            away_mm(lobe).is_some_and(|away_mm| away_mm < half_mm)
        });
        let faces: Vec<bool> = faces.collect();
        faces.into_iter().enumerate().filter(|(_, faces)| *faces).map(|(index, _)| index)
    }

    /// Angle of the wheel line in the frame of a lobe for an angle of C (rad).
    fn angle_on(&self, lobe: usize, c_rad: f64) -> f64 {
        f64::from(self.request.machine.rotation_sense.signum()) * c_rad - self.request.lobes[lobe].design.phase_rad
    }

    /// Distance of the wheel from a finished lobe (mm); of an angle that is not known, all round.
    fn gap_mm(&mut self, lobe: usize, x_mm: f64, c_rad: Option<f64>) -> f64 {
        let planned = &self.request.lobes[lobe];
        let Some(c_rad) = c_rad else { return x_mm - extremes(planned.tool_path.spline()).1 };
        let (angle_rad, wheel_mm) = (self.angle_on(lobe, c_rad), planned.tool_path.wheel_radius_mm());
        self.outline(lobe).gap_mm(wheel_mm, x_mm, angle_rad)
    }

    fn outline(&mut self, lobe: usize) -> &ContourPoints {
        let contour = &self.request.lobes[lobe].design.contour;
        self.outlines[self.request.job.lobes[lobe].profile].get_or_insert_with(|| ContourPoints::new(contour))
    }

    /// Depth of the wheel's rim below the design of its own section, where its middle stands on the contour, that the shape of the lobe does
    /// not allow (mm).
    fn rim_below_mm(&self, lobe: usize) -> f64 {
        let below_mm = self.request.job.rim_below_design_mm(self.request.machine, lobe);
        (below_mm - AXIAL_TOLERANCE_MM).max(0.0)
    }

    /// The lowest place that a lobe allows to the middle of a wheel that does not feed, by its distance from the finished contour (mm).
    fn bound(&self, lobe: usize) -> (f64, &'static str, &'static str) {
        let (low_mm, surface, why) = self.middle_bound(lobe);
        let rim_mm = match self.pushes_mm {
            None if !self.is_cut[lobe] => self.request.job.rim_above_raw_mm(self.request.machine, lobe),
            _ => self.rim_below_mm(lobe),
        };
        (low_mm + rim_mm, surface, why)
    }

    /// The same for a straight rim and a straight lobe.
    fn middle_bound(&self, lobe: usize) -> (f64, &'static str, &'static str) {
        match self.pushes_mm {
            Some(push_mm) => (-push_mm, "the finished contour", "the push of the stopped wheel"),
            None if self.is_cut[lobe] => (0.0, "the finished contour", "rounding"),
            None => (self.request.stock_mm.get(lobe).copied().unwrap_or(0.0), "the raw surface", "rounding"),
        }
    }

    /// A straight line from where the axes stand; X that goes outwards alone leaves what it stands in.
    fn line(&mut self, segment: &Segment, to: [i64; AXIS_COUNT]) -> Result<(), PlanError> {
        let from = self.at;
        let moved = |axis: Axis| to[axis.index()] - from[axis.index()];
        if self.knows_c && moved(Axis::C) == 0 && moved(Axis::X) >= 0 {
            return Ok(());
        }
        // Tables are looked after by the check of clearance, to which the lobe is a body of revolution.
        if moved(Axis::Z) != 0 && segment.phase != crate::motion::plan::Phase::Position {
            return Ok(());
        }
        let places = if moved(Axis::C) == 0 && moved(Axis::Z) == 0 { 1 } else { MOVE_PLACES };
        for place in 0..=places {
            let share = f64::from(place) / f64::from(places);
            let at = |axis: Axis| {
                let (from, to) = (self.position(axis, from[axis.index()]), self.position(axis, to[axis.index()]));
                from + share * (to - from)
            };
            // What X stands in when an approach begins is not for this step to judge.
            if share == 0.0 && moved(Axis::X) != 0 {
                continue;
            }
            let (c_rad, x_mm, z_mm) = (at(Axis::C), at(Axis::X), at(Axis::Z));
            for lobe in self.facing(z_mm) {
                let (min_mm, surface, why) = self.bound(lobe);
                let gap_mm = self.gap_mm(lobe, x_mm, Some(c_rad).filter(|_| self.knows_c));
                if gap_mm < min_mm - ROUNDING_MM {
                    let (depth_mm, allowed_mm) = match self.pushes_mm {
                        Some(push_mm) => (-gap_mm, push_mm + ROUNDING_MM),
                        None => (min_mm - gap_mm, ROUNDING_MM),
                    };
                    return Err(self.deep(
                        segment,
                        lobe,
                        DeepestPoint { c_rad, turn: None, depth_mm, allowed_mm, surface, why },
                    ));
                }
            }
        }
        Ok(())
    }

    fn cut(&mut self, segment: &Segment, cut: &CutSegment) -> Result<(), PlanError> {
        let plan = self.request.plan;
        // A cut of splines that are not there is found by the forward check.
        let (Some(motion), Some(lobe)) = (plan.motion_of(cut), segment.lobe) else { return Ok(()) };
        if lobe >= self.request.lobes.len() {
            return Ok(());
        }
        self.keeps_to_contour(segment, cut, lobe)?;
        let begins_rad = self.position(Axis::C, cut.start_counts);
        let surface = "the finished contour";
        match self.request.corrections.get(lobe) {
            Some(correction) => {
                let wheel_mm = self.request.lobes[lobe].tool_path.wheel_radius_mm();
                let found = correction.lowest(wheel_mm, |angle| motion.over_angle(angle));
                let depth_mm = self.request.lobes[lobe].design.contour.radius_at(0.0) - found.radius_mm;
                let (angle_rad, allowed_mm) = (found.angle_rad, correction.allowed_below_mm);
                if is_deeper(depth_mm, allowed_mm) {
                    let why =
                        "what a correction may leave; more runout_correction.allowance_um keeps the wheel farther out";
                    let (c_rad, turn) = (begins_rad + angle_rad, Some(angle_rad / TURN_RAD));
                    return Err(self.deep(
                        segment,
                        lobe,
                        DeepestPoint { c_rad, turn, depth_mm, allowed_mm, surface, why },
                    ));
                }
            }
            None => {
                let law = |law: &HermiteSpline| (lowest(law), LAW_ROUNDING_MM, "rounding");
                let (size_mm, why) = match self.request.job.size_control() {
                    Some(size) => (size.beyond_mm, "gauge_size.beyond_um, before which the gauge ends the infeed"),
                    None => (0.0, "rounding"),
                };
                let of_infeed = ((lowest(motion.infeed), size_mm + LAW_ROUNDING_MM, why), true);
                let of_lead = motion.lead.map(|lead| (law(lead), false));
                for ((found, allowed_mm, why), is_angle) in [Some(of_infeed), of_lead].into_iter().flatten() {
                    if is_deeper(-found.value, allowed_mm) {
                        let angle_rad = if is_angle { found.at } else { motion.law.sample(found.at).value };
                        let (c_rad, turn) = (begins_rad + angle_rad, Some(angle_rad / TURN_RAD));
                        let depth_mm = -found.value;
                        return Err(self.deep(
                            segment,
                            lobe,
                            DeepestPoint { c_rad, turn, depth_mm, allowed_mm, surface, why },
                        ));
                    }
                }
            }
        }
        let c = &self.request.machine.axis(Axis::C).scale;
        self.at[Axis::C.index()] = cut.start_counts + i64::from(cut.turns) * c.counts(TURN_RAD);
        self.at[Axis::X.index()] = self.request.machine.axis(Axis::X).scale.counts(motion.x_mm(motion.end_s()));
        self.knows_c = motion.end_speeds_rad_s().1 <= 0.0;
        self.is_cut[lobe] = true;
        Ok(())
    }

    /// The wheel on the path of a cut stands nowhere in the finished lobe, but for what a learned correction takes it in by.
    fn keeps_to_contour(&mut self, segment: &Segment, cut: &CutSegment, lobe: usize) -> Result<(), PlanError> {
        let profile = self.request.job.lobes[lobe].profile;
        let learned = self.request.job.compensation.iter().flat_map(|compensation| &compensation.learned);
        let learned = learned.filter(|learned| learned.lobe == self.request.lobes[lobe].design.name);
        let learned_mm = learned.map(|learned| learned.correction.largest().0.abs()).fold(0.0, f64::max);
        // A wheel before the last stops short of the path by what it leaves.
        let is_last = self.request.lobes[lobe].design.is_finished();
        let rim_mm = if is_last { self.rim_below_mm(lobe) } else { 0.0 };
        if learned_mm <= 0.0 && rim_mm <= 0.0 && self.paths.contains(&(cut.path, profile)) {
            return Ok(());
        }
        let path = &self.request.plan.paths[cut.path];
        let (sense, wheel_mm) = (
            f64::from(self.request.machine.rotation_sense.signum()),
            self.request.lobes[lobe].tool_path.wheel_radius_mm(),
        );
        let (places, allowed_mm) = ((4 * path.coefficients().len()).min(MAX_PATH_PLACES), learned_mm + ROUNDING_MM);
        for place in 0..places {
            let angle = place as f64 * TURN_RAD / places as f64;
            let x_mm = path.sample(angle).value;
            let gap_mm = self.outline(lobe).gap_mm(wheel_mm, x_mm, sense * angle) - rim_mm;
            if is_deeper(-gap_mm, allowed_mm) {
                let c_rad = self.position(Axis::C, cut.start_counts) + wrap_turn(angle - cut.path_start_rad);
                let why = if learned_mm > 0.0 { "the learned correction" } else { "rounding" };
                let surface = "the finished contour";
                let deep = DeepestPoint { c_rad, turn: None, depth_mm: -gap_mm, allowed_mm, surface, why };
                return Err(self.deep(segment, lobe, deep));
            }
        }
        self.paths.push((cut.path, profile));
        Ok(())
    }

    fn deep(&self, segment: &Segment, lobe: usize, deep: DeepestPoint) -> PlanError {
        PlanError::Gouges {
            step: segment.label.clone(),
            lobe: self.request.lobes[lobe].design.name.clone(),
            turn: deep.turn,
            c_deg: deg_from_rad(wrap_turn(deep.c_rad)),
            depth_mm: deep.depth_mm,
            allowed_mm: deep.allowed_mm,
            surface: deep.surface,
            why: deep.why,
        }
    }
}
