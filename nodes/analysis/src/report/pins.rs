// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Ground crank pins: size, roundness, and where the centre of each lies.

use super::findings::Findings;
use super::table::table as html_table;
use super::text::{fixed, signed, um};
use camwright::math::units::{deg_from_rad, wrap_turn};
use camwright_files::convert::mm_from_m;
use camwright_msgs::camwright_msgs::msg::LobeForm;
use camwright_planning::markup::escape;
use std::f64::consts::PI;

/// Measured values of a pin beside those of its design (m, rad).
#[derive(Debug, Clone, Copy, PartialEq)]
struct MeasuredPin {
    radius_error: f64,
    roundness: f64,
    throw: f64,
    throw_error: f64,
    angle_error_rad: f64,
}

impl MeasuredPin {
    /// Reads a form; `None` for other lobes and for pins that were not ground.
    fn from_form(form: &LobeForm) -> Option<Self> {
        let ([distance, azimuth_rad], [measured, measured_rad], [radius], [roundness], [design, ..]) = (
            &form.centre[..],
            &form.measured_centre[..],
            &form.measured_radius[..],
            &form.roundness[..],
            &form.contour[..],
        ) else {
            return None;
        };
        Some(Self {
            radius_error: radius - design,
            roundness: *roundness,
            throw: *distance,
            throw_error: measured - distance,
            angle_error_rad: wrap_turn(measured_rad - azimuth_rad + PI) - PI,
        })
    }
}

/// Writes the table of pins, if there are any.
pub(super) fn table(out: &mut String, findings: &Findings<'_>) {
    let forms = findings.story.forms.iter();
    let pins: Vec<_> = forms.filter_map(|form| Some((form, MeasuredPin::from_form(form)?))).collect();
    if pins.is_empty() {
        return;
    }
    let row = |(form, pin): &(&&LobeForm, MeasuredPin)| {
        vec![
            escape(&form.name),
            signed(2.0 * um(pin.radius_error), 2),
            fixed(um(pin.roundness), 2),
            fixed(mm_from_m(pin.throw), 3),
            signed(um(pin.throw_error), 2),
            signed(deg_from_rad(pin.angle_error_rad), 5),
        ]
    };
    let heads = [
        ("pin", true),
        ("diameter error µm", false),
        ("roundness µm", false),
        ("throw mm", false),
        ("throw error µm", false),
        ("angle error °", false),
    ];
    out.push_str("<section id=\"pins\"><h2>Crank pins</h2>");
    html_table(out, &heads, &pins.iter().map(row).collect::<Vec<_>>());
    out.push_str(
        "<p class=\"faint\">Roundness: largest less smallest distance of the ground outline from the centre of its least-squares circle. \
         Throw and angle: that centre against the design's, seen from the axis; the angle is positive with the azimuth of the \
         part.</p></section>\n",
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pin_is_compared_with_its_design() {
        let form = LobeForm {
            contour: vec![0.025; 4],
            centre: vec![0.04, 0.0],
            measured_radius: vec![0.025_001],
            measured_centre: vec![0.039_998, 2.0 * PI - 1e-5],
            roundness: vec![3e-7],
            ..LobeForm::default()
        };
        let pin = MeasuredPin::from_form(&form).expect("a ground pin");
        assert!((pin.radius_error - 1e-6).abs() < 1e-12 && (pin.throw_error + 2e-6).abs() < 1e-12, "{pin:?}");
        assert!((pin.angle_error_rad + 1e-5).abs() < 1e-12 && (pin.roundness - 3e-7).abs() < 1e-15, "{pin:?}");
        let raw = LobeForm { measured_radius: Vec::new(), ..form.clone() };
        assert_eq!(MeasuredPin::from_form(&raw), None);
        assert_eq!(MeasuredPin::from_form(&LobeForm { centre: Vec::new(), ..form }), None);
    }
}
