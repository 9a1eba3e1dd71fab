// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Wrong inputs of a first hour: each ends with one error that names the cause and the next step, its exit code, and no trace. No node
//! starts, so that no bag and no state file are left.

use crate::support;

use camwright_ros::{Node, NodeLock, NodeOptions, RosArgs};
use std::collections::BTreeSet;
use std::net::TcpListener;
use std::path::Path;
use std::process::Command;
use support::{Domain, Folder, PATIENCE};

/// Text of a file of params.
fn params(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../params").join(file);
    std::fs::read_to_string(path).expect("a file of params/")
}

/// Files and folders below a folder.
fn tree(folder: &Path) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        found.insert(entry.path().display().to_string());
        if entry.path().is_dir() {
            found.extend(tree(&entry.path()));
        }
    }
    found
}

/// Folder with files that are wrong, and a domain without a cell.
struct Desk {
    folder: Folder,
    domain: Domain,
}

impl Desk {
    fn new(name: &str) -> Self {
        let folder = Folder::new(&format!("wrong-{name}"));
        let eccentric = params("jobs/plate_cam.yaml");
        folder.write("file", "a file\n");
        std::fs::create_dir_all(folder.join("folder")).expect("a folder");
        std::fs::write(folder.join("binary.yaml"), b"name: \xff\xfe\n").expect("it can be written");
        std::fs::write(folder.join("table.yaml"), b"PK\x03\x04\x14\x00\xff").expect("it can be written");
        folder.write("broken.yaml", "schema: camwright/job/1\nlobes: [\n");
        folder.write("text.yaml", "a letter to the workshop\n");
        folder.write("newer.yaml", &eccentric.replace("camwright/job/1", "camwright/job/9"));
        folder.write("kind.yaml", &eccentric.replace("camwright/job/1", "camwright/jop/1"));
        let no_table = params("jobs/four_lobe_camshaft.yaml").replace("intake.csv", "no_such_table.csv");
        folder.write("no_table.yaml", &no_table);
        let two = eccentric.replace("work_speed_rpm:", "work_speed_rmp:").replace("stock_mm: 0.3", "stock_mm: -1");
        folder.write("two.yaml", &two);
        folder.write("machine.yaml", &params("machines/cam_grinder.yaml").replace("unbalance_um", "unbalence_um"));
        folder.write("nodes.yaml", "/**/run_logger:\n  ros__parameters:\n    split_mbb: 3\n");
        folder.write("table.csv", "cam_angle_deg,lift_mm\n0,0\n");
        Self { folder, domain: Domain::reserve() }
    }

    /// Runs a command that must fail with one error and without a trace.
    fn fails(&self, words: &[&str], code: i32, expected: &[&str]) {
        let before = tree(self.folder.path());
        let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
        command.current_dir(self.folder.path()).env("ROS_DOMAIN_ID", self.domain.id().to_string());
        command.env("XDG_STATE_HOME", self.folder.join("state")).env("XDG_RUNTIME_DIR", self.folder.path());
        let output = command.args(words).output().expect("camwright runs");
        let (out, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert_eq!(output.status.code(), Some(code), "{words:?}: {out}{errors}");
        for part in expected {
            assert!(errors.contains(part), "{words:?} does not report {part:?}: {out}{errors}");
        }
        let is_error = |line: &&str| line.starts_with("camwright") || line.starts_with("error");
        assert_eq!(errors.lines().filter(is_error).count(), 1, "{words:?} is one error: {errors}");
        assert_eq!(tree(self.folder.path()), before, "{words:?} leaves a trace");
    }
}

#[test]
fn a_wrong_command_line_is_refused() {
    let desk = Desk::new("command-line");
    desk.fails(&["runn", "plate_cam"], 2, &["unrecognized subcommand 'runn'", "'run'"]);
    desk.fails(&["run", "plate_cam", "--sett", "stock_mm=1"], 2, &["unexpected argument '--sett'", "'--set'"]);
    desk.fails(&["run", "plate_cam", "--parts", "many"], 2, &["invalid value 'many' for '--parts <N>'"]);
    desk.fails(&["run", "plate_cam", "--parts", "0"], 2, &["it must be a whole number from 1 to 10000"]);
    desk.fails(&["study", "speed_and_infeed", "--workers", "0"], 2, &["it must be a whole number from 1 to 1024"]);
    let search = |limits: &str, expected: &[&str]| {
        let words = ["study", "speed_and_infeed", "--minimise", "job_time_s", "--subject-to", limits];
        desk.fails(&words, 2, expected);
    };
    search("form_error_max_um<3", &["\"form_error_max_um<3\" is no limit; write NAME<=VALUE"]);
    search("form_eror_max_um<=3", &["form_eror_max_um is an unknown key; did you mean form_error_max_um?"]);
    search("burn_index<=hot", &["limits.burn_index is the text \"hot\""]);
    desk.fails(&["study", "speed_and_infeed", "--minimise", "time"], 2, &["minimise", "job_time_s"]);
    desk.fails(&["page", "--port", "99999"], 2, &["it must be a whole number from 0 to 65535"]);
    desk.fails(&["run", "plate_cam", "--pace", "quick"], 2, &["invalid value 'quick'", "realtime, fast"]);
    desk.fails(&["run", "plate_cam", "--start-at", "A"], 2, &["--attach"]);
    desk.fails(&["init", "jobb"], 2, &["invalid value 'jobb'", "'job'"]);
    desk.fails(&["init", "sudy"], 2, &["invalid value 'sudy'", "job, machine, turning, milling, study"]);
    desk.fails(&["list", "job"], 2, &["invalid value 'job'", "'jobs'"]);
    desk.fails(&["run", "--ros-args", "-p", "depth"], 2, &["depth"]);
    desk.fails(&["run", "--ros-args", "--pace", "fast"], 2, &["unknown ROS argument \"--pace\"", "-p NAME:=VALUE"]);
}

/// As rclcpp and rclpy do, a node ends on a token after `--ros-args` that is not an argument of ROS.
#[test]
fn a_node_refuses_unknown_ros_arguments() {
    let binaries = [
        ("machine_sim", env!("CARGO_BIN_EXE_machine_sim")),
        ("axis_interpolator", env!("CARGO_BIN_EXE_axis_interpolator")),
        ("job_planner", env!("CARGO_BIN_EXE_job_planner")),
        ("run_logger", env!("CARGO_BIN_EXE_run_logger")),
    ];
    for (name, binary) in binaries {
        for (token, next) in [("--pase", "-p NAME:=VALUE"), ("pace:=fast", "did you mean `-r pace:=fast`")] {
            let output = Command::new(binary).args(["--ros-args", token]).output().expect("it runs");
            let errors = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{name} {token}: {errors}");
            let start = format!("{name}: unknown ROS argument {token:?}");
            assert!(errors.starts_with(&start) && errors.contains(next), "{token}: {errors}");
            assert_eq!(errors.lines().count(), 1, "{errors}");
        }
    }
}

#[test]
fn a_run_of_a_wrong_job_is_refused_before_a_node_starts() {
    let desk = Desk::new("job");
    let run = |job: &str, expected: &[&str]| {
        desk.fails(&["run", job], 1, &[&["job rejected, nothing started: "], expected].concat());
    };
    run("four_lobe_camshft", &["did you mean four_lobe_camshaft?"]);
    run("missing.yaml", &["missing.yaml: not found as given"]);
    run("folder", &["folder: not found as given"]);
    run("binary.yaml", &["binary.yaml:1: is not UTF-8; save the file as text in UTF-8"]);
    run("table.yaml", &["table.yaml: is a spreadsheet, not text; save its table as CSV (UTF-8)"]);
    run("broken.yaml", &["broken.yaml:"]);
    run("text.yaml", &["has no schema; expected schema: \"camwright/job/1\""]);
    run("newer.yaml", &["newer.yaml:", "version 9", "up to version 1"]);
    run("kind.yaml", &["schema is \"camwright/jop/1\", expected \"camwright/job/1\""]);
    run("no_table.yaml", &["no_such_table.csv: not found as given"]);
    run("two.yaml", &["two.yaml:", "; `camwright check two.yaml` lists all "]);
    run("plate_groove", &["`camwright post plate_groove`"]);
    run("eccentric", &["wheel_radius_mm is 15, the wheel mounted on cam_grinder has 60"]);
}

#[test]
fn a_run_with_a_wrong_override_is_refused_before_a_node_starts() {
    let desk = Desk::new("override");
    let set = |pair: &str, expected: &[&str]| desk.fails(&["run", "plate_cam", "--set", pair], 1, expected);
    set("work_speed_rmp=60", &["work_speed_rmp is an unknown key; did you mean work_speed_rpm?"]);
    set("work_speed_rpm=fast", &["work_speed_rpm is the text \"fast\"; it must be a number"]);
    set("work_speed_rpm=1e9", &["work_speed_rpm is 1000000000; it must be 0.01 to 95000"]);
    set("work_speed_rpm", &["override \"work_speed_rpm\": has no '='"]);
    set("lobes.Z.phase_deg=3", &["\"Z\""]);
    set("machine=cam_grindr", &["did you mean cam_grinder?"]);
    set("machine=lathe", &["job rejected, nothing started: "]);
    set("work_speed_rpm=3000", &["job rejected, nothing started: ", "the largest work speed that fits is"]);
    let machine = |pair: &str, expected: &[&str]| desk.fails(&["run", "plate_cam", "--set-machine", pair], 1, expected);
    machine("x_axis.max_sped_mm_s=3", &["x_axis.max_sped_mm_s is an unknown key; did you mean max_speed_mm_s?"]);
    machine("x_axis.max_speed_mm_s=-3", &["x_axis.max_speed_mm_s is -3; it must be 0.001 to 10000"]);
    desk.fails(&["run", "turned_cam", "--set", "machine=cam_grinder"], 1, &["job rejected, nothing started: "]);
    let parameter = "job_planner:clearance_mm:=-1.0";
    desk.fails(&["run", "plate_cam", "--ros-args", "-p", parameter], 1, &["clearance_mm", "-1 is outside 0 to"]);
}

#[test]
fn a_run_with_wrong_arguments_is_refused_before_a_node_starts() {
    let desk = Desk::new("arguments");
    let run = |more: &[&str], expected: &[&str]| {
        desk.fails(&[&["run", "plate_cam"], more].concat(), 1, expected);
    };
    run(&["--bag", "folder"], &["bag directory folder exists; name another with --bag"]);
    run(&["--bag", "file/run"], &["bag directory file/run cannot be created", "name another with --bag"]);
    run(&["--bag", "/proc/camwright/run"], &["bag directory /proc/camwright/run cannot be created"]);
    run(&["--attach", "--start-at", "Z9"], &["Z9"]);
    run(&["--forget-learned"], &["--forget-learned: job plate_cam does not learn; add the key form_compensation"]);
    desk.fails(&["run", "turned_cam", "--parts", "3"], 1, &["--parts does not apply to turning job turned_cam"]);
    let taken = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let port = taken.local_addr().expect("its address").port();
    run(&[&*format!("--page={port}")], &[&*format!("the operator page cannot be served at 127.0.0.1:{port}")]);
}

#[test]
fn a_bag_that_does_not_fit_on_the_disk_is_refused_before_a_node_starts() {
    let desk = Desk::new("disk");
    let huge = ["run", "four_lobe_camshaft", "--parts", "10000", "--set", "work_speed_rpm=1"];
    desk.fails(&huge, 1, &[" MB are free on the disk of ", "; free space, or name another disk with --bag"]);
}

/// Names of a cell are taken before its nodes start. Warnings of the job come first.
#[test]
fn a_second_cell_of_a_domain_on_this_host_is_refused_before_a_node_starts() {
    let desk = Desk::new("second-cell");
    let args = RosArgs::default().with_domain_id(desk.domain.id());
    let lock = NodeLock::acquire("axis_interpolator", &args).expect("no cell runs");
    let runs = format!(
        "node /axis_interpolator runs already in ROS domain {} (process {}",
        desk.domain.id(),
        std::process::id()
    );
    let burnt = ["run", "plate_cam", "--set", "infeed.per_block_um=0.1"];
    desk.fails(&burnt, 1, &["the predicted burn index is ", &runs, "nothing started", "ROS_DOMAIN_ID", "__ns:="]);
    let output = Command::new(env!("CARGO_BIN_EXE_axis_interpolator"))
        .env("ROS_DOMAIN_ID", desk.domain.id().to_string())
        .output()
        .expect("axis_interpolator runs");
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains(&runs), "{output:?}");
    drop(lock);
    NodeLock::acquire("axis_interpolator", &args).expect("nothing is left");
}

/// A cell that holds no lock of this host, as those of other hosts, is found by discovery.
#[test]
fn a_second_cell_that_discovery_finds_is_refused_before_a_node_starts() {
    let desk = Desk::new("other-cell");
    let args = RosArgs::default().with_domain_id(desk.domain.id());
    let other = Node::new(NodeOptions::new("job_planner", &args)).expect("a node");
    let spin = other.spin_in_thread().expect("a thread");
    assert!(other.wait_acquainted(PATIENCE), "alone in a domain, a node waits for no one");
    let runs = format!("node /job_planner runs already in ROS domain {}; nothing started", desk.domain.id());
    desk.fails(&["run", "plate_cam"], 1, &[&runs, "ROS_DOMAIN_ID"]);
    drop(spin);
    other.shutdown();
}

#[test]
fn wrong_files_of_other_commands_are_refused() {
    let desk = Desk::new("others");
    desk.fails(&["check", "kind.yaml"], 2, &["schema is \"camwright/jop/1\"", "did you mean camwright/job/1?"]);
    desk.fails(&["check", "text.yaml"], 2, &["the kind of the file is unknown; add the key schema"]);
    desk.fails(
        &["check", "machine.yaml"],
        2,
        &["machine.yaml:", "wheel.unbalence_um is an unknown key; did you mean unbalance_um?"],
    );
    desk.fails(
        &["check", "nodes.yaml"],
        2,
        &["nodes.yaml:3: run_logger has no parameter split_mbb; did you mean split_mb?"],
    );
    desk.fails(&["check", "nodes.yaml", "--set", "a=1"], 2, &["--set does not apply to a parameter file"]);
    desk.fails(&["check", "cam_grindr"], 2, &["did you mean cam_grinder?"]);
    let unit = ["check", "table.csv", "--set", "columns=[cam_angle_deg, lift_inches]"];
    desk.fails(&unit, 2, &["lift_inches", "lift_inch"]);
    desk.fails(&["init", "job", "two.yaml"], 1, &["two.yaml exists and is not overwritten"]);
    desk.fails(&["init", "job", "missing/job.yaml"], 1, &["its folder does not exist; create the folder first"]);
    desk.fails(&["init", "machine", "file/machine.yaml"], 1, &["file/machine.yaml cannot be written: "]);
    desk.fails(&["plan", "plate_cam", "--out", "file/plan"], 2, &["file/plan"]);
    desk.fails(&["urdf", "lath"], 1, &["did you mean lathe?"]);
}
