// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! In-process gauging and runout correction, judged by a model of the part that shares nothing with them.
//!
//! `cargo test -p camwright --test integration runout -- --nocapture` prints what every test found.

#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    reason = "a helper that fails fails its test, and counts of phases are small"
)]

mod correction;
mod identification;
mod noise;
mod part;
mod published;
mod refusals;
mod states;
