//! Values that the cyclic thread and the rest of the node share without a message.

use camwright_threads::drops::DropCounter;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64};

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
}
