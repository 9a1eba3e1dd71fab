// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The filter in the kernel, against a reading of the same messages in Rust.

use std::{
    net::{Ipv4Addr, UdpSocket},
    time::Duration,
};

use socket2::{SockFilter, SockRef};

use super::rtps_filter::{FilterExtent, Sources, reading};

/// A pair of sockets with a filter between them.
struct FilteredPair {
    from: UdpSocket,
    to: UdpSocket,
}

const HEADER: [u8; 20] = *b"RTPS\x02\x03\x01\x0fabcdefghijkl";

impl FilteredPair {
    fn new(sources: Sources, walk: FilterExtent) -> Self {
        let program = reading(sources, walk, None).expect("all jumps have targets");
        assert!(program.len() <= 4096, "{} instructions", program.len());
        let to = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        let filters: Vec<SockFilter> = program.into_iter().map(SockFilter::from).collect();
        SockRef::from(&to).attach_filter(&filters).expect("the kernel takes the filter");
        to.set_read_timeout(Some(Duration::from_secs(20))).expect("a timeout");
        let from = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        from.connect(to.local_addr().expect("bound")).expect("UDP connects");
        FilteredPair { from, to }
    }

    /// Returns whether a message passes. A message without submessages, which always passes, follows it.
    fn passes(&self, message: &[u8]) -> bool {
        self.from.send(message).expect("sent");
        self.from.send(&HEADER).expect("sent");
        let mut octets = vec![0; 65_536];
        let length = self.to.recv(&mut octets).expect("the second message passes");
        let passed = octets[..length] == *message;
        if passed {
            self.to.recv(&mut octets).expect("the second message passes");
        }
        passed
    }
}

fn submessage(kind: u8, flags: u8, body: &[u8]) -> Vec<u8> {
    let length = u16::try_from(body.len()).expect("short");
    [&[kind, flags], &length.to_le_bytes()[..], body].concat()
}

fn number(value: i64) -> [u8; 8] {
    let octets = value.to_le_bytes();
    std::array::from_fn(|index| octets[(index + 4) % 8])
}

const READER: [u8; 4] = [0, 0, 3, 0xc7];
const WRITER: [u8; 4] = [0, 0, 3, 0xc2];
const USER_WRITER: [u8; 4] = [0, 0, 1, 0x03];

fn numbers(kind: u8, first: i64, second: i64) -> Vec<u8> {
    submessage(kind, 1, &[&READER[..], &WRITER, &number(first), &number(second), &[1, 0, 0, 0]].concat())
}

fn heartbeat(first: i64, last: i64) -> Vec<u8> {
    numbers(0x07, first, last)
}

fn gap(start: i64, base: i64) -> Vec<u8> {
    numbers(0x08, start, base)
}

fn nack_frag(base: u32) -> Vec<u8> {
    let fields =
        [&READER[..], &WRITER, &number(1), &base.to_le_bytes(), &[1, 0, 0, 0], &[0, 0, 0, 0x80], &[1, 0, 0, 0]];
    submessage(0x12, 1, &fields.concat())
}

fn data(number_: i64) -> Vec<u8> {
    submessage(0x15, 5, &[&[0, 0, 16, 0][..], &READER, &WRITER, &number(number_), &[0, 3, 0, 0, 1, 0, 0, 0]].concat())
}

fn data_frag(writer: [u8; 4], fragment: u16, sample: u32) -> Vec<u8> {
    let fields = [
        &[0, 0, 28, 0][..],
        &READER,
        &writer,
        &number(1),
        &[1, 0, 0, 0, 1, 0],
        &fragment.to_le_bytes(),
        &sample.to_le_bytes(),
        &[7; 64],
    ];
    submessage(0x16, 1, &fields.concat())
}

fn info_ts() -> Vec<u8> {
    submessage(0x09, 1, &[9; 8])
}

fn message(submessages: &[Vec<u8>]) -> Vec<u8> {
    [&HEADER[..], &submessages.concat()].concat()
}

#[test]
fn datagrams_that_bring_rustdds_down_are_dropped_and_honest_ones_pass() {
    const HUGE: i64 = 1 << 62;
    let dropped = [
        heartbeat(1, HUGE),
        heartbeat(1, 1 << 32),
        heartbeat(HUGE, HUGE),
        heartbeat(-1, 5),
        gap(2, HUGE),
        gap(1, HUGE),
        gap(2, 400_000),
        nack_frag(0),
        nack_frag(65_536),
        data(1 << 48),
        data_frag(USER_WRITER, 1024, 1 << 24),
        data_frag(USER_WRITER, 1024, u32::MAX),
        data_frag(USER_WRITER, 64, 100_000),
        data_frag(WRITER, 1024, 65_536),
        submessage(0x0f, 1, &[1, 0, 0, 0, 1, 0, 0, 0]),
        submessage(0x15, 4, &[0; 32]),
        vec![0x15, 5, 200, 0],
        vec![0x15],
    ];
    let passed = [
        heartbeat(1, 0),
        heartbeat(1, 1_000_000),
        heartbeat((1 << 33) + 7, (1 << 33) + 5000),
        heartbeat(65_536, 65_535),
        gap(1, 1 << 40),
        gap(5, 100_000),
        nack_frag(1),
        nack_frag(65_535),
        data((1 << 48) - 1),
        data_frag(USER_WRITER, 1024, (1 << 24) - 1),
        data_frag(WRITER, 1344, 40_000),
        info_ts(),
        submessage(0x09, 3, &[]),
        submessage(0x01, 1, &[]),
        submessage(0x0e, 1, &[1; 12]),
        submessage(0x81, 1, &[1; 12]),
    ];
    for walk in [FilterExtent::LONG, FilterExtent::SHORT] {
        for sources in [Sources::ThisHost, Sources::Anybody] {
            let gate = FilteredPair::new(sources, walk);
            for bad in &dropped {
                assert!(!gate.passes(&message(std::slice::from_ref(bad))), "{walk:?} passes {bad:02x?}");
                assert!(
                    !gate.passes(&message(&[info_ts(), data(1), bad.clone()])),
                    "{walk:?} passes {bad:02x?} behind"
                );
                // In the longest datagram that is inspected to its end.
                let inspected = walk.any + walk.plain - 1;
                let mut long = vec![data(1); inspected];
                long.push(bad.clone());
                assert!(!gate.passes(&message(&long)), "{walk:?} passes {bad:02x?} as submessage {inspected}");
            }
            for good in &passed {
                assert!(gate.passes(&message(std::slice::from_ref(good))), "{walk:?} drops {good:02x?}");
                assert!(
                    gate.passes(&message(&[info_ts(), good.clone(), heartbeat(1, 3)])),
                    "{walk:?} drops {good:02x?}"
                );
            }
            let batch: Vec<_> =
                (0..600).flat_map(|sample| [info_ts(), data(sample)]).chain([heartbeat(1, 600)]).collect();
            assert!(gate.passes(&message(&batch)), "{walk:?} drops what a busy writer on this host sends");
            assert!(!gate.passes(b"not RTPS at all, though long enough"));
        }
    }
}

/// Expected verdict of the filter, computed with slices instead of jumps; for messages that fit into the walk.
fn expected(message: &[u8]) -> bool {
    let mut rest = &message[20..];
    while !rest.is_empty() {
        let [kind, flags, low, high, body @ ..] = rest else { return false };
        if flags & 1 == 0 {
            return false;
        }
        let length = usize::from(u16::from_le_bytes([*low, *high]));
        let may_be_empty = matches!(kind, 0x01 | 0x09);
        let zero = |from: usize, to: usize| rest.get(from..to).map(|octets| octets.iter().all(|octet| *octet == 0));
        let signed = |at: usize| {
            let octets = rest.get(at..at + 8)?;
            Some(
                (i64::from(i32::from_le_bytes(octets[..4].try_into().ok()?)) << 32)
                    | i64::from(u32::from_le_bytes(octets[4..].try_into().ok()?)),
            )
        };
        let fine = match kind {
            0x0f | 0x0d => Some(false),
            0x15 => zero(18, 20),
            0x06 | 0x13 => zero(14, 16),
            0x12 => {
                zero(14, 16).zip(zero(22, 24)).zip(zero(20, 22)).map(|((number, high), low)| number && high && !low)
            }
            0x16 => zero(18, 20).zip(rest.get(15)).zip(rest.get(35)).map(|((number, writer), _)| {
                let built_in = writer & 0xc0 == 0xc0;
                number && rest[35] == 0 && rest[31] != 0 && (!built_in || rest[34] == 0)
            }),
            0x07 | 0x08 => signed(12).zip(signed(20)).map(|(first, last)| {
                if *kind == 0x08 && first == 1 {
                    return (0..1 << 48).contains(&last) || rest[22..24] == [0, 0];
                }
                let near = if *kind == 0x08 { 3 } else { 17 };
                let blocks = ((last & 0xffff_ffff) >> 16) - ((first & 0xffff_ffff) >> 16) + 1;
                (0..1 << 48).contains(&first) && first >> 32 == last >> 32 && (blocks & 0xffff) <= near
            }),
            _ => Some(true),
        };
        if fine != Some(true) {
            return false;
        }
        if length == 0 && !may_be_empty {
            return true;
        }
        let Some(next) = body.get(length..) else { return false };
        rest = next;
    }
    true
}

#[test]
fn the_kernel_decides_as_the_rules_do() {
    let gate = FilteredPair::new(Sources::ThisHost, FilterExtent::LONG);
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        usize::try_from(state >> 33).expect("31 bits") % below
    };
    let mut passed = 0;
    for _ in 0..6000 {
        let mut submessages = Vec::new();
        for _ in 0..=random(6) {
            let value = [0, 1, 2, 70_000, 200_000, 1_200_000, 1 << 32, (1 << 32) + 5, 1 << 47, 1 << 48, -1];
            let (one, two) = (value[random(value.len())], value[random(value.len())]);
            let mut part = match random(9) {
                0 => heartbeat(one, two),
                1 => gap(one, two),
                2 => nack_frag(u32::try_from(random(70_000)).expect("small")),
                3 => data_frag([0, 0, 1, [0x03, 0xc2][random(2)]], 1 << random(16), 1 << random(32)),
                4 => info_ts(),
                5 => submessage([1, 9, 0x0e, 0x81, 0x15][random(5)], 1, &[]),
                _ => data(one),
            };
            if random(4) == 0 {
                let at = random(part.len());
                part[at] = u8::try_from(random(256)).expect("an octet");
            }
            submessages.push(part);
        }
        let mut message = message(&submessages);
        if random(8) == 0 {
            message.truncate(20 + random(message.len() - 19));
        }
        // What extends to the end may be longer than the walk is; the rules above know no such end.
        let passes = gate.passes(&message);
        assert_eq!(passes, expected(&message), "{message:02x?}");
        passed += usize::from(passes);
    }
    assert!((1000..5000).contains(&passed), "{passed} of 6000 passed");
}
