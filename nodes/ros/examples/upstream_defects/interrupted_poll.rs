// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A process that was stopped and continued is deaf: its event loops end on the EINTR of `epoll_wait`.

use super::common::{Checked, Verdict, connect, participant, reader, take, text, writer};
use std::process::Command;
use std::time::Duration;

pub(crate) fn check() -> Checked {
    let (one, other) = (participant()?, participant()?);
    let writer = writer(&one, "interrupted_poll", 1)?;
    let mut reader = reader(&other, "interrupted_poll", 1)?;
    connect(&writer, &mut reader)?;
    let script = "kill -STOP $0; sleep 0.2; kill -CONT $0";
    let stopped = Command::new("sh").args(["-c", script, &std::process::id().to_string()]).status().map_err(text)?;
    if !stopped.success() {
        return Err(format!("no result: sh ended with {stopped}"));
    }
    // The loops may need some time to see the interruption.
    for _ in 0..10 {
        writer.write(vec![0], None).map_err(text)?;
        if take(&mut reader, Duration::from_millis(200))?.is_some() {
            return Ok(Verdict::Pass);
        }
    }
    Ok(Verdict::Fail("no sample arrived within 2 s after SIGSTOP and SIGCONT".into()))
}
