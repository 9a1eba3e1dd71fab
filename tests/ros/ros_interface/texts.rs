// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Texts of the pages that neither the nodes nor the interface files contain.

use super::collect::{Interface, names};
use super::interface_files;
use std::collections::BTreeSet;

/// Begin of the overview.
pub(super) const HEAD: &str = "# ROS interface

Generated from the running nodes, the declared parameters and the interface files. [Types](types.md) lists the fields of `camwright_msgs`
with their units.

**Names** are relative to the namespace of the node (`__ns:=/cell_1` moves the whole cell). `~/` stands for the name of the node.
Names with a leading `/` are shared by all cells.

**QoS** is reliability, durability and depth of the history. A subscriber must not request more than the publisher offers:

| publisher | subscribe with | use |
|---|---|---|
| reliable, volatile | reliable or best effort | streams and events |
| reliable, transient local | transient local for the last messages at once; volatile for new messages only | states and results |

**Command.** Requests that change motion, zeros or state need command. A client takes it with `machine/take_command`; the lease lasts 10 s
unless `lease_s` is set. The same call renews it, `release: true` ends it. `shared: true` lets every participant of the domain command, which
the `ros2` command line needs. Without command a request is rejected, logged and reported by alarm 86. Reading, stop, hold and cancel are
open to every client.

| node | purpose | topics out / in | services | actions |
|---|---|---|---|---|
";

/// Begin of the section about the elements that all nodes share.
pub(super) const EVERY_NODE: &str = "
## Every node

Each node is a lifecycle node and has these elements in addition to its own.";

/// Purpose of a node.
pub(super) fn purpose(node: &str) -> &'static str {
    match node {
        "machine_sim" => "Simulates the machine: axes, sensors, wheel, part, alarms and the lease of command.",
        "axis_interpolator" => "Turns plans and joint trajectories into setpoints, tick by tick.",
        "job_planner" => "Plans jobs, runs them and judges the parts.",
        "run_logger" => "Records every run to a bag.",
        _ => "",
    }
}

/// Senders that a node accepts on a topic.
const SENDERS: [(&str, &str); 19] = [
    ("machine/setpoints", COMMAND),
    ("machine/commands", COMMAND),
    ("~/joint_trajectory", COMMAND),
    ("~/speed_scaling_input", COMMAND),
    ("~/hold_to_run", COMMAND),
    ("loader/state", "one sender"),
    ("run_logger/status", "one sender"),
    ("job_planner/plan", "every sender"),
    ("job_planner/cell_state", "every sender"),
    ("axis_interpolator/state", "every sender"),
    ("machine/alarms", MACHINE),
    ("machine/command_holder", MACHINE),
    ("machine/counters", MACHINE),
    ("machine/description", MACHINE),
    ("machine/gauge", MACHINE),
    ("machine/part", MACHINE),
    ("machine/stream", MACHINE),
    ("machine/turned_part", MACHINE),
    ("machine/work_area", MACHINE),
];
const COMMAND: &str = "the holder of command";
const MACHINE: &str = "the machine";

pub(super) fn sender(topic: &str) -> Option<&'static str> {
    SENDERS.iter().find(|(name, _)| *name == topic).map(|(_, sender)| *sender)
}

/// Topics that only the holder of command may publish, as a log line names them.
pub(super) fn topics_that_need_command() -> impl Iterator<Item = &'static str> {
    SENDERS.iter().filter(|(_, sender)| *sender == COMMAND).map(|(name, _)| *name)
}

/// Meaning of endpoints whose type is a standard one, or stands for several endpoints.
const MEANINGS: [(&str, &str); 60] = [
    ("/clock", "Time of the machine, unless another node publishes it."),
    (
        "/diagnostics",
        "State of the node, once a second: late ticks, drives, wheel, connections, losses, rejected requests.",
    ),
    ("/parameter_events", "Changes of parameters."),
    ("/rosout", "Log of the node."),
    ("/tf", "Frames of table, part, wheelhead and wheel (m, rad)."),
    ("/tf_static", "Fixed frames of the machine (m, rad)."),
    ("dynamic_joint_states", "State of axes, wheel and part, by interface names of ros2_control (SI units)."),
    ("events/rosbag2_messages_lost", "Messages lost since the last event, by topic."),
    ("events/write_split", "The recorder has begun the next file of the bag."),
    ("joint_states", "Positions (m, rad), velocities (m/s, rad/s) and efforts (N, N m) of the axes, every tick."),
    ("machine/close_chuck", "Closes the chuck."),
    ("machine/close_door", "Closes the door."),
    ("machine/estop", "Presses (true) or releases (false) the simulated emergency stop; not a safety function."),
    ("machine/judge_part", "Counts the last machined part as good (true) or bad (false)."),
    ("machine/markers", "Markers of the machine for RViz and Foxglove (m)."),
    ("machine/open_chuck", "Opens the chuck."),
    ("machine/open_door", "Opens the door."),
    ("machine/place_part", "Simulation: places a raw part into the open chuck."),
    ("machine/reset", "Clears the alarms whose cause is gone; nothing moves."),
    ("machine/reset_shift", "Resets the part counters of the shift."),
    (
        "machine/setpoints",
        "Setpoints, one point per tick (m, rad), and a stop behind them that the next chunk replaces.",
    ),
    ("machine/take_part", "Simulation: takes the part out of the open chuck."),
    ("robot_description", "URDF of the machine."),
    ("~/change_state", "Changes the state of the lifecycle."),
    ("~/close_chuck", "Closes the chuck, if the state of the cell permits it."),
    (
        "~/controller_state",
        "Reference, feedback and error of the joints (m, rad), as from the joint trajectory controller.",
    ),
    ("~/describe_parameters", "Descriptions and ranges of parameters."),
    ("~/feed_hold", "Holds (true) or releases (false) the motion on its path."),
    (
        "~/follow_joint_trajectory",
        "Follows a trajectory (m, rad) within its tolerances, as the joint trajectory controller does.",
    ),
    ("~/get_available_states", "States of the lifecycle."),
    ("~/get_available_transitions", "Transitions from the present state."),
    ("~/get_logger_levels", "Levels of the loggers."),
    ("~/get_parameter_types", "Types of parameters."),
    ("~/get_parameters", "Values of parameters."),
    ("~/get_state", "Present state of the lifecycle."),
    ("~/get_transition_graph", "All transitions of the lifecycle."),
    ("~/get_type_description", "Definition of a type by name and hash."),
    ("~/hold_to_run", "Keeps a jog without distance moving; at least twice a second."),
    ("~/is_discovery_running", "Returns whether the recorder subscribes to new topics."),
    ("~/is_paused", "Returns whether the recorder is paused."),
    ("~/joint_trajectory", "Trajectory to follow (m, rad), without an answer; a rejection is logged."),
    ("~/list_parameters", "Names of parameters."),
    ("~/markers", "Markers of design and form error for RViz and Foxglove (m)."),
    ("~/open_chuck", "Opens the chuck, if the state of the cell permits it."),
    ("~/pause", "Pauses the recording."),
    ("~/query_state", "Setpoints at a time of the trajectory in execution (m, rad)."),
    ("~/record", "Opens a bag in `uri`, or as `bag_dir` says, and begins to record."),
    ("~/resume", "Resumes the recording."),
    ("~/set_logger_levels", "Sets the levels of loggers."),
    ("~/set_parameters", "Sets parameters one by one."),
    ("~/set_parameters_atomically", "Sets all parameters or none."),
    ("~/snapshot", "Writes the messages held in memory (parameter `snapshot_s`)."),
    ("~/speed_scaling_input", "Factor on the speed of the path (0 to 1)."),
    ("~/split_bagfile", "Begins the next file of the bag."),
    ("~/start_discovery", "Subscribes to new topics again."),
    ("~/stop", "Stops the job: the wheel retracts, the axes come to rest."),
    ("~/stop (rosbag2_interfaces/srv/Stop)", "Ends the recording and closes the bag."),
    ("~/stop_discovery", "Records the present topics only."),
    ("~/transition_event", "Changes of the lifecycle."),
    ("~/wheel", "Starts (true) or stops (false) the wheel."),
];

/// Meaning of a topic, service or action; an entry may name its type behind the name.
pub(super) fn meaning(name: &str, type_name: &str) -> Option<String> {
    let typed = format!("{name} ({type_name})");
    let find = |wanted: &str| MEANINGS.iter().find(|(known, _)| *known == wanted).map(|(_, text)| (*text).to_owned());
    let own = find(&typed).or_else(|| find(name));
    own.or_else(|| interface_files::meaning(type_name))
}

/// Checks that every endpoint has a text and every text an endpoint.
pub(super) fn assert_complete(interfaces: &[Interface]) {
    let names = names(interfaces);
    let missing: Vec<_> = names.iter().filter(|(name, type_name)| meaning(name, type_name).is_none()).collect();
    assert!(missing.is_empty(), "add the meaning of {missing:#?}");
    let gone: Vec<_> = MEANINGS
        .iter()
        .map(|(name, _)| name.split(" (").next().unwrap_or(name))
        .filter(|name| !names.contains_key(*name))
        .collect();
    assert!(gone.is_empty(), "no node has {gone:?}");
    let subscribed = interfaces.iter().flat_map(|interface| &interface.subscribed);
    let subscribed: BTreeSet<&str> = subscribed.map(|topic| topic.name.as_str()).collect();
    let known: BTreeSet<&str> = SENDERS.iter().map(|(name, _)| *name).collect();
    assert_eq!(subscribed, known, "subscribed topics, and those whose senders are known");
    let undescribed = interfaces.iter().flat_map(|interface| {
        let without = interface.parameters.iter().filter(|parameter| parameter.description().is_empty());
        without.map(|parameter| format!("{}: {}", interface.node, parameter.name()))
    });
    assert_eq!(undescribed.collect::<Vec<_>>(), Vec::<String>::new(), "parameters without a description");
}
