// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! NC programs of turned parts: written in every dialect, read back, compared with the section itself, and driven by the simulated lathe.
#![allow(clippy::print_stdout, reason = "figures for the reader of --nocapture")]

use super::turning_job::{LENGTH_MM, cam, form, ideal, planned, turned_by};

use camwright::gcode::archimedean::Knots;
use camwright::gcode::post::{
    InsertPassRequest, InsertPostRequest, NcControl, PostError, PostedInsertProgram, ProgramRun, compare_insert,
    post_insert,
};
use camwright::gcode::{
    Dialect, Direction, MotionAction, NcAxis, NumberFormat, ProgramFile, ProgramMotion, Tool, XValues, read,
};
use camwright::job::turning::{TurningJob, TurningSpeed};
use camwright::machine::description::{InsertRotation, InsertSpindle, MachineDescription};
use camwright::motion::plan::{PlanCommand, SegmentKind};
use camwright::planner::program_motion::{ProgramSetup, drivable_shares};
use camwright::planner::{
    PlanStart, PlannedProgram, PlannedTurning, ProgramLobe, ProgramPlanError, ProgramRequest, plan_program,
};
use camwright::toolpath::insert_path::{InsertFeed, PathRequest};

/// Rounding of both ends of a block to four places of mm and degrees, the steepest X being some 10 mm/rad.
const ROUNDING_MM: f64 = 0.5e-4 + 0.5 * 1.75e-6 * 10.0;

fn control(dialect: Dialect, decimals: u32, x_values: XValues, rotation_sense: i8) -> NcControl {
    let format = NumberFormat::new(4, decimals, x_values).expect("a format");
    NcControl { dialect, format, max_blocks_s: 2000.0, path_tolerance_mm: None, rotation_sense }
}

/// The request of a planned job: roughing within 10 um, finishing within a tolerance.
fn request<'a>(
    job: &TurningJob,
    planned: &'a PlannedTurning,
    machine: &MachineDescription,
    control: NcControl,
    tolerance_mm: f64,
) -> InsertPostRequest<'a> {
    let insert = machine.insert.expect("a lathe");
    let last = planned.passes.len() - 1;
    let passes = planned.passes.iter().enumerate().map(|(index, pass)| {
        let tolerance_mm = if index == last { tolerance_mm } else { 0.01 };
        InsertPassRequest {
            name: format!("{}", index + 1),
            path: &pass.path,
            spindle: &pass.spindle,
            speed_share: 1.0,
            tolerance_mm,
            widest_tolerance_mm: tolerance_mm,
            knots: Knots::OnCurve,
        }
    });
    InsertPostRequest {
        name: job.name.clone(),
        number: 1000,
        header: vec!["a turned cam".into()],
        tool: Tool { number: 1, radius_mm: insert.radius_mm, text: "round insert".into() },
        spindle: Some((Direction::Clockwise, 2387)),
        coolant: true,
        control,
        x_shift_mm: 0.0,
        clear_mm: job.clear_mm(insert.radius_mm),
        passes: passes.collect(),
    }
}

fn posted(request: &InsertPostRequest<'_>) -> PostedInsertProgram {
    post_insert(request).unwrap_or_else(|error| panic!("{error}"))
}

fn read_back(request: &InsertPostRequest<'_>, posted: &PostedInsertProgram) -> (ProgramMotion, Vec<ProgramFile>) {
    let control = &request.control;
    let files = control.dialect.write(&posted.program).unwrap_or_else(|error| panic!("{error}"));
    let motion = read(control.dialect, control.format.x_values(), &files).unwrap_or_else(|error| panic!("{error}"));
    (motion, files)
}

fn runs(motion: &ProgramMotion) -> Vec<ProgramRun> {
    let run = |action: MotionAction| match action {
        MotionAction::Rapid(pose) => Some((pose, None)),
        MotionAction::Feed { pose, time_s } => Some((pose, Some(time_s))),
        _ => None,
    };
    let moves = motion.done.iter().filter_map(|done| run(done.action));
    let place = |(pose, time_s): (camwright::gcode::ProgramPose, Option<f64>)| ProgramRun {
        pose: NcAxis::ALL.map(|axis| pose.position(axis).unwrap_or(f64::NAN)),
        time_s,
    };
    moves.map(place).collect()
}

/// X of the centre of a round insert over a section, by trying the section: max over z of x(z) + √(R² − (z − zc)²), where the rake plane
/// y = y₀ meets the surface farthest from the axis, found by bisection.
fn centre_by_trial(job: &TurningJob, path: &PathRequest, turned_rad: f64, z_mm: f64) -> f64 {
    let (y, reach) = (path.plane_y_mm, path.insert_radius_mm + path.stock_mm);
    let section = |z: f64| {
        let outside = |x: f64| x.hypot(y) - job.surface.point(turned_rad + y.atan2(x), z).radius_mm;
        let (mut low, mut high) = (5.0, 40.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if outside(middle) > 0.0 { high = middle } else { low = middle }
        }
        high
    };
    let at = |z: f64| section(z) + (reach * reach - (z - z_mm).powi(2)).max(0.0).sqrt();
    // Coarse, then around the best.
    let (mut best, mut width) = (z_mm, 0.5 * reach);
    for _ in 0..6 {
        let tried = (-20..=20).map(|step| best + width * f64::from(step) / 20.0);
        best = tried.max_by(|a, b| at(*a).total_cmp(&at(*b))).expect("some were tried");
        width *= 0.1;
    }
    at(best)
}

/// Every dialect's program comes back within the tolerance of every pass, with the times of the plan; on LinuxCNC and with diameters, and
/// for a control whose C turns the other way.
#[test]
fn a_turned_part_has_a_program_for_every_control() {
    let (job, machine) = (cam(), ideal());
    let planned = planned(&job, &machine);
    for (dialect, decimals, x_values, sense) in [
        (Dialect::LinuxCnc, 4, XValues::Radius, 1),
        (Dialect::LinuxCnc, 4, XValues::Diameter, -1),
        (Dialect::Siemens, 4, XValues::Diameter, 1),
        (Dialect::Siemens, 5, XValues::Radius, -1),
    ] {
        let what = format!("{dialect:?} {x_values:?} {sense}");
        let mut request = request(&job, &planned, &machine, control(dialect, decimals, x_values, sense), 0.001);
        if x_values == XValues::Diameter {
            request.x_shift_mm = -machine.insert.expect("a lathe").radius_mm;
        }
        if decimals == 5 {
            request.passes.iter_mut().for_each(|pass| pass.knots = Knots::Free);
        }
        let posted = posted(&request);
        let (motion, _) = read_back(&request, &posted);
        let compared = compare_insert(&request, &posted, &runs(&motion)).unwrap_or_else(|error| panic!("{error}"));
        assert!(compared.share_of_tolerance > 0.8 && compared.share_of_tolerance <= 1.0, "{what}: {compared:?}");
        assert_eq!(compared.calls, 3, "{what}");
        assert!(compared.time_error_s < 1e-5, "{what}: {compared:?}");
        let planned_s: f64 = planned.passes.iter().map(|pass| pass.spindle.law.end()).sum();
        assert!((compared.feed_time_s - planned_s).abs() < 1e-4, "{what}: {} {planned_s}", compared.feed_time_s);
        for (pass, plan) in posted.passes.iter().zip(&planned.passes) {
            assert!(
                (pass.blocks as f64) < 1.25 * pass.theoretical_blocks + pass.turns,
                "{what}: {} {}",
                pass.blocks,
                pass.theoretical_blocks
            );
            assert!((pass.turns - plan.turns).abs() < 1e-9);
            assert!(pass.deviation.error_mm <= pass.tolerance_mm);
        }
        // C counts on from pass to pass, in its own direction.
        let c: Vec<f64> = runs(&motion).iter().map(|ran| ran.pose[NcAxis::C.index()]).collect();
        let feeds: Vec<f64> =
            runs(&motion).iter().zip(&c).filter(|(ran, _)| ran.time_s.is_some()).map(|(_, c)| *c).collect();
        assert!(feeds.windows(2).all(|pair| f64::from(sense) * (pair[1] - pair[0]) > 0.0), "{what}");
    }
}

/// The blocks as they were read, between their ends too, against an exact section that shares nothing with the path.
#[test]
fn blocks_keep_their_tolerance_to_the_section_itself() {
    let (job, machine) = (cam(), ideal());
    let planned = planned(&job, &machine);
    let request = request(&job, &planned, &machine, control(Dialect::LinuxCnc, 4, XValues::Radius, 1), 0.001);
    let posted = posted(&request);
    let (motion, _) = read_back(&request, &posted);
    let moves = runs(&motion);
    let mut pass = 0;
    let mut worst_mm = [0.0_f64; 3];
    let mut looked = 0;
    for (index, pair) in moves.windows(2).enumerate() {
        let (from, to) = (&pair[0], &pair[1]);
        if to.time_s.is_none() {
            pass += usize::from(from.time_s.is_some());
            continue;
        }
        // Every seventh block, at places that go through the block.
        if index % 7 != 0 {
            continue;
        }
        let share = 0.05 + 0.9 * ((index / 7) % 10) as f64 / 9.0;
        let at = |axis: NcAxis| from.pose[axis.index()] + share * (to.pose[axis.index()] - from.pose[axis.index()]);
        let turned_rad = at(NcAxis::C) - posted.passes[pass].c_shift_rad;
        let path = planned.passes[pass].path.request();
        let exact_mm = centre_by_trial(&job, path, turned_rad, at(NcAxis::Z));
        worst_mm[pass] = worst_mm[pass].max((at(NcAxis::X) - exact_mm).abs());
        looked += 1;
    }
    println!("off the section: {worst_mm:?} mm in {looked} places");
    assert!(looked > 300, "{looked}");
    for (worst_mm, posted) in worst_mm.iter().zip(&posted.passes) {
        assert!(*worst_mm <= posted.tolerance_mm + 2e-5, "{worst_mm} {}", posted.tolerance_mm);
        assert!(*worst_mm > 0.3 * posted.tolerance_mm, "{worst_mm} {}", posted.tolerance_mm);
    }
}

fn setup(job: &TurningJob, machine: &MachineDescription) -> ProgramSetup {
    ProgramSetup {
        cutter_radius_mm: machine.insert.expect("a lathe").radius_mm,
        x_of_edge: false,
        z_zero_mm: -job.part_zero_mm,
        rotation_sense: 1,
        path_tolerance_mm: 0.001,
    }
}

fn driven(
    job: &TurningJob,
    machine: &MachineDescription,
    read: &(ProgramMotion, Vec<ProgramFile>),
    setup: ProgramSetup,
) -> Result<PlannedProgram, ProgramPlanError> {
    let clear_mm = job.clear_mm(setup.cutter_radius_mm);
    let part = ProgramLobe {
        name: &job.name,
        z_mm: 0.5 * LENGTH_MM - job.part_zero_mm,
        width_mm: LENGTH_MM + 2.0 * setup.cutter_radius_mm,
    };
    let request = ProgramRequest {
        name: &job.name,
        motion: &read.0,
        files: &read.1,
        setup,
        x_clear_mm: Some(clear_mm),
        lobes: &[part],
    };
    plan_program(&request, machine, start(job, machine))
}

fn start(job: &TurningJob, machine: &MachineDescription) -> PlanStart {
    PlanStart::clear_of_bar(machine, job.clear_mm(machine.insert.expect("a lathe").radius_mm), 0.0)
}

/// The simulated lathe drives the program as a plain control does. With ideal drives its part has the cusps of the plan, the tolerance, and
/// what the control rounds off; the edge as X of the program leaves the same part.
#[test]
fn the_simulated_lathe_turns_the_part_by_its_program() {
    let (job, machine) = (cam(), ideal());
    let planned = planned(&job, &machine);
    let own = form(&job, &turned_by(planned.plan.clone(), &job, &machine));
    for (tolerance_mm, of_edge) in [(0.0005, false), (0.002, true)] {
        let mut request =
            request(&job, &planned, &machine, control(Dialect::LinuxCnc, 4, XValues::Radius, 1), tolerance_mm);
        let mut setup = setup(&job, &machine);
        if of_edge {
            (request.x_shift_mm, setup.x_of_edge) = (-setup.cutter_radius_mm, true);
        }
        // At the plan's speed the corners of the finest blocks are too sharp for the limits of the axes.
        let fast = read_back(&request, &posted(&request));
        let shares = drivable_shares(&fast.0, &fast.1, &setup, &machine, start(&job, &machine).counts);
        let shares = shares.unwrap_or_else(|error| panic!("{error}"));
        assert!(shares.iter().all(|share| *share > 0.5 && *share <= 1.0), "{shares:?}");
        if tolerance_mm < 0.001 {
            let refused = driven(&job, &machine, &fast, setup).expect_err("too fast").to_string();
            assert!(refused.contains("cam.ngc, line ") && refused.contains("_axis needs a jerk of"), "{refused}");
            assert!(shares[2] < 1.0, "{shares:?}");
        }
        request.passes.iter_mut().zip(&shares).for_each(|(pass, share)| pass.speed_share = *share);
        let posted = posted(&request);
        let read = read_back(&request, &posted);
        let programmed = driven(&job, &machine, &read, setup).unwrap_or_else(|error| panic!("{error}"));
        let again = drivable_shares(&read.0, &read.1, &setup, &machine, start(&job, &machine).counts);
        assert_eq!(again.expect("shares"), [1.0; 3]);
        println!("shares of the speed {shares:.3?}");
        assert_eq!(programmed.runs.len(), 3);
        let rounding_mm = programmed.runs[2].1.laws.rounding_mm;
        assert!(rounding_mm <= 4.0 * tolerance_mm, "{rounding_mm}");
        let map = form(&job, &turned_by(programmed.plan, &job, &machine));
        let (high, low) = (map.highest().deviation_mm, map.lowest().deviation_mm);
        println!(
            "tolerance {:.2} um, rounding {:.2} um: {:.3} to {:.3} um, the plan {:.3} to {:.3} um",
            1e3 * tolerance_mm,
            1e3 * rounding_mm,
            1e3 * low,
            1e3 * high,
            1e3 * own.lowest().deviation_mm,
            1e3 * own.highest().deviation_mm
        );
        let allowed_mm = tolerance_mm + rounding_mm + ROUNDING_MM;
        assert!(high <= own.highest().deviation_mm + allowed_mm, "{high}");
        assert!(low >= own.lowest().deviation_mm - allowed_mm, "{low}");
        assert!(high > own.highest().deviation_mm - allowed_mm, "{high}");
    }
}

/// M3 is clockwise seen from the spindle, M4 counterclockwise, in every dialect. The lathe drives only the direction of its insert, and a
/// clamped insert is driven by a program without a spindle.
#[test]
fn a_program_turns_the_insert_as_the_machine_does_or_is_refused() {
    let job = TurningJob { speed: TurningSpeed::Constant(2.0), ..cam() };
    let machine = ideal();
    let rotating = |rotation: Option<InsertRotation>| {
        let mut machine = machine.clone();
        let insert = machine.insert.as_mut().expect("a lathe");
        insert.spindle = insert.spindle.zip(rotation).map(|(spindle, rotation)| InsertSpindle { rotation, ..spindle });
        machine.wheel = insert.tool();
        machine
    };
    let (clockwise, counterclockwise) = (InsertRotation::Clockwise, InsertRotation::Counterclockwise);
    let planned = planned(&job, &machine);
    let setup = ProgramSetup { path_tolerance_mm: 0.04, ..setup(&job, &machine) };
    for dialect in [Dialect::LinuxCnc, Dialect::Fanuc, Dialect::Siemens] {
        let program = |direction: Option<Direction>| {
            let control = NcControl { path_tolerance_mm: Some(0.04), ..control(dialect, 3, XValues::Radius, 1) };
            let mut request = request(&job, &planned, &machine, control, 0.01);
            request.spindle = direction.map(|direction| (direction, 2387));
            read_back(&request, &posted(&request))
        };
        for (direction, code) in [(Direction::Clockwise, "M3"), (Direction::Counterclockwise, "M4")] {
            let read = program(Some(direction));
            assert!(read.1[0].text.contains(&format!("S2387 {code}\n")), "{dialect:?}");
            let spindle = MotionAction::SpindleOn { direction, rpm: 2387.0 };
            assert!(read.0.done.iter().any(|done| done.action == spindle), "{dialect:?}");
            let drive = |rotation| {
                driven(&job, &rotating(rotation), &read, setup).map(|_| ()).map_err(|error| error.to_string())
            };
            let (own, other) = match direction {
                Direction::Clockwise => (clockwise, counterclockwise),
                Direction::Counterclockwise => (counterclockwise, clockwise),
            };
            assert_eq!(drive(Some(own)), Ok(()), "{dialect:?}");
            let text = drive(Some(other)).expect_err("the other direction");
            assert!(text.contains(", line ") && text.contains(&format!("({code})")), "{text}");
            assert!(text.contains("insert.rotation of the machine is"), "{text}");
            let text = drive(None).expect_err("a clamped insert");
            assert!(text.contains("the machine's insert does not rotate"), "{text}");
        }
        let read = program(None);
        let text = &read.1[0].text;
        assert!(!["M3\n", "M4\n", "M5"].iter().any(|code| text.contains(code)), "{dialect:?}");
        let clamped =
            driven(&job, &rotating(None), &read, setup).unwrap_or_else(|error| panic!("{dialect:?}: {error}"));
        let is_order =
            |kind: &SegmentKind| matches!(kind, SegmentKind::Command(PlanCommand::WheelStart | PlanCommand::WheelStop));
        assert!(!clamped.plan.segments.iter().any(|segment| is_order(&segment.kind)), "{dialect:?}");
    }
}

/// A varied speed gives blocks of varied times, and the feed along the curve moves Z to and fro.
#[test]
fn blocks_follow_a_varied_speed_and_a_feed_along_the_curve() {
    let machine = ideal();
    let varied = TurningJob { speed: TurningSpeed::Varied, ..cam() };
    let along = TurningJob { feed: InsertFeed::AlongCurve(0.2), ..cam() };
    for (name, job) in [("varied", varied), ("along the curve", along)] {
        let planned = planned(&job, &machine);
        let request = request(&job, &planned, &machine, control(Dialect::LinuxCnc, 4, XValues::Radius, 1), 0.001);
        let posted = posted(&request);
        let moves = runs(&read_back(&request, &posted).0);
        let compared = compare_insert(&request, &posted, &moves).unwrap_or_else(|error| panic!("{error}"));
        assert!(compared.share_of_tolerance <= 1.0, "{name}: {compared:?}");
        let mut since_s = 0.0;
        let law = &planned.passes[2].spindle.law;
        // The last run of feeds: C is where the plan has it at the end of every block.
        let run = moves.rsplit(|ran| ran.time_s.is_none()).find(|run| !run.is_empty()).expect("feeds");
        for ran in run {
            since_s += ran.time_s.expect("a feed");
            let turned_rad = ran.pose[NcAxis::C.index()] - posted.passes[2].c_shift_rad;
            let planned_rad = law.sample(since_s).value;
            assert!((turned_rad - planned_rad).abs() < 1e-4, "{name}, {since_s} s: {turned_rad} {planned_rad}");
        }
    }
}

#[test]
fn what_the_control_cannot_run_is_refused_with_what_would_do() {
    let (job, machine) = (cam(), ideal());
    let planned = planned(&job, &machine);
    let linuxcnc = control(Dialect::LinuxCnc, 4, XValues::Radius, 1);
    let whole = |control: NcControl, tolerance_mm: f64| request(&job, &planned, &machine, control, tolerance_mm);
    let refusal = |request: &InsertPostRequest<'_>| post_insert(request).expect_err("refused").to_string();
    let slow = NcControl { max_blocks_s: 20.0, ..linuxcnc };
    let text = refusal(&whole(slow, 0.001));
    assert!(text.contains("cam, pass 1: ") && text.contains("the control reads 20. It would at "), "{text}");
    let text = refusal(&whole(linuxcnc, 0.00005));
    assert!(text.contains("cam, pass 3: a tolerance of 0.05 um leaves nothing beside"), "{text}");
    // Eight digits: with four decimals of a degree C has 27 turns, the finishing pass turns longer.
    let text = refusal(&whole(control(Dialect::Fanuc, 4, XValues::Radius, 1), 0.01));
    assert!(
        text.contains("turns; with 4 decimals the control has digits for 277.8") || text.contains("blocks a second"),
        "{text}"
    );
    for (request, words) in [
        (InsertPostRequest { passes: Vec::new(), ..whole(linuxcnc, 0.001) }, "the program is empty: no pass"),
        (whole(NcControl { rotation_sense: 0, ..linuxcnc }, 0.001), "the rotation sense is 0; it must be 1 or -1"),
        (whole(linuxcnc, f64::NAN), "the tolerance in mm is NaN; it must be above 0"),
        (InsertPostRequest { clear_mm: f64::NAN, ..whole(linuxcnc, 0.001) }, "the clear position in mm is NaN"),
    ] {
        let text = refusal(&request);
        assert!(text.contains(words), "{text}");
    }
    // A wider tolerance is used where it is allowed.
    let mut request = whole(NcControl { max_blocks_s: 150.0, ..linuxcnc }, 0.0002);
    request.passes.iter_mut().for_each(|pass| pass.widest_tolerance_mm = 0.1);
    let posted = posted(&request);
    let last = posted.passes.last().expect("a pass");
    let (tolerance_mm, blocks_s) = (last.tolerance_mm, last.blocks_s);
    assert!(tolerance_mm > 0.0002 && blocks_s <= 150.0 && blocks_s > 80.0, "{tolerance_mm} {blocks_s}");
}

/// A program that drives something else is found: a block beside the path, a rapid in the part, a pass that is missing.
#[test]
fn a_changed_program_is_found() {
    let (job, machine) = (cam(), ideal());
    let planned = planned(&job, &machine);
    let request = request(&job, &planned, &machine, control(Dialect::LinuxCnc, 4, XValues::Radius, 1), 0.001);
    let posted = posted(&request);
    let moves = runs(&read_back(&request, &posted).0);
    let compared = |moves: &[ProgramRun]| compare_insert(&request, &posted, moves);
    let feeds: Vec<usize> = (0..moves.len()).filter(|index| moves[*index].time_s.is_some()).collect();
    let middle = feeds[feeds.len() - 300];
    for (axis, by, what) in [(NcAxis::X, 0.002, "X"), (NcAxis::Z, 0.002, "Z"), (NcAxis::C, 0.002, "C")] {
        let mut changed = moves.clone();
        changed[middle].pose[axis.index()] += by;
        let share = compared(&changed).unwrap_or_else(|error| panic!("{error}")).share_of_tolerance;
        assert!(share > 1.2, "{what}: {share}");
    }
    let mut changed = moves.clone();
    changed.truncate(feeds[feeds.len() - 300]);
    assert!(matches!(compared(&changed), Err(PostError::OtherAngles { .. })));
    let first_end = feeds.windows(2).find(|pair| pair[1] > pair[0] + 1).expect("two runs")[0];
    let mut changed = moves.clone();
    changed.truncate(first_end + 2);
    assert!(matches!(compared(&changed), Err(PostError::OtherCalls { found: 1, expected: 3 })));
    let mut changed = moves;
    // Back from the bar, and clear of it before the next pass.
    changed[first_end + 1].pose[NcAxis::X.index()] -= 5.0;
    changed[first_end + 2].pose[NcAxis::X.index()] -= 5.0;
    let error = compared(&changed).expect_err("a rapid in the part");
    assert!(matches!(error, PostError::RapidNotClear { .. }), "{error}");
}
