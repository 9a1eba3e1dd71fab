// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The example of `camwright_ros`, `nodes/ros/examples/homing_axis`, driven by a client.

use crate::example;
use crate::support::{Domain, PATIENCE};
use camwright_msgs::camwright_msgs::action::{Home, HomeFeedback, HomeGoal};
use camwright_msgs::lifecycle_msgs::msg::Transition;
use camwright_msgs::lifecycle_msgs::srv::{ChangeState, ChangeStateRequest};
use camwright_msgs::rcl_interfaces::msg::{Parameter, ParameterType, ParameterValue};
use camwright_msgs::rcl_interfaces::srv::{SetParameters, SetParametersRequest};
use camwright_msgs::std_msgs::msg::Float64;
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_ros::{CancelOutcome, Client, GoalStatus, Node, NodeOptions, Qos, RosArgs, Subscription};
use std::sync::mpsc::{self, Receiver};
use std::time::Instant;

/// Clients of the example, and the positions it publishes.
struct User {
    push: Client<Trigger>,
    set: Client<SetParameters>,
    change: Client<ChangeState>,
    positions: Receiver<f64>,
    _position: Subscription,
}

impl User {
    fn new(node: &Node) -> Self {
        let (sender, positions) = mpsc::channel();
        let received = move |position: Float64, _: &_| {
            let _ = sender.send(position.data);
        };
        let position =
            node.subscribe("/homing_axis/position", &Qos::default_topic(), received).expect("a subscription");
        let push = node.client("/homing_axis/push").expect("a client");
        let set = node.client("/homing_axis/set_parameters").expect("a client");
        let change = node.client("/homing_axis/change_state").expect("a client");
        push.wait_for_service(PATIENCE).expect("push");
        set.wait_for_service(PATIENCE).expect("set_parameters");
        change.wait_for_service(PATIENCE).expect("change_state");
        Self { push, set, change, positions, _position: position }
    }

    fn wait_for_position(&self, wanted: f64) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let position = self.positions.recv_timeout(PATIENCE).expect("a position");
            if (position - wanted).abs() < 1e-9 {
                return;
            }
            assert!(Instant::now() < deadline, "the axis is at {position} m instead of {wanted} m");
        }
    }

    fn push(&self) {
        assert!(self.push.call(&TriggerRequest::default(), PATIENCE).expect("an answer").success);
    }

    /// Sets the speed; returns true if it was accepted.
    fn set_speed(&self, speed: f64) -> bool {
        let value =
            ParameterValue { type_: ParameterType::PARAMETER_DOUBLE, double_value: speed, ..ParameterValue::default() };
        let parameters = vec![Parameter { name: "speed".into(), value }];
        self.set.call(&SetParametersRequest { parameters }, PATIENCE).expect("an answer").results[0].successful
    }
}

#[test]
fn the_example_publishes_serves_homes_and_stops() {
    let domain = Domain::reserve();
    let args = RosArgs::default().with_domain_id(domain.id());
    let (example, _spin) = example::start(&args).expect("the example starts");
    let client = Node::new(NodeOptions::new("client", &args)).expect("a node");
    let _client_spin = client.spin_in_thread().expect("a thread");
    let user = User::new(&client);
    user.push();
    user.wait_for_position(0.1);
    assert!(!user.set_speed(2.0), "out of range");

    let home = client.action_client::<Home>("/homing_axis/home").expect("a client");
    home.wait_for_server(PATIENCE).expect("a server");
    let (sender, feedback) = mpsc::channel();
    let received = move |feedback: HomeFeedback| drop(sender.send(feedback.joint));
    let goal = home.send_goal(HomeGoal::default(), received, PATIENCE).expect("an answer");
    assert_eq!(feedback.recv_timeout(PATIENCE).as_deref(), Ok("axis"));
    assert!(user.set_speed(1.0), "in range");
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!((status, result.message.as_str()), (GoalStatus::Succeeded, "homed"));
    user.wait_for_position(0.0);

    assert!(user.set_speed(0.001), "slow enough to be interrupted");
    user.push();
    let goal = home.send_goal(HomeGoal::default(), drop, PATIENCE).expect("an answer");
    assert_eq!(goal.cancel(PATIENCE).expect("an answer"), CancelOutcome::Accepted);
    assert_eq!(goal.result(PATIENCE).expect("a result").0, GoalStatus::Canceled);
    let goal = home.send_goal(HomeGoal::default(), drop, PATIENCE).expect("an answer");
    let transition = Transition { id: Transition::TRANSITION_DEACTIVATE, ..Transition::default() };
    let answer = user.change.call(&ChangeStateRequest { transition }, PATIENCE).expect("an answer");
    assert!(answer.success);
    assert_eq!(goal.result(PATIENCE).expect("a result").0, GoalStatus::Aborted);
    client.shutdown();
    example.shutdown();
}
