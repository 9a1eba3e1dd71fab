// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Partners of the cyclic thread: the sender of setpoints and the recorder.

use super::bounds::Bounds;
use camwright_threads::silence::Silence;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Maximum delay of a present recorder at pace fast: a slow disk may need it.
const BEHIND: Duration = Duration::from_secs(10);
/// Longest silence unless a node says otherwise.
const USUAL: Duration = Duration::from_millis(2500);

/// The partners of the cyclic thread.
#[derive(Debug)]
pub struct MachinePartners {
    /// Who has command, while the machine waits for its setpoints.
    pub(super) sender: Silence,
    pub(super) recorder: Silence,
    /// The recorder is alive and makes no progress.
    pub(super) behind: Silence,
    /// Messages of the recorder, and the tick that it had recorded, at the last look.
    pub(super) recorder_messages: u64,
    pub(super) recorded_tick: u64,
    /// Ticks do not wait for the recorder.
    pub(super) is_recording_lost: bool,
    /// A motion is about to begin: no idle tick passes before its first setpoint.
    pub attends: bool,
    /// The feedback was repeated last.
    pub(super) repeated: Instant,
    /// The tick after which a machine that was deactivated rests.
    pub(super) halting: Option<u64>,
    /// The machine was deactivated and takes no chunk before it is active again.
    pub(super) is_closed: bool,
}

impl MachinePartners {
    pub fn new(limit: Duration) -> Self {
        Self {
            sender: Silence::new(limit),
            recorder: Silence::new(limit),
            behind: Silence::new(BEHIND),
            recorder_messages: 0,
            recorded_tick: 0,
            is_recording_lost: false,
            attends: false,
            repeated: Instant::now(),
            halting: None,
            is_closed: false,
        }
    }

    /// The holder of command has sent something.
    pub fn renew_sender(&mut self) {
        self.sender.reset();
    }

    /// Returns whether ticks wait for the recorder.
    pub fn waits_for_recorder(&self, bounds: &Bounds) -> bool {
        bounds.recording.load(Ordering::Acquire) && !self.is_recording_lost
    }
}

impl Default for MachinePartners {
    fn default() -> Self {
        Self::new(USUAL)
    }
}
