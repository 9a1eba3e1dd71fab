// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Gauge readings: from the machine's report to the message, and from the message to the measurement of journals.

use super::{m_from_mm, mm_from_m, si_from_counts};
use camwright::gauging::gauged_tick::GaugedTick;
use camwright::machine::description::{Axis, GaugeKind, MachineDescription};
use camwright::planner::JournalReadings;
use camwright::simulation::tick_report::TickReport;
use camwright_msgs::camwright_msgs::msg::GaugeReading;

/// The readings of a tick, of the first gauge before the second; without their time and the name of the lobe.
pub fn readings(machine: &MachineDescription, report: &TickReport) -> impl Iterator<Item = GaugeReading> {
    let position = |axis: Axis| si_from_counts(machine.axis(axis).scale, report.axes[axis.index()].counts);
    let of_both = GaugeReading {
        tick: report.tick,
        spindle_angle: position(Axis::C),
        wheel_position: position(Axis::X),
        wheel_force: report.axes[Axis::X.index()].effort,
        pushing: report.wheel_rad_s == 0.0,
        ..GaugeReading::default()
    };
    let gauge_mm = report.gauge_mm;
    machine.gauge.into_iter().flat_map(move |gauge| {
        let angles = [Some(gauge.behind_wheel_rad), gauge.second_behind_wheel_rad];
        let kind = match gauge.kind {
            GaugeKind::Diameter => GaugeReading::DIAMETER,
            GaugeKind::Radius => GaugeReading::RADIUS,
        };
        let of_both = of_both.clone();
        gauge_mm
            .into_iter()
            .zip(angles)
            .filter_map(|(mm, angle)| mm.zip(angle))
            .map(move |(mm, gauge_angle)| GaugeReading { kind, gauge_angle, reading: m_from_mm(mm), ..of_both.clone() })
    })
}

/// A reading as journals are measured with it; that of a second gauge is another message.
#[must_use]
pub fn gauged(reading: &GaugeReading) -> GaugedTick {
    GaugedTick {
        tick: reading.tick,
        c_rad: reading.spindle_angle,
        x_mm: mm_from_m(reading.wheel_position),
        value_mm: mm_from_m(reading.reading),
        second_mm: None,
        motor_n: reading.wheel_force,
    }
}

/// Adds a reading to the log of a lobe: where the wheel does not turn to its push. That of a second gauge joins that of the first in the
/// same tick.
pub fn log(contact: &mut JournalReadings, reading: &GaugeReading, is_second: bool) {
    match (reading.pushing, is_second) {
        (false, false) => contact.gauged.push(gauged(reading)),
        (true, false) => contact.pushed.push(gauged(reading).into()),
        (false, true) => {
            if let Some(last) = contact.gauged.last_mut().filter(|last| last.tick == reading.tick) {
                last.second_mm = Some(mm_from_m(reading.reading));
            }
        }
        // Two gauges see a stopped wheel push with one motor.
        (true, true) => {}
    }
}
