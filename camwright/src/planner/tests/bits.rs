// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The same bits whatever the compiler makes of it: one fingerprint of a whole job, which debug, release and every machine
//! have to reproduce. Run at other optimisation levels by `.ci/run`.

use super::*;
use crate::interpolator::MotionOutcome;
use crate::machine::description::{Structure, ThermalDescription};
use crate::simulation::workpiece::Lobe;

/// A change of it is a change of what machines do, and belongs into the changelog.
const FINGERPRINT: u64 = 0x1902_603c_3820_bf3b;

/// FNV-1a by Fowler, Noll and Vo: sufficient to distinguish runs.
struct Fingerprint(u64);

impl Fingerprint {
    fn add(&mut self, octets: [u8; 8]) {
        for octet in octets {
            self.0 = (self.0 ^ u64::from(octet)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// Two lobes on a machine with every effect.
fn real_job() -> (JobSpec, MachineDescription, PlannedJob) {
    let mut job = job();
    job.lobes.truncate(2);
    job.passes[0].total_infeed_mm = 0.018;
    job.passes[0].infeed_per_block_mm = 0.000_005;
    job.stock_mm = 0.01;
    let ordinary = DriveSettings {
        gain_error: 0.01,
        velocity_feed_forward: 0.98,
        friction_feed_forward: 0.2,
        velocity_loop_rad_s: Some(600.0),
        velocity_integral_s: Some(0.01),
        max_force: Some(6000.0),
        coulomb_friction: 1.0,
        viscous_friction: 0.05,
        backlash: 2e-6,
        structure: Some(Structure { frequency_rad_s: 800.0, damping: 0.04, mass_share: 0.2 }),
        encoder_step_counts: 1.0,
        encoder_noise_counts: 0.3,
        ..DriveSettings::IDEAL
    };
    let thermal = ThermalDescription { growth_mm: 0.008, time_constant_s: 1200.0, start_share: 0.0 };
    let mut description =
        MachineDescription { contact: Some(contact()), thermal: Some(thermal), ..machine().with_drives(ordinary) };
    description.wheel.unbalance_mm = 1e-4;
    let planned = plan_job(&job, &description, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
    (job, description, planned)
}

#[test]
fn every_setpoint_every_actual_position_and_every_radius_has_the_same_bits_everywhere() {
    let (job, description, planned) = real_job();
    let mut fingerprint = Fingerprint(0xcbf2_9ce4_8422_2325);
    let (simulated, machine) = ground(&job, &planned, planned.plan.clone(), &description, |setpoint, report| {
        for axis in 0..3 {
            fingerprint.add(setpoint.counts[axis].to_le_bytes());
            fingerprint.add(setpoint.velocity[axis].to_bits().to_le_bytes());
            fingerprint.add(report.axes[axis].counts.to_le_bytes());
            fingerprint.add(report.axes[axis].velocity.to_bits().to_le_bytes());
            fingerprint.add(report.axes[axis].effort.to_bits().to_le_bytes());
        }
    });
    for radius_mm in machine.part().lobes().iter().flat_map(Lobe::radii_mm) {
        fingerprint.add(radius_mm.to_bits().to_le_bytes());
    }
    assert!(simulated.last_tick - simulated.first_tick > 10_000, "a real job: {simulated:?}");
    assert_eq!(fingerprint.0, FINGERPRINT, "other bits than before: {:#018x}", fingerprint.0);
}

#[test]
fn the_stream_between_interpolator_and_machine_changes_no_bit() {
    let (job, description, planned) = real_job();
    let motion = Prepared::new(Motion::Plan(Arc::new(planned.plan.clone())), &description).expect("a plan");
    let machine = loaded(&job, &planned, &description);
    let (mut streamed, mut direct) = (ClosedLoop::new(machine.clone()), ClosedLoop::direct(machine));
    for closed_loop in [&mut streamed, &mut direct] {
        closed_loop.start(Box::new(motion.clone())).expect("it rests");
    }
    while direct.is_running() || !direct.machine().is_at_rest() {
        assert_eq!(streamed.step(&[]), direct.step(&[]));
    }
    assert!(!streamed.is_running());
    assert_eq!(
        (streamed.outcome(), direct.outcome()),
        (Some(MotionOutcome::Completed), Some(MotionOutcome::Completed))
    );
    assert!(streamed.machine() == direct.machine(), "the machines differ");
}
