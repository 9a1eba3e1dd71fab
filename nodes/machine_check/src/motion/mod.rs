// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Clauses that need motion: M10 to M14, M20, M21, M30, M31 and M33. The user has consented to it.

mod commands;
mod drive;
mod refusals;
mod silence;
mod test_motion;
mod travel;

use super::observed::{DescriptionFacts, Observed, Observer};
use super::report::ClauseReport;
use super::{Moving, ProgressSink};
use camwright_msgs::camwright_msgs::msg::{MachineDescription, MachineIo, MachineStream};
use camwright_ros::{Node, RosArgs, Shutdown};
use drive::Drive;
use std::time::Duration;
use test_motion::{EarlyEnd, PATIENCE, TestMotion};
use travel::TestTravel;

/// The shortest feedback delay with which there is room for what is tried here (ticks).
const MIN_DELAY: u64 = 24;
/// Maximum time for the state of inputs.
const INPUTS: Duration = Duration::from_secs(5);
/// Numbers of alarms that are of this program's doing.
const OWN_ALARMS: [u16; 7] = [1, 80, 81, 82, 83, 84, 85];

/// Context of the tests.
pub(super) struct ClauseBench<'a> {
    hand: &'a TestMotion<'a>,
    description: &'a MachineDescription,
    axis: usize,
    /// Start and target of the axis (counts).
    home: i64,
    away: i64,
    /// An input to ask for, and whether it is closed.
    input: (String, bool),
    is_realtime: bool,
    args: &'a RosArgs,
}

impl ClauseBench<'_> {
    /// A travel to the other of both ends.
    fn travel(&self) -> TestTravel {
        let from = self.hand.news().setpoint_counts;
        let here = from.get(self.axis).copied().unwrap_or_default();
        let to = if here == self.home { self.away } else { self.home };
        TestTravel::new(self.hand.facts, self.axis, &self.description.axes[self.axis], &from, to - here)
    }
}

/// Why nothing may be moved now.
pub(super) fn obstacle(ears: &Observer) -> Option<String> {
    ears.read(|observed| {
        let news = observed.last()?;
        if !news.holder.is_empty() {
            return Some(format!("{} has command", news.holder));
        }
        if let Some(alarm) = observed.alarms.last().and_then(|message| message.alarms.first()) {
            return Some(format!("alarm {} is active: {}", alarm.number, alarm.text));
        }
        if !news.alarms.is_empty() {
            return Some(format!("alarms {:?} are active", news.alarms));
        }
        let at_rest = news.motion == MachineStream::MOTION_STANDSTILL;
        (!at_rest).then(|| format!("the machine does not rest: motion is {}", news.motion))
    })
}

/// Target of the axis (counts); an error if there is none.
pub(super) fn target(
    description: &MachineDescription,
    facts: &DescriptionFacts,
    observed: &Observed,
    moving: &Moving,
) -> Result<(usize, i64, i64), String> {
    let axis = facts.joints.iter().position(|joint| *joint == moving.joint);
    let axis = axis.ok_or_else(|| format!("there is no axis {:?}, there are {:?}", moving.joint, facts.joints))?;
    let home = observed.last().and_then(|news| news.setpoint_counts.get(axis)).copied();
    let home = home.ok_or("the machine does not say where its axes are")?;
    #[allow(clippy::cast_possible_truncation, reason = "the cast saturates, and then breaks the soft limits")]
    let by = (moving.distance * facts.per_unit[axis]).round() as i64;
    if by == 0 {
        return Err(format!("distance {} is less than a count", moving.distance));
    }
    let away = home.saturating_add(by);
    let limits = &description.axes[axis];
    let (here, there) = (home as f64 / facts.per_unit[axis], away as f64 / facts.per_unit[axis]);
    let unit = if limits.linear { "m" } else { "rad" };
    for place in [here, there] {
        if limits.has_soft_limits && !(limits.soft_min..=limits.soft_max).contains(&place) {
            let (low, high) = (limits.soft_min, limits.soft_max);
            return Err(format!(
                "{} would be at {place} {unit}, its soft limits are {low} to {high} {unit}",
                moving.joint
            ));
        }
    }
    Ok((axis, home, away))
}

/// An input to ask for: one that is closed, if there is one, else the one that every machine names.
fn input(observed: &Observed) -> (String, bool) {
    let closed = observed.io.last().and_then(|io: &MachineIo| {
        let stations = io.station_switches.iter().zip(&io.station_states);
        let mut all = stations.chain(io.other_inputs.iter().zip(&io.other_states));
        all.find(|(_, closed)| **closed).map(|(name, _)| name.clone())
    });
    let origin = observed.io.last().is_some_and(|io| io.origin);
    closed.map_or_else(|| ("origin".to_owned(), origin), |name| (name, true))
}

/// Moves the axis, again and again, and leaves it where it was.
pub(super) fn run(
    (node, args, shutdown): (&Node, &RosArgs, &Shutdown),
    (ears, facts, description): (&Observer, &DescriptionFacts, &MachineDescription),
    (axis, home, away): (usize, i64, i64),
    report: &mut ClauseReport,
    report_progress: ProgressSink<'_>,
) -> bool {
    if facts.delay < MIN_DELAY {
        report.not_seen(10, format!("feedback_delay_ticks is {}, moving needs {MIN_DELAY}", facts.delay));
        return false;
    }
    let epoch_ns = ears.read(|observed| observed.last().map_or(0, |news| super::observed::ns(&news.epoch)));
    let hand = match TestMotion::new(node, ears, facts, epoch_ns, shutdown) {
        Ok(hand) => hand,
        Err(stop) => return ended(Err(stop), report, report_progress),
    };
    let is_realtime =
        |observed: &Observed| observed.last().is_some_and(|news| news.pace == MachineStream::PACE_REALTIME);
    if ears.read(is_realtime) {
        // Inputs are published when they change, and once a second.
        hand.wait_observed(INPUTS, |observed| !observed.io.is_empty());
    }
    let (input, is_realtime) = ears.read(|observed| (input(observed), is_realtime(observed)));
    let bench = ClauseBench { hand: &hand, description, axis, home, away, input, is_realtime, args };
    let done = sequence(&bench, report, report_progress);
    let left = leave(&bench, report);
    let is_interrupted = ended(done, report, report_progress);
    if let Err(stop) = left {
        return ended(Err(stop), report, report_progress) || is_interrupted;
    }
    is_interrupted
}

fn sequence(
    bench: &ClauseBench<'_>,
    report: &mut ClauseReport,
    report_progress: ProgressSink<'_>,
) -> Result<(), EarlyEnd> {
    report_progress("moving: a travel as it should be");
    plain(bench, report)?;
    report_progress("moving: a second sender");
    foreign(bench, report)?;
    report_progress("silence in the middle of a travel");
    silence::silence(bench, report)?;
    report_progress("setpoints that get lost");
    silence::lost(bench, report)?;
    report_progress("commands out of order");
    commands::gap(bench, report)?;
    commands::late(bench, report)?;
    report_progress("chunks that must be refused");
    refusals::run(bench, report)?;
    report_progress("machine/estop");
    refusals::estop(bench, report)
}

/// Brings the axis back, and clears what this program has raised.
fn leave(bench: &ClauseBench<'_>, report: &mut ClauseReport) -> Result<(), EarlyEnd> {
    bench.hand.rest()?;
    let news = bench.hand.news();
    if news.alarms.iter().any(|number| OWN_ALARMS.contains(number)) {
        bench.hand.clear()?;
    }
    let here = bench.hand.news().setpoint_counts.get(bench.axis).copied();
    if here != Some(bench.home) && !bench.hand.shutdown.is_requested() {
        let mut drive = Drive::begin(bench.hand, bench.travel(), None)?;
        drive.finish()?;
        bench.hand.ears.read(|observed| drive.judge(observed, report));
    }
    Ok(())
}

/// Reports an early end; returns whether the user requested it.
fn ended(done: Result<(), EarlyEnd>, report: &mut ClauseReport, report_progress: ProgressSink<'_>) -> bool {
    match done {
        Ok(()) => false,
        Err(EarlyEnd::Interrupted) => true,
        Err(EarlyEnd::Stuck(clause, why)) => {
            report_progress(&format!("cannot go on: {why}"));
            report.broken(clause, format!("{why}; the tests with motion could not go on"));
            false
        }
    }
}

/// A travel with nothing wrong: M8, M10, M11, M14, M20, M21, and that a reset is refused on the way.
fn plain(bench: &ClauseBench<'_>, report: &mut ClauseReport) -> Result<(), EarlyEnd> {
    let hand = bench.hand;
    let before = report.evidence(10);
    let begin = hand.ears.read(|observed| observed.streams.len());
    let mut drive = Drive::begin(hand, bench.travel(), Some(&bench.input.0))?;
    drive.on(drive.travel.ticks / 2)?;
    let answer = hand.ask_reset()?;
    let finished = drive.finish();
    match answer.recv_timeout(PATIENCE) {
        Ok(answer) if answer.success => report.broken(30, "machine/reset reports success while an axis moves"),
        Ok(answer) => report.kept(30, format!("a reset is refused while an axis moves: {}", answer.message)),
        Err(_) => report.broken(30, format!("machine/reset does not answer within {} s", PATIENCE.as_secs())),
    }
    finished?;
    let left = hand.wait(|news| news.holder.is_empty());
    hand.ears.read(|observed| {
        let during = observed.streams.get(begin..).unwrap_or_default();
        drive.judge(observed, report);
        pending(&drive, during, report);
        command(left, &drive, during, report);
        if !bench.is_realtime {
            report.not_seen(11, "at pace fast what is sent is executed at once");
        } else if report.evidence(10) == before {
            report.kept(11, "setpoints that were sent for ticks ahead were replaced by later ones");
        } else {
            report.not_seen(11, "setpoints are not what was sent, see M10");
        }
        commands::acknowledged(bench, &drive, during, report);
    });
    let (end, alarms) = (hand.news().setpoint_counts, hand.news().alarms);
    if end != drive.travel.end() || !alarms.is_empty() {
        let wanted = drive.travel.end();
        report.broken(
            10,
            format!("after the travel setpoints are {end:?} with alarms {alarms:?}, they were to be {wanted:?}"),
        );
        hand.clear()?;
    }
    Ok(())
}

/// M8: pending setpoints are no standstill. M3: the start of a motion is reported at its tick.
fn pending(drive: &Drive<'_>, during: &[MachineStream], report: &mut ClauseReport) {
    let before = report.evidence(8);
    for message in
        during.iter().filter(|message| !message.holder.is_empty() && message.tick < drive.tick(drive.travel.ticks))
    {
        if message.motion == MachineStream::MOTION_STANDSTILL {
            report.broken(
                8,
                format!("tick {}: STANDSTILL while setpoints of {} are pending", message.tick, message.holder),
            );
        }
    }
    report.kept_unless_broken(8, before, "no STANDSTILL while setpoints were pending");
}

/// M14: who has command, from the first chunk to the last.
fn command(left: bool, drive: &Drive<'_>, during: &[MachineStream], report: &mut ClauseReport) {
    let before = report.evidence(14);
    let (first, last) = (drive.first_tick, drive.tick(drive.travel.ticks));
    for message in
        during.iter().filter(|message| message.tick >= first && message.tick < last && message.holder.is_empty())
    {
        report.broken(14, format!("tick {}: no client has command between the first chunk and the last", message.tick));
    }
    if !left {
        report.broken(14, format!("a client still has command; the last setpoint was of tick {last}"));
    }
    let holder = during.iter().find(|message| !message.holder.is_empty()).map_or("", |message| &message.holder);
    report.kept_unless_broken(14, before, format!("{holder} had command from its first chunk to its last"));
}

/// M14: chunks of another sender. They say what was sent anyway, so nothing happens if they are taken.
fn foreign(bench: &ClauseBench<'_>, report: &mut ClauseReport) -> Result<(), EarlyEnd> {
    let hand = bench.hand;
    let stranger = TestMotion::stranger(bench.args)?;
    let mut drive = Drive::begin(hand, bench.travel(), None)?;
    drive.on(drive.travel.ticks / 2)?;
    if drive.sent > 8 && drive.sent < drive.travel.ticks {
        stranger.setpoints.publish(&drive.chunk(drive.sent - 4, drive.sent))?;
    }
    drive.finish()?;
    let first = drive.first_tick;
    let is_reported_alarm = |observed: &Observed| {
        observed
            .streams
            .iter()
            .rev()
            .take_while(|message| message.tick >= first)
            .any(|message| message.alarms.contains(&83))
    };
    let is_reported = hand.ears.read(is_reported_alarm) || hand.happens(|message| message.alarms.contains(&83));
    if is_reported {
        report.kept(14, "a chunk of a second sender was refused with warning 83");
    } else {
        report.broken(
            14,
            format!(
                "a chunk of a second sender for tick {} was not refused with warning 83",
                drive.tick(drive.sent.saturating_sub(4))
            ),
        );
    }
    hand.ears.read(|observed| drive.judge(observed, report));
    hand.clear()
}
