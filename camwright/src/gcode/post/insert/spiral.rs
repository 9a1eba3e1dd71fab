// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! X and Z of a pass over the turned angle, and the time at which C is there.

use super::{InsertPassRequest, InsertPostRequest};
use crate::gcode::archimedean::{Chain, ChainDeviation, ChainError, ChainRequest, Travelling};
use crate::gcode::{NcAxis, NumberFormat};
use crate::math::hermite::Sample;
use crate::math::uniform_hermite::UniformHermite;
use crate::math::units::TURN_RAD;
use crate::toolpath::insert_path::{InsertPath, SpindleLaw, ZLaw};
use alloc::vec::Vec;

/// Longest piece of a path that is cut into blocks at once (turns): it bounds the memory for the places that are looked at.
const PIECE_TURNS: f64 = 8.0;

/// Bisections of a time: more than the digits of a number.
const BISECTIONS: u32 = 60;

/// A pass as motion over its turned angle.
pub(super) struct InsertMotion<'a> {
    path: &'a InsertPath,
    spindle: &'a SpindleLaw,
    speed_share: f64,
}

impl<'a> InsertMotion<'a> {
    pub(super) fn new(pass: &InsertPassRequest<'a>) -> Self {
        Self { path: pass.path, spindle: pass.spindle, speed_share: pass.speed_share }
    }

    /// Start and end of the turned angle (rad).
    pub(super) fn range(&self) -> (f64, f64) {
        (self.path.x().start(), self.path.x().end())
    }

    /// Returns whether Z follows a law of its own; else it goes in proportion to C.
    pub(super) fn z_travels(&self) -> bool {
        matches!(self.path.z(), ZLaw::Spline(_))
    }

    pub(super) fn x_at(&self, turned_rad: f64) -> Sample {
        self.path.x().sample(turned_rad)
    }

    pub(super) fn z_at(&self, turned_rad: f64) -> Sample {
        self.path.z_at(turned_rad)
    }

    /// Equal pieces of the path, each cut into blocks by itself.
    pub(super) fn pieces(&self) -> Vec<(f64, f64)> {
        let (from, to) = self.range();
        let count = libm::ceil((to - from) / (PIECE_TURNS * TURN_RAD)).max(1.0);
        #[allow(clippy::cast_possible_truncation, reason = "a path has at most some thousand turns")]
        let whole = count as u32;
        let end = |piece: u32| if piece == whole { to } else { from + (to - from) * f64::from(piece) / count };
        (0..whole).map(|piece| (end(piece), end(piece + 1))).collect()
    }

    /// Share of a tolerance (mm) that rounding to increments uses: of the linear axis, and of C where an axis is steepest.
    pub(super) fn rounding_mm(&self, format: NumberFormat) -> f64 {
        let rates = self.path.rates();
        let steepest = rates.x.velocity.value.max(rates.z.velocity.value);
        let linear = format.value(NcAxis::Z, 1).max(format.value(NcAxis::X, 1));
        0.5 * linear + 0.5 * format.value(NcAxis::C, 1) * steepest
    }

    pub(super) fn fastest_rad_s(&self) -> f64 {
        self.speed_share * self.spindle.range_rad_s.1
    }

    /// Time at which C has turned to an angle (s).
    pub(super) fn time_at(&self, turned_rad: f64) -> f64 {
        let (knots, law) = (self.spindle.law.knots(), &self.spindle.law);
        let since = turned_rad - self.path.x().start();
        let right = knots.partition_point(|knot| knot.value < since).clamp(1, knots.len() - 1);
        let (mut low, mut high) = (knots[right - 1].at, knots[right].at);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if law.sample(middle).value < since { low = middle } else { high = middle }
        }
        high / self.speed_share
    }

    /// Deviation of a chain of X and Z from the path, from an angle to another, on a grid 8 times finer than that of the blocks. The path
    /// comes from its Bézier points here, not from the polynomials that the blocks were made of.
    pub(super) fn judge(
        &self,
        chain: &Chain,
        (from_rad, to_rad): (f64, f64),
        tolerance_mm: f64,
    ) -> Result<ChainDeviation, ChainError> {
        let x = |turned_rad: f64| by_bezier_points(self.path.x(), turned_rad);
        let z = |turned_rad: f64| match self.path.z() {
            ZLaw::Spline(spline) => by_bezier_points(spline, turned_rad),
            ZLaw::Straight { .. } => self.z_at(turned_rad),
        };
        let travels: [Travelling<'_>; 2] = [&x, &z];
        chain.judge(&ChainRequest {
            travels: &travels,
            from_rad,
            to_rad,
            tolerance_mm,
            rounding_mm: 0.0,
            knots: crate::gcode::archimedean::Knots::OnCurve,
        })
    }
}

/// Value of a spline by the algorithm of de Casteljau; its derivatives as the spline has them.
fn by_bezier_points(spline: &UniformHermite, at: f64) -> Sample {
    let (h, last) = (spline.step(), spline.knots().len() - 1);
    let place = ((at - spline.start()) / h).clamp(0.0, last as f64);
    #[allow(clippy::cast_possible_truncation, reason = "it lies between the ends")]
    let left = (place as usize).min(last - 1);
    let ([a, a1, a2], [b, b1, b2]) = (spline.knots()[left], spline.knots()[left + 1]);
    let mut points = [
        a,
        a + h * a1 / 5.0,
        a + 2.0 * h * a1 / 5.0 + h * h * a2 / 20.0,
        b - 2.0 * h * b1 / 5.0 + h * h * b2 / 20.0,
        b - h * b1 / 5.0,
        b,
    ];
    let u = place - left as f64;
    for count in (1..points.len()).rev() {
        for point in 0..count {
            points[point] += u * (points[point + 1] - points[point]);
        }
    }
    Sample { value: points[0], ..spline.sample(at) }
}

impl InsertPostRequest<'_> {
    /// Increments of X for a place of the insert's centre (mm).
    pub(super) fn x_count(&self, centre_mm: f64) -> Result<i64, crate::gcode::FormatError> {
        self.control.format.count(NcAxis::X, centre_mm + self.x_shift_mm)
    }

    /// Place of the insert's centre (mm) for increments of X.
    pub(super) fn x_value(&self, count: i64) -> f64 {
        self.control.format.value(NcAxis::X, count) - self.x_shift_mm
    }
}
