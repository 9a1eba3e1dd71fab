// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Our ROS layer on RustDDS, as the nodes use it.

use super::chunk::{Arrival, DEPTH, PATIENCE, TOPIC, print_arrivals, send_bursts};
use super::{Outcome, Task};
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use camwright_ros::{Durability, Node, NodeOptions, Qos, RosArgs};
use std::sync::mpsc;

fn node(name: &str) -> Result<Node, Box<dyn std::error::Error + Send + Sync>> {
    let (args, _rest) = RosArgs::parse(&[])?;
    Ok(Node::new(NodeOptions::new(name, &args))?)
}

fn qos(task: &Task) -> Qos {
    let mut qos = Qos::default_topic().keep_last(DEPTH);
    if task.latched {
        qos.durability = Durability::TransientLocal;
    }
    qos
}

pub fn send(task: &Task) -> Outcome {
    let node = node("axis_interpolator")?;
    let publisher = node.publisher::<JointTrajectory>(TOPIC, &qos(task))?;
    let _spin = node.spin_in_thread()?;
    let wait_for_receiver = || match task.latched || publisher.wait_matched(1, PATIENCE) {
        true => Ok(()),
        false => Err(format!("no subscriber of {TOPIC} in {PATIENCE:?}").into()),
    };
    send_bursts(task.count, wait_for_receiver, |chunk| Ok(publisher.publish(chunk)?))
}

pub fn receive(task: &Task) -> Outcome {
    let node = node("machine_sim")?;
    let (sender, arrivals) = mpsc::channel();
    let _subscription = node.subscribe::<JointTrajectory>(TOPIC, &qos(task), move |chunk, _| {
        let _receiver_has_ended = sender.send(Ok(Arrival::new(&chunk)));
    })?;
    let _spin = node.spin_in_thread()?;
    print_arrivals(task.count, &arrivals)
}
