// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The outline of the finished cam, exact at every angle.
//!
//! A contour is the envelope of its follower: `LocalFrame` has the point Q, the outward normal N at
//! azimuth ω, and the rates dω/dφ and dl/dφ (l the arc length) over the cam angle φ, from what the follower does.
//!
//! | follower | touches with | moves |
//! |---|---|---|
//! | knife edge, roller, mushroom | a tip of radius rr about a trace point P: Q = P − rr N | P = (d₀ + s)u + e n̂ |
//! | oscillating roller | the same | P on an arm about a pivot |
//! | flat | a face x·N = h, the envelope of which is Q = hN + dh/dω T | N = u, h = Rb + s |
//! | oscillating flat | the same | N and h by the angle of the arm |
//!
//! The curvature of the contour is (dω/dφ)/(dl/dφ); it is regular where dl/dφ > 0, else the follower would need a contour
//! that doubles back: undercut. A face must also turn forwards, dω/dφ > 0, for it touches only what is convex.
//! If also Q·N > 0 everywhere, the azimuth of Q only grows with φ, and the contour cannot meet itself anywhere.
//!
//! A bore ([`Contour::bore`]) has the same points. The part is on the other side: N points towards the axis, and walking with the part on the
//! same hand the arc length falls, dl/dφ < 0, so that its curvature is negative where the wall is hollow.

use crate::cam::follower::frame::{LocalFrame, rotated};
use crate::cam::follower::mount::Mount;
use crate::cam::follower::{Follower, FollowerError};
use crate::cam::lift::{LiftLaw, LiftLawError};
use crate::math::extremum::{Extremum, smallest_over_turn};
use crate::math::root::growing_root;
use crate::math::units::{TURN_RAD, deg_from_rad};
use core::f64::consts::{FRAC_PI_2, PI};
use nalgebra::Vector2;
use thiserror::Error;

/// Why a lift has no contour.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ContourError {
    /// The base radius is not a positive number.
    #[error("base radius {base_radius_mm} mm is not a positive number")]
    BadBaseRadius {
        /// Given value (mm).
        base_radius_mm: f64,
    },
    /// The follower cannot ride on this base circle.
    #[error(transparent)]
    Follower(#[from] FollowerError),
    /// The formula of an eccentric is out of range.
    #[error(transparent)]
    Lift(#[from] LiftLawError),
    /// An eccentric that does not contain the spindle axis.
    #[error(
        "eccentricity {eccentricity_mm} mm is not below the radius of {radius_mm} mm: the disc misses the axis; \
         a grinding job makes it as a crank pin"
    )]
    AxisOutside {
        /// Eccentricity (mm).
        eccentricity_mm: f64,
        /// Radius of the disc (mm).
        radius_mm: f64,
    },
    /// A crank pin as a bore.
    #[error("a bore is ground about the spindle axis: it has no throw, but the profile has one of {throw_mm} mm")]
    BoreWithThrow {
        /// Distance of the pin's centre from the axis (mm).
        throw_mm: f64,
    },
    /// A throw that is no length.
    #[error("throw {throw_mm} mm is not a number of at least 0")]
    BadThrow {
        /// Given value (mm).
        throw_mm: f64,
    },
    /// A throw of a profile that is no circle.
    #[error("a throw of {throw_mm} mm with a lift of {max_lift_mm} mm: a crank pin is round, without a lift")]
    PinWithLift {
        /// Distance of the pin's centre from the axis (mm).
        throw_mm: f64,
        /// Largest lift of the profile (mm).
        max_lift_mm: f64,
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
        /// Lower bound, exclusive (mm).
        bound_mm: f64,
    },
    /// An oscillating face overtakes the cam.
    #[error(
        "at cam angle {angle_deg:.2} deg the face swings by {rate:.3} rad per rad of the cam, it must be below {bound}: \
         faster it could touch only a hollow"
    )]
    FaceTurnsBack {
        /// Cam angle (deg).
        angle_deg: f64,
        /// Rate of the face's angle, positive with the cam angle (rad/rad).
        rate: f64,
        /// Upper bound, exclusive.
        bound: f64,
    },
    /// The cam is so large that it reaches the pivot of its follower.
    #[error(
        "the contour at cam angle {angle_deg:.2} deg is {radius_mm:.3} mm from the axis, it must stay below the pivot at \
         {bound_mm} mm"
    )]
    ReachesPivot {
        /// Cam angle (deg).
        angle_deg: f64,
        /// Distance of the contour from the axis (mm).
        radius_mm: f64,
        /// Distance of the pivot (mm).
        bound_mm: f64,
    },
    /// The contact wanders round the cam.
    #[error(
        "the contact at cam angle {angle_deg:.2} deg lies {off_deg:.1} deg from where it lies at rest, it must be below \
         {bound_deg} deg"
    )]
    ContactStrays {
        /// Cam angle (deg).
        angle_deg: f64,
        /// Angle between the contact and the contact at lift 0, relative to the follower (deg).
        off_deg: f64,
        /// Upper bound, exclusive (deg).
        bound_deg: f64,
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
        /// Lower bound, exclusive (mm).
        bound_mm: f64,
    },
}

/// Centre of a lobe's frame on the part, where that is not the spindle axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LobeCentre {
    /// Distance from the axis (mm).
    pub distance_mm: f64,
    /// Azimuth, from the same direction as the azimuths of the part (rad).
    pub azimuth_rad: f64,
}

impl LobeCentre {
    /// Position of a point relative to this centre, from its distance from the axis and its azimuth (mm, rad): the same two.
    #[must_use]
    pub fn relative(&self, distance_mm: f64, azimuth_rad: f64) -> (f64, f64) {
        // Along the line from the axis to the point, and across it: exact for the small angle between both lines.
        let (sin, cos) = libm::sincos(azimuth_rad - self.azimuth_rad);
        let (along, across) = (distance_mm - self.distance_mm * cos, self.distance_mm * sin);
        (libm::hypot(along, across), azimuth_rad + libm::atan2(across, along))
    }
}

/// The outline of a finished cam in its own frame, where the cam angle of the lift table is measured.
///
/// Points, azimuths and radii are relative to the centre of this frame. That is the axis of rotation, except for a crank pin
/// ([`Contour::pin`]): its frame is centred on the pin, [`Contour::throw_mm`] from the axis in the direction of cam angle 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Contour {
    throw_mm: f64,
    /// The part is outside of it.
    is_bore: bool,
    lift: LiftLaw,
    follower: Follower,
    base_radius_mm: f64,
    mount: Mount,
    max_concave: Option<Extremum>,
    max_pressure_angle: Extremum,
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
        let mount = Mount::new(follower, base_radius_mm)?;
        mount.reaches(lift.min_lift_mm(), lift.max_lift_mm())?;
        let mut contour = Self {
            throw_mm: 0.0,
            is_bore: false,
            lift: lift.clone(),
            follower: *follower,
            base_radius_mm,
            mount,
            max_concave: None,
            max_pressure_angle: Extremum { angle_rad: 0.0, value: 0.0 },
        };
        let (grid, breaks) = (lift.grid(), lift.breaks());
        let smallest = |function: &dyn Fn(f64) -> f64| smallest_over_turn(grid, &breaks, function);
        if mount.is_face() {
            let slowest = smallest(&|angle| contour.local(angle).turning);
            if slowest.value.is_nan() || slowest.value <= ROUNDING {
                let (angle_deg, rate) = (deg_from_rad(slowest.angle_rad), 1.0 - slowest.value);
                return Err(ContourError::FaceTurnsBack { angle_deg, rate, bound: 1.0 });
            }
        }
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
        if let Some(pivot_mm) = mount.pivot_mm() {
            contour.stays_beside(pivot_mm)?;
        }
        let concave = smallest(&|angle| contour.local(angle).curvature());
        let steepest = smallest(&|angle| -contour.pressure_angle(angle).abs());
        // A flat is not hollow.
        contour.max_concave = (concave.value * base_radius_mm < -ROUNDING).then_some(concave);
        let value = contour.pressure_angle(steepest.angle_rad);
        contour.max_pressure_angle = Extremum { angle_rad: steepest.angle_rad, value };
        Ok(contour)
    }

    /// Checks that the contour clears the pivot of its follower, and that the azimuth of the contact is unique without counting turns.
    fn stays_beside(&self, pivot_mm: f64) -> Result<(), ContourError> {
        let (grid, breaks) = (self.lift.grid(), self.lift.breaks());
        let radius = |angle: f64| {
            let frame = self.local(angle);
            libm::hypot(frame.along, frame.across)
        };
        let farthest = smallest_over_turn(grid, &breaks, |angle| -radius(angle));
        if -farthest.value >= pivot_mm {
            let (angle_deg, radius_mm) = (deg_from_rad(farthest.angle_rad), -farthest.value);
            return Err(ContourError::ReachesPivot { angle_deg, radius_mm, bound_mm: pivot_mm });
        }
        let off = |angle: f64| (self.azimuth(angle) - angle - self.mount.lead_rad()).abs();
        let astray = smallest_over_turn(grid, &breaks, |angle| -off(angle));
        if -astray.value >= STRAYS_RAD {
            let (angle_deg, off_deg) = (deg_from_rad(astray.angle_rad), deg_from_rad(-astray.value));
            return Err(ContourError::ContactStrays { angle_deg, off_deg, bound_deg: deg_from_rad(STRAYS_RAD) });
        }
        Ok(())
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

    /// A crank pin, or a disc that misses the axis: a circle whose centre lies `throw_mm` from the axis, in the direction of cam
    /// angle 0.
    ///
    /// # Errors
    /// Numbers that are not finite, a throw below 0, a radius that is not above 0.
    pub fn pin(throw_mm: f64, radius_mm: f64) -> Result<Self, ContourError> {
        if !throw_mm.is_finite() || throw_mm < 0.0 {
            return Err(ContourError::BadThrow { throw_mm });
        }
        let circle = Self::from_lift(&LiftLaw::eccentric_flat(0.0, 0.0)?, &Follower::Flat, radius_mm)?;
        Ok(Self { throw_mm, ..circle })
    }

    /// The same outline as the wall of a bore, with the part outside of it.
    ///
    /// # Errors
    /// A crank pin.
    pub fn bore(self) -> Result<Self, ContourError> {
        if self.is_pin() {
            return Err(ContourError::BoreWithThrow { throw_mm: self.throw_mm });
        }
        let convex = self.maximum_convexity();
        let max_concave =
            (convex.value * self.base_radius_mm > ROUNDING).then_some(Extremum { value: -convex.value, ..convex });
        Ok(Self { is_bore: true, max_concave, ..self })
    }

    /// The contour is the wall of a bore.
    #[must_use]
    pub fn is_bore(&self) -> bool {
        self.is_bore
    }

    /// Sign of its radii on a part: those of a bore are negative.
    #[must_use]
    pub fn radius_sign(&self) -> f64 {
        if self.is_bore { -1.0 } else { 1.0 }
    }

    /// The tangent that passes the axis at the smallest distance (mm), and its cam angle.
    #[must_use]
    pub fn nearest_tangent(&self) -> Extremum {
        let (grid, breaks) = (self.lift.grid(), self.lift.breaks());
        smallest_over_turn(grid, &breaks, |angle| self.local(angle).support().abs())
    }

    /// Distance of the centre of its frame from the axis of rotation, in the direction of cam angle 0 (mm); 0 but for a pin.
    #[must_use]
    pub fn throw_mm(&self) -> f64 {
        self.throw_mm
    }

    /// The contour is a crank pin: the axis of rotation is not the centre of its frame.
    #[must_use]
    pub fn is_pin(&self) -> bool {
        self.throw_mm > 0.0
    }

    /// Point of the contour at a cam angle, relative to the axis of rotation (mm).
    #[must_use]
    pub fn point_about_axis(&self, cam_angle_rad: f64) -> Vector2<f64> {
        let point = self.point(cam_angle_rad);
        Vector2::new(point.x + self.throw_mm, point.y)
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

    /// Unit normal at that point, out of the part (in the cam's frame).
    #[must_use]
    pub fn normal(&self, cam_angle_rad: f64) -> Vector2<f64> {
        let frame = self.local(cam_angle_rad);
        rotated(frame.normal_along, frame.normal_across, cam_angle_rad)
    }

    /// Azimuth ω of the normal out of the part (rad), growing by 2π with the cam angle.
    #[must_use]
    pub fn normal_angle(&self, cam_angle_rad: f64) -> f64 {
        let frame = self.local(cam_angle_rad);
        if self.is_bore {
            return cam_angle_rad + PI + self.mount.azimuth(-frame.normal_along, -frame.normal_across);
        }
        cam_angle_rad + self.mount.azimuth(frame.normal_along, frame.normal_across)
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
        cam_angle_rad + self.mount.azimuth(frame.along, frame.across)
    }

    /// Pressure angle at a cam angle (rad): from the normal to the follower's motion. On a slide tan α = (s′ − e)/(d₀ + s),
    /// and 0 for a flat face; on an arm the motion is that of the roller's centre, or of the point of the face that touches.
    #[must_use]
    pub fn pressure_angle(&self, cam_angle_rad: f64) -> f64 {
        let lift = self.lift.sample(cam_angle_rad);
        self.mount.pressure_angle(&lift, &self.mount.frame(&lift))
    }

    /// Additional lift per material left at a cam angle, along the normal (mm per mm, or deg per mm for an angular lift), negative in a
    /// bore; first order, because the contact moves along the contour only.
    #[must_use]
    pub fn lift_per_depth(&self, cam_angle_rad: f64) -> f64 {
        let lift = self.lift.sample(cam_angle_rad);
        let frame = self.mount.frame(&lift);
        let depth_per_lift = libm::cos(self.mount.pressure_angle(&lift, &frame)) * self.mount.travel_per_lift(&frame);
        self.radius_sign() / depth_per_lift
    }

    /// Contact position on the follower's face (mm): from the stem of a flat or mushroom follower, positive towards increasing cam
    /// angle; on an oscillating face from the foot of the pivot's perpendicular, positive along the arm. `None` for a roller or knife
    /// edge.
    #[must_use]
    pub fn contact_on_face_mm(&self, cam_angle_rad: f64) -> Option<f64> {
        let lift = self.lift.sample(cam_angle_rad);
        self.mount.contact_on_face_mm(&self.follower, &lift, &self.mount.frame(&lift))
    }

    /// The part of the face that the cam uses: least and largest [`Self::contact_on_face_mm`] over the turn (mm).
    #[must_use]
    pub fn face_in_use_mm(&self) -> Option<(f64, f64)> {
        self.contact_on_face_mm(0.0)?;
        let (grid, breaks) = (self.lift.grid(), self.lift.breaks());
        let contact = |angle| self.contact_on_face_mm(angle).unwrap_or(f64::NAN);
        let min = smallest_over_turn(grid, &breaks, contact).value;
        let max = -smallest_over_turn(grid, &breaks, |angle| -contact(angle)).value;
        Some((min, max))
    }

    /// Pressure angle of the largest magnitude (rad), and its cam angle.
    #[must_use]
    pub fn max_pressure_angle(&self) -> Extremum {
        self.max_pressure_angle
    }

    /// The most concave place and its curvature (1/mm, negative); `None` if the contour is convex throughout.
    #[must_use]
    pub fn maximum_concavity(&self) -> Option<Extremum> {
        self.max_concave
    }

    /// The most convex place and its curvature (1/mm).
    #[must_use]
    pub fn maximum_convexity(&self) -> Extremum {
        let (grid, breaks) = (self.lift.grid(), self.lift.breaks());
        let flattest = smallest_over_turn(grid, &breaks, |angle| -self.curvature(angle));
        Extremum { value: -flattest.value, ..flattest }
    }

    /// Radius that a wheel must stay below (mm); `None` if any wheel will do.
    #[must_use]
    pub fn largest_wheel_radius_mm(&self) -> Option<f64> {
        self.max_concave.map(|place| -1.0 / place.value)
    }

    /// Radius from which on a wheel can follow a crank pin round the axis (mm); `None` if any wheel will do.
    #[must_use]
    pub fn smallest_wheel_radius_mm(&self) -> Option<f64> {
        let radius_mm = self.throw_mm / libm::sin(MAX_CONTACT_RAD) - self.base_radius_mm;
        (radius_mm > 0.0).then_some(radius_mm)
    }

    /// Radius up to which a wheel is comfortable (mm), nine tenths of [`Self::largest_wheel_radius_mm`]: towards the limit
    /// the contact runs ever faster along the concave flank, and the headstock would have to stand still.
    #[must_use]
    pub fn recommended_wheel_radius_mm(&self) -> Option<f64> {
        self.largest_wheel_radius_mm().map(|largest| RECOMMENDED_SHARE * largest)
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

    /// Cam angle at which the outward normal points to an azimuth (rad), to rounding, for a contour that is convex throughout.
    pub(crate) fn cam_angle_of_normal(&self, normal_rad: f64, guess_rad: f64) -> f64 {
        let ahead = |angle: f64| {
            let frame = self.local(angle);
            (angle + self.mount.azimuth(frame.normal_along, frame.normal_across) - normal_rad, frame.turning)
        };
        let at_rest = normal_rad - self.mount.lead_rad();
        growing_root(at_rest - PI, at_rest + PI, guess_rad, ahead)
    }

    /// Everything at one cam angle.
    pub(crate) fn local(&self, cam_angle_rad: f64) -> LocalFrame {
        let frame = self.mount.frame(&self.lift.sample(cam_angle_rad));
        if self.is_bore { frame.seen_from_inside() } else { frame }
    }

    /// The cam angle at which the point `distance_mm` outside the contour (a wheel's centre; 0 for the contour itself)
    /// lies at an azimuth. The azimuth grows with the cam angle; near undercut it is nearly flat in places.
    pub(crate) fn solve(&self, azimuth_rad: f64, distance_mm: f64, guess_rad: f64) -> f64 {
        let ahead = |angle: f64| {
            let frame = self.local(angle);
            let (along, across) = frame.outside(distance_mm);
            (angle + self.mount.azimuth(along, across) - azimuth_rad, frame.azimuth_rate(distance_mm))
        };
        // The point is less than a quarter turn from where it is at rest on all but freak cams.
        let at_rest = azimuth_rad - self.mount.lead_rad();
        let (mut low, mut high) = (at_rest - FRAC_PI_2, at_rest + FRAC_PI_2);
        if ahead(low).0 > 0.0 {
            low = at_rest - PI;
        }
        if ahead(high).0 < 0.0 {
            high = at_rest + PI;
        }
        growing_root(low, high, guess_rad, ahead)
    }
}

impl Contour {
    /// Position of a point of the lobe's frame relative to the axis of rotation, along and across the direction of a cam angle (mm).
    pub(crate) fn about_axis(&self, (along, across): (f64, f64), cam_angle_rad: f64) -> (f64, f64) {
        if !self.is_pin() {
            return (along, across);
        }
        let (sin, cos) = libm::sincos(cam_angle_rad);
        (along + self.throw_mm * cos, across - self.throw_mm * sin)
    }

    /// The cam angle at which the point `distance_mm` outside the contour lies at an azimuth seen from the axis of rotation.
    ///
    /// With W the point and N the normal its azimuth grows by (W·N)/|W|² per way along the curve: [`ToolPath::fits`] requires W·N > 0.
    ///
    /// [`ToolPath::fits`]: crate::toolpath::wheel_path::ToolPath::fits
    pub(crate) fn solve_about_axis(&self, azimuth_rad: f64, distance_mm: f64, guess_rad: f64) -> f64 {
        if !self.is_pin() {
            return self.solve(azimuth_rad, distance_mm, guess_rad);
        }
        let ahead = |angle: f64| {
            let frame = self.local(angle);
            let (along, across) = self.about_axis(frame.outside(distance_mm), angle);
            let outwards = along * frame.normal_along + across * frame.normal_across;
            let way = frame.arc + frame.turning * distance_mm;
            let rate = way * outwards / (along * along + across * across);
            (angle + libm::atan2(across, along) - azimuth_rad, rate)
        };
        // The normal of a circle is less than a quarter turn from the line to a point outside it that the axis does not see from behind.
        growing_root(azimuth_rad - FRAC_PI_2, azimuth_rad + FRAC_PI_2, guess_rad, ahead)
    }
}

/// Largest angle between the wheel line and the normal of a pin (rad): 80°. Farther off X would have to move more than five times as far
/// as what it corrects along the normal, and C pushes the pin along the wheel.
pub(crate) const MAX_CONTACT_RAD: f64 = 4.0 * TURN_RAD / 18.0;

/// Share of the largest usable wheel radius up to which a wheel is comfortable.
pub(crate) const RECOMMENDED_SHARE: f64 = 0.9;

/// Relative size of what rounding can make of a zero.
const ROUNDING: f64 = 1e-9;

/// Maximum distance of the contact on an oscillating follower from its rest position (rad): less than half a turn.
const STRAYS_RAD: f64 = 3.0;
