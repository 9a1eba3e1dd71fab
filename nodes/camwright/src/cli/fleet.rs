// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright fleet`: state, start and stop of all cells of one or more domains.

use super::output::{JsonArg, note, print_error, say, wrapped};
use super::run::from_here;
use super::run_client::CellClient;
use super::status::seconds;
use camwright_authority::{HeldCommand, TakeOptions};
use camwright_operator_page::operation::Answer;
use camwright_operator_page::{FleetCell, FleetListener};
use camwright_ros::running::NodeError;
use camwright_ros::{Level, RosArgs, RosLayer, Shutdown};
use clap::{Args, Subcommand};
use serde_json::json;
use std::fmt::{Display, Write as _};
use std::io::{IsTerminal as _, Write as _};
use std::ops::RangeInclusive;
use std::process::ExitCode;
use std::time::Duration;

/// Time between two looks at the cells.
const REFRESH: Duration = Duration::from_millis(500);
/// Exit code: a cell has an alarm, or did not start or stop.
const REFUSED: u8 = 3;
/// Exit code: a cell does not answer.
const UNREACHABLE: u8 = 4;

/// Arguments of `camwright fleet`.
#[derive(Debug, Clone, Args)]
#[command(after_help = super::help::FLEET)]
pub(super) struct FleetArgs {
    #[command(subcommand)]
    command: FleetCommand,
}

#[derive(Debug, Clone, Subcommand)]
enum FleetCommand {
    /// List all cells: state, job, progress, pace, alarms.
    #[command(after_help = super::help::FLEET_STATUS)]
    Status {
        #[command(flatten)]
        cells: CellArgs,
        /// List the cells after every change until Ctrl-C; with --json an array a line.
        #[arg(long)]
        watch: bool,
        #[command(flatten)]
        output: JsonArg,
    },
    /// Start a job in every idle cell.
    #[command(after_help = super::help::FLEET_START)]
    Start {
        /// Name or path of the job.
        job: String,
        /// Set a key of the job, such as `infeed.total_mm=0.72`; repeatable.
        #[arg(long = "set", value_name = "KEY=VALUE")]
        set: Vec<String>,
        #[command(flatten)]
        cells: CellArgs,
        #[command(flatten)]
        output: JsonArg,
    },
    /// Cancel the jobs and motions of all cells.
    #[command(after_help = super::help::FLEET_STOP)]
    Stop {
        #[command(flatten)]
        cells: CellArgs,
        #[command(flatten)]
        output: JsonArg,
    },
}

/// Cells that a command acts on.
#[derive(Debug, Clone, Args)]
struct CellArgs {
    /// Namespace of a cell; repeatable [default: all cells found].
    #[arg(long = "cell", value_name = "NAME")]
    names: Vec<String>,
    /// ROS domains of the cells, such as `7` or `11-30`; repeatable [default: `ROS_DOMAIN_ID`].
    #[arg(long = "domain", value_name = "ID", value_parser = domains)]
    domains: Vec<RangeInclusive<u16>>,
    /// Time to wait for cells (s).
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0, value_parser = seconds)]
    patience: f64,
}

impl CellArgs {
    /// Finds the cells. Prints those that were named and not found, or that there is none.
    fn find(&self, ros_args: &RosArgs) -> Result<FleetListener, NodeError> {
        // Several nodes in one process; their logs concern the cells.
        let ros_args = ros_args.clone().with_console_level(Level::Error);
        let domains: Vec<u16> = self.domains.iter().cloned().flatten().collect();
        let mut fleet = FleetListener::start(&ros_args, &domains, &self.names)?;
        fleet.find(Duration::from_secs_f64(self.patience))?;
        for cell in fleet.missing() {
            let message = format!("no cell {cell} found within {} s; start it, or check its namespace", self.patience);
            print_error("camwright fleet", &message);
        }
        for domain in empty_domains(&fleet) {
            print_error("camwright fleet", &format!("no cell found in domain {domain} within {} s", self.patience));
        }
        if fleet.is_empty() && self.names.is_empty() {
            let message = format!(
                "no cell found within {} s; start cells (`camwright run --help` shows how), or check the domain (ROS_DOMAIN_ID or --domain) and, for cells on other hosts, ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET",
                self.patience
            );
            print_error("camwright fleet", &message);
        }
        Ok(fleet)
    }
}

/// Domain, or first and last domain.
fn domains(text: &str) -> Result<RangeInclusive<u16>, String> {
    let id = |text: &str| match text.trim().parse::<u16>() {
        Ok(id) if id <= RosArgs::LAST_DOMAIN => Ok(id),
        _ => Err(format!("`{text}` is not a domain id from 0 to {}", RosArgs::LAST_DOMAIN)),
    };
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let range = id(first)?..=id(last)?;
    if range.is_empty() { Err(format!("domain {first} is after domain {last}")) } else { Ok(range) }
}

/// Domains without a cell beside domains with cells.
fn empty_domains(fleet: &FleetListener) -> Vec<u16> {
    if fleet.is_empty() { Vec::new() } else { fleet.empty_domains() }
}

/// Number of cells that were asked for and do not answer.
fn missing(fleet: &FleetListener) -> usize {
    fleet.missing().len() + empty_domains(fleet).len()
}

/// Entry point. Exit 0: done; 1: no cell found; 3: alarms, or a cell refuses; 4: a cell does not answer.
pub(super) fn main(args: &FleetArgs, ros_args: &RosArgs) -> ExitCode {
    RosLayer::install();
    let code = match &args.command {
        FleetCommand::Status { cells, watch, output } => status(cells, *watch, output.json, ros_args),
        FleetCommand::Start { job, set, cells, output } => start(job, set, cells, output.json, ros_args),
        FleetCommand::Stop { cells, output } => stop(cells, output.json, ros_args),
    };
    ExitCode::from(code.unwrap_or_else(|error| {
        print_error("camwright fleet", &error);
        1
    }))
}

fn status(args: &CellArgs, watches: bool, is_json: bool, ros_args: &RosArgs) -> Result<u8, NodeError> {
    let shutdown = Shutdown::on_signals()?;
    let mut fleet = args.find(ros_args)?;
    let cells = fleet.cells();
    let code = status_code(&cells, missing(&fleet));
    if watches {
        watch(&mut fleet, cells, is_json, &shutdown)?;
        fleet.stop();
        return Ok(0);
    }
    if is_json {
        say!("{}", serde_json::to_string_pretty(&cells).map_err(NodeError::file)?);
    } else if !cells.is_empty() {
        say!("{}", table(&cells));
    }
    fleet.stop();
    Ok(code)
}

fn status_code(cells: &[FleetCell], missing: usize) -> u8 {
    match cells {
        _ if missing > 0 || cells.iter().any(|cell| !cell.is_reachable) => UNREACHABLE,
        [] => 1,
        _ if cells.iter().any(FleetCell::has_alarms) => REFUSED,
        _ => 0,
    }
}

/// Lists the cells after every change until Ctrl-C, or until the reader has closed the pipe.
fn watch(
    fleet: &mut FleetListener,
    mut cells: Vec<FleetCell>,
    is_json: bool,
    shutdown: &Shutdown,
) -> Result<(), NodeError> {
    let mut out = std::io::stdout();
    let in_place = out.is_terminal() && !is_json;
    let mut lines = 0;
    loop {
        let text = if is_json { serde_json::to_string(&cells).map_err(NodeError::file)? } else { table(&cells) };
        // Up to the first line of the table before, and clears from there on.
        let up = if in_place && lines > 0 { format!("\x1b[{lines}A\r\x1b[J") } else { String::new() };
        lines = text.lines().count();
        let end = if in_place || is_json { "" } else { "\n" };
        if writeln!(out, "{up}{text}{end}").and_then(|()| out.flush()).is_err() {
            return Ok(());
        }
        loop {
            if shutdown.wait_timeout(REFRESH) {
                return Ok(());
            }
            fleet.add_new()?;
            let next = fleet.cells();
            let is_same = |(old, new): (&FleetCell, &FleetCell)| old.is_same_state(new);
            if next.len() != cells.len() || !cells.iter().zip(&next).all(is_same) {
                cells = next;
                break;
            }
        }
    }
}

/// Column of the domain, where the cells are in several ones.
fn domain_column(cells: &[FleetCell], text: &dyn Display) -> String {
    let is_one_domain = cells.windows(2).all(|pair| pair[0].domain == pair[1].domain);
    if is_one_domain { String::new() } else { format!("{text:>6}  ") }
}

/// A line for each cell, and one for each alarm.
fn table(cells: &[FleetCell]) -> String {
    let job = |cell: &FleetCell| cell.job().map_or_else(|| "-".to_owned(), |(name, _)| name.to_owned());
    let width = |title: &str, values: Vec<usize>| values.into_iter().chain([title.len()]).max().unwrap_or_default();
    let cell_width = width("cell", cells.iter().map(|cell| cell.cell.chars().count()).collect());
    let state_width = width("state", cells.iter().map(|cell| cell.word().chars().count()).collect());
    let job_width = width("job", cells.iter().map(|cell| job(cell).chars().count()).collect());
    let heading = domain_column(cells, &"domain");
    let mut text =
        format!("{heading}{:cell_width$}  {:state_width$}  {:job_width$}  done   pace", "cell", "state", "job");
    for cell in cells {
        let (name, word, pace) = (&cell.cell, cell.word(), cell.pace().unwrap_or("-"));
        let done = cell.job().map_or_else(|| "    -".to_owned(), |(_, percent)| format!("{percent:3.0} %"));
        let job = job(cell);
        let domain = domain_column(cells, &cell.domain);
        let _infallible =
            write!(text, "\n{domain}{name:cell_width$}  {word:state_width$}  {job:job_width$}  {done}  {pace}");
        if !cell.is_reachable {
            let _infallible = write!(text, "\n{}", wrapped(&format!("  {}", cell.detail()), 4));
        }
        for (number, alarm) in cell.alarms() {
            let _infallible = write!(text, "\n{}", wrapped(&format!("  alarm {number}: {alarm}"), 4));
        }
    }
    text
}

fn start(job: &str, set: &[String], args: &CellArgs, is_json: bool, ros_args: &RosArgs) -> Result<u8, NodeError> {
    let shutdown = Shutdown::on_signals()?;
    let fleet = args.find(ros_args)?;
    let cells = fleet.cells();
    // The nodes of a cell have another folder.
    let job = from_here(job.to_owned());
    let answers = fleet.for_each(&cells, |cell, args| match cell.is_idle {
        true => start_in(args, &job, set, &shutdown).map_or_else(
            |error| Answer { done: false, message: error.to_string() },
            |()| Answer { done: true, message: format!("job {job} accepted") },
        ),
        false => Answer { done: false, message: format!("not idle: {} {}", cell.word(), cell.detail()) },
    });
    let code = report(&cells, &answers, missing(&fleet), is_json)?;
    fleet.stop();
    Ok(code)
}

/// Starts a job in the cell of these arguments; it goes on without this client.
fn start_in(args: &RosArgs, job: &str, set: &[String], shutdown: &Shutdown) -> Result<(), NodeError> {
    let client = CellClient::new(args)?;
    client.meet(None, shutdown)?;
    let options = TakeOptions::new("camwright fleet").for_cell();
    let command =
        HeldCommand::acquire(&client.node, &options).map_err(|error| NodeError::Parameter(error.to_string()))?;
    let accepted = client.send_job(job, set, drop);
    drop(command);
    drop(client.node.leave());
    accepted.map(drop)
}

fn stop(args: &CellArgs, is_json: bool, ros_args: &RosArgs) -> Result<u8, NodeError> {
    let fleet = args.find(ros_args)?;
    let cells = fleet.cells();
    let answers = fleet.cancel(&cells)?;
    let code = report(&cells, &answers, missing(&fleet), is_json)?;
    fleet.stop();
    Ok(code)
}

/// Prints the answer of each cell; returns the exit code.
fn report(cells: &[FleetCell], answers: &[Answer], missing: usize, is_json: bool) -> Result<u8, NodeError> {
    let answered = || cells.iter().zip(answers);
    if is_json {
        let lines: Vec<_> = answered()
            .map(|(cell, answer)| json!({ "domain": cell.domain, "cell": cell.cell, "done": answer.done, "message": answer.message }))
            .collect();
        say!("{}", serde_json::to_string_pretty(&lines).map_err(NodeError::file)?);
    } else {
        let width = cells.iter().map(|cell| cell.cell.chars().count()).max().unwrap_or_default();
        for (cell, answer) in answered() {
            let verdict = if answer.done { "done" } else { "REFUSED" };
            let domain = domain_column(cells, &cell.domain);
            let line = format!("{domain}{:width$}  {verdict:7}  {}", cell.cell, answer.message);
            say!("{}", wrapped(&line, domain.len() + width + 11));
        }
    }
    if answers.iter().any(|answer| !answer.done) {
        note!("camwright fleet status shows the state of all cells");
    }
    Ok(match answers {
        _ if missing > 0 || cells.iter().any(|cell| !cell.is_reachable) => UNREACHABLE,
        [] => 1,
        _ if answers.iter().any(|answer| !answer.done) => REFUSED,
        _ => 0,
    })
}
