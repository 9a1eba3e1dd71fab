// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Door, chuck, part sensor and counters of the machine on the graph: services that work them, and what they show.

use super::{CycleInlet, PendingRequests, pop, push};
use camwright::machine::persistent_state::{PersistentState, TravelCount};
use camwright::simulation::work_area::{LoadingRefused, WorkAreaState};
use camwright_authority::OneSender;
use camwright_files::convert::time::TickClock;
use camwright_machine_cycle::area_order::AreaOrder;
use camwright_machine_cycle::messages::Inbound;
use camwright_msgs::camwright_msgs::msg::{LoaderState, MachineCounters, PartCounters, WorkArea};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolResponse, Trigger, TriggerResponse};
use camwright_ros::{Level, Node, Publisher, Qos, RosError, ServiceHandle, Subscription, TimerHandle};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Period of the check for a silent loader.
const LOADER_WATCH: Duration = Duration::from_millis(50);

/// Requests that the cyclic thread has yet to answer.
#[derive(Debug, Clone, Default)]
pub(super) struct AreaRequests(PendingRequests<Trigger>);

impl AreaRequests {
    pub(super) fn answer(&self, order: AreaOrder, outcome: Result<(), LoadingRefused>) {
        let (success, message) = match outcome {
            Ok(()) => (true, order.done().to_owned()),
            Err(refused) => (false, format!("refused: {refused}")),
        };
        if let Some(responder) = pop(&self.0) {
            responder.send(&TriggerResponse { success, message });
        }
    }
}

/// Subscriptions and services of the machine's surroundings.
#[derive(Debug)]
pub(super) struct WorkAreaEndpoints {
    pub(super) services: Vec<ServiceHandle>,
    _loader: Option<(Subscription, TimerHandle)>,
}

/// Offers the services; those of door and chuck where the machine has some.
pub(super) fn offer(
    node: &Node,
    inlet: &CycleInlet,
    requests: &AreaRequests,
    loader_timeout: Option<Duration>,
) -> Result<WorkAreaEndpoints, RosError> {
    let mut services = vec![judge(node, inlet)?, reset_shift(node, inlet)?];
    let Some(timeout) = loader_timeout else { return Ok(WorkAreaEndpoints { services, _loader: None }) };
    for (name, order) in AreaOrder::ALL {
        let (way, waiting) = (inlet.clone(), Arc::clone(&requests.0));
        services.push(node.service_deferred::<Trigger>(name, move |_, responder| {
            push(&waiting, responder.or_fail(|message| TriggerResponse { success: false, message }));
            way.send(Inbound::Area(order));
        })?);
    }
    Ok(WorkAreaEndpoints { services, _loader: Some(watch_loader(node, inlet, timeout)?) })
}

fn judge(node: &Node, inlet: &CycleInlet) -> Result<ServiceHandle, RosError> {
    let way = inlet.clone();
    node.service::<SetBool>("machine/judge_part", move |request| {
        let success = way.send(Inbound::Judge(request.data));
        let message = if success { "" } else { "the machine's cycle does not answer" };
        SetBoolResponse { success, message: message.to_owned() }
    })
}

fn reset_shift(node: &Node, inlet: &CycleInlet) -> Result<ServiceHandle, RosError> {
    let way = inlet.clone();
    node.service::<Trigger>("machine/reset_shift", move |_| {
        let success = way.send(Inbound::ResetShift);
        let message =
            if success { "the counters of the shift begin anew" } else { "the machine's cycle does not answer" };
        TriggerResponse { success, message: message.to_owned() }
    })
}

/// The loader as it was received last.
#[derive(Debug, Default)]
struct LastContact {
    at: Option<Instant>,
    inside: bool,
    lost: bool,
}

/// Follows the position of the loader, as it reports it; a silent one counts as lost.
fn watch_loader(node: &Node, inlet: &CycleInlet, timeout: Duration) -> Result<(Subscription, TimerHandle), RosError> {
    let contact: Arc<Mutex<LastContact>> = Arc::default();
    let (of_messages, way) = (Arc::clone(&contact), inlet.clone());
    let (mut one_loader, listener) = (OneSender::new("loader/state", timeout), node.clone());
    let subscription = node.subscribe::<LoaderState>("loader/state", &Qos::default_topic(), move |message, info| {
        if !one_loader.accepts(&info.writer, &listener) {
            return;
        }
        let mut contact = of_messages.lock().unwrap_or_else(PoisonError::into_inner);
        let is_news = contact.at.is_none() || contact.inside != message.in_work_area || contact.lost;
        *contact = LastContact { at: Some(Instant::now()), inside: message.in_work_area, lost: false };
        if is_news {
            way.send(Inbound::Loader { inside: message.in_work_area, lost: false });
        }
    })?;
    let (way, logger) = (inlet.clone(), node.clone());
    let timer = node.timer(LOADER_WATCH, move || {
        let mut contact = contact.lock().unwrap_or_else(PoisonError::into_inner);
        if !contact.lost && contact.at.is_some_and(|at| at.elapsed() > timeout) {
            contact.lost = true;
            logger.log(Level::Warn, &format!("no message from the loader for {} s", timeout.as_secs_f64()));
            way.send(Inbound::Loader { inside: contact.inside, lost: true });
        }
    });
    Ok((subscription, timer))
}

/// The topic of door, chuck and sensors.
#[derive(Debug)]
pub(super) struct WorkAreaOutlet {
    publisher: Publisher<WorkArea>,
    published: Option<WorkAreaState>,
}

impl WorkAreaOutlet {
    pub(super) fn new(node: &Node) -> Result<Self, RosError> {
        Ok(Self { publisher: node.publisher("machine/work_area", &Qos::latched(1))?, published: None })
    }

    /// Publishes a changed state.
    pub(super) fn publish(&mut self, state: WorkAreaState, tick: u64, clock: TickClock) -> Result<(), RosError> {
        if self.published == Some(state) {
            return Ok(());
        }
        self.published = Some(state);
        self.publisher.publish(&WorkArea {
            stamp: clock.stamp(tick),
            tick,
            door: state.door as u8,
            chuck: state.chuck as u8,
            part_present: state.part_present,
            entered: state.entered,
            safe_to_enter: state.is_safe,
            may_move: state.hindrance.is_none(),
            message: state.hindrance.map_or("", |hindrance| hindrance.text()).to_owned(),
        })
    }
}

/// The topic of the counters.
#[derive(Debug)]
pub(super) struct CounterOutlet {
    node: Node,
    publisher: Publisher<MachineCounters>,
    published: Option<(TravelCount, TravelCount)>,
}

impl CounterOutlet {
    pub(super) fn new(node: &Node) -> Result<Self, RosError> {
        Ok(Self {
            node: node.clone(),
            publisher: node.publisher("machine/counters", &Qos::latched(1))?,
            published: None,
        })
    }

    /// Publishes a changed state.
    pub(super) fn publish(&mut self, state: &PersistentState) {
        let now = (state.life, state.shift);
        if self.published == Some(now) {
            return;
        }
        self.published = Some(now);
        let counters = |tally: TravelCount| PartCounters { total: tally.total, good: tally.good, bad: tally.bad };
        let message =
            MachineCounters { stamp: self.node.now(), life: counters(state.life), shift: counters(state.shift) };
        if let Err(error) = self.publisher.publish(&message) {
            self.node.log(Level::Error, &format!("the counters cannot be published: {error}"));
        }
    }
}
