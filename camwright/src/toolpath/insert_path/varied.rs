// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A spindle whose speed varies along a path: fast in the air and where the part is nearly round, slow where a slide works hard, within a
//! turn as from turn to turn.
//!
//! ```text
//!  cap of every cell      what slides and spindle allow at constant speed                     ‾‾\_/‾‾|__|‾
//!  rises and falls        no faster than C accelerates                                         ‾\_/‾\__/‾
//!  least around, mean     nowhere above what it is made from, and C² over the angle            _____/\____
//!  bounds of every cell   how much too fast, with the terms of ω̇ and ω̈: the cap is lowered there, or raised where room is left
//! ```
//! It works in q = ω²: ω̇ is half its slope over the angle, and a spindle that accelerates all it can draws a straight line. Means of means
//! of means of the least around stay below what they are made from wherever the least is taken as far around as the means reach together.
//!
//! However good the cap is, slowing the whole law down by one factor keeps all limits: speeds fall by it, accelerations by its square, jerks
//! by its cube. So a law comes out that keeps them, or the constant one, if that is sooner at its end.

use super::cells::{Cells, SpindleMotion};
use super::spindle::{BoundShare, SpindleLaw, ramp_s};
use super::{AxisLimits, InsertPath, InsertPathError};
use crate::machine::description::MotionLimits;
use crate::math::hermite::{HermiteSpline, Knot};
use crate::math::windows::{mean_around, minimum_around};
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

/// Reach (in cells) of each of the three averages that are tried: a narrower one changes the speed sooner and harder. A wider one is
/// preferred if a narrower one gains less than a thousandth.
const REACHES: [usize; 4] = [12, 5, 3, 2];
const GAIN: f64 = 0.999;

/// Rounds in which the cap of every cell is fitted: with each reach, with the best of them, and when its ends are fixed. In so many of the
/// last ones it is only lowered.
const TRIAL_ROUNDS: u32 = 3;
const ROUNDS: u32 = 10;
const END_ROUNDS: u32 = 4;
const LOWERING: u32 = 5;

/// Most by which the cap rises in a round.
const RAISED: f64 = 1.1;

/// Share of C's acceleration with which the cap rises and falls.
const RISE_SHARE: f64 = 0.9;

/// The bounds are kept with a thousandth to spare.
const SPARE: f64 = 0.999;

/// Tries for the speed with which a path begins and ends, and by how much each is slower than the one before.
const MAX_TRIES: u32 = 300;
const SLOWER: f64 = 0.97;

impl InsertPath {
    /// The time law of C along this path whose speed varies as slides and spindle allow, within the limits of C (rad/s, rad/s², rad/s³);
    /// that of [`Self::spindle_law`] where it is not slower.
    ///
    /// # Errors
    /// As [`Self::spindle_law`].
    pub fn varied_spindle_law(&self, limits: &AxisLimits, c: MotionLimits) -> Result<SpindleLaw, InsertPathError> {
        let constant = self.spindle_law(c.velocity, limits, c)?;
        let cells = Cells::new(self);
        let limits = AxisLimits { spindle_rad_s: limits.spindle_rad_s.min(c.velocity), ..*limits };
        let varied = SpeedFit::new(&cells, &limits, &c).law(self.x().end() - self.x().start());
        Ok(match varied {
            Some(VariedLaw { law, range_rad_s, ramp_s, bounds }) if law.end() < constant.law.end() => {
                SpindleLaw { law, rad_s: range_rad_s.0, range_rad_s, ramp_s, bounds, fastest: constant.fastest }
            }
            _ => constant,
        })
    }
}

/// A path's cells and what is allowed there.
struct SpeedFit<'a> {
    cells: &'a Cells,
    limits: &'a AxisLimits,
    c: &'a MotionLimits,
    /// Largest q = ω² of every cell at constant speed, and how far q may rise or fall from one to the next.
    maximum: Vec<f64>,
    rise: f64,
}

/// Speeds at the ends of all cells as q = ω² and accelerations there, and what comes of them.
struct CapProfile {
    q: Vec<f64>,
    acceleration: Vec<f64>,
    /// Times too fast, per cell, and the largest of them.
    over: Vec<f64>,
    worst: f64,
    time_s: f64,
}

impl CapProfile {
    /// Time when it is slowed down until it keeps all limits (s).
    fn kept_s(&self) -> f64 {
        self.time_s * self.worst.max(SPARE) / SPARE
    }
}

/// A cap that was fitted, and its profile.
struct FittedCap {
    reach: usize,
    cap: Vec<f64>,
    profile: CapProfile,
}

/// Ramp of C at the start or the end of a path.
struct Ramp {
    rad_s: f64,
    ramp_s: f64,
    /// Cells that C passes meanwhile.
    cells: usize,
}

impl<'a> SpeedFit<'a> {
    fn new(cells: &'a Cells, limits: &'a AxisLimits, c: &'a MotionLimits) -> Self {
        let square = |cell| {
            let rad_s = SPARE * cells.fastest(cell, limits);
            rad_s * rad_s
        };
        let rise = 2.0 * RISE_SHARE * c.acceleration * cells.width_rad;
        Self { cells, limits, c, maximum: (0..cells.count()).map(square).collect(), rise }
    }

    /// The profile nowhere above the cap of any cell.
    fn profile(&self, cap: &[f64], reach: usize) -> Option<CapProfile> {
        let count = cap.len();
        let mut q: Vec<f64> =
            (0..=count).map(|node| cap[node.saturating_sub(1)].min(cap[node.min(count - 1)])).collect();
        for node in 0..count {
            q[node + 1] = q[node + 1].min(q[node] + self.rise);
        }
        for node in (0..count).rev() {
            q[node] = q[node].min(q[node + 1] + self.rise);
        }
        let minimum = minimum_around(&q, 3 * reach);
        let mean = (0..3).fold(minimum.clone(), |q, _| mean_around(&q, reach));
        // Where the speed is constant it is to the last bit.
        let q: Vec<f64> = mean
            .into_iter()
            .zip(minimum)
            .map(|(q, minimum)| if (q - minimum).abs() < 1e-9 * minimum { minimum } else { q })
            .collect();
        self.profile_with(q)
    }

    fn profile_with(&self, q: Vec<f64>) -> Option<CapProfile> {
        let (count, h) = (q.len() - 1, self.cells.width_rad);
        let slope = |node: usize| if node == 0 || node == count { 0.0 } else { 0.25 * (q[node + 1] - q[node - 1]) / h };
        let acceleration: Vec<f64> = (0..=count).map(slope).collect();
        let at = |node: usize| (libm::sqrt(q[node]), acceleration[node]);
        let mut over = Vec::with_capacity(count);
        let (mut time_s, mut worst) = (0.0, 0.0_f64);
        for cell in 0..count {
            let turning = SpindleMotion::new(h, at(cell), at(cell + 1))?;
            let (slower, _) = self.cells.slower(cell, &turning, self.limits, self.c);
            time_s += turning.time_s;
            worst = worst.max(slower);
            over.push(slower);
        }
        Some(CapProfile { q, acceleration, over, worst, time_s })
    }

    /// Fits the cap of some cells to a profile: down where it is too fast, up where room is left.
    fn fit(&self, cap: &mut [f64], free: Range<usize>, profile: &CapProfile, rises: bool) {
        for cell in free {
            let over = profile.over[cell] / SPARE;
            let here = 0.5 * (profile.q[cell] + profile.q[cell + 1]);
            if over > 1.0 {
                cap[cell] = cap[cell].min(here / (over * over));
            } else if rises {
                cap[cell] = (cap[cell] * f64::min(1.0 / over, RAISED)).min(self.maximum[cell]);
            }
        }
    }

    /// Rounds of fitting the cap of some cells.
    fn rounds(&self, cap: &[f64], free: &Range<usize>, reach: usize, rounds: u32) -> Option<FittedCap> {
        let mut cap = cap.to_vec();
        let mut best: Option<FittedCap> = None;
        for round in 0..rounds {
            let profile = self.profile(&cap, reach)?;
            let kept_s = profile.kept_s();
            let mut next = cap.clone();
            self.fit(&mut next, free.clone(), &profile, round + LOWERING < rounds);
            let is_done = next == cap;
            if best.as_ref().is_none_or(|best| kept_s < best.profile.kept_s()) {
                best = Some(FittedCap { reach, cap, profile });
            }
            if is_done {
                break;
            }
            cap = next;
        }
        best
    }

    fn law(&self, way_rad: f64) -> Option<VariedLaw> {
        let count = self.maximum.len();
        let mut best: Option<FittedCap> = None;
        for reach in REACHES {
            let tried = self.rounds(&self.maximum, &(0..count), reach, TRIAL_ROUNDS)?;
            if best.as_ref().is_none_or(|best| tried.profile.kept_s() < GAIN * best.profile.kept_s()) {
                best = Some(tried);
            }
        }
        let FittedCap { reach, cap, .. } = best?;
        let FittedCap { mut cap, profile, .. } = self.rounds(&cap, &(0..count), reach, ROUNDS)?;
        // A constant speed at both ends, on which C runs up and down, and as far beyond as least and means reach.
        let flat = 6 * reach + 2;
        let up = self.ramp(&profile, flat, |index| index)?;
        let down = self.ramp(&profile, flat, |index| count - 1 - index)?;
        let free = up.cells + flat..count.checked_sub(down.cells + flat)?;
        if free.is_empty() {
            return None;
        }
        cap[..free.start].fill(up.rad_s * up.rad_s);
        cap[free.end..].fill(down.rad_s * down.rad_s);
        let fitted = self.rounds(&cap, &free, reach, END_ROUNDS)?;
        self.built(&fitted.profile, &up, &down, way_rad)
    }

    /// The fastest ramp to a speed that the profile has all along it, and on for so many cells.
    fn ramp(&self, profile: &CapProfile, flat: usize, place: impl Fn(usize) -> usize) -> Option<Ramp> {
        let count = profile.over.len();
        let mut rad_s = libm::sqrt(profile.q[place(0)].min(profile.q[place(0) + 1]));
        let has = |rad_s: f64, cells: usize| {
            cells <= count
                && (0..cells).map(&place).all(|cell| rad_s * rad_s <= profile.q[cell].min(profile.q[cell + 1]))
        };
        for _ in 0..MAX_TRIES {
            if has(rad_s, 1)
                && let Some(ramp) = self.ramp_to(rad_s, count, &place)
                && has(rad_s, ramp.cells + flat)
            {
                return Some(ramp);
            }
            rad_s *= SLOWER;
        }
        None
    }

    /// The ramp to a speed, over as many cells as it takes.
    fn ramp_to(&self, rad_s: f64, count: usize, place: impl Fn(usize) -> usize) -> Option<Ramp> {
        let mut cells = 1;
        while cells <= count {
            let (first, last) = (place(0), place(cells - 1));
            let rates = self.cells.maximum(first.min(last)..first.max(last) + 1);
            let ramp_s = ramp_s(rad_s, &rates, self.limits, self.c)?;
            // One more: the last cell of a path is a part of one.
            #[allow(clippy::cast_possible_truncation, reason = "ramps are bounded")]
            let needed = libm::ceil(0.5 * rad_s * ramp_s / self.cells.width_rad) as usize + 1;
            if needed <= cells {
                return Some(Ramp { rad_s, ramp_s, cells });
            }
            cells = needed;
        }
        None
    }

    /// The law of a profile that is constant where it begins and where it ends.
    fn built(&self, profile: &CapProfile, up: &Ramp, down: &Ramp, way_rad: f64) -> Option<VariedLaw> {
        let slower = profile.worst.max(SPARE) / SPARE;
        let h = self.cells.width_rad;
        let count = profile.over.len();
        let up = self.ramp_to(up.rad_s / slower, count, |cell| cell)?;
        let down = self.ramp_to(down.rad_s / slower, count, |cell| count - 1 - cell)?;
        let (up_rad, down_rad) = (0.5 * up.rad_s * up.ramp_s, 0.5 * down.rad_s * down.ramp_s);
        let knot = |at: f64, value: f64, first: f64, second: f64| Knot { at, value, first, second };
        let mut knots = vec![knot(0.0, 0.0, 0.0, 0.0), knot(up.ramp_s, up_rad, up.rad_s, 0.0)];
        #[allow(clippy::cast_possible_truncation, reason = "nodes between the ends")]
        let (begin, end) = (libm::floor(up_rad / h) as usize + 1, libm::ceil((way_rad - down_rad) / h) as usize - 1);
        let at = |node: usize| (libm::sqrt(profile.q[node]) / slower, profile.acceleration[node] / (slower * slower));
        let steady = |node: usize| {
            let q = &profile.q[node - 1..=node + 1];
            q[0].to_bits() == q[1].to_bits() && q[1].to_bits() == q[2].to_bits()
        };
        let mut time_s = up.ramp_s + (begin as f64 * h - up_rad) / up.rad_s;
        let (mut minimum, mut maximum) = (up.rad_s.min(down.rad_s), up.rad_s.max(down.rad_s));
        let mut bounds: Vec<BoundShare> = Vec::new();
        for node in begin..=end {
            let (from, to) = (at(node), at(node + 1));
            if !steady(node) {
                knots.push(knot(time_s, node as f64 * h, from.0, from.1));
            }
            (minimum, maximum) = (minimum.min(from.0), maximum.max(from.0));
            if node == end {
                break;
            }
            let turning = SpindleMotion::new(h, from, to)?;
            time_s += turning.time_s;
            let (_, bound) = self.cells.slower(node, &turning, self.limits, self.c);
            match bounds.iter_mut().find(|share| share.bound == bound) {
                Some(share) => share.share += 1.0 / (end - begin) as f64,
                None => bounds.push(BoundShare { bound, share: 1.0 / (end - begin) as f64 }),
            }
        }
        bounds.sort_by(|a, b| b.share.total_cmp(&a.share));
        time_s += (way_rad - down_rad - end as f64 * h) / down.rad_s;
        knots.push(knot(time_s, way_rad - down_rad, down.rad_s, 0.0));
        knots.push(knot(time_s + down.ramp_s, way_rad, 0.0, 0.0));
        let law = HermiteSpline::new(knots).ok()?;
        Some(VariedLaw { law, range_rad_s: (minimum, maximum), ramp_s: up.ramp_s.max(down.ramp_s), bounds })
    }
}

/// A law as it was found.
struct VariedLaw {
    law: HermiteSpline,
    range_rad_s: (f64, f64),
    ramp_s: f64,
    bounds: Vec<BoundShare>,
}
