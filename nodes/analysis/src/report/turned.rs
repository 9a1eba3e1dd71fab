//! A part that was turned: its form map, its worst section, and X of its last pass.

use super::chart::{Chart, Curve, Mark};
use super::columns::Columns;
use super::findings::Findings;
use super::judge::WorstError;
use super::part_drawing::DrawnSection;
use super::table::table;
use super::text::{escape, fixed, signed, um};
use super::turned_cause;
use camwright::math::units::{deg_from_rad, rpm_from_rad_s};
use camwright_files::convert::mm_from_m;
use camwright_msgs::camwright_msgs::msg::{FormMap, TurnedPage};
use camwright_planning::AnyPrepared;
use std::fmt::Write as _;

/// Columns of the chart of the last pass, over C.
const COLUMNS: usize = 480;

/// Shades of the map on either side of 0.
const SHADES: f64 = 4.0;

pub(super) fn write(out: &mut String, findings: &Findings<'_>) {
    let Some(part) = findings.story.status.and_then(|status| status.turned.first()) else { return };
    out.push_str("<section id=\"turned\"><h2>Turned part</h2>");
    let heads = [
        ("part", true),
        ("passes", false),
        ("turns", false),
        ("time s (late by)", false),
        ("highest µm", false),
        ("lowest µm", false),
        ("rms µm", false),
        ("allowed µm", false),
        ("cusps µm", false),
        ("cusps of feed and design µm", false),
    ];
    let late = match findings.again {
        Ok(AnyPrepared::Turned(prepared)) => {
            format!(" ({})", signed(part.duration - camwright_planning::turning_s(prepared), 2))
        }
        _ => String::new(),
    };
    let cusp = if part.cusp_height > 0.0 { fixed(um(part.cusp_height), 2) } else { "–".into() };
    let row = vec![
        escape(&part.name),
        part.passes.to_string(),
        fixed(part.turns, 1),
        format!("{}{late}", fixed(part.duration, 2)),
        signed(um(part.form_error_highest), 2),
        signed(um(part.form_error_lowest), 2),
        fixed(um(part.form_error_rms), 2),
        format!("±{}", fixed(um(part.form_error_allowed), 2)),
        cusp,
        fixed(um(part.cusp_height_theory), 2),
    ];
    table(out, &heads, &[row]);
    turned_cause::write(out, findings, part);
    out.push_str("<div class=\"figures\">");
    match last_map(findings) {
        Some(map) => map_figure(out, map, um(part.form_error_allowed)),
        None => out.push_str("<p class=\"none\">the form map is not recorded</p>"),
    }
    out.push_str("<div>");
    let (x, c) = last_pass(findings);
    out.push_str(&x.figure());
    out.push_str(&c.figure());
    out.push_str("</div></div></section>\n");
}

fn last_map<'a>(findings: &Findings<'a>) -> Option<&'a FormMap> {
    let map = &findings.recorded.maps.last()?.message;
    let cells = usize::try_from(map.azimuths).ok()?.checked_mul(usize::try_from(map.columns).ok()?)?;
    (cells > 0 && map.lowest.len() == cells && map.highest.len() == cells).then_some(map)
}

/// The whole surface: azimuth to the right, place along the part downwards, coloured by the farthest deviation of each field.
fn map_figure(out: &mut String, map: &FormMap, allowed_um: f64) {
    let (round, along) = (map.azimuths as usize, map.columns as usize);
    let (width, height, left, bottom) = (600.0, 420.0, 58.0, 36.0);
    let (dx, dy) = ((width - left - 18.0) / round as f64, (height - bottom - 10.0) / along as f64);
    let farthest = |index: usize| {
        let (low, high) = (um(f64::from(map.lowest[index])), um(f64::from(map.highest[index])));
        if low.abs() > high.abs() { low } else { high }
    };
    let max = (0..round * along).map(|index| farthest(index).abs()).fold(1e-3, f64::max);
    let mut paths = [const { String::new() }; 8];
    for column in 0..along {
        for azimuth in 0..round {
            let value = farthest(column * round + azimuth);
            #[allow(clippy::cast_possible_truncation, reason = "between 0 and 3")]
            let shade = ((value.abs() / max * SHADES) as usize).min(3);
            let path = &mut paths[shade + if value < 0.0 { 4 } else { 0 }];
            let (x, y) = (left + azimuth as f64 * dx, 10.0 + column as f64 * dy);
            let _infallible = write!(path, "M{x:.1} {y:.1}h{dx:.2}v{dy:.2}h-{dx:.2}z");
        }
    }
    let _infallible = write!(
        out,
        "<figure><figcaption>Form error farthest from the design over the whole surface (µm), allowed ±{}</figcaption>\
         <svg class=\"map\" viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" aria-label=\"form map\">",
        fixed(allowed_um, 1)
    );
    let classes = ["h1", "h2", "h3", "h4", "l1", "l2", "l3", "l4"];
    for (path, class) in paths.iter().zip(classes).filter(|(path, _)| !path.is_empty()) {
        let _infallible = write!(out, "<path class=\"{class}\" d=\"{path}\"/>");
    }
    for tick in 0..=6 {
        let share = f64::from(tick) / 6.0;
        let x = left + share * (width - left - 18.0);
        let _infallible = write!(
            out,
            "<text class=\"mid\" x=\"{x:.1}\" y=\"{:.1}\">{}</text>",
            height - bottom + 15.0,
            fixed(360.0 * share, 0)
        );
        let z = mm_from_m(map.from_z + (map.to_z - map.from_z) * share);
        let y = 10.0 + share * (height - bottom - 10.0);
        let _infallible =
            write!(out, "<text class=\"end\" x=\"{:.1}\" y=\"{:.1}\">{}</text>", left - 6.0, y + 4.0, fixed(z, 1));
    }
    let _infallible = write!(
        out,
        "<text class=\"mid\" x=\"{:.1}\" y=\"{:.1}\">azimuth (°); z (mm) downwards</text></svg>\
         <div class=\"legend\"><span>red: material is left, blue: too much is gone; darkest {} µm and more, four equal steps</span></div></figure>",
        0.5 * (left + width),
        height - 4.0,
        fixed(0.75 * max, 2)
    );
}

/// X over C of the last pass, and the speed of C.
fn last_pass(findings: &Findings<'_>) -> (Chart, Chart) {
    let samples = match (findings.motion, findings.story.last_cut(0)) {
        (Some(motion), Some(cut)) => motion.within(cut),
        _ => &[],
    };
    let first = samples.first().map_or(0.0, |sample| sample.position[0]);
    let turns = |c: f64| deg_from_rad(c - first) / 360.0;
    let to = samples.last().map_or(1.0, |sample| turns(sample.position[0])).max(1e-6);
    let curve = |name: &str, of: &dyn Fn(&super::motion::MotionSample) -> f64| {
        let points = samples.iter().map(|sample| (turns(sample.position[0]), of(sample)));
        vec![Curve { class: "is", name: name.into(), points: Columns::from_points(0.0, to, COLUMNS, points).points() }]
    };
    let step =
        [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0].into_iter().find(|step| to / step <= 12.0);
    let chart = |title: &str, curves: Vec<Curve>| Chart {
        title: title.into(),
        across: "turns of C in the last pass",
        from: 0.0,
        to,
        step: step.unwrap_or(to),
        curves,
        ..Chart::default()
    };
    (
        chart(
            "X over C, last pass (mm)",
            curve("X as its encoder read it, least and most of each stretch", &|s| mm_from_m(s.position[1])),
        ),
        chart("Speed of C, last pass (1/min)", curve("measured", &|s| rpm_from_rad_s(s.velocity[0]))),
    )
}

/// The section in which the part is worst, as a drawing and as a curve.
pub(super) fn worst_section(findings: &Findings<'_>, worst: &WorstError) -> Option<(DrawnSection, Chart)> {
    let part = findings.story.status?.turned.first()?;
    let map = last_map(findings)?;
    let (round, along) = (map.azimuths as usize, map.columns as usize);
    let share = (part.form_error_max_z - map.from_z) / (map.to_z - map.from_z);
    #[allow(clippy::cast_possible_truncation, reason = "saturates, and is brought into the map")]
    let column = ((share * along as f64).max(0.0) as usize).min(along - 1);
    let of = |values: &[f32]| -> Vec<f64> {
        values[column * round..(column + 1) * round].iter().map(|value| um(f64::from(*value))).collect()
    };
    let (lowest, highest) = (of(&map.lowest), of(&map.highest));
    let radius_mm = radii_at(&findings.story.surface, part.form_error_max_z, round);
    let z = fixed(mm_from_m(part.form_error_max_z), 2);
    let title = format!("Section at z {z} mm, and its form error");
    let points = |values: &[f64]| -> Vec<(f64, f64)> {
        values.iter().enumerate().map(|(at, value)| (360.0 * (at as f64 + 0.5) / round as f64, *value)).collect()
    };
    let curve = |class, name: &str, values: &[f64]| Curve { class, name: name.into(), points: points(values) };
    let chart = Chart {
        curves: vec![curve("is", "highest in each field", &highest), curve("other", "lowest in each field", &lowest)],
        allowed: Some(worst.allowed_um),
        has_zero: true,
        mark: worst.azimuth_deg.map(|azimuth| Mark {
            at: (azimuth, worst.error_um),
            label: format!("{} µm at {}", signed(worst.error_um, 2), worst.place),
        }),
        across: "azimuth on the part from its keyway (°)",
        ..Chart::over_azimuth(format!("Form error round the part near z {z} mm (µm), tolerance shaded"))
    };
    let section = DrawnSection {
        radius_mm,
        lowest_um: lowest,
        highest_um: highest,
        allowed_um: worst.allowed_um,
        key_way_deg: Some(0.0),
        worst: worst.azimuth_deg.map(|azimuth| (azimuth, worst.error_um)),
        title,
    };
    Some((section, chart))
}

/// Radii of the turned surface at a place along it, at so many azimuths (mm); empty where not all of it is recorded.
fn radii_at(pages: &[&TurnedPage], z: f64, count: usize) -> Vec<f64> {
    let Some(first) = pages.first() else { return Vec::new() };
    let (round, along) = (first.azimuths as usize, first.columns as usize);
    let share = if along > 1 { (z - first.from_z) / (first.to_z - first.from_z) } else { 0.0 };
    #[allow(clippy::cast_possible_truncation, reason = "saturates, and is brought into the part")]
    let column = ((share * along.saturating_sub(1) as f64).round().max(0.0) as usize).min(along.saturating_sub(1));
    let radius = |azimuth: usize| {
        let index = u64::try_from(column.checked_mul(round)?.checked_add(azimuth)?).ok()?;
        pages.iter().find_map(|page| {
            let within = usize::try_from(index.checked_sub(page.first)?).ok()?;
            page.radius.get(within).copied()
        })
    };
    let at = |index: usize| radius(index * round / count.max(1)).map(mm_from_m);
    (0..count).map(at).collect::<Option<Vec<f64>>>().unwrap_or_default()
}
