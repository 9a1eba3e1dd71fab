// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Shared code of the tests: the Python environment of the ROS 2 peers, ROS domains of their own, guarded processes, a real rclpy
//! node that takes orders, and the interpreter of LinuxCNC.
#![allow(dead_code, reason = "each test binary uses its own part of this module")]
#![allow(unused_imports, reason = "as above")]
#![allow(unreachable_pub, reason = "a module of test binaries has no outside")]

pub mod command;
mod command_line;
mod domain;
mod env;
mod folder;
pub mod hosts;
mod linuxcnc;
mod opcua;
mod peer;
mod process;
pub mod processes;
pub mod rtps;
pub mod tutorial;

pub use command_line::{camwright, refusal_of_check};
pub use domain::Domain;
pub use env::{PeerEnv, RosDistribution, in_ci, peer_env, repository, target_directory};
pub use folder::Folder;
pub use linuxcnc::{Driven, LinuxCnc};
pub use opcua::{UaClientEnv, ua_client_env};
pub use peer::{LOOPBACK, Peer};
pub use process::{Guarded, PATIENCE};
