// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright status --watch` through a pipe.

use crate::cell::{Cell, PATIENCE};
use crate::support::{Folder, Guarded};

use camwright_msgs::camwright_msgs::srv::{InjectFault, InjectFaultRequest, SetOverride, SetOverrideRequest};
use serde_json::Value;
use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};

fn watch(cell: &Cell, runtime: &Folder, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.args(["status", "--watch"]).args(words).env("ROS_DOMAIN_ID", cell.domain().id().to_string());
    // The pipe decides about colours, not the environment of the test.
    command.env("XDG_RUNTIME_DIR", runtime.path()).env_remove("CLICOLOR_FORCE").env("TERM", "xterm");
    command
}

/// Next block of text, up to its empty line.
fn block(watch: &mut Guarded) -> String {
    let lines = std::iter::from_fn(|| watch.line(PATIENCE).filter(|line| !line.is_empty()));
    let text = lines.collect::<Vec<_>>().join("\n");
    assert!(text.starts_with("state     ") && !text.contains('\u{1b}'), "{text:?}");
    // Without the line breaks of an 80-column terminal.
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn block_with(watch: &mut Guarded, words: &str) {
    while !block(watch).contains(words) {}
}

/// Next object, without the values that change all the time.
fn object(watch: &mut Guarded) -> Value {
    let line = watch.line(PATIENCE).expect("an object");
    let mut value: Value = serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line}"));
    let fields = value.as_object_mut().expect("an object");
    for live in ["machine_time_s", "axes", "cutting"] {
        assert!(fields.remove(live).is_some(), "{live}");
    }
    value
}

fn set_override(cell: &Cell, feed_override: f64) {
    let answer =
        cell.client.call::<SetOverride>("axis_interpolator/set_override", &SetOverrideRequest { feed_override });
    assert!(answer.success, "{}", answer.message);
}

#[test]
fn watching_through_a_pipe_prints_every_change_without_colour_codes() {
    let (cell, runtime) = (Cell::start(&[]), Folder::new("status-watch"));
    let mut text = Guarded::start("status --watch", &mut watch(&cell, &runtime, &[]));
    let mut json = Guarded::start("status --watch --json", &mut watch(&cell, &runtime, &["--json"]));
    block_with(&mut text, "READY");
    let mut last = object(&mut json);
    assert_eq!(last["state"]["word"], "READY");

    set_override(&cell, 0.5);
    block_with(&mut text, "override 50 %");
    while last["override_percent"] != 50.0 {
        let next = object(&mut json);
        assert_ne!(next, last, "a line without a change");
        last = next;
    }
    let fault = InjectFaultRequest {
        fault: "drive_fault".into(),
        target: "x_axis".into(),
        active: true,
        ..InjectFaultRequest::default()
    };
    assert!(cell.client.call::<InjectFault>("machine/inject_fault", &fault).success);
    block_with(&mut text, "clear the fault at the drive, then reset");
    while last["state"]["word"] != "ALARM 42" {
        last = object(&mut json);
    }
    for mut watch in [text, json] {
        watch.interrupt();
        assert_eq!(watch.wait(PATIENCE).code(), Some(0), "{}", watch.complaint());
        assert_eq!(watch.stderr(), "");
    }

    // A reader that closes the pipe ends the watch with the next change.
    let mut command = watch(&cell, &runtime, &["--json"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("camwright starts");
    let mut first = String::new();
    BufReader::new(child.stdout.take().expect("piped")).read_line(&mut first).expect("a line");
    assert!(first.contains("ALARM 42"), "{first}");
    set_override(&cell, 0.8);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!((output.status.code(), String::from_utf8_lossy(&output.stderr).as_ref()), (Some(0), ""));
    cell.stop();
}
