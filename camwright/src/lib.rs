//! From a lift table to axis motion, and from axis motion to the part: the mathematics of machining what is not round.
#![no_std]
extern crate alloc;
