// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Threads whose death is seen: a panic in a thread of a node is reported, takes the node to its error state and ends the process.
//!
//! A thread that dies silently leaves a node that looks alive and never answers. Every thread that does a node's work is therefore started by the
//! node's [`Supervisor`]. When one of them panics, the supervisor keeps what it said, calls its hooks (log, life cycle, diagnostics), and asks the
//! process to end with [`EXIT_CODE`], by itself if an orderly end takes longer than five seconds.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Exit code of a process in which a thread panicked: that of Rust's own main thread.
pub const EXIT_CODE: u8 = 101;

/// Maximum time of an orderly end after a thread died.
const PATIENCE: Duration = Duration::from_secs(5);

/// A thread of this process died.
static DIED: AtomicBool = AtomicBool::new(false);

/// Requests an orderly end of the process; a process without one is not ended here.
static ORDERLY_END: OnceLock<fn()> = OnceLock::new();

/// Names what requests an orderly end of the process after a thread died; only the first call counts.
pub fn end_with(end: fn()) {
    let _already_set = ORDERLY_END.set(end);
}

type Hook = Box<dyn Fn(&str) + Send + Sync>;

#[derive(Default)]
struct Inner {
    fault: OnceLock<String>,
    hooks: Mutex<Vec<Arc<Hook>>>,
}

/// Starts threads and sees them die. Clones are the same supervisor.
#[derive(Clone, Default)]
pub struct Supervisor {
    inner: Arc<Inner>,
}

impl std::fmt::Debug for Supervisor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Supervisor").field("fault", &self.inner.fault.get()).finish_non_exhaustive()
    }
}

impl Supervisor {
    /// Starts a named thread; its value is `None` where it panicked.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn spawn<T: Send + 'static>(
        &self,
        name: &str,
        body: impl FnOnce() -> T + Send + 'static,
    ) -> std::io::Result<JoinHandle<Option<T>>> {
        let (supervisor, of) = (self.clone(), name.to_owned());
        std::thread::Builder::new().name(name.to_owned()).spawn(move || supervisor.run(&of, body))
    }

    /// Runs something on this thread, and reports its panic.
    pub fn run<T>(&self, thread: &str, body: impl FnOnce() -> T) -> Option<T> {
        // What the panic left half changed is used for a farewell at most: the process ends.
        match catch_unwind(AssertUnwindSafe(body)) {
            Ok(value) => Some(value),
            Err(panic) => {
                self.report(thread, panic.as_ref());
                None
            }
        }
    }

    /// Panic of a thread, if one died.
    #[must_use]
    pub fn fault(&self) -> Option<&str> {
        self.inner.fault.get().map(String::as_str)
    }

    /// Calls `hook` with a sentence when the first thread dies, on that thread.
    pub fn on_fault(&self, hook: impl Fn(&str) + Send + Sync + 'static) {
        self.inner.hooks.lock().unwrap_or_else(PoisonError::into_inner).push(Arc::new(Box::new(hook)));
    }

    fn report(&self, thread: &str, panic: &(dyn Any + Send)) {
        let message =
            panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
        let message = message.unwrap_or("no message");
        let fault = format!(
            "thread {thread} was ended by a defect ({message}); the node no longer works and its process ends: restart it, and report this"
        );
        if self.inner.fault.set(fault.clone()).is_err() {
            return;
        }
        let hooks = self.inner.hooks.lock().unwrap_or_else(PoisonError::into_inner).clone();
        for hook in hooks {
            // The others are called all the same, and the process ends all the same.
            drop(catch_unwind(AssertUnwindSafe(|| hook(&fault))));
        }
        end_process(&fault);
    }
}

/// Asks the process for an orderly end, if it is one of ours that waits for signals, and ends it if that takes too long.
fn end_process(fault: &str) {
    DIED.store(true, Ordering::Release);
    let Some(end) = ORDERLY_END.get() else { return };
    eprintln!("{fault}");
    let overdue = Instant::now() + PATIENCE;
    let watchdog = std::thread::Builder::new().name("watchdog".into()).spawn(move || {
        while let Some(left) = overdue.checked_duration_since(Instant::now()) {
            std::thread::park_timeout(left);
        }
        std::process::exit(i32::from(EXIT_CODE));
    });
    if watchdog.is_err() {
        std::process::exit(i32::from(EXIT_CODE));
    }
    end();
}

/// Returns whether a thread of this process died.
#[must_use]
pub fn died() -> bool {
    DIED.load(Ordering::Acquire)
}

/// Exit code that the process must end with because a thread died.
#[must_use]
pub fn exit_code() -> Option<std::process::ExitCode> {
    died().then(|| EXIT_CODE.into())
}

/// Panics in a thread on purpose, for tests. Builds without debug assertions have none of it, and nothing but the environment of the process or a
/// test in it asks for it.
pub mod injected {
    use super::{AtomicU64, Ordering};

    static WANTED: AtomicU64 = AtomicU64::new(0);

    /// Environment variable that names the thread, for tests of whole processes.
    pub const VARIABLE: &str = "CAMWRIGHT_TEST_PANIC";

    /// Takes what the environment asks for.
    pub fn from_environment() {
        if cfg!(debug_assertions)
            && let Ok(thread) = std::env::var(VARIABLE)
        {
            ask(&thread);
        }
    }

    /// The thread of this name panics at its next piece of work, once.
    pub fn ask(thread: &str) {
        WANTED.store(hash(thread), Ordering::Release);
    }

    /// Marks the start of a thread's next piece of work.
    ///
    /// # Panics
    /// A test asked for it.
    #[inline]
    pub fn point(thread: &str) {
        if cfg!(debug_assertions) && WANTED.load(Ordering::Relaxed) != 0 {
            let own = hash(thread);
            let asked = WANTED.compare_exchange(own, 0, Ordering::AcqRel, Ordering::Relaxed).is_ok();
            assert!(!asked, "a test asked for it");
        }
    }

    /// FNV-1a, never 0.
    fn hash(name: &str) -> u64 {
        name.bytes()
            .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
            | 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[test]
    fn a_panic_is_kept_and_reported_once() {
        let supervisor = Supervisor::default();
        let (sender, reports) = mpsc::channel();
        supervisor.on_fault(|_| panic!("a hook that panics keeps nobody from the rest"));
        supervisor.on_fault(move |fault| drop(sender.send(fault.to_owned())));
        for thread in ["first", "second"] {
            let handle = supervisor.spawn(thread, || panic!("{}", 1 + 1)).expect("a thread");
            assert!(handle.join().expect("the panic was caught").is_none());
        }
        let fault = reports.recv().expect("a report");
        assert!(fault.starts_with("thread first was ended by a defect (2);"), "{fault}");
        assert_eq!(supervisor.fault(), Some(fault.as_str()));
        assert!(reports.try_recv().is_err(), "the first is the cause");
    }

    #[test]
    fn what_does_not_panic_gives_its_value() {
        let supervisor = Supervisor::default();
        assert_eq!(supervisor.spawn("sum", || 1 + 1).expect("a thread").join().expect("no panic"), Some(2));
        assert_eq!(supervisor.fault(), None);
    }
}
