// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Door, chuck, part sensor and work area: nothing moves while a person is in reach, and nothing opens while something moves.

use super::{follow, idle, machine, travel};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{Axis, LoadingDescription, MachineDescription};
use camwright::simulation::Machine;
use camwright::simulation::fault::{Fault, LoadingFault};
use camwright::simulation::tick_report::{MotionState, TickReport};
use camwright::simulation::work_area::{AccessRefusal, ActuatorPosition, LoadingRefused};
use camwright::simulation::{MachineCommand, ResetRefused};

/// A machine with a door of 200 and 300 ticks and a chuck of 50 and 80.
fn loaded() -> MachineDescription {
    let loading = LoadingDescription {
        door_opens_s: 0.2,
        door_closes_s: 0.3,
        chuck_opens_s: 0.05,
        chuck_closes_s: 0.08,
        safe_x_mm: 120.0,
    };
    MachineDescription { loading: Some(loading), ..super::ideal() }
}

/// A machine with its chuck closed on a part, ready to move.
fn ready() -> Machine {
    let mut machine = machine(&loaded());
    idle(&mut machine, 10);
    machine.order_door(true).expect("nothing moves");
    idle(&mut machine, 200);
    machine.change_part(true).expect("door and chuck are open");
    machine.order_chuck(false).expect("nothing moves");
    idle(&mut machine, 80);
    machine.order_door(false).expect("nobody is inside");
    idle(&mut machine, 300);
    let area = machine.work_area().expect("it has one");
    assert_eq!(
        (area.door, area.chuck, area.part_present, area.hindrance),
        (ActuatorPosition::Closed, ActuatorPosition::Closed, true, None)
    );
    machine
}

fn strike(machine: &mut Machine, fault: LoadingFault) -> TickReport {
    machine.step(None, &[], &[Fault::Loading(fault)])
}

fn raised(machine: &Machine) -> Vec<AlarmKind> {
    machine.alarms().iter().map(|alarm| alarm.kind).collect()
}

#[test]
fn door_and_chuck_take_their_times_and_the_part_goes_in_through_both() {
    let mut machine = machine(&loaded());
    assert_eq!(machine.change_part(true), Err(LoadingRefused::DoorNotOpen));
    assert_eq!(machine.holds_part(), Err(LoadingRefused::NoPart));
    machine.order_door(true).expect("nothing moves");
    assert_eq!(
        idle(&mut machine, 199).last().and_then(|r| r.work_area).map(|a| a.door),
        Some(ActuatorPosition::Opening)
    );
    let report = idle(&mut machine, 1).pop().and_then(|report| report.work_area).expect("an area");
    assert!(report.door == ActuatorPosition::Open && report.is_safe && !report.part_present);
    machine.order_chuck(false).expect("an empty chuck closes too");
    idle(&mut machine, 80);
    assert_eq!(machine.change_part(true), Err(LoadingRefused::ChuckNotOpen));
    machine.order_chuck(true).expect("the door is open");
    idle(&mut machine, 50);
    machine.change_part(true).expect("both are open");
    assert_eq!(machine.change_part(true), Err(LoadingRefused::PartThere));
    assert_eq!(machine.holds_part(), Err(LoadingRefused::ChuckNotClosed));
    machine.order_chuck(false).expect("nothing moves");
    idle(&mut machine, 80);
    assert_eq!(machine.holds_part(), Ok(()));
    machine.order_door(false).expect("nobody is inside");
    idle(&mut machine, 300);
    assert_eq!(machine.order_chuck(true), Err(LoadingRefused::DoorNotOpen), "the part would fall");
    assert!(machine.alarms().is_empty());
}

#[test]
fn a_motion_that_begins_with_the_door_open_is_an_alarm_and_nothing_moves() {
    for (hinder, kind) in [
        (LoadingFault::DoorForced(true), AlarmKind::DoorOpened),
        (LoadingFault::ChuckForced(true), AlarmKind::ChuckOpened),
        (LoadingFault::Person(true), AlarmKind::WorkAreaEntered),
    ] {
        let mut machine = ready();
        strike(&mut machine, hinder);
        assert!(machine.alarms().is_empty(), "at rest it is allowed");
        let before = machine.truth();
        let moves = travel(&machine, Axis::X, -20.0, 400);
        follow(&mut machine, &moves[..300]);
        idle(&mut machine, 500);
        assert_eq!(raised(&machine), [kind]);
        assert_eq!(machine.truth(), before);
        let mut wheel = ready();
        strike(&mut wheel, hinder);
        let report = wheel.step(None, &[MachineCommand::WheelStart], &[]);
        assert_eq!(raised(&wheel), [kind]);
        assert!(report.wheel_rad_s < f64::MIN_POSITIVE, "the wheel does not start");
    }
}

/// It ends as any power-off does: on the path, at rest, and only a reset lets anything move again.
#[test]
fn a_door_forced_open_stops_the_axes_on_their_path() {
    let mut machine = ready();
    let moves = travel(&machine, Axis::X, -40.0, 1000);
    follow(&mut machine, &moves[..400]);
    let report = machine.step(Some(&moves[400]), &[], &[Fault::Loading(LoadingFault::DoorForced(true))]);
    assert_eq!(report.raised.iter().map(|alarm| alarm.kind.entry().number).collect::<Vec<_>>(), [150]);
    assert!(!machine.is_at_rest(), "no axis stops at once");
    // What was sent runs out.
    follow(&mut machine, &moves[401..]);
    let end = idle(&mut machine, 2000).pop().expect("a report");
    assert!(machine.is_at_rest() && end.motion == MotionState::Fault && !end.io.drives_on);
    assert!((machine.truth()[Axis::X.index()].0 - 80.0).abs() < 1e-2, "{:?}", machine.truth());
    machine.reset().expect("at rest, and nobody inside");
    machine.order_door(false).expect("nobody is inside");
    idle(&mut machine, 300);
    let back = travel(&machine, Axis::X, 10.0, 400);
    follow(&mut machine, &back);
    assert!(machine.alarms().is_empty());
}

/// The wheel runs down for seconds: a reset before it stands would bring the alarm again with the next tick.
#[test]
fn with_the_door_open_a_reset_waits_for_the_wheel() {
    let mut machine = ready();
    machine.step(None, &[MachineCommand::WheelStart], &[]);
    idle(&mut machine, 500);
    strike(&mut machine, LoadingFault::DoorForced(true));
    assert_eq!(raised(&machine), [AlarmKind::DoorOpened]);
    assert_eq!(machine.reset(), Err(ResetRefused::WheelTurns(AccessRefusal::Door)));
    let mut ticks = 0;
    while machine.reset().is_err() {
        idle(&mut machine, 1);
        ticks += 1;
        assert!(ticks < 100_000, "it stands in the end");
    }
    assert!(ticks > 100, "it does not stand at once: {ticks} ticks");
    idle(&mut machine, 500);
    assert!(machine.alarms().is_empty(), "and the alarm stays away");
}

#[test]
fn nothing_opens_in_motion_and_nothing_closes_on_a_person() {
    let mut machine = ready();
    let moves = travel(&machine, Axis::Z, 20.0, 400);
    follow(&mut machine, &moves[..200]);
    assert_eq!(machine.order_door(true), Err(LoadingRefused::Moving));
    assert_eq!(machine.order_chuck(true), Err(LoadingRefused::Moving));
    follow(&mut machine, &moves[200..]);
    idle(&mut machine, 500);
    machine.step(None, &[MachineCommand::WheelStart], &[]);
    assert_eq!(machine.order_door(true), Err(LoadingRefused::WheelTurns));
    idle(&mut machine, 100);
    machine.step(None, &[MachineCommand::WheelStop], &[]);
    assert!(machine.is_being_loaded(), "somebody waits for the wheel");
    while machine.is_being_loaded() {
        idle(&mut machine, 1);
    }
    machine.order_door(true).expect("the wheel has stopped");
    idle(&mut machine, 200);
    machine.see_loader(true, false);
    assert_eq!(machine.order_door(false), Err(LoadingRefused::Entered));
    machine.see_loader(false, false);
    machine.order_door(false).expect("it has left");
    idle(&mut machine, 100);
    // Who enters a closing door opens it again.
    machine.see_loader(true, false);
    idle(&mut machine, 200);
    assert_eq!(machine.work_area().expect("an area").door, ActuatorPosition::Open);
    assert!(machine.alarms().is_empty());
}

#[test]
fn a_loader_that_goes_silent_inside_is_an_alarm_until_it_is_out_and_one_outside_is_none() {
    let mut machine = ready();
    machine.order_door(true).expect("nothing moves");
    idle(&mut machine, 200);
    for (inside, lost) in [(false, false), (false, true), (false, false)] {
        machine.see_loader(inside, lost);
        idle(&mut machine, 1);
    }
    assert!(machine.alarms().is_empty());
    machine.see_loader(true, false);
    machine.see_loader(true, true);
    idle(&mut machine, 1);
    assert_eq!(raised(&machine), [AlarmKind::LoaderLost]);
    let refused = machine.reset().expect_err("it is still in there").to_string();
    assert!(refused.starts_with("a person or the loader is in the work area; clear it"), "{refused}");
    machine.see_loader(false, false);
    machine.reset().expect("it is out");
    assert!(machine.alarms().is_empty() && !machine.work_area().expect("an area").entered);
}

#[test]
fn what_does_not_come_to_its_end_is_an_alarm_after_twice_its_time() {
    let mut machine = ready();
    strike(&mut machine, LoadingFault::DoorStuck(true));
    machine.order_door(true).expect("nothing moves");
    idle(&mut machine, 400);
    assert!(machine.alarms().is_empty());
    idle(&mut machine, 1);
    assert_eq!(raised(&machine), [AlarmKind::DoorStuck]);
    strike(&mut machine, LoadingFault::DoorStuck(false));
    machine.reset().expect("at rest");
    idle(&mut machine, 200);
    assert_eq!(machine.work_area().expect("an area").door, ActuatorPosition::Open);
    strike(&mut machine, LoadingFault::ChuckStuck(true));
    machine.order_chuck(true).expect("the door is open");
    idle(&mut machine, 101);
    assert_eq!(raised(&machine), [AlarmKind::ChuckStuck]);
    strike(&mut machine, LoadingFault::PartSensor(Some(false)));
    assert!(!machine.work_area().expect("an area").part_present, "the sensor says so");
}

#[test]
fn a_machine_without_door_and_chuck_has_nothing_to_work() {
    let mut machine = machine(&super::ideal());
    assert!(machine.work_area().is_none() && machine.holds_part().is_ok() && !machine.is_being_loaded());
    assert_eq!(machine.order_door(true), Err(LoadingRefused::NothingThere));
    machine.see_loader(true, true);
    strike(&mut machine, LoadingFault::Person(true));
    let moves = travel(&machine, Axis::X, -20.0, 400);
    follow(&mut machine, &moves);
    assert!(machine.alarms().is_empty());
}
