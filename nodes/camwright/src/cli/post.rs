//! `camwright post`: the NC program of a job, for a machine whose control reads text.

use camwright_planning::{self as planning, ProgramSummary};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `camwright post`.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct PostArgs {
    /// Name or path of a job file; left out where --eccentric says what is made
    #[arg(required_unless_present = "eccentric")]
    job: Option<String>,
    /// An eccentric disc from three figures: its eccentricity, with --diameter and --tool-radius (the job `eccentric_disc` with
    /// them)
    #[arg(long, value_name = "MM", conflicts_with = "job", requires_all = ["diameter", "tool_radius"], allow_negative_numbers = true)]
    eccentric: Option<f64>,
    /// Diameter of the disc
    #[arg(long, value_name = "MM", requires = "eccentric", allow_negative_numbers = true)]
    diameter: Option<f64>,
    /// Radius of the mill
    #[arg(long, value_name = "MM", requires = "eccentric", allow_negative_numbers = true)]
    tool_radius: Option<f64>,
    /// What the diameter is that of: the disc itself, or the largest one of the part as it turns
    #[arg(long, value_name = "WHAT", requires = "eccentric", value_parser = ["disc", "largest"], default_value = "disc")]
    diameter_is: String,
    /// Folder for the program's files, `summary.json`, and for every cam its segments and drawings (SVG and PNG)
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Sets a key over the file, for example `nc.control=fanuc` (linuxcnc, fanuc, siemens), `nc.finish_tolerance_um=1` or
    /// `nc.x_values=diameter`
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Writes the summary to stdout as JSON instead of text
    #[arg(long)]
    json: bool,
}

/// Exit code 0: made, written, read back and within its tolerances; 2: refused, or not written.
pub(super) fn main(args: &PostArgs) -> ExitCode {
    let progress = |text: &str| drop(writeln!(io::stderr(), "{text}"));
    let (job, set) = asked(args);
    progress(&format!("planning {job}"));
    let telling = |path: &Path| progress(&format!("writing {}", path.display()));
    match planning::write_program(job, &set, &args.out, telling) {
        Ok(summary) => {
            let text = if args.json {
                serde_json::to_string_pretty(&summary).unwrap_or_default()
            } else {
                as_text(&summary, &args.out)
            };
            // A reader that went away (`| head`) is no failure of ours.
            let _ = writeln!(io::stdout(), "{}", text.trim_end());
            ExitCode::SUCCESS
        }
        Err(error) => {
            progress(&format!("error: {error}"));
            ExitCode::from(2)
        }
    }
}

/// The job with what is set over it: the eccentric's figures first.
fn asked(args: &PostArgs) -> (&str, Vec<String>) {
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

fn as_text(summary: &ProgramSummary, out: &Path) -> String {
    let width = summary.turns.iter().map(|turn| turn.feature.len()).max().unwrap_or(0).max(3);
    let mut text = format!(
        "{:<width$} {:<16} {:>5} {:>6} {:>8} {:>7} {:>12} {:>8} {:>14} {:>16} {:>9} {:>8}\n",
        "cam",
        "pass",
        "calls",
        "blocks",
        "segments",
        "theory",
        "tolerance um",
        "error um",
        "at C deg",
        "velocity mm/s",
        "blocks/s",
        "call s"
    );
    for turn in &summary.turns {
        text += &format!(
            "{:<width$} {:<16} {:>5} {:>6} {:>8} {:>7.1} {:>12.3} {:>8.4} {:>14} {:>16} {:>9.1} {:>8.3}\n",
            turn.feature,
            turn.pass,
            turn.calls,
            turn.blocks,
            turn.segments,
            turn.theoretical_segments,
            turn.tolerance_um,
            turn.error_um,
            format!("{:.2} ({})", turn.error_at_deg, turn.error_axis),
            format!("{:.3} steps", turn.velocity_step_mm_s),
            turn.blocks_s,
            turn.time_s,
        );
    }
    let back = &summary.read_back;
    text += &format!(
        "\nprogram  {}: {} lines, {} calls, {:.3} s of feeds\nread     back from {}: {} motions, {:.4} um off the paths at most, {:.1} % of the \
         tolerance, times right to {:.1e} s\n",
        summary.files.join(", "),
        summary.lines,
        summary.calls,
        summary.feed_time_s,
        out.display(),
        back.moves,
        back.error_um,
        100.0 * back.share_of_tolerance,
        back.time_error_s,
    );
    for note in &summary.notes {
        text += &format!("note     {note}\n");
    }
    text
}
