// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Records as texts, whose numbers read back to the bit.

use serde::Serialize;

/// A record as a text: with as many digits as it takes to read its numbers back to the bit.
pub fn record_text(record: &impl Serialize) -> String {
    // Maps with keys that are no text are all that JSON refuses; there are none in a record.
    serde_json::to_string(record).unwrap_or_default()
}
