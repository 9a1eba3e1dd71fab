// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Stored stiffness of a machine: applied to the next job, and extended by its journals.

use super::{MeasuredContacts, PreparedJob};
use camwright::gauging::stiffness::MeasuredValue;
use camwright::gauging::stiffness_map::MeasuredStiffness;
use camwright::job::grinding::{KnownContact, StiffnessSource};
use camwright::machine::description::MachineDescription;
use camwright_files::job_file::Job;
use camwright_files::journal_file::contact_flow;
use camwright_files::stiffness_file::{StoredContact, StoredStiffness};

/// Stored contacts used by a job.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StoredContacts {
    /// The override that writes it into the job; nothing for a job that takes nothing.
    pub over: Option<String>,
    /// Why it takes none for a journal that it would take it for.
    pub lines: Vec<String>,
}

/// Stored contacts for a job: used if its runout is corrected and its stiffness is not measured, unless it uses the description's
/// stiffness or contains stored values itself. The store holds the stiffness of the machine; the part of the job stands in
/// series with it.
#[must_use]
pub fn kept_contacts(kept: &StoredStiffness, job: &Job, machine: &MachineDescription) -> StoredContacts {
    let takes =
        job.spec.correction.as_ref().is_some_and(|correction| {
            correction.stiffness != StiffnessSource::Nominal && correction.contacts.is_empty()
        });
    // A machine that was never measured has nothing to report.
    if !takes || job.spec.identification.is_some() || kept.places().is_empty() {
        return StoredContacts::default();
    }
    let (mut flows, mut lines) = (Vec::new(), Vec::new());
    for lobe in &job.spec.lobes {
        let Some(station) = machine.station(&lobe.station) else { continue };
        match kept.map().law(station.position_mm, lobe.width_mm) {
            Ok(law) => {
                let law = law.in_series(job.spec.lobe_compliance_mm_n(machine, lobe));
                flows.push(contact_flow(&KnownContact { lobe: lobe.name.clone(), law }));
            }
            Err(error) => {
                lines.push(format!("lobe {}: no stiffness is stored for it on {}: {error}", lobe.name, kept.machine));
            }
        }
    }
    let over = (!flows.is_empty()).then(|| format!("runout_correction.contacts=[{}]", flows.join(", ")));
    StoredContacts { over, lines }
}

/// Keeps what was measured on the journals of a part, each in the stead of what was kept for its place; what it keeps of them, in their
/// order.
///
/// # Errors
/// Numbers that no measurement gives.
pub fn learn_stiffness(
    stiffness: &mut StoredStiffness,
    prepared: &PreparedJob,
    measured: &MeasuredContacts,
) -> Result<Vec<StoredContact>, String> {
    if prepared.job.spec.identification.is_some_and(|identification| identification.afresh) {
        *stiffness = StoredStiffness::new(&stiffness.machine);
    }
    stiffness.parts += 1;
    let mut kept = Vec::new();
    for (lobe, contact) in prepared.planned.lobes.iter().zip(&measured.contacts) {
        let (Some(contact), Some(station)) = (contact, prepared.machine.station(&lobe.design.station)) else {
            continue;
        };
        let (law, known_to, width_mm) = (contact.law, contact.known_to, lobe.design.width_mm);
        let per_width = |value: f64, uncertainty: f64| MeasuredValue {
            value: value / width_mm,
            uncertainty: uncertainty / width_mm,
        };
        let measured = MeasuredValue { value: law.machine_n_mm(), uncertainty: known_to.machine_n_mm };
        let part_mm_n = lobe.design.part_compliance_mm_n(&prepared.machine, 0.0);
        let machine_n_mm = without_part(measured, part_mm_n).ok_or_else(|| {
            format!(
                "lobe {}: the measured stiffness of {:.1} N/um is less than that of the part alone, {:.1} N/um; correct part_support",
                lobe.design.name,
                measured.value / PER_MM,
                1.0 / part_mm_n / PER_MM
            )
        })?;
        let place = StoredContact {
            place: MeasuredStiffness {
                z_mm: station.position_mm,
                machine_n_mm,
                grinding_n_mm2: per_width(law.grinding_n_mm(), known_to.grinding_n_mm),
                threshold_n_mm: per_width(law.threshold_n(), known_to.threshold_n),
            },
            lobe: lobe.design.name.clone(),
            job: prepared.job.spec.name.clone(),
            part: stiffness.parts,
            width_mm,
        };
        stiffness.insert(place.clone()).map_err(|error| format!("lobe {}: {error}", lobe.design.name))?;
        kept.push(place);
    }
    Ok(kept)
}

/// N/µm to N/mm.
const PER_MM: f64 = 1e3;

/// Stiffness of the machine behind a part of this compliance (mm/N), from that of both; `None` where the part alone is softer.
fn without_part(measured: MeasuredValue, part_mm_n: f64) -> Option<MeasuredValue> {
    if part_mm_n == 0.0 {
        return Some(measured);
    }
    let machine_mm_n = 1.0 / measured.value - part_mm_n;
    let value = 1.0 / machine_mm_n;
    let uncertainty = measured.uncertainty * (value / measured.value) * (value / measured.value);
    (machine_mm_n > 0.0).then_some(MeasuredValue { value, uncertainty })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{plan, prepare};
    use camwright_files::job_file;
    use camwright_files::locate::{Located, locate};

    fn kept(of: &[(f64, f64)]) -> StoredStiffness {
        let mut kept = StoredStiffness::new("journal_grinder");
        for (z_mm, n_mm) in of {
            let place = MeasuredStiffness {
                z_mm: *z_mm,
                machine_n_mm: MeasuredValue { value: *n_mm, uncertainty: 50.0 },
                grinding_n_mm2: MeasuredValue { value: 1400.0, uncertainty: 50.0 },
                threshold_n_mm: MeasuredValue { value: 0.7, uncertainty: 0.2 },
            };
            kept.insert(StoredContact { place, lobe: "J".into(), job: "j".into(), part: 1, width_mm: 20.0 }).unwrap();
        }
        kept
    }

    const UNMEASURED: [&str; 1] = ["identification=null"];

    /// The store holds the stiffness of the machine: without the part that was on it, in series with the part of the next job.
    #[test]
    fn a_slender_part_is_not_stored_with_the_machine() {
        let measured = MeasuredValue { value: 4000.0, uncertainty: 40.0 };
        assert_eq!(without_part(measured, 0.0), Some(measured));
        let machine = without_part(measured, 5e-5).unwrap();
        assert!((machine.value - 5000.0).abs() < 1e-9 && (machine.uncertainty - 40.0 * 1.5625).abs() < 1e-9);
        assert_eq!(without_part(measured, 2.6e-4), None);
        let slender = prepare("long_camshaft", &["part_support.steady_rest_z_mm=null".to_owned()], None).unwrap();
        let mut prepared = prepare("journal_runout", &UNMEASURED.map(String::from), None).unwrap();
        prepared.machine.workholding = slender.machine.workholding;
        prepared.job.spec.part_support = slender.job.spec.part_support;
        let of_job = kept_contacts(&kept(&[(80.0, 5000.0), (220.0, 5000.0)]), &prepared.job, &prepared.machine);
        let lobe = &prepared.job.spec.lobes[0];
        let part_mm_n = prepared.job.spec.lobe_compliance_mm_n(&prepared.machine, lobe);
        let wanted = format!("lobe: {}, machine_n_um: {:.6}", lobe.name, 1e-3 / (1.0 / 5000.0 + part_mm_n));
        assert!(
            part_mm_n > 1e-5 && of_job.over.as_ref().is_some_and(|over| over.contains(&wanted)),
            "{of_job:?}, {wanted}"
        );
    }

    /// Stored values are written into the job, interpolated ones as well, and the job plans to the same hash from its own text
    /// anywhere.
    #[test]
    fn what_is_kept_is_an_input_of_the_plan() {
        let set: Vec<String> = UNMEASURED.map(String::from).into();
        let prepared = prepare("journal_runout", &set, None).unwrap();
        let taken = kept_contacts(&kept(&[(80.0, 5000.0), (220.0, 6000.0)]), &prepared.job, &prepared.machine);
        let over = taken.over.unwrap();
        // Half way: 2/(1/5 + 1/6) N/µm.
        assert!(
            over.contains("{lobe: J2, machine_n_um: 5.454545, grinding_n_um: 28.000000, threshold_n: 14.000000}"),
            "{over}"
        );
        let with: Vec<String> = set.iter().cloned().chain([over]).collect();
        let used = prepare("journal_runout", &with, None).unwrap();
        assert_ne!(used.plan_hash(), prepared.plan_hash());
        let (law, from) = used.planned.lobes[1].contact(&used.job.spec, &used.machine, None).unwrap();
        assert!((law.machine_n_mm() - 5454.545).abs() < 1e-6 && from.to_string() == "kept for the machine");
        let located = locate("jobs", "journal_runout", "yaml", None).unwrap();
        let recorded = Located { text: used.job.source.clone(), ..located };
        let again = plan(job_file::parse(&recorded, &[]).unwrap(), None).unwrap();
        assert_eq!(again.plan_hash(), used.plan_hash());
    }

    #[test]
    fn a_journal_outside_the_measured_range_is_reported_and_uses_the_description() {
        let set: Vec<String> = UNMEASURED.map(String::from).into();
        let prepared = prepare("journal_runout", &set, None).unwrap();
        let take = |kept: &StoredStiffness, job: &Job| kept_contacts(kept, job, &prepared.machine);
        let some = take(&kept(&[(80.0, 5000.0), (150.0, 4000.0)]), &prepared.job);
        assert!(some.over.is_some_and(|over| !over.contains("J3")));
        assert!(some.lines.len() == 1 && some.lines[0].contains("lobe J3") && some.lines[0].contains("80 to 150 mm"));
        assert_eq!(take(&StoredStiffness::new("journal_grinder"), &prepared.job), StoredContacts::default());
        let load = |more: &str| job_file::load("journal_runout", &[set[0].clone(), more.to_owned()]).unwrap();
        let all = kept(&[(80.0, 5000.0), (220.0, 6000.0)]);
        assert_eq!(take(&all, &load("runout_correction.stiffness=nominal")), StoredContacts::default());
        let measures = job_file::load("journal_runout", &[]).unwrap();
        assert_eq!(take(&all, &measures), StoredContacts::default(), "it measures itself");
        let insists = ["identification=null".to_owned(), "runout_correction.stiffness=kept".to_owned()];
        let error = prepare("journal_runout", &insists, None).unwrap_err().to_string();
        assert!(error.contains("lobe J1") && error.contains("no stiffness is stored"), "{error}");
    }
}
