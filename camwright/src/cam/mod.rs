// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Room 3: the shape of the part.
//!
//! A lift table or a motion law becomes a lift law; lift law and follower become the finished contour, or the surface of a 3-D cam. The
//! way back belongs here too: form error of a measured part, inspection with another follower, capability of a batch, and the
//! compensation of the next part.
//!
//! ```
//! use camwright::cam::{contour::Contour, follower::Follower, lift::LiftLaw};
//!
//! let lift = LiftLaw::from_fn(|cam_angle| 1.5 * (1.0 - cam_angle.cos()))?;
//! let follower = Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 };
//! assert!(Contour::from_lift(&lift, &follower, 16.0).is_ok());
//! # Ok::<(), camwright::cam::lift::LiftLawError>(())
//! ```

pub mod capability;
pub mod compensation;
pub mod contour;
pub mod follower;
pub mod form;
pub mod form_tolerance;
pub mod gauge_report;
pub mod inspection;
pub mod lift;
pub mod lobe_inspection;
pub mod motion_law;
pub mod outline;
pub mod surface;
pub mod wave_cause;
