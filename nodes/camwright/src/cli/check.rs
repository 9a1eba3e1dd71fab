//! `camwright check`: everything that can be said about a job or a lift table before anything moves.

use camwright_files::{ConfigError, Place};
use camwright_planning::{self as planning, Finding, Severity};
use serde_json::{Value, json};
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

/// Arguments of `camwright check`.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct CheckArgs {
    /// Name or path of a job file or of a lift table
    #[arg(value_name = "JOB|LIFT")]
    file: String,
    /// Sets a key over the job file, or for a table a key of a profile's `lift`
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// One JSON object instead of text
    #[arg(long)]
    json: bool,
}

/// Exit code 0: clean; 1: warnings; 2: refused, or not there.
pub(super) fn main(args: &CheckArgs) -> ExitCode {
    let (findings, summary, notes, file) = match planning::check(&args.file, &args.set, None) {
        Ok(report) => (report.findings, report.summary, report.notes, report.file.display().to_string()),
        Err(error) => (vec![Finding { severity: Severity::Error, error }], None, Vec::new(), args.file.clone()),
    };
    let worst = findings.iter().map(|finding| finding.severity).max();
    if args.json {
        let verdict = match worst {
            None => "clean",
            Some(Severity::Warning) => "warnings",
            Some(Severity::Error) => "refused",
        };
        let findings: Vec<Value> = findings.iter().map(as_json).collect();
        let report =
            json!({ "file": file, "verdict": verdict, "summary": summary, "notes": notes, "findings": findings });
        let _ = writeln!(io::stdout(), "{report:#}");
    } else {
        for finding in &findings {
            let _ = writeln!(io::stderr(), "{finding}");
        }
        if let Some(summary) = summary {
            let _ = writeln!(io::stdout(), "{summary}");
        }
        for note in notes {
            let _ = writeln!(io::stdout(), "{note}");
        }
    }
    ExitCode::from(match worst {
        None => 0,
        Some(Severity::Warning) => 1,
        Some(Severity::Error) => 2,
    })
}

fn as_json(finding: &Finding) -> Value {
    let ConfigError { place: Place { file, line }, message } = &finding.error;
    let file: &Path = file;
    json!({
        "severity": finding.severity.to_string(),
        "file": file.display().to_string(),
        "line": line,
        "message": message,
    })
}
