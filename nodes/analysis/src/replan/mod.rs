//! `camwright replan BAG…`: plans archived jobs again with this program, and lists what moved and by how much.
//!
//! ```text
//! bag ─► archive (job, machine, plan as they were) ─┬─► old plan ─┐
//!                                                   └─► planning ─┴─► camwright::planner::plan_difference ─► outcome
//! ```

mod archive;
mod outcome;

#[cfg(test)]
mod tests;

pub use archive::{ArchivedJob, archived_jobs, bags_in};
pub use outcome::{Line, Outcome, replan};

use camwright_bag::progress;
use clap::Args;
use indicatif::ProgressBar;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// Exit codes: something moved; a job could not be planned again.
const MOVED: u8 = 3;
const CANNOT: u8 = 1;

/// Arguments of `camwright replan`.
#[derive(Debug, Clone, Args)]
pub struct ReplanArgs {
    /// Bags, or folders in which bags lie
    #[arg(required = true, value_name = "BAG")]
    pub bags: Vec<PathBuf>,
    /// Smallest reported change (um; at angles urad); a changed number of steps, turns or orders is always reported
    #[arg(long, value_name = "UM", default_value_t = 0.0, value_parser = tolerance)]
    pub tolerance_um: f64,
    /// Sets a key of every job, for example `work_speed_rpm=58`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Sets a key of every machine, for example `x_axis.max_jerk_mm_s3=500000`; may be repeated
    #[arg(long = "set-machine", value_name = "KEY=VALUE")]
    pub set_machine: Vec<String>,
}

fn tolerance(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text} is not a number"))?;
    if value.is_finite() && value >= 0.0 { Ok(value) } else { Err(format!("{text} um, but it is 0 or more")) }
}

/// Runs `camwright replan`. Exit code 0: nothing moved; 3: something did; 1: a job cannot be planned again.
#[must_use]
pub fn run(args: &ReplanArgs) -> ExitCode {
    let mut bags = Vec::new();
    for path in &args.bags {
        match bags_in(path) {
            Ok(found) => bags.extend(found),
            Err(error) => return print_and_exit(&format!("cannot plan again: {error}"), CANNOT),
        }
    }
    // One bag is planned before anybody has seen a bar.
    let progress = match bags.len() {
        0 | 1 => ProgressBar::hidden(),
        several => progress::bar(several as u64, "{bar:40} {pos} of {len} bags (eta {eta}) {msg}"),
    };
    let (mut jobs, mut moved, mut failed) = (0_u32, 0_u32, 0_u32);
    for bag in &bags {
        progress.set_message(bag.display().to_string());
        let name = bag.display();
        let archived = match archived_jobs(bag) {
            Ok(archived) if archived.is_empty() => {
                failed += 1;
                let _ = print(&format!("{name}: no job was planned in it"));
                continue;
            }
            Ok(archived) => archived,
            Err(error) => {
                failed += 1;
                let _ = print(&format!("{name}: {error}"));
                continue;
            }
        };
        for job in &archived {
            jobs += 1;
            let text = match replan(job, &args.set, &args.set_machine, args.tolerance_um) {
                Ok(outcome) => {
                    moved += u32::from(outcome.moved());
                    outcome.to_string()
                }
                Err(reason) => {
                    failed += 1;
                    format!("cannot be planned again: {reason}")
                }
            };
            let _ = print(&format!("{name}: {}: {text}", job.status.job));
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    let code = if failed > 0 {
        CANNOT
    } else if moved > 0 {
        MOVED
    } else {
        0
    };
    print_and_exit(
        &format!("{jobs} jobs of {} bags: {moved} moved, {failed} could not be planned again", bags.len()),
        code,
    )
}

fn print(text: &str) -> io::Result<()> {
    writeln!(io::stdout(), "{text}")
}

fn print_and_exit(text: &str, code: u8) -> ExitCode {
    // Output that went away is no failure of ours.
    let _ = print(text);
    ExitCode::from(code)
}
