// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A peer made by hand: RTPS messages over a UDP socket of the loopback interface.

use super::common::{Outcome, PATIENCE, text};
use rustdds::DomainParticipant;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

pub(crate) const SPDP_WRITER: [u8; 4] = [0, 1, 0, 0xc2];
pub(crate) const SPDP_READER: [u8; 4] = [0, 1, 0, 0xc7];
pub(crate) const PUBLICATIONS_WRITER: [u8; 4] = [0, 0, 3, 0xc2];
pub(crate) const PUBLICATIONS_READER: [u8; 4] = [0, 0, 3, 0xc7];
pub(crate) const SUBSCRIPTIONS_WRITER: [u8; 4] = [0, 0, 4, 0xc2];
pub(crate) const SUBSCRIPTIONS_READER: [u8; 4] = [0, 0, 4, 0xc7];
/// Writer and reader of the peer, without key.
pub(crate) const WRITER: [u8; 4] = [0, 0, 1, 3];
pub(crate) const READER: [u8; 4] = [0, 0, 1, 4];

pub(crate) const ACKNACK: u8 = 0x06;
pub(crate) const HEARTBEAT: u8 = 0x07;
pub(crate) const GAP: u8 = 0x08;
pub(crate) const INFO_REPLY: u8 = 0x0f;
pub(crate) const NACK_FRAG: u8 = 0x12;
pub(crate) const DATA: u8 = 0x15;
pub(crate) const DATA_FRAG: u8 = 0x16;

/// A participant of vendor 1.15 (Fast DDS) with one socket for discovery and user traffic.
#[derive(Debug)]
pub(crate) struct Peer {
    socket: UdpSocket,
    prefix: [u8; 12],
    discovery: SocketAddr,
    user_traffic: SocketAddr,
}

/// A submessage that the peer has received.
#[derive(Debug)]
pub(crate) struct Submessage {
    pub(crate) kind: u8,
    pub(crate) flags: u8,
    pub(crate) body: Vec<u8>,
}

impl Submessage {
    /// Entity id at this offset of the body.
    pub(crate) fn entity(&self, at: usize) -> Option<[u8; 4]> {
        self.body.get(at..at + 4)?.try_into().ok()
    }
}

pub(crate) fn sequence_number(value: i64) -> [u8; 8] {
    let octets = value.to_le_bytes();
    std::array::from_fn(|index| octets[(index + 4) % 8])
}

pub(crate) fn submessage(kind: u8, flags: u8, body: &[u8]) -> Vec<u8> {
    let length = u16::try_from(body.len()).unwrap_or_default();
    [&[kind, flags], &length.to_le_bytes()[..], body].concat()
}

fn parameter(id: u16, value: &[u8]) -> Vec<u8> {
    let padded = value.len().next_multiple_of(4);
    let length = u16::try_from(padded).unwrap_or_default();
    let mut octets = [&id.to_le_bytes()[..], &length.to_le_bytes(), value].concat();
    octets.resize(4 + padded, 0);
    octets
}

fn string(value: &str) -> Vec<u8> {
    let length = u32::try_from(value.len() + 1).unwrap_or_default();
    [&length.to_le_bytes()[..], value.as_bytes(), &[0]].concat()
}

pub(crate) fn locator(address: SocketAddr) -> Vec<u8> {
    let port = u32::from(address.port()).to_le_bytes();
    [&1_u32.to_le_bytes()[..], &port, &[0; 12], &Ipv4Addr::LOCALHOST.octets()].concat()
}

fn data(reader: [u8; 4], writer: [u8; 4], parameters: &[Vec<u8>]) -> Vec<u8> {
    let header = [&[0, 0, 16, 0][..], &reader, &writer, &sequence_number(1), &[0, 3, 0, 0]].concat();
    submessage(DATA, 5, &[header, parameters.concat(), parameter(1, &[])].concat())
}

impl Peer {
    /// A peer that this participant has discovered.
    pub(crate) fn meet(participant: &DomainParticipant) -> Result<Self, String> {
        let peer = Self::new(participant, *b"\x01\x0fupstream01")?;
        // A new participant drops messages until its discovery runs. It asks for the endpoints of a peer that it has discovered.
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            peer.announce()?;
            if (0..5).any(|_| peer.receive().iter().any(|part| part.kind == ACKNACK)) {
                return Ok(peer);
            }
        }
        Err(format!("no result: the peer was not discovered within {PATIENCE:?}"))
    }

    pub(crate) fn new(participant: &DomainParticipant, prefix: [u8; 12]) -> Result<Self, String> {
        let port = 7400 + 250 * participant.domain_id() + 10 + 2 * participant.participant_id();
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).map_err(text)?;
        socket.set_read_timeout(Some(Duration::from_millis(20))).map_err(text)?;
        let [discovery, user_traffic] = [port, port + 1].map(|port| (Ipv4Addr::LOCALHOST, port).into());
        Ok(Peer { socket, prefix, discovery, user_traffic })
    }

    pub(crate) fn address(&self) -> Result<SocketAddr, String> {
        self.socket.local_addr().map_err(text)
    }

    /// Announces the participant, with a lease of 100 s.
    pub(crate) fn announce(&self) -> Outcome {
        let own = locator(self.address()?);
        let parameters = [
            parameter(0x15, &[2, 3]),
            parameter(0x16, &[1, 15]),
            parameter(0x50, &[&self.prefix[..], &[0, 0, 1, 0xc1]].concat()),
            parameter(0x32, &own),
            parameter(0x31, &own),
            parameter(0x02, &[100, 0, 0, 0, 0, 0, 0, 0]),
            parameter(0x58, &0x0c3f_u32.to_le_bytes()),
        ];
        self.send(&[data(SPDP_READER, SPDP_WRITER, &parameters)])
    }

    /// Announces the reliable volatile writer (`WRITER`) or reader (`READER`) of a topic.
    pub(crate) fn announce_endpoint(&self, endpoint: [u8; 4], topic: &str, kind: &str) -> Outcome {
        let (reader, writer) = if endpoint == WRITER {
            (PUBLICATIONS_READER, PUBLICATIONS_WRITER)
        } else {
            (SUBSCRIPTIONS_READER, SUBSCRIPTIONS_WRITER)
        };
        let parameters = [
            parameter(0x5a, &[&self.prefix[..], &endpoint].concat()),
            parameter(0x50, &[&self.prefix[..], &[0, 0, 1, 0xc1]].concat()),
            parameter(0x2f, &locator(self.address()?)),
            parameter(0x05, &string(topic)),
            parameter(0x07, &string(kind)),
            parameter(0x1a, &[2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]),
        ];
        self.send(&[data(reader, writer, &parameters)])
    }

    /// Sends submessages to the discovery traffic of the participant.
    pub(crate) fn send(&self, parts: &[Vec<u8>]) -> Outcome {
        self.send_to(self.discovery, parts)
    }

    /// Sends submessages to the user traffic of the participant.
    pub(crate) fn send_user_traffic(&self, parts: &[Vec<u8>]) -> Outcome {
        self.send_to(self.user_traffic, parts)
    }

    fn send_to(&self, to: SocketAddr, parts: &[Vec<u8>]) -> Outcome {
        let message = [&b"RTPS\x02\x03\x01\x0f"[..], &self.prefix, &parts.concat()].concat();
        self.socket.send_to(&message, to).map(drop).map_err(text)
    }

    /// Submessages of the next datagram; none if no datagram arrives within 20 ms.
    pub(crate) fn receive(&self) -> Vec<Submessage> {
        let mut buffer = vec![0; 1 << 16];
        let length = self.socket.recv(&mut buffer).unwrap_or_default();
        let mut rest = buffer.get(20..length).unwrap_or_default();
        let mut parts = Vec::new();
        while let [kind, flags, low, high, tail @ ..] = rest {
            let announced = usize::from(u16::from_le_bytes([*low, *high]));
            // Length 0 of the last submessage means that it extends to the end of the datagram.
            let length = if announced == 0 { tail.len() } else { announced.min(tail.len()) };
            parts.push(Submessage { kind: *kind, flags: *flags, body: tail[..length].to_vec() });
            rest = &tail[length..];
        }
        parts
    }

    /// Waits for a submessage that fits.
    pub(crate) fn receive_until<T>(
        &self,
        what: &str,
        mut fits: impl FnMut(&Submessage) -> Option<T>,
    ) -> Result<T, String> {
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            if let Some(found) = self.receive().iter().find_map(&mut fits) {
                return Ok(found);
            }
        }
        Err(format!("no result: {what} did not arrive within {PATIENCE:?}"))
    }
}
