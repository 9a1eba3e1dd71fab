// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Protection of a live cell: a bag holds setpoints, commands and states, which the nodes of a cell would take for those of their partners.

use camwright_ros::Node;
use std::collections::BTreeSet;
use std::time::Duration;

/// Maximum time until all nodes that run already are known.
const ACQUAINTED: Duration = Duration::from_secs(3);
/// First parts of the names of a cell's topics, below the namespace of the cell.
const GROUPS: [&str; 4] = ["machine", "axis_interpolator", "job_planner", "loader"];
/// Topics of a cell without a group.
const SINGLE: [&str; 2] = ["joint_states", "dynamic_joint_states"];
/// Topics that a node of a live cell publishes all the time.
const SIGNS_OF_LIFE: [&str; 3] = ["machine/stream", "axis_interpolator/state", "job_planner/cell_state"];

/// Topics that are not played, and the node that shows that their cell is live.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct LiveCell {
    pub(super) node: String,
    pub(super) topics: Vec<String>,
}

/// Namespace of the cell that a topic belongs to: empty for the root, `None` for other topics.
fn cell_of(topic: &str) -> Option<&str> {
    let (parent, name) = topic.rsplit_once('/')?;
    if SINGLE.contains(&name) {
        return Some(parent);
    }
    let parts: Vec<&str> = topic.split('/').collect();
    // The last one: a namespace may have the name of a group.
    let group = parts[..parts.len() - 1].iter().rposition(|part| GROUPS.contains(part))?;
    Some(&topic[..parts[..group].join("/").len()])
}

/// Looks for a live cell among the topics to be played (absolute names).
pub(super) fn find(node: &Node, topics: &[String]) -> Option<LiveCell> {
    let cells: BTreeSet<&str> = topics.iter().filter_map(|topic| cell_of(topic)).collect();
    if cells.is_empty() {
        return None;
    }
    // A node that does not answer in time is not known; the others are.
    let _all_are_known = node.wait_acquainted(ACQUAINTED);
    let known = node.discovered_topics();
    cells.into_iter().find_map(|cell| {
        let signs = SIGNS_OF_LIFE.map(|sign| format!("{cell}/{sign}"));
        let publisher =
            known.iter().filter(|topic| signs.contains(&topic.name)).flat_map(|topic| &topic.publishers).next()?;
        let is_its = |topic: &&String| cell_of(topic) == Some(cell) || *topic == "/clock";
        let topics = topics.iter().filter(is_its).cloned().collect();
        Some(LiveCell { node: node.who(&publisher.guid), topics })
    })
}

/// The first topics of a list, and the number of the others.
pub(super) fn listed(topics: &[String]) -> String {
    const SHOWN: usize = 3;
    let shown = topics.iter().take(SHOWN).cloned().collect::<Vec<_>>().join(", ");
    match topics.len().saturating_sub(SHOWN) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_belong_to_the_cell_of_their_namespace() {
        for (topic, cell) in [
            ("/machine/setpoints", Some("")),
            ("/left/machine/setpoints", Some("/left")),
            ("/line/2/axis_interpolator/joint_trajectory", Some("/line/2")),
            ("/machine/machine/stream", Some("/machine")),
            ("/joint_states", Some("")),
            ("/left/joint_states", Some("/left")),
            ("/old/joint_states", Some("/old")),
            ("/clock", None),
            ("/rosout", None),
            ("/machine", None),
            ("/camera/image", None),
        ] {
            assert_eq!(cell_of(topic), cell, "{topic}");
        }
    }

    #[test]
    fn a_long_list_is_shortened() {
        let topics: Vec<String> = (1..=5).map(|number| format!("/t{number}")).collect();
        assert_eq!((listed(&topics[..2]).as_str(), listed(&topics).as_str()), ("/t1, /t2", "/t1, /t2, /t3 and 2 more"));
    }
}
