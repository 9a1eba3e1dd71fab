// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The caller of the planner, which may compute independent parts in parallel and observe the stages.

use alloc::vec::Vec;

/// A stage of planning a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlanStage {
    /// Check of the job, infeed schedules.
    Prepare,
    /// Contours of the profiles.
    Contour,
    /// Course of the wheel, and its paths.
    Path,
    /// Start and speed of every lobe.
    Speed,
    /// Segments of the plan.
    Sequence,
    /// Forward check of the plan.
    Check,
    /// Dresses of the wheel.
    Dress,
}

/// A caller of [`super::plan_job_on`].
pub trait PlanHost {
    /// Reports that a stage begins, which ends the one before.
    fn begins(&self, stage: PlanStage);

    /// Returns the results of a function of 0 … count − 1 in this order, computed in any order. A panic of the function is the caller's.
    fn map<T: Send>(&self, count: usize, each: impl Fn(usize) -> T + Sync + Send) -> Vec<T>;
}

/// Computes everything in sequence and ignores the stages.
#[derive(Debug, Clone, Copy)]
pub struct OneByOne;

impl PlanHost for OneByOne {
    fn begins(&self, _: PlanStage) {}

    fn map<T: Send>(&self, count: usize, each: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
        (0..count).map(each).collect()
    }
}
