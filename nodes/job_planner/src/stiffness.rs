// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The stiffness of each machine, kept over the end of the node: one small file for each, beside what was learned of its jobs. The planner
//! keeps it, not the machine: it is found by the planner from readings, is an input of plans, and a machine that is driven by another
//! program would not know of it.

use super::learned::{self, LearnedStore};
use super::lock;
use camwright_files::stiffness_file::{StoredContact, StoredStiffness};
use camwright_planning::{MeasuredContacts, PreparedJob};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Mutex;

/// The store; without a directory it lasts as long as the node.
#[derive(Debug, Default)]
pub(super) struct StiffnessStore {
    directory: Option<PathBuf>,
    kept: Mutex<BTreeMap<String, StoredStiffness>>,
}

impl StiffnessStore {
    /// In the directory of what is learned, empty: the user's state directory, `none`: nowhere.
    pub(super) fn new(directory: &str) -> Self {
        Self { directory: LearnedStore::directory(directory), kept: Mutex::default() }
    }

    fn path(&self, machine: &str) -> Option<PathBuf> {
        // A plain name has no point: no folder of a machine's jobs is called so.
        Some(self.directory.as_ref()?.join(format!("{}.stiffness.yaml", learned::plain(machine))))
    }

    /// Loads the stored stiffness of a machine.
    pub(super) fn load(&self, machine: &str) -> Result<StoredStiffness, String> {
        if let Some(kept) = lock(&self.kept).get(machine) {
            return Ok(kept.clone());
        }
        let Some(path) = self.path(machine) else { return Ok(StoredStiffness::new(machine)) };
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(StoredStiffness::new(machine)),
            Err(error) => return Err(format!("{}: cannot be read: {error}", path.display())),
        };
        let read = StoredStiffness::parse(&path, &text).map_err(|error| error.to_string())?;
        // Two machines whose names differ only in what no file name has share a file, which knows its machine.
        Ok(if read.machine == machine { read } else { StoredStiffness::new(machine) })
    }

    /// Keeps what was measured on the journals of a part: what it keeps of them. A file that cannot be read is not written over.
    pub(super) fn store(
        &self,
        prepared: &PreparedJob,
        measured: &MeasuredContacts,
    ) -> Result<Vec<StoredContact>, String> {
        let machine = &prepared.machine.name;
        let afresh = prepared.job.spec.identification.is_some_and(|identification| identification.afresh);
        let mut kept = if afresh { StoredStiffness::new(machine) } else { self.load(machine)? };
        let places = camwright_planning::learn_stiffness(&mut kept, prepared, measured)?;
        let text = kept.text()?;
        if let Some(path) = self.path(machine) {
            learned::write(&path, &text).map_err(|error| format!("{}: cannot be written: {error}", path.display()))?;
        }
        // As its file says it, whether there is a file or not.
        let read = StoredStiffness::parse(&PathBuf::from(machine), &text).map_err(|error| error.to_string())?;
        lock(&self.kept).insert(machine.clone(), read);
        Ok(places)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright::gauging::decay::Comparison;
    use camwright::gauging::identify::{Identified, Uncertainty};
    use camwright::gauging::stiffness::{FeedForce, GrindingStiffness, MeasuredValue};
    use camwright::machine::contact_law::ContactLaw;
    use camwright_planning::prepare;

    fn contact(n_mm: f64) -> Option<Identified> {
        let of = |value: f64| MeasuredValue { value, uncertainty: 0.01 * value };
        Some(Identified {
            machine_n_mm: of(n_mm),
            grinding: GrindingStiffness { grinding_n_mm: of(3e4), threshold_n: of(16.0) },
            one_feed: FeedForce { grinding_n_mm: 3e4, bias_n_mm: 0.0 },
            comparison: Comparison::from_measurements(of(0.2), of(0.2)),
            law: ContactLaw::new(n_mm, 3e4, 16.0).unwrap(),
            known_to: Uncertainty { ratio: of(0.2), machine_n_mm: 60.0, grinding_n_mm: 900.0, threshold_n: 3.0 },
        })
    }

    fn measured(n_mm: [f64; 3]) -> MeasuredContacts {
        MeasuredContacts { contacts: n_mm.map(contact).into(), held: Vec::new() }
    }

    #[test]
    fn what_was_measured_survives_a_restart_and_can_be_begun_afresh() {
        let prepared = prepare("journal_runout", &[], None).unwrap();
        let directory = tempfile::tempdir().unwrap();
        let at = directory.path().display().to_string();
        StiffnessStore::new(&at).store(&prepared, &measured([6e3, 4e3, 6e3])).unwrap();
        let again = StiffnessStore::new(&at);
        let kept = again.load("journal_grinder").unwrap();
        assert_eq!((kept.parts, kept.places().len()), (1, 3));
        assert!((kept.map().at(150.0).unwrap().grinding_n_mm2.value - 1500.0).abs() < 1e-9);
        assert!(again.load("other").unwrap().places().is_empty());
        // Another part with one measured journal replaces that one only.
        let mut one = measured([6e3, 4.4e3, 6e3]);
        (one.contacts[0], one.contacts[2]) = (None, None);
        assert_eq!(again.store(&prepared, &one).unwrap().len(), 1);
        let kept = StiffnessStore::new(&at).load("journal_grinder").unwrap();
        assert_eq!((kept.parts, kept.places()[1].part, kept.places()[2].part), (2, 2, 1));
        // What cannot be read is neither taken nor lost.
        let path = directory.path().join("journal_grinder.stiffness.yaml");
        std::fs::write(&path, "schema: camwright/stiffness/7\n").unwrap();
        let error = StiffnessStore::new(&at).load("journal_grinder").unwrap_err();
        assert!(error.contains("journal_grinder.stiffness.yaml:1"), "{error}");
        assert!(StiffnessStore::new(&at).store(&prepared, &one).is_err());
        let afresh = prepare("journal_runout", &["identification.afresh=true".to_owned()], None).unwrap();
        StiffnessStore::new(&at).store(&afresh, &one).unwrap();
        let kept = StiffnessStore::new(&at).load("journal_grinder").unwrap();
        assert_eq!((kept.parts, kept.places().len()), (1, 1));
        drop(directory);
        let nowhere = StiffnessStore::new("none");
        nowhere.store(&prepared, &one).unwrap();
        assert_eq!(nowhere.load("journal_grinder").unwrap().places().len(), 1);
    }
}
