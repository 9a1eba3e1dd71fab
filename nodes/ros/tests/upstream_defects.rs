// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Defects of `RustDDS` have the state that `UPSTREAM.md` claims. A test that fails here after an update of `RustDDS` is good news: the
//! defect is mended, and its workaround may go.

#[path = "../examples/upstream_defects/main.rs"]
mod checks;
#[allow(unreachable_pub, reason = "other tests use the file as part of a module")]
#[path = "../../../tests/support/domain.rs"]
mod domain;

use domain::Domain;
use std::collections::BTreeMap;
use std::process::{Command, Output, Stdio};
use std::sync::Mutex;

/// Names the check that a process of this test runs.
const CHECK: &str = "CAMWRIGHT_UPSTREAM_CHECK";

/// Checks and their states, from the rows "| `name` | item | state | observation |" below the heading "Checks" of `UPSTREAM.md`.
fn claimed() -> BTreeMap<&'static str, &'static str> {
    let (_, section) = include_str!("../UPSTREAM.md").split_once("\n## Checks\n").expect("a section of checks");
    let section = section.split("\n## ").next().unwrap_or_default();
    let rows = section.lines().filter_map(|line| line.strip_prefix("| `")?.split_once("` |"));
    rows.filter_map(|(name, cells)| Some((name, cells.split('|').nth(1)?.trim()))).collect()
}

/// Runs a check in a process of its own: it may end threads, and it measures memory.
fn run(name: &str) -> Output {
    let domain = Domain::reserve();
    Command::new(std::env::current_exe().expect("this program has a path"))
        .args(["--exact", "one_check", "--ignored", "--nocapture"])
        .env(CHECK, name)
        .env("ROS_DOMAIN_ID", domain.id().to_string())
        .stdin(Stdio::null())
        .output()
        .expect("this program can be started again")
}

#[test]
#[ignore = "a process of `defects_have_the_claimed_state`"]
fn one_check() {
    let name = std::env::var(CHECK).unwrap_or_else(|_| panic!("{CHECK} names no check"));
    println!();
    std::process::exit(checks::run(&name).into());
}

#[test]
fn defects_have_the_claimed_state() {
    let claimed = claimed();
    let known: Vec<&str> = checks::CHECKS.iter().map(|(name, _)| *name).collect();
    let mut listed: Vec<&str> = claimed.keys().copied().collect();
    listed.sort_by_key(|name| known.iter().position(|known| known == name));
    assert_eq!(listed, known, "UPSTREAM.md lists each check once");
    let (waiting, wrong) = (Mutex::new(claimed.into_iter()), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                loop {
                    let next = waiting.lock().expect("no panic with this lock").next();
                    let Some((name, state)) = next else { return };
                    let output = run(name);
                    let seen = match output.status.code() {
                        Some(0) => "mended",
                        Some(1) => "open",
                        _ => "no result",
                    };
                    let text = String::from_utf8_lossy(&output.stdout);
                    let verdict = text.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or_default();
                    println!("{name}: {verdict}");
                    if seen != state {
                        let failure = format!("{name}: {seen}, but UPSTREAM.md says {state}: {verdict}");
                        wrong.lock().expect("no panic with this lock").push(failure);
                    }
                }
            });
        }
    });
    let wrong = wrong.into_inner().expect("no panic with this lock");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
