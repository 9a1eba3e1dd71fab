// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Room 11: what the machine does.
//!
//! ```text
//! setpoints → buffer ─┐
//!           commands ─┤→ Machine::step → axis, servo → sensors → contact, workpiece → report
//!             faults ─┘                                    alarm
//! ```
//! [`Machine::step`] takes the setpoint of a tick, moves the axes through their drives, reads the sensors, removes material and reports.
//! Positions are encoder counts as floating point in the machine's true coordinates. A machine with an insert is a lathe
//! ([`turned_part`]). [`closed_loop`] joins interpolator and machine, [`fault_campaign`] injects every fault at many moments of a job.
//!
//! ```
//! use camwright::machine::{persistent_state::PersistentState, reference::cam_grinder};
//! use camwright::simulation::Machine;
//!
//! let description = cam_grinder();
//! let mut machine = Machine::new(description.clone(), PersistentState::new(&description))?;
//! let report = machine.step(None, &[], &[]);
//! assert_eq!(report.tick, 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub(crate) mod axis;
pub mod buffer;
pub mod closed_loop;
pub mod fault;
pub mod fault_campaign;
pub mod force_monitor;
pub(crate) mod gauge;
pub mod lathe_drives;
pub(crate) mod machine;
pub mod measured;
pub(crate) mod mechanics;
pub mod plausibility;
pub mod process_monitor;
pub mod sensors;
pub mod servo;
pub mod size_monitor;
pub mod tick_report;
pub mod turned_part;
pub mod wheel_spindle;
pub mod work_area;
pub mod workpiece;
pub use machine::{Machine, MachineCommand, ResetRefused};
