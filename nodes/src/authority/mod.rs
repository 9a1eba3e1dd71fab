//! Command authority: one holder at a time may change zeros, state or motion of a cell.
//!
//! ```text
//! machine/take_command ─► Desk (machine): the one Lease ─► machine/command_holder ─► Grant of interpolator and planner
//! machine/join_command ─►   who has which role                                        who may ask them for what
//! ```
//! Every service, goal and command topic of machine, interpolator and planner is closed unless [`rules`] lists it as open. The requests of
//! all services pass one hook (`ros/authority.rs`).

mod desk;
mod grant;
pub(crate) mod lease;
mod rules;
mod taken;

pub(crate) use desk::Desk;
pub(crate) use grant::{Grant, Membership, join};
pub use taken::{Command, TakeError, TakeOptions};
