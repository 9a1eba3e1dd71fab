// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Active alarms, and how far the motion has reacted to them.

use crate::machine::alarm::{ALARM_KINDS, Alarm, AlarmKind, AlarmSeverity};
use crate::machine::description::{AXIS_COUNT, Axis};
use crate::math::fixed_list::FixedList;

/// Source of the setpoints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SetpointSource {
    Following,
    /// The stream until it rests, after an alarm: the tail of the last chunk, beside which the wheel leaves the part.
    Draining,
    /// The machine: every axis decelerates at its limit, X leaves the part.
    OwnStop,
    /// None: the axes hold until a reset.
    Halted,
}

crate::snapshot_cases!(SetpointSource { 0 Following, 1 Draining, 2 OwnStop, 3 Halted });

/// Alarms and the reaction to them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Supervision {
    mode: SetpointSource,
    alarms: FixedList<Alarm, ALARM_KINDS>,
    /// Alarms that no tick has reported yet.
    raised: FixedList<Alarm, ALARM_KINDS>,
    /// Axes whose drives lose their power in the next reaction.
    kill_due: [bool; AXIS_COUNT],
}

snapshot_groups!(Supervision {
    keep_mode(fields: mode),
    keep_kill(fields: kill_due),
    keep_alarms(fields: alarms, raised),
} on {});

impl Supervision {
    pub(super) fn new() -> Self {
        Self {
            mode: SetpointSource::Following,
            alarms: FixedList::new(),
            raised: FixedList::new(),
            kill_due: [false; AXIS_COUNT],
        }
    }

    /// Raises an alarm that is not active yet, and begins the reaction to it.
    pub(super) fn raise(&mut self, tick: u64, kind: AlarmKind, value: f64, bound: f64) {
        if self.alarms.iter().any(|alarm| alarm.kind == kind) {
            return;
        }
        let alarm = Alarm { kind, tick, value, bound };
        self.alarms.push(alarm);
        self.raised.push(alarm);
        if kind.entry().severity == AlarmSeverity::Warning {
            return;
        }
        if let AlarmKind::FollowingError(axis) | AlarmKind::DriveFault(axis) | AlarmKind::EncoderJump(axis) = kind {
            self.kill_due[axis.index()] = true;
        }
        if matches!(kind, AlarmKind::Overtravel(_)) {
            self.stop_unless_halted();
        } else if self.mode == SetpointSource::Following {
            self.mode = SetpointSource::Draining;
        }
    }

    pub(super) fn alarms(&self) -> &FixedList<Alarm, ALARM_KINDS> {
        &self.alarms
    }

    pub(super) fn take_raised(&mut self) -> FixedList<Alarm, ALARM_KINDS> {
        core::mem::take(&mut self.raised)
    }

    pub(super) fn clear_alarms(&mut self) {
        self.alarms = FixedList::new();
    }

    /// An alarm has stopped the motion, or is stopping it.
    pub(super) fn is_stopping(&self) -> bool {
        self.alarms.iter().any(|alarm| alarm.kind.entry().severity > AlarmSeverity::Warning)
    }

    /// An alarm keeps the power of the drives off once the axes rest.
    pub(super) fn requires_power_off(&self) -> bool {
        self.alarms.iter().any(|alarm| alarm.kind.entry().severity == AlarmSeverity::PowerOff)
    }

    pub(super) fn take_kill(&mut self, axis: Axis) -> bool {
        core::mem::take(&mut self.kill_due[axis.index()])
    }

    pub(super) fn mode(&self) -> SetpointSource {
        self.mode
    }

    pub(super) fn enter(&mut self, mode: SetpointSource) {
        self.mode = mode;
    }

    pub(super) fn stop_unless_halted(&mut self) {
        if self.mode != SetpointSource::Halted {
            self.mode = SetpointSource::OwnStop;
        }
    }
}
