// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Threads of a node: supervised starts, rings between them, accepted connections, and the silence of partners. No ROS.

pub mod drops;
pub mod ring;
pub mod silence;
pub mod supervised;
pub mod system_time;
pub mod tcp_server;
