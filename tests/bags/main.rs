// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Bags: recording, recovery, tables, the player.

#[path = "../support/bag_judges.rs"]
mod bag_judges;
#[path = "../support/recorder.rs"]
mod recorder;
#[path = "../support/mod.rs"]
mod support;

mod bag_endings;
mod bag_faults;
mod bag_tables;
mod player;
mod recorder_files;
mod recorder_load;
mod recording;
mod service_events;
