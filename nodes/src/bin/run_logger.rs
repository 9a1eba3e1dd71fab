//! The node `run_logger` as a process of its own.

use camwright_nodes::run_logger::RunLogger;
use camwright_nodes::running;
use std::process::ExitCode;

fn main() -> ExitCode {
    running::main("run_logger", running::CLOSING, RunLogger::start, RunLogger::stop)
}
