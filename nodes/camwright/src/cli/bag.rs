// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright bag info`, `check`, `report`, `recover` and `export`.

use super::help;
use super::output::{VerdictLevel, print_error, print_verdict, say, wrapped};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use camwright_bag::check::{self, BagSeverity};
use camwright_bag::export::TableFormat;
use camwright_bag::info::BagInfo;
use camwright_bag::recover;
use camwright_bag::{Bag, Preset, export};

/// Arguments of `camwright bag`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = help::BAG)]
pub struct BagArgs {
    /// Subcommand
    #[command(subcommand)]
    pub command: BagCommand,
}

/// Subcommands of `camwright bag`.
#[derive(Debug, Clone, clap::Subcommand)]
pub enum BagCommand {
    /// List topics, counts and times of a bag
    #[command(after_help = help::BAG_INFO)]
    Info(InfoArgs),
    /// Check structure, check sums, order and metadata.yaml of a bag
    #[command(after_help = help::BAG_CHECK)]
    Check(BagPath),
    /// Write the HTML report of a run: verdict, worst place, cause
    #[command(after_help = help::BAG_REPORT)]
    Report(ReportArgs),
    /// Write the intact part of a damaged bag to a new bag
    #[command(after_help = help::BAG_RECOVER)]
    Recover(RecoverArgs),
    /// Export a bag to CSV or Parquet tables, or compress it
    #[command(after_help = help::BAG_EXPORT)]
    Export(ExportArgs),
}

/// Arguments of `camwright bag export`.
#[derive(Debug, Clone, clap::Args)]
pub struct ExportArgs {
    /// Directory of the bag, or one MCAP file
    pub bag: PathBuf,
    /// Format of the export
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    pub to: Format,
    /// New directory [default: beside the bag, with `_csv`, `_parquet`, …]
    #[arg(long, value_name = "DIR")]
    pub into: Option<PathBuf>,
    /// Longest array that gets a column per element
    #[arg(long, default_value_t = 64, value_name = "N")]
    pub longest: usize,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// Format of an export.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// One CSV table per topic
    Csv,
    /// One Parquet table per topic, with typed columns
    Parquet,
    /// The same bag with compressed chunks
    Zstd,
    /// The same bag, compressed fast
    #[value(name = "zstd_fast")]
    ZstdFast,
    /// The same bag, compressed small
    #[value(name = "zstd_small")]
    ZstdSmall,
}

/// Arguments of `camwright bag recover`.
#[derive(Debug, Clone, clap::Args)]
pub struct RecoverArgs {
    /// The damaged bag
    #[command(flatten)]
    pub bag: BagPath,
    /// New directory [default: beside the bag, with `_recovered`]
    #[arg(long, value_name = "DIR")]
    pub into: Option<PathBuf>,
}

/// Arguments of `camwright bag report`.
#[derive(Debug, Clone, clap::Args)]
pub struct ReportArgs {
    /// Directory of the bag, or one MCAP file
    pub bag: PathBuf,
    /// File of the report [default: `report.html` in the bag's directory]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `camwright bag info`.
#[derive(Debug, Clone, clap::Args)]
pub struct InfoArgs {
    /// The bag
    #[command(flatten)]
    pub bag: BagPath,
    /// Also list types, files and everything the recorder wrote
    #[arg(long)]
    pub details: bool,
}

/// A bag, and the format of the output.
#[derive(Debug, Clone, clap::Args)]
pub struct BagPath {
    /// Directory of the bag, or one MCAP file
    pub bag: PathBuf,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// Runs `camwright bag …`. Exit code 0: done, or clean; 1: warnings; 2: errors in the bag, or no bag.
#[must_use]
pub fn run(args: &BagArgs) -> ExitCode {
    let outcome = match &args.command {
        BagCommand::Info(args) => info(&args.bag.bag, args.bag.json, args.details),
        BagCommand::Check(path) => check_bag(&path.bag, path.json),
        BagCommand::Export(args) => export_bag(args),
        BagCommand::Recover(RecoverArgs { bag: path, into }) => recover_bag(&path.bag, into.as_deref(), path.json),
        BagCommand::Report(args) => return report(args),
    };
    let failed = if matches!(args.command, BagCommand::Recover(_)) { 1 } else { 2 };
    match outcome {
        Ok(BagResult { text, level, code }) => {
            match level {
                Some(level) => print_verdict(level, text.trim_end()),
                None => say!("{}", text.trim_end()),
            }
            ExitCode::from(code)
        }
        Err(error) => {
            print_error("error", &error);
            ExitCode::from(failed)
        }
    }
}

/// Result of a subcommand.
struct BagResult {
    text: String,
    /// None for JSON.
    level: Option<VerdictLevel>,
    code: u8,
}

impl BagResult {
    /// Text with a verdict, or JSON.
    fn new(
        is_json: bool,
        json: impl FnOnce() -> String,
        text: impl FnOnce() -> String,
        level: VerdictLevel,
        code: u8,
    ) -> Self {
        match is_json {
            true => Self { text: json(), level: None, code },
            false => Self { text: text(), level: Some(level), code },
        }
    }
}

fn report(args: &ReportArgs) -> ExitCode {
    match camwright_analysis::report::write(&args.bag, args.out.as_deref(), None) {
        Ok(path) => {
            match args.json {
                true => say!("{}", json!({ "report": path })),
                false => say!("report: {}", path.display()),
            }
            ExitCode::SUCCESS
        }
        Err(error) => {
            print_error("error", &error);
            ExitCode::from(1)
        }
    }
}

fn info(bag: &Path, json: bool, details: bool) -> Result<BagResult, camwright_bag::BagError> {
    let info = BagInfo::read(bag)?;
    let text = info.to_text(details);
    let level = match info.is_closed {
        false => VerdictLevel::Bad,
        true if text.starts_with("COMPLETE") || text.starts_with("CLOSED") => VerdictLevel::Good,
        true => VerdictLevel::Warning,
    };
    Ok(BagResult::new(json, || info.to_json(), || text, level, 0))
}

fn check_bag(bag: &Path, json: bool) -> Result<BagResult, camwright_bag::BagError> {
    let report = check::check(bag)?;
    let (level, code) = match report.worst() {
        None => (VerdictLevel::Good, 0),
        Some(BagSeverity::Warning) => (VerdictLevel::Warning, 1),
        Some(BagSeverity::Error) => (VerdictLevel::Bad, 2),
    };
    Ok(BagResult::new(json, || report.to_json(), || wrapped(&report.to_text(), 2), level, code))
}

fn recover_bag(bag: &Path, into: Option<&Path>, json: bool) -> Result<BagResult, camwright_bag::BagError> {
    let into = into.map_or_else(|| recover::beside(bag), Path::to_owned);
    let recovery = recover::recover(bag, &into)?;
    let code = if recovery.is_whole() { 0 } else { 2 };
    Ok(BagResult::new(
        json,
        || recovery.to_json(),
        || wrapped(&recovery.to_text(), 2),
        VerdictLevel::from_code(code),
        code,
    ))
}

fn export_bag(args: &ExportArgs) -> Result<BagResult, camwright_bag::BagError> {
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
    let verdict = if exported.left_out.is_empty() { "EXPORTED" } else { "INCOMPLETE" };
    let mut text = format!("{verdict}: {} messages, {} files\n", exported.messages, exported.paths.len());
    for (topic, reason) in &exported.left_out {
        text.push_str(&wrapped(&format!("not exported: {topic}: {reason}"), 2));
        text.push('\n');
    }
    for path in &exported.paths {
        text.push_str(&format!("{}\n", path.display()));
    }
    let json = || {
        let missing: serde_json::Map<String, serde_json::Value> =
            exported.left_out.iter().map(|(topic, reason)| (topic.clone(), reason.as_str().into())).collect();
        json!({ "messages": exported.messages, "files": exported.paths, "not_exported": missing }).to_string()
    };
    let code = u8::from(!exported.left_out.is_empty());
    Ok(BagResult::new(args.json, json, || text, VerdictLevel::from_code(code), code))
}
