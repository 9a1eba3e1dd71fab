// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Everything that the sections of the page report.

use super::edge::ErrorSplit;
use super::gather::RecordedRun;
use super::job_timeline::JobTimeline;
use super::judge::ReportVerdict;
use super::lag::Lag;
use super::motion::RecordedMotion;
use camwright_planning::AnyPrepared;

/// Content of the page.
pub(super) struct Findings<'a> {
    pub(super) recorded: &'a RecordedRun,
    pub(super) story: &'a JobTimeline<'a>,
    pub(super) motion: Option<&'a RecordedMotion>,
    /// Errors that the axes leave on each lobe, or on the part.
    pub(super) lags: &'a [Option<Lag>],
    /// Causes of the worst point of a turned part, or the reason why they are unknown. None: no such part was judged.
    pub(super) split: Option<&'a Result<ErrorSplit, String>>,
    /// The executed plan, or the reason why it is unknown.
    pub(super) again: &'a Result<AnyPrepared, String>,
    pub(super) verdict: &'a ReportVerdict,
}

impl Findings<'_> {
    /// Time of a tick since the first one of the job (s). None: the ticks of the machine are not recorded.
    pub(super) fn seconds(&self, tick: u64) -> Option<f64> {
        let (first, _) = self.story.ticks?;
        Some((tick as f64 - first as f64) * self.recorded.cycle_s()?)
    }

    /// Rotation sense: +1 if the part turns clockwise with a positive C.
    pub(super) fn sense(&self) -> f64 {
        self.story.machine.map_or(1.0, |machine| f64::from(machine.rotation_sense))
    }
}
