// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright status`: state of a running cell.

use super::output::{print_error, say, wrapped};
use camwright_operator_page::{Status, StatusListener};
use camwright_ros::running::NodeError;
use camwright_ros::{RosArgs, RosLayer, Shutdown};
use clap::Args;
use std::io::{IsTerminal as _, Write as _};
use std::process::ExitCode;
use std::time::Duration;

/// Time between two refreshes.
const REFRESH: Duration = Duration::from_millis(250);

/// Arguments of `camwright status`.
#[derive(Debug, Clone, Args)]
#[command(after_help = super::help::STATUS)]
pub(super) struct StatusArgs {
    /// Print JSON instead of text; with --watch one object a line.
    #[arg(long)]
    json: bool,
    /// Show every change until Ctrl-C.
    #[arg(long)]
    watch: bool,
    /// Time to wait for a machine (s).
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0, value_parser = seconds)]
    patience: f64,
}

pub(super) fn seconds(text: &str) -> Result<f64, String> {
    let value = super::output::number(text)?;
    if (0.1..=3600.0).contains(&value) { Ok(value) } else { Err(format!("{value} s is outside 0.1 to 3600 s")) }
}

/// Entry point. Exit 0: no alarm, or the end of watching; 1: no cell found; 3: an alarm needs a reset.
pub(super) fn main(args: &StatusArgs, ros_args: &RosArgs) -> ExitCode {
    RosLayer::install();
    show(args, ros_args).unwrap_or_else(|error| {
        print_error("camwright status", &error);
        ExitCode::from(1)
    })
}

fn show(args: &StatusArgs, ros_args: &RosArgs) -> Result<ExitCode, NodeError> {
    let shutdown = Shutdown::on_signals()?;
    let mut listener = StatusListener::start(ros_args)?;
    let status = listener.find(Duration::from_secs_f64(args.patience));
    let code = if !status.has_machine() {
        let message = format!(
            "no machine found within {} s; start a cell (`camwright run --help` shows how), or check ROS_DOMAIN_ID and the namespace (--ros-args -r __ns:=/NAME)",
            args.patience
        );
        print_error("camwright status", &message);
        ExitCode::from(1)
    } else if args.watch {
        // A reader that has closed the pipe ends the watch.
        let _reader_is_gone = watch(args, status, &mut listener, &shutdown);
        ExitCode::SUCCESS
    } else {
        match args.json {
            true => say!("{}", serde_json::to_string_pretty(&status).map_err(NodeError::file)?),
            false => say!("{}", text(&status)),
        }
        if status.has_alarms() { ExitCode::from(3) } else { ExitCode::SUCCESS }
    };
    listener.stop();
    Ok(code)
}

fn text(status: &Status) -> String {
    wrapped(status.to_string().trim_end(), 10)
}

/// Shows the status until Ctrl-C: refreshed in place on a terminal, otherwise a block or a JSON object for each change.
fn watch(
    args: &StatusArgs,
    mut status: Status,
    listener: &mut StatusListener,
    shutdown: &Shutdown,
) -> std::io::Result<()> {
    let mut out = std::io::stdout();
    let in_place = out.is_terminal() && !args.json;
    let mut lines = 0;
    loop {
        if args.json {
            writeln!(out, "{}", serde_json::to_string(&status)?)?;
        } else if in_place {
            // Up to the first line of the text before, and clears from there on.
            let up = if lines == 0 { String::new() } else { format!("\x1b[{lines}A\r\x1b[J") };
            let text = text(&status);
            lines = text.lines().count();
            writeln!(out, "{up}{text}")?;
        } else {
            writeln!(out, "{}\n", text(&status))?;
        }
        out.flush()?;
        loop {
            if shutdown.wait_timeout(REFRESH) {
                return Ok(());
            }
            let next = listener.next(REFRESH);
            if in_place || !next.is_same_state(&status) {
                status = next;
                break;
            }
        }
    }
}
