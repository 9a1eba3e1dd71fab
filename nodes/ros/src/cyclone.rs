// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Services as `rmw_cyclonedds_cpp` has them.
//!
//! Fast DDS puts the number of a request, or of the answered request, into inline parameters beside the sample. Cyclone puts it in front
//! of the sample's fields: a client id chosen by the client, and the number of the request; a reply begins with the same two. Neither
//! understands the other, so ROS 2 does not promise services between them. The GUID of the writer, which begins with the vendor, shows
//! the mapping of a sample, so here both are answered, each with its own mapping; samples of the other mapping carry no known name.

use std::time::{Duration, Instant};

use rustdds::{GUID, bytes::Bytes};
use serde::de::DeserializeOwned;

use super::discovery::Guid;
use super::wire::{Octets, from_cdr};

/// Vendor id of Eclipse Cyclone DDS, with which by RTPS its GUIDs begin.
const CYCLONE: [u8; 2] = [0x01, 0x10];

/// Octets before the fields.
const LENGTH: usize = 16;

/// Header before the fields of a request and of its reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) client: u64,
    /// Which of its requests it is.
    pub(super) number: i64,
}

/// Returns true for an endpoint of Cyclone DDS.
pub(super) fn is_cyclone(guid: &GUID) -> bool {
    guid.to_bytes()[..2] == CYCLONE
}

/// Time after the match until a reader on Cyclone is assumed to have matched our writer too. A message that arrives earlier counts as
/// older than the match: the reader acknowledges it and never delivers it. Measured: 0.1 ms between the two when a request was lost.
pub(super) const ACQUAINTANCE: Duration = Duration::from_millis(100);

/// Returns true if a peer that matched at that time receives what is sent now.
pub(super) fn knows_us(peer: &GUID, since: Instant) -> bool {
    !is_cyclone(peer) || since.elapsed() >= ACQUAINTANCE
}

/// Identity of a client in headers, unique to its reader.
pub(super) fn client_of(reader: &GUID) -> u64 {
    let octets = reader.to_bytes();
    let eight = |from: usize| u64::from_le_bytes(std::array::from_fn(|index| octets[from + index]));
    // Participant and entity stand in the last twelve octets; the first four are vendor and host.
    eight(4).rotate_left(32) ^ eight(8)
}

impl Header {
    /// Puts the header before the fields. It takes 16 octets, so the fields stay where CDR wants them.
    pub(super) fn before(self, fields: &[u8]) -> Bytes {
        Bytes::from([&self.client.to_le_bytes()[..], &self.number.to_le_bytes(), fields].concat())
    }

    /// Identity of the client in service events, as a server on Cyclone writes it: the id and zeros.
    pub(super) fn client_gid(self) -> Guid {
        let mut gid = Guid::default();
        gid[..8].copy_from_slice(&self.client.to_le_bytes());
        gid
    }

    fn split(body: &[u8]) -> Option<(Self, &[u8])> {
        let (client, rest) = body.split_first_chunk()?;
        let (number, fields) = rest.split_first_chunk()?;
        Some((Header { client: u64::from_le_bytes(*client), number: i64::from_le_bytes(*number) }, fields))
    }
}

/// Reads a request or reply; one of Cyclone's comes with its header.
pub(super) fn read<T: DeserializeOwned>(body: &Octets, writer: &GUID) -> Result<(Option<Header>, T), String> {
    if !is_cyclone(writer) {
        return from_cdr(&body.0).map(|fields| (None, fields));
    }
    let (header, fields) = Header::split(&body.0)
        .ok_or_else(|| format!("{} octets are less than the {LENGTH} of a header", body.0.len()))?;
    from_cdr(fields).map(|fields| (Some(header), fields))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(crate) fn guid(vendor: [u8; 2], last: u8) -> GUID {
        let mut octets = [7; 16];
        octets[..2].copy_from_slice(&vendor);
        octets[15] = last;
        GUID::from_bytes(octets)
    }

    #[test]
    fn a_header_stands_before_the_fields_of_cyclone_alone() {
        let header = Header { client: 0x0102, number: -3 };
        let body = Octets(header.before(&[5, 0, 0, 0]).to_vec());
        assert_eq!(body.0[..10], [2, 1, 0, 0, 0, 0, 0, 0, 0xfd, 0xff]);
        assert_eq!(read::<u32>(&body, &guid(CYCLONE, 1)), Ok((Some(header), 5)));
        assert_eq!(read::<u32>(&Octets(vec![5, 0, 0, 0]), &guid([1, 0x0f], 1)), Ok((None, 5)));
        assert!(read::<u32>(&Octets(vec![0; 15]), &guid(CYCLONE, 1)).is_err());
    }

    #[test]
    fn two_readers_of_a_participant_are_two_clients() {
        assert_ne!(client_of(&guid(CYCLONE, 4)), client_of(&guid(CYCLONE, 7)));
    }
}
