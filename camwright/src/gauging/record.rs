// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Readings of a gauge, tagged with the angle of the headstock, and the actual depth of cut that lies between them.
//!
//! U = D0 − D1 as JTEKT's method has it, for every geometry of [`Gauge`] at any angular interval. Between readings the record is
//! interpolated by the polynomial of degree 5 through the six nearest: a record every 5° holds its third harmonic to 1e-6 of it, and
//! where an interval divides the span of the gauge there is nothing to interpolate.

use super::gauge::{Gauge, GaugeSide};
use crate::math::units::{deg_from_rad, rad_from_deg};
use alloc::vec::Vec;
use thiserror::Error;

/// Widest that two readings may lie apart (deg): half of the 30° that a twelfth harmonic takes. What is wider is a gap, not an
/// interval.
pub const LARGEST_GAP_DEG: f64 = 15.0;

/// Readings around a place that its value is interpolated from.
const NEIGHBOURS: usize = 6;

/// Rounding tolerance of a position outside a record (rad).
const ROUNDING_RAD: f64 = 1e-9;

/// A reading of a gauge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunoutReading {
    /// Angle of the headstock, growing from turn to turn (rad): the machine's counts times its rad per count. That at which the part stood
    /// when there was what is read now: a gauge of time constant τ lags by τ times the work speed.
    pub c_rad: f64,
    /// Reading of the gauge (mm), from any constant zero.
    pub value_mm: f64,
    pub tick: u64,
}

/// Why readings are no record.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum RecordError {
    /// Readings of one gauge where there are two, or of two where there is one.
    #[error("{given} record(s) given for {needed} gauge(s)")]
    Gauges { given: usize, needed: usize },
    /// Too few to interpolate.
    #[error("{which}: {count} readings, at least {min} are needed")]
    TooFew { which: GaugeSide, count: usize, min: usize },
    /// A number that is none: a gauge that lost the part, or a broken one.
    #[error("{which}, reading {index} (tick {tick}): angle or value is not a finite number")]
    NotFinite {
        which: GaugeSide,
        /// Index of the reading.
        index: usize,
        tick: u64,
    },
    /// The part stood, or turned back.
    #[error(
        "{which}, reading {index} (tick {tick}): C at {c_deg:.4} deg is not beyond {previous_deg:.4} deg of the reading before"
    )]
    NotIncreasing {
        which: GaugeSide,
        /// Index of the reading.
        index: usize,
        tick: u64,
        /// Its angle (deg).
        c_deg: f64,
        /// That of the reading before (deg).
        previous_deg: f64,
    },
    #[error(
        "{which}, reading {index} (tick {tick}): {gap_deg:.3} deg after the one before, at most {largest_deg} deg are allowed"
    )]
    Gap {
        which: GaugeSide,
        /// Index of the reading.
        index: usize,
        tick: u64,
        /// Distance (deg).
        gap_deg: f64,
        /// Largest (deg).
        largest_deg: f64,
    },
    /// No cut has a reading before and one after it.
    #[error("readings over {turned_deg:.2} deg see no cut before and after: more than {needed_deg:.2} deg are needed")]
    SeesNoCut {
        /// Angle from the first reading to the last (deg).
        turned_deg: f64,
        /// Span of the gauge (deg).
        needed_deg: f64,
    },
}

/// Depth of cut at one position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthOfCut {
    /// Angle of the headstock at the cut (rad); modulo a turn the phase that was cut.
    pub c_rad: f64,
    /// U (mm). Of a radial probe that feels the part deflect it holds the change of that too.
    pub depth_mm: f64,
    /// Angle of the headstock at which it was known (rad).
    pub known_at_rad: f64,
}

/// Readings that are known to be a record of a gauge.
#[derive(Debug, Clone, Copy)]
pub struct GaugeRecord<'a> {
    gauge: Gauge,
    before: &'a [RunoutReading],
    after: &'a [RunoutReading],
}

impl<'a> GaugeRecord<'a> {
    /// The record of one gauge, in the order of its ticks.
    ///
    /// # Errors
    /// Two gauges; too few readings, numbers that are none, a part that stood or turned back, gaps, less than a span of the gauge.
    pub fn from_one(gauge: Gauge, readings: &'a [RunoutReading]) -> Result<Self, RecordError> {
        if gauge.is_two() {
            return Err(RecordError::Gauges { given: 1, needed: 2 });
        }
        checked(GaugeSide::First, readings)?;
        Self { gauge, before: readings, after: readings }.sees_a_cut()
    }

    /// The records of two gauges.
    ///
    /// # Errors
    /// One gauge; otherwise as [`GaugeRecord::from_one`].
    pub fn from_two(
        gauge: Gauge,
        first: &'a [RunoutReading],
        second: &'a [RunoutReading],
    ) -> Result<Self, RecordError> {
        if !gauge.is_two() {
            return Err(RecordError::Gauges { given: 2, needed: 1 });
        }
        checked(GaugeSide::First, first)?;
        checked(GaugeSide::Second, second)?;
        Self { gauge, before: first, after: second }.sees_a_cut()
    }

    fn sees_a_cut(self) -> Result<Self, RecordError> {
        if self.last_cut_rad() > self.first_cut_rad() {
            return Ok(self);
        }
        Err(RecordError::SeesNoCut {
            turned_deg: deg_from_rad(self.after[self.after.len() - 1].c_rad - self.before[0].c_rad),
            needed_deg: deg_from_rad(self.gauge.span_rad()),
        })
    }

    #[must_use]
    pub const fn gauge(&self) -> &Gauge {
        &self.gauge
    }

    /// Angle of the headstock of the first cut whose depth is known (rad).
    #[must_use]
    pub fn first_cut_rad(&self) -> f64 {
        let before = self.gauge.cut_following_rad(self.before[0].c_rad);
        before.max(self.gauge.cut_seen_rad(self.after[0].c_rad))
    }

    /// Angle of the headstock of the last cut whose depth is known (rad).
    #[must_use]
    pub fn last_cut_rad(&self) -> f64 {
        let before = self.gauge.cut_following_rad(self.before[self.before.len() - 1].c_rad);
        before.min(self.gauge.cut_seen_rad(self.after[self.after.len() - 1].c_rad))
    }

    /// Angle of the headstock at the last reading (rad).
    #[must_use]
    pub fn end_rad(&self) -> f64 {
        self.after[self.after.len() - 1].c_rad
    }

    /// Readings per turn, in the mean.
    #[must_use]
    pub fn per_turn(&self) -> f64 {
        let (first, last) = (self.before[0].c_rad, self.before[self.before.len() - 1].c_rad);
        let intervals = (self.before.len() - 1) as f64;
        intervals * crate::math::units::TURN_RAD / (last - first)
    }

    /// U of the cut at an angle of the headstock (mm); nothing where the record does not reach.
    #[must_use]
    pub fn depth_mm(&self, cut_rad: f64) -> Option<f64> {
        let before_rad = cut_rad - self.gauge.cut_after_rad();
        let before_mm = interpolated(self.before, before_rad)?;
        let after_mm = interpolated(self.after, before_rad + self.gauge.span_rad())?;
        Some(before_mm - (after_mm - self.gauge.zero_difference_mm()))
    }

    /// Readings with the angles after the wheel at which they were taken, and what they read too much (mm).
    pub(super) fn sources(&self) -> impl Iterator<Item = ([Option<f64>; 2], &'a [RunoutReading], f64)> {
        let first = (self.gauge.contacts_rad(GaugeSide::First), self.before, 0.0);
        let second = (self.gauge.contacts_rad(GaugeSide::Second), self.after, self.gauge.zero_difference_mm());
        core::iter::once(first).chain(self.gauge.is_two().then_some(second))
    }

    /// U of the cut that follows every reading, as far as the record reaches.
    #[must_use]
    pub fn depths(&self) -> Vec<DepthOfCut> {
        let cuts = self.before.iter().map(|reading| self.gauge.cut_following_rad(reading.c_rad));
        cuts.filter_map(|c_rad| {
            let known_at_rad = c_rad + self.gauge.known_after_rad();
            self.depth_mm(c_rad).map(|depth_mm| DepthOfCut { c_rad, depth_mm, known_at_rad })
        })
        .collect()
    }
}

/// Checks that readings are in order.
fn checked(which: GaugeSide, readings: &[RunoutReading]) -> Result<(), RecordError> {
    if readings.len() < NEIGHBOURS {
        return Err(RecordError::TooFew { which, count: readings.len(), min: NEIGHBOURS });
    }
    let largest_rad = rad_from_deg(LARGEST_GAP_DEG) + ROUNDING_RAD;
    for (index, reading) in readings.iter().enumerate() {
        let RunoutReading { c_rad, value_mm, tick } = *reading;
        if !(c_rad.is_finite() && value_mm.is_finite()) {
            return Err(RecordError::NotFinite { which, index, tick });
        }
        let Some(previous) = index.checked_sub(1).map(|before| readings[before].c_rad) else { continue };
        if c_rad <= previous {
            let (c_deg, previous_deg) = (deg_from_rad(c_rad), deg_from_rad(previous));
            return Err(RecordError::NotIncreasing { which, index, tick, c_deg, previous_deg });
        }
        if c_rad - previous > largest_rad {
            let gap_deg = deg_from_rad(c_rad - previous);
            return Err(RecordError::Gap { which, index, tick, gap_deg, largest_deg: LARGEST_GAP_DEG });
        }
    }
    Ok(())
}

/// A value between readings, by Lagrange's polynomial through the nearest.
fn interpolated(readings: &[RunoutReading], c_rad: f64) -> Option<f64> {
    let (first, last) = (readings[0].c_rad, readings[readings.len() - 1].c_rad);
    if !(c_rad >= first - ROUNDING_RAD && c_rad <= last + ROUNDING_RAD) {
        return None;
    }
    let right = readings.partition_point(|reading| reading.c_rad < c_rad);
    let from = right.saturating_sub(NEIGHBOURS / 2).min(readings.len() - NEIGHBOURS);
    let near = &readings[from..from + NEIGHBOURS];
    // From the first of them, so that a diameter of 40 mm does not cost the digits of a depth of 1 um.
    let level = near[0].value_mm;
    let mut sum = 0.0;
    for (i, reading) in near.iter().enumerate() {
        let mut weight = 1.0;
        for (j, other) in near.iter().enumerate() {
            if i != j {
                weight *= (c_rad - other.c_rad) / (reading.c_rad - other.c_rad);
            }
        }
        sum += weight * (reading.value_mm - level);
    }
    Some(level + sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    fn every(step_deg: f64, count: u32, value: impl Fn(f64) -> f64) -> Vec<RunoutReading> {
        (0..count)
            .map(|i| {
                let c_rad = rad_from_deg(f64::from(i) * step_deg);
                RunoutReading { c_rad, value_mm: value(c_rad), tick: u64::from(i) }
            })
            .collect()
    }

    #[test]
    fn records_that_are_none_are_refused() {
        let gauge = Gauge::diameter(1.5 * PI).unwrap();
        let two = Gauge::two_diameters(1.8 * PI, 1.0, 0.0).unwrap();
        let good = every(1.0, 400, |_| 40.0);
        assert!(GaugeRecord::from_one(gauge, &good).is_ok());
        let refused = |readings: &[RunoutReading]| GaugeRecord::from_one(gauge, readings).unwrap_err();
        assert_eq!(GaugeRecord::from_one(two, &good).unwrap_err(), RecordError::Gauges { given: 1, needed: 2 });
        assert_eq!(
            GaugeRecord::from_two(gauge, &good, &good).unwrap_err(),
            RecordError::Gauges { given: 2, needed: 1 }
        );
        assert!(matches!(refused(&good[..5]), RecordError::TooFew { count: 5, .. }));
        assert!(matches!(refused(&good[..181]), RecordError::SeesNoCut { .. }));
        let mut broken = good.clone();
        broken[17].value_mm = f64::NAN;
        assert_eq!(refused(&broken), RecordError::NotFinite { which: GaugeSide::First, index: 17, tick: 17 });
        let mut back = good.clone();
        back[20].c_rad = back[19].c_rad;
        assert!(matches!(refused(&back), RecordError::NotIncreasing { index: 20, .. }));
        let mut gap = good.clone();
        gap.drain(30..45);
        assert!(matches!(refused(&gap), RecordError::Gap { index: 30, .. }));
        let second = GaugeRecord::from_two(two, &good, &broken).unwrap_err();
        assert_eq!(
            alloc::format!("{second}"),
            "second gauge, reading 17 (tick 17): angle or value is not a finite number"
        );
    }

    #[test]
    fn readings_of_a_polynomial_are_interpolated_exactly() {
        let readings = every(7.3, 60, |c| 40.0 + 1e-3 * c * (1.0 - 0.2 * c * (1.0 - 0.1 * c)));
        for i in 0..1000 {
            let c = f64::from(i) * readings[59].c_rad / 999.0;
            let wanted = 40.0 + 1e-3 * c * (1.0 - 0.2 * c * (1.0 - 0.1 * c));
            let found = interpolated(&readings, c).unwrap();
            assert!((found - wanted).abs() < 1e-13, "{c}: {found} {wanted}");
        }
        assert_eq!(interpolated(&readings, -1e-6), None);
        assert_eq!(interpolated(&readings, readings[59].c_rad + 1e-6), None);
    }
}
