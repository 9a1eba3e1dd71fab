// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Room for the wheel: a plan walked once more, with everything that the wheel must keep away from.
//!
//! Everything is a body of revolution about the spindle axis, so the wheel is clear of it where `x_axis`, the distance of its
//! nearest point from that axis, is larger than the body's radius. The highest place of its rim counts for all of its width:
//!
//! ```text
//!            │ wheel │                     with z_axis at z the wheel faces z ± width/2
//!            └───────┘ ← x_axis
//!   ┌────┐       ┌────────┐
//! ──┤    ├───────┤        ├── spindle axis
//! ```
//!
//! Inside a bore the wheel must be clear of both sides: `x_axis` above minus the smallest radius of the wall that it grinds, and its
//! other side, a diameter of the wheel above `x_axis`, below that radius on the side opposite.

use super::error::PlanError;
use super::lobe::{PlannedLobe, extremes};
use crate::job::grinding::JobSpec;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use crate::machine::fixture::Extent;
use crate::math::hermite::HermiteSpline;
use crate::motion::plan::{CutSegment, Phase, Plan, PlanCommand, Segment, SegmentKind};
use alloc::string::String;
use alloc::vec::Vec;

/// Rounding of positions to counts, and of the path between its knots (mm).
const ROUNDING_MM: f64 = 1e-4;

/// Kinds of bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Body {
    Lobe(usize),
    Obstacle(usize),
    Headstock,
    Tailstock,
    Dresser,
}

/// Walks through a plan from where the axes stand (counts).
///
/// # Errors
/// The first step that brings the wheel too near to something: what, how far it reaches, how far out the wheel must be.
pub(super) fn check_clearance(
    job: &JobSpec,
    machine: &MachineDescription,
    lobes: &[PlannedLobe],
    plan: &Plan,
    start_counts: [i64; AXIS_COUNT],
) -> Result<(), PlanError> {
    let bodies = bodies(job, machine, lobes);
    let position = |axis: Axis, counts: i64| machine.axis(axis).scale.position(counts);
    let mut x_mm = position(Axis::X, start_counts[Axis::X.index()]);
    let mut z_mm = position(Axis::Z, start_counts[Axis::Z.index()]);
    let (mut half_mm, mut rim_mm) = (0.5 * machine.wheel.width_mm, machine.wheel.rim.highest_mm());
    let bores: Vec<Bore> = lobes.iter().enumerate().filter_map(|lobe| Bore::of_lobe(lobe, job, machine)).collect();
    for bore in &bores {
        // Where a hold, a cancel or an alarm takes the wheel from the raw wall.
        let retract_mm = job.retract_clearance_mm.max(machine.retract.clearance_mm);
        let z_mm = (bore.extent.from_mm, bore.extent.to_mm);
        bore.check(job, "retract from the wall", retract_mm - bore.extent.radius_mm, (z_mm, 0.0))?;
    }
    for segment in &plan.segments {
        if let SegmentKind::Command(PlanCommand::ChangeWheel { wheel }) = segment.kind {
            let wheel = machine.wheel_at(wheel as usize);
            (half_mm, rim_mm) = (0.5 * wheel.width_mm, wheel.rim.highest_mm());
        }
        let way = MovePath::from_segment(segment, plan, machine, x_mm, z_mm);
        for bore in &bores {
            if !way.is_beside(&bore.extent, half_mm) {
                bore.check(job, &segment.label, way.max_x_mm, (way.z_mm, rim_mm))?;
            }
        }
        for (body, extent) in &bodies {
            if way.is_beside(extent, half_mm) || is_meant(*body, segment, &way, lobes) {
                continue;
            }
            // The dresser is touched, not cut into.
            let touched = *body == Body::Dresser && segment.phase == Phase::Dress;
            let clearance_mm = if touched { 0.0 } else { job.clearance_mm };
            // The dresser gives the rim its profile.
            let rim_mm = if touched { 0.0 } else { rim_mm };
            if way.min_x_mm - rim_mm < extent.radius_mm + clearance_mm - ROUNDING_MM {
                return Err(PlanError::Collision {
                    step: segment.label.clone(),
                    lobe: segment.lobe,
                    what: describe(*body, job),
                    obstacle: if let Body::Obstacle(index) = body { Some(*index) } else { None },
                    reach_mm: extent.radius_mm,
                    x_mm: way.min_x_mm - rim_mm,
                    z_mm: way.z_mm,
                    clearance_mm,
                });
            }
        }
        (x_mm, z_mm) = (way.last_x_mm, way.last_z_mm);
    }
    Ok(())
}

/// A bore around the wheel.
struct Bore {
    lobe: usize,
    /// Its place along the axis, and the smallest radius of the raw wall.
    extent: Extent,
    /// Diameter of the wheel (mm).
    wheel_mm: f64,
}

impl Bore {
    fn of_lobe((lobe, planned): (usize, &PlannedLobe), job: &JobSpec, machine: &MachineDescription) -> Option<Self> {
        if !planned.design.contour.is_bore() {
            return None;
        }
        // X is minus the radius of the wall.
        let surface = raw_extent(planned, job, machine)?;
        let extent = Extent { radius_mm: -surface.radius_mm, ..surface };
        Some(Self { lobe, extent, wheel_mm: 2.0 * planned.tool_path.wheel_radius_mm() })
    }

    /// Checks the side of the wheel beyond the axis, with X and Z at most at these positions and the rim so high (mm).
    fn check(&self, job: &JobSpec, step: &str, x_mm: f64, (z_mm, rim_mm): ((f64, f64), f64)) -> Result<(), PlanError> {
        let side_mm = x_mm + self.wheel_mm + rim_mm;
        if side_mm <= self.extent.radius_mm - job.clearance_mm + ROUNDING_MM {
            return Ok(());
        }
        Err(PlanError::OppositeWall {
            step: String::from(step),
            lobe: job.lobes[self.lobe].name.clone(),
            radius_mm: self.extent.radius_mm,
            side_mm,
            x_mm,
            z_mm,
            clearance_mm: job.clearance_mm,
        })
    }
}

/// Travel of the wheel in a segment.
struct MovePath {
    min_x_mm: f64,
    max_x_mm: f64,
    z_mm: (f64, f64),
    last_x_mm: f64,
    last_z_mm: f64,
}

impl MovePath {
    fn from_segment(segment: &Segment, plan: &Plan, machine: &MachineDescription, x_mm: f64, z_mm: f64) -> Self {
        let position = |axis: Axis, counts: i64| machine.axis(axis).scale.position(counts);
        let (mut min_x_mm, mut max_x_mm, mut last_x_mm, mut last_z_mm) = (x_mm, x_mm, x_mm, z_mm);
        let mut z_range = (z_mm, z_mm);
        match &segment.kind {
            SegmentKind::Move(targets) => {
                for target in targets {
                    match target.axis {
                        Axis::X => last_x_mm = position(Axis::X, target.target_counts),
                        Axis::Z => last_z_mm = position(Axis::Z, target.target_counts),
                        Axis::C => {}
                    }
                }
                (min_x_mm, max_x_mm) = (min_x_mm.min(last_x_mm), max_x_mm.max(last_x_mm));
            }
            SegmentKind::Search { axis: Axis::Z, input, travel_counts, offset_counts, .. } => {
                let farthest = z_mm + position(Axis::Z, *travel_counts);
                z_range = (z_mm.min(farthest), z_mm.max(farthest));
                if let Some(station) = machine.station(input) {
                    last_z_mm = station.position_mm + position(Axis::Z, *offset_counts);
                }
            }
            SegmentKind::Cut(cut) => {
                if let Some(CutPositions { min_mm, max_mm, last_mm }) = CutPositions::of_cut(plan, cut) {
                    (min_x_mm, max_x_mm, last_x_mm) = (min_mm.min(x_mm), max_mm.max(x_mm), last_mm);
                }
            }
            _ => {}
        }
        z_range = (z_range.0.min(last_z_mm), z_range.1.max(last_z_mm));
        Self { min_x_mm, max_x_mm, z_mm: z_range, last_x_mm, last_z_mm }
    }

    /// The wheel, with half its width (mm), never comes in front of a body.
    fn is_beside(&self, body: &Extent, half_mm: f64) -> bool {
        body.to_mm <= self.z_mm.0 - half_mm || body.from_mm >= self.z_mm.1 + half_mm
    }

    fn moves_table(&self) -> bool {
        self.z_mm.1 > self.z_mm.0
    }
}

/// Positions of X in a cut.
struct CutPositions {
    min_mm: f64,
    /// Upper bound of all positions.
    max_mm: f64,
    last_mm: f64,
}

impl CutPositions {
    /// The path and what the infeed still keeps off it. A lead only takes X farther off.
    fn of_cut(plan: &Plan, cut: &CutSegment) -> Option<Self> {
        let motion = plan.motion_of(cut)?;
        let range = |law: &HermiteSpline| {
            let values = law.knots().iter().map(|knot| knot.value);
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
        };
        let (path, infeed) = (extremes(motion.path), range(motion.infeed));
        let lead_mm = motion.lead.map_or(0.0, |lead| range(lead).1.max(0.0));
        let last_mm = motion.x_mm(motion.end_s());
        Some(Self { min_mm: path.0 + infeed.0, max_mm: path.1 + infeed.1 + lead_mm, last_mm })
    }
}

/// The wheel grinds the lobe that the step is for, with the table at rest before it. A plunge is ground beside and over its neighbours.
fn is_meant(body: Body, segment: &Segment, way: &MovePath, lobes: &[PlannedLobe]) -> bool {
    let (Body::Lobe(body), Some(lobe)) = (body, segment.lobe) else { return false };
    let is_neighbour = || match (lobes.get(body), lobes.get(lobe)) {
        (Some(body), Some(lobe)) => body.design.is_of_one_lobe(&lobe.design),
        _ => false,
    };
    (body == lobe || is_neighbour()) && !way.moves_table()
}

/// A raw lobe as a body of revolution; `None` on a machine without its station.
fn raw_extent(lobe: &PlannedLobe, job: &JobSpec, machine: &MachineDescription) -> Option<Extent> {
    let place_mm = lobe.design.z_mm(machine)?;
    let half_mm = 0.5 * lobe.design.width_mm;
    // X is largest with the farthest point of the contour on the wheel line, and is its radius there.
    let radius_mm = extremes(lobe.tool_path.spline()).1 + job.maximum_stock_mm();
    Some(Extent { from_mm: place_mm - half_mm, to_mm: place_mm + half_mm, radius_mm })
}

fn bodies(job: &JobSpec, machine: &MachineDescription, lobes: &[PlannedLobe]) -> Vec<(Body, Extent)> {
    let of_lobe = |(index, lobe): (usize, &PlannedLobe)| Some((Body::Lobe(index), raw_extent(lobe, job, machine)?));
    let obstacles = job.obstacles.iter().enumerate();
    let own = [
        (Body::Headstock, machine.headstock),
        (Body::Tailstock, machine.tailstock),
        (Body::Dresser, machine.dresser.map(|dresser| dresser.extent())),
    ];
    (lobes.iter().enumerate().filter_map(of_lobe))
        .chain(obstacles.map(|(index, obstacle)| (Body::Obstacle(index), obstacle.extent)))
        .chain(own.into_iter().filter_map(|(body, extent)| Some((body, extent?))))
        .collect()
}

fn describe(body: Body, job: &JobSpec) -> String {
    match body {
        Body::Lobe(index) => alloc::format!("lobe {} with its stock", job.lobes[index].name),
        Body::Obstacle(index) => alloc::format!("obstacle {}", job.obstacles[index].name),
        Body::Headstock => String::from("the headstock"),
        Body::Tailstock => String::from("the tailstock"),
        Body::Dresser => String::from("the dresser"),
    }
}
