//! Two RTPS messages that `RustDDS` does not send as Fast DDS wants them, sent beside it.
//!
//! Both repair what a user of real ROS 2 tools would see, and both are harmless to anybody else:
//!
//! **The first sample of a fresh Fast DDS writer.** A client or publisher that was just created may send its first sample a moment
//! before our participant has matched its writer; the sample is dropped. `RustDDS` then asks for what it missed with an ACKNACK of base
//! 1, which Fast DDS leaves unanswered until its next heartbeat, 3 s later: `ros2 topic pub --once` and `ros2 service call` hang for
//! that time once in a while. So the heartbeat that Fast DDS might send is sent here, to our own participant alone: "this writer has
//! sample 1". `RustDDS` asks for it, and Fast DDS sends it within some ms. If there is no such sample the request stays without
//! consequence. (Of 80 fresh publishers 4 still waited 3 s, 20 were helped.)
//!
//! **The farewell of a participant.** `RustDDS` says which participant leaves in the payload only, where Fast DDS does not look: topics
//! and services of a node that has ended stay in `ros2 topic list` for the lease of 50 s. Here the same is said inline.

use std::{
    fmt, io,
    net::{Ipv4Addr, SocketAddr, UdpSocket},
};

use rustdds::GUID;

use super::args::DiscoveryRange;

/// Vendor id of Fast DDS, which by RTPS also begins its GUIDs.
const FAST_DDS: [u8; 2] = [0x01, 0x0f];

/// Vendor id of `RustDDS`.
const RUST_DDS: [u8; 2] = [0x01, 0x12];

/// Participants on this host that are told; Fast DDS itself looks for as many.
const LOCAL_PARTICIPANTS: u16 = 32;

/// First port of a domain (RTPS 2.5, section 9.6.2.3).
fn domain_port(domain_id: u16) -> u16 {
    7400 + 250 * domain_id
}

/// Sends the two messages.
pub(super) struct Beside {
    socket: UdpSocket,
    domain_id: u16,
    range: DiscoveryRange,
    participant: GUID,
    user_traffic: SocketAddr,
}

impl fmt::Debug for Beside {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Beside").field("participant", &self.participant).finish_non_exhaustive()
    }
}

impl Beside {
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
        Ok(Beside {
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

    /// Our participant leaves.
    pub(super) fn farewell(&self) {
        let message = disposal(&self.participant.to_bytes());
        let meta_traffic = domain_port(self.domain_id);
        for number in 0..LOCAL_PARTICIPANTS {
            // Who is not there cannot be told.
            let _ = self.socket.send_to(&message, (Ipv4Addr::LOCALHOST, meta_traffic + 10 + 2 * number));
        }
        if self.range == DiscoveryRange::Subnet {
            let _ = self.socket.send_to(&message, (Ipv4Addr::new(239, 255, 0, 1), meta_traffic));
        }
    }
}

const LITTLE_ENDIAN: u8 = 0x01;
const INLINE_QOS: u8 = 0x02;

fn header(vendor: [u8; 2], source: &[u8]) -> Vec<u8> {
    let mut message = Vec::with_capacity(96);
    message.extend_from_slice(b"RTPS");
    message.extend_from_slice(&[2, 3]);
    message.extend_from_slice(&vendor);
    message.extend_from_slice(&source[..12]);
    message
}

fn sequence_number(message: &mut Vec<u8>, number: u32) {
    message.extend_from_slice(&0_i32.to_le_bytes());
    message.extend_from_slice(&number.to_le_bytes());
}

/// One HEARTBEAT (RTPS 2.5, section 9.4.5.7) from a writer to a reader: samples 1 to 1, answer wanted.
fn heartbeat(reader: &[u8; 16], writer: &[u8; 16]) -> Vec<u8> {
    let mut message = header(FAST_DDS, writer);
    // INFO_DST
    message.extend_from_slice(&[0x0e, LITTLE_ENDIAN, 12, 0]);
    message.extend_from_slice(&reader[..12]);
    // HEARTBEAT, neither final nor liveliness
    message.extend_from_slice(&[0x07, LITTLE_ENDIAN, 28, 0]);
    message.extend_from_slice(&reader[12..]);
    message.extend_from_slice(&writer[12..]);
    sequence_number(&mut message, 1);
    sequence_number(&mut message, 1);
    // The count of the first heartbeat: all that follow are greater, so none of them is taken for an old one.
    message.extend_from_slice(&1_i32.to_le_bytes());
    message
}

/// One DATA (RTPS 2.5, section 9.4.5.4) of the participant's announcements, without payload: disposed and unregistered.
fn disposal(participant: &[u8; 16]) -> Vec<u8> {
    let mut message = header(RUST_DDS, participant);
    message.extend_from_slice(&[0x15, LITTLE_ENDIAN | INLINE_QOS, 0, 0]);
    let length_at = message.len() - 2;
    // Flags, and the offset of the inline QoS behind the fields that follow.
    message.extend_from_slice(&[0, 0, 16, 0]);
    // Reader: whoever reads announcements. Writer: that of our announcements.
    message.extend_from_slice(&[0x00, 0x01, 0x00, 0xc7]);
    message.extend_from_slice(&[0x00, 0x01, 0x00, 0xc2]);
    // Later than any announcement, of which there is one in 10 s.
    sequence_number(&mut message, 1 << 30);
    // PID_KEY_HASH
    message.extend_from_slice(&[0x70, 0x00, 16, 0]);
    message.extend_from_slice(participant);
    // PID_STATUS_INFO
    message.extend_from_slice(&[0x71, 0x00, 4, 0, 0, 0, 0, 0x03]);
    // PID_SENTINEL
    message.extend_from_slice(&[0x01, 0x00, 0, 0]);
    let length = u16::try_from(message.len() - length_at - 2).expect("some dozen octets");
    message[length_at..length_at + 2].copy_from_slice(&length.to_le_bytes());
    message
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_messages_are_as_long_as_their_parts_say() {
        let message = heartbeat(&[7; 16], &[9; 16]);
        assert_eq!(message.len(), 20 + 4 + 12 + 4 + 28);
        assert_eq!(&message[8..20], &[9; 12]);
        assert_eq!(&message[24..36], &[7; 12]);
        assert_eq!(message[36..40], [0x07, 1, 28, 0]);
        let message = disposal(&[5; 16]);
        assert_eq!(message.len(), 20 + 4 + 20 + 20 + 8 + 4);
        assert_eq!(message[20..24], [0x15, 3, 52, 0]);
        assert_eq!(domain_port(2), 7900);
    }
}
