// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright setup`: set-up work on a cell that runs already.

use super::operate::unknown_joint;
use super::output::{print_error, say};
use camwright::machine::description::Axis;
use camwright_authority::{HeldCommand, TakeOptions};
use camwright_files::convert::{m_from_mm, si_from_file};
use camwright_msgs::Action;
use camwright_msgs::camwright_msgs::action::{MoveTo, MoveToGoal, Probe, ProbeGoal};
use camwright_msgs::camwright_msgs::srv::{
    ChangeWheel, ChangeWheelRequest, Dress, DressRequest, FindPhase, FindPhaseRequest, TouchOff, TouchOffRequest,
};
use camwright_operator_page::operation::{MotionEnd, motion, position};
use camwright_ros::running::NodeError;
use camwright_ros::{GoalStatus, Node, NodeOptions, RosArgs, RosLayer, Shutdown};
use clap::{Args, Subcommand};
use serde_json::json;
use std::process::ExitCode;
use std::time::Duration;

/// Maximum time to find the cell and to decide on a goal.
const MEETING: Duration = Duration::from_secs(20);
/// Maximum time of set-up work.
const WORK: Duration = Duration::from_secs(600);

/// Arguments of `camwright setup`.
#[derive(Debug, Args)]
#[command(after_help = super::help::SETUP)]
pub(super) struct SetupArgs {
    #[command(subcommand)]
    work: WorkArgs,
    /// Print the result as JSON on standard output.
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum WorkArgs {
    /// Move axes to positions, or by distances.
    #[command(after_help = super::help::SETUP_MOVE)]
    Move {
        /// Joint and position, for example `z_axis=80` (mm, deg).
        #[arg(required = true, value_name = "JOINT=POSITION", value_parser = assignment)]
        to: Vec<(Axis, f64)>,
        /// Move by distances from the present positions.
        #[arg(long)]
        by: bool,
        /// Fraction of the maximum speed.
        #[arg(long, value_name = "0..1", default_value_t = 1.0)]
        speed_factor: f64,
    },
    /// Move one axis until an input closes, then retract.
    #[command(after_help = super::help::SETUP_PROBE)]
    Probe {
        /// Joint and end of the search, for example `x_axis=18.5` (mm, deg).
        #[arg(value_name = "JOINT=TARGET", value_parser = assignment)]
        to: (Axis, f64),
        /// Input: `wheel_contact`, `key_way`, `origin` or the switch of a station.
        input: String,
        /// Search until the input opens.
        #[arg(long)]
        until_open: bool,
        /// Speed (mm/s, deg/s) [default: 0.05 mm/s for `wheel_contact`, else the search speed of the axis].
        #[arg(long)]
        speed: Option<f64>,
        /// Retract from the edge by this distance (mm, deg).
        #[arg(long, default_value_t = 0.0)]
        stand_off: f64,
        /// For `wheel_contact`: maximum force of the stopped wheel (N).
        #[arg(long, default_value_t = 0.0)]
        max_force_n: f64,
    },
    /// Dress the wheel.
    #[command(after_help = super::help::SETUP_DRESS)]
    Dress {
        /// Depth on the radius (um) [default: depth of the job].
        #[arg(long)]
        depth_um: Option<f64>,
    },
    /// Mount another wheel of the wheel changer.
    #[command(after_help = super::help::SETUP_CHANGE_WHEEL)]
    ChangeWheel {
        /// Name of the wheel in the machine file.
        wheel: String,
    },
    /// Touch a known radius and correct the zero of X.
    #[command(after_help = super::help::SETUP_TOUCH_OFF)]
    TouchOff {
        /// Round lobe of the loaded job, with its last measured radius.
        #[arg(long, conflicts_with = "station")]
        lobe: Option<String>,
        /// Station of another round surface.
        #[arg(long, requires = "radius_mm")]
        station: Option<String>,
        /// Radius at the station (mm).
        #[arg(long)]
        radius_mm: Option<f64>,
        /// Maximum correction (um) [default: 200].
        #[arg(long)]
        max_correction_um: Option<f64>,
        /// Touch with the stopped wheel, with at most this force (N).
        #[arg(long, default_value_t = 0.0)]
        max_force_n: f64,
        /// Measure without a correction.
        #[arg(long)]
        only_measure: bool,
    },
    /// Find the phase of the clamped part by its keyway.
    #[command(after_help = super::help::SETUP_FIND_PHASE)]
    FindPhase {
        /// Load a raw part of the loaded job first.
        #[arg(long)]
        load_part: bool,
        /// Discard the found phase without motion.
        #[arg(long)]
        forget: bool,
    },
}

/// Parses `x_axis=12.5`.
pub(super) fn assignment(text: &str) -> Result<(Axis, f64), String> {
    let (joint, value) =
        text.split_once('=').ok_or_else(|| format!("{text:?} is not JOINT=POSITION, for example z_axis=80"))?;
    let axis = Axis::from_joint(joint).ok_or_else(|| unknown_joint(joint))?;
    let value = super::output::number(value)?;
    Ok((axis, value))
}

/// Entry point.
pub(super) fn main(args: &SetupArgs, ros_args: &RosArgs) -> ExitCode {
    RosLayer::install();
    match run(&args.work, ros_args) {
        Ok((done, message)) if args.json => {
            say!("{}", json!({ "done": done, "message": message }));
            if done { ExitCode::SUCCESS } else { ExitCode::from(3) }
        }
        Ok((true, message)) => {
            say!("{message}");
            ExitCode::SUCCESS
        }
        Ok((false, message)) => {
            print_error("camwright setup", &message);
            ExitCode::from(3)
        }
        Err(error) => {
            print_error("camwright setup", &error);
            ExitCode::from(1)
        }
    }
}

fn run(work: &WorkArgs, ros_args: &RosArgs) -> Result<(bool, String), NodeError> {
    let shutdown = Shutdown::on_signals()?;
    let node = Node::new(NodeOptions::new("camwright_setup", ros_args))?;
    let spin = node.spin_in_thread()?;
    let outcome = HeldCommand::acquire(&node, &TakeOptions::new("camwright setup"))
        .map_err(|error| NodeError::Parameter(error.to_string()))
        .and_then(|command| {
            let outcome = ask(work, &node, &shutdown);
            drop(command);
            outcome
        });
    drop(spin);
    node.shutdown();
    outcome
}

fn ask(work: &WorkArgs, node: &Node, shutdown: &Shutdown) -> Result<(bool, String), NodeError> {
    match work {
        WorkArgs::Move { to, by, speed_factor } => {
            let goal = MoveToGoal {
                joints: to.iter().map(|(axis, _)| axis.joint().to_owned()).collect(),
                positions: to.iter().map(|(axis, place)| si_from_file(*axis, *place)).collect(),
                relative: *by,
                // 0 would count as 1.
                speed_factor: if *speed_factor == 0.0 { f64::NAN } else { *speed_factor },
            };
            Ok(match goal_of::<MoveTo>(node, "axis_interpolator/move_to", goal, shutdown)? {
                MotionEnd::Ended(status, result) => (status == GoalStatus::Succeeded, result.message),
                MotionEnd::Rejected(reason) => (false, rejected(&reason)),
            })
        }
        WorkArgs::Probe { to: (axis, target), input, until_open, speed, stand_off, max_force_n } => {
            let goal = ProbeGoal {
                joint: axis.joint().to_owned(),
                input: input.clone(),
                until_open: *until_open,
                target: si_from_file(*axis, *target),
                speed: speed.map_or(0.0, |speed| si_from_file(*axis, speed)),
                stand_off: si_from_file(*axis, *stand_off),
                most_force: *max_force_n,
                ..ProbeGoal::default()
            };
            let (status, result) = match goal_of::<Probe>(node, "axis_interpolator/probe", goal, shutdown)? {
                MotionEnd::Ended(status, result) => (status, result),
                MotionEnd::Rejected(reason) => return Ok((false, rejected(&reason))),
            };
            let good = status == GoalStatus::Succeeded;
            let found = if good { format!("; {input} at {}", position(*axis, result.position)) } else { String::new() };
            Ok((good, result.message + &found))
        }
        WorkArgs::Dress { depth_um } => {
            let request = DressRequest { depth: depth_um.map_or(0.0, m_from_um) };
            let answer = node.client::<Dress>("job_planner/dress")?;
            answer.wait_for_service(MEETING)?;
            let answer = answer.call(&request, WORK)?;
            Ok((answer.success, answer.message))
        }
        WorkArgs::ChangeWheel { wheel } => {
            let request = ChangeWheelRequest { wheel: wheel.clone() };
            let answer = node.client::<ChangeWheel>("job_planner/change_wheel")?;
            answer.wait_for_service(MEETING)?;
            let answer = answer.call(&request, WORK)?;
            Ok((answer.success, answer.message))
        }
        WorkArgs::TouchOff { lobe, station, radius_mm, max_correction_um, max_force_n, only_measure } => {
            let request = TouchOffRequest {
                lobe: lobe.clone().unwrap_or_default(),
                station: station.clone().unwrap_or_default(),
                radius: radius_mm.map_or(0.0, m_from_mm),
                most_correction: max_correction_um.map_or(0.0, m_from_um),
                most_force: *max_force_n,
                only_measure: *only_measure,
                ..TouchOffRequest::default()
            };
            let answer = node.client::<TouchOff>("job_planner/touch_off")?;
            answer.wait_for_service(MEETING)?;
            let answer = answer.call(&request, WORK)?;
            Ok((answer.success, answer.message))
        }
        WorkArgs::FindPhase { load_part, forget } => {
            let request = FindPhaseRequest { load_part: *load_part, forget: *forget, ..FindPhaseRequest::default() };
            let answer = node.client::<FindPhase>("job_planner/find_phase")?;
            answer.wait_for_service(MEETING)?;
            let answer = answer.call(&request, WORK)?;
            Ok((answer.success, answer.message))
        }
    }
}

fn m_from_um(um: f64) -> f64 {
    m_from_mm(camwright::math::units::mm_from_um(um))
}

/// Sends a goal and waits for its end; a signal cancels it.
fn goal_of<A: Action>(node: &Node, name: &str, goal: A::Goal, shutdown: &Shutdown) -> Result<MotionEnd<A>, NodeError>
where
    A::Result: Send + 'static,
{
    Ok(motion::<A>(node, name, goal, &|| {}, &|| !shutdown.is_requested())?)
}

/// Message about a goal that the axis interpolator rejects.
fn rejected(reason: &str) -> String {
    format!("not started: {reason}; nothing moved")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_given_by_joint_in_millimetres_and_degrees() {
        assert_eq!(assignment("x_axis=-1.5"), Ok((Axis::X, -1.5)));
        assert!((si_from_file(Axis::C, 180.0) - std::f64::consts::PI).abs() < 1e-15);
        assert!((si_from_file(Axis::Z, 80.0) - 0.08).abs() < 1e-15);
        assert_eq!(
            (position(Axis::X, 0.0203).as_str(), position(Axis::C, 0.0).as_str()),
            ("20.30000 mm", "0.00000 deg")
        );
        for wrong in ["x_axis", "y_axis=1", "x_axis=one"] {
            assert!(assignment(wrong).is_err(), "{wrong}");
        }
    }
}
