// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Checks with real peers: rclpy of a ROS 2 distribution on Fast DDS, and a peer on Cyclone DDS. Every check is a row of the table in
//! `tests/INTEROPERABILITY.md`, which this test compares with its results.
//!
//! `CAMWRIGHT_INTEROP=words` runs only the scenarios whose names hold one of the words; `CAMWRIGHT_INTEROP=write` writes the table anew.
//! `CAMWRIGHT_ROS_DISTRIBUTION=kilted` measures the column of Kilted instead of the others.

#![allow(unreachable_pub, reason = "a test binary has no outside")]

use crate::support;

mod actions;
mod cells;
mod clients;
mod ground;
mod introspection;
mod life;
mod matrix;
mod parameters;
mod services;
mod topics;

use ground::Ground;
use matrix::{Column, Matrix};
use std::sync::{Mutex, atomic::AtomicUsize, atomic::Ordering};
use support::{RosDistribution, peer_env, repository};

/// Kind of peer of a scenario.
#[derive(Debug, Clone, Copy)]
enum PeerKind {
    /// rclpy of the distribution of the run.
    Rclpy,
    /// Cyclone DDS, which belongs to the default run.
    Cyclone,
}

impl PeerKind {
    /// Column that a run measures with such a peer.
    fn column(self, distribution: RosDistribution) -> Option<Column> {
        match (self, distribution) {
            (Self::Rclpy, RosDistribution::Jazzy) => Some(Column::Jazzy),
            (Self::Rclpy, RosDistribution::Kilted) => Some(Column::Kilted),
            (Self::Cyclone, RosDistribution::Jazzy) => Some(Column::Cyclone),
            (Self::Cyclone, RosDistribution::Kilted) => None,
        }
    }
}

/// Checks that share their nodes and their peer, under a name; every check of it is a row.
type Scenario = (&'static str, PeerKind, fn(&mut Ground<'_>));

const SCENARIOS: &[Scenario] = &[
    // The longest first.
    ("cells", PeerKind::Rclpy, cells::four_processes),
    ("side_by_side", PeerKind::Rclpy, cells::two_cells),
    ("cells", PeerKind::Cyclone, cells::one_process),
    ("topics", PeerKind::Rclpy, topics::both_ways),
    ("topics", PeerKind::Cyclone, topics::both_ways),
    ("misfits", PeerKind::Rclpy, topics::misfits),
    ("misfits", PeerKind::Cyclone, topics::misfits),
    ("long", PeerKind::Rclpy, topics::long_messages),
    ("long", PeerKind::Cyclone, topics::long_messages),
    ("leaving", PeerKind::Rclpy, topics::leaving),
    ("leaving", PeerKind::Cyclone, topics::leaving),
    ("services", PeerKind::Rclpy, services::both_ways),
    ("services", PeerKind::Cyclone, services::both_ways),
    ("long_services", PeerKind::Rclpy, services::long_ones),
    ("introspection", PeerKind::Rclpy, introspection::of_services),
    ("introspection_of_actions", PeerKind::Rclpy, introspection::of_actions),
    ("parameters", PeerKind::Rclpy, parameters::served),
    ("dump", PeerKind::Rclpy, parameters::dumped_and_loaded),
    ("load", PeerKind::Rclpy, parameters::dumped_and_set),
    ("arguments", PeerKind::Rclpy, parameters::command_lines),
    ("actions", PeerKind::Rclpy, actions::several_goals),
    ("results", PeerKind::Rclpy, actions::results_and_statuses),
    ("clients", PeerKind::Rclpy, clients::of_actions),
    ("life", PeerKind::Rclpy, life::life_cycle),
    ("clock", PeerKind::Rclpy, life::clocks),
    ("logs", PeerKind::Rclpy, life::logs_and_descriptions),
    ("namespaces", PeerKind::Rclpy, life::namespaces),
];

/// Scenarios that run only where they are named: rclpy keeps ten unread replies and loses older ones, so what it counts depends on
/// how busy the computer is.
const NAMED_ONLY: &[Scenario] = &[("bursts", PeerKind::Rclpy, actions::bursts)];

/// Scenarios that run at the same time: they mostly wait.
const AT_ONCE: usize = 4;

#[test]
fn the_table_of_interoperability_is_what_is_found() {
    let Some(env) = peer_env() else { return };
    let wish = std::env::var("CAMWRIGHT_INTEROP").unwrap_or_default();
    let words: Vec<&str> = wish.split(',').filter(|word| !word.is_empty() && *word != "write").collect();
    let named = |(name, ..): &&Scenario| words.iter().any(|word| name.contains(word));
    let usual = SCENARIOS.iter().filter(|scenario| words.is_empty() || named(scenario));
    let scenarios: Vec<&Scenario> = usual.chain(NAMED_ONLY.iter().filter(named)).collect();
    let (matrix, next) = (Mutex::new(Matrix::default()), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE {
            scope.spawn(|| {
                while let Some((name, peer, run)) = scenarios.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if let Some(column) = peer.column(env.distribution) {
                        Ground::new(env, column, name, &matrix).walk(*run);
                    }
                }
            });
        }
    });
    let matrix = matrix.into_inner().expect("checks catch their own panics");
    let unexpected = matrix.unexpected();
    assert!(unexpected.is_empty(), "{} checks are not as they should be:\n{}", unexpected.len(), unexpected.join("\n"));
    if words.is_empty() {
        let document = repository().join("tests/INTEROPERABILITY.md");
        matrix.compare_with(&document, env.distribution, wish == "write");
    }
}
