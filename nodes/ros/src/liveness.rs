// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Detection of silent partners.
//!
//! Silence is measured between looks, each of which counts a bounded time: a process that was stopped, or a thread that was starved, does
//! not take its own pause for the silence of another.

use crate::{Logger, Node, Parameter};
use std::time::{Duration, Instant};

/// Name of the parameter.
const LIMIT: &str = "silence_limit_s";
/// Parameter for the longest silence of a partner.
pub fn parameter() -> Parameter {
    Parameter::double(LIMIT, 2.5)
        .describe("maximum silence of another node (s); a longer one ends the motion or the job with an alarm")
        .range(0.5, 60.0)
        .read_only()
}

/// Longest silence of a partner.
pub fn limit(node: &Node) -> Duration {
    Duration::from_secs_f64(node.parameters().double(LIMIT))
}

/// Warning that is logged at most once a second, for failures that repeat with every message.
#[derive(Debug, Default)]
pub struct LimitedWarning {
    last: Option<Instant>,
    kept_back: u64,
}

impl LimitedWarning {
    const PERIOD: Duration = Duration::from_secs(1);

    /// Logs a warning, or counts it.
    pub fn warn(&mut self, logger: &Logger, text: &str) {
        let now = Instant::now();
        if self.last.is_some_and(|last| now - last < Self::PERIOD) {
            self.kept_back += 1;
            return;
        }
        self.last = Some(now);
        match std::mem::take(&mut self.kept_back) {
            0 => logger.warn(text),
            more => logger.warn(&format!("{text} ({more} similar warnings before)")),
        }
    }
}
