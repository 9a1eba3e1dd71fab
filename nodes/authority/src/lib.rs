// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Command authority: one holder at a time may change zeros, state or motion of a cell.
//!
//! ```text
//! machine/take_command ─► Desk (machine): the one Lease ─► machine/command_holder ─► Grant of interpolator and planner
//! machine/join_command ─►   who has which role                                        who may ask them for what
//! ```
//! Every service, goal and command topic of machine, interpolator and planner is closed unless `rules.rs` lists it as open. The requests of
//! all services pass one hook ([`camwright_ros::Authority`]).

mod command_server;
mod grant;
mod held_command;
mod lease;
mod machine_topic;
mod one_sender;
mod rules;

pub use command_server::{CommandServer, Open};
pub use grant::{Grant, Membership, join};
pub use held_command::{HeldCommand, TakeError, TakeOptions};
pub use lease::Role;
pub use machine_topic::subscribe_to_machine;
pub use one_sender::OneSender;
pub use rules::{Access, access};

use std::sync::{Mutex, MutexGuard, PoisonError};

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
