// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Checks for defects of `RustDDS` and ros2-client. They depend on these two crates alone.
//!
//! ```text
//! cargo run -p camwright_ros --example upstream_defects -- NAME
//! ```
//!
//! prints `PASS` (exit code 0), `FAIL: observation` while the defect exists (1), or `ERROR: reason` if the check gave no result (2). Without
//! a name it lists the names. To report a defect, copy `common.rs`, `peer.rs` and the module of the defect.

mod common;
mod peer;

mod cache_after_take;
mod data_frag_memory;
mod disposal;
mod first_acknack;
mod fragment_inline_qos;
mod info_reply;
mod interrupted_poll;
mod large_message;
mod late_subscriber;
mod nack_frag_panic;
mod one_participant;
mod participant_limit;
mod peer_addresses;
mod range_memory;
mod socket_address;

use common::{Checked, Verdict};

/// Name and function of a check.
pub(crate) type Check = (&'static str, fn() -> Checked);

pub(crate) const CHECKS: [Check; 18] = [
    ("first_acknack", first_acknack::check),
    ("participant_disposal", disposal::participant),
    ("writer_disposal", disposal::writer),
    ("fragment_inline_qos", fragment_inline_qos::check),
    ("peer_addresses", peer_addresses::check),
    ("fragment_packing", large_message::packing),
    ("fragment_repetition", large_message::repetition),
    ("one_participant", one_participant::check),
    ("cache_after_take", cache_after_take::check),
    ("interrupted_poll", interrupted_poll::check),
    ("data_frag_memory", data_frag_memory::check),
    ("heartbeat_memory", range_memory::heartbeat),
    ("gap_memory", range_memory::gap),
    ("nack_frag_panic", nack_frag_panic::check),
    ("info_reply", info_reply::check),
    ("socket_address", socket_address::check),
    ("participant_limit", participant_limit::check),
    ("late_subscriber", late_subscriber::check),
];

/// Runs a check, prints its verdict and returns the exit code.
pub(crate) fn run(name: &str) -> u8 {
    let Some((_, check)) = CHECKS.iter().find(|(known, _)| *known == name) else {
        let names: Vec<&str> = CHECKS.iter().map(|(known, _)| *known).collect();
        return report(&format!("ERROR: no check {name:?}; use one of: {}", names.join(" ")), 2);
    };
    common::record_panics();
    match check() {
        Ok(Verdict::Pass) => report("PASS", 0),
        Ok(Verdict::Fail(seen)) => report(&format!("FAIL: {seen}"), 1),
        Err(reason) => report(&format!("ERROR: {reason}"), 2),
    }
}

#[allow(clippy::print_stdout, reason = "the verdict is the output of this program")]
fn report(verdict: &str, code: u8) -> u8 {
    println!("{verdict}");
    code
}

#[allow(dead_code, reason = "the tests of this crate use the file as a module")]
fn main() {
    let name = std::env::args().nth(1).unwrap_or_default();
    // Threads of RustDDS may hang after a defect, so nothing waits for them.
    std::process::exit(run(&name).into())
}
