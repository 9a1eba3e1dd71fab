//! A planned turning job as files for people and scripts: what `camwright plan` writes.
//!
//! | file | rows | frame |
//! |---|---|---|
//! | `summary.json` | one object | the job |
//! | `pass_N/insert_path.csv` | one per angle at which the path was computed | `turned_deg` from the first angle of the path on, x and z of the insert's centre |
//! | `clearance.csv` | one per degree of the turned angle | the least angles along the part |
//! | `surface.csv` | one per place along the part | as `kind: grid` reads it |

use super::summary::{TurningSummary, turning_summary};
use super::{PreparedTurning, error_location};
use crate::files::Files;
use crate::plots::turned_plots;
use camwright::math::units::{TURN_RAD, deg_from_rad, wrap_turn};
use camwright::planner::{PlannedPass, TurningError};
use camwright::toolpath::insert_clearance::Flank;
use camwright::toolpath::insert_path::InsertPathError;
use camwright::toolpath::rake_section::{RakeSection, RakeSectionError};
use camwright_files::{ConfigError, grid_text};
use std::f64::consts::FRAC_PI_2;
use std::io::{self, Write};
use std::path::Path;

/// Azimuths of `surface.csv`, and distance of its rows (mm): a spline through them is within some 0.05 µm of a surface of workshop size.
const AZIMUTHS: u32 = 360;
const ROW_MM: f64 = 0.1;
const MOST_ROWS: f64 = 4000.0;

/// Turned angles, and places along the part, at which clearances are looked at.
const ANGLES: u32 = 360;
const PLACES: u32 = 96;

/// The angles of insert and surface at one turned angle, each the least along the part.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ClearanceRow {
    pub(crate) turned_deg: f64,
    pub(crate) clearance: LeastAngle,
    pub(crate) approach: LeastAngle,
}

/// A least angle with its place, and the azimuth of the part that is cut there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LeastAngle {
    pub(crate) angle_deg: f64,
    pub(crate) z_mm: f64,
    pub(crate) azimuth_deg: f64,
}

/// The least angles between insert and surface all round a turn.
pub(crate) fn clearance_rows(prepared: &PreparedTurning) -> Result<Vec<ClearanceRow>, RakeSectionError> {
    let Some(insert) = &prepared.machine.insert else { return Ok(Vec::new()) };
    let (relief_rad, spec) = (Flank::of(insert).relief_rad, &prepared.job.spec);
    let (from_mm, to_mm) = spec.range_mm();
    let section = RakeSection::new(&spec.surface, insert.height_mm, from_mm, to_mm)?;
    let row = |angle: u32| {
        let turned_rad = TURN_RAD * f64::from(angle) / f64::from(ANGLES);
        let none = LeastAngle { angle_deg: f64::INFINITY, z_mm: from_mm, azimuth_deg: 0.0 };
        let (mut clearance, mut approach) = (none, none);
        for place in 0..=PLACES {
            let z_mm = from_mm + (to_mm - from_mm) * f64::from(place) / f64::from(PLACES);
            let point = section.point(turned_rad, z_mm)?;
            let azimuth_deg = deg_from_rad(wrap_turn(turned_rad + point.lead_rad));
            let normal_rad = point.normal_rad();
            for (least, angle_rad) in
                [(&mut clearance, relief_rad - normal_rad), (&mut approach, FRAC_PI_2 + normal_rad)]
            {
                let angle_deg = deg_from_rad(angle_rad);
                if angle_deg < least.angle_deg {
                    *least = LeastAngle { angle_deg, z_mm, azimuth_deg };
                }
            }
        }
        Ok(ClearanceRow { turned_deg: f64::from(angle) * 360.0 / f64::from(ANGLES), clearance, approach })
    };
    (0..ANGLES).map(row).collect()
}

/// Writes everything about a planned turning job into a folder; `progress` is told of every file. Returns what the summary says.
///
/// # Errors
/// A folder or file that cannot be written.
pub fn write_turning(
    prepared: &PreparedTurning,
    out: &Path,
    with_plots: bool,
    progress: impl FnMut(&Path),
) -> Result<TurningSummary, ConfigError> {
    let job = &prepared.job;
    let blamed = |error: TurningError| error_location::blame(job, &prepared.machine, &error);
    let summary = turning_summary(prepared).ok_or_else(|| blamed(TurningError::NotALathe))?;
    let rows = clearance_rows(prepared).map_err(|error| {
        let source = InsertPathError::Section(error);
        blamed(TurningError::Path { pass: prepared.planned.passes.len(), source })
    })?;
    let mut files = Files::new(progress);
    for (index, pass) in prepared.planned.passes.iter().enumerate() {
        let path = out.join(format!("pass_{}", index + 1)).join("insert_path.csv");
        files.write(&path, &|to| write_path(pass, job.spec.part_zero_mm, to))?;
    }
    files.write(&out.join("clearance.csv"), &|to| write_clearance(&rows, to))?;
    let (from_mm, to_mm) = job.spec.surface.ends_mm();
    #[allow(clippy::cast_possible_truncation, reason = "within the bounds")]
    let count = ((to_mm - from_mm) / ROW_MM).ceil().clamp(1.0, MOST_ROWS) as u32;
    let place = |row: u32| {
        // The ends as they are, and not as a sum rounds them.
        if row == count { to_mm } else { from_mm + (to_mm - from_mm) * f64::from(row) / f64::from(count) }
    };
    let places: Vec<f64> = (0..=count).map(place).collect();
    files.write(&out.join("surface.csv"), &|to| grid_text::write(&job.spec.surface, AZIMUTHS, &places, to))?;
    if with_plots {
        for plot in turned_plots(prepared, &summary, &rows) {
            files.plot(out, &plot)?;
        }
    }
    files.json(&out.join("summary.json"), &summary)?;
    Ok(summary)
}

/// X and Z of the insert's centre with their derivatives over the turned angle; `z_axis_mm` is where the axis of the machine stands.
fn write_path(pass: &PlannedPass, part_zero_mm: f64, to: &mut dyn Write) -> io::Result<()> {
    writeln!(to, "turned_deg,x_mm,z_mm,x_mm_rad,x_mm_rad2,z_mm_rad,z_mm_rad2,z_axis_mm")?;
    for (index, [x, x1, x2]) in pass.path.x().knots().iter().enumerate() {
        let turned_rad = pass.path.x().at(index);
        let z = pass.path.z_at(turned_rad);
        let (turned_deg, z_axis_mm) = (deg_from_rad(turned_rad), z.value - part_zero_mm);
        writeln!(to, "{turned_deg},{x},{},{x1},{x2},{},{},{z_axis_mm}", z.value, z.first, z.second)?;
    }
    Ok(())
}

fn write_clearance(rows: &[ClearanceRow], to: &mut dyn Write) -> io::Result<()> {
    writeln!(
        to,
        "turned_deg,clearance_deg,clearance_z_mm,clearance_azimuth_deg,approach_deg,approach_z_mm,approach_azimuth_deg"
    )?;
    for ClearanceRow { turned_deg, clearance, approach } in rows {
        let cells = |least: &LeastAngle| format!("{},{},{}", least.angle_deg, least.z_mm, least.azimuth_deg);
        writeln!(to, "{turned_deg},{},{}", cells(clearance), cells(approach))?;
    }
    Ok(())
}
