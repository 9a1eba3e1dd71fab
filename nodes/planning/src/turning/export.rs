// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
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

use super::error_location;
use super::prepared::PreparedTurning;
use super::summary::{TurningSummary, turning_summary};
use super::tables::{CLEARANCE, clearance_table, insert_path_name, insert_path_table, planned_clearance};
use crate::files::Files;
use crate::picture_index::{Picture, PictureIndex, PictureSection};
use crate::plots::turned_plots;
use camwright::planner::TurningError;
use camwright_files::{ConfigError, grid_text};
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
    let rows = planned_clearance(prepared)?;
    let mut files = Files::new(progress);
    for (index, pass) in prepared.planned.passes.iter().enumerate() {
        let path = out.join(format!("{}.csv", insert_path_name(index)));
        files.write(&path, &|to| insert_path_table(pass, job.spec.part_zero_mm).write_csv(to))?;
    }
    files.write(&out.join(format!("{CLEARANCE}.csv")), &|to| clearance_table(&rows).write_csv(to))?;
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
