// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Dry runs: a job's whole way with the wheel farther out, of which nothing is measured.

use super::{MeasuredContacts, PreparedCorrection, PreparedJob};
use camwright_files::convert::plan::pages_from_plan;

impl PreparedJob {
    /// Stand-off of the wheel in a dry run (mm).
    #[must_use]
    pub fn dry_run_mm(&self) -> Option<f64> {
        self.job.spec.dry_run_mm
    }

    /// Second half of a dry run: the gauge measures nothing, so it uses the expected correction.
    #[must_use]
    pub fn dry_correction(&self) -> Option<PreparedCorrection> {
        let planned = self.expected_correction.clone().filter(|_| self.dry_run_mm().is_some())?;
        let pages = pages_from_plan(&planned.plan, &self.provenance);
        Some(PreparedCorrection { measured: MeasuredContacts::default(), decided: Vec::new(), planned, pages })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{prepare, raw_part, simulate_job, simulate_outlines_on};
    use camwright::machine::description::Effect;
    use camwright::math::units::um_from_mm;
    use camwright_files::convert::mm_from_m;

    /// Both halves of a job that corrects runout, and a job that dresses its wheel: every plan passes its check, and nothing is cut.
    #[test]
    fn a_dry_run_of_every_kind_of_job_cuts_nothing_and_dresses_nothing() {
        for (job, extra) in [("journal_runout", "identification={}"), ("dressed_batch", "dressing.every_lobes=2")] {
            let set = ["dry_run.stand_off_mm=5".to_owned(), extra.to_owned()];
            let prepared = prepare(job, &set, None).unwrap_or_else(|error| panic!("{error}"));
            let (_, _, outlines) = simulate_outlines_on(&prepared, &prepared.machine, |_, _| {}).unwrap();
            for (index, (outline, raw)) in outlines.iter().zip(raw_part(&prepared)).enumerate() {
                let raw: Vec<f64> = raw.radius.iter().map(|radius| mm_from_m(*radius)).collect();
                assert_eq!(*outline, raw, "{job}, lobe {index}");
            }
        }
    }

    /// A part that is clamped 3 degrees askew comes out right only where the plan knows of it.
    #[test]
    fn a_part_that_is_clamped_askew_is_ground_right_where_its_phase_is_known() {
        let worst_um = |set: &[&str]| {
            let short = ["infeed.total_mm=0.576", "stock_mm=0.5", "raw_part.clamped_at_deg=3"];
            let set: Vec<String> = short.iter().chain(set).map(|set| (*set).to_owned()).collect();
            let prepared = prepare("eccentric", &set, None).unwrap_or_else(|error| panic!("{error}"));
            let (_, lobes) = simulate_job(&prepared, &Effect::ALL, |_, _| {}).unwrap();
            um_from_mm(mm_from_m(lobes[0].form_error_max.abs()))
        };
        let (known, unknown) = (worst_um(&["part_phase_deg=3"]), worst_um(&[]));
        assert!(known < 1.0 && unknown > 100.0, "{known} um, {unknown} um where it is not known");
    }
}
