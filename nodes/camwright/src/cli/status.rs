//! `camwright status`: state of a running cell.

use super::output::{print_error, say, wrapped};
use camwright_operator_page::look;
use camwright_ros::{RosArgs, RosLayer};
use clap::Args;
use std::process::ExitCode;
use std::time::Duration;

/// Arguments of `camwright status`.
#[derive(Debug, Clone, Args)]
#[command(after_help = super::help::STATUS)]
pub(super) struct StatusArgs {
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
    /// Time to wait for a machine (s).
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0, value_parser = seconds)]
    patience: f64,
}

fn seconds(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().map_err(|error| error.to_string())?;
    if (0.1..=3600.0).contains(&value) { Ok(value) } else { Err(format!("{value} s is outside 0.1 to 3600 s")) }
}

/// Entry point. Exit 0: no alarm; 1: no cell found; 3: an alarm needs a reset.
pub(super) fn main(args: &StatusArgs, ros_args: &RosArgs) -> ExitCode {
    RosLayer::install();
    let status = match look(ros_args, Duration::from_secs_f64(args.patience)) {
        Ok(status) => status,
        Err(error) => {
            print_error("camwright status", &error);
            return ExitCode::from(1);
        }
    };
    if !status.is_there() {
        let message = format!(
            "no machine found within {} s; check ROS_DOMAIN_ID and the namespace (--ros-args -r __ns:=/NAME)",
            args.patience
        );
        print_error("camwright status", &message);
        return ExitCode::from(1);
    }
    if args.json {
        match serde_json::to_string_pretty(&status) {
            Ok(text) => print(&text),
            Err(error) => {
                print_error("camwright status", &error);
                return ExitCode::from(1);
            }
        }
    } else {
        print(&wrapped(status.to_string().trim_end(), 10));
    }
    if status.has_alarms() { ExitCode::from(3) } else { ExitCode::SUCCESS }
}

fn print(text: &str) {
    say!("{text}");
}
