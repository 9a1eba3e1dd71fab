// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Makes a participant whose sockets are guarded before they are read.
//!
//! `RustDDS` has no way to configure its sockets, but it reports each one to the `log` crate on the thread that has just bound it: the readers
//! before the thread that reads them exists, the senders before anything is sent. The logger here takes these reports as its cue. A participant
//! whose sockets were not all reported is refused, so that a later `RustDDS` with other words cannot run unguarded.

use std::{
    collections::BTreeSet,
    io,
    net::{IpAddr, Ipv4Addr, SocketAddrV4},
    sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError},
};

use log::{LevelFilter, Log, Metadata, Record};
use rustdds::{DomainParticipant, DomainParticipantBuilder};

use super::{
    descriptors::{self, Inode, UdpSocket},
    gate::{self, ParticipantGate},
    rtps_filter::{self, Sources},
    vitals::{Vitals, threads},
};
use crate::args::DiscoveryRange;

/// Discovery and user traffic, each unicast and multicast.
const READERS: usize = 4;
/// A host without multicast lacks two of them.
const READERS_WITHOUT_MULTICAST: usize = 2;

/// A participant, and what the watchdog looks at.
#[derive(Debug)]
pub(crate) struct WatchedParticipant {
    pub(crate) participant: DomainParticipant,
    pub(crate) vitals: Vitals,
    pub(crate) gate: ParticipantGate,
}

/// Sockets of the participant under construction.
#[derive(Debug)]
struct Construction {
    range: DiscoveryRange,
    known: BTreeSet<Inode>,
    readers: Vec<UdpSocket>,
    senders: usize,
    failure: Option<String>,
}

/// One participant is made at a time; the logger finds it here.
static CONSTRUCTION: Mutex<Option<Construction>> = Mutex::new(None);
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes a participant in this domain. With `DiscoveryRange::Localhost` it exchanges datagrams with this host alone.
///
/// # Errors
/// `RustDDS` cannot make it, or its sockets cannot be guarded.
pub(crate) fn build(domain_id: u16, range: DiscoveryRange) -> Result<WatchedParticipant, String> {
    let _turn = lock(&ONE_AT_A_TIME);
    install_logger()?;
    let system = |error: io::Error| format!("cannot inspect the sockets of this process: {error}");
    let known = descriptors::inodes().map_err(system)?;
    let threads_before = threads().map_err(system)?;
    *lock(&CONSTRUCTION) =
        Some(Construction { range, known, readers: Vec::with_capacity(READERS), senders: 0, failure: None });
    log::set_max_level(LevelFilter::Info);
    let mut builder = DomainParticipantBuilder::new(domain_id);
    if range == DiscoveryRange::Localhost {
        builder = builder.with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]);
    }
    let participant = builder.build();
    log::set_max_level(LevelFilter::Off);
    let construction = lock(&CONSTRUCTION).take().ok_or("the record of the sockets is gone")?;
    let participant = participant.map_err(|error| error.to_string())?;
    let readers = construction.readers;
    if let Some(failure) = construction.failure {
        return Err(failure);
    }
    if readers.len() < READERS_WITHOUT_MULTICAST || construction.senders == 0 {
        return Err(format!(
            "RustDDS reported {} of its {READERS} reading sockets and {} of its sending sockets; all must be guarded",
            readers.len(),
            construction.senders
        ));
    }
    let threads = threads().map_err(system)?.difference(&threads_before).copied().collect();
    let readers = Arc::new(readers);
    let gate = ParticipantGate::new(&readers, sources(range));
    Ok(WatchedParticipant { participant, vitals: Vitals { threads, readers }, gate })
}

impl Construction {
    /// Guards the socket that was just bound to this address.
    fn guard(&mut self, address: SocketAddrV4, reads: bool) -> Result<(), String> {
        let failed = |what: &str, error: io::Error| format!("cannot {what} the socket on {address}: {error}");
        let sockets = UdpSocket::bound_to(address, &self.known).map_err(|error| failed("find", error))?;
        if sockets.is_empty() {
            return Err(format!("cannot find the socket on {address} among the descriptors of this process"));
        }
        for socket in sockets {
            self.known.insert(socket.inode);
            if reads {
                gate::attach(&socket, sources(self.range), None).map_err(|error| failed("filter", error))?;
                self.readers.push(socket);
            } else {
                socket.filter(&rtps_filter::deaf()).map_err(|error| failed("filter", error))?;
                if self.range == DiscoveryRange::Localhost && address.ip().is_unspecified() {
                    socket.rebind_to_loopback().map_err(|error| failed("bind to 127.0.0.1", error))?;
                }
                self.senders += 1;
            }
        }
        Ok(())
    }
}

fn sources(range: DiscoveryRange) -> Sources {
    match range {
        DiscoveryRange::Localhost => Sources::ThisHost,
        DiscoveryRange::Subnet => Sources::Anybody,
    }
}

/// Takes `RustDDS`'s reports of its sockets.
struct SocketReports;

const LISTENER: &str = "rustdds::network::udp_listener";
const SENDER: &str = "rustdds::network::udp_sender";

impl Log for SocketReports {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        matches!(metadata.target(), LISTENER | SENDER)
    }

    fn log(&self, record: &Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let text = record.args().to_string();
        let reads = record.target() == LISTENER;
        let addresses = if reads { listener_address(&text) } else { sender_addresses(&text) };
        let mut construction = lock(&CONSTRUCTION);
        let Some(construction) = construction.as_mut() else { return };
        for address in addresses {
            if let Err(failure) = construction.guard(address, reads) {
                construction.failure.get_or_insert(failure);
            }
        }
    }

    fn flush(&self) {}
}

/// `UDPListener: new socket with address Ok(0.0.0.0:7400)`.
fn listener_address(text: &str) -> Vec<SocketAddrV4> {
    let address = text.strip_prefix("UDPListener: new socket with address Ok(").and_then(|rest| rest.strip_suffix(')'));
    address.and_then(|address| address.parse().ok()).into_iter().collect()
}

/// `UDPSender::new() --> UDPSender { unicast_socket: UdpSocket { addr: 0.0.0.0:40000, fd: 9 }, …`.
fn sender_addresses(text: &str) -> Vec<SocketAddrV4> {
    if !text.starts_with("UDPSender::new() -->") {
        return Vec::new();
    }
    text.split("addr: ").skip(1).filter_map(|rest| rest.split(',').next()?.parse().ok()).collect()
}

fn install_logger() -> Result<(), String> {
    static INSTALLED: OnceLock<bool> = OnceLock::new();
    if *INSTALLED.get_or_init(|| log::set_boxed_logger(Box::new(SocketReports)).is_ok()) {
        Ok(())
    } else {
        Err("this process has a logger of the `log` crate; make the first node before installing another one".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_from_the_reports() {
        let any = |port| SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, port);
        assert_eq!(listener_address("UDPListener: new socket with address Ok(0.0.0.0:7400)"), [any(7400)]);
        assert_eq!(
            sender_addresses(
                "UDPSender::new() --> UDPSender { unicast_socket: UdpSocket { addr: 0.0.0.0:40000, fd: 9 }, \
                 multicast_sockets: [(Ip(127.0.0.1), UdpSocket { addr: 127.0.0.1:40001, fd: 10 })] }"
            ),
            [any(40000), SocketAddrV4::new(Ipv4Addr::LOCALHOST, 40001)]
        );
    }

    #[test]
    fn a_participant_of_this_host_has_guarded_sockets_and_threads() {
        let guarded = build(61, DiscoveryRange::Localhost).expect("a participant");
        assert_eq!(guarded.vitals.readers.len(), READERS);
        assert_eq!(guarded.vitals.threads.len(), 2, "event loop and discovery");
    }
}
