// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A machine with a changer: wheels by lobe and by pass, the steps of a change, and what is refused.

use super::*;
use crate::job::grinding::JobError;
use crate::machine::description::{MagazineWheel, WheelChanger, WheelsNow};
use crate::machine::wheel_state::{WheelNow, nm_from_mm};
use crate::motion::plan::PlanCommand;
use crate::planner::plan_check::{PlanFault, check_plan};

const CHANGE_S: f64 = 12.0;

/// The machine of the other tests with a second, smaller and narrower wheel.
fn machine_with_changer() -> MachineDescription {
    let mut machine = machine();
    let small = WheelDescription {
        new_radius_mm: 25.0,
        min_radius_mm: 20.0,
        width_mm: 15.0,
        surface_speed_m_s: 45.0,
        spin_up_s: 0.5,
        ..machine.wheel
    };
    let wheel = |name: &str, wheel| MagazineWheel { name: name.into(), wheel, setting_error_mm: 0.0 };
    let wheels = vec![wheel("large", WheelDescription { new_radius_mm: 60.0, ..machine.wheel }), wheel("small", small)];
    machine.wheel = wheels[0].wheel;
    machine.wheel_changer = Some(WheelChanger { change_s: CHANGE_S, min_x_mm: 100.0, wheels, mounted: 0 });
    machine
}

fn rough() -> PassSpec {
    PassSpec {
        name: "rough".into(),
        total_infeed_mm: 0.288,
        infeed_per_block_mm: 0.000_01,
        spark_out_turns: 1,
        ..job().passes[0].clone()
    }
}

/// Rough and finish, 0.288 and 0.072 mm, over the stock of 0.3 mm.
fn two_passes() -> JobSpec {
    let mut job = job();
    job.passes =
        vec![rough(), PassSpec { total_infeed_mm: 0.072, infeed_per_block_mm: 0.000_01, ..job.passes[0].clone() }];
    job
}

fn commands(plan: &Plan) -> Vec<PlanCommand> {
    let command = |segment: &crate::motion::plan::Segment| match &segment.kind {
        SegmentKind::Command(command) => Some(command.clone()),
        _ => None,
    };
    plan.segments.iter().filter_map(command).collect()
}

/// Every lobe has the path of a job with its wheel alone, to the bit; lobes of one wheel in a row need no change.
#[test]
fn lobes_with_two_wheels_have_the_paths_of_each_wheel() {
    let machine = machine_with_changer();
    let mut job = job();
    let wheels = [0, 0, 1, 1].map(|wheel| vec![wheel]);
    job.visit_by_wheels(&wheels, 0.02).expect("visits");
    let planned = plan_job(&job, &machine, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
    let alone = |radius_mm: f64| {
        let mut machine = machine.clone();
        machine.wheel_changer = None;
        plan_job(&super::job(), &machine, radius_mm, None).unwrap_or_else(|error| panic!("{error}"))
    };
    let (large, small) = (alone(60.0), alone(25.0));
    for (index, lobe) in planned.lobes.iter().enumerate() {
        let same = if index < 2 { &large.lobes[index] } else { &small.lobes[index] };
        assert_eq!(lobe.tool_path, same.tool_path, "{}", lobe.design.name);
        assert_eq!(lobe.start_rad.to_bits(), same.start_rad.to_bits());
    }
    let changes: Vec<PlanCommand> = commands(&planned.plan)
        .into_iter()
        .filter(|command| matches!(command, PlanCommand::ChangeWheel { .. }))
        .collect();
    assert_eq!(changes, [PlanCommand::ChangeWheel { wheel: 0 }, PlanCommand::ChangeWheel { wheel: 1 }]);
}

/// First all lobes are roughed by the large wheel, then finished by the small one. The finish begins its approach above what the roughing
/// leaves, 0.072 - 0.02 mm, and both leave nothing.
#[test]
fn passes_with_two_wheels_are_visits_and_one_change() {
    let machine = machine_with_changer();
    let mut job = two_passes();
    job.visit_by_wheels(&vec![vec![0, 1]; 4], 0.02).expect("visits");
    let names: Vec<&str> = job.lobes.iter().map(|lobe| lobe.name.as_str()).collect();
    assert_eq!(names, ["I1-rough", "E1-rough", "I2-rough", "E2-rough", "I1", "E1", "I2", "E2"]);
    assert!((job.stock_of_mm(4) - 0.052).abs() < 1e-12 && (job.stock_of_mm(0) - 0.3).abs() < 1e-12);
    let planned = plan_job(&job, &machine, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
    let plan = &planned.plan;
    let cut = |lobe: usize| plan.cuts_of(lobe).next().and_then(|cut| plan.motion_of(cut)).expect("a cut");
    for lobe in 0..4 {
        let (rough, finish) = (cut(lobe), cut(lobe + 4));
        assert_eq!((plan.cuts_of(lobe).count(), plan.cuts_of(lobe + 4).count()), (1, 1));
        let of_law = |law: &crate::math::hermite::HermiteSpline| {
            let knots = law.knots();
            (knots[0].value, knots[knots.len() - 1].value)
        };
        let ((from_mm, to_mm), (again_mm, end_mm)) = (of_law(rough.infeed), of_law(finish.infeed));
        assert!((from_mm - 0.34).abs() < 1e-9 && (to_mm - 0.052).abs() < 1e-9, "{from_mm} {to_mm}");
        assert!((again_mm - 0.072).abs() < 1e-9 && end_mm.abs() < 1e-9, "{again_mm} {end_mm}");
        let radius_mm = |lobe: usize| planned.lobes[lobe].tool_path.wheel_radius_mm();
        assert_eq!((radius_mm(lobe), radius_mm(lobe + 4)), (60.0, 25.0));
    }
    let finished: Vec<bool> = planned.lobes.iter().map(|lobe| !lobe.design.sections().is_empty()).collect();
    assert_eq!(finished, [false, false, false, false, true, true, true, true]);
    // Wheel to rest (2 s), change, wheel to speed (0.5 s), and the way of four commands there and back.
    let of_change = plan.segments.iter().filter(|segment| segment.phase == Phase::WheelChange);
    let moved = |segment: &&crate::motion::plan::Segment| !matches!(segment.kind, SegmentKind::Move(_));
    let ticks: u64 = of_change.filter(moved).map(|segment| segment.ticks).sum();
    let command_ticks = 2 * u64::from(machine.feedback_delay_ticks);
    let first_s = 2.0 + CHANGE_S + 2.0;
    let second_s = 2.0 + CHANGE_S + 0.5;
    assert_eq!(ticks, whole(first_s + second_s, &machine) + 8 * command_ticks);
    let expected = [60.0, 25.0].map(|radius_mm| PlanCommand::ExpectWheel { radius_nm: nm_from_mm(radius_mm) });
    let commands = commands(plan);
    for wheel in [0, 1] {
        let at = commands.iter().position(|command| *command == PlanCommand::ChangeWheel { wheel }).expect("a change");
        let wanted = [PlanCommand::WheelStop, PlanCommand::ChangeWheel { wheel }, expected[wheel as usize].clone()];
        assert_eq!(commands[at - 1..=at + 1], wanted);
        assert_eq!(commands[at + 2], PlanCommand::WheelStart);
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "seconds")]
fn whole(s: f64, machine: &MachineDescription) -> u64 {
    libm::round(s / machine.cycle_time_s()) as u64
}

/// Each wheel wears and is dressed by itself, to its own radius, and is expected with the radius it has then.
#[test]
fn wheels_wear_and_are_dressed_apart() {
    let mut machine = machine_with_changer();
    machine.dresser = Some(crate::machine::fixture::Dresser {
        x_mm: 60.0,
        z_mm: 340.0,
        width_mm: 2.0,
        infeed_speed_mm_s: 1.0,
        traverse_speed_mm_s: 5.0,
        dwell_s: 0.2,
        max_depth_mm: 0.1,
    });
    let mut job = two_passes();
    job.dressing = Some(crate::job::dressing::DressingSpec {
        every_lobes: Some(2),
        every_parts: None,
        predicted_error_mm: None,
        depth_mm: 0.01,
    });
    job.visit_by_wheels(&vec![vec![0, 1]; 4], 0.02).expect("visits");
    let mut stored = [None; crate::machine::description::MAX_WHEELS];
    stored[1] = Some(WheelNow { lobes_since_dress: 1, ..WheelNow::dressed(24.5) });
    let wheels = WheelsNow { mounted: WheelNow::dressed(60.0), stored };
    let planned = plan_job(&job, &machine, wheels, None).unwrap_or_else(|error| panic!("{error}"));
    let dresses: Vec<(usize, i64)> =
        planned.dresses.iter().map(|planned| (planned.dress.before_lobe, planned.dress.radius_nm)).collect();
    // Large before the third lobe; small, which has ground one lobe, before its second and fourth.
    assert_eq!(dresses, [(2, 59_990_000), (5, 24_490_000), (7, 24_480_000)]);
    let radii: Vec<f64> = planned.lobes.iter().map(|lobe| lobe.tool_path.wheel_radius_mm()).collect();
    assert_eq!(radii, [60.0, 60.0, 59.99, 59.99, 24.5, 24.49, 24.49, 24.48]);
    assert!(commands(&planned.plan).contains(&PlanCommand::ExpectWheel { radius_nm: 24_500_000 }));
}

/// Settings that do not go with several wheels, a change near the part, and a lobe wider than its wheel are refused.
#[test]
fn what_cannot_be_ground_or_changed_is_refused() {
    let machine = machine_with_changer();
    let visits = |job: &mut JobSpec| job.visit_by_wheels(&vec![vec![0, 1]; 4], 0.02).expect("visits");
    let refused = |change: &dyn Fn(&mut JobSpec), machine: &MachineDescription| {
        let mut job = two_passes();
        visits(&mut job);
        change(&mut job);
        plan_job(&job, machine, 60.0, None).expect_err("refused").to_string()
    };
    let text = refused(&|job| job.home.x_mm = 90.0, &machine);
    assert!(
        text.contains("home.x_mm is 90, where the wheels are changed") && text.contains("at least 100 mm"),
        "{text}"
    );
    let text = refused(&|job| job.c_between_lobes = BetweenLobes::TurnsOn { margin_s: 0.1 }, &machine);
    assert!(text.contains("c_between_lobes: turns_on is not possible"), "{text}");
    let text = refused(&|_| (), &super::machine());
    assert!(text.contains("has no wheel changer"), "{text}");
    let text = refused(&|job| job.lobes[4].width_mm = 16.0, &machine);
    assert!(text.contains("16") && text.contains("15"), "the small wheel is narrower: {text}");
    let error = two_passes().visit_by_wheels(&vec![vec![0, 1]; 4], 0.08);
    assert!(matches!(error, Err(JobError::ApproachBeyondInfeed { .. })), "{error:?}");
    assert!(matches!(two_passes().visit_by_wheels(&[], 3.0), Err(JobError::WheelApproach { .. })));
}

/// The forward check refuses a change while the wheel runs, near the part, and to a wheel that there is not.
#[test]
fn the_check_of_a_plan_knows_wheel_changes() {
    let machine = machine_with_changer();
    let mut job = two_passes();
    job.visit_by_wheels(&vec![vec![0, 1]; 4], 0.02).expect("visits");
    let good = plan_job(&job, &machine, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
    let start = PlanStart::at_home(&job, &machine).counts;
    let at = (good.plan.segments.iter())
        .rposition(|segment| matches!(segment.kind, SegmentKind::Command(PlanCommand::ChangeWheel { .. })))
        .expect("a change");
    let fault = |change: &dyn Fn(&mut Plan), machine: &MachineDescription| {
        let mut plan = good.plan.clone();
        change(&mut plan);
        match check_plan(&plan, machine, start).expect_err("refused").fault {
            PlanFault::WheelChange { why, .. } => why,
            other => panic!("{other}"),
        }
    };
    assert_eq!(fault(&|plan| plan.segments[at - 2].kind = SegmentKind::Dwell, &machine), "the wheel runs");
    let mut near = machine.clone();
    if let Some(changer) = &mut near.wheel_changer {
        changer.min_x_mm = 160.0;
    }
    assert!(fault(&|_| (), &near).contains("nearer to the part"));
    let other = |plan: &mut Plan| plan.segments[at].kind = SegmentKind::Command(PlanCommand::ChangeWheel { wheel: 2 });
    assert_eq!(fault(&other, &machine), "the changer has fewer wheels");
}
