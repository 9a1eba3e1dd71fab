// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Up to which tick of the machine the bag has the joint states: what the machine may run ahead of at pace fast.

use camwright_msgs::camwright_msgs::msg::MachineStream;

/// Offset of the leading fields of a message, after the four bytes of the encapsulation (always little-endian here).
const BODY: usize = 4;

/// Offset of the pace in a `MachineStream`: behind two times and two ticks.
const PACE_OFFSET: usize = 32;

/// Follows the machine by the stamps of its messages.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct TickWatch {
    /// Time of tick 0 and the cycle time (ns), once the machine has said them.
    grid: Option<(i64, i64)>,
    /// Stamp of joint states that came before the grid was known (ns).
    waiting_stamp_ns: Option<i64>,
    last_tick: u64,
    /// The machine runs at pace fast, where it waits for the recorder.
    is_fast: bool,
}

impl TickWatch {
    /// Returns whether the machine waits for the recorder.
    pub(super) fn is_awaited(&self) -> bool {
        self.is_fast
    }

    /// The last tick whose joint states are in the writer's queue.
    pub(super) fn last_tick(&self) -> u64 {
        self.last_tick
    }

    /// Takes a `camwright_msgs/msg/MachineStream`: its stamp, epoch and tick give epoch and cycle time.
    pub(super) fn stream(&mut self, cdr: &[u8]) {
        let (Some(stamp_ns), Some(epoch_ns), Some(tick)) = (time(cdr, 0), time(cdr, 8), u64_at(cdr, 16)) else {
            return;
        };
        self.is_fast = cdr.get(BODY + PACE_OFFSET) == Some(&MachineStream::PACE_FAST);
        let Ok(ticks) = i64::try_from(tick) else { return };
        if ticks == 0 || stamp_ns <= epoch_ns {
            return;
        }
        let cycle_ns = (stamp_ns - epoch_ns) / ticks;
        if cycle_ns == 0 {
            return;
        }
        if self.grid.is_some_and(|(epoch, _)| epoch != epoch_ns) {
            // The machine has begun anew; its ticks count from 0 again.
            self.last_tick = 0;
        }
        self.grid = Some((epoch_ns, cycle_ns));
        if let Some(stamp_ns) = self.waiting_stamp_ns.take() {
            self.advance(stamp_ns);
        }
    }

    /// Takes a `sensor_msgs/msg/JointState` that is in the writer's queue: its header begins with the stamp.
    pub(super) fn joint_states(&mut self, cdr: &[u8]) {
        let Some(stamp_ns) = time(cdr, 0) else { return };
        if self.grid.is_some() {
            self.advance(stamp_ns);
        } else {
            self.waiting_stamp_ns = Some(stamp_ns);
        }
    }

    fn advance(&mut self, stamp_ns: i64) {
        let Some((epoch_ns, cycle_ns)) = self.grid else { return };
        // A foreign publisher of joint states may stamp between ticks, or by another clock: the tick that is past.
        let tick = u64::try_from((stamp_ns - epoch_ns) / cycle_ns).unwrap_or(0);
        self.last_tick = self.last_tick.max(tick);
    }
}

/// `builtin_interfaces/msg/Time` at an offset of the body (ns).
fn time(cdr: &[u8], offset: usize) -> Option<i64> {
    let at = BODY + offset;
    let sec = i32::from_le_bytes(cdr.get(at..at + 4)?.try_into().ok()?);
    let nanosec = u32::from_le_bytes(cdr.get(at + 4..at + 8)?.try_into().ok()?);
    Some(i64::from(sec) * 1_000_000_000 + i64::from(nanosec))
}

fn u64_at(cdr: &[u8], offset: usize) -> Option<u64> {
    let at = BODY + offset;
    Some(u64::from_le_bytes(cdr.get(at..at + 8)?.try_into().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    const EPOCH_S: i32 = 1_760_000_000;

    /// `builtin_interfaces/msg/Time`, so many nanoseconds after the epoch.
    fn at(ns: u64) -> Vec<u8> {
        let sec = EPOCH_S + i32::try_from(ns / 1_000_000_000).expect("a short test");
        let nanosec = u32::try_from(ns % 1_000_000_000).expect("a remainder");
        [sec.to_le_bytes(), nanosec.to_le_bytes()].concat()
    }

    /// The beginning of a `MachineStream` in CDR.
    fn stream_of(epoch_ns: u64, stamp_ns: u64, tick: u64) -> Vec<u8> {
        [&[0, 1, 0, 0][..], &at(stamp_ns), &at(epoch_ns), &tick.to_le_bytes(), &[0; 40]].concat()
    }

    fn stream(tick: u64) -> Vec<u8> {
        stream_of(0, tick * 500_000, tick)
    }

    /// The beginning of a `JointState` in CDR.
    fn joints(ns: u64) -> Vec<u8> {
        [&[0, 1, 0, 0][..], &at(ns), &[0; 16]].concat()
    }

    #[test]
    fn the_messages_begin_with_the_fields_that_are_read_here() {
        let fields = |type_name| {
            let info = camwright_msgs::by_type_name(type_name).expect("the type is one of ours");
            info.fields.iter().map(|f| f.name).collect::<Vec<_>>()
        };
        assert_eq!(fields("camwright_msgs/msg/MachineStream")[..5], ["stamp", "epoch", "tick", "credit_tick", "pace"]);
        assert_eq!(fields("sensor_msgs/msg/JointState")[0], "header");
        assert_eq!(fields("std_msgs/msg/Header")[0], "stamp");
        assert_eq!(fields("builtin_interfaces/msg/Time"), ["sec", "nanosec"]);
    }

    #[test]
    fn only_a_machine_at_pace_fast_waits() {
        let mut watch = TickWatch::default();
        for (pace, awaits) in [(MachineStream::PACE_FAST, true), (MachineStream::PACE_REALTIME, false)] {
            let message = MachineStream { pace, ..MachineStream::default() };
            watch.stream(&camwright_msgs::cdr::sample_from_message(&message).expect("serialisable"));
            assert_eq!(watch.is_awaited(), awaits);
        }
    }

    #[test]
    fn joint_states_are_counted_in_the_ticks_of_the_stream() {
        let mut watch = TickWatch::default();
        watch.stream(&stream(0));
        watch.joint_states(&joints(1_000_000));
        assert_eq!(watch.last_tick(), 0, "no cycle time is known yet");
        watch.stream(&stream(8));
        assert_eq!(watch.last_tick(), 2, "half a millisecond is a tick");
        watch.joint_states(&joints(4_000_000));
        assert_eq!(watch.last_tick(), 8);
        watch.joint_states(&joints(3_500_000));
        assert_eq!(watch.last_tick(), 8, "an older sample takes nothing back");
    }

    #[test]
    fn a_machine_that_begins_anew_counts_from_zero() {
        let mut watch = TickWatch::default();
        watch.stream(&stream(8));
        watch.joint_states(&joints(4_000_000));
        watch.stream(&stream_of(90_000_000_000, 90_001_000_000, 2));
        assert_eq!(watch.last_tick(), 0);
        watch.joint_states(&joints(90_001_000_000));
        assert_eq!(watch.last_tick(), 2);
    }

    #[test]
    fn torn_messages_change_nothing() {
        let mut watch = TickWatch::default();
        watch.stream(&stream(8)[..15]);
        watch.joint_states(&[0, 1, 0]);
        watch.joint_states(&[]);
        assert_eq!(watch, TickWatch::default());
    }
}
