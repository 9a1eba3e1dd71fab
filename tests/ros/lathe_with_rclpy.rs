// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A lathe as its users meet it: four processes of ours, and a real ROS 2 node (rclpy with Fast DDS) that runs a turning job, reads its
//! form map and the surface that was turned, and afterwards reads what was recorded.

use crate::support;

use serde_json::{Value, json};
use support::processes::{Operator, Processes, RUN_JOB, SUCCEEDED, fresh_bag, judge};
use support::{Domain, PATIENCE, Peer, peer_env};

const JOB: &str = "turned_cam";
/// A real job on a short piece of the part, on a coarser grid.
const SHORT: [&str; 4] =
    ["turned.to_mm=21", "form_grid.azimuths=180", "finishing.along_z_mm=0.3", "roughing.along_z_mm=0.8"];

/// Names relative to the cell's namespace, with their types.
const TOPICS: [(&str, &str); 3] = [
    ("machine/turned_part", "camwright_msgs/msg/TurnedPage"),
    ("job_planner/form_map", "camwright_msgs/msg/FormMap"),
    ("job_planner/job_status", "camwright_msgs/msg/JobStatus"),
];

fn send_job(operator: &mut Operator<'_>, overrides: &[&str]) -> Value {
    let action = operator.name("job_planner/run_job");
    let goal = json!({ "job": JOB, "overrides": overrides });
    operator.peer.ask("send_goal", json!({ "action": action, "type": RUN_JOB, "goal": goal }))
}

/// The planner can take a job when it has received the machine: then it can plan one.
fn wait_until_ready(operator: &mut Operator<'_>) -> Value {
    let deadline = std::time::Instant::now() + PATIENCE;
    loop {
        let request = json!({ "job": JOB, "overrides": SHORT, "points": 36, "z": 0.022 });
        let answer = operator.call("job_planner/preview_job", "camwright_msgs/srv/PreviewJob", request);
        if answer["success"] == true {
            return answer;
        }
        assert!(std::time::Instant::now() < deadline, "the planner is not ready: {}", answer["message"]);
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
}

/// Checks the preview of a turned part: a section, and a turn of three axes.
fn look_at_the_preview(preview: &Value) {
    let radii: Vec<f64> =
        preview["contour_radius"].as_array().expect("a list").iter().filter_map(Value::as_f64).collect();
    let (least, most) = radii.iter().fold((f64::INFINITY, 0.0_f64), |(l, m), r| (l.min(*r), m.max(*r)));
    assert_eq!(radii.len(), 36);
    assert!((least - 0.02).abs() < 1e-9 && most > 0.0225 && most < 0.02301, "{least} to {most} m");
    assert_eq!(preview["turn"]["joint_names"], json!(["c_axis", "x_axis", "z_axis"]));
    let points = preview["turn"]["points"].as_array().expect("a list");
    let z = |index: usize| points[index]["positions"][2].as_f64().expect("a number");
    let advance = (z(35) - z(0)).abs();
    assert!((advance - 0.3e-3 * 35.0 / 36.0).abs() < 1e-5, "{advance} m in 35 of 36 parts of a turn");
}

#[test]
fn a_ros_2_user_turns_a_part_that_is_not_round_and_reads_its_form() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::reserve();
    let bag = fresh_bag("lathe");
    let mut peer = Peer::start(env, &domain, "operator");
    let cell = Processes::start(&domain, "/lathe", &["machine:=lathe"], &bag);
    let mut operator = Operator { peer: &mut peer, namespace: "/lathe" };
    look_at_the_preview(&wait_until_ready(&mut operator));
    operator.subscribe("job_planner/form_map", TOPICS[1].1, "latched:1", 1);
    operator.subscribe("job_planner/job_status", TOPICS[2].1, "latched:10", 1000);
    for (topic, _) in TOPICS {
        let topic = operator.name(topic);
        operator.peer.ask("wait_publishers", json!({ "topic": topic }));
    }

    // Another job's machine, and an insert at the centre: refused with the reason, nothing moves.
    let request = json!({ "job": "eccentric", "overrides": [] });
    let validated = operator.call("job_planner/validate_job", "camwright_msgs/srv/ValidateJob", request);
    assert_eq!(validated["success"], false, "{validated}");
    let wrong = [SHORT.as_slice(), &["bar_radius_mm=21"]].concat();
    assert_eq!(send_job(&mut operator, &wrong)["accepted"], false);

    let sent = send_job(&mut operator, &SHORT);
    assert_eq!(sent["accepted"], true, "{:?}", operator.peer.events_so_far("message").pop());
    let goal = sent["goal"].as_str().expect("an id").to_owned();
    let of_cut = |event: &Value| event["goal"] == goal && event["data"]["phase_name"] == "cut";
    let feedback = operator.peer.event("feedback", of_cut)["data"].take();
    assert_eq!((&feedback["lobe"], &feedback["lobe_count"]), (&json!(JOB), &json!(1)));
    assert!(feedback["turns"].as_f64().is_some_and(|turns| turns > 3.0), "{feedback}");
    let (status, result) = operator.result(&goal);
    assert_eq!(status, SUCCEEDED, "{result}");
    let turned = &result["turned"][0];
    let number = |field: &str| turned[field].as_f64().expect("a number");
    let (worst, allowed) = (number("form_error_max"), number("form_error_allowed"));
    assert!(worst.abs() <= allowed, "{turned}");
    // Here the generatrix is straight: f²/8R in the rake plane, and less along the normal that leans out of it.
    let (theory, in_plane) = (number("cusp_height_theory"), 0.3e-3_f64.powi(2) / 8.0 / 8e-3);
    assert!(theory < in_plane && theory > 0.6 * in_plane && theory < number("cusp_height") + 1e-9, "{turned}");
    assert!((allowed - theory - 10e-6).abs() < 1e-12, "{turned}");

    let map = operator.message("job_planner/form_map");
    let fields =
        |name: &str| -> Vec<f64> { map[name].as_array().expect("a list").iter().filter_map(Value::as_f64).collect() };
    let (lowest, highest) = (fields("lowest"), fields("highest"));
    let size = map["azimuths"].as_u64().zip(map["columns"].as_u64()).expect("two numbers");
    assert_eq!((lowest.len() as u64, highest.len() as u64), (size.0 * size.1, size.0 * size.1));
    let farthest = lowest.iter().chain(&highest).fold(0.0_f64, |most, deviation| most.max(deviation.abs()));
    assert!((farthest - worst.abs()).abs() < 1e-6 * worst.abs(), "{farthest} m in the map, {worst} m reported");

    // Who comes late has the whole surface.
    operator.subscribe("machine/turned_part", TOPICS[0].1, "latched:512", 1000);
    let mut radii: Vec<(u64, Vec<f64>)> = Vec::new();
    let pages = loop {
        let page = operator.message("machine/turned_part");
        let first = page["first"].as_u64().expect("a number");
        let of_page = page["radius"].as_array().expect("a list").iter().filter_map(Value::as_f64).collect();
        radii.push((first, of_page));
        let pages = page["pages"].as_u64().expect("a number");
        assert_eq!(page["finished"], true);
        if radii.len() as u64 == pages {
            break page;
        }
    };
    radii.sort_by_key(|(first, _)| *first);
    let radii: Vec<f64> = radii.into_iter().flat_map(|(_, radii)| radii).collect();
    let (azimuths, columns) = (pages["azimuths"].as_u64(), pages["columns"].as_u64());
    assert_eq!(Some(radii.len() as u64), azimuths.zip(columns).map(|(azimuths, columns)| azimuths * columns));
    assert!(radii.iter().all(|radius| *radius > 0.0199 && *radius < 0.0247));

    let bag = cell.end();
    drop(peer);
    let verdict = judge(env, &domain, &bag);
    for (topic, kind) in TOPICS {
        let topic = format!("/lathe/{topic}");
        let count = verdict["topics"][&topic]["count"].as_u64().unwrap_or_default();
        assert!(count > 0, "{topic} is not in the bag: {}", verdict["topics"]);
        let known = camwright_msgs::by_type_name(kind).expect("a type of ours").type_hash;
        assert_eq!(
            (&verdict["topics"][&topic]["type"], &verdict["topics"][&topic]["hash"]),
            (&json!(kind), &json!(known))
        );
    }
    assert_eq!(verdict["topics"]["/lathe/machine/turned_part"]["count"], pages["pages"]);
    std::fs::remove_dir_all(&bag).expect("the bag is ours");
}
