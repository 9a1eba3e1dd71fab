//! A machine behind the HAL of LinuxCNC: drives and switches simulated by its own components, without hardware and without real time.
//!
//! HAL refuses root and lets only its own user in, so HAL and the node run as an ordinary user here.

use crate::support;

use camwright::machine::contact_law::ContactLaw;
use camwright_analysis::report;
use camwright_analysis::rerun::{self, Window};
use camwright_bag::Bag;
use camwright_files::locate::locate;
use camwright_files::machine_file;
use camwright_machine_check::{ClauseVerdict, Moving, Settings, check};
use camwright_machine_hal::simulation_text;
use camwright_msgs::camwright_msgs::action::{Home, HomeGoal, MoveTo, MoveToGoal, RunJob, RunJobGoal};
use camwright_msgs::camwright_msgs::msg::{GaugeReading, MachineAlarms, MachineStream, RecorderStatus};
use camwright_msgs::cdr::message_from_sample;
use camwright_msgs::diagnostic_msgs::msg::DiagnosticArray;
use camwright_msgs::rcl_interfaces::msg::Log;
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use camwright_ros::{ActionClient, GoalStatus, Node, NodeOptions, Qos, RosArgs, Shutdown, Subscription};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use support::command::Shared;
use support::processes::{Processes, fresh_bag, in_domain};
use support::{Domain, Guarded, PATIENCE, in_ci, tutorial};

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
/// A computer has one HAL. A test that waits for it keeps a thread of the test program, so that little else runs beside HAL: without a real-time
/// kernel its timing suffers from load.
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
/// Servo periods without setpoints after which HAL switches the drives off.
const SILENCE_PERIODS: usize = 500;

/// A command of the user of HAL. Where the tests have the right, it takes precedence over those that run beside it: a machine has a
/// computer to itself.
fn as_user(program: &Path, home: &Path) -> Command {
    let id = Command::new("id").arg("-u").output().expect("id is part of coreutils");
    let mut command = if id.stdout.trim_ascii() == b"0" {
        let mut command = Command::new("nice");
        command.args(["--adjustment=-15", "setpriv"]);
        command.args([&format!("--reuid={NOBODY}"), &format!("--regid={NOBODY}"), "--clear-groups"]).arg(program);
        command
    } else {
        Command::new(program)
    };
    command.env("HOME", home).current_dir(home);
    command
}

/// A folder of the user of HAL, with the programs: not below the repository, which another user may not be able to read.
struct HomeFolder {
    path: PathBuf,
    _alone: MutexGuard<'static, ()>,
}

impl HomeFolder {
    /// `None`, loudly, where LinuxCNC is not installed.
    fn new(programs: &[&str]) -> Option<Self> {
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
struct WatchedPeriod {
    sequence: u64,
    commands: [f64; 3],
    encoders: [f64; 3],
    power: [bool; 3],
    wheel_runs: bool,
}

impl WatchedPeriod {
    /// A line of `halsampler`.
    fn read(line: &str) -> Self {
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

    fn is_off(&self) -> bool {
        !self.power.contains(&true) && !self.wheel_runs
    }
}

/// Servo periods as they come.
struct PeriodWatch(Guarded);

impl PeriodWatch {
    /// The periods up to the one with which they are what is waited for.
    fn until(
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
fn moves(periods: &[WatchedPeriod], axis: usize) -> bool {
    let [.., before, now] = periods else { return false };
    before.commands[axis].to_bits() != now.commands[axis].to_bits()
}

/// Returns whether no command has changed for 300 periods.
fn rests(periods: &[WatchedPeriod]) -> bool {
    let Some(last) = periods.len().checked_sub(300).map(|from| &periods[from..]) else { return false };
    last.iter().all(|period| period.commands.map(f64::to_bits) == last[0].commands.map(f64::to_bits))
}

/// HAL with the simulation of the shipped grinder.
struct Hal {
    halrun: Guarded,
    home: HomeFolder,
}

impl Hal {
    /// `None`, loudly, where LinuxCNC is not installed. `turns` is where C stands, in turns from its origin.
    fn start(turns: Option<&str>) -> Option<Self> {
        Self::start_with(&[], turns)
    }

    /// With these keys of the machine.
    fn start_with(keys: &[(&str, &str)], turns: Option<&str>) -> Option<Self> {
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
        Some(hal)
    }

    /// Every servo period from now on.
    fn watch(&self) -> PeriodWatch {
        let mut sampler = as_user(Path::new("stdbuf"), &self.home.path);
        PeriodWatch(Guarded::start("halsampler", sampler.args(["-oL", "halsampler", "-c", "1"])))
    }

    /// Output of `halcmd`; `None` if it fails.
    fn halcmd(&self, words: &[&str]) -> Option<String> {
        let output = as_user(Path::new("halcmd"), &self.home.path).args(words).output().expect("it is installed");
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    }

    fn set(&self, pin: &str, value: &str) {
        assert!(self.halcmd(&["setp", pin, value]).is_some(), "halcmd setp {pin} {value}");
    }

    fn node(&self, domain: &Domain) -> Guarded {
        let mut command = as_user(&self.home.path.join("bin/machine_hal"), &self.home.path);
        command.env("ROS_DOMAIN_ID", domain.id().to_string());
        command.args(["--ros-args", "-r", &format!("__ns:={NAMESPACE}")]);
        command.args(["-p", "machine:=machine.yaml", "-p", "state_file:=none"]);
        Guarded::start("machine_hal", &mut command)
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

/// Sends the job.
fn send(jobs: &ActionClient<RunJob>, machine: &Guarded) -> camwright_ros::ClientGoal<RunJob> {
    let overrides = JOB.map(String::from).into();
    let goal = RunJobGoal { job: "eccentric".into(), overrides, ..RunJobGoal::default() };
    let sent = jobs.send_goal(goal, drop, PATIENCE).expect("an answer");
    assert!(sent.accepted(), "rejected{}", machine.stderr());
    sent
}

/// The messages of a topic in a bag.
fn messages<M: serde::de::DeserializeOwned>(bag: &Bag, topic: &str) -> Vec<M> {
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

/// Setpoints that were sent, tick by tick, to the bit: position, velocity and acceleration of C, X and Z.
fn setpoints(bag: &Path) -> Vec<[[u64; 3]; 3]> {
    let bag = Bag::open(bag).expect("a bag");
    let mut ticks = BTreeMap::new();
    for chunk in messages::<JointTrajectory>(&bag, &format!("{NAMESPACE}/machine/setpoints")) {
        let stamp_ns = i64::from(chunk.header.stamp.sec) * 1_000_000_000 + i64::from(chunk.header.stamp.nanosec);
        for (tick, point) in (0_i64..).zip(&chunk.points) {
            let since = &point.time_from_start;
            // Behind the setpoints of every tick follows the stop.
            if i64::from(since.sec) * 1_000_000_000 + i64::from(since.nanosec) != tick * 1_000_000 {
                break;
            }
            let axis = |axis: usize| {
                [&point.positions, &point.velocities, &point.accelerations].map(|values| values[axis].to_bits())
            };
            ticks.insert(stamp_ns + tick * 1_000_000, [axis(0), axis(1), axis(2)]);
        }
    }
    ticks.into_values().collect()
}

/// Recorder with a new bag, interpolator and planner beside the machine.
fn recorded_cell(domain: &Domain, bag: &Path) -> (Guarded, Processes) {
    let mut recorder = in_domain(env!("CARGO_BIN_EXE_run_logger"), domain);
    recorder.args(["--ros-args", "-r", &format!("__ns:={NAMESPACE}")]);
    let recorder = Guarded::start("run_logger", recorder.args(["-p", &format!("bag_dir:={}", bag.display())]));
    (recorder, Processes::start_some(domain, NAMESPACE, &["axis_interpolator", "job_planner"]))
}

/// Numbers of the active alarms, whenever they change.
fn subscribe_to_alarms(node: &Node) -> (Subscription, Receiver<BTreeSet<u16>>) {
    let (sender, alarms) = channel();
    let subscription = node
        .subscribe("machine/alarms", &Qos::latched(1), move |message: MachineAlarms, _| {
            let _over = sender.send(message.alarms.iter().map(|alarm| alarm.number).collect());
        })
        .expect("a subscription");
    (subscription, alarms)
}

/// Waits until the recorder has subscribed to the setpoints; what is sent before is not in its bag.
fn wait_for_recorder(node: &Node) {
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

/// The same job on the simulated machine: its bag.
fn simulated() -> PathBuf {
    let (domain, bag) = (Domain::reserve(), fresh_bag("hal-simulated"));
    let cell = Processes::start(&domain, NAMESPACE, &["machine:=cam_grinder_hal"], &bag);
    let args = RosArgs::default().with_domain_id(domain.id()).with_namespace(NAMESPACE);
    let node = Node::new(NodeOptions::new("integrator", &args)).expect("a node");
    let jobs: ActionClient<RunJob> = node.action_client("job_planner/run_job").expect("a client");
    let spin = node.spin_in_thread().expect("a thread");
    jobs.wait_for_server(PATIENCE).expect("the planner");
    wait_for_recorder(&node);
    let overrides = JOB.map(String::from).into();
    let goal = RunJobGoal { job: "eccentric".into(), overrides, ..RunJobGoal::default() };
    let sent = jobs.send_goal(goal, drop, PATIENCE).expect("an answer");
    let (status, result) = sent.result(PATIENCE).expect("it ends");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    drop(spin);
    cell.end()
}

/// A bag of a real machine: its drives, their timing, a replay of the interpolator, a report that states what was measured.
fn judge_bag(bag: &Path) {
    let verdict = rerun::rerun(bag).expect("the bag holds the inputs");
    let text = verdict.to_text();
    assert!(verdict.is_identical() && verdict.drives.as_deref() == Some("hal"), "{text}");
    assert!(verdict.setpoints > 5_000 && verdict.ticks == 0, "{text}");
    assert!(text.contains("the machine is real (hal): only the interpolator is recomputed"), "{text}");
    let page = report::html(bag).expect("a report");
    for words in ["Real drives (hal)", "as if wheel and part were rigid", "of 150 setpoints waited in the queue"] {
        assert!(page.contains(words), "{words} is not in the report");
    }
    let diagnostics: Vec<DiagnosticArray> = messages(&Bag::open(bag).expect("a bag"), "/diagnostics");
    let mut timing = diagnostics.iter().flat_map(|array| &array.status);
    let timing =
        timing.rfind(|status| status.name == format!("{NAMESPACE}/machine_hal: drive_queue")).expect("a status");
    let keys: Vec<&str> = timing.values.iter().map(|pair| pair.key.as_str()).collect();
    assert_eq!(keys, ["queued", "min_queued", "queue_ticks", "max_jitter_us", "underruns"]);
}

/// Beside the part, where the axes have only their own zeros, real and simulated switches differ: HAL sees an edge within a servo period.
/// At the part, C and X go the same way to the bit.
fn same_setpoints(real: &Path, simulated: &Path) {
    const BESIDE_M: f64 = 0.03;
    let (real, simulated) = (setpoints(real), setpoints(simulated));
    let same = real.iter().zip(&simulated).take_while(|(one, other)| one == other).count();
    assert!(same > 2_000, "up to the origin detector everything is the same, not only {same} ticks");
    let at_the_part = |setpoints: &[[[u64; 3]; 3]]| -> Vec<[[u64; 3]; 2]> {
        let near = setpoints.iter().filter(|[_, x, _]| f64::from_bits(x[0]) < BESIDE_M);
        near.map(|[c, x, _]| [*c, *x]).collect()
    };
    let (real, simulated) = (at_the_part(&real), at_the_part(&simulated));
    assert!(real.len() > 3_000, "{} ticks", real.len());
    let first = real.iter().zip(&simulated).position(|(one, other)| one != other);
    assert_eq!((first, real.len()), (None, simulated.len()), "the first setpoint that differs, and the number of them");
}

#[test]
fn a_job_runs_over_hal_and_every_fault_of_hal_is_an_alarm() {
    let Some(hal) = Hal::start(None) else { return };
    let domain = Domain::reserve();
    let mut machine = hal.node(&domain);
    let bag = fresh_bag("hal");
    let (mut recorder, cell) = recorded_cell(&domain, &bag);
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
    let (_alarms, alarms) = subscribe_to_alarms(&node);
    let jobs: ActionClient<RunJob> = node.action_client("job_planner/run_job").expect("a client");
    let _spin = node.spin_in_thread().expect("a thread");
    jobs.wait_for_server(PATIENCE).unwrap_or_else(|error| panic!("{error}{}", machine.stderr()));
    let _command = Shared::for_cell(&domain, NAMESPACE);
    wait_for_recorder(&node);

    // A whole job: the drives follow every setpoint to the count, and the form error is that of the encoders.
    let (status, result) = send(&jobs, &machine).result(PATIENCE).expect("it ends");
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

    recorder.interrupt();
    assert!(recorder.wait(PATIENCE).success(), "{}", recorder.stderr());

    // The emergency stop chain of HAL opens in the cut.
    let job = send(&jobs, &machine);
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
    judge_bag(&bag);
    let simulated = simulated();
    same_setpoints(&bag, &simulated);
    let compared = rerun::against(&bag, Some(&simulated), Window::default()).expect("both hold their inputs");
    let text = compared.to_text();
    assert!(compared.is_same() && text.starts_with("the other run cuts the same: C and X of "), "{text}");
    for bag in [bag, simulated] {
        std::fs::remove_dir_all(bag).expect("our bag");
    }
}

/// The check of the machine contract: C turns out of its origin detector, so that an edge and a closed input are seen.
#[test]
fn a_machine_behind_hal_keeps_its_contract() {
    const SEEN: [u8; 21] = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 16, 20, 21, 30, 31, 33, 40];
    // A virtual computer pauses for longer than the queue lasts.
    for attempt in 1.. {
        let Some(hal) = Hal::start(Some("0.001")) else { return };
        let domain = Domain::reserve();
        let mut machine = hal.node(&domain);
        let args = RosArgs::default().with_domain_id(domain.id()).with_namespace(NAMESPACE);
        let moving = Some(Moving { joint: "c_axis".into(), distance: 0.5 });
        let settings = Settings { listen: Duration::from_secs(2), patience: PATIENCE, moving };
        let checked = check(&args, &settings, &Shutdown::new(), &|_| {}).expect("a machine that is free");
        machine.interrupt();
        assert!(machine.wait(PATIENCE).success(), "{}", machine.stderr());
        let report = checked.report;
        let (kept, broken) = (report.clauses(ClauseVerdict::Kept), report.clauses(ClauseVerdict::Broken));
        if attempt < 3 && !broken.is_empty() {
            eprintln!("once more, after:\n{report}\n{}", machine.stderr());
            continue;
        }
        assert_eq!((kept, broken), (SEEN.to_vec(), Vec::new()), "{report}\n{}", machine.stderr());
        return;
    }
}

/// An X axis whose encoder is zeroed by its index marks, 8 mm apart; its switch closes 14 mm from where it stands at power-up.
const INDEXED: [(&str, &str); 2] = [
    (
        "  power_up_position_mm: 150.0\n",
        "  power_up_position_mm: 150.0\n  home: {search_velocity_mm_s: 10, latch_velocity_mm_s: -3, switch_mm: 164, \
         home_mm: 150, use_index: true, index_pitch_mm: 8}\n",
    ),
    (
        "limit: x-limit.out}",
        "limit: x-limit.out, home: x-home.out, index_enable: x-index.index-enable, index_position: x-since-mark.out}",
    ),
];

/// The marks lie at multiples of 8 mm: whatever was before, the axis stands on the same count of its encoder at home.
#[test]
fn homing_at_an_index_mark_finds_the_same_zero_from_everywhere() {
    const COUNT_MM: f64 = 1e-5;
    let Some(hal) = Hal::start_with(&INDEXED, None) else { return };
    let domain = Domain::reserve();
    let machine = hal.node(&domain);
    let cell = Processes::start_some(&domain, NAMESPACE, &["axis_interpolator", "job_planner"]);
    let args = RosArgs::default().with_domain_id(domain.id()).with_namespace(NAMESPACE);
    let node = Node::new(NodeOptions::new("integrator", &args)).expect("a node");
    let home: ActionClient<Home> = node.action_client("axis_interpolator/home").expect("a client");
    let moves: ActionClient<MoveTo> = node.action_client("axis_interpolator/move_to").expect("a client");
    let spin = node.spin_in_thread().expect("a thread");
    home.wait_for_server(PATIENCE).unwrap_or_else(|error| panic!("{error}{}", machine.stderr()));
    moves.wait_for_server(PATIENCE).expect("the interpolator");
    let command = Shared::for_cell(&domain, NAMESPACE);
    // Where it stands at power-up, just before a mark, just behind one, on its switch.
    for start_m in [None, Some(0.159_99), Some(0.152_01), Some(0.171)] {
        if let Some(start) = start_m {
            let goal = MoveToGoal { joints: vec!["x_axis".into()], positions: vec![start], ..MoveToGoal::default() };
            let moved = moves.send_goal(goal, drop, PATIENCE).expect("an answer").result(PATIENCE).expect("it ends").1;
            assert!(moved.success, "{}{}", moved.message, machine.stderr());
        }
        let deadline = Instant::now() + PATIENCE;
        let homing = loop {
            let goal = HomeGoal { joints: vec!["x_axis".into()] };
            let sent = home.send_goal(goal, drop, PATIENCE).expect("an answer");
            if sent.accepted() {
                break sent;
            }
            // Until the first message of the machine has come.
            assert!(Instant::now() < deadline, "no homing is accepted{}", machine.stderr());
            std::thread::sleep(Duration::from_millis(100));
        };
        let homed = homing.result(PATIENCE).expect("it ends").1;
        assert!(homed.success, "from {start_m:?}: {}{}", homed.message, machine.stderr());
        // Its encoder began to count at power-up, at the home position.
        let stands = hal.halcmd(&["getp", "x-encoder.out"]).expect("the encoder");
        let stands: f64 = stands.trim().parse().expect("a number");
        assert!(stands.abs() <= COUNT_MM, "from {start_m:?} m it stands {stands} mm from home");
    }
    drop((command, spin, cell));
}

/// Contact of the machine in the test of the gauge: five sixths of a runout are left after each turn.
const SOFT: [(&str, &str); 1] = [(
    "machine_stiffness: [{z_mm: 80.0, n_um: 45.0}, {z_mm: 150.0, n_um: 38.0}, {z_mm: 225.0, n_um: 45.0}]",
    "machine_stiffness: [{z_mm: 80.0, n_um: 6.0}, {z_mm: 225.0, n_um: 6.0}]",
)];
/// A journal that is measured, ground and corrected. Behind HAL no drive reports the force of a push.
const GAUGED: [&str; 6] = [
    "machine=cam_grinder_hal",
    "roughing=[{name: rough, infeed: {total_mm: 0.27, per_block_um: 0.005, spark_out_turns: 1}, work_speed_rpm: 60}]",
    "identification=null",
    "runout_correction.stiffness=nominal",
    "measure_stock.margin_um=60",
    "lobes=[{name: J1, station: LS1, profile: journal, phase_deg: 0, width_mm: 20}]",
];

/// The journal in HAL (mm): the parameters of its components, followed tick by tick with the positions of the bag.
struct PlantedJournal {
    lowest_mm: f64,
    radius_mm: f64,
    wave_mm: f64,
}

impl PlantedJournal {
    const RAW_MM: f64 = 20.12;
    const WAVE_MM: f64 = 0.1;
    /// Angle of the contact behind the wheel.
    const BEHIND_RAD: f64 = FRAC_PI_2;

    fn raw() -> Self {
        Self { lowest_mm: f64::INFINITY, radius_mm: Self::RAW_MM, wave_mm: Self::WAVE_MM }
    }

    fn law() -> ContactLaw {
        ContactLaw::new(6_000.0, 30_000.0, 16.0).expect("a law")
    }

    /// Its reading in the next tick (mm).
    fn read(&mut self, c_rad: f64, x_mm: f64) -> f64 {
        self.lowest_mm = self.lowest_mm.min(x_mm);
        if self.lowest_mm < Self::RAW_MM {
            let gain = 1.0 - Self::law().decay().powf(1e-3);
            self.radius_mm += gain * (self.lowest_mm - self.radius_mm);
            self.wave_mm -= gain * self.wave_mm;
        }
        self.radius_mm + self.wave_mm * (c_rad - Self::BEHIND_RAD).cos()
    }

    /// Runout of the ground journal (mm) from its readings over the angle of C: each phase as it left the wheel before it was withdrawn,
    /// and after that by the law of the contact.
    fn runout_mm(readings: &[(f64, f64, f64)]) -> f64 {
        const WITHDRAWN_RAD: f64 = 0.7 * TAU;
        let at = |c_rad: f64| readings[readings.partition_point(|(at, ..)| *at < c_rad).min(readings.len() - 1)];
        let (rest_rad, law) = (readings[readings.len() - 1].0, Self::law());
        // A phase that leaves the wheel at an angle is under the gauge later; the components know no force below which nothing is cut.
        let left_mm = |c_rad: f64| at(c_rad + Self::BEHIND_RAD).2 + law.threshold_n() / law.machine_n_mm();
        let radii = (1..=720).map(|step| {
            let c_rad = rest_rad - TAU + TAU * f64::from(step) / 720.0;
            match c_rad <= rest_rad - WITHDRAWN_RAD {
                true => left_mm(c_rad),
                false => law.radius_after_mm(left_mm(c_rad - TAU), at(c_rad).1),
            }
        });
        let (low, high) = radii.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), mm| (low.min(mm), high.max(mm)));
        high - low
    }
}

/// HAL refuses a machine whose gauge is on a pin that is not there, or of another type.
fn refuse_gauge(hal: &Hal, domain: &Domain) {
    let path = hal.home.path.join("machine.yaml");
    let machine = std::fs::read_to_string(&path).expect("the machine");
    let wrong =
        machine.replace("gauge-reading.out", "gauge-reading.position").replace("gauge-valid.out", "gauge-wave.out");
    std::fs::write(hal.home.path.join("wrong.yaml"), wrong).expect("our folder");
    let mut node = as_user(&hal.home.path.join("bin/machine_hal"), &hal.home.path);
    node.env("ROS_DOMAIN_ID", domain.id().to_string());
    let output = node.args(["--ros-args", "-p", "machine:=wrong.yaml", "-p", "state_file:=none"]).output();
    let output = output.expect("the node starts");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{text}");
    for finding in [
        "hal.gauge.reading: there is no pin gauge-reading.position",
        "hal.gauge.valid: gauge-wave.out is float; it must be bit",
    ] {
        assert!(text.contains(finding), "{finding} is not in\n{text}");
    }
}

/// A gauge of HAL measures the stock, then the runout of a journal, which the planner corrects: both are those that HAL was given.
#[test]
fn a_journal_is_gauged_over_hal_and_its_runout_is_the_planted_one() {
    let Some(hal) = Hal::start_with(&SOFT, None) else { return };
    let domain = Domain::reserve();
    refuse_gauge(&hal, &domain);
    hal.set("gauge-to-wave.in1", &PlantedJournal::WAVE_MM.to_string());
    let machine = hal.node(&domain);
    let bag = fresh_bag("hal-gauge");
    let (mut recorder, cell) = recorded_cell(&domain, &bag);
    let args = RosArgs::default().with_domain_id(domain.id()).with_namespace(NAMESPACE);
    let node = Node::new(NodeOptions::new("integrator", &args)).expect("a node");
    let jobs: ActionClient<RunJob> = node.action_client("job_planner/run_job").expect("a client");
    let spin = node.spin_in_thread().expect("a thread");
    jobs.wait_for_server(PATIENCE).unwrap_or_else(|error| panic!("{error}{}", machine.stderr()));
    let command = Shared::for_cell(&domain, NAMESPACE);
    wait_for_recorder(&node);
    let goal = RunJobGoal {
        job: "journal_runout".into(),
        overrides: GAUGED.map(String::from).into(),
        ..RunJobGoal::default()
    };
    let job = jobs.send_goal(goal, drop, PATIENCE).expect("an answer");
    let (status, result) = job.result(3 * PATIENCE).expect("it ends");
    assert_eq!(status, GoalStatus::Succeeded, "{}{}", result.message, machine.stderr());
    recorder.interrupt();
    assert!(recorder.wait(PATIENCE).success(), "{}", recorder.stderr());
    drop((command, spin, cell));

    let opened = Bag::open(&bag).expect("a bag");
    let readings: Vec<GaugeReading> = messages(&opened, &format!("{NAMESPACE}/machine/gauge"));
    let times: Vec<_> = readings.chunk_by(|one, next| next.tick == one.tick + 1).collect();
    let [under_gauge, cut, correction] = times.as_slice() else { panic!("{} times", times.len()) };
    assert!(under_gauge.len() > 900 && cut.len() > 10_000 && correction.len() > 1_000, "a reading in every tick");
    let is_ours =
        |reading: &GaugeReading| reading.lobe == "J1" && reading.kind == GaugeReading::RADIUS && !reading.pushing;
    assert!(readings.iter().all(is_ours));
    // Each reading belongs to the encoders of its own servo period; an edge of the origin is seen within one.
    let mut planted = PlantedJournal::raw();
    let mut followed = Vec::new();
    for reading in under_gauge.iter().chain(*cut) {
        let (c_rad, x_mm, mm) = (reading.spindle_angle, 1e3 * reading.wheel_position, 1e3 * reading.reading);
        let expected_mm = planted.read(c_rad, x_mm);
        assert!((mm - expected_mm).abs() < 2e-4, "tick {}: {mm} mm instead of {expected_mm}", reading.tick);
        followed.push((c_rad, x_mm, expected_mm));
    }
    let (low, high) = under_gauge.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), reading| {
        (low.min(1e3 * reading.reading), high.max(1e3 * reading.reading))
    });
    let eccentric_mm = 0.5 * (high - low);
    assert!((eccentric_mm - PlantedJournal::WAVE_MM).abs() < 1e-5, "eccentric by {eccentric_mm} mm");
    let logs: Vec<Log> = messages(&opened, "/rosout");
    let stock = "lobe J1: 220.0 um of stock by the gauge";
    assert!(logs.iter().any(|log| log.msg.starts_with(stock)), "{stock}: nobody logged it");
    let (measured_mm, planted_mm) =
        (1e3 * result.lobes[0].runout_before, PlantedJournal::runout_mm(&followed[under_gauge.len()..]));
    eprintln!("runout {measured_mm:.6} mm measured, {planted_mm:.6} mm planted");
    assert!((measured_mm - planted_mm).abs() < 0.01 * planted_mm, "{measured_mm} mm, planted {planted_mm} mm");
    let verdict = rerun::rerun(&bag).expect("the bag holds the inputs");
    assert!(verdict.is_identical() && verdict.motions > 2, "{}", verdict.to_text());
    std::fs::remove_dir_all(bag).expect("our bag");
}

/// HAL while a node ends in the middle of a job: the periods from the motion to the end of power.
fn end_in_motion(hal: &Hal, signal: &str, axes: &[usize]) -> (Vec<WatchedPeriod>, Guarded) {
    let domain = Domain::reserve();
    let machine = hal.node(&domain);
    let cell = Processes::start_some(&domain, NAMESPACE, &["axis_interpolator", "job_planner"]);
    let args = RosArgs::default().with_domain_id(domain.id()).with_namespace(NAMESPACE);
    let node = Node::new(NodeOptions::new("integrator", &args)).expect("a node");
    let jobs: ActionClient<RunJob> = node.action_client("job_planner/run_job").expect("a client");
    let spin = node.spin_in_thread().expect("a thread");
    jobs.wait_for_server(PATIENCE).unwrap_or_else(|error| panic!("{error}{}", machine.stderr()));
    let command = Shared::for_cell(&domain, NAMESPACE);
    let job = send(&jobs, &machine);
    let mut watch = hal.watch();
    watch.until(signal, &machine, |periods| axes.iter().all(|axis| moves(periods, *axis)));
    machine.signal(signal);
    // Power is off, and has been for a while.
    let is_off = |periods: &[WatchedPeriod]| {
        periods.len() > 300 && periods[periods.len() - 300..].iter().all(WatchedPeriod::is_off)
    };
    let periods = watch.until(signal, &machine, is_off);
    drop((job, command, spin, cell));
    (periods, machine)
}

/// A node that is asked to end stops the axes on the path. One that dies or stands still leaves them at its last setpoint. HAL switches the
/// drives off when nothing comes any more, and the next node starts at rest.
#[test]
fn drives_are_at_rest_and_off_after_the_node_has_ended_in_motion() {
    let Some(hal) = Hal::start(None) else { return };
    // C searches its origin, or turns while the wheel moves to the part.
    for (signal, axes) in [("KILL", &[0][..]), ("STOP", &[0]), ("TERM", &[0, 1])] {
        let (periods, mut machine) = end_in_motion(&hal, signal, axes);
        // Not one setpoint is lost or repeated while they come.
        let last_sequence = periods.last().expect("periods").sequence;
        let silent = periods.iter().position(|period| period.sequence == last_sequence).expect("it is there");
        for pair in periods[..=silent].windows(2) {
            assert_eq!(pair[1].sequence, pair[0].sequence + 1, "{signal}");
        }
        let end = &periods[silent];
        for period in &periods[silent..] {
            let [held, sent] = [period, end].map(|period| period.commands.map(f64::to_bits));
            assert_eq!(held, sent, "{signal}: the last setpoint holds");
        }
        let off = periods[silent..].iter().position(WatchedPeriod::is_off).expect("they go off");
        assert!((SILENCE_PERIODS - 5..SILENCE_PERIODS + 20).contains(&off), "{signal}: off after {off} periods");
        let rest = periods.last().expect("periods");
        for (encoder, command) in rest.encoders.iter().zip(rest.commands) {
            assert!((encoder - command).abs() < 1e-5, "{signal}: rests at {rest:?}");
        }
        if signal == "STOP" {
            machine.signal("CONT");
            // Threads of DDS do not survive a stop (nodes/ros/UPSTREAM.md).
            assert_eq!(machine.wait(PATIENCE).code(), Some(70), "{}", machine.stderr());
        } else {
            let status = machine.wait(PATIENCE);
            assert_eq!(status.success(), signal == "TERM", "{signal}: {status} {}", machine.stderr());
        }
        if signal == "TERM" {
            // No acceleration beyond that of a stop (degrees or mm for a period, twice), and two counts.
            for (axis, bound) in [(0, 0.0172), (1, 0.01), (2, 0.002)] {
                let positions = periods.iter().map(|period| period.commands[axis]).collect::<Vec<_>>();
                let largest = positions.windows(3).map(|at| (at[2] - 2.0 * at[1] + at[0]).abs()).fold(0.0, f64::max);
                assert!(largest < 1.2 * bound + 4e-4, "axis {axis} jumps by {largest}");
            }
        }
    }
}

/// Id of a program that the node has started.
fn program_of(machine: &Guarded, name: &str) -> String {
    let folders = std::fs::read_dir("/proc").expect("Linux").flatten();
    let ids = folders.filter_map(|folder| folder.file_name().into_string().ok());
    let is_it = |id: &String| {
        let text = |file: &str| std::fs::read_to_string(format!("/proc/{id}/{file}")).unwrap_or_default();
        let parent = format!("PPid:\t{}\n", machine.id());
        text("comm").trim_end() == name && text("status").contains(&parent)
    };
    ids.filter(|id| id.bytes().all(|octet| octet.is_ascii_digit())).find(is_it).expect("the program")
}

fn signal(id: &str, signal: &str) {
    let sent = Command::new("kill").args([&format!("-{signal}"), id]).status().expect("kill is installed");
    assert!(sent.success(), "cannot signal {id}");
}

/// A process beside the node that dies, or stands still for 2 s: the axes rest, with the alarm for it.
#[test]
fn what_dies_or_stands_still_beside_the_node_ends_at_rest_with_its_alarm() {
    let Some(hal) = Hal::start(None) else { return };
    let domain = Domain::reserve();
    let machine = hal.node(&domain);
    let mut sender = in_domain(env!("CARGO_BIN_EXE_axis_interpolator"), &domain);
    let sender = Guarded::start("axis_interpolator", sender.args(["--ros-args", "-r", &format!("__ns:={NAMESPACE}")]));
    let cell = Processes::start_some(&domain, NAMESPACE, &["job_planner"]);
    let args = RosArgs::default().with_domain_id(domain.id()).with_namespace(NAMESPACE);
    let node = Node::new(NodeOptions::new("integrator", &args)).expect("a node");
    let (_alarms, alarms) = subscribe_to_alarms(&node);
    let jobs: ActionClient<RunJob> = node.action_client("job_planner/run_job").expect("a client");
    let spin = node.spin_in_thread().expect("a thread");
    jobs.wait_for_server(PATIENCE).unwrap_or_else(|error| panic!("{error}{}", machine.stderr()));
    let command = Shared::for_cell(&domain, NAMESPACE);
    let mut watch = hal.watch();
    let at_rest = |what: &str, periods: &[WatchedPeriod]| {
        let rest = periods.last().expect("periods");
        for (encoder, command) in rest.encoders.iter().zip(rest.commands) {
            assert!((encoder - command).abs() < 1e-4, "{what}: rests at {rest:?}");
        }
    };
    let is_off = |periods: &[WatchedPeriod]| periods.last().is_some_and(WatchedPeriod::is_off);

    // The queue of HAL runs empty. What was sent before reaches the drives when the program goes on: the path has no gap.
    let job = send(&jobs, &machine);
    watch.until("motion", &machine, |periods| moves(periods, 0));
    let streamer = program_of(&machine, "halstreamer");
    signal(&streamer, "STOP");
    let periods = watch.until("an empty queue", &machine, |periods| periods.len() >= 2000);
    assert!(rests(&periods) && is_off(&periods), "{:?}", periods.last());
    at_rest("an empty queue", &periods);
    wait_for_alarms(&alarms, |numbers| numbers.contains(&80));
    signal(&streamer, "CONT");
    let stood_at = periods.last().expect("periods").sequence;
    let follows = |periods: &[WatchedPeriod]| periods.last().is_some_and(|period| period.sequence > stood_at + 300);
    at_rest("what was sent", &watch.until("what was sent", &machine, |periods| follows(periods) && rests(periods)));
    assert_eq!(job.result(PATIENCE).expect("it ends").0, GoalStatus::Aborted);
    reset(&node);
    wait_for_alarms(&alarms, BTreeSet::is_empty);
    at_rest("after a reset", &watch.until("a reset", &machine, rests));

    // The sender is silent: the machine follows the stop of its last chunk.
    let job = send(&jobs, &machine);
    watch.until("motion", &machine, |periods| moves(periods, 0));
    sender.signal("KILL");
    let periods = watch.until("a silent sender", &machine, rests);
    at_rest("a silent sender", &periods);
    // No acceleration beyond that of a stop (degrees or mm for a period, twice), and two counts.
    for (axis, bound) in [(0, 0.0172), (1, 0.01), (2, 0.002)] {
        let positions = periods.iter().map(|period| period.commands[axis]).collect::<Vec<_>>();
        let largest = positions.windows(3).map(|at| (at[2] - 2.0 * at[1] + at[0]).abs()).fold(0.0, f64::max);
        assert!(largest < 1.2 * bound + 4e-4, "axis {axis} jumps by {largest}");
    }
    wait_for_alarms(&alarms, |numbers| numbers.contains(&80));
    assert_eq!(job.result(PATIENCE).expect("it ends").0, GoalStatus::Aborted);
    reset(&node);
    wait_for_alarms(&alarms, BTreeSet::is_empty);

    // Nobody reads the samples any more: where the axes are is unknown, and they lose their power.
    signal(&program_of(&machine, "halsampler"), "KILL");
    wait_for_alarms(&alarms, |numbers| numbers.contains(&166));
    at_rest("no samples", &watch.until("no samples", &machine, |periods| rests(periods) && is_off(periods)));
    drop((sender, command, spin, cell));
}

#[test]
fn linuxcnc_machine() {
    let programs = [
        env!("CARGO_BIN_EXE_camwright"),
        env!("CARGO_BIN_EXE_machine_hal"),
        env!("CARGO_BIN_EXE_axis_interpolator"),
        env!("CARGO_BIN_EXE_job_planner"),
        env!("CARGO_BIN_EXE_run_logger"),
    ];
    // A virtual computer pauses for longer than the queue lasts.
    for attempt in 1.. {
        let Some(home) = HomeFolder::new(&programs) else { return };
        let shell = as_user(Path::new("bash"), &home.path);
        match tutorial::follow_in("linuxcnc-machine.md", (&home.path, &home.path.join("bin")), shell) {
            Ok(()) => return,
            Err(difference) if attempt < 3 && difference.contains("alarm 80") => {
                eprintln!("once more, after:\n{difference}");
            }
            Err(difference) => panic!("{difference}"),
        }
    }
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
