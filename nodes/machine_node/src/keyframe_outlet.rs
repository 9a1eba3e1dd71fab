// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The topic of keyframes.

use camwright_files::convert::keyframes::pages;
use camwright_machine_cycle::keyframes::{FORM, PERIOD_S, Room};
use camwright_msgs::camwright_msgs::msg::MachineKeyframe;
use camwright_ros::{Node, Parameter, Parameters, Publisher, Qos, RosError};

/// Pages that a recorder may be behind: 8 MB.
const DEPTH: u32 = 256;

#[derive(Debug)]
pub(super) struct KeyframeOutlet {
    publisher: Publisher<MachineKeyframe>,
    has_failed: bool,
}

impl KeyframeOutlet {
    pub(super) fn new(node: &Node) -> Result<Self, RosError> {
        let publisher = node.publisher("machine/keyframes", &Qos::default_topic().keep_last(DEPTH))?;
        Ok(Self { publisher, has_failed: false })
    }

    /// Publishes a state; `head` has its tick. Late subscribers do not receive it: it is useless without the messages after it.
    pub(super) fn publish(&mut self, head: MachineKeyframe, room: &Room, node: &Node) -> Result<(), RosError> {
        match room.state() {
            Ok(_) if self.publisher.matched() == 0 => Ok(()),
            Ok(state) => {
                let head = MachineKeyframe { form: FORM, ..head };
                pages(head, state).try_for_each(|page| self.publisher.publish(&page))
            }
            Err(error) => {
                if !std::mem::replace(&mut self.has_failed, true) {
                    node.logger().warn(&format!("there is no keyframe of tick {}: {error}", head.tick));
                }
                Ok(())
            }
        }
    }
}

/// Parameter: time of the machine between two keyframes.
const PERIOD: &str = "keyframe_period_s";

/// Parameters of the keyframes.
pub(super) fn parameters() -> [Parameter; 1] {
    [Parameter::double(PERIOD, PERIOD_S)
        .describe("machine time between two keyframes (s), from which a replay can begin; 0: none")
        .range(0.0, 3600.0)
        .read_only()]
}

/// Returns the time of the machine between two keyframes (s).
pub(super) fn period_s(parameters: &Parameters) -> f64 {
    parameters.double(PERIOD)
}
