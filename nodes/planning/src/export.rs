//! A planned job as files for people and scripts: what `camwright plan` writes.
//!
//! | file | rows | frame |
//! |---|---|---|
//! | `summary.json` | one object | the job |
//! | `<lobe>/contour.csv` | one per block, over the azimuth | the lobe: azimuth 0 is cam angle 0 |
//! | `<lobe>/tool_path.csv` | one per block, over a turn of `c_axis` | `c_deg` the headstock, azimuths the lobe |
//! | `<lobe>/inspection.csv` | one per block, over the cam angle, where the profile has a gauge | the lobe |
//! | `<lobe>/speed_plan.csv` | one per interpolation period, over the whole cut | `c_deg` the headstock, from the start of the cut on |
//!
//! With `--plots` also the drawings of [`super::plots`], each as SVG and PNG, and `index.html` with all of them.
//!
//! Numbers are written with the digits that give the same number back.

use super::cut_table::pass_rows;
use super::files::Files;
use super::findings;
use super::picture_index::{Picture, PictureIndex, PictureSection};
use super::plots::plots;
use super::summary::{Summary, summary};
use super::{PreparedJob, write_inspection};
use camwright::math::units::{deg_from_rad, rad_from_deg, wrap_turn};
use camwright::planner::PlannedLobe;
use camwright_files::ConfigError;
use std::io::{self, Write};
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
        files.write(&folder.join("contour.csv"), &|to| write_contour(prepared, lobe, to))?;
        files.write(&folder.join("tool_path.csv"), &|to| write_tool_path(prepared, lobe, to))?;
        if let Some(inspection) = &prepared.inspections[index] {
            let blocks = prepared.job.spec.blocks_per_turn;
            files.write(&folder.join("inspection.csv"), &|to| write_inspection(inspection, blocks, to))?;
        }
        files.write(&folder.join("speed_plan.csv"), &|to| write_speed_plan(prepared, index, lobe, to))?;
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

/// Degrees of block `index`: one rounding, so that 0.3 is written as 0.3.
fn block_deg(index: u32, blocks: u32) -> f64 {
    f64::from(index) * 360.0 / f64::from(blocks)
}

fn write_contour(prepared: &PreparedJob, lobe: &PlannedLobe, to: &mut dyn Write) -> io::Result<()> {
    let contour = &lobe.design.contour;
    let blocks = prepared.job.spec.blocks_per_turn;
    writeln!(to, "azimuth_deg,radius_mm,normal_deg,curvature_1_mm")?;
    for index in 0..blocks {
        let azimuth_deg = block_deg(index, blocks);
        let cam_angle = contour.cam_angle_at(rad_from_deg(azimuth_deg));
        let radius_mm = contour.point(cam_angle).norm();
        let normal_deg = deg_from_rad(contour.normal_angle(cam_angle));
        writeln!(to, "{azimuth_deg},{radius_mm},{normal_deg},{}", contour.curvature(cam_angle))?;
    }
    Ok(())
}

/// `x_mm` is the distance of the wheel's centre from the spindle axis, the X(θ) of the literature; `x_axis_mm` is where the
/// axis of this machine stands then: the wheel's cutting point, one wheel radius nearer.
fn write_tool_path(prepared: &PreparedJob, lobe: &PlannedLobe, to: &mut dyn Write) -> io::Result<()> {
    let blocks = prepared.job.spec.blocks_per_turn;
    let sense = f64::from(prepared.machine.rotation_sense);
    writeln!(to, "c_deg,x_mm,contact_azimuth_deg,wheel_line_deg,x_axis_mm")?;
    for index in 0..blocks {
        let c_deg = block_deg(index, blocks);
        let theta = sense * rad_from_deg(c_deg) - lobe.design.phase_rad;
        let x_axis_mm = lobe.tool_path.sample(theta).value;
        let x_mm = x_axis_mm + lobe.tool_path.wheel_radius_mm();
        let contact_deg = deg_from_rad(wrap_turn(lobe.tool_path.contact_azimuth(theta)));
        writeln!(to, "{c_deg},{x_mm},{contact_deg},{},{x_axis_mm}", deg_from_rad(wrap_turn(theta)))?;
    }
    Ok(())
}

fn write_speed_plan(prepared: &PreparedJob, index: usize, lobe: &PlannedLobe, to: &mut dyn Write) -> io::Result<()> {
    writeln!(to, "c_deg,t_s,c_rad_s,c_rad_s2,c_rad_s3,x_mm_s,x_mm_s2,x_mm_s3,removal_mm2_s,pass")?;
    for pass in 0..lobe.passes.len() {
        for row in pass_rows(prepared, index, lobe, pass) {
            let [c1, c2, c3] = row.c;
            let [x1, x2, x3] = row.x;
            let number = pass + 1;
            writeln!(to, "{},{},{c1},{c2},{c3},{x1},{x2},{x3},{},{number}", row.c_deg, row.t_s, row.removal_mm2_s)?;
        }
    }
    Ok(())
}
