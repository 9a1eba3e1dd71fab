//! Where the setpoint of a tick comes from, and whether it can be followed.

use super::{Machine, Mode};
use crate::machine::alarm::AlarmKind;
use crate::machine::axis::AxisState;
use crate::machine::description::Axis;
use crate::machine::plausibility::Implausible;
use crate::setpoint::Setpoint;

impl Machine {
    pub(super) fn advance_setpoint(&mut self, setpoint: Option<&Setpoint>) {
        let cycle_time_s = self.description.cycle_time_s();
        if matches!(self.mode, Mode::Following | Mode::Draining) {
            match setpoint {
                Some(setpoint) => match self.refusal(setpoint) {
                    None => {
                        for (i, axis) in self.axes.iter_mut().enumerate() {
                            axis.follow(setpoint.counts[i], setpoint.velocity[i], setpoint.acceleration[i]);
                        }
                    }
                    Some((kind, value, bound)) => {
                        self.raise(kind, value, bound);
                        self.mode = Mode::OwnStop;
                    }
                },
                None if self.setpoint_moves() => {
                    if self.mode == Mode::Following {
                        self.raise(AlarmKind::Underrun, 0.0, 0.0);
                    }
                    self.mode = Mode::OwnStop;
                }
                None => self.axes.iter_mut().for_each(AxisState::hold),
            }
            if self.mode == Mode::Draining && !self.setpoint_moves() {
                self.mode = Mode::Halted;
            }
        } else if self.mode == Mode::Halted {
            self.axes.iter_mut().for_each(AxisState::hold);
        }
        if self.mode == Mode::OwnStop {
            self.axes.iter_mut().for_each(|axis| axis.decelerate(cycle_time_s));
            if !self.setpoint_moves() {
                self.mode = Mode::Halted;
            }
        }
    }

    pub(super) fn setpoint_moves(&self) -> bool {
        self.axes.iter().any(|axis| axis.target().velocity != 0.0)
    }

    /// Why a setpoint cannot be followed: the alarm with its value and bound.
    pub(super) fn refusal(&self, setpoint: &Setpoint) -> Option<(AlarmKind, f64, f64)> {
        let last = self.setpoint();
        if let Some(misfit) = self.plausibility.misfit(&last, setpoint) {
            let kind = match misfit.what {
                Implausible::Velocity => AlarmKind::SetpointVelocity(misfit.axis),
                Implausible::Acceleration => AlarmKind::SetpointAcceleration(misfit.axis),
                Implausible::Jump => AlarmKind::SetpointJump(misfit.axis),
            };
            return Some((kind, misfit.value, misfit.bound));
        }
        for axis in Axis::ALL {
            let i = axis.index();
            let description = &self.description.axes[i];
            let Some((min, max)) = description.soft_limits.filter(|_| self.axes[i].homed) else { continue };
            let (min_counts, max_counts) = (description.scale.counts(min), description.scale.counts(max));
            let (now, next) = (last.counts[i], setpoint.counts[i]);
            // An axis that stands outside may come back, never go farther out.
            let (below, above) = (next < min_counts && next < now, next > max_counts && next > now);
            if below || above {
                let bound = if below { min } else { max };
                return Some((AlarmKind::SoftLimit(axis), description.scale.position(next), bound));
            }
        }
        None
    }
}
