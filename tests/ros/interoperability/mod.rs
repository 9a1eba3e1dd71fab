//! Real peers meet us: ROS 2 Jazzy (rclpy on Fast DDS) and a peer on Cyclone DDS. Everything that is tried is a row of the table in
//! `tests/INTEROPERABILITY.md`, which this test compares with what it found.
//!
//! `CAMWRIGHT_INTEROP=words` runs only the scenarios whose names hold one of the words; `CAMWRIGHT_INTEROP=write` writes the table anew.

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
use support::{peer_env, repository};

/// Checks that share their nodes and their peer, under a name; every check of it is a row.
type Scenario = (&'static str, Column, fn(&mut Ground<'_>));

const SCENARIOS: &[Scenario] = &[
    // The longest first.
    ("cells", Column::Rclpy, cells::four_processes),
    ("side_by_side", Column::Rclpy, cells::two_cells),
    ("cells", Column::Cyclone, cells::one_process),
    ("topics", Column::Rclpy, topics::both_ways),
    ("topics", Column::Cyclone, topics::both_ways),
    ("misfits", Column::Rclpy, topics::misfits),
    ("misfits", Column::Cyclone, topics::misfits),
    ("long", Column::Rclpy, topics::long_messages),
    ("long", Column::Cyclone, topics::long_messages),
    ("leaving", Column::Rclpy, topics::leaving),
    ("leaving", Column::Cyclone, topics::leaving),
    ("services", Column::Rclpy, services::both_ways),
    ("services", Column::Cyclone, services::both_ways),
    ("long_services", Column::Rclpy, services::long_ones),
    ("introspection", Column::Rclpy, introspection::of_services),
    ("introspection_of_actions", Column::Rclpy, introspection::of_actions),
    ("parameters", Column::Rclpy, parameters::served),
    ("dump", Column::Rclpy, parameters::dumped_and_loaded),
    ("load", Column::Rclpy, parameters::dumped_and_set),
    ("arguments", Column::Rclpy, parameters::command_lines),
    ("actions", Column::Rclpy, actions::several_goals),
    ("results", Column::Rclpy, actions::results_and_statuses),
    ("clients", Column::Rclpy, clients::of_actions),
    ("life", Column::Rclpy, life::life_cycle),
    ("clock", Column::Rclpy, life::clocks),
    ("logs", Column::Rclpy, life::logs_and_descriptions),
    ("namespaces", Column::Rclpy, life::namespaces),
];

/// Scenarios that run only where they are named: rclpy keeps ten unread replies and loses older ones, so what it counts depends on
/// how busy the computer is.
const NAMED_ONLY: &[Scenario] = &[("bursts", Column::Rclpy, actions::bursts)];

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
                while let Some((name, column, run)) = scenarios.get(next.fetch_add(1, Ordering::Relaxed)) {
                    Ground::new(env, *column, name, &matrix).walk(*run);
                }
            });
        }
    });
    let matrix = matrix.into_inner().expect("checks catch their own panics");
    let unexpected = matrix.unexpected();
    assert!(unexpected.is_empty(), "{} checks are not as they should be:\n{}", unexpected.len(), unexpected.join("\n"));
    if words.is_empty() {
        matrix.compare_with(&repository().join("tests/INTEROPERABILITY.md"), wish == "write");
    }
}
