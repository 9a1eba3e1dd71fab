// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Random cuts of 1 to 2,000 turns, from a seed to a verdict: none may be refused because a position was rounded.

use crate::cams::{SplitMix64, random_law, reference_contour};
use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::job::grinding::{InfeedDirection, SpeedLaw};
use camwright::job::infeed::InfeedSchedule;
use camwright::machine::description::{AxisScale, MotionLimits};
use camwright::math::units::TURN_RAD;
use camwright::motion::cut_motion::CutMotion;
use camwright::motion::speed_plan::{SpeedPlan, SpeedPlanError, SpeedRequest, uses_by_differences};
use camwright::toolpath::wheel_path::ToolPath;

/// Outcome of a cut.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum CutVerdict {
    /// Refused for a reason that the job can change.
    Refused(&'static str),
    /// Planned, with so many turns.
    Planned(u32),
    /// A plan that its own check refused.
    Wrong(String),
}

const SCALE: AxisScale = AxisScale::Linear { counts_per_mm: 100_000 };

/// Turns up to which the whole of a cut is differenced once more, a thousand points a turn, as a plan is before it runs.
const TURNS_DIFFERENCED: u32 = 60;

/// A cut of the reference lobe: a wheel of 150 mm, Q′ = 3 mm³/(mm s), 20 turns with infeed and 1 without.
pub(crate) fn reference_cut() -> CutVerdict {
    let path = ToolPath::for_wheel(&reference_contour(), 150.0).expect("the wheel fits");
    let limits = (
        MotionLimits { velocity: 10.0 * std::f64::consts::PI, acceleration: 300.0, jerk: 3e4 },
        MotionLimits { velocity: 500.0, acceleration: 1e4, jerk: 1e6 },
    );
    let speed = SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 3.0, max_rad_s: limits.0.velocity };
    plan(&path, limits, speed, 0.0, (20, 1), 0.018)
}

/// One cut.
pub(crate) fn judge_cut(seed: u64) -> CutVerdict {
    let mut random = SplitMix64(seed);
    let contour = if random.next().is_multiple_of(3) {
        reference_contour()
    } else {
        let lift = random_law(&mut random, 2.0);
        let follower = Follower::Roller { radius_mm: random.within(4.0, 15.0), offset_mm: 0.0 };
        match Contour::from_lift(&lift, &follower, random.within(12.0, 40.0)) {
            Ok(contour) => contour,
            Err(_) => return CutVerdict::Refused("contour"),
        }
    };
    let Ok(path) = ToolPath::for_wheel(&contour, random.within(20.0, 250.0)) else {
        return CutVerdict::Refused("wheel");
    };
    let mut near = |value: f64| value * 10_f64.powf(random.within(-0.4, 0.4));
    let c = MotionLimits { velocity: near(31.4), acceleration: near(300.0), jerk: near(3e4) };
    let x = MotionLimits { velocity: near(500.0), acceleration: near(1e4), jerk: near(1e6) };
    let max_rad_s = c.velocity;
    let speed = match random.next() % 4 {
        0 => SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: 10_f64.powf(random.within(-1.0, 1.0)) },
        1 => SpeedLaw::TimeOptimal { max_rad_s },
        _ => SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 10_f64.powf(random.within(-0.5, 1.3)), max_rad_s },
    };
    #[allow(clippy::cast_possible_truncation, reason = "at most 4000 turns")]
    let turns = random.within(1.0, 2000.0_f64.log2() + 1.0).exp2() as u32 / 2;
    let spark_out = (turns / 2).max(1);
    let infeed_turns = turns.saturating_sub(spark_out).clamp(1, 1000);
    let start_rad = random.within(0.0, TURN_RAD);
    plan(&path, (c, x), speed, start_rad, (infeed_turns, spark_out), random.within(0.001, 0.05))
}

fn plan(
    path: &ToolPath,
    (c, x): (MotionLimits, MotionLimits),
    speed: SpeedLaw,
    path_start_rad: f64,
    (infeed_turns, spark_out_turns): (u32, u32),
    infeed_of_turn_mm: f64,
) -> CutVerdict {
    // On counts, so that the turns are whole.
    let per_turn_mm = (infeed_of_turn_mm * 1e5).round().max(1.0) / 1e5;
    let infeed = InfeedSchedule::new(per_turn_mm * f64::from(infeed_turns), per_turn_mm / 3600.0, 3600, SCALE);
    let infeed = match infeed {
        Ok(infeed) => infeed,
        Err(error) => return CutVerdict::Wrong(format!("{infeed_turns} turns of {per_turn_mm} mm: {error}")),
    };
    let request = SpeedRequest {
        path: path.spline(),
        path_start_rad,
        infeed: &infeed,
        infeed_direction: InfeedDirection::X,
        ratio: None,
        spark_out_turns,
        leaves_turning: false,
        speed,
        comes: None,
        goes: None,
        wheel_power: None,
        rotation_sense: 1,
        wheel_radius_mm: path.wheel_radius_mm(),
        wheel_speed_m_s: 80.0,
        c,
        x,
        cycle_time_s: 1e-3,
    };
    let turns = infeed_turns + spark_out_turns;
    let plan = match SpeedPlan::new(&request) {
        Ok(plan) => plan,
        Err(SpeedPlanError::Check(found)) => return CutVerdict::Wrong(format!("{turns} turns: {found}")),
        Err(SpeedPlanError::TooFast { .. }) => return CutVerdict::Refused("limit"),
        Err(SpeedPlanError::NoPlateau { .. }) => return CutVerdict::Refused("plateau"),
        Err(SpeedPlanError::NoStop { .. }) => return CutVerdict::Refused("stop"),
        Err(SpeedPlanError::NoRunUp { .. }) => return CutVerdict::Refused("run-up"),
        Err(_) => return CutVerdict::Refused("other"),
    };
    if turns <= TURNS_DIFFERENCED {
        let motion = CutMotion {
            path: path.spline(),
            path_start_rad,
            infeed: plan.infeed().law(),
            ratio: None,
            lead: None,
            law: plan.law(),
        };
        let whole = [(motion.start_s(), motion.end_s())];
        let uses = uses_by_differences(&motion, &whole, plan.turn_s() / 1000.0, &c, &x);
        if let Some(exceeded) = uses.into_iter().find(|found| found.ratio() > 1.0 + 1e-6) {
            return CutVerdict::Wrong(format!("{turns} turns, all of them differenced: {exceeded}"));
        }
    }
    CutVerdict::Planned(turns)
}
