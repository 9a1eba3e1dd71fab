// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Expected readings of an inspection gauge on the lobes of a job.

use super::lobe_tables::block_deg;
use super::table::NumberTable;
use camwright::cam::inspection::Inspection;
use camwright::math::units::{deg_from_rad, rad_from_deg, wrap_turn};
use camwright::planner::PlannedJob;
use camwright_files::ConfigError;
use camwright_files::job_file::Job;

/// Every lobe under the gauge of its profile; none where the profile has none.
///
/// # Errors
/// A gauge that cannot lie on the base circle, or cannot reach over the cam at a cam angle of the job's blocks.
pub fn inspections(job: &Job, planned: &PlannedJob) -> Result<Vec<Option<Inspection>>, ConfigError> {
    let under_gauge = |(index, lobe): (usize, &camwright::planner::PlannedLobe)| {
        let profile = job.spec.lobes[index].profile;
        let Some(gauge) = job.gauges[profile] else { return Ok(None) };
        let refuse = |message: String| {
            let name = &job.spec.profiles[profile].name;
            job.document.error(&format!("profiles.{profile}.gauge"), format!("profile {name}: gauge: {message}"))
        };
        let inspection = Inspection::new(&lobe.design.contour, &gauge).map_err(|error| refuse(error.to_string()))?;
        let blocks = job.spec.blocks_per_turn;
        match angles_deg(blocks).find(|angle_deg| inspection.read(rad_from_deg(*angle_deg)).is_none()) {
            Some(angle_deg) => Err(refuse(format!("it cannot reach over the cam at cam angle {angle_deg} deg"))),
            None => Ok(Some(inspection)),
        }
    };
    planned.lobes.iter().enumerate().map(under_gauge).collect()
}

/// The gauge's lift at every block, of an arm along its arc, and the azimuth of the contour that it touches there.
pub(crate) fn inspection_table(inspection: &Inspection, blocks: u32) -> NumberTable {
    let rows = angles_deg(blocks).filter_map(|angle_deg| {
        let reading = inspection.read(rad_from_deg(angle_deg))?;
        let azimuth_deg = deg_from_rad(wrap_turn(inspection.contour().azimuth(reading.contact_rad)));
        Some([angle_deg, reading.lift, azimuth_deg])
    });
    NumberTable::from_rows([("cam_angle_deg", "deg"), ("lift_mm", "mm"), ("contact_azimuth_deg", "deg")], rows)
}

fn angles_deg(blocks: u32) -> impl Iterator<Item = f64> {
    (0..blocks).map(move |index| block_deg(index, blocks))
}
