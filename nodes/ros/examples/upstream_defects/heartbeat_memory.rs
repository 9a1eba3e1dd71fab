//! A HEARTBEAT over many samples makes `missing_seqnums` list each of them.

use super::common::{Checked, Verdict, memory_kb, participant, wait};
use super::peer::{HEARTBEAT, PUBLICATIONS_READER, PUBLICATIONS_WRITER, Peer, sequence_number, submessage};
use std::time::Duration;

const LAST: i64 = 20_000_000;

pub(crate) fn check() -> Checked {
    let participant = participant()?;
    let peer = Peer::meet(&participant)?;
    let before = memory_kb("VmHWM")?;
    let numbers = [sequence_number(1), sequence_number(LAST)].concat();
    let body = [&PUBLICATIONS_READER[..], &PUBLICATIONS_WRITER, &numbers, &[1, 0, 0, 0]].concat();
    peer.send(&[submessage(HEARTBEAT, 1, &body)])?;
    let grown = wait(Duration::from_secs(2), || {
        memory_kb("VmHWM").ok().map(|now| now - before).filter(|grown| *grown > 50_000)
    });
    Ok(Verdict::pass_if(grown.is_none(), || {
        format!("a HEARTBEAT over {LAST} samples took more than {} kB", grown.unwrap_or_default())
    }))
}
