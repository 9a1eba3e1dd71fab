// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright trace`: shows where a commanded position comes from.

use super::output::{VerdictLevel, print_error, print_verdict, print_warnings, say, whole_number};
use camwright_planning::{self as planning, TraceRequest};
use std::process::ExitCode;

/// Arguments of `camwright trace`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = super::help::TRACE)]
pub(super) struct TraceArgs {
    /// Name or path of a job file
    job: String,
    /// Lobe of the job
    #[arg(long, value_name = "LOBE")]
    lobe: String,
    /// Angle of the headstock in degrees
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = angle)]
    c: f64,
    /// Pass over the lobe [default: the last one]
    #[arg(long, value_name = "PASS")]
    pass: Option<String>,
    /// Turn of the pass, from 1
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = turn)]
    turn: u32,
    /// Set a key of the job, such as `lobes.I1.phase_deg=75`; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

fn angle(text: &str) -> Result<f64, String> {
    let value = text.trim().parse().ok().filter(|deg: &f64| (-360.0..=360.0).contains(deg));
    value.ok_or_else(|| "it must be an angle from -360 to 360 degrees".to_owned())
}

fn turn(text: &str) -> Result<u32, String> {
    whole_number(text, 1..=1_000_000)
}

/// Exit code 0: traced; 2: rejected.
pub(super) fn main(args: &TraceArgs) -> ExitCode {
    let request = TraceRequest { lobe: args.lobe.clone(), pass: args.pass.clone(), turn: args.turn, c_deg: args.c };
    let prepared = match planning::prepare_any(&args.job, &args.set, None) {
        Ok(prepared) => prepared,
        Err(error) => {
            print_error("error", &error);
            return ExitCode::from(2);
        }
    };
    print_warnings(&prepared);
    match planning::trace(&prepared, &request) {
        Ok(trace) if args.json => {
            say!("{}", serde_json::to_string_pretty(&trace).unwrap_or_default());
            ExitCode::SUCCESS
        }
        Ok(trace) => {
            print_verdict(VerdictLevel::Good, &format!("TRACED: {}\n{trace}", trace.job));
            ExitCode::SUCCESS
        }
        Err(error) => {
            print_error("error", &error);
            ExitCode::from(2)
        }
    }
}
