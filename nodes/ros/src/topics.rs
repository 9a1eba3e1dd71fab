// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Publishers and subscriptions, typed and untyped.

use camwright_threads::system_time::system_time_ns;
use std::{
    collections::BTreeMap,
    fmt,
    marker::PhantomData,
    pin::pin,
    sync::{Arc, Mutex, PoisonError, Weak},
    task::{Context, Poll, Waker},
    time::{Duration, Instant},
};

use camwright_msgs::Message;
use futures::Stream;
use rustdds::{GUID, QosPolicies, bytes::Bytes, policy::Reliability};
use serde::de::DeserializeOwned;

use super::{
    delay::DelaySource,
    discovery::{Graph, Guid},
    error::RosError,
    executor::{Executor, SourceHandle},
    loopback::{LocalEndpoint, Unread},
    names::{self, NameKind},
    node::Node,
    qos::{Durability, Qos},
    reader_depth::{DepthBounds, ReaderDepth},
    sample_info::SampleInfo,
    wire::{CDR_LE_HEADER, Octets, from_cdr, to_cdr},
};

/// Origin and times of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MessageInfo {
    /// GUID of the publisher.
    pub writer: Guid,
    /// Time of publication, in ns since 1970 by the publisher's clock; `None`: not stated.
    pub source_timestamp_ns: Option<i64>,
    /// Time of reception by this process, in ns since 1970.
    pub reception_timestamp_ns: i64,
    /// Number of the message among those of its publisher, from 1. A jump is a loss.
    pub sequence_number: i64,
}

impl From<&SampleInfo> for MessageInfo {
    fn from(info: &SampleInfo) -> Self {
        MessageInfo {
            writer: info.writer.to_bytes(),
            source_timestamp_ns: info.source_ns,
            reception_timestamp_ns: info.received_ns,
            sequence_number: info.number,
        }
    }
}

/// Publishes messages of one type on one topic, from any thread. Clones are the same publisher; it lasts as long as one of them.
pub struct Publisher<M> {
    raw: RawPublisher,
    /// Zero octets after the fields of a message.
    trailing_zeros: usize,
    message: PhantomData<fn(M)>,
}

impl<M> Clone for Publisher<M> {
    fn clone(&self) -> Self {
        Publisher { raw: self.raw.clone(), trailing_zeros: self.trailing_zeros, message: PhantomData }
    }
}

impl<M> fmt::Debug for Publisher<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Publisher").field("topic", &self.raw.core.topic).finish_non_exhaustive()
    }
}

impl<M> Publisher<M> {
    /// Resolved name of the topic.
    pub fn topic(&self) -> &str {
        self.raw.topic()
    }

    pub fn guid(&self) -> Guid {
        self.raw.core.guid.to_bytes()
    }

    /// Number of matched subscriptions.
    pub fn matched(&self) -> usize {
        self.raw.matched()
    }

    /// Waits until so many subscriptions are matched; `false` after the timeout. The node must spin on another thread.
    pub fn wait_matched(&self, count: usize, timeout: Duration) -> bool {
        self.raw.wait_matched(count, timeout)
    }
}

impl<M: Message> Publisher<M> {
    /// Publishes a message.
    ///
    /// # Errors
    /// A text or sequence is longer than its type allows, or the writer is full because a peer does not acknowledge.
    pub fn publish(&self, message: &M) -> Result<(), RosError> {
        message.check_bounds().map_err(|error| RosError::publish(self.topic(), error))?;
        let mut body = Vec::from(to_cdr(message).map_err(|error| RosError::publish(self.topic(), error))?);
        body.resize(body.len() + self.trailing_zeros, 0);
        self.raw.send(body)
    }

    /// Appends zero octets to every message, for subscribers whose definition of the type has more fields. Others ignore them.
    pub(super) fn with_trailing_zeros(self, octets: usize) -> Self {
        Publisher { trailing_zeros: octets, ..self }
    }
}

/// Publishes messages that are serialised already, as a bag holds them.
///
/// The DDS writer carries octets for every type, so that the compiler builds it once.
#[derive(Clone)]
pub struct RawPublisher {
    core: Arc<PublisherCore>,
}

struct PublisherCore {
    writer: ros2_client::Publisher<Octets>,
    local: LocalEndpoint,
    guid: GUID,
    topic: String,
    graph: Arc<Graph>,
    durability: Durability,
    /// Maximum time to wait for room.
    max_blocking: Duration,
}

impl fmt::Debug for RawPublisher {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RawPublisher").field("topic", &self.core.topic).finish_non_exhaustive()
    }
}

impl RawPublisher {
    /// Publishes a message: CDR with its 4-byte encapsulation header.
    ///
    /// # Errors
    /// The message is not little-endian CDR; otherwise see [`Publisher::publish`].
    pub fn publish(&self, cdr: &[u8]) -> Result<(), RosError> {
        match cdr.split_at_checked(4) {
            Some((header, body)) if header[..2] == CDR_LE_HEADER[..2] => self.send(body.to_vec()),
            _ => Err(RosError::publish(self.topic(), "the message is not little-endian CDR with its header")),
        }
    }

    /// Publishes the body of a message.
    pub(super) fn send(&self, body: Vec<u8>) -> Result<(), RosError> {
        let PublisherCore { writer, local, topic, durability, max_blocking, .. } = &*self.core;
        if !local.wait_room(*max_blocking) {
            return Err(RosError::Congested { topic: topic.clone() });
        }
        if !local.needs_dds(*durability) {
            local.write(Some(body.into()), None);
            return Ok(());
        }
        let local_body = local.wants_bodies().then(|| Bytes::copy_from_slice(&body));
        writer.publish(Octets(body)).map_err(|error| match error {
            ros2_client::error::WriteError::WouldBlock { .. } => RosError::Congested { topic: topic.clone() },
            error => RosError::publish(topic, error.to_string()),
        })?;
        local.write(local_body, None);
        Ok(())
    }

    /// Resolved name of the topic.
    pub fn topic(&self) -> &str {
        &self.core.topic
    }

    /// Number of matched subscriptions.
    pub fn matched(&self) -> usize {
        self.core.graph.ask(|matches| matches.count(&self.core.guid))
    }

    /// Waits until so many subscriptions are matched; `false` after the timeout. The node must spin on another thread.
    pub fn wait_matched(&self, count: usize, timeout: Duration) -> bool {
        self.core.graph.wait_until(timeout, |matches| matches.count(&self.core.guid) >= count)
    }

    /// The same for messages of one type, which is that of the topic.
    pub(super) fn typed<M: Message>(self) -> Publisher<M> {
        Publisher { raw: self, trailing_zeros: 0, message: PhantomData }
    }
}

/// A subscription; dropping it ends it.
#[must_use = "dropping it ends the subscription"]
pub struct Subscription {
    _source: SourceHandle,
    _local: Arc<LocalEndpoint>,
    guid: GUID,
    topic: String,
    graph: Arc<Graph>,
}

impl fmt::Debug for Subscription {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Subscription").field("topic", &self.topic).finish_non_exhaustive()
    }
}

impl Subscription {
    /// Resolved name of the topic.
    pub fn topic(&self) -> &str {
        &self.topic
    }

    /// Number of matched publishers.
    pub fn matched(&self) -> usize {
        self.graph.ask(|matches| matches.count(&self.guid))
    }

    /// Waits until so many publishers are matched; `false` after the timeout. The node must spin on another thread.
    pub fn wait_matched(&self, count: usize, timeout: Duration) -> bool {
        self.graph.wait_until(timeout, |matches| matches.count(&self.guid) >= count)
    }
}

/// Topic and policies of a new reader.
#[derive(Debug, Clone)]
pub(super) struct ReaderRequest<'a> {
    /// Resolved name for messages to the user.
    pub(super) name: &'a str,
    /// Name of the DDS topic.
    pub(super) dds_name: String,
    /// DDS name of the type.
    pub(super) dds_type: &'a str,
    pub(super) qos: &'a Qos,
    /// Subject to injected delays: topics, not services or the clock.
    pub(super) delayable: bool,
}

impl Node {
    /// Publishes messages of type `M` on a topic (relative, `~/private` or absolute).
    ///
    /// # Errors
    /// The name breaks the rules, or the node is shut down.
    pub fn publisher<M: Message>(&self, topic: &str, qos: &Qos) -> Result<Publisher<M>, RosError> {
        let publisher = self.publisher_with(topic, M::DDS_TYPE_NAME, qos, &self.writer_policies(qos))?;
        Ok(publisher.typed())
    }

    /// Publishes serialised messages of the type with the ROS name `type_name` (`pkg/msg/Type`).
    ///
    /// # Errors
    /// The type's name is malformed; otherwise see [`Node::publisher`].
    pub fn raw_publisher(&self, topic: &str, type_name: &str, qos: &Qos) -> Result<RawPublisher, RosError> {
        self.publisher_with(topic, &dds_type(type_name)?, qos, &self.writer_policies(qos))
    }

    /// Publishes serialised messages of a type, and never waits for room.
    pub(super) fn impatient_raw_publisher(
        &self,
        topic: &str,
        type_name: &str,
        qos: &Qos,
    ) -> Result<RawPublisher, RosError> {
        self.publisher_with(topic, &dds_type(type_name)?, qos, &qos.impatient_writer_policies())
    }

    /// Publishes with policies of its own, of which peers see no more than of `qos`.
    pub(super) fn publisher_with(
        &self,
        topic: &str,
        dds_type: &str,
        qos: &Qos,
        policies: &QosPolicies,
    ) -> Result<RawPublisher, RosError> {
        let absolute = self.names().resolve(topic, NameKind::Topic)?;
        let dds_topic = self.dds_topic(names::dds_topic(&absolute), dds_type, policies)?;
        let writer = self
            .with_crate_node(|node| node.create_publisher::<Octets>(&dds_topic, None))?
            .map_err(|error| RosError::create(format!("publisher on {absolute}"), error))?;
        let guid = writer.guid();
        let local = self.loopback().add_writer(&names::dds_topic(&absolute), dds_type, qos, guid);
        let (graph, durability) = (Arc::clone(self.graph()), qos.durability);
        let max_blocking = match policies.reliability() {
            Some(Reliability::Reliable { max_blocking_time }) => max_blocking_time.into(),
            _ => Duration::ZERO,
        };
        let core = PublisherCore { writer, local, guid, topic: absolute, graph, durability, max_blocking };
        Ok(RawPublisher { core: Arc::new(core) })
    }

    /// Subscribes to messages of type `M`; the callback runs on the executor thread.
    ///
    /// # Errors
    /// The name breaks the rules, or the node is shut down.
    pub fn subscribe<M: Message>(
        &self,
        topic: &str,
        qos: &Qos,
        mut callback: impl FnMut(M, &MessageInfo) + Send + 'static,
    ) -> Result<Subscription, RosError> {
        let absolute = self.names().resolve(topic, NameKind::Topic)?;
        let take = move |message, info: &SampleInfo| callback(message, &MessageInfo::from(info));
        let (dds_name, dds_type) = (names::dds_topic(&absolute), M::DDS_TYPE_NAME);
        self.reader(ReaderRequest { name: &absolute, dds_name, dds_type, qos, delayable: true }, take)
    }

    /// Subscribes to serialised messages of the type with the ROS name `type_name`; the callback gets little-endian CDR with its
    /// 4-byte encapsulation header. (The body of a big-endian peer would arrive as it is; no ROS 2 system sends such.)
    ///
    /// # Errors
    /// The type's name is malformed; otherwise see [`Node::subscribe`].
    pub fn subscribe_raw(
        &self,
        topic: &str,
        type_name: &str,
        qos: &Qos,
        callback: impl FnMut(&[u8], &MessageInfo) + Send + 'static,
    ) -> Result<Subscription, RosError> {
        self.subscribe_raw_bounded(topic, type_name, qos, None, callback)
    }

    /// Same as [`Node::subscribe_raw`], with an upper bound for the memory of read messages: the depth of `qos` is the maximum, and
    /// large messages get less, so that no more than about `budget_bytes` are held. `history` messages may arrive at once at the
    /// beginning.
    ///
    /// # Errors
    /// See [`Node::subscribe_raw`].
    pub fn subscribe_raw_within(
        &self,
        topic: &str,
        type_name: &str,
        qos: &Qos,
        history: u32,
        budget_bytes: usize,
        callback: impl FnMut(&[u8], &MessageInfo) + Send + 'static,
    ) -> Result<Subscription, RosError> {
        let bounds = DepthBounds::for_topic(qos, history, budget_bytes);
        self.subscribe_raw_bounded(topic, type_name, qos, Some(bounds), callback)
    }

    fn subscribe_raw_bounded(
        &self,
        topic: &str,
        type_name: &str,
        qos: &Qos,
        bounds: Option<DepthBounds>,
        mut callback: impl FnMut(&[u8], &MessageInfo) + Send + 'static,
    ) -> Result<Subscription, RosError> {
        let absolute = self.names().resolve(topic, NameKind::Topic)?;
        let dds_type = dds_type(type_name)?;
        let mut cdr = Vec::with_capacity(256);
        let take: OnBody = Box::new(move |body, info| {
            cdr.clear();
            cdr.extend_from_slice(&CDR_LE_HEADER);
            cdr.extend_from_slice(&body.0);
            callback(&cdr, &MessageInfo::from(info));
        });
        let dds_name = names::dds_topic(&absolute);
        let request = ReaderRequest { name: &absolute, dds_name, dds_type: &dds_type, qos, delayable: true };
        match bounds {
            None => self.body_reader(request, take),
            Some(bounds) => self.growing_reader(request, bounds, take),
        }
    }

    /// A reader of samples on a DDS topic.
    pub(super) fn reader<D: DeserializeOwned>(
        &self,
        request: ReaderRequest<'_>,
        mut callback: impl FnMut(D, &SampleInfo) + Send + 'static,
    ) -> Result<Subscription, RosError> {
        let (topic, logger) = (request.name.to_string(), self.logger().clone());
        let take: OnBody = Box::new(move |body, info| match from_cdr::<D>(&body.0) {
            Ok(message) => callback(message, info),
            Err(error) => logger.debug(&format!("message on {topic} cannot be read: {error}")),
        });
        self.body_reader(request, take)
    }

    /// A reader of serialised samples whose cache has the depth of `qos`.
    fn body_reader(&self, request: ReaderRequest<'_>, take: OnBody) -> Result<Subscription, RosError> {
        let policies = request.qos.reader_policies();
        self.reader_with(request, &policies, None, take)
    }

    /// A reader of serialised samples whose cache grows within bounds.
    pub(super) fn growing_reader(
        &self,
        request: ReaderRequest<'_>,
        bounds: DepthBounds,
        take: OnBody,
    ) -> Result<Subscription, RosError> {
        let policies = request.qos.reader_policies_of_depth(bounds.initial);
        let depth = ReaderDepth::new(self, &request.dds_name, request.dds_type, request.qos, bounds);
        self.reader_with(request, &policies, Some(depth), take)
    }

    /// A reader; `depth` sees each sample as it comes from the network, ours included.
    ///
    /// DDS readers carry octets for every type, so that the compiler builds them once.
    fn reader_with(
        &self,
        request: ReaderRequest<'_>,
        policies: &QosPolicies,
        mut depth: Option<ReaderDepth>,
        take: OnBody,
    ) -> Result<Subscription, RosError> {
        let ReaderRequest { name, dds_name, dds_type, qos, delayable } = request;
        let dds_topic = self.dds_topic(dds_name.clone(), dds_type, policies)?;
        let mut earlier = EarlierMessages::than_now(qos.durability);
        let reader = self
            .with_crate_node(|node| node.create_subscription::<Octets>(&dds_topic, None))?
            .map_err(|error| RosError::create(format!("subscription to {name}"), error))?;
        let guid = reader.guid();
        let delivery = Arc::new(Mutex::new(Delivery::new(self, delayable, take)));
        let (executor, for_local) = (Arc::downgrade(self.executor()), Arc::clone(&delivery));
        let deliver_local = Box::new(move |body: Bytes, info: SampleInfo, unread: Unread| {
            let (Some(executor), delivery) = (executor.upgrade(), Arc::clone(&for_local)) else { return };
            executor.post(Box::new(move || {
                delivery.lock().unwrap_or_else(PoisonError::into_inner).deliver(Octets(body.into()), info);
                drop(unread);
            }));
        });
        let local = Arc::new(self.loopback().add_reader(&dds_name, dds_type, qos, guid, deliver_local));
        let (topic, logger, here) = (name.to_string(), self.logger().clone(), Arc::clone(&local));
        let mut types =
            WriterTypes { graph: Arc::clone(self.graph()), dds_type: dds_type.to_string(), fitting: BTreeMap::new() };
        let source = self
            .executor()
            .add_source(reader, |reader| {
                Box::new(move |budget| {
                    // Taking empties the reader's doorbell each time, two system calls; for what came with the first that is done once.
                    let mut first = Some(reader.take());
                    let mut rest = pin!(reader.async_stream());
                    for _ in 0..budget {
                        let next = match first.take() {
                            Some(first) => first.transpose(),
                            None => match rest.as_mut().poll_next(&mut Context::from_waker(Waker::noop())) {
                                Poll::Ready(next) => next,
                                Poll::Pending => None,
                            },
                        };
                        match next {
                            Some(Ok((body, info))) => {
                                let info = SampleInfo::from(&info);
                                if let Some(depth) = &mut depth {
                                    depth.observe(body.0.len(), info.received_ns);
                                }
                                if !here.delivers_from(&info.writer) && types.fit(&info.writer) && !earlier.has(&info) {
                                    delivery.lock().unwrap_or_else(PoisonError::into_inner).deliver(body, info);
                                }
                            }
                            None => return false,
                            Some(Err(error)) => logger.debug(&format!("message on {topic} cannot be read: {error}")),
                        }
                    }
                    true
                })
            })
            .map_err(|error| RosError::create(format!("subscription to {name}"), error))?;
        let graph = Arc::clone(self.graph());
        Ok(Subscription { _source: source, _local: local, guid, topic: name.to_string(), graph })
    }
}

impl Subscription {
    pub(super) fn dds_guid(&self) -> GUID {
        self.guid
    }
}

fn dds_type(ros: &str) -> Result<String, RosError> {
    names::dds_type(ros)
        .ok_or_else(|| RosError::create(format!("topic of type '{ros}'"), "a type is named package/msg/Name"))
}

/// `RustDDS` hands a new reader what its participant has received on the topic already; of a volatile one that is no news.
struct EarlierMessages {
    /// When the reader was made, by the clock that stamps what is received (ns since 1970), and by one that never jumps.
    ns: i64,
    made: Instant,
    is_over: bool,
}

impl EarlierMessages {
    /// Maximum time for a reader to read earlier messages; a clock that was set back must not make it deaf for longer.
    const MAX_WAIT: Duration = Duration::from_secs(1);

    fn than_now(durability: Durability) -> Self {
        Self { ns: system_time_ns(), made: Instant::now(), is_over: durability != Durability::Volatile }
    }

    fn has(&mut self, info: &SampleInfo) -> bool {
        self.is_over |= info.received_ns >= self.ns || self.made.elapsed() > Self::MAX_WAIT;
        !self.is_over
    }
}

/// Keeps apart writers of another type on the same topic, whose messages `RustDDS` delivers too: some of them can even be read.
struct WriterTypes {
    graph: Arc<Graph>,
    dds_type: String,
    fitting: BTreeMap<GUID, bool>,
}

impl WriterTypes {
    fn fit(&mut self, writer: &GUID) -> bool {
        if let Some(fits) = self.fitting.get(writer) {
            return *fits;
        }
        match self.graph.has_type(writer, &self.dds_type) {
            Some(fits) => {
                self.fitting.insert(*writer, fits);
                fits
            }
            // Its message has overtaken the news of it.
            None => true,
        }
    }
}

/// Callback with the body of each sample of a reader.
pub(super) type OnBody = Box<dyn FnMut(Octets, &SampleInfo) + Send>;

/// Hands samples to a callback, at once or, in a test of determinism, after a random delay that never reorders a topic.
struct Delivery {
    callback: Arc<Mutex<OnBody>>,
    delay: Option<(DelaySource, Weak<Executor>)>,
    last_due: Instant,
}

impl Delivery {
    fn new(node: &Node, delayable: bool, callback: OnBody) -> Self {
        Delivery {
            callback: Arc::new(Mutex::new(callback)),
            delay: node.delay_source().filter(|_| delayable).map(|source| (source, Arc::downgrade(node.executor()))),
            last_due: Instant::now(),
        }
    }

    fn deliver(&mut self, body: Octets, info: SampleInfo) {
        let Some((source, executor)) = &mut self.delay else {
            (self.callback.lock().unwrap_or_else(PoisonError::into_inner))(body, &info);
            return;
        };
        let Some(executor) = executor.upgrade() else { return };
        self.last_due = self.last_due.max(Instant::now() + source.next());
        let callback = Arc::clone(&self.callback);
        executor.at(
            self.last_due,
            Box::new(move || (callback.lock().unwrap_or_else(PoisonError::into_inner))(body, &info)),
        );
    }
}
