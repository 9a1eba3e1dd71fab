// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Common traits of all messages, services and actions.

use std::fmt::Debug;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::builtin_interfaces::msg::Time;
use crate::unique_identifier_msgs::msg::UUID;
use crate::{BoundsError, InterfaceInfo};

/// The marker of the DDS client that sends messages: that crate's own trait with feature `ros2-client`, else a trait
/// every type has.
#[cfg(feature = "ros2-client")]
pub use ros2_client::Message as WireMessage;

/// The marker of the DDS client that sends messages: that crate's own trait with feature `ros2-client`, else a trait
/// every type has.
#[cfg(not(feature = "ros2-client"))]
pub trait WireMessage {}

#[cfg(not(feature = "ros2-client"))]
impl<T> WireMessage for T {}

/// A structure that travels on a topic, or as part of a service or an action.
pub trait Message:
    WireMessage + Serialize + DeserializeOwned + Send + Sync + Clone + Debug + PartialEq + Default + 'static
{
    /// Package, for example `sensor_msgs`.
    const PACKAGE: &'static str;
    /// Name in the package, for example `JointState` or `Trigger_Request`.
    const NAME: &'static str;
    /// All that is known of the type.
    const INFO: &'static InterfaceInfo;
    /// Full name, for example `sensor_msgs/msg/JointState`.
    const TYPE_NAME: &'static str = Self::INFO.type_name;
    /// Name on the wire, for example `sensor_msgs::msg::dds_::JointState_`.
    const DDS_TYPE_NAME: &'static str = Self::INFO.dds_type_name;
    /// Hash of the type's description: `RIHS01_` and 64 hexadecimal digits.
    const TYPE_HASH: &'static str = Self::INFO.type_hash;
    /// Definition with all dependencies, as a bag carries it (encoding `ros2msg`).
    const SCHEMA: &'static str = Self::INFO.schema;

    /// Checks the bounds of texts and sequences, here and in everything nested.
    ///
    /// # Errors
    /// The first field that is too long.
    fn check_bounds(&self) -> Result<(), BoundsError> {
        Ok(())
    }
}

pub trait Service: Send + Sync + 'static {
    type Request: Message;
    type Response: Message;
    /// Package, for example `std_srvs`.
    const PACKAGE: &'static str;
    /// Name in the package, for example `Trigger`.
    const NAME: &'static str;
    /// All that is known of the service.
    const INFO: &'static InterfaceInfo;
    /// Full name, for example `std_srvs/srv/Trigger`.
    const TYPE_NAME: &'static str = Self::INFO.type_name;
    /// Hash of the service's description.
    const TYPE_HASH: &'static str = Self::INFO.type_hash;
    /// Name of the request on the wire, for example `std_srvs::srv::dds_::Trigger_Request_`.
    const DDS_REQUEST_TYPE_NAME: &'static str = <Self::Request as Message>::DDS_TYPE_NAME;
    /// Name of the response on the wire, for example `std_srvs::srv::dds_::Trigger_Response_`.
    const DDS_RESPONSE_TYPE_NAME: &'static str = <Self::Response as Message>::DDS_TYPE_NAME;
}

/// An action: goal, result and feedback, and the services and the topic they travel on.
pub trait Action: Send + Sync + 'static {
    type Goal: Message;
    /// Result.
    type Result: Message;
    /// Progress.
    type Feedback: Message;
    /// The service on `<action>/_action/send_goal`.
    type SendGoal: Service;
    /// The service on `<action>/_action/get_result`.
    type GetResult: Service;
    /// The message on `<action>/_action/feedback`.
    type FeedbackMessage: Message;
    /// Package, for example `control_msgs`.
    const PACKAGE: &'static str;
    /// Name in the package, for example `FollowJointTrajectory`.
    const NAME: &'static str;
    /// All that is known of the action.
    const INFO: &'static InterfaceInfo;
    /// Full name, for example `control_msgs/action/FollowJointTrajectory`.
    const TYPE_NAME: &'static str = Self::INFO.type_name;
    /// Hash of the action's description.
    const TYPE_HASH: &'static str = Self::INFO.type_hash;

    /// Puts together a request to accept a goal.
    fn send_goal_request(goal_id: UUID, goal: Self::Goal) -> <Self::SendGoal as Service>::Request;
    /// Takes apart a request to accept a goal.
    fn split_send_goal_request(message: <Self::SendGoal as Service>::Request) -> (UUID, Self::Goal);
    /// Puts together the answer to such a request; `stamp` is the time of acceptance.
    fn send_goal_response(accepted: bool, stamp: Time) -> <Self::SendGoal as Service>::Response;
    /// Takes apart the answer to such a request.
    fn split_send_goal_response(message: <Self::SendGoal as Service>::Response) -> (bool, Time);
    /// Puts together a request for a result.
    fn get_result_request(goal_id: UUID) -> <Self::GetResult as Service>::Request;
    /// Takes apart a request for a result.
    fn split_get_result_request(message: <Self::GetResult as Service>::Request) -> UUID;
    /// Puts together a result; `status` is one of [`GoalStatus`](crate::action_msgs::msg::GoalStatus)`::STATUS_*`.
    fn get_result_response(status: i8, result: Self::Result) -> <Self::GetResult as Service>::Response;
    /// Takes apart a result.
    fn split_get_result_response(message: <Self::GetResult as Service>::Response) -> (i8, Self::Result);
    /// Puts together a message of feedback.
    fn feedback_message(goal_id: UUID, feedback: Self::Feedback) -> Self::FeedbackMessage;
    /// Takes apart a message of feedback.
    fn split_feedback_message(message: Self::FeedbackMessage) -> (UUID, Self::Feedback);
}
