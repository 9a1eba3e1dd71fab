// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Simulated time: follows `/clock` while the parameter `use_sim_time` is set.
//!
//! The crate below reads `/clock` as `builtin_interfaces/msg/Time`, which no ROS 2 publisher sends; this reads
//! `rosgraph_msgs/msg/Clock`.

use std::sync::{Arc, Mutex, PoisonError};

use camwright_msgs::rosgraph_msgs::msg::Clock;

use super::clock::from_time;
use super::error::RosError;
use super::node::Node;
use super::parameter_value::ParameterValue;
use super::parameters::USE_SIM_TIME;
use super::qos::Qos;
use super::topics::{ReaderRequest, Subscription};

/// Subscription to `/clock`, there while it is needed.
type ClockReader = Mutex<Option<Subscription>>;

/// Lets a node's clock follow its parameter from now on.
pub(super) fn follow_parameter(node: &Node) -> Result<(), RosError> {
    let reader = Arc::<ClockReader>::default();
    follow(&reader, node, node.parameters().bool(USE_SIM_TIME))?;
    let (late, weak) = (Arc::downgrade(&reader), node.downgrade());
    node.parameters().on_change(move |changes| {
        for (name, value) in changes {
            if let (USE_SIM_TIME, ParameterValue::Bool(simulated)) = (name.as_str(), value)
                && let (Some(reader), Some(node)) = (late.upgrade(), weak.upgrade())
                && let Err(error) = follow(&reader, &node, *simulated)
            {
                node.logger().warn(&error.to_string());
            }
        }
    });
    node.retain(reader);
    Ok(())
}

fn follow(reader: &ClockReader, node: &Node, simulated: bool) -> Result<(), RosError> {
    let mut subscription = reader.lock().unwrap_or_else(PoisonError::into_inner);
    if simulated && subscription.is_none() {
        let clock = Arc::clone(node.clock());
        let name = node.resolve_topic("/clock")?;
        *subscription = Some(node.reader(
            ReaderRequest {
                name: &name,
                dds_name: super::names::dds_topic(&name),
                dds_type: <Clock as camwright_msgs::Message>::DDS_TYPE_NAME,
                qos: &Qos::clock(),
                delayable: false,
            },
            move |message: Clock, _| clock.set_simulated(from_time(&message.clock)),
        )?);
    } else if !simulated {
        *subscription = None;
    }
    node.clock().simulate(simulated);
    Ok(())
}
