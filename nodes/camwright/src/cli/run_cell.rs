// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The whole cell in the process of `camwright run`.

use super::pace::PaceArg;
use camwright_axis_interpolator::AxisInterpolator;
use camwright_job_planner::JobPlanner;
use camwright_machine_sim::MachineSim;
use camwright_planning::AnyPrepared;
use camwright_ros::running::NodeError;
use camwright_ros::{Farewell, Lifecycle, NodeLock, ParameterValue, RosArgs, Transition};
use camwright_run_logger::RunLogger;
use std::panic::resume_unwind;
use std::path::Path;
use std::thread::ScopedJoinHandle;

/// Names of the nodes.
pub(super) const NODES: [&str; 4] = ["machine_sim", "axis_interpolator", "job_planner", "run_logger"];

/// The four nodes in this process.
pub(super) struct CellNodes {
    logger: RunLogger,
    machine: MachineSim,
    interpolator: AxisInterpolator,
    planner: JobPlanner,
}

impl CellNodes {
    /// Arguments of the nodes for a machine with `key=value` overrides of its file. Overrides of jobs may name files in `file_folders`.
    pub(super) fn arguments(
        machine: &str,
        overrides: &[String],
        file_folders: Vec<String>,
        pace: PaceArg,
        ros_args: &RosArgs,
        bag: &Path,
    ) -> RosArgs {
        let pace_name = match pace {
            PaceArg::Realtime => "realtime",
            PaceArg::Fast => "fast",
        };
        let text = |text: &str| ParameterValue::String(text.to_owned());
        ros_args
            .clone()
            .with_parameter(None, "autostart", ParameterValue::Bool(false))
            .with_default_parameter(Some("machine_sim"), "machine", text(machine))
            .with_parameter(Some("machine_sim"), "pace", text(pace_name))
            .with_parameter(Some("machine_sim"), "machine_overrides", ParameterValue::StringArray(overrides.to_vec()))
            .with_default_parameter(Some("job_planner"), "file_folders", ParameterValue::StringArray(file_folders))
            .with_parameter(Some("run_logger"), "bag_dir", text(&bag.to_string_lossy()))
            // A bag lasts as long as the machine took, not as long as the computer did.
            .with_parameter(Some("run_logger"), "use_sim_time", ParameterValue::Bool(pace == PaceArg::Fast))
    }

    /// Takes the names of the nodes, so that no other process of this host starts them.
    pub(super) fn lock(args: &RosArgs) -> Result<[NodeLock; 4], NodeError> {
        let [machine, interpolator, planner, logger] = NODES.map(|node| NodeLock::acquire(node, args));
        Ok([machine?, interpolator?, planner?, logger?])
    }

    /// Risk of an underrun on this computer.
    pub(super) fn underrun_risk(&self) -> Option<String> {
        self.machine.underrun_risk()
    }

    /// Starts the nodes, the planner with the plan that it needs first.
    pub(super) fn start(args: &RosArgs, planned: AnyPrepared) -> Result<Self, NodeError> {
        let cell = std::thread::scope(|scope| {
            let logger = scope.spawn(|| RunLogger::start(args));
            let machine = scope.spawn(|| MachineSim::start(args));
            let interpolator = scope.spawn(|| AxisInterpolator::start(args));
            let planner = scope.spawn(|| JobPlanner::start_with_plan(args, Some(planned)));
            // All threads end before the first error is returned.
            let (logger, machine) = (joined(logger), joined(machine));
            let (interpolator, planner) = (joined(interpolator), joined(planner));
            Ok::<_, NodeError>(Self {
                logger: logger?,
                machine: machine?,
                interpolator: interpolator?,
                planner: planner?,
            })
        })?;
        // Recorder first, so that the bag begins before anything happens; then from the axes upwards.
        for lifecycle in cell.lifecycles() {
            lifecycle.trigger(Transition::Configure)?;
            lifecycle.trigger(Transition::Activate)?;
        }
        Ok(cell)
    }

    fn lifecycles(&self) -> [&Lifecycle; 4] {
        [self.logger.lifecycle(), self.machine.lifecycle(), self.interpolator.lifecycle(), self.planner.lifecycle()]
    }

    /// Ends the cell from the top down, the recorder last: its bag is closed. The nodes leave the graph until the result is dropped.
    pub(super) fn stop(self) -> [Farewell; 4] {
        [self.planner.stop(), self.interpolator.stop(), self.machine.stop(), self.logger.close().1]
    }
}

fn joined<T>(thread: ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| resume_unwind(panic))
}
