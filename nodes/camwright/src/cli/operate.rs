// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright hold`, `resume`, `override` and others: operations of a running cell.

use super::output::{JsonArg, note, print_error, say};
use camwright::machine::description::Axis;
use camwright::simulation::fault::FAULTS;
use camwright_operator_page::Operator;
use camwright_operator_page::operation::{Answer, Operation};
use camwright_ros::running::NodeError;
use camwright_ros::{Node, NodeOptions, RosArgs, RosLayer, Shutdown};
use clap::Subcommand;
use clap::builder::PossibleValuesParser;
use serde_json::json;
use std::process::ExitCode;

/// Operations of a running cell.
#[derive(Debug, Subcommand)]
pub(super) enum OperateCommand {
    /// Hold the motion of a running cell on its path.
    #[command(after_help = super::help::HOLD)]
    Hold {
        #[command(flatten)]
        output: JsonArg,
    },
    /// Continue a held motion.
    #[command(after_help = super::help::RESUME)]
    Resume {
        #[command(flatten)]
        output: JsonArg,
    },
    /// Set the feed override.
    #[command(after_help = super::help::OVERRIDE)]
    Override {
        /// Percent of the programmed speed, 0 to 100.
        #[arg(value_name = "PERCENT", value_parser = percent)]
        percent: f64,
        #[command(flatten)]
        output: JsonArg,
    },
    /// Cancel the job, or the motion if there is no job.
    #[command(after_help = super::help::CANCEL)]
    Cancel {
        #[command(flatten)]
        output: JsonArg,
    },
    /// Reset the alarms; nothing moves.
    #[command(after_help = super::help::RESET)]
    Reset {
        #[command(flatten)]
        output: JsonArg,
    },
    /// Press the emergency stop of the simulated machine.
    #[command(after_help = super::help::ESTOP)]
    Estop {
        /// Release it instead.
        #[arg(long)]
        release: bool,
        #[command(flatten)]
        output: JsonArg,
    },
    /// Inject a fault into the simulated machine, or remove it.
    #[command(after_help = super::help::FAULT)]
    Fault {
        /// Name of the fault.
        #[arg(value_parser = PossibleValuesParser::new(FAULTS.map(|fault| fault.name)), hide_possible_values = true)]
        kind: String,
        /// Joint or input that the fault affects; some faults have none.
        #[arg(default_value = "", hide_default_value = true)]
        target: String,
        /// Size of the fault, in the unit that `camwright list faults` shows.
        #[arg(long, default_value_t = 1.0, allow_negative_numbers = true)]
        value: f64,
        /// Remove the fault.
        #[arg(long, conflicts_with = "value")]
        clear: bool,
        #[command(flatten)]
        output: JsonArg,
    },
    /// Home axes on their switches.
    #[command(after_help = super::help::HOME)]
    Home {
        /// Joints [default: all that need it].
        #[arg(value_name = "JOINT", value_parser = joint)]
        axes: Vec<Axis>,
        #[command(flatten)]
        output: JsonArg,
    },
    /// Start or stop the wheel.
    #[command(after_help = super::help::WHEEL)]
    Wheel {
        /// `on` or `off`.
        #[arg(value_parser = switch, action = clap::ArgAction::Set)]
        on: bool,
        #[command(flatten)]
        output: JsonArg,
    },
    /// Open door and chuck, insert a part, close both.
    #[command(after_help = super::help::LOAD)]
    Load {
        #[command(flatten)]
        output: JsonArg,
    },
    /// Open door and chuck, remove the part, close the door.
    #[command(after_help = super::help::UNLOAD)]
    Unload {
        #[command(flatten)]
        output: JsonArg,
    },
    /// Jog one axis, by a distance or until Ctrl-C.
    #[command(after_help = super::help::JOG)]
    Jog {
        /// Joint and distance: `z_axis=-0.5` (mm, deg). Without a distance: until Ctrl-C or the soft limit.
        #[arg(value_name = "JOINT[=DISTANCE]", value_parser = jogged)]
        axis: (Axis, Option<f64>),
        /// Speed (mm/s, deg/s); without a distance its sign is the direction.
        #[arg(long, allow_negative_numbers = true)]
        speed: f64,
        #[command(flatten)]
        output: JsonArg,
    },
}

/// Parses `50` or `50%`.
fn percent(text: &str) -> Result<f64, String> {
    let number = text.strip_suffix('%').unwrap_or(text).trim();
    let value: f64 = number.parse().map_err(|_| format!("{text:?} is not a number of percent, for example 50%"))?;
    if (0.0..=100.0).contains(&value) { Ok(value) } else { Err(format!("{text} is outside 0 % to 100 %")) }
}

pub(super) fn unknown_joint(joint: &str) -> String {
    format!("unknown joint {joint:?}; joints are c_axis, x_axis and z_axis")
}

fn joint(text: &str) -> Result<Axis, String> {
    Axis::from_joint(text).ok_or_else(|| unknown_joint(text))
}

/// Parses `x_axis=12.5` or `x_axis`.
fn jogged(text: &str) -> Result<(Axis, Option<f64>), String> {
    match text.contains('=') {
        true => super::setup::assignment(text).map(|(axis, distance)| (axis, Some(distance))),
        false => joint(text).map(|axis| (axis, None)),
    }
}

fn switch(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err(format!("{text:?} is not `on` or `off`")),
    }
}

impl OperateCommand {
    fn operation(&self) -> Operation {
        let name = |axis: &Axis| axis.joint().to_owned();
        match self {
            Self::Hold { .. } => Operation::Hold {},
            Self::Resume { .. } => Operation::Resume {},
            Self::Override { percent, .. } => Operation::Override { percent: *percent },
            Self::Cancel { .. } => Operation::Cancel {},
            Self::Reset { .. } => Operation::Reset {},
            Self::Estop { release, .. } => Operation::Estop { press: !release },
            Self::Fault { kind, target, value, clear, .. } => {
                Operation::Fault { kind: kind.clone(), target: target.clone(), value: *value, active: !clear }
            }
            Self::Home { axes, .. } => Operation::Home { axes: axes.iter().map(name).collect() },
            Self::Wheel { on, .. } => Operation::Wheel { on: *on },
            Self::Load { .. } => Operation::Load {},
            Self::Unload { .. } => Operation::Unload {},
            Self::Jog { axis: (axis, distance), speed, .. } => {
                Operation::Jog { axis: name(axis), distance: *distance, speed: *speed }
            }
        }
    }

    const fn output(&self) -> JsonArg {
        match self {
            Self::Hold { output }
            | Self::Resume { output }
            | Self::Override { output, .. }
            | Self::Cancel { output }
            | Self::Reset { output }
            | Self::Estop { output, .. }
            | Self::Fault { output, .. }
            | Self::Home { output, .. }
            | Self::Wheel { output, .. }
            | Self::Load { output }
            | Self::Unload { output }
            | Self::Jog { output, .. } => *output,
        }
    }
}

/// Entry point. Exit 0: done; 1: no node can start; 3: refused, or no cell answers.
pub(super) fn main(command: &OperateCommand, ros_args: &RosArgs) -> ExitCode {
    RosLayer::install();
    let operation = command.operation();
    match run(&operation, ros_args) {
        Ok(Answer { done, message }) if command.output().json => {
            say!("{}", json!({ "done": done, "message": message }));
            if done { ExitCode::SUCCESS } else { ExitCode::from(3) }
        }
        Ok(Answer { done: true, message }) => {
            say!("{message}");
            ExitCode::SUCCESS
        }
        Ok(Answer { done: false, message }) => {
            print_error("camwright", &message);
            ExitCode::from(3)
        }
        Err(error) => {
            print_error("camwright", &error);
            ExitCode::from(1)
        }
    }
}

fn run(operation: &Operation, ros_args: &RosArgs) -> Result<Answer, NodeError> {
    let shutdown = Shutdown::on_signals()?;
    let node = Node::new(NodeOptions::new("camwright_operate", ros_args))?;
    let spin = node.spin_in_thread()?;
    if let Operation::Jog { axis, distance: None, .. } = operation {
        note!("jogging {axis} until Ctrl-C");
    }
    let operator = Operator::new(node.clone(), ros_args, "camwright operator");
    let answer = operator.perform(operation, &|| !shutdown.is_requested());
    drop(spin);
    node.shutdown();
    Ok(answer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_the_command_line_become_operations() {
        assert_eq!((percent("50%"), percent("12.5")), (Ok(50.0), Ok(12.5)));
        for wrong in ["101", "-1", "x", "NaN", "50 %%", ""] {
            assert!(percent(wrong).is_err(), "{wrong}");
        }
        assert_eq!((jogged("c_axis"), jogged("z_axis=-2")), (Ok((Axis::C, None)), Ok((Axis::Z, Some(-2.0)))));
        assert!(joint("y_axis").is_err() && switch("maybe").is_err());
    }
}
