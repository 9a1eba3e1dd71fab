// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Topics of a recorded cell, and their messages.

use super::error::RerunError;
use camwright_bag::schema_evolution::SchemaChange;
use camwright_bag::{Bag, BagMessage};
use camwright_msgs::Message as _;
use camwright_msgs::camwright_msgs::msg::{AppliedInput, MachineInput, PlanPage};
use camwright_msgs::cdr::message_from_sample;
use serde::de::DeserializeOwned;

/// Topics of a cell, by their indices in the bag.
#[derive(Debug, Clone, Default)]
pub(super) struct ReplayTopics {
    pub(super) machine_inputs: Option<usize>,
    pub(super) interpolator_inputs: Option<usize>,
    pub(super) setpoints: Option<usize>,
    pub(super) stream: Option<usize>,
    pub(super) joint_states: Option<usize>,
    pub(super) io: Option<usize>,
    pub(super) gauge: Option<usize>,
    pub(super) keyframes: Option<usize>,
    pub(super) alarms: Option<usize>,
    pub(super) description: Option<usize>,
    pub(super) plans: Option<usize>,
}

/// Reads a message of a bag.
pub(super) fn read<T: DeserializeOwned>(bag: &Bag, message: &BagMessage) -> Result<T, RerunError> {
    message_from_sample(&message.data).map_err(|reason| {
        let topic = bag.topics().get(message.topic).map_or("", |topic| topic.name.as_str());
        RerunError::Cannot(format!("message {} of {topic} cannot be read: {reason}", message.sequence))
    })
}

/// Reads a message of a bag that may have been recorded when its type had fewer fields.
pub(super) fn read_former<T: DeserializeOwned + camwright_msgs::Message>(
    bag: &Bag,
    mut message: BagMessage,
) -> Result<T, RerunError> {
    if let Some(topic) = bag.topics().get(message.topic) {
        SchemaChange::since(topic, T::SCHEMA).apply(&mut message.data);
    }
    read(bag, &message)
}

impl ReplayTopics {
    pub(super) fn find(bag: &Bag) -> Result<Self, RerunError> {
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
            keyframes: named("machine/keyframes"),
            alarms: named("machine/alarms"),
            description: named("machine/description"),
            plans: in_cell(PlanPage::TYPE_NAME),
        })
    }
}
