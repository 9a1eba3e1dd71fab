//! Room job.

pub(crate) mod check;
pub mod dressing;
pub(crate) mod error;
pub mod grinding;
pub mod infeed;
pub mod milling;
pub mod raw_part;
pub mod turning;
