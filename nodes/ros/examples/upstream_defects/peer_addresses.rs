// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Discovery knows the locators of a peer and omits them from `ParticipantDescription`.

use super::common::{Checked, PATIENCE, Verdict, participant, wait};
use super::peer::Peer;
use rustdds::{DomainParticipantStatusEvent, StatusEvented};

pub(crate) fn check() -> Checked {
    let participant = participant()?;
    let events = participant.status_listener();
    let peer = Peer::meet(&participant)?;
    let discovered = wait(PATIENCE, || match events.try_recv_status()? {
        DomainParticipantStatusEvent::ParticipantDiscovered { dpd } => Some(format!("{dpd:?}")),
        _ => None,
    });
    let description = discovered.ok_or("no result: no ParticipantDiscovered")?;
    let port = peer.address()?.port().to_string();
    Ok(Verdict::pass_if(description.contains(&port), || format!("no locator in {description}")))
}
