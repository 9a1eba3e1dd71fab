// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Progress bar of `camwright run`: one bar for planning, start, run, bag and report.

use super::output::note;
use camwright_bag::progress;
use camwright_files::convert::um_from_m as um;
use camwright_msgs::camwright_msgs::action::RunJobFeedback;
use camwright_ros::GoalStatus;
use indicatif::{ProgressBar, ProgressDrawTarget};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Length of the bar.
const WHOLE: u64 = 1000;

/// Stage of a run that is no job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    Planning,
    Starting,
    Running,
    Closing,
    Reporting,
}

impl Stage {
    const fn start(self) -> u64 {
        match self {
            Self::Planning => 0,
            Self::Starting => 20,
            Self::Running => JOBS.0,
            Self::Closing => JOBS.1,
            Self::Reporting => 960,
        }
    }

    const fn text(self) -> &'static str {
        match self {
            Self::Planning => "planning",
            Self::Starting => "starting the nodes",
            Self::Running => "running the job",
            Self::Closing => "closing the bag",
            Self::Reporting => "writing the report",
        }
    }
}

/// Part of the bar that the jobs of all parts share.
const JOBS: (u64, u64) = (40, 940);

/// Bar of a run, on a terminal only. It is cleared if the run does not come to its end.
pub(super) struct RunProgress {
    bar: ProgressBar,
    began: Instant,
    /// Stages so far, and when each began.
    stages: Mutex<Vec<(Stage, Instant)>>,
}

impl RunProgress {
    /// Bar at its start; hidden where log lines would tear it.
    pub(super) fn start(is_hidden: bool) -> Self {
        let bar = match is_hidden {
            true => ProgressBar::with_draw_target(Some(WHOLE), ProgressDrawTarget::hidden()),
            false => progress::bar(WHOLE, "{bar:24} {percent:>3} %  {wide_msg}"),
        };
        let progress = Self { bar, began: Instant::now(), stages: Mutex::default() };
        progress.enter(Stage::Planning);
        progress
    }

    pub(super) fn enter(&self, stage: Stage) {
        self.stages.lock().unwrap_or_else(PoisonError::into_inner).push((stage, Instant::now()));
        self.bar.set_position(stage.start());
        self.bar.set_message(stage.text());
    }

    /// Progress of the job of one part, from 0 on.
    pub(super) fn job(&self, part: u32, parts: u32) -> JobProgress {
        let (from, to) = JOBS;
        let share = (to - from) / u64::from(parts.max(1));
        let job = JobProgress { bar: self.bar.clone(), from: from + share * u64::from(part), share };
        job.bar.set_position(job.from);
        job.bar.set_message("planning the job");
        job
    }

    /// Runs something that prints on the terminal.
    pub(super) fn suspend<R>(&self, print: impl FnOnce() -> R) -> R {
        self.bar.suspend(print)
    }

    /// Shows how many simulations of causes are done.
    pub(super) fn simulated(&self, done: usize, of: usize) {
        self.bar.set_message(format!("simulating the causes of the form error, {done} of {of} done"));
    }

    /// Time of each stage until now, one line each.
    pub(super) fn timings(&self) -> String {
        let stages = self.stages.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        let ends = stages.iter().skip(1).map(|(_, began)| *began).chain([now]);
        let line = |name: &str, time: Duration| format!("{name:<20} {:>7.3} s", time.as_secs_f64());
        let mut lines: Vec<String> = stages
            .iter()
            .zip(ends)
            .map(|((stage, began), end)| line(stage.text(), end.duration_since(*began)))
            .collect();
        lines.push(line("in all", now.duration_since(self.began)));
        lines.join("\n")
    }

    /// Ends the bar of a job with this end.
    pub(super) fn end(&self, status: GoalStatus) {
        match status {
            GoalStatus::Succeeded => self.finish(),
            _ => self.bar.finish_and_clear(),
        }
    }

    /// Fills the bar, which stays on the terminal.
    fn finish(&self) {
        self.bar.finish_with_message(format!("done in {:.1} s", self.began.elapsed().as_secs_f64()));
        if !self.bar.is_hidden() {
            // A finished bar does not end its line.
            note!("");
        }
    }
}

impl Drop for RunProgress {
    fn drop(&mut self) {
        if !self.bar.is_finished() {
            self.bar.finish_and_clear();
        }
    }
}

/// Part of the bar for one job.
#[derive(Clone)]
pub(super) struct JobProgress {
    bar: ProgressBar,
    from: u64,
    share: u64,
}

impl JobProgress {
    pub(super) fn show(&self, feedback: &RunJobFeedback) {
        self.bar.set_position(self.position(feedback.percent));
        self.bar.set_message(progress_text(feedback));
    }

    pub(super) fn suspend<R>(&self, print: impl FnOnce() -> R) -> R {
        self.bar.suspend(print)
    }

    fn position(&self, percent: f64) -> u64 {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part of the bar")]
        let done = (percent.clamp(0.0, 100.0) / 100.0 * self.share as f64) as u64;
        self.from + done
    }
}

/// Lobe, phase, turn and time left; before the first motion the time only.
fn progress_text(feedback: &RunJobFeedback) -> String {
    let mut parts = vec![format!("{} {}", feedback.lobe, feedback.phase_name).trim().to_owned()];
    parts.retain(|part| !part.is_empty());
    if feedback.turns > 0.0 {
        parts.push(format!("turn {:.1} of {:.0}", feedback.turn, feedback.turns));
        parts.push(format!("{:.0} um", um(feedback.stock)));
    }
    parts.push(format!("{:.0} s left", feedback.time_left));
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_has_no_empty_part() {
        let feedback = RunJobFeedback { time_left: 0.2, ..RunJobFeedback::default() };
        assert_eq!(progress_text(&feedback), "0 s left");
        let feedback =
            RunJobFeedback { lobe: "I1".into(), phase_name: "cut".into(), turn: 1.5, turns: 9.0, ..feedback };
        assert_eq!(progress_text(&feedback), "I1 cut, turn 1.5 of 9, 0 um, 0 s left");
    }

    #[test]
    fn the_parts_of_a_batch_share_the_bar_and_it_ends_full() {
        let progress = RunProgress::start(true);
        let positions: Vec<u64> =
            (0..3).flat_map(|part| [0.0, 50.0, 100.0].map(|p| progress.job(part, 3).position(p))).collect();
        assert_eq!(positions, [40, 190, 340, 340, 490, 640, 640, 790, 940]);
        assert_eq!(progress.job(0, 1).position(f64::NAN), 40);
        progress.finish();
        assert_eq!((progress.bar.position(), progress.bar.is_finished()), (WHOLE, true));
    }
}
