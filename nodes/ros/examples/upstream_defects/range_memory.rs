// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A HEARTBEAT or a GAP over many samples takes memory for each of them: `missing_seqnums` lists them, `irrelevant_changes_range` inserts each
//! number into a map.

use super::common::{Checked, Verdict, memory_growth, memory_kb, participant};
use super::peer::{GAP, HEARTBEAT, PUBLICATIONS_READER, PUBLICATIONS_WRITER, Peer, sequence_number, submessage};
use std::time::Duration;

pub(crate) fn heartbeat() -> Checked {
    check("HEARTBEAT", HEARTBEAT, (1, 20_000_000), [1, 0, 0, 0], 50_000)
}

pub(crate) fn gap() -> Checked {
    check("GAP", GAP, (2, 4_000_000), [0, 0, 0, 0], 30_000)
}

fn check(name: &str, kind: u8, (first, last): (i64, i64), end: [u8; 4], above_kb: u64) -> Checked {
    let participant = participant()?;
    let peer = Peer::meet(&participant)?;
    let before = memory_kb("VmHWM")?;
    let numbers = [sequence_number(first), sequence_number(last)].concat();
    let body = [&PUBLICATIONS_READER[..], &PUBLICATIONS_WRITER, &numbers, &end].concat();
    peer.send(&[submessage(kind, 1, &body)])?;
    let grown = memory_growth(before, above_kb, Duration::from_secs(2), || Some(()));
    Ok(Verdict::pass_if(grown.is_none(), || {
        format!("a {name} over {last} samples took more than {} kB", grown.unwrap_or_default())
    }))
}
