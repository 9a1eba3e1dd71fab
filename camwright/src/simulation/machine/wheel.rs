// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The grinding wheel: speed and its watch, wear and dressing, and the position of its surface.

use super::supervision::Supervision;
use crate::machine::alarm::AlarmKind;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription, WHEEL_TOLERANCE_MM};
use crate::machine::persistent_state::PersistentState;
use crate::machine::wheel_state::mm_from_nm;
use crate::math::units::TURN_RAD;
use crate::simulation::axis::AxisState;
use crate::simulation::wheel_spindle::WheelSpindle;
use crate::simulation::workpiece::Removal;

/// Distance from the dresser within which the wheel stands at it with a following error (mm).
const AT_DRESSER_MM: f64 = 0.05;

/// Penetration (mm) that a wheel without speed may have before it is called contact: rounding, not touch.
const TOUCH_MM: f64 = 1.0e-4;

/// Ticks after the last cut for which the loss of the wheel's speed counts as in the cut: a spark-out turn removes
/// nothing for a while, and yet the wheel is at the part.
const CUTTING_TICKS: u32 = 1000;

/// Speed of the wheel over the one ordered at which it is stopped.
const MAX_OVERSPEED: f64 = 1.05;

/// Largest angle between two positions of a wheel with unbalance (rad): thirteen of them make a wave.
const WAVE_STEP_RAD: f64 = 0.5;

/// The wheel during one servo step.
#[derive(Debug, Clone, Copy)]
pub(super) struct WheelSurface {
    /// Its radius (mm).
    pub(super) radius_mm: f64,
    /// Its centre from where X is counted, without unbalance (mm).
    pub(super) centre_mm: f64,
    unbalance_mm: f64,
    /// Its phase at the beginning, and by how much it turns (rad).
    phase_rad: f64,
    turn_rad: f64,
}

impl WheelSurface {
    /// Distance by which unbalance throws the centre off the part at fraction `s` of the step (mm).
    pub(super) fn thrown_mm(&self, s: f64) -> f64 {
        if self.unbalance_mm == 0.0 { 0.0 } else { self.unbalance_mm * libm::cos(self.phase_rad + s * self.turn_rad) }
    }

    /// Largest such distance (mm).
    pub(super) fn maximum_thrown_mm(&self) -> f64 {
        self.unbalance_mm
    }

    /// Positions in which the step must be swept for its wave.
    pub(super) fn positions(&self) -> f64 {
        if self.unbalance_mm == 0.0 { 1.0 } else { libm::ceil(self.turn_rad / WAVE_STEP_RAD) }
    }
}

/// The wheel on its spindle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GrindingWheel {
    wheel: WheelSpindle,
    wheel_phase_rad: f64,
    /// Share of the remaining growth of a wheelhead that a tick adds.
    warming: f64,
    since_cut: u32,
    /// Lobe that was cut last, since the last dress and the last part.
    ground: Option<usize>,
    /// Factor of the wheel's speed over the one ordered.
    overspeed: f64,
    /// Twice the ticks for which a wheel that is to run has not had its speed.
    wheel_late: u32,
}

snapshot_groups!(GrindingWheel {
    keep_rotation(fields: wheel, wheel_phase_rad),
    keep_cut(fields: since_cut, ground),
    keep_speed(fields: overspeed, wheel_late),
} on { warming });

impl GrindingWheel {
    /// A wheel at rest.
    pub(super) fn new(description: &MachineDescription) -> Self {
        Self {
            wheel: WheelSpindle::new(description),
            wheel_phase_rad: 0.0,
            warming: description
                .thermal
                .map_or(0.0, |thermal| -libm::expm1(-description.cycle_time_s() / thermal.time_constant_s)),
            since_cut: CUTTING_TICKS,
            ground: None,
            overspeed: 1.0,
            wheel_late: 0,
        }
    }

    pub(super) fn spindle(&self) -> &WheelSpindle {
        &self.wheel
    }

    /// The wheel turns, or is about to.
    pub(super) fn turns(&self) -> bool {
        self.wheel.is_ordered() || !self.wheel.is_still()
    }

    /// Another wheel is mounted at rest.
    pub(super) fn mount(&mut self, description: &MachineDescription) {
        self.wheel.mount(description);
        (self.wheel_phase_rad, self.since_cut, self.ground) = (0.0, CUTTING_TICKS, None);
    }

    /// A keyframe is read into the wheel of this description.
    pub(super) fn prepare_reading(&mut self, description: &MachineDescription) {
        self.wheel.mount(description);
    }

    /// Brings the wheel to its speed at once.
    pub(super) fn place_at_speed(&mut self) {
        self.wheel = self.wheel.at_speed();
    }

    pub(super) fn stop(&mut self) {
        self.wheel.order(false);
    }

    pub(super) fn stall(&mut self, stalled: bool) {
        self.wheel.stall(stalled);
    }

    pub(super) fn set_overspeed(&mut self, factor: f64) {
        self.overspeed = factor;
    }

    /// Lobe that was cut last.
    pub(super) fn ground(&self) -> Option<usize> {
        self.ground
    }

    /// The next cut counts as one of another lobe.
    pub(super) fn forget_lobe(&mut self) {
        self.ground = None;
    }

    /// Brings the wheel to its speed if it is `allowed` to run, unless it would turn faster than it may. A clamped insert raises an alarm.
    pub(super) fn start(
        &mut self,
        allowed: bool,
        description: &MachineDescription,
        lasting: &PersistentState,
        mut raise: impl FnMut(AlarmKind, f64, f64),
    ) {
        let radius_mm = lasting.wheel_radius_mm;
        if self.wheel.is_clamped() {
            raise(AlarmKind::WheelStopped, 0.0, 0.0);
            return;
        }
        if let Err(error) = description.wheel.check_speed(radius_mm) {
            raise(AlarmKind::WheelTooFast, error.speed_rpm, error.max_rpm);
            return;
        }
        self.wheel.order(allowed);
        let smallest_mm = description.wheel.min_radius_mm;
        if radius_mm < smallest_mm {
            raise(AlarmKind::WheelWorn, radius_mm, smallest_mm);
        }
    }

    /// One tick of the spindle, and the watch over its speed.
    pub(super) fn step(
        &mut self,
        description: &MachineDescription,
        lasting: &PersistentState,
        (tick, at_speed): (u64, Option<bool>),
        supervision: &mut Supervision,
    ) {
        let ran = self.wheel.is_running();
        self.wheel.step();
        if let Some(at_speed) = at_speed {
            self.wheel.see_speed(at_speed);
        }
        if supervision.is_stopping() {
            self.wheel_late = 0;
            return;
        }
        if ran && !self.wheel.is_running() && self.wheel.is_ordered() {
            let in_cut = self.since_cut < CUTTING_TICKS;
            let kind = if in_cut { AlarmKind::WheelStoppedInCut } else { AlarmKind::WheelStopped };
            supervision.raise(tick, kind, 0.0, 0.0);
        }
        // Half as long again as it takes, and a tick.
        let late = self.wheel.is_ordered() && !self.wheel.is_running();
        self.wheel_late = if late { self.wheel_late.saturating_add(2) } else { 0 };
        if self.wheel_late > self.wheel.ticks_to_speed().saturating_mul(3).saturating_add(2) {
            supervision.raise(tick, AlarmKind::WheelStopped, 0.0, 0.0);
        }
        let ordered = description.wheel.surface_speed_m_s * 1000.0 / lasting.wheel_radius_mm;
        let (speed, max) = (self.rad_s(lasting), ordered * MAX_OVERSPEED);
        if speed > max {
            let rpm = |rad_s: f64| rad_s / TURN_RAD * 60.0;
            supervision.raise(tick, AlarmKind::WheelOverspeed, rpm(speed), rpm(max));
            self.wheel.order(false);
        }
    }

    /// Raises an alarm if a tool that is ready to cut is over the axis, or a wheel that does not run touches the part without `pushes`.
    pub(super) fn watch_contact(&mut self, removal: Removal, pushes: bool, tick: u64, supervision: &mut Supervision) {
        self.since_cut = if removal.area_mm2 > 0.0 { 0 } else { self.since_cut.saturating_add(1).min(CUTTING_TICKS) };
        let is_ready = self.wheel.is_running() || self.wheel.is_clamped();
        let over_the_axis = is_ready && removal.is_over_axis;
        let still = !is_ready && removal.depth_mm > TOUCH_MM && !pushes;
        // A wheel that an alarm has stopped touches until it is off the part.
        if over_the_axis || (still && !supervision.is_stopping()) {
            supervision.raise(tick, AlarmKind::WheelContact, removal.depth_mm, 0.0);
        }
    }

    /// Measured speed of the wheel (rad/s).
    pub(super) fn rad_s(&self, lasting: &PersistentState) -> f64 {
        self.overspeed * self.wheel.rad_s(lasting.wheel_radius_mm)
    }

    /// Surface of the wheel during a servo step.
    ///
    /// The axis knows the wheel as it was dressed. What it has lost since then is missing at its rim; what the wheelhead had grown by when
    /// it was dressed was taken off it, and what it has grown by now brings it nearer. Unbalance throws its centre about, once a turn,
    /// as far as the wheel is at speed: at half of it a quarter, as the force goes with the square.
    pub(super) fn surface(
        &self,
        servo_step: u32,
        step_s: f64,
        description: &MachineDescription,
        lasting: &PersistentState,
    ) -> WheelSurface {
        let (grown_mm, dressed_mm) = match description.thermal {
            Some(_) => (lasting.growth_mm, lasting.growth_at_dress_mm),
            None => (0.0, 0.0),
        };
        let turn_rad = self.rad_s(lasting) * step_s;
        let share = self.wheel.share_of_speed();
        WheelSurface {
            // The dresser's rim stands where it stands, whatever the zero of X was corrected by before.
            radius_mm: lasting.wheel_radius_mm - lasting.wheel_wear_mm - dressed_mm + lasting.wheel_zero_error_mm,
            centre_mm: lasting.wheel_radius_mm - grown_mm,
            unbalance_mm: description.wheel.unbalance_mm * share * share,
            phase_rad: self.wheel_phase_rad + turn_rad * f64::from(servo_step),
            turn_rad,
        }
    }

    /// Ends a tick: the wheel has turned on, and warms its head. Its phase is counted from where it began to run up.
    pub(super) fn turn_on(&mut self, description: &MachineDescription, lasting: &mut PersistentState) {
        let turned_rad = self.rad_s(lasting) * description.cycle_time_s();
        if turned_rad == 0.0 {
            self.wheel_phase_rad = 0.0;
            return;
        }
        self.wheel_phase_rad = libm::fmod(self.wheel_phase_rad + turned_rad, TURN_RAD);
        if let Some(thermal) = description.thermal {
            // The remaining growth times 1 − exp(−T/τ).
            lasting.growth_mm += (thermal.growth_mm - lasting.growth_mm) * self.warming;
        }
    }

    /// Wears the wheel by the removal of a tick, and counts a lobe that begins with it.
    pub(super) fn wear(
        &mut self,
        lobe: usize,
        removal: Removal,
        description: &MachineDescription,
        lasting: &mut PersistentState,
    ) {
        if removal.area_mm2 <= 0.0 {
            return;
        }
        let worn_mm = lasting.wheel_radius_mm - lasting.wheel_wear_mm;
        lasting.wheel_wear_mm += description.wheel.wear_mm(worn_mm, removal.area_mm2);
        if self.ground != Some(lobe) {
            self.ground = Some(lobe);
            lasting.lobes_since_dress = lasting.lobes_since_dress.saturating_add(1);
        }
    }

    /// Dresses the wheel to a radius; an error is the alarm with its value and bound.
    ///
    /// Positions are as the axes read, since the zero of X may have been corrected. The dresser's rim is where the wheel ends afterwards. With the wheel's cutting point held there the slide follows
    /// the radius by itself, so nothing moves in the machine's coordinates.
    pub(super) fn dress(
        &mut self,
        radius_nm: i64,
        axes: &[AxisState; AXIS_COUNT],
        description: &MachineDescription,
        lasting: &mut PersistentState,
    ) -> Result<(), (AlarmKind, f64, f64)> {
        let wheel = description.wheel;
        let radius_mm = mm_from_nm(radius_nm);
        let worn_mm = lasting.wheel_radius_mm - lasting.wheel_wear_mm;
        let zero_mm = |axis: Axis| axes[axis.index()].zero_value();
        let position = |axis: Axis| axes[axis.index()].true_value() - zero_mm(axis);
        let fits = description.dresser.is_some_and(|dresser| {
            let beside_mm = 0.5 * dresser.traverse_mm(wheel.width_mm) + AT_DRESSER_MM;
            self.wheel.is_running()
                && (position(Axis::X) - dresser.x_mm).abs() <= AT_DRESSER_MM
                && (position(Axis::Z) - dresser.z_mm).abs() <= beside_mm
                // A slip of the decimal point must not cost a wheel; half a nanometre is the rounding of the order.
                && lasting.wheel_radius_mm - radius_mm <= dresser.max_depth_mm + 0.5e-6
        });
        if !fits || radius_mm >= worn_mm || radius_mm < wheel.min_radius_mm || wheel.check_speed(radius_mm).is_err() {
            return Err((AlarmKind::NotDressed, radius_mm, worn_mm));
        }
        *lasting = lasting.dressed(radius_mm, zero_mm(Axis::X));
        self.ground = None;
        Ok(())
    }
}

/// Compares the mounted wheel with the one that a plan expects; an error is the alarm with its value and bound. While the changer mounts
/// another wheel, none is as expected.
pub(super) fn expect_wheel(
    radius_nm: i64,
    lasting: &PersistentState,
    is_mounting: bool,
) -> Result<(), (AlarmKind, f64, f64)> {
    let (wanted_mm, mounted_mm) = (mm_from_nm(radius_nm), lasting.wheel_radius_mm);
    if is_mounting || (wanted_mm - mounted_mm).abs() > WHEEL_TOLERANCE_MM {
        return Err((AlarmKind::OtherWheel, mounted_mm, wanted_mm));
    }
    Ok(())
}
