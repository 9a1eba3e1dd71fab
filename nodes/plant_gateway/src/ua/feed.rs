// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Changes of the nodes on their way from the messages of the cell to the thread of the server.

use super::alerts::{AlarmChange, alarm_changes};
use super::nodes::{NODES, NodeReading, alarms};
use crate::cell_messages::CellMessages;
use camwright_msgs::camwright_msgs::msg::Alarm;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use tokio::sync::mpsc::{Receiver, Sender, channel};

/// Updates that may wait for the server: minutes of them.
const MAX_WAITING: usize = 4096;

/// Changes of one message.
#[derive(Debug, Default, PartialEq)]
pub(super) struct UaUpdate {
    /// Arrival of the message (ns since 1970).
    pub(super) time_ns: i64,
    /// Index in [`NODES`] and new value.
    pub(super) changes: Vec<(usize, NodeReading)>,
    pub(super) alarms: Vec<AlarmChange>,
}

/// Values that the server has.
#[derive(Debug)]
struct SentValues {
    readings: Vec<NodeReading>,
    alarms: Vec<Alarm>,
}

/// Sends every change once, in the order of the messages.
#[derive(Debug)]
pub(crate) struct UaFeed {
    sent: Mutex<SentValues>,
    updates: Sender<UaUpdate>,
    lost: Arc<AtomicU64>,
}

/// Other end of a [`UaFeed`].
#[derive(Debug)]
pub(crate) struct UaUpdates {
    pub(super) updates: Receiver<UaUpdate>,
    lost: Arc<AtomicU64>,
}

impl UaUpdates {
    /// Updates that were lost since the last call because the server was too slow.
    pub(super) fn take_lost(&self) -> u64 {
        self.lost.swap(0, Ordering::AcqRel)
    }
}

impl UaFeed {
    /// Feed with the values before the first message.
    pub(crate) fn new() -> (Self, UaUpdates) {
        let (sender, receiver) = channel(MAX_WAITING);
        let nothing = CellMessages::default();
        let readings = NODES.iter().map(|node| node.read(&nothing)).collect();
        let lost = Arc::new(AtomicU64::new(0));
        let sent = Mutex::new(SentValues { readings, alarms: Vec::new() });
        let feed = Self { sent, updates: sender, lost: Arc::clone(&lost) };
        (feed, UaUpdates { updates: receiver, lost })
    }

    /// Sends what has changed; values that change with time only with `with_samples`.
    pub(crate) fn publish(&self, cell: &CellMessages, with_samples: bool, time_ns: i64) {
        let mut sent = self.sent.lock().unwrap_or_else(PoisonError::into_inner);
        let nodes = NODES.iter().enumerate().filter(|(_, node)| with_samples || !node.is_sample());
        let readings = nodes.map(|(index, node)| (index, node.read(cell)));
        let changes: Vec<_> = readings.filter(|(index, new)| sent.readings.get(*index) != Some(new)).collect();
        // Without a list nothing is known of alarms, and none is raised or reset.
        let now = alarms(cell);
        let alarms = now.as_ref().map_or_else(Vec::new, |now| alarm_changes(&sent.alarms, now));
        if changes.is_empty() && alarms.is_empty() {
            return;
        }
        let update = UaUpdate { time_ns, changes: changes.clone(), alarms };
        if self.updates.try_send(update).is_err() {
            // The next update has these changes too.
            self.lost.fetch_add(1, Ordering::AcqRel);
            return;
        }
        for (index, new) in changes {
            if let Some(old) = sent.readings.get_mut(index) {
                *old = new;
            }
        }
        if let Some(now) = now {
            sent.alarms = now.into_iter().cloned().collect();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell_messages::Presence;
    use camwright_msgs::camwright_msgs::msg::{CellState, MachineAlarms};
    use camwright_msgs::control_msgs::msg::{DynamicJointState, InterfaceValue};
    use opcua::types::Variant;

    fn cell(state: u8, x_m: f64) -> CellMessages {
        let axes = DynamicJointState {
            joint_names: vec!["x_axis".into()],
            interface_values: vec![InterfaceValue { interface_names: vec!["position".into()], values: vec![x_m] }],
            ..DynamicJointState::default()
        };
        CellMessages {
            presence: Presence { machine: true, interpolator: true, planner: true },
            cell: Some(CellState { state, mode: 1, ..CellState::default() }),
            axes: Some(axes),
            machine_alarms: Some(MachineAlarms::default()),
            ..CellMessages::default()
        }
    }

    fn index(path: &str) -> usize {
        NODES.iter().position(|node| node.path == path).expect("a node")
    }

    fn states(updates: &mut UaUpdates) -> Vec<NodeReading> {
        let program = index("Production/ActiveProgram/State");
        let mut all = Vec::new();
        while let Ok(update) = updates.updates.try_recv() {
            all.extend(update.changes.into_iter().filter(|(at, _)| *at == program).map(|(_, reading)| reading));
        }
        all
    }

    #[test]
    fn every_state_is_sent_and_samples_are_when_asked_for() {
        let (feed, mut updates) = UaFeed::new();
        for state in [4, 3, 6, 6, 17] {
            feed.publish(&cell(state, 0.1), false, 0);
        }
        assert_eq!(states(&mut updates), [0, 1, 2].map(NodeReading::State), "IDLE and STARTING are one state");
        feed.publish(&cell(17, 0.2), false, 1);
        assert!(updates.updates.try_recv().is_err(), "a position waits for the next samples");
        feed.publish(&cell(17, 0.2), true, 2);
        let update = updates.updates.try_recv().expect("samples");
        let position = (index("Axes/X/Position"), NodeReading::Value(Variant::from(200.0)));
        assert!(update.time_ns == 2 && update.changes.contains(&position), "{update:?}");
        let lost = CellMessages { presence: Presence::default(), ..cell(17, 0.2) };
        feed.publish(&lost, true, 3);
        assert_eq!(states(&mut updates), [NodeReading::Unavailable]);
    }

    #[test]
    fn an_update_that_finds_no_place_is_counted_and_its_values_follow() {
        let (feed, mut updates) = UaFeed::new();
        for step in 0..MAX_WAITING {
            feed.publish(&cell(if step % 2 == 0 { 6 } else { 11 }, 0.0), false, 0);
        }
        for state in [6, 17, 6] {
            feed.publish(&cell(state, 0.0), false, 0);
        }
        assert_eq!((updates.take_lost(), updates.take_lost()), (3, 0));
        assert_eq!(states(&mut updates).len(), MAX_WAITING);
        feed.publish(&cell(17, 0.0), false, 0);
        assert_eq!(states(&mut updates), [NodeReading::State(2)]);
    }

    #[test]
    fn a_lost_machine_neither_raises_nor_resets_alarms() {
        let (feed, mut updates) = UaFeed::new();
        let mut now = cell(9, 0.0);
        let alarm = Alarm { number: 42, severity: Alarm::STOP, source: "x_axis".into(), ..Alarm::default() };
        now.machine_alarms = Some(MachineAlarms { alarms: vec![alarm], ..MachineAlarms::default() });
        feed.publish(&now, false, 0);
        let mut raised = Vec::new();
        let mut receive = |updates: &mut UaUpdates| {
            while let Ok(update) = updates.updates.try_recv() {
                raised.extend(update.alarms.iter().map(|change| change.is_active));
            }
            raised.clone()
        };
        assert_eq!(receive(&mut updates), [true]);
        feed.publish(&CellMessages { presence: Presence::default(), ..now.clone() }, false, 0);
        feed.publish(&now, false, 0);
        assert_eq!(receive(&mut updates), [true]);
        feed.publish(&cell(9, 0.0), false, 0);
        assert_eq!(receive(&mut updates), [true, false]);
    }
}
