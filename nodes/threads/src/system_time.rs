// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The system clock.

/// The system clock, in ns since 1970.
pub fn system_time_ns() -> i64 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
}
