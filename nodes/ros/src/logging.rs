// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Logs: on stderr as ROS prints them, and on `/rosout`.

use std::{
    cell::RefCell,
    fmt::{self, Write as _},
    marker::PhantomData,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicU8, Ordering},
    },
};

use camwright_msgs::rcl_interfaces::msg::Log;
use tracing::{Event, Subscriber, field::Field};
use tracing_subscriber::{Layer, layer::Context, layer::SubscriberExt, util::SubscriberInitExt};

use super::args::RosArgs;
use super::clock::to_time;
use super::error::RosError;
use super::level::Level;
use super::names::NodeNames;
use camwright_threads::system_time::system_time_ns;

/// Publishes the lines of a logger.
pub(super) trait Outlet: Send + Sync {
    /// Time of a line.
    fn now_ns(&self) -> i64;
    fn publish(&self, log: &Log) -> Result<(), RosError>;
}

struct Inner {
    name: String,
    threshold: AtomicU8,
    /// Level of the command line.
    usual: Level,
    /// Lowest level on the terminal; none without a terminal log.
    console: Option<Level>,
    rosout: bool,
    outlet: Mutex<Option<Arc<dyn Outlet>>>,
}

/// A node's logger. Clones are the same logger.
#[derive(Clone)]
pub struct Logger {
    inner: Arc<Inner>,
}

impl fmt::Debug for Logger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Logger").field("name", &self.inner.name).finish_non_exhaustive()
    }
}

/// Origin of a log line.
#[derive(Debug, Clone, Copy, Default)]
struct Origin<'a> {
    file: &'a str,
    function: &'a str,
    line: u32,
}

impl Logger {
    pub(super) fn new(names: &NodeNames, args: &RosArgs) -> Self {
        let name = names.logger();
        let usual = args.level_of(&name);
        let threshold = AtomicU8::new(usual as u8);
        Logger {
            inner: Arc::new(Inner {
                name,
                threshold,
                usual,
                console: args.console(),
                rosout: args.rosout(),
                outlet: Mutex::default(),
            }),
        }
    }

    /// Returns true if the arguments ask for `/rosout`.
    pub(super) fn uses_rosout(&self) -> bool {
        self.inner.rosout
    }

    pub(super) fn connect(&self, outlet: Arc<dyn Outlet>) {
        *self.outlet() = Some(outlet);
    }

    /// Makes this the logger of threads that entered none, unless another node's is.
    pub(super) fn serve_process(&self) {
        let mut first = FIRST.lock().unwrap_or_else(PoisonError::into_inner);
        if first.is_none() {
            *first = Some(self.clone());
        }
    }

    pub(super) fn detach(&self) {
        let outlet = self.outlet().take();
        drop(outlet);
        let mut first = FIRST.lock().unwrap_or_else(PoisonError::into_inner);
        if first.as_ref().is_some_and(|first| Arc::ptr_eq(&first.inner, &self.inner)) {
            *first = None;
        }
    }

    fn outlet(&self) -> std::sync::MutexGuard<'_, Option<Arc<dyn Outlet>>> {
        self.inner.outlet.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Name of the logger, `cell.machine_sim`.
    pub fn name(&self) -> &str {
        &self.inner.name
    }

    /// Lets through only this level and above; unset is the level of the start.
    pub fn set_level(&self, level: Level) {
        let level = if level == Level::Unset { self.inner.usual } else { level };
        self.inner.threshold.store(level as u8, Ordering::Relaxed);
    }

    /// Lowest level that is let through.
    pub fn level(&self) -> Level {
        Level::from_number(u32::from(self.inner.threshold.load(Ordering::Relaxed))).unwrap_or(self.inner.usual)
    }

    /// Returns true if lines of a level are logged.
    pub fn is_enabled(&self, level: Level) -> bool {
        level as u8 >= self.inner.threshold.load(Ordering::Relaxed)
    }

    #[track_caller]
    pub fn log(&self, level: Level, text: &str) {
        let caller = std::panic::Location::caller();
        self.write(level, text, Origin { file: caller.file(), function: "", line: caller.line() });
    }

    /// Logs what a developer wants to know.
    #[track_caller]
    pub fn debug(&self, text: &str) {
        self.log(Level::Debug, text);
    }

    /// Logs what an operator likes to know.
    #[track_caller]
    pub fn info(&self, text: &str) {
        self.log(Level::Info, text);
    }

    /// Logs what an operator should look at.
    #[track_caller]
    pub fn warn(&self, text: &str) {
        self.log(Level::Warn, text);
    }

    /// Logs what did not work.
    #[track_caller]
    pub fn error(&self, text: &str) {
        self.log(Level::Error, text);
    }

    fn write(&self, level: Level, text: &str, origin: Origin<'_>) {
        if !self.is_enabled(level) {
            return;
        }
        let outlet = self.outlet().clone();
        let now_ns = outlet.as_ref().map_or_else(system_time_ns, |outlet| outlet.now_ns());
        if self.inner.console.is_some_and(|lowest| level >= lowest) {
            print(level, now_ns, &self.inner.name, text);
        }
        if let Some(outlet) = outlet {
            let log = Log {
                stamp: to_time(now_ns),
                level: level as u8,
                name: self.inner.name.clone(),
                msg: text.to_string(),
                file: origin.file.to_string(),
                function: origin.function.to_string(),
                line: origin.line,
            };
            if let Err(error) = outlet.publish(&log) {
                // Not through the logger: that would come back here.
                print(Level::Warn, now_ns, &self.inner.name, &error.to_string());
            }
        }
    }

    /// Makes this the logger of the current thread: what `tracing` says there until the returned value is dropped is this node's.
    pub fn enter(&self) -> CurrentLogger {
        CURRENT.with_borrow_mut(|stack| stack.push(self.clone()));
        CurrentLogger { not_send: PhantomData }
    }
}

fn print(level: Level, now_ns: i64, name: &str, text: &str) {
    let (sec, nanosec) = (now_ns.div_euclid(1_000_000_000), now_ns.rem_euclid(1_000_000_000));
    eprintln!("[{}] [{sec}.{nanosec:09}] [{name}]: {text}", level.name());
}

/// The logger of threads that entered none.
static FIRST: Mutex<Option<Logger>> = Mutex::new(None);

thread_local! {
    static CURRENT: RefCell<Vec<Logger>> = const { RefCell::new(Vec::new()) };
}

/// The current thread's logger, until dropped. The executor thread of a node has its node's.
#[derive(Debug)]
#[must_use = "dropping it ends it"]
pub struct CurrentLogger {
    not_send: PhantomData<*const ()>,
}

impl Drop for CurrentLogger {
    fn drop(&mut self) {
        CURRENT.with_borrow_mut(|stack| drop(stack.pop()));
    }
}

/// Layer for `tracing`: passes events to the logger of the current thread, else to that of the process's first node, else to stderr.
#[derive(Debug, Clone, Copy, Default)]
pub struct RosLayer;

impl RosLayer {
    /// Makes `tracing` speak ROS in this process. Does nothing if a subscriber is set already.
    pub fn install() {
        let _ = tracing_subscriber::registry().with(RosLayer).try_init();
    }
}

#[derive(Default)]
struct Text {
    message: String,
    fields: String,
}

impl tracing::field::Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        // Writing to a String cannot fail.
        let _ = if field.name() == "message" {
            write!(self.message, "{value:?}")
        } else {
            write!(self.fields, " {}={value:?}", field.name())
        };
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        let _ = if field.name() == "message" {
            write!(self.message, "{value}")
        } else {
            write!(self.fields, " {}={value}", field.name())
        };
    }
}

impl<S: Subscriber> Layer<S> for RosLayer {
    fn on_event(&self, event: &Event<'_>, _context: Context<'_, S>) {
        let metadata = event.metadata();
        let level = Level::from(*metadata.level());
        // Cloned, so that a callback which logs while logging finds no lock held.
        let logger = CURRENT
            .with_borrow(|stack| stack.last().cloned())
            .or_else(|| FIRST.lock().unwrap_or_else(PoisonError::into_inner).clone());
        if logger.as_ref().map_or(level < Level::Info, |logger| !logger.is_enabled(level)) {
            return;
        }
        let mut text = Text::default();
        event.record(&mut text);
        text.message.push_str(&text.fields);
        match logger {
            Some(logger) => {
                let origin = Origin {
                    file: metadata.file().unwrap_or_default(),
                    function: metadata.module_path().unwrap_or_default(),
                    line: metadata.line().unwrap_or_default(),
                };
                logger.write(level, &text.message, origin);
            }
            None => print(level, system_time_ns(), metadata.target(), &text.message),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_have_ros_numbers_and_names_in_any_case() {
        assert_eq!(Level::from_name("wArN"), Some(Level::Warn));
        assert_eq!(Level::from_name("loud"), None);
        assert_eq!(Level::Fatal as u8, Log::FATAL);
        assert_eq!((Level::from_number(30), Level::from_number(35)), (Some(Level::Warn), None));
        assert_eq!(Level::Info as u8, Log::INFO);
        assert!(Level::Debug < Level::Info);
    }
}
