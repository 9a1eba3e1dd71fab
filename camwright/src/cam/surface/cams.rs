// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Cams along z: contours from lift tables, each over a length of the part, and one blending into the next.

use super::{SurfaceError, SurfaceKey, SurfacePoint};
use crate::cam::contour::Contour;
use crate::cam::motion_law::MotionLaw;
use crate::math::periodic_spline::{PeriodicSpline, Sample};
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// A cam over a length of the part. Between where one ends and the next begins the radius goes from the one to the other by a 3-4-5
/// polynomial, which begins and ends without slope and bend: the surface is C² along z.
#[derive(Debug, Clone, Copy)]
pub struct CamAlong<'a> {
    pub contour: &'a Contour,
    /// Azimuth of its cam angle 0, from the keyway (rad).
    pub phase_rad: f64,
    /// Start (mm).
    pub from_mm: f64,
    /// End (mm); the next cam begins beyond it.
    pub to_mm: f64,
}

/// Fewest and most knots of an outline's spline, doubling.
const KNOTS: (u32, u32) = (360, 11_520);

/// Error of the radius between knots at which no more are added (mm).
const WANTED_ERROR_MM: f64 = 1e-8;

/// Error that is still accepted with the most knots (mm): only laws whose acceleration jumps come near it.
const ALLOWED_ERROR_MM: f64 = 2e-6;

const MAX_CAMS: usize = 1000;

/// Most rows on which bounds are looked for.
const MAX_ROWS: u32 = 512;

#[derive(Debug, Clone, PartialEq)]
struct Cam {
    outline: PeriodicSpline,
    from_mm: f64,
    to_mm: f64,
}

/// Cams along z, ready to be asked.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CamStack {
    cams: Vec<Cam>,
}

impl CamStack {
    pub(super) fn new(cams: &[CamAlong<'_>]) -> Result<Self, SurfaceError> {
        if cams.is_empty() || cams.len() > MAX_CAMS {
            return Err(SurfaceError::Count { what: SurfaceKey::Cams, count: cams.len(), min: 1, max: MAX_CAMS });
        }
        let mut stack: Vec<Cam> = Vec::with_capacity(cams.len());
        for (index, cam) in cams.iter().enumerate() {
            for (what, value) in [
                (SurfaceKey::CamPhase, cam.phase_rad),
                (SurfaceKey::CamBegin, cam.from_mm),
                (SurfaceKey::CamEnd, cam.to_mm),
            ] {
                if !value.is_finite() || value.abs() > 1e5 {
                    return Err(SurfaceError::BadNumber { what, value, allowed: "within ±1e5" });
                }
            }
            if cam.to_mm < cam.from_mm {
                return Err(SurfaceError::NoLength { from_mm: cam.from_mm, to_mm: cam.to_mm });
            }
            if let Some(before) = stack.last().filter(|before| cam.from_mm - before.to_mm < 1e-3) {
                return Err(SurfaceError::ZNotIncreasing { row: index, z_mm: cam.from_mm, previous_mm: before.to_mm });
            }
            let outline = outline(cam, index)?;
            stack.push(Cam { outline, from_mm: cam.from_mm, to_mm: cam.to_mm });
        }
        Ok(Self { cams: stack })
    }

    pub(super) fn ends_mm(&self) -> (f64, f64) {
        (self.cams[0].from_mm, self.cams[self.cams.len() - 1].to_mm)
    }

    /// Two azimuths for each knot of the finest outline, and rows of which sixteen fall into the shortest blend.
    pub(super) fn fine_grid(&self) -> (u32, u32) {
        let knots = self.cams.iter().map(|cam| cam.outline.coefficients().len()).max().unwrap_or(0);
        let (from, to) = self.ends_mm();
        let shortest = self.cams.windows(2).map(|pair| pair[1].from_mm - pair[0].to_mm).fold(f64::INFINITY, f64::min);
        #[allow(clippy::cast_possible_truncation, reason = "it saturates, and is cut off")]
        let rows = (16.0 * (to - from) / shortest) as u32;
        (u32::try_from(2 * knots).unwrap_or(KNOTS.1).min(1440), rows.min(MAX_ROWS))
    }

    pub(super) fn point(&self, azimuth_rad: f64, z_mm: f64) -> SurfacePoint {
        let next = self.cams.partition_point(|cam| cam.from_mm <= z_mm);
        let Some(index) = next.checked_sub(1) else { return round(&self.cams[0], azimuth_rad) };
        let cam = &self.cams[index];
        let Some(next) = self.cams.get(next).filter(|_| z_mm > cam.to_mm) else { return round(cam, azimuth_rad) };
        let length = next.from_mm - cam.to_mm;
        let share = MotionLaw::Polynomial345.sample((z_mm - cam.to_mm) / length);
        let (w, w1, w2) = (share.value, share.first / length, share.second / (length * length));
        let (a, b): (Sample, Sample) = (cam.outline.sample(azimuth_rad), next.outline.sample(azimuth_rad));
        SurfacePoint {
            radius_mm: a.value + w * (b.value - a.value),
            by_azimuth: a.first + w * (b.first - a.first),
            by_z: w1 * (b.value - a.value),
            by_azimuth_twice: a.second + w * (b.second - a.second),
            by_azimuth_and_z: w1 * (b.first - a.first),
            by_z_twice: w2 * (b.value - a.value),
        }
    }
}

/// A cam's own outline.
fn round(cam: &Cam, azimuth_rad: f64) -> SurfacePoint {
    let sample = cam.outline.sample(azimuth_rad);
    SurfacePoint {
        radius_mm: sample.value,
        by_azimuth: sample.first,
        by_azimuth_twice: sample.second,
        ..SurfacePoint::default()
    }
}

/// The radius of a cam over the azimuth of the part.
fn outline(cam: &CamAlong<'_>, index: usize) -> Result<PeriodicSpline, SurfaceError> {
    let radius = |azimuth: f64| cam.contour.radius_at(azimuth - cam.phase_rad);
    let values = |count: u32, offset: f64| -> Vec<f64> {
        (0..count).map(|i| radius((f64::from(i) + offset) * TURN_RAD / f64::from(count))).collect()
    };
    let mut knots = KNOTS.0;
    let mut at_knots = values(knots, 0.0);
    loop {
        let bad = |_| SurfaceError::BadNumber { what: SurfaceKey::CamRadius, value: f64::NAN, allowed: "finite" };
        let spline = PeriodicSpline::interpolate(&at_knots).map_err(bad)?;
        let between = values(knots, 0.5);
        let error_mm = between.iter().enumerate().fold(0.0_f64, |max, (i, radius)| {
            let azimuth = (i as f64 + 0.5) * TURN_RAD / f64::from(knots);
            max.max((spline.sample(azimuth).value - radius).abs())
        });
        if error_mm <= WANTED_ERROR_MM || (knots >= KNOTS.1 && error_mm <= ALLOWED_ERROR_MM) {
            return Ok(spline);
        }
        if knots >= KNOTS.1 {
            return Err(SurfaceError::RoughCam {
                cam: index,
                knots: at_knots.len(),
                error_mm,
                bound_mm: ALLOWED_ERROR_MM,
            });
        }
        at_knots = at_knots.into_iter().zip(between).flat_map(|(at, between)| [at, between]).collect();
        knots *= 2;
    }
}
