// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! From what the engine reports to messages, and to the goal that is being served.

use super::engine_messages::{Ended, FromEngine, MotionForecast, SequencedCommand, ToEngine, Tracking};
use super::goals::ActiveGoal;
use super::joint_trajectory::arrival::ArrivalStep;
use super::joint_trajectory::{settings, tracking};
use super::{Shared, lock};
use camwright::interpolator::{
    ExecutionState, InterpolatorAlarm, InterpolatorEvent, InterpolatorStatus, MotionOutcome, OrderKind, RestState,
    StartError,
};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::MachineDescription;
use camwright::math::units::um_from_mm;
use camwright_files::convert::applied_input;
use camwright_files::convert::m_from_mm;
use camwright_files::convert::machine_report::input_name;
use camwright_files::convert::motion_record::{MotionRecord, StartRecord};
use camwright_files::convert::setpoints::{ChunkBuffer, trajectory_from_chunk};
use camwright_files::convert::time::TickClock;
use camwright_msgs::camwright_msgs::msg::{Alarm, AppliedInput, InterpolatorState, MachineAlarms, MachineCommand};
use camwright_msgs::control_msgs::msg::JointTrajectoryControllerState;
use camwright_msgs::control_msgs::srv::QueryTrajectoryStateResponse;
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use camwright_ros::liveness::LimitedWarning;
use camwright_ros::{Node, Publisher, Qos, RosError, Telemetry};
use camwright_threads::drops::DropCounter;
use camwright_threads::ring::{Receiver, Waker};
use camwright_threads::silence::HEARTBEAT;
use camwright_threads::supervised::injected;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

/// Inputs that a late reader still gets.
const INPUTS_DEPTH: u32 = 2000;

/// Time for which sending setpoints, orders and alarms is retried; the machine misses them meanwhile and stops on the path.
const VITAL_LIMIT: Duration = Duration::from_secs(2);

/// The publishers of the interpolator.
#[derive(Debug)]
pub(super) struct InterpolatorOutlets {
    setpoints: Publisher<JointTrajectory>,
    commands: Publisher<MachineCommand>,
    state: Publisher<InterpolatorState>,
    inputs: Publisher<AppliedInput>,
    alarms: Publisher<MachineAlarms>,
    controller_state: Telemetry<JointTrajectoryControllerState>,
}

impl InterpolatorOutlets {
    pub(super) fn new(node: &Node, drops: &DropCounter) -> Result<Self, RosError> {
        Ok(Self {
            setpoints: node.publisher("machine/setpoints", &Qos::default_topic().keep_last(1000))?,
            commands: node.publisher("machine/commands", &Qos::default_topic().keep_last(1000))?,
            state: node.publisher("~/state", &Qos::latched(1))?,
            // Also for a recorder that comes when something has been applied already.
            inputs: node.publisher("~/inputs", &Qos::latched(INPUTS_DEPTH))?,
            alarms: node.publisher("~/alarms", &Qos::latched(1))?,
            controller_state: node.telemetry("~/controller_state", &Qos::default_topic(), drops)?,
        })
    }
}

pub(super) struct EnginePump {
    node: Node,
    machine: MachineDescription,
    /// The node's callbacks know what waits; the node ends before them.
    shared: Weak<Shared>,
    clock: Arc<Mutex<Option<TickClock>>>,
    outlets: InterpolatorOutlets,
    served: Arc<Mutex<ActiveGoal>>,
    order: u32,
    order_tick: u64,
    inputs_sent: u64,
    /// Alarm that ended the last motion, once the list of alarms has been published.
    alarms: Option<Vec<Alarm>>,
    feed_override: f64,
    last_state: Option<InterpolatorState>,
    state_sent_at: Instant,
    complaint: LimitedWarning,
}

impl EnginePump {
    pub(super) fn new(shared: &Arc<Shared>, machine: &MachineDescription) -> Result<Self, RosError> {
        Ok(Self {
            node: shared.node.clone(),
            machine: machine.clone(),
            shared: Arc::downgrade(shared),
            clock: Arc::clone(&shared.clock),
            outlets: InterpolatorOutlets::new(&shared.node, &shared.drops)?,
            served: Arc::clone(&shared.served),
            order: 0,
            order_tick: 0,
            inputs_sent: 0,
            alarms: None,
            feed_override: 1.0,
            last_state: None,
            state_sent_at: Instant::now(),
            complaint: LimitedWarning::default(),
        })
    }

    /// Runs until the other end of the ring is gone; `back` returns empty chunks to the engine.
    pub(super) fn run(mut self, mut reports: Receiver<FromEngine>, waker: &Waker, back: impl Fn(ToEngine)) {
        waker.adopt_current_thread();
        loop {
            injected::point("interpolator pump");
            let is_last = reports.is_abandoned();
            while let Some(report) = reports.receive() {
                let clock = *self.clock.lock().unwrap_or_else(PoisonError::into_inner);
                let Some(clock) = clock else { continue };
                if let Err(error) = self.publish(report, clock, &back) {
                    self.complaint.warn(self.node.logger(), &format!("a report cannot be published: {error}"));
                }
            }
            if is_last {
                return;
            }
            if self.state_sent_at.elapsed() >= 2 * HEARTBEAT
                && let Err(error) = self.repeat(None)
            {
                self.complaint.warn(self.node.logger(), &error.to_string());
            }
            let _woken = waker.wait(Duration::from_millis(100));
        }
    }

    /// Turns one report of the engine into messages and answers.
    fn publish(&mut self, report: FromEngine, clock: TickClock, back: &impl Fn(ToEngine)) -> Result<(), RosError> {
        match report {
            FromEngine::Chunk(chunk) => self.publish_chunk(chunk, clock, back),
            FromEngine::Command { sequence, command } => {
                let message = message(sequence, command, clock, &self.machine);
                self.outlets.commands.publish_within(&message, VITAL_LIMIT)
            }
            FromEngine::Started { tick, rest, record } => self.report_start(clock, tick, &rest, *record),
            FromEngine::NotStarted(error, _motion) => {
                self.reject_motion(&error);
                Ok(())
            }
            FromEngine::Applied { tick, input } => {
                self.input(clock, tick, applied_input::message(&input, &self.machine))
            }
            FromEngine::Status { tick, status } => {
                let published = if self.alarms.is_none() { self.alarms(clock, tick, Vec::new()) } else { Ok(()) };
                published.and(self.status(clock, tick, &status))
            }
            FromEngine::Event { tick, event } => self.report_event(clock, tick, event),
            FromEngine::Ended(ended) => {
                let published = self.alarm_of_lost_partner(clock, ended.last_tick);
                self.end(ended);
                self.with_shared(Shared::begin_arrival);
                published
            }
            FromEngine::Foreseen(foresight) => {
                self.foreseen(&foresight, clock, back);
                Ok(())
            }
            FromEngine::Spliced { tick, record } => {
                self.with_shared(|shared| shared.arrived(tick));
                let content = record.to_text();
                self.input(clock, tick, AppliedInput { kind: AppliedInput::SPLICE, content, ..Default::default() })
            }
            FromEngine::NotSpliced(error, _motion) => {
                self.with_shared(|shared| shared.refuse_arrival(&error.to_string()));
                Ok(())
            }
            FromEngine::Tracking(tracking) => self.tracking(&tracking, clock),
            FromEngine::Queried(state) => {
                let answer = tracking::answer(state.as_ref(), &self.machine);
                self.answer_query(&answer);
                Ok(())
            }
            // The cyclic thread does not free memory.
            FromEngine::Used(news) => {
                drop(news);
                Ok(())
            }
            FromEngine::Done(motion) => {
                drop(motion);
                Ok(())
            }
        }
    }

    /// Publishes setpoints and returns the emptied chunk to the engine.
    fn publish_chunk(
        &self,
        mut chunk: Box<ChunkBuffer>,
        clock: TickClock,
        back: &impl Fn(ToEngine),
    ) -> Result<(), RosError> {
        let message = trajectory_from_chunk(&chunk, &self.machine, clock);
        let outcome = self.outlets.setpoints.publish_within(&message, VITAL_LIMIT);
        chunk.clear();
        back(ToEngine::Chunk(chunk));
        outcome
    }

    /// Logs the start of a motion, clears the alarms of the last one, and records where the axes start.
    fn report_start(
        &mut self,
        clock: TickClock,
        tick: u64,
        rest: &RestState,
        record: MotionRecord,
    ) -> Result<(), RosError> {
        let (name, _) = self.served().names();
        self.node.logger().info(&format!("{name} begins at tick {tick}"));
        let published = self.alarms(clock, tick, Vec::new());
        let text = record.plan_hash().to_owned();
        let content = StartRecord::new(rest, record).to_text();
        let start = AppliedInput { kind: AppliedInput::START, text, content, ..Default::default() };
        published.and(self.input(clock, tick, start))
    }

    /// Ends the goal of a motion that cannot start.
    fn reject_motion(&self, error: &StartError) {
        if self.served().is_of_topic() {
            self.with_shared(|shared| shared.warn_of_refusal(&error.to_string()));
        }
        match error {
            StartError::Cancelled => self.served().withdraw(&error.to_string()),
            _ => self.served().refuse(&error.to_string()),
        }
    }

    fn report_event(&mut self, clock: TickClock, tick: u64, event: InterpolatorEvent) -> Result<(), RosError> {
        match event {
            InterpolatorEvent::Alarm(alarm) => return self.alarm(clock, tick, alarm),
            InterpolatorEvent::LeftOut { lobe, turns } => {
                self.node
                    .logger()
                    .info(&format!("the force is steady at tick {tick}: {turns} spark-out turns are skipped"));
                self.served().leave_out(lobe, turns);
            }
            InterpolatorEvent::InfeedEnded(end) => {
                let (turn, infed_um, left_out) = (end.turn, um_from_mm(end.infed_mm), end.left_out);
                self.node.logger().info(&format!(
                    "the gauge has read the size: the infeed ends at tick {tick} in turn {turn:.2} after {infed_um:.1} um, {left_out} turns \
                     with infeed are skipped"
                ));
                self.served().leave_out(end.lobe, left_out);
            }
            InterpolatorEvent::Probed(probed) => self.served().probed = Some(probed),
            InterpolatorEvent::Segment(_) | InterpolatorEvent::Finished(_) => {}
        }
        Ok(())
    }

    /// Answers the oldest `query_state` request.
    fn answer_query(&self, answer: &QueryTrajectoryStateResponse) {
        self.with_shared(|shared| {
            if let Some(responder) = lock(&shared.queries).pop_front() {
                responder.send(answer);
            }
        });
    }

    fn with_shared(&self, act: impl FnOnce(&Shared)) {
        if let Some(shared) = self.shared.upgrade() {
            act(&shared);
        }
    }

    /// The engine has looked ahead for the trajectory that waits.
    fn foreseen(&self, foresight: &MotionForecast, clock: TickClock, back: &impl Fn(ToEngine)) {
        self.with_shared(|shared| {
            let step = lock(&shared.arrival).as_ref().map(|arrival| arrival.next(foresight, clock, &self.machine));
            match step {
                Some(ArrivalStep::Send(message)) => back(message),
                Some(ArrivalStep::Wait) => {
                    // It may have ended before this was received.
                    if !lock(&shared.served).is_busy() {
                        shared.begin_arrival();
                    }
                }
                Some(ArrivalStep::Refuse(reason)) => {
                    back(ToEngine::StayOn);
                    shared.refuse_arrival(&reason);
                }
                None => back(ToEngine::StayOn),
            }
        });
    }

    /// Publishes the path following of the axes, at the rate of the parameters.
    fn tracking(&self, followed: &Tracking, clock: TickClock) -> Result<(), RosError> {
        let (tick, parameters) = (followed.measured.tick, self.node.parameters());
        let (feedback_ticks, state_ticks) = settings::periods_ticks(parameters, self.machine.cycle_time_s());
        let period = self.machine.stream_period_ticks();
        // Of the ticks that are measured those that are the first in a period.
        let is_due = |ticks: u64| tick % ticks.max(period) < period;
        if let Some(goal) = self.served().trajectory().filter(|_| is_due(feedback_ticks)) {
            let joints = &goal.goal().trajectory.joint_names;
            goal.feedback(&tracking::feedback(followed, joints, &self.machine, clock));
        }
        if state_ticks.is_some_and(is_due) && self.outlets.controller_state.matched() > 0 {
            let state = tracking::state(followed, self.feed_override, &self.machine, clock);
            return self.outlets.controller_state.publish(&state);
        }
        Ok(())
    }

    fn served(&self) -> std::sync::MutexGuard<'_, ActiveGoal> {
        // Held for a message or a look at a name, never across a wait.
        self.served.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn input(&mut self, clock: TickClock, tick: u64, input: AppliedInput) -> Result<(), RosError> {
        self.order = if tick == self.order_tick { self.order + 1 } else { 0 };
        self.order_tick = tick;
        let (stamp, sequence) = (clock.stamp(tick), self.inputs_sent);
        self.inputs_sent += 1;
        let mut message = AppliedInput { stamp, tick, order: self.order, sequence, ..input };
        message.check = applied_input::check(&message).unwrap_or_default();
        self.outlets.inputs.publish(&message)
    }

    fn status(&mut self, clock: TickClock, tick: u64, status: &InterpolatorStatus) -> Result<(), RosError> {
        self.feed_override = status.feed_override;
        self.with_shared(|shared| *lock(&shared.homed) = status.homed);
        let served = self.served();
        served.feedback(tick, status);
        let (holder, plan_hash) = served.names();
        drop(served);
        let is_idle = status.state == ExecutionState::Idle;
        let message = InterpolatorState {
            stamp: clock.stamp(tick),
            tick,
            state: status.state as u8,
            holder: if is_idle { String::new() } else { holder },
            plan_hash: if is_idle { String::new() } else { plan_hash },
            segment: u32::try_from(status.segment).unwrap_or(u32::MAX),
            phase: status.phase.map_or(0, |phase| phase as u8),
            lobe: status.lobe.and_then(|lobe| i32::try_from(lobe).ok()).unwrap_or(InterpolatorState::NO_LOBE),
            turn: status.turn,
            turns: status.turns,
            stock: m_from_mm(status.stock_mm),
            percent: status.percent,
            time_left: status.time_left_s,
            feed_override: status.feed_override,
            is_homed: status.is_homed(),
        };
        self.repeat(Some(message))
    }

    /// Publishes a state, or repeats the last one, so that the planner sees that this node is present. At rest it is that of the machine's
    /// last tick.
    fn repeat(&mut self, state: Option<InterpolatorState>) -> Result<(), RosError> {
        let is_new = state.is_some();
        self.last_state = state.or_else(|| self.last_state.take());
        let clock = *self.clock.lock().unwrap_or_else(PoisonError::into_inner);
        let machine_tick = self.shared.upgrade().map_or(0, |shared| shared.machine_tick());
        let rests = |state: &&mut InterpolatorState| {
            matches!(state.state, InterpolatorState::IDLE | InterpolatorState::FAULT) && state.tick < machine_tick
        };
        if let (false, Some(clock), Some(state)) = (is_new, clock, self.last_state.as_mut().filter(rests)) {
            (state.tick, state.stamp) = (machine_tick, clock.stamp(machine_tick));
        }
        self.state_sent_at = Instant::now();
        match &self.last_state {
            Some(state) => self.outlets.state.publish(state),
            None => Ok(()),
        }
    }

    fn alarm(&mut self, clock: TickClock, tick: u64, alarm: InterpolatorAlarm) -> Result<(), RosError> {
        let (number, text, remedy) = (alarm.number(), alarm.to_string(), alarm.remedy().to_owned());
        self.node.logger().error(&format!("alarm {number} at tick {tick}: {text} ({remedy})"));
        self.served().alarm = Some((number, text.clone()));
        let mut alarms = self.alarms.take().unwrap_or_default();
        let (stamp, source, severity) = (clock.stamp(tick), self.node.name().to_owned(), Alarm::STOP);
        alarms.push(Alarm { stamp, tick, number, severity, source, text, remedy, active: true });
        self.alarms(clock, tick, alarms)
    }

    /// Publishes the active alarms if they have changed.
    fn alarms(&mut self, clock: TickClock, tick: u64, alarms: Vec<Alarm>) -> Result<(), RosError> {
        if self.alarms.as_ref() == Some(&alarms) {
            return Ok(());
        }
        let alarm_list = self.alarms.insert(alarms).clone();
        let message = MachineAlarms { stamp: clock.stamp(tick), tick, alarms: alarm_list };
        self.outlets.alarms.publish_within(&message, VITAL_LIMIT)
    }

    /// Publishes the alarm of a motion that ended because a partner was lost.
    fn alarm_of_lost_partner(&mut self, clock: TickClock, tick: u64) -> Result<(), RosError> {
        let alarm = self.served().alarm.clone();
        let Some((number, text)) = alarm else { return Ok(()) };
        let kind = AlarmKind::from_number(number);
        let Some(kind @ (AlarmKind::MachineLost | AlarmKind::PlannerLost)) = kind else { return Ok(()) };
        let (stamp, source, severity) = (clock.stamp(tick), self.node.name().to_owned(), Alarm::STOP);
        let remedy = kind.entry().remedy.to_owned();
        let alarm = Alarm { stamp, tick, number, severity, source, text, remedy, active: true };
        self.alarms(clock, tick, vec![alarm])
    }

    fn end(&self, ended: Ended) {
        let mut served = self.served();
        let (name, _) = served.names();
        let text = match ended.outcome {
            MotionOutcome::Completed => format!("{name} is complete at tick {}", ended.last_tick),
            MotionOutcome::Cancelled => {
                format!("{name} was cancelled: the axes are at rest and the wheel is retracted")
            }
            MotionOutcome::Failed(number) => format!("{name} was stopped by alarm {number}"),
            MotionOutcome::OutOfTolerance(broken) => format!("{name} was stopped: {broken}"),
        };
        served.end(&ended, &text, &self.machine);
        drop(served);
        match ended.outcome {
            MotionOutcome::Failed(_) | MotionOutcome::OutOfTolerance(_) => self.node.logger().error(&text),
            MotionOutcome::Completed | MotionOutcome::Cancelled => self.node.logger().info(&text),
        }
    }
}

fn message(sequence: u32, command: SequencedCommand, clock: TickClock, machine: &MachineDescription) -> MachineCommand {
    let base = |tick: u64, kind: u8| MachineCommand {
        stamp: clock.stamp(tick),
        sequence,
        tick,
        kind,
        ..MachineCommand::default()
    };
    match command {
        SequencedCommand::Attend { tick } => base(tick, MachineCommand::ATTEND),
        SequencedCommand::JobBegin { tick } => base(tick, MachineCommand::JOB_BEGIN),
        SequencedCommand::JobEnd { tick } => base(tick, MachineCommand::JOB_END),
        SequencedCommand::Alarm { tick, number } => {
            MachineCommand { counts: i64::from(number), ..base(tick, MachineCommand::ALARM) }
        }
        SequencedCommand::Interpolator(order) => match order.kind {
            OrderKind::SetHome { axis, counts } => {
                MachineCommand { target: axis.joint().to_owned(), counts, ..base(order.tick, MachineCommand::SET_HOME) }
            }
            OrderKind::LoseHome { axis } => {
                MachineCommand { target: axis.joint().to_owned(), ..base(order.tick, MachineCommand::LOSE_HOME) }
            }
            OrderKind::Ask { input } => MachineCommand {
                target: input_name(input, machine).to_owned(),
                ..base(order.tick, MachineCommand::ASK)
            },
            OrderKind::WheelStart => base(order.tick, MachineCommand::WHEEL_START),
            OrderKind::WheelStop => base(order.tick, MachineCommand::WHEEL_STOP),
            OrderKind::ExpectWheel { radius_nm } => {
                MachineCommand { counts: radius_nm, ..base(order.tick, MachineCommand::EXPECT_WHEEL) }
            }
            OrderKind::ChangeWheel { wheel } => {
                MachineCommand { counts: i64::from(wheel), ..base(order.tick, MachineCommand::CHANGE_WHEEL) }
            }
            OrderKind::Dress { radius_nm } => {
                MachineCommand { counts: radius_nm, ..base(order.tick, MachineCommand::DRESS) }
            }
            OrderKind::Push { max_n } => MachineCommand { counts: max_n, ..base(order.tick, MachineCommand::PUSH) },
            OrderKind::WatchForce { max_n } => {
                MachineCommand { counts: max_n, ..base(order.tick, MachineCommand::WATCH_FORCE) }
            }
            OrderKind::WatchSize { diameter_nm } => {
                MachineCommand { counts: diameter_nm, ..base(order.tick, MachineCommand::WATCH_SIZE) }
            }
        },
    }
}
