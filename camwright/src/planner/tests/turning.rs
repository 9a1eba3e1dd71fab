// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! C turning on from lobe to lobe: planned, checked, and run through interpolator and machine.

use super::*;

const MARGIN_S: f64 = 0.02;

fn turning_job() -> JobSpec {
    JobSpec { c_between_lobes: BetweenLobes::TurnsOn { margin_s: MARGIN_S }, ..job() }
}

fn at_a_removal_rate(job: JobSpec, removal_rate_mm2_s: f64) -> JobSpec {
    let mut job = job;
    job.passes[0].speed = SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s, max_rad_s: rad_s_from_rpm(300.0) };
    job
}

/// Setpoints and table of a run, tick by tick.
struct SimulatedRun {
    setpoints: Vec<Setpoint>,
    ticks: Simulated,
}

fn run(planned: &PlannedJob, machine: &MachineDescription) -> SimulatedRun {
    let mut setpoints = Vec::new();
    let ticks = simulated(planned.plan.clone(), machine, |setpoint, _| setpoints.push(*setpoint));
    SimulatedRun { setpoints, ticks }
}

impl SimulatedRun {
    fn duration_s(&self, machine: &MachineDescription) -> f64 {
        let ticks = (self.ticks.last_tick - self.ticks.first_tick) as f64;
        ticks * machine.cycle_time_s()
    }

    /// Setpoints from the first cut to the last, where C turns with the wheel at the part.
    fn while_turning(&self) -> &[Setpoint] {
        let cutting = |setpoint: &Setpoint| setpoint.velocity[0] > 0.0 && setpoint.counts[1] < 100_000 * 60;
        let first = self.setpoints.iter().position(cutting).expect("there are cuts");
        let last = self.setpoints.iter().rposition(cutting).expect("there are cuts");
        &self.setpoints[first..=last]
    }
}

#[test]
fn c_never_stops_from_the_first_lobe_to_the_last_and_the_job_is_faster() {
    let machine = machine();
    for job in [turning_job(), at_a_removal_rate(turning_job(), 10.0), at_a_removal_rate(turning_job(), 2.0)] {
        let planned = planned(&job);
        let saved_s = planned.saved_by_turning_on_s().expect("C turns on");
        assert!(saved_s > 0.1, "{saved_s}");
        assert!(planned.report.max_ratio() <= 1.0 + 1e-6);
        let run = run(&planned, &machine);
        for (tick, setpoint) in run.while_turning().iter().enumerate() {
            assert!(setpoint.velocity[0] > 0.0, "{tick}: {setpoint:?}");
        }
        let turning_s = run.while_turning().len() as f64 * machine.cycle_time_s();
        let stop = planned.plan.segments.iter().rposition(|s| s.phase == Phase::Cut).expect("a cut");
        let start = planned.plan.segments.iter().position(|s| s.phase == Phase::Cut).expect("a cut");
        let predicted: u64 = planned.plan.segments[start..=stop].iter().map(|segment| segment.ticks).sum();
        let predicted_s = predicted as f64 * machine.cycle_time_s();
        assert!((turning_s - predicted_s).abs() < 0.03, "{turning_s} {predicted_s}");
    }
}

/// Every setpoint keeps the limits of its axis: positions by differences, over the joints of cuts and leads too.
#[test]
fn setpoints_keep_the_limits_while_c_turns_on() {
    let machine = machine();
    let dt = machine.cycle_time_s();
    for job in [turning_job(), at_a_removal_rate(turning_job(), 10.0)] {
        let run = run(&planned(&job), &machine);
        for (index, axis) in machine.axes.iter().enumerate() {
            let limits = axis.limits;
            for pair in run.while_turning().windows(2) {
                let [a, b] = pair else { continue };
                // From tick to tick velocities change by no more than the acceleration allows, accelerations by the jerk.
                assert!(b.velocity[index].abs() <= limits.velocity * (1.0 + 1e-9));
                let change = (b.velocity[index] - a.velocity[index]).abs() / dt;
                assert!(change <= limits.acceleration * (1.0 + 1e-6), "{index}: {a:?} {b:?}");
                let change = (b.acceleration[index] - a.acceleration[index]).abs() / dt;
                assert!(change <= limits.jerk * (1.0 + 1e-6), "{index}: {a:?} {b:?}");
                // And positions are where the velocities lead to, to the count.
                let per_unit = axis.scale.counts_per_unit();
                let way = 0.5 * (a.velocity[index] + b.velocity[index]) * dt * per_unit;
                let bend = limits.jerk * dt * dt * dt / 12.0 * per_unit;
                let moved = (b.counts[index] - a.counts[index]) as f64;
                assert!((moved - way).abs() <= 1.0 + bend, "{index}: {moved} {way}");
            }
        }
    }
}

/// The table moves only while X stands clear of the highest lobe.
#[test]
fn x_stands_clear_whenever_the_table_moves() {
    let planned = planned(&turning_job());
    let machine = machine();
    let highest_mm = 16.0 + 6.0 + 0.3;
    for setpoint in run(&planned, &machine).while_turning() {
        if setpoint.velocity[2] != 0.0 {
            assert!(setpoint.velocity[1] == 0.0);
            assert!(machine.axis(Axis::X).scale.position(setpoint.counts[1]) > highest_mm + 1.0);
        }
    }
}

/// Switches that close later than planned cost a turn where the phase is missed; the job is ground all the same.
#[test]
fn a_table_that_arrives_too_late_waits_for_the_next_turn() {
    let planned = planned(&turning_job());
    let as_planned = run(&planned, &machine());
    let mut late = machine();
    for station in &mut late.stations {
        // 0.1 s at 40 mm/s, five margins.
        station.position_mm += 4.0;
    }
    let run = run(&planned, &late);
    assert_eq!(run.ticks.outcome, crate::interpolator::MotionOutcome::Completed);
    let more_s = run.duration_s(&late) - as_planned.duration_s(&late);
    // Three lobes come turning, each a turn of 1 s later; the first only 0.1 s.
    assert!((more_s - 3.1).abs() < 0.1, "{more_s}");
}

#[test]
fn c_stops_between_the_passes_of_a_lobe() {
    let mut job = turning_job();
    let mut rough = job.passes[0].clone();
    rough.name = String::from("rough");
    job.passes.insert(0, rough);
    let planned = planned(&job);
    let run = run(&planned, &machine());
    assert_eq!(run.ticks.outcome, crate::interpolator::MotionOutcome::Completed);
    for lobe in 0..4 {
        let ends: Vec<(f64, f64)> = planned
            .plan
            .cuts_of(lobe)
            .map(|cut| planned.plan.motion_of(cut).expect("its splines").end_speeds_rad_s())
            .collect();
        // Between passes C stops on the part; it turns on between lobes only.
        assert_eq!((ends[0].1, ends[1].0), (0.0, 0.0));
        assert_eq!((ends[0].0 > 0.0, ends[1].1 > 0.0), (lobe > 0, lobe < 3));
    }
}

#[test]
fn it_is_refused_with_rotary_indexing_and_with_a_margin_that_is_none() {
    let indexed = refusal(|job| {
        *job = JobSpec { rotary_indexing: true, ..turning_job() };
    });
    assert!(indexed.to_string().contains("with rotary indexing C stops before each lobe"), "{indexed}");
    let margin = refusal(|job| job.c_between_lobes = BetweenLobes::TurnsOn { margin_s: f64::NAN });
    assert!(margin.to_string().contains("c_between_lobes.margin_s"), "{margin}");
}

/// Foreign plans are refused if C moves during a flying start, or if a flying start has no successor.
#[test]
fn the_walk_and_the_interpolator_refuse_a_plan_that_loses_c() {
    let planned = planned(&turning_job());
    let machine = machine();
    let start = [0, 150 * 100_000, 0];
    let last = planned.plan.segments.iter().rposition(|s| s.phase == Phase::Cut).expect("a cut");
    let mut cut_off = planned.plan.clone();
    cut_off.segments.truncate(last);
    let error = check_plan(&cut_off, &machine, start).expect_err("C turns on");
    assert!(error.to_string().contains("c_axis still turns on from the cut before"), "{error}");
    let error = Prepared::new(Motion::Plan(Arc::new(cut_off)), &machine).expect_err("C turns on");
    assert!(error.to_string().contains("no cut comes after"), "{error}");

    let mut moved = planned.plan;
    let first = moved.segments.iter().position(|s| s.phase == Phase::Cut).expect("a cut");
    let limits = machine.axis(Axis::C).limits;
    let turn = SegmentKind::Move(vec![crate::motion::plan::AxisTarget { axis: Axis::C, target_counts: 0, limits }]);
    let segment = crate::motion::plan::Segment { kind: turn, ..moved.segments[0].clone() };
    moved.segments.insert(first + 1, segment);
    assert!(check_plan(&moved, &machine, start).is_err());
    let error = Prepared::new(Motion::Plan(Arc::new(moved)), &machine).expect_err("C turns on");
    assert!(error.to_string().contains("c_axis still turns on from the cut before"), "{error}");
}

#[test]
fn every_lobe_gets_its_whole_infeed_and_its_spark_out() {
    let planned = planned(&turning_job());
    for lobe in 0..4 {
        let cut = planned.plan.cuts_of(lobe).next().expect("a cut");
        let motion = planned.plan.motion_of(cut).expect("its splines");
        assert!((motion.offset_over_angle(0.0).value - 0.36).abs() < 1e-12);
        assert_eq!((cut.infeed_turns, cut.turns), (2, 4));
        // From the end of the infeed to the lead-out nothing is beside the path.
        let total = f64::from(cut.turns) * TURN_RAD;
        let from_s = motion.time_of(motion.infeed.end());
        let to_s = motion.time_of(total);
        for i in 0..=1000 {
            let at = from_s + (to_s - from_s) * f64::from(i) / 1000.0;
            let c = motion.angle(at).value;
            assert!((motion.x_mm(at) - motion.path.sample(motion.path_start_rad + c).value).abs() < 1e-9);
        }
    }
}

/// Any job that C turns on in is planned whole and faster than with stops, or refused in a sentence; it runs to its end.
#[test]
fn random_jobs_with_c_turning_on_are_planned_whole_or_refused_in_a_sentence() {
    let seed = 0x5851_F42D_4C95_7F2D_u64;
    let mut random = random_between(seed);
    let (mut made, mut refused) = (0, 0);
    for round in 0..10_u32 {
        let what = format!("seed {seed} round {round}");
        let mut job = turning_job();
        job.profiles = vec![lobe_profile("p", random(1.0, 7.0), random(65.0, 85.0))];
        job.lobes = (0..2 + round % 3)
            .map(|i| lobe(&format!("L{i}"), &format!("LS{}", i + 1), random(-400.0, 400.0), 0))
            .collect();
        job.passes[0].speed = match round % 4 {
            0 => SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: rad_s_from_rpm(random(10.0, 120.0)) },
            1 => SpeedLaw::TimeOptimal { max_rad_s: rad_s_from_rpm(random(50.0, 300.0)) },
            _ => SpeedLaw::ConstantRemovalRate {
                removal_rate_mm2_s: random(1.0, 20.0),
                max_rad_s: rad_s_from_rpm(random(50.0, 300.0)),
            },
        };
        if round % 5 == 4 {
            job.passes[0].infeed_direction = InfeedDirection::Normal;
        }
        if round % 3 == 2 {
            job.passes[0].infeed_course = InfeedCourse::PerTurn;
        }
        let machine = MachineDescription { rotation_sense: if round % 2 == 0 { 1 } else { -1 }, ..machine() };
        let wheel_mm = random(40.0, 70.0);
        match plan_job(&job, &machine, wheel_mm, None) {
            Ok(planned) => {
                made += 1;
                assert!(planned.report.max_ratio() <= 1.0 + 1e-6, "{what}");
                assert!(planned.saved_by_turning_on_s().expect("C turns on") > 0.0, "{what}");
                let stopping = JobSpec { c_between_lobes: BetweenLobes::Stops, ..job };
                let stopping = plan_job(&stopping, &machine, wheel_mm, None).expect("what turns on can stop");
                let late_s =
                    |planned: &PlannedJob| run(planned, &machine).duration_s(&machine) - planned.plan.duration_s;
                // Nothing is later than predicted but the search for the origin.
                let (turning, stopping) = (late_s(&planned), late_s(&stopping));
                assert!((turning - stopping).abs() < 0.03, "{what}: {turning} s, {stopping} s with stops");
            }
            Err(error) => {
                refused += 1;
                let text = error.to_string();
                assert!(text.len() > 20 && !text.contains("forward check"), "{what}: {text}");
            }
        }
    }
    assert!(made >= 5, "made {made}, refused {refused}");
}
