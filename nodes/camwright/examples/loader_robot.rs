// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A robot that loads the machine, through nothing but what any robot's controller could do over ROS 2:
//! `cargo run --release -p camwright_nodes --example loader_robot -- [JOB [PARTS [KEY=VALUE ...]]]`.
//!
//! It says five times a second or more where it is (`loader/state`), does what `job_planner/loading` asks for, works the chuck by
//! `job_planner/open_chuck` and `/close_chuck`, and in the place of a gripper puts parts in and takes them out by
//! `machine/place_part` and `/take_part`. It also says RESET and START, as an operator or a line would. The machine needs a door and a
//! chuck: `machine_sim --ros-args -p 'machine_overrides:=["loading={door: {opens_ms: 1500, closes_ms: 1500}, chuck: {opens_ms: 500,
//! closes_ms: 500}, safe_x_mm: 120}"]'`.
#![allow(clippy::print_stdout, reason = "a command")]
#![allow(dead_code, reason = "the tests steer the robot by hand as well")]

use camwright_authority::{HeldCommand, TakeOptions};
use camwright_msgs::camwright_msgs::msg::{CellState, LoaderState, LoadingState};
use camwright_msgs::camwright_msgs::srv::{CellCommand, CellCommandRequest, CellCommandResponse};
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_ros::{Client, Node, NodeOptions, Publisher, Qos, RosArgs, RosError, SpinThread, Subscription};
use camwright_ros::{RosLayer, TimerHandle};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Period of its signals.
const SIGNALS: Duration = Duration::from_millis(100);
/// Maximum time of an answer.
const ANSWER: Duration = Duration::from_secs(90);

/// Received messages, and a condition variable for new ones.
#[derive(Debug, Default)]
struct ReceivedStates {
    cell: Option<CellState>,
    loading: Option<LoadingState>,
}

/// Its signals as it says them now.
#[derive(Debug, Default)]
struct Signals {
    state: LoaderState,
    is_silent: bool,
}

/// The robot.
#[derive(Debug)]
pub(crate) struct Robot {
    /// Its node.
    pub(crate) node: Node,
    received: Arc<(Mutex<ReceivedStates>, Condvar)>,
    signals: Arc<Mutex<Signals>>,
    publisher: Publisher<LoaderState>,
    command: Client<CellCommand>,
    open_chuck: Client<Trigger>,
    close_chuck: Client<Trigger>,
    place_part: Client<Trigger>,
    take_part: Client<Trigger>,
    _timer: TimerHandle,
    _subscriptions: [Subscription; 2],
    _spin: SpinThread,
}

impl Robot {
    /// A robot outside the machine, with so many raw parts.
    ///
    /// # Errors
    /// DDS that cannot start.
    pub(crate) fn start(args: &RosArgs, raw_parts: u32) -> Result<Self, RosError> {
        let node = Node::new(NodeOptions::new("loader_robot", args))?;
        let received: Arc<(Mutex<ReceivedStates>, Condvar)> = Arc::default();
        let (of_cell, of_loading) = (Arc::clone(&received), Arc::clone(&received));
        let latched = Qos::latched(1);
        let cell = node.subscribe("job_planner/cell_state", &latched, move |state: CellState, _| {
            update(&of_cell, |received| received.cell = Some(state));
        })?;
        let loading = node.subscribe("job_planner/loading", &latched, move |state: LoadingState, _| {
            update(&of_loading, |received| received.loading = Some(state));
        })?;
        let state =
            LoaderState { name: "loader".into(), available: true, parts_left: raw_parts, ..LoaderState::default() };
        let signals = Arc::new(Mutex::new(Signals { state, is_silent: false }));
        let publisher = node.publisher("loader/state", &Qos::default_topic())?;
        let (sent_signals, state_publisher, clock) = (Arc::clone(&signals), publisher.clone(), node.clone());
        let timer = node.timer(SIGNALS, move || publish(&sent_signals, &state_publisher, &clock));
        Ok(Self {
            command: node.client("job_planner/cell_command")?,
            open_chuck: node.client("job_planner/open_chuck")?,
            close_chuck: node.client("job_planner/close_chuck")?,
            place_part: node.client("machine/place_part")?,
            take_part: node.client("machine/take_part")?,
            received,
            signals,
            publisher,
            _timer: timer,
            _subscriptions: [cell, loading],
            _spin: node.spin_in_thread()?,
            node,
        })
    }

    /// Changes its signals, and says so at once.
    pub(crate) fn signal(&self, change: impl FnOnce(&mut LoaderState)) {
        change(&mut self.signals.lock().unwrap_or_else(PoisonError::into_inner).state);
        publish(&self.signals, &self.publisher, &self.node);
    }

    /// Ceases to say anything, as one that has died; or speaks again.
    pub(crate) fn be_silent(&self, is_silent: bool) {
        self.signals.lock().unwrap_or_else(PoisonError::into_inner).is_silent = is_silent;
    }

    /// Waits until cell and loading are as wanted.
    ///
    /// # Errors
    /// They are not within the time.
    fn wait<R>(&self, what: &str, mut wanted: impl FnMut(&ReceivedStates) -> Option<R>) -> Result<R, String> {
        let end = Instant::now() + ANSWER;
        let mut received = self.received.0.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(found) = wanted(&received) {
                return Ok(found);
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                let cell = received.cell.as_ref().map(|cell| (&cell.state_name, &cell.substate, &cell.stop_reason));
                return Err(format!("waited {} s for {what}; the cell is {cell:?}", ANSWER.as_secs()));
            }
            received = self.received.1.wait_timeout(received, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Waits for a state of the cell.
    ///
    /// # Errors
    /// It does not come.
    pub(crate) fn cell(&self, what: &str, wanted: impl Fn(&CellState) -> bool) -> Result<CellState, String> {
        self.wait(what, |received| received.cell.clone().filter(|cell| wanted(cell)))
    }

    /// Waits for a state of the loading.
    ///
    /// # Errors
    /// It does not come.
    pub(crate) fn loading(&self, what: &str, wanted: impl Fn(&LoadingState) -> bool) -> Result<LoadingState, String> {
        self.wait(what, |received| received.loading.clone().filter(|loading| wanted(loading)))
    }

    /// A command to the cell.
    ///
    /// # Errors
    /// No answer.
    pub(crate) fn command(&self, request: &CellCommandRequest) -> Result<CellCommandResponse, String> {
        self.command.wait_for_service(ANSWER).map_err(|error| error.to_string())?;
        self.command.call(request, ANSWER).map_err(|error| error.to_string())
    }

    /// One of its own steps at the machine.
    fn step(&self, client: &Client<Trigger>) -> Result<(), String> {
        client.wait_for_service(ANSWER).map_err(|error| error.to_string())?;
        let answer = client.call(&TriggerRequest::default(), ANSWER).map_err(|error| error.to_string())?;
        if answer.success { Ok(()) } else { Err(format!("{}: {}", client.service(), answer.message)) }
    }

    /// Enters as soon as it may; the request that it enters for.
    ///
    /// # Errors
    /// No leave comes.
    pub(crate) fn enter(&self) -> Result<u8, String> {
        let cleared = self.loading("a leave to enter", |loading| loading.clear_to_enter)?;
        self.signal(|signals| (signals.busy, signals.in_work_area) = (true, true));
        // The chuck obeys once the machine, too, has seen that it is inside.
        self.loading("the machine to see it", |loading| loading.robot_in_work_area && loading.step == "inside")?;
        Ok(cleared.request)
    }

    /// Changes the part: it is inside.
    ///
    /// # Errors
    /// Chuck or gripper is refused.
    pub(crate) fn change_part(&self, request: u8) -> Result<(), String> {
        self.step(&self.open_chuck)?;
        if request != LoadingState::LOAD {
            self.step(&self.take_part)?;
        }
        if request != LoadingState::UNLOAD {
            self.step(&self.place_part)?;
            self.step(&self.close_chuck)?;
            self.signal(|signals| signals.parts_left = signals.parts_left.saturating_sub(1));
        }
        Ok(())
    }

    /// Leaves, and waits until the leave is taken back.
    ///
    /// # Errors
    /// It stays.
    pub(crate) fn leave(&self) -> Result<(), String> {
        self.signal(|signals| (signals.busy, signals.in_work_area) = (false, false));
        self.loading("the end of the leave", |loading| !loading.clear_to_enter).map(drop)
    }

    /// Tends the cell until its run is complete; the requests that it served.
    ///
    /// # Errors
    /// The cell is held, stopped or aborted, or a step is refused: what it says.
    pub(crate) fn tend(&self) -> Result<Vec<u8>, String> {
        let mut served = Vec::new();
        loop {
            let is_over = self.wait("a request", |received| {
                let cell = received.cell.as_ref()?;
                let failed = matches!(cell.state, CellState::HELD | CellState::STOPPED | CellState::ABORTED);
                if failed {
                    return Some(Err(format!("the cell is {}: {}", cell.state_name, cell.stop_reason)));
                }
                let clear = received.loading.as_ref().is_some_and(|loading| loading.clear_to_enter);
                (clear || cell.state == CellState::COMPLETE).then_some(Ok(!clear))
            })??;
            if is_over {
                return Ok(served);
            }
            let request = self.enter()?;
            let changed = self.change_part(request);
            // Whatever happened, it comes out before it says so.
            self.leave()?;
            changed?;
            served.push(request);
        }
    }

    /// RESET and START of a run, as an operator or a line would say them.
    ///
    /// # Errors
    /// One of them is refused.
    pub(crate) fn start_run(&self, job: &str, overrides: &[String], parts: u32) -> Result<(), String> {
        let reset = CellCommandRequest { command: CellCommandRequest::RESET, ..CellCommandRequest::default() };
        let (job, overrides) = (job.to_owned(), overrides.to_vec());
        let start = CellCommandRequest { command: CellCommandRequest::START, parts, job, overrides };
        for (request, state) in [(reset, CellState::IDLE), (start, 0)] {
            let answer = self.command(&request)?;
            if !answer.success {
                return Err(answer.message);
            }
            if state > 0 {
                self.cell("the cell to be idle", |cell| cell.state == state)?;
            }
        }
        // Messages from now on belong to this run.
        self.cell("the run to begin", |cell| cell.state != CellState::IDLE).map(drop)
    }
}

fn update(received: &(Mutex<ReceivedStates>, Condvar), change: impl FnOnce(&mut ReceivedStates)) {
    change(&mut received.0.lock().unwrap_or_else(PoisonError::into_inner));
    received.1.notify_all();
}

fn publish(signals: &Mutex<Signals>, publisher: &Publisher<LoaderState>, node: &Node) {
    let signals = signals.lock().unwrap_or_else(PoisonError::into_inner);
    if signals.is_silent {
        return;
    }
    let message = LoaderState { stamp: node.now(), ..signals.state.clone() };
    if let Err(error) = publisher.publish(&message) {
        node.logger().warn(&error.to_string());
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (args, words) = RosArgs::from_env()?;
    RosLayer::install();
    let mut words = words.into_iter();
    let job = words.next().unwrap_or_default();
    let parts: u32 = words.next().map_or(Ok(10), |word| word.parse())?;
    let overrides: Vec<String> = words.collect();
    let robot = Robot::start(&args, parts)?;
    // Shared: an operator may command beside the robot.
    let _command = HeldCommand::acquire(&robot.node, &TakeOptions::new("loader robot").shared().for_cell())?;
    robot.start_run(&job, &overrides, parts)?;
    let served = robot.tend()?;
    let end = robot.cell("the end of the run", |cell| cell.state == CellState::COMPLETE)?;
    println!("{} of {parts} parts tended in {} visits", end.parts_done, served.len());
    println!("parts of the machine: {} good, {} bad, {} in all", end.life.good, end.life.bad, end.life.total);
    Ok(())
}
