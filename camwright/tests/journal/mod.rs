// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A journal that runs out, from job to round part: the first half of its plan feeds and dwells, what the gauge reads decides the turn
//! that corrects, the second half drives it.

mod finishing;
mod size;
mod stiffness;
mod stock;

use crate::cams::journal;
use camwright::cam::form_tolerance::FormTolerance;
use camwright::cam::lift::LiftLaw;
use camwright::gauging::GaugingMode;
use camwright::gauging::finishing::FinishingSpec;
use camwright::gauging::gauged_tick::GaugedTick;
use camwright::gauging::journal::JournalCorrection;
use camwright::gauging::published::PublishedWindow;
use camwright::interpolator::{Motion, Prepared};
use camwright::job::grinding::{
    BetweenLobes, CorrectionSpec, HoldInCut, HomePosition, InfeedCourse, InfeedDirection, JobError, JobSpec, LobeSpec,
    PassSpec, SpeedLaw, StiffnessSource,
};
use camwright::job::raw_part::{RawPart, Wave};
use camwright::machine::description::{
    ContactDescription, DriveSettings, GaugeDescription, GaugeKind, MachineDescription, StiffnessAt,
};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::reference::cam_grinder;
use camwright::math::hermite::HermiteSpline;
use camwright::math::units::TURN_RAD;
use camwright::motion::plan::Plan;
use camwright::planner::{JournalReadings, PlanError, PlannedJob, decide_corrections, plan_corrections, plan_job};
use camwright::simulation::Machine;
use camwright::simulation::closed_loop::ClosedLoop;
use camwright::simulation::workpiece::DEFAULT_AZIMUTHS;
use std::sync::Arc;

const WIDTH_MM: f64 = 20.0;
const KG_N_MM: f64 = 3.0e4;
const RADIUS_MM: f64 = 20.0;

/// The reference machine with ideal drives, deflecting, with a gauge so far behind its wheel.
fn grinder(ratio: f64, gamma_deg: f64) -> MachineDescription {
    let stiffness = vec![
        StiffnessAt { z_mm: 80.0, n_mm: ratio * KG_N_MM },
        StiffnessAt { z_mm: 180.0, n_mm: 0.8 * ratio * KG_N_MM },
    ];
    let contact = ContactDescription {
        stiffness,
        grinding_n_mm2: KG_N_MM / WIDTH_MM,
        threshold_n_mm: 15.0 / WIDTH_MM,
        part_share: 0.7,
        modes: Vec::new(),
    };
    let gauge = GaugeDescription {
        kind: GaugeKind::Diameter,
        behind_wheel_rad: gamma_deg.to_radians(),
        second_behind_wheel_rad: None,
        resolution_mm: 0.0,
        noise_mm: 0.0,
        bandwidth_rad_s: None,
        seed: 11,
    };
    let machine = cam_grinder().with_drives(DriveSettings::IDEAL);
    MachineDescription { contact: Some(contact), gauge: Some(gauge), ..machine }
}

/// Two journals that are off by eccentricity and three lobes.
fn job(mode: GaugingMode) -> JobSpec {
    let lobe = |name: &str, station: &str, phase_rad: f64| LobeSpec {
        name: name.into(),
        station: station.into(),
        phase_rad,
        profile: 0,
        width_mm: WIDTH_MM,
        tolerance: FormTolerance::default(),
        plunge: None,
        visit: None,
        axial: None,
    };
    JobSpec {
        name: "journals".into(),
        profiles: vec![journal(RADIUS_MM)],
        lobes: vec![lobe("J1", "LS1", 0.0), lobe("J2", "LS3", 1.0)],
        blocks_per_turn: 3600,
        rapid_advance_mm: 40.0,
        rapid_speed_mm_s: 100.0,
        stock_mm: 0.1,
        passes: vec![PassSpec {
            name: "grind".into(),
            total_infeed_mm: 0.18,
            infeed_per_block_mm: 0.000_005,
            infeed_of_turns_mm: Vec::new(),
            air_mm: 0.0,
            infeed_course: InfeedCourse::PerAngle,
            infeed_direction: InfeedDirection::X,
            spark_out_turns: 3,
            spark_out_until_n: None,
            gauge_size: None,
            speed: SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: TURN_RAD },
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
        raw_part: RawPart {
            clamped_at_rad: 0.0,
            eccentric: Wave { mm: 0.03, at_rad: 1.0 },
            bend: None,
            lobes: vec![(3, Wave { mm: 0.005, at_rad: 0.4 })],
            unknown_mm: 0.0,
        },
        correction: Some(CorrectionSpec {
            mode,
            harmonics: 15,
            published: PublishedWindow::default(),
            finishing: None,
            allowance_mm: 0.02,
            stiffness: StiffnessSource::Best,
            contacts: Vec::new(),
        }),
        compensation: None,
        identification: None,
        dry_run_mm: None,
        part_phase_rad: 0.0,
        measure_stock: None,
        part_support: None,
    }
}

/// A cell: interpolator and machine with the raw part.
struct MachineUnderTest(ClosedLoop);

impl MachineUnderTest {
    fn new(description: &MachineDescription, job: &JobSpec) -> Self {
        Self::with_wheel(description, job, PersistentState::new(description))
    }

    fn with_wheel(description: &MachineDescription, job: &JobSpec, lasting: PersistentState) -> Self {
        let mut machine = Machine::new(description.clone(), lasting).expect("a machine");
        for lobe in &job.lobes {
            let z_mm = description.station(&lobe.station).expect("it is there").position_mm;
            let azimuth = |i: usize| i as f64 * TURN_RAD / DEFAULT_AZIMUTHS as f64;
            let radius = |i: usize| RADIUS_MM + job.stock_mm + job.raw_part.above_mm(azimuth(i), z_mm);
            let radii = (0..DEFAULT_AZIMUTHS).map(radius).collect();
            machine.load_lobe(&lobe.name, &lobe.station, lobe.width_mm, radii).expect("a raw journal");
        }
        Self(ClosedLoop::direct(machine))
    }

    /// Runs a plan; what the gauge read of each lobe.
    fn run(&mut self, plan: &Plan) -> Vec<JournalReadings> {
        let description = self.0.machine().description().clone();
        let prepared = Prepared::new(Motion::Plan(Arc::new(plan.clone())), &description).expect("a plan");
        let mut logs = vec![JournalReadings::default(); plan.lobes.len()];
        let simulated = self.0.simulate(Box::new(prepared), |_, report| {
            let (c_rad, x_mm, motor_n) = (report.axes[0].position, report.axes[1].position, report.axes[1].effort);
            let (Some(lobe), Some(value_mm)) = (report.lobe, report.gauge_mm[0]) else { return };
            let gauged =
                GaugedTick { tick: report.tick, c_rad, x_mm, value_mm, second_mm: report.gauge_mm[1], motor_n };
            match report.wheel_rad_s == 0.0 {
                true => logs[lobe].pushed.push(gauged.into()),
                false => logs[lobe].gauged.push(gauged),
            }
        });
        simulated.unwrap_or_else(|error| panic!("{error}"));
        logs
    }

    /// Runout of a journal, and how far its least radius is off (mm).
    fn runout_mm(&self, name: &str) -> (f64, f64) {
        let radii = self.0.machine().part().lobe(name).expect("it is there").radii_mm();
        let low = radii.iter().copied().fold(f64::INFINITY, f64::min);
        let high = radii.iter().copied().fold(0.0, f64::max);
        (high - low, low - RADIUS_MM)
    }
}

/// For each journal: runout before and after (mm), how far its size is off (mm), and what was decided.
fn ground(description: &MachineDescription, job: &JobSpec) -> Vec<(f64, f64, f64, JournalCorrection)> {
    let first: PlannedJob = plan_job(job, description, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
    let mut cell = MachineUnderTest::new(description, job);
    let logs = cell.run(&first.plan);
    let decided = decide_corrections(job, description, &first, &logs, &[]).unwrap_or_else(|error| panic!("{error}"));
    let before: Vec<f64> = job.lobes.iter().map(|lobe| cell.runout_mm(&lobe.name).0).collect();
    let second = plan_corrections(job, description, &first, &decided).unwrap_or_else(|error| panic!("{error}"));
    cell.run(&second.plan);
    let results = job.lobes.iter().zip(before).zip(decided);
    let lines = results.map(|((lobe, before_mm), decided)| {
        let (after_mm, off_mm) = cell.runout_mm(&lobe.name);
        eprintln!(
            "{}: {:.3} um, {:.4} um left, size {:+.4} um off: {decided}",
            lobe.name,
            1e3 * before_mm,
            1e3 * after_mm,
            1e3 * off_mm
        );
        (before_mm, after_mm, off_mm, decided)
    });
    lines.collect()
}

/// One turn takes 99 % of the runout and brings the journal to size, however soft the machine and wherever the gauge.
#[test]
fn a_turn_makes_journals_round_and_to_size() {
    for (ratio, gamma_deg) in
        [(0.05, 270.0), (0.1, 270.0), (0.2, 270.0), (0.5, 270.0), (0.2, 90.0), (0.2, 135.0), (0.2, 225.0), (0.2, 315.0)]
    {
        eprintln!("km/kg {ratio}, gauge at {gamma_deg} deg");
        for (before_mm, after_mm, off_mm, decided) in ground(&grinder(ratio, gamma_deg), &job(GaugingMode::Exact)) {
            assert!((decided.before_mm - before_mm).abs() < 0.02 * before_mm, "{} {before_mm}", decided.before_mm);
            assert!(after_mm < 0.01 * before_mm + 5e-5, "{after_mm} of {before_mm} mm left");
            assert!(off_mm.abs() < 3e-4, "size off by {off_mm} mm");
            // What a spark-out would have needed for the same.
            let turns = decided.spark_out_turns_to(after_mm).expect("a runout");
            assert!(turns > 2.0 * f64::from(decided.turns), "{turns}");
        }
    }
}

/// The job with finishing turns.
fn finishing(mode: GaugingMode, per_turn_mm: f64, turns: u32) -> JobSpec {
    let mut job = job(mode);
    job.correction.as_mut().expect("it corrects").finishing = Some(FinishingSpec::PerTurn { per_turn_mm, turns });
    job
}

/// Finishing turns after the correction take what it left for them and end at the size, as round as the correction alone.
#[test]
fn finishing_turns_end_at_the_size_and_leave_no_spiral() {
    for (ratio, turns) in [(0.1, 4), (0.2, 3), (0.5, 1)] {
        let machine = grinder(ratio, 270.0);
        for (before_mm, after_mm, off_mm, decided) in ground(&machine, &finishing(GaugingMode::Exact, 0.004, turns)) {
            assert!(after_mm < 0.01 * before_mm + 5e-5, "km/kg {ratio}: {after_mm} of {before_mm} mm left");
            assert!(off_mm.abs() < 3e-4, "km/kg {ratio}: size off by {off_mm} mm");
            let alone = ground(&machine, &job(GaugingMode::Exact))[0].3.turns;
            assert_eq!(decided.turns, alone + turns + 1);
            // A spiral with a turn of spark-out leaves λ f.
            let spiral_mm = 0.004 / (1.0 + ratio);
            assert!(decided.forecast.expect("a forecast").left_mm < 0.05 * spiral_mm);
        }
    }
}

/// The published correction reverses a part of the runout, and every finishing turn leaves kg/(kg + km) of what remains.
#[test]
fn finishing_turns_reduce_what_the_published_correction_leaves() {
    let machine = grinder(0.5, 270.0);
    let alone = ground(&machine, &job(GaugingMode::Published));
    let finished = ground(&machine, &finishing(GaugingMode::Published, 0.002, 3));
    for ((_, alone_mm, ..), (_, after_mm, ..)) in alone.iter().zip(&finished) {
        assert!(*after_mm < 0.5 * alone_mm, "{after_mm} of {alone_mm} mm");
    }
}

#[test]
fn finishing_turns_out_of_range_are_refused() {
    let machine = grinder(0.2, 270.0);
    let refusal =
        |per_turn_mm, turns| finishing(GaugingMode::Exact, per_turn_mm, turns).check(&machine).unwrap_err().to_string();
    assert!(refusal(0.0, 3).contains("runout_correction.finishing.per_turn_mm"), "{}", refusal(0.0, 3));
    assert!(refusal(0.004, 0).contains("1 to 20") && refusal(f64::NAN, 3).contains("above 0"));
}

/// σ = 0.2 µm, km/kg = 0.2, two dwell turns: as much as expected, and below the limit. In 24 journals the mean is 4 % below it.
#[test]
fn a_noisy_gauge_leaves_as_much_as_expected() {
    let (mut left_mm, mut expected_mm) = (0.0, 0.0);
    for seed in [1, 2, 3] {
        let mut machine = grinder(0.2, 270.0);
        if let Some(gauge) = &mut machine.gauge {
            (gauge.noise_mm, gauge.resolution_mm, gauge.seed) = (2e-4, 1e-4, seed);
        }
        for (_, after_mm, _, decided) in ground(&machine, &job(GaugingMode::Exact)) {
            let expected = decided.expected.expect("an exact correction");
            // Of steps of 0.1 µm and the contact beside the line of centres there is a tenth of a micrometre more.
            assert!(after_mm < expected.limit_mm + 1e-4, "seed {seed}: {after_mm} mm left, {expected}");
            left_mm += after_mm;
            expected_mm += expected.median_mm;
        }
    }
    assert!((left_mm / expected_mm - 1.0).abs() < 0.2, "{left_mm} mm left, {expected_mm} mm expected");
}

/// To the letter the published way takes a machine that deflects for runout and leaves most of it, in another place; the exact way
/// knows. What the published formula leaves of a runout that is known as it is, is tested with the formulas.
#[test]
fn the_published_turn_takes_a_machine_that_gives_way_for_runout() {
    let machine = grinder(0.2, 270.0);
    let left = |mode: GaugingMode| {
        let (before_mm, after_mm, _, _) = ground(&machine, &job(mode))[0].clone();
        after_mm / before_mm
    };
    let (published, exact) = (left(GaugingMode::Published), left(GaugingMode::Exact));
    eprintln!("left: published {published:.3}, exact {exact:.4}");
    assert!(published > 0.5 && exact < 0.01, "{published} {exact}");
}

/// The published measurement reads over the window and at the step of the job: the default is the 540° and 5° of the text to the bit,
/// a longer window takes older cuts, another step another turn. A window that the dwell does not hold is refused before anything moves.
#[test]
fn window_and_step_of_the_published_method_are_those_of_the_job() {
    let machine = grinder(0.2, 270.0);
    let with = |turned_rad: Option<f64>, phases: u32| {
        let mut job = job(GaugingMode::Published);
        job.correction.as_mut().expect("it corrects").published = PublishedWindow { turned_rad, phases };
        job
    };
    let way = |job: &JobSpec| ground(&machine, job)[0].3.way.clone();
    let text = way(&with(None, 72));
    assert_eq!(way(&with(Some(1.5 * TURN_RAD), 72)), text);
    assert_ne!(way(&with(Some(2.5 * TURN_RAD), 72)), text);
    assert_ne!(way(&with(None, 36)), text);
    let refusal =
        |turned_rad: f64, phases: u32| with(Some(turned_rad), phases).check(&machine).unwrap_err().to_string();
    for turned_rad in [1.4 * TURN_RAD, 3.6 * TURN_RAD] {
        let error = refusal(turned_rad, 72);
        assert!(error.contains("it must be 540 to 1278 with this gauge and 3 spark-out turns"), "{error}");
    }
    assert!(refusal(1.5 * TURN_RAD, 7).contains("8 to 7200"));
}

/// A noisy gauge gives the published turn a slope and a curvature where it begins; neither is carried on over the way in.
#[test]
fn the_published_way_in_never_goes_below_where_the_turn_begins() {
    for seed in [1, 2, 3] {
        let mut machine = grinder(0.2, 270.0);
        if let Some(gauge) = &mut machine.gauge {
            (gauge.noise_mm, gauge.resolution_mm, gauge.seed) = (2e-4, 1e-4, seed);
        }
        for (_, _, off_mm, decided) in ground(&machine, &job(GaugingMode::Published)) {
            let x_mm = |share: f64| decided.way.sample(share * decided.corrects_from_rad).value;
            let ways: Vec<f64> = (0..=2000).map(|i| x_mm(f64::from(i) / 2000.0)).collect();
            assert!(ways.windows(2).all(|pair| pair[1] <= pair[0] + 1e-12), "seed {seed}: it goes in and out");
            assert!(off_mm > 0.0, "seed {seed}: the journal is {off_mm} mm too small");
        }
    }
}

/// A correction that would cut below the journal is refused with where and how much, and nothing has moved.
#[test]
fn a_correction_that_gouges_is_refused_with_where_and_how_much() {
    let (machine, job) = (grinder(0.2, 270.0), job(GaugingMode::Published));
    let first = plan_job(&job, &machine, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
    let logs = MachineUnderTest::new(&machine, &job).run(&first.plan);
    let decided = decide_corrections(&job, &machine, &first, &logs, &[]).unwrap_or_else(|error| panic!("{error}"));
    // The slope and curvature of a noisy turn where the way in ends.
    let mut steep = decided.clone();
    let mut knots = decided[1].way.knots().to_vec();
    (knots[2].first, knots[2].second) = (0.4, -4.0);
    steep[1].way = HermiteSpline::new(knots).expect("as many knots");
    let error = plan_corrections(&job, &machine, &first, &steep).expect_err("it gouges");
    let PlanError::Gouges { lobe, turn: Some(turn), depth_mm, allowed_mm, .. } = &error else { panic!("{error}") };
    assert_eq!(lobe, "J2");
    let entered = decided[1].corrects_from_rad / TURN_RAD;
    assert!((entered - 0.7..entered).contains(turn), "{turn} of {entered}");
    assert!(*depth_mm > 0.05 && *allowed_mm < 2e-3, "{error}");
    assert!(error.to_string().contains("um below the finished contour of lobe J2"), "{error}");
}

/// A job that cannot be measured as published is refused before anything is ground.
#[test]
fn a_gauge_that_does_not_fit_its_method_is_refused_when_the_job_is_planned() {
    let refusal = |mode: GaugingMode, first_deg: f64, second_deg: Option<f64>| {
        let mut machine = grinder(0.2, first_deg);
        if let Some(gauge) = &mut machine.gauge {
            gauge.second_behind_wheel_rad = second_deg.map(f64::to_radians);
        }
        plan_job(&job(mode), &machine, 60.0, None).map(|_| ()).map_err(|error| error.to_string())
    };
    let error = refusal(GaugingMode::Published, 300.0, Some(60.0)).expect_err("two gauges");
    assert!(error.contains("two gauges") && error.contains("runout_correction.mode to exact"), "{error}");
    assert_eq!(refusal(GaugingMode::Exact, 300.0, Some(60.0)), Ok(()));
    assert_eq!(refusal(GaugingMode::Published, 270.0, None), Ok(()));
    for mode in [GaugingMode::Exact, GaugingMode::Published] {
        let error = refusal(mode, 180.0, None).expect_err("it stands opposite the wheel");
        assert!(error.contains("belongs to no side of a cut"), "{error}");
    }
}

/// An amplifier of 50 Hz lags by 1° at a turn a second.
#[test]
fn a_lagging_gauge_gives_the_same_result() {
    let mut machine = grinder(0.2, 270.0);
    if let Some(gauge) = &mut machine.gauge {
        gauge.bandwidth_rad_s = Some(50.0 * TURN_RAD);
    }
    for (before_mm, after_mm, off_mm, _) in ground(&machine, &job(GaugingMode::Exact)) {
        assert!(after_mm < 0.01 * before_mm + 1e-4, "{after_mm} of {before_mm} mm left");
        assert!(off_mm.abs() < 3e-4, "size off by {off_mm} mm");
    }
}

#[test]
fn a_machine_that_cannot_tell_runout_and_a_lobe_that_is_none_are_refused() {
    let fits = grinder(0.2, 270.0);
    let refusal = |job: &JobSpec, machine: &MachineDescription| plan_job(job, machine, 60.0, None).unwrap_err();
    let blind = MachineDescription { gauge: None, ..fits.clone() };
    assert!(refusal(&job(GaugingMode::Exact), &blind).to_string().contains("in-process gauge"));
    let unknown = MachineDescription { contact: None, ..fits.clone() };
    assert!(refusal(&job(GaugingMode::Exact), &unknown).to_string().contains("stiffness"));
    let mut cam = job(GaugingMode::Exact);
    cam.profiles[0].lift = LiftLaw::eccentric_round(1.0, RADIUS_MM + 1.0, 0.0).expect("a lift");
    let error = cam.check(&fits).unwrap_err();
    assert_eq!(error, JobError::NotRound { lobe: "J1".into() });
}

/// Two gauges, 120° apart with the wheel between them: the depth of a cut is the difference of both, known earlier, and the journals
/// are as round and as near to size. In the other order of naming them it is the same.
#[test]
fn two_gauges_tell_the_same_as_one() {
    for (first_deg, second_deg) in [(300.0_f64, 60.0_f64), (60.0, 300.0)] {
        let mut machine = grinder(0.2, first_deg);
        if let Some(gauge) = &mut machine.gauge {
            gauge.second_behind_wheel_rad = Some(second_deg.to_radians());
        }
        for (before_mm, after_mm, off_mm, _) in ground(&machine, &job(GaugingMode::Exact)) {
            assert!(after_mm < 0.01 * before_mm + 5e-5, "{after_mm} of {before_mm} mm left");
            assert!(off_mm.abs() < 3e-4, "size off by {off_mm} mm");
        }
    }
}
