// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Topics of the machine: only messages of the machine that keeps the lease count.

use super::grant::Grant;
use super::lease::{Participant, participant_of};
use super::lock;
use camwright_msgs::Message;
use camwright_ros::{Guid, Node, Qos, RosError, Subscription};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

/// Other senders whose messages are retained, in case that one of them is a machine that was just started.
const MAX_SENDERS: usize = 4;

/// Messages of senders that are not known to be the machine.
#[derive(Debug)]
struct Retained<M> {
    depth: usize,
    senders: VecDeque<(Participant, VecDeque<(M, Guid)>)>,
}

impl<M> Retained<M> {
    /// Retains a message; the oldest of its sender and the oldest sender are dropped beyond the limits.
    fn add(&mut self, by: Participant, message: M, writer: Guid) {
        if self.depth == 0 {
            return;
        }
        let at = self.senders.iter().position(|(sender, _)| *sender == by).unwrap_or_else(|| {
            if self.senders.len() >= MAX_SENDERS {
                self.senders.pop_front();
            }
            self.senders.push_back((by, VecDeque::new()));
            self.senders.len() - 1
        });
        let messages = &mut self.senders[at].1;
        if messages.len() >= self.depth {
            messages.pop_front();
        }
        messages.push_back((message, writer));
    }

    /// Removes and returns the messages of a sender.
    fn drain(&mut self, by: Participant) -> VecDeque<(M, Guid)> {
        let at = self.senders.iter().position(|(sender, _)| *sender == by);
        at.and_then(|at| self.senders.remove(at)).map(|(_, messages)| messages).unwrap_or_default()
    }
}

struct SenderFilter<M, F> {
    retained: Retained<M>,
    take: F,
}

/// Subscribes to a topic of the machine. Messages of other senders never reach `take`; the last `depth` of each are retained, because a machine
/// may publish before this node knows it.
///
/// # Errors
/// See [`Node::subscribe`].
pub fn subscribe_to_machine<M: Message + Send>(
    node: &Node,
    grant: &Arc<Grant>,
    topic: &str,
    (qos, depth): (&Qos, usize),
    take: impl FnMut(M, &Guid) + Send + 'static,
) -> Result<Subscription, RosError> {
    let retained = Retained { depth, senders: VecDeque::new() };
    let filter = Arc::new(Mutex::new(SenderFilter { retained, take }));
    let late = Arc::downgrade(&filter);
    grant.on_machine(move |machine| {
        let Some(filter) = late.upgrade() else { return };
        let mut filter = lock(&filter);
        for (message, writer) in filter.retained.drain(machine) {
            (filter.take)(message, &writer);
        }
    });
    let (grant, listener, name) = (Arc::clone(grant), node.clone(), topic.to_owned());
    node.subscribe::<M>(topic, qos, move |message, info| {
        let by = participant_of(info.writer);
        let mut filter = lock(&filter);
        if grant.is_machine(by) {
            return (filter.take)(message, &info.writer);
        }
        if grant.has_machine() {
            let who = listener.who(&info.writer);
            let text = format!("{name} of {who} ignored: another machine has this cell; end one of the two");
            listener.warn_once(&format!("{name} of {who} ignored"), &text);
        }
        filter.retained.add(by, message, info.writer);
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_strangers_are_bounded_and_do_not_mix() {
        let mut retained = Retained { depth: 2, senders: VecDeque::new() };
        for message in 0..5 {
            retained.add([1; 16], message, [0; 16]);
        }
        retained.add([2; 16], 9, [0; 16]);
        let own: Vec<i32> = retained.drain([1; 16]).into_iter().map(|(message, _)| message).collect();
        assert_eq!(own, [3, 4]);
        assert!(retained.drain([1; 16]).is_empty());
        for sender in 3..8 {
            retained.add([sender; 16], 0, [0; 16]);
        }
        assert_eq!(retained.senders.len(), MAX_SENDERS);
        assert!(retained.drain([2; 16]).is_empty(), "the oldest sender was dropped");
        let mut none = Retained { depth: 0, senders: VecDeque::new() };
        none.add([1; 16], 0, [0; 16]);
        assert!(none.senders.is_empty());
    }
}
