//! M5, M6 and M8: what the machine says of axes and inputs.

use super::observed::{Facts, Joints, Observed, ns};
use super::report::Report;
use camwright_msgs::camwright_msgs::msg::{Latch, MachineStream};
use std::collections::BTreeMap;

/// Counts by which the position at an edge may lie outside of what the encoder read before and after it.
const EDGE_COUNTS: i64 = 2;
/// Share of an axis' largest acceleration within which two words on its velocity in a tick agree, times the tick.
const VELOCITY: f64 = 2.0;

pub(super) fn judge(heard: &Observed, facts: &Facts, report: &mut Report) {
    let places = columns(heard, facts);
    counts(heard, facts, &places, report);
    latches(heard, facts, report);
    motion(heard, facts, report);
}

/// Columns of the axes in the joint states.
fn columns(heard: &Observed, facts: &Facts) -> Option<Vec<usize>> {
    facts.joints.iter().map(|joint| heard.joint_names.iter().position(|name| name == joint)).collect()
}

/// The count of a position.
#[allow(clippy::cast_possible_truncation, reason = "the cast saturates, and then differs")]
fn count(position: f64, per_unit: f64) -> i64 {
    (position * per_unit).round() as i64
}

/// M5: the stream against the joint states of the same tick.
fn counts(heard: &Observed, facts: &Facts, places: &Option<Vec<usize>>, report: &mut Report) {
    let before = report.evidence(5);
    let axes = facts.joints.len();
    for said in &heard.streams {
        let lengths = [said.setpoint_counts.len(), said.actual_counts.len(), said.actual_velocities.len()];
        if lengths != [axes; 3] {
            report.broken(
                5,
                format!("tick {}: {lengths:?} setpoints, counts and velocities, allowed are {axes}", said.tick),
            );
        }
    }
    if let Some(other) = &heard.other_names {
        report.broken(5, format!("joint_states name {other:?} after {:?}", heard.joint_names));
    }
    if heard.joint_names.is_empty() {
        return report.not_seen(5, "joint_states were not heard");
    }
    let Some(places) = places else {
        return report.broken(5, format!("joint_states name {:?}, the axes are {:?}", heard.joint_names, facts.joints));
    };
    let states: BTreeMap<i64, &Joints> = heard.joints.iter().map(|said| (said.stamp_ns, said)).collect();
    let accelerations = heard.description.iter().flat_map(|said| said.axes.iter().map(|axis| axis.max_acceleration));
    let accelerations: Vec<f64> = accelerations.collect();
    let mut compared = 0;
    for said in &heard.streams {
        let Some(state) = states.get(&ns(&said.stamp)) else { continue };
        compared += 1;
        for (axis, place) in places.iter().enumerate() {
            let (Some(position), Some(told)) = (state.position.get(*place), said.actual_counts.get(axis)) else {
                continue;
            };
            let read = count(*position, facts.per_unit[axis]);
            let joint = &facts.joints[axis];
            if read != *told {
                report.broken(
                    5,
                    format!(
                        "tick {}: {joint} is at {told} counts in machine/stream, at {read} in joint_states",
                        said.tick
                    ),
                );
            }
            let (Some(one), Some(other)) = (state.velocity.get(*place), said.actual_velocities.get(axis)) else {
                continue;
            };
            let allowed = VELOCITY * accelerations.get(axis).copied().unwrap_or(0.0) * facts.cycle_s();
            // A number that is not one agrees with nothing.
            if (one - other).is_nan() || (one - other).abs() > allowed {
                report.broken(
                    5,
                    format!(
                        "tick {}: {joint} goes {other} in machine/stream, {one} in joint_states, allowed {allowed}",
                        said.tick
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
fn latches(heard: &Observed, facts: &Facts, report: &mut Report) {
    let before = report.evidence(6);
    let each = heard.streams.iter().enumerate();
    let told: Vec<(usize, &MachineStream, &Latch)> =
        each.flat_map(|(index, said)| said.latches.iter().map(move |latch| (index, said, latch))).collect();
    let mut seen: BTreeMap<(u64, &str, bool), (usize, u64)> = BTreeMap::new();
    for (index, said, latch) in &told {
        let what = format!("the edge of {} at tick {}", latch.input, latch.tick);
        // A bouncing input has several edges in a tick, which one message reports.
        let earlier = seen.insert((latch.tick, &latch.input, latch.rising), (*index, said.tick));
        if let Some((_, earlier)) = earlier.filter(|(before, _)| before != index) {
            report.broken(6, format!("{what} is told at tick {earlier} and again at tick {}", said.tick));
        }
        let late = said.tick.saturating_sub(latch.tick);
        if late > facts.delay || latch.tick > said.tick {
            report.broken(6, format!("{what} is told at tick {}, allowed are {} ticks later", said.tick, facts.delay));
        }
        let Some(axis) = facts.joints.iter().position(|joint| *joint == latch.joint) else {
            report.broken(6, format!("{what} is of the joint {:?}, the axes are {:?}", latch.joint, facts.joints));
            continue;
        };
        if let Some((low, high)) = around(heard, facts, axis, latch.tick)
            && !(low.saturating_sub(EDGE_COUNTS)..=high.saturating_add(EDGE_COUNTS)).contains(&latch.counts)
        {
            let (joint, at) = (&latch.joint, latch.counts);
            report.broken(6, format!("{what} has {joint} at {at} counts, the encoder read {low} to {high} around it"));
        }
    }
    if !told.is_empty() {
        report.kept_unless_broken(6, before, format!("{} edges, each told once and in time", told.len()));
    }
}

/// Encoder readings of an axis from the tick before to the tick of an edge.
fn around(heard: &Observed, facts: &Facts, axis: usize, tick: u64) -> Option<(i64, i64)> {
    let epoch_ns = heard.streams.first().map(|first| ns(&first.epoch))?;
    let at = epoch_ns.checked_add(i64::try_from(tick).ok()?.checked_mul(facts.cycle_ns)?)?;
    let place = heard.joint_names.iter().position(|name| *name == facts.joints[axis])?;
    let until = heard.joints.partition_point(|said| said.stamp_ns <= at);
    let from = heard.joints.partition_point(|said| said.stamp_ns < at.saturating_sub(facts.cycle_ns));
    let read = heard.joints.get(from..until)?.iter().filter_map(|said| said.position.get(place));
    let read = read.map(|position| count(*position, facts.per_unit[axis]));
    // Both of them, or nothing can be said.
    let read: Vec<i64> = read.collect();
    if read.len() < 2 { None } else { read.iter().min().copied().zip(read.iter().max().copied()) }
}

fn at_rest(said: &MachineStream) -> bool {
    said.motion == MachineStream::MOTION_STANDSTILL
}

/// News and the next, between which setpoints moved, though both say that all rests and nobody has command.
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
fn motion(heard: &Observed, facts: &Facts, report: &mut Report) {
    let before = report.evidence(8);
    for said in &heard.streams {
        if said.motion > MachineStream::MOTION_FAULT {
            report.broken(8, format!("motion is {} at tick {}, allowed are 0 to 4", said.motion, said.tick));
        }
        for (axis, joint) in facts.joints.iter().enumerate().filter(|_| at_rest(said)) {
            let (setpoint, actual) = (said.setpoint_counts.get(axis), said.actual_counts.get(axis));
            if setpoint != actual {
                report.broken(
                    8,
                    format!(
                        "tick {}: STANDSTILL, and {joint} is told at {actual:?}, its setpoint is {setpoint:?}",
                        said.tick
                    ),
                );
            }
        }
    }
    for (one, other) in moves_at_standstill(&heard.streams) {
        let (from, to) = (&one.setpoint_counts, &other.setpoint_counts);
        report.broken(
            8,
            format!("STANDSTILL at ticks {} and {}, setpoints go from {from:?} to {to:?}", one.tick, other.tick),
        );
    }
    let count = heard.streams.iter().filter(|said| at_rest(said)).count();
    if count > 0 {
        report.kept_unless_broken(8, before, format!("{count} times STANDSTILL, every axis at its setpoint"));
    }
}
