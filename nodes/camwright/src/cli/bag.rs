//! `camwright bag info`, `check`, `report`, `recover` and `export`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use camwright_bag::check::{self, Severity};
use camwright_bag::export::TableFormat;
use camwright_bag::info::BagInfo;
use camwright_bag::recover;
use camwright_bag::{Bag, Preset, export};

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
    /// A page for a browser or for paper: whether the part is good, where it is worst and why; exit 0 written, 1 not
    Report(ReportArgs),
    /// A new bag of what is whole in one that was killed or is damaged; exit 0 nothing was lost, 2 something was, 1 there is no new bag
    Recover(RecoverArgs),
    /// Tables (CSV, Parquet) of every topic for pandas and spreadsheets, or a compressed copy of the bag
    Export(ExportArgs),
}

/// What is made of a bag, and where.
#[derive(Debug, Clone, clap::Args)]
pub struct ExportArgs {
    /// Directory of the bag, or one MCAP file
    pub bag: PathBuf,
    /// csv, parquet: a table of each topic; zstd and its like: the same bag with compressed chunks
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    pub to: Format,
    /// Directory that is made; left out: beside the bag, under its name with `_csv`, `_parquet`, …
    #[arg(long, value_name = "DIR")]
    pub into: Option<PathBuf>,
    /// Elements of an array that have a column each; a longer array is one text, in parquet one list
    #[arg(long, default_value_t = 64, value_name = "N")]
    pub longest: usize,
}

/// What a bag is made into.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// A table of each topic.
    Csv,
    /// A table of each topic, each column with its type.
    Parquet,
    /// The same bag with compressed chunks.
    Zstd,
    /// The same, compressed as fast as it can be.
    #[value(name = "zstd_fast")]
    ZstdFast,
    /// The same, as small as it can be.
    #[value(name = "zstd_small")]
    ZstdSmall,
}

/// What is to be recovered, and where to.
#[derive(Debug, Clone, clap::Args)]
pub struct RecoverArgs {
    /// Which bag
    #[command(flatten)]
    pub bag: BagPath,
    /// Directory of the new bag; left out: beside the old one, under its name with `_recovered`
    #[arg(long, value_name = "DIR")]
    pub into: Option<PathBuf>,
}

/// Which run is reported, and where to.
#[derive(Debug, Clone, clap::Args)]
pub struct ReportArgs {
    /// Directory of the bag, or one MCAP file
    pub bag: PathBuf,
    /// The page; left out: `report.html` in the bag's directory
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
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
        BagCommand::Export(args) => export_bag(args),
        BagCommand::Recover(RecoverArgs { bag: path, into }) => recover_bag(&path.bag, into.as_deref(), path.json),
        BagCommand::Report(args) => return report(args),
    };
    let failed = if matches!(args.command, BagCommand::Recover(_)) { 1 } else { 2 };
    match outcome {
        Ok((text, code)) => {
            // A reader that went away (`| head`) is no failure of ours.
            let _ = writeln!(io::stdout(), "{}", text.trim_end());
            ExitCode::from(code)
        }
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {error}");
            ExitCode::from(failed)
        }
    }
}

fn report(args: &ReportArgs) -> ExitCode {
    match camwright_analysis::report::write(&args.bag, args.out.as_deref()) {
        Ok(path) => {
            let _ = writeln!(io::stdout(), "report: {}", path.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {error}");
            ExitCode::from(1)
        }
    }
}

fn info(bag: &Path, json: bool) -> Result<(String, u8), camwright_bag::BagError> {
    let info = BagInfo::read(bag)?;
    Ok((if json { info.to_json() } else { info.to_text() }, 0))
}

fn check_bag(bag: &Path, json: bool) -> Result<(String, u8), camwright_bag::BagError> {
    let report = check::check(bag)?;
    let code = match report.worst() {
        None => 0,
        Some(Severity::Warning) => 1,
        Some(Severity::Error) => 2,
    };
    Ok((if json { report.to_json() } else { report.to_text() }, code))
}

fn recover_bag(bag: &Path, into: Option<&Path>, json: bool) -> Result<(String, u8), camwright_bag::BagError> {
    let into = into.map_or_else(|| recover::beside(bag), Path::to_owned);
    let recovery = recover::recover(bag, &into)?;
    let code = if recovery.is_whole() { 0 } else { 2 };
    Ok((if json { recovery.to_json() } else { recovery.to_text() }, code))
}

fn export_bag(args: &ExportArgs) -> Result<(String, u8), camwright_bag::BagError> {
    let bag = Bag::open(&args.bag)?;
    let beside = |word: &str| args.into.clone().unwrap_or_else(|| camwright_bag::named_beside(&args.bag, word));
    let copy = |preset: Preset| export::to_bag(&bag, &beside(preset.name()), preset);
    let exported = match args.to {
        Format::Csv => export::to_tables(&bag, &beside("csv"), TableFormat::Csv, args.longest)?,
        Format::Parquet => export::to_tables(&bag, &beside("parquet"), TableFormat::Parquet, args.longest)?,
        Format::Zstd => copy(Preset::Zstd)?,
        Format::ZstdFast => copy(Preset::ZstdFast)?,
        Format::ZstdSmall => copy(Preset::ZstdSmall)?,
    };
    let mut text = String::new();
    for path in &exported.paths {
        text.push_str(&format!("{}\n", path.display()));
    }
    for (topic, reason) in &exported.left_out {
        text.push_str(&format!("left out: {topic}: {reason}\n"));
    }
    text.push_str(&format!("{} messages\n", exported.messages));
    Ok((text, u8::from(!exported.left_out.is_empty())))
}
