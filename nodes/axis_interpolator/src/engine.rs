// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The interpolator's cyclic thread: it has no clock and computes when the machine grants credit.
//!
//! ```text
//! machine/stream ─► feedback ─► step, step, step … up to the credit ─► chunk with its stop ─► machine/setpoints
//! ```
//! An order to the machine takes effect at a tick ahead; no setpoint from that tick on leaves before the machine has
//! acknowledged it. So what is executed depends on ticks alone, never on when messages arrive.

use super::engine_messages::{
    Ended, FromEngine, JobEnds, MachineFeedback, PreparedMotion, SequencedCommand, ToEngine, Tracking,
};
use super::next_trajectory::NextTrajectory;
use super::receipts::Receipts;
use camwright::interpolator::{
    ExecutionState, Interpolator, InterpolatorEvent, InterpolatorStatus, MotionOutcome, MotionRequest, StartError,
    TickInputs,
};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use camwright::machine::setpoint::Setpoint;
use camwright_files::convert::setpoints::{CHUNK_TICKS, ChunkBuffer, STOP_POINTS, add_stop};
use camwright_threads::ring::{Receiver, Sender, Waker};
use camwright_threads::supervised::injected;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Requests that may wait for the next tick.
const REQUESTS: usize = 16;
/// Period of the state in a motion (s of machine time).
const STATUS_PERIOD_S: f64 = 0.05;
/// Longest wait for a machine to attend to a motion.
const ATTENTION: Duration = Duration::from_secs(5);
/// Empty chunks that go round between engine and pump.
pub(super) const CHUNK_POOL: usize = 32;

/// A motion between its first and its last tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct Running {
    job: JobEnds,
    /// It is over with its last setpoint; what else is executed is over when the axes stand still.
    is_trajectory: bool,
    first_tick: u64,
    /// Outcome, once the last setpoint has been computed.
    pub(super) outcome: Option<(MotionOutcome, u64)>,
}

pub(super) struct Engine {
    pub(super) machine: MachineDescription,
    pub(super) interpolator: Interpolator,
    inbox: Receiver<ToEngine>,
    outbox: Sender<FromEngine>,
    stop: Arc<AtomicBool>,
    #[allow(clippy::vec_box, reason = "chunks travel through the ring in their box; moving them would copy")]
    pool: Vec<Box<ChunkBuffer>>,
    /// A chunk that waits until the machine knows of an order within it: the job's end, or an alarm.
    withheld: Option<Box<ChunkBuffer>>,
    /// The last news; `None` before the machine has spoken.
    seen: Option<LastFeedback>,
    pub(super) running: Option<Running>,
    pub(super) next_tick: u64,
    sequence: u32,
    /// Orders that must be acknowledged before setpoints of their ticks may leave.
    pub(super) unacknowledged: Receipts,
    requests: [Option<MotionRequest>; REQUESTS],
    pub(super) next_trajectory: NextTrajectory,
    /// A motion that begins when the axes stand still.
    waiting: Option<(PreparedMotion, JobEnds)>,
    /// A motion that begins with the machine's next message, at pace fast when the machine attends to it; and since when it waits.
    attending: Option<(PreparedMotion, JobEnds, Instant)>,
    known_alarms: [u16; 16],
    last_status: Option<(u64, InterpolatorStatus)>,
    /// Ticks between two states in a motion.
    status_period_ticks: u64,
}

#[derive(Debug, Clone, Copy)]
struct LastFeedback {
    tick: u64,
    credit_tick: u64,
    is_standstill: bool,
    is_realtime: bool,
    has_alarms: bool,
    counts: [i64; AXIS_COUNT],
    commands_received: u32,
}

impl LastFeedback {
    /// A machine that withholds its credit at rest is about to execute many ticks: what begins now would come late.
    fn gives_credit(&self) -> bool {
        self.credit_tick > self.tick
    }
}

impl Engine {
    pub(super) fn new(
        machine: &MachineDescription,
        inbox: Receiver<ToEngine>,
        outbox: Sender<FromEngine>,
        stop: Arc<AtomicBool>,
    ) -> Self {
        let chunk = || {
            Box::new(ChunkBuffer {
                dense: Vec::with_capacity(CHUNK_TICKS),
                tail: Vec::with_capacity(STOP_POINTS + 1),
                ..ChunkBuffer::default()
            })
        };
        Self {
            interpolator: Interpolator::new(machine),
            machine: machine.clone(),
            inbox,
            outbox,
            stop,
            pool: (0..CHUNK_POOL).map(|_| chunk()).collect(),
            withheld: None,
            seen: None,
            running: None,
            next_tick: 0,
            sequence: 0,
            unacknowledged: Receipts::default(),
            requests: [None; REQUESTS],
            next_trajectory: NextTrajectory::default(),
            waiting: None,
            attending: None,
            known_alarms: [0; 16],
            last_status: None,
            status_period_ticks: status_period_ticks(machine.cycle_time_s()),
        }
    }

    /// Runs until the node ends.
    pub(super) fn run(mut self, waker: &Waker) {
        waker.adopt_current_thread();
        while !self.stop.load(Ordering::Acquire) {
            injected::point("interpolator cycle");
            self.cycle();
            let _woken = waker.wait(Duration::from_millis(100));
        }
    }

    /// Takes what has arrived and computes what it allows.
    pub(super) fn cycle(&mut self) {
        self.receive();
        self.give_up_attention();
        self.compute();
    }

    fn receive(&mut self) {
        while let Some(message) = self.inbox.receive() {
            match message {
                ToEngine::News(news) => {
                    self.apply_feedback(&news);
                    self.send(FromEngine::Used(news));
                }
                ToEngine::Start { made, job } => self.start(made, job),
                ToEngine::Request(request) => self.ask(request),
                ToEngine::Foresee { soonest } => self.foresee(soonest),
                ToEngine::Splice(made) => self.take_successor(made),
                ToEngine::StayOn => self.next_trajectory = NextTrajectory::None,
                ToEngine::MachineLost => self.lose_machine(),
                ToEngine::Query { tick } => {
                    let setpoint = self.interpolator.desired_at(tick).copied();
                    let setpoint =
                        setpoint.filter(|_| self.running.is_some()).or_else(|| self.interpolator.planned_at(tick));
                    self.send(FromEngine::Queried(setpoint));
                }
                ToEngine::Chunk(chunk) => {
                    if self.pool.len() < CHUNK_POOL {
                        self.pool.push(chunk);
                    }
                }
            }
            // The wait of the one in command may be over with this message.
            self.answer_forecast();
        }
    }

    /// A request for the next tick that is computed. Of several overrides that wait the last counts; between motions one waits for the
    /// next, like the knob that it is.
    fn ask(&mut self, request: MotionRequest) {
        if request == MotionRequest::Cancel
            && let Some(made) = self.take_waiting()
        {
            self.send(FromEngine::NotStarted(StartError::Cancelled, made));
            return;
        }
        let before = self.requests;
        let outdated = |old: &MotionRequest| is_override(old) && is_override(&request);
        let kept = before.iter().flatten().copied().filter(|old| !outdated(old));
        self.wait(kept.chain([request]));
        if is_override(&request) && self.running.is_none() {
            self.publish_idle();
        }
    }

    /// A hold or a cancel waits for the next tick.
    pub(super) fn is_disturbed(&self) -> bool {
        self.requests.iter().flatten().any(|request| matches!(request, MotionRequest::Hold | MotionRequest::Cancel))
    }

    /// Makes these the requests that wait, as many as there is room for.
    fn wait(&mut self, requests: impl Iterator<Item = MotionRequest>) {
        self.requests = [None; REQUESTS];
        for (place, request) in self.requests.iter_mut().zip(requests) {
            *place = Some(request);
        }
    }

    fn apply_feedback(&mut self, news: &MachineFeedback) {
        let stopped_before = self.seen.map(|seen| seen.has_alarms);
        for latch in &news.latches {
            self.interpolator.feedback(latch);
        }
        if let Some(measured) = &news.measured {
            self.interpolator.measured(measured);
            let at_rest = Setpoint { counts: news.setpoint_counts, ..Setpoint::default() };
            let setpoint = self.interpolator.desired_at(measured.tick).copied().unwrap_or(at_rest);
            self.send(FromEngine::Tracking(Tracking { setpoint, measured: *measured }));
        }
        for (place, number) in self.known_alarms.iter_mut().zip(news.alarms.iter().copied().chain(std::iter::repeat(0)))
        {
            let is_new = number != 0 && *place != number;
            *place = number;
            // Warnings stop nothing; every alarm that does is in its kind's table as such.
            if is_new && stops_motion(number) {
                self.interpolator.alarm(news.tick, number);
                // An axis whose encoder jumped has lost its zero.
                if let Some(AlarmKind::EncoderJump(axis)) = AlarmKind::from_number(number)
                    && self.machine.axis(axis).needs_homing
                {
                    self.interpolator.set_homed(axis, false);
                }
            }
        }
        self.seen = Some(LastFeedback {
            tick: news.tick,
            credit_tick: news.credit_tick,
            is_standstill: news.is_standstill,
            is_realtime: news.is_realtime,
            has_alarms: news.alarms.iter().copied().any(stops_motion),
            counts: news.setpoint_counts,
            commands_received: news.commands_received,
        });
        if self.running.is_some() {
            self.abandon_after_alarm();
        } else if news.is_standstill && !self.has_alarms() {
            // Between motions the machine's word counts; after an alarm's reset this is where it goes on from.
            if self.interpolator.setpoint().counts != news.setpoint_counts || !self.interpolator.is_idle() {
                self.interpolator.resync(news.setpoint_counts);
            }
        }
        self.unacknowledged.received(news.commands_received);
        self.report_end();
        self.start_waiting();
        if self.running.is_none() && stopped_before != Some(self.has_alarms()) {
            self.publish_idle();
        }
    }

    fn has_alarms(&self) -> bool {
        self.seen.is_some_and(|seen| seen.has_alarms)
    }

    /// An alarm has stopped the machine: what was under way is over once it stands.
    fn abandon_after_alarm(&mut self) {
        let Some(seen) = self.seen.filter(|seen| seen.has_alarms) else { return };
        let Some(running) = &mut self.running else { return };
        let number = self.known_alarms.iter().copied().find(|number| stops_motion(*number)).unwrap_or(0);
        running.outcome = Some((MotionOutcome::Failed(number), seen.tick));
        self.unacknowledged.clear();
        self.drop_withheld();
    }

    fn drop_withheld(&mut self) {
        if let Some(mut chunk) = self.withheld.take() {
            chunk.clear();
            self.pool.push(chunk);
        }
    }

    /// A motion has not begun yet.
    pub(super) fn has_waiting(&self) -> bool {
        self.waiting.is_some() || self.attending.is_some()
    }

    /// The motion that has not begun yet, which does not begin any more.
    fn take_waiting(&mut self) -> Option<PreparedMotion> {
        let attending = self.attending.take().map(|(made, ..)| made);
        let made = attending.or_else(|| self.waiting.take().map(|(made, _)| made))?;
        self.drop_requests();
        Some(made)
    }

    /// Requests for a motion that is over, or that does not begin, do not apply to the next one. An override does.
    fn drop_requests(&mut self) {
        let before = self.requests;
        self.wait(before.iter().flatten().copied().filter(is_override));
    }

    /// Nothing that the machine said counts any more: what is under way is over, and zeros have to be found again.
    fn lose_machine(&mut self) {
        let number = AlarmKind::MachineLost.entry().number;
        if let Some(made) = self.take_waiting() {
            self.send(FromEngine::NotStarted(StartError::MachineLost, made));
            self.answer_forecast();
        }
        let Some(seen) = self.seen.take() else { return };
        self.unacknowledged.clear();
        self.drop_withheld();
        self.known_alarms = [0; 16];
        for axis in Axis::ALL.into_iter().filter(|axis| self.machine.axis(*axis).needs_homing) {
            self.interpolator.set_homed(axis, false);
        }
        self.interpolator.resync(seen.counts);
        if let Some(finished) = self.interpolator.take_finished() {
            self.send(FromEngine::Done(finished));
        }
        self.next_trajectory = NextTrajectory::None;
        if let Some(running) = self.running.take() {
            self.drop_requests();
            let (first_tick, counts) = (running.first_tick, seen.counts);
            let ended = Ended { outcome: MotionOutcome::Failed(number), first_tick, last_tick: seen.tick, counts };
            self.send(FromEngine::Ended(ended));
        }
        let status = InterpolatorStatus { state: ExecutionState::Fault, ..self.interpolator.idle_status() };
        self.last_status = None;
        self.send(FromEngine::Status { tick: seen.tick, status });
    }

    /// Begins a motion, as soon as the axes stand still. A trajectory may follow another before that, whose setpoints rest already,
    /// where ticks follow the clock: at pace fast those in which the axes settle pass by themselves.
    fn start(&mut self, made: PreparedMotion, job: JobEnds) {
        let refusal = match self.seen {
            _ if self.running.is_some() || self.has_waiting() => Some(StartError::Busy),
            Some(seen) if !seen.has_alarms => None,
            Some(_) => Some(StartError::Fault),
            None => Some(StartError::MachineLost),
        };
        match (refusal, self.seen) {
            (None, Some(seen)) if seen.gives_credit() && seen.is_standstill => self.attend(made, job, seen),
            (None, Some(seen))
                if seen.gives_credit()
                    && seen.is_realtime
                    && made.motion.is_trajectory()
                    && self.interpolator.is_idle() =>
            {
                self.begin_sequence(seen);
                self.start_now(made, job, seen);
            }
            (None, _) => self.waiting = Some((made, job)),
            (Some(error), _) => self.send(FromEngine::NotStarted(error, made)),
        }
    }

    /// Starts the waiting motion when the axes stand still; an alarm ends the wait.
    fn start_waiting(&mut self) {
        let may_begin = |seen: &LastFeedback| seen.has_alarms || (seen.is_standstill && seen.gives_credit());
        let Some(seen) = self.seen.filter(may_begin) else { return };
        if seen.has_alarms {
            if let Some(made) = self.take_waiting() {
                self.send(FromEngine::NotStarted(StartError::Fault, made));
            }
        } else if let Some((made, job)) = self.waiting.take() {
            self.attend(made, job, seen);
        } else if self.unacknowledged.is_empty()
            && let Some((made, job, _)) = self.attending.take()
        {
            self.start_now(made, job, seen);
        }
    }

    /// Prepares the start of a motion of a machine at rest, with the machine's next message. At pace realtime the tick of the last one
    /// may be old, since a machine at rest reports less often. At pace fast the machine has to attend: a tick that passed could not be
    /// made up for, and setpoints for it would be late.
    fn attend(&mut self, made: PreparedMotion, job: JobEnds, seen: LastFeedback) {
        self.begin_sequence(seen);
        self.attending = Some((made, job, Instant::now()));
        if !seen.is_realtime {
            self.command(SequencedCommand::Attend { tick: seen.tick }, u64::MAX);
        }
    }

    /// Continues the command number from what the machine has received, so that no receipt of an earlier motion counts for this one.
    fn begin_sequence(&mut self, seen: LastFeedback) {
        self.sequence = seen.commands_received;
        self.unacknowledged.clear();
    }

    /// A machine that is alive and does not attend ends the wait.
    fn give_up_attention(&mut self) {
        if let Some((made, ..)) = self.attending.take_if(|(_, _, since)| since.elapsed() > ATTENTION) {
            self.unacknowledged.clear();
            self.drop_requests();
            self.send(FromEngine::NotStarted(StartError::MachineLost, made));
            self.answer_forecast();
        }
    }

    fn start_now(&mut self, made: PreparedMotion, job: JobEnds, seen: LastFeedback) {
        let PreparedMotion { motion, record } = made;
        let is_trajectory = motion.is_trajectory();
        let rest = self.interpolator.rest_state();
        if let Err((error, motion)) = self.interpolator.start(motion) {
            self.send(FromEngine::NotStarted(error, PreparedMotion { motion, record }));
            return;
        }
        // Far enough ahead for the first chunk to arrive in time, near enough for it to lie within the credit.
        let lead = u64::from(self.machine.feedback_delay_ticks) * 6 / 10;
        let first_tick = seen.tick + lead.max(1);
        self.next_tick = first_tick;
        self.running = Some(Running { job, is_trajectory, first_tick, outcome: None });
        self.send(FromEngine::Started { tick: first_tick, rest, record });
        if job.begins {
            self.command(SequencedCommand::JobBegin { tick: first_tick }, first_tick);
        }
    }

    fn command(&mut self, command: SequencedCommand, tick: u64) {
        self.sequence += 1;
        self.unacknowledged.sent(self.sequence, tick);
        self.send(FromEngine::Command { sequence: self.sequence, command });
    }

    /// Computes what credit and acknowledgements allow.
    fn compute(&mut self) {
        loop {
            let (Some(seen), Some(running)) = (self.seen, self.running) else { return };
            if let Some(chunk) = self.withheld.take() {
                if !self.unacknowledged.is_empty() {
                    self.withheld = Some(chunk);
                    return;
                }
                self.send(FromEngine::Chunk(chunk));
                return;
            }
            if running.outcome.is_some() || self.unacknowledged.is_full() {
                return;
            }
            self.answer_forecast();
            self.succeed();
            let bound = self.unacknowledged.last_tick();
            let last = seen.credit_tick.min(bound).min(self.next_trajectory.last_tick());
            if self.next_tick > last {
                return;
            }
            let Some(chunk) = self.pool.pop() else { return };
            self.fill(chunk, last);
        }
    }

    /// One chunk from the next tick on, at most to `last`.
    fn fill(&mut self, mut chunk: Box<ChunkBuffer>, last: u64) {
        chunk.clear();
        chunk.first_tick = self.next_tick;
        let mut last = last;
        while self.next_tick <= last && chunk.dense.len() < CHUNK_TICKS {
            let tick = self.next_tick;
            let mut pending = [MotionRequest::Hold; REQUESTS];
            let mut count = 0;
            for request in self.requests.iter().flatten() {
                pending[count] = *request;
                count += 1;
            }
            let out = self.interpolator.step(&TickInputs { tick, requests: &pending[..count] });
            self.retain_requests(&pending[..count], out.requests_taken);
            chunk.dense.push(out.setpoint);
            self.next_tick += 1;
            for input in out.applied.iter() {
                self.send(FromEngine::Applied { tick, input: *input });
            }
            for order in out.orders.iter() {
                self.command(SequencedCommand::Interpolator(*order), order.tick);
                last = last.min(order.tick - 1);
            }
            self.publish(tick, &out.status);
            for event in out.events.iter() {
                self.send(FromEngine::Event { tick, event: *event });
                if let InterpolatorEvent::Alarm(alarm) = event {
                    self.command(SequencedCommand::Alarm { tick, number: alarm.number() }, tick);
                    last = last.min(tick);
                }
                if let (InterpolatorEvent::Finished(outcome), Some(running)) = (event, &mut self.running) {
                    running.outcome = Some((*outcome, tick));
                }
            }
            if self.running.is_some_and(|running| running.outcome.is_some()) {
                break;
            }
        }
        if let Some(finished) = self.interpolator.take_finished() {
            self.send(FromEngine::Done(finished));
        }
        let Some(running) = self.running else { return };
        match running.outcome {
            // Only a job that came to its end has made a part.
            Some((MotionOutcome::Completed, tick)) if running.job.ends => {
                chunk.is_final = true;
                self.command(SequencedCommand::JobEnd { tick }, tick);
            }
            Some(_) => chunk.is_final = true,
            None => self.add_stop(&mut chunk),
        }
        // An order of one of its ticks must not come after it.
        if self.next_tick > self.unacknowledged.last_tick().saturating_add(1) {
            self.withheld = Some(chunk);
        } else {
            self.send(FromEngine::Chunk(chunk));
        }
    }

    /// Requests that were not taken wait for the next tick, in their order.
    fn retain_requests(&mut self, pending: &[MotionRequest], taken: usize) {
        self.wait(pending.iter().skip(taken).copied());
    }

    /// The stop that the machine follows if nothing newer comes.
    fn add_stop(&self, chunk: &mut ChunkBuffer) {
        add_stop(&self.interpolator, &self.machine, self.next_tick - 1, chunk);
    }

    /// Status on change of what people watch, and every 50 ms.
    fn publish(&mut self, tick: u64, status: &InterpolatorStatus) {
        let due = self.last_status.is_none_or(|(last, before)| {
            tick >= last + self.status_period_ticks
                || before.state != status.state
                || before.segment != status.segment
                || before.phase != status.phase
        });
        if due {
            self.last_status = Some((tick, *status));
            self.send(FromEngine::Status { tick, status: *status });
        }
    }

    /// A motion is over when the machine has executed its last setpoint, and stands if it is not a trajectory.
    fn report_end(&mut self) {
        let (Some(seen), Some(running)) = (self.seen, self.running) else { return };
        let Some((outcome, last_tick)) = running.outcome else { return };
        // An order that is not acknowledged yet may be an alarm.
        if self.withheld.is_some()
            || !self.unacknowledged.is_empty()
            || seen.tick < last_tick
            || !(seen.is_standstill || seen.has_alarms || running.is_trajectory)
        {
            return;
        }
        self.running = None;
        self.drop_requests();
        self.unacknowledged.clear();
        self.next_trajectory = NextTrajectory::None;
        if seen.has_alarms || matches!(outcome, MotionOutcome::Failed(_)) {
            self.interpolator.resync(seen.counts);
            if let Some(finished) = self.interpolator.take_finished() {
                self.send(FromEngine::Done(finished));
            }
        }
        let ended = Ended { outcome, first_tick: running.first_tick, last_tick, counts: seen.counts };
        self.send(FromEngine::Ended(ended));
        self.publish_idle();
    }

    /// Status between motions, with the override that the next one begins with; a fault until the machine's alarm is reset.
    fn publish_idle(&mut self) {
        let Some(seen) = self.seen else { return };
        let state = if seen.has_alarms { ExecutionState::Fault } else { ExecutionState::Idle };
        let mut status = InterpolatorStatus { state, ..self.interpolator.idle_status() };
        if let Some(MotionRequest::SetOverride(value)) =
            self.requests.iter().flatten().find(|request| is_override(request))
        {
            status.feed_override = *value;
        }
        self.last_status = None;
        self.send(FromEngine::Status { tick: seen.tick, status });
    }

    pub(super) fn send(&mut self, message: FromEngine) {
        let mut message = message;
        // The ring holds more than a credit's worth of everything; if it is full the pump is about to make room.
        loop {
            match self.outbox.send(message) {
                Ok(()) => return,
                Err(_) if self.outbox.is_abandoned() => return,
                Err(back) => message = back,
            }
            std::thread::yield_now();
        }
    }
}

/// Ticks of the period of the state in a motion.
#[allow(clippy::cast_possible_truncation, reason = "a cycle is 1 us at least")]
fn status_period_ticks(cycle_s: f64) -> u64 {
    ((STATUS_PERIOD_S / cycle_s).round() as u64).max(1)
}

fn is_override(request: &MotionRequest) -> bool {
    matches!(request, MotionRequest::SetOverride(_))
}

/// Returns whether an alarm with this number stops motion; unknown numbers do.
pub(super) fn stops_motion(number: u16) -> bool {
    use camwright::machine::alarm::AlarmSeverity;
    number != 0 && AlarmKind::from_number(number).is_none_or(|kind| kind.entry().severity > AlarmSeverity::Warning)
}
