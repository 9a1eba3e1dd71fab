//! How the lift tables of a job were read, and the jerk that each way to read them costs.

use crate::config::job_file::Job;
use crate::config::lift_file::ProfileLift;
use camwright::lift::TableReading;
use camwright::units::deg_from_rad;
use serde::Serialize;
use std::fmt;

/// What `summary.json` says about a lift table.
#[derive(Debug, Clone, Serialize)]
pub struct LiftSummary {
    /// The profile.
    pub profile: String,
    /// Files of the table.
    pub files: Vec<String>,
    /// Rows over one turn, mirrored and filled-in ones included.
    pub blocks: usize,
    /// The reading that is used first, then what the others would have been.
    pub readings: Vec<ReadingSummary>,
}

/// One way to read a table.
#[derive(Debug, Clone, Serialize)]
pub struct ReadingSummary {
    /// `smoothest`, `cubic_spline` or `smooth_within`.
    pub reading: &'static str,
    /// Whether the job is made with it.
    pub is_used: bool,
    /// Largest third derivative of the lift over the cam angle.
    pub peak_jerk_mm_rad3: f64,
    /// How far the curve may lie from a point.
    pub allowed_mm: f64,
    /// How far it lies from a point at most.
    pub max_deviation_mm: f64,
    /// Cam angle of that point.
    pub max_deviation_deg: f64,
    /// Root of the mean square over all points.
    pub rms_deviation_mm: f64,
}

impl ReadingSummary {
    fn new(reading: &TableReading, is_used: bool) -> Self {
        Self {
            reading: reading.reading.name(),
            is_used,
            peak_jerk_mm_rad3: reading.peak_jerk_mm_rad3,
            allowed_mm: reading.allowed_mm,
            max_deviation_mm: reading.max_deviation_mm,
            max_deviation_deg: deg_from_rad(reading.max_deviation_rad),
            rms_deviation_mm: reading.rms_deviation_mm,
        }
    }
}

impl fmt::Display for ReadingSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verb = if self.is_used { "used" } else { "not used" };
        write!(f, "{verb:<8} {:<13} peak jerk {:>11.1} mm/rad3", self.reading, self.peak_jerk_mm_rad3)?;
        if self.allowed_mm > 0.0 {
            write!(
                f,
                ", off the points by {:.3} um at most (at {:.2} deg, {:.3} um allowed), {:.3} um rms",
                1e3 * self.max_deviation_mm,
                self.max_deviation_deg,
                1e3 * self.allowed_mm,
                1e3 * self.rms_deviation_mm
            )
        } else {
            f.write_str(", through every point")
        }
    }
}

/// How a table was read, then the ways it was not; empty for a formula.
pub(super) fn readings(lift: &ProfileLift) -> Vec<ReadingSummary> {
    let used = lift.law.reading().map(|reading| ReadingSummary::new(&reading, true));
    let others = lift.others.iter().map(|reading| ReadingSummary::new(reading, false));
    used.into_iter().chain(others).collect()
}

pub(super) fn summaries(job: &Job) -> Vec<LiftSummary> {
    (job.spec.profiles.iter().zip(&job.lifts))
        .filter_map(|(profile, lift)| {
            Some(LiftSummary {
                profile: profile.name.clone(),
                files: lift.files.iter().map(|file| file.display().to_string()).collect(),
                blocks: lift.table.as_ref()?.blocks(),
                readings: readings(lift),
            })
        })
        .collect()
}

/// One line for each reading of each table.
pub(super) fn notes(job: &Job) -> Vec<String> {
    summaries(job)
        .iter()
        .flat_map(|lift| lift.readings.iter().map(move |reading| format!("lift {:<8} {reading}", lift.profile)))
        .collect()
}
