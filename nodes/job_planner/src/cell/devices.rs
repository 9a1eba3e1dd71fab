//! What the cell asks others for: door and chuck, reset, feed hold, the judgement of a part. Answers come through the mailbox.

use super::Told;
use camwright_msgs::camwright_msgs::srv::{FeedHold, FeedHoldRequest, JudgePart, JudgePartRequest};
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_ros::{Client, Node, RosError};
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// How long an answer may take before the request is made again.
const PATIENCE: Duration = Duration::from_secs(5);
/// The least time between two requests for the same that was refused.
const AGAIN: Duration = Duration::from_millis(100);

/// What was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Asked {
    /// The door: open, or close.
    Door(bool),
    Chuck(bool),
    Reset,
    Hold(bool),
}

/// Door and chuck of a machine that has some.
#[derive(Debug)]
struct AreaClients {
    door: [Client<Trigger>; 2],
    chuck: [Client<Trigger>; 2],
}

/// The clients, and what is being waited for.
#[derive(Debug)]
pub(super) struct Devices {
    node: Node,
    mailbox: mpsc::Sender<Told>,
    area: Option<AreaClients>,
    reset: Client<Trigger>,
    hold: Client<FeedHold>,
    judge: Client<JudgePart>,
    /// Asked for since, and whether the answer is still out.
    out: Vec<(Asked, Instant, bool)>,
}

impl Devices {
    pub(super) fn new(node: &Node, mailbox: mpsc::Sender<Told>) -> Result<Self, RosError> {
        Ok(Self {
            node: node.clone(),
            mailbox,
            area: None,
            reset: node.client("machine/reset")?,
            hold: node.client("axis_interpolator/feed_hold")?,
            judge: node.client("machine/judge_part")?,
            out: Vec::new(),
        })
    }

    /// The machine has a door and a chuck.
    pub(super) fn meet_area(&mut self) -> Result<(), RosError> {
        if self.area.is_none() {
            let pair = |open: &str, close: &str| Ok::<_, RosError>([self.node.client(close)?, self.node.client(open)?]);
            self.area = Some(AreaClients {
                door: pair("machine/open_door", "machine/close_door")?,
                chuck: pair("machine/open_chuck", "machine/close_chuck")?,
            });
        }
        Ok(())
    }

    /// Asks for something unless it was asked for just now.
    pub(super) fn ask(&mut self, asked: Asked) {
        let is_early = |(what, at, is_out): &(Asked, Instant, bool)| {
            *what == asked && at.elapsed() < if *is_out { PATIENCE } else { AGAIN }
        };
        if self.out.iter().any(is_early) {
            return;
        }
        self.out.retain(|(what, ..)| *what != asked);
        self.out.push((asked, Instant::now(), true));
        if let Err(error) = self.send(asked) {
            self.node.logger().warn(&error.to_string());
        }
    }

    fn send(&self, asked: Asked) -> Result<(), RosError> {
        let mailbox = self.mailbox.clone();
        let answer = move |success: bool, message: String| drop(mailbox.send(Told::Answered(asked, success, message)));
        let trigger = TriggerRequest::default();
        let of_area = |clients: fn(&AreaClients) -> &[Client<Trigger>; 2], open: bool| {
            self.area.as_ref().map(|area| clients(area)[usize::from(open)].clone())
        };
        let client = match asked {
            Asked::Door(open) => of_area(|area| &area.door, open),
            Asked::Chuck(open) => of_area(|area| &area.chuck, open),
            Asked::Reset => Some(self.reset.clone()),
            Asked::Hold(hold) => {
                let request = FeedHoldRequest { hold };
                return self.hold.call_with(&request, move |reply| answer(reply.success, reply.message)).map(drop);
            }
        };
        match client {
            Some(client) => client.call_with(&trigger, move |reply| answer(reply.success, reply.message)).map(drop),
            None => Ok(()),
        }
    }

    /// An answer has come.
    pub(super) fn answered(&mut self, asked: Asked) {
        for (what, _, is_out) in &mut self.out {
            if *what == asked {
                *is_out = false;
            }
        }
    }

    /// Tells the machine what became of a part.
    pub(super) fn judge(&self, good: bool) {
        let node = self.node.clone();
        let answer = move |reply: camwright_msgs::camwright_msgs::srv::JudgePartResponse| {
            if !reply.success {
                node.logger().warn(&format!("the part is not counted: {}", reply.message));
            }
        };
        if let Err(error) = self.judge.call_with(&JudgePartRequest { good }, answer) {
            self.node.logger().warn(&format!("the part is not counted: {error}"));
        }
    }
}
