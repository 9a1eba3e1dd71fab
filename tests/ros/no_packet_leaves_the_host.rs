// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Everything stays on this host unless the user asks for the subnet: nodes with default settings in a network namespace of their own, with
//! an interface to another namespace. They send nothing there, and a stranger there is neither received nor answered.

use crate::support;

use std::net::Ipv4Addr;
use std::time::{Duration, Instant};
use support::hosts::{Hosts, INSIDE};
use support::{Domain, Guarded, PATIENCE, rtps};

/// Long enough for some rounds of what RTPS repeats by itself: announcements come every few seconds, heartbeats more often.
const WATCHED: Duration = Duration::from_secs(8);
/// A node that talks to itself sends at least its own announcements over the loopback.
const SOME_PACKETS: u64 = 5;
/// Participants whose ports a stranger tries.
const PARTICIPANTS: u16 = 4;

/// Starts the simulated machine inside.
fn machine(hosts: &Hosts, domain: &Domain, range: Option<&str>) -> Guarded {
    let mut command = hosts.command(env!("CARGO_BIN_EXE_machine_sim"));
    command
        .current_dir(support::repository())
        .env("ROS_DOMAIN_ID", domain.id().to_string())
        .env_remove("ROS_AUTOMATIC_DISCOVERY_RANGE")
        .env_remove("ROS_LOCALHOST_ONLY")
        .env_remove("ROS_STATIC_PEERS");
    if let Some(range) = range {
        command.env("ROS_AUTOMATIC_DISCOVERY_RANGE", range);
    }
    Guarded::start("machine_sim", &mut command)
}

/// Waits until a counter has passed a number.
fn wait_for(what: &str, counter: impl Fn() -> u64, more_than: u64, node: &mut Guarded) {
    let deadline = Instant::now() + PATIENCE;
    while counter() <= more_than {
        assert!(node.is_running(), "the node ended{}", node.complaint());
        assert!(Instant::now() < deadline, "{what}: {} within {PATIENCE:?}", counter());
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_node_with_default_settings_sends_no_packet_off_this_machine() {
    let Some(hosts) = Hosts::new("default") else { return };
    let domain = Domain::reserve();
    let (before, lo_before) = (hosts.sent("cable"), hosts.sent("lo"));
    let mut machine = machine(&hosts, &domain, None);
    wait_for("packets over lo", || hosts.sent("lo"), lo_before + SOME_PACKETS, &mut machine);
    let until = Instant::now() + WATCHED;
    while Instant::now() < until {
        assert_eq!(hosts.sent("cable"), before, "packets left the machine{}", machine.complaint());
        assert!(machine.is_running(), "the node ended{}", machine.complaint());
        std::thread::sleep(Duration::from_millis(100));
    }
    // The goodbye goes over the network too.
    machine.interrupt();
    assert!(machine.wait(PATIENCE).success(), "{}", machine.complaint());
    assert_eq!(hosts.sent("cable"), before, "packets left the machine at the end");
}

/// The same watch sees the packets of a node with range SUBNET; without this the test above would show nothing.
#[test]
fn a_node_configured_for_the_subnet_speaks_to_it() {
    let Some(hosts) = Hosts::new("subnet") else { return };
    let domain = Domain::reserve();
    let before = hosts.sent("cable");
    let mut machine = machine(&hosts, &domain, Some("SUBNET"));
    wait_for("packets over the cable", || hosts.sent("cable"), before, &mut machine);
}

/// A stranger on another host announces itself to every port of the domain, again and again; one on this host announces an address there.
fn announce_strangers(hosts: &Hosts, domain: &Domain, answered: impl Fn() -> bool) {
    let inside: Ipv4Addr = INSIDE.parse().expect("an address");
    let (there, here) = (hosts.socket_outside(), hosts.socket_inside());
    let std::net::IpAddr::V4(address) = there.local_addr().expect("bound").ip() else { panic!("IPv4") };
    let port = there.local_addr().expect("bound").port();
    let until = Instant::now() + WATCHED;
    while Instant::now() < until && !answered() {
        for to in rtps::ports(domain.id(), PARTICIPANTS) {
            let announced = |prefix| rtps::announcement(prefix, address, port, domain.id());
            // A closed port answers the next send with an error.
            let _ = there.send_to(&announced(b"\x01\x0ffar away!!"), (inside, to));
            let _ = there.send_to(&announced(b"\x01\x0ffar away!!"), ("239.255.0.1", to));
            let _ = here.send_to(&announced(b"\x01\x0fin between"), (Ipv4Addr::LOCALHOST, to));
        }
        std::thread::sleep(Duration::from_millis(200));
    }
}

#[test]
fn a_stranger_on_another_host_is_ignored() {
    let Some(hosts) = Hosts::new("stranger") else { return };
    let domain = Domain::reserve();
    let lo_before = hosts.sent("lo");
    let mut machine = machine(&hosts, &domain, None);
    wait_for("packets over lo", || hosts.sent("lo"), lo_before + SOME_PACKETS, &mut machine);
    announce_strangers(&hosts, &domain, || hosts.arrived_outside() > 0);
    assert_eq!(hosts.arrived_outside(), 0, "the stranger was answered{}", machine.complaint());
    assert!(hosts.refused_inside() > 0, "what the stranger sent did not arrive at any socket; this test shows nothing");
    machine.interrupt();
    assert!(machine.wait(PATIENCE).success(), "{}", machine.complaint());
    assert_eq!(hosts.arrived_outside(), 0, "the stranger heard the farewell");
}

#[test]
fn a_stranger_on_the_subnet_is_answered_if_the_user_asks_for_the_subnet() {
    let Some(hosts) = Hosts::new("open") else { return };
    let domain = Domain::reserve();
    let mut machine = machine(&hosts, &domain, Some("SUBNET"));
    wait_for("packets over lo", || hosts.sent("cable"), 0, &mut machine);
    let to_stranger = hosts.arrived_outside();
    announce_strangers(&hosts, &domain, || hosts.arrived_outside() > to_stranger);
    wait_for("answers", || hosts.arrived_outside(), to_stranger, &mut machine);
}

#[test]
fn a_node_that_shall_be_secure_refuses_to_start() {
    for (binary, arguments) in
        [(env!("CARGO_BIN_EXE_machine_sim"), &[][..]), (env!("CARGO_BIN_EXE_camwright"), &["run", "--bag", "none"])]
    {
        let mut command = std::process::Command::new(binary);
        command.args(arguments).current_dir(support::repository()).env("ROS_SECURITY_ENABLE", "true");
        let mut node = Guarded::start(binary, &mut command);
        assert_eq!(node.wait(PATIENCE).code(), Some(1), "{binary}{}", node.complaint());
        let stderr = node.stderr();
        assert!(stderr.contains("ROS_SECURITY_ENABLE=true, but DDS security is not supported"), "{binary}: {stderr}");
    }
}

#[test]
fn settings_without_effect_are_named_in_one_warning() {
    let domain = Domain::reserve();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_machine_sim"));
    command
        .current_dir(support::repository())
        .env("ROS_DOMAIN_ID", domain.id().to_string())
        .env("ROS_STATIC_PEERS", "192.0.2.7")
        .env("RMW_IMPLEMENTATION", "rmw_zenoh_cpp")
        .args(["--ros-args", "--enclave", "/cell", "-p", "state_file:=none"]);
    let mut node = Guarded::start("machine_sim", &mut command);
    let named = |node: &Guarded| node.stderr().matches("ignored: ").count();
    let deadline = Instant::now() + PATIENCE;
    while named(&node) == 0 {
        assert!(node.is_running() && Instant::now() < deadline, "no warning{}", node.complaint());
        std::thread::sleep(Duration::from_millis(20));
    }
    node.interrupt();
    assert!(node.wait(PATIENCE).success(), "{}", node.complaint());
    let stderr = node.stderr();
    assert_eq!(named(&node), 1, "{stderr}");
    for setting in ["ROS_STATIC_PEERS=192.0.2.7", "RMW_IMPLEMENTATION=rmw_zenoh_cpp", "--enclave /cell"] {
        assert!(stderr.contains(setting), "{setting}: {stderr}");
    }
}
