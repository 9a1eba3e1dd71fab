// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The axis: publisher, service, action, life cycle and parameters.

use camwright_msgs::camwright_msgs::action::{Home, HomeFeedback, HomeResult};
use camwright_msgs::std_msgs::msg::Float64;
use camwright_msgs::std_srvs::srv::{Trigger, TriggerResponse};
use camwright_ros::running::{NodeError, autostart};
use camwright_ros::{GoalHandle, LifecycleCallbacks, Node, NodeOptions, Parameter, Qos, RosArgs, SpinThread};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

const PERIOD: Duration = Duration::from_millis(20);

#[derive(Default)]
struct State {
    position_m: f64,
    goal: Option<GoalHandle<Home>>,
}

/// Clones are the same axis.
#[derive(Clone, Default)]
struct Axis(Arc<Mutex<State>>);

impl Axis {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Moves towards zero while a goal is active; returns the position.
    fn step(&self, distance_m: f64) -> f64 {
        let mut state = self.lock();
        let Some(goal) = state.goal.clone().filter(GoalHandle::is_active) else { return state.position_m };
        state.position_m = (state.position_m - distance_m).max(0.0);
        goal.feedback(&HomeFeedback { joint: "axis".into(), step: format!("{:.3} m", state.position_m) });
        if goal.is_canceling() {
            goal.canceled(HomeResult { message: "canceled".into(), ..HomeResult::default() });
        } else if state.position_m <= 0.0 {
            goal.succeed(HomeResult { message: "homed".into(), ..HomeResult::default() });
        }
        state.position_m
    }
}

impl LifecycleCallbacks for Axis {
    fn deactivate(&mut self) -> Result<(), String> {
        // A goal whose handles are dropped is aborted.
        self.lock().goal = None;
        Ok(())
    }
}

pub(crate) fn start(args: &RosArgs) -> Result<(Node, SpinThread), NodeError> {
    // Users change it with `ros2 param set`; values out of range are rejected.
    let speed = Parameter::double("speed", 0.05).describe("homing speed (m/s)").range(0.001, 1.0);
    let node = Node::new(NodeOptions::new("homing_axis", args).parameters([speed, autostart::parameter()]))?;
    let axis = Axis::default();
    let lifecycle = node.lifecycle(axis.clone())?;
    // The node keeps what it is given to retain, until it shuts down.
    let homed = axis.clone();
    node.retain(node.action_server("~/home", move |goal: GoalHandle<Home>| homed.lock().goal = Some(goal))?);
    let pushed = axis.clone();
    node.retain(node.service::<Trigger>("~/push", move |_| {
        pushed.lock().position_m += 0.1;
        TriggerResponse { success: true, message: "the axis moved out by 0.1 m".into() }
    })?);
    let position = node.publisher::<Float64>("~/position", &Qos::default_topic())?;
    let (state, parameters) = (lifecycle.clone(), node.parameters().clone());
    // All callbacks run on one thread, one after the other.
    node.retain(node.timer(PERIOD, move || {
        if state.is_active() {
            let data = axis.step(parameters.double("speed") * PERIOD.as_secs_f64());
            drop(position.publish(&Float64 { data }));
        }
    }));
    let spin = node.spin_in_thread()?;
    autostart::begin(&node, &lifecycle);
    Ok((node, spin))
}
