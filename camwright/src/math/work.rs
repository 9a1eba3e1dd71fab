// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A bound on the work that a file can ask for: counted while it is done, and refused once it is used up.

use core::cell::Cell;

/// Work that is allowed, in looks at a surface or steps alike.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkBudget {
    allowed: u64,
    spent: Cell<u64>,
}

impl WorkBudget {
    /// A budget of which nothing is spent.
    #[must_use]
    pub const fn new(allowed: u64) -> Self {
        Self { allowed, spent: Cell::new(0) }
    }

    #[inline]
    pub fn spend(&self, work: u64) {
        self.spent.set(self.spent.get().saturating_add(work));
    }

    /// The work exceeds the limit.
    #[inline]
    #[must_use]
    pub fn is_used_up(&self) -> bool {
        self.spent.get() > self.allowed
    }

    /// Work that is allowed.
    #[must_use]
    pub const fn allowed(&self) -> u64 {
        self.allowed
    }

    #[must_use]
    pub fn spent(&self) -> u64 {
        self.spent.get()
    }
}
