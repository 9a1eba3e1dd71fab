//! What the nodes have in common besides ROS: their threads, their errors, and starting by themselves.

use crate::{EXIT_FAILED, Node, RosError, Shutdown};
use camwright_threads::supervised;
use std::thread::JoinHandle;
use std::time::Duration;
use thiserror::Error;

/// Why a node could not start.
#[derive(Debug, Error)]
pub enum NodeError {
    /// ROS or DDS said no.
    #[error(transparent)]
    Ros(#[from] RosError),
    /// A file was refused.
    #[error(transparent)]
    File(Box<dyn std::error::Error + Send + Sync>),
    /// A parameter was refused.
    #[error("{0}")]
    Parameter(String),
    /// The system gave no thread.
    #[error("a thread cannot be started: {0}")]
    Thread(#[from] std::io::Error),
}

impl NodeError {
    /// Wraps the error of a file that was refused.
    pub fn file(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::File(Box::new(error))
    }
}

/// Threads of a node, joined in the order of their start.
#[derive(Debug, Default)]
pub struct Threads(Vec<JoinHandle<Option<()>>>);

impl Threads {
    /// Starts a named thread of a node, which is seen if it dies.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn spawn(&mut self, node: &Node, name: &str, body: impl FnOnce() + Send + 'static) -> std::io::Result<()> {
        self.0.push(node.supervisor().spawn(name, body)?);
        Ok(())
    }

    /// Waits for all of them.
    pub fn join(self) {
        for thread in self.0 {
            // A panic was reported; the others still have to end.
            let _panicked = thread.join();
        }
    }
}

/// How long a node may take to end after a signal, and how long a motion or a job that it ends may take of that.
pub const ENDING: Duration = Duration::from_millis(1900);
/// See [`ENDING`]; what is left is for the farewell to the graph.
pub const COMING_TO_REST: Duration = Duration::from_millis(800);
/// The same for a node whose work is on a disk that may be slow.
pub const CLOSING: Duration = Duration::from_secs(10);

/// Ends the process where a node does not end by itself.
fn end_within(name: &str, limit: Duration) {
    let name = name.to_owned();
    let watch = move || {
        std::thread::sleep(limit);
        eprintln!("{name}: it did not end within {} s and is ended now", limit.as_secs_f64());
        let died = supervised::died().then_some(i32::from(supervised::EXIT_CODE));
        let failed = Shutdown::has_failed().then_some(i32::from(EXIT_FAILED));
        std::process::exit(died.or(failed).unwrap_or(1));
    };
    if let Err(error) = std::thread::Builder::new().name("ending".into()).spawn(watch) {
        eprintln!("no thread watches the end of the node: {error}");
    }
}

/// Waits for a thread to end, but not for ever; false where it goes on.
pub fn join_within<T: Send + 'static>(thread: JoinHandle<T>, limit: Duration) -> bool {
    let (ended, wait) = std::sync::mpsc::channel();
    let waiter = std::thread::Builder::new().name("join".into()).spawn(move || {
        // A panic was reported.
        let _panicked = thread.join();
        let _nobody_waits = ended.send(());
    });
    waiter.is_ok() && wait.recv_timeout(limit).is_ok()
}

/// Nodes that configure and activate themselves.
pub mod autostart {
    use crate::{Level, Lifecycle, Node, Parameter, Transition};

    /// The parameter that says so.
    #[must_use]
    pub fn parameter() -> Parameter {
        Parameter::bool("autostart", true)
            .describe("configure and activate without being asked; false: wait for a life cycle manager")
            .read_only()
    }

    /// Configures and activates the node if its parameter says so.
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

/// The `main` of a node's binary: starts it, waits for a signal, ends it within `limit`. Exit 0 after a signal unless `stop` says otherwise, 1 if it could
/// not start, 2 if its arguments are malformed, 70 if `RustDDS` died, 101 if a thread of the node was ended by a defect.
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
        let is_help = matches!(unknown.as_str(), "-h" | "--help");
        eprintln!(
            "{name}: a ROS 2 node of camwright; usage: {name} [--ros-args -r FROM:=TO -p NAME:=VALUE --params-file FILE --log-level LEVEL]"
        );
        if is_help {
            return ExitCode::SUCCESS;
        }
        eprintln!("{name}: unknown argument {unknown:?}");
        return ExitCode::from(2);
    }
    RosLayer::install();
    crate::limit_memory();
    supervised::injected::from_environment();
    let node = Shutdown::on_signals().map_err(NodeError::from).and_then(|shutdown| Ok((start(&args)?, shutdown)));
    match node {
        Ok((node, shutdown)) => {
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
