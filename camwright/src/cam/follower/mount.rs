// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A follower as it rests on a base circle: where it stands at every lift.
//!
//! On a slide the trace point is (d₀ + s, e), the face u·x = Rb + s.
//!
//! On an arm, with the pivot A = c·u, ψ is the angle at A from the line to the cam's axis to the arm (or to the face), and
//! σ = +1 if the arm reaches ahead, −1 behind. The direction of the arm is (−cos ψ, σ sin ψ), and with ψ its end moves
//! along (sin ψ, σ cos ψ).
//!
//! - Roller: P = (c − a cos ψ, σa sin ψ) (g = φ + π ∓ ψ). It rests where
//!   c² + a² − 2ac cos ψ₀ = (Rb + rr)².
//! - Face: its normal is N = (sin ψ, σ cos ψ), which is at φ + σ(π/2 − ψ), so ω′ = 1 − σψ′ and ω″ = −σψ″. The plane lies b
//!   outside the pivot: h = A·N + b = c sin ψ + b, at rest Rb. From h and ω the contact follows as for any envelope of
//!   lines ([`LocalFrame::from_face`]); along the face, counted from the pivot, it lies at (Q − A)·(arm direction)
//!   = c cos ψ + σh′/ω′ = c cos ψ/(1 − σψ′), which is where the common normal passes the instant centre of cam and arm.

use super::frame::{Face, LocalFrame, Trace};
use super::{ArmSide, Follower, FollowerError, Pivot, SwingLift};
use crate::math::periodic_spline::Sample;
use crate::math::units::{deg_from_rad, rad_from_deg};
use core::f64::consts::{FRAC_PI_2, PI};

/// A follower on its base circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mount {
    pub(super) kind: MountKind,
    lead_rad: f64,
    lead: (f64, f64),
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum MountKind {
    SlidingTip { height_mm: f64, offset_mm: f64, radius_mm: f64 },
    SlidingFace { base_radius_mm: f64 },
    SwingingTip { swing: ArmSwing, arm_mm: f64, radius_mm: f64 },
    SwingingFace { swing: ArmSwing, face_offset_mm: f64 },
}

/// Angle ψ of an arm over the lift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ArmSwing {
    pub(super) pivot_mm: f64,
    /// σ: +1 if the arm reaches ahead, −1 if behind.
    pub(super) sense: f64,
    pub(super) rest_rad: f64,
    /// dψ/ds.
    pub(super) rad_per_lift: f64,
    /// Upper bound of ψ, exclusive: the arm lifts no further there.
    pub(super) bound_rad: f64,
}

impl Mount {
    /// The follower resting on a base circle.
    ///
    /// # Errors
    /// Numbers that are none, a follower that cannot touch the base circle.
    pub(crate) fn new(follower: &Follower, base_radius_mm: f64) -> Result<Self, FollowerError> {
        let kind = match *follower {
            Follower::KnifeEdge { offset_mm } => sliding_tip(base_radius_mm, 0.0, offset_mm)?,
            Follower::Roller { radius_mm, offset_mm } => {
                positive_roller(radius_mm)?;
                sliding_tip(base_radius_mm, radius_mm, offset_mm)?
            }
            Follower::Mushroom { radius_mm } => {
                sliding_tip(base_radius_mm, positive("radius of the face", radius_mm)?, 0.0)?
            }
            Follower::Flat => MountKind::SlidingFace { base_radius_mm },
            Follower::OscillatingRoller { radius_mm, arm_mm, pivot } => {
                positive_roller(radius_mm)?;
                swinging_tip(base_radius_mm, radius_mm, positive("arm", arm_mm)?, &pivot)?
            }
            Follower::OscillatingFlat { face_offset_mm, pivot } => {
                swinging_face(base_radius_mm, face_offset_mm, &pivot)?
            }
        };
        let mut mount = Self { kind, lead_rad: 0.0, lead: (1.0, 0.0) };
        // At rest the contact lies on the base circle, in the direction of its normal.
        let rest = mount.frame(&Sample { value: 0.0, first: 0.0, second: 0.0, third: 0.0 });
        mount.lead_rad = libm::atan2(rest.across, rest.along);
        mount.lead = (libm::cos(mount.lead_rad), libm::sin(mount.lead_rad));
        Ok(mount)
    }

    /// Contact and its rates at a lift.
    pub(crate) fn frame(&self, lift: &Sample) -> LocalFrame {
        match &self.kind {
            MountKind::SlidingTip { height_mm, offset_mm, radius_mm } => {
                let along = [height_mm + lift.value, lift.first, lift.second];
                LocalFrame::from_tip(&Trace { along, across: [*offset_mm, 0.0, 0.0] }, *radius_mm)
            }
            MountKind::SlidingFace { base_radius_mm } => LocalFrame::from_face(&Face {
                normal: (1.0, 0.0),
                turning: [1.0, 0.0],
                support: [base_radius_mm + lift.value, lift.first, lift.second],
            }),
            MountKind::SwingingTip { swing, arm_mm, radius_mm } => {
                let ([psi, psi1, psi2], (a, side)) = (swing.angle(lift), (arm_mm, swing.sense * arm_mm));
                let (sin, cos) = (libm::sin(psi), libm::cos(psi));
                let along = [swing.pivot_mm - a * cos, a * sin * psi1, a * (cos * psi1 * psi1 + sin * psi2)];
                let across = [side * sin, side * cos * psi1, side * (cos * psi2 - sin * psi1 * psi1)];
                LocalFrame::from_tip(&Trace { along, across }, *radius_mm)
            }
            MountKind::SwingingFace { swing, face_offset_mm } => {
                let ([psi, psi1, psi2], c) = (swing.angle(lift), swing.pivot_mm);
                let (sin, cos) = (libm::sin(psi), libm::cos(psi));
                LocalFrame::from_face(&Face {
                    normal: (sin, swing.sense * cos),
                    turning: [1.0 - swing.sense * psi1, -swing.sense * psi2],
                    support: [c * sin + face_offset_mm, c * cos * psi1, c * (cos * psi2 - sin * psi1 * psi1)],
                })
            }
        }
    }

    /// Azimuth of the contact at rest, relative to the cam angle (rad): 0 for a slide without offset.
    pub(crate) fn lead_rad(&self) -> f64 {
        self.lead_rad
    }

    /// Azimuth of a vector along u and n̂ relative to the cam angle (rad), within half a turn of the contact at rest.
    pub(crate) fn azimuth(&self, along: f64, across: f64) -> f64 {
        let (cos, sin) = self.lead;
        self.lead_rad + libm::atan2(across * cos - along * sin, along * cos + across * sin)
    }

    /// Pressure angle (rad): from the normal to the direction in which the follower's contact (of a face) or trace point
    /// (of a tip) moves with growing lift.
    pub(crate) fn pressure_angle(&self, lift: &Sample, frame: &LocalFrame) -> f64 {
        let (along, across) = match &self.kind {
            MountKind::SlidingTip { .. } | MountKind::SlidingFace { .. } => (1.0, 0.0),
            MountKind::SwingingTip { swing, .. } => {
                let psi = swing.angle(lift)[0];
                (libm::sin(psi), swing.sense * libm::cos(psi))
            }
            MountKind::SwingingFace { swing, .. } => {
                (swing.sense * frame.across, -swing.sense * (frame.along - swing.pivot_mm))
            }
        };
        libm::atan2(
            frame.normal_along * across - frame.normal_across * along,
            frame.normal_along * along + frame.normal_across * across,
        )
    }

    /// Travel of the contact (of a face) or trace point (of a tip) per lift (mm per mm, or mm per degree for an angular lift).
    pub(crate) fn travel_per_lift(&self, frame: &LocalFrame) -> f64 {
        match &self.kind {
            MountKind::SlidingTip { .. } | MountKind::SlidingFace { .. } => 1.0,
            MountKind::SwingingTip { swing, arm_mm, .. } => arm_mm * swing.rad_per_lift,
            MountKind::SwingingFace { swing, .. } => {
                libm::hypot(frame.along - swing.pivot_mm, frame.across) * swing.rad_per_lift
            }
        }
    }

    /// Contact position on a face (mm): from the stem, positive towards increasing cam angle, or from the foot of the pivot's
    /// perpendicular, positive along the arm. `None` for a roller or knife edge.
    pub(crate) fn contact_on_face_mm(&self, follower: &Follower, lift: &Sample, frame: &LocalFrame) -> Option<f64> {
        match (&self.kind, follower) {
            (MountKind::SwingingFace { swing, .. }, _) => {
                let psi = swing.angle(lift)[0];
                Some((swing.pivot_mm - frame.along) * libm::cos(psi) + swing.sense * frame.across * libm::sin(psi))
            }
            (_, Follower::Flat | Follower::Mushroom { .. }) => Some(frame.across),
            _ => None,
        }
    }

    /// Distance of the pivot from the axis (mm); `None` on a slide.
    pub(crate) fn pivot_mm(&self) -> Option<f64> {
        self.swing().map(|swing| swing.pivot_mm)
    }

    /// Returns whether a flat face touches: it needs a convex contour.
    pub(crate) fn is_face(&self) -> bool {
        matches!(self.kind, MountKind::SlidingFace { .. } | MountKind::SwingingFace { .. })
    }

    /// Checks that no lift between these swings the arm past where it still lifts.
    pub(crate) fn reaches(&self, min_lift: f64, max_lift: f64) -> Result<(), FollowerError> {
        let Some(swing) = self.swing() else { return Ok(()) };
        for lift in [min_lift, max_lift] {
            let swing_rad = swing.rest_rad + swing.rad_per_lift * lift;
            if !(swing_rad > swing.bound_rad - PI && swing_rad < swing.bound_rad) {
                let (swing_deg, bound_deg) = (deg_from_rad(swing_rad), deg_from_rad(swing.bound_rad));
                return Err(FollowerError::SwingTooFar { swing_deg, min_deg: bound_deg - 180.0, bound_deg });
            }
        }
        Ok(())
    }

    fn swing(&self) -> Option<&ArmSwing> {
        match &self.kind {
            MountKind::SlidingTip { .. } | MountKind::SlidingFace { .. } => None,
            MountKind::SwingingTip { swing, .. } | MountKind::SwingingFace { swing, .. } => Some(swing),
        }
    }
}

impl ArmSwing {
    fn new(pivot: &Pivot, rest_rad: f64, bound_rad: f64) -> Result<Self, FollowerError> {
        let rad_per_lift = match pivot.lift {
            SwingLift::Degrees => rad_from_deg(1.0),
            SwingLift::Arc { radius_mm } => 1.0 / positive("radius of the arc of the lift", radius_mm)?,
        };
        let sense = match pivot.side {
            ArmSide::Ahead => 1.0,
            ArmSide::Behind => -1.0,
        };
        Ok(Self { pivot_mm: pivot.distance_mm, sense, rest_rad, rad_per_lift, bound_rad })
    }

    /// ψ with its first and second derivative.
    fn angle(&self, lift: &Sample) -> [f64; 3] {
        let k = self.rad_per_lift;
        [self.rest_rad + k * lift.value, k * lift.first, k * lift.second]
    }
}

fn positive(what: &'static str, value: f64) -> Result<f64, FollowerError> {
    let good = value.is_finite() && value > 0.0;
    if good { Ok(value) } else { Err(FollowerError::BadNumber { what, value, bound: "a positive number" }) }
}

fn positive_roller(radius_mm: f64) -> Result<(), FollowerError> {
    let good = radius_mm.is_finite() && radius_mm > 0.0;
    if good { Ok(()) } else { Err(FollowerError::BadRadius { radius_mm }) }
}

/// Height d₀ of the trace point at lift 0: √(prime radius² − offset²).
fn sliding_tip(base_radius_mm: f64, radius_mm: f64, offset_mm: f64) -> Result<MountKind, FollowerError> {
    let prime_radius_mm = base_radius_mm + radius_mm;
    if !offset_mm.is_finite() || offset_mm.abs() >= prime_radius_mm {
        return Err(FollowerError::OffsetTooLarge { offset_mm, prime_radius_mm });
    }
    let height_mm = libm::sqrt((prime_radius_mm - offset_mm) * (prime_radius_mm + offset_mm));
    Ok(MountKind::SlidingTip { height_mm, offset_mm, radius_mm })
}

fn swinging_tip(base_radius_mm: f64, radius_mm: f64, arm_mm: f64, pivot: &Pivot) -> Result<MountKind, FollowerError> {
    let pivot_mm = positive("distance of the pivot", pivot.distance_mm)?;
    let prime_radius_mm = base_radius_mm + radius_mm;
    let (min_mm, max_mm) = ((arm_mm - pivot_mm).abs(), arm_mm + pivot_mm);
    if prime_radius_mm <= min_mm || prime_radius_mm >= max_mm {
        return Err(FollowerError::ArmOutOfReach { arm_mm, pivot_mm, prime_radius_mm, min_mm, max_mm });
    }
    // Half the angle from the half perimeter: well conditioned where the cosine is near ±1.
    let (p, a, c) = (prime_radius_mm, arm_mm, pivot_mm);
    let rest_rad = 2.0 * libm::atan2(libm::sqrt((p + a - c) * (p - a + c)), libm::sqrt((a + c - p) * (a + c + p)));
    Ok(MountKind::SwingingTip { swing: ArmSwing::new(pivot, rest_rad, PI)?, arm_mm, radius_mm })
}

fn swinging_face(base_radius_mm: f64, face_offset_mm: f64, pivot: &Pivot) -> Result<MountKind, FollowerError> {
    let pivot_mm = positive("distance of the pivot", pivot.distance_mm)?;
    let (min_mm, max_mm) = (base_radius_mm - pivot_mm, base_radius_mm + pivot_mm);
    if !face_offset_mm.is_finite() || face_offset_mm <= min_mm || face_offset_mm >= max_mm {
        return Err(FollowerError::FaceOutOfReach { face_offset_mm, pivot_mm, base_radius_mm, min_mm, max_mm });
    }
    let rest_rad = libm::asin((base_radius_mm - face_offset_mm) / pivot_mm);
    Ok(MountKind::SwingingFace { swing: ArmSwing::new(pivot, rest_rad, FRAC_PI_2)?, face_offset_mm })
}
