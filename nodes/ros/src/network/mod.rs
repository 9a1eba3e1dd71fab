// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Guards a node's sockets: which datagrams reach `RustDDS`, where it may send, and what happens when it dies.
//!
//! `RustDDS` binds its sockets to all interfaces, trusts the numbers of every datagram and keeps running half dead after a panic. All three
//! are repaired from outside, on its own sockets and threads:
//!
//! - [`rtps_filter`] is a program of the kernel's packet filter. It passes datagrams of this host alone (discovery range LOCALHOST) and
//!   drops those whose numbers make `RustDDS` allocate without bound, loop or panic.
//! - [`participant`] attaches it to every socket before the first datagram is read and, in LOCALHOST, binds the sending socket to 127.0.0.1,
//!   from where the kernel sends to this host alone.
//! - [`gate`] closes the node to newcomers while a flood of announcements lasts.
//! - [`watchdog`] notices when a thread of `RustDDS` has ended or reads no more, and ends the process with an error.
//! - [`limit_memory`] bounds what the process may allocate, for what the filter cannot see.

mod assembler;
mod descriptors;
#[cfg(test)]
mod filter_tests;
pub(super) mod gate;
mod memory;
pub(super) mod participant;
mod rtps_filter;
mod vitals;
pub(super) mod watchdog;

pub use memory::limit_memory;
