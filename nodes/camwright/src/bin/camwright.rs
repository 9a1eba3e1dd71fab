// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The command line: the whole cell in one process, and the tools around it.

use std::process::ExitCode;

fn main() -> ExitCode {
    camwright_nodes::cli::main()
}
