// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Check of a file that users write, of whatever kind.

use super::finding::CheckReport;
use super::findings::{check_job, check_table, is_table};
use camwright_files::file_kind::FileKind;
use camwright_files::locate::{Located, list, locate};
use camwright_files::schema::nearest;
use camwright_files::yaml::Document;
use camwright_files::{ConfigError, FileLocation, machine_file, study_file};
use std::path::Path;

/// Kinds of files that are found by name.
const NAMED: [&str; 4] = ["jobs", "lifts", "machines", "studies"];

/// Checks a job, a machine, a study or a lift table, by name or path. The key `schema` of a YAML file states its kind.
///
/// # Errors
/// There is no such file.
pub fn check_file(name: &str, overrides: &[String]) -> Result<CheckReport, ConfigError> {
    if is_table(name) {
        return locate("lifts", name, "csv", None).map(|located| check_table(&located, overrides));
    }
    let error = match locate("jobs", name, "yaml", None) {
        Ok(located) => return Ok(check_by_schema(&located, overrides)),
        Err(error) => error,
    };
    if Path::new(name).is_file() {
        return Err(error);
    }
    if let Ok(located) = locate("lifts", name, "csv", None) {
        return Ok(check_table(&located, overrides));
    }
    locate("machines", name, "yaml", None)
        .or_else(|_| locate("studies", name, "yaml", None))
        .map(|located| check_by_schema(&located, overrides))
        .map_err(|_| not_found(name))
}

/// Error for a name that no file has.
fn not_found(name: &str) -> ConfigError {
    let known: Vec<String> = NAMED.iter().flat_map(|kind| list(kind)).collect();
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    let stem = Path::new(name).file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default();
    let hint = match nearest(&stem, &known) {
        Some(nearest) => format!("did you mean {nearest}?"),
        None => "`camwright list jobs` lists jobs, `camwright list machines` machines".to_owned(),
    };
    let message = format!("not found as given, in ./params, in share/camwright/params or built in; {hint}");
    ConfigError::at(FileLocation::file(Path::new(name)), message)
}

fn check_by_schema(located: &Located, overrides: &[String]) -> CheckReport {
    let document = match Document::with_overrides(located, overrides) {
        Ok(document) => document,
        Err(error) => return CheckReport::refused(&located.path, vec![error]),
    };
    match FileKind::ALL.into_iter().find(|kind| document.kind() == Some(kind.name())) {
        Some(FileKind::Machine) => check_machine(located, overrides),
        Some(FileKind::Study) => check_study(located, overrides),
        Some(FileKind::Job | FileKind::TurningJob | FileKind::MillingJob) => check_job(located, overrides, None),
        None => CheckReport::refused(&located.path, vec![unknown_kind(&document)]),
    }
}

/// Error for a file whose kind is unknown.
fn unknown_kind(document: &Document) -> ConfigError {
    let known = FileKind::ALL.map(|kind| format!("camwright/{}/1", kind.name()));
    let listed = known.join(", ");
    match document.text_at("schema") {
        Some(schema) => {
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            let hint = nearest(schema, &known).map_or_else(String::new, |known| format!("; did you mean {known}?"));
            document.error("schema", format!("schema is {schema:?}; it must be one of {listed}{hint}"))
        }
        None => document.error(
            "schema",
            format!("the kind of the file is unknown; add the key schema with one of {listed}, or ros__parameters"),
        ),
    }
}

fn check_machine(located: &Located, overrides: &[String]) -> CheckReport {
    match machine_file::read(&located.path, &located.text, overrides) {
        Ok(machine) => {
            let stations = match machine.description.stations.len() {
                1 => "1 station".to_owned(),
                count => format!("{count} stations"),
            };
            let summary = format!("{}: {}, {}, {stations}", machine.description.name, machine.kind(), machine.travel());
            CheckReport { file: located.path.clone(), findings: Vec::new(), summary: Some(summary), notes: Vec::new() }
        }
        Err(errors) => CheckReport::refused(&located.path, errors),
    }
}

fn check_study(located: &Located, overrides: &[String]) -> CheckReport {
    match study_file::read(located, overrides) {
        Ok(study) => {
            let count = |count: usize, word: &str| format!("{count} {word}{}", if count == 1 { "" } else { "s" });
            let (cases, factors) = (count(study.case_count as usize, "case"), count(study.factors.len(), "factor"));
            let summary = format!("{}: {cases} of {}, {factors}", study.name, study.job);
            CheckReport { file: located.path.clone(), findings: Vec::new(), summary: Some(summary), notes: Vec::new() }
        }
        Err(errors) => CheckReport::refused(&located.path, errors),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Severity;

    fn checked(name: &str, overrides: &[&str]) -> CheckReport {
        check_file(name, &overrides.iter().map(ToString::to_string).collect::<Vec<_>>()).expect("a file")
    }

    #[test]
    fn machines_jobs_and_tables_are_checked_by_name() {
        for (name, words) in [
            ("cam_grinder", "cam_grinder: grinder, x_axis 5 to 180 mm, z_axis -20 to 600 mm, 4 stations"),
            ("lathe", "lathe: lathe, x_axis "),
            ("plate_cam", "plate_cam: 1 lobe, "),
            ("speed_and_infeed", "speed_and_infeed: 12 cases of "),
            ("intake", "3600 blocks over one turn"),
        ] {
            let summary = checked(name, &[]).summary.expect("no errors");
            assert!(summary.contains(words), "{summary}");
        }
    }

    #[test]
    fn all_errors_of_a_machine_are_reported() {
        let report = checked("cam_grinder", &["x_axis.max_sped_mm_s=3", "wheel.width_mm=-1", "rotation_sense=2"]);
        let text: Vec<String> = report.findings.iter().map(ToString::to_string).collect();
        let text = text.join("\n");
        for words in ["did you mean max_speed_mm_s?", "wheel.width_mm is -1", "rotation_sense is 2; it must be 1 or -1"]
        {
            assert!(text.contains(words), "{words}: {text}");
        }
        assert_eq!(report.worst(), Some(Severity::Error));
    }

    #[test]
    fn all_errors_of_a_study_are_reported() {
        let report =
            checked("speed_and_infeed", &["factors.work_sped_rpm=[50.0]", "minimise=time", "limits.form_um=3"]);
        let text: Vec<String> = report.findings.iter().map(ToString::to_string).collect();
        let text = text.join("\n");
        for words in ["minimise is \"time\"", "limits.form_um is an unknown key"] {
            assert!(text.contains(words), "{words}: {text}");
        }
        let report = checked("speed_and_infeed", &["factors.work_sped_rpm=[50.0]", "factors.stock_mm=[-1.0]"]);
        let text: Vec<String> = report.findings.iter().map(ToString::to_string).collect();
        let text = text.join("\n");
        for words in ["did you mean work_speed_rpm?", "stock_mm is -1; it must be 0.000001 to 10000"] {
            assert!(text.contains(words), "{words}: {text}");
        }
    }

    #[test]
    fn an_unknown_kind_is_one_error_with_the_known_ones() {
        for (schema, words) in [
            ("schema=camwright/machin/1", "did you mean camwright/machine/1?"),
            ("schema=7", "the kind of the file is unknown; add the key schema with one of camwright/job/1, "),
        ] {
            let report = checked("eccentric", &[schema]);
            assert_eq!(report.findings.len(), 1, "{:?}", report.findings);
            assert!(report.findings[0].to_string().contains(words), "{}", report.findings[0]);
        }
    }

    #[test]
    fn a_misspelt_name_gets_the_nearest_of_all_kinds() {
        for (name, nearest) in [("lath", "lathe"), ("intak.yaml", "intake"), ("ecentric", "eccentric")] {
            let error = check_file(name, &[]).expect_err("no file").to_string();
            assert!(error.ends_with(&format!("did you mean {nearest}?")), "{error}");
        }
        assert!(check_file("zzzzzz", &[]).expect_err("no file").to_string().contains("`camwright list jobs`"));
    }
}
