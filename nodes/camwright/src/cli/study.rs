// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright study`: runs the cases of a study without ROS on all cores.

use super::output::{VerdictLevel, note, print_error, print_verdict, say, whole_number, wrapped};
use camwright_bag::progress;
use camwright_files::study_file::{self, Study};
use camwright_ros::Shutdown;
use camwright_studies::{self as studies, EngineSettings, SingleCaseError, StudyFolder, StudyResults};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Exit code of a study that was interrupted before its end.
const INTERRUPTED: u8 = 130;

/// Exit code of a study without a feasible case.
const NOT_FEASIBLE: u8 = 4;

/// Arguments of `camwright study`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = super::help::STUDY)]
pub(super) struct StudyArgs {
    /// Name or path of a study file
    #[arg(value_name = "FILE")]
    file: String,
    /// Folder for plan, finished cases and results [default: studies/<name>]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Cases that run at a time [default: number of processors]
    #[arg(long, value_name = "N", value_parser = workers)]
    workers: Option<u16>,
    /// Set a key of the study, such as `replicates=3`; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Write plan.json, with the hash of every case, and run nothing
    #[arg(long)]
    plan: bool,
    /// Run one case of plan.json into cases/HASH.parquet and .json of the folder
    #[arg(long, value_name = "HASH", conflicts_with_all = ["plan", "workers", "json"])]
    case: Option<String>,
    /// Search for the best point from the cases of the design: minimise this result
    #[arg(long, value_name = "RESULT", conflicts_with_all = ["plan", "case"])]
    minimise: Option<String>,
    /// Limits of the search, such as `form_error_max_um<=3,burn_index<=0.9`; they replace those of the study
    #[arg(long, value_name = "LIMITS", requires = "minimise")]
    subject_to: Option<String>,
    /// Maximum number of cases of a search, those of the design included
    #[arg(long, value_name = "N", requires = "minimise", default_value_t = 200, value_parser = max_cases)]
    cases: u32,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

impl StudyArgs {
    /// Keys of the study that the arguments set.
    fn overrides(&self) -> Result<Vec<String>, String> {
        let mut set = self.set.clone();
        set.extend(self.minimise.iter().map(|response| format!("minimise={response}")));
        let limits = self.subject_to.iter().flat_map(|limits| limits.split(',')).map(limit);
        set.extend(limits.collect::<Result<Vec<_>, _>>()?);
        Ok(set)
    }
}

/// Override of a limit that is written as `NAME<=VALUE`.
fn limit(text: &str) -> Result<String, String> {
    let (name, value) = text.split_once("<=").ok_or_else(|| {
        format!("--subject-to: {:?} is no limit; write NAME<=VALUE, for example form_error_max_um<=3", text.trim())
    })?;
    Ok(format!("limits.{}={}", name.trim(), value.trim()))
}

fn max_cases(text: &str) -> Result<u32, String> {
    whole_number(text, 1..=study_file::MAX_CASES)
}

fn workers(text: &str) -> Result<u16, String> {
    whole_number(text, 1..=1024)
}

/// Exit code 0: a case is feasible; 1: not written; 2: rejected; 4: no case is feasible; 130: interrupted.
pub(super) fn main(args: &StudyArgs) -> ExitCode {
    match run(args) {
        Ok(code) | Err(code) => ExitCode::from(code),
    }
}

fn failed(code: u8, error: &dyn std::fmt::Display) -> u8 {
    print_error("error", error);
    code
}

fn run(args: &StudyArgs) -> Result<u8, u8> {
    let overrides = args.overrides().map_err(|error| failed(2, &error))?;
    let study = study_file::load(&args.file, &overrides).map_err(|errors| {
        errors.iter().for_each(|error| print_error("error", error));
        2
    })?;
    let not_written = |error: studies::StudyError| failed(1, &error);
    let path = args.out.clone().unwrap_or_else(|| Path::new("studies").join(&study.name));
    if let Some(hash) = &args.case {
        return run_single(&study, &path, hash);
    }
    let mut cases = studies::cases(&study);
    let folder = StudyFolder::create(&path).map_err(not_written)?;
    if args.plan {
        folder.write_plan(&study, &cases).map_err(not_written)?;
        match args.json {
            true => say!("{}", json!({ "plan": folder.file("plan.json"), "cases": cases.len() })),
            false => say!("plan:    {} cases in {}", cases.len(), folder.file("plan.json").display()),
        }
        return Ok(0);
    }
    let (log, mut outcomes) = folder.open_log().map_err(not_written)?;
    folder.write_plan(&study, &cases).map_err(not_written)?;
    let known = match &args.minimise {
        // Cases of a search are known only when it asks for them.
        Some(_) => outcomes.len(),
        None => cases.iter().filter(|case| outcomes.contains_key(&case.hash)).count(),
    };
    let count = if args.minimise.is_some() { args.cases.max(study.case_count) as usize } else { cases.len() };
    if known > 0 {
        note!("resumed: {known} of {count} cases were finished before");
    }
    let shutdown = Shutdown::on_signals().map_err(|error| failed(1, &error))?;
    let bar = progress::bar(count as u64, "{bar:24} {human_pos} of {human_len} cases, {eta} left");
    bar.set_position(known as u64);
    bar.reset_eta();
    let processors = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let settings = EngineSettings {
        workers: args.workers.map_or(processors, usize::from),
        is_stopped: &|| shutdown.is_requested(),
        on_done: &|_| bar.inc(1),
    };
    let ran = match args.minimise {
        Some(_) => studies::optimise(&study, args.cases, (&log, &mut outcomes), &settings).and_then(|all| {
            cases = all;
            folder.write_plan(&study, &cases)
        }),
        None => studies::run_cases(&study, &cases, (&log, &mut outcomes), &settings),
    };
    bar.finish_and_clear();
    ran.map_err(not_written)?;
    let results = StudyResults::new(&study, &cases, &outcomes);
    folder.write_results(&results).map_err(not_written)?;
    let is_interrupted = !results.is_complete() || (args.minimise.is_some() && shutdown.is_requested());
    if args.json {
        say!("{:#}", results.json(&folder));
    } else {
        if is_interrupted {
            let text = format!(
                "INTERRUPTED: {} of {} cases are finished; the same command runs the others",
                results.rows.len(),
                cases.len()
            );
            print_verdict(VerdictLevel::Warning, &wrapped(&text, 2));
        }
        let level = if results.is_good() { VerdictLevel::Good } else { VerdictLevel::Bad };
        print_verdict(level, &wrapped(results.text(&folder).trim_end(), 9));
        if args.minimise.is_some() && results.is_good() {
            say!("job:     {}", folder.file("best_job.yaml").display());
        }
        say!("report:  {}", folder.file("report.html").display());
        say!("tables:  results.parquet, results.csv in {}", path.display());
    }
    Ok(match (is_interrupted, results.is_good()) {
        (true, _) => INTERRUPTED,
        (false, true) => 0,
        (false, false) => NOT_FEASIBLE,
    })
}

/// Runs one case of the written plan. A case that ran before does not run again.
fn run_single(study: &Study, path: &Path, hash: &str) -> Result<u8, u8> {
    let single = studies::run_single_case(study, &StudyFolder::open(path), hash)
        .map_err(|error| failed(if matches!(error, SingleCaseError::Failed(_)) { 1 } else { 2 }, &error))?;
    if single.ran_before {
        note!("case {hash} ran before");
        return Ok(0);
    }
    let outcome = single.outcome;
    let reason = if outcome.reason.is_empty() { String::new() } else { format!(": {}", outcome.reason) };
    let (number, count) = (single.case.number, single.case_count);
    say!("{}", wrapped(&format!("case {number} of {count}, {hash}: {}{reason}", outcome.status.name()), 2));
    Ok(0)
}
