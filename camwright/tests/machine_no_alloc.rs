// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The cyclic path of the machine does not allocate: a test of its own, since it replaces the allocator.

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{
    Axis, ContactDescription, ContactMode, GaugeDescription, GaugeKind, GrindingProcess, MachineDescription,
    MagazineWheel, ReferenceCut, StiffnessAt, Structure, WheelChanger, WheelDescription,
};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::reference::{cam_grinder, lathe};
use camwright::machine::setpoint::{Input, Setpoint};
use camwright::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use camwright::simulation::buffer::{Chunk, SetpointBuffer, TailPoint};
use camwright::simulation::fault::Fault;
use camwright::simulation::turned_part::{PartGrid, TurnedPart};
use camwright::simulation::{Machine, MachineCommand};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

const PROCESS: GrindingProcess = GrindingProcess {
    specific_energy_j_mm3: 40.0,
    rubbing_n_mm2: 0.05,
    safe_cut: ReferenceCut { footprint_speed_mm_s: 300.0, depth_mm: 0.01, equivalent_diameter_mm: 30.0 },
};

/// Chunks come, setpoints run, the wheel cuts, edges are caught, faults strike, alarms are raised.
#[test]
fn a_tick_does_not_allocate_whatever_happens_in_it() {
    let contact = ContactDescription {
        stiffness: vec![StiffnessAt { z_mm: 60.0, n_mm: 4e4 }, StiffnessAt { z_mm: 90.0, n_mm: 3e4 }],
        grinding_n_mm2: 1.5e3,
        threshold_n_mm: 0.8,
        part_share: 0.5,
        modes: vec![ContactMode { frequency_rad_s: 1200.0, damping: 0.05, compliance_share: 0.3 }],
    };
    let gauge = GaugeDescription {
        kind: GaugeKind::Diameter,
        behind_wheel_rad: 4.7,
        second_behind_wheel_rad: Some(3.0),
        resolution_mm: 1e-4,
        noise_mm: 2e-4,
        bandwidth_rad_s: Some(300.0),
        seed: 1,
    };
    for (contact, gauge) in [(None, None), (Some(contact), Some(gauge))] {
        let mut description =
            MachineDescription { process: contact.is_some().then_some(PROCESS), contact, gauge, ..cam_grinder() };
        description.wheel.unbalance_mm = 1e-4;
        for axis in &mut description.axes {
            axis.drive.velocity_integral_s = Some(0.01);
            axis.drive.coulomb_friction = 1.0;
            axis.drive.structure = Some(Structure { frequency_rad_s: 900.0, damping: 0.04, mass_share: 0.2 });
            (axis.drive.encoder_step_counts, axis.drive.encoder_noise_counts) = (1.0, 0.3);
        }
        run_through_everything(description);
    }
}

fn run_through_everything(description: MachineDescription) {
    let mut machine = Machine::new(description.clone(), PersistentState::new(&description)).expect("valid");
    machine.load_lobe("I1", "LS1", 15.0, vec![23.0; 3600]).expect("a round blank");
    machine.place([0, 2_290_000, 600_000]);
    let mut buffer = SetpointBuffer::new(&description, machine.setpoint());
    let faults = [
        Fault::StuckInput { input: Input::Station(0), level: Some(true) },
        Fault::EncoderOffset { axis: Axis::Z, offset: 0.01 },
        Fault::DriveGain { axis: Axis::X, factor: 0.9 },
        Fault::WheelStall(true),
        Fault::EStop(true),
        Fault::EStop(false),
    ];
    // C at constant acceleration: v = a t, c = a t²/2.
    let (acceleration, rest) = (20.0, machine.setpoint());
    let at = |tick: u64| {
        let t = tick as f64 * 1e-3;
        let mut setpoint = rest;
        setpoint.counts[0] = description.axes[0].scale.counts(0.5 * acceleration * t * t);
        setpoint.velocity[0] = acceleration * t;
        setpoint.acceleration[0] = acceleration;
        setpoint
    };
    let mut dense = [Setpoint::default(); 8];
    let (mut removed, mut edges, mut raised) = (0.0, 0, 0);
    for first in (1..800).step_by(8) {
        for (tick, setpoint) in (first..).zip(&mut dense) {
            *setpoint = at(tick);
        }
        let (mut end, stop) = (at(first + 7), 2 * first + 40);
        // The stop: as long as the way there, at the same deceleration, so as far again.
        end.counts[0] *= 2;
        end.velocity[0] = 0.0;
        end.acceleration[0] = 0.0;
        let tail = [TailPoint { tick: stop, setpoint: end }];
        let chunk = Chunk { first_tick: first, dense: &dense, tail: &tail, is_final: false };
        assert_no_alloc(|| {
            buffer.accept(&chunk, machine.tick()).expect("each continues the one before");
            for tick in first..first + 8 {
                let setpoint = buffer.at(tick);
                let order = [MachineCommand::WheelStart];
                let report = machine.step(setpoint.as_ref(), &order, &[]);
                buffer.executed(tick);
                removed += report.removal.area_mm2;
                edges += report.latches.len();
                raised += report.raised.len();
            }
        });
    }
    // A keyframe is written between two ticks; one that finds no room is only not there.
    let mut room = vec![0; 200_000];
    assert_no_alloc(|| {
        let mut codec = SnapshotCodec::writing(&mut room);
        machine.snapshot(&mut codec).and_then(|()| buffer.snapshot(&mut codec)).expect("there is room");
        assert!(codec.octets() > 2 * 3600 * 8);
        assert_eq!(machine.snapshot(&mut SnapshotCodec::writing(&mut room[..1000])), Err(SnapshotError::NoRoom));
    });
    assert!(removed > 1.0 && edges > 0, "it was a cut: {removed} mm², {edges} edges");
    assert_eq!(raised, 0);
    assert_no_alloc(|| {
        for fault in &faults {
            raised += machine.step(None, &[], core::slice::from_ref(fault)).raised.len();
        }
        machine.raise(AlarmKind::CommandGap, 2.0, 1.0);
        for _ in 0..3000 {
            raised += machine.step(None, &[MachineCommand::SetHome { axis: Axis::C, counts: 5 }], &[]).raised.len();
        }
        machine.reset().expect("the axes rest");
        buffer.open(machine.setpoint());
    });
    assert!(raised >= 3, "{raised}");
}

/// A wheel is changed, a change is refused, and the new wheel runs up.
#[test]
fn a_change_of_the_wheel_does_not_allocate() {
    let mut description = cam_grinder();
    description.axes.iter_mut().for_each(|axis| axis.needs_homing = false);
    let wheel = description.wheel;
    let magazine = |name: &str, wheel| MagazineWheel { name: name.into(), wheel, setting_error_mm: 0.0 };
    let second = WheelDescription { new_radius_mm: 50.0, surface_speed_m_s: 60.0, ..wheel };
    let wheels = vec![magazine("roughing", wheel), magazine("finishing", second)];
    description.wheel_changer = Some(WheelChanger { change_s: 0.5, min_x_mm: 100.0, wheels, mounted: 0 });
    let mut machine = Machine::new(description.clone(), PersistentState::new(&description)).expect("valid");
    machine.load_lobe("I1", "LS1", 15.0, vec![23.0; 3600]).expect("a round blank");
    let (mut raised, mut running) = (0, false);
    assert_no_alloc(|| {
        for tick in 1..=4000 {
            let order = match tick {
                1 | 100 => Some(MachineCommand::ChangeWheel { wheel: 1 }),
                600 => Some(MachineCommand::WheelStart),
                _ => None,
            };
            let report = machine.step(None, order.as_slice(), &[]);
            raised += report.raised.len();
            running = report.io.wheel_running;
        }
        machine.count_part();
    });
    assert!(running && machine.description().mounted_wheel() == 1);
    assert_eq!(raised, 1, "the second order came into the change");
}

/// A lathe turns a bar, its insert loses its speed, and the alarm takes it off the part.
#[test]
fn a_tick_of_a_lathe_does_not_allocate() {
    let description = lathe();
    let mut machine = Machine::new(description.clone(), PersistentState::new(&description)).expect("valid");
    let grid = PartGrid { azimuths: 360, columns: 500, from_mm: 0.0, to_mm: 10.0 };
    let bar = TurnedPart::round("bar".into(), grid, 20.0).expect("a bar");
    machine.load_turned_part(bar, 0.0).expect("a lathe");
    let x_mm = f64::sqrt(20.0 * 20.0 - 14.0 * 14.0) + 8.0 - 0.2;
    machine.place([0, description.axes[1].scale.counts(x_mm), description.axes[2].scale.counts(5.0)]);
    let rest = machine.setpoint();
    let (mut volume, mut raised) = (0.0, 0);
    assert_no_alloc(|| {
        for tick in 1..=2000 {
            let t = f64::from(tick) * 1e-3;
            let mut setpoint = rest;
            setpoint.counts[0] = description.axes[0].scale.counts(10.0 * t * t);
            setpoint.velocity[0] = 20.0 * t;
            setpoint.acceleration[0] = 20.0;
            let stall = [Fault::WheelStall(true)];
            let report = machine.step(Some(&setpoint), &[], if tick == 1999 { &stall } else { &[] });
            volume += report.turned.volume_mm3;
            raised += report.raised.len();
        }
        for _ in 0..5000 {
            raised += machine.step(None, &[], &[]).raised.len();
        }
    });
    assert!(volume > 20.0 && raised >= 1, "{volume} mm³, {raised} alarms");
    assert!(machine.is_at_rest());
}
