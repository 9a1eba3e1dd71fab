// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lines of `halsampler` and `halstreamer`.

use crate::connection::{AT_SPEED, ESTOP, FAULTS, GAUGE, HOMES, INDEXES, LIMITS, ORIGIN, SAMPLER_COLUMNS};
use camwright::machine::description::{AXIS_COUNT, AxisScale, MachineDescription};
use camwright::simulation::measured::{DriveOrders, Measurement, WiredInputs};
use camwright_files::hal_file::HalConfig;
use std::fmt::Write as _;

/// A line of `halsampler -t`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ServoSample {
    /// Number of the servo period.
    pub(crate) period: u32,
    /// Number of the setpoint that the drives follow; 0 before the first.
    pub(crate) sequence: u32,
    pub(crate) queued: u32,
    /// Deviation of this servo period from its length (ns).
    pub(crate) jitter_ns: u32,
    pub(crate) measurement: Measurement,
    pub(crate) is_estop: bool,
    pub(crate) drive_faults: u8,
}

/// Units of the pins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PinScale {
    /// Counts for one unit of the pin.
    counts: [f64; AXIS_COUNT],
    /// Axes with index marks.
    has_index: [bool; AXIS_COUNT],
    /// Gauges with a pin.
    has_gauge: [bool; 2],
    /// A bit reports that the gauges measure.
    has_valid: bool,
}

impl PinScale {
    pub(crate) fn new(hal: &HalConfig, machine: &MachineDescription) -> Self {
        let counts = |i: usize| {
            let counts_per_unit = match machine.axes[i].scale {
                AxisScale::Rotary { counts_per_turn } => counts_per_turn as f64 / 360.0,
                AxisScale::Linear { counts_per_mm } => counts_per_mm as f64,
            };
            counts_per_unit / hal.axes[i].scale
        };
        let gauge = hal.gauge.as_ref();
        Self {
            counts: core::array::from_fn(counts),
            has_index: core::array::from_fn(|i| hal.axes[i].index.is_some()),
            has_gauge: [gauge.is_some(), gauge.is_some_and(|gauge| gauge.second_reading.is_some())],
            has_valid: gauge.is_some_and(|gauge| gauge.valid.is_some()),
        }
    }

    /// Reads a line of `halsampler -t`.
    ///
    /// # Errors
    /// A line that is none.
    #[allow(clippy::cast_possible_truncation, reason = "positions beyond i64 saturate; words are masked")]
    pub(crate) fn read(&self, line: &str) -> Result<ServoSample, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [period, sequence, queued, c, x, z, inputs, stations, jitter, since @ .., first, second] = words.as_slice()
        else {
            return Err(unreadable(line));
        };
        let since_marks: &[&str; AXIS_COUNT] = since.try_into().map_err(|_| unreadable(line))?;
        let whole = |word: &str| word.parse::<i64>().map_err(|_| format!("halsampler printed {word:?} for a number"));
        let position = |index: usize, word: &str| match word.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok((value * self.counts[index]).round() as i64),
            _ => Err(format!("halsampler printed {word:?} for a position")),
        };
        let (inputs, stations) = (whole(inputs)? as u32, whole(stations)? as u16);
        let bits = |first: u32| (inputs >> first & 0b111) as u8;
        let wired = WiredInputs {
            origin: inputs >> ORIGIN & 1 == 1,
            stations: u64::from(stations),
            homes: bits(HOMES),
            limits: bits(LIMITS),
            wheel_at_speed: inputs >> AT_SPEED & 1 == 1,
        };
        let counts = [position(0, c)?, position(1, x)?, position(2, z)?];
        let mut marks = [None; AXIS_COUNT];
        for i in (0..AXIS_COUNT).filter(|i| self.has_index[*i] && bits(INDEXES) >> i & 1 == 0) {
            marks[i] = Some(counts[i].saturating_sub(position(i, since_marks[i])?));
        }
        // A reading that is no number is one: the machine raises its alarm.
        let is_measuring = !self.has_valid || inputs >> GAUGE & 1 == 1;
        let reading = |has_gauge: bool, word: &str| match word.parse::<f64>() {
            Ok(mm) => Ok(Some(mm).filter(|_| has_gauge && is_measuring)),
            Err(_) => Err(format!("halsampler printed {word:?} for a reading of the gauge")),
        };
        let gauge_mm = [reading(self.has_gauge[0], first)?, reading(self.has_gauge[1], second)?];
        Ok(ServoSample {
            period: whole(period)? as u32,
            sequence: whole(sequence)? as u32,
            queued: u32::try_from(whole(queued)?).unwrap_or(0),
            jitter_ns: u32::try_from(whole(jitter)?).unwrap_or(0),
            measurement: Measurement { counts, inputs: wired, marks, gauge_mm },
            is_estop: inputs >> ESTOP & 1 == 1,
            drive_faults: bits(FAULTS),
        })
    }

    /// Writes a line for `halstreamer`.
    pub(crate) fn write(&self, sequence: u32, orders: &DriveOrders, line: &mut String) {
        line.clear();
        let bit = |on: bool| u8::from(on);
        let [c, x, z] = core::array::from_fn(|i| orders.positions[i] / self.counts[i]);
        let [c_on, x_on, z_on] = core::array::from_fn(|i| bit(orders.powered >> i & 1 == 1));
        let (run, rpm) = (bit(orders.wheel_runs), orders.wheel_rad_s * 60.0 / core::f64::consts::TAU);
        // A string takes everything.
        let _infallible = writeln!(line, "{sequence} {c} {x} {z} {c_on} {x_on} {z_on} {run} {rpm}");
    }
}

fn unreadable(line: &str) -> String {
    format!("halsampler printed {line:?}; {} columns are expected", 1 + SAMPLER_COLUMNS.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hal_file_text::tests::{grinder, grinder_with_index, with_hal};

    #[test]
    fn a_position_returns_to_the_count_after_the_six_decimals_of_the_sampler() {
        let (machine, hal) = grinder();
        let scale = PinScale::new(&hal, &machine);
        let mut line = String::new();
        for counts in [0_i64, 1, -1, 12_345_678, -98_765_432, 1_800_000_001] {
            let orders = DriveOrders { positions: [counts as f64; 3], powered: 0b101, ..DriveOrders::default() };
            scale.write(7, &orders, &mut line);
            let words: Vec<&str> = line.split_whitespace().collect();
            let printed: Vec<String> =
                words[1..4].iter().map(|word| format!("{:.6}", word.parse::<f64>().expect("a number"))).collect();
            assert_eq!(&words[4..8], ["1", "0", "1", "0"]);
            let sample = scale.read(&format!("99 7 40 {} 1073 3 8500 0 0 0 0 0", printed.join(" "))).expect("a sample");
            assert_eq!(sample.measurement.counts, [counts; 3], "{line}");
            assert_eq!((sample.period, sample.sequence, sample.queued, sample.jitter_ns), (99, 7, 40, 8500));
            // 1073: emergency stop, at speed, origin, limit of X.
            let wired = sample.measurement.inputs;
            assert!(sample.is_estop && sample.drive_faults == 0 && wired.wheel_at_speed && wired.origin);
            assert_eq!((wired.homes, wired.limits, wired.stations), (0, 0b010, 3));
        }
    }

    /// X has index marks, with a bit of the word of inputs that is off in the period of a mark.
    #[test]
    fn an_index_mark_lies_where_the_encoder_began_to_count_anew() {
        let (machine, hal) = grinder_with_index();
        let scale = PinScale::new(&hal, &machine);
        let marks = |line: &str| scale.read(line).expect("a sample").measurement.marks;
        let waiting = 1 << (INDEXES + 1);
        assert_eq!(marks(&format!("1 2 3 0 144.012340 0 {waiting} 0 0 0 0.012340 0 0 0")), [None; AXIS_COUNT]);
        assert_eq!(marks("1 2 3 0 144.012340 0 0 0 0 7 0.012340 7 0 0"), [None, Some(14_400_000), None]);
        assert_eq!(marks("1 2 3 0 -8.000010 0 0 0 0 0 -0.000010 0 0 0"), [None, Some(-800_000), None]);
        let (machine, hal) = grinder();
        let sample = PinScale::new(&hal, &machine).read("1 2 3 0 144 0 0 0 0 0 0 0 0 0").expect("a sample");
        assert_eq!(sample.measurement.marks, [None; AXIS_COUNT]);
    }

    /// Readings are those of HAL, in mm, while the bit is on; a second gauge without a pin has none.
    #[test]
    fn a_gauge_is_read_while_it_measures() {
        let bits = |line: &str, overrides: &[&str]| {
            let (machine, hal) = with_hal(overrides);
            let sample = PinScale::new(&hal, &machine).read(line).expect("a sample");
            sample.measurement.gauge_mm.map(|mm| mm.map(f64::to_bits))
        };
        let valid = 1 << GAUGE;
        let on = format!("1 2 3 0 0 0 {valid} 0 0 0 0 0 20.123457 -0.000001");
        let off = "1 2 3 0 0 0 32767 0 0 0 0 0 20.123457 -0.000001";
        let [first, second] = [20.123_457_f64, -0.000_001].map(|mm| Some(mm.to_bits()));
        assert_eq!(bits(&on, &[]), [first, None]);
        assert_eq!(bits(off, &[]), [None, None]);
        let two =
            ["gauge.kind=diameter", "gauge.second_behind_wheel_deg=210", "hal.gauge={reading: a, second_reading: b}"];
        assert_eq!(bits(off, &two), [first, second], "without a bit it always measures");
        assert_eq!(bits(&on, &["gauge=null", "hal.gauge=null"]), [None, None]);
        let (machine, hal) = grinder();
        let broken = PinScale::new(&hal, &machine).read(&on.replace("20.123457", "-nan")).expect("a sample");
        assert!(broken.measurement.gauge_mm[0].is_some_and(f64::is_nan));
    }

    #[test]
    fn lines_that_are_none_are_refused() {
        let (machine, hal) = grinder();
        let scale = PinScale::new(&hal, &machine);
        for line in [
            "",
            "1 2 3",
            "1 2 3 0 0 0 0 0 0 0 0 0",
            "1 2 3 nan 0 0 0 0 0 0 0 0 0 0",
            "1 2 3 0 0 0 0 x 0 0 0 0 0 0",
            "a 2 3 0 0 0 0 0 0 0 0 0 0 0",
            "1 2 3 0 0 0 0 0 0 0 0 0 x 0",
        ] {
            assert!(scale.read(line).is_err(), "{line:?}");
        }
    }
}
