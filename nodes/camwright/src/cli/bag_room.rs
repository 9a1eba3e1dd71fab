// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Directory and predicted size of the bag of `camwright run`, checked before a node starts.

use super::output::note;
use super::pace::PaceArg;
use crate::bag_size::BagSize;
use camwright_machine_cycle::pacing::Pace;
use camwright_planning::AnyPrepared;
use camwright_ros::running::NodeError;
use std::path::Path;

/// Checks that the bag can be created and that the disk has space for it; prints its size where `verbose`.
///
/// # Errors
/// The directory exists or cannot be created; the disk lacks space for the bag and the reserve.
pub(super) fn announce(
    prepared: &AnyPrepared,
    pace: PaceArg,
    parts: u32,
    bag: &Path,
    verbose: bool,
) -> Result<(), NodeError> {
    let pace = match pace {
        PaceArg::Realtime => Pace::Realtime,
        PaceArg::Fast => Pace::Fast,
    };
    let size = BagSize::estimate(prepared, pace).times(parts);
    if verbose {
        note!("recording {}", size.to_text());
    }
    let remedy = "free space, or name another disk with --bag";
    size.lacks_room(bag).map_or(Ok(()), |reason| Err(NodeError::Parameter(format!("{reason}; {remedy}"))))
}

/// Checks that the directory of a bag can be created, and leaves no folder behind.
///
/// # Errors
/// It exists, or cannot be created.
pub(super) fn is_free(bag: &Path) -> Result<(), NodeError> {
    let shown = bag.display();
    if bag.symlink_metadata().is_ok() {
        let message = format!("bag directory {shown} exists; name another with --bag, or remove it");
        return Err(NodeError::Parameter(message));
    }
    let is_new = |path: &&Path| !path.as_os_str().is_empty() && path.symlink_metadata().is_err();
    let new: Vec<&Path> = bag.ancestors().take_while(is_new).collect();
    let created = std::fs::create_dir_all(bag);
    // Those that were created are empty; others do not exist.
    new.iter().for_each(|folder| drop(std::fs::remove_dir(folder)));
    created.map_err(|error| {
        NodeError::Parameter(format!("bag directory {shown} cannot be created: {error}; name another with --bag"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bag_directory_is_checked_without_a_trace() {
        let folder = tempfile::tempdir().expect("a folder for temporary files");
        let folder = folder.path();
        std::fs::write(folder.join("file"), "").expect("it can be written");
        assert!(is_free(&folder.join("bags/run")).is_ok());
        assert!(!folder.join("bags").exists(), "nothing stays");
        let refusal = |path: &Path| is_free(path).expect_err("it is refused").to_string();
        assert!(refusal(folder).contains(" exists; name another with --bag"));
        assert!(refusal(&folder.join("file/run")).contains(" cannot be created: "));
    }
}
