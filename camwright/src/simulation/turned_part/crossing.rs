// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Crossing of the edge and a line of the grid in a step, in closed form.
//!
//! With s the share of the step, counted from its middle, x, z and θ are cubics, and the line is met at xₑ* = H cot a with a = a₀ − θ(s). The
//! height of the insert's circle there, u = x − xₑ*, is a power series in s, which is reversed to s(u). A column z is crossed where
//!
//! ```text
//! (z − z(s))² + u² = R²
//! ```
//! With z linear in u this is a quadratic; the little that z(s) bends is added to first order. So a cell costs two roots. Bounds of what the
//! series leave out decide, line by line, whether they hold; where they do not, the crossing is searched for.

use super::bounds::CHUNK;
use super::{Insert, InsertMove};
use crate::math::lanes::square_roots;

/// Largest terms of second, third and fourth order at the ends of the step, as shares of the first: with them, the terms of the reversed
/// series fall by a factor of six from the fifth on.
const MAX_BEND: [f64; 3] = [0.02, 2e-3, 2e-4];

/// Maximum of what the closed form leaves out, as a change of the edge's position (mm).
const MAX_ERROR_MM: f64 = 5e-7;

/// Maximum error of the share: half of [`SLACK`].
const MAX_SHARE_ERROR: f64 = 0.5 * SLACK;

/// Maximum of the shift of a crossing by the bend of z, as a share of the step.
const MAX_SHIFT: f64 = 1e-4;

/// Largest angle of a step over the sine of the line's angle: up to it, a power of the cotangent is a tenth of the power before.
const MAX_ANGLE: f64 = 0.1;

/// Smallest height of the circle as a share of its radius: beyond, the rim is near.
const MIN_HEIGHT: f64 = 0.05;

/// Largest slope of the path of z over the height, times the radius over the height: the circle then crosses a column once.
const MAX_TILT: f64 = 0.25;

/// Largest movement of x over that of the height: below, the edge rises along the line from the insert's centre on.
const MAX_LEAN: f64 = 0.8;

/// Shares of the step beyond its ends that count as in it: between two steps no crossing may be lost. A cell that is crossed in both is left
/// with the same radius twice.
const SLACK: f64 = 1e-3;

/// Largest share from the middle, and its powers.
const END: [f64; 4] = {
    let end = 0.5 + SLACK;
    [end, end * end, end * end * end, end * end * end * end]
};

/// A cubic of the share, counted from the middle of the step.
#[derive(Debug, Clone, Copy)]
struct Cubic([f64; 4]);

impl Cubic {
    /// From a way with its slopes at both ends.
    fn new(from: f64, way: f64, slope_from: f64, slope_to: f64) -> Self {
        let (second, third) = (3.0 * way - 2.0 * slope_from - slope_to, slope_from + slope_to - 2.0 * way);
        Self([
            from + 0.5 * slope_from + 0.25 * second + 0.125 * third,
            slope_from + second + 0.75 * third,
            second + 1.5 * third,
            third,
        ])
    }
}

/// A step of the insert as power series about its middle.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepSeries {
    /// θ from the beginning of the step on (rad).
    turned: Cubic,
    x: Cubic,
    z: Cubic,
    /// Coefficients of θ² in s³ and s⁴, of θ³ in s⁴; those of the lowest powers are powers of the first of θ.
    squares: (f64, f64),
    cube: f64,
    /// Largest angle from the middle (rad).
    angle_rad: f64,
    /// Maxima of what is left out of θ², θ³ and θ⁴, whose powers of s go on beyond the fourth, and the fifth power of the angle.
    left_out: [f64; 4],
    height_mm: f64,
    radius_mm: f64,
}

/// A line as it is seen at the middle of a step: the cotangent of its angle, and the square of its cosecant.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenLine {
    cot: f64,
    csc2: f64,
}

impl StepSeries {
    pub(super) fn new(insert: &Insert, motion: &InsertMove) -> Self {
        let from = motion.from();
        let [turned, x, z] = [0.0, from.x_mm, from.z_mm];
        let [turned, x, z] =
            motion.cubics([turned, x, z]).map(|[from, way, begin, end]| Cubic::new(from, way, begin, end));
        let [_, t1, t2, t3] = turned.0;
        let (first, second, third) = (END[0] * t1.abs(), END[1] * t2.abs(), END[2] * t3.abs());
        let angle_rad = first + second + third;
        let (first2, angle2) = (first * first, angle_rad * angle_rad);
        Self {
            turned,
            x,
            z,
            squares: (2.0 * t1 * t2, t2 * t2 + 2.0 * t1 * t3),
            cube: 3.0 * t1 * t1 * t2,
            angle_rad,
            left_out: [
                (2.0 * second + third) * third,
                angle2 * angle_rad - first2 * (first + 3.0 * second),
                angle2 * angle2 - first2 * first2,
                angle2 * angle2 * angle_rad,
            ],
            height_mm: insert.height_mm,
            radius_mm: insert.radius_mm,
        }
    }

    /// Angle turned at the middle of the step (rad).
    pub(super) fn middle_rad(&self) -> f64 {
        self.turned.0[0]
    }

    /// A line which is seen at the middle of the step at an angle of this cosine and sine; `None` where the edge does not come, or where it is
    /// seen too flat for a series.
    pub(super) fn seen(&self, (cos, sin): (f64, f64)) -> Option<SeenLine> {
        if sin * self.height_mm <= 0.0 {
            return None;
        }
        let cot = cos / sin;
        let csc2 = 1.0 + cot * cot;
        (csc2 * (self.angle_rad * self.angle_rad) <= MAX_ANGLE * MAX_ANGLE).then_some(SeenLine { cot, csc2 })
    }

    /// Returns whether the edge meets the line beyond a radius in the whole step, given its square and the square of the insert's height.
    pub(super) fn passes_beyond(&self, line: &SeenLine, radius2: f64, height2: f64) -> bool {
        // The powers of the angle beyond the first add a ninth.
        let nearest = self.height_mm * line.cot - 1.12 * (self.height_mm * line.csc2).abs() * self.angle_rad;
        nearest > 0.0 && nearest * nearest + height2 >= radius2
    }

    /// The crossing of a line; `None` where the series do not hold.
    pub(super) fn crossing(&self, line: &SeenLine) -> Option<LineCrossing> {
        let (h, r) = (self.height_mm, self.radius_mm);
        let ([_, t1, t2, t3], [x0, x1, x2, x3], [z0, z1, z2, z3]) = (self.turned.0, self.x.0, self.z.0);
        // cot(a − θ) = c + q θ + c q θ² + q (1/3 + c²) θ³ + c q (2/3 + c²) θ⁴ …, where the factor of θⁿ is at most the (n + 1)th power of √q.
        let SeenLine { cot: c, csc2: q } = *line;
        let c2 = c * c;
        let (second, third) = (c * q, q * (1.0 / 3.0 + c2));
        let fourth = second * (2.0 / 3.0 + c2);
        let t12 = t1 * t1;
        let u0 = x0 - h * c;
        let u1 = x1 - h * (q * t1);
        let u2 = x2 - h * (q * t2 + second * t12);
        let u3 = x3 - h * (q * t3 + second * self.squares.0 + third * t12 * t1);
        let u4 = -h * (second * self.squares.1 + third * self.cube + fourth * t12 * t12);
        let low = u0 - 0.55 * u1.abs();
        let per_u = 1.0 / u1;
        let (b2, b3, b4) = (u2 * per_u, u3 * per_u, u4 * per_u);
        let k = z1 * per_u;
        let bent = 1.0 - x1 * per_u;

        let bends = [END[0] * b2.abs(), END[1] * b3.abs(), END[2] * b4.abs()];
        if !(low >= MIN_HEIGHT * r && bends[0] <= MAX_BEND[0] && bends[1] <= MAX_BEND[1] && bends[2] <= MAX_BEND[2]) {
            return None;
        }
        let steepness = r / low;
        let tilt = k.abs() * steepness;
        let square = bends[0] * bends[0];
        let reversal =
            14.0 * square * square + 21.0 * square * bends[1] + 6.0 * bends[0] * bends[2] + 3.0 * bends[1] * bends[1];
        let height = self.left_out[0] * second.abs()
            + self.left_out[1] * third
            + self.left_out[2] * fourth.abs()
            + self.left_out[3] * 1.12 * q * q * q;
        let share_error = 0.7 * reversal + 1.1 * (h * height * per_u).abs();
        // Bend of z over the height, and the shift of the height by it.
        let bend_mm = z1.abs() * END[0] * (bends[0] + bends[1] + bends[2]) + END[1] * z2.abs() + END[2] * z3.abs();
        let shift_mm = 1.34 * steepness * bend_mm;
        let shift = shift_mm * per_u.abs();
        let varies = 0.55 * u1 / low;
        let first_order =
            varies * varies + 1.34 * tilt + 5.0 * shift + 2.0 * shift_mm / low + (0.55 * z1.abs() + bend_mm) / r;
        let curved_mm = x2.abs() + x3.abs();
        // Fifth and higher powers of the height in the squares and cubes of the share.
        let square_tail = 0.8 * (bends[2] + 8.0 * bends[0] * (square + bends[1]));
        let cube_tail = 1.7 * square + 0.6 * bends[1];
        let tail_mm = |second: f64, third: f64| second.abs() * square_tail + third.abs() * cube_tail;
        let error_mm = (x1.abs() + curved_mm) * share_error
            + tail_mm(x2, x3)
            + bent.abs() * (shift_mm * first_order + steepness * (z1.abs() * share_error + tail_mm(z2, z3)))
            + (curved_mm + x1.abs() * (2.5 * bends[0] + 4.0 * bends[1] + 5.0 * bends[2])) * shift;
        if !(error_mm <= MAX_ERROR_MM && share_error <= MAX_SHARE_ERROR && shift <= MAX_SHIFT && tilt <= MAX_TILT) {
            return None;
        }

        let share = 1.0 / (1.0 + k * k);
        let end = |s: f64| {
            let u = u0 + s * (u1 + s * (u2 + s * (u3 + s * u4)));
            (u, z0 + s * (z1 + s * (z2 + s * z3)))
        };
        let (begin, end) = (end(-END[0]), end(END[0]));
        let series = [-b2, 2.0 * b2 * b2 - b3, 5.0 * b2 * (b3 - b2 * b2) - b4];
        // A cubic of the share from its second order on, in powers of the height from u₀ on.
        let bend = |[_, first, second, third]: [f64; 4]| {
            let [s2, s3, s4] = series;
            let per_u2 = per_u * per_u;
            [
                (first * s2 + second) * per_u2,
                (first * s3 + 2.0 * second * s2 + third) * (per_u2 * per_u),
                (first * s4 + second * (s2 * s2 + 2.0 * s3) + 3.0 * third * s2) * (per_u2 * per_u2),
            ]
        };
        Some(LineCrossing {
            u0,
            edge: x0 - u0,
            bent,
            x: bend(self.x.0),
            z0,
            z: bend(self.z.0).map(|z| z * bent),
            share,
            tilt: k * share,
            beyond: k * u0,
            square: r * r * (1.0 + k * k),
            per_height: 1.0 / u0,
            rises: (x1.abs() + curved_mm) * per_u.abs() <= MAX_LEAN,
            ends: if begin.0 < end.0 { [begin, end] } else { [end, begin] },
        })
    }
}

/// The crossings of one line with the columns.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineCrossing {
    u0: f64,
    /// Position of the edge at the height u₀ (mm).
    edge: f64,
    /// Way of u − x per way of u.
    bent: f64,
    /// Factors of x in the second to fourth power of u − u₀, and of z times `bent`.
    x: [f64; 3],
    z0: f64,
    z: [f64; 3],
    /// 1/(1 + k²), k/(1 + k²), k u₀ and R² (1 + k²), with k = dz/du.
    share: f64,
    tilt: f64,
    beyond: f64,
    square: f64,
    per_height: f64,
    /// The radius rises from the insert's centre on, to either side.
    pub(super) rises: bool,
    /// Heights of the circle at the ends of the step, the lower first, and z of its centre there (mm).
    ends: [(f64, f64); 2],
}

impl LineCrossing {
    /// Places of the columns that are crossed in the step, on either side of the insert's centre (mm).
    pub(super) fn sides_mm(&self, radius_mm: f64) -> [(f64, f64); 2] {
        let square = radius_mm * radius_mm;
        let [(far, z_far), (near, z_near)] = self.ends.map(|(u, z)| (libm::sqrt((square - u * u).max(0.0)), z));
        [(z_far - far, z_near - near), (z_near + near, z_far + far)]
    }

    /// Radii at which the edge crosses the line at the columns of a chunk (mm), with this square of the insert's height. A function of its own
    /// is compiled to instructions for two columns.
    #[inline(never)]
    pub(super) fn radii_mm(&self, columns_mm: &[f64; CHUNK], height2: f64) -> [f64; CHUNK] {
        square_roots(self.edges_mm(*columns_mm).map(|edge| edge * edge + height2))
    }

    /// Positions of the edge where it crosses the line at columns (mm): stage by stage, so that no root waits for another.
    #[inline]
    pub(super) fn edges_mm<const N: usize>(&self, columns_mm: [f64; N]) -> [f64; N] {
        let beside = columns_mm.map(|column_mm| column_mm - self.z0);
        let e = beside.map(|beside| beside + self.beyond);
        let roots = square_roots(e.map(|e| (self.square - e * e).max(0.0)));
        let mut edges = [0.0; N];
        for i in 0..N {
            let v = self.tilt * e[i] + self.share * roots[i] - self.u0;
            let v2 = v * v;
            let x = v2 * (self.x[0] + v * (self.x[1] + v * self.x[2]));
            let z = v2 * (self.z[0] + v * (self.z[1] + v * self.z[2]));
            // 1/u by one step of Newton.
            let per_u = self.per_height * (1.0 - v * self.per_height);
            edges[i] = self.edge - v * self.bent + x - z * (beside[i] * per_u);
        }
        edges
    }
}
