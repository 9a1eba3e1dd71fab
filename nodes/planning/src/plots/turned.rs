//! Drawings of a turned part by `camwright plan --plots`.
//!
//! | name | shows |
//! |---|---|
//! | `section` | sections in the rake plane all round, the insert and the path of its centre in the last pass |
//! | `x_axis` | the turn that asks most of X: its place, speed, acceleration and jerk with what is allowed of them, and the spindle's speed |
//! | `clearance` | the angles between insert and surface over a turn, with what is asked of them |

use super::chart::{CURVE_MM, SMALL, TurnChart};
use super::contour::PartView;
use super::curves::{ALLOWED, LIMIT, frame};
use super::sheet::{ROOM, legend_entry, sheet};
use crate::chart::Scale;
use crate::drawing::{Anchor, Colour, Dash, Drawing, Lettering, Pen, Plot, Point};
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
    vec![
        Plot { name: "section".into(), drawing: of.section() },
        Plot { name: "x_axis".into(), drawing: of.x_axis() },
        Plot { name: "clearance".into(), drawing: of.clearance(rows) },
    ]
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
            let [x, _] = view.at([z, low]);
            drawing.text([x, ROOM.bottom() + 3.6], SMALL, &format!("z {z:.3}"));
        }
        drawing.line(&ROOM.corners(), Pen::solid(Colour::BLACK, 0.25));
        legend(
            &mut drawing,
            &[
                ("at C 0°", OUTLINE),
                ("others", SECTION),
                ("centre of the insert", CENTRES),
                ("bar in the rake plane", BAR),
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
            let note = format!("least {:.2}° at C {:.1}°, z {:.3} mm", min.angle_deg, min.c_deg, min.z_mm);
            let lettering = Lettering { anchor: Anchor::End, ..SMALL };
            drawing.text([chart.0.frame.right(), chart.0.frame.top - 1.3], lettering, &note);
        }
        legend(&mut drawing, &[("asked for", LIMIT)]);
        drawing
    }
}

/// Lines with their names along the foot of a sheet.
fn legend(drawing: &mut Drawing, entries: &[(&str, Pen)]) {
    let mut x = 14.0;
    for (text, pen) in entries {
        x = legend_entry(drawing, x, text, *pen);
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
                ["section", "x_axis", "clearance"]
            );
            for (plot, again) in one.iter().zip(&other) {
                let [low, high] = plot.drawing.extent();
                assert!(low[0] >= 8.0 && low[1] >= 8.0, "{set:?} {}: {low:?}", plot.name);
                assert!(high[0] <= PAPER.0 - 8.0 && high[1] <= PAPER.1 - 4.0, "{set:?} {}: {high:?}", plot.name);
                assert_eq!(svg(&plot.drawing), svg(&again.drawing), "{}", plot.name);
                assert_eq!(png(&plot.drawing).unwrap(), png(&again.drawing).unwrap(), "{}", plot.name);
                assert!(!svg(&plot.drawing).contains("NaN"), "{}", plot.name);
            }
        }
    }
}
