// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The report of a recorded run: one HTML file that needs nothing else, no script, no font, no network.
//!
//! ```text
//! bag ─► gather (what is said) ─► story (the last job) ─► motion (its ticks) ─► judge (good? why?) ─► page
//!                                    └─► again (its plan, if it plans to the recorded hash) ─► edge (what made a turned part's worst place)
//! ```
//!
//! It is made from the bag and from nothing else, so that everybody who has the bag makes the same bytes; what the bag does not hold is said to be
//! missing.

mod alarms;
mod causes;
mod chart;
mod columns;
mod edge;
mod error;
mod findings;
mod gather;
mod gauge_size;
mod gauging;
mod head;
mod inspection;
mod job_timeline;
mod judge;
mod lag;
mod lobes;
mod motion;
mod page;
mod part_drawing;
mod pins;
mod provenance;
mod replan;
mod table;
mod text;
mod time_line;
mod turned;
mod turned_cause;

#[cfg(test)]
mod tests;

use camwright::machine::description::MachineDescription;
use camwright_bag::Bag;
use camwright_files::convert::centre_offset;
use camwright_planning::AnyPrepared;
use edge::ErrorSplit;
pub use error::ReportError;
use findings::Findings;
use gather::RecordedRun;
use job_timeline::JobTimeline;
pub use judge::{BURNT, burnt};
use lag::Lag;
use motion::RecordedMotion;
use std::fs;
use std::path::{Path, PathBuf};

/// Name of the report within a bag's directory.
pub const FILE_NAME: &str = "report.html";

/// The report of a bag as HTML.
///
/// # Errors
/// A bag that cannot be read, or that holds no job.
pub fn html(path: &Path) -> Result<String, ReportError> {
    html_with(path, None)
}

/// The same; `known` saves planning the recorded job again if it is that plan.
fn html_with(path: &Path, known: Option<&AnyPrepared>) -> Result<String, ReportError> {
    let bag = Bag::open(path)?;
    let recorded = RecordedRun::from_bag(&bag)?;
    let story = JobTimeline::from_recorded(&recorded);
    if story.status.is_none() {
        return Err(ReportError::NoJob { path: path.to_owned() });
    }
    let cuts: Vec<Option<(u64, u64)>> = (0..story.names().len()).map(|lobe| story.last_cut(lobe)).collect();
    let infeeds = (0..story.names().len()).map(|lobe| story.first_infeed(lobe));
    let margin = lag::MARGIN_TICKS;
    let windows: Vec<(u64, u64)> = (cuts.iter().copied().chain(infeeds).flatten())
        .map(|(from, to)| (from.saturating_sub(margin), to.saturating_add(margin)))
        .collect();
    let motion = match story.ticks {
        Some(ticks) => RecordedMotion::from_recorded(&bag, &recorded, ticks, &windows)?,
        None => None,
    };
    let described = replan::described(&story);
    // The structures of real axes are in no reading.
    let structures = described.as_ref().ok().filter(|_| recorded.drives.is_none());
    let lag = |(lobe, cut): (usize, &Option<(u64, u64)>)| {
        lag_of(&recorded, &story, structures, motion.as_ref()?, ((*cut)?, lobe))
    };
    let lags: Vec<Option<Lag>> = cuts.iter().enumerate().map(lag).collect();
    let again = replan::plan(&story, described, known);
    let split = split_of(&story, &again, motion.as_ref(), cuts.first().copied().flatten());
    let verdict = judge::judge(&recorded, &story, &lags, split.as_ref());
    Ok(page::html(&Findings {
        recorded: &recorded,
        story: &story,
        motion: motion.as_ref(),
        lags: &lags,
        split: split.as_ref(),
        again: &again,
        verdict: &verdict,
    }))
}

/// Form error by the axes in the last turn of a cut, or in the last pass of a turned part.
fn lag_of(
    recorded: &RecordedRun,
    story: &JobTimeline<'_>,
    description: Option<&MachineDescription>,
    motion: &RecordedMotion,
    (cut, lobe): ((u64, u64), usize),
) -> Option<Lag> {
    let machine = story.machine?;
    let form = story.names().get(lobe).and_then(|name| story.forms.iter().find(|form| form.name == *name));
    let centre = form.and_then(|form| centre_offset(&form.centre));
    let is_turned = story.forms.is_empty();
    let from = if is_turned { cut.0 } else { motion.last_turn(cut).first()?.tick };
    let known = lag::CutContext {
        description,
        cycle_s: recorded.cycle_s()?,
        sense: f64::from(machine.rotation_sense),
        wheel_m: (!is_turned).then_some(machine.wheel_radius),
        centre,
    };
    Lag::from_motion(motion, motion.within(cut), from, known)
}

/// Causes at the worst position of a turned part; `None` without a judged turned part.
fn split_of(
    story: &JobTimeline<'_>,
    again: &Result<AnyPrepared, String>,
    motion: Option<&RecordedMotion>,
    pass: Option<(u64, u64)>,
) -> Option<Result<ErrorSplit, String>> {
    let result = story.status?.turned.first()?;
    Some(match (again, motion.zip(pass)) {
        (_, None) => Err("the axes' ticks are not in the bag".into()),
        (Err(reason), _) => Err(reason.clone()),
        (Ok(AnyPrepared::Turned(prepared)), Some((motion, pass))) => {
            edge::worst(prepared, result, motion, motion.within(pass))
        }
        (Ok(AnyPrepared::Ground(_)), _) => Err("the recorded job turns no part".into()),
    })
}

/// Makes the report of a bag and writes it; omitted, `out` is `report.html` in the bag's directory. A plan that the caller has saves
/// planning the recorded job again. Returns where the report lies.
///
/// # Errors
/// As [`html`], and where the file cannot be written.
pub fn write(bag: &Path, out: Option<&Path>, known: Option<&AnyPrepared>) -> Result<PathBuf, ReportError> {
    let page = html_with(bag, known)?;
    let beside = || if bag.is_dir() { bag.join(FILE_NAME) } else { bag.with_extension("html") };
    let out = out.map_or_else(beside, Path::to_owned);
    fs::write(&out, page).map_err(|source| ReportError::Io { action: "write", path: out.clone(), source })?;
    Ok(out)
}
