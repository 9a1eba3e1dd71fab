// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The disposal of a participant or an endpoint names it in the payload only. Fast DDS reads key hash and status inline (RTPS 2.5, 9.6.4).

use super::common::{Checked, Verdict, participant as new_participant, writer as new_writer};
use super::peer::{DATA, PUBLICATIONS_WRITER, Peer, SPDP_WRITER, Submessage};

const INLINE_QOS: u8 = 2;
const KEY: u8 = 8;
const PID_KEY_HASH: [u8; 4] = [0x70, 0, 16, 0];

/// For a disposal from this writer: whether the key hash is inline.
fn names_key_inline(part: &Submessage, writer: [u8; 4]) -> Option<bool> {
    let is_disposal = part.kind == DATA && part.entity(8)? == writer && part.flags & KEY != 0;
    let has_key_hash = part.body.windows(4).any(|octets| octets == PID_KEY_HASH);
    is_disposal.then_some(part.flags & INLINE_QOS != 0 && has_key_hash)
}

fn verdict(inline: bool) -> Checked {
    Ok(Verdict::pass_if(inline, || "the disposal has no inline PID_KEY_HASH".into()))
}

pub(crate) fn participant() -> Checked {
    let participant = new_participant()?;
    let peer = Peer::meet(&participant)?;
    drop(participant);
    verdict(peer.receive_until("the disposal of the participant", |part| names_key_inline(part, SPDP_WRITER))?)
}

pub(crate) fn writer() -> Checked {
    let participant = new_participant()?;
    let writer = new_writer(&participant, "disposal", 1)?;
    let peer = Peer::meet(&participant)?;
    drop(writer);
    verdict(peer.receive_until("the disposal of the writer", |part| names_key_inline(part, PUBLICATIONS_WRITER))?)
}
