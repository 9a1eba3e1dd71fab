//! Room simulation.

pub(crate) mod axis;
pub mod buffer;
pub mod closed_loop;
pub mod fault;
pub mod fault_campaign;
pub mod force_monitor;
pub(crate) mod gauge;
pub mod lathe_drives;
pub(crate) mod machine;
pub(crate) mod mechanics;
pub mod offline_run;
pub mod plausibility;
pub mod rehearsal;
pub mod sensors;
pub mod servo;
pub mod tick_report;
pub mod turned_part;
pub mod wheel_spindle;
pub mod work_area;
pub mod workpiece;
pub use machine::{Machine, MachineCommand, ResetRefused};
