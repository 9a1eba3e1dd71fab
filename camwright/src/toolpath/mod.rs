// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Room 4: the way of a tool along a contour.
//!
//! A contour or surface and a tool go in: grinding wheel, end mill or round insert. X over the turned angle of C comes out, with the
//! places where the tool does not fit. Time and axis limits come later.
//!
//! ```
//! use camwright::cam::{contour::Contour, follower::Follower, lift::LiftLaw};
//! use camwright::toolpath::wheel_path::ToolPath;
//!
//! let lift = LiftLaw::from_fn(|cam_angle| 1.5 * (1.0 - cam_angle.cos()))?;
//! let contour = Contour::from_lift(&lift, &Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 }, 16.0)?;
//! let path = ToolPath::for_wheel(&contour, 60.0)?;
//! assert_eq!(path.wheel_radius_mm(), 60.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod cutter_path;
pub mod groove;
pub mod insert_clearance;
pub mod insert_path;
pub mod rake_section;
pub mod wheel_path;
