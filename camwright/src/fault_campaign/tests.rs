use super::*;
use crate::cycle::plan_job;
use crate::cycle::tests::{contact, job as four_lobes, machine as grinder};
use crate::interpolator::Motion;
use crate::machine::Machine;
use crate::machine::description::{DriveSettings, GaugeDescription, GaugeKind};
use crate::machine::state::LastingState;
use alloc::sync::Arc;

/// Two lobes of a short job on a machine that gives way, with ordinary drives and a gauge.
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
    let mut machine = Machine::new(description.clone(), LastingState::new(&description)).expect("a machine");
    for design in &designs {
        let radii = (0..3600_u32).map(|i| design.radius_at(f64::from(i) * TURN_RAD / 3600.0) + job.stock_mm).collect();
        machine.load_lobe(&design.name, &design.station, design.width_mm, radii).expect("a raw lobe");
    }
    let motion = Prepared::new(Motion::Plan(Arc::new(planned.plan.clone())), &description).expect("a motion");
    let cell = Cell::new(machine);
    let (healthy, _) =
        Campaign::new(&planned.plan, &designs, motion.clone(), cell.clone(), &[]).expect("the job without a fault");
    let moments = seeded_moments(seed, 4, healthy.struck_within());
    let (campaign, frames) = Campaign::new(&planned.plan, &designs, motion, cell, &moments).expect("the same again");
    assert_eq!(frames.len(), 4);
    let mut failures = Vec::new();
    for (round, frame) in frames.iter().enumerate() {
        for case in every_fault(&description, round % 2) {
            match campaign.strike(frame, &case) {
                Err(failure) => failures.push(format!("{} at tick {}: {failure}", case.name, frame.tick)),
                Ok(found) if found.bound_mm > 5.0 => {
                    failures
                        .push(format!("{} at tick {}: a bound that says nothing: {found:?}", case.name, frame.tick));
                }
                Ok(_) => {}
            }
        }
    }
    assert!(failures.is_empty(), "seed {seed}, healthy {:.6} mm: {failures:#?}", campaign.healthy_mm);
}
