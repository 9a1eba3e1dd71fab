// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lock that keeps two processes of a host from running the same node of one domain.
//!
//! The lock is an abstract Unix socket: it leaves no file, ends with its process, and is visible where the loopback interface is, so that
//! containers with networks of their own do not collide.

use super::args::RosArgs;
use super::error::RosError;
use super::names::NodeNames;
use super::running::NodeError;
use rustix::fd::OwnedFd;
use rustix::io::Errno;
use rustix::net::sockopt::socket_peercred;
use rustix::net::{AddressFamily, SocketAddrUnix, SocketFlags, SocketType, bind, connect, listen, socket_with};

/// Longest abstract name (bytes); longer names of nodes are not locked.
const MAX_NAME: usize = 100;

/// Name of a node in its domain, held until it is dropped.
#[derive(Debug)]
pub struct NodeLock {
    _socket: Option<OwnedFd>,
}

impl NodeLock {
    /// Takes the name of a node, as `args` remap it.
    ///
    /// # Errors
    /// Another process of this host runs the node. A host without abstract sockets locks nothing.
    pub fn acquire(node: &str, args: &RosArgs) -> Result<Self, NodeError> {
        let name = NodeNames::new(node, args.default_namespace(), args.remap_rules())
            .map_err(RosError::from)?
            .fully_qualified();
        let domain = args.domain_id();
        let key = format!("camwright/{domain}{name}");
        if key.len() > MAX_NAME {
            return Ok(Self { _socket: None });
        }
        match take(key.as_bytes()) {
            Ok(socket) => Ok(Self { _socket: Some(socket) }),
            Err(Errno::ADDRINUSE) => Err(NodeError::Parameter(runs_already(&name, domain, &holder(key.as_bytes())))),
            Err(_) => Ok(Self { _socket: None }),
        }
    }
}

/// Error for a node that runs in the domain already.
#[must_use]
pub fn runs_already(node: &str, domain: u16, holder: &str) -> String {
    format!(
        "node {node} runs already in ROS domain {domain}{holder}; nothing started: end that one, or choose another domain \
         (ROS_DOMAIN_ID) or namespace (--ros-args -r __ns:=/second)"
    )
}

fn socket() -> Result<OwnedFd, Errno> {
    socket_with(AddressFamily::UNIX, SocketType::STREAM, SocketFlags::CLOEXEC | SocketFlags::NONBLOCK, None)
}

fn take(key: &[u8]) -> Result<OwnedFd, Errno> {
    let socket = socket()?;
    bind(&socket, &SocketAddrUnix::new_abstract_name(key)?)?;
    listen(&socket, 1)?;
    Ok(socket)
}

/// ` (process 1234: camwright run)`, or nothing where the process cannot be found.
fn holder(key: &[u8]) -> String {
    let found = || -> Result<i32, Errno> {
        let socket = socket()?;
        connect(&socket, &SocketAddrUnix::new_abstract_name(key)?)?;
        Ok(socket_peercred(&socket)?.pid.as_raw_nonzero().get())
    };
    let Ok(process) = found() else { return String::new() };
    let words = std::fs::read(format!("/proc/{process}/cmdline")).unwrap_or_default();
    let words: Vec<String> = words
        .split(|byte| *byte == 0)
        .map(|word| String::from_utf8_lossy(word).into_owned())
        .filter(|word| !word.is_empty())
        .take(3)
        .collect();
    let separator = if words.is_empty() { "" } else { ": " };
    format!(" (process {process}{separator}{})", words.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_locked_once_in_its_domain_and_namespace() {
        let domain = u16::try_from(std::process::id() % 100).unwrap_or(0);
        let args = RosArgs::default().with_domain_id(domain).with_namespace("/lock_test");
        let lock = NodeLock::acquire("machine_sim", &args).expect("the name is free");
        let error = NodeLock::acquire("machine_sim", &args).expect_err("it is taken").to_string();
        let process =
            format!("node /lock_test/machine_sim runs already in ROS domain {domain} (process {}", std::process::id());
        assert!(error.starts_with(&process) && error.contains("ROS_DOMAIN_ID"), "{error}");
        for other in [args.clone().with_namespace("/lock_test_2"), args.clone().with_domain_id(domain + 1)] {
            NodeLock::acquire("machine_sim", &other).expect("another cell");
        }
        drop(lock);
        NodeLock::acquire("machine_sim", &args).expect("it is free again");
    }
}
