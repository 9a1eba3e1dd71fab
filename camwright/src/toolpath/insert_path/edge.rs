// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Arc of the insert's edge that cuts along a path.
//!
//! ```text
//!      x    raw part ________        The angle is measured at the insert's centre: 0 towards the spindle axis, positive towards +z.
//!      │            /               At the contact it is τ. With a feed f towards +z and a depth d on a straight section the edge
//!      │   ____(   /  insert        cuts from the cusp behind the contact, τ − asin(f/2R), to the raw part before it, τ + acos(1 − d/R).
//!      └───────────── z
//! ```
//! Here both ends come from the path itself: the cusp is where the circles of two turns meet, and the surface that the pass before left is the
//! parallel to the contacts of the turns to come.

use super::{InsertFeed, InsertPath};
use core::f64::consts::PI;

/// Material in front of a pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UncutBar {
    /// x of the bar in the rake plane (mm).
    pub x_mm: f64,
    /// z of its end, where the passes enter (mm).
    pub end_mm: f64,
    /// Depth below the surface that the pass before left (mm); `None`: the pass cuts the bar itself.
    pub depth_mm: Option<f64>,
}

/// An angle of the insert, and the place on the part at which it occurs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AngleAt {
    /// The angle (rad).
    pub angle_rad: f64,
    /// Turned angle θ at which that place is cut (rad).
    pub turned_rad: f64,
    /// z (mm).
    pub z_mm: f64,
}

/// Arc of the edge that cuts: angles at the insert's centre, 0 towards the spindle axis, positive towards +z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EngagedEdge {
    pub min: AngleAt,
    pub max: AngleAt,
}

impl EngagedEdge {
    /// The smallest arc that holds both.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self {
            min: if other.min.angle_rad < self.min.angle_rad { other.min } else { self.min },
            max: if other.max.angle_rad > self.max.angle_rad { other.max } else { self.max },
        }
    }
}

/// Least number of points of the surface before a pass within the insert's radius.
const POINTS: f64 = 64.0;

impl InsertPath {
    /// Arc of the edge that cuts on this path; `None` if the path cuts nothing.
    #[must_use]
    pub fn engaged_edge(&self, raw: &UncutBar) -> Option<EngagedEdge> {
        let mut found: Option<EngagedEdge> = None;
        for knot in 0..self.edge_rad.len() {
            let Some((low, high)) = self.engaged_at(knot, raw) else { continue };
            let radius_mm = self.request.insert_radius_mm;
            let (turned_rad, [_, centre_mm]) = (self.x.at(knot), self.centre(knot));
            let [min, max] = [low, high].map(|angle_rad| AngleAt {
                angle_rad,
                turned_rad,
                z_mm: centre_mm + radius_mm * libm::sin(angle_rad),
            });
            let here = EngagedEdge { min, max };
            found = Some(found.map_or(here, |found| found.with(here)));
        }
        found
    }

    /// X and z of the insert's centre at a knot (mm).
    fn centre(&self, knot: usize) -> [f64; 2] {
        [self.x.knots()[knot][0], self.z_at(self.x.at(knot)).value]
    }

    /// +1 for a feed towards +z, else −1.
    fn towards(&self) -> f64 {
        if self.request.to_mm < self.request.from_mm { -1.0 } else { 1.0 }
    }

    /// Smallest and largest angle of the edge that cuts at a knot. Angles and lengths are counted along the feed until the last line.
    fn engaged_at(&self, knot: usize, raw: &UncutBar) -> Option<(f64, f64)> {
        let (radius_mm, towards) = (self.request.insert_radius_mm, self.towards());
        let [x_mm, z_mm] = self.centre(knot);
        // Below the bar's surface, and behind its end.
        let (above, before) = ((x_mm - raw.x_mm) / radius_mm, towards * (raw.end_mm - z_mm) / radius_mm);
        if above >= 1.0 || before >= 1.0 {
            return None;
        }
        let bar = libm::acos(above.max(-1.0));
        let end = if before <= -1.0 { -PI } else { libm::asin(before) };
        let low = self.cusp_rad(knot).max(-bar).max(end);
        let high = raw.depth_mm.map_or(bar, |depth_mm| self.ahead_rad(knot, depth_mm).min(bar));
        match (low <= high, towards > 0.0) {
            (false, _) => None,
            (true, true) => Some((low, high)),
            (true, false) => Some((-high, -low)),
        }
    }

    /// Angle at which the edge meets that of the turn before, or the contact if that lies behind.
    fn cusp_rad(&self, knot: usize) -> f64 {
        let contact_rad = self.towards() * self.edge_rad[knot];
        let Some(before) = knot.checked_sub(self.request.angles as usize) else { return contact_rad };
        let ([x, z], [x_before, z_before]) = (self.centre(knot), self.centre(before));
        let (along, out) = (self.towards() * (z_before - z), x_before - x);
        let half = 0.5 * libm::hypot(along, out) / self.request.insert_radius_mm;
        let cusp_rad = libm::atan2(along, -out) + libm::acos(half.min(1.0));
        cusp_rad.min(contact_rad)
    }

    /// Angle at which the edge meets the surface that the pass before left.
    fn ahead_rad(&self, knot: usize, depth_mm: f64) -> f64 {
        let (radius_mm, towards) = (self.request.insert_radius_mm, self.towards());
        let [x, z] = self.centre(knot);
        let (InsertFeed::AlongZ(feed_mm) | InsertFeed::AlongCurve(feed_mm)) = self.request.feed;
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a feed is above 0 and no more than R"
        )]
        let stride = ((radius_mm / (POINTS * feed_mm)) as usize).max(1) * self.request.angles as usize;
        let contact = |at: usize| towards * self.edge_rad[at];
        let left = |at: usize| {
            let ([x_there, z_there], (sin, cos)) = (self.centre(at), libm::sincos(contact(at)));
            [towards * (z_there - z) + (radius_mm - depth_mm) * sin, x_there - x - (radius_mm - depth_mm) * cos]
        };
        let mut from = left(knot);
        if libm::hypot(from[0], from[1]) >= radius_mm {
            return if depth_mm > radius_mm { PI } else { contact(knot) };
        }
        let mut last = knot;
        for at in (knot..self.edge_rad.len()).step_by(stride).skip(1) {
            let to = left(at);
            if libm::hypot(to[0], to[1]) >= radius_mm {
                return leaving_rad(from, to, radius_mm);
            }
            (from, last) = (to, at);
        }
        // Behind the last turn the surface goes on straight.
        let (sin, cos) = libm::sincos(contact(last));
        leaving_rad(from, [from[0] + 2.0 * radius_mm * cos, from[1] + 2.0 * radius_mm * sin], radius_mm)
    }
}

/// Angle at which a line from inside a circle about the insert's centre leaves it.
fn leaving_rad([along, out]: [f64; 2], to: [f64; 2], radius_mm: f64) -> f64 {
    let way = [to[0] - along, to[1] - out];
    let square = way[0] * way[0] + way[1] * way[1];
    let (half, rest) = (along * way[0] + out * way[1], radius_mm * radius_mm - along * along - out * out);
    let share = (libm::sqrt((half * half + square * rest).max(0.0)) - half) / square;
    libm::atan2(along + share * way[0], -(out + share * way[1]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cam::surface::Surface;
    use crate::cam::surface::solid::{LinearInZ, Solid};
    use crate::toolpath::insert_path::PathRequest;

    const RADIUS_MM: f64 = 8.0;
    const FEED_MM: f64 = 0.5;

    fn request(from_mm: f64, to_mm: f64) -> PathRequest {
        PathRequest {
            insert_radius_mm: RADIUS_MM,
            plane_y_mm: 0.0,
            from_mm,
            to_mm,
            feed: InsertFeed::AlongZ(FEED_MM),
            angles: 180,
            start_rad: 0.0,
            stock_mm: 0.3,
        }
    }

    fn engaged(surface: &Surface, request: &PathRequest, raw: &UncutBar) -> (f64, f64) {
        let path = InsertPath::new(surface, request).expect("a path");
        let edge = path.engaged_edge(raw).expect("it cuts");
        (edge.min.angle_rad, edge.max.angle_rad)
    }

    fn is_arc(found: (f64, f64), low: f64, high: f64) {
        assert!((found.0 - low).abs() < 1e-9 && (found.1 - high).abs() < 1e-9, "{found:?}, {low} to {high}");
    }

    /// A cylinder is touched at 0: from asin(f/2R) behind to acos(1 − d/R) before, or to the bar of radius B, acos((X − B)/R).
    #[test]
    fn a_cylinder_uses_the_edge_from_the_cusp_to_the_raw_part() {
        let surface = Surface::solid(Solid::Cylinder { radius_mm: 20.0 }, 0.0, 20.0).expect("a cylinder");
        let behind = libm::asin(0.5 * FEED_MM / RADIUS_MM);
        for depth_mm in [0.2, 1.0, 3.0] {
            let ahead = libm::acos(1.0 - depth_mm / RADIUS_MM);
            let raw = |end_mm: f64| UncutBar { x_mm: 30.0, end_mm, depth_mm: Some(depth_mm) };
            is_arc(engaged(&surface, &request(14.0, 6.0), &raw(100.0)), -ahead, behind);
            is_arc(engaged(&surface, &request(6.0, 14.0), &raw(-100.0)), -behind, ahead);
        }
        let ahead = libm::acos((20.3 + RADIUS_MM - 22.0) / RADIUS_MM);
        let bar = UncutBar { x_mm: 22.0, end_mm: 100.0, depth_mm: None };
        is_arc(engaged(&surface, &request(14.0, 6.0), &bar), -ahead, behind);
        // A bar that the pass does not reach, and a path before the bar's end.
        let path = InsertPath::new(&surface, &request(14.0, 6.0)).expect("a path");
        assert_eq!(path.engaged_edge(&UncutBar { x_mm: 20.2, ..bar }), None);
        assert_eq!(path.engaged_edge(&UncutBar { end_mm: -3.0, ..bar }), None);
    }

    /// A cone of half angle a is touched at a where it widens towards +z, at −a where it narrows. Its turns are f/cos a apart.
    #[test]
    fn a_cone_is_cut_at_its_half_angle() {
        let depth_mm = 0.6;
        for half_angle in [-0.35_f64, -0.1, 0.1, 0.35] {
            let radius_mm = LinearInZ { at_zero: 24.0, per_mm: libm::tan(half_angle) };
            let cone = Solid::EllipticCone { first_mm: radius_mm, second_mm: radius_mm, azimuth_rad: 0.0 };
            let surface = Surface::solid(cone, 0.0, 20.0).expect("a cone");
            let behind = libm::asin(0.5 * FEED_MM / libm::cos(half_angle) / RADIUS_MM);
            let ahead = libm::acos(1.0 - depth_mm / RADIUS_MM);
            let raw = |end_mm: f64| UncutBar { x_mm: 60.0, end_mm, depth_mm: Some(depth_mm) };
            let ask = request(14.0, 6.0);
            is_arc(engaged(&surface, &ask, &raw(100.0)), half_angle - ahead, half_angle + behind);
            let back = engaged(&surface, &request(6.0, 14.0), &raw(-100.0));
            is_arc(back, half_angle - behind, half_angle + ahead);
            // Along the curve the turns are f apart, less what whole steps leave.
            let along = PathRequest { feed: InsertFeed::AlongCurve(FEED_MM), ..ask };
            let (low, high) = engaged(&surface, &along, &raw(100.0));
            let behind = libm::asin(0.5 * FEED_MM / RADIUS_MM);
            assert!(
                (low - half_angle + ahead).abs() < 1e-9 && (high - half_angle - behind).abs() < 1e-3,
                "{low} {high}"
            );
        }
    }

    /// An insert of radius R in a round groove of radius ρ: the surface before the pass is a circle of radius ρ − d, and the edge meets it
    /// at the angle of the triangle of R, ρ − d and the distance of the centres, ρ − R.
    #[test]
    fn a_hollow_uses_more_of_the_edge_than_a_straight_section() {
        let (groove_mm, depth_mm) = (20.0_f64, 0.5);
        let left_mm = groove_mm - depth_mm;
        let apart_mm = groove_mm - RADIUS_MM;
        let wide = libm::acos(
            (left_mm * left_mm - RADIUS_MM * RADIUS_MM - apart_mm * apart_mm) / (2.0 * RADIUS_MM * apart_mm),
        );
        assert!(wide > libm::acos(1.0 - depth_mm / RADIUS_MM));
        // The contacts of a groove with its centre at z = 0, x = 0: the insert's centre on a circle of radius ρ − R.
        let turns = 400;
        let ask = PathRequest { stock_mm: 0.0, ..request(-5.0, 5.0) };
        let step = ask.step_rad();
        let knots = turns * ask.angles as usize;
        let at = |knot: usize| ask.from_mm + 10.0 * knot as f64 / knots as f64;
        let x = (0..=knots).map(|knot| [-libm::sqrt(apart_mm * apart_mm - at(knot) * at(knot)), 0.0, 0.0]).collect();
        let path = InsertPath {
            request: PathRequest { feed: InsertFeed::AlongZ(10.0 / turns as f64), ..ask },
            x: super::super::UniformHermite::new(0.0, step, x).expect("knots"),
            z: super::super::ZLaw::Straight { from_mm: -5.0, per_rad: 10.0 / (knots as f64 * step) },
            edge_rad: (0..=knots).map(|knot| libm::asin(at(knot) / apart_mm)).collect(),
            hollow: None,
            accuracy: super::super::InsertPathAccuracy { interpolation_error_mm: 0.0, gouge_mm: 0.0, places: 0 },
        };
        let middle = knots / 2;
        let ahead = path.ahead_rad(middle, depth_mm);
        assert!((ahead - wide).abs() < 2e-3, "{ahead} {wide}");
    }
}
