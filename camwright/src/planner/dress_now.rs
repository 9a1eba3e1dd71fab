// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A dress that nobody's part waits for: a plan of its own, of the wheel's way to the dresser and back.

use super::PlanStart;
use super::clearance::check_clearance;
use super::error::PlanError;
use super::sequence::Sequence;
use crate::job::dressing::{Dress, DressReason};
use crate::job::grinding::JobSpec;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription, WheelTooFast};
use crate::machine::wheel_state::{WheelNow, nm_from_mm};
use crate::math::units::um_from_mm;
use crate::motion::plan::{Half, Plan};
use crate::planner::plan_check::check_plan;
use alloc::boxed::Box;
use alloc::string::String;
use thiserror::Error;

/// Why the wheel is not dressed now.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DressNowError {
    /// There is nothing to dress with.
    #[error("machine {machine} has no dresser")]
    NoDresser { machine: String },
    /// A depth that is none (mm).
    #[error("the depth of the dress is {} um; it must be above 0", um_from_mm(*.0))]
    Depth(f64),
    /// More is to come off than the dresser may take (mm).
    #[error(
        "the dress takes {:.3} um off the wheel's radius ({:.3} um of wear with it); the dresser is allowed {:.3} um",
        um_from_mm(*.depth_mm), um_from_mm(*.wear_mm), um_from_mm(*.allowed_mm)
    )]
    TooDeep { depth_mm: f64, wear_mm: f64, allowed_mm: f64 },
    /// The wheel is used up (mm).
    #[error(
        "the dress would leave a wheel of radius {radius_mm:.4} mm; wheel.min_radius_mm is {min_mm:.4} mm: mount a new wheel"
    )]
    WornOut { radius_mm: f64, min_mm: f64 },
    /// A wheel so small would turn too fast.
    #[error("after the dress: {0}")]
    TooFast(WheelTooFast),
    /// There is no way to the dresser.
    #[error("{0}")]
    Plan(Box<PlanError>),
}

impl From<PlanError> for DressNowError {
    fn from(error: PlanError) -> Self {
        DressNowError::Plan(Box::new(error))
    }
}

/// A dress of the wheel as it is, planned: the plan, and the dress in it. X goes to the far end of its travel first and stays there, so
/// that no job needs to say where the wheel is clear of the part; the table ends beside the dresser.
///
/// # Errors
/// No dresser, a depth that is none or too much, a wheel that has nothing left, no way.
pub fn plan_dress(
    machine: &MachineDescription,
    wheel: WheelNow,
    depth_mm: f64,
) -> Result<(Plan, Dress), DressNowError> {
    let Some(dresser) = machine.dresser else {
        return Err(DressNowError::NoDresser { machine: machine.name.clone() });
    };
    if !(depth_mm > 0.0 && depth_mm.is_finite()) {
        return Err(DressNowError::Depth(depth_mm));
    }
    let wear_mm = wheel.wear_mm;
    let dress = Dress {
        before_lobe: 0,
        reason: DressReason::Asked,
        old_radius_mm: wheel.radius_mm,
        wear_mm,
        depth_mm,
        radius_nm: nm_from_mm(wheel.radius_mm - depth_mm - wear_mm),
    };
    let (radius_mm, min_mm) = (dress.radius_mm(), machine.wheel.min_radius_mm);
    if radius_mm < min_mm {
        return Err(DressNowError::WornOut { radius_mm, min_mm });
    }
    if depth_mm + wear_mm > dresser.max_depth_mm {
        let allowed_mm = dresser.max_depth_mm;
        return Err(DressNowError::TooDeep { depth_mm: depth_mm + wear_mm, wear_mm, allowed_mm });
    }
    machine.wheel.check_speed(radius_mm).map_err(DressNowError::TooFast)?;

    let clear_mm = machine.axis(Axis::X).soft_limits.map_or(2.0 * dresser.x_mm, |(_, high_mm)| high_mm);
    let job = JobSpec::without_lobes("dress", clear_mm, machine.axis(Axis::X).limits.velocity);
    let counts = |axis: Axis, at: f64| machine.axis(axis).scale.counts(at);
    let start = PlanStart { counts: [0, counts(Axis::X, clear_mm), counts(Axis::Z, dresser.z_mm)], c_homed: false };
    let mut sequence = Sequence::new(&job, machine, &[], start);
    sequence.expect_wheel(wheel.radius_mm);
    sequence.clear_and_run()?;
    sequence.dress(&dress, "the next job")?;
    let mut plan = sequence.stop_wheel();
    plan.half = Half::NoPart;
    plan.duration_with_indexing_s = plan.duration_s;
    // Wherever the table stands now, it comes from there.
    let (low_mm, high_mm) = machine.axis(Axis::Z).soft_limits.unwrap_or((dresser.z_mm, dresser.z_mm));
    for z_mm in [low_mm, high_mm] {
        let from: [i64; AXIS_COUNT] = [0, start.counts[Axis::X.index()], counts(Axis::Z, z_mm)];
        check_clearance(&job, machine, &[], &plan, from)?;
        check_plan(&plan, machine, from).map_err(PlanError::from)?;
    }
    Ok((plan, dress))
}
