// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Infeed: how the wheel goes from first contact to size while the part turns.
//!
//! In two ways. As JPS6156064B2 has it, the wheel comes closer by ΔR in every block, through n whole turns: RT = N·ΔR·n, compared in
//! counts of X, so that cutting ends on the phase it began at. The patent stops there and leaves the step of a spiral;
//! turns without infeed follow here. The slope ends in a short blend, for a corner would ask for infinite jerk of X:
//!
//! ```text
//! offset   RT ─╲
//!               ╲  −ΔR per block, exact up to half a blend before the end of turn n
//!                ╲
//!              0  ╲_______  exactly 0 from half a blend after the end of turn n
//! ```
//!
//! Or once per turn on the base circle, by N·ΔR in a blend each, and the depth is constant in between:
//!
//! ```text
//! offset   RT ─╮
//!              ╰────╮
//!                   ╰────╮
//!              0         ╰────
//! ```
//!
//! The infeed may differ from turn to turn, as a list of values whose sum is RT. A spiral then changes its slope in a blend around the end
//! of a turn, which takes the same share of X's limits.
//!
//! Without spark-out the blend at the end lies before the end of turn n, and the last turn is steeper by so much that RT stays exact. The
//! step of the spiral, the infeed of the last turn, stays on the part for the next pass.

use crate::gauging::journal::DWELL_LEAVES_RAD;
use crate::job::grinding::InfeedCourse;
use crate::machine::description::{AxisScale, MotionLimits};
use crate::math::hermite::{HermiteSpline, Knot};
use crate::math::units::{TURN_RAD, um_from_mm};
use alloc::vec::Vec;
use thiserror::Error;

/// Share of X's acceleration and jerk limit that the blend at the end of the infeed may take. Smaller makes the blend
/// longer, and with it what a single spark-out turn leaves (see [`InfeedLaw::left_on_part_mm`]); larger takes from what
/// the path of the lobe may use. At 5 % and ordinary settings the blend is some degrees long and leaves under 0.1 µm.
pub(crate) const BLEND_SHARE: f64 = 0.05;

/// Longest blend (rad): half of that of a spiral lies in the first spark-out turn, of which three quarters must stay.
const LONGEST_BLEND_RAD: f64 = TURN_RAD / 2.0;

/// Largest slope of the last turn of a spiral without spark-out, over that with it: with the longest blend.
const STEEPEST_LAST_TURN: f64 = 1.0 / (1.0 - 0.5 * LONGEST_BLEND_RAD / TURN_RAD);

/// Outward motion of the wheel when it leaves a part that still turns (mm): more than any deflection in a dwell.
const LEAVES_MM: f64 = 0.2;

/// Most turns with infeed: beyond it a mistyped ΔR is likelier than a wish.
pub const MAX_TURNS: u32 = 1000;

/// Infeeds of two turns that differ by less are the same (mm): far below a count, far above rounding.
const SAME_INFEED_MM: f64 = 1e-9;

/// Why settings of the infeed fit no whole number of turns.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InfeedError {
    /// RT is not N·ΔR·n.
    #[error(
        "total infeed {} mm is {turns:.4} turns of {blocks} blocks of {} um; whole turns are needed: {nearest}",
        significant(*.total_mm), significant(um_from_mm(*.per_block_mm))
    )]
    NotWholeTurns {
        total_mm: f64,
        per_block_mm: f64,
        blocks: u32,
        /// RT / (N·ΔR).
        turns: f64,
        /// The nearest values that fit.
        nearest: NearestInfeed,
    },
    /// More turns than `MAX_TURNS`.
    #[error(
        "total infeed {total_mm} mm at {} um per block takes {turns:.0} turns; at most {max} are allowed",
        significant(um_from_mm(*.per_block_mm))
    )]
    TooManyTurns {
        total_mm: f64,
        per_block_mm: f64,
        /// Turns it would take.
        turns: f64,
        max: u32,
    },
    /// The infeeds of the turns do not sum to RT.
    #[error(
        "the {turns} values of the infeed per turn sum to {} mm, the total infeed is {} mm; they must agree within half a count of x_axis \
         ({} um): set the total infeed to {} mm, or change a value by {} um",
        significant(*.sum_mm), significant(*.total_mm), significant(um_from_mm(*.tolerance_mm)), significant(*.sum_mm),
        significant(um_from_mm(*.total_mm - *.sum_mm))
    )]
    WrongSum {
        turns: usize,
        /// Sum of the values (mm).
        sum_mm: f64,
        total_mm: f64,
        /// Difference that is allowed (mm).
        tolerance_mm: f64,
    },
    /// A list of more values than turns are allowed.
    #[error("the infeed per turn has {turns} values; at most {max} are allowed")]
    TooLongList { turns: usize, max: u32 },
    /// RT is less than one count of X.
    #[error("total infeed {total_mm} mm is less than one count of x_axis")]
    BelowOneCount { total_mm: f64 },
}

/// The nearest settings that fit whole turns; no value where there would be no turn at all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestInfeed {
    /// RT below and above, at the given ΔR (mm).
    pub total_mm: (Option<f64>, f64),
    /// ΔR below and above, at the given RT (mm).
    pub per_block_mm: (f64, Option<f64>),
    /// N, blocks of a turn.
    pub blocks: u32,
}

impl core::fmt::Display for NearestInfeed {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("the nearest total infeed is ")?;
        if let Some(below) = self.total_mm.0 {
            write!(f, "{} or ", significant(below))?;
        }
        let below_or_above = |f: &mut core::fmt::Formatter<'_>, um: &dyn Fn(f64) -> f64| {
            write!(f, "{}", significant(um(self.per_block_mm.0)))?;
            match self.per_block_mm.1 {
                Some(above) => write!(f, " or {} um", significant(um(above))),
                None => f.write_str(" um"),
            }
        };
        write!(f, "{} mm, the nearest infeed per block ", significant(self.total_mm.1))?;
        below_or_above(f, &um_from_mm)?;
        f.write_str(", per turn ")?;
        below_or_above(f, &|per_block_mm| um_from_mm(per_block_mm) * f64::from(self.blocks))
    }
}

/// A number at nine decimals of a mm or a µm without its trailing zeros: finer than any count, and readable.
fn significant(value: f64) -> f64 {
    libm::round(value * 1e9) / 1e9
}

/// Total infeed, turns and slope: settings of a pass that are known to fit.
#[derive(Debug, Clone, PartialEq)]
pub struct InfeedSchedule {
    total_counts: i64,
    total_mm: f64,
    turns: u32,
    left_mm: f64,
    course: InfeedCourse,
    sparks_out: bool,
    /// Infeed of each turn (mm); empty: the same in all.
    each_mm: Vec<f64>,
}

impl InfeedSchedule {
    /// Checks RT = N·ΔR·n in counts of X.
    ///
    /// # Errors
    /// No whole number of turns n fits, or too many would be needed.
    pub fn new(total_mm: f64, per_block_mm: f64, blocks: u32, x_scale: AxisScale) -> Result<Self, InfeedError> {
        let per_turn_mm = f64::from(blocks) * per_block_mm;
        let turns = total_mm / per_turn_mm;
        if turns.is_nan() || turns > f64::from(MAX_TURNS) + 0.5 {
            return Err(InfeedError::TooManyTurns { total_mm, per_block_mm, turns, max: MAX_TURNS });
        }
        let total_counts = x_scale.counts(total_mm);
        if total_counts < 1 {
            return Err(InfeedError::BelowOneCount { total_mm });
        }
        let whole = libm::round(turns);
        if whole < 1.0 || x_scale.counts(per_turn_mm * whole) != total_counts {
            let (low, high) = (libm::floor(turns), libm::floor(turns) + 1.0);

            let on_count = |turns: f64| x_scale.position(x_scale.counts(per_turn_mm * turns));
            let nearest = NearestInfeed {
                total_mm: ((low >= 1.0).then(|| on_count(low)), on_count(high)),
                per_block_mm: (
                    total_mm / (f64::from(blocks) * high),
                    (low >= 1.0).then(|| total_mm / (f64::from(blocks) * low)),
                ),
                blocks,
            };
            return Err(InfeedError::NotWholeTurns { total_mm, per_block_mm, blocks, turns, nearest });
        }
        #[allow(clippy::cast_possible_truncation, reason = "between 1 and MAX_TURNS")]
        let turns = whole as u32;
        Ok(Self {
            total_counts,
            total_mm: x_scale.position(total_counts),
            turns,
            left_mm: 0.0,
            course: InfeedCourse::PerAngle,
            sparks_out: true,
            each_mm: Vec::new(),
        })
    }

    /// Checks that the infeeds of the turns (mm) sum to RT, in counts of X. Values that all agree are the same as one value.
    ///
    /// # Errors
    /// Another sum than RT, too many turns, or less than a count of X.
    pub fn from_list(total_mm: f64, each_mm: &[f64], x_scale: AxisScale) -> Result<Self, InfeedError> {
        let turns = u32::try_from(each_mm.len()).ok().filter(|turns| *turns <= MAX_TURNS);
        let turns = turns.ok_or(InfeedError::TooLongList { turns: each_mm.len(), max: MAX_TURNS })?;
        let total_counts = x_scale.counts(total_mm);
        if total_counts < 1 {
            return Err(InfeedError::BelowOneCount { total_mm });
        }
        let sum_mm: f64 = each_mm.iter().sum();
        if sum_mm.is_nan() || x_scale.counts(sum_mm) != total_counts {
            let (turns, tolerance_mm) = (each_mm.len(), 0.5 * x_scale.position(1));
            return Err(InfeedError::WrongSum { turns, sum_mm, total_mm, tolerance_mm });
        }
        let on_counts_mm = x_scale.position(total_counts);
        let is_even = each_mm.iter().all(|mm| (mm - each_mm[0]).abs() < SAME_INFEED_MM);
        let each_mm = each_mm.iter().filter(|_| !is_even).map(|mm| mm * (on_counts_mm / sum_mm)).collect();
        let (left_mm, course) = (0.0, InfeedCourse::PerAngle);
        Ok(Self { total_counts, total_mm: on_counts_mm, turns, left_mm, course, sparks_out: true, each_mm })
    }

    /// The same schedule for a pass after which others take so much more (mm, on counts of X).
    #[must_use]
    pub fn above(self, left_mm: f64) -> Self {
        Self { left_mm, ..self }
    }

    /// The same schedule, spread as wanted.
    #[must_use]
    pub fn spread(self, course: InfeedCourse) -> Self {
        Self { course, ..self }
    }

    /// The same schedule for a pass with turns without infeed after it, or without.
    #[must_use]
    pub fn sparking_out(self, sparks_out: bool) -> Self {
        Self { sparks_out, ..self }
    }

    /// Stock of later passes (mm).
    #[must_use]
    pub const fn left_mm(&self) -> f64 {
        self.left_mm
    }

    /// Total infeed (counts of X).
    #[must_use]
    pub const fn total_counts(&self) -> i64 {
        self.total_counts
    }

    /// Total infeed, on counts of X (mm).
    #[must_use]
    pub const fn total_mm(&self) -> f64 {
        self.total_mm
    }

    /// n, whole turns with infeed.
    #[must_use]
    pub const fn turns(&self) -> u32 {
        self.turns
    }

    /// Infeed of each turn where it differs from turn to turn (mm); empty where it is the same in all.
    #[must_use]
    pub fn each_mm(&self) -> &[f64] {
        &self.each_mm
    }

    /// Infeed of a turn, from 0 (mm).
    #[must_use]
    pub fn of_turn_mm(&self, turn: u32) -> f64 {
        self.each_mm.get(turn as usize).copied().unwrap_or(self.total_mm / f64::from(self.turns))
    }

    /// Largest infeed of a turn (mm).
    #[must_use]
    pub fn max_per_turn_mm(&self) -> f64 {
        self.each_mm.iter().copied().reduce(f64::max).unwrap_or_else(|| self.of_turn_mm(0))
    }

    /// Smallest infeed of a turn (mm).
    #[must_use]
    pub fn min_per_turn_mm(&self) -> f64 {
        self.each_mm.iter().copied().reduce(f64::min).unwrap_or_else(|| self.of_turn_mm(0))
    }

    /// Infeed of the last turn (mm).
    #[must_use]
    pub fn last_turn_mm(&self) -> f64 {
        self.of_turn_mm(self.turns - 1)
    }

    /// Offset of X above the finished path at the begin of a turn, from 0, of a spiral (mm).
    #[must_use]
    pub fn begins_mm(&self, turn: u32) -> f64 {
        match self.each_mm.get(turn as usize..) {
            Some(after) if !self.each_mm.is_empty() && turn > 0 => self.left_mm + after.iter().sum::<f64>(),
            _ => self.left_mm + self.total_mm - f64::from(turn) * self.of_turn_mm(0),
        }
    }

    /// Largest infeed per angle in the mean of a turn (mm/rad).
    #[must_use]
    pub fn slope_mm_rad(&self) -> f64 {
        if self.each_mm.is_empty() {
            return self.total_mm / (f64::from(self.turns) * TURN_RAD);
        }
        self.max_per_turn_mm() / TURN_RAD
    }

    /// Infeed per angle in the mean of the last turn (mm/rad).
    fn last_slope_mm_rad(&self) -> f64 {
        if self.each_mm.is_empty() { self.slope_mm_rad() } else { self.last_turn_mm() / TURN_RAD }
    }

    /// Largest change of the slope of a spiral, its end included (mm/rad).
    fn slope_change_mm_rad(&self) -> f64 {
        let changes = self.each_mm.windows(2).map(|pair| (pair[1] - pair[0]).abs() / TURN_RAD);
        changes.fold(self.last_slope_mm_rad(), f64::max)
    }

    /// Largest slope of the law in most of a turn (mm/rad): 0 where it steps.
    #[must_use]
    pub fn lasting_slope_mm_rad(&self) -> f64 {
        match self.course {
            InfeedCourse::PerAngle => self.slope_mm_rad(),
            InfeedCourse::PerTurn => 0.0,
        }
    }

    /// The law for a work speed: blends are as short as a small share of X's limits allows. Steps lie around `base_rad`, the angle
    /// from the start to the first base centre (rad, in 0..2π).
    #[must_use]
    pub fn law_for(&self, work_speed_rad_s: f64, x: MotionLimits, base_rad: f64) -> InfeedLaw {
        let w = work_speed_rad_s;
        let (acceleration, jerk) = (BLEND_SHARE * x.acceleration, BLEND_SHARE * x.jerk);
        let blend_rad = match self.course {
            // The slope falls by smoothstep: its first and second derivative peak at 1.5/β and 6/β².
            InfeedCourse::PerAngle => {
                let blend_rad =
                    |slope: f64| (1.5 * slope * w * w / acceleration).max(libm::sqrt(6.0 * slope * w * w * w / jerk));
                let slope = self.slope_change_mm_rad();
                match self.sparks_out {
                    true => blend_rad(slope),
                    false => blend_rad(slope.max(STEEPEST_LAST_TURN * self.last_slope_mm_rad())),
                }
            }
            // A quintic step: its second and third derivative peak at (10/√3)/β² and 60/β³.
            InfeedCourse::PerTurn => {
                let step = self.max_per_turn_mm();
                let for_acceleration = libm::sqrt(10.0 / libm::sqrt(3.0) * step * w * w / acceleration);
                for_acceleration.max(libm::cbrt(60.0 * step * w * w * w / jerk))
            }
        };
        // Also where it is not a number.
        let blend_rad = blend_rad.clamp(TURN_RAD / 3600.0, LONGEST_BLEND_RAD);
        match self.course {
            InfeedCourse::PerAngle => InfeedLaw::spiral(self.clone(), blend_rad),
            InfeedCourse::PerTurn => InfeedLaw::steps(self.clone(), blend_rad, base_rad),
        }
    }
}

/// Offset of X above the finished path over the angle turned since the start (mm over rad); it ends at what later passes take.
#[derive(Debug, Clone, PartialEq)]
pub struct InfeedLaw {
    schedule: InfeedSchedule,
    last_blend_rad: (f64, f64),
    law: HermiteSpline,
}

impl InfeedLaw {
    fn spiral(schedule: InfeedSchedule, blend_rad: f64) -> Self {
        let of_turn = |turn: usize| schedule.each_mm[turn] / TURN_RAD;
        let first = if schedule.each_mm.is_empty() { schedule.slope_mm_rad() } else { of_turn(0) };
        let half = 0.5 * blend_rad;
        if !schedule.sparks_out {
            return Self::spiral_to_the_end(schedule, half);
        }
        let slope = schedule.last_slope_mm_rad();
        let end = f64::from(schedule.turns) * TURN_RAD;
        let mut knots =
            alloc::vec![Knot { at: 0.0, value: schedule.left_mm + schedule.total_mm, first: -first, second: 0.0 }];
        // The slope goes from one to the other by smoothstep around the end of a turn, so that it adds nothing there.
        for (turn, pair) in (1_u32..).zip(schedule.each_mm.windows(2)) {
            if (pair[1] - pair[0]).abs() >= SAME_INFEED_MM {
                let (at, level) = (f64::from(turn) * TURN_RAD, schedule.begins_mm(turn));
                let (before, after) = (pair[0] / TURN_RAD, pair[1] / TURN_RAD);
                knots.push(Knot { at: at - half, value: level + before * half, first: -before, second: 0.0 });
                knots.push(Knot { at: at + half, value: level - after * half, first: -after, second: 0.0 });
            }
        }
        knots.push(Knot { at: end - half, value: schedule.left_mm + slope * half, first: -slope, second: 0.0 });
        knots.push(Knot { at: end + half, value: schedule.left_mm, first: 0.0, second: 0.0 });
        let law = HermiteSpline::new(knots)
            .expect("the blend is longer than nothing and ends within the turns around it; all numbers are finite");
        Self { schedule, last_blend_rad: (end - half, end + half), law }
    }

    /// A spiral that ends with the last turn: the slope of this turn is f/(2π − β/2) with its infeed f, and falls to 0 over the blend β.
    fn spiral_to_the_end(schedule: InfeedSchedule, half: f64) -> Self {
        let end = f64::from(schedule.turns) * TURN_RAD;
        let of_turn = |turn: u32| match turn + 1 == schedule.turns {
            true => schedule.last_turn_mm() / (TURN_RAD - half),
            false => schedule.of_turn_mm(turn) / TURN_RAD,
        };
        let knot = |at: f64, value: f64, slope: f64| Knot { at, value, first: -slope, second: 0.0 };
        let mut knots = alloc::vec![knot(0.0, schedule.left_mm + schedule.total_mm, of_turn(0))];
        for turn in 1..schedule.turns {
            let (before, after) = (of_turn(turn - 1), of_turn(turn));
            if (after - before).abs() * TURN_RAD >= SAME_INFEED_MM {
                let (at, level) = (f64::from(turn) * TURN_RAD, schedule.begins_mm(turn));
                knots.push(knot(at - half, level + before * half, before));
                knots.push(knot(at + half, level - after * half, after));
            }
        }
        let last = of_turn(schedule.turns - 1);
        knots.push(knot(end - 2.0 * half, schedule.left_mm + last * half, last));
        knots.push(Knot { at: end, value: schedule.left_mm, first: 0.0, second: 0.0 });
        let law = HermiteSpline::new(knots).expect("a blend is at most half a turn; all numbers are finite");
        Self { schedule, last_blend_rad: (end - 2.0 * half, end), law }
    }

    /// Turn k, from 0, is ground at RT·(1 − (k+1)/n). The last step ends within the last turn with infeed, so that a whole turn
    /// at size follows it.
    fn steps(schedule: InfeedSchedule, blend_rad: f64, base_rad: f64) -> Self {
        let half = 0.5 * blend_rad;
        let first = base_rad.clamp(half, TURN_RAD - half);
        let still = |at: f64, value: f64| Knot { at, value, first: 0.0, second: 0.0 };
        let level = |step: u32| {
            if !schedule.each_mm.is_empty() {
                return schedule.begins_mm(step);
            }
            schedule.left_mm + schedule.total_mm * f64::from(schedule.turns - step) / f64::from(schedule.turns)
        };
        let mut knots = Vec::with_capacity(2 * schedule.turns as usize + 1);
        if first > half {
            knots.push(still(0.0, level(0)));
        }
        let mut last_blend_rad = (0.0, 0.0);
        for step in 0..schedule.turns {
            let centre = first + f64::from(step) * TURN_RAD;
            last_blend_rad = (centre - half, centre + half);
            knots.push(still(last_blend_rad.0, level(step)));
            knots.push(still(last_blend_rad.1, level(step + 1)));
        }
        let law = HermiteSpline::new(knots).expect("a blend is at most half a turn; all numbers are finite");
        Self { schedule, last_blend_rad, law }
    }

    /// The same law for a cut that C comes to turning: X already goes at the rate of the infeed when the cut begins, and got to it
    /// before, in a blend as long as the last.
    #[must_use]
    pub(crate) fn begun_at_speed(self) -> Self {
        let first = self.law.knots()[0];
        if first.first >= 0.0 {
            return self;
        }
        let blend_rad = self.last_blend_rad.1 - self.last_blend_rad.0;
        let before =
            Knot { at: -blend_rad, value: first.value - 0.5 * blend_rad * first.first, first: 0.0, second: 0.0 };
        let knots = [before].into_iter().chain(self.law.knots().iter().copied()).collect();
        let law = HermiteSpline::new(knots).expect("a blend is longer than nothing; all numbers are finite");
        Self { law, ..self }
    }

    /// The same law for a cut of this many turns (rad) with retraction while the part still turns: X moves outwards during the last
    /// part of the last turn, so the stop of C leaves no mark on the part.
    #[must_use]
    pub(crate) fn left_turning(self, turns_rad: f64) -> Self {
        let left_mm = self.schedule.left_mm;
        let still = |at: f64, value: f64| Knot { at, value, first: 0.0, second: 0.0 };
        let knots = self.law.knots().iter().copied();
        let leaving = [
            still(turns_rad - DWELL_LEAVES_RAD.0, left_mm),
            still(turns_rad - DWELL_LEAVES_RAD.1, left_mm + LEAVES_MM),
        ];
        let law = HermiteSpline::new(knots.chain(leaving).collect())
            .expect("the last blend ends within the first quarter of the last turns; all numbers are finite");
        Self { law, ..self }
    }

    /// Schedule that it was made from.
    #[must_use]
    pub const fn schedule(&self) -> &InfeedSchedule {
        &self.schedule
    }

    #[must_use]
    pub const fn law(&self) -> &HermiteSpline {
        &self.law
    }

    /// Angles from the first change of the infeed to the end of the last blend (rad): in between, turns differ from each other. Where the
    /// infeed is the same in all turns it is the last blend, without spark-out the last turn too.
    #[must_use]
    pub fn varies_rad(&self) -> (f64, f64) {
        let (from, to) = self.last_blend_rad;
        if !self.schedule.each_mm.is_empty() {
            return (0.0, to);
        }
        match self.schedule.sparks_out || self.schedule.course == InfeedCourse::PerTurn {
            true => (from, to),
            false => ((from - TURN_RAD).max(0.0), to),
        }
    }

    /// Start and end of the last blend (rad); for a spiral centred on the end of the last turn with infeed, without spark-out before it.
    #[must_use]
    pub const fn last_blend_rad(&self) -> (f64, f64) {
        self.last_blend_rad
    }

    /// Most that stays on the contour at the start phase after the spark-out (mm): the second half of the blend lies in
    /// the first spark-out turn, so with one such turn that stretch is cut by the blend and not again. After steps nothing stays. Without
    /// spark-out it is the infeed of the last turn.
    #[must_use]
    pub fn left_on_part_mm(&self, spark_out_turns: u32) -> f64 {
        if spark_out_turns == 0 {
            return self.schedule.last_turn_mm();
        }
        if spark_out_turns >= 2 || self.schedule.course == InfeedCourse::PerTurn {
            return 0.0;
        }
        // Half-way through the blend ∫(1 − 3u² + 2u³) du over ½..1 = 3/32 of slope times blend is still to go.
        let (from, to) = self.last_blend_rad;
        self.schedule.last_slope_mm_rad() * (to - from) * (3.0 / 32.0)
    }
}

/// The infeed of a law differs from turn to turn.
pub(crate) fn differs_by_turn(law: &HermiteSpline, turns: u32) -> bool {
    let level = |turn: u32| law.sample(f64::from(turn) * TURN_RAD).value;
    let ends_mm = law.knots().iter().map(|knot| knot.value).fold(f64::INFINITY, f64::min);
    let each_mm = (level(0) - ends_mm) / f64::from(turns.max(1));
    (1..turns).any(|turn| (level(turn - 1) - level(turn) - each_mm).abs() > SAME_INFEED_MM)
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::string::ToString;

    const X: AxisScale = AxisScale::Linear { counts_per_mm: 100_000 };
    const LIMITS: MotionLimits = MotionLimits { velocity: 500.0, acceleration: 10_000.0, jerk: 1e6 };

    fn blend_rad(law: &InfeedLaw) -> f64 {
        law.last_blend_rad().1 - law.last_blend_rad().0
    }

    /// Four turns of 3600 blocks of 25 nm are 0.36 mm; block k begins at RT − k·ΔR to the count.
    #[test]
    fn every_block_takes_its_infeed() {
        let schedule = InfeedSchedule::new(0.36, 0.000_025, 3600, X).expect("0.36 mm is 4 turns");
        assert_eq!((schedule.turns(), schedule.total_counts()), (4, 36_000));
        let law = schedule.law_for(6.0, LIMITS, 0.0);
        let blocks_in_half_blend = blend_rad(&law) / TURN_RAD * 1800.0;
        for block in 0..4 * 3600 {
            if f64::from(block) < 4.0 * 3600.0 - blocks_in_half_blend {
                let offset = law.law().sample(f64::from(block) * TURN_RAD / 3600.0).value;
                assert!((offset - (0.36 - f64::from(block) * 0.000_025)).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn after_the_blend_the_offset_is_exactly_zero() {
        let law = InfeedSchedule::new(0.36, 0.000_025, 3600, X).expect("4 turns").law_for(6.0, LIMITS, 0.0);
        for i in 0..1000 {
            let at = law.last_blend_rad().1 + f64::from(i) * 0.01;
            assert_eq!(law.law().sample(at).value.to_bits(), 0.0_f64.to_bits());
        }
    }

    /// The offset never rises, and its blend takes its share of X's limits at most.
    #[test]
    fn the_blend_keeps_its_share() {
        for speed in [0.5, 6.0, 30.0] {
            let law = InfeedSchedule::new(0.36, 0.000_05, 3600, X).expect("2 turns").law_for(speed, LIMITS, 0.0);
            let end = 2.0 * TURN_RAD + blend_rad(&law);
            for i in 0..=10_000 {
                let s = law.law().sample(end * f64::from(i) / 10_000.0);
                assert!(s.first <= 1e-12);
                assert!(s.second.abs() * speed * speed <= BLEND_SHARE * LIMITS.acceleration * (1.0 + 1e-9));
                assert!(s.third.abs() * speed * speed * speed <= BLEND_SHARE * LIMITS.jerk * (1.0 + 1e-9));
            }
            let half_way = law.law().sample(2.0 * TURN_RAD).value;
            assert!((half_way - law.left_on_part_mm(1)).abs() < 1e-12);
        }
    }

    /// Steps lie on the base circle, wherever the cut begins; between them the depth stays, to the bit; X keeps its share.
    #[test]
    fn steps_take_the_infeed_of_a_turn_on_the_base_circle() {
        let schedule = InfeedSchedule::new(0.36, 0.000_025, 3600, X).expect("4 turns").spread(InfeedCourse::PerTurn);
        for (speed, base_rad) in [(6.0, 2.0), (6.0, 0.0), (30.0, 6.2), (0.5, 3.0)] {
            let law = schedule.law_for(speed, LIMITS, base_rad);
            let half = 0.5 * blend_rad(&law);
            let first = law.last_blend_rad().0 + half - 3.0 * TURN_RAD;
            assert!((first - base_rad).abs() <= half, "{first} rad");
            for turn in 0..4_u32 {
                let centre = first + f64::from(turn) * TURN_RAD;
                let stays = |level: u32| 0.36 * f64::from(level) / 4.0;
                for after in [half + 1e-9, 3.0, TURN_RAD - half - 1e-9] {
                    let there = law.law().sample(centre + after);
                    assert!((there.value - stays(3 - turn)).abs() < 1e-15 && there.first.abs() < 1e-12, "{there:?}");
                }
                assert!((law.law().sample(centre).value - 0.5 * (stays(4 - turn) + stays(3 - turn))).abs() < 1e-12);
            }
            for i in 0..=20_000 {
                let s = law.law().sample(law.law().end() * f64::from(i) / 20_000.0);
                assert!(s.first <= 1e-12);
                assert!(s.second.abs() * speed * speed <= BLEND_SHARE * LIMITS.acceleration * (1.0 + 1e-9));
                assert!(s.third.abs() * speed * speed * speed <= BLEND_SHARE * LIMITS.jerk * (1.0 + 1e-9));
            }
            // A whole turn at size fits between the last step and the end of one spark-out turn.
            assert!(law.last_blend_rad().1 <= 4.0 * TURN_RAD + 1e-12);
            assert_eq!(law.law().sample(law.last_blend_rad().1).value.to_bits(), 0.0_f64.to_bits());
        }
    }

    #[test]
    fn what_fits_no_whole_turns_is_refused_with_its_neighbours() {
        let error = InfeedSchedule::new(0.35, 0.000_025, 3600, X).expect_err("3.89 turns");
        assert_eq!(
            error.to_string(),
            "total infeed 0.35 mm is 3.8889 turns of 3600 blocks of 0.025 um; whole turns are needed: the nearest \
             total infeed is 0.27 or 0.36 mm, the nearest infeed per block 0.024305556 or 0.032407407 um, per turn 87.5 or \
             116.666666667 um"
        );
        // The neighbours named do fit.
        for (total, per_block) in
            [(0.27, 0.000_025), (0.36, 0.000_025), (0.35, 0.000_024_305_556), (0.35, 0.000_032_407_407)]
        {
            InfeedSchedule::new(total, per_block, 3600, X).expect("a value the refusal named");
        }
    }

    /// One count off is refused, half a count is not seen.
    #[test]
    fn infeed_is_compared_in_counts() {
        assert!(InfeedSchedule::new(0.360_01, 0.000_025, 3600, X).is_err());
        assert!(InfeedSchedule::new(0.360_004, 0.000_025, 3600, X).is_ok());
        let under_a_turn = InfeedSchedule::new(0.04, 0.000_025, 3600, X).expect_err("0.44 turns");
        assert!(under_a_turn.to_string().contains("the nearest total infeed is 0.09 mm"), "{under_a_turn}");
        assert!(matches!(InfeedSchedule::new(0.36, 1e-12, 3600, X), Err(InfeedError::TooManyTurns { .. })));
    }

    const LIST_MM: [f64; 4] = [0.14, 0.1, 0.1, 0.02];

    fn listed() -> InfeedSchedule {
        InfeedSchedule::from_list(0.36, &LIST_MM, X).expect("the sum is 0.36 mm")
    }

    /// Each turn takes its own infeed: at the end of a turn the spiral stands where the values so far bring it, but for the smoothstep of
    /// the slope, which is 3/32 of the change times the blend off in its middle; a blend away it is exact.
    #[test]
    fn every_turn_of_a_list_takes_its_infeed() {
        let law = listed().law_for(6.0, LIMITS, 0.0);
        let (half, mut left_mm) = (0.5 * blend_rad(&law), 0.36);
        for (turn, infeed_mm) in (0_u32..).zip(LIST_MM) {
            let begin = f64::from(turn) * TURN_RAD;
            for share in [0.2, 0.5, 0.8] {
                let at = law.law().sample(begin + share * TURN_RAD);
                assert!((at.value - (left_mm - share * infeed_mm)).abs() < 1e-12, "turn {turn}: {at:?}");
                assert!((at.first + infeed_mm / TURN_RAD).abs() < 1e-12, "turn {turn}: {at:?}");
            }
            let before_mm = LIST_MM[(turn as usize).saturating_sub(1)];
            let middle_mm = (before_mm - infeed_mm) / TURN_RAD * 2.0 * half * (3.0 / 32.0);
            assert!((law.law().sample(begin).value - (left_mm + middle_mm)).abs() < 1e-12, "turn {turn}");
            left_mm -= infeed_mm;
        }
        assert_eq!(law.law().sample(law.law().end()).value.to_bits(), 0.0_f64.to_bits());
        assert_eq!((law.varies_rad().0, listed().turns(), listed().total_counts()), (0.0, 4, 36_000));
        assert!((law.left_on_part_mm(1) - 0.02 / TURN_RAD * 2.0 * half * (3.0 / 32.0)).abs() < 1e-12);
    }

    /// The offset never rises, and every blend takes its share of X's limits at most.
    #[test]
    fn the_blends_of_a_list_keep_their_share() {
        for (course, each_mm) in [
            (InfeedCourse::PerAngle, &LIST_MM[..]),
            (InfeedCourse::PerAngle, &[0.01, 0.34, 0.01]),
            (InfeedCourse::PerTurn, &LIST_MM[..]),
            (InfeedCourse::PerTurn, &[0.01, 0.34, 0.01]),
        ] {
            let schedule = InfeedSchedule::from_list(0.36, each_mm, X).expect("the sum is 0.36 mm").spread(course);
            for speed in [0.5, 6.0, 30.0] {
                let law = schedule.law_for(speed, LIMITS, 1.0);
                let mut before_mm = f64::INFINITY;
                for i in 0..=40_000 {
                    let s = law.law().sample(law.law().end() * f64::from(i) / 40_000.0);
                    assert!(s.value <= before_mm + 1e-15 && s.first <= 1e-12, "{course:?} {speed}: {s:?}");
                    assert!(s.second.abs() * speed * speed <= BLEND_SHARE * LIMITS.acceleration * (1.0 + 1e-9));
                    assert!(s.third.abs() * speed * speed * speed <= BLEND_SHARE * LIMITS.jerk * (1.0 + 1e-9));
                    before_mm = s.value;
                }
            }
        }
    }

    /// Without spark-out a spiral ends with its last turn, on a count and without a slope. Turns before the last take their infeed to the
    /// last bit beside the blends; the last one is steeper and takes its own.
    #[test]
    fn a_spiral_without_spark_out_ends_with_its_last_turn() {
        let even = |turns: u32| {
            let total_mm = 0.09 * f64::from(turns);
            InfeedSchedule::new(total_mm, 0.000_025, 3600, X).expect("whole turns").sparking_out(false)
        };
        for (schedule, speed) in [(even(4), 6.0), (even(1), 6.0), (even(1), 300.0), (listed().sparking_out(false), 6.0)]
        {
            let law = schedule.above(0.1).law_for(speed, LIMITS, 0.0);
            let (schedule, end) = (law.schedule().clone(), f64::from(law.schedule().turns()) * TURN_RAD);
            let (from, to) = law.last_blend_rad();
            let half = 0.5 * (to - from);
            assert_eq!((to.to_bits(), law.law().end().to_bits()), (end.to_bits(), end.to_bits()));
            let ends = law.law().sample(end);
            assert_eq!((ends.value.to_bits(), ends.first.to_bits()), (0.1_f64.to_bits(), 0.0_f64.to_bits()));
            for turn in 0..schedule.turns() {
                let begin = f64::from(turn) * TURN_RAD;
                let is_last = turn + 1 == schedule.turns();
                let slope = schedule.of_turn_mm(turn) / if is_last { TURN_RAD - half } else { TURN_RAD };
                let at = law.law().sample(begin + half.max(1.0).min(TURN_RAD - 2.0 * half));
                let on_line = schedule.begins_mm(turn) - slope * half.max(1.0).min(TURN_RAD - 2.0 * half);
                assert!((at.value - on_line).abs() < 1e-12 && (at.first + slope).abs() < 1e-12, "turn {turn}: {at:?}");
            }
            let mut before_mm = f64::INFINITY;
            for i in 0..=40_000 {
                let s = law.law().sample(end * f64::from(i) / 40_000.0);
                assert!(s.value <= before_mm + 1e-15 && s.first <= 1e-12, "{s:?}");
                if to - from < LONGEST_BLEND_RAD {
                    assert!(s.second.abs() * speed * speed <= BLEND_SHARE * LIMITS.acceleration * (1.0 + 1e-9));
                    assert!(s.third.abs() * speed * speed * speed <= BLEND_SHARE * LIMITS.jerk * (1.0 + 1e-9));
                }
                before_mm = s.value;
            }
            assert_eq!(law.left_on_part_mm(0).to_bits(), schedule.last_turn_mm().to_bits());
            assert!(law.varies_rad().0 <= (end - TURN_RAD - half).max(0.0) && law.varies_rad().1 >= end);
        }
    }

    /// Steps of a list are its values, one per turn.
    #[test]
    fn steps_of_a_list_are_its_values() {
        let law = listed().spread(InfeedCourse::PerTurn).law_for(6.0, LIMITS, 2.0);
        let mut left_mm = 0.36;
        for (turn, infeed_mm) in (0_u32..).zip(LIST_MM) {
            left_mm -= infeed_mm;
            let stands = law.law().sample(2.0 + 3.0 + f64::from(turn) * TURN_RAD);
            assert!((stands.value - left_mm).abs() < 1e-12 && stands.first.abs() < 1e-12, "turn {turn}: {stands:?}");
        }
    }

    /// A list of equal values is the same law as one value, to the bit, and the check of a plan sees which laws differ by turn.
    #[test]
    fn equal_values_of_a_list_are_one_value() {
        let even = InfeedSchedule::from_list(0.36, &[0.09; 4], X).expect("4 turns");
        assert_eq!(even, InfeedSchedule::new(0.36, 0.000_025, 3600, X).expect("4 turns"));
        for course in [InfeedCourse::PerAngle, InfeedCourse::PerTurn] {
            let law = |schedule: InfeedSchedule| schedule.spread(course).above(0.1).law_for(6.0, LIMITS, 2.0);
            assert!(!differs_by_turn(law(even.clone()).law(), 4) && differs_by_turn(law(listed()).law(), 4));
            let two = InfeedSchedule::from_list(0.36, &[0.2, 0.16], X).expect("2 turns");
            assert!(differs_by_turn(law(two).law(), 2));
        }
    }

    #[test]
    fn a_list_with_another_sum_is_refused_with_what_is_missing() {
        let error = InfeedSchedule::from_list(0.36, &[0.2, 0.15], X).expect_err("0.35 mm");
        assert_eq!(
            error.to_string(),
            "the 2 values of the infeed per turn sum to 0.35 mm, the total infeed is 0.36 mm; they must agree within half a count of x_axis \
             (0.005 um): set the total infeed to 0.35 mm, or change a value by 10 um"
        );
        assert!(InfeedSchedule::from_list(0.36, &[0.2, 0.160_004], X).is_ok());
        assert!(InfeedSchedule::from_list(0.36, &[0.2, 0.160_01], X).is_err());
        assert!(matches!(InfeedSchedule::from_list(0.36, &[f64::NAN], X), Err(InfeedError::WrongSum { .. })));
        assert!(matches!(InfeedSchedule::from_list(0.0, &[0.2], X), Err(InfeedError::BelowOneCount { .. })));
        let long = alloc::vec![1e-3; 1001];
        assert!(matches!(InfeedSchedule::from_list(1.001, &long, X), Err(InfeedError::TooLongList { .. })));
    }
}
