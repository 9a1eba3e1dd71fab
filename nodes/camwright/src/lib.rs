// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The command line of camwright: commands, the whole cell in one process, and the player of bags.

pub mod bag_size;
pub mod cli;
pub mod player;
