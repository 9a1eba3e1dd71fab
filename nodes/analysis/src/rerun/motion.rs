// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The interpolator again: every chunk of setpoints that was sent is computed from the inputs as they were applied.

use super::cuts::JobCuts;
use super::difference::ReplayDifference;
use super::recorded::RecordedInputs;
use camwright::interpolator::{AppliedInput as Applied, Interpolator, MotionRequest, TickInputs};
use camwright::machine::description::Axis;
use camwright_files::convert::applied_input::{input as applied_input, kind_name};
use camwright_files::convert::motion_record::{MotionRecord, StartRecord};
use camwright_files::convert::setpoints::add_stop;
use camwright_files::convert::setpoints::{ChunkBuffer, chunk_from_trajectory, trajectory_from_chunk};
use camwright_msgs::camwright_msgs::msg::AppliedInput;
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};

/// The interpolator, run again.
#[derive(Debug)]
pub(super) struct InterpolatorReplay<'a> {
    recorded: &'a RecordedInputs,
    interpolator: Interpolator,
    /// The next input that was recorded.
    next: usize,
    /// The next tick of the motion in execution; nothing is executed before the first.
    next_tick: Option<u64>,
    /// Indices of the inputs that begin motions, and the number already replayed.
    starts: Vec<usize>,
    motions_begun: usize,
    pub(super) setpoints: u64,
    pub(super) motions: u64,
    /// Cuts of the plans that were executed.
    pub(super) jobs: Vec<JobCuts>,
}

impl<'a> InterpolatorReplay<'a> {
    pub(super) fn new(recorded: &'a RecordedInputs) -> Self {
        let inputs = recorded.interpolator_inputs.iter().enumerate();
        Self {
            recorded,
            interpolator: Interpolator::new(&recorded.machine),
            next: 0,
            next_tick: None,
            starts: inputs.filter(|(_, input)| input.kind == AppliedInput::START).map(|(at, _)| at).collect(),
            motions_begun: 0,
            setpoints: 0,
            motions: 0,
            jobs: Vec::new(),
        }
    }

    /// Computes a chunk that was sent.
    ///
    /// # Errors
    /// Where it is another.
    pub(super) fn chunk(&mut self, message: &JointTrajectory) -> Result<(), Box<ReplayDifference>> {
        let (machine, clock) = (&self.recorded.machine, self.recorded.clock);
        let sent = chunk_from_trajectory(message, machine, clock).map_err(|error| {
            ReplayDifference::texts(self.next_tick.unwrap_or(0), "setpoints", error.to_string(), "a chunk")
        })?;
        self.begin(&sent)?;
        // From the middle: what comes of a motion that began before is taken as it was sent.
        if self.next_tick.is_none() && self.recorded.start.is_some() {
            return Ok(());
        }
        if self.next_tick != Some(sent.first_tick) {
            let expected = self.next_tick.map_or_else(|| "no motion".to_owned(), |tick| format!("tick {tick}"));
            let field = "first tick of a chunk";
            let found = format!("tick {}", sent.first_tick);
            return Err(ReplayDifference::texts(sent.first_tick, field, found, expected).into());
        }
        let mut chunk = ChunkBuffer { first_tick: sent.first_tick, is_final: sent.is_final, ..ChunkBuffer::default() };
        for tick in (sent.first_tick..).take(sent.dense.len()) {
            chunk.dense.push(self.tick(tick)?);
            // Tick by tick, so that what differs is found before what comes of it.
            let place = chunk.dense.len() - 1;
            if chunk.dense[place] != sent.dense[place] {
                self.compare(&chunk, message)?;
            }
        }
        let last_tick = self.next_tick.map_or(0, |tick| tick - 1);
        if !sent.is_final {
            add_stop(&self.interpolator, machine, last_tick, &mut chunk);
        }
        self.setpoints += chunk.dense.len() as u64;
        self.compare(&chunk, message)?;
        if chunk.tail.len() != sent.tail.len() {
            let count = |chunk: &ChunkBuffer| format!("{} points", chunk.tail.len());
            return Err(ReplayDifference::texts(last_tick, "stop after the chunk", count(&sent), count(&chunk)).into());
        }
        Ok(())
    }

    /// Begins the motion that a chunk begins. What was applied since the last chunk of the one before it led to no setpoint that was sent.
    fn begin(&mut self, sent: &ChunkBuffer) -> Result<(), Box<ReplayDifference>> {
        let (inputs, tick) = (&self.recorded.interpolator_inputs, sent.first_tick);
        // One that an alarm ended before anything was sent is passed over.
        let mut to_come = self.starts.iter().enumerate().skip(self.motions_begun);
        let Some((place, &at)) = to_come.find(|(_, at)| inputs[**at].tick == tick) else { return Ok(()) };
        let unreadable = |reason: String| Box::new(ReplayDifference::texts(tick, "START", "a motion", reason));
        let (rest, record) = StartRecord::from_text(&inputs[at].content).map_err(unreadable)?.parts();
        // A motion that an alarm ended may have been sent beyond the first tick of the next, which begins where the axes rest.
        let may_go_on = self.next_tick == Some(tick) || (self.next_tick.is_none() && self.recorded.start.is_some());
        let goes_on = may_go_on && sent.dense.first().is_none_or(|first| first.counts != rest.counts);
        if goes_on {
            return Ok(());
        }
        self.interpolator.rest_as(&rest);
        drop(self.interpolator.take_finished());
        let prepared = self.prepared(&record).map_err(unreadable)?;
        if let Err((error, _)) = self.interpolator.start(prepared) {
            return Err(unreadable(error.to_string()));
        }
        if let MotionRecord::Plan(hash) = &record {
            self.jobs.push(JobCuts::of_plan(hash));
        }
        self.motions += 1;
        self.motions_begun = place + 1;
        self.next = at + 1;
        self.next_tick = Some(tick);
        Ok(())
    }

    fn prepared(&self, record: &MotionRecord) -> Result<Box<camwright::interpolator::Prepared>, String> {
        record.prepared(&self.recorded.machine, |hash| self.recorded.plan(hash)).map(Box::new)
    }

    /// One tick, with the inputs that it applied.
    fn tick(&mut self, tick: u64) -> Result<camwright::machine::setpoint::Setpoint, Box<ReplayDifference>> {
        let mut given: Vec<Applied> = Vec::new();
        let mut requests: Vec<MotionRequest> = Vec::new();
        while let Some(message) = self.recorded.interpolator_inputs.get(self.next).filter(|input| input.tick <= tick) {
            if message.kind == AppliedInput::START {
                // Of the next motion: this one was sent beyond the tick at which an alarm ended it.
                break;
            }
            self.next += 1;
            let name = kind_name(message.kind);
            let unreadable = |reason: String| Box::new(ReplayDifference::texts(tick, name, "an input", reason));
            if message.tick < tick {
                return Err(unreadable(format!("it is of tick {}, which has passed", message.tick)));
            }
            match applied_input(message, &self.recorded.machine).map_err(unreadable)? {
                Some(input) => {
                    requests.extend(self.interpolator.replay(tick, &input));
                    given.push(input);
                }
                None => {
                    let record = MotionRecord::from_text(&message.content).map_err(unreadable)?;
                    let prepared = self.prepared(&record).map_err(unreadable)?;
                    if let Err((error, _)) = self.interpolator.splice(tick, prepared) {
                        return Err(unreadable(error.to_string()));
                    }
                    self.motions += 1;
                }
            }
        }
        let out = self.interpolator.step(&TickInputs { tick, requests: &requests });
        // Those that it was given are those that it applied, in their order.
        if out.applied.iter().ne(given.iter()) {
            let (old, new) = (format!("{given:?}"), format!("{:?}", out.applied.to_vec()));
            return Err(ReplayDifference::texts(tick, "inputs applied", old, new).into());
        }
        drop(self.interpolator.take_finished());
        if let Some(job) = self.jobs.last_mut() {
            job.see(&out);
        }
        self.next_tick = Some(tick + 1);
        Ok(out.setpoint)
    }

    /// Compares what was computed so far with what was sent, as it travelled.
    fn compare(&self, chunk: &ChunkBuffer, sent: &JointTrajectory) -> Result<(), Box<ReplayDifference>> {
        let computed = trajectory_from_chunk(chunk, &self.recorded.machine, self.recorded.clock);
        let dense = chunk.dense.len();
        for (index, (old, new)) in sent.points.iter().zip(&computed.points).enumerate() {
            let tick = chunk.first_tick + index.min(dense.saturating_sub(1)) as u64;
            let what = if index < dense { "setpoint" } else { "stop after the chunk" };
            if let Some(difference) = self.point(tick, what, old, new) {
                return Err(difference.into());
            }
        }
        Ok(())
    }

    fn point(
        &self,
        tick: u64,
        what: &str,
        old: &JointTrajectoryPoint,
        new: &JointTrajectoryPoint,
    ) -> Option<ReplayDifference> {
        if old.time_from_start != new.time_from_start {
            let (old, new) = (format!("{:?}", old.time_from_start), format!("{:?}", new.time_from_start));
            return Some(ReplayDifference::texts(tick, format!("{what}: time"), old, new));
        }
        let kinds = [
            ("position", &old.positions, &new.positions, ["rad", "m"]),
            ("velocity", &old.velocities, &new.velocities, ["rad/s", "m/s"]),
            ("acceleration", &old.accelerations, &new.accelerations, ["rad/s^2", "m/s^2"]),
        ];
        for (kind, old, new, units) in kinds {
            for (axis, (old, new)) in Axis::ALL.iter().zip(old.iter().zip(new)) {
                let unit = units[usize::from(*axis != Axis::C)];
                let field = || format!("{what}: {kind} of {}", axis.joint());
                if old.to_bits() != new.to_bits() {
                    return ReplayDifference::from_numbers(tick, &field(), *old, *new, unit);
                }
            }
        }
        None
    }
}
