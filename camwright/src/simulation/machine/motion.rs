// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Setpoints of the axes in each tick: from the stream, beside it, or from the machine itself; power and reset.

use super::supervision::SetpointSource;
use super::workholding::PartClearance;
use super::{Machine, ResetRefused};
use crate::machine::alarm::AlarmKind;
use crate::machine::description::{AXIS_COUNT, Axis};
use crate::machine::setpoint::Setpoint;
use crate::simulation::axis::{AxisSetpoint, AxisState, Span};

const X: usize = Axis::X as usize;

impl Machine {
    pub(super) fn advance_setpoint(&mut self, setpoint: Option<&Setpoint>) {
        let mode = self.supervision.mode();
        if matches!(mode, SetpointSource::Following | SetpointSource::Draining) {
            if mode == SetpointSource::Draining {
                self.begin_retreat();
            }
            match setpoint {
                Some(setpoint) => match self.refusal(setpoint) {
                    None => {
                        self.stream.follow(*setpoint);
                        self.follow();
                    }
                    Some((kind, value, bound)) => {
                        self.raise(kind, value, bound);
                        self.supervision.enter(SetpointSource::OwnStop);
                    }
                },
                None if self.stream.moves() => {
                    if mode == SetpointSource::Following {
                        self.raise(AlarmKind::Underrun, 0.0, 0.0);
                    }
                    self.supervision.enter(SetpointSource::OwnStop);
                }
                None => {
                    self.stream.rest();
                    if self.retract.is_active() { self.follow() } else { self.hold() }
                }
            }
            if self.supervision.mode() == SetpointSource::Draining {
                self.end_draining();
            }
        } else if mode == SetpointSource::Halted {
            self.hold();
        }
        if self.supervision.mode() == SetpointSource::OwnStop {
            self.stop_by_itself();
        }
    }

    /// Returns why a setpoint cannot be followed: the alarm with its value and bound.
    fn refusal(&self, setpoint: &Setpoint) -> Option<(AlarmKind, f64, f64)> {
        match self.hinders(setpoint) {
            Some(kind) => Some((kind, 0.0, 0.0)),
            None => self.stream.refusal(setpoint, &self.axes, &self.description),
        }
    }

    /// Clearance that the wheel at `x_mm` lacks.
    fn too_near(&self, x_mm: f64) -> Option<PartClearance> {
        self.workholding.too_near(x_mm, self.axes[Axis::Z.index()].true_value(), &self.description)
    }

    /// Position of the setpoint of X (mm, true).
    fn x_target_mm(&self) -> f64 {
        self.axes[X].target().position / self.axes[X].counts_per_unit
    }

    /// Sends X off the part if it is too near and its drive works.
    fn begin_retreat(&mut self) {
        if self.retract.is_active() || self.power.is_dead(Axis::X) {
            return;
        }
        let Some(near) = self.too_near(self.x_target_mm()) else { return };
        let beside_path = self.supervision.mode() == SetpointSource::Draining;
        self.retract.begin(near, beside_path, &self.axes[X], &self.description, self.tick - 1);
    }

    /// Follows a setpoint of the stream, beside it where the wheel is on its way off the part.
    fn follow(&mut self) {
        let beside =
            self.retract.is_active().then(|| self.retract.sample(self.tick, self.description.cycle_time_s()).0);
        let followed = self.stream.followed();
        let dead = self.power.dead();
        for (i, axis) in self.axes.iter_mut().enumerate().filter(|(i, _)| !dead[*i]) {
            let (counts, velocity, acceleration) = (followed.counts[i], followed.velocity[i], followed.acceleration[i]);
            match &beside {
                Some(beside) if i == X => axis.follow_beside(counts, velocity, acceleration, beside),
                _ => axis.follow(counts, velocity, acceleration),
            }
        }
    }

    fn hold(&mut self) {
        for (axis, _) in self.axes.iter_mut().zip(self.power.dead()).filter(|(_, dead)| !*dead) {
            axis.hold();
        }
    }

    fn is_retreat_over(&self) -> bool {
        self.retract.sample(self.tick, self.description.cycle_time_s()).1
    }

    /// The stream has come to rest: the axes halt once the wheel is off. The path may have gone deeper than the lobe was at the
    /// alarm, by what was still to be fed and by what wheel and part deflect: then X goes the rest by itself.
    fn end_draining(&mut self) {
        if self.stream.moves() || !self.is_retreat_over() {
            return;
        }
        let retreats = self.retract.end();
        if retreats {
            let end = libm::round(self.axes[X].target().position);
            self.axes[X].go(AxisSetpoint::resting(end));
        }
        let is_near = retreats && self.too_near(self.x_target_mm()).is_some();
        self.supervision.enter(if is_near { SetpointSource::OwnStop } else { SetpointSource::Halted });
    }

    /// Every axis decelerates at its limit, X leaves the part first.
    fn stop_by_itself(&mut self) {
        let cycle_time_s = self.description.cycle_time_s();
        self.retract.leave_path();
        self.begin_retreat();
        let is_over = self.is_retreat_over();
        let retreat = self.retract.target(self.tick, cycle_time_s, self.axes[X].counts_per_unit);
        let dead = self.power.dead();
        for (i, axis) in self.axes.iter_mut().enumerate().filter(|(i, _)| !dead[*i]) {
            match retreat.filter(|_| i == X) {
                Some(target) => axis.go(target),
                None => axis.decelerate(cycle_time_s),
            }
        }
        if is_over && self.axes.iter().all(|axis| axis.target().velocity == 0.0) {
            self.retract.end();
            self.supervision.enter(SetpointSource::Halted);
        }
    }

    /// Reacts to alarms: drives that cannot go on lose their power now, the others once the axes rest.
    pub(super) fn react(&mut self) {
        for axis in Axis::ALL {
            if self.supervision.take_kill(axis) && !self.power.is_dead(axis) {
                self.release(axis);
                // C and X make the path together; the table has no part in it.
                if axis != Axis::Z {
                    self.supervision.stop_unless_halted();
                }
            }
        }
        let rests = self.supervision.mode() == SetpointSource::Halted && !self.retract.is_active() && self.is_at_rest();
        if self.power.take_power_off() || (self.supervision.requires_power_off() && rests) {
            self.cut_power();
        }
    }

    /// Takes the power from every drive; axes that move brake.
    fn cut_power(&mut self) {
        if self.power.switch_off() {
            self.supervision.enter(SetpointSource::Halted);
            Axis::ALL.into_iter().for_each(|axis| self.release(axis));
        }
    }

    fn release(&mut self, axis: Axis) {
        if !self.power.kill(axis) {
            return;
        }
        if axis == Axis::X {
            let near = self.too_near(self.axes[X].true_value());
            self.retract.release(near, &self.axes[X], &self.description);
        }
        self.axes[axis.index()].release();
    }

    /// One servo step of every axis.
    pub(super) fn servo_step(&mut self, index: u32) -> [Span; AXIS_COUNT] {
        let (count, step_s, dead) = (self.description.servo_steps_per_tick, self.step_s, self.power.dead());
        let forces = self.cutting_forces();
        core::array::from_fn(|i| {
            let axis = &mut self.axes[i];
            match (dead[i], i) {
                (false, _) => axis.step(index, count, step_s, forces[i]),
                (true, X) => self.retract.coast(axis, (index, count), step_s),
                (true, _) => axis.coast(index, count, step_s),
            }
        })
    }

    /// A wheelhead that has been drawn far enough is held by its brake; an empty buffer takes the power away.
    pub(super) fn end_of_retreat(&mut self) {
        self.retract.end_draw(&self.axes[X]);
        let cycle_time_s = self.description.cycle_time_s();
        let motors_w = || self.axes.iter().map(|axis: &AxisState| axis.power_w(cycle_time_s).max(0.0)).sum();
        if self.power.drain_buffer(motors_w, &self.description.retract, cycle_time_s) {
            self.cut_power();
        }
    }

    /// Setpoints did not reach the drives of a real machine, which stand where the last one sent them: an alarm, and the axes hold.
    pub fn starve(&mut self) {
        self.raise(AlarmKind::Underrun, 0.0, 0.0);
        self.stream.rest();
        self.axes.iter_mut().for_each(AxisState::starve);
        self.supervision.enter(SetpointSource::Halted);
    }

    /// Clears the alarms whose causes are gone and gives the drives their power again. The axes hold where they are;
    /// nothing that was under way is resumed.
    ///
    /// # Errors
    /// Emergency stop pressed, mains lost, a drive fault that persists, axes that are not at rest yet, a wheel that has still
    /// to leave the part or turns behind an open door; nothing has changed then.
    pub fn reset(&mut self) -> Result<(), ResetRefused> {
        self.power.check_supply()?;
        if self.work_area.is_some_and(|area| area.entered()) {
            return Err(ResetRefused::Entered);
        }
        if let Some(hindrance) = self.hindrance().filter(|_| self.wheel.turns()) {
            return Err(ResetRefused::WheelTurns(hindrance));
        }
        for axis in Axis::ALL {
            self.power.check_drive(axis)?;
            if !self.axes[axis.index()].is_at_rest() {
                return Err(ResetRefused::Moving(axis));
            }
        }
        if self.supervision.is_stopping() && self.power.is_on() && self.supervision.mode() != SetpointSource::Halted {
            return Err(ResetRefused::Moving(Axis::X));
        }
        self.supervision.clear_alarms();
        self.power.reset();
        self.retract.stop_drawing();
        self.stream.follow(self.setpoint());
        self.supervision.enter(SetpointSource::Following);
        Ok(())
    }

    /// Orders power for the drives, or none: then the axes brake. Power comes only when no alarm keeps it away.
    pub fn set_drives(&mut self, on: bool) {
        self.power.order_drives(on);
        if !on {
            self.react();
        } else if !self.supervision.requires_power_off() && self.is_at_rest() {
            self.power.switch_on();
            self.stream.follow(self.setpoint());
            if !self.supervision.is_stopping() {
                self.supervision.enter(SetpointSource::Following);
            }
        }
    }
}
