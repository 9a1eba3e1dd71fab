// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright plan`: plans a job without ROS and writes its paths.

use super::output::{VerdictLevel, print_error, print_verdict, print_warnings, say, wrapped};
use super::plan_turned;
use crate::bag_size::BagSize;
use camwright_machine_cycle::pacing::Pace;
use camwright_planning::{
    self as planning, AnyPrepared, BoundSummary, PassSummary, PlanningStage, RemovalClass, Timings,
};
use serde::Serialize;
use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Maximum number of arcs of one bound in the text; `summary.json` holds all.
const MAX_ARCS: usize = 6;

/// Arguments of `camwright plan`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = super::help::PLAN)]
pub(super) struct PlanArgs {
    /// Name or path of a job file
    job: String,
    /// Folder for the files
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Set a key of the job, such as `lobes.I1.phase_deg=75`; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Draw contours, paths, speeds and limits as SVG and PNG, with an index.html
    #[arg(long)]
    plots: bool,
    /// Print the summary as JSON instead of text
    #[arg(long)]
    json: bool,
    /// Print the time of each stage from file to plan hash
    #[arg(long, conflicts_with = "json")]
    timings: bool,
    /// Print all results: times, speed limits, removal rates, deflection, lift tables
    #[arg(long)]
    details: bool,
}

/// Exit code 0: planned and written; 2: rejected, or not written.
pub(super) fn main(args: &PlanArgs) -> ExitCode {
    let files = Cell::new(0_usize);
    let count = |_: &Path| files.set(files.get() + 1);
    let timings = Timings::start();
    let prepared = planning::prepare_any_timed(&args.job, &args.set, None, &timings);
    let stages = timings.stages();
    let done = prepared.and_then(|prepared| {
        print_warnings(&prepared);
        let recorded = format!("recorded {}\n", BagSize::estimate(&prepared, Pace::Fast).to_text());
        let with_details =
            |text: String, details: String| if args.details { text + &details + &recorded } else { text };
        match prepared {
            AnyPrepared::Ground(prepared) => {
                let summary = planning::write(&prepared, &args.out, args.plots, count)?;
                Ok(if args.json { as_json(&summary) } else { with_details(as_text(&summary), details(&summary)) })
            }
            AnyPrepared::Turned(prepared) => {
                let summary = planning::write_turning(&prepared, &args.out, args.plots, count)?;
                let (text, details) = (plan_turned::as_text(&summary), plan_turned::details(&summary));
                Ok(if args.json { as_json(&summary) } else { with_details(text, details) })
            }
        }
    });
    match done {
        Ok(text) if args.json => {
            say!("{text}");
            ExitCode::SUCCESS
        }
        Ok(text) => {
            print_verdict(VerdictLevel::Good, &wrapped(text.trim_end(), 2));
            say!("files:  {} in {}", files.get(), args.out.display());
            if args.plots {
                say!("plots:  {}", args.out.join("index.html").display());
            }
            if args.timings {
                say!("{}", timings_text(&stages).trim_end());
            }
            ExitCode::SUCCESS
        }
        Err(error) => {
            print_error("error", &error);
            ExitCode::from(2)
        }
    }
}

/// One line for each stage, and their sum.
fn timings_text(stages: &[(PlanningStage, Duration)]) -> String {
    let line = |name: &str, time: Duration| format!("{name:<8} {:>10.4}\n", time.as_secs_f64());
    let mut text = format!("{:<8} {:>10}\n", "stage", "s");
    for (stage, time) in stages {
        text += &line(stage.name(), *time);
    }
    text + &line("total", stages.iter().map(|(_, time)| *time).sum())
}

fn as_json(summary: &impl Serialize) -> String {
    serde_json::to_string_pretty(summary).unwrap_or_default()
}

/// Verdict and one line for each pass of each lobe.
fn as_text(summary: &planning::Summary) -> String {
    let mut text = format!(
        "PLANNED: {}, {}, {:.3} s, plan {:.12}\n",
        summary.job,
        planning::lobe_count(summary.lobes.len()),
        summary.duration_s,
        summary.plan_hash
    );
    let width = summary.lobes.iter().map(|lobe| lobe.name.chars().count()).max().unwrap_or(0).max(4);
    text += &format!(
        "{:<width$} {:<8} {:>5} {:>8} {:>8} {:>11}  {}\n",
        "lobe", "pass", "turns", "cut s", "Q' mm2/s", "rpm", "highest limit use"
    );
    for lobe in &summary.lobes {
        for (number, pass) in lobe.passes.iter().enumerate() {
            let name = if number == 0 { &*lobe.name } else { "" };
            let highest = pass.limits.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio));
            let limit = highest.map_or_else(String::new, |limit| {
                format!("{:.1} % {} {}", 100.0 * limit.ratio, limit.axis, limit.quantity)
            });
            let [slowest, fastest] = pass.work_speed_rpm;
            text += &format!(
                "{name:<width$} {:<8} {:>5} {:>8.3} {:>8.3} {:>11}  {limit}\n",
                pass.name,
                pass.turns,
                pass.cut_s,
                pass.max_removal_mm2_s,
                format!("{slowest:.1}-{fastest:.1}"),
            );
        }
    }
    for change in &summary.wheel_changes {
        text += &format!("{change}\n");
    }
    for dress in &summary.dresses {
        text += &format!("{dress}\n");
    }
    text
}

/// Times, limits, removal rates, deflection and lift tables.
fn details(summary: &planning::Summary) -> String {
    let mut text = format!(
        "\n{:<8} {:<8} {:<8} {:>9} {:>8} {:>13}  {}\n",
        "lobe", "station", "pass", "start deg", "turn s", "const. rpm s", "limit at"
    );
    for lobe in &summary.lobes {
        for pass in &lobe.passes {
            let highest = pass.limits.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio));
            text += &format!(
                "{:<8} {:<8} {:<8} {:>9.3} {:>8.3} {:>13}  {}\n",
                lobe.name,
                lobe.station,
                pass.name,
                lobe.start_deg,
                pass.turn_s,
                pass.constant_speed_turn_s.map_or_else(|| "-".into(), |turn_s| format!("{turn_s:.3}")),
                highest.map_or_else(String::new, |limit| format!("{:.1} deg", limit.cam_angle_deg)),
            );
        }
    }
    text += &by_lobes(summary, "Q' mm2/s, share of a turn's time", removal_text);
    text += &by_lobes(summary, "limits of the speed, share of a turn's time: C angles (deg)", bounds_text);
    text.push('\n');
    for lobe in &summary.lobes {
        if let Some(plunge) = &lobe.plunge {
            text += &format!("plunge {}: {plunge}\n", lobe.name);
        }
    }
    for lobe in &summary.lobes {
        if let Some(shape) = &lobe.shape {
            text += &format!("shape {}: {shape}\n", lobe.name);
        }
    }
    for lobe in &summary.lobes {
        if let Some(deflection) = &lobe.giving_way {
            text += &format!("deflection {}: {deflection}\n", lobe.name);
        }
    }
    for lobe in &summary.lobes {
        if let Some(finishing) = &lobe.finishing {
            text += &format!("finishing {}: {finishing}\n", lobe.name);
        }
    }
    for lobe in &summary.lobes {
        if let Some(support) = &lobe.part_support {
            text += &format!("support {}: {support}\n", lobe.name);
        }
    }
    for line in &summary.support_order {
        text += &format!("support: {line}\n");
    }
    for lift in &summary.lifts {
        for line in lift.texts() {
            text += &format!("{line}\n");
        }
    }
    if let Some(saved_s) = summary.saved_by_order_s {
        let names: Vec<&str> = summary.lobes.iter().map(|lobe| lobe.name.as_str()).collect();
        text += &format!("order {}: saves {saved_s:.3} s of table motion\n", names.join(", "));
    }
    if summary.rotary_indexing {
        text += "time with rotary indexing before each lobe\n";
    } else {
        text += &format!(
            "with rotary indexing before each lobe: {:.3} s, {:.3} s saved\n",
            summary.duration_with_indexing_s, summary.saved_s
        );
    }
    if let Some(saved_s) = summary.saved_by_turning_on_s {
        let stops_s = summary.duration_s + saved_s;
        text += &format!("with C stopping between lobes: {stops_s:.3} s, {saved_s:.3} s saved\n");
    }
    text + &format!("plan hash {}\n", summary.plan_hash)
}

/// One line for each pass of each lobe under a heading; lobes with the same text share a line.
fn by_lobes(summary: &planning::Summary, heading: &str, describe: impl Fn(&PassSummary) -> String) -> String {
    let mut lines: Vec<(Vec<&str>, &str, String)> = Vec::new();
    for lobe in &summary.lobes {
        for pass in &lobe.passes {
            let text = describe(pass);
            match lines.iter_mut().find(|line| line.1 == pass.name && line.2 == text) {
                Some(line) => line.0.push(&lobe.name),
                None => lines.push((vec![&lobe.name], &pass.name, text)),
            }
        }
    }
    let names: Vec<String> = lines.iter().map(|line| line.0.join(" ")).collect();
    let width = names.iter().map(String::len).max().unwrap_or(0).max(8);
    let mut text = format!("\n{:<width$} {:<8} {heading}\n", "lobe", "pass");
    for (names, (_, pass, line)) in names.iter().zip(&lines) {
        text += &format!("{names:<width$} {pass:<8} {line}\n");
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
        return format!("constant work speed of {:.1} rpm over the whole turn", pass.work_speed_rpm[1]);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timings_are_a_line_for_each_stage_and_their_sum() {
        let stages =
            [(PlanningStage::Read, Duration::from_micros(1500)), (PlanningStage::Hash, Duration::from_micros(500))];
        assert_eq!(
            timings_text(&stages),
            "stage             s\nread         0.0015\nhash         0.0005\ntotal        0.0020\n"
        );
    }
}
