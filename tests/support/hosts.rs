//! Two hosts with a cable between them: network namespaces.

use super::in_ci;
use rustix::thread::{LinkNameSpaceType, move_into_link_name_space};
use serde_json::Value;
use std::fs::File;
use std::net::UdpSocket;
use std::os::fd::AsFd;
use std::process::Command;

/// Address of the host under test.
pub const INSIDE: &str = "192.0.2.1";
/// Address of the other host.
pub const OUTSIDE: &str = "192.0.2.2";

/// Two network namespaces with a cable between them; gone when this is dropped.
#[derive(Debug)]
pub struct Hosts {
    pub inside: String,
    pub outside: String,
}

fn ip(arguments: &[&str]) -> Result<String, String> {
    let output = Command::new("ip").args(arguments).output().map_err(|error| format!("ip: {error}"))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(format!("ip {}: {}", arguments.join(" "), String::from_utf8_lossy(&output.stderr).trim()))
    }
}

impl Hosts {
    fn connect(purpose: &str) -> Result<Self, String> {
        let name = |end: &str| format!("camwright-{}-{purpose}-{end}", std::process::id());
        let hosts = Self { inside: name("in"), outside: name("out") };
        for namespace in [&hosts.inside, &hosts.outside] {
            ip(&["netns", "add", namespace])?;
            // Neighbour discovery of IPv6 sends some packets by itself.
            let off =
                "for all in all default; do echo 1 > /proc/sys/net/ipv6/conf/$all/disable_ipv6; done 2>/dev/null; true";
            ip(&["netns", "exec", namespace, "sh", "-c", off])?;
            ip(&["-n", namespace, "link", "set", "lo", "up"])?;
        }
        let cable = ["-n", &hosts.inside, "link", "add", "cable", "type", "veth", "peer", "name", "cable", "netns"];
        ip(&[&cable[..], &[&hosts.outside]].concat())?;
        for (namespace, address, gateway) in [(&hosts.inside, INSIDE, OUTSIDE), (&hosts.outside, OUTSIDE, INSIDE)] {
            ip(&["-n", namespace, "address", "add", &format!("{address}/24"), "dev", "cable"])?;
            ip(&["-n", namespace, "link", "set", "cable", "up"])?;
            // A route for everything, multicast too: nothing but a node's own restraint keeps a packet in.
            ip(&["-n", namespace, "route", "add", "default", "via", gateway])?;
        }
        Ok(hosts)
    }

    /// Namespaces need root. CI has it; a developer without sees that nothing was tested.
    pub fn new(purpose: &str) -> Option<Self> {
        match Self::connect(purpose) {
            Ok(hosts) => Some(hosts),
            Err(error) if in_ci() => panic!("{error}"),
            Err(error) => {
                eprintln!("SKIPPED, NOT PASSED: no network namespace can be made here ({error})");
                None
            }
        }
    }

    /// Packets sent so far over an interface of the inner namespace.
    pub fn sent(&self, interface: &str) -> u64 {
        let text = ip(&["-n", &self.inside, "-s", "-j", "link", "show", interface]).expect("the interface is there");
        let links: Value = serde_json::from_str(&text).expect("ip writes JSON");
        links[0]["stats64"]["tx"]["packets"].as_u64().expect("a counter")
    }

    /// A command that runs inside, on the host under test.
    pub fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new("ip");
        command.args(["netns", "exec", &self.inside]).arg(program);
        command
    }

    /// UDP datagrams that arrived at the outer namespace, with or without a listener.
    pub fn arrived_outside(&self) -> u64 {
        let text = ip(&["netns", "exec", &self.outside, "cat", "/proc/net/snmp"]).expect("proc is mounted");
        let mut lines = text.lines().filter_map(|line| line.strip_prefix("Udp: "));
        let (names, values) = (lines.next().expect("names"), lines.next().expect("values"));
        let counters = names.split_whitespace().zip(values.split_whitespace());
        let received = counters.filter(|(name, _)| matches!(*name, "InDatagrams" | "NoPorts" | "InErrors"));
        received.map(|(_, value)| value.parse::<u64>().expect("a number")).sum()
    }

    /// Datagrams that the sockets of the inner namespace have refused.
    pub fn refused_inside(&self) -> u64 {
        let text = ip(&["netns", "exec", &self.inside, "cat", "/proc/net/udp"]).expect("proc is mounted");
        text.lines().skip(1).filter_map(|line| line.split_whitespace().last()?.parse::<u64>().ok()).sum()
    }

    /// A UDP socket on the other host.
    pub fn socket_outside(&self) -> UdpSocket {
        socket_in(&self.outside, OUTSIDE)
    }

    /// A UDP socket on the host under test.
    pub fn socket_inside(&self) -> UdpSocket {
        socket_in(&self.inside, "127.0.0.1")
    }
}

/// A socket belongs to the namespace of the thread that makes it.
fn socket_in(namespace: &str, address: &str) -> UdpSocket {
    let file = File::open(format!("/run/netns/{namespace}")).expect("the namespace has a name");
    let address = address.to_owned();
    let make = move || {
        move_into_link_name_space(file.as_fd(), Some(LinkNameSpaceType::Network)).expect("root may");
        UdpSocket::bind((address, 0)).expect("a free port")
    };
    std::thread::spawn(make).join().expect("the thread makes a socket")
}

impl Drop for Hosts {
    fn drop(&mut self) {
        for namespace in [&self.inside, &self.outside] {
            let _ = ip(&["netns", "delete", namespace]);
        }
    }
}
