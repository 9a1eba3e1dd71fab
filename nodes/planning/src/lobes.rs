// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lobes as messages: the blank that is put between the centres, and the form of what was ground.

use camwright::cam::contour::Contour;
use camwright::cam::form::{Form, FormError};
use camwright::job::plunges::LobeSection;
use camwright::math::range::minimum_and_maximum;
use camwright::math::units::{TURN_RAD, deg_from_rad, um_from_mm, wrap_turn};
use camwright::planner::LobeDesign;
use camwright_files::convert::{held_centre_values, m_from_mm, mm_from_m};
use camwright_msgs::camwright_msgs::msg::{LobeResult, PartLobe};
use thiserror::Error;

/// Points of a blank's outline over one turn: 0.1°, as the blocks of the tables in use.
pub const BLANK_POINTS: usize = 3600;

/// Reason why the form of a lobe is unknown.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("the form of lobe {lobe} cannot be judged: {source}")]
pub struct LobeFormError {
    /// Name of the lobe.
    pub lobe: String,
    pub source: FormError,
}

/// The raw outline of a section of a lobe: its contour with the stock along the normal and what the part has above that (mm, over the azimuth from its
/// keyway), on equal azimuths, with its keyway at one of them (rad); the part has a radial compliance there (mm/N).
#[must_use]
pub(super) fn blank(
    design: &LobeDesign,
    section: &LobeSection,
    (stock_mm, part_mm_n): (f64, f64),
    key_way_rad: f64,
    above_mm: impl Fn(f64) -> f64,
) -> PartLobe {
    let phase_rad = design.phase_on_rad(key_way_rad);
    let even_mm = |azimuth_rad: f64| blank_radius_mm(&design.contour, azimuth_rad - phase_rad, stock_mm);
    let above_mm = |azimuth_rad: f64| above_mm(azimuth_rad - key_way_rad);
    // The wall of a bore has negative radii: more of them is more material, too.
    let sign = design.contour.radius_sign();
    let radius = (0..BLANK_POINTS).map(azimuth).map(|at| m_from_mm(sign * even_mm(at) + above_mm(at))).collect();
    PartLobe {
        name: section.name.clone(),
        station: design.station.clone(),
        width: m_from_mm(section.width_mm),
        finished: false,
        key_way: key_way_rad,
        radius,
        centre: held_centre_values(design.centre_on(key_way_rad), section.offset_mm, part_mm_n),
        ..PartLobe::default()
    }
}

fn azimuth(index: usize) -> f64 {
    index as f64 * TURN_RAD / BLANK_POINTS as f64
}

/// The closed outline of a blank in the frame of its lobe (mm), for drawings.
pub(super) fn blank_outline_mm(design: &LobeDesign, stock_mm: f64) -> Vec<[f64; 2]> {
    (0..=BLANK_POINTS)
        .step_by(4)
        .map(|index| {
            let angle = azimuth(index);
            let (sin, cos) = angle.sin_cos();
            let radius = blank_radius_mm(&design.contour, angle, stock_mm);
            [radius * cos, radius * sin]
        })
        .collect()
}

/// Radius of the curve `stock_mm` outside the contour, or inside the wall of a bore, at an azimuth of the cam's frame.
///
/// The distance of a point from the contour grows along its ray (the contour passes the axis on the right side), so the
/// radius at which it is the stock is found by bisection between the contour and the contour plus what even a normal 80°
/// off the ray would need.
fn blank_radius_mm(contour: &Contour, azimuth_rad: f64, stock_mm: f64) -> f64 {
    let sign = contour.radius_sign();
    let mut low = sign * contour.radius_at(azimuth_rad);
    let mut high = low + 6.0 * stock_mm;
    // Newton's slope is the cosine between ray and normal: a few secant steps within the bracket are enough.
    let mut radius = low + stock_mm;
    for _ in 0..60 {
        let (distance, cam_angle) = contour.distance(sign * radius, azimuth_rad);
        let miss = distance - stock_mm;
        if miss > 0.0 {
            high = radius;
        } else {
            low = radius;
        }
        if miss.abs() < 1e-10 || high - low < 1e-12 {
            break;
        }
        let slope = sign * (contour.normal_angle(cam_angle) - azimuth_rad).cos();
        let next = radius - miss / slope;
        radius = if next > low && next < high { next } else { 0.5 * (low + high) };
    }
    sign * radius
}

/// Form of a measured lobe, or of a section of one against its own design, and the azimuth of its cam angle 0 on that part (rad).
///
/// # Errors
/// An outline without radii, or with one that is none.
pub fn measured_form(design: &LobeDesign, measured: &PartLobe) -> Result<(Form, f64), FormError> {
    let radii_mm: Vec<f64> = measured.radius.iter().map(|radius| mm_from_m(*radius)).collect();
    let phase_rad = design.phase_on_rad(measured.key_way);
    let above_mm = design.above_mm(&measured.name);
    Ok((Form::measure_parallel(&radii_mm, &design.contour, phase_rad, above_mm)?, phase_rad))
}

/// Result of a ground lobe, against its design.
///
/// # Errors
/// An outline without radii, or with one that is none.
pub fn lobe_result(design: &LobeDesign, measured: &PartLobe) -> Result<LobeResult, LobeFormError> {
    let (form, phase_rad) =
        measured_form(design, measured).map_err(|source| LobeFormError { lobe: design.name.clone(), source })?;
    let worst = design.tolerance.judge(&form, &design.contour, phase_rad);
    let span = minimum_and_maximum(measured.radius.iter().copied());
    let highest = |of: &[f64]| {
        let degrees = of.iter().enumerate().filter(|(_, value)| **value > 0.0);
        let (degree, value) = degrees.max_by(|a, b| a.1.total_cmp(b.1))?;
        let azimuth_rad = (degree as f64 + 0.5) / of.len() as f64 * TURN_RAD;
        Some((*value, wrap_turn(azimuth_rad - design.phase_rad), degree))
    };
    let power = highest(&measured.power);
    let burn = highest(&measured.burn_index);
    let specific_energy = power.and_then(|(_, _, degree)| measured.specific_energy.get(degree).copied());
    let lift_is_length = design.contour.follower().lift_is_length() && !design.contour.is_pin();
    Ok(LobeResult {
        power_max: power.map_or(f64::NAN, |power| power.0),
        power_max_angle: power.map_or(f64::NAN, |power| power.1),
        specific_energy: specific_energy.unwrap_or(f64::NAN),
        burn_index_max: burn.map_or(f64::NAN, |burn| burn.0),
        burn_index_max_angle: burn.map_or(f64::NAN, |burn| burn.1),
        runout: if design.is_round() { span.1 - span.0 } else { f64::NAN },
        name: design.name.clone(),
        station: design.station.clone(),
        form_error_max: m_from_mm(worst.deviation.deviation_mm),
        form_error_max_angle: wrap_turn(worst.deviation.cam_angle_rad),
        form_error_allowed: m_from_mm(worst.allowed_mm),
        form_error_rms: m_from_mm(form.rms_mm),
        lift_error: match lift_is_length {
            true => m_from_mm(form.lift_error(&design.contour, design.phase_rad)),
            false => f64::NAN,
        },
        runout_before: f64::NAN,
        runout_expected: f64::NAN,
        runout_limit: f64::NAN,
        spark_out_turns: f64::NAN,
        machine_stiffness: f64::NAN,
        machine_stiffness_uncertainty: f64::NAN,
        grinding_stiffness: f64::NAN,
        grinding_stiffness_uncertainty: f64::NAN,
        threshold_force: f64::NAN,
        threshold_force_uncertainty: f64::NAN,
        stiffness_ratio: f64::NAN,
        stiffness_ratio_uncertainty: f64::NAN,
        start_angle: 0.0,
        turns: 0.0,
        duration: 0.0,
    })
}

/// Result of a ground lobe or plunge from the sections that are finished with it, its own first: the worst of them against the design.
///
/// # Errors
/// Those of [`lobe_result`]; no section.
pub fn sections_result(design: &LobeDesign, sections: &[PartLobe]) -> Result<LobeResult, LobeFormError> {
    let (own, beside) = match sections {
        [own, beside @ ..] => (own, beside),
        [] => (&PartLobe::default(), sections),
    };
    let mut worst = lobe_result(design, own)?;
    if let (Some(section), true) = (design.sections().first(), design.plunge.is_some() || design.axial.is_some()) {
        // The spindle drives the cut over all the width that no plunge has cut before.
        let fresh_mm = design.plunge.as_ref().map_or(design.width_mm, |plunge| plunge.fresh_width_mm(design.width_mm));
        worst.power_max *= fresh_mm / section.width_mm;
    }
    for section in beside {
        let found = lobe_result(design, section)?;
        let is_worse = found.form_error_max.abs() * worst.form_error_allowed
            > worst.form_error_max.abs() * found.form_error_allowed;
        if is_worse {
            worst.form_error_max = found.form_error_max;
            worst.form_error_max_angle = found.form_error_max_angle;
            worst.form_error_allowed = found.form_error_allowed;
        }
        worst.form_error_rms = worst.form_error_rms.max(found.form_error_rms);
        worst.lift_error = worst.lift_error.max(found.lift_error);
        worst.runout = worst.runout.max(found.runout);
        if worst.burn_index_max.is_nan() || found.burn_index_max > worst.burn_index_max {
            worst.burn_index_max = found.burn_index_max;
            worst.burn_index_max_angle = found.burn_index_max_angle;
        }
    }
    Ok(worst)
}

/// Roundness of a ground crank pin, and the errors of its diameter and of its centre, in a sentence; `None` for other lobes.
#[must_use]
pub fn pin_line(design: &LobeDesign, measured: &PartLobe) -> Option<String> {
    let (form, phase_rad) = measured_form(design, measured).ok()?;
    let pin = form.pin(&design.contour, phase_rad)?;
    Some(format!(
        "pin {}: roundness {:.2} um, diameter {:+.2} um, throw {:+.2} um, angle {:+.5} deg",
        design.name,
        um_from_mm(pin.roundness_mm),
        um_from_mm(2.0 * pin.radius_error_mm),
        um_from_mm(pin.throw_error_mm),
        deg_from_rad(pin.angle_error_rad)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright::cam::form_tolerance::FormTolerance;

    /// The blank of a pin is the larger pin about the same centre, which a keyway elsewhere turns with the part; what is measured of it is its
    /// stock, and nothing else.
    #[test]
    fn the_blank_of_a_pin_is_a_larger_pin() {
        let pin = LobeDesign { contour: Contour::pin(40.0, 25.0).unwrap(), ..disc(1.0, 20.0, 0.7) };
        let blank = raw(&pin, 0.3, 0.1);
        let [distance, azimuth] = blank.centre[..] else { panic!("{:?}", blank.centre) };
        assert!((mm_from_m(distance) - 40.0).abs() < 1e-12 && (azimuth - 0.8).abs() < 1e-12, "{:?}", blank.centre);
        assert!(blank.radius.iter().all(|radius| (mm_from_m(*radius) - 25.3).abs() < 1e-9));
        let line = pin_line(&pin, &blank).expect("a pin");
        assert_eq!(line, "pin A: roundness 0.00 um, diameter +600.00 um, throw +0.00 um, angle +0.00000 deg");
        assert!(lobe_result(&pin, &blank).unwrap().runout.is_nan(), "the runout of a journal is none of a pin");
        assert_eq!(pin_line(&disc(1.0, 20.0, 0.7), &blank), None);
        assert!(raw(&disc(1.0, 20.0, 0.7), 0.3, 0.1).centre.is_empty());
    }

    fn raw(design: &LobeDesign, stock_mm: f64, key_way_rad: f64) -> PartLobe {
        blank(design, &design.sections()[0], (stock_mm, 0.0), key_way_rad, |_| 0.0)
    }

    fn disc(eccentricity_mm: f64, radius_mm: f64, phase_rad: f64) -> LobeDesign {
        LobeDesign {
            name: "A".into(),
            station: "LS1".into(),
            contour: Contour::eccentric(eccentricity_mm, radius_mm).unwrap(),
            phase_rad,
            part_phase_rad: 0.0,
            width_mm: 14.0,
            tolerance: FormTolerance::default(),
            plunge: None,
            visit: None,
            axial: None,
            part_support: None,
        }
    }

    /// The degree with the largest removal is reported by its cam angle, the hottest one by its own.
    #[test]
    fn the_hardest_cut_is_reported_with_its_position() {
        let (e, r, phase) = (4.2, 19.0, 1.1);
        let design = disc(e, r, phase);
        let radius = (0..720).map(|i| m_from_mm(design.radius_at(f64::from(i) * TURN_RAD / 720.0))).collect();
        let at = |degree: usize, high: f64, low: f64| -> Vec<f64> {
            (0..360).map(|i| if i == degree { high } else { low }).collect()
        };
        let (power, specific_energy, burn_index) = (at(100, 2e3, 1e3), at(100, 5e10, 4e10), at(250, 0.7, 0.5));
        let part = PartLobe { radius, power, specific_energy, burn_index, ..PartLobe::default() };
        let result = lobe_result(&design, &part).unwrap();
        assert_eq!((result.power_max, result.specific_energy, result.burn_index_max), (2e3, 5e10, 0.7));
        let degree = |angle: f64| (angle + phase).to_degrees().rem_euclid(360.0);
        assert!((degree(result.power_max_angle) - 100.5).abs() < 1e-9, "{}", result.power_max_angle);
        assert!((degree(result.burn_index_max_angle) - 250.5).abs() < 1e-9, "{}", result.burn_index_max_angle);
        let unknown = lobe_result(&design, &PartLobe { radius: part.radius, ..PartLobe::default() }).unwrap();
        assert!(unknown.power_max.is_nan() && unknown.specific_energy.is_nan() && unknown.burn_index_max.is_nan());
    }

    /// The blank of an eccentric disc is the larger disc about the same centre:
    /// r(a) = e cos(a − α) + √((r + stock)² − e² sin²(a − α)).
    #[test]
    fn the_blank_of_a_disc_is_a_larger_disc() {
        let (e, r, stock, phase) = (4.2, 19.0, 0.3, 1.1);
        let blank = raw(&disc(e, r, phase), stock, 0.0);
        assert_eq!(blank.radius.len(), BLANK_POINTS);
        for (i, radius) in blank.radius.iter().enumerate() {
            let angle = azimuth(i) - phase;
            let exact = e * angle.cos() + ((r + stock).powi(2) - (e * angle.sin()).powi(2)).sqrt();
            assert!((mm_from_m(*radius) - exact).abs() < 1e-8, "{i}: {} {exact}", mm_from_m(*radius));
        }
    }

    /// A blank lies its stock outside the design everywhere.
    #[test]
    fn the_form_error_of_a_blank_is_its_stock() {
        let design = disc(4.2, 19.0, -0.7);
        let result = lobe_result(&design, &raw(&design, 0.25, 0.0)).unwrap();
        assert!((result.form_error_max - 0.25e-3).abs() < 1e-11);
        assert!((result.form_error_rms - 0.25e-3).abs() < 1e-11);
    }

    /// A part that is clamped askew is measured from its keyway: its blank is as good as another, and the wrong phase shows.
    #[test]
    fn form_is_measured_from_the_key_way_wherever_the_part_is_clamped() {
        let design = disc(4.2, 19.0, -0.7);
        let askew = raw(&design, 0.25, 0.1);
        assert!((lobe_result(&design, &askew).unwrap().form_error_max - 0.25e-3).abs() < 1e-11);
        let found = LobeDesign { phase_rad: -0.6, part_phase_rad: 0.1, ..design.clone() };
        assert!((lobe_result(&found, &askew).unwrap().form_error_max - 0.25e-3).abs() < 1e-11);
        // Ground where the keyway should be: the disc is turned by 0.1 rad, up to e sin 0.1 off in addition to its stock.
        let ground = PartLobe { key_way: 0.1, ..raw(&design, 0.25, 0.0) };
        let off = lobe_result(&design, &ground).unwrap().form_error_max.abs();
        assert!((off - (0.25e-3 + 4.2e-3 * (2.0 * 0.05_f64.sin()))).abs() < 2e-5, "{off}");
    }

    #[test]
    fn an_outline_without_radii_has_no_form() {
        let error = lobe_result(&disc(4.2, 19.0, 0.0), &PartLobe::default()).unwrap_err();
        assert!(error.to_string().starts_with("the form of lobe A cannot be judged"), "{error}");
    }
}
