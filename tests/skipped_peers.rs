//! Without network a developer may skip the tests with real ROS 2 peers, and is told so; where it counts nobody may.

mod support;

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

fn asked(skip: &str, ci: Option<&str>) -> Output {
    let mut command = Command::new(std::env::current_exe().expect("a test knows its binary"));
    command
        .args(["--exact", "child_that_wants_a_peer", "--nocapture"])
        .env(ASKED, "1")
        .env("CAMWRIGHT_SKIP_PEERS", skip);
    match ci {
        Some(value) => command.env("CI", value),
        None => command.env_remove("CI"),
    };
    command.output().expect("it starts")
}

#[test]
fn a_developer_who_skips_the_peers_is_told_that_nothing_was_shown() {
    let output = asked("1", None);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("SKIPPED, NOT PASSED: CAMWRIGHT_SKIP_PEERS is set"), "{said}");
    assert!(said.contains("child_that_wants_a_peer"), "it names the test: {said}");
}

#[test]
fn ci_refuses_to_skip_the_peers() {
    for ci in ["true", "1"] {
        let output = asked("1", Some(ci));
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success(), "CI={ci} took it: {said}");
        assert!(said.contains("the tests with real ROS 2 peers are not optional there"), "{said}");
    }
}
