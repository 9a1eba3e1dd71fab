// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Events of service calls in a bag: recorded while they are enabled, with definitions that other readers understand.

use crate::bag_judges;
use crate::recorder::{ACTIVATE, CONFIGURE, DEACTIVATE, RecorderUnderTest, args, directory, messages, until};
use crate::support::{Domain, Guarded, PATIENCE, peer_env};

use camwright_bag::Bag;
use camwright_bag::check::check;
use camwright_msgs::by_type_name;
use camwright_msgs::camwright_msgs::action::{Home, HomeGoal, HomeResult};
use camwright_msgs::cdr::message_from_sample;
use camwright_msgs::rcl_interfaces::msg::ListParametersResult;
use camwright_msgs::rcl_interfaces::srv::{ListParameters, ListParametersRequest, ListParametersResponse};
use camwright_msgs::service_msgs::msg::ServiceEventInfo;
use camwright_ros::{GoalHandle, Node, NodeOptions, SpinThread};
use serde::Deserialize;
use serde_json::{Value, json};
use std::io::Write;

const LIST: &str = "/server/list/_service_event";
const LIST_EVENT: &str = "rcl_interfaces/srv/ListParameters_Event";
const SEND_GOAL: &str = "/server/home/_action/send_goal/_service_event";
const SEND_GOAL_EVENT: &str = "camwright_msgs/action/Home_SendGoal_Event";

/// Event of a call of [`ListParameters`].
#[derive(Debug, Deserialize)]
struct ListEvent {
    info: ServiceEventInfo,
    request: Vec<ListParametersRequest>,
    response: Vec<ListParametersResponse>,
}

fn node(domain: &Domain, name: &str, parameters: &[&str]) -> (Node, SpinThread) {
    let words: Vec<String> = parameters.iter().map(|parameter| format!("{parameter}:=contents")).collect();
    let mut line = vec!["--ros-args"];
    line.extend(words.iter().flat_map(|word| ["-p", word.as_str()]));
    let node = Node::new(NodeOptions::new(name, &args(domain, &line))).expect("it joins the graph");
    let spinning = node.spin_in_thread().expect("there are threads");
    (node, spinning)
}

#[test]
fn events_of_calls_are_in_the_bag_and_others_decode_them() {
    let domain = Domain::reserve();
    let directory = directory("service-events");
    let bag = directory.join("run");
    let recorder = ["--ros-args", "-p", &format!("bag_dir:={}", bag.display()), "-p", "include_feedback:=true"];
    let mut cell = RecorderUnderTest::new(&domain, &recorder);
    let enabled = ["service_configure_introspection", "action_server_configure_introspection"];
    let (server, _server_spins) = node(&domain, "server", &enabled);
    let answer = |request: ListParametersRequest| ListParametersResponse {
        result: ListParametersResult { names: request.prefixes, prefixes: vec![request.depth.to_string()] },
    };
    let _list = server.service::<ListParameters>("~/list", answer).expect("good name");
    let at_once = |goal: GoalHandle<Home>| {
        goal.succeed(HomeResult::default());
    };
    let _home = server.action_server::<Home>("~/home", at_once).expect("good name");
    let (user, _user_spins) = node(&domain, "user", &["client_configure_introspection"]);
    let list = user.client::<ListParameters>("/server/list").expect("good name");
    let home = user.action_client::<Home>("/server/home").expect("good name");
    assert!(cell.change_state(CONFIGURE) && cell.change_state(ACTIVATE));
    cell.wait_for_topics(&[LIST, SEND_GOAL]);
    list.wait_for_service(PATIENCE).expect("the service is there");
    home.wait_for_server(PATIENCE).expect("the action is there");

    let mut depth = 0;
    let mut call = || {
        depth += 1;
        let request = ListParametersRequest { prefixes: vec!["odd".into()], depth };
        list.call(&request, PATIENCE).expect("an answer");
        depth
    };
    // The recorder may match a publisher before the publisher matches the recorder; then both have matched when events of both are there.
    until("both sides are recorded", || {
        let calls = call();
        cell.written(LIST) > 2 * calls
    });
    until("events of the action are recorded", || {
        home.send_goal(HomeGoal { joints: vec!["x_axis".into()] }, |_| {}, PATIENCE).expect("an answer");
        cell.written(SEND_GOAL) > 0
    });
    let last = call();
    // The server publishes that a response was sent before it handles the next request.
    call();
    assert!(cell.change_state(DEACTIVATE));
    cell.end();

    let report = check(&bag).expect("there is a bag");
    assert_eq!(report.findings, [], "{}", report.to_text());
    let read = Bag::open(&bag).expect("it is closed");
    for (topic, type_name) in [(LIST, LIST_EVENT), (SEND_GOAL, SEND_GOAL_EVENT)] {
        let recorded = read.topics().iter().find(|recorded| recorded.name == topic).expect("it was written");
        assert_eq!(recorded.type_name, type_name);
        assert_eq!(recorded.definition, by_type_name(type_name).expect("a known type").schema);
    }
    let samples = messages(&read, LIST);
    let events = samples.iter().map(|sample| message_from_sample::<ListEvent>(&sample.data).expect("an event"));
    let of_last: Vec<ListEvent> =
        events.filter(|event| u64::try_from(event.info.sequence_number) == Ok(last)).collect();
    let mut types: Vec<u8> = of_last.iter().map(|event| event.info.event_type).collect();
    types.sort_unstable();
    assert_eq!(types, [0, 1, 2, 3], "{of_last:?}");
    for event in &of_last {
        assert_eq!(event.info.client_gid, of_last[0].info.client_gid);
        let is_request = event.info.event_type <= ServiceEventInfo::REQUEST_RECEIVED;
        assert_eq!((event.request.len(), event.response.len()), if is_request { (1, 0) } else { (0, 1) });
        assert!(event.request.iter().all(|request| request.depth == last && request.prefixes == ["odd"]), "{event:?}");
        assert!(event.response.iter().all(|response| response.result.prefixes == [last.to_string()]), "{event:?}");
    }

    if let Some(counts) = bag_judges::foxglove_counts(&bag) {
        assert_eq!(counts["topics"][LIST], json!(samples.len()));
        assert_eq!(counts["topics"][SEND_GOAL], json!(messages(&read, SEND_GOAL).len()));
    }
    // They know no types of services and actions, but such topics do not keep them from the others.
    if let Some(counts) = bag_judges::rosbags_counts_without(&["_Event", "_FeedbackMessage"], &bag, &domain) {
        assert_eq!(counts["topics"][LIST]["count"], json!(samples.len()));
        assert!(counts["topics"]["/run_logger/status"]["count"].as_u64() > Some(0), "{counts}");
    }
    decoded_by_rclpy(&domain, LIST_EVENT, &samples.iter().map(|sample| sample.data.as_slice()).collect::<Vec<_>>());
    let goals = messages(&read, SEND_GOAL);
    decoded_by_rclpy(&domain, SEND_GOAL_EVENT, &goals.iter().map(|goal| goal.data.as_slice()).collect::<Vec<_>>());
    std::fs::remove_dir_all(directory).expect("it is ours");
}

/// Real rclpy reads the samples with its own types, as `ros2 bag play` needs them.
fn decoded_by_rclpy(domain: &Domain, type_name: &str, samples: &[&[u8]]) {
    let Some(env) = peer_env() else { return };
    let mut process = Guarded::start("wire.py", &mut env.python("wire.py", domain));
    let mut stdin = process.take_stdin();
    for sample in samples {
        let cdr: String = sample.iter().map(|octet| format!("{octet:02x}")).collect();
        writeln!(stdin, "{}", json!({ "type": type_name, "cdr": cdr })).expect("rclpy reads");
        let line = process.line(PATIENCE).unwrap_or_else(|| panic!("rclpy ended{}", process.complaint()));
        let plain = serde_json::from_str::<Value>(&line).expect("rclpy answers in JSON")["plain"].take();
        let count = |part: &str| plain[part].as_array().map(Vec::len);
        let is_request = plain["info"]["event_type"].as_u64().expect("a number") <= 1;
        let expected = if is_request { (Some(1), Some(0)) } else { (Some(0), Some(1)) };
        assert_eq!((count("request"), count("response")), expected, "{plain}");
    }
}
