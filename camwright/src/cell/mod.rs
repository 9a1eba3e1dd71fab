// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Room 12: the cell around the machine.
//!
//! The states of PackML (ISA-TR88.00.02) and the handshake with a robot that loads parts. Commands and sensor states go in, the next
//! state and the requests to the robot come out. The clock is an argument.
//!
//! ```
//! use camwright::cell::packml::{PackmlState, Unit};
//!
//! let cell = Unit::new(0.0);
//! assert_eq!(cell.state(), PackmlState::default());
//! assert_eq!(cell.time_in_state_s(2.5), 2.5);
//! ```

pub mod loading;
pub mod packml;
