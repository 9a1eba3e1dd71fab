// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Resources used by a process, as Linux reports them.

use std::collections::BTreeSet;
use std::fs;

/// Linux counts processor time in hundredths of a second, on every processor.
const TICKS_PER_S: f64 = 100.0;

/// Processor time of a process and its threads (s); 0 when it is gone.
pub fn cpu_s(process: u32) -> f64 {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    // Behind the name, which may hold anything: the state, then ten numbers, then the times of user and system.
    let behind = stat.rsplit_once(')').map_or("", |(_, rest)| rest);
    behind.split_whitespace().skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / TICKS_PER_S
}

/// Most memory that a process has had at a time (kB).
pub fn peak_kb(process: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or_default();
    line.split_whitespace().next().and_then(|kb| kb.parse().ok()).unwrap_or(0)
}

/// Datagrams that the system threw away because a socket of the process had no room for them.
pub fn datagrams_dropped(process: u32) -> u64 {
    let sockets: BTreeSet<String> = fs::read_dir(format!("/proc/{process}/fd"))
        .into_iter()
        .flatten()
        .filter_map(|entry| fs::read_link(entry.ok()?.path()).ok())
        .filter_map(|link| Some(link.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?.to_owned()))
        .collect();
    let table = fs::read_to_string("/proc/net/udp").unwrap_or_default();
    let rows = table.lines().skip(1).map(|row| row.split_whitespace().collect::<Vec<_>>());
    let mine = rows.filter(|row| row.get(9).is_some_and(|inode| sockets.contains(*inode)));
    mine.filter_map(|row| row.last()?.parse::<u64>().ok()).sum()
}
