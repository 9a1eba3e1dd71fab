//! `camwright drives`: what the drives of a lathe leave on a part, and what they would have to be.

use camwright::math::units::{TURN_RAD, mm_from_um, um_from_mm};
use camwright::simulation::lathe_drives::{
    Drives, DrivesForm, FeedForward, GainSearch, GainTried, LeastGain, Told, TurningDrives,
};
use camwright_files::any_job::{self, AnyJob};
use camwright_planning::{self as planning, PreparedTurning};
use serde_json::{Value, json};
use std::io::{self, Write};
use std::process::ExitCode;

/// Arguments of `camwright drives`.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct DrivesArgs {
    /// Name or path of a job that turns
    #[arg(default_value = "turned_cam")]
    job: String,
    /// How far the part may be off besides what ideal drives leave
    #[arg(long, value_name = "UM", default_value_t = 2.0)]
    tolerance_um: f64,
    /// Largest position loop gain of X that is tried
    #[arg(long, value_name = "KV", default_value_t = 2000.0)]
    most_kv_1_s: f64,
    /// Sets a key of the job, for example `turned.to_mm=20`: a short piece of the part is turned sooner
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Sets a key of the machine
    #[arg(long = "set-machine", value_name = "KEY=VALUE")]
    set_machine: Vec<String>,
    /// One JSON object instead of text
    #[arg(long)]
    json: bool,
}

/// Exit code 0: told; 2: refused, or not turned.
pub(super) fn main(args: &DrivesArgs) -> ExitCode {
    match drives(args) {
        Ok(report) => {
            if args.json {
                let _ = writeln!(io::stdout(), "{report:#}");
            }
            ExitCode::SUCCESS
        }
        Err(message) => {
            let _ = writeln!(io::stderr(), "error: {message}");
            ExitCode::from(2)
        }
    }
}

fn prepared(args: &DrivesArgs) -> Result<PreparedTurning, String> {
    let job = any_job::load(&args.job, &args.set).map_err(|error| error.to_string())?;
    let AnyJob::Turned(mut job) = job else {
        return Err(format!("job {} grinds: what its drives leave `camwright run` tells at its end", args.job));
    };
    job.machine = job.machine.with_overrides(&args.set_machine).map_err(|error| error.to_string())?;
    planning::plan_turned(*job, None).map_err(|error| error.to_string())
}

fn drives(args: &DrivesArgs) -> Result<Value, String> {
    let prepared = prepared(args)?;
    let (spec, machine) = (&prepared.job.spec, &prepared.machine);
    // Results come one after the other, some seconds apart: text says each at once, and with --json where people look for progress.
    let say = |line: &str| {
        let _ = if args.json { writeln!(io::stderr(), "{line}") } else { writeln!(io::stdout(), "{line}") };
    };
    let told = |told: &Told| say(&told_text(told));
    say(&prepared.summary());
    say("off the design: highest, lowest, and how far beyond what ideal drives leave");
    let all = TurningDrives::new(spec, &prepared.planned.plan, machine, prepared.job.grid);
    let all = all.map_err(|error| error.to_string())?;
    let compared = all.compare(told).map_err(|error| error.to_string())?;
    let good = compared.iter().find(|(drives, _)| *drives == Drives::Good).map(|(_, form)| um_from_mm(form.beyond_mm));
    let mut searches = Vec::new();
    for (feed_forward, name) in [(FeedForward::AsItIs, "as it is"), (FeedForward::Whole, "whole")] {
        say(&format!("position loop gain of x_axis, velocity loop in the same ratio, feed-forward {name}:"));
        let search =
            GainSearch { tolerance_mm: mm_from_um(args.tolerance_um), most_kv_1_s: args.most_kv_1_s, feed_forward };
        let found = all.least_gain(&search, told).map_err(|error| error.to_string())?;
        say(&verdict(args.tolerance_um, &found));
        searches.push(json!({ "feed_forward": name, "result": gain_json(&found) }));
    }
    if let Some(good_um) = good {
        let keep = if good_um <= args.tolerance_um { "keep" } else { "do not keep" };
        say(&format!(
            "the good drives that {} describes {keep} {} um: {good_um:.3} um",
            machine.name, args.tolerance_um
        ));
    }
    let compared: serde_json::Map<String, Value> =
        compared.iter().map(|(drives, form)| (drives.to_string(), form_json(form))).collect();
    Ok(json!({
        "job": spec.name,
        "machine": machine.name,
        "tolerance_um": args.tolerance_um,
        "drives": compared,
        "gain_of_x": searches,
    }))
}

fn form_text(form: &DrivesForm) -> String {
    let [highest, lowest, beyond] =
        [form.highest.deviation_mm, form.lowest.deviation_mm, form.beyond_mm].map(um_from_mm);
    format!("{highest:+8.3} um {lowest:+8.3} um {beyond:8.3} um")
}

fn loop_text(tried: &GainTried) -> String {
    let velocity =
        tried.velocity_loop_rad_s.map_or_else(|| "ideal".into(), |rad_s| format!("{:.0} Hz", rad_s / TURN_RAD));
    format!("Kv {:.1} 1/s, velocity loop {velocity}", tried.kv_1_s)
}

fn told_text(told: &Told) -> String {
    match told {
        Told::Drives(drives, form) => format!("  {:<44} {}", drives.to_string(), form_text(form)),
        Told::Gain(tried) => {
            let form = tried.form.as_ref().map_or_else(|| "the machine stops with an alarm".into(), form_text);
            format!("  {:<44} {form}", loop_text(tried))
        }
        Told::Flaw(without) => format!("  {:<44} {}", format!("without {}", without.of), form_text(&without.form)),
    }
}

fn verdict(tolerance_um: f64, found: &LeastGain) -> String {
    let beyond_um = |tried: &GainTried| tried.form.map_or(f64::NAN, |form| um_from_mm(form.beyond_mm));
    match found {
        LeastGain::Found { least, .. } => {
            format!("{} keeps {tolerance_um} um: {:.3} um", loop_text(least), beyond_um(least))
        }
        LeastGain::NotFound { best, most_kv_1_s, flaws, .. } => {
            let most = flaws.first().map_or_else(String::new, |without| {
                format!("; without {} {:.3} um would be left", without.of, um_from_mm(without.form.beyond_mm))
            });
            format!(
                "no gain up to {most_kv_1_s:.0} 1/s keeps {tolerance_um} um; the best is {}: {:.3} um{most}",
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

fn tried_json(tried: &GainTried) -> Value {
    json!({
        "kv_1_s": tried.kv_1_s,
        "velocity_loop_hz": tried.velocity_loop_rad_s.map(|rad_s| rad_s / TURN_RAD),
        "form": tried.form.as_ref().map(form_json),
    })
}

fn gain_json(found: &LeastGain) -> Value {
    match found {
        LeastGain::Found { least, tried, .. } => json!({
            "least": tried_json(least),
            "tried": tried.iter().map(tried_json).collect::<Vec<_>>(),
        }),
        LeastGain::NotFound { best, tried, flaws, .. } => json!({
            "best": tried_json(best),
            "tried": tried.iter().map(tried_json).collect::<Vec<_>>(),
            "without": flaws.iter().map(|without| json!({
                "flaw": without.of.to_string(), "form": form_json(&without.form),
            })).collect::<Vec<_>>(),
        }),
    }
}
