// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Random turned parts: the insert's edge beside the surface, held and slowed at any tick.

use super::JobEnd;
use super::drive::{drive, requests};
use crate::cams::SplitMix64;
use crate::solids::random_lobed;
use camwright::cam::surface::Surface;
use camwright::interpolator::Interpolator;
use camwright::job::turning::{TurningJob, TurningSpeed};
use camwright::machine::description::DriveSettings;
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::reference::lathe;
use camwright::planner::{PlanStart, plan_turning};
use camwright::simulation::Machine;
use camwright::toolpath::insert_path::{InsertFeed, Passes};

const LENGTH_MM: f64 = 8.0;
const PART_ZERO_MM: f64 = 2.0;
/// Depth that is nothing (mm): what an insert path may leave its surface by, and counts of X and C.
const NOTHING_MM: f64 = 1e-4;
/// Points of the edge on either side of its middle.
const EDGE: i32 = 40;

fn job(random: &mut SplitMix64) -> TurningJob {
    let solid = random_lobed(|low, high| random.within(low, high));
    let surface = Surface::solid(solid, 0.0, LENGTH_MM).expect("a solid");
    let bounds = surface.bounds(0.0, LENGTH_MM);
    let bar_radius_mm = bounds.largest_mm + random.within(0.1, 1.0);
    let finish_mm = random.within(0.1, 0.4);
    let stock_mm = bar_radius_mm - bounds.min_mm + finish_mm;
    let feed = random.within(0.2, 0.6);
    TurningJob {
        name: "random".into(),
        surface,
        turned_mm: if random.next().is_multiple_of(2) { (LENGTH_MM, 4.0) } else { (0.0, 4.0) },
        bar_radius_mm,
        part_zero_mm: PART_ZERO_MM,
        passes: Passes { stock_mm, finish_mm, deepest_mm: stock_mm, rough_feed: InsertFeed::AlongZ(0.6) },
        feed: if random.next().is_multiple_of(2) { InsertFeed::AlongZ(feed) } else { InsertFeed::AlongCurve(feed) },
        angles: 360,
        speed: random.one_of(&[TurningSpeed::Fastest, TurningSpeed::Varied]),
        clearance_mm: 1.0,
        rapid_speed_mm_s: 200.0,
    }
}

/// One part, from its seed.
pub(crate) fn judge(seed: u64) -> JobEnd {
    let mut random = SplitMix64(seed);
    let job = job(&mut random);
    let machine = lathe().with_drives(DriveSettings::IDEAL);
    let insert = machine.insert.expect("a lathe");
    let mut simulated = Machine::new(machine.clone(), PersistentState::new(&machine)).expect("a lathe");
    let start = PlanStart { counts: simulated.setpoint().counts, c_homed: false };
    let planned = match plan_turning(&job, &machine, Some(start)) {
        Ok(planned) => planned,
        Err(error) => return JobEnd::Refused(error.to_string()),
    };
    let ticks = planned.plan.segments.iter().map(|segment| segment.ticks).sum();
    let requests = requests(&mut random, ticks);
    let (mut deepest_mm, mut fault) = (f64::NEG_INFINITY, None);
    let reach_mm = job.bar_radius_mm + insert.radius_mm;
    let outcome = drive(&planned.plan, &mut Interpolator::new(&machine), &mut simulated, &requests, |tick| {
        // Outside of that circle the insert is clear of everything that turns, wherever that stands.
        let Some(c_rad) = tick.c_rad else {
            if tick.x_mm < reach_mm {
                fault = Some(format!("tick {}: X at {} mm while C is not homed", tick.tick, tick.x_mm));
            }
            return;
        };
        if tick.x_mm > reach_mm {
            return;
        }
        for point in -EDGE..=EDGE {
            let (s, c) = (f64::from(point) / f64::from(EDGE) * 1.55).sin_cos();
            let (x, y) = (tick.x_mm - insert.radius_mm * c, insert.height_mm);
            let z = tick.z_mm + PART_ZERO_MM - insert.radius_mm * s;
            if (0.0..=LENGTH_MM).contains(&z) {
                let depth_mm = job.surface.radius(c_rad + y.atan2(x), z) - x.hypot(y);
                deepest_mm = deepest_mm.max(depth_mm);
                if depth_mm > NOTHING_MM && fault.is_none() {
                    fault = Some(format!("tick {}: {:.3} um deep; requests {requests:?}", tick.tick, 1e3 * depth_mm));
                }
            }
        }
    });
    match (outcome, fault) {
        (_, Some(fault)) => JobEnd::Gouge(fault),
        (Err(error), None) => JobEnd::Gouge(format!("{error}; requests {requests:?}")),
        (Ok(_), None) => JobEnd::Clean { deepest_mm },
    }
}
