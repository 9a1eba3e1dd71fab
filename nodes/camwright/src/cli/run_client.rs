//! `camwright run` as a client of the cell, like any other node.

use camwright::math::units::deg_from_rad;
use camwright_bag::progress;
use camwright_files::convert::um_from_m as um;
use camwright_msgs::camwright_msgs::action::{RunJob, RunJobFeedback, RunJobGoal, RunJobResult};
use camwright_msgs::camwright_msgs::msg::{FormMap, JobStatus, RecorderStatus};
use camwright_msgs::camwright_msgs::srv::{FindPhase, FindPhaseRequest, LoadJob, LoadJobRequest};
use camwright_msgs::lifecycle_msgs::msg::State;
use camwright_msgs::lifecycle_msgs::srv::{GetState, GetStateRequest};
use camwright_ros::running::NodeError;
use camwright_ros::{
    ActionClient, ClientGoal, GoalStatus, Node, NodeOptions, Qos, RosArgs, Shutdown, SpinThread, Subscription,
};
use indicatif::ProgressBar;
use std::fmt::Write as _;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How long the nodes may take to find each other.
const MEETING: Duration = Duration::from_secs(20);
/// How long a cancelled job may take to come to rest.
const STOPPING: Duration = Duration::from_secs(30);
/// How long the search for the key-way may take at pace realtime.
const FINDING: Duration = Duration::from_secs(120);

/// What the client waits for: set by callbacks, watched by the main thread.
#[derive(Debug, Default)]
struct Heard {
    recorder: Option<RecorderStatus>,
    job: Option<JobStatus>,
    form_map: Option<FormMap>,
}

/// The part of the command that talks to the cell like any other ROS client.
pub(super) struct Client {
    pub(super) node: Node,
    action: ActionClient<RunJob>,
    heard: Arc<(Mutex<Heard>, Condvar)>,
    _spin: SpinThread,
    _subscriptions: Vec<Subscription>,
}

impl Client {
    pub(super) fn new(ros_args: &RosArgs) -> Result<Self, NodeError> {
        let node = Node::new(NodeOptions::new("camwright", ros_args))?;
        let heard: Arc<(Mutex<Heard>, Condvar)> = Arc::default();
        let for_recorder = Arc::clone(&heard);
        let recorder =
            node.subscribe::<RecorderStatus>("run_logger/status", &Qos::default_topic(), move |message, _| {
                tell(&for_recorder, |heard| heard.recorder = Some(message));
            })?;
        let for_job = Arc::clone(&heard);
        let job = node.subscribe::<JobStatus>("job_planner/job_status", &Qos::latched(1), move |message, _| {
            tell(&for_job, |heard| heard.job = Some(message));
        })?;
        let for_map = Arc::clone(&heard);
        let map = node.subscribe::<FormMap>("job_planner/form_map", &Qos::latched(1), move |message, _| {
            tell(&for_map, |heard| heard.form_map = Some(message));
        })?;
        let action = node.action_client::<RunJob>("job_planner/run_job")?;
        let spin = node.spin_in_thread()?;
        Ok(Self { node, action, heard, _spin: spin, _subscriptions: vec![recorder, job, map] })
    }

    /// Waits until the planner can be asked and, with a recorder of ours, until it records what matters.
    pub(super) fn meet(&self, recorded: Option<&[&str]>, shutdown: &Shutdown) -> Result<(), NodeError> {
        self.action.wait_for_server(MEETING)?;
        for node in ["machine_sim", "axis_interpolator", "job_planner"] {
            self.wait_active(node, shutdown)?;
        }
        let Some(wanted) = recorded else { return Ok(()) };
        let wanted: Vec<String> =
            wanted.iter().map(|topic| self.node.resolve_topic(topic)).collect::<Result<_, _>>()?;
        let missing = |status: Option<&RecorderStatus>| -> Vec<&String> {
            let recorded = |topic: &String| status.is_some_and(|s| s.topics.iter().any(|t| t.topic == *topic));
            wanted.iter().filter(|topic| !recorded(topic)).collect()
        };
        let deadline = Instant::now() + MEETING;
        let (mutex, changed) = &*self.heard;
        let mut heard = mutex.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            let missing = missing(heard.recorder.as_ref());
            if missing.is_empty() {
                return Ok(());
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() || shutdown.is_requested() {
                return Err(NodeError::Parameter(format!("the recorder does not record {missing:?}")));
            }
            let slice = left.min(Duration::from_millis(200));
            heard = changed.wait_timeout(heard, slice).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Waits until a node of the cell is active, which it becomes by itself or by its life cycle manager.
    fn wait_active(&self, name: &str, shutdown: &Shutdown) -> Result<(), NodeError> {
        let client = self.node.client::<GetState>(&format!("{name}/get_state"))?;
        client.wait_for_service(MEETING)?;
        let deadline = Instant::now() + MEETING;
        loop {
            let state = client.call(&GetStateRequest::default(), MEETING)?.current_state;
            if state.id == State::PRIMARY_STATE_ACTIVE {
                return Ok(());
            }
            if Instant::now() > deadline || shutdown.is_requested() {
                return Err(NodeError::Parameter(format!("{name} is {}, not active", state.label)));
            }
            // Nothing says when a foreign manager acts; asking ten times a second costs nothing.
            let _requested = shutdown.wait_timeout(Duration::from_millis(100));
        }
    }

    /// Puts the raw part of a job in and finds the angle at which it is clamped; what the job must then be told.
    pub(super) fn find_phase(&self, job: &str, overrides: &[String]) -> Result<[String; 2], NodeError> {
        let load = self.node.client::<LoadJob>("job_planner/load_job")?;
        load.wait_for_service(MEETING)?;
        let loaded = load.call(&LoadJobRequest { job: job.to_owned(), overrides: overrides.to_vec() }, STOPPING)?;
        if !loaded.success {
            return Err(NodeError::Parameter(format!("the job is refused, nothing moved: {}", loaded.message)));
        }
        let find = self.node.client::<FindPhase>("job_planner/find_phase")?;
        find.wait_for_service(MEETING)?;
        let found = find.call(&FindPhaseRequest { load_part: true, ..FindPhaseRequest::default() }, FINDING)?;
        if !found.success {
            return Err(NodeError::Parameter(format!("the part's phase was not found: {}", found.message)));
        }
        // The part stays as it is.
        Ok([format!("part_phase_deg={:?}", deg_from_rad(found.phase)), "start_at=1".to_owned()])
    }

    /// What the planner said of its job last.
    pub(super) fn heard_job(&self) -> Option<JobStatus> {
        self.heard.0.lock().unwrap_or_else(PoisonError::into_inner).job.clone()
    }

    /// Where the part is off that was turned up to a tick, as the planner tells it.
    pub(super) fn form_map(&self, tick: u64) -> Option<FormMap> {
        let deadline = Instant::now() + MEETING;
        let (mutex, changed) = &*self.heard;
        let mut heard = mutex.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(map) = heard.form_map.as_ref().filter(|map| map.tick == tick) {
                return Some(map.clone());
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return None;
            }
            heard = changed.wait_timeout(heard, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Runs a job to its end, with a bar of its progress; a signal brings it to rest.
    pub(super) fn run_job(
        &self,
        job: &str,
        overrides: &[String],
        shutdown: &Shutdown,
    ) -> Result<(GoalStatus, RunJobResult), NodeError> {
        let progress = progress::bar(1000, "{bar:30} {msg}");
        progress.set_message("planning");
        let bar = progress.clone();
        let goal = RunJobGoal { job: job.to_owned(), overrides: overrides.to_vec(), ..RunJobGoal::default() };
        let goal = self.action.send_goal(goal, move |feedback| show(&bar, &feedback), MEETING)?;
        if !goal.accepted() {
            progress.finish_and_clear();
            let (mutex, _) = &*self.heard;
            let reason = mutex.lock().unwrap_or_else(PoisonError::into_inner).job.clone().map(|status| status.message);
            let reason = reason.filter(|reason| !reason.is_empty()).unwrap_or_else(|| "no reason was given".into());
            return Err(NodeError::Parameter(format!("the job is refused, nothing moved: {reason}")));
        }
        let outcome = wait_for_result(&goal, shutdown);
        progress.finish_and_clear();
        outcome
    }
}

/// Waits for the result; a signal cancels the goal and waits for the axes to come to rest.
fn wait_for_result(goal: &ClientGoal<RunJob>, shutdown: &Shutdown) -> Result<(GoalStatus, RunJobResult), NodeError> {
    type Slot = Arc<(Mutex<Option<(GoalStatus, RunJobResult)>>, Condvar)>;
    let slot: Slot = Arc::default();
    let place = Arc::clone(&slot);
    goal.result_with(move |status, result| {
        let (mutex, changed) = &*place;
        *mutex.lock().unwrap_or_else(PoisonError::into_inner) = Some((status, result));
        changed.notify_all();
    })?;
    let (mutex, changed) = &*slot;
    let mut given_up: Option<Instant> = None;
    let mut result = mutex.lock().unwrap_or_else(PoisonError::into_inner);
    loop {
        if let Some(result) = result.take() {
            return Ok(result);
        }
        if shutdown.is_requested() && given_up.is_none() {
            given_up = Some(Instant::now() + STOPPING);
            goal.cancel_with(|_| {})?;
        }
        if given_up.is_some_and(|end| Instant::now() > end) {
            return Err(NodeError::Parameter("the cancelled job did not come to rest in time".into()));
        }
        result = changed.wait_timeout(result, Duration::from_millis(100)).unwrap_or_else(PoisonError::into_inner).0;
    }
}

fn tell(heard: &(Mutex<Heard>, Condvar), change: impl FnOnce(&mut Heard)) {
    change(&mut heard.0.lock().unwrap_or_else(PoisonError::into_inner));
    heard.1.notify_all();
}

fn show(progress: &ProgressBar, feedback: &RunJobFeedback) {
    #[allow(clippy::cast_possible_truncation, reason = "a percentage")]
    progress.set_position((feedback.percent.clamp(0.0, 100.0) * 10.0) as u64);
    let mut text = format!("{:>3.0} %  {} {}", feedback.percent, feedback.lobe, feedback.phase_name);
    if feedback.turns > 0.0 {
        let _infallible = write!(text, ", turn {:.1} of {:.0}", feedback.turn, feedback.turns);
        let _infallible = write!(text, ", stock {:.0} um", um(feedback.stock));
    }
    let _infallible = write!(text, ", {:.0} s left", feedback.time_left);
    progress.set_message(text);
}
