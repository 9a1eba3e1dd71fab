// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Every lobe: how it came out, and what was done over its last turns.

use super::chart::{Chart, Curve, LevelLine};
use super::columns::Columns;
use super::findings::Findings;
use super::head::{COLUMNS, error_chart, section};
use super::motion::MotionSample;
use super::table::table as html_table;
use super::text::{fixed, signed, um};
use camwright::math::units::{deg_from_rad, rad_from_deg, rpm_from_rad_s, wrap_turn};
use camwright_files::convert::{j_mm3_from_j_m3, mm_from_m};
use camwright_msgs::camwright_msgs::msg::{LobeForm, LobeResult, LobeShape, PartLobe};
use camwright_planning::markup::escape;
use camwright_planning::{AnyPrepared, Summary, compare_times, summary, turn_curve};
use std::fmt::Write as _;

pub(super) fn table(out: &mut String, findings: &Findings<'_>) {
    let Some(status) = findings.story.status.filter(|status| !status.lobes.is_empty()) else { return };
    let times = match findings.again {
        Ok(AnyPrepared::Ground(prepared)) => compare_times(prepared, &status.lobes, 0.0),
        _ => Vec::new(),
    };
    let row = |lobe: &LobeResult| {
        let allowed = super::judge::allowed(findings.story, lobe);
        let verdict = match allowed {
            Some(allowed) if lobe.form_error_max.abs() <= allowed => "<span class=\"ok\">good</span>",
            Some(_) => "<span class=\"bad\">not good</span>",
            None => "–",
        };
        let late = times.iter().find(|time| time.what == lobe.name).map(|time| signed(time.late_s(), 2));
        let given = |value: f64, digits: usize| if value > 0.0 { fixed(value, digits) } else { "–".into() };
        vec![
            escape(&lobe.name),
            verdict.to_owned(),
            signed(um(lobe.form_error_max), 2),
            fixed(deg_from_rad(lobe.form_error_max_angle), 1),
            allowed.map_or_else(|| "–".into(), |allowed| format!("±{}", fixed(um(allowed), 1))),
            fixed(um(lobe.form_error_rms), 2),
            given(um(lobe.lift_error), 2),
            fixed(lobe.turns, 0),
            format!("{}{}", fixed(lobe.duration, 2), late.map_or_else(String::new, |late| format!(" ({late})"))),
            given(lobe.power_max, 0),
            given(j_mm3_from_j_m3(lobe.specific_energy), 0),
            given(lobe.burn_index_max, 2),
        ]
    };
    out.push_str("<section id=\"lobes\"><h2>Lobes</h2>");
    let heads = [
        ("lobe", true),
        ("", true),
        ("worst error µm", false),
        ("at cam angle °", false),
        ("allowed µm", false),
        ("rms µm", false),
        ("lift p-v µm", false),
        ("turns", false),
        ("time s (late by)", false),
        ("peak power W", false),
        ("there J/mm³", false),
        ("burn index", false),
    ];
    html_table(out, &heads, &status.lobes.iter().map(row).collect::<Vec<_>>());
    shape_table(out, &status.shapes);
    out.push_str("<p class=\"faint\">Errors along the normal, positive where material is left. Burn index: highest temperature of the contact by that of the cut that just does not burn. In brackets, how much longer it took than planned.</p></section>\n");
}

/// Taper and crown of the lobes that have them.
fn shape_table(out: &mut String, shapes: &[LobeShape]) {
    if shapes.is_empty() {
        return;
    }
    let row = |shape: &LobeShape| {
        let errors: Vec<String> = shape.form_error.iter().map(|error| signed(um(*error), 2)).collect();
        vec![
            escape(&shape.name),
            signed(um(shape.taper), 2),
            signed(um(shape.taper_design), 2),
            signed(um(shape.crown), 2),
            signed(um(shape.crown_design), 2),
            errors.join(", "),
        ]
    };
    let heads = [
        ("lobe", true),
        ("taper µm", false),
        ("design µm", false),
        ("crown µm", false),
        ("design µm", false),
        ("worst error of the sections from the headstock on µm", false),
    ];
    html_table(out, &heads, &shapes.iter().map(row).collect::<Vec<_>>());
}

/// Drawing and curves of every lobe.
pub(super) fn figures(out: &mut String, findings: &Findings<'_>) {
    let planned = match findings.again {
        Ok(AnyPrepared::Ground(prepared)) => Some(summary(prepared)),
        _ => None,
    };
    for (index, name) in findings.story.names().iter().enumerate() {
        let Some(form) = findings.story.forms.iter().find(|form| form.name == *name) else { continue };
        let _infallible = write!(out, "<section class=\"lobe\"><h2>Lobe {}</h2>", escape(name));
        if let Some(giving) = planned.as_ref().and_then(|planned| planned.lobes.get(index)?.giving_way.as_ref()) {
            let _infallible = write!(
                out,
                "<p class=\"faint\">Planned deflection of wheel and part: {}.</p>",
                escape(&giving.to_string())
            );
        }
        if let Some(finishing) = planned.as_ref().and_then(|planned| planned.lobes.get(index)?.finishing.as_ref()) {
            let expected = escape(&finishing.to_string());
            let _infallible = write!(out, "<p class=\"faint\">Expected after the correction: {expected}.</p>");
        }
        out.push_str("<div class=\"figures\">");
        let section = section(findings, form);
        let _infallible =
            write!(out, "<figure><figcaption>{}</figcaption>{}</figure>", escape(&section.title), section.svg());
        out.push_str("<div>");
        out.push_str(&error_chart(findings, index, form, None).figure());
        out.push_str(&path_chart(findings, index).figure());
        out.push_str("</div>");
        for chart in [speed_chart(findings, index), removal_chart(findings, index, planned.as_ref())] {
            out.push_str(&chart.figure());
        }
        out.push_str(&force_chart(findings, index).figure());
        let outline = findings.story.outlines.iter().find(|part| part.name == *name);
        for chart in cut_charts(outline.copied(), form) {
            out.push_str(&chart.figure());
        }
        out.push_str("</div></section>\n");
    }
}

/// Azimuth on the part that the wheel's line is at (deg).
fn azimuth(findings: &Findings<'_>, sample: &MotionSample) -> f64 {
    deg_from_rad(wrap_turn(findings.sense() * sample.position[0]))
}

fn turn_curve_of(
    findings: &Findings<'_>,
    turn: &[MotionSample],
    class: &'static str,
    name: &str,
    of: impl Fn(&MotionSample) -> f64,
) -> Curve {
    let points = turn.iter().map(|sample| (azimuth(findings, sample), of(sample)));
    Curve { class, name: name.to_owned(), points: Columns::from_points(0.0, 360.0, COLUMNS, points).points() }
}

fn last_turn<'a>(findings: &Findings<'a>, lobe: usize) -> &'a [MotionSample] {
    match (findings.motion, findings.story.last_cut(lobe)) {
        (Some(motion), Some(cut)) => motion.last_turn(cut),
        _ => &[],
    }
}

fn infeed_turn<'a>(findings: &Findings<'a>, lobe: usize) -> &'a [MotionSample] {
    match (findings.motion, findings.story.first_infeed(lobe)) {
        (Some(motion), Some(cut)) => motion.last_turn(cut),
        _ => &[],
    }
}

const LINE: &str = "azimuth of the wheel's line on the part (°)";

fn path_chart(findings: &Findings<'_>, lobe: usize) -> Chart {
    let turn = last_turn(findings, lobe);
    let curve =
        turn_curve_of(findings, turn, "is", "X as its encoder read it, last turn", |s| mm_from_m(s.position[1]));
    Chart { curves: vec![curve], across: LINE, ..Chart::over_azimuth("X over C (mm)") }
}

fn speed_chart(findings: &Findings<'_>, lobe: usize) -> Chart {
    let rpm = |sample: &MotionSample| rpm_from_rad_s(sample.velocity[0]);
    let mut curves =
        vec![turn_curve_of(findings, infeed_turn(findings, lobe), "is", "measured, last turn with infeed", rpm)];
    if let Some(points) = planned_turn(findings, lobe, |point| point.c_rpm) {
        curves.push(Curve { class: "plan", name: "planned".into(), points });
    }
    Chart { curves, across: LINE, ..Chart::over_azimuth("Speed of C (1/min)") }
}

/// A quantity of the pass that removes most, as planned.
fn planned_turn(
    findings: &Findings<'_>,
    lobe: usize,
    of: impl Fn(&camwright_planning::TurnCurvePoint) -> f64,
) -> Option<Vec<(f64, f64)>> {
    let Ok(AnyPrepared::Ground(prepared)) = findings.again else { return None };
    let curve = turn_curve(prepared, lobe, 0)?;
    let azimuth = |c_deg: f64| deg_from_rad(wrap_turn(findings.sense() * rad_from_deg(c_deg)));
    let points = curve.iter().map(|point| (azimuth(point.c_deg), of(point)));
    Some(Columns::from_points(0.0, 360.0, COLUMNS, points).points())
}

fn removal_chart(findings: &Findings<'_>, lobe: usize, planned: Option<&Summary>) -> Chart {
    let points = planned_turn(findings, lobe, |point| point.removal_mm2_s).unwrap_or_default();
    let pass = planned.and_then(|planned| planned.lobes.get(lobe)?.passes.first());
    let name = pass.map_or_else(String::new, |pass| {
        format!("planned with infeed, pass {}, at most {} mm²/s", pass.name, fixed(pass.max_removal_mm2_s, 2))
    });
    let curves = vec![Curve { class: "plan", name, points }];
    Chart {
        curves, has_zero: true, across: LINE, ..Chart::over_azimuth("Removal rate Q′ (mm³ per mm of width and s)")
    }
}

fn force_chart(findings: &Findings<'_>, lobe: usize) -> Chart {
    let force = |sample: &MotionSample| sample.force_x_n;
    let with = turn_curve_of(findings, infeed_turn(findings, lobe), "is", "last turn with infeed", force);
    let last = turn_curve_of(findings, last_turn(findings, lobe), "other", "last turn of all", force);
    let title =
        "Force of the motor of X, which holds the wheel against the part and moves its slide (N, inwards negative)";
    Chart { curves: vec![with, last], across: LINE, ..Chart::over_azimuth(title) }
}

/// Force, power and heat over the azimuth of their maxima, as the machine reported them with the part.
fn cut_charts(outline: Option<&PartLobe>, form: &LobeForm) -> [Chart; 3] {
    let of = |values: Option<&Vec<f64>>| -> Vec<(f64, f64)> {
        let values = values.map_or(&[][..], Vec::as_slice);
        let at = |(index, value): (usize, &f64)| ((index as f64 + 0.5) * 360.0 / values.len() as f64, *value);
        Columns::from_points(0.0, 360.0, COLUMNS, values.iter().enumerate().map(at)).points()
    };
    let curve = |points, name: &str| vec![Curve { class: "is", name: name.into(), points }];
    let largest = "the largest of all turns";
    let force = Chart {
        curves: curve(of(outline.map(|part| &part.normal_force)), largest),
        has_zero: true,
        ..Chart::over_azimuth(format!("Normal force of the wheel on lobe {} (N)", form.name))
    };
    let power = Chart {
        curves: curve(of(outline.map(|part| &part.power)), largest),
        has_zero: true,
        ..Chart::over_azimuth(format!("Power of the wheel in the cut of lobe {} (W)", form.name))
    };
    let burn = Chart {
        curves: curve(of(outline.map(|part| &part.burn_index)), largest),
        levels: vec![LevelLine { value: 1.0, label: "burns above".into() }],
        has_zero: true,
        ..Chart::over_azimuth("Burn index")
    };
    [force, power, burn]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The force of every degree is drawn at its middle with the reported value in N; without it there is no curve.
    #[test]
    fn the_force_that_is_drawn_is_that_of_the_message() {
        let normal_force: Vec<f64> = (0..360).map(|degree| f64::from(degree * degree % 97)).collect();
        let part = PartLobe { normal_force: normal_force.clone(), ..PartLobe::default() };
        let form = LobeForm { name: "A".into(), ..LobeForm::default() };
        let drawn = |part: Option<&PartLobe>| {
            let [force, ..] = cut_charts(part, &form);
            force.curves.into_iter().flat_map(|curve| curve.points).collect::<Vec<_>>()
        };
        let wanted: Vec<(f64, f64)> = (0..360).map(|degree| f64::from(degree) + 0.5).zip(normal_force).collect();
        assert_eq!(drawn(Some(&part)), wanted);
        assert!(drawn(Some(&PartLobe::default())).is_empty() && drawn(None).is_empty());
    }
}
