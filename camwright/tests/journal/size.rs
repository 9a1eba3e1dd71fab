// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Gauge-controlled size: the infeed ends when the gauge reads the size, whatever the wheel really is.

use super::{KG_N_MM, MachineUnderTest, RADIUS_MM, WIDTH_MM, grinder, job};
use camwright::gauging::GaugingMode;
use camwright::interpolator::{InfeedEnd, Motion, Prepared};
use camwright::job::grinding::{JobSpec, SizeControl};
use camwright::machine::contact_law::ContactLaw;
use camwright::machine::description::MachineDescription;
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::wheel_state::WheelNow;
use camwright::planner::deflection::{Deflections, SizeForecast};
use camwright::planner::{PlannedJob, plan_job};
use camwright::simulation::closed_loop::{ClosedLoop, SimulationError};
use std::sync::Arc;

/// Infeed of a turn (mm): a tick of a turn of a second is 3.6 nm of it.
const FEED_MM: f64 = 0.0036;
const SPARK_OUT_TURNS: u32 = 8;
/// Stiffness of the machine by that of the cut at the two journals of [`grinder`] at 0.5.
const RATIOS: [f64; 2] = [0.5, 0.4];

/// Steps of a turn in the forecast of the size.
const FORECAST_PHASES: f64 = 72.0;

/// Infeed beyond the finished size (mm).
const BEYOND_MM: f64 = 0.0504;

/// Two journals with 30 µm of stock, fed slowly.
fn sized(size: Option<f64>) -> JobSpec {
    slow(0.03, 12.0, size)
}

/// Two journals with this stock (mm), fed slowly in so many turns; with a size the infeed goes beyond it.
fn slow(stock_mm: f64, turns: f64, size: Option<f64>) -> JobSpec {
    let mut job = job(GaugingMode::Exact);
    job.correction = None;
    job.stock_mm = stock_mm;
    job.raw_part.eccentric.mm = 0.003;
    job.raw_part.lobes.clear();
    let pass = &mut job.passes[0];
    pass.infeed_per_block_mm = FEED_MM / 3600.0;
    pass.total_infeed_mm = FEED_MM * turns + if size.is_some() { BEYOND_MM } else { 0.0 };
    pass.spark_out_turns = SPARK_OUT_TURNS;
    pass.gauge_size = size.map(|ends_above_mm| SizeControl { ends_above_mm, beyond_mm: BEYOND_MM });
    job
}

/// Mean radius of each journal above its nominal one (mm), and the ends of the infeeds, ground by a wheel that has lost so much (mm).
fn ground(
    machine: &MachineDescription,
    job: &JobSpec,
    wear_mm: f64,
) -> Result<(Vec<f64>, Vec<InfeedEnd>), SimulationError> {
    let planned: PlannedJob = plan_job(job, machine, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
    let wheel = WheelNow { wear_mm, ..WheelNow::dressed(60.0) };
    let MachineUnderTest(closed_loop) =
        MachineUnderTest::with_wheel(machine, job, PersistentState::new(machine).with_wheel(wheel));
    run(closed_loop, &planned, job)
}

fn run(
    mut closed_loop: ClosedLoop,
    planned: &PlannedJob,
    job: &JobSpec,
) -> Result<(Vec<f64>, Vec<InfeedEnd>), SimulationError> {
    let description = closed_loop.machine().description().clone();
    let motion = Prepared::new(Motion::Plan(Arc::new(planned.plan.clone())), &description).expect("a plan");
    closed_loop.simulate(Box::new(motion), |_, _| {})?;
    let above = job.lobes.iter().map(|lobe| {
        let radii = closed_loop.machine().part().lobe(&lobe.name).expect("it was loaded").radii_mm();
        radii.iter().sum::<f64>() / radii.len() as f64 - RADIUS_MM
    });
    Ok((above.collect(), closed_loop.infeed_ends().to_vec()))
}

fn rigid() -> MachineDescription {
    MachineDescription { contact: None, ..grinder(0.2, 270.0) }
}

/// On a rigid machine the radius under the wheel is S/2 − f when the mean diameter of a turn is S: half a turn of mean and half a turn of
/// the two contacts at 270° and 90° behind the wheel lag by f. Until the infeed ends, D ticks pass. The wheel has no part in it.
#[test]
fn the_size_of_a_rigid_machine_is_the_closed_form_whatever_the_wheel() {
    let (machine, above_mm) = (rigid(), 0.012);
    let job = sized(Some(above_mm));
    let delay_turns = f64::from(machine.feedback_delay_ticks) * machine.cycle_time_s();
    let expected_mm = 0.5 * above_mm - FEED_MM * (1.0 + delay_turns);
    for wear_mm in [0.0, 0.01, 0.02] {
        let (sizes, ends) = ground(&machine, &job, wear_mm).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(ends.len(), 2, "both journals");
        for (size_mm, end) in sizes.iter().zip(&ends) {
            let off_um = 1e3 * (size_mm - expected_mm);
            eprintln!("wear {wear_mm} mm: {off_um:+.4} um off the closed form, {end:?}");
            assert!(off_um.abs() < 0.01, "wear {wear_mm} mm: {off_um} um off {expected_mm} mm");
            // The position of X shows what the wheel has lost, and whole turns are left out.
            let x_mm = FEED_MM * 12.0 - end.infed_mm;
            assert!((x_mm - (size_mm - wear_mm)).abs() < 2e-5, "{x_mm} mm, {size_mm} mm");
            assert!((f64::from(end.left_out) + end.turn.ceil() - 26.0).abs() < 1e-9, "{end:?}");
        }
        let (without, _) = ground(&machine, &sized(None), wear_mm).unwrap_or_else(|error| panic!("{error}"));
        // Without the gauge the part is larger by what the wheel has lost.
        assert!(without.iter().all(|size_mm| (size_mm - wear_mm).abs() < 2e-5), "{without:?}");
    }
}

/// The wheel and the part deflect: once the depth of cut is steady the size is the same on every wheel, also on one that wears while it
/// grinds, and as forecast. The turn in which the size is read is finished, so up to one turn more sparks out: after m turns that takes
/// λ^(m+1) f at most, f being the infeed of a turn and λ = kg/(kg + km).
#[test]
fn a_worn_wheel_does_not_change_the_size_of_a_compliant_machine() {
    let machine = grinder(0.5, 270.0);
    let (job, plain) = (slow(0.08, 25.0, Some(0.036)), slow(0.08, 25.0, None));
    let (reference, _) = ground(&machine, &job, 0.0).unwrap_or_else(|error| panic!("{error}"));
    let (nominal, _) = ground(&machine, &plain, 0.0).unwrap_or_else(|error| panic!("{error}"));
    let mut wearing = machine.clone();
    wearing.wheel.grinding_ratio = Some(10.0);
    for (machine, wear_mm) in [(&machine, 0.01), (&machine, 0.02), (&wearing, 0.0)] {
        let (sizes, _) = ground(machine, &job, wear_mm).unwrap_or_else(|error| panic!("{error}"));
        let off_um: Vec<f64> = sizes.iter().zip(&reference).map(|(size, reference)| 1e3 * (size - reference)).collect();
        let (without, _) = ground(machine, &plain, wear_mm).unwrap_or_else(|error| panic!("{error}"));
        let without_um = 1e3 * (without[1] - nominal[1]);
        eprintln!("wear {wear_mm} mm: {off_um:?} um with the gauge, {without_um:.3} um without");
        for (off_um, ratio) in off_um.iter().zip(RATIOS) {
            let spark_out_um = 1e3 * FEED_MM * (1.0 / (1.0 + ratio)).powi(1 + SPARK_OUT_TURNS as i32);
            // A wheel that wears feeds less than it should, and goes on wearing after the size.
            let wears_um = machine.wheel.grinding_ratio.map_or(0.0, |_| 0.2 * without_um);
            let allowed_um = spark_out_um + wears_um + 0.02;
            assert!(off_um.abs() < allowed_um, "{off_um} um with the gauge, {allowed_um} um allowed");
        }
        assert!(without_um > 2.0, "{without_um} um without the gauge");
    }
    let planned = plan_job(&job, &machine, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
    for (index, (size_mm, ratio)) in reference.iter().zip(RATIOS).enumerate() {
        let law = ContactLaw::new(ratio * KG_N_MM, KG_N_MM, 0.75 * WIDTH_MM).expect("a law");
        let found = Deflections::from_lobe(&planned.plan, index, job.stock_mm, &law, &machine).expect("it is cut");
        assert!(matches!(found.size, Some(SizeForecast::Reached { .. })), "{found:?}");
        let off_um = 1e3 * (size_mm - found.left_mm);
        // The forecast ends the infeed within a phase of the turn, and may finish another turn than the real one.
        let phase_um = 1e3 * FEED_MM / FORECAST_PHASES;
        let allowed_um = 1e3 * FEED_MM * (1.0 / (1.0 + ratio)).powi(1 + SPARK_OUT_TURNS as i32) + phase_um;
        eprintln!("{off_um:.3} um off the forecast, {allowed_um:.3} um allowed");
        assert!(off_um.abs() < allowed_um, "{off_um} um off the forecast {found:?}, {allowed_um} um allowed");
    }
}

/// A wheel that has lost more than the infeed may go beyond the size: the motion stops with the alarm, and nothing is called finished.
#[test]
fn a_size_that_the_infeed_does_not_reach_is_an_alarm() {
    let machine = rigid();
    let planned = plan_job(&sized(Some(0.012)), &machine, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
    let wheel = WheelNow { wear_mm: 0.08, ..WheelNow::dressed(60.0) };
    let lasting = PersistentState::new(&machine).with_wheel(wheel);
    let MachineUnderTest(mut closed_loop) = MachineUnderTest::with_wheel(&machine, &sized(Some(0.012)), lasting);
    let motion = Prepared::new(Motion::Plan(Arc::new(planned.plan)), &machine).expect("a plan");
    let simulated = closed_loop.simulate(Box::new(motion), |_, _| {}).expect("it comes to rest");
    assert_eq!(simulated.outcome, camwright::interpolator::MotionOutcome::Failed(142));
    assert!(closed_loop.infeed_ends().is_empty());
}

/// A size that the gauge cannot control is refused with the reason, before a path is planned.
#[test]
fn sizes_that_make_no_sense_are_refused() {
    let fits = rigid();
    let refusal = |machine: &MachineDescription, change: &dyn Fn(&mut JobSpec)| {
        let mut job = sized(Some(0.012));
        change(&mut job);
        job.check(machine).expect_err("must be refused").to_string()
    };
    assert_eq!(sized(Some(0.012)).check(&fits), Ok(()));
    let blind = MachineDescription { gauge: None, ..fits.clone() };
    assert!(refusal(&blind, &|_| {}).contains("no in-process gauge"));
    let mut single = fits.clone();
    single.gauge.as_mut().expect("a gauge").kind = camwright::machine::description::GaugeKind::Radius;
    assert!(refusal(&single, &|_| {}).contains("single contact"));
    let above =
        |mm: f64| move |job: &mut JobSpec| job.passes[0].gauge_size.as_mut().expect("a size").ends_above_mm = mm;
    assert!(refusal(&fits, &above(-0.001)).contains("0 is the finished diameter"));
    assert!(refusal(&fits, &above(0.06)).contains("60.0 um on the diameter before the pass"));
    assert!(refusal(&fits, &|job| job.rotary_indexing = true).contains("rotary_indexing"));
    assert!(refusal(&fits, &|job| job.profiles[0].throw_mm = 5.0).contains("crank pin"));
    let rough = |job: &mut JobSpec| {
        let last = job.passes[0].clone();
        job.passes.push(camwright::job::grinding::PassSpec { name: "fine".into(), gauge_size: None, ..last });
    };
    assert!(refusal(&fits, &rough).contains("last pass"));
    let corrected = |job: &mut JobSpec| job.correction = super::job(GaugingMode::Exact).correction;
    assert!(refusal(&fits, &corrected).contains("runout_correction"));
}
