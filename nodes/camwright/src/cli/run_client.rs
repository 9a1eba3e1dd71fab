// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! ROS client of `camwright run`.

use super::output::note;
use super::run_cell::NODES;
use super::run_part::PartProgress;
use super::run_progress::JobProgress;
use camwright::math::units::deg_from_rad;
use camwright_msgs::camwright_msgs::action::{RunJob, RunJobFeedback, RunJobGoal, RunJobResult};
use camwright_msgs::camwright_msgs::msg::{FormMap, JobStatus, RecorderStatus};
use camwright_msgs::camwright_msgs::srv::{FindPhase, FindPhaseRequest, LoadJob, LoadJobRequest};
use camwright_msgs::lifecycle_msgs::msg::State;
use camwright_msgs::lifecycle_msgs::srv::{GetState, GetStateRequest};
use camwright_ros::running::NodeError;
use camwright_ros::{
    ActionClient, ClientGoal, GoalStatus, Node, NodeOptions, Qos, RosArgs, Shutdown, SpinThread, Subscription,
    runs_already,
};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Nodes of machines: simulated, behind the HAL of LinuxCNC.
const MACHINES: [&str; 2] = ["machine_sim", "machine_hal"];
/// Maximum time for other participants to say which nodes they have.
const ACQUAINTED: Duration = Duration::from_secs(1);
/// Maximum time for the nodes to find each other.
const MEETING: Duration = Duration::from_secs(20);
/// Maximum time for a cancelled job to come to rest.
const STOPPING: Duration = Duration::from_secs(30);
/// Maximum time of the keyway search in real time.
const FINDING: Duration = Duration::from_secs(120);

/// Note after the first Ctrl-C.
const CANCELLING: &str = "\
Ctrl-C: cancelling. The machine retracts and comes to rest, then the bag is
closed; the part stays unfinished. A second Ctrl-C leaves the bag open.";
/// Error of a start that was interrupted.
const INTERRUPTED: &str = "interrupted before the job started; nothing moved";

/// Last messages of the cell: written by callbacks, awaited by the main thread.
#[derive(Debug, Default)]
struct CellState {
    recorder: Option<RecorderStatus>,
    job: Option<JobStatus>,
    form_map: Option<FormMap>,
}

/// End of a job: its status, its result, and the part by the feedback.
pub(super) type JobEnd = (GoalStatus, RunJobResult, PartProgress);

/// Client node of the cell.
pub(super) struct CellClient {
    pub(super) node: Node,
    action: ActionClient<RunJob>,
    state: Arc<(Mutex<CellState>, Condvar)>,
    _spin: SpinThread,
    _subscriptions: Vec<Subscription>,
}

impl CellClient {
    pub(super) fn new(ros_args: &RosArgs) -> Result<Self, NodeError> {
        let node = Node::new(NodeOptions::new("camwright", ros_args))?;
        let state: Arc<(Mutex<CellState>, Condvar)> = Arc::default();
        let for_recorder = Arc::clone(&state);
        let recorder =
            node.subscribe::<RecorderStatus>("run_logger/status", &Qos::default_topic(), move |message, _| {
                update(&for_recorder, |state| state.recorder = Some(message));
            })?;
        let for_job = Arc::clone(&state);
        let job = node.subscribe::<JobStatus>("job_planner/job_status", &Qos::latched(1), move |message, _| {
            update(&for_job, |state| state.job = Some(message));
        })?;
        let for_map = Arc::clone(&state);
        let map = node.subscribe::<FormMap>("job_planner/form_map", &Qos::latched(1), move |message, _| {
            update(&for_map, |state| state.form_map = Some(message));
        })?;
        let action = node.action_client::<RunJob>("job_planner/run_job")?;
        let spin = node.spin_in_thread()?;
        Ok(Self { node, action, state, _spin: spin, _subscriptions: vec![recorder, job, map] })
    }

    /// Checks that no other host of the domain runs a cell in this namespace.
    ///
    /// Reports of discovery end the wait: those of the participants that ran before this client.
    pub(super) fn is_alone(&self, ros_args: &RosArgs) -> Result<(), NodeError> {
        let _all_said_their_nodes = self.node.wait_acquainted(ACQUAINTED);
        let names = NODES.map(|name| join(self.node.namespace(), name));
        let running = self.node.discovered_nodes().into_iter().find(|node| names.contains(node));
        match running {
            Some(node) => Err(NodeError::Parameter(runs_already(&node, ros_args.domain_id(), ""))),
            None => Ok(()),
        }
    }

    /// Waits for the planner and, with an own recorder, until it records `recorded`.
    pub(super) fn meet(&self, recorded: Option<&[&str]>, shutdown: &Shutdown) -> Result<(), NodeError> {
        self.action.wait_for_server(MEETING)?;
        for names in [&MACHINES[..], &["axis_interpolator"], &["job_planner"]] {
            self.wait_active(names, shutdown)?;
        }
        let Some(wanted) = recorded else { return Ok(()) };
        let wanted: Vec<String> =
            wanted.iter().map(|topic| self.node.resolve_topic(topic)).collect::<Result<_, _>>()?;
        let missing = |status: Option<&RecorderStatus>| -> Vec<&String> {
            let recorded = |topic: &String| status.is_some_and(|s| s.topics.iter().any(|t| t.topic == *topic));
            wanted.iter().filter(|topic| !recorded(topic)).collect()
        };
        let deadline = Instant::now() + MEETING;
        let (mutex, changed) = &*self.state;
        let mut state = mutex.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            let missing = missing(state.recorder.as_ref());
            if missing.is_empty() {
                return Ok(());
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if shutdown.is_requested() {
                return Err(NodeError::Parameter(INTERRUPTED.into()));
            }
            if left.is_zero() {
                return Err(NodeError::Parameter(format!(
                    "the recorder does not record {missing:?}; check its topic filter"
                )));
            }
            let slice = left.min(Duration::from_millis(200));
            state = changed.wait_timeout(state, slice).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Waits until the node with one of these names is active, by itself or through a life cycle manager.
    fn wait_active(&self, names: &[&str], shutdown: &Shutdown) -> Result<(), NodeError> {
        let clients = names.iter().map(|name| self.node.client::<GetState>(&format!("{name}/get_state")));
        let clients = clients.collect::<Result<Vec<_>, _>>()?;
        let deadline = Instant::now() + MEETING;
        // A foreign manager sends no event, and several services have none in common; both are polled.
        loop {
            let is_late = Instant::now() > deadline;
            if let Some(client) = clients.iter().find(|client| client.is_ready()) {
                let state = client.call(&GetStateRequest::default(), MEETING)?.current_state;
                if state.id == State::PRIMARY_STATE_ACTIVE {
                    return Ok(());
                }
                if is_late {
                    let node = client.service().trim_end_matches("/get_state");
                    return Err(NodeError::Parameter(format!(
                        "node {node} is {}, not active; activate it",
                        state.label
                    )));
                }
            } else if is_late {
                return Err(NodeError::Parameter(self.absent(names)));
            }
            if shutdown.wait_timeout(Duration::from_millis(50)) {
                return Err(NodeError::Parameter(INTERRUPTED.into()));
            }
        }
    }

    /// Error about a node that is not there, with the nodes that are.
    fn absent(&self, names: &[&str]) -> String {
        let names = names.iter().map(|name| join(self.node.namespace(), name)).collect::<Vec<_>>().join(" or ");
        let shown = self.node.discovered_nodes().join(", ");
        let seconds = MEETING.as_secs();
        format!("no node {names} answers within {seconds} s; start it. Nodes that are there: {shown}")
    }

    /// Loads the raw part of a job and finds its phase; returns the overrides for the job.
    pub(super) fn find_phase(&self, job: &str, overrides: &[String]) -> Result<[String; 2], NodeError> {
        let load = self.node.client::<LoadJob>("job_planner/load_job")?;
        load.wait_for_service(MEETING)?;
        let loaded = load.call(&LoadJobRequest { job: job.to_owned(), overrides: overrides.to_vec() }, STOPPING)?;
        if !loaded.success {
            return Err(NodeError::Parameter(refusal(&loaded.message)));
        }
        let find = self.node.client::<FindPhase>("job_planner/find_phase")?;
        find.wait_for_service(MEETING)?;
        let found = find.call(&FindPhaseRequest { load_part: true, ..FindPhaseRequest::default() }, FINDING)?;
        if !found.success {
            return Err(NodeError::Parameter(format!("the phase of the part was not found: {}", found.message)));
        }
        // The part stays as it is.
        Ok([format!("part_phase_deg={:?}", deg_from_rad(found.phase)), "start_at=1".to_owned()])
    }

    /// Last job status of the planner.
    pub(super) fn last_job_status(&self) -> Option<JobStatus> {
        self.state.0.lock().unwrap_or_else(PoisonError::into_inner).job.clone()
    }

    /// Form map of the part that was turned up to a tick.
    pub(super) fn form_map(&self, tick: u64) -> Option<FormMap> {
        let deadline = Instant::now() + MEETING;
        let (mutex, changed) = &*self.state;
        let mut state = mutex.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(map) = state.form_map.as_ref().filter(|map| map.tick == tick) {
                return Some(map.clone());
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return None;
            }
            state = changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Sends a job that the planner accepts.
    pub(super) fn send_job(
        &self,
        job: &str,
        overrides: &[String],
        on_feedback: impl FnMut(RunJobFeedback) + Send + 'static,
    ) -> Result<ClientGoal<RunJob>, NodeError> {
        let goal = RunJobGoal { job: job.to_owned(), overrides: overrides.to_vec(), ..RunJobGoal::default() };
        let goal = self.action.send_goal(goal, on_feedback, MEETING)?;
        if !goal.accepted() {
            let reason = self.last_job_status().map(|status| status.message);
            let reason = reason
                .filter(|reason| !reason.is_empty())
                .unwrap_or_else(|| "the planner gives no reason; its log may show it".into());
            return Err(NodeError::Parameter(refusal(&reason)));
        }
        Ok(goal)
    }

    /// Runs a job to its end; a signal cancels it. Returns also the state of the part by the feedback.
    pub(super) fn run_job(
        &self,
        job: &str,
        overrides: &[String],
        progress: &JobProgress,
        shutdown: &Shutdown,
    ) -> Result<JobEnd, NodeError> {
        let part: Arc<Mutex<PartProgress>> = Arc::default();
        let (bar, state) = (progress.clone(), Arc::clone(&part));
        let on_feedback = move |feedback: RunJobFeedback| {
            state.lock().unwrap_or_else(PoisonError::into_inner).receive(&feedback);
            bar.show(&feedback);
        };
        let goal = self.send_job(job, overrides, on_feedback)?;
        let (status, result) = wait_for_result(&goal, progress, shutdown)?;
        let part = part.lock().unwrap_or_else(PoisonError::into_inner).clone();
        Ok((status, result, part))
    }
}

/// Waits for the result; a signal cancels the goal and waits for the axes to come to rest.
fn wait_for_result(
    goal: &ClientGoal<RunJob>,
    progress: &JobProgress,
    shutdown: &Shutdown,
) -> Result<(GoalStatus, RunJobResult), NodeError> {
    type Slot = Arc<(Mutex<Option<(GoalStatus, RunJobResult)>>, Condvar)>;
    let slot: Slot = Arc::default();
    let filled = Arc::clone(&slot);
    goal.result_with(move |status, result| {
        let (mutex, changed) = &*filled;
        *mutex.lock().unwrap_or_else(PoisonError::into_inner) = Some((status, result));
        changed.notify_all();
    })?;
    let (mutex, changed) = &*slot;
    let mut deadline: Option<Instant> = None;
    let mut result = mutex.lock().unwrap_or_else(PoisonError::into_inner);
    loop {
        if let Some(result) = result.take() {
            return Ok(result);
        }
        if shutdown.is_requested() && deadline.is_none() {
            deadline = Some(Instant::now() + STOPPING);
            progress.suspend(|| note!("{CANCELLING}"));
            goal.cancel_with(|_| {})?;
        }
        if deadline.is_some_and(|end| Instant::now() > end) {
            return Err(NodeError::Parameter("the cancelled job did not come to rest within 30 s".into()));
        }
        result = changed.wait_timeout(result, Duration::from_millis(100)).unwrap_or_else(PoisonError::into_inner).0;
    }
}

/// A rejected job. Messages of the planner begin with the same words already.
fn refusal(reason: &str) -> String {
    let reason = reason.strip_prefix("refused, nothing moved: ").unwrap_or(reason);
    format!("job rejected, nothing moved: {reason}")
}

/// Fully qualified name of a node.
fn join(namespace: &str, name: &str) -> String {
    format!("{}/{name}", namespace.trim_end_matches('/'))
}

fn update(state: &(Mutex<CellState>, Condvar), change: impl FnOnce(&mut CellState)) {
    change(&mut state.0.lock().unwrap_or_else(PoisonError::into_inner));
    state.1.notify_all();
}
