// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Impossible jobs are refused in one sentence: problem, value, limit, location.

use super::*;
use crate::job::grinding::JobError;
use crate::job::speed_variation::SpeedVariation;

#[test]
fn two_lobes_on_one_station_are_refused() {
    let error = refusal(|job| job.lobes[2].station = String::from("LS1"));
    assert_eq!(error.to_string(), "lobes I1 and I2 are both at station LS1; a station holds one lobe");
}

#[test]
fn a_station_without_a_switch_is_refused() {
    let error = refusal(|job| job.lobes[2].station = String::from("LS9"));
    assert!(
        error
            .to_string()
            .starts_with("lobe I2: station LS9 has no limit switch on machine test grinder, which has LS1")
    );
}

#[test]
fn jobs_without_what_they_need_are_refused() {
    assert_eq!(refusal(|job| job.lobes.clear()), JobError::NoLobes.into());
    assert_eq!(refusal(|job| job.passes.clear()), JobError::PassCount { count: 0, max: 16 }.into());
    let error = refusal(|job| {
        job.passes[0].spark_out_turns = 0;
        job.passes[0].spark_out_until_n = Some(2);
    });
    assert!(error.to_string().contains("spark_out_turns is 0; it must be at least 1 for spark_out_until_n"), "{error}");
    let error = refusal(|job| job.lobes[1].width_mm = 26.0);
    assert!(error.to_string().starts_with("lobe E1: width 26 mm is more than the wheel's 25 mm"), "{error}");
    assert!(error.to_string().contains("plunge_overlap_mm"), "{error}");
    let error = refusal(|job| job.lobes[1].profile = 2);
    assert!(error.to_string().contains("profile 2 does not exist; the job has 2"), "{error}");
    let error = refusal(|job| job.lobes[1].name = String::from("I1"));
    assert!(error.to_string().contains("lobes 1 and 2 are both named I1"), "{error}");
    let error = refusal(|job| job.stock_mm = f64::NAN);
    assert_eq!(error.to_string(), "stock_mm is NaN; it must be a number above 0");
}

/// A variation of the work speed is within its ranges, and no faster than the axes can change their speed.
#[test]
fn variations_of_the_work_speed_that_cannot_be_are_refused() {
    let with = |slower: f64, period_turns: f64| {
        refusal(|job| job.speed_variation = Some(SpeedVariation { slower, period_turns })).to_string()
    };
    assert_eq!(with(0.9, 2.0), "speed_variation.slower is 0.9; it must be 0.01 to 0.75 (1 to 75 %)");
    assert_eq!(with(0.2, 1.0), "speed_variation.period_turns is 1; it must be 1.5 to 3");
    let error = refusal(|job| {
        job.speed_variation = Some(SpeedVariation { slower: 0.2, period_turns: 1.5 });
        job.passes[0].speed = SpeedLaw::TimeOptimal { max_rad_s: 1e4 };
    });
    let PlanError::VariationTooFast { shortest_turns, .. } = &error else { panic!("{error}") };
    assert!(*shortest_turns > 1.5 && error.to_string().contains("a change of the work speed takes half of"), "{error}");
}

/// A plan of a year is a mistyped speed, and one of the age of the universe has knots that are the same float.
#[test]
fn cuts_that_take_longer_than_a_day_are_refused() {
    let at = |work_speed_rad_s: f64| {
        refusal(|job| job.passes[0].speed = SpeedLaw::ConstantWorkSpeed { work_speed_rad_s }).to_string()
    };
    for speed in [1e-8, 1e-13, 1e-300, 1e300, f64::INFINITY] {
        let text = at(speed);
        assert!(text.contains("work_speed_rad_s") && text.contains("it must be"), "{speed}: {text}");
    }
    let slow = |job: &mut JobSpec| {
        job.passes[0].spark_out_turns = 1000;
        job.passes[0].speed = SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: 0.01 };
    };
    let text = refusal(slow).to_string();
    assert!(text.contains("takes 174.88 h, the maximum is 24 h"), "{text}");
    let starved = |job: &mut JobSpec| {
        job.passes[0].speed = SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 1e-9, max_rad_s: 10.0 };
    };
    let text = refusal(starved).to_string();
    assert!(text.contains("h, the maximum is 24 h"), "{text}");
}

#[test]
fn numbers_beyond_any_machine_are_refused() {
    type Change = fn(&mut JobSpec);
    let changes: [(&str, Change); 8] = [
        ("home.x_mm", |job| job.home.x_mm = 1e300),
        ("rapid_advance_mm", |job| job.rapid_advance_mm = 1e300),
        ("rapid_speed_mm_s", |job| job.rapid_speed_mm_s = 1e-300),
        ("retract_clearance_mm", |job| job.retract_clearance_mm = 1e18),
        ("phase_rad", |job| job.lobes[0].phase_rad = 1e18),
        ("spark_out_turns", |job| job.passes[0].spark_out_turns = u32::MAX),
        ("total_infeed_mm", |job| job.passes[0].total_infeed_mm = 1e300),
        ("clearance_mm", |job| job.clearance_mm = 1e300),
    ];
    for (key, change) in changes {
        let text = refusal(change).to_string();
        assert!(text.contains(key) && text.contains("it must be"), "{key}: {text}");
    }
}

#[test]
fn lobes_nearer_than_the_wheel_is_wide_are_refused() {
    let mut machine = machine();
    machine.stations[1].position_mm = 55.0;
    let error = plan_job(&job(), &machine, 60.0, None).expect_err("15 mm apart");
    assert!(error.to_string().contains("15 mm away; at least 19.5 mm"), "{error}");
}

#[test]
fn an_infeed_of_no_whole_turns_is_refused_with_its_neighbours() {
    let error = refusal(|job| job.passes[0].total_infeed_mm = 0.35);
    assert!(error.to_string().starts_with("pass grind: total infeed 0.35 mm is 1.9444 turns"), "{error}");
    assert!(error.to_string().contains("nearest total infeed is 0.18 or 0.36 mm"), "{error}");
}

#[test]
fn a_work_speed_beyond_an_axis_is_refused_with_the_largest_that_fits() {
    let too_fast = |job: &mut JobSpec| {
        job.passes[0].speed = SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: rad_s_from_rpm(280.0) };
    };
    let error = refusal(too_fast);
    let text = error.to_string();
    assert!(
        text.starts_with("lobe I1, pass grind: the work speed of 280 rpm (29.322 rad/s) exceeds ")
            && text.contains(", the speed at which x_axis reaches a "),
        "{text}"
    );
    assert!(text.contains("at cam angle") && text.contains("the largest work speed that fits"), "{text}");
}

#[test]
fn a_rapid_advance_into_the_blank_is_refused() {
    let error = refusal(|job| job.stock_mm = 0.36);
    let text = error.to_string();
    assert!(
        text.starts_with("lobe I1: the rapid advance ends 0.3") && text.contains("inside the 0.36 mm of stock"),
        "{text}"
    );
    // On the flank of I1 the wheel is nearer than its offset in X says; on a base it is not.
    let PlanError::TouchesBlank { gap_mm, .. } = error else { panic!("{text}") };
    assert!(gap_mm < 0.36 - 1e-4);
    refusal(|job| {
        job.stock_mm = 0.36;
        job.lobes.truncate(1);
        job.lobes[0].phase_rad = 0.0;
    });
    let mut bare = job();
    bare.lobes.truncate(1);
    bare.lobes[0].phase_rad = 0.0;
    bare.stock_mm = 0.359;
    planned(&bare);
}

#[test]
fn a_rapid_retract_that_stays_among_the_lobes_is_refused() {
    let error = refusal(|job| job.rapid_advance_mm = 5.0);
    assert!(error.to_string().contains("the rapid retract leaves x_axis at"), "{error}");
    let error = refusal(|job| job.home.x_mm = 20.0);
    assert!(error.to_string().contains("home.x_mm leaves x_axis at 20.000 mm"), "{error}");
}

#[test]
fn positions_beyond_soft_limits_are_refused() {
    let error = refusal(|job| job.rapid_advance_mm = 170.0);
    assert!(error.to_string().contains("the start of the rapid advance needs x_axis at"), "{error}");
    let error = refusal(|job| job.home.z_mm = -30.0);
    assert_eq!(error.to_string(), "the home position needs z_axis at -30.0000 mm; its soft limits are -20 to 400 mm");
    let mut machine = machine();
    machine.stations[3].position_mm = 398.0;
    let error = plan_job(&job(), &machine, 60.0, None).expect_err("the search ends beyond");
    assert!(error.to_string().contains("the end of the search for the station's switch"), "{error}");
    machine.axes[Axis::X.index()].soft_limits = Some((17.0, 180.0));
    let error = plan_job(&job(), &machine, 60.0, None).expect_err("the base is at 16 mm");
    assert!(error.to_string().contains("the lowest point of the path needs x_axis at 16.0000 mm"), "{error}");
}

#[test]
fn undercut_and_a_wheel_too_large_are_refused() {
    let error = refusal(|job| {
        job.profiles[1] = lobe_profile("exhaust", 14.0, 40.0);
        job.profiles[1].follower = Follower::Flat;
    });
    assert!(error.to_string().starts_with("profile exhaust: "), "{error}");
    let error = refusal(|job| job.profiles[1] = lobe_profile("exhaust", 9.0, 50.0));
    assert!(matches!(&error, PlanError::Path { profile, .. } if profile == "exhaust"), "{error}");
}
