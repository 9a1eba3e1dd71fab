// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright replan`: plans the recorded jobs of bags again with this program, and lists the differences.

use super::output::{JsonArg, VerdictLevel, print_error, print_verdict, say, wrapped};
use camwright_analysis::replan::{ReplanOutcome, archived_jobs, bags_in, replan};
use camwright_bag::progress;
use clap::Args;
use indicatif::ProgressBar;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Exit codes: a plan differs; a job could not be planned again.
const DIFFERENT: u8 = 3;
const CANNOT: u8 = 1;

/// Arguments of `camwright replan`.
#[derive(Debug, Clone, Args)]
#[command(after_help = super::help::REPLAN)]
pub(super) struct ReplanArgs {
    /// Bags, or folders of bags
    #[arg(required = true, value_name = "BAG")]
    bags: Vec<PathBuf>,
    /// Smallest reported change (um; at angles urad); a changed number of steps, turns or orders is always reported
    #[arg(long, value_name = "UM", default_value_t = 0.0, value_parser = tolerance)]
    tolerance_um: f64,
    /// Set a key of every job, such as `work_speed_rpm=58`; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Set a key of every machine, such as `x_axis.max_jerk_mm_s3=5e5`; repeatable
    #[arg(long = "set-machine", value_name = "KEY=VALUE")]
    set_machine: Vec<String>,
    #[command(flatten)]
    output: JsonArg,
}

fn tolerance(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text} is not a number"))?;
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(format!("{text} um is negative or not finite; it must be 0 or more"))
    }
}

/// A recorded job after planning it again. Without a job the bag cannot be read, or holds none.
struct Replanned {
    bag: PathBuf,
    job: Option<String>,
    outcome: Result<ReplanOutcome, String>,
}

impl Replanned {
    fn text(&self) -> String {
        let bag = self.bag.display();
        match (&self.job, &self.outcome) {
            (Some(job), Ok(outcome)) => format!("{bag}: {job}: {outcome}"),
            (Some(job), Err(reason)) => format!("{bag}: {job}: cannot be planned again: {reason}"),
            (None, Ok(_)) => bag.to_string(),
            (None, Err(reason)) => format!("{bag}: {reason}"),
        }
    }

    fn json(&self) -> Value {
        let mut json = json!({ "bag": self.bag, "job": self.job });
        match &self.outcome {
            Err(reason) => json["error"] = reason.as_str().into(),
            Ok(outcome) => {
                let changes = outcome.lines.iter().map(|line| json!({ "step": line.step, "change": line.text }));
                json["is_same"] = outcome.is_same.into();
                json["plan_hashes"] = json!(outcome.hashes);
                json["durations_s"] = json!(outcome.duration_s);
                json["changes"] = changes.collect();
                json["changes_within_tolerance"] = outcome.within.into();
            }
        }
        json
    }
}

/// Exit code 0: same plans; 3: differences; 1: a job cannot be planned again.
pub(super) fn main(args: &ReplanArgs) -> ExitCode {
    let mut bags = Vec::new();
    for path in &args.bags {
        match bags_in(path) {
            Ok(found) => bags.extend(found),
            Err(error) => {
                print_error("camwright replan", &error);
                return ExitCode::from(CANNOT);
            }
        }
    }
    // One bag is planned before a bar is visible.
    let progress = match bags.len() {
        0 | 1 => ProgressBar::hidden(),
        several => progress::bar(several as u64, "{bar:40} {pos} of {len} bags (eta {eta}) {msg}"),
    };
    let mut jobs = Vec::new();
    for bag in &bags {
        progress.set_message(bag.display().to_string());
        jobs.extend(replanned(bag, args));
        progress.inc(1);
    }
    progress.finish_and_clear();
    let different = jobs.iter().filter(|job| job.outcome.as_ref().is_ok_and(ReplanOutcome::moved)).count();
    let failed = jobs.iter().filter(|job| job.outcome.is_err()).count();
    let (word, code) = match (failed, different) {
        (0, 0) => ("SAME", 0),
        (0, _) => ("DIFFERENT", DIFFERENT),
        _ => ("INCOMPLETE", CANNOT),
    };
    let count = jobs.iter().filter(|job| job.job.is_some()).count();
    if args.output.json {
        let all: Value = jobs.iter().map(Replanned::json).collect();
        say!("{:#}", json!({ "verdict": word.to_lowercase(), "bags": bags.len(), "jobs": all }));
    } else {
        let verdict =
            format!("{word}: {count} jobs of {} bags, {different} different, {failed} not planned again", bags.len());
        let lines: Vec<String> = std::iter::once(verdict).chain(jobs.iter().map(Replanned::text)).collect();
        print_verdict(VerdictLevel::from_code(code), &wrapped(&lines.join("\n"), 2));
    }
    ExitCode::from(code)
}

/// Plans every job of a bag again.
fn replanned(bag: &Path, args: &ReplanArgs) -> Vec<Replanned> {
    let without_job = |reason: String| vec![Replanned { bag: bag.to_owned(), job: None, outcome: Err(reason) }];
    match archived_jobs(bag) {
        Err(error) => without_job(error.to_string()),
        Ok(archived) if archived.is_empty() => without_job("the bag holds no planned job".to_owned()),
        Ok(archived) => {
            let again = |job| replan(job, &args.set, &args.set_machine, args.tolerance_um);
            let all = archived.iter().map(|job| Replanned {
                bag: bag.to_owned(),
                job: Some(job.status.job.clone()),
                outcome: again(job),
            });
            all.collect()
        }
    }
}
