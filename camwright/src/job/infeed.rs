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

/// Outward motion of the wheel when it leaves a part that still turns (mm): more than any deflection in a dwell.
const LEAVES_MM: f64 = 0.2;

/// Most turns with infeed: beyond it a mistyped ΔR is likelier than a wish.
const MAX_TURNS: u32 = 1000;

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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InfeedSchedule {
    total_counts: i64,
    total_mm: f64,
    turns: u32,
    left_mm: f64,
    course: InfeedCourse,
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
        })
    }

    /// The same schedule for a pass after which others take so much more (mm, on counts of X).
    #[must_use]
    pub const fn above(self, left_mm: f64) -> Self {
        Self { left_mm, ..self }
    }

    /// The same schedule, spread as wanted.
    #[must_use]
    pub const fn spread(self, course: InfeedCourse) -> Self {
        Self { course, ..self }
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

    /// Infeed of a turn (mm).
    #[must_use]
    pub fn per_turn_mm(&self) -> f64 {
        self.total_mm / f64::from(self.turns)
    }

    /// Infeed per angle in the mean of a turn (mm/rad).
    #[must_use]
    pub fn slope_mm_rad(&self) -> f64 {
        self.total_mm / (f64::from(self.turns) * TURN_RAD)
    }

    /// Slope of the law in most of a turn (mm/rad): 0 where it steps.
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
                let slope = self.slope_mm_rad();
                (1.5 * slope * w * w / acceleration).max(libm::sqrt(6.0 * slope * w * w * w / jerk))
            }
            // A quintic step: its second and third derivative peak at (10/√3)/β² and 60/β³.
            InfeedCourse::PerTurn => {
                let step = self.per_turn_mm();
                let for_acceleration = libm::sqrt(10.0 / libm::sqrt(3.0) * step * w * w / acceleration);
                for_acceleration.max(libm::cbrt(60.0 * step * w * w * w / jerk))
            }
        };
        // Also where it is not a number.
        let blend_rad = blend_rad.clamp(TURN_RAD / 3600.0, LONGEST_BLEND_RAD);
        match self.course {
            InfeedCourse::PerAngle => InfeedLaw::spiral(*self, blend_rad),
            InfeedCourse::PerTurn => InfeedLaw::steps(*self, blend_rad, base_rad),
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
        let slope = schedule.slope_mm_rad();
        let end = f64::from(schedule.turns) * TURN_RAD;
        let half = 0.5 * blend_rad;
        let law = HermiteSpline::new(alloc::vec![
            Knot { at: 0.0, value: schedule.left_mm + schedule.total_mm, first: -slope, second: 0.0 },
            Knot { at: end - half, value: schedule.left_mm + slope * half, first: -slope, second: 0.0 },
            Knot { at: end + half, value: schedule.left_mm, first: 0.0, second: 0.0 },
        ])
        .expect("the blend is longer than nothing and ends within the turns around it; all numbers are finite");
        Self { schedule, last_blend_rad: (end - half, end + half), law }
    }

    /// Turn k, from 0, is ground at RT·(1 − (k+1)/n). The last step ends within the last turn with infeed, so that a whole turn
    /// at size follows it.
    fn steps(schedule: InfeedSchedule, blend_rad: f64, base_rad: f64) -> Self {
        let half = 0.5 * blend_rad;
        let first = base_rad.clamp(half, TURN_RAD - half);
        let still = |at: f64, value: f64| Knot { at, value, first: 0.0, second: 0.0 };
        let level = |step: u32| {
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

    /// Start and end of the last blend (rad); for a spiral centred on the end of the last turn with infeed.
    #[must_use]
    pub const fn last_blend_rad(&self) -> (f64, f64) {
        self.last_blend_rad
    }

    /// Most that stays on the contour at the start phase after the spark-out (mm): the second half of the blend lies in
    /// the first spark-out turn, so with one such turn that stretch is cut by the blend and not again. After steps nothing stays.
    #[must_use]
    pub fn left_on_part_mm(&self, spark_out_turns: u32) -> f64 {
        if spark_out_turns >= 2 || self.schedule.course == InfeedCourse::PerTurn {
            return 0.0;
        }
        // Half-way through the blend ∫(1 − 3u² + 2u³) du over ½..1 = 3/32 of slope times blend is still to go.
        let (from, to) = self.last_blend_rad;
        self.schedule.slope_mm_rad() * (to - from) * (3.0 / 32.0)
    }
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
}
