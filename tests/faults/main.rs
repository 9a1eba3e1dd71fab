// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Faults, command authority, silent partners, malformed packets.

#[path = "../support/cell.rs"]
mod cell;
#[path = "../support/hostile.rs"]
mod hostile;
#[path = "../support/mod.rs"]
mod support;
#[path = "../support/watched.rs"]
mod watched;

mod authority;
mod diagnostics;
mod faults;
mod liveness;
mod malformed_packets;
mod two_hosts;
