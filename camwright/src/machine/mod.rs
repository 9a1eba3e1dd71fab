//! The machine: what it is, and a simulation of what it does.
//!
//! ```text
//! setpoints → buffer ─┐
//!           commands ─┤→ Machine::step → axis, servo → sensors → contact, workpiece → report
//!             faults ─┘                                    alarm
//! ```
//! Positions inside are encoder counts as floating point, in the machine's true coordinates: C is 0 where the key-way's
//! centre faces the wheel, X is the distance of the wheel's cutting point from the spindle axis, Z is the table.
//!
//! A machine with an insert is a lathe ([`turned_part`]): X is the distance of the insert's centre from the spindle axis, and Z the slide
//! of the chuck, whose place is where the insert's centre stands along the part, less a constant of the clamping.

pub mod alarm;
mod axis;
mod axis_description;
pub mod buffer;
mod contact_description;
mod cyclic;
pub mod description;
mod drive_description;
mod effect_description;
pub mod fault;
pub mod fixture;
pub mod force_monitor;
mod gauge;
mod gauge_description;
mod homing_description;
mod insert_description;
mod loading_description;
mod mechanics;
pub mod plausibility;
mod probe_description;
mod process_description;
pub mod reference;
pub mod report;
mod retract_description;
pub mod sensors;
pub mod servo;
pub mod simulate;
pub mod state;
mod thermal_description;
pub mod turned_part;
pub mod wheel;
mod wheel_description;
pub mod work_area;
pub mod workpiece;

pub use cyclic::{Machine, MachineCommand, ResetRefused};
pub use wheel_description::WHEEL_TOLERANCE_MM;
