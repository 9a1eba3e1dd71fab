//! The ROS 2 layer: the only place that names `ros2-client` or `rustdds`.
//!
//! Contexts, nodes, publishers and subscriptions are the crate's. What it lacks or gets wrong for us is here: names and remapping,
//! `--ros-args`, quality of service, parameters with descriptors, services and actions (several goals at once), the life cycle,
//! `/clock`, `/rosout`, `/diagnostics`, discovery, shutdown. Nothing above this module meets any of it.
//!
//! A node has one participant and one executor thread, on which all its callbacks run:
//!
//! ```no_run
//! use camwright_msgs::std_msgs::msg::String as Text;
//! use camwright_ros::{Node, NodeOptions, Parameter, Qos, RosArgs, Shutdown};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let (args, _rest) = RosArgs::from_env()?;
//! let rate = Parameter::double("rate_hz", 10.0).describe("how often, in Hz").range(0.1, 100.0);
//! let node = Node::new(NodeOptions::new("talker", &args).parameter(rate))?;
//! let publisher = node.publisher::<Text>("chatter", &Qos::default_topic())?;
//! let period = std::time::Duration::from_secs_f64(1.0 / node.parameters().double("rate_hz"));
//! let _timer = node.timer(period, move || drop(publisher.publish(&Text { data: "hello".into() })));
//! node.spin(&Shutdown::on_signals()?)?;
//! node.shutdown();
//! # Ok(())
//! # }
//! ```

pub mod authority;
pub mod liveness;
pub mod realtime;
pub mod running;

mod action;
mod action_client;
mod action_server;
mod args;
mod authority_hook;
mod clock;
mod cyclone;
mod delay;
mod diagnostics;
mod discovery;
mod error;
mod executor;
mod fastdds_workarounds;
mod goal_handle;
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
mod parameter_services;
mod parameter_value;
mod parameters;
mod params_file;
mod qos;
mod raw_requests;
mod reader_depth;
mod repeated_warnings;
mod reply_pace;
mod rtps_messages;
mod services;
mod shutdown;
mod telemetry;
mod topics;
mod type_description;
mod unsupported;
mod wire;

pub use action::{GoalId, GoalStatus};
pub use action_client::{ActionClient, CancelOutcome, ClientGoal};
pub use action_server::{ActionHandler, ActionServer, GoalDecider, GoalDecision, LaterDecision};
pub use args::{ArgsError, DiscoveryRange, RosArgs};
pub use authority_hook::Authority;
pub use clock::{from_time, to_time};
pub use delay::DelayInjection;
pub use diagnostics::{Diagnostics, diagnostic_status};
pub use discovery::{EndpointInfo, GraphListener, Guid, TopicInfo};
pub use error::RosError;
pub use executor::TimerHandle;
pub use goal_handle::GoalHandle;
pub use lifecycle::{Lifecycle, LifecycleCallbacks, LifecycleState, Transition};
pub use logging::{CurrentLogger, Level, Logger, RosLayer};
pub use names::NameError;
pub use network::limit_memory;
pub use node::{Node, NodeOptions, SpinThread};
pub use parameter_value::ParameterValue;
pub use parameters::{Parameter, ParameterChanges, ParameterDeclaration, ParameterRange, Parameters};
pub use qos::{Durability, History, Liveliness, Qos, Reliability, WriterWindow};
pub use raw_requests::RawRequests;
pub use services::{Client, Responder, ServiceHandle};
pub use shutdown::{EXIT_FAILED, Shutdown, ShutdownHook};
pub use telemetry::Telemetry;
pub use topics::{MessageInfo, Publisher, RawPublisher, Subscription};
