//! What the nodes have in common besides ROS: their threads, their errors, and starting by themselves.

use crate::config::ConfigError;
use crate::ros::RosError;
use std::thread::JoinHandle;
use thiserror::Error;

/// Why a node could not start.
#[derive(Debug, Error)]
pub enum NodeError {
    /// ROS or DDS said no.
    #[error(transparent)]
    Ros(#[from] RosError),
    /// A file was refused.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A parameter was refused.
    #[error("{0}")]
    Parameter(String),
    /// The system gave no thread.
    #[error("a thread cannot be started: {0}")]
    Thread(#[from] std::io::Error),
}

/// Threads of a node, joined in the order of their start.
#[derive(Debug, Default)]
pub struct Threads(Vec<JoinHandle<()>>);

impl Threads {
    /// Starts a named thread.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn spawn(&mut self, name: &str, body: impl FnOnce() + Send + 'static) -> std::io::Result<()> {
        self.0.push(std::thread::Builder::new().name(name.to_owned()).spawn(body)?);
        Ok(())
    }

    /// Waits for all of them.
    pub fn join(self) {
        for thread in self.0 {
            // A thread that panicked has told so; the others still have to end.
            let _panicked = thread.join();
        }
    }
}

/// Nodes that configure and activate themselves.
pub mod autostart {
    use crate::ros::{Level, Lifecycle, Node, Parameter, Transition};

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

/// The `main` of a node's binary: starts it, waits for a signal, ends it. Exit 0 after a signal unless `stop` says otherwise, 1 if it could
/// not start, 2 if its arguments are malformed.
pub fn main<N, E: std::process::Termination>(
    name: &str,
    start: impl FnOnce(&crate::ros::RosArgs) -> Result<N, NodeError>,
    stop: impl FnOnce(N) -> E,
) -> std::process::ExitCode {
    use crate::ros::{RosArgs, RosLayer, Shutdown};
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
    let node = Shutdown::on_signals().map_err(NodeError::from).and_then(|shutdown| Ok((start(&args)?, shutdown)));
    match node {
        Ok((node, shutdown)) => {
            shutdown.wait();
            stop(node).report()
        }
        Err(error) => {
            eprintln!("{name}: {error}");
            ExitCode::from(1)
        }
    }
}
