// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Two hosts with a cable between them: network namespaces.

use super::{Guarded, PATIENCE, in_ci, repository};
use rustix::thread::{LinkNameSpaceType, move_into_link_name_space};
use serde_json::Value;
use std::fs::File;
use std::io::{Read as _, Write as _};
use std::net::{TcpStream, UdpSocket};
use std::os::fd::AsFd;
use std::process::{ChildStdin, Command};

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

/// Cable that loses, delays, reorders and repeats frames, or is unplugged: `cable.py`. Its carrier is gone when this is dropped.
#[derive(Debug)]
pub struct Cable {
    process: Guarded,
    settings: ChildStdin,
}

impl Cable {
    fn between(hosts: &Hosts) -> Result<Self, String> {
        let mut command = Command::new("python3");
        command.arg(repository().join("tests/support/cable.py")).args([&hosts.inside, &hosts.outside]);
        let mut process = Guarded::start("cable.py", &mut command);
        let settings = process.take_stdin();
        match process.line(PATIENCE) {
            Some(_) => Ok(Self { process, settings }),
            None => Err(format!("cable.py makes no TAP devices{}", process.complaint())),
        }
    }

    /// Changes settings; returns what was counted since the change before.
    pub fn set(&mut self, settings: &Value) -> Value {
        writeln!(self.settings, "{settings}").expect("cable.py runs");
        let line = self.process.line(PATIENCE);
        let line = line.unwrap_or_else(|| panic!("cable.py ended{}", self.process.complaint()));
        serde_json::from_str(&line).expect("cable.py writes JSON")
    }
}

impl Hosts {
    /// Makes both namespaces.
    fn apart(purpose: &str) -> Result<Self, String> {
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
        Ok(hosts)
    }

    /// Gives both ends of the cable an address and makes them the way to everywhere.
    fn address(&self) -> Result<(), String> {
        for (namespace, address, gateway) in [(&self.inside, INSIDE, OUTSIDE), (&self.outside, OUTSIDE, INSIDE)] {
            ip(&["-n", namespace, "address", "add", &format!("{address}/24"), "dev", "cable"])?;
            ip(&["-n", namespace, "link", "set", "cable", "up"])?;
            // A route for everything, multicast too: nothing but a node's own restraint keeps a packet in.
            ip(&["-n", namespace, "route", "add", "default", "via", gateway])?;
        }
        Ok(())
    }

    fn connect(purpose: &str) -> Result<Self, String> {
        let hosts = Self::apart(purpose)?;
        let cable = ["-n", &hosts.inside, "link", "add", "cable", "type", "veth", "peer", "name", "cable", "netns"];
        ip(&[&cable[..], &[&hosts.outside]].concat())?;
        hosts.address()?;
        Ok(hosts)
    }

    fn connect_badly(purpose: &str) -> Result<(Self, Cable), String> {
        let hosts = Self::apart(purpose)?;
        let cable = Cable::between(&hosts)?;
        hosts.address()?;
        Ok((hosts, cable))
    }

    /// Namespaces need root. CI has it; a developer without sees that nothing was tested.
    pub fn new(purpose: &str) -> Option<Self> {
        made(Self::connect(purpose))
    }

    /// The same with a cable whose faults a test sets.
    pub fn with_faulty_cable(purpose: &str) -> Option<(Self, Cable)> {
        made(Self::connect_badly(purpose))
    }

    /// Packets sent so far over an interface of the inner namespace.
    pub fn sent(&self, interface: &str) -> u64 {
        let text = ip(&["-n", &self.inside, "-s", "-j", "link", "show", interface]).expect("the interface is there");
        let links: Value = serde_json::from_str(&text).expect("ip writes JSON");
        links[0]["stats64"]["tx"]["packets"].as_u64().expect("a counter")
    }

    /// A command that runs inside, on the host under test.
    pub fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        command_in(&self.inside, program)
    }

    /// A command that runs on the other host.
    pub fn command_outside(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        command_in(&self.outside, program)
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

    /// Content of an HTTP resource on the loopback of the host under test; an error while nothing serves it.
    pub fn get_inside(&self, port: u16, resource: &str) -> std::io::Result<String> {
        on_host(&self.inside, || {
            let mut stream = TcpStream::connect(("127.0.0.1", port))?;
            stream.set_read_timeout(Some(PATIENCE))?;
            write!(stream, "GET {resource} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n")?;
            let mut answer = String::new();
            stream.read_to_string(&mut answer)?;
            let (_, body) = answer.split_once("\r\n\r\n").unwrap_or_default();
            Ok(body.to_owned())
        })
    }
}

/// The hosts; without rights a loud word, and in CI a failure.
fn made<T>(hosts: Result<T, String>) -> Option<T> {
    match hosts {
        Ok(hosts) => Some(hosts),
        Err(error) if in_ci() => panic!("{error}"),
        Err(error) => {
            eprintln!("SKIPPED, NOT PASSED: no network namespace can be made here ({error})");
            None
        }
    }
}

fn command_in(namespace: &str, program: impl AsRef<std::ffi::OsStr>) -> Command {
    let mut command = Command::new("ip");
    command.args(["netns", "exec", namespace]).arg(program);
    command
}

/// Does something on a host: sockets belong to the namespace of the thread that makes them.
fn on_host<T: Send>(namespace: &str, action: impl FnOnce() -> T + Send) -> T {
    let file = File::open(format!("/run/netns/{namespace}")).expect("the namespace has a name");
    let act = || {
        move_into_link_name_space(file.as_fd(), Some(LinkNameSpaceType::Network)).expect("root may");
        action()
    };
    std::thread::scope(|scope| scope.spawn(act).join().expect("the action ends"))
}

fn socket_in(namespace: &str, address: &str) -> UdpSocket {
    on_host(namespace, || UdpSocket::bind((address, 0)).expect("a free port"))
}

impl Drop for Hosts {
    fn drop(&mut self) {
        for namespace in [&self.inside, &self.outside] {
            let _ = ip(&["netns", "delete", namespace]);
        }
    }
}
