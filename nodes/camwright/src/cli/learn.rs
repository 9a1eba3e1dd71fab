// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright learn`: corrects the next part by the reports of a measuring machine.

use super::init::write_new;
use super::output::{VerdictLevel, print_error, print_verdict, say};
use camwright_files::gauge_report_file::{self, ReportFormat};
use camwright_files::{job_file, locate::Located};
use camwright_planning::{self as planning, AnyPrepared, LobeReport, PreparedJob, ReportedLobe};
use clap::ValueEnum;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `camwright learn`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = super::help::LEARN)]
pub(super) struct LearnArgs {
    /// Name or path of the job file with which the measured part was ground
    job: String,
    /// Lobe and its report; repeatable
    #[arg(long = "report", value_name = "LOBE=FILE", required = true, value_parser = report)]
    reports: Vec<(String, String)>,
    /// Columns of the reports [default: their header]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    columns: Option<Vec<String>>,
    /// Numbers have a decimal comma
    #[arg(long)]
    decimal_comma: bool,
    /// Angles of the reports count against the cam angle
    #[arg(long)]
    mirrored: bool,
    /// Deviations are positive where material is missing
    #[arg(long)]
    positive_inward: bool,
    /// Errors of the mounting in the gauge, removed before learning
    #[arg(long, value_name = "ERRORS", value_delimiter = ',')]
    align: Vec<Align>,
    /// Set a key of the job, such as `form_compensation.gain=0.5`; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// New job file with the corrections
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

/// Error of the mounting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Align {
    Size,
    Eccentricity,
    Phase,
}

fn report(text: &str) -> Result<(String, String), String> {
    let parts = text.split_once('=').filter(|(lobe, file)| !lobe.is_empty() && !file.is_empty());
    let (lobe, file) = parts.ok_or_else(|| "it must be LOBE=FILE, such as I1=gauge_I1.csv".to_owned())?;
    Ok((lobe.to_owned(), file.to_owned()))
}

/// Exit code 0: written; 2: rejected.
pub(super) fn main(args: &LearnArgs) -> ExitCode {
    match learn(args) {
        Ok(lobes) if args.json => {
            let out = args.out.display().to_string();
            let report = serde_json::json!({ "job": out, "lobes": lobes });
            say!("{report:#}");
            ExitCode::SUCCESS
        }
        Ok(lobes) => {
            let lines: Vec<String> = lobes.iter().map(|lobe| lines(lobe, &args.align)).collect();
            let out = args.out.display();
            print_verdict(
                VerdictLevel::Good,
                &format!("LEARNED: {out}\n{}next      camwright run {out}", lines.concat()),
            );
            ExitCode::SUCCESS
        }
        Err(errors) => {
            errors.iter().for_each(|error| print_error("error", error));
            ExitCode::from(2)
        }
    }
}

fn learn(args: &LearnArgs) -> Result<Vec<ReportedLobe>, Vec<String>> {
    let all = |errors: Vec<camwright_files::ConfigError>| errors.iter().map(ToString::to_string).collect::<Vec<_>>();
    let prepare = |set: &[String]| -> Result<Box<PreparedJob>, Vec<String>> {
        match planning::prepare_any(&args.job, set, None).map_err(|error| vec![error.to_string()])? {
            AnyPrepared::Ground(prepared) => Ok(prepared),
            AnyPrepared::Turned(turned) => {
                Err(vec![format!("{} turns a part; only lobes that are ground learn", turned.job.spec.name)])
            }
        }
    };
    let prepared = prepare(&args.set)?;
    let format = ReportFormat {
        columns: args.columns.clone(),
        decimal_comma: args.decimal_comma,
        mirrored: args.mirrored,
        positive_inward: args.positive_inward,
    };
    let mut reports = Vec::new();
    let mut errors = Vec::new();
    for (lobe, file) in &args.reports {
        match gauge_report_file::read(file, &format) {
            Ok(table) => reports.push(LobeReport { lobe: lobe.clone(), file: file.clone(), table }),
            Err(found) => errors.extend(all(found)),
        }
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let aligned = |error| args.align.contains(&error);
    let alignment = planning::Alignment {
        size: aligned(Align::Size),
        eccentricity: aligned(Align::Eccentricity),
        phase: aligned(Align::Phase),
    };
    let learned = planning::learn_reports(&prepared, &reports, alignment).map_err(|error| vec![error])?;
    let set: Vec<String> = args.set.iter().cloned().chain([learned.override_text]).collect();
    let text = &prepare(&set)?.job.source;
    // The new file names tables as the old one does: they must be found from its folder too.
    if let Err(error) = job_file::parse(&Located::new(&args.out, text.clone()), &[]) {
        let hint = "name a file beside the job with --out, so that its tables are found";
        return Err(vec![format!("{error}\n{hint}")]);
    }
    write_new(&args.out, text).map_err(|error| vec![error])?;
    Ok(learned.lobes)
}

/// Lines of one lobe.
fn lines(lobe: &ReportedLobe, align: &[Align]) -> String {
    let phase = lobe.phase_deg.map_or("not separable from eccentricity".to_owned(), |deg| format!("{deg:+.4} deg"));
    let names: Vec<String> =
        align.iter().filter_map(|error| error.to_possible_value()).map(|value| value.get_name().to_owned()).collect();
    let removed = if names.is_empty() {
        String::new()
    } else {
        format!("          without {}: up to {:.3} um\n", names.join(", "), lobe.aligned_largest_um)
    };
    let bounded = if lobe.is_bounded { ", bounded by most_um or most_um_per_deg" } else { "" };
    format!(
        "lobe {:<4} {} values, deviation up to {:.3} um; size {:+.3} um, eccentricity {:.3} um at {:.1} deg, phase {phase}\n{removed}          \
         form error {:.3} um rms; the next part is corrected by up to {:.3} um{bounded}\n",
        lobe.lobe,
        lobe.values,
        lobe.largest_um,
        lobe.size_um,
        lobe.eccentricity_um,
        lobe.eccentricity_at_deg,
        lobe.error_rms_um,
        lobe.correction_um,
    )
}
