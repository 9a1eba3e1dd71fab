//! What the machine watches for: following error, overtravel, a wheel that stops or touches.

use super::Machine;
use crate::machine::alarm::{AlarmKind, Severity};
use crate::machine::description::Axis;
use crate::math::units::TURN_RAD;
use crate::simulation::workpiece::Removal;

/// Penetration (mm) that a wheel without speed may have before it is called contact: rounding, not touch.
const TOUCH_MM: f64 = 1.0e-4;

/// Ticks after the last cut for which the loss of the wheel's speed counts as in the cut: a spark-out turn removes
/// nothing for a while, and yet the wheel is at the part.
pub(super) const CUTTING_TICKS: u32 = 1000;

/// Speed of the wheel over the one ordered at which it is stopped.
const MAX_OVERSPEED: f64 = 1.05;

impl Machine {
    /// `LinuxCNC`'s rule: the limit grows with the speed asked for, but is never below its floor.
    pub(super) fn watch_following_error(&mut self) {
        for axis in Axis::ALL {
            let (state, description) = (&self.axes[axis.index()], &self.description.axes[axis.index()]);
            let share = state.setpoint_velocity().abs() / description.limits.velocity;
            let limit = (description.max_following_error * share).max(description.min_following_error);
            let error = state.following_error().abs();
            if error > limit {
                self.raise(AlarmKind::FollowingError(axis), error, limit);
            }
        }
    }

    /// The alarm comes when a switch closes; a reset with the axis still on its switch lets it move back.
    pub(super) fn watch_overtravel(&mut self) {
        for axis in Axis::ALL {
            let i = axis.index();
            let position = self.axes[i].true_position();
            let homes_on_it = self.description.axes[i].homing.is_some_and(|homing| homing.ignore_limits);
            let ignored = homes_on_it && !self.axes[i].homed;
            let beyond = self.overtravel[i].beyond(position).filter(|_| !ignored);
            if let Some(limit) = beyond.filter(|_| !self.beyond[i]) {
                let per_unit = self.axes[i].counts_per_unit;
                self.raise(AlarmKind::Overtravel(axis), position / per_unit, limit / per_unit);
            }
            self.beyond[i] = beyond.is_some();
        }
    }

    pub(super) fn watch_wheel(&mut self, removal: Removal) {
        self.since_cut = if removal.area_mm2 > 0.0 { 0 } else { self.since_cut.saturating_add(1).min(CUTTING_TICKS) };
        let over_the_axis = self.wheel.is_running() && removal.is_over_axis;
        let pushes = self.push_n > 0.0 && self.force_n <= self.push_n;
        let still = !self.wheel.is_running() && removal.depth_mm > TOUCH_MM && !pushes;
        // A wheel that an alarm has stopped touches until it is off the part.
        let known = self.is_stopping();
        if over_the_axis || (still && !known) {
            self.raise(AlarmKind::WheelContact, removal.depth_mm, 0.0);
        }
    }

    pub(super) fn turn_wheel(&mut self) {
        let ran = self.wheel.is_running();
        self.wheel.step();
        if self.is_stopping() {
            self.wheel_late = 0;
            return;
        }
        if ran && !self.wheel.is_running() && self.wheel.is_ordered() {
            let in_cut = self.since_cut < CUTTING_TICKS;
            self.raise(if in_cut { AlarmKind::WheelStoppedInCut } else { AlarmKind::WheelStopped }, 0.0, 0.0);
        }
        // Half as long again as it takes, and a tick.
        let late = self.wheel.is_ordered() && !self.wheel.is_running();
        self.wheel_late = if late { self.wheel_late.saturating_add(2) } else { 0 };
        if self.wheel_late > self.wheel.ticks_to_speed().saturating_mul(3).saturating_add(2) {
            self.raise(AlarmKind::WheelStopped, 0.0, 0.0);
        }
        let wheel = &self.description.wheel;
        let radius_mm = self.lasting.wheel_radius_mm;
        let ordered = wheel.surface_speed_m_s * 1000.0 / radius_mm;
        let (speed, most) = (self.wheel_rad_s(), ordered * MAX_OVERSPEED);
        if speed > most {
            let rpm = |rad_s: f64| rad_s / TURN_RAD * 60.0;
            self.raise(AlarmKind::WheelOverspeed, rpm(speed), rpm(most));
            self.wheel.order(false);
        }
    }

    /// Speed of the wheel as it is measured (rad/s).
    pub(super) fn wheel_rad_s(&self) -> f64 {
        self.overspeed * self.wheel.rad_s(self.lasting.wheel_radius_mm)
    }

    /// An alarm has stopped the motion, or is stopping it.
    pub(super) fn is_stopping(&self) -> bool {
        self.alarms.iter().any(|alarm| alarm.kind.entry().severity > Severity::Warning)
    }
}
