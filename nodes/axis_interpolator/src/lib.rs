// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The node `axis_interpolator`: the motion in execution, homing, feed hold, override, and who has command.

mod engine;
mod engine_messages;
mod goal_end;
mod goals;
mod health;
mod joint_trajectory;
mod manual;
mod next_trajectory;
mod partners;
mod plan_goal;
mod plans;
mod pump;
mod receipts;
mod setup_goals;
mod trajectory_replacement;

use camwright::interpolator::MotionRequest;
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use camwright::machine::setpoint::{Latch, Measured};
use camwright::motion::plan::Plan;
use camwright_authority::{Grant, Membership, Role, subscribe_to_machine};
use camwright_files::convert::core_from_si;
use camwright_files::convert::machine_now::MachineNow;
use camwright_files::convert::machine_report::input_named;
use camwright_files::convert::motion_record::MotionRecord;
use camwright_files::convert::time::{TickClock, ns_from_time};
use camwright_msgs::camwright_msgs::action::{ExecutePlan, Home, Jog, MoveTo, Probe};
use camwright_msgs::camwright_msgs::msg::{
    CellState, Latch as LatchMessage, MachineDescription as DescriptionMessage, MachineStream, PlanPage, WorkArea,
};
use camwright_msgs::camwright_msgs::srv::{SetOverride, SetOverrideResponse};
use camwright_msgs::control_msgs::action::FollowJointTrajectory;
use camwright_msgs::control_msgs::srv::{QueryTrajectoryState, QueryTrajectoryStateResponse};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolResponse};
use camwright_ros::liveness;
use camwright_ros::realtime::{self, Realtime};
use camwright_ros::running::{NodeError, Threads, autostart};
use camwright_ros::{
    ActionServer, Diagnostics, Farewell, GoalDecision, Guid, Lifecycle, LifecycleCallbacks, Node, NodeOptions, Qos,
    Responder, RosArgs, ServiceHandle, SpinThread, Subscription, TimerHandle,
};
use camwright_threads::drops::DropCounter;
use camwright_threads::ring::{Sender, Waker, ring};
use camwright_threads::silence::LOOK;
use engine::Engine;
use engine_messages::{JobEnds, MachineFeedback, PreparedMotion, ToEngine};
use goals::ActiveGoal;
use health::MachineHealth;
use joint_trajectory::arrival::TrajectoryArrival;
use manual::HeldJog;
use plans::Plans;
use pump::EnginePump;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU16, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Longest time for a cancelled motion to come to rest when the node ends within a larger program.
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
    _look: TimerHandle,
    _membership: Membership,
}

#[derive(Debug)]
struct Actions {
    _plan: ActionServer<ExecutePlan>,
    _home: ActionServer<Home>,
    _trajectory: ActionServer<FollowJointTrajectory>,
    _move: ActionServer<MoveTo>,
    _probe: ActionServer<Probe>,
    _jog: ActionServer<Jog>,
}

/// State shared by the callbacks of the executor thread and the pump.
#[derive(Debug)]
struct Shared {
    node: Node,
    active: AtomicBool,
    stop: Arc<AtomicBool>,
    /// Decides who may ask for motion.
    grant: Arc<Grant>,
    served: Arc<Mutex<ActiveGoal>>,
    clock: Arc<Mutex<Option<TickClock>>>,
    /// The machine and the way into its engine; nothing before the machine has said what it is.
    cell: Mutex<Option<MachineConnection>>,
    plans: Mutex<Plans>,
    rest_counts: Mutex<[i64; AXIS_COUNT]>,
    /// Which axes know their zero.
    homed: Mutex<[bool; AXIS_COUNT]>,
    /// A jog with hold-to-run.
    held: Mutex<Option<HeldJog>>,
    /// Condition of door, chuck or work area that prevents axes and wheel from starting; empty: none.
    hindrance: Mutex<String>,
    /// Alarm of the machine that stops every motion until its reset; 0: none.
    stopping_alarm: AtomicU16,
    /// The machine's last tick that was received of.
    tick: AtomicU64,
    machine_health: Mutex<MachineHealth>,
    partners: Mutex<partners::InterpolatorPartners>,
    /// Telemetry that was dropped.
    drops: DropCounter,
    /// A trajectory that takes the place of the one in execution, or begins after it.
    arrival: Mutex<Option<TrajectoryArrival>>,
    /// Who asked `~/query_state`, in the order of asking.
    queries: Mutex<VecDeque<Responder<QueryTrajectoryState>>>,
}

/// State that exists once the machine is known.
#[derive(Debug)]
struct MachineConnection {
    machine: MachineDescription,
    inlet: EngineInlet,
    threads: Threads,
    waker: Waker,
}

/// The way into the engine.
#[derive(Debug, Clone)]
struct EngineInlet(Arc<Mutex<Sender<ToEngine>>>);

impl EngineInlet {
    fn send(&self, message: ToEngine) -> bool {
        lock(&self.0).send(message).is_ok()
    }
}

/// Locks a mutex whose value stays sound whatever a panicking holder did.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl AxisInterpolator {
    /// Name and parameters of the node.
    #[must_use]
    pub fn options(args: &RosArgs) -> NodeOptions {
        let options = NodeOptions::new("axis_interpolator", args).parameter(autostart::parameter());
        let options = options.parameter(liveness::parameter());
        options.parameters(joint_trajectory::settings::parameters()).parameters(realtime::parameters())
    }

    /// Starts the node.
    ///
    /// # Errors
    /// DDS that cannot start.
    pub fn start(args: &RosArgs) -> Result<Self, NodeError> {
        realtime::start_with_priority(Self::options(args), true, Self::start_node)
    }

    fn start_node(options: NodeOptions) -> Result<Self, NodeError> {
        let node = Node::new(options)?;
        let shared = Arc::new(Shared {
            node: node.clone(),
            active: AtomicBool::new(false),
            stop: Arc::new(AtomicBool::new(false)),
            grant: Grant::new(&node)?,
            served: Arc::default(),
            clock: Arc::default(),
            cell: Mutex::default(),
            plans: Mutex::default(),
            rest_counts: Mutex::new([0; AXIS_COUNT]),
            homed: Mutex::default(),
            held: Mutex::default(),
            hindrance: Mutex::default(),
            stopping_alarm: AtomicU16::new(0),
            tick: AtomicU64::new(0),
            machine_health: Mutex::default(),
            partners: Mutex::new(partners::InterpolatorPartners::new(liveness::limit(&node))),
            drops: DropCounter::default(),
            arrival: Mutex::default(),
            queries: Mutex::default(),
        });
        let subscriptions = subscriptions(&shared)?;
        let services = services(&shared)?;
        let trajectory = joint_trajectory::Handler(Arc::clone(&shared));
        let actions = Actions {
            _plan: node.action_server("~/execute_plan", plan_goal::PlanHandler(Arc::clone(&shared)))?,
            _jog: node.action_server("~/jog", manual::JogHandler(Arc::clone(&shared)))?,
            _home: node.action_server("~/home", setup_goals::HomeHandler(Arc::clone(&shared)))?,
            _trajectory: node.action_server_with_trailing_zeros(
                "~/follow_joint_trajectory",
                joint_trajectory::FEEDBACK_TRAILING_ZEROS,
                trajectory,
            )?,
            _move: node.action_server("~/move_to", setup_goals::MoveHandler(Arc::clone(&shared)))?,
            _probe: node.action_server("~/probe", setup_goals::ProbeHandler(Arc::clone(&shared)))?,
        };
        let lifecycle = node.lifecycle(Activation(Arc::clone(&shared)))?;
        let this = Arc::clone(&shared);
        let diagnostics = node.diagnostics("axis_interpolator", move || this.health())?;
        let this = Arc::downgrade(&shared);
        let look = node.timer(LOOK, move || {
            if let Some(shared) = this.upgrade() {
                shared.check_partners();
            }
        });
        let this = Arc::downgrade(&shared);
        let busy = move || this.upgrade().is_some_and(|shared| lock(&shared.served).is_busy());
        let membership = camwright_authority::join(&node, &shared.grant, Role::Interpolator, busy)?;
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
            _look: look,
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
        lock(&self.shared.cell).is_some() && lock(&self.shared.clock).is_some()
    }

    /// Cancels what is under way, waits until the axes are at rest, then ends the engine and the node. If the machine does
    /// not answer, what is under way ends in the stop of its last chunk.
    pub fn stop(self) -> Farewell {
        self.stop_within(STOPPING)
    }

    /// The same; axes that do not rest within `limit` come to rest on the stop of what was sent.
    pub fn stop_within(self, limit: Duration) -> Farewell {
        self.shared.refuse_arrival("the node is ending");
        if lock(&self.shared.served).is_busy() {
            lock(&self.shared.served).end_because("the node is ending: the axes came to rest on the path");
            self.shared.request(MotionRequest::Cancel);
        }
        let latest = Instant::now() + limit;
        while lock(&self.shared.served).is_busy() && Instant::now() < latest {
            // The pump ends the goal on its own thread and wakes no thread here.
            std::thread::sleep(Duration::from_millis(10));
        }
        self.shared.stop.store(true, Ordering::Release);
        let cell = lock(&self.shared.cell).take();
        if let Some(cell) = cell {
            cell.waker.wake();
            drop(cell.inlet);
            cell.threads.join();
        }
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
        self.0.refuse_arrival("the node is being deactivated");
        lock(&self.0.served).end_because("the node was deactivated: the axes came to rest on the path");
        self.0.request(MotionRequest::Cancel);
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
        if self.stop.load(Ordering::Acquire) {
            // The engine has ended; a machine describes itself again when its wheel has worn.
            return;
        }
        if let Some(known) = cell.as_ref() {
            if known.machine.hash != message.hash {
                self.node.logger().error("the machine has become another one; restart this node");
            }
            return;
        }
        let machine = match MachineNow::from_message(message) {
            Ok(now) => now.description,
            Err(reason) => return self.node.logger().error(&reason),
        };
        match self.start_engine(&machine) {
            Ok(started) => *cell = Some(started),
            Err(error) => self.node.logger().error(&format!("the engine cannot start: {error}")),
        }
    }

    fn start_engine(self: &Arc<Self>, machine: &MachineDescription) -> Result<MachineConnection, NodeError> {
        let waker = Waker::default();
        let pump_waker = Waker::default();
        let (inlet, inbox) = ring(RING, &waker);
        let (outbox, reports) = ring(RING, &pump_waker);
        let inlet = EngineInlet(Arc::new(Mutex::new(inlet)));
        let engine = Engine::new(machine, inbox, outbox, Arc::clone(&self.stop));
        let pump = EnginePump::new(self, machine)?;
        let mut threads = Threads::default();
        let engine_waker = waker.clone();
        let realtime = Realtime::for_node(&self.node)?;
        threads.spawn(&self.node, "interpolator cycle", move || {
            realtime.adopt_current_thread();
            engine.run(&engine_waker);
        })?;
        let back = inlet.clone();
        threads.spawn(&self.node, "interpolator pump", move || {
            pump.run(reports, &pump_waker, move |message| {
                back.send(message);
            });
        })?;
        Ok(MachineConnection { machine: machine.clone(), inlet, threads, waker })
    }

    fn receive(&self, message: &MachineStream, writer: Guid) {
        self.receive_machine(writer);
        let cell = lock(&self.cell);
        let Some(cell) = cell.as_ref() else { return };
        let clock = TickClock { epoch_ns: ns_from_time(&message.epoch), cycle_time_ns: cell.machine.cycle_time_ns };
        *lock(&self.clock) = Some(clock);
        let mut counts = [0; AXIS_COUNT];
        for (place, value) in counts.iter_mut().zip(&message.setpoint_counts) {
            *place = *value;
        }
        *lock(&self.rest_counts) = counts;
        lock(&self.machine_health).update(message, &cell.machine);
        let stopping = message.alarms.iter().copied().find(|number| engine::stops_motion(*number));
        self.stopping_alarm.store(stopping.unwrap_or(0), Ordering::Release);
        let is_new = self.tick.swap(message.tick, Ordering::AcqRel) < message.tick;
        cell.inlet.send(ToEngine::News(Box::new(MachineFeedback {
            tick: message.tick,
            credit_tick: message.credit_tick,
            is_standstill: message.motion == MachineStream::MOTION_STANDSTILL
                || message.motion == MachineStream::MOTION_FAULT
                || message.motion == MachineStream::MOTION_OFF,
            is_realtime: message.pace == MachineStream::PACE_REALTIME,
            commands_received: message.commands_received,
            alarms: message.alarms.clone(),
            setpoint_counts: counts,
            measured: measured(message, &cell.machine).filter(|_| is_new),
            latches: message.latches.iter().filter_map(|latch| core_latch(latch, &cell.machine)).collect(),
        })));
    }

    fn request(&self, request: MotionRequest) -> bool {
        self.send(ToEngine::Request(request))
    }

    fn send(&self, message: ToEngine) -> bool {
        lock(&self.cell).as_ref().is_some_and(|cell| cell.inlet.send(message))
    }

    fn is_active(&self) -> bool {
        self.active.load(Ordering::Acquire)
    }

    fn clock(&self) -> Option<TickClock> {
        *lock(&self.clock)
    }

    fn machine_tick(&self) -> u64 {
        self.tick.load(Ordering::Acquire)
    }

    /// The time of the machine's last tick (ns); 0 before it was received of.
    fn machine_time_ns(&self) -> i64 {
        self.clock().map_or(0, |clock| clock.ns(self.machine_tick()))
    }

    /// Why no motion can begin now.
    fn obstacle(&self) -> Option<String> {
        if !self.is_active() {
            return Some("the node is not active".into());
        }
        let served = lock(&self.served);
        if served.is_busy() {
            return Some(format!("{} has command", served.names().0));
        }
        if lock(&self.cell).is_none() || lock(&self.clock).is_none() {
            return Some("no message from the machine yet".into());
        }
        drop(served);
        self.silent_machine().or_else(|| self.fault()).or_else(|| self.grant.obstacle())
    }

    /// Alarm that has to be reset before any motion.
    fn fault(&self) -> Option<String> {
        let number = match self.stopping_alarm.load(Ordering::Acquire) {
            0 => return None,
            number => number,
        };
        Some(match AlarmKind::from_number(number) {
            Some(kind) => format!("alarm {number} needs a reset: {}; {}", kind.entry().name, kind.entry().remedy),
            None => format!("alarm {number} of the machine needs a reset"),
        })
    }

    /// Decides on a goal whose motion begins where the axes rest: what can be judged without moving is rejected.
    fn decide(&self, record: impl FnOnce(&MachineDescription) -> Result<MotionRecord, String>) -> GoalDecision {
        let judged = || {
            self.hindrance()?;
            let machine = self.machine().ok_or_else(setup_goals::unknown)?;
            PreparedMotion::new(record(&machine)?, None, &machine).map(drop)
        };
        match self.obstacle().map_or_else(judged, Err) {
            Ok(()) => GoalDecision::Accept,
            Err(reason) => GoalDecision::Reject(reason),
        }
    }

    /// Why the machine would answer any motion with an alarm. For clients that do not check the work area.
    fn hindrance(&self) -> Result<(), String> {
        match lock(&self.hindrance).as_str() {
            "" => Ok(()),
            reason => Err(format!("nothing may start: {reason}")),
        }
    }

    /// Starts a motion for the goal that has command; a plan is at hand where it is one.
    fn begin(&self, record: MotionRecord, plan: Option<Arc<Plan>>) {
        let job = plan.as_deref().map(JobEnds::from_plan).unwrap_or_default();
        let made = match lock(&self.cell).as_ref() {
            None => Err("no message from the machine yet".to_owned()),
            Some(cell) => PreparedMotion::new(record, plan, &cell.machine),
        };
        self.start(made, job);
    }

    /// The same with a motion that belongs to no job and is ready, or cannot be.
    fn begin_made(&self, made: Result<PreparedMotion, String>) {
        self.start(made, JobEnds::default());
    }

    fn start(&self, made: Result<PreparedMotion, String>, job: JobEnds) {
        let sent = made.and_then(|made| {
            let is_sent = self.send(ToEngine::Start { made, job });
            is_sent.then_some(()).ok_or_else(|| "the engine does not take anything any more".to_owned())
        });
        if let Err(reason) = sent {
            let mut served = lock(&self.served);
            let is_of_topic = served.is_of_topic();
            served.refuse(&reason);
            drop(served);
            if is_of_topic {
                self.warn_of_refusal(&reason);
            }
        }
    }

    /// Queries the engine for the setpoints at a time.
    fn query(&self, ns: i64, responder: Responder<QueryTrajectoryState>) {
        let tick = self.clock().and_then(|clock| clock.nearest_tick(ns));
        // In the order in which the engine is asked.
        let mut queries = lock(&self.queries);
        match tick.filter(|tick| self.send(ToEngine::Query { tick: *tick })) {
            Some(_) => queries.push_back(responder),
            None => {
                let message = "no message from the machine yet, or the time is before its first tick".to_owned();
                responder.send(&QueryTrajectoryStateResponse { message, ..QueryTrajectoryStateResponse::default() });
            }
        }
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
        let outcome = lock(&self.plans).load(&hash, &machine);
        match outcome {
            Ok(Some(plan)) => self.begin(MotionRecord::Plan(hash), Some(plan)),
            Ok(None) => {}
            Err(reason) => lock(&self.served).refuse(&reason),
        }
    }
}

/// Encoder readings at the ticks at which every machine reports them: decisions based on them depend on no other message.
fn measured(message: &MachineStream, machine: &MachineDescription) -> Option<Measured> {
    if !message.tick.is_multiple_of(machine.stream_period_ticks()) {
        return None;
    }
    let counts: [i64; AXIS_COUNT] = message.actual_counts.as_slice().try_into().ok()?;
    let velocity: [f64; AXIS_COUNT] = message.actual_velocities.as_slice().try_into().ok()?;
    let velocity = Axis::ALL.map(|axis| core_from_si(axis, velocity[axis.index()]));
    Some(Measured { tick: message.tick, counts, velocity })
}

fn core_latch(message: &LatchMessage, machine: &MachineDescription) -> Option<Latch> {
    let input = input_named(&message.input, machine)?;
    let axis = Axis::from_joint(&message.joint)?;
    Some(Latch { tick: message.tick, input, rising: message.rising, axis, counts: message.counts })
}

fn subscriptions(shared: &Arc<Shared>) -> Result<Vec<Subscription>, NodeError> {
    let (node, grant, latched) = (&shared.node, &shared.grant, &Qos::latched(1));
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
    let qos = Qos::default_topic().keep_last(1000);
    let stream = subscribe_to_machine::<MachineStream>(
        node,
        grant,
        partners::MACHINE_STREAM,
        (&qos, 0),
        move |message, writer| {
            this.receive(&message, *writer);
            this.watch_jog(&message);
        },
    )?;
    let this = Arc::clone(shared);
    let pages = node.subscribe::<PlanPage>("job_planner/plan", &Qos::latched(256), move |page, info| {
        this.receive_pages(info.writer);
        lock(&this.plans).add(page);
        this.begin_plan();
    })?;
    let this = Arc::clone(shared);
    let area = subscribe_to_machine::<WorkArea>(node, grant, "machine/work_area", (latched, 1), move |area, _| {
        *lock(&this.hindrance) = if area.may_move { String::new() } else { area.message };
    })?;
    let this = Arc::clone(shared);
    let planner = node.subscribe::<CellState>(partners::PLANNER_STATE, &Qos::latched(1), move |_, info| {
        this.receive_planner(info.writer);
    })?;
    let mut all = vec![description, stream, pages, area, planner, manual::subscribe(shared)?];
    all.extend(joint_trajectory::subscribe(shared)?);
    Ok(all)
}

fn services(shared: &Arc<Shared>) -> Result<Vec<ServiceHandle>, NodeError> {
    let this = Arc::clone(shared);
    let hold = shared.node.service::<SetBool>("~/feed_hold", move |request| {
        let success = lock(&this.served).is_busy()
            && this.request(if request.data { MotionRequest::Hold } else { MotionRequest::Unhold });
        let message = if success { "" } else { "nothing is being executed" };
        SetBoolResponse { success, message: message.to_owned() }
    })?;
    let this = Arc::clone(shared);
    let feed_override = shared.node.service::<SetOverride>("~/set_override", move |request| {
        let value = request.feed_override;
        if !(0.0..=1.0).contains(&value) {
            return SetOverrideResponse { success: false, message: format!("override {value}; allowed: 0 to 1") };
        }
        let success = this.request(MotionRequest::SetOverride(value));
        let message = if success { "" } else { "no message from the machine yet" };
        SetOverrideResponse { success, message: message.to_owned() }
    })?;
    let this = Arc::clone(shared);
    let query = shared.node.service_deferred::<QueryTrajectoryState>("~/query_state", move |request, responder| {
        let failed = |message| QueryTrajectoryStateResponse { message, ..QueryTrajectoryStateResponse::default() };
        this.query(ns_from_time(&request.time), responder.or_fail(failed));
    })?;
    Ok(vec![hold, feed_override, query, manual::offer(shared)?])
}
