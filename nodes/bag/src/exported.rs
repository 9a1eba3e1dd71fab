// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Result of an export.

use std::path::PathBuf;

#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Exported {
    /// Files of tables, or the new bag.
    pub paths: Vec<PathBuf>,
    pub messages: u64,
    /// Topics that could not be written as tables, and why.
    pub left_out: Vec<(String, String)>,
}
