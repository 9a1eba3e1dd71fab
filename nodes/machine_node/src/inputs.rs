// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Inputs of the machine, published in the order in which its cyclic thread applied them: `machine/inputs`.
//!
//! The cyclic thread only hands on what it took; tick and digests are made here, in the pump, which sees ticks and inputs in their order.

use camwright::machine::description::MachineDescription;
use camwright::machine::persistent_state::PersistentState;
use camwright::simulation::tick_report::TickReport;
use camwright_files::convert::time::TickClock;
use camwright_files::record_text::record_text as text;
use camwright_machine_cycle::commands;
use camwright_machine_cycle::input_record::{
    BeginRecord, FORMAT, VERSION, bar_message, check, chunk_message, digest_message, lobe_message,
};
use camwright_machine_cycle::messages::{CyclicInput, Outbound};
use camwright_machine_cycle::output_digest::OutputDigest;
use camwright_machine_cycle::persistent_record::PersistentRecord;
use camwright_machine_cycle::stream_state::StreamState;
use camwright_msgs::camwright_msgs::msg::{MachineInput, MachineKeyframe};
use camwright_ros::{Node, Publisher, Qos, RosError};

/// Inputs that a late reader still gets: a recorder that comes when the machine runs already.
const DEPTH: u32 = 4000;

#[derive(Debug)]
pub(super) struct InputOutlet {
    publisher: Publisher<MachineInput>,
    machine: MachineDescription,
    clock: TickClock,
    sequence: u64,
    tick: u64,
    digest: OutputDigest,
}

impl InputOutlet {
    pub(super) fn new(node: &Node, machine: &MachineDescription, clock: TickClock) -> Result<Self, RosError> {
        let publisher = node.publisher("machine/inputs", &Qos::latched(DEPTH))?;
        let (machine, digest) = (machine.clone(), OutputDigest::default());
        Ok(Self { publisher, machine, clock, sequence: 0, tick: 0, digest })
    }

    pub(super) fn begin(&mut self, lasting: &PersistentState, drives: Option<&'static str>) -> Result<(), RosError> {
        let content = text(&BeginRecord {
            format: FORMAT,
            version: VERSION.to_owned(),
            machine_hash: self.machine.hash.clone(),
            lasting: PersistentRecord::from(lasting),
            drives: drives.map(str::to_owned),
        });
        self.publish(MachineInput { kind: MachineInput::BEGIN, content, ..MachineInput::default() })
    }

    /// A tick was executed.
    pub(super) fn tick(&mut self, report: &TickReport, state: &StreamState) -> Result<(), RosError> {
        self.tick = report.tick;
        let digests = self.digest.add(report, state);
        digests.into_iter().flatten().try_for_each(|digests| self.publish(digest_message(&digests)))
    }

    /// Tick and identity of the next keyframe.
    pub(super) fn head(&self) -> MachineKeyframe {
        let (digest, job_tick) = self.digest.parts();
        let (stamp, tick, sequence) = (self.clock.stamp(self.tick), self.tick, self.sequence);
        MachineKeyframe { stamp, tick, sequence, job_tick, digest, ..MachineKeyframe::default() }
    }

    /// Publishes the inputs in a report of the cyclic thread.
    pub(super) fn see(&mut self, report: &Outbound) -> Result<(), RosError> {
        let message = match report {
            Outbound::Used(writer, chunk)
            | Outbound::Refused(_, writer, chunk)
            | Outbound::SecondWriter { refused: writer, chunk, .. } => chunk_message(*writer, chunk),
            Outbound::LobeDone(_, lobe) => lobe_message(lobe),
            Outbound::BarDone(_, bar) => bar_message(bar),
            Outbound::Applied(input) => self.message(input),
            _ => return Ok(()),
        };
        self.publish(message)
    }

    fn message(&self, input: &CyclicInput) -> MachineInput {
        let plain = |kind: u8| MachineInput { kind, ..MachineInput::default() };
        match input {
            CyclicInput::NoChunk(writer) => MachineInput { writer: *writer, ..plain(MachineInput::NO_CHUNK) },
            CyclicInput::Command(writer, command) => {
                let content = text(&commands::message(command, &self.machine));
                MachineInput { writer: *writer, content, ..plain(MachineInput::COMMAND) }
            }
            CyclicInput::Fault(asked) => MachineInput { content: text(&asked.request), ..plain(MachineInput::FAULT) },
            CyclicInput::Reset => plain(MachineInput::RESET),
            CyclicInput::Area(order) => {
                MachineInput { content: order.service().to_owned(), ..plain(MachineInput::WORK_AREA) }
            }
            CyclicInput::Loader { inside, lost } => {
                let number = u64::from(*inside) + 2 * u64::from(*lost);
                MachineInput { number, ..plain(MachineInput::LOADER) }
            }
            CyclicInput::Judge(is_good) => MachineInput { number: u64::from(*is_good), ..plain(MachineInput::JUDGE) },
            CyclicInput::ResetShift => plain(MachineInput::RESET_SHIFT),
            CyclicInput::Close => plain(MachineInput::CLOSE),
            CyclicInput::Open => plain(MachineInput::OPEN),
            CyclicInput::Alarm(kind, value) => {
                let number = u64::from(kind.entry().number);
                MachineInput { number, values: vec![*value], ..plain(MachineInput::ALARM) }
            }
        }
    }

    fn publish(&mut self, message: MachineInput) -> Result<(), RosError> {
        let (stamp, tick, sequence) = (self.clock.stamp(self.tick), self.tick, self.sequence);
        self.sequence += 1;
        let mut message = MachineInput { stamp, tick, sequence, ..message };
        message.check = check(&message).unwrap_or_default();
        self.publisher.publish(&message)
    }
}
