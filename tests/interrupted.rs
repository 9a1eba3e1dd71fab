//! Ctrl-C in the middle of everything: the axes come to rest, the wheel leaves the part, the bag is closed. And two machines, one clock.

mod support;

use byteorder::LittleEndian;
use camwright_msgs::camwright_msgs::msg::{InterpolatorState, PlanSegment};
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_nodes::bag::Bag;
use camwright_nodes::bag::check::check;
use camwright_nodes::ros::{Node, NodeOptions, Qos, RosArgs};
use std::path::Path;
use std::process::Command;
use std::sync::mpsc;
use std::time::{Duration, Instant};
use support::{Domain, Guarded, PATIENCE};

fn until(what: &str, mut condition: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !condition() {
        assert!(Instant::now() < deadline, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// At pace realtime, so that the cut is still going on when the signal comes.
#[test]
fn ctrl_c_in_the_cut_retracts_the_wheel_and_closes_the_bag() {
    let domain = Domain::take();
    let bag = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("interrupted-{}", std::process::id()));
    let _not_there = std::fs::remove_dir_all(&bag);
    let node = Node::new(NodeOptions::new("watcher", &RosArgs::default().with_domain_id(domain.id()))).expect("a node");
    let _spinning = node.spin_in_thread().expect("a thread");
    let (sender, phases) = mpsc::channel();
    let _states = node
        .subscribe::<InterpolatorState>("axis_interpolator/state", &Qos::latched(1), move |state, _| {
            let _test_is_over = sender.send(state.phase);
        })
        .expect("a subscription");
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.env("ROS_DOMAIN_ID", domain.id().to_string()).env("XDG_STATE_HOME", env!("CARGO_TARGET_TMPDIR"));
    command.args(["run", "eccentric", "--pace", "realtime", "--bag"]).arg(&bag);
    command.args(["--set", "wheel_radius_mm=60.0", "--set-machine", "wheel.spin_up_s=0.2"]);
    // Setpoints run far ahead, so that a busy computer is no underrun.
    command.args(["--set-machine", "feedback_delay_ticks=500"]);
    let mut run = Guarded::start("camwright run", &mut command);
    while phases.recv_timeout(PATIENCE).expect("it comes to the cut") != PlanSegment::PHASE_CUT {}
    run.interrupt();
    let status = run.wait(PATIENCE);
    assert_eq!(status.code(), Some(3), "a job that was cancelled{}", run.complaint());
    let said = run.remaining_lines(PATIENCE);
    let last_three: Vec<&str> = said.iter().rev().take(3).rev().map(String::as_str).collect();
    let [message, path, verdict] = last_three[..] else { panic!("{said:?}") };
    assert!(message.contains("cancelled: the axes are at rest and the wheel is retracted"), "{said:?}");
    assert_eq!(path, format!("bag: {}", bag.display()));
    assert_eq!(verdict, "NOT COMPLETE: eccentric, Canceled");

    let report = check(&bag).expect("there is a bag");
    assert_eq!(report.findings, [], "{}", report.to_text());
    let read = Bag::open(&bag).expect("it is closed");
    let (mut last, mut messages) = (None, read.messages());
    while let Some(message) = messages.next_message().expect("a readable bag") {
        if read.topics()[message.topic].name == "/joint_states" {
            last = Some(message.data);
        }
    }
    let last: JointState =
        cdr_encoding::from_bytes::<_, LittleEndian>(&last.expect("joint states")[4..]).expect("CDR").0;
    let of = |values: &[f64], joint: &str| values[last.name.iter().position(|name| name == joint).expect("a joint")];
    for axis in ["c_axis", "x_axis", "z_axis"] {
        assert!(of(&last.velocity, axis).abs() < 1e-12, "{axis} moves still: {last:?}");
    }
    // The disc reaches out to 23.2 mm, its blank 0.3 mm farther.
    assert!(of(&last.position, "x_axis") > 23.5e-3, "{last:?}");
    std::fs::remove_dir_all(&bag).expect("the bag is ours");
}

/// The second machine at pace fast says that it leaves the clock to the first, and takes it over when that is gone.
#[test]
fn one_of_two_machines_tells_the_time() {
    let domain = Domain::take();
    let node = Node::new(NodeOptions::new("watcher", &RosArgs::default().with_domain_id(domain.id()))).expect("a node");
    let _spinning = node.spin_in_thread().expect("a thread");
    let machine = |namespace: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_machine_sim"));
        command.env("ROS_DOMAIN_ID", domain.id().to_string());
        command.args(["--ros-args", "-r", &format!("__ns:={namespace}"), "-p", "pace:=fast", "-p", "state_file:=none"]);
        Guarded::start(namespace, &mut command)
    };
    let clocks = || node.publisher_count("/clock").expect("a good name");
    let mut first = machine("/left");
    until("the first machine tells the time", || clocks() == 1);
    let mut second = machine("/right");
    let said = "/left/machine_sim publishes /clock, so this machine does not";
    until("the second leaves it to the first", || {
        assert!(second.is_running(), "{}", second.complaint());
        second.stderr().contains(said)
    });
    assert_eq!(clocks(), 1);
    first.interrupt();
    assert!(first.wait(PATIENCE).success(), "{}", first.complaint());
    until("the second takes over", || second.stderr().contains("nobody else publishes /clock any more"));
    until("it tells the time", || clocks() == 1);
    second.interrupt();
    assert!(second.wait(PATIENCE).success(), "{}", second.complaint());
}
