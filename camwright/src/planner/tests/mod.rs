// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use crate::cam::follower::Follower;
use crate::cam::form_tolerance::FormTolerance;
use crate::cam::lift::{LiftLaw, MotionProgram, MotionSegment};
use crate::cam::motion_law::MotionLaw;
use crate::interpolator::{Motion, Prepared};
use crate::job::grinding::{
    HoldInCut, HomePosition, InfeedCourse, InfeedDirection, LobeSpec, PassSpec, ProfileSpec, SpeedLaw,
};
use crate::machine::axial_profile::AxialProfile;
use crate::machine::description::{
    AlarmRetract, AxisDescription, AxisScale, ContactDescription, DriveSettings, MotionLimits, Station, StiffnessAt,
    WheelDescription,
};
use crate::machine::persistent_state::PersistentState;
use crate::machine::setpoint::Setpoint;
use crate::math::units::{TURN_RAD, rad_from_deg, rad_s_from_rpm, wrap_turn};
use crate::motion::plan::{Phase, SegmentKind};
use crate::simulation::Machine;
use crate::simulation::closed_loop::{ClosedLoop, Simulated};
use crate::simulation::tick_report::TickReport;
use alloc::boxed::Box;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;

fn axis(axis: Axis, scale: AxisScale, limits: MotionLimits, soft_limits: Option<(f64, f64)>) -> AxisDescription {
    AxisDescription {
        axis,
        scale,
        limits,
        soft_limits,
        overtravel: None,
        max_following_error: 1.0,
        min_following_error: 0.1,
        needs_homing: axis == Axis::C,
        homing: None,
        search_velocity: if axis == Axis::C { rad_s_from_rpm(20.0) } else { 40.0 },
        drive: DriveSettings::IDEAL,
        good_drive: None,
        inertia: if axis == Axis::C { 0.05 } else { 250.0 },
        power_up_position: 0.0,
    }
}

pub(crate) fn machine() -> MachineDescription {
    let limits = |velocity, acceleration, jerk| MotionLimits { velocity, acceleration, jerk };
    MachineDescription {
        name: String::from("test grinder"),
        hash: String::new(),
        cycle_time_ns: 1_000_000,
        feedback_delay_ticks: 20,
        servo_steps_per_tick: 4,
        axes: [
            axis(Axis::C, AxisScale::Rotary { counts_per_turn: 3_600_000 }, limits(31.4, 300.0, 3e4), None),
            axis(Axis::X, AxisScale::Linear { counts_per_mm: 100_000 }, limits(500.0, 1e4, 1e6), Some((5.0, 180.0))),
            axis(Axis::Z, AxisScale::Linear { counts_per_mm: 10_000 }, limits(250.0, 2e3, 5e4), Some((-20.0, 400.0))),
        ],
        stations: (0..8_u32)
            .map(|i| Station { switch: format!("LS{}", i + 1), position_mm: 40.0 + 45.0 * f64::from(i) })
            .collect(),
        dog_length_mm: 8.0,
        switch_hysteresis_mm: 0.05,
        origin_half_window_rad: rad_from_deg(1.0),
        wheel: WheelDescription {
            new_radius_mm: 60.0,
            min_radius_mm: 40.0,
            width_mm: 25.0,
            surface_speed_m_s: 80.0,
            spin_up_s: 2.0,
            max_surface_speed_m_s: None,
            max_speed_rad_s: None,
            grinding_ratio: None,
            unbalance_mm: 0.0,
            rim: AxialProfile::default(),
        },
        insert: None,
        wheel_changer: None,
        contact: None,
        workholding: None,
        thermal: None,
        gauge: None,
        gap_detector: None,
        key_way_probe: None,
        loading: None,
        process: None,
        retract: AlarmRetract::default(),
        dresser: None,
        headstock: None,
        tailstock: None,
        rotation_sense: 1,
    }
}

/// An ordinary machine and part between centres, softer away from the headstock.
pub(crate) fn contact() -> ContactDescription {
    ContactDescription {
        stiffness: vec![StiffnessAt { z_mm: 0.0, n_mm: 4e4 }, StiffnessAt { z_mm: 300.0, n_mm: 3e4 }],
        grinding_n_mm2: 1.5e3,
        threshold_n_mm: 0.8,
        part_share: 0.5,
        modes: Vec::new(),
    }
}

/// Base centre at cam angle 0, nose at 180 deg.
fn lobe_profile(name: &str, lift_mm: f64, half_deg: f64) -> ProfileSpec {
    let half_rad = rad_from_deg(half_deg);
    let segment = |law, angle_rad, rise_mm| MotionSegment { law, angle_rad, rise_mm };
    let segments = [
        segment(MotionLaw::Polynomial4567, half_rad, lift_mm),
        segment(MotionLaw::Polynomial4567, half_rad, -lift_mm),
        segment(MotionLaw::Dwell, TURN_RAD - 2.0 * half_rad, 0.0),
    ];
    let program = MotionProgram::new(0.5 * TURN_RAD - half_rad, &segments).expect("one turn, closed");
    ProfileSpec {
        name: String::from(name),
        lift: LiftLaw::from_program(program).expect("above its base circle"),
        follower: Follower::Roller { radius_mm: 10.0, offset_mm: 0.0 },
        base_radius_mm: 16.0,
        throw_mm: 0.0,
        is_bore: false,
    }
}

fn lobe(name: &str, station: &str, phase_deg: f64, profile: usize) -> LobeSpec {
    LobeSpec {
        name: String::from(name),
        station: String::from(station),
        phase_rad: rad_from_deg(phase_deg),
        profile,
        width_mm: 14.0,
        tolerance: FormTolerance::default(),
        plunge: None,
        visit: None,
        axial: None,
    }
}

/// Four lobes, all phases different; I1 begins on a flank (cam angle 130 deg).
pub(crate) fn job() -> JobSpec {
    JobSpec {
        name: String::from("camshaft"),
        profiles: vec![lobe_profile("intake", 6.0, 75.0), lobe_profile("exhaust", 5.5, 78.0)],
        lobes: vec![
            lobe("I1", "LS1", 230.0, 0),
            lobe("E1", "LS2", 332.0, 1),
            lobe("I2", "LS3", 50.0, 0),
            lobe("E2", "LS4", 92.0, 1),
        ],
        blocks_per_turn: 3600,
        rapid_advance_mm: 40.0,
        rapid_speed_mm_s: 100.0,
        stock_mm: 0.3,
        passes: vec![PassSpec {
            name: String::from("grind"),
            total_infeed_mm: 0.36,
            infeed_per_block_mm: 0.000_05,
            infeed_of_turns_mm: Vec::new(),
            air_mm: 0.0,
            infeed_course: InfeedCourse::PerAngle,
            infeed_direction: InfeedDirection::X,
            spark_out_turns: 2,
            spark_out_until_n: None,
            gauge_size: None,
            speed: SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: rad_s_from_rpm(60.0) },
        }],
        retract_clearance_mm: 2.0,
        hold_in_cut: HoldInCut::Retract,
        speed_variation: None,
        wheel_power: None,
        c_between_lobes: BetweenLobes::Stops,
        rotary_indexing: false,
        home: HomePosition { x_mm: 150.0, z_mm: 0.0 },
        dressing: None,
        obstacles: Vec::new(),
        clearance_mm: 1.0,
        wheels: Vec::new(),
        raw_part: crate::job::raw_part::RawPart::default(),
        correction: None,
        compensation: None,
        identification: None,
        dry_run_mm: None,
        part_phase_rad: 0.0,
        measure_stock: None,
        part_support: None,
    }
}

/// Numbers between two bounds, by Marsaglia's xorshift.
fn random_between(mut state: u64) -> impl FnMut(f64, f64) -> f64 {
    move |low, high| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        let unit = (state >> 11) as f64 / (1_u64 << 53) as f64;
        low + unit * (high - low)
    }
}

fn planned(job: &JobSpec) -> PlannedJob {
    plan_job(job, &machine(), 60.0, None).unwrap_or_else(|error| panic!("{error}"))
}

/// A plan run through interpolator and machine.
fn simulated(plan: Plan, description: &MachineDescription, observe: impl FnMut(&Setpoint, &TickReport)) -> Simulated {
    let motion = Prepared::new(Motion::Plan(Arc::new(plan)), description).unwrap_or_else(|error| panic!("{error}"));
    let machine = Machine::new(description.clone(), PersistentState::new(description)).expect("a machine");
    let simulated = ClosedLoop::direct(machine).simulate(Box::new(motion), observe);
    simulated.unwrap_or_else(|error| panic!("{error}"))
}

/// The machine with raw lobes, their stock all round.
fn loaded(job: &JobSpec, planned: &PlannedJob, description: &MachineDescription) -> Machine {
    let mut machine = Machine::new(description.clone(), PersistentState::new(description)).expect("a machine");
    for lobe in &planned.lobes {
        let design = &lobe.design;
        let azimuth = |i: u32| f64::from(i) * TURN_RAD / 3600.0;
        // Stock along the ray is at least the stock along the normal.
        let radii = (0..3600).map(|i| design.radius_at(azimuth(i)) + job.stock_mm).collect();
        machine.load_lobe(&design.name, &design.station, design.width_mm, radii).expect("a raw lobe");
    }
    machine
}

/// Runs a plan on raw lobes.
fn ground(
    job: &JobSpec,
    planned: &PlannedJob,
    plan: Plan,
    description: &MachineDescription,
    observe: impl FnMut(&Setpoint, &TickReport),
) -> (Simulated, Machine) {
    let motion = Prepared::new(Motion::Plan(Arc::new(plan)), description).unwrap_or_else(|error| panic!("{error}"));
    let mut closed_loop = ClosedLoop::direct(loaded(job, planned, description));
    let simulated = closed_loop.simulate(Box::new(motion), observe).unwrap_or_else(|error| panic!("{error}"));
    (simulated, closed_loop.into_machine())
}

fn first_turn(planned: &PlannedJob, count: u32) -> Vec<crate::motion::cut_motion::TurnSample> {
    let cut = planned.plan.cuts_of(0).next().expect("a cut");
    planned.plan.turn_samples(cut, count).expect("a plateau")
}

fn refusal(change: impl FnOnce(&mut JobSpec)) -> PlanError {
    let mut job = job();
    change(&mut job);
    plan_job(&job, &machine(), 60.0, None).map(|_| ()).expect_err("must be refused")
}

mod bits;
mod clearance;
mod compensation;
mod deflection;
mod dress_now;
mod dressing;
mod dry_run;
mod infeeds;
mod order;
mod part_support;
mod passes;
mod refusals;
mod sparking_out;
mod tapered;
mod turning;
mod two_wheels;

/// The steps of JPS6156064B2, Fig. 6, in its order, lobe by lobe.
#[test]
fn the_steps_are_those_of_the_main_routine() {
    let plan = planned(&job()).plan;
    let phases: Vec<Phase> = plan.segments.iter().filter(|s| s.lobe == Some(1)).map(|s| s.phase).collect();
    assert_eq!(phases, [Phase::Index, Phase::Index, Phase::Position, Phase::Approach, Phase::Cut, Phase::Retract]);
    assert_eq!(plan.segments[0].phase, Phase::Home);
    assert_eq!(plan.segments.last().map(|s| s.phase), Some(Phase::Return));
    assert!(matches!(&plan.segments[1].kind, SegmentKind::Search { axis: Axis::C, input, .. } if input == "origin"));
    assert_eq!(plan.lobes, ["I1", "E1", "I2", "E2"]);
    // Two profiles and one speed: nothing travels twice.
    assert_eq!((plan.paths.len(), plan.angle_laws.len()), (2, 1));
}

/// k = (C − α)/Δθ mod N, past the last block too; X is pre-positioned by the lift there.
#[test]
fn the_read_start_wraps_past_the_last_block() {
    let planned = planned(&job());
    for (lobe, block) in planned.lobes.iter().zip([1300, 280, 3100, 2680]) {
        assert_eq!(lobe.start_block, block, "{}", lobe.design.name);
        assert!((lobe.start_rad - rad_from_deg(f64::from(block) * 0.1)).abs() < 1e-9);
    }
    assert_eq!(lobe::block_at(TURN_RAD - 1e-12, 3600), 0);
    assert_eq!(lobe::block_at(TURN_RAD * 3599.5 / 3600.0, 3600), 3599);
    assert_eq!(lobe::block_at(-TURN_RAD / 3600.0, 3600), 3599);

    // I1 begins on its flank: the wheel stands farther out than for a start on the base, by the lift.
    let x_of = |lobe: usize, phase: Phase| {
        let segment = planned.plan.segments.iter().find(|s| s.lobe == Some(lobe) && s.phase == phase);
        match segment.map(|s| &s.kind) {
            Some(SegmentKind::Move(targets)) => targets[0].target_counts,
            other => panic!("{other:?}"),
        }
    };
    let on_base = 100_000 * 16 + 36_000;
    assert_eq!(x_of(1, Phase::Approach), on_base);
    assert_eq!(x_of(1, Phase::Position), on_base + 4_000_000);
    let lift = planned.lobes[0].tool_path.sample(rad_from_deg(130.0)).value - 16.0;
    assert!(lift > 0.5, "{lift}");
    #[allow(clippy::cast_possible_truncation, reason = "some millimetres of counts")]
    let by_lift = libm::round(lift * 1e5) as i64;
    assert!((x_of(0, Phase::Approach) - on_base - by_lift).abs() <= 1);
}

/// After n turns C has moved by exactly n turns and X by exactly the infeed.
#[test]
fn counts_close_after_whole_turns() {
    let planned = planned(&job());
    let (machine, plan) = (machine(), &planned.plan);
    for lobe in 0..4 {
        let cut = plan.cuts_of(lobe).next().expect("every lobe is cut");
        let motion = plan.motion_of(cut).expect("its splines are there");
        let end = motion.at(motion.duration_s());
        assert_eq!(machine.axis(Axis::C).scale.counts(end.c.value), i64::from(cut.turns) * 3_600_000);
        let x = machine.axis(Axis::X).scale;
        assert_eq!(x.counts(motion.at(0.0).x.value) - x.counts(end.x.value), 36_000);
    }
    assert_eq!(planned.report.end_counts, [16 * 3_600_000, 150 * 100_000, 0]);
}

#[test]
fn every_limit_holds_on_the_whole_plan() {
    let planned = planned(&job());
    assert!(planned.report.max_ratio() <= 1.0 + 1e-6, "{:?}", planned.report);
    let cuts = planned.plan.segments.iter().filter(|s| s.phase == Phase::Cut);
    for cut in cuts {
        assert!(cut.stop_ticks > 0 && cut.stop_ticks < 2000, "{}", cut.stop_ticks);
    }
}

/// The claim of the patent: without turning the part to each lobe the same job takes less time.
#[test]
fn not_indexing_saves_time() {
    let straight = planned(&job());
    let mut conventional = job();
    conventional.rotary_indexing = true;
    let conventional = planned(&conventional);
    assert!(straight.saved_by_not_indexing_s() > 0.5, "{}", straight.saved_by_not_indexing_s());
    assert!((conventional.plan.duration_s - straight.plan.duration_with_indexing_s).abs() < 0.05);
    for lobe in &conventional.lobes {
        assert_eq!(lobe.start_block, 0);
    }
    assert_eq!(conventional.plan.segments.iter().filter(|s| s.phase == Phase::RotaryIndex).count(), 4);
}

/// A concentric disc moves X by its infeed alone.
#[test]
fn concentric_disc_holds_x_still() {
    let mut job = job();
    job.profiles = vec![ProfileSpec {
        name: String::from("disc"),
        lift: LiftLaw::eccentric_flat(0.0, 0.0).expect("a disc"),
        follower: Follower::Flat,
        base_radius_mm: 20.0,
        throw_mm: 0.0,
        is_bore: false,
    }];
    job.lobes.truncate(1);
    let planned = planned(&job);
    for sample in first_turn(&planned, 360) {
        assert!((sample.x.value - 20.0).abs() < 1e-12 && sample.x.first.abs() < 1e-9);
        assert!((sample.c.first - rad_s_from_rpm(60.0)).abs() < 1e-9);
    }
}

/// Circle r at eccentricity E, tool R: X = E cos θ + √((r + R)² − E² sin² θ) − R, times as the work speed says.
#[test]
fn eccentric_disc_follows_its_closed_form() {
    let (e, r, wheel) = (4.2, 19.0, 15.0);
    let mut job = job();
    job.profiles = vec![ProfileSpec {
        name: String::from("eccentric"),
        lift: LiftLaw::eccentric_flat(e, 0.0).expect("an eccentric"),
        follower: Follower::Flat,
        base_radius_mm: r - e,
        throw_mm: 0.0,
        is_bore: false,
    }];
    job.lobes.truncate(1);
    job.lobes[0].phase_rad = 0.7;
    for rotation_sense in [1, -1] {
        let machine = MachineDescription { rotation_sense, ..machine() };
        let planned = plan_job(&job, &machine, wheel, None).expect("can be made");
        let samples = first_turn(&planned, 720);
        for sample in &samples {
            // The disc is symmetric, so the mirrored path of sense −1 has the same closed form.
            let theta = sample.angle_rad;
            let root = libm::sqrt((r + wheel) * (r + wheel) - e * e * libm::sin(theta) * libm::sin(theta));
            assert!((sample.x.value - (e * libm::cos(theta) + root - wheel)).abs() < 1e-9);
            assert!((sample.time_s - theta / rad_s_from_rpm(60.0)).abs() < 1e-9);
        }
        // At C = 0 the wheel line has azimuth 0 on the part and σ·C − α on the lobe, whichever way C turns.
        assert!((planned.lobes[0].start_rad - wrap_turn(-0.7)).abs() < 1e-12);
        let cut = planned.plan.cuts_of(0).next().expect("a cut");
        let start = planned.plan.motion_of(cut).expect("its splines").over_angle(0.0).value;
        let root = libm::sqrt((r + wheel) * (r + wheel) - e * e * libm::sin(0.7) * libm::sin(0.7));
        assert!((start - (e * libm::cos(0.7) + root - wheel + 0.36)).abs() < 1e-9);
    }
}

/// Turning the other way, the same wheel-line angles of the part give the same X.
#[test]
fn the_rotation_sense_mirrors_the_path_and_nothing_else() {
    let there = planned(&job());
    let back = plan_job(&job(), &MachineDescription { rotation_sense: -1, ..machine() }, 60.0, None).expect("fits");
    for (a, b) in there.plan.paths.iter().zip(&back.plan.paths) {
        for i in 0..1000 {
            let angle = f64::from(i) * 0.0123;
            assert!((a.sample(angle).value - b.sample(-angle).value).abs() < 1e-12);
        }
    }
    for (a, b) in there.lobes.iter().zip(&back.lobes) {
        assert!((a.start_rad - b.start_rad).abs() < 1e-12);
    }
}

#[test]
fn the_design_sits_on_the_part_at_its_phase() {
    let job = job();
    let designs = designs(&job).expect("contours");
    // The nose of I1 is at cam angle 180 deg of the lobe and 230 + 180 deg of the part.
    assert!((designs[0].radius_at(rad_from_deg(230.0 + 180.0)) - 22.0).abs() < 1e-9);
    assert!((designs[0].radius_at(rad_from_deg(230.0)) - 16.0).abs() < 1e-9);
}

#[test]
fn a_known_start_shortens_the_prediction_only() {
    let machine = machine();
    let start = PlanStart { counts: [3_580_000, 14_000_000, 3_000_000], c_homed: true };
    let known = plan_job(&job(), &machine, 60.0, Some(start)).expect("fits");
    let unknown = planned(&job());
    assert!((known.plan.duration_s - unknown.plan.duration_s).abs() < 3.0);
    assert_eq!(known.plan.paths, unknown.plan.paths);
    assert_eq!(known.plan.segments.len(), unknown.plan.segments.len());
}

/// A plan that is tampered with does not pass the walk.
#[test]
fn the_walk_sees_what_does_not_join() {
    let machine = machine();
    let start = [0, 15_000_000, 0];
    let good = planned(&job()).plan;
    check_plan(&good, &machine, start).expect("as planned");
    let broken = |change: &dyn Fn(&mut Plan)| {
        let mut plan = good.clone();
        change(&mut plan);
        check_plan(&plan, &machine, start).expect_err("tampered with").to_string()
    };
    let cut_at = good.segments.iter().position(|s| s.phase == Phase::Cut).expect("a cut");
    let text = broken(&|plan| {
        plan.segments.remove(cut_at - 1);
    });
    assert!(text.contains("x_axis begins at"), "{text}");
    let text = broken(&|plan| {
        if let SegmentKind::Cut(cut) = &mut plan.segments[cut_at].kind {
            cut.start_counts = 7;
        }
    });
    assert!(text.contains("c_axis begins at 7 counts, the segment before ended at 0"), "{text}");
    let text = broken(&|plan| {
        if let SegmentKind::Cut(cut) = &mut plan.segments[cut_at].kind {
            cut.speed = 9;
        }
    });
    assert!(text.contains("spline that the plan does not have"), "{text}");
    let text = broken(&|plan| {
        let knots: Vec<_> = plan.time_laws[0]
            .knots()
            .iter()
            .map(|k| crate::math::hermite::Knot {
                at: k.at * 0.2,
                value: k.value,
                first: k.first * 5.0,
                second: k.second * 25.0,
            })
            .collect();
        plan.time_laws[0] = crate::math::hermite::HermiteSpline::new(knots).expect("still increasing");
        for segment in &mut plan.segments {
            if let SegmentKind::Cut(cut) = &mut segment.kind {
                (cut.plateau_s, cut.turn_s) = ((cut.plateau_s.0 * 0.2, cut.plateau_s.1 * 0.2), cut.turn_s * 0.2);
            }
        }
    });
    assert!(text.contains("needs a") && text.contains("are allowed"), "{text}");
}

/// Any job that is planned is whole; any that is not says why in a sentence with a figure or a name.
#[test]
fn random_jobs_are_planned_whole_or_refused_in_a_sentence() {
    let mut random = random_between(0x9E37_79B9_7F4A_7C15);
    let (mut made, mut refused) = (0, 0);
    for round in 0..12 {
        let mut job = job();
        job.profiles = vec![lobe_profile("p", random(1.0, 7.0), random(65.0, 85.0))];
        let count = 1 + round % 3;
        job.lobes =
            (0..count).map(|i| lobe(&format!("L{i}"), &format!("LS{}", i + 1), random(-400.0, 400.0), 0)).collect();
        let speed = SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: rad_s_from_rpm(random(10.0, 120.0)) };
        job.passes[0].speed = speed;
        job.rotary_indexing = round % 4 == 3;
        let machine = MachineDescription { rotation_sense: if round % 2 == 0 { 1 } else { -1 }, ..machine() };
        match plan_job(&job, &machine, random(40.0, 70.0), None) {
            Ok(planned) => {
                made += 1;
                assert!(planned.report.max_ratio() <= 1.0 + 1e-6, "round {round}");
                assert_eq!(planned.report.end_counts[Axis::X.index()], 15_000_000, "round {round}");
                assert!(planned.plan.duration_with_indexing_s >= planned.plan.duration_s - 1e-9, "round {round}");
                let turns = planned.report.end_counts[Axis::C.index()];
                assert!(job.rotary_indexing || turns % 3_600_000 == 0, "round {round}");
            }
            Err(error) => {
                refused += 1;
                let text = error.to_string();
                assert!(text.len() > 20 && !text.contains("forward check"), "round {round}: {text}");
            }
        }
    }
    assert!(made >= 4, "made {made}, refused {refused}");
}
