//! `camwright plan`: plans a job without ROS and writes what came out.

use super::plan_turned;
use crate::bag_size::{BagSize, Pace};
use camwright_planning::{self as planning, AnyPrepared, BoundSummary, PassSummary, RemovalClass};
use serde::Serialize;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Most arcs of one bound in the text; `summary.json` has them all.
const MAX_ARCS: usize = 6;

/// Arguments of `camwright plan`.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct PlanArgs {
    /// Name or path of a job file
    job: String,
    /// Folder for `summary.json` and, per lobe, `contour.csv`, `tool_path.csv` and `speed_plan.csv`; of a turned part
    /// `surface.csv`, `clearance.csv` and, per pass, `insert_path.csv`
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Sets a key over the file, for example `infeed.total_mm=0.72` or `lobes.I1.phase_deg=75`
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Draws every lobe, as SVG and PNG: contour with wheel and path; X and its derivatives over C; speed, acceleration and
    /// jerk of C and X with their limits; removal rate with its bound. Colours show what sets the speed. Of a turned part: its
    /// sections with the insert, X with its limits, clearances
    #[arg(long)]
    plots: bool,
    /// Writes the summary to stdout as JSON instead of text
    #[arg(long)]
    json: bool,
}

/// Exit code 0: planned and written; 2: refused, or not written.
pub(super) fn main(args: &PlanArgs) -> ExitCode {
    let progress = |text: &str| drop(writeln!(io::stderr(), "{text}"));
    progress(&format!("planning {}", args.job));
    let telling = |path: &Path| progress(&format!("writing {}", path.display()));
    let done = planning::prepare_any(&args.job, &args.set, None).and_then(|prepared| {
        let recorded = format!("recorded {}\n", BagSize::of(&prepared, Pace::Fast).to_text());
        match prepared {
            AnyPrepared::Ground(prepared) => planning::write(&prepared, &args.out, args.plots, telling)
                .map(|summary| if args.json { as_json(&summary) } else { as_text(&summary) + &recorded }),
            AnyPrepared::Turned(prepared) => planning::write_turning(&prepared, &args.out, args.plots, telling)
                .map(|summary| if args.json { as_json(&summary) } else { plan_turned::as_text(&summary) + &recorded }),
        }
    });
    match done {
        Ok(text) => {
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

fn as_json(summary: &impl Serialize) -> String {
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
                "{name:<8} {station:<8} {:>10.3} {:<8} {:>6} {:>9.3} {:>9.3} {:>13} {:>8.3} {:>13}  {limit}\n",
                lobe.start_deg,
                pass.name,
                pass.turns,
                pass.cut_s,
                pass.max_removal_mm2_s,
                format!("{slowest:.1}-{fastest:.1}"),
                pass.turn_s,
                pass.constant_speed_turn_s.map_or_else(|| "-".into(), |turn_s| format!("{turn_s:.3}")),
            );
        }
    }
    text += &by_lobes(summary, "Q' mm2/s, share of a turn's time", removal_text);
    text += &by_lobes(summary, "what sets the speed, share of a turn's time: where, in deg of c_axis", bounds_text);
    text.push('\n');
    for lobe in &summary.lobes {
        if let Some(way) = &lobe.giving_way {
            text += &format!("{:<8} wheel and part give way {way}\n", lobe.name);
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
    if let Some(saved_s) = summary.saved_by_order_s {
        let names: Vec<&str> = summary.lobes.iter().map(|lobe| lobe.name.as_str()).collect();
        text += &format!(
            "order    {}: {saved_s:.3} s less of the table's ways than in the order written\n",
            names.join(", ")
        );
    }
    let compared = if summary.rotary_indexing {
        String::from("with rotary indexing before each lobe")
    } else {
        format!(
            "{:.3} s with rotary indexing before each lobe, {:.3} s saved",
            summary.duration_with_indexing_s, summary.saved_s
        )
    };
    let compared = compared
        + &summary.saved_by_turning_on_s.map_or_else(String::new, |saved_s| {
            format!("; {:.3} s with C stopping between lobes, {saved_s:.3} s saved", summary.duration_s + saved_s)
        });
    text + &format!("job      {:.3} s ({compared})\nplan     {}\n", summary.duration_s, summary.plan_hash)
}

/// One line for each pass of each lobe under a heading; lobes of which the same is to be said share one.
fn by_lobes(summary: &planning::Summary, heading: &str, say: impl Fn(&PassSummary) -> String) -> String {
    let mut lines: Vec<(Vec<&str>, &str, String)> = Vec::new();
    for lobe in &summary.lobes {
        for pass in &lobe.passes {
            let said = say(pass);
            match lines.iter_mut().find(|line| line.1 == pass.name && line.2 == said) {
                Some(line) => line.0.push(&lobe.name),
                None => lines.push((vec![&lobe.name], &pass.name, said)),
            }
        }
    }
    let names: Vec<String> = lines.iter().map(|line| line.0.join(" ")).collect();
    let width = names.iter().map(String::len).max().unwrap_or(0).max(8);
    let mut text = format!("\n{:<width$} {:<8} {heading}\n", "lobe", "pass");
    for (names, (_, pass, said)) in names.iter().zip(&lines) {
        text += &format!("{names:<width$} {pass:<8} {said}\n");
    }
    text
}

/// Classes in which some of the time is spent.
fn removal_text(pass: &PassSummary) -> String {
    let class = |class: &RemovalClass| match 100.0 * class.share {
        percent if percent < 0.5 => None,
        percent => Some(format!("{}-{}: {percent:.0} %", class.from_mm2_s, class.to_mm2_s)),
    };
    pass.removal_classes.iter().filter_map(class).collect::<Vec<_>>().join("  ")
}

/// Every bound with its arcs.
fn bounds_text(pass: &PassSummary) -> String {
    if pass.speed_law == "constant_work_speed" {
        return format!("constant work speed of {:.1} rpm all the way round", pass.work_speed_rpm[1]);
    }
    let bound = |bound: &BoundSummary| {
        let mut arcs: Vec<String> =
            bound.arcs_deg.iter().take(MAX_ARCS).map(|[from, to]| format!("{from:.0}-{to:.0}")).collect();
        if let Some(more @ 1..) = bound.arcs_deg.len().checked_sub(MAX_ARCS) {
            arcs.push(format!("{more} more"));
        }
        let name = bound.bound.replace("c_axis", "C").replace("x_axis", "X").replace('_', " ");
        format!("{name} {:.0} %: {}", 100.0 * bound.share, arcs.join(", "))
    };
    pass.bounds.iter().map(bound).collect::<Vec<_>>().join("; ")
}
