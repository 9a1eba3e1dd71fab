//! What a bag holds of a run: the machine, the plans, and everything that machine and interpolator were given.

use super::RerunError;
use crate::axis_interpolator;
use crate::bag::{Bag, Message};
use crate::convert::plan::plan_from_pages;
use crate::convert::time::{TickClock, ns_from_time};
use crate::machine_sim;
use crate::planning::recorded_machine;
use crate::ros::message_from_sample;
use camwright::machine::description::MachineDescription;
use camwright::plan::Plan;
use camwright_msgs::Message as _;
use camwright_msgs::camwright_msgs::msg::{
    AppliedInput, MachineDescription as DescriptionMessage, MachineInput, MachineStream, PlanPage,
};
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use std::sync::Arc;

/// Topics of a cell, by their indices in the bag.
#[derive(Debug, Clone, Default)]
pub(super) struct Topics {
    pub(super) machine_inputs: Option<usize>,
    pub(super) interpolator_inputs: Option<usize>,
    pub(super) setpoints: Option<usize>,
    pub(super) stream: Option<usize>,
    pub(super) joint_states: Option<usize>,
    pub(super) io: Option<usize>,
    pub(super) gauge: Option<usize>,
    description: Option<usize>,
    plans: Option<usize>,
}

/// What was recorded of a run.
#[derive(Debug)]
pub(super) struct Recorded {
    pub(super) topics: Topics,
    pub(super) machine: MachineDescription,
    pub(super) clock: TickClock,
    pub(super) machine_inputs: Vec<MachineInput>,
    pub(super) interpolator_inputs: Vec<AppliedInput>,
    pages: HashMap<String, Vec<PlanPage>>,
    /// The last tick of which the machine told anything.
    pub(super) last_tick: u64,
}

/// Reads a message of a bag.
pub(super) fn read<T: DeserializeOwned>(bag: &Bag, message: &Message) -> Result<T, RerunError> {
    message_from_sample(&message.data).map_err(|reason| {
        let topic = bag.topics().get(message.topic).map_or("", |topic| topic.name.as_str());
        RerunError::Cannot(format!("message {} of {topic} cannot be read: {reason}", message.sequence))
    })
}

impl Topics {
    fn of(bag: &Bag) -> Result<Self, RerunError> {
        let of_type = |name: &'static str| bag.topics().iter().enumerate().filter(move |(_, t)| t.type_name == name);
        let mut inputs = of_type(MachineInput::TYPE_NAME);
        let Some((machine_inputs, topic)) = inputs.next() else {
            let reason =
                "it has no topic machine/inputs: a camwright made it that did not record inputs, or they were left out";
            return Err(RerunError::Cannot(reason.into()));
        };
        if let Some((_, other)) = inputs.next() {
            let reason = format!("it holds two machines, {} and {}; record one of them", topic.name, other.name);
            return Err(RerunError::Cannot(reason));
        }
        let cell = topic.name.strip_suffix("machine/inputs").unwrap_or("/");
        let named = |name: &str| {
            let name = format!("{cell}{name}");
            bag.topics().iter().position(|topic| topic.name == name)
        };
        let in_cell = |name: &'static str| {
            let mut all = of_type(name).filter(|(_, topic)| topic.name.starts_with(cell));
            all.next().map(|(index, _)| index)
        };
        Ok(Self {
            machine_inputs: Some(machine_inputs),
            interpolator_inputs: in_cell(AppliedInput::TYPE_NAME),
            setpoints: named("machine/setpoints"),
            stream: named("machine/stream"),
            joint_states: named("joint_states"),
            io: named("machine/io"),
            gauge: named("machine/gauge"),
            description: named("machine/description"),
            plans: in_cell(PlanPage::TYPE_NAME),
        })
    }
}

impl Recorded {
    /// Reads what was given, and looks whether all of it is there.
    ///
    /// # Errors
    /// A bag that cannot be read, or in which something is missing without which the run cannot be computed.
    pub(super) fn of(bag: &Bag) -> Result<Self, RerunError> {
        let topics = Topics::of(bag)?;
        let mut description: Option<DescriptionMessage> = None;
        let mut machine_inputs: Vec<MachineInput> = Vec::new();
        let mut interpolator_inputs: Vec<AppliedInput> = Vec::new();
        let mut pages: HashMap<String, Vec<PlanPage>> = HashMap::new();
        let mut last_tick = 0;
        let mut messages = bag.messages();
        while let Some(message) = messages.next_message()? {
            let at = Some(message.topic);
            if at == topics.machine_inputs {
                machine_inputs.push(read(bag, &message)?);
            } else if at == topics.interpolator_inputs {
                interpolator_inputs.push(read(bag, &message)?);
            } else if at == topics.description && description.is_none() {
                description = Some(read(bag, &message)?);
            } else if at == topics.plans {
                let page: PlanPage = read(bag, &message)?;
                let known = pages.entry(page.plan_hash.clone()).or_default();
                if !known.iter().any(|other| other.page == page.page) {
                    known.push(page);
                }
            } else if at == topics.stream {
                let stream: MachineStream = read(bag, &message)?;
                last_tick = last_tick.max(stream.tick);
            }
        }
        let description =
            description.ok_or_else(|| RerunError::Cannot("it does not say what the machine is".into()))?;
        let machine = recorded_machine(&description, &[]).map_err(RerunError::Cannot)?;
        let last = machine_inputs.last().map_or(0, |input| input.tick);
        let epoch_ns = machine_inputs.first().map_or(0, |input| ns_from_time(&input.stamp));
        let clock = TickClock { epoch_ns, cycle_time_ns: machine.cycle_time_ns };
        let last_tick = last_tick.max(last);
        let all = Self { topics, machine, clock, machine_inputs, interpolator_inputs, pages, last_tick };
        all.must_be_whole()?;
        Ok(all)
    }

    /// Nothing that was given is missing.
    fn must_be_whole(&self) -> Result<(), RerunError> {
        let of_machine = self.machine_inputs.iter().map(|input| (input.sequence, input.tick));
        whole("machine/inputs", of_machine)?;
        match self.machine_inputs.first() {
            Some(first) if first.kind == MachineInput::BEGIN => {}
            _ => return Err(RerunError::Cannot("it does not say how the machine began".into())),
        }
        if self.topics.interpolator_inputs.is_some() {
            let of_interpolator = self.interpolator_inputs.iter().map(|input| (input.sequence, input.tick));
            whole("axis_interpolator/inputs", of_interpolator)?;
        }
        let took_chunks = self.machine_inputs.iter().any(|input| input.kind == MachineInput::CHUNK);
        if took_chunks && self.topics.setpoints.is_none() {
            let reason = "the machine took setpoints, and machine/setpoints is not in it: they were left out";
            return Err(RerunError::Cannot(reason.into()));
        }
        Ok(())
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
            let is_changed = machine_sim::check_of_input(input) != Ok(input.check);
            let name = machine_sim::kind_name(input.kind);
            is_changed.then(|| (input.tick, format!("{name}, input {} of machine/inputs", input.sequence)))
        });
        let of_interpolator = self.interpolator_inputs.iter().filter_map(|input| {
            let is_changed = axis_interpolator::check_of_input(input) != Ok(input.check);
            let name = axis_interpolator::kind_name(input.kind);
            is_changed.then(|| (input.tick, format!("{name}, input {} of axis_interpolator/inputs", input.sequence)))
        });
        let mut changed: Vec<(u64, String)> = of_machine.chain(of_interpolator).collect();
        changed.sort();
        changed
    }
}

/// Sequence numbers from 0 on without a gap; with them their ticks.
fn whole(topic: &str, numbers: impl Iterator<Item = (u64, u64)>) -> Result<(), RerunError> {
    let mut tick_before = 0;
    for (expected, (number, tick)) in (0..).zip(numbers) {
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
    fn a_gap_is_told_with_its_inputs_and_ticks() {
        let refusal =
            |numbers: &[(u64, u64)]| whole("machine/inputs", numbers.iter().copied()).map_err(|e| e.to_string());
        assert_eq!(refusal(&[(0, 0), (1, 5), (2, 5)]), Ok(()));
        let text = refusal(&[(0, 0), (1, 5), (4, 9)]).expect_err("a gap");
        assert!(text.contains("inputs 2 to 3 are missing, between ticks 5 and 9"), "{text}");
        let text = refusal(&[(3, 9)]).expect_err("a late recorder");
        assert!(text.contains("the first 3 inputs, of before the recorder listened, are missing"), "{text}");
        assert!(refusal(&[(0, 0), (0, 1)]).expect_err("twice").contains("two runs"));
    }
}
