// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The simulated machine: what it does with setpoints, and what it leaves of a part.

mod bores;
mod chatter;
mod compliance;
mod correcting;
mod drives;
mod grinding;
mod guarding;
mod heat;
mod keyframes;
mod motion;
mod pins;
mod real;
mod sections;
mod slow;
mod stopping;
mod tapered;
mod turned;
mod turning;
mod wheel_changer;

use camwright::machine::description::{
    AXIS_COUNT, Axis, ContactDescription, DriveSettings, Homing, MachineDescription, StiffnessAt,
};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::reference::cam_grinder;
use camwright::machine::setpoint::Setpoint;
use camwright::simulation::Machine;
use camwright::simulation::fault::Fault;
use camwright::simulation::tick_report::TickReport;

/// The reference machine with ideal drives.
fn ideal() -> MachineDescription {
    cam_grinder().with_drives(DriveSettings::IDEAL)
}

fn machine(description: &MachineDescription) -> Machine {
    Machine::new(description.clone(), PersistentState::new(description)).expect("the reference machine is valid")
}

/// Homing of X at a switch, without an index.
pub(crate) const HOMING_AT_A_SWITCH: Homing = Homing {
    search_mm_s: 20.0,
    latch_mm_s: -1.0,
    final_mm_s: 50.0,
    use_index: false,
    offset_mm: None,
    home_mm: 150.0,
    ignore_limits: false,
    sequence: 0,
    switch_mm: 200.0,
    index_pitch_mm: 10.0,
};

/// A setpoint from positions, speeds and accelerations (mm or rad, s).
fn setpoint(
    description: &MachineDescription,
    position: [f64; AXIS_COUNT],
    velocity: [f64; AXIS_COUNT],
    acceleration: [f64; AXIS_COUNT],
) -> Setpoint {
    Setpoint { counts: std::array::from_fn(|i| description.axes[i].scale.counts(position[i])), velocity, acceleration }
}

/// Share of a move done at share `u` of its time, with its first and second derivative: 10u³ − 15u⁴ + 6u⁵.
fn ease(u: f64) -> (f64, f64, f64) {
    (
        u * u * u * (10.0 + u * (-15.0 + u * 6.0)),
        u * u * (30.0 + u * (-60.0 + u * 30.0)),
        u * (60.0 + u * (-180.0 + u * 120.0)),
    )
}

/// A move of one axis by `distance` (mm or rad) in `ticks` from where the machine's setpoint rests.
fn travel(machine: &Machine, axis: Axis, distance: f64, ticks: u32) -> Vec<Setpoint> {
    let (rest, i) = (machine.setpoint(), axis.index());
    let scale = machine.description().axes[i].scale;
    let seconds = f64::from(ticks) * machine.description().cycle_time_s();
    (1..=ticks)
        .map(|k| {
            let (share, first, second) = ease(f64::from(k) / f64::from(ticks));
            let mut setpoint = rest;
            setpoint.counts[i] = rest.counts[i] + scale.counts(distance * share);
            setpoint.velocity[i] = if k == ticks { 0.0 } else { distance * first / seconds };
            setpoint.acceleration[i] = if k == ticks { 0.0 } else { distance * second / seconds / seconds };
            setpoint
        })
        .collect()
}

/// Runs setpoints through a machine.
fn follow(machine: &mut Machine, setpoints: &[Setpoint]) -> Vec<TickReport> {
    setpoints.iter().map(|setpoint| machine.step(Some(setpoint), &[], &[])).collect()
}

fn idle(machine: &mut Machine, ticks: u32) -> Vec<TickReport> {
    (0..ticks).map(|_| machine.step(None, &[], &[])).collect()
}

/// A contact whose cut is five times as stiff as the machine, over a width.
pub(crate) fn soft_contact(z_mm: f64, width_mm: f64) -> ContactDescription {
    ContactDescription {
        stiffness: vec![StiffnessAt { z_mm, n_mm: 1e4 }],
        grinding_n_mm2: 5e4 / width_mm,
        threshold_n_mm: 15.0 / width_mm,
        part_share: 0.5,
        modes: Vec::new(),
    }
}

/// An emergency stop at a tick of setpoints: the machine comes to rest with the wheel clear of the lobe in front of it.
pub(crate) fn stop_and_clear(machine: &mut Machine, setpoints: &[Setpoint], at: usize) {
    machine.place(setpoints[0].counts);
    follow(machine, &setpoints[..at]);
    machine.step(Some(&setpoints[at]), &[], &[Fault::EStop(true)]);
    follow(machine, &setpoints[at + 1..(at + 101).min(setpoints.len())]);
    idle(machine, 2000);
    assert!(machine.is_at_rest());
    let gap_mm = machine.wheel_gap_mm().expect("in front of the wheel");
    assert!(gap_mm > machine.description().retract.clearance_mm - 0.1, "at {at}: {gap_mm} mm from the lobe");
}
