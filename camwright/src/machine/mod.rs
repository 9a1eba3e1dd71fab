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
pub(crate) mod axes;
pub(crate) mod contact;
pub mod contact_law;
pub mod description;
pub(crate) mod drive;
pub mod fixture;
pub(crate) mod gauge;
pub(crate) mod homing;
pub(crate) mod insert;
pub(crate) mod loading;
pub mod persistent_state;
pub(crate) mod probe;
pub(crate) mod process;
pub mod reference;
pub(crate) mod retract;
pub mod setpoint;
pub(crate) mod thermal;
mod wheel;
pub mod wheel_state;
mod without_effect;

pub use wheel::WHEEL_TOLERANCE_MM;
