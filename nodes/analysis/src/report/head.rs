// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Head of the report: the verdict, the worst position, its tolerance and its cause, with a picture of each.

use super::chart::{Chart, Curve, Mark, Size};
use super::columns::Columns;
use super::findings::Findings;
use super::judge::{VerdictTone, WorstError};
use super::lag::Residual;
use super::part_drawing::DrawnSection;
use super::text::{fixed, signed, um};
use super::turned;
use camwright::math::units::{deg_from_rad, wrap_turn};
use camwright_bag::info::utc;
use camwright_files::convert::{allowed_form_errors, mm_from_m};
use camwright_msgs::camwright_msgs::msg::LobeForm;
use camwright_planning::markup::escape;
use std::fmt::Write as _;

/// Columns of a chart over a turn.
pub(super) const COLUMNS: usize = 360;

pub(super) fn write(out: &mut String, findings: &Findings<'_>) {
    let verdict = findings.verdict;
    titles(out, findings);
    let tone = match verdict.tone {
        VerdictTone::Good => "good",
        VerdictTone::Wrong => "wrong",
        VerdictTone::Waits => "waits",
    };
    let _infallible = write!(
        out,
        "<div class=\"verdict {tone}\" id=\"verdict\"><h1>{}</h1><p>{}</p></div>\n<div class=\"tiles\">",
        verdict.word,
        escape(&verdict.reason)
    );
    match &verdict.worst {
        Some(worst) => {
            let _infallible = write!(
                out,
                "<div class=\"tile\" id=\"worst\"><h2>Worst form error</h2><div class=\"big\">{} µm</div><div class=\"place\">{}, {}</div></div>\
                 <div class=\"tile\" id=\"bound\"><h2>Allowed</h2><div class=\"big\">±{} µm</div><div class=\"place\">{} % of it used</div></div>",
                signed(worst.error_um, 2),
                escape(&worst.name),
                escape(&worst.place),
                fixed(worst.allowed_um, 1),
                fixed(100.0 * worst.error_um.abs() / worst.allowed_um, 0),
            );
        }
        None => out.push_str(
            "<div class=\"tile\" id=\"worst\"><h2>Worst form error</h2><div class=\"big\">–</div><div class=\"place\">nothing was judged</div></div>\
             <div class=\"tile\" id=\"bound\"><h2>Allowed</h2><div class=\"big\">–</div></div>",
        ),
    }
    out.push_str("<div class=\"tile cause\" id=\"cause\"><h2>Where it comes from</h2>");
    for cause in &verdict.causes {
        let _infallible = write!(out, "<p>{}</p>", escape(cause));
    }
    out.push_str("</div></div>\n");
    drives(out, findings);
    if let Some(worst) = &verdict.worst {
        pictures(out, findings, worst);
    }
}

/// Real drives: what the form error is computed from, and how regularly they were served.
fn drives(out: &mut String, findings: &Findings<'_>) {
    let Some(drives) = &findings.recorded.drives else { return };
    let _infallible = write!(
        out,
        "<p class=\"faint\" id=\"drives\">Real drives ({}): the form error is computed from the encoder positions, as if wheel and part were \
         rigid. Measure the part.",
        escape(drives)
    );
    if let Some(timing) = findings.recorded.timing {
        let (full, jitter, underruns) = (timing.queue_ticks, fixed(timing.max_jitter_us, 0), timing.underruns);
        let least = timing.min_queued.min(full);
        let _infallible = write!(
            out,
            " At least {least} of {full} setpoints waited in the queue, {underruns} underruns; jitter of the servo period up to {jitter} µs."
        );
    }
    out.push_str("</p>\n");
}

fn titles(out: &mut String, findings: &Findings<'_>) {
    let recorded = findings.recorded;
    let status = findings.story.status;
    let machine = findings.story.machine.map_or("not recorded", |machine| &machine.name);
    let started = recorded.span_ns.map_or_else(|| "–".to_owned(), |(first, _)| utc(first).replace('T', " "));
    let parts = findings.story.ended.len();
    let _infallible = write!(
        out,
        "<header><span>job <b>{}</b></span><span>machine <b>{}</b></span><span>recorded <b>{}</b></span><span>bag <b>{}</b></span>",
        escape(status.map_or("", |status| &status.job)),
        escape(machine),
        escape(started.split('.').next().unwrap_or("")),
        escape(&recorded.name)
    );
    if parts > 1 {
        let _infallible = write!(out, "<span>the last of <b>{parts} jobs</b> in the bag</span>");
    }
    out.push_str("</header>\n");
}

/// The worst lobe as a drawing and as a curve.
fn pictures(out: &mut String, findings: &Findings<'_>, worst: &WorstError) {
    let name = findings.story.names().get(worst.index).map_or("", String::as_str);
    let form = findings.story.forms.iter().find(|form| form.name == name);
    let (section, chart) = match form {
        Some(form) => (section(findings, form), error_chart(findings, worst.index, form, Some(worst))),
        None => match turned::worst_section(findings, worst) {
            Some(pictures) => pictures,
            None => return,
        },
    };
    let chart = Chart { size: Size(800.0, 360.0), ..chart };
    let _infallible = writeln!(
        out,
        "<div class=\"first\"><div><h2>{}</h2>{}</div><div>{}</div></div>",
        escape(&section.title),
        section.svg(),
        chart.figure()
    );
}

/// Allowed form error at each azimuth (µm).
fn allowed_um(form: &LobeForm) -> Vec<f64> {
    allowed_form_errors(form).map(um).collect()
}

/// A lobe in its nominal form with what it is off by.
pub(super) fn section(findings: &Findings<'_>, form: &LobeForm) -> DrawnSection {
    let errors: Vec<f64> = form.form_error.iter().map(|error| um(*error)).collect();
    let outline = findings.story.outlines.iter().find(|part| part.name == form.name);
    let worst = super::judge::worst_place(form).map(|(deg, error)| (deg, um(error)));
    DrawnSection {
        radius_mm: form.contour.iter().map(|radius| mm_from_m(*radius)).collect(),
        lowest_um: errors.clone(),
        highest_um: errors,
        allowed_um: allowed_um(form),
        key_way_deg: outline.map(|part| deg_from_rad(wrap_turn(part.key_way))),
        worst,
        title: format!("Lobe {}, design and form error", form.name),
    }
}

/// The form error of a lobe over its azimuth, with what of it the drives leave.
pub(super) fn error_chart(findings: &Findings<'_>, index: usize, form: &LobeForm, worst: Option<&WorstError>) -> Chart {
    let count = form.form_error.len().max(1);
    let points = form.form_error.iter().enumerate();
    let errors = points.map(|(at, error)| (360.0 * at as f64 / count as f64, um(*error)));
    let mut curves = vec![Curve {
        class: "is",
        name: "form error along the normal".into(),
        points: Columns::from_points(0.0, 360.0, COLUMNS, errors).points(),
    }];
    // Of a cut that was broken off the way out is no error of the part.
    let judged = findings.lags.get(index).filter(|_| !form.form_error.is_empty());
    if let Some(lag) = judged.and_then(Option::as_ref) {
        // The drives ring faster than a column is wide: its middle is what the eye can follow.
        let curve = |class, name: &str, left: &Residual| {
            let middle = |degree: u16| Some((f64::from(degree) + 0.5, left.at(f64::from(degree) + 0.5)?));
            Curve { class, name: name.into(), points: (0..360).filter_map(middle).collect() }
        };
        if let Some(tool) = &lag.tool {
            curves.push(curve("plan", "error by lag and swing of the axes", tool));
        }
        curves.push(curve("other", "error by lag alone, from the encoders", &lag.encoders));
    }
    let mark = worst.and_then(|worst| {
        let at = (worst.azimuth_deg?, worst.error_um);
        Some(Mark { at, label: format!("{} µm at {}", signed(worst.error_um, 2), worst.place) })
    });
    Chart {
        curves,
        mark,
        allowed: allowed_um(form),
        has_zero: true,
        ..Chart::over_azimuth(format!("Lobe {}: form error (µm), tolerance shaded", form.name))
    }
}
