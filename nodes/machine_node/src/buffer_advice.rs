// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Recommended length of the setpoint buffer on this computer: latency against robustness, in figures.
//!
//! The buffer (`feedback_delay_ticks`) must outlast the longest pause of the machine's cycle and of the interpolator's,
//! and both ways of a message. A longer one lets motion survive a busy computer; feedback (probes, spark-out, holds) is
//! that much later in effect.

use camwright::machine::description::MachineDescription;
use camwright_machine_cycle::bounds::Bounds;
use camwright_msgs::diagnostic_msgs::msg::DiagnosticStatus;
use camwright_ros::{Node, diagnostic_status};
use std::sync::atomic::Ordering;

/// Microseconds of a millisecond.
pub(super) const US_PER_MS: f64 = 1000.0;
/// Time for both ways of a message and the computing between them (ms).
const MESSAGES_MS: f64 = 40.0;
/// Step in which a buffer is recommended (ms).
const STEP_MS: f64 = 50.0;
/// Reports before the advice is logged: the start is over by then.
const REPORTS: u32 = 3;

/// Compares the buffer with what was measured.
#[derive(Debug)]
pub(super) struct BufferAdvice {
    node: Node,
    buffer_ms: f64,
    reports: u32,
    is_warned: bool,
}

/// The buffer that outlasts a pause of machine and interpolator, one after the other (ms).
fn recommended_ms(longest_pause_ms: f64) -> f64 {
    ((2.0 * longest_pause_ms + MESSAGES_MS) / STEP_MS).ceil().max(1.0) * STEP_MS
}

/// Length of the setpoint buffer of a machine (ms).
pub(super) fn buffer_ms(machine: &MachineDescription) -> f64 {
    f64::from(machine.feedback_delay_ticks) * f64::from(machine.cycle_time_ns) / 1e6
}

/// Warning where the longest pause of the cycle asks for a longer buffer.
pub(super) fn underrun_risk(node: &str, buffer_ms: f64, longest_pause_ms: f64) -> Option<String> {
    let wanted_ms = recommended_ms(longest_pause_ms);
    (wanted_ms > buffer_ms).then(|| {
        format!(
            "the computer kept the machine's cycle waiting for up to {longest_pause_ms:.1} ms, the setpoint buffer lasts {buffer_ms:.0} ms: a \
             motion may end in alarm 80; set {node}:setpoint_buffer_ms:={wanted_ms:.0} (--ros-args -p), or cyclic_priority, or reduce \
             the load of the computer"
        )
    })
}

impl BufferAdvice {
    pub(super) fn new(node: &Node, machine: &MachineDescription) -> Self {
        Self { node: node.clone(), buffer_ms: buffer_ms(machine), reports: 0, is_warned: false }
    }

    /// Reports the buffer; logs the advice once, and once more where it turns out too short.
    pub(super) fn report(&mut self, bounds: &Bounds) -> DiagnosticStatus {
        let pause_ms = bounds.longest_pause_us.load(Ordering::Relaxed) as f64 / US_PER_MS;
        let (buffer_ms, wanted_ms) = (self.buffer_ms, recommended_ms(pause_ms));
        let risk = underrun_risk(self.node.name(), buffer_ms, pause_ms);
        self.reports = self.reports.saturating_add(1);
        let measured = format!("setpoint buffer {buffer_ms:.0} ms, longest pause of the cycle {pause_ms:.1} ms");
        if self.reports >= REPORTS && !self.is_warned {
            match &risk {
                Some(risk) => {
                    self.is_warned = true;
                    self.node.logger().warn(risk);
                }
                None if self.reports == REPORTS => self.node.logger().info(&format!("{measured}: enough")),
                None => {}
            }
        }
        let (level, message) = match risk {
            Some(risk) => (DiagnosticStatus::WARN, risk),
            None => (DiagnosticStatus::OK, measured),
        };
        let values = [
            ("buffer_ms", format!("{buffer_ms:.0}")),
            ("longest_pause_ms", format!("{pause_ms:.1}")),
            ("recommended_buffer_ms", format!("{wanted_ms:.0}")),
        ];
        diagnostic_status(level, "buffer", &message, &values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_buffer_outlasts_two_pauses_and_the_messages() {
        for (pause_ms, buffer_ms) in
            [(0.0, 50.0), (3.0, 50.0), (5.1, 100.0), (30.0, 100.0), (55.0, 150.0), (200.0, 450.0)]
        {
            let found: f64 = recommended_ms(pause_ms);
            assert!((found - buffer_ms).abs() < 1e-9, "{pause_ms}: {found}");
        }
    }

    #[test]
    fn a_short_buffer_is_reported_with_the_value_to_set() {
        assert_eq!(underrun_risk("machine_sim", 100.0, 30.0), None);
        let risk = underrun_risk("machine_sim", 100.0, 30.1)
            .expect("two pauses of 30.1 ms and 40 ms of messages are more than 100 ms");
        assert!(risk.contains("up to 30.1 ms") && risk.contains("machine_sim:setpoint_buffer_ms:=150 "), "{risk}");
    }
}
