// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright chatter`: stability of every cut of a job, and the effect of a varying work speed.

use super::output::{JsonArg, VerdictLevel, number, print_error, print_verdict, say, wrapped};
use camwright::job::grinding::VARIATION_PERIODS_TURNS;
use camwright_files::any_job::{self, AnyJob};
use camwright_planning::{self as planning, ChatterReport, PassChatter, VariationSummary};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `camwright chatter`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = super::help::CHATTER)]
pub(super) struct ChatterArgs {
    /// Name or path of a grinding job
    job: String,
    /// Compare with a work speed that is lower by this in half of each period (percent) [default: the job's, or 25]
    #[arg(long, value_name = "PERCENT", value_parser = slower)]
    variation: Option<f64>,
    /// Period of that variation in turns of the part [default: the job's, or 2]
    #[arg(long, value_name = "TURNS", value_parser = period)]
    period: Option<f64>,
    /// Draw the stability lobes of the worst pass as SVG or PNG
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Set a key of the job, such as `work_speed_rpm=50`; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Set a key of the machine, such as `contact.modes=[...]`; repeatable
    #[arg(long = "set-machine", value_name = "KEY=VALUE")]
    set_machine: Vec<String>,
    #[command(flatten)]
    output: JsonArg,
}

fn slower(text: &str) -> Result<f64, String> {
    number(text)
        .ok()
        .filter(|percent| (1.0..=75.0).contains(percent))
        .ok_or_else(|| "it must be a number from 1 to 75 percent".to_owned())
}

fn period(text: &str) -> Result<f64, String> {
    number(text)
        .ok()
        .filter(|turns| (VARIATION_PERIODS_TURNS.0..=VARIATION_PERIODS_TURNS.1).contains(turns))
        .ok_or_else(|| "it must be a number from 1.5 to 3 turns".to_owned())
}

/// Exit code 0: stable; 1: a pass chatters; 2: rejected, or not written.
pub(super) fn main(args: &ChatterArgs) -> ExitCode {
    let report = match report(args) {
        Ok(report) => report,
        Err(message) => {
            print_error("error", &message);
            return ExitCode::from(2);
        }
    };
    if args.output.json {
        say!("{}", serde_json::to_string_pretty(&report).unwrap_or_default());
    } else {
        let level = if report.is_stable { VerdictLevel::Good } else { VerdictLevel::Bad };
        print_verdict(level, &wrapped(as_text(&report).trim_end(), 2));
    }
    if let Some(path) = &args.plot {
        if let Err(error) = report.write_plot(path) {
            print_error("error", &error);
            return ExitCode::from(2);
        }
        if !args.output.json {
            say!("plot:   {}", path.display());
        }
    }
    ExitCode::from(u8::from(!report.is_stable))
}

fn report(args: &ChatterArgs) -> Result<ChatterReport, String> {
    let job = any_job::load(&args.job, &args.set).map_err(|error| error.to_string())?;
    let AnyJob::Ground(mut job) = job else {
        return Err(format!("job {} is not ground; the forecast of chatter is for grinding jobs", args.job));
    };
    if !args.set_machine.is_empty() {
        job.machine = job.machine.with_overrides(&args.set_machine).map_err(|error| error.to_string())?;
    }
    let prepared = planning::plan(*job, None).map_err(|error| error.to_string())?;
    let of_job = VariationSummary::of_job(&prepared);
    let base = of_job.unwrap_or(VariationSummary { slower_percent: 25.0, period_turns: 2.0, is_of_job: false });
    let variation = VariationSummary {
        slower_percent: args.variation.unwrap_or(base.slower_percent),
        period_turns: args.period.unwrap_or(base.period_turns),
        is_of_job: of_job.is_some() && args.variation.is_none() && args.period.is_none(),
    };
    planning::chatter(&prepared, variation).map_err(|error| error.to_string())
}

/// Verdict, one line for each pass of each lobe, and the remedies.
fn as_text(report: &ChatterReport) -> String {
    let mut text = verdict(report);
    let width = report.passes.iter().map(|pass| pass.lobe.chars().count()).max().unwrap_or(0).max(4);
    text += &format!(
        "{:<width$} {:<8} {:>7} {:>7} {:>7} {:>8} {:>8} {:>8}\n",
        "lobe", "pass", "rpm", "Hz", "waves", "growth", "varied", "margin"
    );
    let mut before = "";
    for pass in &report.passes {
        let name = if pass.lobe == before { "" } else { &*pass.lobe };
        before = &pass.lobe;
        let or_none = |value: Option<f64>, digits: usize| {
            value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
        };
        text += &format!(
            "{name:<width$} {:<8} {:>7.1} {:>7} {:>7} {:>8} {:>8.3} {:>8}  {}\n",
            pass.pass,
            pass.work_speed_rpm,
            or_none(pass.part.map(|wave| wave.frequency_hz), 1),
            or_none(pass.part.map(|wave| wave.waves_per_turn), 1),
            or_none(pass.part.map(|wave| wave.growth_per_turn), 3),
            pass.varied_growth_per_turn,
            pass.margin_db.map_or_else(|| "any".to_owned(), |db| format!("{db:+.1} dB")),
            if pass.is_stable { "stable" } else { "chatters" },
        );
    }
    text += &format!(
        "growth: of the worst wave per turn; varied: with a work speed that is {} % lower in half of every {} turns{}; margin: of \
         the width, any: stable at every width\n",
        report.variation.slower_percent,
        report.variation.period_turns,
        if report.variation.is_of_job { ", as the job has it" } else { "" }
    );
    for line in notes(report) {
        text += &format!("{line}\n");
    }
    text
}

fn verdict(report: &ChatterReport) -> String {
    let chattering = report.passes.iter().filter(|pass| !pass.is_stable).count();
    match report.worst() {
        Some(worst) if chattering > 0 => format!(
            "CHATTERS: {} on {}: {chattering} of {} passes; waves of {} {} grow {:.2} times per turn\n",
            report.job,
            report.machine,
            report.passes.len(),
            worst.lobe,
            worst.pass,
            worst.part.map_or(f64::NAN, |wave| wave.growth_per_turn)
        ),
        _ => format!("STABLE: {} on {}: no wave grows in {} passes\n", report.job, report.machine, report.passes.len()),
    }
}

/// Remedies of the worst pass, and limits of the forecast that apply to this job.
fn notes(report: &ChatterReport) -> Vec<String> {
    let mut notes = Vec::new();
    let Some(worst) = report.worst() else { return notes };
    if !worst.is_stable {
        notes.push(remedies(worst, report.variation));
    }
    if let (Some(wave_mm), false) = (worst.wave_mm, worst.is_stable)
        && wave_mm < worst.contact_mm
    {
        notes.push(format!(
            "waves of {} {} are {wave_mm:.2} mm long, shorter than the contact of {:.2} mm, which wipes them out",
            worst.lobe, worst.pass, worst.contact_mm
        ));
    }
    let wheel = report.passes.iter().filter_map(|pass| Some((pass, pass.wheel?)));
    if let Some((pass, wave)) = wheel.max_by(|one, other| one.1.growth_per_s.total_cmp(&other.1.growth_per_s)) {
        let change = 60.0 * wave.growth_per_s.ln();
        let verb = if change > 0.0 { "grow" } else { "shrink" };
        notes.push(format!(
            "waves on the wheel {verb}: {:.1} Hz, {:.1} waves, by e^{change:+.2} per minute of {} {}",
            wave.frequency_hz, wave.waves_per_turn, pass.lobe, pass.pass
        ));
    }
    if report.x_friction_n > 0.0 {
        notes.push(format!(
            "friction of {} N holds x_axis while the force changes by less: then growth is that of spring and modes alone",
            report.x_friction_n
        ));
    }
    if report.passes.iter().any(|pass| pass.speed_range_rpm[1] > 1.02 * pass.speed_range_rpm[0]) {
        notes.push(
            "the work speed changes within a turn: the delay is the time of a turn all round, waves are uneven".into(),
        );
    }
    notes
}

fn remedies(worst: &PassChatter, variation: VariationSummary) -> String {
    let mut remedies = Vec::new();
    if let Some(width_mm) = worst.limit_width_mm {
        remedies.push(format!("a width of {width_mm:.1} mm instead of {:.1} mm", worst.width_mm));
    }
    let speeds: Vec<String> = [worst.stable_below_rpm, worst.stable_above_rpm]
        .into_iter()
        .flatten()
        .map(|rpm| format!("{rpm:.2} rpm"))
        .collect();
    if speeds.is_empty() {
        remedies.push("no work speed nearby".into());
    } else {
        remedies.push(format!("a work speed of {}", speeds.join(" or ")));
    }
    if worst.varied_growth_per_turn < 1.0 {
        let VariationSummary { slower_percent, period_turns, .. } = variation;
        let key = format!("speed_variation={{slower_percent: {slower_percent}, period_turns: {period_turns}}}");
        remedies.push(format!("a varying work speed, --set '{key}'"));
    }
    format!("stable for {} {}: {}", worst.lobe, worst.pass, remedies.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        args: ChatterArgs,
    }

    fn args(words: &[&str]) -> Result<ChatterArgs, clap::Error> {
        let words = ["chatter"].iter().chain(words);
        Line::try_parse_from(words).map(|line| line.args)
    }

    /// The slender shaft of the example: stable as it comes, and with a soft mode it chatters and the remedies are named.
    #[test]
    fn the_text_fits_the_page_and_names_remedies() {
        let calm = report(&args(&["journal_runout"]).unwrap()).unwrap();
        let text = wrapped(as_text(&calm).trim_end(), 2);
        assert!(text.starts_with("STABLE: journal_runout on journal_grinder"), "{text}");
        let mode = "contact.modes=[{frequency_hz: 140.0, damping: 0.03, compliance_share: 0.6}]";
        let loud = report(&args(&["journal_runout", "--set-machine", mode]).unwrap()).unwrap();
        let text = wrapped(as_text(&loud).trim_end(), 2);
        assert!(text.starts_with("CHATTERS: ") && text.contains("stable for J1 rough"), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    }

    #[test]
    fn bad_input_is_rejected_with_the_range() {
        let refused = |words: &[&str]| args(words).unwrap_err().to_string();
        assert!(refused(&["journal_runout", "--variation", "80"]).contains("from 1 to 75 percent"));
        assert!(refused(&["journal_runout", "--period", "0"]).contains("from 1.5 to 3 turns"));
        let turned = report(&args(&["turned_cam"]).unwrap()).unwrap_err();
        assert!(turned.contains("is not ground"), "{turned}");
    }
}
