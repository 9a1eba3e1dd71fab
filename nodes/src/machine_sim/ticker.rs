//! The machine's cyclic thread: one tick after the other, at the pace of the clock or of the setpoints.

use super::faults::Faults;
use super::part::{BarRefused, LobeRefused};
use super::pump::StreamState;
use super::traffic::{Inbound, Order, Outbound, TimedCommand};
use super::work_area::AreaOrder;
use crate::convert::setpoints::ChunkBuffer;
use crate::cyclic::{Receiver, Sender, Waker};
use camwright::machine::alarm::{AlarmKind, NO_TICK, Severity};
use camwright::machine::buffer::{ChunkError, SetpointBuffer};
use camwright::machine::fault::Fault;
use camwright::machine::report::{MotionState, TickReport};
use camwright::machine::state::LastingState;
use camwright::machine::work_area::LoadingRefused;
use camwright::machine::{Machine, MachineCommand, ResetRefused};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Commands that may wait for their tick.
const PENDING_COMMANDS: usize = 32;
/// Wall time of an idle tick at pace fast: ticks then only show that the machine lives.
const FAST_IDLE_TICK: Duration = Duration::from_millis(10);

/// How long the chunk after a lost one may take at pace fast: it is on its way already, if there is one.
const AFTER_A_LOSS: Duration = Duration::from_millis(500);
/// Ticks within which every axis has come to rest, whatever it did before.
const LONGEST_STOP_TICKS: u64 = 20_000;

/// How ticks follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// With the wall clock; a missing setpoint is an underrun.
    Realtime,
    /// With the setpoints; a missing one is waited for.
    Fast,
}

/// What other threads tell the ticker without a message.
#[derive(Debug, Default)]
pub(super) struct Bounds {
    /// A recording is active.
    pub(super) recording: AtomicBool,
    /// Last tick that is in the bag.
    pub(super) recorded_tick: AtomicU64,
    /// The node is ending.
    pub(super) stop: AtomicBool,
    /// For diagnostics: the last tick, ticks that began more than a period late, active alarms that stop motion.
    pub(super) tick: AtomicU64,
    pub(super) late_ticks: AtomicU64,
    /// By how much the latest of them was late since that was asked last (µs).
    pub(super) worst_late_us: AtomicU64,
    /// Ticks between the arrival of a chunk and its first setpoint's, the least since that was asked last.
    pub(super) least_lead_ticks: AtomicU64,
    pub(super) alarms: AtomicU64,
}

/// The cyclic thread's own state.
pub(super) struct Ticker {
    machine: Machine,
    buffer: SetpointBuffer,
    pace: Pace,
    cycle: Duration,
    inbound: Receiver<Inbound>,
    outbound: Sender<Outbound>,
    bounds: Arc<Bounds>,
    /// Ticks that may be executed beyond what is in the bag.
    recorder_window: u64,
    commands: [Option<TimedCommand>; PENDING_COMMANDS],
    now: [MachineCommand; 4],
    faults: Faults,
    /// Chunks that still get lost, and when the last one was.
    losing: u32,
    lost: Option<Instant>,
    state: StreamState,
    /// What outlives the run, as it was told last.
    told: LastingState,
    last_report: Option<TickReport>,
    /// What was done to door, chuck or part, until a tick has shown it.
    area_done: Option<(AreaOrder, Result<(), LoadingRefused>)>,
    /// How the last reset went, until a tick has shown it.
    reset_done: Option<Result<(), ResetRefused>>,
    active: bool,
    job_running: bool,
}

impl Ticker {
    pub(super) fn new(
        machine: Machine,
        pace: Pace,
        inbound: Receiver<Inbound>,
        outbound: Sender<Outbound>,
        bounds: Arc<Bounds>,
        recorder_window: u64,
    ) -> Self {
        let description = machine.description();
        let cycle = Duration::from_nanos(u64::from(description.cycle_time_ns));
        let buffer = SetpointBuffer::new(description, machine.setpoint());
        Self {
            told: *machine.lasting(),
            machine,
            buffer,
            pace,
            cycle,
            inbound,
            outbound,
            bounds,
            recorder_window,
            commands: [None; PENDING_COMMANDS],
            now: [MachineCommand::WheelStop; 4],
            faults: Faults::default(),
            losing: 0,
            lost: None,
            state: StreamState::default(),
            last_report: None,
            area_done: None,
            reset_done: None,
            active: false,
            job_running: false,
        }
    }

    /// Runs until the node ends.
    pub(super) fn run(mut self, waker: &Waker) {
        waker.adopt_current_thread();
        let mut deadline = Instant::now();
        while !self.bounds.stop.load(Ordering::Acquire) {
            self.receive();
            let now = Instant::now();
            if !self.active {
                let _woken = waker.wait(Duration::from_millis(100));
                deadline = Instant::now();
            } else if self.outbound.free() < 64 {
                // The pump is behind; what it has to tell is more important than the next tick.
                std::thread::yield_now();
                deadline = deadline.max(now);
            } else if self.pace == Pace::Fast && self.may_run_fast() {
                self.tick();
                deadline = now + FAST_IDLE_TICK;
            } else if self.pace == Pace::Fast && self.is_moving() {
                // Setpoints or the recorder are behind: wait for their news.
                let _woken = waker.wait(Duration::from_millis(100));
            } else if now >= deadline {
                if now > deadline + self.cycle && self.pace == Pace::Realtime {
                    self.bounds.late_ticks.fetch_add(1, Ordering::Relaxed);
                    let late_us = u64::try_from((now - deadline).as_micros()).unwrap_or(u64::MAX);
                    self.bounds.worst_late_us.fetch_max(late_us, Ordering::Relaxed);
                }
                self.tick();
                deadline += if self.pace == Pace::Fast { FAST_IDLE_TICK } else { self.cycle };
                // After a long suspension time is not made up for: missed ticks did not happen.
                if now > deadline + 50 * self.cycle {
                    deadline = now;
                }
            } else {
                let _woken = waker.wait(deadline - now);
            }
        }
        if self.active {
            self.come_to_rest(waker);
        }
        // What a job that was not finished took off the wheel.
        if *self.machine.lasting() != self.told {
            self.tell_lasting();
        }
    }

    /// What outlives the run has changed.
    fn tell_lasting(&mut self) {
        self.told = *self.machine.lasting();
        self.send(Outbound::Lasting(self.told));
    }

    /// Brings the axes to rest before the thread ends: what was sent runs out on its stop, nothing more is taken.
    fn come_to_rest(&mut self, waker: &Waker) {
        self.buffer.close();
        let latest = self.machine.tick() + LONGEST_STOP_TICKS;
        while self.machine.tick() < latest && (self.buffer.has_setpoints() || !self.machine.is_at_rest()) {
            if self.pace == Pace::Realtime {
                let _woken = waker.wait(self.cycle);
            }
            self.tick();
        }
    }

    /// Something is under way that must go on without the wall clock.
    fn is_moving(&self) -> bool {
        let next = self.machine.tick() + 1;
        // After an alarm nothing that was sent is waited for.
        !self.is_stopped_by_alarm() && (self.buffer.is_underrun(next) || self.has_work(next))
    }

    fn has_work(&self, next: u64) -> bool {
        self.buffer.has_setpoints()
            || !self.machine.is_at_rest()
            || self.machine.is_being_loaded()
            || self.area_done.is_some()
            || self.commands.iter().flatten().any(|c| c.tick >= next)
    }

    /// At pace fast a tick is executed when its setpoint is there, or when there is nothing to wait for.
    fn may_run_fast(&self) -> bool {
        let next = self.machine.tick() + 1;
        if self.bounds.recording.load(Ordering::Acquire)
            && next > self.bounds.recorded_tick.load(Ordering::Acquire).saturating_add(self.recorder_window)
        {
            return false;
        }
        if self.is_stopped_by_alarm() {
            return !self.machine.is_at_rest() || self.machine.is_being_loaded() || self.area_done.is_some();
        }
        self.has_work(next) && (self.is_given_up() || !self.buffer.is_underrun(next)) && !self.awaits_stream(next)
    }

    /// Setpoints that got lost are not waited for, but what comes after them is for a while: it tells that they are lost.
    fn is_given_up(&self) -> bool {
        self.lost.is_some_and(|since| self.losing > 0 || since.elapsed() > AFTER_A_LOSS)
    }

    /// A job begins with this tick, or an order lies ahead of a stream that has not begun: its first setpoints are still on their
    /// way, and must not find their ticks executed.
    fn awaits_stream(&self, next: u64) -> bool {
        let begins = |c: &TimedCommand| matches!(c.order, Order::JobBegin) && c.tick <= next;
        let is_ahead = |c: &TimedCommand| self.buffer.is_spent() && c.tick > next;
        !self.buffer.has_setpoints() && self.commands.iter().flatten().any(|c| begins(c) || is_ahead(c))
    }

    fn is_stopped_by_alarm(&self) -> bool {
        self.machine.alarms().iter().any(|alarm| alarm.kind.entry().severity > Severity::Warning)
    }

    fn tick(&mut self) {
        let next = self.machine.tick() + 1;
        if self.buffer.is_underrun(next) && !self.is_stopped_by_alarm() {
            self.machine.raise(AlarmKind::Underrun, 0.0, 0.0);
            self.buffer.close();
            self.state.news = true;
        }
        let setpoint = self.buffer.at(next);
        let count = self.take_due(next);
        let faults = self.faults.due(next);
        for fault in faults.iter() {
            if let Fault::LostChunks(chunks) = fault {
                self.losing = *chunks;
            }
        }
        let mut report = self.machine.step(setpoint.as_ref(), &self.now[..count], &faults);
        self.buffer.executed(next);
        let is_raised = report.raised.iter().next().is_some();
        if self.is_stopped_by_alarm() && is_raised {
            self.buffer.close();
        }
        // Setpoints that wait for their tick are no standstill.
        if report.motion == MotionState::Standstill && self.buffer.has_setpoints() {
            report.motion = MotionState::Running;
        }
        self.state.news |= is_raised || self.last_report.is_none_or(|last| last.motion != report.motion);
        if self.state.has_holder && self.buffer.is_spent() {
            self.state.has_holder = false;
            self.state.news = true;
        }
        if report.motion == MotionState::Standstill && self.state.alarms_reset {
            self.state.news = true;
        }
        self.last_report = Some(report);
        if self.machine.lasting().dress_count != self.told.dress_count {
            self.tell_lasting();
        }
        self.bounds.tick.store(next, Ordering::Relaxed);
        let alarms =
            self.machine.alarms().iter().filter(|alarm| alarm.kind.entry().severity > Severity::Warning).count();
        self.bounds.alarms.store(alarms as u64, Ordering::Relaxed);
        self.send(Outbound::Tick(report, self.state));
        self.answer_area();
        self.answer_reset();
        self.state.news = false;
        self.state.alarms_reset = false;
    }

    /// Commands of a tick, into `now`; their number.
    fn take_due(&mut self, tick: u64) -> usize {
        let mut count = 0;
        for index in 0..PENDING_COMMANDS {
            let Some(command) = self.commands[index].filter(|command| command.tick <= tick) else { continue };
            match command.order {
                Order::Machine(order) if count < self.now.len() => {
                    self.now[count] = order;
                    count += 1;
                }
                // More than four orders of one tick: the rest follows in the next.
                Order::Machine(_) => continue,
                Order::JobBegin => {
                    self.job_running = true;
                    self.machine.begin_job();
                    self.faults.begin_job(tick);
                }
                Order::JobEnd => {
                    self.faults.end_job();
                    if std::mem::take(&mut self.job_running) {
                        self.machine.count_part();
                        self.tell_lasting();
                        self.send(Outbound::JobEnded);
                    }
                }
            }
            self.commands[index] = None;
        }
        count
    }

    fn receive(&mut self) {
        while let Some(message) = self.inbound.receive() {
            match message {
                Inbound::Chunk(writer, chunk) => self.take_chunk(writer, chunk),
                Inbound::NoChunk(writer) => self.take_no_chunk(writer),
                Inbound::Command(writer, command) => self.take_command(writer, command),
                Inbound::Fault(fault, job_tick) => self.faults.add(fault, job_tick),
                Inbound::Reset => self.reset(),
                Inbound::Lobe(mut lobe) => {
                    let outcome = match self.machine.holds_part() {
                        Err(refused) => Err(LobeRefused::NotHeld(refused)),
                        Ok(()) if self.takes_part() => lobe.put_in(&mut self.machine),
                        Ok(()) => Err(LobeRefused::Moving),
                    };
                    self.send(Outbound::LobeDone(outcome, lobe));
                }
                Inbound::Bar(mut bar) => {
                    let outcome = match self.machine.holds_part() {
                        Err(refused) => Err(BarRefused::NotHeld(refused)),
                        Ok(()) if self.takes_part() => bar.clamp(&mut self.machine),
                        Ok(()) => Err(BarRefused::Moving),
                    };
                    self.send(Outbound::BarDone(outcome, bar));
                }
                Inbound::Snapshot(mut snapshot) => {
                    snapshot.take(&self.machine);
                    self.send(Outbound::Snapshot(snapshot));
                }
                Inbound::Outline(mut outline) => {
                    outline.take(&self.machine);
                    self.send(Outbound::Outline(outline));
                }
                Inbound::Area(order) => self.work_area(order),
                Inbound::Loader { inside, lost } => self.machine.see_loader(inside, lost),
                Inbound::Judge(is_good) => {
                    self.machine.judge_part(is_good);
                    self.tell_lasting();
                }
                Inbound::ResetShift => {
                    self.machine.reset_shift();
                    self.tell_lasting();
                }
                Inbound::Active(active) => self.active = active,
            }
        }
    }

    fn take_chunk(&mut self, writer: [u8; 16], chunk: Box<ChunkBuffer>) {
        if self.state.has_holder && self.state.holder != writer {
            self.machine.raise(AlarmKind::SecondWriter, 0.0, 0.0);
            let holder = self.state.holder;
            self.send(Outbound::SecondWriter { holder, refused: writer, chunk });
            return;
        }
        if self.losing > 0 {
            self.losing -= 1;
            self.lost = Some(Instant::now());
            self.send(Outbound::Used(chunk));
            return;
        }
        match self.buffer.accept(&chunk.as_chunk(), self.machine.tick()) {
            Ok(()) => {
                let lead_ticks = chunk.first_tick.saturating_sub(self.machine.tick());
                self.bounds.least_lead_ticks.fetch_min(lead_ticks, Ordering::Relaxed);
                if !self.state.has_holder {
                    self.state.has_holder = true;
                    self.state.holder = writer;
                    self.state.news = true;
                }
                self.send(Outbound::Used(chunk));
            }
            Err(error @ ChunkError::Lost { first_tick, expected }) => {
                #[allow(clippy::cast_precision_loss, reason = "tick numbers for people")]
                self.machine.raise(AlarmKind::SetpointsLost, first_tick as f64, expected as f64);
                self.buffer.close();
                self.send(Outbound::Refused(error, writer, chunk));
            }
            Err(error) => {
                // A closed buffer says that an alarm is active already: not another one.
                if error != ChunkError::Closed {
                    #[allow(clippy::cast_precision_loss, reason = "a tick number for people")]
                    self.machine.raise(AlarmKind::ChunkRefused, chunk.first_tick as f64, 0.0);
                    self.buffer.close();
                }
                self.send(Outbound::Refused(error, writer, chunk));
            }
        }
    }

    /// What came in the place of a chunk and is none: refused like one that cannot be followed.
    fn take_no_chunk(&mut self, writer: [u8; 16]) {
        if self.state.has_holder && self.state.holder != writer {
            self.machine.raise(AlarmKind::SecondWriter, 0.0, 0.0);
        } else if !self.is_stopped_by_alarm() {
            self.machine.raise(AlarmKind::ChunkRefused, NO_TICK, 0.0);
            self.buffer.close();
        }
    }

    fn take_command(&mut self, writer: [u8; 16], command: TimedCommand) {
        if self.state.has_holder && self.state.holder != writer {
            self.machine.raise(AlarmKind::SecondWriter, 0.0, 0.0);
            return;
        }
        if command.sequence == 1 {
            self.state.commands_received = 0;
        }
        let expected = self.state.commands_received + 1;
        if command.sequence != expected {
            self.machine.raise(AlarmKind::CommandGap, f64::from(command.sequence), f64::from(expected));
            return;
        }
        let executed = self.machine.tick();
        if command.tick <= executed {
            #[allow(clippy::cast_precision_loss, reason = "a number of ticks for people")]
            self.machine.raise(AlarmKind::LateCommand, (executed + 1 - command.tick) as f64, 0.0);
            return;
        }
        if let Order::Machine(MachineCommand::SetHome { axis, counts }) = command.order {
            self.buffer.schedule_home(command.tick, axis, counts);
        }
        let Some(place) = self.commands.iter_mut().find(|place| place.is_none()) else {
            self.machine.raise(AlarmKind::CommandGap, f64::from(command.sequence), f64::from(expected));
            return;
        };
        *place = Some(command);
        self.state.commands_received = command.sequence;
        self.state.news = true;
        // The sender waits for this before it sends setpoints beyond the command's tick.
        self.tell_receipt();
    }

    /// Tells the stream at once that a command arrived, without executing a tick.
    fn tell_receipt(&mut self) {
        if let Some(report) = self.last_report {
            self.send(Outbound::Tick(report, StreamState { only_stream: true, ..self.state }));
            self.state.news = false;
        }
    }

    fn reset(&mut self) {
        let outcome = self.machine.reset();
        if outcome.is_ok() {
            self.buffer.open(self.machine.setpoint());
            self.commands = [None; PENDING_COMMANDS];
            self.job_running = false;
            self.lost = None;
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
    fn answer_reset(&mut self) {
        if let Some(outcome) = self.reset_done.take() {
            self.send(Outbound::ResetDone(outcome));
        }
    }

    /// Works door, chuck or part of a machine that takes no setpoints.
    fn work_area(&mut self, order: AreaOrder) {
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
    fn answer_area(&mut self) {
        if let Some((order, outcome)) = self.area_done.take() {
            self.send(Outbound::AreaDone(order, outcome));
        }
    }

    /// Loading and copying the part are the only places where this thread allocates: a part is taken at rest only.
    fn takes_part(&self) -> bool {
        self.machine.is_at_rest() && !self.buffer.has_setpoints()
    }

    fn send(&mut self, message: Outbound) {
        let mut message = message;
        // The loop keeps room free; a full ring here means that the pump has died.
        for _ in 0..1000 {
            match self.outbound.send(message) {
                Ok(()) => return,
                Err(back) => message = back,
            }
            std::thread::yield_now();
        }
    }
}
