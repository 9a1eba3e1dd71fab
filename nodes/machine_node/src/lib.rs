// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The node of a machine behind the machine contract (`nodes/MACHINE_CONTRACT.md`): topics, services, command authority, parameters,
//! health and records. A [`Plant`] is what moves behind it: the simulation, or real drives.

mod buffer_advice;
mod clock_outlet;
mod health;
mod inputs;
mod keyframe_outlet;
mod loading;
mod pump;
mod scene_outlet;
mod work_area;

use camwright::machine::description::MachineDescription;
use camwright::machine::persistent_state::PersistentState;
use camwright::simulation::Machine;
use camwright::simulation::fault::{FAULTS, Fault};
use camwright::simulation::measured::Measurement;
use camwright_authority::{CommandServer, OneSender};
use camwright_files::convert::machine_description::description_message;
use camwright_files::convert::machine_now::MachineNow;
use camwright_files::convert::setpoints::chunk_from_trajectory;
use camwright_files::convert::time::TickClock;
use camwright_files::locate::locate;
use camwright_files::machine_file;
use camwright_files::machine_state_file;
use camwright_machine_cycle::bounds::Bounds;
use camwright_machine_cycle::commands;
use camwright_machine_cycle::cyclic_loop::CyclicLoop;
use camwright_machine_cycle::faults::asked_fault;
use camwright_machine_cycle::input_record::estop_request;
use camwright_machine_cycle::keyframes::Keyframes;
use camwright_machine_cycle::messages::{AskedFault, Inbound, Outbound};
use camwright_machine_cycle::pacing::Pace;
use camwright_machine_cycle::part::PartSnapshot;
use camwright_machine_cycle::servo_bus::ServoBus;
use camwright_msgs::camwright_msgs::msg::{
    MachineCommand as CommandMessage, MachineDescription as DescriptionMessage, MachineStream, RecorderStatus,
};
use camwright_msgs::camwright_msgs::srv::{InjectFault, InjectFaultResponse};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolResponse, Trigger, TriggerResponse};
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use camwright_ros::liveness;
use camwright_ros::realtime::{self, Realtime};
use camwright_ros::running::{NodeError, Threads, autostart};
use camwright_ros::{
    Diagnostics, Farewell, Level, Lifecycle, LifecycleCallbacks, Node, NodeOptions, Parameter, ParameterValue,
    Parameters, Publisher, Qos, Responder, RosArgs, ServiceHandle, SpinThread, Subscription, TimerHandle,
};
use camwright_threads::ring::{Receiver, Sender, Waker, ring};
use camwright_threads::system_time::system_time_ns;
use health::Health;
use loading::Loads;
use pump::{Context, MachineOutlets, MachinePump};
use scene_outlet::SceneOutlet;
use std::collections::VecDeque;
use std::marker::PhantomData;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use work_area::{AreaRequests, CounterOutlet};

/// Messages that may wait between the threads.
const RING: usize = 1024;
/// Ticks the machine may be ahead of the recorder at pace fast.
const RECORDER_WINDOW: u64 = 500;
/// Parameter: how long the loader may be silent.
const LOADER_TIMEOUT: &str = "loader_timeout_s";
/// Parameter: how far setpoints run ahead.
const BUFFER: &str = "setpoint_buffer_ms";
/// Parameter: joint states of a machine at rest.
const REST_RATE: &str = "rest_publish_rate_hz";

/// Parameter: clock of the ticks, of a simulated machine.
pub const PACE: &str = "pace";

/// Drives and sensors of a machine.
pub trait Plant: std::fmt::Debug + Default + Send + Sync {
    /// Name of the node.
    fn node_name(&self) -> &'static str;

    /// Parameters in addition to those of every machine.
    fn parameters(&self) -> Vec<Parameter>;

    /// Makes the machine ready; `waker` wakes its cyclic thread.
    ///
    /// # Errors
    /// Why there is no such machine.
    fn open(
        &self,
        node: &Node,
        file: &machine_file::MachineConfig,
        lasting: PersistentState,
        waker: &Waker,
    ) -> Result<OpenedPlant, NodeError>;
}

/// A machine that is ready.
#[derive(Debug)]
pub struct OpenedPlant {
    pub machine: Machine,
    /// Bus to real drives, and their readings at rest; `None`: the machine is simulated.
    pub bus: Option<(Box<dyn ServoBus>, Measurement)>,
}

/// A running machine with the drives and sensors `P`.
#[derive(Debug)]
pub struct MachineNode<P> {
    _plant: PhantomData<P>,
    node: Node,
    lifecycle: Lifecycle,
    threads: Threads,
    bounds: Arc<Bounds>,
    waker: Waker,
    buffer_ms: f64,
    _spin: SpinThread,
    _endpoints: MachineEndpoints,
    _diagnostics: Diagnostics,
}

#[derive(Debug)]
struct MachineEndpoints {
    _subscriptions: Vec<Subscription>,
    _services: Vec<ServiceHandle>,
    _around: work_area::WorkAreaEndpoints,
    _command: TimerHandle,
}

/// The way into the cyclic thread, shared by the callbacks of the executor thread.
#[derive(Debug, Clone)]
struct CycleInlet(Arc<Mutex<Sender<Inbound>>>);

impl CycleInlet {
    /// False when the ring is full: the cyclic thread does not take anything any more.
    fn send(&self, message: Inbound) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).send(message).is_ok()
    }
}

/// Requests that the cyclic thread has yet to answer, oldest first.
type PendingRequests<S> = Arc<Mutex<VecDeque<Responder<S>>>>;

fn push<S: camwright_msgs::Service>(waiting: &PendingRequests<S>, responder: Responder<S>) {
    waiting.lock().unwrap_or_else(PoisonError::into_inner).push_back(responder);
}

fn pop<S: camwright_msgs::Service>(waiting: &PendingRequests<S>) -> Option<Responder<S>> {
    waiting.lock().unwrap_or_else(PoisonError::into_inner).pop_front()
}

/// Order of the emergency stop: pressed, and the responder.
type EStopOrder = (bool, Responder<SetBool>);

/// Orders of the emergency stop that the cyclic thread has yet to apply, oldest first.
#[derive(Clone, Default)]
struct EStopOrders(Arc<Mutex<VecDeque<EStopOrder>>>);

impl EStopOrders {
    fn lock(&self) -> MutexGuard<'_, VecDeque<EStopOrder>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Answers the oldest order: it is applied.
    fn answer(&self) {
        let Some((pressed, responder)) = self.lock().pop_front() else { return };
        let state = if pressed { "pressed" } else { "released; a reset is needed" };
        let message = format!("emergency stop {state} (a simulation, not a safety function)");
        responder.send(&SetBoolResponse { success: true, message });
    }
}

fn parameters(plant: &impl Plant) -> Vec<Parameter> {
    let own = vec![
        Parameter::string("machine", "cam_grinder").describe("machine file, by name or path").read_only(),
        Parameter::string_array("machine_overrides", &[]).describe("key=value pairs over the machine file").read_only(),
        Parameter::string("state_file", "")
            .describe("file of the persistent machine state; empty: the user's state directory; 'none': no file")
            .read_only(),
        Parameter::double(LOADER_TIMEOUT, 1.0)
            .describe("maximum silence of the loader on loader/state (s); only with `loading`")
            .range(0.1, 60.0)
            .read_only(),
        Parameter::double(BUFFER, 0.0)
            .describe(
                "lead of the setpoints (ms): longer tolerates a busier computer, shorter reacts sooner; 0: feedback_delay_ticks of the machine file",
            )
            .range(0.0, 1000.0)
            .read_only(),
        Parameter::double(REST_RATE, 5.0)
            .describe("rate of joint_states at rest without a job, at pace realtime (Hz); otherwise every tick")
            .range(1.0, 10_000.0)
            .read_only(),
        autostart::parameter(),
        liveness::parameter(),
    ];
    own.into_iter()
        .chain(plant.parameters())
        .chain(keyframe_outlet::parameters())
        .chain(realtime::parameters())
        .chain(scene_outlet::parameters())
        .collect()
}

impl<P: Plant> MachineNode<P> {
    /// Name and parameters of the node.
    #[must_use]
    pub fn options(args: &RosArgs) -> NodeOptions {
        let plant = P::default();
        NodeOptions::new(plant.node_name(), args).parameters(parameters(&plant))
    }

    /// Machine and wheel with which a node with these arguments starts.
    ///
    /// # Errors
    /// A machine file or a machine state that is refused, parameters out of range.
    pub fn machine_from_args(args: &RosArgs) -> Result<MachineNow, NodeError> {
        let LoadedMachine { file, lasting, .. } = LoadedMachine::from_parameters(&Self::options(args).declared()?)?;
        let mut description = file.description;
        let mounted = description.mount_wheel(lasting.mounted_wheel());
        mounted.map_err(|error| NodeError::Parameter(error.to_string()))?;
        Ok(MachineNow { description, wheels: lasting.wheels() })
    }

    /// Starts the node.
    ///
    /// # Errors
    /// A machine file that is refused, parameters out of range, DDS that cannot start, a plant that is not there.
    pub fn start(args: &RosArgs) -> Result<Self, NodeError> {
        let options = Self::options(args);
        // At pace fast there is no clock to keep up with, only others to be kept from working.
        let keeps_clock = !matches!(options.asked(PACE), Some(ParameterValue::String(pace)) if pace == "fast");
        realtime::start_with_priority(options, keeps_clock, Self::start_node)
    }

    fn start_node(options: NodeOptions) -> Result<Self, NodeError> {
        let node = Node::new(options)?;
        let desk = CommandServer::new(&node, liveness::limit(&node))?;
        let LoadedMachine { file, state_file, lasting, pace } = LoadedMachine::from_parameters(node.parameters())?;
        let (waker, pump_waker) = (Waker::default(), Waker::default());
        let OpenedPlant { machine, bus } = P::default().open(&node, &file, lasting, &waker)?;
        let description = node.publisher("machine/description", &Qos::latched(1))?;
        description.publish(&description_message(&file, &lasting))?;

        let (inlet, inbound) = ring(RING, &waker);
        let (outbound, reports) = ring(RING, &pump_waker);
        let setup = LoadedSetup {
            clock: tick_clock(&node, &file.description, pace),
            node,
            file,
            pace,
            inlet: CycleInlet(Arc::new(Mutex::new(inlet))),
            bounds: Arc::default(),
            waker,
            health: Health::default(),
            resets: PendingRequests::default(),
            estops: EStopOrders::default(),
            loads: Loads::default(),
            area: AreaRequests::default(),
            drives: bus.as_ref().map(|(bus, _)| bus.name()),
        };
        let cycle = setup.cycle(machine, inbound, outbound);
        let cycle = match bus {
            Some((bus, at_rest)) => cycle.with_bus(bus, at_rest),
            None => cycle,
        };
        let pump = setup.pump(&lasting)?;
        let mut counters = CounterOutlet::new(&setup.node)?;
        let mut threads = Threads::default();
        let realtime = setup.start_cycle(cycle, &mut threads)?;
        counters.publish(&lasting);
        let answer = setup.answers(state_file, description, counters);
        threads.spawn(&setup.node, "machine pump", move || pump.run(reports, &pump_waker, answer))?;

        let endpoints = setup.offer_endpoints(&desk)?;
        let LoadedSetup { node, file, pace, inlet, bounds, waker, health, .. } = setup;
        let lifecycle = node.lifecycle(Activation(inlet))?;
        let spin = node.spin_in_thread()?;
        autostart::begin(&node, &lifecycle);
        let diagnostics = health.report(&node, &file.description, &bounds, (pace, realtime))?;
        let (_spin, _endpoints, _diagnostics) = (spin, endpoints, diagnostics);
        let buffer_ms = buffer_advice::buffer_ms(&file.description);
        Ok(Self {
            _plant: PhantomData,
            node,
            lifecycle,
            threads,
            bounds,
            waker,
            buffer_ms,
            _spin,
            _endpoints,
            _diagnostics,
        })
    }

    #[must_use]
    pub fn node(&self) -> &Node {
        &self.node
    }

    pub fn lifecycle(&self) -> &Lifecycle {
        &self.lifecycle
    }

    /// Warning where the pauses of the cycle since the start ask for a longer setpoint buffer: at pace realtime the cycle measures how late
    /// the computer wakes it.
    #[must_use]
    pub fn underrun_risk(&self) -> Option<String> {
        let pause_us = self.bounds.longest_pause_us.load(Ordering::Relaxed);
        buffer_advice::underrun_risk(self.node.name(), self.buffer_ms, pause_us as f64 / buffer_advice::US_PER_MS)
    }

    /// Ends the cyclic thread, then the node.
    pub fn stop(self) -> Farewell {
        self.bounds.stop.store(true, Ordering::Release);
        self.waker.wake();
        self.threads.join();
        self.node.leave()
    }
}

/// Machine file, state and pace, as the parameters of the node name them.
struct LoadedMachine {
    file: machine_file::MachineConfig,
    /// None: the state is not stored.
    state_file: Option<PathBuf>,
    lasting: PersistentState,
    pace: Pace,
}

impl LoadedMachine {
    fn from_parameters(parameters: &Parameters) -> Result<Self, NodeError> {
        let located = locate("machines", &parameters.string("machine"), "yaml", None).map_err(NodeError::file)?;
        let mut overrides = parameters.string_array("machine_overrides");
        let mut file = machine_file::parse(&located.path, &located.text, &overrides).map_err(NodeError::file)?;
        if let Some(ticks) = buffer_ticks(parameters.double(BUFFER), &file.description) {
            overrides.push(format!("feedback_delay_ticks={ticks}"));
            file = machine_file::parse(&located.path, &located.text, &overrides).map_err(NodeError::file)?;
        }
        // The clock of real drives is real time; only the simulation has the parameter.
        let pace = match parameters.get(PACE) {
            Some(ParameterValue::String(pace)) if pace == "fast" => Pace::Fast,
            _ => Pace::Realtime,
        };
        let state_file = match parameters.string("state_file").as_str() {
            "" => machine_state_file::default_path(&file.description.name),
            "none" => None,
            path => Some(PathBuf::from(path)),
        };
        let lasting = match &state_file {
            Some(path) => machine_state_file::load(path, &file.description).map_err(NodeError::file)?,
            None => PersistentState::new(&file.description),
        };
        Ok(Self { file, state_file, lasting, pace })
    }
}

/// Clock of the ticks. At pace realtime they follow the system clock, in whole cycles; simulated time begins with a whole second.
fn tick_clock(node: &Node, machine: &MachineDescription, pace: Pace) -> TickClock {
    let (now_ns, grid_ns) = match pace {
        Pace::Realtime => (system_time_ns(), i64::from(machine.cycle_time_ns).max(1)),
        Pace::Fast => (node.now_ns(), 1_000_000_000),
    };
    TickClock { epoch_ns: now_ns / grid_ns * grid_ns, cycle_time_ns: machine.cycle_time_ns }
}

/// Values that the phases of the start share.
struct LoadedSetup {
    node: Node,
    file: machine_file::MachineConfig,
    pace: Pace,
    clock: TickClock,
    inlet: CycleInlet,
    bounds: Arc<Bounds>,
    /// Wakes the cyclic thread.
    waker: Waker,
    health: Health,
    resets: PendingRequests<Trigger>,
    estops: EStopOrders,
    loads: Loads,
    area: AreaRequests,
    /// Bus to real drives; `None`: the machine is simulated.
    drives: Option<&'static str>,
}

impl LoadedSetup {
    fn cycle(&self, machine: Machine, inbound: Receiver<Inbound>, outbound: Sender<Outbound>) -> CyclicLoop {
        let period_s = keyframe_outlet::period_s(self.node.parameters());
        // A replay cannot compute real drives again, so it does not begin in the middle either.
        let period_s = if self.drives.is_none() { period_s } else { 0.0 };
        let keyframes = Keyframes::new(period_s, self.file.description.cycle_time_s(), self.pace);
        CyclicLoop::new(machine, self.pace, inbound, outbound, Arc::clone(&self.bounds), RECORDER_WINDOW)
            .with_clock(self.clock)
            .with_keyframes(keyframes)
            .with_silence_limit(liveness::limit(&self.node))
    }

    fn pump(&self, lasting: &PersistentState) -> Result<MachinePump, NodeError> {
        let mut description = self.file.description.clone();
        description
            .mount_wheel(lasting.mounted_wheel())
            .map_err(|error| NodeError::Parameter(format!("state of the machine: {error}")))?;
        let (machine, is_fast) = (&description, self.pace == Pace::Fast);
        self.health.update(lasting);
        let rest_rate_hz = self.node.parameters().double(REST_RATE);
        let context = Context {
            health: self.health.clone(),
            node: self.node.clone(),
            description: machine.clone(),
            clock: self.clock,
            pace: if is_fast { MachineStream::PACE_FAST } else { MachineStream::PACE_REALTIME },
            inlet: self.inlet.clone(),
            is_fast,
            drops: self.bounds.drops.clone(),
            rest_period_ticks: rest_period_ticks(rest_rate_hz, machine, self.pace),
        };
        let drops = &self.bounds.drops;
        let scene = SceneOutlet::new(&self.node, machine, lasting, self.inlet.clone(), drops)?;
        let mut outlets = MachineOutlets::new(&self.node, is_fast, machine, self.clock, drops)?;
        outlets.begin(lasting, self.drives)?;
        Ok(MachinePump::new(context, outlets, scene))
    }

    /// Starts the cyclic thread. At pace fast it keeps no clock, and takes no priority from others.
    fn start_cycle(&self, cycle: CyclicLoop, threads: &mut Threads) -> Result<Realtime, NodeError> {
        let (waker, realtime) = (self.waker.clone(), Realtime::for_node(&self.node)?);
        let priority = (self.pace == Pace::Realtime).then(|| realtime.clone());
        threads.spawn(&self.node, "machine cycle", move || {
            if let Some(priority) = priority {
                priority.adopt_current_thread();
            }
            cycle.run(&waker);
        })?;
        Ok(realtime)
    }

    /// Receiver of the pump's answers.
    fn answers(
        &self,
        state_file: Option<PathBuf>,
        description: Publisher<DescriptionMessage>,
        counters: CounterOutlet,
    ) -> impl FnMut(Outbound) + Send + use<> {
        let (file, area, health) = (self.file.clone(), self.area.clone(), self.health.clone());
        let state = StateOutlets { file, state_file, description, counters, area, health };
        answers(&self.node, &self.inlet, (&self.resets, &self.estops), &self.loads, state)
    }

    fn offer_endpoints(&self, desk: &Arc<CommandServer>) -> Result<MachineEndpoints, NodeError> {
        let (node, machine) = (&self.node, &self.file.description);
        let subscriptions = subscriptions(node, machine, self.clock, &self.inlet, &self.bounds, &self.waker, desk)?;
        let mut services = services(node, &self.inlet, (&self.resets, &self.estops), &self.loads)?;
        if self.drives.is_none() {
            services.push(fault_service(node, machine, &self.inlet)?);
        }
        let loader_timeout = Duration::from_secs_f64(node.parameters().double(LOADER_TIMEOUT));
        let loader_timeout = machine.loading.map(|_| loader_timeout);
        let mut around = work_area::offer(node, &self.inlet, &self.area, loader_timeout)?;
        services.append(&mut around.services);
        let (bounds, inlet) = (Arc::clone(&self.bounds), self.inlet.clone());
        let in_motion = move || bounds.in_motion.load(Ordering::Relaxed);
        let alarm = move || {
            inlet.send(Inbound::NoAuthority);
        };
        let mut command = desk.open(in_motion, alarm)?;
        services.append(&mut command.services);
        Ok(MachineEndpoints {
            _subscriptions: subscriptions,
            _services: services,
            _around: around,
            _command: command.timer,
        })
    }
}

/// Ticks of a buffer of so many ms; `None`: as the machine file says.
#[allow(clippy::cast_possible_truncation, reason = "at most a second")]
fn buffer_ticks(buffer_ms: f64, machine: &MachineDescription) -> Option<u32> {
    (buffer_ms > 0.0).then(|| (buffer_ms * 1e6 / f64::from(machine.cycle_time_ns)).round() as u32)
}

/// Ticks between two joint states at rest; at pace fast every tick is one that something happens in.
#[allow(clippy::cast_possible_truncation, reason = "a rate of 1 to 10000 Hz of ticks of at most 10 ms")]
fn rest_period_ticks(rate_hz: f64, machine: &MachineDescription, pace: Pace) -> u64 {
    match pace {
        Pace::Realtime => (1.0 / (rate_hz * machine.cycle_time_s())).round().max(1.0) as u64,
        Pace::Fast => 1,
    }
}

/// Ticks only while the node is active.
#[derive(Debug)]
struct Activation(CycleInlet);

impl LifecycleCallbacks for Activation {
    fn activate(&mut self) -> Result<(), String> {
        self.switch(true)
    }
    fn deactivate(&mut self) -> Result<(), String> {
        self.switch(false)
    }
    fn shutdown(&mut self) -> Result<(), String> {
        self.switch(false)
    }
}

impl Activation {
    fn switch(&self, active: bool) -> Result<(), String> {
        if self.0.send(Inbound::Active(active)) { Ok(()) } else { Err("the machine's cycle does not answer".into()) }
    }
}

fn subscriptions(
    node: &Node,
    description: &MachineDescription,
    clock: TickClock,
    inlet: &CycleInlet,
    bounds: &Arc<Bounds>,
    waker: &Waker,
    desk: &Arc<CommandServer>,
) -> Result<Vec<Subscription>, NodeError> {
    let qos = Qos::default_topic().keep_last(1000);
    let (machine, logger, chunks, gate) = (description.clone(), node.logger().clone(), inlet.clone(), Arc::clone(desk));
    let setpoints = node.subscribe::<JointTrajectory>("machine/setpoints", &qos, move |message, info| {
        if !gate.accepts_motion("machine/setpoints", &info.writer) {
            return;
        }
        match chunk_from_trajectory(&message, &machine, clock) {
            Ok(chunk) => {
                chunks.send(Inbound::Chunk(participant(info.writer), Box::new(chunk)));
            }
            Err(error) => {
                logger.warn(&format!("setpoints refused: {error}"));
                chunks.send(Inbound::NoChunk(participant(info.writer)));
            }
        }
    })?;
    let (orders, machine, gate, ticks) = (inlet.clone(), description.clone(), Arc::clone(desk), Arc::clone(bounds));
    let commands = node.subscribe::<CommandMessage>("machine/commands", &qos, move |message, info| {
        if !gate.accepts_motion("machine/commands", &info.writer) {
            return;
        }
        match commands::checked(&message, &machine, clock, ticks.tick.load(Ordering::Relaxed)) {
            Ok(command) => {
                orders.send(Inbound::Command(participant(info.writer), command));
            }
            Err(reason) => gate.refuse("machine/commands", &info.writer, &reason),
        }
    })?;
    let (bounds, waker, listener) = (Arc::clone(bounds), waker.clone(), node.clone());
    let mut one_recorder = OneSender::new("run_logger/status", liveness::limit(node));
    let recorder = node.subscribe::<RecorderStatus>(
        "run_logger/status",
        &Qos::default_topic().keep_last(100),
        move |message, info| {
            if !one_recorder.accepts(&info.writer, &listener) {
                return;
            }
            bounds.recorded_tick.store(message.last_tick, Ordering::Release);
            bounds.recording.store(message.recording && !message.paused, Ordering::Release);
            bounds.recorder_messages.fetch_add(1, Ordering::AcqRel);
            waker.wake();
        },
    )?;
    Ok(vec![setpoints, commands, recorder])
}

/// Who sends: the participant of a writer, the same for its setpoints and its commands.
fn participant(writer: camwright_ros::Guid) -> [u8; 16] {
    let mut participant = writer;
    participant[12..].fill(0);
    participant
}

fn services(
    node: &Node,
    inlet: &CycleInlet,
    (resets, estops): (&PendingRequests<Trigger>, &EStopOrders),
    loads: &Loads,
) -> Result<Vec<ServiceHandle>, NodeError> {
    let (way, waiting) = (inlet.clone(), Arc::clone(resets));
    let reset = node.service_deferred::<Trigger>("machine/reset", move |_, responder| {
        push(&waiting, responder.or_fail(|message| TriggerResponse { success: false, message }));
        way.send(Inbound::Reset);
    })?;
    let (way, waiting) = (inlet.clone(), estops.clone());
    let estop = node.service_deferred::<SetBool>("machine/estop", move |request, responder| {
        let refusal = |message: String| SetBoolResponse { success: false, message };
        let (fault, request_of_it) = (Fault::EStop(request.data), estop_request(request.data));
        let asked = AskedFault { fault, job_tick: 0, request: request_of_it };
        // Orders are given in the order of their responders.
        let mut orders = waiting.lock();
        let responder = responder.or_fail(refusal);
        if way.send(Inbound::Fault(Box::new(asked))) {
            orders.push_back((request.data, responder));
        } else {
            responder.send(&refusal("the machine is ending and takes no orders".to_owned()));
        }
    })?;
    let [lobe, bar] = loading::offer(node, inlet, loads)?;
    Ok(vec![reset, estop, lobe, bar])
}

/// Injection of faults, into a simulated machine.
fn fault_service(
    node: &Node,
    description: &MachineDescription,
    inlet: &CycleInlet,
) -> Result<ServiceHandle, NodeError> {
    let (way, machine) = (inlet.clone(), description.clone());
    let inject = node.service::<InjectFault>("machine/inject_fault", move |request| {
        if request.fault.is_empty() {
            let list: Vec<String> =
                FAULTS.iter().map(|f| format!("{} (target: {}; value: {})", f.name, f.target, f.value)).collect();
            return InjectFaultResponse { success: false, message: list.join("; ") };
        }
        match asked_fault(request, &machine) {
            Ok(asked) => {
                InjectFaultResponse { success: way.send(Inbound::Fault(Box::new(asked))), message: String::new() }
            }
            Err(error) => InjectFaultResponse { success: false, message: error.to_string() },
        }
    })?;
    Ok(inject)
}

/// Files and topics that follow the state that outlives a run.
struct StateOutlets {
    file: machine_file::MachineConfig,
    state_file: Option<PathBuf>,
    counters: CounterOutlet,
    area: AreaRequests,
    description: Publisher<DescriptionMessage>,
    health: Health,
}

impl StateOutlets {
    /// Stores and publishes the state.
    fn update(&mut self, state: &PersistentState, node: &Node) {
        if let Some(Err(error)) =
            self.state_file.as_ref().map(|path| machine_state_file::store(path, state, &self.file.description))
        {
            node.log(Level::Error, &error.to_string());
        }
        self.counters.publish(state);
        self.health.update(state);
        self.publish_description(state, node);
    }

    /// Publishes the machine again if its wheel can change.
    fn publish_description(&self, state: &PersistentState, node: &Node) {
        let machine = &self.file.description;
        if machine.dresser.is_none() && machine.wheel.grinding_ratio.is_none() && machine.wheel_changer.is_none() {
            return;
        }
        if let Err(error) = self.description.publish(&description_message(&self.file, state)) {
            node.log(Level::Error, &format!("the wheel's radius cannot be published: {error}"));
        }
    }
}

/// Handles the answers of the cyclic thread, on the pump.
fn answers(
    node: &Node,
    inlet: &CycleInlet,
    (resets, estops): (&PendingRequests<Trigger>, &EStopOrders),
    loads: &Loads,
    mut outlets: StateOutlets,
) -> impl FnMut(Outbound) + Send + use<> {
    let (node, inlet, resets, loads) = (node.clone(), inlet.clone(), Arc::clone(resets), loads.clone());
    let estops = estops.clone();
    move |message| match message {
        Outbound::EStopDone => estops.answer(),
        Outbound::ResetDone(outcome) => {
            let (success, message) = match outcome {
                Ok(()) => (true, "alarms are cleared; nothing moves before a new goal".to_owned()),
                Err(error) => (false, error.to_string()),
            };
            if let Some(responder) = pop(&resets) {
                responder.send(&TriggerResponse { success, message });
            }
        }
        message @ (Outbound::LobeDone(..) | Outbound::BarDone(..)) => loads.answer(message),
        Outbound::Refused(error, writer, chunk) => {
            drop(chunk);
            node.log(Level::Warn, &format!("setpoints of {} refused: {error}", node.who(&writer)));
        }
        Outbound::SecondWriter { holder, refused, chunk } => {
            drop(chunk);
            let text = format!("setpoints of {} refused: {} has command", node.who(&refused), node.who(&holder));
            node.log(Level::Warn, &text);
        }
        Outbound::JobEnded => {
            inlet.send(Inbound::Snapshot(Box::new(PartSnapshot { finished: true, ..PartSnapshot::default() })));
        }
        Outbound::Lasting(state) => outlets.update(&state, &node),
        Outbound::AreaDone(order, outcome) => outlets.area.answer(order, outcome),
        Outbound::Used(_, chunk) => drop(chunk),
        Outbound::Applied(input) => drop(input),
        Outbound::Keyframe(room) => {
            inlet.send(Inbound::Room(room.reset()));
        }
        Outbound::DrivesLost(_)
        | Outbound::Slip(_)
        | Outbound::Tick(..)
        | Outbound::Snapshot(_)
        | Outbound::Outline(_) => {}
    }
}
