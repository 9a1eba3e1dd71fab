//! Where the setpoint of a tick comes from, and whether it can be followed.

use super::{Machine, Mode};
use crate::machine::alarm::AlarmKind;
use crate::machine::description::Axis;
use crate::machine::setpoint::Setpoint;
use crate::simulation::plausibility::Implausible;

impl Machine {
    pub(super) fn advance_setpoint(&mut self, setpoint: Option<&Setpoint>) {
        if matches!(self.mode, Mode::Following | Mode::Draining) {
            if self.mode == Mode::Draining {
                self.begin_retreat();
            }
            match setpoint {
                Some(setpoint) => match self.refusal(setpoint) {
                    None => {
                        self.followed = *setpoint;
                        self.follow();
                    }
                    Some((kind, value, bound)) => {
                        self.raise(kind, value, bound);
                        self.mode = Mode::OwnStop;
                    }
                },
                None if self.stream_moves() => {
                    if self.mode == Mode::Following {
                        self.raise(AlarmKind::Underrun, 0.0, 0.0);
                    }
                    self.mode = Mode::OwnStop;
                }
                None => {
                    self.followed = Setpoint { counts: self.followed.counts, ..Setpoint::default() };
                    if self.retreat.is_some() { self.follow() } else { self.hold() }
                }
            }
            if self.mode == Mode::Draining {
                self.end_draining();
            }
        } else if self.mode == Mode::Halted {
            self.hold();
        }
        if self.mode == Mode::OwnStop {
            self.stop_by_itself();
        }
    }

    fn hold(&mut self) {
        for (axis, _) in self.axes.iter_mut().zip(self.dead).filter(|(_, dead)| !*dead) {
            axis.hold();
        }
    }

    /// The stream has not come to rest.
    pub(super) fn stream_moves(&self) -> bool {
        self.followed.velocity.iter().any(|velocity| *velocity != 0.0)
    }

    pub(super) fn setpoint_moves(&self) -> bool {
        self.axes.iter().any(|axis| axis.target().velocity != 0.0)
    }

    /// Why a setpoint cannot be followed: the alarm with its value and bound.
    pub(super) fn refusal(&self, setpoint: &Setpoint) -> Option<(AlarmKind, f64, f64)> {
        if let Some(kind) = self.hinders(setpoint) {
            return Some((kind, 0.0, 0.0));
        }
        let last = self.followed;
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
