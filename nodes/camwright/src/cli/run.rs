// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright run`: the whole cell in one process, or the job on a cell that runs already.

use super::bag_room;
use super::batch::Batch;
use super::output::{is_quiet, note, print_error, print_warning, print_warnings, whole_number};
use super::pace::PaceArg;
use super::run_cell::CellNodes;
use super::run_client::{CellClient, JobEnd};
use super::run_part::PartProgress;
use super::run_progress::{RunProgress, Stage};
use super::run_report::{Report, RunFiles};
use super::turned_report::TurnedReport;
use camwright_analysis::report;
use camwright_authority::{HeldCommand, TakeOptions};
use camwright_files::ConfigError;
use camwright_files::access::folders_of;
use camwright_files::any_job::{self, AnyJob};
use camwright_files::job_file::{self, Job};
use camwright_files::locate::{Located, locate};
use camwright_job_planner::JobPlanner;
use camwright_machine_sim::MachineSim;
use camwright_msgs::camwright_msgs::action::RunJobResult;
use camwright_msgs::camwright_msgs::msg::{FormMap, JobStatus};
use camwright_operator_page::{DEFAULT_ADDRESS, HolderSocket, Operator, OperatorPage};
use camwright_planning::{self as planning, AnyPrepared, Causes, PreparedJob, PreparedTurning};
use camwright_ros::running::NodeError;
use camwright_ros::{GoalStatus, Level, NodeLock, RosArgs, RosLayer, Shutdown};
use camwright_threads::supervised;
use clap::Args;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Topics that the recorder must find before anything moves.
const GRINDING_RECORD: [&str; 5] =
    ["joint_states", "machine/stream", "machine/setpoints", "machine/part", "job_planner/plan"];
const TURNING_RECORD: [&str; 6] = [
    "joint_states",
    "machine/stream",
    "machine/setpoints",
    "machine/turned_part",
    "job_planner/plan",
    "job_planner/form_map",
];

/// Arguments of `camwright run`.
#[derive(Debug, Clone, Args)]
#[command(after_help = super::help::RUN)]
pub(super) struct RunArgs {
    /// Name or path of the job.
    #[arg(default_value = "four_lobe_camshaft")]
    job: Option<String>,
    /// Run in real time or as fast as possible.
    #[arg(long, value_enum, default_value_t = PaceArg::Fast)]
    pace: PaceArg,
    /// New directory for the bag [default: bags/<job>_<time>].
    #[arg(long, value_name = "DIR")]
    bag: Option<PathBuf>,
    /// Set a key of the job, such as `infeed.total_mm=0.72`; repeatable.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Set a key of the machine, such as `x_axis.drive.kv_1_s=150`; repeatable.
    #[arg(long = "set-machine", value_name = "KEY=VALUE")]
    set_machine: Vec<String>,
    /// Use the nodes of a running cell instead of starting one; see below.
    #[arg(long)]
    attach: bool,
    /// Number of parts to grind.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = parts)]
    pub(super) parts: u32,
    /// Discard the learned form compensation first.
    #[arg(long)]
    forget_learned: bool,
    /// Only grind the journals and measure the stiffness of machine and cut.
    #[arg(long)]
    identify_only: bool,
    /// Discard the measured stiffness first; for jobs with `identification`.
    #[arg(long)]
    forget_stiffness: bool,
    /// Begin with this lobe (name or number) on the part in the machine.
    #[arg(long, value_name = "LOBE", requires = "attach")]
    start_at: Option<String>,
    /// Find the phase of the clamped part by its keyway first.
    #[arg(long, conflicts_with_all = ["start_at", "parts"])]
    find_phase: bool,
    /// Serve the operator page on this port of this computer.
    #[arg(long, value_name = "PORT", num_args = 0..=1, require_equals = true, default_missing_value = "8080", value_parser = super::page::port)]
    page: Option<u16>,
    /// Let viewers of the page operate the cell; the printed address contains the token.
    #[arg(long, requires = "page")]
    control: bool,
    /// Print the result as JSON on standard output.
    #[arg(long)]
    json: bool,
    /// Print all results: times, power, stiffness, runout.
    #[arg(long)]
    details: bool,
    /// Simulate the job without each effect of the machine and print the form error of each.
    #[arg(long)]
    causes: bool,
    /// Print the time that each stage took on standard error.
    #[arg(long)]
    timings: bool,
    /// Show the log lines of the nodes; without it only warnings and errors.
    #[arg(long, short)]
    verbose: bool,
}

fn parts(text: &str) -> Result<u32, String> {
    whole_number(text, 1..=10_000)
}

/// Entry point.
pub(super) fn main(args: &RunArgs, ros_args: &RosArgs) -> ExitCode {
    RosLayer::install();
    camwright_ros::limit_memory();
    supervised::injected::from_environment();
    match run(args, ros_args) {
        Ok(code) => supervised::exit_code().unwrap_or(code),
        Err(error) => {
            print_error("camwright run", &error);
            supervised::exit_code().unwrap_or_else(|| ExitCode::from(1))
        }
    }
}

fn run(args: &RunArgs, ros_args: &RosArgs) -> Result<ExitCode, NodeError> {
    let started = Instant::now();
    let progress = RunProgress::start(args.verbose);
    let lowest = match (is_quiet(), args.verbose) {
        (true, _) => Level::Error,
        (false, true) => Level::Unset,
        (false, false) => Level::Warn,
    };
    let ros_args = &ros_args.clone().with_console_level(lowest).with_intra_process();
    let shutdown = Shutdown::on_signals()?;
    let mut request = Request::from_args(args)?;
    let own = request.prepare_cell(ros_args)?;
    let page = progress.suspend(|| start_page(args, ros_args))?;
    progress.enter(Stage::Starting);
    let client = CellClient::new(ros_args)?;
    if own.is_some() {
        client.is_alone(ros_args)?;
    }
    let cell = own.as_ref().map(|own| CellNodes::start(&own.ros_args, own.planned.clone())).transpose()?;
    let (planned, locks) = own.map(|own| (own.planned, own.locks)).unzip();
    client.meet(cell.is_some().then(|| request.recorded_topics()), &shutdown)?;
    if let Some(risk) = cell.as_ref().filter(|_| args.pace == PaceArg::Realtime).and_then(CellNodes::underrun_risk) {
        progress.suspend(|| print_warning("warning", &risk));
    }
    progress.enter(Stage::Running);
    let finished = run_job(&client, &mut request, ros_args, &progress, &shutdown);
    progress.enter(Stage::Closing);
    let farewells = (cell.map(CellNodes::stop), client.node.leave());
    let finished = match finished {
        Ok(finished) => finished,
        Err(error) => {
            page.into_iter().for_each(OperatorPage::stop);
            return Err(error);
        }
    };
    page.iter().for_each(OperatorPage::end_cell);
    progress.enter(Stage::Reporting);
    let code = request.report(finished, planned, &progress, started.elapsed());
    drop(farewells);
    drop(locks);
    if args.timings {
        note!("{}", progress.timings());
    }
    if let Some(page) = page {
        note!("the operator page stays until Ctrl-C: {}", page.url());
        shutdown.wait();
        page.stop();
    }
    Ok(code)
}

/// Cell that will run in this process.
struct OwnCell {
    /// Arguments of its nodes.
    ros_args: RosArgs,
    /// The job, planned for its machine.
    planned: AnyPrepared,
    /// Names of its nodes.
    locks: [NodeLock; 4],
}

/// Job, arguments and bag of one run.
struct Request {
    job: String,
    /// Includes the overrides that other arguments stand for.
    args: RunArgs,
    bag: PathBuf,
    /// None for a job that only the running cell finds.
    read: Option<AnyJob>,
    turns: bool,
}

/// Outcome of a run, with the messages of the planner that its report needs.
struct Finished {
    status: GoalStatus,
    result: RunJobResult,
    batch: Option<Batch>,
    planned_as: Option<JobStatus>,
    form_map: Option<FormMap>,
    part: PartProgress,
}

impl Request {
    /// Reads the job and rejects arguments that do not fit it.
    fn from_args(args: &RunArgs) -> Result<Self, NodeError> {
        let mut args = args.clone();
        let job = args.job.clone().unwrap_or_else(|| "four_lobe_camshaft".to_owned());
        // The nodes of a running cell have another folder.
        let job = if args.attach { from_here(job) } else { job };
        let bag = args.bag.clone().unwrap_or_else(|| default_bag(&job));
        let turns = any_job::turns(&job, &args.set);
        if turns {
            fits_turning(&job, &args).map_err(NodeError::Parameter)?;
        }
        args.set.extend(args.start_at.iter().map(|lobe| format!("start_at={lobe}")));
        args.set.extend(args.identify_only.then(|| "identification.only=true".to_owned()));
        // A running cell may find jobs that this process does not.
        let is_elsewhere = args.attach && locate("jobs", &job, "yaml", None).is_err();
        let read = if is_elsewhere { None } else { Some(read_job(&job, &args.set)?) };
        match &read {
            Some(AnyJob::Ground(read)) => fits_grinding(&job, read, &args).map_err(NodeError::Parameter)?,
            Some(AnyJob::Milled(read)) => return Err(not_started(&planning::is_milled(read))),
            Some(AnyJob::Turned(_)) | None => {}
        }
        Ok(Self { job, args, bag, read, turns })
    }

    fn is_dry_run(&self) -> bool {
        matches!(&self.read, Some(AnyJob::Ground(job)) if job.spec.dry_run_mm.is_some())
    }

    /// Topics that the recorder must find before anything moves.
    fn recorded_topics(&self) -> &'static [&'static str] {
        // A turning job on a grinding machine is rejected, and needs no recording.
        let on_lathe = matches!(&self.read, Some(AnyJob::Turned(job)) if job.machine.description.is_lathe());
        if on_lathe { &TURNING_RECORD } else { &GRINDING_RECORD }
    }

    /// Checks everything that a cell in this process needs, before a node starts; none for a cell that runs already.
    fn prepare_cell(&self, ros_args: &RosArgs) -> Result<Option<OwnCell>, NodeError> {
        let (args, job) = (&self.args, &self.job);
        if args.attach {
            return Ok(None);
        }
        bag_room::is_free(&self.bag)?;
        let machine = any_job::machine_of(job, &args.set).unwrap_or_else(|| "cam_grinder".to_owned());
        let folders = folders_of(&args.set);
        let ros_args = CellNodes::arguments(&machine, &args.set_machine, folders, args.pace, ros_args, &self.bag);
        let machine = MachineSim::machine_from_args(&ros_args)?;
        let overrides = JobPlanner::overrides_from_args(&ros_args, job, &args.set)?;
        let read = match &self.read {
            Some(read) if overrides == args.set => read.clone(),
            _ => read_job(job, &overrides)?,
        };
        let planned = planning::plan_any(read, Some(&machine)).map_err(|error| not_started(&error))?;
        bag_room::announce(&planned, args.pace, args.parts, &self.bag, args.verbose)?;
        print_warnings(&planned);
        let locks = CellNodes::lock(&ros_args)?;
        Ok(Some(OwnCell { ros_args, planned, locks }))
    }

    /// Prints the report of a finished run; returns the exit code.
    fn report(
        self,
        finished: Finished,
        planned: Option<AnyPrepared>,
        progress: &RunProgress,
        took: Duration,
    ) -> ExitCode {
        let bag = (!self.args.attach).then(|| self.bag.clone());
        let report = bag.as_deref().and_then(|bag| page_of(bag, planned.as_ref(), progress));
        let files = RunFiles { bag, report };
        if self.turns {
            self.report_turned(finished, planned, files, progress, took)
        } else {
            self.report_ground(finished, planned, files, progress, took)
        }
    }

    fn report_turned(
        self,
        finished: Finished,
        planned: Option<AnyPrepared>,
        files: RunFiles,
        progress: &RunProgress,
        took: Duration,
    ) -> ExitCode {
        let Self { job, args, read, .. } = self;
        let Finished { status, result, form_map, .. } = finished;
        let read = read.filter(|_| status == GoalStatus::Succeeded);
        let prepared = replanned_turning(read, planned, &args, &result);
        let predicted_s = prepared.as_ref().map(PreparedTurning::duration_s);
        let asked = prepared.as_ref().filter(|_| args.causes);
        let causes =
            asked.and_then(|prepared| planning::turned_causes(prepared, &|done, of| progress.simulated(done, of)).ok());
        let causes = causes.unwrap_or_default();
        let report = TurnedReport { job: &job, status, result: &result, predicted_s, form_map, causes, files, took };
        progress.end(status);
        if args.json {
            report.print_json();
        } else {
            report.print(args.details);
        }
        report.exit_code()
    }

    fn report_ground(
        self,
        finished: Finished,
        planned: Option<AnyPrepared>,
        files: RunFiles,
        progress: &RunProgress,
        took: Duration,
    ) -> ExitCode {
        let dry_run = self.is_dry_run();
        let Self { job, args, .. } = self;
        let Finished { status, result, batch, planned_as, part, .. } = finished;
        let again = || match planned {
            Some(AnyPrepared::Ground(planned)) if planned.plan_hash() == result.plan_hash => Some(*planned),
            planned => replanned(&job, planned, &args, planned_as.as_ref()),
        };
        let prepared = if status == GoalStatus::Succeeded && !dry_run { again() } else { None };
        // Predictions of another plan are not those of this run.
        let same = prepared.as_ref().filter(|prepared| prepared.plan_hash() == result.plan_hash);
        let times = same.map(|prepared| planning::compare_times(prepared, &result.lobes, result.duration));
        let times = times.unwrap_or_default();
        let identifies = args.identify_only;
        let causes = Causes::default();
        let (job, result) = (&*job, &result);
        let mut report = Report { job, dry_run, status, result, times, causes, batch, part, files, took, identifies };
        // A job that only measures leaves no finished part whose errors have causes.
        if let Some(prepared) = prepared.as_ref().filter(|_| args.causes && !identifies) {
            let causes = planning::causes(prepared, &|done, of| progress.simulated(done, of));
            report.causes = causes.unwrap_or_default();
        }
        progress.end(status);
        if args.json {
            report.print_json();
        } else {
            report.print(args.details);
        }
        report.exit_code()
    }
}

/// Serves the operator page with `--page`.
fn start_page(args: &RunArgs, ros_args: &RosArgs) -> Result<Option<OperatorPage>, NodeError> {
    let Some(port) = args.page else { return Ok(None) };
    let page = OperatorPage::start(ros_args, SocketAddr::new(DEFAULT_ADDRESS.ip(), port), args.control)?;
    super::page::print_address(&page);
    Ok(Some(page))
}

/// Takes command, finds the phase of the part with `--find-phase`, and runs all parts.
fn run_job(
    client: &CellClient,
    request: &mut Request,
    ros_args: &RosArgs,
    progress: &RunProgress,
    shutdown: &Shutdown,
) -> Result<Finished, NodeError> {
    let command = TakeOptions::new("camwright run").for_cell();
    let command =
        HeldCommand::acquire(&client.node, &command).map_err(|error| NodeError::Parameter(error.to_string()))?;
    let socket = progress.suspend(|| serve_operators(client, ros_args));
    if request.args.find_phase {
        let found = client.find_phase(&request.job, &request.args.set)?;
        request.args.set.extend(found);
    }
    let Request { job, args, .. } = request;
    let batch = if args.parts > 1 { Some(Batch::subscribe(&client.node, args.parts, job, &args.set)?) } else { None };
    let (outcome, batch) = run_parts(client, job, args, batch, progress, shutdown);
    drop(socket);
    drop(command);
    let planned_as = client.last_job_status();
    let has_form = outcome.as_ref().ok().filter(|(_, result, _)| !result.turned.is_empty());
    let form_map = has_form.and_then(|(_, result, _)| client.form_map(result.last_tick));
    outcome.map(|(status, result, part)| Finished { status, result, batch, planned_as, form_map, part })
}

/// Lets other processes of this user operate the cell during the job.
fn serve_operators(client: &CellClient, ros_args: &RosArgs) -> Option<HolderSocket> {
    let operator = Operator::new(client.node.clone(), ros_args, "camwright run");
    match HolderSocket::serve(&operator, client.node.supervisor()) {
        Ok(socket) => Some(socket),
        Err(error) => {
            let message = format!("`camwright resume` and others cannot operate this run: {error}");
            print_warning("camwright run", &message);
            None
        }
    }
}

/// A job file of this folder by its whole path; other names as they are.
pub(super) fn from_here(job: String) -> String {
    let path = Path::new(&job);
    let whole = path.is_file().then(|| std::path::absolute(path).ok()).flatten();
    whole.and_then(|path| path.to_str().map(str::to_owned)).unwrap_or(job)
}

/// Reads the job.
fn read_job(job: &str, overrides: &[String]) -> Result<AnyJob, NodeError> {
    let located = locate("jobs", job, "yaml", None).map_err(|error| not_started(&error))?;
    any_job::read(&located, overrides).map_err(|findings| {
        let more = match findings.len() {
            0 | 1 => String::new(),
            count => format!("; `camwright check {job}` lists all {count} errors"),
        };
        let first = findings.first().map(ToString::to_string).unwrap_or_default();
        NodeError::Parameter(format!("job rejected, nothing started: {first}{more}"))
    })
}

/// Error for a job that is refused before a node starts.
fn not_started(error: &ConfigError) -> NodeError {
    NodeError::Parameter(format!("job rejected, nothing started: {error}"))
}

/// Writes the report of the run from its bag. A failure is printed and does not fail the run.
fn page_of(bag: &Path, planned: Option<&AnyPrepared>, progress: &RunProgress) -> Option<PathBuf> {
    match report::write(bag, None, planned) {
        Ok(page) => Some(page),
        Err(error) => {
            let message = format!("the report cannot be written: {error}");
            progress.suspend(|| print_warning("camwright run", &message));
            None
        }
    }
}

/// Runs all parts until one fails; the outcome is that of the last part.
fn run_parts(
    client: &CellClient,
    job: &str,
    args: &RunArgs,
    mut batch: Option<Batch>,
    progress: &RunProgress,
    shutdown: &Shutdown,
) -> (Result<JobEnd, NodeError>, Option<Batch>) {
    let mut overrides = args.set.clone();
    overrides.extend(args.forget_learned.then(|| "form_compensation.afresh=true".to_owned()));
    overrides.extend(args.forget_stiffness.then(|| "identification.afresh=true".to_owned()));
    let mut part = 0;
    loop {
        let outcome = client.run_job(job, &overrides, &progress.job(part, args.parts), shutdown);
        part += 1;
        overrides.clone_from(&args.set);
        let goes_on = match (&outcome, &mut batch) {
            (Ok((GoalStatus::Succeeded, result, _)), Some(batch)) => batch.measure(result),
            _ => false,
        };
        if !goes_on || shutdown.is_requested() {
            return (outcome, batch);
        }
    }
}

/// Rejects arguments that do not fit a grinding job.
fn fits_grinding(job: &str, read: &Job, args: &RunArgs) -> Result<(), String> {
    if args.forget_learned && read.spec.compensation.is_none() {
        return Err(format!("--forget-learned: job {job} does not learn; add the key form_compensation"));
    }
    if args.parts > 1 && read.spec.dry_run_mm.is_some() {
        return Err("--parts: a dry run makes no parts; remove --parts or dry_run".into());
    }
    if args.forget_stiffness && read.spec.identification.is_none() {
        return Err(format!("--forget-stiffness: job {job} does not measure stiffness; add the key identification"));
    }
    Ok(())
}

/// Rejects arguments that do not fit a turning job.
fn fits_turning(job: &str, args: &RunArgs) -> Result<(), String> {
    let asked = [
        ("--parts", args.parts > 1, "capability is defined for ground lobes only"),
        ("--forget-learned", args.forget_learned, "turning does not learn"),
        ("--identify-only", args.identify_only, "turning measures no stiffness"),
        ("--forget-stiffness", args.forget_stiffness, "turning measures no stiffness"),
        ("--start-at", args.start_at.is_some(), "a turned part has no lobes"),
        ("--find-phase", args.find_phase, "the raw part is a round bar"),
    ];
    match asked.iter().find(|(_, is_asked, _)| *is_asked) {
        Some((flag, _, reason)) => Err(format!("{flag} does not apply to turning job {job}: {reason}")),
        None => Ok(()),
    }
}

fn default_bag(job: &str) -> PathBuf {
    let name = Path::new(job).file_stem().map_or_else(|| job.to_owned(), |stem| stem.to_string_lossy().into());
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    PathBuf::from("bags").join(format!("{name}_{seconds}"))
}

/// Plans the job again without ROS, for the machine with its overrides. The recorded job source holds the learned compensation and the
/// stored correction.
fn replanned(
    job: &str,
    planned: Option<AnyPrepared>,
    args: &RunArgs,
    planned_as: Option<&JobStatus>,
) -> Option<PreparedJob> {
    let mut job = match (planned_as, job_file::load(job, &args.set).ok()?) {
        (Some(status), loaded)
            if (loaded.spec.compensation.is_some() || loaded.spec.correction.is_some())
                && !status.job_source.is_empty() =>
        {
            let located = Located::new(loaded.document.path.clone(), status.job_source.clone());
            job_file::parse(&located, &[]).ok()?
        }
        (_, loaded) => loaded,
    };
    job.machine = job.machine.with_overrides(&args.set_machine).ok()?;
    match plan_unless(planned, AnyJob::Ground(Box::new(job)))? {
        AnyPrepared::Ground(prepared) => Some(*prepared),
        AnyPrepared::Turned(_) => None,
    }
}

/// Plans a turning job again without ROS; none if the plan of the run was another.
fn replanned_turning(
    read: Option<AnyJob>,
    planned: Option<AnyPrepared>,
    args: &RunArgs,
    result: &RunJobResult,
) -> Option<PreparedTurning> {
    let Some(AnyJob::Turned(mut job)) = read else { return None };
    job.machine = job.machine.with_overrides(&args.set_machine).ok()?;
    match plan_unless(planned, AnyJob::Turned(job))? {
        AnyPrepared::Turned(prepared) => Some(*prepared).filter(|prepared| prepared.plan_hash() == result.plan_hash),
        AnyPrepared::Ground(_) => None,
    }
}

/// Plans a job for its machine. Reuses the plan of the start if files and machine are the same: no learned part, no found phase and no
/// override came since.
fn plan_unless(planned: Option<AnyPrepared>, job: AnyJob) -> Option<AnyPrepared> {
    let (hash, machine) = match &job {
        AnyJob::Ground(job) => (&job.hash, &job.machine.description),
        AnyJob::Turned(job) => (&job.hash, &job.machine.description),
        AnyJob::Milled(_) => return None,
    };
    let known = planned.filter(|known| known.job_hash() == hash && known.machine() == machine);
    known.or_else(|| planning::plan_any(job, None).ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn owned(overrides: &[&str]) -> Vec<String> {
        overrides.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn what_was_planned_at_the_start_is_taken_for_the_same_job_on_the_same_machine_and_for_no_other() {
        let read = |overrides: &[&str]| match any_job::load("eccentric", &owned(overrides)) {
            Ok(AnyJob::Ground(job)) => job,
            other => panic!("{other:?} is not ground"),
        };
        let mut known = planning::plan_any(AnyJob::Ground(read(&[])), None).unwrap();
        // Marks the plan of the start.
        let AnyPrepared::Ground(marked) = &mut known else { panic!("it is ground") };
        marked.pages.clear();
        let is_taken = |job: Box<Job>| {
            let prepared = plan_unless(Some(known.clone()), AnyJob::Ground(job)).unwrap();
            prepared.first_pages().is_empty()
        };
        let on = |overrides: &[&str]| {
            let mut job = read(&[]);
            job.machine = job.machine.with_overrides(&owned(overrides)).unwrap();
            job
        };
        assert!(is_taken(on(&[])));
        assert!(!is_taken(on(&["x_axis.drive.kv_1_s=150"])), "another machine");
        assert!(!is_taken(read(&["infeed.spark_out_turns=6"])), "another job");
    }
}
