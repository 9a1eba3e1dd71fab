//! The ROS 2 shells around the `camwright` core.

pub mod bag;
pub mod config;
pub mod convert;
pub mod cyclic;
pub mod ros;
