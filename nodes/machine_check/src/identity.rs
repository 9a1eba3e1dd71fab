//! M1 and M9: what the machine says that it is, and the endpoints that it has.

use super::observed::Observed;
use super::report::Report;
use camwright::machine::description::{Axis, MachineDescription as Described, Scale};
use camwright_files::convert::machine_now::described_machine;
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
pub(super) fn judge(heard: &Observed, report: &mut Report) {
    let Some(said) = &heard.description else {
        return report.broken(1, "machine/description was not heard, though other topics were");
    };
    let before = report.evidence(1);
    for hash in &heard.other_hashes {
        report.broken(1, format!("hash {hash} after {}: another machine, while this one runs", said.hash));
    }
    match described_machine(said, &[]) {
        Err(error) => report.broken(1, format!("source is no machine file: {error}")),
        Ok(source) => {
            if source.hash != said.hash {
                let (hash, own) = (&said.hash, &source.hash);
                report.broken(1, format!("hash is {hash}, that of source's canonical form is {own}"));
            }
            compare(said, &source, report);
        }
    }
    report.kept_unless_broken(1, before, format!("{}, hash {:.12}, as its source says", said.name, said.hash));
}

fn compare(said: &MachineDescription, source: &Described, report: &mut Report) {
    for (name, told, meant) in [
        ("cycle_time_ns", said.cycle_time_ns, source.cycle_time_ns),
        ("feedback_delay_ticks", said.feedback_delay_ticks, source.feedback_delay_ticks),
    ] {
        if told != meant || told == 0 {
            report.broken(1, format!("{name} is {told}, its source says {meant}"));
        }
    }
    let joints: Vec<&str> = said.axes.iter().map(|axis| axis.joint.as_str()).collect();
    let wanted = Axis::ALL.map(Axis::joint);
    if joints != wanted {
        return report.broken(1, format!("axes are {joints:?}, its source says {wanted:?}"));
    }
    for (axis, told) in Axis::ALL.into_iter().zip(&said.axes) {
        compare_axis(axis, told, source, report);
    }
}

fn compare_axis(axis: Axis, told: &AxisDescription, source: &Described, report: &mut Report) {
    let own = source.axis(axis);
    let (low, high) = own.soft_limits.unwrap_or((0.0, 0.0));
    for (name, told, meant) in [
        ("soft_min", told.soft_min, low),
        ("soft_max", told.soft_max, high),
        ("max_velocity", told.max_velocity, own.limits.velocity),
        ("max_acceleration", told.max_acceleration, own.limits.acceleration),
        ("max_jerk", told.max_jerk, own.limits.jerk),
    ] {
        let meant = si_from_core(axis, meant);
        if (told - meant).abs() > 1e-9 * meant.abs() {
            report.broken(1, format!("{}: {name} is {told}, its source says {meant}", axis.joint()));
        }
    }
    // Counts for so many micrometres, or for so many turns.
    let (numerator, denominator) = (told.counts_per_unit_numerator, told.counts_per_unit_denominator);
    let is_same = match own.scale {
        Scale::Linear { counts_per_mm } => {
            i128::from(numerator) * 1000 == i128::from(denominator) * i128::from(counts_per_mm)
        }
        Scale::Rotary { counts_per_turn } => {
            i128::from(numerator) == i128::from(denominator) * i128::from(counts_per_turn)
        }
    };
    if !is_same || denominator <= 0 {
        report.broken(
            1,
            format!("{}: counts are {numerator}/{denominator}, its source says {:?}", axis.joint(), own.scale),
        );
    }
}

/// M9: endpoints as they were discovered.
pub(super) fn endpoints(node: &Node, report: &mut Report) {
    let topics = node.discovered_topics();
    let own = node.participant_guid().unwrap_or_default();
    let is_own = |guid: &Guid| guid[..12] == own[..12];
    let before = report.evidence(9);
    let mut seen = 0;
    for (name, kind, latched, says) in ENDPOINTS {
        let Ok(absolute) = node.resolve_topic(name) else { continue };
        let named: Vec<&TopicInfo> = topics.iter().filter(|topic| topic.name == absolute).collect();
        for topic in named.iter().filter(|topic| topic.type_name != *kind) {
            report.broken(9, format!("{name} is of type {}, the contract says {kind}", topic.type_name));
        }
        let machines = |topic: &&TopicInfo| if *says { topic.publishers.clone() } else { topic.subscriptions.clone() };
        let ends = named.iter().flat_map(machines).filter(|end| !is_own(&end.guid));
        let ends: Vec<EndpointInfo> = ends.collect();
        if ends.is_empty() {
            report.broken(9, format!("nobody {} {name}", if *says { "publishes" } else { "subscribes to" }));
        }
        // Others may listen to setpoints, as a recorder does; the machine's word comes from one.
        if *says && ends.len() > 1 {
            let nodes: Vec<_> = ends.iter().filter_map(|end| end.node.as_deref()).collect();
            report.broken(9, format!("{} publishers on {name}, one machine: {}", ends.len(), nodes.join(", ")));
        }
        seen += 1;
        for qos in ends.iter().map(|end| &end.qos).filter(|_| *says) {
            if qos.reliability != Reliability::Reliable {
                report.broken(9, format!("{name} is {:?}, the contract says reliable", qos.reliability));
            }
            if *latched && qos.durability != Durability::TransientLocal {
                report.broken(9, format!("{name} is {:?}, the contract says transient local", qos.durability));
            }
        }
    }
    report.kept_unless_broken(9, before, format!("{seen} topics as in the tables (depths cannot be discovered)"));
}
