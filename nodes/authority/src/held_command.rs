// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Command as a client takes it: held and renewed until it is dropped.

use super::lock;
use camwright_msgs::camwright_msgs::msg::CommandHolder;
use camwright_msgs::camwright_msgs::srv::{TakeCommand, TakeCommandRequest, TakeCommandResponse};
use camwright_ros::{Client, Node, Qos, RosError, TimerHandle};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};
use thiserror::Error;

/// Longest time for the machine to answer.
const ANSWER: Duration = Duration::from_secs(10);
/// Longest time for a release to be answered.
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
    #[error("{0} did not join the machine within {1} s; check that it runs in this domain and namespace")]
    Alone(&'static str, u64),
    #[error(transparent)]
    Ros(#[from] RosError),
}

#[derive(Debug, Clone)]
pub struct TakeOptions {
    /// Name shown to others.
    pub holder: String,
    /// Time after which it ends when it is not renewed any more (s); 0: 10 s.
    pub lease_s: f64,
    /// Lets every participant of the domain command.
    pub shared: bool,
    /// Waits until the axis interpolator has joined the machine, so that it knows of the lease.
    pub interpolator: bool,
    /// Waits for the job planner too.
    pub planner: bool,
    /// Longest time for machine and members to be there.
    pub patience: Duration,
}

impl TakeOptions {
    /// Command of one participant.
    #[must_use]
    pub fn new(holder: &str) -> Self {
        let patience = Duration::from_secs(20);
        let (holder, lease_s) = (holder.to_owned(), 0.0);
        Self { holder, lease_s, shared: false, interpolator: false, planner: false, patience }
    }

    /// Command of every participant of the domain.
    #[must_use]
    pub fn shared(self) -> Self {
        Self { shared: true, ..self }
    }

    /// Command of a whole cell: waits until interpolator and planner have joined.
    #[must_use]
    pub fn for_cell(self) -> Self {
        Self { interpolator: true, planner: true, ..self }
    }
}

/// Command of a cell, renewed until it is dropped. The node must spin on another thread.
#[derive(Debug)]
#[must_use = "dropping it releases command"]
pub struct HeldCommand {
    client: Client<TakeCommand>,
    request: TakeCommandRequest,
    /// Client of the renewals; none once command is given back.
    renewing: Arc<Mutex<Option<Client<TakeCommand>>>>,
    _renewal: TimerHandle,
}

impl HeldCommand {
    /// Takes command.
    ///
    /// # Errors
    /// There is no machine, another holder has command, or the members are missing.
    pub fn acquire(node: &Node, options: &TakeOptions) -> Result<Self, TakeError> {
        let client = node.client::<TakeCommand>("machine/take_command")?;
        client.wait_for_service(options.patience)?;
        wait_for_members(node, options)?;
        let TakeOptions { holder, lease_s, shared, .. } = options.clone();
        let request = TakeCommandRequest { holder, lease_s, shared, release: false };
        let TakeCommandResponse { success, message, .. } = client.call(&request, ANSWER)?;
        if !success {
            return Err(TakeError::Refused(message));
        }
        let renewing = Arc::new(Mutex::new(Some(client.clone())));
        let (renewed_by, again) = (Arc::clone(&renewing), request.clone());
        let mut open: Option<i64> = None;
        let renewal = node.timer(RENEWAL, move || {
            let client = lock(&renewed_by);
            let Some(client) = client.as_ref() else { return };
            open.take().into_iter().for_each(|number| client.forget(number));
            // The next one comes soon; a machine that was started again is asked like the first.
            open = client.call_with(&again, drop).ok();
        });
        Ok(Self { client, request, renewing, _renewal: renewal })
    }
}

impl Drop for HeldCommand {
    fn drop(&mut self) {
        // A renewal that the machine receives after the release would take command again.
        *lock(&self.renewing) = None;
        // Without an answer the lease runs out by itself.
        let request = TakeCommandRequest { release: true, ..self.request.clone() };
        let _released_or_gone = self.client.call(&request, FAREWELL);
    }
}

/// Waits until the members that are wanted have joined.
fn wait_for_members(node: &Node, options: &TakeOptions) -> Result<(), TakeError> {
    type SharedHolder = (Mutex<CommandHolder>, Condvar);
    if !options.interpolator && !options.planner {
        return Ok(());
    }
    let holder_state: Arc<SharedHolder> = Arc::default();
    let into = Arc::clone(&holder_state);
    let _subscription =
        node.subscribe::<CommandHolder>("machine/command_holder", &Qos::latched(1), move |message, _| {
            *lock(&into.0) = message;
            into.1.notify_all();
        })?;
    let missing = |holder: &CommandHolder| {
        let wanted = [
            ("axis_interpolator", options.interpolator, holder.interpolator),
            ("job_planner", options.planner, holder.planner),
        ];
        wanted.into_iter().find(|(_, is_wanted, member)| *is_wanted && *member == [0; 16]).map(|(name, ..)| name)
    };
    let deadline = Instant::now() + options.patience;
    let mut holder = lock(&holder_state.0);
    while let Some(name) = missing(&holder) {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(TakeError::Alone(name, options.patience.as_secs()));
        }
        holder = holder_state.1.wait_timeout(holder, left).unwrap_or_else(PoisonError::into_inner).0;
    }
    Ok(())
}
