// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Every fault at many moments of a job: `cargo run --release -p camwright_nodes --example fault_campaign [JOB [MOMENTS [SEED]]]`.
//!
//! Strikes copies of the cell (interpolator, stream and machine as one value) in the middle of the job (`four_lobe_camshaft`, 20 moments)
//! and prints for each fault its alarms, the deepest cut below the design, and the bound computed for it from the axes alone; see
//! `camwright::simulation::fault_campaign`. Exits with 1 where a fault did not end at rest, with an alarm, off the part, within its bound.
#![allow(clippy::print_stdout, reason = "a command")]

use camwright::interpolator::{Motion, Prepared};
use camwright::machine::description::{GaugeDescription, GaugeKind, MachineDescription};
use camwright::machine::persistent_state::PersistentState;
use camwright::math::units::um_from_mm;
use camwright::planner::LobeDesign;
use camwright::simulation::Machine;
use camwright::simulation::closed_loop::ClosedLoop;
use camwright::simulation::fault::Fault;
use camwright::simulation::fault_campaign::{Campaign, CaseResult, FaultCase, every_fault, seeded_moments};
use camwright_files::convert::plan::plan_from_pages;
use camwright_files::convert::{centre_from_values, compliance_from_values, mm_from_m, offset_from_values};
use camwright_planning::{PreparedJob, prepare, raw_part};
use std::collections::{BTreeMap, BTreeSet};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

/// A gauge for machines without one, so that it can fail.
const GAUGE: GaugeDescription = GaugeDescription {
    kind: GaugeKind::Diameter,
    behind_wheel_rad: 2.0,
    second_behind_wheel_rad: None,
    resolution_mm: 1e-4,
    noise_mm: 2e-4,
    bandwidth_rad_s: None,
    seed: 1,
};

/// Result of one fault.
#[derive(Default)]
struct Row {
    found: Vec<CaseResult>,
    failures: Vec<String>,
}

fn cell(prepared: &PreparedJob, description: &MachineDescription) -> Result<ClosedLoop, Box<dyn std::error::Error>> {
    let lasting = PersistentState::new(description).with_wheels(&prepared.wheels);
    let mut machine = Machine::new(description.clone(), lasting)?;
    for raw in raw_part(prepared) {
        let radii = raw.radius.iter().map(|radius| mm_from_m(*radius)).collect();
        let outline = (offset_from_values(&raw.centre), mm_from_m(raw.width), radii);
        machine.load_section(&raw.name, &raw.station, outline, centre_from_values(&raw.centre))?;
        machine.set_part_compliance(&raw.name, compliance_from_values(&raw.centre))?;
    }
    Ok(ClosedLoop::new(machine))
}

fn main() -> Result<ExitCode, Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let job = words.next().unwrap_or_else(|| "four_lobe_camshaft".to_owned());
    let count: usize = words.next().map_or(Ok(20), |word| word.parse())?;
    let seed: u64 = words.next().map_or(Ok(4), |word| word.parse())?;
    let start = Instant::now();
    let prepared = prepare(&job, &[], None)?;
    let mut description = prepared.machine.clone();
    description.gauge.get_or_insert(GAUGE);
    let mut drained = description.clone();
    drained.retract.buffered_energy_j = 20.0;
    let (plan, _) = plan_from_pages(&prepared.pages, &description)?;
    let designs: Vec<&LobeDesign> = prepared.planned.lobes.iter().map(|lobe| &lobe.design).collect();
    let mut rows: BTreeMap<String, Row> = BTreeMap::new();
    let mut text = String::new();
    for (description, only) in [(&description, None), (&drained, Some("power loss"))] {
        let motion = Prepared::new(Motion::Plan(Arc::new(plan.clone())), description)?;
        let failed = |alarm: Option<camwright::machine::alarm::Alarm>| format!("the job without a fault: {alarm:?}");
        let cell = cell(&prepared, description)?;
        let (healthy, _) = Campaign::new(&plan, &designs, motion.clone(), cell.clone(), &[]).map_err(failed)?;
        let moments = seeded_moments(seed, count, healthy.struck_within());
        let (campaign, frames) = Campaign::new(&plan, &designs, motion, cell, &moments).map_err(failed)?;
        text = format!("deepest cut of the job without a fault {:.2} um", um_from_mm(campaign.healthy_mm));
        for frame in &frames {
            let is_meant =
                |case: &FaultCase| only.is_none_or(|name| case.fault == Fault::PowerLoss(true) && case.name == name);
            for case in every_fault(description, frame.station).into_iter().filter(is_meant) {
                let name = if only.is_some() { format!("{}, buffer of 20 J", case.name) } else { case.name.clone() };
                let row = rows.entry(name).or_default();
                match campaign.run_case(frame, &case) {
                    Ok(found) => row.found.push(found),
                    Err(failure) => row.failures.push(format!("tick {}: {failure}", frame.tick)),
                }
            }
        }
    }
    println!("{job}: every fault at {count} moments, seed {seed}; {text}");
    println!(
        "{:<28} {:>5}  {:<24} {:>9} {:>9} {:>9} {:>9}",
        "fault", "cases", "alarms", "rest ms", "cut um", "bound um", "margin"
    );
    let mut failures = 0;
    for (name, row) in &rows {
        let alarms: BTreeSet<u16> = row.found.iter().map(|found| found.alarm.kind.entry().number).collect();
        let alarms: Vec<String> = alarms.iter().map(ToString::to_string).collect();
        let rest = row.found.iter().map(|found| found.ticks.1).max().unwrap_or(0);
        let rest_ms = rest as f64 * description.cycle_time_s() * 1e3;
        // The case with the deepest cut, and how near any came to its bound.
        let deepest = row.found.iter().max_by(|a, b| a.deepest_mm.total_cmp(&b.deepest_mm));
        let (cut, bound) = deepest.map_or((0.0, 0.0), |found| (found.deepest_mm, found.bound_mm));
        let margin = row.found.iter().map(|found| found.bound_mm - found.deepest_mm).fold(f64::INFINITY, f64::min);
        println!(
            "{name:<28} {:>5}  {:<24} {rest_ms:>9.0} {:>9.2} {:>9.2} {:>9.2}",
            row.found.len() + row.failures.len(),
            alarms.join(" "),
            um_from_mm(cut),
            um_from_mm(bound),
            um_from_mm(margin),
        );
        for failure in &row.failures {
            println!("    {failure}");
        }
        failures += row.failures.len();
    }
    let cases: usize = rows.values().map(|row| row.found.len() + row.failures.len()).sum();
    println!("{cases} cases, {failures} failed; took {:.1} s", start.elapsed().as_secs_f64());
    println!("cut and bound of the case with the deepest cut; margin: the least between a cut and its bound");
    Ok(if failures == 0 { ExitCode::SUCCESS } else { ExitCode::from(1) })
}
