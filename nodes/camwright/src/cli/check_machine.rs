// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright check-machine`: checks a machine against the machine contract.

use super::output::{note, print_error, say};
use camwright::machine::description::Axis;
use camwright_files::convert::si_from_file;
use camwright_machine_check::{CheckError, ClauseVerdict, Moving, Settings, check};
use camwright_ros::{RosArgs, RosLayer, Shutdown};
use clap::Args;
use std::process::ExitCode;
use std::time::Duration;

/// Arguments of `camwright check-machine`.
///
/// Each clause of `nodes/MACHINE_CONTRACT.md` is reported as kept, broken (value, limit, tick) or not seen (reason, how to see it). Without
/// --move the check only listens and resets a machine that rests without an alarm. With --move it takes command, moves one axis forth and
/// back, stops sending, sends invalid setpoints, triggers machine/estop and alarms, and resets them: stay beside the machine. It does not
/// start while another client has command, an axis moves or an alarm is active. Ctrl-C stops it on the path.
#[derive(Debug, Clone, Args)]
#[command(after_help = super::help::CHECK_MACHINE)]
pub(super) struct CheckMachineArgs {
    /// Namespace of the cell.
    #[arg(long, value_name = "/CELL")]
    namespace: Option<String>,
    /// Joint to move, for example `z_axis`.
    #[arg(long = "move", value_name = "JOINT", requires = "distance", value_parser = joint)]
    joint: Option<Axis>,
    /// Distance to move forth and back (mm, deg).
    #[arg(long, value_name = "MM|DEG", allow_hyphen_values = true, requires = "joint", value_parser = distance)]
    distance: Option<f64>,
    /// Time to listen before the first test (s).
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0, value_parser = seconds)]
    seconds: f64,
    /// Time to wait for a machine (s).
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = seconds)]
    patience: f64,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

fn joint(text: &str) -> Result<Axis, String> {
    Axis::from_joint(text).ok_or_else(|| format!("unknown joint {text:?}; joints are c_axis, x_axis and z_axis"))
}

fn distance(text: &str) -> Result<f64, String> {
    let value = super::output::number(text)?;
    if value != 0.0 && value.abs() <= 1000.0 {
        Ok(value)
    } else {
        Err(format!("{value} is outside -1000 to 1000, or 0"))
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let value = super::output::number(text)?;
    if (0.1..=600.0).contains(&value) { Ok(value) } else { Err(format!("{value} s is outside 0.1 to 600 s")) }
}

/// Entry point.
pub(super) fn main(args: &CheckMachineArgs, ros_args: &RosArgs) -> ExitCode {
    RosLayer::install();
    let ros_args = args.namespace.iter().fold(ros_args.clone(), |ros_args, name| ros_args.with_namespace(name));
    let moving = args.joint.zip(args.distance);
    let settings = Settings {
        listen: Duration::from_secs_f64(args.seconds),
        patience: Duration::from_secs_f64(args.patience),
        moving: moving.map(|(axis, by)| Moving { joint: axis.joint().to_owned(), distance: si_from_file(axis, by) }),
    };
    let outcome = Shutdown::on_signals()
        .map_err(|error| CheckError::Node(error.into()))
        .and_then(|shutdown| check(&ros_args, &settings, &shutdown, &|what| note!("camwright check-machine: {what}")));
    let checked = match outcome {
        Ok(checked) => checked,
        Err(error) => {
            print_error("camwright check-machine", &error);
            return ExitCode::from(if matches!(error, CheckError::Refused(_)) { 4 } else { 3 });
        }
    };
    if args.json {
        print(&format!("{:#}", checked.report.json()));
    } else {
        print(&checked.report.to_string());
    }
    match (checked.interrupted, checked.report.clauses(ClauseVerdict::Broken).is_empty()) {
        (true, _) => ExitCode::from(130),
        (false, true) => ExitCode::SUCCESS,
        (false, false) => ExitCode::from(1),
    }
}

fn print(text: &str) {
    say!("{text}");
}
