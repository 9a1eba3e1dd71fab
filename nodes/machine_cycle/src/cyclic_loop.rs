// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The machine's cyclic thread: one tick after the other, at the pace of the clock or of the setpoints.

use super::area_order::AreaOrder;
use super::bounds::{Bounds, PENDING_COMMANDS};
use super::faults::Faults;
use super::keyframes::Keyframes;
use super::messages::{Inbound, MachineOrder, Outbound, TimedCommand};
use super::pacing::{CycleTime, Pace, Pacing, PacingStep, Slip};
use super::partners::MachinePartners;
use super::servo_bus::BusState;
use super::stream_state::StreamState;
use camwright::machine::alarm::{AlarmKind, AlarmSeverity};
use camwright::machine::persistent_state::PersistentState;
use camwright::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use camwright::simulation::buffer::{SetpointBuffer, Supply};
use camwright::simulation::fault::Fault;
use camwright::simulation::tick_report::{MotionState, TickReport};
use camwright::simulation::work_area::LoadingRefused;
use camwright::simulation::{Machine, MachineCommand, ResetRefused};
use camwright_files::convert::time::TickClock;
use camwright_threads::ring::{Receiver, Sender, Waker};
use camwright_threads::silence::HEARTBEAT;
use camwright_threads::supervised::injected;
use camwright_threads::system_time::system_time_ns;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Wall time of an idle tick at pace fast: ticks then only show that the machine lives.
const FAST_IDLE_TICK: Duration = Duration::from_millis(10);
/// Pause of the cycle while the pump is behind, which then publishes some of the ring. A thread of real-time priority that only yields
/// takes a processor from the pump.
const PUMP_BEHIND: Duration = Duration::from_micros(500);

/// Maximum delay of the chunk after a lost one at pace fast: it is already on its way, if there is one.
const AFTER_A_LOSS: Duration = Duration::from_millis(500);
/// Time in which the stop of an ending node follows the clock; the rest of it is executed at once.
const ENDING: Duration = Duration::from_millis(800);
/// Waits of one cycle before the first tick that are measured.
const JITTER_TRIALS: u32 = 500;
/// Ticks within which every axis has come to rest, whatever it did before.
const LONGEST_STOP_TICKS: u64 = 20_000;

/// The cyclic thread's own state.
#[derive(Debug)]
pub struct CyclicLoop {
    pub machine: Machine,
    pub buffer: SetpointBuffer,
    pace: Pace,
    pub(super) pacing: Pacing,
    jitter_trials: u32,
    pub(super) cycle: Duration,
    pub inbound: Receiver<Inbound>,
    outbound: Sender<Outbound>,
    pub bounds: Arc<Bounds>,
    /// Ticks that may be executed beyond what is in the bag.
    recorder_window: u64,
    pub commands: [Option<TimedCommand>; PENDING_COMMANDS],
    now: [MachineCommand; 4],
    pub faults: Faults,
    /// Chunks that still get lost, and when the last one was.
    pub losing: u32,
    pub lost: Option<Instant>,
    pub state: StreamState,
    /// Persistent state as it was last published.
    published_state: PersistentState,
    pub last_report: Option<TickReport>,
    /// Last tick with a setpoint of a client.
    last_setpoint_tick: u64,
    /// Result of an order for door, chuck or part, until a tick has reported it.
    pub area_done: Option<(AreaOrder, Result<(), LoadingRefused>)>,
    /// Result of the last reset, until a tick has reported it.
    pub reset_done: Option<Result<(), ResetRefused>>,
    /// Orders of the emergency stop that the next tick applies.
    pub estop_orders: u32,
    pub active: bool,
    pub job_running: bool,
    pub keyframes: Keyframes,
    pub partners: MachinePartners,
    /// Real drives.
    pub(super) bus: Option<BusState>,
}

// Requests are answered before a tick is over; the rest are the caller's handles and published values.
camwright::snapshot!(CyclicLoop { machine, buffer, commands, faults, losing, state, job_running } on {
    pace, pacing, jitter_trials, cycle, inbound, outbound, bounds, recorder_window, now, lost, published_state, last_report, last_setpoint_tick, area_done, reset_done, estop_orders,
    active, keyframes, partners, bus,
});

impl CyclicLoop {
    /// Walks through the state of a keyframe, at whose end stands what only some machines have in use.
    ///
    /// # Errors
    /// Those of the walk.
    pub fn walk_keyframe(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        self.snapshot(codec)?;
        self.machine.snapshot_size_monitor(codec)
    }

    pub fn new(
        machine: Machine,
        pace: Pace,
        inbound: Receiver<Inbound>,
        outbound: Sender<Outbound>,
        bounds: Arc<Bounds>,
        recorder_window: u64,
    ) -> Self {
        let description = machine.description();
        let cycle = Duration::from_nanos(u64::from(description.cycle_time_ns));
        let clock = TickClock { epoch_ns: 0, cycle_time_ns: description.cycle_time_ns };
        let buffer = SetpointBuffer::new(description, machine.setpoint());
        Self {
            published_state: *machine.lasting(),
            machine,
            buffer,
            pace,
            pacing: Pacing::new(clock),
            jitter_trials: 0,
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
            last_setpoint_tick: 0,
            area_done: None,
            reset_done: None,
            estop_orders: 0,
            active: false,
            job_running: false,
            keyframes: Keyframes::default(),
            partners: MachinePartners::default(),
            bus: None,
        }
    }

    /// With the clock that ticks follow at pace realtime.
    pub fn with_clock(self, clock: TickClock) -> Self {
        Self { pacing: Pacing::new(clock), ..self }
    }

    /// Runs until the node ends.
    pub fn run(mut self, waker: &Waker) {
        waker.adopt_current_thread();
        let (began, mut deadline) = (Instant::now(), Instant::now());
        while !self.bounds.stop.load(Ordering::Acquire) {
            injected::point("machine cycle");
            let is_addressed = self.receive();
            self.halt_at_rest();
            self.check_recorder(Instant::now());
            if self.bus.is_some() && self.outbound.free() >= 64 {
                self.run_bus(waker);
            } else if !self.active {
                self.pacing.suspend();
                self.wait_inactive(waker);
                deadline = Instant::now();
            } else if self.outbound.free() < 64 {
                // The pump is behind; its messages are more important than the next tick.
                let _woken = waker.wait(PUMP_BEHIND);
                deadline = deadline.max(Instant::now());
            } else {
                match self.pace {
                    Pace::Fast => self.run_fast(&mut deadline, waker),
                    Pace::Realtime => self.run_realtime(began, is_addressed, waker),
                }
            }
        }
        if self.active {
            self.come_to_rest(waker);
        }
        // What a job that was not finished took off the wheel.
        if *self.machine.lasting() != self.published_state {
            self.publish_persistent();
        }
    }

    /// Waits for activation; meanwhile a realtime machine measures how late the computer wakes its cycle.
    fn wait_inactive(&mut self, waker: &Waker) {
        if self.pace == Pace::Fast || self.jitter_trials >= JITTER_TRIALS {
            let _woken = waker.wait(Duration::from_millis(100));
            return;
        }
        self.jitter_trials += 1;
        let due = Instant::now() + self.cycle;
        if !waker.wait(self.cycle) {
            self.note_pause(due.elapsed());
        }
    }

    /// The cycle was kept waiting for so long.
    pub(super) fn note_pause(&self, pause: Duration) {
        let pause_us = u64::try_from(pause.as_micros()).unwrap_or(u64::MAX);
        self.bounds.longest_pause_us.fetch_max(pause_us, Ordering::Relaxed);
    }

    fn run_fast(&mut self, deadline: &mut Instant, waker: &Waker) {
        let now = Instant::now();
        // How many ticks pass before the next motion is chance: it begins when none of them changes anything any more.
        self.withhold_credit(self.is_idle() && self.is_wheel_changing());
        if self.may_run_fast() {
            self.tick();
            self.stop_waiting_for_partners(now);
            *deadline = now + FAST_IDLE_TICK;
        } else if self.is_moving() {
            // Setpoints or the recorder are behind: wait for their news.
            let _woken = waker.wait(HEARTBEAT / 4);
            self.wait_for_partners();
        } else if now >= *deadline {
            self.tick();
            self.stop_waiting_for_partners(now);
            *deadline = now + FAST_IDLE_TICK;
        } else {
            let _woken = waker.wait(*deadline - now);
        }
    }

    fn run_realtime(&mut self, began: Instant, is_addressed: bool, waker: &Waker) {
        let moment = CycleTime {
            monotonic_ns: i64::try_from(began.elapsed().as_nanos()).unwrap_or(i64::MAX),
            system_ns: system_time_ns(),
            tick: self.machine.tick(),
            is_idle: self.is_idle(),
            has_room: self.has_room(),
            rests: !is_addressed && self.rests(),
        };
        let step = self.pacing.next(&moment);
        if let Some(slip) = self.pacing.take_slip() {
            self.bounds.slips.fetch_add(u64::from(!matches!(slip, Slip::MadeUp(_))), Ordering::Relaxed);
            self.send(Outbound::Slip(slip));
        }
        let withheld = self.pacing.withholds_credit();
        self.withhold_credit(withheld);
        match step {
            PacingStep::Tick(late_ns) => {
                let behind_us = self.pacing.behind_ns(&moment) / 1000;
                if !withheld {
                    self.note_pause(Duration::from_nanos(u64::try_from(late_ns).unwrap_or(0)));
                }
                self.bounds.behind_us.store(behind_us, Ordering::Relaxed);
                if late_ns > i64::from(self.machine.description().cycle_time_ns) && !withheld {
                    self.bounds.late_ticks.fetch_add(1, Ordering::Relaxed);
                    self.bounds.worst_late_us.fetch_max(u64::try_from(late_ns / 1000).unwrap_or(0), Ordering::Relaxed);
                }
                self.tick();
                self.stop_waiting_for_partners(Instant::now());
            }
            PacingStep::Wait(time) => {
                let _woken = waker.wait(time);
            }
        }
    }

    pub(super) fn withhold_credit(&mut self, withheld: bool) {
        self.state.news |= withheld != self.state.no_credit;
        self.state.no_credit = withheld;
    }

    /// The wheel runs up or down, and no alarm has stopped what it is for.
    fn is_wheel_changing(&self) -> bool {
        self.machine.is_wheel_changing() && !self.is_stopped_by_alarm()
    }

    /// Nothing moves, and nothing that moves has been announced.
    fn is_idle(&self) -> bool {
        !self.has_work(self.machine.tick() + 1) && (self.buffer.is_spent() || self.is_stopped_by_alarm())
    }

    /// Returns whether the next ticks can only repeat the last one, unless a message comes.
    fn rests(&self) -> bool {
        self.is_idle()
            && !self.state.has_holder
            && !self.state.news
            && !self.job_running
            && self.reset_done.is_none()
            && self.commands.iter().all(Option::is_none)
            && !self.machine.is_wheel_changing()
            && self.last_report.is_some_and(|last| last.motion == MotionState::Standstill)
    }

    /// Setpoints for more than half of the credit are there.
    fn has_room(&self) -> bool {
        let ahead = u64::from(self.machine.description().feedback_delay_ticks) / 2;
        self.buffer.supply(self.machine.tick() + 1 + ahead) == Supply::Dense
    }

    /// Publishes the persistent state if it has changed.
    pub fn publish_persistent(&mut self) {
        self.published_state = *self.machine.lasting();
        self.send(Outbound::Lasting(self.published_state));
    }

    /// Brings the axes to rest before the thread ends: what was sent runs out on its stop, nothing more is taken.
    fn come_to_rest(&mut self, waker: &Waker) {
        self.end_motion();
        let (latest, soon) = (self.machine.tick() + LONGEST_STOP_TICKS, Instant::now() + ENDING);
        // One tick at least, which reports the alarm.
        loop {
            let now = Instant::now();
            if self.bus.is_some() {
                // The stop travels to the drives as every setpoint does.
                self.run_bus(waker);
            } else if now < soon && (self.pace == Pace::Realtime || self.outbound.free() < 64) {
                let _woken = waker.wait(self.cycle);
                self.tick();
            } else {
                self.tick();
            }
            let is_over = !self.buffer.has_setpoints() && self.machine.is_at_rest();
            if is_over || self.machine.tick() >= latest {
                return;
            }
        }
    }

    /// Something is under way that must go on without the wall clock.
    fn is_moving(&self) -> bool {
        let next = self.machine.tick() + 1;
        // After an alarm nothing that was sent is waited for.
        !self.is_stopped_by_alarm() && (self.partners.attends || self.buffer.is_underrun(next) || self.has_work(next))
    }

    fn has_work(&self, next: u64) -> bool {
        self.buffer.has_setpoints()
            || !self.machine.is_at_rest()
            || self.machine.is_being_loaded()
            || self.machine.is_mounting()
            || self.area_done.is_some()
            || self.commands.iter().flatten().any(|c| c.tick >= next)
    }

    /// At pace fast a tick is executed when its setpoint is there, or when there is nothing to wait for.
    fn may_run_fast(&self) -> bool {
        let next = self.machine.tick() + 1;
        if self.is_held_by_recorder() {
            return false;
        }
        if self.is_stopped_by_alarm() {
            let works = self.machine.is_being_loaded() || self.machine.is_mounting();
            return !self.machine.is_at_rest() || works || self.area_done.is_some();
        }
        // A wheel that runs up or down does so before what is announced begins: how far it came would be chance.
        if self.partners.attends && !self.buffer.has_setpoints() && !self.is_wheel_changing() {
            return false;
        }
        let has_work = self.has_work(next) || (self.buffer.is_spent() && self.is_wheel_changing());
        has_work && (self.is_given_up() || !self.buffer.is_underrun(next)) && !self.awaits_stream(next)
    }

    /// Returns whether the next tick waits until the recorder has caught up.
    pub fn is_held_by_recorder(&self) -> bool {
        self.pace == Pace::Fast && self.partners.waits_for_recorder(&self.bounds) && self.is_beyond_recorder()
    }

    /// The next tick is farther ahead of the recorder than it may be.
    pub fn is_beyond_recorder(&self) -> bool {
        let recorded = self.bounds.recorded_tick.load(Ordering::Acquire);
        self.machine.tick() + 1 > recorded.saturating_add(self.recorder_window)
    }

    /// Returns whether lost setpoints are given up: the loop waits for a while for the chunk after them, which proves the loss.
    fn is_given_up(&self) -> bool {
        self.lost.is_some_and(|since| self.losing > 0 || since.elapsed() > AFTER_A_LOSS)
    }

    /// A job begins with this tick, or an order lies ahead of a stream that has not begun: its first setpoints are still on their
    /// way, and must not find their ticks executed.
    fn awaits_stream(&self, next: u64) -> bool {
        let begins = |c: &TimedCommand| matches!(c.order, MachineOrder::JobBegin) && c.tick <= next;
        let is_ahead = |c: &TimedCommand| self.buffer.is_spent() && c.tick > next;
        !self.buffer.has_setpoints() && self.commands.iter().flatten().any(|c| begins(c) || is_ahead(c))
    }

    pub fn is_stopped_by_alarm(&self) -> bool {
        self.machine.alarms().iter().any(|alarm| alarm.kind.entry().severity > AlarmSeverity::Warning)
    }

    /// Executes one tick: step of the machine, state of the stream, messages, keyframe.
    pub fn tick(&mut self) {
        let next = self.machine.tick() + 1;
        self.raise_underrun(next);
        let report = self.step_machine(next);
        self.update_stream_state(&report);
        let is_quiet = self.is_quiet(&report);
        self.last_report = Some(report);
        let (now, published) = (self.machine.lasting(), &self.published_state);
        if now.dress_count != published.dress_count || now.mounted_wheel() != published.mounted_wheel() {
            self.publish_persistent();
        }
        self.update_bounds(next);
        // Readings of real drives are older than the job when it begins.
        let is_of_job = report.tick >= self.state.job_tick;
        let state = StreamState { job_tick: if is_of_job { self.state.job_tick } else { 0 }, ..self.state };
        if self.bus.is_some() && !self.active {
            // The drives' clock goes on; what rests is not shown.
        } else if is_quiet {
            self.send_quietly(Outbound::Tick(report, state));
        } else {
            self.send(Outbound::Tick(report, state));
        }
        self.answer_area();
        self.answer_reset();
        self.answer_estops();
        self.state.news = false;
        self.state.alarms_reset = false;
        self.write_keyframe();
    }

    /// Raises an alarm if the setpoint of the next tick is missing.
    fn raise_underrun(&mut self, next: u64) {
        if self.buffer.is_underrun(next) && !self.is_stopped_by_alarm() {
            self.machine.raise(AlarmKind::Underrun, 0.0, 0.0);
            self.buffer.close();
            self.state.news = true;
        }
    }

    /// Steps the machine with the setpoint, the commands and the faults of a tick.
    fn step_machine(&mut self, next: u64) -> TickReport {
        let setpoint = self.buffer.at(next);
        if setpoint.is_some() {
            self.last_setpoint_tick = next;
        }
        let count = self.execute_due(next);
        let faults = self.faults.due(next);
        for fault in faults.iter() {
            if let Fault::LostChunks(chunks) = fault {
                self.losing = *chunks;
            }
        }
        let (setpoint, orders) = (setpoint.as_ref(), &self.now[..count]);
        let mut report = match &self.bus {
            None => self.machine.step(setpoint, orders, &faults),
            Some(bus) => self.machine.step_measured(setpoint, orders, &faults, &bus.measurement),
        };
        self.buffer.executed(next);
        if self.is_stopped_by_alarm() && report.raised.iter().next().is_some() {
            self.buffer.close();
        }
        // Setpoints that wait for their tick are no standstill.
        if report.motion == MotionState::Standstill && self.buffer.has_setpoints() {
            report.motion = MotionState::Running;
        }
        report
    }

    /// Marks what is new on the stream, and ends the holder's right when its setpoints are spent.
    fn update_stream_state(&mut self, report: &TickReport) {
        let is_raised = report.raised.iter().next().is_some();
        self.state.news |= is_raised || self.last_report.is_none_or(|last| last.motion != report.motion);
        // Readings of real drives show the last setpoint later.
        let is_shown = report.tick >= self.last_setpoint_tick;
        if self.state.has_holder && self.buffer.is_spent() && is_shown {
            self.state.has_holder = false;
            self.state.news = true;
        }
        if report.motion == MotionState::Standstill && self.state.alarms_reset {
            self.state.news = true;
        }
    }

    /// Updates the figures that other threads read without a message.
    fn update_bounds(&self, tick: u64) {
        self.bounds.tick.store(tick, Ordering::Relaxed);
        self.bounds.in_motion.store(self.state.has_holder, Ordering::Relaxed);
        let alarms =
            self.machine.alarms().iter().filter(|alarm| alarm.kind.entry().severity > AlarmSeverity::Warning).count();
        self.bounds.alarms.store(alarms as u64, Ordering::Relaxed);
    }

    /// Executes the orders of a tick; those of the machine go into `now`. Returns their number.
    fn execute_due(&mut self, tick: u64) -> usize {
        let mut count = 0;
        for index in 0..PENDING_COMMANDS {
            let Some(command) = self.commands[index].filter(|command| command.tick <= tick) else { continue };
            match command.order {
                MachineOrder::Machine(order) if count < self.now.len() => {
                    self.now[count] = order;
                    count += 1;
                }
                // More than four orders of one tick: the rest follows in the next.
                MachineOrder::Machine(_) => continue,
                MachineOrder::JobBegin => {
                    self.job_running = true;
                    self.state.job_tick = tick;
                    self.machine.begin_job();
                    self.faults.begin_job(tick);
                }
                MachineOrder::JobEnd => {
                    self.faults.end_job();
                    self.state.job_tick = 0;
                    if std::mem::take(&mut self.job_running) {
                        self.machine.count_part();
                        self.publish_persistent();
                        self.send(Outbound::JobEnded);
                    }
                }
                // Takes effect when it comes, and never waits here.
                MachineOrder::Attend => {}
            }
            self.commands[index] = None;
        }
        count
    }

    /// A tick of a resting machine that shows nothing new, and is not due on the stream: no reason to wake the pump.
    fn is_quiet(&self, report: &TickReport) -> bool {
        let is_idle = report.motion == MotionState::Standstill && !self.state.has_holder;
        let machine = self.machine.description();
        let period = if is_idle { machine.rest_stream_period_ticks() } else { machine.stream_period_ticks() };
        let repeats = |last: &TickReport| TickReport { tick: report.tick, ..*last } == *report;
        self.pace == Pace::Realtime
            && self.state.job_tick == 0
            && !self.state.news
            && !report.tick.is_multiple_of(period)
            && self.last_report.as_ref().is_some_and(repeats)
    }

    fn send_quietly(&mut self, message: Outbound) {
        if let Err(back) = self.outbound.send_quietly(message) {
            self.send(back);
        }
    }

    pub fn send(&mut self, message: Outbound) {
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
