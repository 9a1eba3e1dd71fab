// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Services that answer from the planning thread.

use super::{Shared, lock};
use camwright_msgs::Service;
use camwright_ros::{Responder, RosError, ServiceHandle};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Calls of one service that may wait for the planning thread.
const MAX_WAITING_CALLS: usize = 32;
/// Longest time that a call waits for its turn.
const MAX_WAIT: Duration = Duration::from_millis(800);

/// A service that answers from the planning thread. A call that waits too long for its turn is refused.
pub(super) fn deferred<S: Service>(
    shared: &Arc<Shared>,
    name: &str,
    answer: fn(&Shared, &S::Request) -> S::Response,
    refusal: fn(String) -> S::Response,
) -> Result<ServiceHandle, RosError> {
    let this = Arc::clone(shared);
    let waiting = Arc::new(AtomicUsize::new(0));
    shared.node.service_deferred::<S>(name, move |request, responder: Responder<S>| {
        let responder = responder.or_fail(refusal);
        if waiting.load(Ordering::Acquire) >= MAX_WAITING_CALLS {
            return responder
                .refuse(&refusal(format!("busy: {MAX_WAITING_CALLS} calls wait already; try again later")));
        }
        waiting.fetch_add(1, Ordering::AcqRel);
        let place = Arc::new(Mutex::new(Some((request, responder))));
        let (shared, turn, left) = (Arc::clone(&this), Arc::clone(&place), Arc::clone(&waiting));
        let is_ordered = this.order(move || {
            let call = lock(&turn).take();
            if let Some((request, responder)) = call {
                left.fetch_sub(1, Ordering::AcqRel);
                responder.send(&answer(&shared, &request));
            }
        });
        let left = Arc::clone(&waiting);
        let give_up = move |reason: &str| {
            let call = lock(&place).take();
            if let Some((_, responder)) = call {
                left.fetch_sub(1, Ordering::AcqRel);
                responder.refuse(&refusal(reason.to_owned()));
            }
        };
        if is_ordered {
            this.node.after(MAX_WAIT, move || give_up("busy: the planner works on another request; try again later"));
        } else {
            give_up("the node is ending, or its planning thread has ended");
        }
    })
}
