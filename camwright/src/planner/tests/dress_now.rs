// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A dress of its own: the wheel is smaller afterwards, and nothing else has changed.

use super::*;
use crate::machine::fixture::Dresser;
use crate::machine::wheel_state::WheelNow;
use crate::motion::plan::{Half, PlanCommand};

fn with_dresser() -> MachineDescription {
    let mut machine = machine();
    machine.wheel.grinding_ratio = Some(500.0);
    machine.dresser = Some(Dresser {
        x_mm: 60.0,
        z_mm: 360.0,
        width_mm: 2.0,
        infeed_speed_mm_s: 1.0,
        traverse_speed_mm_s: 10.0,
        dwell_s: 0.2,
        max_depth_mm: 0.05,
    });
    machine
}

#[test]
fn a_dress_now_leaves_the_wheel_dressed_and_no_part_made() {
    let machine = with_dresser();
    let wheel = WheelNow { radius_mm: 59.5, wear_mm: 0.004, lobes_since_dress: 7, parts_since_dress: 2 };
    let (plan, dress) = plan_dress(&machine, wheel, 0.01).expect("it can be dressed");
    assert_eq!((dress.radius_nm, plan.half), (59_486_000, Half::NoPart));
    let motion = Prepared::new(Motion::Plan(Arc::new(plan.clone())), &machine).expect("a motion");
    let grinder = Machine::new(machine.clone(), PersistentState::new(&machine).with_wheel(wheel)).expect("a machine");
    let mut nearest = f64::INFINITY;
    let mut closed_loop = ClosedLoop::direct(grinder);
    let simulated = closed_loop.simulate(Box::new(motion), |setpoint, report| {
        if report.wheel_rad_s > 0.0 {
            nearest = nearest.min(machine.axis(Axis::X).scale.position(setpoint.counts[Axis::X.index()]));
        }
    });
    let result = simulated.unwrap_or_else(|error| panic!("{error}"));
    let lasting = closed_loop.machine().lasting();
    assert!((lasting.wheel_radius_mm - 59.486).abs() < 1e-9 && lasting.wheel_wear_mm == 0.0, "{lasting:?}");
    assert_eq!((lasting.dress_count, lasting.lobes_since_dress, lasting.parts_since_dress), (1, 0, 0));
    assert!((nearest - 60.0).abs() < 1e-5, "the dresser's rim: {nearest}");
    let report = closed_loop.step(&[]);
    assert!(
        (report.axes[1].position - 180.0).abs() < 1e-5 && !report.io.wheel_running,
        "clear of everything, and still"
    );
    let seconds = (result.last_tick - result.first_tick) as f64 * 1e-3;
    assert!((seconds - plan.duration_s).abs() < 0.1 + 2.0, "{seconds} s, predicted {} s", plan.duration_s);
    // The plan names the wheel: another one stops the machine before anything moves.
    assert!(matches!(plan.segments[0].kind, SegmentKind::Command(PlanCommand::ExpectWheel { radius_nm: 59_500_000 })));
}

#[test]
fn impossible_dresses_are_refused_with_their_figures() {
    let machine = with_dresser();
    let wheel = |radius_mm, wear_mm| WheelNow { wear_mm, ..WheelNow::dressed(radius_mm) };
    let refusal = |machine: &MachineDescription, wheel, depth_mm| {
        plan_dress(machine, wheel, depth_mm).expect_err("refused").to_string()
    };
    let without = MachineDescription { dresser: None, ..machine.clone() };
    assert_eq!(refusal(&without, wheel(59.0, 0.0), 0.01), "machine test grinder has no dresser");
    for depth_mm in [0.0, -0.01, f64::NAN, f64::INFINITY] {
        assert!(refusal(&machine, wheel(59.0, 0.0), depth_mm).contains("it must be above 0"), "{depth_mm}");
    }
    let deep = refusal(&machine, wheel(59.0, 0.02), 0.04);
    assert!(deep.contains("takes 60.000 um") && deep.contains("allowed 50.000 um"), "{deep}");
    let worn = refusal(&machine, wheel(40.005, 0.0), 0.01);
    assert!(worn.contains("39.9950 mm") && worn.contains("mount a new wheel"), "{worn}");
}
