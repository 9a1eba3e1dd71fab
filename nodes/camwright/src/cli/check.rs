// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright check`: validates a job, a machine, a study, a lift table or a parameter file.

use super::check_parameters;
use super::output::{VerdictLevel, print_error, print_verdict, print_warning, say, wrapped};
use camwright_files::{ConfigError, FileLocation};
use camwright_planning::{self as planning, CheckReport, Finding, Severity};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

/// Arguments of `camwright check`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = super::help::CHECK)]
pub(super) struct CheckArgs {
    /// Name or path of a job, a machine, a study, a lift table or a parameter file
    #[arg(value_name = "FILE")]
    file: String,
    /// Set a key of the file, or for a lift table a key of `lift`; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
    /// Print readings of lift tables, clearances of an insert, and finishing turns too
    #[arg(long)]
    details: bool,
}

/// Exit code 0: clean; 1: warnings; 2: rejected or not found.
pub(super) fn main(args: &CheckArgs) -> ExitCode {
    let (findings, summary, notes, file) = match check(args) {
        Ok(report) => (report.findings, report.summary, report.notes, report.file.display().to_string()),
        Err(error) => (vec![Finding { severity: Severity::Error, error }], None, Vec::new(), args.file.clone()),
    };
    let worst = findings.iter().map(|finding| finding.severity).max();
    let (verdict, level) = match worst {
        None => ("clean", VerdictLevel::Good),
        Some(Severity::Warning) => ("warnings", VerdictLevel::Warning),
        Some(Severity::Error) => ("refused", VerdictLevel::Bad),
    };
    if args.json {
        let findings: Vec<Value> = findings.iter().map(as_json).collect();
        let report =
            json!({ "file": file, "verdict": verdict, "summary": summary, "notes": notes, "findings": findings });
        say!("{report:#}");
    } else {
        let count = |severity| findings.iter().filter(|finding| finding.severity == severity).count();
        let counts = [(count(Severity::Error), "error"), (count(Severity::Warning), "warning")];
        let counts: Vec<String> = counts
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, word)| format!("{count} {word}{}", if *count == 1 { "" } else { "s" }))
            .collect();
        let about = if counts.is_empty() { summary.clone().unwrap_or(file) } else { counts.join(", ") };
        print_verdict(level, &wrapped(&format!("{}: {about}", verdict.to_uppercase()), 2));
        for (severity, text) in grouped(&findings) {
            match severity {
                Severity::Warning => print_warning("warning", &text),
                Severity::Error => print_error("error", &text),
            }
        }
        if let Some(summary) = summary.filter(|_| !counts.is_empty()) {
            say!("{}", wrapped(&summary, 2));
        }
        if args.details {
            for note in notes {
                say!("{}", wrapped(&note, 2));
            }
        }
    }
    ExitCode::from(match worst {
        None => 0,
        Some(Severity::Warning) => 1,
        Some(Severity::Error) => 2,
    })
}

fn check(args: &CheckArgs) -> Result<CheckReport, ConfigError> {
    let Some(located) = check_parameters::parameter_file(&args.file) else {
        return planning::check_file(&args.file, &args.set);
    };
    let refuse = |message: String| ConfigError::at(FileLocation::file(&located.path), message);
    if !args.set.is_empty() {
        return Err(refuse("--set does not apply to a parameter file; change the file".into()));
    }
    check_parameters::check(&located).map_err(|error| refuse(error.to_string()))
}

/// Findings in their order; equal ones of a file are one, with the lines of the others.
fn grouped(findings: &[Finding]) -> Vec<(Severity, String)> {
    let mut groups: Vec<(&Finding, Vec<u64>)> = Vec::new();
    let mut known = BTreeMap::new();
    for finding in findings {
        let Finding { severity, error } = finding;
        let group = *known.entry((severity, &error.place.file, &error.message)).or_insert(groups.len());
        match groups.get_mut(group) {
            Some((_, others)) => others.extend(error.place.line),
            None => groups.push((finding, Vec::new())),
        }
    }
    groups
        .into_iter()
        .map(|(Finding { severity, error }, others)| (*severity, format!("{error}{}", also(&others))))
        .collect()
}

fn also(lines: &[u64]) -> String {
    let shown = lines.iter().take(3).map(u64::to_string).collect::<Vec<_>>().join(", ");
    match lines.len() {
        0 => String::new(),
        1 => format!("; the same in line {shown}"),
        2 | 3 => format!("; the same in lines {shown}"),
        count => format!("; the same in lines {shown} and {} others", count - 3),
    }
}

fn as_json(finding: &Finding) -> Value {
    let ConfigError { place: FileLocation { file, line }, message } = &finding.error;
    let file: &Path = file;
    json!({
        "severity": finding.severity.to_string(),
        "file": file.display().to_string(),
        "line": line,
        "message": message,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_findings_of_a_file_are_one_with_its_lines() {
        let finding = |file: &str, line, message: &str| Finding {
            severity: Severity::Error,
            error: ConfigError::at(FileLocation::line(Path::new(file), line), message),
        };
        let mut findings: Vec<_> = (5..11).map(|line| finding("a.csv", line, "no angle")).collect();
        findings.insert(2, finding("a.csv", 6, "no lift"));
        findings.push(finding("b.csv", 5, "no angle"));
        findings.push(finding("b.csv", 9, "no angle"));
        let texts: Vec<_> = grouped(&findings).into_iter().map(|(_, text)| text).collect();
        let expected = [
            "a.csv:5: no angle; the same in lines 6, 7, 8 and 2 others",
            "a.csv:6: no lift",
            "b.csv:5: no angle; the same in line 9",
        ];
        assert_eq!(texts, expected);
    }
}
