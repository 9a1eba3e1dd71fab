// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The node `job_planner`: jobs, plans, the sequence of a job, results.
//!
//! The executor thread only takes requests and answers. Files are read and jobs planned on a worker thread; a job that
//! runs has a thread of its own, which loads the blanks, hands the plan to the axis interpolator, and measures the part.

mod cell;
mod deferred;
mod execution;
mod gauged_run;
mod gaugings;
mod grinding_run;
mod identify;
mod job_request;
mod job_slot;
mod learned;
mod loading;
mod lobe_forms;
mod lobe_ticks;
mod partners;
pub mod parts;
mod plan_progress;
mod plan_publisher;
mod preview;
mod request_origin;
mod services;
mod settings;
mod setup;
mod stiffness;
mod turned_parts;
mod turning_run;

use camwright_authority::{Grant, Membership, Role, subscribe_to_machine};
use camwright_files::convert::machine_now::MachineNow;
use camwright_machine_cycle::part::MAX_PAGES;
use camwright_msgs::camwright_msgs::action::{ExecutePlan, RunJob};
use camwright_msgs::camwright_msgs::msg::{
    Alarm, FormMap, GaugeReading, MachineAlarms, MachineDescription as DescriptionMessage, PartLobe, PlanPage,
    TurnedPage,
};
use camwright_msgs::camwright_msgs::srv::{InjectFault, LoadBar, LoadLobe};
use camwright_msgs::diagnostic_msgs::msg::DiagnosticStatus;
use camwright_planning::AnyPrepared;
use camwright_ros::liveness;
use camwright_ros::running::{NodeError, autostart, join_within};
use camwright_ros::{
    ActionClient, ActionServer, Client, Diagnostics, Farewell, Lifecycle, LifecycleCallbacks, Node, NodeOptions,
    Publisher, Qos, RosArgs, ServiceHandle, SpinThread, Subscription, diagnostic_status,
};
use camwright_scene as scene;
use camwright_threads::supervised::injected;
use cell::{CellEvent, CellInterface};
use gaugings::Gaugings;
use job_request::{LoadedJob, RunHandler};
use job_slot::JobSlot;
use learned::LearnedStore;
use lobe_forms::LobeForms;
use parts::Parts;
use plan_publisher::PlanPublisher;
use setup::Setup;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use stiffness::StiffnessStore;
use turned_parts::TurnedParts;

/// Pages of plans that a late joiner still gets: some ten plans.
const PLAN_DEPTH: u32 = 256;

/// Lobes of a part that may come at once.
const MAX_LOBES: u32 = 32;
/// Readings of the gauge that may wait for this node: two seconds of them.
const GAUGE_DEPTH: u32 = 2000;

/// Maximum time for coming to rest when the node ends within a larger program.
const STOPPING: Duration = Duration::from_secs(60);
/// Maximum time for the end of the cell's thread.
const LAST_WORD: Duration = Duration::from_millis(200);

/// A running `job_planner`.
#[derive(Debug)]
pub struct JobPlanner {
    node: Node,
    lifecycle: Lifecycle,
    shared: Arc<Shared>,
    worker: Option<JoinHandle<Option<()>>>,
    _subscriptions: Vec<Subscription>,
    _services: Vec<ServiceHandle>,
    _action: ActionServer<RunJob>,
    _diagnostics: Diagnostics,
    _spin: SpinThread,
    _membership: Membership,
}

/// Longest wait for a partner of the cell before a job is rejected.
const MEETING: Duration = Duration::from_secs(5);
const NO_MACHINE: &str = "no machine description received (topic machine/description); check that the machine runs";

/// A piece of work for the planning thread.
type Work = Box<dyn FnOnce() + Send>;

/// State shared by callbacks, the planning thread and a running job.
#[derive(Debug)]
struct Shared {
    node: Node,
    active: AtomicBool,
    /// The machine as it last described itself.
    machine: Mutex<Option<MachineNow>>,
    /// The machine has described itself.
    described: Condvar,
    alarms: Mutex<Vec<Alarm>>,
    parts: Parts,
    turned_parts: TurnedParts,
    /// The cell as a unit of PackML.
    cell: CellInterface,
    gaugings: Gaugings,
    /// Learned corrections of each job.
    learned: LearnedStore,
    /// Stored stiffness of each machine.
    stiffness: StiffnessStore,
    board: PlanPublisher,
    /// The job that `load_job` planned last.
    loaded: Mutex<Option<LoadedJob>>,
    /// The last plan: the next part needs the same in most cases.
    known: Mutex<Option<AnyPrepared>>,
    /// The one job there can be.
    job_slot: Mutex<JobSlot>,
    /// The thread of the job that runs or ran last.
    run: Mutex<Option<JoinHandle<Option<()>>>>,
    /// The way to the planning thread; gone when the node ends.
    work: Mutex<Option<mpsc::Sender<Work>>>,
    plan: Publisher<PlanPage>,
    form_map: Publisher<FormMap>,
    lobe_forms: LobeForms,
    /// Set-up work, and what it found of the part.
    setup: Setup,
    load_lobe: Client<LoadLobe>,
    load_bar: Client<LoadBar>,
    inject_fault: Client<InjectFault>,
    execute: ActionClient<ExecutePlan>,
    interpolator: partners::InterpolatorPartner,
}

/// Locks a mutex whose value stays sound whatever a panicking holder did.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits until what a mutex guards gives what is wanted; what is in the way when time is over.
fn wait_for<T, R, E>(
    mutex: &Mutex<T>,
    changed: &Condvar,
    timeout: Duration,
    mut wanted: impl FnMut(&mut T) -> Result<R, E>,
) -> Result<R, E> {
    let end = Instant::now() + timeout;
    let mut guarded = lock(mutex);
    loop {
        let outcome = wanted(&mut guarded);
        let left = end.saturating_duration_since(Instant::now());
        if outcome.is_ok() || left.is_zero() {
            return outcome;
        }
        guarded = changed.wait_timeout(guarded, left).unwrap_or_else(PoisonError::into_inner).0;
    }
}

impl JobPlanner {
    /// Name and parameters of the node.
    #[must_use]
    pub fn options(args: &RosArgs) -> NodeOptions {
        let options = NodeOptions::new("job_planner", args).parameters(settings::parameters());
        options.parameter(autostart::parameter()).parameter(liveness::parameter()).parameter(scene::parameter())
    }

    /// Overrides with which a node with these arguments reads the job of a goal: those of its parameters, then those of the goal.
    ///
    /// # Errors
    /// Parameters that are refused, or do not fit the job.
    pub fn overrides_from_args(args: &RosArgs, job: &str, of_goal: &[String]) -> Result<Vec<String>, NodeError> {
        let parameters = Self::options(args).declared()?;
        settings::validate(&parameters, &parameters.all()).map_err(NodeError::Parameter)?;
        settings::check_against_job(&parameters, job, of_goal).map_err(NodeError::Parameter)?;
        Ok(settings::overrides(&parameters, of_goal))
    }

    /// Starts the node.
    ///
    /// # Errors
    /// Parameters that are refused, DDS that cannot start.
    pub fn start(args: &RosArgs) -> Result<Self, NodeError> {
        Self::start_with_plan(args, None)
    }

    /// The same; a known plan saves the time to plan the same job for the same machine.
    ///
    /// # Errors
    /// See [`JobPlanner::start`].
    pub fn start_with_plan(args: &RosArgs, known: Option<AnyPrepared>) -> Result<Self, NodeError> {
        let node = Node::new(Self::options(args))?;
        settings::validate(node.parameters(), &node.parameters().all()).map_err(NodeError::Parameter)?;
        node.parameters().on_set_together(settings::validate);
        let grant = Grant::new(&node)?;
        let (work, orders) = mpsc::channel::<Work>();
        let (cell, inbox) = CellInterface::new();
        let shared = Arc::new(Shared {
            active: AtomicBool::new(false),
            machine: Mutex::default(),
            described: Condvar::new(),
            alarms: Mutex::default(),
            parts: Parts::default(),
            turned_parts: TurnedParts::default(),
            gaugings: Gaugings::default(),
            learned: LearnedStore::new(&node.parameters().string(settings::LEARNED_DIR)),
            stiffness: StiffnessStore::new(&node.parameters().string(settings::LEARNED_DIR)),
            board: PlanPublisher::new(&node, cell.mailbox())?,
            cell,
            loaded: Mutex::default(),
            known: Mutex::new(known),
            job_slot: Mutex::default(),
            run: Mutex::default(),
            work: Mutex::new(Some(work)),
            plan: node.publisher("~/plan", &Qos::latched(PLAN_DEPTH))?,
            form_map: node.publisher("~/form_map", &Qos::latched(1))?,
            lobe_forms: LobeForms::new(&node)?,
            setup: Setup::new(&node)?,
            load_lobe: node.client("machine/load_lobe")?,
            load_bar: node.client("machine/load_bar")?,
            inject_fault: node.client("machine/inject_fault")?,
            execute: node.action_client("axis_interpolator/execute_plan")?,
            interpolator: partners::InterpolatorPartner::new(liveness::limit(&node)),
            node: node.clone(),
        });
        let this = Arc::downgrade(&shared);
        grant.on_refusal(move |service, reason| {
            if let Some(shared) = this.upgrade().filter(|_| service.ends_with("/run_job/_action/send_goal")) {
                shared.board.rejected(reason);
            }
        });
        let worker = node.supervisor().spawn("planning", move || {
            for order in orders {
                injected::point("planning");
                order();
            }
        })?;
        let mut subscriptions = subscriptions(&shared, &grant)?;
        subscriptions.extend(cell::subscriptions(&shared, &grant)?);
        cell::start(&shared, inbox)?;
        let mut services = services::offer(&shared)?;
        services.extend(setup::offer(&shared)?);
        services.extend(cell::offer(&shared)?);
        let action = node.action_server("~/run_job", RunHandler(Arc::clone(&shared)))?;
        let lifecycle = node.lifecycle(Activation(Arc::clone(&shared)))?;
        let this = Arc::clone(&shared);
        let diagnostics = node.diagnostics("job_planner", move || vec![this.health()])?;
        let this = Arc::downgrade(&shared);
        let is_busy = |shared: &Shared| !matches!(*lock(&shared.job_slot), JobSlot::Idle) || shared.cell.has_run();
        let busy = move || this.upgrade().is_some_and(|shared| is_busy(&shared));
        let membership = camwright_authority::join(&node, &grant, Role::Planner, busy)?;
        let spin = node.spin_in_thread()?;
        autostart::begin(&node, &lifecycle);
        Ok(Self {
            node,
            lifecycle,
            shared,
            worker: Some(worker),
            _subscriptions: subscriptions,
            _services: services,
            _action: action,
            _diagnostics: diagnostics,
            _spin: spin,
            _membership: membership,
        })
    }

    #[must_use]
    pub fn node(&self) -> &Node {
        &self.node
    }

    pub fn lifecycle(&self) -> &Lifecycle {
        &self.lifecycle
    }

    /// Returns whether the machine has published its description.
    #[must_use]
    pub fn knows_machine(&self) -> bool {
        lock(&self.shared.machine).is_some()
    }

    /// Brings a job that runs to rest, then ends the node.
    pub fn stop(self) -> Farewell {
        self.stop_within(STOPPING)
    }

    /// The same. What does not come to its end within `limit` is left behind: the interpolator brings a cancelled job to rest by itself,
    /// and a plan that is being computed is of no use any more.
    pub fn stop_within(mut self, limit: Duration) -> Farewell {
        let end = Instant::now() + limit;
        let left = || end.saturating_duration_since(Instant::now());
        self.shared.active.store(false, Ordering::Release);
        self.shared.cancel();
        drop(lock(&self.shared.work).take());
        let run = lock(&self.shared.run).take();
        if let Some(run) = run
            && !join_within(run, left())
        {
            self.node.logger().warn("the node ends before its job: the axis interpolator brings the axes to rest");
        }
        if let Some(worker) = self.worker.take()
            && !join_within(worker, left())
        {
            self.node.logger().warn("the node ends before its plan is made");
        }
        self.shared.cancel();
        // A job that the planning thread has just begun.
        let run = lock(&self.shared.run).take();
        if let Some(run) = run {
            join_within(run, left());
        }
        self.shared.cell.end(left().max(LAST_WORD));
        self.node.leave()
    }
}

#[derive(Debug)]
struct Activation(Arc<Shared>);

impl LifecycleCallbacks for Activation {
    fn activate(&mut self) -> Result<(), String> {
        self.0.active.store(true, Ordering::Release);
        Ok(())
    }
    fn deactivate(&mut self) -> Result<(), String> {
        self.0.active.store(false, Ordering::Release);
        self.0.cancel();
        Ok(())
    }
    fn shutdown(&mut self) -> Result<(), String> {
        self.deactivate()
    }
}

impl Shared {
    /// Takes the machine's description: what it is, and its wheels.
    fn meet(&self, message: &DescriptionMessage) {
        match MachineNow::from_message(message) {
            Ok(now) => {
                *lock(&self.machine) = Some(now);
                self.described.notify_all();
            }
            Err(reason) => self.node.logger().error(&reason),
        }
    }

    /// Returns the machine, and waits for its description: on a bad network it may come after the first goal.
    fn met_machine(&self) -> Result<MachineNow, String> {
        let machine = lock(&self.machine);
        let met = self.described.wait_timeout_while(machine, MEETING, |machine| machine.is_none());
        let (machine, _) = met.unwrap_or_else(PoisonError::into_inner);
        machine.clone().ok_or_else(|| NO_MACHINE.to_owned())
    }

    /// Gives work to the planning thread; false when the node is ending.
    fn order(&self, work: impl FnOnce() + Send + 'static) -> bool {
        lock(&self.work).as_ref().is_some_and(|orders| orders.send(Box::new(work)).is_ok())
    }

    /// One status: whether it works, whether the machine is known, what runs.
    fn health(&self) -> DiagnosticStatus {
        let course = lock(&self.job_slot).to_string();
        let (level, message) = if !self.active.load(Ordering::Acquire) {
            (DiagnosticStatus::OK, "not active".to_owned())
        } else if lock(&self.machine).is_none() {
            (DiagnosticStatus::WARN, "no message from the machine yet".to_owned())
        } else {
            (DiagnosticStatus::OK, course)
        };
        let loaded = lock(&self.loaded).as_ref().map_or_else(String::new, |loaded| loaded.name.clone());
        diagnostic_status(level, "", &message, &[("loaded", loaded)])
    }
}

fn subscriptions(shared: &Arc<Shared>, grant: &Arc<Grant>) -> Result<Vec<Subscription>, NodeError> {
    let (node, latched) = (&shared.node, &Qos::latched(1));
    let this = Arc::clone(shared);
    let description = subscribe_to_machine::<DescriptionMessage>(
        node,
        grant,
        "machine/description",
        (latched, 1),
        move |message, _| {
            this.meet(&message);
        },
    )?;
    let this = Arc::clone(shared);
    let lobes = &Qos::latched(MAX_LOBES);
    let part =
        subscribe_to_machine::<PartLobe>(node, grant, "machine/part", (lobes, MAX_LOBES as usize), move |lobe, _| {
            this.parts.add(lobe);
        })?;
    let this = Arc::clone(shared);
    let pages = (&Qos::latched(MAX_PAGES), MAX_PAGES as usize);
    let turned = subscribe_to_machine::<TurnedPage>(node, grant, "machine/turned_part", pages, move |page, _| {
        this.turned_parts.receive_page(&page);
    })?;
    let this = Arc::clone(shared);
    let alarms =
        subscribe_to_machine::<MachineAlarms>(node, grant, "machine/alarms", (latched, 1), move |message, _| {
            *lock(&this.alarms) = message.alarms;
            this.cell.send(CellEvent::Alarms);
        })?;
    let this = Arc::clone(shared);
    let every = &Qos::default_topic().keep_last(GAUGE_DEPTH);
    let gauge = subscribe_to_machine::<GaugeReading>(node, grant, "machine/gauge", (every, 0), move |reading, _| {
        this.gaugings.add(&reading);
    })?;
    Ok(vec![description, part, turned, alarms, gauge])
}
