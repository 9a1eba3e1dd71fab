// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Room 7: motion in time.
//!
//! [`plan`] is the plan as data: segments that the interpolator executes. The other files make its segments: moves from point to point,
//! stops on the path, and [`speed_plan`], which finds the fastest speed of C along a path within the limits of every axis. A speed plan
//! is checked by differencing its positions before it is returned.
//!
//! ```
//! use camwright::machine::{description::Axis, reference::cam_grinder};
//! use camwright::motion::point_to_point::rest_to_rest;
//!
//! let limits = cam_grinder().axis(Axis::X).limits;
//! let law = rest_to_rest(25.0, &limits)?; // mm over s
//! assert!((law.sample(law.end()).value - 25.0).abs() < 1e-9);
//! # Ok::<(), camwright::motion::point_to_point::PointToPointError>(())
//! ```

pub mod cut_motion;
pub mod path_stop;
pub mod plan;
pub mod point_to_point;
pub(crate) mod speed_change;
pub mod speed_plan;
pub mod spiral_motion;
