// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Path following of trajectories: tolerances on the path and at the end, timed starts, and replacement.

use super::bench::{Bench, PER_MM, TestNoise, machine};
use camwright::interpolator::tolerance::{FollowingTolerances, MotionPhase, Tolerance};
use camwright::interpolator::trajectory::{Trajectory, TrajectoryPoint, TrajectoryStart};
use camwright::interpolator::{
    AppliedInput, ExecutionState, Motion, MotionOutcome, MotionRequest, Prepared, StartError, StateForecast, StepOutput,
};
use camwright::machine::description::Axis;
use camwright::machine::setpoint::{Measured, Setpoint};

fn point(time_s: f64, x_mm: f64) -> TrajectoryPoint {
    TrajectoryPoint { time_s, positions: vec![x_mm], ..TrajectoryPoint::default() }
}

/// X from 0 to 20 mm in 1 s; it is fastest at half time, 1.875 · 20 mm/s.
fn twenty_mm(tolerances: FollowingTolerances) -> Trajectory {
    let points = [point(1.0, 20.0)];
    let trajectory =
        Trajectory::from_points(&[Axis::X], &points, &TrajectoryStart::default(), &machine()).expect("within limits");
    trajectory.with_tolerances(tolerances)
}

fn of_x(position: Option<f64>, velocity: Option<f64>) -> [Tolerance; 3] {
    let mut tolerances = [Tolerance::default(); 3];
    tolerances[Axis::X.index()] = Tolerance { position, velocity, acceleration: None };
    tolerances
}

/// Steps with an axis that comes after its setpoint by a time constant; it is measured every tenth tick, after `delay` ticks.
struct LaggingAxis {
    lag_ticks: usize,
    delay: u64,
    setpoints: Vec<Setpoint>,
    measured: Vec<Measured>,
}

impl LaggingAxis {
    fn new(lag_ticks: usize, delay: u64) -> Self {
        Self { lag_ticks, delay, setpoints: Vec::new(), measured: Vec::new() }
    }

    fn step(&mut self, bench: &mut Bench, requests: &[MotionRequest]) -> StepOutput {
        let tick = bench.tick;
        self.measured.retain(|measured| {
            let is_due = measured.tick + self.delay <= tick;
            if is_due {
                bench.interpolator.measured(measured);
            }
            !is_due
        });
        let out = bench.step(requests);
        self.setpoints.push(out.setpoint);
        if tick.is_multiple_of(10) {
            let then = self.setpoints[self.setpoints.len().saturating_sub(1 + self.lag_ticks)];
            self.measured.push(Measured { tick, counts: then.counts, velocity: then.velocity });
        }
        out
    }

    fn finish(&mut self, bench: &mut Bench, max: u64) -> MotionOutcome {
        for _ in 0..max {
            if let Some(outcome) = bench.outcome {
                return outcome;
            }
            self.step(bench, &[]);
        }
        panic!("not finished after {max} ticks: {:?}", bench.rows.last());
    }
}

#[test]
fn a_broken_path_tolerance_ends_the_trajectory_at_rest_and_is_reported_with_its_size() {
    // 20 ms behind at v mm/s is 0.02 · v mm: 0.5 mm at 25 mm/s, which the law reaches when 30 u²(1 − u)² = 1.25.
    let law = twenty_mm(FollowingTolerances::default());
    let law = law.law(Axis::X).expect("X moves");
    let lag = |t: f64| law.sample(t).value - law.sample(t - 0.020).value;
    let first = (1..100_u32).map(|i| 0.010 * f64::from(i)).find(|t| lag(*t) > 0.5).expect("it is that fast");
    let tolerances = FollowingTolerances { path: of_x(Some(0.5), None), ..FollowingTolerances::default() };
    let mut runs = Vec::new();
    for delay in [1, 7, 20] {
        let mut bench = Bench::new(machine());
        bench.start(Motion::from(twenty_mm(tolerances)));
        let outcome = LaggingAxis::new(20, delay).finish(&mut bench, 3000);
        let MotionOutcome::OutOfTolerance(broken) = outcome else { panic!("{outcome:?}") };
        assert_eq!((broken.axis, broken.stretch, broken.allowed), (Axis::X, MotionPhase::Path, 0.5));
        assert!((broken.time_s - first).abs() < 1e-9, "{} {first}", broken.time_s);
        assert!((broken.error - lag(first)).abs() < 1e-4, "{} {}", broken.error, lag(first));
        bench.assert_limits("out of tolerance");
        bench.assert_at_rest("out of tolerance");
        // It goes on for D ticks, then stops on its path, far from its end.
        assert!(bench.counts()[1] > 0 && bench.counts()[1] < 20 * PER_MM, "{:?}", bench.counts());
        runs.push(bench.rows.iter().map(|row| row.setpoint.counts).collect::<Vec<_>>());
    }
    assert!(runs[0] == runs[1] && runs[1] == runs[2], "when a measurement arrives changes no setpoint");
    // An axis that keeps it, and a tolerance that is wide enough.
    for (lag_ticks, allowed) in [(0, 0.5), (20, 0.8)] {
        let tolerances = FollowingTolerances { path: of_x(Some(allowed), None), ..FollowingTolerances::default() };
        let mut bench = Bench::new(machine());
        bench.start(Motion::from(twenty_mm(tolerances)));
        assert_eq!(LaggingAxis::new(lag_ticks, 1).finish(&mut bench, 3000), MotionOutcome::Completed);
    }
}

#[test]
fn a_goal_is_reached_when_the_axes_are_there_and_missed_when_its_time_is_over() {
    let machine = machine();
    // 300 ticks behind: 0.3 s after the end it stands there; the tenth tick after that is measured.
    let goal = |ticks: Option<u64>| FollowingTolerances {
        goal: of_x(Some(0.001), Some(0.01)),
        goal_time_ticks: ticks,
        ..FollowingTolerances::default()
    };
    for ticks in [None, Some(400)] {
        let mut bench = Bench::new(machine.clone());
        bench.start(Motion::from(twenty_mm(goal(ticks))));
        assert_eq!(LaggingAxis::new(300, 1).finish(&mut bench, 3000), MotionOutcome::Completed);
        let over = bench.rows.len() as u64 - 1001;
        assert!((290..=330).contains(&over), "{over} ticks after the end, 20 of them until it is in sight");
        assert_eq!(bench.counts(), [0, 20 * PER_MM, 0]);
    }
    let mut bench = Bench::new(machine.clone());
    bench.start(Motion::from(twenty_mm(goal(Some(100)))));
    let outcome = LaggingAxis::new(300, 1).finish(&mut bench, 3000);
    let MotionOutcome::OutOfTolerance(broken) = outcome else { panic!("{outcome:?}") };
    assert_eq!((broken.axis, broken.stretch), (Axis::X, MotionPhase::Goal));
    assert!((broken.time_s - 0.110).abs() < 0.011, "{}", broken.time_s);
    let text = broken.to_string();
    assert!(text.starts_with("x_axis: position error ") && text.ends_with("s after the end"), "{text}");
    bench.assert_at_rest("missed goal");

    // Held at the end, cancelled there: it ends.
    let mut bench = Bench::new(machine);
    bench.start(Motion::from(twenty_mm(goal(None))));
    let mut lagging = LaggingAxis::new(100_000, 1);
    for _ in 0..1500 {
        lagging.step(&mut bench, &[]);
    }
    assert_eq!((bench.outcome, bench.last().status.state), (None, ExecutionState::Executing), "it waits");
    lagging.step(&mut bench, &[MotionRequest::Cancel]);
    assert_eq!(lagging.finish(&mut bench, 5), MotionOutcome::Cancelled);
}

#[test]
fn what_was_decided_by_measurements_is_among_the_inputs_that_are_recorded() {
    let tolerances = FollowingTolerances { goal: of_x(Some(0.001), None), ..FollowingTolerances::default() };
    let mut bench = Bench::new(machine());
    bench.start(Motion::from(twenty_mm(tolerances)));
    let (mut lagging, mut settled) = (LaggingAxis::new(3, 5), Vec::new());
    while bench.outcome.is_none() {
        let tick = bench.tick;
        let out = lagging.step(&mut bench, &[]);
        settled.extend(out.applied.iter().filter(|input| **input == AppliedInput::Settled).map(|_| tick));
    }
    assert_eq!(settled, [2000 + 20], "three ticks before its end, at tick 2000, it is there but for 5 nm; D is 20");
}

#[test]
fn a_trajectory_waits_for_its_tick_at_rest_and_can_be_held_and_cancelled_there() {
    let machine = machine();
    let prepared = || {
        let motion = Motion::from(twenty_mm(FollowingTolerances::default()));
        Box::new(Prepared::new(motion, &machine).expect("good").starting_at(1500))
    };
    let mut bench = Bench::new(machine.clone());
    bench.interpolator.start(prepared()).expect("idle");
    assert_eq!(bench.finish(3000), MotionOutcome::Completed);
    let first = bench.rows.iter().find(|row| row.setpoint.velocity[1] != 0.0).expect("it moves").tick;
    assert_eq!((first, bench.last().tick), (1501, 2500));
    // Held over its start it begins when it is let go, and not before.
    let mut bench = Bench::new(machine.clone());
    bench.interpolator.start(prepared()).expect("idle");
    for _ in 0..100 {
        bench.step(&[]);
    }
    bench.step(&[MotionRequest::Hold]);
    for _ in 0..900 {
        bench.step(&[]);
    }
    assert_eq!((bench.last().status.state, bench.counts()), (ExecutionState::Held, [0; 3]));
    bench.step(&[MotionRequest::Unhold]);
    assert_eq!(bench.finish(3000), MotionOutcome::Completed);
    bench.assert_limits("held before its start");
    assert_eq!(bench.counts()[1], 20 * PER_MM);
    // Cancelled before its start nothing moves.
    let mut bench = Bench::new(machine.clone());
    bench.interpolator.start(prepared()).expect("idle");
    bench.step(&[]);
    bench.step(&[MotionRequest::Cancel]);
    assert_eq!(bench.outcome, Some(MotionOutcome::Cancelled));
    assert!(bench.rows.iter().all(|row| row.setpoint == Setpoint::default()));
}

/// Seeded: wherever one trajectory takes the place of another, position, velocity and acceleration go on without a step and every
/// limit is kept, at any rate of time; and the new one ends where it should.
#[test]
fn one_trajectory_takes_the_place_of_another_without_a_step() {
    let machine = machine();
    let mut random = TestNoise(0x5711_ce01);
    let mut spliced = 0;
    for case in 0..200 {
        let mut bench = Bench::new(machine.clone());
        bench.start(Motion::from(twenty_mm(FollowingTolerances::default())));
        let factor = if case % 3 == 0 { 1.0 } else { 0.2 + 0.8 * random.next() };
        bench.step(&[MotionRequest::SetOverride(factor)]);
        let at = 5 + random.below(900);
        for _ in 0..at {
            bench.step(&[]);
        }
        let tick = bench.tick + random.below(30);
        let StateForecast::At(start) = bench.interpolator.foresee(tick) else { continue };
        let target = 5.0 + 20.0 * random.next();
        let points = [point(0.3 + 1.5 * random.next(), target)];
        // Too sharp a turn is refused with what it would exceed, before anything changes.
        let Ok(trajectory) = Trajectory::from_points(&[Axis::X], &points, &start, &machine) else { continue };
        let motion = Box::new(Prepared::new(Motion::from(trajectory), &machine).expect("good"));
        while bench.tick < tick {
            bench.step(&[]);
        }
        bench.interpolator.splice(tick, motion).unwrap_or_else(|(error, _)| panic!("case {case}: {error}"));
        assert!(bench.interpolator.take_finished().is_some(), "the one before is given back");
        assert_eq!(bench.finish(20_000), MotionOutcome::Completed, "case {case}");
        bench.assert_limits(&format!("case {case}"));
        bench.assert_at_rest(&format!("case {case}"));
        assert_eq!(bench.counts(), [0, machine.axis(Axis::X).scale.counts(target), 0], "case {case}");
        spliced += 1;
    }
    assert!(spliced > 100, "{spliced} of 200 were gentle enough");
}

#[test]
fn a_trajectory_takes_no_place_that_was_disturbed_and_moving_joints_must_be_named() {
    let machine = machine();
    let moving = || {
        let mut bench = Bench::new(machine.clone());
        bench.start(Motion::from(twenty_mm(FollowingTolerances::default())));
        for _ in 0..400 {
            bench.step(&[]);
        }
        bench
    };
    let mut bench = moving();
    let tick = bench.tick + 3;
    let StateForecast::At(start) = bench.interpolator.foresee(tick) else { panic!("it moves") };
    assert!(start.is_moving(Axis::X) && !start.is_moving(Axis::Z));
    let z = [TrajectoryPoint { time_s: 1.0, positions: vec![5.0], ..TrajectoryPoint::default() }];
    let error = Trajectory::from_points(&[Axis::Z], &z, &start, &machine).expect_err("X still moves");
    assert_eq!(error.to_string(), "joint x_axis still moves and the new trajectory does not name it");
    let sharp = Trajectory::from_points(&[Axis::X], &[point(0.05, 0.0)], &start, &machine).expect_err("too sharp");
    assert!(sharp.to_string().contains("x_axis") && sharp.to_string().contains("the machine allows"), "{sharp}");

    let trajectory = Trajectory::from_points(&[Axis::X], &[point(1.0, 0.0)], &start, &machine).expect("gentle");
    let prepared = || Box::new(Prepared::new(Motion::from(trajectory.clone()), &machine).expect("good"));
    // Too early by a tick, and after a hold: refused, and the one in execution goes on.
    bench.step(&[]);
    let (error, _) = bench.interpolator.splice(bench.tick, prepared()).expect_err("a tick too early");
    assert_eq!(error, StartError::MovesOtherwise);
    bench.step(&[MotionRequest::Hold]);
    bench.step(&[]);
    assert_eq!(bench.tick, tick);
    assert_eq!(bench.interpolator.foresee(tick + 5), StateForecast::Held);
    assert!(bench.interpolator.splice(tick, prepared()).is_err());
    bench.step(&[MotionRequest::Unhold]);
    assert_eq!(bench.finish(3000), MotionOutcome::Completed);
    assert_eq!(bench.counts()[1], 20 * PER_MM);
    // Nothing to take the place of: idle, and beyond the end.
    assert_eq!(bench.interpolator.foresee(bench.tick + 1), StateForecast::Over);
    let mut bench = moving();
    assert_eq!(bench.interpolator.foresee(bench.tick + 2000), StateForecast::Over);
    bench.step(&[MotionRequest::Cancel]);
    assert_eq!(bench.interpolator.foresee(bench.tick + 1), StateForecast::Over);
}

/// One that waits for its time deflects to one that begins at once.
#[test]
fn a_trajectory_that_waits_gives_way() {
    let machine = machine();
    let motion = Motion::from(twenty_mm(FollowingTolerances::default()));
    let waiting = Box::new(Prepared::new(motion, &machine).expect("good").starting_at(100_000));
    let mut bench = Bench::new(machine.clone());
    bench.interpolator.start(waiting).expect("idle");
    for _ in 0..50 {
        bench.step(&[]);
    }
    let tick = bench.tick;
    let StateForecast::At(start) = bench.interpolator.foresee(tick) else { panic!("it waits") };
    assert_eq!(start, TrajectoryStart::default());
    let z = [point(1.0, 5.0)];
    let trajectory = Trajectory::from_points(&[Axis::Z], &z, &start, &machine).expect("within limits");
    let motion = Box::new(Prepared::new(Motion::from(trajectory), &machine).expect("good"));
    bench.interpolator.splice(tick, motion).unwrap_or_else(|(error, _)| panic!("{error}"));
    assert_eq!(bench.interpolator.planned_at(tick + 1000).map(|setpoints| setpoints.counts), Some([0, 0, 5 * PER_MM]));
    assert_eq!(bench.finish(2000), MotionOutcome::Completed);
    assert_eq!((bench.counts(), bench.last().tick), ([0, 0, 5 * PER_MM], tick + 1000));
}

/// A trajectory between its start and its first tick is not over: whatever ended before it, it can be replaced once it has begun.
#[test]
fn a_trajectory_that_has_not_begun_is_not_over() {
    let machine = machine();
    let bench = || Bench::new(machine.clone());
    let tolerances = FollowingTolerances { path: of_x(Some(0.5), None), ..FollowingTolerances::default() };
    let completed = |bench: &mut Bench| {
        bench.start(Motion::from(twenty_mm(tolerances)));
        assert_eq!(bench.finish(3000), MotionOutcome::Completed);
    };
    let cancelled = |bench: &mut Bench| {
        bench.start(Motion::from(twenty_mm(tolerances)));
        for _ in 0..400 {
            bench.step(&[]);
        }
        bench.step(&[MotionRequest::Cancel]);
        assert_eq!(bench.finish(3000), MotionOutcome::Cancelled);
    };
    let aborted = |bench: &mut Bench| {
        bench.start(Motion::from(twenty_mm(tolerances)));
        let outcome = LaggingAxis::new(20, 1).finish(bench, 3000);
        assert!(matches!(outcome, MotionOutcome::OutOfTolerance(_)), "{outcome:?}");
    };
    let homed = |bench: &mut Bench| {
        bench.start(Motion::Home(vec![Axis::C]));
        assert_eq!(bench.finish(20_000), MotionOutcome::Completed);
    };
    let nothing = |_: &mut Bench| {};
    let cases = [
        ("nothing", &nothing as &dyn Fn(&mut Bench)),
        ("a complete one", &completed),
        ("a cancelled one", &cancelled),
        ("an aborted one", &aborted),
        ("a homing", &homed),
    ];
    for (after, run) in cases {
        let mut bench = bench();
        run(&mut bench);
        let first = bench.tick;
        assert_eq!(bench.interpolator.foresee(first + 10), StateForecast::Over, "after {after}: nothing is executed");
        let counts = bench.interpolator.setpoint().counts;
        let start = TrajectoryStart::at_rest(Axis::ALL.map(|axis| {
            let index = axis.index();
            machine.axis(axis).scale.position(counts[index])
        }));
        let slow = [point(3600.0, start.position[Axis::X.index()] + 5.0)];
        let slow = Trajectory::from_points(&[Axis::X], &slow, &start, &machine).expect("within limits");
        bench.start(Motion::from(slow));
        assert_eq!(bench.interpolator.foresee(first + 10), StateForecast::NotBegun, "after {after}");
        bench.step(&[]);
        // One takes the place of the slow one, and another the place of that.
        for (tick, target_mm) in [(first + 10, 8.0), (first + 300, 9.0)] {
            let StateForecast::At(start) = bench.interpolator.foresee(tick) else { panic!("after {after}: it moves") };
            let trajectory = Trajectory::from_points(&[Axis::X], &[point(1.0, target_mm)], &start, &machine);
            let motion = Motion::from(trajectory.expect("within limits"));
            while bench.tick < tick {
                bench.step(&[]);
            }
            let motion = Box::new(Prepared::new(motion, &machine).expect("good"));
            bench.interpolator.splice(tick, motion).unwrap_or_else(|(error, _)| panic!("after {after}: {error}"));
        }
        assert_eq!(bench.finish(2000), MotionOutcome::Completed, "after {after}");
        assert_eq!((bench.interpolator.setpoint().counts[1], bench.last().tick), (9 * PER_MM, first + 1300), "{after}");
    }
    // Only a trajectory can be replaced.
    let mut bench = bench();
    bench.start(Motion::Home(vec![Axis::C]));
    assert_eq!(bench.interpolator.foresee(bench.tick + 10), StateForecast::Over);
}
