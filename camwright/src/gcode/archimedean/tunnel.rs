// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The fewest straight pieces through a tunnel around a curve, whose ends lie on it.
//!
//! A line y = t + s(x − x₀) is a point (s, t), and to pass a gate at x between two heights is to lie between two parallel lines of that
//! plane, so the lines that pass a row of gates are a convex polygon, which every gate clips. Where a gate leaves nothing of it, the line
//! that comes nearest to that gate reaches farthest; it leaves the tunnel by one wall just before. Whatever lies on the other side of that
//! line cannot be seen from the pieces so far, and is entered only across the line, between its beginning and its end: that is again a
//! pair of half planes for the next piece (with the gates in between bounding it on the far side alone). Taking the farthest line every
//! time gives the fewest pieces (S. Suri, A linear time algorithm for minimum link paths inside a simple polygon, 1986).

use alloc::vec::Vec;

/// Knots: angles, and positions at them.
pub(super) type TunnelKnots = (Vec<f64>, Vec<f64>);

/// Halvings in search of the narrowest tunnel that takes no more pieces.
const HALVINGS: u32 = 12;

/// The fewest pieces through a tunnel of a half width, in the narrowest tunnel that takes no more of them: so their errors are even.
/// `None` if the tunnel is so narrow that rounding leaves no line through it.
pub(super) fn fewest_evenly(angles: &[f64], values: &[f64], half_width: f64) -> Option<TunnelKnots> {
    let mut best = fewest(angles, values, half_width)?;
    let (mut too_narrow, mut wide_enough) = (0.0, half_width);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (too_narrow + wide_enough);
        match fewest(angles, values, middle) {
            Some(tried) if tried.0.len() <= best.0.len() => (best, wide_enough) = (tried, middle),
            _ => too_narrow = middle,
        }
    }
    Some(best)
}

/// A line through a place.
#[derive(Debug, Clone, Copy)]
struct TangentLine {
    at: f64,
    height: f64,
    slope: f64,
}

impl TangentLine {
    fn value(&self, angle: f64) -> f64 {
        self.height + self.slope * (angle - self.at)
    }

    /// Intersection with another line, clamped between two angles.
    fn meets(&self, other: &TangentLine, between: (f64, f64)) -> f64 {
        let apart = self.value(between.1) - other.value(between.1);
        let nearing = self.slope - other.slope;
        let angle = if nearing.abs() > 0.0 { between.1 - apart / nearing } else { between.1 };
        angle.clamp(between.0, between.1)
    }
}

/// The wall by which a line leaves the tunnel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TunnelWall {
    Lower,
    Upper,
}

/// Lines y = t + s(x − at) that pass every gate so far: corners (s, t) of a convex polygon.
struct PassingLines {
    at: f64,
    corners: Vec<(f64, f64)>,
}

impl PassingLines {
    /// Keeps those that are no higher (`sign` 1) or no lower (−1) than a height at an angle. False, and nothing changed, if none is left.
    fn clip(&mut self, angle: f64, height: f64, sign: f64, spare: &mut Vec<(f64, f64)>) -> bool {
        let way = angle - self.at;
        let over = |&(s, t): &(f64, f64)| sign * (t + s * way - height);
        spare.clear();
        for (index, corner) in self.corners.iter().enumerate() {
            let next = &self.corners[(index + 1) % self.corners.len()];
            let (here, there) = (over(corner), over(next));
            if here <= 0.0 {
                spare.push(*corner);
            }
            if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
                let share = here / (here - there);
                spare.push((corner.0 + share * (next.0 - corner.0), corner.1 + share * (next.1 - corner.1)));
            }
        }
        if spare.is_empty() {
            return false;
        }
        core::mem::swap(&mut self.corners, spare);
        true
    }

    /// The line that is highest (`sign` 1) or lowest (−1) at an angle.
    fn extreme(&self, angle: f64, sign: f64) -> TangentLine {
        let way = angle - self.at;
        let height = |&(s, t): &(f64, f64)| sign * (t + s * way);
        let best = self.corners.iter().copied().reduce(|a, b| if height(&b) > height(&a) { b } else { a });
        let (slope, height) = best.unwrap_or((0.0, 0.0));
        TangentLine { at: self.at, height, slope }
    }

    /// One in the middle of them; a level one, if there is one, so that an axis rests where it may.
    fn middle(&self) -> TangentLine {
        let next = |index: usize| self.corners[(index + 1) % self.corners.len()];
        let crossing = |(index, &(s, t)): (usize, &(f64, f64))| {
            let (next_s, next_t) = next(index);
            ((s <= 0.0 && next_s >= 0.0) || (s >= 0.0 && next_s <= 0.0)).then(|| {
                let share = if (next_s - s).abs() > 0.0 { -s / (next_s - s) } else { 0.0 };
                t + share * (next_t - t)
            })
        };
        let level = self.corners.iter().enumerate().filter_map(crossing);
        let (low, high) = level.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| (low.min(t), high.max(t)));
        if low <= high {
            return TangentLine { at: self.at, height: 0.5 * (low + high), slope: 0.0 };
        }
        let share = 1.0 / self.corners.len() as f64;
        let (slope, height) = self.corners.iter().fold((0.0, 0.0), |sum, c| (sum.0 + share * c.0, sum.1 + share * c.1));
        TangentLine { at: self.at, height, slope }
    }
}

struct Tunnel<'a> {
    angles: &'a [f64],
    values: &'a [f64],
    half_width: f64,
    steepest: f64,
}

/// A piece: its line, where that leaves the tunnel, by which wall, and the first gate behind that place.
struct TunnelPiece {
    line: TangentLine,
    leaves: f64,
    by: TunnelWall,
    next_gate: usize,
}

/// Event that ends the search for a piece.
enum SearchEnd {
    /// It reaches the end.
    Last(TangentLine),
    /// It leaves the tunnel.
    More(TunnelPiece),
}

impl Tunnel<'_> {
    /// Heights of a gate; the last is a point.
    fn gate(&self, index: usize) -> (f64, f64) {
        let half = if index + 1 == self.angles.len() { 0.0 } else { self.half_width };
        (self.values[index] - half, self.values[index] + half)
    }

    /// Passes gates from one on until none of the lines passes.
    fn pass(&self, mut lines: PassingLines, from: usize, spare: &mut Vec<(f64, f64)>) -> SearchEnd {
        for index in from..self.angles.len() {
            let (angle, (low, high)) = (self.angles[index], self.gate(index));
            let before = |lines: &PassingLines, sign: f64, by: TunnelWall| {
                let line = lines.extreme(angle, sign);
                SearchEnd::More(TunnelPiece { line, leaves: self.leaves(&line, index, by), by, next_gate: index })
            };
            if !lines.clip(angle, low, -1.0, spare) {
                return before(&lines, 1.0, TunnelWall::Lower);
            }
            if !lines.clip(angle, high, 1.0, spare) {
                return before(&lines, -1.0, TunnelWall::Upper);
            }
        }
        SearchEnd::Last(lines.middle())
    }

    /// Angle at which a line that passed the gate before an index leaves the tunnel through a wall.
    fn leaves(&self, line: &TangentLine, index: usize, by: TunnelWall) -> f64 {
        let (from, to) = (self.angles[index - 1], self.angles[index]);
        let wall = |index: usize| if by == TunnelWall::Lower { self.gate(index).0 } else { self.gate(index).1 };
        let (here, there) = (line.value(from) - wall(index - 1), line.value(to) - wall(index));
        if here * there < 0.0 { from + (to - from) * here / (here - there) } else { from }
    }

    /// Lines that cross that of a piece between its beginning and where it leaves the tunnel.
    fn across(&self, piece: &TunnelPiece, begins: f64, first_gate: usize, spare: &mut Vec<(f64, f64)>) -> PassingLines {
        // By the lower wall: steeper ones, below the piece where it begins and above it where it ends.
        let sign = if piece.by == TunnelWall::Lower { 1.0 } else { -1.0 };
        let (at, height) = (piece.leaves, piece.line.value(piece.leaves));
        let inner = sign * 2.0 * self.half_width;
        let (gentle, steep) = (piece.line.slope, piece.line.slope + sign * 2.0 * self.steepest);
        let corners = alloc::vec![(gentle, height), (steep, height), (steep, height + inner), (gentle, height + inner)];
        let mut lines = PassingLines { at, corners };
        // The corner of the piece itself always stays, so nothing empties it.
        lines.clip(begins, piece.line.value(begins), sign, spare);
        for index in first_gate..piece.next_gate {
            let (low, high) = self.gate(index);
            lines.clip(self.angles[index], if sign > 0.0 { high } else { low }, sign, spare);
        }
        lines
    }
}

/// The fewest pieces through a tunnel of a half width, from the first value to the last; `None` where rounding stops it.
fn fewest(angles: &[f64], values: &[f64], half_width: f64) -> Option<TunnelKnots> {
    let last = angles.len() - 1;
    let slope = |i: usize| (values[i + 1] - values[i]) / (angles[i + 1] - angles[i]);
    // No line of a tunnel is steeper than from wall to wall between two gates.
    let steepest =
        (0..last).map(|i| slope(i).abs() + 2.0 * half_width / (angles[i + 1] - angles[i])).fold(0.0, f64::max);
    let tunnel = Tunnel { angles, values, half_width, steepest };
    let mut spare = Vec::new();
    let mut knots = (alloc::vec![angles[0]], alloc::vec![values[0]]);
    let mut lines = PassingLines { at: angles[0], corners: alloc::vec![(-steepest, values[0]), (steepest, values[0])] };
    let mut first_gate = 1;
    let mut before: Option<(TangentLine, (f64, f64))> = None;
    loop {
        let found = tunnel.pass(lines, first_gate, &mut spare);
        let line = match &found {
            SearchEnd::Last(line) => *line,
            SearchEnd::More(piece) => piece.line,
        };
        // The knot is where it meets the piece before.
        let begins = before.map_or(angles[0], |(earlier, between)| earlier.meets(&line, between));
        if before.is_some() {
            if begins <= knots.0[knots.0.len() - 1] || begins >= angles[last] {
                return None;
            }
            knots.0.push(begins);
            knots.1.push(line.value(begins));
        }
        let SearchEnd::More(piece) = found else {
            knots.0.push(angles[last]);
            knots.1.push(values[last]);
            return Some(knots);
        };
        if piece.next_gate <= first_gate && before.is_some() {
            return None;
        }
        let behind = angles.partition_point(|angle| *angle <= begins);
        lines = tunnel.across(&piece, begins, behind, &mut spare);
        first_gate = piece.next_gate;
        before = Some((piece.line, (begins, piece.leaves)));
    }
}
