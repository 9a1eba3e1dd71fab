// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Runs a command within limits of time and memory, and says how it ended.

use std::fmt;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Processor time that a command may take (s): twice that of the longest shipped job with all its plots in a debug build.
pub const MAX_CPU_S: u64 = 15;
/// Address space that a command may have (kB); what it fills of that is less.
pub const MAX_KB: u64 = 1 << 20;
/// Time by the clock: a busy computer is not a defect, a command that waits for nothing is one.
const MAX_WALL: Duration = Duration::from_secs(120);
/// Characters that are kept of what a command says.
const KEPT: usize = 4000;

/// End of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum End {
    /// Regular: 0, or 1 to 3 with a sentence.
    Rule(i32),
    /// It failed without a word.
    Silent,
    /// It panicked, or died by a signal.
    Panic,
    /// It took too long.
    Hang,
    /// It asked for too much memory.
    Memory,
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            End::Rule(code) => write!(f, "exit {code}"),
            End::Silent => f.write_str("silent"),
            End::Panic => f.write_str("panic"),
            End::Hang => f.write_str("hang"),
            End::Memory => f.write_str("memory"),
        }
    }
}

/// Result of a command.
#[derive(Debug)]
pub struct Outcome {
    pub end: End,
    pub seconds: f64,
    pub output: String,
}

/// Runs the program in a folder.
pub fn run(program: &Path, arguments: &[String], folder: &Path) -> Outcome {
    let begun = Instant::now();
    // Limits of a process are set by its shell: from Rust they need unsafe code.
    let limits = format!("ulimit -v {MAX_KB}; ulimit -t {MAX_CPU_S}; ulimit -c 0; exec \"$0\" \"$@\"");
    let mut child = Command::new("sh")
        .args(["-c", &limits])
        .arg(program)
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .env("RUST_BACKTRACE", "1")
        .spawn()
        .expect("a shell");
    let read = |mut pipe: Box<dyn Read + Send>| {
        std::thread::spawn(move || {
            let (mut output, mut buffer) = (Vec::new(), [0; 4096]);
            while let Ok(length @ 1..) = pipe.read(&mut buffer) {
                if output.len() < KEPT {
                    output.extend_from_slice(&buffer[..length]);
                }
            }
            output
        })
    };
    let stdout = read(Box::new(child.stdout.take().expect("piped")));
    let stderr = read(Box::new(child.stderr.take().expect("piped")));
    let mut is_late = false;
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child can be waited for") {
            break status;
        }
        if begun.elapsed() > MAX_WALL {
            is_late = true;
            let _ended = child.kill();
        }
        // The standard library has no wait with a deadline; the end of a process is polled.
        std::thread::sleep(Duration::from_millis(2));
    };
    let output = [stderr.join().unwrap_or_default(), stdout.join().unwrap_or_default()].concat();
    let output = String::from_utf8_lossy(&output).into_owned();
    let end = match status.code() {
        _ if is_late => End::Hang,
        _ if output.contains("memory allocation of") || output.contains("capacity overflow") => End::Memory,
        _ if output.contains("panicked at") => End::Panic,
        Some(code @ 0..=3) if code == 0 || !output.trim().is_empty() => End::Rule(code),
        Some(0..=3) => End::Silent,
        // SIGXCPU, and SIGKILL where that is not heard.
        None if begun.elapsed() > Duration::from_secs(MAX_CPU_S - 1) => End::Hang,
        _ => End::Panic,
    };
    Outcome { end, seconds: begun.elapsed().as_secs_f64(), output }
}
