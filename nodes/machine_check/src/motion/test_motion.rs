// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Who sends: the publishers and services of a sender, and waiting for what the machine makes of it.

use super::super::observed::{DescriptionFacts, Observed, Observer};
use super::travel::stamp;
use camwright_msgs::camwright_msgs::msg::{MachineCommand, MachineStream};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest, TriggerResponse};
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use camwright_ros::{Client, Node, Publisher, Qos, RosArgs, RosError, Shutdown, SpinThread};
use std::sync::mpsc;
use std::time::Duration;

/// Maximum time for the machine to answer, or to come to rest.
pub(super) const PATIENCE: Duration = Duration::from_secs(20);
/// Time to wait for a forbidden event, in messages of the stream.
const MESSAGES: usize = 12;

/// Why a test ended before its end.
#[derive(Debug)]
pub(super) enum EarlyEnd {
    /// Interrupt requested.
    Interrupted,
    /// Nothing more can be tried: the clause that is broken by it, and why.
    Stuck(u8, String),
}

impl From<RosError> for EarlyEnd {
    fn from(error: RosError) -> Self {
        Self::Stuck(9, error.to_string())
    }
}

/// A second sender, with a participant of its own.
pub(super) struct UnauthorisedClient {
    pub(super) setpoints: Publisher<JointTrajectory>,
    node: Node,
    _spin: SpinThread,
}

impl Drop for UnauthorisedClient {
    fn drop(&mut self) {
        self.node.shutdown();
    }
}

pub(super) struct TestMotion<'a> {
    pub(super) ears: &'a Observer,
    pub(super) facts: &'a DescriptionFacts,
    pub(super) epoch_ns: i64,
    pub(super) shutdown: &'a Shutdown,
    setpoints: Publisher<JointTrajectory>,
    commands: Publisher<MachineCommand>,
    reset: Client<Trigger>,
    estop: Client<SetBool>,
}

impl<'a> TestMotion<'a> {
    pub(super) fn new(
        node: &Node,
        ears: &'a Observer,
        facts: &'a DescriptionFacts,
        epoch_ns: i64,
        shutdown: &'a Shutdown,
    ) -> Result<Self, EarlyEnd> {
        let qos = Qos::default_topic().keep_last(1000);
        let hand = Self {
            setpoints: node.publisher("machine/setpoints", &qos)?,
            commands: node.publisher("machine/commands", &qos)?,
            reset: node.client("machine/reset")?,
            estop: node.client("machine/estop")?,
            ears,
            facts,
            epoch_ns,
            shutdown,
        };
        for (topic, met) in [
            ("machine/setpoints", hand.setpoints.wait_matched(1, PATIENCE)),
            ("machine/commands", hand.commands.wait_matched(1, PATIENCE)),
        ] {
            if !met {
                return Err(EarlyEnd::Stuck(9, format!("no node subscribes to {topic}")));
            }
        }
        hand.reset.wait_for_service(PATIENCE)?;
        Ok(hand)
    }

    /// A second sender beside this one.
    pub(super) fn stranger(args: &RosArgs) -> Result<UnauthorisedClient, EarlyEnd> {
        let node = Node::new(camwright_ros::NodeOptions::new("check_machine_stranger", args))
            .map_err(|error| EarlyEnd::Stuck(9, error.to_string()))?;
        let spin = node.spin_in_thread()?;
        let setpoints = node.publisher("machine/setpoints", &Qos::default_topic().keep_last(1000))?;
        if !setpoints.wait_matched(1, PATIENCE) {
            return Err(EarlyEnd::Stuck(9, "the machine does not meet a second sender".into()));
        }
        Ok(UnauthorisedClient { setpoints, node, _spin: spin })
    }

    pub(super) fn send(&self, chunk: &JointTrajectory) -> Result<(), EarlyEnd> {
        Ok(self.setpoints.publish(chunk)?)
    }

    pub(super) fn order(&self, sequence: u32, tick: u64, kind: u8, target: &str) -> Result<(), EarlyEnd> {
        let ticks = i64::try_from(tick).unwrap_or(i64::MAX);
        let at = stamp(self.epoch_ns.saturating_add(ticks.saturating_mul(self.facts.cycle_ns)));
        let command = MachineCommand { stamp: at, sequence, tick, kind, target: target.to_owned(), counts: 0 };
        Ok(self.commands.publish(&command)?)
    }

    pub(super) fn news(&self) -> MachineStream {
        self.ears.read(|observed| observed.last().cloned().unwrap_or_default())
    }

    /// Waits for the next tick of a machine whose ticks follow the clock: at rest the last message may be half the feedback delay old.
    pub(super) fn fresh_news(&self) -> MachineStream {
        let last = self.news();
        if last.pace == MachineStream::PACE_REALTIME {
            self.wait(|news| news.tick > last.tick);
        }
        self.news()
    }

    /// Waits for news that are as wanted; false after the time.
    pub(super) fn wait(&self, mut wanted: impl FnMut(&MachineStream) -> bool) -> bool {
        self.wait_observed(PATIENCE, |observed| observed.last().is_some_and(&mut wanted))
    }

    /// The same with everything that was received.
    pub(super) fn wait_observed(&self, patience: Duration, mut wanted: impl FnMut(&Observed) -> bool) -> bool {
        self.ears.wait(patience, |observed| wanted(observed).then_some(())).is_some()
    }

    /// Waits until the machine reports that it is at rest, with an alarm or without.
    pub(super) fn rest(&self) -> Result<(), EarlyEnd> {
        if self.wait(|news| !is_moving(news)) {
            return Ok(());
        }
        let news = self.news();
        Err(EarlyEnd::Stuck(
            8,
            format!("the machine does not come to rest within {} s: motion {}", PATIENCE.as_secs(), news.motion),
        ))
    }

    /// Waits for some messages of the stream, and returns whether the event has happened by then.
    pub(super) fn happens(&self, mut wanted: impl FnMut(&MachineStream) -> bool) -> bool {
        let begin = self.ears.read(|observed| observed.streams.len());
        let mut found = false;
        self.wait_observed(PATIENCE, |observed| {
            found |= observed.streams.iter().skip(begin).any(&mut wanted);
            found || observed.streams.len() >= begin + MESSAGES
        });
        found
    }

    /// Asks for a reset without waiting for the answer.
    pub(super) fn ask_reset(&self) -> Result<mpsc::Receiver<TriggerResponse>, EarlyEnd> {
        let (sender, answer) = mpsc::channel();
        self.reset.call_with(&TriggerRequest::default(), move |response| drop(sender.send(response)))?;
        Ok(answer)
    }

    /// Asks for a reset.
    pub(super) fn reset(&self) -> Result<TriggerResponse, EarlyEnd> {
        Ok(self.reset.call(&TriggerRequest::default(), PATIENCE)?)
    }

    /// Presses or releases the emergency stop of the software.
    pub(super) fn estop(&self, pressed: bool) -> Result<(), EarlyEnd> {
        self.estop.wait_for_service(PATIENCE)?;
        let answer = self.estop.call(&SetBoolRequest { data: pressed }, PATIENCE)?;
        if answer.success { Ok(()) } else { Err(EarlyEnd::Stuck(33, format!("machine/estop: {}", answer.message))) }
    }

    /// Waits for rest and resets: what this program did is not left to others.
    pub(super) fn clear(&self) -> Result<(), EarlyEnd> {
        self.rest()?;
        let answer = self.reset()?;
        if !answer.success {
            return Err(EarlyEnd::Stuck(30, format!("machine/reset at rest is refused: {}", answer.message)));
        }
        if self.wait(|news| news.alarms.is_empty() && !is_moving(news)) {
            return Ok(());
        }
        Err(EarlyEnd::Stuck(30, format!("alarms {:?} are active after their reset", self.news().alarms)))
    }

    /// Goes on, unless an interrupt was requested.
    pub(super) fn go_on(&self) -> Result<(), EarlyEnd> {
        if self.shutdown.is_requested() { Err(EarlyEnd::Interrupted) } else { Ok(()) }
    }
}

/// The axes move, or are about to.
pub(super) fn is_moving(news: &MachineStream) -> bool {
    matches!(news.motion, MachineStream::MOTION_RUNNING | MachineStream::MOTION_STOPPING)
}
