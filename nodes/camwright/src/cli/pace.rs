// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Argument `--pace`.

use clap::ValueEnum;

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum PaceArg {
    Realtime,
    Fast,
}
