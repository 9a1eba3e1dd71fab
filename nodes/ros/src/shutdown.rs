// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Shutdown requests, and the signals that make them.

use camwright_threads::supervised;
use std::{
    fmt,
    sync::{
        Arc, Condvar, Mutex, OnceLock, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use signal_hook::{
    consts::{SIGINT, SIGTERM},
    iterator::Signals,
};

use super::error::RosError;

type Hook = Box<dyn Fn() + Send>;

#[derive(Default)]
struct Inner {
    requested: AtomicBool,
    hooks: Mutex<(u64, Vec<(u64, Hook)>)>,
    guard: Mutex<()>,
    changed: Condvar,
}

/// The request of this process, see [`Shutdown::on_signals`].
static ON_SIGNALS: OnceLock<Shutdown> = OnceLock::new();

/// Failure of this process, see [`Shutdown::fail_process`].
static FAILURE: OnceLock<String> = OnceLock::new();

/// Exit code of a process that could not go on (`EX_SOFTWARE`).
pub const EXIT_FAILED: u8 = 70;

/// Time for an orderly end after a failure: nodes leave the graph and the recorder closes its bag.
const ORDERLY_END: Duration = Duration::from_secs(10);

/// Request to shut down. Clones are the same request.
#[derive(Clone, Default)]
pub struct Shutdown {
    inner: Arc<Inner>,
}

impl fmt::Debug for Shutdown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Shutdown").field("requested", &self.is_requested()).finish()
    }
}

impl Shutdown {
    /// Creates a request that is not made yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The request that SIGINT and SIGTERM make: one per process. The first signal asks for an orderly end; a second one ends the
    /// process at once with 128 + its number, for a user whose orderly end hangs.
    ///
    /// # Errors
    /// The operating system refuses the handlers.
    pub fn on_signals() -> Result<Self, RosError> {
        if let Some(shutdown) = ON_SIGNALS.get() {
            return Ok(shutdown.clone());
        }
        let failed = |source| RosError::Io { what: "cannot handle SIGINT and SIGTERM".into(), source };
        let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(failed)?;
        let shutdown = Shutdown::new();
        let requested = shutdown.clone();
        std::thread::Builder::new()
            .name("signals".into())
            .spawn(move || {
                for signal in signals.forever() {
                    if requested.is_requested() {
                        std::process::exit(128 + signal);
                    }
                    requested.request();
                }
            })
            .map_err(failed)?;
        let shutdown = ON_SIGNALS.get_or_init(|| shutdown).clone();
        supervised::end_with(|| {
            if let Some(shutdown) = ON_SIGNALS.get() {
                shutdown.request();
            }
        });
        Ok(shutdown)
    }

    /// Asks for an orderly end of this process because it cannot go on, and ends it with [`EXIT_FAILED`] if that takes longer than 10 s.
    /// Without [`Shutdown::on_signals`], the caller ends the nodes.
    pub(super) fn fail_process(reason: &str) {
        let first = FAILURE.set(reason.to_owned()).is_ok();
        let Some(shutdown) = ON_SIGNALS.get() else { return };
        shutdown.request();
        if first {
            let end = move || {
                std::thread::sleep(ORDERLY_END);
                std::process::exit(i32::from(EXIT_FAILED));
            };
            // Without the thread the orderly end remains.
            let _ = std::thread::Builder::new().name("forced end".into()).spawn(end);
        }
    }

    /// Returns true if this process has failed.
    pub fn has_failed() -> bool {
        FAILURE.get().is_some()
    }

    /// The exit code of this process: [`EXIT_FAILED`] after a failure, otherwise the given one.
    pub fn exit_code(code: std::process::ExitCode) -> std::process::ExitCode {
        if Self::has_failed() { EXIT_FAILED.into() } else { code }
    }

    /// Makes the request and wakes all waiting threads.
    pub fn request(&self) {
        self.inner.requested.store(true, Ordering::Release);
        drop(self.inner.guard.lock().unwrap_or_else(PoisonError::into_inner));
        self.inner.changed.notify_all();
        for (_, hook) in &self.inner.hooks.lock().unwrap_or_else(PoisonError::into_inner).1 {
            hook();
        }
    }

    /// Returns true after the request.
    pub fn is_requested(&self) -> bool {
        self.inner.requested.load(Ordering::Acquire)
    }

    /// Waits for the request.
    pub fn wait(&self) {
        let mut guard = self.inner.guard.lock().unwrap_or_else(PoisonError::into_inner);
        while !self.is_requested() {
            guard = self.inner.changed.wait(guard).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Waits for the request; returns false after the timeout.
    pub fn wait_timeout(&self, timeout: Duration) -> bool {
        let deadline = Instant::now() + timeout;
        let mut guard = self.inner.guard.lock().unwrap_or_else(PoisonError::into_inner);
        while !self.is_requested() {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            guard = self.inner.changed.wait_timeout(guard, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        true
    }

    /// Calls `hook` when the request is made (at once if it already is), until the returned value is dropped. The hook must not
    /// block and must not call this object.
    pub fn on_request(&self, hook: impl Fn() + Send + 'static) -> ShutdownHook {
        let mut hooks = self.inner.hooks.lock().unwrap_or_else(PoisonError::into_inner);
        if self.is_requested() {
            hook();
        }
        hooks.0 += 1;
        let id = hooks.0;
        hooks.1.push((id, Box::new(hook)));
        ShutdownHook { inner: Arc::clone(&self.inner), id }
    }
}

/// Keeps a hook of [`Shutdown::on_request`] in place.
#[must_use = "dropping it removes the hook"]
pub struct ShutdownHook {
    inner: Arc<Inner>,
    id: u64,
}

impl fmt::Debug for ShutdownHook {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ShutdownHook").field("id", &self.id).finish()
    }
}

impl Drop for ShutdownHook {
    fn drop(&mut self) {
        self.inner.hooks.lock().unwrap_or_else(PoisonError::into_inner).1.retain(|(id, _)| *id != self.id);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_waiter_is_woken_and_a_dropped_hook_is_not_called() {
        let shutdown = Shutdown::new();
        assert!(!shutdown.wait_timeout(Duration::from_millis(1)));
        let called = Arc::new(AtomicBool::new(false));
        let seen = Arc::clone(&called);
        drop(shutdown.on_request(move || seen.store(true, Ordering::SeqCst)));
        let waiter = std::thread::spawn({
            let shutdown = shutdown.clone();
            move || shutdown.wait()
        });
        shutdown.request();
        waiter.join().expect("the waiter does not panic");
        assert!(!called.load(Ordering::SeqCst));
        let seen = Arc::clone(&called);
        let _hook = shutdown.on_request(move || seen.store(true, Ordering::SeqCst));
        assert!(called.load(Ordering::SeqCst), "a hook set after the request is called at once");
    }
}
