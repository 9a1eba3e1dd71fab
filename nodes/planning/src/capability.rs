// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Size and form of the parts of a batch, and how capable they show machine and job to be.

use super::lobes::measured_form;
use camwright::cam::capability::{Capability, CapabilityError};
use camwright::cam::form::FormError;
use camwright::math::units::um_from_mm;
use camwright::planner::LobeDesign;
use camwright_msgs::camwright_msgs::msg::PartLobe;

/// A lobe of one part of a batch.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredLobe {
    pub name: String,
    /// Mean deviation of its base circle; of a journal, or where there is none, of all of it (mm).
    pub size_mm: f64,
    /// The deviation from its design that uses most of what is allowed, with its sign (mm).
    pub form_mm: f64,
    /// Allowed deviation there (mm).
    pub allowed_mm: f64,
    /// Smallest allowed deviation of all zones of the lobe (mm).
    pub tolerance_mm: f64,
}

/// A lobe of a whole batch.
#[derive(Debug, Clone, PartialEq)]
pub struct LobeCapability {
    pub name: String,
    /// Smallest allowed deviation of all its zones (mm).
    pub tolerance_mm: f64,
    /// Capability of its size, against ± the tolerance.
    pub size: Capability,
    /// Capability of the magnitude of its largest deviation, against the tolerance.
    pub form: Capability,
}

/// Text of a tolerance in µm, to a thousandth, without zeros at its end.
#[must_use]
pub fn tolerance_text(tolerance_mm: f64) -> String {
    let text = format!("{:.3}", um_from_mm(tolerance_mm));
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Measures a lobe of a part.
///
/// # Errors
/// An outline that is none.
pub fn measure_lobe(design: &LobeDesign, part: &PartLobe) -> Result<MeasuredLobe, FormError> {
    let (form, phase_rad) = measured_form(design, part)?;
    let size_mm = form.size_mm(&design.contour, phase_rad);
    let worst = design.tolerance.judge(&form, &design.contour, phase_rad);
    Ok(MeasuredLobe {
        name: design.name.clone(),
        size_mm,
        form_mm: worst.deviation.deviation_mm,
        allowed_mm: worst.allowed_mm,
        tolerance_mm: design.tolerance.smallest_mm(),
    })
}

/// Capability of each lobe over the parts of a batch, against the smallest tolerance of its zones.
///
/// # Errors
/// Fewer than two parts, or values that are no numbers.
pub fn capability(parts: &[Vec<MeasuredLobe>]) -> Result<Vec<LobeCapability>, CapabilityError> {
    let first = parts.first().map_or(&[][..], Vec::as_slice);
    let lobe = |lobe: &MeasuredLobe| {
        let of = |value: fn(&MeasuredLobe) -> f64| -> Vec<f64> {
            let here = parts.iter().filter_map(|part| part.iter().find(|other| other.name == lobe.name));
            here.map(value).collect()
        };
        let tolerance_mm = lobe.tolerance_mm;
        Ok(LobeCapability {
            name: lobe.name.clone(),
            tolerance_mm,
            size: Capability::from_values(&of(|lobe| lobe.size_mm), Some(-tolerance_mm), tolerance_mm)?,
            form: Capability::from_values(&of(|lobe| lobe.form_mm.abs()), None, tolerance_mm)?,
        })
    };
    if parts.len() < 2 {
        return Err(CapabilityError::TooFew { count: parts.len() });
    }
    first.iter().map(lobe).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright::cam::contour::Contour;
    use camwright::cam::form_tolerance::FormTolerance;
    use camwright_files::convert::m_from_mm;

    /// Discs larger by 1, 2 and 3 µm: mean 2, s = 1, Cp = 10/6, Cpk = (5 − 2)/3 for size and form.
    #[test]
    fn discs_of_known_size_have_the_capability_of_the_closed_form() {
        let design = LobeDesign {
            name: "A".into(),
            station: "LS1".into(),
            contour: Contour::eccentric(0.0, 20.0).unwrap(),
            phase_rad: 0.4,
            part_phase_rad: 0.0,
            width_mm: 14.0,
            tolerance: FormTolerance::default(),
            plunge: None,
            visit: None,
            axial: None,
            part_support: None,
        };
        let part = |um: f64| {
            let radius = vec![m_from_mm(20.0 + 1e-3 * um); 360];
            vec![measure_lobe(&design, &PartLobe { radius, ..PartLobe::default() }).unwrap()]
        };
        let found = capability(&[part(1.0), part(2.0), part(3.0)]).unwrap();
        let near = |found: Option<f64>, wanted: f64| found.is_some_and(|found| (found - wanted).abs() < 1e-6);
        let (size, form) = (&found[0].size, &found[0].form);
        assert!((size.mean - 0.002).abs() < 1e-12 && (size.deviation - 0.001).abs() < 1e-12, "{size:?}");
        assert!(near(size.cp, 10.0 / 6.0) && near(size.cpk, 1.0), "{size:?}");
        assert!(form.cp.is_none() && near(form.cpk, 1.0), "{form:?}");
        assert_eq!(capability(&[part(1.0)]), Err(CapabilityError::TooFew { count: 1 }));
    }
}
