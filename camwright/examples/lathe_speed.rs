//! How fast a lathe is simulated, and what its drives leave: `cargo run --release -p camwright --example lathe_speed [RPM]`.
//!
//! Turns an eccentric (20 mm, 1.5 mm off the axis) of 12 mm length from a bar on one core, 720 azimuths and columns 0.02 mm apart, with the
//! rake face 14 mm below the axis: machine seconds per second of the wall clock, and the form error beside the cusps.
#![allow(clippy::print_stdout, clippy::disallowed_methods, reason = "a command that takes the time")]

use camwright::machine::Machine;
use camwright::machine::description::{DriveSettings, MachineDescription, Structure};
use camwright::machine::reference::lathe;
use camwright::machine::state::LastingState;
use camwright::machine::turned_part::{FormMap, PartGrid, TurnedPart};
use camwright::setpoint::Setpoint;
use camwright::surface::SurfacePoint;
use std::f64::consts::TAU;
use std::time::Instant;

const RADIUS: f64 = 20.0;
const OFF: f64 = 1.5;
const FEED: f64 = 0.1;
const LENGTH: f64 = 12.0;

fn design(azimuth: f64, _z: f64) -> SurfacePoint {
    let (sin, cos) = azimuth.sin_cos();
    let along = (RADIUS * RADIUS - OFF * OFF * sin * sin).sqrt();
    SurfacePoint {
        radius_mm: OFF * cos + along,
        by_azimuth: -OFF * sin - OFF * OFF * sin * cos / along,
        ..SurfacePoint::default()
    }
}

/// The setpoint of a moment (s), and whether it is the last: C runs up in a second, X and Z follow its angle.
fn setpoint(machine: &MachineDescription, rpm: f64, t: f64) -> (Setpoint, bool) {
    let insert = machine.insert.expect("a lathe");
    let speed = rpm / 60.0 * TAU;
    let (c, v, a) = if t < 1.0 {
        (speed * (t.powi(3) - 0.5 * t.powi(4)), speed * (3.0 * t * t - 2.0 * t.powi(3)), speed * 6.0 * (t - t * t))
    } else {
        (speed * (t - 0.5), speed, 0.0)
    };
    let (sin, cos) = c.sin_cos();
    let above = insert.height_mm + OFF * sin;
    let along = (RADIUS * RADIUS - above * above).sqrt();
    let first = -above * OFF * cos / along;
    let second = (-OFF * OFF * cos * cos + above * OFF * sin - first * first) / along;
    let (x, first, second) = (OFF * cos + along + insert.radius_mm, first - OFF * sin, second - OFF * cos);
    let z = FEED * c / TAU - insert.radius_mm - 0.5;
    let position = [c, x, z];
    let setpoint = Setpoint {
        counts: std::array::from_fn(|i| machine.axes[i].scale.counts(position[i])),
        velocity: [v, first * v, FEED * v / TAU],
        acceleration: [a, first * a + second * v * v, FEED * a / TAU],
    };
    (setpoint, z > LENGTH + insert.radius_mm)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rpm: f64 = std::env::args().nth(1).map_or(Ok(120.0), |word| word.parse())?;
    let mut ordinary = lathe();
    for (axis, hertz) in ordinary.axes.iter_mut().zip([180.0, 220.0, 80.0]) {
        axis.drive.structure = Some(Structure { frequency_rad_s: hertz * TAU, damping: 0.04, mass_share: 0.2 });
    }
    for (name, description) in [("ideal", lathe().with_drives(DriveSettings::IDEAL)), ("ordinary", ordinary)] {
        let grid = PartGrid { azimuths: 720, columns: 601, from_mm: 0.0, to_mm: LENGTH };
        let part = TurnedPart::round("bar".into(), grid, RADIUS + OFF + 0.3)?;
        let mut machine = Machine::new(description.clone(), LastingState::new(&description))?;
        machine.load_turned_part(part, 0.0)?;
        machine.place(setpoint(&description, rpm, 0.0).0.counts);
        let (mut ticks, mut volume_mm3) = (0_u32, 0.0);
        let start = Instant::now();
        loop {
            ticks += 1;
            let (next, is_last) = setpoint(&description, rpm, f64::from(ticks) * description.cycle_time_s());
            volume_mm3 += machine.step(Some(&next), &[], &[]).turned.volume_mm3;
            if is_last || !machine.alarms().is_empty() {
                break;
            }
        }
        let wall_s = start.elapsed().as_secs_f64();
        let machine_s = f64::from(ticks) * description.cycle_time_s();
        println!(
            "{name} drives: {machine_s:.1} s in {wall_s:.2} s, {:.0} times as fast as time; {:.0} mm³ removed",
            machine_s / wall_s,
            volume_mm3
        );
        let part = machine.turned_part().ok_or("no part")?;
        let map = FormMap::new(part, design, 0.0, LENGTH)?;
        let um = |mm: f64| mm * 1e3;
        println!(
            "  form at {rpm} rpm: {:.3} um below to {:.3} um above the design; cusps {:.3} um, in the rake plane {:.3} um",
            um(map.lowest().deviation_mm),
            um(map.highest().deviation_mm),
            um(map.cusps(FEED).map_or(f64::NAN, |cusps| cusps.mean_mm)),
            um(FEED * FEED / (8.0 * description.insert.map_or(f64::NAN, |insert| insert.radius_mm)))
        );
    }
    Ok(())
}
