// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Machine, interpolator and planner in this process, and an operator who talks to them over ROS.
#![allow(missing_debug_implementations, reason = "as above")]
#![allow(dead_code, reason = "each test target uses its part")]
#![allow(unreachable_pub, reason = "a module of test binaries has no outside")]

use crate::support::Domain;
use crate::support::command::share_command_of_cell;
use camwright_authority::HeldCommand;
use camwright_axis_interpolator::AxisInterpolator;
use camwright_job_planner::JobPlanner;
use camwright_machine_sim::MachineSim;
use camwright_msgs::camwright_msgs::action::{RunJob, RunJobFeedback, RunJobGoal};
use camwright_msgs::camwright_msgs::msg::{InterpolatorState, JobStatus, PartLobe};
use camwright_ros::{
    ActionClient, ClientGoal, Node, NodeOptions, ParameterValue, Qos, RosArgs, SpinThread, Subscription,
};
use std::sync::{Arc, Mutex, mpsc};
use std::time::Duration;

/// Generous: the machine may be building at the same time.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// Machine, interpolator, planner and a client that watches them.
pub struct Cell {
    /// Everybody in its domain may command it.
    command: Option<HeldCommand>,
    /// The machine.
    pub machine: MachineSim,
    /// The interpolator.
    pub interpolator: AxisInterpolator,
    /// The planner.
    pub planner: JobPlanner,
    /// Who watches them.
    pub client: Client,
    domain: Domain,
}

/// An operator: sends jobs, hears what becomes of them.
pub struct Client {
    pub node: Node,
    pub action: ActionClient<RunJob>,
    pub statuses: mpsc::Receiver<JobStatus>,
    /// True if the interpolator was ever busy.
    pub moved: Arc<Mutex<bool>>,
    /// Lobes that were put on the machine.
    pub parts: Arc<Mutex<Vec<PartLobe>>>,
    _subscriptions: Vec<Subscription>,
    _spin: SpinThread,
}

impl Client {
    fn new(args: &RosArgs) -> Self {
        let node = Node::new(NodeOptions::new("operator", args)).expect("a node");
        let (sender, statuses) = mpsc::channel();
        let status = node.subscribe("job_planner/job_status", &Qos::latched(1).keep_last(50), move |status, _| {
            let _test_is_over = sender.send(status);
        });
        let moved = Arc::new(Mutex::new(false));
        let seen = Arc::clone(&moved);
        let state = node.subscribe("axis_interpolator/state", &Qos::latched(1).keep_last(50), move |state, _| {
            let state: InterpolatorState = state;
            *seen.lock().expect("not poisoned") |= state.state != InterpolatorState::IDLE;
        });
        let parts: Arc<Mutex<Vec<PartLobe>>> = Arc::default();
        let list = Arc::clone(&parts);
        let part = node.subscribe("machine/part", &Qos::latched(32), move |lobe, _| {
            list.lock().expect("not poisoned").push(lobe);
        });
        let action = node.action_client("job_planner/run_job").expect("a client");
        let spin = node.spin_in_thread().expect("a thread");
        let subscriptions = [status, state, part].map(|made| made.expect("a subscription")).into();
        Self { node, action, statuses, moved, parts, _subscriptions: subscriptions, _spin: spin }
    }

    pub fn send(&self, job: &str, overrides: &[&str]) -> (ClientGoal<RunJob>, mpsc::Receiver<RunJobFeedback>) {
        let (sender, feedback) = mpsc::channel();
        let overrides = overrides.iter().map(ToString::to_string).collect();
        let goal = RunJobGoal { job: job.into(), overrides, ..RunJobGoal::default() };
        let send = move |feedback| drop(sender.send(feedback));
        (self.action.send_goal(goal, send, PATIENCE).expect("a decision"), feedback)
    }

    /// Waits for a status.
    pub fn status(&self, what: &str, wanted: impl Fn(&JobStatus) -> bool) -> JobStatus {
        loop {
            let status = self.statuses.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("no status that {what}"));
            if wanted(&status) {
                return status;
            }
        }
    }

    /// Returns whether the interpolator was ever busy, or a part was loaded.
    pub fn has_moved(&self) -> bool {
        *self.moved.lock().expect("not poisoned") || !self.parts.lock().expect("not poisoned").is_empty()
    }

    pub fn call<S: camwright_msgs::Service>(&self, name: &str, request: &S::Request) -> S::Response {
        let client = self.node.client::<S>(name).expect("a client");
        client.wait_for_service(PATIENCE).expect("the service");
        client.call(request, PATIENCE).expect("an answer")
    }
}

impl Cell {
    /// Starts the three nodes at pace fast, with `key=value` overrides of the machine.
    pub fn start(machine: &[&str]) -> Self {
        Self::start_with(machine, |args| args)
    }

    /// The same at pace realtime, with setpoints that run so far ahead that a pause of this computer is no alarm 80.
    pub fn start_realtime(machine: &[&str]) -> Self {
        let realtime = ParameterValue::String("realtime".into());
        Self::start_with(&[&["feedback_delay_ticks=500"], machine].concat(), |args| {
            args.with_parameter(Some("machine_sim"), "pace", realtime)
        })
    }

    /// The same with more parameters.
    pub fn start_with(machine: &[&str], more: impl FnOnce(RosArgs) -> RosArgs) -> Self {
        let domain = Domain::reserve();
        let machine = machine.iter().map(ToString::to_string).collect();
        let text = |text: &str| ParameterValue::String(text.into());
        let args = RosArgs::default()
            .with_domain_id(domain.id())
            .with_parameter(Some("machine_sim"), "pace", text("fast"))
            .with_parameter(Some("machine_sim"), "state_file", text("none"))
            .with_parameter(Some("machine_sim"), "machine_overrides", ParameterValue::StringArray(machine));
        let args = more(args);
        let client = Client::new(&args);
        let machine = MachineSim::start(&args).expect("machine_sim");
        let interpolator = AxisInterpolator::start(&args).expect("axis_interpolator");
        let planner = JobPlanner::start(&args).expect("job_planner");
        client.action.wait_for_server(PATIENCE).expect("run_job");
        for _ in 0..600 {
            if planner.knows_machine() && interpolator.knows_machine() {
                let command = share_command_of_cell(&client.node);
                let command = Some(command);
                return Self { command, machine, interpolator, planner, client, domain };
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        panic!("the machine was not heard of");
    }

    /// The domain that it lives in.
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Gives command back: no client has it.
    pub fn release(&mut self) {
        self.command.take();
    }

    /// Replaces the interpolator.
    pub fn with_interpolator(self, other: impl FnOnce(AxisInterpolator) -> AxisInterpolator) -> Self {
        let interpolator = other(self.interpolator);
        Self { interpolator, ..self }
    }

    pub fn stop(self) {
        drop(self.command);
        self.planner.stop();
        self.interpolator.stop();
        self.machine.stop();
        self.client.node.shutdown();
    }
}
