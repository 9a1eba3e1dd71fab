// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright gateway`: a client of the MTConnect adapter reads a whole run, and its history is that of the bag.

use crate::hal::messages;
use crate::support;

use camwright_bag::Bag;
use camwright_msgs::camwright_msgs::msg::{CellState, MachineAlarms, MachineCounters};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};
use support::processes::{Processes, fresh_bag, in_domain};
use support::{Domain, Guarded, PATIENCE};

pub(super) const NAMESPACE: &str = "/plant";
/// A short job.
pub(super) const SHORT: [&str; 4] =
    ["wheel_radius_mm=60.0", "infeed.per_block_um=0.02", "infeed.spark_out_turns=1", "infeed.total_mm=0.36"];
/// Quick start of the wheel, and setpoints so far ahead that a pause of this computer stops no motion.
pub(super) const MACHINE: [&str; 1] = ["machine_overrides:=[\"wheel.spin_up_s=0.2\", \"feedback_delay_ticks=500\"]"];

/// EXECUTION of the states 1 to 17, from the standard's meaning of the words.
const EXECUTION: [&str; 17] = [
    "STOPPED",           // CLEARING
    "STOPPED",           // STOPPED
    "READY",             // STARTING
    "READY",             // IDLE
    "WAIT",              // SUSPENDED
    "ACTIVE",            // EXECUTE
    "STOPPED",           // STOPPING
    "STOPPED",           // ABORTING
    "STOPPED",           // ABORTED
    "FEED_HOLD",         // HOLDING
    "FEED_HOLD",         // HELD
    "ACTIVE",            // UNHOLDING
    "WAIT",              // SUSPENDING
    "ACTIVE",            // UNSUSPENDING
    "READY",             // RESETTING
    "ACTIVE",            // COMPLETING
    "PROGRAM_COMPLETED", // COMPLETE
];
const MODE: [&str; 4] = ["AUTOMATIC", "MANUAL", "MANUAL", "SEMI_AUTOMATIC"];

/// An agent as its protocol wants it: sends PING, reads lines, keeps histories.
struct Agent {
    lines: Receiver<String>,
    /// Values of every data item that is no condition, without repetitions.
    values: BTreeMap<String, Vec<String>>,
    /// Active alarms of every condition; `None`: unavailable.
    conditions: BTreeMap<String, Option<BTreeSet<u16>>>,
    /// Sets of active alarms of all conditions, one after every change.
    alarms: Vec<BTreeSet<u16>>,
    greeting: Vec<String>,
    pongs: usize,
}

impl Agent {
    fn connect(address: &str) -> Self {
        let stream = TcpStream::connect(address).expect("the gateway listens");
        let mut pinging = stream.try_clone().expect("the same connection");
        std::thread::spawn(move || {
            while pinging.write_all(b"* PING\n").is_ok() {
                std::thread::sleep(Duration::from_secs(2));
            }
        });
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(stream).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        Self {
            lines,
            values: BTreeMap::new(),
            conditions: BTreeMap::new(),
            alarms: Vec::new(),
            greeting: Vec::new(),
            pongs: 0,
        }
    }

    fn receive(&mut self, line: &str) {
        if line.starts_with("* PONG ") {
            self.pongs += 1;
            return;
        }
        if line.starts_with("* ") {
            self.greeting.push(line.to_owned());
            return;
        }
        let fields: Vec<&str> = line.split('|').collect();
        assert!(fields[0].len() == 24 && fields[0].ends_with('Z'), "a time in UTC: {line}");
        let key = |key: &str| key.strip_prefix("plant_").unwrap_or_else(|| panic!("{line}")).to_owned();
        let is_condition = fields[1].ends_with("system");
        if !is_condition {
            for pair in fields[1..].chunks(2) {
                let history = self.values.entry(key(pair[0])).or_default();
                assert_ne!(history.last().map(String::as_str), Some(pair[1]), "only changes are sent: {line}");
                history.push(pair[1].to_owned());
            }
            return;
        }
        let (level, code) = (fields[2], fields[3].parse::<u16>().ok());
        let known = self.conditions.entry(key(fields[1])).or_default();
        match (level, code) {
            ("UNAVAILABLE", None) => *known = None,
            ("NORMAL", None) => *known = Some(BTreeSet::new()),
            ("NORMAL", Some(code)) => assert!(known.as_mut().expect("known").remove(&code), "{line}"),
            ("WARNING" | "FAULT", Some(code)) => drop(known.get_or_insert_default().insert(code)),
            _ => panic!("{line}"),
        }
        if self.conditions.values().all(Option::is_some) {
            let all = self.conditions.values().flatten().flatten().copied().collect();
            if self.alarms.last() != Some(&all) {
                self.alarms.push(all);
            }
        }
    }

    /// Receives lines until something is so.
    fn until(&mut self, what: &str, wanted: impl Fn(&Self) -> bool) {
        let deadline = Instant::now() + PATIENCE;
        while !wanted(self) {
            let left = deadline.saturating_duration_since(Instant::now());
            match self.lines.recv_timeout(left) {
                Ok(line) => self.receive(&line),
                Err(error) => panic!("{what}: {error}; {:?} {:?}", self.values, self.conditions),
            }
        }
    }

    fn last(&self, id: &str) -> Option<&str> {
        self.values.get(id).and_then(|history| history.last()).map(String::as_str)
    }

    /// Known values of an item, without repetitions.
    fn history(&self, id: &str) -> Vec<String> {
        let known = self.values[id].iter().filter(|value| *value != "UNAVAILABLE").cloned();
        deduplicated(known)
    }
}

pub(super) fn deduplicated<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut kept = Vec::new();
    for value in values {
        if kept.last() != Some(&value) {
            kept.push(value);
        }
    }
    kept
}

/// Checks that a history of a client lies in that of the bag, without a gap.
pub(super) fn is_in_the_bag<T: PartialEq + std::fmt::Debug>(what: &str, client: &[T], bag: &[T]) {
    assert!(bag.windows(client.len()).any(|part| part == client), "{what}: the client has {client:?}, the bag {bag:?}");
}

/// Runs a command on the cell to its end.
pub(super) fn run_camwright(domain: &Domain, words: &[&str]) {
    let mut command = in_domain(env!("CARGO_BIN_EXE_camwright"), domain);
    let namespace = format!("__ns:={NAMESPACE}");
    let output = command.args(words).args(["--ros-args", "-r", &namespace]).output().expect("camwright runs");
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
}

fn gateway(domain: &Domain, port: u16) -> Guarded {
    gateway_with(domain, port, &[])
}

/// Starts a gateway with more options.
pub(super) fn gateway_with(domain: &Domain, port: u16, options: &[&str]) -> Guarded {
    let mut command = in_domain(env!("CARGO_BIN_EXE_camwright"), domain);
    command.args(["gateway", "--mtconnect-port", &port.to_string()]).args(options).args(["--ros-args", "-r"]);
    Guarded::start("camwright gateway", command.arg(format!("__ns:={NAMESPACE}")))
}

fn address(gateway: &Guarded) -> String {
    address_of(gateway, "MTConnect adapter: ")
}

/// Waits for the address that the gateway prints after these words.
pub(super) fn address_of(gateway: &Guarded, words: &str) -> String {
    let deadline = Instant::now() + PATIENCE;
    loop {
        let text = gateway.stderr();
        let address = text.lines().find_map(|line| line.strip_prefix(words));
        if let Some(address) = address.filter(|_| text.ends_with('\n')) {
            return address.to_owned();
        }
        assert!(Instant::now() < deadline, "{text}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn the_history_of_a_run_is_that_of_the_bag() {
    let (domain, bag) = (Domain::reserve(), fresh_bag("gateway"));
    let mut gateway = gateway(&domain, 0);
    let mut agent = Agent::connect(&address(&gateway));
    agent.until("everything is unavailable", |agent| agent.conditions.len() == 4);
    assert_eq!(agent.greeting.last().map(String::as_str), Some("* shdrVersion: 2"), "{:?}", agent.greeting);
    assert!(agent.values.values().all(|history| history == &["UNAVAILABLE"]), "{:?}", agent.values);

    let mut cell = Processes::start_without_command(&domain, NAMESPACE, &MACHINE, &bag);
    agent.until("the cell is there", |agent| {
        let known = ["availability", "execution", "program", "x_position", "s_velocity", "path_feedrate_override"];
        let is_known = |id: &&str| agent.last(id).is_some_and(|value| value != "UNAVAILABLE");
        known.iter().filter(|id| **id != "program").all(is_known) && !agent.alarms.is_empty()
    });
    let set: Vec<&str> = SHORT.iter().flat_map(|over| ["--set", over]).collect();
    let start = ["fleet", "start", "eccentric", "--patience", "90", "--cell", NAMESPACE];
    run_camwright(&domain, &[&start[..], &set].concat());
    agent.until("the job is complete", |agent| {
        agent.last("execution") == Some("PROGRAM_COMPLETED") && agent.last("part_count_all") == Some("1")
    });
    assert_eq!(agent.last("program"), Some("eccentric"));
    // The wheel turned and C went round; 900 rpm and more at 60 mm.
    let largest = |id: &str| {
        let numbers = agent.history(id).into_iter().filter_map(|value| value.parse::<f64>().ok());
        numbers.map(f64::abs).fold(0.0, f64::max)
    };
    assert!(largest("s_velocity") > 900.0 && largest("c_angle") > 360.0, "{:?}", agent.values["s_velocity"]);

    // An alarm and its reset.
    run_camwright(&domain, &["estop"]);
    agent.until("the alarm is a fault", |agent| {
        let is_fault = agent.conditions["system"].as_ref().is_some_and(|active| active.contains(&1));
        is_fault && agent.last("emergency_stop") == Some("TRIGGERED") && agent.last("execution") == Some("STOPPED")
    });
    run_camwright(&domain, &["estop", "--release"]);
    run_camwright(&domain, &["reset"]);
    agent.until("the reset is NORMAL", |agent| {
        agent.conditions["system"].as_ref().is_some_and(BTreeSet::is_empty)
            && agent.last("emergency_stop") == Some("ARMED")
    });
    let seen: Vec<(&str, Vec<String>)> =
        ["execution", "controller_mode", "program", "part_count_all"].map(|id| (id, agent.history(id))).into();
    let alarms = agent.alarms.clone();

    // A machine that dies without leaving the graph is lost, the planner is not; then there is a new one.
    cell.kill("machine_sim");
    agent.until("a dead machine is unavailable", |agent| {
        let is_lost = |id: &&str| agent.last(id) == Some("UNAVAILABLE");
        ["availability", "c_angle", "part_count_all"].iter().all(is_lost) && agent.conditions["system"].is_none()
    });
    assert_ne!(agent.last("controller_mode"), Some("UNAVAILABLE"));
    cell.restart("machine_sim", &domain, NAMESPACE);
    agent.until("the new machine has counted no part", |agent| {
        agent.last("availability") == Some("AVAILABLE") && agent.last("part_count_all") == Some("0")
    });

    let bag = cell.end();
    agent.until("everything is unavailable at the end of the cell", |agent| {
        agent.values.values().all(|history| history.last().is_some_and(|value| value == "UNAVAILABLE"))
            && agent.conditions.values().all(Option::is_none)
    });
    assert!(agent.pongs > 0);
    gateway.interrupt();
    assert_eq!(gateway.wait(PATIENCE).code(), Some(0), "{}", gateway.complaint());
    agent.lines.iter().for_each(drop);

    let read = Bag::open(&bag).expect("a bag");
    let topic = |name: &str| format!("{NAMESPACE}/{name}");
    let states: Vec<CellState> = messages(&read, &topic("job_planner/cell_state"));
    let word = |words: &[&str], number: u8| words[usize::from(number) - 1].to_owned();
    let counters: Vec<MachineCounters> = messages(&read, &topic("machine/counters"));
    let recorded = [
        deduplicated(states.iter().map(|state| word(&EXECUTION, state.state))),
        deduplicated(states.iter().map(|state| word(&MODE, state.mode))),
        deduplicated(states.iter().map(|state| state.job.clone()).filter(|job| !job.is_empty())),
        deduplicated(counters.iter().map(|counters| counters.shift.total.to_string())),
    ];
    for ((id, agent), bag) in seen.iter().zip(&recorded) {
        is_in_the_bag(id, agent, bag);
    }
    let execution = &seen[0].1;
    assert!(execution.len() >= 4 && execution.contains(&"ACTIVE".to_owned()), "{execution:?}");
    let lists: Vec<MachineAlarms> = messages(&read, &topic("machine/alarms"));
    let sets = lists.iter().map(|list| list.alarms.iter().map(|alarm| alarm.number).collect::<BTreeSet<u16>>());
    let sets = deduplicated(sets);
    is_in_the_bag("alarms", &alarms, &sets);
    assert!(alarms.iter().any(|active| active.contains(&1)) && alarms.last() == Some(&BTreeSet::new()), "{alarms:?}");
    std::fs::remove_dir_all(bag).expect("the bag is ours");
}

#[test]
fn a_port_in_use_is_an_error_and_devices_need_no_cell() {
    let (domain, taken) = (Domain::reserve(), TcpListener::bind("127.0.0.1:0").expect("a port"));
    let port = taken.local_addr().expect("an address").port();
    let mut refused = gateway(&domain, port);
    assert_eq!(refused.wait(PATIENCE).code(), Some(1));
    let text = refused.stderr();
    assert!(
        text.contains(&format!("cannot be served at 127.0.0.1:{port}: ")) && text.contains("another port"),
        "{text}"
    );
    let devices = |words: &[&str]| {
        let mut command = in_domain(env!("CARGO_BIN_EXE_camwright"), &domain);
        let output = command.arg("gateway").args(words).output().expect("camwright runs");
        (output.status.code(), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
    };
    let (code, text) = devices(&["--devices", "cam_grinder", "--namespace", "/plant"]);
    assert!(code == Some(0) && text.contains("id=\"plant_execution\""), "{text}");
    let (code, text) = devices(&["--devices", "no_machine"]);
    assert!(code == Some(1) && text.contains("no_machine"), "{text}");
    let (code, text) = devices(&["--devices", "cam_grinder", "--namespace", "/a\"b"]);
    assert!(code == Some(2) && text.contains("letters, digits and _"), "{text}");
}
