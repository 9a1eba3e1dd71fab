// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! M2, M3, M4, M7, M40 and M41: what the machine says against ticks and clock, in integers.

use super::observed::{DescriptionFacts, Joints, MAX_TICK, Observed, ns};
use super::report::ClauseReport;
use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::camwright_msgs::msg::MachineStream;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

/// Tolerance of a tick rate: as a share, and for the delay of the first and the last message.
const RATE: (f64, f64) = (0.01, 0.1);
/// The shortest time in which a rate is judged.
const SHORTEST: Duration = Duration::from_secs(2);

pub(super) fn judge(observed: &Observed, facts: &DescriptionFacts, publishes_clock: bool, report: &mut ClauseReport) {
    let Some(first) = observed.streams.first() else {
        return report.broken(3, "machine/stream was not received, though other topics were");
    };
    let epoch_ns = ns(&first.epoch);
    stamps(observed, facts, epoch_ns, report);
    stream(observed, facts, report);
    credit(observed, facts, report);
    joint_states(observed, facts, epoch_ns, report);
    pace(observed, facts, publishes_clock, report);
}

/// Time of a tick, without rounding and without overflow.
fn time_of(tick: u64, epoch_ns: i64, facts: &DescriptionFacts) -> i128 {
    i128::from(epoch_ns) + i128::from(tick) * i128::from(facts.cycle_ns)
}

/// M2: stamps of stream, inputs and alarms, the epoch, and the order of ticks.
fn stamps(observed: &Observed, facts: &DescriptionFacts, epoch_ns: i64, report: &mut ClauseReport) {
    let before = report.evidence(2);
    let streams = observed.streams.iter().map(|message| ("machine/stream", message.tick, &message.stamp));
    let io = observed.io.iter().map(|message| ("machine/io", message.tick, &message.stamp));
    let alarms = observed.alarms.iter().map(|message| ("machine/alarms", message.tick, &message.stamp));
    for (topic, tick, stamp) in streams.chain(io).chain(alarms) {
        let (reported, meant) = (i128::from(ns(stamp)), time_of(tick, epoch_ns, facts));
        if reported != meant || stamp.nanosec >= 1_000_000_000 {
            let off = reported - meant;
            report.broken(
                2,
                format!("{topic}: stamp of tick {tick} is {off} ns off epoch + tick * cycle_time_ns, allowed 0"),
            );
        }
    }
    for pair in observed.streams.windows(2) {
        let [before, after] = pair else { continue };
        if after.epoch != before.epoch {
            let (Time { sec, nanosec }, now) = (&before.epoch, &after.epoch);
            let (from, to) = (format!("{sec}.{nanosec:09}"), format!("{}.{:09}", now.sec, now.nanosec));
            report.broken(2, format!("the epoch goes from {from} to {to} at tick {}", after.tick));
        }
        // The same tick is repeated to acknowledge a command.
        if after.tick < before.tick {
            report.broken(2, format!("tick {} is reported after tick {}", after.tick, before.tick));
        }
    }
    if let Some(tick) = observed.beyond {
        report.broken(2, format!("machine/stream reports tick {tick}; maximum {MAX_TICK}"));
    }
    let steps = steps(observed, facts);
    for moves in [true, false] {
        if usual(&steps, moves) == Some(1) {
            for TickStep { from, ticks, .. } in steps.iter().filter(|step| step.moves == moves && step.ticks > 1) {
                report.broken(2, format!("{} ticks are missing after tick {from} (joint_states)", ticks - 1));
            }
        }
    }
    for TickStep { from, ticks, .. } in steps.iter().filter(|step| step.ticks <= 0) {
        report.broken(2, format!("joint_states go from tick {from} by {ticks}: a tick is executed twice"));
    }
    let count = observed.streams.len() + observed.io.len();
    report.kept_unless_broken(2, before, format!("{count} stamps and {} ticks in a row", observed.joints.len()));
}

/// From one joint state to the next.
struct TickStep {
    from: i64,
    ticks: i64,
    /// They differ: what repeats itself a machine may publish less often.
    moves: bool,
}

/// Steps of the joint states, counted from the first tick.
fn steps(observed: &Observed, facts: &DescriptionFacts) -> Vec<TickStep> {
    let epoch_ns = observed.streams.first().map_or(0, |first| ns(&first.epoch));
    let tick = |stamp_ns: i64| (stamp_ns - epoch_ns).checked_div(facts.cycle_ns).unwrap_or(0);
    let step = |pair: &[Joints]| {
        let [before, after] = pair else { return None };
        let values = |joints: &Joints| [joints.position.clone(), joints.velocity.clone(), joints.effort.clone()];
        let moves = values(before) != values(after);
        Some(TickStep { from: tick(before.stamp_ns), ticks: tick(after.stamp_ns) - tick(before.stamp_ns), moves })
    };
    observed.joints.windows(2).filter_map(step).collect()
}

/// The step that is most frequent in motion, or at rest.
fn usual(steps: &[TickStep], moves: bool) -> Option<i64> {
    let mut counts: BTreeMap<i64, usize> = BTreeMap::new();
    for step in steps.iter().filter(|step| step.moves == moves) {
        *counts.entry(step.ticks).or_default() += 1;
    }
    counts.into_iter().max_by_key(|(_, count)| *count).map(|(step, _)| step)
}

/// Returns whether a machine rests without setpoints; not at pace fast, it then reports less often.
fn is_idle(message: &MachineStream) -> bool {
    message.pace != MachineStream::PACE_FAST
        && message.motion == MachineStream::MOTION_STANDSTILL
        && message.holder.is_empty()
}

/// M3: every tick that is a multiple of the period, and every alarm at once.
fn stream(observed: &Observed, facts: &DescriptionFacts, report: &mut ClauseReport) {
    let before = report.evidence(3);
    for pair in observed.streams.windows(2) {
        let (from, to) = (pair[0].tick, pair[1].tick);
        let period = if is_idle(&pair[0]) { facts.rest_period } else { facts.period };
        let due = (from / period + 1).saturating_mul(period);
        if due < to {
            let missing = (to - 1) / period - from / period;
            report.broken(
                3,
                format!("{missing} of the ticks that are multiples of {period} are missing from tick {due} on"),
            );
        }
    }
    let (first, last) = match (observed.streams.first(), observed.streams.last()) {
        (Some(first), Some(last)) => (first.tick, last.tick),
        _ => return,
    };
    let reported: BTreeSet<u64> = observed.streams.iter().map(|message| message.tick).collect();
    // The first message of alarms is what was latched before.
    for changed in observed.alarms.iter().skip(1).filter(|message| (first..=last).contains(&message.tick)) {
        if !reported.contains(&changed.tick) {
            report.broken(
                3,
                format!("alarms change at tick {}, machine/stream has no message for that tick", changed.tick),
            );
        }
    }
    for pair in observed.streams.windows(2) {
        let [before, after] = pair else { continue };
        let is_over = |message: &MachineStream| message.motion == MachineStream::MOTION_STANDSTILL;
        // An axis at rest at one tick and moving at the next reported one began to move in between.
        if is_over(before) && after.motion != before.motion && after.tick.saturating_sub(before.tick) > 1 {
            let moved = after.setpoint_counts != before.setpoint_counts;
            if moved {
                report.broken(
                    3,
                    format!(
                        "motion changes between tick {} and tick {}, and no message reports its tick",
                        before.tick, after.tick
                    ),
                );
            }
        }
    }
    let seen = format!(
        "{} messages over {} ticks, at least one in {}, at rest in {}",
        observed.streams.len(),
        last.saturating_sub(first),
        facts.period,
        facts.rest_period
    );
    report.kept_unless_broken(3, before, seen);
}

/// M4.
fn credit(observed: &Observed, facts: &DescriptionFacts, report: &mut ClauseReport) {
    let before = report.evidence(4);
    for message in &observed.streams {
        if message.credit_tick > message.tick.saturating_add(facts.delay) {
            let over = message.credit_tick.saturating_sub(message.tick);
            report
                .broken(4, format!("credit is {over} ticks ahead of tick {}; allowed: {}", message.tick, facts.delay));
        }
    }
    report.kept_unless_broken(4, before, format!("never more than {} ticks", facts.delay));
}

/// M7: stamps of ticks, as evenly as they began. Where there is one a tick, one that is missing is a tick that is missing (M2).
fn joint_states(observed: &Observed, facts: &DescriptionFacts, epoch_ns: i64, report: &mut ClauseReport) {
    let before = report.evidence(7);
    let steps = steps(observed, facts);
    let (moving, resting) = (usual(&steps, true), usual(&steps, false));
    let Some(step) = moving.or(resting) else {
        return report.not_seen(7, "fewer than two messages of joint_states were received");
    };
    for message in &observed.joints {
        let rest = (message.stamp_ns - epoch_ns).checked_rem(facts.cycle_ns).unwrap_or(0);
        if rest != 0 {
            report.broken(7, format!("a stamp of joint_states is {rest} ns off a tick, allowed 0"));
        }
    }
    if let Some(step) = moving.filter(|step| *step > 1) {
        // What begins to move after a rest begins between two of them.
        let within = steps.windows(2).filter(|pair| pair.iter().all(|step| step.moves)).map(|pair| &pair[1]);
        for TickStep { from, ticks, .. } in within.filter(|other| other.ticks != step) {
            report.broken(7, format!("joint_states come every {step} ticks, after tick {from} {ticks} later"));
        }
    }
    if let Some(step) = resting.filter(|step| *step > 1) {
        // A rest may begin and end between two of them, so a shorter step is none that is missing.
        for TickStep { from, ticks, .. } in steps.iter().filter(|other| !other.moves && other.ticks > step) {
            report.broken(7, format!("joint_states come every {step} ticks at rest, after tick {from} {ticks} later"));
        }
    }
    let seen = format!("{} messages, one in {step} ticks", observed.joints.len());
    report.kept_unless_broken(7, before, seen);
}

/// M40 and M41.
fn pace(observed: &Observed, facts: &DescriptionFacts, publishes_clock: bool, report: &mut ClauseReport) {
    let (Some(first), Some(last)) = (observed.streams.first(), observed.streams.last()) else { return };
    if observed.streams.iter().any(|message| message.pace == MachineStream::PACE_FAST) {
        report.not_seen(40, "the machine runs at pace fast");
        if publishes_clock {
            report.kept(41, "pace fast, with /clock");
        } else {
            report.broken(41, "the machine runs at pace fast, and no node publishes /clock");
        }
        return;
    }
    report.not_seen(41, "the machine runs at pace realtime");
    if let Some(message) = observed.streams.iter().find(|message| message.pace != MachineStream::PACE_REALTIME) {
        return report.broken(40, format!("pace is {} at tick {}; allowed: 0 and 1", message.pace, message.tick));
    }
    let (Some(began), Some(ended)) = (observed.came.first(), observed.came.last()) else { return };
    let passed = ended.duration_since(*began);
    if passed < SHORTEST {
        return report.not_seen(40, format!("only {:.1} s were received", passed.as_secs_f64()));
    }
    let ticked_s = last.tick.saturating_sub(first.tick) as f64 * facts.cycle_s();
    let off_s = gained_s(observed, facts, *began, first.tick);
    let allowed_s = RATE.0.mul_add(passed.as_secs_f64(), RATE.1);
    let seen = format!("{ticked_s:.3} s of ticks in {:.3} s", ticked_s - off_s);
    if off_s.abs() <= allowed_s {
        report.kept(40, seen);
    } else if let Some(warning) = observed.warnings.first() {
        let how = if off_s < 0.0 { "is late" } else { "makes up for what it was late" };
        report.kept(40, format!("{seen}; it {how}, and warns: {warning}"));
    } else {
        report.broken(40, format!("{seen}; allowed: {allowed_s:.3} s of difference, and /diagnostics has no warning"));
    }
}

/// Gain of the ticks on the clock (s). A message comes late on a busy processor, and never early: so the message that came earliest for its tick
/// counts, in the first quarter and in the last; for a machine that gains evenly they are three quarters of the time apart.
fn gained_s(observed: &Observed, facts: &DescriptionFacts, began: Instant, first_tick: u64) -> f64 {
    let late_s = |(message, came): (&MachineStream, &Instant)| {
        came.duration_since(began).as_secs_f64() - message.tick.saturating_sub(first_tick) as f64 * facts.cycle_s()
    };
    let all: Vec<f64> = observed.streams.iter().zip(&observed.came).map(late_s).collect();
    let quarter = all.len() / 4;
    let min = |some: &[f64]| some.iter().copied().fold(f64::INFINITY, f64::min);
    let gained_s = (min(&all[..quarter]) - min(&all[all.len() - quarter..])) / 0.75;
    if gained_s.is_finite() { gained_s } else { 0.0 }
}
