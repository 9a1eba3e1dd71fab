// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The steps of a dress, and what it would cost to keep the path over it.

use super::error::PlanError;
use super::error::RequiredPosition;
use super::lobe::{WheelShape, shape_of, soft_limit};
use super::sequence::Sequence;
use super::steps::StepSubject;
use crate::cam::contour::Contour;
use crate::job::dressing::{Dress, PlannedDress, RetainedPath, WheelCourse, kept_path_error};
use crate::job::grinding::JobSpec;
use crate::job::grinding::Subject;
use crate::machine::description::{Axis, MachineDescription, WheelsNow};
use crate::machine::wheel_state::{mm_from_nm, nm_from_mm};
use crate::math::units::um_from_mm;
use crate::motion::plan::{Phase, PlanCommand, SegmentKind};
use crate::motion::point_to_point::whole_ticks;
use crate::toolpath::wheel_path::ToolPath;
use alloc::vec::Vec;

/// Distance before the dresser at which the slow infeed begins (mm): clearance for a wheel that wore less than predicted.
const APPROACH_MM: f64 = 0.5;

impl Sequence<'_> {
    /// The machine stops before anything moves if another wheel is mounted.
    pub(super) fn expect_wheel(&mut self, radius_mm: f64) {
        let label = alloc::format!("wheel of radius {radius_mm:.4} mm");
        self.steps.command(
            StepSubject::part(Phase::Home),
            PlanCommand::ExpectWheel { radius_nm: nm_from_mm(radius_mm) },
            &label,
        );
    }

    /// Wheel to the dresser, past it and back, and clear of the part again. Its cutting point stands at the dresser's rim
    /// before and after: what comes off moves the wheel's centre, not `x_axis`.
    pub(super) fn dress(&mut self, dress: &Dress, lobe: &str) -> Result<(), PlanError> {
        let Some(dresser) = self.steps.machine.dresser else { return Ok(()) };
        let of = StepSubject::part(Phase::Dress);
        let half_mm = 0.5 * dresser.traverse_mm(self.steps.machine.wheel_at(self.wheel).width_mm);
        let (first_mm, last_mm) = (dresser.z_mm - half_mm, dresser.z_mm + half_mm);
        let place = || Subject::Lobe(lobe.into());
        for z_mm in [first_mm, last_mm] {
            soft_limit(self.steps.machine, Axis::Z, z_mm, place(), RequiredPosition::PastDresser)?;
        }
        soft_limit(self.steps.machine, Axis::X, dresser.x_mm, place(), RequiredPosition::Dresser)?;
        let clear = self.steps.counts(Axis::X, self.job.home.x_mm);
        let (first, last) = (self.steps.counts(Axis::Z, first_mm), self.steps.counts(Axis::Z, last_mm));
        let rapid = Some(self.job.rapid_speed_mm_s);
        let slow = Some(dresser.traverse_speed_mm_s);
        self.steps.move_axis(of, Axis::X, clear, None, "wheel clear of the part")?;
        self.steps.move_axis(of, Axis::Z, first, None, "table to the dresser")?;
        self.steps.move_axis(
            of,
            Axis::X,
            self.steps.counts(Axis::X, dresser.x_mm + APPROACH_MM),
            rapid,
            "wheel before the dresser",
        )?;
        let at_rim = self.steps.counts(Axis::X, dresser.x_mm);
        self.steps.move_axis(of, Axis::X, at_rim, Some(dresser.infeed_speed_mm_s), "wheel to the dresser")?;
        let label = alloc::format!(
            "dress before {lobe} ({}): radius {:.4} to {:.4} mm, {:.3} um of wear and {:.3} um of depth",
            dress.reason,
            dress.old_radius_mm,
            mm_from_nm(dress.radius_nm),
            um_from_mm(dress.wear_mm),
            um_from_mm(dress.depth_mm)
        );
        self.steps.command(of, PlanCommand::Dress { radius_nm: dress.radius_nm }, &label);
        self.steps.move_axis(of, Axis::Z, last, slow, "past the dresser")?;
        self.steps.move_axis(of, Axis::Z, first, slow, "back past the dresser")?;
        let dwell = whole_ticks(dresser.dwell_s, self.steps.machine.cycle_time_s());
        self.steps.add(of, SegmentKind::Dwell, dwell, 0, "dresser out of contact");
        self.steps.move_axis(of, Axis::X, clear, rapid, "wheel clear of the part")
    }
}

/// Every dress with the form error that the paths before it would leave.
pub(super) fn with_kept_paths(
    job: &JobSpec,
    machine: &MachineDescription,
    contours: &[Contour],
    shapes: &[WheelShape],
    wheels_now: &WheelsNow,
    wheel: &WheelCourse,
) -> Vec<PlannedDress> {
    let path = |profile: usize, radius_mm: f64| match shape_of(shapes, profile, None, radius_mm) {
        Some(index) => Some(shapes[index].tool_path.clone()),
        // Nothing is ground with this wheel; it may even be too large for the profile.
        None => ToolPath::for_wheel(&contours[profile], radius_mm).ok(),
    };
    let wheel_of = |lobe: usize| job.lobes[lobe].wheel(machine);
    let end_of = |dress: &Dress| {
        let own = wheel_of(dress.before_lobe);
        let later = wheel.dresses.iter().map(|next| next.before_lobe).filter(|next| *next > dress.before_lobe);
        later.filter(|next| wheel_of(*next) == own).min().unwrap_or(job.lobes.len())
    };
    let kept = |dress: &Dress, radius_mm: f64| {
        let mut worst: Option<RetainedPath> = None;
        let own = wheel_of(dress.before_lobe);
        let lobes = (dress.before_lobe..end_of(dress)).filter(|lobe| wheel_of(*lobe) == own);
        let profiles: Vec<usize> = lobes.map(|lobe| job.lobes[lobe].profile).collect();
        for profile in (0..contours.len()).filter(|profile| profiles.contains(profile)) {
            let error = kept_path_error(&contours[profile], &path(profile, radius_mm)?, dress.radius_mm());
            if worst.is_none_or(|worst| error.value.abs() > worst.error.value.abs()) {
                worst = Some(RetainedPath { profile, error });
            }
        }
        worst
    };
    let planned = |dress: &Dress| PlannedDress {
        dress: *dress,
        kept_path: kept(dress, dress.old_radius_mm),
        first_path: kept(dress, wheels_now.wheel(machine, wheel_of(dress.before_lobe)).radius_mm),
    };
    wheel.dresses.iter().map(planned).collect()
}
