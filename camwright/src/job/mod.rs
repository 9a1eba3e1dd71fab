// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Room 6: what a job is.
//!
//! Pure data with its checks: grinding, turning and milling jobs, the raw part, dressing and infeed. Files are read elsewhere. A job
//! that passes its check is complete; whether a machine can do it, the room `planner` decides.
//!
//! ```
//! use camwright::job::grinding::JobSpec;
//!
//! let idle = JobSpec::without_lobes("move clear", 120.0, 100.0); // wheel clear at 120 mm, rapids of 100 mm/s
//! assert!(idle.lobes.is_empty());
//! ```

pub mod axial_shape;
pub(crate) mod check;
pub mod dressing;
pub(crate) mod error;
pub mod grinding;
pub mod infeed;
mod key;
pub mod milling;
pub mod part_support;
pub mod plunges;
pub mod raw_part;
pub mod speed_variation;
pub mod supported_shaft;
pub mod turning;
pub mod wheel_visit;
