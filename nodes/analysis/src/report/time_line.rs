// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The job over time: what was done when, how fast the axes were, and what limited them.

use super::chart::{Chart, Curve, Size, Zone};
use super::findings::Findings;
use super::job_timeline::Period;
use super::table::table;
use super::text::fixed;
use camwright::motion::plan::Phase;
use camwright_files::convert::plan::{phase_from, phase_name};
use camwright_msgs::camwright_msgs::msg::AppliedInput;
use camwright_planning::markup::escape;
use camwright_planning::{AnyPrepared, PassSummary, TurnedPassSummary, summary, turning_summary};
use std::collections::BTreeMap;
use std::fmt::Write as _;

pub(super) fn write(out: &mut String, findings: &Findings<'_>) {
    out.push_str("<section id=\"time\"><h2>Time line</h2>");
    let whole_s = findings.story.ticks.and_then(|(_, last)| findings.seconds(last)).filter(|whole| *whole > 0.0);
    match whole_s {
        Some(whole_s) => {
            bands(out, findings, whole_s);
            shares(out, findings, whole_s);
        }
        None => out.push_str("<p class=\"none\">the motion of the interpolator is not recorded</p>"),
    }
    limits(out, findings);
    operator(out, findings);
    out.push_str("</section>\n");
}

/// Class of what was done.
fn class(stretch: &Period) -> &'static str {
    if stretch.is_held {
        return "z6";
    }
    match phase_from(stretch.phase) {
        Some(Phase::Cut) => "z1",
        Some(Phase::SparkOut) => "z2",
        Some(Phase::Index | Phase::Position | Phase::RotaryIndex | Phase::Approach | Phase::Retract) => "z3",
        Some(Phase::Dress | Phase::WheelChange) => "z5",
        _ => "z4",
    }
}

const CLASSES: [(&str, &str); 6] = [
    ("z1", "cut"),
    ("z2", "spark-out"),
    ("z3", "on the way to and from the part"),
    ("z4", "homing, return, waiting"),
    ("z5", "dressing"),
    ("z6", "held"),
];

fn bands(out: &mut String, findings: &Findings<'_>, whole_s: f64) {
    let stretches = &findings.story.stretches;
    let at = |tick: u64| findings.seconds(tick).unwrap_or_default();
    let (left, width) = (58.0, 1132.0);
    let x = |tick: u64| left + width * at(tick) / whole_s;
    let _infallible = write!(out, "<svg viewBox=\"0 0 1200 62\" role=\"img\" aria-label=\"timeline of the job\">");
    for stretch in stretches {
        let (from, to) = (x(stretch.from), x(stretch.to));
        let _infallible = write!(
            out,
            "<rect class=\"{}\" x=\"{from:.1}\" y=\"24\" width=\"{:.1}\" height=\"34\"/>",
            class(stretch),
            (to - from).max(0.3)
        );
    }
    for (lobe, name) in findings.story.names().iter().enumerate() {
        let of = || stretches.iter().filter(|stretch| stretch.lobe == Some(lobe) && stretch.cuts());
        let mut cuts: Vec<(u64, u64)> = Vec::new();
        for stretch in of() {
            match cuts.last_mut() {
                Some(last) if last.1 == stretch.from => last.1 = stretch.to,
                _ => cuts.push((stretch.from, stretch.to)),
            }
        }
        // A name where there is room for it.
        for (from, to) in cuts.iter().filter(|(from, to)| x(*to) - x(*from) > 14.0) {
            let middle = 0.5 * (x(*from) + x(*to));
            let _infallible = write!(out, "<text class=\"mid\" x=\"{middle:.1}\" y=\"17\">{}</text>", escape(name));
        }
    }
    out.push_str("</svg><div class=\"legend\">");
    for (class_name, name) in CLASSES.iter().filter(|(name, _)| stretches.iter().any(|s| class(s) == *name)) {
        let _infallible = write!(out, "<span><i class=\"box {class_name}\"></i>{name}</span>");
    }
    out.push_str("</div>");
    let Some(motion) = findings.motion else { return };
    let step = [1.0, 2.0, 5.0, 10.0, 20.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0];
    let step = step.into_iter().find(|step| whole_s / step <= 16.0).unwrap_or(whole_s);
    let held = stretches.iter().filter(|stretch| stretch.is_held);
    let zones: Vec<Zone> = held.map(|s| Zone { from: at(s.from), to: at(s.to), class: "z6" }).collect();
    let chart = |title: &str, columns: &super::columns::Columns| Chart {
        title: title.into(),
        across: "time from the job's first tick (s)",
        from: 0.0,
        to: whole_s,
        step,
        curves: vec![Curve { class: "is", name: String::new(), points: columns.points() }],
        zones: zones.clone(),
        size: Size(1200.0, 150.0),
        ..Chart::default()
    };
    for (title, columns) in [("Speed of C (1/min)", &motion.c_rpm), ("X (mm)", &motion.x_mm), ("Z (mm)", &motion.z_mm)]
    {
        out.push_str(&chart(title, columns).figure());
    }
}

/// Time of each phase of each lobe.
fn shares(out: &mut String, findings: &Findings<'_>, whole_s: f64) {
    let mut times: BTreeMap<(usize, u8, bool), f64> = BTreeMap::new();
    for stretch in &findings.story.stretches {
        let time = findings.seconds(stretch.to).zip(findings.seconds(stretch.from)).map_or(0.0, |(to, from)| to - from);
        let lobe = stretch.lobe.unwrap_or(usize::MAX);
        *times.entry((lobe, stretch.phase, stretch.is_held)).or_default() += time;
    }
    let planned_s = findings.again.as_ref().ok().map(AnyPrepared::duration_s);
    let _infallible = write!(
        out,
        "<h3>Where the time went</h3><p>The motion took {} s{}.</p>",
        fixed(whole_s, 2),
        planned_s.map_or_else(String::new, |planned| format!(", planned were {} s", fixed(planned, 2)))
    );
    let mut lobes: Vec<usize> = times.keys().map(|key| key.0).collect();
    lobes.dedup();
    let row = |lobe: &usize| {
        let name = findings.story.names().get(*lobe).map_or_else(|| "no lobe".to_owned(), |name| escape(name));
        let phases: Vec<String> = (times.iter().filter(|(key, time)| key.0 == *lobe && **time > 0.0))
            .map(|((_, phase, held), time)| {
                let phase = phase_from(*phase).map_or("waiting", phase_name);
                format!("{phase}{} {} s", if *held { " (held)" } else { "" }, fixed(*time, 2))
            })
            .collect();
        let sum: f64 = times.iter().filter(|(key, _)| key.0 == *lobe).map(|(_, time)| time).sum();
        vec![name, fixed(sum, 2), phases.join(", ")]
    };
    table(out, &[("lobe", true), ("s", false), ("of which", true)], &lobes.iter().map(row).collect::<Vec<_>>());
}

/// Bounds of the speed of every cut, and the most used limits.
fn limits(out: &mut String, findings: &Findings<'_>) {
    out.push_str("<h3>What limited it</h3>");
    let rows: Vec<Vec<String>> = match findings.again {
        Err(reason) => {
            let _infallible = write!(out, "<p class=\"none\">not known: {}</p>", escape(reason));
            return;
        }
        Ok(AnyPrepared::Ground(prepared)) => {
            let planned = summary(prepared);
            planned.lobes.iter().flat_map(|lobe| lobe.passes.iter().map(|pass| ground_row(&lobe.name, pass))).collect()
        }
        Ok(AnyPrepared::Turned(prepared)) => {
            let planned = turning_summary(prepared);
            let passes = planned.iter().flat_map(|planned| &planned.passes).enumerate();
            passes.map(|(index, pass)| turned_row(&prepared.job.spec.name, index, pass)).collect()
        }
    };
    let heads = [
        ("lobe", true),
        ("pass", true),
        ("cut s", false),
        ("C 1/min", false),
        ("peak Q′ mm²/s", false),
        ("limits of the speed, with their shares", true),
        ("highest use of an axis limit", true),
    ];
    table(out, &heads, &rows);
    out.push_str("<p class=\"faint\">From the plan that was driven: the recorded job was planned again and has the recorded plan's hash.</p>");
}

fn percent(share: f64) -> String {
    format!("{} %", fixed(100.0 * share, 0))
}

fn words(name: &str) -> String {
    name.replace("c_axis", "C").replace("x_axis", "X").replace("z_axis", "Z").replace('_', " ")
}

fn ground_row(lobe: &str, pass: &PassSummary) -> Vec<String> {
    let bounds = pass.bounds.iter().map(|bound| format!("{} {}", words(&bound.bound), percent(bound.share)));
    let max = pass.limits.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio));
    let max = max.map_or_else(String::new, |limit| {
        let at = format!("cam angle {}°", fixed(limit.cam_angle_deg, 1));
        format!("{} of {}, {} at {at}", limit.quantity, words(limit.axis), percent(limit.ratio))
    });
    vec![
        escape(lobe),
        escape(&pass.name),
        fixed(pass.cut_s, 2),
        format!("{}–{}", fixed(pass.work_speed_rpm[0], 1), fixed(pass.work_speed_rpm[1], 1)),
        fixed(pass.max_removal_mm2_s, 2),
        escape(&bounds.collect::<Vec<_>>().join(", ")),
        escape(&max),
    ]
}

fn turned_row(part: &str, index: usize, pass: &TurnedPassSummary) -> Vec<String> {
    let bounds = pass.bounds.iter().map(|bound| format!("{} {}", words(&bound.bound), percent(bound.share)));
    let max = pass.limits.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio));
    let max = max.map_or_else(String::new, |limit| {
        let at = format!("C {}°, z {} mm", fixed(limit.c_deg, 1), fixed(limit.z_mm, 2));
        format!("{} of {}, {} at {at}", limit.quantity, words(limit.axis), percent(limit.ratio))
    });
    vec![
        escape(part),
        (index + 1).to_string(),
        fixed(pass.cut_s, 2),
        format!("{}–{}", fixed(pass.spindle_rpm[0], 1), fixed(pass.spindle_rpm[1], 1)),
        "–".into(),
        escape(&bounds.collect::<Vec<_>>().join(", ")),
        escape(&max),
    ]
}

/// Actions of the operator during the run.
fn operator(out: &mut String, findings: &Findings<'_>) {
    let Some((first, last)) = findings.story.ticks else { return };
    let what = |input: &AppliedInput| match input.kind {
        AppliedInput::HOLD => Some("hold".to_owned()),
        AppliedInput::UNHOLD => Some("hold released".to_owned()),
        AppliedInput::CANCEL => Some("cancelled".to_owned()),
        AppliedInput::OVERRIDE => Some(format!("override {} %", fixed(100.0 * input.value, 0))),
        AppliedInput::ALARM => Some(format!("alarm {} came into sight", input.counts)),
        _ => None,
    };
    let rows: Vec<Vec<String>> = (findings.recorded.inputs.iter().map(|at| &at.message))
        .filter(|input| (first..=last).contains(&input.tick))
        .filter_map(|input| {
            let at = findings.seconds(input.tick).map_or_else(|| "–".into(), |at| fixed(at, 3));
            Some(vec![at, input.tick.to_string(), what(input)?])
        })
        .collect();
    out.push_str("<h3>What came from outside</h3>");
    if rows.is_empty() {
        out.push_str("<p>Nothing: no hold, no override, no cancel.</p>");
    } else {
        table(out, &[("at s", false), ("tick", false), ("what", true)], &rows);
    }
}
