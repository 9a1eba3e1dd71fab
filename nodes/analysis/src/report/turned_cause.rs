// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The worst deviation of a turned part by its causes, as a table.

use super::edge::{AxisShare, ErrorSplit, turns_since};
use super::findings::Findings;
use super::table::table;
use super::text::{fixed, signed};
use camwright::machine::description::Axis;
use camwright::math::units::{deg_from_rad, um_from_mm, wrap_turn};
use camwright::toolpath::insert_path::InsertFeed;
use camwright_files::convert::mm_from_m;
use camwright_msgs::camwright_msgs::msg::TurnedResult;
use camwright_planning::AnyPrepared;
use camwright_planning::markup::escape;
use std::fmt::Write as _;

/// Causes that no sensor shows.
const REST: &str = "deflection of insert and part, wear, heat (the rest)";

/// The worst place by what left it, as a table.
pub(super) fn write(out: &mut String, findings: &Findings<'_>, part: &TurnedResult) {
    let place = format!(
        "azimuth {}°, z {} mm",
        fixed(deg_from_rad(wrap_turn(part.form_error_max_azimuth)), 1),
        fixed(mm_from_m(part.form_error_max_z), 2)
    );
    let _infallible = write!(out, "<h3>What made the worst place, {place}</h3>");
    let split = match findings.split {
        Some(Ok(split)) => split,
        Some(Err(reason)) => {
            let _infallible = write!(out, "<p class=\"none\">not known: {}</p>", escape(reason));
            return;
        }
        None => return,
    };
    let heads = [
        ("", true),
        ("off its setpoint by", false),
        ("leaves µm", false),
        ("structure off the encoder by", false),
        ("leaves µm", false),
    ];
    let [c, x, z] = split.axes;
    let dash = || "–".to_owned();
    let whole = |name: String, left_um: f64| vec![name, dash(), signed(left_um, 2), dash(), dash()];
    let names = ["X", "C, by the slope round the part", "Z, by the slope along the part"];
    let mut rows: Vec<Vec<String>> = [x, c, z].iter().zip(names).map(|(axis, name)| axis_lines(name, axis)).collect();
    rows.push(whole(cusp_name(findings), split.cusp_um));
    rows.push(whole(REST.to_owned(), split.rest_um));
    rows.push(whole("<b>form error there, the sum of all</b>".to_owned(), split.error_um));
    table(out, &heads, &rows);
    let _infallible = write!(out, "<p class=\"faint\">{}</p>", made(findings, split));
}

fn axis_lines(name: &str, axis: &AxisShare) -> Vec<String> {
    let unit = |off: f64| match axis.axis {
        Axis::C => format!("{}°", signed(deg_from_rad(off), 4)),
        Axis::X | Axis::Z => format!("{} µm", signed(um_from_mm(off), 2)),
    };
    let swing = axis.swing.map_or_else(|| ["–".into(), "–".into()], |off| [unit(off), signed(axis.swing_um, 2)]);
    let [off, left] = swing;
    vec![name.to_owned(), unit(axis.lag), signed(axis.lag_um, 2), off, left]
}

fn cusp_name(findings: &Findings<'_>) -> String {
    let Ok(AnyPrepared::Turned(prepared)) = findings.again else { return "cusp of the feed".into() };
    let (InsertFeed::AlongZ(feed_mm) | InsertFeed::AlongCurve(feed_mm)) = prepared.job.spec.feed;
    let along = if matches!(prepared.job.spec.feed, InsertFeed::AlongZ(_)) { "Z" } else { "the curve" };
    let radius =
        prepared.machine.insert.map_or_else(String::new, |insert| format!(", R {} mm", fixed(insert.radius_mm, 2)));
    format!("cusp of the feed, {} mm a turn along {along}{radius}", fixed(feed_mm, 3))
}

/// Which tick made the place, and how the figures are found.
fn made(findings: &Findings<'_>, split: &ErrorSplit) -> String {
    let pass = findings.motion.zip(findings.story.last_cut(0)).map_or(&[][..], |(motion, pass)| motion.within(pass));
    let [c, x, z] = split.position;
    let turn = turns_since(pass, c)
        .map_or_else(String::new, |turns| format!(", {} turns after the pass began", fixed(turns, 2)));
    let time = findings.seconds(split.tick).map_or_else(String::new, |s| format!(" ({} s)", fixed(s, 3)));
    format!(
        "The edge made that place in tick {}{time}{turn}, with C at {}°, the insert's centre at X {} mm and z {} mm. What an axis leaves is found by \
         letting the edge come by in that turn with this axis where it was and the others on their setpoints; along the normal, positive where material is left.",
        split.tick,
        fixed(deg_from_rad(wrap_turn(c)), 2),
        fixed(x, 3),
        fixed(z, 3)
    )
}
