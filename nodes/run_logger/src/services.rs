// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Services of rosbag2's recorder.

use std::path::PathBuf;
use std::sync::{Arc, Weak};

use camwright_msgs::rosbag2_interfaces::srv::{
    IsDiscoveryRunning, IsDiscoveryRunningResponse, IsPaused, IsPausedResponse, Pause, PauseResponse, Record,
    RecordResponse, Resume, ResumeResponse, Snapshot, SnapshotResponse, SplitBagfile, SplitBagfileResponse,
    StartDiscovery, StartDiscoveryResponse, Stop, StopDiscovery, StopDiscoveryResponse, StopResponse,
};
use camwright_ros::running::NodeError;
use camwright_ros::{Lifecycle, Node, ServiceHandle, Transition};

use super::Shared;
use super::session::Session;

/// Return code of a request that failed or changed nothing.
const FAILED: i32 = 1;

/// Error of a request that needs a bag.
const NOT_RECORDING: &str = "the recorder is not recording; call ~/record or activate it";

pub(super) fn offer(node: &Node, shared: &Arc<Shared>, lifecycle: &Lifecycle) -> Result<Vec<ServiceHandle>, NodeError> {
    let mut services = Vec::new();
    services.extend(pauses(node, shared)?);
    services.extend(files(node, shared)?);
    services.extend(recordings(node, shared, lifecycle)?);
    services.extend(discovery(node, shared)?);
    Ok(services)
}

fn pause(shared: &Weak<Shared>, is_paused: bool) {
    if let Some(shared) = shared.upgrade() {
        shared.with_session((), |session| session.pause(is_paused));
    }
}

fn pauses(node: &Node, shared: &Arc<Shared>) -> Result<[ServiceHandle; 3], NodeError> {
    let weak = || Arc::downgrade(shared);
    let (pausing, resuming, asked) = (weak(), weak(), weak());
    Ok([
        node.service::<Pause>("~/pause", move |_| {
            pause(&pausing, true);
            PauseResponse::default()
        })?,
        node.service::<Resume>("~/resume", move |_| {
            pause(&resuming, false);
            ResumeResponse::default()
        })?,
        node.service::<IsPaused>("~/is_paused", move |_| IsPausedResponse {
            paused: asked.upgrade().is_some_and(|shared| shared.with_session(false, Session::is_paused)),
        })?,
    ])
}

/// The services that begin a new file. The writer's thread answers, once it has done what was asked.
fn files(node: &Node, shared: &Arc<Shared>) -> Result<[ServiceHandle; 2], NodeError> {
    let weak = Arc::downgrade(shared);
    let split = node.service_deferred::<SplitBagfile>("~/split_bagfile", move |_, responder| {
        let responder = responder.or_fail(|_| SplitBagfileResponse::default());
        // Where nothing is recorded there is nothing to split; rosbag2's answer has no word for it.
        let answer = move |_| responder.send(&SplitBagfileResponse::default());
        match weak.upgrade().and_then(|shared| shared.session()) {
            Some(session) => session.split(answer),
            None => answer(false),
        }
    })?;
    let weak = Arc::downgrade(shared);
    let snapshot = node.service_deferred::<Snapshot>("~/snapshot", move |_, responder| {
        let responder = responder.or_fail(|_| SnapshotResponse { success: false });
        let answer = move |success| responder.send(&SnapshotResponse { success });
        let Some(shared) = weak.upgrade() else { return answer(false) };
        if let Some(session) = shared.session() {
            return session.snapshot(answer);
        }
        shared.node.logger().warn("no snapshot: not recording");
        answer(false);
    })?;
    Ok([split, snapshot])
}

/// The services that open and close a bag: the transitions of the life cycle under rosbag2's names.
fn recordings(node: &Node, shared: &Arc<Shared>, lifecycle: &Lifecycle) -> Result<[ServiceHandle; 2], NodeError> {
    let (weak, starting) = (Arc::downgrade(shared), lifecycle.clone());
    let record = node.service_deferred::<Record>("~/record", move |request, responder| {
        let failed = |error_string| RecordResponse { return_code: FAILED, error_string };
        let responder = responder.or_fail(failed);
        let Some(shared) = weak.upgrade() else { return };
        if starting.is_active() {
            return responder.send(&failed("the recorder is recording already; call ~/stop first".into()));
        }
        shared.request_dir(Some(request.uri).filter(|uri| !uri.is_empty()).map(PathBuf::from));
        starting.trigger_with(Transition::Activate, move |outcome| {
            shared.request_dir(None);
            responder.send(&outcome.map_or_else(failed, |()| RecordResponse::default()));
        });
    })?;
    let (stopping, logger) = (lifecycle.clone(), node.logger().clone());
    let stop = node.service_deferred::<Stop>("~/stop", move |_, responder| {
        let responder = responder.or_fail(|_| StopResponse::default());
        let logger = logger.clone();
        // The answer of Jazzy's rosbag2 has no field for a reason.
        stopping.trigger_with(Transition::Deactivate, move |outcome| {
            if let Err(reason) = outcome {
                logger.warn(&format!("~/stop changes nothing: {reason}"));
            }
            responder.send(&StopResponse::default());
        });
    })?;
    Ok([record, stop])
}

/// The services that start and stop subscribing to new topics.
fn discovery(node: &Node, shared: &Arc<Shared>) -> Result<[ServiceHandle; 3], NodeError> {
    let change = |is_discovering: bool| {
        let weak = Arc::downgrade(shared);
        move || match weak.upgrade().and_then(|shared| shared.session()) {
            Some(session) if session.discover(is_discovering) => (0, String::new()),
            Some(_) if is_discovering => (FAILED, "discovery is running already".to_owned()),
            Some(_) => (FAILED, "discovery is not running".to_owned()),
            None => (FAILED, NOT_RECORDING.to_owned()),
        }
    };
    let (start, stop, asked) = (change(true), change(false), Arc::downgrade(shared));
    Ok([
        node.service::<StartDiscovery>("~/start_discovery", move |_| {
            let (return_code, error_string) = start();
            StartDiscoveryResponse { return_code, error_string }
        })?,
        node.service::<StopDiscovery>("~/stop_discovery", move |_| {
            let (return_code, error_string) = stop();
            StopDiscoveryResponse { return_code, error_string }
        })?,
        node.service::<IsDiscoveryRunning>("~/is_discovery_running", move |_| IsDiscoveryRunningResponse {
            running: asked.upgrade().is_some_and(|shared| shared.with_session(false, Session::is_discovering)),
        })?,
    ])
}
