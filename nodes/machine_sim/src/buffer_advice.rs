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

impl BufferAdvice {
    pub(super) fn new(node: &Node, machine: &MachineDescription) -> Self {
        let buffer_ms = f64::from(machine.feedback_delay_ticks) * f64::from(machine.cycle_time_ns) / 1e6;
        Self { node: node.clone(), buffer_ms, reports: 0, is_warned: false }
    }

    /// Reports the buffer; logs the advice once, and once more where it turns out too short.
    pub(super) fn report(&mut self, bounds: &Bounds) -> DiagnosticStatus {
        let pause_ms = bounds.longest_pause_us.load(Ordering::Relaxed) as f64 / US_PER_MS;
        let (buffer_ms, wanted_ms) = (self.buffer_ms, recommended_ms(pause_ms));
        let is_short = wanted_ms > buffer_ms;
        self.reports = self.reports.saturating_add(1);
        let measured = format!("setpoint buffer {buffer_ms:.0} ms, longest pause of the cycle {pause_ms:.1} ms");
        let advice =
            format!("set setpoint_buffer_ms to {wanted_ms:.0}, or cyclic_priority, or reduce the load of the computer");
        if is_short && !self.is_warned && self.reports >= REPORTS {
            self.is_warned = true;
            self.node.logger().warn(&format!("{measured}: a motion may end in alarm 80; {advice}"));
        } else if self.reports == REPORTS {
            self.node.logger().info(&format!("{measured}: enough"));
        }
        let (level, message) = match is_short {
            true => (DiagnosticStatus::WARN, format!("{measured}; {advice}")),
            false => (DiagnosticStatus::OK, measured),
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
}
