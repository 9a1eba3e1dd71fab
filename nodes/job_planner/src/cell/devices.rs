// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Requests of the cell to other nodes: door and chuck, reset, feed hold, the judgement of a part. Answers come through the
//! mailbox.

use super::CellEvent;
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, SetBoolResponse, Trigger, TriggerRequest};
use camwright_ros::{Client, Node, RosError};
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// Time after which an unanswered request is repeated.
const PATIENCE: Duration = Duration::from_secs(5);
/// The least time between two requests for the same that was refused.
const AGAIN: Duration = Duration::from_millis(100);

/// Kinds of requests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DeviceRequest {
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
    mailbox: mpsc::Sender<CellEvent>,
    area: Option<AreaClients>,
    reset: Client<Trigger>,
    hold: Client<SetBool>,
    judge: Client<SetBool>,
    /// Asked for since, and whether the answer is still out.
    out: Vec<(DeviceRequest, Instant, bool)>,
}

impl Devices {
    pub(super) fn new(node: &Node, mailbox: mpsc::Sender<CellEvent>) -> Result<Self, RosError> {
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
    pub(super) fn ask(&mut self, asked: DeviceRequest) {
        let is_early = |(what, at, is_out): &(DeviceRequest, Instant, bool)| {
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

    fn send(&self, asked: DeviceRequest) -> Result<(), RosError> {
        let mailbox = self.mailbox.clone();
        let answer =
            move |success: bool, message: String| drop(mailbox.send(CellEvent::Answered(asked, success, message)));
        let trigger = TriggerRequest::default();
        let of_area = |clients: fn(&AreaClients) -> &[Client<Trigger>; 2], open: bool| {
            self.area.as_ref().map(|area| clients(area)[usize::from(open)].clone())
        };
        let client = match asked {
            DeviceRequest::Door(open) => of_area(|area| &area.door, open),
            DeviceRequest::Chuck(open) => of_area(|area| &area.chuck, open),
            DeviceRequest::Reset => Some(self.reset.clone()),
            DeviceRequest::Hold(hold) => {
                let request = SetBoolRequest { data: hold };
                return self.hold.call_with(&request, move |reply| answer(reply.success, reply.message)).map(drop);
            }
        };
        match client {
            Some(client) => client.call_with(&trigger, move |reply| answer(reply.success, reply.message)).map(drop),
            None => Ok(()),
        }
    }

    /// An answer has come.
    pub(super) fn answered(&mut self, asked: DeviceRequest) {
        for (what, _, is_out) in &mut self.out {
            if *what == asked {
                *is_out = false;
            }
        }
    }

    /// Reports the judgement of a part to the machine.
    pub(super) fn judge(&self, good: bool) {
        let node = self.node.clone();
        let answer = move |reply: SetBoolResponse| {
            if !reply.success {
                node.logger().warn(&format!("the part is not counted: {}", reply.message));
            }
        };
        if let Err(error) = self.judge.call_with(&SetBoolRequest { data: good }, answer) {
            self.node.logger().warn(&format!("the part is not counted: {error}"));
        }
    }
}
