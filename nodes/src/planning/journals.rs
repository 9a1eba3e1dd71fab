//! Journals that run out: the raw part as it is put between the centres, and the second half of a job that corrects them.

use super::{PreparedJob, blame, lobes};
use crate::config::ConfigError;
use crate::config::job_file::Job;
use crate::convert::mm_from_m;
use crate::convert::plan::pages_from_plan;
use camwright::cycle::{Contact, PlannedCorrection, PlannedJob, decide_corrections, identify, plan_corrections};
use camwright::machine::description::MachineDescription;
use camwright::runout::identify::{Identified, Pushed};
use camwright::runout::journal::{Gauged, JournalCorrection};
use camwright_msgs::camwright_msgs::msg::{GaugeReading, LobeResult, PartLobe, PlanPage};
use thiserror::Error;

/// The second half of a job, decided and planned.
#[derive(Debug, Clone)]
pub struct PreparedCorrection {
    /// The contact of each journal, where it was measured.
    pub measured: Vec<Identified>,
    /// What was decided for each journal.
    pub decided: Vec<JournalCorrection>,
    /// Its plan.
    pub planned: PlannedCorrection,
    /// The plan as messages, the header first.
    pub pages: Vec<PlanPage>,
}

impl PreparedCorrection {
    /// Hash of the plan, 64 hexadecimal digits.
    #[must_use]
    pub fn plan_hash(&self) -> &str {
        self.pages.first().map_or("", |page| &page.plan_hash)
    }

    /// One sentence for each journal.
    #[must_use]
    pub fn told(&self, prepared: &PreparedJob) -> Vec<String> {
        let names = || prepared.planned.lobes.iter().map(|lobe| &lobe.design.name);
        let measured = names().zip(&self.measured).map(|(name, measured)| format!("lobe {name}: {measured}"));
        measured.chain(names().zip(&self.decided).map(|(name, decided)| format!("lobe {name}: {decided}"))).collect()
    }

    /// Writes into the results of a job what was corrected.
    pub fn add_to(&self, results: &mut [LobeResult]) {
        // N/mm and N/m differ as m and mm do, the other way round.
        let n_m = |n_mm: f64| mm_from_m(n_mm);
        for (result, measured) in results.iter_mut().zip(&self.measured) {
            let (km, kg, f0) = (measured.machine_n_mm, measured.grinding.grinding_n_mm, measured.grinding.threshold_n);
            result.machine_stiffness = n_m(km.value);
            result.machine_stiffness_uncertainty = n_m(km.uncertainty);
            result.grinding_stiffness = n_m(kg.value);
            result.grinding_stiffness_uncertainty = n_m(kg.uncertainty);
            (result.threshold_force, result.threshold_force_uncertainty) = (f0.value, f0.uncertainty);
            let ratio = measured.comparison.by_decay;
            (result.stiffness_ratio, result.stiffness_ratio_uncertainty) = (ratio.value, ratio.uncertainty);
        }
        for (result, decided) in results.iter_mut().zip(&self.decided) {
            result.runout_before = crate::convert::m_from_mm(decided.before_mm);
            result.turns += f64::from(decided.turns);
            // As round as it is now by sparking out alone.
            result.spark_out_turns = decided.spark_out_turns_to(mm_from_m(result.runout)).unwrap_or_default();
        }
    }
}

/// Why a job could not be corrected.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("the runout cannot be corrected: {0}")]
pub struct CorrectionFailed(String);

/// A reading as the correction takes it.
#[must_use]
pub fn gauged(reading: &GaugeReading) -> Gauged {
    Gauged {
        tick: reading.tick,
        c_rad: reading.spindle_angle,
        x_mm: mm_from_m(reading.wheel_position),
        value_mm: mm_from_m(reading.reading),
        motor_n: reading.wheel_force,
    }
}

/// A tick of a push as the identification takes it.
#[must_use]
pub fn pushed(reading: &GaugeReading) -> Pushed {
    gauged(reading).into()
}

/// The second half of a job from what was read of each of its lobes in the first.
///
/// # Errors
/// Readings that do not tell the part, a part that cannot be corrected, a plan that cannot be made.
pub fn correct(prepared: &PreparedJob, logs: &[Contact]) -> Result<PreparedCorrection, CorrectionFailed> {
    let (job, machine, first) = (&prepared.job.spec, &prepared.machine, &prepared.planned);
    let measured = match job.identification {
        Some(_) => identify(job, machine, first, logs).map_err(|error| CorrectionFailed(error.to_string()))?,
        None => Vec::new(),
    };
    let decided = decide_corrections(job, machine, first, logs, &measured)
        .map_err(|error| CorrectionFailed(error.to_string()))?;
    let planned =
        plan_corrections(job, machine, first, &decided).map_err(|error| CorrectionFailed(error.to_string()))?;
    let pages = pages_from_plan(&planned.plan, &prepared.provenance);
    Ok(PreparedCorrection { measured, decided, planned, pages })
}

/// The second half as it is expected before anything is known: turns of journals without runout, for its time and its room.
pub(super) fn expected(
    job: &Job,
    machine: &MachineDescription,
    first: &PlannedJob,
) -> Result<Option<PlannedCorrection>, ConfigError> {
    let Some(correction) = &job.spec.correction else { return Ok(None) };
    let expected = first.lobes.iter().filter_map(|lobe| {
        let z_mm = machine.station(&lobe.design.station)?.position_mm;
        let law = machine.contact.as_ref()?.law(z_mm, lobe.design.width_mm)?;
        Some(JournalCorrection::expected(correction.mode, lobe.design.contour.radius_at(0.0), law))
    });
    let planned = plan_corrections(&job.spec, machine, first, &expected.collect::<Vec<_>>());
    planned.map(Some).map_err(|error| blame(job, &error))
}

/// A lobe of the raw part: its design, its stock, and what is off about it.
#[must_use]
pub fn raw_lobe(prepared: &PreparedJob, index: usize) -> PartLobe {
    let (job, design) = (&prepared.job.spec, &prepared.planned.lobes[index].design);
    let z_mm = prepared.machine.station(&design.station).map_or(0.0, |station| station.position_mm);
    let key_way_rad = job.raw_part.clamped_at_rad;
    lobes::blank(design, job.stock_mm, key_way_rad, |azimuth_rad| job.raw_part.above_mm(azimuth_rad, z_mm))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::{prepare, rehearse_job};
    use camwright::machine::description::Effect;
    use camwright::units::um_from_mm;

    /// The shipped journals, rehearsed as a whole: rounder and nearer to size than sparking out leaves them.
    #[test]
    fn the_shipped_journals_come_out_round_and_to_size() {
        let prepared = prepare("journal_runout", &[], None).unwrap();
        let (_, results) = rehearse_job(&prepared, &[], |_, _| {}).unwrap();
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
        let (_, results) = rehearse_job(&prepared, &ideal, |_, _| {}).unwrap();
        assert!(results.iter().all(|result| um_from_mm(mm_from_m(result.runout)) < 1.5));
    }

    #[test]
    fn readings_that_are_missing_are_told() {
        let prepared = prepare("journal_runout", &[], None).unwrap();
        let none = vec![Contact::default(); prepared.planned.lobes.len()];
        let error = correct(&prepared, &none).unwrap_err().to_string();
        assert!(error.contains("lobe J1") && error.contains("readings"), "{error}");
    }
}
