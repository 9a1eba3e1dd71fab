// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Finishing turns by force: their number follows the contact that was measured on each journal, whatever the machine's description says.

use super::stiffness::identifying_job;
use super::*;
use camwright::gauging::finishing::MAX_FINISHING_TURNS;
use camwright::gauging::identify::Identified;
use camwright::planner::identify;

/// Target of the finishing turns (N), and their stock (mm).
const FORCE_N: f64 = 128.0;
const STOCK_MM: f64 = 0.012;

/// A job that measures, with a wide and a narrow journal: kg and F0 of the second are half of those of the first.
fn measuring_job(finishing: FinishingSpec) -> JobSpec {
    let mut job = identifying_job();
    job.lobes[1].width_mm = 0.5 * WIDTH_MM;
    job.correction.as_mut().expect("it corrects").finishing = Some(finishing);
    job
}

fn by_force(force_n: f64, max_turns: u32) -> FinishingSpec {
    FinishingSpec::ByForce { stock_mm: STOCK_MM, force_n, max_turns }
}

/// A part that is harder than the machine's description says, or a wheel that is blunter.
fn harder(description: &MachineDescription, factor: f64) -> MachineDescription {
    let mut truth = description.clone();
    truth.contact.as_mut().expect("it deflects").grinding_n_mm2 *= factor;
    truth
}

/// The first half of a job, planned with a description and ground on another machine.
struct FirstHalf {
    first: PlannedJob,
    cell: MachineUnderTest,
    logs: Vec<JournalReadings>,
    measured: Vec<Option<Identified>>,
}

impl FirstHalf {
    fn grind(description: &MachineDescription, truth: &MachineDescription, job: &JobSpec) -> Self {
        let first = plan_job(job, description, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
        let mut cell = MachineUnderTest::new(truth, job);
        let logs = cell.run(&first.plan);
        let measured = identify(job, description, &first, &logs).into_iter();
        let measured = measured.map(|measured| Some(measured.unwrap_or_else(|error| panic!("{error}")))).collect();
        Self { first, cell, logs, measured }
    }
}

/// Result of a journal: finishing turns, peak force in them (N), runout and error of the size (mm).
#[derive(Debug)]
struct Finished {
    turns: u32,
    peak_n: f64,
    runout_mm: f64,
    off_mm: f64,
}

/// Grinds a job planned with a description on a machine that is another one.
fn finished(description: &MachineDescription, truth: &MachineDescription, finishing: FinishingSpec) -> Vec<Finished> {
    let job = measuring_job(finishing);
    let FirstHalf { first, mut cell, logs, measured } = FirstHalf::grind(description, truth, &job);
    let decided = decide_corrections(&job, description, &first, &logs, &measured);
    let decided = decided.unwrap_or_else(|error| panic!("{error}"));
    let second = plan_corrections(&job, description, &first, &decided).unwrap_or_else(|error| panic!("{error}"));
    let prepared = Prepared::new(Motion::Plan(Arc::new(second.plan)), truth).expect("a plan");
    // C and normal force while a lobe stands in front of the wheel, apart for each time that it does.
    let mut stays: Vec<(usize, Vec<(f64, f64)>)> = Vec::new();
    let simulated = cell.0.simulate(Box::new(prepared), |_, report| {
        let lobe = report.lobe.unwrap_or(usize::MAX);
        if stays.last().is_none_or(|(last, _)| *last != lobe) {
            stays.push((lobe, Vec::new()));
        }
        if let Some((_, ticks)) = stays.last_mut() {
            ticks.push((report.axes[0].position, report.normal_force_n));
        }
    });
    simulated.unwrap_or_else(|error| panic!("{error}"));
    let journals = job.lobes.iter().zip(&decided).enumerate();
    let results = journals.map(|(index, (lobe, decided))| {
        let of_lobe = stays.iter().filter(|(lobe, _)| *lobe == index).map(|(_, ticks)| ticks);
        let forces = of_lobe.max_by_key(|ticks| ticks.len()).expect("it was ground");
        let finishing = decided.finishing.expect("it finishes");
        let from_rad = forces[0].0 + decided.corrects_from_rad + TURN_RAD;
        let to_rad = from_rad + f64::from(finishing.all_turns()) * TURN_RAD;
        let within = forces.iter().filter(|(c_rad, _)| (from_rad..to_rad).contains(c_rad));
        let peak_n = within.map(|(_, force_n)| *force_n).fold(0.0, f64::max);
        let (runout_mm, off_mm) = cell.runout_mm(&lobe.name);
        eprintln!("{}: {decided}; {peak_n:.1} N, {runout_mm:.6} mm left, {off_mm:+.6} mm off", lobe.name);
        Finished { turns: finishing.turns, peak_n, runout_mm, off_mm }
    });
    results.collect()
}

/// U = (128 − F0)/kg, and N − 1/4 ≥ 12/U. F0 = 15 N and kg = 30 N/µm on the first journal, half of both on the second, kg times 0.5, 1 and 2.
/// The force is measured in the simulated machine. It exceeds the target by no more than an error of 3 % of kg; a fixed depth doubles it.
#[test]
fn a_planted_hardness_changes_the_turns_and_not_the_force() {
    let description = grinder(0.2, 270.0);
    for (factor, turns) in [(0.5, [2, 1]), (1.0, [4, 2]), (2.0, [7, 4])] {
        let truth = harder(&description, factor);
        let journals = finished(&description, &truth, by_force(FORCE_N, MAX_FINISHING_TURNS));
        for (journal, turns) in journals.iter().zip(turns) {
            assert_eq!(journal.turns, turns, "kg x{factor}: {journal:?}");
            assert!(journal.peak_n < 1.03 * FORCE_N && journal.peak_n > 0.5 * FORCE_N, "kg x{factor}: {journal:?}");
            assert!(journal.runout_mm < 5e-4 && journal.off_mm.abs() < 5e-4, "kg x{factor}: {journal:?}");
        }
    }
    let fixed = FinishingSpec::PerTurn { per_turn_mm: 0.004, turns: 3 };
    let [as_described, blunt] = [1.0, 2.0].map(|factor| {
        let journals = finished(&description, &harder(&description, factor), fixed);
        journals.iter().map(|journal| journal.peak_n).collect::<Vec<f64>>()
    });
    for (threshold_n, (as_described, blunt)) in [15.0, 7.5].into_iter().zip(as_described.iter().zip(&blunt)) {
        let ratio = (blunt - threshold_n) / (as_described - threshold_n);
        assert!((ratio - 2.0).abs() < 0.1, "{as_described} N, {blunt} N on a part twice as hard");
    }
}

/// The way is the same to the bit if the force allows as many turns as the job states otherwise. A measured contact that needs more
/// turns than the job permits is refused with the journal, its contact and the force that is enough.
#[test]
fn the_decision_is_the_stated_one_or_is_refused() {
    let description = grinder(0.2, 270.0);
    let truth = harder(&description, 2.0);
    let job = measuring_job(by_force(FORCE_N, MAX_FINISHING_TURNS));
    let half = FirstHalf::grind(&description, &truth, &job);
    let decide = |finishing: FinishingSpec| {
        decide_corrections(&measuring_job(finishing), &description, &half.first, &half.logs, &half.measured)
    };
    let by_force_of = |max_turns: u32| decide(by_force(FORCE_N, max_turns));
    let decided = by_force_of(MAX_FINISHING_TURNS).expect("a decision");
    assert_eq!(by_force_of(7).as_ref(), Ok(&decided), "the bound changes nothing that it permits");
    let turns: Vec<u32> = decided.iter().map(|decided| decided.finishing.expect("it finishes").turns).collect();
    assert_eq!(turns, [7, 4]);
    for (index, turns) in turns.into_iter().enumerate() {
        let stated = decide(FinishingSpec::PerTurn { per_turn_mm: STOCK_MM / f64::from(turns), turns });
        let stated = &stated.expect("a decision")[index];
        assert_eq!((&stated.way, stated.turns), (&decided[index].way, decided[index].turns));
    }
    let error = by_force_of(6).expect_err("too many turns").to_string();
    for words in ["lobe J1: finishing at 128 N takes 1.", "12.0 um need 7 turns, at most 6", "force_n to 13"] {
        assert!(error.contains(words), "{words}: {error}");
    }
    let error = decide(by_force(10.0, 20)).expect_err("it rubs").to_string();
    assert!(error.contains("finishing at 10 N takes nothing"), "{error}");
}

#[test]
fn forces_and_stocks_out_of_range_are_refused() {
    let machine = grinder(0.2, 270.0);
    let refusal = |stock_mm: f64, force_n: f64, max_turns: u32| {
        let job = measuring_job(FinishingSpec::ByForce { stock_mm, force_n, max_turns });
        job.check(&machine).err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert_eq!(refusal(STOCK_MM, FORCE_N, MAX_FINISHING_TURNS), "");
    for (stock_mm, force_n, max_turns, words) in [
        (f64::NAN, FORCE_N, 20, "runout_correction.finishing.stock_mm"),
        (0.0, FORCE_N, 20, "above 0 and at most 1"),
        (1.1, FORCE_N, 20, "above 0 and at most 1"),
        (STOCK_MM, f64::NAN, 20, "runout_correction.finishing.force_n"),
        (STOCK_MM, 0.0, 20, "above 0 and at most 20000"),
        (STOCK_MM, f64::INFINITY, 20, "above 0 and at most 20000"),
        (STOCK_MM, FORCE_N, 0, "runout_correction.finishing.max_turns is 0; it must be 1 to 20"),
        (STOCK_MM, FORCE_N, 21, "1 to 20"),
        (0.12, FORCE_N, 2, "stock_um is 120.0; with max_turns 2 it must be at most 100"),
    ] {
        let error = refusal(stock_mm, force_n, max_turns);
        assert!(error.contains(words), "{words}: {error}");
    }
    let mut published = measuring_job(by_force(FORCE_N, MAX_FINISHING_TURNS));
    published.correction.as_mut().expect("it corrects").mode = GaugingMode::Published;
    assert_eq!(published.check(&machine), Err(JobError::FinishingByForcePublished));
}
