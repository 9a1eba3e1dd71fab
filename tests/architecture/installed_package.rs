// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The package as `ros2 run` and `ros2 launch` find it: built and installed by `CMake` with the real `ament_cmake`, run from there.
//! Stand-ins for the launch modules, which no index for Python has, record the processes of the launch file; the test then starts them.

use crate::support;

use camwright_files::locate;
use camwright_ros::{Node, NodeOptions, RosArgs};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use support::{Domain, Folder, Guarded, PATIENCE, PeerEnv, peer_env, repository};

/// Builds and installs; the prefix.
fn install(env: &PeerEnv, domain: &Domain, folder: &Folder) -> PathBuf {
    let binaries = Path::new(env!("CARGO_BIN_EXE_camwright")).parent().expect("Cargo's folder");
    let prefix = folder.join("install");
    let mut command = env.python("install_package.py", domain);
    command.args([&repository().join("nodes"), binaries, &folder.join("build"), &prefix]);
    let output = command.output().expect("the environment's Python starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    prefix
}

/// Command lines that the launch file starts with these arguments.
fn launched(
    env: &PeerEnv,
    domain: &Domain,
    prefix: &Path,
    arguments: &[&str],
) -> Result<Vec<(Vec<String>, bool)>, String> {
    let mut command = env.python("launch_standin.py", domain);
    let path = format!("{}:{}", prefix.display(), std::env::var("AMENT_PREFIX_PATH").unwrap_or_default());
    command.env("AMENT_PREFIX_PATH", path).arg(prefix.join("share/camwright/launch/cell.launch.py")).args(arguments);
    let output = command.output().expect("the environment's Python starts");
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    let line = |line: &str| {
        let process: Value = serde_json::from_str(line).expect("a line of JSON");
        let words = process["command"].as_array().expect("a command");
        let words = words.iter().map(|word| word.as_str().expect("a word").to_owned()).collect();
        (words, process["respawn"].as_bool().expect("yes or no"))
    };
    Ok(String::from_utf8_lossy(&output.stdout).lines().map(line).collect())
}

#[test]
fn the_package_runs_from_where_it_is_installed() {
    let Some(env) = peer_env() else { return };
    let (domain, folder) = (Domain::reserve(), Folder::new("installed-package"));
    let prefix = install(env, &domain, &folder);
    let share = prefix.join("share/camwright");
    // What ros2 pkg, ros2 run and ros2 launch look for.
    for file in [
        "share/ament_index/resource_index/packages/camwright",
        "share/camwright/package.xml",
        "share/camwright/cmake/camwrightConfig.cmake",
    ] {
        assert!(prefix.join(file).is_file(), "{file} is not installed");
    }
    for file in ["launch/cell.launch.py", "rviz/cell.rviz", "foxglove/cell.json", "params/nodes.yaml"] {
        assert!(share.join(file).is_file(), "{file} is not installed");
    }
    for machine in locate::list("machines") {
        assert!(share.join(format!("urdf/{machine}.urdf")).is_file(), "urdf of {machine}");
    }
    // Params of the prefix come before those inside of the binary: a machine that only the prefix has is found there.
    let own = std::fs::read_to_string(share.join("params/machines/lathe.yaml")).expect("it was installed");
    std::fs::write(share.join("params/machines/own.yaml"), own.replace("name: lathe", "name: own"))
        .expect("our prefix");
    let urdf =
        Command::new(prefix.join("lib/camwright/camwright")).args(["urdf", "own"]).current_dir(folder.path()).output();
    let urdf = urdf.expect("the installed binary starts");
    let text = String::from_utf8_lossy(&urdf.stdout);
    assert!(
        urdf.status.success() && text.contains("<robot name=\"own\">"),
        "{}",
        String::from_utf8_lossy(&urdf.stderr)
    );

    let params = share.join("params/nodes.yaml").display().to_string();
    let bag = format!("bag_dir:={}", folder.join("bag").display());
    let arguments =
        ["namespace:=cell1", "pace:=fast", "machine:=own", "respawn:=true", &format!("params_file:={params}"), &bag];
    let processes = launched(env, &domain, &prefix, &arguments).expect("the launch file is read");
    let mut running = Vec::new();
    for (words, respawn) in &processes {
        assert!(words[0].starts_with(&prefix.display().to_string()) && *respawn, "{words:?}");
        let mut command = Command::new(&words[0]);
        command.args(&words[1..]).current_dir(folder.path()).env("ROS_DOMAIN_ID", domain.id().to_string());
        command.env("XDG_STATE_HOME", folder.path()).env_remove("ROS_NAMESPACE");
        running.push((words[0].clone(), Guarded::start(&words[0], &mut command)));
    }
    let node = Node::new(NodeOptions::new("looks", &RosArgs::default().with_domain_id(domain.id()))).expect("a node");
    let spin = node.spin_in_thread().expect("a thread");
    for name in ["run_logger", "machine_sim", "axis_interpolator", "job_planner"] {
        assert!(node.wait_for_node(&format!("/cell1/{name}"), PATIENCE), "/cell1/{name} is not there");
    }
    let description =
        node.client::<camwright_msgs::rcl_interfaces::srv::GetParameters>("/cell1/machine_sim/get_parameters");
    let description = description.expect("a client");
    description.wait_for_service(PATIENCE).expect("the service");
    let request =
        camwright_msgs::rcl_interfaces::srv::GetParametersRequest { names: vec!["machine".into(), "pace".into()] };
    let values = description.call(&request, PATIENCE).expect("an answer").values;
    assert_eq!(
        (values[0].string_value.as_str(), values[1].string_value.as_str()),
        ("own", "fast"),
        "the launch file wins"
    );
    drop(spin);
    node.shutdown();
    for (name, process) in running.iter_mut().rev() {
        process.interrupt();
        let status = process.wait(PATIENCE);
        assert!(status.success(), "{name} ends with {status}{}", process.complaint());
    }
}

#[test]
fn the_launch_file_passes_its_arguments() {
    let Some(env) = peer_env() else { return };
    let (domain, folder) = (Domain::reserve(), Folder::new("launch-file"));
    let prefix = install(env, &domain, &folder);
    let named = |arguments: &[&str]| -> Vec<(String, String)> {
        let processes = launched(env, &domain, &prefix, arguments).expect("the launch file is read");
        processes
            .iter()
            .map(|(words, _)| (words[0].rsplit('/').next().unwrap_or_default().to_owned(), words[1..].join(" ")))
            .collect()
    };
    let usual = named(&[]);
    let names: Vec<&str> = usual.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["run_logger", "machine_sim", "axis_interpolator", "job_planner"]);
    for (name, words) in &usual {
        assert!(
            words.contains("--log-level info") && words.contains("autostart:=true") && !words.contains("__ns"),
            "{name}: {words}"
        );
        // What nobody said is as the node has it.
        assert!(
            !words.contains("machine:=") && !words.contains("pace:=") && !words.contains("job:="),
            "{name}: {words}"
        );
    }
    let all = named(&[
        "namespace:=cell1",
        "machine:=lathe",
        "job:=turned_cam",
        "autostart:=false",
        "log_level:=debug",
        "publish_tf:=false",
        "rviz:=true",
        "page:=true",
        "page_port:=9000",
        "use_sim_time:=true",
    ]);
    let words =
        |name: &str| &all.iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("no {name} in {all:?}")).1;
    assert!(
        words("machine_sim").contains("-p machine:=lathe") && words("machine_sim").contains("-p publish_tf:=false")
    );
    assert!(!words("machine_sim").contains("use_sim_time"), "the machine makes the time");
    assert!(
        words("job_planner").contains("-p job:=turned_cam") && words("job_planner").contains("-p use_sim_time:=true")
    );
    assert!(words("job_planner").contains("-p autostart:=false") && words("job_planner").contains("--log-level debug"));
    let publisher = words("robot_state_publisher");
    assert!(publisher.contains("<link name=\"cell1_insert\">") && publisher.contains("__ns:=/cell1"), "{publisher}");
    assert!(words("rviz2").contains("share/camwright/rviz/cell.rviz") && words("rviz2").contains("__ns:=/cell1"));
    assert!(words("camwright").starts_with("page --port 9000 --ros-args"), "{}", words("camwright"));
    let refused = launched(env, &domain, &prefix, &["respawn:=maybe"]).expect_err("it is no truth");
    assert!(refused.contains("respawn is 'maybe'; allowed: true and false"), "{refused}");
}
