// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A `NACK_FRAG` of fragment 0 ends the event loop of the participant with a panic.

use super::common::{Checked, Verdict, first_panic, participant, wait};
use super::peer::{NACK_FRAG, PUBLICATIONS_READER, PUBLICATIONS_WRITER, Peer, sequence_number, submessage};
use std::time::Duration;

pub(crate) fn check() -> Checked {
    let participant = participant()?;
    let peer = Peer::meet(&participant)?;
    let set = [0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0x80];
    let fields = [&PUBLICATIONS_READER[..], &PUBLICATIONS_WRITER, &sequence_number(1), &set, &[1, 0, 0, 0]];
    peer.send(&[submessage(NACK_FRAG, 1, &fields.concat())])?;
    let panic = wait(Duration::from_secs(1), first_panic);
    Ok(panic.map_or(Verdict::Pass, Verdict::Fail))
}
