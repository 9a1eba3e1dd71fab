// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The house: crates, alarm table, message types, installation.

#[path = "../support/mod.rs"]
mod support;
#[path = "../support/viewer_files.rs"]
mod viewer_files;

mod alarm_table;
mod architecture;
mod comments;
mod documents;
mod installed_package;
mod messages_on_the_wire;
mod packages;
mod skipped_peers;
mod type_hashes;
mod viewer_display_files;
