// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Running up from rest onto a turn at varying speed, and down again, wherever on the lobe the cut begins.

use crate::cams;

use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::motion_law::MotionLaw;
use camwright::job::grinding::{InfeedDirection, SpeedLaw};
use camwright::job::infeed::InfeedSchedule;
use camwright::machine::description::{AxisScale, MotionLimits};
use camwright::math::units::TURN_RAD;
use camwright::motion::speed_plan::{SpeedPlan, SpeedRequest};
use camwright::toolpath::wheel_path::ToolPath;

const C: MotionLimits = MotionLimits { velocity: 10.0 * std::f64::consts::PI, acceleration: 300.0, jerk: 3e4 };
const X: MotionLimits = MotionLimits { velocity: 500.0, acceleration: 1e4, jerk: 1e6 };

/// C at its acceleration limit needs 0.06 s and more to reach the speed of the base circle, and loses half of that. A flank costs
/// more, for there X has to be brought up to speed too.
#[test]
fn from_anywhere_on_the_lobe_both_ramps_together_lose_little() {
    let follower = Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 };
    let lift = cams::lobe(MotionLaw::Polynomial345, 6.0, 62.0);
    let contour = Contour::from_lift(&lift, &follower, 16.0).expect("a regular contour");
    let path = ToolPath::for_wheel(&contour, 60.0).expect("the wheel fits");
    let infeed = InfeedSchedule::new(0.36, 0.05 / 3600.0 * 1.2, 3600, AxisScale::Linear { counts_per_mm: 100_000 });
    let infeed = infeed.expect("6 turns of 0.06 mm");
    let (mut worst_s, mut sum_s) = (0.0_f64, 0.0);
    for k in 0..36_u32 {
        let plan = SpeedPlan::new(&SpeedRequest {
            path: path.spline(),
            path_start_rad: f64::from(k) * TURN_RAD / 36.0,
            infeed: &infeed,
            infeed_direction: InfeedDirection::X,
            ratio: None,
            spark_out_turns: 2,
            leaves_turning: false,
            speed: SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 10.0, max_rad_s: 31.4 },
            comes: None,
            goes: None,
            wheel_power: None,
            rotation_sense: 1,
            wheel_radius_mm: 60.0,
            wheel_speed_m_s: 80.0,
            c: C,
            x: X,
            cycle_time_s: 1e-3,
        });
        let plan = plan.unwrap_or_else(|error| panic!("from {} deg: {error}", 10 * k));
        let lost_s = plan.law().end() - f64::from(plan.turns()) * plan.turn_s();
        (worst_s, sum_s) = (worst_s.max(lost_s), sum_s + lost_s);
    }
    let mean_s = sum_s / 36.0;
    assert!(worst_s < 0.1 && mean_s < 0.07, "at most {worst_s:.3} s, {mean_s:.3} s in the mean");
}
