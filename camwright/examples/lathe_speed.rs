// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Simulation speed of a lathe, and the form error of its drives: `cargo run --release -p camwright --example lathe_speed [RPM]`.
//!
//! Turns an eccentric (20 mm, 1.5 mm off the axis) of 12 mm length from a bar on one core, as planned and executed tick by tick, 720
//! azimuths and columns 0.02 mm apart: machine seconds per second of the wall clock, and the form error beside the cusps.
#![allow(clippy::print_stdout, clippy::disallowed_methods, reason = "a command that takes the time")]

use camwright::cam::surface::Surface;
use camwright::cam::surface::solid::Solid;
use camwright::interpolator::{Motion, Prepared};
use camwright::job::turning::{TurningJob, TurningSpeed};
use camwright::machine::description::{DriveSettings, Structure};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::reference::lathe;
use camwright::math::units::{rad_s_from_rpm, um_from_mm};
use camwright::planner::plan_turning;
use camwright::simulation::Machine;
use camwright::simulation::closed_loop::ClosedLoop;
use camwright::simulation::turned_part::{FormMap, PartGrid, TurnedPart};
use camwright::toolpath::insert_path::{InsertFeed, Passes};
use std::f64::consts::TAU;
use std::sync::Arc;
use std::time::Instant;

const RADIUS: f64 = 20.0;
const OFF: f64 = 1.5;
const FEED: f64 = 0.1;
const LENGTH: f64 = 12.0;
const BAR: f64 = RADIUS + OFF + 0.3;

fn job(rpm: f64) -> Result<TurningJob, Box<dyn std::error::Error>> {
    let eccentric = Solid::Eccentric { radius_mm: RADIUS, eccentricity_mm: OFF, azimuth_rad: 0.0 };
    // A little more than from the bar to the part at its least.
    let stock_mm = BAR - RADIUS + OFF + 0.1;
    Ok(TurningJob {
        name: "eccentric".into(),
        surface: Surface::solid(eccentric, 0.0, LENGTH)?,
        turned_mm: (LENGTH, 0.0),
        bar_radius_mm: BAR,
        part_zero_mm: 0.0,
        // All in one pass.
        passes: Passes { stock_mm, finish_mm: stock_mm, deepest_mm: stock_mm, rough_feed: InsertFeed::AlongZ(FEED) },
        feed: InsertFeed::AlongZ(FEED),
        angles: 360,
        speed: TurningSpeed::Constant(rad_s_from_rpm(rpm)),
        clearance_mm: 1.0,
        rapid_speed_mm_s: 200.0,
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rpm: f64 = std::env::args().nth(1).map_or(Ok(120.0), |word| word.parse())?;
    let job = job(rpm)?;
    let mut ordinary = lathe();
    for (axis, hertz) in ordinary.axes.iter_mut().zip([180.0, 220.0, 80.0]) {
        axis.drive.structure = Some(Structure { frequency_rad_s: hertz * TAU, damping: 0.04, mass_share: 0.2 });
    }
    for (name, description) in [("ideal", lathe().with_drives(DriveSettings::IDEAL)), ("ordinary", ordinary)] {
        let plan = plan_turning(&job, &description, None)?.plan;
        let grid = PartGrid { azimuths: 720, columns: 601, from_mm: 0.0, to_mm: LENGTH };
        let mut machine = Machine::new(description.clone(), PersistentState::new(&description))?;
        machine.load_turned_part(TurnedPart::round("bar".into(), grid, BAR)?, job.part_zero_mm)?;
        let motion = Prepared::new(Motion::Plan(Arc::new(plan)), &description)?;
        let mut closed_loop = ClosedLoop::direct(machine);
        let (mut ticks, mut volume_mm3) = (0_u32, 0.0);
        let start = Instant::now();
        closed_loop.simulate(Box::new(motion), |_, report| {
            ticks += 1;
            volume_mm3 += report.turned.volume_mm3;
        })?;
        let wall_s = start.elapsed().as_secs_f64();
        let machine_s = f64::from(ticks) * description.cycle_time_s();
        println!(
            "{name} drives: {machine_s:.1} s in {wall_s:.2} s, {:.0} times as fast as time; {:.0} mm³ removed",
            machine_s / wall_s,
            volume_mm3
        );
        let part = closed_loop.machine().turned_part().ok_or("no part")?;
        let map = FormMap::new(part, |azimuth, z| job.surface.point(azimuth, z), 0.0, LENGTH)?;
        println!(
            "  form at {rpm} rpm: {:.3} um below to {:.3} um above the design; cusps {:.3} um, in the rake plane {:.3} um",
            um_from_mm(map.lowest().deviation_mm),
            um_from_mm(map.highest().deviation_mm),
            um_from_mm(map.cusps(FEED).map_or(f64::NAN, |cusps| cusps.mean_mm)),
            um_from_mm(FEED * FEED / (8.0 * description.insert.map_or(f64::NAN, |insert| insert.radius_mm)))
        );
    }
    Ok(())
}
