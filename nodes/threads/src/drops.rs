// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Count of dropped messages.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Number of messages that were dropped. Clones count together.
#[derive(Debug, Clone, Default)]
pub struct DropCounter(Arc<AtomicU64>);

impl DropCounter {
    /// Messages dropped so far.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    pub fn add(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}
