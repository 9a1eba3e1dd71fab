// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The fastest turn: against the best known plans, against lower bounds, and against its own limits by other arithmetic.

use crate::cams;

use cams::reference_lobe;
use camwright::machine::description::MotionLimits;
use camwright::math::hermite::Sample;
use camwright::math::units::TURN_RAD;
use camwright::motion::speed_plan::{TurnRequest, TurnSpeed};
use camwright::toolpath::wheel_path::ToolPath;

const C: MotionLimits = MotionLimits { velocity: 10.0 * std::f64::consts::PI, acceleration: 300.0, jerk: 3e4 };
const X: MotionLimits = MotionLimits { velocity: 500.0, acceleration: 1e4, jerk: 1e6 };

/// Q′ at unit speed of C (mm²/rad).
fn removal(path: &ToolPath, infeed_mm: f64, x: Sample) -> f64 {
    cams::cutting(path.wheel_radius_mm(), infeed_mm).removal_rate_ratio_mm2(x)
}

struct Case {
    wheel_radius_mm: f64,
    removal_rate_mm2_s: f64,
    infeed_mm: f64,
    /// Best turn known, by the oracle of `tests/benchmarks`: successive linear programs from several starts (s).
    best_s: f64,
    /// Proven lower bound: the linear program without jerk (s).
    bound_s: f64,
}

const CASES: [Case; 4] = [
    Case { wheel_radius_mm: 60.0, removal_rate_mm2_s: 3.0, infeed_mm: 0.02, best_s: 0.7460, bound_s: 0.739 },
    Case { wheel_radius_mm: 60.0, removal_rate_mm2_s: 10.0, infeed_mm: 0.05, best_s: 0.5865, bound_s: 0.580 },
    Case { wheel_radius_mm: 150.0, removal_rate_mm2_s: 3.0, infeed_mm: 0.02, best_s: 0.7564, bound_s: 0.749 },
    Case { wheel_radius_mm: 150.0, removal_rate_mm2_s: 10.0, infeed_mm: 0.05, best_s: 0.6036, bound_s: 0.597 },
];

/// Within 0.5 % of the best turn known, above what is proven impossible, on the reference lobe with both wheels.
#[test]
fn the_turn_is_within_half_a_hundredth_of_the_best_known() {
    for case in CASES {
        let path = reference_lobe(case.wheel_radius_mm);
        let bound = |_: f64, x: Sample| case.removal_rate_mm2_s / removal(&path, case.infeed_mm, x);
        let request = TurnRequest { path: path.spline(), infeed_slope_mm_rad: 0.0, bound: &bound, c: C, x: X };
        let turn = TurnSpeed::fastest(&request).expect("limits above 0");
        let (turn_s, min_s) = (turn.turn_s(), turn.minimum_s());
        assert!(turn_s <= 1.005 * case.best_s && turn_s > case.bound_s, "{turn_s} s against {} s", case.best_s);
        assert!(min_s < turn_s && min_s <= case.bound_s + 0.0005, "{min_s} s is not below {} s", case.bound_s);
    }
}

/// Every limit holds on a grid some 40 times finer than the knots, by the chain rule from speed and acceleration over the angle,
/// with jerk differenced: arithmetic the planner does not use.
#[test]
fn no_limit_is_exceeded_on_a_fine_grid() {
    const POINTS: u32 = 20_000;
    for case in CASES {
        let path = reference_lobe(case.wheel_radius_mm);
        let bound = |_: f64, x: Sample| case.removal_rate_mm2_s / removal(&path, case.infeed_mm, x);
        let request = TurnRequest { path: path.spline(), infeed_slope_mm_rad: 0.0, bound: &bound, c: C, x: X };
        let turn = TurnSpeed::fastest(&request).expect("limits above 0");
        let mut worst = [0.0_f64; 7];
        let mut take = |index: usize, ratio: f64| worst[index] = worst[index].max(ratio.abs());
        let d = TURN_RAD / f64::from(POINTS);
        for i in 0..POINTS {
            let angle = f64::from(i) * d;
            let here = turn.at(angle);
            let (v, a) = (here.speed, here.acceleration);
            // Within a step that crosses a knot jerk is a mean of two that are both allowed.
            let (before, after) = (turn.at(angle - 0.5 * d), turn.at(angle + 0.5 * d));
            let jerk = (after.acceleration - before.acceleration) / d * v;
            let x = path.sample(angle);
            take(0, v / bound(angle, x));
            take(1, v / C.velocity);
            take(2, a / C.acceleration);
            take(3, jerk / C.jerk);
            take(4, x.first * v / X.velocity);
            take(5, (x.second * v * v + x.first * a) / X.acceleration);
            take(6, (x.third * v * v * v + 3.0 * x.second * v * a + x.first * jerk) / X.jerk);
        }
        assert!(worst.iter().all(|ratio| *ratio <= 1.00005), "wheel {} mm: {worst:?}", case.wheel_radius_mm);
        // Something binds: the plan is not merely slow.
        assert!(worst[0] > 0.999 && worst[2] > 0.98, "wheel {} mm: {worst:?}", case.wheel_radius_mm);
    }
}

/// A round part asks nothing of X: C turns at the bound, and the time is that of the lower bound.
#[test]
fn on_a_concentric_disc_the_bound_is_reached_everywhere() {
    let flat = camwright::math::periodic_spline::PeriodicSpline::interpolate(&[20.0; 36]).expect("36 values");
    let request = TurnRequest { path: &flat, infeed_slope_mm_rad: 0.0, bound: &|_, _| 12.0, c: C, x: X };
    let turn = TurnSpeed::fastest(&request).expect("limits above 0");
    assert!((turn.turn_s() / (TURN_RAD / 12.0) - 1.0).abs() < 1e-3, "{} s", turn.turn_s());
    assert!(turn.turn_s() >= turn.minimum_s());
}

/// Turning the part turns the plan, and changes nothing else: up to 0.1 % is what other knots and the gap at which the search ends
/// make of it.
#[test]
fn the_plan_turns_with_the_part() {
    let path = reference_lobe(60.0);
    let turn_s = |shift: f64| {
        let n = path.spline().coefficients().len();
        let values: Vec<f64> = (0..n).map(|i| path.sample(i as f64 * TURN_RAD / n as f64 - shift).value).collect();
        let turned = camwright::math::periodic_spline::PeriodicSpline::interpolate(&values).expect("finite");
        let bound = |_: f64, x: Sample| 10.0 / removal(&path, 0.05, x);
        let request = TurnRequest { path: &turned, infeed_slope_mm_rad: 0.0, bound: &bound, c: C, x: X };
        TurnSpeed::fastest(&request).expect("limits above 0").turn_s()
    };
    let at_0 = turn_s(0.0);
    for shift in [0.7, 2.0, 4.1] {
        assert!((turn_s(shift) / at_0 - 1.0).abs() < 1e-3, "turned by {shift} rad: {} s, not {at_0} s", turn_s(shift));
    }
}
