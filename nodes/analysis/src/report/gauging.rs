// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Gauge readings, and runout of the journals before and after their correction.

use super::chart::{Chart, Curve};
use super::columns::Columns;
use super::findings::Findings;
use super::head::COLUMNS;
use super::table::table;
use super::text::{fixed, um};
use camwright::math::range::minimum_and_maximum;
use camwright::math::units::{TURN_RAD, deg_from_rad, mm_from_um, wrap_turn};
use camwright::planner::JournalReadings;
use camwright_files::convert::{gauge, m_from_mm};
use camwright_msgs::camwright_msgs::msg::{GaugeReading, LobeResult};
use camwright_planning::markup::escape;
use camwright_planning::{AnyPrepared, correct};
use std::fmt::Write as _;

/// Tolerance of the angle of a gauge after its conversion in a message (rad).
const SAME_RAD: f64 = 1e-9;

pub(super) fn write(out: &mut String, findings: &Findings<'_>) {
    let corrected: Vec<&LobeResult> = findings.story.status.map_or_else(Vec::new, |status| {
        status.lobes.iter().filter(|lobe| lobe.runout_before > 0.0 || lobe.machine_stiffness > 0.0).collect()
    });
    if corrected.is_empty() && findings.story.gauge.is_empty() {
        return;
    }
    out.push_str("<section id=\"gauge\"><h2>Gauge and runout</h2>");
    if !corrected.is_empty() {
        results(out, &corrected);
    }
    finishing(out, findings);
    out.push_str("<div class=\"figures\">");
    for (index, name) in findings.story.names().iter().enumerate() {
        let readings: Vec<&GaugeReading> =
            findings.story.gauge.iter().copied().filter(|reading| reading.lobe == *name && !reading.pushing).collect();
        if !readings.is_empty() {
            out.push_str(&diameter(findings, index, name, &readings).figure());
        }
        if let Some(chart) = outline(findings, name) {
            out.push_str(&chart.figure());
        }
    }
    out.push_str("</div></section>\n");
}

fn results(out: &mut String, lobes: &[&LobeResult]) {
    // N/m and N/µm differ as µm and m do, the other way round.
    let n_um = |n_m: f64| mm_from_um(m_from_mm(n_m));
    let given = |value: f64, text: String| if value > 0.0 { text } else { "–".to_owned() };
    let row = |lobe: &&LobeResult| {
        vec![
            escape(&lobe.name),
            given(lobe.runout_before, fixed(um(lobe.runout_before), 2)),
            given(lobe.runout_limit, fixed(um(lobe.runout_expected), 2)),
            given(lobe.runout_limit, fixed(um(lobe.runout_limit), 2)),
            given(lobe.runout, fixed(um(lobe.runout), 3)),
            given(lobe.spark_out_turns, fixed(lobe.spark_out_turns.ceil(), 0)),
            given(
                lobe.machine_stiffness,
                format!(
                    "{} ± {}",
                    fixed(n_um(lobe.machine_stiffness), 2),
                    fixed(n_um(lobe.machine_stiffness_uncertainty), 2)
                ),
            ),
            given(
                lobe.grinding_stiffness,
                format!(
                    "{} ± {}",
                    fixed(n_um(lobe.grinding_stiffness), 1),
                    fixed(n_um(lobe.grinding_stiffness_uncertainty), 1)
                ),
            ),
        ]
    };
    let heads = [
        ("journal", true),
        ("runout before µm", false),
        ("expected after it µm", false),
        ("below, in 95 of 100 cases µm", false),
        ("after µm", false),
        ("turns that sparking out would take", false),
        ("stiffness of machine N/µm", false),
        ("of the cut N/µm", false),
    ];
    table(out, &heads, &lobes.iter().map(row).collect::<Vec<_>>());
}

/// First tick of the second half; `None` before it begins.
fn second_half(findings: &Findings<'_>) -> Option<u64> {
    findings.story.stretches.iter().find(|stretch| stretch.plan > 0).map(|stretch| stretch.from)
}

/// Finishing turns, decided again from the recorded readings of the first half.
fn finishing(out: &mut String, findings: &Findings<'_>) {
    let (Ok(AnyPrepared::Ground(prepared)), Some(split)) = (findings.again, second_half(findings)) else { return };
    if !prepared.has_finishing_turns() {
        return;
    }
    let Some(machine_gauge) = prepared.machine.gauge else { return };
    let log = |name: &String| {
        let mut readings = JournalReadings::default();
        for reading in findings.story.gauge.iter().filter(|reading| reading.lobe == *name && reading.tick < split) {
            let is_second = (reading.gauge_angle - machine_gauge.behind_wheel_rad).abs() > SAME_RAD;
            gauge::log(&mut readings, reading, is_second);
        }
        readings
    };
    let logs: Vec<JournalReadings> = findings.story.names().iter().map(log).collect();
    let text = match correct(prepared, &logs) {
        Ok(again) if findings.story.plans.iter().any(|(hash, _)| hash == again.plan_hash()) => {
            let lines = again.finishing_lines(prepared).join("; ");
            format!(
                "{lines}. Decided again from the recorded readings: the same second plan ({:.12})",
                again.plan_hash()
            )
        }
        Ok(again) => format!("the recorded readings give another second plan here ({:.12})", again.plan_hash()),
        Err(error) => error.to_string(),
    };
    let _infallible = write!(out, "<p>Finishing turns: {}.</p>", escape(&text));
}

/// The reading of the gauge over the last turn of each half of the job, from its mean.
fn diameter(findings: &Findings<'_>, index: usize, name: &str, readings: &[&GaugeReading]) -> Chart {
    let split = findings.story.stretches.iter().find(|s| s.plan > 0 && s.lobe == Some(index)).map(|s| s.from);
    let split = split.unwrap_or(u64::MAX);
    let half = |is_first: bool| {
        let of: Vec<&&GaugeReading> = readings.iter().filter(|reading| (reading.tick < split) == is_first).collect();
        let last = of.last().map_or(0.0, |reading| reading.spindle_angle);
        let turn: Vec<(f64, f64)> = (of.iter().filter(|reading| (last - reading.spindle_angle).abs() <= TURN_RAD))
            .map(|reading| {
                let at = findings.sense() * reading.spindle_angle;
                (deg_from_rad(wrap_turn(at)), um(reading.reading))
            })
            .collect();
        let (min, max) = minimum_and_maximum(turn.iter().map(|point| point.1));
        let middle = 0.5 * (min + max);
        let size = mm_from_um(middle);
        let points =
            Columns::from_points(0.0, 360.0, COLUMNS, turn.iter().map(|(at, value)| (*at, value - middle))).points();
        (points, size, max - min)
    };
    let curve = |class, when: &str, (points, size, range): (Vec<(f64, f64)>, f64, f64)| Curve {
        class,
        name: format!("{when}: about {} mm, {} µm from least to most", fixed(size, 4), fixed(range, 2)),
        points,
    };
    let kind = if readings.iter().any(|reading| reading.kind == GaugeReading::RADIUS) { "radius" } else { "diameter" };
    Chart {
        across: "azimuth of the wheel's line on the part (°)",
        curves: vec![
            curve("other", "last turn before the correction", half(true)),
            curve("is", "last turn of all", half(false)),
        ],
        has_zero: true,
        ..Chart::over_azimuth(format!("{name}: reading of the gauge, a {kind}, from its middle (µm)"))
    }
}

/// The outline of a journal from its mean: what it runs out by now.
fn outline(findings: &Findings<'_>, name: &str) -> Option<Chart> {
    let result = findings.story.status?.lobes.iter().find(|lobe| lobe.name == name && lobe.runout_before > 0.0)?;
    let part = findings.story.outlines.iter().find(|part| part.name == name && !part.radius.is_empty())?;
    let (min, max) = minimum_and_maximum(part.radius.iter().copied());
    let middle = 0.5 * (min + max);
    let count = part.radius.len() as f64;
    let points = part.radius.iter().enumerate().map(|(at, r)| (360.0 * at as f64 / count, um(r - middle)));
    let curve = Curve {
        class: "is",
        name: format!(
            "ran out by {} µm before, now by {} µm",
            fixed(um(result.runout_before), 2),
            fixed(um(result.runout), 3)
        ),
        points: Columns::from_points(0.0, 360.0, COLUMNS, points).points(),
    };
    Some(Chart {
        curves: vec![curve],
        has_zero: true,
        ..Chart::over_azimuth(format!("{name}: distance of the outline from the axis, from its middle (µm)"))
    })
}
