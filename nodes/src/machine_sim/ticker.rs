//! The machine's cyclic thread: one tick after the other, at the pace of the clock or of the setpoints.

use super::faults::Faults;
use super::keyframes::Keyframes;
use super::pump::StreamState;
use super::traffic::{Inbound, Order, Outbound, TimedCommand};
use super::work_area::AreaOrder;
use crate::cyclic::{Receiver, Sender, Waker};
use camwright::machine::alarm::{AlarmKind, Severity};
use camwright::machine::buffer::SetpointBuffer;
use camwright::machine::fault::Fault;
use camwright::machine::report::{MotionState, TickReport};
use camwright::machine::state::LastingState;
use camwright::machine::work_area::LoadingRefused;
use camwright::machine::{Machine, MachineCommand, ResetRefused};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Commands that may wait for their tick.
pub(super) const PENDING_COMMANDS: usize = 32;
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
    pub(super) machine: Machine,
    pub(super) buffer: SetpointBuffer,
    pace: Pace,
    cycle: Duration,
    pub(super) inbound: Receiver<Inbound>,
    outbound: Sender<Outbound>,
    pub(super) bounds: Arc<Bounds>,
    /// Ticks that may be executed beyond what is in the bag.
    recorder_window: u64,
    pub(super) commands: [Option<TimedCommand>; PENDING_COMMANDS],
    now: [MachineCommand; 4],
    pub(super) faults: Faults,
    /// Chunks that still get lost, and when the last one was.
    pub(super) losing: u32,
    pub(super) lost: Option<Instant>,
    pub(super) state: StreamState,
    /// What outlives the run, as it was told last.
    told: LastingState,
    pub(super) last_report: Option<TickReport>,
    /// What was done to door, chuck or part, until a tick has shown it.
    pub(super) area_done: Option<(AreaOrder, Result<(), LoadingRefused>)>,
    /// How the last reset went, until a tick has shown it.
    pub(super) reset_done: Option<Result<(), ResetRefused>>,
    pub(super) active: bool,
    pub(super) job_running: bool,
    pub(super) keyframes: Keyframes,
}

// What is answered is answered before a tick is over; the rest is who drives it, and what it has told.
camwright::kept!(Ticker { machine, buffer, commands, faults, losing, state, job_running } on {
    pace, cycle, inbound, outbound, bounds, recorder_window, now, lost, told, last_report, area_done, reset_done, active, keyframes,
});

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
            keyframes: Keyframes::default(),
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
    pub(super) fn tell_lasting(&mut self) {
        self.told = *self.machine.lasting();
        self.send(Outbound::Lasting(self.told));
    }

    /// Brings the axes to rest before the thread ends: what was sent runs out on its stop, nothing more is taken.
    fn come_to_rest(&mut self, waker: &Waker) {
        self.close();
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

    pub(super) fn is_stopped_by_alarm(&self) -> bool {
        self.machine.alarms().iter().any(|alarm| alarm.kind.entry().severity > Severity::Warning)
    }

    pub(super) fn tick(&mut self) {
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
        self.write_keyframe();
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
                    self.state.job_tick = tick;
                    self.machine.begin_job();
                    self.faults.begin_job(tick);
                }
                Order::JobEnd => {
                    self.faults.end_job();
                    self.state.job_tick = 0;
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

    pub(super) fn send(&mut self, message: Outbound) {
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
