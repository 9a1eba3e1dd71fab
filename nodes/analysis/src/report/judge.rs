// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Verdict on the part, its worst position and the cause, from the recorded data.

use super::causes::{causes_of, causes_of_turned};
use super::edge::ErrorSplit;
use super::gather::RecordedRun;
use super::job_timeline::JobTimeline;
use super::lag::{Lag, Residual};
use super::text::{fixed, signed, um};
use camwright::math::units::{deg_from_rad, wrap_turn};
use camwright_files::convert::{allowed_form_errors, mm_from_m};
use camwright_msgs::camwright_msgs::msg::{Alarm, JobStatus, LobeForm, LobeResult, PlanHeader, TurnedResult};

/// Verdict on a part with good form that was ground too hot.
pub const BURNT: &str = "NOT GOOD, BURNT";

/// Emphasis of the verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum VerdictTone {
    Good,
    Wrong,
    Waits,
}

/// The worst place of the part.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WorstError {
    /// Which lobe, or the part.
    pub(super) index: usize,
    pub(super) name: String,
    pub(super) error_um: f64,
    pub(super) allowed_um: f64,
    /// "cam angle 140.7°", or azimuth and place along the part.
    pub(super) place: String,
    /// Azimuth from where C is 0, where it is known (deg).
    pub(super) azimuth_deg: Option<f64>,
}

/// Verdict of the report.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ReportVerdict {
    pub(super) tone: VerdictTone,
    pub(super) word: &'static str,
    pub(super) reason: String,
    pub(super) worst: Option<WorstError>,
    /// Causes of the error; the first is the short answer.
    pub(super) causes: Vec<String>,
}

/// Judges the last job; one lag for each lobe, where the ticks are recorded, and of a turned part what made its worst place.
pub(super) fn judge(
    recorded: &RecordedRun,
    story: &JobTimeline<'_>,
    lags: &[Option<Lag>],
    split: Option<&Result<ErrorSplit, String>>,
) -> ReportVerdict {
    let Some(status) = story.status else {
        return without_part("NOT JUDGED", "The bag holds no job.".into(), Vec::new());
    };
    let worst = worst(status, story);
    if status.state != JobStatus::COMPLETE {
        let stopped = not_complete(recorded, story, status);
        return ReportVerdict { worst, ..stopped };
    }
    let Some(worst) = worst else {
        let only_measured = story.plans.iter().any(|(_, header)| header.half == PlanHeader::NO_PART);
        let why = if only_measured { "Nothing was to be cut, or only to be measured." } else { "No lobe was judged." };
        return without_part("NOT JUDGED", format!("The job ended as planned. {why}"), vec![status.message.clone()]);
    };
    let count = status.lobes.len() + status.turned.len();
    let bad = bad_count(status, story);
    let burnt = burnt(&status.lobes);
    let allowed = fixed(worst.allowed_um, 1);
    let (tone, word, reason) = match (bad, burnt) {
        (0, None) => {
            let all = if count > 1 { format!("All {count} lobes are") } else { "The part is".into() };
            let reserve = fixed(worst.allowed_um - worst.error_um.abs(), 2);
            let reason = format!("{all} within the allowed ±{allowed} µm; the worst place has {reserve} µm to spare.");
            (VerdictTone::Good, "GOOD", reason)
        }
        (0, Some(burnt)) => (VerdictTone::Wrong, BURNT, format!("The form is within tolerance. {}", burnt_text(burnt))),
        (bad, _) => {
            let over = fixed(worst.error_um.abs() - worst.allowed_um, 2);
            let side = if worst.error_um > 0.0 { "more material" } else { "less material" };
            let which = match count {
                1 => String::from("It is out of tolerance"),
                count if bad == count => format!("All {count} lobes are out of tolerance"),
                count => format!("{bad} of {count} lobes are out of tolerance"),
            };
            let reason = format!("{which}: the worst place has {over} µm {side} than the allowed ±{allowed} µm.");
            (VerdictTone::Wrong, "NOT GOOD", reason)
        }
    };
    let lag = lags.get(worst.index).and_then(Option::as_ref);
    let mut causes = match (lag, split) {
        (_, Some(split)) => causes_of_turned(&status.turned[0], split.as_ref(), lag),
        (Some(lag), None) => causes_of_lobe(&worst, lag),
        (None, None) => vec!["Not known: the axes' ticks are not in the bag.".to_owned()],
    };
    causes.extend(burnt.filter(|_| bad > 0).map(burnt_text));
    ReportVerdict { tone, word, reason, worst: Some(worst), causes }
}

/// The lobe that burnt most, if one did.
pub fn burnt(lobes: &[LobeResult]) -> Option<&LobeResult> {
    let burns = lobes.iter().filter(|lobe| lobe.burn_index_max > 1.0);
    burns.max_by(|a, b| a.burn_index_max.total_cmp(&b.burn_index_max))
}

fn without_part(word: &'static str, reason: String, causes: Vec<String>) -> ReportVerdict {
    ReportVerdict { tone: VerdictTone::Waits, word, reason, worst: None, causes }
}

fn burnt_text(lobe: &LobeResult) -> String {
    format!(
        "Lobe {} is burnt: burn index {} (limit 1) at cam angle {}°.",
        lobe.name,
        fixed(lobe.burn_index_max, 2),
        fixed(deg_from_rad(lobe.burn_index_max_angle), 1)
    )
}

/// Allowed form error of a lobe at its worst place (m). Results of earlier versions do not have it, and are judged by the one tolerance of
/// their lobe.
pub(super) fn allowed(story: &JobTimeline<'_>, lobe: &LobeResult) -> Option<f64> {
    let form = story.forms.iter().find(|form| form.name == lobe.name)?;
    Some(if lobe.form_error_allowed > 0.0 { lobe.form_error_allowed } else { form.tolerance })
}

fn bad_count(status: &JobStatus, story: &JobTimeline<'_>) -> usize {
    let lobe = |l: &&LobeResult| allowed(story, l).is_some_and(|allowed| l.form_error_max.abs() > allowed);
    let turned = |t: &&TurnedResult| t.form_error_max.abs() > t.form_error_allowed;
    status.lobes.iter().filter(lobe).count() + status.turned.iter().filter(turned).count()
}

/// The place that is worst by what is allowed there.
fn worst(status: &JobStatus, story: &JobTimeline<'_>) -> Option<WorstError> {
    let of_lobe = |lobe: &LobeResult| {
        let form = story.forms.iter().find(|form| form.name == lobe.name)?;
        Some(WorstError {
            index: story.names().iter().position(|name| *name == lobe.name)?,
            name: format!("lobe {}", lobe.name),
            error_um: um(lobe.form_error_max),
            allowed_um: um(allowed(story, lobe)?),
            place: format!("cam angle {}°", fixed(deg_from_rad(lobe.form_error_max_angle), 1)),
            azimuth_deg: worst_place(form).map(|(deg, _)| deg),
        })
    };
    let of_part = |part: &TurnedResult| WorstError {
        index: 0,
        name: "part".to_owned(),
        error_um: um(part.form_error_max),
        allowed_um: um(part.form_error_allowed),
        place: format!(
            "azimuth {}°, z {} mm",
            fixed(deg_from_rad(wrap_turn(part.form_error_max_azimuth)), 1),
            fixed(mm_from_m(part.form_error_max_z), 2)
        ),
        azimuth_deg: Some(deg_from_rad(wrap_turn(part.form_error_max_azimuth))),
    };
    let all = status.lobes.iter().filter_map(of_lobe).chain(status.turned.iter().map(of_part));
    all.max_by(|a, b| (a.error_um.abs() / a.allowed_um).total_cmp(&(b.error_um.abs() / b.allowed_um)))
}

/// The azimuth at which a lobe uses most of its tolerance (deg) and the error there (m); none before it was judged.
pub(super) fn worst_place(form: &LobeForm) -> Option<(f64, f64)> {
    let errors = form.form_error.iter().copied().zip(allowed_form_errors(form)).enumerate();
    let used = |(_, (error, allowed)): &(usize, (f64, f64))| error.abs() / allowed;
    let (index, (error, _)) = errors.max_by(|a, b| used(a).total_cmp(&used(b)))?;
    Some((360.0 * index as f64 / form.form_error.len() as f64, error))
}

fn not_complete(recorded: &RecordedRun, story: &JobTimeline<'_>, status: &JobStatus) -> ReportVerdict {
    let begin = story.ticks.map_or(0, |(first, _)| first);
    let stopping = recorded.alarms.iter().map(|record| &record.alarm);
    let first = stopping.filter(|alarm| alarm.severity >= Alarm::STOP && alarm.tick >= begin).min_by_key(|a| a.tick);
    let done = status.lobes.len() + status.turned.len();
    let of = story.names().len();
    let reason = match first {
        Some(alarm) => format!("Alarm {} ({}) stopped the job: {}.", alarm.number, alarm.source, alarm.text),
        None => match status.state {
            JobStatus::STOPPED => "The job was cancelled.".to_owned(),
            JobStatus::ABORTED => "The job was aborted or refused.".to_owned(),
            _ => "The recording ends before the job does.".to_owned(),
        },
    };
    let mut causes: Vec<String> = first.map(|alarm| format!("Remedy: {}.", alarm.remedy)).into_iter().collect();
    if !status.message.is_empty() {
        causes.push(status.message.clone());
    }
    causes.push(format!("{done} of {of} lobes or parts were judged."));
    ReportVerdict { tone: VerdictTone::Wrong, word: "NOT COMPLETE", reason, worst: None, causes }
}

/// Share of each cause in the error at the worst position of a lobe.
fn causes_of_lobe(worst: &WorstError, lag: &Lag) -> Vec<String> {
    let [low, high] = [lag.max().lowest_um, lag.max().highest_um].map(|um| signed(um, 2));
    let range = format!("In the last turn, lag and swing of the axes leave {low} to {high} µm around {}.", worst.name);
    let at = |left: &Residual| worst.azimuth_deg.and_then(|azimuth| left.at(azimuth));
    let Some(drives) = at(&lag.encoders) else { return vec![range] };
    let mut sources = vec![(drives, "the drives' lag behind the path", "lag by the encoders")];
    let tool = lag.tool.as_ref().and_then(at);
    if let Some(tool) = tool {
        let name = "the structures of the axes, which swing behind the encoders when X and C are accelerated";
        sources.push((tool - drives, name, "swing of the structures under the recorded motion"));
    }
    let rest = worst.error_um - tool.unwrap_or(drives);
    sources.push((
        rest,
        "effects without a sensor: deflection of wheel and part, wear, heat",
        "deflection, wear, heat (the rest)",
    ));
    let mut causes = causes_of(worst.error_um, &sources);
    causes.push(range);
    causes
}
