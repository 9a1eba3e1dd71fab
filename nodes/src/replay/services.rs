//! The services of rosbag2's player. They pass on what is asked; the player answers once it has done it.

use std::sync::mpsc;

use camwright_msgs::rosbag2_interfaces::srv::{
    Burst, GetRate, IsPaused, Pause, Play, PlayNext, PlayRequest, Resume, Seek, SetRate, Stop, TogglePaused,
};

use crate::ros::{Node, Responder, RosError, ServiceHandle, from_time};

/// What the player is asked, and whom it answers.
#[derive(Debug)]
pub(super) enum Order {
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
    /// So many messages; 0: all.
    Burst(u64, Responder<Burst>),
    /// A moment of the bag (ns since 1970).
    Seek(i64, Responder<Seek>),
    Play(PlayRequest, Responder<Play>),
}

/// Offers the services of rosbag2's player under the node's name.
pub(super) fn offer(node: &Node, orders: &mpsc::Sender<Order>) -> Result<Vec<ServiceHandle>, RosError> {
    // A player that has ended answers nobody.
    let pass = |order: Order, orders: &mpsc::Sender<Order>| drop(orders.send(order));
    let own = || orders.clone();
    let (a, b, c, d) = (own(), own(), own(), own());
    let (e, f, g, h) = (own(), own(), own(), own());
    let (i, j, k) = (own(), own(), own());
    Ok(vec![
        node.service_deferred::<Stop>("~/stop", move |_, to| pass(Order::Stop(to), &a))?,
        node.service_deferred::<Pause>("~/pause", move |_, to| pass(Order::Pause(to), &b))?,
        node.service_deferred::<Resume>("~/resume", move |_, to| pass(Order::Resume(to), &c))?,
        node.service_deferred::<TogglePaused>("~/toggle_paused", move |_, to| pass(Order::TogglePaused(to), &d))?,
        node.service_deferred::<IsPaused>("~/is_paused", move |_, to| pass(Order::IsPaused(to), &e))?,
        node.service_deferred::<GetRate>("~/get_rate", move |_, to| pass(Order::GetRate(to), &f))?,
        node.service_deferred::<SetRate>("~/set_rate", move |wanted, to| pass(Order::SetRate(wanted.rate, to), &g))?,
        node.service_deferred::<PlayNext>("~/play_next", move |_, to| pass(Order::PlayNext(to), &h))?,
        node.service_deferred::<Burst>("~/burst", move |wanted, to| pass(Order::Burst(wanted.num_messages, to), &i))?,
        node.service_deferred::<Seek>("~/seek", move |wanted, to| pass(Order::Seek(from_time(&wanted.time), to), &j))?,
        node.service_deferred::<Play>("~/play", move |wanted, to| pass(Order::Play(wanted, to), &k))?,
    ])
}
