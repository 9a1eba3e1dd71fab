// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright fleet`: several cells in one domain or in domains of their own, one client.
//!
//! `CAMWRIGHT_CELLS=20 cargo test -p camwright_nodes --test cell fleet::every_message -- --nocapture` runs a campaign with more cells.
#![allow(clippy::print_stdout, reason = "the campaign prints what it measures")]

use crate::gateway::{MACHINE, SHORT};
use crate::support;

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};
use support::processes::{Processes, fresh_bag, in_domain};
use support::{Domain, Guarded, PATIENCE};

fn fleet(domain: &Domain, words: &[&str]) -> Command {
    let mut command = in_domain(env!("CARGO_BIN_EXE_camwright"), domain);
    command.arg("fleet").args(words);
    command
}

/// Exit code, and the JSON on standard output.
fn answer(domain: &Domain, words: &[&str]) -> (Option<i32>, Value) {
    let Output { status, stdout, stderr } =
        fleet(domain, &[words, &["--json"]].concat()).output().expect("camwright runs");
    let text = String::from_utf8_lossy(&stderr);
    let value = serde_json::from_slice(&stdout).unwrap_or_else(|error| panic!("{words:?}: {error}: {text}"));
    (status.code(), value)
}

/// State of every cell.
fn words(cells: &Value) -> Vec<(&str, &str)> {
    let cells = cells.as_array().expect("an array").iter();
    cells
        .map(|cell| (cell["cell"].as_str().expect("a name"), cell["state"]["word"].as_str().expect("a word")))
        .collect()
}

/// Waits until the states are as wanted.
fn wait_for(domain: &Domain, wanted: impl Fn(&[(&str, &str)]) -> bool) -> Value {
    let mut command = fleet(domain, &["status", "--watch", "--json"]);
    let mut watch = Guarded::start("camwright fleet status --watch", &mut command);
    let deadline = Instant::now() + PATIENCE;
    loop {
        let line = watch.line(PATIENCE).expect("the watch goes on");
        let cells: Value = serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line}"));
        if wanted(&words(&cells)) {
            watch.interrupt();
            assert_eq!(watch.wait(PATIENCE).code(), Some(0), "{}", watch.complaint());
            return cells;
        }
        assert!(Instant::now() < deadline, "{cells}");
    }
}

/// Messages of all cells, each of which must have done it.
fn messages(cells: &Value) -> Vec<&str> {
    let cells = cells.as_array().expect("an array");
    assert!(cells.iter().all(|cell| cell["done"] == true), "{cells:?}");
    cells.iter().map(|cell| cell["message"].as_str().expect("a text")).collect()
}

#[test]
fn two_cells_are_listed_started_and_stopped() {
    let domain = Domain::reserve();
    let bags = ["left", "right"].map(|name| fresh_bag(&format!("fleet-{name}")));
    let [left, mut right] = [("/left", &bags[0]), ("/right", &bags[1])]
        .map(|(namespace, bag)| Processes::start_without_command(&domain, namespace, &MACHINE, bag));
    let both = ["status", "--patience", "90", "--cell", "left", "--cell", "/right"];
    let (code, cells) = answer(&domain, &both);
    assert_eq!((code, words(&cells)), (Some(0), vec![("/left", "READY"), ("/right", "READY")]), "{cells}");
    for cell in cells.as_array().expect("an array") {
        assert!(cell["is_idle"] == true && cell["pace"] == "fast" && cell["alarms"] == Value::Array(vec![]), "{cell}");
    }

    // A job that lasts until it is stopped.
    let long = ["start", "eccentric", "--set", "wheel_radius_mm=60.0", "--set", "infeed.per_block_um=0.002"];
    let (code, started) = answer(&domain, &long);
    assert_eq!((code, messages(&started)), (Some(0), vec!["job eccentric accepted"; 2]), "{started}");
    wait_for(&domain, |words| words.iter().all(|(_, word)| *word == "CUTTING"));
    let (code, again) = answer(&domain, &long);
    assert_eq!(code, Some(3), "{again}");
    assert!(again.as_array().expect("an array").iter().all(|cell| cell["done"] == false), "{again}");

    let (code, stopped) = answer(&domain, &["stop"]);
    assert_eq!((code, messages(&stopped)), (Some(0), vec!["job cancelled, the axes come to rest"; 2]), "{stopped}");
    wait_for(&domain, |words| words.iter().all(|(_, word)| *word == "STOPPED"));
    let (code, at_rest) = answer(&domain, &["stop"]);
    assert_eq!((code, messages(&at_rest)), (Some(0), vec!["nothing to stop"; 2]), "{at_rest}");

    // One cell alone, by its name.
    let (code, one) = answer(&domain, &[&long[..], &["--cell", "/left"]].concat());
    assert_eq!((code, messages(&one).len()), (Some(0), 1), "{one}");
    wait_for(&domain, |words| words == [("/left", "CUTTING"), ("/right", "STOPPED")]);
    let (code, stopped) = answer(&domain, &["stop"]);
    let expected = vec!["job cancelled, the axes come to rest", "nothing to stop"];
    assert_eq!((code, messages(&stopped)), (Some(0), expected), "{stopped}");

    // An alarm, a cell that nobody started, and a machine that has died.
    let mut estop = in_domain(env!("CARGO_BIN_EXE_camwright"), &domain);
    let estop = estop.args(["estop", "--ros-args", "-r", "__ns:=/left"]).output().expect("camwright runs");
    assert_eq!(estop.status.code(), Some(0), "{}", String::from_utf8_lossy(&estop.stderr));
    wait_for(&domain, |words| words[0] == ("/left", "EMERGENCY STOP"));
    let (code, alarmed) = answer(&domain, &both);
    assert_eq!(code, Some(3), "{alarmed}");
    let output = fleet(&domain, &["status", "--cell", "/nowhere", "--patience", "2"]).output().expect("camwright runs");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(4) && text.contains("no cell /nowhere found within 2 s"), "{text}");
    right.kill("machine_sim");
    let (code, cells) = answer(&domain, &["status", "--patience", "5"]);
    assert_eq!(code, Some(4), "{cells}");
    assert_eq!(cells[1]["state"]["detail"], "no message from a machine in /right", "{cells}");
    left.end();
    assert_whole(&bags[0]);
    drop(right);
    for bag in bags {
        std::fs::remove_dir_all(bag).expect("the bag is ours");
    }
    let empty = fleet(&Domain::reserve(), &["status", "--patience", "1"]).output().expect("camwright runs");
    let text = String::from_utf8_lossy(&empty.stderr);
    assert!(empty.status.code() == Some(1) && text.contains("no cell found within 1 s"), "{text}");
}

/// All alarms of the cells are warnings.
fn has_only_warnings(cells: &Value) -> bool {
    let alarms =
        cells.as_array().into_iter().flatten().flat_map(|cell| cell["alarms"].as_array().into_iter().flatten());
    alarms.into_iter().all(|alarm| alarm["severity"] == "warning")
}

/// Every message of a bag was recorded.
fn assert_whole(bag: &Path) {
    let mut check = Command::new(env!("CARGO_BIN_EXE_camwright"));
    let check = check.args(["bag", "check"]).arg(bag).output().expect("camwright runs");
    assert_eq!(check.status.code(), Some(0), "{}: {}", bag.display(), String::from_utf8_lossy(&check.stdout));
}

/// Cells of four processes in a domain each run a job at once; every bag is whole, and the client sees the end of every job.
#[test]
fn every_message_of_several_cells_is_recorded() {
    let count: usize = std::env::var("CAMWRIGHT_CELLS").ok().and_then(|text| text.parse().ok()).unwrap_or(2);
    let patience = PATIENCE + Duration::from_secs(15) * u32::try_from(count).unwrap_or(u32::MAX);
    let (domains, begin): (Vec<Domain>, _) = ((0..count).map(|_| Domain::reserve()).collect(), Instant::now());
    let start = |domain: &Domain| {
        let bag = fresh_bag(&format!("fleet-domain-{}", domain.id()));
        Processes::start_without_command(domain, "/cell", &MACHINE, &bag)
    };
    let cells: Vec<Processes> = domains.iter().map(start).collect();
    let mut every = vec!["--patience".to_owned(), patience.as_secs().to_string()];
    every.extend(domains.iter().flat_map(|domain| ["--domain".to_owned(), domain.id().to_string()]));
    let every: Vec<&str> = every.iter().map(String::as_str).collect();
    let domain = &domains[0];
    let (code, found) = answer(domain, &[&["status"], &every[..]].concat());
    // A busy computer may keep a recorder behind for a while, which is a warning; the bags show whether something is lost.
    assert!(code == Some(0) || code == Some(3) && has_only_warnings(&found), "{code:?}: {found}");
    assert_eq!(words(&found), vec![("/cell", "READY"); count], "{found}");
    let mut ids: Vec<u64> = domains.iter().map(|domain| domain.id().into()).collect();
    ids.sort_unstable();
    let found_in = found.as_array().expect("an array").iter().map(|cell| cell["domain"].as_u64().expect("a number"));
    assert_eq!(found_in.collect::<Vec<_>>(), ids, "{found}");
    println!("{count} cells are ready after {:.1} s", begin.elapsed().as_secs_f64());

    let mut watch = fleet(domain, &["status", "--watch", "--json"]);
    let mut watch = Guarded::start("camwright fleet status --watch", watch.args(&every));
    let first = watch.line(patience).expect("a line");
    assert_eq!(words(&serde_json::from_str(&first).expect("JSON")).len(), count, "{first}");
    let set: Vec<&str> = SHORT.iter().flat_map(|over| ["--set", over]).collect();
    let (code, started) = answer(domain, &[&["start", "eccentric"], &set[..], &every[..]].concat());
    assert_eq!((code, messages(&started).len()), (Some(0), count), "{started}");
    println!("all have accepted the job after {:.1} s", begin.elapsed().as_secs_f64());

    let deadline = Instant::now() + patience;
    let ended = loop {
        let line = watch.line(patience).expect("the watch goes on");
        let now: Value = serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line}"));
        if words(&now).iter().all(|(_, word)| *word == "COMPLETE") {
            break now;
        }
        assert!(Instant::now() < deadline, "{now}");
    };
    println!("all have completed the job after {:.1} s", begin.elapsed().as_secs_f64());
    watch.interrupt();
    let code = watch.wait(patience).code();
    assert!(code == Some(0) || code == Some(3) && has_only_warnings(&ended), "{code:?}: {}", watch.complaint());
    let (code, at_rest) = answer(domain, &[&["stop"], &every[..]].concat());
    assert_eq!((code, messages(&at_rest)), (Some(0), vec!["nothing to stop"; count]), "{at_rest}");
    let empty = Domain::reserve();
    let (there, nowhere) = (domain.id().to_string(), empty.id().to_string());
    let both = ["status", "--domain", &there, "--domain", &nowhere, "--patience", "5"];
    let output = fleet(domain, &both).output().expect("camwright runs");
    let text = String::from_utf8_lossy(&output.stderr);
    let expected = format!("no cell found in domain {nowhere} within 5 s");
    assert!(output.status.code() == Some(4) && text.contains(&expected), "{text}");

    let bags: Vec<_> = cells.into_iter().map(Processes::end).collect();
    for bag in bags {
        assert_whole(&bag);
        std::fs::remove_dir_all(bag).expect("the bag is ours");
    }
    println!("all bags are whole after {:.1} s", begin.elapsed().as_secs_f64());
}

#[test]
fn domains_that_do_not_exist_are_refused() {
    for (text, reason) in [
        ("233", "`233` is not a domain id from 0 to 232"),
        ("3-", "`` is not a domain id from 0 to 232"),
        ("9-7", "domain 9 is after domain 7"),
        ("one", "`one` is not a domain id from 0 to 232"),
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
        let output = command.args(["fleet", "status", "--domain", text]).output().expect("camwright runs");
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && message.contains(reason), "{text}: {message}");
    }
}
