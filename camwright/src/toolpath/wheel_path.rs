// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Position of the wheel while the part turns: X over the wheel-line angle θ.
//!
//! θ is the azimuth of the X axis line seen from the part. The wheel's centre is W = Q + R·N (contour point and outward
//! normal), |W| its distance from the spindle axis, and the path carries X = |W| − R, the position of the wheel's cutting
//! point on the X axis. The path travels as a periodic quintic spline on a uniform grid of θ.
//!
//! Of a crank pin Q is counted from the spindle axis all the same: the centre of the pin lies at P, its throw e from the axis, and
//! W = P + (r + R)·N. With the pin's centre at θ = 0
//!
//! ```text
//! X + R = e cos θ + √((R + r)² − e² sin² θ)       sin β = −e sin θ / (R + r)
//! ```
//! β is the angle from the normal of the contact to the wheel line. The path goes round the axis only if R + r exceeds the throw.
//!
//! The wheel inside a bore grinds the wall on the far side of the axis: infeed and retract keep their directions. Its centre lies on the
//! wheel line beyond the axis, at −|W|, and its cutting point at X = −|W| − R, minus the radius of the wall there. With the coordinate
//! c = X + R of the centre, of whatever sign, every formula of position and contact holds for both.

use crate::cam::compensation::FormCurve;
use crate::cam::contour::{Contour, MAX_CONTACT_RAD, RECOMMENDED_SHARE};
use crate::math::extremum::Extremum;
use crate::math::periodic_spline::{PeriodicSpline, Sample};
use crate::math::units::{TURN_RAD, deg_from_rad};
use alloc::vec::Vec;
use core::f64::consts::PI;
use nalgebra::Vector2;
use thiserror::Error;

/// Why a wheel cannot make a contour.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ToolPathError {
    /// The wheel radius is not a positive number.
    #[error("wheel radius {wheel_radius_mm} mm is not a positive number")]
    BadWheelRadius {
        /// Given value (mm).
        wheel_radius_mm: f64,
    },
    /// A concave flank is tighter than the wheel.
    #[error(
        "the wheel of radius {wheel_radius_mm:.3} mm does not reach into the concave flank at cam angle {angle_deg:.2} deg \
         (1 + curvature x radius = {clearance:.4}, must be above 0): the largest usable radius is {largest_mm:.3} mm; \
         at most {:.3} mm is recommended", RECOMMENDED_SHARE * .largest_mm
    )]
    WheelTooLarge {
        /// Radius of the wheel (mm).
        wheel_radius_mm: f64,
        /// Radius that must not be reached (mm).
        largest_mm: f64,
        /// Cam angle of the tightest place (deg).
        angle_deg: f64,
        /// 1 + κR there.
        clearance: f64,
    },
    /// The wheel cannot follow the pin round the axis.
    #[error(
        "the wheel of radius {wheel_radius_mm:.3} mm is too small for the throw of {throw_mm} mm: where the pin stands beside the axis its \
         contact is {contact_deg:.2} deg off the wheel line, it must be at most {max_deg:.0} deg: the smallest usable radius is {smallest_mm:.3} mm"
    )]
    WheelTooSmall {
        /// Radius of the wheel (mm).
        wheel_radius_mm: f64,
        /// Distance of the pin's centre from the axis (mm).
        throw_mm: f64,
        /// Largest angle of the contact (deg); 90 where the wheel's centre does not go round the axis.
        contact_deg: f64,
        /// Largest allowed (deg).
        max_deg: f64,
        /// Smallest radius that is allowed (mm).
        smallest_mm: f64,
    },
    /// The path is too rough for its spline.
    #[error(
        "the path bends too sharply: {knots} knots leave {error_mm:e} mm between them; allowed: {bound_mm:e} mm \
         (an acceleration that jumps, or a wheel that hardly fits its concave flank)"
    )]
    Unresolved {
        /// Largest number of knots tried.
        knots: usize,
        /// Remaining error (mm).
        error_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
    /// The wheel does not turn freely inside a bore.
    #[error(
        "the wheel of radius {wheel_radius_mm:.3} mm does not fit into the bore: at cam angle {angle_deg:.2} deg {bound} {bound_mm:.3} mm, \
         the wheel must be smaller; at most {:.3} mm is recommended", RECOMMENDED_SHARE * .bound_mm
    )]
    WheelFillsBore {
        /// Radius of the wheel (mm).
        wheel_radius_mm: f64,
        /// Cam angle of the narrowest place (deg).
        angle_deg: f64,
        /// Kind of the bound.
        bound: &'static str,
        /// Radius that must not be reached (mm).
        bound_mm: f64,
    },
    /// Going back from the path does not lead to the contour.
    #[error(
        "the path leaves the contour by {error_mm:e} mm at wheel-line angle {angle_deg:.3} deg; allowed: {bound_mm:e} mm"
    )]
    LeavesContour {
        /// Distance (mm).
        error_mm: f64,
        /// Wheel-line angle (deg).
        angle_deg: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
}

/// Accuracy of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathAccuracy {
    /// Knots of the spline over one turn.
    pub knots: usize,
    /// Largest error of X midway between knots, against the exact value (mm).
    pub interpolation_error_mm: f64,
    /// Largest distance from the contour of the points that the path grinds, found backwards (mm).
    pub contour_error_mm: f64,
}

/// X over the wheel-line angle for one contour and one wheel.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolPath {
    spline: PeriodicSpline,
    wheel_radius_mm: f64,
    /// Distance of the lobe's centre from the axis, in the direction of θ = 0 (mm).
    throw_mm: f64,
    accuracy: PathAccuracy,
}

/// Fewest and most knots tried, doubling. 0.25° knots resolve a camshaft; the upper end is for tables of 0.01°.
const KNOTS: (usize, usize) = (360, 23_040);

/// Error of X between knots at which no more are added (mm).
pub(crate) const WANTED_ERROR_MM: f64 = 1e-9;

/// Error of X between knots that is still accepted with the most knots (mm): a tenth of the finest encoder count in use.
/// Only laws whose acceleration jumps (harmonic beside a dwell) come near it.
pub(crate) const ALLOWED_ERROR_MM: f64 = 1e-6;

/// Distance of the ground points from the contour that is accepted (mm).
pub(crate) const CONTOUR_ERROR_MM: f64 = 2e-6;

/// Steps to the cam angle of a shifted contour; each leaves a share of a few hundredths for an ordinary correction.
const MAX_STEPS: usize = 40;

/// The way back is checked on a grid this much finer than the knots.
pub(crate) const CHECK_DENSITY: usize = 8;

impl ToolPath {
    /// Checks that a wheel reaches every point of a contour.
    ///
    /// # Errors
    /// A radius that is none; one that is too large for a concave flank, with the largest that fits; one that is too small to follow a
    /// crank pin, with the smallest that does.
    pub fn fits(contour: &Contour, wheel_radius_mm: f64) -> Result<(), ToolPathError> {
        if !wheel_radius_mm.is_finite() || wheel_radius_mm <= 0.0 {
            return Err(ToolPathError::BadWheelRadius { wheel_radius_mm });
        }
        if contour.is_bore() {
            return fits_bore(contour, wheel_radius_mm);
        }
        if let Some(place) = contour.maximum_concavity() {
            let clearance = 1.0 + place.value * wheel_radius_mm;
            if clearance <= 1e-9 {
                return Err(ToolPathError::WheelTooLarge {
                    wheel_radius_mm,
                    largest_mm: -1.0 / place.value,
                    angle_deg: deg_from_rad(place.angle_rad),
                    clearance,
                });
            }
        }
        if let Some(smallest_mm) = contour.smallest_wheel_radius_mm()
            && wheel_radius_mm < smallest_mm
        {
            let throw_mm = contour.throw_mm();
            let sine = throw_mm / (wheel_radius_mm + contour.base_radius_mm());
            return Err(ToolPathError::WheelTooSmall {
                wheel_radius_mm,
                throw_mm,
                contact_deg: deg_from_rad(libm::asin(sine.min(1.0))),
                max_deg: deg_from_rad(MAX_CONTACT_RAD),
                smallest_mm,
            });
        }
        Ok(())
    }

    /// The path on which a wheel grinds a contour.
    ///
    /// The contour is regular (its constructor saw to it), so with 1 + κR > 0 everywhere the wheel's centre goes round
    /// the axis without turning back and its path cannot meet itself: the wheel touches the contour where it should and
    /// cuts it nowhere else.
    ///
    /// # Errors
    /// A wheel that is too large for a concave flank, with the largest that fits; a path that is not smooth enough; a
    /// result that the way back does not confirm.
    pub fn for_wheel(contour: &Contour, wheel_radius_mm: f64) -> Result<Self, ToolPathError> {
        Self::fits(contour, wheel_radius_mm)?;
        let far_rad = far_rad(contour);
        let exact = |angle: f64, guess: &mut f64| {
            let azimuth = angle + far_rad;
            let cam_angle = contour.solve_about_axis(azimuth, wheel_radius_mm, azimuth + *guess);
            *guess = cam_angle - azimuth;
            let centre = contour.local(cam_angle).outside(wheel_radius_mm);
            let (along, across) = contour.about_axis(centre, cam_angle);
            let distance = libm::hypot(along, across);
            contour.radius_sign() * distance - wheel_radius_mm
        };
        let mut path = Self::through(exact, contour, wheel_radius_mm)?;
        path.accuracy.contour_error_mm = path.check(|path, angle| path.misses(contour, angle))?;
        Ok(path)
    }

    /// The path on which a wheel grinds what lies off a contour along its normal by a correction.
    ///
    /// With Q the contour, N its normal and T its tangent over the cam angle φ, dQ = a₀T and dN = ω′T, the shifted curve Q + cN runs with
    /// aT + c′N, a = a₀ + ω′c, so that its normal is (aN − c′T)/√(a² + c′²); the wheel's centre lies R along that. It is seen from the
    /// axis by a small angle δ(φ) beside the centre for the contour itself, and the cam angle at which it stands on the wheel line θ is
    /// where the contour's own would stand on θ − δ(φ).
    ///
    /// # Errors
    /// What [`Self::for_wheel`] says; a correction that the wheel cannot follow without cutting into it is one that the way back does
    /// not confirm.
    pub fn compensated(contour: &Contour, correction: &FormCurve, wheel_radius_mm: f64) -> Result<Self, ToolPathError> {
        // Checks first whether the wheel fits the contour at all, with the error of the contour itself.
        let design = Self::for_wheel(contour, wheel_radius_mm)?;
        if correction.is_zero() {
            return Ok(design);
        }
        // Distance of the centre from the axis, and its angle beside that of the contour itself.
        let centre = |cam_angle: f64| {
            let (frame, off) = (contour.local(cam_angle), correction.sample(cam_angle));
            let (normal_along, normal_across) = (frame.normal_along, frame.normal_across);
            let (run, rise) = (frame.arc + frame.turning * off.value, off.first);
            let length = libm::hypot(run, rise);
            let (outwards, beside) = (off.value + wheel_radius_mm * run / length, -wheel_radius_mm * rise / length);
            let along = frame.along + outwards * normal_along - beside * normal_across;
            let across = frame.across + outwards * normal_across + beside * normal_along;
            let (along, across) = contour.about_axis((along, across), cam_angle);
            let (own_along, own_across) = contour.about_axis(frame.outside(wheel_radius_mm), cam_angle);
            let turned = own_along * across - own_across * along;
            (libm::hypot(along, across), libm::atan2(turned, own_along * along + own_across * across))
        };
        let exact = |angle: f64, guess: &mut f64| {
            let mut cam_angle = angle + *guess;
            for _ in 0..MAX_STEPS {
                let next = contour.solve_about_axis(angle - centre(cam_angle).1, wheel_radius_mm, cam_angle);
                let change = (next - cam_angle).abs();
                cam_angle = next;
                if change <= 1e-14 {
                    break;
                }
            }
            *guess = cam_angle - angle;
            centre(cam_angle).0 - wheel_radius_mm
        };
        let mut path = Self::through(exact, contour, wheel_radius_mm)?;
        path.accuracy.contour_error_mm = path.check(|path, angle| {
            let ground = path.contact(angle);
            let (off_mm, cam_angle) =
                contour.distance(libm::hypot(ground.x, ground.y), libm::atan2(ground.y, ground.x));
            (off_mm - correction.sample(cam_angle).value).abs()
        })?;
        Ok(path)
    }

    /// The spline through exact values, its way back not checked yet.
    fn through(
        exact: impl Fn(f64, &mut f64) -> f64,
        contour: &Contour,
        wheel_radius_mm: f64,
    ) -> Result<Self, ToolPathError> {
        let (spline, interpolation_error_mm) = resample(exact)?;
        let accuracy =
            PathAccuracy { knots: spline.coefficients().len(), interpolation_error_mm, contour_error_mm: 0.0 };
        Ok(Self { spline, wheel_radius_mm, throw_mm: contour.throw_mm(), accuracy })
    }

    /// X (mm) over the wheel-line angle (rad): position of the wheel's cutting point, as plans carry it.
    #[must_use]
    pub fn spline(&self) -> &PeriodicSpline {
        &self.spline
    }

    /// X (mm) and its derivatives (mm/rad, …) at a wheel-line angle (rad).
    #[must_use]
    pub fn sample(&self, angle_rad: f64) -> Sample {
        self.spline.sample(angle_rad)
    }

    /// Radius of the wheel (mm).
    #[must_use]
    pub fn wheel_radius_mm(&self) -> f64 {
        self.wheel_radius_mm
    }

    /// The same positions of the wheel's cutting point under a wheel of another radius (mm): what is driven when a path is
    /// kept over a dress. It does not lead along the contour.
    #[must_use]
    pub(crate) fn with_other_wheel(&self, wheel_radius_mm: f64) -> Self {
        Self { wheel_radius_mm, ..self.clone() }
    }

    /// Accuracy of the path.
    #[must_use]
    pub fn accuracy(&self) -> PathAccuracy {
        self.accuracy
    }

    /// Angle β from the contour's normal to the wheel line (rad): tan β = X′/c, c the coordinate of the wheel's centre on the wheel line.
    #[must_use]
    pub fn beta(&self, angle_rad: f64) -> f64 {
        let x = self.sample(angle_rad);
        line_angle(x.first, x.value + self.wheel_radius_mm)
    }

    /// Point of the contour that the wheel touches (mm, in the cam's frame, of a pin from its own centre): W − R(cos(θ − β), sin(θ − β)).
    #[must_use]
    pub fn contact(&self, angle_rad: f64) -> Vector2<f64> {
        let x = self.sample(angle_rad);
        let (centre, radius) = (x.value + self.wheel_radius_mm, self.wheel_radius_mm);
        let normal = angle_rad - line_angle(x.first, centre);
        Vector2::new(
            centre * libm::cos(angle_rad) - radius * libm::cos(normal) - self.throw_mm,
            centre * libm::sin(angle_rad) - radius * libm::sin(normal),
        )
    }

    /// Azimuth of that point (rad), growing by 2π with the wheel-line angle.
    #[must_use]
    pub fn contact_azimuth(&self, angle_rad: f64) -> f64 {
        let x = self.sample(angle_rad);
        let (centre, radius) = (x.value + self.wheel_radius_mm, self.wheel_radius_mm);
        let beta = line_angle(x.first, centre);
        if centre < 0.0 {
            // The contact lies beyond the axis.
            return angle_rad + PI + libm::atan2(-radius * libm::sin(beta), radius * libm::cos(beta) - centre);
        }
        if self.throw_mm > 0.0 {
            // Relative to the normal, which is less than a quarter turn from the line to the contact.
            let (normal, point) = (angle_rad - beta, self.contact(angle_rad));
            let (sin, cos) = libm::sincos(normal);
            return normal + libm::atan2(point.y * cos - point.x * sin, point.x * cos + point.y * sin);
        }
        // Relative to the wheel line the contact lies at (|W| − R cos β, R sin β).
        angle_rad + libm::atan2(radius * libm::sin(beta), centre - radius * libm::cos(beta))
    }

    /// Footprint speed ratio vf/Ċ (mm/rad): how fast the contact runs along the contour per unit of work speed,
    /// |W|/(cos β (1 + κR)). From the path alone: 1/(1 + κR) = 1 − R κc, with κc the curvature of the centre's path; 1 + R κc in a bore.
    #[must_use]
    pub fn footprint_speed_ratio_mm(&self, angle_rad: f64) -> f64 {
        let (x, radius) = (self.sample(angle_rad), self.wheel_radius_mm);
        let centre = x.value + radius;
        let square = centre * centre + x.first * x.first;
        footprint_ratio(x, radius, centre, square, libm::sqrt(square))
    }

    /// Distance of the ground point from the contour at a wheel-line angle (mm).
    fn misses(&self, contour: &Contour, angle_rad: f64) -> f64 {
        let ground = self.contact(angle_rad);
        let azimuth = self.contact_azimuth(angle_rad);
        let cam_angle = contour.solve(azimuth, 0.0, angle_rad + far_rad(contour) - self.beta(angle_rad));
        (ground - contour.point(cam_angle)).dot(&contour.normal(cam_angle)).abs()
    }

    /// Goes back from the path to the contour, which shares nothing with how the path was found
    /// but the contour itself, and returns the largest distance.
    fn check(&self, misses: impl Fn(&Self, f64) -> f64) -> Result<f64, ToolPathError> {
        let count = CHECK_DENSITY * self.accuracy.knots;
        let mut worst = 0.0_f64;
        for i in 0..count {
            let angle = angle_of(i, count);
            let error_mm = misses(self, angle);
            if error_mm.is_nan() || error_mm > CONTOUR_ERROR_MM {
                let angle_deg = deg_from_rad(angle);
                return Err(ToolPathError::LeavesContour { error_mm, angle_deg, bound_mm: CONTOUR_ERROR_MM });
            }
            worst = worst.max(error_mm);
        }
        Ok(worst)
    }
}

/// The footprint speed ratio from what is known of the path there: `x`, the distance of the wheel's centre, and square and length of
/// the centre's speed per angle (mm/rad). κc = (|c′|² + X′² − |W| X″)/|c′|³ is the curvature of the centre's path.
pub(crate) fn footprint_ratio(x: Sample, wheel_radius_mm: f64, centre: f64, square: f64, length: f64) -> f64 {
    let curvature = (square + x.first * x.first - centre * x.second) / (square * length);
    length * (1.0 - libm::copysign(wheel_radius_mm, centre) * curvature)
}

/// Angle whose tangent is X′/c, within a quarter turn: from the normal of the contact to the wheel line.
pub(crate) fn line_angle(first: f64, centre: f64) -> f64 {
    if centre < 0.0 { libm::atan2(-first, -centre) } else { libm::atan2(first, centre) }
}

/// Angle from the wheel line to the wheel (rad): in a bore it stands beyond the axis.
fn far_rad(contour: &Contour) -> f64 {
    if contour.is_bore() { PI } else { 0.0 }
}

/// Checks that a wheel inside a bore touches its wall in one place, and that its centre goes round the axis.
fn fits_bore(contour: &Contour, wheel_radius_mm: f64) -> Result<(), ToolPathError> {
    let refuse = |(place, bound): (Extremum, &'static str)| ToolPathError::WheelFillsBore {
        wheel_radius_mm,
        angle_deg: deg_from_rad(place.angle_rad),
        bound,
        bound_mm: place.value,
    };
    let curved = contour.maximum_concavity().map(|place| Extremum { value: -1.0 / place.value, ..place });
    let curved = curved.map(|place| (place, "the wall has a radius of curvature of"));
    let near = (contour.nearest_tangent(), "the tangent of the wall passes the axis at");
    let is_exceeded = |(place, _): &(Extremum, &'static str)| {
        let largest_mm = (1.0 - ROUNDING) * place.value;
        largest_mm.is_nan() || wheel_radius_mm >= largest_mm
    };
    match [curved, Some(near)].into_iter().flatten().find(is_exceeded) {
        Some(bound) => Err(refuse(bound)),
        None => Ok(()),
    }
}

/// Relative distance from a bound that rounding could cross.
const ROUNDING: f64 = 1e-9;

pub(crate) fn angle_of(index: usize, count: usize) -> f64 {
    index as f64 * TURN_RAD / count as f64
}

/// Exact values on ever finer grids until the spline through them is right between them, with what it is off there (mm). The exact
/// function is asked from angle to angle and may keep a guess from one to the next.
pub(crate) fn resample(exact: impl Fn(f64, &mut f64) -> f64) -> Result<(PeriodicSpline, f64), ToolPathError> {
    let mut guess = 0.0;
    let mut knots = KNOTS.0;
    let mut at_knots: Vec<f64> = (0..knots).map(|i| exact(angle_of(i, knots), &mut guess)).collect();
    loop {
        let between: Vec<f64> = (0..knots).map(|i| exact(angle_of(2 * i + 1, 2 * knots), &mut guess)).collect();
        let unresolved = |error_mm| ToolPathError::Unresolved { knots, error_mm, bound_mm: ALLOWED_ERROR_MM };
        let spline = PeriodicSpline::interpolate(&at_knots).map_err(|_| unresolved(f64::NAN))?;
        let error_mm = (between.iter().enumerate())
            .map(|(i, value)| (spline.sample(angle_of(2 * i + 1, 2 * knots)).value - value).abs())
            .fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) });
        let last = 2 * knots > KNOTS.1;
        if error_mm <= WANTED_ERROR_MM || (last && error_mm <= ALLOWED_ERROR_MM) {
            return Ok((spline, error_mm));
        }
        if last {
            return Err(unresolved(error_mm));
        }
        at_knots = at_knots.iter().zip(&between).flat_map(|(a, b)| [*a, *b]).collect();
        knots *= 2;
    }
}
