// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Without network a developer may skip the tests with real ROS 2 peers, without LinuxCNC those with its interpreter, and gets a message;
//! in CI no test may be skipped.

use crate::support;

use std::process::{Command, Output};

/// Marks the process that the tests below start: this test binary, asked for the first test alone.
const ASKED: &str = "CAMWRIGHT_TEST_ASKS_FOR_PEERS";

/// Does what every test with a peer does first.
#[test]
fn child_that_wants_a_peer() {
    if std::env::var_os(ASKED).is_some() {
        assert!(support::peer_env().is_none(), "there is an environment, though it was to be skipped");
    }
}

/// The same for the interpreter of LinuxCNC.
#[test]
fn child_that_wants_linuxcnc() {
    if std::env::var_os(ASKED).is_some() {
        assert!(support::LinuxCnc::find().is_none(), "it was found on an empty search path");
    }
}

fn asked(skip: &str, ci: Option<&str>) -> Output {
    child("skipped_peers::child_that_wants_a_peer", ("CAMWRIGHT_SKIP_PEERS", skip), ci)
}

fn child(test: &str, (key, value): (&str, &str), ci: Option<&str>) -> Output {
    let mut command = Command::new(std::env::current_exe().expect("a test knows its binary"));
    command.args(["--exact", test, "--nocapture"]).env(ASKED, "1").env(key, value);
    match ci {
        Some(value) => command.env("CI", value),
        None => command.env_remove("CI"),
    };
    command.output().expect("it starts")
}

#[test]
fn skipping_the_peers_is_reported_as_not_tested() {
    let output = asked("1", None);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("SKIPPED, NOT PASSED: CAMWRIGHT_SKIP_PEERS is set"), "{stderr}");
    assert!(stderr.contains("child_that_wants_a_peer"), "it names the test: {stderr}");
}

#[test]
fn ci_refuses_to_skip_the_peers() {
    for ci in ["true", "1"] {
        let output = asked("1", Some(ci));
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success(), "CI={ci} took it: {stderr}");
        assert!(stderr.contains("the tests with real ROS 2 peers are not optional there"), "{stderr}");
    }
}

#[test]
fn a_missing_linuxcnc_is_reported_as_not_tested() {
    let output = child("skipped_peers::child_that_wants_linuxcnc", ("PATH", "/nowhere"), None);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("SKIPPED, NOT PASSED: rs274 is not there"), "{stderr}");
    assert!(stderr.contains("child_that_wants_linuxcnc"), "it names the test: {stderr}");
}

#[test]
fn ci_has_linuxcnc() {
    let output = child("skipped_peers::child_that_wants_linuxcnc", ("PATH", "/nowhere"), Some("true"));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success(), "{stderr}");
    assert!(stderr.contains("the tests with LinuxCNC are not optional in CI"), "{stderr}");
}
