// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Putting the raw part of a job into the machine.

use super::Shared;
use super::execution::{ANSWER, JobFailure};
use camwright_msgs::Service;
use camwright_msgs::camwright_msgs::srv::{LoadBarRequest, LoadLobeRequest};
use camwright_planning::{self as planning, PreparedJob};
use camwright_ros::Client;
use std::time::{Duration, Instant};

/// Maximum time for the machine to come to rest before it takes a new part.
const AT_REST: Duration = Duration::from_secs(5);
const BETWEEN_ATTEMPTS: Duration = Duration::from_millis(50);

/// Why a part was not put in.
#[derive(Debug)]
pub(super) enum LoadingFailure {
    Cancelled,
    /// The machine does not take it, or does not answer.
    Refused(String),
}

impl From<LoadingFailure> for JobFailure {
    fn from(reason: LoadingFailure) -> Self {
        match reason {
            LoadingFailure::Cancelled => Self::Cancelled("cancelled before anything moved".into()),
            LoadingFailure::Refused(reason) => Self::still(&reason),
        }
    }
}

impl Shared {
    /// Puts the raw part of a job between the centres, in the place of another.
    pub(super) fn put_in(&self, prepared: &PreparedJob, is_cancelled: &dyn Fn() -> bool) -> Result<(), LoadingFailure> {
        self.setup.forget_phase();
        self.parts.clear();
        for (index, lobe) in planning::raw_part(prepared).enumerate() {
            let request = LoadLobeRequest { clear: index == 0, lobe };
            offered(&self.load_lobe, &request, |answer| (answer.success, answer.message), is_cancelled)?;
            // The machine reports what was ground, not what was put in.
            self.parts.add(request.lobe);
        }
        Ok(())
    }

    /// Puts a bar into the chuck of a lathe, in the place of another part.
    pub(super) fn clamp(&self, bar: &LoadBarRequest, is_cancelled: &dyn Fn() -> bool) -> Result<(), LoadingFailure> {
        self.turned_parts.clear();
        offered(&self.load_bar, bar, |answer| (answer.success, answer.message), is_cancelled)
    }
}

/// Asks the machine to take something until it does, or until time is over.
fn offered<S: Service>(
    client: &Client<S>,
    request: &S::Request,
    taken: fn(S::Response) -> (bool, String),
    is_cancelled: &dyn Fn() -> bool,
) -> Result<(), LoadingFailure> {
    let end = Instant::now() + AT_REST;
    loop {
        if is_cancelled() {
            return Err(LoadingFailure::Cancelled);
        }
        let answer = client.call(request, ANSWER).map_err(|error| LoadingFailure::Refused(error.to_string()))?;
        let (is_taken, message) = taken(answer);
        if is_taken {
            return Ok(());
        }
        // The job before may just have ended: its last axis is still settling.
        if Instant::now() >= end {
            return Err(LoadingFailure::Refused(format!("the machine does not take the part: {message}")));
        }
        std::thread::sleep(BETWEEN_ATTEMPTS);
    }
}
