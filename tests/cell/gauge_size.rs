// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Journals ground to gauge by the whole cell: a wheel that wears, an infeed that cannot reach the size, report and replay.

use crate::support;

use camwright_analysis::rerun::{Window, rerun, within};
use std::path::Path;
use std::process::{Command, Output};
use support::{Domain, Folder};

/// The job on a new wheel that wears by this ratio, with its bag.
fn run(folder: &Folder, name: &str, ratio: &str, more: &[&str]) -> (Output, std::path::PathBuf) {
    let (domain, bag) = (Domain::reserve(), folder.join(name));
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    // Every run has a machine of its own, whose wheel is new.
    command.env("XDG_STATE_HOME", folder.join(&format!("state-{name}")));
    let wear = format!("wheel.grinding_ratio={ratio}");
    command.args(["run", "journal_size", "--json", "--set-machine", &wear, "--bag"]).arg(&bag);
    (command.args(more).output().expect("camwright runs"), bag)
}

fn report(output: &Output) -> serde_json::Value {
    let complaint = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {complaint}"))
}

fn errors_um(report: &serde_json::Value) -> Vec<f64> {
    let lobes = report["lobes"].as_array().expect("lobes");
    lobes.iter().map(|lobe| lobe["form_error_max_um"].as_f64().expect("a number")).collect()
}

fn assert_replays(bag: &Path) {
    let verdict = rerun(bag).expect("the bag holds what it takes");
    assert!(verdict.is_identical(), "{}", verdict.to_text());
}

/// With the gauge both journals are within 2 µm although the wheel loses 8 µm on each; without it they are larger by all of that.
#[test]
fn a_wheel_that_wears_is_compensated_reported_and_replayed() {
    let folder = Folder::new("gauge-size");
    let (output, bag) = run(&folder, "with", "4", &[]);
    let with = errors_um(&report(&output));
    assert!(output.status.success() && with.iter().all(|um| um.abs() < 2.5), "{with:?}");
    let (output, _) = run(&folder, "without", "4", &["--set", "infeed.gauge_size=null"]);
    let without = errors_um(&report(&output));
    assert!(without[0] > 8.0 && without[1] > without[0] + 5.0, "{without:?}");
    assert_replays(&bag);
    // From a keyframe in which the gauge watches.
    let window = Window { from_tick: Some(25_000), ..Window::default() };
    let verdict = within(&bag, window).expect("it has keyframes");
    assert!(verdict.is_identical(), "{}", verdict.to_text());
    let html = std::fs::read_to_string(bag.join("report.html")).expect("a report beside the bag");
    let sizes = html.split("<section id=\"size\">").nth(1).expect("a table of sizes").split("</section>").next();
    let sizes = sizes.expect("its end");
    for words in ["J1", "J3", "40.0212", " of 48", " of 86.4"] {
        assert!(sizes.contains(words), "{words}: {sizes}");
    }
}

/// A wheel that loses more than the infeed may go beyond the size: alarm 142 with its remedy, and the journal is not called finished.
#[test]
fn an_infeed_that_does_not_reach_the_size_stops_with_its_alarm() {
    let folder = Folder::new("gauge-size-missed");
    let (output, bag) = run(&folder, "missed", "0.8", &[]);
    assert_eq!(output.status.code(), Some(3));
    let report = report(&output);
    let message = report["message"].as_str().expect("a message");
    for words in ["alarm 142", "has not read the size of 40.0212 mm", "raise infeed.gauge_size.beyond_um"] {
        assert!(message.contains(words), "{words}: {message}");
    }
    assert_replays(&bag);
}
