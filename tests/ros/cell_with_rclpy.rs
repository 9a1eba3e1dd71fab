// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The whole cell as its users meet it: four processes of ours, and a real ROS 2 node (rclpy with Fast DDS) that looks around, runs a job
//! to its end, cancels another, and afterwards reads and hears what was recorded.

use crate::support;

use serde_json::{Value, json};
use std::path::Path;
use support::processes::{Operator, Processes, RUN_JOB, SUCCEEDED, fresh_bag, in_domain, judge};
use support::{Domain, Guarded, PATIENCE, Peer, PeerEnv, peer_env};

/// A real job in few turns: the eccentric disc, with the wheel that is mounted.
const JOB: &str = "eccentric";
const SHORT: [&str; 3] = ["wheel_radius_mm=60.0", "infeed.per_block_um=0.05", "infeed.spark_out_turns=6"];
/// Number of `action_msgs/GoalStatus`.
const CANCELED: u64 = 5;
const ABORTED: u64 = 6;

impl Operator<'_> {
    fn send_job(&mut self, overrides: &[&str]) -> Value {
        let action = self.name("job_planner/run_job");
        let goal = json!({ "job": JOB, "overrides": overrides });
        self.peer.ask("send_goal", json!({ "action": action, "type": RUN_JOB, "goal": goal }))
    }

    /// Sends the job until the planner has met the machine and takes it.
    fn start_job(&mut self) -> String {
        self.wait_until_ready();
        let answer = self.send_job(&SHORT);
        assert_eq!(answer["accepted"], true, "{:?}", self.last_status());
        answer["goal"].as_str().expect("an id").to_owned()
    }

    /// The planner can take a job when it has received the machine: then it can plan one.
    fn wait_until_ready(&mut self) {
        let deadline = std::time::Instant::now() + PATIENCE;
        loop {
            let answer = self.preview();
            if answer["success"] == true {
                return;
            }
            assert!(std::time::Instant::now() < deadline, "the planner is not ready: {}", answer["message"]);
            std::thread::sleep(std::time::Duration::from_millis(100));
        }
    }

    fn preview(&mut self) -> Value {
        let request = json!({ "job": JOB, "overrides": SHORT, "points": 36 });
        self.call("job_planner/preview_job", "camwright_msgs/srv/PreviewJob", request)
    }

    fn last_status(&mut self) -> Option<Value> {
        self.peer.events_so_far("message").pop()
    }

    /// Waits until the job's feedback says that a phase has come.
    fn wait_for_phase(&mut self, goal: &str, phase: &str) -> Value {
        let event = |event: &Value| event["goal"] == goal && event["data"]["phase_name"] == phase;
        self.peer.event("feedback", event)["data"].take()
    }
}

/// Names relative to the cell's namespace, with their types.
const TOPICS: [(&str, &str); 13] = [
    ("joint_states", "sensor_msgs/msg/JointState"),
    ("machine/stream", "camwright_msgs/msg/MachineStream"),
    ("machine/io", "camwright_msgs/msg/MachineIo"),
    ("machine/alarms", "camwright_msgs/msg/MachineAlarms"),
    ("machine/part", "camwright_msgs/msg/PartLobe"),
    ("machine/description", "camwright_msgs/msg/MachineDescription"),
    ("machine/setpoints", "trajectory_msgs/msg/JointTrajectory"),
    ("machine/commands", "camwright_msgs/msg/MachineCommand"),
    ("axis_interpolator/alarms", "camwright_msgs/msg/MachineAlarms"),
    ("axis_interpolator/state", "camwright_msgs/msg/InterpolatorState"),
    ("job_planner/plan", "camwright_msgs/msg/PlanPage"),
    ("job_planner/job_status", "camwright_msgs/msg/JobStatus"),
    ("run_logger/status", "camwright_msgs/msg/RecorderStatus"),
];

const SERVICES: [(&str, &str); 7] = [
    ("job_planner/list_jobs", "camwright_msgs/srv/ListJobs"),
    ("job_planner/stop", "std_srvs/srv/Trigger"),
    ("axis_interpolator/feed_hold", "std_srvs/srv/SetBool"),
    ("machine/estop", "std_srvs/srv/SetBool"),
    ("run_logger/is_paused", "rosbag2_interfaces/srv/IsPaused"),
    ("run_logger/is_discovery_running", "rosbag2_interfaces/srv/IsDiscoveryRunning"),
    ("run_logger/record", "rosbag2_interfaces/srv/Record"),
];

fn look_around(operator: &mut Operator<'_>) {
    for node in ["run_logger", "machine_sim", "axis_interpolator", "job_planner"] {
        operator.peer.ask("wait_node", json!({ "name": node, "namespace": operator.namespace }));
    }
    for (topic, _) in TOPICS {
        let topic = operator.name(topic);
        operator.peer.ask("wait_publishers", json!({ "topic": topic }));
    }
    for (service, _) in SERVICES {
        let service = operator.name(service);
        operator.peer.ask("wait_service", json!({ "service": service }));
    }
    let graph = operator.peer.ask("graph", json!({}));
    for (topic, kind) in TOPICS {
        assert_eq!(graph["topics"][operator.name(topic)], json!([kind]), "{topic}");
    }
    for (topic, kind) in
        [("/rosout", "rcl_interfaces/msg/Log"), ("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")]
    {
        assert_eq!(graph["topics"][topic], json!([kind]));
    }
    for (service, kind) in SERVICES {
        assert_eq!(graph["services"][operator.name(service)], json!([kind]), "{service}");
    }
    for node in ["run_logger", "machine_sim", "axis_interpolator", "job_planner"] {
        let deadline = std::time::Instant::now() + PATIENCE;
        loop {
            let state = operator.call(&format!("{node}/get_state"), "lifecycle_msgs/srv/GetState", json!({}));
            if state["current_state"]["label"] == "active" {
                break;
            }
            assert!(std::time::Instant::now() < deadline, "{node} is {}", state["current_state"]["label"]);
            std::thread::sleep(std::time::Duration::from_millis(50));
        }
    }
    let topic = json!({
        "topic": "/diagnostics", "type": "diagnostic_msgs/msg/DiagnosticArray", "qos": "reliable:100", "keep": 40
    });
    operator.peer.ask("subscribe", topic);
    for node in ["run_logger", "machine_sim", "axis_interpolator", "job_planner"] {
        // The node itself first, then its parts under its name, which has the namespace of the cell.
        let node = operator.name(node);
        let report = operator.peer.message_where("/diagnostics", |report| report["status"][0]["name"] == node);
        for status in report["status"].as_array().expect("a list") {
            let of_node = |name: &str| name == node || name.starts_with(&format!("{node}: "));
            assert!(status["name"].as_str().is_some_and(of_node), "{report}");
            assert!(status["message"].as_str().is_some_and(|text| !text.is_empty()), "{report}");
        }
    }
}

fn ask_the_planner(operator: &mut Operator<'_>) {
    operator.wait_until_ready();
    let discovery = "rosbag2_interfaces/srv/IsDiscoveryRunning";
    assert_eq!(operator.call("run_logger/is_discovery_running", discovery, json!({}))["running"], json!(true));
    let record = operator.call("run_logger/record", "rosbag2_interfaces/srv/Record", json!({}));
    assert_eq!((&record["return_code"], record["error_string"] != ""), (&json!(1), true), "it is recording already");
    let jobs = operator.call("job_planner/list_jobs", "camwright_msgs/srv/ListJobs", json!({}));
    assert!(jobs["jobs"].as_array().expect("a list").contains(&json!(JOB)), "{jobs}");
    let preview = operator.preview();
    assert_eq!(preview["contour_radius"].as_array().map(Vec::len), Some(36));
    assert_eq!(preview["turn"]["joint_names"], json!(["c_axis", "x_axis"]));

    // An infeed that does not come out in whole turns: refused with the reason, by the service and by the action.
    let wrong = [SHORT[0], "infeed.total_mm=0.35"];
    let request = json!({ "job": JOB, "overrides": wrong });
    let validated = operator.call("job_planner/validate_job", "camwright_msgs/srv/ValidateJob", request);
    assert_eq!(validated["success"], false);
    assert!(validated["message"].as_str().is_some_and(|text| text.contains("whole turns")), "{validated}");
    assert_eq!(operator.send_job(&wrong)["accepted"], false);

    let set = |operator: &mut Operator<'_>, value: Value| {
        let request = json!({ "parameters": [{ "name": "work_speed_rpm", "value": value }] });
        operator.call("job_planner/set_parameters", "rcl_interfaces/srv/SetParameters", request)["results"][0].take()
    };
    let get = |operator: &mut Operator<'_>| {
        let request = json!({ "names": ["work_speed_rpm"] });
        operator.call("job_planner/get_parameters", "rcl_interfaces/srv/GetParameters", request)["values"][0].take()
    };
    let planned = |operator: &mut Operator<'_>| operator.preview()["duration"].as_f64().expect("a number");
    let before = planned(operator);
    assert_eq!(set(operator, json!({ "type": 3, "double_value": 30.0 }))["successful"], true);
    assert_eq!(get(operator)["double_value"], 30.0);
    assert!(planned(operator) > before + 1.0, "half the work speed takes longer than {before} s");
    assert_eq!(set(operator, json!({ "type": 4, "string_value": "fast" }))["successful"], false);
    assert_eq!(set(operator, json!({ "type": 0 }))["successful"], true, "back to the settings of the job");
}

/// Acts as a client of `ros2_control`: a trajectory that is followed, and one that breaks its tolerance.
fn follow_trajectories(operator: &mut Operator<'_>) {
    let action = operator.name("axis_interpolator/follow_joint_trajectory");
    let kind = "control_msgs/action/FollowJointTrajectory";
    let mut follow = |position: f64, tolerance: f64| {
        let point = json!({ "positions": [position], "time_from_start": { "sec": 1 } });
        let goal = json!({
            "trajectory": { "joint_names": ["z_axis"], "points": [point] },
            "path_tolerance": [{ "name": "z_axis", "position": tolerance }],
        });
        let sent = operator.peer.ask("send_goal", json!({ "action": action, "type": kind, "goal": goal }));
        assert_eq!(sent["accepted"], true);
        let goal = sent["goal"].as_str().expect("an id").to_owned();
        let feedback = operator.peer.event("feedback", |event| event["goal"] == goal)["data"].take();
        assert_eq!(feedback["joint_names"], json!(["z_axis"]));
        for part in ["desired", "actual", "error"] {
            assert_eq!(feedback[part]["positions"].as_array().map(Vec::len), Some(1), "{feedback}");
        }
        operator.result(&goal)
    };
    let (status, result) = follow(0.05, 0.1);
    assert_eq!((status, &result["error_code"]), (SUCCEEDED, &json!(0)), "{result}");
    let (status, result) = follow(0.0, 1e-5);
    assert_eq!((status, &result["error_code"]), (ABORTED, &json!(-4)), "{result}");
    let text = result["error_string"].as_str().expect("a text");
    assert!(text.starts_with("z_axis: position error ") && text.contains("exceeds 0.010000 mm by"), "{text}");
}

/// A cancelled job comes to rest and says so.
fn cancel_a_job(operator: &mut Operator<'_>) {
    let goal = operator.start_job();
    operator.wait_for_phase(&goal, "cut");
    let answer = operator.peer.ask("cancel", json!({ "goal": goal }));
    assert_eq!((&answer["return_code"], &answer["goals"]), (&json!(0), &json!([goal])));
    let (status, result) = operator.result(&goal);
    assert_eq!(status, CANCELED, "{result}");
    let words = "was cancelled: the axes are at rest and the wheel is retracted";
    assert!(result["message"].as_str().is_some_and(|text| text.contains(words)), "{result}");
}

/// A second sender of setpoints is refused while the cell holds its cut, with the name of who has command.
fn interfere(operator: &mut Operator<'_>) {
    let hold = |operator: &mut Operator<'_>, hold: bool| {
        let answer = operator.call("axis_interpolator/feed_hold", "std_srvs/srv/SetBool", json!({ "data": hold }));
        assert_eq!(answer["success"], true, "{answer}");
    };
    hold(operator, true);
    let joints = operator.message("joint_states");
    assert_eq!(joints["name"], json!(["c_axis", "x_axis", "z_axis", "wheel_spindle"]));
    let point = json!({
        "positions": joints["position"].as_array().expect("a list")[..3],
        "velocities": [0.0, 0.0, 0.0],
        "accelerations": [0.0, 0.0, 0.0],
    });
    let names = &joints["name"].as_array().expect("a list")[..3];
    let setpoints = json!({ "header": joints["header"], "joint_names": names, "points": [point] });
    let topic = operator.name("machine/setpoints");
    operator.peer.ask("publish", json!({ "topic": topic, "data": setpoints }));
    let refused = format!("setpoints of /operator refused: {} has command", operator.name("axis_interpolator"));
    operator.peer.event("message", |event| event["topic"] == "/rosout" && event["data"]["msg"] == refused);
    hold(operator, false);
}

/// A job runs to its end with feedback on the way and figures at the end.
fn run_a_job(operator: &mut Operator<'_>) {
    let setpoints = operator.name("machine/setpoints");
    operator.peer.ask("advertise", json!({ "topic": setpoints, "type": "trajectory_msgs/msg/JointTrajectory" }));
    // The machine, and the recorder.
    operator.peer.ask("wait_matched", json!({ "topic": setpoints, "n": 2 }));
    operator
        .peer
        .ask("subscribe", json!({ "topic": "/rosout", "type": "rcl_interfaces/msg/Log", "qos": "latched:1000" }));
    let goal = operator.start_job();
    let feedback = operator.wait_for_phase(&goal, "cut");
    interfere(operator);
    assert_eq!((&feedback["lobe"], &feedback["lobe_count"]), (&json!("A"), &json!(1)));
    assert!(feedback["percent"].as_f64().is_some_and(|percent| (0.0..=100.0).contains(&percent)), "{feedback}");
    let (status, result) = operator.result(&goal);
    assert_eq!(status, SUCCEEDED, "{result}");
    assert_eq!(result["alarm"], 0);
    let lobe = &result["lobes"][0];
    let error_um = lobe["form_error_max"].as_f64().expect("a number") * 1e6;
    assert!(error_um.abs() < 5.0, "{error_um} um");
    assert!(result["last_tick"].as_u64() > result["first_tick"].as_u64());
}

#[test]
fn a_ros_2_user_looks_around_runs_a_job_cancels_another_and_reads_the_bag() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::reserve();
    let bag = fresh_bag("four");
    let mut peer = Peer::start(env, &domain, "operator");
    let cell = Processes::start(&domain, "/cell", &[], &bag);
    let mut operator = Operator { peer: &mut peer, namespace: "/cell" };
    look_around(&mut operator);

    operator.subscribe("joint_states", "sensor_msgs/msg/JointState", "best_effort", 1);
    operator.subscribe("machine/io", "camwright_msgs/msg/MachineIo", "reliable:100", 1);
    operator.subscribe("machine/description", "camwright_msgs/msg/MachineDescription", "latched:1", 1);
    operator.subscribe("job_planner/job_status", "camwright_msgs/msg/JobStatus", "latched:10", 1000);
    let description = operator.message("machine/description");
    assert!(description["axes"].as_array().is_some_and(|axes| axes.len() >= 3), "{description}");
    ask_the_planner(&mut operator);
    follow_trajectories(&mut operator);
    cancel_a_job(&mut operator);
    run_a_job(&mut operator);
    operator.message("machine/io");

    let bag = cell.end();
    drop(peer);
    let verdict = judge(env, &domain, &bag);
    let count = |topic: &str| verdict["topics"][topic]["count"].as_u64().unwrap_or_default();
    for (topic, kind) in TOPICS.iter().filter(|(topic, _)| *topic != "run_logger/status") {
        let topic = format!("/cell/{topic}");
        assert!(count(&topic) > 0, "{topic} is not in the bag: {}", verdict["topics"]);
        assert_eq!(verdict["topics"][&topic]["type"], *kind);
        let known = camwright_msgs::by_type_name(kind).expect("a type of ours").type_hash;
        assert_eq!(verdict["topics"][&topic]["hash"], known, "{topic}");
    }
    hear_the_bag(env, &bag, count("/cell/joint_states"), &["/cell/joint_states", "/cell/machine/description"]);
    std::fs::remove_dir_all(&bag).expect("the bag is ours");
}

/// An rclpy subscriber receives the messages when the bag is played.
fn hear_the_bag(env: &PeerEnv, bag: &Path, expected: u64, topics: &[&str]) {
    let domain = Domain::reserve();
    let mut peer = Peer::start(env, &domain, "listener");
    let [joints, description] = topics else { panic!("two topics") };
    peer.ask(
        "subscribe",
        json!({ "topic": joints, "type": "sensor_msgs/msg/JointState", "qos": "reliable:10000", "keep": 1 }),
    );
    let latched = json!({ "topic": description, "type": "camwright_msgs/msg/MachineDescription", "qos": "latched:1" });
    peer.ask("subscribe", latched);
    let mut command = in_domain(env!("CARGO_BIN_EXE_camwright"), &domain);
    command.arg("replay").arg(bag).args(["--rate", "2", "--wait", "20", "--topics"]).args(topics);
    let mut replay = Guarded::start("camwright replay", &mut command);
    let received = peer.ask("received", json!({ "topic": joints, "at_least": expected, "timeout": 300 }));
    assert_eq!(received["n"], expected, "every joint state that was recorded");
    assert!(peer.message(joints)["name"].as_array().is_some_and(|names| !names.is_empty()));
    peer.message(description);
    let status = replay.wait(PATIENCE);
    assert!(status.success(), "{status}{}", replay.complaint());
}
