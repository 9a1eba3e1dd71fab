//! C turning on from one cut to the next: undisturbed, held, slowed down, cancelled and stopped at any tick.

use crate::bench::{Bench, Random, SAFE_X, TURN, machine, two_cuts};
use camwright::interpolator::{Outcome, Request, State};
use camwright::job::SpeedLaw;
use camwright::machine::description::AXIS_COUNT;
use camwright::plan::Plan;

fn speeds() -> [SpeedLaw; 2] {
    [
        SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: 6.0 },
        SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 30.0, most_rad_s: 12.0 },
    ]
}

fn plans() -> [(Plan, [i64; AXIS_COUNT]); 2] {
    speeds().map(|speed| two_cuts(&machine(), speed))
}

fn started(plan: &Plan, start: [i64; AXIS_COUNT]) -> Bench {
    let mut bench = Bench::at(machine(), start);
    bench.start_plan(plan.clone());
    bench
}

/// Ends where the second cut closes: at its own phase after whole turns, X at size, then retracted.
fn assert_ended(bench: &Bench, what: &str) {
    assert_eq!(bench.counts()[0].rem_euclid(TURN), TURN / 3, "{what}");
    assert_eq!(bench.counts()[1], SAFE_X, "{what}");
    bench.assert_limits(what);
    bench.assert_at_rest(what);
}

#[test]
fn c_turns_from_the_first_cut_to_the_end_of_the_second() {
    for (plan, start) in plans() {
        let mut bench = started(&plan, start);
        assert_eq!(bench.finish(20_000), Outcome::Completed);
        assert_ended(&bench, "undisturbed");
        let turning = |row: &&crate::bench::Row| row.setpoint.velocity[0] > 0.0;
        let first = bench.rows.iter().position(|row| turning(&row)).unwrap();
        let last = bench.rows.iter().rposition(|row| turning(&row)).unwrap();
        assert!(bench.rows[first..=last].iter().all(|row| turning(&row)));
        // Between the cuts C comes to the speed of the second and keeps it.
        let indexing = bench.rows.iter().filter(|row| row.status.segment == 2);
        assert!(indexing.skip(50).all(|row| (row.setpoint.velocity[0] - 3.0).abs() < 1e-12));
    }
}

/// Whatever is held, whenever and for however long: limits hold and the end is the same.
#[test]
fn a_hold_anywhere_lets_the_phase_go_by_and_the_cut_begins_later() {
    let seed = 11;
    let mut random = Random(seed);
    let plans = plans();
    for case in 0..60 {
        let (plan, start) = &plans[case % 2];
        let (hold, length) = (1 + random.below(7_000), 1 + random.below(2_500));
        let what = format!("seed {seed} case {case}: hold at {hold} for {length}");
        let mut bench = started(plan, *start);
        while (bench.rows.len() as u64) < hold && bench.outcome.is_none() {
            bench.step(&[]);
        }
        if bench.outcome.is_some() {
            continue;
        }
        bench.step(&[Request::Hold]);
        for _ in 0..length {
            bench.step(&[]);
        }
        bench.step(&[Request::Unhold]);
        assert_eq!(bench.finish(30_000), Outcome::Completed, "{what}");
        assert_ended(&bench, &what);
    }
}

/// A hold between the cuts stops the table; C turns on.
#[test]
fn a_hold_between_the_cuts_leaves_c_turning() {
    let (plan, start) = &plans()[0];
    let mut bench = started(plan, *start);
    while bench.rows.last().is_none_or(|row| row.status.segment < 1) {
        bench.step(&[]);
    }
    for _ in 0..100 {
        bench.step(&[]);
    }
    bench.step(&[Request::Hold]);
    for _ in 0..1000 {
        bench.step(&[]);
    }
    let row = *bench.last();
    assert_eq!((row.status.state, row.status.segment), (State::Held, 1));
    assert_eq!(row.setpoint.velocity[1..], [0.0, 0.0]);
    assert!((row.setpoint.velocity[0] - 3.0).abs() < 1e-12);
    bench.step(&[Request::Unhold]);
    assert_eq!(bench.finish(20_000), Outcome::Completed);
    assert_ended(&bench, "held between the cuts");
}

#[test]
fn holds_and_overrides_in_any_order_keep_the_limits() {
    let seed = 23;
    let mut random = Random(seed);
    let plans = plans();
    for case in 0..40 {
        let (plan, start) = &plans[case % 2];
        let what = format!("seed {seed} case {case}");
        let mut bench = started(plan, *start);
        for _ in 0..30 {
            for _ in 0..random.below(400) {
                bench.step(&[]);
            }
            let request = match random.below(4) {
                0 => Request::Hold,
                1 => Request::SetOverride(random.next()),
                _ => Request::Unhold,
            };
            if bench.outcome.is_none() {
                bench.step(&[request]);
            }
        }
        if bench.outcome.is_none() {
            bench.step(&[Request::SetOverride(1.0), Request::Unhold]);
        }
        assert_eq!(bench.finish(60_000), Outcome::Completed, "{what}");
        assert_ended(&bench, &what);
    }
}

#[test]
fn a_cancel_anywhere_ends_at_rest_with_the_wheel_retracted() {
    for (plan, start) in plans() {
        for cancel in (1..8_000).step_by(97) {
            let what = format!("cancel at {cancel}");
            let mut bench = started(&plan, start);
            while (bench.rows.len() as u64) < cancel && bench.outcome.is_none() {
                bench.step(&[]);
            }
            if bench.outcome.is_some() {
                continue;
            }
            bench.step(&[Request::Cancel]);
            assert_eq!(bench.finish(5_000), Outcome::Cancelled, "{what}");
            bench.assert_limits(&what);
            bench.assert_at_rest(&what);
            assert!(bench.counts()[1] >= SAFE_X, "{what}: {:?}", bench.counts());
        }
    }
}

#[test]
fn an_alarm_anywhere_brings_c_to_rest_too() {
    for (plan, start) in plans() {
        for alarm in (50..8_000).step_by(173) {
            let mut bench = started(&plan, start);
            while (bench.rows.len() as u64) < alarm && bench.outcome.is_none() {
                bench.step(&[]);
            }
            if bench.outcome.is_some() {
                continue;
            }
            assert!(bench.interpolator.alarm(bench.tick, 42));
            for _ in 0..bench.machine.feedback_delay_ticks {
                bench.step(&[]);
            }
            if bench.outcome.is_some() {
                continue;
            }
            assert_eq!(bench.finish(3_000), Outcome::Failed(42), "alarm at {alarm}");
            bench.assert_limits(&format!("alarm at {alarm}"));
            bench.assert_at_rest("alarm");
        }
    }
}

/// A switch that never closes: the interpolator's own alarm, and C comes to rest before the motion ends.
#[test]
fn a_station_that_is_not_found_brings_c_to_rest_before_the_motion_ends() {
    let (mut plan, start) = two_cuts(&machine(), speeds()[0]);
    // The table searches from behind its switch.
    let far = crate::bench::to(&machine(), camwright::machine::description::Axis::Z, 200 * crate::bench::PER_MM);
    plan.segments[1].kind = camwright::plan::SegmentKind::Move(vec![far]);
    let mut bench = started(&plan, start);
    assert_eq!(bench.finish(20_000), Outcome::Failed(91));
    bench.assert_limits("no station");
    bench.assert_at_rest("no station");
    assert_eq!(bench.last().status.state, State::Fault);
}
