// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The log of a journal as the record of its gauge, or of its two.

use super::gauge::Gauge;
use super::gauged_tick::GaugedTick;
use super::record::{GaugeRecord, RecordError, RunoutReading};
use alloc::vec::Vec;

/// Gauge that measures a machine's journals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaugeSetup {
    /// The gauge, or the two.
    pub gauge: Gauge,
    /// For two gauges: the cut lies after the machine's second and before its first, not the other way round.
    pub exchanged: bool,
    /// Time constant of the amplifier (s), 0 for none.
    pub lag_s: f64,
    /// Interpolation period (s).
    pub cycle_time_s: f64,
}

/// Readings of the first gauge and, where there are two, of the second.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Readings {
    pub(super) first: Vec<RunoutReading>,
    second: Vec<RunoutReading>,
}

impl Readings {
    /// Converts the readings into the record of a gauge.
    pub(super) fn record(&self, gauge: Gauge) -> Result<GaugeRecord<'_>, RecordError> {
        match gauge.is_two() {
            true => GaugeRecord::from_two(gauge, &self.first, &self.second),
            false => GaugeRecord::from_one(gauge, &self.first),
        }
    }

    /// Those up to an angle (rad).
    pub(super) fn until(&self, until_rad: f64) -> Self {
        let until = |readings: &[RunoutReading]| {
            readings.iter().copied().filter(|reading| reading.c_rad <= until_rad).collect()
        };
        Self { first: until(&self.first), second: until(&self.second) }
    }
}

impl GaugeSetup {
    /// Readings at the angles that they belong to, up to an angle (rad): an amplifier of first order shows what there was a time constant
    /// ago. Where C stands or an encoder lets it seem to, the later one is omitted. A reading of a second gauge that is missing is no
    /// number.
    pub(super) fn readings(&self, gauged: &[GaugedTick], until_rad: f64) -> Readings {
        let two = self.gauge.is_two();
        let count = |wanted: bool| if wanted { gauged.len() } else { 0 };
        let mut readings = Readings { first: Vec::with_capacity(gauged.len()), second: Vec::with_capacity(count(two)) };
        for pair in gauged.windows(2) {
            let (before, now) = (pair[0], pair[1]);
            let c_rad = now.c_rad - (now.c_rad - before.c_rad) / self.cycle_time_s * self.lag_s;
            if c_rad > until_rad || readings.first.last().is_some_and(|last| c_rad <= last.c_rad) {
                continue;
            }
            let (own_mm, other_mm) = (now.value_mm, now.second_mm.unwrap_or(f64::NAN));
            let (first_mm, second_mm) = if self.exchanged { (other_mm, own_mm) } else { (own_mm, other_mm) };
            readings.first.push(RunoutReading { c_rad, value_mm: first_mm, tick: now.tick });
            if two {
                readings.second.push(RunoutReading { c_rad, value_mm: second_mm, tick: now.tick });
            }
        }
        readings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauging::gauge::GaugeSide;
    use core::f64::consts::PI;

    fn log(second_mm: impl Fn(u64) -> Option<f64>) -> Vec<GaugedTick> {
        let at = |tick: u64| GaugedTick {
            tick,
            c_rad: tick as f64 * PI / 180.0,
            x_mm: 20.0,
            value_mm: 40.0 + tick as f64,
            second_mm: second_mm(tick),
            motor_n: 0.0,
        };
        (0..720).map(at).collect()
    }

    #[test]
    fn two_gauges_are_read_in_the_order_in_which_the_cut_comes_between_them() {
        let gauge = Gauge::two_diameters(1.5 * PI, 0.9 * PI, 0.0).unwrap();
        let seen = GaugeSetup { gauge, exchanged: false, lag_s: 0.0, cycle_time_s: 1e-3 };
        let readings = seen.readings(&log(|tick| Some(-(tick as f64))), f64::INFINITY);
        assert!(readings.first[0].value_mm > 40.0 && readings.second[0].value_mm < 0.0);
        assert!(readings.record(gauge).is_ok());
        let other = GaugeSetup { exchanged: true, ..seen };
        let exchanged = other.readings(&log(|tick| Some(-(tick as f64))), f64::INFINITY);
        assert_eq!((exchanged.first, exchanged.second), (readings.second, readings.first));
        // A second that fails once is no record.
        let lost = seen.readings(&log(|tick| (tick != 300).then_some(1.0)), f64::INFINITY);
        let error = lost.record(gauge).unwrap_err();
        assert!(matches!(error, RecordError::NotFinite { which: GaugeSide::Second, tick: 300, .. }), "{error:?}");
    }
}
