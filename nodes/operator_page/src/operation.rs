// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Operations of a running cell, for the command line and the page.

use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::Axis;
use camwright::math::units::deg_from_rad;
use camwright_files::convert::machine_now::described_machine;
use camwright_files::convert::{mm_from_m, si_from_file};
use camwright_msgs::action_msgs::srv::{CancelGoal, CancelGoalRequest};
use camwright_msgs::camwright_msgs::action::{Home, HomeGoal, Jog, JogGoal};
use camwright_msgs::camwright_msgs::msg::{
    CommandHolder, InterpolatorState, MachineAlarms, MachineDescription, WorkArea,
};
use camwright_msgs::camwright_msgs::srv::{InjectFault, InjectFaultRequest, SetOverride, SetOverrideRequest};
use camwright_msgs::rcl_interfaces::msg::Log;
use camwright_msgs::std_msgs::msg::Empty;
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, SetBoolResponse, Trigger, TriggerRequest};
use camwright_msgs::{Action, Message, Service};
use camwright_ros::{ActionClient, GoalId, GoalStatus, Node, Qos, RosError, Subscription};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Maximum time to find the server of an operation.
const MEETING: Duration = Duration::from_secs(5);
/// Maximum time to find a server that not every cell has, after the interpolator was found.
const OPTIONAL_SERVER: Duration = Duration::from_millis(300);
/// Maximum time for the answer of a service that does not wait for motion.
const ANSWER: Duration = Duration::from_secs(5);
/// Maximum time of homing, of a jog, and of a motion of wheel, door or chuck.
const MOTION: Duration = Duration::from_secs(300);
/// Maximum time from a rejection to its line in the log.
const LOG_DELAY: Duration = Duration::from_secs(1);
/// Words of the line, between the name of the action and the reason.
const REJECTED: &str = " rejected: ";
/// Time between two messages that keep a jog without distance alive.
const HOLD_TO_RUN: Duration = Duration::from_millis(100);

/// Answer to a cancellation of a cell at rest.
pub(crate) const NOTHING_TO_CANCEL: &str = "nothing to cancel: no job and no motion is in execution";

/// Request of an operator to a cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "operation", rename_all = "snake_case", deny_unknown_fields)]
pub enum Operation {
    /// Holds the motion on its path.
    Hold {},
    /// Continues a held motion.
    Resume {},
    /// Sets the feed override in percent of the programmed speed.
    Override { percent: f64 },
    /// Cancels the job, or the motion if there is no job.
    Cancel {},
    /// Resets the alarms. Nothing moves.
    Reset {},
    /// Presses the emergency stop of the simulated machine, or releases it.
    Estop { press: bool },
    /// Injects a fault into the simulated machine, or removes it. Units of the value: those of `machine/inject_fault`.
    Fault { kind: String, target: String, value: f64, active: bool },
    /// Homes axes; an empty list homes all that need it.
    Home { axes: Vec<String> },
    /// Starts or stops the wheel.
    Wheel { on: bool },
    /// Opens door and chuck, inserts a part, and closes both.
    Load {},
    /// Opens door and chuck, removes the part, and closes the door.
    Unload {},
    /// Jogs an axis by a distance (mm, deg) at a speed (mm/s, deg/s). Without a distance the jog lasts until it is stopped.
    Jog { axis: String, distance: Option<f64>, speed: f64 },
}

/// Result of an operation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Answer {
    /// True: the cell has done it.
    pub done: bool,
    /// Result, or the reason of a refusal and who refused.
    pub message: String,
}

impl Answer {
    pub(crate) fn done(message: impl Into<String>) -> Self {
        Self { done: true, message: message.into() }
    }

    pub(crate) fn refused(message: impl Into<String>) -> Self {
        Self { done: false, message: message.into() }
    }

    /// Answer of a service of `node`.
    fn of_service(node: &str, success: bool, message: &str, done: &str) -> Self {
        match (success, message) {
            (true, "") => Self::done(done),
            (true, message) => Self::done(format!("{done}: {message}")),
            (false, message) => Self::refused(format!("{node} refuses: {message}")),
        }
    }
}

impl Operation {
    /// Returns true for operations with a motion, which can take long.
    #[must_use]
    pub(crate) const fn lasts(&self) -> bool {
        matches!(self, Self::Jog { .. } | Self::Home { .. })
    }

    /// Returns true for operations that only stop. They need no command.
    #[must_use]
    pub fn is_stop(&self) -> bool {
        matches!(self, Self::Hold {} | Self::Cancel {} | Self::Estop { press: true })
    }

    /// Returns true for operations that start a motion.
    #[must_use]
    pub fn moves(&self) -> bool {
        matches!(
            self,
            Self::Resume {}
                | Self::Home { .. }
                | Self::Wheel { on: true }
                | Self::Load {}
                | Self::Unload {}
                | Self::Jog { .. }
        )
    }

    /// Asks the cell and waits for its answer. A motion ends once `goes_on` returns false; it is called ten times a second.
    ///
    /// # Errors
    /// The cell does not answer.
    pub fn perform(&self, node: &Node, goes_on: &dyn Fn() -> bool) -> Result<Answer, RosError> {
        match self {
            Self::Hold {} => feed_hold(node, true),
            Self::Resume {} => feed_hold(node, false),
            Self::Override { percent } => {
                let request = SetOverrideRequest { feed_override: percent / 100.0 };
                let answer = call::<SetOverride>(node, "axis_interpolator/set_override", &request, ANSWER)?;
                let done = format!("override {percent} %");
                Ok(Answer::of_service("axis_interpolator", answer.success, &answer.message, &done))
            }
            Self::Cancel {} => cancel(node),
            Self::Reset {} => {
                let answer = call::<Trigger>(node, "machine/reset", &TriggerRequest::default(), MOTION)?;
                Ok(Answer::of_service("machine", answer.success, &answer.message, "alarms reset"))
            }
            Self::Estop { press } => {
                let request = SetBoolRequest { data: *press };
                let SetBoolResponse { success, message } = call::<SetBool>(node, "machine/estop", &request, ANSWER)?;
                let done = if *press {
                    "emergency stop pressed"
                } else {
                    "emergency stop released; reset the alarms (`camwright reset`)"
                };
                Ok(Answer::of_service("machine", success, &message, done))
            }
            Self::Fault { kind, target, value, active } => {
                let (fault, target) = (kind.clone(), target.clone());
                let request = InjectFaultRequest { fault, target, value: *value, active: *active, job_tick: 0 };
                let answer = call::<InjectFault>(node, "machine/inject_fault", &request, ANSWER)?;
                let done = match active {
                    true => format!("fault {kind} injected"),
                    false => format!("fault {kind} removed; `camwright status` lists the alarms to reset"),
                };
                Ok(Answer::of_service("machine", answer.success, &answer.message, &done))
            }
            Self::Home { axes } => home(node, axes, goes_on),
            Self::Wheel { on } => {
                let request = SetBoolRequest { data: *on };
                let answer = call::<SetBool>(node, "axis_interpolator/wheel", &request, MOTION)?;
                let done = if *on { "wheel at speed" } else { "wheel stopped" };
                Ok(Answer::of_service("axis_interpolator", answer.success, &answer.message, done))
            }
            Self::Load {} => exchange(node, &LOADING, false, "part loaded"),
            Self::Unload {} => exchange(node, &UNLOADING, true, "part removed"),
            Self::Jog { axis, distance, speed } => jog(node, axis, *distance, *speed, goes_on),
        }
    }
}

fn call<S: Service>(node: &Node, name: &str, request: &S::Request, limit: Duration) -> Result<S::Response, RosError>
where
    S::Response: Send + 'static,
{
    let client = node.client::<S>(name)?;
    client.wait_for_service(MEETING)?;
    client.call(request, limit)
}

/// Last message of a latched topic.
fn latched<M: Message + Send + 'static>(node: &Node, topic: &str) -> Result<M, RosError> {
    let (sender, received) = mpsc::sync_channel(1);
    let _subscription = node.subscribe::<M>(topic, &Qos::latched(1), move |message, _| {
        let _is_first = sender.try_send(message);
    })?;
    received
        .recv_timeout(MEETING)
        .map_err(|_| RosError::Timeout { what: format!("message on {topic}"), waited_s: MEETING.as_secs_f64() })
}

fn feed_hold(node: &Node, hold: bool) -> Result<Answer, RosError> {
    let answer = call::<SetBool>(node, "axis_interpolator/feed_hold", &SetBoolRequest { data: hold }, ANSWER)?;
    let done = if hold { "motion held on its path" } else { "motion continues" };
    Ok(Answer::of_service("axis_interpolator", answer.success, &answer.message, done))
}

/// Actions that move axes.
const MOTIONS: [&str; 7] = [
    "axis_interpolator/execute_plan",
    "axis_interpolator/move_to",
    "axis_interpolator/jog",
    "axis_interpolator/home",
    "axis_interpolator/probe",
    "axis_interpolator/follow_joint_trajectory",
    "job_planner/run_job",
];

/// Cancels the job; without one, whatever the interpolator executes.
fn cancel(node: &Node) -> Result<Answer, RosError> {
    let planner = node.client::<Trigger>("job_planner/stop")?;
    let clients = MOTIONS.map(|action| node.client::<CancelGoal>(&format!("{action}/_action/cancel_goal")));
    let clients = clients.into_iter().collect::<Result<Vec<_>, _>>()?;
    // Membership only lengthens the wait: the first message may date from the start of the machine, before anyone had joined.
    let has_planner = Arc::<AtomicBool>::default();
    let into = Arc::clone(&has_planner);
    let _holder = node.subscribe::<CommandHolder>("machine/command_holder", &Qos::latched(1), move |message, _| {
        into.fetch_or(message.planner != [0; 16], Ordering::AcqRel);
    })?;
    let deadline = Instant::now() + MEETING;
    let left = || deadline.saturating_duration_since(Instant::now());
    let found = clients[0].wait_for_service(left());
    // A cell of a machine and an interpolator has no planner.
    let is_planner_there = planner.wait_for_service(OPTIONAL_SERVER).is_ok()
        || (has_planner.load(Ordering::Acquire) && planner.wait_for_service(left()).is_ok());
    if is_planner_there && planner.call(&TriggerRequest::default(), ANSWER)?.success {
        return Ok(Answer::done("job cancelled, the axes come to rest"));
    }
    if !is_planner_there {
        found?;
    }
    // All servers of a node appear together; those of a node that is missing are not waited for again.
    let patience = |action: &str| match action.starts_with("job_planner/") {
        true if !is_planner_there => Duration::ZERO,
        _ => left(),
    };
    let (sender, answers) = mpsc::channel();
    for (action, client) in MOTIONS.iter().zip(&clients) {
        if client.wait_for_service(patience(action)).is_ok() {
            let sender = sender.clone();
            client.call_with(&CancelGoalRequest::default(), move |answer| {
                let _is_answered = sender.send(!answer.goals_canceling.is_empty());
            })?;
        }
    }
    drop(sender);
    let deadline = Instant::now() + ANSWER;
    loop {
        match answers.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
            Ok(true) => return Ok(Answer::done("motion cancelled, the axes come to rest")),
            Ok(false) => {}
            Err(RecvTimeoutError::Disconnected) => {
                return Ok(Answer::refused(NOTHING_TO_CANCEL));
            }
            Err(RecvTimeoutError::Timeout) => {
                let what = "answer of an action server to a cancellation".to_owned();
                return Err(RosError::Timeout { what, waited_s: ANSWER.as_secs_f64() });
            }
        }
    }
}

fn home(node: &Node, axes: &[String], goes_on: &dyn Fn() -> bool) -> Result<Answer, RosError> {
    let goal = HomeGoal { joints: axes.to_vec() };
    let (success, result) = match motion::<Home>(node, "axis_interpolator/home", goal, &|| {}, goes_on)? {
        MotionEnd::Ended(status, result) => (status == GoalStatus::Succeeded, result),
        MotionEnd::Rejected(reason) => return Ok(Answer::refused(format!("axis_interpolator refuses: {reason}"))),
    };
    let names = if axes.is_empty() { "all axes".to_owned() } else { axes.join(", ") };
    Ok(Answer::of_service("axis_interpolator", success, &result.message, &format!("homed {names}")))
}

fn jog(
    node: &Node,
    axis: &str,
    distance: Option<f64>,
    speed: f64,
    goes_on: &dyn Fn() -> bool,
) -> Result<Answer, RosError> {
    let Some(joint) = Axis::from_joint(axis) else {
        return Ok(Answer::refused(format!("unknown joint {axis:?}; joints are c_axis, x_axis and z_axis")));
    };
    if distance == Some(0.0) {
        return Ok(Answer::refused(format!("the jog distance of {axis} is 0; give another distance, or none")));
    }
    if latched::<InterpolatorState>(node, "axis_interpolator/state")?.feed_override == 0.0 {
        return Ok(Answer::refused("the feed override is 0 %, so nothing moves; raise it (`camwright override 100%`)"));
    }
    let hold = node.publisher::<Empty>("axis_interpolator/hold_to_run", &Qos::default_topic())?;
    let goal = JogGoal {
        joint: axis.to_owned(),
        velocity: si_from_file(joint, speed),
        distance: distance.map_or(0.0, |distance| si_from_file(joint, distance)),
        hold_to_run: 0.0,
    };
    let is_held = distance.is_none();
    let keep_alive = || {
        // Without this message the jog ends.
        let _sent = is_held && hold.publish(&Empty::default()).is_ok();
    };
    let (status, result) = match motion::<Jog>(node, "axis_interpolator/jog", goal, &keep_alive, goes_on)? {
        MotionEnd::Ended(status, result) => (status, result),
        MotionEnd::Rejected(reason) => return Ok(Answer::refused(format!("axis_interpolator refuses: {reason}"))),
    };
    let ended_well = status == GoalStatus::Succeeded || (is_held && status == GoalStatus::Canceled);
    let at = format!("{axis} at {}", position(joint, result.position));
    Ok(match ended_well {
        true => Answer::done(at),
        false => Answer::refused(format!("axis_interpolator refuses: {}", result.message)),
    })
}

/// Position of an axis with its unit.
#[must_use]
pub fn position(axis: Axis, position: f64) -> String {
    match axis {
        Axis::C => format!("{:.5} deg", deg_from_rad(position)),
        Axis::X | Axis::Z => format!("{:.5} mm", mm_from_m(position)),
    }
}

/// End of a goal.
#[derive(Debug)]
pub enum MotionEnd<A: Action> {
    Ended(GoalStatus, A::Result),
    /// The server rejected it for this reason.
    Rejected(String),
}

/// Reasons of rejections. The protocol of actions has no field for them, so servers log them with the id of the goal.
struct RejectionLog {
    lines: mpsc::Receiver<String>,
    _subscription: Subscription,
}

impl RejectionLog {
    fn subscribe(node: &Node) -> Result<Self, RosError> {
        let (sender, lines) = mpsc::channel();
        let listen = move |log: Log, _: &_| {
            if log.msg.contains(REJECTED) {
                let _is_over = sender.send(log.msg);
            }
        };
        Ok(Self { lines, _subscription: node.subscribe("/rosout", &Qos::latched(1000), listen)? })
    }

    /// Reason for which a goal was rejected. A server logs the same reason once in five seconds: without a line about this goal, it is
    /// that of the last one.
    fn reason(&self, action: &str, goal: GoalId) -> String {
        let (id, about) = (goal.to_string(), format!(" of {action}{REJECTED}"));
        let mut last = None;
        let deadline = Instant::now() + LOG_DELAY;
        while let Ok(line) = self.lines.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
            let of_a_goal = line.strip_prefix("goal ").and_then(|line| line.split_once(&about));
            let Some((goal, reason)) = of_a_goal else { continue };
            if goal == id {
                return reason.to_owned();
            }
            last = Some(reason.to_owned());
        }
        last.unwrap_or_else(|| "the goal is rejected; the log of the node has the reason".to_owned())
    }
}

/// Sends a goal and waits for its end.
///
/// Ten times a second it calls `meanwhile`, and cancels the goal once `goes_on` returns false.
///
/// # Errors
/// The server is missing or does not answer.
pub fn motion<A: Action>(
    node: &Node,
    name: &str,
    goal: A::Goal,
    meanwhile: &dyn Fn(),
    goes_on: &dyn Fn() -> bool,
) -> Result<MotionEnd<A>, RosError>
where
    A::Result: Send + 'static,
{
    let rejections = RejectionLog::subscribe(node)?;
    let client: ActionClient<A> = node.action_client(name)?;
    client.wait_for_server(MEETING)?;
    let goal = client.send_goal(goal, drop, ANSWER)?;
    if !goal.accepted() {
        return Ok(MotionEnd::Rejected(rejections.reason(client.action(), goal.id())));
    }
    drop(rejections);
    let (sender, ended) = mpsc::channel();
    goal.result_with(move |status, result| drop(sender.send((status, result))))?;
    let mut is_cancelled = false;
    loop {
        match ended.recv_timeout(HOLD_TO_RUN) {
            Ok((status, result)) => return Ok(MotionEnd::Ended(status, result)),
            Err(RecvTimeoutError::Disconnected) => {
                return Err(RosError::Timeout { what: format!("result of {name}"), waited_s: 0.0 });
            }
            Err(RecvTimeoutError::Timeout) if goes_on() => meanwhile(),
            Err(RecvTimeoutError::Timeout) if !is_cancelled => {
                is_cancelled = true;
                goal.cancel_with(drop)?;
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
}

/// Step of loading by hand: service, and the state in which it is done.
type LoadingStep = (&'static str, fn(&WorkArea) -> bool);

const OPEN_DOOR: LoadingStep = ("machine/open_door", |area| area.door == WorkArea::OPEN);
const CLOSE_DOOR: LoadingStep = ("machine/close_door", |area| area.door == WorkArea::CLOSED);
const OPEN_CHUCK: LoadingStep = ("machine/open_chuck", |area| area.chuck == WorkArea::OPEN);
const CLOSE_CHUCK: LoadingStep = ("machine/close_chuck", |area| area.chuck == WorkArea::CLOSED);

/// Silence after which the states that a latched writer repeats to a late reader, old ones first, have all come.
pub(super) const END_OF_HISTORY: Duration = Duration::from_millis(200);

/// Steps of loading by hand.
const LOADING: [LoadingStep; 5] =
    [OPEN_DOOR, OPEN_CHUCK, ("machine/place_part", |area| area.part_present), CLOSE_CHUCK, CLOSE_DOOR];
/// Steps of unloading by hand.
const UNLOADING: [LoadingStep; 4] =
    [OPEN_DOOR, OPEN_CHUCK, ("machine/take_part", |area| !area.part_present), CLOSE_DOOR];

/// Message about door and chuck.
enum AreaMessage {
    Area(WorkArea),
    Alarms(MachineAlarms),
}

/// Exchanges a part by hand, step by step; a refused step, or a door or chuck that is stuck, ends it. Without a part to remove, or a free
/// chuck, nothing is opened.
fn exchange(node: &Node, steps: &[LoadingStep], needs_part: bool, done: &str) -> Result<Answer, RosError> {
    let clients = steps.iter().map(|(step, _)| node.client::<Trigger>(step)).collect::<Result<Vec<_>, _>>()?;
    let machine = described_machine(&latched::<MachineDescription>(node, "machine/description")?, &[]);
    if machine.is_ok_and(|machine| machine.loading.is_none()) {
        return Ok(Answer::refused(
            "the machine has no door and no chuck: its jobs insert the raw part themselves (key `loading` of the machine file)",
        ));
    }
    let (sender, messages) = mpsc::channel();
    let of_alarms = sender.clone();
    let _area = node.subscribe::<WorkArea>("machine/work_area", &Qos::latched(1), move |area, _| {
        let _is_over = sender.send(AreaMessage::Area(area));
    })?;
    let _alarms = node.subscribe::<MachineAlarms>("machine/alarms", &Qos::latched(1), move |alarms, _| {
        let _is_over = of_alarms.send(AreaMessage::Alarms(alarms));
    })?;
    let (mut last, mut active) = (None, MachineAlarms::default());
    let deadline = Instant::now() + MEETING;
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        match messages.recv_timeout(if last.is_some() { END_OF_HISTORY } else { left }) {
            Ok(AreaMessage::Area(area)) => last = Some(area),
            Ok(AreaMessage::Alarms(alarms)) => active = alarms,
            Err(_) if last.is_some() => break,
            Err(_) => {
                let what = "message on machine/work_area".to_owned();
                return Err(RosError::Timeout { what, waited_s: MEETING.as_secs_f64() });
            }
        }
    }
    match last.as_ref().map(|area| area.part_present) {
        Some(true) if !needs_part => {
            return Ok(Answer::refused("there is a part in the chuck already; remove it first (`camwright unload`)"));
        }
        Some(false) if needs_part => return Ok(Answer::refused("there is no part in the chuck; nothing was opened")),
        _ => {}
    }
    for ((step, is_done), client) in steps.iter().zip(clients) {
        client.wait_for_service(MEETING)?;
        let answer = client.call(&TriggerRequest::default(), MOTION)?;
        if !answer.success {
            return Ok(Answer::refused(format!("{step}: machine refuses: {}", answer.message)));
        }
        // The answer comes when the motion begins.
        let deadline = Instant::now() + MOTION;
        while !last.as_ref().is_some_and(is_done) {
            if let Some(kind) = stuck(&active) {
                let entry = kind.entry();
                let text = format!("{step}: alarm {}, {}: {}", entry.number, entry.name, entry.remedy);
                return Ok(Answer::refused(text));
            }
            match messages.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
                Ok(AreaMessage::Area(area)) => last = Some(area),
                Ok(AreaMessage::Alarms(alarms)) => active = alarms,
                Err(_) => {
                    return Err(RosError::Timeout { what: format!("end of {step}"), waited_s: MOTION.as_secs_f64() });
                }
            }
        }
    }
    Ok(Answer::done(done))
}

/// Alarm of a door or a chuck that does not move.
fn stuck(alarms: &MachineAlarms) -> Option<AlarmKind> {
    let is_active = |kind: &AlarmKind| alarms.alarms.iter().any(|alarm| alarm.number == kind.entry().number);
    [AlarmKind::DoorStuck, AlarmKind::ChuckStuck].into_iter().find(is_active)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stops_need_no_command_and_move_nothing() {
        let axis = || "z_axis".to_owned();
        let all = [
            (Operation::Hold {}, true, false),
            (Operation::Cancel {}, true, false),
            (Operation::Estop { press: true }, true, false),
            (Operation::Estop { press: false }, false, false),
            (Operation::Resume {}, false, true),
            (Operation::Override { percent: 50.0 }, false, false),
            (Operation::Reset {}, false, false),
            (Operation::Fault { kind: "estop".into(), target: String::new(), value: 1.0, active: true }, false, false),
            (Operation::Home { axes: vec![axis()] }, false, true),
            (Operation::Wheel { on: true }, false, true),
            (Operation::Wheel { on: false }, false, false),
            (Operation::Load {}, false, true),
            (Operation::Unload {}, false, true),
            (Operation::Jog { axis: axis(), distance: None, speed: 1.0 }, false, true),
        ];
        for (operation, is_stop, moves) in all {
            assert_eq!((operation.is_stop(), operation.moves()), (is_stop, moves), "{operation:?}");
            let text = serde_json::to_string(&operation).expect("it is plain data");
            assert_eq!(serde_json::from_str::<Operation>(&text).expect("its own text"), operation, "{text}");
        }
        for wrong in ["{}", r#"{"operation":"hold","x":1}"#, r#"{"operation":"fly"}"#, r#"{"operation":"override"}"#] {
            assert!(serde_json::from_str::<Operation>(wrong).is_err(), "{wrong}");
        }
    }
}
