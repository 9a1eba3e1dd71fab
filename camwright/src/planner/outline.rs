// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Distance of a wheel from the finished contour of a lobe, from points of the contour alone: nothing of the tool path is used.

use crate::cam::contour::Contour;
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// Points of an outline: every 0.1°. Between two of them a contour of 60 mm bulges by less than 0.05 µm.
const POINTS: usize = 3600;
/// Points between those that are looked at first.
const STRIDE: usize = 10;

/// Points all around a contour.
#[derive(Debug, Clone)]
pub(super) struct ContourPoints {
    points: Vec<(f64, f64)>,
    /// Squared spacing of the points that are looked at first, and largest curvature (mm², 1/mm).
    spacing_mm2: f64,
    curvature: f64,
}

impl ContourPoints {
    pub(super) fn new(contour: &Contour) -> Self {
        let at = |i: usize| i as f64 * TURN_RAD / POINTS as f64;
        let points: Vec<(f64, f64)> =
            (0..POINTS).map(|i| contour.point_about_axis(at(i))).map(|p| (p.x, p.y)).collect();
        let spacing_mm2 = (0..POINTS).step_by(STRIDE).map(|i| {
            let (a, b) = (points[i], points[(i + STRIDE) % POINTS]);
            square(a.0 - b.0, a.1 - b.1)
        });
        let spacing_mm2 = spacing_mm2.fold(0.0, f64::max);
        let curvature = (0..POINTS).map(|i| contour.curvature(at(i)).abs()).fold(0.0, f64::max);
        Self { points, spacing_mm2, curvature }
    }

    /// Distance between the wheel and the contour (mm), below 0 where the wheel stands in it. `x_mm` is that of the wheel's cutting point,
    /// at an angle of the wheel line in the lobe's frame (rad).
    pub(super) fn gap_mm(&self, wheel_radius_mm: f64, x_mm: f64, angle_rad: f64) -> f64 {
        let centre = x_mm + wheel_radius_mm;
        let (x, y) = (centre * libm::cos(angle_rad), centre * libm::sin(angle_rad));
        let square_at = |point: &(f64, f64)| square(point.0 - x, point.1 - y);
        let firsts = || self.points.iter().step_by(STRIDE).map(square_at);
        let nearest = firsts().fold(f64::INFINITY, f64::min);
        // A nearer point between two of them is at most a spacing beside one, along a contour that bends towards the wheel or away.
        let near = nearest + self.spacing_mm2 * (1.0 + (libm::sqrt(nearest) + wheel_radius_mm) * self.curvature);
        let mut min = nearest;
        for (index, _) in firsts().enumerate().filter(|(_, square)| *square <= near) {
            let from = index * STRIDE;
            let beside = (from + 1..from + STRIDE).chain(from + POINTS + 1 - STRIDE..from + POINTS);
            min = beside.map(|i| square_at(&self.points[i % POINTS])).fold(min, f64::min);
        }
        libm::sqrt(min) - wheel_radius_mm
    }
}

fn square(a: f64, b: f64) -> f64 {
    a * a + b * b
}
