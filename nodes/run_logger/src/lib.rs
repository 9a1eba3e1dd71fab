// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The node `run_logger`: records the topics of its cell as a rosbag2 bag.
//!
//! ```text
//!   discovery ──► Selection ──► raw subscriptions ──► Recording (queue, writer thread) ──► <bag_dir>/
//!                                     │ joint_states, machine/stream
//!                                     └──► TickWatch ──► ~/status ──► machine_sim: at pace fast it waits for us
//! ```
//!
//! Active means recording: activation opens the bag, deactivation closes it. Services and events are those of rosbag2's recorder
//! (`services.rs`); `~/record` and `~/stop` are the same two transitions.

mod arrivals;
mod definitions;
mod losses;
mod retention;
mod selection;
mod services;
mod session;
mod settings;
mod ticks;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use camwright_bag::{Counts, DurationSummary};
use camwright_msgs::camwright_msgs::msg::RecorderStatus;
use camwright_msgs::diagnostic_msgs::msg::DiagnosticStatus;
use camwright_ros::running::{NodeError, autostart, ending_step};
use camwright_ros::{
    Diagnostics, Farewell, GraphListener, Lifecycle, LifecycleCallbacks, Node, NodeOptions, Qos, RosArgs,
    ServiceHandle, SpinThread, TimerHandle, Transition, WriterWindow, diagnostic_status,
};

pub use selection::regex;
pub use selection::{Selection, TopicFilter};
use session::{RecorderOutlets, Session};
pub use settings::MIN_FREE_MB;
use settings::RecorderSettings;

/// Period of the checks of a recording.
const ATTEND_PERIOD: Duration = Duration::from_millis(100);
/// Maximum delay of messages published before a deactivation.
const LAST_ARRIVALS: Duration = Duration::from_millis(100);

/// A recording under way and what feeds it.
struct Active {
    session: Arc<Session>,
    _status: TimerHandle,
    _graph: GraphListener,
}

/// State shared by the node's callbacks.
struct Shared {
    node: Node,
    outlets: RecorderOutlets,
    /// Locked for the moments of activation and deactivation (the life cycle's thread) and by services (the executor's); never
    /// while waiting for the other.
    active: Mutex<Option<Active>>,
    /// Directory of the next bag in place of the parameter `bag_dir`.
    requested_dir: Mutex<Option<PathBuf>>,
    /// True if a recording ended by itself, or could not be closed.
    has_failed: AtomicBool,
}

pub struct RunLogger {
    shared: Arc<Shared>,
    lifecycle: Lifecycle,
    _diagnostics: Diagnostics,
    _services: Vec<ServiceHandle>,
    _spin: SpinThread,
}

impl std::fmt::Debug for RunLogger {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RunLogger").field("node", &self.shared.node).finish_non_exhaustive()
    }
}

impl Shared {
    fn active(&self) -> std::sync::MutexGuard<'_, Option<Active>> {
        self.active.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the directory of the next bag in place of the parameter.
    fn request_dir(&self, directory: Option<PathBuf>) {
        *self.requested_dir.lock().unwrap_or_else(PoisonError::into_inner) = directory;
    }

    /// The present parameters, or a sentence about the one that is wrong.
    fn settings(&self) -> Result<RecorderSettings, String> {
        let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
        RecorderSettings::read(self.node.parameters(), u64::try_from(since.as_nanos()).unwrap_or(u64::MAX))
    }

    /// Opens the bag and begins to record.
    fn activate(self: &Arc<Self>) -> Result<(), String> {
        let mut active = self.active();
        if active.is_some() {
            return Err("a bag is open already".into());
        }
        let mut settings = self.settings()?;
        if let Some(directory) = self.requested_dir.lock().unwrap_or_else(PoisonError::into_inner).take() {
            settings.bag_dir = directory;
        }
        let deleted = settings.retention.make_room(&settings.bag_dir);
        for run in deleted.map_err(|error| format!("an old run could not be deleted: {error}"))? {
            self.node.logger().info(&format!("deleted {}, as keep_runs and keep_mb say", run.display()));
        }
        let session = Session::start(&self.node, settings, self.outlets.clone()).map_err(|e| e.to_string())?;
        let graph = self.node.on_graph_change({
            let session = Arc::downgrade(&session);
            move || {
                if let Some(session) = session.upgrade() {
                    session.refresh();
                }
            }
        });
        let status = self.node.timer(ATTEND_PERIOD, {
            let (session, logger) = (Arc::downgrade(&session), self.node.logger().clone());
            let mut has_reported_fault = false;
            move || {
                let Some(session) = session.upgrade() else { return };
                session.attend();
                session.publish_if_due();
                if let Some(fault) = session.fault().filter(|_| !has_reported_fault) {
                    has_reported_fault = true;
                    logger.error(&format!("the recording has ended: {fault}"));
                }
            }
        });
        // On the executor thread, where subscriptions are made whenever the graph changes.
        self.node.post({
            let session = Arc::downgrade(&session);
            move || {
                if let Some(session) = session.upgrade() {
                    session.refresh();
                }
            }
        });
        self.node.logger().info(&format!("recording into {}", session.bag().display()));
        *active = Some(Active { session, _status: status, _graph: graph });
        Ok(())
    }

    /// Closes the bag. Nothing happens when none is open.
    fn deactivate(&self) -> Result<(), String> {
        let Some(Active { session, _status, _graph }) = self.active().take() else { return Ok(()) };
        // The executor goes on delivering meanwhile, unless this is it.
        if !self.node.on_executor_thread() {
            std::thread::sleep(LAST_ARRIVALS);
        }
        drop((_status, _graph));
        let bag = session.bag().display().to_string();
        let ended_early = session.fault().is_some();
        match session.stop() {
            Ok((metadata, counts)) => {
                let (written, topics) = (metadata.message_count, metadata.topics.len());
                self.report_end(&format!("closed {bag}: {written} messages on {topics} topics"), &counts);
                // The end itself was already reported.
                self.has_failed.fetch_or(ended_early, Ordering::AcqRel);
                Ok(())
            }
            Err(error) => {
                self.has_failed.store(true, Ordering::Release);
                let text = format!("{bag} could not be closed properly: {error}");
                self.node.logger().error(&text);
                Err(text)
            }
        }
    }

    /// Logs what became of all that was published, and how long it took to hand a message over.
    fn report_end(&self, closed: &str, counts: &Counts) {
        let Counts { received, dropped, queue_full, missed, enqueue, .. } = counts;
        let us = |ns: u64| Duration::from_nanos(ns);
        let DurationSummary { p50_ns, p99_ns, longest_ns, .. } = *enqueue;
        let took = format!(
            "each took {:?} (p50), {:?} (p99), {:?} (most) into the queue",
            us(p50_ns),
            us(p99_ns),
            us(longest_ns)
        );
        let logger = self.node.logger();
        if (*dropped, *missed) == (0, 0) {
            logger.info(&format!("{closed}; {took}"));
        } else {
            let not_taken = dropped.saturating_sub(*queue_full);
            let lost = format!("{missed} were lost on their way here, {dropped} of {received} received were dropped");
            logger.warn(&format!("{closed}; {lost}: {queue_full} by a full queue, {not_taken} by the bag; {took}"));
        }
    }

    fn session(&self) -> Option<Arc<Session>> {
        self.active().as_ref().map(|active| Arc::clone(&active.session))
    }

    fn with_session<T>(&self, idle: T, action: impl FnOnce(&Session) -> T) -> T {
        match self.active().as_ref() {
            Some(active) => action(&active.session),
            None => idle,
        }
    }

    /// One status for `/diagnostics`.
    fn diagnosis(&self) -> DiagnosticStatus {
        let idle = diagnostic_status(DiagnosticStatus::OK, "", "not recording", &[]);
        self.with_session(idle, |session| {
            let counts = session.counts();
            let bag = session.bag().display().to_string();
            let (level, text) = if let Some(fault) = session.fault() {
                (DiagnosticStatus::ERROR, format!("the recording has ended: {fault}"))
            } else if counts.dropped > 0 {
                (DiagnosticStatus::WARN, format!("{} messages were dropped", counts.dropped))
            } else if counts.queued_bytes > session.queue_bytes() / 2 {
                (DiagnosticStatus::WARN, "the disk is slow: the queue is more than half full".into())
            } else if session.is_paused() {
                (DiagnosticStatus::OK, "paused".into())
            } else {
                (DiagnosticStatus::OK, "recording".into())
            };
            let values = [
                ("bag", bag),
                ("topics", counts.topics.len().to_string()),
                ("received", counts.received.to_string()),
                ("written", counts.written.to_string()),
                ("dropped", counts.dropped.to_string()),
                ("passed", counts.passed.to_string()),
                ("files", counts.files.to_string()),
                ("free_bytes", counts.free_bytes.to_string()),
                ("queued_bytes", counts.queued_bytes.to_string()),
                ("file_bytes", counts.bytes.to_string()),
            ];
            diagnostic_status(level, "", &text, &values)
        })
    }
}

struct Callbacks(Arc<Shared>);

impl LifecycleCallbacks for Callbacks {
    fn configure(&mut self) -> Result<(), String> {
        self.0.settings().map(drop)
    }

    fn activate(&mut self) -> Result<(), String> {
        self.0.activate()
    }

    fn deactivate(&mut self) -> Result<(), String> {
        // A bag that could not be closed properly is reported; the node is inactive all the same.
        drop(self.0.deactivate());
        Ok(())
    }

    fn shutdown(&mut self) -> Result<(), String> {
        self.0.deactivate()
    }
}

impl RunLogger {
    /// Name and parameters of the node.
    #[must_use]
    pub fn options(args: &RosArgs) -> NodeOptions {
        // It records its own topics too.
        NodeOptions::new("run_logger", args).writer_window(WriterWindow::Usual).parameters(settings::parameters())
    }

    /// Joins the graph as `run_logger`, unless `args` say otherwise. Nothing is recorded before the node is active.
    ///
    /// # Errors
    /// A name or a parameter is refused, or the network is.
    pub fn start(args: &RosArgs) -> Result<Self, NodeError> {
        let node = Node::new(Self::options(args))?;
        node.parameters().on_set(settings::check);
        let status = node.publisher::<RecorderStatus>("~/status", &Qos::default_topic())?;
        let splits = node.publisher("events/write_split", &Qos::default_topic())?;
        let losses = node.publisher("events/rosbag2_messages_lost", &Qos::default_topic())?;
        let outlets = RecorderOutlets { status, splits, losses };
        let shared = Arc::new(Shared {
            node: node.clone(),
            outlets,
            active: Mutex::default(),
            requested_dir: Mutex::default(),
            has_failed: AtomicBool::default(),
        });
        let weak = Arc::downgrade(&shared);
        let diagnostics =
            node.diagnostics("run_logger", move || weak.upgrade().map(|s| s.diagnosis()).into_iter().collect())?;
        let lifecycle = node.lifecycle(Callbacks(shared.clone()))?;
        let services = services::offer(&node, &shared, &lifecycle)?;
        let spin = shared.node.spin_in_thread()?;
        autostart::begin(&shared.node, &lifecycle);
        Ok(Self { shared, lifecycle, _spin: spin, _diagnostics: diagnostics, _services: services })
    }

    /// The node, for those who manage several in one process.
    #[must_use]
    pub fn node(&self) -> &Node {
        &self.shared.node
    }

    pub fn lifecycle(&self) -> &Lifecycle {
        &self.lifecycle
    }

    /// Closes the bag, then ends the node. A failure, unless all that was received before its end is in a bag that was closed properly.
    pub fn stop(self) -> ExitCode {
        self.close().0
    }

    /// Same as [`RunLogger::stop`], but waits for the end of the node only when the farewell is dropped.
    pub fn close(self) -> (ExitCode, Farewell) {
        // What could not be closed has been logged, and a node that was shut down before has nothing to close.
        ending_step("closing the bag");
        drop(self.lifecycle.trigger(Transition::Shutdown));
        ending_step("leaving the graph");
        let farewell = self.shared.node.leave();
        (ExitCode::from(u8::from(self.shared.has_failed.load(Ordering::Acquire))), farewell)
    }
}

impl Drop for RunLogger {
    fn drop(&mut self) {
        // A bag that was not closed: its metadata and the log say how it went.
        drop(self.shared.deactivate());
    }
}
