// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Bounds that an interface sets and Rust's types do not hold.

use std::error::Error;
use std::fmt;

/// A text or a sequence is longer than its interface allows; a peer would refuse the message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoundsError {
    /// The field, with its type: `rcl_interfaces/msg/ParameterDescriptor.integer_range`.
    pub field: &'static str,
    /// Its length: elements of a sequence, bytes of a text.
    pub length: usize,
    /// The largest length allowed.
    pub bound: usize,
}

impl BoundsError {
    /// Compares a length with its bound.
    ///
    /// # Errors
    /// The length is above the bound.
    pub(crate) fn check(field: &'static str, length: usize, bound: usize) -> Result<(), Self> {
        if length > bound { Err(Self { field, length, bound }) } else { Ok(()) }
    }
}

impl fmt::Display for BoundsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} has length {}, at most {} are allowed", self.field, self.length, self.bound)
    }
}

impl Error for BoundsError {}
