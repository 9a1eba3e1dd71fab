// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Child processes that do not outlive their test.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Time after which a test gives up waiting. Much more than anything takes: a busy machine is not a defect.
pub const PATIENCE: Duration = Duration::from_secs(90);

/// A child process with its standard output line by line; killed when this is dropped.
#[derive(Debug)]
pub struct Guarded {
    name: String,
    child: Child,
    lines: Receiver<String>,
    stderr: Arc<Mutex<String>>,
    /// Disconnects when stderr is closed and read.
    stderr_closed: Receiver<()>,
}

impl Guarded {
    /// Starts the command with piped input and output; what it writes to stderr is kept and shown when something goes wrong.
    ///
    /// # Panics
    /// When it cannot be started.
    pub fn start(name: &str, command: &mut Command) -> Self {
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("cannot start {name} ({command:?}): {error}"));
        let stdout = child.stdout.take().expect("stdout is piped");
        let (send, lines) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(stdout).lines().map_while(Result::ok) {
                if send.send(line).is_err() {
                    break;
                }
            }
        });
        let stderr = Arc::new(Mutex::new(String::new()));
        let (mut from, into) = (child.stderr.take().expect("stderr is piped"), Arc::clone(&stderr));
        let (open, stderr_closed) = channel();
        std::thread::spawn(move || {
            let _open = open;
            let mut buffer = [0; 4096];
            while let Ok(n @ 1..) = from.read(&mut buffer) {
                into.lock().expect("nobody panics with this lock").push_str(&String::from_utf8_lossy(&buffer[..n]));
            }
        });
        Self { name: name.to_owned(), child, lines, stderr, stderr_closed }
    }

    /// The next line of its output; `None` when it has closed its output.
    ///
    /// # Panics
    /// After `patience`.
    pub fn line(&mut self, patience: Duration) -> Option<String> {
        match self.lines.recv_timeout(patience) {
            Ok(line) => Some(line),
            Err(RecvTimeoutError::Disconnected) => None,
            Err(RecvTimeoutError::Timeout) => panic!("{} said nothing for {patience:?}{}", self.name, self.complaint()),
        }
    }

    /// The next line of its output if it comes within this time.
    pub fn line_within(&mut self, time: Duration) -> Option<String> {
        self.lines.recv_timeout(time).ok()
    }

    /// Everything it still says until it closes its output.
    pub fn remaining_lines(&mut self, patience: Duration) -> Vec<String> {
        std::iter::from_fn(|| self.line(patience)).collect()
    }

    /// Its process id.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// The child's standard input.
    ///
    /// # Panics
    /// When it has been taken before.
    pub fn take_stdin(&mut self) -> std::process::ChildStdin {
        self.child.stdin.take().expect("taken once")
    }

    /// Content of stderr so far.
    pub fn stderr(&self) -> String {
        self.stderr.lock().expect("nobody panics with this lock").clone()
    }

    /// Returns whether it is still running.
    pub fn is_running(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    /// Sends SIGINT, as Ctrl-C does. Through the `kill` of the system: signals from Rust need unsafe code.
    pub fn interrupt(&self) {
        self.signal("INT");
    }

    /// Sends SIGTERM.
    pub fn terminate(&self) {
        self.signal("TERM");
    }

    /// Sends a signal by its name.
    pub fn signal(&self, signal: &str) {
        let sent = Command::new("kill").args([format!("-{signal}"), self.child.id().to_string()]).status();
        assert!(sent.is_ok_and(|status| status.success()), "cannot signal {}", self.name);
    }

    /// Waits for its end and, unless a child of its own still has it open, for the end of its stderr.
    ///
    /// # Panics
    /// After `patience`.
    pub fn wait(&mut self, patience: Duration) -> ExitStatus {
        let deadline = Instant::now() + patience;
        loop {
            if let Some(status) = self.child.try_wait().expect("a child can be waited for") {
                // Disconnected or timed out: what has arrived until then is its stderr.
                let _ = self.stderr_closed.recv_timeout(Duration::from_secs(5));
                return status;
            }
            assert!(Instant::now() < deadline, "{} did not end within {patience:?}{}", self.name, self.complaint());
            // The standard library has no wait with a deadline; the end of a process is polled.
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Content of stderr, for a panic message.
    pub fn complaint(&self) -> String {
        let stderr = self.stderr();
        if stderr.is_empty() { String::new() } else { format!("; its stderr:\n{stderr}") }
    }
}

impl Drop for Guarded {
    fn drop(&mut self) {
        // Errors mean that it has ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
        if std::thread::panicking() {
            eprintln!("--- {} said on stderr:\n{}", self.name, self.stderr());
        }
    }
}
