// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tasks of the fastest turn: the reference lobe and seeded random ones. Benchmarks and judges share them.
#![allow(dead_code, reason = "each program uses its part")]

use crate::cams::{self, SplitMix64};
use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::lift::{LiftLaw, MotionProgram, MotionSegment};
use camwright::cam::motion_law::MotionLaw;
use camwright::machine::description::MotionLimits;
use camwright::math::hermite::Sample;
use camwright::math::units::{TURN_RAD, rad_from_deg};
use camwright::motion::speed_plan::{TurnError, TurnRequest, TurnSpeed};
use camwright::toolpath::wheel_path::ToolPath;
use std::error::Error;

/// Limits of C.
pub(crate) const C: MotionLimits =
    MotionLimits { velocity: 10.0 * std::f64::consts::PI, acceleration: 300.0, jerk: 3e4 };
const LINEAR_MOTOR: MotionLimits = MotionLimits { velocity: 500.0, acceleration: 1e4, jerk: 1e6 };
const BALL_SCREW: MotionLimits = MotionLimits { velocity: 170.0, acceleration: 3e3, jerk: 1e5 };

/// A lobe, its wheel, what is taken off, and what X can do.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lobe {
    pub(crate) law: MotionLaw,
    pub(crate) follower: Follower,
    pub(crate) base_radius_mm: f64,
    pub(crate) lift_mm: f64,
    pub(crate) rise_deg: f64,
    pub(crate) fall_deg: f64,
    pub(crate) wheel_radius_mm: f64,
    pub(crate) removal_rate_mm2_s: f64,
    pub(crate) infeed_mm: f64,
    pub(crate) x: MotionLimits,
}

impl Lobe {
    /// The lobe of the acceptance test (`camwright/tests/motion/fastest_turn.rs`).
    const fn reference(wheel_radius_mm: f64, removal_rate_mm2_s: f64, infeed_mm: f64) -> Self {
        Self {
            law: MotionLaw::Polynomial345,
            follower: Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 },
            base_radius_mm: 16.0,
            lift_mm: 6.0,
            rise_deg: 62.0,
            fall_deg: 62.0,
            wheel_radius_mm,
            removal_rate_mm2_s,
            infeed_mm,
            x: LINEAR_MOTOR,
        }
    }

    fn contour(&self) -> Option<Contour> {
        let segment = |law, angle_rad, rise_mm| MotionSegment { law, angle_rad, rise_mm };
        let (rise, fall) = (rad_from_deg(self.rise_deg), rad_from_deg(self.fall_deg));
        let segments = [
            segment(self.law, rise, self.lift_mm),
            segment(self.law, fall, -self.lift_mm),
            segment(MotionLaw::Dwell, TURN_RAD - rise - fall, 0.0),
        ];
        let program = MotionProgram::new(0.5 * TURN_RAD - rise, &segments).ok()?;
        Contour::from_lift(&LiftLaw::from_program(program).ok()?, &self.follower, self.base_radius_mm).ok()
    }

    /// The first lobe that can be ground, among those drawn from a seed.
    fn random(seed: u64) -> (Self, ToolPath) {
        let mut random = SplitMix64(seed);
        loop {
            let mut lobe = Self {
                law: if random.next() >> 63 == 1 { MotionLaw::Polynomial345 } else { MotionLaw::Polynomial4567 },
                follower: if random.next() >> 63 == 1 {
                    Follower::Roller { radius_mm: random.within(5.0, 20.0), offset_mm: 0.0 }
                } else {
                    Follower::Flat
                },
                base_radius_mm: random.within(12.0, 25.0),
                lift_mm: random.within(3.0, 10.0),
                rise_deg: random.within(50.0, 80.0),
                fall_deg: random.within(50.0, 80.0),
                wheel_radius_mm: 0.0,
                removal_rate_mm2_s: random.within(2.0, 20.0),
                infeed_mm: random.within(0.01, 0.05),
                x: if random.next() >> 63 == 1 { LINEAR_MOTOR } else { BALL_SCREW },
            };
            let wheel = random.within(0.0, 1.0);
            let Some(contour) = lobe.contour() else { continue };
            let largest = contour.recommended_wheel_radius_mm().unwrap_or(f64::INFINITY).min(250.0);
            if largest < 30.0 {
                continue;
            }
            lobe.wheel_radius_mm = 30.0 + (largest - 30.0) * wheel;
            if let Ok(path) = ToolPath::for_wheel(&contour, lobe.wheel_radius_mm) {
                return (lobe, path);
            }
        }
    }
}

/// A lobe with the path of its wheel.
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) lobe: Lobe,
    pub(crate) path: ToolPath,
}

impl Case {
    /// The speed that the removal rate allows (rad/s).
    pub(crate) fn bound(&self, x: Sample) -> f64 {
        let cutting = cams::cutting(self.lobe.wheel_radius_mm, self.lobe.infeed_mm);
        self.lobe.removal_rate_mm2_s / cutting.removal_rate_ratio_mm2(x)
    }

    pub(crate) fn plan(&self) -> Result<TurnSpeed, TurnError> {
        let bound = |_: f64, x: Sample| self.bound(x);
        let path = self.path.spline();
        let request = TurnRequest { path, infeed_slope_mm_rad: 0.0, bound: &bound, c: C, x: self.lobe.x };
        TurnSpeed::fastest(&request)
    }
}

/// The four cases of the reference lobe, then so many random ones of seeds from this on.
pub(crate) fn cases(random: u64, seed: u64) -> Result<Vec<Case>, Box<dyn Error>> {
    let mut cases = Vec::new();
    for (wheel_radius_mm, removal_rate_mm2_s, infeed_mm) in
        [(60.0, 3.0, 0.02), (60.0, 10.0, 0.05), (150.0, 3.0, 0.02), (150.0, 10.0, 0.05)]
    {
        let lobe = Lobe::reference(wheel_radius_mm, removal_rate_mm2_s, infeed_mm);
        let contour = lobe.contour().ok_or("the reference lobe is not regular")?;
        let path = ToolPath::for_wheel(&contour, wheel_radius_mm)?;
        cases.push(Case { name: format!("reference wheel {wheel_radius_mm} Q' {removal_rate_mm2_s}"), lobe, path });
    }
    for seed in seed..seed + random {
        let (lobe, path) = Lobe::random(seed);
        cases.push(Case { name: format!("random seed {seed}"), lobe, path });
    }
    Ok(cases)
}
