//! Splines and solvers that the rest is built on.

pub mod hermite;
pub mod periodic_spline;
