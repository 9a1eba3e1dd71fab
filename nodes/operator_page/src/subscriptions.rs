//! Subscriptions of the page.

use super::cell_snapshot::{CellSnapshot, Received};
use super::feed::Feed;
use camwright_msgs::Message;
use camwright_msgs::camwright_msgs::msg::{
    InterpolatorState, LobeForm, MachineAlarms, MachineDescription, PartLobe, PlanPage,
};
use camwright_ros::{Node, Qos, RosError, Subscription};
use std::sync::Arc;
use std::time::Instant;

/// Designs and forms that may come at once.
const FORMS: u32 = 128;
/// Pages of a plan that may come at once.
const PAGES: u32 = 256;
/// States of axes and wheel that may come at once, of which the largest values are shown.
const STATES: u32 = 50;

pub(super) fn subscribe(node: &Node, feed: &Arc<Feed>) -> Result<Vec<Subscription>, RosError> {
    // The newest is enough of what is published again and again.
    let newest = Qos::default_topic().keep_last(1);
    let (latched, states) = (Qos::latched(1), Qos::default_topic().keep_last(STATES));
    Ok(vec![
        listen::<MachineDescription>(node, feed, "machine/description", &latched, CellSnapshot::add_machine)?,
        listen(node, feed, "machine/stream", &newest, |snapshot, message| snapshot.stream = received(message))?,
        listen(node, feed, "machine/io", &newest, |snapshot, message| snapshot.io = Some(message))?,
        listen(node, feed, "dynamic_joint_states", &states, CellSnapshot::add_axes)?,
        listen::<MachineAlarms>(node, feed, "machine/alarms", &latched, |snapshot, message| {
            snapshot.machine_alarms = message.alarms;
        })?,
        listen::<MachineAlarms>(node, feed, "axis_interpolator/alarms", &latched, |snapshot, message| {
            snapshot.interpolator_alarms = message.alarms;
        })?,
        listen(node, feed, "machine/command_holder", &latched, |snapshot, message| snapshot.lease = Some(message))?,
        listen::<InterpolatorState>(node, feed, "axis_interpolator/state", &newest, CellSnapshot::add_interpolator)?,
        listen(node, feed, "job_planner/job_status", &latched, CellSnapshot::add_job)?,
        listen::<PlanPage>(node, feed, "job_planner/plan", &Qos::latched(PAGES), CellSnapshot::add_page)?,
        listen::<LobeForm>(node, feed, "job_planner/lobe_forms", &Qos::latched(FORMS), CellSnapshot::add_form)?,
        listen::<PartLobe>(node, feed, "machine/outline", &latched, CellSnapshot::add_outline)?,
        listen(node, feed, "run_logger/status", &newest, |snapshot, message| snapshot.recorder = received(message))?,
    ])
}

fn received<T>(message: T) -> Option<Received<T>> {
    Some(Received { message, at: Instant::now() })
}

fn listen<M: Message>(
    node: &Node,
    feed: &Arc<Feed>,
    topic: &str,
    qos: &Qos,
    take: impl Fn(&mut CellSnapshot, M) + Send + 'static,
) -> Result<Subscription, RosError> {
    let feed = Arc::clone(feed);
    node.subscribe::<M>(topic, qos, move |message, _| feed.update(|snapshot| take(snapshot, message)))
}
