// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Recorded outputs of a tick, compared with the replayed ones.

use super::difference::ReplayDifference;
use camwright::machine::description::{AXIS_COUNT, Axis, AxisScale, MachineDescription};
use camwright::simulation::tick_report::TickReport;
use camwright_files::convert::gauge::readings;
use camwright_files::convert::machine_report::{io_message, joint_values, latch_message, motion_number};
use camwright_files::convert::si_from_core;
use camwright_files::convert::time::TickClock;
use camwright_machine_cycle::replay::TickOutput;
use camwright_msgs::camwright_msgs::msg::{Alarm, GaugeReading, MachineAlarms, MachineIo, MachineStream};
use camwright_msgs::sensor_msgs::msg::JointState;

/// A message of the machine, to be compared with its tick.
#[derive(Debug)]
pub(super) enum Output {
    Joints(JointState),
    Stream(Box<MachineStream>),
    Io(Box<MachineIo>),
    Gauge(GaugeReading),
    Alarms(MachineAlarms),
}

/// Size of a count (m or rad).
fn size(machine: &MachineDescription, axis: Axis) -> Option<(Axis, f64)> {
    let per_unit = match machine.axis(axis).scale {
        scale @ (AxisScale::Linear { .. } | AxisScale::Rotary { .. }) => scale.counts_per_unit(),
    };
    Some((axis, si_from_core(axis, 1.0 / per_unit)))
}

/// First difference between the recorded and the replayed outputs of a tick.
pub(super) fn difference(
    output: &Output,
    ticked: &TickOutput,
    machine: &MachineDescription,
    clock: TickClock,
) -> Option<ReplayDifference> {
    let report = &ticked.report;
    match output {
        Output::Joints(message) => joints(message, report, machine),
        Output::Stream(message) => stream(message, report, machine).or_else(|| states(message, ticked)),
        Output::Io(message) => io(message, report, machine),
        Output::Gauge(message) => gauge(message, report, machine),
        Output::Alarms(message) => alarms(message, ticked, clock),
    }
}

fn joints(old: &JointState, report: &TickReport, machine: &MachineDescription) -> Option<ReplayDifference> {
    let new = joint_values(machine, report);
    let kinds = [
        ("position", &old.position, &new.position, ["rad", "m"]),
        ("velocity", &old.velocity, &new.velocity, ["rad/s", "m/s"]),
        ("effort", &old.effort, &new.effort, ["N m", "N"]),
    ];
    for (kind, old_values, new_values, units) in kinds {
        if old_values.len() != new_values.len() {
            let count = |values: &[f64]| format!("{} values", values.len());
            return Some(ReplayDifference::texts(report.tick, kind, count(old_values), count(new_values)));
        }
        let differs = old_values.iter().zip(new_values).position(|(old, new)| old.to_bits() != new.to_bits());
        if let Some(index) = differs {
            let joint = old.name.get(index).map_or("a joint", String::as_str);
            let is_linear = Axis::from_joint(joint).is_some_and(|axis| axis != Axis::C);
            let (field, unit) = (format!("{kind} of {joint}"), units[usize::from(is_linear)]);
            return ReplayDifference::from_numbers(report.tick, &field, old_values[index], new_values[index], unit);
        }
    }
    None
}

fn stream(old: &MachineStream, report: &TickReport, machine: &MachineDescription) -> Option<ReplayDifference> {
    let tick = report.tick;
    if [old.setpoint_counts.len(), old.actual_counts.len(), old.actual_velocities.len()] != [AXIS_COUNT; 3] {
        return Some(ReplayDifference::texts(tick, "machine/stream", "another number of axes", "three axes"));
    }
    for axis in Axis::ALL {
        let (i, own) = (axis.index(), &report.axes[axis.index()]);
        let counts = |what: &str, old: i64, new: i64| {
            ReplayDifference::from_counts(
                tick,
                &format!("{what} of {} (counts)", axis.joint()),
                old,
                new,
                size(machine, axis),
            )
        };
        let unit = if axis == Axis::C { "rad/s" } else { "m/s" };
        let speed = si_from_core(axis, own.velocity);
        let found = counts("setpoint", old.setpoint_counts[i], own.setpoint_counts)
            .or_else(|| counts("actual position", old.actual_counts[i], own.counts))
            .or_else(|| {
                let field = format!("measured velocity of {}", axis.joint());
                ReplayDifference::from_numbers(tick, &field, old.actual_velocities[i], speed, unit)
            });
        if found.is_some() {
            return found;
        }
    }
    // Those of ticks between two messages are in the digests.
    let of_tick = old.latches.iter().filter(|latch| latch.tick == tick);
    let new: Vec<_> = report.latches.iter().filter(|l| l.tick == tick).map(|l| latch_message(l, machine)).collect();
    let old: Vec<_> = of_tick.cloned().collect();
    (!old.is_empty() && old != new)
        .then(|| ReplayDifference::texts(tick, "latches", format!("{old:?}"), format!("{new:?}")))
}

/// Motion state and alarms in the stream.
fn states(old: &MachineStream, ticked: &TickOutput) -> Option<ReplayDifference> {
    let (tick, motion) = (ticked.report.tick, motion_number(ticked.report.motion));
    let counts = ReplayDifference::from_counts(tick, "motion", old.motion.into(), motion.into(), None);
    counts.or_else(|| {
        let new = ticked.alarms.numbers();
        let differs = old.alarms != new;
        differs.then(|| ReplayDifference::texts(tick, "active alarms", format!("{:?}", old.alarms), format!("{new:?}")))
    })
}

fn alarms(old: &MachineAlarms, ticked: &TickOutput, clock: TickClock) -> Option<ReplayDifference> {
    let new = ticked.alarms.messages(clock);
    let text = |alarm: Option<&Alarm>| {
        alarm.map_or_else(|| "none".to_owned(), |a| format!("alarm {} of tick {}: {}", a.number, a.tick, a.text))
    };
    let count = old.alarms.len().max(new.len());
    let differs = (0..count).find(|place| old.alarms.get(*place) != new.get(*place))?;
    let (old, new) = (text(old.alarms.get(differs)), text(new.get(differs)));
    Some(ReplayDifference::texts(ticked.report.tick, "machine/alarms", old, new))
}

fn io(old: &MachineIo, report: &TickReport, machine: &MachineDescription) -> Option<ReplayDifference> {
    let new = io_message(&report.io, machine);
    let old = MachineIo { stamp: new.stamp.clone(), tick: new.tick, ..old.clone() };
    (old != new).then(|| ReplayDifference::texts(report.tick, "machine/io", format!("{old:?}"), format!("{new:?}")))
}

fn gauge(old: &GaugeReading, report: &TickReport, machine: &MachineDescription) -> Option<ReplayDifference> {
    let mut all = readings(machine, report);
    let Some(new) = all.find(|new| new.gauge_angle.to_bits() == old.gauge_angle.to_bits()) else {
        return Some(ReplayDifference::texts(report.tick, "machine/gauge", "a reading", "none"));
    };
    let number =
        |field: &str, old: f64, new: f64, unit| ReplayDifference::from_numbers(report.tick, field, old, new, unit);
    number("reading of the gauge", old.reading, new.reading, "m")
        .or_else(|| number("spindle angle of the gauge's reading", old.spindle_angle, new.spindle_angle, "rad"))
        .or_else(|| number("wheel position of the gauge's reading", old.wheel_position, new.wheel_position, "m"))
        .or_else(|| number("wheel force of the gauge's reading", old.wheel_force, new.wheel_force, "N"))
}
