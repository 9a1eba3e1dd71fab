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
pub use outcome::{ChangeLine, ReplanOutcome, replan};

use camwright_bag::progress;
use camwright_bag::terminal::wrapped;
use clap::Args;
use indicatif::ProgressBar;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// Exit codes: something moved; a job could not be planned again.
const MOVED: u8 = 3;
const CANNOT: u8 = 1;

const AFTER_HELP: &str = "\
Example: camwright replan bags/my_run --set work_speed_rpm=58

Exit codes:
  0  same plans
  1  a job cannot be planned again
  2  wrong arguments
  3  differences";

/// Arguments of `camwright replan`.
#[derive(Debug, Clone, Args)]
#[command(after_help = AFTER_HELP)]
pub struct ReplanArgs {
    /// Bags, or folders of bags
    #[arg(required = true, value_name = "BAG")]
    pub bags: Vec<PathBuf>,
    /// Smallest reported change (um; at angles urad); a changed number of steps, turns or orders is always reported
    #[arg(long, value_name = "UM", default_value_t = 0.0, value_parser = tolerance)]
    pub tolerance_um: f64,
    /// Set a key of every job, such as `work_speed_rpm=58`; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Set a key of every machine, such as `x_axis.max_jerk_mm_s3=5e5`; repeatable
    #[arg(long = "set-machine", value_name = "KEY=VALUE")]
    pub set_machine: Vec<String>,
}

fn tolerance(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text} is not a number"))?;
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(format!("{text} um is negative or not finite; it must be 0 or more"))
    }
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
    let mut lines = Vec::new();
    for bag in &bags {
        progress.set_message(bag.display().to_string());
        let name = bag.display();
        let archived = match archived_jobs(bag) {
            Ok(archived) if archived.is_empty() => {
                failed += 1;
                lines.push(format!("{name}: the bag holds no planned job"));
                continue;
            }
            Ok(archived) => archived,
            Err(error) => {
                failed += 1;
                lines.push(format!("{name}: {error}"));
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
            lines.push(format!("{name}: {}: {text}", job.status.job));
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
    let word = match code {
        0 => "SAME",
        MOVED => "DIFFERENT",
        _ => "INCOMPLETE",
    };
    let verdict = format!("{word}: {jobs} jobs of {} bags, {moved} different, {failed} not planned again", bags.len());
    lines.insert(0, verdict);
    print_and_exit(&wrapped(&lines.join("\n"), 2), code)
}

fn print(text: &str) -> io::Result<()> {
    writeln!(io::stdout(), "{text}")
}

fn print_and_exit(text: &str, code: u8) -> ExitCode {
    // Output that went away is no failure of ours.
    let _ = print(text);
    ExitCode::from(code)
}
