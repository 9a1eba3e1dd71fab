// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Diagnostics of the interpolator: the holder of command, and the reception of the machine. Each status covers the last second.

use super::{Shared, lock};
use camwright::machine::description::MachineDescription;
use camwright_msgs::camwright_msgs::msg::MachineStream;
use camwright_msgs::diagnostic_msgs::msg::DiagnosticStatus;
use camwright_ros::diagnostic_status;
use std::time::{Duration, Instant};

/// Reception of `machine/stream`.
#[derive(Debug, Default)]
pub(super) struct MachineHealth {
    last: Option<(Instant, u64)>,
    /// The last message was that of a machine at rest, which reports less often.
    was_idle: bool,
    /// Messages, and those that must have been between them, since the last report.
    messages: u64,
    lost: u64,
    lost_ever: u64,
    longest_gap: Duration,
    /// Its ticks follow the clock.
    is_realtime: bool,
}

impl MachineHealth {
    /// Records a message, and the periods without one since the last.
    pub(super) fn update(&mut self, message: &MachineStream, machine: &MachineDescription) {
        let period = if self.was_idle { machine.rest_stream_period_ticks() } else { machine.stream_period_ticks() };
        let now = Instant::now();
        if let Some((before, tick)) = self.last {
            // Nothing runs out while the machine rests.
            if !self.was_idle {
                self.longest_gap = self.longest_gap.max(now - before);
            }
            // Multiples of the period after the one and before the other.
            let due = (message.tick / period).saturating_sub(tick / period);
            let lost = due.saturating_sub(u64::from(message.tick.is_multiple_of(period)));
            self.lost += lost;
            self.lost_ever += lost;
        }
        self.messages += 1;
        self.is_realtime = message.pace == MachineStream::PACE_REALTIME;
        self.was_idle =
            self.is_realtime && message.motion == MachineStream::MOTION_STANDSTILL && message.holder.is_empty();
        self.last = Some((now, message.tick));
    }

    /// Status since the last report.
    fn report(&mut self, delay: Option<Duration>) -> DiagnosticStatus {
        let gap = std::mem::take(&mut self.longest_gap);
        let (messages, lost) = (std::mem::take(&mut self.messages), std::mem::take(&mut self.lost));
        let (level, message) = match delay {
            None => (DiagnosticStatus::WARN, "no message from the machine yet".to_owned()),
            Some(_) if messages == 0 => (DiagnosticStatus::ERROR, "the machine has fallen silent".to_owned()),
            Some(_) if lost > 0 => (DiagnosticStatus::WARN, format!("{lost} messages of machine/stream were lost")),
            Some(delay) if self.is_realtime && gap > delay => {
                let text = format!(
                    "machine/stream was silent for {} ms: setpoints run out after {} ms",
                    gap.as_millis(),
                    delay.as_millis()
                );
                (DiagnosticStatus::ERROR, text)
            }
            Some(delay) if self.is_realtime && 2 * gap > delay => {
                (DiagnosticStatus::WARN, format!("machine/stream was silent for {} ms", gap.as_millis()))
            }
            Some(_) => (DiagnosticStatus::OK, "the machine is connected".to_owned()),
        };
        let values = [
            ("messages_in_the_last_second", messages.to_string()),
            ("longest_gap_ms", gap.as_millis().to_string()),
            ("lost", self.lost_ever.to_string()),
        ];
        diagnostic_status(level, "machine", &message, &values)
    }
}

impl Shared {
    /// Who has command, and whether the machine is alive.
    pub(super) fn health(&self) -> Vec<DiagnosticStatus> {
        let (holder, plan) = lock(&self.served).names();
        let message = match (self.is_active(), holder.is_empty()) {
            (false, _) => "not active".to_owned(),
            (true, true) => "idle".to_owned(),
            (true, false) => format!("{holder} has command"),
        };
        let values = [("plan", plan), ("telemetry_dropped", self.drops.count().to_string())];
        let command = diagnostic_status(DiagnosticStatus::OK, "", &message, &values);
        let delay = self
            .machine()
            .map(|machine| Duration::from_nanos(u64::from(machine.cycle_time_ns)) * machine.feedback_delay_ticks);
        vec![command, lock(&self.machine_health).report(delay.filter(|_| self.clock().is_some()))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright_files::{locate, machine_file};

    #[test]
    fn what_must_have_been_between_two_messages_is_lost() {
        let mut machine_health = MachineHealth::default();
        let file = locate::locate("machines", "cam_grinder", "yaml", None).expect("shipped");
        let machine = machine_file::parse(&file.path, &file.text, &[]).expect("shipped").description;
        assert_eq!(machine.stream_period_ticks(), 10);
        // News between two periods is a message more, and none is missed.
        for tick in [20, 30, 33, 33, 40, 50] {
            machine_health.update(&MachineStream { tick, ..MachineStream::default() }, &machine);
        }
        assert_eq!((machine_health.messages, machine_health.lost), (6, 0));
        for tick in [80, 95, 100] {
            machine_health.update(&MachineStream { tick, ..MachineStream::default() }, &machine);
        }
        assert_eq!((machine_health.messages, machine_health.lost), (9, 3), "60, 70 and 90");
        let idle = MachineStream { motion: MachineStream::MOTION_STANDSTILL, ..MachineStream::default() };
        for tick in [110, 150, 200, 300] {
            machine_health.update(&MachineStream { tick, ..idle.clone() }, &machine);
        }
        assert_eq!((machine_health.messages, machine_health.lost), (13, 4), "at rest every fifth period: 250");
        machine_health.lost = 3;
        let status = machine_health.report(Some(Duration::from_secs(100)));
        assert_eq!(status.level, DiagnosticStatus::WARN);
        assert!(status.message.starts_with("3 messages"), "{}", status.message);
        assert_eq!(
            machine_health.report(Some(Duration::from_secs(100))).level,
            DiagnosticStatus::ERROR,
            "silent since"
        );
        assert_eq!(machine_health.report(None).level, DiagnosticStatus::WARN);
    }
}
