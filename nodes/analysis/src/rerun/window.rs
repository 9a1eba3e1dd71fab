// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Part of a run.

/// Ticks to replay; default: all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Window {
    /// From the last keyframe up to this tick.
    pub from_tick: Option<u64>,
    /// Up to this tick.
    pub to_tick: Option<u64>,
}
