// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Slow changes, and effects once per wheel turn: growth of the wheelhead, unbalance.

use super::turned::{WHEEL_MM, turning};
use super::{follow, ideal, idle, machine};
use camwright::machine::description::{ContactDescription, MachineDescription, StiffnessAt, ThermalDescription};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::setpoint::Setpoint;
use camwright::math::units::TURN_RAD;
use camwright::simulation::workpiece::DEFAULT_AZIMUTHS;
use camwright::simulation::{Machine, MachineCommand};

fn growing(start_share: f64) -> MachineDescription {
    let thermal = ThermalDescription { growth_mm: 0.01, time_constant_s: 20.0, start_share };
    MachineDescription { thermal: Some(thermal), ..ideal() }
}

/// G (1 − exp(−t/τ)) of the time that the spindle has turned; nothing while it stands, and nothing more of a warm machine.
#[test]
fn the_wheelhead_grows_exponentially_while_its_spindle_turns() {
    let mut cold = machine(&growing(0.0));
    idle(&mut cold, 3000);
    assert_eq!(cold.lasting().growth_mm.to_bits(), 0.0_f64.to_bits(), "the spindle stands");
    cold.step(None, &[MachineCommand::WheelStart], &[]);
    for ticks in [4999, 5000, 30_000] {
        idle(&mut cold, ticks);
        let seconds = (cold.tick() - 3000) as f64 * 1e-3;
        let wanted = 0.01 * (1.0 - (-seconds / 20.0).exp());
        let found = cold.lasting().growth_mm;
        assert!((found - wanted).abs() < 1e-12, "{seconds} s: {found} {wanted}");
        let thermal = cold.description().thermal.expect("it grows");
        assert!((thermal.after_mm(0.0, seconds) - wanted).abs() < 1e-15);
    }
    let mut warm = machine(&growing(1.0));
    warm.step(None, &[MachineCommand::WheelStart], &[]);
    idle(&mut warm, 5000);
    assert_eq!(warm.lasting().growth_mm.to_bits(), 0.01_f64.to_bits());
}

/// One turn and a little of a round part, X at 20 mm.
fn ground(
    description: &MachineDescription,
    lasting: PersistentState,
    turns: f64,
    ticks: u32,
) -> (Vec<f64>, Vec<Setpoint>) {
    let mut machine = Machine::new(description.clone(), lasting).expect("valid");
    machine.load_lobe("J1", "LS1", 15.0, vec![20.1; DEFAULT_AZIMUTHS]).expect("a blank");
    let setpoints = turning(description, 60.0, turns, ticks, |_| (20.0, 0.0, 0.0));
    machine.place(setpoints[0].counts);
    follow(&mut machine, &setpoints[1..]);
    assert!(machine.alarms().is_empty(), "{:?}", machine.alarms());
    (machine.part().lobes()[0].radii_mm().to_vec(), setpoints)
}

/// A wheelhead that has grown by g since the wheel was dressed leaves the part smaller by g; what it had grown by before then the
/// dresser took off the wheel.
#[test]
fn growth_since_the_dress_is_missing_on_the_part() {
    let mut description = growing(0.0);
    description.thermal = Some(ThermalDescription { growth_mm: 0.01, time_constant_s: 1e9, start_share: 0.0 });
    for (growth_mm, growth_at_dress_mm) in [(0.01, 0.0), (0.01, 0.01), (0.004, 0.01), (0.0, 0.0)] {
        let lasting = PersistentState { growth_mm, growth_at_dress_mm, ..PersistentState::new(&description) };
        let (radii, _) = ground(&description, lasting, 1.5, 1500);
        let wanted = 20.0 - (growth_mm - growth_at_dress_mm);
        for radius in radii {
            // The cusps of the sweep.
            assert!((radius - wanted).abs() < 2e-5, "{radius} {wanted}");
        }
    }
}

/// A wheel that unbalance throws by u to either side writes its turns on the part: as many waves as it turns, u deep on both sides where
/// the wheel fits into them.
#[test]
fn a_wheel_out_of_balance_writes_its_turns_on_the_part() {
    let mut description = ideal();
    description.wheel.unbalance_mm = 5e-4;
    let (radii, setpoints) = ground(&description, PersistentState::new(&description), 1.2, 1000);
    let per_rad = description.axes[0].scale.counts_per_unit();
    let at =
        |angle: f64| setpoints.iter().position(|s| s.counts[0] as f64 / per_rad >= angle).expect("it turned so far");
    let (from, to) = (0.3 * TURN_RAD, 0.8 * TURN_RAD);
    let seconds = (at(to) - at(from)) as f64 * 1e-3;
    let wheel_turns = 1e3 * description.wheel.surface_speed_m_s / WHEEL_MM * seconds / TURN_RAD;
    // The azimuths from 0.3 to 0.8 turns.
    let seen = &radii[1080..2880];
    let waves = seen.windows(2).filter(|pair| pair[0] < 20.0 && pair[1] >= 20.0).count();
    eprintln!("{waves} waves, {wheel_turns} turns of the wheel");
    assert!((waves as f64 - wheel_turns).abs() < 2.0, "{waves} {wheel_turns}");
    let (low, high) = seen.iter().fold((f64::MAX, f64::MIN), |(low, high), r| (low.min(*r), high.max(*r)));
    assert!((low - 19.9995).abs() < 2e-5 && (high - 20.0005).abs() < 8e-5, "{low} {high}");
}

/// After twenty turns whose phases differ little but the deepest waves is left: the part is smaller by u, and round to a third of what one
/// turn writes.
#[test]
fn beating_turns_leave_the_envelope_of_the_waves() {
    let mut description = ideal();
    description.wheel.unbalance_mm = 5e-4;
    let (radii, _) = ground(&description, PersistentState::new(&description), 20.3, 20_000);
    let (low, high) = radii.iter().fold((f64::MAX, f64::MIN), |(low, high), r| (low.min(*r), high.max(*r)));
    assert!(low > 19.9995 - 1e-6 && high < 19.9995 + 1e-3 / 3.0, "{low} {high}");
}

/// Wheel and part that deflect let through km/(km + kg) of the wave.
#[test]
fn what_gives_way_softens_the_waves() {
    let contact = ContactDescription {
        stiffness: vec![StiffnessAt { z_mm: 60.0, n_mm: 1e4 }],
        grinding_n_mm2: 2e3,
        threshold_n_mm: 0.0,
        part_share: 0.5,
        modes: Vec::new(),
    };
    let mut description = MachineDescription { contact: Some(contact), ..ideal() };
    description.wheel.unbalance_mm = 5e-4;
    let (radii, _) = ground(&description, PersistentState::new(&description), 1.2, 1000);
    let seen = &radii[1000..2800];
    let (low, high) = seen.iter().fold((f64::MAX, f64::MIN), |(low, high), r| (low.min(*r), high.max(*r)));
    let wanted = 2.0 * 5e-4 * 1e4 / (1e4 + 3e4);
    assert!(((high - low) / wanted - 1.0).abs() < 0.1, "{} {wanted}", high - low);
}
