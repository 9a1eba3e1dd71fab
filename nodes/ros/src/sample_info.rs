// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Origin, number and times of a sample.

use camwright_threads::system_time::system_time_ns;
use rustdds::GUID;

/// Sample information of DDS.
#[derive(Debug, Clone, Copy)]
pub(super) struct SampleInfo {
    pub(super) writer: GUID,
    pub(super) number: i64,
    pub(super) source_ns: Option<i64>,
    pub(super) received_ns: i64,
    /// Which request a sample belongs to: the waiting reader and the number, which a client leaves unknown (below 1).
    pub(super) related: Option<(GUID, i64)>,
}

impl From<&ros2_client::MessageInfo> for SampleInfo {
    fn from(info: &ros2_client::MessageInfo) -> Self {
        SampleInfo {
            writer: GUID::from(info.publisher_gid()),
            number: info.sequence_number(),
            source_ns: info.source_timestamp().map(|stamp| stamp.to_nanos()),
            received_ns: info.received_timestamp().map_or_else(system_time_ns, |stamp| stamp.to_nanos()),
            related: info.related_request_id().map(|id| (GUID::from(id.writer_gid), id.sequence_number)),
        }
    }
}
