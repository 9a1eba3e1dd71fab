// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The single thread that runs a node's callbacks.
//!
//! Readers report new data through a poll (no sleeping, no busy waiting); timers, work from other threads and delayed deliveries
//! go through one queue. A callback never runs on two threads, and two callbacks of one node never at the same time.

use std::{
    cmp::Ordering as Order,
    collections::{BinaryHeap, HashMap, VecDeque},
    fmt, io,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread::ThreadId,
    time::{Duration, Instant},
};

use rustdds::mio1::{Events, Interest, Poll, Registry, Token, Waker, event};

use super::shutdown::Shutdown;

const WAKE: Token = Token(usize::MAX);

/// Samples one reader may deliver before the others get their turn.
const BUDGET: usize = 64;

/// A job for the executor thread.
pub(super) type ExecutorJob = Box<dyn FnOnce() + Send>;

/// Delivers up to `budget` samples of a reader; returns true if there may be more.
pub(super) type Drain = Box<dyn FnMut(usize) -> bool + Send>;

enum TimerAction {
    Once(ExecutorJob),
    Periodic { id: u64, period: Duration },
}

struct TimedAction {
    due: Instant,
    order: u64,
    action: TimerAction,
}

impl PartialEq for TimedAction {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Order::Equal
    }
}
impl Eq for TimedAction {}
impl PartialOrd for TimedAction {
    fn partial_cmp(&self, other: &Self) -> Option<Order> {
        Some(self.cmp(other))
    }
}
impl Ord for TimedAction {
    // The heap's greatest is the earliest; among equals, the first queued.
    fn cmp(&self, other: &Self) -> Order {
        (other.due, other.order).cmp(&(self.due, self.order))
    }
}

type SharedTimer = Arc<Mutex<Box<dyn FnMut() + Send>>>;

#[derive(Default)]
struct Queue {
    next_token: usize,
    next_order: u64,
    next_timer: u64,
    sources: HashMap<usize, Arc<Mutex<Drain>>>,
    ready: VecDeque<usize>,
    jobs: VecDeque<ExecutorJob>,
    timed: BinaryHeap<TimedAction>,
    timers: HashMap<u64, SharedTimer>,
}

pub(super) struct Executor {
    registry: Registry,
    waker: Waker,
    poll: Mutex<Option<Poll>>,
    queue: Mutex<Queue>,
    thread: Mutex<Option<ThreadId>>,
    closed: AtomicBool,
}

impl fmt::Debug for Executor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Executor").finish_non_exhaustive()
    }
}

impl Executor {
    pub(super) fn new() -> io::Result<Arc<Self>> {
        let poll = Poll::new()?;
        let registry = poll.registry().try_clone()?;
        let waker = Waker::new(&registry, WAKE)?;
        Ok(Arc::new(Executor {
            registry,
            waker,
            poll: Mutex::new(Some(poll)),
            queue: Mutex::default(),
            thread: Mutex::new(None),
            closed: AtomicBool::new(false),
        }))
    }

    fn queue(&self) -> MutexGuard<'_, Queue> {
        // A callback runs without this lock, so a panic in one cannot leave the queue half changed.
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Interrupts the executor's wait.
    pub(super) fn wake(&self) {
        // A full wake-up pipe means that it is awake already.
        let _ = self.waker.wake();
    }

    /// Returns true inside a callback of this node.
    pub(super) fn is_current_thread(&self) -> bool {
        *self.thread.lock().unwrap_or_else(PoisonError::into_inner) == Some(std::thread::current().id())
    }

    /// Registers a reader; `drain` is called whenever it has something new, and once at the beginning.
    pub(super) fn add_source<S: event::Source>(
        self: &Arc<Self>,
        mut source: S,
        drain: impl FnOnce(S) -> Drain,
    ) -> io::Result<SourceHandle> {
        let token = {
            let mut queue = self.queue();
            queue.next_token += 1;
            queue.next_token
        };
        self.registry.register(&mut source, Token(token), Interest::READABLE)?;
        let mut queue = self.queue();
        queue.sources.insert(token, Arc::new(Mutex::new(drain(source))));
        queue.ready.push_back(token);
        drop(queue);
        self.wake();
        Ok(SourceHandle { executor: Arc::downgrade(self), token })
    }

    /// Runs a job on the executor thread as soon as possible.
    pub(super) fn post(&self, job: ExecutorJob) {
        let mut queue = self.queue();
        // The executor takes all jobs at once and looks for more before it waits.
        let is_woken = !queue.jobs.is_empty();
        queue.jobs.push_back(job);
        drop(queue);
        if !is_woken {
            self.wake();
        }
    }

    /// Runs a job on the executor thread at `due`; jobs with equal times run in the order of this call.
    pub(super) fn at(&self, due: Instant, job: ExecutorJob) {
        let mut queue = self.queue();
        queue.next_order += 1;
        let order = queue.next_order;
        queue.timed.push(TimedAction { due, order, action: TimerAction::Once(job) });
        drop(queue);
        self.wake();
    }

    /// Runs a callback every `period`, measured from now, until the handle is dropped. Late periods are skipped, not made up.
    pub(super) fn every(self: &Arc<Self>, period: Duration, callback: Box<dyn FnMut() + Send>) -> TimerHandle {
        let period = period.max(Duration::from_micros(100));
        let mut queue = self.queue();
        queue.next_timer += 1;
        queue.next_order += 1;
        let (id, order) = (queue.next_timer, queue.next_order);
        queue.timers.insert(id, Arc::new(Mutex::new(callback)));
        queue.timed.push(TimedAction {
            due: Instant::now() + period,
            order,
            action: TimerAction::Periodic { id, period },
        });
        drop(queue);
        self.wake();
        TimerHandle { executor: Arc::downgrade(self), id }
    }

    /// Runs callbacks until shutdown is requested or the executor is closed. `false` if another thread is at it.
    pub(super) fn spin(self: &Arc<Self>, shutdown: &Shutdown) -> bool {
        let Some(mut poll) = self.poll.lock().unwrap_or_else(PoisonError::into_inner).take() else {
            return false;
        };
        *self.thread.lock().unwrap_or_else(PoisonError::into_inner) = Some(std::thread::current().id());
        let wake = Arc::downgrade(self);
        let _hook = shutdown.on_request(move || {
            if let Some(executor) = wake.upgrade() {
                executor.wake();
            }
        });
        let mut events = Events::with_capacity(256);
        while !shutdown.is_requested() && !self.closed.load(Ordering::Acquire) {
            self.run_jobs();
            self.run_timed();
            self.run_ready();
            let timeout = self.next_timeout();
            if let Err(error) = poll.poll(&mut events, timeout) {
                if error.kind() != io::ErrorKind::Interrupted {
                    // Only a broken epoll descriptor does this; without it nothing can be delivered any more.
                    break;
                }
                continue;
            }
            let mut queue = self.queue();
            for event in &events {
                if event.token() != WAKE {
                    queue.ready.push_back(event.token().0);
                }
            }
        }
        *self.thread.lock().unwrap_or_else(PoisonError::into_inner) = None;
        *self.poll.lock().unwrap_or_else(PoisonError::into_inner) = Some(poll);
        true
    }

    fn run_jobs(&self) {
        let jobs = std::mem::take(&mut self.queue().jobs);
        for job in jobs {
            job();
        }
    }

    /// Runs what is due now. What comes due meanwhile has its turn after readers, jobs and the end: a callback that takes longer than its
    /// period would otherwise be the only one that runs.
    fn run_timed(&self) {
        let now = Instant::now();
        loop {
            let mut queue = self.queue();
            if queue.timed.peek().is_none_or(|timed| timed.due > now) {
                return;
            }
            let Some(timed) = queue.timed.pop() else { return };
            match timed.action {
                TimerAction::Once(job) => {
                    drop(queue);
                    job();
                }
                TimerAction::Periodic { id, period } => {
                    let Some(timer) = queue.timers.get(&id).cloned() else { continue };
                    let mut due = timed.due + period;
                    if due <= now {
                        due = now + period;
                    }
                    queue.next_order += 1;
                    let order = queue.next_order;
                    queue.timed.push(TimedAction { due, order, action: TimerAction::Periodic { id, period } });
                    drop(queue);
                    (timer.lock().unwrap_or_else(PoisonError::into_inner))();
                }
            }
        }
    }

    fn run_ready(&self) {
        let ready = std::mem::take(&mut self.queue().ready);
        for token in ready {
            let source = self.queue().sources.get(&token).cloned();
            let Some(source) = source else { continue };
            let more = (source.lock().unwrap_or_else(PoisonError::into_inner))(BUDGET);
            if more {
                self.queue().ready.push_back(token);
            }
        }
    }

    fn next_timeout(&self) -> Option<Duration> {
        let queue = self.queue();
        if !queue.ready.is_empty() || !queue.jobs.is_empty() {
            return Some(Duration::ZERO);
        }
        queue.timed.peek().map(|timed| timed.due.saturating_duration_since(Instant::now()))
    }

    /// Ends `spin` and forgets everything it would have called, and with it what the callbacks own.
    pub(super) fn close(&self) {
        self.closed.store(true, Ordering::Release);
        // Dropped after the lock is released: what a callback owns may call back here when it is dropped.
        let dropped = std::mem::take(&mut *self.queue());
        drop(dropped);
        self.wake();
    }
}

/// Keeps a reader registered.
pub(super) struct SourceHandle {
    executor: std::sync::Weak<Executor>,
    token: usize,
}

impl Drop for SourceHandle {
    fn drop(&mut self) {
        if let Some(executor) = self.executor.upgrade() {
            let removed = executor.queue().sources.remove(&self.token);
            drop(removed);
        }
    }
}

/// A running timer; dropping it stops the timer.
#[must_use = "dropping it stops the timer"]
pub struct TimerHandle {
    executor: std::sync::Weak<Executor>,
    id: u64,
}

impl fmt::Debug for TimerHandle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TimerHandle").field("id", &self.id).finish()
    }
}

impl Drop for TimerHandle {
    fn drop(&mut self) {
        if let Some(executor) = self.executor.upgrade() {
            let removed = executor.queue().timers.remove(&self.id);
            drop(removed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[test]
    fn jobs_at_equal_times_keep_their_order_and_timers_repeat() {
        let executor = Executor::new().expect("a poll");
        let shutdown = Shutdown::new();
        let (sender, receiver) = mpsc::channel();
        let due = Instant::now() + Duration::from_millis(5);
        for number in 0..100 {
            let sender = sender.clone();
            executor.at(due, Box::new(move || sender.send(number).expect("the receiver lives")));
        }
        let mut left = 3;
        let ender = shutdown.clone();
        let _timer = executor.every(
            Duration::from_millis(10),
            Box::new(move || {
                left -= 1;
                if left == 0 {
                    ender.request();
                }
            }),
        );
        assert!(executor.spin(&shutdown));
        assert_eq!(receiver.try_iter().collect::<Vec<i32>>(), (0..100).collect::<Vec<_>>());
    }

    /// As where a publisher waits for room in each of its calls.
    #[test]
    fn a_callback_that_takes_longer_than_its_period_leaves_jobs_and_the_end_their_turn() {
        const PERIOD: Duration = Duration::from_millis(1);
        let executor = Executor::new().expect("a poll");
        let shutdown = Shutdown::new();
        let (began, begins) = mpsc::channel();
        let _timer = executor.every(
            PERIOD,
            Box::new(move || {
                // An error means that the test waits no longer.
                let _unsent = began.send(());
                let end = Instant::now() + 3 * PERIOD;
                while Instant::now() < end {
                    std::hint::spin_loop();
                }
            }),
        );
        let (ended, end) = mpsc::channel();
        std::thread::spawn({
            let (executor, shutdown) = (Arc::clone(&executor), shutdown.clone());
            move || ended.send(executor.spin(&shutdown))
        });
        let patience = Duration::from_secs(5);
        begins.recv_timeout(patience).expect("the timer runs");
        let (sender, receiver) = mpsc::channel();
        executor.post(Box::new(move || sender.send(()).expect("the receiver lives")));
        receiver.recv_timeout(patience).expect("the job has its turn");
        shutdown.request();
        assert_eq!(end.recv_timeout(patience), Ok(true), "the executor ends");
    }

    #[test]
    fn a_second_spinner_is_refused_and_a_wake_from_another_thread_is_prompt() {
        let executor = Executor::new().expect("a poll");
        let shutdown = Shutdown::new();
        let spinner = std::thread::spawn({
            let (executor, shutdown) = (Arc::clone(&executor), shutdown.clone());
            move || executor.spin(&shutdown)
        });
        let (sender, receiver) = mpsc::channel();
        executor.post(Box::new(move || sender.send(Instant::now()).expect("the receiver lives")));
        receiver.recv_timeout(Duration::from_secs(5)).expect("the job runs");
        assert!(!executor.spin(&Shutdown::new()), "two threads spin");
        assert!(!executor.is_current_thread());
        shutdown.request();
        assert!(spinner.join().expect("no panic"));
    }
}
