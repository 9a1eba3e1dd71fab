// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The machine as others draw it: its links and joints as a URDF, where they stand as transforms, the part as markers. SI units.
//!
//! ```text
//! MachineDescription ─► Tree ─► URDF                    robot_description
//!                        └────► transforms of positions  /tf, /tf_static
//! outlines of the part ───────► markers in its frames    machine/markers, job_planner/markers
//! ```
//!
//! One tree makes the description and the transforms, so they cannot differ, and it is made from the machine file, so limits, strokes
//! and the mounted wheel are those of the machine that runs.

mod bodies;
mod frames;
mod link;
mod markers;
mod solids;
pub mod tree;
mod urdf;

pub use frames::{FRAME_PREFIX, Frames, frames_of, parameter, prefix};
pub use link::{Inertial, Link, LinkSolid, Visual};
pub use markers::{MarkerPose, Rgba, about, error_ring, gone, outline, rings, solid, text, wheel};
pub use tree::{Joint, JointMotion, Limit, Tree};
pub use urdf::UrdfVersion;
