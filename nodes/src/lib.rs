//! The ROS 2 shells around the `camwright` core.

pub mod config;
pub mod convert;
pub mod cyclic;
