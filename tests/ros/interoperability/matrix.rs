//! The table: what was tried, with whom, and what came out.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// With whom.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Column {
    /// rclpy of ROS 2 Jazzy on Fast DDS.
    Rclpy,
    /// A peer on Cyclone DDS that writes out what `rmw_cyclonedds_cpp` sends.
    Cyclone,
}

/// Row of the scenario that runs only where it is named; its outcome depends on how busy the computer is, so it is not in the table.
pub const BURST: &str = "1,000 goals and 1,000 calls sent in one loop: each is answered";

/// Sections and their rows, in the order of the table.
const ROWS: &[(&str, &[&str])] = &[
    (
        "Topics",
        &[
            "nested message, ours to theirs",
            "text, theirs to ours",
            "latched, ours to a late joiner",
            "latched, theirs to us as late joiner",
            "1 MB, ours to theirs",
            "1 MB, theirs to ours",
            "incompatible reliability: both sides report the policy",
            "incompatible durability: both sides report the policy",
            "different type on a topic: reported, no delivery",
        ],
    ),
    (
        "Graph",
        &[
            "node names, both ways",
            "type and quality of service of an endpoint",
            "type hash of an endpoint",
            "name, topics and services of a node disappear when it ends",
            "one publisher of `/parameter_events` a node",
            "two namespaces in one domain stay separate",
            "remapped names of node, topic and service",
        ],
    ),
    (
        "Services",
        &[
            "ours, called by theirs",
            "theirs, called by us",
            "without fields, both ways",
            "replies up to 300 kB, ours to theirs",
            "requests up to 300 kB, theirs to ours and ours to theirs",
            "`~/get_type_description`",
        ],
    ),
    (
        "Service introspection",
        &[
            "no topic before it is enabled, and other values are refused",
            "server ours: metadata, contents, then nothing",
            "server ours: the four events of a call have one client and one number",
            "client ours: the four events of a call have one client and one number",
            "action server ours: events of its three services",
            "action client ours: events of its three clients",
            "no events of the services of parameters, types and loggers",
        ],
    ),
    (
        "Actions, server ours",
        &[
            "goal rejected",
            "three goals at once, each with its own feedback",
            "one cancelled, one succeeds, one aborts",
            "cancelling an ended goal is answered as such",
            "result on late and repeated requests",
            "status is latched and reports ends without a request",
            "cancelling all goals",
        ],
    ),
    ("Actions, client ours", &["accepted, feedback, result", "rejected", "cancelled", "aborted"]),
    (
        "Parameters",
        &[
            "list, types and values",
            "descriptions, ranges, read-only",
            "set, and refused with a reason",
            "set atomically: all or none",
            "`/parameter_events`",
            "output of `ros2 param dump` is accepted as a parameter file",
            "output of `ros2 param dump` is set by `ros2 param load`",
            "354 command lines have the meaning of rcl",
        ],
    ),
    (
        "Life cycle",
        &[
            "changed by id and by label",
            "illegal transitions refused",
            "`~/transition_event` with the states between",
            "states, transitions and graph listed",
        ],
    ),
    (
        "Time and logs",
        &[
            "`/clock`, theirs to ours",
            "`/clock`, ours to theirs",
            "`/rosout`, also to late joiners",
            "levels of loggers, read and set",
        ],
    ),
    (
        "The cell, four processes",
        &[
            "nodes come up active",
            "`/diagnostics` of every node",
            "a joint trajectory replaces another in motion",
            "a goal for a busy axis is rejected with its holder",
            "each node restarted: a running peer finds it again",
            "Ctrl-C: exit 0, gone from the graph",
            "two cells side by side",
        ],
    ),
];

/// Known failures with their reasons.
const KNOWN: &[(&str, Column, &str)] = &[
    (
        "type hash of an endpoint",
        Column::Rclpy,
        "RustDDS reads `USER_DATA` of endpoints but never sends it, so `ros2 topic info -v` prints `INVALID`. Nothing else depends on it; \
         bags and `~/get_type_description` have the hashes. See `nodes/ros/UPSTREAM.md`.",
    ),
    (
        "one publisher of `/parameter_events` a node",
        Column::Rclpy,
        "ros2-client creates a second publisher, which cannot be used or disabled. See `nodes/ros/UPSTREAM.md`.",
    ),
];

const HEAD: &str = "# Interoperability

Tests of our nodes against real ROS 2 peers, in both directions where they apply, on one host and in a DDS domain of their own.
Written by `CAMWRIGHT_INTEROP=write cargo test -p camwright_nodes --test ros interoperability`. Without the variable the same test repeats
all checks and fails if a result differs from this table.

rclpy is ROS 2 Jazzy on Fast DDS 2.14.5. The Cyclone peer is Cyclone DDS 11.0.1 with the names, types and service headers of
`rmw_cyclonedds_cpp` reproduced in `tests/support/cyclone_peer.py`, because it has no Python package. Actions, parameters and
life cycle consist of topics and services and are not repeated with this peer (–).

A message of 1 MB needs some seconds to a subscriber on Fast DDS (`nodes/ros/UPSTREAM.md`, line 6); messages of camwright have at most 32 kB.
";

/// Result of every check.
#[derive(Debug, Default)]
pub struct Matrix {
    outcomes: BTreeMap<(&'static str, Column), Result<(), String>>,
    strays: Vec<String>,
}

impl Matrix {
    /// Takes what came out of a check.
    pub fn enter(&mut self, row: &'static str, column: Column, outcome: Result<(), String>) {
        assert!(row == BURST || ROWS.iter().any(|(_, rows)| rows.contains(&row)), "'{row}' is no row of the table");
        let before = self.outcomes.insert((row, column), outcome);
        assert!(before.is_none(), "'{row}' is tried twice with {column:?}");
    }

    /// Takes an error that belongs to no row.
    pub fn stray(&mut self, error: String, column: Column) {
        self.strays.push(format!("{error} ({column:?})"));
    }

    /// Unexpected failures, and unexpected successes.
    pub fn unexpected(&self) -> Vec<String> {
        let known = |row: &str, column: Column| KNOWN.iter().any(|(name, with, _)| *name == row && *with == column);
        self.outcomes
            .iter()
            .filter_map(|((row, column), outcome)| match (outcome, known(row, *column)) {
                (Err(error), false) => Some(format!("{row} ({column:?}): {error}")),
                (Ok(()), true) => Some(format!("{row} ({column:?}): works, though it is known not to")),
                _ => None,
            })
            .chain(self.strays.iter().cloned())
            .collect()
    }

    fn render(&self) -> String {
        let mut text = format!("{HEAD}\n| check | rclpy, Fast DDS | Cyclone DDS |\n|---|:-:|:-:|\n");
        let mark = |row: &'static str, column: Column| match self.outcomes.get(&(row, column)) {
            None => "–".to_string(),
            Some(Ok(())) => "✓".to_string(),
            Some(Err(_)) => {
                let note = KNOWN.iter().position(|(name, with, _)| *name == row && *with == column);
                note.map_or_else(|| "✗".to_string(), |note| format!("✗ [{}]", note + 1))
            }
        };
        for (section, rows) in ROWS {
            let _infallible = writeln!(text, "| **{section}** | | |");
            for row in *rows {
                let _infallible =
                    writeln!(text, "| {row} | {} | {} |", mark(row, Column::Rclpy), mark(row, Column::Cyclone));
            }
        }
        text.push('\n');
        for (note, (_, _, reason)) in KNOWN.iter().enumerate() {
            let _infallible = writeln!(text, "[{}] {reason}\n", note + 1);
        }
        text.truncate(text.trim_end().len());
        text.push('\n');
        text
    }

    /// Compares the table with the document, or writes it.
    pub fn compare_with(&self, document: &Path, write: bool) {
        let missing: Vec<_> = ROWS
            .iter()
            .flat_map(|(_, rows)| *rows)
            .filter(|row| !self.outcomes.keys().any(|(name, _)| name == *row))
            .collect();
        assert!(missing.is_empty(), "rows that nobody tried: {missing:?}");
        let found = self.render();
        if write {
            std::fs::write(document, &found).expect("the document can be written");
        }
        let stands = std::fs::read_to_string(document).unwrap_or_default();
        let differ: Vec<_> = found.lines().filter(|line| !stands.lines().any(|other| other == *line)).collect();
        assert!(found == stands, "{} says something else; found:\n{}", document.display(), differ.join("\n"));
    }
}
