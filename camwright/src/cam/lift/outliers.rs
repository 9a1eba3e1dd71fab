// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Rows and jumps that the lift around them does not bear out.
//!
//! With the fourth difference δ⁴y, r(k) = δ⁴y(k)/6 is the distance of row k from the cubic through the two rows on either
//! side. One bad row with error J gives (…, J/6, −2J/3, J, −2J/3, J/6, …), a step of height J gives (−J/6, −J/2, J/2,
//! J/6); the neighbours distinguish the two. Rounding gives at most 4/3 of a digit, a jump of the acceleration a sixth of
//! a second difference, a smooth law next to nothing. Allowed are
//!
//! ```text
//!   2 digits + 6 · 1.4826 · MAD(r) + ½ · max(second differences: 90 % quantile of the table, upper median of the eight
//!                                            around the row that do not contain it)
//! ```
//!
//! None of the three scales is moved by the fault itself, and a steep flank raises its own allowance and no other. The
//! worst row is taken out (or the step is cut) and the rest looked at again, so that one fault does not hide another.

use alloc::vec;
use alloc::vec::Vec;

/// Something off the trend, in units of the last digit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum RowDeviation {
    Row {
        at: usize,
        /// Deviation.
        off: f64,
        bound: f64,
    },
    /// Everything from a slot on.
    Jump {
        /// The first slot after the jump.
        at: usize,
        height: f64,
        bound: f64,
    },
}

/// Most faults looked for in one table; who has that many has another problem.
const MAX_OUTLIERS: usize = 200;

/// A second difference of the law itself shows in r as at most a sixth where the acceleration jumps; a flank of eight
/// blocks brings a third at its ends. A half leaves room; a whole digit more of it would hide what people mistype.
const SHARE: f64 = 0.5;

/// From this many rows per turn on [`SHARE`] holds; coarser tables say less about themselves.
const FINE: f64 = 72.0;

/// A normal distribution's standard deviation over its median absolute deviation.
const SIGMA_PER_MAD: f64 = 1.4826;

/// Deviations from the trend in a sequence of slots, `closed` if the last is followed by the first; `digits` is the
/// resolution in units of the last digit.
pub(super) fn deviations(lifts: &[Option<i64>], closed: bool, digits: f64) -> Vec<RowDeviation> {
    let mut found = Vec::new();
    if lifts.len() < super::table::LiftTable::MIN_BLOCKS {
        return found;
    }
    let values = lifts.iter().map(|lift| lift.map_or(f64::NAN, |units| units as f64)).collect();
    let mut series = LiftSequence { values, cut: vec![false; lifts.len()], closed };
    let coarse = (FINE / lifts.len() as f64).max(1.0);
    while found.len() < MAX_OUTLIERS {
        let Some(worst) = series.worst(digits, SHARE * coarse * coarse) else { break };
        found.push(series.remove(worst));
    }
    found
}

/// The worst row and how bad it is.
struct Worst {
    at: usize,
    off: f64,
    bound: f64,
}

struct LiftSequence {
    /// Lift at each slot; not a number where there is none.
    values: Vec<f64>,
    /// A step has been found between the slot before and this one.
    cut: Vec<bool>,
    closed: bool,
}

impl LiftSequence {
    fn index(&self, from: usize, offset: isize) -> Option<usize> {
        let n = self.values.len();
        let index =
            from.checked_add_signed(offset).or_else(|| self.closed.then(|| from + n - offset.unsigned_abs()))?;
        if index < n { Some(index) } else { self.closed.then(|| index % n) }
    }

    /// Returns whether the slots from `from − reach` to `from + reach` are connected.
    fn is_joined(&self, from: usize, reach: isize) -> bool {
        (1 - reach..=reach).all(|offset| self.index(from, offset).is_some_and(|index| !self.cut[index]))
    }

    fn at(&self, from: usize, offset: isize) -> f64 {
        self.index(from, offset).map_or(f64::NAN, |index| self.values[index])
    }

    /// Size of the second difference at each slot; not a number where a neighbour is missing.
    fn second(&self) -> Vec<f64> {
        (0..self.values.len())
            .map(|k| {
                if self.is_joined(k, 1) {
                    (self.at(k, 1) - 2.0 * self.at(k, 0) + self.at(k, -1)).abs()
                } else {
                    f64::NAN
                }
            })
            .collect()
    }

    /// Distance of each slot from the cubic through its neighbours.
    fn off_trend(&self) -> Vec<f64> {
        (0..self.values.len())
            .map(|k| {
                if self.is_joined(k, 2) {
                    let ends = self.at(k, -2) + self.at(k, 2);
                    self.at(k, 0) + (ends - 4.0 * (self.at(k, -1) + self.at(k, 1))) / 6.0
                } else {
                    f64::NAN
                }
            })
            .collect()
    }

    fn worst(&self, digits: f64, share: f64) -> Option<Worst> {
        let (off, second) = (self.off_trend(), self.second());
        let finite = |values: &[f64]| -> Vec<f64> {
            let mut finite: Vec<f64> =
                values.iter().map(|value| value.abs()).filter(|value| value.is_finite()).collect();
            finite.sort_by(f64::total_cmp);
            finite
        };
        let quantile = |sorted: &[f64], tenths: usize| sorted.get(tenths * sorted.len() / 10).copied().unwrap_or(0.0);
        let (sizes, seconds) = (finite(&off), finite(&second));
        let noise = 6.0 * SIGMA_PER_MAD * quantile(&sizes, 5);
        let overall = quantile(&seconds, 9);
        let mut worst: Option<Worst> = None;
        let mut ratio = 1.0;
        for (at, &off) in off.iter().enumerate().filter(|(_, off)| off.is_finite()) {
            let floor = 2.0 * digits + noise + share * overall;
            if off.abs() <= ratio * floor {
                continue;
            }
            let around = [-5, -4, -3, -2, 2, 3, 4, 5]
                .map(|offset| self.index(at, offset).map_or(f64::NAN, |index| second[index]));
            let around = finite(&around);
            let local = around.get(around.len() / 2).copied().unwrap_or(0.0);
            let bound = 2.0 * digits + noise + share * overall.max(local);
            if off.abs() > ratio * bound {
                ratio = off.abs() / bound;
                worst = Some(Worst { at, off, bound });
            }
        }
        worst
    }

    /// Reports the deviation, and repairs it for the next pass.
    fn remove(&mut self, worst: Worst) -> RowDeviation {
        let Worst { at, off, bound } = worst;
        let trend = self.off_trend();
        let beside = |offset| self.index(at, offset).map_or(f64::NAN, |index| trend[index]);
        let (before, after) = (beside(-1), beside(1));
        if (before - after).abs() > off.abs() / 3.0 {
            // The larger neighbour stands on the other side of the step.
            let (jump, height) =
                if before.abs() > after.abs() { (Some(at), 2.0 * off) } else { (self.index(at, 1), -2.0 * off) };
            if let Some(jump) = jump {
                self.cut[jump] = true;
                return RowDeviation::Jump { at: jump, height, bound: 2.0 * bound };
            }
        }
        self.values[at] -= off;
        RowDeviation::Row { at, off, bound }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize) -> Vec<Option<i64>> {
        let value = |i: usize| 1000.0 * (1.0 - libm::cos(i as f64 * core::f64::consts::TAU / n as f64));
        #[allow(clippy::cast_possible_truncation, reason = "at most 2000")]
        (0..n).map(|i| Some(libm::round(value(i)) as i64)).collect()
    }

    #[test]
    fn one_row_is_one_deviation_of_its_own_size() {
        for at in [0, 1, 77, 359] {
            let mut lifts = wave(360);
            lifts[at] = lifts[at].map(|lift| lift - 40);
            let found = deviations(&lifts, true, 1.0);
            assert!(
                matches!(found[..], [RowDeviation::Row { at: slot, off, .. }] if slot == at && (off + 40.0).abs() < 2.0),
                "{at}: {found:?}"
            );
        }
    }

    #[test]
    fn a_step_up_and_a_step_down_are_two_jumps() {
        let mut lifts = wave(360);
        lifts[100..200].iter_mut().for_each(|lift| *lift = lift.map(|lift| lift + 40));
        let mut found = deviations(&lifts, true, 1.0);
        found.sort_by_key(|found| if let RowDeviation::Jump { at, .. } = found { *at } else { 0 });
        assert!(
            matches!(found[..], [RowDeviation::Jump { at: 100, height: up, .. }, RowDeviation::Jump { at: 200, height: down, .. }]
                if (up - 40.0).abs() < 2.0 && (down + 40.0).abs() < 2.0),
            "{found:?}"
        );
    }

    /// A missing row is no fault here, and does not hide the next but two.
    #[test]
    fn gaps_are_gone_round() {
        let mut lifts = wave(360);
        (lifts[50], lifts[53]) = (None, lifts[53].map(|lift| lift + 30));
        assert!(matches!(deviations(&lifts, true, 1.0)[..], [RowDeviation::Row { at: 53, .. }]));
        assert_eq!(deviations(&wave(360)[20..120], false, 1.0), []);
    }
}
