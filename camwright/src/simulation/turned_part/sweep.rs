// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
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
//! Steps that are as smooth as a lathe's solve this in closed form ([`super::crossing`]); the search is for the others.
//!
//! Which columns may have passed a line is known from xₑ* = H cot a, the place where the edge meets it: at the height u = x − xₑ* of the
//! edge's circle, dz = √(R² − u²) from its centre on either side.

use super::bounds::CHUNK;
use super::crossing::{LineCrossing, StepSeries};
use super::{Insert, InsertMove, InsertPose, TurnedPart, TurnedRemoval, largest, smallest};
use crate::math::units::TURN_RAD;
use core::ops::Range;

/// Accuracy of a crossing point (mm along the arc).
const ARC_MM: f64 = 1.0e-7;

/// Distance from a line below which a point counts as on it at the start of a step (mm): rounding may have placed it on the other side at
/// the end of the previous step.
const ON_LINE_MM: f64 = 1.0e-9;

/// Steps of the search for where a point passes; two or three do, unless an axis turns round in the step.
const MAX_STEPS: u32 = 24;

/// Columns of a chunk.
const CHUNK_COLUMNS: [f64; CHUNK] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// A line of the grid at both ends of a step: cosine and sine of a.
#[derive(Debug, Clone, Copy)]
struct GridLine {
    index: usize,
    begin: (f64, f64),
    end: (f64, f64),
}

/// Side of the insert's centre, along the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Left,
    Right,
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
    /// As far in as the edge can be between two columns in the whole step (mm); infinite: nowhere.
    fn lowest_mm(&self, first_mm: f64, last_mm: f64) -> f64 {
        let beside = (self.z.0 - last_mm).max(first_mm - self.z.1).max(0.0);
        self.insert.edge_mm(self.x.0, beside).unwrap_or(f64::INFINITY)
    }

    /// Half the width over which the edge can be inside a cylinder, whose section ends at this x (mm).
    fn widest_mm(&self, outermost_mm: f64) -> f64 {
        let (radius, depth) = (self.insert.radius_mm, self.x.0 - outermost_mm);
        if depth > 0.0 { libm::sqrt((radius * radius - depth * depth).max(0.0)) } else { radius }
    }

    /// The columns that may pass a line, on either side of the insert's centre: distances from it, and all between. The line is seen at both
    /// ends of the range of C.
    fn beside_mm(&self, line: [(f64, f64); 2], widest: f64) -> (f64, f64) {
        let insert = self.insert;
        if insert.height_mm == 0.0 {
            return (0.0, widest);
        }
        let [one, other] = line.map(|seen| insert.meets(seen));
        // Below a nanometre rounding decides, and at the edge's nose a nanometre is a micrometre of width.
        let lowest = self.x.0 - one.max(other) - 1e-6;
        let highest = self.x.1 - one.min(other) + 1e-6;
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

/// Cut of chunks of a line.
struct ChunkCut {
    /// Smallest radius of the part (mm).
    min: f64,
    /// Volume over half the angle and the width of a cell (mm²).
    volume: f64,
    /// Deepest penetration (mm), and its column if a chunk of this line has it.
    depth: f64,
    deepest_mm: Option<f64>,
}

impl ChunkCut {
    /// Cuts the cells of a chunk down to radii; returns false if none is larger.
    fn cut(&mut self, cells: &mut [f64; CHUNK], left: &[f64; CHUNK], columns_mm: &[f64; CHUNK]) -> bool {
        let depths: [f64; CHUNK] = core::array::from_fn(|i| cells[i] - left[i]);
        let depth = largest(&depths);
        if depth <= 0.0 {
            return false;
        }
        for i in 0..CHUNK {
            self.volume += if depths[i] > 0.0 { (cells[i] + left[i]) * depths[i] } else { 0.0 };
            cells[i] = if left[i] < cells[i] { left[i] } else { cells[i] };
        }
        self.min = smallest(left, self.min);
        if depth > self.depth {
            self.depth = depth;
            self.deepest_mm = depths.iter().position(|other| *other >= depth).map(|i| columns_mm[i]);
        }
        true
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
        let [turned, x, z] = [0, 1, 2].map(|axis| motion.range(axis));
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
        let widest = sweep.widest_mm(outermost);
        let (one, other) = (libm::atan2(height, nearest), libm::atan2(height, outermost));
        let per_line = TURN_RAD / self.grid.azimuths as f64;
        let low = (turned.0 + one.min(other)) / per_line;
        let high = (turned.1 + one.max(other)) / per_line;
        let (begin, end) = (libm::sincos(from.turned_rad), libm::sincos(to.turned_rad));
        let series = StepSeries::new(insert, motion);
        let middle = libm::sincos(from.turned_rad + series.middle_rad());
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
            k += 1.0;
            if let Some(line) = series.seen(seen(middle)) {
                let bound = self.bounds.line_mm(index);
                if series.passes_beyond(&line, bound * bound, sweep.height2) {
                    continue;
                }
                if let Some(crossing) = series.crossing(&line) {
                    self.cut_crossed(&sweep, &crossing, index, &mut removal);
                    continue;
                }
            }
            let line = GridLine { index, begin: seen(begin), end: seen(end) };
            let ends = [turned.0, turned.1].map(|turned_rad| seen(libm::sincos(turned_rad)));
            let (narrowest, widest) = sweep.beside_mm(ends, widest);
            let left = self.columns(z.0 - widest, z.1 - narrowest);
            let right = self.columns(z.0 + narrowest, z.1 + widest);
            let right = (right.0.max(left.1), right.1);
            for (first, end) in [left, right] {
                for column in first..end {
                    self.cut_cell(&sweep, &line, column, &mut removal);
                }
            }
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
        let before = self.cells.cell(line.index, column);
        let square = sweep.height2;
        let column_mm = self.grid.from_mm + sweep.column_step * column as f64;
        let lowest = sweep.lowest_mm(column_mm, column_mm);
        if lowest > 0.0 && lowest * lowest + square >= before * before {
            return;
        }
        let Some(edge) = sweep.passes_at(line, column_mm) else { return };
        let left = libm::sqrt(edge * edge + sweep.height2);
        let depth = before - left;
        if depth <= 0.0 {
            return;
        }
        *self.cells.cell_mut(line.index, column) = left;
        self.bounds.chunks_mut(line.index)[column / CHUNK] = largest(self.cells.chunk(line.index, column / CHUNK));
        self.min = self.min.min(left);
        self.changed = true;
        removal.volume_mm3 += (before + left) * depth * sweep.half_sector;
        if depth > removal.depth_mm {
            removal.depth_mm = depth;
            removal.deepest = Some((self.grid.azimuth_rad(line.index), column_mm));
        }
    }

    /// Cuts the columns of a line that the edge crosses where the series hold.
    fn cut_crossed(
        &mut self,
        sweep: &InsertSweep<'_>,
        crossing: &LineCrossing,
        line: usize,
        removal: &mut TurnedRemoval,
    ) {
        let bound = self.bounds.line_mm(line);
        let outermost = libm::sqrt((bound * bound - sweep.height2).max(0.0));
        let widest = sweep.widest_mm(outermost);
        let volume = removal.volume_mm3;
        for (side, (from_mm, to_mm)) in
            [Side::Left, Side::Right].into_iter().zip(crossing.sides_mm(sweep.insert.radius_mm))
        {
            let columns = self.columns_between(from_mm.max(sweep.z.0 - widest), to_mm.min(sweep.z.1 + widest));
            self.cut_side(sweep, crossing, (line, side), columns, removal);
        }
        // Nothing is there to be cut: another look at it is spared.
        if removal.volume_mm3 <= volume {
            self.bounds.refresh_line(line);
        }
    }

    /// Cuts the columns of a line on one side of the insert's centre.
    fn cut_side(
        &mut self,
        sweep: &InsertSweep<'_>,
        crossing: &LineCrossing,
        (line, side): (usize, Side),
        columns: Range<usize>,
        removal: &mut TurnedRemoval,
    ) {
        if columns.is_empty() {
            return;
        }
        let from_mm = self.grid.from_mm;
        let column_mm = |column: usize| from_mm + sweep.column_step * column as f64;
        let mut cut = ChunkCut { min: self.min, volume: 0.0, depth: removal.depth_mm, deepest_mm: None };
        let chunks = columns.start / CHUNK..columns.end.div_ceil(CHUNK);
        let highest = &mut self.bounds.chunks_mut(line)[chunks.clone()];
        let mut is_cut = false;
        for (chunk, highest) in chunks.zip(highest) {
            let first = chunk * CHUNK;
            let (begin, end) = (columns.start.saturating_sub(first), (columns.end - first).min(CHUNK));
            // Beside a chunk that is cut, the next one most likely is.
            if crossing.rises && !is_cut {
                let nearest = if side == Side::Left { first + end - 1 } else { first + begin };
                let [edge] = crossing.edges_mm([column_mm(nearest)]);
                if edge > 0.0 && edge * edge + sweep.height2 >= *highest * *highest {
                    continue;
                }
            }
            let columns_mm = CHUNK_COLUMNS.map(|i| from_mm + sweep.column_step * (first as f64 + i));
            let mut left = crossing.radii_mm(&columns_mm, sweep.height2);
            if end - begin < CHUNK {
                left = core::array::from_fn(|i| if i >= begin && i < end { left[i] } else { f64::INFINITY });
            }
            let cells = self.cells.chunk_mut(line, chunk);
            is_cut = cut.cut(cells, &left, &columns_mm);
            if is_cut {
                *highest = largest(cells);
            }
        }
        self.changed |= cut.volume > 0.0;
        self.min = cut.min;
        removal.volume_mm3 += cut.volume * sweep.half_sector;
        if let Some(deepest_mm) = cut.deepest_mm {
            (removal.depth_mm, removal.deepest) = (cut.depth, Some((self.grid.azimuth_rad(line), deepest_mm)));
        }
    }

    /// Columns between two places.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the columns there are")]
    fn columns_between(&self, from_mm: f64, to_mm: f64) -> Range<usize> {
        let per_mm = 1.0 / self.grid.column_step_mm();
        let after = |place_mm: f64| {
            ((place_mm - self.grid.from_mm) * per_mm + 1.0).clamp(0.0, self.grid.columns as f64) as usize
        };
        after(from_mm)..after(to_mm)
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
            let (one, next) = (self.radius_mm(index, column), self.radius_mm((index + 1) % self.grid.azimuths, column));
            let depth = one + (next - one) * (lines - libm::floor(lines)) - radius;
            if depth > removal.depth_mm {
                (removal.depth_mm, removal.deepest) = (depth, Some((self.grid.azimuth_rad(index), column_mm)));
            }
        }
        removal
    }
}

#[cfg(test)]
mod tests {
    use super::super::PartGrid;
    use super::*;
    use alloc::string::String;
    use alloc::vec::Vec;

    /// A random number generator after Marsaglia.
    struct Random(u32);

    impl Random {
        fn between(&mut self, from: f64, to: f64) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 17;
            self.0 ^= self.0 << 5;
            from + (to - from) * f64::from(self.0) / f64::from(u32::MAX)
        }

        fn by_magnitude(&mut self, from: f64, to: f64) -> f64 {
            libm::exp(self.between(libm::log(from), libm::log(to)))
        }

        fn sign(&mut self) -> f64 {
            if self.between(-1.0, 1.0) < 0.0 { -1.0 } else { 1.0 }
        }
    }

    fn sweep<'a>(insert: &'a Insert, motion: &'a InsertMove) -> InsertSweep<'a> {
        InsertSweep {
            insert,
            motion,
            from: motion.from(),
            to: motion.at(1.0),
            x: motion.range(1),
            z: motion.range(2),
            height2: insert.height_mm * insert.height_mm,
            column_step: 0.0,
            half_sector: 0.0,
        }
    }

    /// Cosine and sine of a line's angle, seen from a machine that has turned.
    fn seen(azimuth_rad: f64, turned_rad: f64) -> (f64, f64) {
        let (sin, cos) = libm::sincos(azimuth_rad - turned_rad);
        (cos, sin)
    }

    /// Crossing of the edge and a line at a column, by halving the step with its ends a little beyond: its share, and the position of the edge.
    fn halved(insert: &Insert, motion: &InsertMove, azimuth_rad: f64, column_mm: f64) -> Option<(f64, f64)> {
        let at = |s: f64| {
            let pose = motion.at(s);
            let edge = insert.edge_mm(pose.x_mm, column_mm - pose.z_mm)?;
            Some((beyond(seen(azimuth_rad, pose.turned_rad), insert.height_mm, edge), edge))
        };
        let (mut left, mut right) = (-2e-3, 1.002);
        let (begin, end) = (at(left)?.0, at(right)?.0);
        if (begin < 0.0) == (end < 0.0) {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (left + right);
            *(if (at(middle)?.0 < 0.0) == (begin < 0.0) { &mut left } else { &mut right }) = middle;
        }
        Some((left, at(left)?.1))
    }

    /// A step of any lathe: edges from a tenth of a millimetre to a face mill's, slow and fast C, feeds up to the insert's radius per turn.
    fn any_step(random: &mut Random) -> (Insert, InsertMove) {
        let radius_mm = random.by_magnitude(0.1, 100.0);
        let edge_mm = random.by_magnitude(0.05, 100.0);
        let insert = Insert { radius_mm, height_mm: random.sign() * edge_mm * random.by_magnitude(0.01, 30.0) };
        let from = InsertPose {
            turned_rad: random.between(-9.0, 9.0),
            x_mm: edge_mm + radius_mm * random.between(0.02, 1.0),
            z_mm: random.between(-1.0, 1.0) * radius_mm,
        };
        let turn = random.sign() * random.by_magnitude(1e-6, 0.05);
        let way = [
            turn,
            edge_mm * turn * random.sign() * random.by_magnitude(1e-4, 3.0),
            radius_mm * turn * random.sign() * random.by_magnitude(1e-5, 0.5),
        ];
        let uneven = random.by_magnitude(1e-4, 0.3);
        let mut slope = || way.map(|way| way * (1.0 + uneven * random.between(-1.0, 1.0)));
        let (begin, end) = (slope(), slope());
        (insert, InsertMove::cubic(from, way, begin, end))
    }

    /// The series against halving, for random steps of any lathe: the radius within the bound, and no crossing lost.
    #[test]
    fn the_series_cross_where_the_edge_does() {
        let mut random = Random(0x9e37_79b9);
        let (mut crossed, mut held, mut refused) = (0, 0, 0);
        for _ in 0..20_000 {
            let (insert, motion) = any_step(&mut random);
            let from = motion.from();
            let height2 = insert.height_mm * insert.height_mm;
            let series = StepSeries::new(&insert, &motion);
            for _ in 0..4 {
                let edge = from.x_mm - insert.radius_mm * random.between(0.0, 1.0);
                let azimuth_rad = from.turned_rad + libm::atan2(insert.height_mm, edge);
                let middle = seen(azimuth_rad, from.turned_rad + series.middle_rad());
                let Some((line, crossing)) = series.seen(middle).and_then(|line| Some((line, series.crossing(&line)?)))
                else {
                    refused += 1;
                    continue;
                };
                held += 1;
                let beside = libm::sqrt(
                    (insert.radius_mm * insert.radius_mm - (from.x_mm - edge) * (from.x_mm - edge)).max(0.0),
                );
                let sides = crossing.sides_mm(insert.radius_mm);
                let wide = 1.2 * (sides[1].1 - sides[1].0) + 1e-3 * insert.radius_mm;
                for i in 0..16 {
                    let aside = beside + wide * random.between(-1.0, 1.0);
                    let side = usize::from(i % 2 == 0);
                    let column_mm = from.z_mm + if side == 1 { aside } else { -aside };
                    let Some((share, edge)) = halved(&insert, &motion, azimuth_rad, column_mm) else { continue };
                    let wanted = libm::sqrt(edge * edge + height2);
                    let [found] = crossing.edges_mm([column_mm]);
                    let found = libm::sqrt(found * found + height2);
                    let about = (&insert, &motion, column_mm, share);
                    assert!((found - wanted).abs() < 6e-7 + 1e-13 * wanted, "{about:?}: {found} {wanted}");
                    let radius = wanted - 1e-9;
                    assert!(
                        !series.passes_beyond(&line, wanted * wanted, height2)
                            || !(0.0..=1.0).contains(&share)
                            || radius > wanted,
                        "{about:?}"
                    );
                    if (0.0..=1.0).contains(&share) {
                        let is_there = sides.iter().any(|(from, to)| (*from..=*to).contains(&column_mm));
                        assert!(is_there, "{about:?} {sides:?}");
                        crossed += 1;
                    }
                }
            }
        }
        assert!(crossed > 50_000 && held > 10_000 && refused < 70_000, "{crossed} {held} {refused}");
    }

    /// Every line and every column by the search alone.
    fn search_everywhere(radii: &mut [f64], grid: &PartGrid, insert: &Insert, motion: &InsertMove) {
        let sweep = sweep(insert, motion);
        for index in 0..grid.azimuths {
            let azimuth_rad = grid.azimuth_rad(index);
            let (begin, end) = (seen(azimuth_rad, sweep.from.turned_rad), seen(azimuth_rad, sweep.to.turned_rad));
            // The other half of a line that runs through the axis.
            let nearest_mm = sweep.x.0 - insert.radius_mm;
            if begin.0 * nearest_mm + begin.1 * insert.height_mm < 0.0 {
                continue;
            }
            let line = GridLine { index, begin, end };
            for column in 0..grid.columns {
                if let Some(edge) = sweep.passes_at(&line, grid.z_mm(column)) {
                    let cell = &mut radii[column * grid.azimuths + index];
                    *cell = cell.min(libm::sqrt(edge * edge + sweep.height2));
                }
            }
        }
    }

    /// A path of any lathe over a part of any grid: the part is what the search alone leaves, or what it leaves with every step a little longer.
    #[test]
    fn a_part_is_what_the_search_alone_leaves() {
        let mut random = Random(0x2545_f491);
        let mut cut = 0;
        for round in 0..60 {
            let radius_mm = random.by_magnitude(0.2, 60.0);
            let part_mm = random.by_magnitude(1.0, 60.0);
            let share = [0.0, 0.01, 0.3, 0.7, 0.9][round % 5];
            let insert = Insert { radius_mm, height_mm: random.sign() * share * part_mm };
            let depth_mm = radius_mm.min(0.5 * part_mm) * random.by_magnitude(0.003, 0.9);
            let section_mm = libm::sqrt(part_mm * part_mm - insert.height_mm * insert.height_mm);
            let depth_mm = depth_mm.min(0.45 * section_mm);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small and positive")]
            let (azimuths, columns) = (random.between(16.0, 200.0) as usize, random.between(2.0, 70.0) as usize);
            let length_mm = radius_mm * random.by_magnitude(0.1, 3.0);
            let grid = PartGrid { azimuths, columns, from_mm: -0.5 * length_mm, to_mm: 0.5 * length_mm };
            let mut part = TurnedPart::round(String::from("P"), grid, part_mm).expect("a bar");
            let (mut searched, mut longer) = (part.radii_mm().collect::<Vec<_>>(), part.radii_mm().collect::<Vec<_>>());
            let step_rad = random.by_magnitude(0.003, 0.1);
            let feed = length_mm * random.by_magnitude(0.01, 0.3) / TURN_RAD;
            let (lobes, swing) = (libm::floor(random.between(1.0, 9.0)), depth_mm * random.between(0.0, 0.8));
            let sense = random.sign();
            let path = |turned: f64| {
                let (sin, cos) = libm::sincos(lobes * turned);
                let x_mm = section_mm + radius_mm - depth_mm + swing * cos;
                (
                    [turned, x_mm, -0.4 * length_mm + feed * turned.abs()],
                    [1.0, -lobes * swing * sin, feed * turned.signum()],
                )
            };
            for k in 0..200_u32 {
                let ([a, b], h) = ([k, k + 1].map(|k| path(sense * step_rad * f64::from(k))), sense * step_rad);
                let from = InsertPose { turned_rad: a.0[0], x_mm: a.0[1], z_mm: a.0[2] };
                let way = core::array::from_fn(|i| b.0[i] - a.0[i]);
                let motion = InsertMove::cubic(from, way, a.1.map(|slope| slope * h), b.1.map(|slope| slope * h));
                part.sweep(&insert, &motion, true);
                part.refresh();
                search_everywhere(&mut searched, &grid, &insert, &motion);
                search_everywhere(&mut longer, &grid, &insert, &motion.between(-2e-3, 1.002));
            }
            for (i, radius) in part.radii_mm().enumerate() {
                let (most, least) = (searched[i], searched[i].min(longer[i]));
                let about = (round, insert, grid, step_rad, i);
                assert!(radius < most + 2e-6 && radius > least - 2e-6, "{about:?}: {radius} {most} {least}");
                cut += u32::from(radius < part_mm);
            }
        }
        assert!(cut > 40_000, "{cut}");
    }
}
