//! What the page listens to.

use super::feed::Feed;
use super::known::{Heard, Known};
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

pub(super) fn subscribe(node: &Node, feed: &Arc<Feed>) -> Result<Vec<Subscription>, RosError> {
    // The newest is enough of what is published again and again.
    let newest = Qos::default_topic().keep_last(1);
    let latched = Qos::latched(1);
    Ok(vec![
        hear::<MachineDescription>(node, feed, "machine/description", &latched, |known, said| {
            known.machine = Some(said);
        })?,
        hear(node, feed, "machine/stream", &newest, |known, said| known.stream = heard(said))?,
        hear(node, feed, "machine/io", &newest, |known, said| known.io = Some(said))?,
        hear(node, feed, "dynamic_joint_states", &newest, |known, said| known.axes = Some(said))?,
        hear::<MachineAlarms>(node, feed, "machine/alarms", &latched, |known, said| {
            known.machine_alarms = said.alarms;
        })?,
        hear::<MachineAlarms>(node, feed, "axis_interpolator/alarms", &latched, |known, said| {
            known.interpolator_alarms = said.alarms;
        })?,
        hear(node, feed, "machine/command_holder", &latched, |known, said| known.lease = Some(said))?,
        hear::<InterpolatorState>(node, feed, "axis_interpolator/state", &newest, Known::take_interpolator)?,
        hear(node, feed, "job_planner/job_status", &latched, |known, said| known.job = Some(said))?,
        hear::<PlanPage>(node, feed, "job_planner/plan", &Qos::latched(PAGES), Known::take_page)?,
        hear::<LobeForm>(node, feed, "job_planner/lobe_forms", &Qos::latched(FORMS), Known::take_form)?,
        hear::<PartLobe>(node, feed, "machine/outline", &latched, Known::take_outline)?,
        hear(node, feed, "run_logger/status", &newest, |known, said| known.recorder = heard(said))?,
    ])
}

fn heard<T>(said: T) -> Option<Heard<T>> {
    Some(Heard { said, at: Instant::now() })
}

fn hear<M: Message>(
    node: &Node,
    feed: &Arc<Feed>,
    topic: &str,
    qos: &Qos,
    take: impl Fn(&mut Known, M) + Send + 'static,
) -> Result<Subscription, RosError> {
    let feed = Arc::clone(feed);
    node.subscribe::<M>(topic, qos, move |said, _| feed.hear(|known| take(known, said)))
}
