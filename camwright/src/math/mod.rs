//! Splines and solvers that the rest is built on.

pub mod banded;
pub mod differences;
pub mod extremum;
pub mod fixed_list;
pub mod hermite;
pub(crate) mod hermite_exact;
pub mod hull;
pub(crate) mod jet;
pub(crate) mod noise;
pub mod periodic_cubic;
pub mod periodic_spline;
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
