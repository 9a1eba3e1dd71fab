// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Closes a node to newcomers when too many participants announce themselves.
//!
//! `RustDDS` answers each with an announcement to all and keeps it for the lease that it claims: some thousand that do not exist keep a node busy
//! for minutes, and it misses who really comes and goes. Beyond a limit the sockets pass only datagrams of participants that
//! this node has to do with, until the others have expired.

use std::{
    collections::BTreeSet,
    io,
    sync::Arc,
    time::{Duration, Instant},
};

use rustdds::DomainParticipantStatusEvent;

use super::{
    descriptors::UdpSocket,
    rtps_filter::{self, FilterExtent, Sources},
};

/// First octets of the GUIDs of a participant.
pub(crate) type Prefix = [u8; 12];

/// Participants beyond which a node closes. RTPS has ports for 120 on a host.
const LIMIT: usize = 240;

/// It opens again below this number, or after this time, since leases may be claimed for ever.
const FEW: usize = 160;
const CLOSED: Duration = Duration::from_secs(60);

/// Maximum number of admitted sockets: the capacity of the filter.
const ADMITTED: usize = 60;

/// The octets of a prefix.
pub(crate) fn octets(prefix: impl AsRef<[u8]>) -> Prefix {
    let mut octets = [0; 12];
    octets.copy_from_slice(prefix.as_ref());
    octets
}

/// The kernel's answers to a filter that is too long for it.
const NO_MEMORY: i32 = 12;
const TOO_LONG: i32 = 22;

/// The participants a node knows, and its sockets.
#[derive(Debug)]
pub(crate) struct ParticipantGate {
    readers: Arc<Vec<UdpSocket>>,
    sources: Sources,
    present: BTreeSet<Prefix>,
    closed: Option<Instant>,
}

impl ParticipantGate {
    pub(super) fn new(readers: &Arc<Vec<UdpSocket>>, sources: Sources) -> Self {
        ParticipantGate { readers: Arc::clone(readers), sources, present: BTreeSet::new(), closed: None }
    }

    /// Takes what discovery reports of participants. `admitted` are those that are received if the gate closes; returns a sentence if it does.
    pub(crate) fn admit(
        &mut self,
        event: &DomainParticipantStatusEvent,
        admitted: impl FnOnce() -> BTreeSet<Prefix>,
    ) -> Option<String> {
        match event {
            DomainParticipantStatusEvent::ParticipantDiscovered { dpd } => {
                self.discovered(octets(dpd.guid.prefix), admitted)
            }
            DomainParticipantStatusEvent::ParticipantLost { id, .. } => {
                self.present.remove(&octets(id));
                None
            }
            _ => None,
        }
    }

    fn discovered(&mut self, participant: Prefix, admitted: impl FnOnce() -> BTreeSet<Prefix>) -> Option<String> {
        self.present.insert(participant);
        if self.closed.is_some() || self.present.len() <= LIMIT {
            return None;
        }
        self.closed = Some(Instant::now());
        let admitted: Vec<Prefix> = admitted().into_iter().take(ADMITTED).collect();
        Some(match self.attach(Some(&admitted)) {
            Ok(()) => format!(
                "{} participants have announced themselves, more than {LIMIT}; until they have expired, only the {} that this node \
                 exchanges messages with are heard. Find the process that floods the domain",
                self.present.len(),
                admitted.len()
            ),
            Err(error) => format!(
                "{} participants have announced themselves, more than {LIMIT}, and the kernel cannot keep them out ({error}); find the \
                 process that floods the domain",
                self.present.len()
            ),
        })
    }

    /// Opens the gate when it is time. Returns a sentence if it does.
    pub(crate) fn reopen(&mut self) -> Option<String> {
        let since = self.closed?;
        if self.present.len() >= FEW && since.elapsed() < CLOSED {
            return None;
        }
        self.closed = None;
        self.attach(None).ok()?;
        Some(format!("{} participants are left; new ones are heard again", self.present.len()))
    }

    fn attach(&self, admitted: Option<&[Prefix]>) -> io::Result<()> {
        self.readers.iter().try_for_each(|socket| attach(socket, self.sources, admitted))
    }
}

/// Attaches the longest program the kernel takes; see [`rtps_filter::reading`].
pub(super) fn attach(socket: &UdpSocket, sources: Sources, admitted: Option<&[Prefix]>) -> io::Result<()> {
    let attach = |walk| {
        let program = rtps_filter::reading(sources, walk, admitted);
        socket.filter(&program.ok_or_else(|| io::Error::other("the filter has a jump without a target"))?)
    };
    match attach(FilterExtent::LONG) {
        // Too long for an older kernel, too long for an instruction count, or too long beside the filter that it replaces.
        Err(error) if matches!(error.raw_os_error(), Some(NO_MEMORY | TOO_LONG)) => attach(FilterExtent::SHORT),
        done => done,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::{Ipv4Addr, UdpSocket as StdSocket};

    #[test]
    fn beyond_the_limit_only_known_participants_are_received() {
        let to = StdSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        to.set_read_timeout(Some(Duration::from_secs(20))).expect("a timeout");
        let std::net::SocketAddr::V4(address) = to.local_addr().expect("bound") else { panic!("IPv4") };
        let readers = Arc::new(UdpSocket::bound_to(address, &BTreeSet::new()).expect("/proc is mounted"));
        let mut gate = ParticipantGate::new(&readers, Sources::ThisHost);
        gate.attach(None).expect("the kernel takes the filter");
        let message = |prefix: Prefix| [&b"RTPS\x02\x03\x01\x0f"[..], &prefix].concat();
        let (friends, stranger): (BTreeSet<Prefix>, Prefix) = ((1..=60).map(|friend| [friend; 12]).collect(), [99; 12]);
        let is_received = |prefix| {
            for sent in [prefix, [60; 12]] {
                to.send_to(&message(sent), address).expect("sent");
            }
            let mut octets = [0; 100];
            let mut receive =
                || to.recv(&mut octets).map(|length| octets[..length].to_vec()).expect("a friend is heard");
            let first = receive() == message(prefix);
            first && receive() == message([60; 12])
        };
        assert!(is_received(stranger));
        for number in 0..LIMIT {
            let mut prefix = [7; 12];
            prefix[..8].copy_from_slice(&number.to_le_bytes());
            assert_eq!(gate.discovered(prefix, || friends.clone()), None);
        }
        assert!(gate.discovered(stranger, || friends.clone()).is_some());
        assert!(!is_received(stranger));
        assert!(friends.iter().take(59).all(|friend| is_received(*friend)));
        assert_eq!(gate.reopen(), None);
        gate.present.clear();
        assert!(gate.reopen().is_some());
        assert!(is_received(stranger));
    }
}
