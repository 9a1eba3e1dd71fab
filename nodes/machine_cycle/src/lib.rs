// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The cyclic loop of a simulated machine without ROS: the node `machine_sim` runs it, and a replay runs it again from recorded inputs.

pub mod active_alarms;
pub mod area_order;
pub mod bounds;
pub mod commands;
pub mod cyclic_loop;
pub mod faults;
pub mod inbound;
pub mod input_record;
mod keyframe_writing;
pub mod keyframes;
pub mod messages;
pub mod outline;
pub mod output_digest;
pub mod pacing;
pub mod part;
pub mod partners;
pub mod persistent_record;
pub mod replay;
pub mod servo_bus;
mod silent_partners;
pub mod stream_state;
