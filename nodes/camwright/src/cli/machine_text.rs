// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Commands that print a text made from a machine file, without ROS.

use super::output::{print_error, say};
use camwright_files::locate::locate;
use camwright_files::machine_file::{self, MachineConfig};
use camwright_ros::running::NodeError;
use std::process::ExitCode;

/// Prints the text of a machine, by the name or path of its file and keys over it.
pub(super) fn print_machine_text(
    command: &str,
    (machine, keys): (&str, &[String]),
    text: impl FnOnce(&MachineConfig) -> Result<String, NodeError>,
) -> ExitCode {
    let made = locate("machines", machine, "yaml", None)
        .and_then(|located| machine_file::parse(&located.path, &located.text, keys))
        .map_err(NodeError::file)
        .and_then(|file| text(&file));
    match made {
        Ok(text) => {
            say!("{}", text.trim_end());
            ExitCode::SUCCESS
        }
        Err(error) => {
            print_error(command, &error);
            ExitCode::from(1)
        }
    }
}
