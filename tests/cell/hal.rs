// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A machine behind the HAL of LinuxCNC for the tests: its own components simulate drives and switches, without hardware.
//!
//! HAL refuses root and lets only its own user in, so HAL and the node run as an ordinary user here.

use crate::support;

use camwright_bag::Bag;
use camwright_files::locate::locate;
use camwright_files::machine_file;
use camwright_machine_hal::simulation_text;
use camwright_msgs::camwright_msgs::action::{RunJob, RunJobGoal};
use camwright_msgs::camwright_msgs::msg::{MachineAlarms, RecorderStatus};
use camwright_msgs::cdr::message_from_sample;
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_ros::{ActionClient, Node, NodeOptions, Qos, RosArgs, SpinThread, Subscription};
use std::collections::BTreeSet;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use support::processes::{Processes, in_domain};
use support::{Domain, Guarded, PATIENCE, in_ci};

pub(crate) const NAMESPACE: &str = "/hal_cell";
pub(crate) const JOB: [&str; 5] = [
    "machine=cam_grinder_hal",
    "wheel_radius_mm=60.0",
    "infeed.per_block_um=0.02",
    "infeed.spark_out_turns=1",
    "infeed.total_mm=0.36",
];
/// User without rights, whom every Linux has.
const NOBODY: &str = "65534";

/// A computer has one HAL. The tests that need it stand apart in the order of their names, so that few threads of the test program wait for it.
static HAL: Mutex<()> = Mutex::new(());

/// Signals that a second channel of `sampler` records for the test, in its columns: number of the setpoint; commands, encoders, power of C,
/// X and Z; run of the wheel.
const WATCHED: [&str; 11] = [
    "sequence",
    "c-axis-command",
    "x-axis-command",
    "z-axis-command",
    "c-axis-feedback",
    "x-axis-feedback",
    "z-axis-feedback",
    "c-axis-enable",
    "x-axis-enable",
    "z-axis-enable",
    "wheel-run",
];
/// Returns whether the tests run as root.
static IS_ROOT: LazyLock<bool> = LazyLock::new(|| {
    let id = Command::new("id").arg("-u").output().expect("id is part of coreutils");
    id.stdout.trim_ascii() == b"0"
});

/// Returns whether the tests have the right to real-time priority.
static MAY_RAISE: LazyLock<bool> = LazyLock::new(|| {
    let tried = Command::new("chrt").args(["--fifo", "10", "true"]).output();
    tried.is_ok_and(|done| done.status.success())
});

/// A command of the user of HAL. Where the tests have the right, it takes precedence over those that run beside it, as do the processes that it
/// starts: a machine has a computer to itself.
pub(crate) fn as_user(program: &Path, home: &Path) -> Command {
    let mut words: Vec<String> = Vec::new();
    if *MAY_RAISE {
        words.extend(["chrt", "--rr", "1"].map(String::from));
    }
    if *IS_ROOT {
        let ids = [format!("--reuid={NOBODY}"), format!("--regid={NOBODY}")];
        words.extend(["setpriv".to_owned()].into_iter().chain(ids).chain(["--clear-groups".to_owned()]));
    }
    let mut command = match words.split_first() {
        Some((first, others)) => {
            let mut command = Command::new(first);
            command.args(others).arg(program);
            command
        }
        None => Command::new(program),
    };
    command.env("HOME", home).current_dir(home);
    command
}

/// Gives all threads of a process real-time priority, as on a machine, where the tests have the right.
fn raise(id: &str) {
    if *MAY_RAISE {
        let raised = Command::new("chrt").args(["--all-tasks", "--fifo", "--pid", "10", id]).status();
        assert!(raised.is_ok_and(|status| status.success()), "process {id:?}");
    }
}

/// A folder of the user of HAL, with the programs: not below the repository, which another user may not be able to read.
pub(crate) struct HomeFolder {
    pub(crate) path: PathBuf,
    _alone: MutexGuard<'static, ()>,
}

impl HomeFolder {
    /// `None`, loudly, where LinuxCNC is not installed.
    pub(crate) fn new(programs: &[&str]) -> Option<Self> {
        let path = std::env::var_os("PATH").unwrap_or_default();
        if !std::env::split_paths(&path).any(|folder| folder.join("halrun").is_file()) {
            assert!(!in_ci(), "halrun is not there: the tests with LinuxCNC are not optional in CI");
            eprintln!("SKIPPED, NOT PASSED: halrun is not there (linuxcnc-uspace)");
            return None;
        }
        let alone = HAL.lock().unwrap_or_else(PoisonError::into_inner);
        let path = std::env::temp_dir().join(format!("camwright-hal-{}", std::process::id()));
        std::fs::create_dir_all(path.join("bin")).expect("a folder");
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o777)).expect("our folder");
        for program in programs {
            let name = Path::new(program).file_name().expect("a program");
            std::fs::copy(program, path.join("bin").join(name)).expect("the program");
        }
        // What an earlier run has left.
        let _nothing_was_left = as_user(Path::new("halrun"), &path).arg("-U").output();
        Some(Self { path, _alone: alone })
    }
}

impl Drop for HomeFolder {
    fn drop(&mut self) {
        let _ended = as_user(Path::new("halrun"), &self.path).arg("-U").output();
        let _removed = std::fs::remove_dir_all(&self.path);
    }
}

/// Values of HAL in a servo period.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct WatchedPeriod {
    pub(crate) sequence: u64,
    pub(crate) commands: [f64; 3],
    pub(crate) encoders: [f64; 3],
    pub(crate) power: [bool; 3],
    pub(crate) wheel_runs: bool,
}

impl WatchedPeriod {
    /// A line of `halsampler`.
    pub(crate) fn read(line: &str) -> Self {
        let values: Vec<f64> = line.split_whitespace().map(|word| word.parse().expect("a number")).collect();
        assert_eq!(values.len(), WATCHED.len(), "{line:?}");
        let is_on = |value: f64| value != 0.0;
        Self {
            sequence: line.split_whitespace().next().and_then(|word| word.parse().ok()).expect("a number"),
            commands: [values[1], values[2], values[3]],
            encoders: [values[4], values[5], values[6]],
            power: [is_on(values[7]), is_on(values[8]), is_on(values[9])],
            wheel_runs: is_on(values[10]),
        }
    }

    pub(crate) fn is_off(&self) -> bool {
        !self.power.contains(&true) && !self.wheel_runs
    }
}

/// Servo periods as they come.
pub(crate) struct PeriodWatch(Guarded);

impl PeriodWatch {
    /// The periods up to the one with which they are what is waited for.
    pub(crate) fn until(
        &mut self,
        what: &str,
        machine: &Guarded,
        is_this: impl Fn(&[WatchedPeriod]) -> bool,
    ) -> Vec<WatchedPeriod> {
        let (deadline, mut periods) = (Instant::now() + PATIENCE, Vec::new());
        while !is_this(&periods) {
            let line = self.0.line_within(deadline.saturating_duration_since(Instant::now()));
            let line = line.unwrap_or_else(|| panic!("{what}: HAL has not come there{}", machine.stderr()));
            // Periods of before this sampler was there.
            if line.trim() != "overrun" {
                periods.push(WatchedPeriod::read(&line));
            }
        }
        periods
    }
}

/// Returns whether the command of an axis changes.
pub(crate) fn moves(periods: &[WatchedPeriod], axis: usize) -> bool {
    let [.., before, now] = periods else { return false };
    before.commands[axis].to_bits() != now.commands[axis].to_bits()
}

/// Returns whether no command has changed for 300 periods.
pub(crate) fn rests(periods: &[WatchedPeriod]) -> bool {
    let Some(last) = periods.len().checked_sub(300).map(|from| &periods[from..]) else { return false };
    last.iter().all(|period| period.commands.map(f64::to_bits) == last[0].commands.map(f64::to_bits))
}

/// HAL with the simulation of the shipped grinder.
pub(crate) struct Hal {
    pub(crate) halrun: Guarded,
    pub(crate) home: HomeFolder,
}

impl Hal {
    /// `None`, loudly, where LinuxCNC is not installed. `turns` is where C stands, in turns from its origin.
    pub(crate) fn start(turns: Option<&str>) -> Option<Self> {
        Self::start_with(&[], turns)
    }

    /// With these keys of the machine.
    pub(crate) fn start_with(keys: &[(&str, &str)], turns: Option<&str>) -> Option<Self> {
        let home = HomeFolder::new(&[env!("CARGO_BIN_EXE_machine_hal")])?;
        let located = locate("machines", "cam_grinder_hal", "yaml", None).expect("it is shipped");
        let mut machine = located.text;
        for (from, to) in keys {
            assert!(machine.contains(from), "{from} is not in\n{machine}");
            machine = machine.replace(from, to);
        }
        let path = home.path.join("machine.yaml");
        let file = machine_file::parse(&path, &machine, &[]).expect("it is a machine");
        std::fs::write(path, machine).expect("our folder");
        let mut text = simulation_text(&file, file.hal.as_ref().expect("it has drives"));
        let mut put = |from: &str, to: &str| {
            assert!(text.contains(from), "{from} is not in\n{text}");
            text = text.replace(from, to);
        };
        put(
            "loadrt sampler depth=10000 cfg=usfffsssfffff",
            "loadrt sampler depth=10000,20000 cfg=usfffsssfffff,uffffffbbbb",
        );
        let nets = WATCHED.iter().enumerate();
        let nets: String =
            nets.map(|(pin, signal)| format!("net camwright-{signal} => sampler.1.pin.{pin}\n")).collect();
        put("\nstart\n", &format!("\naddf sampler.1 servo-thread\n{nets}start\n"));
        if let Some(turns) = turns {
            put("setp c-in-turns.offset ", &format!("setp c-in-turns.offset {turns} # not "));
        }
        std::fs::write(home.path.join("machine.hal"), text).expect("our folder");
        let mut halrun = as_user(Path::new("halrun"), &home.path);
        let halrun = Guarded::start("halrun", halrun.args(["-I", "-f", "machine.hal"]));
        let hal = Self { home, halrun };
        let deadline = Instant::now() + PATIENCE;
        // HAL does not report that its thread runs.
        while !hal.halcmd(&["-s", "show", "thread"]).is_some_and(|text| text.contains("sampler.0")) {
            assert!(Instant::now() < deadline, "HAL does not start{}", hal.halrun.stderr());
            std::thread::sleep(Duration::from_millis(100));
        }
        // A HAL without a real-time kernel starts its threads at ordinary priority.
        let found = Command::new("pidof").arg("rtapi_app").output().expect("pidof is installed");
        raise(String::from_utf8_lossy(&found.stdout).trim());
        Some(hal)
    }

    /// Every servo period from now on.
    pub(crate) fn watch(&self) -> PeriodWatch {
        let mut sampler = as_user(Path::new("stdbuf"), &self.home.path);
        PeriodWatch(Guarded::start("halsampler", sampler.args(["-oL", "halsampler", "-c", "1"])))
    }

    /// Output of `halcmd`; `None` if it fails.
    pub(crate) fn halcmd(&self, words: &[&str]) -> Option<String> {
        let output = as_user(Path::new("halcmd"), &self.home.path).args(words).output().expect("it is installed");
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    }

    pub(crate) fn set(&self, pin: &str, value: &str) {
        assert!(self.halcmd(&["setp", pin, value]).is_some(), "halcmd setp {pin} {value}");
    }

    pub(crate) fn node(&self, domain: &Domain) -> Guarded {
        let mut command = as_user(&self.home.path.join("bin/machine_hal"), &self.home.path);
        command.env("ROS_DOMAIN_ID", domain.id().to_string());
        command.args(["--ros-args", "-r", &format!("__ns:={NAMESPACE}")]);
        command.args(["-p", "machine:=machine.yaml", "-p", "state_file:=none"]);
        let node = Guarded::start("machine_hal", &mut command);
        raise(&node.id().to_string());
        node
    }
}

/// Waits for a state of the alarms.
pub(crate) fn wait_for_alarms(
    alarms: &Receiver<BTreeSet<u16>>,
    is_this: impl Fn(&BTreeSet<u16>) -> bool,
) -> BTreeSet<u16> {
    let deadline = Instant::now() + PATIENCE;
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        let seen = alarms.recv_timeout(left).expect("the alarms change");
        if is_this(&seen) {
            return seen;
        }
    }
}

pub(crate) fn reset(node: &Node) {
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

/// Sends the job.
pub(crate) fn send(jobs: &ActionClient<RunJob>, machine: &Guarded) -> camwright_ros::ClientGoal<RunJob> {
    let overrides = JOB.map(String::from).into();
    let goal = RunJobGoal { job: "eccentric".into(), overrides, ..RunJobGoal::default() };
    let sent = jobs.send_goal(goal, drop, PATIENCE).expect("an answer");
    assert!(sent.accepted(), "rejected{}", machine.stderr());
    sent
}

/// The messages of a topic in a bag.
pub(crate) fn messages<M: serde::de::DeserializeOwned>(bag: &Bag, topic: &str) -> Vec<M> {
    let index = bag.topics().iter().position(|known| known.name == topic);
    let index = index.unwrap_or_else(|| panic!("{topic} is not in the bag"));
    let (mut all, mut found) = (bag.messages(), Vec::new());
    while let Some(message) = all.next_message().expect("a readable bag") {
        if message.topic == index {
            found.push(message_from_sample(&message.data).expect("a message"));
        }
    }
    found
}

/// A node beside the cell.
pub(crate) fn integrator(domain: &Domain) -> Node {
    let args = RosArgs::default().with_domain_id(domain.id()).with_namespace(NAMESPACE);
    Node::new(NodeOptions::new("integrator", &args)).expect("a node")
}

/// A client of the planner, with the thread that spins its node, once the planner is there.
pub(crate) fn planner_client(node: &Node, machine: &Guarded) -> (ActionClient<RunJob>, SpinThread) {
    let jobs: ActionClient<RunJob> = node.action_client("job_planner/run_job").expect("a client");
    let spin = node.spin_in_thread().expect("a thread");
    jobs.wait_for_server(PATIENCE).unwrap_or_else(|error| panic!("{error}{}", machine.stderr()));
    (jobs, spin)
}

/// Recorder with a new bag, interpolator and planner beside the machine.
pub(crate) fn recorded_cell(domain: &Domain, bag: &Path) -> (Guarded, Processes) {
    let mut recorder = in_domain(env!("CARGO_BIN_EXE_run_logger"), domain);
    recorder.args(["--ros-args", "-r", &format!("__ns:={NAMESPACE}")]);
    let recorder = Guarded::start("run_logger", recorder.args(["-p", &format!("bag_dir:={}", bag.display())]));
    raise(&recorder.id().to_string());
    let cell = Processes::start_some(domain, NAMESPACE, &["axis_interpolator", "job_planner"]);
    raise(&cell.id("axis_interpolator").to_string());
    (recorder, cell)
}

/// Numbers of the active alarms, whenever they change.
pub(crate) fn subscribe_to_alarms(node: &Node) -> (Subscription, Receiver<BTreeSet<u16>>) {
    let (sender, alarms) = channel();
    let subscription = node
        .subscribe("machine/alarms", &Qos::latched(1), move |message: MachineAlarms, _| {
            let _over = sender.send(message.alarms.iter().map(|alarm| alarm.number).collect());
        })
        .expect("a subscription");
    (subscription, alarms)
}

/// Waits until the recorder has subscribed to the setpoints; what is sent before is not in its bag.
pub(crate) fn wait_for_recorder(node: &Node) {
    let topic = format!("{NAMESPACE}/machine/setpoints");
    let (sender, statuses) = channel();
    let _status = node
        .subscribe("run_logger/status", &Qos::default_topic(), move |message: RecorderStatus, _| {
            let _over = sender.send(message.topics.iter().any(|record| record.topic == topic));
        })
        .expect("a subscription");
    let deadline = Instant::now() + PATIENCE;
    while !statuses.recv_timeout(PATIENCE).expect("a status of the recorder") {
        assert!(Instant::now() < deadline, "the recorder does not record the setpoints");
    }
}
