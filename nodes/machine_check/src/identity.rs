// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! M1 and M9: what the machine says that it is, and the endpoints that it has.

use super::observed::Observed;
use super::report::ClauseReport;
use camwright::machine::description::{Axis, AxisScale, MachineDescription as Described};
use camwright_files::convert::machine_now::{described_machine, wheels_now};
use camwright_files::convert::si_from_core;
use camwright_msgs::camwright_msgs::msg::{AxisDescription, MachineDescription};
use camwright_ros::{Durability, EndpointInfo, Guid, Node, Reliability, TopicInfo};

/// Topic, type, whether it is latched, whether the machine publishes it.
const ENDPOINTS: &[(&str, &str, bool, bool)] = &[
    ("machine/description", "camwright_msgs/msg/MachineDescription", true, true),
    ("machine/stream", "camwright_msgs/msg/MachineStream", false, true),
    ("joint_states", "sensor_msgs/msg/JointState", false, true),
    ("machine/io", "camwright_msgs/msg/MachineIo", false, true),
    ("machine/alarms", "camwright_msgs/msg/MachineAlarms", true, true),
    ("machine/setpoints", "trajectory_msgs/msg/JointTrajectory", false, false),
    ("machine/commands", "camwright_msgs/msg/MachineCommand", false, false),
];

/// M1: the description against the machine file that it carries.
pub(super) fn judge(observed: &Observed, report: &mut ClauseReport) {
    let Some(description) = &observed.description else {
        return report.broken(1, "machine/description was not received, though other topics were");
    };
    let before = report.evidence(1);
    for hash in &observed.other_hashes {
        report.broken(1, format!("hash {hash} after {}: another machine, while this one runs", description.hash));
    }
    match described_machine(description, &[]) {
        Err(error) => report.broken(1, format!("source is no machine file: {error}")),
        Ok(source) => {
            if source.hash != description.hash {
                let (hash, own) = (&description.hash, &source.hash);
                report.broken(1, format!("hash is {hash}, that of source's canonical form is {own}"));
            }
            compare(description, &source, report);
        }
    }
    report.kept_unless_broken(
        1,
        before,
        format!("{}, hash {:.12}, as in its source", description.name, description.hash),
    );
}

fn compare(description: &MachineDescription, source: &Described, report: &mut ClauseReport) {
    for (name, declared, meant) in [
        ("cycle_time_ns", description.cycle_time_ns, source.cycle_time_ns),
        ("feedback_delay_ticks", description.feedback_delay_ticks, source.feedback_delay_ticks),
    ] {
        if declared != meant || declared == 0 {
            report.broken(1, format!("{name} is {declared}, its source has {meant}"));
        }
    }
    if (source.wheel_changer.is_some() || !description.wheels.is_empty())
        && let Err(error) = wheels_now(description, source)
    {
        report.broken(1, error);
    }
    let joints: Vec<&str> = description.axes.iter().map(|axis| axis.joint.as_str()).collect();
    let wanted = Axis::ALL.map(Axis::joint);
    if joints != wanted {
        return report.broken(1, format!("axes are {joints:?}, its source has {wanted:?}"));
    }
    for (axis, declared) in Axis::ALL.into_iter().zip(&description.axes) {
        compare_axis(axis, declared, source, report);
    }
}

fn compare_axis(axis: Axis, declared: &AxisDescription, source: &Described, report: &mut ClauseReport) {
    let own = source.axis(axis);
    let (low, high) = own.soft_limits.unwrap_or((0.0, 0.0));
    for (name, declared, meant) in [
        ("soft_min", declared.soft_min, low),
        ("soft_max", declared.soft_max, high),
        ("max_velocity", declared.max_velocity, own.limits.velocity),
        ("max_acceleration", declared.max_acceleration, own.limits.acceleration),
        ("max_jerk", declared.max_jerk, own.limits.jerk),
    ] {
        let meant = si_from_core(axis, meant);
        if (declared - meant).abs() > 1e-9 * meant.abs() {
            report.broken(1, format!("{}: {name} is {declared}, its source has {meant}", axis.joint()));
        }
    }
    // Counts for so many micrometres, or for so many turns.
    let (numerator, denominator) = (declared.counts_per_unit_numerator, declared.counts_per_unit_denominator);
    let is_same = match own.scale {
        AxisScale::Linear { counts_per_mm } => {
            i128::from(numerator) * 1000 == i128::from(denominator) * i128::from(counts_per_mm)
        }
        AxisScale::Rotary { counts_per_turn } => {
            i128::from(numerator) == i128::from(denominator) * i128::from(counts_per_turn)
        }
    };
    if !is_same || denominator <= 0 {
        report.broken(
            1,
            format!("{}: counts are {numerator}/{denominator}, its source has {:?}", axis.joint(), own.scale),
        );
    }
}

/// M9: endpoints as they were discovered.
pub(super) fn endpoints(node: &Node, report: &mut ClauseReport) {
    let topics = node.discovered_topics();
    let own = node.participant_guid().unwrap_or_default();
    let is_own = |guid: &Guid| guid[..12] == own[..12];
    let before = report.evidence(9);
    let mut seen = 0;
    for (name, kind, latched, is_published) in ENDPOINTS {
        let Ok(absolute) = node.resolve_topic(name) else { continue };
        let named: Vec<&TopicInfo> = topics.iter().filter(|topic| topic.name == absolute).collect();
        for topic in named.iter().filter(|topic| topic.type_name != *kind) {
            report.broken(9, format!("{name} is of type {}, the contract requires {kind}", topic.type_name));
        }
        let machines =
            |topic: &&TopicInfo| if *is_published { topic.publishers.clone() } else { topic.subscriptions.clone() };
        let ends = named.iter().flat_map(machines).filter(|end| !is_own(&end.guid));
        let ends: Vec<EndpointInfo> = ends.collect();
        if ends.is_empty() {
            report.broken(9, format!("no node {} {name}", if *is_published { "publishes" } else { "subscribes to" }));
        }
        // Others may listen to setpoints, as a recorder does; the machine's word comes from one.
        if *is_published && ends.len() > 1 {
            let nodes: Vec<_> = ends.iter().filter_map(|end| end.node.as_deref()).collect();
            report.broken(9, format!("{} publishers on {name}, one machine: {}", ends.len(), nodes.join(", ")));
        }
        seen += 1;
        for qos in ends.iter().map(|end| &end.qos).filter(|_| *is_published) {
            if qos.reliability != Reliability::Reliable {
                report.broken(9, format!("{name} is {:?}, the contract requires reliable", qos.reliability));
            }
            if *latched && qos.durability != Durability::TransientLocal {
                report.broken(9, format!("{name} is {:?}, the contract requires transient local", qos.durability));
            }
        }
    }
    report.kept_unless_broken(9, before, format!("{seen} topics as in the tables (depths cannot be discovered)"));
}
