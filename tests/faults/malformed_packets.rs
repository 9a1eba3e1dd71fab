// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Hostile datagrams at a running cell, from another host and from this one.
//!
//! The campaign with a seed and a number of packets:
//!
//! ```text
//! CAMWRIGHT_SEED=7 CAMWRIGHT_PACKETS=100000 cargo test -p camwright_nodes --test faults malformed_packets campaign -- --ignored --nocapture
//! ```

use crate::support;

use std::net::{Ipv4Addr, UdpSocket};
use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use support::hosts::{Hosts, INSIDE};
use support::processes::fresh_bag;
use support::{Domain, Guarded, PATIENCE, repository, rtps};

const NODES: [&str; 4] = ["run_logger", "machine_sim", "axis_interpolator", "job_planner"];
/// A real job in few turns.
const JOB: [&str; 7] = [
    "eccentric",
    "--set",
    "wheel_radius_mm=60.0",
    "--set",
    "infeed.per_block_um=0.05",
    "--set",
    "infeed.spark_out_turns=6",
];
/// Participants whose ports are attacked: the four nodes, and their observers.
const PARTICIPANTS: u16 = 8;
/// Packets sent between two pauses, in which the attacked catch up.
const BURST: u64 = 50;
/// More than a node of a cell that has run one short job needs.
const MEMORY_LIMIT_MB: u64 = 700;
/// Exit code of a node whose DDS died.
const EXIT_FAILED: i32 = 70;

/// The four nodes, each a process, on the host under test.
struct HostedNodes {
    hosts: Hosts,
    domain: Domain,
    nodes: Vec<(&'static str, Guarded)>,
    bag: PathBuf,
}

impl HostedNodes {
    fn start(purpose: &str) -> Option<Self> {
        let hosts = Hosts::new(purpose)?;
        let mut cell = HostedNodes { hosts, domain: Domain::reserve(), nodes: Vec::new(), bag: fresh_bag(purpose) };
        for name in NODES {
            let directory = format!("bag_dir:={}", cell.bag.display());
            let (binary, parameters): (&str, &[&str]) = match name {
                "run_logger" => (env!("CARGO_BIN_EXE_run_logger"), &[&directory, "use_sim_time:=true"]),
                "machine_sim" => (env!("CARGO_BIN_EXE_machine_sim"), &["pace:=fast", "state_file:=none"]),
                "axis_interpolator" => (env!("CARGO_BIN_EXE_axis_interpolator"), &[]),
                _ => (env!("CARGO_BIN_EXE_job_planner"), &[]),
            };
            let mut command = cell.command(binary);
            command.arg("--ros-args");
            for parameter in parameters {
                command.args(["-p", parameter]);
            }
            cell.nodes.push((name, Guarded::start(name, &mut command)));
        }
        Some(cell)
    }

    fn command(&self, binary: &str) -> Command {
        let mut command = self.hosts.command(binary);
        command
            .current_dir(repository())
            .env("ROS_DOMAIN_ID", self.domain.id().to_string())
            .env("XDG_STATE_HOME", env!("CARGO_TARGET_TMPDIR"))
            .env_remove("ROS_AUTOMATIC_DISCOVERY_RANGE")
            .env_remove("ROS_NAMESPACE");
        command
    }

    fn camwright(&self, arguments: &[&str]) -> Guarded {
        Guarded::start("camwright", self.command(env!("CARGO_BIN_EXE_camwright")).args(arguments))
    }

    fn start_job(&self) -> Guarded {
        self.camwright(&[&["run"], &JOB[..], &["--attach", "--json"]].concat())
    }

    /// The job runs to its end, and nobody has lost anybody. Whether its part is good (4: it is not) is another matter.
    fn expect_success(mut job: Guarded) {
        let lines = job.remaining_lines(PATIENCE * 3);
        let status = job.wait(PATIENCE);
        assert!(matches!(status.code(), Some(0 | 4)), "{status}: {lines:?}{}", job.complaint());
    }

    /// A newcomer sees the whole cell.
    fn expect_visible(&self) {
        let mut status = self.camwright(&["status", "--json"]);
        let lines = status.remaining_lines(PATIENCE);
        assert!(status.wait(PATIENCE).success(), "{lines:?}{}", status.complaint());
    }

    /// A newcomer sees the whole cell once the nodes listen to newcomers again: a flood of announcements closes them for a minute at most.
    fn wait_until_visible(&self) {
        let deadline = Instant::now() + Duration::from_secs(120);
        loop {
            let mut status = self.camwright(&["status", "--json"]);
            let lines = status.remaining_lines(PATIENCE);
            if status.wait(PATIENCE).success() {
                return;
            }
            assert!(Instant::now() < deadline, "{lines:?}{}", status.complaint());
        }
    }

    /// All nodes run, within their memory; gives the peak of each in MB.
    fn expect_health(&mut self) -> Vec<(&'static str, u64)> {
        let mut peaks = Vec::new();
        for (name, node) in &mut self.nodes {
            assert!(node.is_running(), "{name} has ended{}", node.complaint());
            let status = std::fs::read_to_string(format!("/proc/{}/status", node.id())).expect("it runs");
            let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB"));
            let peak_mb = peak.expect("the kernel reports it").parse::<u64>().expect("a number") / 1024;
            assert!(peak_mb < MEMORY_LIMIT_MB, "{name} took {peak_mb} MB");
            peaks.push((*name, peak_mb));
        }
        peaks
    }

    fn attack(&self, seed: u64, packets: u64, socket: &UdpSocket, to: Ipv4Addr) {
        send_malformed(socket, to, &self.domain, seed, packets, &AtomicU64::new(0));
    }

    fn end(mut self) {
        for (name, node) in self.nodes.iter_mut().rev() {
            node.interrupt();
            let status = node.wait(PATIENCE);
            assert!(status.success(), "{name} ends with {status}{}", node.complaint());
        }
        let _nothing_recorded = std::fs::remove_dir_all(&self.bag);
    }
}

fn send_malformed(socket: &UdpSocket, to: Ipv4Addr, domain: &Domain, seed: u64, packets: u64, sent: &AtomicU64) {
    let ports = rtps::ports(domain.id(), PARTICIPANTS);
    let mut random = rtps::Random::new(seed);
    let std::net::IpAddr::V4(own) = socket.local_addr().expect("bound").ip() else { panic!("IPv4") };
    for packet in 0..packets {
        let octets = random.malformed(own, domain.id());
        // A closed port answers the next send with an error.
        let _ = socket.send_to(&octets, (to, ports[random.below(ports.len())]));
        sent.store(packet + 1, Ordering::Relaxed);
        if packet % BURST == BURST - 1 {
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

const STRANGER: [u8; 12] = *b"\x01\x0fa stranger";

fn from_another_host(seed: u64, packets: u64) {
    let Some(mut cell) = HostedNodes::start("remote") else { return };
    let target: Ipv4Addr = INSIDE.parse().expect("an address");
    let socket = cell.hosts.socket_outside();
    let ports = rtps::ports(cell.domain.id(), PARTICIPANTS);
    let job = cell.start_job();
    rtps::send_killers(&socket, target, &ports, cell.domain.id(), &STRANGER);
    cell.attack(seed, packets, &socket, target);
    rtps::send_killers(&socket, target, &ports, cell.domain.id(), &STRANGER);
    HostedNodes::expect_success(job);
    cell.expect_visible();
    assert_eq!(cell.hosts.arrived_outside(), 0, "the stranger was answered");
    assert!(
        cell.hosts.refused_inside() > packets / 4,
        "few of the packets arrived at a socket; this test shows little"
    );
    let peaks = cell.expect_health();
    eprintln!("seed {seed}, {packets} packets from another host: the job ran to its end; peak memory in MB {peaks:?}");
    cell.end();
}

#[test]
fn a_stranger_on_another_host_does_not_disturb_a_job() {
    from_another_host(1, 3_000);
}

#[test]
fn the_known_killers_from_this_host_are_survived() {
    let Some(mut cell) = HostedNodes::start("killers") else { return };
    let ports = rtps::ports(cell.domain.id(), PARTICIPANTS);
    let socket = cell.hosts.socket_inside();
    cell.expect_visible();
    // Most killers act on nodes that know the stranger already, which takes some milliseconds after the first round.
    for _round in 0..5 {
        rtps::send_killers(&socket, Ipv4Addr::LOCALHOST, &ports, cell.domain.id(), &STRANGER);
        std::thread::sleep(Duration::from_millis(300));
    }
    HostedNodes::expect_success(cell.start_job());
    cell.expect_visible();
    cell.expect_health();
    cell.end();
}

/// Packets from this host reach the nodes: each survives, or ends with an error.
fn from_this_host(seed: u64, packets: u64) {
    let Some(mut cell) = HostedNodes::start("local") else { return };
    cell.expect_visible();
    let socket = cell.hosts.socket_inside();
    let started = Instant::now();
    cell.attack(seed, packets, &socket, Ipv4Addr::LOCALHOST);
    let mut ended = Vec::new();
    for (name, node) in &mut cell.nodes {
        if !node.is_running() {
            let status = node.wait(PATIENCE);
            assert!(!status.success(), "{name} ended quietly{}", node.complaint());
            assert!(node.stderr().contains("DDS") || status.code().is_none(), "{name}: {status}{}", node.complaint());
            ended.push(*name);
        }
    }
    eprintln!("seed {seed}, {packets} packets from this host in {:?}: ended {ended:?}", started.elapsed());
    if ended.is_empty() {
        cell.wait_until_visible();
        eprintln!("a newcomer is heard {:?} after the first packet", started.elapsed());
        HostedNodes::expect_success(cell.start_job());
        cell.expect_visible();
        eprintln!("peak memory in MB {:?}", cell.expect_health());
        cell.end();
    }
}

#[test]
fn malformed_packets_from_this_host_are_survived_or_end_a_node_loudly() {
    from_this_host(2, 1_000);
}

/// A datagram of this host with more submessages than the filter inspects brings `RustDDS` down; the node must not live on deaf.
#[test]
fn a_node_whose_dds_has_died_ends_with_an_error() {
    let Some(mut cell) = HostedNodes::start("dead") else { return };
    cell.expect_visible();
    let socket = cell.hosts.socket_inside();
    let ports = rtps::ports(cell.domain.id(), 4);
    let deadline = Instant::now() + PATIENCE;
    while cell.nodes.iter_mut().any(|(_, node)| node.is_running()) {
        assert!(Instant::now() < deadline, "a node lives on without DDS");
        rtps::send_hidden_killer(&socket, Ipv4Addr::LOCALHOST, &ports, cell.domain.id(), &STRANGER);
        std::thread::sleep(Duration::from_millis(500));
    }
    for (name, node) in &mut cell.nodes {
        let status = node.wait(PATIENCE);
        assert_eq!(status.code(), Some(EXIT_FAILED), "{name}{}", node.complaint());
        assert!(node.stderr().contains("lost its connection to the graph"), "{name}{}", node.complaint());
    }
}

#[test]
#[ignore = "a campaign: minutes; see the head of this file"]
fn campaign() {
    let number = |name: &str, default| std::env::var(name).map_or(default, |text| text.parse().expect("a number"));
    let (seed, packets) = (number("CAMWRIGHT_SEED", 1), number("CAMWRIGHT_PACKETS", 100_000));
    from_another_host(seed, packets);
    from_this_host(seed, packets);
}
