//! Folder of a study: plan of the cases, log of finished cases, results.

use super::StudyError;
use super::case_log::CaseLog;
use super::cases::StudyCase;
use super::engine::CaseOutcomes;
use super::results::StudyResults;
use camwright_files::study_file::Study;
use serde_json::{Value, json};
use std::fs::{self, File};
use std::path::{Path, PathBuf};

/// Folder of a study.
#[derive(Debug, Clone)]
pub struct StudyFolder(PathBuf);

impl StudyFolder {
    /// Creates the folder if it does not exist.
    ///
    /// # Errors
    /// It cannot be created.
    pub fn create(path: &Path) -> Result<Self, StudyError> {
        fs::create_dir_all(path).map_err(|source| StudyError::io("created", path, source))?;
        Ok(Self(path.to_path_buf()))
    }

    /// Opens the log of finished cases.
    ///
    /// # Errors
    /// See [`CaseLog::open`].
    pub fn open_log(&self) -> Result<(CaseLog, CaseOutcomes), StudyError> {
        CaseLog::open(&self.0.join("cases.jsonl"))
    }

    /// Writes `plan.json`: every case with its hash and settings.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_plan(&self, study: &Study, cases: &[StudyCase]) -> Result<(), StudyError> {
        let fixed: Vec<String> = study.base.fixed().iter().map(set_text).collect();
        let case = |case: &StudyCase| {
            let set: Vec<String> = case.settings.iter().map(set_text).collect();
            json!({
                "case": case.number, "hash": case.hash, "point": case.point, "replicate": case.replicate, "set": set,
            })
        };
        let plan = json!({
            "study": study.name,
            "job": study.job,
            "machine": study.machine,
            "base": study.base.hash,
            "program": concat!("camwright ", env!("CARGO_PKG_VERSION")),
            "fixed": fixed,
            "source": study.document.text,
            "cases": cases.iter().map(case).collect::<Vec<Value>>(),
        });
        self.write("plan.json", format!("{plan:#}\n").as_bytes())
    }

    /// Writes `results.parquet`, `results.csv` and `report.html`, and job and machine of the best case where there is one.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write_results(&self, results: &StudyResults<'_>) -> Result<(), StudyError> {
        let table = results.table();
        let path = self.0.join("results.parquet");
        let part = self.0.join("results.parquet.part");
        let file = File::create(&part).map_err(|source| StudyError::io("written", &part, source))?;
        table.write_parquet(&path, file)?;
        fs::rename(&part, &path).map_err(|source| StudyError::io("written", &path, source))?;
        self.write("results.csv", table.to_csv().as_bytes())?;
        self.write("report.html", results.page(self).as_bytes())?;
        let best = results.best().and_then(|best| results.study.base.sources_with(&best.settings).ok());
        if let Some((job, machine)) = best {
            self.write("best_job.yaml", job.as_bytes())?;
            self.write("best_machine.yaml", machine.as_bytes())?;
        }
        Ok(())
    }

    /// Path of a file in the folder.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Replaces a file as a whole.
    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StudyError> {
        let (path, part) = (self.0.join(name), self.0.join(format!("{name}.part")));
        let failed = |source| StudyError::io("written", &path, source);
        fs::write(&part, bytes).map_err(failed)?;
        fs::rename(&part, &path).map_err(failed)
    }
}

/// A setting as `key=value`.
pub(crate) fn set_text((key, value): &(String, camwright_files::yaml::YamlValue)) -> String {
    format!("{key}={}", value.to_flow())
}
