//! The job planner among the nodes it works with: jobs run, refused, cancelled, previewed.

mod support;

use camwright_msgs::camwright_msgs::action::{RunJob, RunJobFeedback, RunJobGoal};
use camwright_msgs::camwright_msgs::msg::{InterpolatorState, JobStatus, PartLobe};
use camwright_msgs::camwright_msgs::srv::{
    ListJobs, ListJobsRequest, LoadJob, LoadJobRequest, PreviewJob, PreviewJobRequest, ValidateJob, ValidateJobRequest,
};
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_nodes::axis_interpolator::AxisInterpolator;
use camwright_nodes::job_planner::JobPlanner;
use camwright_nodes::machine_sim::MachineSim;
use camwright_nodes::ros::{
    ActionClient, CancelOutcome, ClientGoal, GoalStatus, Node, NodeOptions, ParameterValue, Qos, RosArgs, SpinThread,
    Subscription, Transition,
};
use std::sync::{Arc, Mutex, mpsc};
use std::time::Duration;
use support::Domain;

/// Generous: the machine may be building at the same time.
const PATIENCE: Duration = Duration::from_secs(60);

/// Machine, interpolator, planner and a client that watches them.
struct Cell {
    machine: MachineSim,
    interpolator: AxisInterpolator,
    planner: JobPlanner,
    client: Client,
    _domain: Domain,
}

struct Client {
    node: Node,
    action: ActionClient<RunJob>,
    statuses: mpsc::Receiver<JobStatus>,
    moved: Arc<Mutex<bool>>,
    parts: Arc<Mutex<Vec<PartLobe>>>,
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

    fn send(&self, job: &str, overrides: &[&str]) -> (ClientGoal<RunJob>, mpsc::Receiver<RunJobFeedback>) {
        let (sender, feedback) = mpsc::channel();
        let overrides = overrides.iter().map(ToString::to_string).collect();
        let goal = RunJobGoal { job: job.into(), overrides };
        let send = move |feedback| drop(sender.send(feedback));
        (self.action.send_goal(goal, send, PATIENCE).expect("a decision"), feedback)
    }

    /// Waits for a status.
    fn status(&self, what: &str, wanted: impl Fn(&JobStatus) -> bool) -> JobStatus {
        loop {
            let status = self.statuses.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("no status that {what}"));
            if wanted(&status) {
                return status;
            }
        }
    }

    fn call<S: camwright_msgs::Service>(&self, name: &str, request: &S::Request) -> S::Response {
        let client = self.node.client::<S>(name).expect("a client");
        client.wait_for_service(PATIENCE).expect("the service");
        client.call(request, PATIENCE).expect("an answer")
    }
}

impl Cell {
    fn start() -> Self {
        let domain = Domain::take();
        let text = |text: &str| ParameterValue::String(text.into());
        let args = RosArgs::default()
            .with_domain_id(domain.id())
            .with_parameter(Some("machine_sim"), "pace", text("fast"))
            .with_parameter(Some("machine_sim"), "state_file", text("none"));
        let client = Client::new(&args);
        let machine = MachineSim::start(&args).expect("machine_sim");
        let interpolator = AxisInterpolator::start(&args).expect("axis_interpolator");
        let planner = JobPlanner::start(&args).expect("job_planner");
        client.action.wait_for_server(PATIENCE).expect("run_job");
        for _ in 0..600 {
            if planner.knows_machine() && interpolator.knows_machine() {
                return Self { machine, interpolator, planner, client, _domain: domain };
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        panic!("the machine was not heard of");
    }

    fn stop(self) {
        self.planner.stop();
        self.interpolator.stop();
        self.machine.stop();
        self.client.node.shutdown();
    }
}

/// One lobe, with the mounted wheel, in few turns.
const SHORT: [&str; 3] = ["wheel_radius_mm=60.0", "infeed.per_block_um=0.05", "infeed.spark_out_turns=1"];

#[test]
fn a_job_is_run_to_its_end_with_feedback_and_measured() {
    let cell = Cell::start();
    let (goal, feedback) = cell.client.send("eccentric", &SHORT);
    assert!(goal.accepted(), "{:?}", cell.client.statuses.try_iter().last());
    let (busy, _) = cell.client.send("eccentric", &SHORT);
    assert!(!busy.accepted(), "one job at a time");
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    assert!(result.success && result.alarm == 0);
    assert_eq!(result.lobes.len(), 1);
    let lobe = &result.lobes[0];
    assert!(lobe.form_error_max.abs() < 5e-6, "{} m", lobe.form_error_max);
    assert!(lobe.form_error_rms <= lobe.form_error_max.abs());
    assert!((lobe.turns - 3.0).abs() < 1e-12, "2 turns with infeed and 1 without: {}", lobe.turns);
    assert!(lobe.duration > 3.0 && lobe.duration < result.duration, "{} of {} s", lobe.duration, result.duration);
    let feedback: Vec<RunJobFeedback> = feedback.try_iter().collect();
    let phases: Vec<&str> = feedback.iter().map(|feedback| feedback.phase_name.as_str()).collect();
    for phase in ["home", "index", "cut", "retract"] {
        assert!(phases.contains(&phase), "{phase} is not in {phases:?}");
    }
    assert!(feedback.iter().any(|feedback| feedback.lobe == "A" && feedback.stock > 0.0));
    let complete = cell.client.status("is complete", |status| status.state == JobStatus::COMPLETE);
    assert_eq!(complete.plan_hash, result.plan_hash);
    assert!(complete.job_source.contains("per_block_um: 0.05"), "overrides are written in: {}", complete.job_source);
    assert_eq!(complete.lobes, result.lobes);

    // The same again, from the loaded plan, without a word more; two runs of one plan give one part.
    let load = LoadJobRequest { job: "eccentric".into(), overrides: SHORT.map(String::from).into() };
    let loaded = cell.client.call::<LoadJob>("job_planner/load_job", &load);
    assert!(loaded.success, "{}", loaded.message);
    assert_eq!(loaded.plan_hash, result.plan_hash);
    let (again, _) = cell.client.send("", &[]);
    assert!(again.accepted());
    let (status, second) = again.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", second.message);
    let error = (second.lobes[0].form_error_max - lobe.form_error_max).abs();
    assert!(error < 1e-9, "{error} m between two parts");
    cell.stop();
}

#[test]
fn a_cancelled_job_comes_to_rest_and_the_next_one_runs() {
    let cell = Cell::start();
    let (goal, feedback) = cell.client.send("eccentric", &SHORT);
    assert!(goal.accepted());
    loop {
        let feedback = feedback.recv_timeout(PATIENCE).expect("feedback");
        if feedback.phase_name == "cut" {
            break;
        }
    }
    assert_eq!(goal.cancel(PATIENCE).expect("an answer"), CancelOutcome::Accepted);
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Canceled, "{}", result.message);
    assert!(!result.success && !result.message.is_empty());
    cell.client.status("is stopped", |status| status.state == JobStatus::STOPPED);
    let (goal, _) = cell.client.send("eccentric", &SHORT);
    assert!(goal.accepted());
    let stop = cell.client.call::<Trigger>("job_planner/stop", &TriggerRequest::default());
    assert!(stop.success, "{}", stop.message);
    assert_eq!(goal.result(PATIENCE).expect("a result").0, GoalStatus::Canceled);
    let (goal, _) = cell.client.send("eccentric", &SHORT);
    assert!(goal.accepted());
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    cell.stop();
}

#[test]
fn what_cannot_be_made_is_a_rejection_with_nothing_moved() {
    let cell = Cell::start();
    let unknown = |text: &str| text.replace("work_speed_rpm:", "work_speed_rmp:");
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("planner-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder under target/tmp");
    let job = folder.join("job.yaml");
    let params = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../params/jobs/eccentric.yaml");
    std::fs::write(&job, unknown(&std::fs::read_to_string(params).expect("the eccentric job"))).expect("a job");
    let job = job.display().to_string();
    for (job, overrides, words) in [
        (job.as_str(), vec![], "work_speed_rmp"),
        ("eccentric", vec![], "wheel_radius_mm is 15, the wheel mounted on cam_grinder has 60"),
        ("eccentric", vec![SHORT[0], "lobes.A.station=LS9"], "LS1, LS2, LS3, LS4"),
        ("eccentric", vec![SHORT[0], "infeed.total_mm=0.35"], "whole turns are needed"),
        ("no_such_job", vec![], "four_lobe_camshaft"),
    ] {
        let (goal, _) = cell.client.send(job, &overrides);
        assert!(!goal.accepted(), "{job} {overrides:?}");
        let status = cell.client.status(words, |status| status.message.contains(words));
        assert_eq!(status.state, JobStatus::IDLE);
        let overrides = overrides.iter().map(ToString::to_string).collect();
        let request = ValidateJobRequest { job: job.into(), overrides };
        let validated = cell.client.call::<ValidateJob>("job_planner/validate_job", &request);
        assert!(!validated.success && validated.message.contains(words), "{}", validated.message);
        assert!(!validated.findings.is_empty());
    }
    assert!(!*cell.client.moved.lock().expect("not poisoned"), "nothing moved");
    assert!(cell.client.parts.lock().expect("not poisoned").is_empty(), "no blank was loaded");
    // A planner that is not active takes no job at all.
    cell.planner.lifecycle().trigger(Transition::Deactivate).expect("inactive");
    let (goal, _) = cell.client.send("eccentric", &SHORT);
    assert!(!goal.accepted());
    drop(std::fs::remove_dir_all(folder));
    cell.stop();
}

/// A goal's overrides beat parameters, which beat the file; a parameter that is unset leaves the file's value.
#[test]
fn settings_come_from_the_goal_then_the_parameters_then_the_file() {
    let cell = Cell::start();
    let duration = |overrides: &[&str]| {
        let overrides = overrides.iter().map(ToString::to_string).collect();
        let request = PreviewJobRequest { job: "four_lobe_camshaft".into(), overrides, points: 90, ..Default::default() };
        let preview = cell.client.call::<PreviewJob>("job_planner/preview_job", &request);
        assert!(preview.success, "{}", preview.message);
        assert_eq!((preview.contour_radius.len(), preview.turn.points.len()), (90, 90));
        assert!((preview.contour_radius[0] - 0.016).abs() < 1e-6, "the base circle of I1");
        preview.duration
    };
    let file = duration(&[]);
    let node = cell.planner.node();
    let set = |value: ParameterValue| node.parameters().set(node, "work_speed_rpm", value);
    set(ParameterValue::Double(30.0)).expect("a setting");
    let slower = duration(&[]);
    assert!((slower - file - 48.0).abs() < 1.0, "48 turns take a second longer each: {file} s, {slower} s");
    let goal = duration(&["work_speed_rpm=60.0"]);
    assert!((goal - file).abs() < 1e-9, "{goal} {file}");
    set(ParameterValue::NotSet).expect("unset");
    assert!((duration(&[]) - file).abs() < 1e-9);
    assert!(set(ParameterValue::Double(f64::NAN)).is_err());
    let jobs = cell.client.call::<ListJobs>("job_planner/list_jobs", &ListJobsRequest::default());
    assert!(jobs.jobs.iter().any(|job| job == "four_lobe_camshaft"), "{:?}", jobs.jobs);
    cell.stop();
}
