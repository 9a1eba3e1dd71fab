// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Fragments of a message of 1 MB: how the first transmission packs them, and how fast lost ones are repeated.

use super::common::{Checked, Outcome, PATIENCE, Verdict, participant, text, wait, writer};
use super::peer::{DATA_FRAG, NACK_FRAG, Peer, READER, sequence_number, submessage};
use rustdds::no_key::DataWriter;
use rustdds::{DataWriterStatus, DomainParticipant, RTPSEntity, StatusEvented};
use std::time::{Duration, Instant};

const LENGTH: usize = 1_000_000;
/// Octets of a `DATA_FRAG` before its fragments.
const HEADER: usize = 32;
/// Fragments that a `NACK_FRAG` can name.
const REQUESTED: usize = 256;

/// Octets in fragments and datagrams that arrive until none arrives for 100 ms or the deadline.
fn fragments(peer: &Peer, deadline: Instant, enough: usize) -> (usize, usize) {
    let (mut octets, mut datagrams, mut last) = (0, 0, Instant::now());
    while octets < enough && Instant::now() < deadline && last.elapsed() < Duration::from_millis(100) {
        for part in peer.receive().iter().filter(|part| part.kind == DATA_FRAG && part.body.len() > HEADER) {
            (octets, datagrams, last) = (octets + part.body.len() - HEADER, datagrams + 1, Instant::now());
        }
    }
    (octets, datagrams)
}

fn matched_peer(participant: &DomainParticipant, writer: &DataWriter<Vec<u8>>) -> Result<Peer, String> {
    let peer = Peer::meet(participant)?;
    peer.announce_endpoint(READER, "large_message", "upstream::Octets")?;
    let matched = wait(PATIENCE, || {
        matches!(writer.try_recv_status()?, DataWriterStatus::PublicationMatched { .. }).then_some(())
    });
    matched.ok_or("no result: the writer did not match")?;
    writer.write(vec![1; LENGTH], None).map_err(text)?;
    Ok(peer)
}

/// The first transmission fills its datagrams: at least 32 kB in each on the loopback interface.
pub(crate) fn packing() -> Checked {
    let participant = participant()?;
    let writer = writer(&participant, "large_message", 1)?;
    let peer = matched_peer(&participant, &writer)?;
    let (octets, datagrams) = fragments(&peer, Instant::now() + PATIENCE, LENGTH);
    if datagrams == 0 {
        return Err("no result: no DATA_FRAG arrived".into());
    }
    Ok(Verdict::pass_if(octets / datagrams >= 32_000, || format!("{octets} octets arrived in {datagrams} datagrams")))
}

/// Repetition sends 8 fragments of 256 octets every 10 ms, each in its own datagram (`handle_repair_frags_send_worker`). The maximum
/// is 0.2 MB/s: what a socket buffer of 208 kB loses of 1 MB takes 4 to 6 s.
pub(crate) fn repetition() -> Checked {
    let participant = participant()?;
    let writer = writer(&participant, "large_message", 1)?;
    let peer = matched_peer(&participant, &writer)?;
    fragments(&peer, Instant::now() + PATIENCE, LENGTH);
    request(&peer, &writer)?;
    let begun = Instant::now();
    let (octets, datagrams) = fragments(&peer, begun + PATIENCE, REQUESTED * 256);
    if datagrams == 0 {
        return Err("no result: no repeated DATA_FRAG arrived".into());
    }
    let taken = begun.elapsed();
    Ok(Verdict::pass_if(octets >= REQUESTED * 256 && taken < Duration::from_millis(150), || {
        format!("{octets} octets of {REQUESTED} requested fragments took {taken:.0?} in {datagrams} datagrams")
    }))
}

fn request(peer: &Peer, writer: &DataWriter<Vec<u8>>) -> Outcome {
    let entity = writer.guid().to_bytes();
    let set = [&1_u32.to_le_bytes()[..], &256_u32.to_le_bytes(), &[0xff; 32]].concat();
    let fields = [&READER[..], &entity[12..], &sequence_number(1), &set, &[1, 0, 0, 0]];
    peer.send_user_traffic(&[submessage(NACK_FRAG, 1, &fields.concat())])
}
