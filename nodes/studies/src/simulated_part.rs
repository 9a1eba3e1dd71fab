// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A planned job on the simulated machine, without ROS: the part and its results.

use camwright::cam::form::Form;
use camwright::math::units::{deg_from_rad, um_from_mm};
use camwright::planner::PlannedLobe;
use camwright::simulation::closed_loop::Simulated;
use camwright::simulation::tick_report::TickReport;
use camwright::simulation::turned_part::FormMap;
use camwright_files::convert::um_from_m;
use camwright_files::study_file::StudyResponse;
use camwright_msgs::camwright_msgs::msg::LobeResult;
use camwright_planning::{self as planning, AnyPrepared, NumberTable, PreparedJob, PreparedTurning, SimulationFailed};
use std::fmt::Display;

/// Part that the simulated machine made.
#[derive(Debug, Clone)]
pub struct SimulatedPart {
    /// Results in the order of [`StudyResponse::ALL`]; none where the job has no such result.
    pub responses: [Option<f64>; StudyResponse::ALL.len()],
    /// Lobe with the largest form error.
    pub worst_lobe: Option<String>,
    pub form: SimulatedForm,
}

impl SimulatedPart {
    fn new(worst_lobe: Option<String>, form: SimulatedForm) -> Self {
        Self { responses: [None; StudyResponse::ALL.len()], worst_lobe, form }
    }

    /// Ground lobes in the order of machining; none of a turned part.
    #[must_use]
    pub fn lobes(&self) -> &[SimulatedLobe] {
        match &self.form {
            SimulatedForm::Lobes(lobes) => lobes,
            SimulatedForm::Surface(_) => &[],
        }
    }

    /// Form error of a lobe over the azimuth of the part, or that of a turned surface, all azimuths of its first position along z first.
    /// Returns none for a lobe that the part does not have, and for a part with lobes where none is named.
    #[must_use]
    pub fn form_table(&self, lobe: Option<&str>) -> Option<NumberTable> {
        match (&self.form, lobe) {
            (SimulatedForm::Lobes(lobes), Some(name)) => {
                let deviations_mm = &lobes.iter().find(|lobe| lobe.result.name == name)?.form.deviations_mm;
                let count = deviations_mm.len();
                let rows = deviations_mm.iter().enumerate();
                let rows = rows.map(|(index, deviation_mm)| [azimuth_deg(index, count), um_from_mm(*deviation_mm)]);
                Some(NumberTable::from_rows([("azimuth_deg", "deg"), ("form_error_um", "um")], rows))
            }
            (SimulatedForm::Surface(map), None) => {
                let count = map.azimuths();
                let rows = map.deviations_mm().iter().enumerate().map(|(index, deviation_mm)| {
                    let z_mm = map.places_mm()[index / count];
                    [z_mm, azimuth_deg(index % count, count), um_from_mm(*deviation_mm)]
                });
                Some(NumberTable::from_rows([("z_mm", "mm"), ("azimuth_deg", "deg"), ("form_error_um", "um")], rows))
            }
            _ => None,
        }
    }

    fn set(&mut self, response: StudyResponse, value: Option<f64>) {
        self.responses[response.index()] = value.filter(|value| value.is_finite());
    }
}

/// Form of a part.
#[derive(Debug, Clone)]
pub enum SimulatedForm {
    /// Ground lobes in the order of machining.
    Lobes(Vec<SimulatedLobe>),
    /// Turned surface.
    Surface(FormMap),
}

/// A ground lobe.
#[derive(Debug, Clone)]
pub struct SimulatedLobe {
    pub result: LobeResult,
    pub form: Form,
}

impl SimulatedLobe {
    /// Results by name, with the unit at its end.
    #[must_use]
    pub fn results(&self) -> [(&'static str, f64); 7] {
        let lobe = &self.result;
        [
            ("form_error_max_um", um_from_m(lobe.form_error_max)),
            ("form_error_max_cam_angle_deg", deg_from_rad(lobe.form_error_max_angle)),
            ("form_error_rms_um", um_from_m(lobe.form_error_rms)),
            ("lift_error_pv_um", um_from_m(lobe.lift_error)),
            ("waviness_um", um_from_mm(self.form.waviness_mm())),
            ("power_max_w", lobe.power_max),
            ("burn_index", lobe.burn_index_max),
        ]
    }
}

/// One rounding, so that 0.3 is written as 0.3.
fn azimuth_deg(index: usize, count: usize) -> f64 {
    index as f64 * 360.0 / count as f64
}

/// Makes the part of a planned job on its machine and measures it.
///
/// # Errors
/// An alarm of the machine; a part that cannot be measured.
pub fn simulate_part(prepared: &AnyPrepared) -> Result<SimulatedPart, SimulationFailed> {
    match prepared {
        AnyPrepared::Ground(prepared) => ground(prepared),
        AnyPrepared::Turned(prepared) => turned(prepared),
    }
}

fn time_s(simulated: &Simulated, cycle_time_s: f64) -> f64 {
    (simulated.last_tick + 1 - simulated.first_tick) as f64 * cycle_time_s
}

fn largest(values: impl Iterator<Item = f64>) -> Option<f64> {
    values.filter(|value| value.is_finite()).max_by(f64::total_cmp)
}

fn not_measured(job: &str, error: &dyn Display) -> SimulationFailed {
    SimulationFailed { job: job.to_owned(), reason: error.to_string(), alarm: None }
}

fn ground(prepared: &PreparedJob) -> Result<SimulatedPart, SimulationFailed> {
    let mut warnings = 0_usize;
    let count = |report: &TickReport| report.raised.iter().count();
    let simulated = planning::simulate_outlines_on(prepared, &prepared.machine, |_, report| warnings += count(report));
    let (simulated, results, outlines_mm) = simulated?;
    let lobes = prepared.finished_lobes().zip(&outlines_mm).zip(results).map(|(((_, lobe), radii_mm), result)| {
        let phase_rad = lobe.design.phase_on_rad(prepared.job.spec.raw_part.clamped_at_rad);
        let form = Form::measure(radii_mm, &lobe.design.contour, phase_rad);
        let form = form.map_err(|error| not_measured(&prepared.job.spec.name, &error))?;
        Ok(SimulatedLobe { result, form })
    });
    let lobes = lobes.collect::<Result<Vec<_>, SimulationFailed>>()?;
    let of_all = |value: &dyn Fn(&SimulatedLobe) -> f64| largest(lobes.iter().map(value));
    let has_length = |lobe: &PlannedLobe| lobe.design.contour.follower().lift_is_length();
    let has_lift = prepared.planned.lobes.iter().any(has_length);
    let has_process = prepared.machine.process.is_some();
    let error_m = |lobe: &SimulatedLobe| lobe.result.form_error_max.abs();
    let worst = lobes.iter().max_by(|a, b| error_m(a).total_cmp(&error_m(b)));
    let mut part = SimulatedPart::new(worst.map(|lobe| lobe.result.name.clone()), SimulatedForm::Lobes(Vec::new()));
    part.set(StudyResponse::FormErrorMaxUm, of_all(&|lobe| um_from_m(error_m(lobe))));
    let lift = of_all(&|lobe| um_from_m(lobe.result.lift_error));
    part.set(StudyResponse::LiftErrorPvUm, lift.filter(|_| has_lift));
    part.set(StudyResponse::WavinessUm, of_all(&|lobe| um_from_mm(lobe.form.waviness_mm())));
    part.set(StudyResponse::JobTimeS, Some(time_s(&simulated, prepared.machine.cycle_time_s())));
    let power = of_all(&|lobe| lobe.result.power_max);
    part.set(StudyResponse::PowerMaxW, power.filter(|_| has_process));
    let burn = of_all(&|lobe| lobe.result.burn_index_max);
    part.set(StudyResponse::BurnIndex, burn.filter(|_| has_process));
    part.set(StudyResponse::Alarms, Some(warnings as f64));
    part.form = SimulatedForm::Lobes(lobes);
    Ok(part)
}

fn turned(prepared: &PreparedTurning) -> Result<SimulatedPart, SimulationFailed> {
    let (simulated, turned) = planning::simulate_turned(prepared, &[])?;
    let form = planning::turned_form(prepared, &turned);
    let form = form.map_err(|error| not_measured(&prepared.job.spec.name, &error))?;
    let result = planning::turned_result(prepared, &form);
    let mut part = SimulatedPart::new(None, SimulatedForm::Surface(form));
    part.set(StudyResponse::FormErrorMaxUm, Some(um_from_m(result.form_error_max.abs())));
    part.set(StudyResponse::JobTimeS, Some(time_s(&simulated, prepared.machine.cycle_time_s())));
    Ok(part)
}
