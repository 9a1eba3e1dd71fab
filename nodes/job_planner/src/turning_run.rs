// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A job that turns, on a thread of its own: bar, execution, measuring the surface.

use super::execution::{Execution, JobFailure, PlanShare};
use camwright_msgs::camwright_msgs::action::RunJobResult;
use camwright_planning::{self as planning, PreparedTurning, hash_of};
use std::time::Duration;

/// Maximum delay of the finished part: some hundred pages of 32 kB.
const MEASURING: Duration = Duration::from_secs(30);

/// One run of a job that turns.
pub(super) struct TurningRun {
    execution: Execution,
    prepared: PreparedTurning,
}

impl TurningRun {
    pub(super) fn new(execution: Execution, prepared: PreparedTurning) -> Self {
        Self { execution, prepared }
    }

    /// The whole run; the course is idle again when it returns.
    pub(super) fn run(mut self) {
        let mut result = RunJobResult { plan_hash: self.prepared.plan_hash().to_owned(), ..RunJobResult::default() };
        let outcome = self.proceed(&mut result);
        self.execution.end(outcome, result, Vec::new());
    }

    fn proceed(&mut self, result: &mut RunJobResult) -> Result<(), JobFailure> {
        let cancelled = || self.execution.is_cancelled();
        self.execution.shared.clamp(&planning::bar(&self.prepared), &cancelled)?;
        self.execution.publish(&self.prepared.pages)?;
        self.execution.arm_faults()?;
        let own_s = self.prepared.duration_s();
        let share = PlanShare { done_s: 0.0, own_s, whole_s: own_s };
        let ended = self.execution.execute(hash_of(&self.prepared.pages), share)?;
        self.execution.note(result, ended)?;
        self.measure(result)
    }

    /// The form of the finished part, which goes to subscribers as a map too.
    fn measure(&self, result: &mut RunJobResult) -> Result<(), JobFailure> {
        let shared = &self.execution.shared;
        let part = shared
            .turned_parts
            .wait_finished(&self.prepared.job.spec.name, result.first_tick, MEASURING)
            .map_err(|error| JobFailure::Failed(format!("the job was executed, but {error}")))?;
        let form = planning::turned_form(&self.prepared, &part)
            .map_err(|error| JobFailure::Failed(format!("the form of the part cannot be judged: {error}")))?;
        let frames = camwright_scene::frames_of(&shared.node, &self.prepared.machine)
            .map_err(|error| JobFailure::Failed(error.to_string()))?;
        let map =
            planning::form_map_message(&self.prepared, &form, result.last_tick, frames.part_header(shared.node.now()));
        if let Err(error) = shared.form_map.publish(&map) {
            shared.node.logger().warn(&format!("the form map cannot be published: {error}"));
        }
        let mut turned = planning::turned_result(&self.prepared, &form);
        let ticks = super::lock(&self.execution.times).first_tick(0, result.last_tick);
        turned.duration =
            ticks.map_or_else(|| planning::turning_s(&self.prepared), |ticks| self.execution.seconds(ticks));
        let predicted_s = self.prepared.duration_s();
        result.message = format!(
            "{} passes in {:.2} s, predicted {predicted_s:.2} s ({:+.2} s)",
            turned.passes,
            result.duration,
            result.duration - predicted_s
        );
        result.turned = vec![turned];
        Ok(())
    }
}
