// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! RTPS messages that `RustDDS` does not send as Fast DDS wants them, sent beside it.
//!
//! Each repairs what a user of real ROS 2 tools would see, and each is harmless to anybody else:
//!
//! **The first sample of a fresh Fast DDS writer.** A client or publisher that was just created may send its first sample a moment
//! before our participant has matched its writer; the sample is dropped. `RustDDS` then asks for what it missed with an ACKNACK of base
//! 1, which Fast DDS leaves unanswered until its next heartbeat, 3 s later: `ros2 topic pub --once` and `ros2 service call` hang for
//! that time once in a while. So the heartbeat that Fast DDS might send is sent here, to our own participant alone: "this writer has
//! sample 1". `RustDDS` asks for it, and Fast DDS sends it within some ms. If there is no such sample the request stays without
//! consequence. (Of 200 first calls of fresh clients 1 still waited 3 s; without this heartbeat 6 to 17 did.)
//!
//! **The farewell of a participant.** `RustDDS` says which participant leaves in the payload only, where Fast DDS does not look: topics
//! and services of a node that has ended stay in `ros2 topic list` for the lease of 50 s. Here the same is said inline.
//!
//! **A long reply.** What does not fit into one datagram is sent in fragments, and a reply carries inline whose request it answers.
//! `RustDDS` 0.15 writes one octet too many between the two (the tag of an `Option`), so no reader understands such a fragment: a Fast
//! DDS client waits for ever for a reply of more than 1372 octets, or of more than 65 kB if it announces the loopback interface alone.
//! So a long reply is sent from here, in one datagram or in fragments, and `RustDDS` writes the same sample without naming the request,
//! which it does right: a client with the reply takes that for a repetition, and it fills what was lost. On this host alone: where
//! a client on another host listens is not known here.

use std::{
    fmt, io,
    net::{Ipv4Addr, SocketAddr, UdpSocket},
};

use rustdds::GUID;

use super::{
    args::DiscoveryRange,
    rtps_messages::{FAST_DDS, Reply, disposal, heartbeat},
};

/// Maximum number of participants on this host that are announced; Fast DDS itself looks for the same number.
const LOCAL_PARTICIPANTS: u16 = 32;

/// First port of a domain (RTPS 2.5, section 9.6.2.3).
fn domain_port(domain_id: u16) -> u16 {
    7400 + 250 * domain_id
}

pub(super) struct FastDdsWorkarounds {
    socket: UdpSocket,
    domain_id: u16,
    range: DiscoveryRange,
    participant: GUID,
    user_traffic: SocketAddr,
}

impl fmt::Debug for FastDdsWorkarounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FastDdsWorkarounds").field("participant", &self.participant).finish_non_exhaustive()
    }
}

impl FastDdsWorkarounds {
    pub(super) fn new(
        participant: GUID,
        domain_id: u16,
        participant_id: u16,
        range: DiscoveryRange,
    ) -> io::Result<Self> {
        let address = match range {
            DiscoveryRange::Localhost => Ipv4Addr::LOCALHOST,
            DiscoveryRange::Subnet => Ipv4Addr::UNSPECIFIED,
        };
        let port = domain_port(domain_id) + 11 + 2 * participant_id;
        Ok(FastDdsWorkarounds {
            socket: UdpSocket::bind((address, 0))?,
            domain_id,
            range,
            participant,
            user_traffic: (Ipv4Addr::LOCALHOST, port).into(),
        })
    }

    /// A remote writer is matched with one of our readers.
    pub(super) fn writer_matched(&self, reader: &GUID, writer: &GUID) {
        // Discovery's own endpoints are left alone: their heartbeats are prompt, and one more would hide the first of them.
        if writer.to_bytes()[..2] == FAST_DDS && writer.entity_id.kind().is_user_defined() {
            // If it is lost, Fast DDS's own heartbeat comes in 3 s.
            let _ = self.socket.send_to(&heartbeat(&reader.to_bytes(), &writer.to_bytes()), self.user_traffic);
        }
    }

    pub(super) fn farewell(&self) {
        let message = disposal(&self.participant.to_bytes());
        self.to_local_participants(10, &message);
        if self.range == DiscoveryRange::Subnet {
            let _ = self.socket.send_to(&message, (Ipv4Addr::new(239, 255, 0, 1), domain_port(self.domain_id)));
        }
    }

    /// One of our writers answers a request with a long reply.
    pub(super) fn reply(&self, reply: &Reply<'_>) {
        for message in reply.messages() {
            self.to_local_participants(11, &message);
        }
    }

    /// To the port of every participant there may be on this host: 10 for discovery, 11 for messages (RTPS 2.5, section 9.6.2.3).
    fn to_local_participants(&self, kind: u16, message: &[u8]) {
        for number in 0..LOCAL_PARTICIPANTS {
            // An absent participant cannot be informed.
            let _ =
                self.socket.send_to(message, (Ipv4Addr::LOCALHOST, domain_port(self.domain_id) + kind + 2 * number));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_of_a_domain() {
        assert_eq!(domain_port(2), 7900);
    }
}
