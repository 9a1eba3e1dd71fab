// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Content of a recorded run: the machine, the plans, and all inputs of machine and interpolator.

use super::error::RerunError;
use super::keyframes;
use super::topics::{ReplayTopics, read, read_former};
use super::window::Window;
use camwright::machine::description::MachineDescription;
use camwright::motion::plan::Plan;
use camwright_bag::Bag;
use camwright_files::convert::applied_input;
use camwright_files::convert::keyframes::PartialKeyframe;
use camwright_files::convert::machine_now::recorded_machine;
use camwright_files::convert::plan::plan_from_pages;
use camwright_files::convert::time::{TickClock, ns_from_time};
use camwright_machine_cycle::{input_record, keyframes::FORM as KEYFRAME_FORM};
use camwright_msgs::camwright_msgs::msg::{
    AppliedInput, MachineDescription as DescriptionMessage, MachineInput, MachineKeyframe, MachineStream, PlanPage,
};
use std::collections::HashMap;
use std::sync::Arc;

/// Most ticks between two messages of the machine: it publishes ten times a second and more, and no recorder pauses for longer than a quarter
/// of an hour of 1 ms ticks without losing inputs.
const MAX_LEAP_TICKS: u64 = 1_000_000;

/// Recorded run.
#[derive(Debug)]
pub(super) struct RecordedInputs {
    pub(super) topics: ReplayTopics,
    pub(super) machine: MachineDescription,
    pub(super) clock: TickClock,
    pub(super) machine_inputs: Vec<MachineInput>,
    pub(super) interpolator_inputs: Vec<AppliedInput>,
    pages: HashMap<String, Vec<PlanPage>>,
    /// Keyframes whose pages are all there, in the order of their ticks, without their states.
    pub(super) keyframes: Vec<MachineKeyframe>,
    /// That from which the run is computed; none: from its beginning.
    pub(super) start: Option<MachineKeyframe>,
    /// Last tick to compute: the last with any output, or the requested one.
    pub(super) last_tick: u64,
}

impl RecordedInputs {
    /// Reads what was given, and looks whether all of it is there that the window takes.
    ///
    /// # Errors
    /// A bag that cannot be read, or in which something is missing without which the run cannot be computed.
    pub(super) fn from_bag(bag: &Bag, window: Window) -> Result<Self, RerunError> {
        let topics = ReplayTopics::find(bag)?;
        let mut description: Option<DescriptionMessage> = None;
        let mut machine_inputs: Vec<MachineInput> = Vec::new();
        let mut interpolator_inputs: Vec<AppliedInput> = Vec::new();
        let mut pages: HashMap<String, Vec<PlanPage>> = HashMap::new();
        let (mut heads, mut arriving): (Vec<MachineKeyframe>, _) = (Vec::new(), PartialKeyframe::default());
        let (mut last_tick, mut ticks) = (0, Vec::new());
        let mut messages = bag.messages();
        while let Some(message) = messages.next_message()? {
            let at = Some(message.topic);
            if at == topics.machine_inputs {
                machine_inputs.push(read(bag, &message)?);
            } else if at == topics.interpolator_inputs {
                interpolator_inputs.push(read(bag, &message)?);
            } else if at == topics.description && description.is_none() {
                description = Some(read_former(bag, message)?);
            } else if at == topics.plans {
                let page: PlanPage = read(bag, &message)?;
                let known = pages.entry(page.plan_hash.clone()).or_default();
                if !known.iter().any(|other| other.page == page.page) {
                    known.push(page);
                }
            } else if at == topics.keyframes {
                heads.extend(arriving.add(&read(bag, &message)?));
            } else if at == topics.stream {
                let stream: MachineStream = read(bag, &message)?;
                last_tick = last_tick.max(stream.tick);
                ticks.push(stream.tick);
            }
        }
        let description = description.ok_or_else(|| RerunError::Cannot("it holds no machine description".into()))?;
        let machine = recorded_machine(&description, &[]).map_err(RerunError::Cannot)?;
        let last = machine_inputs.last().map_or(0, |input| input.tick);
        let epoch_ns = machine_inputs.first().map_or(0, |input| {
            let since = i64::try_from(input.tick).unwrap_or(i64::MAX).saturating_mul(machine.cycle_time_ns.into());
            ns_from_time(&input.stamp).saturating_sub(since)
        });
        let clock = TickClock { epoch_ns, cycle_time_ns: machine.cycle_time_ns };
        let last_tick = last_tick.max(last).min(window.to_tick.unwrap_or(u64::MAX));
        heads.sort_by_key(|head| head.tick);
        let (start, keyframes) = (None, heads);
        let mut all =
            Self { topics, machine, clock, machine_inputs, interpolator_inputs, pages, keyframes, start, last_tick };
        if let (Some(_), Some(drives)) = (window.from_tick, all.drives()) {
            let reason =
                format!("the machine is real ({drives}) and has no keyframes; it is computed without --from-tick");
            return Err(RerunError::Cannot(reason));
        }
        if let Some(tick) = window.from_tick {
            match keyframes::last_before(&all.keyframes, tick) {
                Ok(head) => all.begin_with(head.clone()),
                // Before the first keyframe there is the beginning, if it was recorded.
                Err(_) if all.begins_before_keyframes(tick) => {}
                Err(reason) => return Err(RerunError::Cannot(reason)),
            }
        }
        all.must_be_whole()?;
        all.must_not_leap(ticks)?;
        if let Some(start) = all.start.as_ref().filter(|start| start.tick >= all.last_tick) {
            let (start, last) = (start.tick, all.last_tick);
            return Err(RerunError::Cannot(format!("there is no tick between {start} and {last}, the last one")));
        }
        Ok(all)
    }

    /// Bus to real drives; `None`: the machine was simulated.
    pub(super) fn drives(&self) -> Option<String> {
        self.machine_inputs.first().and_then(input_record::drives_of)
    }

    fn begins_before_keyframes(&self, tick: u64) -> bool {
        let begins = self.machine_inputs.first().is_some_and(|input| input.kind == MachineInput::BEGIN);
        begins && self.keyframes.first().is_some_and(|head| head.tick > tick)
    }

    /// From here on only that counts which comes after a keyframe: of the machine what it was given, of the interpolator the motion under
    /// way, from its start.
    fn begin_with(&mut self, head: MachineKeyframe) {
        self.machine_inputs.retain(|input| input.sequence >= head.sequence);
        let is_start = |input: &AppliedInput| input.kind == AppliedInput::START;
        let under_way = self.interpolator_inputs.iter().rposition(|input| is_start(input) && input.tick <= head.tick);
        if let Some(first) = under_way.or_else(|| self.interpolator_inputs.iter().position(is_start)) {
            self.interpolator_inputs.drain(..first);
        }
        self.start = Some(head);
    }

    /// Nothing that was given is missing.
    fn must_be_whole(&self) -> Result<(), RerunError> {
        let of_machine = self.machine_inputs.iter().map(|input| (input.sequence, input.tick));
        let first = self.start.as_ref().map_or(0, |start| start.sequence);
        whole("machine/inputs", first, of_machine).map_err(|error| self.with_hint(error))?;
        match self.machine_inputs.first() {
            Some(first) if first.kind == MachineInput::BEGIN || self.start.is_some() => {}
            None if self.start.is_some() => {}
            _ => return Err(RerunError::Cannot("it holds no initial state of the machine".into())),
        }
        if self.topics.interpolator_inputs.is_some() {
            let of_interpolator = self.interpolator_inputs.iter().map(|input| (input.sequence, input.tick));
            let first = self.interpolator_inputs.first().filter(|_| self.start.is_some());
            whole("axis_interpolator/inputs", first.map_or(0, |first| first.sequence), of_interpolator)?;
        }
        let took_chunks = self.machine_inputs.iter().any(|input| input.kind == MachineInput::CHUNK);
        if took_chunks && self.topics.setpoints.is_none() {
            let reason = "the machine took setpoints, and machine/setpoints is not in it: they were left out";
            return Err(RerunError::Cannot(reason.into()));
        }
        Ok(())
    }

    /// The ticks that are computed follow each other without a leap: a damaged number would ask for years of them.
    fn must_not_leap(&self, mut ticks: Vec<u64>) -> Result<(), RerunError> {
        ticks.extend(self.machine_inputs.iter().map(|input| input.tick));
        ticks.push(self.last_tick);
        ticks.sort_unstable();
        let mut before = self.start.as_ref().map_or(0, |start| start.tick);
        for tick in ticks.into_iter().filter(|tick| *tick <= self.last_tick) {
            let leap = tick.saturating_sub(before);
            if leap > MAX_LEAP_TICKS {
                return Err(RerunError::Cannot(format!(
                    "nothing is recorded of the machine between tick {before} and tick {tick}, which are {leap} ticks; at most \
                     {MAX_LEAP_TICKS} are computed without a message: a message is damaged, or --to-tick {before} ends before the gap"
                )));
            }
            before = before.max(tick);
        }
        Ok(())
    }

    /// Adds the hint that a run without its beginning may be replayed from a keyframe on.
    fn with_hint(&self, error: RerunError) -> RerunError {
        let RerunError::Cannot(reason) = error else { return error };
        let numbers = |from: u64| {
            let after = self.machine_inputs.iter().filter(move |input| input.sequence >= from);
            after.map(|input| (input.sequence, input.tick))
        };
        let is_whole = |head: &&MachineKeyframe| whole("", head.sequence, numbers(head.sequence)).is_ok();
        let later = self.keyframes.iter().filter(|head| self.start.as_ref().is_none_or(|start| head.tick > start.tick));
        RerunError::Cannot(match later.filter(is_whole).find(|head| head.form == KEYFRAME_FORM) {
            Some(head) => format!("{reason}; from a keyframe on it is whole: --from-tick {}", head.tick),
            None => reason,
        })
    }

    /// The plan with a hash.
    pub(super) fn plan(&self, hash: &str) -> Result<Arc<Plan>, String> {
        let pages = self.pages.get(hash).ok_or_else(|| format!("plan {hash} is not in the bag"))?;
        let (plan, _) = plan_from_pages(pages, &self.machine).map_err(|error| format!("plan {hash}: {error}"))?;
        Ok(Arc::new(plan))
    }

    /// Inputs that are not as they were recorded, as tick and what it is.
    pub(super) fn changed(&self) -> Vec<(u64, String)> {
        let of_machine = self.machine_inputs.iter().filter_map(|input| {
            let is_changed = input_record::check(input) != Ok(input.check);
            let name = input_record::kind_name(input.kind);
            is_changed.then(|| (input.tick, format!("{name}, input {} of machine/inputs", input.sequence)))
        });
        let of_interpolator = self.interpolator_inputs.iter().filter_map(|input| {
            let is_changed = applied_input::check(input) != Ok(input.check);
            let name = applied_input::kind_name(input.kind);
            is_changed.then(|| (input.tick, format!("{name}, input {} of axis_interpolator/inputs", input.sequence)))
        });
        let mut changed: Vec<(u64, String)> = of_machine.chain(of_interpolator).collect();
        changed.sort();
        changed
    }
}

/// Sequence numbers from `first` on without a gap; with them their ticks.
fn whole(topic: &str, first: u64, numbers: impl Iterator<Item = (u64, u64)>) -> Result<(), RerunError> {
    let mut tick_before = 0;
    for (expected, (number, tick)) in (first..).zip(numbers) {
        if number > expected {
            let which = match (expected, number - expected) {
                (0, 1) => "the first input, of before the recorder listened, is".to_owned(),
                (0, _) => format!("the first {number} inputs, of before the recorder listened, are"),
                (_, 1) => format!("input {expected} is"),
                _ => format!("inputs {expected} to {} are", number - 1),
            };
            let reason = format!("{topic} is not whole: {which} missing, between ticks {tick_before} and {tick}");
            return Err(RerunError::Cannot(reason));
        }
        if number < expected {
            return Err(RerunError::Cannot(format!("{topic} has input {number} twice: it holds two runs")));
        }
        tick_before = tick;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_is_reported_with_its_inputs_and_ticks() {
        let refusal =
            |numbers: &[(u64, u64)]| whole("machine/inputs", 0, numbers.iter().copied()).map_err(|e| e.to_string());
        assert_eq!(refusal(&[(0, 0), (1, 5), (2, 5)]), Ok(()));
        let text = refusal(&[(0, 0), (1, 5), (4, 9)]).expect_err("a gap");
        assert!(text.contains("inputs 2 to 3 are missing, between ticks 5 and 9"), "{text}");
        let text = refusal(&[(3, 9)]).expect_err("a late recorder");
        assert!(text.contains("the first 3 inputs, of before the recorder listened, are missing"), "{text}");
        assert!(refusal(&[(0, 0), (0, 1)]).expect_err("twice").contains("two runs"));
    }
}
