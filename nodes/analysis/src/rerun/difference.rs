// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Difference between a recorded run and its recomputation.

use camwright::machine::description::Axis;
use camwright_files::convert::um_from_si;
use std::fmt;

/// Kind of two differing values.
#[derive(Debug, Clone, PartialEq)]
pub enum DifferingValues {
    /// Numbers of an axis or another quantity, with their unit.
    Numbers { old: f64, new: f64, unit: &'static str },
    /// Whole numbers, as counts, with the size of one, where it has one (m or rad).
    Counts {
        old: i64,
        new: i64,
        /// The axis, and the size of a count (m or rad).
        size: Option<(Axis, f64)>,
    },
    /// Anything else, as a text.
    Texts { old: String, new: String },
}

#[derive(Debug, Clone, PartialEq)]
pub struct ReplayDifference {
    /// The tick it is at.
    pub tick: u64,
    pub field: String,
    pub values: DifferingValues,
}

impl ReplayDifference {
    pub(super) fn texts(tick: u64, field: impl Into<String>, old: impl Into<String>, new: impl Into<String>) -> Self {
        Self { tick, field: field.into(), values: DifferingValues::Texts { old: old.into(), new: new.into() } }
    }

    /// Two numbers, if they differ in a bit.
    pub(super) fn from_numbers(tick: u64, field: &str, old: f64, new: f64, unit: &'static str) -> Option<Self> {
        let differs = old.to_bits() != new.to_bits();
        differs.then(|| Self { tick, field: field.to_owned(), values: DifferingValues::Numbers { old, new, unit } })
    }

    /// Two counts of an axis, if they differ.
    pub(super) fn from_counts(tick: u64, field: &str, old: i64, new: i64, size: Option<(Axis, f64)>) -> Option<Self> {
        (old != new).then(|| Self { tick, field: field.to_owned(), values: DifferingValues::Counts { old, new, size } })
    }
}

impl fmt::Display for ReplayDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tick {}: {}: ", self.tick, self.field)?;
        match &self.values {
            DifferingValues::Numbers { old, new, unit } => {
                write!(f, "recorded {old:?} {unit}, computed {new:?} {unit}, ")?;
                by(f, new - old, unit)
            }
            DifferingValues::Counts { old, new, size } => {
                write!(f, "recorded {old}, computed {new}, ")?;
                let off = new.wrapping_sub(*old) as f64;
                match size {
                    Some((axis, size)) => by(f, off * size, if *axis == Axis::C { "rad" } else { "m" }),
                    None => write!(f, "{off:+} of difference"),
                }
            }
            DifferingValues::Texts { old, new } => write!(f, "recorded {old}, computed {new}"),
        }
    }
}

/// Size of the difference, in its usual unit.
fn by(f: &mut fmt::Formatter<'_>, off: f64, unit: &str) -> fmt::Result {
    match unit {
        "m" => write!(f, "{:+.6} um of difference", um_from_si(off)),
        "rad" => write!(f, "{:+.6} urad of difference", um_from_si(off)),
        _ => write!(f, "{off:+e} {unit} of difference"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_reports_tick_field_both_values_and_size() {
        let counts = ReplayDifference::from_counts(1234, "setpoint of x_axis", 100, 103, Some((Axis::X, 1e-8)));
        let text = counts.expect("they differ").to_string();
        assert_eq!(text, "tick 1234: setpoint of x_axis: recorded 100, computed 103, +0.030000 um of difference");
        let numbers =
            ReplayDifference::from_numbers(7, "position of z_axis", 0.1, 0.1 + 1e-9, "m").expect("they differ");
        assert!(numbers.to_string().ends_with(" m, +0.001000 um of difference"), "{numbers}");
        assert_eq!(ReplayDifference::from_numbers(7, "effort of z_axis", 2.0, 2.0, "N"), None);
        assert!(
            ReplayDifference::from_numbers(7, "effort of z_axis", 0.0, -0.0, "N").is_some(),
            "they differ in a bit"
        );
        assert_eq!(ReplayDifference::from_numbers(7, "gauge", f64::NAN, f64::NAN, "m"), None, "the same bits");
    }
}
