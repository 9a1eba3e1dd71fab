//! A machine behind the HAL of LinuxCNC: drives and switches simulated by its own components, without hardware and without real time.
//!
//! HAL refuses root and lets only its own user in, so HAL and the node run as an ordinary user here.

use crate::support;

use camwright_files::locate::locate;
use camwright_files::machine_file;
use camwright_machine_hal::simulation_text;
use camwright_msgs::camwright_msgs::action::{RunJob, RunJobGoal};
use camwright_msgs::camwright_msgs::msg::{MachineAlarms, MachineStream};
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_ros::{ActionClient, GoalStatus, Node, NodeOptions, Qos, RosArgs};
use std::collections::BTreeSet;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use support::command::Shared;
use support::processes::Processes;
use support::{Domain, Guarded, PATIENCE, in_ci};

const NAMESPACE: &str = "/hal_cell";
const JOB: [&str; 5] = [
    "machine=cam_grinder_hal",
    "wheel_radius_mm=60.0",
    "infeed.per_block_um=0.02",
    "infeed.spark_out_turns=1",
    "infeed.total_mm=0.36",
];
/// User without rights, whom every Linux has.
const NOBODY: &str = "65534";

/// A command of the user of HAL.
fn as_user(program: &Path, home: &Path) -> Command {
    let id = Command::new("id").arg("-u").output().expect("id is part of coreutils");
    let mut command = if id.stdout.trim_ascii() == b"0" {
        let mut command = Command::new("setpriv");
        command.args([&format!("--reuid={NOBODY}"), &format!("--regid={NOBODY}"), "--clear-groups"]).arg(program);
        command
    } else {
        Command::new(program)
    };
    command.env("HOME", home).current_dir(home);
    command
}

/// HAL with the simulation of the shipped grinder.
struct Hal {
    home: PathBuf,
    halrun: Guarded,
}

impl Hal {
    /// `None`, loudly, where LinuxCNC is not installed.
    fn start() -> Option<Self> {
        let path = std::env::var_os("PATH").unwrap_or_default();
        if !std::env::split_paths(&path).any(|folder| folder.join("halrun").is_file()) {
            assert!(!in_ci(), "halrun is not there: the tests with LinuxCNC are not optional in CI");
            eprintln!("SKIPPED, NOT PASSED: halrun is not there (linuxcnc-uspace)");
            return None;
        }
        // Not below the repository, which another user may not be able to read.
        let home = std::env::temp_dir().join(format!("camwright-hal-{}", std::process::id()));
        std::fs::create_dir_all(&home).expect("a folder");
        std::fs::set_permissions(&home, std::fs::Permissions::from_mode(0o777)).expect("our folder");
        std::fs::copy(env!("CARGO_BIN_EXE_machine_hal"), home.join("machine_hal")).expect("the node");
        let located = locate("machines", "cam_grinder_hal", "yaml", None).expect("it is shipped");
        let file = machine_file::parse(&located.path, &located.text, &[]).expect("it is a machine");
        let text = simulation_text(&file, file.hal.as_ref().expect("it has drives"));
        std::fs::write(home.join("machine.hal"), text).expect("our folder");
        // What an earlier run has left.
        let _nothing_was_left = as_user(Path::new("halrun"), &home).arg("-U").output();
        let mut halrun = as_user(Path::new("halrun"), &home);
        let halrun = Guarded::start("halrun", halrun.args(["-I", "-f", "machine.hal"]));
        let hal = Self { home, halrun };
        let deadline = Instant::now() + PATIENCE;
        // HAL reports to nobody that its thread runs.
        while !hal.halcmd(&["-s", "show", "thread"]).is_some_and(|text| text.contains("sampler.0")) {
            assert!(Instant::now() < deadline, "HAL does not start{}", hal.halrun.stderr());
            std::thread::sleep(Duration::from_millis(100));
        }
        Some(hal)
    }

    /// Output of `halcmd`; `None` if it fails.
    fn halcmd(&self, words: &[&str]) -> Option<String> {
        let output = as_user(Path::new("halcmd"), &self.home).args(words).output().expect("it is installed");
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    }

    fn set(&self, pin: &str, value: &str) {
        assert!(self.halcmd(&["setp", pin, value]).is_some(), "halcmd setp {pin} {value}");
    }

    fn node(&self, domain: &Domain) -> Guarded {
        let mut command = as_user(&self.home.join("machine_hal"), &self.home);
        command.env("ROS_DOMAIN_ID", domain.id().to_string());
        command.args(["--ros-args", "-r", &format!("__ns:={NAMESPACE}")]);
        command.args(["-p", "machine:=cam_grinder_hal", "-p", "state_file:=none"]);
        Guarded::start("machine_hal", &mut command)
    }
}

impl Drop for Hal {
    fn drop(&mut self) {
        let _ended = as_user(Path::new("halrun"), &self.home).arg("-U").output();
        let _removed = std::fs::remove_dir_all(&self.home);
    }
}

/// Waits for a state of the alarms.
fn wait_for_alarms(alarms: &Receiver<BTreeSet<u16>>, is_this: impl Fn(&BTreeSet<u16>) -> bool) -> BTreeSet<u16> {
    let deadline = Instant::now() + PATIENCE;
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        let seen = alarms.recv_timeout(left).expect("the alarms change");
        if is_this(&seen) {
            return seen;
        }
    }
}

fn reset(node: &Node) {
    let reset = node.client::<Trigger>("machine/reset").expect("a client");
    reset.wait_for_service(PATIENCE).expect("the machine offers it");
    let deadline = Instant::now() + PATIENCE;
    loop {
        let answer = reset.call(&TriggerRequest::default(), PATIENCE).expect("an answer");
        if answer.success {
            return;
        }
        // The axes come to rest meanwhile.
        assert!(Instant::now() < deadline, "{}", answer.message);
        std::thread::sleep(Duration::from_millis(100));
    }
}

#[test]
fn a_job_runs_over_hal_and_every_fault_of_hal_is_an_alarm() {
    let Some(hal) = Hal::start() else { return };
    let domain = Domain::reserve();
    let mut machine = hal.node(&domain);
    let cell = Processes::start_some(&domain, NAMESPACE, &["axis_interpolator", "job_planner"]);
    let args = RosArgs::default().with_domain_id(domain.id()).with_namespace(NAMESPACE);
    let node = Node::new(NodeOptions::new("integrator", &args)).expect("a node");
    let seen: Arc<Mutex<Vec<MachineStream>>> = Arc::default();
    let into = Arc::clone(&seen);
    let qos = Qos::default_topic().keep_last(1000);
    let _stream = node
        .subscribe("machine/stream", &qos, move |message: MachineStream, _| {
            into.lock().expect("no panic").push(message);
        })
        .expect("a subscription");
    let (sender, alarms) = channel();
    let _alarms = node
        .subscribe("machine/alarms", &Qos::latched(1), move |message: MachineAlarms, _| {
            let _over = sender.send(message.alarms.iter().map(|alarm| alarm.number).collect::<BTreeSet<u16>>());
        })
        .expect("a subscription");
    let jobs: ActionClient<RunJob> = node.action_client("job_planner/run_job").expect("a client");
    let _spin = node.spin_in_thread().expect("a thread");
    jobs.wait_for_server(PATIENCE).unwrap_or_else(|error| panic!("{error}{}", machine.stderr()));
    let _command = Shared::for_cell(&domain, NAMESPACE);
    let send = |machine: &Guarded| {
        let overrides = JOB.map(String::from).into();
        let goal = RunJobGoal { job: "eccentric".into(), overrides, ..RunJobGoal::default() };
        let sent = jobs.send_goal(goal, drop, PATIENCE).expect("an answer");
        assert!(sent.accepted(), "rejected{}", machine.stderr());
        sent
    };

    // A whole job: the drives follow every setpoint to the count, and the form error is that of the encoders.
    let (status, result) = send(&machine).result(PATIENCE).expect("it ends");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    assert!(result.lobes[0].form_error_max.abs() < 1e-7, "{} m", result.lobes[0].form_error_max);
    let messages = std::mem::take(&mut *seen.lock().expect("no panic"));
    let off = |message: &MachineStream| {
        let pairs = message.setpoint_counts.iter().zip(&message.actual_counts);
        pairs.map(|(setpoint, actual)| (setpoint - actual).abs()).max().unwrap_or(0)
    };
    let moving = messages.iter().filter(|message| message.actual_velocities.iter().any(|speed| *speed != 0.0)).count();
    let farthest = messages.iter().map(off).max();
    assert!(moving > 300 && farthest <= Some(1), "{moving} messages in motion, off by {farthest:?} counts");
    let ticks = messages.windows(2).all(|pair| pair[0].tick <= pair[1].tick);
    assert!(ticks, "ticks only increase");

    // The emergency stop chain of HAL opens in the cut.
    let job = send(&machine);
    let goes_on = Instant::now() + PATIENCE;
    while !seen.lock().expect("no panic").iter().any(|message| message.actual_velocities.iter().any(|v| *v != 0.0)) {
        assert!(Instant::now() < goes_on, "nothing moves");
        std::thread::sleep(Duration::from_millis(20));
    }
    hal.set("chain.ok-in", "0");
    wait_for_alarms(&alarms, |numbers| numbers.contains(&1));
    assert_eq!(job.result(PATIENCE).expect("it ends").0, GoalStatus::Aborted);
    hal.set("chain.reset", "0");
    hal.set("chain.ok-in", "1");
    hal.set("chain.reset", "1");
    reset(&node);
    wait_for_alarms(&alarms, BTreeSet::is_empty);

    // A drive reports a fault, and a limit switch is pressed, at rest.
    hal.set("x-fault.in0", "1");
    wait_for_alarms(&alarms, |numbers| numbers.contains(&42));
    hal.set("x-fault.in0", "0");
    reset(&node);
    wait_for_alarms(&alarms, BTreeSet::is_empty);
    hal.set("z-limit.in0", "1");
    wait_for_alarms(&alarms, |numbers| numbers.contains(&13));
    hal.set("z-limit.in0", "0");
    reset(&node);
    wait_for_alarms(&alarms, BTreeSet::is_empty);

    // HAL stops: nobody knows where the axes are, and the node still answers.
    assert!(hal.halcmd(&["stop"]).is_some());
    wait_for_alarms(&alarms, |numbers| numbers.contains(&166));
    assert!(machine.is_running());
    machine.interrupt();
    assert!(machine.wait(PATIENCE).success(), "{}", machine.stderr());
    drop(cell);
}

/// A HAL that is not there, and one that does not fit the machine, are refused with the whole list.
#[test]
fn a_machine_without_its_hal_is_refused() {
    let output = Command::new(env!("CARGO_BIN_EXE_machine_hal"))
        .args(["--ros-args", "-p", "machine:=cam_grinder"])
        .env("ROS_DOMAIN_ID", Domain::reserve().id().to_string())
        .output();
    let output = output.expect("the node starts");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("has no section `hal`") && text.contains("machine_sim"), "{text}");
}
