//! Programs for controls that are not ours: what is written, and what is refused.

mod refused;
mod sample;
mod written;
