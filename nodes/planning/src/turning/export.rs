//! A planned turning job as files for people and scripts: what `camwright plan` writes.
//!
//! | file | rows | frame |
//! |---|---|---|
//! | `summary.json` | one object | the job |
//! | `pass_N/insert_path.csv` | one per angle at which the path was computed | `turned_deg` from the first angle of the path on, x and z of the insert's centre |
//! | `clearance.csv` | one per degree of the turned angle | the least angles along the part |
//! | `surface.csv` | one per place along the part | as `kind: grid` reads it |
//!
//! With plots also the drawings of `turned_plots`, each as SVG and PNG, and `index.html` with all of them.

use super::clearance_rows::{ClearanceRow, MinimumAngle, clearance_rows};
use super::error_location;
use super::prepared::PreparedTurning;
use super::summary::{TurningSummary, turning_summary};
use crate::files::Files;
use crate::picture_index::{Picture, PictureIndex, PictureSection};
use crate::plots::turned_plots;
use camwright::math::units::deg_from_rad;
use camwright::planner::{PlannedPass, TurningError};
use camwright::toolpath::insert_path::InsertPathError;
use camwright_files::{ConfigError, grid_text};
use std::io::{self, Write};
use std::path::Path;

/// Azimuths of `surface.csv`, and distance of its rows (mm): a spline through them is within some 0.05 µm of a surface of workshop size.
const AZIMUTHS: u32 = 360;
const ROW_MM: f64 = 0.1;
const MAX_ROWS: f64 = 4000.0;

/// Writes all files of a planned turning job into a folder; calls `progress` for every file. Returns the content of the summary.
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
    let count = ((to_mm - from_mm) / ROW_MM).ceil().clamp(1.0, MAX_ROWS) as u32;
    let place = |row: u32| {
        // The ends as they are, and not as a sum rounds them.
        if row == count { to_mm } else { from_mm + (to_mm - from_mm) * f64::from(row) / f64::from(count) }
    };
    let places: Vec<f64> = (0..=count).map(place).collect();
    files.write(&out.join("surface.csv"), &|to| grid_text::write(&job.spec.surface, AZIMUTHS, &places, to))?;
    if with_plots {
        let plots = turned_plots(prepared, &summary, &rows);
        files.plots(out, &plots)?;
        let pictures = plots.iter().map(|plot| Picture::from_plot(None, plot)).collect();
        let index = PictureIndex {
            job: summary.job.clone(),
            title: summary.title.clone(),
            verdict: verdict(&summary),
            warnings: super::all_warnings(prepared).iter().map(ToString::to_string).collect(),
            sections: vec![PictureSection { heading: "Turned part".into(), pictures }],
        };
        files.write(&out.join("index.html"), &|to| to.write_all(index.to_html().as_bytes()))?;
    }
    files.json(&out.join("summary.json"), &summary)?;
    Ok(summary)
}

fn verdict(summary: &TurningSummary) -> String {
    format!(
        "PLANNED: {} passes in {:.2} s for machine {}; highest use of an axis limit {:.1} %; plan {:.12}",
        summary.passes.len(),
        summary.duration_s,
        summary.machine,
        100.0 * summary.max_limit_ratio,
        summary.plan_hash
    )
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
        let cells = |min: &MinimumAngle| format!("{},{},{}", min.angle_deg, min.z_mm, min.azimuth_deg);
        writeln!(to, "{turned_deg},{},{}", cells(clearance), cells(approach))?;
    }
    Ok(())
}
