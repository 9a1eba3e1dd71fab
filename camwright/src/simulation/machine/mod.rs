//! The machine as it runs, one tick after the other.

mod alarm_retract;
mod build_report;
mod command;
mod dressing;
mod fault_injection;
mod inputs;
mod loading;
mod power;
mod probes;
mod snapshot;
mod stream;
mod supervision;
mod sweep;
mod turning;
mod wheel_surface;
mod work_area;

use crate::machine::alarm::{ALARM_KINDS, Alarm, AlarmKind, Severity};
use crate::machine::description::{AXIS_COUNT, Axis, DescriptionError, MachineDescription};
use crate::machine::persistent_state::{LastingState, Tally};
use crate::machine::setpoint::{Input, Latch, Setpoint};
use crate::math::fixed_list::FixedList;
use crate::math::units::TURN_RAD;
use crate::simulation::axis::AxisState;
use crate::simulation::fault::Fault;
use crate::simulation::force_monitor::ForceMonitor;
use crate::simulation::gauge::Gauge;
use crate::simulation::plausibility::Plausibility;
use crate::simulation::sensors::{OriginDetector, OvertravelSwitches, StationSwitch};
use crate::simulation::tick_report::TickReport;
use crate::simulation::turned_part::TurnedRemoval;
use crate::simulation::wheel_spindle::WheelSpindle;
use crate::simulation::work_area::WorkArea;
use crate::simulation::workpiece::{Deflection, Removal, Workpiece};
use alarm_retract::{Draw, Retreat};
use alloc::vec::Vec;
pub use command::{MachineCommand, ResetRefused};
use inputs::{GaugeWatch, References, SwitchWatch};
use probes::GapWatch;
use turning::Clamped;

/// Where the setpoints come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Following,
    /// From the stream until it rests, after an alarm: the tail of the last chunk, and beside it the wheel's way off the part.
    Draining,
    /// From the machine: every axis decelerates at its limit, X goes off the part.
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
    /// Home switches and index marks of the slides that have some.
    references: [Option<References>; AXIS_COUNT],
    /// Edges that somebody asked for, to be told with this tick.
    asked: FixedList<Latch, 4>,
    overtravel: [OvertravelSwitches; AXIS_COUNT],
    beyond: [bool; AXIS_COUNT],
    wheel: WheelSpindle,
    wheel_phase_rad: f64,
    /// Share of what is left to a warm wheelhead that a tick goes.
    warming: f64,
    part: Workpiece,
    /// The part in the chuck of a lathe.
    turned: Option<Clamped>,
    /// What a machine that is loaded is loaded through.
    work_area: Option<WorkArea>,
    /// How wheel and part have given way to each other.
    deflection: Deflection,
    /// Normal force of the wheel on the part (N).
    force_n: f64,
    /// Force with which a wheel that does not turn may press on the part (N).
    push_n: f64,
    force_monitor: ForceMonitor,
    gauge: Option<Gauge>,
    gap: Option<GapWatch>,
    /// Azimuth of the part's key-way as it is clamped (rad): 0 faces the wheel where C is 0.
    key_way_rad: f64,
    /// How far the zero of X was off the machine's own at the last dress (mm).
    dressed_zero_mm: f64,
    since_cut: u32,
    /// Lobe that the wheel took something from last, since the last dress and the last part.
    ground: Option<usize>,
    mode: Mode,
    /// The setpoint of the stream that was followed last, without what an alarm adds to it.
    followed: Setpoint,
    /// The wheel on its way off the part, after an alarm.
    retreat: Option<Retreat>,
    draw: Option<Draw>,
    /// Axes whose drives have no power, and those that lose it now.
    dead: [bool; AXIS_COUNT],
    kill_due: [bool; AXIS_COUNT],
    mains_lost: bool,
    /// Energy left when the mains are lost (J).
    buffered_j: f64,
    /// Inputs on one line.
    shared: Option<[Input; 2]>,
    switch_watch: Vec<SwitchWatch>,
    gauge_watch: GaugeWatch,
    /// Each axis' readings of the last two ticks (counts, true).
    readings: [[i64; 2]; AXIS_COUNT],
    /// Times the ordered speed that the wheel has; ticks for which it has had none though it is to run.
    overspeed: f64,
    wheel_late: u32,
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
        let at_rest = Setpoint { counts: core::array::from_fn(|i| axes[i].setpoint_counts()), ..Setpoint::default() };
        Ok(Self {
            followed: at_rest,
            retreat: None,
            draw: None,
            dead: [false; AXIS_COUNT],
            kill_due: [false; AXIS_COUNT],
            mains_lost: false,
            buffered_j: description.retract.buffered_energy_j,
            shared: None,
            switch_watch: alloc::vec![SwitchWatch::default(); description.stations.len()],
            gauge_watch: GaugeWatch::default(),
            readings: core::array::from_fn(|i| [axes[i].reading(); 2]),
            overspeed: 1.0,
            wheel_late: 0,
            plausibility: Plausibility::new(&description),
            tick: 0,
            step_s,
            origin: OriginDetector::new(libm::round(turn), description.origin_half_window_rad),
            stations: stations.collect(),
            references: core::array::from_fn(|i| {
                let axis = &description.axes[i];
                let homing = axis.homing.as_ref()?;
                Some(References::new(homing, description.switch_hysteresis_mm, &axes[i]))
            }),
            asked: FixedList::new(),
            overtravel,
            beyond: [false; AXIS_COUNT],
            wheel: WheelSpindle::new(&description),
            wheel_phase_rad: 0.0,
            warming: description
                .thermal
                .map_or(0.0, |thermal| -libm::expm1(-description.cycle_time_s() / thermal.time_constant_s)),
            part: Workpiece::default(),
            turned: None,
            work_area: description.loading.map(|loading| WorkArea::new(&loading, description.cycle_time_s())),
            deflection: Deflection::default(),
            force_n: 0.0,
            push_n: 0.0,
            force_monitor: ForceMonitor::default(),
            gauge: description.gauge.map(|gauge| Gauge::new(gauge, description.cycle_time_s())),
            gap: GapWatch::new(&description),
            key_way_rad: 0.0,
            dressed_zero_mm: 0.0,
            since_cut: supervision::CUTTING_TICKS,
            ground: None,
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
        self.lasting.count_part();
        self.ground = None;
    }

    /// Counts what a finished part was found to be.
    pub fn judge_part(&mut self, is_good: bool) {
        self.lasting.judge_part(is_good);
    }

    pub fn reset_shift(&mut self) {
        self.lasting.shift = Tally::default();
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

    /// Where the axes truly are (mm or rad) and how fast (mm/s or rad/s), which no encoder tells: C from the key-way's
    /// centre facing the wheel.
    #[must_use]
    pub fn truth(&self) -> [(f64, f64); AXIS_COUNT] {
        core::array::from_fn(|i| {
            let axis = &self.axes[i];
            (axis.true_position() / axis.counts_per_unit, axis.velocity())
        })
    }

    /// How far the structure of each axis swings ahead of its slide (mm or rad), and how fast that grows (1/s).
    #[must_use]
    pub fn swings(&self) -> [(f64, f64); AXIS_COUNT] {
        core::array::from_fn(|i| self.axes[i].swing())
    }

    /// Distance of the wheel's cutting point from the farthest point of the lobe in front of it (mm, below 0 where it may
    /// touch); `None` where nothing is in front of it.
    #[must_use]
    pub fn wheel_gap_mm(&self) -> Option<f64> {
        let lobe = &self.part.lobes()[self.lobe_in_front()?];
        Some(self.truth()[Axis::X.index()].0 - lobe.reach_mm())
    }

    /// Every axis is clamped at its resting setpoint: from here on any number of idle ticks changes nothing.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.axes.iter().all(AxisState::is_at_rest)
    }

    /// The wheel runs up or down.
    #[must_use]
    pub fn is_wheel_changing(&self) -> bool {
        self.wheel.is_changing()
    }

    /// A job begins: what only chance decides begins anew, so that a job is the same whatever the machine did before.
    pub fn begin_job(&mut self) {
        self.axes.iter_mut().for_each(AxisState::begin_job);
        if let Some(gauge) = &mut self.gauge {
            gauge.begin_job();
        }
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
        for (references, axis) in self.references.iter_mut().zip(&self.axes) {
            if let Some(references) = references {
                references.switch.look(axis.true_position());
            }
        }
        self.switch_watch.fill(SwitchWatch::default());
        self.wheel = self.wheel.at_speed();
        self.followed = self.setpoint();
        self.readings = core::array::from_fn(|i| [self.axes[i].reading(); 2]);
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
        if kind.entry().severity == Severity::Warning {
            return;
        }
        self.note_kill(kind);
        if matches!(kind, AlarmKind::Overtravel(_)) && self.mode != Mode::Halted {
            self.mode = Mode::OwnStop;
        } else if self.mode == Mode::Following {
            self.mode = Mode::Draining;
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
        self.watch_guards();
        self.react();
        if self.powered {
            self.advance_setpoint(setpoint);
        }
        for (axis, _) in self.axes.iter_mut().zip(self.dead).filter(|(_, dead)| *dead) {
            axis.begin_coasting();
        }
        self.turn_wheel();
        let mut latches = FixedList::new();
        for latch in core::mem::take(&mut self.asked).iter() {
            latches.push(*latch);
        }
        let mut removal = Removal::default();
        let mut turned = TurnedRemoval::default();
        let lobe = self.lobe_in_front();
        let law = lobe.and_then(|lobe| self.contact_law(lobe));
        if law.is_none() {
            (self.deflection, self.force_n) = (Deflection::default(), 0.0);
        }
        for index in 0..self.description.servo_steps_per_tick {
            let spans = self.servo_step(index);
            self.sense(&spans, &mut latches);
            if let Some(lobe) = lobe {
                removal = removal.and(self.grind(index, lobe, law.as_ref(), &spans));
            } else if self.turned.is_some() {
                turned = turned.and(self.turn_part(&spans));
            }
        }
        if let Some(clamped) = &mut self.turned {
            clamped.part.refresh();
            removal = self.as_of_a_wheel(&turned);
        }
        self.sense_gap(&mut latches);
        self.turn_on();
        self.watch_force(&mut latches);
        if let Some(lobe) = lobe {
            self.part.lobe_mut(lobe).refresh();
            self.wear_wheel(lobe, removal);
        }
        let cycle_time_s = self.description.cycle_time_s();
        for (axis, _) in self.axes.iter_mut().zip(self.dead).filter(|(_, dead)| !*dead) {
            axis.end_tick(cycle_time_s);
        }
        self.watch_encoders();
        self.watch_following_error();
        self.watch_overtravel();
        self.watch_switches();
        self.watch_wheel(removal);
        let gauge_mm = self.gauge(lobe);
        let gauge_mm = self.spoiled(gauge_mm);
        self.watch_gauge(gauge_mm, lobe, removal);
        self.end_of_retreat();
        self.react();
        self.report(setpoint.is_some(), latches, (lobe, removal, turned), gauge_mm)
    }

    fn apply_command(&mut self, command: MachineCommand) {
        match command {
            MachineCommand::SetHome { axis, counts } => {
                self.axes[axis.index()].set_home(counts);
                let followed = &mut self.followed.counts[axis.index()];
                *followed = followed.saturating_sub(counts);
            }
            MachineCommand::LoseHome { axis } => self.lose_home(axis),
            MachineCommand::Ask { input } => self.tell_level(input),
            MachineCommand::Raise { number } => {
                if let Some(kind) = AlarmKind::from_number(number) {
                    self.raise(kind, f64::NAN, f64::NAN);
                }
            }
            MachineCommand::WheelStart => {
                self.push_n = 0.0;
                self.start_wheel();
            }
            MachineCommand::WheelStop => self.wheel.order(false),
            MachineCommand::ExpectWheel { radius_nm } => self.expect_wheel(radius_nm),
            MachineCommand::Dress { radius_nm } => self.dress(radius_nm),
            MachineCommand::Push { most_n } => self.push_n = most_n as f64,
            MachineCommand::WatchForce { most_n } => self.force_monitor.watch(most_n as f64),
        }
    }
}
