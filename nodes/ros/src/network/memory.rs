// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The last resort against datagrams that make `RustDDS` allocate without bound.

use rlimit::{Resource, getrlimit, setrlimit};

/// A node of the largest cell needs less.
const MIN_OCTETS: u64 = 2 << 30;

/// Limits this process to half of the computer's memory, at least 2 GiB. An allocation beyond that aborts the process, with a message, before
/// the computer is out of memory and the kernel ends a process of its own choice.
pub fn limit_memory() {
    let Some(half) = total_octets().map(|total| total / 2) else { return };
    let Ok((soft, hard)) = getrlimit(Resource::DATA) else { return };
    let limit = half.max(MIN_OCTETS).min(hard);
    if limit < soft {
        // Without the limit everything works as with it.
        let _ = setrlimit(Resource::DATA, limit, hard);
    }
}

fn total_octets() -> Option<u64> {
    let memory = std::fs::read_to_string("/proc/meminfo").ok()?;
    let total = memory.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    total.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}
