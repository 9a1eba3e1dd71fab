//! Material removed by the insert's edge during a step.
//!
//! The edge's point at a column is at P = (xₑ, H) in the machine's frame. A line of the grid at azimuth φᵢ seen from there has the
//! direction a = φᵢ − θ, and
//!
//! ```text
//! g = cos a · H − sin a · xₑ = |P| sin(ψ − a)
//! ```
//! is the distance by which the point lies beyond it: where g has another sign at the end of the step than at its beginning, the point has
//! passed. Where on the way it did is found with the cubics of the step themselves, until |g| is below [`ARC_MM`]; so the radius left
//! differs from that of the cubics by less than `ARC_MM` times the slope of the section, dr/(r dφ): 1e-4 µm on a slope of 45°. A point that
//! passes a line and comes back within one step is not seen: with the angular acceleration α it went beyond by at most r α h²/8, at
//! 300 rad/s², 30 mm and h = 0.25 ms by 0.07 µm along the arc.
//!
//! Which columns may have passed a line is known from xₑ* = H cot a, the place where the edge meets it: at the height u = x − xₑ* of the
//! edge's circle, dz = √(R² − u²) from its centre on either side.

use super::{Insert, InsertMove, InsertPose, TurnedPart, TurnedRemoval};
use crate::math::units::TURN_RAD;

/// Accuracy of a crossing point (mm along the arc).
const ARC_MM: f64 = 1.0e-7;

/// Distance from a line below which a point counts as on it at the start of a step (mm): rounding may have placed it on the other side at
/// the end of the previous step.
const ON_LINE_MM: f64 = 1.0e-9;

/// Steps of the search for where a point passes; two or three do, unless an axis turns round in the step.
const MAX_STEPS: u32 = 24;

/// A line of the grid at both ends of a step: cosine and sine of a.
#[derive(Clone, Copy)]
struct GridLine {
    index: usize,
    begin: (f64, f64),
    end: (f64, f64),
}

/// A step of the insert.
struct InsertSweep<'a> {
    insert: &'a Insert,
    motion: &'a InsertMove,
    from: InsertPose,
    to: InsertPose,
    x: (f64, f64),
    z: (f64, f64),
    /// Square of the insert's height, distance of the columns, volume of a cell over the square of its radius.
    height2: f64,
    column_step: f64,
    half_sector: f64,
}

/// Distance by which a point at xₑ lies beyond a line.
fn beyond((cos, sin): (f64, f64), height: f64, edge: f64) -> f64 {
    cos * height - sin * edge
}

/// Sine and cosine of an angle that C turns in a servo step: below 0.02 rad the next terms of the series are below rounding, and
/// thousands of cells need them in every tick.
fn turn_of_a_step(angle: f64) -> (f64, f64) {
    if angle.abs() > 0.02 {
        return libm::sincos(angle);
    }
    let square = angle * angle;
    let sin = angle * (1.0 - square / 6.0 * (1.0 - square / 20.0));
    let cos = 1.0 - 0.5 * square * (1.0 - square / 12.0 * (1.0 - square / 30.0));
    (sin, cos)
}

impl Insert {
    /// x of the edge at a column `dz` beside its centre (mm); none beside the insert.
    fn edge_mm(&self, x_mm: f64, dz: f64) -> Option<f64> {
        let under = self.radius_mm * self.radius_mm - dz * dz;
        (under >= 0.0).then(|| x_mm - libm::sqrt(under))
    }

    /// Place on the line at which the edge meets it, between minus and plus infinity.
    fn meets(&self, (cos, sin): (f64, f64)) -> f64 {
        if sin * self.height_mm > 0.0 { self.height_mm * cos / sin } else { f64::INFINITY }
    }
}

impl InsertSweep<'_> {
    /// The columns that may pass a line, on either side of the insert's centre: distances from it, and all between.
    fn beside_mm(&self, line: &GridLine, widest: f64) -> (f64, f64) {
        let insert = self.insert;
        if insert.height_mm == 0.0 {
            return (0.0, widest);
        }
        let (one, other) = (insert.meets(line.begin), insert.meets(line.end));
        // Below a nanometre rounding decides, and at the edge's nose a nanometre is a micrometre of width.
        let lowest = self.from.x_mm.min(self.to.x_mm) - one.max(other) - 1e-6;
        let highest = self.from.x_mm.max(self.to.x_mm) - one.min(other) + 1e-6;
        let square = insert.radius_mm * insert.radius_mm;
        let dz = |u: f64| libm::sqrt((square - u * u).max(0.0));
        let widest = if lowest > 0.0 { dz(lowest).min(widest) } else { widest };
        let narrowest = if highest > 0.0 { dz(highest) } else { widest };
        (narrowest, widest)
    }

    /// Share of the step at which a point of a column crosses a line: xₑ there. `None` if it does not cross.
    fn passes_at(&self, line: &GridLine, column_mm: f64) -> Option<f64> {
        let (insert, height) = (self.insert, self.insert.height_mm);
        let edge0 = insert.edge_mm(self.from.x_mm, column_mm - self.from.z_mm);
        let edge1 = insert.edge_mm(self.to.x_mm, column_mm - self.to.z_mm);
        let (Some(edge0), Some(edge1)) = (edge0, edge1) else {
            return self.rim_passes(line, edge0, edge1);
        };
        let (g0, g1) = (beyond(line.begin, height, edge0), beyond(line.end, height, edge1));
        if g0.abs() <= ON_LINE_MM {
            return Some(edge0);
        }
        if (g0 < 0.0) == (g1 < 0.0) {
            return None;
        }
        // Regula falsi; the end that stays twice counts half (the Illinois way).
        let (mut left, mut right) = ((0.0, g0), (1.0, g1));
        let (mut edge, mut went_left) = (edge1, None);
        for _ in 0..MAX_STEPS {
            let s = left.0 - left.1 * (right.0 - left.0) / (right.1 - left.1);
            let [turned, x, z] = self.motion.gone(s);
            edge = insert.edge_mm(self.from.x_mm + x, column_mm - self.from.z_mm - z)?;
            let (sin, cos) = turn_of_a_step(turned);
            let (cos_a, sin_a) = (line.begin.0 * cos + line.begin.1 * sin, line.begin.1 * cos - line.begin.0 * sin);
            let g = beyond((cos_a, sin_a), height, edge);
            if g.abs() <= ARC_MM {
                break;
            }
            let goes_left = (g < 0.0) == (left.1 < 0.0);
            let other = if goes_left { &mut right } else { &mut left };
            if went_left == Some(goes_left) {
                other.1 *= 0.5;
            }
            *(if goes_left { &mut left } else { &mut right }) = (s, g);
            went_left = Some(goes_left);
        }
        Some(edge)
    }

    /// A column that the insert reaches with its rim only at one end of the step: there the edge is at the height of the centre.
    fn rim_passes(&self, line: &GridLine, edge0: Option<f64>, edge1: Option<f64>) -> Option<f64> {
        let (x0, x1, height) = (self.from.x_mm, self.to.x_mm, self.insert.height_mm);
        if edge0.is_none() && edge1.is_none() {
            return None;
        }
        let g0 = beyond(line.begin, height, edge0.unwrap_or(x0));
        let g1 = beyond(line.end, height, edge1.unwrap_or(x1));
        ((g0 < 0.0) != (g1 < 0.0)).then(|| edge0.unwrap_or(x0).max(edge1.unwrap_or(x1)))
    }
}

impl TurnedPart {
    /// The insert goes a step, less than half a turn: takes away what its edge sweeps. With `cuts` false it only looks how deep the edge
    /// stands in the part at the end.
    ///
    /// A part that stands still is cut only at azimuths that the edge passes: not at all with H = 0. An edge that reaches the part's axis
    /// (x ≤ R) cuts nothing and has the whole part as depth.
    pub fn sweep(&mut self, insert: &Insert, motion: &InsertMove, cuts: bool) -> TurnedRemoval {
        let none = TurnedRemoval::default();
        let height = insert.height_mm;
        let under = self.reach * self.reach - height * height;
        if motion.is_still() || under <= 0.0 {
            return none;
        }
        let (x, z) = (motion.range(1), motion.range(2));
        let outermost = libm::sqrt(under);
        let (first_mm, last_mm) = (self.grid.from_mm, self.grid.to_mm);
        let beside = z.0 - insert.radius_mm > last_mm || z.1 + insert.radius_mm < first_mm;
        let nearest = x.0 - insert.radius_mm;
        if nearest >= outermost || beside {
            return none;
        }
        if nearest <= 0.0 {
            return TurnedRemoval { depth_mm: self.reach, is_over_axis: true, ..none };
        }
        let (from, to) = (motion.from(), motion.at(1.0));
        if !cuts {
            return self.depth_at(insert, to);
        }
        let (column_step, half_sector) = (self.grid.column_step_mm(), self.half_sector());
        let sweep = InsertSweep { insert, motion, from, to, x, z, height2: height * height, column_step, half_sector };
        // Half the width over which the edge is inside the largest radius.
        let depth = x.0 - outermost;
        let widest = if depth > 0.0 {
            libm::sqrt((insert.radius_mm * insert.radius_mm - depth * depth).max(0.0))
        } else {
            insert.radius_mm
        };
        let (one, other) = (libm::atan2(height, nearest), libm::atan2(height, outermost));
        let per_line = TURN_RAD / self.grid.azimuths as f64;
        let low = (from.turned_rad.min(to.turned_rad) + one.min(other)) / per_line;
        let high = (from.turned_rad.max(to.turned_rad) + one.max(other)) / per_line;
        let (begin, end) = (libm::sincos(from.turned_rad), libm::sincos(to.turned_rad));
        let lowest = libm::ceil(low - 1e-6);
        let max = self.grid.azimuths as f64 - 1.0;
        let count = (libm::floor(high + 1e-6) - lowest).min(max);
        let mut removal = none;
        let mut k = 0.0;
        while k <= count {
            let index = self.line_index(lowest + k);
            let (cos, sin) = (self.cos[index], self.sin[index]);
            let seen = |(sin_turned, cos_turned): (f64, f64)| {
                (cos * cos_turned + sin * sin_turned, sin * cos_turned - cos * sin_turned)
            };
            let line = GridLine { index, begin: seen(begin), end: seen(end) };
            let (narrowest, widest) = sweep.beside_mm(&line, widest);
            let left = self.columns(from.z_mm.min(to.z_mm) - widest, from.z_mm.max(to.z_mm) - narrowest);
            let right = self.columns(from.z_mm.min(to.z_mm) + narrowest, from.z_mm.max(to.z_mm) + widest);
            let right = (right.0.max(left.1), right.1);
            for (first, end) in [left, right] {
                for column in first..end {
                    self.cut_cell(&sweep, &line, column, &mut removal);
                }
            }
            k += 1.0;
        }
        removal
    }

    /// Index of a line counted over any number of turns.
    #[allow(clippy::cast_possible_truncation, reason = "a whole number below the count")]
    fn line_index(&self, line: f64) -> usize {
        let n = self.grid.azimuths as f64;
        let index = line - n * libm::floor(line / n);
        (index as usize).min(self.grid.azimuths - 1)
    }

    /// Columns between two places, the last not included.
    #[allow(clippy::cast_possible_truncation, reason = "clamped to the columns there are")]
    fn columns(&self, from_mm: f64, to_mm: f64) -> (usize, usize) {
        let step = self.grid.column_step_mm();
        let max = self.grid.columns as f64;
        let first = libm::ceil((from_mm - self.grid.from_mm) / step - 1e-6).clamp(0.0, max);
        let end = (libm::floor((to_mm - self.grid.from_mm) / step + 1e-6) + 1.0).clamp(first, max);
        (first as usize, end as usize)
    }

    fn cut_cell(&mut self, sweep: &InsertSweep<'_>, line: &GridLine, column: usize, removal: &mut TurnedRemoval) {
        let at = column * self.grid.azimuths + line.index;
        let before = self.radii[at];
        let (insert, square) = (sweep.insert, sweep.height2);
        let column_mm = self.grid.from_mm + sweep.column_step * column as f64;
        // As far in as the edge can be at this column in the whole step.
        let beside = (sweep.z.0 - column_mm).max(column_mm - sweep.z.1).max(0.0);
        let Some(lowest) = insert.edge_mm(sweep.x.0, beside) else { return };
        if lowest > 0.0 && lowest * lowest + square >= before * before {
            return;
        }
        let Some(edge) = sweep.passes_at(line, column_mm) else { return };
        let left = libm::sqrt(edge * edge + square);
        let depth = before - left;
        if depth <= 0.0 {
            return;
        }
        self.radii[at] = left;
        self.min = self.min.min(left);
        self.changed = true;
        removal.volume_mm3 += (before + left) * depth * sweep.half_sector;
        if depth > removal.depth_mm {
            removal.depth_mm = depth;
            removal.deepest = Some((self.grid.azimuth_rad(line.index), column_mm));
        }
    }

    /// Depth of the insert's edge in the part at this pose; between two azimuths the radius is linear.
    fn depth_at(&self, insert: &Insert, pose: InsertPose) -> TurnedRemoval {
        let (first, end) = self.columns(pose.z_mm - insert.radius_mm, pose.z_mm + insert.radius_mm);
        let mut removal = TurnedRemoval::default();
        let (n, height) = (self.grid.azimuths as f64, insert.height_mm);
        for column in first..end {
            let column_mm = self.grid.z_mm(column);
            let Some(edge) = insert.edge_mm(pose.x_mm, column_mm - pose.z_mm) else { continue };
            let radius = libm::sqrt(edge * edge + height * height);
            if radius >= self.reach {
                continue;
            }
            let azimuth_rad = pose.turned_rad + libm::atan2(height, edge);
            let lines = azimuth_rad / TURN_RAD * n;
            let index = self.line_index(libm::floor(lines));
            let radii = self.column_mm(column);
            let (one, next) = (radii[index], radii[(index + 1) % radii.len()]);
            let depth = one + (next - one) * (lines - libm::floor(lines)) - radius;
            if depth > removal.depth_mm {
                (removal.depth_mm, removal.deepest) = (depth, Some((self.grid.azimuth_rad(index), column_mm)));
            }
        }
        removal
    }
}
