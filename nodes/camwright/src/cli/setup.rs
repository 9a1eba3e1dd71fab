//! `camwright setup`: set-up work on a cell that runs already.

use super::output::say;
use camwright::machine::description::Axis;
use camwright::math::units::deg_from_rad;
use camwright_authority::{Command, TakeOptions};
use camwright_files::convert::{m_from_mm, mm_from_m, si_from_file};
use camwright_msgs::Action;
use camwright_msgs::camwright_msgs::action::{Jog, JogGoal, MoveTo, MoveToGoal, Probe, ProbeGoal};
use camwright_msgs::camwright_msgs::srv::{
    Dress, DressRequest, FindPhase, FindPhaseRequest, TouchOff, TouchOffRequest,
};
use camwright_msgs::std_msgs::msg::Empty;
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest};
use camwright_ros::running::NodeError;
use camwright_ros::{ActionClient, GoalStatus, Node, NodeOptions, Qos, RosArgs, RosLayer, Shutdown};
use clap::{Args, Subcommand};
use std::process::ExitCode;
use std::sync::mpsc;
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
    /// Jog one axis, by a distance or until Ctrl-C.
    #[command(after_help = super::help::SETUP_JOG)]
    Jog {
        /// Joint and distance: `z_axis=-0.5` (mm, deg). Without a distance: until Ctrl-C or the soft limit.
        #[arg(value_name = "JOINT[=DISTANCE]", value_parser = jogged)]
        axis: (Axis, Option<f64>),
        /// Speed (mm/s, deg/s); without a distance its sign is the direction.
        #[arg(long, allow_negative_numbers = true)]
        speed: f64,
    },
    /// Start or stop the wheel.
    #[command(after_help = super::help::SETUP_WHEEL)]
    Wheel {
        /// `on` or `off`.
        #[arg(value_parser = switch, action = clap::ArgAction::Set)]
        on: bool,
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
        most_force_n: f64,
    },
    /// Dress the wheel.
    #[command(after_help = super::help::SETUP_DRESS)]
    Dress {
        /// Depth on the radius (um) [default: depth of the job].
        #[arg(long)]
        depth_um: Option<f64>,
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
        most_correction_um: Option<f64>,
        /// Touch with the stopped wheel, with at most this force (N).
        #[arg(long, default_value_t = 0.0)]
        most_force_n: f64,
        /// Measure without a correction.
        #[arg(long)]
        only_measure: bool,
    },
    /// Find the phase of the clamped part by its key-way.
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

fn unknown_joint(joint: &str) -> String {
    format!("unknown joint {joint:?}; joints are c_axis, x_axis and z_axis")
}

/// Parses `x_axis=12.5`.
fn assignment(text: &str) -> Result<(Axis, f64), String> {
    let (joint, value) =
        text.split_once('=').ok_or_else(|| format!("{text:?} is not JOINT=POSITION, for example z_axis=80"))?;
    let axis = Axis::from_joint(joint).ok_or_else(|| unknown_joint(joint))?;
    let value = value.parse::<f64>().map_err(|error| format!("{value:?}: {error}"))?;
    Ok((axis, value))
}

/// Parses `x_axis=12.5` or `x_axis`.
fn jogged(text: &str) -> Result<(Axis, Option<f64>), String> {
    if text.contains('=') {
        return assignment(text).map(|(axis, distance)| (axis, Some(distance)));
    }
    let axis = Axis::from_joint(text).ok_or_else(|| unknown_joint(text))?;
    Ok((axis, None))
}

fn switch(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err(format!("{text:?} is not `on` or `off`")),
    }
}

/// Entry point.
pub(super) fn main(args: &SetupArgs, ros_args: &RosArgs) -> ExitCode {
    RosLayer::install();
    match run(&args.work, ros_args) {
        Ok((true, message)) => {
            print(&message);
            ExitCode::SUCCESS
        }
        Ok((false, message)) => {
            eprintln!("camwright setup: {message}");
            ExitCode::from(3)
        }
        Err(error) => {
            eprintln!("camwright setup: {error}");
            ExitCode::from(1)
        }
    }
}

fn print(message: &str) {
    say!("{message}");
}

fn run(work: &WorkArgs, ros_args: &RosArgs) -> Result<(bool, String), NodeError> {
    let shutdown = Shutdown::on_signals()?;
    let node = Node::new(NodeOptions::new("camwright_setup", ros_args))?;
    let spin = node.spin_in_thread()?;
    let outcome = Command::acquire(&node, &TakeOptions::new("camwright setup"))
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
            let (status, result) = goal_of::<MoveTo>(node, "axis_interpolator/move_to", goal, shutdown, || {})?;
            Ok((status == GoalStatus::Succeeded, result.message))
        }
        WorkArgs::Jog { axis: (axis, distance), speed } => jog(node, *axis, *distance, *speed, shutdown),
        WorkArgs::Wheel { on } => {
            let wheel = node.client::<SetBool>("axis_interpolator/wheel")?;
            wheel.wait_for_service(MEETING)?;
            let answer = wheel.call(&SetBoolRequest { data: *on }, WORK)?;
            Ok((answer.success, answer.message))
        }
        WorkArgs::Probe { to: (axis, target), input, until_open, speed, stand_off, most_force_n } => {
            let goal = ProbeGoal {
                joint: axis.joint().to_owned(),
                input: input.clone(),
                until_open: *until_open,
                target: si_from_file(*axis, *target),
                speed: speed.map_or(0.0, |speed| si_from_file(*axis, speed)),
                stand_off: si_from_file(*axis, *stand_off),
                most_force: *most_force_n,
                ..ProbeGoal::default()
            };
            let (status, result) = goal_of::<Probe>(node, "axis_interpolator/probe", goal, shutdown, || {})?;
            let good = status == GoalStatus::Succeeded;
            let found = if good { format!("; {input} at {}", place(*axis, result.position)) } else { String::new() };
            Ok((good, result.message + &found))
        }
        WorkArgs::Dress { depth_um } => {
            let request = DressRequest { depth: depth_um.map_or(0.0, m_from_um) };
            let answer = node.client::<Dress>("job_planner/dress")?;
            answer.wait_for_service(MEETING)?;
            let answer = answer.call(&request, WORK)?;
            Ok((answer.success, answer.message))
        }
        WorkArgs::TouchOff { lobe, station, radius_mm, most_correction_um, most_force_n, only_measure } => {
            let request = TouchOffRequest {
                lobe: lobe.clone().unwrap_or_default(),
                station: station.clone().unwrap_or_default(),
                radius: radius_mm.map_or(0.0, m_from_mm),
                most_correction: most_correction_um.map_or(0.0, m_from_um),
                most_force: *most_force_n,
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

/// Jogs; without a distance until Ctrl-C.
fn jog(
    node: &Node,
    axis: Axis,
    distance: Option<f64>,
    speed: f64,
    shutdown: &Shutdown,
) -> Result<(bool, String), NodeError> {
    if distance == Some(0.0) {
        return Err(NodeError::Parameter(format!(
            "the jog distance of {} is 0; give a distance other than 0, or none",
            axis.joint()
        )));
    }
    let hold = node.publisher::<Empty>("axis_interpolator/hold_to_run", &Qos::default_topic())?;
    let goal = JogGoal {
        joint: axis.joint().to_owned(),
        velocity: si_from_file(axis, speed),
        distance: distance.map_or(0.0, |distance| si_from_file(axis, distance)),
        hold_to_run: 0.0,
    };
    let held = distance.is_none();
    if held {
        eprintln!("jogging {} until Ctrl-C", axis.joint());
    }
    let (status, result) = goal_of::<Jog>(node, "axis_interpolator/jog", goal, shutdown, || {
        // Without this message the jog ends.
        let _sent = held && hold.publish(&Empty::default()).is_ok();
    })?;
    let ended_well = status == GoalStatus::Succeeded || (held && status == GoalStatus::Canceled);
    let at = if ended_well { format!("; {} at {}", axis.joint(), place(axis, result.position)) } else { String::new() };
    Ok((ended_well, result.message + &at))
}

/// Position with its unit.
fn place(axis: Axis, position: f64) -> String {
    match axis {
        Axis::C => format!("{:.5} deg", deg_from_rad(position)),
        Axis::X | Axis::Z => format!("{:.5} mm", mm_from_m(position)),
    }
}

fn m_from_um(um: f64) -> f64 {
    m_from_mm(camwright::math::units::mm_from_um(um))
}

/// Sends a goal and waits for its end; a signal cancels it. Calls `meanwhile` ten times a second.
fn goal_of<A: Action>(
    node: &Node,
    name: &str,
    goal: A::Goal,
    shutdown: &Shutdown,
    meanwhile: impl Fn(),
) -> Result<(GoalStatus, A::Result), NodeError>
where
    A::Result: Send + 'static,
{
    let client: ActionClient<A> = node.action_client(name)?;
    client.wait_for_server(MEETING)?;
    let goal = client.send_goal(goal, drop, MEETING)?;
    if !goal.accepted() {
        return Err(NodeError::Parameter("the axis interpolator rejected the goal; its log shows the reason".into()));
    }
    let (sender, ended) = mpsc::channel();
    goal.result_with(move |status, result| drop(sender.send((status, result))))?;
    let mut cancelled = false;
    loop {
        match ended.recv_timeout(Duration::from_millis(100)) {
            Ok(ended) => return Ok(ended),
            Err(mpsc::RecvTimeoutError::Timeout) if shutdown.is_requested() => {}
            Err(mpsc::RecvTimeoutError::Timeout) => meanwhile(),
            Err(error) => return Err(NodeError::Parameter(error.to_string())),
        }
        if shutdown.is_requested() && !cancelled {
            cancelled = true;
            goal.cancel_with(drop)?;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_given_by_joint_in_millimetres_and_degrees() {
        assert_eq!(assignment("x_axis=-1.5"), Ok((Axis::X, -1.5)));
        assert!((si_from_file(Axis::C, 180.0) - std::f64::consts::PI).abs() < 1e-15);
        assert!((si_from_file(Axis::Z, 80.0) - 0.08).abs() < 1e-15);
        assert_eq!((place(Axis::X, 0.0203).as_str(), place(Axis::C, 0.0).as_str()), ("20.30000 mm", "0.00000 deg"));
        assert_eq!((jogged("c_axis"), jogged("z_axis=-2")), (Ok((Axis::C, None)), Ok((Axis::Z, Some(-2.0)))));
        for wrong in ["x_axis", "y_axis=1", "x_axis=one"] {
            assert!(assignment(wrong).is_err(), "{wrong}");
        }
    }
}
