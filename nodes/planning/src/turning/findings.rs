// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Everything that can be said about a turning job before anything moves.

use super::prepared::{PreparedTurning, plan_turned};
use super::summary::{EdgeSummary, MeshSummary, TurningSummary, mesh_summary, turning_summary};
use crate::finding::{CheckReport, Finding, warning};
use crate::lifts;
use camwright::toolpath::insert_clearance::{OFFSET_DEG, beside_centre};
use camwright_files::ConfigError;
use camwright_files::convert::machine_now::MachineNow;
use camwright_files::turning_file::TurnedJob;
use std::path::Path;

/// Checks a turning job that has been read, planning it to the end.
pub(crate) fn check_turned(file: &Path, job: TurnedJob, machine: Option<&MachineNow>) -> CheckReport {
    let mut findings: Vec<Finding> =
        job.lifts.iter().flat_map(|(_, lift)| lift.warnings.iter().cloned().map(warning)).collect();
    let mut notes = read_notes(&job);
    let mesh = job.mesh.as_ref().map(|(file, reading)| mesh_note(&mesh_summary(file, reading)));
    match plan_turned(job, machine) {
        Ok(prepared) => {
            if let Some(summary) = turning_summary(&prepared) {
                findings.extend(warnings(&prepared, &summary));
                notes.extend(turning_notes(&summary));
            }
            CheckReport { file: file.to_path_buf(), findings, summary: Some(prepared.summary()), notes }
        }
        Err(error) => {
            let mut report = CheckReport::refused(file, vec![error]);
            report.findings.extend(findings);
            // What cannot be turned may be so for how its mesh was read.
            notes.extend(mesh);
            report.notes = notes;
            report
        }
    }
}

/// Notes on the reading of its files.
fn read_notes(job: &TurnedJob) -> Vec<String> {
    let mut notes: Vec<String> = Vec::new();
    for (profile, lift) in &job.lifts {
        notes.extend(lifts::readings(lift).iter().map(|reading| format!("lift {profile:<8} {reading}")));
    }
    notes
}

/// One line about a mesh.
fn mesh_note(mesh: &MeshSummary) -> String {
    format!(
        "mesh      {}: {} triangles, {} of end faces left out, read as points of a smooth surface on {} azimuths and {} rows: corners \
         within {:.4} um of it, flat faces up to {:.2} um off",
        mesh.file, mesh.triangles, mesh.left_out, mesh.grid[0], mesh.grid[1], mesh.corners_off_um, mesh.faces_off_um
    )
}

/// One line about the edge of the insert.
fn edge_note(edge: &EdgeSummary) -> String {
    let [from, to] = [edge.from, edge.to]
        .map(|place| format!("{:.2} deg at C {:.1} deg, z {:.3} mm", place.angle_deg, place.c_deg, place.z_mm));
    let arc =
        edge.arc_deg.map_or_else(|| "the whole circle".to_owned(), |[from, to]| format!("{from:.2} to {to:.2} deg"));
    let insert = if edge.rotates { "rotating insert" } else { "clamped insert" };
    format!("edge      cuts from {from}, to {to}; {insert}, {arc}")
}

/// Lines on the fidelity of a mesh, and on the clearance of the insert.
#[must_use]
pub fn turning_notes(summary: &TurningSummary) -> Vec<String> {
    let clearance = &summary.clearance;
    let [(low, high), (min, max)] = OFFSET_DEG;
    let offset = match (clearance.is_offset_preferred, clearance.is_offset_allowed) {
        (true, _) => format!("within the {low} to {high} deg that JP2012-71381A prefers"),
        (_, true) => format!("within {min} to {max} deg, better {low} to {high}, after JP2012-71381A"),
        _ => format!("outside of the {min} to {max} deg of JP2012-71381A"),
    };
    let mut notes: Vec<String> = summary.mesh.iter().map(mesh_note).collect();
    notes.extend([
        format!(
            "clearance {:.2} deg at C {:.1} deg, z {:.3} mm, minimum {}; {:.2} deg to the rake face at C {:.1} deg, z {:.3} \
             mm, at least {}",
            clearance.clearance.angle_deg,
            clearance.clearance.c_deg,
            clearance.clearance.z_mm,
            clearance.clearance.min_deg.round(),
            clearance.approach.angle_deg,
            clearance.approach.c_deg,
            clearance.approach.z_mm,
            clearance.approach.min_deg.round()
        ),
        format!(
            "insert    {}, offset angle {:.2} deg, {offset}",
            beside_centre(clearance.below_centre_mm),
            clearance.offset_angle_deg
        ),
    ]);
    notes.extend(summary.edge.as_ref().map(edge_note));
    if let Some(heights) = &clearance.heights {
        notes.push(format!(
            "heights   from {} to {} work, best {}",
            beside_centre(heights.from_mm),
            beside_centre(heights.to_mm),
            beside_centre(heights.best_mm)
        ));
    }
    notes
}

/// Warnings about a planned job and its files.
pub(crate) fn all_warnings(prepared: &PreparedTurning) -> Vec<Finding> {
    let lifts = prepared.job.lifts.iter().flat_map(|(_, lift)| lift.warnings.iter().cloned().map(warning));
    let planned = turning_summary(prepared).map(|summary| warnings(prepared, &summary));
    lifts.chain(planned.into_iter().flatten()).collect()
}

/// Warnings of a feasible job.
fn warnings(prepared: &PreparedTurning, summary: &TurningSummary) -> Vec<Finding> {
    let document = &prepared.job.document;
    let mut findings = Vec::new();
    let last = summary.passes.last();
    if let Some(hollow) = last.and_then(|pass| pass.hollow.as_ref()) {
        findings.push(warning(document.error(
            "surface",
            format!(
                "the insert bridges a hollow: at C {:.1} deg, z = {:.3} mm its radius is {:.3} mm, the insert has {:.3} mm, and {:.2} um \
                 are left in it",
                hollow.c_deg, hollow.z_mm, hollow.radius_mm, hollow.bound_mm, hollow.left_um
            ),
        )));
    }
    if !summary.clearance.is_offset_allowed {
        let (min, max) = OFFSET_DEG[1];
        let message = format!(
            "the insert stands {}, an offset angle of {:.2} deg; JP2012-71381A asks for {min} to {max} deg",
            beside_centre(summary.clearance.below_centre_mm),
            summary.clearance.offset_angle_deg
        );
        findings.push(warning(ConfigError::at(prepared.job.machine.place("insert.height_mm"), message)));
    }
    findings
}
