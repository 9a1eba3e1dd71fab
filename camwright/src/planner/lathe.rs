// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! From a job of turning to its plan.
//!
//! ```text
//! insert clear of the bar · home C on the origin detector · driven insert up to speed
//! for each pass:
//!     C to its zero, Z to before the part's end              Position
//!     X to where the path begins, in the air                 Approach
//!     C, X and Z together along the spiral                   Cut
//!     X clear of the bar                                     Retract
//! Z back to the part's end, insert stop                      Return
//! ```
//! The path begins so far before the end of the part that the insert does not touch the bar yet, for C starts from rest there; and it ends
//! a feed beyond what is to be turned, so that every azimuth of it has been passed; there X draws the insert out of the groove that it
//! stands in.
//!
//! A pass turns at constant speed, or at one that varies as the axes allow, from rest to rest, and uses [`MOVE_SHARE`] of what the axes may
//! do: the rest is left to an override that changes, and to a stop on the path.

use super::PlanStart;
use super::error::PlanError;
use super::steps::{PlanSteps, StepSubject};

use crate::cam::surface::Surface;
use crate::job::turning::{TurningJob, TurningSpeed};
use crate::machine::description::{Axis, InsertDescription, MachineDescription};
use crate::math::hermite::{HermiteError, HermiteSpline, Knot};
use crate::math::named::named;
use crate::math::units::{TURN_RAD, deg_from_rad, rpm_from_rad_s, wrap_turn};
use crate::math::work::WorkBudget;
use crate::motion::plan::{Phase, Plan, PlanCommand, SegmentKind, SpiralSegment};
use crate::motion::point_to_point::{MOVE_SHARE, whole_ticks};
use crate::planner::plan_check::{PlanCheckError, PlanReport, check_plan};
use crate::toolpath::insert_clearance::{Clearance, ClearanceMap, Flank, InsertClearanceError, flank_distance_mm};
use crate::toolpath::insert_path::{
    AngleAt, AxisLimits, EngagedEdge, InsertFeed, InsertPath, InsertPathError, PassStep, PathRequest, SpeedBound,
    SpindleLaw, UncutBar,
};
use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;
use thiserror::Error;

/// Distance (mm) between the start of the insert and the first possible contact with the bar.
const AIR_MM: f64 = 0.5;

/// Most knots of all passes together: some hundred bytes each in path, plan and pages, and some microseconds each to find them. The shipped
/// turned cam has less than a tenth of them.
const MAX_KNOTS: u32 = 1_000_000;

/// Angle by which a contact may leave the arc of the edge (deg): the rounding of reported angles.
const EDGE_ROUNDING_DEG: f64 = 0.01;

/// Most looks at the surface for the paths of all passes: seconds of work. A test holds the shipped turned cam, whose insert bridges a hollow,
/// to a tenth of them.
pub const MAX_SURFACE_LOOKS: u64 = 50_000_000;

named! {
    /// Number of a turning job with a range of its own.
    TurningKey {
        Begin = "the z at which turning begins",
        End = "the z at which turning ends",
        BarRadius = "the bar's radius (mm)",
        Clearance = "the clearance (mm)",
        RapidSpeed = "the rapid speed (mm/s)",
        PartZero = "z where Z is 0 (mm)",
        Stock = "the stock (mm)",
    }
}

/// Why a part cannot be turned.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TurningError {
    #[error("the machine grinds with a wheel; turning needs a lathe, which has an insert")]
    NotALathe,
    /// A lathe whose spindle counts up while it turns the part the other way. The edge cuts only what comes towards its rake face, so C would
    /// have to count down all along a spiral; the laws of C count up, since X and Z are functions of the angle that has passed. A drive can
    /// be set to count the other way, and then the description says 1.
    #[error("rotation_sense is -1; a lathe turns its part past the insert while c_axis counts up, which is 1")]
    TurnsBackwards,
    /// A number out of its range.
    #[error("{what} is {value}, it must be {allowed}")]
    OutOfRange { what: TurningKey, value: f64, allowed: String },
    /// The insert finds no path.
    #[error("pass {pass}: {source}")]
    Path {
        /// Pass, from 1.
        pass: usize,
        source: InsertPathError,
    },
    /// The passes make no sense.
    #[error(transparent)]
    Passes(InsertPathError),
    /// More than a plan should hold.
    #[error(
        "the {passes} passes have {knots:.0} angles at which the path is computed, at most {max} are allowed: fewer passes, a larger feed, \
         or fewer angles a turn"
    )]
    TooLong {
        passes: usize,
        /// Angles of all of them.
        knots: f64,
        max: u32,
    },
    /// A speed that the axes do not keep.
    #[error(
        "pass {pass}: the spindle is to turn at {wanted_rpm:.2} 1/min; the axes keep {fastest_rpm:.2} 1/min, for {bound}"
    )]
    TooFast {
        /// Pass, from 1.
        pass: usize,
        /// Speed asked for (1/min).
        wanted_rpm: f64,
        /// Fastest (1/min).
        fastest_rpm: f64,
        /// Bound that limits the speed.
        bound: SpeedBound,
    },
    /// A path that no plan can carry.
    #[error("pass {pass}: {source}")]
    Spline {
        /// Pass, from 1.
        pass: usize,
        source: HermiteError,
    },
    /// No room for a stop on the path.
    #[error("pass {pass}: {} leaves no room for a stop on the path", axis.joint())]
    NoStop {
        /// Pass, from 1.
        pass: usize,
        axis: Axis,
    },
    /// The insert's flank would touch the part, or its edge scrape.
    #[error(transparent)]
    Clearance(#[from] InsertClearanceError),
    /// The job cuts with a part of the edge that is not there.
    #[error(
        "pass {pass} cuts with the insert's edge at {angle_deg:.2} deg, turned to {turned_deg:.1} deg at z = {z_mm:.3} mm; the edge goes from \
         {from_deg:.2} to {to_deg:.2} deg, the job needs {min_deg:.2} to {max_deg:.2} deg: turn the insert in its holder, state another arc, or use \
         a rotating insert with its whole edge"
    )]
    OutsideEdge {
        /// Pass that leaves the arc farthest, from 1.
        pass: usize,
        /// Place on the edge (deg).
        angle_deg: f64,
        /// Turned angle θ (deg), in 0..360.
        turned_deg: f64,
        /// z of that place (mm).
        z_mm: f64,
        /// Arc of the machine (deg).
        from_deg: f64,
        /// End of that arc (deg).
        to_deg: f64,
        /// Arc that all passes need (deg).
        min_deg: f64,
        /// End of that arc (deg).
        max_deg: f64,
    },
    /// A step before or after.
    #[error(transparent)]
    Step(Box<PlanError>),
    /// The forward check does not confirm the plan.
    #[error(transparent)]
    Check(Box<PlanCheckError>),
}

impl From<PlanError> for TurningError {
    fn from(error: PlanError) -> Self {
        Self::Step(Box::new(error))
    }
}

impl From<PlanCheckError> for TurningError {
    fn from(error: PlanCheckError) -> Self {
        Self::Check(Box::new(error))
    }
}

/// One pass as planned.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedPass {
    /// Depth of cut along the section's normal in the rake plane (mm).
    pub depth_mm: f64,
    /// Path of the insert's centre over the turned angle.
    pub path: InsertPath,
    /// Speed law of the spindle, constant or varied, without run-up and run-down.
    pub spindle: SpindleLaw,
    /// Bound of the fastest constant speed; for a varied speed [`SpindleLaw::bounds`] lists the bounds and their shares.
    pub bound: SpeedBound,
    pub turns: f64,
}

impl PlannedPass {
    /// Slowest and fastest speed of the spindle between run-up and run-down (rad/s).
    #[must_use]
    pub fn speed_range_rad_s(&self) -> (f64, f64) {
        self.spindle.range_rad_s
    }
}

/// A part planned to be turned.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedTurning {
    pub plan: Plan,
    pub passes: Vec<PlannedPass>,
    /// Clearance of the insert on the finished part.
    pub clearance: Clearance,
    /// Arc of the insert's edge that cuts in any pass; `None` if no pass cuts.
    pub edge: Option<EngagedEdge>,
    /// Smallest distance of the flank from the surface below the edge (mm), along the last pass.
    pub flank_distance_mm: f64,
    /// Result of the forward check.
    pub report: PlanReport,
    /// Looks at the surface that its paths took; at most [`MAX_SURFACE_LOOKS`] are allowed.
    pub surface_looks: u64,
}

/// Plans a part that is turned. `start` is where the axes stand; without it X and Z are taken to stand clear of the part's end, C unhomed.
///
/// # Errors
/// Everything that cannot be made, in one sentence; nothing has moved.
pub fn plan_turning(
    job: &TurningJob,
    machine: &MachineDescription,
    start: Option<PlanStart>,
) -> Result<PlannedTurning, TurningError> {
    let insert = machine.insert.ok_or(TurningError::NotALathe)?;
    if machine.rotation_sense < 0 {
        return Err(TurningError::TurnsBackwards);
    }
    check(job)?;
    let flank = Flank::from_insert(&insert);
    let (low, high) = job.range_mm();
    let clearance = ClearanceMap::new(&job.surface, low, high, flank)?.check(-insert.height_mm)?;
    let clear_mm = job.clear_mm(insert.radius_mm);
    let mut passes = Vec::new();
    let requests = requests(job, &insert)?;
    let knots: f64 = requests.iter().map(|(_, request)| knots(request)).sum();
    if knots > f64::from(MAX_KNOTS) {
        return Err(TurningError::TooLong { passes: requests.len(), knots, max: MAX_KNOTS });
    }
    let budget = WorkBudget::new(MAX_SURFACE_LOOKS);
    for (index, (depth_mm, request)) in requests.into_iter().enumerate() {
        passes.push(plan_pass(job, machine, index + 1, depth_mm, &request, &budget)?);
    }
    let edge = engaged_edge(job, &insert, &passes)?;
    let counts = |axis: Axis, at: f64| machine.axis(axis).scale.counts(at);
    let first_z_mm = passes.first().map_or(0.0, |pass| pass.path.request().from_mm) - job.part_zero_mm;
    let start = start.unwrap_or_else(|| PlanStart::clear_of_bar(machine, clear_mm, first_z_mm));
    let plan = Plan { job: job.name.clone(), lobes: alloc::vec![job.name.clone()], ..Plan::default() };
    let mut steps = PlanSteps { machine, at: start.counts, ticks: 0, plan };
    let home = StepSubject::part(Phase::Home);
    steps.move_axis(home, Axis::X, counts(Axis::X, clear_mm), None, "insert clear of the bar")?;
    steps.home_headstock(home, start.c_homed)?;
    steps.start_wheel(home);
    for (index, pass) in passes.iter().enumerate() {
        add_pass(&mut steps, job, index + 1, pass, clear_mm)?;
    }
    let back = StepSubject::part(Phase::Return);
    steps.move_axis(back, Axis::Z, counts(Axis::Z, first_z_mm), None, "to before the part's end")?;
    if insert.spindle.is_some() {
        steps.command(back, PlanCommand::WheelStop, "insert stop");
    }
    let plan = steps.done();
    let report = check_plan(&plan, machine, start.counts)?;
    let flank_distance_mm = match passes.last() {
        Some(pass) => flank_distance_mm(&job.surface, &pass.path, &flank)?,
        None => f64::INFINITY,
    };
    Ok(PlannedTurning { plan, passes, clearance, edge, flank_distance_mm, report, surface_looks: budget.spent() })
}

/// Arc of the edge that the passes use, which must lie within that of the insert.
fn engaged_edge(
    job: &TurningJob,
    insert: &InsertDescription,
    passes: &[PlannedPass],
) -> Result<Option<EngagedEdge>, TurningError> {
    let x_mm = in_plane_mm(job.bar_radius_mm, insert);
    let of_pass = |(index, pass): (usize, &PlannedPass)| {
        let depth_mm = (index > 0).then_some(pass.depth_mm);
        let edge = pass.path.engaged_edge(&UncutBar { x_mm, end_mm: job.turned_mm.0, depth_mm })?;
        Some((index + 1, edge))
    };
    let edges: Vec<(usize, EngagedEdge)> = passes.iter().enumerate().filter_map(of_pass).collect();
    let all = edges.iter().map(|(_, edge)| *edge).reduce(EngagedEdge::with);
    let (Some(arc), Some(needed)) = (insert.edge, all) else { return Ok(all) };
    let beyond_rad = |place: &AngleAt| (arc.from_rad - place.angle_rad).max(place.angle_rad - arc.to_rad);
    let places = edges.iter().flat_map(|(pass, edge)| [(*pass, edge.min), (*pass, edge.max)]);
    let farthest = places.max_by(|(_, a), (_, b)| beyond_rad(a).total_cmp(&beyond_rad(b)));
    match farthest.filter(|(_, place)| deg_from_rad(beyond_rad(place)) > EDGE_ROUNDING_DEG) {
        None => Ok(all),
        Some((pass, place)) => Err(TurningError::OutsideEdge {
            pass,
            angle_deg: deg_from_rad(place.angle_rad),
            turned_deg: deg_from_rad(wrap_turn(place.turned_rad)),
            z_mm: place.z_mm,
            from_deg: deg_from_rad(arc.from_rad),
            to_deg: deg_from_rad(arc.to_rad),
            min_deg: deg_from_rad(needed.min.angle_rad),
            max_deg: deg_from_rad(needed.max.angle_rad),
        }),
    }
}

/// x of a radius in the rake plane (mm); 0 where the plane passes beside it.
fn in_plane_mm(radius_mm: f64, insert: &InsertDescription) -> f64 {
    libm::sqrt((radius_mm * radius_mm - insert.height_mm * insert.height_mm).max(0.0))
}

fn check(job: &TurningJob) -> Result<(), TurningError> {
    let (low, high) = job.surface.ends_mm();
    let within = |value: f64| (low..=high).contains(&value);
    let range = alloc::format!("within the part's ends, {low} to {high} mm");
    let positive = || String::from("above 0 and up to 1000 mm");
    let is_length = |value: f64| value > 0.0 && value <= 1000.0;
    let (from_mm, to_mm) = job.turned_mm;
    let (low_mm, high_mm) = job.range_mm();
    let design = job.surface.bounds(low_mm, high_mm);
    for (what, value, is_right, allowed) in [
        (TurningKey::Begin, from_mm, within(from_mm), range.clone()),
        (TurningKey::End, to_mm, within(to_mm) && (to_mm - from_mm).abs() > 0.0, range),
        (TurningKey::BarRadius, job.bar_radius_mm, is_length(job.bar_radius_mm), positive()),
        (TurningKey::Clearance, job.clearance_mm, is_length(job.clearance_mm), positive()),
        (
            TurningKey::RapidSpeed,
            job.rapid_speed_mm_s,
            job.rapid_speed_mm_s > 0.0 && job.rapid_speed_mm_s.is_finite(),
            String::from("above 0"),
        ),
        (TurningKey::PartZero, job.part_zero_mm, job.part_zero_mm.is_finite(), String::from("finite")),
        (
            TurningKey::BarRadius,
            job.bar_radius_mm,
            job.bar_radius_mm >= design.largest_mm,
            alloc::format!("at least {:.4} mm, the part's largest radius", design.largest_mm),
        ),
        (
            TurningKey::Stock,
            job.passes.stock_mm,
            job.passes.stock_mm >= job.bar_radius_mm - design.min_mm,
            alloc::format!(
                "at least {:.4} mm, by which the bar is larger than the part at its least: or a pass would take more than its depth",
                job.bar_radius_mm - design.min_mm
            ),
        ),
    ] {
        if !is_right {
            return Err(TurningError::OutOfRange { what, value, allowed });
        }
    }
    Ok(())
}

/// Depth of each pass and the request for its path.
fn requests(job: &TurningJob, insert: &InsertDescription) -> Result<Vec<(f64, PathRequest)>, TurningError> {
    let (from_mm, to_mm) = job.turned_mm;
    let outward = if to_mm < from_mm { 1.0 } else { -1.0 };
    let request = |PassStep { depth_mm, stock_mm, feed }: PassStep| {
        let air_mm = air_mm(&job.surface, job.bar_radius_mm, from_mm, insert, stock_mm);
        let (InsertFeed::AlongZ(over_mm) | InsertFeed::AlongCurve(over_mm)) = feed;
        let request = PathRequest {
            insert_radius_mm: insert.radius_mm,
            plane_y_mm: insert.height_mm,
            from_mm: from_mm + outward * air_mm,
            to_mm: to_mm - outward * over_mm,
            feed,
            angles: job.angles,
            start_rad: 0.0,
            stock_mm,
        };
        (depth_mm, request)
    };
    Ok(job.passes.steps(job.feed).map_err(TurningError::Passes)?.into_iter().map(request).collect())
}

/// Knots of a path, before it is computed; of a feed that is none not a number, which the path itself refuses.
fn knots(request: &PathRequest) -> f64 {
    let (InsertFeed::AlongZ(feed) | InsertFeed::AlongCurve(feed)) = request.feed;
    (request.to_mm - request.from_mm).abs() / feed * f64::from(request.angles)
}

/// Distance before the part's end at which the insert on its path does not touch the bar yet (mm).
///
/// At a distance d along z its edge lies √(R² − d²) nearer the axis than its centre. Seen in the rake plane the bar reaches √(B² − y₀²), and
/// the centre stands R + stock beyond the section at least, √(r² − y₀²).
fn air_mm(surface: &Surface, bar_mm: f64, end_mm: f64, insert: &InsertDescription, stock_mm: f64) -> f64 {
    let in_plane = |radius_mm: f64| in_plane_mm(radius_mm, insert);
    let radius_mm = insert.radius_mm;
    let min = in_plane(surface.bounds(end_mm - radius_mm, end_mm + radius_mm).min_mm) + radius_mm + stock_mm;
    let room = (min - in_plane(bar_mm)).clamp(0.0, radius_mm);
    libm::sqrt(radius_mm * radius_mm - room * room) + AIR_MM
}

fn plan_pass(
    job: &TurningJob,
    machine: &MachineDescription,
    pass: usize,
    depth_mm: f64,
    request: &PathRequest,
    budget: &WorkBudget,
) -> Result<PlannedPass, TurningError> {
    let wrong = |source| TurningError::Path { pass, source };
    let path = InsertPath::within(&job.surface, request, budget).map_err(wrong)?;
    let limits = |axis: Axis| machine.axis(axis).limits.with_share(MOVE_SHARE);
    let c = limits(Axis::C);
    let max = AxisLimits { x: limits(Axis::X), z: limits(Axis::Z), spindle_rad_s: c.velocity };
    let spindle = match job.speed {
        TurningSpeed::Fastest => path.spindle_law(c.velocity, &max, c),
        TurningSpeed::Constant(wanted_rad_s) => path.spindle_law(wanted_rad_s, &max, c),
        TurningSpeed::Varied => path.varied_spindle_law(&max, c),
    }
    .map_err(wrong)?;
    let bound = spindle.fastest.bound;
    if let TurningSpeed::Constant(wanted_rad_s) = job.speed
        && spindle.rad_s < wanted_rad_s * (1.0 - 1e-9)
    {
        let (wanted_rpm, fastest_rpm) = (rpm_from_rad_s(wanted_rad_s), rpm_from_rad_s(spindle.rad_s));
        return Err(TurningError::TooFast { pass, wanted_rpm, fastest_rpm, bound });
    }
    let turns = (path.x().end() - path.x().start()) / TURN_RAD;
    Ok(PlannedPass { depth_mm, path, spindle, bound, turns })
}

fn add_pass(
    steps: &mut PlanSteps<'_>,
    job: &TurningJob,
    number: usize,
    pass: &PlannedPass,
    clear_mm: f64,
) -> Result<(), TurningError> {
    let machine = steps.machine;
    let of = |phase: Phase| StepSubject {
        phase,
        lobe: Some((0, job.name.as_str())),
        stock_mm: pass.path.request().stock_mm,
    };
    let counts = |axis: Axis, at: f64| machine.axis(axis).scale.counts(at);
    let wrong = |source| TurningError::Spline { pass: number, source };
    let law = pass.spindle.law.clone();
    let stop_ticks = steps.stop_ticks().map_err(|axis| TurningError::NoStop { pass: number, axis })?;
    let (path, advance) = pass.path.laws().map_err(wrong)?;
    let moved = |knot: &Knot| Knot { value: knot.value - job.part_zero_mm, ..*knot };
    let advance = HermiteSpline::new(advance.knots().iter().map(moved).collect()).map_err(wrong)?;
    let (x_counts, z_counts) = (counts(Axis::X, path.sample(0.0).value), counts(Axis::Z, advance.sample(0.0).value));
    let angle_rad = law.knots()[law.knots().len() - 1].value;
    let (x_end, z_end) =
        (counts(Axis::X, path.sample(angle_rad).value), counts(Axis::Z, advance.sample(angle_rad).value));

    // The part's keyway to the insert, by the shorter way on.
    let turn_counts = counts(Axis::C, TURN_RAD);
    let c_at = steps.at[Axis::C.index()];
    let zero_counts = c_at + (-c_at).rem_euclid(turn_counts);
    steps.move_axis(of(Phase::Position), Axis::C, zero_counts, None, "key-way to the insert")?;
    steps.move_axis(of(Phase::Position), Axis::Z, z_counts, None, "to before the part's end")?;
    let rapid = Some(job.rapid_speed_mm_s);
    steps.move_axis(of(Phase::Approach), Axis::X, x_counts, rapid, "insert to its path")?;
    let spiral = SpiralSegment {
        path: steps.plan.angle_laws.len(),
        advance: steps.plan.angle_laws.len() + 1,
        speed: steps.plan.time_laws.len(),
        start_counts: 0,
    };
    let ticks = whole_ticks(law.end(), machine.cycle_time_s());
    let label = alloc::format!("pass {number}, {:.1} turns", pass.turns);
    steps.plan.time_laws.push(law);
    steps.plan.angle_laws.push(path);
    steps.plan.angle_laws.push(advance);
    steps.add(of(Phase::Cut), SegmentKind::Spiral(spiral), ticks, stop_ticks, &label);
    steps.at[Axis::C.index()] = zero_counts + counts(Axis::C, angle_rad);
    steps.at[Axis::X.index()] = x_end;
    steps.at[Axis::Z.index()] = z_end;
    steps.move_axis(of(Phase::Retract), Axis::X, counts(Axis::X, clear_mm), rapid, "insert clear of the bar")?;
    Ok(())
}
