// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use crate::job::grinding::{InfeedDirection, WheelPower};
use crate::machine::description::{Axis, AxisScale};
use alloc::string::ToString;

pub(super) const C: MotionLimits = MotionLimits { velocity: 31.4, acceleration: 300.0, jerk: 30_000.0 };
pub(super) const X: MotionLimits = MotionLimits { velocity: 500.0, acceleration: 10_000.0, jerk: 1e6 };

/// `mean + e cos θ`, as a spline whose coefficients are samples: its amplitude is e to 1e-4 at 180 coefficients.
pub(super) fn eccentric(mean: f64, e: f64) -> PeriodicSpline {
    let coefficients = (0..180).map(|i| mean + e * libm::cos(f64::from(i) * TURN_RAD / 180.0)).collect();
    PeriodicSpline::from_coefficients(coefficients).expect("180 finite coefficients")
}

fn schedule() -> InfeedSchedule {
    InfeedSchedule::new(0.36, 0.000_05, 3600, AxisScale::Linear { counts_per_mm: 100_000 }).expect("2 turns")
}

pub(super) fn request<'a>(path: &'a PeriodicSpline, infeed: &'a InfeedSchedule, speed: f64) -> SpeedRequest<'a> {
    SpeedRequest {
        path,
        path_start_rad: 1.0,
        infeed,
        infeed_direction: InfeedDirection::X,
        ratio: None,
        spark_out_turns: 2,
        leaves_turning: false,
        speed: SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: speed },
        comes: None,
        goes: None,
        wheel_power: None,
        rotation_sense: 1,
        wheel_radius_mm: 60.0,
        wheel_speed_m_s: 80.0,
        c: C,
        x: X,
        cycle_time_s: 1e-3,
    }
}

/// A concentric disc asks nothing of X, and C gets the speed wanted.
#[test]
fn concentric_disc_turns_at_the_speed_wanted() {
    let (path, infeed) = (eccentric(25.0, 0.0), schedule());
    let plan = SpeedPlan::new(&request(&path, &infeed, 12.0)).expect("nothing limits it");
    assert_eq!(plan.turns(), 4);
    assert!((plan.turn_s() - TURN_RAD / 12.0).abs() < 1e-15);
    let middle = plan.law().sample(0.5 * (plan.plateau_s().0 + plan.plateau_s().1));
    assert!((middle.first - 12.0).abs() < 1e-9 && middle.second.abs() < 1e-6);
    // X moves by its infeed only.
    let x_velocity = plan.uses().iter().find(|u| u.axis == Axis::X).expect("X is limited").value;
    assert!((x_velocity - 12.0 * infeed.slope_mm_rad()).abs() < 1e-9);
}

/// Whole turns to the bit, at rest at both ends, never backwards.
#[test]
fn the_law_turns_whole_turns_from_rest_to_rest() {
    let (path, infeed) = (eccentric(25.0, 4.2), schedule());
    let plan = SpeedPlan::new(&request(&path, &infeed, 6.0)).expect("fits");
    let (first, last) = (plan.law().knots()[0], plan.law().knots()[plan.law().knots().len() - 1]);
    assert_eq!((first.value.to_bits(), first.first.to_bits()), (0, 0));
    assert_eq!(last.value.to_bits(), (4.0 * TURN_RAD).to_bits());
    assert_eq!((last.first.abs().to_bits(), last.second.abs().to_bits()), (0, 0));
    for i in 0..=20_000 {
        let s = plan.law().sample(plan.law().end() * f64::from(i) / 20_000.0);
        assert!(s.first >= -1e-12 && s.first <= 6.0 + 1e-9);
    }
}

/// e cos θ at constant speed: Ẋ = eω, Ẍ = eω², X⃛ = eω³, so the largest speed is known on paper.
#[test]
fn the_largest_speed_of_an_eccentric_is_the_one_on_paper() {
    let (path, infeed) = (eccentric(40.0, 40.0), schedule());
    let error = SpeedPlan::new(&request(&path, &infeed, 30.0)).expect_err("too fast");
    let on_paper = libm::cbrt(PATH_SHARE * X.jerk / 40.0).min(libm::sqrt(PATH_SHARE * X.acceleration / 40.0)).min(12.5);
    let SpeedPlanError::TooFast { worst, largest_rad_s: Some(largest), .. } = error.clone() else {
        panic!("{error}");
    };
    // The limit that is named is the one that sets the largest speed.
    assert_eq!(worst.axis, Axis::X);
    assert!((30.0 / worst.speed_ratio() / on_paper - 1.0).abs() < 3e-3, "{worst}");
    assert!((largest / on_paper - 1.0).abs() < 3e-3, "{largest} {on_paper}");
    let text = error.to_string();
    assert!(
        text.starts_with("the work speed of 286.48 rpm (30 rad/s) exceeds ") && text.contains("x_axis reaches a "),
        "{text}"
    );
    assert!(text.contains("the largest work speed that fits is"), "{text}");
    SpeedPlan::new(&request(&path, &infeed, largest)).expect("the refusal named a speed that fits");
}

#[test]
fn a_work_speed_beyond_c_is_refused_for_c() {
    let (path, infeed) = (eccentric(25.0, 0.0), schedule());
    let error = SpeedPlan::new(&request(&path, &infeed, 40.0)).expect_err("C does 31.4 rad/s");
    let words = "the work speed of 381.97 rpm (40 rad/s) exceeds 299.85 rpm (31.4 rad/s), the limit of c_axis; ";
    assert!(error.to_string().starts_with(words), "{error}");
    assert!(error.to_string().contains("that fits is 31.39 rad/s"), "{error}");
}

#[test]
fn ramps_longer_than_the_cut_are_refused() {
    let (path, infeed) = (eccentric(25.0, 0.0), schedule());
    let lazy = MotionLimits { acceleration: 1.0, ..C };
    let error = SpeedPlan::new(&SpeedRequest { c: lazy, ..request(&path, &infeed, 6.0) }).expect_err("a lazy axis");
    assert!(matches!(error, SpeedPlanError::NoPlateau { turns: 4, .. }), "{error}");
}

/// Near the limits, from every start phase: limits hold on an eight times finer grid and a stop exists.
#[test]
fn a_plan_near_its_limits_passes_from_any_start_phase() {
    let (path, infeed) = (eccentric(30.0, 12.0), schedule());
    let mut asked = request(&path, &infeed, 31.0);
    let Err(SpeedPlanError::TooFast { .. }) = SpeedPlan::new(&asked) else { panic!("too fast") };
    for i in 0..6 {
        asked.path_start_rad = f64::from(i);
        asked.speed = SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: 31.0 };
        let Err(SpeedPlanError::TooFast { largest_rad_s: Some(largest), .. }) = SpeedPlan::new(&asked) else {
            panic!("too fast")
        };
        asked.speed = SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: largest };
        let plan = SpeedPlan::new(&asked).expect("the speed named fits");
        assert!(plan.tightest().expect("six limits").ratio() > 0.98);
        assert!(plan.stop_ticks() < 3000, "{}", plan.stop_ticks());
    }
}

/// Laws that let the speed vary: faster than any constant speed that keeps their bound, and proven by differences.
#[test]
fn at_a_constant_removal_rate_a_cut_is_faster_than_at_any_constant_speed() {
    let (path, infeed) = (eccentric(25.0, 8.0), schedule());
    let law = SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 20.0, max_rad_s: 31.4 };
    let asked = SpeedRequest { speed: law, ..request(&path, &infeed, 1.0) };
    let plan = SpeedPlan::new(&asked).unwrap_or_else(|error| panic!("{error}"));
    let cutting = Cutting {
        wheel_radius_mm: 60.0,
        wheel_speed_m_s: 80.0,
        infeed_per_turn_mm: 0.18,
        infeed_direction: InfeedDirection::X,
    };
    let slowest = (0..3600)
        .map(|i| largest_speed_rad_s(&law, path.sample(f64::from(i) * TURN_RAD / 3600.0), &cutting))
        .fold(f64::INFINITY, f64::min);
    assert!(plan.turn_s() < 0.95 * TURN_RAD / slowest, "{} s against {} s", plan.turn_s(), TURN_RAD / slowest);
    assert!(plan.minimum_turn_s().is_some_and(|min| min < plan.turn_s()));
    let (low, high) = plan.speed_range_rad_s();
    assert!(low < high && high <= 31.4);
    assert_eq!(plan.turns(), 4);
    let last = plan.law().knots()[plan.law().knots().len() - 1];
    assert_eq!(last.value.to_bits(), (4.0 * TURN_RAD).to_bits());
}

#[test]
fn a_law_without_a_speed_is_refused() {
    let (path, infeed) = (eccentric(25.0, 8.0), schedule());
    let law = SpeedLaw::TimeOptimal { max_rad_s: 0.0 };
    let error = SpeedPlan::new(&SpeedRequest { speed: law, ..request(&path, &infeed, 1.0) }).expect_err("no speed");
    assert!(matches!(error, SpeedPlanError::Turn(_)), "{error}");
}

/// 0.18 mm a turn off a disc of radius 20 mm at 5 rad/s is 18 mm²/s: at 50 J/mm³, and next to no rubbing, 900 W/mm of width.
#[test]
fn the_power_of_the_wheel_bounds_every_law() {
    let (path, infeed) = (eccentric(20.0, 0.0), schedule());
    let power = WheelPower { max_w: 9000.0, specific_energy_j_mm3: 50.0, rubbing_n_mm2: 1e-9 };
    let asked =
        |speed: SpeedLaw| SpeedRequest { speed, wheel_power: Some(power.as_law(10.0)), ..request(&path, &infeed, 1.0) };
    let too_fast = SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: 5.01 };
    let error = SpeedPlan::new(&asked(too_fast)).expect_err("more than its power");
    let SpeedPlanError::WheelPower { allowed_rad_s, largest_rad_s: Some(largest), .. } = error else {
        panic!("{error}");
    };
    assert!((allowed_rad_s - 5.0).abs() < 1e-6 && (4.99..=5.0).contains(&largest), "{allowed_rad_s} {largest}");
    SpeedPlan::new(&asked(SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: largest })).expect("the speed named fits");
    for law in [
        SpeedLaw::TimeOptimal { max_rad_s: 31.4 },
        SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 100.0, max_rad_s: 31.4 },
    ] {
        let plan = SpeedPlan::new(&asked(law)).unwrap_or_else(|error| panic!("{error}"));
        let (_, high) = plan.speed_range_rad_s();
        assert!(high <= 5.0 + 1e-6 && plan.turn_s() < TURN_RAD / 4.97, "{high} rad/s, {} s", plan.turn_s());
    }
}
