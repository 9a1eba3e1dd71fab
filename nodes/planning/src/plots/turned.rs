// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Drawings of a turned part by `camwright plan --plots`.
//!
//! | name | shows |
//! |---|---|
//! | `surface_map` | radius of the design over azimuth and z, as colours |
//! | `surface_view` | the design seen from the side, in the same colours |
//! | `section` | sections in the rake plane all round, the insert and the path of its centre in the last pass |
//! | `x_axis` | the turn that asks most of X: its place, speed, acceleration and jerk with what is allowed of them, and the spindle's speed |
//! | `clearance` | the angles between insert and surface over a turn, with what is asked of them |

use super::chart::{CURVE_MM, HALF_MM, SMALL, TurnChart, plane_axes};
use super::contour::PartView;
use super::curves::{ALLOWED, LIMIT, frame};
use super::sheet::{Legend, ROOM, sheet};
use crate::chart::{Axes, Frame, Scale, round_step};
use crate::colour_scale::{ColourScale, Rgb, lit};
use crate::drawing::{Anchor, Colour, Dash, Drawing, Lettering, Pen, Plot, Point};
use crate::surface_view::{RadiusGrid, SurfaceView};
use crate::turning::clearance_rows::{ClearanceRow, MinimumAngle};
use crate::turning::prepared::PreparedTurning;
use crate::turning::summary::TurningSummary;
use crate::turning::walk::{PassPoint, points};
use camwright::machine::description::Axis;
use camwright::math::units::{TURN_RAD, rad_from_deg, rpm_from_rad_s};
use camwright::motion::point_to_point::MOVE_SHARE;
use camwright::motion::speed_plan::LimitedQuantity;
use camwright::planner::PlannedPass;
use camwright::toolpath::insert_clearance::beside_centre;
use camwright::toolpath::rake_section::RakeSection;

const CURVE: Pen = Pen::solid(Colour(0, 114, 178), CURVE_MM);
const OUTLINE: Pen = Pen::solid(Colour::BLACK, 0.4);
const SECTION: Pen = Pen::solid(Colour(170, 170, 170), 0.2);
const CENTRES: Pen = Pen::solid(Colour(0, 114, 178), 0.3);
const BAR: Pen = Pen { colour: Colour(150, 90, 40), width_mm: 0.22, dash: Dash::Centre };
const ENDS: Pen = Pen::dashed(Colour::GREY, 0.2);

/// Turned angles between the sections that are drawn (deg), and points of each.
const SECTIONS_DEG: u16 = 30;
const SECTION_POINTS: u32 = 300;

/// A limit is drawn where at least this share of it is used.
const NEAR: f64 = 0.25;

/// All drawings of a turned part.
pub(crate) fn turned_plots(prepared: &PreparedTurning, summary: &TurningSummary, rows: &[ClearanceRow]) -> Vec<Plot> {
    let Some(pass) = prepared.planned.passes.last() else { return Vec::new() };
    let of = Turned { prepared, summary, pass };
    let plot =
        |name: &str, caption: &str, drawing: Drawing| Plot { name: name.into(), caption: caption.into(), drawing };
    vec![
        plot("surface_map", "The finished surface unrolled; its colours show the radius.", of.surface_map()),
        plot("surface_view", "The finished part in three dimensions, in the same colours.", of.surface_view()),
        plot("section", "Sections of the part with the insert and the path of its centre.", of.section()),
        plot("x_axis", "X over the turn that uses its limits most.", of.x_axis()),
        plot("clearance", "Angles between insert and surface, with the minimum allowed.", of.clearance(rows)),
    ]
}

/// Azimuths and rows of the surface as a map and as a view.
const MAP_SIZE: [u32; 2] = [360, 96];
const VIEW_SIZE: [u32; 2] = [180, 48];

/// Range of radii below which colours would show nothing but rounding (mm).
const MIN_RANGE_MM: f64 = 0.002;

/// The map and the view beside their legend of colours.
const COLOURED: Frame = Frame { width: 212.0, ..ROOM };

/// Overlap of fields of the map and of faces of the view, so that no gap is seen between them at any size (mm).
const MAP_OVERLAP_MM: f64 = 1.5;
const VIEW_OVERLAP_MM: f64 = 0.3;

const END_FACE: Colour = Colour(232, 232, 228);

fn paint([red, green, blue]: Rgb) -> Colour {
    Colour(red, green, blue)
}

/// Legend of the colours at the right of a sheet.
fn colour_legend(drawing: &mut Drawing, scale: &ColourScale, name: &str) {
    let frame = Frame { left: COLOURED.right() + 9.0, width: 6.0, ..COLOURED };
    let height = frame.height / scale.bands() as f64;
    for band in 0..scale.bands() {
        let bottom = frame.bottom() - height * band as f64;
        let corners = [
            [frame.left, bottom],
            [frame.right(), bottom],
            [frame.right(), bottom - height],
            [frame.left, bottom - height],
        ];
        drawing.area(&corners, paint(scale.colour(band)));
    }
    for edge in 0..=scale.bands() {
        let y = frame.bottom() - height * edge as f64;
        drawing.line(&[[frame.left, y], [frame.right() + 1.0, y]], Pen::solid(Colour::BLACK, 0.15));
        let number = Lettering { anchor: Anchor::Start, ..SMALL };
        drawing.text([frame.right() + 2.0, y + HALF_MM], number, &scale.scale.label(scale.edge(edge)));
    }
    drawing.line(&frame.corners(), Pen::solid(Colour::BLACK, 0.25));
    drawing.text([frame.left, frame.top - 3.0], Lettering { anchor: Anchor::Start, ..SMALL }, name);
}

struct Turned<'a> {
    prepared: &'a PreparedTurning,
    summary: &'a TurningSummary,
    pass: &'a PlannedPass,
}

impl Turned<'_> {
    fn begin(&self, shows: &str) -> Drawing {
        let made_of = format!(
            "insert R {:.3} mm, {}, machine {}",
            self.summary.insert_radius_mm,
            beside_centre(self.summary.clearance.below_centre_mm),
            self.summary.machine
        );
        let title = format!("{} · turned", self.summary.job);
        sheet(&title, shows, &made_of, &format!("plan {:.16}", self.prepared.plan_hash()))
    }

    /// Radii of the design at the middle of each field of a map, or at the corners of the faces of a view (mm).
    fn radii(&self, [azimuths, rows]: [u32; 2], z_of: impl Fn(u32) -> f64, shift: f64) -> Vec<f64> {
        let surface = &self.prepared.job.spec.surface;
        let turn = |azimuth: u32| TURN_RAD * (f64::from(azimuth) + shift) / f64::from(azimuths);
        (0..rows)
            .flat_map(|row| (0..azimuths).map(move |azimuth| (row, azimuth)))
            .map(|(row, azimuth)| surface.radius(turn(azimuth), z_of(row)))
            .collect()
    }

    /// The surface rolled off, coloured by its radius.
    fn surface_map(&self) -> Drawing {
        let (from, to) = self.prepared.job.spec.surface.ends_mm();
        let [azimuths, rows] = MAP_SIZE;
        let z_of = |row: u32| from + (to - from) * (f64::from(row) + 0.5) / f64::from(rows);
        let radii = self.radii(MAP_SIZE, z_of, 0.5);
        let scale = ColourScale::growing(radii.iter().copied(), MIN_RANGE_MM);
        let shows =
            format!("finished surface from z {from} to {to} mm, coloured by its distance from the spindle axis");
        let mut drawing = self.begin(&shows);
        let up = Scale::exactly(from, to, COLOURED.height / 10.0);
        let chart = TurnChart(Axes { frame: COLOURED, across: Scale::TURN_DEG, up });
        let (width, height) = (COLOURED.width / f64::from(azimuths), COLOURED.height / f64::from(rows));
        for (row, radii) in (0_u32..).zip(radii.chunks(azimuths as usize)) {
            let bottom = COLOURED.bottom() - height * f64::from(row);
            let top = (bottom - height - MAP_OVERLAP_MM).max(COLOURED.top);
            let mut left = COLOURED.left;
            for fields in radii.chunk_by(|a, b| scale.band(*a) == scale.band(*b)) {
                let right = left + width * fields.len() as f64;
                let end = (right + MAP_OVERLAP_MM).min(COLOURED.right());
                let corners = [[left, bottom], [end, bottom], [end, top], [left, top]];
                drawing.area(&corners, paint(scale.colour(scale.band(fields[0]))));
                left = right;
            }
        }
        chart.axes_over(&mut drawing, "z (mm)", Some("azimuth on the part from its keyway (deg)"));
        colour_legend(&mut drawing, &scale, "radius (mm)");
        drawing
    }

    /// The part in three dimensions.
    fn surface_view(&self) -> Drawing {
        let (from, to) = self.prepared.job.spec.surface.ends_mm();
        let [azimuths, rows] = VIEW_SIZE;
        let z_of = |row: u32| from + (to - from) * f64::from(row) / f64::from(rows - 1);
        let radius_mm = self.radii(VIEW_SIZE, z_of, 0.0);
        let scale = ColourScale::growing(radius_mm.iter().copied(), MIN_RANGE_MM);
        let mut drawing =
            self.begin("finished surface from the side: parallel projection, one scale in all directions");
        let grid = RadiusGrid { azimuths: azimuths as usize, radius_mm, from_mm: from, to_mm: to };
        // The highest place of the surface is on the side that is seen.
        let highest = (0..grid.radius_mm.len()).max_by(|a, b| grid.radius_mm[*a].total_cmp(&grid.radius_mm[*b]));
        let facing_rad = highest.map_or(0.0, |index| TURN_RAD * (index % grid.azimuths) as f64 / grid.azimuths as f64);
        let Some(view) = SurfaceView::new(&grid, facing_rad) else { return drawing };
        let [low, high] = view.extent();
        let (width, height) = (COLOURED.width - 44.0, COLOURED.height - 8.0);
        let per_mm = (width / (high[0] - low[0])).min(height / (high[1] - low[1]));
        let middle = [COLOURED.right() - 0.5 * width - 2.0, COLOURED.top + 0.5 * COLOURED.height];
        let at = |[x, y]: Point| {
            [middle[0] + per_mm * (x - 0.5 * (low[0] + high[0])), middle[1] - per_mm * (y - 0.5 * (low[1] + high[1]))]
        };
        let round = grid.azimuths;
        for face in &view.faces {
            let corners: Vec<Point> = face.widened(VIEW_OVERLAP_MM / per_mm).into_iter().map(at).collect();
            let next = face.row * round + (face.azimuth + 1) % round;
            let here = face.row * round + face.azimuth;
            let mean =
                0.25 * [here, next, here + round, next + round].iter().map(|index| grid.radius_mm[*index]).sum::<f64>();
            drawing.area(&corners, paint(lit(scale.colour(scale.band(mean)), face.light)));
        }
        let end: Vec<Point> = view.end.iter().chain(view.end.first()).map(|point| at(*point)).collect();
        drawing.area(&end, END_FACE);
        drawing.line(&end, OUTLINE);
        for (deg, share) in [(0_u16, 0.0), (90, 0.25), (180, 0.5), (270, 0.75)] {
            #[allow(clippy::cast_possible_truncation, reason = "an azimuth of the view")]
            let [x, y] = view.end[(share * round as f64) as usize];
            let inside = [0.78 * x + 0.22 * view.end_centre[0], 0.78 * y + 0.22 * view.end_centre[1]];
            let [x, y] = at(inside);
            drawing.text([x, y + HALF_MM], SMALL, &format!("{deg}°"));
        }
        // A length along each axis to measure by.
        let length = round_step((high[0] - low[0]) / 20.0, 1.0);
        let [x, y] = [COLOURED.left + 12.0, COLOURED.bottom() - 22.0];
        for (name, unit) in ["x", "y", "z"].into_iter().zip(view.units) {
            let tip = [x + per_mm * length * unit[0], y - per_mm * length * unit[1]];
            drawing.line(&[[x, y], tip], OUTLINE);
            let away = unit[0].hypot(unit[1]);
            let text = [tip[0] + 4.0 * unit[0] / away, tip[1] - 4.0 * unit[1] / away + HALF_MM];
            drawing.text(text, SMALL, name);
        }
        let text = Lettering { anchor: Anchor::Start, ..SMALL };
        drawing.text(
            [COLOURED.left, COLOURED.bottom() + 9.5],
            text,
            &format!("each line at the left is {length} mm long; numbers on the end face: azimuth from the keyway"),
        );
        colour_legend(&mut drawing, &scale, "radius (mm)");
        drawing
    }

    /// Sections with the insert, z to the right and x up, both to one scale.
    fn section(&self) -> Drawing {
        let shows = format!(
            "sections in the rake plane every {SECTIONS_DEG}° of C, the insert and the path of its centre in the last pass"
        );
        let mut drawing = self.begin(&shows);
        let (spec, insert_mm) = (&self.prepared.job.spec, self.summary.insert_radius_mm);
        let plane_mm = self.pass.path.request().plane_y_mm;
        let in_plane = |radius: f64| (radius * radius - plane_mm * plane_mm).max(0.0).sqrt();
        let (from, to) = spec.range_mm();
        let (start, end) = (self.pass.path.x().start(), self.pass.path.x().end());
        let z_of = |turned: f64| self.pass.path.z_at(turned).value;
        let left = z_of(start).min(z_of(end)) - insert_mm;
        let right = z_of(start).max(z_of(end)) + insert_mm;
        let low = in_plane(self.summary.radius_mm[0]) - 2.0;
        let high = (self.pass.path.x_range_mm().1 + insert_mm).max(in_plane(spec.bar_radius_mm)) + 1.0;
        let scale = (ROOM.width / (right - left)).min(ROOM.height / (high - low));
        let centre = [
            ROOM.left + 0.5 * ROOM.width - scale * 0.5 * (left + right),
            ROOM.top + 0.5 * ROOM.height + scale * 0.5 * (low + high),
        ];
        let view = PartView { frame: ROOM, centre, scale, turn_rad: 0.0 };
        let line = |drawing: &mut Drawing, points: Vec<Point>, pen: Pen| view.line(drawing, points.into_iter(), pen);
        if let Ok(section) = RakeSection::new(&spec.surface, plane_mm, from, to) {
            for deg in (0..360_u16).step_by(usize::from(SECTIONS_DEG)).rev() {
                let turned = rad_from_deg(f64::from(deg));
                let places =
                    (0..=SECTION_POINTS).map(|k| from + (to - from) * f64::from(k) / f64::from(SECTION_POINTS));
                let points = places.filter_map(|z| Some([z, section.point(turned, z).ok()?.x_mm])).collect();
                line(&mut drawing, points, if deg == 0 { OUTLINE } else { SECTION });
            }
        }
        for deg in (0..360_u16).step_by(usize::from(SECTIONS_DEG)).rev() {
            // The same angle, turn after turn.
            let first = start + (rad_from_deg(f64::from(deg)) - start).rem_euclid(TURN_RAD);
            #[allow(clippy::cast_possible_truncation, reason = "turns of a path are bounded")]
            let turns = ((end - first) / TURN_RAD).max(0.0) as u32;
            let at = |turn: u32| {
                let turned = first + f64::from(turn) * TURN_RAD;
                [z_of(turned), self.pass.path.x().sample(turned).value]
            };
            let pen = if deg == 0 { Pen { width_mm: CURVE_MM, ..CENTRES } } else { Pen { width_mm: 0.12, ..CENTRES } };
            line(&mut drawing, (0..=turns).map(at).collect(), pen);
            if deg == 0 {
                view.circle(&mut drawing, at(turns / 2), insert_mm, OUTLINE);
                for turn in [0, turns] {
                    view.circle(&mut drawing, at(turn), insert_mm, ENDS);
                }
            }
        }
        let bar = in_plane(spec.bar_radius_mm);
        line(&mut drawing, vec![[left, bar], [right, bar]], BAR);
        for z in [from, to] {
            line(&mut drawing, vec![[z, low], [z, high]], ENDS);
        }
        plane_axes(&mut drawing, &view, "z along the part (mm)", "x in the rake plane (mm)");
        legend(
            &mut drawing,
            &[
                ("at C 0°", OUTLINE),
                ("others", SECTION),
                ("centre of the insert", CENTRES),
                ("bar in the rake plane", BAR),
                ("ends of the turned length", ENDS),
            ],
        );
        drawing
    }

    /// The turn that asks most of X.
    fn x_axis(&self) -> Drawing {
        let path = &self.pass.path;
        let limits = self.prepared.machine.axis(Axis::X).limits;
        let allowed = limits.with_share(MOVE_SHARE);
        let of: [fn(&PassPoint) -> f64; 3] = [|point| point.x.first, |point| point.x.second, |point| point.x.third];
        let used = |point: &PassPoint| {
            let shares = LimitedQuantity::ALL
                .into_iter()
                .zip(of)
                .map(|(quantity, of)| of(point).abs() / quantity.limit(&allowed));
            shares.fold(0.0, f64::max)
        };
        let worst = points(self.pass)
            .map(|point| (used(&point), point.turned_rad))
            .fold((0.0, path.x().start()), |a, b| if b.0 > a.0 { b } else { a });
        // A whole turn around it, from 0 to 360° of C.
        let first = (worst.1 / TURN_RAD).floor() * TURN_RAD;
        let turn: Vec<PassPoint> =
            points(self.pass).filter(|point| (first..=first + TURN_RAD).contains(&point.turned_rad)).collect();
        let shows = format!(
            "X axis over the turn of the last pass with the highest use, z {:.2} mm; {:.2} % of the planning limit",
            path.z_at(worst.1).value,
            100.0 * worst.0
        );
        let mut drawing = self.begin(&shows);
        let deg = |point: &PassPoint| (point.turned_rad - first) * 360.0 / TURN_RAD;
        let mut chart = |row: u8, label: &str, name: &str, values: Vec<(f64, f64)>, bounds: Option<(f64, f64)>| {
            let used = |limit: f64| values.iter().map(|(_, value)| value.abs()).fold(0.0, f64::max) / limit;
            let near = bounds.filter(|(limit, _)| used(*limit) >= NEAR);
            let shown = near.into_iter().flat_map(|(limit, _)| [limit, -limit]);
            let scale = Scale::around(values.iter().map(|(_, value)| *value).chain(shown));
            let chart = TurnChart::new(frame(row, 5), scale);
            chart.axes(&mut drawing, label, row == 4);
            if let Some((limit, allowed)) = near {
                for sign in [1.0, -1.0] {
                    chart.level(&mut drawing, sign * limit, LIMIT);
                    chart.level(&mut drawing, sign * allowed, ALLOWED);
                }
            }
            if let Some((limit, _)) = bounds {
                let note = format!("{name}: limit {limit:.0} {label}, used {:.1} %", 100.0 * used(limit));
                let lettering = Lettering { anchor: Anchor::End, colour: LIMIT.colour, ..SMALL };
                drawing.text([chart.0.frame.right(), chart.0.frame.top - 1.3], lettering, &note);
            }
            chart.curve(&mut drawing, values.into_iter(), CURVE);
        };
        chart(0, "X (mm)", "", turn.iter().map(|point| (deg(point), point.x.value)).collect(), None);
        for (row, (quantity, of)) in (1_u8..).zip(LimitedQuantity::ALL.into_iter().zip(of)) {
            let values = turn.iter().map(|point| (deg(point), of(point))).collect();
            chart(
                row,
                quantity.unit(Axis::X),
                quantity.name(),
                values,
                Some((quantity.limit(&limits), quantity.limit(&allowed))),
            );
        }
        let speeds = turn.iter().map(|point| (deg(point), rpm_from_rad_s(point.c.first))).collect();
        chart(4, "C (rpm)", "", speeds, None);
        legend(&mut drawing, &[("limit", LIMIT), ("planning uses", ALLOWED)]);
        drawing
    }

    /// Clearance and angle to the rake face.
    fn clearance(&self, rows: &[ClearanceRow]) -> Drawing {
        let clearance = &self.summary.clearance;
        let shows = format!(
            "angles between insert and surface over a turn, minimum along the part; offset angle {:.2}°",
            clearance.offset_angle_deg
        );
        let mut drawing = self.begin(&shows);
        let of: [fn(&ClearanceRow) -> MinimumAngle; 2] = [|row| row.clearance, |row| row.approach];
        for (row, ((label, min), of)) in (0_u8..).zip(
            [("flank to surface (deg)", &clearance.clearance), ("surface to rake face (deg)", &clearance.approach)]
                .into_iter()
                .zip(of),
        ) {
            let closed = rows.iter().map(|row| (row.turned_deg, of(row).angle_deg));
            let closed: Vec<(f64, f64)> = closed.chain(rows.first().map(|row| (360.0, of(row).angle_deg))).collect();
            let values = closed.iter().map(|(_, value)| *value);
            let chart = TurnChart::new(frame(row, 2), Scale::around(values.chain([min.min_deg])));
            chart.axes(&mut drawing, label, row == 1);
            chart.level(&mut drawing, min.min_deg, LIMIT);
            chart.curve(&mut drawing, closed.into_iter(), CURVE);
            let note = format!("minimum {:.2}° at C {:.1}°, z {:.3} mm", min.angle_deg, min.c_deg, min.z_mm);
            let lettering = Lettering { anchor: Anchor::End, ..SMALL };
            drawing.text([chart.0.frame.right(), chart.0.frame.top - 1.3], lettering, &note);
        }
        legend(&mut drawing, &[("minimum allowed", LIMIT)]);
        drawing
    }
}

/// Lines with their names along the foot of a sheet.
fn legend(drawing: &mut Drawing, entries: &[(&str, Pen)]) {
    let mut legend = Legend::new();
    for (text, pen) in entries {
        legend.line(drawing, text, *pen);
    }
}

#[cfg(test)]
mod tests {
    use super::super::sheet::PAPER;
    use super::*;
    use crate::drawing::{png, svg};
    use crate::turning::clearance_rows::clearance_rows;
    use crate::{plan_turned, turning_summary};

    fn drawn(set: &[&str]) -> Vec<Plot> {
        let set: Vec<String> = set.iter().map(ToString::to_string).collect();
        let prepared = plan_turned(camwright_files::turning_file::load("turned_cam", &set).unwrap(), None).unwrap();
        let (summary, rows) = (turning_summary(&prepared).unwrap(), clearance_rows(&prepared).unwrap());
        turned_plots(&prepared, &summary, &rows)
    }

    #[test]
    fn nothing_is_drawn_beyond_the_margins_and_the_same_job_gives_the_same_bytes() {
        let cylinder = "surface={kind: cylinder, radius_mm: 24.0, from_mm: 0.0, to_mm: 24.0}";
        for set in [vec![], vec!["spindle={law: varied}"], vec![cylinder]] {
            let (one, other) = (drawn(&set), drawn(&set));
            assert_eq!(
                one.iter().map(|plot| plot.name.as_str()).collect::<Vec<_>>(),
                ["surface_map", "surface_view", "section", "x_axis", "clearance"]
            );
            for (plot, again) in one.iter().zip(&other) {
                let [low, high] = plot.drawing.extent();
                assert!(low[0] >= 8.0 && low[1] >= 8.0, "{set:?} {}: {low:?}", plot.name);
                assert!(high[0] <= PAPER.0 - 8.0 && high[1] <= PAPER.1 - 4.0, "{set:?} {}: {high:?}", plot.name);
                assert_eq!(svg(&plot.drawing), svg(&again.drawing), "{}", plot.name);
                assert_eq!(png(&plot.drawing).unwrap(), png(&again.drawing).unwrap(), "{}", plot.name);
                assert!(!svg(&plot.drawing).contains("NaN"), "{}", plot.name);
                assert_eq!(plot.drawing.text_faults(), [""; 0], "{set:?} {}", plot.name);
            }
        }
    }
}
