// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Interpolator and machine in one loop, tick by tick, without a network.
//!
//! Setpoints depend on ticks alone, so the loop gives the samples that the same motion gives over any network. It can be copied in the
//! middle of a motion to try several continuations. [`ClosedLoop::new`] carries the setpoints over the stream of the nodes: chunks ahead
//! of time, credit, a stop behind every chunk. [`ClosedLoop::direct`] hands each setpoint to the machine in its own tick, which saves the
//! stream's work and gives the same samples as long as no chunk is lost.

use crate::interpolator::{
    InfeedEnd, Interpolator, InterpolatorEvent, MotionOutcome, MotionRequest, OrderKind, Prepared, ProbeOutcome,
    StartError, TickInputs,
};
use crate::machine::alarm::{Alarm, AlarmKind, AlarmSeverity};
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use crate::machine::setpoint::{Setpoint, StopPoint};
use crate::simulation::buffer::{Chunk, ChunkError, MAX_TAIL_POINTS, SetpointBuffer, TailPoint};
use crate::simulation::fault::Fault;
use crate::simulation::tick_report::TickReport;
use crate::simulation::{Machine, MachineCommand, ResetRefused};
use alloc::boxed::Box;
use alloc::vec::Vec;
use thiserror::Error;

/// Points of the stop that ends a chunk.
const STOP_POINTS: usize = 24;

/// Ticks after the last setpoint in which every drive with a position loop has come to rest.
const SETTLING_TICKS: u64 = 60_000;

/// A motion that was simulated to its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Simulated {
    pub outcome: MotionOutcome,
    /// First tick of the motion.
    pub first_tick: u64,
    /// Tick of its last setpoint.
    pub last_tick: u64,
}

/// Reason for a simulation that did not come to its end.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SimulationError {
    /// The motion does not start.
    #[error(transparent)]
    Start(#[from] StartError),
    /// The machine raised an alarm.
    #[error("alarm {}: {}", .0.kind.entry().number, .0)]
    Alarm(Alarm),
    /// The axes do not come to rest.
    #[error("the axes are not at rest {SETTLING_TICKS} ticks after the last setpoint")]
    NotSettled,
}

/// The interpolator and what it has sent out.
#[derive(Debug, Clone)]
struct SetpointSender {
    interpolator: Interpolator,
    orders: Vec<(u64, MachineCommand)>,
    requests: Vec<MotionRequest>,
    /// First tick that has not been computed; `None` without a motion.
    next_tick: Option<u64>,
    outcome: Option<MotionOutcome>,
    probed: Option<ProbeOutcome>,
    infeed_ends: Vec<InfeedEnd>,
}

/// The stream of chunks between interpolator and machine.
#[derive(Debug, Clone)]
struct Stream {
    buffer: SetpointBuffer,
    /// Chunks that still get lost.
    losing: u32,
    lost: bool,
}

/// Interpolator and machine, connected.
#[derive(Debug, Clone)]
pub struct ClosedLoop {
    sender: SetpointSender,
    /// `None`: setpoints go straight to the machine.
    stream: Option<Stream>,
    machine: Machine,
    /// Setpoint of the last tick.
    setpoint: Option<Setpoint>,
}

impl ClosedLoop {
    /// Connects a machine that rests over the stream of the nodes.
    #[must_use]
    pub fn new(machine: Machine) -> Self {
        let buffer = SetpointBuffer::new(machine.description(), machine.setpoint());
        Self { stream: Some(Stream { buffer, losing: 0, lost: false }), ..Self::direct(machine) }
    }

    /// Connects a machine that rests without a stream. An alarm of the interpolator shows in the outcome alone.
    #[must_use]
    pub fn direct(machine: Machine) -> Self {
        let mut interpolator = Interpolator::new(machine.description());
        interpolator.resync(machine.setpoint().counts);
        let sender = SetpointSender {
            interpolator,
            orders: Vec::new(),
            requests: Vec::new(),
            next_tick: None,
            outcome: None,
            probed: None,
            infeed_ends: Vec::new(),
        };
        Self { sender, stream: None, machine, setpoint: None }
    }

    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Ends of infeeds at a gauge-controlled size, in the order of the cuts.
    #[must_use]
    pub fn infeed_ends(&self) -> &[InfeedEnd] {
        &self.sender.infeed_ends
    }

    #[must_use]
    pub fn into_machine(self) -> Machine {
        self.machine
    }

    #[must_use]
    pub fn interpolator(&self) -> &Interpolator {
        &self.sender.interpolator
    }

    /// The interpolator and the machine, to set what they must know of each other.
    pub fn parts_mut(&mut self) -> (&mut Interpolator, &mut Machine) {
        (&mut self.sender.interpolator, &mut self.machine)
    }

    /// Outcome of the last motion; `None` before its end.
    #[must_use]
    pub fn outcome(&self) -> Option<MotionOutcome> {
        self.sender.outcome
    }

    /// Result of the last motion if it was a probe.
    #[must_use]
    pub fn probed(&self) -> Option<ProbeOutcome> {
        self.sender.probed
    }

    /// A motion is under way, or something of it has still to be executed.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.has_setpoints() || !self.sender.orders.is_empty()
    }

    fn has_setpoints(&self) -> bool {
        self.sender.next_tick.is_some() || self.stream.as_ref().is_some_and(|stream| stream.buffer.has_setpoints())
    }

    /// Begins a motion.
    ///
    /// # Errors
    /// One that is under way, an alarm that needs a reset, a trajectory that begins elsewhere.
    pub fn start(&mut self, motion: Box<Prepared>) -> Result<(), StartError> {
        if stops(&self.machine) {
            return Err(StartError::Fault);
        }
        if self.is_running() {
            return Err(StartError::Busy);
        }
        let sender = &mut self.sender;
        sender.interpolator.start(motion).map_err(|(error, _)| error)?;
        sender.next_tick = Some(self.machine.tick() + 1);
        sender.outcome = None;
        sender.probed = None;
        Ok(())
    }

    /// Executes a motion from rest to rest. `observe` sees every tick from the motion's first to its last; the ticks in which the axes
    /// settle follow unseen.
    ///
    /// # Errors
    /// See [`SimulationError`].
    pub fn simulate(
        &mut self,
        motion: Box<Prepared>,
        mut observe: impl FnMut(&Setpoint, &TickReport),
    ) -> Result<Simulated, SimulationError> {
        let begins_job = motion.begins_job();
        self.sender.interpolator.resync(self.machine.setpoint().counts);
        self.start(motion)?;
        if begins_job {
            self.machine.begin_job();
        }
        let first_tick = self.machine.tick() + 1;
        while self.has_setpoints() {
            let report = self.step(&[]);
            unless_stopped(&report)?;
            if let Some(setpoint) = &self.setpoint {
                observe(setpoint, &report);
            }
        }
        let last_tick = self.machine.tick();
        for _ in 0..SETTLING_TICKS {
            if let Some(outcome) = self.sender.outcome.filter(|_| self.machine.is_at_rest()) {
                return Ok(Simulated { outcome, first_tick, last_tick });
            }
            unless_stopped(&self.step(&[]))?;
        }
        Err(SimulationError::NotSettled)
    }

    /// Passes a request to the motion, with the next tick that is computed.
    pub fn request(&mut self, request: MotionRequest) {
        self.sender.requests.push(request);
    }

    /// Clears the alarms; nothing that was under way is resumed.
    ///
    /// # Errors
    /// See [`Machine::reset`].
    pub fn reset(&mut self) -> Result<(), ResetRefused> {
        self.machine.reset()?;
        if let Some(stream) = &mut self.stream {
            stream.buffer.open(self.machine.setpoint());
            stream.lost = false;
        }
        self.sender.orders.clear();
        self.sender.interpolator.resync(self.machine.setpoint().counts);
        Ok(())
    }

    /// Takes setpoints from a sender that does not know of an alarm.
    ///
    /// # Errors
    /// See [`SetpointBuffer::accept`]; without a stream every chunk is refused as closed.
    pub fn offer(&mut self, chunk: &Chunk<'_>) -> Result<(), ChunkError> {
        let stream = self.stream.as_mut().ok_or(ChunkError::Closed)?;
        stream.buffer.accept(chunk, self.machine.tick())
    }

    /// One tick of the machine, and what the interpolator sends before it.
    pub fn step(&mut self, faults: &[Fault]) -> TickReport {
        let Self { sender, stream, machine, setpoint } = self;
        let tick = machine.tick() + 1;
        *setpoint = match stream {
            Some(stream) => stream.transfer(sender, machine, faults),
            None => sender.next_tick.map(|tick| sender.compute(tick, None)),
        };
        let due: Vec<MachineCommand> =
            sender.orders.iter().filter(|(at, _)| *at == tick).map(|(_, order)| *order).collect();
        sender.orders.retain(|(at, _)| *at > tick);
        let report = machine.step(setpoint.as_ref(), &due, faults);
        for latch in report.latches.iter() {
            sender.interpolator.feedback(latch);
        }
        let alarm = report.stopping_alarm();
        if let Some(stream) = stream {
            stream.buffer.executed(tick);
            if alarm.is_some() {
                // What was sent runs out on its stop.
                stream.buffer.close();
            }
        }
        if let Some(alarm) = alarm {
            sender.abandon(alarm, machine, &report);
        }
        report
    }
}

impl SetpointSender {
    /// Computes the setpoint of the next tick. Over a stream, the buffer hears of zeros that shift and the machine of alarms.
    fn compute(&mut self, tick: u64, mut stream: Option<(&mut SetpointBuffer, &mut Machine)>) -> Setpoint {
        let out = self.interpolator.step(&TickInputs { tick, requests: &self.requests });
        self.requests.drain(..out.requests_taken);
        for order in out.orders.iter() {
            if let (OrderKind::SetHome { axis, counts }, Some((buffer, _))) = (order.kind, &mut stream) {
                buffer.schedule_home(order.tick, axis, counts);
            }
            self.orders.push((order.tick, order.kind.into()));
        }
        for event in out.events.iter() {
            match event {
                InterpolatorEvent::Finished(outcome) => self.outcome = Some(*outcome),
                InterpolatorEvent::Alarm(alarm) => {
                    if let (Some(kind), Some((_, machine))) = (AlarmKind::from_number(alarm.number()), &mut stream) {
                        machine.raise(kind, f64::NAN, f64::NAN);
                    }
                }
                InterpolatorEvent::Probed(probed) => self.probed = Some(*probed),
                InterpolatorEvent::InfeedEnded(end) => self.infeed_ends.push(*end),
                InterpolatorEvent::Segment(_) | InterpolatorEvent::LeftOut { .. } => {}
            }
        }
        self.next_tick = self.outcome.is_none().then_some(tick + 1);
        if self.outcome.is_some() {
            drop(self.interpolator.take_finished());
        }
        out.setpoint
    }

    /// Stop after the last setpoint computed.
    fn tail(&self, last: u64, machine: &MachineDescription) -> Vec<TailPoint> {
        let mut points = [StopPoint::default(); STOP_POINTS];
        let count = self.interpolator.stop_tail(&mut points).min(MAX_TAIL_POINTS);
        let tail: Vec<TailPoint> = points[..count]
            .iter()
            .map(|point| {
                let mut counts = [0; AXIS_COUNT];
                for axis in Axis::ALL {
                    counts[axis.index()] = machine.axis(axis).scale.counts(point.position[axis.index()]);
                }
                let setpoint = Setpoint { counts, velocity: point.velocity, acceleration: point.acceleration };
                TailPoint { tick: last + u64::from(point.ticks), setpoint }
            })
            .collect();
        if tail.is_empty() {
            // At rest already: a point of rest says that more will come.
            let setpoint = Setpoint { counts: self.interpolator.setpoint().counts, ..Setpoint::default() };
            return [TailPoint { tick: last + 2, setpoint }].into();
        }
        tail
    }

    /// Drops the motion that an alarm of the machine has stopped.
    fn abandon(&mut self, alarm: Alarm, machine: &Machine, report: &TickReport) {
        self.next_tick = None;
        self.requests.clear();
        self.interpolator.resync(machine.setpoint().counts);
        // An encoder that jumped has lost its zero.
        for axis in Axis::ALL.into_iter().filter(|axis| !report.axes[axis.index()].is_homed) {
            self.interpolator.set_homed(axis, false);
        }
        drop(self.interpolator.take_finished());
        self.outcome = Some(MotionOutcome::Failed(alarm.kind.entry().number));
    }
}

impl Stream {
    /// Sends what the credit allows, and returns the setpoint of the next tick of the machine.
    fn transfer(&mut self, sender: &mut SetpointSender, machine: &mut Machine, faults: &[Fault]) -> Option<Setpoint> {
        for fault in faults {
            if let Fault::LostChunks(count) = fault {
                self.losing = *count;
            }
        }
        self.send(sender, machine);
        let tick = machine.tick() + 1;
        if self.lost && self.buffer.is_underrun(tick) && !stops(machine) {
            machine.raise(AlarmKind::Underrun, 0.0, 0.0);
        }
        self.buffer.at(tick)
    }

    /// Sends chunks as far ahead as the credit goes, a tenth of it each.
    fn send(&mut self, sender: &mut SetpointSender, machine: &mut Machine) {
        let delay = u64::from(machine.description().feedback_delay_ticks);
        let max = usize::try_from((delay / 10).max(1)).unwrap_or(1);
        while let Some(first) = sender.next_tick {
            let credit = self.buffer.credit(machine.tick());
            if first + max as u64 - 1 > credit {
                return;
            }
            let mut dense: Vec<Setpoint> = Vec::with_capacity(max);
            while let Some(tick) = sender.next_tick.filter(|_| dense.len() < max) {
                dense.push(sender.compute(tick, Some((&mut self.buffer, machine))));
            }
            let is_final = sender.next_tick.is_none();
            let last = first + dense.len() as u64 - 1;
            let tail = if is_final { Vec::new() } else { sender.tail(last, machine.description()) };
            let chunk = Chunk { first_tick: first, dense: &dense, tail: &tail, is_final };
            if self.losing > 0 {
                self.losing -= 1;
                self.lost = true;
                continue;
            }
            match self.buffer.accept(&chunk, machine.tick()) {
                Ok(()) | Err(ChunkError::Closed) => {}
                Err(ChunkError::Lost { first_tick, expected }) => {
                    machine.raise(AlarmKind::SetpointsLost, first_tick as f64, expected as f64);
                    self.buffer.close();
                }
                Err(_) => {
                    machine.raise(AlarmKind::ChunkRefused, first as f64, 0.0);
                    self.buffer.close();
                }
            }
        }
    }
}

fn unless_stopped(report: &TickReport) -> Result<(), SimulationError> {
    report.stopping_alarm().map_or(Ok(()), |alarm| Err(SimulationError::Alarm(alarm)))
}

fn stops(machine: &Machine) -> bool {
    machine.alarms().iter().any(|alarm| alarm.kind.entry().severity > AlarmSeverity::Warning)
}

impl From<OrderKind> for MachineCommand {
    fn from(order: OrderKind) -> Self {
        match order {
            OrderKind::SetHome { axis, counts } => MachineCommand::SetHome { axis, counts },
            OrderKind::LoseHome { axis } => MachineCommand::LoseHome { axis },
            OrderKind::Ask { input } => MachineCommand::Ask { input },
            OrderKind::WheelStart => MachineCommand::WheelStart,
            OrderKind::WheelStop => MachineCommand::WheelStop,
            OrderKind::ExpectWheel { radius_nm } => MachineCommand::ExpectWheel { radius_nm },
            OrderKind::ChangeWheel { wheel } => MachineCommand::ChangeWheel { wheel },
            OrderKind::Dress { radius_nm } => MachineCommand::Dress { radius_nm },
            OrderKind::Push { max_n } => MachineCommand::Push { max_n },
            OrderKind::WatchForce { max_n } => MachineCommand::WatchForce { max_n },
            OrderKind::WatchSize { diameter_nm } => MachineCommand::WatchSize { diameter_nm },
        }
    }
}
