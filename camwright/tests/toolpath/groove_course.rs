// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Grooves round a cylinder over several turns, with two ends, and for rollers on a turret: closed forms, the swept mill, and refusals.
//!
//! The oracle knows the course of the roller as a formula of the test, and of the library only the path of the mill. It finds the wall of the
//! rolling cylinder from differences of that formula.

#![allow(clippy::print_stdout, reason = "figures for the reader of --nocapture")]

use crate::cams;

use cams::{SplitMix64, segment};
use camwright::cam::lift::{LiftLaw, MotionProgram, MotionSegment, ProgramError};
use camwright::cam::motion_law::MotionLaw;
use camwright::math::units::{TURN_RAD, rad_from_deg};
use camwright::toolpath::cutter_path::{CarriageAxis, CutterPath};
use camwright::toolpath::groove::barrel::{BarrelCutter, BarrelGroove, EndFaces};
use camwright::toolpath::groove::course::{GrooveCourse, Turret};
use camwright::toolpath::groove::rib::PlacedGroove;
use camwright::toolpath::groove::{Coverage, GrooveError, Wall};

/// Segments by their angles in degrees.
fn segments(of: &[(MotionLaw, f64, f64)]) -> Vec<MotionSegment> {
    of.iter().map(|&(law, deg, rise)| segment(law, rad_from_deg(deg), rise)).collect()
}

/// Out and back at one rate (mm/deg) over so many turns, in blends of 60°.
fn traverse(turns: u32, rate: f64) -> Vec<MotionSegment> {
    let straight = 180.0 * f64::from(turns) - 120.0;
    let way = |sign: f64| {
        [
            (MotionLaw::SepticBlend, 60.0, sign * 30.0 * rate),
            (MotionLaw::ConstantVelocity, straight, sign * straight * rate),
            (MotionLaw::SepticBlend, 60.0, sign * 30.0 * rate),
        ]
    };
    segments(&[way(1.0), way(-1.0)].concat())
}

fn closed(turns: u32, of: &[MotionSegment]) -> GrooveCourse {
    let program = MotionProgram::over_turns(turns, 0.0, 0.0, of).expect("segments that close");
    GrooveCourse::closed(&LiftLaw::from_program(program).expect("a lift"), turns).expect("turns")
}

/// Dwell, rise by the cycloid, dwell, once a turn.
fn steps(turns: u32, rise_mm: f64) -> MotionProgram {
    let one = [(MotionLaw::Dwell, 90.0, 0.0), (MotionLaw::Cycloidal, 180.0, rise_mm), (MotionLaw::Dwell, 90.0, 0.0)];
    MotionProgram::open(turns, 0.0, &segments(&one.repeat(turns as usize))).expect("a motion")
}

/// The same in closed form.
fn steps_mm(azimuth: f64, turns: f64, rise_mm: f64) -> f64 {
    let azimuth = azimuth.clamp(0.0, turns * TURN_RAD - 1e-12);
    let turn = (azimuth / TURN_RAD).floor();
    let u = ((azimuth / TURN_RAD - turn - 0.25) * 2.0).clamp(0.0, 1.0);
    rise_mm * (turn + u - (TURN_RAD * u).sin() / TURN_RAD)
}

fn mill(radius_mm: f64, y_axis: bool) -> BarrelCutter {
    BarrelCutter { radius_mm, y_axis }
}

/// Y and Z of a path.
fn stands(path: &CutterPath, azimuth: f64) -> [f64; 2] {
    [CarriageAxis::Y, CarriageAxis::Z].map(|axis| path.sample(axis, azimuth).map_or(0.0, |at| at.value))
}

/// Material that a mill leaves on the wall of a rolling cylinder at x along its roller (mm), by mills at 2400 azimuths around the place.
fn swept(
    centre: &dyn Fn(f64) -> [f64; 2],
    path: &CutterPath,
    (roller, cutter): (f64, f64),
    side: f64,
    azimuth: f64,
    x: f64,
) -> f64 {
    const STEP: f64 = 1e-5;
    let ([y, z], [y0, z0], [y1, z1]) = (centre(azimuth), centre(azimuth - STEP), centre(azimuth + STEP));
    let (across, along) = (x + (y1 - y0) / (2.0 * STEP), (z1 - z0) / (2.0 * STEP));
    let length = across.hypot(along);
    let place = [x, y - side * roller * along / length, z + side * roller * across / length];
    let left = |carriage: f64| {
        let by = carriage - azimuth;
        let beside = place[1] * by.cos() - place[0] * by.sin();
        let [y, z] = stands(path, carriage);
        (beside - y).hypot(place[2] - z) - cutter
    };
    let window = 1.2 * (roller + y.abs()) / x;
    let best = (0..=1200)
        .map(|i| azimuth + window * (f64::from(i) / 600.0 - 1.0))
        .map(|carriage| (left(carriage), carriage))
        .fold((f64::INFINITY, 0.0), |a, b| if b.0 < a.0 { b } else { a });
    let step = window / 600.0;
    (0..=1200).map(|i| left(best.1 + step * (f64::from(i) / 600.0 - 1.0))).fold(best.0, f64::min)
}

/// Three turns out and three back: Z is the lift of the segments, over six turns, and both walls are those of the roller, at crossings too.
#[test]
fn a_mill_like_the_roller_cuts_a_groove_of_six_turns() {
    let rate = 0.05;
    let groove = BarrelGroove::along(closed(6, &traverse(6, rate)), 4.0, (30.0, 25.0), None).unwrap();
    let paths = groove.paths(mill(4.0, false), 0.0, Coverage::Slot).unwrap();
    let [path] = paths.as_slice() else { panic!("{} paths", paths.len()) };
    assert!((path.span_rad() - 6.0 * TURN_RAD).abs() < 1e-12 && !path.is_open() && path.turns() == 6);
    // Between the blends: 30° of rate less than the angle.
    let straight = |deg: f64| if deg < 1080.0 { rate * (deg - 30.0) } else { rate * (2130.0 - deg) };
    for deg in (0..2160).map(|deg| f64::from(deg) + 0.37) {
        let z = path.sample(CarriageAxis::Z, rad_from_deg(deg)).unwrap();
        let again = path.sample(CarriageAxis::Z, rad_from_deg(deg - 2160.0)).unwrap();
        assert!((z.value - again.value).abs() < 1e-9, "{deg}");
        if (deg % 1080.0) > 60.0 && (deg % 1080.0) < 1020.0 {
            assert!((z.value - straight(deg)).abs() < 2e-9, "{deg}: {} {}", z.value, straight(deg));
            assert!((z.first.abs() - rate.to_degrees()).abs() < 1e-6, "{deg}: {}", z.first);
        }
    }
    let centre = |azimuth: f64| [0.0, straight(azimuth.to_degrees())];
    for (deg, x) in [(500.0, 25.0), (540.0, 27.0), (900.0, 30.0), (1500.0, 25.0), (1800.0, 28.0)] {
        for side in [-1.0, 1.0] {
            let left = swept(&centre, path, (4.0, 4.0), side, rad_from_deg(deg), x);
            assert!(left.abs() < 2e-7, "{deg} {x}: {left}");
        }
    }
    for wall in Wall::BOTH {
        let errors = groove.wall_errors(path, 4.0, 0.0, wall);
        assert!(errors.worst().error_mm.abs() < 1e-7, "{errors:?}");
    }
}

/// On the straight flanks, which are helices, a smaller mill leaves d(1 − cos Δγ) with Y, and without Y what the turn of C gives, at every turn
/// and also in an open groove.
#[test]
fn a_smaller_mill_leaves_the_same_along_several_turns_and_between_two_ends() {
    let (roller, cutter, outer, floor, rate) = (10.0_f64, 6.0, 45.0, 35.0, 0.3);
    let (d, per_rad) = (roller - cutter, f64::to_degrees(rate));
    let slope = |x: f64| f64::atan2(per_rad, x);
    let (half_way, mean) = (0.5 * (slope(floor) + slope(outer)), 0.5 * (floor + outer));
    let open = |rise: f64| {
        let of = [
            (MotionLaw::SepticBlend, 60.0, 30.0 * rate),
            (MotionLaw::ConstantVelocity, 600.0, 600.0 * rate),
            (MotionLaw::SepticBlend, 60.0, 30.0 * rate + rise),
        ];
        GrooveCourse::open(MotionProgram::open(2, 0.0, &segments(&of)).unwrap()).unwrap()
    };
    let centre = |azimuth: f64| [0.0, rate * (azimuth.to_degrees() - 30.0)];
    for course in [closed(4, &traverse(4, rate)), open(0.0)] {
        let groove = BarrelGroove::along(course, roller, (outer, floor), None).unwrap();
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
                for x in [floor, outer] {
                    for deg in [250.0, 500.0] {
                        let left = swept(&centre, path, (roller, cutter), wall.side(), rad_from_deg(deg), x);
                        assert!((left / formula(x) - 1.0).abs() < 0.05, "{deg} {x}: {left} {}", formula(x));
                    }
                }
                let errors = groove.wall_errors(path, cutter, 0.0, wall);
                let worst = [floor, outer].map(|x| formula(x).abs()).into_iter().fold(0.0, f64::max);
                assert!(errors.worst().error_mm.abs() < 1.3 * worst, "{errors:?} {worst}");
            }
        }
    }
}

/// The mill follows the cycloid from the first dwell to the last one and stands beyond them. Derivatives are those of the values.
#[test]
fn an_open_groove_has_two_ends_at_rest() {
    let course = GrooveCourse::open(steps(3, 30.0)).unwrap();
    let faces = EndFaces { from_mm: 12.0, to_mm: 78.0, zero_mm: 0.0 };
    let groove = BarrelGroove::along(course, 8.0, (45.0, 35.0), Some(faces)).unwrap();
    groove.check_ends(2.0).unwrap();
    let paths = groove.paths(mill(8.0, false), 0.0, Coverage::Slot).unwrap();
    let path = &paths[0];
    assert!(path.is_open() && path.turns() == 3 && (path.span_rad() - 3.0 * TURN_RAD).abs() < 1e-12);
    for deg in (-50..1130).map(|deg| f64::from(deg) + 0.31) {
        let azimuth = rad_from_deg(deg);
        let at = |azimuth| path.sample(CarriageAxis::Z, azimuth).unwrap();
        let (z, h) = (at(azimuth), 1e-5);
        assert!((z.value - steps_mm(azimuth, 3.0, 30.0)).abs() < 3e-9, "{deg}: {}", z.value);
        assert!((z.first - (at(azimuth + h).value - at(azimuth - h).value) / (2.0 * h)).abs() < 1e-5, "{deg}");
        assert!((z.second - (at(azimuth + h).first - at(azimuth - h).first) / (2.0 * h)).abs() < 2e-3, "{deg}");
    }
    let centre = |azimuth: f64| [0.0, steps_mm(azimuth, 3.0, 30.0)];
    for side in [-1.0, 1.0] {
        for (deg, x) in [(180.0, 35.0), (450.0, 40.0), (540.0, 45.0), (900.0, 36.0)] {
            let left = swept(&centre, path, (8.0, 8.0), side, rad_from_deg(deg), x);
            assert!(left.abs() < 2e-7, "{deg} {x}: {left}");
        }
    }
    // A smaller mill, with Y and without, by the oracle at places of all kinds.
    for y_axis in [true, false] {
        let paths = groove.paths(mill(6.0, y_axis), 0.0, Coverage::Walls).unwrap();
        for (path, wall) in paths.iter().zip(Wall::BOTH) {
            let errors = groove.wall_errors(path, 6.0, 0.0, wall);
            for deg in (100..980).step_by(7).map(f64::from) {
                let [_, z] = centre(rad_from_deg(deg));
                let left = swept(&centre, path, (8.0, 6.0), wall.side(), rad_from_deg(deg), 35.0);
                if groove.is_inside(z) {
                    assert!(left < errors.max.error_mm + 2e-6, "{deg}: {left} {errors:?}");
                    assert!(left > errors.min.error_mm - 2e-6, "{deg}: {left} {errors:?}");
                }
            }
        }
    }
}

fn turret(radius_mm: f64, axis_y_mm: f64, start_deg: f64) -> Turret {
    Turret { stations: 12, radius_mm, axis_y_mm, start_rad: rad_from_deg(start_deg) }
}

/// Twelve stations, a step a turn, axis on either side: Z = R sin ψ and Y = ±(|C| − R cos ψ), and both walls are those of the roller.
#[test]
fn a_mill_like_the_roller_of_a_turret_follows_its_arc() {
    let radius = 80.0;
    let step_mm = rad_from_deg(30.0) * radius;
    for axis_y_mm in [76.0, -76.0] {
        let course = GrooveCourse::open(steps(3, step_mm)).unwrap();
        let course = course.on_turret(turret(radius, axis_y_mm, -45.0)).unwrap();
        let faces = EndFaces { from_mm: -32.0, to_mm: 32.0, zero_mm: 0.0 };
        let groove = BarrelGroove::along(course, 8.0, (60.0, 45.0), Some(faces)).unwrap();
        groove.check_ends(2.0).unwrap();
        let centre = |azimuth: f64| {
            let angle = rad_from_deg(-45.0) + steps_mm(azimuth, 3.0, step_mm) / radius;
            [f64::signum(axis_y_mm) * (76.0 - radius * angle.cos()), radius * angle.sin()]
        };
        let paths = groove.paths(mill(8.0, true), 0.0, Coverage::Slot).unwrap();
        let [path] = paths.as_slice() else { panic!("{} paths", paths.len()) };
        for deg in (-20..1100).map(|deg| f64::from(deg) + 0.43) {
            let (wanted, found) = (centre(rad_from_deg(deg)), stands(path, rad_from_deg(deg)));
            assert!((wanted[0] - found[0]).abs() + (wanted[1] - found[1]).abs() < 6e-9, "{deg}: {wanted:?} {found:?}");
        }
        // Dwells of the stations: -15 and 15 deg.
        let dwell = stands(path, TURN_RAD);
        assert!((dwell[1] + radius * rad_from_deg(15.0).sin()).abs() < 1e-9, "{dwell:?}");
        for side in [-1.0, 1.0] {
            for (deg, x) in [(240.0, 45.0), (360.0, 50.0), (500.0, 45.0), (540.0, 55.0), (830.0, 48.0)] {
                let left = swept(&centre, path, (8.0, 8.0), side, rad_from_deg(deg), x);
                assert!(left.abs() < 3e-7, "{deg} {x}: {left}");
            }
        }
        // Another mill: errors are those of the sweep.
        let paths = groove.paths(mill(6.0, true), 0.0, Coverage::Walls).unwrap();
        for (path, wall) in paths.iter().zip(Wall::BOTH) {
            let errors = groove.wall_errors(path, 6.0, 0.0, wall);
            assert!(errors.worst().error_mm > 1e-5 && errors.worst().error_mm < 0.1, "{errors:?}");
            for deg in (200..880).step_by(11).map(f64::from) {
                if groove.is_inside(centre(rad_from_deg(deg))[1]) {
                    let left = swept(&centre, path, (8.0, 6.0), wall.side(), rad_from_deg(deg), 45.0);
                    assert!(left < errors.max.error_mm + 2e-6 && left > errors.min.error_mm - 2e-6, "{deg}: {left}");
                }
            }
        }
    }
}

/// A groove on a turret that is refused as undercut really is, and one that is not is not.
#[test]
fn undercut_on_a_turret_is_what_the_roller_does_to_its_own_walls() {
    let (mut sound, mut under) = (0, 0);
    for seed in 0..48 {
        let mut random = SplitMix64(seed);
        let (radius, axis) = (random.within(40.0, 100.0), random.one_of(&[-1.0, 1.0]));
        let (rise_mm, angle_deg) = (random.within(15.0, 45.0), random.within(50.0, 130.0));
        let (roller, floor) = (random.within(5.0, 18.0), random.within(20.0, 40.0));
        let of = [
            (MotionLaw::Dwell, 180.0 - angle_deg, 0.0),
            (MotionLaw::Cycloidal, angle_deg, rise_mm),
            (MotionLaw::Dwell, 180.0 - angle_deg, 0.0),
            (MotionLaw::Cycloidal, angle_deg, -rise_mm),
        ];
        let start_deg = random.within(-20.0, 0.0);
        let on = turret(radius, axis * (radius - 2.0), start_deg);
        let course = closed(1, &segments(&of)).on_turret(on).unwrap();
        let outer = floor + 10.0;
        let law = |azimuth: f64| {
            let deg = azimuth.to_degrees().rem_euclid(360.0);
            let rise = |u: f64| rise_mm * (u - (TURN_RAD * u).sin() / TURN_RAD);
            let up = rise(((deg - 180.0 + angle_deg) / angle_deg).clamp(0.0, 1.0));
            up - rise(((deg - 360.0 + angle_deg) / angle_deg).clamp(0.0, 1.0))
        };
        let centre = |azimuth: f64| {
            let angle = on.start_rad + law(azimuth) / radius;
            [axis * (radius - 2.0 - radius * angle.cos()), radius * angle.sin()]
        };
        let thin = BarrelGroove::along(course.clone(), 1e-3, (outer, floor), None).unwrap();
        let path = &thin.paths(mill(1e-3, true), 0.0, Coverage::Slot).unwrap()[0];
        let bite = |from: f64, to: f64, wall: f64| {
            let places = (0..120).map(|i| from + (to - from) * f64::from(i) / 120.0);
            let left = places.flat_map(|angle| [floor, outer].map(|x| (angle, x)));
            left.map(|(angle, x)| swept(&centre, path, (roller, roller), wall, angle, x)).fold(0.0, f64::min)
        };
        match BarrelGroove::along(course, roller, (outer, floor), None) {
            Ok(_) => {
                sound += 1;
                let worst = [-1.0, 1.0].map(|wall| bite(0.0, TURN_RAD, wall));
                assert!(worst.iter().all(|bite| *bite > -2e-6), "seed {seed}: {worst:?}");
            }
            Err(GrooveError::Undercut { wall, angle_deg, .. }) => {
                under += 1;
                let side = if wall == "wall towards -Z" { -1.0 } else { 1.0 };
                let at = angle_deg.to_radians();
                assert!(bite(at - 0.2, at + 0.2, side) < -1e-7, "seed {seed}");
            }
            Err(GrooveError::BesideCylinder { .. }) => {}
            Err(other) => panic!("seed {seed}: {other}"),
        }
    }
    println!("{sound} sound, {under} undercut");
    assert!(sound > 8 && under > 8, "{sound} sound, {under} undercut");
}

/// Half a turn behind.
fn behind(groove: &BarrelGroove) -> PlacedGroove<'_> {
    PlacedGroove { phase_rad: 0.5 * TURN_RAD, ..placed("B", groove, 0.0) }
}

fn placed<'a>(name: &'a str, groove: &'a BarrelGroove, z_mm: f64) -> PlacedGroove<'a> {
    PlacedGroove { name, groove, z_mm, phase_rad: 0.0 }
}

/// Turns 18 mm apart leave a rib of grooves 8 mm wide, and crossings are meant. Turns of an open groove 7 mm apart leave none.
#[test]
fn ribs_remain_between_turns_unless_they_cross() {
    let crossing = BarrelGroove::along(closed(6, &traverse(6, 0.05)), 4.0, (30.0, 25.0), None).unwrap();
    crossing.check_turns(true).unwrap();
    // The turn after meets on its way back: φ - 30 = 2130 - (φ + 360).
    let refusal = crossing.check_turns(false).unwrap_err();
    assert!(matches!(refusal, GrooveError::Crosses { angle_deg } if (angle_deg - 900.0).abs() < 0.26), "{refusal}");
    // Turns beside each other, 18 mm apart along Z, lead to the crossings at the ends of the traverse, but they do not cross.
    let wide = |roller| BarrelGroove::along(closed(6, &traverse(6, 0.05)), roller, (30.0, 25.0), None).unwrap();
    wide(8.8).check_turns(true).unwrap();
    let refusal = wide(9.0).check_turns(true).unwrap_err();
    let GrooveError::NoRib { distance_mm, .. } = refusal else { panic!("{refusal}") };
    // Beside a blend a turn is a little nearer than beside a helix, 18 mm times the cosine of its slope.
    let of_helices_mm = 18.0 * f64::atan2(0.05_f64.to_degrees(), 25.0).cos();
    assert!((of_helices_mm - 0.2..of_helices_mm).contains(&distance_mm), "{refusal}");
    let open = |rise: f64, roller: f64| {
        let course = GrooveCourse::open(steps(3, rise)).unwrap();
        BarrelGroove::along(course, roller, (45.0, 35.0), None).unwrap()
    };
    open(20.0, 8.0).check_turns(false).unwrap();
    open(16.1, 8.0).check_turns(true).unwrap_err();
    // In dwells the distance is the rise; on the flanks the next turn is nearer than along Z by the cosine of the slope.
    let refusal = open(15.0, 8.0).check_turns(true).unwrap_err();
    let GrooveError::NoRib { distance_mm, bound_mm, .. } = &refusal else { panic!("{refusal}") };
    let slope = f64::atan2(2.0 * 15.0 / (0.5 * TURN_RAD), 35.0);
    assert!((bound_mm - 16.0).abs() < 1e-12 && (distance_mm / (15.0 * slope.cos()) - 1.0).abs() < 0.01, "{refusal}");
    let refusal = refusal.to_string();
    assert!(refusal.contains("the rib between its turns vanishes") && refusal.contains("16.000 mm"), "{refusal}");

    // Two rings, and a ring beside grooves that go to and fro.
    let to_and_fro = |amplitude_mm: f64| {
        BarrelGroove::new(&LiftLaw::eccentric_flat(amplitude_mm, 0.0).unwrap(), 8.0, 45.0, 35.0).unwrap()
    };
    let (ring, wave, wide_wave) = (to_and_fro(0.0), to_and_fro(10.0), to_and_fro(20.0));
    placed("A", &ring, 0.0).check_rib_beside(&placed("B", &ring, 16.1)).unwrap();
    let refusal = placed("A", &ring, 0.0).check_rib_beside(&placed("B", &ring, 15.9)).unwrap_err().to_string();
    assert!(refusal.contains("between grooves A and B vanishes") && refusal.contains("15.900 mm"), "{refusal}");
    // A wave that goes 20 mm to both sides leaves ribs between its crossings with the ring; one of 10 mm is in the ring's groove all the time.
    placed("A", &ring, 20.0).check_rib_beside(&placed("W", &wide_wave, 0.0)).unwrap();
    let refusal = placed("A", &ring, 10.0).check_rib_beside(&placed("W", &wave, 0.0)).unwrap_err();
    let GrooveError::NoRib { distance_mm, .. } = &refusal else { panic!("{refusal}") };
    assert!((9.5..=10.0).contains(distance_mm), "{refusal}");
    placed("A", &ring, 30.0).check_rib_beside(&placed("W", &wave, 0.0)).unwrap_err();
    placed("A", &ring, 36.1).check_rib_beside(&placed("W", &wave, 0.0)).unwrap();
    let low = BarrelGroove::new(&LiftLaw::eccentric_flat(0.0, 0.0).unwrap(), 8.0, 35.0, 30.0).unwrap();
    placed("A", &ring, 0.0).check_rib_beside(&placed("B", &low, 1.0)).unwrap();
    // The same groove half a turn behind: two starts, whose ribs are half as wide.
    let even = |rate: f64| {
        let of = [
            (MotionLaw::SepticBlend, 60.0, 30.0 * rate),
            (MotionLaw::ConstantVelocity, 960.0, 960.0 * rate),
            (MotionLaw::SepticBlend, 60.0, 30.0 * rate),
        ];
        let course = GrooveCourse::open(MotionProgram::open(3, 0.0, &segments(&of)).unwrap()).unwrap();
        let faces = EndFaces { from_mm: 25.0, to_mm: 90.0, zero_mm: 0.0 };
        BarrelGroove::along(course, 8.0, (45.0, 35.0), Some(faces)).unwrap()
    };
    placed("A", &even(0.11), 0.0).check_rib_beside(&behind(&even(0.11))).unwrap();
    placed("A", &even(0.085), 0.0).check_rib_beside(&behind(&even(0.085))).unwrap_err();
}

/// A groove of an indexer on a turret of so many stations, from one face to the other.
fn indexer(stations: u32, turns: u32, start_deg: f64) -> BarrelGroove {
    let on = Turret { stations, ..turret(80.0, 76.0, start_deg) };
    let course =
        GrooveCourse::open(steps(turns, rad_from_deg(30.0) * 80.0)).expect("a course").on_turret(on).expect("a turret");
    let faces = EndFaces { from_mm: -32.0, to_mm: 32.0, zero_mm: 0.0 };
    BarrelGroove::along(course, 3.0, (60.0, 45.0), Some(faces)).expect("a groove")
}

/// In a dwell both walls are planes square to the axis, at Z of the roller ± its radius, and the mill stands still.
#[test]
fn a_dwell_of_an_indexer_is_a_plane_ring() {
    let groove = indexer(12, 3, -45.0);
    let path = &groove.paths(mill(3.0, true), 0.0, Coverage::Slot).unwrap()[0];
    let z_mm = 80.0 * rad_from_deg(-15.0).sin();
    let y_mm = 76.0 - 80.0 * rad_from_deg(15.0).cos();
    for deg in (271..450).map(f64::from) {
        let [y, z] = stands(path, rad_from_deg(deg));
        assert!((y - y_mm).abs() < 1e-9 && (z - z_mm).abs() < 1e-9, "{deg}: {y} {z}");
    }
    for side in [-1.0, 1.0] {
        let left = swept(&|_| [y_mm, z_mm], path, (3.0, 3.0), side, TURN_RAD, 50.0);
        assert!(left.abs() < 1e-9, "{left}");
    }
}

/// Every roller in the cylinder needs a groove: one groove serves 12 stations of 30 deg, 24 stations of 15 deg take two.
#[test]
fn rollers_of_a_turret_have_grooves() {
    let one = indexer(12, 3, -45.0);
    placed("A", &one, 0.0).check_rollers(&[placed("A", &one, 0.0)]).unwrap();

    let (a, b) = (indexer(24, 3, -45.0), indexer(24, 4, -60.0));
    let both = [placed("A", &a, 0.0), placed("B", &b, 0.0)];
    let refusal = both[0].check_rollers(&both[..1]).unwrap_err().to_string();
    assert!(refusal.contains("where no groove is; the rollers are 15.0000 deg apart"), "{refusal}");
    both.iter().for_each(|groove| groove.check_rollers(&both).unwrap());
    // The other groove at another place of the part, or turned.
    for wrong in [placed("B", &b, 0.001), PlacedGroove { phase_rad: 0.3, ..placed("B", &b, 0.0) }] {
        both[0].check_rollers(&[both[0], wrong]).unwrap_err();
    }
    // Both turned together.
    let turned = both.map(|groove| PlacedGroove { phase_rad: 1.0, ..groove });
    turned[0].check_rollers(&turned).unwrap();

    let on = |program: MotionProgram, stations| {
        let on = Turret { stations, ..turret(80.0, 76.0, -45.0) };
        GrooveCourse::open(program).unwrap().on_turret(on).unwrap_err().to_string()
    };
    let arc_mm = rad_from_deg(30.0) * 80.0;
    assert_eq!(
        on(steps(3, arc_mm), 11),
        "the lift turns the turret by 30.000000 deg from azimuth 0.00 deg to the same place a turn later; with 11 stations it must be a multiple \
         of 32.727273 deg other than 0"
    );
    assert!(on(steps(1, arc_mm), 11).contains("30.000000 deg from azimuth 0.00 deg"));
    assert_eq!(on(steps(3, arc_mm), 0), "a turret has at least one station");
    let still = MotionProgram::open(2, 0.0, &segments(&[(MotionLaw::Dwell, 720.0, 0.0)])).unwrap();
    assert!(on(still, 12).contains("by 0.000000 deg from azimuth 0.00 deg"));
    // The same step in less time: right from end to end, wrong in between.
    let uneven = [
        (MotionLaw::Dwell, 90.0, 0.0),
        (MotionLaw::Cycloidal, 180.0, arc_mm),
        (MotionLaw::Dwell, 150.0, 0.0),
        (MotionLaw::Cycloidal, 180.0, arc_mm),
        (MotionLaw::Dwell, 120.0, 0.0),
    ];
    let uneven = on(MotionProgram::open(2, 0.0, &segments(&uneven)).unwrap(), 12);
    assert!(uneven.contains("with 12 stations it must be a multiple of 30.000000 deg"), "{uneven}");
}

#[test]
fn what_cannot_be_a_course_is_refused_with_figures() {
    let text = |error: GrooveError| error.to_string();
    let law = LiftLaw::eccentric_flat(10.0, 0.0).unwrap();
    for turns in [0, 51] {
        let refusal = text(GrooveCourse::closed(&law, turns).unwrap_err());
        assert_eq!(refusal, format!("a groove runs over {turns} turns; 1 to 50 are allowed"));
    }
    let shut = MotionProgram::over_turns(2, 0.0, 0.0, &traverse(2, 0.1)).unwrap();
    assert_eq!(text(GrooveCourse::open(shut).unwrap_err()), "the lift of an open groove has two ends; this one closes");
    assert!(LiftLaw::from_program(steps(1, 5.0)).is_err());

    let on = |course: GrooveCourse, turret| text(course.on_turret(turret).unwrap_err());
    let course = || closed(2, &traverse(2, 0.1));
    assert!(on(course(), turret(0.0, 76.0, 0.0)).contains("the radius of the turret is 0 mm"));
    assert!(on(course(), turret(80.0, 0.0, 0.0)).contains("Y of the turret's axis is 0 mm"));
    assert!(on(course(), turret(80.0, f64::NAN, 0.0)).contains("Y of the turret's axis is NaN mm"));
    assert!(on(course(), turret(80.0, 76.0, 80.0)).contains("it must stay below 90 deg on either side"));
    let turned = course().on_turret(turret(80.0, 79.0, 0.0)).unwrap();
    let groove = BarrelGroove::along(turned, 8.0, (45.0, 35.0), None).unwrap();
    let refusal = text(groove.paths(mill(8.0, false), 0.0, Coverage::Slot).unwrap_err());
    assert!(refusal.contains("y_axis: true"), "{refusal}");
    // 30 mm of lift are 0.375 rad; Y = 112 - 80 cos 0.375.
    let far = course().on_turret(turret(80.0, 112.0, 0.0)).unwrap();
    let refusal = text(BarrelGroove::along(far, 8.0, (45.0, 35.0), None).unwrap_err());
    assert!(refusal.starts_with("at azimuth 360.00 deg the roller stands 37.559 mm beside"), "{refusal}");
    assert!(refusal.contains("ends 24.785 mm from the axis"), "{refusal}");

    let faces = |from_mm, to_mm| Some(EndFaces { from_mm, to_mm, zero_mm: 20.0 });
    let groove = |from, to| BarrelGroove::along(course(), 8.0, (45.0, 35.0), faces(from, to)).map(|_| ());
    // 30 mm of lift from Z 20: the walls reach from 12 to 58.
    groove(11.9, 58.1).unwrap();
    let refusal = text(groove(12.5, 60.0).unwrap_err());
    assert!(refusal.contains("from Z 12.000 to 58.000 mm, the end faces lie at 12.5 and 60 mm"), "{refusal}");
    groove(0.0, 57.9).unwrap_err();
    assert!(text(groove(60.0, 0.0).unwrap_err()).contains("the face towards -Z below the other one"));
    groove(f64::NAN, 60.0).unwrap_err();

    let open = |from, to| {
        let course = GrooveCourse::open(steps(2, 30.0)).unwrap();
        BarrelGroove::along(course, 8.0, (45.0, 35.0), faces(from, to)).unwrap()
    };
    open(30.0, 70.0).check_ends(2.0).unwrap();
    let refusal = text(open(29.0, 70.0).check_ends(2.0).unwrap_err());
    assert!(
        refusal.contains("begins at Z 20.000 mm") && refusal.contains("at most at Z 19.000 or at least"),
        "{refusal}"
    );
    let refusal = text(open(30.0, 71.0).check_ends(2.0).unwrap_err());
    assert!(refusal.contains("ends at Z 80.000 mm") && refusal.contains("at least at Z 81.000 mm"), "{refusal}");
    let unknown = BarrelGroove::along(GrooveCourse::open(steps(2, 30.0)).unwrap(), 8.0, (45.0, 35.0), None).unwrap();
    assert_eq!(unknown.check_ends(2.0), Err(GrooveError::NoFaces));
}

#[test]
fn programs_over_several_turns_and_with_ends_are_refused_where_they_are_wrong() {
    let over = |turns, of: &[(MotionLaw, f64, f64)]| {
        MotionProgram::over_turns(turns, 0.0, 0.0, &segments(of)).unwrap_err().to_string()
    };
    let open = |turns, of: &[(MotionLaw, f64, f64)]| MotionProgram::open(turns, 0.0, &segments(of)).unwrap_err();
    assert_eq!(over(3, &[(MotionLaw::Dwell, 360.0, 0.0)]), "the segments cover 360.000000 deg, 3 turns are 1080 deg");
    assert_eq!(over(1, &[(MotionLaw::Dwell, 300.0, 0.0)]), "the segments cover 300.000000 deg, one turn is 360 deg");
    let rise = [(MotionLaw::Dwell, 360.0, 0.0), (MotionLaw::Cycloidal, 360.0, 5.0)];
    assert!(over(2, &rise).starts_with("after 2 turns 5.000000000 mm of lift remain"), "{}", over(2, &rise));
    assert!(over(0, &rise).contains("runs over 0 turns"));
    assert!(MotionProgram::open(2, 0.0, &segments(&rise)).is_ok());
    for (of, number, end) in [
        ([(MotionLaw::ConstantVelocity, 360.0, 5.0), (MotionLaw::SepticBlend, 360.0, 5.0)], 1, "begins"),
        ([(MotionLaw::SepticBlend, 360.0, 5.0), (MotionLaw::ConstantVelocity, 360.0, 5.0)], 2, "ends"),
        ([(MotionLaw::Harmonic, 360.0, 5.0), (MotionLaw::Harmonic, 360.0, 5.0)], 1, "begins"),
    ] {
        match open(2, &of) {
            ProgramError::MovesAtEnd { segment, end: at, .. } => assert_eq!((segment, at), (number, end)),
            other => panic!("{other}"),
        }
    }
    let fall = [(MotionLaw::Dwell, 360.0, 0.0), (MotionLaw::Cycloidal, 360.0, -5.0)];
    assert!(matches!(open(2, &fall), ProgramError::BelowBase { segment: 2, .. }));
    assert!(MotionProgram::open(2, -5.0, &segments(&fall)).is_ok());
}
