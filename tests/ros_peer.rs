//! A node of ours and a real ROS 2 Jazzy node (rclpy, Fast DDS) meet: graph, topics, services, parameters, life cycle, actions in
//! both directions, time, and the end.

use std::{
    sync::{Arc, Mutex, mpsc},
    time::{Duration, Instant},
};

use camwright_msgs::{
    camwright_msgs::action::{Home, HomeGoal, HomeResult},
    rcl_interfaces::{
        msg::ParameterValue,
        srv::{GetParameters, GetParametersRequest, GetParametersResponse},
    },
    rosgraph_msgs::msg::Clock,
    std_msgs::msg::String as Text,
    std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerResponse},
};
use camwright_nodes::ros::{
    ActionHandler, CancelOutcome, GoalDecision, GoalHandle, GoalId, GoalStatus, LifecycleCallbacks, LifecycleState,
    Node, NodeOptions, Parameter, Qos, RosArgs, SpinThread,
};
use serde_json::{Value, json};

mod support;

use support::{Domain, PATIENCE, Peer, peer_env};

fn start(domain: &Domain, parameters: Vec<Parameter>) -> (Node, SpinThread) {
    let words: Vec<String> = ["--ros-args", "-r", "__ns:=/cell"].iter().map(ToString::to_string).collect();
    let (args, _) = RosArgs::parse_with(&words, |_| None).expect("valid");
    let node = Node::new(NodeOptions::new("machine", &args.with_domain_id(domain.id())).parameters(parameters));
    let node = node.expect("a node");
    let thread = node.spin_in_thread().expect("a thread");
    (node, thread)
}

fn strings(value: &Value) -> Vec<&str> {
    value.as_array().map(|list| list.iter().filter_map(Value::as_str).collect()).unwrap_or_default()
}

#[test]
fn a_real_peer_sees_names_types_and_qualities_and_hears_and_is_heard() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (node, _spin) = start(&domain, vec![]);
    let latched = node.publisher::<Text>("~/description", &Qos::latched(1)).expect("a publisher");
    latched.publish(&Text { data: "said before anybody came".into() }).expect("published");
    let echo = node.publisher::<Text>("echo", &Qos::default_topic()).expect("a publisher");
    let _heard = node
        .subscribe::<Text>("speech", &Qos::default_topic(), move |text, _| echo.publish(&text).expect("published"))
        .expect("a subscription");

    let mut peer = Peer::start(env, &domain, "visitor");
    peer.ask("wait_node", json!({ "name": "machine", "namespace": "/cell" }));
    peer.ask(
        "subscribe",
        json!({ "topic": "/cell/machine/description", "type": "std_msgs/msg/String", "qos": "latched" }),
    );
    assert_eq!(peer.message("/cell/machine/description")["data"], "said before anybody came");

    let graph = peer.ask("graph", json!({}));
    assert!(strings(&graph["nodes"]).contains(&"/cell/machine"), "{graph}");
    assert_eq!(graph["topics"]["/cell/echo"], json!(["std_msgs/msg/String"]));
    assert_eq!(graph["topics"]["/rosout"], json!(["rcl_interfaces/msg/Log"]));
    for service in ["get_parameters", "set_parameters_atomically", "describe_parameters", "get_type_description"] {
        assert!(graph["services"].get(format!("/cell/machine/{service}")).is_some(), "{service} is missing: {graph}");
    }
    let ends = peer.ask("endpoints", json!({ "topic": "/cell/machine/description" }));
    let publisher = &ends["publishers"][0];
    assert_eq!(publisher["node"], "/cell/machine");
    assert_eq!((&publisher["reliability"], &publisher["durability"]), (&json!("RELIABLE"), &json!("TRANSIENT_LOCAL")));

    peer.ask("subscribe", json!({ "topic": "/cell/echo", "type": "std_msgs/msg/String" }));
    peer.ask("wait_publishers", json!({ "topic": "/cell/echo" }));
    // Waits until our echo has matched the peer, so that the first word comes back.
    let deadline = Instant::now() + PATIENCE;
    while node.subscription_count("echo").expect("valid") == 0 {
        assert!(Instant::now() < deadline, "the peer's subscription is not found");
        std::thread::sleep(Duration::from_millis(10));
    }
    peer.ask("advertise", json!({ "topic": "/cell/speech", "type": "std_msgs/msg/String" }));
    peer.ask("wait_matched", json!({ "topic": "/cell/speech" }));
    for word in ["Nocken", "Schleifen ÄÖÜ", ""] {
        peer.ask("publish", json!({ "topic": "/cell/speech", "data": { "data": word } }));
        assert_eq!(peer.message("/cell/echo")["data"], word);
    }
}

#[test]
fn services_work_in_both_directions() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (node, _spin) = start(&domain, vec![]);
    let _reset = node
        .service::<Trigger>("~/reset", |_| TriggerResponse { success: true, message: "reset".into() })
        .expect("a service");
    let mut peer = Peer::start(env, &domain, "visitor");
    for _ in 0..3 {
        let response = peer.call("/cell/machine/reset", "std_srvs/srv/Trigger", json!({}));
        assert_eq!(response, json!({ "success": true, "message": "reset" }));
    }
    let answer = json!({ "success": true, "message": "on" });
    peer.ask("serve", json!({ "service": "/light", "type": "std_srvs/srv/SetBool", "response": answer }));
    let light = node.client::<SetBool>("/light").expect("a client");
    light.wait_for_service(PATIENCE).expect("the service is there");
    let response = light.call(&SetBoolRequest { data: true }, PATIENCE).expect("an answer");
    assert!(response.success && response.message == "on");
    assert_eq!(peer.event("request", |_| true)["data"], json!({ "data": true }));
}

/// Lengths of text on both sides of what a datagram takes, of an Ethernet frame and of UDP.
const LENGTHS: [usize; 8] = [900, 1020, 1100, 1400, 9000, 57_330, 66_000, 300_000];

#[test]
fn long_requests_and_replies_arrive_whole() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (node, _spin) = start(&domain, vec![]);
    let text = |length: usize| "0123456789".chars().cycle().take(length).collect::<String>();
    let echo = move |request: GetParametersRequest| {
        let answer = |name: &String| ParameterValue { string_value: name.clone(), ..ParameterValue::default() };
        GetParametersResponse { values: request.names.iter().map(answer).collect() }
    };
    let _echo = node.service::<GetParameters>("~/echo", echo).expect("a service");

    let mut peer = Peer::start(env, &domain, "visitor");
    for length in LENGTHS {
        let request = json!({ "names": [text(length)] });
        let response = peer.call("/cell/machine/echo", "rcl_interfaces/srv/GetParameters", request);
        assert!(response["values"][0]["string_value"] == json!(text(length)), "{length} to a real client");
    }
    let (client_node, _client_spin) = start(&domain, vec![]);
    let client = client_node.client::<GetParameters>("/cell/machine/echo").expect("a client");
    client.wait_for_service(PATIENCE).expect("the service is there");
    for length in LENGTHS {
        let response = client.call(&GetParametersRequest { names: vec![text(length)] }, PATIENCE);
        assert!(response.expect("an answer").values[0].string_value == text(length), "{length} to our client");
    }
    let served = json!({ "service": "/served", "type": "rcl_interfaces/srv/GetParameters", "response": {} });
    peer.ask("serve", served);
    let client = client_node.client::<GetParameters>("/served").expect("a client");
    client.wait_for_service(PATIENCE).expect("the service is there");
    for length in LENGTHS {
        client.call(&GetParametersRequest { names: vec![text(length)] }, PATIENCE).expect("an answer");
        let request = peer.event("request", |_| true);
        assert!(request["data"]["names"] == json!([text(length)]), "{length} to a real server");
    }
}

#[test]
fn a_real_peer_reads_sets_and_describes_parameters() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let parameters = vec![
        Parameter::double("feed_override", 1.0).describe("factor on the feed").range(0.0, 1.0),
        Parameter::integer("axes", 2).read_only(),
    ];
    let (node, _spin) = start(&domain, parameters);
    let mut peer = Peer::start(env, &domain, "visitor");
    peer.ask("subscribe", json!({ "topic": "/parameter_events", "type": "rcl_interfaces/msg/ParameterEvent" }));
    let call = |peer: &mut Peer, service: &str, kind: &str, request: Value| {
        peer.call(&format!("/cell/machine/{service}"), &format!("rcl_interfaces/srv/{kind}"), request)
    };
    let names = json!({ "names": ["feed_override", "axes", "use_sim_time", "unknown"] });
    let values = call(&mut peer, "get_parameters", "GetParameters", names.clone());
    let types: Vec<_> =
        values["values"].as_array().expect("a list").iter().map(|value| value["type"].clone()).collect();
    assert_eq!(types, [3, 2, 1, 0]);
    let set = |name: &str, value: Value| json!({ "name": name, "value": value });
    let request = json!({ "parameters": [
        set("feed_override", json!({ "type": 3, "double_value": 0.5 })),
        set("feed_override", json!({ "type": 3, "double_value": 1.5 })),
        set("axes", json!({ "type": 2, "integer_value": 3 })),
    ] });
    let results = call(&mut peer, "set_parameters", "SetParameters", request);
    let outcome: Vec<_> =
        results["results"].as_array().expect("a list").iter().map(|result| result["successful"].clone()).collect();
    assert_eq!(outcome, [true, false, false]);
    assert!((node.parameters().double("feed_override") - 0.5).abs() < 1e-12);
    let event = peer.message_where("/parameter_events", |event| {
        event["node"] == "/cell/machine" && event["changed_parameters"] != json!([])
    });
    assert_eq!(event["changed_parameters"][0]["name"], "feed_override");
    let described = call(&mut peer, "describe_parameters", "DescribeParameters", names);
    let first = &described["descriptors"][0];
    assert_eq!(
        (&first["description"], &first["floating_point_range"][0]["to_value"]),
        (&json!("factor on the feed"), &json!(1.0))
    );
    assert_eq!(described["descriptors"][1]["read_only"], true);
}

struct Nothing;
impl LifecycleCallbacks for Nothing {}

#[test]
fn a_real_peer_manages_the_life_cycle() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (node, _spin) = start(&domain, vec![]);
    let life = node.lifecycle(Nothing).expect("a life cycle");
    let mut peer = Peer::start(env, &domain, "manager");
    let topic = "/cell/machine/transition_event";
    peer.ask("subscribe", json!({ "topic": topic, "type": "lifecycle_msgs/msg/TransitionEvent" }));
    peer.ask("wait_publishers", json!({ "topic": topic }));
    let mut change = |transition: Value| {
        let request = json!({ "transition": transition });
        peer.call("/cell/machine/change_state", "lifecycle_msgs/srv/ChangeState", request)["success"].take()
    };
    assert_eq!(change(json!({ "id": 3 })), false, "not before it is configured");
    assert_eq!(change(json!({ "id": 1, "label": "configure" })), true);
    assert_eq!(change(json!({ "label": "activate" })), true);
    assert_eq!(life.state(), LifecycleState::Active);
    let goal_states: Vec<Value> = (0..4).map(|_| peer.message(topic)["goal_state"]["label"].take()).collect();
    assert_eq!(goal_states, ["configuring", "inactive", "activating", "active"]);
    let state = peer.call("/cell/machine/get_state", "lifecycle_msgs/srv/GetState", json!({}));
    assert_eq!(state["current_state"], json!({ "id": 3, "label": "active" }));
}

/// Ends each goal when it is told to.
#[derive(Clone, Default)]
struct Homing {
    goals: Arc<Mutex<Vec<GoalHandle<Home>>>>,
}

impl ActionHandler<Home> for Homing {
    fn goal(&mut self, _: GoalId, goal: &HomeGoal) -> GoalDecision {
        if goal.joints.is_empty() { GoalDecision::Reject("no joint is named".into()) } else { GoalDecision::Accept }
    }
    fn accepted(&mut self, goal: GoalHandle<Home>) {
        goal.feedback(&camwright_msgs::camwright_msgs::action::HomeFeedback {
            joint: goal.goal().joints[0].clone(),
            step: "search".into(),
        });
        self.goals.lock().expect("not poisoned").push(goal);
    }
    fn cancel(&mut self, _: GoalId) -> bool {
        true
    }
}

#[test]
fn a_real_client_runs_three_goals_at_once_and_cancels_one() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (node, _spin) = start(&domain, vec![]);
    let homing = Homing::default();
    let _server = node.action_server::<Home>("~/home", homing.clone()).expect("a server");
    let mut peer = Peer::start(env, &domain, "operator");
    let send = |peer: &mut Peer, joints: &[&str]| {
        let order = json!({
            "action": "/cell/machine/home", "type": "camwright_msgs/action/Home", "goal": { "joints": joints }
        });
        peer.ask("send_goal", order)
    };
    assert_eq!(send(&mut peer, &[])["accepted"], false);
    let goals: Vec<Value> =
        ["x_axis", "z_axis", "c_axis"].iter().map(|joint| send(&mut peer, &[joint])["goal"].take()).collect();
    for goal in &goals {
        assert_eq!(peer.event("feedback", |event| event["goal"] == *goal)["data"]["step"], "search");
    }
    // All results are asked for while the goals run.
    let asked: Vec<u64> = goals.iter().map(|goal| peer.order("result", json!({ "goal": goal }))).collect();
    let canceled = peer.ask("cancel", json!({ "goal": goals[1] }));
    assert_eq!((&canceled["return_code"], &canceled["goals"]), (&json!(0), &json!([goals[1]])));
    let handles = homing.goals.lock().expect("not poisoned").clone();
    assert_eq!(handles.iter().map(GoalHandle::is_canceling).collect::<Vec<_>>(), [false, true, false]);
    let result = |message: &str| HomeResult { success: true, message: message.into(), ..Default::default() };
    handles[2].abort(result("no switch"));
    handles[0].succeed(result("homed"));
    handles[1].canceled(result("stopped"));
    let ends: Vec<(Value, Value)> = asked
        .into_iter()
        .map(|order| peer.answer(order).expect("a result"))
        .map(|mut end| (end["status"].take(), end["result"]["message"].take()))
        .collect();
    let expected = [(4, "homed"), (5, "stopped"), (6, "no switch")];
    assert_eq!(ends, expected.map(|(status, message)| (json!(status), json!(message))));
    let late = peer.ask("result", json!({ "goal": goals[0] }));
    assert_eq!(late["result"]["message"], "homed", "results are kept");
}

#[test]
fn our_client_runs_and_cancels_goals_of_a_real_server() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (node, _spin) = start(&domain, vec![]);
    let mut peer = Peer::start(env, &domain, "server");
    let kind = "camwright_msgs/action/Home";
    let feedback = json!([{ "joint": "x_axis", "step": "search" }, { "joint": "x_axis", "step": "latch" }]);
    let result = json!({ "success": true, "message": "homed" });
    peer.ask("serve_action", json!({ "action": "/quick", "type": kind, "feedback": feedback, "result": result }));
    peer.ask("serve_action", json!({ "action": "/slow", "type": kind, "hold": true, "result": result }));
    peer.ask("serve_action", json!({ "action": "/never", "type": kind, "reject": true }));
    let goal = HomeGoal { joints: vec!["x_axis".into()] };
    let (sender, steps) = mpsc::channel();
    let quick = node.action_client::<Home>("/quick").expect("a client");
    quick.wait_for_server(PATIENCE).expect("the server is there");
    let told = move |feedback: camwright_msgs::camwright_msgs::action::HomeFeedback| {
        let _ = sender.send(feedback.step);
    };
    let sent = quick.send_goal(goal.clone(), told, PATIENCE).expect("an answer");
    assert!(sent.accepted());
    let (status, result) = sent.result(PATIENCE).expect("a result");
    assert_eq!((status, result.message.as_str()), (GoalStatus::Succeeded, "homed"));
    assert_eq!(steps.recv_timeout(PATIENCE).as_deref(), Ok("search"));
    assert_eq!(steps.recv_timeout(PATIENCE).as_deref(), Ok("latch"));

    let slow = node.action_client::<Home>("/slow").expect("a client");
    slow.wait_for_server(PATIENCE).expect("the server is there");
    let sent = slow.send_goal(goal.clone(), |_| {}, PATIENCE).expect("an answer");
    assert_eq!(sent.cancel(PATIENCE).expect("an answer"), CancelOutcome::Accepted);
    assert_eq!(sent.result(PATIENCE).expect("a result").0, GoalStatus::Canceled);

    let never = node.action_client::<Home>("/never").expect("a client");
    never.wait_for_server(PATIENCE).expect("the server is there");
    assert!(!never.send_goal(goal, |_| {}, PATIENCE).expect("an answer").accepted());
}

#[test]
fn a_real_peer_follows_our_clock_and_forgets_us_when_we_go() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (node, spin) = start(&domain, vec![]);
    let clock = node.publisher::<Clock>("/clock", &Qos::default_topic()).expect("a publisher");
    let mut peer = Peer::start_with(env, &domain, &["follower", "--sim-time"]);
    assert!(clock.wait_matched(1, PATIENCE));
    let mut message = Clock::default();
    message.clock.sec = 77;
    let deadline = Instant::now() + PATIENCE;
    while peer.ask("now", json!({}))["now"].as_i64().is_none_or(|now| now < 77_000_000_000) {
        assert!(Instant::now() < deadline, "the peer's clock does not follow");
        clock.publish(&message).expect("published");
        std::thread::sleep(Duration::from_millis(20));
    }
    peer.ask("wait_node", json!({ "name": "machine", "namespace": "/cell" }));
    drop(spin);
    node.shutdown();
    // The lease that would otherwise end it is 50 s.
    let gone = Instant::now() + Duration::from_secs(10);
    loop {
        let graph = peer.ask("graph", json!({}));
        let left = strings(&graph["nodes"]).contains(&"/cell/machine")
            || graph["services"].get("/cell/machine/get_parameters").is_some();
        if !left {
            break;
        }
        assert!(Instant::now() < gone, "still known: {graph}");
        std::thread::sleep(Duration::from_millis(50));
    }
}
