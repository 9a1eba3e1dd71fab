// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Events of service calls on `<service>/_service_event`, as rcl publishes them with service introspection.
//!
//! Parameters switch the events while the node runs, by group of endpoints. They have the names and values of the demos of ROS 2. A group
//! has no topics until it is enabled. Its topics then remain, without messages while it is disabled: peers on Fast DDS do not notice that
//! `RustDDS` withdraws an endpoint, and would list one more publisher for each time the group is enabled.

use std::fmt;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

use camwright_msgs::service_msgs::msg::ServiceEventInfo;
use rustdds::GUID;
use rustdds::bytes::Bytes;
use serde::Serialize;

use super::clock::{RosClock, to_time};
use super::discovery::Guid;
use super::error::RosError;
use super::load::Load;
use super::logging::Logger;
use super::node::Node;
use super::parameter_value::ParameterValue;
use super::parameters::Parameter;
use super::qos::Qos;
use super::topics::RawPublisher;
use super::wire::to_cdr;

/// Name of the topic of events below that of its service.
const TOPIC: &str = "_service_event";

/// Events that a reader may not have acknowledged; a call makes two on each side.
const DEPTH: u32 = 100;

/// Endpoints that one parameter switches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CallGroup {
    /// Services that every node has: parameters, type descriptions, logger levels. They publish no events, as in rclcpp and rclpy.
    BuiltIn,
    Services,
    Clients,
    /// The three services of each action.
    ActionServers,
    /// Clients of the three services of each action.
    ActionClients,
}

impl CallGroup {
    const SWITCHED: [Self; 4] = [Self::Services, Self::Clients, Self::ActionServers, Self::ActionClients];

    /// Parameter of the group, and its endpoints in words.
    fn parameter(self) -> Option<(&'static str, &'static str)> {
        match self {
            Self::BuiltIn => None,
            Self::Services => Some(("service_configure_introspection", "the services")),
            Self::Clients => Some(("client_configure_introspection", "the service clients")),
            Self::ActionServers => Some(("action_server_configure_introspection", "the action servers")),
            Self::ActionClients => Some(("action_client_configure_introspection", "the action clients")),
        }
    }
}

/// Parameters that every node has for its groups.
pub(super) fn parameters() -> impl Iterator<Item = Parameter> {
    CallGroup::SWITCHED.into_iter().filter_map(CallGroup::parameter).map(|(name, endpoints)| {
        Parameter::string(name, Detail::NAMES[0])
            .describe(&format!("events of calls of {endpoints} of the node, on _service_event below each service"))
            .choices(&Detail::NAMES)
    })
}

/// Content of the events.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Detail {
    Disabled,
    /// Type, time, client and number, without request and response.
    Metadata,
    Contents,
}

impl Detail {
    /// Values of a parameter, by number of the detail.
    const NAMES: [&'static str; 3] = ["disabled", "metadata", "contents"];

    fn from_number(number: u8) -> Self {
        match number {
            0 => Self::Disabled,
            1 => Self::Metadata,
            _ => Self::Contents,
        }
    }

    fn from_value(value: &ParameterValue) -> Self {
        let ParameterValue::String(name) = value else { return Self::Disabled };
        match name.as_str() {
            "metadata" => Self::Metadata,
            "contents" => Self::Contents,
            _ => Self::Disabled,
        }
    }
}

/// Identity of a call: with it the events of client and server are related.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct CallId {
    pub(super) client: Guid,
    pub(super) number: i64,
}

impl CallId {
    pub(super) fn new(client: &GUID, number: i64) -> Self {
        Self { client: client.to_bytes(), number }
    }
}

/// Event of a call, in the form of `pkg/srv/Name_Event`: at most one request and at most one response.
#[derive(Debug, Serialize)]
struct CallEvent<'a, Q, R> {
    info: &'a ServiceEventInfo,
    request: &'a [Q],
    response: &'a [R],
}

/// An empty sequence is the same octets for every type.
const ABSENT: &[u8] = &[];

/// Events of one service or client.
pub(super) struct CallEvents {
    group: CallGroup,
    topic: String,
    type_name: String,
    detail: AtomicU8,
    publisher: OnceLock<RawPublisher>,
    clock: Arc<RosClock>,
    load: Arc<Load>,
    logger: Logger,
}

impl fmt::Debug for CallEvents {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CallEvents").field("topic", &self.topic).field("group", &self.group).finish_non_exhaustive()
    }
}

impl CallEvents {
    fn detail(&self) -> Detail {
        Detail::from_number(self.detail.load(Ordering::Acquire))
    }

    /// Changes the detail. The caller lets one change come after the other.
    fn configure(&self, node: &Node, detail: Detail) -> Result<(), RosError> {
        if detail != Detail::Disabled && self.publisher.get().is_none() {
            let qos = Qos::services().keep_last(DEPTH);
            let publisher = node.impatient_raw_publisher(&self.topic, &self.type_name, &qos)?;
            let _is_the_first = self.publisher.set(publisher);
        }
        self.detail.store(detail as u8, Ordering::Release);
        Ok(())
    }

    /// Publishes that a request was sent or received, where events are enabled.
    pub(super) fn request<Q: Serialize>(&self, event_type: u8, call: CallId, request: &Q) {
        match self.detail() {
            Detail::Disabled => {}
            Detail::Metadata => self.publish_metadata(event_type, call),
            Detail::Contents => {
                let info = self.info(event_type, call);
                let request = std::slice::from_ref(request);
                self.publish(to_cdr(&CallEvent { info: &info, request, response: ABSENT }));
            }
        }
    }

    /// Publishes that a response was sent or received, where events are enabled.
    pub(super) fn response<R: Serialize>(&self, event_type: u8, call: CallId, response: &R) {
        match self.detail() {
            Detail::Disabled => {}
            Detail::Metadata => self.publish_metadata(event_type, call),
            Detail::Contents => {
                let info = self.info(event_type, call);
                let response = std::slice::from_ref(response);
                self.publish(to_cdr(&CallEvent { info: &info, request: ABSENT, response }));
            }
        }
    }

    fn publish_metadata(&self, event_type: u8, call: CallId) {
        let info = self.info(event_type, call);
        self.publish(to_cdr(&CallEvent { info: &info, request: ABSENT, response: ABSENT }));
    }

    fn info(&self, event_type: u8, call: CallId) -> ServiceEventInfo {
        let stamp = to_time(self.clock.now_ns());
        ServiceEventInfo { event_type, stamp, client_gid: call.client, sequence_number: call.number }
    }

    /// Publishes an event, or drops and counts it: a call never waits for a reader of its events.
    fn publish(&self, event: Result<Bytes, String>) {
        let Some(publisher) = self.publisher.get() else { return };
        let sent = event.map_err(|reason| RosError::publish(&self.topic, reason));
        match sent.and_then(|body| publisher.send(body.into())) {
            Ok(()) => {}
            Err(error) => {
                self.load.service_events_dropped.add_one();
                self.logger.debug(&error.to_string());
            }
        }
    }
}

/// Events of all services and clients of a node.
#[derive(Debug, Default)]
pub(super) struct Introspection {
    endpoints: Mutex<Vec<Weak<CallEvents>>>,
}

impl Node {
    /// Events of a service or client of a type, by the parameters of the node from now on.
    pub(super) fn call_events(
        &self,
        group: CallGroup,
        service: &str,
        type_name: &str,
    ) -> Result<Arc<CallEvents>, RosError> {
        let events = Arc::new(CallEvents {
            group,
            topic: format!("{service}/{TOPIC}"),
            type_name: format!("{type_name}_Event"),
            detail: AtomicU8::new(Detail::Disabled as u8),
            publisher: OnceLock::new(),
            clock: Arc::clone(self.clock()),
            load: Arc::clone(self.load()),
            logger: self.logger().clone(),
        });
        let Some((parameter, _)) = group.parameter() else { return Ok(events) };
        // Locked over both: a change of the parameter comes before or after them.
        let mut endpoints = self.introspection().endpoints.lock().unwrap_or_else(PoisonError::into_inner);
        let detail = self.parameters().get(parameter).as_ref().map_or(Detail::Disabled, Detail::from_value);
        events.configure(self, detail)?;
        endpoints.retain(|endpoint| endpoint.strong_count() > 0);
        endpoints.push(Arc::downgrade(&events));
        Ok(events)
    }

    fn configure_introspection(&self, group: CallGroup, detail: Detail) {
        let endpoints = self.introspection().endpoints.lock().unwrap_or_else(PoisonError::into_inner);
        for events in endpoints.iter().filter_map(Weak::upgrade).filter(|events| events.group == group) {
            if let Err(error) = events.configure(self, detail) {
                self.logger().warn(&error.to_string());
            }
        }
    }
}

/// Lets the events of a node follow its parameters from now on.
pub(super) fn follow_parameters(node: &Node) {
    let weak = node.downgrade();
    node.parameters().on_change(move |changes| {
        let Some(node) = weak.upgrade() else { return };
        for (name, value) in changes {
            let is_its = |group: &CallGroup| group.parameter().is_some_and(|(parameter, _)| parameter == name);
            if let Some(group) = CallGroup::SWITCHED.into_iter().find(is_its) {
                node.configure_introspection(group, Detail::from_value(value));
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright_msgs::builtin_interfaces::msg::Time;
    use camwright_msgs::rcl_interfaces::srv::{GetParametersResponse, ListParametersRequest};
    use camwright_msgs::std_srvs::srv::TriggerRequest;

    fn info() -> ServiceEventInfo {
        ServiceEventInfo {
            event_type: ServiceEventInfo::RESPONSE_SENT,
            stamp: Time { sec: 1, nanosec: 2 },
            client_gid: *b"0123456789abcdef",
            sequence_number: 7,
        }
    }

    /// The octets that rclpy writes for the same event.
    fn info_octets() -> Vec<u8> {
        let mut octets = vec![2, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0];
        octets.extend(b"0123456789abcdef");
        // The number stands at a multiple of eight.
        octets.extend([0, 0, 0, 0]);
        octets.extend(7_i64.to_le_bytes());
        assert_eq!(octets.len(), 40);
        octets
    }

    #[test]
    fn metadata_has_two_empty_sequences() {
        let body = to_cdr(&CallEvent { info: &info(), request: ABSENT, response: ABSENT }).expect("serialisable");
        assert_eq!(body[..40], info_octets());
        assert_eq!(body[40..], [0; 8]);
    }

    /// In a request the eight octets of a depth stand at 8, in the event at 56: four octets of padding where the request alone has none.
    #[test]
    fn a_request_is_aligned_within_the_event() {
        let request = ListParametersRequest { prefixes: vec![], depth: 9 };
        assert_eq!(to_cdr(&request).expect("serialisable").len(), 16);
        let event = CallEvent { info: &info(), request: &[request], response: ABSENT };
        let mut expected = info_octets();
        expected.extend([1, 0, 0, 0]); // one request
        expected.extend([0, 0, 0, 0]); // no prefixes; the depth follows at 48
        expected.extend(9_u64.to_le_bytes());
        expected.extend([0, 0, 0, 0]); // no response
        assert_eq!(to_cdr(&event).expect("serialisable"), expected);
    }

    #[test]
    fn an_empty_request_is_one_octet_and_the_next_length_is_aligned() {
        let event = CallEvent { info: &info(), request: &[TriggerRequest::default()], response: ABSENT };
        let mut expected = info_octets();
        expected.extend([1, 0, 0, 0, 0, 0, 0, 0]); // one request of one octet, then padding
        expected.extend([0, 0, 0, 0]);
        assert_eq!(to_cdr(&event).expect("serialisable"), expected);
    }

    #[test]
    fn a_response_follows_an_empty_request() {
        let event =
            CallEvent { info: &info(), request: ABSENT, response: &[GetParametersResponse { values: Vec::new() }] };
        let mut expected = info_octets();
        expected.extend([0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(to_cdr(&event).expect("serialisable"), expected);
    }

    #[test]
    fn every_value_of_a_parameter_is_a_detail() {
        let details = [Detail::Disabled, Detail::Metadata, Detail::Contents];
        for (name, detail) in Detail::NAMES.into_iter().zip(details) {
            assert_eq!(Detail::from_value(&ParameterValue::String(name.into())), detail);
            assert_eq!(Detail::from_number(detail as u8), detail);
        }
        for parameter in parameters() {
            let refused = parameter.check_given(ParameterValue::String("on".into()));
            assert_eq!(refused, Err("is 'on'; it must be one of disabled, metadata, contents".into()));
        }
    }
}
