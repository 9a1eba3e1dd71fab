// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The recorder in Python, as rosbag2 makes them, in a process of its own.

use super::account::{Found, ReportedCounts, find};
use super::load::{Load, TOPIC};
use super::recorders::{DEPTH, ResourceUse, used};
use super::support::{Domain, Guarded, LOOPBACK, PATIENCE, PeerEnv};
use camwright_bag::Bag;
use std::io::Write;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::ChildStdin;

/// The recorder in Python.
pub struct PythonRecorder {
    process: Guarded,
    stdin: ChildStdin,
    bag: PathBuf,
}

impl PythonRecorder {
    pub fn start(env: &PeerEnv, domain: &Domain, bag: &Path, load: &Load) -> Self {
        let _not_there = std::fs::remove_dir_all(bag);
        let mut command = env.python("../benchmarks/recorder_load/record.py", domain);
        command.env("CYCLONEDDS_URI", LOOPBACK);
        command.args([TOPIC, &bag.display().to_string(), load.reliability(), &DEPTH.to_string()]);
        let mut process = Guarded::start("the recorder in Python", command.process_group(0));
        let stdin = process.take_stdin();
        Self { process, stdin, bag: bag.to_owned() }
    }

    pub fn wait_ready(&mut self) {
        let line = self.process.line(PATIENCE);
        assert_eq!(line.as_deref(), Some("ready"), "the recorder meets nobody{}", self.process.complaint());
    }

    /// Has it close its bag; what it says, what is in the bag, and what it used.
    pub fn end(mut self) -> (ReportedCounts, Found, PathBuf, ResourceUse) {
        let used = used(&self.process);
        writeln!(self.stdin, "end").expect("it listens");
        let line = self.process.line(PATIENCE).expect("it says what it did");
        let report: serde_json::Value = serde_json::from_str(&line).expect("what it says is JSON");
        let number = |key: &str| report[key].as_u64().unwrap_or_else(|| panic!("no {key} in {line}"));
        let report = ReportedCounts { received: number("received"), written: number("written"), dropped: 0 };
        let name = self.bag.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let file = Bag::open(&self.bag.join(format!("{name}_0.mcap"))).expect("it is closed");
        (report, find(&file), self.bag, used)
    }
}
