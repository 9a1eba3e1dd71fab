// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A taken sample stays in the cache of the topic until newer samples push it out.

use super::common::{Checked, PATIENCE, Verdict, connect, memory_kb, participant, reader, take, text, writer};

const SAMPLES: usize = 500;
const LENGTH: usize = 60_000;

pub(crate) fn check() -> Checked {
    let (one, other) = (participant()?, participant()?);
    let writer = writer(&one, "cache_after_take", 1)?;
    let mut reader = reader(&other, "cache_after_take", 10_000)?;
    connect(&writer, &mut reader)?;
    let mut round = || -> Result<u64, String> {
        for number in 0..SAMPLES {
            writer.write(vec![1; LENGTH], None).map_err(text)?;
            if take(&mut reader, PATIENCE)? != Some(LENGTH) {
                return Err(format!("no result: sample {number} did not arrive"));
            }
        }
        memory_kb("VmRSS")
    };
    let before = memory_kb("VmRSS")?;
    let after = round()?;
    let twice = round()?;
    let (kb, grown) = (SAMPLES * LENGTH / 1000, twice.saturating_sub(after));
    Ok(Verdict::pass_if(grown < 10_000, || {
        format!(
            "each {SAMPLES} samples ({kb} kB), all taken, added {} kB and {grown} kB to the memory",
            after.saturating_sub(before)
        )
    }))
}
