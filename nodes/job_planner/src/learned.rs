// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Learned corrections of each job, stored beyond the end of the node: one small file for each machine and job.

use super::lock;
use camwright_files::convert::mm_from_m;
use camwright_files::machine_state_file;
use camwright_msgs::camwright_msgs::msg::PartLobe;
use camwright_planning::{LearnedJob, PreparedJob};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// The store; without a directory it lasts as long as the node.
#[derive(Debug, Default)]
pub(super) struct LearnedStore {
    directory: Option<PathBuf>,
    kept: Mutex<BTreeMap<(String, String), LearnedJob>>,
}

impl LearnedStore {
    /// In a directory; empty: the user's state directory, `none`: nowhere.
    pub(super) fn new(directory: &str) -> Self {
        Self { directory: Self::directory(directory), kept: Mutex::default() }
    }

    /// The directory that is meant.
    pub(super) fn directory(directory: &str) -> Option<PathBuf> {
        match directory {
            "none" => None,
            "" => machine_state_file::default_path("learned").map(|path| path.with_extension("")),
            directory => Some(PathBuf::from(directory)),
        }
    }

    fn path(&self, machine: &str, job: &str) -> Option<PathBuf> {
        // Names come from files and may hold anything; two jobs whose names differ only there share a file, which knows its job.
        Some(self.directory.as_ref()?.join(plain(machine)).join(format!("{}.yaml", plain(job))))
    }

    /// Loads the learned corrections of a job on a machine.
    pub(super) fn load(&self, machine: &str, job: &str) -> Result<LearnedJob, String> {
        let key = (machine.to_owned(), job.to_owned());
        if let Some(kept) = lock(&self.kept).get(&key) {
            return Ok(kept.clone());
        }
        let Some(path) = self.path(machine, job) else { return Ok(LearnedJob::new(machine, job)) };
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(LearnedJob::new(machine, job)),
            Err(error) => return Err(format!("{}: cannot be read: {error}", path.display())),
        };
        let read = LearnedJob::parse(&text).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(if read.is_of(machine, job) { read } else { LearnedJob::new(machine, job) })
    }

    /// Learns from a finished part and keeps it; one sentence a lobe, and the number of the part.
    pub(super) fn learn(&self, prepared: &PreparedJob, parts: &[PartLobe]) -> Result<Vec<String>, String> {
        let (machine, job) = (&prepared.machine.name, &prepared.job.spec.name);
        let outlines_mm: Vec<Vec<f64>> =
            parts.iter().map(|part| part.radius.iter().map(|radius| mm_from_m(*radius)).collect()).collect();
        // An unreadable file is reported when the job is planned; here learning starts anew.
        let mut learned = self.load(machine, job).unwrap_or_else(|_| LearnedJob::new(machine, job));
        let mut lines = learned.learn(prepared, &outlines_mm)?;
        lines.push(format!("job {job} has learned from {} parts on {machine}", learned.parts));
        // As its file says it, whether there is a file or not.
        let text = learned.text()?;
        lock(&self.kept).insert((machine.clone(), job.clone()), LearnedJob::parse(&text)?);
        if let Some(path) = self.path(machine, job) {
            write(&path, &text).map_err(|error| format!("{}: cannot be written: {error}", path.display()))?;
        }
        Ok(lines)
    }
}

/// A name as a file may have it.
pub(super) fn plain(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    name.chars().map(plain).collect()
}

/// Whole or not at all.
pub(super) fn write(path: &Path, text: &str) -> std::io::Result<()> {
    if let Some(directory) = path.parent() {
        std::fs::create_dir_all(directory)?;
    }
    let temporary = path.with_extension("yaml.tmp");
    std::fs::write(&temporary, text)?;
    std::fs::File::open(&temporary)?.sync_all()?;
    std::fs::rename(&temporary, path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright_files::convert::m_from_mm;
    use camwright_planning::prepare;

    #[test]
    fn what_was_learned_survives_a_restart_and_belongs_to_one_machine_and_job() {
        let set = ["form_compensation={}", "infeed.total_mm=0.072", "stock_mm=0.06"].map(str::to_owned);
        let prepared = prepare("four_lobe_camshaft", &set, None).unwrap();
        let part = |lobe: &camwright::planner::PlannedLobe| {
            let radius = |i: u32| lobe.design.radius_at(f64::from(i) * std::f64::consts::TAU / 720.0) + 0.001;
            let radius = (0..720).map(|i| m_from_mm(radius(i))).collect();
            PartLobe { name: lobe.design.name.clone(), radius, ..PartLobe::default() }
        };
        let parts: Vec<PartLobe> = prepared.planned.lobes.iter().map(part).collect();
        let directory = tempfile::tempdir().unwrap();
        let at = directory.path().display().to_string();
        let lines = LearnedStore::new(&at).learn(&prepared, &parts).unwrap();
        assert_eq!(lines.last().unwrap(), "job four_lobe_camshaft has learned from 1 parts on cam_grinder");
        let again = LearnedStore::new(&at);
        let learned = again.load("cam_grinder", "four_lobe_camshaft").unwrap();
        assert_eq!(learned.parts, 1);
        assert!(learned.override_for(&prepared.job).is_some());
        assert_eq!(again.load("cam_grinder", "eccentric").unwrap().parts, 0);
        assert_eq!(again.load("other", "four_lobe_camshaft").unwrap().parts, 0);
        std::fs::write(directory.path().join("cam_grinder/four_lobe_camshaft.yaml"), "nothing").unwrap();
        assert!(LearnedStore::new(&at).load("cam_grinder", "four_lobe_camshaft").is_err());
        drop(directory);
        let nowhere = LearnedStore::new("none");
        nowhere.learn(&prepared, &parts).unwrap();
        assert_eq!(nowhere.load("cam_grinder", "four_lobe_camshaft").unwrap().parts, 1);
    }
}
