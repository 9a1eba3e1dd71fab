//! The ROS 2 shells around the `camwright` core.

pub mod config;
