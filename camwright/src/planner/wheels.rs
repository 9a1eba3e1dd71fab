// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! One wheel for one job: reports the possible wheels of each lobe if the wheel does not fit or two are needed.

use super::error::PlanError;
use crate::cam::contour::Contour;
use crate::job::grinding::JobSpec;
use crate::machine::description::{MachineDescription, WHEEL_TOLERANCE_MM};
use crate::math::units::deg_from_rad;
use crate::toolpath::wheel_path::ToolPathError;
use alloc::string::String;
use alloc::vec::Vec;

/// Refuses a job that asks for another wheel than the one that is mounted.
pub(super) fn check_one_wheel(job: &JobSpec, contours: &[Contour], mounted_mm: f64) -> Result<(), PlanError> {
    if job.wheels.iter().all(|wish| (wish.radius_mm - mounted_mm).abs() <= WHEEL_TOLERANCE_MM) {
        return Ok(());
    }
    let wishes = job.wheels.iter().map(|wish| alloc::format!("{} mm for {}", wish.radius_mm, wish.of));
    let wishes: Vec<String> = wishes.collect();
    Err(PlanError::TwoWheels { mounted_mm, wishes: wishes.join(", "), needs: needs(job, contours) })
}

/// The largest wheel for each lobe, in a sentence.
fn needs(job: &JobSpec, contours: &[Contour]) -> String {
    let need = |lobe: &crate::job::grinding::LobeSpec| match contours[lobe.profile].maximum_concavity() {
        Some(place) => alloc::format!(
            "lobe {} takes less than {:.3} mm (hollow at cam angle {:.2} deg)",
            lobe.name,
            -1.0 / place.value,
            deg_from_rad(place.angle_rad)
        ),
        None => match contours[lobe.profile].smallest_wheel_radius_mm() {
            Some(smallest_mm) => alloc::format!("lobe {} takes {smallest_mm:.3} mm and more", lobe.name),
            None => alloc::format!("lobe {} takes any", lobe.name),
        },
    };
    let needs: Vec<String> = job.lobes.iter().map(need).collect();
    needs.join(", ")
}

/// A path that cannot be: which lobes wait for it, and what can be done where a smaller wheel would do.
pub(super) fn no_path(
    job: &JobSpec,
    machine: &MachineDescription,
    contours: &[Contour],
    profile: usize,
    source: ToolPathError,
) -> PlanError {
    let of: Vec<&str> =
        job.lobes.iter().filter(|lobe| lobe.profile == profile).map(|lobe| lobe.name.as_str()).collect();
    let lobes = match of.len() {
        0 => String::new(),
        1 => alloc::format!("lobe {}, ", of[0]),
        _ => alloc::format!("lobes {}, ", of.join(", ")),
    };
    let advice = match &source {
        ToolPathError::WheelTooLarge { wheel_radius_mm, .. } => {
            let fits = |lobe: &&crate::job::grinding::LobeSpec| {
                contours[lobe.profile].largest_wheel_radius_mm().is_none_or(|largest| *wheel_radius_mm < largest)
            };
            let others: Vec<&str> = job.lobes.iter().filter(fits).map(|lobe| lobe.name.as_str()).collect();
            if others.is_empty() {
                String::new()
            } else {
                let (one, other) = (others.join(", "), of.join(", "));
                if machine.wheel_changer.is_some() {
                    alloc::format!("; name a smaller wheel of the changer for {other} (wheel), as this one fits {one}")
                } else {
                    alloc::format!(
                        "; the machine has one wheel: make a job of {one} and another, with a smaller wheel, of {other}"
                    )
                }
            }
        }
        _ => String::new(),
    };
    PlanError::Path { lobes, advice, profile: job.profiles[profile].name.clone(), source }
}
