// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Reaction of alarms with the wheel in the cut.

use super::grinding::{loaded, path_setpoints};
use super::turned::Eccentric;
use super::{cam_grinder, follow, ideal, idle};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{Axis, MachineDescription};
use camwright::machine::setpoint::Setpoint;
use camwright::simulation::Machine;
use camwright::simulation::fault::Fault;
use camwright::simulation::{MachineCommand, ResetRefused};

const DISC: Eccentric = Eccentric { radius_mm: 19.0, offset_mm: 4.2 };

/// A machine in the middle of the second turn of an eccentric, and the setpoints that come.
fn cutting(description: &MachineDescription) -> (Machine, Vec<Setpoint>) {
    let mut machine = loaded(description, 23.4);
    let setpoints = path_setpoints(description, DISC, 2.0, 3000);
    machine.place(setpoints[0].counts);
    let reports = follow(&mut machine, &setpoints[..2000]);
    assert!(reports.iter().all(|report| report.raised.is_empty()));
    (machine, setpoints[2000..].to_vec())
}

fn deepest_mm(machine: &Machine) -> f64 {
    let radii = machine.part().lobes()[0].radii_mm();
    let azimuth = |i: usize| i as f64 * camwright::math::units::TURN_RAD / radii.len() as f64;
    radii.iter().enumerate().map(|(i, radius)| DISC.radius(azimuth(i)) - radius).fold(0.0, f64::max)
}

/// From a buffer that suffices, the wheel leaves beside the path; from an empty one the drives are off at once, and the weight draws
/// the wheelhead back. Nothing can be reset before the mains are back.
#[test]
fn a_power_loss_takes_the_wheel_off_from_the_buffer_or_by_the_weight() {
    let mut machines = [ideal(), ideal(), ideal()];
    machines[1].retract.buffered_energy_j = 0.0;
    // Half of what drives and control alone need until the axes rest.
    machines[2].retract.buffered_energy_j = 20.0;
    for description in machines {
        let buffer_j = description.retract.buffered_energy_j;
        let (mut machine, to_come) = cutting(&description);
        let before = machine.step(Some(&to_come[0]), &[], &[]);
        let first = machine.step(Some(&to_come[1]), &[], &[Fault::PowerLoss(true)]);
        assert_eq!(first.raised.first().map(|alarm| alarm.kind), Some(AlarmKind::PowerLoss));
        assert_eq!(first.io.drives_on, buffer_j > 0.0, "{buffer_j} J");
        assert!(before.io.drives_on);
        let reports = follow(&mut machine, &to_come[2..]);
        idle(&mut machine, 1000);
        assert!(machine.is_at_rest(), "{buffer_j} J");
        let gap_mm = machine.wheel_gap_mm().expect("it stands in front of the wheel");
        assert!(gap_mm > description.retract.clearance_mm - 0.1, "{buffer_j} J: {gap_mm} mm");
        // 500 W from 20 J last 40 ms, less what moves the axes; 100 J more than 0.2 s.
        let powered = reports.iter().take_while(|report| report.io.drives_on).count();
        assert!(if buffer_j > 100.0 { powered > 100 } else { powered < 41 }, "{buffer_j} J: {powered} ticks");
        assert_eq!(machine.reset(), Err(ResetRefused::PowerLost));
        machine.step(None, &[], &[Fault::PowerLoss(false)]);
        machine.reset().expect("the mains are back");
    }
}

/// A machine without weight or spring leaves the wheel where the brake stops it.
#[test]
fn without_a_weight_a_wheelhead_without_drive_stays_where_its_brake_stops_it() {
    let mut description = ideal();
    description.retract.drawback_mm_s2 = 0.0;
    let (mut machine, to_come) = cutting(&description);
    machine.step(Some(&to_come[0]), &[], &[Fault::DriveFault { axis: Axis::X, active: true }]);
    idle(&mut machine, 1000);
    assert!(machine.is_at_rest());
    assert!(machine.wheel_gap_mm().expect("it stands in front of the wheel") < 1.0);
}

/// At any tick of a turn the stop on the path with X beside it cuts no deeper than the path itself.
#[test]
fn a_stop_in_the_cut_takes_nothing_below_the_design() {
    for at in (0..900).step_by(59) {
        let (mut machine, to_come) = cutting(&ideal());
        follow(&mut machine, &to_come[..at]);
        machine.step(Some(&to_come[at]), &[], &[Fault::EStop(true)]);
        // The stream goes on as far as it was sent.
        follow(&mut machine, &to_come[at + 1..(at + 100).min(to_come.len())]);
        idle(&mut machine, 1000);
        assert!(machine.is_at_rest() && machine.wheel_gap_mm().expect("in front of the wheel") > 1.9);
        assert!(deepest_mm(&machine) < 1e-4, "at {at}: {} mm", deepest_mm(&machine));
    }
}

/// A reading that jumps farther than the axis can is not believed: the drive loses its power at once, the axis its zero.
#[test]
fn an_encoder_that_jumps_costs_the_axis_its_zero() {
    let mut machine =
        Machine::new(cam_grinder(), camwright::machine::persistent_state::PersistentState::new(&cam_grinder()))
            .expect("a machine");
    machine.step(None, &[MachineCommand::SetHome { axis: Axis::C, counts: 0 }], &[]);
    let report = machine.step(None, &[], &[Fault::EncoderOffset { axis: Axis::C, offset: 0.01 }]);
    assert_eq!(report.raised.first().map(|alarm| alarm.kind), Some(AlarmKind::EncoderJump(Axis::C)));
    assert!(!report.axes[0].is_homed && !report.axes[0].is_powered && report.axes[1].is_powered);
    idle(&mut machine, 100);
    machine.reset().expect("the axes rest");
    assert!(!machine.step(None, &[], &[]).axes[0].is_homed);
}
