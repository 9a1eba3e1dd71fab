// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A prepared job run through interpolator and machine without ROS: what it would grind, on its machine and on one that lacks
//! an effect which leaves an error.

use super::lobes::sections_result;
use super::wide_lobes::{WideLobeForm, wide_lobe_forms};
use super::{PreparedJob, correct, raw_part};
use camwright::interpolator::{Motion, MotionOutcome, Prepared};
use camwright::job::plunges::LobeSection;
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{Effect, MachineDescription};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::setpoint::Setpoint;
use camwright::planner::JournalReadings;
use camwright::planner::PlannedLobe;
use camwright::simulation::Machine;
use camwright::simulation::closed_loop::{ClosedLoop, Simulated, SimulationError};
use camwright::simulation::tick_report::TickReport;
use camwright_files::convert::gauge::{log, readings};
use camwright_files::convert::machine_report::cut_of;
use camwright_files::convert::plan::plan_from_pages;
use camwright_files::convert::{centre_from_values, compliance_from_values, m_from_mm, mm_from_m, offset_from_values};
use camwright_msgs::camwright_msgs::msg::{LobeResult, PartLobe, PlanPage};
use std::fmt::Display;
use std::sync::Arc;
use thiserror::Error;

/// A simulation that gave no part.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("the simulation of {job} failed: {reason}")]
pub struct SimulationFailed {
    /// Name of the job.
    pub job: String,
    pub reason: String,
    /// Number of the alarm that stopped the machine.
    pub alarm: Option<u16>,
}

impl SimulationFailed {
    pub(super) fn new(job: &str, reason: &dyn Display) -> Self {
        Self { job: job.to_owned(), reason: reason.to_string(), alarm: None }
    }

    fn alarmed(job: &str, number: u16) -> Self {
        let name = AlarmKind::from_number(number).map_or("an unknown alarm", |kind| kind.entry().name);
        Self { alarm: Some(number), ..Self::new(job, &format!("alarm {number}: {name}")) }
    }

    pub(super) fn stopped(job: &str, error: &SimulationError) -> Self {
        let alarm = match error {
            SimulationError::Alarm(alarm) => Some(alarm.kind.entry().number),
            SimulationError::Start(_) | SimulationError::NotSettled => None,
        };
        Self { alarm, ..Self::new(job, error) }
    }
}

/// Radii of every lobe in the order of machining (mm, at equal azimuths).
pub type Outlines = Vec<Vec<f64>>;

/// Runs a job on its machine without these effects, and measures the ground part. Calls `on_tick` for every tick of the motion.
///
/// # Errors
/// A motion that does not come to its end; what cannot be measured.
pub fn simulate_job(
    prepared: &PreparedJob,
    without: &[Effect],
    on_tick: impl FnMut(&Setpoint, &TickReport),
) -> Result<(Simulated, Vec<LobeResult>), SimulationFailed> {
    let own = prepared.machine.clone();
    let description = without.iter().fold(own, |machine, effect| machine.without(*effect));
    simulate_job_on(prepared, &description, on_tick)
}

/// Runs a job on a machine that differs from its own in nothing that its plan was made for, and measures what was ground.
///
/// # Errors
/// See [`simulate_job`].
pub fn simulate_job_on(
    prepared: &PreparedJob,
    description: &MachineDescription,
    on_tick: impl FnMut(&Setpoint, &TickReport),
) -> Result<(Simulated, Vec<LobeResult>), SimulationFailed> {
    let (simulated, results, _) = simulate_outlines_on(prepared, description, on_tick)?;
    Ok((simulated, results))
}

/// The same, with the outlines of the lobes (mm, at equal azimuths) in their order.
///
/// # Errors
/// See [`simulate_job`].
pub fn simulate_outlines_on(
    prepared: &PreparedJob,
    description: &MachineDescription,
    on_tick: impl FnMut(&Setpoint, &TickReport),
) -> Result<(Simulated, Vec<LobeResult>, Outlines), SimulationFailed> {
    let part = simulate_whole(prepared, description, on_tick, |_| {})?;
    Ok((part.simulated, part.results, part.outlines_mm))
}

/// Runs a job on a machine, and measures what was ground with the sections of its wide lobes.
///
/// # Errors
/// See [`simulate_job`].
pub fn simulate_wide_lobes(
    prepared: &PreparedJob,
    description: &MachineDescription,
) -> Result<(Vec<LobeResult>, Vec<WideLobeForm>), SimulationFailed> {
    let part = simulate_whole(prepared, description, |_, _| {}, |_| {})?;
    let forms = wide_lobe_forms(prepared, &part.sections);
    Ok((part.results, forms))
}

/// Runs a job on a machine and measures the ground part; passes the decisions between its plans to `report_line`.
#[cfg(test)]
pub(super) fn simulate_with_report(
    prepared: &PreparedJob,
    description: &MachineDescription,
    report_line: impl FnMut(String),
) -> Result<(Simulated, Vec<LobeResult>), SimulationFailed> {
    let part = simulate_whole(prepared, description, |_, _| {}, report_line)?;
    Ok((part.simulated, part.results))
}

/// The machine, with the job's raw part in it.
pub fn with_raw_part(prepared: &PreparedJob, description: &MachineDescription) -> Result<Machine, String> {
    let lasting = PersistentState::new(description).with_wheels(&prepared.wheels);
    let mut machine = Machine::new(description.clone(), lasting).map_err(|error| error.to_string())?;
    for raw in raw_part(prepared) {
        let radii = raw.radius.iter().map(|radius| mm_from_m(*radius)).collect();
        let outline = (offset_from_values(&raw.centre), mm_from_m(raw.width), radii);
        machine.set_keyway(raw.key_way);
        let loaded = machine.load_section(&raw.name, &raw.station, outline, centre_from_values(&raw.centre));
        let held = loaded.and_then(|()| machine.set_part_compliance(&raw.name, compliance_from_values(&raw.centre)));
        held.map_err(|error| error.to_string())?;
    }
    Ok(machine)
}

/// A simulated job with the part that it ground.
struct GroundPart {
    simulated: Simulated,
    results: Vec<LobeResult>,
    outlines_mm: Outlines,
    /// Every section of every lobe.
    sections: Vec<PartLobe>,
}

fn simulate_whole(
    prepared: &PreparedJob,
    description: &MachineDescription,
    mut on_tick: impl FnMut(&Setpoint, &TickReport),
    mut report_line: impl FnMut(String),
) -> Result<GroundPart, SimulationFailed> {
    let job = &prepared.planned.plan.job;
    let failed = |reason: String| SimulationFailed::new(job, &reason);
    let mut closed_loop = ClosedLoop::direct(with_raw_part(prepared, description).map_err(failed)?);
    let mut run = |pages: &[PlanPage], on_tick: &mut dyn FnMut(&Setpoint, &TickReport)| {
        // The plan as a receiver of its pages has it: the way through metres is part of it.
        let (plan, _) = plan_from_pages(pages, description).map_err(|error| failed(error.to_string()))?;
        let motion =
            Prepared::new(Motion::Plan(Arc::new(plan)), description).map_err(|error| failed(error.to_string()))?;
        let simulated = closed_loop.simulate(Box::new(motion), on_tick);
        match simulated.map_err(|error| SimulationFailed::stopped(job, &error))? {
            // An alarm of the interpolator itself, as of a size that the infeed does not reach.
            Simulated { outcome: MotionOutcome::Failed(number), .. } => Err(SimulationFailed::alarmed(job, number)),
            simulated => Ok(simulated),
        }
    };
    let mut logged = |pages: &[PlanPage], on_tick: &mut dyn FnMut(&Setpoint, &TickReport)| {
        let mut logs = vec![JournalReadings::default(); prepared.planned.lobes.len()];
        let simulated = run(pages, &mut |setpoint, report| {
            if let Some(lobe) = report.lobe.and_then(|lobe| logs.get_mut(lobe)) {
                for (number, reading) in readings(description, report).enumerate() {
                    log(lobe, &reading, number > 0);
                }
            }
            on_tick(setpoint, report);
        })?;
        Ok::<_, SimulationFailed>((simulated, logs))
    };
    let (mut first_tick, mut for_stock) = (None, None);
    if let Some(measuring) = &prepared.measuring {
        let (simulated, logs) = logged(&measuring.pages, &mut on_tick)?;
        first_tick = Some(simulated.first_tick);
        let stock = super::for_stock(prepared, &logs).map_err(|error| failed(error.to_string()))?;
        stock.lines.into_iter().chain([stock.saved]).for_each(&mut report_line);
        for_stock = Some(stock.prepared);
    }
    let prepared = for_stock.as_ref().unwrap_or(prepared);
    let (mut simulated, logs) = logged(&prepared.pages, &mut on_tick)?;
    simulated.first_tick = first_tick.unwrap_or(simulated.first_tick);
    let correction = match prepared.expected_correction {
        Some(_) => match prepared.dry_correction() {
            Some(dry) => Some(dry),
            None => Some(correct(prepared, &logs).map_err(|error| failed(error.to_string()))?),
        },
        None => None,
    };
    if let Some(correction) = &correction {
        correction.summary_lines(prepared).into_iter().for_each(&mut report_line);
        let second = run(&correction.pages, &mut on_tick)?;
        simulated = Simulated { outcome: second.outcome, last_tick: second.last_tick, ..simulated };
    }
    let machine = closed_loop.machine();
    let measured = |section: LobeSection| {
        let Some(lobe) = machine.part().lobe(&section.name) else { return PartLobe::default() };
        let common_mm = lobe.width_mm().min(description.wheel.width_mm);
        let cut = lobe.cut_record().map(|record| cut_of(record, common_mm));
        let radius = lobe.radii_mm().iter().map(|radius| m_from_mm(*radius)).collect();
        PartLobe { name: section.name, radius, key_way: machine.key_way_rad(), ..cut.unwrap_or_default() }
    };
    let ground = |lobe: &PlannedLobe| {
        machine.part().lobe(&lobe.design.name).map_or_else(Vec::new, |lobe| lobe.radii_mm().to_vec())
    };
    let outlines_mm: Outlines = prepared.finished_lobes().map(|(_, lobe)| ground(lobe)).collect();
    let (mut results, mut sections) = (Vec::new(), Vec::new());
    for (_, lobe) in prepared.finished_lobes() {
        let of_lobe: Vec<PartLobe> = lobe.design.sections().into_iter().map(measured).collect();
        results.push(sections_result(&lobe.design, &of_lobe).map_err(|error| failed(error.to_string()))?);
        sections.extend(of_lobe);
    }
    if let Some(correction) = &correction {
        correction.add_to(&mut results);
    }
    Ok(GroundPart { simulated, results, outlines_mm, sections })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare;
    use camwright::cam::form::Form;
    use camwright::math::units::um_from_mm;
    use camwright_files::convert::mm_from_m;

    /// The default job on an ideal machine is ground within 1 µm of the design, on its own honestly worse.
    #[test]
    fn the_default_job_is_within_a_micrometre_on_an_ideal_machine() {
        let short = ["infeed.total_mm=0.072".to_owned(), "stock_mm=0.06".to_owned()];
        let prepared = prepare("four_lobe_camshaft", &short, None).unwrap();
        let worst = |without: &[Effect]| {
            let (_, lobes) = simulate_job(&prepared, without, |_, _| {}).unwrap();
            let um = |lobe: &LobeResult| um_from_mm(mm_from_m(lobe.form_error_max.abs()));
            lobes.iter().map(um).fold(0.0, f64::max)
        };
        let (ideal, ordinary) = (worst(&Effect::ALL), worst(&[]));
        eprintln!("ideal {ideal} um, ordinary {ordinary} um");
        assert!(ideal < 1.0, "{ideal} um");
        assert!(ordinary > ideal, "{ordinary} um, ideal {ideal} um");
    }

    /// Infeed once per turn, along the normal, or both: the lobes end in their nominal form.
    #[test]
    fn every_kind_of_infeed_grinds_the_design_within_a_micrometre() {
        for kind in
            [["infeed.course=per_turn", "infeed.along=x_axis"], ["infeed.course=per_turn", "infeed.along=normal"]]
        {
            let short = ["infeed.total_mm=0.072", "stock_mm=0.06", kind[0], kind[1]].map(str::to_owned);
            let prepared = prepare("four_lobe_camshaft", &short, None).unwrap();
            let (_, lobes) = simulate_job(&prepared, &Effect::ALL, |_, _| {}).unwrap();
            for lobe in lobes {
                let um = um_from_mm(mm_from_m(lobe.form_error_max.abs()));
                assert!(um < 1.0, "{kind:?}: lobe {} is off by {um} um", lobe.name);
            }
        }
    }

    /// The shipped pump ring, ground inside in both senses of rotation: within 0.1 µm on ideal drives without deflection, and within 2 µm with
    /// good drives.
    #[test]
    fn a_pump_ring_is_ground_inside_to_its_form() {
        for sense in [1, -1] {
            let located = camwright_files::locate::locate("jobs", "pump_ring", "yaml", None).unwrap();
            let mut job = camwright_files::job_file::parse(&located, &[]).unwrap();
            job.machine.description.rotation_sense = sense;
            let prepared = crate::plan(job, None).unwrap();
            let worst = |description: &MachineDescription| {
                let (_, lobes, _) = simulate_outlines_on(&prepared, description, |_, _| {}).unwrap();
                um_from_mm(mm_from_m(lobes[0].form_error_max.abs()))
            };
            let ideal =
                Effect::ALL.into_iter().fold(prepared.machine.clone(), |machine, effect| machine.without(effect));
            let good = prepared.machine.clone().with_good_drives().expect("the machine file has them");
            let (ideal_um, good_um) = (worst(&ideal), worst(&good));
            eprintln!("sense {sense}: ideal {ideal_um:.3} um, good drives {good_um:.3} um");
            assert!(ideal_um < 0.1, "sense {sense}: {ideal_um} um on ideal drives");
            assert!(good_um < 2.0, "sense {sense}: {good_um} um with good drives");
        }
    }

    /// The shipped crank pins, ground in both senses of rotation, the last from a raw part that the wheel meets over a share of each turn at
    /// first: round within 0.1 µm on ideal drives without deflection, and within 2 µm of their form with good drives.
    #[test]
    fn crank_pins_are_ground_round() {
        for (sense, raw_part) in [(1, "raw_part={}"), (-1, "raw_part={}"), (1, "raw_part.eccentric_um=10")] {
            let located = camwright_files::locate::locate("jobs", "crank_pins", "yaml", None).unwrap();
            let short = ["infeed.total_mm=0.018", "roughing.0.infeed.total_mm=0.036", "stock_mm=0.04", raw_part]
                .map(String::from);
            let mut job = camwright_files::job_file::parse(&located, &short).unwrap();
            job.machine.description.rotation_sense = sense;
            let prepared = crate::plan(job, None).unwrap();
            let worst = |description: &MachineDescription| {
                let (_, lobes, outlines) = simulate_outlines_on(&prepared, description, |_, _| {}).unwrap();
                let form =
                    lobes.iter().map(|lobe| um_from_mm(mm_from_m(lobe.form_error_max.abs()))).fold(0.0, f64::max);
                let roundness = prepared.planned.lobes.iter().zip(&outlines).map(|(lobe, radii_mm)| {
                    let (contour, phase_rad) = (&lobe.design.contour, lobe.design.phase_rad);
                    let form = Form::measure(radii_mm, contour, phase_rad).unwrap();
                    um_from_mm(form.pin(contour, phase_rad).expect("a pin").roundness_mm)
                });
                (form, roundness.fold(0.0, f64::max))
            };
            let ideal =
                Effect::ALL.into_iter().fold(prepared.machine.clone(), |machine, effect| machine.without(effect));
            let (ideal_form, ideal_roundness) = worst(&ideal);
            let (form, roundness) = worst(&prepared.machine);
            let good = prepared.machine.clone().with_good_drives().expect("the machine file has them");
            let (good_form, good_roundness) = worst(&good);
            eprintln!(
                "sense {sense}, {raw_part}, form and roundness: ideal {ideal_form:.3} {ideal_roundness:.3}, own drives {form:.3} {roundness:.3}, \
                 good drives {good_form:.3} {good_roundness:.3} um"
            );
            assert!(ideal_form < 0.2 && ideal_roundness < 0.1, "sense {sense}: {ideal_form} um, {ideal_roundness} um");
            assert!(good_form < 2.0 && good_roundness < 1.0, "sense {sense}: {good_form} um, {good_roundness} um");
            assert!(form < 5.0, "sense {sense}: {form} um");
        }
    }

    /// Flats, corners and arcs of the shipped punches: ground within 0.1 µm on ideal drives without deflection, and within 2 µm with good
    /// drives.
    #[test]
    fn punches_of_lines_and_arcs_are_ground_to_their_outline() {
        let short = ["infeed.total_mm=0.072", "stock_mm=0.06"].map(str::to_owned);
        let prepared = prepare("punches", &short, None).unwrap();
        let worst = |description: &MachineDescription| {
            let (_, lobes, _) = simulate_outlines_on(&prepared, description, |_, _| {}).unwrap();
            lobes.iter().map(|lobe| um_from_mm(mm_from_m(lobe.form_error_max.abs()))).fold(0.0, f64::max)
        };
        let ideal = Effect::ALL.into_iter().fold(prepared.machine.clone(), |machine, effect| machine.without(effect));
        let good = prepared.machine.clone().with_good_drives().expect("the machine file has them");
        let (ideal_um, good_um) = (worst(&ideal), worst(&good));
        assert!(ideal_um < 0.1 && good_um < 2.0, "{ideal_um} um, {good_um} um");
    }

    /// The shipped wide lobe: on ideal drives without deflection every section has its form within 0.1 µm and no plunge leaves a step; with good
    /// drives, deflection and all it stays within 2 µm, and its steps too.
    #[test]
    fn a_wide_lobe_is_ground_over_its_whole_width() {
        let short = ["infeed.total_mm=0.018", "roughing.0.infeed.total_mm=0.036", "stock_mm=0.04"].map(String::from);
        let prepared = prepare("wide_lobes", &short, None).unwrap();
        let worst = |description: &MachineDescription| {
            let (results, wide) = simulate_wide_lobes(&prepared, description).unwrap();
            eprintln!("{}", wide[0]);
            let names: Vec<&str> = wide[0].sections.iter().map(|(name, _)| name.as_str()).collect();
            assert_eq!(names, ["W-1", "W-1-2", "W-2", "W-2-3", "W-3"], "over the whole width");
            let of_sections =
                wide[0].sections.iter().map(|(_, error_mm)| um_from_mm(error_mm.abs())).fold(0.0, f64::max);
            let of_results = |name: &str| {
                let lobes = results.iter().filter(|result| result.name.starts_with(name));
                lobes.map(|result| um_from_mm(mm_from_m(result.form_error_max.abs()))).fold(0.0, f64::max)
            };
            assert!((of_sections - of_results("W")).abs() < 1e-9, "a result is the worst of what its plunge finished");
            let step = wide[0].step.as_ref().expect("three plunges");
            (of_sections.max(of_results("N")), um_from_mm(step.height_mm.abs()))
        };
        let ideal = Effect::ALL.into_iter().fold(prepared.machine.clone(), |machine, effect| machine.without(effect));
        let (form_um, step_um) = worst(&ideal);
        assert!(form_um < 0.1 && step_um < 0.05, "{form_um} um, step {step_um} um");
        let good = prepared.machine.clone().with_good_drives().expect("the machine file has them");
        let (form_um, step_um) = worst(&good);
        assert!(form_um < 2.0 && step_um < 2.0, "{form_um} um, step {step_um} um");
    }

    /// Wear alone: every plunge leaves what the wheel has lost until then, the steps are the differences, and the overlap keeps what the
    /// plunge with the larger wheel left.
    #[test]
    fn the_step_between_plunges_is_the_wear_between_them() {
        let set = ["machine=cam_grinder_with_dresser", "stock_mm=0.16"].map(String::from);
        let prepared = prepare("wide_lobes", &set, None).unwrap();
        let others = Effect::ALL.into_iter().filter(|effect| *effect != Effect::Wear);
        let worn = others.fold(prepared.machine.clone(), MachineDescription::without);
        let (_, wide) = simulate_wide_lobes(&prepared, &worn).unwrap();
        let wear_um: Vec<f64> = prepared.planned.lobes.iter().map(|lobe| um_from_mm(lobe.wear_mm)).collect();
        assert!(wear_um[0] > 0.02 && wear_um[2] > 2.0 * wear_um[0], "{wear_um:?}");
        let wanted_um = [wear_um[0], wear_um[0], wear_um[1], wear_um[1], wear_um[2]];
        for ((name, error_mm), wanted_um) in wide[0].sections.iter().zip(wanted_um) {
            let um = um_from_mm(*error_mm);
            assert!((um - wanted_um).abs() < 0.02, "{name}: {um} um, {wanted_um} um, {}", wide[0]);
        }
        let step = wide[0].step.as_ref().expect("three plunges");
        let mean_um = um_from_mm(step.mean_mm);
        assert!((mean_um - (wear_um[1] - wear_um[0])).abs() < 0.02, "{mean_um} um, {wear_um:?}");
    }

    /// A cam for a finger follower, its lift in degrees: the whole way from the job file to the ground part.
    #[test]
    fn the_cam_of_an_oscillating_roller_is_ground_within_a_micrometre() {
        let set = [
            "profiles.eccentric.base_radius_mm=16",
            "profiles.eccentric.follower={kind: oscillating_roller, radius_mm: 8.5, arm_mm: 42, pivot_mm: 48, side: behind}",
            "profiles.eccentric.lift={segments: [{law: dwell, angle_deg: 220}, \
             {law: 4-5-6-7, angle_deg: 70, rise_deg: 7}, {law: 4-5-6-7, angle_deg: 70, rise_deg: -7}]}",
            "infeed.total_mm=0.072",
            "stock_mm=0.06",
            "work_speed_rpm=30",
        ];
        let prepared = prepare("eccentric", &set.map(String::from), None).unwrap();
        let (_, lobes) = simulate_job(&prepared, &Effect::ALL, |_, _| {}).unwrap();
        let worst_um = um_from_mm(mm_from_m(lobes[0].form_error_max.abs()));
        assert!(worst_um < 1.0, "{worst_um} um");
    }

    /// A simulation whose infeed does not reach the size on the gauge is no part: it fails with the alarm of the machine.
    #[test]
    fn a_size_that_is_not_reached_is_a_failed_simulation() {
        let prepared = prepare("journal_size", &[], None).unwrap();
        let mut worn = prepared.machine.clone();
        worn.wheel.grinding_ratio = Some(0.8);
        let failed = simulate_job_on(&prepared, &worn, |_, _| {}).unwrap_err();
        assert_eq!((failed.alarm, failed.reason.as_str()), (Some(142), "alarm 142: size not reached"));
    }

    /// The error of a batch equals the predicted wear of its wheel, over a dress and with a wheel that is already worn.
    #[test]
    fn a_dressed_batch_is_off_by_the_wear_that_is_predicted() {
        let job = camwright_files::job_file::load("dressed_batch", &[]).unwrap();
        let machine = job.machine.description.clone();
        let mut wheel = camwright::machine::wheel_state::WheelNow::dressed(59.5);
        (wheel.wear_mm, wheel.lobes_since_dress) = (0.0002, 1);
        let now = camwright_files::convert::machine_now::MachineNow { description: machine, wheels: wheel.into() };
        let prepared = crate::plan(job, Some(&now)).unwrap();
        assert_eq!(prepared.planned.dresses.len(), 2, "{:?}", prepared.planned.dresses);
        let others: Vec<Effect> = Effect::ALL.into_iter().filter(|effect| *effect != Effect::Wear).collect();
        let (_, lobes) = simulate_job(&prepared, &others, |_, _| {}).unwrap();
        for (result, lobe) in lobes.iter().zip(&prepared.planned.lobes) {
            let (ground, reported) = (um_from_mm(mm_from_m(result.form_error_max)), um_from_mm(lobe.wear_mm));
            assert!(reported > 0.1 && reported <= 0.5, "{}: {reported} um", result.name);
            assert!((ground - reported).abs() < 0.02, "{}: {ground} um, predicted {reported} um", result.name);
        }
    }
}
