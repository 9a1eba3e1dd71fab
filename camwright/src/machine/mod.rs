//! The machine: what it is, and a simulation of what it does.

pub mod description;
