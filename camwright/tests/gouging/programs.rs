// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Programs of several controls for the reference lobe, at any speed, held and slowed at any tick.

use super::JobEnd;
use super::drive::{drive, requests};
use super::sweep::Touch;
use crate::cams::SplitMix64;
use crate::program_motion::shop::{Part, STATION_MM, plan, program, setup, start};
use camwright::gcode::Dialect;
use camwright::interpolator::Interpolator;
use camwright::machine::description::DriveSettings;
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::reference::cam_grinder;
use camwright::simulation::Machine;

/// Counts of X and C, and half a digit of the program (mm).
const NOTHING_MM: f64 = 2e-4;

/// One program, from its seed.
pub(crate) fn judge(seed: u64, touch: &Touch) -> JobEnd {
    let mut random = SplitMix64(seed);
    let machine = cam_grinder().with_drives(DriveSettings::IDEAL);
    let dialect = random.one_of(&Dialect::ALL);
    let (posted, read) = program(&Part::lobe(), dialect, random.within(3.0, 25.0));
    let planned = match plan(&read, setup(), &machine) {
        Ok(planned) => planned,
        Err(error) => return JobEnd::Refused(error.to_string()),
    };
    let rounding_mm = planned.runs.iter().map(|(_, run)| run.laws.rounding_mm).fold(0.0, f64::max);
    let allowed_mm = posted.turns[1].deviation.error_mm + rounding_mm + NOTHING_MM;
    let mut simulated = Machine::new(machine.clone(), PersistentState::new(&machine)).expect("a machine");
    // Only C stands elsewhere until it is homed.
    assert_eq!(simulated.setpoint().counts[1..], start(&machine).counts[1..]);
    let ticks = planned.plan.segments.iter().map(|segment| segment.ticks).sum();
    let requests = requests(&mut random, ticks);
    let (mut deepest_mm, mut fault) = (f64::NEG_INFINITY, None);
    let outcome = drive(&planned.plan, &mut Interpolator::new(&machine), &mut simulated, &requests, |tick| {
        if (tick.z_mm - STATION_MM).abs() >= 17.5 {
            return;
        }
        let min = tick.c_rad.map_or_else(|| touch.highest(), |c_rad| touch.at(c_rad));
        let depth_mm = min - tick.x_mm;
        deepest_mm = deepest_mm.max(depth_mm);
        if depth_mm > allowed_mm && fault.is_none() {
            let label = &tick.segment.label;
            fault = Some(format!("tick {}, {label}: {:.3} um; requests {requests:?}", tick.tick, 1e3 * depth_mm));
        }
    });
    match (outcome, fault) {
        (_, Some(fault)) => JobEnd::Gouge(fault),
        (Err(error), None) => JobEnd::Gouge(format!("{error}; requests {requests:?}")),
        (Ok(_), None) => JobEnd::Clean { deepest_mm },
    }
}
