// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A path in cells of the turned angle: between which bounds the derivatives of both slides lie in each, and what they and C make of a
//! speed that varies there.
//!
//! With the spindle at ω, its acceleration α and its jerk j the slide does v = s′ω, a = s″ω² + s′α, and s‴ω³ + 3 s″ωα + s′j. All of these
//! lie within ranges over a cell, so the sums are bounded by products of ranges, and nothing between two places is missed.

use super::rates::{AxisLimits, SpeedBound};
use super::{InsertPath, ZLaw};
use crate::machine::description::MotionLimits;
use crate::math::range::{maximum_of_sum, minimum_and_maximum, product, scaled};
use crate::math::uniform_hermite::UniformHermite;
use alloc::vec;
use alloc::vec::Vec;

/// Cells of a turn: 5°. With cells of 10° two cams of 1 and 4.5 mm lift take 16 % longer to turn, with 2.5° 2 % less, for twice the time to
/// plan and twice the knots.
const CELLS: u32 = 72;

type ValueSpan = (f64, f64);

/// Ranges of the first three derivatives of a slide over the turned angle (mm/rad, mm/rad², mm/rad³).
type Derivatives = [ValueSpan; 3];

/// The cells of a path, from its begin to its end.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cells {
    /// Their width (rad); the path ends in the last one.
    pub(super) width_rad: f64,
    x: Vec<Derivatives>,
    z: Vec<Derivatives>,
}

/// Spindle motion over a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SpindleMotion {
    /// Time (s).
    pub(super) time_s: f64,
    speed: ValueSpan,
    acceleration: ValueSpan,
    jerk: ValueSpan,
}

impl SpindleMotion {
    /// Over a cell between two speeds with their accelerations: ω over time is the cubic through them, and the time such that the angle
    /// is the cell's. `None` where that would turn back.
    pub(super) fn new(width_rad: f64, from: (f64, f64), to: (f64, f64)) -> Option<Self> {
        let ((w0, a0), (w1, a1)) = (from, to);
        // ∫ω = T (ω₀ + ω₁)/2 + T² (α₀ − α₁)/12.
        let (mean, bend) = (0.5 * (w0 + w1), (a0 - a1) / 12.0);
        let root = mean * mean + 4.0 * bend * width_rad;
        if !(root >= 0.0 && mean > 0.0) {
            return None;
        }
        let t = 2.0 * width_rad / (mean + libm::sqrt(root));
        let of = |values: &[f64]| minimum_and_maximum(values.iter().copied());
        let (b1, b2) = (w0 + a0 * t / 3.0, w1 - a1 * t / 3.0);
        let middle = 3.0 * (b2 - b1) / t;
        let speed = of(&[w0, b1, b2, w1]);
        if !(speed.0 > 0.0 && t.is_finite()) {
            return None;
        }
        let jerk = of(&[2.0 * (middle - a0) / t, 2.0 * (a1 - middle) / t]);
        Some(Self { time_s: t, speed, acceleration: of(&[a0, middle, a1]), jerk })
    }
}

impl Cells {
    pub(super) fn new(path: &InsertPath) -> Self {
        let knots = (path.request().angles / CELLS).max(1) as usize;
        let x = gathered(path.x(), knots);
        let z = match path.z() {
            ZLaw::Straight { per_rad, .. } => vec![[(*per_rad, *per_rad), (0.0, 0.0), (0.0, 0.0)]; x.len()],
            ZLaw::Spline(spline) => gathered(spline, knots),
        };
        Self { width_rad: path.x().step() * knots as f64, x, z }
    }

    pub(super) fn count(&self) -> usize {
        self.x.len()
    }

    /// Largest magnitudes of a slide's derivatives from a cell to before another: X, Z.
    pub(super) fn maximum(&self, cells: core::ops::Range<usize>) -> [[f64; 3]; 2] {
        [&self.x[cells.clone()], &self.z[cells]].map(|all| {
            all.iter().fold([0.0; 3], |maximum, ranges| {
                core::array::from_fn(|i| f64::max(maximum[i], f64::max(-ranges[i].0, ranges[i].1)))
            })
        })
    }

    /// The fastest constant speed in a cell (rad/s).
    pub(super) fn fastest(&self, cell: usize, limits: &AxisLimits) -> f64 {
        let maximum = self.maximum(cell..cell + 1);
        [limits.x, limits.z].iter().zip(maximum).fold(limits.spindle_rad_s, |rad_s, (limits, [s1, s2, s3])| {
            let slide = [limits.velocity / s1, libm::sqrt(limits.acceleration / s2), libm::cbrt(limits.jerk / s3)];
            slide.into_iter().fold(rad_s, f64::min)
        })
    }

    /// Factor by which the spindle must slow down in a cell to keep the limits of slides and spindle, with all speeds, accelerations and
    /// jerks scaled alike; and the quantity that requires it.
    pub(super) fn slower(
        &self,
        cell: usize,
        turning: &SpindleMotion,
        limits: &AxisLimits,
        c: &MotionLimits,
    ) -> (f64, SpeedBound) {
        let SpindleMotion { speed: w, acceleration: a, jerk: j, .. } = *turning;
        let maximum = |range: ValueSpan| f64::max(-range.0, range.1);
        let w2 = (w.0 * w.0, w.1 * w.1);
        let (w3, wa3) = ((w2.0 * w.0, w2.1 * w.1), scaled(a, (3.0 * w.0, 3.0 * w.1)));
        let mut worst = [
            (w.1 / limits.spindle_rad_s.min(c.velocity), SpeedBound::Spindle),
            (maximum(a) / c.acceleration, SpeedBound::Acceleration("c_axis")),
            (maximum(j) / c.jerk, SpeedBound::Jerk("c_axis")),
        ];
        for (axis, [s1, s2, s3], limits) in [("x_axis", self.x[cell], limits.x), ("z_axis", self.z[cell], limits.z)] {
            let used = [
                (maximum(scaled(s1, w)) / limits.velocity, SpeedBound::Velocity(axis)),
                (
                    maximum_of_sum([scaled(s2, w2), product(s1, a)]) / limits.acceleration,
                    SpeedBound::Acceleration(axis),
                ),
                (
                    maximum_of_sum([scaled(s3, w3), product(s2, wa3), product(s1, j)]) / limits.jerk,
                    SpeedBound::Jerk(axis),
                ),
            ];
            for (worst, used) in worst.iter_mut().zip(used) {
                if used.0 > worst.0 {
                    *worst = used;
                }
            }
        }
        let [velocity, acceleration, jerk] = worst;
        // A root only of what asks for more than what came before.
        let mut maximum = velocity;
        if acceleration.0 > maximum.0 * maximum.0 {
            maximum = (libm::sqrt(acceleration.0), acceleration.1);
        }
        if jerk.0 > maximum.0 * maximum.0 * maximum.0 {
            maximum = (libm::cbrt(jerk.0), jerk.1);
        }
        maximum
    }
}

fn gathered(spline: &UniformHermite, knots: usize) -> Vec<Derivatives> {
    let pieces = spline.knots().len() - 1;
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let cell = |first: usize| {
        (first..(first + knots).min(pieces)).fold([none; 3], |all: Derivatives, left| {
            let hulls = spline.hulls(left);
            core::array::from_fn(|i| (all[i].0.min(hulls[i].0), all[i].1.max(hulls[i].1)))
        })
    };
    (0..pieces).step_by(knots).map(cell).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cam::surface::Surface;
    use crate::cam::surface::solid::Solid;
    use crate::toolpath::insert_path::{InsertFeed, PathRequest};

    /// ω = 2 + t − t² over a second turns by 2 + ½ − ⅓; its acceleration is 1 − 2t, its jerk −2.
    #[test]
    fn a_cell_is_passed_in_the_time_that_its_speeds_take() {
        let turning = SpindleMotion::new(2.0 + 1.0 / 6.0, (2.0, 1.0), (2.0, -1.0)).expect("it turns on");
        assert!((turning.time_s - 1.0).abs() < 1e-12);
        assert!(turning.speed.0 <= 2.0 && turning.speed.1 >= 2.25 && turning.speed.1 < 2.34, "{turning:?}");
        assert!((turning.acceleration.0 + 1.0).abs() < 1e-12 && (turning.acceleration.1 - 1.0).abs() < 1e-12);
        assert!((turning.jerk.0 + 2.0).abs() < 1e-12 && (turning.jerk.1 + 2.0).abs() < 1e-12);
        assert_eq!(SpindleMotion::new(1.0, (0.0, 0.0), (0.0, 0.0)), None);
        assert_eq!(SpindleMotion::new(1.0, (1.0, -9.0), (1.0, 9.0)), None, "it would turn back");
    }

    /// An eccentric at centre height: X″ is largest where it is farthest out, e + e²/a. With the spindle at constant speed only that
    /// and the like count; with its acceleration the terms add up.
    #[test]
    fn the_worst_cell_is_reported_with_its_share() {
        let (a, e) = (20.0, 2.0);
        let eccentric = Solid::Eccentric { radius_mm: a, eccentricity_mm: e, azimuth_rad: 0.0 };
        let surface = Surface::solid(eccentric, 0.0, 10.0).expect("an eccentric");
        let request = PathRequest {
            insert_radius_mm: 4.0,
            plane_y_mm: 0.0,
            from_mm: 1.0,
            to_mm: 3.0,
            feed: InsertFeed::AlongZ(0.5),
            angles: 360,
            start_rad: 0.0,
            stock_mm: 0.0,
        };
        let path = InsertPath::new(&surface, &request).expect("a path");
        let cells = Cells::new(&path);
        assert_eq!(cells.count(), 4 * 72);
        let wide = MotionLimits { velocity: 1e9, acceleration: 1e9, jerk: 1e9 };
        let limits = AxisLimits { x: MotionLimits { acceleration: 100.0, ..wide }, z: wide, spindle_rad_s: 1e9 };
        // At a constant acceleration ω² grows by 2α over a rad.
        let turning = |rad_s: f64, slope: f64| {
            let after = libm::sqrt(rad_s * rad_s + 2.0 * slope * cells.width_rad);
            SpindleMotion::new(cells.width_rad, (rad_s, slope), (after, slope)).expect("it turns on")
        };
        let maximum = e + e * e / a;
        let fastest = libm::sqrt(100.0 / maximum);
        assert!((cells.fastest(0, &limits) - fastest).abs() < 2e-3 * fastest, "{}", cells.fastest(0, &limits));
        let (over, bound) = cells.slower(0, &turning(2.0 * fastest, 0.0), &limits, &wide);
        assert!((over - 2.0).abs() < 4e-3 && bound == SpeedBound::Acceleration("x_axis"), "{over} {bound}");
        // A quarter turn on X falls by e per rad and hardly bends: ω̇ alone moves it.
        let (over, bound) = cells.slower(18, &turning(2.0, 400.0 / e), &limits, &wide);
        assert!(over > 1.9 && over < 2.1 && bound == SpeedBound::Acceleration("x_axis"), "{over} {bound}");
        let slow = MotionLimits { acceleration: 8.0, ..wide };
        let (over, bound) = cells.slower(18, &turning(2.0, 400.0 / e), &limits, &slow);
        assert!((over - 5.0).abs() < 1e-9 && bound == SpeedBound::Acceleration("c_axis"), "{over} {bound}");
    }
}
