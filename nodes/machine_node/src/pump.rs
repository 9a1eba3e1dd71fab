// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! From what the cyclic thread reports to messages: joint states, I/O, alarms, credit, the part.

use super::CycleInlet;
use super::clock_outlet::ClockOutlet;
use super::health::Health;
use super::inputs::InputOutlet;
use super::keyframe_outlet::KeyframeOutlet;
use super::scene_outlet::SceneOutlet;
use super::work_area::WorkAreaOutlet;
use camwright::machine::alarm::{Alarm as CoreAlarm, AlarmSeverity};
use camwright::machine::description::{Axis, MachineDescription};
use camwright::machine::persistent_state::PersistentState;
use camwright::simulation::tick_report::{IoState, MotionState, TickReport};
use camwright_files::convert::gauge::readings;
use camwright_files::convert::machine_description::WHEEL_JOINT;
use camwright_files::convert::machine_report::{cut_of, io_message, joint_values, latch_message, motion_number};
use camwright_files::convert::time::TickClock;
use camwright_files::convert::{m_from_mm, section_centre_values, si_from_core};
use camwright_machine_cycle::active_alarms::ActiveAlarms;
use camwright_machine_cycle::messages::{Inbound, Outbound};
use camwright_machine_cycle::pacing::Slip;
use camwright_machine_cycle::part::{LobeRefused, MAX_PAGES, PartSnapshot, RawLobe};
use camwright_machine_cycle::stream_state::StreamState;
use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::camwright_msgs::msg::{
    GaugeReading, Latch, MachineAlarms, MachineIo, MachineStream, PartLobe, TurnedPage,
};
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_ros::liveness::LimitedWarning;
use camwright_ros::{Node, Publisher, Qos, RosError, Telemetry};
use camwright_threads::drops::DropCounter;
use camwright_threads::ring::{Receiver, Waker};
use camwright_threads::supervised::injected;
use std::time::{Duration, Instant};

/// Ticks between two I/O messages when nothing changes: one second at 1 ms.
const IO_PERIOD_TICKS: u64 = 1000;
/// Ticks between two messages of `/clock`.
const CLOCK_PERIOD_TICKS: u64 = 10;
/// Depth of the joint state writer: what a late reader of a burst may still get.
const JOINT_STATE_DEPTH: u32 = 2000;

/// Maximum time for sending alarms and feedback; then the machine comes to rest.
const VITAL_LIMIT: Duration = Duration::from_secs(2);
/// Maximum wait of samples at pace fast before they are dropped; a sent sample renews it.
const SAMPLE_PATIENCE: Duration = Duration::from_secs(1);

/// The publishers of the machine.
#[derive(Debug)]
pub(super) struct MachineOutlets {
    joint_states: Telemetry<JointState>,
    stream: Publisher<MachineStream>,
    io: Publisher<MachineIo>,
    alarms: Publisher<MachineAlarms>,
    part: Publisher<PartLobe>,
    /// The part of a lathe.
    turned: Option<Publisher<TurnedPage>>,
    gauge: Option<Telemetry<GaugeReading>>,
    work_area: Option<WorkAreaOutlet>,
    clock: Option<ClockOutlet>,
    inputs: InputOutlet,
    keyframes: KeyframeOutlet,
}

impl MachineOutlets {
    pub(super) fn new(
        node: &Node,
        publishes_clock: bool,
        machine: &MachineDescription,
        clock: TickClock,
        drops: &DropCounter,
    ) -> Result<Self, RosError> {
        let samples = Qos::default_topic().keep_last(JOINT_STATE_DEPTH);
        let turned = || node.publisher("machine/turned_part", &Qos::latched(MAX_PAGES));
        let gauge = || node.telemetry("machine/gauge", &samples, drops);
        Ok(Self {
            joint_states: node.telemetry("joint_states", &samples, drops)?,
            stream: node.publisher("machine/stream", &Qos::default_topic().keep_last(1000))?,
            io: node.publisher("machine/io", &Qos::default_topic().keep_last(1000))?,
            alarms: node.publisher("machine/alarms", &Qos::latched(1))?,
            part: node.publisher("machine/part", &Qos::latched(32))?,
            turned: machine.is_lathe().then(turned).transpose()?,
            gauge: machine.gauge.is_some().then(gauge).transpose()?,
            work_area: machine.loading.map(|_| WorkAreaOutlet::new(node)).transpose()?,
            clock: publishes_clock.then(|| ClockOutlet::new(node)).transpose()?,
            inputs: InputOutlet::new(node, machine, clock)?,
            keyframes: KeyframeOutlet::new(node)?,
        })
    }

    /// The machine begins, with what it remembers and with the bus of its real drives.
    pub(super) fn begin(&mut self, lasting: &PersistentState, drives: Option<&'static str>) -> Result<(), RosError> {
        self.inputs.begin(lasting, drives)
    }
}

/// State of the pump in addition to the reports.
#[derive(Debug)]
pub(super) struct Context {
    pub(super) health: Health,
    pub(super) node: Node,
    pub(super) description: MachineDescription,
    pub(super) clock: TickClock,
    pub(super) pace: u8,
    /// The way into the cyclic thread.
    pub(super) inlet: CycleInlet,
    pub(super) is_fast: bool,
    pub(super) drops: DropCounter,
    /// Ticks between two joint states of a machine that rests and runs no job.
    pub(super) rest_period_ticks: u64,
}

/// Builds and publishes messages until the cyclic thread ends.
pub(super) struct MachinePump {
    context: Context,
    outlets: MachineOutlets,
    scene: SceneOutlet,
    latches: Vec<Latch>,
    last_io: Option<IoState>,
    active: ActiveAlarms,
    joint_names: Vec<String>,
    /// Joint states that were published last.
    last_joints: JointState,
    /// Last tick whose joint states were not published, because they were those before.
    skipped_tick: Option<u64>,
    /// Names of the part's lobes, in the machine's order.
    lobes: Vec<String>,
    /// Remaining wait of samples; spent on a subscriber that does not acknowledge.
    patience: Duration,
    complaint: LimitedWarning,
    /// The part has been cut in this job since it was last published.
    has_cut: bool,
}

impl MachinePump {
    pub(super) fn new(context: Context, outlets: MachineOutlets, scene: SceneOutlet) -> Self {
        let mut joint_names = camwright_files::convert::setpoints::joint_names();
        joint_names.push(WHEEL_JOINT.to_owned());
        Self {
            context,
            outlets,
            scene,
            latches: Vec::new(),
            last_io: None,
            active: ActiveAlarms::default(),
            joint_names,
            last_joints: JointState::default(),
            skipped_tick: None,
            lobes: Vec::new(),
            patience: SAMPLE_PATIENCE,
            complaint: LimitedWarning::default(),
            has_cut: false,
        }
    }

    /// Runs until the other end of the ring is gone; `answer` takes what is not for the graph.
    pub(super) fn run(mut self, mut reports: Receiver<Outbound>, waker: &Waker, mut answer: impl FnMut(Outbound)) {
        waker.adopt_current_thread();
        if let Err(error) = self.alarms(0) {
            self.context.node.logger().warn(&format!("alarms cannot be published: {error}"));
        }
        loop {
            injected::point("machine pump");
            let is_last = reports.is_abandoned();
            while let Some(report) = reports.receive() {
                let published = self.outlets.inputs.see(&report);
                let outcome = match report {
                    Outbound::Tick(report, state) => self.tick(&report, &state),
                    Outbound::Outline(outline) => {
                        self.scene.show(&outline, self.lobes.get(outline.lobe), self.context.clock)
                    }
                    Outbound::Slip(slip) => {
                        self.log_slip(slip);
                        Ok(())
                    }
                    Outbound::DrivesLost(reason) => {
                        self.context.node.logger().error(&format!("the drives do not answer: {reason}"));
                        Ok(())
                    }
                    Outbound::Keyframe(room) => {
                        let head = self.outlets.inputs.head();
                        let outcome = self.outlets.keyframes.publish(head, &room, &self.context.node);
                        answer(Outbound::Keyframe(room));
                        outcome
                    }
                    Outbound::Snapshot(snapshot) => {
                        let outcome = self.part(&snapshot);
                        answer(Outbound::Snapshot(snapshot));
                        outcome
                    }
                    other => {
                        match &other {
                            Outbound::LobeDone(outcome, lobe) => self.loaded(outcome, lobe),
                            Outbound::BarDone(Ok(()), _) => self.scene.ask(0),
                            Outbound::JobEnded => (0..self.lobes.len().max(1)).for_each(|lobe| self.scene.ask(lobe)),
                            Outbound::Lasting(state) => {
                                // The machine has what it says that it mounted.
                                let _mounted = self.context.description.mount_wheel(state.mounted_wheel());
                                let outcome = self.scene.mount(state);
                                self.scene.log_failure(outcome);
                            }
                            _ => {}
                        }
                        answer(other);
                        Ok(())
                    }
                };
                if let Err(error) = outcome.and(published) {
                    self.complaint.warn(self.context.node.logger(), &format!("a report cannot be published: {error}"));
                }
            }
            if is_last {
                return;
            }
            let _woken = waker.wait(Duration::from_millis(100));
        }
    }

    /// A lobe takes the place of one with the same name, or comes after all others; the part before it may go even if it is refused.
    fn loaded(&mut self, outcome: &Result<(), LobeRefused>, lobe: &RawLobe) {
        if matches!(outcome, Err(LobeRefused::Moving | LobeRefused::NotHeld(_))) {
            return;
        }
        if lobe.clear {
            self.lobes.clear();
            let outcome = self.scene.clear();
            self.scene.log_failure(outcome);
        }
        if outcome.is_ok() && !self.lobes.contains(&lobe.name) {
            self.lobes.push(lobe.name.clone());
        }
        if let Some(index) = self.lobes.iter().position(|name| *name == lobe.name).filter(|_| outcome.is_ok()) {
            self.scene.set_width(index, &lobe.station, lobe.width_mm);
            self.scene.ask(index);
        }
    }

    fn tick(&mut self, report: &TickReport, state: &StreamState) -> Result<(), RosError> {
        if state.only_stream {
            return self.stream(report, state);
        }
        self.context.health.see(report, &self.context.description);
        self.latches.extend(report.latches.iter().map(|latch| latch_message(latch, &self.context.description)));
        report.raised.iter().for_each(|alarm| self.log(alarm));
        self.see_unfinished_job(report, state);
        let sent = self.vital(report, state);
        let stamp = self.context.clock.stamp(report.tick);
        sent.and(self.samples(report, state, &stamp))
    }

    /// Has the part published as it is when the motion of a job ends before its end: the setpoints are spent, or the axes rest after an
    /// alarm. The part of a lathe has a single surface, which is not finished then.
    fn see_unfinished_job(&mut self, report: &TickReport, state: &StreamState) {
        self.has_cut = state.job_tick != 0 && (self.has_cut || report.removal.area_mm2 > 0.0);
        let is_over = !state.has_holder || report.motion == MotionState::Fault;
        if is_over && std::mem::take(&mut self.has_cut) && self.outlets.turned.is_none() {
            self.context.inlet.send(Inbound::Snapshot(Box::default()));
        }
    }

    /// Publishes the messages that other nodes wait for: alarms, credit with receipts and edges, inputs, I/O. A failed one does not delay
    /// the others.
    fn vital(&mut self, report: &TickReport, state: &StreamState) -> Result<(), RosError> {
        let mut sent = Ok(());
        if self.active.update(report, state) {
            sent = sent.and(self.alarms(report.tick));
        }
        if self.is_stream_due(report, state) || state.news || !self.latches.is_empty() {
            sent = sent.and(self.stream(report, state));
        }
        sent = sent.and(self.outlets.inputs.tick(report, state));
        if self.last_io != Some(report.io) || report.tick.is_multiple_of(IO_PERIOD_TICKS) {
            let (stamp, tick) = (self.context.clock.stamp(report.tick), report.tick);
            let io = io_message(&report.io, &self.context.description);
            let published = self.outlets.io.publish(&MachineIo { stamp, tick, ..io });
            // A message that was not sent is repeated with the next tick.
            self.last_io = published.is_ok().then_some(report.io);
            sent = sent.and(published);
        }
        if let (Some(outlet), Some(state)) = (&mut self.outlets.work_area, report.work_area) {
            sent = sent.and(outlet.publish(state, report.tick, self.context.clock));
        }
        sent
    }

    /// Returns whether the stream is due by its period, which is longer while the machine stands still and receives no setpoints.
    fn is_stream_due(&self, report: &TickReport, state: &StreamState) -> bool {
        let is_idle = self.context.pace == MachineStream::PACE_REALTIME
            && report.motion == MotionState::Standstill
            && !state.has_holder;
        let machine = &self.context.description;
        let period = if is_idle { machine.rest_stream_period_ticks() } else { machine.stream_period_ticks() };
        report.tick.is_multiple_of(period)
    }

    /// Samples of every tick, which are dropped and counted where a subscriber leaves no room.
    fn samples(&mut self, report: &TickReport, state: &StreamState, stamp: &Time) -> Result<(), RosError> {
        let rest_ticks = self.rest_ticks(report, state);
        let mut sent = self.joint_states(report, rest_ticks);
        sent = sent.and(self.gauge(report));
        sent = sent.and(self.scene.tick(report, stamp, rest_ticks));
        if let Some(clock) = self.outlets.clock.as_mut().filter(|_| report.tick.is_multiple_of(CLOCK_PERIOD_TICKS)) {
            sent = sent.and(clock.publish(stamp.clone()));
        }
        sent
    }

    fn alarms(&self, tick: u64) -> Result<(), RosError> {
        let clock = self.context.clock;
        let alarms = self.active.messages(clock);
        self.outlets.alarms.publish_within(&MachineAlarms { stamp: clock.stamp(tick), tick, alarms }, VITAL_LIMIT)
    }

    fn log(&self, alarm: &CoreAlarm) {
        let entry = alarm.kind.entry();
        let text = format!("alarm {}: {alarm} ({})", entry.number, entry.remedy);
        match entry.severity {
            AlarmSeverity::Warning => self.context.node.logger().warn(&text),
            AlarmSeverity::Stop | AlarmSeverity::PowerOff => self.context.node.logger().error(&text),
        }
    }

    fn log_slip(&self, slip: Slip) {
        let seconds = |ns: i64| ns as f64 * 1e-9;
        let logger = self.context.node.logger();
        match slip {
            Slip::Stalled(ns) => logger.warn(&format!(
                "the machine's time is {:.3} s behind the system clock: its cycle was delayed, or the clock was set; stamps are too old by this time until the axes rest (see `cyclic_priority`)",
                seconds(ns)
            )),
            Slip::Inactive(ns) => logger.info(&format!("the machine was inactive for {:.3} s", seconds(ns))),
            Slip::ClockSetBack(ns) => logger.warn(&format!(
                "the system clock was set back by {:.3} s: ticks are 10 % slower until it has caught up",
                seconds(ns)
            )),
            Slip::MadeUp(ns) => {
                logger.info(&format!("the machine's time follows the system clock again; {:.3} s were made up for", seconds(ns)));
            }
        }
    }

    /// Returns the period of the samples while no job runs and no axis moves.
    fn rest_ticks(&self, report: &TickReport, state: &StreamState) -> Option<u64> {
        let is_at_rest = state.job_tick == 0 && joint_values(&self.context.description, report) == self.last_joints;
        is_at_rest.then_some(self.context.rest_period_ticks)
    }

    /// Every tick of a job and of what moves is published; what rests is repeated less often. The last tick of a rest is published with the
    /// first one that differs, so that a change never lies between two ticks that are far apart.
    fn joint_states(&mut self, report: &TickReport, rest_ticks: Option<u64>) -> Result<(), RosError> {
        if rest_ticks.is_some_and(|period| !report.tick.is_multiple_of(period)) {
            self.skipped_tick = Some(report.tick);
            return Ok(());
        }
        let values = joint_values(&self.context.description, report);
        if let Some(tick) = self.skipped_tick.take().filter(|_| values != self.last_joints) {
            self.publish_joints(tick)?;
        }
        self.last_joints = values;
        self.publish_joints(report.tick)
    }

    fn publish_joints(&mut self, tick: u64) -> Result<(), RosError> {
        let mut message = JointState { name: self.joint_names.clone(), ..self.last_joints.clone() };
        message.header.stamp = self.context.clock.stamp(tick);
        self.scene.base_frame().clone_into(&mut message.header.frame_id);
        let begin = Instant::now();
        let patience = if self.context.is_fast { self.patience } else { Duration::ZERO };
        let is_sent = self.outlets.joint_states.offer(&message, patience)?;
        // At pace fast ticks wait for a recorder that is slow, but not for a subscriber that is gone.
        self.patience = if is_sent { SAMPLE_PATIENCE } else { self.patience.saturating_sub(begin.elapsed()) };
        if !is_sent {
            self.context.drops.add();
        }
        Ok(())
    }

    fn gauge(&mut self, report: &TickReport) -> Result<(), RosError> {
        let Some(outlet) = &self.outlets.gauge else { return Ok(()) };
        let patience = if self.context.is_fast { self.patience } else { Duration::ZERO };
        for reading in readings(&self.context.description, report) {
            let lobe = report.lobe.and_then(|lobe| self.lobes.get(lobe)).cloned().unwrap_or_default();
            let reading = GaugeReading { stamp: self.context.clock.stamp(report.tick), lobe, ..reading };
            outlet.publish_within(&reading, patience)?;
        }
        Ok(())
    }

    fn stream(&mut self, report: &TickReport, state: &StreamState) -> Result<(), RosError> {
        let clock = self.context.clock;
        let message = MachineStream {
            stamp: clock.stamp(report.tick),
            epoch: clock.stamp(0),
            tick: report.tick,
            credit_tick: report.tick
                + if state.no_credit { 0 } else { u64::from(self.context.description.feedback_delay_ticks) },
            pace: self.context.pace,
            motion: motion_number(report.motion),
            commands_received: state.commands_received,
            holder: if state.has_holder { self.context.node.who(&state.holder) } else { String::new() },
            alarms: self.active.numbers(),
            setpoint_counts: report.axes.iter().map(|axis| axis.setpoint_counts).collect(),
            actual_counts: report.axes.iter().map(|axis| axis.counts).collect(),
            actual_velocities: Axis::ALL
                .iter()
                .map(|axis| si_from_core(*axis, report.axes[axis.index()].velocity))
                .collect(),
            latches: self.latches.clone(),
        };
        let sent = self.outlets.stream.publish_within(&message, VITAL_LIMIT);
        match &sent {
            // Edges that were not sent go with the next message.
            Ok(()) => self.latches.clear(),
            Err(RosError::Congested { .. }) => {
                self.context.inlet.send(Inbound::Blocked(VITAL_LIMIT.as_secs_f64()));
            }
            Err(_) => {}
        }
        sent
    }

    fn part(&self, snapshot: &PartSnapshot) -> Result<(), RosError> {
        let header = self.scene.part_header(self.context.clock.stamp(snapshot.tick));
        if let (Some(outlet), Some(turned)) = (&self.outlets.turned, &snapshot.turned) {
            let pages = turned.pages(snapshot.tick, snapshot.finished, header.clone());
            pages.into_iter().try_for_each(|page| outlet.publish(&page))?;
        }
        for lobe in &snapshot.lobes {
            let common_mm = lobe.width_mm.min(self.context.description.wheel.width_mm);
            self.outlets.part.publish(&PartLobe {
                header: header.clone(),
                tick: snapshot.tick,
                name: lobe.name.clone(),
                station: lobe.station.clone(),
                width: m_from_mm(lobe.width_mm),
                finished: snapshot.finished,
                key_way: snapshot.key_way_rad,
                radius: lobe.radii_mm.iter().map(|radius| m_from_mm(*radius)).collect(),
                centre: section_centre_values(lobe.centre, lobe.offset_mm),
                ..lobe.cut.as_ref().map(|cut| cut_of(cut, common_mm)).unwrap_or_default()
            })?;
        }
        Ok(())
    }
}
