// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Services: servers, deferred answers, and blocking clients.
//!
//! A service consists of two topics, as on the wire, because the crate's own services can neither carry an action's types nor report
//! whether the peer is matched. Requests and replies are related as in Fast DDS ("enhanced" mapping): a request carries the GUID of the
//! reader that waits for the reply, a reply carries that GUID and the number of the request. Peers on Cyclone use another mapping
//! ([`super::cyclone`]).

use std::{
    collections::BTreeMap,
    fmt,
    sync::{
        Arc, Mutex, OnceLock, PoisonError, Weak,
        atomic::{AtomicBool, Ordering},
        mpsc,
    },
    time::{Duration, Instant},
};

use camwright_msgs::Service;
use camwright_msgs::service_msgs::msg::ServiceEventInfo;
use rustdds::{GUID, RTPSEntity, SampleIdentity, SequenceNumber, Timestamp, WriteOptionsBuilder, bytes::Bytes, no_key};

use super::authority;
use super::cyclone::{self, Header};
use super::discovery::{Graph, GraphListener, Guid};
use super::error::RosError;
use super::executor::Executor;
use super::fastdds_workarounds::FastDdsWorkarounds;
use super::introspection::{CallEvents, CallGroup, CallId};
use super::load::Load;
use super::logging::Logger;
use super::loopback::LocalEndpoint;
use super::names::{self, NameKind};
use super::node::{Node, private};
use super::qos::Qos;
use super::reader_depth::DepthBounds;
use super::reply_pace::{ReplyPace, STEP};
use super::rtps_messages::Reply;
use super::sample_info::SampleInfo;
use super::topics::{OnBody, ReaderRequest, Subscription};
use super::wire::{CDR_LE_HEADER, RawBytes, to_cdr};

/// Longest time for which a reply waits for the discovery of its reader. Discovery of a client's two endpoints takes some ms;
/// a client that is not found by then has gone.
const REPLY_PATIENCE: Duration = Duration::from_secs(2);

/// Octets of a body up to which a sample goes in one datagram to any reader: an Ethernet frame holds 1372, a tunnel less.
const SHORT: usize = 1024;

/// Replies that may wait for the discovery of their readers, for each service.
const MAX_UNMATCHED: usize = 8192;

/// Vendor id of `RustDDS`, with which its GUIDs begin by RTPS.
const RUST_DDS: [u8; 2] = [0x01, 0x12];

/// Returns true for an endpoint of `RustDDS`.
fn is_rust_dds(endpoint: &GUID) -> bool {
    endpoint.to_bytes()[..2] == RUST_DDS
}

/// Returns true for a client that may keep no more than the ten unread replies of ROS's default. Clients of this crate keep at least 512.
fn keeps_few_replies(client: &GUID) -> bool {
    !is_rust_dds(client)
}

/// Writes requests or replies.
pub(super) struct Writer {
    dds: no_key::DataWriter<Bytes, RawBytes>,
    local: LocalEndpoint,
    beside: Arc<FastDdsWorkarounds>,
    /// Samples written, which is the number of the last one.
    written: Mutex<i64>,
}

impl Writer {
    pub(super) fn new(node: &Node, dds_name: &str, dds_type: &str, qos: &Qos) -> Result<Self, RosError> {
        let policies = node.writer_policies(qos);
        let topic = node.dds_topic(dds_name.to_string(), dds_type, &policies)?;
        let dds = node
            .with_participant(|participant| {
                participant.create_publisher(&policies)?.create_datawriter_no_key::<Bytes, RawBytes>(&topic, None)
            })?
            .map_err(|error| RosError::create(format!("writer of {dds_name}"), error))?;
        let local = node.loopback().add_writer(dds_name, dds_type, qos, dds.guid());
        Ok(Writer { dds, local, beside: Arc::clone(node.beside()), written: Mutex::new(0) })
    }

    pub(super) fn guid(&self) -> GUID {
        self.dds.guid()
    }

    /// Writes a request that is answered to a reader, in the manner of the server; returns its number.
    pub(super) fn request(&self, body: Bytes, answer_to: GUID, to_cyclone: bool) -> Result<i64, String> {
        let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        if to_cyclone {
            let header = Header { client: cyclone::client_of(&answer_to), number: *written + 1 };
            *written = self.write(&header.before(&body), None)?;
            self.local.write(None, None);
            return Ok(*written);
        }
        let client = self.client_of(body.len(), answer_to);
        *written = self.write(&body, (client == answer_to).then_some((client, UNKNOWN)))?;
        self.local.write(Some(body), Some((client, UNKNOWN)));
        Ok(*written)
    }

    /// Endpoint that the server takes for the client of a request. Samples in fragments cannot name anything; the answer to such a request
    /// goes to its writer.
    fn client_of(&self, body_length: usize, answer_to: GUID) -> GUID {
        if body_length <= SHORT { answer_to } else { self.guid() }
    }

    /// Writes the reply to a request.
    fn reply(&self, body: Bytes, to: RequestId) -> Result<(), String> {
        let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(header) = to.header {
            *written = self.write(&header.before(&body), None)?;
            self.local.write(None, None);
            return Ok(());
        }
        let related = (to.client, to.number);
        let named = body.len() <= SHORT;
        if !named {
            let payload = [&CDR_LE_HEADER, body.as_ref()].concat();
            let (writer, client) = (self.guid().to_bytes(), to.client.to_bytes());
            let number = *written + 1;
            self.beside.reply(&Reply { writer, number, client, request: to.number, payload: &payload });
        }
        *written = self.write(&body, named.then_some(related))?;
        self.local.write(Some(body), Some(related));
        Ok(())
    }

    fn write(&self, body: &Bytes, related: Option<(GUID, i64)>) -> Result<i64, String> {
        let mut options = WriteOptionsBuilder::new().source_timestamp(Timestamp::now());
        if let Some((writer_guid, number)) = related {
            let sequence_number = SequenceNumber::from(number);
            options = options.related_sample_identity(SampleIdentity { writer_guid, sequence_number });
        }
        let sent = self.dds.write_with_options(body.clone(), options.build()).map_err(|error| format!("{error:?}"))?;
        Ok(i64::from(sent.sequence_number))
    }
}

/// Request that a reply belongs to.
#[derive(Debug, Clone, Copy)]
struct RequestId {
    /// The reader that waits for the reply, or, with clients that do not say, the writer of the request.
    client: GUID,
    number: i64,
    /// Header that a client on Cyclone expects instead.
    header: Option<Header>,
}

impl RequestId {
    fn from_sample(info: &SampleInfo, header: Option<Header>) -> Self {
        match info.related {
            None => RequestId { client: info.writer, number: info.number, header },
            // Fast DDS leaves the number unknown here: it is that of the request itself.
            Some((client, number)) => {
                RequestId { client, number: if number > 0 { number } else { info.number }, header }
            }
        }
    }

    /// Identity of the call in the events of both sides. A client of rmw names the writer of its requests in its own events; a client of
    /// this crate names the endpoint that it gives to the server.
    fn call(&self, sender: &GUID) -> CallId {
        let client = if is_rust_dds(&self.client) { &self.client } else { sender };
        CallId::new(client, self.header.map_or(self.number, |header| header.number))
    }
}

struct PendingReply {
    id: RequestId,
    reply: Bytes,
    until: Instant,
}

struct ReplySide {
    writer: Writer,
    events: Arc<CallEvents>,
    service: String,
    graph: Arc<Graph>,
    executor: Weak<Executor>,
    logger: Logger,
    load: Arc<Load>,
    waiting: Mutex<Vec<PendingReply>>,
    pace: Mutex<ReplyPace<GUID, (RequestId, Bytes)>>,
    /// A look at the replies that wait for their turn is due.
    is_pacing: AtomicBool,
}

impl ReplySide {
    fn send(self: &Arc<Self>, id: RequestId, reply: Bytes) {
        // A reply to a reader that is not matched yet would be lost: the request has overtaken the reader's discovery.
        if self.is_matched(id) {
            self.write_in_turn(id, reply);
            return;
        }
        let until = Instant::now() + REPLY_PATIENCE;
        {
            let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
            if waiting.len() >= MAX_UNMATCHED {
                self.load.replies_undelivered.add_one();
                return;
            }
            waiting.push(PendingReply { id, reply, until });
        }
        // It may have been matched in between.
        self.retry();
        self.schedule_retry();
    }

    /// Tries again after a while, as long as a reply waits: a match is news, that it has lasted for a time is none.
    fn schedule_retry(self: &Arc<Self>) {
        let Some(executor) = self.executor.upgrade() else { return };
        let side = Arc::downgrade(self);
        let retry = move || {
            let Some(side) = side.upgrade() else { return };
            side.retry();
            if !side.waiting.lock().unwrap_or_else(PoisonError::into_inner).is_empty() {
                side.schedule_retry();
            }
        };
        executor.at(Instant::now() + cyclone::ACQUAINTANCE, Box::new(retry));
    }

    /// Registers a request: its client is busy sending.
    fn note_request(&self, id: RequestId) {
        if keeps_few_replies(&id.client) {
            self.pace.lock().unwrap_or_else(PoisonError::into_inner).request(id.client, Instant::now());
        }
    }

    /// Writes a reply at once, or when its turn comes.
    fn write_in_turn(self: &Arc<Self>, id: RequestId, reply: Bytes) {
        let now = Instant::now();
        let at_once = self.pace.lock().unwrap_or_else(PoisonError::into_inner).reply(id.client, (id, reply), now);
        match at_once {
            Some((id, reply)) => self.write(id, reply),
            None => self.check_pace(),
        }
    }

    /// Writes the replies whose turn has come, step by step, as long as any waits.
    fn check_pace(self: &Arc<Self>) {
        if self.is_pacing.swap(true, Ordering::AcqRel) {
            return;
        }
        let Some(executor) = self.executor.upgrade() else { return };
        let side = Arc::downgrade(self);
        let step = move || {
            let Some(side) = side.upgrade() else { return };
            side.is_pacing.store(false, Ordering::Release);
            let (due, waits) = {
                let mut pace = side.pace.lock().unwrap_or_else(PoisonError::into_inner);
                (pace.due(Instant::now()), pace.has_waiting())
            };
            for (id, reply) in due {
                side.write(id, reply);
            }
            if waits {
                side.check_pace();
            }
        };
        executor.at(Instant::now() + STEP, Box::new(step));
    }

    fn is_matched(&self, id: RequestId) -> bool {
        self.graph.ask(|matches| matches.is_matched_by_client(&self.writer.guid(), &id.client))
    }

    fn retry(self: &Arc<Self>) {
        let now = Instant::now();
        let due: Vec<PendingReply> = {
            let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
            let (due, still) =
                std::mem::take(&mut *waiting).into_iter().partition(|w| w.until <= now || self.is_matched(w.id));
            *waiting = still;
            due
        };
        for PendingReply { id, reply, .. } in due {
            if !self.is_matched(id) {
                self.load.replies_undelivered.add_one();
            }
            self.write_in_turn(id, reply);
        }
    }

    fn write(&self, id: RequestId, reply: Bytes) {
        if let Err(error) = self.writer.reply(reply, id) {
            self.load.replies_undelivered.add_one();
            self.logger.warn(&format!("reply of {} cannot be sent: {error}", self.service));
        }
    }
}

/// A service that is offered; dropping it withdraws it.
#[must_use = "dropping it withdraws the service"]
pub struct ServiceHandle {
    requests: Subscription,
    _on_match: GraphListener,
}

impl fmt::Debug for ServiceHandle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ServiceHandle").field("service", &self.requests.topic()).finish()
    }
}

impl ServiceHandle {
    /// Resolved name of the service.
    pub fn service(&self) -> &str {
        self.requests.topic()
    }
}

/// The right to answer one request, once, from any thread. If it is dropped, the client gets what [`Responder::or_fail`] says, or the
/// default answer: no success, no text.
pub struct Responder<S: Service> {
    side: Arc<ReplySide>,
    id: RequestId,
    sender: GUID,
    is_answered: bool,
    unanswered: Option<Unanswered<S>>,
}

/// Makes the answer to an unanswered request, from the reason.
type Unanswered<S> = Box<dyn Fn(String) -> <S as Service>::Response + Send + Sync>;

/// Text of the answer to a request that was dropped.
const NO_ANSWER: &str = "no answer is possible: the node is ending, or a defect ended one of its threads (its log and /diagnostics say which)";

impl<S: Service> Drop for Responder<S> {
    fn drop(&mut self) {
        if !self.is_answered {
            self.side.load.calls_refused.add_one();
            self.side.logger.debug(&format!("a call of {} was dropped without an answer", self.side.service));
            let failed = self.unanswered.take();
            self.answer(&failed.map_or_else(S::Response::default, |failed| failed(NO_ANSWER.into())));
        }
    }
}

impl<S: Service> fmt::Debug for Responder<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Responder").field("service", &self.side.service).finish_non_exhaustive()
    }
}

impl<S: Service> Responder<S> {
    /// GUID of an endpoint of the client.
    pub fn client(&self) -> Guid {
        self.id.client.to_bytes()
    }

    /// GUID of the writer that sent the request, whatever the request says of its client.
    pub fn sender(&self) -> Guid {
        self.sender.to_bytes()
    }

    pub fn send(mut self, response: &S::Response) {
        self.answer(response);
    }

    /// Sends the answer to a rejected call, and counts the rejection.
    pub fn refuse(self, response: &S::Response) {
        self.side.load.calls_refused.add_one();
        self.send(response);
    }

    fn answer(&mut self, response: &S::Response) {
        self.is_answered = true;
        self.reply(response);
    }

    /// Sets the answer that is sent if the responder is dropped; `failed` makes it from the reason.
    #[must_use]
    pub fn or_fail(mut self, failed: impl Fn(String) -> S::Response + Send + Sync + 'static) -> Self {
        self.unanswered = Some(Box::new(failed));
        self
    }

    fn reply(&self, response: &S::Response) {
        match to_cdr(response) {
            Ok(reply) => {
                self.side.send(self.id, reply);
                let call = self.id.call(&self.sender);
                self.side.events.response(ServiceEventInfo::RESPONSE_SENT, call, response);
            }
            Err(reason) => self.side.logger.warn(&format!("reply of {} cannot be sent: {reason}", self.side.service)),
        }
    }
}

impl Node {
    /// Offers a service; the callback runs on the executor thread and its return value is the answer.
    ///
    /// # Errors
    /// The name breaks the rules, or the node is shut down.
    pub fn service<S: Service>(
        &self,
        name: &str,
        callback: impl FnMut(S::Request) -> S::Response + Send + 'static,
    ) -> Result<ServiceHandle, RosError> {
        self.service_with::<S>(name, &Qos::services(), CallGroup::Services, callback)
    }

    /// Offers a service that every node has, in its private namespace.
    pub(super) fn builtin_service<S: Service>(
        &self,
        name: &str,
        qos: &Qos,
        callback: impl FnMut(S::Request) -> S::Response + Send + 'static,
    ) -> Result<ServiceHandle, RosError> {
        self.service_with::<S>(&private(name), qos, CallGroup::BuiltIn, callback)
    }

    pub(super) fn service_with<S: Service>(
        &self,
        name: &str,
        qos: &Qos,
        group: CallGroup,
        mut callback: impl FnMut(S::Request) -> S::Response + Send + 'static,
    ) -> Result<ServiceHandle, RosError> {
        self.service_deferred_with::<S>(name, qos, group, move |request, responder| responder.send(&callback(request)))
    }

    /// Offers a service whose answers may come later, from any thread.
    ///
    /// # Errors
    /// See [`Node::service`].
    pub fn service_deferred<S: Service>(
        &self,
        name: &str,
        callback: impl FnMut(S::Request, Responder<S>) + Send + 'static,
    ) -> Result<ServiceHandle, RosError> {
        self.service_deferred_with::<S>(name, &Qos::services(), CallGroup::Services, callback)
    }

    pub(super) fn service_deferred_with<S: Service>(
        &self,
        name: &str,
        qos: &Qos,
        group: CallGroup,
        mut callback: impl FnMut(S::Request, Responder<S>) + Send + 'static,
    ) -> Result<ServiceHandle, RosError> {
        let service = self.names().resolve(name, NameKind::Service)?;
        let (request_topic, reply_topic) = names::dds_service(&service);
        let side = Arc::new(ReplySide {
            writer: Writer::new(self, &reply_topic, S::DDS_RESPONSE_TYPE_NAME, qos)?,
            events: self.call_events(group, &service, S::TYPE_NAME)?,
            service: service.clone(),
            graph: Arc::clone(self.graph()),
            executor: Arc::downgrade(self.executor()),
            logger: self.logger().clone(),
            load: Arc::clone(self.load()),
            waiting: Mutex::default(),
            pace: Mutex::default(),
            is_pacing: AtomicBool::new(false),
        });
        let retrying = Arc::downgrade(&side);
        let on_match = self.graph().on_change(move || {
            if let Some(side) = retrying.upgrade() {
                side.retry();
            }
        });
        let weak = self.downgrade();
        let take: OnBody = Box::new(move |body, info| match cyclone::read::<S::Request>(&body, &info.writer) {
            Ok((header, request)) => {
                let id = RequestId::from_sample(info, header);
                side.events.request(ServiceEventInfo::REQUEST_RECEIVED, id.call(&info.writer), &request);
                side.note_request(id);
                let (sender, side) = (info.writer, Arc::clone(&side));
                let node = weak.upgrade();
                let reason = node.and_then(|node| node.refusal(&side.service, &request, &sender.to_bytes()));
                let responder = Responder { side, id, sender, is_answered: false, unanswered: None };
                match reason {
                    None => callback(request, responder),
                    Some(reason) => responder.refuse(&authority::refused::<S>(&request, &reason)),
                }
            }
            Err(reason) => {
                side.load.requests_unreadable.add_one();
                side.logger.debug(&format!("request to {} cannot be read: {reason}", side.service));
            }
        });
        let bounds = DepthBounds::for_service();
        let requests = self.growing_reader(
            ReaderRequest {
                name: &service,
                dds_name: request_topic,
                dds_type: S::DDS_REQUEST_TYPE_NAME,
                qos,
                delayable: false,
            },
            bounds,
            take,
        )?;
        Ok(ServiceHandle { requests, _on_match: on_match })
    }

    /// Calls a service. A long-lived client spares the server's discovery a race that costs Fast DDS peers up to 3 s.
    ///
    /// # Errors
    /// See [`Node::service`].
    pub fn client<S: Service>(&self, name: &str) -> Result<Client<S>, RosError> {
        self.client_with(name, CallGroup::Clients)
    }

    pub(super) fn client_with<S: Service>(&self, name: &str, group: CallGroup) -> Result<Client<S>, RosError> {
        let service = self.names().resolve(name, NameKind::Service)?;
        let (request_topic, reply_topic) = names::dds_service(&service);
        let qos = Qos::services();
        let pending: Arc<Pending<S>> = Arc::default();
        let answers = Arc::clone(&pending);
        let events = self.call_events(group, &service, S::TYPE_NAME)?;
        let received = Arc::clone(&events);
        let own = Arc::new(OnceLock::<[GUID; 2]>::new());
        let mine = Arc::clone(&own);
        let (logger, of) = (self.logger().clone(), service.clone());
        let take: OnBody = Box::new(move |body, info| {
            let Some(own) = mine.get() else { return };
            let read = cyclone::read::<S::Response>(&body, &info.writer);
            // Replies to all clients of the service arrive here.
            let call = match (&read, info.related) {
                (Ok((Some(header), _)), _) if header.client == cyclone::client_of(&own[0]) => {
                    CallId { client: header.client_gid(), number: header.number }
                }
                (_, Some((client, number))) if own.contains(&client) => CallId::new(&client, number),
                _ => return,
            };
            if let Ok((_, reply)) = &read {
                received.response(ServiceEventInfo::RESPONSE_RECEIVED, call, reply);
            }
            let waiter = answers.lock().unwrap_or_else(PoisonError::into_inner).remove(&call.number);
            match (read, waiter) {
                (Ok((_, reply)), Some(waiter)) => waiter(reply),
                (Err(reason), _) => logger.debug(&format!("reply of {of} cannot be read: {reason}")),
                (Ok(_), None) => {}
            }
        });
        let bounds = DepthBounds::for_service();
        let replies = self.growing_reader(
            ReaderRequest {
                name: &service,
                dds_name: reply_topic,
                dds_type: S::DDS_RESPONSE_TYPE_NAME,
                qos: &qos,
                delayable: false,
            },
            bounds,
            take,
        )?;
        let writer = Writer::new(self, &request_topic, S::DDS_REQUEST_TYPE_NAME, &qos)?;
        let _ = own.set([replies.dds_guid(), writer.guid()]);
        let (graph, executor) = (Arc::clone(self.graph()), Arc::downgrade(self.executor()));
        Ok(Client { core: Arc::new(ClientCore { writer, replies, pending, events, service, graph, executor }) })
    }
}

type Pending<S> = Mutex<BTreeMap<i64, Box<dyn FnOnce(<S as Service>::Response) + Send>>>;

struct ClientCore<S: Service> {
    writer: Writer,
    replies: Subscription,
    pending: Arc<Pending<S>>,
    events: Arc<CallEvents>,
    service: String,
    graph: Arc<Graph>,
    executor: Weak<Executor>,
}

/// A client of a service. Clones are the same client.
pub struct Client<S: Service> {
    core: Arc<ClientCore<S>>,
}

impl<S: Service> Clone for Client<S> {
    fn clone(&self) -> Self {
        Client { core: Arc::clone(&self.core) }
    }
}

impl<S: Service> fmt::Debug for Client<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Client").field("service", &self.core.service).finish_non_exhaustive()
    }
}

impl<S: Service> Client<S> {
    /// Resolved name of the service.
    pub fn service(&self) -> &str {
        &self.core.service
    }

    /// Returns true while all known servers are matched for requests and for replies.
    pub fn is_ready(&self) -> bool {
        let (requests, replies) = (self.core.writer.guid(), self.core.replies.dds_guid());
        self.core.graph.ask(|matches| matches.is_service_matched(&requests, &replies))
    }

    /// Waits until a server is matched. The node must spin on another thread.
    ///
    /// # Errors
    /// None appears in time, or the caller is a callback of the same node.
    pub fn wait_for_service(&self, timeout: Duration) -> Result<(), RosError> {
        self.refuse_on_executor()?;
        let (requests, replies) = (self.core.writer.guid(), self.core.replies.dds_guid());
        if self.core.graph.wait_until(timeout, |matches| matches.is_service_matched(&requests, &replies)) {
            Ok(())
        } else {
            Err(RosError::timeout(format!("service {} is not there", self.core.service), timeout))
        }
    }

    /// Waits until so many servers are matched, those that were killed and are not forgotten yet included; `false` after the timeout. The
    /// node must spin on another thread.
    pub fn wait_matched(&self, count: usize, timeout: Duration) -> bool {
        let (requests, replies) = (self.core.writer.guid(), self.core.replies.dds_guid());
        self.core.graph.wait_until(timeout, |matches| matches.count(&requests).min(matches.count(&replies)) >= count)
    }

    fn refuse_on_executor(&self) -> Result<(), RosError> {
        match self.core.executor.upgrade() {
            Some(executor) if executor.is_current_thread() => {
                Err(RosError::WouldDeadlock { what: format!("service {}", self.core.service) })
            }
            _ => Ok(()),
        }
    }

    /// Sends a request and returns its number; the answer goes to `answer`, on the executor thread. May be called from callbacks.
    ///
    /// # Errors
    /// The request cannot be sent.
    pub fn call_with(
        &self,
        request: &S::Request,
        answer: impl FnOnce(S::Response) + Send + 'static,
    ) -> Result<i64, RosError> {
        let failed = |reason: String| RosError::publish(&self.core.service, reason);
        let body = to_cdr(request).map_err(failed)?;
        // Locked over the write: the answer may be here before the number is.
        let mut pending = self.core.pending.lock().unwrap_or_else(PoisonError::into_inner);
        // The server answers to the reader named here, and (Fast DDS) waits until it has found it.
        let (requests, replies) = (self.core.writer.guid(), self.core.replies.dds_guid());
        let server = self.core.graph.ask(|matches| matches.one_peer_for_both(&requests, &replies));
        let to_cyclone = server.is_some_and(|server| cyclone::is_cyclone(&server));
        let body_length = body.len();
        let number = self.core.writer.request(body, replies, to_cyclone).map_err(failed)?;
        pending.insert(number, Box::new(answer));
        let call = if to_cyclone {
            CallId { client: Header { client: cyclone::client_of(&replies), number }.client_gid(), number }
        } else {
            CallId::new(&self.core.writer.client_of(body_length, replies), number)
        };
        self.core.events.request(ServiceEventInfo::REQUEST_SENT, call, request);
        Ok(number)
    }

    /// Stops waiting for an answer.
    pub fn forget(&self, number: i64) {
        self.core.pending.lock().unwrap_or_else(PoisonError::into_inner).remove(&number);
    }

    /// Waits for a server, sends a request and waits for the answer.
    ///
    /// # Errors
    /// No server appears or answers in time, the request cannot be sent, or the caller is a callback of the same node.
    pub fn call(&self, request: &S::Request, timeout: Duration) -> Result<S::Response, RosError> {
        let begin = Instant::now();
        self.wait_for_service(timeout)?;
        let (sender, receiver) = mpsc::sync_channel(1);
        let number = self.call_with(request, move |reply| drop(sender.send(reply)))?;
        receiver.recv_timeout(timeout.saturating_sub(begin.elapsed())).map_err(|_| {
            self.forget(number);
            RosError::timeout(format!("service {}", self.core.service), timeout)
        })
    }
}

/// RTPS's "unknown" sequence number: the server takes that of the request.
const UNKNOWN: i64 = -(1 << 32);

#[cfg(test)]
mod tests {
    use super::cyclone::tests::guid;
    use super::*;

    /// In events of a call both sides name the client in the same way.
    #[test]
    fn a_call_has_the_identity_that_its_client_gives_it() {
        let (reader, writer) = (4, 3);
        let fast_dds = |last| guid([0x01, 0x0f], last);
        let rust_dds = |last| guid(RUST_DDS, last);
        let cyclone = |last| guid([0x01, 0x10], last);
        let id = |client, header| RequestId { client, number: 5, header };
        let call = id(fast_dds(reader), None).call(&fast_dds(writer));
        assert_eq!(call, CallId::new(&fast_dds(writer), 5), "rmw_fastrtps names the writer of its requests");
        let call = id(rust_dds(reader), None).call(&rust_dds(writer));
        assert_eq!(call, CallId::new(&rust_dds(reader), 5), "servers on Fast DDS name the reader of the replies");
        let header = Header { client: 0x0102, number: 9 };
        let call = id(cyclone(writer), Some(header)).call(&cyclone(writer));
        assert_eq!(call, CallId::new(&cyclone(writer), 9), "rmw_cyclonedds counts its requests in the header");
        assert_eq!(header.client_gid(), [2, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    }
}
