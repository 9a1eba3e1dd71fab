//! A GAP over many samples makes `irrelevant_changes_range` insert each number into a map.

use super::common::{Checked, Verdict, memory_kb, participant, wait};
use super::peer::{GAP, PUBLICATIONS_READER, PUBLICATIONS_WRITER, Peer, sequence_number, submessage};
use std::time::Duration;

const BASE: i64 = 4_000_000;

pub(crate) fn check() -> Checked {
    let participant = participant()?;
    let peer = Peer::meet(&participant)?;
    let before = memory_kb("VmHWM")?;
    let numbers = [sequence_number(2), sequence_number(BASE)].concat();
    let body = [&PUBLICATIONS_READER[..], &PUBLICATIONS_WRITER, &numbers, &[0, 0, 0, 0]].concat();
    peer.send(&[submessage(GAP, 1, &body)])?;
    let grown = wait(Duration::from_secs(2), || {
        memory_kb("VmHWM").ok().map(|now| now - before).filter(|grown| *grown > 30_000)
    });
    Ok(Verdict::pass_if(grown.is_none(), || {
        format!("a GAP of {BASE} samples took more than {} kB", grown.unwrap_or_default())
    }))
}
