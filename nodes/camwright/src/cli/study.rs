//! `camwright study`: runs the cases of a study without ROS on all cores.

use super::output::{VerdictLevel, note, print_error, print_verdict, say, wrapped};
use camwright_bag::progress;
use camwright_files::study_file;
use camwright_ros::Shutdown;
use camwright_studies::{self as studies, EngineSettings, StudyFolder, StudyResults};
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
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    workers: Option<u16>,
    /// Set a key of the study, such as `replicates=3`; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
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
    let study = study_file::load(&args.file, &args.set).map_err(|errors| {
        errors.iter().for_each(|error| print_error("error", error));
        2
    })?;
    let not_written = |error: studies::StudyError| failed(1, &error);
    let cases = studies::cases(&study);
    let path = args.out.clone().unwrap_or_else(|| Path::new("studies").join(&study.name));
    let folder = StudyFolder::create(&path).map_err(not_written)?;
    let (log, mut outcomes) = folder.open_log().map_err(not_written)?;
    folder.write_plan(&study, &cases).map_err(not_written)?;
    let known = cases.iter().filter(|case| outcomes.contains_key(&case.hash)).count();
    if known > 0 {
        note!("resumed: {known} of {} cases were finished before", cases.len());
    }
    let shutdown = Shutdown::on_signals().map_err(|error| failed(1, &error))?;
    let bar = progress::bar(cases.len() as u64, "{bar:24} {human_pos} of {human_len} cases, {eta} left");
    bar.set_position(known as u64);
    bar.reset_eta();
    let processors = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let settings = EngineSettings {
        workers: args.workers.map_or(processors, usize::from),
        is_stopped: &|| shutdown.is_requested(),
        on_done: &|_| bar.inc(1),
    };
    let ran = studies::run_cases(&study, &cases, (&log, &mut outcomes), &settings);
    bar.finish_and_clear();
    ran.map_err(not_written)?;
    let results = StudyResults::new(&study, &cases, &outcomes);
    folder.write_results(&results).map_err(not_written)?;
    let is_interrupted = !results.is_complete();
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
        say!("report:  {}", folder.file("report.html").display());
        say!("tables:  results.parquet, results.csv in {}", path.display());
    }
    Ok(match (is_interrupted, results.is_good()) {
        (true, _) => INTERRUPTED,
        (false, true) => 0,
        (false, false) => NOT_FEASIBLE,
    })
}
