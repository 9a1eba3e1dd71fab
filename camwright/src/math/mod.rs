// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Room 1: mathematics without machining.
//!
//! Splines (Hermite in time, periodic B-splines over a turn), roots, extrema, banded solvers, derivatives by differences, units,
//! numbers with twice the digits, and [`snapshot`], which writes the state of a running machine as octets. Values go in, values come
//! out; nothing here knows an axis or a part.
//!
//! ```
//! use camwright::math::hermite::{HermiteSpline, Knot};
//!
//! let rest = Knot { at: 0.0, value: 0.0, first: 0.0, second: 0.0 };
//! let law = HermiteSpline::new(vec![rest, Knot { at: 2.0, value: 10.0, ..rest }])?;
//! assert_eq!(law.sample(1.0).value, 5.0);
//! # Ok::<(), camwright::math::hermite::HermiteError>(())
//! ```

pub mod banded;
pub mod complex;
pub mod differences;
pub mod extremum;
pub mod fixed_list;
pub mod hermite;
pub(crate) mod hermite_exact;
pub mod hull;
pub(crate) mod jet;
pub(crate) mod lanes;
pub(crate) mod named;
pub mod noise;
pub(crate) mod pentadiagonal;
pub mod periodic_cubic;
pub mod periodic_spline;
#[cfg(test)]
pub(crate) mod random;
pub mod range;
pub(crate) mod root;
pub mod snapshot;
pub mod tube;
pub mod twofold;
pub(crate) mod uneven_cubic;
pub mod uniform_hermite;
pub mod units;
pub mod windows;
pub mod work;
