// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright drives`: form error by each drive of a lathe, and the gain that keeps the tolerance.

use super::output::{VerdictLevel, print_error, print_verdict, say, wrapped};
use camwright::math::units::{TURN_RAD, mm_from_um, um_from_mm};
use camwright::simulation::lathe_drives::{
    Drives, DrivesForm, DrivesResult, FeedForward, GainSearch, GainTrial, MinimumGain, TurningDrives,
};
use camwright_bag::progress;
use camwright_files::any_job::{self, AnyJob};
use camwright_planning::{self as planning, PreparedTurning};
use serde_json::{Value, json};
use std::process::ExitCode;

/// Arguments of `camwright drives`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = super::help::DRIVES)]
pub(super) struct DrivesArgs {
    /// Name or path of a turning job
    #[arg(default_value = "turned_cam")]
    job: String,
    /// Maximum form error beyond that of ideal drives (um)
    #[arg(long, value_name = "UM", default_value_t = 2.0)]
    tolerance_um: f64,
    /// Maximum position loop gain of X in the search (1/s)
    #[arg(long, value_name = "KV", default_value_t = 2000.0)]
    max_kv_1_s: f64,
    /// Set a key of the job, such as `turned.to_mm=20` for a short piece; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Set a key of the machine; repeatable
    #[arg(long = "set-machine", value_name = "KEY=VALUE")]
    set_machine: Vec<String>,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

/// Exit code 0: done; 2: rejected, or not a turning job.
pub(super) fn main(args: &DrivesArgs) -> ExitCode {
    match drives(args) {
        Ok((_, json)) if args.json => {
            say!("{json:#}");
            ExitCode::SUCCESS
        }
        Ok((text, _)) => {
            let level = if text.starts_with("NOT GOOD") { VerdictLevel::Bad } else { VerdictLevel::Good };
            print_verdict(level, &wrapped(text.trim_end(), 2));
            ExitCode::SUCCESS
        }
        Err(message) => {
            print_error("error", &message);
            ExitCode::from(2)
        }
    }
}

fn prepared(args: &DrivesArgs) -> Result<PreparedTurning, String> {
    let job = any_job::load(&args.job, &args.set).map_err(|error| error.to_string())?;
    let AnyJob::Turned(mut job) = job else {
        return Err(format!("job {} grinds; `camwright run {0} --details` shows what its drives leave", args.job));
    };
    job.machine = job.machine.with_overrides(&args.set_machine).map_err(|error| error.to_string())?;
    planning::plan_turned(*job, None).map_err(|error| error.to_string())
}

/// Simulates all drives and searches the gain of X. Returns the result as text, verdict first, and as JSON.
fn drives(args: &DrivesArgs) -> Result<(String, Value), String> {
    let prepared = prepared(args)?;
    let (spec, machine) = (&prepared.job.spec, &prepared.machine);
    // The simulations take some seconds each.
    let simulations = progress::bar(0, "{pos} simulations done");
    let mut text =
        format!("{}\n{:<40} {:>11} {:>11} {:>11}\n", prepared.summary(), "drives", "highest", "lowest", "excess");
    let record = |text: &mut String, finding: &DrivesResult| {
        simulations.inc(1);
        *text += &finding_text(finding);
    };
    let all = TurningDrives::new(spec, &prepared.planned.plan, machine, prepared.job.grid);
    let all = all.map_err(|error| error.to_string())?;
    let compared = all.compare(|found| record(&mut text, found)).map_err(|error| error.to_string())?;
    let good = compared.iter().find(|(drives, _)| *drives == Drives::Good).map(|(_, form)| um_from_mm(form.beyond_mm));
    let mut verdicts = Vec::new();
    if let Some(good_um) = good {
        let (word, keep) = if good_um <= args.tolerance_um { ("GOOD", "keep") } else { ("NOT GOOD", "exceed") };
        verdicts.push(format!(
            "{word}: the good drives of {} {keep} {} um: {good_um:.3} um",
            machine.name, args.tolerance_um
        ));
    }
    let mut searches = Vec::new();
    for (feed_forward, name) in [(FeedForward::AsItIs, "as it is"), (FeedForward::Whole, "whole")] {
        text += &format!("\ngain of x_axis, velocity loop in the same ratio, feed-forward {name}:\n");
        let search =
            GainSearch { tolerance_mm: mm_from_um(args.tolerance_um), max_kv_1_s: args.max_kv_1_s, feed_forward };
        let found = all.minimum_gain(&search, |found| record(&mut text, found)).map_err(|error| error.to_string())?;
        verdicts.push(format!("feed-forward {name}: {}", verdict(args.tolerance_um, &found)));
        searches.push(json!({ "feed_forward": name, "result": gain_json(&found) }));
    }
    simulations.finish_and_clear();
    let compared: serde_json::Map<String, Value> =
        compared.iter().map(|(drives, form)| (drives.to_string(), form_json(form))).collect();
    let json = json!({
        "job": spec.name,
        "machine": machine.name,
        "tolerance_um": args.tolerance_um,
        "drives": compared,
        "gain_of_x": searches,
    });
    let text = format!(
        "{}\n\n{text}\nhighest and lowest: form error; excess: beyond the error of ideal drives\n",
        verdicts.join("\n")
    );
    Ok((text, json))
}

fn form_text(form: &DrivesForm) -> String {
    let [highest, lowest, beyond] =
        [form.highest.deviation_mm, form.lowest.deviation_mm, form.beyond_mm].map(um_from_mm);
    format!("{highest:>+8.3} um {lowest:>+8.3} um {beyond:>8.3} um")
}

fn loop_text(tried: &GainTrial) -> String {
    let velocity =
        tried.velocity_loop_rad_s.map_or_else(|| "ideal".into(), |rad_s| format!("{:.0} Hz", rad_s / TURN_RAD));
    format!("Kv {:.1} 1/s, velocity loop {velocity}", tried.kv_1_s)
}

fn finding_text(finding: &DrivesResult) -> String {
    match finding {
        DrivesResult::Drives(drives, form) => format!("{:<40} {}\n", drives.to_string(), form_text(form)),
        DrivesResult::Gain(tried) => {
            let form = tried.form.as_ref().map_or_else(|| "the machine stops with an alarm".into(), form_text);
            format!("{:<40} {form}\n", loop_text(tried))
        }
        DrivesResult::Flaw(without) => {
            format!("{:<40} {}\n", format!("without {}", without.of), form_text(&without.form))
        }
    }
}

fn verdict(tolerance_um: f64, found: &MinimumGain) -> String {
    let beyond_um = |tried: &GainTrial| tried.form.map_or(f64::NAN, |form| um_from_mm(form.beyond_mm));
    match found {
        MinimumGain::Found { least, .. } => {
            format!("{} keeps {tolerance_um} um: {:.3} um", loop_text(least), beyond_um(least))
        }
        MinimumGain::NotFound { best, max_kv_1_s, flaws, .. } => {
            let most = flaws.first().map_or_else(String::new, |without| {
                format!("; without {} {:.3} um would remain", without.of, um_from_mm(without.form.beyond_mm))
            });
            format!(
                "no gain up to {max_kv_1_s:.0} 1/s keeps {tolerance_um} um; best {}: {:.3} um{most}",
                loop_text(best),
                beyond_um(best)
            )
        }
    }
}

fn form_json(form: &DrivesForm) -> Value {
    json!({
        "highest_um": um_from_mm(form.highest.deviation_mm),
        "lowest_um": um_from_mm(form.lowest.deviation_mm),
        "beyond_um": um_from_mm(form.beyond_mm),
    })
}

fn tried_json(tried: &GainTrial) -> Value {
    json!({
        "kv_1_s": tried.kv_1_s,
        "velocity_loop_hz": tried.velocity_loop_rad_s.map(|rad_s| rad_s / TURN_RAD),
        "form": tried.form.as_ref().map(form_json),
    })
}

fn gain_json(found: &MinimumGain) -> Value {
    match found {
        MinimumGain::Found { least, tried, .. } => json!({
            "least": tried_json(least),
            "tried": tried.iter().map(tried_json).collect::<Vec<_>>(),
        }),
        MinimumGain::NotFound { best, tried, flaws, .. } => json!({
            "best": tried_json(best),
            "tried": tried.iter().map(tried_json).collect::<Vec<_>>(),
            "without": flaws.iter().map(|without| json!({
                "flaw": without.of.to_string(), "form": form_json(&without.form),
            })).collect::<Vec<_>>(),
        }),
    }
}
