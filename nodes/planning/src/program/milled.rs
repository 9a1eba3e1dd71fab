// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The program of a milling job: pass by pass, every cam with a turn of its own, every wall of a groove step by step down.

use super::request::{Plane, ProgramOutline, ToPost};
use camwright::cam::contour::Contour;
use camwright::gcode::post::{FeatureRequest, Lead, PassRequest, PostRequest, ProgramTurnSpeed};
use camwright::gcode::{Direction, Tool};
use camwright::job::milling::{CutsWith, GrooveKind, MilledCam, MilledGroove, MillingJob, MillingPass};
use camwright::math::units::{TURN_RAD, deg_from_rad, rpm_from_rad_s, um_from_mm};
use camwright::toolpath::cutter_path::{CarriageAxis, CutterPath};
use camwright::toolpath::groove::barrel::BarrelGroove;
use camwright::toolpath::groove::wall_error::WallError;
use camwright::toolpath::groove::{Coverage, Wall};
use camwright_files::ConfigError;
use camwright_files::milling_file::MilledJob;
use camwright_files::nc_file::NcSettings;

/// Points of a drawn contour.
const OUTLINE_POINTS: u32 = 720;

/// A path with all that its feature needs.
struct MilledToolPath {
    name: String,
    phase_rad: f64,
    path: CutterPath,
    stands_mm: Vec<(CarriageAxis, f64)>,
    clear_mm: f64,
    lead: Lead,
    leaves_mm: Vec<f64>,
    pass: usize,
    /// None for a path between the walls of a groove: nothing of it stays on the part.
    outline: Option<ProgramOutline>,
}

/// Makes the request of a milling job and hands it on.
///
/// # Errors
/// A cam or a groove that the mill cannot make.
pub(super) fn with_request<R>(
    job: &MilledJob,
    done: impl FnOnce(ToPost<'_>) -> Result<R, ConfigError>,
) -> Result<R, ConfigError> {
    let (spec, settings) = (&job.spec, &job.nc);
    let (mut made, mut notes) = (Vec::new(), Vec::new());
    let has_y = |groove: &MilledGroove| matches!(groove.kind, GrooveKind::Barrel { y_axis: true, .. });
    let y_axis = spec.grooves.iter().any(has_y);
    for (index, pass) in spec.passes.iter().enumerate() {
        for cam in &spec.cams {
            made.push(from_cam(job, cam, (index, pass))?);
        }
        for groove in &spec.grooves {
            made.extend(from_groove(job, groove, (index, pass), &mut notes)?);
        }
    }
    // What one groove leaves of Y is taken back before anything else is cut.
    for made in made.iter_mut().filter(|made| y_axis && made.path.sample(CarriageAxis::Y, 0.0).is_none()) {
        made.stands_mm.push((CarriageAxis::Y, 0.0));
    }
    let features = made.iter().map(|made| feature(made, spec, settings)).collect();
    let tool = &spec.tool;
    #[allow(clippy::cast_possible_truncation, reason = "a spindle's speed")]
    let rpm = rpm_from_rad_s(tool.spindle_speed_rad_s).clamp(1.0, 99_999.0).round() as u32;
    let text = if tool.text.is_empty() { format!("mill radius {:.3} mm", tool.radius_mm) } else { tool.text.clone() };
    let request = PostRequest {
        name: spec.name.clone(),
        number: settings.program_number,
        header: Vec::new(),
        tool: Tool { number: tool.number, radius_mm: tool.radius_mm, text },
        spindle: Some((Direction::Clockwise, settings.spindle_rpm.unwrap_or(rpm))),
        coolant: settings.coolant,
        control: settings.control,
        features,
    };
    done(ToPost {
        request,
        settings: *settings,
        document: &job.document,
        job: &spec.name,
        job_hash: &job.hash,
        outlines: made.iter().map(|made| made.outline.clone()).collect(),
        notes,
    })
}

fn feature<'a>(made: &'a MilledToolPath, spec: &MillingJob, settings: &NcSettings) -> FeatureRequest<'a> {
    let pass = &spec.passes[made.pass];
    FeatureRequest {
        name: made.name.clone(),
        phase_rad: made.phase_rad,
        path: &made.path,
        stands_mm: made.stands_mm.clone(),
        clear_mm: made.clear_mm,
        lead: made.lead,
        passes: vec![PassRequest {
            name: pass.name.clone(),
            leaves_mm: made.leaves_mm.clone(),
            tolerance_mm: pass.tolerance_mm,
            widest_tolerance_mm: settings.widest_tolerance_mm.max(pass.tolerance_mm),
            knots: settings.knots,
            speed: ProgramTurnSpeed::WorkSpeed(pass.work_speed_rad_s),
            // An open groove is run once in a call.
            turns: if made.path.is_open() { 1 } else { pass.turns },
        }],
    }
}

/// Highest and lowest place of an axis that travels (mm).
fn range_mm(path: &CutterPath, axis: CarriageAxis) -> (f64, f64) {
    let hulls = path.travels.iter().filter(|travel| travel.axis == axis).map(|travel| travel.position.hull_mm());
    hulls.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), hull| (low.min(hull.0), high.max(hull.1)))
}

/// The largest radius of a contour (mm).
fn largest_radius_mm(contour: &Contour) -> f64 {
    outline(|angle| contour.point(angle).into()).iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max)
}

fn outline(at: impl Fn(f64) -> [f64; 2]) -> Vec<[f64; 2]> {
    (0..=OUTLINE_POINTS).map(|point| at(f64::from(point) * TURN_RAD / f64::from(OUTLINE_POINTS))).collect()
}

/// A cam: the mill comes onto the blank from outside over an angle, turns, and leaves as it came.
fn from_cam(
    job: &MilledJob,
    cam: &MilledCam,
    (index, pass): (usize, &MillingPass),
) -> Result<MilledToolPath, ConfigError> {
    let (spec, settings) = (&job.spec, &job.nc);
    let refuse = |error: &dyn std::fmt::Display| {
        job.document.error("tool.radius_mm", format!("cam {}, pass {}: {error}", cam.name, pass.name))
    };
    let mut path = spec.tool.cam_path(cam, pass.leaves_mm).map_err(|error| refuse(&error))?;
    let blank_mm = spec.blank_radius_mm.unwrap_or_else(|| largest_radius_mm(&cam.contour));
    // Where X is with the mill beside the blank.
    let periphery = spec.tool.cuts_with == CutsWith::Periphery;
    let (reach_mm, edge_mm) = match (periphery, settings.x_of_edge) {
        (true, false) => (spec.tool.radius_mm, 0.0),
        (true, true) => (0.0, spec.tool.radius_mm),
        (false, _) => (0.0, 0.0),
    };
    if edge_mm > 0.0 {
        for travel in &mut path.travels {
            travel.position = travel.position.raised(-edge_mm);
        }
    }
    let (low_mm, high_mm) = range_mm(&path, CarriageAxis::X);
    let clear_mm = high_mm.max(blank_mm + reach_mm) + spec.clearance_mm;
    Ok(MilledToolPath {
        name: cam.name.clone(),
        phase_rad: cam.phase_rad,
        stands_mm: vec![(CarriageAxis::Z, cam.z_mm)],
        clear_mm,
        lead: Lead { height_mm: clear_mm - low_mm, angle_rad: settings.lead_rad, leaves_turning: true },
        leaves_mm: vec![0.0],
        pass: index,
        outline: Some(ProgramOutline {
            closed: vec![outline(|angle| cam.contour.point(angle).into())],
            cutter_mm: if periphery { spec.tool.radius_mm } else { 0.0 },
            edge_mm,
            plane: Plane::Across,
        }),
        path,
    })
}

/// A groove: every path of it, step by step down. The mill comes down over the turn before; into an open groove it comes beyond the end
/// face, as often at each depth as the pass has turns.
fn from_groove(
    job: &MilledJob,
    groove: &MilledGroove,
    (index, pass): (usize, &MillingPass),
    notes: &mut Vec<String>,
) -> Result<Vec<MilledToolPath>, ConfigError> {
    let spec = &job.spec;
    let coverage = if index == 0 { Coverage::Slot } else { Coverage::Walls };
    let paths = spec.tool.groove_paths(groove, pass.leaves_mm, coverage).map_err(|error| {
        job.document.error("tool.radius_mm", format!("groove {}, pass {}: {error}", groove.name, pass.name))
    })?;
    let steps_mm = groove.steps_mm();
    let step_mm = groove.depth_mm() / f64::from(u32::try_from(steps_mm.len()).unwrap_or(u32::MAX)).max(1.0);
    let is_open = paths.iter().any(CutterPath::is_open);
    let angle_rad = if is_open { job.nc.lead_rad } else { TURN_RAD };
    let lead = Lead { height_mm: step_mm + spec.clearance_mm, angle_rad, leaves_turning: false };
    let runs = if is_open { pass.turns as usize } else { 1 };
    let leaves_mm: Vec<f64> = steps_mm.iter().flat_map(|left| std::iter::repeat_n(*left, runs)).collect();
    let last = paths.len().saturating_sub(1);
    let mut made = Vec::new();
    // The first and the last path make the walls.
    for (at, mut path) in paths.into_iter().enumerate() {
        let (stands_mm, clear_mm, outline) = match &groove.kind {
            GrooveKind::Plate { groove: walls, top_mm, depth_mm } => {
                let wall = |out_mm: f64| {
                    outline(|angle| {
                        (walls.inner_wall().point(angle) + walls.inner_wall().normal(angle) * out_mm).into()
                    })
                };
                let closed = vec![wall(2.0 * walls.roller_radius_mm()), wall(0.0)];
                let outline =
                    ProgramOutline { closed, cutter_mm: spec.tool.radius_mm, edge_mm: 0.0, plane: Plane::Across };
                (vec![(CarriageAxis::Z, top_mm - depth_mm)], top_mm + spec.clearance_mm, outline)
            }
            GrooveKind::Barrel { groove: walls, z_mm, y_axis } => {
                if pass.leaves_mm.abs() < f64::EPSILON {
                    notes.extend(wall_note(groove, walls, &path, spec, *y_axis));
                }
                for travel in path.travels.iter_mut().filter(|travel| travel.axis == CarriageAxis::Z) {
                    travel.position = travel.position.raised(*z_mm);
                }
                let outline = developed(walls, *z_mm, spec.tool.radius_mm);
                (vec![(CarriageAxis::X, walls.floor_radius_mm())], walls.outer_radius_mm() + spec.clearance_mm, outline)
            }
        };
        made.push(MilledToolPath {
            name: if last == 0 { groove.name.clone() } else { format!("{} {}", groove.name, in_letters(&path.name)) },
            phase_rad: groove.phase_rad,
            path,
            stands_mm,
            clear_mm,
            lead,
            leaves_mm: leaves_mm.clone(),
            pass: index,
            outline: (at == 0 || at == last).then_some(outline),
        });
    }
    Ok(made)
}

/// A path's name in letters: subprograms and folders are named by it, which have no signs.
fn in_letters(name: &str) -> String {
    name.replace("wall towards +Z", "plus Z").replace("wall towards -Z", "minus Z")
}

/// The walls of a groove round a cylinder, rolled off at its mean radius; those of several turns one turn over the other.
fn developed(walls: &BarrelGroove, z_mm: f64, cutter_mm: f64) -> ProgramOutline {
    let (mean_mm, roller_mm) = (walls.mean_radius_mm(), walls.roller_radius_mm());
    let turns = walls.course().turns();
    let plane = Plane::Developed { radius_mm: mean_mm, is_folded: turns > 1 };
    let wall = |side: f64| {
        let at = |angle: f64| {
            let centre = walls.course().centre(angle);
            let slope = (centre.z.first / (mean_mm + centre.y.first)).atan();
            [
                mean_mm * angle + centre.y.value - side * roller_mm * slope.sin(),
                z_mm + centre.z.value + side * roller_mm * slope.cos(),
            ]
        };
        let points = OUTLINE_POINTS * turns;
        let span_rad = walls.course().span_rad();
        let all = (0..=points).map(|point| f64::from(point) * span_rad / f64::from(points));
        // Beyond the end faces there is no wall.
        let inside = all.map(|angle| walls.is_inside(walls.course().centre(angle).z.value).then(|| at(angle)));
        plane.folded(inside)
    };
    let closed = Wall::BOTH.iter().flat_map(|side| wall(side.side())).collect();
    ProgramOutline { closed, cutter_mm, edge_mm: 0.0, plane }
}

/// Note on the error that a mill smaller than the roller leaves on a wall of a groove round a cylinder.
fn wall_note(
    groove: &MilledGroove,
    walls: &BarrelGroove,
    path: &CutterPath,
    spec: &MillingJob,
    y_axis: bool,
) -> Option<String> {
    let wall = Wall::BOTH.into_iter().find(|wall| wall.name_on_cylinder() == path.name)?;
    let errors = walls.wall_errors(path, spec.tool.radius_mm, 0.0, wall);
    let at = |error: &WallError| {
        format!(
            "{:+.2} um at radius {:.3} mm and {:.1} deg",
            um_from_mm(error.error_mm),
            error.radius_mm,
            deg_from_rad(error.azimuth_rad).rem_euclid(deg_from_rad(walls.course().span_rad()))
        )
    };
    let how = if y_axis { "with a Y axis" } else { "without a Y axis, whose shift C has to make" };
    Some(format!(
        "{}, {}: a mill of {:.3} mm for a roller of {:.3} mm leaves {} and {} on it {how} (negative: cuts into it)",
        groove.name,
        path.name,
        spec.tool.radius_mm,
        walls.roller_radius_mm(),
        at(&errors.max),
        at(&errors.min)
    ))
}
