// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Several passes over a lobe, each with its own infeed and speed.

use super::*;
use crate::interpolator::MotionOutcome;

fn in_two_passes() -> JobSpec {
    let mut job = job();
    job.lobes.truncate(2);
    let finish = PassSpec {
        name: String::from("grind"),
        total_infeed_mm: 0.018,
        infeed_per_block_mm: 0.000_005,
        infeed_of_turns_mm: Vec::new(),
        air_mm: 0.0,
        infeed_course: InfeedCourse::PerAngle,
        infeed_direction: InfeedDirection::X,
        spark_out_turns: 2,
        spark_out_until_n: None,
        gauge_size: None,
        speed: SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: rad_s_from_rpm(60.0) },
    };
    let rough = PassSpec {
        name: String::from("rough"),
        total_infeed_mm: 0.36,
        infeed_per_block_mm: 0.000_05,
        infeed_of_turns_mm: Vec::new(),
        air_mm: 0.0,
        infeed_course: InfeedCourse::PerAngle,
        infeed_direction: InfeedDirection::X,
        spark_out_turns: 1,
        spark_out_until_n: None,
        gauge_size: None,
        speed: SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 40.0, max_rad_s: 31.0 },
    };
    job.passes = vec![rough, finish];
    job
}

/// Roughing without spark-out: it has a turn less, ends at its phase on the same count, and the finish takes the step that it leaves. In
/// the last pass the step stays.
#[test]
fn a_pass_without_spark_out_ends_with_its_infeed() {
    let x = machine().axis(Axis::X).scale;
    for (rough, finish) in [(0, 2), (1, 0), (0, 0)] {
        let mut job = in_two_passes();
        (job.passes[0].spark_out_turns, job.passes[1].spark_out_turns) = (rough, finish);
        job.passes[1].infeed_per_block_mm = 0.000_002_5;
        let planned = planned(&job);
        for lobe in 0..2 {
            let cuts: Vec<_> = planned.plan.cuts_of(lobe).collect();
            let turns: Vec<_> = cuts.iter().map(|cut| (cut.turns, cut.infeed_turns)).collect();
            assert_eq!(turns, [(2 + rough, 2), (2 + finish, 2)]);
            let begin_mm = planned.lobes[lobe].tool_path.sample(planned.lobes[lobe].start_rad).value;
            for (cut, left_mm) in cuts.iter().zip([0.018, 0.0]) {
                let motion = planned.plan.motion_of(cut).expect("its splines");
                let end = motion.at(motion.duration_s());
                assert!((x.counts(end.x.value) - x.counts(begin_mm + left_mm)).abs() <= 1, "{end:?}");
            }
        }
        let left_um = planned.lobes[0].passes[1].infeed().left_on_part_mm(finish);
        assert_eq!(left_um > 0.0, finish == 0);
    }
}

/// Every pass ends at the phase it began at and where the next one begins, the last one on the finished path.
#[test]
fn each_pass_begins_where_the_one_before_ended() {
    let planned = planned(&in_two_passes());
    let (machine, plan) = (machine(), &planned.plan);
    let x = machine.axis(Axis::X).scale;
    for lobe in 0..2 {
        let cuts: Vec<_> = plan.cuts_of(lobe).collect();
        assert_eq!(cuts.iter().map(|cut| (cut.turns, cut.infeed_turns)).collect::<Vec<_>>(), [(3, 2), (3, 1)]);
        let ends = |pass: usize| {
            let motion = plan.motion_of(cuts[pass]).expect("its splines");
            (x.counts(motion.at(0.0).x.value), x.counts(motion.at(motion.duration_s()).x.value))
        };
        let (rough, finish) = (ends(0), ends(1));
        assert_eq!((rough.0 - rough.1, rough.1 - finish.0, finish.0 - finish.1), (36_000, 0, 1800));
        assert!(
            (x.position(finish.1) - planned.lobes[lobe].tool_path.sample(planned.lobes[lobe].start_rad).value).abs()
                < 1e-5
        );
        assert!(cuts[0].turn_s < 0.9 * cuts[1].turn_s, "roughing is faster: {} s", cuts[0].turn_s);
    }
    let stocks: Vec<f64> = plan.segments.iter().filter(|s| s.phase == Phase::Cut).map(|s| s.stock_mm).collect();
    assert_eq!(stocks, [0.3, 0.018, 0.3, 0.018]);
    assert!(planned.report.max_ratio() <= 1.0 + 1e-6, "{:?}", planned.report);
}

#[test]
fn both_passes_are_executed_without_an_alarm() {
    let simulated = simulated(planned(&in_two_passes()).plan, &machine(), |_, _| {});
    assert_eq!(simulated.outcome, MotionOutcome::Completed);
}

#[test]
fn a_pass_that_fits_no_whole_turns_is_named() {
    let error = refusal(|job| {
        *job = in_two_passes();
        job.passes[0].total_infeed_mm = 0.35;
    });
    assert!(error.to_string().starts_with("pass rough: "), "{error}");
}
