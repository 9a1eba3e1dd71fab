// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Gauge measurements of a running job: the stock of its journals, the stiffness at them, and the correction of their runout.

use super::execution::JobFailure;
use super::grinding_run::GrindingRun;
use super::lock;
use camwright::gauging::journal::LOG_ENDS_RAD;
use camwright::planner::{JournalReadings, rests_rad};
use camwright_msgs::camwright_msgs::action::RunJobResult;
use camwright_planning::{self as planning, MeasuredContacts, PreparedCorrection};
use std::time::Duration;

/// Maximum delay of readings.
const READING: Duration = Duration::from_secs(20);

impl GrindingRun {
    /// Measures the stock, and plans the job anew for it.
    pub(super) fn measure_stock(&mut self, result: &mut RunJobResult) -> Result<(), JobFailure> {
        let Some(measuring) = self.prepared.measuring.clone() else { return Ok(()) };
        self.execution.publish(&measuring.pages)?;
        self.execution.arm_faults()?;
        self.listen();
        let measuring_s = self.prepared.measuring_s();
        self.execute(result, measuring.plan_hash(), 0.0, measuring_s)?;
        let logs = self.logs(&measuring.planned.read_to_rad, "turn under it")?;
        let stock = planning::for_stock(&self.prepared, &logs)
            .map_err(|error| JobFailure::Failed(format!("{error}; the wheel has not left its home position")))?;
        for lines in stock.lines.iter().chain([&stock.saved]) {
            self.execution.shared.node.logger().info(lines);
        }
        (self.prepared, self.saved) = (stock.prepared, Some(stock.saved));
        lock(&self.execution.times).next_half();
        Ok(())
    }

    /// Listens to the gauge where the job needs it.
    pub(super) fn listen(&self) {
        let spec = &self.prepared.job.spec;
        let listens = (spec.correction.is_some() || spec.measure_stock.is_some()) && spec.dry_run_mm.is_none();
        match self.prepared.machine.gauge.filter(|_| listens) {
            Some(gauge) => self.execution.shared.gaugings.listen(gauge.behind_wheel_rad, gauge.second_behind_wheel_rad),
            None => self.execution.shared.gaugings.stop(),
        }
    }

    /// Readings of every lobe up to these angles of C (rad); `of` names the phase for errors.
    fn logs(&self, until_rad: &[f64], of: &str) -> Result<Vec<JournalReadings>, JobFailure> {
        let names = self.prepared.planned.lobes.iter().map(|lobe| lobe.design.name.as_str());
        let wanted: Vec<(&str, f64)> = names.zip(until_rad.iter().copied()).collect();
        let logs = self.execution.shared.gaugings.wait(&wanted, READING).map_err(|missing| {
            JobFailure::Failed(format!(
                "the gauge did not read lobe {missing} to the end of its {of}; the wheel is clear of the part"
            ))
        })?;
        self.execution.shared.gaugings.stop();
        Ok(logs)
    }

    /// Readings of every lobe during grinding.
    fn ground_logs(&self) -> Result<Vec<JournalReadings>, JobFailure> {
        let rests = rests_rad(&self.prepared.planned, &self.prepared.machine);
        let until_rad: Vec<f64> = rests.iter().map(|rest_rad| rest_rad - LOG_ENDS_RAD).collect();
        self.logs(&until_rad, "dwell")
    }

    /// Measures the stiffness of a job that does no more with it.
    pub(super) fn identify(&mut self) -> Result<MeasuredContacts, JobFailure> {
        let logs = self.ground_logs()?;
        let measured = planning::measured_contacts(&self.prepared, &logs)
            .map_err(|error| JobFailure::Failed(format!("{error}; the wheel is clear of the part")))?;
        measured.summary_lines(&self.prepared).iter().for_each(|lines| self.execution.shared.node.logger().info(lines));
        self.store(&measured);
        Ok(measured)
    }

    /// Stores the measured stiffness of the machine. A failure to store it is reported; the measurement stays valid.
    fn store(&mut self, measured: &MeasuredContacts) {
        if measured.contacts.iter().all(Option::is_none) {
            return;
        }
        let logger = self.execution.shared.node.logger();
        match self.execution.shared.stiffness.store(&self.prepared, measured) {
            Ok(kept) => {
                logger.info(&format!(
                    "the stiffness at {} journals is kept for {}",
                    kept.len(),
                    self.prepared.machine.name
                ));
                self.stiffness = kept;
            }
            Err(error) => logger.error(&format!("the measured stiffness cannot be stored: {error}")),
        }
    }

    /// Decides from what the gauge read how the second half goes.
    pub(super) fn correct(&mut self) -> Result<PreparedCorrection, JobFailure> {
        if let Some(dry) = self.prepared.dry_correction() {
            return Ok(dry);
        }
        let logs = self.ground_logs()?;
        let correction = planning::correct(&self.prepared, &logs)
            .map_err(|error| JobFailure::Failed(format!("{error}; the wheel is clear of the part")))?;
        for lines in correction.summary_lines(&self.prepared) {
            self.execution.shared.node.logger().info(&lines);
        }
        self.store(&correction.measured);
        self.execution.shared.node.logger().info(&format!(
            "second half: {:.2} s, plan {:.12}",
            correction.planned.plan.duration_s,
            correction.plan_hash()
        ));
        Ok(correction)
    }
}
