//! Room cell.

pub mod loading;
pub mod packml;
