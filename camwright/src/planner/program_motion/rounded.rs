// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A broken line averaged twice over a window, which is what a control that joins its blocks makes of it.
//!
//! Averaging over a width w, and once more, is averaging under a triangle that reaches w to either side. What it adds to a broken line is, for
//! each corner by which the slope steps by Δ, at the distance d of it,
//!
//! ```text
//! φ(d) = Δ·w/6·(1 − |d|/w)³,    φ″ = Δ/w·(1 − |d|/w),    |φ‴| = Δ/w²    within |d| < w, and nothing beyond
//! ```
//!
//! so the rounded line is made of cubics between the places ξ − w, ξ and ξ + w of its corners ξ, which splines carry exactly; it leaves a corner
//! alone by Δ·w/6, and where corners lie closer than w, as on a curve of second derivative X″, by X″·w²/12: X″·w²/24 for each averaging.

use crate::math::hermite::{HermiteError, HermiteSpline, Knot};
use alloc::vec::Vec;

/// Places nearer to each other than this share of the window are one: a quintic over less would be all rounding.
const NEAREST: f64 = 1e-3;

/// A place of a broken line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CornerPosition {
    /// Abscissa (rad or s).
    pub(super) at: f64,
    /// Value (mm or rad).
    pub(super) value: f64,
}

/// Corner: a step of the slope.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Corner {
    at: f64,
    step: f64,
}

/// Continuation of a line beyond its ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum EndExtension {
    /// It rests: so does what was averaged, a window before and behind the line.
    Rest,
    /// It goes on as its mirror image in the end point, so that it keeps its end points.
    Mirrored,
}

/// A broken line that is to be averaged.
#[derive(Debug, Clone)]
pub(super) struct BrokenLine {
    places: Vec<CornerPosition>,
    ends: EndExtension,
}

/// A broken line averaged twice over one window.
#[derive(Debug, Clone)]
pub(super) struct RoundedLine<'a> {
    line: &'a BrokenLine,
    window: f64,
    corners: Vec<Corner>,
}

impl BrokenLine {
    /// At least two places with abscissae that increase.
    pub(super) fn new(places: Vec<CornerPosition>, ends: EndExtension) -> Result<Self, HermiteError> {
        if places.len() < 2 {
            return Err(HermiteError::TooFewKnots { count: places.len() });
        }
        if let Some(index) = places.iter().position(|place| !(place.at.is_finite() && place.value.is_finite())) {
            return Err(HermiteError::NotFinite { index });
        }
        if let Some(index) = places.windows(2).position(|pair| pair[1].at <= pair[0].at) {
            let (at, previous) = (places[index + 1].at, places[index].at);
            return Err(HermiteError::NotIncreasing { index: index + 1, at, previous });
        }
        Ok(Self { places, ends })
    }

    pub(super) fn places(&self) -> &[CornerPosition] {
        &self.places
    }

    /// From its first place to its last.
    pub(super) fn length(&self) -> f64 {
        self.places[self.places.len() - 1].at - self.places[0].at
    }

    /// Averaged twice over a window; where its ends are mirrored, over its own length at most.
    pub(super) fn rounded(&self, window: f64) -> RoundedLine<'_> {
        let window = if self.ends == EndExtension::Mirrored { window.min(self.length()) } else { window };
        RoundedLine { line: self, window, corners: self.corners(window) }
    }

    fn slopes(&self) -> impl DoubleEndedIterator<Item = f64> + '_ {
        self.places.windows(2).map(|pair| (pair[1].value - pair[0].value) / (pair[1].at - pair[0].at))
    }

    /// Its corners, with those of its mirror images that the window reaches.
    fn corners(&self, window: f64) -> Vec<Corner> {
        let mut corners: Vec<Corner> = self
            .places
            .windows(3)
            .zip(self.slopes().zip(self.slopes().skip(1)))
            .map(|(places, (before, after))| Corner { at: places[1].at, step: after - before })
            .collect();
        let (first, last) = (self.places[0].at, self.places[self.places.len() - 1].at);
        let all = match self.ends {
            EndExtension::Rest => {
                let begins = Corner { at: first, step: self.slopes().next().unwrap_or(0.0) };
                let ends = Corner { at: last, step: -self.slopes().next_back().unwrap_or(0.0) };
                corners.insert(0, begins);
                corners.push(ends);
                corners
            }
            EndExtension::Mirrored => {
                let image = |end: f64| move |corner: &Corner| Corner { at: 2.0 * end - corner.at, step: -corner.step };
                let before = corners.iter().take_while(|corner| corner.at < first + window).map(image(first));
                let behind = corners.iter().rev().take_while(|corner| corner.at > last - window).map(image(last));
                let (mut all, behind): (Vec<Corner>, Vec<Corner>) = (before.collect(), behind.collect());
                all.reverse();
                all.extend(corners);
                all.extend(behind);
                all
            }
        };
        // Where the line goes straight on there is none.
        all.into_iter().filter(|corner| corner.step.abs() > 0.0).collect()
    }
}

impl RoundedLine<'_> {
    /// From where to where it is defined.
    pub(super) fn range(&self) -> (f64, f64) {
        let (first, last) = (self.line.places[0].at, self.line.places[self.line.places.len() - 1].at);
        match self.line.ends {
            EndExtension::Rest => (first - self.window, last + self.window),
            EndExtension::Mirrored => (first, last),
        }
    }

    /// Most corners that one average sees.
    pub(super) fn maximum_in_window(&self) -> usize {
        let mut from = 0;
        let mut max = 0;
        for (to, corner) in self.corners.iter().enumerate() {
            while self.corners[from].at < corner.at - 2.0 * self.window {
                from += 1;
            }
            max = max.max(to - from + 1);
        }
        max
    }

    /// Maximum distance from the broken line.
    ///
    /// Between two corners the sum of all |φ| is convex, so it is largest at one of them.
    pub(super) fn error(&self) -> f64 {
        let (first, last) = self.range();
        let at_corners = self.corners.iter().filter(|corner| (first..=last).contains(&corner.at));
        let mut from = 0;
        let mut max = 0.0_f64;
        for here in at_corners {
            while self.corners[from].at <= here.at - self.window {
                from += 1;
            }
            let seen = self.corners[from..].iter().take_while(|corner| corner.at < here.at + self.window);
            let sum: f64 =
                seen.map(|corner| (corner.step * self.window / 6.0 * cube(self.rest(here.at - corner.at))).abs()).sum();
            max = max.max(sum);
        }
        max
    }

    /// Its knots: exact values and derivatives at every place between which it is a cubic.
    pub(super) fn knots(&self) -> Vec<Knot> {
        let (first, last) = self.range();
        let inside = |at: &f64| *at > first && *at < last;
        let mut at: Vec<f64> = self
            .corners
            .iter()
            .flat_map(|corner| [corner.at - self.window, corner.at, corner.at + self.window])
            .filter(inside)
            .collect();
        at.sort_unstable_by(f64::total_cmp);
        let nearest = NEAREST * self.window.min(last - first);
        let mut kept = alloc::vec![first];
        for place in at {
            if place - kept[kept.len() - 1] > nearest && last - place > nearest {
                kept.push(place);
            }
        }
        kept.push(last);
        let (mut from, mut piece) = (0, 0);
        let mut knots: Vec<Knot> = kept.into_iter().map(|at| self.knot(at, &mut from, &mut piece)).collect();
        self.pin(&mut knots);
        knots
    }

    pub(super) fn spline(&self) -> Result<HermiteSpline, HermiteError> {
        HermiteSpline::new(self.knots())
    }

    /// The ends are where they must be to the last bit: positions are compared in counts there.
    fn pin(&self, knots: &mut [Knot]) {
        let places = &self.line.places;
        for (knot, place) in [(0, 0), (knots.len() - 1, places.len() - 1)] {
            let (knot, place) = (&mut knots[knot], places[place]);
            (knot.value, knot.second) = (place.value, 0.0);
            if self.line.ends == EndExtension::Rest {
                knot.first = 0.0;
            }
        }
    }

    /// Share of the window beyond a distance.
    fn rest(&self, distance: f64) -> f64 {
        (1.0 - distance.abs() / self.window).max(0.0)
    }

    /// Value and derivatives at a place behind the one before; `from` and `piece` are where to look on.
    fn knot(&self, at: f64, from: &mut usize, piece: &mut usize) -> Knot {
        let (places, w) = (&self.line.places, self.window);
        while *piece + 2 < places.len() && places[*piece + 1].at <= at {
            *piece += 1;
        }
        while *from < self.corners.len() && self.corners[*from].at <= at - w {
            *from += 1;
        }
        let (left, right) = (places[*piece], places[*piece + 1]);
        let beyond = at < places[0].at || at >= places[places.len() - 1].at;
        let slope = (right.value - left.value) / (right.at - left.at);
        let mut knot = match self.line.ends {
            EndExtension::Rest if beyond => {
                let value = if at < left.at { left.value } else { right.value };
                Knot { at, value, first: 0.0, second: 0.0 }
            }
            _ => Knot { at, value: left.value + slope * (at - left.at), first: slope, second: 0.0 },
        };
        for corner in self.corners[*from..].iter().take_while(|corner| corner.at < at + w) {
            let distance = at - corner.at;
            let rest = self.rest(distance);
            let side = if distance < 0.0 { -1.0 } else { 1.0 };
            knot.value += corner.step * w / 6.0 * cube(rest);
            knot.first -= side * 0.5 * corner.step * rest * rest;
            knot.second += corner.step / w * rest;
        }
        knot
    }
}

fn cube(x: f64) -> f64 {
    x * x * x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(values: &[(f64, f64)], ends: EndExtension) -> BrokenLine {
        BrokenLine::new(values.iter().map(|&(at, value)| CornerPosition { at, value }).collect(), ends)
            .expect("it increases")
    }

    /// The line itself, its mirror images included.
    fn value(line: &BrokenLine, at: f64) -> f64 {
        let (first, last) = (line.places[0], line.places[line.places.len() - 1]);
        match line.ends {
            EndExtension::Rest if at <= first.at => first.value,
            EndExtension::Rest if at >= last.at => last.value,
            EndExtension::Mirrored if at < first.at => 2.0 * first.value - value(line, 2.0 * first.at - at),
            EndExtension::Mirrored if at > last.at => 2.0 * last.value - value(line, 2.0 * last.at - at),
            _ => {
                let pair = line.places.windows(2).find(|pair| at <= pair[1].at).expect("it lies inside");
                pair[0].value + (pair[1].value - pair[0].value) * (at - pair[0].at) / (pair[1].at - pair[0].at)
            }
        }
    }

    /// Averaged over a width, and once more, by sums.
    fn averaged_twice(line: &BrokenLine, at: f64, window: f64) -> f64 {
        const PARTS: u32 = 400;
        let place = |part: u32| (f64::from(part) + 0.5) / f64::from(PARTS) - 0.5;
        let once =
            |at: f64| (0..PARTS).map(|part| value(line, at + window * place(part))).sum::<f64>() / f64::from(PARTS);
        (0..PARTS).map(|part| once(at + window * place(part))).sum::<f64>() / f64::from(PARTS)
    }

    #[test]
    fn it_is_the_average_of_the_average() {
        let places = [(0.0, 1.0), (0.3, 1.2), (0.35, 1.9), (1.1, 1.4), (1.2, 1.4), (2.0, 2.5)];
        for ends in [EndExtension::Rest, EndExtension::Mirrored] {
            let line = line(&places, ends);
            for window in [0.02, 0.2, 0.9] {
                let rounded = line.rounded(window);
                let (from, to) = rounded.range();
                let spline = rounded.spline().expect("a spline");
                for part in 0..=60_u32 {
                    let at = from + (to - from) * f64::from(part) / 60.0;
                    let (found, wanted) = (spline.sample(at).value, averaged_twice(&line, at, window));
                    assert!((found - wanted).abs() < 2e-5 * window, "{ends:?} {window} {at}: {found} {wanted}");
                }
                let (first, last) = (spline.sample(from), spline.sample(to));
                assert!((first.value - 1.0).abs() < 1e-15 && (last.value - 2.5).abs() < 1e-15);
                if ends == EndExtension::Rest {
                    assert!(first.first == 0.0 && last.first == 0.0);
                }
            }
        }
    }

    /// A corner of slope step Δ alone: Δ·w/6 off, curved by Δ/w there, and nothing beyond w.
    #[test]
    fn a_corner_is_cut_by_a_sixth_of_its_step_times_the_window() {
        let line = line(&[(0.0, 0.0), (5.0, 0.0), (10.0, 15.0)], EndExtension::Mirrored);
        let rounded = line.rounded(0.4);
        assert!((rounded.error() - 3.0 * 0.4 / 6.0).abs() < 1e-14);
        let spline = rounded.spline().expect("a spline");
        assert!((spline.sample(5.0).value - 0.2).abs() < 1e-14);
        assert!((spline.sample(5.0).second - 3.0 / 0.4).abs() < 1e-12);
        assert!((spline.sample(4.9).third.abs() - 3.0 / 0.16).abs() < 1e-6);
        assert!(spline.sample(4.59).value.abs() < 1e-14 && (spline.sample(5.41).value - 1.23).abs() < 1e-13);
    }

    /// Chords of a parabola of second derivative b, much shorter than the window: off by b·w²/12, b·w²/24 for each averaging.
    #[test]
    fn a_curve_in_short_chords_moves_by_a_twelfth_of_its_bend_times_the_window_squared() {
        let (bend, step, window) = (7.0, 0.01, 0.3);
        let chords: Vec<(f64, f64)> =
            (0..=400_u32).map(|i| f64::from(i) * step).map(|at| (at, 0.5 * bend * at * at)).collect();
        let line = line(&chords, EndExtension::Mirrored);
        let rounded = line.rounded(window);
        let at_corner = rounded.spline().expect("a spline").sample(2.0).value - 0.5 * bend * 4.0;
        let closed = bend * window * window / 12.0;
        // The chords themselves are b·h²/12 off in the mean.
        assert!((at_corner - closed).abs() < bend * step * step / 6.0, "{at_corner} {closed}");
        assert!((rounded.error() - closed).abs() < 0.01 * closed, "{} {closed}", rounded.error());
    }

    /// A speed from nothing to ω and back, averaged over ±T: acceleration ω/T, jerk ω/T², and 2T longer.
    #[test]
    fn a_speed_runs_up_from_rest_over_two_windows() {
        let line = line(&[(0.0, 0.0), (2.0, 6.0)], EndExtension::Rest);
        let spline = line.rounded(0.1).spline().expect("a spline");
        assert!((spline.start() + 0.1).abs() < 1e-15 && (spline.end() - 2.1).abs() < 1e-15);
        assert!((spline.sample(0.0).second - 3.0 / 0.1).abs() < 1e-10);
        assert!((spline.sample(-0.05).third - 3.0 / 0.01).abs() < 1e-6);
        assert!((spline.sample(0.1).first - 3.0).abs() < 1e-12 && (spline.sample(0.1).value - 0.3).abs() < 1e-14);
    }

    #[test]
    fn what_makes_no_line_is_refused() {
        let places = |values: &[f64]| values.iter().map(|&at| CornerPosition { at, value: at }).collect::<Vec<_>>();
        for values in [&[0.0][..], &[0.0, 0.0], &[0.0, 2.0, 1.0], &[0.0, f64::NAN]] {
            assert!(BrokenLine::new(places(values), EndExtension::Rest).is_err(), "{values:?}");
        }
    }
}
