// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Conversion between mm and m: the core's values as messages and back. Only this module multiplies by a thousand.
//!
//! What is compared exactly travels as counts, or as a position computed from counts; rounding that position to counts
//! gives the same counts again.

pub mod applied_input;
pub mod machine_description;
pub mod machine_now;
pub mod machine_report;
pub mod motion_record;

pub mod gauge;
pub mod job_files;
pub mod keyframes;
pub mod pages;
mod phase;
pub mod plan;
mod plan_segment;
mod plan_splines;
mod segment_reader;
pub mod setpoints;
pub mod time;

use camwright::cam::contour::LobeCentre;
use camwright::machine::description::{Axis, AxisScale};
use camwright::math::units::um_from_mm;
use camwright_msgs::camwright_msgs::msg::{AxisDescription, LobeForm};

#[must_use]
pub fn m_from_mm(mm: f64) -> f64 {
    mm / 1000.0
}

#[must_use]
pub fn mm_from_m(m: f64) -> f64 {
    m * 1000.0
}

/// Centre of a lobe as messages have it: distance (m) and azimuth (rad), or nothing where it is the axis.
#[must_use]
pub fn centre_values(centre: Option<LobeCentre>) -> Vec<f64> {
    centre.map_or_else(Vec::new, |centre| vec![m_from_mm(centre.distance_mm), centre.azimuth_rad])
}

/// The same of a section whose middle stands beside the position of its station (mm along Z): the offset (m) is a third value.
#[must_use]
pub fn section_centre_values(centre: Option<LobeCentre>, offset_mm: f64) -> Vec<f64> {
    if offset_mm == 0.0 {
        return centre_values(centre);
    }
    let LobeCentre { distance_mm, azimuth_rad } = centre.unwrap_or(LobeCentre { distance_mm: 0.0, azimuth_rad: 0.0 });
    vec![m_from_mm(distance_mm), azimuth_rad, m_from_mm(offset_mm)]
}

/// The same with the radial compliance of the part on its supports there (mm/N) as a fourth value (m/N), where it is not 0.
#[must_use]
pub fn held_centre_values(centre: Option<LobeCentre>, offset_mm: f64, part_mm_n: f64) -> Vec<f64> {
    let mut values = section_centre_values(centre, offset_mm);
    if part_mm_n != 0.0 {
        values.resize(3, 0.0);
        values.push(m_from_mm(part_mm_n));
    }
    values
}

/// Radial compliance of the part on its supports (mm/N); 0 where the values have no fourth.
#[must_use]
pub fn compliance_from_values(values: &[f64]) -> f64 {
    if let [_, _, _, compliance] = *values { mm_from_m(compliance) } else { 0.0 }
}

/// The same the other way. A list of another length is a centre of NaN, which a machine refuses.
#[must_use]
pub fn centre_from_values(values: &[f64]) -> Option<LobeCentre> {
    match *values {
        [] => None,
        [distance, azimuth_rad] | [distance, azimuth_rad, _] | [distance, azimuth_rad, _, _] => {
            Some(LobeCentre { distance_mm: mm_from_m(distance), azimuth_rad })
        }
        _ => Some(LobeCentre { distance_mm: f64::NAN, azimuth_rad: f64::NAN }),
    }
}

/// Middle of a section from the position of its station (mm along Z); 0 where the values have no third.
#[must_use]
pub fn offset_from_values(values: &[f64]) -> f64 {
    if let [_, _, offset] | [_, _, offset, _] = *values { mm_from_m(offset) } else { 0.0 }
}

/// Offset of that centre from the axis (m), along azimuth 0 and a quarter turn on; `None` where the axis is the centre.
#[must_use]
pub fn centre_offset(values: &[f64]) -> Option<[f64; 2]> {
    let ([distance, azimuth_rad] | [distance, azimuth_rad, _] | [distance, azimuth_rad, _, _]) = *values else {
        return None;
    };
    Some([distance * azimuth_rad.cos(), distance * azimuth_rad.sin()])
}

/// Allowed form error at each azimuth of the design of a lobe (m); messages of earlier versions have one value for all.
pub fn allowed_form_errors(form: &LobeForm) -> impl Iterator<Item = f64> {
    (0..form.contour.len()).map(|index| form.form_error_allowed.get(index).copied().unwrap_or(form.tolerance))
}

/// Bytes from megabytes (1 MB are 10^6 B); what is too large is as large as can be.
#[must_use]
pub fn bytes_from_mb(mb: u64) -> u64 {
    mb.saturating_mul(1_000_000)
}

/// A value of an axis in the core (mm or rad, and per s, s², s³) as ROS has it (m or rad).
#[must_use]
pub fn si_from_core(axis: Axis, value: f64) -> f64 {
    match axis {
        Axis::C => value,
        Axis::X | Axis::Z => m_from_mm(value),
    }
}

/// A value of an axis as ROS has it (m or rad, and per s, s², s³) in the core (mm or rad).
#[must_use]
pub fn core_from_si(axis: Axis, value: f64) -> f64 {
    match axis {
        Axis::C => value,
        Axis::X | Axis::Z => mm_from_m(value),
    }
}

/// A place of an axis as people give it (mm or deg) as ROS has it (m or rad).
#[must_use]
pub fn si_from_file(axis: Axis, value: f64) -> f64 {
    match axis {
        Axis::C => camwright::math::units::rad_from_deg(value),
        Axis::X | Axis::Z => m_from_mm(value),
    }
}

/// Position of a count as ROS has it (m or rad).
#[must_use]
pub fn si_from_counts(scale: AxisScale, counts: i64) -> f64 {
    match scale {
        // One division, so that the nearest count of the result is the count again.
        AxisScale::Linear { counts_per_mm } => counts as f64 / (counts_per_mm as f64 * 1000.0),
        AxisScale::Rotary { .. } => scale.position(counts),
    }
}

/// The nearest count to a position as ROS has it (m or rad).
#[must_use]
pub fn counts_from_si(scale: AxisScale, position: f64) -> i64 {
    match scale {
        AxisScale::Linear { counts_per_mm } => {
            #[allow(
                clippy::cast_possible_truncation,
                reason = "the cast saturates; a wild position is refused by its limits"
            )]
            let counts = (position * (counts_per_mm as f64 * 1000.0)).round() as i64;
            counts
        }
        AxisScale::Rotary { .. } => scale.counts(position),
    }
}

/// Counts of an axis for a metre or a radian, by what the machine's description says and nothing else: who judges a machine must not
/// read its counts by the scale that it was made with.
#[must_use]
pub fn counts_per_si(axis: &AxisDescription) -> f64 {
    let ratio = axis.counts_per_unit_numerator as f64 / axis.counts_per_unit_denominator as f64;
    if axis.linear { ratio * 1e6 } else { ratio / core::f64::consts::TAU }
}

/// A length for people (µm) from a message (m).
#[must_use]
pub fn um_from_m(m: f64) -> f64 {
    um_from_mm(mm_from_m(m))
}

/// Metres to micrometres, radians to microradians.
#[must_use]
pub fn um_from_si(si: f64) -> f64 {
    si * 1e6
}

/// Energy per volume: J/mm³ to J/m³.
#[must_use]
pub fn j_m3_from_j_mm3(j_mm3: f64) -> f64 {
    j_mm3 * 1e9
}

/// Energy per volume: J/m³ to J/mm³.
#[must_use]
pub fn j_mm3_from_j_m3(j_m3: f64) -> f64 {
    j_m3 / 1e9
}

/// Power: W to kW.
#[must_use]
pub fn kw_from_w(w: f64) -> f64 {
    w / 1e3
}

/// A fault's value in the core's unit: offsets of slides come in metres, all others have no length in their unit.
#[must_use]
pub fn fault_value(fault: &str, target: &str, value: f64) -> f64 {
    match (fault, Axis::from_joint(target)) {
        ("encoder_offset", Some(axis @ (Axis::X | Axis::Z))) => core_from_si(axis, value),
        _ => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_offsets_of_slides_are_lengths() {
        for (fault, target, value, core) in [
            ("encoder_offset", "x_axis", 0.001, 1.0),
            ("encoder_offset", "c_axis", 0.001, 0.001),
            ("drive_gain", "x_axis", 0.5, 0.5),
            ("drive_gain", "z_axis", 0.5, 0.5),
        ] {
            assert!((fault_value(fault, target, value) - core).abs() < 1e-12, "{fault} {target}");
        }
    }

    /// counts → m → counts is exact over the whole travel and for a headstock that has turned for days.
    #[test]
    fn counts_survive_the_way_through_si_units() {
        let linear = AxisScale::Linear { counts_per_mm: 100_000 };
        let rotary = AxisScale::Rotary { counts_per_turn: 3_600_000 };
        for i in 0..200_000_i64 {
            let counts = i * 7919 - 500_000_000;
            assert_eq!(counts_from_si(linear, si_from_counts(linear, counts)), counts);
            let counts = i * 179_424_673 - 5_000_000_000;
            assert_eq!(counts_from_si(rotary, si_from_counts(rotary, counts)), counts);
        }
    }
}
