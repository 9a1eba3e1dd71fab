// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! NC programs: written, read back, driven, and judged by LinuxCNC.

#[path = "../../camwright/tests/cams/mod.rs"]
mod cams;
#[path = "../support/mod.rs"]
mod support;

mod groove_walls;
mod post_command;
mod program_in_the_cell;
mod programs_on_linuxcnc;
