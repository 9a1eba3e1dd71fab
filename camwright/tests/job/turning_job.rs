// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A part that is not round, from its job to the finished surface: planned, turned by the interpolator on a simulated lathe, and compared
//! with its design.
#![allow(clippy::print_stdout, reason = "figures for the reader of --nocapture")]

use crate::solids;

use camwright::cam::surface::Surface;
use camwright::cam::surface::cams::CamAlong;
use camwright::interpolator::{Motion, MotionOutcome, Prepared};
use camwright::job::turning::{TurningJob, TurningSpeed};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{DriveSettings, EdgeArc, InsertDescription, MachineDescription};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::reference::{cam_grinder, lathe};
use camwright::math::units::TURN_RAD;
use camwright::motion::plan::{Plan, PlanCommand, SegmentKind};
use camwright::planner::{PlannedTurning, TurningError, TurningKey, plan_turning};
use camwright::simulation::closed_loop::ClosedLoop;
use camwright::simulation::turned_part::{FormMap, PartGrid, TurnedPart};
use camwright::simulation::{Machine, MachineCommand};
use camwright::toolpath::insert_clearance::InsertClearanceError;
use camwright::toolpath::insert_path::{InsertFeed, Passes};
use std::sync::Arc;

pub(crate) const LENGTH_MM: f64 = 4.0;
const LIFT_MM: f64 = 3.0;
const FEED_MM: f64 = 0.2;

/// A cam of 20 mm base radius, turned from a bar that just holds it: two roughing passes, then finishing.
pub(crate) fn cam() -> TurningJob {
    let contour = solids::raised_cosine(LIFT_MM);
    let surface = Surface::cams(&[CamAlong { contour: &contour, phase_rad: 0.5, from_mm: 0.0, to_mm: LENGTH_MM }]);
    TurningJob {
        name: "cam".into(),
        surface: surface.expect("a cam"),
        turned_mm: (LENGTH_MM, 0.0),
        bar_radius_mm: 23.2,
        part_zero_mm: 2.0,
        passes: Passes { stock_mm: 3.4, finish_mm: 0.4, deepest_mm: 1.5, rough_feed: InsertFeed::AlongZ(0.4) },
        feed: InsertFeed::AlongZ(FEED_MM),
        angles: 360,
        speed: TurningSpeed::Fastest,
        clearance_mm: 1.0,
        rapid_speed_mm_s: 200.0,
    }
}

pub(crate) fn ideal() -> MachineDescription {
    lathe().with_drives(DriveSettings::IDEAL)
}

pub(crate) fn planned(job: &TurningJob, machine: &MachineDescription) -> PlannedTurning {
    plan_turning(job, machine, None).unwrap_or_else(|error| panic!("{error}"))
}

/// The part after the job, on a machine that begins anywhere; turns of the spindle that the machine made.
fn turned(job: &TurningJob, machine: &MachineDescription) -> TurnedPart {
    turned_by(planned(job, machine).plan, job, machine)
}

/// The part of a job after a plan.
pub(crate) fn turned_by(plan: Plan, job: &TurningJob, machine: &MachineDescription) -> TurnedPart {
    let mut lathe = Machine::new(machine.clone(), PersistentState::new(machine)).expect("a lathe");
    let grid = PartGrid { azimuths: 720, columns: 401, from_mm: 0.0, to_mm: job.turned_mm.0 };
    let bar = TurnedPart::round("bar".into(), grid, job.bar_radius_mm).expect("a bar");
    lathe.load_turned_part(bar, job.part_zero_mm).expect("a lathe");
    let motion = Prepared::new(Motion::Plan(Arc::new(plan)), machine).unwrap_or_else(|error| panic!("{error}"));
    let mut closed_loop = ClosedLoop::direct(lathe);
    let done = closed_loop.simulate(Box::new(motion), |_, _| {});
    assert_eq!(done.unwrap_or_else(|error| panic!("{error}")).outcome, MotionOutcome::Completed);
    closed_loop.machine().turned_part().expect("it was loaded").clone()
}

pub(crate) fn form(job: &TurningJob, part: &TurnedPart) -> FormMap {
    // The insert stands over the end of what is turned: its groove goes out by its own radius.
    FormMap::new(part, |azimuth, z| job.surface.point(azimuth, z), 0.0, LENGTH_MM).expect("a map")
}

/// The remaining error is the cusps of the feed, plus half a count of X and C and the interpolation of the sweep.
#[test]
fn ideal_drives_leave_the_cusps_of_the_feed_and_nothing_else() {
    let (job, machine) = (cam(), ideal());
    let map = form(&job, &turned(&job, &machine));
    let path = &planned(&job, &machine).passes[2].path;
    let cusp_mm = path.highest_cusp(&job.surface, 0.0, LENGTH_MM).expect("a cusp").height_mm;
    let (high, low) = (map.highest(), map.lowest());
    println!(
        "ideal drives: {:.3} to {:.3} um, highest cusp in theory {:.3} um",
        1e3 * low.deviation_mm,
        1e3 * high.deviation_mm,
        1e3 * cusp_mm
    );
    assert!((high.deviation_mm - cusp_mm).abs() < 2e-5 && low.deviation_mm > -2e-5, "{low:?} {high:?} {cusp_mm}");
}

/// They lag: some micrometres, which good ones would not leave.
#[test]
fn ordinary_drives_leave_more_than_the_cusps() {
    let job = cam();
    let map = form(&job, &turned(&job, &lathe()));
    println!("ordinary drives: {:.2} to {:.2} um", 1e3 * map.lowest().deviation_mm, 1e3 * map.highest().deviation_mm);
    assert!(map.largest_mm() > 1e-3 && map.largest_mm() < 1e-2, "{}", map.largest_mm());
}

/// A cylinder of 20 mm, cut as the cam is.
fn cylinder() -> TurningJob {
    let cylinder = Surface::solid(solids::CYLINDER, 0.0, LENGTH_MM).expect("a cylinder");
    TurningJob { surface: cylinder, ..cam() }
}

/// A lathe whose insert is changed; a clamped one has nothing to rotate.
fn with_insert(change: impl Fn(&mut InsertDescription)) -> MachineDescription {
    let mut machine = ideal();
    let insert = machine.insert.as_mut().expect("a lathe");
    change(insert);
    machine.wheel = insert.tool();
    assert_eq!(machine.validate(), Ok(()));
    machine
}

/// In the rake plane the first pass of a cylinder stands X = √(r² − H²) + 1.9 mm + R beside the axis and meets the bar √(B² − H²) at
/// acos((X − √(B² − H²))/R) on the side of the feed, −z; the cusps of its feed lie asin(f/2R) on the other side.
#[test]
fn the_edge_that_a_job_uses_must_be_there() {
    let job = cylinder();
    let whole = planned(&job, &ideal());
    let edge = whole.edge.expect("it cuts");
    let (radius_mm, in_plane) = (8.0_f64, |radius: f64| (radius * radius - 14.0 * 14.0).sqrt());
    let ahead = ((in_plane(20.0) + 1.9 + radius_mm - in_plane(23.2)) / radius_mm).acos();
    let behind = (0.5 * 0.4 / radius_mm).asin();
    assert!((edge.min.angle_rad + ahead).abs() < 1e-6 && (edge.max.angle_rad - behind).abs() < 1e-6, "{edge:?}");
    let arc = |from: f64, to: f64| {
        let (from_rad, to_rad) = (from.to_radians(), to.to_radians());
        with_insert(|insert| insert.edge = Some(EdgeArc { from_rad, to_rad }))
    };
    let (ahead, behind) = (ahead.to_degrees(), behind.to_degrees());
    assert_eq!(planned(&job, &arc(-ahead - 0.1, behind + 0.1)).plan, whole.plan, "the arc moves nothing");
    for (from, to, wanted) in [(-ahead + 0.1, 90.0, -ahead), (-90.0, behind - 0.1, behind)] {
        let error = plan_turning(&job, &arc(from, to), None).expect_err("too short an arc");
        let TurningError::OutsideEdge { pass, angle_deg, from_deg, to_deg, min_deg, max_deg, .. } = error else {
            panic!("{error}")
        };
        // Both roughing passes have the same cusps.
        assert!(pass == 1 || (pass == 2 && wanted > 0.0), "{pass}");
        assert!((angle_deg - wanted).abs() < 1e-4 && (from_deg - from).abs() < 1e-9 && (to_deg - to).abs() < 1e-9);
        assert!((min_deg + ahead).abs() < 1e-4 && (max_deg - behind).abs() < 1e-4, "{min_deg} {max_deg}");
        let text = error.to_string();
        assert!(text.contains("turn the insert in its holder") && text.contains("z = "), "{text}");
    }
}

/// The same part as with the driven insert, without an order to a spindle; nothing touches at rest that should not.
#[test]
fn a_clamped_insert_turns_the_same_part_and_starts_nothing() {
    let (job, driven) = (cam(), ideal());
    let clamped = with_insert(|insert| insert.spindle = None);
    let orders = |plan: &Plan| {
        let is_order =
            |kind: &SegmentKind| matches!(kind, SegmentKind::Command(PlanCommand::WheelStart | PlanCommand::WheelStop));
        plan.segments.iter().filter(|segment| is_order(&segment.kind)).count()
    };
    let (with, without) = (planned(&job, &driven).plan, planned(&job, &clamped).plan);
    assert_eq!((orders(&with), orders(&without)), (2, 0));
    assert!(without.duration_s < with.duration_s - 0.9, "{} {}", without.duration_s, with.duration_s);
    let (own, other) = (form(&job, &turned_by(with, &job, &driven)), form(&job, &turned_by(without, &job, &clamped)));
    let off_mm = |a: f64, b: f64| (a - b).abs();
    assert!(off_mm(own.highest().deviation_mm, other.highest().deviation_mm) < 2e-5);
    assert!(off_mm(own.lowest().deviation_mm, other.lowest().deviation_mm) < 2e-5);
}

/// An order to rotate a clamped insert is an alarm: no spindle would answer it.
#[test]
fn a_clamped_insert_cannot_be_started() {
    let clamped = with_insert(|insert| insert.spindle = None);
    let mut machine = Machine::new(clamped.clone(), PersistentState::new(&clamped)).expect("a lathe");
    machine.step(None, &[MachineCommand::WheelStart], &[]);
    let is_raised = machine.alarms().iter().any(|alarm| alarm.kind == AlarmKind::WheelStopped);
    assert!(is_raised && !machine.orders().wheel_runs);
}

/// On a cylinder of radius r an insert H above centre clears by γ − asin(H/r): with 4° asked for it may stand r·sin(γ − 4°) above.
#[test]
fn an_insert_a_little_above_centre_turns_a_cylinder() {
    let job = cylinder();
    for relief_deg in [7.0_f64, 15.0] {
        let max_mm = 20.0 * (relief_deg - 4.0).to_radians().sin();
        let at = |height_mm: f64| {
            with_insert(|insert| (insert.height_mm, insert.relief_rad) = (height_mm, relief_deg.to_radians()))
        };
        let machine = at(max_mm - 1e-3);
        let map = form(&job, &turned(&job, &machine));
        let cusp_mm = FEED_MM * FEED_MM / 8.0 / 8.0;
        assert!(map.highest().deviation_mm < 1.2 * cusp_mm && map.lowest().deviation_mm > -2e-5, "{relief_deg}");
        let error = plan_turning(&job, &at(max_mm + 0.01), None).expect_err("the flank touches");
        let TurningError::Clearance(InsertClearanceError::FlankTouches { clearance_deg, .. }) = error else {
            panic!("{error}")
        };
        let exact_deg = relief_deg - ((max_mm + 0.01) / 20.0).asin().to_degrees();
        assert!((clearance_deg - exact_deg).abs() < 1e-6, "{clearance_deg} {exact_deg}");
    }
}

#[test]
fn passes_take_what_they_say_and_a_plan_ends_where_it_began() {
    let (job, machine) = (cam(), ideal());
    let plan = planned(&job, &machine);
    let depths: Vec<f64> = plan.passes.iter().map(|pass| pass.depth_mm).collect();
    assert_eq!(depths.len(), 3);
    assert!(depths.iter().zip([1.5, 1.5, 0.4]).all(|(depth, wanted)| (depth - wanted).abs() < 1e-12), "{depths:?}");
    let spirals = plan.plan.segments.iter().filter(|segment| matches!(segment.kind, SegmentKind::Spiral(_))).count();
    assert_eq!(spirals, 3);
    assert!(plan.report.max_ratio() <= 1.0 + 1e-6);
    assert!(plan.plan.duration_s > plan.passes.iter().map(|pass| pass.spindle.law.end()).sum::<f64>());
    for pass in &plan.passes {
        // At constant speed the spiral takes its turns, and half of the run-up and the run-down more.
        let wanted_s = pass.turns * TURN_RAD / pass.spindle.rad_s + pass.spindle.ramp_s;
        assert!((pass.spindle.law.end() - wanted_s).abs() < 1e-9, "{} {wanted_s}", pass.spindle.law.end());
    }
}

#[test]
fn a_slower_spindle_is_kept_and_a_faster_one_refused_with_what_it_would_exceed() {
    let machine = ideal();
    let fastest = planned(&cam(), &machine).passes[2].spindle.rad_s;
    let slow = TurningJob { speed: TurningSpeed::Constant(0.5 * fastest), ..cam() };
    assert!((planned(&slow, &machine).passes[2].spindle.rad_s - 0.5 * fastest).abs() < 1e-12);
    let fast = TurningJob { speed: TurningSpeed::Constant(1.1 * fastest), ..cam() };
    let error = plan_turning(&fast, &machine, None).expect_err("too fast");
    assert!(matches!(error, TurningError::TooFast { .. }), "{error}");
    assert!(error.to_string().contains("1/min, for the limit of the spindle"), "{error}");
}

#[test]
fn a_part_that_this_machine_cannot_turn_is_refused_with_its_reason() {
    let machine = ideal();
    let refused =
        |job: &TurningJob, machine: &MachineDescription| plan_turning(job, machine, None).expect_err("refused");
    assert_eq!(refused(&cam(), &cam_grinder()), TurningError::NotALathe);
    let backwards = MachineDescription { rotation_sense: -1, ..machine.clone() };
    assert_eq!(refused(&cam(), &backwards), TurningError::TurnsBackwards);
    for height_mm in [0.0, 14.0] {
        let high = machine.clone().with_rake_height(height_mm).expect("within its range");
        let error = refused(&cam(), &high);
        assert!(
            matches!(error, TurningError::Clearance(InsertClearanceError::FlankTouches { .. })),
            "{height_mm}: {error}"
        );
    }
    for (job, what) in [
        (TurningJob { bar_radius_mm: 22.0, ..cam() }, TurningKey::BarRadius),
        (TurningJob { bar_radius_mm: f64::NAN, ..cam() }, TurningKey::BarRadius),
        (TurningJob { turned_mm: (LENGTH_MM + 1.0, 0.0), ..cam() }, TurningKey::Begin),
        (TurningJob { turned_mm: (1.0, 1.0), ..cam() }, TurningKey::End),
        (TurningJob { clearance_mm: 0.0, ..cam() }, TurningKey::Clearance),
        (TurningJob { rapid_speed_mm_s: -1.0, ..cam() }, TurningKey::RapidSpeed),
        (TurningJob { part_zero_mm: f64::INFINITY, ..cam() }, TurningKey::PartZero),
        (TurningJob { passes: Passes { stock_mm: 3.0, ..cam().passes }, ..cam() }, TurningKey::Stock),
    ] {
        match refused(&job, &machine) {
            TurningError::OutOfRange { what: found, .. } => assert_eq!(found, what),
            other => panic!("{what}: {other}"),
        }
    }
    let passes = Passes { deepest_mm: 1e-9, ..cam().passes };
    assert!(matches!(refused(&TurningJob { passes, ..cam() }, &machine), TurningError::Passes(_)));
    let passes = Passes { deepest_mm: 0.004, rough_feed: InsertFeed::AlongZ(0.01), ..cam().passes };
    let error = refused(&TurningJob { passes, ..cam() }, &machine);
    assert!(matches!(error, TurningError::TooLong { passes: 751, max: 1_000_000, .. }), "{error}");
    let far = TurningJob { part_zero_mm: 1e5, ..cam() };
    assert!(matches!(refused(&far, &machine), TurningError::Check(_)), "beyond Z's soft limit");
}

fn low_and_high_cam() -> TurningJob {
    TurningJob {
        surface: solids::low_and_high_cam(),
        turned_mm: (12.0, 1.0),
        bar_radius_mm: 24.7,
        passes: Passes { stock_mm: 4.9, finish_mm: 0.4, deepest_mm: 4.6, rough_feed: InsertFeed::AlongZ(0.4) },
        ..cam()
    }
}

/// The gain of a varied speed is reported; the part is the same. On one cam the spindle's own limit is active everywhere.
#[test]
fn a_spindle_whose_speed_varies_turns_the_same_part_sooner() {
    let machine = ideal();
    for (name, job, gain) in [("a cam", cam(), 1.01), ("a low and a high cam", low_and_high_cam(), 6.0)] {
        let varied = TurningJob { speed: TurningSpeed::Varied, ..job.clone() };
        let (constant, planned) = (planned(&job, &machine), planned(&varied, &machine));
        for (before, pass) in constant.passes.iter().zip(&planned.passes) {
            let (low, high) = pass.speed_range_rad_s();
            println!(
                "{name}: {:.2} s at {low:.2} to {high:.2} rad/s instead of {:.2} s at {:.2} rad/s: {:?}",
                pass.spindle.law.end(),
                before.spindle.law.end(),
                before.spindle.rad_s,
                pass.spindle.bounds
            );
            assert!(before.spindle.law.end() > gain * pass.spindle.law.end());
            assert_eq!(before.speed_range_rad_s(), (before.spindle.rad_s, before.spindle.rad_s));
            assert_eq!((before.bound, before.path.accuracy()), (pass.bound, pass.path.accuracy()));
        }
        assert!(planned.report.max_ratio() <= 1.0 + 1e-6);
        let grid = |part: &TurnedPart| {
            let (from, to) = job.turned_mm;
            let design = |azimuth, z| job.surface.point(azimuth, z);
            FormMap::new(part, design, from.min(to), from.max(to)).expect("a map")
        };
        let map = grid(&turned(&varied, &machine));
        println!("{name}: {:.3} to {:.3} um", 1e3 * map.lowest().deviation_mm, 1e3 * map.highest().deviation_mm);
        assert!(map.lowest().deviation_mm > -1e-4, "{:?}", map.lowest());
    }
}
