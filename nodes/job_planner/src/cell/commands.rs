// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Commands to the cell: accepted, or refused with the reason and the holder of command.

use super::Shared;
use super::controller::{CellController, Reason, SuspensionCause};
use super::devices::DeviceRequest;
use super::run::{PartPhase, PartsRun};
use crate::settings;
use camwright::cell::packml::{Command, Mode};
use camwright_msgs::camwright_msgs::msg::InterpolatorState;
use camwright_msgs::camwright_msgs::srv::{
    CellCommand, CellCommandRequest, CellCommandResponse, SetCellMode, SetCellModeResponse,
};
use camwright_ros::Responder;
use std::sync::Arc;
use std::sync::atomic::Ordering;

impl CellController {
    pub(super) fn commanded(
        &mut self,
        shared: &Arc<Shared>,
        request: CellCommandRequest,
        responder: Responder<CellCommand>,
    ) {
        let outcome = match Command::from_number(request.command) {
            Some(command) => self.obey(shared, command, request).map(|()| command),
            None => Err(format!("there is no command {}; allowed: 1 (RESET) to 9 (CLEAR)", request.command)),
        };
        match outcome {
            // Answered when the machine has answered.
            Ok(Command::Clear) => self.clearing = Some(responder),
            Ok(_) => {
                let state = self.unit.state() as u8;
                responder.send(&CellCommandResponse { success: true, message: String::new(), state });
            }
            Err(message) => {
                let state = self.unit.state() as u8;
                responder.send(&CellCommandResponse { success: false, message, state });
            }
        }
    }

    fn obey(&mut self, shared: &Arc<Shared>, command: Command, request: CellCommandRequest) -> Result<(), String> {
        let with_holder = |text: String| match self.holder(shared) {
            holder if holder.is_empty() => text,
            holder => format!("{text}; {holder} has command"),
        };
        if !shared.active.load(Ordering::Acquire) {
            return Err("the node is not active".into());
        }
        self.unit.would(command).map_err(|refused| with_holder(refused.to_string()))?;
        match command {
            Command::Start => {
                let run = self.new_run(shared, request).map_err(with_holder)?;
                self.parts = (run.wanted, 0);
                self.job.clone_from(&run.job);
                self.run = Some(run);
                self.reason = Reason::default();
            }
            Command::Stop => {
                self.reason = Reason::new("STOP was commanded");
                self.end_run(shared);
                shared.cancel();
            }
            Command::Abort => {
                self.reason = Reason {
                    text: "ABORT was requested".into(),
                    alarm: 0,
                    remedy: "CLEAR when the cell is at rest".into(),
                };
                self.needs_clear = true;
                self.end_run(shared);
                shared.cancel();
            }
            Command::Hold => self.reason = Reason::new("HOLD was commanded"),
            Command::Suspend => {
                self.cause = Some(SuspensionCause::Command);
                self.reason = Reason::new("SUSPEND was commanded");
            }
            Command::Clear if self.is_inside() => {
                return Err("the reset was rejected: a person is in the work area; clear it first".into());
            }
            Command::Unsuspend if self.cause == Some(SuspensionCause::Loading) => {
                return Err(format!("the cell waits for the loader, not for a command: {}", self.substate));
            }
            Command::Unhold | Command::Unsuspend | Command::Reset | Command::Clear => {}
        }
        // What was said counts from now on.
        self.cause = self.cause.filter(|cause| *cause != SuspensionCause::Feed);
        if self.command(shared, command) {
            if command == Command::Hold || command == Command::Suspend {
                self.hold_feed(shared);
            }
            Ok(())
        } else {
            Err(format!("the cell is {}", self.unit.state()))
        }
    }

    fn hold_feed(&mut self, shared: &Shared) {
        if Self::is_busy(shared) && self.motion_state() == InterpolatorState::EXECUTING {
            self.devices.ask(DeviceRequest::Hold(true));
        }
    }

    /// A run as it was asked for, if nothing stands in its way.
    fn new_run(&self, shared: &Arc<Shared>, request: CellCommandRequest) -> Result<PartsRun, String> {
        if Self::is_busy(shared) {
            return Err("START is not taken while something else runs".into());
        }
        let moving = self.motion.as_ref().filter(|motion| motion.state != InterpolatorState::IDLE);
        if moving.is_some() {
            return Err("START is rejected while another client moves the axes".into());
        }
        if let Some(alarm) = shared.stopping_alarm() {
            return Err(format!("alarm {} needs CLEAR: {}; {}", alarm.number, alarm.text, alarm.remedy));
        }
        if self.is_inside() {
            return Err("START is rejected while a person is in the work area".into());
        }
        let is_automatic = self.unit.mode() == Mode::Automatic;
        if let Some(area) = self.area.as_ref().filter(|_| !is_automatic) {
            if !area.may_move {
                return Err(format!("nothing may start: {}", area.message));
            }
            if !area.part_present {
                return Err("no part in the chuck; in semi-automatic mode load it by hand".into());
            }
        }
        let usual = u32::try_from(shared.node.parameters().integer(settings::CELL_PARTS)).unwrap_or(0);
        let wanted = match request.parts {
            _ if !is_automatic => 1,
            0 => usual,
            parts => parts,
        };
        let loads = is_automatic && self.area.is_some();
        let (job, overrides) = shared.wanted(&request.job, &request.overrides);
        Ok(PartsRun { job, overrides, wanted, done: 0, loads, phase: PartPhase::Part })
    }

    pub(super) fn select(&mut self, shared: &Shared, mode: u8, responder: Responder<SetCellMode>) {
        let outcome = match Mode::from_number(mode) {
            None => Err(format!("there is no mode {mode}; allowed: 1 to 4")),
            Some(_) if Self::is_busy(shared) => Err(format!("the mode changes at rest; {}", self.holder(shared))),
            Some(mode) => self.unit.select(mode).map_err(|refused| refused.to_string()),
        };
        self.publish(shared);
        let (success, message) = match outcome {
            Ok(()) => (true, String::new()),
            Err(message) => (false, message),
        };
        responder.send(&SetCellModeResponse { success, message });
    }
}
