// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A wheel that is dressed within a job: the path follows it, and the part does not notice.

use super::*;
use crate::cam::form::Form;
use crate::job::dressing::{DressReason, DressingSpec};
use crate::machine::fixture::Dresser;
use crate::machine::wheel_state::mm_from_nm;
use crate::motion::plan::PlanCommand;

fn with_dresser() -> MachineDescription {
    let mut machine = machine();
    machine.dresser = Some(Dresser {
        x_mm: 60.0,
        z_mm: 360.0,
        width_mm: 2.0,
        infeed_speed_mm_s: 1.0,
        traverse_speed_mm_s: 10.0,
        dwell_s: 0.2,
        max_depth_mm: 5.0,
    });
    machine
}

/// Short lobes, dressed before the third; 2 mm come off, which no job would, so that a kept path would show.
fn dressed() -> JobSpec {
    let mut job = job();
    job.passes[0].total_infeed_mm = 0.072;
    job.passes[0].infeed_per_block_mm = 0.000_01;
    job.stock_mm = 0.06;
    job.dressing =
        Some(DressingSpec { every_lobes: Some(2), every_parts: None, predicted_error_mm: None, depth_mm: 2.0 });
    job
}

fn plan_on(job: &JobSpec, machine: &MachineDescription) -> PlannedJob {
    plan_job(job, machine, 60.0, None).unwrap_or_else(|error| panic!("{error}"))
}

/// Runs a plan on blanks; largest form error of each lobe (mm), and the machine.
fn form_errors(job: &JobSpec, planned: &PlannedJob, plan: Plan, on: &MachineDescription) -> (Vec<f64>, Machine) {
    let (_, machine) = ground(job, planned, plan, on, |_, _| {});
    let error = |lobe: &PlannedLobe| {
        let radii = machine.part().lobe(&lobe.design.name).expect("it was loaded").radii_mm();
        Form::measure(radii, &lobe.design.contour, lobe.design.phase_rad).expect("radii").largest.deviation_mm
    };
    let errors = planned.lobes.iter().map(error).collect();
    (errors, machine)
}

/// With C turning on, the table at the dresser meanwhile, the lobes come out as they do with C stopping.
#[test]
fn lobes_are_ground_as_exactly_with_c_turning_on_from_one_to_the_next() {
    let (machine, stopping) = (with_dresser(), dressed());
    let turning = JobSpec { c_between_lobes: BetweenLobes::TurnsOn { margin_s: 0.02 }, ..stopping.clone() };
    let [(stops, _), (turns, _)] = [&stopping, &turning].map(|job| {
        let planned = plan_on(job, &machine);
        form_errors(job, &planned, planned.plan.clone(), &machine)
    });
    assert!(turns.iter().all(|error| error.abs() < 3e-4), "{turns:?}");
    for (stops, turns) in stops.iter().zip(&turns) {
        assert!((stops.abs() - turns.abs()).abs() < 5e-5, "{stops} {turns}");
    }
}

#[test]
fn lobes_after_a_dress_are_ground_as_exactly_as_those_before_it() {
    let (machine, job) = (with_dresser(), dressed());
    let planned = plan_on(&job, &machine);
    assert_eq!(planned.plan.paths.len(), 4, "two profiles, two radii");
    assert_eq!(planned.dresses.len(), 1);
    let dress = planned.dresses[0].dress;
    assert_eq!((dress.before_lobe, dress.reason, dress.radius_nm), (2, DressReason::Lobes(2), 58_000_000));
    let (errors, after) = form_errors(&job, &planned, planned.plan.clone(), &machine);
    assert!(errors.iter().all(|error| error.abs() < 3e-4), "{errors:?}");
    assert_eq!(after.lasting().wheel_radius_mm.to_bits(), 58.0_f64.to_bits());
    assert_eq!((after.lasting().dress_count, after.lasting().lobes_since_dress), (1, 2));
}

/// With the old paths the machine grinds the error that the plan predicted.
#[test]
fn a_kept_path_grinds_the_reported_error() {
    let (machine, job) = (with_dresser(), dressed());
    let planned = plan_on(&job, &machine);
    let path_error = planned.dresses[0].kept_path.expect("both radii have paths");
    let mut plan = planned.plan.clone();
    (plan.paths[2], plan.paths[3]) = (plan.paths[0].clone(), plan.paths[1].clone());
    // The same start as before it, to the count, or the cut does not begin.
    let old = plan_job(&JobSpec { dressing: None, ..job.clone() }, &machine, 60.0, None).expect("fits").plan;
    for lobe in [2, 3] {
        let moves = old.segments.iter().filter(|segment| segment.lobe == Some(lobe));
        let mine = plan.segments.iter_mut().filter(|segment| segment.lobe == Some(lobe));
        for (segment, old) in mine.zip(moves) {
            if matches!(segment.kind, SegmentKind::Move(_)) {
                segment.kind = old.kind.clone();
            }
        }
    }
    let (errors, _) = form_errors(&job, &planned, plan, &machine);
    let worst = errors[2..].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    assert!(path_error.error.value > 0.01, "{path_error:?}");
    assert!(
        (worst - path_error.error.value).abs() < 0.05 * path_error.error.value,
        "ground {worst}, reported {path_error:?}"
    );
    assert!(errors[..2].iter().all(|error| error.abs() < 3e-4), "{errors:?}");
}

/// Wear leaves its depth on the part, along the normal and everywhere alike, as predicted.
#[test]
fn wear_grinds_the_error_that_is_predicted() {
    let (mut machine, mut job) = (with_dresser(), dressed());
    machine.wheel.grinding_ratio = Some(5.0);
    // 6.9 mm² wear 3.7 µm: two lobes in 8 µm.
    job.dressing =
        Some(DressingSpec { every_lobes: None, every_parts: None, predicted_error_mm: Some(0.008), depth_mm: 0.01 });
    let planned = plan_on(&job, &machine);
    assert_eq!(planned.dresses.iter().map(|d| d.dress.before_lobe).collect::<Vec<_>>(), [2]);
    assert_eq!(planned.dresses[0].dress.reason, DressReason::PredictedError);
    let (errors, after) = form_errors(&job, &planned, planned.plan.clone(), &machine);
    for (error, lobe) in errors.iter().zip(&planned.lobes) {
        assert!(lobe.wear_mm > 0.002 && lobe.wear_mm <= 0.008, "{}", lobe.wear_mm);
        // The blank here has a little more than its stock on the flanks.
        assert!((error - lobe.wear_mm).abs() < 6e-4, "{error} {}", lobe.wear_mm);
    }
    assert!((after.lasting().wheel_wear_mm - planned.lobes[3].wear_mm).abs() < 6e-4);
}

/// Roller radius = wheel radius: X = base + roller + lift − wheel = base + lift, for each radius its own only there.
#[test]
fn a_wheel_dressed_to_the_rollers_radius_follows_the_lift() {
    let mut machine = with_dresser();
    machine.wheel.min_radius_mm = 5.0;
    let mut job = dressed();
    job.dressing = job.dressing.map(|dressing| DressingSpec { depth_mm: 1.5, ..dressing });
    let planned = plan_job(&job, &machine, 11.5, None).unwrap_or_else(|error| panic!("{error}"));
    for (index, lobe) in planned.lobes.iter().enumerate() {
        let lift = &job.profiles[job.lobes[index].profile].lift;
        let apart = (0..720)
            .map(|i| rad_from_deg(f64::from(i) * 0.5))
            .map(|angle| (lobe.tool_path.sample(angle).value - (16.0 + lift.sample(angle).value)).abs());
        let apart = apart.fold(0.0, f64::max);
        if index < 2 {
            assert!(apart > 1e-3, "{apart}");
        } else {
            assert!(apart < 1e-8, "{apart}");
        }
    }
}

/// The steps of a dress, in their order, and the table only moves with the wheel at home or passing the dresser.
#[test]
fn the_steps_of_a_dress_are_whole() {
    let machine = with_dresser();
    let planned = plan_on(&dressed(), &machine);
    let segments = &planned.plan.segments;
    assert!(matches!(segments[0].kind, SegmentKind::Command(PlanCommand::ExpectWheel { radius_nm: 60_000_000 })));
    let steps: Vec<&SegmentKind> = segments.iter().filter(|s| s.phase == Phase::Dress).map(|s| &s.kind).collect();
    assert_eq!(steps.len(), 9);
    assert!(matches!(steps[4], SegmentKind::Command(PlanCommand::Dress { radius_nm: 58_000_000 })), "{:?}", steps[4]);
    let first = segments.iter().position(|s| s.phase == Phase::Dress).expect("a dress");
    assert_eq!((segments[first - 1].lobe, segments[first + 9].lobe), (Some(1), Some(2)));
    assert_eq!(segments[first - 1].phase, Phase::Retract);
    assert_eq!(segments[first + 9].phase, Phase::Index);
    // A job that is not dressed only makes sure of its wheel.
    let plain = plan_job(&job(), &machine, 60.0, None).expect("fits").plan;
    assert_eq!(plain.segments[1..], super::planned(&job()).plan.segments[..]);
}

#[test]
fn the_walk_sees_a_path_that_is_kept_over_a_dress_and_a_dress_elsewhere() {
    let machine = with_dresser();
    let good = plan_on(&dressed(), &machine).plan;
    let start = [0, 15_000_000, 0];
    check_plan(&good, &machine, start).expect("as planned");
    let broken = |change: &dyn Fn(&mut Plan)| {
        let mut plan = good.clone();
        change(&mut plan);
        check_plan(&plan, &machine, start).expect_err("tampered with").to_string()
    };
    let text = broken(&|plan| {
        for segment in &mut plan.segments {
            if let (Some(2), SegmentKind::Cut(cut)) = (segment.lobe, &mut segment.kind) {
                cut.path = 0;
            }
        }
    });
    assert!(text.contains("it uses path 0 again, which was used before the wheel was dressed"), "{text}");
    let at = good.segments.iter().position(|s| matches!(s.kind, SegmentKind::Command(PlanCommand::Dress { .. })));
    let at = at.expect("a dress");
    let text = broken(&|plan| plan.segments.swap(at, at - 1));
    assert!(text.contains("where no dresser is"), "{text}");
    let text =
        broken(&|plan| plan.segments[at].kind = SegmentKind::Command(PlanCommand::Dress { radius_nm: 39_000_000 }));
    assert!(text.contains("the wheel is dressed to 39 mm; it must have at least 40 mm and less than 60 mm"), "{text}");
}

/// The machine refuses a plan for another wheel before anything moves, and a dress that would not touch or cut too deep.
#[test]
fn a_plan_for_another_wheel_is_stopped_before_it_moves() {
    let description = with_dresser();
    let plan = plan_on(&dressed(), &description).plan;
    let lasting = PersistentState { wheel_radius_mm: 59.9, ..PersistentState::new(&description) };
    let machine = Machine::new(description.clone(), lasting).expect("a machine");
    let before = machine.setpoint();
    let motion = Prepared::new(Motion::Plan(Arc::new(plan)), &description).unwrap_or_else(|error| panic!("{error}"));
    let mut closed_loop = ClosedLoop::direct(machine);
    let error = closed_loop.simulate(Box::new(motion), |_, _| {});
    let machine = closed_loop.machine();
    let text = error.expect_err("another wheel").to_string();
    assert_eq!(text, "alarm 104: wheel radius 59.9000 mm, the plan is for 60.0000 mm");
    assert_eq!(machine.setpoint().counts, before.counts);
    assert_eq!(machine.lasting().wheel_radius_mm.to_bits(), 59.9_f64.to_bits());
}

#[test]
fn a_dress_away_from_the_dresser_leaves_the_wheel_as_it_is() {
    let description = with_dresser();
    let mut machine = Machine::new(description.clone(), PersistentState::new(&description)).expect("a machine");
    machine.place([0, 10_000_000, 0]);
    let report = machine.step(None, &[crate::simulation::MachineCommand::Dress { radius_nm: 59_900_000 }], &[]);
    let alarm = report.raised.first().expect("an alarm");
    assert_eq!(alarm.to_string(), "the wheel of radius 60.0000 mm was not dressed to 59.9000 mm");
    let wheel = machine.lasting().wheel();
    assert_eq!((wheel.radius_mm.to_bits(), machine.lasting().dress_count), (mm_from_nm(60_000_000).to_bits(), 0));
}

#[test]
fn a_spindle_too_slow_for_a_smaller_wheel_is_refused() {
    let mut machine = with_dresser();
    // 80 m/s at 60 mm are 12732.4 rpm, at 58 mm 13171.4 rpm.
    machine.wheel.max_speed_rad_s = Some(rad_s_from_rpm(13_000.0));
    let error = plan_job(&dressed(), &machine, 60.0, None).map(|_| ()).expect_err("too fast");
    assert_eq!(
        error.to_string(),
        "lobe I2: a wheel of radius 58.0000 mm turns at 13171.4 rpm for its surface speed of 80 m/s; its spindle is allowed \
         13000.0 rpm"
    );
}
