//! The node `axis_interpolator`: the motion in execution, homing, feed hold, override, and who has command.

mod engine;
mod engine_messages;
mod goals;
mod plans;
mod pump;
mod setup_goals;
mod trajectory_goal;

use crate::config::machine_file;
use crate::convert::time::{TickClock, ns_from_time};
use crate::cyclic::{Sender, Waker, ring};
use crate::machine_sim::input_named;
use crate::ros::{
    ActionHandler, ActionServer, Diagnostics, GoalDecision, GoalHandle, GoalId, Lifecycle, LifecycleCallbacks, Node,
    NodeOptions, Qos, RosArgs, ServiceHandle, SpinThread, Subscription, diagnostic_status,
};
use crate::running::{NodeError, Threads, autostart};
use camwright::interpolator::{Motion, Prepared, Request};
use camwright::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use camwright::setpoint::Latch;
use camwright_msgs::camwright_msgs::action::{ExecutePlan, ExecutePlanGoal, Home, HomeGoal, MoveTo, Probe};
use camwright_msgs::camwright_msgs::msg::{
    Latch as LatchMessage, MachineDescription as DescriptionMessage, MachineStream, PlanPage,
};
use camwright_msgs::camwright_msgs::srv::{FeedHold, FeedHoldResponse, SetOverride, SetOverrideResponse};
use camwright_msgs::control_msgs::action::FollowJointTrajectory;
use camwright_msgs::diagnostic_msgs::msg::DiagnosticStatus;
use engine::Engine;
use engine_messages::{JobEnds, News, ToEngine};
use goals::{Goal, Served};
use plans::Plans;
use pump::{Outlets, Pump};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How long a cancelled motion may take to come to rest when the node ends.
const STOPPING: Duration = Duration::from_secs(10);
/// Messages that may wait between the threads.
const RING: usize = 4096;

/// A running `axis_interpolator`.
#[derive(Debug)]
pub struct AxisInterpolator {
    node: Node,
    lifecycle: Lifecycle,
    shared: Arc<Shared>,
    _subscriptions: Vec<Subscription>,
    _services: Vec<ServiceHandle>,
    _spin: SpinThread,
    _actions: Actions,
    _diagnostics: Diagnostics,
}

#[derive(Debug)]
struct Actions {
    _plan: ActionServer<ExecutePlan>,
    _home: ActionServer<Home>,
    _trajectory: ActionServer<FollowJointTrajectory>,
    _move: ActionServer<MoveTo>,
    _probe: ActionServer<Probe>,
}

/// What the callbacks of the executor thread and the pump share.
#[derive(Debug)]
struct Shared {
    node: Node,
    active: AtomicBool,
    stop: Arc<AtomicBool>,
    served: Arc<Mutex<Served>>,
    clock: Arc<Mutex<Option<TickClock>>>,
    /// The machine and the way into its engine; nothing before the machine has said what it is.
    cell: Mutex<Option<Cell>>,
    plans: Mutex<Plans>,
    rest_counts: Mutex<[i64; AXIS_COUNT]>,
}

/// What exists once the machine is known.
#[derive(Debug)]
struct Cell {
    machine: MachineDescription,
    inlet: Inlet,
    threads: Threads,
    waker: Waker,
}

/// The way into the engine.
#[derive(Debug, Clone)]
struct Inlet(Arc<Mutex<Sender<ToEngine>>>);

impl Inlet {
    fn send(&self, message: ToEngine) -> bool {
        lock(&self.0).send(message).is_ok()
    }
}

/// Locks a mutex whose value stays sound whatever a panicking holder did.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl AxisInterpolator {
    /// Starts the node.
    ///
    /// # Errors
    /// DDS that cannot start.
    pub fn start(args: &RosArgs) -> Result<Self, NodeError> {
        let node = Node::new(NodeOptions::new("axis_interpolator", args).parameter(autostart::parameter()))?;
        let shared = Arc::new(Shared {
            node: node.clone(),
            active: AtomicBool::new(false),
            stop: Arc::new(AtomicBool::new(false)),
            served: Arc::default(),
            clock: Arc::default(),
            cell: Mutex::default(),
            plans: Mutex::default(),
            rest_counts: Mutex::new([0; AXIS_COUNT]),
        });
        let subscriptions = subscriptions(&shared)?;
        let services = services(&shared)?;
        let trajectory = trajectory_goal::Handler(Arc::clone(&shared));
        let actions = Actions {
            _plan: node.action_server("~/execute_plan", PlanHandler(Arc::clone(&shared)))?,
            _home: node.action_server("~/home", HomeHandler(Arc::clone(&shared)))?,
            _trajectory: node.action_server("~/follow_joint_trajectory", trajectory)?,
            _move: node.action_server("~/move_to", setup_goals::MoveHandler(Arc::clone(&shared)))?,
            _probe: node.action_server("~/probe", setup_goals::ProbeHandler(Arc::clone(&shared)))?,
        };
        let lifecycle = node.lifecycle(Activation(Arc::clone(&shared)))?;
        let this = Arc::clone(&shared);
        let diagnostics = node.diagnostics("axis_interpolator", move || vec![this.health()])?;
        let spin = node.spin_in_thread()?;
        autostart::begin(&node, &lifecycle);
        Ok(Self {
            node,
            lifecycle,
            shared,
            _subscriptions: subscriptions,
            _services: services,
            _spin: spin,
            _actions: actions,
            _diagnostics: diagnostics,
        })
    }

    /// The node.
    #[must_use]
    pub fn node(&self) -> &Node {
        &self.node
    }

    /// Its life cycle.
    pub fn lifecycle(&self) -> &Lifecycle {
        &self.lifecycle
    }

    /// Whether the machine has said what it is.
    #[must_use]
    pub fn knows_machine(&self) -> bool {
        lock(&self.shared.cell).is_some() && lock(&self.shared.clock).is_some()
    }

    /// Cancels what is under way, waits until the axes are at rest, then ends the engine and the node. If the machine does
    /// not answer, what is under way ends in the stop of its last chunk.
    pub fn stop(self) {
        if lock(&self.shared.served).is_busy() {
            self.shared.request(Request::Cancel);
        }
        let latest = Instant::now() + STOPPING;
        while lock(&self.shared.served).is_busy() && Instant::now() < latest {
            // The pump ends the goal on its own thread and wakes nobody here.
            std::thread::sleep(Duration::from_millis(10));
        }
        self.shared.stop.store(true, Ordering::Release);
        let cell = lock(&self.shared.cell).take();
        if let Some(cell) = cell {
            cell.waker.wake();
            drop(cell.inlet);
            cell.threads.join();
        }
        self.node.shutdown();
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
        self.0.request(Request::Cancel);
        Ok(())
    }
    fn shutdown(&mut self) -> Result<(), String> {
        self.deactivate()
    }
}

impl Shared {
    /// Takes the machine's description: the first one starts the engine.
    fn meet(self: &Arc<Self>, message: &DescriptionMessage) {
        let mut cell = lock(&self.cell);
        if let Some(known) = cell.as_ref() {
            if known.machine.hash != message.hash {
                self.node.logger().error("the machine has become another one; restart this node");
            }
            return;
        }
        let machine = match machine_file::parse(Path::new("machine/description"), &message.source, &[]) {
            Ok(file) if file.description.hash == message.hash => file.description,
            Ok(_) => return self.node.logger().error("the machine's description does not have its hash"),
            Err(error) => return self.node.logger().error(&error.to_string()),
        };
        match self.start_engine(&machine) {
            Ok(started) => *cell = Some(started),
            Err(error) => self.node.logger().error(&format!("the engine cannot start: {error}")),
        }
    }

    fn start_engine(self: &Arc<Self>, machine: &MachineDescription) -> Result<Cell, NodeError> {
        let waker = Waker::default();
        let pump_waker = Waker::default();
        let (inlet, inbox) = ring(RING, &waker);
        let (outbox, reports) = ring(RING, &pump_waker);
        let inlet = Inlet(Arc::new(Mutex::new(inlet)));
        let engine = Engine::new(machine, inbox, outbox, Arc::clone(&self.stop));
        let pump = Pump {
            node: self.node.clone(),
            machine: machine.clone(),
            clock: Arc::clone(&self.clock),
            outlets: Outlets::new(&self.node)?,
            served: Arc::clone(&self.served),
            order: 0,
            order_tick: 0,
            alarms: None,
        };
        let mut threads = Threads::default();
        let engine_waker = waker.clone();
        threads.spawn("interpolator cycle", move || engine.run(&engine_waker))?;
        let back = inlet.clone();
        threads.spawn("interpolator pump", move || {
            pump.run(reports, &pump_waker, move |message| {
                back.send(message);
            });
        })?;
        Ok(Cell { machine: machine.clone(), inlet, threads, waker })
    }

    fn hear(&self, message: &MachineStream) {
        let cell = lock(&self.cell);
        let Some(cell) = cell.as_ref() else { return };
        let clock = TickClock { epoch_ns: ns_from_time(&message.epoch), cycle_time_ns: cell.machine.cycle_time_ns };
        *lock(&self.clock) = Some(clock);
        let mut counts = [0; AXIS_COUNT];
        for (place, value) in counts.iter_mut().zip(&message.setpoint_counts) {
            *place = *value;
        }
        *lock(&self.rest_counts) = counts;
        cell.inlet.send(ToEngine::News(Box::new(News {
            tick: message.tick,
            credit_tick: message.credit_tick,
            is_standstill: message.motion == MachineStream::MOTION_STANDSTILL
                || message.motion == MachineStream::MOTION_FAULT
                || message.motion == MachineStream::MOTION_OFF,
            commands_received: message.commands_received,
            alarms: message.alarms.clone(),
            setpoint_counts: counts,
            latches: message.latches.iter().filter_map(|latch| core_latch(latch, &cell.machine)).collect(),
        })));
    }

    fn request(&self, request: Request) -> bool {
        lock(&self.cell).as_ref().is_some_and(|cell| cell.inlet.send(ToEngine::Request(request)))
    }

    /// Why no motion can begin now.
    fn obstacle(&self) -> Option<String> {
        if !self.active.load(Ordering::Acquire) {
            return Some("the node is not active".into());
        }
        let served = lock(&self.served);
        if served.is_busy() {
            return Some(format!("{} has command", served.names().0));
        }
        if lock(&self.cell).is_none() || lock(&self.clock).is_none() {
            return Some("the machine has not been heard of yet".into());
        }
        None
    }

    /// Starts a motion for the goal that has command.
    fn begin(&self, motion: Motion) {
        let job = JobEnds::of(&motion);
        let sent = match lock(&self.cell).as_ref() {
            None => Err("the machine has not been heard of yet".to_owned()),
            Some(cell) => match Prepared::new(motion, &cell.machine) {
                Ok(prepared) => match cell.inlet.send(ToEngine::Start { motion: Box::new(prepared), job }) {
                    true => Ok(()),
                    false => Err("the engine does not take anything any more".into()),
                },
                Err(error) => Err(error.to_string()),
            },
        };
        if let Err(reason) = sent {
            lock(&self.served).refuse(&reason);
        }
    }

    /// One status: who has command, and whether the machine is heard.
    fn health(&self) -> DiagnosticStatus {
        let (holder, plan) = lock(&self.served).names();
        let (level, message) = match (lock(&self.clock).is_some(), holder.is_empty()) {
            (false, _) => (DiagnosticStatus::WARN, "the machine has not been heard of yet".to_owned()),
            (true, true) => (DiagnosticStatus::OK, "idle".to_owned()),
            (true, false) => (DiagnosticStatus::OK, format!("{holder} has command")),
        };
        diagnostic_status(level, "", &message, &[("plan", plan)])
    }

    fn machine(&self) -> Option<MachineDescription> {
        lock(&self.cell).as_ref().map(|cell| cell.machine.clone())
    }

    /// Starts the plan that has command as soon as all of its pages are here.
    fn begin_plan(&self) {
        let hash = match lock(&self.plans).waiting() {
            Some(hash) => hash,
            None => return,
        };
        let Some(machine) = self.machine() else { return };
        let outcome = lock(&self.plans).take(&hash, &machine);
        match outcome {
            Ok(Some(plan)) => self.begin(Motion::Plan(plan)),
            Ok(None) => {}
            Err(reason) => lock(&self.served).refuse(&reason),
        }
    }
}

fn core_latch(message: &LatchMessage, machine: &MachineDescription) -> Option<Latch> {
    let input = input_named(&message.input, machine)?;
    let axis = Axis::from_joint(&message.joint)?;
    Some(Latch { tick: message.tick, input, rising: message.rising, axis, counts: message.counts })
}

fn subscriptions(shared: &Arc<Shared>) -> Result<Vec<Subscription>, NodeError> {
    let node = &shared.node;
    let this = Arc::clone(shared);
    let description =
        node.subscribe::<DescriptionMessage>("machine/description", &Qos::latched(1), move |message, _| {
            this.meet(&message);
        })?;
    let this = Arc::clone(shared);
    let qos = Qos::default_topic().keep_last(1000);
    let stream = node.subscribe::<MachineStream>("machine/stream", &qos, move |message, _| this.hear(&message))?;
    let this = Arc::clone(shared);
    let pages = node.subscribe::<PlanPage>("job_planner/plan", &Qos::latched(256), move |page, _| {
        lock(&this.plans).add(page);
        this.begin_plan();
    })?;
    let topic = trajectory_goal::subscribe(shared)?;
    Ok(vec![description, stream, pages, topic])
}

fn services(shared: &Arc<Shared>) -> Result<Vec<ServiceHandle>, NodeError> {
    let this = Arc::clone(shared);
    let hold = shared.node.service::<FeedHold>("~/feed_hold", move |request| {
        let success =
            lock(&this.served).is_busy() && this.request(if request.hold { Request::Hold } else { Request::Unhold });
        let message = if success { "" } else { "nothing is being executed" };
        FeedHoldResponse { success, message: message.to_owned() }
    })?;
    let this = Arc::clone(shared);
    let feed_override = shared.node.service::<SetOverride>("~/set_override", move |request| {
        let value = request.feed_override;
        if !(0.0..=1.0).contains(&value) {
            return SetOverrideResponse { success: false, message: format!("override {value}, allowed is 0 to 1") };
        }
        let success = this.request(Request::SetOverride(value));
        let message = if success { "" } else { "the machine has not been heard of yet" };
        SetOverrideResponse { success, message: message.to_owned() }
    })?;
    Ok(vec![hold, feed_override])
}

/// Serves `~/execute_plan`.
#[derive(Debug)]
struct PlanHandler(Arc<Shared>);

impl ActionHandler<ExecutePlan> for PlanHandler {
    fn goal(&mut self, _id: GoalId, goal: &ExecutePlanGoal) -> GoalDecision {
        match self.0.obstacle() {
            Some(reason) => GoalDecision::Reject(reason),
            None if goal.plan_hash.is_empty() => GoalDecision::Reject("the goal names no plan".into()),
            None => GoalDecision::Accept,
        }
    }

    fn accepted(&mut self, handle: GoalHandle<ExecutePlan>) {
        let hash = handle.goal().plan_hash.clone();
        let name = match handle.goal().client.as_str() {
            "" => format!("plan {}", short(&hash)),
            client => format!("plan {} of {client}", short(&hash)),
        };
        lock(&self.0.served).begin(Goal::Plan(handle), name, hash.clone());
        lock(&self.0.plans).wait_for(hash);
        self.0.begin_plan();
    }

    fn cancel(&mut self, _id: GoalId) -> bool {
        if lock(&self.0.plans).waiting().is_some() {
            lock(&self.0.plans).forget_waiting();
            lock(&self.0.served).refuse("cancelled before its plan was complete");
            return true;
        }
        self.0.request(Request::Cancel)
    }
}

fn short(hash: &str) -> &str {
    hash.get(..8).unwrap_or(hash)
}

/// Serves `~/home`.
#[derive(Debug)]
struct HomeHandler(Arc<Shared>);

impl ActionHandler<Home> for HomeHandler {
    fn goal(&mut self, _id: GoalId, goal: &HomeGoal) -> GoalDecision {
        if let Some(joint) = goal.joints.iter().find(|joint| Axis::from_joint(joint).is_none()) {
            return GoalDecision::Reject(format!("there is no joint {joint:?}"));
        }
        self.0.obstacle().map_or(GoalDecision::Accept, GoalDecision::Reject)
    }

    fn accepted(&mut self, handle: GoalHandle<Home>) {
        let mut axes: Vec<Axis> = handle.goal().joints.iter().filter_map(|joint| Axis::from_joint(joint)).collect();
        if axes.is_empty() {
            let needs = |axis: &Axis| self.0.machine().is_some_and(|machine| machine.axis(*axis).needs_homing);
            axes = Axis::ALL.into_iter().filter(needs).collect();
        }
        lock(&self.0.served).begin(Goal::Home(handle), "homing".into(), String::new());
        self.0.begin(Motion::Home(axes));
    }

    fn cancel(&mut self, _id: GoalId) -> bool {
        self.0.request(Request::Cancel)
    }
}
