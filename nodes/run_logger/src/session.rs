// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! One recording of the graph: who is subscribed to, and what becomes of what arrives.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use camwright_msgs::camwright_msgs::msg::{Alarm, MachineAlarms, RecorderStatus, TopicRecord};
use camwright_msgs::rosbag2_interfaces::msg::{MessagesLostEvent, WriteSplitEvent};

use super::arrivals::{Arrivals, TopicArrival};
use super::definitions::{DefinitionState, DefinitionText, Definitions};
use super::losses::PublishedLosses;
use super::selection::{Selection, is_message_type, is_service_event, recorded_qos, subscription_qos};
use super::settings::RecorderSettings;
use super::ticks::TickWatch;
use camwright_bag::recording::{RecordedTopic, RecordingOptions};
use camwright_bag::{BagError, BagMetadata, Counts, Recording, RecordingOutcome, Topic};
use camwright_ros::{Durability, MessageInfo, Node, Publisher, Qos, RosError, Subscription, TopicInfo};

/// Most that waits for the first `/clock` (B); what comes then is stamped with its time of receipt.
const HELD_BYTES: usize = 64 << 20;

/// Memory for messages of one topic that were read already (B): the middleware frees a message when newer ones push it out.
const READ_BYTES: usize = 16 << 20;

/// Subscriptions made before those that exist get their turn: a fast topic must not wait until all are made.
const SUBSCRIBED_AT_ONCE: usize = 4;
/// Shortest time between two events of lost messages, as in rosbag2.
const LOSS_INTERVAL: Duration = Duration::from_secs(1);
/// Longest time between two status messages.
const STATUS_INTERVAL: Duration = Duration::from_millis(250);

/// Meaning of a topic for the recorder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TopicRole {
    JointStates,
    Stream,
    Other,
}

/// A topic that is subscribed to.
struct TopicSubscription {
    type_name: String,
    subscription: Subscription,
    /// A publisher matched once; from then on it is shown in the status.
    was_matched: bool,
}

#[derive(Default)]
struct Topics {
    entries: BTreeMap<String, TopicSubscription>,
    /// Topic and type of what is not recorded, so that it is said once.
    refused: BTreeSet<(String, String)>,
}

/// A message that waits for `/clock`.
struct HeldMessage {
    topic: RecordedTopic,
    publish_ns: u64,
    reception_ns: u64,
    data: Vec<u8>,
}

/// Last tick of the machine's joint states in the bag, and last published progress.
#[derive(Default)]
struct Progress {
    watch: TickWatch,
    reported_tick: u64,
    reported_at: Option<Instant>,
}

/// Publishers of a recording's status.
#[derive(Clone)]
pub(super) struct RecorderOutlets {
    pub(super) status: Publisher<RecorderStatus>,
    pub(super) splits: Publisher<WriteSplitEvent>,
    pub(super) losses: Publisher<MessagesLostEvent>,
}

/// Alarms that have been seen, where a new one asks for a snapshot.
#[derive(Default)]
struct Alarms {
    subscription: Option<Subscription>,
    numbers: Vec<u16>,
    /// When the snapshot is due.
    due: Option<Instant>,
}

/// A recording of the graph, from activation to deactivation. Callbacks hold it weakly: dropping it ends them.
pub(super) struct Session {
    node: Node,
    settings: RecorderSettings,
    selection: Selection,
    recording: Recording,
    is_paused: AtomicBool,
    is_stopped: AtomicBool,
    /// New topics are subscribed to.
    is_discovering: AtomicBool,
    /// Guard the fields below against each other's threads; all callbacks run on the executor's, so waits are short.
    topics: Mutex<Topics>,
    progress: Mutex<Progress>,
    held: Mutex<Vec<HeldMessage>>,
    definitions: Mutex<Definitions>,
    alarms: Mutex<Alarms>,
    /// Published losses, and the time of the last event.
    losses: Mutex<(PublishedLosses, Instant)>,
    outlets: RecorderOutlets,
    joint_states: String,
    stream: String,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn unsigned(ns: i64) -> u64 {
    u64::try_from(ns).unwrap_or(0)
}

impl Session {
    /// Opens the bag. Nothing is subscribed to before [`Session::refresh`].
    pub(super) fn start(
        node: &Node,
        settings: RecorderSettings,
        outlets: RecorderOutlets,
    ) -> Result<Arc<Self>, SessionError> {
        let joint_states = node.resolve_topic("joint_states")?;
        let stream = node.resolve_topic("machine/stream")?;
        let supervisor = node.supervisor().clone();
        let options = RecordingOptions { supervisor, ..settings.recording.clone() };
        let recording = Recording::start(&settings.bag_dir, &options)?;
        let session = Arc::new(Self {
            node: node.clone(),
            selection: Selection::new(node.namespace(), settings.include.clone(), settings.exclude.clone()),
            is_paused: AtomicBool::new(settings.start_paused),
            is_stopped: AtomicBool::new(false),
            is_discovering: AtomicBool::new(true),
            settings,
            recording,
            topics: Mutex::default(),
            progress: Mutex::default(),
            held: Mutex::default(),
            definitions: Mutex::default(),
            alarms: Mutex::default(),
            losses: Mutex::new((PublishedLosses::default(), Instant::now())),
            outlets,
            joint_states,
            stream,
        });
        if session.settings.recording.snapshot.is_some() {
            let weak = Arc::downgrade(&session);
            let subscription = node.subscribe("machine/alarms", &Qos::latched(1), move |message, _| {
                if let Some(session) = weak.upgrade() {
                    session.see_alarms(&message);
                }
            })?;
            lock(&session.alarms).subscription = Some(subscription);
        }
        Ok(session)
    }

    pub(super) fn bag(&self) -> &Path {
        self.recording.directory()
    }

    /// Why the recording cannot go on, when it cannot.
    pub(super) fn fault(&self) -> Option<&str> {
        self.recording.fault()
    }

    /// Received, written and lost messages.
    pub(super) fn counts(&self) -> Counts {
        self.recording.counts()
    }

    /// Most bytes that wait for the disk.
    pub(super) fn queue_bytes(&self) -> u64 {
        self.settings.recording.queue_bytes
    }

    /// Writes the buffered messages; `answer` receives whether buffering is active.
    pub(super) fn snapshot(&self, answer: impl FnOnce(bool) + Send + 'static) {
        if self.settings.recording.snapshot.is_some() {
            self.recording.snapshot(move |_| answer(true));
        } else {
            let reason = "this recording writes all; parameter snapshot_s makes one of snapshots";
            self.node.logger().warn(&format!("no snapshot: {reason}"));
            answer(false);
        }
    }

    /// Continues in the next file; `answer` receives whether it does.
    pub(super) fn split(&self, answer: impl FnOnce(bool) + Send + 'static) {
        self.recording.split(answer);
    }

    /// A new alarm that stops the machine asks for a snapshot, once it has been seen how it came to rest.
    fn see_alarms(&self, message: &MachineAlarms) {
        let mut alarms = lock(&self.alarms);
        let stopping = message.alarms.iter().filter(|alarm| alarm.severity > Alarm::WARNING).map(|alarm| alarm.number);
        let numbers: Vec<u16> = stopping.collect();
        if numbers.iter().any(|number| !alarms.numbers.contains(number)) && alarms.due.is_none() {
            alarms.due = Some(Instant::now() + self.settings.snapshot_delay);
        }
        alarms.numbers = numbers;
    }

    /// Takes a due snapshot, and reports new files and lost messages.
    pub(super) fn attend(&self) {
        let due = lock(&self.alarms).due.take_if(|due| *due <= Instant::now());
        if due.is_some() {
            let (logger, bag) = (self.node.logger().clone(), self.bag().display().to_string());
            let on_snapshot =
                move |count| logger.info(&format!("an alarm: a snapshot of {count} messages is in {bag}"));
            self.recording.snapshot(on_snapshot);
        }
        for (closed, opened) in self.recording.take_splits() {
            let path = |name: String| self.bag().join(name).display().to_string();
            let event = WriteSplitEvent {
                closed_file: path(closed),
                opened_file: path(opened),
                node_name: self.node.fully_qualified_name().to_owned(),
            };
            if let Err(error) = self.outlets.splits.publish(&event) {
                self.node.logger().warn(&error.to_string());
            }
        }
        if lock(&self.losses).1.elapsed() >= LOSS_INTERVAL {
            self.publish_losses();
        }
    }

    /// Publishes the losses since the last event, if there are any.
    fn publish_losses(&self) {
        let topics = self.counts().topics;
        let mut losses = lock(&self.losses);
        let messages_lost_statistics = losses.0.since_last(&topics);
        losses.1 = Instant::now();
        drop(losses);
        if messages_lost_statistics.is_empty() {
            return;
        }
        let node_name = self.node.fully_qualified_name().to_owned();
        if let Err(error) = self.outlets.losses.publish(&MessagesLostEvent { node_name, messages_lost_statistics }) {
            self.node.logger().warn(&error.to_string());
        }
    }

    /// Stops or resumes writing; what arrives in between is not part of the recording.
    pub(super) fn pause(&self, is_paused: bool) {
        self.is_paused.store(is_paused, Ordering::Release);
    }

    /// Returns whether writing is paused.
    pub(super) fn is_paused(&self) -> bool {
        self.is_paused.load(Ordering::Acquire)
    }

    /// Starts or stops subscribing to new topics; returns false if nothing changes.
    pub(super) fn discover(self: &Arc<Self>, is_discovering: bool) -> bool {
        let was = self.is_discovering.swap(is_discovering, Ordering::AcqRel);
        self.refresh();
        was != is_discovering
    }

    /// Returns whether new topics are subscribed to.
    pub(super) fn is_discovering(&self) -> bool {
        self.is_discovering.load(Ordering::Acquire)
    }

    /// Subscribes to what has turned up in the graph since the last call.
    pub(super) fn refresh(self: &Arc<Self>) {
        if self.is_stopped.load(Ordering::Acquire) || !self.is_discovering() {
            return;
        }
        let mut topics = lock(&self.topics);
        let mut subscribed_now = 0;
        for found in self.node.discovered_topics() {
            if found.publishers.is_empty() || !self.selection.selects(&found.name, &found.type_name) {
                continue;
            }
            // A type that an action or a service implies (`pkg/action/X_FeedbackMessage`) has no name in the bag's definition language;
            // rosbag2 excludes these hidden topics as well. Events of service calls exist only where a parameter enables them.
            let is_expected = is_message_type(&found.type_name) || is_service_event(&found.name, &found.type_name);
            if !self.settings.include_feedback && !is_expected {
                continue;
            }
            if let Some(entry) = topics.entries.get(&found.name) {
                if entry.type_name != found.type_name {
                    let text = format!("a publisher says {}, the recording says {}", found.type_name, entry.type_name);
                    self.refuse(&mut topics, &found, &text);
                }
                continue;
            }
            if subscribed_now == SUBSCRIBED_AT_ONCE {
                let weak = Arc::downgrade(self);
                self.node.post(move || {
                    if let Some(session) = weak.upgrade() {
                        session.refresh();
                    }
                });
                break;
            }
            let weak = Arc::downgrade(self);
            let answered = move |type_name: String, response| {
                if let Some(session) = weak.upgrade() {
                    lock(&session.definitions).learn(&type_name, &response);
                    session.refresh();
                }
            };
            let subscribed = match lock(&self.definitions).find(&self.node, &found, answered) {
                DefinitionState::Yes(definition) => self.subscribe(&found, definition),
                DefinitionState::NotYet => continue,
                DefinitionState::No(reason) => Err(reason),
            };
            match subscribed {
                Ok(entry) => {
                    subscribed_now += 1;
                    topics.entries.insert(found.name, entry);
                }
                Err(reason) => self.refuse(&mut topics, &found, &reason),
            }
        }
        for entry in topics.entries.values_mut().filter(|e| !e.was_matched) {
            entry.was_matched = entry.subscription.matched() > 0;
        }
    }

    /// Says once why a topic is not recorded.
    fn refuse(&self, topics: &mut Topics, found: &TopicInfo, reason: &str) {
        if topics.refused.insert((found.name.clone(), found.type_name.clone())) {
            self.node.logger().warn(&format!("{} is not recorded: {reason}", found.name));
        }
    }

    fn subscribe(self: &Arc<Self>, found: &TopicInfo, definition: DefinitionText) -> Result<TopicSubscription, String> {
        let offers: Vec<_> = found.publishers.iter().map(|p| p.qos).collect();
        let recorded = self.recording.add_topic(Topic {
            name: found.name.clone(),
            type_name: found.type_name.clone(),
            // rosbags checks every hash when it opens a bag, and refuses the whole bag for the hash of a type whose name it cannot have.
            type_hash: if is_message_type(&found.type_name) { definition.hash } else { String::new() },
            definition: definition.text,
            offered_qos: offers.iter().map(recorded_qos).collect(),
        });
        let meaning = match &found.name {
            name if *name == self.joint_states => TopicRole::JointStates,
            name if *name == self.stream => TopicRole::Stream,
            _ => TopicRole::Other,
        };
        let weak = Arc::downgrade(self);
        let mut arrivals = Arrivals::default();
        let qos = subscription_qos(&offers, self.settings.depth);
        let latched = offers.iter().filter(|offer| offer.durability == Durability::TransientLocal);
        let history = latched.map(Qos::depth).max().unwrap_or(0);
        let subscription = self
            .node
            .subscribe_raw_within(&found.name, &found.type_name, &qos, history, READ_BYTES, move |cdr, message| {
                let Some(session) = weak.upgrade() else { return };
                match arrivals.record(message.writer, message.sequence_number) {
                    TopicArrival::After(missing) => session.note_missing(missing, &recorded),
                    TopicArrival::Late => recorded.withdraw_missed(),
                    TopicArrival::Older => {}
                }
                session.receive(&recorded, meaning, cdr, message);
            })
            .map_err(|error| error.to_string())?;
        Ok(TopicSubscription { type_name: found.type_name.clone(), subscription, was_matched: false })
    }

    fn note_missing(&self, count: u64, topic: &RecordedTopic) {
        if count > 0 && self.recording.report_missed(topic, count) {
            let name = topic.name();
            self.node.logger().warn(&format!("{count} messages of {name} were lost on their way to the recorder"));
        }
    }

    fn receive(&self, topic: &RecordedTopic, meaning: TopicRole, cdr: &[u8], message: &MessageInfo) {
        if self.is_stopped.load(Ordering::Acquire) {
            return;
        }
        let is_kept = self.is_paused() || self.store(topic, cdr, message);
        // Ticks are followed while paused, or a machine at pace fast would wait for a paused recorder.
        match meaning {
            TopicRole::JointStates if is_kept => self.advance(|watch| watch.joint_states(cdr)),
            TopicRole::Stream => self.advance(|watch| watch.stream(cdr)),
            _ => {}
        }
    }

    fn store(&self, topic: &RecordedTopic, cdr: &[u8], message: &MessageInfo) -> bool {
        let reception_ns = unsigned(message.reception_timestamp_ns);
        let publish_ns = message.source_timestamp_ns.map_or(reception_ns, unsigned);
        if !self.settings.use_sim_time {
            return self.recording.record(topic, reception_ns, publish_ns, cdr.to_vec());
        }
        let now_ns = unsigned(self.node.now_ns());
        let mut held = lock(&self.held);
        if now_ns == 0 {
            held.push(HeldMessage { topic: topic.clone(), publish_ns, reception_ns, data: cdr.to_vec() });
            let waits_too_long = held.iter().map(|h| h.data.len()).sum::<usize>() > HELD_BYTES;
            if waits_too_long {
                self.release(&mut held, None);
            }
            return true;
        }
        self.release(&mut held, Some(now_ns));
        drop(held);
        self.recording.record(topic, now_ns, publish_ns, cdr.to_vec())
    }

    /// Writes what has waited for `/clock`, with the first time it showed or each message's time of receipt.
    fn release(&self, held: &mut Vec<HeldMessage>, clock_ns: Option<u64>) {
        for h in held.drain(..) {
            self.recording.record(&h.topic, clock_ns.unwrap_or(h.reception_ns), h.publish_ns, h.data);
        }
    }

    /// Follows the machine, and publishes the progress of the bag when the machine needs it.
    fn advance(&self, step: impl FnOnce(&mut TickWatch)) {
        let mut progress = lock(&self.progress);
        step(&mut progress.watch);
        let tick = progress.watch.last_tick();
        let is_news = progress.watch.is_awaited()
            && (tick < progress.reported_tick || tick - progress.reported_tick >= self.settings.credit_ticks);
        drop(progress);
        if is_news {
            self.publish();
        }
    }

    /// Publishes the status if it was not published lately.
    pub(super) fn publish_if_due(&self) {
        let is_due = lock(&self.progress).reported_at.is_none_or(|at| at.elapsed() >= STATUS_INTERVAL);
        if is_due {
            self.publish();
        }
    }

    pub(super) fn publish(&self) {
        let mut status = RecorderStatus {
            stamp: self.node.now(),
            recording: !self.is_stopped.load(Ordering::Acquire) && self.fault().is_none(),
            paused: self.is_paused(),
            bag: self.bag().display().to_string(),
            ..RecorderStatus::default()
        };
        {
            let mut progress = lock(&self.progress);
            status.last_tick = progress.watch.last_tick();
            progress.reported_tick = status.last_tick;
            progress.reported_at = Some(Instant::now());
        }
        let counts = self.counts();
        (status.bytes, status.received) = (counts.bytes, counts.received);
        (status.written, status.dropped) = (counts.written, counts.dropped);
        (status.passed, status.repeated, status.free_bytes) = (counts.passed, counts.repeated, counts.free_bytes);
        status.files = u32::try_from(counts.files).unwrap_or(u32::MAX);
        let topics = lock(&self.topics);
        status.topics = counts
            .topics
            .into_iter()
            .filter(|t| t.received > 0 || topics.entries.get(&t.topic).is_some_and(|e| e.was_matched))
            .map(|t| TopicRecord {
                topic: t.topic,
                type_: t.type_name,
                received: t.received,
                written: t.written,
                dropped: t.dropped,
                passed: t.passed,
            })
            .collect();
        drop(topics);
        if let Err(error) = self.outlets.status.publish(&status) {
            self.node.logger().warn(&error.to_string());
        }
    }

    /// Ends the subscriptions, writes what is queued and closes the bag.
    pub(super) fn stop(&self) -> Result<(BagMetadata, Counts), BagError> {
        self.is_stopped.store(true, Ordering::Release);
        let entries = std::mem::take(&mut lock(&self.topics).entries);
        drop(entries);
        self.release(&mut lock(&self.held), None);
        let result = self.recording.stop(RecordingOutcome::Complete);
        self.publish();
        self.publish_losses();
        result
    }
}

/// Why a recording could not begin.
#[derive(Debug, thiserror::Error)]
pub(super) enum SessionError {
    #[error(transparent)]
    Bag(#[from] BagError),
    #[error(transparent)]
    Ros(#[from] RosError),
}
