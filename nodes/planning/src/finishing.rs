// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Finishing turns of journals: forecast before anything is measured, and decision.

use super::{PreparedCorrection, PreparedJob};
use camwright::gauging::GaugingMode;
use camwright::gauging::finishing::{Finishing, FinishingSpec};
use camwright::gauging::identify::Identified;
use camwright::machine::contact_law::ContactLaw;
use camwright::math::units::um_from_mm;
use camwright::planner::{ContactFrom, PlannedLobe};
use serde::Serialize;

/// Key of the force, which errors and warnings of the number of turns name.
pub(super) const FORCE_KEY: &str = "runout_correction.finishing.force_n";

/// Finishing turns of a journal in `summary.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FinishingSummary {
    /// Turns with feed.
    pub turns: u32,
    /// Largest depth of cut.
    pub deepest_um: f64,
    /// Largest normal force by the contact law.
    pub peak_n: f64,
    /// Source of the contact.
    pub stiffness: String,
}

impl FinishingSummary {
    fn new(finishing: Finishing, (law, from): (ContactLaw, ContactFrom)) -> Self {
        Self {
            turns: finishing.turns,
            deepest_um: um_from_mm(finishing.deepest_mm()),
            peak_n: finishing.peak_n(&law),
            stiffness: from.to_string(),
        }
    }
}

impl std::fmt::Display for FinishingSummary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let s = if self.turns == 1 { "" } else { "s" };
        write!(
            f,
            "{} finishing turn{s} of at most {:.2} um and {:.1} N, by the stiffness {}",
            self.turns, self.deepest_um, self.peak_n, self.stiffness
        )
    }
}

/// Finishing turns as the job states them; `None` without, and in the published mode, which does not know their depth.
fn stated(prepared: &PreparedJob) -> Option<FinishingSpec> {
    prepared.job.spec.is_corrected().filter(|correction| correction.mode == GaugingMode::Exact)?.finishing
}

/// Forecast at a lobe; `None` of a job without finishing turns of known depth.
pub(super) fn forecast(prepared: &PreparedJob, lobe: usize) -> Option<FinishingSummary> {
    let contact = prepared.planned.lobes.get(lobe)?.contact(&prepared.job.spec, &prepared.machine, None)?;
    let finishing = stated(prepared)?.turns(&contact.0).ok()?;
    Some(FinishingSummary::new(finishing, contact))
}

/// Forecast of each journal with finishing turns.
pub(super) fn notes(prepared: &PreparedJob) -> Vec<String> {
    let is_measured = prepared.job.spec.identification.is_some();
    let adapts = is_measured && matches!(stated(prepared), Some(FinishingSpec::ByForce { .. }));
    let then = if adapts { "; the measured one decides" } else { "" };
    let lines =
        prepared.planned.lobes.iter().enumerate().filter_map(|(index, lobe)| {
            Some(format!("lobe {}: {}{then}", lobe.design.name, forecast(prepared, index)?))
        });
    lines.collect()
}

/// Warning for turns by force that no measurement adapts to the part.
pub(super) fn unmeasured_warning(prepared: &PreparedJob) -> Option<String> {
    let spec = &prepared.job.spec;
    let FinishingSpec::ByForce { force_n, .. } = stated(prepared)? else { return None };
    if spec.identification.is_some() {
        return None;
    }
    let is_nominal = |lobe: &PlannedLobe| {
        lobe.contact(spec, &prepared.machine, None).is_some_and(|(_, from)| from == ContactFrom::Nominal)
    };
    let lobe = prepared.planned.lobes.iter().find(|lobe| is_nominal(lobe))?;
    Some(format!(
        "lobe {}: the number of finishing turns at {force_n} N follows the stiffness of the machine file, whatever wheel and part are; \
         identification: {{}} measures it on the part",
        lobe.design.name
    ))
}

impl PreparedJob {
    /// True for a job with finishing turns of known depth after its correction.
    #[must_use]
    pub fn has_finishing_turns(&self) -> bool {
        stated(self).is_some()
    }
}

impl PreparedCorrection {
    /// One sentence for each journal with finishing turns.
    #[must_use]
    pub fn finishing_lines(&self, prepared: &PreparedJob) -> Vec<String> {
        let spec = &prepared.job.spec;
        if !prepared.has_finishing_turns() {
            return Vec::new();
        }
        let line = |(index, lobe): (usize, &PlannedLobe)| {
            let finishing = self.decided.get(index)?.finishing?;
            let measured = self.measured.contacts.get(index).and_then(Option::as_ref);
            let contact = lobe.contact(spec, &prepared.machine, measured.map(|measured: &Identified| measured.law))?;
            Some(format!("lobe {}: {}", lobe.design.name, FinishingSummary::new(finishing, contact)))
        };
        prepared.planned.lobes.iter().enumerate().filter_map(line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finding::Severity;
    use crate::findings::all_warnings;
    use crate::{prepare, summary};
    use camwright::machine::description::MachineDescription;

    const BY_FORCE: &str = "runout_correction.finishing={stock_um: 12, force_n: 120}";

    fn prepared(set: &[&str]) -> Result<PreparedJob, String> {
        let set: Vec<String> = set.iter().map(ToString::to_string).collect();
        prepare("journal_runout", &set, None).map_err(|error| error.to_string())
    }

    /// kg = 30 N/µm, F0 = 16 N: U = 104/30 µm, 4 turns of 12/3.75 µm at 112 N; 8 turns with twice the kg in the stored contact.
    #[test]
    fn the_forecast_follows_the_contact_known_before() {
        let nominal = prepared(&[BY_FORCE]).unwrap();
        for lobe in summary(&nominal).lobes {
            let expected =
                "4 finishing turns of at most 3.20 um and 112.0 N, by the stiffness of the machine's description";
            assert_eq!(lobe.finishing.unwrap().to_string(), expected);
        }
        let contacts = ["J1", "J2", "J3"].map(|name| {
            let kg = if name == "J2" { 60.0 } else { 30.0 };
            format!("{{lobe: {name}, machine_n_um: 6, grinding_n_um: {kg}, threshold_n: 16}}")
        });
        let contacts = format!("runout_correction.contacts=[{}]", contacts.join(", "));
        let kept = prepared(&[BY_FORCE, &contacts, "identification=null"]).unwrap();
        let turns: Vec<u32> = summary(&kept).lobes.iter().map(|lobe| lobe.finishing.as_ref().unwrap().turns).collect();
        assert_eq!(turns, [4, 8, 4]);
        // J2 turns four times more, at a turn a second.
        let seconds = |prepared: &PreparedJob| prepared.expected_correction.as_ref().unwrap().plan.duration_s;
        assert!((seconds(&kept) - seconds(&nominal) - 4.0).abs() < 1e-6);
        assert_eq!(summary(&prepared(&[]).unwrap()).lobes[0].finishing, None);
    }

    #[test]
    fn what_no_contact_can_finish_is_refused_with_its_line() {
        for (set, words) in [
            (
                "runout_correction.finishing={stock_um: 12, force_n: 20}",
                &[
                    "lobe J1, by the stiffness of the machine's description: ",
                    "need 91 turns, at most 20",
                    "force_n to 34.3",
                ][..],
            ),
            ("runout_correction.finishing={stock_um: 12, force_n: 10}", &["takes nothing", "begins to cut at 16.0 N"]),
            (
                "runout_correction.finishing={stock_um: 12, force_n: 120, max_turns: 3}",
                &["need 4 turns, at most 3 are allowed", "raise max_turns"],
            ),
            (
                "runout_correction.finishing={stock_um: 12, force_n: -5}",
                &["runout_correction.finishing.force_n is -5; it must be 0.1 to 20000"],
            ),
            ("runout_correction.finishing={stock_um: 12, force_n: 1e9}", &["it must be 0.1 to 20000"]),
            ("runout_correction.finishing={stock_um: 0, force_n: 120}", &["it must be 0.1 to 1000"]),
            ("runout_correction.finishing={stock_um: 120, force_n: 9000, max_turns: 2}", &["it must be at most 100"]),
            ("runout_correction.finishing={stock_um: 12, turns: 3}", &["it has turns, stock_um"]),
            (
                "runout_correction.finishing={per_turn_um: 4, turns: 3, force_n: 120}",
                &["needs per_turn_um and turns, or stock_um and force_n", "it has per_turn_um, turns, force_n"],
            ),
            ("runout_correction.finishing={}", &["it has none of them"]),
        ] {
            let error = prepared(&[set]).unwrap_err();
            for words in words {
                assert!(error.contains(words), "{set}: {words}: {error}");
            }
            assert!(
                error.contains("journal_runout.yaml") && error.contains("(set by runout_correction.finishing"),
                "{error}"
            );
        }
        let error = prepared(&[BY_FORCE, "runout_correction.mode=published"]).unwrap_err();
        assert!(error.contains("needs mode: exact"), "{error}");
    }

    /// A job that does not measure is warned that nothing adapts; one with a stored contact, and one that measures, are not.
    #[test]
    fn turns_that_adapt_to_nothing_are_warned_of() {
        let warned = |set: &[&str]| {
            let findings = all_warnings(&prepared(set).unwrap());
            assert!(findings.iter().all(|finding| finding.severity == Severity::Warning));
            findings.iter().any(|finding| {
                finding.to_string().contains("finishing turns at 120 N follows the stiffness of the machine")
            })
        };
        assert!(warned(&[BY_FORCE, "identification=null"]));
        assert!(!warned(&[BY_FORCE]) && !warned(&["identification=null"]));
    }

    /// The shipped job on a machine whose cut takes twice the force of the file: twice the turns on each journal, decided from the
    /// readings, and the same plan to the bit when decided again.
    #[test]
    fn a_blunt_wheel_gets_more_turns_and_the_decision_repeats_to_the_bit() {
        let prepared = prepared(&[BY_FORCE]).unwrap();
        let mut blunt = prepared.machine.clone();
        blunt.contact.as_mut().unwrap().grinding_n_mm2 *= 2.0;
        let turns = |machine: &MachineDescription| {
            let run = || {
                let mut lines = Vec::new();
                crate::simulate::simulate_with_report(&prepared, machine, |line| lines.push(line)).unwrap();
                lines
            };
            let lines: Vec<String> = run();
            assert_eq!(lines, run(), "the decision repeats");
            let finishing = lines.iter().filter_map(|line| line.split_once(" finishing turns"));
            finishing.map(|(before, _)| before.rsplit(' ').next().unwrap().parse().unwrap()).collect::<Vec<u32>>()
        };
        let (as_described, harder) = (turns(&prepared.machine), turns(&blunt));
        assert_eq!(as_described.len(), 3);
        for (as_described, harder) in as_described.iter().zip(&harder) {
            assert!((4..=5).contains(as_described) && (7..=10).contains(harder), "{as_described} {harder}");
        }
    }
}
