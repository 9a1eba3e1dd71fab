// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The dresses of a job, for people and for `summary.json`.

use super::PreparedJob;
use camwright::job::dressing::RetainedPath;
use camwright::math::units::{deg_from_rad, um_from_mm};
use serde::Serialize;
use std::fmt;

/// Dress in `summary.json`.
#[derive(Debug, Clone, Serialize)]
pub struct DressSummary {
    /// Lobe that it comes before.
    pub before_lobe: String,
    pub reason: String,
    /// Radius at the dress before.
    pub old_radius_mm: f64,
    /// Radius after it, which every path after it is made for.
    pub radius_mm: f64,
    /// Predicted wear since the dress before.
    pub wear_um: f64,
    /// Taken off by the dresser.
    pub depth_um: f64,
    /// Largest form error if the path of the radius before it were kept; none where that wheel has no path.
    pub kept_path: Option<KeptPathSummary>,
    /// The same for the path that the job began with.
    pub first_path: Option<KeptPathSummary>,
}

/// Error of retaining a path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct KeptPathSummary {
    /// Profile on which it is largest.
    pub profile: String,
    /// Form error along the normal, positive where material would be left.
    pub error_um: f64,
    pub cam_angle_deg: f64,
}

/// The dresses of a prepared job, in their order.
#[must_use]
pub fn dresses(prepared: &PreparedJob) -> Vec<DressSummary> {
    let job = &prepared.job.spec;
    let kept = |kept: RetainedPath| KeptPathSummary {
        profile: job.profiles.get(kept.profile).map(|profile| profile.name.clone()).unwrap_or_default(),
        error_um: um_from_mm(kept.error.value),
        cam_angle_deg: deg_from_rad(kept.error.angle_rad),
    };
    let summary = |planned: &camwright::job::dressing::PlannedDress| DressSummary {
        before_lobe: job.lobes.get(planned.dress.before_lobe).map(|lobe| lobe.name.clone()).unwrap_or_default(),
        reason: planned.dress.reason.to_string(),
        old_radius_mm: planned.dress.old_radius_mm,
        radius_mm: planned.dress.radius_mm(),
        wear_um: um_from_mm(planned.dress.wear_mm),
        depth_um: um_from_mm(planned.dress.depth_mm),
        kept_path: planned.kept_path.map(kept),
        first_path: planned.first_path.map(kept),
    };
    prepared.planned.dresses.iter().map(summary).collect()
}

impl fmt::Display for DressSummary {
    /// One sentence, with what keeping the path would cost.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { before_lobe, reason, old_radius_mm, radius_mm, wear_um, depth_um, kept_path, first_path } = self;
        write!(
            f,
            "dress before {before_lobe} ({reason}): wheel radius {old_radius_mm:.4} to {radius_mm:.4} mm ({wear_um:.3} um of \
             wear, {depth_um:.3} um of depth)"
        )?;
        if let Some(kept) = kept_path {
            let KeptPathSummary { profile, error_um, cam_angle_deg } = kept;
            write!(f, "; the path before it would leave {error_um:.4} um on {profile} at {cam_angle_deg:.2} deg")?;
        }
        match first_path {
            Some(first) if Some(first) != kept_path.as_ref() => {
                write!(f, ", the job's first {:.4} um", first.error_um)
            }
            _ => Ok(()),
        }
    }
}
