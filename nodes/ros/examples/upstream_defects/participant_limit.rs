// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Each announced participant costs memory and answers, without a limit.

use super::common::{Checked, Verdict, memory_kb, participant};
use super::peer::Peer;

const STRANGERS: u32 = 400;

pub(crate) fn check() -> Checked {
    let participant = participant()?;
    let before = memory_kb("VmRSS")?;
    let mut answered = 0;
    for number in 0..STRANGERS {
        let mut prefix = *b"\x01\x0fstrangers!";
        prefix[8..].copy_from_slice(&number.to_le_bytes());
        let stranger = Peer::new(&participant, prefix)?;
        stranger.announce()?;
        answered += u32::from((0..5).any(|_| !stranger.receive().is_empty()));
    }
    let grown = memory_kb("VmRSS")?.saturating_sub(before);
    Ok(Verdict::pass_if(answered < STRANGERS / 2, || {
        format!("{answered} of {STRANGERS} strangers were discovered and answered, which took {grown} kB")
    }))
}
