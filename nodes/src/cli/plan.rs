//! `camwright plan`: plans a job without ROS and writes what came out.

use crate::planning;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `camwright plan`.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct PlanArgs {
    /// Name or path of a job file
    job: String,
    /// Folder for `summary.json` and, per lobe, `contour.csv`, `tool_path.csv` and `speed_plan.csv`
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Sets a key over the file, for example `infeed.total_mm=0.72` or `lobes.I1.phase_deg=75`
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Writes the summary to stdout as JSON instead of text
    #[arg(long)]
    json: bool,
}

/// Exit code 0: planned and written; 2: refused, or not written.
pub(super) fn main(args: &PlanArgs) -> ExitCode {
    let progress = |text: &str| drop(writeln!(io::stderr(), "{text}"));
    progress(&format!("planning {}", args.job));
    let done = planning::prepare(&args.job, &args.set, None).and_then(|prepared| {
        planning::write(&prepared, &args.out, |path| progress(&format!("writing {}", path.display())))?;
        Ok(planning::summary(&prepared))
    });
    match done {
        Ok(summary) => {
            let text = if args.json { as_json(&summary) } else { as_text(&summary) };
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

fn as_json(summary: &planning::Summary) -> String {
    serde_json::to_string_pretty(summary).unwrap_or_default()
}

fn as_text(summary: &planning::Summary) -> String {
    let mut text = format!(
        "{:<8} {:<8} {:>10} {:<8} {:>6} {:>9} {:>9} {:>13} {:>8} {:>13}  {}\n",
        "lobe",
        "station",
        "start deg",
        "pass",
        "turns",
        "cut s",
        "Q' mm2/s",
        "rpm",
        "turn s",
        "const. rpm s",
        "limit used most"
    );
    for lobe in &summary.lobes {
        for (number, pass) in lobe.passes.iter().enumerate() {
            let (name, station) = if number == 0 { (&*lobe.name, &*lobe.station) } else { ("", "") };
            let tightest = pass.limits.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio));
            let limit = tightest.map_or_else(String::new, |limit| {
                let percent = 100.0 * limit.ratio;
                format!("{} of {} at {:.1} deg, {percent:.1} %", limit.quantity, limit.axis, limit.cam_angle_deg)
            });
            let [slowest, fastest] = pass.work_speed_rpm;
            text += &format!(
                "{name:<8} {station:<8} {:>10.3} {:<8} {:>6} {:>9.3} {:>9.3} {:>13} {:>8.3} {:>13.3}  {limit}\n",
                lobe.start_deg,
                pass.name,
                pass.turns,
                pass.cut_s,
                pass.max_removal_mm2_s,
                format!("{slowest:.1}-{fastest:.1}"),
                pass.turn_s,
                pass.constant_speed_turn_s
            );
        }
    }
    for dress in &summary.dresses {
        text += &format!("{dress}\n");
    }
    for lift in &summary.lifts {
        for reading in &lift.readings {
            text += &format!("lift {:<8} {reading}\n", lift.profile);
        }
    }
    let compared = if summary.rotary_indexing {
        String::from("with rotary indexing before each lobe")
    } else {
        format!(
            "{:.3} s with rotary indexing before each lobe, {:.3} s saved",
            summary.duration_with_indexing_s, summary.saved_s
        )
    };
    text + &format!("job      {:.3} s ({compared})\nplan     {}\n", summary.duration_s, summary.plan_hash)
}
