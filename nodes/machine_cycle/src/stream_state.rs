// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Stream state that the cyclic thread adds to the report of a tick.

/// State that the cyclic loop adds to a report.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StreamState {
    /// Machine commands received from the holder, in sequence.
    pub commands_received: u32,
    /// A client has command of the setpoints.
    pub has_holder: bool,
    /// Who, by the GUID of its participant.
    pub holder: [u8; 16],
    /// True if the stream must be published at once.
    pub news: bool,
    /// First tick of the job that runs; 0: none does.
    pub job_tick: u64,
    /// Alarms were reset since the last tick.
    pub alarms_reset: bool,
    /// True if no tick was executed and only the stream is published.
    pub only_stream: bool,
    /// No motion may begin: ticks are about to be made up for.
    pub no_credit: bool,
}

camwright::snapshot!(StreamState { commands_received, has_holder, holder, job_tick } on { news, alarms_reset, only_stream, no_credit });
