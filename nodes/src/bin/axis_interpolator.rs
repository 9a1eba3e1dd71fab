//! The node `axis_interpolator` as a process of its own.

use camwright_nodes::axis_interpolator::AxisInterpolator;
use camwright_nodes::running;
use std::process::ExitCode;

fn main() -> ExitCode {
    running::main("axis_interpolator", AxisInterpolator::start, AxisInterpolator::stop)
}
