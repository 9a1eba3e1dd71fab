// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Each lobe by itself: its shape, the phase it begins at, its speed plan, and whether there is room.

use super::error::PlanError;
use super::error::{IdleWheelStep, RequiredPosition};
use super::host::{OneByOne, PlanHost};
use super::wheels::no_path;
use crate::cam::compensation::FormCurve;
use crate::cam::contour::{Contour, LobeCentre};
use crate::cam::form_tolerance::FormTolerance;
use crate::job::axial_shape;
use crate::job::dressing::{LobeStock, WheelCourse, stock_area_mm2};
use crate::job::grinding::Subject;
use crate::job::grinding::{InfeedDirection, JobSpec, LobeSpec};
use crate::job::infeed::InfeedSchedule;
use crate::job::part_support::{self, PartSupport};
use crate::job::plunges::{self, LobeSection, Plunge};
use crate::job::wheel_visit::{self, WheelVisit};
use crate::machine::axial_profile::AxialProfile;
use crate::machine::contact_law::ContactLaw;
use crate::machine::description::{Axis, MachineDescription, WheelsNow};
use crate::math::periodic_spline::{PeriodicSpline, PeriodicSplineError};
use crate::math::range::minimum_and_maximum;
use crate::math::units::{TURN_RAD, deg_from_rad, wrap_turn};
use crate::motion::speed_plan::{FlyingStart, SpeedPlan, SpeedRequest};
use crate::toolpath::wheel_path::ToolPath;
use alloc::string::String;
use alloc::vec::Vec;

/// Nominal geometry of a lobe: contour and position on the part, the reference of every measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct LobeDesign {
    /// Name of the lobe.
    pub name: String,
    /// Limit switch of its station.
    pub station: String,
    /// Contour in the lobe's own frame.
    pub contour: Contour,
    /// Azimuth of the lobe's cam angle 0 where the part is taken to be clamped: from where its keyway should be (rad).
    pub phase_rad: f64,
    /// Assumed angle of its keyway (rad).
    pub part_phase_rad: f64,
    /// Width (mm); of a plunge the width of the wheel.
    pub width_mm: f64,
    /// Allowed form error.
    pub tolerance: FormTolerance,
    /// Plunge of a lobe wider than the wheel that this is.
    pub plunge: Option<Plunge>,
    /// Visit of one wheel of a changer that this is.
    pub visit: Option<WheelVisit>,
    /// Taper and crown over its width; `None`: it is straight.
    pub axial: Option<AxialProfile>,
    /// The part on its supports as a round shaft; `None`: the part is as stiff as the machine's contact says.
    pub part_support: Option<PartSupport>,
}

impl LobeDesign {
    /// It is a journal: as large all round the spindle axis.
    #[must_use]
    pub fn is_round(&self) -> bool {
        const SAME_MM: f64 = 1e-9;
        if self.contour.is_pin() || self.contour.is_bore() {
            return false;
        }
        let radius = |i: u32| self.contour.radius_at(f64::from(i) * TURN_RAD / 36.0);
        (1..36).all(|i| (radius(i) - radius(0)).abs() < SAME_MM)
    }

    /// Middle of the wheel from the position of the station when it grinds this (mm).
    #[must_use]
    pub fn offset_mm(&self) -> f64 {
        self.plunge.as_ref().map_or(0.0, |plunge| plunge.offset_mm(self.width_mm))
    }

    /// Position of `z_axis` at which the wheel grinds this (mm); `None` on a machine without its station.
    #[must_use]
    pub fn z_mm(&self, machine: &MachineDescription) -> Option<f64> {
        Some(machine.station(&self.station)?.position_mm + self.offset_mm())
    }

    /// Contact law of wheel and lobe where it is ground, of a plunge over the width that no plunge has cut before; `None` on a rigid machine.
    #[must_use]
    pub fn contact_law(&self, machine: &MachineDescription) -> Option<ContactLaw> {
        let part_mm_n = self.part_compliance_mm_n(machine, self.offset_mm());
        let wheel_mm = machine.wheel_at(self.wheel(machine)).width_mm;
        plunges::contact_law(machine, wheel_mm, &self.station, self.width_mm, self.plunge.as_ref(), part_mm_n)
    }

    /// Radial compliance of the part on its supports beside the position of the station (mm/N, mm); 0 of a part as stiff as the machine's
    /// contact says.
    #[must_use]
    pub fn part_compliance_mm_n(&self, machine: &MachineDescription, offset_mm: f64) -> f64 {
        part_support::compliance_mm_n(self.part_support.as_ref(), machine, &self.station, offset_mm)
    }

    /// Position of the wheel that grinds this; the mounted one where the job names none.
    #[must_use]
    pub fn wheel(&self, machine: &MachineDescription) -> usize {
        wheel_visit::wheel_of(self.visit.as_ref(), machine)
    }

    /// The lobe is finished with this, or a section of it.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        wheel_visit::finishes(self.visit.as_ref())
    }

    /// Sections of the part that are finished with this, its own first: one, several of a plunge, none of a wheel's visit after which
    /// another wheel comes.
    #[must_use]
    pub fn sections(&self) -> Vec<LobeSection> {
        if !self.is_finished() {
            return Vec::new();
        }
        match &self.plunge {
            Some(plunge) => plunge.finished_sections(self.width_mm),
            None => axial_shape::sections(&self.name, self.width_mm, self.axial),
        }
    }

    /// Distance of the design of a section outside the contour (mm); 0 of any other name than that of its sections.
    #[must_use]
    pub fn above_mm(&self, section: &str) -> f64 {
        self.sections().into_iter().find(|found| found.name == section).map_or(0.0, |found| found.above_mm)
    }

    /// Both are plunges of one lobe, or visits of wheels to one.
    #[must_use]
    pub fn is_of_one_lobe(&self, other: &Self) -> bool {
        plunges::are_beside(self.plunge.as_ref(), other.plunge.as_ref())
            || wheel_visit::visit_together(self.visit.as_ref(), other.visit.as_ref())
    }

    /// Centre of its contour on a part whose keyway truly lies at an azimuth (rad); `None` for the spindle axis, which it is but for a
    /// crank pin.
    #[must_use]
    pub fn centre_on(&self, key_way_rad: f64) -> Option<LobeCentre> {
        let azimuth_rad = wrap_turn(self.phase_on_rad(key_way_rad));
        self.contour.is_pin().then(|| LobeCentre { distance_mm: self.contour.throw_mm(), azimuth_rad })
    }

    /// Azimuth of its cam angle 0 on a part whose keyway truly lies at an azimuth (rad).
    #[must_use]
    pub fn phase_on_rad(&self, key_way_rad: f64) -> f64 {
        self.phase_rad - self.part_phase_rad + key_way_rad
    }

    /// Radius of the finished lobe about its centre at an azimuth of the part, measured from the keyway (mm, rad).
    #[must_use]
    pub fn radius_at(&self, part_azimuth_rad: f64) -> f64 {
        self.contour.radius_at(part_azimuth_rad - self.phase_rad)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct PlannedLobe {
    /// Nominal geometry.
    pub design: LobeDesign,
    /// Path of the wheel over the wheel-line angle in the lobe's frame, for the wheel as it is then.
    pub tool_path: ToolPath,
    /// Its index among the paths of the plan.
    pub path: usize,
    /// Wear of the wheel since its last dress at the end of the lobe, predicted (mm): what it leaves on the lobe.
    pub wear_mm: f64,
    /// Wheel-line angle in the lobe's frame at which cutting begins (rad, in 0..2π).
    pub start_rad: f64,
    /// Block of the table from which it is read: the one that begins at or before the start angle.
    pub start_block: u32,
    /// Speed and infeed of every pass.
    pub passes: Vec<SpeedPlan>,
}

/// A profile as a wheel sees it.
#[derive(Debug, Clone)]
pub(super) struct WheelShape {
    /// Index of the profile.
    pub(super) profile: usize,
    /// Index of the lobe for which alone it is: that of a correction.
    pub(super) lobe: Option<usize>,
    pub(super) contour: Contour,
    pub(super) tool_path: ToolPath,
    /// The path over σ times the wheel-line angle, as plans carry it.
    pub(super) path: PeriodicSpline,
    /// Way of X per depth along the contour's normal, over the same, where the job's infeed is measured so.
    pub(super) ratio: Option<PeriodicSpline>,
}

/// Position of C at the start of a lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LobeStart {
    /// C (counts).
    pub(super) c_counts: i64,
    /// σ times the wheel-line angle in the lobe's frame (rad, in 0..2π).
    pub(super) path_rad: f64,
}

/// Nominal geometry of every lobe of a job.
///
/// # Errors
/// A profile without a contour, a lobe without a profile.
pub fn designs(job: &JobSpec) -> Result<Vec<LobeDesign>, PlanError> {
    let contours = contours(job, &OneByOne)?;
    let design = |lobe: &LobeSpec| {
        let count = contours.len();
        let contour = contours.get(lobe.profile).cloned().ok_or_else(|| {
            crate::job::grinding::JobError::UnknownProfile { lobe: lobe.name.clone(), profile: lobe.profile, count }
        })?;
        Ok(designed(job, lobe, contour))
    };
    job.lobes.iter().map(design).collect()
}

fn designed(job: &JobSpec, lobe: &LobeSpec, contour: Contour) -> LobeDesign {
    LobeDesign {
        name: lobe.name.clone(),
        station: lobe.station.clone(),
        contour,
        phase_rad: lobe.phase_rad,
        part_phase_rad: job.part_phase_rad,
        width_mm: lobe.width_mm,
        tolerance: lobe.tolerance,
        plunge: lobe.plunge.clone(),
        visit: lobe.visit.clone(),
        axial: lobe.axial,
        part_support: job.part_support,
    }
}

pub(super) fn contours(job: &JobSpec, host: &impl PlanHost) -> Result<Vec<Contour>, PlanError> {
    let contour = |index: usize| {
        let profile = &job.profiles[index];
        profile.contour().map_err(|source| PlanError::Contour { profile: profile.name.clone(), source })
    };
    host.map(job.profiles.len(), contour).into_iter().collect()
}

/// Contour and path of every profile for the wheel of the first lobe, in the order of the job; then of what later lobes
/// need for theirs.
pub(super) fn shapes(
    job: &JobSpec,
    machine: &MachineDescription,
    contours: &[Contour],
    wheel: &WheelCourse,
    host: &impl PlanHost,
) -> Result<Vec<WheelShape>, PlanError> {
    let along_normal = job.passes.iter().any(|pass| pass.infeed_direction == InfeedDirection::Normal);
    let shape = |profile: usize, radius_mm: f64, lobe: Option<usize>| {
        let contour = contours[profile].clone();
        let design = || {
            ToolPath::for_wheel(&contour, radius_mm).map_err(|source| no_path(job, machine, contours, profile, source))
        };
        let tool_path = match lobe.and_then(|lobe| learned_of(job, lobe)) {
            None => design()?,
            Some(correction) => ToolPath::compensated(&contour, correction, radius_mm).or_else(|source| {
                // What the wheel cannot grind anyway has nothing to do with what was learned.
                design()?;
                Err(PlanError::Compensated {
                    lobe: lobe.map_or_else(String::new, |lobe| job.lobes[lobe].name.clone()),
                    max_mm: correction.largest().0,
                    source,
                })
            })?,
        };
        let path = if machine.rotation_sense < 0 { tool_path.spline().mirrored() } else { tool_path.spline().clone() };
        let ratio = match along_normal {
            true => Some(normal_ratio(&path, radius_mm).map_err(|source| through_axis(job, profile, source))?),
            false => None,
        };
        Ok::<_, PlanError>(WheelShape { profile, lobe, contour, tool_path, path, ratio })
    };
    let mut shapes = Vec::new();
    for (index, (lobe, &radius_mm)) in job.lobes.iter().zip(&wheel.radii_mm).enumerate() {
        // A wheel of a changer need not fit the lobes that another one grinds.
        if index == 0 && lobe.visit.is_none() {
            for shape in host.map(contours.len(), |profile| shape(profile, radius_mm, None)) {
                shapes.push(shape?);
            }
        }
        let alone = learned_of(job, index).map(|_| index);
        if shape_of(&shapes, lobe.profile, alone, radius_mm).is_none() {
            shapes.push(shape(lobe.profile, radius_mm, alone)?);
        }
    }
    Ok(shapes)
}

/// Index of the shape of a profile for a wheel (mm), as designed or for one lobe alone.
pub(super) fn shape_of(
    shapes: &[WheelShape],
    profile: usize,
    lobe: Option<usize>,
    wheel_radius_mm: f64,
) -> Option<usize> {
    let same = |shape: &WheelShape| {
        let radius_mm = shape.tool_path.wheel_radius_mm();
        shape.profile == profile && shape.lobe == lobe && radius_mm.to_bits() == wheel_radius_mm.to_bits()
    };
    shapes.iter().position(same)
}

/// Learned correction of a lobe.
fn learned_of(job: &JobSpec, lobe: usize) -> Option<&FormCurve> {
    let name = &job.lobes[lobe].name;
    let learned = job.compensation.iter().flat_map(|compensation| &compensation.learned);
    learned.filter(|learned| learned.lobe == *name).map(|learned| &learned.correction).find(|curve| !curve.is_zero())
}

/// The wheel over the job: every dress, and the radius each lobe is ground with.
pub(super) fn wheel_course(
    job: &JobSpec,
    machine: &MachineDescription,
    contours: &[Contour],
    wheels: &WheelsNow,
) -> Result<WheelCourse, PlanError> {
    let areas: Vec<f64> = contours.iter().map(|contour| stock_area_mm2(contour, job.stock_mm)).collect();
    let lobes = job.lobes.iter().enumerate().map(|(index, lobe)| match &lobe.visit {
        None => LobeStock { name: &lobe.name, stock_mm: job.stock_mm, area_mm2: areas[lobe.profile], wheel: None },
        Some(visit) => {
            let left_mm = if visit.is_last { 0.0 } else { job.left_after_mm(visit.passes().end) };
            let (stock_mm, contour) = (job.stock_of_mm(index), &contours[lobe.profile]);
            let area_mm2 = stock_area_mm2(contour, stock_mm) - stock_area_mm2(contour, left_mm);
            LobeStock { name: &lobe.name, stock_mm: stock_mm - left_mm, area_mm2, wheel: Some(visit.wheel) }
        }
    });
    let lobes: Vec<LobeStock<'_>> = lobes.collect();
    let course = WheelCourse::new(job.dressing.as_ref(), machine, wheels, &lobes)?;
    for (lobe, &radius_mm) in job.lobes.iter().zip(&course.radii_mm) {
        (machine.wheel_at(lobe.wheel(machine)).check_speed(radius_mm))
            .map_err(|source| PlanError::WheelTooFast { lobe: lobe.name.clone(), source })?;
    }
    Ok(course)
}

/// Knots of the ratio over a turn. It says where the infeed goes, not where the finished contour is.
const RATIO_KNOTS: u32 = 720;

/// Way of X per depth along the contour's normal: 1/cos β, with tan β = X'/X of the wheel's centre. To first order in the depth s:
/// the wheel's centre is seen from the contact's centre of curvature, at the distance ρ, so that the path of a contour larger by
/// s all round lies s² tan²β/(2ρ cos β) lower, under 1 µm for 0.4 mm on an ordinary flank.
fn normal_ratio(path: &PeriodicSpline, wheel_radius_mm: f64) -> Result<PeriodicSpline, PeriodicSplineError> {
    let at = |knot: u32| {
        let x = path.sample(f64::from(knot) * TURN_RAD / f64::from(RATIO_KNOTS));
        let centre = x.value + wheel_radius_mm;
        libm::hypot(centre, x.first) / centre.abs()
    };
    let values: Vec<f64> = (0..RATIO_KNOTS).map(at).collect();
    PeriodicSpline::interpolate(&values)
}

/// The wheel's centre comes through the axis of the part, where no normal has a direction.
fn through_axis(job: &JobSpec, profile: usize, source: PeriodicSplineError) -> PlanError {
    let profile = job.profiles.get(profile).map(|profile| profile.name.clone()).unwrap_or_default();
    PlanError::NoNormal { profile, source }
}

/// Smallest and largest value, on four points per knot.
pub(super) fn extremes(spline: &PeriodicSpline) -> (f64, f64) {
    #[allow(clippy::cast_possible_truncation, reason = "knots are far below 2^30")]
    let count = 4 * spline.coefficients().len() as u32;
    let values = (0..count).map(|i| spline.sample(f64::from(i) * TURN_RAD / f64::from(count)).value);
    minimum_and_maximum(values)
}

/// Position of C at the start of each lobe. After homing C is 0; each lobe adds whole turns; rotary indexing first turns C the
/// shorter way to the lobe's cam angle 0.
pub(super) fn begins(
    job: &JobSpec,
    machine: &MachineDescription,
    schedules: &[InfeedSchedule],
    rotary_indexing: bool,
) -> Vec<LobeStart> {
    let scale = machine.axis(Axis::C).scale;
    let turn_counts = scale.counts(TURN_RAD);
    let sense = f64::from(machine.rotation_sense.signum());
    let turns_of = |lobe: &LobeSpec| {
        let passes = lobe.passes(job.passes.len());
        let spark_out: u32 = job.passes[passes.clone()].iter().map(|pass| pass.spark_out_turns).sum();
        i64::from(schedules[passes].iter().map(InfeedSchedule::turns).sum::<u32>() + spark_out)
    };
    let mut c_counts = 0_i64;
    job.lobes
        .iter()
        .map(|lobe| {
            if rotary_indexing {
                let there = (scale.counts(sense * lobe.phase_rad) - c_counts).rem_euclid(turn_counts);
                c_counts += if 2 * there > turn_counts { there - turn_counts } else { there };
            }
            let begin = begin_at(machine, lobe.phase_rad, c_counts);
            c_counts += turns_of(lobe) * turn_counts;
            begin
        })
        .collect()
}

/// Start of a lobe of this phase (rad) for a position of C (counts).
pub(super) fn begin_at(machine: &MachineDescription, phase_rad: f64, c_counts: i64) -> LobeStart {
    let scale = machine.axis(Axis::C).scale;
    let c_rad = scale.position(c_counts.rem_euclid(scale.counts(TURN_RAD)));
    let path_rad = wrap_turn(c_rad - f64::from(machine.rotation_sense.signum()) * phase_rad);
    LobeStart { c_counts, path_rad }
}

/// The block that begins at or before an angle. A millionth of a block below the next one counts as the next: an angle
/// of whole blocks, given in degrees, may round to just below itself.
pub(super) fn block_at(angle_rad: f64, blocks: u32) -> u32 {
    #[allow(clippy::cast_possible_truncation, reason = "an angle within one turn")]
    let block = libm::floor(wrap_turn(angle_rad) / TURN_RAD * f64::from(blocks) + 1e-6) as u32;
    block % blocks
}

/// Input for planning lobes.
#[derive(Clone, Copy)]
pub(super) struct LobePlanner<'a> {
    pub(super) job: &'a JobSpec,
    pub(super) machine: &'a MachineDescription,
    pub(super) shapes: &'a [WheelShape],
    pub(super) schedules: &'a [InfeedSchedule],
    pub(super) wheel: &'a WheelCourse,
}

impl LobePlanner<'_> {
    /// Start, speed and room of every lobe, each from rest to rest.
    pub(super) fn all(&self, begins: &[LobeStart], host: &impl PlanHost) -> Result<Vec<PlannedLobe>, PlanError> {
        let lobes = host.map(begins.len(), |index| self.lobe(index, begins[index], None, None));
        lobes.into_iter().collect()
    }

    /// Index of the shape of a lobe.
    pub(super) fn path_of(&self, index: usize) -> usize {
        let alone = learned_of(self.job, index).map(|_| index);
        shape_of(self.shapes, self.job.lobes[index].profile, alone, self.wheel.radii_mm[index])
            .expect("every lobe's profile got a path for the lobe's wheel")
    }

    /// Start of a lobe for a position of C (counts).
    pub(super) fn begin(&self, index: usize, c_counts: i64) -> LobeStart {
        begin_at(self.machine, self.job.lobes[index].phase_rad, c_counts)
    }

    /// Infeed of all passes together, on counts of X (mm).
    pub(super) fn total_infeed_mm(&self) -> f64 {
        total_infeed_mm(self.schedules)
    }

    /// A lobe, from where C stands or comes turning to where it comes to rest or turns on.
    pub(super) fn lobe(
        &self,
        index: usize,
        begin: LobeStart,
        comes: Option<FlyingStart>,
        goes: Option<FlyingStart>,
    ) -> Result<PlannedLobe, PlanError> {
        let (job, machine) = (self.job, self.machine);
        let lobe = &job.lobes[index];
        let range = lobe.passes(job.passes.len());
        let (specs, schedules) = (&job.passes[range.clone()], &self.schedules[range]);
        let path = self.path_of(index);
        let shape = &self.shapes[path];
        let start_rad = wrap_turn(f64::from(machine.rotation_sense.signum()) * begin.path_rad);
        check_convex(job, lobe, &shape.contour)?;
        let rim_mm = job.rim_above_raw_mm(machine, index);
        check_blank(job, index, shape, (total_infeed_mm(schedules), rim_mm), start_rad)?;
        let last = specs.len() - 1;
        let passes = specs.iter().zip(schedules).enumerate().map(|(number, (pass, schedule))| {
            SpeedPlan::new(&SpeedRequest {
                path: &shape.path,
                path_start_rad: begin.path_rad,
                infeed: schedule,
                infeed_direction: pass.infeed_direction,
                ratio: shape.ratio.as_ref(),
                spark_out_turns: pass.spark_out_turns,
                leaves_turning: job.correction.is_some() && number == last,
                speed: pass.speed,
                comes: comes.filter(|_| number == 0),
                goes: goes.filter(|_| number == last),
                wheel_power: job.wheel_power.map(|power| power.as_law(lobe.width_mm)),
                rotation_sense: machine.rotation_sense,
                wheel_radius_mm: shape.tool_path.wheel_radius_mm(),
                wheel_speed_m_s: machine.wheel_at(lobe.wheel(machine)).surface_speed_m_s,
                c: machine.axis(Axis::C).limits,
                x: machine.axis(Axis::X).limits,
                cycle_time_s: machine.cycle_time_s(),
            })
            .map_err(|source| PlanError::Speed {
                lobe: lobe.name.clone(),
                pass: pass.name.clone(),
                source,
            })
        });
        let passes = passes.collect::<Result<Vec<_>, _>>()?;
        Ok(PlannedLobe {
            design: designed(job, lobe, shape.contour.clone()),
            tool_path: shape.tool_path.clone(),
            path,
            wear_mm: self.wheel.wear_mm[index],
            start_rad,
            start_block: block_at(start_rad, job.blocks_per_turn),
            passes,
        })
    }
}

/// Infeed of all passes together, on counts of X (mm).
fn total_infeed_mm(schedules: &[InfeedSchedule]) -> f64 {
    schedules.first().map_or(0.0, |first| first.left_mm() + first.total_mm())
}

/// Offset of X from the finished path for a remaining infeed (mm).
pub(super) fn infeed_of_x_mm(job: &JobSpec, path: &ToolPath, angle_rad: f64, infeed_mm: f64) -> f64 {
    match job.passes.first().map(|pass| pass.infeed_direction) {
        Some(InfeedDirection::Normal) => infeed_mm / libm::cos(path.beta(angle_rad)),
        _ => infeed_mm,
    }
}

/// A section inside the contour is its parallel curve where that is farther from it than no centre of curvature of a convex flank.
fn check_convex(job: &JobSpec, lobe: &LobeSpec, contour: &Contour) -> Result<(), PlanError> {
    let inside_mm = lobe.axial.map_or(0.0, |axial| (-axial).highest_mm());
    if inside_mm == 0.0 {
        return Ok(());
    }
    let sharpest = contour.maximum_convexity();
    if sharpest.value * inside_mm < 1.0 {
        return Ok(());
    }
    let radius_mm = 1.0 / sharpest.value;
    let (profile, cam_deg) = (job.profiles[lobe.profile].name.clone(), deg_from_rad(sharpest.angle_rad));
    Err(PlanError::SharpForTaper { lobe: lobe.name.clone(), profile, radius_mm, inside_mm, cam_deg })
}

/// At the end of the rapid advance the wheel stands off the blank, which is the contour and its stock. The rim stands out by `rim_mm`.
fn check_blank(
    job: &JobSpec,
    index: usize,
    shape: &WheelShape,
    (total_infeed_mm, rim_mm): (f64, f64),
    start_rad: f64,
) -> Result<(), PlanError> {
    let lobe = &job.lobes[index];
    let wheel_mm = shape.tool_path.wheel_radius_mm();
    let at_size_mm = shape.tool_path.sample(start_rad).value + wheel_mm;
    let total_infeed_mm = infeed_of_x_mm(job, &shape.tool_path, start_rad, total_infeed_mm);
    let gap_at = |offset_mm: f64| {
        let centre = at_size_mm + offset_mm;
        let (x, y) = (centre * libm::cos(start_rad), centre * libm::sin(start_rad));
        // Every 0.1 deg: the distance to a circle of ordinary curvature errs by square of spacing, under 1e-5 mm.
        (0..3600_u32)
            .map(|i| shape.contour.point_about_axis(f64::from(i) * TURN_RAD / 3600.0))
            .map(|point| libm::hypot(point.x - x, point.y - y) - wheel_mm)
            .fold(f64::INFINITY, f64::min)
            - rim_mm
    };
    let gap_mm = gap_at(total_infeed_mm);
    let stock_mm = job.maximum_stock_of_mm(index);
    if gap_mm > stock_mm {
        return Ok(());
    }
    let (mut low, mut high) = (0.0, 100.0 * (stock_mm + total_infeed_mm));
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if gap_at(middle) > stock_mm { high = middle } else { low = middle }
    }
    Err(PlanError::TouchesBlank { lobe: lobe.name.clone(), gap_mm, stock_mm, total_infeed_mm, min_mm: high })
}

/// X keeps within its soft limits on every lobe and is clear of the part whenever table or part move. Where C turns on, X stands at
/// `clear_x_mm` between the lobes (mm).
pub(super) fn check_travel(
    job: &JobSpec,
    machine: &MachineDescription,
    schedules: &[InfeedSchedule],
    lobes: &[PlannedLobe],
    clear_x_mm: Option<f64>,
) -> Result<(), PlanError> {
    let infeeds_mm = job.lobes.iter().map(|lobe| total_infeed_mm(&schedules[lobe.passes(job.passes.len())]));
    let infeeds_mm: Vec<f64> = infeeds_mm.collect();
    // X is largest with the farthest point of the contour on the wheel line, and is its radius there.
    let reach = |lobe: &PlannedLobe| extremes(lobe.tool_path.spline()).1 + job.maximum_stock_mm();
    let highest = lobes.iter().max_by(|a, b| reach(a).total_cmp(&reach(b)));
    let clear = |place: Subject, what: IdleWheelStep, x_mm: f64, moving: Axis, remedy: &'static str| match highest {
        Some(highest) if x_mm <= reach(highest) => Err(PlanError::NotClear {
            place,
            what,
            x_mm,
            moving: moving.joint(),
            highest: highest.design.name.clone(),
            reach_mm: reach(highest),
            remedy,
            lacking_mm: reach(highest) - x_mm,
        }),
        _ => Ok(()),
    };
    clear(Subject::Job, IdleWheelStep::Home, job.home.x_mm, Axis::Z, "home.x_mm must be")?;
    soft_limit(machine, Axis::X, job.home.x_mm, Subject::Job, RequiredPosition::Home)?;
    soft_limit(machine, Axis::Z, job.home.z_mm, Subject::Job, RequiredPosition::Home)?;
    for (index, lobe) in lobes.iter().enumerate() {
        let place = || Subject::Lobe(lobe.design.name.clone());
        let (low_mm, high_mm) = extremes(lobe.tool_path.spline());
        let total_infeed_mm = infeeds_mm[index];
        let infeed_mm = infeed_of_x_mm(job, &lobe.tool_path, lobe.start_rad, total_infeed_mm);
        let retracted_mm = lobe.tool_path.sample(lobe.start_rad).value + infeed_mm + job.rapid_advance_mm;
        soft_limit(machine, Axis::X, low_mm, place(), RequiredPosition::LowestPoint)?;
        let held_mm = high_mm + total_infeed_mm + job.retract_clearance_mm;
        soft_limit(machine, Axis::X, held_mm, place(), RequiredPosition::Hold)?;
        if let Some(clear_x_mm) = clear_x_mm {
            soft_limit(machine, Axis::X, clear_x_mm, place(), RequiredPosition::BetweenLobes)?;
            if index > 0 {
                continue;
            }
        }
        soft_limit(machine, Axis::X, retracted_mm, place(), RequiredPosition::RapidAdvance)?;
        if clear_x_mm.is_none() && index + 1 < lobes.len() {
            clear(place(), IdleWheelStep::RapidRetract, retracted_mm, Axis::Z, "the rapid advance must be")?;
        }
    }
    Ok(())
}

/// A position against the soft limits of its axis, if it has any.
pub(super) fn soft_limit(
    machine: &MachineDescription,
    axis: Axis,
    position_mm: f64,
    place: Subject,
    what: RequiredPosition,
) -> Result<(), PlanError> {
    match machine.axis(axis).soft_limits {
        Some((low_mm, high_mm)) if !(low_mm..=high_mm).contains(&position_mm) => {
            Err(PlanError::SoftLimit { place, what, axis, position_mm, low_mm, high_mm })
        }
        _ => Ok(()),
    }
}
