// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Random grinding jobs: cams, eccentrics and journals, rough and finish, with C stopping or turning on, held, slowed and cancelled.

use super::JobEnd;
use super::drive::{drive, requests};
use super::sweep::Touch;
use crate::cams::{SplitMix64, journal, lobe_segments, program};
use camwright::cam::follower::Follower;
use camwright::cam::form_tolerance::FormTolerance;
use camwright::cam::lift::LiftLaw;
use camwright::cam::motion_law::MotionLaw;
use camwright::interpolator::Interpolator;
use camwright::job::grinding::{
    BetweenLobes, HoldInCut, HomePosition, InfeedCourse, InfeedDirection, JobSpec, LobeSpec, PassSpec, ProfileSpec,
    SpeedLaw,
};
use camwright::job::raw_part::RawPart;
use camwright::machine::description::{DriveSettings, MachineDescription};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::reference::cam_grinder;
use camwright::math::units::{TURN_RAD, rad_s_from_rpm};
use camwright::motion::plan::SegmentKind;
use camwright::planner::{PlanStart, plan_job};
use camwright::simulation::Machine;

/// Depth that is nothing (mm): a count of X, a count of C on a flank of 30 mm/rad, the polygon, and the path between its knots. 5 nm, 26 nm,
/// 10 nm and at most 10 nm.
const NOTHING_MM: f64 = 1e-4;

fn profile(random: &mut SplitMix64) -> ProfileSpec {
    const LAWS: [MotionLaw; 4] =
        [MotionLaw::Polynomial4567, MotionLaw::Polynomial345, MotionLaw::ModifiedSine, MotionLaw::Cycloidal];
    let base_radius_mm = random.within(14.0, 22.0);
    match random.next() % 5 {
        0 => journal(base_radius_mm),
        1 => {
            let off_mm = random.within(0.5, 5.0);
            let lift = LiftLaw::eccentric_round(off_mm, base_radius_mm + off_mm, random.within(0.0, TURN_RAD));
            ProfileSpec { name: "eccentric".into(), lift: lift.expect("a lift"), ..journal(base_radius_mm) }
        }
        kind => {
            let law = random.one_of(&LAWS);
            let segments = lobe_segments(law, random.within(1.0, 8.0), random.within(55.0, 85.0));
            let flat = kind == 2;
            let radius_mm = random.within(5.0, 15.0);
            let offset_mm = if random.next().is_multiple_of(2) { 0.0 } else { random.within(-3.0, 3.0) };
            ProfileSpec {
                name: "cam".into(),
                lift: program(random.within(0.5, 3.0), &segments),
                follower: if flat { Follower::Flat } else { Follower::Roller { radius_mm, offset_mm } },
                base_radius_mm,
                throw_mm: 0.0,
                is_bore: false,
            }
        }
    }
}

fn speed(random: &mut SplitMix64) -> SpeedLaw {
    let max_rad_s = rad_s_from_rpm(random.within(60.0, 150.0));
    match random.next() % 4 {
        0 => SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: random.within(2.0, 20.0), max_rad_s },
        1 => SpeedLaw::ConstantFootprintSpeed { footprint_speed_mm_s: random.within(40.0, 150.0), max_rad_s },
        _ => SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: rad_s_from_rpm(random.within(15.0, 90.0)) },
    }
}

fn pass(random: &mut SplitMix64, name: &str, along: InfeedDirection, course: InfeedCourse) -> PassSpec {
    let infeed_per_block_mm = random.one_of(&[0.000_005, 0.000_025, 0.000_05]);
    PassSpec {
        name: name.into(),
        total_infeed_mm: infeed_per_block_mm * 3600.0 * (1 + random.next() % 3) as f64,
        infeed_per_block_mm,
        infeed_of_turns_mm: Vec::new(),
        air_mm: 0.0,
        infeed_course: course,
        infeed_direction: along,
        spark_out_turns: 1 + u32::try_from(random.next() % 2).expect("0 or 1"),
        spark_out_until_n: None,
        gauge_size: None,
        speed: speed(random),
    }
}

pub(crate) fn job(random: &mut SplitMix64) -> JobSpec {
    let profiles: Vec<ProfileSpec> = (0..2).map(|_| profile(random)).collect();
    let count = 1 + random.next() % 3;
    let lobes = (1..=count).map(|number| LobeSpec {
        name: format!("L{number}"),
        station: format!("LS{number}"),
        phase_rad: random.within(0.0, TURN_RAD),
        profile: usize::try_from(random.next() % 2).expect("0 or 1"),
        width_mm: 15.0,
        tolerance: FormTolerance::default(),
        plunge: None,
        visit: None,
        axial: None,
    });
    let lobes = lobes.collect();
    let along = random.one_of(&[InfeedDirection::X, InfeedDirection::X, InfeedDirection::Normal]);
    let course = random.one_of(&[InfeedCourse::PerAngle, InfeedCourse::PerTurn]);
    let mut passes = vec![pass(random, "finish", along, course)];
    if random.next().is_multiple_of(2) {
        passes.insert(0, pass(random, "rough", along, course));
    }
    let turns_on = random.next().is_multiple_of(3);
    let infeed_mm: f64 = passes.iter().map(|pass| pass.total_infeed_mm).sum();
    JobSpec {
        name: "random".into(),
        profiles,
        lobes,
        blocks_per_turn: 3600,
        rapid_advance_mm: random.within(25.0, 40.0),
        rapid_speed_mm_s: random.within(30.0, 200.0),
        stock_mm: random.within(0.3, 0.8) * infeed_mm,
        passes,
        retract_clearance_mm: random.within(0.2, 3.0),
        hold_in_cut: random.one_of(&[HoldInCut::Retract, HoldInCut::StopInfeed]),
        speed_variation: None,
        wheel_power: None,
        c_between_lobes: if turns_on { BetweenLobes::TurnsOn { margin_s: 0.05 } } else { BetweenLobes::Stops },
        rotary_indexing: !turns_on && random.next().is_multiple_of(4),
        home: HomePosition { x_mm: 150.0, z_mm: 0.0 },
        dressing: None,
        obstacles: Vec::new(),
        clearance_mm: 1.0,
        wheels: Vec::new(),
        raw_part: RawPart::default(),
        correction: None,
        compensation: None,
        identification: None,
        dry_run_mm: None,
        part_phase_rad: 0.0,
        measure_stock: None,
        part_support: None,
    }
}

pub(crate) fn machine(random: &mut SplitMix64) -> MachineDescription {
    let mut machine = cam_grinder().with_drives(DriveSettings::IDEAL);
    machine.rotation_sense = random.one_of(&[1, 1, -1]);
    let times = 10_f64.powf(random.within(-0.4, 0.3));
    let x = &mut machine.axes[1].limits;
    (x.acceleration, x.jerk) = (times * x.acceleration, times * x.jerk);
    machine
}

/// One job, from its seed.
pub(crate) fn judge(seed: u64) -> JobEnd {
    let mut random = SplitMix64(seed);
    let (job, machine, wheel_mm) = (job(&mut random), machine(&mut random), random.within(45.0, 60.0));
    let mut simulated = Machine::new(machine.clone(), PersistentState::new(&machine)).expect("a machine");
    let start = PlanStart { counts: simulated.setpoint().counts, c_homed: false };
    let planned = match plan_job(&job, &machine, wheel_mm, Some(start)) {
        Ok(planned) => planned,
        Err(error) => return JobEnd::Refused(error.to_string()),
    };
    let touches = planned.lobes.iter().map(|lobe| {
        let contour = &lobe.design.contour;
        let station = machine.station(&lobe.design.station).expect("it is there").position_mm;
        let phase_rad = lobe.design.phase_rad;
        (Touch::new(contour, wheel_mm, 0.0), Touch::new(contour, wheel_mm, job.stock_mm), station, phase_rad)
    });
    let touches: Vec<_> = touches.collect();
    let reach_mm = 0.5 * (machine.wheel.width_mm + job.lobes[0].width_mm);
    let sense = f64::from(machine.rotation_sense.signum());
    let ticks: u64 = planned.plan.segments.iter().map(|segment| segment.ticks).sum();
    let requests = requests(&mut random, ticks);
    let mut interpolator = Interpolator::new(&machine);
    let (mut deepest_mm, mut fault) = (f64::NEG_INFINITY, None);
    let mut is_cut = vec![false; touches.len()];
    let outcome = drive(&planned.plan, &mut interpolator, &mut simulated, &requests, |tick| {
        let cuts = matches!(tick.segment.kind, SegmentKind::Cut(_));
        for (lobe, (design, raw, station_mm, phase_rad)) in touches.iter().enumerate() {
            if (tick.z_mm - station_mm).abs() >= reach_mm {
                continue;
            }
            is_cut[lobe] |= cuts;
            let min =
                |touch: &Touch| tick.c_rad.map_or_else(|| touch.highest(), |c_rad| touch.at(sense * c_rad - phase_rad));
            let depth_mm = min(design) - tick.x_mm;
            deepest_mm = deepest_mm.max(depth_mm);
            let in_raw_mm = if is_cut[lobe] { f64::NEG_INFINITY } else { min(raw) - tick.x_mm };
            if fault.is_none() && (depth_mm > NOTHING_MM || in_raw_mm > NOTHING_MM) {
                fault = Some(format!(
                    "tick {}, {}: {:.3} um below the design of {}, {:.3} um in the raw part; requests {requests:?}",
                    tick.tick,
                    tick.segment.label,
                    1e3 * depth_mm,
                    job.lobes[lobe].name,
                    1e3 * in_raw_mm
                ));
            }
        }
    });
    match (outcome, fault) {
        (_, Some(fault)) => JobEnd::Gouge(fault),
        (Err(error), None) => JobEnd::Gouge(format!("{error}; requests {requests:?}")),
        (Ok(_), None) => JobEnd::Clean { deepest_mm },
    }
}
