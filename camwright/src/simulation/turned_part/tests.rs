// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Closed forms of what a round insert leaves, and a slow look at every moment for the rest.

use super::*;
use crate::cam::surface::SurfacePoint;
use alloc::vec;
use alloc::vec::Vec;

const INSERT: f64 = 8.0;
const H45: f64 = -14.142_135_623_730_95;

fn bar(azimuths: usize, columns: usize, from_mm: f64, to_mm: f64, radius_mm: f64) -> TurnedPart {
    let grid = PartGrid { azimuths, columns, from_mm, to_mm };
    TurnedPart::round(String::from("bar"), grid, radius_mm).expect("a bar")
}

fn insert(height_mm: f64) -> Insert {
    Insert { radius_mm: INSERT, height_mm }
}

fn pose(turned_rad: f64, x_mm: f64, z_mm: f64) -> InsertPose {
    InsertPose { turned_rad, x_mm, z_mm }
}

/// Numbers between 0 and 1 from a seed.
fn random(seed: &mut u32) -> f64 {
    *seed ^= *seed << 13;
    *seed ^= *seed >> 17;
    *seed ^= *seed << 5;
    f64::from(*seed) / f64::from(u32::MAX)
}

/// Turns along `path`, θ ↦ (x, dx/dθ), with a feed per turn, in so many steps; what was removed in all.
fn turn(
    part: &mut TurnedPart,
    insert: &Insert,
    path: impl Fn(f64) -> (f64, f64),
    (feed_mm, z0_mm): (f64, f64),
    (from_rad, to_rad): (f64, f64),
    steps: u32,
) -> TurnedRemoval {
    let step = (to_rad - from_rad) / f64::from(steps);
    let per_rad = feed_mm / TURN_RAD;
    let mut removal = TurnedRemoval::default();
    for k in 0..steps {
        let (a, b) = (from_rad + step * f64::from(k), from_rad + step * f64::from(k + 1));
        let ((xa, da), (xb, db)) = (path(a), path(b));
        let from = pose(a, xa, z0_mm + per_rad * a);
        let slope = |d: f64| [step, d * step, per_rad * step];
        let motion = InsertMove::cubic(from, [step, xb - xa, per_rad * step], slope(da), slope(db));
        removal = removal.and(part.sweep(insert, &motion, true));
        part.refresh();
    }
    removal
}

/// Between two turns that are f apart stays R − √(R² − f²/4), which is f²/(8R) to within its next term f⁴/(128 R³).
#[test]
fn turning_a_cylinder_leaves_cusps_of_the_feed_and_the_insert() {
    let (feed, radius) = (0.16, 20.0);
    // At azimuth i the centre passes at f (k + i/16), the peak is half a feed on: all of them are columns.
    let mut part = bar(16, 641, 0.0, 3.2, 20.4);
    let before = part.volume_mm3();
    let path = |_: f64| (radius + INSERT, 0.0);
    let removal = turn(&mut part, &insert(0.0), path, (feed, 0.0), (-5.0 * TURN_RAD, 26.0 * TURN_RAD), 31 * 500);
    let peak = INSERT - libm::sqrt(INSERT * INSERT - 0.25 * feed * feed);
    assert!(
        (peak - feed * feed / (8.0 * INSERT)).abs() < 1.1 * libm::pow(feed, 4.0) / (128.0 * INSERT * INSERT * INSERT)
    );
    for i in 0..16 {
        for j in 32..600 {
            let phase = (j as f64 * 0.005 / feed - i as f64 / 16.0).rem_euclid(1.0);
            let beside = feed * phase.min(1.0 - phase);
            let left = radius + INSERT - libm::sqrt(INSERT * INSERT - beside * beside);
            assert!((part.radius_mm(i, j) - left).abs() < 1e-10, "{i} {j}: {} {left}", part.radius_mm(i, j));
        }
    }
    let map = FormMap::new(&part, |_, _| SurfacePoint { radius_mm: radius, ..SurfacePoint::default() }, 0.16, 2.9)
        .expect("a map");
    let cusps = map.cusps(feed).expect("32 columns in a feed");
    assert!((cusps.max_mm - peak).abs() < 1e-10 && (cusps.mean_mm - peak).abs() < 1e-10, "{cusps:?} {peak}");
    assert!((map.highest().deviation_mm - peak).abs() < 1e-10 && map.lowest().deviation_mm.abs() < 1e-10);
    assert!((before - part.volume_mm3() - removal.volume_mm3).abs() < 1e-8, "what is gone is what was taken");
}

/// One turn where the insert stands leaves its shape, at any height of the rake plane.
#[test]
fn a_groove_of_one_turn_has_the_shape_of_the_insert() {
    for (height, sense) in [(0.0, 1.0), (H45, 1.0), (H45, -1.0), (9.0, 1.0), (-1e-3, 1.0)] {
        let mut part = bar(360, 400, -10.0, 10.0, 21.0);
        let x = libm::sqrt(20.0 * 20.0 - height * height) + INSERT;
        let removal =
            turn(&mut part, &insert(height), |_| (x, 0.0), (0.0, 0.3), (0.4, 0.4 + sense * (TURN_RAD + 0.9)), 800);
        for j in 0..400 {
            let dz = part.grid().z_mm(j) - 0.3;
            let edge = x - libm::sqrt(INSERT * INSERT - dz * dz);
            let left = if dz.abs() < INSERT { libm::hypot(edge, height).min(21.0) } else { 21.0 };
            for i in 0..360 {
                assert!((part.radius_mm(i, j) - left).abs() < 1e-12, "{height}: {i} {j} {}", part.radius_mm(i, j));
            }
        }
        assert!((removal.depth_mm - 1.0).abs() < 1e-4, "the middle is 1 mm deep: {removal:?}");
        assert!(removal.deepest.is_some_and(|(_, z)| (z - 0.3).abs() < 0.06), "{removal:?}");
    }
}

/// Intersection of the rake plane's section with a circle of radius r about e in the direction 0, with the part turned by θ: its point
/// is e rotated by −θ plus a radius; of the two the one at height H on the outer side. Returned as (x, dx/dθ).
fn eccentric(r: f64, e: f64, height: f64) -> impl Fn(f64) -> (f64, f64) {
    move |theta| {
        // In the machine's frame the centre is at e (cos θ, −sin θ).
        let (sin, cos) = libm::sincos(theta);
        let above = height + e * sin;
        let along = libm::sqrt(r * r - above * above);
        (e * cos + along + INSERT, -e * sin - above * e * cos / along)
    }
}

/// The same circle as a radius over azimuth.
fn disc(r: f64, e: f64) -> impl Fn(f64, f64) -> SurfacePoint {
    move |azimuth, _| {
        let (sin, cos) = libm::sincos(azimuth);
        let along = libm::sqrt(r * r - e * e * sin * sin);
        SurfacePoint {
            radius_mm: e * cos + along,
            by_azimuth: -e * sin - e * e * sin * cos / along,
            ..SurfacePoint::default()
        }
    }
}

/// On the exact path an eccentric is never cut too deep and keeps no more than its cusps: 0.01 µm, of which the cubics of the steps make
/// X'''' h⁴/384 (at 300 steps a turn 1e-7 µm) and the search for the passing the rest.
#[test]
fn an_eccentric_on_its_exact_path_keeps_cusps_and_nothing_else() {
    let (r, e, feed) = (20.0, 3.0, 0.2);
    for (height, sense) in [(0.0, 1.0), (0.0, -1.0), (H45, 1.0), (H45, -1.0), (8.0, 1.0)] {
        let mut part = bar(360, 81, 0.0, 4.0, 24.0);
        let path = eccentric(r, e, height);
        let turns = (-4.0 * TURN_RAD, 26.0 * TURN_RAD);
        let turns = (sense * turns.0, sense * turns.1);
        turn(&mut part, &insert(height), path, (sense * feed, 0.0), turns, 30 * 300);
        let map = FormMap::new(&part, disc(r, e), 0.0, 4.0).expect("a map");
        let cusp = feed * feed / (8.0 * INSERT);
        let (high, low) = (map.highest(), map.lowest());
        assert!(low.deviation_mm > -1e-5, "{height} {sense}: {low:?}");
        assert!(high.deviation_mm < cusp + 1e-5, "{height} {sense}: {high:?} over {cusp}");
        let cusps = map.cusps(feed).expect("4 columns in a feed");
        assert!(cusps.max_mm > 0.3 * cusp, "{cusps:?}");
    }
}

/// Cubics cut into pieces leave what they leave whole.
#[test]
fn how_a_motion_is_divided_into_steps_changes_nothing() {
    let mut seed = 0x1db3_a9c4_u32;
    for round in 0..20 {
        let height = [0.0, H45, -5.0, 7.5][round % 4];
        let mut whole = bar(180, 120, 0.0, 6.0, 21.0);
        let mut parts = whole.clone();
        let (mut volume, mut volume_of_parts) = (0.0, 0.0);
        let x0 = libm::sqrt(20.4 * 20.4 - height * height) + INSERT;
        let (mut at, mut speed) = (pose(random(&mut seed) * 9.0, x0, 3.0), [0.02, 0.0, 0.01]);
        for _ in 0..300 {
            let next = [0.01 + 0.02 * random(&mut seed), 0.03 * (random(&mut seed) - 0.5), 0.0];
            let way: [f64; 3] = core::array::from_fn(|i| 0.5 * (speed[i] + next[i]));
            let motion = InsertMove::cubic(at, way, speed, next);
            volume += whole.sweep(&insert(height), &motion, true).volume_mm3;
            let cut = 0.1 + 0.8 * random(&mut seed);
            for piece in [motion.between(0.0, 0.5 * cut), motion.between(0.5 * cut, cut), motion.between(cut, 1.0)] {
                volume_of_parts += parts.sweep(&insert(height), &piece, true).volume_mm3;
            }
            whole.refresh();
            (at, speed) = (motion.at(1.0), next);
        }
        let apart = whole.radii_mm().zip(parts.radii_mm()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-6, "round {round}: {apart} mm");
        assert!(volume > 1.0 && (volume - volume_of_parts).abs() < 1e-5 * volume, "{volume} {volume_of_parts}");
    }
}

/// Every moment by itself: where each column's point is, by its angle, and every azimuth between two moments.
fn slow_sweep(part: &mut [f64], grid: &PartGrid, insert: &Insert, motion: &InsertMove, moments: u32) {
    let n = grid.azimuths as f64;
    for j in 0..grid.columns {
        let point = |s: f64| {
            let at = motion.at(s);
            let dz = grid.z_mm(j) - at.z_mm;
            let edge = at.x_mm - libm::sqrt((insert.radius_mm * insert.radius_mm - dz * dz).max(0.0));
            let azimuth = at.turned_rad + libm::atan2(insert.height_mm, edge);
            (azimuth / TURN_RAD * n, libm::hypot(edge, insert.height_mm), dz.abs() < insert.radius_mm)
        };
        for m in 0..moments {
            let (a, ra, in_a) = point(f64::from(m) / f64::from(moments));
            let (b, rb, in_b) = point(f64::from(m + 1) / f64::from(moments));
            if !(in_a && in_b) {
                continue;
            }
            let mut line = libm::ceil(a.min(b));
            while line <= a.max(b) {
                let share = if (a - b).abs() < 1e-12 { 0.0 } else { (line - a) / (b - a) };
                #[allow(clippy::cast_possible_truncation, reason = "a whole number below n")]
                let at = j * grid.azimuths + line.rem_euclid(n) as usize;
                part[at] = part[at].min(ra + (rb - ra) * share);
                line += 1.0;
            }
        }
    }
}

#[test]
fn random_motions_leave_what_a_look_at_every_moment_leaves() {
    for seed in [0x2545_f491_u32, 0x9e37_79b9, 0x0bad_cafe, 0x7654_3210] {
        let mut state = seed;
        let mut next = || random(&mut state);
        for round in 0..8 {
            let height = if round == 0 { 0.0 } else { 24.0 * (next() - 0.5) };
            let grid = PartGrid { azimuths: 90, columns: 61, from_mm: -3.0, to_mm: 3.0 };
            let mut part = TurnedPart::round(String::from("P"), grid, 21.0).expect("a bar");
            let mut slow = part.radii_mm().collect::<Vec<_>>();
            let insert = insert(height);
            let x0 = libm::sqrt(400.0 - height * height) + INSERT;
            let sense = if next() < 0.5 { -1.0 } else { 1.0 };
            let mut at = pose(10.0 * (next() - 0.5), x0, 4.0 * (next() - 0.5));
            let mut speed = [0.05 * sense, 0.0, 0.0];
            for _ in 0..250 {
                let x_home = x0 - at.x_mm + next() - 0.5;
                let new = [sense * (0.02 + 0.06 * next()), 0.1 * x_home, 0.1 * (next() - 0.5) - 0.01 * at.z_mm];
                let way: [f64; 3] = core::array::from_fn(|i| 0.5 * (speed[i] + new[i]));
                let motion = InsertMove::cubic(at, way, speed, new);
                part.sweep(&insert, &motion, true);
                part.refresh();
                slow_sweep(&mut slow, &grid, &insert, &motion, 60);
                (at, speed) = (motion.at(1.0), new);
            }
            for (i, (fast, slow)) in part.radii_mm().zip(&slow).enumerate() {
                // What 60 moments in a step leave between each other.
                assert!((fast - slow).abs() < 2e-5, "seed {seed:#x} round {round} H {height} {i}: {fast} {slow}");
            }
            let cut = part.radii_mm().filter(|r| *r < 21.0).count();
            assert!(cut > 500, "seed {seed:#x} round {round}: {cut}");
        }
    }
}

#[test]
fn measuring_depth_does_not_cut() {
    for height in [0.0, H45] {
        let mut part = bar(360, 101, -5.0, 5.0, 20.0);
        let x = libm::sqrt(19.9 * 19.9 - height * height) + INSERT;
        let motion = InsertMove::straight(pose(1.0, x + 0.2, 0.0), pose(1.0, x, 0.0));
        let seen = part.sweep(&insert(height), &motion, false);
        assert!((seen.depth_mm - 0.1).abs() < 1e-9 && seen.volume_mm3 == 0.0, "{seen:?}");
        assert_eq!(part, bar(360, 101, -5.0, 5.0, 20.0));
    }
}

#[test]
fn an_edge_over_the_axis_and_one_beside_the_part_cut_nothing() {
    let mut part = bar(90, 11, 0.0, 5.0, 20.0);
    let step = |x: f64, z: f64| InsertMove::straight(pose(0.0, x, z), pose(0.3, x, z));
    let over = part.sweep(&insert(0.0), &step(INSERT - 0.1, 2.0), true);
    assert!(over.is_over_axis && over.depth_mm >= 20.0 && over.volume_mm3 == 0.0);
    for (x, z) in [(20.0 + INSERT, 2.0), (20.0, 5.0 + INSERT + 0.1), (20.0, -INSERT - 0.1)] {
        assert_eq!(part.sweep(&insert(0.0), &step(x, z), true), TurnedRemoval::default(), "{x} {z}");
    }
    assert_eq!(part.sweep(&insert(-20.5), &step(10.0, 2.0), true), TurnedRemoval::default(), "under the part");
    assert_eq!(part, bar(90, 11, 0.0, 5.0, 20.0));
}

#[test]
fn a_smaller_reach_is_known_after_every_column_was_looked_at() {
    let mut part = bar(90, 11, 0.0, 1.0, 20.0);
    turn(&mut part, &insert(0.0), |_| (19.0 + INSERT, 0.0), (0.0, 0.5), (0.0, 7.0), 200);
    (0..11).for_each(|_| part.refresh());
    let max = part.radii_mm().fold(0.0, f64::max);
    assert!(
        part.reach_mm() < 19.1 && part.reach_mm() >= max && part.raw_reach_mm() >= 20.0 && part.minimum_mm() >= 19.0,
        "{}",
        part.reach_mm()
    );
}

#[test]
fn grids_and_radii_that_are_no_part_are_refused() {
    let part = |azimuths, columns, to_mm, radii: Vec<f64>| {
        let grid = PartGrid { azimuths, columns, from_mm: 0.0, to_mm };
        TurnedPart::new(String::from("P"), grid, radii).map(|_| ())
    };
    assert!(matches!(part(3, 5, 1.0, vec![1.0; 15]), Err(TurnedPartError::TooFew { azimuths: 3, columns: 5, .. })));
    assert!(matches!(part(16, 1, 1.0, vec![1.0; 16]), Err(TurnedPartError::TooFew { columns: 1, .. })));
    assert!(matches!(part(16, 2, 0.0, vec![1.0; 32]), Err(TurnedPartError::Range { .. })));
    assert!(matches!(part(16, 2, 1.0, vec![1.0; 31]), Err(TurnedPartError::Count { radii: 31, cells: 32, .. })));
    let mut radii = vec![1.0; 32];
    radii[20] = f64::NAN;
    assert!(
        matches!(part(16, 2, 1.0, radii), Err(TurnedPartError::Radius { azimuth_deg, .. }) if (azimuth_deg - 90.0).abs() < 1e-9)
    );
}

/// A cone that stands 0.01 too far out is off by that times the cosine of its slope; bins keep the worst places.
#[test]
fn the_map_measures_along_the_normal_and_its_bins_lose_no_extreme() {
    let grid = PartGrid { azimuths: 36, columns: 41, from_mm: 0.0, to_mm: 20.0 };
    let cone = |z: f64| 20.0 + 0.75 * z;
    let mut radii: Vec<f64> = (0..41).flat_map(|j| vec![cone(grid.z_mm(j)) + 0.01; 36]).collect();
    radii[30 * 36 + 7] += 0.05;
    radii[11 * 36 + 35] -= 0.04;
    let part = TurnedPart::new(String::from("cone"), grid, radii).expect("a cone");
    let design = |_, z: f64| SurfacePoint { radius_mm: cone(z), by_z: 0.75, ..SurfacePoint::default() };
    let map = FormMap::new(&part, design, 0.0, 20.0).expect("a map");
    let (high, low) = (map.highest(), map.lowest());
    assert!((high.deviation_mm - 0.8 * 0.06).abs() < 1e-12 && (high.z_mm - 15.0).abs() < 1e-12);
    assert!((high.azimuth_rad - grid.azimuth_rad(7)).abs() < 1e-12);
    assert!((low.deviation_mm + 0.8 * 0.03).abs() < 1e-12 && (low.z_mm - 5.5).abs() < 1e-12);
    assert!((map.largest_mm() - 0.048).abs() < 1e-12 && (map.rms_mm() - 0.008).abs() < 1e-3);
    let bins = map.bins(5, 7);
    assert_eq!(bins.len(), 35);
    assert!(bins.iter().any(|bin| bin.max_mm >= high.deviation_mm));
    assert!(bins.iter().any(|bin| bin.min_mm <= low.deviation_mm));
    assert!(bins.iter().all(|bin| bin.min_mm <= bin.mean_mm && bin.mean_mm <= bin.max_mm));
    assert_eq!(map.bins(1000, 1000).len(), 36 * 41);
    assert!(matches!(FormMap::new(&part, design, 30.0, 40.0), Err(FormMapError::NoColumns { .. })));
    let none = |_, _| SurfacePoint { radius_mm: f64::NAN, ..SurfacePoint::default() };
    assert!(matches!(FormMap::new(&part, none, 0.0, 9.0), Err(FormMapError::NoSurface { .. })));
}
