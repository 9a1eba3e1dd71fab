// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Time of each stage from a job file to the hash of its plan. The core sees no clock: it reports that a stage begins.

use camwright::planner::{PlanHost, PlanStage};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// A stage from a job file to a plan hash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlanningStage {
    /// Files of job, machine and lifts.
    Read,
    /// A stage of the planner.
    Plan(PlanStage),
    /// A turning job, as a whole.
    Turning,
    /// Program, measuring plan and inspections.
    Complete,
    /// Pages and their hash.
    Hash,
}

impl PlanningStage {
    /// Its name in a table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Plan(PlanStage::Prepare) => "prepare",
            Self::Plan(PlanStage::Contour) => "contour",
            Self::Plan(PlanStage::Path) => "path",
            Self::Plan(PlanStage::Speed) => "speed",
            Self::Plan(PlanStage::Sequence) => "sequence",
            Self::Plan(PlanStage::Check) => "check",
            Self::Plan(PlanStage::Dress) => "dress",
            Self::Turning => "turning",
            Self::Complete => "complete",
            Self::Hash => "hash",
        }
    }
}

/// A thread per processor. They end no process: a panic in one of them continues in the thread that waits for the result. `None` where the
/// system gives no threads.
static PROCESSORS: LazyLock<Option<ThreadPool>> =
    LazyLock::new(|| ThreadPoolBuilder::new().thread_name(|index| format!("planner-{index}")).build().ok());

/// Host of the planner with all processors, and a stopwatch.
#[derive(Debug)]
pub struct Timings {
    begun: Mutex<Vec<(PlanningStage, Instant)>>,
}

impl Timings {
    /// A stopwatch that starts with reading files.
    #[must_use]
    pub fn start() -> Self {
        Self { begun: Mutex::new(vec![(PlanningStage::Read, Instant::now())]) }
    }

    pub(crate) fn enter(&self, stage: PlanningStage) {
        self.begun.lock().unwrap_or_else(PoisonError::into_inner).push((stage, Instant::now()));
    }

    /// Time of each stage so far, in their order; the last one ends now.
    #[must_use]
    pub fn stages(&self) -> Vec<(PlanningStage, Duration)> {
        let begun = self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        let ends = begun.iter().skip(1).map(|(_, at)| *at).chain([Instant::now()]);
        begun.iter().zip(ends).map(|((stage, at), end)| (*stage, end.duration_since(*at))).collect()
    }
}

impl PlanHost for Timings {
    fn begins(&self, stage: PlanStage) {
        self.enter(PlanningStage::Plan(stage));
    }

    fn map<T: Send>(&self, count: usize, each: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
        match PROCESSORS.as_ref() {
            Some(pool) => pool.install(|| (0..count).into_par_iter().map(each).collect()),
            None => (0..count).map(each).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    #[test]
    fn results_are_in_order_and_stages_as_they_began() {
        let timings = Timings::start();
        timings.begins(PlanStage::Contour);
        assert_eq!(timings.map(100, |index| 3 * index), (0..100).map(|index| 3 * index).collect::<Vec<_>>());
        timings.begins(PlanStage::Path);
        let stages: Vec<&str> = timings.stages().iter().map(|(stage, _)| stage.name()).collect();
        assert_eq!(stages, ["read", "contour", "path"]);
    }

    /// A defect in a lobe reaches the supervisor of the thread that plans, with its message, and later plans work.
    #[test]
    fn a_panic_in_a_parallel_part_reaches_the_caller() {
        let timings = Timings::start();
        let defect = |index: usize| if index == 7 { panic!("defect of lobe {index}") } else { index };
        let caught = catch_unwind(AssertUnwindSafe(|| timings.map(20, defect))).expect_err("one of them panics");
        assert_eq!(caught.downcast_ref::<String>().map(String::as_str), Some("defect of lobe 7"));
        assert_eq!(timings.map(2, |index| index), [0, 1]);
    }

    /// The plan is the same to the bit as that of the core alone.
    #[test]
    fn the_host_changes_no_bit_of_a_plan() {
        let job = camwright_files::job_file::load("four_lobe_camshaft", &[]).expect("it ships");
        let machine = &job.machine.description;
        let wheel = machine.wheel.new_radius_mm;
        let alone = camwright::planner::plan_job(&job.spec, machine, wheel, None).expect("it can be made");
        let hosted = camwright::planner::plan_job_on(&Timings::start(), &job.spec, machine, wheel, None);
        assert_eq!(hosted.expect("it can be made"), alone);
    }
}
