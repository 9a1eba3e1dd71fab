// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Job files of every kind: what a name leads to, by the schema that the file states.

use super::ConfigError;
use super::file_kind::FileKind;
use super::job_file::{self, Job};
use super::locate::{Located, locate};
use super::milling_file::{self, MilledJob};
use super::turning_file::{self, TurnedJob};
use super::yaml::Document;
use std::path::PathBuf;

/// A job as its files describe it.
#[derive(Debug, Clone)]
pub enum AnyJob {
    /// Lobes that are ground.
    Ground(Box<Job>),
    /// A part that is turned.
    Turned(Box<TurnedJob>),
    /// A part that is milled on a machine that is not ours.
    Milled(Box<MilledJob>),
}

/// Finds, reads and understands a job of any kind with `key=value` overrides.
///
/// # Errors
/// The first of what [`read`] finds.
pub fn load(name: &str, overrides: &[String]) -> Result<AnyJob, ConfigError> {
    parse(&locate("jobs", name, "yaml", None)?, overrides)
}

/// Understands a job of any kind that has been read.
///
/// # Errors
/// The first of what [`read`] finds.
pub fn parse(located: &Located, overrides: &[String]) -> Result<AnyJob, ConfigError> {
    read(located, overrides).map_err(|mut findings| findings.swap_remove(0))
}

/// Reads a job file of one kind.
type Reader = fn(&Located, &[String]) -> Result<AnyJob, Vec<ConfigError>>;

/// Kinds of jobs.
const READERS: [(FileKind, Reader); 3] = [
    (FileKind::Job, |located, overrides| job_file::read(located, overrides).map(|job| AnyJob::Ground(Box::new(job)))),
    (FileKind::TurningJob, |located, overrides| {
        turning_file::read(located, overrides).map(|job| AnyJob::Turned(Box::new(job)))
    }),
    (FileKind::MillingJob, |located, overrides| {
        milling_file::read(located, overrides).map(|job| AnyJob::Milled(Box::new(job)))
    }),
];

/// Reads a job of any kind, or reports everything that is wrong with it.
///
/// # Errors
/// Anything that is not a job, at least one error.
pub fn read(located: &Located, overrides: &[String]) -> Result<AnyJob, Vec<ConfigError>> {
    let (_, reader) = kind(located, overrides).map_err(|error| vec![error])?;
    reader(located, overrides)
}

/// Kind of job that the schema of a file states, with its reader; nothing else of the file is checked.
fn kind(located: &Located, overrides: &[String]) -> Result<(FileKind, Reader), ConfigError> {
    let document = Document::with_overrides(located, overrides)?;
    let stated = READERS.into_iter().find(|(kind, _)| document.kind() == Some(kind.name()));
    stated.ok_or_else(|| {
        let known = READERS.map(|(kind, _)| format!("\"camwright/{}/1\"", kind.name())).join(" or ");
        match document.text_at("schema") {
            Some(schema) => document.error("schema", format!("schema is {schema:?}, expected {known}")),
            None => document.error("schema", format!("has no schema; expected schema: {known}")),
        }
    })
}

/// Returns whether a name leads to a turning job; nothing else of the file is checked, and no file that it names is read.
#[must_use]
pub fn turns(name: &str, overrides: &[String]) -> bool {
    let located = locate("jobs", name, "yaml", None);
    located.is_ok_and(|located| kind(&located, overrides).is_ok_and(|(kind, _)| kind == FileKind::TurningJob))
}

/// The machine file that a job names, as its other readers find it; `None` for what is no job.
#[must_use]
pub fn machine_of(name: &str, overrides: &[String]) -> Option<String> {
    let located = locate("jobs", name, "yaml", None).ok()?;
    let document = Document::with_overrides(&located, overrides).ok()?;
    let machine = document.text_at("machine")?;
    let found = locate("machines", machine, "yaml", Some(&located.path)).ok()?;
    // What was found beside the job is named by its path; what is built in, by its name.
    Some(if found.path.is_file() { found.path.display().to_string() } else { machine.to_owned() })
}

/// Name, title and path of the jobs that [`load`] finds by name.
#[must_use]
pub fn list() -> Vec<(String, String, PathBuf)> {
    super::locate::list("jobs")
        .into_iter()
        .filter_map(|name| {
            let located = locate("jobs", &name, "yaml", None).ok()?;
            let document = Document::with_overrides(&located, &[]).ok()?;
            let title = document.text_at("title").unwrap_or_default().to_owned();
            Some((name, title, located.path))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        let located = Located::new("job.yaml", text);
        parse(&located, &[]).expect_err("no job").to_string()
    }

    #[test]
    fn a_file_is_read_by_its_schema() {
        assert!(matches!(load("turned_cam", &[]).unwrap(), AnyJob::Turned(_)));
        assert!(matches!(load("eccentric", &[]).unwrap(), AnyJob::Ground(_)));
    }

    #[test]
    fn a_schema_that_no_job_has_is_refused_with_those_that_jobs_have() {
        let known = "\"camwright/job/1\" or \"camwright/turning_job/1\" or \"camwright/milling_job/1\"";
        for (text, words) in [
            ("schema: camwright/machine/1\n", "job.yaml:1: schema is \"camwright/machine/1\", expected "),
            ("# a job\nschema: job\n", "job.yaml:2: schema is \"job\", expected "),
            ("schema: 7\n", "job.yaml:1: has no schema; expected schema: "),
            ("name: a\n", "job.yaml: has no schema; expected schema: "),
        ] {
            assert_eq!(refusal(text), format!("{words}{known}"));
        }
        let newer = refusal("schema: camwright/turning_job/4\n");
        assert!(newer.contains("job.yaml:1: is of schema version 4; this program reads turning_job files"), "{newer}");
    }

    #[test]
    fn jobs_of_both_kinds_are_listed_and_name_their_machine() {
        let names: Vec<String> = list().into_iter().map(|(name, _, _)| name).collect();
        assert!(names.contains(&"turned_cam".to_owned()) && names.contains(&"eccentric".to_owned()), "{names:?}");
        let machine = |job: &str| machine_of(job, &[]).expect("a machine");
        assert!(machine("turned_cam").contains("lathe") && machine("eccentric").contains("cam_grinder"));
        assert_eq!(machine_of("no_such_job", &[]), None);
    }
}
