// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Services as they are discovered, and requests that are serialised already, without waiting for their answers.

use super::discovery::TopicInfo;
use super::error::RosError;
use super::names::{self, NameKind};
use super::node::Node;
use super::qos::Qos;
use super::services::Writer;
use rustdds::bytes::Bytes;

/// Sends requests of one service.
pub struct RawRequests {
    writer: Writer,
    service: String,
}

impl std::fmt::Debug for RawRequests {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RawRequests").field("service", &self.service).finish_non_exhaustive()
    }
}

impl RawRequests {
    /// Sends a request: CDR without its encapsulation header.
    ///
    /// # Errors
    /// No room is left.
    pub fn send(&self, body: &[u8]) -> Result<(), RosError> {
        let sent = self.writer.request(Bytes::copy_from_slice(body), self.writer.guid(), false);
        sent.map(drop).map_err(|reason| RosError::publish(&self.service, reason))
    }
}

impl Node {
    /// Services that are known, those of actions included: name, type of the request (`pkg/srv/Name_Request`), and as subscriptions their servers.
    pub fn discovered_services(&self) -> Vec<TopicInfo> {
        self.graph().services()
    }

    /// Sends requests of a service whose request has the ROS name `request_type`.
    ///
    /// # Errors
    /// A name that breaks the rules, or the node is shut down.
    pub fn raw_requests(&self, service: &str, request_type: &str) -> Result<RawRequests, RosError> {
        let service = self.names().resolve(service, NameKind::Service)?;
        let dds_type = names::dds_type(request_type).ok_or_else(|| {
            RosError::create(format!("service of type '{request_type}'"), "a type is named package/srv/Name")
        })?;
        let writer = Writer::new(self, &names::dds_service(&service).0, &dds_type, &Qos::services())?;
        Ok(RawRequests { writer, service })
    }
}
