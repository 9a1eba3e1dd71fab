// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Seeded random programs: what is planned keeps its limits and its tolerance, and what is refused is refused for an axis.

use super::ideal;
use super::shop::{STATION_MM, blocks, plan, setup};
use crate::cams::SplitMix64;
use camwright::machine::reference::lathe;
use camwright::math::units::rad_from_deg;
use camwright::planner::ProgramPlanError;
use camwright::planner::program_motion::{ProgramMotionFault, ProgramSetup};
use std::fmt::Write;

/// Feeds of one run: C (deg), X of the wheel's centre, Z (mm), time (s).
fn random_feeds(random: &mut SplitMix64) -> Vec<[f64; 4]> {
    let hurry = random.one_of(&[0.006, 0.012, 0.05, 0.3]);
    let (mut c, mut x, mut z) = (0.0, 85.0, 20.0);
    (0..3 + random.next() % 40)
        .map(|_| {
            let turned = random.one_of(&[0.01, 0.5, 3.0, 40.0]) * random.within(0.5, 1.0);
            let per_deg = random.one_of(&[0.0, 0.01, 0.05]);
            c += turned;
            x += turned * per_deg * random.within(-1.0, 1.0);
            z += turned * random.one_of(&[0.0, 0.0, 0.01]) * random.within(-1.0, 1.0);
            x = f64::clamp(x, 78.0, 92.0);
            z = f64::clamp(z, 16.0, 24.0);
            let rounded = |value: f64| (value * 1e4).round() / 1e4;
            [rounded(c), rounded(x), rounded(z), turned * hurry * random.within(0.3, 1.0)]
        })
        .collect()
}

fn text(feeds: &[[f64; 4]], tolerance_mm: f64) -> String {
    let mut text = format!("G0 X90 Z20 C0\nG0 X85\nG93 G64 P{tolerance_mm}\n");
    for [c, x, z, time_s] in feeds {
        writeln!(text, "G1 X{x:.4} Z{z:.4} C{c:.4} F{:.6}", 60.0 / time_s).expect("a string");
    }
    text + "G0 X95"
}

#[test]
fn what_is_planned_keeps_its_limits_and_its_tolerance_and_what_is_refused_names_its_axis() {
    let machine = ideal();
    let (mut planned, mut refused) = (0, 0);
    for seed in 0..150 {
        let mut random = SplitMix64(seed);
        let feeds = random_feeds(&mut random);
        let tolerance_mm = random.one_of(&[0.002, 0.02, 0.2]);
        let read = blocks(&text(&feeds, tolerance_mm));
        // The bounds are above what the forward check finds by differences, so that never refuses what they allow.
        let found = match plan(&read, setup(), &machine) {
            Ok(found) => found,
            Err(ProgramPlanError::Motion(error)) => {
                let is_axis =
                    matches!(error.fault, ProgramMotionFault::Limit { .. } | ProgramMotionFault::TooFast { .. });
                assert!(is_axis && error.line > 4, "seed {seed}: {error}");
                refused += 1;
                continue;
            }
            Err(other) => panic!("seed {seed}: {other}"),
        };
        planned += 1;
        let run = &found.runs[0].1;
        let laws = &run.laws;
        assert!(laws.rounding_mm <= tolerance_mm && laws.max_used <= 1.0, "seed {seed}: {laws:?}");
        let time_s: f64 = feeds.iter().map(|feed| feed[3]).sum();
        assert!((laws.duration_s() - time_s - 2.0 * laws.ramp_s).abs() < 1e-6 * (1.0 + time_s), "seed {seed}");
        for [c, x, z, _] in &feeds {
            let c = rad_from_deg(*c);
            let off = [laws.path.sample(c).value + 60.0 - x, laws.advance.sample(c).value - STATION_MM + 20.0 - z];
            assert!(off[0].hypot(off[1]) <= laws.rounding_mm + 1e-9, "seed {seed}, C {c}: {off:?}");
        }
        let steps = 2000;
        let turned = |step: u32| laws.speed.sample(laws.duration_s() * f64::from(step) / f64::from(steps)).value;
        assert!((0..steps).all(|step| turned(step + 1) > turned(step) - 1e-12), "seed {seed}: C turns back");
    }
    println!("{planned} random programs planned, {refused} refused");
    assert!(planned > 30 && refused > 30, "{planned} {refused}");
}

/// On a lathe X is the insert's centre, and there are no stations.
#[test]
fn on_a_lathe_x_is_what_the_program_says() {
    let read = blocks(&text(&[[90.0, 80.0, 20.0, 1.0], [450.0, 80.0, 19.0, 3.0], [540.0, 85.0, 19.0, 1.0]], 0.05));
    let planned = plan(&read, ProgramSetup { z_zero_mm: 3.0, ..setup() }, &lathe()).unwrap_or_else(|e| panic!("{e}"));
    let laws = &planned.runs[0].1.laws;
    assert!((laws.path.sample(0.0).value - 85.0).abs() < 1e-9 && (laws.advance.sample(0.0).value - 23.0).abs() < 1e-9);
    assert!((laws.advance.sample(laws.angle_rad()).value - 22.0).abs() < 1e-9);
}
