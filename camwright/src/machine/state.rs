//! What outlives a run: the machine's lasting state. The node keeps it in a file; here it is a plain value.

use crate::machine::description::MachineDescription;

/// What the machine remembers from one run to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LastingState {
    /// Present radius of the wheel (mm).
    pub wheel_radius_mm: f64,
    /// Times this wheel has been dressed.
    pub dress_count: u32,
    /// Parts finished.
    pub part_count: u64,
}

impl LastingState {
    /// A machine that has never run, with a new wheel.
    #[must_use]
    pub fn new(description: &MachineDescription) -> Self {
        Self { wheel_radius_mm: description.wheel.new_radius_mm, dress_count: 0, part_count: 0 }
    }
}
