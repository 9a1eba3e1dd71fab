// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! M5, M6 and M8: what the machine says of axes and inputs.

use super::observed::{DescriptionFacts, Joints, Observed, ns};
use super::report::ClauseReport;
use camwright_msgs::camwright_msgs::msg::{Latch, MachineStream};
use std::collections::BTreeMap;

/// Counts by which the position at an edge may lie outside of what the encoder read before and after it.
const EDGE_COUNTS: i64 = 2;
/// Share of an axis' largest acceleration within which two words on its velocity in a tick agree, times the tick.
const VELOCITY: f64 = 2.0;

pub(super) fn judge(observed: &Observed, facts: &DescriptionFacts, report: &mut ClauseReport) {
    let places = columns(observed, facts);
    counts(observed, facts, &places, report);
    latches(observed, facts, report);
    motion(observed, facts, report);
}

/// Columns of the axes in the joint states.
fn columns(observed: &Observed, facts: &DescriptionFacts) -> Option<Vec<usize>> {
    facts.joints.iter().map(|joint| observed.joint_names.iter().position(|name| name == joint)).collect()
}

/// The count of a position.
#[allow(clippy::cast_possible_truncation, reason = "the cast saturates, and then differs")]
fn count(position: f64, per_unit: f64) -> i64 {
    (position * per_unit).round() as i64
}

/// M5: the stream against the joint states of the same tick.
fn counts(observed: &Observed, facts: &DescriptionFacts, places: &Option<Vec<usize>>, report: &mut ClauseReport) {
    let before = report.evidence(5);
    let axes = facts.joints.len();
    for message in &observed.streams {
        let lengths = [message.setpoint_counts.len(), message.actual_counts.len(), message.actual_velocities.len()];
        if lengths != [axes; 3] {
            report.broken(
                5,
                format!("tick {}: {lengths:?} setpoints, counts and velocities; allowed: {axes}", message.tick),
            );
        }
    }
    if let Some(other) = &observed.other_names {
        report.broken(5, format!("joint_states name {other:?} after {:?}", observed.joint_names));
    }
    if observed.joint_names.is_empty() {
        return report.not_seen(5, "joint_states were not received");
    }
    let Some(places) = places else {
        return report
            .broken(5, format!("joint_states name {:?}, the axes are {:?}", observed.joint_names, facts.joints));
    };
    let states: BTreeMap<i64, &Joints> = observed.joints.iter().map(|message| (message.stamp_ns, message)).collect();
    let accelerations =
        observed.description.iter().flat_map(|message| message.axes.iter().map(|axis| axis.max_acceleration));
    let accelerations: Vec<f64> = accelerations.collect();
    let mut compared = 0;
    for message in &observed.streams {
        let Some(state) = states.get(&ns(&message.stamp)) else { continue };
        compared += 1;
        for (axis, place) in places.iter().enumerate() {
            let (Some(position), Some(reported)) = (state.position.get(*place), message.actual_counts.get(axis)) else {
                continue;
            };
            let read = count(*position, facts.per_unit[axis]);
            let joint = &facts.joints[axis];
            if read != *reported {
                report.broken(
                    5,
                    format!(
                        "tick {}: {joint} is at {reported} counts in machine/stream, at {read} in joint_states",
                        message.tick
                    ),
                );
            }
            let (Some(one), Some(other)) = (state.velocity.get(*place), message.actual_velocities.get(axis)) else {
                continue;
            };
            let allowed = VELOCITY * accelerations.get(axis).copied().unwrap_or(0.0) * facts.cycle_s();
            // A number that is not one agrees with nothing.
            if (one - other).is_nan() || (one - other).abs() > allowed {
                report.broken(
                    5,
                    format!(
                        "tick {}: {joint} goes {other} in machine/stream, {one} in joint_states, allowed {allowed}",
                        message.tick
                    ),
                );
            }
        }
    }
    if compared == 0 {
        report.not_seen(5, "no message of joint_states has the stamp of one of machine/stream");
    } else {
        report.kept_unless_broken(
            5,
            before,
            format!("{compared} ticks read the same in machine/stream and in joint_states"),
        );
    }
}

/// M6: each edge once, in time, and where the axis was then.
fn latches(observed: &Observed, facts: &DescriptionFacts, report: &mut ClauseReport) {
    let before = report.evidence(6);
    let each = observed.streams.iter().enumerate();
    let reported: Vec<(usize, &MachineStream, &Latch)> =
        each.flat_map(|(index, message)| message.latches.iter().map(move |latch| (index, message, latch))).collect();
    let mut seen: BTreeMap<(u64, &str, bool), (usize, u64)> = BTreeMap::new();
    for (index, message, latch) in &reported {
        let what = format!("the edge of {} at tick {}", latch.input, latch.tick);
        // A bouncing input has several edges in a tick, which one message reports.
        let earlier = seen.insert((latch.tick, &latch.input, latch.rising), (*index, message.tick));
        if let Some((_, earlier)) = earlier.filter(|(before, _)| before != index) {
            report.broken(6, format!("{what} is reported at tick {earlier} and again at tick {}", message.tick));
        }
        let late = message.tick.saturating_sub(latch.tick);
        if late > facts.delay || latch.tick > message.tick {
            report.broken(
                6,
                format!("{what} is reported at tick {}; allowed: up to {} ticks later", message.tick, facts.delay),
            );
        }
        let Some(axis) = facts.joints.iter().position(|joint| *joint == latch.joint) else {
            report.broken(6, format!("{what} is of the joint {:?}, the axes are {:?}", latch.joint, facts.joints));
            continue;
        };
        if let Some((low, high)) = around(observed, facts, axis, latch.tick)
            && !(low.saturating_sub(EDGE_COUNTS)..=high.saturating_add(EDGE_COUNTS)).contains(&latch.counts)
        {
            let (joint, at) = (&latch.joint, latch.counts);
            report.broken(6, format!("{what} has {joint} at {at} counts, the encoder read {low} to {high} around it"));
        }
    }
    if !reported.is_empty() {
        report.kept_unless_broken(6, before, format!("{} edges, each reported once and in time", reported.len()));
    }
}

/// Encoder readings of an axis from the tick before to the tick of an edge.
fn around(observed: &Observed, facts: &DescriptionFacts, axis: usize, tick: u64) -> Option<(i64, i64)> {
    let epoch_ns = observed.streams.first().map(|first| ns(&first.epoch))?;
    let at = epoch_ns.checked_add(i64::try_from(tick).ok()?.checked_mul(facts.cycle_ns)?)?;
    let place = observed.joint_names.iter().position(|name| *name == facts.joints[axis])?;
    let until = observed.joints.partition_point(|message| message.stamp_ns <= at);
    let from = observed.joints.partition_point(|message| message.stamp_ns < at.saturating_sub(facts.cycle_ns));
    let read = observed.joints.get(from..until)?.iter().filter_map(|message| message.position.get(place));
    let read = read.map(|position| count(*position, facts.per_unit[axis]));
    // Both of them, or nothing can be said.
    let read: Vec<i64> = read.collect();
    if read.len() < 2 { None } else { read.iter().min().copied().zip(read.iter().max().copied()) }
}

fn at_rest(message: &MachineStream) -> bool {
    message.motion == MachineStream::MOTION_STANDSTILL
}

/// News and the next, between which setpoints moved, though both say that all rests and no client has command.
pub(super) fn moves_at_standstill(streams: &[MachineStream]) -> impl Iterator<Item = (&MachineStream, &MachineStream)> {
    streams.windows(2).filter_map(|pair| {
        let [one, other] = pair else { return None };
        // A new zero moves nothing, and comes from who has command.
        let nobody = one.holder.is_empty() && other.holder.is_empty();
        (at_rest(one) && at_rest(other) && nobody && one.setpoint_counts != other.setpoint_counts)
            .then_some((one, other))
    })
}

/// M8: what rests, rests exactly.
fn motion(observed: &Observed, facts: &DescriptionFacts, report: &mut ClauseReport) {
    let before = report.evidence(8);
    for message in &observed.streams {
        if message.motion > MachineStream::MOTION_FAULT {
            report.broken(8, format!("motion is {} at tick {}; allowed: 0 to 4", message.motion, message.tick));
        }
        for (axis, joint) in facts.joints.iter().enumerate().filter(|_| at_rest(message)) {
            let (setpoint, actual) = (message.setpoint_counts.get(axis), message.actual_counts.get(axis));
            if setpoint != actual {
                report.broken(
                    8,
                    format!(
                        "tick {}: STANDSTILL, but {joint} is reported at {actual:?}; its setpoint is {setpoint:?}",
                        message.tick
                    ),
                );
            }
        }
    }
    for (one, other) in moves_at_standstill(&observed.streams) {
        let (from, to) = (&one.setpoint_counts, &other.setpoint_counts);
        report.broken(
            8,
            format!("STANDSTILL at ticks {} and {}, setpoints go from {from:?} to {to:?}", one.tick, other.tick),
        );
    }
    let count = observed.streams.iter().filter(|message| at_rest(message)).count();
    if count > 0 {
        report.kept_unless_broken(8, before, format!("{count} times STANDSTILL, every axis at its setpoint"));
    }
}
