// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Shapes and masses of a machine's links. Sizes of the machine file are used; the rest is for display only.

use super::Frames;
use super::link::{Inertial, Link, LinkSolid, SPINDLE_HEIGHT, Visual};
use camwright::machine::description::{Axis, MachineDescription};
use camwright::machine::fixture::Extent;
use camwright_files::convert::m_from_mm;

const CAST_IRON: [f64; 4] = [0.35, 0.38, 0.40, 1.0];
const SLIDE: [f64; 4] = [0.55, 0.58, 0.60, 1.0];
const STEEL: [f64; 4] = [0.72, 0.74, 0.76, 1.0];
const KEY: [f64; 4] = [0.90, 0.55, 0.10, 1.0];
const WHEEL: [f64; 4] = [0.62, 0.45, 0.30, 1.0];
const INSERT: [f64; 4] = [0.85, 0.70, 0.25, 1.0];

/// A vitrified wheel, and the carbide of an insert (kg/m³).
const WHEEL_DENSITY: f64 = 2300.0;
const CARBIDE_DENSITY: f64 = 14_500.0;

/// Room between the outermost lobe and what the part is held by, if unknown (m).
const HELD_BESIDE: f64 = 0.04;

/// A body of revolution along the part (m).
#[derive(Debug, Clone, Copy)]
struct RevolvedBody {
    from: f64,
    to: f64,
    radius: f64,
}

impl From<Extent> for RevolvedBody {
    fn from(extent: Extent) -> Self {
        let [from, to, radius] = [extent.from_mm, extent.to_mm, extent.radius_mm].map(m_from_mm);
        Self { from, to, radius }
    }
}

impl RevolvedBody {
    fn visual(self, colour: [f64; 4]) -> Visual {
        let solid = LinkSolid::AlongZ { radius: self.radius, length: self.to - self.from };
        Visual { solid, at: [0.0, 0.0, 0.5 * (self.from + self.to)], colour }
    }
}

/// All links, the wheel last.
pub(super) fn links(machine: &MachineDescription, wheel_radius: f64, frames: &Frames) -> Vec<Link> {
    let held = WheelSupport::from_machine(machine);
    vec![
        Link { name: frames.world.clone(), visuals: Vec::new(), inertial: None },
        base(machine, wheel_radius, &held, frames),
        table(machine, &held, frames),
        part(machine, &held, frames),
        head(machine, wheel_radius, frames),
        wheel(machine, wheel_radius, frames),
    ]
}

/// Holder of the part, along its axis.
struct WheelSupport {
    headstock: RevolvedBody,
    tailstock: Option<RevolvedBody>,
}

impl WheelSupport {
    fn from_machine(machine: &MachineDescription) -> Self {
        let (low, high) = stroke(machine, Axis::Z);
        let places = machine.stations.iter().map(|station| m_from_mm(station.position_mm));
        let (first, last) = places.fold((f64::MAX, f64::MIN), |(a, b), place| (a.min(place), b.max(place)));
        let (first, last) = if machine.stations.is_empty() { (low, high) } else { (first, last) };
        let headstock = machine.headstock.map_or_else(
            || RevolvedBody { from: first - HELD_BESIDE - 0.25, to: first - HELD_BESIDE, radius: 0.07 },
            RevolvedBody::from,
        );
        let tailstock = (!machine.is_lathe()).then(|| {
            let beside = || RevolvedBody { from: last + HELD_BESIDE, to: last + HELD_BESIDE + 0.12, radius: 0.04 };
            machine.tailstock.map_or_else(beside, RevolvedBody::from)
        });
        Self { headstock, tailstock }
    }

    /// From the headstock's back to the end of what holds the part.
    fn reach(&self) -> (f64, f64) {
        (self.headstock.from, self.tailstock.map_or(self.headstock.to, |tailstock| tailstock.to))
    }
}

/// Travel of an axis (m); a metre if it is unknown.
fn stroke(machine: &MachineDescription, axis: Axis) -> (f64, f64) {
    let own = machine.axis(axis);
    own.soft_limits.or(own.overtravel).map_or((0.0, 1.0), |(low, high)| (m_from_mm(low), m_from_mm(high)))
}

fn boxed(from: [f64; 3], to: [f64; 3], colour: [f64; 4]) -> Visual {
    let size = [0, 1, 2].map(|i| to[i] - from[i]);
    Visual { solid: LinkSolid::Box(size), at: [0, 1, 2].map(|i| 0.5 * (from[i] + to[i])), colour }
}

fn base(machine: &MachineDescription, wheel_radius: f64, held: &WheelSupport, frames: &Frames) -> Link {
    let (z_low, z_high) = stroke(machine, Axis::Z);
    let (_, x_high) = stroke(machine, Axis::X);
    let (from, to) = held.reach();
    let bed = boxed([-0.22, -SPINDLE_HEIGHT, from - z_high], [0.22, -0.3, to - z_low], CAST_IRON);
    let far = x_high + 2.0 * wheel_radius + 0.45;
    let cross = boxed([0.22, -SPINDLE_HEIGHT, -0.3], [far, -0.3, 0.3], CAST_IRON);
    Link { name: frames.base.clone(), visuals: vec![bed, cross], inertial: None }
}

fn table(machine: &MachineDescription, held: &WheelSupport, frames: &Frames) -> Link {
    let (from, to) = held.reach();
    let slab = boxed([-0.16, -0.28, from], [0.16, -0.2, to], SLIDE);
    let foot =
        |body: RevolvedBody| boxed([-0.6 * body.radius, -0.2, body.from], [0.6 * body.radius, 0.0, body.to], SLIDE);
    let mut visuals = vec![slab.clone()];
    for body in [Some(held.headstock), held.tailstock].into_iter().flatten() {
        visuals.extend([body.visual(SLIDE), foot(body)]);
    }
    let mass = machine.axis(Axis::Z).inertia;
    Link { name: frames.table.clone(), inertial: Some(box_inertial(mass, &slab)), visuals }
}

fn part(machine: &MachineDescription, held: &WheelSupport, frames: &Frames) -> Link {
    let (x_low, _) = stroke(machine, Axis::X);
    // No wheel goes deeper than its soft limit, so the bar stands inside of every lobe.
    let radius = x_low.clamp(0.003, 0.012);
    let (from, to) = match held.tailstock {
        Some(tailstock) => (held.headstock.to, tailstock.from),
        None => (held.headstock.to, held.headstock.to + 0.01),
    };
    let bar = RevolvedBody { from, to, radius };
    // The driver shows where the keyway is, on azimuth 0.
    let driver = boxed([0.0, -0.4 * radius, from], [3.0 * radius, 0.4 * radius, from + 0.01], KEY);
    let moment = machine.axis(Axis::C).inertia;
    // A solid cylinder as thick as the headstock that has this moment.
    let thick = held.headstock.radius;
    let mass = 2.0 * moment / (thick * thick);
    let across = 0.5 * moment + mass * (to - from).powi(2) / 12.0;
    let inertial = Inertial { mass, at: [0.0, 0.0, 0.5 * (from + to)], moments: [across, across, moment] };
    Link { name: frames.part.clone(), visuals: vec![bar.visual(STEEL), driver], inertial: Some(inertial) }
}

fn head(machine: &MachineDescription, wheel_radius: f64, frames: &Frames) -> Link {
    let mass = machine.axis(Axis::X).inertia;
    let r = wheel_radius;
    let visuals = match &machine.insert {
        // Everything lies below the rake face and behind the edge.
        Some(_) => vec![
            boxed([r, -0.12, -0.04], [r + 0.3, -0.02, 0.04], SLIDE),
            boxed([-0.5 * r, -0.12, -0.5 * r], [r, -0.06, 0.5 * r], SLIDE),
        ],
        None => {
            let side = 0.5 * m_from_mm(machine.wheel.width_mm) + 0.004;
            let spindle = LinkSolid::AlongZ { radius: 0.3 * r, length: 0.16 };
            vec![
                boxed([r + 0.1, -0.3, -0.25], [2.0 * r + 0.4, -0.2, 0.25], SLIDE),
                boxed([0.7 * r, -0.2, side + 0.02], [2.0 * r + 0.3, 0.6 * r, side + 0.22], SLIDE),
                Visual { solid: spindle, at: [r, 0.0, side + 0.08], colour: STEEL },
            ]
        }
    };
    Link { name: frames.head.clone(), inertial: Some(box_inertial(mass, &visuals[0])), visuals }
}

fn wheel(machine: &MachineDescription, radius: f64, frames: &Frames) -> Link {
    let (solid, at, colour, density, length) = match &machine.insert {
        Some(_) => {
            let length = 0.5 * radius;
            (LinkSolid::AlongY { radius, length }, [0.0, -0.5 * length, 0.0], INSERT, CARBIDE_DENSITY, length)
        }
        None => {
            let length = m_from_mm(machine.wheel.width_mm);
            (LinkSolid::AlongZ { radius, length }, [0.0; 3], WHEEL, WHEEL_DENSITY, length)
        }
    };
    let mass = density * std::f64::consts::PI * radius * radius * length;
    let (along, across) = (0.5 * mass * radius * radius, mass * (3.0 * radius * radius + length * length) / 12.0);
    let moments = if machine.is_lathe() { [across, along, across] } else { [across, across, along] };
    let inertial = Inertial { mass, at, moments };
    Link { name: frames.wheel.clone(), visuals: vec![Visual { solid, at, colour }], inertial: Some(inertial) }
}

/// A mass spread evenly over a box.
fn box_inertial(mass: f64, body: &Visual) -> Inertial {
    let [x, y, z] = match body.solid {
        LinkSolid::Box(size) => size,
        LinkSolid::AlongZ { radius, length } => [2.0 * radius, 2.0 * radius, length],
        LinkSolid::AlongY { radius, length } => [2.0 * radius, length, 2.0 * radius],
    };
    let moment = |a: f64, b: f64| mass * (a * a + b * b) / 12.0;
    Inertial { mass, at: body.at, moments: [moment(y, z), moment(x, z), moment(x, y)] }
}
