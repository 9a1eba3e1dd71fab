// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The wheel beside the design, by arithmetic of its own: a dense polygon of the contour and a circle, nothing of the tool path.

use camwright::cam::contour::Contour;
use camwright::math::units::TURN_RAD;

/// Corners of the polygon.
const POINTS: u32 = 7200;
/// Angles of the wheel line at which the wheel is brought to the polygon; between them a cubic runs through four.
const ANGLES: usize = 3600;
/// Corners that are tried first: every so many.
const STRIDE: usize = 8;

/// Position of the wheel's cutting point at which the wheel just touches, over the angle of the wheel line.
pub(crate) struct Touch {
    x_mm: Vec<f64>,
}

impl Touch {
    /// For a wheel, and a contour with so much stock along its normal: then the wheel is that much larger, and its cutting point as far out.
    pub(crate) fn new(contour: &Contour, wheel_mm: f64, stock_mm: f64) -> Self {
        let at = |i: u32| f64::from(i) * TURN_RAD / f64::from(POINTS);
        let points: Vec<(f64, f64)> = (0..POINTS).map(|i| contour.point(at(i))).map(|p| (p.x, p.y)).collect();
        let reach = wheel_mm + stock_mm;
        let centre = |angle: f64, (x, y): (f64, f64)| {
            let (s, c) = angle.sin_cos();
            let (along, across) = (x * c + y * s, y * c - x * s);
            // A corner that the wheel passes beside, it does not touch.
            if across.abs() < reach { along + (reach * reach - across * across).sqrt() } else { f64::NEG_INFINITY }
        };
        let touch = |index: usize| {
            let angle = index as f64 * TURN_RAD / ANGLES as f64;
            let tried = points.iter().enumerate().step_by(STRIDE).map(|(i, point)| (i, centre(angle, *point)));
            let tried: Vec<(usize, f64)> = tried.collect();
            let best = tried.iter().map(|(_, x)| *x).fold(f64::NEG_INFINITY, f64::max);
            // Whatever comes near it may have a neighbour that lies higher.
            let near = tried
                .iter()
                .filter(|(_, x)| *x > best - 0.05)
                .flat_map(|(i, _)| (0..2 * STRIDE).map(move |k| (i + points_count() - STRIDE + k) % points_count()));
            near.map(|i| centre(angle, points[i])).fold(best, f64::max) - wheel_mm
        };
        Self { x_mm: (0..ANGLES).map(touch).collect() }
    }

    /// At an angle of the wheel line in the frame of the lobe (rad).
    pub(crate) fn at(&self, angle_rad: f64) -> f64 {
        let place = angle_rad.rem_euclid(TURN_RAD) / TURN_RAD * ANGLES as f64;
        let (index, u) = (place.floor() as usize, place.fract());
        let x = |k: usize| self.x_mm[(index + ANGLES + k - 1) % ANGLES];
        let (a, b, c, d) = (x(0), x(1), x(2), x(3));
        a * (-u * (u - 1.0) * (u - 2.0) / 6.0)
            + b * ((u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0)
            + c * (-(u + 1.0) * u * (u - 2.0) / 2.0)
            + d * ((u + 1.0) * u * (u - 1.0) / 6.0)
    }

    /// Farthest out, wherever the part stands.
    pub(crate) fn highest(&self) -> f64 {
        self.x_mm.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }
}

const fn points_count() -> usize {
    POINTS as usize
}
