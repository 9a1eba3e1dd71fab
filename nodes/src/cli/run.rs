//! `camwright run`: the whole cell in one process, or the job on a cell that runs already.

use super::batch::Batch;
use super::run_report::{Report, um};
use crate::axis_interpolator::AxisInterpolator;
use crate::config::locate::Located;
use crate::config::{any_job, job_file};
use crate::job_planner::JobPlanner;
use crate::machine_sim::MachineSim;
use crate::planning::{self, PreparedJob};
use crate::ros::{
    ClientGoal, GoalStatus, Lifecycle, Node, NodeOptions, ParameterValue, Qos, RosArgs, RosLayer, Shutdown,
    Subscription, Transition,
};
use crate::run_logger::RunLogger;
use crate::running::NodeError;
use camwright::units::deg_from_rad;
use camwright_msgs::camwright_msgs::action::{RunJob, RunJobFeedback, RunJobGoal, RunJobResult};
use camwright_msgs::camwright_msgs::msg::{JobStatus, RecorderStatus};
use camwright_msgs::camwright_msgs::srv::{FindPhase, FindPhaseRequest, LoadJob, LoadJobRequest};
use camwright_msgs::lifecycle_msgs::msg::State;
use camwright_msgs::lifecycle_msgs::srv::{GetState, GetStateRequest};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// How long the nodes may take to find each other.
const MEETING: Duration = Duration::from_secs(20);
/// How long a cancelled job may take to come to rest.
const STOPPING: Duration = Duration::from_secs(30);
/// How long the search for the key-way may take at pace realtime.
const FINDING: Duration = Duration::from_secs(120);

/// Arguments of `camwright run`.
#[derive(Debug, Clone, Args, Default)]
pub(super) struct RunArgs {
    /// Job, by name or path.
    #[arg(default_value = "four_lobe_camshaft")]
    job: Option<String>,
    /// Ticks follow the wall clock, or go as fast as they can.
    #[arg(long, value_enum, default_value_t = PaceArg::Fast)]
    pace: PaceArg,
    /// Directory of the bag, which must not exist; default: bags/<job>_<time>.
    #[arg(long, value_name = "DIR")]
    bag: Option<PathBuf>,
    /// Set a key of the job, for example `infeed.total_mm=0.72` or `lobes.I1.phase_deg=75`; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Set a key of the machine, for example `x_axis.drive.kv_1_s=150`; may be repeated.
    #[arg(long = "set-machine", value_name = "KEY=VALUE")]
    set_machine: Vec<String>,
    /// Run the job on nodes that are running already, in other processes.
    #[arg(long)]
    attach: bool,
    /// So many parts of the job, one after the other on one machine.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    parts: u32,
    /// The first part is ground as designed, and form compensation begins with it.
    #[arg(long)]
    forget_learned: bool,
    /// Grind the journals as far as the passes go, measure the stiffness of machine and cut on them, and no more
    #[arg(long)]
    identify_only: bool,
    /// What was measured of the machine's stiffness before is forgotten; for a job that measures it (identification)
    #[arg(long)]
    forget_stiffness: bool,
    /// Begin with this lobe, by name or number, on the part as it is in the machine of the cell that is attached to.
    #[arg(long, value_name = "LOBE", requires = "attach")]
    start_at: Option<String>,
    /// Find the angle at which the part is clamped, by its key-way, before it is ground.
    #[arg(long, conflicts_with_all = ["start_at", "parts"])]
    find_phase: bool,
    /// Print the result as JSON on standard output.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Default)]
enum PaceArg {
    Realtime,
    #[default]
    Fast,
}

/// The four nodes in this process.
struct Cell {
    logger: RunLogger,
    machine: MachineSim,
    interpolator: AxisInterpolator,
    planner: JobPlanner,
}

/// Entry point.
pub(super) fn main(args: &RunArgs, ros_args: &RosArgs) -> ExitCode {
    RosLayer::install();
    match run(args, ros_args) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("camwright run: {error}");
            ExitCode::from(1)
        }
    }
}

fn run(args: &RunArgs, ros_args: &RosArgs) -> Result<ExitCode, NodeError> {
    let mut args = args.clone();
    args.set.extend(args.start_at.iter().map(|lobe| format!("start_at={lobe}")));
    args.set.extend(args.identify_only.then(|| "identification.only=true".to_owned()));
    let started = Instant::now();
    let shutdown = Shutdown::on_signals()?;
    let job = args.job.clone().unwrap_or_else(|| "four_lobe_camshaft".to_owned());
    let bag = args.bag.clone().unwrap_or_else(|| default_bag(&job));
    if args.forget_learned && job_file::load(&job, &args.set).is_ok_and(|job| job.spec.compensation.is_none()) {
        return Err(NodeError::Parameter(format!("--forget-learned: job {job} does not learn (form_compensation)")));
    }
    let dry_run = job_file::load(&job, &args.set).is_ok_and(|job| job.spec.dry_run_mm.is_some());
    if dry_run && args.parts > 1 {
        return Err(NodeError::Parameter("--parts: a dry run makes no parts".into()));
    }
    if args.forget_stiffness && job_file::load(&job, &args.set).is_ok_and(|job| job.spec.identification.is_none()) {
        return Err(NodeError::Parameter(format!(
            "--forget-stiffness: job {job} does not measure it (identification)"
        )));
    }
    let client = Client::new(ros_args)?;
    let cell = if args.attach { None } else { Some(Cell::start(&job, &args, ros_args, &bag)?) };
    client.meet(cell.is_some(), &shutdown)?;
    if args.find_phase {
        let found = client.find_phase(&job, &args.set)?;
        args.set.extend(found);
    }
    let args = &args;
    let batch = if args.parts > 1 { Some(Batch::of(&client.node, args.parts, &job, &args.set)?) } else { None };
    let (outcome, batch) = client.run_parts(&job, args, batch, &shutdown);
    let planned_as = client.heard_job();
    if let Some(cell) = cell {
        cell.stop();
    }
    client.node.shutdown();
    let (status, result) = outcome?;
    let took = started.elapsed();
    let prepared = if result.success && !dry_run { planned_again(&job, args, planned_as.as_ref()) } else { None };
    // What only measures leaves no finished part whose errors had causes.
    let causes = prepared.as_ref().filter(|_| !args.identify_only);
    let causes = causes.and_then(|prepared| planning::causes(prepared).ok()).unwrap_or_default();
    // The same plan, or what it predicts is not what was predicted.
    let same = prepared.as_ref().filter(|prepared| prepared.plan_hash() == result.plan_hash);
    let times = same.map(|prepared| planning::compare_times(prepared, &result.lobes, result.duration));
    let bag = (!args.attach).then_some(&bag);
    let times = times.unwrap_or_default();
    let identifies = args.identify_only;
    let report = Report { job: &job, dry_run, status, result: &result, times, causes, batch, bag, took, identifies };
    if args.json {
        report.print_json();
    } else {
        report.print();
    }
    Ok(report.exit_code())
}

/// The machine that a job names; what is wrong with the job the planner says.
fn machine_of(job: &str, args: &RunArgs) -> String {
    any_job::machine_of(job, &args.set).unwrap_or_else(|| "cam_grinder".to_owned())
}

fn default_bag(job: &str) -> PathBuf {
    let name =
        std::path::Path::new(job).file_stem().map_or_else(|| job.to_owned(), |stem| stem.to_string_lossy().into());
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    PathBuf::from("bags").join(format!("{name}_{seconds}"))
}

impl Cell {
    fn start(job: &str, args: &RunArgs, ros_args: &RosArgs, bag: &std::path::Path) -> Result<Self, NodeError> {
        let pace = match args.pace {
            PaceArg::Realtime => "realtime",
            PaceArg::Fast => "fast",
        };
        let text = |text: &str| ParameterValue::String(text.to_owned());
        let args_of_cell = ros_args
            .clone()
            .with_parameter(None, "autostart", ParameterValue::Bool(false))
            .with_default_parameter(Some("machine_sim"), "machine", text(&machine_of(job, args)))
            .with_parameter(Some("machine_sim"), "pace", text(pace))
            .with_parameter(
                Some("machine_sim"),
                "machine_overrides",
                ParameterValue::StringArray(args.set_machine.clone()),
            )
            .with_parameter(Some("run_logger"), "bag_dir", text(&bag.to_string_lossy()))
            // A bag lasts as long as the machine took, not as long as the computer did.
            .with_parameter(Some("run_logger"), "use_sim_time", ParameterValue::Bool(args.pace == PaceArg::Fast));
        let cell = Self {
            logger: RunLogger::start(&args_of_cell)?,
            machine: MachineSim::start(&args_of_cell)?,
            interpolator: AxisInterpolator::start(&args_of_cell)?,
            planner: JobPlanner::start(&args_of_cell)?,
        };
        // Recorder first, so that the bag begins before anything happens; then from the axes upwards.
        for lifecycle in cell.lifecycles() {
            lifecycle.trigger(Transition::Configure)?;
            lifecycle.trigger(Transition::Activate)?;
        }
        Ok(cell)
    }

    fn lifecycles(&self) -> [&Lifecycle; 4] {
        [self.logger.lifecycle(), self.machine.lifecycle(), self.interpolator.lifecycle(), self.planner.lifecycle()]
    }

    /// Ends the cell from the top down, the recorder last.
    fn stop(self) {
        self.planner.stop();
        self.interpolator.stop();
        self.machine.stop();
        self.logger.stop();
    }
}

/// What the client waits for: set by callbacks, watched by the main thread.
#[derive(Debug, Default)]
struct Heard {
    recorder: Option<RecorderStatus>,
    job: Option<JobStatus>,
}

/// The part of the command that talks to the cell like any other ROS client.
struct Client {
    node: Node,
    action: crate::ros::ActionClient<RunJob>,
    heard: Arc<(Mutex<Heard>, Condvar)>,
    _spin: crate::ros::SpinThread,
    _subscriptions: Vec<Subscription>,
}

impl Client {
    fn new(ros_args: &RosArgs) -> Result<Self, NodeError> {
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
        let action = node.action_client::<RunJob>("job_planner/run_job")?;
        let spin = node.spin_in_thread()?;
        Ok(Self { node, action, heard, _spin: spin, _subscriptions: vec![recorder, job] })
    }

    /// Waits until the planner can be asked and, with a recorder, until it records what matters.
    fn meet(&self, with_recorder: bool, shutdown: &Shutdown) -> Result<(), NodeError> {
        self.action.wait_for_server(MEETING)?;
        for node in ["machine_sim", "axis_interpolator", "job_planner"] {
            self.wait_active(node, shutdown)?;
        }
        if !with_recorder {
            return Ok(());
        }
        let wanted = ["joint_states", "machine/stream", "machine/setpoints", "machine/part", "job_planner/plan"];
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
    fn find_phase(&self, job: &str, overrides: &[String]) -> Result<[String; 2], NodeError> {
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

    /// So many parts as are wanted, or until one fails; the outcome is the last one's.
    fn run_parts(
        &self,
        job: &str,
        args: &RunArgs,
        mut batch: Option<Batch>,
        shutdown: &Shutdown,
    ) -> (Result<(GoalStatus, RunJobResult), NodeError>, Option<Batch>) {
        let mut overrides = args.set.clone();
        overrides.extend(args.forget_learned.then(|| "form_compensation.afresh=true".to_owned()));
        overrides.extend(args.forget_stiffness.then(|| "identification.afresh=true".to_owned()));
        loop {
            let outcome = self.run_job(job, &overrides, shutdown);
            overrides.clone_from(&args.set);
            let goes_on = match (&outcome, &mut batch) {
                (Ok((GoalStatus::Succeeded, result)), Some(batch)) if result.success => batch.take(result),
                _ => false,
            };
            if !goes_on || shutdown.is_requested() {
                return (outcome, batch);
            }
        }
    }

    /// What the planner said of its job last.
    fn heard_job(&self) -> Option<JobStatus> {
        self.heard.0.lock().unwrap_or_else(PoisonError::into_inner).job.clone()
    }

    fn run_job(
        &self,
        job: &str,
        overrides: &[String],
        shutdown: &Shutdown,
    ) -> Result<(GoalStatus, RunJobResult), NodeError> {
        let progress = ProgressBar::new(1000);
        let style = ProgressStyle::with_template("{bar:30} {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
        progress.set_style(style);
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
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a percentage")]
    progress.set_position((feedback.percent.clamp(0.0, 100.0) * 10.0) as u64);
    let mut text = format!("{:>3.0} %  {} {}", feedback.percent, feedback.lobe, feedback.phase_name);
    if feedback.turns > 0.0 {
        let _infallible = write!(text, ", turn {:.1} of {:.0}", feedback.turn, feedback.turns);
        let _infallible = write!(text, ", stock {:.0} um", um(feedback.stock));
    }
    let _infallible = write!(text, ", {:.0} s left", feedback.time_left);
    progress.set_message(text);
}

/// The same job without ROS, for the machine with its overrides. What it had learned and what was kept for it
/// stands in what the planner recorded of it.
fn planned_again(job: &str, args: &RunArgs, planned_as: Option<&JobStatus>) -> Option<PreparedJob> {
    let mut job = match (planned_as, job_file::load(job, &args.set).ok()?) {
        (Some(status), loaded)
            if (loaded.spec.compensation.is_some() || loaded.spec.correction.is_some())
                && !status.job_source.is_empty() =>
        {
            let located = Located { path: loaded.document.path.clone(), text: status.job_source.clone() };
            job_file::parse(&located, &[]).ok()?
        }
        (_, loaded) => loaded,
    };
    job.machine = job.machine.with_overrides(&args.set_machine).ok()?;
    planning::plan(job, None).ok()
}
