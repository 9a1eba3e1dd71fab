// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Infeed per turn, and at constant depth along the normal.

use super::*;
use crate::interpolator::MotionOutcome;
use crate::toolpath::wheel_path::ToolPath;

fn job_with(course: InfeedCourse, direction: InfeedDirection) -> JobSpec {
    let mut job = job();
    job.lobes.truncate(2);
    job.passes[0].infeed_course = course;
    job.passes[0].infeed_direction = direction;
    job
}

const KINDS: [(InfeedCourse, InfeedDirection); 3] = [
    (InfeedCourse::PerTurn, InfeedDirection::X),
    (InfeedCourse::PerAngle, InfeedDirection::Normal),
    (InfeedCourse::PerTurn, InfeedDirection::Normal),
];

/// Whatever the infeed, each lobe ends on its finished path, and the plan keeps every limit.
#[test]
fn every_kind_of_infeed_is_planned_within_limits_and_ground_to_the_design() {
    for (course, direction) in KINDS {
        for law in [
            SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: rad_s_from_rpm(60.0) },
            SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 30.0, max_rad_s: 31.0 },
        ] {
            let mut job = job_with(course, direction);
            job.passes[0].speed = law;
            let planned = planned(&job);
            assert!(planned.report.max_ratio() <= 1.0 + 1e-6, "{course:?} {direction:?}: {:?}", planned.report);
            let simulated = simulated(planned.plan.clone(), &machine(), |_, _| {});
            assert_eq!(simulated.outcome, MotionOutcome::Completed);
        }
    }
}

/// An infeed of its own in every turn, with every course, direction and law: the plan keeps its limits on the finer grid, the machine grinds
/// it to the design, and at the middle of every turn X stands as much lower than a turn before as the list says.
#[test]
fn a_list_of_infeeds_is_planned_within_limits_and_driven_turn_by_turn() {
    let list_mm = [0.15, 0.11, 0.07, 0.03];
    for (course, direction) in [KINDS[0], KINDS[1], KINDS[2], (InfeedCourse::PerAngle, InfeedDirection::X)] {
        for law in [
            SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: rad_s_from_rpm(60.0) },
            SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 30.0, max_rad_s: 31.0 },
            SpeedLaw::ConstantRadialRemovalRate { removal_rate_mm2_s: 30.0, max_rad_s: 31.0 },
            SpeedLaw::TimeOptimal { max_rad_s: 31.0 },
        ] {
            let mut job = job_with(course, direction);
            (job.passes[0].speed, job.passes[0].infeed_of_turns_mm) = (law, list_mm.to_vec());
            let planned = planned(&job);
            assert!(planned.report.max_ratio() <= 1.0 + 1e-6, "{course:?} {direction:?}: {:?}", planned.report);
            let cut = planned.plan.cuts_of(0).next().expect("a cut");
            assert_eq!(cut.infeed_turns, 4);
            let infeed = planned.plan.motion_of(cut).expect("its splines").infeed;
            match course {
                // From the middle of a turn to that of the next: half of the infeed of both.
                InfeedCourse::PerAngle => {
                    let level = |turn: u32| infeed.sample((f64::from(turn) + 0.5) * TURN_RAD).value;
                    for (turn, pair) in (0_u32..).zip(list_mm.windows(2)) {
                        let (fell_mm, wanted_mm) = (level(turn) - level(turn + 1), 0.5 * (pair[0] + pair[1]));
                        assert!((fell_mm - wanted_mm).abs() < 1e-9, "turn {turn}: {fell_mm}, not {wanted_mm} mm");
                    }
                }
                InfeedCourse::PerTurn => {
                    let mut levels: Vec<f64> = infeed.knots().iter().map(|knot| knot.value).collect();
                    levels.dedup();
                    let steps: Vec<f64> = levels.windows(2).map(|pair| pair[0] - pair[1]).collect();
                    let differ = steps.iter().zip(list_mm).any(|(step, wanted)| (step - wanted).abs() > 1e-9);
                    assert!(steps.len() == 4 && !differ, "{steps:?}");
                }
            }
            let simulated = simulated(planned.plan.clone(), &machine(), |_, _| {});
            assert_eq!(simulated.outcome, MotionOutcome::Completed);
        }
    }
}

/// The speed follows the turn with the largest infeed: a removal rate that holds there holds in every turn.
#[test]
fn a_list_of_infeeds_is_as_fast_as_its_deepest_turn() {
    let law = SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 10.0, max_rad_s: 31.0 };
    let turn_s = |list_mm: &[f64]| {
        let mut job = job_with(InfeedCourse::PerTurn, InfeedDirection::X);
        (job.passes[0].speed, job.passes[0].infeed_of_turns_mm) = (law, list_mm.to_vec());
        planned(&job).lobes[0].passes[0].turn_s()
    };
    let (even_s, deepest_s) = (turn_s(&[0.18, 0.18]), turn_s(&[0.18, 0.12, 0.06]));
    assert!((deepest_s / even_s - 1.0).abs() < 1e-9, "{deepest_s} s, with equal turns of 0.18 mm {even_s} s");
}

/// A refusal names the pass and the sum.
#[test]
fn a_list_of_infeeds_with_another_sum_is_refused() {
    let mut job = job_with(InfeedCourse::PerAngle, InfeedDirection::X);
    job.passes[0].infeed_of_turns_mm = vec![0.2, 0.1];
    let error = plan_job(&job, &machine(), 60.0, None).expect_err("0.3 of 0.36 mm").to_string();
    assert!(
        error.contains("pass grind") && error.contains("the 2 values of the infeed per turn sum to 0.3 mm"),
        "{error}"
    );
}

/// In the turns between steps the wheel grinds a contour that is larger by the infeed still to come, all round: its path is that
/// of a wheel larger by as much.
#[test]
fn an_infeed_along_the_normal_leaves_the_same_depth_all_round() {
    let planned = planned(&job_with(InfeedCourse::PerTurn, InfeedDirection::Normal));
    for (index, lobe) in planned.lobes.iter().enumerate() {
        let cut = planned.plan.cuts_of(index).next().expect("a cut");
        let motion = planned.plan.motion_of(cut).expect("its splines");
        let (_, first_end) = {
            let knots = motion.infeed.knots();
            (knots[0].at, knots.iter().find(|knot| (knot.value - 0.18).abs() < 1e-12).expect("half of it").at)
        };
        let larger = ToolPath::for_wheel(&lobe.design.contour, 60.0 + 0.18).expect("a path");
        let mut askew = 0.0_f64;
        for i in 0..360 {
            let angle = first_end + 0.01 + f64::from(i) * 0.9 * TURN_RAD / 360.0;
            let at = cut.path_start_rad + angle;
            let beta = lobe.tool_path.beta(at);
            askew = askew.max(beta.abs());
            let depth = (motion.over_angle(angle).value + 60.0 - (larger.sample(at).value + 60.18)) * libm::cos(beta);
            // s² tan²β/(2ρ) with ρ of 60 mm at least.
            let second = 0.18 * 0.18 * libm::pow(libm::tan(beta), 2.0) / 120.0;
            assert!(depth.abs() < second + 1e-5, "lobe {index} at {at} rad: {depth} mm");
        }
        assert!(askew > 0.1, "the flank is askew by {askew} rad at most: nothing was tried");
    }
}

/// The next pass would not begin at the end of the one before.
#[test]
fn passes_that_measure_their_infeed_differently_are_refused() {
    let mut job = job_with(InfeedCourse::PerAngle, InfeedDirection::X);
    let mut finish = job.passes[0].clone();
    finish.name = String::from("finish");
    finish.infeed_direction = InfeedDirection::Normal;
    job.passes.push(finish);
    let error = plan_job(&job, &machine(), 60.0, None).expect_err("two directions");
    assert_eq!(
        error.to_string(),
        "pass finish measures its infeed along the contour's normal, pass grind along x_axis; all passes need the same"
    );
}
