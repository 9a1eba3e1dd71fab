// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A planned job as files for people and scripts: what `camwright plan` writes.
//!
//! | file | rows | frame |
//! |---|---|---|
//! | `summary.json` | one object | the job |
//! | `<lobe>/lift.csv` | one per block, over the cam angle | the lobe |
//! | `<lobe>/contour.csv` | one per block, over the azimuth | the lobe: azimuth 0 is cam angle 0 |
//! | `<lobe>/tool_path.csv` | one per block, over a turn of `c_axis` | `c_deg` the headstock, azimuths the lobe |
//! | `<lobe>/inspection.csv` | one per block, over the cam angle, where the profile has a gauge | the lobe |
//! | `<lobe>/speed_plan.csv` | one per interpolation period, over the whole cut | `c_deg` the headstock, from the start of the cut on |
//! | `<lobe>/pulses.csv` | one per step of C, over the whole cut, where the job has `pulses` | `c_deg` the headstock |
//!
//! With `--plots` also the drawings of [`super::plots`], each as SVG and PNG, and `index.html` with all of them.
//!
//! Numbers are written with the digits that give the same number back.

use super::PreparedJob;
use super::files::Files;
use super::findings;
use super::lobe_tables::LobeTable;
use super::picture_index::{Picture, PictureIndex, PictureSection};
use super::plots::plots;
use super::summary::{Summary, summary};
use camwright_files::ConfigError;
use std::path::Path;

/// Writes `summary.json` and, in a folder per lobe, its tables and on request its drawings; calls `progress` for every file. Returns
/// the content of the summary.
///
/// # Errors
/// A folder or file that cannot be written.
pub fn write(
    prepared: &PreparedJob,
    out: &Path,
    with_plots: bool,
    progress: impl FnMut(&Path),
) -> Result<Summary, ConfigError> {
    let summary = summary(prepared);
    let mut files = Files::new(progress);
    let mut sections = Vec::new();
    for (index, lobe) in prepared.planned.lobes.iter().enumerate() {
        let folder = out.join(&lobe.design.name);
        for kind in LobeTable::ALL {
            if let Some(table) = kind.compute(prepared, index) {
                files.write(&folder.join(format!("{}.csv", kind.name())), &|to| table.write_csv(to))?;
            }
        }
        if with_plots {
            let plots = plots(prepared, index, &summary.lobes[index]);
            files.plots(&folder, &plots)?;
            let name = &lobe.design.name;
            let pictures = plots.iter().map(|plot| Picture::from_plot(Some(name), plot)).collect();
            sections.push(PictureSection { heading: format!("Lobe {name}"), pictures });
        }
    }
    if with_plots {
        let index = PictureIndex {
            job: summary.job.clone(),
            title: summary.title.clone(),
            verdict: verdict(&summary),
            warnings: findings::all_warnings(prepared).iter().map(ToString::to_string).collect(),
            sections,
        };
        files.write(&out.join("index.html"), &|to| to.write_all(index.to_html().as_bytes()))?;
    }
    files.json(&out.join("summary.json"), &summary)?;
    Ok(summary)
}

fn verdict(summary: &Summary) -> String {
    format!(
        "PLANNED: {} in {:.2} s for machine {}; highest use of an axis limit {:.1} %; plan {:.12}",
        super::lobe_count(summary.lobes.len()),
        summary.duration_s,
        summary.machine,
        100.0 * summary.max_limit_ratio,
        summary.plan_hash
    )
}
