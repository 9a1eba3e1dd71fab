//! What `camwright run` says of its bag before anything moves: how large it will be, and whether there is room for it.

use super::pace::PaceArg;
use crate::bag_size::{BagSize, Pace};
use camwright_files::any_job::AnyJob;
use camwright_planning::{self as planning, AnyPrepared};
use camwright_ros::running::NodeError;
use std::path::Path;

/// Prints the size, and returns the plan that it follows from. The planner rejects a job that cannot be read or planned.
///
/// # Errors
/// There is less room on the disk than the bag will take, and what has to be left.
pub(super) fn announce(
    job: Option<&AnyJob>,
    pace: PaceArg,
    parts: u32,
    bag: &Path,
) -> Result<Option<AnyPrepared>, NodeError> {
    let Some(prepared) = job.and_then(|job| planning::plan_any(job.clone(), None).ok()) else { return Ok(None) };
    let pace = match pace {
        PaceArg::Realtime => Pace::Realtime,
        PaceArg::Fast => Pace::Fast,
    };
    let size = BagSize::of(&prepared, pace).times(parts);
    eprintln!("recording {}", size.to_text());
    size.lacks_room(bag).map_or(Ok(Some(prepared)), |reason| Err(NodeError::Parameter(reason)))
}
