// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Subscriptions of the page.

use super::cell_snapshot::{CellSnapshot, Received};
use super::feed::Feed;
use camwright_msgs::Message;
use camwright_msgs::camwright_msgs::msg::{
    InterpolatorState, LobeForm, MachineAlarms, MachineDescription, PartLobe, PlanPage,
};
use camwright_ros::{Durability, Node, Qos, RosError, Subscription};
use std::sync::Arc;
use std::time::Instant;

/// Designs and forms that may come at once.
const FORMS: u32 = 128;
/// Pages of a plan that may come at once.
const PAGES: u32 = 256;
/// Outlines that may come at once: the last one of a lobe must not be replaced by that of the next lobe.
const OUTLINES: u32 = 16;
/// States of axes and wheel that may come at once, of which the largest values are shown.
const STATES: u32 = 50;

/// Subscribes to everything that the page shows.
pub(super) fn subscribe(node: &Node, feed: &Arc<Feed>) -> Result<Vec<Subscription>, RosError> {
    let (newest, latched) = (newest(), Qos::latched(1));
    let states = Qos::default_topic().keep_last(STATES);
    let mut subscriptions = subscribe_to_state(node, feed, "")?;
    subscriptions.extend([
        store_from::<MachineDescription>(node, feed, "machine/description", &latched, CellSnapshot::add_machine)?,
        store_from(node, feed, "dynamic_joint_states", &states, CellSnapshot::add_axes)?,
        store_from(node, feed, "machine/command_holder", &latched, |snapshot, message| snapshot.lease = Some(message))?,
        store_from::<PlanPage>(node, feed, "job_planner/plan", &Qos::latched(PAGES), CellSnapshot::add_page)?,
        store_from::<LobeForm>(node, feed, "job_planner/lobe_forms", &Qos::latched(FORMS), CellSnapshot::add_form)?,
        store_from::<PartLobe>(node, feed, "machine/outline", &Qos::latched(OUTLINES), CellSnapshot::add_outline)?,
        store_from(node, feed, "run_logger/status", &newest, |snapshot, message| {
            snapshot.recorder = received(message);
        })?,
    ]);
    Ok(subscriptions)
}

/// Subscribes to what the state of a cell needs. The topics begin with `prefix`, the namespace of a cell and a slash, or are those of the
/// node's own namespace.
pub(super) fn subscribe_to_state(node: &Node, feed: &Arc<Feed>, prefix: &str) -> Result<Vec<Subscription>, RosError> {
    let (newest, latched) = (newest(), Qos::latched(1));
    let name = |topic: &str| format!("{prefix}{topic}");
    Ok(vec![
        store_from(node, feed, &name("machine/stream"), &newest, CellSnapshot::add_stream)?,
        store_from(node, feed, &name("machine/io"), &newest, |snapshot, message| snapshot.io = Some(message))?,
        store_from::<MachineAlarms>(node, feed, &name("machine/alarms"), &latched, |snapshot, message| {
            snapshot.machine_alarms = Some(message.alarms);
        })?,
        store_from::<MachineAlarms>(node, feed, &name("axis_interpolator/alarms"), &latched, |snapshot, message| {
            snapshot.interpolator_alarms = message.alarms;
        })?,
        store_from::<InterpolatorState>(
            node,
            feed,
            &name("axis_interpolator/state"),
            &newest,
            CellSnapshot::add_interpolator,
        )?,
        store_from(node, feed, &name("job_planner/job_status"), &latched, CellSnapshot::add_job)?,
    ])
}

/// The newest is enough of what is published again and again.
fn newest() -> Qos {
    Qos::default_topic().keep_last(1)
}

fn received<T>(message: T) -> Option<Received<T>> {
    Some(Received { message, at: Instant::now() })
}

/// Subscribes to a topic whose messages go to the snapshot.
fn store_from<M: Message>(
    node: &Node,
    feed: &Arc<Feed>,
    topic: &str,
    qos: &Qos,
    store: impl Fn(&mut CellSnapshot, M) + Send + 'static,
) -> Result<Subscription, RosError> {
    let (feed, is_latched) = (Arc::clone(feed), qos.durability == Durability::TransientLocal);
    node.subscribe::<M>(topic, qos, move |message, _| {
        feed.update(|snapshot| {
            if is_latched {
                snapshot.latched_at = Some(Instant::now());
            }
            store(snapshot, message);
        });
    })
}
