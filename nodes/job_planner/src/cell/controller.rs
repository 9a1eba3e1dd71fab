// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The cell thread: what it knows of jobs, machine and robot, and how that moves the state of the cell.

use super::devices::{DeviceRequest, Devices};
use super::publisher::CellPublisher;
use super::run::PartsRun;
use super::{CellEvent, Shared, lock};
use crate::job_slot::JobSlot;
use camwright::cell::loading::Handshake;
use camwright::cell::packml::{Command, PackmlState, Unit};
use camwright_msgs::camwright_msgs::msg::{InterpolatorState, JobStatus, LoaderState, MachineCounters, WorkArea};
use camwright_msgs::camwright_msgs::srv::{CellCommand, CellCommandResponse};
use camwright_msgs::std_srvs::srv::Trigger;
use camwright_ros::{ElapsedTime, Responder, RosError};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Weak, mpsc};
use std::time::{Duration, Instant};

/// Period of the checks without an event.
const PERIOD: Duration = Duration::from_millis(50);
/// Maximum age of the interpolator's last message while it counts as present.
const ALIVE_FOR: Duration = Duration::from_secs(5);

/// Maximum time for clearing machine and interpolator (s).
const CLEARING_S: f64 = 10.0;

/// Why it is suspended, or held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SuspensionCause {
    /// A robot is to load.
    Loading,
    Command,
    /// Another client holds the feed, and the cell follows.
    Feed,
}

/// Why it is not producing.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Reason {
    pub(super) text: String,
    pub(super) alarm: u16,
    pub(super) remedy: String,
}

impl Reason {
    pub(super) fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), ..Self::default() }
    }
}

/// Everything the cell thread has.
pub(super) struct CellController {
    /// Weak: the planner's other threads end before this one is ordered to.
    planner: Weak<Shared>,
    inbox: mpsc::Receiver<CellEvent>,
    began: Instant,
    /// ROS time for the times in messages.
    elapsed: ElapsedTime,
    pub(super) unit: Unit,
    /// The state as last seen, and since when in real time.
    state_since: (PackmlState, Instant),
    pub(super) devices: Devices,
    pub(super) publisher: CellPublisher,
    pub(super) run: Option<PartsRun>,
    pub(super) handshake: Option<Handshake>,
    pub(super) cause: Option<SuspensionCause>,
    pub(super) reason: Reason,
    /// Current action or wait.
    pub(super) substate: String,
    /// The machine refused the last request for the door; `substate` has its reason.
    pub(super) is_door_refused: bool,
    /// ABORT, or a fault without an alarm of the machine: only CLEAR ends it.
    pub(super) needs_clear: bool,
    /// The alarm of the machine that it was aborted for.
    by_alarm: bool,
    pub(super) clearing: Option<Responder<CellCommand>>,
    pub(super) chuck: Option<(bool, Instant, Responder<Trigger>)>,
    /// The part in the chuck has been machined, or was begun.
    pub(super) is_machined: bool,
    pub(super) area: Option<WorkArea>,
    pub(super) loader: Option<(LoaderState, Instant)>,
    pub(super) motion: Option<InterpolatorState>,
    motion_at: Option<Instant>,
    pub(super) counters: MachineCounters,
    pub(super) job: String,
    /// A job of any client executes.
    pub(super) in_job: bool,
    /// Parts of the run: wanted, done.
    pub(super) parts: (u32, u32),
}

impl CellController {
    pub(super) fn new(shared: &Arc<Shared>, inbox: mpsc::Receiver<CellEvent>) -> Result<Self, RosError> {
        let mailbox = shared.cell.mailbox.clone();
        Ok(Self {
            planner: Arc::downgrade(shared),
            inbox,
            began: Instant::now(),
            elapsed: shared.node.elapsed_time(),
            unit: Unit::new(0.0),
            state_since: (PackmlState::default(), Instant::now()),
            devices: Devices::new(&shared.node, mailbox)?,
            publisher: CellPublisher::new(&shared.node)?,
            run: None,
            handshake: None,
            cause: None,
            reason: Reason::default(),
            substate: String::new(),
            is_door_refused: false,
            needs_clear: false,
            by_alarm: false,
            clearing: None,
            chuck: None,
            is_machined: false,
            area: None,
            loader: None,
            motion: None,
            motion_at: None,
            counters: MachineCounters::default(),
            job: String::new(),
            in_job: false,
            parts: (0, 0),
        })
    }

    pub(super) fn run(mut self) {
        let Some(node) = self.planner.upgrade().map(|shared| shared.node.clone()) else { return };
        let _current = node.logger().enter();
        loop {
            let first = self.inbox.recv_timeout(PERIOD);
            let Some(shared) = self.planner.upgrade() else { return };
            let mut event = match first {
                Ok(event) => Some(event),
                Err(mpsc::RecvTimeoutError::Timeout) => None,
                Err(mpsc::RecvTimeoutError::Disconnected) => return,
            };
            while let Some(next) = event {
                if matches!(next, CellEvent::End) {
                    return;
                }
                self.apply(&shared, next);
                self.settle(&shared);
                event = self.inbox.try_recv().ok();
            }
            self.settle(&shared);
            self.publish(&shared);
        }
    }

    /// ROS time since the start (s), for the times of the states.
    pub(super) fn now_s(&mut self) -> f64 {
        self.elapsed.seconds()
    }

    /// Real time since the start (s), for waits: simulated time may stand still.
    pub(super) fn real_s(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// Real time in the present state (s).
    pub(super) fn waited_s(&self) -> f64 {
        self.state_since.1.elapsed().as_secs_f64()
    }

    fn apply(&mut self, shared: &Arc<Shared>, event: CellEvent) {
        match event {
            CellEvent::Command(request, responder) => self.commanded(shared, request, responder),
            CellEvent::Mode(mode, responder) => self.select(shared, mode, responder),
            CellEvent::Chuck(open, responder) => self.work_chuck(shared, open, responder),
            CellEvent::Job(status) => self.job(shared, &status),
            CellEvent::PartRefused(reason) => self.part_refused(shared, &reason),
            CellEvent::WorkArea(area) => {
                if let Err(error) = self.devices.meet_area() {
                    shared.node.logger().error(&error.to_string());
                }
                self.is_machined &= area.part_present;
                self.area = Some(area);
            }
            CellEvent::Loader(loader) => self.loader = Some((loader, Instant::now())),
            CellEvent::Motion(motion) => (self.motion, self.motion_at) = (Some(*motion), Some(Instant::now())),
            CellEvent::Counters(counters) => self.counters = counters,
            CellEvent::Alarms | CellEvent::End => {}
            CellEvent::Answered(asked, success, message) => self.answered(shared, asked, success, &message),
        }
    }

    /// Moves on until nothing more is to be done now.
    pub(super) fn settle(&mut self, shared: &Arc<Shared>) {
        // Every turn enters a state or is the last one; there is no way round that is longer.
        for _ in 0..32 {
            let before = self.unit.state();
            if self.state_since.0 != before {
                self.state_since = (before, Instant::now());
            }
            self.check_alarms(shared);
            self.check_hold(shared);
            self.act(shared);
            self.let_go_of_handshake();
            self.finish_chuck(shared);
            self.set_gate(shared);
            if self.unit.state() == before {
                return;
            }
            self.publish(shared);
        }
    }

    /// A command that the cell gives itself; the states in which it leads nowhere stay as they are.
    pub(super) fn command(&mut self, shared: &Shared, command: Command) -> bool {
        let now_s = self.now_s();
        let is_taken = self.unit.command(command, now_s).is_ok();
        if is_taken {
            self.publish(shared);
        }
        is_taken
    }

    pub(super) fn complete(&mut self, shared: &Shared) {
        let now_s = self.now_s();
        if self.unit.complete(now_s) {
            self.publish(shared);
        }
    }

    /// Running job of any client, or none.
    pub(super) fn is_busy(shared: &Shared) -> bool {
        !matches!(*lock(&shared.job_slot), JobSlot::Idle)
    }

    pub(super) fn motion_state(&self) -> u8 {
        self.motion.as_ref().map_or(InterpolatorState::IDLE, |motion| motion.state)
    }

    fn check_alarms(&mut self, shared: &Shared) {
        let alarm = shared.stopping_alarm();
        let state = self.unit.state();
        match alarm {
            Some(alarm) if !matches!(state, PackmlState::Aborting | PackmlState::Aborted | PackmlState::Clearing) => {
                self.reason = Reason { text: alarm.text, alarm: alarm.number, remedy: alarm.remedy };
                self.by_alarm = true;
                self.end_run(shared);
                self.command(shared, Command::Abort);
            }
            Some(alarm) if self.reason.alarm == 0 && !self.needs_clear => {
                self.reason = Reason { text: alarm.text, alarm: alarm.number, remedy: alarm.remedy };
                self.by_alarm = true;
            }
            // Another client has reset the machine.
            None if state == PackmlState::Aborted && self.by_alarm && !self.needs_clear => {
                self.by_alarm = false;
                self.command(shared, Command::Clear);
            }
            _ => {}
        }
    }

    /// Another client holds the feed, or lets go of it.
    fn check_hold(&mut self, shared: &Shared) {
        if !Self::is_busy(shared) {
            return;
        }
        match (self.unit.state(), self.motion_state()) {
            (PackmlState::Execute, InterpolatorState::HOLDING | InterpolatorState::HELD) => {
                self.reason = Reason::new("the feed is held");
                self.cause = Some(SuspensionCause::Feed);
                self.command(shared, Command::Hold);
            }
            (PackmlState::Held, InterpolatorState::UNHOLDING | InterpolatorState::EXECUTING) => {
                self.command(shared, Command::Unhold);
            }
            (PackmlState::Suspended, InterpolatorState::UNHOLDING | InterpolatorState::EXECUTING)
                if self.cause == Some(SuspensionCause::Command) =>
            {
                self.command(shared, Command::Unsuspend);
            }
            _ => {}
        }
    }

    /// Performs the action of the present state.
    fn act(&mut self, shared: &Arc<Shared>) {
        let busy = Self::is_busy(shared);
        let inside = self.is_inside();
        if self.run.is_some() && !shared.active.load(Ordering::Acquire) {
            self.reason = Reason::new("the node is not active any more");
            self.end_run(shared);
            self.command(shared, Command::Stop);
        }
        match self.unit.state() {
            PackmlState::Resetting | PackmlState::Starting | PackmlState::Completing => self.complete(shared),
            PackmlState::Execute => self.produce(shared),
            PackmlState::Holding => self.stop_feed(shared, busy, inside),
            PackmlState::Suspending if self.cause == Some(SuspensionCause::Loading) => self.complete(shared),
            PackmlState::Suspending => self.stop_feed(shared, busy, inside),
            PackmlState::Unsuspending if self.cause == Some(SuspensionCause::Loading) => self.complete(shared),
            PackmlState::Unholding | PackmlState::Unsuspending => self.release_feed(shared, busy),
            PackmlState::Suspended => self.load(shared),
            PackmlState::Stopping if !busy && !inside => self.complete(shared),
            PackmlState::Aborting if !busy => self.complete(shared),
            PackmlState::Clearing => self.clear(shared),
            _ => {}
        }
    }

    fn stop_feed(&mut self, shared: &Shared, busy: bool, inside: bool) {
        match (busy, self.motion_state()) {
            (true, InterpolatorState::HELD) => self.complete(shared),
            (true, InterpolatorState::HOLDING) => {}
            // The client that held it has released it.
            (true, _) if self.cause == Some(SuspensionCause::Feed) => self.complete(shared),
            // A job that is being planned, or whose part is put in, is held once it moves.
            (true, _) => self.devices.ask(DeviceRequest::Hold(true)),
            (false, _) if !inside => self.complete(shared),
            (false, _) => self.substate = "the loader is inside and finishes its work".into(),
        }
    }

    fn release_feed(&mut self, shared: &Shared, busy: bool) {
        match (busy, self.motion_state()) {
            (true, InterpolatorState::HELD | InterpolatorState::HOLDING) => {
                self.devices.ask(DeviceRequest::Hold(false));
            }
            (true, InterpolatorState::UNHOLDING) => {}
            _ => {
                self.cause = None;
                self.reason = Reason::default();
                self.complete(shared);
            }
        }
    }

    /// Alarms are reset; nothing moves.
    fn clear(&mut self, shared: &Shared) {
        if self.waited_s() > CLEARING_S {
            self.devices.answered(DeviceRequest::Reset);
            return self.refuse_clear(shared, "the machine or the axis interpolator does not answer");
        }
        if shared.stopping_alarm().is_some() {
            self.devices.ask(DeviceRequest::Reset);
            return;
        }
        // Who executes has to hear of it too, or it would refuse what comes next.
        let is_alive = self.motion_at.is_some_and(|at| at.elapsed() < ALIVE_FOR);
        if is_alive && self.motion_state() == InterpolatorState::FAULT {
            return;
        }
        self.needs_clear = false;
        self.by_alarm = false;
        self.reason = Reason::default();
        self.complete(shared);
        self.answer_clear(true, "the alarms are cleared; nothing moves before RESET and START");
    }

    pub(super) fn answer_clear(&mut self, success: bool, message: &str) {
        if let Some(responder) = self.clearing.take() {
            let state = self.unit.state() as u8;
            responder.send(&CellCommandResponse { success, message: message.to_owned(), state });
        }
    }

    /// Back to where only a reset leads out.
    fn refuse_clear(&mut self, shared: &Shared, message: &str) {
        let remedy = std::mem::take(&mut self.reason.remedy);
        self.reason = Reason { text: format!("the reset was refused: {message}"), remedy, ..self.reason };
        self.command(shared, Command::Abort);
        self.complete(shared);
        let refused = self.reason.text.clone();
        self.answer_clear(false, &refused);
    }

    fn answered(&mut self, shared: &Shared, asked: DeviceRequest, success: bool, message: &str) {
        self.devices.answered(asked);
        match asked {
            DeviceRequest::Reset if !success && self.unit.state() == PackmlState::Clearing => {
                self.refuse_clear(shared, message);
            }
            DeviceRequest::Chuck(_) if !success => self.answer_chuck(false, message),
            DeviceRequest::Door(_) if !success => {
                self.substate = format!("door {message}");
                self.is_door_refused = true;
            }
            _ => {}
        }
    }

    /// Updates the cell from the state of the planner's jobs.
    fn job(&mut self, shared: &Arc<Shared>, status: &JobStatus) {
        let was_in_job = self.in_job;
        self.in_job = matches!(status.state, JobStatus::EXECUTING | JobStatus::STOPPING);
        match status.state {
            JobStatus::EXECUTING => {
                if self.run.is_none() && !was_in_job {
                    // A job of `~/run_job` is a run of one part.
                    self.parts = (1, 0);
                }
                self.job.clone_from(&status.job);
                self.is_machined = true;
                self.substate = format!("job {}", status.job);
                self.begin_execution(shared);
            }
            JobStatus::STOPPING if self.run.is_none() => {
                self.reason = Reason::new("the job is being stopped");
                self.command(shared, Command::Stop);
            }
            JobStatus::COMPLETE => self.part_is_done(shared, status),
            JobStatus::STOPPED => {
                self.end_run(shared);
                // Who said STOP or ABORT has given his reason.
                if self.unit.would(Command::Stop).is_ok() {
                    self.reason = Reason::new(status.message.clone());
                    self.command(shared, Command::Stop);
                }
            }
            JobStatus::ABORTED => {
                self.end_run(shared);
                if self.unit.would(Command::Abort).is_ok() {
                    self.reason = Reason::new(status.message.clone());
                    self.command(shared, Command::Abort);
                }
            }
            _ => {}
        }
    }

    /// A job of `~/run_job` takes the way that commands would have taken.
    fn begin_execution(&mut self, shared: &Shared) {
        if self.run.is_some() {
            return;
        }
        self.reason = Reason::default();
        if self.unit.state() == PackmlState::Aborted && self.command(shared, Command::Clear) {
            self.complete(shared);
        }
        if self.command(shared, Command::Reset) {
            self.complete(shared);
        }
        if self.command(shared, Command::Start) {
            self.complete(shared);
        }
    }

    /// Who may start something in addition to the cell itself.
    fn set_gate(&self, shared: &Shared) {
        let mode = self.unit.mode();
        let state = self.unit.state();
        let both = match &self.run {
            Some(run) => Some(format!("the cell runs {run}; STOP it first")),
            None if self.needs_clear => Some(format!("the cell is {state}: {}; CLEAR it first", self.reason.text)),
            None => None,
        };
        let jobs = both.clone().or_else(|| {
            (!mode.produces()).then(|| format!("the cell is in {mode} mode, in which no job runs (~/set_cell_mode)"))
        });
        let mut gate = lock(&shared.cell.gate);
        (gate.jobs, gate.set_up) = (jobs, both);
        gate.has_run = self.run.is_some();
    }
}
