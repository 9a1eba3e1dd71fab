// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Cuts of two runs, one of them at least on real drives: the same setpoints of C and X, and Z at the same station.
//!
//! Edges of real switches, the ticks of a run and what its drives did differ in every run; they are not compared.

use camwright::interpolator::StepOutput;
use camwright::machine::description::{Axis, MachineDescription};
use camwright::math::units::um_from_mm;
use camwright::motion::plan::Phase;
use std::hash::{DefaultHasher, Hasher as _};

/// Setpoints of a cut.
#[derive(Debug, Clone)]
struct CutTrace {
    segment: usize,
    setpoints: u64,
    /// C and X, to the bit.
    digest: DefaultHasher,
    /// Z at the first and last setpoint (counts).
    z: [i64; 2],
}

/// Cuts of a plan that was executed.
#[derive(Debug, Clone)]
pub(super) struct JobCuts {
    plan: String,
    cuts: Vec<CutTrace>,
}

impl JobCuts {
    pub(super) fn of_plan(hash: &str) -> Self {
        Self { plan: hash.to_owned(), cuts: Vec::new() }
    }

    /// Adds a tick, if it is of a cut.
    pub(super) fn see(&mut self, out: &StepOutput) {
        if !matches!(out.status.phase, Some(Phase::Cut | Phase::SparkOut)) {
            return;
        }
        let (setpoint, segment) = (&out.setpoint, out.status.segment);
        let z = setpoint.counts[Axis::Z.index()];
        if self.cuts.last().is_none_or(|cut| cut.segment != segment) {
            self.cuts.push(CutTrace { segment, setpoints: 0, digest: DefaultHasher::new(), z: [z; 2] });
        }
        let Some(cut) = self.cuts.last_mut() else { return };
        cut.setpoints += 1;
        cut.z[1] = z;
        for axis in [Axis::C, Axis::X].map(Axis::index) {
            cut.digest.write_i64(setpoint.counts[axis]);
            cut.digest.write_u64(setpoint.velocity[axis].to_bits());
            cut.digest.write_u64(setpoint.acceleration[axis].to_bits());
        }
    }
}

/// Comparison of the cuts of two runs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CutComparison {
    jobs: usize,
    cuts: usize,
    /// Largest distance of Z, and the allowed one (um): that of a search in a servo period.
    z_um: (f64, f64),
    difference: Option<String>,
}

impl CutComparison {
    pub(super) fn new(ours: &[JobCuts], theirs: &[JobCuts], machine: &MachineDescription) -> Self {
        let z = machine.axis(Axis::Z);
        let allowed_um = um_from_mm(z.search_velocity * machine.cycle_time_s());
        let mut compared = Self { jobs: ours.len(), cuts: 0, z_um: (0.0, allowed_um), difference: None };
        let here_and_there = |what: &str, ours: usize, theirs: usize| {
            (ours != theirs).then(|| format!("{ours} {what} here, {theirs} there"))
        };
        for (job, (ours, theirs)) in (1..).zip(ours.iter().zip(theirs)) {
            let [plan, other] = [ours, theirs].map(|job| job.plan.chars().take(8).collect::<String>());
            if ours.plan != theirs.plan {
                compared.difference = Some(format!("job {job}: plan {plan} here, {other} there"));
                return compared;
            }
            for (cut, (ours, theirs)) in (1..).zip(ours.cuts.iter().zip(&theirs.cuts)) {
                let off = [0, 1].map(|end| ours.z[end].abs_diff(theirs.z[end])).into_iter().max().unwrap_or(0);
                let off_um = um_from_mm(off as f64 / z.scale.counts_per_unit());
                compared.z_um.0 = compared.z_um.0.max(off_um);
                let found = if ours.setpoints != theirs.setpoints {
                    format!("{} setpoints here, {} there", ours.setpoints, theirs.setpoints)
                } else if ours.digest.finish() != theirs.digest.finish() {
                    "other setpoints of C or X".to_owned()
                } else if off_um > allowed_um {
                    format!("Z is {off_um:.1} um off; edges of switches allow {allowed_um:.1} um")
                } else {
                    compared.cuts += 1;
                    continue;
                };
                compared.difference = Some(format!("job {job}, cut {cut}: {found}"));
                return compared;
            }
            if let Some(text) = here_and_there("cuts", ours.cuts.len(), theirs.cuts.len()) {
                compared.difference = Some(format!("job {job}: {text}"));
                return compared;
            }
        }
        compared.difference = here_and_there("jobs", ours.len(), theirs.len());
        compared
    }

    pub(super) fn is_same(&self) -> bool {
        self.difference.is_none() && self.cuts > 0
    }

    pub(super) fn to_text(&self) -> String {
        let Self { jobs, cuts, z_um: (z_um, _), .. } = self;
        let result = match &self.difference {
            Some(difference) => format!("the other run differs: {difference}"),
            None if *cuts == 0 => "no cut to compare: neither run holds one".to_owned(),
            None => format!(
                "the other run cuts the same: C and X of {cuts} cuts of {jobs} jobs to the bit, Z within {z_um:.1} um"
            ),
        };
        result + "\nof real drives only the setpoints of cuts are compared, not switches, ticks and encoders"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright::machine::reference::cam_grinder;

    fn job(plan: &str, cuts: &[(u64, u64, i64)]) -> JobCuts {
        let cuts = cuts.iter().enumerate().map(|(segment, (setpoints, content, z))| {
            let mut digest = DefaultHasher::new();
            digest.write_u64(*content);
            CutTrace { segment, setpoints: *setpoints, digest, z: [*z; 2] }
        });
        JobCuts { plan: plan.to_owned(), cuts: cuts.collect() }
    }

    /// Z of the reference grinder has 10 counts per um, and a search goes 40 um in a tick.
    #[test]
    fn cuts_are_the_same_within_an_edge_of_z_and_else_the_first_difference_is_named() {
        let machine = cam_grinder();
        let compare = |ours: &[JobCuts], theirs: &[JobCuts]| CutComparison::new(ours, theirs, &machine);
        let ours = [job("abcdefghij", &[(4000, 1, 800_000), (1000, 2, 800_000)])];
        let same = compare(&ours, &[job("abcdefghij", &[(4000, 1, 800_012), (1000, 2, 799_995)])]);
        assert!(same.is_same(), "{}", same.to_text());
        assert!(same.to_text().starts_with(
            "the other run cuts the same: C and X of 2 cuts of 1 jobs to the bit, Z within 1.2 um\nof real drives only"
        ));
        for (theirs, expected) in [
            (vec![job("bcdefghijk", &[])], "job 1: plan abcdefgh here, bcdefghi there"),
            (vec![job("abcdefghij", &[(4000, 1, 800_000)])], "job 1: 2 cuts here, 1 there"),
            (
                vec![job("abcdefghij", &[(4000, 1, 800_000), (999, 2, 800_000)])],
                "job 1, cut 2: 1000 setpoints here, 999 there",
            ),
            (vec![job("abcdefghij", &[(4000, 7, 800_000)])], "job 1, cut 1: other setpoints of C or X"),
            (vec![job("abcdefghij", &[(4000, 1, 810_000)])], "job 1, cut 1: Z is 1000.0 um off"),
            (vec![], "1 jobs here, 0 there"),
        ] {
            let compared = compare(&ours, &theirs);
            let text = compared.to_text();
            assert!(!compared.is_same() && text.starts_with(&format!("the other run differs: {expected}")), "{text}");
        }
        assert!(!compare(&[], &[]).is_same(), "nothing was compared");
    }
}
