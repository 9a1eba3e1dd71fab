// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Persistent state at the start of a run, in a form that reads back to the bit.

use camwright::machine::description::MAX_WHEELS;
use camwright::machine::persistent_state::{PersistentState, TravelCount};
use camwright::machine::wheel_magazine::{StoredWheel, WheelMagazine};
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
    #[serde(default, skip_serializing_if = "Option::is_none")]
    wheel_zero_error_mm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    magazine: Option<MagazineRecord>,
}

/// Wheels of a changer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MagazineRecord {
    mounted: u32,
    /// By position.
    stored: [Option<StoredWheelRecord>; MAX_WHEELS],
}

/// A wheel in the magazine; lengths in mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredWheelRecord {
    radius_mm: f64,
    wear_mm: f64,
    growth_at_dress_mm: f64,
    zero_error_mm: f64,
    lobes_since_dress: u32,
    parts_since_dress: u32,
    dress_count: u32,
}

impl From<&WheelMagazine> for MagazineRecord {
    fn from(magazine: &WheelMagazine) -> Self {
        let stored = |position| {
            let wheel: StoredWheel = magazine.stored(position)?;
            Some(StoredWheelRecord {
                radius_mm: wheel.radius_mm,
                wear_mm: wheel.wear_mm,
                growth_at_dress_mm: wheel.growth_at_dress_mm,
                zero_error_mm: wheel.zero_error_mm,
                lobes_since_dress: wheel.lobes_since_dress,
                parts_since_dress: wheel.parts_since_dress,
                dress_count: wheel.dress_count,
            })
        };
        let mounted = u32::try_from(magazine.mounted()).unwrap_or(u32::MAX);
        Self { mounted, stored: std::array::from_fn(stored) }
    }
}

impl From<&MagazineRecord> for WheelMagazine {
    fn from(record: &MagazineRecord) -> Self {
        let stored = |wheel: StoredWheelRecord| StoredWheel {
            radius_mm: wheel.radius_mm,
            wear_mm: wheel.wear_mm,
            growth_at_dress_mm: wheel.growth_at_dress_mm,
            zero_error_mm: wheel.zero_error_mm,
            lobes_since_dress: wheel.lobes_since_dress,
            parts_since_dress: wheel.parts_since_dress,
            dress_count: wheel.dress_count,
        };
        Self::from_states(record.mounted as usize, record.stored.map(|wheel| wheel.map(stored)))
    }
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
            // Records of machines without such an error are as they always were.
            wheel_zero_error_mm: (state.wheel_zero_error_mm.abs() > 0.0).then_some(state.wheel_zero_error_mm),
            magazine: state.magazine.as_ref().map(MagazineRecord::from),
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
            wheel_zero_error_mm: record.wheel_zero_error_mm.unwrap_or(0.0),
            magazine: record.magazine.as_ref().map(WheelMagazine::from),
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
            wheel_zero_error_mm: 0.0,
            magazine: None,
        };
        let text = serde_json::to_string(&PersistentRecord::from(&state)).expect("numbers");
        let read: PersistentRecord = serde_json::from_str(&text).expect("as it was written");
        let back = PersistentState::from(&read);
        assert_eq!(back, state);
        assert_eq!(back.growth_mm.to_bits(), state.growth_mm.to_bits());
        assert!(!text.contains("magazine") && !text.contains("zero"), "as it always was: {text}");
        let wheel = StoredWheel { radius_mm: 1.0 / 3.0, zero_error_mm: -0.1, dress_count: 9, ..StoredWheel::default() };
        let magazine = WheelMagazine::from_states(1, [Some(wheel), None, None, None]);
        let state = PersistentState { wheel_zero_error_mm: 1e-3 / 3.0, magazine: Some(magazine), ..state };
        let text = serde_json::to_string(&PersistentRecord::from(&state)).expect("numbers");
        let read: PersistentRecord = serde_json::from_str(&text).expect("as it was written");
        assert_eq!(PersistentState::from(&read), state);
    }
}
