// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Applies injected faults.

use super::Machine;
use crate::machine::alarm::AlarmKind;
use crate::machine::description::Axis;
use crate::simulation::fault::Fault;

impl Machine {
    pub(super) fn apply_fault(&mut self, fault: Fault) {
        match fault {
            Fault::EStop(pressed) => {
                self.power.set_estop(pressed);
                if pressed {
                    self.raise(AlarmKind::EStop, 0.0, 0.0);
                    self.wheel.stop();
                }
            }
            Fault::PowerLoss(lost) => {
                if self.power.set_mains_lost(lost, &self.description.retract) {
                    self.raise(AlarmKind::PowerLoss, 0.0, 0.0);
                    self.wheel.stop();
                }
            }
            Fault::StuckInput { input, level } => self.inputs.set_stuck(input, level),
            Fault::DoubleOrigin(angle_rad) => {
                let per_rad = self.axes[Axis::C.index()].counts_per_unit;
                self.inputs.set_second_origin(angle_rad.map(|angle_rad| angle_rad * per_rad));
            }
            Fault::BouncingSwitch { station, active } => self.inputs.set_bouncing(station, active),
            Fault::SharedInput(inputs) => self.inputs.share(inputs),
            Fault::EncoderOffset { axis, offset } => {
                let dead = self.power.is_dead(axis);
                let axis = &mut self.axes[axis.index()];
                let counts = offset * axis.counts_per_unit;
                if dead { axis.set_encoder_offset_unpowered(counts) } else { axis.set_encoder_offset(counts) }
            }
            Fault::DriveGain { axis, factor } => self.axes[axis.index()].set_gain(factor),
            Fault::DriveFault { axis, active } => {
                self.power.set_drive_fault(axis, active);
                if active {
                    self.raise(AlarmKind::DriveFault(axis), 0.0, 0.0);
                }
            }
            Fault::LostChunks(_) => {}
            Fault::Gauge(fault) => self.gauging.set_fault(fault),
            Fault::WheelStall(stalled) => self.wheel.stall(stalled),
            Fault::WheelOverspeed(factor) => self.wheel.set_overspeed(factor),
            Fault::Loading(fault) => self.apply_loading_fault(fault),
        }
    }
}
