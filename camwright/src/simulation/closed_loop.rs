//! Interpolator, stream of setpoints and machine as one value: what the nodes do over the network, tick by tick, with
//! nothing in between. It can be copied in the middle of a motion, so that what would happen from there on can be tried
//! again and again.

use crate::interpolator::{Event, Interpolator, OrderKind, Outcome, Prepared, Probed, Request, StartError, TickInputs};
use crate::machine::alarm::{AlarmKind, Severity};
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use crate::machine::setpoint::{Setpoint, StopPoint};
use crate::simulation::buffer::{Chunk, ChunkError, MAX_TAIL_POINTS, SetpointBuffer, TailPoint};
use crate::simulation::fault::Fault;
use crate::simulation::tick_report::TickReport;
use crate::simulation::{Machine, MachineCommand, ResetRefused};
use alloc::boxed::Box;
use alloc::vec::Vec;

/// Points of the stop that ends a chunk.
const STOP_POINTS: usize = 24;

/// A cell in execution.
#[derive(Debug, Clone)]
pub struct Cell {
    interpolator: Interpolator,
    machine: Machine,
    buffer: SetpointBuffer,
    orders: Vec<(u64, MachineCommand)>,
    requests: Vec<Request>,
    /// First tick that has not been computed; `None` without a motion.
    next_tick: Option<u64>,
    /// Chunks that still get lost.
    losing: u32,
    lost: bool,
    outcome: Option<Outcome>,
    probed: Option<Probed>,
}

impl Cell {
    /// A cell whose machine rests.
    #[must_use]
    pub fn new(machine: Machine) -> Self {
        let mut interpolator = Interpolator::new(machine.description());
        interpolator.resync(machine.setpoint().counts);
        Self {
            interpolator,
            buffer: SetpointBuffer::new(machine.description(), machine.setpoint()),
            orders: Vec::new(),
            requests: Vec::new(),
            next_tick: None,
            losing: 0,
            lost: false,
            outcome: None,
            probed: None,
            machine,
        }
    }

    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    #[must_use]
    pub fn interpolator(&self) -> &Interpolator {
        &self.interpolator
    }

    /// The interpolator and the machine, to be told what they must know of each other.
    pub fn parts_mut(&mut self) -> (&mut Interpolator, &mut Machine) {
        (&mut self.interpolator, &mut self.machine)
    }

    /// How the last motion ended; `None` before its end.
    #[must_use]
    pub fn outcome(&self) -> Option<Outcome> {
        self.outcome
    }

    /// What the last motion found, if it was a probe.
    #[must_use]
    pub fn probed(&self) -> Option<Probed> {
        self.probed
    }

    /// A motion is under way, or something of it has still to be executed.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.next_tick.is_some() || self.buffer.has_setpoints() || !self.orders.is_empty()
    }

    /// Begins a motion.
    ///
    /// # Errors
    /// One that is under way, an alarm that needs a reset, a trajectory that begins elsewhere.
    pub fn start(&mut self, motion: Box<Prepared>) -> Result<(), StartError> {
        if self.stops() {
            return Err(StartError::Fault);
        }
        if self.is_running() {
            return Err(StartError::Busy);
        }
        self.interpolator.start(motion).map_err(|(error, _)| error)?;
        self.next_tick = Some(self.machine.tick() + 1);
        self.outcome = None;
        self.probed = None;
        Ok(())
    }

    /// What somebody asks of the motion, with the next tick that is computed.
    pub fn request(&mut self, request: Request) {
        self.requests.push(request);
    }

    /// Clears the alarms; nothing that was under way is taken up again.
    ///
    /// # Errors
    /// What the machine says.
    pub fn reset(&mut self) -> Result<(), ResetRefused> {
        self.machine.reset()?;
        self.buffer.open(self.machine.setpoint());
        self.orders.clear();
        self.lost = false;
        self.interpolator.resync(self.machine.setpoint().counts);
        Ok(())
    }

    /// Takes setpoints from a sender that does not know of an alarm.
    ///
    /// # Errors
    /// What the machine's end of the stream says.
    pub fn offer(&mut self, chunk: &Chunk<'_>) -> Result<(), ChunkError> {
        self.buffer.accept(chunk, self.machine.tick())
    }

    fn stops(&self) -> bool {
        self.machine.alarms().iter().any(|alarm| alarm.kind.entry().severity > Severity::Warning)
    }

    /// One tick of the machine, and what the interpolator sends before it.
    pub fn step(&mut self, faults: &[Fault]) -> TickReport {
        for fault in faults {
            if let Fault::LostChunks(count) = fault {
                self.losing = *count;
            }
        }
        self.send();
        let tick = self.machine.tick() + 1;
        let due: Vec<MachineCommand> = self.orders.iter().filter(|(at, _)| *at == tick).map(|order| order.1).collect();
        self.orders.retain(|(at, _)| *at > tick);
        if self.lost && self.buffer.is_underrun(tick) && !self.stops() {
            self.machine.raise(AlarmKind::Underrun, 0.0, 0.0);
        }
        let setpoint = self.buffer.at(tick);
        let report = self.machine.step(setpoint.as_ref(), &due, faults);
        self.buffer.executed(tick);
        for latch in report.latches.iter() {
            self.interpolator.feedback(latch);
        }
        if let Some(alarm) = report.raised.iter().find(|alarm| alarm.kind.entry().severity > Severity::Warning) {
            // What was sent runs out on its stop; what the interpolator computes from now on, nobody takes.
            self.buffer.close();
            self.next_tick = None;
            self.requests.clear();
            self.interpolator.resync(self.machine.setpoint().counts);
            // An encoder that jumped has lost its zero.
            for axis in Axis::ALL.into_iter().filter(|axis| !report.axes[axis.index()].is_homed) {
                self.interpolator.set_homed(axis, false);
            }
            drop(self.interpolator.take_finished());
            self.outcome = Some(Outcome::Failed(alarm.kind.entry().number));
        }
        report
    }

    /// Chunks as far ahead as the credit goes, a tenth of it each.
    fn send(&mut self) {
        let delay = u64::from(self.machine.description().feedback_delay_ticks);
        let most = usize::try_from((delay / 10).max(1)).unwrap_or(1);
        while let Some(first) = self.next_tick {
            let credit = self.buffer.credit(self.machine.tick());
            if first + most as u64 - 1 > credit {
                return;
            }
            let mut dense: Vec<Setpoint> = Vec::with_capacity(most);
            let mut finished = false;
            while dense.len() < most && !finished {
                finished = self.compute(first + dense.len() as u64, &mut dense);
            }
            let last = first + dense.len() as u64 - 1;
            self.next_tick = Some(last + 1).filter(|_| !finished);
            let tail = if finished { Vec::new() } else { self.tail(last) };
            let chunk = Chunk { first_tick: first, dense: &dense, tail: &tail, is_final: finished };
            if self.losing > 0 {
                self.losing -= 1;
                self.lost = true;
                continue;
            }
            match self.buffer.accept(&chunk, self.machine.tick()) {
                Ok(()) | Err(ChunkError::Closed) => {}
                Err(ChunkError::Lost { first_tick, expected }) => {
                    self.machine.raise(AlarmKind::SetpointsLost, first_tick as f64, expected as f64);
                    self.buffer.close();
                }
                Err(_) => {
                    self.machine.raise(AlarmKind::ChunkRefused, first as f64, 0.0);
                    self.buffer.close();
                }
            }
        }
    }

    /// The setpoint of one tick; whether the motion ends with it.
    fn compute(&mut self, tick: u64, dense: &mut Vec<Setpoint>) -> bool {
        let out = self.interpolator.step(&TickInputs { tick, requests: &self.requests });
        self.requests.drain(..out.requests_taken);
        for order in out.orders.iter() {
            if let OrderKind::SetHome { axis, counts } = order.kind {
                self.buffer.schedule_home(order.tick, axis, counts);
            }
            self.orders.push((order.tick, order.kind.into()));
        }
        dense.push(out.setpoint);
        for event in out.events.iter() {
            match event {
                Event::Finished(outcome) => self.outcome = Some(*outcome),
                Event::Alarm(alarm) => {
                    if let Some(kind) = AlarmKind::from_number(alarm.number()) {
                        self.machine.raise(kind, f64::NAN, f64::NAN);
                    }
                }
                Event::Probed(probed) => self.probed = Some(*probed),
                Event::Segment(_) | Event::LeftOut { .. } => {}
            }
        }
        if self.outcome.is_some() {
            drop(self.interpolator.take_finished());
        }
        self.outcome.is_some()
    }

    /// The stop after the last setpoint computed.
    fn tail(&self, last: u64) -> Vec<TailPoint> {
        let mut points = [StopPoint::default(); STOP_POINTS];
        let count = self.interpolator.stop_tail(&mut points).min(MAX_TAIL_POINTS);
        let machine: &MachineDescription = self.machine.description();
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
}
