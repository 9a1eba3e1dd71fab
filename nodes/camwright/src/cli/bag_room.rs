//! Predicted size of the bag of `camwright run`, checked against the free disk space before anything moves.

use super::pace::PaceArg;
use crate::bag_size::{BagSize, Pace};
use camwright_files::any_job::AnyJob;
use camwright_planning::{self as planning, AnyPrepared};
use camwright_ros::running::NodeError;
use std::path::Path;

/// Returns the plan that the size follows from, and prints the size where `verbose`. The planner rejects a job that cannot be read or planned.
///
/// # Errors
/// The disk lacks space for the bag and the reserve.
pub(super) fn announce(
    job: Option<&AnyJob>,
    pace: PaceArg,
    parts: u32,
    bag: &Path,
    verbose: bool,
) -> Result<Option<AnyPrepared>, NodeError> {
    let Some(prepared) = job.and_then(|job| planning::plan_any(job.clone(), None).ok()) else { return Ok(None) };
    let pace = match pace {
        PaceArg::Realtime => Pace::Realtime,
        PaceArg::Fast => Pace::Fast,
    };
    let size = BagSize::estimate(&prepared, pace).times(parts);
    if verbose {
        eprintln!("recording {}", size.to_text());
    }
    size.lacks_room(bag).map_or(Ok(Some(prepared)), |reason| Err(NodeError::Parameter(reason)))
}
