// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Room 2: description of a machine. It says what a machine is; the room `simulation` says what it does.
//!
//! Axes with counts and limits, drives, wheel or insert, gauges, switches, contact law, the alarm table, setpoints, and the state that
//! outlives a run. Every later room takes its limits from [`description::MachineDescription`]. A machine with an insert is a lathe.
//!
//! C is 0 where the centre of the keyway faces the wheel. X is the distance of the wheel's cutting point from the spindle axis, on a
//! lathe that of the insert's centre. Z is the table.
//!
//! ```
//! use camwright::machine::{description::Axis, reference::cam_grinder};
//!
//! let grinder = cam_grinder();
//! assert!(!grinder.is_lathe());
//! assert!(grinder.axis(Axis::X).limits.velocity > 0.0); // mm/s
//! ```

pub mod alarm;
pub(crate) mod axes;
pub mod axial_profile;
pub(crate) mod contact;
pub mod contact_law;
pub mod description;
pub mod description_error;
pub(crate) mod drive;
pub(crate) mod effect;
pub mod fixture;
pub(crate) mod gauge;
pub(crate) mod homing;
mod homing_check;
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
pub mod wheel_changer;
pub mod wheel_magazine;
pub mod wheel_state;
mod without_effect;
pub(crate) mod workholding;

pub use wheel::WHEEL_TOLERANCE_MM;
