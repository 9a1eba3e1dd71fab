// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Which key of the job file, or of the machine file, is behind a refusal to turn a part.

use super::clearance_map;
use camwright::machine::description::{Axis, MachineDescription};
use camwright::planner::plan_check::{PlanCheckError, PlanFault};
use camwright::planner::{PlanError, TurningError, TurningKey};
use camwright::toolpath::insert_clearance::{InsertClearanceError, InsertClearanceKey, beside_centre};
use camwright::toolpath::insert_path::{InsertFeed, InsertPathError, InsertPathKey};
use camwright::toolpath::rake_section::RakeSectionError;
use camwright_files::ConfigError;
use camwright_files::turning_file::TurnedJob;

/// Key of the insert's height in a machine file.
const HEIGHT: &str = "insert.height_mm";

/// A refusal of the core as one sentence with the file and the line of the key that causes it.
pub(super) fn blame(job: &TurnedJob, machine: &MachineDescription, error: &TurningError) -> ConfigError {
    match cause(job, machine, error) {
        Cause::Job(key) => job.document.error(&key, error.to_string()),
        Cause::Machine(key) => ConfigError::at(job.machine.place(key), error.to_string()),
        Cause::Height(advice) => ConfigError::at(job.machine.place(HEIGHT), format!("{error}{advice}")),
    }
}

/// The file and the key that cause a refusal.
enum Cause {
    Job(String),
    Machine(&'static str),
    /// The height of the insert, with the heights that would do.
    Height(String),
}

fn job_key(key: &str) -> Cause {
    Cause::Job(key.to_owned())
}

fn cause(job: &TurnedJob, machine: &MachineDescription, error: &TurningError) -> Cause {
    match error {
        TurningError::NotALathe => job_key("machine"),
        TurningError::TurnsBackwards => Cause::Machine("rotation_sense"),
        TurningError::OutOfRange { what, .. } => job_key(match what {
            TurningKey::Begin => "turned.from_mm",
            TurningKey::End => "turned.to_mm",
            TurningKey::BarRadius => "bar_radius_mm",
            TurningKey::Clearance => "clearance_mm",
            TurningKey::RapidSpeed => "rapid_speed_mm_s",
            TurningKey::PartZero => "part_zero_mm",
            TurningKey::Stock => "roughing.stock_mm",
        }),
        TurningError::Passes(source) => path_cause(job, usize::MAX, source),
        TurningError::Path { pass, source } => path_cause(job, *pass, source),
        TurningError::TooLong { passes: 1, .. } => job_key("finishing"),
        TurningError::TooLong { .. } => job_key("roughing"),
        TurningError::TooFast { .. } => job_key("spindle.rpm"),
        TurningError::Spline { .. } => job_key("surface"),
        TurningError::NoStop { axis, .. } => Cause::Machine(axis.joint()),
        TurningError::OutsideEdge { .. } => Cause::Machine("insert.edge"),
        TurningError::Clearance(error) => clearance_cause(job, machine, error),
        TurningError::Step(error) => match &**error {
            PlanError::SoftLimit { axis, position_mm, high_mm, .. } => axis_cause(job, *axis, *position_mm, *high_mm),
            PlanError::Move { .. } => job_key("rapid_speed_mm_s"),
            PlanError::Check(error) => check_cause(job, error),
            _ => job_key(""),
        },
        TurningError::Check(error) => check_cause(job, error),
    }
}

/// Key that puts an axis outside its travel, beyond these limits or below them: X follows the part and retracts from the bar, Z is the
/// position of the clamped part.
fn axis_cause(job: &TurnedJob, axis: Axis, position_mm: f64, high_mm: f64) -> Cause {
    job_key(match axis {
        Axis::X if position_mm < high_mm => "surface",
        Axis::X if position_mm - job.spec.clearance_mm > high_mm => "bar_radius_mm",
        Axis::X => "clearance_mm",
        _ => "part_zero_mm",
    })
}

fn check_cause(job: &TurnedJob, error: &PlanCheckError) -> Cause {
    match &error.fault {
        PlanFault::SoftLimit { axis, position, high, .. } => axis_cause(job, *axis, *position, *high),
        PlanFault::Limit(_) => job_key("spindle"),
        _ => job_key(""),
    }
}

/// Passes are counted from 1; the last one finishes.
fn path_cause(job: &TurnedJob, pass: usize, error: &InsertPathError) -> Cause {
    let passes = job.spec.passes.stocks_mm().map_or(1, |stocks| stocks.len());
    let (of, feed) =
        if pass >= passes { ("finishing", job.spec.feed) } else { ("roughing", job.spec.passes.rough_feed) };
    let feed = match feed {
        InsertFeed::AlongZ(_) => format!("{of}.along_z_mm"),
        InsertFeed::AlongCurve(_) => format!("{of}.along_curve_mm"),
    };
    match error {
        InsertPathError::BadNumber { what, .. } => match what {
            InsertPathKey::InsertRadius => Cause::Machine("insert.radius_mm"),
            InsertPathKey::Feed => Cause::Job(feed),
            InsertPathKey::Stock => job_key("roughing.stock_mm"),
            InsertPathKey::FinishingStock => job_key("roughing.leaves_mm"),
            InsertPathKey::RoughingDepth | InsertPathKey::RoughingPasses => job_key("roughing.deepest_mm"),
            InsertPathKey::Angles => job_key("angles_per_turn"),
            InsertPathKey::Begin => job_key("turned.from_mm"),
            InsertPathKey::End => job_key("turned.to_mm"),
            InsertPathKey::SpindleSpeed => job_key("spindle.rpm"),
            _ => job_key("turned"),
        },
        InsertPathError::Section(RakeSectionError::Misses { .. }) => Cause::Machine(HEIGHT),
        InsertPathError::TooLong { .. } | InsertPathError::TooHollow { .. } => Cause::Job(feed),
        InsertPathError::Unresolved { .. } => job_key("angles_per_turn"),
        InsertPathError::ExceedsLimit { .. } => job_key("spindle"),
        InsertPathError::Section(_) | InsertPathError::Overhang { .. } | InsertPathError::Gouges { .. } => {
            job_key("surface")
        }
    }
}

/// The height of the insert, if another would do; else the surface.
fn clearance_cause(job: &TurnedJob, machine: &MachineDescription, error: &InsertClearanceError) -> Cause {
    let insert = machine.insert.as_ref();
    let heights = insert.and_then(|insert| clearance_map(job, insert).ok()?.heights().ok());
    match (error, heights) {
        (InsertClearanceError::BadNumber { what: InsertClearanceKey::Relief, .. }, _) => {
            Cause::Machine("insert.relief_deg")
        }
        (InsertClearanceError::BadNumber { .. } | InsertClearanceError::NoHeight { .. }, _) | (_, None) => {
            job_key("surface")
        }
        (InsertClearanceError::MeetsFlank { .. }, Some(_)) => Cause::Machine(HEIGHT),
        (_, Some(heights)) => Cause::Height(format!(
            "; from {} to {} it clears this surface, best {} ({HEIGHT}: {:.3})",
            beside_centre(heights.lowest_mm),
            beside_centre(heights.highest_mm),
            beside_centre(heights.best_mm),
            -heights.best_mm
        )),
    }
}
