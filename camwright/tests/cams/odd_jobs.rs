// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Jobs with implausible numbers, from a seed to a verdict: refused with a reason or planned, never a panic.

use crate::cams::{SplitMix64, lobe, random_law, reference_contour};
use camwright::cam::follower::Follower;
use camwright::cam::form_tolerance::FormTolerance;
use camwright::cam::motion_law::MotionLaw;
use camwright::cam::surface::Surface;
use camwright::cam::surface::cams::CamAlong;
use camwright::job::grinding::{
    BetweenLobes, HoldInCut, HomePosition, InfeedCourse, InfeedDirection, JobSpec, LobeSpec, ObstacleSpec, PassSpec,
    ProfileSpec, SpeedLaw, WheelPower,
};
use camwright::job::turning::{TurningJob, TurningSpeed};
use camwright::machine::fixture::Extent;
use camwright::machine::reference::{cam_grinder, lathe};
use camwright::math::units::rad_from_deg;
use camwright::planner::{plan_job, plan_turning};
use camwright::toolpath::insert_path::{InsertFeed, Passes};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

/// Outcome of a job.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum OddVerdict {
    /// Refused, in a sentence.
    Refused,
    /// Planned.
    Planned,
    /// A panic, or a refusal that names a defect.
    Wrong(String),
}

/// Numbers at which sums, quotients and casts go wrong.
const ODD: [f64; 24] = [
    0.0,
    -0.0,
    -1.0,
    1.0,
    1e-300,
    1e-15,
    1e-12,
    1e-9,
    1e-6,
    1e-3,
    0.07,
    0.999_999,
    6.3,
    359.0,
    1e3,
    1e4,
    1e6,
    1e9,
    1e15,
    9.3e18,
    1e300,
    f64::MAX,
    f64::INFINITY,
    f64::NAN,
];

fn odd(random: &mut SplitMix64, value: &mut f64) {
    *value = match random.next() % 4 {
        0 => *value * 10_f64.powf(random.within(-12.0, 12.0)),
        1 => -*value,
        _ => random.one_of(&ODD),
    };
}

fn odd_whole(random: &mut SplitMix64, value: &mut u32) {
    *value = random.one_of(&[0, 1, 2, 36, 1000, 100_000, u32::MAX - 1, u32::MAX]);
}

/// The grinding job of a seed.
fn ground(random: &mut SplitMix64) -> JobSpec {
    let law = if random.next().is_multiple_of(2) {
        lobe(MotionLaw::Polynomial345, 6.0, 62.0)
    } else {
        random_law(random, 1.5)
    };
    let profile = ProfileSpec {
        name: "cam".into(),
        lift: law,
        follower: Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 },
        base_radius_mm: 16.0,
        throw_mm: 0.0,
        is_bore: false,
    };
    let lobe = |name: &str, station: &str, phase_deg: f64| LobeSpec {
        name: name.into(),
        station: station.into(),
        phase_rad: rad_from_deg(phase_deg),
        profile: 0,
        width_mm: 14.0,
        tolerance: FormTolerance::default(),
        plunge: None,
        visit: None,
        axial: None,
    };
    let max_rad_s = 10.0;
    let speed = match random.next() % 5 {
        0 => SpeedLaw::TimeOptimal { max_rad_s },
        1 => SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 3.0, max_rad_s },
        2 => SpeedLaw::ConstantFootprintSpeed { footprint_speed_mm_s: 60.0, max_rad_s },
        _ => SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: 6.0 },
    };
    let course = random.one_of(&[InfeedCourse::PerAngle, InfeedCourse::PerTurn]);
    let direction = random.one_of(&[InfeedDirection::X, InfeedDirection::Normal]);
    let margin = BetweenLobes::TurnsOn { margin_s: 0.1 };
    let stations = cam_grinder().stations;
    JobSpec {
        profiles: vec![profile],
        lobes: vec![lobe("A", &stations[0].switch, 210.0), lobe("B", &stations[2].switch, 32.0)],
        blocks_per_turn: 3600,
        rapid_advance_mm: 40.0,
        stock_mm: 0.3,
        passes: vec![PassSpec {
            name: "grind".into(),
            total_infeed_mm: 0.36,
            infeed_per_block_mm: 0.000_05,
            infeed_of_turns_mm: Vec::new(),
            air_mm: 0.0,
            infeed_course: course,
            infeed_direction: direction,
            spark_out_turns: 2,
            spark_out_until_n: None,
            gauge_size: None,
            speed,
        }],
        retract_clearance_mm: 2.0,
        hold_in_cut: random.one_of(&[HoldInCut::Retract, HoldInCut::StopInfeed]),
        c_between_lobes: random.one_of(&[BetweenLobes::Stops, margin]),
        home: HomePosition { x_mm: 150.0, z_mm: 0.0 },
        ..JobSpec::without_lobes("odd", 150.0, 100.0)
    }
}

/// One to three numbers of a grinding job, replaced.
fn spoil(random: &mut SplitMix64, job: &mut JobSpec) {
    for _ in 0..1 + random.next() % 3 {
        let last = job.passes.len().saturating_sub(1);
        match random.next() % 20 {
            0 => odd(random, &mut job.rapid_advance_mm),
            1 => odd(random, &mut job.rapid_speed_mm_s),
            2 => odd(random, &mut job.stock_mm),
            3 => odd(random, &mut job.retract_clearance_mm),
            4 => odd(random, &mut job.clearance_mm),
            5 => odd(random, &mut job.home.x_mm),
            6 => odd(random, &mut job.home.z_mm),
            7 => odd(random, &mut job.lobes[0].phase_rad),
            8 => odd(random, &mut job.lobes[1].width_mm),
            9 => odd(random, &mut job.profiles[0].base_radius_mm),
            10 => odd(random, &mut job.passes[last].total_infeed_mm),
            11 => odd(random, &mut job.passes[last].infeed_per_block_mm),
            12 => odd_whole(random, &mut job.passes[last].spark_out_turns),
            13 => odd_whole(random, &mut job.blocks_per_turn),
            14 => {
                let mut radius_mm = 8.5;
                odd(random, &mut radius_mm);
                job.profiles[0].follower = Follower::Roller { radius_mm, offset_mm: 0.0 };
            }
            15 => {
                let mut power = WheelPower { max_w: 1e4, specific_energy_j_mm3: 40.0, rubbing_n_mm2: 0.2 };
                odd(random, &mut power.max_w);
                job.wheel_power = Some(power);
            }
            16 => {
                let mut extent = Extent { from_mm: 20.0, to_mm: 30.0, radius_mm: 15.0 };
                odd(random, &mut extent.radius_mm);
                job.obstacles.push(ObstacleSpec { name: "shoulder".into(), extent });
            }
            17 => {
                let mut stand_off_mm = 10.0;
                odd(random, &mut stand_off_mm);
                job.dry_run_mm = Some(stand_off_mm);
            }
            _ => match &mut job.passes[last].speed {
                SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: value }
                | SpeedLaw::TimeOptimal { max_rad_s: value }
                | SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: value, .. }
                | SpeedLaw::ConstantRadialRemovalRate { removal_rate_mm2_s: value, .. }
                | SpeedLaw::ConstantFootprintSpeed { footprint_speed_mm_s: value, .. } => odd(random, value),
                SpeedLaw::ConstantPower { .. } | SpeedLaw::ConstantTemperature { .. } => {}
            },
        }
    }
}

/// A turning job with one to three numbers replaced.
fn turned(random: &mut SplitMix64) -> Option<TurningJob> {
    let contour = reference_contour();
    let mut length_mm = 4.0;
    if random.next().is_multiple_of(8) {
        odd(random, &mut length_mm);
    }
    let surface = Surface::cams(&[CamAlong { contour: &contour, phase_rad: 0.5, from_mm: 0.0, to_mm: length_mm }]);
    let mut job = TurningJob {
        name: "odd".into(),
        surface: surface.ok()?,
        turned_mm: (length_mm, 0.0),
        bar_radius_mm: 23.2,
        part_zero_mm: 2.0,
        passes: Passes { stock_mm: 7.4, finish_mm: 0.4, deepest_mm: 3.5, rough_feed: InsertFeed::AlongZ(0.4) },
        feed: InsertFeed::AlongZ(0.4),
        angles: 360,
        speed: random.one_of(&[TurningSpeed::Fastest, TurningSpeed::Constant(6.0), TurningSpeed::Varied]),
        clearance_mm: 1.0,
        rapid_speed_mm_s: 200.0,
    };
    for _ in 0..1 + random.next() % 2 {
        let mut feed_mm = 0.4;
        match random.next() % 12 {
            0 => odd(random, &mut job.turned_mm.0),
            1 => odd(random, &mut job.turned_mm.1),
            2 => odd(random, &mut job.bar_radius_mm),
            3 => odd(random, &mut job.part_zero_mm),
            4 => odd(random, &mut job.passes.stock_mm),
            5 => odd(random, &mut job.passes.finish_mm),
            6 => odd(random, &mut job.passes.deepest_mm),
            7 => {
                odd(random, &mut feed_mm);
                job.feed = InsertFeed::AlongCurve(feed_mm);
            }
            8 => odd_whole(random, &mut job.angles),
            9 => {
                odd(random, &mut feed_mm);
                job.speed = TurningSpeed::Constant(feed_mm);
            }
            10 => odd(random, &mut job.clearance_mm),
            _ => odd(random, &mut job.rapid_speed_mm_s),
        }
    }
    // Long paths are a matter of time, not of numbers.
    let (InsertFeed::AlongZ(feed_mm) | InsertFeed::AlongCurve(feed_mm)) = job.feed;
    let (from_mm, to_mm) = job.turned_mm;
    let is_long = (from_mm - to_mm).abs() / feed_mm.min(0.4) * f64::from(job.angles) > 2e4;
    (!is_long || feed_mm <= 0.0).then_some(job)
}

/// One job, and how long it took.
#[allow(clippy::disallowed_methods, reason = "measures the planner, which itself sees no clock")]
pub(crate) fn judge_odd_job(seed: u64) -> (OddVerdict, Duration) {
    let began = Instant::now();
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        let mut random = SplitMix64(seed);
        if random.next().is_multiple_of(4) {
            let job = turned(&mut random)?;
            return Some(plan_turning(&job, &lathe(), None).map(drop).map_err(|error| error.to_string()));
        }
        let mut job = ground(&mut random);
        spoil(&mut random, &mut job);
        Some(plan_job(&job, &cam_grinder(), 60.0, None).map(drop).map_err(|error| error.to_string()))
    }));
    let verdict = match outcome {
        Err(panic) => {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
            OddVerdict::Wrong(format!("panic: {}", text.unwrap_or_default()))
        }
        Ok(Some(Err(text))) if text.contains("forward check") => OddVerdict::Wrong(text),
        Ok(Some(Ok(()))) => OddVerdict::Planned,
        Ok(Some(Err(_)) | None) => OddVerdict::Refused,
    };
    (verdict, began.elapsed())
}
