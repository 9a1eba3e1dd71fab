// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Actions, life cycle and diagnostics between two nodes of this process.
#![allow(clippy::print_stdout, reason = "a test shows what it measured")]

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::{Arc, Condvar, Mutex, MutexGuard, mpsc},
    time::{Duration, Instant},
};

use camwright_msgs::{
    Action,
    action_msgs::{
        msg::{GoalInfo, GoalStatusArray},
        srv::{CancelGoal, CancelGoalRequest, CancelGoalResponse},
    },
    camwright_msgs::action::{Home, HomeFeedback, HomeGoal, HomeResult},
    diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus},
    lifecycle_msgs::{
        msg::{Transition as TransitionMsg, TransitionEvent},
        srv::{
            ChangeState, ChangeStateRequest, GetAvailableStates, GetAvailableTransitions, GetState, GetStateRequest,
        },
    },
    unique_identifier_msgs::msg::UUID,
};
use camwright_ros::{
    ActionHandler, CancelOutcome, ClientGoal, GoalDecision, GoalHandle, GoalId, GoalStatus, Lifecycle,
    LifecycleCallbacks, LifecycleState, Node, NodeOptions, Qos, RosArgs, RosError, SpinThread, Transition,
    diagnostic_status,
};

use crate::support;

use support::Domain;

/// Generous: the machine may be building at the same time.
const PATIENCE: Duration = Duration::from_secs(20);

fn node(domain: &Domain, name: &str) -> (Node, SpinThread) {
    let node = Node::new(NodeOptions::new(name, &RosArgs::default().with_domain_id(domain.id()))).expect("a node");
    let thread = node.spin_in_thread().expect("a thread");
    (node, thread)
}

type HomingGoals = BTreeMap<GoalId, GoalHandle<Home>>;

/// Takes goals named after what is to become of them.
#[derive(Default, Clone)]
struct Homing {
    goals: Arc<Mutex<HomingGoals>>,
    accepted: Arc<Condvar>,
}

impl Homing {
    fn wish(goal: &HomeGoal) -> &str {
        goal.joints.first().map_or("", String::as_str)
    }

    fn goals(&self) -> MutexGuard<'_, HomingGoals> {
        self.goals.lock().expect("not poisoned")
    }

    /// Waits for the goal: a client may have its answer before the handler has the goal.
    fn named(&self, wish: &str) -> GoalHandle<Home> {
        let deadline = Instant::now() + PATIENCE;
        let mut goals = self.goals();
        loop {
            if let Some(goal) = goals.values().find(|goal| Self::wish(goal.goal()) == wish) {
                return goal.clone();
            }
            let left = deadline.saturating_duration_since(Instant::now());
            let (woken, timeout) = self.accepted.wait_timeout(goals, left).expect("not poisoned");
            goals = woken;
            if timeout.timed_out() {
                drop(goals);
                panic!("the handler has no goal '{wish}'");
            }
        }
    }
}

impl ActionHandler<Home> for Homing {
    fn goal(&mut self, _id: GoalId, goal: &HomeGoal) -> GoalDecision {
        match Self::wish(goal) {
            "reject" => GoalDecision::Reject("axis 'reject' does not exist".into()),
            "later" | "later no" | "never" => {
                let (decider, decision) = GoalDecision::later();
                let wish = Self::wish(goal).to_owned();
                std::thread::spawn(move || {
                    std::thread::sleep(Duration::from_millis(50));
                    match wish.as_str() {
                        "later" => decider.accept(),
                        "later no" => decider.reject("thought about it"),
                        _ => drop(decider),
                    }
                });
                decision
            }
            _ => GoalDecision::Accept,
        }
    }

    fn accepted(&mut self, goal: GoalHandle<Home>) {
        assert_eq!(goal.status(), GoalStatus::Executing);
        self.goals().insert(goal.id(), goal);
        self.accepted.notify_all();
    }

    fn cancel(&mut self, id: GoalId) -> bool {
        self.goals().get(&id).is_some_and(|goal| Self::wish(goal.goal()) != "stubborn")
    }
}

fn goal(wish: &str) -> HomeGoal {
    HomeGoal { joints: vec![wish.into()] }
}

fn result(message: &str) -> HomeResult {
    HomeResult { message: message.into(), ..Default::default() }
}

fn until(what: &str, condition: impl Fn() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !condition() {
        assert!(Instant::now() < deadline, "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn three_goals_run_at_once_and_each_has_its_own_end() {
    let domain = Domain::reserve();
    let (machine, _a) = node(&domain, "machine");
    let (operator, _b) = node(&domain, "operator");
    let homing = Homing::default();
    let server = machine.action_server::<Home>("~/home", homing.clone()).expect("a server");
    assert_eq!(server.action(), "/machine/home");
    let client = operator.action_client::<Home>("/machine/home").expect("a client");
    client.wait_for_server(PATIENCE).expect("the server is there");

    let (sender, feedback) = mpsc::channel();
    let send = |wish: &str| {
        let (sender, name) = (sender.clone(), wish.to_string());
        let sent = client.send_goal(
            goal(wish),
            move |feedback: HomeFeedback| {
                let _ = sender.send((name.clone(), feedback.step));
            },
            PATIENCE,
        );
        sent.expect("an answer")
    };
    let (first, second, third) = (send("first"), send("second"), send("third"));
    assert!(first.accepted() && second.accepted() && third.accepted());
    assert!(!send("reject").accepted());
    assert_eq!(server.active_goals().len(), 3);

    homing.named("second").feedback(&HomeFeedback { joint: "c".into(), step: "latch".into() });
    assert_eq!(feedback.recv_timeout(PATIENCE), Ok(("second".to_string(), "latch".to_string())));
    until("the state is published", || second.status() == GoalStatus::Executing);

    assert_eq!(third.cancel(PATIENCE).expect("an answer"), CancelOutcome::Accepted);
    until("the goal learns of it", || homing.named("third").is_canceling());
    assert!(!homing.named("first").is_canceling());
    assert_eq!(third.cancel(PATIENCE).expect("an answer"), CancelOutcome::Terminated, "it is ending already");

    // All three results are waited for while the goals still run, and come in another order.
    std::thread::scope(|scope| {
        let waits: Vec<_> = [first.clone(), second.clone(), third.clone()]
            .into_iter()
            .map(|goal| scope.spawn(move || goal.result(PATIENCE).expect("a result")))
            .collect();
        std::thread::sleep(Duration::from_millis(50));
        assert!(homing.named("third").canceled(result("stopped")));
        assert!(homing.named("first").abort(result("failed")));
        assert!(homing.named("second").succeed(result("homed")));
        assert!(!homing.named("second").abort(result("too late")), "a goal ends once");
        let ends: Vec<_> = waits.into_iter().map(|wait| wait.join().expect("no panic")).collect();
        assert_eq!(
            ends.iter().map(|(status, result)| (*status, result.message.as_str())).collect::<Vec<_>>(),
            [(GoalStatus::Aborted, "failed"), (GoalStatus::Succeeded, "homed"), (GoalStatus::Canceled, "stopped")]
        );
    });
    until("the ends are published unasked", || first.status() == GoalStatus::Aborted);
    let (status, late) = second.result(PATIENCE).expect("results are kept");
    assert_eq!((status, late.message.as_str()), (GoalStatus::Succeeded, "homed"));
    assert_eq!(second.cancel(PATIENCE).expect("an answer"), CancelOutcome::Terminated);
    assert!(server.active_goals().is_empty());
}

#[test]
fn a_thousand_goals_at_once_are_all_answered_and_those_rejected_are_counted() {
    let domain = Domain::reserve();
    let (machine, _a) = node(&domain, "machine");
    let (operator, _b) = node(&domain, "operator");
    let _diagnostics = machine.diagnostics("4711", || vec![diagnostic_status(DiagnosticStatus::OK, "", "ready", &[])]);
    let homing = Homing::default();
    let server = machine.action_server::<Home>("~/home", homing.clone()).expect("a server");
    let client = operator.action_client::<Home>("/machine/home").expect("a client");
    client.wait_for_server(PATIENCE).expect("the server is there");
    let (sender, reports) = mpsc::channel();
    let _reports = operator
        .subscribe("/diagnostics", &Qos::default_topic(), move |report: DiagnosticArray, _| drop(sender.send(report)))
        .expect("a subscription");

    for (wish, count) in [("reject", 1000), ("", 1000), ("reject", 300)] {
        let begun = Instant::now();
        let (sender, decisions) = mpsc::channel();
        for _ in 0..count {
            let sender = sender.clone();
            let decided = move |sent: ClientGoal<Home>| {
                let _ = sender.send(sent.accepted());
            };
            client.send_goal_with(goal(wish), drop, decided).expect("room");
        }
        let sent_s = begun.elapsed().as_secs_f64();
        for answered in 0..count {
            let accepted =
                decisions.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("{answered} of {count} answered"));
            assert_eq!(accepted, wish.is_empty());
        }
        println!("{count} goals '{wish}' sent in {sent_s:.3} s, answered in {:.3} s", begun.elapsed().as_secs_f64());
    }
    assert_eq!(server.active_goals().len(), 1000);
    let rejected = |report: &DiagnosticArray| {
        let status = report.status.iter().find(|status| status.name == "machine")?;
        Some(status.values.iter().find(|value| value.key == "goals rejected")?.value.clone())
    };
    let deadline = Instant::now() + PATIENCE;
    while reports.recv_timeout(PATIENCE).ok().and_then(|report| rejected(&report)).as_deref() != Some("1300") {
        assert!(Instant::now() < deadline, "1300 rejected goals are not reported");
    }
}

#[test]
fn a_decision_may_come_later_from_another_thread() {
    let domain = Domain::reserve();
    let (machine, _a) = node(&domain, "machine");
    let (operator, _b) = node(&domain, "operator");
    let homing = Homing::default();
    let _server = machine.action_server::<Home>("home", homing.clone()).expect("a server");
    let client = operator.action_client::<Home>("home").expect("a client");
    client.wait_for_server(PATIENCE).expect("the server is there");
    for (wish, accepted) in [("later", true), ("later no", false), ("never", false)] {
        let sent = client.send_goal(goal(wish), |_| {}, PATIENCE).expect("an answer");
        assert_eq!(sent.accepted(), accepted, "{wish}");
    }
    assert!(homing.named("later").succeed(result("homed")));
}

#[test]
fn the_state_of_goals_is_latched_for_late_joiners() {
    let domain = Domain::reserve();
    let (machine, _a) = node(&domain, "machine");
    let homing = Homing::default();
    let _server = machine.action_server::<Home>("home", homing.clone()).expect("a server");
    let (operator, _b) = node(&domain, "operator");
    let client = operator.action_client::<Home>("home").expect("a client");
    client.wait_for_server(PATIENCE).expect("the server is there");
    let sent = client.send_goal(goal("x"), |_| {}, PATIENCE).expect("an answer");
    homing.named("x").succeed(result("homed"));

    let (late, _c) = node(&domain, "late");
    let (sender, receiver) = mpsc::channel();
    let _status = late
        .subscribe::<GoalStatusArray>("home/_action/status", &Qos::action_status(), move |message, _| {
            let _ = sender.send(message);
        })
        .expect("a subscription");
    // RustDDS may send some older states before the last.
    let mut message = receiver.recv_timeout(PATIENCE).expect("the latched state");
    while let Ok(newer) = receiver.recv_timeout(Duration::from_millis(500)) {
        message = newer;
    }
    assert_eq!(message.status_list.len(), 1);
    assert_eq!(message.status_list[0].goal_info.goal_id.uuid, sent.id().0);
    assert_eq!(message.status_list[0].status, GoalStatus::Succeeded as i8);
}

#[test]
fn cancelling_follows_the_rules_of_action_msgs() {
    let domain = Domain::reserve();
    let (machine, _a) = node(&domain, "machine");
    let (operator, _b) = node(&domain, "operator");
    let homing = Homing::default();
    let _server = machine.action_server::<Home>("home", homing.clone()).expect("a server");
    let client = operator.action_client::<Home>("home").expect("a client");
    client.wait_for_server(PATIENCE).expect("the server is there");
    let cancel = operator.client::<CancelGoal>("home/_action/cancel_goal").expect("a client");
    cancel.wait_for_service(PATIENCE).expect("the service is there");
    let ask = |id: GoalId, sec: i32| {
        let mut goal_info = GoalInfo { goal_id: UUID { uuid: id.0 }, ..Default::default() };
        goal_info.stamp.sec = sec;
        cancel.call(&CancelGoalRequest { goal_info }, PATIENCE).expect("an answer")
    };
    let send = |wish: &str| client.send_goal(goal(wish), |_| {}, PATIENCE).expect("an answer");

    assert_eq!(ask(GoalId::random(), 0).return_code, CancelGoalResponse::ERROR_UNKNOWN_GOAL_ID);
    assert_eq!(ask(GoalId::default(), 0).return_code, CancelGoalResponse::ERROR_NONE, "nothing to cancel is no error");
    let stubborn = send("stubborn");
    assert_eq!(ask(stubborn.id(), 0).return_code, CancelGoalResponse::ERROR_REJECTED);
    assert!(!homing.named("stubborn").is_canceling());
    let (one, two) = (send("one"), send("two"));
    assert!(ask(GoalId::default(), 1).goals_canceling.is_empty(), "none was accepted in the second second of 1970");
    let response = ask(GoalId::default(), 0);
    assert_eq!(response.return_code, CancelGoalResponse::ERROR_NONE);
    let mut canceling: Vec<_> = response.goals_canceling.iter().map(|info| info.goal_id.uuid).collect();
    let mut expected = vec![one.id().0, two.id().0];
    canceling.sort_unstable();
    expected.sort_unstable();
    assert_eq!(canceling, expected, "all but the stubborn one");
    homing.named("one").succeed(result("was at its end"));
    assert_eq!(ask(one.id(), 0).return_code, CancelGoalResponse::ERROR_GOAL_TERMINATED);
}

#[test]
fn ids_in_use_are_refused_and_a_dropped_goal_is_aborted() {
    let domain = Domain::reserve();
    let (machine, _a) = node(&domain, "machine");
    let (operator, _b) = node(&domain, "operator");
    let homing = Homing::default();
    let _server = machine.action_server::<Home>("home", homing.clone()).expect("a server");
    let client = operator.action_client::<Home>("home").expect("a client");
    client.wait_for_server(PATIENCE).expect("the server is there");
    let sent = client.send_goal(goal("x"), |_| {}, PATIENCE).expect("an answer");

    let again = operator.client::<<Home as Action>::SendGoal>("home/_action/send_goal").expect("a client");
    again.wait_for_service(PATIENCE).expect("the service is there");
    let request = Home::send_goal_request(UUID { uuid: sent.id().0 }, goal("y"));
    let (accepted, _) = Home::split_send_goal_response(again.call(&request, PATIENCE).expect("an answer"));
    assert!(!accepted);

    homing.goals().clear();
    assert_eq!(sent.result(PATIENCE).expect("a result").0, GoalStatus::Aborted);

    // From a callback, without blocking.
    let (sender, receiver) = mpsc::channel();
    let inside = client.clone();
    operator.post(move || {
        let blocked = inside.send_goal(goal("z"), |_| {}, PATIENCE);
        assert!(matches!(blocked, Err(RosError::WouldDeadlock { .. })));
        let decided = move |goal: ClientGoal<Home>| {
            let id = goal.id();
            let ended = move |status, result: HomeResult| {
                let _ = sender.send((id, status, result.message));
            };
            goal.result_with(ended).expect("sent");
        };
        inside.send_goal_with(goal("z"), |_| {}, decided).expect("sent");
    });
    homing.named("z").succeed(result("homed"));
    let (id, status, message) = receiver.recv_timeout(PATIENCE).expect("the end");
    assert_eq!((id, status, message.as_str()), (homing.named("z").id(), GoalStatus::Succeeded, "homed"));
}

#[derive(Default)]
struct Managed {
    calls: Arc<Mutex<Vec<&'static str>>>,
    refuse_activation: Arc<Mutex<bool>>,
}

impl Managed {
    fn call(&self, name: &'static str) {
        self.calls.lock().expect("not poisoned").push(name);
    }
}

impl LifecycleCallbacks for Managed {
    fn configure(&mut self) -> Result<(), String> {
        self.call("configure");
        Ok(())
    }
    fn activate(&mut self) -> Result<(), String> {
        self.call("activate");
        if *self.refuse_activation.lock().expect("not poisoned") { Err("not homed".into()) } else { Ok(()) }
    }
    fn deactivate(&mut self) -> Result<(), String> {
        self.call("deactivate");
        Ok(())
    }
    fn cleanup(&mut self) -> Result<(), String> {
        self.call("cleanup");
        Ok(())
    }
    fn shutdown(&mut self) -> Result<(), String> {
        self.call("shutdown");
        Ok(())
    }
}

#[test]
fn a_managed_node_walks_its_life_by_service_and_by_itself() {
    let domain = Domain::reserve();
    let (managed, _a) = node(&domain, "managed");
    let (manager, _b) = node(&domain, "manager");
    let callbacks = Managed::default();
    let (calls, refuse) = (Arc::clone(&callbacks.calls), Arc::clone(&callbacks.refuse_activation));
    let life: Lifecycle = managed.lifecycle(callbacks).expect("a life cycle");
    assert_eq!(life.state(), LifecycleState::Unconfigured);

    let (sender, events) = mpsc::channel();
    let listening = manager
        .subscribe::<TransitionEvent>("/managed/transition_event", &Qos::default_topic(), move |event, _| {
            let _ = sender.send((event.start_state.label, event.transition.id, event.goal_state.label));
        })
        .expect("a subscription");
    let change = manager.client::<ChangeState>("/managed/change_state").expect("a client");
    change.wait_for_service(PATIENCE).expect("the service is there");
    assert!(listening.wait_matched(1, PATIENCE));
    let ask = |id: u8, label: &str| {
        let transition = TransitionMsg { id, label: label.into() };
        change.call(&ChangeStateRequest { transition }, PATIENCE).expect("an answer").success
    };
    assert!(!ask(3, ""), "not before it is configured");
    assert!(ask(1, ""));
    let event = |from: &str, id, to: &str| (from.to_string(), id, to.to_string());
    assert_eq!(events.recv_timeout(PATIENCE), Ok(event("unconfigured", 1, "configuring")));
    assert_eq!(events.recv_timeout(PATIENCE), Ok(event("configuring", 10, "inactive")));

    *refuse.lock().expect("not poisoned") = true;
    assert!(!ask(0, "activate"), "its callback refuses");
    assert_eq!(life.state(), LifecycleState::Inactive);
    *refuse.lock().expect("not poisoned") = false;
    life.trigger(Transition::Activate).expect("allowed");
    assert!(life.is_active());
    assert!(matches!(life.trigger(Transition::Cleanup), Err(RosError::Refused { .. })), "not while it is active");

    let state = manager.client::<GetState>("/managed/get_state").expect("a client");
    state.wait_for_service(PATIENCE).expect("the service is there");
    let now = state.call(&GetStateRequest::default(), PATIENCE).expect("an answer").current_state;
    assert_eq!((now.id, now.label.as_str()), (3, "active"));
    let available = manager.client::<GetAvailableTransitions>("/managed/get_available_transitions").expect("a client");
    available.wait_for_service(PATIENCE).expect("the service is there");
    let labels: Vec<String> = available
        .call(&Default::default(), PATIENCE)
        .expect("an answer")
        .available_transitions
        .into_iter()
        .map(|description| description.transition.label)
        .collect();
    assert_eq!(labels, ["deactivate", "shutdown"]);
    let states = manager.client::<GetAvailableStates>("/managed/get_available_states").expect("a client");
    states.wait_for_service(PATIENCE).expect("the service is there");
    assert_eq!(states.call(&Default::default(), PATIENCE).expect("an answer").available_states.len(), 11);

    assert!(ask(0, "deactivate") && ask(0, "cleanup") && ask(0, "shutdown"));
    assert!(life.wait_for(LifecycleState::Finalized, PATIENCE));
    let expected = ["configure", "activate", "activate", "deactivate", "cleanup", "shutdown"];
    assert_eq!(*calls.lock().expect("not poisoned"), expected);
}

/// Two cells of one domain share `/diagnostics`: names and hardware of nodes in namespaces differ.
#[test]
fn diagnostics_of_two_namespaces_do_not_collide() {
    let domain = Domain::reserve();
    let (monitor, _spinning) = node(&domain, "monitor");
    let (sender, receiver) = mpsc::channel();
    let listening = monitor
        .subscribe::<DiagnosticArray>("/diagnostics", &Qos::default_topic().keep_last(100), move |message, _| {
            let _ = sender.send(message);
        })
        .expect("a subscription");
    let report =
        || [("", "all is well"), ("drives", "at rest")].map(|(part, text)| diagnostic_status(0, part, text, &[]));
    let cells = ["/left", "/right"].map(|namespace| {
        let args = RosArgs::default().with_domain_id(domain.id()).with_namespace(namespace);
        let machine = Node::new(NodeOptions::new("machine", &args)).expect("a node");
        let spinning = machine.spin_in_thread().expect("a thread");
        (machine.diagnostics("grinder", move || report().to_vec()).expect("diagnostics"), machine, spinning)
    });
    assert!(listening.wait_matched(2, PATIENCE));
    let mut found = BTreeSet::new();
    while found.len() < 4 {
        let message: DiagnosticArray = receiver.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("only {found:?}"));
        found.extend(message.status.into_iter().map(|status| (status.name, status.hardware_id)));
    }
    let wanted = [
        ("/left/machine", "/left/grinder"),
        ("/left/machine: drives", "/left/grinder"),
        ("/right/machine", "/right/grinder"),
        ("/right/machine: drives", "/right/grinder"),
    ];
    assert_eq!(found, wanted.map(|(name, hardware)| (name.to_owned(), hardware.to_owned())).into());
    drop(cells);
}

#[test]
fn diagnostics_come_every_second_and_at_once_when_asked() {
    let domain = Domain::reserve();
    let (machine, _a) = node(&domain, "machine");
    let (monitor, _b) = node(&domain, "monitor");
    let (sender, receiver) = mpsc::channel();
    let listening = monitor
        .subscribe::<DiagnosticArray>("/diagnostics", &Qos::default_topic(), move |message, _| {
            let _ = sender.send((Instant::now(), message));
        })
        .expect("a subscription");
    let report = || {
        vec![
            diagnostic_status(DiagnosticStatus::OK, "", "all is well", &[]),
            diagnostic_status(DiagnosticStatus::WARN, "x_axis", "runs warm", &[("temperature_c", "61".into())]),
        ]
    };
    let diagnostics = machine.diagnostics("grinder-1", report).expect("diagnostics");
    assert!(listening.wait_matched(1, PATIENCE));
    let (first, message) = receiver.recv_timeout(PATIENCE).expect("a report");
    assert_eq!(message.status[0].name, "machine");
    assert_eq!(
        (message.status[1].name.as_str(), message.status[1].hardware_id.as_str()),
        ("machine: x_axis", "grinder-1")
    );
    assert_eq!(message.status[1].values[0].key, "temperature_c");
    assert!(message.header.stamp.sec > 1_700_000_000);
    receiver.recv_timeout(PATIENCE).expect("a second report without being asked for");
    // One that is asked for does not wait for its second: a hundred of them come in much less than a hundred seconds.
    for _ in 0..100 {
        while receiver.try_recv().is_ok() {}
        diagnostics.report_now();
        receiver.recv_timeout(PATIENCE).expect("a report");
    }
    assert!(first.elapsed() < Duration::from_secs(90), "{:?}", first.elapsed());
}
