//! From a lift table to axis motion, and from axis motion to the part: the mathematics of machining what is not round.
//!
//! Inside: mm, rad, s, N, unless a name says otherwise. No ROS, no file, no clock, no thread: time is a tick.
#![no_std]
extern crate alloc;

pub mod cam;
pub mod cell;
pub mod gauging;
pub mod gcode;
pub mod interpolator;
pub mod job;
pub mod machine;
pub mod math;
pub mod motion;
pub mod planner;
pub mod simulation;
pub mod toolpath;
