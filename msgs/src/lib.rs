//! The interfaces of camwright as Rust types.
