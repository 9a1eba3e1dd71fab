//! What `camwright run` says of its bag before anything moves: how large it will be, and whether there is room for it.

use super::run::{PaceArg, RunArgs};
use crate::bag_size::{BagSize, Pace};
use crate::planning;
use crate::running::NodeError;
use std::path::Path;

/// Tells the size; a job that cannot be planned is the planner's to refuse.
///
/// # Errors
/// There is less room on the disk than the bag will take, and what has to be left.
pub(super) fn tell(job: &str, args: &RunArgs, bag: &Path) -> Result<(), NodeError> {
    let Ok(prepared) = planning::prepare_any(job, &args.set, None) else { return Ok(()) };
    let pace = match args.pace {
        PaceArg::Realtime => Pace::Realtime,
        PaceArg::Fast => Pace::Fast,
    };
    let size = BagSize::of(&prepared, pace).times(args.parts);
    eprintln!("recording {}", size.to_text());
    size.lacks_room(bag).map_or(Ok(()), |reason| Err(NodeError::Parameter(reason)))
}
