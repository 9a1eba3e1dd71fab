// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A node that dies, stops or is deactivated in the middle of a job ends the job with a reason, and the next job succeeds.
//!
//! Campaigns, each with a seed (`CAMWRIGHT_SEED`, default 1):
//! `CAMWRIGHT_KILLS=20 cargo test -p camwright_nodes --test faults liveness -- --ignored --nocapture campaign_of_kills`
//! `cargo test -p camwright_nodes --test faults liveness -- --ignored --nocapture campaign_of_restart_orders`
//! `CAMWRIGHT_JOBS=1000 cargo test -p camwright_nodes --test faults liveness -- --ignored --nocapture soak_of_jobs`
#![allow(clippy::print_stdout, reason = "campaigns print what they measure")]

use crate::support;

use camwright_msgs::camwright_msgs::action::{RunJob, RunJobGoal, RunJobResult};
use camwright_msgs::camwright_msgs::msg::InterpolatorState;
use camwright_msgs::lifecycle_msgs::msg::Transition;
use camwright_msgs::lifecycle_msgs::srv::{ChangeState, ChangeStateRequest, GetState, GetStateRequest};
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_ros::{ActionClient, ClientGoal, GoalStatus, Node, NodeOptions, Qos, RosArgs, SpinThread, Subscription};
use std::path::PathBuf;
use std::sync::mpsc;
use std::time::{Duration, Instant};
use support::command::Shared;
use support::processes::{fresh_bag, in_domain};
use support::{Domain, Guarded, PATIENCE};

/// A job that a node has left ends within this time: 2.5 s of silence, the stop, and the slowness of a computer under test.
const STATED: Duration = Duration::from_secs(25);
/// A node ends within 2 s after a signal; the rest is the slowness of a computer under test.
const ENDING: Duration = Duration::from_secs(8);
const NODES: [&str; 4] = ["run_logger", "machine_sim", "axis_interpolator", "job_planner"];
const JOB: [&str; 4] =
    ["wheel_radius_mm=60.0", "infeed.per_block_um=0.02", "infeed.spark_out_turns=1", "infeed.total_mm=0.36"];

/// Fate of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fate {
    Kill,
    Interrupt,
    Terminate,
    StopAndContinue,
    Deactivate,
}

const FATES: [Fate; 5] = [Fate::Kill, Fate::Interrupt, Fate::Terminate, Fate::StopAndContinue, Fate::Deactivate];

/// A small generator of numbers, the same in every run with a seed.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % bound
    }
}

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Four processes and an operator.
struct NodeProcesses {
    pace: &'static str,
    processes: Vec<(&'static str, Guarded)>,
    bags: Vec<PathBuf>,
    node: Node,
    jobs: ActionClient<RunJob>,
    states: mpsc::Receiver<u8>,
    _states: Subscription,
    _spin: SpinThread,
    command: Option<Shared>,
    domain: Domain,
}

impl NodeProcesses {
    fn start(pace: &'static str) -> Self {
        let domain = Domain::reserve();
        let args = RosArgs::default().with_domain_id(domain.id());
        let node = Node::new(NodeOptions::new("operator", &args)).expect("a node");
        let spin = node.spin_in_thread().expect("a thread");
        let (sender, states) = mpsc::channel();
        let on_state = move |state: InterpolatorState, _: &_| {
            let _test_is_over = sender.send(state.state);
        };
        let subscription =
            node.subscribe("axis_interpolator/state", &Qos::latched(1), on_state).expect("a subscription");
        let jobs = node.action_client("job_planner/run_job").expect("a client");
        let (processes, bags) = (Vec::new(), Vec::new());
        let (_states, _spin, command) = (subscription, spin, None);
        let mut cell = Self { pace, processes, bags, node, jobs, states, _states, _spin, command, domain };
        for name in NODES {
            cell.start_node(name);
        }
        cell.jobs.wait_for_server(PATIENCE).expect("run_job");
        cell.command = Some(Shared::for_cell(&cell.domain, ""));
        cell
    }

    fn start_node(&mut self, name: &'static str) {
        self.processes.retain(|(other, _)| *other != name);
        let binary = match name {
            "run_logger" => env!("CARGO_BIN_EXE_run_logger"),
            "machine_sim" => env!("CARGO_BIN_EXE_machine_sim"),
            "axis_interpolator" => env!("CARGO_BIN_EXE_axis_interpolator"),
            _ => env!("CARGO_BIN_EXE_job_planner"),
        };
        let mut command = in_domain(binary, &self.domain);
        command.arg("--ros-args");
        let mut parameters = Vec::new();
        if name == "run_logger" {
            let bag = fresh_bag(&format!("liveness-{}-{}", self.domain.id(), self.bags.len()));
            parameters.push(format!("bag_dir:={}", bag.display()));
            self.bags.push(bag);
        } else if name == "machine_sim" {
            parameters.extend([format!("pace:={}", self.pace), "state_file:=none".to_owned()]);
            parameters.push("machine_overrides:=[\"wheel.spin_up_s=0.2\", \"feedback_delay_ticks=500\"]".to_owned());
        }
        for parameter in parameters {
            command.args(["-p", &parameter]);
        }
        self.processes.push((name, Guarded::start(name, &mut command)));
    }

    fn process(&mut self, name: &str) -> &mut Guarded {
        &mut self.processes.iter_mut().find(|(other, _)| *other == name).expect("it was started").1
    }

    fn send(&self) -> Result<ClientGoal<RunJob>, String> {
        let overrides = JOB.map(String::from).into();
        let goal = RunJobGoal { job: "eccentric".into(), overrides, ..RunJobGoal::default() };
        let sent = self.jobs.send_goal(goal, drop, Duration::from_secs(20)).map_err(|error| error.to_string())?;
        if sent.accepted() { Ok(sent) } else { Err("rejected".to_owned()) }
    }

    /// Resets and runs a job until one succeeds; how long that took.
    fn run_next(&self) -> Duration {
        let begin = Instant::now();
        let reset = self.node.client::<Trigger>("machine/reset").expect("a client");
        let mut printed = String::new();
        while begin.elapsed() < 2 * PATIENCE {
            let _refused_or_gone = reset.call(&TriggerRequest::default(), Duration::from_secs(5));
            match self.send().and_then(|goal| goal.result(PATIENCE).map_err(|error| error.to_string())) {
                Ok((GoalStatus::Succeeded, _)) => return begin.elapsed(),
                Ok((status, result)) => printed = format!("{status:?}: {}", result.message),
                Err(error) => printed = error,
            }
            // Nodes that have just been started meet each other.
            std::thread::sleep(Duration::from_millis(200));
        }
        panic!("no job succeeds any more: {printed}");
    }

    /// Begins a job and waits until the axes move.
    fn begin(&self) -> ClientGoal<RunJob> {
        while self.states.try_recv().is_ok() {}
        let deadline = Instant::now() + PATIENCE;
        loop {
            match self.send() {
                Ok(goal) => {
                    while self.states.recv_timeout(PATIENCE).expect("the job begins") != InterpolatorState::EXECUTING {}
                    return goal;
                }
                Err(error) => assert!(Instant::now() < deadline, "{error}"),
            }
        }
    }

    fn change_state(&self, name: &str, id: u8) {
        let client = self.node.client::<ChangeState>(&format!("{name}/change_state")).expect("a client");
        client.wait_for_service(PATIENCE).expect("a managed node");
        let request = ChangeStateRequest { transition: Transition { id, ..Transition::default() } };
        let _it_may_be_so_already = client.call(&request, PATIENCE).expect("an answer");
    }

    fn strike(&mut self, name: &'static str, fate: Fate) {
        match fate {
            Fate::Kill => self.process(name).signal("KILL"),
            Fate::Interrupt => self.process(name).interrupt(),
            Fate::Terminate => self.process(name).terminate(),
            Fate::StopAndContinue => self.process(name).signal("STOP"),
            Fate::Deactivate => self.change_state(name, Transition::TRANSITION_DEACTIVATE),
        }
        if matches!(fate, Fate::Kill | Fate::Interrupt | Fate::Terminate) {
            let begin = Instant::now();
            self.process(name).wait(ENDING);
            println!("    {name} ended after {:.2} s", begin.elapsed().as_secs_f64());
        }
    }

    fn bring_back(&mut self, name: &'static str, fate: Fate) {
        match fate {
            Fate::Kill | Fate::Interrupt | Fate::Terminate => self.start_node(name),
            // RustDDS ends its threads when a process is continued (EINTR), so the node has to be started again.
            Fate::StopAndContinue => {
                self.process(name).signal("CONT");
                self.process(name).signal("KILL");
                self.start_node(name);
            }
            Fate::Deactivate => self.change_state(name, Transition::TRANSITION_ACTIVATE),
        }
    }

    /// One node meets its fate in the middle of a job: the job ends with a reason, and the next one succeeds.
    fn try_fate(&mut self, name: &'static str, fate: Fate, after: Duration) {
        let goal = self.begin();
        std::thread::sleep(after);
        let begin = Instant::now();
        self.strike(name, fate);
        let outcome = match name {
            // The client of the planner gets no result; the interpolator ends the plan.
            "job_planner" => None,
            _ => Some(goal.result(STATED + if self.pace == "fast" { Duration::ZERO } else { PATIENCE })),
        };
        let ended = begin.elapsed();
        let outcome = outcome
            .map(|outcome| outcome.unwrap_or_else(|error| panic!("{name} {fate:?}: the job has no end: {error}")));
        let message = outcome.as_ref().map_or("", |(_, RunJobResult { message, .. })| message);
        println!("{:9} {name:18} {fate:?}: after {:.1} s: {message}", self.pace, ended.as_secs_f64());
        assert!(
            outcome
                .as_ref()
                .is_none_or(|(status, result)| *status == GoalStatus::Succeeded || !result.message.is_empty())
        );
        self.bring_back(name, fate);
        println!("    the next job succeeded after {:.1} s", self.run_next().as_secs_f64());
    }

    /// Ends all of it.
    fn end(mut self) {
        self.command.take();
        for (name, process) in self.processes.iter_mut().rev() {
            process.interrupt();
            let status = process.wait(PATIENCE);
            assert!(status.success(), "{name} ends with {status}{}", process.complaint());
        }
        for bag in &self.bags {
            let _not_there = std::fs::remove_dir_all(bag);
        }
    }
}

#[test]
fn a_node_that_dies_in_a_job_ends_it_and_the_next_one_succeeds() {
    let mut cell = NodeProcesses::start("fast");
    let after = Duration::from_millis(300);
    cell.try_fate("axis_interpolator", Fate::Kill, after);
    cell.try_fate("machine_sim", Fate::Kill, after);
    cell.try_fate("run_logger", Fate::Kill, after);
    cell.try_fate("machine_sim", Fate::Deactivate, after);
    cell.end();
}

/// A killed machine stays known to discovery. New clients of the machine that was started again get an answer all the same.
#[test]
fn new_clients_reach_a_machine_that_was_started_again() {
    let domain = Domain::reserve();
    let start = || {
        let mut command = in_domain(env!("CARGO_BIN_EXE_machine_sim"), &domain);
        Guarded::start("machine_sim", command.args(["--ros-args", "-p", "pace:=fast", "-p", "state_file:=none"]))
    };
    let args = RosArgs::default().with_domain_id(domain.id());
    let node = Node::new(NodeOptions::new("operator", &args)).expect("a node");
    let _spin = node.spin_in_thread().expect("a thread");
    let ask = || {
        let client = node.client::<GetState>("machine_sim/get_state").expect("a client");
        client.call(&GetStateRequest::default(), PATIENCE)
    };
    let mut killed = start();
    ask().expect("the first machine answers");
    killed.signal("KILL");
    killed.wait(ENDING);
    let _machine = start();
    // A client that knows the dead machine alone sends its request to that one.
    let observer = node.client::<GetState>("machine_sim/get_state").expect("a client");
    assert!(observer.wait_matched(2, PATIENCE), "both machines are known");
    for call in 0..100 {
        ask().unwrap_or_else(|error| panic!("call {call}: {error}"));
    }
}

#[test]
#[ignore = "a campaign: see the head of this file"]
fn campaign_of_kills() {
    let mut random = Random(number("CAMWRIGHT_SEED", 1));
    let kills = number("CAMWRIGHT_KILLS", 20);
    let paces = std::env::var("CAMWRIGHT_PACES").unwrap_or_else(|_| "fast realtime".to_owned());
    for pace in ["fast", "realtime"].into_iter().filter(|pace| paces.contains(pace)) {
        let mut cell = NodeProcesses::start(pace);
        for round in 0..kills {
            for name in NODES {
                let fate = FATES[usize::try_from(random.below(5)).expect("less than 5")];
                let after = Duration::from_millis(random.below(if pace == "fast" { 1000 } else { 6000 }));
                print!("{round:3} ");
                cell.try_fate(name, fate, after);
            }
        }
        cell.end();
    }
}

/// The 24 orders of the four nodes.
fn restart_orders() -> Vec<Vec<&'static str>> {
    let mut orders = vec![Vec::new()];
    for _ in NODES {
        let longer = |order: &Vec<&'static str>| {
            let rest = NODES.into_iter().filter(|name| !order.contains(name));
            rest.map(|name| [order.as_slice(), &[name]].concat()).collect::<Vec<_>>()
        };
        orders = orders.iter().flat_map(longer).collect();
    }
    orders
}

/// Kills all four nodes in the middle of a job and starts them again in each order.
#[test]
#[ignore = "a campaign: see the head of this file"]
fn campaign_of_restart_orders() {
    let paces = std::env::var("CAMWRIGHT_PACES").unwrap_or_else(|_| "fast realtime".to_owned());
    for pace in ["fast", "realtime"].into_iter().filter(|pace| paces.contains(pace)) {
        let mut cell = NodeProcesses::start(pace);
        for order in restart_orders() {
            let _goal_without_a_server = cell.begin();
            for name in NODES {
                cell.strike(name, Fate::Kill);
            }
            for name in &order {
                cell.start_node(name);
            }
            println!(
                "{pace:9} {}: the next job succeeded after {:.1} s",
                order.join(", "),
                cell.run_next().as_secs_f64()
            );
        }
        cell.end();
    }
}

/// Resident memory of a process (kB).
fn resident_kb(process: &Guarded) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", process.id())).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.trim().strip_suffix(" kB")).and_then(|text| text.trim().parse().ok()).unwrap_or(0)
}

#[test]
#[ignore = "a campaign: see the head of this file"]
fn soak_of_jobs() {
    let cell = NodeProcesses::start("fast");
    let jobs = number("CAMWRIGHT_JOBS", 1000);
    cell.run_next();
    let begin = Instant::now();
    for job in 1..=jobs {
        let goal = cell.send().expect("it is accepted");
        let (status, result) = goal.result(PATIENCE).unwrap_or_else(|error| panic!("job {job} is stuck: {error}"));
        assert_eq!(status, GoalStatus::Succeeded, "job {job}: {}", result.message);
        if job.is_multiple_of((jobs / 20).max(1)) {
            let memory: Vec<String> = cell
                .processes
                .iter()
                .map(|(name, process)| format!("{name} {} MB", resident_kb(process) / 1024))
                .collect();
            println!("{job:5} jobs, {:.0} s: {}", begin.elapsed().as_secs_f64(), memory.join(", "));
        }
    }
    cell.end();
}
