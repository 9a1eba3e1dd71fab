//! Command as a client takes it: held and renewed until it is dropped.

use crate::ros::{Client, Node, Qos, RosError, TimerHandle};
use camwright_msgs::camwright_msgs::msg::CommandHolder;
use camwright_msgs::camwright_msgs::srv::{TakeCommand, TakeCommandRequest, TakeCommandResponse};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};
use thiserror::Error;

/// How long the machine may take to answer.
const ANSWER: Duration = Duration::from_secs(10);
/// How long a release may take to be answered.
const FAREWELL: Duration = Duration::from_secs(1);
/// Time between two renewals.
const RENEWAL: Duration = Duration::from_secs(2);

/// Why command was not taken.
#[derive(Debug, Error)]
pub enum TakeError {
    /// Another holder has it, or the request is out of range.
    #[error("command is refused: {0}")]
    Refused(String),
    /// Interpolator or planner have not reported to the machine.
    #[error("axis_interpolator and job_planner have not joined the machine within {0} s; check that both run in this domain and namespace")]
    Alone(u64),
    /// ROS said no.
    #[error(transparent)]
    Ros(#[from] RosError),
}

/// How command is taken.
#[derive(Debug, Clone)]
pub struct TakeOptions {
    /// Name shown to others.
    pub holder: String,
    /// Lets every participant of the domain command.
    pub shared: bool,
    /// Waits until interpolator and planner have joined, so that they know of it.
    pub with_members: bool,
    /// How long machine and members may take to be there.
    pub patience: Duration,
}

impl TakeOptions {
    /// Command of one participant.
    #[must_use]
    pub fn new(holder: &str) -> Self {
        Self { holder: holder.to_owned(), shared: false, with_members: false, patience: Duration::from_secs(20) }
    }
}

/// Command of a cell, renewed until it is dropped. The node must spin on another thread.
#[derive(Debug)]
#[must_use = "dropping it releases command"]
pub struct Command {
    client: Client<TakeCommand>,
    request: TakeCommandRequest,
    _renewal: TimerHandle,
}

impl Command {
    /// Takes command.
    ///
    /// # Errors
    /// There is no machine, another holder has command, or the members are missing.
    pub fn take(node: &Node, options: &TakeOptions) -> Result<Self, TakeError> {
        let client = node.client::<TakeCommand>("machine/take_command")?;
        client.wait_for_service(options.patience)?;
        if options.with_members {
            wait_for_members(node, options.patience)?;
        }
        let (holder, shared) = (options.holder.clone(), options.shared);
        let request = TakeCommandRequest { holder, shared, ..TakeCommandRequest::default() };
        let TakeCommandResponse { success, message, .. } = client.call(&request, ANSWER)?;
        if !success {
            return Err(TakeError::Refused(message));
        }
        let (renewing, again) = (client.clone(), request.clone());
        let mut open: Option<i64> = None;
        let renewal = node.timer(RENEWAL, move || {
            open.take().into_iter().for_each(|number| renewing.forget(number));
            // The next one comes soon; a machine that was started again is asked like the first.
            open = renewing.call_with(&again, drop).ok();
        });
        Ok(Self { client, request, _renewal: renewal })
    }
}

impl Drop for Command {
    fn drop(&mut self) {
        // Without an answer the lease runs out by itself.
        let request = TakeCommandRequest { release: true, ..self.request.clone() };
        let _released_or_gone = self.client.call(&request, FAREWELL);
    }
}

/// Waits until interpolator and planner have joined.
fn wait_for_members(node: &Node, patience: Duration) -> Result<(), TakeError> {
    let heard: Arc<(Mutex<bool>, Condvar)> = Arc::default();
    let into = Arc::clone(&heard);
    let _subscription =
        node.subscribe::<CommandHolder>("machine/command_holder", &Qos::latched(1), move |message, _| {
            let is_whole = [message.interpolator, message.planner].iter().all(|member| *member != [0; 16]);
            *into.0.lock().unwrap_or_else(PoisonError::into_inner) = is_whole;
            into.1.notify_all();
        })?;
    let deadline = Instant::now() + patience;
    let mut is_whole = heard.0.lock().unwrap_or_else(PoisonError::into_inner);
    while !*is_whole {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(TakeError::Alone(patience.as_secs()));
        }
        is_whole = heard.1.wait_timeout(is_whole, left).unwrap_or_else(PoisonError::into_inner).0;
    }
    Ok(())
}
