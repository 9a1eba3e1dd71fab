// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! All cells of one or more domains: found by their topics, shown in a line each, stopped together.

use super::OPTIONAL_NODES;
use super::cell_snapshot::CellSnapshot;
use super::feed::Feed;
use super::operation::{Answer, END_OF_HISTORY, NOTHING_TO_CANCEL, Operation};
use super::operator::Operator;
use super::state_line::{self, StatusLine};
use super::status::{AlarmLine, JobLine, alarm, job};
use super::subscriptions::subscribe_to_state;
use camwright_msgs::Message;
use camwright_msgs::camwright_msgs::msg::{InterpolatorState, JobStatus, MachineStream};
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_ros::running::NodeError;
use camwright_ros::{Client, Node, NodeOptions, RosArgs, SpinThread, Subscription};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::panic::resume_unwind;
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

/// Maximum time for the other participants to say which nodes they have.
const ACQUAINTED: Duration = Duration::from_secs(3);
/// Maximum time for a planner to answer.
const ANSWER: Duration = Duration::from_secs(5);
/// Cells that are operated at a time by nodes of their own: a host has ports for 120 participants in a domain.
const AT_ONCE: usize = 8;

/// A cell in a line.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FleetCell {
    /// ROS domain.
    pub domain: u16,
    /// Namespace.
    pub cell: String,
    state: StatusLine,
    job: Option<JobLine>,
    alarms: Vec<AlarmLine>,
    /// `fast` or `realtime`; none without a machine.
    pace: Option<&'static str>,
    /// Machine and interpolator send messages.
    pub is_reachable: bool,
    /// A job may begin: no alarm, no job and no motion.
    pub is_idle: bool,
}

impl FleetCell {
    fn from_snapshot(domain: u16, snapshot: &CellSnapshot, now: Instant) -> Self {
        let is_stopped =
            state_line::stopping(snapshot).next().is_some() || snapshot.io.as_ref().is_some_and(|io| io.estop);
        let is_reachable = !snapshot.is_machine_silent(now) && !snapshot.is_interpolator_silent(now);
        let pace = snapshot.stream.as_ref().filter(|_| !snapshot.is_machine_silent(now));
        Self {
            domain,
            cell: snapshot.namespace.clone(),
            state: state_line::state(snapshot, now),
            job: job(snapshot),
            alarms: state_line::alarms(snapshot).map(alarm).collect(),
            pace: pace.map(|stream| match stream.message.pace {
                MachineStream::PACE_REALTIME => "realtime",
                _ => "fast",
            }),
            is_reachable,
            is_idle: is_reachable && !is_stopped && !is_at_work(snapshot),
        }
    }

    /// Word of the state: READY, CUTTING, ALARM 42.
    #[must_use]
    pub fn word(&self) -> &str {
        &self.state.word
    }

    /// Explanation of the state.
    #[must_use]
    pub fn detail(&self) -> &str {
        &self.state.detail
    }

    /// Name and progress (%) of the job, if the cell has one.
    #[must_use]
    pub fn job(&self) -> Option<(&str, f64)> {
        self.job.as_ref().map(|job| (job.name.as_str(), job.percent))
    }

    #[must_use]
    pub fn pace(&self) -> Option<&'static str> {
        self.pace
    }

    /// Number and text of each alarm.
    pub fn alarms(&self) -> impl Iterator<Item = (u16, &str)> {
        self.alarms.iter().map(|alarm| (alarm.number, alarm.text.as_str()))
    }

    /// Returns true if an alarm needs a reset.
    #[must_use]
    pub fn has_alarms(&self) -> bool {
        self.alarms.iter().any(|alarm| alarm.severity != "warning")
    }

    /// Returns true if the cell does the same as in `other`; the job may have advanced by less than a percent.
    #[must_use]
    pub fn is_same_state(&self, other: &Self) -> bool {
        let percent = |cell: &Self| cell.job().map(|(name, percent)| (name.to_owned(), percent.floor().to_bits()));
        let known = |cell: &Self| (cell.domain, cell.cell.clone(), cell.pace, cell.is_reachable, cell.is_idle);
        self.state == other.state
            && self.alarms == other.alarms
            && percent(self) == percent(other)
            && known(self) == known(other)
    }
}

/// Returns true while a job or a motion is under way.
fn is_at_work(snapshot: &CellSnapshot) -> bool {
    let in_job = snapshot
        .job
        .as_ref()
        .is_some_and(|job| [JobStatus::PLANNING, JobStatus::EXECUTING, JobStatus::STOPPING].contains(&job.state));
    let moves = snapshot.interpolator.as_ref().is_some_and(|state| state.message.state != InterpolatorState::IDLE);
    in_job || moves
}

/// A cell that was found.
#[derive(Debug)]
struct FoundCell {
    feed: Arc<Feed>,
    _subscriptions: Vec<Subscription>,
}

/// One node that listens to all cells of its domain.
#[derive(Debug)]
struct DomainListener {
    node: Node,
    cells: BTreeMap<String, FoundCell>,
    _spin: SpinThread,
}

impl DomainListener {
    fn start(args: &RosArgs) -> Result<Self, NodeError> {
        let node = Node::new(NodeOptions::new("camwright_fleet", args))?;
        let spin = node.spin_in_thread()?;
        Ok(Self { node, cells: BTreeMap::new(), _spin: spin })
    }

    /// Listens to cells that have appeared, of these namespaces or of all if there is none.
    fn add_new(&mut self, wanted: &BTreeSet<String>) -> Result<(), NodeError> {
        for namespace in self.discovered() {
            let is_wanted = wanted.is_empty() || wanted.contains(&namespace);
            if !is_wanted || self.cells.contains_key(&namespace) {
                continue;
            }
            let feed = Arc::<Feed>::default();
            feed.update(|snapshot| snapshot.namespace.clone_from(&namespace));
            let _subscriptions = subscribe_to_state(&self.node, &feed, &prefix(&namespace))?;
            self.cells.insert(namespace, FoundCell { feed, _subscriptions });
        }
        Ok(())
    }

    /// Namespaces in which a node of a cell publishes.
    fn discovered(&self) -> BTreeSet<String> {
        let marks = [
            ("machine/stream", MachineStream::TYPE_NAME),
            ("axis_interpolator/state", InterpolatorState::TYPE_NAME),
            ("job_planner/job_status", JobStatus::TYPE_NAME),
        ];
        let topics = self.node.discovered_topics();
        let published = topics.iter().filter(|topic| !topic.publishers.is_empty());
        let namespaces = published.filter_map(|topic| {
            let (mark, _) = marks.iter().find(|(mark, kind)| topic.name.ends_with(mark) && topic.type_name == *kind)?;
            let namespace = topic.name.strip_suffix(mark)?.strip_suffix('/')?;
            Some(absolute(namespace))
        });
        namespaces.collect()
    }
}

/// Listens to the cells of one or more domains, with a node in each.
#[derive(Debug)]
pub struct FleetListener {
    args: RosArgs,
    /// Namespaces to listen to; empty: all.
    wanted: BTreeSet<String>,
    domains: BTreeMap<u16, DomainListener>,
}

impl FleetListener {
    /// Listens to the cells with these namespaces, without any to all cells. Without domains it listens in that of the arguments.
    ///
    /// # Errors
    /// DDS cannot start.
    pub fn start(args: &RosArgs, domains: &[u16], wanted: &[String]) -> Result<Self, NodeError> {
        let own = [args.domain_id()];
        let domains = if domains.is_empty() { &own[..] } else { domains };
        let listener = |id: &u16| Ok((*id, DomainListener::start(&args.clone().with_domain_id(*id))?));
        let domains = domains.iter().map(listener).collect::<Result<_, NodeError>>()?;
        let wanted = wanted.iter().map(|name| absolute(name)).collect();
        Ok(Self { args: args.clone(), wanted, domains })
    }

    /// Finds the cells and waits for their messages, at most for `patience`.
    ///
    /// # Errors
    /// A subscription is refused.
    pub fn find(&mut self, patience: Duration) -> Result<(), NodeError> {
        let deadline = Instant::now() + patience;
        let left = || deadline.saturating_duration_since(Instant::now());
        let (sender, changes) = mpsc::sync_channel(1);
        let listener = |domain: &DomainListener| {
            let sender = sender.clone();
            domain.node.on_graph_change(move || {
                let _one_is_enough = sender.try_send(());
            })
        };
        let _listeners: Vec<_> = self.domains.values().map(listener).collect();
        let acquainted = Instant::now() + ACQUAINTED.min(patience);
        for domain in self.domains.values() {
            let _all_said_their_nodes =
                domain.node.wait_acquainted(acquainted.saturating_duration_since(Instant::now()));
        }
        self.add_new()?;
        while !self.is_complete() && !left().is_zero() {
            let _changed_or_late = changes.recv_timeout(left());
            self.add_new()?;
        }
        let cells: Vec<&FoundCell> = self.found().map(|(_, cell)| cell).collect();
        for cell in &cells {
            drop(cell.feed.wait_until(left(), |cell| cell.stream.is_some() && cell.interpolator.is_some()));
        }
        // The planner is optional, and a writer of latched messages may repeat older ones first.
        let optional = deadline.min(Instant::now() + OPTIONAL_NODES);
        let left_for_optional = || optional.saturating_duration_since(Instant::now());
        for cell in &cells {
            let is_known = |cell: &CellSnapshot| cell.machine_alarms.is_some() && cell.job.is_some();
            drop(cell.feed.wait_until(left_for_optional(), is_known));
        }
        for cell in &cells {
            cell.feed.wait_for_quiet(END_OF_HISTORY, END_OF_HISTORY.max(left_for_optional()));
        }
        // A cell is not judged by an old state of its interpolator.
        for cell in &cells {
            drop(cell.feed.wait_until(left(), CellSnapshot::is_current));
        }
        Ok(())
    }

    /// Listens to cells that have appeared; those that have left stay.
    ///
    /// # Errors
    /// A subscription is refused.
    pub fn add_new(&mut self) -> Result<(), NodeError> {
        let wanted = &self.wanted;
        self.domains.values_mut().try_for_each(|domain| domain.add_new(wanted))
    }

    /// All cells with their domains, sorted by domain and namespace.
    fn found(&self) -> impl Iterator<Item = (u16, &FoundCell)> {
        self.domains.iter().flat_map(|(id, domain)| domain.cells.values().map(|cell| (*id, cell)))
    }

    /// Cells that were asked for and found in no domain.
    #[must_use]
    pub fn missing(&self) -> Vec<&str> {
        let is_found = |name: &String| self.domains.values().any(|domain| domain.cells.contains_key(name));
        let missing = self.wanted.iter().filter(|name| !is_found(name));
        missing.map(String::as_str).collect()
    }

    /// Every named cell was found, and every domain has a cell.
    fn is_complete(&self) -> bool {
        self.missing().is_empty() && self.empty_domains().is_empty()
    }

    /// No cell was found.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.found().next().is_none()
    }

    /// Domains without any of the cells.
    #[must_use]
    pub fn empty_domains(&self) -> Vec<u16> {
        let empty = self.domains.iter().filter(|(_, domain)| domain.cells.is_empty());
        empty.map(|(id, _)| *id).collect()
    }

    /// The cells now, sorted by domain and namespace.
    #[must_use]
    pub fn cells(&self) -> Vec<FleetCell> {
        let now = Instant::now();
        let snapshot = |(domain, cell): (u16, &FoundCell)| {
            FleetCell::from_snapshot(domain, &cell.feed.wait_until(Duration::ZERO, |_| true), now)
        };
        self.found().map(snapshot).collect()
    }

    /// Does something for several cells, for some of them at a time; the order of results is that of the cells.
    pub fn for_each<T: Send>(&self, cells: &[FleetCell], action: impl Fn(&FleetCell, &RosArgs) -> T + Sync) -> Vec<T> {
        let mut results = Vec::with_capacity(cells.len());
        for group in cells.chunks(AT_ONCE) {
            std::thread::scope(|scope| {
                let mut threads = Vec::with_capacity(AT_ONCE);
                for cell in group {
                    let args = self.args.clone().with_domain_id(cell.domain).with_namespace(&cell.cell);
                    let action = &action;
                    threads.push(scope.spawn(move || action(cell, &args)));
                }
                results.extend(
                    threads.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic))),
                );
            });
        }
        results
    }

    /// Cancels the jobs of all planners at once, then the motions of cells without a job. A cell at rest has nothing to stop.
    ///
    /// # Errors
    /// A client is refused.
    pub fn cancel(&self, cells: &[FleetCell]) -> Result<Vec<Answer>, NodeError> {
        let mut planners = Vec::with_capacity(cells.len());
        for (index, cell) in cells.iter().enumerate() {
            if let Some(domain) = self.domains.get(&cell.domain) {
                let service = format!("{}job_planner/stop", prefix(&cell.cell));
                planners.push((index, cell, domain.node.client::<Trigger>(&service)?));
            }
        }
        let mut answers: Vec<Option<Answer>> = vec![None; cells.len()];
        stop_jobs(&planners, &mut answers);
        let rest: Vec<usize> = (0..cells.len()).filter(|index| answers[*index].is_none()).collect();
        let moving: Vec<FleetCell> = rest.iter().map(|index| cells[*index].clone()).collect();
        let cancelled = self.for_each(&moving, |cell, args| {
            if cell.is_idle {
                return Answer::done("nothing to stop");
            }
            let answer = cancel_motion(args).unwrap_or_else(|error| Answer::refused(error.to_string()));
            if answer.message == NOTHING_TO_CANCEL { Answer::done("nothing to stop") } else { answer }
        });
        for (index, answer) in rest.into_iter().zip(cancelled) {
            answers[index] = Some(answer);
        }
        Ok(answers.into_iter().flatten().collect())
    }

    /// Ends the nodes.
    pub fn stop(self) {
        for domain in self.domains.values() {
            domain.node.shutdown();
        }
    }
}

/// Asks all planners to stop their jobs. A planner that has no job or does not answer leaves no answer.
fn stop_jobs(planners: &[(usize, &FleetCell, Client<Trigger>)], answers: &mut [Option<Answer>]) {
    let (sender, received) = mpsc::channel();
    let deadline = Instant::now() + ANSWER;
    let left = || deadline.saturating_duration_since(Instant::now());
    let mut asked = 0_usize;
    for (index, cell, planner) in planners {
        // A cell without a planner has no job status.
        let patience = if cell.job.is_some() { left() } else { left().min(OPTIONAL_NODES) };
        if planner.wait_for_service(patience).is_ok() {
            let (index, sender) = (*index, sender.clone());
            let sent = planner.call_with(&TriggerRequest::default(), move |answer| {
                let _is_late = sender.send((index, answer.success));
            });
            asked += usize::from(sent.is_ok());
        }
    }
    while asked > 0
        && let Ok((index, is_stopped)) = received.recv_timeout(left())
    {
        asked -= 1;
        if is_stopped {
            answers[index] = Some(Answer::done("job cancelled, the axes come to rest"));
        }
    }
}

/// Cancels the motion of a cell.
fn cancel_motion(args: &RosArgs) -> Result<Answer, NodeError> {
    let node = Node::new(NodeOptions::new("camwright_operate", args))?;
    let spin = node.spin_in_thread()?;
    let answer = Operator::new(node.clone(), args, "camwright fleet").perform(&Operation::Cancel {}, &|| true);
    drop(spin);
    node.shutdown();
    Ok(answer)
}

/// Namespace with its leading slash; `/` for none.
fn absolute(namespace: &str) -> String {
    format!("/{}", namespace.trim_matches('/'))
}

/// First part of the names of a cell's topics.
fn prefix(namespace: &str) -> String {
    format!("{}/", namespace.trim_end_matches('/'))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell_snapshot::Received;

    #[test]
    fn namespaces_become_names_of_topics() {
        for (given, namespace, topics) in
            [("cell_1", "/cell_1", "/cell_1/"), ("/a/b/", "/a/b", "/a/b/"), ("", "/", "/")]
        {
            assert_eq!((absolute(given), prefix(&absolute(given))), (namespace.to_owned(), topics.to_owned()));
        }
    }

    #[test]
    fn a_cell_is_idle_while_nothing_stops_it_or_moves() {
        let now = Instant::now();
        let mut snapshot = CellSnapshot::default();
        let line = |snapshot: &CellSnapshot| FleetCell::from_snapshot(0, snapshot, now);
        assert!(!line(&snapshot).is_reachable && !line(&snapshot).is_idle, "{:?}", line(&snapshot));
        assert_eq!((line(&snapshot).word(), line(&snapshot).pace()), ("NO MACHINE", None));
        let stream = MachineStream { pace: MachineStream::PACE_REALTIME, ..MachineStream::default() };
        snapshot.stream = Some(Received { message: stream, at: now });
        assert!(!line(&snapshot).is_reachable, "without an interpolator");
        snapshot.add_interpolator(InterpolatorState { state: InterpolatorState::IDLE, ..InterpolatorState::default() });
        assert!(line(&snapshot).is_idle && line(&snapshot).pace() == Some("realtime"), "{:?}", line(&snapshot));
        snapshot.add_job(JobStatus { state: JobStatus::PLANNING, ..JobStatus::default() });
        assert!(line(&snapshot).is_reachable && !line(&snapshot).is_idle, "{:?}", line(&snapshot));
    }
}
