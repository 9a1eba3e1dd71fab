// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Required drives of a lathe for a part: the form error of drives, and the gain of X that keeps a tolerance.
#![allow(clippy::print_stdout, reason = "figures for the reader of --nocapture")]

use crate::solids;

use camwright::cam::surface::Surface;
use camwright::cam::surface::cams::CamAlong;
use camwright::job::turning::{TurningJob, TurningSpeed};
use camwright::machine::description::{Axis, DriveSettings, MachineDescription, Structure};
use camwright::machine::reference::{cam_grinder, lathe};
use camwright::math::units::{TURN_RAD, rad_s_from_rpm, um_from_mm};
use camwright::motion::plan::Plan;
use camwright::planner::plan_turning;
use camwright::simulation::lathe_drives::{
    AxisFlaw, DriveFlaw, Drives, DrivesResult, FeedForward, FlawAxes, GainSearch, MinimumGain, TurningDrives,
    TurningDrivesError,
};
use camwright::simulation::turned_part::PartGrid;
use camwright::toolpath::insert_path::{InsertFeed, Passes};

/// A short cam of 3 mm lift, turned in one pass.
fn cam() -> TurningJob {
    let contour = solids::raised_cosine(3.0);
    let surface = Surface::cams(&[CamAlong { contour: &contour, phase_rad: 0.5, from_mm: 0.0, to_mm: 4.0 }]);
    TurningJob {
        name: "cam".into(),
        surface: surface.expect("a cam"),
        turned_mm: (4.0, 0.0),
        bar_radius_mm: 23.2,
        part_zero_mm: 2.0,
        passes: Passes { stock_mm: 3.4, finish_mm: 3.4, deepest_mm: 3.4, rough_feed: InsertFeed::AlongZ(0.2) },
        feed: InsertFeed::AlongZ(0.2),
        angles: 360,
        speed: TurningSpeed::Fastest,
        clearance_mm: 1.0,
        rapid_speed_mm_s: 200.0,
    }
}

const GRID: PartGrid = PartGrid { azimuths: 360, columns: 201, from_mm: 0.0, to_mm: 4.0 };

/// Drives with all their flaws, and good ones beside them: figures of a lathe with a linear motor for X and a ball screw for Z.
fn machine() -> MachineDescription {
    let mut machine = lathe();
    let [c, x, z] = &mut machine.axes;
    let swings =
        |hertz: f64, mass_share: f64| Some(Structure { frequency_rad_s: hertz * TURN_RAD, damping: 0.05, mass_share });
    let drive = |kv_1_s: f64, loop_hz: f64| DriveSettings {
        kv_1_s,
        velocity_feed_forward: 0.99,
        acceleration_feed_forward: 0.97,
        velocity_loop_rad_s: Some(loop_hz * TURN_RAD),
        velocity_integral_s: Some(0.008),
        encoder_noise_counts: 0.3,
        ..DriveSettings::IDEAL
    };
    c.drive = DriveSettings {
        gain_error: 0.01,
        coulomb_friction: 0.6,
        viscous_friction: 0.02,
        structure: swings(180.0, 0.2),
        ..drive(200.0, 120.0)
    };
    c.good_drive = Some(DriveSettings {
        coulomb_friction: 0.6,
        friction_feed_forward: 0.9,
        velocity_feed_forward: 1.0,
        structure: swings(300.0, 0.2),
        ..drive(400.0, 250.0)
    });
    x.drive = DriveSettings {
        coulomb_friction: 15.0,
        viscous_friction: 0.06,
        structure: swings(220.0, 0.15),
        ..drive(250.0, 150.0)
    };
    x.good_drive = Some(DriveSettings {
        viscous_friction: 0.06,
        velocity_feed_forward: 1.0,
        acceleration_feed_forward: 1.0,
        structure: swings(600.0, 0.1),
        ..drive(600.0, 400.0)
    });
    z.drive = DriveSettings {
        velocity_feed_forward: 0.98,
        coulomb_friction: 80.0,
        viscous_friction: 0.6,
        backlash: 0.002,
        structure: swings(80.0, 0.2),
        ..drive(60.0, 60.0)
    };
    machine
}

fn plan(job: &TurningJob, machine: &MachineDescription) -> Plan {
    plan_turning(job, machine, None).unwrap_or_else(|error| panic!("{error}")).plan
}

fn check_finding(finding: &DrivesResult) {
    match finding {
        DrivesResult::Drives(drives, form) => println!(
            "{drives}: {:.2} to {:.2} um, {:.2} um beyond cusps",
            um_from_mm(form.lowest.deviation_mm),
            um_from_mm(form.highest.deviation_mm),
            um_from_mm(form.beyond_mm)
        ),
        DrivesResult::Gain(gain) => {
            println!("Kv of X {:.1}/s: {:?} um", gain.kv_1_s, gain.form.map(|form| um_from_mm(form.beyond_mm)));
        }
        DrivesResult::Flaw(flaw) => println!("without {}: {:.2} um", flaw.of, um_from_mm(flaw.form.beyond_mm)),
    }
}

const TOLERANCE_MM: f64 = 0.002;

fn search(feed_forward: FeedForward) -> GainSearch {
    GainSearch { tolerance_mm: TOLERANCE_MM, max_kv_1_s: 1e4, feed_forward }
}

fn at_rpm(rpm: f64) -> TurningJob {
    TurningJob { speed: TurningSpeed::Constant(rad_s_from_rpm(rpm)), ..cam() }
}

#[test]
fn drives_are_compared_from_ideal_ones_to_those_of_the_machine() {
    let (job, machine) = (at_rpm(300.0), machine());
    let study = TurningDrives::new(&job, &plan(&job, &machine), &machine, GRID).expect("a study");
    let mut seen = Vec::new();
    let found = study.compare(|one| {
        check_finding(one);
        seen.push(*one);
    });
    let found = found.expect("all of them turn the part");
    // Z has no good drive.
    let names: Vec<Drives> = found.iter().map(|(drives, _)| *drives).collect();
    let good = [Drives::GoodOn(Axis::X), Drives::GoodOn(Axis::C), Drives::Good];
    assert_eq!(names, [&[Drives::Ideal, Drives::Own][..], &good].concat());
    assert_eq!(seen, found.iter().map(|(drives, form)| DrivesResult::Drives(*drives, *form)).collect::<Vec<_>>());
    let of = |drives: Drives| found.iter().find(|(found, _)| *found == drives).expect("it was looked at").1;
    let ideal = of(Drives::Ideal);
    assert!(ideal.beyond_mm < 1e-12 && ideal.lowest.deviation_mm > -5e-5, "{ideal:?}");
    assert!(ideal.highest.deviation_mm < study.cusp_mm() + 5e-5, "{ideal:?}");
    for (drives, form) in &found[1..] {
        // What is beyond is below the design, or above the cusps of the feed.
        let outside = (-form.lowest.deviation_mm).max(form.highest.deviation_mm - study.cusp_mm());
        assert!(form.beyond_mm > 1e-5 && form.beyond_mm <= outside + 5e-5, "{drives}: {form:?}");
        assert!(of(Drives::Own).beyond_mm < 0.01);
    }
    assert!(of(Drives::Good).beyond_mm < 0.2 * of(Drives::Own).beyond_mm);
}

/// At 150 1/min the lag of X is most of what is left: the gain that is found keeps the tolerance, and a tenth less does not.
#[test]
fn the_lowest_gain_keeps_the_tolerance_and_a_tenth_less_does_not() {
    let (job, machine) = (at_rpm(150.0), machine());
    let study = TurningDrives::new(&job, &plan(&job, &machine), &machine, GRID).expect("a study");
    let own = machine.axis(Axis::X).drive;
    for feed_forward in [FeedForward::AsItIs, FeedForward::Whole] {
        let found = study.minimum_gain(&search(feed_forward), check_finding).expect("a search");
        let MinimumGain::Found { least, below, tried } = found else { panic!("{feed_forward:?}: {found:?}") };
        println!("{feed_forward:?}: Kv {:.0}/s, loop {:?} rad/s", least.kv_1_s, least.velocity_loop_rad_s);
        let below = below.expect("an eighth of the gain is not enough");
        assert!(least.keeps(TOLERANCE_MM) && !below.keeps(TOLERANCE_MM));
        assert!(below.kv_1_s < least.kv_1_s && below.kv_1_s * 1.05 >= least.kv_1_s);
        // Up to there more gain leaves less.
        let beyond_mm: Vec<f64> = tried.iter().map(|gain| gain.form.expect("no alarm").beyond_mm).collect();
        let to = tried.iter().position(|gain| gain == &least).expect("it was tried");
        assert!(beyond_mm[..=to].windows(2).all(|pair| pair[1] < pair[0]), "{beyond_mm:?}");
        let with = |times: f64| {
            let mut machine = machine.clone();
            let drive = &mut machine.axes[Axis::X.index()].drive;
            drive.kv_1_s = times * least.kv_1_s;
            drive.velocity_loop_rad_s = least.velocity_loop_rad_s.map(|loop_rad_s| times * loop_rad_s);
            if feed_forward == FeedForward::Whole {
                (drive.velocity_feed_forward, drive.acceleration_feed_forward) = (1.0, 1.0);
            }
            study.form(&machine).expect("no alarm").beyond_mm
        };
        assert!((with(1.0) - least.form.expect("no alarm").beyond_mm).abs() < 1e-9);
        assert!(with(0.9) > TOLERANCE_MM, "{}", with(0.9));
        let ratio = least.velocity_loop_rad_s.expect("a loop") / own.velocity_loop_rad_s.expect("a loop");
        assert!((ratio - least.kv_1_s / own.kv_1_s).abs() < 1e-12);
    }
}

/// At 300 1/min no gain of X keeps the tolerance, because C alone exceeds it: the result says so, and the lag of C agrees.
#[test]
fn where_no_gain_suffices_the_remaining_flaw_is_reported() {
    let (job, machine) = (at_rpm(300.0), machine());
    let study = TurningDrives::new(&job, &plan(&job, &machine), &machine, GRID).expect("a study");
    let found = study.minimum_gain(&search(FeedForward::Whole), check_finding).expect("a search");
    let MinimumGain::NotFound { best, max_kv_1_s, flaws, tried } = found else { panic!("{found:?}") };
    // The servo step of 0.25 ms bounds the velocity loop.
    let drive = machine.axis(Axis::X).drive;
    let max = drive.kv_1_s * 4000.0 / drive.velocity_loop_rad_s.expect("a loop");
    assert!(max_kv_1_s <= max && max_kv_1_s > 0.99 * max, "{max_kv_1_s} {max}");
    let best_mm = best.form.expect("no alarm").beyond_mm;
    assert!(best_mm > TOLERANCE_MM && tried.iter().all(|gain| gain.form.is_none_or(|form| form.beyond_mm >= best_mm)));
    assert!(flaws.windows(2).all(|pair| pair[0].form.beyond_mm <= pair[1].form.beyond_mm));
    let of =
        |axes, flaw| flaws.iter().find(|found| found.of == AxisFlaw { axes, flaw }).map(|found| found.form.beyond_mm);
    let of_one = |axis, flaw| of(FlawAxes::One(axis), flaw);
    assert!(of_one(Axis::Z, DriveFlaw::Backlash).is_some() && of_one(Axis::X, DriveFlaw::Backlash).is_none());
    assert!(of_one(Axis::X, DriveFlaw::FeedForward).is_none(), "it is whole");
    // C lags by (1 − ff) ω/Kv: a cam that is read so much later is off by up to h/2 of it, but for what the slope of the contour takes.
    let c = machine.axis(Axis::C).drive;
    let lag_rad = (1.0 - c.velocity_feed_forward) * rad_s_from_rpm(300.0) / (c.kv_1_s * (1.0 + c.gain_error));
    let alone_mm = of(FlawAxes::AllBut(Axis::C), DriveFlaw::Everything).expect("C is not ideal");
    println!("C alone: {:.2} um, its lag {:.2} um", um_from_mm(alone_mm), um_from_mm(1.5 * lag_rad));
    assert!((alone_mm / (1.5 * lag_rad) - 1.0).abs() < 0.06 && alone_mm > TOLERANCE_MM, "{alone_mm}");
}

#[test]
fn a_machine_that_stops_with_an_alarm_does_not_keep_the_tolerance() {
    let (job, mut machine) = (at_rpm(150.0), machine());
    // At rapid speed X lags by 1 % of 200 mm/s over its gain.
    let own = &mut machine.axes[Axis::X.index()];
    (own.max_following_error, own.min_following_error) = (0.05, 0.05);
    let study = TurningDrives::new(&job, &plan(&job, &machine), &machine, GRID).expect("a study");
    let found = study.minimum_gain(&search(FeedForward::AsItIs), check_finding).expect("a search");
    let MinimumGain::Found { tried, .. } = found else { panic!("{found:?}") };
    assert!(tried[0].form.is_none() && !tried[0].keeps(f64::INFINITY), "{:?}", tried[0]);
}

#[test]
fn what_cannot_be_looked_for_is_refused() {
    let (job, machine) = (at_rpm(600.0 * 0.9), machine());
    let plan = plan(&job, &machine);
    let grinder = TurningDrives::new(&job, &plan, &cam_grinder(), GRID).map(|_| ());
    assert_eq!(grinder, Err(TurningDrivesError::NotALathe));
    let coarse = TurningDrives::new(&job, &plan, &machine, PartGrid { azimuths: 2, ..GRID }).map(|_| ());
    assert!(matches!(coarse, Err(TurningDrivesError::Part(_))), "{coarse:?}");
    let study = TurningDrives::new(&job, &plan, &machine, GRID).expect("a study");
    let good = search(FeedForward::AsItIs);
    for bad in [
        GainSearch { tolerance_mm: 0.0, ..good },
        GainSearch { tolerance_mm: f64::NAN, ..good },
        GainSearch { max_kv_1_s: 31.0, ..good },
        GainSearch { max_kv_1_s: f64::INFINITY, ..good },
    ] {
        let error = study.minimum_gain(&bad, check_finding).expect_err("refused");
        assert!(matches!(error, TurningDrivesError::OutOfRange { .. }), "{error}");
    }
    let mut broken = machine.clone();
    broken.axes[Axis::X.index()].drive.kv_1_s = -1.0;
    assert!(matches!(study.form(&broken), Err(TurningDrivesError::Description(_))));
    broken.axes[Axis::X.index()].drive = DriveSettings { kv_1_s: 2.0, ..machine.axis(Axis::X).drive };
    assert!(matches!(study.form(&broken), Err(TurningDrivesError::Simulation(_))), "its following error is too large");
}
