// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A travel on its way: chunks up to the credit, each with its stop.

use super::super::observed::Observed;
use super::super::report::ClauseReport;
use super::test_motion::{EarlyEnd, PATIENCE, TestMotion};
use super::travel::{TestTravel, TravelPoint};
use camwright_msgs::camwright_msgs::msg::{MachineCommand, MachineStream};
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;

/// Dense points of a chunk at most.
const DENSE: u64 = 64;
/// Resting ticks that are sent ahead of a travel, and of which the later half is replaced by it.
const AHEAD: u64 = 8;
/// Attempts to begin a travel: on a busy computer the first chunk can arrive after its tick, which every machine must refuse.
const BEGINNINGS: u32 = 4;

/// A travel in execution.
pub(super) struct Drive<'a> {
    hand: &'a TestMotion<'a>,
    pub(super) travel: TestTravel,
    /// The first tick that was sent.
    pub(super) first_tick: u64,
    /// The tick before that of its first point.
    pub(super) start: u64,
    /// Points that were sent so far.
    pub(super) sent: u64,
    /// The tick of the command that came with it.
    pub(super) command_tick: u64,
}

impl<'a> Drive<'a> {
    /// Takes command: rest for some ticks, then the travel in the place of the later ones. Begins once more if the first chunk came too
    /// late.
    ///
    /// An input that is asked for is asked for by the first command of the motion, in its first tick.
    pub(super) fn begin(hand: &'a TestMotion<'a>, travel: TestTravel, ask: Option<&str>) -> Result<Self, EarlyEnd> {
        for _ in 1..BEGINNINGS {
            let seen = hand.ears.read(|observed| observed.streams.len());
            let drive = Self::begin_once(hand, travel.clone(), ask)?;
            drive.wait_for_command();
            if !hand.ears.read(|observed| drive.came_late(observed.streams.get(seen..).unwrap_or_default())) {
                return Ok(drive);
            }
            hand.clear()?;
        }
        Self::begin_once(hand, travel, ask)
    }

    /// Waits until the machine has taken the first chunk or refused it. At pace fast its idle ticks go on until the chunk is there.
    fn wait_for_command(&self) {
        let is_realtime = self.hand.news().pace == MachineStream::PACE_REALTIME;
        let latest = self.first_tick + if is_realtime { 0 } else { self.hand.facts.delay };
        self.hand.wait(|news| !news.holder.is_empty() || news.tick >= latest || stops(news));
    }

    /// The machine has executed the first tick before it refused the first command or chunk (alarms 81 and 84).
    fn came_late(&self, during: &[MachineStream]) -> bool {
        let is_refused = |message: &&MachineStream| [81, 84].iter().any(|number| message.alarms.contains(number));
        during.iter().find(is_refused).is_some_and(|message| message.tick >= self.first_tick)
    }

    fn begin_once(hand: &'a TestMotion<'a>, travel: TestTravel, ask: Option<&str>) -> Result<Self, EarlyEnd> {
        hand.go_on()?;
        let news = hand.fresh_news();
        // A tick between the regular reports: its changes must be published at once.
        let mut first_tick = news.tick + (hand.facts.delay * 6 / 10).max(1);
        while first_tick.is_multiple_of(hand.facts.period) && hand.facts.period > 1 {
            first_tick += 1;
        }
        if let Some(input) = ask {
            hand.order(1, first_tick, MachineCommand::ASK, input)?;
            if !hand.wait(|news| news.commands_received == 1 || stops(news)) {
                return Err(EarlyEnd::Stuck(20, "the first command of a motion is not acknowledged".into()));
            }
        }
        // At pace fast what is sent ahead is executed before anything could take its place.
        let ahead = if news.pace == MachineStream::PACE_REALTIME { AHEAD } else { 0 };
        let start = (first_tick + ahead / 2).saturating_sub(1);
        let mut drive = Self { hand, travel, first_tick, start, sent: 0, command_tick: first_tick };
        if ahead > 0 {
            let rest = drive.travel.point(0);
            // Of an end that is a tick apart nobody could say whether it is dense.
            let ahead: Vec<_> = (0..ahead).chain([ahead + 1]).map(|tick| (tick, rest.clone())).collect();
            hand.send(&drive.travel.chunk(hand.facts, hand.epoch_ns, first_tick, &ahead))?;
        }
        drive.on(1)?;
        Ok(drive)
    }

    /// Tick of a point.
    pub(super) fn tick(&self, k: u64) -> u64 {
        self.start + k
    }

    /// The chunk of some points, with the stop that follows, or without if they are the last.
    pub(super) fn chunk(&self, from: u64, to: u64) -> JointTrajectory {
        let last = self.travel.ticks;
        let mut points: Vec<(u64, TravelPoint)> = (from..=to).map(|k| (k - from, self.travel.point(k))).collect();
        let middle = u64::midpoint(to, last);
        let tail = [middle, last].into_iter().filter(|k| *k > to + 1 && to < last);
        let mut tail: Vec<u64> = tail.collect();
        tail.dedup();
        points.extend(tail.into_iter().map(|k| (k - from, self.travel.point(k))));
        self.travel.chunk(self.hand.facts, self.hand.epoch_ns, self.tick(from), &points)
    }

    /// Sends at least up to a point. An alarm ends it; an interruption goes on to the end of the travel first, which is a stop too.
    pub(super) fn on(&mut self, to: u64) -> Result<(), EarlyEnd> {
        let to = to.min(self.travel.ticks);
        loop {
            let is_interrupted = self.hand.shutdown.is_requested();
            let to = if is_interrupted { self.travel.ticks } else { to };
            if self.sent >= to {
                return if is_interrupted { Err(EarlyEnd::Interrupted) } else { Ok(()) };
            }
            let news = self.hand.news();
            if stops(&news) {
                return Ok(());
            }
            let credit = news.credit_tick.saturating_sub(self.start).min(self.travel.ticks);
            let mut last = credit.min(self.sent + DENSE);
            // The last point is either the end or far enough from it for a stop of sparse points.
            if last + 1 == self.travel.ticks {
                last -= 1;
            }
            if last > self.sent {
                self.hand.send(&self.chunk(self.sent + 1, last))?;
                self.sent = last;
                continue;
            }
            let tick = news.credit_tick;
            if !self.hand.wait(|news| news.credit_tick > tick || stops(news)) {
                return Err(EarlyEnd::Stuck(4, format!("credit stays at tick {tick} for {} s", PATIENCE.as_secs())));
            }
        }
    }

    /// Sends the rest and waits until the machine rests.
    pub(super) fn finish(&mut self) -> Result<(), EarlyEnd> {
        let ended = self.on(self.travel.ticks);
        let last = self.tick(self.travel.ticks);
        self.hand.wait(|news| news.tick >= last || stops(news));
        self.hand.rest()?;
        ended
    }

    /// Checks the machine's interpretation of the setpoints, tick by tick: exactly the sent values, and within a count between
    /// sparse points.
    pub(super) fn judge(&self, observed: &Observed, report: &mut ClauseReport) {
        let (before, before_stop) = (report.evidence(10), report.evidence(31));
        let dense = self.tick(self.sent);
        let (mut exact, mut between) = (0, 0);
        let during = |message: &&MachineStream| {
            message.tick >= self.first_tick && message.tick <= self.tick(self.travel.ticks) + 1
        };
        for message in observed.streams.iter().filter(during) {
            let meant = self.travel.point(message.tick.saturating_sub(self.start)).counts;
            // What was sent after an alarm was not taken.
            let is_dense = message.tick <= dense && !stops(message);
            let (clause, allowed) = if is_dense { (10, 0) } else { (31, 1) };
            *(if clause == 10 { &mut exact } else { &mut between }) += 1;
            for (axis, joint) in self.hand.facts.joints.iter().enumerate() {
                let is_reported = message.setpoint_counts.get(axis).copied().unwrap_or(i64::MAX);
                let off = is_reported.saturating_sub(meant[axis]);
                // After an alarm the machine may take other axes off the part.
                let is_own = message.alarms.is_empty() || axis == self.travel.axis;
                if off.abs() > allowed && is_own {
                    report.broken(
                        clause,
                        format!(
                            "tick {}: the setpoint of {joint} is {off} counts off what was sent, allowed {allowed}",
                            message.tick
                        ),
                    );
                }
            }
        }
        if exact > 0 {
            report.kept_unless_broken(10, before, format!("{exact} ticks of a travel executed as sent, to the count"));
        }
        if between > 0 {
            report.kept_unless_broken(31, before_stop, format!("{between} ticks of a stop on the path, to a count"));
        }
    }
}

/// An alarm that stops motion; a refused stranger is a warning.
pub(super) fn stops(news: &MachineStream) -> bool {
    matches!(news.motion, MachineStream::MOTION_STOPPING | MachineStream::MOTION_FAULT | MachineStream::MOTION_OFF)
}
