// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Who asks: a node of our ROS layer, the same for everybody who answers.

use super::figures::{Dice, Row};
use super::support::Domain;
use camwright_files::convert::time::{ns_from_time, time_from_ns};
use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::camwright_msgs::msg::{MachineIo, MachineStream};
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use camwright_msgs::{Message, Service};
use camwright_ros::{Node, NodeOptions, Qos, RosArgs, SpinThread};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Time after which an answer counts as lost.
const PATIENCE: Duration = Duration::from_secs(5);
/// Maximum time of discovery.
pub const DISCOVERY: Duration = Duration::from_secs(60);
/// Samples that are not counted: the first ones find caches empty.
const WARM_UP: usize = 20;
/// Longest pause between two samples.
const PAUSE: Duration = Duration::from_millis(6);

/// Message that begins with a stamp, which relates an answer to its question.
pub trait Stamped: Message + Clone {
    fn stamp(&self) -> &Time;
    fn set_stamp(&mut self, stamp: Time);
}

macro_rules! stamped {
    ($($message:ty: $($field:ident).+),*) => {$(
        impl Stamped for $message {
            fn stamp(&self) -> &Time {
                &self.$($field).+
            }
            fn set_stamp(&mut self, stamp: Time) {
                self.$($field).+ = stamp;
            }
        }
    )*};
}
stamped!(JointTrajectory: header.stamp, MachineStream: stamp, MachineIo: stamp);

/// Quality of service of the machine's topics.
pub fn qos() -> Qos {
    Qos::default_topic().keep_last(1000)
}

pub fn now_ns() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
}

/// A time between two stamps of the system clock; 0 if it was set back in between.
pub fn between_ns(from: i64, to: i64) -> Duration {
    Duration::from_nanos(u64::try_from(to.saturating_sub(from)).unwrap_or(0))
}

/// A node that asks, and what it needs to.
pub struct Asker {
    pub node: Node,
    pub dice: Dice,
    /// Ctrl-C was pressed: what there is is printed.
    pub interrupted: Arc<AtomicBool>,
    _spin: SpinThread,
}

impl Asker {
    pub fn new(domain: &Domain, seed: u64, interrupted: &Arc<AtomicBool>) -> Self {
        let args = RosArgs::default().with_domain_id(domain.id());
        let node = Node::new(NodeOptions::new("asker", &args)).expect("a node");
        let spin = node.spin_in_thread().expect("a thread");
        Self { node, dice: Dice::new(seed), interrupted: Arc::clone(interrupted), _spin: spin }
    }

    pub fn goes_on(&self) -> bool {
        !self.interrupted.load(Ordering::Relaxed)
    }

    pub fn pause(&mut self) {
        std::thread::sleep(self.dice.below(PAUSE));
    }

    /// Publishes a message so often and waits for its answer each time: until the answer left, and until it was here.
    pub fn exchange<Q: Stamped, A: Stamped>(
        &mut self,
        [to, from]: [&str; 2],
        question: &Q,
        [one_way, round_trip]: [&mut Row; 2],
    ) {
        let (sender, answers) = mpsc::channel();
        let publisher = self.node.publisher::<Q>(to, &qos()).expect("a publisher");
        let subscription = self.node.subscribe::<A>(from, &qos(), move |answer, info| {
            let times = (ns_from_time(answer.stamp()), info.source_timestamp_ns, Instant::now());
            let _nobody_asks_any_more = sender.send(times);
        });
        let subscription = subscription.expect("a subscription");
        let matched = publisher.wait_matched(1, DISCOVERY) && subscription.wait_matched(1, DISCOVERY);
        assert!(matched, "nobody answers on {from}");
        let mut question = question.clone();
        for number in 0..round_trip.wanted + WARM_UP {
            if !self.goes_on() {
                return;
            }
            let stamp = i64::try_from(number).expect("some thousand");
            question.set_stamp(time_from_ns(stamp));
            let (asked_ns, asked) = (now_ns(), Instant::now());
            publisher.publish(&question).expect("it can be published");
            let answer = loop {
                match answers.recv_timeout(PATIENCE) {
                    Ok(answer) if answer.0 == stamp => break Some(answer),
                    Ok(_of_an_earlier_one) => {}
                    Err(_) => break None,
                }
            };
            match answer {
                _ if number < WARM_UP => {}
                Some((_, left_ns, here)) => {
                    one_way.times.extend(left_ns.map(|left_ns| between_ns(asked_ns, left_ns)));
                    round_trip.times.push(here - asked);
                }
                None => {
                    one_way.lost += 1;
                    round_trip.lost += 1;
                }
            }
            self.pause();
        }
    }

    /// Calls a service so often: from call to answer.
    pub fn call<S: Service>(&mut self, name: &str, mut request: impl FnMut() -> S::Request, row: &mut Row) {
        let client = self.node.client::<S>(name).expect("a client");
        client.wait_for_service(DISCOVERY).expect("the service");
        for number in 0..row.wanted + WARM_UP {
            if !self.goes_on() {
                return;
            }
            let request = request();
            let asked = Instant::now();
            let answer = client.call(&request, PATIENCE);
            let taken = asked.elapsed();
            match answer {
                _ if number < WARM_UP => {}
                Ok(_) => row.times.push(taken),
                Err(_) => row.lost += 1,
            }
            self.pause();
        }
    }
}
