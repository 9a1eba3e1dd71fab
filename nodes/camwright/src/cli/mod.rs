// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The command line of `camwright`, see `docs/reference/command_line.md`.

pub mod bag;

mod bag_room;
mod batch;
mod chatter;
mod check;
mod check_machine;
mod check_parameters;
mod completions;
#[cfg(test)]
mod documents;
mod drives;
mod fleet;
mod gateway;
mod hal;
mod help;
mod init;
mod learn;
mod list;
mod machine_text;
mod operate;
mod output;
mod pace;
mod page;
mod plan;
mod plan_turned;
mod post;
mod replan;
mod replay;
mod run;
mod run_cell;
mod run_client;
mod run_part;
mod run_progress;
mod run_report;
mod schema;
mod setup;
mod status;
mod study;
mod trace;
mod turned_report;
mod urdf;

use camwright_ros::{RosArgs, Shutdown};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use output::{OutputArgs, print_error};
use std::process::ExitCode;

/// Plan, simulate, record and replay the grinding and turning of parts that are not round.
///
/// Without a command the default job runs.
#[derive(Debug, Parser)]
#[command(name = "camwright", version, max_term_width = 80, after_help = help::CAMWRIGHT)]
struct Cli {
    #[command(flatten)]
    output: OutputArgs,
    #[command(subcommand)]
    command: Option<CommandLine>,
}

#[derive(Debug, Subcommand)]
enum CommandLine {
    /// Run a job on the whole cell and record a bag.
    Run(run::RunArgs),
    /// Plan a job without ROS and write its paths.
    Plan(plan::PlanArgs),
    /// Show where a commanded position comes from: table rows, limits, infeed.
    Trace(trace::TraceArgs),
    /// Correct the next part by the reports of a measuring machine.
    Learn(learn::LearnArgs),
    /// Run the cases of a study without ROS and find the best one.
    Study(study::StudyArgs),
    /// Write the NC program of a job and verify it.
    Post(post::PostArgs),
    /// Write a commented job, machine or study file to start from.
    Init(init::InitArgs),
    /// List jobs, machines, studies, lift tables, faults, topics or alarms.
    List(list::ListArgs),
    /// Check a job, a machine, a study, a lift table or a parameter file.
    Check(check::CheckArgs),
    /// Print the JSON Schema of job, machine and study files.
    Schema(schema::SchemaArgs),
    /// Check a running machine against the machine contract.
    CheckMachine(check_machine::CheckMachineArgs),
    /// Find the drive gains that a turned part needs.
    Drives(drives::DrivesArgs),
    /// Forecast chatter: waves that grow, stable work speeds, a varying speed.
    Chatter(chatter::ChatterArgs),
    #[command(flatten)]
    Operate(operate::OperateCommand),
    /// Set up a running cell: move, probe, dress, change wheels, touch off.
    Setup(setup::SetupArgs),
    /// Serve the operator page of a running cell.
    Page(page::PageArgs),
    /// Serve a running cell over MTConnect and OPC UA; read-only.
    Gateway(gateway::GatewayArgs),
    /// Show the state of a running cell.
    Status(status::StatusArgs),
    /// List, start and stop all cells of one or more domains.
    Fleet(fleet::FleetArgs),
    /// Print the URDF of a machine.
    Urdf(urdf::UrdfArgs),
    /// Print the HAL file of a machine whose drives LinuxCNC's HAL moves
    Hal(hal::HalArgs),
    /// Inspect, check, repair or export a bag.
    Bag(bag::BagArgs),
    /// Play a bag to the ROS graph, or recompute its run and compare.
    Replay(replay::ReplayCommand),
    /// Plan the recorded jobs of bags again and list differences.
    Replan(replan::ReplanArgs),
    /// Print the completions of a shell.
    Completions(completions::CompletionsArgs),
    /// Write the man pages of all commands.
    Man(completions::ManArgs),
}

/// Parses a command line; ends the process on help, version or an error.
fn parse(words: Vec<String>) -> Cli {
    let matches = Cli::command().color(output::color_choice(&words)).get_matches_from(words);
    Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
}

/// Command of a command line, and its output; without a command `run` with its defaults.
fn command_of(words: Vec<String>) -> (OutputArgs, Option<CommandLine>) {
    let Cli { output, command } = parse(words);
    (output, command.or_else(|| parse(vec!["camwright".into(), "run".into()]).command))
}

/// Entry point of the binary.
#[must_use]
pub fn main() -> ExitCode {
    let (ros_args, rest) = match RosArgs::from_env() {
        Ok(parsed) => parsed,
        Err(error) => {
            print_error("camwright", &error);
            return ExitCode::from(2);
        }
    };
    let (output, command) = command_of(std::iter::once("camwright".to_owned()).chain(rest).collect());
    output::apply(output);
    let Some(command) = command else { return ExitCode::from(2) };
    let code = match command {
        CommandLine::Run(args) => run::main(&args, &ros_args),
        CommandLine::Plan(args) => plan::main(&args),
        CommandLine::Trace(args) => trace::main(&args),
        CommandLine::Learn(args) => learn::main(&args),
        CommandLine::Study(args) => study::main(&args),
        CommandLine::Post(args) => post::main(&args),
        CommandLine::Init(args) => init::main(&args),
        CommandLine::List(args) => list::main(&args),
        CommandLine::Check(args) => check::main(&args),
        CommandLine::Schema(args) => schema::main(&args),
        CommandLine::CheckMachine(args) => check_machine::main(&args, &ros_args),
        CommandLine::Drives(args) => drives::main(&args),
        CommandLine::Chatter(args) => chatter::main(&args),
        CommandLine::Operate(command) => operate::main(&command, &ros_args),
        CommandLine::Setup(args) => setup::main(&args, &ros_args),
        CommandLine::Page(args) => page::main(&args, &ros_args),
        CommandLine::Gateway(args) => gateway::main(&args, &ros_args),
        CommandLine::Status(args) => status::main(&args, &ros_args),
        CommandLine::Fleet(args) => fleet::main(&args, &ros_args),
        CommandLine::Urdf(args) => urdf::main(&args),
        CommandLine::Hal(args) => hal::main(&args),
        CommandLine::Bag(args) => bag::run(&args),
        CommandLine::Replay(args) => replay::main(&args, &ros_args),
        CommandLine::Replan(args) => replan::main(&args),
        CommandLine::Completions(args) => completions::completions(&args),
        CommandLine::Man(args) => completions::man(&args),
    };
    Shutdown::exit_code(code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_command_the_defaults_are_those_of_run() {
        let words = |words: &[&str]| command_of(words.iter().map(ToString::to_string).collect()).1;
        let Some(CommandLine::Run(bare)) = words(&["camwright"]) else { panic!("it runs") };
        let Some(CommandLine::Run(run)) = words(&["camwright", "run"]) else { panic!("it runs") };
        assert_eq!(bare.parts, 1);
        assert_eq!(format!("{bare:?}"), format!("{run:?}"));
    }
}
