// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Nodes of a participant, as ROS 2 publishes them on `ros_discovery_info`.

use serde::{Deserialize, Serialize};

/// Identity of an endpoint: DDS GUID.
pub type Guid = [u8; 16];

/// `rmw_dds_common/msg/NodeEntitiesInfo`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct NodeEntities {
    pub(super) namespace: String,
    pub(super) name: String,
    pub(super) readers: Vec<Guid>,
    pub(super) writers: Vec<Guid>,
}

/// `rmw_dds_common/msg/ParticipantEntitiesInfo`: which nodes a participant holds.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct ParticipantEntities {
    pub(super) participant: Guid,
    pub(super) nodes: Vec<NodeEntities>,
}
