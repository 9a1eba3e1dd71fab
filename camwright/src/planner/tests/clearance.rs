// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The wheel keeps away from everything but the lobe it grinds.

use super::*;
use crate::job::dressing::DressingSpec;
use crate::job::grinding::{ObstacleSpec, Subject, WheelRequirement};
use crate::machine::fixture::{Dresser, Extent};

fn journal(from_mm: f64, to_mm: f64, radius_mm: f64) -> ObstacleSpec {
    ObstacleSpec { name: String::from("journal 1"), extent: Extent { from_mm, to_mm, radius_mm } }
}

/// Stations are at 40, 85, 130 … mm, the wheel is 25 mm wide: at LS2 it faces 72.5 … 97.5 mm.
#[test]
fn a_shoulder_beside_a_lobe_is_refused_where_the_wheel_would_meet_it_and_nowhere_else() {
    let error = refusal(|job| job.obstacles = vec![journal(57.0, 73.0, 30.0)]);
    let text = error.to_string();
    assert!(text.starts_with("E1: "), "{text}");
    assert!(text.contains("with z_axis at 85.000 mm, where obstacle journal 1 reaches 30.000 mm"), "{text}");
    assert!(text.contains("x_axis must stay at 31.000 mm or more"), "{text}");
    // Half a millimetre farther away it is beside the wheel.
    let mut job = job();
    job.obstacles = vec![journal(57.0, 72.5, 30.0)];
    planned(&job);
    // As low as the base circle less the clearance it is no obstacle at all.
    job.obstacles = vec![journal(57.0, 100.0, 14.9)];
    planned(&job);
    job.obstacles = vec![journal(57.0, 100.0, 15.1)];
    let error = plan_job(&job, &machine(), 60.0, None).map(|_| ()).expect_err("0.9 mm of 1 mm");
    let PlanError::Collision { lobe, what, obstacle, x_mm, reach_mm, .. } = &error else { panic!("{error}") };
    assert_eq!((lobe, what.as_str(), obstacle), (&Some(1), "obstacle journal 1", &Some(0)));
    assert!((x_mm - 16.0).abs() < 1e-6 && (reach_mm - 15.1).abs() < 1e-12, "{error}");
    job.clearance_mm = 0.5;
    planned(&job);
}

#[test]
fn the_table_does_not_pass_what_is_higher_than_the_wheel_stands() {
    // Between LS1 and LS2, in nobody's way but the table's: the retracted wheel stands at 56 to 62 mm.
    let error = refusal(|job| job.obstacles = vec![journal(55.0, 70.0, 70.0)]);
    let text = error.to_string();
    assert!(text.starts_with("E1: table to before LS2: ") && text.contains("z_axis at 40.000 to 80.000 mm"), "{text}");
    let mut job = job();
    job.obstacles = vec![journal(55.0, 70.0, 50.0)];
    planned(&job);
}

#[test]
fn headstock_and_tailstock_are_kept_away_from() {
    let mut grinder = machine();
    grinder.headstock = Some(Extent { from_mm: -100.0, to_mm: 30.0, radius_mm: 80.0 });
    let error = plan_job(&job(), &grinder, 60.0, None).map(|_| ()).expect_err("27.5 mm at LS1");
    assert!(error.to_string().contains("where the headstock reaches 80.000 mm"), "{error}");
    grinder.headstock = Some(Extent { from_mm: -100.0, to_mm: 20.0, radius_mm: 80.0 });
    plan_job(&job(), &grinder, 60.0, None).expect("home.x_mm is above it");
    grinder.tailstock = Some(Extent { from_mm: 185.0, to_mm: 400.0, radius_mm: 60.0 });
    let error = plan_job(&job(), &grinder, 60.0, None).map(|_| ()).expect_err("187.5 mm at LS4");
    let text = error.to_string();
    assert!(text.starts_with("E2: ") && text.contains("where the tailstock reaches 60.000 mm"), "{text}");
}

/// Beside the dresser the wheel is as low as its rim, and so is the wheel's other edge.
#[test]
fn what_stands_beside_the_dresser_is_kept_away_from() {
    let mut grinder = machine();
    let dresser = Dresser {
        x_mm: 60.0,
        z_mm: 300.0,
        width_mm: 2.0,
        infeed_speed_mm_s: 1.0,
        traverse_speed_mm_s: 10.0,
        dwell_s: 0.2,
        max_depth_mm: 1.0,
    };
    grinder.dresser = Some(dresser);
    grinder.tailstock = Some(Extent { from_mm: 328.0, to_mm: 400.0, radius_mm: 70.0 });
    let mut job = job();
    job.dressing =
        Some(DressingSpec { every_lobes: Some(2), every_parts: None, predicted_error_mm: None, depth_mm: 0.02 });
    // Table ± 14.5 mm, wheel ± 12.5 mm: up to 327 mm.
    plan_job(&job, &grinder, 60.0, None).expect("beside each other");
    grinder.tailstock = Some(Extent { from_mm: 326.0, to_mm: 400.0, radius_mm: 70.0 });
    let error = plan_job(&job, &grinder, 60.0, None).map(|_| ()).expect_err("1 mm");
    let text = error.to_string();
    assert!(text.starts_with("past the dresser: ") && text.contains("where the tailstock reaches 70.000 mm"), "{text}");
    // The dresser itself is in the way of a table that moves with the wheel lower than it.
    grinder.tailstock = None;
    grinder.dresser = Some(Dresser { z_mm: 107.0, ..dresser });
    let error = plan_job(&job, &grinder, 60.0, None).map(|_| ()).expect_err("between LS2 and LS3");
    assert!(error.to_string().contains("where the dresser reaches 60.000 mm"), "{error}");
}

/// Random jobs with random obstacles: whatever is planned moves its table only above everything it sweeps.
#[test]
fn whenever_the_table_moves_the_wheel_is_clear_of_everything_it_passes() {
    let seed = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = random_between(seed);
    let (mut made, mut refused) = (0, 0);
    for round in 0..24 {
        let mut job = job();
        job.lobes.truncate(1 + round % 4);
        job.rapid_advance_mm = random(8.0, 60.0);
        job.home.x_mm = random(40.0, 150.0);
        job.clearance_mm = random(0.0, 5.0);
        let from_mm = random(-20.0, 200.0);
        job.obstacles = vec![journal(from_mm, from_mm + random(1.0, 40.0), random(5.0, 70.0))];
        let Ok(planned) = plan_job(&job, &machine(), 60.0, None) else {
            refused += 1;
            continue;
        };
        made += 1;
        let (mut x, mut z) = (job.home.x_mm, job.home.z_mm);
        for segment in &planned.plan.segments {
            let (x_before, z_before) = (x, z);
            match &segment.kind {
                SegmentKind::Move(targets) if targets[0].axis == Axis::X => x = targets[0].target_counts as f64 / 1e5,
                SegmentKind::Move(targets) if targets[0].axis == Axis::Z => z = targets[0].target_counts as f64 / 1e4,
                SegmentKind::Search { axis: Axis::Z, input, .. } => {
                    z = machine().station(input).expect("known").position_mm;
                }
                _ => {}
            }
            if (z - z_before).abs() < 1e-9 {
                continue;
            }
            assert!((x - x_before).abs() < 1e-12, "seed {seed:#x}, round {round}: both move");
            let (low, high) = (z.min(z_before) - 12.5, z.max(z_before) + 12.5);
            let obstacle = job.obstacles[0].extent;
            if obstacle.to_mm > low && obstacle.from_mm < high {
                let min = obstacle.radius_mm + job.clearance_mm - 1e-3;
                assert!(x >= min, "seed {seed:#x}, round {round}: x {x}, {obstacle:?}");
            }
            // 22.3 mm is the highest nose with its stock.
            assert!(x > 22.3, "seed {seed:#x}, round {round}: x {x}");
        }
    }
    assert!(made >= 5 && refused >= 5, "seed {seed:#x}: made {made}, refused {refused}");
}

/// A hollow that the wheel does not reach into names lobes, place, bound and what to do; so does a wish for two wheels.
#[test]
fn a_part_for_two_wheels_is_refused_with_what_each_lobe_takes() {
    let error = refusal(|job| job.profiles[1] = lobe_profile("exhaust", 9.0, 50.0));
    let text = error.to_string();
    assert!(
        text.starts_with("lobes E1, E2, profile exhaust: the wheel of radius 60.000 mm does not reach into"),
        "{text}"
    );
    assert!(text.contains("at cam angle") && text.contains("the largest usable radius is"), "{text}");
    assert!(text.ends_with("make a job of I1, I2 and another, with a smaller wheel, of E1, E2"), "{text}");
    let error = refusal(|job| {
        job.profiles[1] = lobe_profile("exhaust", 9.0, 50.0);
        job.wheels = vec![
            WheelRequirement { of: Subject::Lobe("I1".into()), radius_mm: 60.0 },
            WheelRequirement { of: Subject::Lobe("E1".into()), radius_mm: 25.0 },
        ];
    });
    let text = error.to_string();
    let begins = "the machine has one wheel, of radius 60.000 mm, and the job needs 60 mm for lobe I1, 25 mm for lobe E1; \
                  lobe I1 takes ";
    assert!(text.starts_with(begins), "{text}");
    assert!(text.contains("lobe E1 takes less than") && text.contains("hollow at cam angle"), "{text}");
    assert!(text.ends_with("split it into one job per wheel"), "{text}");
    // The wheel that is mounted may be asked for.
    let mut job = job();
    job.wheels = vec![WheelRequirement { of: Subject::Pass("grind".into()), radius_mm: 60.0 }];
    planned(&job);
}
