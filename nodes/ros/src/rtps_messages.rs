// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! RTPS messages octet by octet (OMG DDSI-RTPS 2.5, section 9.4).

use std::time::{SystemTime, UNIX_EPOCH};

/// Vendor id of Fast DDS, which by RTPS also begins its GUIDs.
pub(super) const FAST_DDS: [u8; 2] = [0x01, 0x0f];

/// Vendor id of `RustDDS`.
const RUST_DDS: [u8; 2] = [0x01, 0x12];

/// Octets of one fragment: that of `RustDDS`, whose fragments of the same sample these have to fit.
const FRAGMENT: usize = 256;

/// Fragments that travel together in one datagram.
const FRAGMENTS_IN_A_DATAGRAM: usize = 224;

const LITTLE_ENDIAN: u8 = 0x01;
const INLINE_QOS: u8 = 0x02;
const WITH_DATA: u8 = 0x04;
const PID_SENTINEL: [u8; 4] = [0x01, 0x00, 0, 0];

fn header(vendor: [u8; 2], source: &[u8]) -> Vec<u8> {
    let mut message = Vec::with_capacity(96);
    message.extend_from_slice(b"RTPS");
    message.extend_from_slice(&[2, 3]);
    message.extend_from_slice(&vendor);
    message.extend_from_slice(&source[..12]);
    message
}

fn sequence_number(message: &mut Vec<u8>, number: i64) {
    let octets = number.to_le_bytes();
    // The upper half first, each half in the message's order.
    message.extend_from_slice(&octets[4..]);
    message.extend_from_slice(&octets[..4]);
}

/// Begins a submessage; its length is entered by [`end`].
fn begin(message: &mut Vec<u8>, kind: u8, flags: u8) -> usize {
    message.extend_from_slice(&[kind, LITTLE_ENDIAN | flags, 0, 0]);
    message.len()
}

/// Ends the submessage that [`begin`] began, on a multiple of four octets.
fn end(message: &mut Vec<u8>, begun: usize) {
    message.resize(message.len().next_multiple_of(4), 0);
    let length = u16::try_from(message.len() - begun).expect("a submessage fits into a datagram");
    message[begun - 2..begun].copy_from_slice(&length.to_le_bytes());
}

fn destination(message: &mut Vec<u8>, guid: &[u8; 16]) {
    let info_dst = begin(message, 0x0e, 0);
    message.extend_from_slice(&guid[..12]);
    end(message, info_dst);
}

/// One HEARTBEAT (RTPS 2.5, section 9.4.5.7) from a writer to a reader: samples 1 to 1, answer wanted.
pub(super) fn heartbeat(reader: &[u8; 16], writer: &[u8; 16]) -> Vec<u8> {
    let mut message = header(FAST_DDS, writer);
    destination(&mut message, reader);
    // HEARTBEAT, neither final nor liveliness
    let begun = begin(&mut message, 0x07, 0);
    message.extend_from_slice(&reader[12..]);
    message.extend_from_slice(&writer[12..]);
    sequence_number(&mut message, 1);
    sequence_number(&mut message, 1);
    // The count of the first heartbeat: all that follow are greater, so none of them is taken for an old one.
    message.extend_from_slice(&1_i32.to_le_bytes());
    end(&mut message, begun);
    message
}

/// One DATA (RTPS 2.5, section 9.4.5.4) of the participant's announcements, without payload: disposed and unregistered.
pub(super) fn disposal(participant: &[u8; 16]) -> Vec<u8> {
    let mut message = header(RUST_DDS, participant);
    let begun = begin(&mut message, 0x15, INLINE_QOS);
    // Flags, and the offset of the inline QoS behind the fields that follow.
    message.extend_from_slice(&[0, 0, 16, 0]);
    // Reader: any reader of announcements. Writer: ours.
    message.extend_from_slice(&[0x00, 0x01, 0x00, 0xc7]);
    message.extend_from_slice(&[0x00, 0x01, 0x00, 0xc2]);
    // Later than any announcement, of which there is one in 10 s.
    sequence_number(&mut message, 1 << 30);
    // PID_KEY_HASH
    message.extend_from_slice(&[0x70, 0x00, 16, 0]);
    message.extend_from_slice(participant);
    // PID_STATUS_INFO
    message.extend_from_slice(&[0x71, 0x00, 4, 0, 0, 0, 0, 0x03]);
    message.extend_from_slice(&PID_SENTINEL);
    end(&mut message, begun);
    message
}

/// A sample that answers a request.
#[derive(Debug)]
pub(super) struct Reply<'a> {
    /// The writer of the reply, and the number that the sample has there.
    pub(super) writer: [u8; 16],
    pub(super) number: i64,
    /// Client and number of the answered request.
    pub(super) client: [u8; 16],
    pub(super) request: i64,
    /// Encapsulation header and body.
    pub(super) payload: &'a [u8],
}

impl Reply<'_> {
    /// One DATA, or several `DATA_FRAG` (RTPS 2.5, sections 9.4.5.4 and 9.4.5.5), each in a datagram of its own.
    pub(super) fn messages(&self) -> Vec<Vec<u8>> {
        const ROOM: usize = FRAGMENT * FRAGMENTS_IN_A_DATAGRAM;
        if self.payload.len() <= ROOM {
            return vec![self.whole()];
        }
        self.payload
            .chunks(ROOM)
            .enumerate()
            .map(|(chunk, octets)| self.part(chunk * FRAGMENTS_IN_A_DATAGRAM, octets))
            .collect()
    }

    fn whole(&self) -> Vec<u8> {
        let mut message = self.head(self.payload.len());
        let begun = begin(&mut message, 0x15, INLINE_QOS | WITH_DATA);
        // Flags, and the offset of the inline QoS behind the fields that follow.
        message.extend_from_slice(&[0, 0, 16, 0]);
        self.identity(&mut message);
        self.inline_qos(&mut message);
        message.extend_from_slice(self.payload);
        end(&mut message, begun);
        message
    }

    /// Some fragments, those before them being so many.
    fn part(&self, before: usize, octets: &[u8]) -> Vec<u8> {
        let number = |number: usize| u32::try_from(number).expect("a reply fits into memory by far").to_le_bytes();
        let mut message = self.head(octets.len());
        let begun = begin(&mut message, 0x16, INLINE_QOS);
        message.extend_from_slice(&[0, 0, 28, 0]);
        self.identity(&mut message);
        message.extend_from_slice(&number(before + 1));
        message.extend_from_slice(&number(octets.len().div_ceil(FRAGMENT))[..2]);
        message.extend_from_slice(&number(FRAGMENT)[..2]);
        message.extend_from_slice(&number(self.payload.len()));
        self.inline_qos(&mut message);
        message.extend_from_slice(octets);
        end(&mut message, begun);
        message
    }

    fn head(&self, room: usize) -> Vec<u8> {
        let mut message = header(RUST_DDS, &self.writer);
        message.reserve(room + 128);
        destination(&mut message, &self.client);
        // INFO_TS: the source timestamp
        let begun = begin(&mut message, 0x09, 0);
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let fraction = (u64::from(now.subsec_nanos()) << 32) / 1_000_000_000;
        message.extend_from_slice(&now.as_secs().to_le_bytes()[..4]);
        message.extend_from_slice(&fraction.to_le_bytes()[..4]);
        end(&mut message, begun);
        message
    }

    fn identity(&self, message: &mut Vec<u8>) {
        // Any reader of that participant.
        message.extend_from_slice(&[0; 4]);
        message.extend_from_slice(&self.writer[12..]);
        sequence_number(message, self.number);
    }

    fn inline_qos(&self, message: &mut Vec<u8>) {
        // PID_RELATED_SAMPLE_IDENTITY as RTPS 2.5 has it, and as Fast DDS had it before.
        for parameter in [0x0083_u16, 0x800f] {
            message.extend_from_slice(&parameter.to_le_bytes());
            message.extend_from_slice(&24_u16.to_le_bytes());
            message.extend_from_slice(&self.client);
            sequence_number(message, self.request);
        }
        message.extend_from_slice(&PID_SENTINEL);
    }
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
    }

    fn reply(payload: &[u8]) -> Reply<'_> {
        Reply { writer: [5; 16], number: 3, client: [7; 16], request: (2 << 32) + 9, payload }
    }

    #[test]
    fn a_reply_names_the_request_before_its_payload() {
        let payload = [0xab; 1501];
        let messages = reply(&payload).messages();
        let [message] = messages.as_slice() else { panic!("one datagram") };
        // Header, destination, time stamp.
        let data = 20 + 16 + 12;
        assert_eq!(message[data..data + 2], [0x15, 7]);
        assert_eq!(message.len(), data + 4 + 20 + 60 + 1504);
        assert_eq!(message[data + 2..data + 4], 1584_u16.to_le_bytes());
        assert_eq!(message[data + 16..data + 24], [0, 0, 0, 0, 3, 0, 0, 0], "the sample's number");
        assert_eq!(message[data + 24..data + 28], [0x83, 0, 24, 0]);
        assert_eq!(message[data + 44..data + 52], [2, 0, 0, 0, 9, 0, 0, 0], "the request's number");
        assert_eq!(message[data + 84], 0xab);
    }

    #[test]
    fn a_reply_longer_than_a_datagram_comes_in_fragments() {
        let payload: Vec<u8> = (0..150_001_u32).map(|octet| octet.to_le_bytes()[0]).collect();
        let messages = reply(&payload).messages();
        let mut assembled = Vec::new();
        for message in &messages {
            let body = &message[52..];
            assert_eq!(message[48..50], [0x16, 3]);
            let field = |at: usize| u32::from_le_bytes(body[at..at + 4].try_into().expect("four octets"));
            assert_eq!(field(20) as usize, assembled.len() / 256 + 1, "the first fragment's number");
            assert_eq!(field(28), 150_001);
            let count = (field(24) & 0xffff) as usize;
            let end = (assembled.len() + count * 256).min(payload.len());
            let length = end - assembled.len();
            assembled.extend_from_slice(&body[32 + 60..32 + 60 + length]);
        }
        assert_eq!(messages.len(), 3);
        assert_eq!(assembled, payload);
    }
}
