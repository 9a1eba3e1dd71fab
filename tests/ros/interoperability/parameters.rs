// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Parameters: the six services, events, files, and the command line.

use super::ground::{Ground, strings};
use crate::support::{Peer, repository};
use camwright_ros::{NodeOptions, Parameter, ParameterValue, RosArgs};
use serde_json::{Value, json};
use std::io::Write as _;

fn declared() -> Vec<Parameter> {
    vec![
        Parameter::double("infeed_um_rev", 5.0).describe("infeed per revolution (µm)").range(0.1, 50.0),
        Parameter::string("job", "four_lobes"),
        Parameter::integer("lobes", 4).read_only(),
        Parameter::double("group.depth", 0.25),
        Parameter::optional("group.law", ParameterValue::String(String::new())).choices(&["constant", "optimal"]),
        Parameter::optional("group.speed_rpm", ParameterValue::Double(0.0)).range(0.1, 100.0),
    ]
}

fn ask(peer: &mut Peer, service: &str, request: Value) -> Value {
    let camel: String = service.split('_').map(|word| word[..1].to_uppercase() + &word[1..]).collect();
    peer.call(&format!("/planner/{service}"), &format!("rcl_interfaces/srv/{camel}"), request)
}

fn double(name: &str, value: f64) -> Value {
    json!({ "name": name, "value": { "type": 3, "double_value": value } })
}

fn set(peer: &mut Peer, parameter: Value) -> Value {
    ask(peer, "set_parameters", json!({ "parameters": [parameter] }))["results"][0].take()
}

pub fn served(ground: &mut Ground<'_>) {
    let (node, _spin) = ground.node_with("planner", "--ros-args -p job:=other", declared());
    let now = |name: &str| node.parameters().get(name);
    let mut peer = ground.peer("peer");
    ground.check("list, types and values", || {
        let listed = ask(&mut peer, "list_parameters", json!({}));
        let names = strings(&listed["result"]["names"]);
        for name in ["infeed_um_rev", "job", "lobes", "use_sim_time", "group.depth"] {
            assert!(names.contains(&name), "{name} in {names:?}");
        }
        assert_eq!(strings(&listed["result"]["prefixes"]), ["group"]);
        let read = ask(&mut peer, "get_parameters", json!({ "names": ["infeed_um_rev", "job", "nobody"] }));
        assert_eq!(read["values"][0]["double_value"], 5.0);
        assert_eq!(read["values"][1]["string_value"], "other");
        let types =
            ask(&mut peer, "get_parameter_types", json!({ "names": ["infeed_um_rev", "job", "lobes", "nobody"] }));
        assert_eq!(types["types"], json!([3, 4, 2, 0]));
    });
    ground.check("descriptions, ranges, read-only", || {
        let described = ask(&mut peer, "describe_parameters", json!({ "names": ["infeed_um_rev", "lobes"] }));
        let [infeed, lobes] = [0, 1].map(|index| &described["descriptors"][index]);
        assert_eq!(infeed["description"], "infeed per revolution (µm)");
        assert_eq!(infeed["floating_point_range"][0]["to_value"], 50.0);
        assert_eq!((&infeed["read_only"], &lobes["read_only"]), (&json!(false), &json!(true)));
    });
    ground.check("set, and refused with a reason", || {
        assert_eq!(set(&mut peer, double("infeed_um_rev", 7.5))["successful"], true);
        assert_eq!(now("infeed_um_rev"), Some(ParameterValue::Double(7.5)));
        for (wrong, expected) in [
            (double("infeed_um_rev", 51.0), "50"),
            (json!({ "name": "lobes", "value": { "type": 2, "integer_value": 5 } }), "lobes"),
            (double("nobody", 1.0), "nobody"),
            (double("job", 1.0), "string"),
        ] {
            let refused = set(&mut peer, wrong);
            assert_eq!(refused["successful"], false);
            assert!(
                refused["reason"].as_str().is_some_and(|reason| reason.contains(expected)),
                "'{expected}' in {refused}"
            );
        }
        assert_eq!(now("infeed_um_rev"), Some(ParameterValue::Double(7.5)), "refusals change nothing");
    });
    ground.check("set atomically: all or none", || {
        let both = |first: f64, second: f64| json!({ "parameters": [double("group.depth", first), double("infeed_um_rev", second)] });
        let refused = ask(&mut peer, "set_parameters_atomically", both(0.25, 51.0));
        assert_eq!((&refused["result"]["successful"], now("group.depth")), (&json!(false), Some(ParameterValue::Double(0.25))));
        assert_eq!(ask(&mut peer, "set_parameters_atomically", both(0.25, 9.0))["result"]["successful"], true);
        assert_eq!(now("group.depth"), Some(ParameterValue::Double(0.25)));
    });
    ground.check("`/parameter_events`", || {
        peer.ask("subscribe", json!({ "topic": "/parameter_events", "type": "rcl_interfaces/msg/ParameterEvent" }));
        let deadline = std::time::Instant::now() + crate::support::PATIENCE;
        while node.subscription_count("/parameter_events").expect("valid") == 0 {
            assert!(std::time::Instant::now() < deadline, "the peer's subscription is not found");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        peer.ask("wait_publishers", json!({ "topic": "/parameter_events", "n": 2 }));
        // Nobody promises that the event of a change outruns the discovery of who listens: changes go on until one is seen.
        let mut event = json!(null);
        for infeed in 1..50 {
            assert_eq!(set(&mut peer, double("infeed_um_rev", f64::from(infeed)))["successful"], true);
            let events = peer.events_so_far("message");
            let ours =
                events.into_iter().map(|mut event| event["data"].take()).find(|event| event["node"] == "/planner");
            if let Some(found) = ours.filter(|event| event["changed_parameters"] != json!([])) {
                event = found;
                break;
            }
        }
        assert_eq!(event["changed_parameters"][0]["name"], "infeed_um_rev", "{event}");
        assert_eq!((&event["new_parameters"], &event["deleted_parameters"]), (&json!([]), &json!([])));
    });
}

/// The output of `ros2 param dump` is a file that a node accepts, with the same values.
pub fn dumped_and_loaded(ground: &mut Ground<'_>) {
    let given = "--ros-args -r __ns:=/cell -p infeed_um_rev:=12.5 -p job:='007' -p group.depth:=1e-07";
    let (node, _spin) = ground.node_with("planner", given, declared());
    let mut peer = ground.peer("peer");
    ground.check("output of `ros2 param dump` is accepted as a parameter file", || {
        let text = peer.ask("dump", json!({ "node": "/cell/planner" }))["yaml"].as_str().expect("a text").to_owned();
        let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("dump-{}.yaml", std::process::id()));
        std::fs::File::create(&path).and_then(|mut file| file.write_all(text.as_bytes())).expect("a file of ours");
        let words = ["--ros-args", "-r", "__ns:=/cell", "--params-file", path.to_str().expect("a plain path")];
        let words: Vec<String> = words.iter().map(ToString::to_string).collect();
        let (args, _) = RosArgs::parse_with(&words, |_| None).unwrap_or_else(|error| panic!("{error} in\n{text}"));
        let options = NodeOptions::new("planner", &args.with_domain_id(ground.domain.id())).parameters(declared());
        let again = camwright_ros::Node::new(options).unwrap_or_else(|error| panic!("{error} in\n{text}"));
        for name in ["infeed_um_rev", "job", "lobes", "group.depth", "use_sim_time"] {
            assert_eq!(again.parameters().get(name), node.parameters().get(name), "{name} of\n{text}");
        }
        again.shutdown();
        std::fs::remove_file(&path).expect("it is ours");
    });
}

/// The output of `ros2 param dump` for one node can be loaded into another by `ros2 param load`; an invalid value is refused with its
/// name and range.
pub fn dumped_and_set(ground: &mut Ground<'_>) {
    let given = "--ros-args -r __ns:=/cell -p infeed_um_rev:=12.5 -p group.law:=optimal";
    let (_node, _spin) = ground.node_with("planner", given, declared());
    let (other, _other_spin) = ground.node_with("planner", "--ros-args -r __ns:=/other", declared());
    let mut peer = ground.peer("peer");
    ground.check("output of `ros2 param dump` is set by `ros2 param load`", || {
        let text = peer.ask("dump", json!({ "node": "/cell/planner" }))["yaml"].as_str().expect("a text").to_owned();
        assert!(!text.contains("null") && !text.contains("speed_rpm"), "what is not set is not dumped:\n{text}");
        let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("load-{}.yaml", std::process::id()));
        let mut load = |text: &str| {
            std::fs::write(&path, text.replace("/cell/", "/other/")).expect("a file of ours");
            peer.ask("load", json!({ "node": "/other/planner", "file": path }))["reasons"].take()
        };
        let reasons = load(&text);
        let reasons = reasons.as_object().expect("one for each parameter");
        assert!(reasons.values().all(|reason| reason == ""), "{reasons:?} of\n{text}");
        let now = |name: &str| other.parameters().get(name);
        assert_eq!(now("infeed_um_rev"), Some(ParameterValue::Double(12.5)));
        assert_eq!(now("group.law"), Some(ParameterValue::String("optimal".into())));
        assert_eq!(now("group.speed_rpm"), Some(ParameterValue::NotSet));
        for (wrong, expected) in [
            ("group: {law: foo}", ["'foo'", "one of constant, optimal"]),
            ("group: {law: null}", ["'None'", "one of constant, optimal"]),
            ("group: {speed_rpm: -45.0}", ["-45", "0.1 to 100"]),
            ("group: {speed_rpm: null}", ["'None'", "0.1 to 100"]),
            ("lobes: 5", ["'lobes' is 4", "read-only"]),
        ] {
            let reasons = load(&format!("/cell/planner:\n  ros__parameters: {{{wrong}}}\n"));
            let reason = reasons.as_object().and_then(|all| all.values().next()?.as_str().map(str::to_owned));
            let reason = reason.unwrap_or_default();
            assert!(expected.iter().all(|words| reason.contains(words)), "{wrong}: {reason}");
        }
        assert_eq!(now("group.law"), Some(ParameterValue::String("optimal".into())), "refusals change nothing");
        std::fs::remove_file(&path).expect("it is ours");
    });
}

/// Real rcl reads every line of the table as the table says; that this crate does too is a test of its own beside the parser.
pub fn command_lines(ground: &mut Ground<'_>) {
    ground.check("354 command lines have the meaning of rcl", || {
        let table = std::fs::read(repository().join("nodes/ros/src/args_table.json")).expect("the table");
        let table: Vec<Value> = serde_json::from_slice(&table).expect("JSON");
        assert_eq!(table.len(), 354, "the number in the row");
        let lines: Vec<&Value> = table.iter().map(|line| &line["args"]).collect();
        let mut process = ground.env.python("ros_args.py", &ground.domain);
        let mut process = process
            .stdin(std::process::Stdio::piped())
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::null())
            .spawn()
            .expect("it starts");
        let question = serde_json::to_vec(&lines).expect("JSON");
        process.stdin.take().expect("piped").write_all(&question).expect("it listens");
        let output = process.wait_with_output().expect("it ends");
        let verdicts: Vec<Value> = serde_json::from_slice(&output.stdout).expect("verdicts");
        assert_eq!(verdicts.len(), table.len());
        for (line, verdict) in table.iter().zip(&verdicts) {
            assert_eq!(line["rcl"], *verdict, "{}", line["args"]);
        }
    });
}
