// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Reaction of the cyclic thread to partners that fall silent and to deactivation: a stop on the path, with an alarm.
//!
//! Silence is measured by the wall clock, outside of ticks. What follows from it enters the machine as a recorded input, so that a replay
//! takes it at the same tick.

use super::bounds::PENDING_COMMANDS;
use super::cyclic_loop::CyclicLoop;
use super::messages::CyclicInput;
use super::partners::MachinePartners;
use super::stream_state::StreamState;
use camwright::machine::alarm::{AlarmKind, AlarmSeverity};
use camwright_threads::silence::HEARTBEAT;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

impl CyclicLoop {
    /// With another limit of silence.
    pub fn with_silence_limit(mut self, limit: Duration) -> Self {
        self.partners = MachinePartners::new(limit);
        self
    }

    /// Raises an alarm that does not come from the machine itself.
    pub fn raise_outside(&mut self, kind: AlarmKind, value: f64) {
        self.report_applied(CyclicInput::Alarm(kind, value));
        self.machine.raise(kind, value, 0.0);
        if kind.entry().severity > AlarmSeverity::Warning {
            self.buffer.close();
            self.partners.attends = false;
        }
        self.state.news = true;
    }

    /// The machine waits, at pace fast: looks whether whom it waits for is still there, and repeats its feedback, so that a lost credit
    /// is sent again.
    pub fn wait_for_partners(&mut self) {
        if !self.is_held_by_recorder() && self.partners.sender.poll() {
            self.lose_sender();
        }
        if self.partners.repeated.elapsed() >= HEARTBEAT {
            self.partners.repeated = Instant::now();
            self.publish_receipt();
        }
    }

    /// Ends the wait for partners, because a tick is executed.
    pub fn stop_waiting_for_partners(&mut self, now: Instant) {
        self.partners.sender.check(now);
        self.partners.sender.reset();
        self.partners.repeated = now;
    }

    fn lose_sender(&mut self) {
        let has_begun = !self.buffer.is_spent() || self.commands.iter().any(Option::is_some);
        if has_begun {
            self.raise_outside(AlarmKind::SenderLost, self.partners.sender.limit_s());
        }
        // A motion that was announced and never began.
        self.partners.attends = false;
    }

    /// Looks after the recorder. One that is lost is not waited for until it has caught up.
    pub fn check_recorder(&mut self, now: Instant) {
        let is_held = self.is_held_by_recorder();
        let is_behind = self.is_beyond_recorder();
        let partners = &mut self.partners;
        let is_recording = self.bounds.recording.load(Ordering::Acquire);
        let messages = self.bounds.recorder_messages.load(Ordering::Acquire);
        let recorded_tick = self.bounds.recorded_tick.load(Ordering::Acquire);
        if !is_recording || messages != partners.recorder_messages {
            partners.recorder_messages = messages;
            partners.recorder.reset();
            partners.is_recording_lost &= is_recording && is_behind;
        }
        if !is_held || recorded_tick != partners.recorded_tick {
            partners.recorded_tick = recorded_tick;
            partners.behind.reset();
        }
        let is_silent = partners.recorder.check(now);
        let is_late = partners.behind.check(now);
        if is_silent || is_late {
            partners.is_recording_lost = true;
            let limit_s = if is_silent { partners.recorder.limit_s() } else { partners.behind.limit_s() };
            self.raise_outside(AlarmKind::RecordingLost, limit_s);
        }
    }

    /// Setpoints are executed, or wait to be, or the axes move.
    fn is_in_motion(&self) -> bool {
        self.buffer.has_setpoints() || !self.buffer.is_spent() || !self.machine.is_at_rest()
    }

    /// The node is not active any more, or ends: a motion is over, and comes to rest on the path.
    pub fn end_motion(&mut self) {
        if self.is_in_motion() && !self.is_stopped_by_alarm() {
            self.raise_outside(AlarmKind::MachineDeactivated, 0.0);
        }
        self.close();
    }

    /// The node becomes active, or inactive once the axes rest.
    pub fn set_active(&mut self, active: bool) {
        if active {
            self.active = true;
            self.partners.halting = None;
            // After an alarm the reset does it.
            if std::mem::take(&mut self.partners.is_closed) && !self.is_stopped_by_alarm() {
                self.report_applied(CyclicInput::Open);
                self.open();
            }
        } else if self.active {
            self.end_motion();
            self.partners.is_closed = true;
            self.partners.halting = Some(self.machine.tick() + 1);
        }
    }

    /// A machine that was deactivated and rests executes no more ticks.
    pub fn halt_at_rest(&mut self) {
        let is_halted = self.partners.halting.is_some_and(|tick| self.machine.tick() >= tick);
        if is_halted && !self.buffer.has_setpoints() && self.machine.is_at_rest() {
            self.active = false;
            self.partners.halting = None;
        }
    }

    /// Chunks are taken from where the axes rest; what was ordered before is forgotten.
    pub fn open(&mut self) {
        self.buffer.open(self.machine.setpoint());
        self.commands = [None; PENDING_COMMANDS];
        self.state = StreamState { news: true, job_tick: self.state.job_tick, ..StreamState::default() };
    }
}
