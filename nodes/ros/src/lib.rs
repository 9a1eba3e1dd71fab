// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! ROS 2 nodes in Rust, without a ROS installation.
//!
//! [`ros2-client`](https://docs.rs/ros2-client) and [`rustdds`](https://docs.rs/rustdds) carry the messages. This crate adds what a node
//! needs beyond them:
//!
//! | | |
//! |---|---|
//! | [`Node`], [`Node::spin`] | one participant and one executor thread per node; timers; delivery between endpoints of one node |
//! | [`RosArgs`] | `--ros-args`: remapping, parameters, parameter files, log levels, namespaces, domain and discovery range |
//! | [`Publisher`], [`Subscription`], [`Qos`] | the quality of service profiles of ROS 2; number and times of each message; waiting for a match; serialised messages |
//! | [`Client`], [`Responder`] | services that reply at once or later, to clients on Fast DDS and on Cyclone DDS |
//! | `service_configure_introspection` and three more | parameters that publish service events, as in the demos of ROS 2 |
//! | [`ActionServer`], [`ActionClient`] | any number of goals at once; deferred decisions; results that are kept |
//! | [`Lifecycle`] | managed nodes: five services, `~/transition_event`, callbacks on a thread of their own |
//! | [`Parameter`], [`Parameters`] | ranges, choices, read-only and optional parameters, validators, the parameter services |
//! | [`Logger`], [`Diagnostics`] | `/rosout`, logger levels, `tracing` events; `/diagnostics` |
//! | [`Node::now`] | `/clock` and `use_sim_time` |
//! | [`GraphListener`], [`Node::discovered_topics`] | topics, services and nodes of the domain, and their changes |
//! | [`Shutdown`], [`running`] | signals, exit codes, `main` of a node |
//! | [`Authority`] | decides on every request to a node |
//!
//! Malformed datagrams are dropped before `rustdds` reads them, and with the default discovery range no packet leaves the host.
//!
//! # Example
//!
//! All callbacks of a node run on the thread that spins it. The repository has a longer example with service, action and life cycle:
//! `nodes/ros/examples/homing_axis`.
//!
//! ```no_run
//! use camwright_msgs::std_msgs::msg::String as Text;
//! use camwright_ros::{Node, NodeOptions, Parameter, Qos, RosArgs, Shutdown};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let (args, _rest) = RosArgs::from_env()?;
//! let rate = Parameter::double("rate_hz", 10.0).describe("publish rate (Hz)").range(0.1, 100.0);
//! let node = Node::new(NodeOptions::new("talker", &args).parameter(rate))?;
//! let publisher = node.publisher::<Text>("chatter", &Qos::default_topic())?;
//! let period = std::time::Duration::from_secs_f64(1.0 / node.parameters().double("rate_hz"));
//! let _timer = node.timer(period, move || drop(publisher.publish(&Text { data: "hello".into() })));
//! node.spin(&Shutdown::on_signals()?)?;
//! node.shutdown();
//! # Ok(())
//! # }
//! ```

pub mod liveness;
pub mod realtime;
pub mod running;

mod action;
mod action_client;
mod action_server;
mod args;
mod authority;
mod clock;
mod cyclone;
mod delay;
mod diagnostics;
mod discovery;
mod early_events;
mod error;
mod executor;
mod fastdds_workarounds;
mod goal_handle;
mod goal_table;
mod introspection;
mod level;
mod lifecycle;
mod load;
mod logger_services;
mod logging;
mod loopback;
mod matches;
mod names;
mod neighbours;
mod network;
mod node;
mod node_lock;
mod node_start;
mod parameter_services;
mod parameter_value;
mod parameters;
mod params_file;
mod participant_entities;
mod qos;
mod raw_requests;
mod reader_depth;
mod repeated_warnings;
mod reply_pace;
mod rosout;
mod rtps_messages;
mod sample_info;
mod services;
mod shutdown;
mod sim_time;
mod telemetry;
mod topics;
mod type_description;
mod unsupported;
mod wire;

pub use action::{GoalId, GoalStatus};
pub use action_client::{ActionClient, CancelOutcome, ClientGoal};
pub use action_server::{ActionHandler, ActionServer, DeferredDecision, GoalDecider, GoalDecision};
pub use args::{ArgsError, DiscoveryRange, RosArgs};
pub use authority::Authority;
pub use clock::{ElapsedTime, from_time, to_time};
pub use delay::DelayInjection;
pub use diagnostics::{Diagnostics, diagnostic_status};
pub use discovery::{EndpointInfo, GraphListener, Guid, TopicInfo};
pub use error::RosError;
pub use executor::TimerHandle;
pub use goal_handle::GoalHandle;
pub use level::Level;
pub use lifecycle::{Lifecycle, LifecycleCallbacks, LifecycleState, Transition};
pub use logging::{CurrentLogger, Logger, RosLayer};
pub use names::NameError;
pub use network::limit_memory;
pub use node::{Farewell, Node, SpinThread};
pub use node_lock::{NodeLock, runs_already};
pub use node_start::NodeOptions;
pub use parameter_value::ParameterValue;
pub use parameters::{Parameter, ParameterChanges, ParameterDeclaration, ParameterRange, Parameters};
pub use params_file::{NodeParameters, parse as parse_parameter_file};
pub use qos::{Durability, History, Liveliness, Qos, Reliability, WriterWindow};
pub use raw_requests::RawRequests;
pub use services::{Client, Responder, ServiceHandle};
pub use shutdown::{EXIT_FAILED, Shutdown, ShutdownHook};
pub use telemetry::Telemetry;
pub use topics::{MessageInfo, Publisher, RawPublisher, Subscription};
