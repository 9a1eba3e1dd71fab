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
