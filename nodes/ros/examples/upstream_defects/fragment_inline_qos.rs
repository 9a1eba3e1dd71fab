// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A fragment with inline parameters, which every long reply of a service has, is written with one octet too many: `data_frag.rs` writes
//! `Option<ParameterList>` with its tag. No reader understands it. With debug assertions the event loop of the writer ends with a panic.

use super::common::{Checked, PATIENCE, Verdict, connect, first_panic, participant, reader, take, text, writer};
use rustdds::rpc::SampleIdentity;
use rustdds::{RTPSEntity, SequenceNumber, WriteOptionsBuilder};
use std::time::Duration;

/// More than a datagram takes on any interface.
const LENGTH: usize = 100_000;

pub(crate) fn check() -> Checked {
    let (one, other) = (participant()?, participant()?);
    let writer = writer(&one, "fragment_inline_qos", 1)?;
    let mut reader = reader(&other, "fragment_inline_qos", 1)?;
    connect(&writer, &mut reader)?;
    writer.write(vec![1; LENGTH], None).map_err(text)?;
    if take(&mut reader, PATIENCE)? != Some(LENGTH) {
        return Err("no result: a long sample without inline parameters did not arrive either".into());
    }
    let request = SampleIdentity { writer_guid: writer.guid(), sequence_number: SequenceNumber::new(1) };
    let options = WriteOptionsBuilder::new().related_sample_identity(request).build();
    writer.write_with_options(vec![2; LENGTH], options).map_err(text)?;
    let patience = Duration::from_secs(2);
    let received = take(&mut reader, patience)?;
    Ok(Verdict::pass_if(received == Some(LENGTH), || {
        let panic = first_panic().map(|panic| format!("; {panic}")).unwrap_or_default();
        format!(
            "{LENGTH} octets with related_sample_identity did not arrive within {patience:?}, without it they did{panic}"
        )
    }))
}
