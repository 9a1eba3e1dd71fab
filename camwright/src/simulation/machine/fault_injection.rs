//! Faults strike.

use super::Machine;
use crate::machine::alarm::AlarmKind;
use crate::machine::description::Axis;
use crate::machine::setpoint::Input;
use crate::simulation::fault::{Fault, GaugeFault};

impl Machine {
    pub(super) fn apply_fault(&mut self, fault: Fault) {
        match fault {
            Fault::EStop(pressed) => {
                self.estop = pressed;
                if pressed {
                    self.raise(AlarmKind::EStop, 0.0, 0.0);
                    self.wheel.order(false);
                }
            }
            Fault::PowerLoss(lost) => {
                if lost && !self.mains_lost {
                    self.buffered_j = self.description.retract.buffered_energy_j;
                    self.raise(AlarmKind::PowerLoss, 0.0, 0.0);
                    self.wheel.order(false);
                }
                self.mains_lost = lost;
            }
            Fault::StuckInput { input: Input::Origin, level } => self.origin.set_stuck(level),
            Fault::StuckInput { input: Input::Station(index), level } => {
                if let Some(switch) = self.stations.get_mut(index) {
                    switch.set_stuck(level);
                }
            }
            Fault::StuckInput { input: Input::Home(axis) | Input::Index(axis), level } => {
                if let Some(own) = &mut self.references[axis.index()] {
                    own.switch.set_stuck(level);
                }
            }
            // No switches, and nobody relies on them: a probe ends at its target.
            Fault::StuckInput { input: Input::SteadyForce | Input::WheelContact | Input::KeyWay, .. } => {}
            Fault::DoubleOrigin(angle_rad) => {
                let per_rad = self.axes[Axis::C.index()].counts_per_unit;
                self.origin.set_second(angle_rad.map(|angle_rad| angle_rad * per_rad));
            }
            Fault::BouncingSwitch { station, active } => {
                if let Some(switch) = self.stations.get_mut(station) {
                    switch.set_bouncing(active);
                }
            }
            Fault::SharedInput(inputs) => self.shared = inputs,
            Fault::EncoderOffset { axis, offset } => {
                let (axis, dead) = (&mut self.axes[axis.index()], self.dead[axis.index()]);
                let counts = offset * axis.counts_per_unit;
                if dead { axis.set_encoder_offset_unpowered(counts) } else { axis.set_encoder_offset(counts) }
            }
            Fault::DriveGain { axis, factor } => self.axes[axis.index()].set_gain(factor),
            Fault::DriveFault { axis, active } => {
                self.drive_faults[axis.index()] = active;
                if active {
                    self.raise(AlarmKind::DriveFault(axis), 0.0, 0.0);
                }
            }
            Fault::LostChunks(_) => {}
            Fault::Gauge(fault) => self.gauge_watch.fault = fault,
            Fault::WheelStall(stalled) => self.wheel.stall(stalled),
            Fault::WheelOverspeed(factor) => self.overspeed = factor,
            Fault::Loading(fault) => self.apply_loading_fault(fault),
        }
    }

    /// What a gauge that fails makes of its readings.
    pub(super) fn spoiled(&self, readings_mm: [Option<f64>; 2]) -> [Option<f64>; 2] {
        core::array::from_fn(|i| match (self.gauge_watch.fault, readings_mm[i]) {
            (Some(GaugeFault::NotANumber), Some(_)) => Some(f64::NAN),
            // A gauge that never read anything is stuck at nothing.
            (Some(GaugeFault::Stuck), Some(_)) => Some(self.gauge_watch.last[i].unwrap_or(0.0)),
            (_, reading) => reading,
        })
    }
}
