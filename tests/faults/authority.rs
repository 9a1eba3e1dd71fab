// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Command authority: a stranger changes no zero, no state and moves nothing; one holder at a time does; stops stay open to everybody.
#![allow(clippy::print_stdout, reason = "it prints what it covers")]

use crate::cell;
use crate::hostile;
use crate::support;

use camwright_authority::{HeldCommand, TakeError, TakeOptions};
use camwright_axis_interpolator::AxisInterpolator;
use camwright_msgs::camwright_msgs::action::{Home, HomeGoal, RunJob, RunJobGoal};
use camwright_msgs::camwright_msgs::msg::{
    CommandHolder, InterpolatorState, JobStatus, MachineAlarms, MachineCommand, MachineStream,
};
use camwright_msgs::camwright_msgs::srv::{TakeCommand, TakeCommandRequest, TakeCommandResponse};
use camwright_msgs::lifecycle_msgs::msg::State;
use camwright_msgs::lifecycle_msgs::srv::{GetState, GetStateRequest};
use camwright_msgs::rcl_interfaces::msg::Parameter;
use camwright_msgs::rcl_interfaces::srv::{SetParameters, SetParametersRequest};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest};
use camwright_ros::{GoalStatus, MessageInfo, Node, NodeOptions, Publisher, Qos, RosArgs, SpinThread, Subscription};
use cell::{Cell, PATIENCE};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use support::Domain;

/// A node of a participant of its own, and what it hears.
struct Client {
    node: Node,
    stream: Arc<Mutex<MachineStream>>,
    alarms: Arc<Mutex<Vec<u16>>>,
    holder: Arc<Mutex<CommandHolder>>,
    homed: Arc<Mutex<bool>>,
    job: Arc<Mutex<JobStatus>>,
    _subscriptions: Vec<Subscription>,
    _spin: SpinThread,
}

impl Client {
    fn new(domain: &Domain, name: &str) -> Self {
        let node = Node::new(NodeOptions::new(name, &RosArgs::default().with_domain_id(domain.id()))).expect("a node");
        let (stream, alarms): (Arc<Mutex<MachineStream>>, Arc<Mutex<Vec<u16>>>) = Default::default();
        let (holder, homed): (Arc<Mutex<CommandHolder>>, Arc<Mutex<bool>>) = Default::default();
        let job: Arc<Mutex<JobStatus>> = Arc::default();
        let to_job = Arc::clone(&job);
        let (to_stream, to_alarms) = (Arc::clone(&stream), Arc::clone(&alarms));
        let (to_holder, to_homed) = (Arc::clone(&holder), Arc::clone(&homed));
        let latched = Qos::latched(1);
        // What a client publishes on these topics itself is not the cell's.
        let own = node.participant_guid().expect("a running node");
        let is_own = move |info: &MessageInfo| info.writer[..12] == own[..12];
        let subscriptions = [
            node.subscribe::<MachineStream>("machine/stream", &Qos::default_topic(), move |message, info| {
                if !is_own(info) {
                    *to_stream.lock().expect("not poisoned") = message;
                }
            }),
            node.subscribe::<MachineAlarms>("machine/alarms", &latched, move |message, info| {
                if !is_own(info) {
                    *to_alarms.lock().expect("not poisoned") =
                        message.alarms.iter().map(|alarm| alarm.number).collect();
                }
            }),
            node.subscribe::<CommandHolder>("machine/command_holder", &latched, move |message, info| {
                if !is_own(info) {
                    *to_holder.lock().expect("not poisoned") = message;
                }
            }),
            node.subscribe::<InterpolatorState>("axis_interpolator/state", &latched, move |message, info| {
                if !is_own(info) {
                    *to_homed.lock().expect("not poisoned") = message.is_homed;
                }
            }),
            node.subscribe::<JobStatus>("job_planner/job_status", &latched, move |message, info| {
                if !is_own(info) {
                    *to_job.lock().expect("not poisoned") = message;
                }
            }),
        ];
        let spin = node.spin_in_thread().expect("a thread");
        let _subscriptions = subscriptions.map(|made| made.expect("a subscription")).into();
        Self { node, stream, alarms, holder, homed, job, _subscriptions, _spin: spin }
    }

    fn call<S: camwright_msgs::Service>(&self, name: &str, request: &S::Request) -> S::Response {
        let client = self.node.client::<S>(name).expect("a client");
        client.wait_for_service(PATIENCE).expect("the service");
        client.call(request, PATIENCE).expect("an answer")
    }

    fn take_command(&self, holder: &str, lease_s: f64) -> TakeCommandResponse {
        let request = TakeCommandRequest { holder: holder.into(), lease_s, ..TakeCommandRequest::default() };
        self.call::<TakeCommand>("machine/take_command", &request)
    }

    fn release(&self, holder: &str) -> TakeCommandResponse {
        let request = TakeCommandRequest { holder: holder.into(), release: true, ..TakeCommandRequest::default() };
        self.call::<TakeCommand>("machine/take_command", &request)
    }

    fn stream(&self) -> MachineStream {
        self.stream.lock().expect("not poisoned").clone()
    }

    fn has_alarm(&self, number: u16) -> bool {
        self.alarms.lock().expect("not poisoned").contains(&number)
    }

    fn holder(&self) -> String {
        self.holder.lock().expect("not poisoned").holder.clone()
    }

    /// Homes the axes.
    fn home(&self) -> GoalStatus {
        let home = self.node.action_client::<Home>("axis_interpolator/home").expect("a client");
        home.wait_for_server(PATIENCE).expect("home");
        let goal = home.send_goal(HomeGoal::default(), drop, PATIENCE).expect("a decision");
        if goal.accepted() { goal.result(PATIENCE).expect("a result").0 } else { GoalStatus::Unknown }
    }

    /// Sends a goal to the planner; true if it was accepted.
    fn runs_job(&self) -> bool {
        let jobs = self.node.action_client::<RunJob>("job_planner/run_job").expect("a client");
        jobs.wait_for_server(PATIENCE).expect("run_job");
        let goal = RunJobGoal { job: "eccentric".into(), ..RunJobGoal::default() };
        jobs.send_goal(goal, drop, PATIENCE).expect("a decision").accepted()
    }

    fn job_message(&self) -> String {
        self.job.lock().expect("not poisoned").message.clone()
    }

    fn stop(self) {
        self.node.shutdown();
    }
}

fn until(what: &str, mut wanted: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !wanted() {
        assert!(Instant::now() < deadline, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// A cell without a holder of command.
fn free_cell() -> Cell {
    let mut cell = Cell::start(&[]);
    cell.release();
    cell
}

fn commands(client: &Client) -> Publisher<MachineCommand> {
    let publisher =
        client.node.publisher("machine/commands", &Qos::default_topic().keep_last(100)).expect("a publisher");
    assert!(publisher.wait_matched(1, PATIENCE), "the machine listens");
    publisher
}

#[test]
fn a_stranger_changes_no_zero_and_a_holder_works_afterwards() {
    let cell = free_cell();
    let [stranger, anna] = ["stranger", "anna"].map(|name| Client::new(cell.domain(), name));
    until("the machine is heard", || stranger.stream().tick > 0);
    let commands = commands(&stranger);
    let before = stranger.stream();
    let order = |kind: u8, target: &str, counts: i64, ahead: u64| {
        let tick = stranger.stream().tick + ahead;
        let target = target.to_owned();
        commands.publish(&MachineCommand { sequence: 1, tick, kind, target, counts, ..MachineCommand::default() })
    };
    order(MachineCommand::SET_HOME, "x_axis", -2000, 5).expect("it is sent");
    until("the refusal is an alarm", || stranger.has_alarm(86));
    order(MachineCommand::WHEEL_START, "", 0, 30_000).expect("it is sent");
    order(MachineCommand::PUSH, "", i64::MAX, 5).expect("it is sent");
    std::thread::sleep(Duration::from_millis(500));
    let after = stranger.stream();
    assert!(after.tick > before.tick, "the machine goes on");
    assert_eq!(after.setpoint_counts, before.setpoint_counts);
    assert_eq!((after.commands_received, after.holder.as_str()), (before.commands_received, ""));
    assert_eq!(stranger.home(), GoalStatus::Unknown, "the goal is rejected");
    let refused = stranger.call::<Trigger>("machine/reset", &TriggerRequest::default());
    assert!(!refused.success && refused.message.contains("no client has command"), "{}", refused.message);
    assert!(!stranger.runs_job(), "the job is rejected");
    until("the status of the planner has the reason", || stranger.job_message().contains("no client has command"));
    let request = SetParametersRequest { parameters: vec![Parameter { name: "job".into(), ..Parameter::default() }] };
    let refused = stranger.call::<SetParameters>("job_planner/set_parameters", &request);
    assert!(refused.results.len() == 1 && refused.results[0].reason.contains("command"), "{refused:?}");

    // A holder's fields are bounded all the same.
    let command = HeldCommand::acquire(&anna.node, &TakeOptions::new("anna")).expect("command");
    let of_anna = self::commands(&anna);
    for (kind, counts, ahead) in [
        (MachineCommand::PUSH, i64::MAX, 5),
        (MachineCommand::WHEEL_START, 0, 30_000),
        (MachineCommand::ALARM, 9999, 5),
    ] {
        let (sequence, tick) = (1, anna.stream().tick + ahead);
        of_anna.publish(&MachineCommand { sequence, tick, kind, counts, ..MachineCommand::default() }).expect("sent");
    }
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(anna.stream().commands_received, before.commands_received);
    assert_eq!(anna.home(), GoalStatus::Succeeded, "homing works, and hangs on nothing");
    let refused = stranger.call::<Trigger>("machine/reset", &TriggerRequest::default());
    assert!(!refused.success && refused.message.contains("anna has command"), "{}", refused.message);
    let reset = anna.call::<Trigger>("machine/reset", &TriggerRequest::default());
    assert!(reset.success, "{}", reset.message);
    until("the alarm is reset", || !anna.has_alarm(86));
    drop(command);
    stranger.stop();
    anna.stop();
    cell.stop();
}

#[test]
fn a_lease_is_renewed_refused_released_shared_and_runs_out() {
    let cell = free_cell();
    let [anna, bert] = ["anna", "bert"].map(|name| Client::new(cell.domain(), name));
    let taken = anna.take_command("anna", 600.0);
    assert!(taken.success && taken.holder == "anna" && taken.remaining_s > 590.0, "{taken:?}");
    until("everybody hears who has command", || bert.holder() == "anna");
    let refused = bert.take_command("bert", 1.0);
    assert!(!refused.success && refused.message.contains("anna has command for"), "{}", refused.message);
    let refused = HeldCommand::acquire(&bert.node, &TakeOptions::new("bert")).expect_err("anna has it");
    assert!(matches!(refused, TakeError::Refused(_)), "{refused}");
    assert!(!bert.release("anna").success, "the name is not enough");
    assert!(
        !anna.take_command("anna", f64::NAN).success
            && !anna.take_command("anna", 1e9).success
            && !anna.take_command("", 1.0).success
    );
    assert!(anna.take_command("anna", 1.0).success, "renewed, for a second");
    until("it runs out", || bert.holder().is_empty());
    assert!(!anna.call::<Trigger>("machine/reset", &TriggerRequest::default()).success);

    // Handover.
    assert!(anna.take_command("anna", 60.0).success && anna.release("anna").success);
    assert!(bert.take_command("bert", 60.0).success);
    assert!(!anna.call::<Trigger>("machine/reset", &TriggerRequest::default()).success);
    assert!(bert.call::<Trigger>("machine/reset", &TriggerRequest::default()).success);
    assert!(bert.release("bert").success);

    // Shared, as the ros2 command line needs it: each call is another participant.
    let request = TakeCommandRequest { holder: "shell".into(), lease_s: 60.0, shared: true, release: false };
    assert!(anna.call::<TakeCommand>("machine/take_command", &request).success);
    assert!(bert.call::<Trigger>("machine/reset", &TriggerRequest::default()).success);
    assert_eq!(bert.home(), GoalStatus::Succeeded);
    assert!(bert.release("shell").success);
    assert!(!anna.call::<Trigger>("machine/reset", &TriggerRequest::default()).success);

    // A motion keeps the lease under which it began; its end lets it run out.
    assert!(anna.take_command("anna", 5.0).success);
    assert_eq!(anna.home(), GoalStatus::Succeeded);
    until("it runs out", || bert.holder().is_empty());
    anna.stop();
    bert.stop();
    cell.stop();
}

/// A machine that takes its time to answer receives no renewal after the release: it would give command to a client that has left.
#[test]
fn nothing_is_renewed_after_a_release() {
    let domain = Domain::reserve();
    let node = |name| {
        let node = Node::new(NodeOptions::new(name, &RosArgs::default().with_domain_id(domain.id()))).expect("a node");
        let spin = node.spin_in_thread().expect("a thread");
        (node, spin)
    };
    let [(machine, _machine_spin), (client, _client_spin)] = ["slow_machine", "client"].map(node);
    let (sender, received) = std::sync::mpsc::channel();
    let mut waiting = Vec::new();
    let _service = machine
        .service_deferred::<TakeCommand>("machine/take_command", move |request, responder| {
            sender.send(request.release).expect("the test listens");
            match request.release {
                true => waiting.push(responder),
                false => responder.send(&TakeCommandResponse { success: true, ..TakeCommandResponse::default() }),
            }
        })
        .expect("a service");
    let command = HeldCommand::acquire(&client, &TakeOptions::new("client")).expect("command");
    for what in ["the request", "the first renewal"] {
        assert_eq!(received.recv_timeout(PATIENCE), Ok(false), "{what}");
    }
    // Renewals come every 2 s: the next one is due while the client waits a second for the answer to its release.
    let _early_renewal = received.recv_timeout(Duration::from_millis(1_500));
    drop(command);
    client.shutdown();
    while !received.recv_timeout(PATIENCE).expect("the release") {}
    assert!(received.recv_timeout(Duration::from_secs(1)).is_err(), "renewed after the release");
    machine.shutdown();
}

#[test]
fn a_member_that_is_started_again_takes_its_role_back() {
    let cell = free_cell();
    let anna = Client::new(cell.domain(), "anna");
    let member = || anna.holder.lock().expect("not poisoned").interpolator;
    until("the interpolator has joined", || member() != [0; 16]);
    let (before, args) = (member(), RosArgs::default().with_domain_id(cell.domain().id()));
    let command = HeldCommand::acquire(&anna.node, &TakeOptions::new("anna")).expect("command");
    let cell = cell.with_interpolator(|interpolator| {
        interpolator.stop();
        AxisInterpolator::start(&args).expect("axis_interpolator")
    });
    until("another interpolator has joined", || ![[0; 16], before].contains(&member()));
    until("it homes", || anna.home() == GoalStatus::Succeeded);
    drop(command);
    anna.stop();
    cell.stop();
}

/// Every service, goal and topic that the graph shows of the three nodes, so that new ones are covered.
#[test]
fn nothing_that_a_stranger_sends_moves_or_changes_the_cell() {
    let cell = free_cell();
    let stranger = Client::new(cell.domain(), "stranger");
    until("the machine is heard", || stranger.stream().tick > 0);
    let nodes = [cell.machine.node(), cell.interpolator.node(), cell.planner.node()];
    let ours = nodes.map(|node| node.participant_guid().expect("a running node"));
    let is_ours = |guid: &[u8; 16]| ours.iter().any(|our| our[..12] == guid[..12]);
    let states = || {
        let active = |node: &&str| {
            let state = stranger.call::<GetState>(&format!("{node}/get_state"), &GetStateRequest::default());
            state.current_state.id == State::PRIMARY_STATE_ACTIVE
        };
        ["machine_sim", "axis_interpolator", "job_planner"].iter().all(active)
    };
    assert!(states());
    let before = stranger.stream();
    let parameters = cell.planner.node().parameters().names();
    let values = || parameters.iter().map(|name| cell.planner.node().parameters().get(name)).collect::<Vec<_>>();
    let values_before = values();

    // Stops are open: what would press the emergency stop or deactivate a node is tried at the end.
    let stops = ["/machine/estop", "/change_state"];
    let is_asked = |name: &str| {
        // With a lease or a role of its own it would be no stranger.
        let closed = [&stops[..], &["/take_command", "/join_command"]].concat();
        !closed.iter().any(|end| name.ends_with(end))
    };
    let mut services = stranger.node.discovered_services();
    services.retain(|service| is_asked(&service.name) && service.subscriptions.iter().any(|end| is_ours(&end.guid)));
    let requests = services.iter().map(|service| {
        let requests = stranger.node.raw_requests(&service.name, &service.type_name).expect("a writer");
        (service, requests)
    });
    let requests: Vec<_> = requests.collect();
    // Until the servers have met all of the writers.
    std::thread::sleep(Duration::from_secs(3));
    for (service, requests) in &requests {
        for kind in 0..hostile::KINDS {
            let body = hostile::body(&service.type_name, kind)
                .unwrap_or_else(|| panic!("no message of {} can be made", service.type_name));
            requests.send(&body).expect("it is sent");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let services: BTreeSet<String> = services.iter().map(|service| service.name.clone()).collect();
    let mut topics = BTreeSet::new();
    for topic in stranger.node.discovered_topics() {
        // A loader that nobody else speaks for may hold the machine, as any stop.
        let is_loader = topic.name == "/loader/state";
        if is_loader || !topic.subscriptions.iter().any(|reader| is_ours(&reader.guid)) {
            continue;
        }
        topics.insert(topic.name.clone());
        let publisher =
            stranger.node.raw_publisher(&topic.name, &topic.type_name, &Qos::latched(10)).expect("a publisher");
        let _matched = publisher.wait_matched(1, Duration::from_secs(5));
        for kind in 0..hostile::KINDS {
            let body = hostile::body(&topic.type_name, kind).expect("a known type");
            publisher.publish(&[&[0, 1, 0, 0], &body[..]].concat()).expect("it is sent");
        }
        std::thread::sleep(Duration::from_millis(60));
    }
    println!("{} services and {} topics", services.len(), topics.len());
    for wanted in ["/machine/reset", "/job_planner/load_job", "/axis_interpolator/jog/_action/send_goal"] {
        assert!(services.contains(wanted), "{wanted} is not in {services:?}");
    }
    for wanted in [
        "/machine/setpoints",
        "/machine/commands",
        "/machine/description",
        "/machine/stream",
        "/job_planner/plan",
        "/axis_interpolator/joint_trajectory",
    ] {
        assert!(topics.contains(wanted), "{wanted} is not in {topics:?}");
    }

    until("the refusals are an alarm", || stranger.has_alarm(86));
    std::thread::sleep(Duration::from_secs(1));
    let after = stranger.stream();
    assert!(after.tick > before.tick, "the machine goes on");
    assert_eq!((&after.setpoint_counts, &after.actual_counts), (&before.setpoint_counts, &before.actual_counts));
    assert!(after.holder.is_empty() && after.alarms == [86], "{after:?}");
    assert!(!*stranger.homed.lock().expect("not poisoned"), "no zero is known that was not");
    assert!(states(), "every node is active");
    assert_eq!(values(), values_before);

    // Stops are open to everybody, and only stops.
    let hold = stranger.call::<SetBool>("axis_interpolator/feed_hold", &SetBoolRequest { data: true });
    assert_eq!(hold.message, "nothing is being executed", "it is asked, and has nothing to hold");
    let stop = stranger.call::<Trigger>("job_planner/stop", &TriggerRequest::default());
    assert!(!stop.message.contains("command"), "{}", stop.message);
    assert!(stranger.call::<SetBool>("machine/estop", &SetBoolRequest { data: true }).success);
    until("the emergency stop is an alarm", || stranger.has_alarm(1));
    let released = stranger.call::<SetBool>("machine/estop", &SetBoolRequest { data: false });
    assert!(!released.success && released.message.contains("no client has command"), "{}", released.message);
    let command = HeldCommand::acquire(&stranger.node, &TakeOptions::new("operator")).expect("command");
    assert!(stranger.call::<SetBool>("machine/estop", &SetBoolRequest { data: false }).success);
    until("it is reset", || stranger.call::<Trigger>("machine/reset", &TriggerRequest::default()).success);
    assert_eq!(stranger.home(), GoalStatus::Succeeded);
    drop(command);
    stranger.stop();
    cell.stop();
}
