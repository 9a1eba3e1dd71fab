// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Journals that run out: the raw part as it is put between the centres, what is measured of it before and while it is ground, and the
//! half of a job that corrects it.

use super::{PreparedJob, error_location::blame, finishing::FORCE_KEY, lobes};
use camwright::gauging::identify::Identified;
use camwright::gauging::journal::{JournalCorrection, JournalError};
use camwright::machine::description::MachineDescription;
use camwright::machine::wheel_state::WheelNow;
use camwright::math::units::um_from_mm;
use camwright::planner::{
    JournalReadings, MeasuredJob, PlannedCorrection, PlannedJob, PlannedMeasuring, UncorrectedJournal,
    decide_corrections, identify, measured_stocks, plan_corrections, plan_measured_job, plan_measuring,
};
use camwright_files::ConfigError;
use camwright_files::convert::plan::{Provenance, pages_from_plan};
use camwright_files::convert::{m_from_mm, mm_from_m};
use camwright_files::job_file::Job;
use camwright_msgs::camwright_msgs::msg::{LobeResult, PartLobe, PlanPage};
use thiserror::Error;

/// Measured contact of each journal of a job, and the reasons for journals without a result.
#[derive(Debug, Clone, Default)]
pub struct MeasuredContacts {
    /// In the order of machining; nothing of a journal whose cut was held, or of a job that does not measure.
    pub contacts: Vec<Option<Identified>>,
    /// One sentence for each journal that was held.
    pub held: Vec<String>,
}

impl MeasuredContacts {
    /// One sentence for each journal.
    #[must_use]
    pub fn summary_lines(&self, prepared: &PreparedJob) -> Vec<String> {
        let names = prepared.planned.lobes.iter().map(|lobe| &lobe.design.name);
        let measured = names.zip(&self.contacts).filter_map(|(name, contact)| Some((name, contact.as_ref()?)));
        measured.map(|(name, contact)| format!("lobe {name}: {contact}")).chain(self.held.iter().cloned()).collect()
    }

    /// Writes into the results of a job what was measured.
    pub fn add_to(&self, results: &mut [LobeResult]) {
        // N/mm and N/m differ as m and mm do, the other way round.
        let n_m = |n_mm: f64| mm_from_m(n_mm);
        for (result, measured) in results.iter_mut().zip(&self.contacts) {
            let Some(measured) = measured else { continue };
            let (km, kg, f0) = (measured.machine_n_mm, measured.grinding.grinding_n_mm, measured.grinding.threshold_n);
            result.machine_stiffness = n_m(km.value);
            result.machine_stiffness_uncertainty = n_m(km.uncertainty);
            result.grinding_stiffness = n_m(kg.value);
            result.grinding_stiffness_uncertainty = n_m(kg.uncertainty);
            (result.threshold_force, result.threshold_force_uncertainty) = (f0.value, f0.uncertainty);
            let ratio = measured.comparison.by_decay;
            (result.stiffness_ratio, result.stiffness_ratio_uncertainty) = (ratio.value, ratio.uncertainty);
        }
    }
}

/// The second half of a job, decided and planned.
#[derive(Debug, Clone)]
pub struct PreparedCorrection {
    /// The contact of each journal, where it was measured.
    pub measured: MeasuredContacts,
    /// Decision for each journal.
    pub decided: Vec<JournalCorrection>,
    pub planned: PlannedCorrection,
    /// The plan as messages, the header first.
    pub pages: Vec<PlanPage>,
}

impl PreparedCorrection {
    /// Hash of the plan, 64 hexadecimal digits.
    #[must_use]
    pub fn plan_hash(&self) -> &str {
        hash_of(&self.pages)
    }

    /// Some sentences for each journal: what was measured, and by what it is corrected and how.
    #[must_use]
    pub fn summary_lines(&self, prepared: &PreparedJob) -> Vec<String> {
        let mut lines = self.measured.summary_lines(prepared);
        for (index, (lobe, decided)) in prepared.planned.lobes.iter().zip(&self.decided).enumerate() {
            let name = &lobe.design.name;
            let measured = self.measured.contacts.get(index).and_then(Option::as_ref).map(|contact| contact.law);
            if let Some((law, from)) = lobe.contact(&prepared.job.spec, &prepared.machine, measured) {
                // N/mm and N/um differ as um and mm do.
                let n_um = |n_mm: f64| camwright::math::units::mm_from_um(n_mm);
                lines.push(format!(
                    "lobe {name}: corrected by the stiffness {from}: machine {:.3} N/um, grinding {:.2} N/um, {:.1} N to begin",
                    n_um(law.machine_n_mm()),
                    n_um(law.grinding_n_mm()),
                    law.threshold_n()
                ));
            }
            lines.push(format!("lobe {name}: {decided}"));
        }
        lines
    }

    /// Writes into the results of a job what was corrected.
    pub fn add_to(&self, results: &mut [LobeResult]) {
        self.measured.add_to(results);
        for (result, decided) in results.iter_mut().zip(&self.decided) {
            result.runout_before = m_from_mm(decided.before_mm);
            if let Some(expected) = &decided.expected {
                result.runout_expected = m_from_mm(expected.median_mm);
                result.runout_limit = m_from_mm(expected.limit_mm);
            }
            result.turns += f64::from(decided.turns);
            // As round as it is now by sparking out alone.
            result.spark_out_turns = decided.spark_out_turns_to(mm_from_m(result.runout)).unwrap_or(f64::NAN);
        }
    }
}

/// Hash of the plan that pages carry, 64 hexadecimal digits.
#[must_use]
pub fn hash_of(pages: &[PlanPage]) -> &str {
    pages.first().map_or("", |page| &page.plan_hash)
}

/// Why a job could not go on with what was measured in it.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{what}: {reason}")]
pub struct CorrectionFailed {
    what: &'static str,
    reason: String,
}

impl CorrectionFailed {
    fn new(what: &'static str, reason: &impl ToString) -> Self {
        Self { what, reason: reason.to_string() }
    }
}

/// Derives the stiffness of machine and cut from the log of each lobe, if the job measures it.
///
/// # Errors
/// The readings give no stiffness.
pub fn measured_contacts(
    prepared: &PreparedJob,
    logs: &[JournalReadings],
) -> Result<MeasuredContacts, CorrectionFailed> {
    let (job, machine, first) = (&prepared.job.spec, &prepared.machine, &prepared.planned);
    let mut measured = MeasuredContacts::default();
    if job.identification.is_none() {
        return Ok(measured);
    }
    for contact in identify(job, machine, first, logs) {
        match contact {
            Ok(contact) => measured.contacts.push(Some(contact)),
            // Holding is the operator's right, and the stiffness is known from elsewhere.
            Err(held @ UncorrectedJournal { source: JournalError::Held { .. }, .. }) => {
                measured.contacts.push(None);
                measured.held.push(format!("the stiffness is not measured: {held}"));
            }
            Err(error) => return Err(CorrectionFailed::new("the stiffness cannot be measured", &error)),
        }
    }
    Ok(measured)
}

/// The second half of a job from what was read of each of its lobes in the first.
///
/// # Errors
/// The readings do not determine the part, the part cannot be corrected, or the plan cannot be made.
pub fn correct(prepared: &PreparedJob, logs: &[JournalReadings]) -> Result<PreparedCorrection, CorrectionFailed> {
    let failed = |reason: &dyn ToString| CorrectionFailed::new("the runout cannot be corrected", &reason.to_string());
    let (job, machine, first) = (&prepared.job.spec, &prepared.machine, &prepared.planned);
    let measured = measured_contacts(prepared, logs)?;
    let decided = decide_corrections(job, machine, first, logs, &measured.contacts).map_err(|error| failed(&error))?;
    let planned = plan_corrections(job, machine, first, &decided).map_err(|error| failed(&error))?;
    let pages = pages_from_plan(&planned.plan, &prepared.provenance);
    Ok(PreparedCorrection { measured, decided, planned, pages })
}

/// The second half as it is expected before anything is known: turns of journals without runout, for its time and its room.
pub(super) fn expected(
    job: &Job,
    machine: &MachineDescription,
    first: &PlannedJob,
) -> Result<Option<PlannedCorrection>, ConfigError> {
    let Some(correction) = job.spec.is_corrected() else { return Ok(None) };
    let mut expected = Vec::new();
    for lobe in &first.lobes {
        let Some((law, from)) = lobe.contact(&job.spec, machine, None) else { continue };
        let finishing = correction.finishing.map(|finishing| finishing.turns(&law)).transpose();
        let finishing = finishing.map_err(|error| {
            let message = format!("lobe {}, by the stiffness {from}: {error}", lobe.design.name);
            job.document.error(FORCE_KEY, message)
        })?;
        let radius_mm = lobe.design.contour.radius_at(0.0);
        expected.push(JournalCorrection::expected(correction.mode, radius_mm, law, finishing));
    }
    let planned = plan_corrections(&job.spec, machine, first, &expected);
    planned.map(Some).map_err(|error| blame(job, &error))
}

/// The plan that measures the stock of a job before anything is cut.
#[derive(Debug, Clone)]
pub struct PreparedMeasuring {
    /// Plan of the measurement.
    pub planned: PlannedMeasuring,
    /// The job as it would be ground without.
    pub whole: PlannedJob,
    /// The plan as messages, the header first.
    pub pages: Vec<PlanPage>,
}

impl PreparedMeasuring {
    /// Hash of the plan, 64 hexadecimal digits.
    #[must_use]
    pub fn plan_hash(&self) -> &str {
        hash_of(&self.pages)
    }
}

/// Plans how the stock of a job is measured, and what is ground then if it is as large as the job says.
pub(super) fn measuring(
    job: &Job,
    machine: &MachineDescription,
    wheel: WheelNow,
    whole: PlannedJob,
    provenance: &Provenance,
) -> Result<(PlannedJob, Option<PreparedMeasuring>), ConfigError> {
    // The wheel of a dry run takes nothing, however much there is.
    if job.spec.measure_stock.is_none() || job.spec.dry_run_mm.is_some() {
        return Ok((whole, None));
    }
    let planned = plan_measuring(&job.spec, machine, wheel, &whole.lobes, None).map_err(|error| blame(job, &error))?;
    let stocks_mm = vec![job.spec.stock_mm; whole.lobes.len()];
    let expected = plan_measured_job(&job.spec, machine, wheel, &whole, &planned, &stocks_mm);
    let expected = expected.map_err(|error| blame(job, &error))?.planned;
    let pages = pages_from_plan(&planned.plan, provenance);
    Ok((expected, Some(PreparedMeasuring { planned, whole, pages })))
}

/// Job planned anew for the measured stock, with a report.
#[derive(Debug, Clone)]
pub struct PreparedForStock {
    /// The job, which goes on with its plan from here.
    pub prepared: PreparedJob,
    /// A sentence for each journal.
    pub lines: Vec<String>,
    /// Saved time, as a text.
    pub saved: String,
}

/// The job as it goes on after its stock was measured.
///
/// # Errors
/// The readings give no stock, or the stock exceeds that of the job.
pub fn for_stock(prepared: &PreparedJob, logs: &[JournalReadings]) -> Result<PreparedForStock, CorrectionFailed> {
    let failed = |reason: &dyn ToString| CorrectionFailed::new("the part is not ground", &reason.to_string());
    let Some(measuring) = &prepared.measuring else {
        return Ok(PreparedForStock { prepared: prepared.clone(), lines: Vec::new(), saved: String::new() });
    };
    let (job, machine) = (&prepared.job.spec, &prepared.machine);
    let stocks_mm =
        measured_stocks(machine, &measuring.planned, &measuring.whole.lobes, logs).map_err(|error| failed(&error))?;
    let MeasuredJob { planned, skipped, saved_s } =
        plan_measured_job(job, machine, prepared.wheels.mounted, &measuring.whole, &measuring.planned, &stocks_mm)
            .map_err(|error| failed(&error))?;
    let lines = skipped.iter().map(ToString::to_string).collect();
    let saved = format!(
        "skipped turns in the air save {saved_s:.2} s; measuring the stock took {:.2} s, with a margin of {:.1} um for errors that two opposed contacts cannot see",
        measuring.planned.measuring_s,
        job.measure_stock.map_or(0.0, |stock| um_from_mm(stock.margin_mm))
    );
    let pages = pages_from_plan(&planned.plan, &prepared.provenance);
    let expected_correction = expected(&prepared.job, machine, &planned).map_err(|error| failed(&error))?;
    let prepared = PreparedJob { planned, pages, expected_correction, ..prepared.clone() };
    Ok(PreparedForStock { prepared, lines, saved })
}

/// The raw part as the machine takes it: its lobes in the order of machining, a wide lobe as its sections. Each has the stock of the job
/// and what is off about the part where it stands.
pub fn raw_part(prepared: &PreparedJob) -> impl Iterator<Item = PartLobe> + '_ {
    let job = &prepared.job.spec;
    let key_way_rad = job.raw_part.clamped_at_rad;
    // The section that has the name of a plunge stands at the index of the plunge.
    let designs = || prepared.planned.lobes.iter().map(|lobe| &lobe.design);
    let first = designs().filter_map(|design| Some((design, design.sections().into_iter().next()?)));
    let further =
        designs().flat_map(|design| design.sections().into_iter().skip(1).map(move |section| (design, section)));
    first.chain(further).map(move |(design, section)| {
        let station_mm = prepared.machine.station(&design.station).map_or(0.0, |station| station.position_mm);
        let z_mm = station_mm + section.offset_mm;
        let above_mm = |azimuth_rad: f64| job.raw_part.above_mm(azimuth_rad, z_mm);
        let part_mm_n = design.part_compliance_mm_n(&prepared.machine, section.offset_mm);
        lobes::blank(design, &section, (job.stock_mm, part_mm_n), key_way_rad, above_mm)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{prepare, simulate_job};
    use camwright::machine::description::Effect;
    use camwright::math::units::um_from_mm;

    /// The shipped journals, simulated as a whole: rounder and nearer to size than sparking out leaves them.
    #[test]
    fn the_shipped_journals_come_out_round_and_to_size() {
        let prepared = prepare("journal_runout", &[], None).unwrap();
        let (_, results) = simulate_job(&prepared, &[], |_, _| {}).unwrap();
        for result in &results {
            let [before, after, form] =
                [result.runout_before, result.runout, result.form_error_max.abs()].map(|m| um_from_mm(mm_from_m(m)));
            eprintln!(
                "{}: {before} um, {after} um left, form {form} um, {} turns",
                result.name, result.spark_out_turns
            );
            assert!(before > 5.0 && after < 1.5, "{}: {before} um, {after} um left", result.name);
            assert!(form < 3.0, "{}: {form} um off", result.name);
            assert!(result.spark_out_turns > 5.0, "{}: {} turns", result.name, result.spark_out_turns);
        }
        let ideal = [Effect::Servo];
        let (_, results) = simulate_job(&prepared, &ideal, |_, _| {}).unwrap();
        assert!(results.iter().all(|result| um_from_mm(mm_from_m(result.runout)) < 1.5));
    }

    /// The shipped journals with 30 um less on them than their job says: turns are omitted, and they come out as good. With 60 um more
    /// nothing is ground.
    #[test]
    fn stock_is_measured_and_turns_are_left_out() {
        let job = |unknown_um: i32| {
            let set = [format!("raw_part.unknown_um={unknown_um}.0"), "measure_stock.margin_um=60.0".to_owned()];
            prepare("journal_runout", &set, None).unwrap()
        };
        let less = job(-30);
        let mut reported_lines = Vec::new();
        let (_, results) =
            crate::simulate::simulate_with_report(&less, &less.machine, |lines| reported_lines.push(lines)).unwrap();
        eprintln!("{reported_lines:#?}");
        assert!(
            reported_lines[0].starts_with("lobe J1: 9") && reported_lines[0].contains("2 turns with infeed"),
            "{}",
            reported_lines[0]
        );
        for result in &results {
            let [after, form] = [result.runout, result.form_error_max.abs()].map(|m| um_from_mm(mm_from_m(m)));
            // A part with less to grind runs out more before the turn that corrects it.
            assert!(after < 2.0 && form < 3.0, "{}: {after} um left, form {form} um", result.name);
        }
        let error = simulate_job(&job(60), &[], |_, _| {}).unwrap_err().to_string();
        assert!(error.contains("lobe J1: the gauge finds 0.18") && error.contains("are the most"), "{error}");
    }

    #[test]
    fn missing_readings_are_reported() {
        let prepared = prepare("journal_runout", &[], None).unwrap();
        let none = vec![JournalReadings::default(); prepared.planned.lobes.len()];
        let error = correct(&prepared, &none).unwrap_err().to_string();
        assert!(error.contains("lobe J1") && error.contains("readings"), "{error}");
    }
}
