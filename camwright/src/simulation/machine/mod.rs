// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The machine as it runs, one tick after the other.

#[macro_use]
mod snapshot;

mod alarm_retract;
mod axis_watch;
mod build_report;
mod changing;
mod command;
mod contact;
mod contact_modes;
mod fault_injection;
mod gauging;
mod inputs;
mod loading;
mod motion;
mod power;
mod probes;
mod stream;
mod supervision;
mod turning;
mod wheel;
mod work_area;
mod workholding;

use crate::machine::alarm::{ALARM_KINDS, Alarm, AlarmKind};
use crate::machine::description::{AXIS_COUNT, Axis, DescriptionError, MachineDescription};
use crate::machine::persistent_state::{PersistentState, TravelCount};
use crate::machine::setpoint::{Input, Setpoint};
use crate::math::fixed_list::FixedList;
use crate::math::units::TURN_RAD;
use crate::simulation::axis::{AxisState, Span};
use crate::simulation::fault::Fault;
use crate::simulation::measured::{DriveOrders, MAX_LAG_TICKS, Measurement, without_simulated_effects};
use crate::simulation::tick_report::TickReport;
use crate::simulation::turned_part::TurnedRemoval;
use crate::simulation::work_area::WorkArea;
use crate::simulation::workpiece::{Lobe, Removal};
use alarm_retract::Retract;
use axis_watch::AxisWatch;
use changing::ChangerArm;
pub use command::{MachineCommand, ResetRefused};
use contact::{ContactState, LobeSweep};
use gauging::Gauging;
use inputs::{Inputs, ProcessLevels, Sensing};
use power::Power;
use stream::SetpointStream;
use supervision::Supervision;
use wheel::GrindingWheel;
use workholding::{FacedSection, FacedSections, Workholding};

/// Questions that can wait for the readings of a real machine: more than commands of a lag.
const PENDING_ASKS: usize = 8;

/// A simulated machine. See [`Machine::step`].
///
/// Each part owns its state; the machine connects them in the order of a tick.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    description: MachineDescription,
    lasting: PersistentState,
    tick: u64,
    step_s: f64,
    axes: [AxisState; AXIS_COUNT],
    supervision: Supervision,
    axis_watch: AxisWatch,
    inputs: Inputs,
    gauging: Gauging,
    workholding: Workholding,
    contact: ContactState,
    wheel: GrindingWheel,
    /// Arm of the wheel changer of a machine that has one.
    changer: Option<ChangerArm>,
    power: Power,
    stream: SetpointStream,
    retract: Retract,
    /// Door, chuck and sensors of a machine that is loaded.
    work_area: Option<WorkArea>,
    /// Ticks by which readings are older than setpoints: 0 of a simulated machine.
    lag_ticks: u32,
    /// Questions for the level of an input whose tick the readings of a real machine have not reached.
    pending_asks: [Option<(u64, Input)>; PENDING_ASKS],
}

impl Machine {
    /// A machine after power-up: axes at rest where they stood, drives on, wheel still, no part.
    ///
    /// # Errors
    /// Figures that do not make a machine.
    pub fn new(mut description: MachineDescription, lasting: PersistentState) -> Result<Self, DescriptionError> {
        description.validate()?;
        let lasting = lasting.for_machine(&description)?;
        description.mount_wheel(lasting.mounted_wheel())?;
        let step_s = description.cycle_time_s() / f64::from(description.servo_steps_per_tick);
        let axes: [AxisState; AXIS_COUNT] = core::array::from_fn(|i| AxisState::new(&description.axes[i], step_s));
        Ok(Self {
            tick: 0,
            step_s,
            supervision: Supervision::new(),
            axis_watch: AxisWatch::new(&description, &axes),
            inputs: Inputs::new(&description, &axes),
            gauging: Gauging::new(&description),
            workholding: Workholding::default(),
            contact: ContactState::new(&description),
            wheel: GrindingWheel::new(&description),
            changer: description.wheel_changer.as_ref().map(|_| ChangerArm::default()),
            power: Power::new(&description.retract),
            stream: SetpointStream::new(&description, resting_setpoint(&axes)),
            retract: Retract::default(),
            work_area: description.loading.map(|loading| WorkArea::new(&loading, description.cycle_time_s())),
            lag_ticks: 0,
            pending_asks: [None; PENDING_ASKS],
            lasting,
            axes,
            description,
        })
    }

    /// A machine with real axes, which rest where they are measured. `lag_ticks` is the number of ticks between a setpoint and the
    /// readings that show it, `window_counts` the error at which an axis counts as at rest. See [`Machine::step_measured`].
    ///
    /// # Errors
    /// Figures that do not make a machine, a longer lag than [`MAX_LAG_TICKS`].
    pub fn real(
        description: &MachineDescription,
        lasting: PersistentState,
        (lag_ticks, window_counts): (u32, f64),
        at_rest: &Measurement,
    ) -> Result<Self, DescriptionError> {
        if lag_ticks > MAX_LAG_TICKS {
            return Err(DescriptionError::Outside {
                what: "lag of the drives (ticks)",
                value: f64::from(lag_ticks),
                low: 0.0,
                high: f64::from(MAX_LAG_TICKS),
            });
        }
        let mut machine = Self::new(without_simulated_effects(description), lasting)?;
        let (step_s, lag) = (machine.step_s, (lag_ticks as usize, window_counts));
        machine.axes =
            core::array::from_fn(|i| AxisState::real(&machine.description.axes[i], step_s, at_rest.counts[i], lag));
        machine.lag_ticks = lag_ticks;
        // The first report is of tick 1.
        machine.tick = u64::from(lag_ticks);
        machine.inputs.wire(at_rest.inputs);
        machine.stream.follow(machine.setpoint());
        machine.axis_watch.restart(&machine.axes);
        Ok(machine)
    }

    /// Description of the machine.
    #[must_use]
    pub fn description(&self) -> &MachineDescription {
        &self.description
    }

    /// State that outlives the run.
    #[must_use]
    pub fn lasting(&self) -> &PersistentState {
        &self.lasting
    }

    /// Counts a finished part.
    pub fn count_part(&mut self) {
        let ground = self.changer.as_mut().map(ChangerArm::take_ground).unwrap_or_default();
        self.lasting.count_part(ground);
        self.wheel.forget_lobe();
    }

    /// Counts what a finished part was found to be.
    pub fn judge_part(&mut self, is_good: bool) {
        self.lasting.judge_part(is_good);
    }

    pub fn reset_shift(&mut self) {
        self.lasting.shift = TravelCount::default();
    }

    /// The last tick executed; 0 before the first.
    #[must_use]
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// Active alarms, oldest first.
    #[must_use]
    pub fn alarms(&self) -> &FixedList<Alarm, ALARM_KINDS> {
        self.supervision.alarms()
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

    /// True positions (mm or rad) and velocities (mm/s or rad/s) of the axes, which no encoder shows: C from the keyway's
    /// centre facing the wheel.
    #[must_use]
    pub fn truth(&self) -> [(f64, f64); AXIS_COUNT] {
        core::array::from_fn(|i| {
            let axis = &self.axes[i];
            (axis.true_value(), axis.velocity())
        })
    }

    /// Distance by which the structure of each axis is ahead of its slide (mm or rad), and its growth (1/s).
    #[must_use]
    pub fn swings(&self) -> [(f64, f64); AXIS_COUNT] {
        core::array::from_fn(|i| self.axes[i].swing())
    }

    /// Distance of the wheel's cutting point from the farthest point of the lobe sections in front of it (mm, below 0 where it may
    /// touch); `None` where nothing is in front of it.
    #[must_use]
    pub fn wheel_gap_mm(&self) -> Option<f64> {
        let gap_mm = |section: FacedSection| {
            let lobe = &self.workholding.lobes()[section.lobe];
            self.truth()[Axis::X.index()].0 - lobe.reach_mm() - lobe.throw_mm() - section.rim_mm
        };
        let faced = self.workholding.faced(self.table_mm(), &self.description)?;
        Some(faced.beside().map(gap_mm).fold(gap_mm(faced.main), f64::min))
    }

    /// Every axis is clamped at its resting setpoint: from here on any number of idle ticks changes nothing.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.axes.iter().all(AxisState::is_at_rest)
    }

    /// The wheel runs up or down, or another one is being mounted.
    #[must_use]
    pub fn is_wheel_changing(&self) -> bool {
        self.wheel.spindle().is_changing() || self.is_mounting()
    }

    /// A job begins: what only chance decides begins anew, so that a job is the same whatever the machine did before.
    pub fn begin_job(&mut self) {
        self.axes.iter_mut().for_each(AxisState::begin_job);
        self.gauging.begin_job();
    }

    /// Places every axis at rest at a true position (counts), homed, and the wheel at speed: for an offline simulation
    /// that begins in the middle of a job.
    pub fn place(&mut self, counts: [i64; AXIS_COUNT]) {
        for (axis, counts) in self.axes.iter_mut().zip(counts) {
            axis.place(counts);
        }
        self.inputs.restart(&self.axes);
        self.wheel.place_at_speed();
        self.stream.follow(self.setpoint());
        self.axis_watch.restart(&self.axes);
    }

    /// Raises an alarm that another client found, as the node that watches the stream of setpoints.
    ///
    /// An alarm that is active already is not raised again. See [`AlarmKind`] for value and bound.
    pub fn raise(&mut self, kind: AlarmKind, value: f64, bound: f64) {
        self.supervision.raise(self.tick, kind, value, bound);
    }

    /// One tick: faults, commands, then the servo steps towards the setpoint of this tick.
    ///
    /// `setpoint` is in the readings of the axes as they are after this tick's commands; `None` holds the last one. A
    /// setpoint that cannot follow the last one, or none while the setpoint moves, is an alarm and a stop.
    /// Never allocates, locks, logs or fails.
    pub fn step(&mut self, setpoint: Option<&Setpoint>, commands: &[MachineCommand], faults: &[Fault]) -> TickReport {
        self.advance(setpoint, commands, faults, None)
    }

    /// One tick of a machine with real axes: the setpoint of this tick leaves for the drives ([`Machine::orders`]); the readings, and the
    /// report of them, belong to the tick of its lag before.
    pub fn step_measured(
        &mut self,
        setpoint: Option<&Setpoint>,
        commands: &[MachineCommand],
        faults: &[Fault],
        measurement: &Measurement,
    ) -> TickReport {
        self.advance(setpoint, commands, faults, Some(measurement))
    }

    /// Orders for the drives of a real machine, after a tick.
    #[must_use]
    pub fn orders(&self) -> DriveOrders {
        let dead = self.power.dead();
        let powered = |i: &usize| self.power.is_on() && !dead[*i];
        DriveOrders {
            positions: core::array::from_fn(|i| self.axes[i].raw_target()),
            powered: (0..AXIS_COUNT).filter(powered).fold(0, |word, i| word | 1 << i),
            wheel_runs: self.wheel.spindle().is_ordered(),
            wheel_rad_s: self.description.wheel.surface_speed_m_s * 1000.0 / self.lasting.wheel_radius_mm,
        }
    }

    /// The tick that the readings belong to.
    fn shown_tick(&self) -> u64 {
        self.tick.saturating_sub(u64::from(self.lag_ticks))
    }

    fn advance(
        &mut self,
        setpoint: Option<&Setpoint>,
        commands: &[MachineCommand],
        faults: &[Fault],
        measurement: Option<&Measurement>,
    ) -> TickReport {
        self.tick += 1;
        for fault in faults {
            self.apply_fault(*fault);
        }
        for command in commands {
            self.apply_command(*command);
        }
        self.watch_guards();
        self.react();
        if self.power.is_on() {
            self.advance_setpoint(setpoint);
        }
        let dead = self.power.dead();
        for (axis, _) in self.axes.iter_mut().zip(dead).filter(|(_, dead)| *dead) {
            axis.begin_coasting();
        }
        let at_speed = measurement.map(|measured| measured.inputs.wheel_at_speed);
        self.wheel.step(&self.description, &self.lasting, (self.tick, at_speed), &mut self.supervision);
        if let Some(measured) = measurement {
            self.measure(measured);
            self.answer_shown();
        }
        let mut latches = FixedList::new();
        for latch in self.inputs.take_asked().iter() {
            latches.push(*latch);
        }
        let mut removal = Removal::default();
        let mut turned = TurnedRemoval::default();
        let faced = self.workholding.faced(self.table_mm(), &self.description);
        let lobe = faced.map(|faced| faced.main.lobe);
        if faced.is_none_or(|faced| faced.main.law.is_none()) {
            self.contact.separate();
        }
        let key_way = self.workholding.keyway(&self.axes[Axis::C.index()], &self.description);
        self.contact.begin_tick();
        for index in 0..self.description.servo_steps_per_tick {
            let spans = self.servo_step(index);
            let tick = self.shown_tick();
            let sensing =
                &mut Sensing { tick, axes: &self.axes, latches: &mut latches, supervision: &mut self.supervision };
            match measurement {
                None => self.inputs.sense(&spans, key_way.as_ref(), sensing),
                Some(measured) if index == 0 => self.inputs.sense_wired(&measured.marks, sensing),
                Some(_) => {}
            }
            if let Some(faced) = &faced {
                removal = removal.and(self.grind(index, faced, &spans));
            } else if let Some(clamped) = self.workholding.turned_mut() {
                let cuts = self.wheel.spindle().cuts();
                turned = turned.and(clamped.turn(&spans, &self.axes, self.step_s, cuts, &self.description));
            }
        }
        if let Some(faced) = &faced {
            removal = removal.and(self.contact.finish(self.workholding.part_mut(), faced));
        }
        if let Some(clamped) = self.workholding.turned_mut() {
            clamped.part.refresh();
            removal = turning::as_of_a_wheel(&turned, self.description.wheel.width_mm);
        }
        let mut sensing = Sensing {
            tick: self.shown_tick(),
            axes: &self.axes,
            latches: &mut latches,
            supervision: &mut self.supervision,
        };
        self.contact.sense_gap(&mut sensing);
        self.wheel.turn_on(&self.description, &mut self.lasting);
        self.contact.sense_force(&mut self.inputs, &mut sensing);
        if let Some(faced) = &faced {
            self.workholding.lobe_mut(faced.main.lobe).refresh();
            faced.beside().for_each(|section| self.workholding.lobe_mut(section.lobe).refresh());
            self.wheel.wear(faced.main.lobe, removal, &self.description, &mut self.lasting);
        }
        let cycle_time_s = self.description.cycle_time_s();
        for (axis, _) in self.axes.iter_mut().zip(dead).filter(|(_, dead)| !*dead) {
            axis.end_tick(cycle_time_s);
        }
        self.axis_watch.watch(&mut self.axes, &self.description, self.tick, &mut self.supervision);
        let process = self.process_levels();
        self.inputs.watch_switches(&self.axes, process, self.tick, &mut self.supervision);
        self.wheel.watch_contact(removal, self.contact.pushes(), self.tick, &mut self.supervision);
        self.step_changer(removal);
        let gauge_mm = self.gauge(lobe, removal, measurement.map(|measured| measured.gauge_mm));
        let tick = self.shown_tick();
        let sensing =
            &mut Sensing { tick, axes: &self.axes, latches: &mut latches, supervision: &mut self.supervision };
        self.gauging.sense_size(gauge_mm, &self.description, sensing);
        self.end_of_retreat();
        self.react();
        self.report(setpoint.is_some(), latches, (lobe, removal, turned), gauge_mm)
    }

    fn measure(&mut self, measured: &Measurement) {
        for (axis, raw) in self.axes.iter_mut().zip(measured.counts) {
            axis.measure(raw);
        }
        self.inputs.wire(measured.inputs);
        for axis in Axis::ALL {
            self.axis_watch.see_limit(axis, measured.inputs.limit(axis));
        }
    }

    fn apply_command(&mut self, command: MachineCommand) {
        let is_mounting = self.is_mounting();
        let Self { description, lasting, tick, supervision, .. } = self;
        let mut raise = |kind, value, bound| supervision.raise(*tick, kind, value, bound);
        match command {
            MachineCommand::SetHome { axis, counts } => {
                self.axes[axis.index()].set_home(counts);
                self.stream.set_home(axis, counts);
            }
            MachineCommand::LoseHome { axis } => {
                self.axes[axis.index()].lose_home();
                if self.inputs.has_references(axis) {
                    self.ask(Input::Home(axis));
                }
            }
            MachineCommand::Ask { input } => self.ask(input),
            MachineCommand::Raise { number } => {
                if let Some(kind) = AlarmKind::from_number(number) {
                    raise(kind, f64::NAN, f64::NAN);
                }
            }
            MachineCommand::WheelStart if is_mounting => self.refuse_wheel(),
            MachineCommand::WheelStart => {
                self.contact.allow_push(0.0);
                self.wheel.start(self.power.allows_wheel(), description, lasting, raise);
            }
            MachineCommand::WheelStop => self.wheel.stop(),
            MachineCommand::ExpectWheel { radius_nm } => {
                if let Err((kind, value, bound)) = wheel::expect_wheel(radius_nm, lasting, is_mounting) {
                    raise(kind, value, bound);
                }
            }
            MachineCommand::ChangeWheel { wheel } => self.change_wheel(wheel as usize),
            MachineCommand::Dress { radius_nm } => {
                match self.wheel.dress(radius_nm, &self.axes, description, lasting) {
                    Ok(()) => self.changer.iter_mut().for_each(|arm| arm.forget_ground(description.mounted_wheel())),
                    Err((kind, value, bound)) => raise(kind, value, bound),
                }
            }
            MachineCommand::Push { max_n } => self.contact.allow_push(max_n as f64),
            MachineCommand::WatchForce { max_n } => self.contact.watch_force(max_n as f64),
            MachineCommand::WatchSize { diameter_nm } => self.gauging.watch_size(diameter_nm),
        }
    }

    fn ask(&mut self, input: Input) {
        if self.lag_ticks > 0 {
            let free = self.pending_asks.iter_mut().find(|place| place.is_none());
            if let Some(place) = free {
                *place = Some((self.tick, input));
            }
            return;
        }
        let process = self.process_levels();
        self.inputs.ask(input, &self.axes, process, self.tick);
    }

    /// Answers the questions whose tick the readings of a real machine have reached.
    fn answer_shown(&mut self) {
        let shown = self.shown_tick();
        for index in 0..PENDING_ASKS {
            if let Some((tick, input)) = self.pending_asks[index].filter(|(tick, _)| *tick <= shown) {
                let process = self.process_levels();
                self.inputs.ask(input, &self.axes, process, tick);
                self.pending_asks[index] = None;
            }
        }
    }

    fn process_levels(&self) -> ProcessLevels {
        let headstock = &self.axes[Axis::C.index()];
        let key_way = self.workholding.keyway(headstock, &self.description);
        ProcessLevels {
            steady_force: self.contact.is_force_steady(),
            size_reached: self.gauging.is_size_reached(),
            wheel_contact: self.contact.is_gap_closed(),
            key_way: key_way.is_some_and(|key_way| key_way.is_under_switch(headstock.true_position())),
        }
    }

    /// Position of the table (mm).
    fn table_mm(&self) -> f64 {
        self.axes[Axis::Z.index()].true_value()
    }

    fn lobe_in_front(&self) -> Option<usize> {
        self.workholding.lobe_in_front(self.table_mm(), &self.description)
    }

    fn cutting_forces(&self) -> [f64; AXIS_COUNT] {
        let sense = f64::from(self.description.rotation_sense);
        let lobe = if self.contact.force_n() == 0.0 { None } else { self.lobe_in_front() };
        let centre = lobe.and_then(|lobe| self.workholding.lobes()[lobe].centre());
        self.contact.forces_on_axes(&self.axes, self.lasting.wheel_radius_mm, sense, centre)
    }

    /// Sweeps the wheel over the sections of a lobe along a servo step.
    fn grind(&mut self, servo_step: u32, faced: &FacedSections, spans: &[Span; AXIS_COUNT]) -> Removal {
        let (c, x) = (&spans[Axis::C.index()], &spans[Axis::X.index()]);
        if c.is_still() && x.is_still() && !self.contact.vibrates() {
            return Removal::default();
        }
        let sweep = LobeSweep {
            c,
            x,
            per_rad: self.axes[Axis::C.index()].counts_per_unit,
            per_mm: self.axes[Axis::X.index()].counts_per_unit,
            rotation_sense: f64::from(self.description.rotation_sense),
            step_s: self.step_s,
            surface: self.wheel.surface(servo_step, self.step_s, &self.description, &self.lasting),
            cuts: self.wheel.spindle().cuts(),
        };
        self.contact.grind(self.workholding.part_mut(), faced, &sweep)
    }

    /// Readings of the gauge at the end of a tick, while C turns; `measured_mm` are those of a real one.
    fn gauge(
        &mut self,
        lobe: Option<usize>,
        removal: Removal,
        measured_mm: Option<[Option<f64>; 2]>,
    ) -> [Option<f64>; 2] {
        let headstock = &self.axes[Axis::C.index()];
        let lobe = lobe.map(|lobe| &self.workholding.lobes()[lobe]);
        // The gauge stands on the axis, outside of the part: a crank pin passes it by.
        let read = lobe.filter(|lobe| {
            lobe.centre().is_none() && !lobe.is_bore() && (!headstock.is_at_rest() || self.contact.is_push_allowed())
        });
        let sense = f64::from(self.description.rotation_sense);
        let z_mm = self.axes[Axis::Z.index()].true_value();
        let part_mm_n = lobe.map_or(0.0, Lobe::part_mm_n);
        let contact = self.description.contact.as_ref();
        let share = contact.map_or(0.0, |contact| contact.part_share_with(z_mm, part_mm_n));
        let deflection = self.contact.part_deflection(share);
        let readings_mm = self.gauging.read(read, headstock, sense, deflection, measured_mm);
        let round_mm = lobe.map_or(f64::INFINITY, |lobe| TURN_RAD * lobe.reach_mm().abs());
        let cut = (round_mm, removal.area_mm2);
        self.gauging.watch(readings_mm, cut, headstock, &self.description, |kind, value, bound| {
            self.supervision.raise(self.tick, kind, value, bound);
        });
        readings_mm
    }
}

fn resting_setpoint(axes: &[AxisState; AXIS_COUNT]) -> Setpoint {
    Setpoint { counts: core::array::from_fn(|i| axes[i].setpoint_counts()), ..Setpoint::default() }
}
