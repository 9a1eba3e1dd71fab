// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Grooves round a cylinder: what the roller does to its walls, what mills leave on them by formula, by the library and by a slow sweep, and
//! what is refused.
#![allow(clippy::print_stdout, reason = "figures for the reader of --nocapture")]

use crate::cams;

use cams::{SplitMix64, lobe, program, random_law, segment};
use camwright::cam::lift::LiftLaw;
use camwright::cam::motion_law::MotionLaw;
use camwright::math::units::{TURN_RAD, rad_from_deg, um_from_mm};
use camwright::toolpath::cutter_path::{CarriageAxis, CutterPath};
use camwright::toolpath::groove::barrel::{BarrelCutter, BarrelGroove};
use camwright::toolpath::groove::{Coverage, GrooveError, Wall};

fn angles(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| TURN_RAD * (f64::from(i) + 0.31) / f64::from(count))
}

/// Up and down at a constant rate over a third of a turn each, blended in.
fn ramps(rate_mm_rad: f64) -> LiftLaw {
    let (straight, blend, dwell) = (rad_from_deg(70.0), rad_from_deg(50.0), rad_from_deg(10.0));
    let up = [
        (MotionLaw::Dwell, dwell, 0.0),
        (MotionLaw::SepticBlend, blend, 0.5 * blend * rate_mm_rad),
        (MotionLaw::ConstantVelocity, straight, straight * rate_mm_rad),
        (MotionLaw::SepticBlend, blend, 0.5 * blend * rate_mm_rad),
    ];
    let down = up.iter().map(|&(law, angle, rise)| segment(law, angle, -rise));
    program(0.0, &up.iter().map(|&(law, angle, rise)| segment(law, angle, rise)).chain(down).collect::<Vec<_>>())
}

fn mill(radius_mm: f64, y_axis: bool) -> BarrelCutter {
    BarrelCutter { radius_mm, y_axis }
}

/// Error of the roller's wall at a cam angle and a position x along the roller, by testing the mill at 1600 azimuths: only the path comes
/// from the library.
fn swept(lift: &LiftLaw, path: &CutterPath, radii: (f64, f64), wall: f64, angle: f64, x: f64) -> f64 {
    const STEP: f64 = 1e-5;
    let (roller, cutter) = radii;
    let rate = (lift.sample(angle + STEP).value - lift.sample(angle - STEP).value) / (2.0 * STEP);
    let length = x.hypot(rate);
    let place = [
        x * angle.cos() + wall * roller * rate / length * angle.sin(),
        x * angle.sin() - wall * roller * rate / length * angle.cos(),
        lift.sample(angle).value + wall * roller * x / length,
    ];
    let left = |carriage: f64| {
        let along = place[0] * carriage.cos() + place[1] * carriage.sin();
        let across = place[1] * carriage.cos() - place[0] * carriage.sin();
        let y = path.sample(CarriageAxis::Y, carriage).map_or(0.0, |y| y.value);
        let z = path.sample(CarriageAxis::Z, carriage).expect("it moves along Z").value;
        if along > 0.0 { (across - y).hypot(place[2] - z) - cutter } else { f64::INFINITY }
    };
    let best = angles(800)
        .map(|carriage| (left(carriage), carriage))
        .fold((f64::INFINITY, 0.0), |a, b| if b.0 < a.0 { b } else { a });
    // 20 urad apart: a place between two of them is seen too far away by less than 1e-7 mm.
    let window = TURN_RAD / 800.0;
    (0..=800).map(|i| left(best.1 + window * (f64::from(i) / 400.0 - 1.0))).fold(best.0, f64::min)
}

/// A mill like the roller, its axis radial: Z is the lift, and both walls are what the roller makes of them.
#[test]
fn a_mill_like_the_roller_leaves_nothing() {
    let law = ramps(20.0);
    let groove = BarrelGroove::new(&law, 8.0, 45.0, 35.0).unwrap();
    let paths = groove.paths(mill(8.0, false), 0.0, Coverage::Slot).unwrap();
    let [path] = paths.as_slice() else { panic!("{} paths", paths.len()) };
    assert_eq!((path.name.as_str(), path.infeed, path.travels.len()), ("groove", CarriageAxis::X, 1));
    for angle in angles(3600) {
        let z = path.sample(CarriageAxis::Z, angle).unwrap().value;
        assert!((z - law.sample(angle).value).abs() < 2e-9, "{angle}");
    }
    for wall in Wall::BOTH {
        let errors = groove.wall_errors(path, 8.0, 0.0, wall);
        assert!(errors.worst().error_mm.abs() < 1e-8, "{errors:?}");
        assert!(swept(&law, path, (8.0, 8.0), wall.side(), 1.0, 36.0).abs() < 1e-8);
    }
}

/// For a helical groove the formula of the shifted axis is correct except for the curvature of the walls: d(1 − cos Δγ), d = rr − rc, with
/// Y; without Y d(1 − cos γ cos γm − (x/xm) sin γ sin γm). The two cases of which the first stays below 8 µm and the second, with the axis
/// right at the mean radius, below 50 µm; right half-way between the slopes of both ends, as here, it is a fifth less.
#[test]
fn the_shift_of_a_smaller_mill_leaves_what_the_formulas_say() {
    for (floor, outer, rate, roller, cutter, max_um) in
        [(35.0, 45.0, 20.0, 10.0, 5.0, 8.0), (30.0, 50.0, 40.0, 10.0, 5.0, 50.0)]
    {
        let law = ramps(rate);
        let groove = BarrelGroove::new(&law, roller, outer, floor).unwrap();
        let (d, mean) = (roller - cutter, groove.mean_radius_mm());
        let slope = |x: f64| f64::atan2(rate, x);
        let at_mean_um = um_from_mm(d * (1.0 - (slope(floor) - slope(mean)).cos()));
        let half_way = 0.5 * (slope(floor) + slope(outer));
        for y_axis in [true, false] {
            let formula = |x: f64| {
                if y_axis {
                    d * (1.0 - (slope(x) - half_way).cos())
                } else {
                    d * (1.0 - slope(x).cos() * slope(mean).cos() - x / mean * slope(x).sin() * slope(mean).sin())
                }
            };
            let paths = groove.paths(mill(cutter, y_axis), 0.0, Coverage::Walls).unwrap();
            for (path, wall) in paths.iter().zip(Wall::BOTH) {
                let errors = groove.wall_errors(path, cutter, 0.0, wall);
                // The middle of the rise, which is a helix.
                let exact = |x: f64| swept(&law, path, (roller, cutter), wall.side(), rad_from_deg(95.0), x);
                println!(
                    "R {floor} to {outer} mm, {rate} mm/rad, {} {}: formula {:+.2} um at the floor, {:+.2} at the surface; swept {:+.2}, {:+.2}; \
                     of the whole wall {:+.2} um at R {:.2} mm, {:.1} deg, to {:+.2} um at R {:.2} mm, {:.1} deg; with the axis right at the \
                     mean radius {at_mean_um:.2}",
                    if y_axis { "with Y" } else { "without Y" },
                    wall.name_on_cylinder(),
                    um_from_mm(formula(floor)),
                    um_from_mm(formula(outer)),
                    um_from_mm(exact(floor)),
                    um_from_mm(exact(outer)),
                    um_from_mm(errors.max.error_mm),
                    errors.max.radius_mm,
                    errors.max.azimuth_rad.to_degrees(),
                    um_from_mm(errors.min.error_mm),
                    errors.min.radius_mm,
                    errors.min.azimuth_rad.to_degrees(),
                );
                for x in [floor, outer] {
                    assert!((exact(x) / formula(x) - 1.0).abs() < 0.05, "{x}: {} {}", exact(x), formula(x));
                }
                if y_axis {
                    assert!(um_from_mm(errors.worst().error_mm) < max_um, "{errors:?}");
                    assert!(errors.min.error_mm > -1e-6, "a shifted axis never cuts in: {errors:?}");
                } else {
                    assert!(errors.min.error_mm < -5.0 * formula(mean).abs(), "it cuts in: {errors:?}");
                }
            }
        }
    }
}

/// Every wall of random grooves by the slow sweep: nowhere beyond what the library says is most and least, which are places of the wall.
#[test]
fn wall_errors_are_those_of_the_swept_mill() {
    let mut made = 0;
    for seed in 0..40 {
        let mut random = SplitMix64(seed);
        let law = random_law(&mut random, 6.0);
        let (roller, floor) = (random.within(4.0, 12.0), random.within(25.0, 40.0));
        let outer = floor + random.within(4.0, 15.0);
        let Ok(groove) = BarrelGroove::new(&law, roller, outer, floor) else { continue };
        let leaves = random.one_of(&[0.0, 0.3]);
        let radius = (roller - leaves) * random.one_of(&[1.0, 0.9, 0.7, 0.6]);
        let y_axis = random.next().is_multiple_of(2);
        let paths = groove.paths(mill(radius, y_axis), leaves, Coverage::Walls).unwrap();
        for (path, wall) in [(&paths[0], Wall::Inner), (&paths[paths.len() - 1], Wall::Outer)] {
            let errors = groove.wall_errors(path, radius, leaves, wall);
            let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
            for _ in 0..60 {
                let (angle, share) = (random.within(0.0, TURN_RAD), random.one_of(&[0.0, 0.3, 1.0]));
                let rate = law.sample(angle).first;
                // The end at the surface is where the wall itself meets the cylinder.
                let mut surface = outer;
                for _ in 0..50 {
                    let y = (roller - leaves) * rate / f64::hypot(surface, rate);
                    surface = (outer * outer - y * y).sqrt();
                }
                let x = floor + share * (surface - floor);
                let left = swept(&law, path, (roller - leaves, radius), wall.side(), angle, x);
                assert!(left < errors.max.error_mm + 2e-6, "seed {seed}: {left} {errors:?}");
                assert!(left > errors.min.error_mm - 2e-6, "seed {seed}: {left} {errors:?}");
                (min, max) = (min.min(left), max.max(left));
            }
            // A hundred and twenty places come near the worst ones.
            let range = errors.max.error_mm - errors.min.error_mm;
            assert!(max - min > 0.4 * range - 1e-6, "seed {seed}: {min} to {max}, {errors:?}");
            made += 1;
        }
    }
    println!("{made} walls");
    assert!(made > 30, "{made}");
}

/// Whatever lies between the walls, a little off them, is cut by one path or another, with Y and without.
#[test]
fn nothing_is_left_between_the_walls() {
    let mut deepest = f64::NEG_INFINITY;
    for seed in 0..16 {
        let mut random = SplitMix64(500 + seed);
        let law = random_law(&mut random, 6.0);
        let (roller, floor) = (random.within(6.0, 12.0), random.within(25.0, 40.0));
        let outer = floor + random.within(4.0, 15.0);
        let Ok(groove) = BarrelGroove::new(&law, roller, outer, floor) else { continue };
        let (radius, y_axis) = (roller * random.one_of(&[0.45, 0.3, 0.2]), random.next().is_multiple_of(2));
        let paths = groove.paths(mill(radius, y_axis), 0.0, Coverage::Slot).unwrap();
        assert!(paths.len() > 2, "seed {seed}");
        for _ in 0..60 {
            let (angle, x) = (random.within(0.0, TURN_RAD), random.within(floor, outer));
            let beside = roller * random.within(-0.85, 0.85);
            let left = paths.iter().map(|path| swept(&law, path, (beside, radius), 1.0, angle, x));
            let left = left.fold(f64::INFINITY, f64::min);
            assert!(left < 0.0, "seed {seed}: {left} left {beside} mm beside the pitch curve, at {angle}, {x}");
            deepest = deepest.max(left);
        }
    }
    println!("at least {deepest} mm inside a path");
    assert!(deepest > -2.0, "{deepest}");
}

/// A groove that is refused as undercut really is: the roller cuts into one of its own walls; and one that is not is not.
#[test]
fn undercut_is_what_the_roller_does_to_its_own_walls() {
    let (mut sound, mut under) = (0, 0);
    for seed in 0..60 {
        let mut random = SplitMix64(1000 + seed);
        let law = random_law(&mut random, 16.0);
        let (roller, floor) = (random.within(4.0, 12.0), random.within(20.0, 40.0));
        let outer = floor + random.within(4.0, 15.0);
        // Z of a mill that is the roller: the path of a groove with a roller so thin that nothing is undercut.
        let thin = BarrelGroove::new(&law, 1e-3, outer, floor).unwrap();
        let path = &thin.paths(mill(1e-3, false), 0.0, Coverage::Slot).unwrap()[0];
        let bite = |wall: Wall| {
            let places = (0..180).map(|i| TURN_RAD * f64::from(i) / 180.0);
            let left = places.flat_map(|angle| [floor, 0.5 * (floor + outer), outer].map(|x| (angle, x)));
            left.map(|(angle, x)| swept(&law, path, (roller, roller), wall.side(), angle, x)).fold(0.0, f64::min)
        };
        match BarrelGroove::new(&law, roller, outer, floor) {
            Ok(_) => {
                sound += 1;
                assert!(Wall::BOTH.into_iter().all(|wall| bite(wall) > -1e-6), "seed {seed}");
            }
            Err(GrooveError::Undercut { wall, slot_radius_mm, bound_mm, from_axis_mm, angle_deg }) => {
                under += 1;
                assert!(
                    slot_radius_mm > 0.0 && slot_radius_mm <= bound_mm && bound_mm >= roller,
                    "seed {seed}: {slot_radius_mm}"
                );
                assert!((floor..=outer).contains(&from_axis_mm), "seed {seed}");
                let side = if wall == "wall towards -Z" { -1.0 } else { 1.0 };
                let near = (0..41).map(|i| angle_deg.to_radians() + 0.01 * f64::from(i - 20));
                let bite = near
                    .map(|angle| swept(&law, path, (roller, roller), side, angle, from_axis_mm))
                    .fold(0.0, f64::min);
                assert!(bite < 0.0, "seed {seed}: {bite}, radius {slot_radius_mm} of {bound_mm}");
            }
            Err(other) => panic!("seed {seed}: {other}"),
        }
    }
    println!("{sound} sound, {under} undercut");
    assert!(sound > 8 && under > 8, "{sound} sound, {under} undercut");
}

#[test]
fn what_cannot_be_a_groove_is_refused_with_figures_and_place() {
    let law = lobe(MotionLaw::Polynomial4567, 20.0, 90.0);
    let refusal =
        |law: &LiftLaw, roller, outer, floor| BarrelGroove::new(law, roller, outer, floor).unwrap_err().to_string();
    assert_eq!(refusal(&law, -1.0, 50.0, 40.0), "the radius of the roller is -1 mm, it must be a positive number");
    assert_eq!(refusal(&law, 8.0, 50.0, f64::NAN), "the radius of the floor is NaN mm, it must be a positive number");
    assert_eq!(
        refusal(&law, 8.0, 50.0, 4.0),
        "the radius of the floor is 4 mm, it must be larger than half that of the roller"
    );
    assert_eq!(
        refusal(&law, 8.0, 40.0, 40.0),
        "the radius of the cylinder is 40 mm, it must be larger than that of the floor"
    );
    assert!(refusal(&law, 8.0, f64::INFINITY, 40.0).contains("the radius of the cylinder is inf mm"));
    let steep = refusal(&lobe(MotionLaw::Polynomial4567, 20.0, 30.0), 12.0, 50.0, 40.0);
    assert!(steep.starts_with("the groove is undercut at its wall towards -Z, at cam angle 1"), "{steep}");
    let groove = BarrelGroove::new(&law, 8.0, 50.0, 40.0).unwrap();
    for y_axis in [false, true] {
        let refusal =
            |radius, leaves| groove.paths(mill(radius, y_axis), leaves, Coverage::Slot).unwrap_err().to_string();
        assert!(
            refusal(8.5, 0.0)
                .starts_with("a mill of radius 8.5 mm does not go into the groove, whose half width is 8 mm")
        );
        assert!(refusal(1e-12, 0.0).contains("at most 64 are allowed"));
        assert!(refusal(0.0, 0.0).contains("the radius of the mill is 0 mm"));
    }
}
