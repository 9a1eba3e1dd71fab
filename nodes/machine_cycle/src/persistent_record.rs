//! Persistent state at the start of a run, in a form that reads back to the bit.

use camwright::machine::persistent_state::{PersistentState, TravelCount};
use serde::{Deserialize, Serialize};

/// All of a machine's lasting state; lengths in mm. Tallies are total, good, bad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PersistentRecord {
    wheel_radius_mm: f64,
    wheel_wear_mm: f64,
    growth_mm: f64,
    growth_at_dress_mm: f64,
    lobes_since_dress: u32,
    parts_since_dress: u32,
    dress_count: u32,
    life: [u64; 3],
    shift: [u64; 3],
}

impl From<&PersistentState> for PersistentRecord {
    fn from(state: &PersistentState) -> Self {
        let listed = |tally: &TravelCount| [tally.total, tally.good, tally.bad];
        Self {
            wheel_radius_mm: state.wheel_radius_mm,
            wheel_wear_mm: state.wheel_wear_mm,
            growth_mm: state.growth_mm,
            growth_at_dress_mm: state.growth_at_dress_mm,
            lobes_since_dress: state.lobes_since_dress,
            parts_since_dress: state.parts_since_dress,
            dress_count: state.dress_count,
            life: listed(&state.life),
            shift: listed(&state.shift),
        }
    }
}

impl From<&PersistentRecord> for PersistentState {
    fn from(record: &PersistentRecord) -> Self {
        let tally = |[total, good, bad]: [u64; 3]| TravelCount { total, good, bad };
        Self {
            wheel_radius_mm: record.wheel_radius_mm,
            wheel_wear_mm: record.wheel_wear_mm,
            growth_mm: record.growth_mm,
            growth_at_dress_mm: record.growth_at_dress_mm,
            lobes_since_dress: record.lobes_since_dress,
            parts_since_dress: record.parts_since_dress,
            dress_count: record.dress_count,
            life: tally(record.life),
            shift: tally(record.shift),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_outlives_a_run_reads_back_to_the_bit() {
        let tally = |total| TravelCount { total, good: 1, bad: 2 };
        let state = PersistentState {
            wheel_radius_mm: 59.999_999_999_999_99,
            wheel_wear_mm: 1.0 / 3.0,
            growth_mm: -0.0,
            growth_at_dress_mm: 5e-324,
            lobes_since_dress: 1,
            parts_since_dress: 2,
            dress_count: 3,
            life: tally(u64::MAX),
            shift: tally(4),
        };
        let text = serde_json::to_string(&PersistentRecord::from(&state)).expect("numbers");
        let read: PersistentRecord = serde_json::from_str(&text).expect("as it was written");
        let back = PersistentState::from(&read);
        assert_eq!(back, state);
        assert_eq!(back.growth_mm.to_bits(), state.growth_mm.to_bits());
    }
}
