//! Expected readings of an inspection gauge on the lobes of a job.

use camwright::cam::inspection::Inspection;
use camwright::math::units::{deg_from_rad, rad_from_deg, wrap_turn};
use camwright::planner::PlannedJob;
use camwright_files::ConfigError;
use camwright_files::job_file::Job;
use std::io::{self, Write};

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
///
/// # Errors
/// What cannot be written.
pub fn write_inspection(inspection: &Inspection, blocks: u32, to: &mut dyn Write) -> io::Result<()> {
    writeln!(to, "cam_angle_deg,lift_mm,contact_azimuth_deg")?;
    for angle_deg in angles_deg(blocks) {
        if let Some(reading) = inspection.read(rad_from_deg(angle_deg)) {
            let azimuth_deg = deg_from_rad(wrap_turn(inspection.contour().azimuth(reading.contact_rad)));
            writeln!(to, "{angle_deg},{},{azimuth_deg}", reading.lift)?;
        }
    }
    Ok(())
}

fn angles_deg(blocks: u32) -> impl Iterator<Item = f64> {
    (0..blocks).map(move |index| f64::from(index) * 360.0 / f64::from(blocks))
}
