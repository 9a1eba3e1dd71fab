// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Homing by switch and index as `LinuxCNC` does it: every kind and every sign finds the machine's own zero from either side of the
//! switch; what fails or is stopped leaves the axis un-homed and homes nothing else.

use crate::machine::HOMING_AT_A_SWITCH;
use camwright::interpolator::{Motion, MotionOutcome, MotionRequest, Prepared, StartError};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{Axis, DescriptionError, Homing, HomingKind, MachineDescription};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::reference::cam_grinder;
use camwright::machine::setpoint::Input;
use camwright::simulation::Machine;
use camwright::simulation::closed_loop::ClosedLoop;
use camwright::simulation::fault::Fault;

const X: usize = Axis::X as usize;
const Z: usize = Axis::Z as usize;

/// A switch 10 mm before the end of the travel of X, away from the part.
const AWAY: Homing = Homing { switch_mm: 243.21, ..HOMING_AT_A_SWITCH };

fn grinder(x: Homing, at_mm: f64) -> MachineDescription {
    let mut machine = cam_grinder();
    machine.axes[X].needs_homing = true;
    machine.axes[X].homing = Some(x);
    machine.axes[X].power_up_position = at_mm;
    machine
}

/// X and Z, the table behind the wheelhead: its switch is at the low end of its travel.
fn both() -> MachineDescription {
    let mut machine = grinder(AWAY, 100.0);
    machine.axes[Z].needs_homing = true;
    machine.axes[Z].power_up_position = 111.5;
    machine.axes[Z].homing =
        Some(Homing { search_mm_s: -40.0, latch_mm_s: -2.0, home_mm: 0.0, sequence: 1, switch_mm: -15.0, ..AWAY });
    machine
}

fn cell(machine: &MachineDescription) -> ClosedLoop {
    ClosedLoop::new(Machine::new(machine.clone(), PersistentState::new(machine)).expect("a machine"))
}

fn start(cell: &mut ClosedLoop, axes: &[Axis]) -> Result<(), StartError> {
    let motion = Prepared::new(Motion::Home(axes.to_vec()), cell.machine().description()).expect("it can be homed");
    cell.start(Box::new(motion))
}

/// Runs to the end of the motion, and until the axes rest.
fn finish(cell: &mut ClosedLoop) -> MotionOutcome {
    for _ in 0..200_000 {
        cell.step(&[]);
        if let Some(outcome) = cell.outcome().filter(|_| !cell.is_running() && cell.machine().is_at_rest()) {
            return outcome;
        }
    }
    panic!("homing does not end");
}

fn homed(cell: &mut ClosedLoop) -> [bool; 3] {
    let report = cell.step(&[]);
    let [c, x, z] = report.axes;
    for axis in Axis::ALL {
        assert_eq!(cell.interpolator().is_homed(axis), report.axes[axis.index()].is_homed, "{axis:?}");
    }
    [c.is_homed, x.is_homed, z.is_homed]
}

#[test]
fn every_kind_and_every_sign_finds_the_zero_from_both_sides_of_the_switch() {
    let towards = Homing { search_mm_s: -20.0, latch_mm_s: -1.0, switch_mm: 8.5, home_mm: 30.0, ..AWAY };
    let index = Homing { use_index: true, index_pitch_mm: 4.0, ..AWAY };
    for homing in [
        AWAY,
        Homing { latch_mm_s: 1.0, ..AWAY },
        towards,
        Homing { latch_mm_s: 1.0, ..towards },
        index,
        Homing { latch_mm_s: 2.0, ..index },
        Homing { use_index: true, index_pitch_mm: 4.0, ..towards },
    ] {
        for at_mm in [100.0, if homing.search_mm_s > 0.0 { 248.0 } else { 5.5 }] {
            let machine = grinder(homing, at_mm);
            let mut cell = cell(&machine);
            start(&mut cell, &[Axis::X]).expect("it starts");
            assert_eq!(
                finish(&mut cell),
                MotionOutcome::Completed,
                "{homing:?} from {at_mm}: {:?}",
                cell.machine().alarms()
            );
            let report = cell.step(&[]);
            assert!((report.axes[X].position - homing.home_mm).abs() < 1e-9, "{homing:?}: {}", report.axes[X].position);
            // One count of rounding at the edge.
            let true_mm = cell.machine().truth()[X].0;
            assert!((true_mm - homing.home_mm).abs() < 2e-5, "{homing:?} from {at_mm}: truly at {true_mm}");
            assert_eq!(homed(&mut cell), [false, true, true]);
        }
    }
}

#[test]
fn where_it_stands_or_at_the_next_mark_is_a_zero_too() {
    let immediate = Homing { search_mm_s: 0.0, latch_mm_s: 0.0, offset_mm: Some(90.0), home_mm: 100.0, ..AWAY };
    let mark = Homing { use_index: true, search_mm_s: 0.0, offset_mm: Some(90.0), home_mm: 100.0, ..AWAY };
    // The next mark below 97 mm is at 90.
    for (homing, kind, at_mm, true_mm) in
        [(immediate, HomingKind::Immediate, 97.0, 107.0), (mark, HomingKind::IndexOnly, 97.0, 100.0)]
    {
        assert_eq!(homing.kind(), Some(kind));
        let mut cell = cell(&grinder(homing, at_mm));
        start(&mut cell, &[Axis::X]).expect("it starts");
        assert_eq!(finish(&mut cell), MotionOutcome::Completed);
        assert!((cell.machine().truth()[X].0 - true_mm).abs() < 2e-5, "{}", cell.machine().truth()[X].0);
    }
}

#[test]
fn every_other_combination_is_refused() {
    for (search_mm_s, latch_mm_s, use_index) in
        [(20.0, 0.0, false), (20.0, 0.0, true), (0.0, 1.0, false), (0.0, 0.0, true)]
    {
        let homing = Homing { search_mm_s, latch_mm_s, use_index, offset_mm: Some(1.0), ..AWAY };
        let refused = grinder(homing, 100.0).validate();
        assert!(matches!(refused, Err(DescriptionError::Homing { joint: "x_axis", .. })), "{homing:?}: {refused:?}");
    }
    for homing in [
        Homing { search_mm_s: 1e4, ..AWAY },
        Homing { final_mm_s: 0.0, ..AWAY },
        Homing { home_mm: 1.0, ..AWAY },
        Homing { switch_mm: 256.0, ..AWAY },
        Homing { use_index: true, search_mm_s: 0.0, ..AWAY },
        Homing { use_index: true, index_pitch_mm: 0.0, ..AWAY },
        Homing { use_index: true, index_pitch_mm: 0.05, ..AWAY },
        Homing { latch_mm_s: f64::NAN, ..AWAY },
    ] {
        assert!(grinder(homing, 100.0).validate().is_err(), "{homing:?}");
    }
}

/// The switch of the hard limit is the home switch.
#[test]
fn a_limit_switch_may_be_the_home_switch_until_the_axis_is_homed() {
    let shared = Homing { switch_mm: 255.0, ignore_limits: true, ..AWAY };
    let mut cell = cell(&grinder(shared, 100.0));
    start(&mut cell, &[Axis::X]).expect("it starts");
    assert_eq!(finish(&mut cell), MotionOutcome::Completed, "{:?}", cell.machine().alarms());
    assert!((cell.machine().truth()[X].0 - shared.home_mm).abs() < 2e-5);
}

#[test]
fn axes_are_homed_by_their_sequence_and_the_headstock_last() {
    let mut cell = cell(&both());
    start(&mut cell, &Axis::ALL).expect("it starts");
    let mut order = Vec::new();
    while cell.is_running() {
        let report = cell.step(&[]);
        for axis in Axis::ALL {
            if report.axes[axis.index()].is_homed && !order.contains(&axis) {
                order.push(axis);
            }
        }
    }
    assert_eq!((order, cell.outcome()), (vec![Axis::X, Axis::Z, Axis::C], Some(MotionOutcome::Completed)));
}

#[test]
fn before_homing_there_are_no_soft_limits_and_after_it_there_are() {
    let mut cell = cell(&grinder(AWAY, 100.0));
    start(&mut cell, &[Axis::X]).expect("it starts");
    finish(&mut cell);
    // 10 mm beyond the soft limit of 250 mm.
    let counts = cell.machine().setpoint().counts;
    let machine = cell.machine().description().clone();
    let target = camwright::motion::plan::AxisTarget {
        axis: Axis::X,
        target_counts: 26_000_000,
        limits: machine.axes[X].limits,
    };
    let plan = camwright::motion::plan::Plan {
        segments: vec![camwright::motion::plan::Segment {
            kind: camwright::motion::plan::SegmentKind::Move(vec![target]),
            phase: camwright::motion::plan::Phase::Index,
            lobe: None,
            label: String::new(),
            ticks: 1,
            stop_ticks: 1,
            stock_mm: 0.0,
        }],
        ..camwright::motion::plan::Plan::default()
    };
    let motion = Prepared::new(Motion::Plan(std::sync::Arc::new(plan)), &machine).expect("a motion");
    cell.start(Box::new(motion)).expect("it starts");
    assert_eq!(finish(&mut cell), MotionOutcome::Failed(22));
    assert_eq!(cell.machine().setpoint().counts, counts, "nothing moved");
}

/// Cancelled, held and struck at many places: every axis stops, nothing is half homed, and it can be homed afterwards.
#[test]
fn what_stops_homing_stops_every_axis_and_leaves_it_not_homed() {
    let machine = both();
    for at in (50..6000).step_by(487) {
        for stop in ["cancel", "hold", "alarm"] {
            let mut cell = cell(&machine);
            start(&mut cell, &[Axis::X, Axis::Z]).expect("it starts");
            for _ in 0..at {
                cell.step(&[]);
            }
            let what = format!("{stop} at {at}");
            assert_eq!(start(&mut cell, &[Axis::X]), Err(StartError::Busy), "{what}: a second request is refused");
            match stop {
                "cancel" => cell.request(MotionRequest::Cancel),
                "hold" => cell.request(MotionRequest::Hold),
                _ => drop(cell.step(&[Fault::EStop(true)])),
            }
            for _ in 0..1500 {
                cell.step(&[]);
            }
            let place = cell.machine().truth().map(|(position, _)| position);
            for _ in 0..500 {
                cell.step(&[]);
            }
            assert_eq!(place, cell.machine().truth().map(|(position, _)| position), "{what}: the axes rest");
            let [_, x, z] = homed(&mut cell);
            assert!(!z || x, "{what}: the sequence");
            match stop {
                "hold" => {
                    cell.request(MotionRequest::Unhold);
                    assert_eq!(finish(&mut cell), MotionOutcome::Completed, "{what}");
                    assert_eq!(homed(&mut cell), [false, true, true], "{what}");
                    continue;
                }
                "alarm" => {
                    assert_eq!(cell.outcome(), Some(MotionOutcome::Failed(1)), "{what}");
                    cell.step(&[Fault::EStop(false)]);
                    cell.reset().expect("it can be reset");
                    for axis in Axis::ALL {
                        let is_homed = cell.step(&[]).axes[axis.index()].is_homed;
                        cell.parts_mut().0.set_homed(axis, is_homed);
                    }
                    for _ in 0..500 {
                        cell.step(&[]);
                    }
                    let after = cell.machine().truth().map(|(position, _)| position);
                    assert_eq!(place, after, "{what}: a reset moves nothing");
                }
                _ => assert_eq!(cell.outcome(), Some(MotionOutcome::Cancelled), "{what}"),
            }
            start(&mut cell, &[Axis::X, Axis::Z]).expect("it can be homed now");
            assert_eq!(finish(&mut cell), MotionOutcome::Completed, "{what}: {:?}", cell.machine().alarms());
            assert_eq!(homed(&mut cell), [false, true, true], "{what}");
        }
    }
}

#[test]
fn an_axis_that_fails_is_not_homed_no_other_follows_and_homing_one_homes_just_that_one() {
    let stuck = |level| Fault::StuckInput { input: Input::Home(Axis::X), level };
    let machine = both();
    let mut cell = cell(&machine);
    cell.step(&[stuck(Some(false))]);
    start(&mut cell, &Axis::ALL).expect("it starts");
    // It runs onto its hard limit.
    let outcome = finish(&mut cell);
    assert_eq!(outcome, MotionOutcome::Failed(12), "{:?}", cell.machine().alarms());
    assert_eq!(cell.machine().alarms().first().map(|alarm| alarm.kind), Some(AlarmKind::Overtravel(Axis::X)));
    assert_eq!(homed(&mut cell), [false; 3], "neither it nor those after it");
    cell.step(&[stuck(None)]);
    cell.reset().expect("it can be reset");
    start(&mut cell, &[Axis::Z]).expect("it starts");
    assert_eq!(finish(&mut cell), MotionOutcome::Completed, "{:?}", cell.machine().alarms());
    assert_eq!(homed(&mut cell), [false, false, true], "just that one");
}
