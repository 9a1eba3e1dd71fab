// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! At which lift a mounted follower touches a given piece of a contour: the way back from a contour to a lift.
//!
//! A piece is a point Q with its outward normal N, both in the cam's frame. The follower touches it at cam angle φ if the
//! centre W = Q + r N of its tip lies where the follower can carry it, or if its face can lie along the tangent:
//!
//! | follower | condition | lift |
//! |---|---|---|
//! | tip on a slide | W·n̂ = e | W·u − d₀ |
//! | tip on an arm | (W − A)² = a² | ψ of W − A |
//! | face on a slide | N·n̂ = 0 | Q·u − Rb |
//! | face on an arm | N·(Q − A) = b | ψ of N = (sin ψ, σ cos ψ) |
//!
//! With u = (cos φ, sin φ), n̂ = (−sin φ, cos φ) and A = c u, each condition is linear in cos φ and sin φ.

use super::mount::{Mount, MountKind};
use nalgebra::Vector2;

/// Distance between a follower and a piece of a contour, as a function of the cam angle φ: 0 at contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactMiss {
    constant: f64,
    cos: f64,
    sin: f64,
}

impl ContactMiss {
    /// Its value at the cam angle with this cosine and sine.
    pub(crate) fn at(&self, cos: f64, sin: f64) -> f64 {
        self.constant + self.cos * cos + self.sin * sin
    }

    /// Bound on the difference from another at the same cam angle, whichever it is.
    pub(crate) fn change_to(&self, other: &Self) -> f64 {
        (other.constant - self.constant).abs() + libm::hypot(other.cos - self.cos, other.sin - self.sin)
    }
}

impl Mount {
    /// The condition under which the follower touches a piece of a contour.
    pub(crate) fn miss(&self, point: Vector2<f64>, normal: Vector2<f64>) -> ContactMiss {
        match &self.kind {
            MountKind::SlidingTip { offset_mm, radius_mm, .. } => {
                let centre = point + *radius_mm * normal;
                ContactMiss { constant: -offset_mm, cos: centre.y, sin: -centre.x }
            }
            MountKind::SwingingTip { swing, arm_mm, radius_mm } => {
                let (centre, c, a) = (point + *radius_mm * normal, swing.pivot_mm, arm_mm);
                let constant = (centre.norm_squared() + (c - a) * (c + a)) / (2.0 * a);
                ContactMiss { constant, cos: -c * centre.x / a, sin: -c * centre.y / a }
            }
            MountKind::SlidingFace { .. } => ContactMiss { constant: 0.0, cos: normal.y, sin: -normal.x },
            MountKind::SwingingFace { swing, face_offset_mm } => ContactMiss {
                constant: point.dot(&normal) - face_offset_mm,
                cos: -swing.pivot_mm * normal.x,
                sin: -swing.pivot_mm * normal.y,
            },
        }
    }

    /// The lift at which the follower touches a piece, given along u and n̂ of the cam angle at which it does. `None` if it
    /// would have to reach through the axis or past where it lifts.
    pub(crate) fn lift_on(&self, point: (f64, f64), normal: (f64, f64)) -> Option<f64> {
        let ((along, across), (normal_along, normal_across)) = (point, normal);
        let (psi, swing) = match &self.kind {
            MountKind::SlidingTip { height_mm, radius_mm, .. } => {
                let centre = along + radius_mm * normal_along;
                return (centre > 0.0).then_some(centre - height_mm);
            }
            MountKind::SlidingFace { base_radius_mm } => {
                return (normal_along > 0.0).then_some(along - base_radius_mm);
            }
            MountKind::SwingingTip { swing, radius_mm, .. } => {
                let (x, y) = (along + radius_mm * normal_along, across + radius_mm * normal_across);
                (libm::atan2(swing.sense * y, swing.pivot_mm - x), swing)
            }
            MountKind::SwingingFace { swing, .. } => (libm::atan2(normal_along, swing.sense * normal_across), swing),
        };
        let min_rad = swing.bound_rad - core::f64::consts::PI;
        (psi > min_rad && psi < swing.bound_rad).then_some((psi - swing.rest_rad) / swing.rad_per_lift)
    }
}
