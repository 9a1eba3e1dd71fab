// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Active alarms, as published on `machine/alarms`.

use super::stream_state::StreamState;
use camwright::machine::alarm::Alarm as CoreAlarm;
use camwright::machine::description::Axis;
use camwright::simulation::tick_report::TickReport;
use camwright_files::convert::time::TickClock;
use camwright_msgs::camwright_msgs::msg::Alarm;

/// Alarms in the order in which they were raised.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ActiveAlarms(Vec<CoreAlarm>);

impl ActiveAlarms {
    /// Those of a machine that is taken up in the middle.
    pub fn from_alarms(alarms: &[CoreAlarm]) -> Self {
        Self(alarms.to_vec())
    }

    /// Takes a tick in; whether they are others now.
    pub fn update(&mut self, report: &TickReport, state: &StreamState) -> bool {
        if state.alarms_reset {
            self.0.clear();
        }
        self.0.extend(report.raised.iter());
        state.alarms_reset || !report.raised.is_empty()
    }

    pub fn numbers(&self) -> Vec<u16> {
        self.0.iter().map(|alarm| alarm.kind.entry().number).collect()
    }

    pub fn messages(&self, clock: TickClock) -> Vec<Alarm> {
        self.0.iter().map(|alarm| message(alarm, clock)).collect()
    }
}

fn message(alarm: &CoreAlarm, clock: TickClock) -> Alarm {
    let entry = alarm.kind.entry();
    Alarm {
        stamp: clock.stamp(alarm.tick),
        tick: alarm.tick,
        number: entry.number,
        severity: entry.severity as u8,
        source: alarm.kind.axis().map_or("machine_sim", Axis::joint).to_owned(),
        text: alarm.to_string(),
        remedy: entry.remedy.to_owned(),
        active: true,
    }
}
