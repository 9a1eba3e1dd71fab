// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The last job of a bag: which plans were its own, when what was done, and what came out.

use super::gather::{RecordedRun, TimedMessage};
use camwright_files::convert::job_files::files_from_pages;
use camwright_files::recorded_files::NamedFile;
use camwright_msgs::camwright_msgs::msg::{
    GaugeReading, InterpolatorState, JobStatus, LobeForm, MachineDescription, PartLobe, PlanHeader, PlanSegment,
    TurnedPage,
};

/// A stretch of time in which one thing was done.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Period {
    /// Which of the job's plans.
    pub(super) plan: usize,
    /// `PlanSegment::PHASE_*`, 0 where none is named.
    pub(super) phase: u8,
    pub(super) lobe: Option<usize>,
    pub(super) segment: u32,
    /// It was held, or on its way there and back.
    pub(super) is_held: bool,
    pub(super) from: u64,
    pub(super) to: u64,
    /// Smallest feed override in it.
    pub(super) min_override: f64,
}

impl Period {
    /// The tool is at work.
    pub(super) fn cuts(&self) -> bool {
        matches!(self.phase, PlanSegment::PHASE_CUT | PlanSegment::PHASE_SPARK_OUT)
    }
}

/// Another job of the bag, ended before the last one.
#[derive(Debug, Clone)]
pub(super) struct EndedJob {
    pub(super) status: JobStatus,
    pub(super) is_last: bool,
}

/// The last job of a bag.
#[derive(Debug)]
pub(super) struct JobTimeline<'a> {
    /// Last status; `None` without messages of a planner.
    pub(super) status: Option<&'a JobStatus>,
    /// Every job that came to an end, in their order.
    pub(super) ended: Vec<EndedJob>,
    /// Recorded files that it names.
    pub(super) files: Vec<NamedFile>,
    /// The machine as it was when the job was planned.
    pub(super) machine: Option<&'a MachineDescription>,
    /// Hash and header of its plans in the order in which they were made.
    pub(super) plans: Vec<(String, PlanHeader)>,
    pub(super) stretches: Vec<Period>,
    /// First and last tick of its motion.
    pub(super) ticks: Option<(u64, u64)>,
    /// Latest forms and outlines of its lobes, in the order of machining.
    pub(super) forms: Vec<&'a LobeForm>,
    pub(super) outlines: Vec<&'a PartLobe>,
    pub(super) gauge: Vec<&'a GaugeReading>,
    /// Pages of the surface that was turned, all of one state.
    pub(super) surface: Vec<&'a TurnedPage>,
}

impl<'a> JobTimeline<'a> {
    pub(super) fn from_recorded(recorded: &'a RecordedRun) -> Self {
        let from_ns = begin_ns(&recorded.statuses);
        let status = recorded.statuses.last().map(|at| &at.message).filter(|status| !status.job.is_empty());
        let machine = recorded.machines.iter().rev().find(|at| at.ns <= from_ns).or(recorded.machines.first());
        let pages = recorded.job_files.iter().map(|at| &at.message);
        let files = status.map_or_else(Vec::new, |status| files_from_pages(&status.job_hash, pages));
        let plans = plans(recorded, from_ns, status);
        let stretches = stretches(&recorded.states, &plans);
        let ticks = stretches.first().zip(stretches.last()).map(|(first, last)| (first.from, last.to));
        let names: Vec<String> = plans.first().map_or_else(Vec::new, |(_, header)| header.lobes.clone());
        let forms = last_of(&recorded.forms, from_ns, |form| &form.name, &names);
        let outlines = last_of(&recorded.parts, from_ns, |part| &part.name, &names);
        let gauge = recorded.gauge.iter().filter(|at| at.ns >= from_ns).map(|at| &at.message).collect();
        let pages = || recorded.surface.iter().filter(|at| at.ns >= from_ns).map(|at| &at.message);
        let newest = pages().filter(|page| page.finished).map(|page| page.tick).max();
        let surface = pages().filter(|page| Some(page.tick) == newest).collect();
        Self {
            status,
            ended: ended(&recorded.statuses),
            files,
            machine: machine.map(|at| &at.message),
            plans,
            stretches,
            ticks,
            forms,
            outlines,
            gauge,
            surface,
        }
    }

    /// Names of the lobes in the order of machining, or of the part.
    pub(super) fn names(&self) -> &[String] {
        self.plans.first().map_or(&[], |(_, header)| &header.lobes)
    }

    /// The ticks of the last cut of a lobe, from its first infeed to its last turn.
    pub(super) fn last_cut(&self, lobe: usize) -> Option<(u64, u64)> {
        let of_lobe = |stretch: &&Period| stretch.lobe == Some(lobe) && stretch.cuts();
        let last = self.stretches.iter().rfind(of_lobe)?;
        let first = self.stretches.iter().filter(of_lobe).find(|s| (s.plan, s.segment) == (last.plan, last.segment))?;
        Some((first.from, last.to))
    }

    /// The last tick with infeed of the first cut of a lobe that has one, and the tick at which that cut began.
    pub(super) fn first_infeed(&self, lobe: usize) -> Option<(u64, u64)> {
        let of_lobe = |stretch: &&Period| stretch.lobe == Some(lobe) && stretch.phase == PlanSegment::PHASE_CUT;
        let first = self.stretches.iter().find(of_lobe)?;
        let same = |s: &&Period| of_lobe(s) && (s.plan, s.segment) == (first.plan, first.segment);
        Some((first.from, self.stretches.iter().rfind(same)?.to))
    }
}

/// Time of the last job's request; everything about that job comes later.
fn begin_ns(statuses: &[TimedMessage<JobStatus>]) -> u64 {
    let is_asked = |index: usize| {
        let before = index.checked_sub(1).map(|before| statuses[before].message.state);
        statuses[index].message.state == JobStatus::PLANNING && before != Some(JobStatus::PLANNING)
    };
    (0..statuses.len()).rev().find(|index| is_asked(*index)).map_or(0, |index| statuses[index].ns)
}

fn ended(statuses: &[TimedMessage<JobStatus>]) -> Vec<EndedJob> {
    let is_end = |state: u8| (JobStatus::COMPLETE..=JobStatus::ABORTED).contains(&state);
    let mut ended: Vec<EndedJob> = Vec::new();
    let mut before = JobStatus::IDLE;
    for at in statuses {
        if is_end(at.message.state) {
            if is_end(before) {
                ended.pop();
            }
            ended.push(EndedJob { status: at.message.clone(), is_last: false });
        }
        before = at.message.state;
    }
    if let (Some(last), true) = (ended.last_mut(), is_end(before)) {
        last.is_last = true;
    }
    ended
}

/// Plans published since then; a plan that is repeated by name only is taken from the earlier ones.
fn plans(recorded: &RecordedRun, from_ns: u64, status: Option<&JobStatus>) -> Vec<(String, PlanHeader)> {
    let headers = || recorded.pages.iter().filter_map(|at| Some((at, at.message.header.first()?)));
    let mut plans: Vec<(String, PlanHeader)> = Vec::new();
    let wanted = |hash: &str| status.is_some_and(|status| !hash.is_empty() && status.plan_hash == hash);
    for (at, header) in headers().filter(|(at, _)| at.ns >= from_ns || wanted(&at.message.plan_hash)) {
        if plans.iter().all(|(hash, _)| *hash != at.message.plan_hash) {
            plans.push((at.message.plan_hash.clone(), header.clone()));
        }
    }
    plans
}

fn last_of<'a, T>(
    messages: &'a [TimedMessage<T>],
    from_ns: u64,
    name: impl Fn(&'a T) -> &'a String,
    order: &[String],
) -> Vec<&'a T> {
    let of = |wanted: &String| messages.iter().rev().find(|at| at.ns >= from_ns && name(&at.message) == wanted);
    order.iter().filter_map(|wanted| of(wanted).map(|at| &at.message)).collect()
}

/// Periods from message to message, with adjacent ones of one kind merged.
fn stretches(states: &[TimedMessage<InterpolatorState>], plans: &[(String, PlanHeader)]) -> Vec<Period> {
    let mut stretches: Vec<Period> = Vec::new();
    // The last job's plans may have been driven before, by a part of the same kind: then its own time is the last.
    let mut before: Option<Period> = None;
    for at in states {
        let message = &at.message;
        if let Some(mut open) = before.take() {
            open.to = message.tick.max(open.from);
            add(&mut stretches, open);
        }
        let Some(plan) = plans.iter().position(|(hash, _)| *hash == message.plan_hash) else { continue };
        let again = stretches.last().is_some_and(|last| (plan, message.segment) < (last.plan, last.segment));
        if again {
            stretches.clear();
        }
        before = Some(Period {
            plan,
            phase: message.phase,
            lobe: usize::try_from(message.lobe).ok(),
            segment: message.segment,
            is_held: (InterpolatorState::HOLDING..=InterpolatorState::UNHOLDING).contains(&message.state),
            from: message.tick,
            to: message.tick,
            min_override: message.feed_override,
        });
    }
    stretches.extend(before);
    stretches
}

fn add(stretches: &mut Vec<Period>, next: Period) {
    match stretches.last_mut() {
        Some(last)
            if (last.plan, last.phase, last.lobe, last.segment, last.is_held)
                == (next.plan, next.phase, next.lobe, next.segment, next.is_held) =>
        {
            last.to = next.to;
            last.min_override = last.min_override.min(next.min_override);
        }
        _ => stretches.push(next),
    }
}
