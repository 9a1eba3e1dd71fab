// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Table of interoperability: checks, peers and results. A run measures the columns of its peers and keeps the others as committed.

use crate::support::RosDistribution;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

/// Peer of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Column {
    /// rclpy of ROS 2 Jazzy on Fast DDS.
    Jazzy,
    /// rclpy of ROS 2 Kilted on Fast DDS; measured by a run of its own.
    Kilted,
    /// Peer on Cyclone DDS that reproduces `rmw_cyclonedds_cpp`.
    Cyclone,
}

impl Column {
    /// Columns in the order of the table.
    const ALL: [Column; 3] = [Column::Jazzy, Column::Kilted, Column::Cyclone];

    /// Returns true for a peer on Cyclone DDS.
    pub fn is_cyclone(self) -> bool {
        self == Column::Cyclone
    }

    /// Returns true for a column that a run with peers of a distribution measures.
    fn belongs_to(self, distribution: RosDistribution) -> bool {
        (self == Column::Kilted) == (distribution == RosDistribution::Kilted)
    }
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
            "feedback of a joint trajectory, by the definition of the distribution",
            "a goal for a busy axis is rejected with its holder",
            "each node restarted: a running peer finds it again",
            "Ctrl-C: exit 0, gone from the graph",
            "two cells side by side",
        ],
    ),
];

const RCLPY: &[Column] = &[Column::Jazzy, Column::Kilted];

/// Known failures with their reasons.
const KNOWN: &[(&str, &[Column], &str)] = &[
    (
        "type hash of an endpoint",
        RCLPY,
        "RustDDS reads `USER_DATA` of endpoints but never sends it, so `ros2 topic info -v` prints `INVALID`. Nothing else depends on it; \
         bags and `~/get_type_description` have the hashes. See `nodes/ros/UPSTREAM.md`.",
    ),
    (
        "one publisher of `/parameter_events` a node",
        RCLPY,
        "ros2-client creates a second publisher, which cannot be used or disabled. See `nodes/ros/UPSTREAM.md`.",
    ),
    (
        "server ours: the four events of a call have one client and one number",
        &[Column::Kilted],
        "A client of Jazzy names itself by the writer of its requests, a client of Kilted by the reader of its replies. Our server cannot \
         tell them apart and names every client as Jazzy does. The numbers agree.",
    ),
];

const HEAD: &str = "# Interoperability

Tests of our nodes against real ROS 2 peers, in both directions where they apply, on one host and in a DDS domain of their own.
Written by `CAMWRIGHT_INTEROP=write cargo test -p camwright_nodes --test ros interoperability`. Without the variable the same test repeats
all checks and fails if a result differs from this table.

The Cyclone peer is Cyclone DDS 11.0.1 with the names, types and service headers of `rmw_cyclonedds_cpp` reproduced in
`tests/support/cyclone_peer.py`, because it has no Python package. Actions, parameters and life cycle consist of topics and services and are
not repeated with this peer (–).

The column Kilted has a command of its own, which measures no other column:
`CAMWRIGHT_ROS_DISTRIBUTION=kilted CAMWRIGHT_INTEROP=write cargo test -p camwright_nodes --test ros interoperability`. The default run and the
continuous integration keep this column as it is committed.
";

const LONG_MESSAGES: &str = "A message of 1 MB needs some seconds to a subscriber on Fast DDS (`nodes/ros/UPSTREAM.md`, line 6); \
                             messages of camwright have at most 32 kB.";

/// Beginning of the line about the column that only a run of its own measures.
const KILTED_LINE: &str = "- Kilted: ";

/// Versions of the rclpy peer of a distribution.
fn versions(distribution: RosDistribution) -> String {
    let fast_dds = match distribution {
        RosDistribution::Jazzy => "ros-fastrtps",
        RosDistribution::Kilted => "ros-fastdds",
    };
    format!("rclpy {} on Fast DDS {}", distribution.version_of("ros-rclpy"), distribution.version_of(fast_dds))
}

/// Present date, as `date` prints it.
fn today() -> String {
    let output = Command::new("date").arg("+%Y-%m-%d").output().expect("coreutils are installed");
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

/// Columns of a run that measured others, read from the document.
#[derive(Debug, Default)]
struct Kept {
    cells: BTreeMap<(String, Column), String>,
    kilted_line: Option<String>,
}

impl Kept {
    fn from_document(text: &str) -> Self {
        let mut kept = Self::default();
        for line in text.lines() {
            if line.starts_with(KILTED_LINE) {
                kept.kilted_line = Some(line.to_owned());
            }
            let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
            if let [row, results @ ..] = &cells[..]
                && results.len() == Column::ALL.len()
            {
                for (column, result) in Column::ALL.into_iter().zip(results) {
                    kept.cells.insert(((*row).to_owned(), column), (*result).to_owned());
                }
            }
        }
        kept
    }
}

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
        self.outcomes
            .iter()
            .filter_map(|((row, column), outcome)| match (outcome, known_failure(row, *column)) {
                (Err(error), None) => Some(format!("{row} ({column:?}): {error}")),
                (Ok(()), Some(_)) => Some(format!("{row} ({column:?}): works, though it is a known failure")),
                _ => None,
            })
            .chain(self.strays.iter().cloned())
            .collect()
    }

    fn cell(&self, row: &'static str, column: Column, distribution: RosDistribution, kept: &Kept) -> String {
        if !column.belongs_to(distribution) {
            // A row that is new since then has not been measured.
            return kept.cells.get(&(row.to_owned(), column)).cloned().unwrap_or_else(|| "?".to_owned());
        }
        match self.outcomes.get(&(row, column)) {
            None => "–".to_owned(),
            Some(Ok(())) => "✓".to_owned(),
            Some(Err(_)) => {
                known_failure(row, column).map_or_else(|| "✗".to_owned(), |note| format!("✗ [{}]", note + 1))
            }
        }
    }

    fn render(&self, distribution: RosDistribution, kept: &Kept, kilted_line: &str) -> String {
        let mut text = format!("{HEAD}\n- Jazzy: {}.\n{kilted_line}\n", versions(RosDistribution::Jazzy));
        let _infallible =
            write!(text, "\n{LONG_MESSAGES}\n\n| check | Jazzy | Kilted | Cyclone DDS |\n|---|:-:|:-:|:-:|\n");
        for (section, rows) in ROWS {
            let _infallible = writeln!(text, "| **{section}** | | | |");
            for row in *rows {
                let [jazzy, kilted, cyclone] = Column::ALL.map(|column| self.cell(row, column, distribution, kept));
                let _infallible = writeln!(text, "| {row} | {jazzy} | {kilted} | {cyclone} |");
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

    /// Compares the columns of a distribution with the document, or writes them.
    pub fn compare_with(&self, document: &Path, distribution: RosDistribution, write: bool) {
        let missing: Vec<_> = ROWS
            .iter()
            .flat_map(|(_, rows)| *rows)
            .filter(|row| !self.outcomes.keys().any(|(name, _)| name == *row))
            .collect();
        assert!(missing.is_empty(), "rows that nobody tried: {missing:?}");
        let stands = std::fs::read_to_string(document).unwrap_or_default();
        let kept = Kept::from_document(&stands);
        let measured = versions(RosDistribution::Kilted);
        let kilted_line = match &kept.kilted_line {
            _ if write && distribution == RosDistribution::Kilted => {
                format!("{KILTED_LINE}{measured}, measured on {}.", today())
            }
            Some(line) => line.clone(),
            None => format!("{KILTED_LINE}not measured."),
        };
        assert!(
            kilted_line.contains(&measured),
            "{}: the column Kilted is of other packages than {measured}; measure it again",
            document.display()
        );
        let found = self.render(distribution, &kept, &kilted_line);
        if write {
            std::fs::write(document, &found).expect("the document can be written");
            return;
        }
        let differ: Vec<_> = found.lines().filter(|line| !stands.lines().any(|other| other == *line)).collect();
        assert!(found == stands, "{} says something else; found:\n{}", document.display(), differ.join("\n"));
    }
}

/// Number of the known failure of a check with a peer.
fn known_failure(row: &str, column: Column) -> Option<usize> {
    KNOWN.iter().position(|(name, columns, _)| *name == row && columns.contains(&column))
}

/// A run with other peers keeps the cells and the date of a column; a row that is new to it is marked as not measured.
#[test]
fn a_run_keeps_the_columns_that_it_does_not_measure() {
    let mut kilted = Matrix::default();
    let (first, second) = (ROWS[0].1[0], ROWS[0].1[1]);
    kilted.enter(first, Column::Kilted, Err("lost".to_owned()));
    let line = format!("{KILTED_LINE}some version, measured on 2026-11-27.");
    let document = kilted.render(RosDistribution::Kilted, &Kept::default(), &line);
    assert!(document.contains(&format!("| {first} | ? | ✗ | ? |")), "{document}");

    let shorter: String =
        document.lines().filter(|line| !line.contains(second)).map(|line| format!("{line}\n")).collect();
    let kept = Kept::from_document(&shorter);
    assert_eq!(kept.kilted_line.as_deref(), Some(line.as_str()));
    let mut jazzy = Matrix::default();
    jazzy.enter(first, Column::Jazzy, Ok(()));
    let document = jazzy.render(RosDistribution::Jazzy, &kept, &line);
    assert!(document.contains(&format!("| {first} | ✓ | ✗ | – |\n| {second} | – | ? | – |")), "{document}");
    assert!(document.contains(&line), "{document}");
}
