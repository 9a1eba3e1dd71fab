// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Frame of a node's process: `main`, start errors, threads, autostart.

use crate::{EXIT_FAILED, Node, NodeLock, RosError, Shutdown};
use camwright_threads::supervised;
use std::io::Write as _;
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use thiserror::Error;

/// Error at the start of a node.
#[derive(Debug, Error)]
pub enum NodeError {
    /// ROS or DDS failed.
    #[error(transparent)]
    Ros(#[from] RosError),
    /// A file was rejected.
    #[error(transparent)]
    File(Box<dyn std::error::Error + Send + Sync>),
    /// A parameter was rejected.
    #[error("{0}")]
    Parameter(String),
    /// The operating system refused a thread.
    #[error("a thread cannot be started: {0}")]
    Thread(#[from] std::io::Error),
}

impl NodeError {
    /// Wraps the error of a rejected file.
    pub fn file(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::File(Box::new(error))
    }
}

/// Threads of a node, joined in the order of their start.
#[derive(Debug, Default)]
pub struct Threads(Vec<JoinHandle<Option<()>>>);

impl Threads {
    /// Starts a named thread of a node under supervision.
    ///
    /// # Errors
    /// The operating system refuses a thread.
    pub fn spawn(&mut self, node: &Node, name: &str, body: impl FnOnce() + Send + 'static) -> std::io::Result<()> {
        self.0.push(node.supervisor().spawn(name, body)?);
        Ok(())
    }

    /// Waits for all threads.
    pub fn join(self) {
        for thread in self.0 {
            // A panic was reported; the others still have to end.
            let _panicked = thread.join();
        }
    }
}

/// Maximum time from a signal to the end of a node.
pub const ENDING: Duration = Duration::from_millis(1900);
/// Part of [`ENDING`] for ending a motion or a job; the remainder is for leaving the graph.
pub const COMING_TO_REST: Duration = Duration::from_millis(800);
/// Maximum time from a signal to the end of a node that writes to a slow disk.
pub const CLOSING: Duration = Duration::from_secs(10);

/// Present step of the end of the node.
static ENDING_STEP: Mutex<&str> = Mutex::new("stopping its work");

/// Names the present step of the end of a node, for the report of a node that does not end in time.
pub fn ending_step(step: &'static str) {
    *ENDING_STEP.lock().unwrap_or_else(PoisonError::into_inner) = step;
}

/// Ends the process if the node does not end in time.
fn end_within(name: &str, limit: Duration) {
    let name = name.to_owned();
    let watch = move || {
        std::thread::sleep(limit);
        let step = *ENDING_STEP.lock().unwrap_or_else(PoisonError::into_inner);
        eprintln!("{name}: it did not end within {} s and is ended now, while {step}", limit.as_secs_f64());
        let died = supervised::died().then_some(i32::from(supervised::EXIT_CODE));
        let failed = Shutdown::has_failed().then_some(i32::from(EXIT_FAILED));
        std::process::exit(died.or(failed).unwrap_or(1));
    };
    if let Err(error) = std::thread::Builder::new().name("ending".into()).spawn(watch) {
        eprintln!("no thread watches the end of the node: {error}");
    }
}

/// Waits for the end of a thread; returns false after `limit`.
pub fn join_within<T: Send + 'static>(thread: JoinHandle<T>, limit: Duration) -> bool {
    let (ended, wait) = std::sync::mpsc::channel();
    let waiter = std::thread::Builder::new().name("join".into()).spawn(move || {
        // A panic was reported.
        let _panicked = thread.join();
        // An error means that no thread waits.
        let _unsent = ended.send(());
    });
    waiter.is_ok() && wait.recv_timeout(limit).is_ok()
}

/// Nodes that configure and activate themselves.
pub mod autostart {
    use crate::{Level, Lifecycle, Node, Parameter, Transition};

    /// Parameter `autostart`.
    #[must_use]
    pub fn parameter() -> Parameter {
        Parameter::bool("autostart", true)
            .describe("configures and activates the node at its start; false: a lifecycle manager does")
            .read_only()
    }

    /// Configures and activates the node if its parameter `autostart` is true.
    pub fn begin(node: &Node, lifecycle: &Lifecycle) {
        if !node.parameters().bool("autostart") {
            return;
        }
        for transition in [Transition::Configure, Transition::Activate] {
            if let Err(error) = lifecycle.trigger(transition) {
                node.log(Level::Error, &format!("autostart: {error}"));
                return;
            }
        }
    }
}

/// Help of a node's binary.
fn help(name: &str) -> String {
    format!(
        "{name}: ROS 2 node of a camwright cell

Usage: {name} [--ros-args OPTIONS]

Options:
  -p NAME:=VALUE        Set a parameter
  --params-file FILE    Set parameters from a ROS parameter file
  -r FROM:=TO           Rename a topic, a service or an action; __ns:=/NAME
                        puts the node into a namespace, __node:=NAME renames it
  --log-level LEVEL     debug, info, warn, error or fatal

A cell has the nodes machine_sim, axis_interpolator, job_planner and, for
recording, run_logger, in any order. `camwright run JOB --attach` then runs a
job on it. `params/nodes.yaml` lists all parameters with their defaults.

Example:
  {name} --ros-args --params-file params/nodes.yaml

Exit codes: 0 ended by a signal, 1 not started, 2 wrong arguments, 70 DDS
failed in this process, 101 a thread of the program panicked
"
    )
}

/// Runs a node's binary: parses the arguments, starts the node, waits for SIGINT or SIGTERM and stops the node within `limit`.
///
/// Exit codes: 0 after a signal (or the code of `stop`), 1 if the node cannot start, 2 for malformed arguments, 70 if `RustDDS` has
/// failed, 101 after a panic in a thread of the node.
pub fn main<N, E: std::process::Termination>(
    name: &str,
    limit: Duration,
    start: impl FnOnce(&crate::RosArgs) -> Result<N, NodeError>,
    stop: impl FnOnce(N) -> E,
) -> std::process::ExitCode {
    use crate::{RosArgs, RosLayer};
    use std::process::ExitCode;

    let (args, rest) = match RosArgs::from_env() {
        Ok(parsed) => parsed,
        Err(error) => {
            eprintln!("{name}: {error}");
            return ExitCode::from(2);
        }
    };
    if let Some(unknown) = rest.first() {
        if matches!(unknown.as_str(), "-h" | "--help") {
            // A closed pipe is no reason for a panic.
            let _reader_is_gone = std::io::stdout().write_all(help(name).as_bytes());
            return ExitCode::SUCCESS;
        }
        eprintln!(
            "{name}: unknown argument {unknown:?}; arguments of ROS follow `--ros-args`. For more information, try '--help'."
        );
        return ExitCode::from(2);
    }
    RosLayer::install();
    crate::limit_memory();
    supervised::injected::from_environment();
    let node = Shutdown::on_signals().map_err(NodeError::from).and_then(|shutdown| {
        let lock = NodeLock::acquire(name, &args)?;
        Ok((start(&args)?, shutdown, lock))
    });
    match node {
        Ok((node, shutdown, _lock)) => {
            shutdown.wait();
            end_within(name, limit);
            let code = Shutdown::exit_code(stop(node).report());
            supervised::exit_code().unwrap_or(code)
        }
        Err(error) => {
            eprintln!("{name}: {error}");
            ExitCode::from(1)
        }
    }
}
