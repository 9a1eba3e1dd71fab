// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The datagrams a node accepts, as a program for its sockets.
//!
//! The program walks the submessages of an RTPS message (OMG DDSI-RTPS 2.5, section 9.4) as `RustDDS` 0.15.1 does and drops the datagram if one
//! of them would make `RustDDS` allocate without bound, loop for ever or panic (`UPSTREAM.md`, lines 12 to 16):
//!
//! | submessage | passes if |
//! |---|---|
//! | all with a sequence number | it is below 2^48 |
//! | HEARTBEAT | at most 1.1 million samples between first and last |
//! | GAP | it starts at 1 (which is cheap) or spans at most 200,000 samples |
//! | `NACK_FRAG` | its base lies in 1..65535 |
//! | `DATA_FRAG` | the sample is below 16 MiB (64 KiB in discovery), its fragments have 256 octets or more |
//! | `INFO_REPLY` | never: it redirects answers, and no ROS 2 peer sends it |
//! | any | it is little-endian, as all peers on the processors we support are |
//!
//! Classic BPF has no loops, so the walk is unrolled and has an end: [`FilterExtent`]. A datagram with more submessages than that is dropped if it
//! comes from another host, whose datagrams are short. On this host it passes, since a busy `RustDDS` writer packs a thousand samples into one;
//! the watchdog and the limit of memory then remain.

use super::assembler::{Assembler, FilterStep, Label, code::*};

/// Ancillary data of the kernel (`SKF_AD_OFF`): packet type and interface.
const PACKET_TYPE: u32 = 0xffff_f004;
const INTERFACE: u32 = 0xffff_f008;
/// `PACKET_LOOPBACK`: the copy of a multicast that this host sent itself.
const LOOPED_BACK: u32 = 5;
/// The loopback interface has this index in every network namespace.
const LOOPBACK_INTERFACE: u32 = 1;

/// The filter sees the UDP header (8 octets) first, then the RTPS header (20 octets).
const RTPS_HEADER: u32 = 8;
const GUID_PREFIX: u32 = 16;
const FIRST_SUBMESSAGE: u32 = 28;

const PASS: u32 = u32::MAX;
const DROP: u32 = 0;

/// Words of the filter's memory.
const OFFSET: u32 = 0;
const OTHER: u32 = 1;

const LITTLE_ENDIAN: u32 = 1;
/// Entity kinds of discovery's own endpoints have both of these bits.
const BUILT_IN: u32 = 0xc0;

/// Submessage kinds (section 9.4.5.1.1).
const PAD: u32 = 0x01;
const ACKNACK: u32 = 0x06;
const HEARTBEAT: u32 = 0x07;
const GAP: u32 = 0x08;
const INFO_TS: u32 = 0x09;
const INFO_REPLY_IP4: u32 = 0x0d;
const INFO_REPLY: u32 = 0x0f;
const NACK_FRAG: u32 = 0x12;
const HEARTBEAT_FRAG: u32 = 0x13;
const DATA: u32 = 0x15;
const DATA_FRAG: u32 = 0x16;

/// Whom a socket listens to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sources {
    /// Processes of this host.
    ThisHost,
    Anybody,
}

/// Extent of the filter program's walk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FilterExtent {
    /// Submessages of any kind.
    pub(super) any: usize,
    /// Further submessages that are DATA or interpreter submessages; one of another kind has to be the last.
    pub(super) plain: usize,
    /// True if a longer datagram from another host is dropped.
    pub(super) drop_longer: bool,
}

impl FilterExtent {
    /// Needs 128 KiB of socket option memory, the kernel's default since 6.8.
    pub(super) const LONG: FilterExtent = FilterExtent { any: 16, plain: 100, drop_longer: true };
    /// Fits into the 20 KiB of older kernels.
    pub(super) const SHORT: FilterExtent = FilterExtent { any: 5, plain: 16, drop_longer: false };
}

/// The program for a socket that reads. With `admitted`, other participants are not received.
pub(super) fn reading(sources: Sources, walk: FilterExtent, admitted: Option<&[[u8; 12]]>) -> Option<Vec<FilterStep>> {
    let mut a = Assembler::default();
    if sources == Sources::ThisHost {
        drop_other_hosts(&mut a);
    }
    if let Some(admitted) = admitted {
        drop_others(&mut a, admitted);
    }
    let (drop, rtps) = (a.label(), a.label());
    a.op(LOAD_WORD, RTPS_HEADER);
    a.jump_if(IF_EQUAL, u32::from_be_bytes(*b"RTPS"), rtps);
    a.place(drop);
    a.op(RETURN, DROP);
    a.place(rtps);
    a.op(SET_X, FIRST_SUBMESSAGE);
    for _ in 0..walk.any {
        any_submessage(&mut a);
    }
    let inspected_last = a.label();
    for _ in 0..walk.plain {
        plain_submessage(&mut a, inspected_last);
    }
    if walk.drop_longer && sources == Sources::Anybody {
        pass_if_ended(&mut a);
        drop_other_hosts(&mut a);
    }
    a.op(RETURN, PASS);
    // A submessage behind the walk that has to be inspected: it must be the last.
    a.place(inspected_last);
    any_submessage(&mut a);
    pass_if_ended(&mut a);
    if walk.drop_longer && sources == Sources::Anybody {
        drop_other_hosts(&mut a);
    }
    a.op(RETURN, PASS);
    a.finish()
}

/// The program for a socket that only sends.
pub(super) fn deaf() -> Vec<FilterStep> {
    vec![FilterStep { code: RETURN, jt: 0, jf: 0, k: DROP }]
}

/// Goes on for datagrams of this host alone.
fn drop_other_hosts(a: &mut Assembler) {
    let this_host = a.label();
    a.op(LOAD_WORD, INTERFACE);
    a.jump_if(IF_EQUAL, LOOPBACK_INTERFACE, this_host);
    a.op(LOAD_WORD, PACKET_TYPE);
    a.jump_if(IF_EQUAL, LOOPED_BACK, this_host);
    a.op(RETURN, DROP);
    a.place(this_host);
}

/// Goes on for datagrams of these participants alone.
fn drop_others(a: &mut Assembler, admitted: &[[u8; 12]]) {
    let known = a.label();
    for prefix in admitted {
        let other = a.label();
        // The last words of prefixes differ most.
        for word in (0..3_u32).rev() {
            let at = word as usize * 4;
            a.op(LOAD_WORD, GUID_PREFIX + 4 * word);
            let octets = [prefix[at], prefix[at + 1], prefix[at + 2], prefix[at + 3]];
            a.jump_unless(IF_EQUAL, u32::from_be_bytes(octets), other);
        }
        a.go(known);
        a.place(other);
    }
    a.op(RETURN, DROP);
    a.place(known);
}

fn pass_if_ended(a: &mut Assembler) {
    let goes_on = a.label();
    a.op(LOAD_LENGTH, 0);
    a.jump_unless(IF_EQUAL_X, 0, goes_on);
    a.op(RETURN, PASS);
    a.place(goes_on);
}

/// Loads the kind of the submessage at X; drops big-endian ones.
fn load_kind(a: &mut Assembler, drop: Label) {
    a.op(LOAD_HALF_AT_X, 0);
    a.jump_unless(IF_ANY_BIT, LITTLE_ENDIAN, drop);
    a.op(SHIFT_RIGHT, 8);
}

/// Loads a little-endian number of 16 bits at X + offset. Bits above the 16th are left over.
fn load_half(a: &mut Assembler, offset: u32) {
    a.op(LOAD_HALF_AT_X, offset);
    a.op(MULTIPLY, 0x1_0001);
    a.op(SHIFT_RIGHT, 8);
}

/// Moves X behind the submessage. A length of 0 means that it is the last, unless it may be empty.
fn advance(a: &mut Assembler, may_be_empty: Label) {
    let step = a.label();
    load_half(a, 2);
    a.op(AND, 0xffff);
    a.jump_unless(IF_EQUAL, 0, step);
    a.op(RETURN, PASS);
    a.place(may_be_empty);
    load_half(a, 2);
    a.op(AND, 0xffff);
    a.place(step);
    a.op(ADD_X, 0);
    a.op(ADD, 4);
    a.op(A_TO_X, 0);
}

/// Inspects the submessage at X, whatever it is, and moves X behind it.
fn any_submessage(a: &mut Assembler) {
    let [drop, next, empty] = std::array::from_fn(|_| a.label());
    let [gap, ranged, numbered, nack_frag, data, data_frag] = std::array::from_fn(|_| a.label());
    pass_if_ended(a);
    load_kind(a, drop);
    for (kind, target) in [
        (DATA, data),
        (INFO_TS, empty),
        (HEARTBEAT, ranged),
        (ACKNACK, numbered),
        (GAP, gap),
        (DATA_FRAG, data_frag),
        (NACK_FRAG, nack_frag),
        (HEARTBEAT_FRAG, numbered),
        (PAD, empty),
        (INFO_REPLY, drop),
        (INFO_REPLY_IP4, drop),
    ] {
        a.jump_if(IF_EQUAL, kind, target);
    }
    a.go(next);

    a.place(gap);
    // From 1 on: RustDDS moves its base and touches nothing.
    a.op(LOAD_WORD_AT_X, 12);
    a.jump_unless(IF_EQUAL, 0, ranged);
    a.op(LOAD_WORD_AT_X, 16);
    a.jump_unless(IF_EQUAL, 0x0100_0000, ranged);
    a.op(LOAD_HALF_AT_X, 22);
    a.jump_if(IF_EQUAL, 0, next);
    a.go(drop);

    a.place(ranged);
    range(a, drop);
    a.go(next);

    a.place(nack_frag);
    // Base of the fragment numbers: neither 0 nor beyond 16 bits.
    a.op(LOAD_HALF_AT_X, 22);
    a.jump_unless(IF_EQUAL, 0, drop);
    a.op(LOAD_HALF_AT_X, 20);
    a.jump_if(IF_EQUAL, 0, drop);
    a.place(numbered);
    // The upper 16 bits of the sequence number.
    a.op(LOAD_HALF_AT_X, 14);
    a.jump_unless(IF_EQUAL, 0, drop);
    a.go(next);

    a.place(data_frag);
    fragments(a, drop);
    a.place(data);
    a.op(LOAD_HALF_AT_X, 18);
    a.jump_if(IF_EQUAL, 0, next);
    a.place(drop);
    a.op(RETURN, DROP);

    a.place(next);
    advance(a, empty);
}

/// HEARTBEAT and GAP: two sequence numbers, which must be near each other. Compared are their multiples of 65536.
fn range(a: &mut Assembler, drop: Label) {
    a.op(LOAD_HALF_AT_X, 14);
    a.jump_unless(IF_EQUAL, 0, drop);
    // Upper words. They differ while a range crosses 2^32; for that moment heartbeats are lost.
    a.op(LOAD_WORD_AT_X, 20);
    a.op(STORE_A, OTHER);
    a.op(LOAD_WORD_AT_X, 12);
    a.op(STORE_X, OFFSET);
    a.op(LOAD_X_FROM_MEMORY, OTHER);
    a.jump_unless(IF_EQUAL_X, 0, drop);
    a.op(LOAD_X_FROM_MEMORY, OFFSET);
    load_half(a, 18);
    a.op(STORE_A, OTHER);
    load_half(a, 26);
    a.op(LOAD_X_FROM_MEMORY, OTHER);
    a.op(SUBTRACT_X, 0);
    // An empty range ends one before it starts.
    a.op(ADD, 1);
    a.op(AND, 0xffff);
    a.op(LOAD_X_FROM_MEMORY, OFFSET);
    a.jump_if(IF_GREATER, 17, drop);
    let near = a.label();
    let far = a.label();
    a.jump_if(IF_GREATER, 3, far);
    a.go(near);
    a.place(far);
    a.op(LOAD_BYTE_AT_X, 0);
    a.jump_if(IF_EQUAL, GAP, drop);
    a.place(near);
}

/// `DATA_FRAG`: the size of the sample and of its fragments.
fn fragments(a: &mut Assembler, drop: Label) {
    a.op(LOAD_BYTE_AT_X, 35);
    a.jump_unless(IF_EQUAL, 0, drop);
    a.op(LOAD_BYTE_AT_X, 31);
    a.jump_if(IF_EQUAL, 0, drop);
    let user = a.label();
    // The kind of the writer.
    a.op(LOAD_BYTE_AT_X, 15);
    a.op(AND, BUILT_IN);
    a.jump_unless(IF_EQUAL, BUILT_IN, user);
    a.op(LOAD_BYTE_AT_X, 34);
    a.jump_unless(IF_EQUAL, 0, drop);
    a.place(user);
}

/// A submessage that needs little inspection; others go to `inspect`.
fn plain_submessage(a: &mut Assembler, inspect: Label) {
    let [drop, data, next, empty] = std::array::from_fn(|_| a.label());
    pass_if_ended(a);
    load_kind(a, drop);
    a.jump_if(IF_EQUAL, DATA, data);
    a.jump_if(IF_EQUAL, INFO_TS, empty);
    a.go(inspect);
    a.place(data);
    a.op(LOAD_HALF_AT_X, 18);
    a.jump_if(IF_EQUAL, 0, next);
    a.place(drop);
    a.op(RETURN, DROP);
    a.place(next);
    advance(a, empty);
}
