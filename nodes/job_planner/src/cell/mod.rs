// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The cell as a unit of PackML: what it is doing, who may make it do what, parts one after the other with the robot that loads them.
//!
//! ```text
//!  services, topics, jobs ──► mailbox ──► cell thread: CellController ──► ~/cell_state, ~/loading
//!                                            │  commands.rs    what is asked of the cell
//!                                            │  production.rs  parts, and the handshake between them
//!                                            └► door, chuck, feed hold, reset, jobs: by services and goals like everybody else's
//! ```
//! It decides nothing that moves an axis: a job of a run is planned and executed like one of `~/run_job`.

mod commands;
mod controller;
mod devices;
mod production;
mod publisher;
mod run;
mod state_messages;

use super::{Shared, lock, wait_for};
use camwright_authority::{Grant, OneSender, subscribe_to_machine};
use camwright_msgs::camwright_msgs::msg::{InterpolatorState, JobStatus, LoaderState, MachineCounters, WorkArea};
use camwright_msgs::camwright_msgs::srv::{
    CellCommand, CellCommandRequest, CellCommandResponse, SetCellMode, SetCellModeResponse,
};
use camwright_msgs::std_srvs::srv::{Trigger, TriggerResponse};
use camwright_ros::liveness;
use camwright_ros::running::join_within;
use camwright_ros::{Node, Qos, Responder, RosError, ServiceHandle, Subscription};
use controller::CellController;
use devices::DeviceRequest;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, mpsc};
use std::thread::JoinHandle;
use std::time::Duration;

/// Event for the cell thread.
pub(super) enum CellEvent {
    Command(CellCommandRequest, Responder<CellCommand>),
    Mode(u8, Responder<SetCellMode>),
    /// Open the chuck, or close it.
    Chuck(bool, Responder<Trigger>),
    Job(Box<JobStatus>),
    /// The job of a part was not started.
    PartRefused(String),
    WorkArea(WorkArea),
    Loader(LoaderState),
    Motion(Box<InterpolatorState>),
    Counters(MachineCounters),
    /// The alarms are others.
    Alarms,
    /// Who was asked for something has answered.
    Answered(DeviceRequest, bool, String),
    End,
}

/// Who is kept from starting something, and why.
#[derive(Debug, Default, Clone)]
struct StartConditions {
    jobs: Option<String>,
    set_up: Option<String>,
    has_run: bool,
}

/// Interface of the cell to the rest of the planner.
#[derive(Debug)]
pub(super) struct CellInterface {
    mailbox: mpsc::Sender<CellEvent>,
    gate: Mutex<StartConditions>,
    /// Door, chuck and sensors of a machine that has some.
    area: Mutex<Option<WorkArea>>,
    /// True after the interpolator has published its state, which it does once it has received the machine's messages.
    interpolator_changed: Mutex<bool>,
    changed: Condvar,
    /// A part of the cell's own run may be begun.
    wants_part: AtomicBool,
    thread: Mutex<Option<JoinHandle<Option<()>>>>,
}

impl CellInterface {
    /// The cell, and what it will hear.
    pub(super) fn new() -> (Self, mpsc::Receiver<CellEvent>) {
        let (mailbox, inbox) = mpsc::channel();
        let (gate, area, interpolator_changed, changed, wants_part, thread) = Default::default();
        (Self { mailbox, gate, area, interpolator_changed, changed, wants_part, thread }, inbox)
    }

    /// Sender for events.
    pub(super) fn mailbox(&self) -> mpsc::Sender<CellEvent> {
        self.mailbox.clone()
    }

    /// Sends an event to the cell; while the node ends there is no receiver.
    pub(super) fn send(&self, changed: CellEvent) {
        let _ending = self.mailbox.send(changed);
    }

    /// Why a job of another client may not begin.
    pub(super) fn keeps_jobs_out(&self) -> Option<String> {
        lock(&self.gate).jobs.clone()
    }

    /// Returns true while a run of parts is under way, between its parts too.
    pub(super) fn has_run(&self) -> bool {
        lock(&self.gate).has_run
    }

    /// Why set-up work may not begin.
    pub(super) fn keeps_set_up_out(&self) -> Option<String> {
        lock(&self.gate).set_up.clone()
    }

    /// Condition of door, chuck or work area that prevents axes and wheel from starting.
    pub(super) fn hindrance(&self) -> Option<String> {
        let area = lock(&self.area);
        area.as_ref().filter(|area| !area.may_move).map(|area| format!("nothing may start: {}", area.message))
    }

    /// Waits until the interpolator takes plans: nodes that were started together find each other in any order.
    pub(super) fn wait_for_interpolator(&self, timeout: Duration) -> Result<(), &'static str> {
        wait_for(&self.interpolator_changed, &self.changed, timeout, |has_changed| {
            has_changed
                .then_some(())
                .ok_or("no state from the axis interpolator yet; check that it runs and reaches the machine")
        })
    }

    /// Returns whether a part of the cell's own run may still be started.
    pub(super) fn wants_part(&self) -> bool {
        self.wants_part.load(Ordering::Acquire)
    }

    /// Ends its thread, within `limit`.
    pub(super) fn end(&self, limit: Duration) {
        self.send(CellEvent::End);
        let thread = lock(&self.thread).take();
        if let Some(thread) = thread {
            let _in_time = join_within(thread, limit);
        }
    }
}

/// Starts the cell's thread.
pub(super) fn start(shared: &Arc<Shared>, inbox: mpsc::Receiver<CellEvent>) -> Result<(), super::NodeError> {
    let brain = CellController::new(shared, inbox)?;
    let thread = shared.node.supervisor().spawn("cell", move || brain.run())?;
    *lock(&shared.cell.thread) = Some(thread);
    Ok(())
}

/// The services of the cell.
pub(super) fn offer(shared: &Arc<Shared>) -> Result<Vec<ServiceHandle>, RosError> {
    let node = &shared.node;
    let this = Arc::clone(shared);
    let command = node.service_deferred::<CellCommand>("~/cell_command", move |request, responder| {
        let failed = |message| CellCommandResponse { message, ..CellCommandResponse::default() };
        this.cell.send(CellEvent::Command(request, responder.or_fail(failed)));
    })?;
    let this = Arc::clone(shared);
    let mode = node.service_deferred::<SetCellMode>("~/set_cell_mode", move |request, responder| {
        let failed = |message| SetCellModeResponse { message, ..SetCellModeResponse::default() };
        this.cell.send(CellEvent::Mode(request.mode, responder.or_fail(failed)));
    })?;
    let chuck = |name: &str, open: bool| {
        let this = Arc::clone(shared);
        node.service_deferred::<Trigger>(name, move |_, responder| {
            let failed = |message| TriggerResponse { success: false, message };
            this.cell.send(CellEvent::Chuck(open, responder.or_fail(failed)));
        })
    };
    Ok(vec![command, mode, chuck("~/open_chuck", true)?, chuck("~/close_chuck", false)?])
}

/// Subscriptions of the cell in addition to the planner's own.
pub(super) fn subscriptions(shared: &Arc<Shared>, grant: &Arc<Grant>) -> Result<Vec<Subscription>, RosError> {
    let node: &Node = &shared.node;
    let this = Arc::clone(shared);
    // Every change counts: an exchange is known by the empty chuck in between.
    let every = Qos::latched(1).keep_last(64);
    let area = subscribe_to_machine::<WorkArea>(node, grant, "machine/work_area", (&every, 64), move |area, _| {
        *lock(&this.cell.area) = Some(area.clone());
        this.cell.send(CellEvent::WorkArea(area));
    })?;
    let this = Arc::clone(shared);
    let mut one_loader = OneSender::new("loader/state", liveness::limit(node));
    let loader = node.subscribe::<LoaderState>("loader/state", &Qos::default_topic(), move |loader, info| {
        if !one_loader.accepts(&info.writer, &this.node) {
            return;
        }
        this.cell.send(CellEvent::Loader(loader));
    })?;
    let this = Arc::clone(shared);
    let motion =
        node.subscribe::<InterpolatorState>("axis_interpolator/state", &Qos::latched(1), move |state, info| {
            this.interpolator.receive(info.writer);
            *lock(&this.cell.interpolator_changed) = true;
            this.cell.changed.notify_all();
            this.cell.send(CellEvent::Motion(Box::new(state)));
        })?;
    let this = Arc::clone(shared);
    let latched = (&Qos::latched(1), 1);
    let counters =
        subscribe_to_machine::<MachineCounters>(node, grant, "machine/counters", latched, move |counters, _| {
            this.cell.send(CellEvent::Counters(counters));
        })?;
    Ok(vec![area, loader, motion, counters])
}
