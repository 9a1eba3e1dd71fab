// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The core from outside, theme by theme: `cargo test -p camwright --test integration machine::chatter`.

mod cams;
mod solids;

mod cam;
mod gouging;
mod interpolator;
mod job;
mod journal;
mod machine;
mod motion;
mod nc;
mod post;
mod program_motion;
mod rooms;
mod runout;
mod toolpath;
