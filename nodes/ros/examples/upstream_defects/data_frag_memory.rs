// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! One `DATA_FRAG` of 100 octets from an unannounced writer allocates the size that it claims.

use super::common::{Checked, Verdict, memory_growth, memory_kb, participant};
use super::peer::{DATA_FRAG, PUBLICATIONS_READER, PUBLICATIONS_WRITER, Peer, sequence_number, submessage};
use std::time::Duration;

const CLAIMED: u32 = 256 << 20;

pub(crate) fn check() -> Checked {
    let participant = participant()?;
    let stranger = Peer::new(&participant, *b"\x01\x0fstranger01")?;
    let before = memory_kb("VmHWM")?;
    let fields = [
        &[0, 0, 28, 0][..],
        &PUBLICATIONS_READER,
        &PUBLICATIONS_WRITER,
        &sequence_number(1),
        &[1, 0, 0, 0, 1, 0],
        &64_u16.to_le_bytes(),
        &CLAIMED.to_le_bytes(),
        &[0; 64],
    ];
    let message = submessage(DATA_FRAG, 1, &fields.concat());
    let grown = memory_growth(before, 100_000, Duration::from_secs(1), || {
        // A new participant drops messages until its discovery runs.
        stranger.send(std::slice::from_ref(&message)).ok()?;
        std::thread::sleep(Duration::from_millis(20));
        Some(())
    });
    Ok(Verdict::pass_if(grown.is_none(), || {
        format!("100 octets that claim {} kB took more than {} kB", CLAIMED >> 10, grown.unwrap_or_default())
    }))
}
