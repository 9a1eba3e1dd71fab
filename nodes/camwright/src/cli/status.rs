//! `camwright status`: what a running cell does, from a second shell.

use super::output::say;
use camwright_operator_page::look;
use camwright_ros::{RosArgs, RosLayer};
use clap::Args;
use std::process::ExitCode;
use std::time::Duration;

/// Arguments of `camwright status`.
#[derive(Debug, Clone, Args)]
pub(super) struct StatusArgs {
    /// Print it as JSON.
    #[arg(long)]
    json: bool,
    /// How long to listen for a machine (s).
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0, value_parser = seconds)]
    patience: f64,
}

fn seconds(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().map_err(|error| error.to_string())?;
    if (0.1..=3600.0).contains(&value) { Ok(value) } else { Err(format!("{value} s, allowed is 0.1 to 3600")) }
}

/// Entry point. Exit 0: a cell without alarms, 1: none is heard, 3: an alarm needs a reset.
pub(super) fn main(args: &StatusArgs, ros_args: &RosArgs) -> ExitCode {
    RosLayer::install();
    let status = match look(ros_args, Duration::from_secs_f64(args.patience)) {
        Ok(status) => status,
        Err(error) => {
            eprintln!("camwright status: {error}");
            return ExitCode::from(1);
        }
    };
    if !status.is_there() {
        eprintln!(
            "camwright status: no machine was heard within {} s; look at ROS_DOMAIN_ID and at the namespace (--ros-args -r __ns:=/NAME)",
            args.patience
        );
        return ExitCode::from(1);
    }
    if args.json {
        match serde_json::to_string_pretty(&status) {
            Ok(text) => tell(&text),
            Err(error) => {
                eprintln!("camwright status: {error}");
                return ExitCode::from(1);
            }
        }
    } else {
        tell(status.to_string().trim_end());
    }
    if status.has_alarms() { ExitCode::from(3) } else { ExitCode::SUCCESS }
}

fn tell(text: &str) {
    say!("{text}");
}
