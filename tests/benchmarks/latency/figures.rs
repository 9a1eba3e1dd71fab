// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Measured values, and their table.

use std::fmt::Write;
use std::time::Duration;

/// A row of a table: one path and who answered on it.
#[derive(Debug, Clone)]
pub struct Row {
    pub path: &'static str,
    pub who: String,
    pub times: Vec<Duration>,
    /// Questions without an answer.
    pub lost: usize,
    /// Samples that were wanted; fewer mean that it was interrupted.
    pub wanted: usize,
}

impl Row {
    pub fn new(path: &'static str, who: impl Into<String>, wanted: usize) -> Self {
        Self { path, who: who.into(), times: Vec::new(), lost: 0, wanted }
    }

    pub fn is_complete(&self) -> bool {
        self.times.len() == self.wanted && self.lost == 0
    }

    /// The smallest time that this share of the samples does not exceed, those that were lost being slower than all others: `None` if it
    /// lies among them.
    fn quantile(sorted: &[Duration], lost: usize, share: f64) -> Option<Duration> {
        #[allow(clippy::cast_possible_truncation, reason = "a share of a length")]
        let index = (share * (sorted.len() + lost) as f64).ceil() as usize;
        sorted.get(index.saturating_sub(1)).copied()
    }
}

fn text(time: Option<Duration>) -> String {
    time.map_or_else(|| "–".to_owned(), |time| format!("{:.3}", time.as_secs_f64() * 1e3))
}

/// The rows as a table in Markdown, times in ms.
pub fn table<'a>(rows: impl Iterator<Item = &'a Row>) -> String {
    let mut markdown =
        String::from("| path | who answers | samples | p50 ms | p99 ms | max ms |\n|---|---|---:|---:|---:|---:|\n");
    for row in rows {
        let mut sorted = row.times.clone();
        sorted.sort();
        let lost = if row.lost > 0 { format!(", {} lost", row.lost) } else { String::new() };
        let [p50, p99] = [0.5, 0.99].map(|share| text(Row::quantile(&sorted, row.lost, share)));
        let max = text(sorted.last().copied());
        let _never_fails =
            writeln!(markdown, "| {} | {} | {}{lost} | {p50} | {p99} | {max} |", row.path, row.who, sorted.len());
    }
    markdown
}

/// Seeded numbers for the pauses between samples, so that none falls always into the same moment of a tick.
#[derive(Debug)]
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// `splitmix64` by Sebastiano Vigna.
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A time of less than `max`.
    pub fn below(&mut self, max: Duration) -> Duration {
        let max_ns = u64::try_from(max.as_nanos()).unwrap_or(u64::MAX).max(1);
        Duration::from_nanos(self.next() % max_ns)
    }
}
