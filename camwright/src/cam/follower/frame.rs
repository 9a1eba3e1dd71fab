// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The contour at one cam angle: where the follower touches it, from how the follower moves.
//!
//! Everything is in the frame that turns with the follower: u = (cos φ, sin φ) along it, n̂ = (−sin φ, cos φ) square to
//! it. Differentiating with φ in the cam's frame, u′ = n̂ and n̂′ = −u.

use nalgebra::Vector2;

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

/// Motion of a trace point over the cam angle: components along u and n̂, each with its first and second derivative.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trace {
    pub(crate) along: [f64; 3],
    pub(crate) across: [f64; 3],
}

/// Motion of a straight face over the cam angle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Face {
    /// Unit normal, away from the cam, along u and n̂.
    pub(crate) normal: (f64, f64),
    /// ω′ and ω″, the rates of the normal's azimuth.
    pub(crate) turning: [f64; 2],
    /// Distance of the face from the axis (mm) with its first and second derivative.
    pub(crate) support: [f64; 3],
}

impl LocalFrame {
    /// The contour inside a round tip of radius r about a trace point P, Q = P − rN. The velocity of P in the cam's frame
    /// is V = P′, N is V turned by −90°, and N turns by dω/dφ = V × V′ / V².
    pub(crate) fn from_tip(trace: &Trace, radius_mm: f64) -> Self {
        let ([p, p1, p2], [q, q1, q2]) = (trace.along, trace.across);
        let (along, across) = (p1 - q, q1 + p);
        let (along_rate, across_rate) = (p2 - q1, q2 + p1);
        let square = along * along + across * across;
        let length = libm::sqrt(square);
        let turning = (across * across + along * (along + across_rate) - across * along_rate) / square;
        let (normal_along, normal_across) = (across / length, -along / length);
        Self {
            along: p - radius_mm * normal_along,
            across: q - radius_mm * normal_across,
            normal_along,
            normal_across,
            turning,
            arc: length - radius_mm * turning,
        }
    }

    /// The envelope of the lines x·N(φ) = h(φ). Where one of them touches it, x·dN/dφ = h′ holds as well, and with
    /// dN/dφ = ω′T, T = N turned by 90°, the point is Q = hN + (h′/ω′)T. Its rate along T is ω′(h + d²h/dω²):
    /// dl/dφ = hω′ + (h″ω′ − h′ω″)/ω′². For ω′ = 1 this is the support function.
    pub(crate) fn from_face(face: &Face) -> Self {
        let ((normal_along, normal_across), [turning, turning_rate], [h, h1, h2]) =
            (face.normal, face.turning, face.support);
        let beside = h1 / turning;
        Self {
            along: h * normal_along - beside * normal_across,
            across: h * normal_across + beside * normal_along,
            normal_along,
            normal_across,
            turning,
            arc: h * turning + (h2 * turning - h1 * turning_rate) / (turning * turning),
        }
    }

    /// The same point of a wall with the part outside.
    pub(crate) fn seen_from_inside(self) -> Self {
        Self { normal_along: -self.normal_along, normal_across: -self.normal_across, arc: -self.arc, ..self }
    }

    /// Distance of the tangent from the axis, Q·N (mm), negative in a bore.
    pub(crate) fn support(&self) -> f64 {
        self.along * self.normal_along + self.across * self.normal_across
    }

    /// Distance of Q along its tangent from the foot of the axis' perpendicular on that, Q·T (mm): h′ of the support function.
    pub(crate) fn beside(&self) -> f64 {
        self.across * self.normal_along - self.along * self.normal_across
    }

    /// Curvature (1/mm).
    pub(crate) fn curvature(&self) -> f64 {
        self.turning / self.arc
    }

    /// The point a distance outside, along u and n̂.
    pub(crate) fn outside(&self, distance_mm: f64) -> (f64, f64) {
        (self.along + distance_mm * self.normal_along, self.across + distance_mm * self.normal_across)
    }

    /// Rate of the azimuth of that point W: dθ/dφ = (dl/dφ + R dω/dφ)(W·N)/W².
    pub(crate) fn azimuth_rate(&self, distance_mm: f64) -> f64 {
        let (along, across) = self.outside(distance_mm);
        (self.arc + distance_mm * self.turning) * (self.support() + distance_mm) / (along * along + across * across)
    }
}

/// A vector given along u and n̂ at a cam angle, in the cam's frame.
pub(crate) fn rotated(along: f64, across: f64, angle_rad: f64) -> Vector2<f64> {
    let (sin, cos) = (libm::sin(angle_rad), libm::cos(angle_rad));
    Vector2::new(along * cos - across * sin, along * sin + across * cos)
}
