// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Readings of the lift tables of a job, and the jerk of each possible reading.

use super::PreparedJob;
use super::turn::LobeTurn;
use camwright::cam::lift::{LiftLaw, LiftTable, TableReading};
use camwright::cam::outline::fit::FittedOutline;
use camwright::job::grinding::{ProfileSpec, SpeedLaw};
use camwright::machine::description::Axis;
use camwright::math::hermite::Sample;
use camwright::math::units::{TURN_RAD, deg_from_rad, um_from_mm};
use camwright::motion::cut_motion::chain;
use camwright::toolpath::wheel_path::ToolPath;
use camwright_files::job_file::Job;
use camwright_files::lift_file::ProfileLift;
use serde::Serialize;
use std::fmt;

/// Lift table in `summary.json`.
#[derive(Debug, Clone, Serialize)]
pub struct LiftSummary {
    pub profile: String,
    /// Files of the table.
    pub files: Vec<String>,
    /// Rows over one turn, mirrored and filled-in ones included.
    pub blocks: usize,
    /// The reading that is used first, then what the others would have been.
    pub readings: Vec<ReadingSummary>,
    /// Lines and arcs through the points of a contour, in place of a reading.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outline: Option<OutlineSummary>,
}

impl LiftSummary {
    /// A line for each reading.
    pub fn texts(&self) -> impl Iterator<Item = String> + '_ {
        let readings = self.readings.iter().map(ToString::to_string);
        let outline = self.outline.iter().map(ToString::to_string);
        readings.chain(outline).map(|text| format!("lift {:<8} {text}", self.profile))
    }
}

/// Lines and arcs that were found through points.
#[derive(Debug, Clone, Serialize)]
pub struct OutlineSummary {
    pub lines: usize,
    /// Radii of the arcs, in their order; negative where the contour is hollow.
    pub radii_mm: Vec<f64>,
    /// Largest deviation from a point.
    pub max_deviation_mm: f64,
}

impl OutlineSummary {
    fn new(outline: &FittedOutline) -> Self {
        let radii_mm = outline.segments.iter().filter_map(|segment| segment.radius_mm).collect();
        Self { lines: outline.lines(), radii_mm, max_deviation_mm: outline.max_deviation_mm }
    }
}

impl fmt::Display for OutlineSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let radii: Vec<String> = self.radii_mm.iter().map(|radius| format!("{radius:.4}")).collect();
        let deviation_um = um_from_mm(self.max_deviation_mm);
        write!(f, "lines {}, arcs {} (", self.lines, radii.len())?;
        write!(f, "R {} mm), largest deviation from a point {deviation_um:.3} um", radii.join(", "))
    }
}

/// One way to read a table.
#[derive(Debug, Clone, Serialize)]
pub struct ReadingSummary {
    /// `smoothest`, `cubic_spline` or `smooth_within`.
    pub reading: &'static str,
    /// True for the reading that the job uses.
    pub is_used: bool,
    /// Largest third derivative of the lift over the cam angle.
    pub peak_jerk_mm_rad3: f64,
    /// Tolerance of a point.
    pub allowed_mm: f64,
    /// Largest deviation from a point.
    pub max_deviation_mm: f64,
    /// Cam angle of that point.
    pub max_deviation_deg: f64,
    /// Root of the mean square over all points.
    pub rms_deviation_mm: f64,
    /// Demand on the X axis; only within a job, which has a wheel and a speed.
    pub x_axis: Option<AxisJerk>,
}

/// Demand of a reading on `x_axis` on the path of the wheel, at one speed of C.
#[derive(Debug, Clone, Serialize)]
pub struct AxisJerk {
    /// The work speed of the last pass; where its speed varies the mean of its turn.
    pub work_speed_rpm: f64,
    /// True if the speed varies.
    pub varies: bool,
    /// Largest jerk at the speeds of the turn; where there is no path that of the lift alone at the work speed above.
    pub jerk_mm_s3: f64,
    /// Limit of the axis.
    pub limit_mm_s3: f64,
    /// Why this reading gives the wheel no path, if it does not.
    pub no_path: Option<String>,
}

impl ReadingSummary {
    fn new(reading: &TableReading, is_used: bool) -> Self {
        Self {
            x_axis: None,
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
        if let Some(x) = &self.x_axis {
            let (jerk, percent) = (x.jerk_mm_s3, 100.0 * x.jerk_mm_s3 / x.limit_mm_s3);
            let speed = format!("{:.1} rpm{}", x.work_speed_rpm, if x.varies { " in the mean" } else { "" });
            match x.no_path {
                None => write!(f, ", X axis {jerk:.0} mm/s3 at {speed} ({percent:.1} % of its limit)")?,
                Some(_) => {
                    write!(f, ", no path for the wheel, the lift alone needs {jerk:.3e} mm/s3 at {speed}")?;
                }
            }
        }
        if self.allowed_mm > 0.0 {
            write!(
                f,
                ", largest deviation {:.3} um (at {:.2} deg, limit {:.3} um), {:.3} um rms",
                um_from_mm(self.max_deviation_mm),
                self.max_deviation_deg,
                um_from_mm(self.allowed_mm),
                um_from_mm(self.rms_deviation_mm)
            )
        } else {
            f.write_str(", through every point")
        }
    }
}

/// Reading used for a table, then the alternatives; empty for a formula.
pub(super) fn readings(lift: &ProfileLift) -> Vec<ReadingSummary> {
    let used = lift.law.reading().map(|reading| ReadingSummary::new(&reading, true));
    let others = lift.others.iter().map(|reading| ReadingSummary::new(reading, false));
    used.into_iter().chain(others).collect()
}

/// Points on which a path is looked at in each of its intervals, where its third derivative is a parabola.
const PER_INTERVAL: u32 = 4;

/// Motion of C in the last pass over a profile.
enum PassMotion<'a> {
    /// At one speed (rad/s).
    Evenly(f64),
    /// Motion of this turn.
    Planned(LobeTurn<'a>),
}

impl<'a> PassMotion<'a> {
    fn from_job(job: &Job, prepared: Option<&'a PreparedJob>, profile: usize) -> Option<Self> {
        match job.spec.passes.last()?.speed {
            SpeedLaw::ConstantWorkSpeed { work_speed_rad_s } => Some(Self::Evenly(work_speed_rad_s)),
            _ => {
                let lobe = job.spec.lobes.iter().position(|lobe| lobe.profile == profile)?;
                LobeTurn::new(prepared?, lobe, job.spec.passes.len() - 1).map(Self::Planned)
            }
        }
    }

    /// In the mean of a turn (rad/s).
    fn mean_rad_s(&self) -> f64 {
        match self {
            Self::Evenly(speed) => *speed,
            Self::Planned(turn) => TURN_RAD / turn.turn_s,
        }
    }

    /// Largest jerk of X on a path (mm/s³); the angle of the path is `sense` times that of the plan.
    fn peak_jerk_mm_s3(&self, path: &ToolPath, sense: f64) -> f64 {
        match self {
            Self::Evenly(speed) => {
                let count = PER_INTERVAL * u32::try_from(path.accuracy().knots).unwrap_or(u32::MAX / PER_INTERVAL);
                let jerk = |i: u32| path.sample(f64::from(i) * TURN_RAD / f64::from(count)).third.abs();
                (0..count).map(jerk).fold(0.0, f64::max) * speed * speed * speed
            }
            Self::Planned(turn) => {
                let jerk = |c: Sample| {
                    let c = Sample {
                        value: sense * c.value,
                        first: sense * c.first,
                        second: sense * c.second,
                        third: sense * c.third,
                    };
                    chain(path.sample(c.value), c).third.abs()
                };
                turn.points.iter().map(|point| jerk(point.c)).fold(0.0, f64::max)
            }
        }
    }
}

/// Adds to the readings of a profile what each costs the X axis: on the path that is planned, and on the one that would be.
fn add_axis_jerk(readings: &mut [ReadingSummary], job: &Job, prepared: Option<&PreparedJob>, profile: usize) {
    let Some(turning) = PassMotion::from_job(job, prepared, profile) else { return };
    let lift = &job.lifts[profile];
    let machine = prepared.map_or(&job.machine.description, |prepared| &prepared.machine);
    let wheel_radius_mm = prepared.map_or_else(
        || job.wheel_radius_mm.unwrap_or(machine.wheel.new_radius_mm),
        |prepared| prepared.wheel_radius_mm,
    );
    let planned = prepared.and_then(|prepared| {
        let lobe = job.spec.lobes.iter().position(|lobe| lobe.profile == profile)?;
        Some(&prepared.planned.lobes.get(lobe)?.tool_path)
    });
    let spec = &job.spec.profiles[profile];
    let sense = f64::from(machine.rotation_sense);
    let peak = |path: &ToolPath| turning.peak_jerk_mm_s3(path, sense);
    let mean = turning.mean_rad_s();
    let used = lift.law.reading().map(|reading| reading.reading);
    let kinds = used.into_iter().chain(lift.others.iter().map(|reading| reading.reading));
    for (summary, reading) in readings.iter_mut().zip(kinds) {
        let jerk = match (summary.is_used, planned) {
            (true, Some(path)) => Ok(peak(path)),
            (true, None) => path_of(&lift.law, spec, wheel_radius_mm).map(|path| peak(&path)),
            (false, _) => {
                let Some(table) = &lift.table else { continue };
                (LiftLaw::read_table(table, reading).map_err(|error| error.to_string()))
                    .and_then(|law| path_of(&law, spec, wheel_radius_mm))
                    .map(|path| peak(&path))
            }
        };
        summary.x_axis = Some(AxisJerk {
            work_speed_rpm: mean * 60.0 / TURN_RAD,
            varies: matches!(turning, PassMotion::Planned(_)),
            jerk_mm_s3: *jerk.as_ref().unwrap_or(&(summary.peak_jerk_mm_rad3 * mean * mean * mean)),
            limit_mm_s3: machine.axis(Axis::X).limits.jerk,
            no_path: jerk.err(),
        });
    }
}

/// The path of the wheel for a profile with this lift.
fn path_of(lift: &LiftLaw, profile: &ProfileSpec, wheel_radius_mm: f64) -> Result<ToolPath, String> {
    let profile = ProfileSpec { lift: lift.clone(), ..profile.clone() };
    let contour = profile.contour().map_err(|error| error.to_string())?;
    ToolPath::for_wheel(&contour, wheel_radius_mm).map_err(|error| error.to_string())
}

/// Reading of every table of a job; `prepared` if it could be planned.
pub(super) fn summaries(job: &Job, prepared: Option<&PreparedJob>) -> Vec<LiftSummary> {
    let summary = |(index, (profile, lift)): (usize, (&ProfileSpec, &ProfileLift))| {
        let of_outline = lift.outline.as_ref().map(|outline| outline.points);
        let blocks = lift.table.as_ref().map(LiftTable::blocks).or(of_outline)?;
        let mut readings = readings(lift);
        add_axis_jerk(&mut readings, job, prepared, index);
        Some(LiftSummary {
            profile: profile.name.clone(),
            files: lift.files.iter().map(|file| file.display().to_string()).collect(),
            blocks,
            readings,
            outline: lift.outline.as_ref().map(OutlineSummary::new),
        })
    };
    job.spec.profiles.iter().zip(&job.lifts).enumerate().filter_map(summary).collect()
}

/// One line for each reading of each table.
pub(super) fn notes(job: &Job, prepared: Option<&PreparedJob>) -> Vec<String> {
    summaries(job, prepared).iter().flat_map(LiftSummary::texts).collect()
}
