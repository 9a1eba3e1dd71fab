//! The node `job_planner` as a process of its own.

use camwright_nodes::job_planner::JobPlanner;
use camwright_nodes::running;
use std::process::ExitCode;

fn main() -> ExitCode {
    running::main("job_planner", JobPlanner::start, JobPlanner::stop)
}
