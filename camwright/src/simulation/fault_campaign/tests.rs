// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use crate::interpolator::Motion;
use crate::machine::description::{DriveSettings, GaugeDescription, GaugeKind, Structure};
use crate::machine::persistent_state::PersistentState;
use crate::math::units::rad_from_deg;
use crate::planner::plan_job;
use crate::planner::tests::{contact, job as four_lobes, machine as grinder};
use crate::simulation::Machine;
use alloc::format;
use alloc::sync::Arc;

/// The drives of C and X as of `cam_grinder`: motors with a limit, and a structure that swings on when they fail.
fn motor(inertia: f64, max_force: f64, coulomb_friction: f64, frequency_hz: f64) -> DriveSettings {
    DriveSettings {
        velocity_feed_forward: 0.99,
        acceleration_feed_forward: 0.97,
        velocity_loop_rad_s: Some(120.0 * TURN_RAD),
        velocity_integral_s: Some(0.01),
        max_force: Some(max_force),
        coulomb_friction,
        viscous_friction: 0.001 * inertia,
        structure: Some(Structure { frequency_rad_s: frequency_hz * TURN_RAD, damping: 0.04, mass_share: 0.2 }),
        encoder_noise_counts: 0.3,
        ..DriveSettings::IDEAL
    }
}

/// Two lobes of a short job on a machine that deflects, with ordinary drives and a gauge.
#[test]
fn every_fault_ends_at_rest_with_an_alarm_off_the_part_and_within_its_bound() {
    let seed = 7_u64;
    let mut job = four_lobes();
    job.lobes.truncate(2);
    job.passes[0].total_infeed_mm = 0.036;
    job.passes[0].infeed_per_block_mm = 0.000_005;
    job.stock_mm = 0.03;
    let ordinary =
        DriveSettings { velocity_feed_forward: 0.98, velocity_loop_rad_s: Some(600.0), ..DriveSettings::IDEAL };
    let mut description = grinder().with_drives(ordinary);
    description.axes[0].drive = motor(description.axes[0].inertia, 80.0, 1.0, 140.0);
    description.axes[1].drive = motor(description.axes[1].inertia, 6000.0, 20.0, 150.0);
    description.contact = Some(contact());
    description.axes[0].power_up_position = rad_from_deg(217.3);
    description.gauge = Some(GaugeDescription {
        kind: GaugeKind::Diameter,
        behind_wheel_rad: rad_from_deg(90.0),
        second_behind_wheel_rad: None,
        resolution_mm: 1e-4,
        noise_mm: 2e-4,
        bandwidth_rad_s: None,
        seed: 1,
    });
    for axis in &mut description.axes {
        axis.min_following_error = 0.05 * axis.max_following_error;
    }
    let planned = plan_job(&job, &description, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
    let designs: Vec<&LobeDesign> = planned.lobes.iter().map(|lobe| &lobe.design).collect();
    let mut machine = Machine::new(description.clone(), PersistentState::new(&description)).expect("a machine");
    for design in &designs {
        let radii = (0..3600_u32).map(|i| design.radius_at(f64::from(i) * TURN_RAD / 3600.0) + job.stock_mm).collect();
        machine.load_lobe(&design.name, &design.station, design.width_mm, radii).expect("a raw lobe");
    }
    let motion = Prepared::new(Motion::Plan(Arc::new(planned.plan.clone())), &description).expect("a motion");
    let cell = ClosedLoop::new(machine);
    let (healthy, _) =
        Campaign::new(&planned.plan, &designs, motion.clone(), cell.clone(), &[]).expect("the job without a fault");
    let moments = seeded_moments(seed, 4, healthy.struck_within());
    let (campaign, frames) = Campaign::new(&planned.plan, &designs, motion, cell, &moments).expect("the same again");
    assert_eq!(frames.len(), 4);
    let (mut failures, mut pushed_mm) = (Vec::new(), 0.0_f64);
    for frame in &frames {
        for case in every_fault(&description, frame.station) {
            match campaign.run_case(frame, &case) {
                Err(failure) => failures.push(format!("{} at tick {}: {failure}", case.name, frame.tick)),
                Ok(found) if found.bound_mm > 5.0 => {
                    failures
                        .push(format!("{} at tick {}: a bound that says nothing: {found:?}", case.name, frame.tick));
                }
                Ok(found) if matches!(case.fault, Fault::EncoderOffset { axis: Axis::X, .. }) => {
                    pushed_mm = pushed_mm.max(found.deepest_mm);
                }
                Ok(_) => {}
            }
        }
    }
    assert!(failures.is_empty(), "seed {seed}, healthy {:.6} mm: {failures:#?}", campaign.healthy_mm);
    // What its drive does for a tick to an X that it takes for too far out, and how its structure swings on, is more than lag.
    assert!(pushed_mm > campaign.healthy_mm + 0.02, "an encoder's step was not struck in the cut: {pushed_mm} mm");
}
