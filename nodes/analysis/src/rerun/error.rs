// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Errors of a replay.

use camwright_bag::BagError;

/// Reason why a run cannot be replayed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RerunError {
    /// The bag cannot be read.
    #[error(transparent)]
    Bag(#[from] BagError),
    /// The bag lacks something that a replay needs.
    #[error("{0}")]
    Cannot(String),
}
