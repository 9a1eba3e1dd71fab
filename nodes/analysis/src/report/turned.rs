// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A part that was turned: its form map, its worst section, and X of its last pass.

use super::chart::{Chart, Curve, Mark};
use super::columns::Columns;
use super::findings::Findings;
use super::judge::WorstError;
use super::part_drawing::DrawnSection;
use super::table::table;
use super::text::{fixed, signed, um};
use super::turned_cause;
use camwright::math::units::{deg_from_rad, rpm_from_rad_s};
use camwright_files::convert::mm_from_m;
use camwright_msgs::camwright_msgs::msg::{FormMap, TurnedPage};
use camwright_planning::AnyPrepared;
use camwright_planning::chart::{Axes, Frame, Point, Scale, round_step};
use camwright_planning::colour_scale::{ColourScale, lit};
use camwright_planning::markup::escape;
use camwright_planning::surface_view::{RadiusGrid, SurfaceView};
use std::fmt::Write as _;

/// Columns of the chart of the last pass, over C.
const COLUMNS: usize = 480;

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
        Some(map) => {
            let map = ColouredMap::new(map);
            map.figure(out, um(part.form_error_allowed));
            map.view(out, &findings.story.surface, part.form_error_max_azimuth);
        }
        None => out.push_str("<p class=\"none\">the form map is not recorded</p>"),
    }
    let (x, c) = last_pass(findings);
    out.push_str(&x.figure());
    out.push_str(&c.figure());
    out.push_str("</div></section>\n");
}

fn last_map<'a>(findings: &Findings<'a>) -> Option<&'a FormMap> {
    let map = &findings.recorded.maps.last()?.message;
    let cells = usize::try_from(map.azimuths).ok()?.checked_mul(usize::try_from(map.columns).ok()?)?;
    (cells > 0 && map.lowest.len() == cells && map.highest.len() == cells).then_some(map)
}

/// Deviation farthest from the design in each field of a map (µm), and its colours.
struct ColouredMap<'a> {
    map: &'a FormMap,
    farthest_um: Vec<f64>,
    colours: ColourScale,
}

/// Width and height of the drawings of a map, and the frame in them (their own pixels).
const MAP_SIZE: (f64, f64) = (600.0, 420.0);
const MAP_FRAME: Frame = Frame { left: 58.0, top: 24.0, width: 444.0, height: 352.0 };

/// Overlap of coloured fields, so that no gap is seen between them.
const OVERLAP: f64 = 0.5;

impl<'a> ColouredMap<'a> {
    fn new(map: &'a FormMap) -> Self {
        let farthest = |(low, high): (&f32, &f32)| {
            let (low, high) = (um(f64::from(*low)), um(f64::from(*high)));
            if low.abs() > high.abs() { low } else { high }
        };
        let farthest_um: Vec<f64> = map.lowest.iter().zip(&map.highest).map(farthest).collect();
        let colours = ColourScale::signed(farthest_um.iter().copied(), 0.01);
        Self { map, farthest_um, colours }
    }

    fn colour(&self, value: f64, light: f64) -> String {
        let [red, green, blue] = lit(self.colours.colour(self.colours.band(value)), light);
        format!("#{red:02x}{green:02x}{blue:02x}")
    }

    fn begin(out: &mut String, caption: &str, label: &str) {
        let (width, height) = MAP_SIZE;
        let _infallible = write!(
            out,
            "<figure><figcaption>{caption}</figcaption>\
             <svg class=\"map\" viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" aria-label=\"{label}\">"
        );
    }

    /// Colours with their numbers at the right, and the end of the drawing.
    fn end(&self, out: &mut String) {
        let (bands, frame) = (self.colours.bands(), MAP_FRAME);
        let (left, step) = (frame.right() + 24.0, frame.height / bands as f64);
        for band in 0..bands {
            let [red, green, blue] = self.colours.colour(band);
            let y = frame.bottom() - step * (band as f64 + 1.0);
            let _infallible = write!(
                out,
                "<rect x=\"{left:.1}\" y=\"{y:.1}\" width=\"14\" height=\"{:.1}\" fill=\"#{red:02x}{green:02x}{blue:02x}\"/>",
                step + OVERLAP
            );
        }
        for edge in 0..=bands {
            let y = frame.bottom() - step * edge as f64 + 4.0;
            let text = self.colours.scale.label(self.colours.edge(edge));
            let _infallible = write!(out, "<text class=\"start\" x=\"{:.1}\" y=\"{y:.1}\">{text}</text>", left + 19.0);
        }
        let _infallible = write!(
            out,
            "<text class=\"start\" x=\"{left:.1}\" y=\"12\">µm</text></svg>\
             <div class=\"legend\"><span>red: material is left; blue: too much is removed</span></div></figure>"
        );
    }

    /// The whole surface: azimuth to the right, z upwards.
    fn figure(&self, out: &mut String, allowed_um: f64) {
        let caption = format!(
            "Form error farthest from the design over the whole surface (µm), allowed ±{}",
            fixed(allowed_um, 1)
        );
        Self::begin(out, &caption, "form map");
        let (round, along) = (self.map.azimuths as usize, self.map.columns as usize);
        let axes = Axes {
            frame: MAP_FRAME,
            across: Scale::TURN_DEG,
            up: Scale::exactly(mm_from_m(self.map.from_z), mm_from_m(self.map.to_z), 9.0),
        };
        let (dx, dy) = (MAP_FRAME.width / round as f64, MAP_FRAME.height / along as f64);
        for (row, values) in self.farthest_um.chunks(round).enumerate() {
            let y = MAP_FRAME.bottom() - dy * (row as f64 + 1.0);
            let mut x = MAP_FRAME.left;
            for fields in values.chunk_by(|a, b| self.colours.band(*a) == self.colours.band(*b)) {
                let width = dx * fields.len() as f64;
                let _infallible = write!(
                    out,
                    "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\"/>",
                    (width + OVERLAP).min(MAP_FRAME.right() - x),
                    (dy + OVERLAP).min(MAP_FRAME.bottom() - y),
                    self.colour(fields[0], 1.0)
                );
                x += width;
            }
        }
        let (bottom, middle) = (MAP_FRAME.bottom(), MAP_FRAME.left + 0.5 * MAP_FRAME.width);
        for deg in axes.across.ticks() {
            let _infallible = write!(
                out,
                "<text class=\"mid\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                axes.x(deg),
                bottom + 16.0,
                axes.across.label(deg)
            );
        }
        for z in axes.up.ticks() {
            let _infallible = write!(
                out,
                "<text class=\"end\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                MAP_FRAME.left - 6.0,
                axes.y(z) + 4.0,
                axes.up.label(z)
            );
        }
        let _infallible = write!(
            out,
            "<text class=\"mid\" x=\"{middle:.1}\" y=\"{:.1}\">azimuth on the part from its keyway (°)</text>\
             <text class=\"start\" x=\"4\" y=\"12\">z (mm)</text>",
            bottom + 36.0
        );
        self.end(out);
    }

    /// The part in three dimensions in the same colours, with an azimuth towards the viewer.
    fn view(&self, out: &mut String, pages: &[&TurnedPage], facing_rad: f64) {
        let (round, along) = (self.map.azimuths as usize, self.map.columns as usize);
        let z_of = |row: usize| self.map.from_z + (self.map.to_z - self.map.from_z) * row as f64 / along as f64;
        let radius_mm: Vec<f64> = (0..=along).flat_map(|row| radii_at(pages, z_of(row), round)).collect();
        let grid = RadiusGrid {
            azimuths: round,
            radius_mm,
            from_mm: mm_from_m(self.map.from_z),
            to_mm: mm_from_m(self.map.to_z),
        };
        let view = SurfaceView::new(&grid, facing_rad).filter(|_| grid.radius_mm.len() == round * (along + 1));
        let Some(view) = view else {
            out.push_str("<p class=\"none\">the surface is not recorded</p>");
            return;
        };
        let caption =
            "Form error on the part in three dimensions (µm), worst place in front; one scale in all directions";
        Self::begin(out, caption, "form error in three dimensions");
        let [low, high] = view.extent();
        let frame = Frame { left: 120.0, width: MAP_FRAME.right() - 120.0, ..MAP_FRAME };
        let scale = (frame.width / (high[0] - low[0])).min(frame.height / (high[1] - low[1]));
        let middle = [frame.left + 0.5 * frame.width, frame.top + 0.5 * frame.height];
        let at = |[x, y]: Point| {
            [middle[0] + scale * (x - 0.5 * (low[0] + high[0])), middle[1] - scale * (y - 0.5 * (low[1] + high[1]))]
        };
        let polygon = |out: &mut String, points: &[Point], rest: &str| {
            out.push_str("<polygon points=\"");
            for point in points {
                let [x, y] = at(*point);
                let _infallible = write!(out, "{x:.1},{y:.1} ");
            }
            let _infallible = write!(out, "\" {rest}/>");
        };
        for face in &view.faces {
            let value = self.farthest_um[face.row * round + face.azimuth];
            let fill = format!("fill=\"{}\"", self.colour(value, face.light));
            polygon(out, &face.widened(0.7 * OVERLAP / scale), &fill);
        }
        polygon(out, &view.end, "fill=\"#e8e8e4\" stroke=\"#16202a\"");
        let length = round_step((high[0] - low[0]) / 20.0, 1.0);
        let [x, y] = [62.0, MAP_FRAME.bottom() - 60.0];
        for (name, unit) in ["x", "y", "z"].into_iter().zip(view.units) {
            let [dx, dy] = unit.map(|value| scale * length * value);
            let away = unit[0].hypot(unit[1]).max(1e-9);
            let _infallible = write!(
                out,
                "<path class=\"design\" d=\"M{x:.1} {y:.1}L{:.1} {:.1}\"/><text class=\"mid\" x=\"{:.1}\" y=\"{:.1}\">{name}</text>",
                x + dx,
                y - dy,
                x + dx + 10.0 * unit[0] / away,
                y - dy - 10.0 * unit[1] / away + 4.0
            );
        }
        let _infallible = write!(
            out,
            "<text class=\"start\" x=\"4\" y=\"{:.1}\">each line at the lower left is {length} mm long</text>",
            MAP_FRAME.bottom() + 36.0
        );
        self.end(out);
    }
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
        allowed: vec![worst.allowed_um],
        has_zero: true,
        mark: worst.azimuth_deg.map(|azimuth| Mark {
            at: (azimuth, worst.error_um),
            label: format!("{} µm at {}", signed(worst.error_um, 2), worst.place),
        }),
        across: "azimuth on the part from its keyway (°)",
        ..Chart::over_azimuth(format!("Form error round the part near z {z} mm (µm), tolerance shaded"))
    };
    let section = DrawnSection {
        lowest_um: lowest,
        highest_um: highest,
        allowed_um: vec![worst.allowed_um; radius_mm.len()],
        radius_mm,
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

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> FormMap {
        let (azimuths, columns) = (36_u32, 10_u32);
        let values: Vec<f32> = (0..azimuths * columns).map(|index| (index % azimuths) as f32 * 1e-7 - 1.8e-6).collect();
        FormMap {
            azimuths,
            columns,
            from_z: 0.0,
            to_z: 0.024,
            highest: values.iter().map(|value| value + 1e-8).collect(),
            lowest: values,
            ..FormMap::default()
        }
    }

    fn page() -> TurnedPage {
        TurnedPage {
            azimuths: 36,
            columns: 11,
            from_z: 0.0,
            to_z: 0.024,
            radius: vec![0.02; 36 * 11],
            ..TurnedPage::default()
        }
    }

    /// Texts of a drawing: left, top, right and bottom, where a letter of 12 px is 7.5 px wide on average.
    fn boxes(svg: &str) -> Vec<([f64; 4], String)> {
        let texts = svg.split("<text class=\"").skip(1).map(|rest| {
            let number = |name: &str| -> f64 {
                let value = rest.split(&format!(" {name}=\"")).nth(1).and_then(|rest| rest.split('"').next());
                value.and_then(|value| value.parse().ok()).expect("a position")
            };
            let text = rest.split('>').nth(1).and_then(|rest| rest.split('<').next()).expect("a text").to_owned();
            let (x, y, width) = (number("x"), number("y"), 7.5 * text.chars().count() as f64);
            let left = match rest.split('"').next() {
                Some("mid") => x - 0.5 * width,
                Some("end") => x - width,
                _ => x,
            };
            ([left, y - 9.5, left + width, y + 2.5], text)
        });
        texts.collect()
    }

    #[test]
    fn the_map_and_the_part_have_a_legend_and_texts_that_can_be_read() {
        let (map, page) = (map(), page());
        let coloured = ColouredMap::new(&map);
        let (mut figure, mut view) = (String::new(), String::new());
        coloured.figure(&mut figure, 5.0);
        coloured.view(&mut view, &[&page], 1.0);
        assert_eq!(view.matches("<polygon").count(), 36 / 2 * 10 + 1, "half of the faces and the end");
        for svg in [&figure, &view] {
            assert!(!svg.contains("NaN") && svg.contains(">µm</text>") && svg.contains("material is left"), "{svg}");
            for band in 0..coloured.colours.bands() {
                let [red, green, blue] = coloured.colours.colour(band);
                assert!(svg.contains(&format!("#{red:02x}{green:02x}{blue:02x}")), "{band}");
            }
            let boxes = boxes(svg);
            assert!(boxes.len() > 8, "{boxes:?}");
            for (index, (one, text)) in boxes.iter().enumerate() {
                assert!(
                    one[0] >= 0.0 && one[1] >= 0.0 && one[2] <= MAP_SIZE.0 && one[3] <= MAP_SIZE.1,
                    "{text}: {one:?}"
                );
                for (other, name) in &boxes[..index] {
                    let is_apart = one[0] >= other[2] || other[0] >= one[2] || one[1] >= other[3] || other[1] >= one[3];
                    assert!(is_apart, "{text} {one:?} overlaps {name} {other:?}");
                }
            }
        }
    }

    #[test]
    fn a_part_whose_surface_is_not_recorded_has_no_view() {
        let map = map();
        let mut out = String::new();
        ColouredMap::new(&map).view(&mut out, &[], 0.0);
        assert_eq!(out, "<p class=\"none\">the surface is not recorded</p>");
    }
}
