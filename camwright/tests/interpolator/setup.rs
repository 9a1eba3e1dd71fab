// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Set-up work on the machine: moves end on their counts, a probe's edge is where the part truly is, at every speed.

use camwright::interpolator::setup::{MoveTo, Probe, ProbeRequest, SetupError, targets};
use camwright::interpolator::wheel_change::plan_wheel_change;
use camwright::interpolator::{Motion, MotionOutcome, MotionRequest, Prepared, ProbeOutcome, StartError};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{
    Axis, ContactDescription, DriveSettings, GapDetector, KeyWayProbe, MachineDescription, MagazineWheel, StiffnessAt,
    ThermalDescription, WheelChanger, WheelDescription,
};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::reference::cam_grinder;
use camwright::machine::setpoint::Input;
use camwright::math::units::{TURN_RAD, rad_from_deg};
use camwright::simulation::Machine;
use camwright::simulation::closed_loop::ClosedLoop;

const C: usize = Axis::C as usize;
const X: usize = Axis::X as usize;
const Z: usize = Axis::Z as usize;
const PER_MM: i64 = 100_000;
const RADIUS_MM: f64 = 20.0;

/// The reference machine with ideal drives, a gap detector, a switch at the keyway, and a part at its first station.
pub(super) fn description() -> MachineDescription {
    let mut machine = cam_grinder().with_drives(DriveSettings::IDEAL);
    machine.gap_detector = Some(GapDetector { holds_s: 0.02 });
    machine.key_way_probe = Some(KeyWayProbe { at_rad: rad_from_deg(140.0), width_rad: rad_from_deg(16.0) });
    machine.axes[Z].power_up_position = 60.0;
    machine.axes[X].power_up_position = 40.0;
    machine
}

fn cell_with(description: &MachineDescription, radii: Vec<f64>) -> ClosedLoop {
    let mut machine = Machine::new(description.clone(), PersistentState::new(description)).expect("a machine");
    machine.load_lobe("J1", "LS1", 15.0, radii).expect("a journal");
    let counts = [0, 40 * PER_MM, 600_000];
    let wheel_stands = |machine: &mut Machine| {
        machine.step(None, &[camwright::simulation::MachineCommand::WheelStop], &[]);
        for _ in 0..3000 {
            machine.step(None, &[], &[]);
        }
    };
    machine.place(counts);
    wheel_stands(&mut machine);
    let mut cell = ClosedLoop::new(machine);
    cell.parts_mut().0.set_homed(Axis::C, true);
    cell
}

pub(super) fn cell(description: &MachineDescription) -> ClosedLoop {
    cell_with(description, vec![RADIUS_MM; 3600])
}

pub(super) fn finish(cell: &mut ClosedLoop) -> MotionOutcome {
    for _ in 0..400_000 {
        cell.step(&[]);
        if let Some(outcome) = cell.outcome().filter(|_| !cell.is_running() && cell.machine().is_at_rest()) {
            return outcome;
        }
    }
    panic!("it does not end");
}

pub(super) fn run(cell: &mut ClosedLoop, motion: Motion) -> Result<MotionOutcome, StartError> {
    let motion = Prepared::new(motion, cell.machine().description()).expect("it can be executed");
    cell.start(Box::new(motion))?;
    Ok(finish(cell))
}

fn touch(speed: f64) -> ProbeRequest {
    ProbeRequest {
        axis: Axis::X,
        target: 18.0,
        speed,
        input: Input::WheelContact,
        input_name: "wheel_contact".into(),
        until_open: false,
        stand_off: 1.0,
        most_force_n: 0.0,
        reads: None,
    }
}

fn probe(cell: &mut ClosedLoop, request: &ProbeRequest) -> Result<ProbeOutcome, SetupError> {
    let from = cell.machine().setpoint().counts;
    let probe = Probe::new(request, from, cell.machine().description())?;
    assert_eq!(run(cell, Motion::Probe(probe)), Ok(MotionOutcome::Completed), "{:?}", cell.machine().alarms());
    Ok(cell.probed().expect("a probe says what it found"))
}

fn near(cell: &mut ClosedLoop, x_mm: f64) {
    let to = targets(&[MoveTo { axis: Axis::X, position: x_mm, is_relative: false }], [0; 3], 1.0, &description());
    assert_eq!(run(cell, Motion::Move(to.expect("within travel"))), Ok(MotionOutcome::Completed));
}

#[test]
fn a_move_ends_on_its_counts_on_every_axis_at_once_and_by_distances() {
    let mut cell = cell(&description());
    let absolute = |axis, position| MoveTo { axis, position, is_relative: false };
    let by = |axis, position| MoveTo { axis, position, is_relative: true };
    let machine = description();
    let moves = [absolute(Axis::X, 61.234_567), absolute(Axis::Z, 123.4), absolute(Axis::C, -1.0)];
    let to = targets(&moves, cell.machine().setpoint().counts, 0.5, &machine).expect("within travel");
    assert_eq!(run(&mut cell, Motion::Move(to)), Ok(MotionOutcome::Completed));
    let c = machine.axis(Axis::C).scale.counts(-1.0);
    assert_eq!(cell.machine().setpoint().counts, [c, 6_123_457, 1_234_000]);
    let to = targets(&[by(Axis::X, -0.25), by(Axis::C, 10.0 * TURN_RAD)], [c, 6_123_457, 1_234_000], 1.0, &machine);
    assert_eq!(run(&mut cell, Motion::Move(to.expect("within travel"))), Ok(MotionOutcome::Completed));
    assert_eq!(cell.machine().setpoint().counts, [c + 36_000_000, 6_098_457, 1_234_000]);
}

#[test]
fn a_move_keeps_its_share_of_the_speed_and_a_cancel_leaves_it_where_it_stops() {
    let mut cell = cell(&description());
    let machine = description();
    let by = MoveTo { axis: Axis::X, position: 150.0, is_relative: true };
    let to = targets(&[by], cell.machine().setpoint().counts, 0.1, &machine).expect("within travel");
    let motion = Prepared::new(Motion::Move(to), &machine).expect("a motion");
    cell.start(Box::new(motion)).expect("it starts");
    let mut fastest = 0.0_f64;
    for tick in 0..4000 {
        if tick == 1500 {
            cell.request(MotionRequest::Cancel);
        }
        fastest = fastest.max(cell.step(&[]).axes[X].velocity);
    }
    assert_eq!(cell.outcome(), Some(MotionOutcome::Cancelled));
    assert!((fastest - 50.0).abs() < 0.5, "a tenth of 500 mm/s: {fastest}");
    let x = cell.machine().setpoint().counts[X];
    assert!(x > 60 * PER_MM && x < 150 * PER_MM && cell.machine().is_at_rest(), "{x}");
}

#[test]
fn a_move_beyond_travel_or_of_an_axis_without_a_zero_is_refused_and_nothing_moves() {
    let machine = description();
    let of = |axis, position| MoveTo { axis, position, is_relative: false };
    let refused =
        |moves: &[MoveTo], factor| targets(moves, [0, 40 * PER_MM, 0], factor, &machine).expect_err("refused");
    let error = refused(&[of(Axis::X, 251.0)], 1.0);
    assert_eq!(error.to_string(), "the target of x_axis is 251.0000 mm, the soft limit is 250 mm");
    let error = refused(&[of(Axis::Z, -21.5)], 1.0);
    assert_eq!(error.to_string(), "the target of z_axis is -21.5000 mm, the soft limit is -20 mm");
    let by = MoveTo { axis: Axis::X, position: -35.1, is_relative: true };
    assert!(matches!(refused(&[by], 1.0), SetupError::SoftLimit { axis: Axis::X, .. }));
    assert_eq!(refused(&[], 1.0), SetupError::NoAxis);
    assert_eq!(refused(&[of(Axis::X, 20.0), of(Axis::X, 30.0)], 1.0), SetupError::Twice(Axis::X));
    assert_eq!(refused(&[of(Axis::X, 20.0)], 1.1), SetupError::SpeedFactor(1.1));
    for wild in [f64::NAN, f64::INFINITY, 1e300] {
        assert_eq!(refused(&[of(Axis::C, wild)], 1.0), SetupError::NotFinite { axis: Axis::C, what: "the target" });
    }
    let mut cell = cell(&machine);
    cell.parts_mut().0.set_homed(Axis::C, false);
    let to = targets(&[of(Axis::C, 1.0)], [0; 3], 1.0, &machine).expect("C has no limits");
    assert_eq!(run(&mut cell, Motion::Move(to)), Err(StartError::NotHomed(Axis::C)));
    assert_eq!(cell.machine().setpoint().counts[C], 0);
    assert!(cell.machine().alarms().is_empty(), "a refusal is no alarm");
}

/// The wheel touches where X is the radius of the part: 20 mm, whatever the speed; then it stands 1 mm off.
#[test]
fn the_running_wheel_touches_where_the_part_is_at_every_speed() {
    for speed in [0.05, 0.123, 0.4, 1.0, 1.9] {
        let mut cell = cell(&description());
        near(&mut cell, 20.5);
        let found = probe(&mut cell, &touch(speed)).expect("a probe");
        let ProbeOutcome::Found { latch, correction: 0 } = found else { panic!("{found:?}") };
        assert!((latch.counts - 20 * PER_MM).abs() <= 1, "{speed} mm/s: {}", latch.counts);
        assert_eq!(cell.machine().setpoint().counts[X], latch.counts + PER_MM);
        // What the wheel took on its way on, and no more: the delay is 20 ms.
        let min = cell.machine().part().lobe("J1").expect("it is there").radii_mm()[0];
        let taken = RADIUS_MM - min;
        assert!(taken > 0.0 && taken < 0.05, "{speed} mm/s: {taken} mm");
    }
}

/// A stopped wheel presses on a part that deflects, and takes nothing off it. Without leave it is an alarm.
#[test]
fn a_stopped_wheel_touches_a_part_that_gives_way_and_leaves_it_whole() {
    let contact = ContactDescription {
        stiffness: vec![StiffnessAt { z_mm: 60.0, n_mm: 20_000.0 }],
        grinding_n_mm2: 1500.0,
        threshold_n_mm: 0.8,
        part_share: 0.0,
        modes: Vec::new(),
    };
    let machine = MachineDescription { contact: Some(contact), ..description() };
    for speed in [0.05, 0.2, 0.9] {
        let mut cell = cell(&machine);
        near(&mut cell, 20.5);
        let found = probe(&mut cell, &ProbeRequest { most_force_n: 2000.0, ..touch(speed) }).expect("a probe");
        let ProbeOutcome::Found { latch, .. } = found else { panic!("{found:?}") };
        assert!((latch.counts - 20 * PER_MM).abs() <= 1, "{speed} mm/s: {}", latch.counts);
        assert!(cell.machine().part().lobe("J1").expect("there").radii_mm().iter().all(|r| *r >= RADIUS_MM));
        assert!(cell.machine().alarms().is_empty());
    }
    let mut cell = cell(&machine);
    near(&mut cell, 20.5);
    let weak = ProbeRequest { most_force_n: 5.0, ..touch(0.9) };
    let probe = Probe::new(&weak, cell.machine().setpoint().counts, &machine).expect("a probe");
    let number = AlarmKind::WheelContact.entry().number;
    assert_eq!(run(&mut cell, Motion::Probe(probe)), Ok(MotionOutcome::Failed(number)), "5 N are not enough");
}

/// A head that grows so slowly that it keeps what it has during a test.
const SLOW_GROWTH: ThermalDescription = ThermalDescription { growth_mm: 0.008, time_constant_s: 1e9, start_share: 0.0 };

/// A cell whose head has grown by 8 um since its wheel was dressed.
fn grown_cell(machine: &MachineDescription) -> ClosedLoop {
    let lasting = PersistentState { growth_mm: 0.008, growth_at_dress_mm: 0.0, ..PersistentState::new(machine) };
    let mut grown = Machine::new(machine.clone(), lasting).expect("a machine");
    grown.load_lobe("J1", "LS1", 15.0, vec![RADIUS_MM; 3600]).expect("a journal");
    grown.place([0, 40 * PER_MM, 600_000]);
    let mut cell = cell(machine);
    *cell.parts_mut().1 = grown;
    cell
}

/// A head that has grown by 8 um touches 8 um earlier; the zero of X is corrected by that, and the next touch reads the radius.
#[test]
fn touching_off_takes_the_growth_of_the_wheelhead_out_of_the_zero() {
    let mut machine = description();
    machine.thermal = Some(SLOW_GROWTH);
    let mut cell = grown_cell(&machine);
    near(&mut cell, 20.5);
    let request = ProbeRequest { reads: Some((RADIUS_MM, 0.1)), ..touch(0.1) };
    let Ok(ProbeOutcome::Found { latch, correction }) = probe(&mut cell, &request) else { panic!("found") };
    assert!((latch.counts - 2_000_800).abs() <= 1, "{}", latch.counts);
    assert_eq!(correction, 2_000_000 - latch.counts);
    assert_eq!(cell.machine().setpoint().counts[X], 2_100_000, "one millimetre off the radius, in the new reading");
    let again = cell.machine().part().lobe("J1").expect("there").radii_mm()[0];
    let Ok(ProbeOutcome::Found { latch, correction }) = probe(&mut cell, &request) else { panic!("found") };
    let wanted = machine.axis(Axis::X).scale.counts(again);
    assert!((latch.counts - wanted).abs() <= 1, "{} {wanted}", latch.counts);
    assert_eq!(correction, 2_000_000 - latch.counts);
}

/// The dresser's rim stands where it stands: after a touch-off and a dress the next touch reads what is there, and the correction that
/// was for the wheel before is not made twice.
#[test]
fn a_dress_after_a_touch_off_leaves_the_reading_right() {
    let mut machine = description();
    machine.thermal = Some(SLOW_GROWTH);
    machine.dresser = Some(camwright::machine::fixture::Dresser {
        x_mm: 60.0,
        z_mm: 360.0,
        width_mm: 2.0,
        infeed_speed_mm_s: 2.0,
        traverse_speed_mm_s: 10.0,
        dwell_s: 0.1,
        max_depth_mm: 0.05,
    });
    let mut cell = grown_cell(&machine);
    near(&mut cell, 20.5);
    let request = ProbeRequest { reads: Some((RADIUS_MM, 0.1)), ..touch(0.1) };
    assert!(matches!(probe(&mut cell, &request), Ok(ProbeOutcome::Found { correction: -801..=-799, .. })));
    let (plan, _) = camwright::planner::plan_dress(&machine, cell.machine().lasting().wheel(), 0.02).expect("a dress");
    assert_eq!(
        run(&mut cell, Motion::Plan(plan.into())),
        Ok(MotionOutcome::Completed),
        "{:?}",
        cell.machine().alarms()
    );
    assert_eq!(cell.machine().lasting().dress_count, 1);
    let back = targets(&[MoveTo { axis: Axis::Z, position: 60.0, is_relative: false }], [0; 3], 1.0, &machine);
    assert_eq!(run(&mut cell, Motion::Move(back.expect("within travel"))), Ok(MotionOutcome::Completed));
    near(&mut cell, 20.5);
    let left = machine.axis(Axis::X).scale.counts(cell.machine().part().lobe("J1").expect("there").radii_mm()[0]);
    let Ok(ProbeOutcome::Found { latch, .. }) = probe(&mut cell, &touch(0.1)) else { panic!("found") };
    assert!((latch.counts - left).abs() <= 1, "{} {left}", latch.counts);
}

#[test]
fn a_zero_that_would_move_too_far_stays_and_so_does_the_reading() {
    let mut cell = cell(&description());
    near(&mut cell, 20.5);
    let request = ProbeRequest { reads: Some((20.3, 0.2)), ..touch(0.2) };
    let found = probe(&mut cell, &request).expect("a probe");
    let ProbeOutcome::TooFarOff { latch, off } = found else { panic!("{found:?}") };
    assert_eq!((off, latch.counts), (2_030_000 - latch.counts, cell.machine().setpoint().counts[X] - PER_MM));
}

#[test]
fn a_probe_that_meets_nothing_stands_at_its_target_and_is_no_alarm() {
    let mut cell = cell_with(&description(), vec![10.0; 3600]);
    near(&mut cell, 18.5);
    assert_eq!(probe(&mut cell, &touch(0.5)), Ok(ProbeOutcome::Missed));
    assert_eq!(cell.machine().setpoint().counts[X], 18 * PER_MM);
    assert!(cell.machine().alarms().is_empty());
}

/// Edges of the keyway, both ways round, at three speeds: a clamped angle of 7.25 deg, a switch at 140 deg, a keyway of 16 deg.
#[test]
fn both_edges_of_the_key_way_tell_the_angle_at_which_the_part_is_clamped() {
    for sense in [1, -1] {
        let machine = MachineDescription { rotation_sense: sense, ..description() };
        for (clamped_deg, speed, way) in [(7.25, 2.0, 1.0), (7.25, 0.3, -1.0), (-91.0, 1.0, 1.0), (0.0, 2.0, 1.0)] {
            let mut cell = cell(&machine);
            cell.parts_mut().1.set_keyway(rad_from_deg(clamped_deg));
            let scale = machine.axis(Axis::C).scale;
            let mut edge = |until_open| {
                let at = cell.machine().setpoint().counts[C];
                let request = ProbeRequest {
                    axis: Axis::C,
                    target: scale.position(at) + way * 1.2 * TURN_RAD,
                    speed,
                    input: Input::KeyWay,
                    input_name: "key_way".into(),
                    until_open,
                    stand_off: 0.0,
                    most_force_n: 0.0,
                    reads: None,
                };
                match probe(&mut cell, &request) {
                    Ok(ProbeOutcome::Found { latch, .. }) => latch.counts,
                    other => panic!("{other:?}"),
                }
            };
            let centre = scale.position(edge(false) + edge(true)) / 2.0;
            let found = machine.key_way_probe.expect("there is one").key_way_rad(centre, sense);
            let off = libm::remainder(found - rad_from_deg(clamped_deg), TURN_RAD);
            assert!(off.abs() <= 1.1 / scale.counts_per_unit(), "{sense} {clamped_deg} {speed}: {off}");
        }
    }
}

#[test]
fn a_key_way_under_its_switch_is_reported_before_motion() {
    let mut cell = cell(&description());
    cell.parts_mut().1.set_keyway(rad_from_deg(140.0));
    let request = ProbeRequest {
        axis: Axis::C,
        target: 1.0,
        speed: 1.0,
        input: Input::KeyWay,
        input_name: "key_way".into(),
        ..touch(1.0)
    };
    assert_eq!(probe(&mut cell, &request), Ok(ProbeOutcome::AlreadyThere));
    assert_eq!(cell.machine().setpoint().counts[C], 0);
    let opens = ProbeRequest { until_open: true, stand_off: 0.0, ..request };
    assert!(matches!(probe(&mut cell, &opens), Ok(ProbeOutcome::Found { .. })));
}

#[test]
fn probes_that_cannot_be_are_refused_with_what_is_allowed() {
    let machine = description();
    let from = [0, 30 * PER_MM, 600_000];
    let refused = |request: &ProbeRequest, machine: &MachineDescription| {
        Probe::new(request, from, machine).expect_err("refused").to_string()
    };
    let refusal = |change: &dyn Fn(&mut ProbeRequest)| {
        let mut request = touch(0.1);
        change(&mut request);
        refused(&request, &machine)
    };
    assert!(refusal(&|r| r.speed = 3.0).contains("the wheel would run on by"));
    assert!(refusal(&|r| r.stand_off = 0.0).contains("the wheel must leave the part"));
    assert!(refusal(&|r| r.target = 4.0).contains("the soft limit is 5 mm"));
    assert!(refusal(&|r| r.target = 30.0).contains("is already at or beyond the target"));
    assert!(refusal(&|r| r.axis = Axis::C).contains("wheel_contact catches the position of x_axis, not of c_axis"));
    assert!(refusal(&|r| r.stand_off = 225.0).contains("the stand-off from the start of x_axis is 255"));
    assert!(refusal(&|r| r.most_force_n = -1.0).contains("it must be 0 to 1000000"));
    assert!(refusal(&|r| r.reads = Some((20.0, f64::NAN))).contains("largest correction"));
    for speed in [0.0, -1.0, f64::NAN, 501.0] {
        assert!(refusal(&|r| r.speed = speed).contains("cannot move at"), "{speed}");
    }
    let without = MachineDescription { gap_detector: None, ..machine.clone() };
    assert_eq!(refused(&touch(0.1), &without), "the machine has no gap detector");
}

/// The wheel is changed from where the machine stands: X goes clear, the running wheel comes to rest, the other one is mounted.
#[test]
fn a_wheel_change_of_its_own_clears_x_and_stops_the_wheel() {
    let mut machine = description();
    let second = WheelDescription { new_radius_mm: 40.0, min_radius_mm: 30.0, spin_up_s: 0.3, ..machine.wheel };
    let magazine = |name: &str, wheel| MagazineWheel { name: name.into(), wheel, setting_error_mm: 0.0 };
    let wheels = vec![magazine("roughing", machine.wheel), magazine("finishing", second)];
    machine.wheel_changer = Some(WheelChanger { change_s: 1.5, min_x_mm: 200.0, wheels, mounted: 0 });
    let mut cell = cell(&machine);
    cell.parts_mut().1.step(None, &[camwright::simulation::MachineCommand::WheelStart], &[]);
    let wheels = cell.machine().lasting().wheels();
    let plan = plan_wheel_change(&machine, &wheels, "finishing").expect("a wheel");
    assert_eq!(
        run(&mut cell, Motion::Plan(plan.into())),
        Ok(MotionOutcome::Completed),
        "{:?}",
        cell.machine().alarms()
    );
    let described = cell.machine().description().clone();
    assert_eq!((described.mounted_wheel(), described.wheel.new_radius_mm), (1, 40.0));
    assert!(cell.machine().truth()[X].0 > 200.0);
    // Back, although the wheel just began to run down.
    let wheels = cell.machine().lasting().wheels();
    let plan = plan_wheel_change(&described, &wheels, "roughing").expect("a wheel");
    assert_eq!(
        run(&mut cell, Motion::Plan(plan.into())),
        Ok(MotionOutcome::Completed),
        "{:?}",
        cell.machine().alarms()
    );
    assert_eq!(cell.machine().description().mounted_wheel(), 0);
    // A plan for the wheel that was mounted before is refused by the machine.
    let stale = plan_wheel_change(&described, &wheels, "roughing").expect("a wheel");
    assert_eq!(
        run(&mut cell, Motion::Plan(stale.into())),
        Ok(MotionOutcome::Failed(AlarmKind::OtherWheel.entry().number))
    );
    let refused = |machine: &MachineDescription, name: &str| {
        plan_wheel_change(machine, &wheels, name).expect_err("refused").to_string()
    };
    assert_eq!(refused(&machine, "roughing"), "wheel roughing is mounted already");
    assert!(refused(&machine, "polishing").ends_with("has roughing, finishing"));
    assert!(refused(&description(), "roughing").ends_with("has no wheel_changer"));
}
