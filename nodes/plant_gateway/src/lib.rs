// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Gateway of a running cell to the plant: an MTConnect adapter, and an OPC UA server on request.
//!
//! ```text
//! topics of the cell ─► CellMessages ─► items ─► changes (SHDR) ─► ReadingFeed ─► Outbox of each client ─► agent
//!                                         ├────► devices (XML)
//!                                         └────► ua: nodes ─► UaFeed ─► OPC UA server ─► clients
//! ```
//!
//! Read-only: it subscribes to public topics. The adapter accepts nothing but PING, the server no write and no method of the machine. Values
//! and text are computed without clock, socket or ROS.

mod cell_messages;
pub mod devices;
mod feed;
mod items;
mod outbox;
pub mod reference;
mod server;
mod shdr;
mod ua;

use camwright_files::convert::machine_now::described_machine;
use camwright_msgs::Message;
use camwright_msgs::camwright_msgs::msg::{InterpolatorState, MachineDescription, MachineStream};
use camwright_ros::liveness::LimitedWarning;
use camwright_ros::running::NodeError;
use camwright_ros::{Node, NodeOptions, Qos, Reliability, RosArgs, RosError, SpinThread, Subscription, TimerHandle};
use camwright_threads::silence::{LOOK, Silence};
use camwright_threads::supervised::Supervisor;
use camwright_threads::system_time::system_time_ns;
use cell_messages::{CellMessages, Equipment};
use feed::ReadingFeed;
use items::read_all;
use server::AdapterServer;
pub use server::ClientCounts;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
pub use ua::{Nameplate, UaOptions};
use ua::{UaFeed, UaServer};

/// Default address of the adapter: this computer only. The port is the default of the agent.
pub const DEFAULT_ADDRESS: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 7878);

/// A node without a message for this time counts as lost.
const SILENCE: Duration = Duration::from_secs(3);
/// Messages of events that may come at once, each of which is a change for the agent.
const EVENTS: u32 = 500;

/// Silences of the nodes of a cell.
#[derive(Debug)]
struct Silences {
    machine: Silence,
    interpolator: Silence,
    planner: Silence,
}

/// Messages of the cell, and where their values go.
#[derive(Debug)]
struct Adapter {
    cell: CellMessages,
    silences: Silences,
    feed: Arc<ReadingFeed>,
    /// Feed of the OPC UA server, if there is one.
    ua: Option<UaFeed>,
}

impl Adapter {
    fn new(feed: Arc<ReadingFeed>, ua: Option<UaFeed>) -> Self {
        let [machine, interpolator, planner] = [Silence::new(SILENCE); 3];
        Self { cell: CellMessages::default(), silences: Silences { machine, interpolator, planner }, feed, ua }
    }

    /// Sends events and conditions that have changed, samples only with `with_samples`.
    fn publish(&self, with_samples: bool) {
        let time_ns = system_time_ns();
        self.feed.publish(read_all(&self.cell), with_samples, time_ns);
        if let Some(ua) = &self.ua {
            ua.publish(&self.cell, with_samples, time_ns);
        }
    }

    /// Marks silent nodes as lost, and sends everything that has changed.
    fn look(&mut self) {
        let Silences { machine, interpolator, planner } = &mut self.silences;
        let presence = &mut self.cell.presence;
        for (silence, present) in [
            (machine, &mut presence.machine),
            (interpolator, &mut presence.interpolator),
            (planner, &mut presence.planner),
        ] {
            silence.poll();
            *present &= !silence.is_lost();
        }
        self.publish(true);
    }

    fn describe(&mut self, description: MachineDescription) -> Result<(), String> {
        let machine = described_machine(&description, &[]).map_err(|error| error.to_string())?;
        self.cell.equipment = Equipment::of_machine(&machine);
        self.cell.description = Some(description);
        Ok(())
    }
}

type SharedAdapter = Arc<Mutex<Adapter>>;

fn lock(adapter: &Mutex<Adapter>) -> MutexGuard<'_, Adapter> {
    adapter.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A running gateway.
#[derive(Debug)]
pub struct PlantGateway {
    node: Node,
    server: AdapterServer,
    ua: Option<UaServer>,
    _look: TimerHandle,
    _spin: SpinThread,
}

impl PlantGateway {
    /// Serves the cell in the namespace of `args` to MTConnect agents, and with `ua` to OPC UA clients; port 0 selects a free one.
    ///
    /// # Errors
    /// The address is in use or not of this computer, or DDS cannot start.
    pub fn start(args: &RosArgs, address: SocketAddr, ua: Option<&UaOptions>) -> Result<Self, NodeError> {
        let feed = Arc::new(ReadingFeed::new(read_all(&CellMessages::default())));
        let refused = |what: &str, address: SocketAddr, error: &dyn std::fmt::Display| {
            let text = format!("{what} cannot be served at {address}: {error}; choose another port or address");
            NodeError::Parameter(text)
        };
        let supervisor = Supervisor::default();
        // Before DDS, so that a wrong port is reported at once.
        let bound = ua.map(|UaOptions { address, nameplate }| match TcpListener::bind(address) {
            Ok(listener) => Ok((*address, (listener, nameplate.clone()))),
            Err(error) => Err(refused("the OPC UA server", *address, &error)),
        });
        let bound = bound.transpose()?;
        let mut server = AdapterServer::start(address, Arc::clone(&feed), &supervisor)
            .map_err(|error| refused("the MTConnect adapter", address, &error))?;
        let (ua_feed, ua) = bound.map_or((None, None), |bound| {
            let (feed, updates) = UaFeed::new();
            (Some(feed), Some((bound, updates)))
        });
        let adapter = Arc::new(Mutex::new(Adapter::new(Arc::clone(&feed), ua_feed)));
        let subscribed = Node::new(NodeOptions::new("plant_gateway", args)).map_err(NodeError::from).and_then(|node| {
            feed.set_prefix(shdr::id_prefix(node.namespace()));
            let logger = node.logger().clone();
            let warnings = Mutex::new(LimitedWarning::default());
            supervisor.on_fault({
                let logger = logger.clone();
                move |fault| logger.error(fault)
            });
            let log = logger.clone();
            server.set_log(move |text| warnings.lock().unwrap_or_else(PoisonError::into_inner).warn(&log, text));
            let ua = ua.map(|((address, parts), updates)| {
                let started = ua::start(parts, updates, node.namespace(), (&logger, &supervisor));
                started.map_err(|error| refused("the OPC UA server", address, &error))
            });
            let ua = ua.transpose()?;
            let mut subscriptions = subscribe(&node, &adapter)?;
            let look = node.timer(LOOK, move || {
                subscriptions.iter_mut().for_each(|watched| watched.check(&mut lock(&adapter)));
                lock(&adapter).look();
            });
            let spin = node.spin_in_thread()?;
            Ok((node, ua, look, spin))
        });
        match subscribed {
            Ok((node, ua, look, spin)) => Ok(Self { node, server, ua, _look: look, _spin: spin }),
            Err(error) => {
                server.stop();
                Err(error)
            }
        }
    }

    /// Address of the adapter.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.server.address()
    }

    /// Address of the OPC UA server, if there is one.
    #[must_use]
    pub fn ua_address(&self) -> Option<SocketAddr> {
        self.ua.as_ref().map(UaServer::address)
    }

    /// Clients of the MTConnect adapter so far.
    #[must_use]
    pub fn statistics(&self) -> ClientCounts {
        self.server.statistics()
    }

    /// Ends the servers, then the node.
    pub fn stop(mut self) {
        self.server.stop();
        if let Some(ua) = &mut self.ua {
            ua.stop();
        }
        self.node.shutdown();
    }
}

/// Removes what a lost publisher has sent.
type Forget = fn(&mut Adapter);

/// A subscription whose message is forgotten when the last publisher is lost.
struct Watched {
    subscription: Subscription,
    forget: Forget,
    /// A message may arrive before its publisher counts as matched, and must not be forgotten then.
    was_matched: bool,
}

impl Watched {
    fn check(&mut self, adapter: &mut Adapter) {
        let is_matched = self.subscription.matched() > 0;
        if self.was_matched && !is_matched {
            (self.forget)(adapter);
        }
        self.was_matched = is_matched;
    }
}

fn subscribe(node: &Node, adapter: &SharedAdapter) -> Result<Vec<Watched>, RosError> {
    // A slow gateway must not delay the machine.
    let unreliable = Qos { reliability: Reliability::BestEffort, ..Qos::default_topic().keep_last(1) };
    let (events, latched) = (Qos::default_topic().keep_last(EVENTS), Qos::latched(1).keep_last(EVENTS));
    let logger = node.logger().clone();
    let mut warned = String::new();
    let subscriptions: [(Subscription, Forget); 10] = [
        (
            store(node, adapter, "machine/stream", &unreliable, |adapter, _: MachineStream| {
                adapter.silences.machine.reset();
                // The first message makes the machine available; later ones change nothing.
                !std::mem::replace(&mut adapter.cell.presence.machine, true)
            })?,
            |adapter| adapter.cell.presence.machine = false,
        ),
        (
            store(node, adapter, "dynamic_joint_states", &unreliable, |adapter, message| {
                adapter.cell.axes = Some(message);
                false
            })?,
            |adapter| adapter.cell.axes = None,
        ),
        (
            store(
                node,
                adapter,
                "machine/description",
                &Qos::latched(1),
                move |adapter, message: MachineDescription| {
                    if let Err(error) = adapter.describe(message)
                        && warned != error
                    {
                        logger.warn(&format!("the description of the machine is refused: {error}"));
                        warned = error;
                    }
                    true
                },
            )?,
            |adapter| adapter.cell.description = None,
        ),
        (
            store(node, adapter, "machine/io", &events, |adapter, message| {
                adapter.cell.io = Some(message);
                true
            })?,
            |adapter| adapter.cell.io = None,
        ),
        (
            store(node, adapter, "machine/work_area", &latched, |adapter, message| {
                adapter.cell.area = Some(message);
                true
            })?,
            |adapter| adapter.cell.area = None,
        ),
        (
            store(node, adapter, "machine/counters", &latched, |adapter, message| {
                adapter.cell.counters = Some(message);
                true
            })?,
            |adapter| adapter.cell.counters = None,
        ),
        (
            store(node, adapter, "machine/alarms", &latched, |adapter, message| {
                adapter.cell.machine_alarms = Some(message);
                true
            })?,
            |adapter| adapter.cell.machine_alarms = None,
        ),
        (
            store(node, adapter, "axis_interpolator/alarms", &latched, |adapter, message| {
                adapter.cell.interpolator_alarms = Some(message);
                true
            })?,
            |adapter| adapter.cell.interpolator_alarms = None,
        ),
        (
            store(node, adapter, "axis_interpolator/state", &events, |adapter, message: InterpolatorState| {
                adapter.silences.interpolator.reset();
                adapter.cell.presence.interpolator = true;
                adapter.cell.interpolator = Some(message);
                true
            })?,
            |adapter| adapter.cell.presence.interpolator = false,
        ),
        (
            store(node, adapter, "job_planner/cell_state", &latched, |adapter, message| {
                adapter.silences.planner.reset();
                adapter.cell.presence.planner = true;
                adapter.cell.cell = Some(message);
                true
            })?,
            |adapter| adapter.cell.presence.planner = false,
        ),
    ];
    let watch = |(subscription, forget)| Watched { subscription, forget, was_matched: false };
    Ok(subscriptions.into_iter().map(watch).collect())
}

/// Subscribes to a topic whose messages go to the adapter; `store` returns true if an event may have changed.
fn store<M: Message>(
    node: &Node,
    adapter: &SharedAdapter,
    topic: &str,
    qos: &Qos,
    mut store: impl FnMut(&mut Adapter, M) -> bool + Send + 'static,
) -> Result<Subscription, RosError> {
    let adapter = Arc::clone(adapter);
    node.subscribe::<M>(topic, qos, move |message, _| {
        let mut adapter = lock(&adapter);
        if store(&mut adapter, message) {
            adapter.publish(false);
        }
    })
}
