// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A machine that runs again what it was given once, without a clock: the cyclic thread's own code, fed from a record.

use super::active_alarms::ActiveAlarms;
use super::area_order::AreaOrder;
use super::bounds::Bounds;
use super::commands;
use super::cyclic_loop::CyclicLoop;
use super::faults::asked_fault;
use super::input_record::{BeginRecord, FORMAT, alarm_of, lobe_of, record};
use super::keyframes::FORM as FORM_OF_KEYFRAMES;
use super::messages::{Inbound, Outbound};
use super::output_digest::{OutputDigest, RangeDigest};
use super::pacing::Pace;
use super::part::RawBar;
use super::stream_state::StreamState;
use camwright::machine::description::MachineDescription;
use camwright::machine::persistent_state::PersistentState;
use camwright::math::snapshot::SnapshotCodec;
use camwright::simulation::Machine;
use camwright::simulation::tick_report::TickReport;
use camwright_files::convert::setpoints::ChunkBuffer;
use camwright_msgs::camwright_msgs::msg::{MachineCommand, MachineInput, MachineKeyframe};
use camwright_threads::ring::{Receiver, Sender, Waker, ring};
use std::sync::Arc;

/// Messages between two ticks that the rings hold; what comes out is taken after each one that goes in.
const RING: usize = 1024;

/// Output of a tick.
#[derive(Debug, Clone)]
pub struct TickOutput {
    pub report: TickReport,
    /// Alarms that are active after it.
    pub alarms: Arc<ActiveAlarms>,
    /// Digests published with it.
    pub digests: [Option<RangeDigest>; 2],
}

/// The machine, run again.
pub struct MachineReplay {
    ticker: CyclicLoop,
    inlet: Sender<Inbound>,
    reports: Receiver<Outbound>,
    alarms: Arc<ActiveAlarms>,
    digest: OutputDigest,
}

impl std::fmt::Debug for MachineReplay {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MachineReplay").field("digest", &self.digest).finish_non_exhaustive()
    }
}

impl MachineReplay {
    /// The machine as a run began.
    ///
    /// # Errors
    /// A record of another program or another machine, or one that cannot be read.
    pub fn new(description: &MachineDescription, begin: &MachineInput) -> Result<Self, String> {
        let begun: BeginRecord = record(&begin.content)?;
        if begun.format != FORMAT {
            let (format, version) = (begun.format, begun.version);
            return Err(format!(
                "its inputs are of form {format}, by camwright {version}; this one reads form {FORMAT}"
            ));
        }
        if begun.machine_hash != description.hash {
            return Err("the machine that began is not the one that the bag describes".to_owned());
        }
        let machine = Machine::new(description.clone(), PersistentState::from(&begun.lasting));
        Ok(Self::from_machine(machine.map_err(|error| error.to_string())?))
    }

    /// A machine that has not begun.
    pub fn from_machine(machine: Machine) -> Self {
        let waker = Waker::default();
        let (inlet, inbound) = ring(RING, &waker);
        let (outbound, reports) = ring(RING, &waker);
        let ticker = CyclicLoop::new(machine, Pace::Fast, inbound, outbound, Arc::new(Bounds::default()), 0);
        Self { ticker, inlet, reports, alarms: Arc::default(), digest: OutputDigest::default() }
    }

    /// The machine as it was after a tick.
    ///
    /// # Errors
    /// A state of another form or another machine, or one that cannot be.
    pub fn from_keyframe(
        description: &MachineDescription,
        head: &MachineKeyframe,
        state: &[u8],
    ) -> Result<Self, String> {
        if head.form != FORM_OF_KEYFRAMES {
            return Err(format!("its state is of form {}; this program reads form {FORM_OF_KEYFRAMES}", head.form));
        }
        let machine = Machine::new(description.clone(), PersistentState::new(description));
        let mut again = Self::from_machine(machine.map_err(|error| error.to_string())?);
        again.follow(&mut SnapshotCodec::reading(state))?;
        let (tick, job_tick) = (again.ticker.machine.tick(), again.ticker.state.job_tick);
        if tick != head.tick || job_tick != head.job_tick || job_tick > tick {
            return Err(format!("its state is of tick {tick} and of the job that began with tick {job_tick}"));
        }
        again.digest = OutputDigest::from(head.digest, job_tick);
        again.alarms = Arc::new(ActiveAlarms::from_alarms(again.ticker.machine.alarms()));
        Ok(again)
    }

    /// Goes through the state of the machine as it is now.
    ///
    /// # Errors
    /// Where it cannot be gone through, and why.
    pub fn follow(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), String> {
        let followed = self.ticker.walk_keyframe(codec).and_then(|()| codec.end());
        followed.map_err(|error| format!("{}: {error}", codec.place()))
    }

    /// Writes the state down.
    ///
    /// # Errors
    /// As for [`MachineReplay::follow`].
    pub fn state(&mut self) -> Result<Vec<u8>, String> {
        let mut measured = SnapshotCodec::measuring();
        self.follow(&mut measured)?;
        let mut state = vec![0; measured.octets()];
        self.follow(&mut SnapshotCodec::writing(&mut state))?;
        Ok(state)
    }

    /// Takes an input; `chunk` finds the chunk with a first tick and a digest.
    ///
    /// # Errors
    /// An input that cannot be read, or a chunk that is not at hand.
    pub fn apply(
        &mut self,
        input: &MachineInput,
        chunk: impl FnOnce(u64, u64) -> Result<ChunkBuffer, String>,
    ) -> Result<(), String> {
        let machine = self.ticker.machine.description();
        let inbound = match input.kind {
            MachineInput::CHUNK => Inbound::Chunk(input.writer, Box::new(chunk(input.number, input.digest)?)),
            MachineInput::NO_CHUNK => Inbound::NoChunk(input.writer),
            MachineInput::COMMAND => {
                let message: MachineCommand = record(&input.content)?;
                let command = commands::timed(&message, machine)
                    .ok_or_else(|| format!("command {} for {:?} is unknown", message.kind, message.target))?;
                Inbound::Command(input.writer, command)
            }
            MachineInput::FAULT => {
                let asked = asked_fault(record(&input.content)?, machine).map_err(|error| error.to_string())?;
                Inbound::Fault(Box::new(asked))
            }
            MachineInput::RESET => Inbound::Reset,
            MachineInput::LOBE => Inbound::Lobe(Box::new(lobe_of(input)?)),
            MachineInput::BAR => Inbound::Bar(Box::new(RawBar::new(record(&input.content)?)?)),
            MachineInput::WORK_AREA => {
                let order = AreaOrder::from_service(&input.content);
                Inbound::Area(order.ok_or_else(|| format!("{:?} works no part of the machine", input.content))?)
            }
            MachineInput::LOADER => Inbound::Loader { inside: input.number & 1 != 0, lost: input.number & 2 != 0 },
            MachineInput::JUDGE => Inbound::Judge(input.number == 1),
            MachineInput::RESET_SHIFT => Inbound::ResetShift,
            MachineInput::CLOSE => {
                self.ticker.close();
                self.drain();
                return Ok(());
            }
            MachineInput::OPEN => {
                self.ticker.open();
                return Ok(());
            }
            MachineInput::ALARM => {
                let (kind, value) = alarm_of(input)?;
                self.ticker.raise_outside(kind, value);
                self.drain();
                return Ok(());
            }
            MachineInput::BEGIN | MachineInput::DIGEST => return Ok(()),
            kind => return Err(format!("there is no input of kind {kind}")),
        };
        // The ring is empty before every input.
        let _taken = self.inlet.send(inbound);
        self.ticker.receive();
        self.drain();
        Ok(())
    }

    pub fn tick(&mut self) -> Option<TickOutput> {
        self.ticker.tick();
        let (report, state) = self.drain()?;
        let mut alarms = ActiveAlarms::clone(&self.alarms);
        if alarms.update(&report, &state) {
            self.alarms = Arc::new(alarms);
        }
        let alarms = Arc::clone(&self.alarms);
        Some(TickOutput { report, alarms, digests: self.digest.add(&report, &state) })
    }

    /// Published tick: only the tick itself counts.
    fn drain(&mut self) -> Option<(TickReport, StreamState)> {
        let mut ticked = None;
        while let Some(report) = self.reports.receive() {
            if let Outbound::Tick(report, state) = report
                && !state.only_stream
            {
                ticked = Some((report, state));
            }
        }
        ticked
    }
}
