// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Goal ids, states and names, shared by servers and clients of actions.

use std::{fmt, time::Duration};

use camwright_msgs::{action_msgs::msg::GoalStatus as GoalStatusMsg, unique_identifier_msgs::msg::UUID};

use super::{error::RosError, names::NameKind, node::Node};

/// Identity of a goal: a UUID that its client chose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct GoalId(pub [u8; 16]);

impl GoalId {
    pub fn random() -> Self {
        GoalId(*ros2_client::action::GoalId::new_random().uuid.as_bytes())
    }

    pub(super) fn to_msg(self) -> UUID {
        UUID { uuid: self.0 }
    }

    pub(super) fn from_msg(msg: &UUID) -> Self {
        GoalId(msg.uuid)
    }
}

impl fmt::Display for GoalId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, octet) in self.0.iter().enumerate() {
            let dash = if matches!(index, 4 | 6 | 8 | 10) { "-" } else { "" };
            write!(f, "{dash}{octet:02x}")?;
        }
        Ok(())
    }
}

/// State of a goal (`action_msgs/msg/GoalStatus`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i8)]
pub enum GoalStatus {
    Unknown = GoalStatusMsg::STATUS_UNKNOWN,
    Accepted = GoalStatusMsg::STATUS_ACCEPTED,
    Executing = GoalStatusMsg::STATUS_EXECUTING,
    /// Being brought to an end at the client's wish.
    Canceling = GoalStatusMsg::STATUS_CANCELING,
    Succeeded = GoalStatusMsg::STATUS_SUCCEEDED,
    /// Ended at the client's wish.
    Canceled = GoalStatusMsg::STATUS_CANCELED,
    /// Ended by the server.
    Aborted = GoalStatusMsg::STATUS_ABORTED,
}

impl GoalStatus {
    /// State of a number; what is no state is unknown.
    pub fn from_number(number: i8) -> Self {
        match number {
            GoalStatusMsg::STATUS_ACCEPTED => GoalStatus::Accepted,
            GoalStatusMsg::STATUS_EXECUTING => GoalStatus::Executing,
            GoalStatusMsg::STATUS_CANCELING => GoalStatus::Canceling,
            GoalStatusMsg::STATUS_SUCCEEDED => GoalStatus::Succeeded,
            GoalStatusMsg::STATUS_CANCELED => GoalStatus::Canceled,
            GoalStatusMsg::STATUS_ABORTED => GoalStatus::Aborted,
            _ => GoalStatus::Unknown,
        }
    }

    /// Returns true after the end of the goal.
    pub fn is_terminal(self) -> bool {
        matches!(self, GoalStatus::Succeeded | GoalStatus::Canceled | GoalStatus::Aborted)
    }
}

/// Time for which a result is kept after the end of its goal. rcl keeps 10 s; more costs little and forgives a busy client.
pub(super) const RESULT_TIMEOUT: Duration = Duration::from_secs(30);

/// The five names an action is made of.
pub(super) struct ActionNames {
    pub(super) action: String,
    pub(super) send_goal: String,
    pub(super) cancel_goal: String,
    pub(super) get_result: String,
    pub(super) feedback: String,
    pub(super) status: String,
}

impl ActionNames {
    /// Resolves the name of an action. A remapping rule may name the action itself (as no other ROS 2 library allows) or one of its
    /// parts.
    pub(super) fn resolve(node: &Node, name: &str) -> Result<Self, RosError> {
        let action = node.names().resolve(name, NameKind::Topic)?;
        let part = |part: &str| format!("{action}/_action/{part}");
        Ok(ActionNames {
            send_goal: part("send_goal"),
            cancel_goal: part("cancel_goal"),
            get_result: part("get_result"),
            feedback: part("feedback"),
            status: part("status"),
            action,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goal_ids_print_as_uuids_and_differ() {
        let id = GoalId([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]);
        assert_eq!(id.to_string(), "00010203-0405-0607-0809-0a0b0c0d0e0f");
        assert_ne!(GoalId::random(), GoalId::random());
        assert_eq!(GoalStatus::from_number(6), GoalStatus::Aborted);
        assert_eq!(GoalStatus::from_number(77), GoalStatus::Unknown);
        assert!(GoalStatus::Canceled.is_terminal() && !GoalStatus::Canceling.is_terminal());
    }
}
