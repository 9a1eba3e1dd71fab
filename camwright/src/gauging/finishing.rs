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

use crate::machine::contact_law::ContactLaw;
use crate::math::hermite::Sample;
use crate::math::units::TURN_RAD;

/// Angle over which the feed begins, and over which it ends (rad).
const EASE_RAD: f64 = TURN_RAD / 4.0;

/// Finishing turns after a correction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finishing {
    /// Depth of a turn (mm).
    pub per_turn_mm: f64,
    /// Turns with feed. One turn without feed follows.
    pub turns: u32,
}

/// Most finishing turns.
pub const MAX_FINISHING_TURNS: u32 = 20;

/// Largest depth of a finishing turn (mm).
pub const MAX_FINISHING_MM: f64 = 0.05;

impl Finishing {
    /// Depth of all turns together (mm).
    #[must_use]
    pub fn depth_mm(&self) -> f64 {
        f64::from(self.turns) * self.per_turn_mm
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
        let depth_mm = self.depth_mm();
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
        let (fed, depth_mm) = (self.fed(since_rad), self.depth_mm());
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

    const FINISHING: Finishing = Finishing { per_turn_mm: 0.004, turns: 3 };

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
                let mut radius_mm = 20.0 + FINISHING.depth_mm();
                for turn in 0..FINISHING.all_turns() {
                    let wheel_mm = FINISHING.by_the_law(&law, 20.0, at + f64::from(turn) * TURN_RAD).value;
                    let after_mm = law.radius_after_mm(radius_mm, wheel_mm);
                    if turn == 1 && at > EASE_RAD && at < TURN_RAD - EASE_RAD {
                        let even_mm = FINISHING.depth_mm() * TURN_RAD / (3.0 * TURN_RAD - EASE_RAD);
                        assert!((radius_mm - after_mm - even_mm).abs() < 1e-9, "{ratio} {place}");
                    }
                    radius_mm = after_mm;
                }
                assert!((radius_mm - 20.0).abs() < 1e-12, "{ratio} {place}: {radius_mm}");
            }
        }
    }
}
