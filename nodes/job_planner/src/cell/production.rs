// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A production run: part after part, with the handshake that brings each in and out.

use super::controller::{CellController, Reason, SuspensionCause};
use super::devices::DeviceRequest;
use super::run::PartPhase;
use super::{Shared, lock};
use crate::settings;
use camwright::cell::loading::{
    Handshake, HandshakeGoal, HandshakeProgress, HandshakeRequest, HandshakeStep, LoaderState, LoadingCommand,
    LoadingInputs, Timeouts, Wait,
};
use camwright::cell::packml::{Command, PackmlState};
use camwright::simulation::work_area::ActuatorPosition;
use camwright_msgs::camwright_msgs::msg::{JobStatus, WorkArea};
use camwright_msgs::std_srvs::srv::{Trigger, TriggerResponse};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Position of a door or a chuck in a message.
fn place(number: u8) -> ActuatorPosition {
    match number {
        WorkArea::CLOSED => ActuatorPosition::Closed,
        WorkArea::OPENING => ActuatorPosition::Opening,
        WorkArea::OPEN => ActuatorPosition::Open,
        _ => ActuatorPosition::Closing,
    }
}

/// Returns whether every tolerance was kept; `None`: nothing was judged.
fn is_good(status: &JobStatus) -> Option<bool> {
    if status.lobes.is_empty() && status.turned.is_empty() {
        return None;
    }
    let lobes = status.lobes.iter().all(|lobe| lobe.form_error_max.abs() <= lobe.form_error_allowed);
    Some(lobes && status.turned.iter().all(|part| part.form_error_max.abs() <= part.form_error_allowed))
}

impl CellController {
    fn timeouts(shared: &Shared) -> Timeouts {
        let of = |name: &str| shared.node.parameters().double(name);
        Timeouts {
            machine_s: of(settings::LOADING_MACHINE),
            enter_s: of(settings::LOADING_ENTER),
            inside_s: of(settings::LOADING_INSIDE),
        }
    }

    /// The robot while its signals arrive.
    pub(super) fn loader_state(&self, shared: &Shared) -> Option<LoaderState> {
        let max_s = shared.node.parameters().double(settings::LOADER_TIMEOUT);
        let (loader, _) = self.loader.as_ref().filter(|(_, at)| at.elapsed().as_secs_f64() <= max_s)?;
        Some(LoaderState {
            available: loader.available,
            inside: loader.in_work_area,
            busy: loader.busy,
            has_fault: !loader.fault.is_empty(),
        })
    }

    /// A person or a silent loader is in the work area.
    pub(super) fn is_inside(&self) -> bool {
        let area = self.area.as_ref();
        area.is_some_and(|area| area.entered || self.loader.as_ref().is_some_and(|(loader, _)| loader.in_work_area))
    }

    pub(super) fn seen(&self, shared: &Shared) -> LoadingInputs {
        let area = self.area.clone().unwrap_or_default();
        LoadingInputs {
            now_s: self.real_s(),
            door: place(area.door),
            chuck: place(area.chuck),
            part_present: area.part_present,
            entered: area.entered,
            is_safe: area.safe_to_enter,
            loader: self.loader_state(shared),
        }
    }

    /// Starts the next action of a run.
    pub(super) fn produce(&mut self, shared: &Arc<Shared>) {
        let Some(run) = &mut self.run else {
            if !self.in_job {
                self.complete(shared);
            }
            return;
        };
        let wants = match run.phase {
            PartPhase::Part => HandshakeGoal::RawPart,
            PartPhase::Empty => HandshakeGoal::Empty,
            PartPhase::Begin => return self.begin_part(shared),
            PartPhase::Job => return,
            PartPhase::End => {
                self.substate = format!("run ended: {run}");
                self.run = None;
                return self.complete(shared);
            }
        };
        let present = self.area.as_ref().is_some_and(|area| area.part_present);
        let request = HandshakeRequest::for_goal(wants, present, self.is_machined);
        if !run.loads || request == HandshakeRequest::None {
            run.phase = if wants == HandshakeGoal::RawPart { PartPhase::Begin } else { PartPhase::End };
            return self.produce(shared);
        }
        self.handshake = Some(Handshake::begin(request, Self::timeouts(shared), self.real_s()));
        self.cause = Some(SuspensionCause::Loading);
        self.command(shared, Command::Suspend);
    }

    fn begin_part(&mut self, shared: &Arc<Shared>) {
        let is_loaded = self.run.as_ref().is_some_and(|run| run.loads);
        if is_loaded && !self.is_closed(shared) {
            return;
        }
        if let Some(run) = &mut self.run {
            run.phase = PartPhase::Job;
            shared.cell.wants_part.store(true, Ordering::Release);
            shared.run_part(run.job.clone(), run.overrides.clone());
        }
    }

    /// Door and chuck are closed, or have had their time; an open door is closed.
    fn is_closed(&mut self, shared: &Shared) -> bool {
        let Some(area) = self.area.as_ref().filter(|area| !area.may_move) else { return true };
        if area.door != WorkArea::CLOSED && !area.entered {
            self.devices.ask(DeviceRequest::Door(false));
        }
        self.waited_s() > Self::timeouts(shared).machine_s
    }

    /// The handshake, while the cell is suspended for it.
    pub(super) fn load(&mut self, shared: &Arc<Shared>) {
        if self.cause != Some(SuspensionCause::Loading) {
            return;
        }
        let seen = self.seen(shared);
        let Some(handshake) = &mut self.handshake else {
            self.command(shared, Command::Unsuspend);
            return;
        };
        let request = handshake.request();
        match handshake.advance(&seen) {
            HandshakeProgress::Going(order) => {
                let step = handshake.step();
                match order {
                    Some(LoadingCommand::OpenDoor) => self.devices.ask(DeviceRequest::Door(true)),
                    Some(LoadingCommand::CloseDoor) => self.devices.ask(DeviceRequest::Door(false)),
                    None => {}
                }
                self.is_door_refused &= order.is_some();
                if !self.is_door_refused {
                    self.substate = format!("{}, {}", request.name(), step.name());
                }
            }
            HandshakeProgress::Waiting(wait) => {
                let fault = self.loader.as_ref().map_or("", |(loader, _)| loader.fault.as_str());
                self.substate = match wait {
                    Wait::Silent => "waiting for the loader: no message on loader/state".to_owned(),
                    Wait::Unavailable => "waiting for the loader: it is not available".to_owned(),
                    Wait::Fault => format!("waiting for the loader: {fault}"),
                };
                self.reason = Reason::new(self.substate.clone());
            }
            HandshakeProgress::Done => {
                self.handshake = None;
                if let Some(run) = &mut self.run {
                    run.phase = if run.phase == PartPhase::Part { PartPhase::Begin } else { PartPhase::End };
                }
                self.reason = Reason::default();
                self.command(shared, Command::Unsuspend);
            }
            HandshakeProgress::Failed(failure) => {
                self.reason = Reason {
                    text: failure.to_string(),
                    alarm: 0,
                    remedy: "inspect the part, the loader and the door, then UNHOLD to try again, or STOP".into(),
                };
                self.substate.clone_from(&self.reason.text);
                shared.node.logger().warn(&format!("the cell is held: {failure}"));
                self.command(shared, Command::Hold);
            }
            HandshakeProgress::Uncleared => {
                self.reason = Reason {
                    text: "the loader entered the work area without permission".into(),
                    alarm: 0,
                    remedy: "bring the loader out of the work area, then CLEAR".into(),
                };
                self.needs_clear = true;
                shared.node.logger().error(&self.reason.text);
                self.end_run(shared);
                self.command(shared, Command::Abort);
            }
        }
    }

    /// The leave to enter lasts while the work area is occupied, even after the run has ended.
    pub(super) fn let_go_of_handshake(&mut self) {
        let is_needed = matches!(self.unit.state(), PackmlState::Suspending | PackmlState::Suspended);
        if !is_needed && !self.is_inside() {
            self.handshake = None;
        }
    }

    /// The run is over, however it ended.
    pub(super) fn end_run(&mut self, shared: &Shared) {
        shared.cell.wants_part.store(false, Ordering::Release);
        if let Some(run) = self.run.take() {
            self.substate = format!("run ended: {run}");
        }
    }

    pub(super) fn part_is_done(&mut self, shared: &Arc<Shared>, status: &JobStatus) {
        if let Some(good) = is_good(status) {
            self.devices.judge(good);
        }
        if let Some(run) = self.run.as_mut().filter(|run| run.phase == PartPhase::Job) {
            run.done = run.done.saturating_add(1);
            run.phase = if run.wanted > 0 && run.done >= run.wanted { PartPhase::Empty } else { PartPhase::Part };
            self.parts = (run.wanted, run.done);
        } else if self.run.is_none() {
            self.parts = (1, 1);
        }
        self.settle(shared);
    }

    /// A part of the run could not start: the operator must check.
    pub(super) fn part_refused(&mut self, shared: &Shared, reason: &str) {
        let Some(run) = &mut self.run else { return };
        run.phase = PartPhase::Begin;
        self.reason = Reason {
            text: format!("the job of the next part is refused: {reason}"),
            alarm: 0,
            remedy: "remove the cause, then UNHOLD to try again, or STOP".into(),
        };
        self.substate.clone_from(&self.reason.text);
        self.command(shared, Command::Hold);
    }

    /// Opens or closes the chuck for the robot that is inside.
    pub(super) fn work_chuck(&mut self, shared: &Shared, open: bool, responder: camwright_ros::Responder<Trigger>) {
        let state = self.unit.state();
        let refused = match &self.chuck {
            Some(_) => Some("the chuck is being worked already".to_owned()),
            None if state != PackmlState::Suspended => Some(format!("the cell is {state}")),
            None => Handshake::chuck_refused(self.handshake.as_ref(), &self.seen(shared)).map(str::to_owned),
        };
        if let Some(reason) = refused {
            return responder.send(&TriggerResponse { success: false, message: format!("refused: {reason}") });
        }
        self.chuck = Some((open, Instant::now(), responder));
        self.devices.ask(DeviceRequest::Chuck(open));
    }

    pub(super) fn answer_chuck(&mut self, success: bool, message: &str) {
        if let Some((_, _, responder)) = self.chuck.take() {
            responder.send(&TriggerResponse { success, message: message.to_owned() });
        }
    }

    /// The chuck has come to its end, or its time is over.
    pub(super) fn finish_chuck(&mut self, shared: &Shared) {
        let Some((open, since, _)) = &self.chuck else { return };
        let (wanted, message) = match open {
            true => (WorkArea::OPEN, "the chuck is open"),
            false => (WorkArea::CLOSED, "the chuck is closed"),
        };
        let max_s = shared.node.parameters().double(settings::LOADING_MACHINE);
        if self.area.as_ref().is_some_and(|area| area.chuck == wanted) {
            self.answer_chuck(true, message);
        } else if let Some(alarm) = shared.stopping_alarm() {
            self.answer_chuck(false, &format!("alarm {}: {}", alarm.number, alarm.text));
        } else if since.elapsed() > Duration::from_secs_f64(max_s) {
            self.answer_chuck(false, &format!("the chuck did not come to its end within {max_s} s"));
        }
    }

    /// The step of the handshake for people.
    pub(super) fn step(&self) -> &'static str {
        self.handshake.as_ref().map(Handshake::step).map_or("", HandshakeStep::name)
    }

    /// Holder of command of the cell; empty: none.
    pub(super) fn holder(&self, shared: &Shared) -> String {
        if let Some(run) = &self.run {
            return format!("the cell's run of {run}");
        }
        let course = lock(&shared.job_slot);
        match &*course {
            crate::job_slot::JobSlot::Idle => {}
            other => return other.to_string(),
        }
        self.motion.as_ref().map_or_else(String::new, |motion| motion.holder.clone())
    }
}
