// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Replay to the bit, golden bags, and the report of a run.

#[path = "../support/cell.rs"]
mod cell;
#[path = "../support/changed_bag.rs"]
mod changed_bag;
#[path = "../support/chromium.rs"]
mod chromium;
#[path = "../support/mod.rs"]
mod support;

mod golden_bags;
mod replay_to_the_bit;
mod report;
mod same_bits;
