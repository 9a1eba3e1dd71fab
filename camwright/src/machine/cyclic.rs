//! The machine as it runs, one tick after the other.

use crate::machine::alarm::{ALARM_KINDS, Alarm, AlarmKind, Severity};
use crate::machine::axis::{AxisState, Span};
use crate::machine::contact::Contact;
use crate::machine::description::{AXIS_COUNT, Axis, DescriptionError, MachineDescription};
use crate::machine::fault::Fault;
use crate::machine::plausibility::{Implausible, Plausibility};
use crate::machine::report::{AxisReport, IoState, MAX_LATCHES, MotionState, TickReport};
use crate::machine::sensors::{Edge, OriginDetector, OvertravelSwitches, StationSwitch};
use crate::machine::state::LastingState;
use crate::machine::wheel::WheelSpindle;
use crate::machine::workpiece::{Lobe, LobeError, Removal, WheelPosition, Workpiece};
use crate::numeric::fixed_list::FixedList;
use crate::setpoint::{Input, Latch, Setpoint};
use crate::units::TURN_RAD;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use thiserror::Error;

/// Height of the cusps that the sweep may leave where the part is straight or convex (mm); ten times that, 0.05 µm, on
/// a concave flank whose radius is the wheel's over 0.9, the tightest that is planned.
///
/// Between two positions of the wheel whose centres are d apart, seen from the part, a cusp of d² ρ/(8 R (ρ + R)) stays
/// (R wheel, ρ part, negative where concave): at most d²/(8 R) on convex parts, which gives the largest d.
const CUSP_MM: f64 = 5.0e-6;

/// Penetration (mm) that a wheel without speed may have before it is called contact: rounding, not touch.
const TOUCH_MM: f64 = 1.0e-4;

/// Ticks after the last cut for which the loss of the wheel's speed counts as in the cut: a spark-out turn removes
/// nothing for a while, and yet the wheel is at the part.
const CUTTING_TICKS: u32 = 1000;

/// Orders that take effect at the tick they are given to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MachineCommand {
    /// The reading `counts` of this axis is its zero from now on; setpoints from this tick on are in the new reading.
    SetHome {
        /// Which axis.
        axis: Axis,
        /// The reading that becomes 0 (counts).
        counts: i64,
    },
    /// Bring the wheel to its surface speed.
    WheelStart,
    /// Let the wheel come to rest.
    WheelStop,
}

/// Why a reset was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ResetRefused {
    /// The emergency stop is still pressed.
    #[error("the emergency stop is pressed")]
    EStopPressed,
    /// A drive still reports its fault.
    #[error("the drive of {} still reports a fault", .0.joint())]
    DriveFault(Axis),
    /// An axis is not at rest yet.
    #[error("{} is not at rest yet", .0.joint())]
    Moving(Axis),
}

/// Where the setpoints come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    /// From the stream.
    Following,
    /// From the stream until it rests, after an alarm: the tail of the last chunk.
    Draining,
    /// From the machine: every axis decelerates at its limit.
    OwnStop,
    /// Nowhere: the axes hold until a reset.
    Halted,
}

/// A simulated machine. See [`Machine::step`].
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    description: MachineDescription,
    plausibility: Plausibility,
    lasting: LastingState,
    tick: u64,
    step_s: f64,
    axes: [AxisState; AXIS_COUNT],
    origin: OriginDetector,
    stations: Vec<StationSwitch>,
    overtravel: [OvertravelSwitches; AXIS_COUNT],
    beyond: [bool; AXIS_COUNT],
    wheel: WheelSpindle,
    part: Workpiece,
    contact: Contact,
    since_cut: u32,
    mode: Mode,
    drives_ordered: bool,
    powered: bool,
    power_off_due: bool,
    estop: bool,
    drive_faults: [bool; AXIS_COUNT],
    alarms: FixedList<Alarm, ALARM_KINDS>,
    raised: FixedList<Alarm, ALARM_KINDS>,
}

impl Machine {
    /// A machine after power-up: axes at rest where they stood, drives on, wheel still, no part.
    ///
    /// # Errors
    /// Figures that do not make a machine.
    pub fn new(description: MachineDescription, lasting: LastingState) -> Result<Self, DescriptionError> {
        description.validate()?;
        if !(lasting.wheel_radius_mm > 0.0 && lasting.wheel_radius_mm.is_finite()) {
            return Err(DescriptionError::NotPositive {
                what: "present wheel radius (mm)",
                value: lasting.wheel_radius_mm,
            });
        }
        let step_s = description.cycle_time_s() / f64::from(description.servo_steps_per_tick);
        let axes: [AxisState; AXIS_COUNT] = core::array::from_fn(|i| AxisState::new(&description.axes[i], step_s));
        let table = &axes[Axis::Z.index()];
        let per_mm = table.counts_per_unit;
        let stations = description.stations.iter().map(|station| {
            let start = table.scale.counts(station.position_mm) as f64;
            let (dog, hysteresis) = (description.dog_length_mm * per_mm, description.switch_hysteresis_mm * per_mm);
            StationSwitch::new(start, dog, hysteresis, table.true_position())
        });
        let overtravel = core::array::from_fn(|i| {
            let (min, max) = description.axes[i].overtravel.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
            OvertravelSwitches::new(min * axes[i].counts_per_unit, max * axes[i].counts_per_unit)
        });
        let turn = TURN_RAD * axes[Axis::C.index()].counts_per_unit;
        Ok(Self {
            plausibility: Plausibility::new(&description),
            tick: 0,
            step_s,
            origin: OriginDetector::new(libm::round(turn), description.origin_half_window_rad),
            stations: stations.collect(),
            overtravel,
            beyond: [false; AXIS_COUNT],
            wheel: WheelSpindle::new(&description),
            part: Workpiece::default(),
            contact: Contact::Rigid,
            since_cut: CUTTING_TICKS,
            mode: Mode::Following,
            drives_ordered: true,
            powered: true,
            power_off_due: false,
            estop: false,
            drive_faults: [false; AXIS_COUNT],
            alarms: FixedList::new(),
            raised: FixedList::new(),
            lasting,
            axes,
            description,
        })
    }

    /// What the machine is.
    #[must_use]
    pub fn description(&self) -> &MachineDescription {
        &self.description
    }

    /// What outlives the run.
    #[must_use]
    pub fn lasting(&self) -> &LastingState {
        &self.lasting
    }

    /// Counts a finished part.
    pub fn count_part(&mut self) {
        self.lasting.part_count = self.lasting.part_count.saturating_add(1);
    }

    /// The last tick executed; 0 before the first.
    #[must_use]
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// The part between the centres.
    #[must_use]
    pub fn part(&self) -> &Workpiece {
        &self.part
    }

    /// Active alarms, oldest first.
    #[must_use]
    pub fn alarms(&self) -> &FixedList<Alarm, ALARM_KINDS> {
        &self.alarms
    }

    /// The setpoint of the last tick, in the present readings: where the next one must continue.
    #[must_use]
    pub fn setpoint(&self) -> Setpoint {
        Setpoint {
            counts: core::array::from_fn(|i| self.axes[i].setpoint_counts()),
            velocity: core::array::from_fn(|i| self.axes[i].setpoint_velocity()),
            acceleration: core::array::from_fn(|i| self.axes[i].target().acceleration / self.axes[i].counts_per_unit),
        }
    }

    /// Every axis is clamped at its resting setpoint: from here on any number of idle ticks changes nothing.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.axes.iter().all(AxisState::is_at_rest)
    }

    /// Puts one lobe of a raw part between the centres, in the place of one with the same name: radii (mm) at azimuths
    /// i·2π/n from the key-way, in front of the wheel when the table stands at the station's position.
    ///
    /// # Errors
    /// An unknown station or one that is taken, an outline that is none.
    pub fn load_lobe(&mut self, name: &str, station: &str, width_mm: f64, radii: Vec<f64>) -> Result<(), LobeError> {
        let index = self
            .description
            .stations
            .iter()
            .position(|s| s.switch == station)
            .ok_or_else(|| LobeError::UnknownStation { name: name.to_string(), station: station.to_string() })?;
        if let Some(other) = self.part.lobes().iter().find(|lobe| lobe.station() == index && lobe.name() != name) {
            return Err(LobeError::StationTaken {
                name: name.to_string(),
                station: station.to_string(),
                other: other.name().to_string(),
            });
        }
        self.part.load(Lobe::new(String::from(name), index, width_mm, radii)?);
        Ok(())
    }

    /// Takes the part out.
    pub fn clear_part(&mut self) {
        self.part.clear();
    }

    /// Places every axis at rest at a true position (counts), homed, and the wheel at speed: for an offline simulation
    /// that begins in the middle of a job.
    pub fn place(&mut self, counts: [i64; AXIS_COUNT]) {
        for (axis, counts) in self.axes.iter_mut().zip(counts) {
            axis.place(counts);
        }
        let table = self.axes[Axis::Z.index()].true_position();
        for switch in &mut self.stations {
            switch.look(table);
        }
        self.wheel = self.wheel.at_speed();
    }

    /// Raises an alarm that somebody else found, as the node that watches the stream of setpoints.
    ///
    /// An alarm that is active already is not raised again. See [`AlarmKind`] for value and bound.
    pub fn raise(&mut self, kind: AlarmKind, value: f64, bound: f64) {
        if self.alarms.iter().any(|alarm| alarm.kind == kind) {
            return;
        }
        let alarm = Alarm { kind, tick: self.tick, value, bound };
        self.alarms.push(alarm);
        self.raised.push(alarm);
        match kind.entry().severity {
            Severity::Warning => {}
            Severity::Stop => {
                if self.mode == Mode::Following {
                    self.mode = Mode::Draining;
                }
            }
            Severity::PowerOff => self.power_off_due = true,
        }
    }

    /// Clears the alarms whose causes are gone and gives the drives their power again. The axes hold where they are;
    /// nothing that was under way is resumed.
    ///
    /// # Errors
    /// Emergency stop pressed, a drive fault that persists, axes that are not at rest yet; nothing has changed then.
    pub fn reset(&mut self) -> Result<(), ResetRefused> {
        if self.estop {
            return Err(ResetRefused::EStopPressed);
        }
        for axis in Axis::ALL {
            if self.drive_faults[axis.index()] {
                return Err(ResetRefused::DriveFault(axis));
            }
            if !self.axes[axis.index()].is_at_rest() {
                return Err(ResetRefused::Moving(axis));
            }
        }
        self.alarms = FixedList::new();
        self.power_off_due = false;
        self.powered = self.drives_ordered;
        self.mode = Mode::Following;
        Ok(())
    }

    /// Orders power for the drives, or none: then the axes brake. Power comes only when no alarm keeps it away.
    pub fn set_drives(&mut self, on: bool) {
        self.drives_ordered = on;
        let kept_off = self.alarms.iter().any(|alarm| alarm.kind.entry().severity == Severity::PowerOff);
        if !on {
            self.power_off_due = true;
            self.react();
        } else if !kept_off && self.is_at_rest() {
            self.powered = true;
            if self.alarms.iter().all(|alarm| alarm.kind.entry().severity == Severity::Warning) {
                self.mode = Mode::Following;
            }
        }
    }

    /// One tick: faults, commands, then the servo steps towards the setpoint of this tick.
    ///
    /// `setpoint` is in the readings of the axes as they are after this tick's commands; `None` holds the last one. A
    /// setpoint that cannot follow the last one, or none while the setpoint moves, is an alarm and a stop.
    /// Never allocates, locks, logs or fails.
    pub fn step(&mut self, setpoint: Option<&Setpoint>, commands: &[MachineCommand], faults: &[Fault]) -> TickReport {
        self.tick += 1;
        for fault in faults {
            self.apply_fault(*fault);
        }
        for command in commands {
            self.apply_command(*command);
        }
        self.react();
        if self.powered {
            self.advance_setpoint(setpoint);
        } else {
            self.axes.iter_mut().for_each(AxisState::begin_coasting);
        }
        self.turn_wheel();
        let mut latches = FixedList::new();
        let mut removal = Removal::default();
        let lobe = self.lobe_in_front();
        for index in 0..self.description.servo_steps_per_tick {
            let spans = self.servo_step(index);
            self.sense(&spans, &mut latches);
            if let Some(lobe) = lobe {
                removal = removal.and(self.grind(lobe, &spans));
            }
        }
        if let Some(lobe) = lobe {
            self.part.lobe_mut(lobe).refresh();
        }
        if self.powered {
            let cycle_time_s = self.description.cycle_time_s();
            self.axes.iter_mut().for_each(|axis| axis.end_tick(cycle_time_s));
            self.watch_following_error();
        }
        self.watch_overtravel();
        self.watch_wheel(removal);
        self.react();
        self.report(setpoint.is_some(), latches, lobe, removal)
    }

    fn apply_fault(&mut self, fault: Fault) {
        match fault {
            Fault::EStop(pressed) => {
                self.estop = pressed;
                if pressed {
                    self.raise(AlarmKind::EStop, 0.0, 0.0);
                    self.wheel.order(false);
                }
            }
            Fault::StuckInput { input: Input::Origin, level } => self.origin.set_stuck(level),
            Fault::StuckInput { input: Input::Station(index), level } => {
                if let Some(switch) = self.stations.get_mut(index) {
                    switch.set_stuck(level);
                }
            }
            Fault::EncoderOffset { axis, offset } => {
                let axis = &mut self.axes[axis.index()];
                axis.set_encoder_offset(offset * axis.counts_per_unit);
            }
            Fault::DriveGain { axis, factor } => self.axes[axis.index()].set_gain(factor),
            Fault::DriveFault { axis, active } => {
                self.drive_faults[axis.index()] = active;
                if active {
                    self.raise(AlarmKind::DriveFault(axis), 0.0, 0.0);
                }
            }
            Fault::WheelStall(stalled) => self.wheel.stall(stalled),
        }
    }

    fn apply_command(&mut self, command: MachineCommand) {
        match command {
            MachineCommand::SetHome { axis, counts } => self.axes[axis.index()].set_home(counts),
            MachineCommand::WheelStart => {
                self.wheel.order(!self.estop);
                if self.lasting.wheel_radius_mm < self.description.wheel.min_radius_mm {
                    let smallest = self.description.wheel.min_radius_mm;
                    self.raise(AlarmKind::WheelWorn, self.lasting.wheel_radius_mm, smallest);
                }
            }
            MachineCommand::WheelStop => self.wheel.order(false),
        }
    }

    /// Takes the power away when an alarm asks for it.
    fn react(&mut self) {
        if core::mem::take(&mut self.power_off_due) && self.powered {
            self.powered = false;
            self.mode = Mode::Halted;
            self.axes.iter_mut().for_each(AxisState::release);
        }
    }

    fn advance_setpoint(&mut self, setpoint: Option<&Setpoint>) {
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

    fn setpoint_moves(&self) -> bool {
        self.axes.iter().any(|axis| axis.target().velocity != 0.0)
    }

    /// Why a setpoint cannot be followed: the alarm with its value and bound.
    fn refusal(&self, setpoint: &Setpoint) -> Option<(AlarmKind, f64, f64)> {
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

    fn turn_wheel(&mut self) {
        let ran = self.wheel.is_running();
        self.wheel.step();
        let lost = ran && !self.wheel.is_running() && (self.wheel.is_ordered() || self.estop);
        if lost && self.since_cut < CUTTING_TICKS {
            self.raise(AlarmKind::WheelStoppedInCut, 0.0, 0.0);
        }
    }

    fn servo_step(&mut self, index: u32) -> [Span; AXIS_COUNT] {
        let (count, step_s, powered) = (self.description.servo_steps_per_tick, self.step_s, self.powered);
        core::array::from_fn(|i| if powered { self.axes[i].step(index, count, step_s) } else { self.axes[i].coast() })
    }

    /// Inputs along a servo step.
    fn sense(&mut self, spans: &[Span; AXIS_COUNT], latches: &mut FixedList<Latch, MAX_LATCHES>) {
        let tick = self.tick;
        let (headstock, table) = (&spans[Axis::C.index()], &spans[Axis::Z.index()]);
        let mut caught = |axis: Axis, input: Input, edge: Edge, state: &AxisState| {
            latches.push(Latch { tick, input, rising: edge.rising, axis, counts: state.reading_at(edge.position) });
        };
        if !headstock.is_still()
            && let Some(edge) = self.origin.edge(headstock.from, headstock.to)
        {
            caught(Axis::C, Input::Origin, edge, &self.axes[Axis::C.index()]);
        }
        if !table.is_still() {
            for (index, switch) in self.stations.iter_mut().enumerate() {
                for edge in switch.pass(table.from, table.to).into_iter().flatten() {
                    caught(Axis::Z, Input::Station(index), edge, &self.axes[Axis::Z.index()]);
                }
            }
        }
    }

    /// The lobe that stands in front of the wheel: the one whose width overlaps the wheel's, the nearest if several do.
    /// A lobe is centred on the wheel when the table stands at its station's position.
    fn lobe_in_front(&self) -> Option<usize> {
        let table = &self.axes[Axis::Z.index()];
        let z = table.true_position() / table.counts_per_unit;
        let distance = |lobe: &Lobe| (z - self.description.stations[lobe.station()].position_mm).abs();
        self.part
            .lobes()
            .iter()
            .enumerate()
            .filter(|(_, lobe)| distance(lobe) < 0.5 * (lobe.width_mm() + self.description.wheel.width_mm))
            .min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)))
            .map(|(index, _)| index)
    }

    /// The wheel sweeps the lobe along a servo step, in steps so small that the cusps between them do not matter.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to u32 before the cast")]
    fn grind(&mut self, lobe: usize, spans: &[Span; AXIS_COUNT]) -> Removal {
        let (c, x) = (&spans[Axis::C.index()], &spans[Axis::X.index()]);
        if c.is_still() && x.is_still() {
            return Removal::default();
        }
        let radius_mm = self.lasting.wheel_radius_mm;
        let (per_mm, per_rad) =
            (self.axes[Axis::X.index()].counts_per_unit, self.axes[Axis::C.index()].counts_per_unit);
        let turn = libm::round(TURN_RAD * per_rad);
        let sense = f64::from(self.description.rotation_sense);
        let lobe = self.part.lobe_mut(lobe);
        // Between its ends the cubic swings out by less than the speeds at its ends times the step.
        let swing = (x.from_velocity.abs() + x.to_velocity.abs()) * self.step_s;
        if (x.from.min(x.to) - swing) / per_mm >= lobe.reach_mm() {
            return Removal::default();
        }
        let centre = x.from.max(x.to) / per_mm + radius_mm;
        let path = (c.to - c.from).abs() / per_rad * centre + (x.to - x.from).abs() / per_mm;
        let longest = libm::sqrt(8.0 * radius_mm * CUSP_MM);
        let positions = libm::ceil(path / longest).clamp(1.0, 10_000.0) as u32;
        let mut removal = Removal::default();
        for j in 1..=positions {
            let s = f64::from(j) / f64::from(positions);
            let wheel = WheelPosition {
                azimuth_rad: sense * libm::fmod(c.at(s, self.step_s), turn) / turn * TURN_RAD,
                centre_mm: x.at(s, self.step_s) / per_mm + radius_mm,
                radius_mm,
            };
            removal = removal.and(lobe.pass(wheel, self.contact, self.wheel.is_running()));
        }
        removal
    }

    /// `LinuxCNC`'s rule: the limit grows with the speed asked for, but is never below its floor.
    fn watch_following_error(&mut self) {
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
    fn watch_overtravel(&mut self) {
        for axis in Axis::ALL {
            let i = axis.index();
            let position = self.axes[i].true_position();
            let beyond = self.overtravel[i].beyond(position);
            if let Some(limit) = beyond.filter(|_| !self.beyond[i]) {
                let per_unit = self.axes[i].counts_per_unit;
                self.raise(AlarmKind::Overtravel(axis), position / per_unit, limit / per_unit);
            }
            self.beyond[i] = beyond.is_some();
        }
    }

    fn watch_wheel(&mut self, removal: Removal) {
        self.since_cut = if removal.area_mm2 > 0.0 { 0 } else { self.since_cut.saturating_add(1).min(CUTTING_TICKS) };
        let over_the_axis = self.wheel.is_running() && removal.depth_mm > 0.0 && removal.area_mm2 == 0.0;
        let still = !self.wheel.is_running() && removal.depth_mm > TOUCH_MM;
        let known = self.alarms.iter().any(|alarm| alarm.kind == AlarmKind::WheelStoppedInCut);
        if over_the_axis || (still && !known) {
            self.raise(AlarmKind::WheelContact, removal.depth_mm, 0.0);
        }
    }

    fn motion(&self, has_setpoint: bool) -> MotionState {
        let at_rest = self.is_at_rest();
        let needs_reset = self.alarms.iter().any(|alarm| alarm.kind.entry().severity > Severity::Warning);
        match (needs_reset, at_rest, self.powered) {
            (true, true, _) => MotionState::Fault,
            (true, false, _) => MotionState::Stopping,
            (false, _, false) => MotionState::Off,
            (false, true, true) if !has_setpoint => MotionState::Standstill,
            _ => MotionState::Running,
        }
    }

    fn io(&self) -> IoState {
        let position = |axis: Axis| self.axes[axis.index()].true_position();
        let closed = |axis: Axis| self.overtravel[axis.index()].closed(position(axis));
        let ((overtravel_x_min, overtravel_x_max), (overtravel_z_min, overtravel_z_max)) =
            (closed(Axis::X), closed(Axis::Z));
        let stations = self.stations.iter().enumerate();
        IoState {
            origin: self.origin.is_closed(position(Axis::C)),
            stations: stations.fold(0, |word, (i, switch)| word | u64::from(switch.is_closed()) << i),
            overtravel_x_min,
            overtravel_x_max,
            overtravel_z_min,
            overtravel_z_max,
            estop: self.estop,
            drives_on: self.powered,
            wheel_running: self.wheel.is_running(),
            part_present: !self.part.is_empty(),
        }
    }

    fn report(
        &mut self,
        has_setpoint: bool,
        latches: FixedList<Latch, MAX_LATCHES>,
        lobe: Option<usize>,
        removal: Removal,
    ) -> TickReport {
        let cycle_time_s = self.description.cycle_time_s();
        TickReport {
            tick: self.tick,
            axes: core::array::from_fn(|i| {
                let axis = &self.axes[i];
                AxisReport {
                    setpoint_counts: axis.setpoint_counts(),
                    counts: axis.counts(),
                    position: axis.scale.position(axis.counts()),
                    velocity: axis.velocity(),
                    effort: axis.effort(cycle_time_s),
                    following_error: axis.following_error(),
                    is_at_rest: axis.is_at_rest(),
                    is_homed: axis.homed,
                }
            }),
            latches,
            io: self.io(),
            raised: core::mem::take(&mut self.raised),
            motion: self.motion(has_setpoint),
            lobe,
            removal,
            wheel_rad_s: self.wheel.rad_s(self.lasting.wheel_radius_mm),
        }
    }
}
