// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Inputs of the cyclic thread between two ticks: chunks, commands, faults, resets, parts, and orders for door and chuck.

use super::area_order::AreaOrder;
use super::bounds::PENDING_COMMANDS;
use super::cyclic_loop::CyclicLoop;
use super::messages::{CyclicInput, Inbound, MachineOrder, Outbound, TimedCommand};
use super::part::{BarRefused, LobeRefused};
use super::stream_state::StreamState;
use camwright::machine::alarm::{AlarmKind, NO_TICK};
use camwright::simulation::MachineCommand;
use camwright::simulation::buffer::ChunkError;
use camwright::simulation::fault::Fault;
use camwright::simulation::work_area::LoadingRefused;
use camwright_files::convert::setpoints::ChunkBuffer;
use std::sync::atomic::Ordering;
use std::time::Instant;

impl CyclicLoop {
    /// Handles the messages that have come, in their order. Returns whether there was one.
    pub fn receive(&mut self) -> bool {
        let mut is_addressed = false;
        while let Some(message) = self.inbound.receive() {
            is_addressed = true;
            match message {
                Inbound::Chunk(writer, chunk) => self.apply_chunk(writer, chunk),
                Inbound::NoChunk(writer) => self.skip_chunk(writer),
                Inbound::Command(writer, command) => self.apply_command(writer, command),
                Inbound::Fault(asked) => {
                    let is_order = matches!(asked.fault, Fault::EStop(_)) && asked.job_tick == 0;
                    self.faults.add(asked.fault, asked.job_tick);
                    self.report_applied(CyclicInput::Fault(asked));
                    self.estop_orders += u32::from(is_order);
                    if !self.active {
                        self.answer_estops();
                    }
                }
                Inbound::Reset => self.reset(),
                Inbound::Lobe(mut lobe) => {
                    let outcome = match self.machine.holds_part() {
                        Err(refused) => Err(LobeRefused::NotHeld(refused)),
                        Ok(()) if self.takes_part() => lobe.put_in(&mut self.machine),
                        Ok(()) => Err(LobeRefused::Moving),
                    };
                    if outcome.is_ok() {
                        self.measure_keyframe();
                    }
                    self.send(Outbound::LobeDone(outcome, lobe));
                }
                Inbound::Bar(mut bar) => {
                    let outcome = match self.machine.holds_part() {
                        Err(refused) => Err(BarRefused::NotHeld(refused)),
                        Ok(()) if self.takes_part() => bar.clamp(&mut self.machine),
                        Ok(()) => Err(BarRefused::Moving),
                    };
                    if outcome.is_ok() {
                        self.measure_keyframe();
                    }
                    self.send(Outbound::BarDone(outcome, bar));
                }
                Inbound::Snapshot(mut snapshot) => {
                    snapshot.update(&self.machine);
                    self.send(Outbound::Snapshot(snapshot));
                }
                Inbound::Outline(mut outline) => {
                    outline.update(&self.machine);
                    self.send(Outbound::Outline(outline));
                }
                Inbound::Area(order) => self.work_area(order),
                Inbound::Loader { inside, lost } => {
                    self.report_applied(CyclicInput::Loader { inside, lost });
                    self.machine.see_loader(inside, lost);
                }
                Inbound::Judge(is_good) => {
                    self.report_applied(CyclicInput::Judge(is_good));
                    self.machine.judge_part(is_good);
                    self.publish_persistent();
                }
                Inbound::ResetShift => {
                    self.report_applied(CyclicInput::ResetShift);
                    self.machine.reset_shift();
                    self.publish_persistent();
                }
                Inbound::Active(active) => self.set_active(active),
                Inbound::Blocked(limit_s) => self.raise_outside(AlarmKind::FeedbackBlocked, limit_s),
                Inbound::NoAuthority => self.raise_outside(AlarmKind::NoAuthority, 0.0),
                Inbound::Room(room) => self.keyframes.room = Some(room),
            }
        }
        is_addressed
    }

    /// Reports an input in its order, so that a recomputation of the run applies it in the same tick.
    pub fn report_applied(&mut self, input: CyclicInput) {
        self.send(Outbound::Applied(input));
    }

    /// No chunk is taken any more.
    pub fn close(&mut self) {
        self.report_applied(CyclicInput::Close);
        self.buffer.close();
    }

    fn apply_chunk(&mut self, writer: [u8; 16], chunk: Box<ChunkBuffer>) {
        if self.state.has_holder && self.state.holder != writer {
            self.machine.raise(AlarmKind::SecondWriter, 0.0, 0.0);
            let holder = self.state.holder;
            self.send(Outbound::SecondWriter { holder, refused: writer, chunk });
            return;
        }
        self.partners.renew_sender();
        if self.losing > 0 {
            self.losing -= 1;
            self.lost = Some(Instant::now());
            self.send(Outbound::Used(writer, chunk));
            return;
        }
        match self.buffer.accept(&chunk.as_chunk(), self.machine.tick()) {
            Ok(()) => {
                self.partners.attends = false;
                let lead_ticks = chunk.first_tick.saturating_sub(self.machine.tick());
                self.bounds.min_lead_ticks.fetch_min(lead_ticks, Ordering::Relaxed);
                if !self.state.has_holder {
                    self.state.has_holder = true;
                    self.state.holder = writer;
                    self.state.news = true;
                }
                self.send(Outbound::Used(writer, chunk));
            }
            Err(error @ ChunkError::Lost { first_tick, expected }) => {
                self.machine.raise(AlarmKind::SetpointsLost, first_tick as f64, expected as f64);
                self.buffer.close();
                self.send(Outbound::Refused(error, writer, chunk));
            }
            Err(error) => {
                // A closed buffer says that an alarm is active already: not another one.
                if error != ChunkError::Closed {
                    self.machine.raise(AlarmKind::ChunkRefused, chunk.first_tick as f64, 0.0);
                    self.buffer.close();
                }
                self.send(Outbound::Refused(error, writer, chunk));
            }
        }
    }

    /// Rejects a malformed chunk like one that cannot be followed.
    fn skip_chunk(&mut self, writer: [u8; 16]) {
        self.report_applied(CyclicInput::NoChunk(writer));
        if self.state.has_holder && self.state.holder != writer {
            self.machine.raise(AlarmKind::SecondWriter, 0.0, 0.0);
        } else if !self.is_stopped_by_alarm() {
            self.machine.raise(AlarmKind::ChunkRefused, NO_TICK, 0.0);
            self.buffer.close();
        }
    }

    fn apply_command(&mut self, writer: [u8; 16], command: TimedCommand) {
        self.report_applied(CyclicInput::Command(writer, command));
        if self.state.has_holder && self.state.holder != writer {
            self.machine.raise(AlarmKind::SecondWriter, 0.0, 0.0);
            return;
        }
        self.partners.renew_sender();
        if command.sequence == 1 {
            self.state.commands_received = 0;
        }
        let expected = self.state.commands_received + 1;
        if command.sequence != expected {
            self.machine.raise(AlarmKind::CommandGap, f64::from(command.sequence), f64::from(expected));
            return;
        }
        if command.order == MachineOrder::Attend {
            self.partners.attends = self.buffer.is_spent() && !self.is_stopped_by_alarm();
            return self.acknowledge(command.sequence);
        }
        let executed = self.machine.tick();
        if command.tick <= executed {
            self.machine.raise(AlarmKind::LateCommand, (executed + 1 - command.tick) as f64, 0.0);
            return;
        }
        if let MachineOrder::Machine(MachineCommand::SetHome { axis, counts }) = command.order {
            self.buffer.schedule_home(command.tick, axis, counts);
        }
        let Some(place) = self.commands.iter_mut().find(|place| place.is_none()) else {
            self.machine.raise(AlarmKind::CommandGap, f64::from(command.sequence), f64::from(expected));
            return;
        };
        *place = Some(command);
        self.acknowledge(command.sequence);
    }

    /// A command has been taken.
    fn acknowledge(&mut self, sequence: u32) {
        self.state.commands_received = sequence;
        self.state.news = true;
        // The sender waits for this before it sends setpoints beyond the command's tick.
        self.publish_receipt();
    }

    /// Publishes the receipt of a command in the stream at once, without executing a tick.
    pub fn publish_receipt(&mut self) {
        if let Some(report) = self.last_report {
            self.send(Outbound::Tick(report, StreamState { only_stream: true, ..self.state }));
            self.state.news = false;
        }
    }

    fn reset(&mut self) {
        self.report_applied(CyclicInput::Reset);
        let outcome = self.machine.reset();
        if outcome.is_ok() {
            self.buffer.open(self.machine.setpoint());
            self.commands = [None; PENDING_COMMANDS];
            self.job_running = false;
            self.lost = None;
            self.partners.attends = false;
            self.faults.end_job();
            self.state = StreamState { news: true, alarms_reset: true, ..StreamState::default() };
        }
        self.answer_reset();
        // Of one that was refused there is nothing to show.
        let shows = self.active && outcome.is_ok();
        self.reset_done = Some(outcome);
        if !shows {
            self.answer_reset();
        }
    }

    /// Who asked for a reset hears of it once a tick has shown it: what it starts next, others let it start.
    pub fn answer_reset(&mut self) {
        if let Some(outcome) = self.reset_done.take() {
            self.send(Outbound::ResetDone(outcome));
        }
    }

    /// Answers the orders of the emergency stop once a tick has applied them: a reset behind the answer finds them.
    pub fn answer_estops(&mut self) {
        for _ in 0..std::mem::take(&mut self.estop_orders) {
            self.send(Outbound::EStopDone);
        }
    }

    /// Works door, chuck or part of a machine that takes no setpoints.
    fn work_area(&mut self, order: AreaOrder) {
        self.report_applied(CyclicInput::Area(order));
        let outcome = match order {
            _ if self.buffer.has_setpoints() => Err(LoadingRefused::Moving),
            AreaOrder::Door(open) => self.machine.order_door(open),
            AreaOrder::Chuck(open) => self.machine.order_chuck(open),
            AreaOrder::Part(put_in) => self.machine.change_part(put_in),
        };
        self.answer_area();
        self.area_done = Some((order, outcome));
        if !self.active {
            self.answer_area();
        }
    }

    /// Who asked for door, chuck or part hears of it once a tick has shown it.
    pub fn answer_area(&mut self) {
        if let Some((order, outcome)) = self.area_done.take() {
            self.send(Outbound::AreaDone(order, outcome));
        }
    }

    /// Loading and copying the part are the only places where this thread allocates: a part is taken at rest only.
    fn takes_part(&self) -> bool {
        self.machine.is_at_rest() && !self.buffer.has_setpoints()
    }
}
