// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright post`: writes the NC program of a job and verifies it.

use super::output::{VerdictLevel, print_error, print_verdict, say, wrapped};
use camwright_planning::{self as planning, ProgramSummary};
use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `camwright post`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = super::help::POST)]
pub(super) struct PostArgs {
    /// Name or path of a job file; not with --eccentric
    #[arg(required_unless_present = "eccentric")]
    job: Option<String>,
    /// Eccentricity of an eccentric disc, with --diameter and --tool-radius (job `eccentric_disc`)
    #[arg(long, value_name = "MM", conflicts_with = "job", requires_all = ["diameter", "tool_radius"], allow_negative_numbers = true)]
    eccentric: Option<f64>,
    /// Diameter of the disc
    #[arg(long, value_name = "MM", requires = "eccentric", allow_negative_numbers = true)]
    diameter: Option<f64>,
    /// Radius of the mill
    #[arg(long, value_name = "MM", requires = "eccentric", allow_negative_numbers = true)]
    tool_radius: Option<f64>,
    /// Meaning of the diameter: of the disc, or the largest of the turning part
    #[arg(long, value_name = "WHAT", requires = "eccentric", value_parser = ["disc", "largest"], default_value = "disc")]
    diameter_is: String,
    /// Folder for program, summary.json, segments and drawings
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Set a key of the job, such as `nc.control=fanuc` (linuxcnc, fanuc, siemens); repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Print the summary as JSON instead of text
    #[arg(long)]
    json: bool,
    /// Print segments and block rates too
    #[arg(long)]
    details: bool,
}

/// Exit code 0: written and verified; 2: rejected, or not written.
pub(super) fn main(args: &PostArgs) -> ExitCode {
    let (job, set) = job_and_overrides(args);
    let files = Cell::new(0_usize);
    match planning::write_program(job, &set, &args.out, |_: &Path| files.set(files.get() + 1)) {
        Ok(summary) if args.json => {
            say!("{}", serde_json::to_string_pretty(&summary).unwrap_or_default());
            ExitCode::SUCCESS
        }
        Ok(summary) => {
            let text = if args.details { as_text(&summary) + &details(&summary) } else { as_text(&summary) };
            print_verdict(VerdictLevel::Good, &wrapped(text.trim_end(), 2));
            say!("files:   {} in {}", files.get(), args.out.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            print_error("error", &error);
            ExitCode::from(2)
        }
    }
}

/// Job and its overrides, the figures of the eccentric first.
fn job_and_overrides(args: &PostArgs) -> (&str, Vec<String>) {
    let figures = [
        ("profiles.disc.lift.eccentric.eccentricity_mm", args.eccentric),
        ("profiles.disc.lift.eccentric.diameter_mm", args.diameter),
        ("tool.radius_mm", args.tool_radius),
    ];
    let mut set: Vec<String> =
        figures.into_iter().filter_map(|(key, value)| Some(format!("{key}={}", value?))).collect();
    if args.eccentric.is_some() {
        set.push(format!("profiles.disc.lift.eccentric.diameter_is={}", args.diameter_is));
        let text = args.tool_radius.map_or_else(String::new, |radius_mm| format!("mill radius {radius_mm} mm"));
        set.push(format!("tool.text={text}"));
    }
    set.extend(args.set.iter().cloned());
    (args.job.as_deref().unwrap_or("eccentric_disc"), set)
}

/// Verdict, one line for each pass of each cam, and the notes.
fn as_text(summary: &ProgramSummary) -> String {
    let back = &summary.read_back;
    let mut text = format!(
        "VERIFIED: largest path error {:.4} um, {:.1} % of its tolerance\n",
        back.error_um,
        100.0 * back.share_of_tolerance
    );
    let width = summary.turns.iter().map(|turn| turn.feature.len()).max().unwrap_or(0).max(3);
    let pass_width = summary.turns.iter().map(|turn| turn.pass.len()).max().unwrap_or(0).max(4);
    text += &format!(
        "{:<width$} {:<pass_width$} {:>5} {:>6} {:>8} {:>12} {:>13} {:>7}\n",
        "cam", "pass", "calls", "blocks", "error um", "tolerance um", "at C deg", "call s"
    );
    for turn in &summary.turns {
        text += &format!(
            "{:<width$} {:<pass_width$} {:>5} {:>6} {:>8.4} {:>12.3} {:>13} {:>7.3}\n",
            turn.feature,
            turn.pass,
            turn.calls,
            turn.blocks,
            turn.error_um,
            turn.tolerance_um,
            format!("{:.2} ({})", turn.error_at_deg, turn.error_axis),
            turn.time_s,
        );
    }
    for note in &summary.notes {
        text += &format!("note:    {note}\n");
    }
    text + &format!(
        "program: {}: {} lines, {} calls, {:.3} s of feeds\n",
        summary.files.join(", "),
        summary.lines,
        summary.calls,
        summary.feed_time_s
    )
}

/// Segments and block rates of each pass, and the comparison with the program as it was read back.
fn details(summary: &ProgramSummary) -> String {
    let width = summary.turns.iter().map(|turn| turn.feature.len()).max().unwrap_or(0).max(3);
    let mut text = format!(
        "\n{:<width$} {:<16} {:>8} {:>8} {:>22} {:>9}\n",
        "cam", "pass", "segments", "theory", "velocity step mm/s", "blocks/s"
    );
    for turn in &summary.turns {
        text += &format!(
            "{:<width$} {:<16} {:>8} {:>8.1} {:>22.3} {:>9.1}\n",
            turn.feature, turn.pass, turn.segments, turn.theoretical_segments, turn.velocity_step_mm_s, turn.blocks_s,
        );
    }
    let back = &summary.read_back;
    text + &format!("\nread back: {} motions, largest time error {:.1e} s\n", back.moves, back.time_error_s)
}
