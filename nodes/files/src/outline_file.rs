// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lifts that are the outline of the part itself: polygons, lines and arcs.

use super::ConfigError;
use super::lift_context::LiftContext;
use super::lift_file::ProfileLift;
use camwright::cam::follower::Follower;
use camwright::cam::lift::LiftLaw;
use camwright::cam::outline::fit::FittedOutline;
use camwright::cam::outline::{Outline, OutlineError, OutlineSegment};
use camwright::math::units::mm_from_um;
use schemars::JsonSchema;
use serde::Deserialize;

/// Default of `blend_within_um`.
const BLEND_WITHIN_UM: f64 = 2.0;

/// A line or an arc as written, from the end of the one before.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct OutlineSegmentFile {
    /// End: x and y. The axis is at 0, 0; cam angle 0 lies on the x axis, cam angle 90 on the y axis.
    to_mm: [f64; 2],
    /// Radius of an arc of at most half a circle: positive where the outline is convex, negative where it is hollow. Default: a line.
    #[schemars(range(min = -1e4, max = 1e4))]
    radius_mm: Option<f64>,
}

/// A closed outline of lines and arcs as written, counterclockwise round the axis.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct OutlineFile {
    /// Start of the first segment, and end of the last: x and y.
    start_mm: [f64; 2],
    /// Lines and arcs one after the other, each tangent to the one before.
    #[schemars(length(min = 2, max = 1000))]
    segments: Vec<OutlineSegmentFile>,
    /// Material that the blends between lines and arcs may leave on the drawing. Default: 2.
    #[schemars(range(min = 0.01, max = 1000.0))]
    blend_within_um: Option<f64>,
}

/// A regular polygon with rounded corners as written; the middle of a side is at cam angle 0.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PolygonFile {
    /// Number of sides.
    #[schemars(range(min = 3, max = 500))]
    sides: usize,
    /// Twice the distance of a side from the axis; of an even number of sides the width across flats.
    #[schemars(range(min = 1e-3, max = 1e4))]
    across_flats_mm: f64,
    /// Radius of the corners.
    #[schemars(range(min = 1e-3, max = 1e4))]
    corner_radius_mm: f64,
    /// Material that the blends between sides and corners may leave on the drawing. Default: 2.
    #[schemars(range(min = 0.01, max = 1000.0))]
    blend_within_um: Option<f64>,
}

fn tolerance_mm(blend_within_um: Option<f64>) -> f64 {
    mm_from_um(blend_within_um.unwrap_or(BLEND_WITHIN_UM))
}

/// Lines and arcs.
pub(super) fn outline(file: &OutlineFile, profile: &LiftContext<'_>) -> Result<ProfileLift, Vec<ConfigError>> {
    let segments = file
        .segments
        .iter()
        .map(|OutlineSegmentFile { to_mm, radius_mm }| OutlineSegment { to_mm: *to_mm, radius_mm: *radius_mm });
    let segments: Vec<OutlineSegment> = segments.collect();
    let outline = Outline::new(file.start_mm, &segments, tolerance_mm(file.blend_within_um)).map_err(|error| {
        let key = match segment_of(&error) {
            0 => "outline".to_owned(),
            segment => format!("outline.segments.{}", segment - 1),
        };
        profile.refuse(&key, error)
    })?;
    lift_of(outline, "outline", profile)
}

/// Lines and arcs that were found through points.
pub(super) fn fitted(found: &FittedOutline, profile: &LiftContext<'_>) -> Result<ProfileLift, Vec<ConfigError>> {
    let outline = Outline::new(found.start_mm, &found.segments, tolerance_mm(None));
    lift_of(outline.map_err(|error| profile.refuse("reading", error))?, "reading", profile)
}

/// A regular polygon.
pub(super) fn polygon(file: &PolygonFile, profile: &LiftContext<'_>) -> Result<ProfileLift, Vec<ConfigError>> {
    let tolerance_mm = tolerance_mm(file.blend_within_um);
    let outline = Outline::polygon(file.sides, file.across_flats_mm, file.corner_radius_mm, tolerance_mm);
    lift_of(outline.map_err(|error| profile.refuse("polygon", error))?, "polygon", profile)
}

fn lift_of(outline: Outline, key: &str, profile: &LiftContext<'_>) -> Result<ProfileLift, Vec<ConfigError>> {
    let smallest_mm = outline.smallest_mm();
    let law = LiftLaw::from_outline(outline).map_err(|error| profile.refuse(key, error))?;
    Ok(ProfileLift::formula(law, Some((Follower::KnifeEdge { offset_mm: 0.0 }, smallest_mm))))
}

/// Number of the segment at fault, from 1; 0 for the whole.
fn segment_of(error: &OutlineError) -> usize {
    match *error {
        OutlineError::BadSegment { segment, .. }
        | OutlineError::NoLength { segment }
        | OutlineError::ArcTooSmall { segment, .. }
        | OutlineError::Corner { segment, .. }
        | OutlineError::BlendsOverlap { segment, .. }
        | OutlineError::NoBlend { segment, .. } => segment,
        OutlineError::SegmentCount { .. }
        | OutlineError::BadNumber { .. }
        | OutlineError::Turn { .. }
        | OutlineError::PassesAxis { .. } => 0,
    }
}
