// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The services of rosbag2's player. They pass on what is asked; the player answers once it has done it.

use std::sync::mpsc;

use camwright_msgs::Service;
use camwright_msgs::rosbag2_interfaces::srv::{
    Burst, GetRate, IsPaused, Pause, Play, PlayNext, PlayRequest, Resume, Seek, SetRate, Stop, TogglePaused,
};

use camwright_ros::{Node, Responder, RosError, ServiceHandle, from_time};

/// Request to the player, with its client.
#[derive(Debug)]
pub(super) enum PlayerCommand {
    /// The process is to end.
    End,
    Stop(Responder<Stop>),
    Pause(Responder<Pause>),
    Resume(Responder<Resume>),
    TogglePaused(Responder<TogglePaused>),
    IsPaused(Responder<IsPaused>),
    GetRate(Responder<GetRate>),
    SetRate(f64, Responder<SetRate>),
    PlayNext(Responder<PlayNext>),
    /// Number of messages; 0: all.
    Burst(u64, Responder<Burst>),
    /// A moment of the bag (ns since 1970).
    Seek(i64, Responder<Seek>),
    Play(PlayRequest, Responder<Play>),
}

/// Offers the services of rosbag2's player under the node's name.
pub(super) fn offer(node: &Node, orders: &mpsc::Sender<PlayerCommand>) -> Result<Vec<ServiceHandle>, RosError> {
    Ok(vec![
        passed(node, "~/stop", orders, |_, to| PlayerCommand::Stop(to))?,
        passed(node, "~/pause", orders, |_, to| PlayerCommand::Pause(to))?,
        passed(node, "~/resume", orders, |_, to| PlayerCommand::Resume(to))?,
        passed(node, "~/toggle_paused", orders, |_, to| PlayerCommand::TogglePaused(to))?,
        passed(node, "~/is_paused", orders, |_, to| PlayerCommand::IsPaused(to))?,
        passed(node, "~/get_rate", orders, |_, to| PlayerCommand::GetRate(to))?,
        passed::<SetRate>(node, "~/set_rate", orders, |wanted, to| PlayerCommand::SetRate(wanted.rate, to))?,
        passed(node, "~/play_next", orders, |_, to| PlayerCommand::PlayNext(to))?,
        passed::<Burst>(node, "~/burst", orders, |wanted, to| PlayerCommand::Burst(wanted.num_messages, to))?,
        passed::<Seek>(node, "~/seek", orders, |wanted, to| PlayerCommand::Seek(from_time(&wanted.time), to))?,
        passed(node, "~/play", orders, PlayerCommand::Play)?,
    ])
}

/// A service whose requests become orders. A player that has ended answers no request.
fn passed<S: Service>(
    node: &Node,
    name: &str,
    orders: &mpsc::Sender<PlayerCommand>,
    order: fn(S::Request, Responder<S>) -> PlayerCommand,
) -> Result<ServiceHandle, RosError> {
    let orders = orders.clone();
    node.service_deferred::<S>(name, move |request, to| drop(orders.send(order(request, to))))
}
