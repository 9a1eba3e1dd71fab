// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Builds the tick report.

use super::Machine;
use crate::machine::description::Axis;
use crate::machine::setpoint::{Input, Latch};
use crate::math::fixed_list::FixedList;
use crate::simulation::tick_report::{AxisReport, IoState, MAX_LATCHES, MotionState, TickReport};
use crate::simulation::turned_part::TurnedRemoval;
use crate::simulation::workpiece::Removal;

impl Machine {
    pub(super) fn motion(&self, has_setpoint: bool) -> MotionState {
        let at_rest = self.is_at_rest();
        let needs_reset = self.supervision.is_stopping();
        match (needs_reset, at_rest, self.power.is_on()) {
            (true, true, _) => MotionState::Fault,
            (true, false, _) => MotionState::Stopping,
            (false, _, false) => MotionState::Off,
            (false, true, true) if !has_setpoint => MotionState::Standstill,
            _ => MotionState::Running,
        }
    }

    pub(super) fn io(&self) -> IoState {
        let process = self.process_levels();
        let level = |input: Input| self.inputs.level(input, &self.axes, process);
        let closed = |axis: Axis| self.axis_watch.closed(axis, &self.axes);
        let ((overtravel_x_min, overtravel_x_max), (overtravel_z_min, overtravel_z_max)) =
            (closed(Axis::X), closed(Axis::Z));
        IoState {
            origin: level(Input::Origin),
            stations: (0..self.inputs.station_count().min(64))
                .fold(0, |word, i| word | u64::from(level(Input::Station(i))) << i),
            others: (0..).zip(Input::OTHERS).fold(0, |word, (i, input)| word | u8::from(level(input)) << i),
            overtravel_x_min,
            overtravel_x_max,
            overtravel_z_min,
            overtravel_z_max,
            estop: self.power.is_estop_pressed(),
            drives_on: self.power.is_on(),
            wheel_running: self.wheel.spindle().is_running(),
            part_present: self.work_area.map_or(self.workholding.has_part(), |area| area.part_present()),
        }
    }

    pub(super) fn report(
        &mut self,
        has_setpoint: bool,
        latches: FixedList<Latch, MAX_LATCHES>,
        (lobe, removal, turned): (Option<usize>, Removal, TurnedRemoval),
        gauge_mm: [Option<f64>; 2],
    ) -> TickReport {
        let cycle_time_s = self.description.cycle_time_s();
        let (forces, dead) = (self.cutting_forces(), self.power.dead());
        TickReport {
            tick: self.shown_tick(),
            axes: core::array::from_fn(|i| {
                let axis = &self.axes[i];
                AxisReport {
                    setpoint_counts: axis.shown_setpoint_counts(),
                    counts: axis.counts(),
                    position: axis.scale.position(axis.counts()),
                    velocity: axis.velocity(),
                    effort: axis.effort(cycle_time_s, forces[i]),
                    following_error: axis.following_error(),
                    is_at_rest: axis.is_at_rest(),
                    is_homed: axis.homed,
                    is_powered: !dead[i],
                }
            }),
            latches,
            io: self.io(),
            raised: self.supervision.take_raised(),
            motion: self.motion(has_setpoint),
            lobe,
            removal,
            turned,
            normal_force_n: self.contact.force_n(),
            gauge_mm,
            wheel_rad_s: self.wheel.rad_s(&self.lasting),
            work_area: self.work_area(),
        }
    }
}
