// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! An `INFO_REPLY` redirects the answers of a participant to any address.

use super::common::{Checked, Verdict, participant, text, wait};
use super::peer::{
    HEARTBEAT, INFO_REPLY, PUBLICATIONS_READER, PUBLICATIONS_WRITER, Peer, locator, sequence_number, submessage,
};
use std::net::{Ipv4Addr, UdpSocket};
use std::time::Duration;

pub(crate) fn check() -> Checked {
    let participant = participant()?;
    let peer = Peer::meet(&participant)?;
    let victim = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).map_err(text)?;
    victim.set_nonblocking(true).map_err(text)?;
    let redirect = [&1_u32.to_le_bytes()[..], &locator(victim.local_addr().map_err(text)?)].concat();
    let numbers = [sequence_number(1), sequence_number(1)].concat();
    // RustDDS 0.15 expects one octet more than RTPS: the tag of the absent multicast locators.
    for (count, tag) in [(1, &[][..]), (2, &[0])] {
        let redirect = [&redirect, tag].concat();
        let heartbeat = [&PUBLICATIONS_READER[..], &PUBLICATIONS_WRITER, &numbers, &[count, 0, 0, 0]].concat();
        peer.send(&[submessage(INFO_REPLY, 1, &redirect), submessage(HEARTBEAT, 1, &heartbeat)])?;
    }
    let redirected = wait(Duration::from_secs(1), || victim.recv(&mut [0; 1500]).ok());
    Ok(redirected.map_or(Verdict::Pass, |octets| {
        Verdict::Fail(format!("an address that announced nothing received {octets} octets"))
    }))
}
