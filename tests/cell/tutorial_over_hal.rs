// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The tutorial of LinuxCNC.

use crate::hal::{HomeFolder, as_user};
use crate::support;
use std::path::Path;
use support::tutorial;

#[test]
fn linuxcnc_machine() {
    let programs = [
        env!("CARGO_BIN_EXE_camwright"),
        env!("CARGO_BIN_EXE_machine_hal"),
        env!("CARGO_BIN_EXE_axis_interpolator"),
        env!("CARGO_BIN_EXE_job_planner"),
        env!("CARGO_BIN_EXE_run_logger"),
    ];
    // A computer without real time pauses for longer than the queue lasts, or than HAL may be silent.
    let is_pause = |difference: &str| ["alarm 80", "alarm 166"].iter().any(|alarm| difference.contains(alarm));
    for attempt in 1.. {
        let Some(home) = HomeFolder::new(&programs) else { return };
        let shell = as_user(Path::new("bash"), &home.path);
        match tutorial::follow_in("linuxcnc-machine.md", (&home.path, &home.path.join("bin")), shell) {
            Ok(()) => return,
            Err(difference) if attempt < 5 && is_pause(&difference) => {
                eprintln!("once more, after:\n{difference}");
            }
            Err(difference) => panic!("{difference}"),
        }
    }
}
