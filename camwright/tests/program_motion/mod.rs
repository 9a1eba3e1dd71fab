// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Programs in the dialects of controls, read, and driven by the simulated machine as a plain control would drive them: what is left on the
//! part.
#![allow(clippy::print_stdout, reason = "figures for the reader of --nocapture")]

mod random;
mod refused;
pub(crate) mod shop;

use camwright::gcode::Dialect;
use camwright::machine::description::{Axis, DriveSettings, MachineDescription};
use camwright::machine::reference::cam_grinder;
use camwright::math::hermite::HermiteSpline;
use camwright::planner::plan_check::check_plan;
use shop::{Part, STATION_MM, TOLERANCE_MM, ground, lobe_on_the_machine, planned, program, start};

fn ideal() -> MachineDescription {
    cam_grinder().with_drives(DriveSettings::IDEAL)
}

/// Error of the wheel's sweep and of a count of X and C (mm).
const SIMULATED_MM: f64 = 1e-4;

/// With ideal drives the part is off by what the pieces of the program and their rounding are off, and by no more.
#[test]
fn ideal_drives_leave_the_tolerance_of_the_blocks_and_of_their_corners() {
    let machine = ideal();
    for part in [Part::lobe(), Part::eccentric()] {
        for dialect in Dialect::ALL {
            // One piece of the eccentric is a seventeenth of a degree, and a Fanuc's shortest block takes 6 ms.
            let rpm = if dialect == Dialect::Fanuc && part.name == "eccentric" { 1.5 } else { 10.0 };
            let (posted, read) = program(&part, dialect, rpm);
            let planned = planned(&read, &machine);
            assert_eq!(planned.runs.len(), 4);
            let finish = &planned.runs[3].1;
            let blocks_mm = posted.turns[1].deviation.error_mm;
            let (low, high) = ground(&planned, &part, &machine);
            println!(
                "{} {dialect:?}, ideal drives: {:+.3} to {:+.3} um; blocks {:.3} um, corners over {:.3} deg {:.3} um, ramps {:.1} ms",
                part.name,
                1e3 * low,
                1e3 * high,
                1e3 * blocks_mm,
                finish.laws.window_rad.to_degrees(),
                1e3 * finish.laws.rounding_mm,
                1e3 * finish.laws.ramp_s
            );
            assert!(finish.laws.rounding_mm > 1e-6 && finish.laws.rounding_mm <= finish.tolerance_mm);
            let max = blocks_mm + finish.laws.rounding_mm + SIMULATED_MM;
            assert!(low > -max && high < max, "{} {dialect:?}: {low} {high}, {max} allowed", part.name);
            // Coarser blocks than that would be found.
            assert!(high.max(-low) > 0.2 * blocks_mm, "{low} {high}");
        }
    }
}

/// The error of the drives adds to the rounding of the control, position by position: both are largest on the flanks, where lag may
/// compensate the rounding.
#[test]
fn ordinary_drives_leave_an_error_that_grows_with_speed() {
    let part = Part::lobe();
    let mut before = 0.0;
    for (rpm, max_mm) in [(15.0, 1e-3), (50.0, 5e-3)] {
        let (posted, read) = program(&part, Dialect::Siemens, rpm);
        let planned = planned(&read, &cam_grinder());
        let finish = &planned.runs[3].1.laws;
        let bound_mm = posted.turns[1].deviation.error_mm + finish.rounding_mm + SIMULATED_MM;
        let [good, ordinary] = [ideal(), cam_grinder()].map(|machine| lobe_on_the_machine(&planned, &part, &machine));
        let besides_mm = good.iter().zip(&ordinary).map(|(good, other)| (good - other).abs()).fold(0.0, f64::max);
        let [good, ordinary] = [good, ordinary].map(|radii| {
            let (low, high) = part.deviation(&radii);
            high.max(-low)
        });
        println!(
            "{} at {rpm} 1/min: ideal drives {:.2} um, ordinary ones {:.2} um, {:.3} um between them; corners {:.2} um",
            part.name,
            1e3 * good,
            1e3 * ordinary,
            1e3 * besides_mm,
            1e3 * finish.rounding_mm
        );
        assert!(good < bound_mm && ordinary < bound_mm + besides_mm, "{good} {ordinary} {bound_mm} {besides_mm}");
        assert!(besides_mm > before && besides_mm < max_mm, "{besides_mm}");
        before = besides_mm;
    }
    assert!(before > 2e-4, "drives that lag must be seen: {before}");
}

/// Blocks that are rounded may be faster than their corners allow: what a control loses is seen in the window.
#[test]
fn a_faster_part_is_rounded_over_a_wider_window_within_its_tolerance() {
    let part = Part::lobe();
    let machine = ideal();
    let mut before = 0.0;
    for rpm in [8.0, 15.0, 30.0] {
        let (_, read) = program(&part, Dialect::Siemens, rpm);
        let finish = planned(&read, &machine).runs[3].1.clone();
        println!(
            "{rpm} 1/min: {:.4} deg, {:.4} um",
            finish.laws.window_rad.to_degrees(),
            1e3 * finish.laws.rounding_mm
        );
        assert!(
            finish.laws.rounding_mm > before && finish.laws.rounding_mm <= TOLERANCE_MM && finish.laws.max_used <= 1.0
        );
        before = finish.laws.rounding_mm;
    }
}

/// The plan is checked against the program: the blocks' time and two ramps, every knot of the program within the rounding, C from rest to
/// rest over the angle of the blocks.
#[test]
fn a_run_is_its_blocks_and_two_ramps() {
    let (machine, part) = (ideal(), Part::lobe());
    let (posted, read) = program(&part, Dialect::LinuxCnc, 30.0);
    let planned = planned(&read, &machine);
    for ((segment, run), (turn, phase_rad, leaves_mm)) in planned.runs.iter().zip(&posted.calls) {
        let turn = &posted.turns[*turn];
        let laws = &run.laws;
        assert!((laws.programmed_s - turn.time_s).abs() < 1e-5, "{} {}", laws.programmed_s, turn.time_s);
        assert!((laws.duration_s() - laws.programmed_s - 2.0 * laws.ramp_s).abs() < 1e-9);
        assert_eq!(run.blocks, turn.blocks);
        let first = turn.knots[0].0;
        let mut worst = 0.0_f64;
        for (u, axes) in &turn.knots {
            let x = laws.path.sample(u - first).value + part.wheel_mm();
            worst = worst.max((x - axes[0] - leaves_mm).abs());
        }
        assert!(worst <= laws.rounding_mm + 1e-6 && worst > 0.3 * laws.rounding_mm, "{worst} {}", laws.rounding_mm);
        let start = machine.axis(Axis::C).scale.position(run.start_counts);
        assert!((start - phase_rad - first).abs() < 1e-6, "{start}");
        let ends =
            |law: &HermiteSpline| [law.sample(law.start()), law.sample(law.end())].map(|end| (end.first, end.second));
        assert_eq!(ends(&laws.speed), [(0.0, 0.0); 2]);
        assert!(laws.ramps_rad.0 < 0.5 && laws.ramps_rad.1 < 0.5, "within the lead: {:?}", laws.ramps_rad);
        assert!((laws.advance.sample(1.0).value - STATION_MM).abs() < 1e-12);
        assert!(
            planned.plan.segments[*segment].label.contains("feeds of lobe.ngc, line"),
            "{}",
            planned.plan.segments[*segment].label
        );
    }
    assert!(planned.report.max_ratio() <= 1.0 + 1e-6);
    let again = check_plan(&planned.plan, &machine, start(&machine).counts).expect("within limits");
    assert_eq!(again, planned.report);
}

#[test]
fn the_same_program_gives_the_same_bits() {
    let part = Part::lobe();
    let run = || {
        let (_, read) = program(&part, Dialect::Fanuc, 10.0);
        let machine = cam_grinder();
        let planned = planned(&read, &machine);
        let radii = lobe_on_the_machine(&planned, &part, &machine);
        (planned.plan, radii.iter().map(|radius| radius.to_bits()).collect::<Vec<_>>())
    };
    let (first, second) = (run(), run());
    assert!(first.0 == second.0 && first.1 == second.1);
}
