// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Values that the cyclic thread and the rest of the node share without a message.

use camwright_threads::drops::DropCounter;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};

/// Commands that may wait for their tick.
pub const PENDING_COMMANDS: usize = 32;

/// Values shared with the cyclic thread.
#[derive(Debug, Default)]
pub struct Bounds {
    /// A recording is active.
    pub recording: AtomicBool,
    /// Last tick that is in the bag.
    pub recorded_tick: AtomicU64,
    /// Messages of the recorder so far.
    pub recorder_messages: AtomicU64,
    /// Telemetry that was dropped.
    pub drops: DropCounter,
    /// The node is ending.
    pub stop: AtomicBool,
    /// For diagnostics: the last tick, ticks that began more than a period late, active alarms that stop motion.
    pub tick: AtomicU64,
    pub late_ticks: AtomicU64,
    /// Maximum delay of a late tick since the last read (µs).
    pub worst_late_us: AtomicU64,
    /// Ticks between the arrival of a chunk and its first setpoint's, the least since that was asked last.
    pub min_lead_ticks: AtomicU64,
    pub alarms: AtomicU64,
    /// Setpoints of a client are being executed.
    pub in_motion: AtomicBool,
    /// Slips of the machine's time against the system clock since the start, and by how much it is behind now (µs).
    pub slips: AtomicU64,
    pub behind_us: AtomicI64,
    /// Longest time that the cycle was kept waiting since the start (µs).
    pub longest_pause_us: AtomicU64,
    pub bus: BusTiming,
}

/// Timing of the bus to real drives.
#[derive(Debug, Default)]
pub struct BusTiming {
    /// Setpoints that wait in its queue as a rule; 0: the machine is simulated.
    pub queue_ticks: AtomicU64,
    /// Setpoints in the queue: at the last servo period, and the least since that was read last.
    pub queued: AtomicU64,
    pub min_queued: AtomicU64,
    /// Largest deviation of a servo period from its length since that was read last (ns).
    pub max_jitter_ns: AtomicU64,
    /// Number of times that the queue ran empty, since the start.
    pub underruns: AtomicU64,
}

impl BusTiming {
    /// Names of its status in diagnostics, and of the figures there.
    pub const STATUS: &str = "drive_queue";
    pub const MIN_QUEUED: &str = "min_queued";
    pub const QUEUE_TICKS: &str = "queue_ticks";
    pub const MAX_JITTER_US: &str = "max_jitter_us";
    pub const UNDERRUNS: &str = "underruns";

    /// Records a servo period in which the drives followed.
    pub fn see(&self, queued: u32, jitter_ns: u32) {
        self.queued.store(queued.into(), Ordering::Relaxed);
        self.min_queued.fetch_min(queued.into(), Ordering::Relaxed);
        self.max_jitter_ns.fetch_max(jitter_ns.into(), Ordering::Relaxed);
    }
}
