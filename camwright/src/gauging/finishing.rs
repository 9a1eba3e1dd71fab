// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Turns after a correction that take an even depth and end at the size.
//!
//! The radius that leaves the wheel falls from r₁ after the correction to r* over N turns, and stays for one turn more:
//!
//! ```text
//! r(u) = r* + D (1 − w(u)),   D = r₁ − r*,   u from the end of the correction on
//! L(u) = r(u) − F0/km − (kg/km)(r(u − 2π) − r(u))
//! ```
//! w grows from 0 to 1 with a constant slope but for its two ends. The contact law solved for the wheel position L gives that radius exactly,
//! so every place loses the same depth per turn, and the last turn leaves a circle: a spiral with turns of spark-out would leave a part of its
//! step. At the end the wheel takes nothing and leaves.
//!
//! Without the law, as in the published method, the wheel itself moves by D w(u), and the last turn is one of spark-out.
//!
//! A job states either depth and number of turns, or stock and normal force. Then the contact law of the journal gives both:
//!
//! ```text
//! U = (F − F0)/kg,   N the smallest whole number with D/(N − 1/4) ≤ U
//! ```
//! The quarter is what both ends of the feed take from a turn. A blunt wheel or a hard part has a larger kg and gets more turns at the same
//! force.

use crate::machine::contact_law::ContactLaw;
use crate::math::hermite::Sample;
use crate::math::units::{TURN_RAD, mm_from_um, um_from_mm};
use thiserror::Error;

/// Angle over which the feed begins, and over which it ends (rad).
const EASE_RAD: f64 = TURN_RAD / 4.0;

/// Most finishing turns.
pub const MAX_FINISHING_TURNS: u32 = 20;

/// Largest depth of a finishing turn (mm).
pub const MAX_FINISHING_MM: f64 = 0.05;

/// Largest stock of all finishing turns (mm).
pub const MAX_FINISHING_STOCK_MM: f64 = MAX_FINISHING_TURNS as f64 * MAX_FINISHING_MM;

/// Largest normal force of finishing turns (N).
pub const MAX_FINISHING_N: f64 = 20_000.0;

/// Rounding tolerance of the number of turns: a depth that is exactly the permitted one costs no further turn.
const ROUNDING_TURNS: f64 = 1e-9;

/// Finishing turns as a job states them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FinishingSpec {
    /// Depth and number of turns.
    PerTurn {
        /// Depth of a turn (mm).
        per_turn_mm: f64,
        /// Turns with feed.
        turns: u32,
    },
    /// Stock and normal force: depth and number follow from the contact of the journal.
    ByForce {
        /// Depth of all turns together (mm).
        stock_mm: f64,
        /// Normal force that no turn exceeds (N).
        force_n: f64,
        /// Largest number of turns with feed.
        max_turns: u32,
    },
}

/// Contact with which the stock cannot be finished at the force of the job.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum FinishingError {
    /// The wheel rubs at this force.
    #[error(
        "finishing at {force_n} N takes nothing: the wheel begins to cut at {threshold_n:.1} N; raise runout_correction.finishing.force_n \
         above that"
    )]
    NoCut {
        /// Force of the job (N).
        force_n: f64,
        /// F0 of the contact (N).
        threshold_n: f64,
    },
    /// The stock needs too many turns at this force.
    #[error(
        "finishing at {force_n} N takes {:.3} um per turn (grinding stiffness {:.2} N/um, {threshold_n:.1} N to begin): {:.1} um need \
         {turns:.0} turns, at most {max_turns} are allowed; raise runout_correction.finishing.force_n to {:.1} or more, raise max_turns or \
         lower stock_um",
        // N/mm and N/um differ as um and mm do.
        um_from_mm(*.depth_mm), mm_from_um(*.grinding_n_mm), um_from_mm(*.stock_mm), libm::ceil(10.0 * *.enough_n) / 10.0
    )]
    TooManyTurns {
        /// Force of the job (N).
        force_n: f64,
        /// Depth of cut at this force (mm).
        depth_mm: f64,
        /// kg of the contact (N/mm).
        grinding_n_mm: f64,
        /// F0 of the contact (N).
        threshold_n: f64,
        /// Stock of finishing (mm).
        stock_mm: f64,
        /// Turns that it needs.
        turns: f64,
        /// Turns that the job permits.
        max_turns: u32,
        /// Smallest force with which they are enough (N).
        enough_n: f64,
    },
}

impl FinishingSpec {
    /// Depth of all turns together (mm). It does not depend on the contact, so that the passes leave it before anything is measured.
    #[must_use]
    pub fn depth_mm(&self) -> f64 {
        match *self {
            Self::PerTurn { per_turn_mm, turns } => f64::from(turns) * per_turn_mm,
            Self::ByForce { stock_mm, .. } => stock_mm,
        }
    }

    /// Turns on a journal with this contact.
    ///
    /// # Errors
    /// A force at which the wheel does not cut, or with which the permitted turns do not take the stock.
    pub fn turns(&self, law: &ContactLaw) -> Result<Finishing, FinishingError> {
        let depth_mm = self.depth_mm();
        let (force_n, max_turns) = match *self {
            Self::PerTurn { turns, .. } => return Ok(Finishing { depth_mm, turns }),
            Self::ByForce { force_n, max_turns, .. } => (force_n, max_turns),
        };
        let cut_mm = law.depth_from_force_mm(force_n);
        if cut_mm.is_nan() || cut_mm <= 0.0 {
            return Err(FinishingError::NoCut { force_n, threshold_n: law.threshold_n() });
        }
        let turns = Finishing::turns_for(depth_mm, cut_mm).max(libm::ceil(depth_mm / MAX_FINISHING_MM));
        if turns > f64::from(max_turns) {
            let deepest_mm = Finishing { depth_mm, turns: max_turns }.deepest_mm();
            return Err(FinishingError::TooManyTurns {
                force_n,
                depth_mm: cut_mm,
                grinding_n_mm: law.grinding_n_mm(),
                threshold_n: law.threshold_n(),
                stock_mm: depth_mm,
                turns,
                max_turns,
                enough_n: law.threshold_n() + law.grinding_n_mm() * deepest_mm,
            });
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a whole number from 1 to a u32")]
        Ok(Finishing { depth_mm, turns: turns as u32 })
    }
}

/// Finishing turns after a correction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finishing {
    /// Depth of all turns together (mm).
    pub depth_mm: f64,
    /// Turns with feed. One turn without feed follows.
    pub turns: u32,
}

impl Finishing {
    /// Smallest number of turns in which no place loses more than a depth of cut in a turn.
    fn turns_for(depth_mm: f64, cut_mm: f64) -> f64 {
        let full = depth_mm / cut_mm;
        // The only turn begins and ends at rest, and takes no more than the whole depth.
        if full <= 1.0 + ROUNDING_TURNS {
            1.0
        } else {
            libm::ceil(full + EASE_RAD / TURN_RAD - ROUNDING_TURNS).max(2.0)
        }
    }

    /// Largest depth of cut (mm): what a place loses per turn between begin and end of the feed.
    #[must_use]
    pub fn deepest_mm(&self) -> f64 {
        match self.turns {
            0 | 1 => self.depth_mm,
            turns => self.depth_mm / (f64::from(turns) - EASE_RAD / TURN_RAD),
        }
    }

    /// Largest normal force by the contact law (N).
    #[must_use]
    pub fn peak_n(&self, law: &ContactLaw) -> f64 {
        law.threshold_n() + law.grinding_n_mm() * self.deepest_mm()
    }

    /// Turns that it takes, with the one that cuts to size.
    #[must_use]
    pub const fn all_turns(&self) -> u32 {
        self.turns + 1
    }

    /// Share of the depth that has been fed, over the angle since the correction (rad), with its derivatives.
    fn fed(&self, since_rad: f64) -> Sample {
        let end_rad = f64::from(self.turns) * TURN_RAD;
        let slope = 1.0 / (end_rad - EASE_RAD);
        if since_rad <= 0.0 {
            return Sample::default();
        }
        if since_rad >= end_rad {
            return Sample { value: 1.0, ..Sample::default() };
        }
        // The end is the begin, mirrored.
        if since_rad > end_rad - EASE_RAD {
            let mirrored = Self::begun(end_rad - since_rad, slope);
            return Sample { value: 1.0 - mirrored.value, second: -mirrored.second, ..mirrored };
        }
        if since_rad < EASE_RAD {
            return Self::begun(since_rad, slope);
        }
        Sample { value: slope * (since_rad - 0.5 * EASE_RAD), first: slope, ..Sample::default() }
    }

    /// Begin of the feed: its slope grows as 10τ³ − 15τ⁴ + 6τ⁵.
    fn begun(since_rad: f64, slope: f64) -> Sample {
        let t = since_rad / EASE_RAD;
        let (t2, t3) = (t * t, t * t * t);
        Sample {
            value: slope * EASE_RAD * t3 * t * (2.5 - 3.0 * t + t2),
            first: slope * t3 * (10.0 - 15.0 * t + 6.0 * t2),
            second: slope / EASE_RAD * t2 * (30.0 - 60.0 * t + 30.0 * t2),
            third: slope / (EASE_RAD * EASE_RAD) * t * (60.0 - 180.0 * t + 120.0 * t2),
        }
    }

    /// Wheel position over the angle since the correction (mm over rad) that leaves the radius of the law. `target_mm` is r*.
    pub(super) fn by_the_law(&self, law: &ContactLaw, target_mm: f64, since_rad: f64) -> Sample {
        let ratio = law.grinding_n_mm() / law.machine_n_mm();
        let (now, before) = (self.fed(since_rad), self.fed(since_rad - TURN_RAD));
        let depth_mm = self.depth_mm;
        // r(u) falls by D w(u), and D (w(u) − w(u − 2π)) is cut there.
        let position = |now: f64, before: f64| -depth_mm * (now + ratio * (now - before));
        Sample {
            value: target_mm + depth_mm - law.threshold_n() / law.machine_n_mm() + position(now.value, before.value),
            first: position(now.first, before.first),
            second: position(now.second, before.second),
            third: position(now.third, before.third),
        }
    }

    /// Wheel position over the angle since the correction (mm over rad), fed from where the correction ended.
    pub(super) fn fed_from(&self, wheel_mm: f64, since_rad: f64) -> Sample {
        let (fed, depth_mm) = (self.fed(since_rad), self.depth_mm);
        Sample {
            value: wheel_mm - depth_mm * fed.value,
            first: -depth_mm * fed.first,
            second: -depth_mm * fed.second,
            third: -depth_mm * fed.third,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::unit_numbers;
    use alloc::string::ToString as _;

    const FINISHING: Finishing = Finishing { depth_mm: 0.012, turns: 3 };

    #[test]
    fn the_feed_is_smooth_and_its_derivatives_are_those_of_its_value() {
        let h = 1e-5;
        for step in 0..400_u32 {
            let at = 0.05 * f64::from(step) + 1e-3;
            let [low, here, high] = [at - h, at, at + h].map(|at| FINISHING.fed(at));
            assert!(((high.value - low.value) / (2.0 * h) - here.first).abs() < 1e-8, "{at}");
            assert!(((high.first - low.first) / (2.0 * h) - here.second).abs() < 1e-8, "{at}");
            assert!(((high.second - low.second) / (2.0 * h) - here.third).abs() < 1e-6, "{at}");
        }
        let middle = FINISHING.fed(1.5 * TURN_RAD);
        assert!((middle.value - 0.5).abs() < 1e-12 && FINISHING.fed(3.0 * TURN_RAD).value >= 1.0);
    }

    /// The law carried through all turns at places of the part leaves a circle of the target, and an even depth before.
    #[test]
    fn the_contact_law_leaves_a_circle_of_the_target() {
        for ratio in [0.1, 1.0, 7.0] {
            let law = ContactLaw::new(6_000.0, 6_000.0 * ratio, 16.0).expect("a law");
            for place in 0..90_u32 {
                let at = TURN_RAD * f64::from(place) / 90.0;
                let mut radius_mm = 20.0 + FINISHING.depth_mm;
                for turn in 0..FINISHING.all_turns() {
                    let wheel_mm = FINISHING.by_the_law(&law, 20.0, at + f64::from(turn) * TURN_RAD).value;
                    let after_mm = law.radius_after_mm(radius_mm, wheel_mm);
                    if turn == 1 && at > EASE_RAD && at < TURN_RAD - EASE_RAD {
                        let even_mm = FINISHING.depth_mm * TURN_RAD / (3.0 * TURN_RAD - EASE_RAD);
                        assert!((radius_mm - after_mm - even_mm).abs() < 1e-9, "{ratio} {place}");
                    }
                    radius_mm = after_mm;
                }
                assert!((radius_mm - 20.0).abs() < 1e-12, "{ratio} {place}: {radius_mm}");
            }
        }
    }

    /// kg = 30 N/µm, F0 = 16 N, and the same cut with kg times `harder`.
    fn law(harder: f64) -> ContactLaw {
        ContactLaw::new(6_000.0, 30_000.0 * harder, 16.0).expect("a law")
    }

    fn by_force(stock_mm: f64, force_n: f64) -> FinishingSpec {
        FinishingSpec::ByForce { stock_mm, force_n, max_turns: MAX_FINISHING_TURNS }
    }

    /// Grinds a part with `law` by the path for `planned`, at places all around: largest force (N), and the range of radii at the end (mm).
    fn ground(finishing: &Finishing, planned: &ContactLaw, law: &ContactLaw) -> (f64, (f64, f64)) {
        let (mut peak_n, mut low_mm, mut high_mm) = (0.0_f64, f64::INFINITY, f64::NEG_INFINITY);
        for place in 0..360_u32 {
            let at = TURN_RAD * f64::from(place) / 360.0;
            let mut radius_mm = 20.0 + finishing.depth_mm;
            for turn in 0..finishing.all_turns() {
                let wheel_mm = finishing.by_the_law(planned, 20.0, at + f64::from(turn) * TURN_RAD).value;
                peak_n = peak_n.max(law.force_n(law.deflection_mm(radius_mm - wheel_mm)));
                radius_mm = law.radius_after_mm(radius_mm, wheel_mm);
            }
            (low_mm, high_mm) = (low_mm.min(radius_mm), high_mm.max(radius_mm));
        }
        (peak_n, (low_mm, high_mm))
    }

    /// 12 µm at 120 N: U = 104/30 µm, and N − 1/4 ≥ 12/U = 3.46 with kg, 1.73 with half of it, 6.92 with twice.
    #[test]
    fn a_harder_part_gets_more_turns_at_the_same_force() {
        for (harder, turns) in [(0.5, 2), (1.0, 4), (2.0, 8)] {
            let law = law(harder);
            let finishing = by_force(0.012, 120.0).turns(&law).expect("turns");
            assert_eq!((finishing.turns, finishing.depth_mm), (turns, 0.012));
            let on_paper_n = 16.0 + harder * 30.0 * 12.0 / (f64::from(turns) - 0.25);
            assert!((finishing.peak_n(&law) - on_paper_n).abs() < 1e-9);
            let (peak_n, (low_mm, high_mm)) = ground(&finishing, &law, &law);
            assert!((peak_n - on_paper_n).abs() < 1e-6, "kg x{harder}: {peak_n} N, on paper {on_paper_n} N");
            // The next smaller number would exceed the force; so it is above (N − 5/4)/(N − 1/4) of the target.
            let fewer_n = Finishing { turns: turns - 1, ..finishing }.peak_n(&law);
            assert!(peak_n <= 120.0 && fewer_n > 120.0, "kg x{harder}: {peak_n} N, {fewer_n} N with a turn less");
            assert!((low_mm - 20.0).abs() < 1e-12 && (high_mm - 20.0).abs() < 1e-12, "kg x{harder}");
        }
        // At a depth per turn the force doubles with the part.
        let fixed = FinishingSpec::PerTurn { per_turn_mm: 0.004, turns: 3 };
        let cut_n = [1.0, 2.0].map(|harder| {
            let law = law(harder);
            ground(&fixed.turns(&law).expect("turns"), &law, &law).0 - 16.0
        });
        assert!((cut_n[1] / cut_n[0] - 2.0).abs() < 1e-9, "{cut_n:?}");
    }

    /// An error of kg changes the force of the cut by no more than its share, and the size by no more than its share of the deflection.
    #[test]
    fn the_force_is_off_by_no_more_than_the_measured_stiffness() {
        let measured = law(1.0);
        let finishing = by_force(0.012, 120.0).turns(&measured).expect("turns");
        for error in [-0.1, -0.03, 0.03, 0.1] {
            let (peak_n, (low_mm, high_mm)) = ground(&finishing, &measured, &law(1.0 + error));
            assert!(peak_n <= 16.0 + 104.0 * (1.0 + error.abs()), "{error}: {peak_n} N");
            let allowed_mm = error.abs() * (finishing.peak_n(&measured) - 16.0) / measured.machine_n_mm();
            let off_mm = (low_mm - 20.0).abs().max((high_mm - 20.0).abs());
            assert!(off_mm <= allowed_mm, "{error}: {off_mm} mm off, {allowed_mm} mm allowed");
        }
    }

    /// Seeded random contacts, stocks and forces: the number of turns is the smallest that keeps the force, and all stock is taken.
    #[test]
    fn random_contacts_are_finished_at_their_force_and_to_size() {
        let mut unit = unit_numbers(101);
        let mut cases = [0_u32; 3];
        for case in 0..400 {
            let kg_n_mm = libm::pow(10.0, 3.0 + 2.5 * unit());
            let law = ContactLaw::new(
                kg_n_mm * (0.05 + 2.0 * unit()),
                kg_n_mm,
                if unit() < 0.2 { 0.0 } else { 40.0 * unit() },
            );
            let law = law.expect("a law");
            let stock_mm = 1e-4 + 0.05 * unit() * unit();
            let force_n = law.threshold_n() + kg_n_mm * stock_mm * (1.2 * unit() - 0.05);
            match by_force(stock_mm, force_n).turns(&law) {
                Ok(finishing) => {
                    cases[0] += 1;
                    let (peak_n, (low_mm, high_mm)) = ground(&finishing, &law, &law);
                    let cut_n = force_n - law.threshold_n();
                    assert!(peak_n <= force_n + 1e-6 * cut_n, "case {case}: {peak_n} N for {force_n} N, {finishing:?}");
                    assert!(
                        (low_mm - 20.0).abs() < 1e-9 && (high_mm - 20.0).abs() < 1e-9,
                        "case {case}: {low_mm} {high_mm}"
                    );
                    let fewer = Finishing { turns: finishing.turns - 1, ..finishing };
                    assert!(fewer.turns == 0 || fewer.peak_n(&law) > force_n, "case {case}: {finishing:?}");
                }
                Err(FinishingError::NoCut { .. }) => {
                    cases[1] += 1;
                    assert!(force_n <= law.threshold_n(), "case {case}");
                }
                Err(FinishingError::TooManyTurns { turns, enough_n, .. }) => {
                    cases[2] += 1;
                    assert!(turns > f64::from(MAX_FINISHING_TURNS), "case {case}: {turns}");
                    let enough = by_force(stock_mm, enough_n * (1.0 + 1e-9)).turns(&law).expect("enough");
                    assert_eq!(enough.turns, MAX_FINISHING_TURNS, "case {case}");
                }
            }
        }
        assert!(cases.iter().all(|count| *count > 5), "{cases:?}");
    }

    #[test]
    fn forces_that_cannot_finish_are_refused_with_the_force_that_can() {
        let law = law(1.0);
        for force_n in [f64::NAN, f64::NEG_INFINITY, -1.0, 0.0, 15.9, 16.0] {
            let error = by_force(0.012, force_n).turns(&law).expect_err("it rubs");
            assert!(error.to_string().contains("the wheel begins to cut at 16.0 N"), "{error}");
        }
        // 4 N take 0.133 um; 12 um in 20 turns are 0.608 um at 34.2 N.
        let error = by_force(0.012, 20.0).turns(&law).expect_err("too many turns").to_string();
        for words in ["takes 0.133 um per turn", "12.0 um need 91 turns", "at most 20", "force_n to 34.3 or more"] {
            assert!(error.contains(words), "{words}: {error}");
        }
        let error = by_force(0.012, 16.0 + 1e-12).turns(&law).expect_err("far too many turns").to_string();
        assert!(error.contains("turns, at most 20"), "{error}");
        for force_n in [1e9, f64::INFINITY] {
            assert_eq!(by_force(0.012, force_n).turns(&law), Ok(Finishing { depth_mm: 0.012, turns: 1 }));
            // No turn takes more than a job may state.
            assert_eq!(by_force(0.12, force_n).turns(&law).map(|finishing| finishing.turns), Ok(3));
        }
    }
}
