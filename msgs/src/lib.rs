// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The interfaces camwright speaks, as Rust types.
//!
//! They are generated at build time from the same files that `rosidl` builds the ROS package `camwright_msgs` from
//! (`msg/`, `srv/`, `action/`), and from the standard interfaces written out under `standard/` (ROS 2 Jazzy). Each
//! package is a module, each kind of interface a module in it:
//!
//! ```
//! use camwright_msgs::{Message, sensor_msgs::msg::JointState};
//!
//! let state = JointState { name: vec!["c_axis".into()], position: vec![0.5], ..Default::default() };
//! assert_eq!(JointState::TYPE_NAME, "sensor_msgs/msg/JointState");
//! assert!(JointState::TYPE_HASH.starts_with("RIHS01_"));
//! assert_eq!(state.velocity.len(), 0);
//! ```
//!
//! A structure's fields stand in the order of its file and serialise with `serde` in that order, which is what CDR
//! needs. A field whose name is a Rust keyword ends in an underscore (`type_`). An interface without fields has the
//! one byte `structure_needs_at_least_one_member`, as rosidl gives it. Units are those of ROS: m, rad, s, N.
//!
//! A service is a unit type with its request and response beside it ([`std_srvs::srv::Trigger`]), an action likewise
//! ([`camwright_msgs::action::RunJob`]), with the messages that travel for it. [`ALL`] lists everything, with hashes,
//! descriptions and schema texts, for those who learn a type's name at run time.
//!
//! With the feature `ros2-client` every [`Message`] implements that crate's marker trait too. Nothing else here knows
//! of it.

mod bounds;
pub mod cdr;
mod registry;
pub mod syntax;
mod traits;

pub use bounds::BoundsError;
pub use registry::{ALL, FieldInfo, InterfaceInfo, InterfaceKind, by_type_name};
pub use traits::{Action, Message, Service, WireMessage};

include!(concat!(env!("OUT_DIR"), "/interfaces.rs"));
