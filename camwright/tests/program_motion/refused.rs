// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Requests that the machine cannot execute are refused, with file and line.

use super::ideal;
use super::shop::{Part, Read, blocks, plan, program, setup};
use camwright::gcode::Dialect;
use camwright::machine::reference::cam_grinder;
use camwright::planner::program_motion::ProgramSetup;

fn refused(read: &Read, setup: ProgramSetup) -> String {
    plan(read, setup, &ideal()).expect_err("refused").to_string()
}

/// A round of 20 mm, from 25: three blocks that fit, X of the wheel's centre.
const GOOD: &str = "G0 X90 Z20 C0\nG0 X85\nG93 G64 P0.05\nG1 X80 C90 F60\nG1 C450 F20\nG1 X85 C540 F60\nG0 X90";

fn changed(from: &str, to: &str) -> Read {
    assert!(GOOD.contains(from), "{from}");
    blocks(&GOOD.replace(from, to))
}

#[test]
fn a_short_program_is_planned_and_each_fault_is_reported_with_its_line() {
    let machine = ideal();
    let good = plan(&blocks(GOOD), setup(), &machine).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((good.runs.len(), good.runs[0].1.blocks), (1, 3));
    for (from, to, words) in [
        (
            "G1 C450 F20",
            "G1 C450 F600",
            "short.ngc, line 6: in 0.1 s c_axis would go at 62.832 rad/s, 31.416 rad/s are allowed",
        ),
        ("X80 C90 F60", "X80 C90 Y1 F60", "short.ngc, line 5: Y goes to 1 mm; the machine has no Y"),
        ("G1 C450 F20", "G1 C80 F20", "short.ngc, line 6: the feed turns C from 90 to 80 deg"),
        ("G1 C450 F20", "G1 X79 F20", "short.ngc, line 6: the feed turns C from 90 to 90 deg"),
        ("P0.05", "P0.00001", "x_axis needs a"),
        (
            "Z20",
            "Z-20",
            "lines 5 to 7: z_axis is at 20 mm, where no lobe is before the wheel; the nearest, I1, is at 60 mm",
        ),
        ("X80", "X64", "x_axis goes to 4 mm; its soft limits are 5 to 250 mm"),
        ("X80", "X9999999", "line 5: x_axis goes to 9999939, beyond what can be counted"),
        ("G1 X80 C90 F60\nG1 C450 F20\nG1 X85 C540 F60\n", "", "no block of the program feeds"),
    ] {
        let found = refused(&changed(from, to), setup());
        assert!(found.contains(words), "{found}");
    }
}

/// A tolerance that leaves the corners too sharp for the axes says how wide a window it allows, and where.
#[test]
fn corners_that_need_more_rounding_are_reported_with_the_amount() {
    let found = refused(&changed("P0.05", "P0.00001"), setup());
    assert!(found.starts_with("short.ngc, line ") && found.contains("mm/s"), "{found}");
    assert!(found.contains("as the path tolerance of 0.010 um allows"), "{found}");
    // Slow enough, the same corners pass.
    let slow = GOOD.replace("P0.05", "P0.00001").replace("F60", "F0.4").replace("F20", "F0.2");
    plan(&blocks(&slow), setup(), &ideal()).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn a_setup_that_is_none_and_another_rotation_sense_are_refused() {
    let read = blocks(GOOD);
    for (setup, words) in [
        (ProgramSetup { cutter_radius_mm: 0.0, ..setup() }, "the cutter's radius (mm) is 0, it must be above 0"),
        (ProgramSetup { cutter_radius_mm: f64::NAN, ..setup() }, "the cutter's radius (mm) is NaN"),
        (ProgramSetup { z_zero_mm: f64::INFINITY, ..setup() }, "Z 0 (mm) is inf"),
        (ProgramSetup { path_tolerance_mm: -1.0, ..setup() }, "the control's path tolerance (mm) is -1"),
        (ProgramSetup { rotation_sense: -1, ..setup() }, "for a rotation sense of -1, this machine's is 1"),
    ] {
        let found = refused(&read, setup);
        assert!(found.contains(words), "{found}");
    }
}

/// The wheel of the plan is the program's cutter: the machine stops before anything moves where another is mounted.
#[test]
fn a_program_for_another_wheel_is_an_alarm_before_anything_moves() {
    use camwright::interpolator::{Motion, Prepared};
    use camwright::machine::persistent_state::PersistentState;
    use camwright::simulation::Machine;
    use camwright::simulation::closed_loop::{ClosedLoop, SimulationError};
    let machine = cam_grinder();
    let (_, read) = program(&Part::lobe(), Dialect::Siemens, 10.0);
    let other = ProgramSetup { cutter_radius_mm: 59.0, ..setup() };
    let planned = plan(&read, other, &machine).unwrap_or_else(|error| panic!("{error}"));
    let grinder = Machine::new(machine.clone(), PersistentState::new(&machine)).expect("a machine");
    let motion = Prepared::new(Motion::Plan(std::sync::Arc::new(planned.plan)), &machine).expect("ready");
    let done = ClosedLoop::direct(grinder).simulate(Box::new(motion), |_, _| {});
    assert!(matches!(done, Err(SimulationError::Alarm(_))), "{done:?}");
}

/// Feeds at two stations: what comes before a lobe's feeds belongs to it, what comes after the last to nobody.
#[test]
fn every_step_is_reported_with_its_lobe() {
    let second = GOOD.replace("Z20 C0", "Z70 C540").replace("C540 F60", "C1080 F60").replace("C450", "C990");
    let second = second.replace("C90 F60", "C630 F60");
    let planned = plan(&blocks(&format!("{GOOD}\n{second}")), setup(), &ideal()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(planned.plan.lobes, ["I1", "E1"]);
    let lobes: Vec<_> = planned.runs.iter().map(|(segment, _)| planned.plan.segments[*segment].lobe).collect();
    assert_eq!(lobes, [Some(0), Some(1)]);
    let (first, last) = (planned.runs[0].0, planned.runs[1].0);
    assert!(planned.plan.segments[first + 1..last].iter().all(|segment| segment.lobe == Some(1)));
    assert!(planned.plan.segments[last + 1..].iter().all(|segment| segment.lobe.is_none()));
}

/// The same way of the wheel, said of its cutting point.
#[test]
fn x_of_the_edge_is_a_radius_less_than_that_of_the_centre() {
    let edge = GOOD.replace("X90", "X30").replace("X85", "X25").replace("X80", "X20");
    let of_edge = plan(&blocks(&edge), ProgramSetup { x_of_edge: true, ..setup() }, &ideal());
    let of_centre = plan(&blocks(GOOD), setup(), &ideal()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(of_edge.unwrap_or_else(|error| panic!("{error}")).plan, of_centre.plan);
}
