//! The command line of `camwright`, see `docs/reference/command_line.md`.

pub mod bag;

mod bag_room;
mod batch;
mod check;
mod check_machine;
mod drives;
mod output;
mod pace;
mod page;
mod plan;
mod plan_turned;
mod post;
mod replay;
mod run;
mod run_cell;
mod run_client;
mod run_report;
mod schema;
mod setup;
mod status;
mod turned_report;
mod urdf;

use camwright_ros::{RosArgs, Shutdown};
use clap::{Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;

/// Grinds parts that are not round: plans, runs, records and replays jobs of a simulated cam grinding cell over ROS 2.
///
/// Without a command it runs the default job. `--ros-args …` is understood everywhere: remaps, __ns, -p, --params-file.
#[derive(Debug, Parser)]
#[command(name = "camwright", version, max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    command: Option<CommandLine>,
}

#[derive(Debug, Subcommand)]
enum CommandLine {
    /// Run a job on the whole cell, in this process, and leave a bag.
    Run(run::RunArgs),
    /// Plan a job without ROS and write contour, tool path and speed plan of every lobe, or the insert's path of every pass.
    Plan(plan::PlanArgs),
    /// Make the NC program of a job, for a machine whose control reads G code, and read it back.
    Post(post::PostArgs),
    /// Check a job or a lift table: every finding with file, line, value and bound.
    Check(check::CheckArgs),
    /// Print the JSON Schema of job and machine files.
    Schema(schema::SchemaArgs),
    /// Check a machine against its contract, clause by clause: a drive, a bridge, or the simulated machine.
    CheckMachine(check_machine::CheckMachineArgs),
    /// Tell what the drives of a lathe leave on a part, and what they would have to be.
    Drives(drives::DrivesArgs),
    /// Set a running cell up: jog, probe, dress, touch off, find the part's phase.
    Setup(setup::SetupArgs),
    /// Serve the operator page of a running cell.
    Page(page::PageArgs),
    /// Tell what a running cell does: state, job, axes, who has command, alarms, recorder.
    Status(status::StatusArgs),
    /// Print the URDF of a machine.
    Urdf(urdf::UrdfArgs),
    /// Look into a bag.
    Bag(bag::BagArgs),
    /// Play a bag to the ROS graph, or compute its run again and compare.
    Replay(replay::ReplayCommand),
    /// Plan the jobs of bags again with this program, and list what moved and by how much.
    Replan(camwright_analysis::replan::ReplanArgs),
}

/// The command of a command line: without one the default job is run, with the defaults of `run`.
fn command_of(words: impl Iterator<Item = String>) -> Option<CommandLine> {
    Cli::parse_from(words).command.or_else(|| Cli::parse_from(["camwright", "run"]).command)
}

/// Entry point of the binary.
#[must_use]
pub fn main() -> ExitCode {
    let (ros_args, rest) = match RosArgs::from_env() {
        Ok(parsed) => parsed,
        Err(error) => {
            // A reader that went away is no failure of ours.
            let _ = writeln!(std::io::stderr(), "camwright: {error}");
            return ExitCode::from(2);
        }
    };
    let Some(command) = command_of(std::iter::once("camwright".to_owned()).chain(rest)) else {
        return ExitCode::from(2);
    };
    let code = match command {
        CommandLine::Run(args) => run::main(&args, &ros_args),
        CommandLine::Plan(args) => plan::main(&args),
        CommandLine::Post(args) => post::main(&args),
        CommandLine::Check(args) => check::main(&args),
        CommandLine::Schema(args) => schema::main(&args),
        CommandLine::CheckMachine(args) => check_machine::main(&args, &ros_args),
        CommandLine::Drives(args) => drives::main(&args),
        CommandLine::Setup(args) => setup::main(&args, &ros_args),
        CommandLine::Page(args) => page::main(&args, &ros_args),
        CommandLine::Status(args) => status::main(&args, &ros_args),
        CommandLine::Urdf(args) => urdf::main(&args),
        CommandLine::Bag(args) => bag::run(&args),
        CommandLine::Replay(args) => replay::main(&args, &ros_args),
        CommandLine::Replan(args) => camwright_analysis::replan::run(&args),
    };
    Shutdown::exit_code(code)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A single part, whose bag is predicted before there is room for it.
    #[test]
    fn without_a_command_the_defaults_are_those_of_run() {
        let words = |words: &[&str]| command_of(words.iter().map(ToString::to_string).collect::<Vec<_>>().into_iter());
        let Some(CommandLine::Run(bare)) = words(&["camwright"]) else { panic!("it runs") };
        let Some(CommandLine::Run(run)) = words(&["camwright", "run"]) else { panic!("it runs") };
        assert_eq!(bare.parts, 1);
        assert_eq!(format!("{bare:?}"), format!("{run:?}"));
    }
}
