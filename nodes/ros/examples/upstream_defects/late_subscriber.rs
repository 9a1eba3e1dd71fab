// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A volatile writer keeps a set of all numbers that it wrote before a reader joined.

use super::common::{Checked, PATIENCE, Verdict, memory_kb, participant, text, wait, writer};
use super::peer::{Peer, READER};
use rustdds::{DataWriterStatus, StatusEvented};

const SAMPLES: usize = 1_000_000;

pub(crate) fn check() -> Checked {
    let participant = participant()?;
    let writer = writer(&participant, "late_subscriber", 1)?;
    for _ in 0..SAMPLES {
        writer.write(vec![0], None).map_err(text)?;
    }
    let peer = Peer::meet(&participant)?;
    let before = memory_kb("VmRSS")?;
    peer.announce_endpoint(READER, "late_subscriber", "upstream::Octets")?;
    let matched = wait(PATIENCE, || {
        matches!(writer.try_recv_status()?, DataWriterStatus::PublicationMatched { .. }).then_some(())
    });
    matched.ok_or("no result: the writer did not match")?;
    let grown = memory_kb("VmRSS")?.saturating_sub(before);
    Ok(Verdict::pass_if(grown < 4_000, || format!("a reader after {SAMPLES} samples cost the writer {grown} kB")))
}
