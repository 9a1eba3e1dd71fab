//! `camwright bag info` and `camwright bag check`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::check::{self, Severity};
use super::info::BagInfo;

/// Arguments of `camwright bag`.
#[derive(Debug, Clone, clap::Args)]
pub struct BagArgs {
    /// What to do with the bag
    #[command(subcommand)]
    pub command: BagCommand,
}

/// What `camwright bag` does.
#[derive(Debug, Clone, clap::Subcommand)]
pub enum BagCommand {
    /// Topics, counts, times and custom data of a bag
    Info(BagPath),
    /// Structure, check sums, order, and agreement with metadata.yaml; exit 0 clean, 1 warnings, 2 errors
    Check(BagPath),
}

/// Which bag, and how to tell about it.
#[derive(Debug, Clone, clap::Args)]
pub struct BagPath {
    /// Directory of the bag, or one MCAP file
    pub bag: PathBuf,
    /// One JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// Runs `camwright bag …`. Exit code 0: done, or clean; 1: warnings; 2: errors in the bag, or no bag.
#[must_use]
pub fn run(args: &BagArgs) -> ExitCode {
    let outcome = match &args.command {
        BagCommand::Info(path) => info(&path.bag, path.json),
        BagCommand::Check(path) => check_bag(&path.bag, path.json),
    };
    match outcome {
        Ok((text, code)) => {
            // A reader that went away (`| head`) is no failure of ours.
            let _ = writeln!(io::stdout(), "{}", text.trim_end());
            ExitCode::from(code)
        }
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {error}");
            ExitCode::from(2)
        }
    }
}

fn info(bag: &Path, json: bool) -> Result<(String, u8), super::BagError> {
    let info = BagInfo::read(bag)?;
    Ok((if json { info.to_json() } else { info.to_text() }, 0))
}

fn check_bag(bag: &Path, json: bool) -> Result<(String, u8), super::BagError> {
    let report = check::check(bag)?;
    let code = match report.worst() {
        None => 0,
        Some(Severity::Warning) => 1,
        Some(Severity::Error) => 2,
    };
    Ok((if json { report.to_json() } else { report.to_text() }, code))
}
