//! Splines and solvers that the rest is built on.

pub mod differences;
pub mod hermite;
pub mod periodic_spline;
