// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A machine made of a trajectory controller (`nodes/camwright/examples/trajectory_controller_bridge.rs`): which clauses of the contract it keeps, and
//! that the interpolator moves it. `ros2_control` itself is no part of the test: a stand-in does what its controller does with what comes
//! on `~/joint_trajectory`, and says where it is on `~/controller_state`.

use crate::bridge;
#[path = "machine_contract/stand_in.rs"]
mod stand_in;
use crate::support;

use bridge::Bridge;
use camwright_axis_interpolator::AxisInterpolator;
use camwright_files::locate::locate;
use camwright_files::machine_file;
use camwright_machine_check::{Checked, ClauseVerdict, Moving, Settings, check};
use camwright_msgs::camwright_msgs::action::{MoveTo, MoveToGoal};
use camwright_ros::{GoalStatus, Node, NodeOptions, RosArgs, Shutdown};
use stand_in::StandIn;
use std::time::Duration;
use support::command::share_command_of_axes;
use support::{Domain, PATIENCE};

/// A delay that outlasts what controller, bridge and a busy computer take.
const MACHINE: [&str; 3] = ["cycle_time_us=4000", "servo_steps_per_tick=16", "feedback_delay_ticks=60"];
const CONTROLLER: &str = "joint_trajectory_controller";

fn machine() -> machine_file::MachineConfig {
    let located = locate("machines", "cam_grinder", "yaml", None).expect("it is built in");
    machine_file::parse(&located.path, &located.text, &MACHINE.map(str::to_owned)).expect("a machine")
}

#[test]
fn a_controller_bridge_meets_its_documented_clauses_and_moves() {
    let domain = Domain::reserve();
    let args = RosArgs::default().with_domain_id(domain.id()).with_namespace("/cell");
    let controller = StandIn::start(&args, CONTROLLER);
    let bridge = Bridge::start(&args, machine(), CONTROLLER).expect("a bridge");
    let moving = Some(Moving { joint: "z_axis".into(), distance: 0.002 });
    let settings = Settings { listen: Duration::from_secs(2), patience: PATIENCE, moving };
    let Checked { report, .. } = check(&args, &settings, &Shutdown::new(), &|_| {}).expect("a machine that is free");
    println!("{report}");
    assert_eq!(report.clauses(ClauseVerdict::Broken), Vec::<u8>::new(), "{report}");
    // As MACHINE_CONTRACT.md has it.
    let unseen = [6, 21, 22, 23, 32, 41];
    assert_eq!(report.clauses(ClauseVerdict::NotSeen), unseen, "{report}");

    let interpolator = AxisInterpolator::start(&args).expect("axis_interpolator");
    let operator = Node::new(NodeOptions::new("operator", &args)).expect("a node");
    let spin = operator.spin_in_thread().expect("a thread");
    let client = operator.action_client::<MoveTo>("axis_interpolator/move_to").expect("a client");
    client.wait_for_server(PATIENCE).expect("move_to");
    while !interpolator.knows_machine() {
        // No message announces it.
        std::thread::sleep(Duration::from_millis(20));
    }
    let command = share_command_of_axes(&operator);
    let goal = MoveToGoal {
        joints: vec!["z_axis".into(), "x_axis".into()],
        positions: vec![0.05, 0.1],
        ..MoveToGoal::default()
    };
    let sent = client.send_goal(goal, drop, PATIENCE).expect("a decision");
    assert!(sent.accepted());
    let (status, moved) = sent.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", moved.message);
    // The controller itself is at the position that the bridge reports.
    let [_, x, z] = controller.position();
    assert!((z - 0.05).abs() < 1e-9 && (x - 0.1).abs() < 1e-9, "x is {x}, z is {z}");
    drop(command);
    interpolator.stop();
    drop(spin);
    operator.shutdown();
    bridge.stop();
    controller.stop();
}
