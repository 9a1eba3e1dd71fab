// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Plans, and files that are refused.

#[path = "../support/cell.rs"]
mod cell;
#[path = "../support/changed_bag.rs"]
mod changed_bag;
#[path = "../support/mod.rs"]
mod support;

mod bores;
mod crank_pins;
mod file_mutations;
mod learn;
mod parameter_file;
mod plan_command;
mod pockets;
mod punches;
mod refusals;
mod schema;
mod starter_files;
mod steady_rest;
mod study;
mod tapered_lobes;
mod terminal;
mod tutorials;
mod two_wheels;
mod warnings;
mod wide_lobes;
mod wrong_inputs;
