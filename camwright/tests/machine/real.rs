// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Real axes: the machine's supervision with readings that are some ticks old.

use super::{HOMING_AT_A_SWITCH, cam_grinder, travel};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{AXIS_COUNT, Axis, GaugeDescription, GaugeKind, Homing, MachineDescription};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::setpoint::{Input, Setpoint};
use camwright::simulation::fault::Fault;
use camwright::simulation::measured::{Measurement, WiredInputs};
use camwright::simulation::tick_report::{MotionState, TickReport};
use camwright::simulation::{Machine, MachineCommand};
use std::collections::VecDeque;

const LAG: u32 = 7;
const X: usize = Axis::X as usize;

/// Drives that follow exactly, a lag later.
struct DelayLine {
    machine: Machine,
    on_the_way: VecDeque<[i64; AXIS_COUNT]>,
    counts: [i64; AXIS_COUNT],
    inputs: WiredInputs,
    marks: [Option<i64>; AXIS_COUNT],
    gauge_mm: [Option<f64>; 2],
}

impl DelayLine {
    fn new(description: &MachineDescription, counts: [i64; AXIS_COUNT]) -> Self {
        Self::with_lag(description, counts, LAG)
    }

    fn with_lag(description: &MachineDescription, counts: [i64; AXIS_COUNT], lag: u32) -> Self {
        let at_rest = Measurement { counts, ..Measurement::default() };
        let machine = Machine::real(description, PersistentState::new(description), (lag, 2.0), &at_rest);
        let machine = machine.expect("the reference machine is valid");
        Self {
            machine,
            on_the_way: vec![counts; lag as usize].into(),
            counts,
            inputs: at_rest.inputs,
            marks: at_rest.marks,
            gauge_mm: at_rest.gauge_mm,
        }
    }

    fn measurement(&self) -> Measurement {
        Measurement { counts: self.counts, inputs: self.inputs, marks: self.marks, gauge_mm: self.gauge_mm }
    }

    fn step(&mut self, setpoint: Option<&Setpoint>, commands: &[MachineCommand]) -> TickReport {
        self.counts = self.on_the_way.pop_front().expect("it holds the lag");
        let report = self.machine.step_measured(setpoint, commands, &[], &self.measurement());
        #[allow(clippy::cast_possible_truncation, reason = "positions of a machine")]
        self.on_the_way.push_back(self.machine.orders().positions.map(|position| position.round() as i64));
        report
    }

    fn step_fault(&mut self, fault: Fault) {
        let measurement = self.measurement();
        self.machine.step_measured(None, &[], &[fault], &measurement);
    }

    fn follow(&mut self, setpoints: &[Setpoint]) -> Vec<TickReport> {
        setpoints.iter().map(|setpoint| self.step(Some(setpoint), &[])).collect()
    }

    fn idle(&mut self, ticks: u32) -> Vec<TickReport> {
        (0..ticks).map(|_| self.step(None, &[])).collect()
    }
}

fn start(description: &MachineDescription) -> [i64; AXIS_COUNT] {
    std::array::from_fn(|i| description.axes[i].scale.counts(description.axes[i].power_up_position))
}

#[test]
fn readings_belong_to_the_setpoint_of_their_tick() {
    let description = cam_grinder();
    let mut plant = DelayLine::new(&description, start(&description));
    let setpoints = travel(&plant.machine, Axis::X, -20.0, 200);
    let first = plant.machine.tick() + 1;
    let mut reports = plant.follow(&setpoints);
    reports.extend(plant.idle(50));
    for (k, setpoint) in setpoints.iter().enumerate() {
        // The report of the tick comes a lag later.
        let report = &reports[k + LAG as usize];
        assert_eq!(report.tick, first + k as u64);
        let axis = &report.axes[X];
        assert_eq!((axis.setpoint_counts, axis.counts), (setpoint.counts[X], setpoint.counts[X]), "tick {k}");
        assert!(axis.following_error.abs() < 1e-9);
    }
    let last = reports.last().expect("reports");
    assert_eq!((last.motion, plant.machine.alarms().len()), (MotionState::Standstill, 0));
    let moving = reports.iter().position(|report| report.motion == MotionState::Standstill).expect("it comes to rest");
    assert!(moving > 200, "it rests only when its encoder shows it");
}

/// The last counts of a gentle travel are within the window of an axis at rest while setpoints are still on their way.
#[test]
fn an_axis_rests_only_when_all_setpoints_are_shown() {
    let description = cam_grinder();
    let mut plant = DelayLine::with_lag(&description, start(&description), 40);
    let setpoints = travel(&plant.machine, Axis::X, -0.001, 200);
    let mut reports = plant.follow(&setpoints);
    reports.extend(plant.idle(80));
    let end = setpoints.last().expect("setpoints").counts[X];
    let rest =
        reports.iter().skip(100).find(|report| report.motion == MotionState::Standstill).expect("it comes to rest");
    assert_eq!((rest.axes[X].setpoint_counts, rest.axes[X].counts), (end, end));
}

/// Without power the setpoint is where the axis is, but does not follow the noise of the encoder.
#[test]
fn noise_does_not_move_the_setpoint_of_an_axis_without_power() {
    let description = cam_grinder();
    let mut plant = DelayLine::new(&description, start(&description));
    plant.step_fault(Fault::EStop(true));
    let noisy = |plant: &mut DelayLine| {
        let stands = start(&description)[X];
        let setpoints: Vec<i64> = (0..40)
            .map(|tick| {
                plant.on_the_way[0][X] = stands + tick % 2;
                plant.step(None, &[]).axes[X].setpoint_counts
            })
            .collect();
        setpoints
    };
    noisy(&mut plant);
    let setpoints = noisy(&mut plant);
    assert!(setpoints.windows(2).all(|pair| pair[0] == pair[1]), "{setpoints:?}");
    plant.step_fault(Fault::EStop(false));
    plant.machine.reset().expect("it rests");
}

#[test]
fn a_drive_that_stays_behind_trips_with_its_error() {
    let description = cam_grinder();
    let mut plant = DelayLine::new(&description, start(&description));
    let setpoints = travel(&plant.machine, Axis::X, -20.0, 200);
    let stuck = plant.counts;
    let mut alarms = Vec::new();
    for setpoint in &setpoints {
        plant.on_the_way[0] = stuck;
        alarms.extend(plant.step(Some(setpoint), &[]).raised.iter().copied());
    }
    let trip = alarms.iter().find(|alarm| alarm.kind == AlarmKind::FollowingError(Axis::X)).expect("it trips");
    assert!(trip.value > trip.bound && trip.bound >= description.axes[X].min_following_error);
    // Without power, the setpoint is where the axis is.
    plant.on_the_way.iter_mut().for_each(|counts| *counts = stuck);
    for _ in 0..40 {
        plant.step(None, &[]);
    }
    assert!((plant.machine.orders().positions[X] - stuck[X] as f64).abs() < 0.5);
    assert_eq!(plant.machine.orders().powered, 0);
}

#[test]
fn homing_moves_the_zero_and_not_the_axis() {
    let mut description = cam_grinder();
    description.axes[X].needs_homing = true;
    description.axes[X].homing = Some(HOMING_AT_A_SWITCH);
    // The encoder reads anything at power-up; the axis stands 30 mm before its switch.
    let mut plant = DelayLine::new(&description, [0, 777_777, 0]);
    let setpoints = travel(&plant.machine, Axis::X, 40.0, 400);
    let per_mm = 100_000;
    let (mut latch, mut edge) = (None, 0);
    for setpoint in &setpoints {
        let before = plant.on_the_way[0][X];
        let is_closed = before - 777_777 >= 30 * per_mm;
        if is_closed && plant.inputs.homes == 0 {
            (plant.inputs.homes, edge) = (1 << X, before - 777_777);
        }
        let report = plant.step(Some(setpoint), &[]);
        latch = latch.or(report.latches.iter().find(|latch| latch.input == Input::Home(Axis::X)).copied());
    }
    plant.idle(40);
    let latch = latch.expect("the switch was passed");
    // The edge lies in the tick in which it shows, within what the axis travels in it.
    let travel_counts = 40 * per_mm * 2 / 400;
    assert!(latch.rising && (latch.counts - edge).abs() <= travel_counts, "{} {edge}", latch.counts);
    let stands = plant.machine.orders().positions[X];
    let reading = plant.machine.setpoint().counts[X];
    plant.step(None, &[MachineCommand::SetHome { axis: Axis::X, counts: latch.counts }]);
    let reports = plant.idle(LAG + 1);
    assert_eq!(plant.machine.setpoint().counts[X], reading - latch.counts);
    assert!((plant.machine.orders().positions[X] - stands).abs() < 0.5, "nothing moves");
    // Readings of earlier ticks keep their zero.
    assert_eq!(reports[0].axes[X].counts, reading);
    assert_eq!(reports[LAG as usize].axes[X].counts, reading - latch.counts);
    assert_eq!(plant.machine.alarms().len(), 0);
}

/// The encoder catches its index mark itself: the zero is that of the mark, to the count, before and after a homing.
#[test]
fn an_index_mark_is_latched_to_the_count() {
    let mut description = cam_grinder();
    description.axes[X].needs_homing = true;
    description.axes[X].homing = Some(Homing { use_index: true, ..HOMING_AT_A_SWITCH });
    let start = 777_777;
    let mut plant = DelayLine::new(&description, [0, start, 0]);
    let pass = |plant: &mut DelayLine, mark: i64, distance: f64| {
        let mut latches = Vec::new();
        for setpoint in travel(&plant.machine, Axis::X, distance, 200) {
            let (before, now) = (plant.counts[X], plant.on_the_way[0][X]);
            let passed = (before < mark && mark <= now) || (now <= mark && mark < before);
            plant.marks[X] = passed.then_some(mark);
            latches.extend(plant.step(Some(&setpoint), &[]).latches.iter().copied());
        }
        plant.marks[X] = None;
        plant.idle(40);
        latches
    };
    let mark = start + 123_457;
    let latches = pass(&mut plant, mark, 3.0);
    let [latch] = latches.as_slice() else { panic!("{latches:?}") };
    assert_eq!((latch.input, latch.rising, latch.counts), (Input::Index(Axis::X), true, mark - start));
    // The mark lies at 100 mm from now on, inside the soft limits.
    let home = description.axes[X].scale.counts(100.0);
    plant.step(None, &[MachineCommand::SetHome { axis: Axis::X, counts: latch.counts - home }]);
    plant.idle(LAG + 1);
    let latches = pass(&mut plant, mark, -3.0);
    assert_eq!(latches.iter().map(|latch| latch.counts).collect::<Vec<_>>(), [home], "the same mark by the new zero");
}

#[test]
fn setpoints_that_do_not_arrive_are_an_alarm_and_no_jump() {
    let description = cam_grinder();
    let mut plant = DelayLine::new(&description, start(&description));
    let setpoints = travel(&plant.machine, Axis::X, -20.0, 200);
    plant.follow(&setpoints[..100]);
    let sent = plant.machine.orders().positions[X];
    plant.machine.starve();
    let reports = plant.idle(60);
    assert!(reports[0].raised.iter().any(|alarm| alarm.kind == AlarmKind::Underrun));
    assert!((plant.machine.orders().positions[X] - sent).abs() < 0.5);
    assert_eq!(reports.last().expect("reports").motion, MotionState::Fault);
    plant.machine.reset().expect("it rests");
    let (setpoint, target) = (plant.machine.setpoint(), plant.machine.orders().positions[X]);
    plant.step(Some(&setpoint), &[]);
    assert!((plant.machine.orders().positions[X] - target).abs() < 0.5, "a reset moves nothing");
}

#[test]
fn a_wheel_runs_when_its_spindle_reports_it() {
    let description = cam_grinder();
    let mut plant = DelayLine::new(&description, start(&description));
    plant.step(None, &[MachineCommand::WheelStart]);
    assert!(plant.machine.orders().wheel_runs);
    assert!(!plant.idle(2500).last().expect("reports").io.wheel_running, "time alone brings no speed");
    plant.inputs.wheel_at_speed = true;
    assert!(plant.idle(2).last().expect("reports").io.wheel_running);
    plant.inputs.wheel_at_speed = false;
    let raised = plant.idle(2).into_iter().flat_map(|report| report.raised.to_vec()).collect::<Vec<_>>();
    assert!(raised.iter().any(|alarm| alarm.kind == AlarmKind::WheelStopped), "{raised:?}");
}

#[test]
fn a_limit_switch_stops_the_axes() {
    let description = cam_grinder();
    let mut plant = DelayLine::new(&description, start(&description));
    let setpoints = travel(&plant.machine, Axis::X, -20.0, 200);
    plant.follow(&setpoints[..80]);
    plant.inputs.limits = 1 << X;
    let raised: Vec<AlarmKind> =
        plant.idle(400).into_iter().flat_map(|report| report.raised.to_vec()).map(|alarm| alarm.kind).collect();
    assert!(raised.contains(&AlarmKind::Overtravel(Axis::X)), "{raised:?}");
    assert!(plant.machine.is_at_rest());
}

/// The level of an input that is asked for belongs to its tick, whose readings come a lag later.
#[test]
fn a_question_is_answered_by_the_readings_of_its_tick() {
    let description = cam_grinder();
    let mut plant = DelayLine::new(&description, start(&description));
    plant.inputs.origin = true;
    plant.idle(20);
    let asked = plant.machine.tick() + 1;
    let mut reports = vec![plant.step(None, &[MachineCommand::Ask { input: Input::Origin }])];
    reports.extend(plant.idle(2 * LAG));
    let answers = reports.iter().flat_map(|report| report.latches.iter().map(|latch| (report.tick, latch.tick)));
    assert_eq!(answers.collect::<Vec<_>>(), [(asked, asked)]);
}

/// A grinder with an exact gauge, and its counts with the first station in front of the wheel.
fn gauged(kind: GaugeKind, second_behind_wheel_rad: Option<f64>) -> (MachineDescription, [i64; AXIS_COUNT]) {
    let mut description = cam_grinder();
    description.gauge = Some(GaugeDescription {
        kind,
        behind_wheel_rad: 1.5,
        second_behind_wheel_rad,
        resolution_mm: 0.0,
        noise_mm: 0.0,
        bandwidth_rad_s: None,
        seed: 0,
    });
    let mut counts = start(&description);
    let z = Axis::Z as usize;
    counts[z] = description.axes[z].scale.counts(description.stations[0].position_mm);
    (description, counts)
}

/// The readings of a real gauge reach the report of their own tick, of a lobe in front of the wheel while C turns, to the bit.
#[test]
fn a_gauge_is_read_while_a_lobe_turns_in_front_of_the_wheel() {
    let (mut description, counts) = gauged(GaugeKind::Radius, Some(4.5));
    let read = |description: &MachineDescription, has_lobe: bool| {
        let mut plant = DelayLine::new(description, counts);
        if has_lobe {
            plant.machine.load_lobe("J1", "LS1", 20.0, vec![20.0; 720]).expect("a lobe");
        }
        let setpoints = travel(&plant.machine, Axis::C, 3.0, 300);
        let mut reports = Vec::new();
        for (k, setpoint) in (0_u32..).zip(setpoints.iter().map(Some).chain([None; 40])) {
            let mm = 20.0 + 1e-3 * f64::from(k);
            // The second gauge does not measure in every tick.
            plant.gauge_mm = [Some(mm), (k % 2 == 0).then_some(-mm)];
            reports.push((k, plant.step(setpoint, &[])));
        }
        (plant, reports)
    };
    let (plant, reports) = read(&description, true);
    let (turning, resting): (Vec<_>, Vec<_>) =
        reports.iter().partition(|(_, report)| report.motion == MotionState::Running && report.gauge_mm[0].is_some());
    assert!(turning.len() > 280 && resting.iter().all(|(_, report)| report.gauge_mm == [None; 2]));
    for (k, report) in turning {
        let mm = 20.0 + 1e-3 * f64::from(k);
        assert_eq!(report.gauge_mm, [Some(mm), (k % 2 == 0).then_some(-mm)], "tick {}", report.tick);
        assert_eq!((report.tick, report.lobe), (u64::from(k) + 1, Some(0)));
    }
    assert_eq!(plant.machine.alarms().len(), 0);
    let none = |(_, reports): (DelayLine, Vec<(u32, TickReport)>)| {
        reports.iter().all(|(_, report)| report.gauge_mm == [None; 2])
    };
    assert!(none(read(&description, false)), "no lobe is in front of the wheel");
    description.gauge = None;
    assert!(none(read(&description, true)), "there is no gauge");
}

#[test]
fn a_gauge_that_gives_no_number_is_an_alarm() {
    let (description, counts) = gauged(GaugeKind::Diameter, None);
    let mut plant = DelayLine::new(&description, counts);
    plant.machine.load_lobe("J1", "LS1", 20.0, vec![20.0; 720]).expect("a lobe");
    let setpoints = travel(&plant.machine, Axis::C, 3.0, 300);
    plant.gauge_mm = [Some(40.0), None];
    plant.follow(&setpoints[..100]);
    assert_eq!(plant.machine.alarms().len(), 0);
    plant.gauge_mm = [Some(f64::NAN), None];
    let reports = plant.follow(&setpoints[100..110]);
    let raised: Vec<_> = reports.iter().flat_map(|report| report.raised.to_vec()).map(|alarm| alarm.kind).collect();
    assert_eq!(raised, [AlarmKind::GaugeInvalid]);
}
