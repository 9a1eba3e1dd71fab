// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Folder of a study: plan of the cases, log of finished cases, results.

use super::StudyError;
use super::case_log::{CaseLog, line_of, outcome_in};
use super::case_run::CaseOutcome;
use super::cases::StudyCase;
use super::engine::CaseOutcomes;
use super::results::StudyResults;
use super::table::ResultTable;
use camwright_files::study_file::Study;
use serde::Deserialize;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// Folder of the cases that ran alone.
const SINGLE_CASES: &str = "cases";

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

    /// A folder that exists.
    #[must_use]
    pub fn open(path: &Path) -> Self {
        Self(path.to_path_buf())
    }

    /// Opens the log of finished cases and adds those that ran alone.
    ///
    /// # Errors
    /// See [`CaseLog::open`].
    pub fn open_log(&self) -> Result<(CaseLog, CaseOutcomes), StudyError> {
        let (log, mut outcomes) = CaseLog::open(&self.0.join("cases.jsonl"))?;
        outcomes.extend(log.add_single_cases(&self.0.join(SINGLE_CASES), &outcomes)?);
        Ok((log, outcomes))
    }

    /// Hashes of the cases in `plan.json`.
    ///
    /// # Errors
    /// It cannot be read, or is no plan of cases.
    pub fn planned_hashes(&self) -> Result<Vec<String>, StudyError> {
        #[derive(Deserialize)]
        struct Plan {
            cases: Vec<PlannedCase>,
        }
        #[derive(Deserialize)]
        struct PlannedCase {
            hash: String,
        }
        let path = self.0.join("plan.json");
        let failed = |source| StudyError::io("read", &path, source);
        let plan: Plan = serde_json::from_slice(&fs::read(&path).map_err(failed)?).map_err(|e| failed(e.into()))?;
        Ok(plan.cases.into_iter().map(|case| case.hash).collect())
    }

    /// Outcome of a case that ran alone; none if it has not run or a file of it is missing or damaged.
    #[must_use]
    pub fn single_case(&self, hash: &str) -> Option<CaseOutcome> {
        let path = |extension: &str| self.0.join(SINGLE_CASES).join(format!("{hash}.{extension}"));
        let line = fs::read(path("json")).ok()?;
        outcome_in(&line, hash).filter(|_| path("parquet").exists())
    }

    /// Writes `cases/HASH.parquet`, the row of a case that ran alone, and `cases/HASH.json`, its line for the log.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write_single_case(
        &self,
        study: &Study,
        cases: &[StudyCase],
        hash: &str,
        outcome: &CaseOutcome,
    ) -> Result<(), StudyError> {
        let folder = Self::create(&self.0.join(SINGLE_CASES))?;
        let outcomes = CaseOutcomes::from([(hash.to_owned(), outcome.clone())]);
        folder.write_table(&format!("{hash}.parquet"), &StudyResults::new(study, cases, &outcomes).table())?;
        let name = format!("{hash}.json");
        let line = line_of(hash, outcome).map_err(|source| StudyError::io("written", &folder.file(&name), source))?;
        folder.write(&name, &line)
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
        self.write_table("results.parquet", &table)?;
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

    fn write_table(&self, name: &str, table: &ResultTable) -> Result<(), StudyError> {
        let mut bytes = Vec::new();
        table.write_parquet(&self.0.join(name), &mut bytes)?;
        self.write(name, &bytes)
    }

    /// Replaces a file as a whole, also where several processes write it at a time.
    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StudyError> {
        let (path, part) = (self.0.join(name), self.0.join(format!("{name}.{}.part", std::process::id())));
        let failed = |source| StudyError::io("written", &path, source);
        fs::write(&part, bytes).map_err(failed)?;
        fs::rename(&part, &path).map_err(failed)
    }
}

/// A setting as `key=value`.
pub(crate) fn set_text((key, value): &(String, camwright_files::yaml::YamlValue)) -> String {
    format!("{key}={}", value.to_flow())
}
