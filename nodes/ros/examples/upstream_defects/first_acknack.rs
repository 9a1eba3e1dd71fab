// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A reader that matches a writer asks for its samples with an ACKNACK of base 1. Fast DDS answers at once only if the base is 0.

use super::common::{Checked, Verdict, participant, reader};
use super::peer::{ACKNACK, Peer, WRITER};

pub(crate) fn check() -> Checked {
    let participant = participant()?;
    let _reader = reader(&participant, "first_acknack", 1)?;
    let peer = Peer::meet(&participant)?;
    peer.announce_endpoint(WRITER, "first_acknack", "upstream::Octets")?;
    let base = peer.receive_until("the first ACKNACK to the writer", |part| {
        // reader, writer, base of the set: high and low word
        let low = part.body.get(12..16)?.try_into().ok().map(u32::from_le_bytes)?;
        (part.kind == ACKNACK && part.entity(4)? == WRITER).then_some(low)
    })?;
    Ok(Verdict::pass_if(base == 0, || format!("the first ACKNACK has base {base}")))
}
