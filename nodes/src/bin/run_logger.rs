//! The recorder as a process of its own: `run_logger [--ros-args …]`.

use std::io::Write as _;
use std::process::ExitCode;

use camwright_nodes::ros::{RosArgs, RosLayer, Shutdown};
use camwright_nodes::run_logger::RunLogger;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Before the node is there, nobody but the console can be told; a closed one is no reason to panic.
            let _ = writeln!(std::io::stderr(), "run_logger: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn std::error::Error>> {
    RosLayer::install();
    let (args, rest) = RosArgs::from_env()?;
    if let Some(word) = rest.first() {
        return Err(format!("'{word}' is not understood; arguments of ROS follow --ros-args").into());
    }
    let shutdown = Shutdown::on_signals()?;
    RunLogger::new(&args)?.run(&shutdown)?;
    Ok(())
}
