//! The outline of the finished cam, exact at every angle.
//!
//! A contour is the envelope of its follower (`PROCESS_MATH` 1.a). With u = (cos φ, sin φ) along the follower at cam angle
//! φ, n̂ = (−sin φ, cos φ), lift s, D = d₀ + s, t = s′ − e (e the offset, d₀ the trace point's height at lift 0):
//!
//! | follower | point Q | outward normal N | dω/dφ | arc length dl/dφ |
//! |---|---|---|---|---|
//! | flat | (Rb + s)u + s′n̂ | u | 1 | Rb + s + s″ |
//! | knife edge | P = D u + e n̂ | (D u − t n̂)/L, L = √(D² + t²) | κp L | L |
//! | roller rr | P − rr N | as above | κp L | L (1 − rr κp) |
//!
//! κp = (D² + t(t + s′) − D s″)/L³ is the curvature of the pitch curve. The curvature of the contour is
//! (dω/dφ)/(dl/dφ); it is regular where dl/dφ > 0, else the follower would need a contour that doubles back: undercut.
//! If also Q·N > 0 everywhere, the azimuth of Q only grows with φ, and the contour cannot meet itself anywhere.

use crate::follower::{Follower, FollowerError};
use crate::lift::{LiftLaw, LiftLawError};
use crate::numeric::extremum::{Extremum, smallest_over_turn};
use crate::units::deg_from_rad;
use core::f64::consts::{FRAC_PI_2, PI};
use nalgebra::Vector2;
use thiserror::Error;

/// Why a lift has no contour.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ContourError {
    /// The base radius is not a positive number.
    #[error("base radius {base_radius_mm} mm is not a positive number")]
    BadBaseRadius {
        /// What was given (mm).
        base_radius_mm: f64,
    },
    /// The follower cannot ride on this base circle.
    #[error(transparent)]
    Follower(#[from] FollowerError),
    /// The formula of an eccentric is out of range.
    #[error(transparent)]
    Lift(#[from] LiftLawError),
    /// An eccentric that does not contain the spindle axis.
    #[error("eccentricity {eccentricity_mm} mm is not below the radius of {radius_mm} mm: the disc misses the axis")]
    AxisOutside {
        /// Eccentricity (mm).
        eccentricity_mm: f64,
        /// Radius of the disc (mm).
        radius_mm: f64,
    },
    /// The lift asks for a contour that doubles back.
    #[error(
        "undercut at cam angle {angle_deg:.2} deg: the radius of curvature is {radius_of_curvature_mm:.3} mm, \
         it must be above {bound_mm} mm"
    )]
    Undercut {
        /// Cam angle (deg).
        angle_deg: f64,
        /// Radius of curvature of the contour there (mm), negative where it doubles back.
        radius_of_curvature_mm: f64,
        /// What it must exceed (mm).
        bound_mm: f64,
    },
    /// The contour passes the axis on the wrong side.
    #[error(
        "the contour at cam angle {angle_deg:.2} deg passes the axis at {distance_mm:.3} mm, it must be above {bound_mm} mm"
    )]
    PassesAxis {
        /// Cam angle (deg).
        angle_deg: f64,
        /// Distance of the tangent from the axis (mm).
        distance_mm: f64,
        /// What it must exceed (mm).
        bound_mm: f64,
    },
}

/// The outline of a finished cam in its own frame, where the cam angle of the lift table is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Contour {
    lift: LiftLaw,
    follower: Follower,
    base_radius_mm: f64,
    trace_height_mm: f64,
    most_concave: Option<Extremum>,
    max_pressure_angle: Extremum,
}

/// Point, normal and their rates at one cam angle, along the follower (u) and square to it (n̂).
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalFrame {
    pub(crate) along: f64,
    pub(crate) across: f64,
    pub(crate) normal_along: f64,
    pub(crate) normal_across: f64,
    /// dω/dφ.
    pub(crate) turning: f64,
    /// dl/dφ (mm/rad).
    pub(crate) arc: f64,
}

impl Contour {
    /// The contour on which a follower does what a lift law says.
    ///
    /// # Errors
    /// A base radius or follower that is none; undercut, or a contour that passes the axis, with angle, value and bound.
    pub fn from_lift(lift: &LiftLaw, follower: &Follower, base_radius_mm: f64) -> Result<Self, ContourError> {
        if !base_radius_mm.is_finite() || base_radius_mm <= 0.0 {
            return Err(ContourError::BadBaseRadius { base_radius_mm });
        }
        let trace_height_mm = follower.trace_height_mm(base_radius_mm)?;
        let mut contour = Self {
            lift: lift.clone(),
            follower: *follower,
            base_radius_mm,
            trace_height_mm,
            most_concave: None,
            max_pressure_angle: Extremum { angle_rad: 0.0, value: 0.0 },
        };
        let (grid, breaks) = (lift.grid(), lift.breaks());
        let smallest = |function: &dyn Fn(f64) -> f64| smallest_over_turn(grid, &breaks, function);
        let thinnest = smallest(&|angle| contour.local(angle).arc);
        if thinnest.value.is_nan() || thinnest.value <= ROUNDING * base_radius_mm {
            let frame = contour.local(thinnest.angle_rad);
            return Err(ContourError::Undercut {
                angle_deg: deg_from_rad(thinnest.angle_rad),
                radius_of_curvature_mm: frame.arc / frame.turning,
                bound_mm: 0.0,
            });
        }
        let nearest = smallest(&|angle| contour.local(angle).support());
        if nearest.value.is_nan() || nearest.value <= ROUNDING * base_radius_mm {
            let (angle_deg, distance_mm) = (deg_from_rad(nearest.angle_rad), nearest.value);
            return Err(ContourError::PassesAxis { angle_deg, distance_mm, bound_mm: 0.0 });
        }
        let concave = smallest(&|angle| contour.local(angle).curvature());
        let steepest = smallest(&|angle| -contour.pressure_angle(angle).abs());
        contour.most_concave = (concave.value < 0.0).then_some(concave);
        let value = contour.pressure_angle(steepest.angle_rad);
        contour.max_pressure_angle = Extremum { angle_rad: steepest.angle_rad, value };
        Ok(contour)
    }

    /// A disc whose centre lies `eccentricity_mm` from the axis, in the direction of cam angle 0.
    ///
    /// # Errors
    /// A disc that does not contain the axis, numbers that are not finite.
    pub fn eccentric(eccentricity_mm: f64, radius_mm: f64) -> Result<Self, ContourError> {
        if !radius_mm.is_finite() || radius_mm <= 0.0 {
            return Err(ContourError::BadBaseRadius { base_radius_mm: radius_mm });
        }
        let lift = LiftLaw::eccentric_flat(eccentricity_mm, 0.0)?;
        if eccentricity_mm >= radius_mm {
            return Err(ContourError::AxisOutside { eccentricity_mm, radius_mm });
        }
        Self::from_lift(&lift, &Follower::Flat, radius_mm - eccentricity_mm)
    }

    /// The lift law it was made from.
    #[must_use]
    pub fn lift(&self) -> &LiftLaw {
        &self.lift
    }

    /// The follower it was made for.
    #[must_use]
    pub fn follower(&self) -> Follower {
        self.follower
    }

    /// Base radius (mm).
    #[must_use]
    pub fn base_radius_mm(&self) -> f64 {
        self.base_radius_mm
    }

    /// Point of the contour that the follower touches at a cam angle (mm, in the cam's frame).
    #[must_use]
    pub fn point(&self, cam_angle_rad: f64) -> Vector2<f64> {
        let frame = self.local(cam_angle_rad);
        rotated(frame.along, frame.across, cam_angle_rad)
    }

    /// Outward unit normal at that point (in the cam's frame).
    #[must_use]
    pub fn normal(&self, cam_angle_rad: f64) -> Vector2<f64> {
        let frame = self.local(cam_angle_rad);
        rotated(frame.normal_along, frame.normal_across, cam_angle_rad)
    }

    /// Azimuth ω of the outward normal (rad), growing by 2π with the cam angle.
    #[must_use]
    pub fn normal_angle(&self, cam_angle_rad: f64) -> f64 {
        let frame = self.local(cam_angle_rad);
        cam_angle_rad + libm::atan2(frame.normal_across, frame.normal_along)
    }

    /// Curvature at that point (1/mm), positive where the contour is convex.
    #[must_use]
    pub fn curvature(&self, cam_angle_rad: f64) -> f64 {
        self.local(cam_angle_rad).curvature()
    }

    /// Azimuth of that point (rad), growing by 2π with the cam angle.
    #[must_use]
    pub fn azimuth(&self, cam_angle_rad: f64) -> f64 {
        let frame = self.local(cam_angle_rad);
        cam_angle_rad + libm::atan2(frame.across, frame.along)
    }

    /// Pressure angle at a cam angle (rad): between the follower's motion and the normal through its trace point,
    /// tan α = (s′ − e)/(d₀ + s); 0 for a flat face.
    #[must_use]
    pub fn pressure_angle(&self, cam_angle_rad: f64) -> f64 {
        match self.follower {
            Follower::Flat => 0.0,
            Follower::KnifeEdge { offset_mm } | Follower::Roller { offset_mm, .. } => {
                let s = self.lift.sample(cam_angle_rad);
                libm::atan2(s.first - offset_mm, self.trace_height_mm + s.value)
            }
        }
    }

    /// Where the pressure angle is largest in size, and its value there (rad).
    #[must_use]
    pub fn max_pressure_angle(&self) -> Extremum {
        self.max_pressure_angle
    }

    /// The most concave place and its curvature (1/mm, negative); `None` if the contour is convex throughout.
    #[must_use]
    pub fn most_concave(&self) -> Option<Extremum> {
        self.most_concave
    }

    /// Radius that a wheel must stay below (mm); `None` if any wheel will do.
    #[must_use]
    pub fn largest_wheel_radius_mm(&self) -> Option<f64> {
        self.most_concave.map(|place| -1.0 / place.value)
    }

    /// Radius up to which a wheel is comfortable (mm), a tenth below [`Self::largest_wheel_radius_mm`]: towards the limit
    /// the contact runs ever faster along the concave flank, and the headstock would have to stand still.
    #[must_use]
    pub fn recommended_wheel_radius_mm(&self) -> Option<f64> {
        self.largest_wheel_radius_mm().map(|largest| 0.9 * largest)
    }

    /// Cam angle whose point lies at an azimuth (rad), to rounding.
    #[must_use]
    pub fn cam_angle_at(&self, azimuth_rad: f64) -> f64 {
        self.solve(azimuth_rad, 0.0, azimuth_rad)
    }

    /// Distance of the contour from the axis at an azimuth (mm, rad).
    #[must_use]
    pub fn radius_at(&self, azimuth_rad: f64) -> f64 {
        let frame = self.local(self.cam_angle_at(azimuth_rad));
        libm::hypot(frame.along, frame.across)
    }

    /// Everything at one cam angle.
    pub(crate) fn local(&self, cam_angle_rad: f64) -> LocalFrame {
        let s = self.lift.sample(cam_angle_rad);
        if self.follower == Follower::Flat {
            let along = self.base_radius_mm + s.value;
            let (across, arc) = (s.first, along + s.second);
            return LocalFrame { along, across, normal_along: 1.0, normal_across: 0.0, turning: 1.0, arc };
        }
        let (roller, offset) = (self.follower.roller_radius_mm(), self.follower.offset_mm());
        let (d, t) = (self.trace_height_mm + s.value, s.first - offset);
        let square = d * d + t * t;
        let length = libm::sqrt(square);
        // κp·L, the rate of the normal's azimuth.
        let turning = (d * d + t * (t + s.first) - d * s.second) / square;
        let (normal_along, normal_across) = (d / length, -t / length);
        LocalFrame {
            along: d - roller * normal_along,
            across: offset - roller * normal_across,
            normal_along,
            normal_across,
            turning,
            arc: length - roller * turning,
        }
    }

    /// The cam angle at which the point `distance_mm` outside the contour (a wheel's centre; 0 for the contour itself)
    /// lies at an azimuth. The azimuth grows with the cam angle, so Newton's method inside a shrinking bracket finds it.
    pub(crate) fn solve(&self, azimuth_rad: f64, distance_mm: f64, guess_rad: f64) -> f64 {
        let ahead = |angle: f64| {
            let (value, rate) = self.local(angle).offset_azimuth(distance_mm);
            (angle + value - azimuth_rad, rate)
        };
        // The point is less than a quarter turn from the follower's line on all but freak cams.
        let (mut low, mut high) = (azimuth_rad - FRAC_PI_2, azimuth_rad + FRAC_PI_2);
        if ahead(low).0 > 0.0 {
            low = azimuth_rad - PI;
        }
        if ahead(high).0 < 0.0 {
            high = azimuth_rad + PI;
        }
        let mut angle = guess_rad.clamp(low, high);
        let mut previous = f64::INFINITY;
        for _ in 0..100 {
            let (miss, rate) = ahead(angle);
            // What rounding leaves of an angle; beyond it Newton's step and the bracket would only play with noise.
            if miss.abs() <= f64::EPSILON * (1.0 + angle.abs()) {
                break;
            }
            if miss > 0.0 {
                high = angle;
            } else {
                low = angle;
            }
            let newton = angle - miss / rate;
            if (newton - angle).abs() <= f64::EPSILON * (1.0 + angle.abs()) {
                break;
            }
            // Strictly inside, and only while it gains: near undercut the azimuth is nearly flat in places, and Newton's
            // steps would run from one end of the bracket to the other.
            let gains = miss.abs() <= 0.5 * previous;
            previous = miss.abs();
            angle = if gains && newton > low && newton < high { newton } else { 0.5 * (low + high) };
        }
        angle
    }
}

/// Relative size of what rounding can make of a zero.
const ROUNDING: f64 = 1e-9;

impl LocalFrame {
    /// Distance of the tangent from the axis, Q·N (mm).
    pub(crate) fn support(&self) -> f64 {
        self.along * self.normal_along + self.across * self.normal_across
    }

    /// Curvature (1/mm).
    pub(crate) fn curvature(&self) -> f64 {
        self.turning / self.arc
    }

    /// The point a distance outside, along u and n̂.
    pub(crate) fn outside(&self, distance_mm: f64) -> (f64, f64) {
        (self.along + distance_mm * self.normal_along, self.across + distance_mm * self.normal_across)
    }

    /// Azimuth of that point relative to the cam angle, and the rate of its azimuth:
    /// dθ/dφ = (dl/dφ + R dω/dφ)(W·N)/W².
    fn offset_azimuth(&self, distance_mm: f64) -> (f64, f64) {
        let (along, across) = self.outside(distance_mm);
        let rate = (self.arc + distance_mm * self.turning) * (self.support() + distance_mm)
            / (along * along + across * across);
        (libm::atan2(across, along), rate)
    }
}

fn rotated(along: f64, across: f64, angle_rad: f64) -> Vector2<f64> {
    let (sin, cos) = (libm::sin(angle_rad), libm::cos(angle_rad));
    Vector2::new(along * cos - across * sin, along * sin + across * cos)
}
