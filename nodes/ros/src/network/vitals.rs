// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Threads of `RustDDS`, and the sockets they read.

use super::descriptors::UdpSocket;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;
use std::{fs, io};

/// Threads of a participant and the sockets they read.
#[derive(Debug, Default)]
pub(crate) struct Vitals {
    pub(super) threads: BTreeSet<u32>,
    pub(super) readers: Arc<Vec<UdpSocket>>,
}

impl Vitals {
    /// Time for which all its threads together have waited for a processor; 0 where the kernel does not count it.
    pub(super) fn waited_for_processor(&self) -> Duration {
        let waited_ns = self.threads.iter().filter_map(|thread| {
            let text = fs::read_to_string(format!("/proc/self/task/{thread}/schedstat")).ok()?;
            text.split_whitespace().nth(1)?.parse::<u64>().ok()
        });
        Duration::from_nanos(waited_ns.sum())
    }
}

/// The threads of `RustDDS` in this process.
pub(super) fn threads() -> io::Result<BTreeSet<u32>> {
    let mut threads = BTreeSet::new();
    for entry in fs::read_dir("/proc/self/task")? {
        let entry = entry?;
        let Some(id) = entry.file_name().to_str().and_then(|name| name.parse().ok()) else { continue };
        if is_rustdds(id) {
            threads.insert(id);
        }
    }
    Ok(threads)
}

/// Returns true if a thread of `RustDDS` with this id runs in this process.
pub(super) fn is_rustdds(thread: u32) -> bool {
    fs::read_to_string(format!("/proc/self/task/{thread}/comm")).is_ok_and(|name| name.starts_with("RustDDS"))
}
