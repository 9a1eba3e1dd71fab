//! The part on its way to the cyclic thread and back.

use camwright::machine::workpiece::{CutAt, LobeError};

/// A lobe of a raw part, on its way to the machine.
#[derive(Debug)]
pub(super) struct RawLobe {
    pub(super) clear: bool,
    pub(super) name: String,
    pub(super) station: String,
    pub(super) width_mm: f64,
    /// Of the part, as every lobe of it says.
    pub(super) key_way_rad: f64,
    pub(super) radii_mm: Vec<f64>,
}

/// The part as it stands, copied into room that the pump made.
#[derive(Debug, Default)]
pub(super) struct Snapshot {
    pub(super) tick: u64,
    pub(super) finished: bool,
    pub(super) key_way_rad: f64,
    pub(super) lobes: Vec<SnapshotLobe>,
}

/// One lobe of a snapshot.
#[derive(Debug, Default, Clone)]
pub(super) struct SnapshotLobe {
    pub(super) name: String,
    pub(super) station: String,
    pub(super) width_mm: f64,
    pub(super) radii_mm: Vec<f64>,
    /// What was taken from every degree of it; empty where nobody knows.
    pub(super) cut: Vec<CutAt>,
}

/// Why a lobe was not put in.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum LobeRefused {
    Moving,
    Part(LobeError),
}
