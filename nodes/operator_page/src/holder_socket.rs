// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Socket by which a process that has command performs operations for other processes of the same user.
//!
//! `camwright run` has command for the time of its job. `camwright resume` in another terminal of the same user passes its operation
//! through this socket. The file system keeps other users out: the folder belongs to the user and has mode 0700.
//!
//! ```text
//! client ── {"operation":"resume"}\n ──► server      an empty line at least every half second continues a motion
//! client ◄── {"done":true,"message":…}\n ── server
//! ```

use super::operation::{Answer, Operation};
use super::operator::Operator;
use camwright_threads::supervised::Supervisor;
use std::fs::{self, DirBuilder};
use std::io::{self, BufRead as _, BufReader, ErrorKind, Read as _, Write as _};
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Longest request (bytes).
const MAX_REQUEST: u64 = 4096;
/// Maximum time for a request to arrive, and for an answer to be read.
const PATIENCE: Duration = Duration::from_secs(3);
/// A motion ends after this time without a sign of life from its client.
const DEAD_MAN: Duration = Duration::from_millis(500);
/// Time between two signs of life.
const SIGN_OF_LIFE: Duration = Duration::from_millis(100);
/// Longest time of an operation.
const OPERATION: Duration = Duration::from_secs(600);

/// Path of the socket of a cell.
pub(crate) fn path(domain: u16, namespace: &str) -> PathBuf {
    let name: String = namespace.trim_matches('/').chars().map(|c| if c == '/' { '.' } else { c }).take(40).collect();
    folder().join(format!("{domain}-{name}.sock"))
}

/// Folder of the user for sockets.
fn folder() -> PathBuf {
    match std::env::var_os("XDG_RUNTIME_DIR").filter(|folder| !folder.is_empty()) {
        Some(folder) => Path::new(&folder).join("camwright"),
        None => std::env::temp_dir().join(format!("camwright-{}", user())),
    }
}

/// User of this process.
fn user() -> u32 {
    fs::metadata("/proc/self").map_or(u32::MAX, |process| process.uid())
}

/// Returns true for a folder of this user that others cannot enter.
fn is_private(folder: &Path) -> bool {
    fs::symlink_metadata(folder).is_ok_and(|found| found.is_dir() && found.uid() == user() && found.mode() & 0o077 == 0)
}

/// Socket that is served until it is dropped.
#[derive(Debug)]
pub struct HolderSocket {
    path: PathBuf,
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<Option<()>>>,
}

impl HolderSocket {
    /// Serves the socket of the operator's cell. The process must have command.
    ///
    /// # Errors
    /// The folder is not private, or another process serves the cell.
    pub fn serve(operator: &Operator, supervisor: &Supervisor) -> io::Result<Self> {
        let path = operator.socket().to_owned();
        let folder = path.parent().unwrap_or(Path::new("/"));
        match DirBuilder::new().mode(0o700).create(folder) {
            Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(error),
            _ => {}
        }
        if !is_private(folder) {
            let text = format!("{} must belong to you and have mode 0700; remove it", folder.display());
            return Err(io::Error::new(ErrorKind::PermissionDenied, text));
        }
        if UnixStream::connect(&path).is_ok() {
            return Err(io::Error::new(ErrorKind::AddrInUse, format!("another process serves {}", path.display())));
        }
        // Left over from a process that was killed.
        let _absent = fs::remove_file(&path);
        let listener = UnixListener::bind(&path)?;
        let is_over = Arc::new(AtomicBool::new(false));
        let (over, operator, of_requests) = (Arc::clone(&is_over), operator.clone(), supervisor.clone());
        let thread = supervisor.spawn("holder socket", move || {
            for stream in listener.incoming() {
                if over.load(Ordering::Acquire) {
                    return;
                }
                let Ok(stream) = stream else { continue };
                let operator = operator.clone();
                // Without a thread the connection is closed, and its client reports the refusal of the machine.
                let _started = of_requests.spawn("operation", move || drop(serve_one(stream, &operator)));
            }
        })?;
        Ok(Self { path, is_over, thread: Some(thread) })
    }
}

impl Drop for HolderSocket {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Release);
        // The thread waits for a connection.
        let _woken = UnixStream::connect(&self.path);
        if let Some(thread) = self.thread.take() {
            let _panicked = thread.join();
        }
        let _absent = fs::remove_file(&self.path);
    }
}

/// Serves one connection.
fn serve_one(mut stream: UnixStream, operator: &Operator) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut line = String::new();
    BufReader::new((&stream).take(MAX_REQUEST)).read_line(&mut line)?;
    let answer = match serde_json::from_str::<Operation>(line.trim_end()) {
        Ok(operation) => {
            let life = LifeSigns::watch(&stream)?;
            operator.ask_cell(&operation, &|| life.is_alive())
        }
        Err(error) => Answer::refused(format!("unknown operation: {error}")),
    };
    let text = serde_json::to_string(&answer).map_err(io::Error::other)?;
    writeln!(stream, "{text}")
}

/// Signs of life of a client.
struct LifeSigns<'a> {
    stream: &'a UnixStream,
    last: std::cell::Cell<Instant>,
}

impl<'a> LifeSigns<'a> {
    fn watch(stream: &'a UnixStream) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        Ok(Self { stream, last: std::cell::Cell::new(Instant::now()) })
    }

    /// Returns false after [`DEAD_MAN`] without a sign of life.
    fn is_alive(&self) -> bool {
        let mut signs = [0; 64];
        let mut stream = self.stream;
        if matches!(stream.read(&mut signs), Ok(count) if count > 0) {
            self.last.set(Instant::now());
        }
        self.last.get().elapsed() < DEAD_MAN
    }
}

impl Drop for LifeSigns<'_> {
    fn drop(&mut self) {
        let _closed = self.stream.set_nonblocking(false);
    }
}

/// Passes an operation to the process that serves a socket; `None`: no process of this user serves it.
pub(crate) fn ask(path: &Path, operation: &Operation, goes_on: &dyn Fn() -> bool) -> Option<Answer> {
    if !is_private(path.parent()?) {
        return None;
    }
    let stream = UnixStream::connect(path).ok()?;
    let lost = |error: io::Error| Answer::refused(format!("the process that has command does not answer: {error}"));
    Some(converse(stream, operation, goes_on).unwrap_or_else(lost))
}

fn converse(mut stream: UnixStream, operation: &Operation, goes_on: &dyn Fn() -> bool) -> io::Result<Answer> {
    stream.set_write_timeout(Some(PATIENCE))?;
    stream.set_read_timeout(Some(SIGN_OF_LIFE))?;
    let text = serde_json::to_string(operation).map_err(io::Error::other)?;
    writeln!(stream, "{text}")?;
    let deadline = Instant::now() + OPERATION;
    let mut answer = Vec::new();
    let mut chunk = [0; 1024];
    while !answer.ends_with(b"\n") {
        match stream.read(&mut chunk) {
            Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
            Ok(count) => answer.extend_from_slice(&chunk[..count]),
            Err(error)
                if [ErrorKind::WouldBlock, ErrorKind::TimedOut, ErrorKind::Interrupted].contains(&error.kind()) =>
            {
                if Instant::now() > deadline {
                    return Err(ErrorKind::TimedOut.into());
                }
                if goes_on() {
                    // The answer may be under way already, and the server closed.
                    let _sent = writeln!(stream);
                }
            }
            Err(error) => return Err(error),
        }
    }
    serde_json::from_slice(&answer).map_err(io::Error::other)
}
