// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Grooves in plates: closed forms, the mill's disc against both walls point by point, and what is refused.
#![allow(clippy::print_stdout, reason = "figures for the reader of --nocapture")]

use crate::cams;

use cams::{SplitMix64, lobe, program, random_law, segment};
use camwright::cam::follower::{ArmSide, Follower, Pivot, SwingLift};
use camwright::cam::lift::LiftLaw;
use camwright::cam::motion_law::MotionLaw;
use camwright::math::units::{TURN_RAD, rad_from_deg};
use camwright::toolpath::cutter_path::{CarriageAxis, CutterPath};
use camwright::toolpath::groove::plate::PlateGroove;
use camwright::toolpath::groove::{Coverage, GrooveError, Wall};

fn angles(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| TURN_RAD * (f64::from(i) + 0.31) / f64::from(count))
}

fn roller(radius_mm: f64, offset_mm: f64) -> Follower {
    Follower::Roller { radius_mm, offset_mm }
}

/// The roller's centre over the cam angle, put together from lift and follower alone.
fn pitch(lift: &LiftLaw, follower: &Follower, base: f64, angle: f64) -> [f64; 2] {
    let (s, (sin, cos)) = (lift.sample(angle).value, angle.sin_cos());
    match *follower {
        Follower::Roller { radius_mm, offset_mm } => {
            let along = ((base + radius_mm).powi(2) - offset_mm * offset_mm).sqrt() + s;
            [along * cos - offset_mm * sin, along * sin + offset_mm * cos]
        }
        Follower::OscillatingRoller { radius_mm, arm_mm, pivot } => {
            let c = pivot.distance_mm;
            let rest = ((c * c + arm_mm * arm_mm - (base + radius_mm).powi(2)) / (2.0 * c * arm_mm)).acos();
            let SwingLift::Arc { radius_mm: arc } = pivot.lift else { panic!("these tests lift along an arc") };
            let (psi, side) = (rest + s / arc, if pivot.side == ArmSide::Ahead { 1.0 } else { -1.0 });
            let (along, across) = (c - arm_mm * psi.cos(), side * arm_mm * psi.sin());
            [along * cos - across * sin, along * sin + across * cos]
        }
        _ => panic!("no roller"),
    }
}

/// Both walls, by differences of the pitch curve: points a roller's radius, less what is left, to either side.
fn walls(lift: &LiftLaw, follower: &Follower, base: f64, half_width: f64) -> [Vec<[f64; 2]>; 2] {
    const STEP: f64 = 1e-5;
    [-1.0, 1.0].map(|side| {
        angles(30_000)
            .map(|angle| {
                let [before, at, after] =
                    [angle - STEP, angle, angle + STEP].map(|angle| pitch(lift, follower, base, angle));
                let (x, y) = (after[0] - before[0], after[1] - before[1]);
                let length = x.hypot(y);
                [at[0] + side * half_width * y / length, at[1] - side * half_width * x / length]
            })
            .collect()
    })
}

fn centre(path: &CutterPath, azimuth: f64) -> [f64; 2] {
    let x = path.sample(CarriageAxis::X, azimuth).expect("it moves along X").value;
    [x * azimuth.cos(), x * azimuth.sin()]
}

fn nearest(points: &[[f64; 2]], to: [f64; 2]) -> f64 {
    let squares = points.iter().map(|p| (p[0] - to[0]).powi(2) + (p[1] - to[1]).powi(2));
    squares.fold(f64::INFINITY, f64::min).sqrt()
}

/// A mill as wide as the slot runs where the roller runs: X = Rb + rr + s without an offset.
#[test]
fn a_mill_like_the_roller_moves_like_the_roller() {
    let (law, base, radius) = (lobe(MotionLaw::Polynomial4567, 8.0, 80.0), 40.0, 10.0);
    let groove = PlateGroove::new(&law, &roller(radius, 0.0), base).unwrap();
    let paths = groove.paths(radius, 0.0, Coverage::Slot).unwrap();
    let [path] = paths.as_slice() else { panic!("{} paths", paths.len()) };
    assert_eq!((path.name.as_str(), path.infeed, path.travels.len()), ("groove", CarriageAxis::Z, 1));
    for angle in angles(3600) {
        let x = path.sample(CarriageAxis::X, angle).unwrap().value;
        assert!((x - base - radius - law.sample(angle).value).abs() < 2e-9, "{angle}");
    }
}

/// The groove of an eccentric is a ring between two circles, and a smaller mill runs on circles.
#[test]
fn an_eccentric_groove_is_a_ring() {
    let (e, pitch_radius, rr, rc) = (6.0, 50.0, 8.0, 5.0);
    let law = LiftLaw::eccentric_round(e, pitch_radius, 0.0).unwrap();
    let groove = PlateGroove::new(&law, &roller(rr, 0.0), pitch_radius - e - rr).unwrap();
    let paths = groove.paths(rc, 0.5, Coverage::Walls).unwrap();
    assert_eq!(paths.iter().map(|path| path.name.as_str()).collect::<Vec<_>>(), ["inner wall", "outer wall"]);
    for (path, radius) in paths.iter().zip([pitch_radius - 2.5, pitch_radius + 2.5]) {
        for angle in angles(2000) {
            let [x, y] = centre(path, angle);
            assert!(((x - e).hypot(y) - radius).abs() < 2e-9, "{angle}");
        }
    }
    let tightest = groove.tightest(Wall::Inner).unwrap();
    assert!((tightest.value - pitch_radius).abs() < 1e-6 && groove.tightest(Wall::Outer).is_none(), "{tightest:?}");
}

fn random_follower(random: &mut SplitMix64) -> Follower {
    let radius_mm = random.within(3.0, 9.0);
    if random.next().is_multiple_of(2) {
        return roller(radius_mm, random.within(-6.0, 6.0));
    }
    let (arm_mm, side) = (random.within(60.0, 80.0), random.one_of(&[ArmSide::Ahead, ArmSide::Behind]));
    let pivot = Pivot { distance_mm: random.within(80.0, 100.0), side, lift: SwingLift::Arc { radius_mm: arm_mm } };
    Follower::OscillatingRoller { radius_mm, arm_mm, pivot }
}

/// On every path the mill stays within both walls everywhere; the paths along the walls make all of them, and those between leave no
/// material.
#[test]
fn no_path_cuts_into_a_wall_and_nothing_is_left() {
    let mut made = 0;
    for seed in 0..40 {
        let mut random = SplitMix64(seed);
        let law = random_law(&mut random, 3.0);
        let (follower, base) = (random_follower(&mut random), random.within(30.0, 50.0));
        let Ok(groove) = PlateGroove::new(&law, &follower, base) else { continue };
        let leaves = random.one_of(&[0.0, 0.4]);
        let half_width = groove.roller_radius_mm() - leaves;
        let radius = half_width * random.one_of(&[1.0, 0.8, 0.45, 0.2]);
        let walls = walls(&law, &follower, base, half_width);
        let paths = groove.paths(radius, leaves, Coverage::Slot).unwrap();
        let centres: Vec<Vec<[f64; 2]>> =
            paths.iter().map(|path| angles(20_000).map(|angle| centre(path, angle)).collect()).collect();
        for (path, centres) in paths.iter().zip(&centres) {
            for at in centres.iter().step_by(197) {
                for wall in &walls {
                    let gap = nearest(wall, *at) - radius;
                    assert!(gap > -3e-6, "seed {seed}, {}: {gap} at {at:?}", path.name);
                }
            }
        }
        // Centres are up to 0.025 mm apart, so that a place between two of them is seen too far away by (0.025)²/8rc.
        let seen = 3e-6 + 0.025 * 0.025 / (8.0 * radius);
        for (wall, along) in walls.iter().zip([&centres[0], &centres[centres.len() - 1]]) {
            for place in wall.iter().step_by(307) {
                let left = nearest(along, *place) - radius;
                assert!(left.abs() < seen, "seed {seed}: {left} left at {place:?}");
            }
        }
        // Anything in the slot: between the two walls, at any share of the way across.
        for (inner, outer) in walls[0].iter().zip(&walls[1]).step_by(509) {
            let share = random.within(0.0, 1.0);
            let place = [inner[0] + share * (outer[0] - inner[0]), inner[1] + share * (outer[1] - inner[1])];
            let left = centres.iter().map(|centres| nearest(centres, place)).fold(f64::INFINITY, f64::min) - radius;
            assert!(left < seen, "seed {seed}: {left} left at {place:?}");
        }
        made += 1;
    }
    println!("{made} grooves");
    assert!(made > 25, "{made}");
}

/// A groove that is refused as undercut really is: the roller cuts into one of its own walls; and one that is not is not.
#[test]
fn undercut_is_what_the_roller_does_to_its_own_walls() {
    let (mut sound, mut inner, mut outer) = (0, 0, 0);
    for seed in 0..40 {
        let mut random = SplitMix64(1000 + seed);
        let law = random_law(&mut random, 30.0);
        let (follower, base) = (roller(random.within(6.0, 30.0), random.within(-3.0, 3.0)), random.within(10.0, 25.0));
        let Follower::Roller { radius_mm, .. } = follower else { panic!("a roller") };
        let walls = walls(&law, &follower, base, radius_mm);
        let centres: Vec<[f64; 2]> = angles(4000).map(|angle| pitch(&law, &follower, base, angle)).collect();
        let bites: Vec<f64> = (walls.iter())
            .map(|wall| {
                let gaps = wall.iter().step_by(11).map(|place| nearest(&centres, *place) - radius_mm);
                gaps.fold(f64::INFINITY, f64::min)
            })
            .collect();
        match PlateGroove::new(&law, &follower, base) {
            Ok(_) => {
                sound += 1;
                assert!(bites.iter().all(|bite| *bite > -1e-4), "seed {seed}: {bites:?}");
            }
            Err(GrooveError::InnerWall(error)) => {
                inner += 1;
                assert!(bites[0] < 0.0, "seed {seed}: {error}, {bites:?}");
            }
            Err(GrooveError::Undercut { slot_radius_mm, bound_mm, wall, .. }) => {
                outer += 1;
                assert!(
                    bites[1] < 0.0 && slot_radius_mm <= bound_mm + 1e-6,
                    "seed {seed}: {slot_radius_mm}, {bites:?}"
                );
                assert_eq!(wall, "outer wall");
            }
            Err(other) => panic!("seed {seed}: {other}"),
        }
    }
    println!("{sound} sound, {inner} undercut inside, {outer} outside");
    assert!(sound > 5 && inner > 0 && outer > 3, "{sound} sound, {inner} undercut inside, {outer} outside");
}

#[test]
fn what_cannot_be_a_groove_is_refused_with_figures_and_place() {
    let law = lobe(MotionLaw::Polynomial4567, 8.0, 80.0);
    let refusal = |law: &LiftLaw, follower, base| PlateGroove::new(law, &follower, base).unwrap_err().to_string();
    assert_eq!(
        refusal(&law, Follower::Flat, 40.0),
        "a groove guides a roller, on a slide or on an arm; this follower is none"
    );
    assert!(matches!(
        PlateGroove::new(&law, &Follower::KnifeEdge { offset_mm: 0.0 }, 40.0),
        Err(GrooveError::NoRoller)
    ));
    assert_eq!(
        refusal(&law, roller(-3.0, 0.0), 40.0),
        "the inner wall of the groove: roller radius -3 mm is not a positive number"
    );
    assert!(refusal(&law, roller(10.0, 0.0), f64::NAN).starts_with("the inner wall of the groove: base radius NaN"));
    // A nose that is tighter than the roller: the inner wall doubles back.
    let steep = lobe(MotionLaw::Polynomial4567, 20.0, 25.0);
    let inner = refusal(&steep, roller(10.0, 0.0), 20.0);
    assert!(inner.starts_with("the inner wall of the groove: undercut at cam angle 1"), "{inner}");
    // A rise that begins far more quickly than it ends: the flank is hollow more tightly than the roller is round.
    let quick = [
        (MotionLaw::Dwell, 60.0, 0.0),
        (MotionLaw::SepticBlend, 10.0, 5.0),
        (MotionLaw::ConstantVelocity, 10.0, rad_from_deg(10.0) * 60.0),
        (MotionLaw::SepticBlend, 100.0, 50.0),
    ];
    let up = quick.iter().map(|&(law, deg, rise)| segment(law, rad_from_deg(deg), rise));
    let down = quick.iter().rev().map(|&(law, deg, rise)| segment(law, rad_from_deg(deg), -rise));
    let outer = refusal(&program(0.0, &up.chain(down).collect::<Vec<_>>()), roller(30.0, 0.0), 60.0);
    assert!(outer.starts_with("the groove is undercut at its outer wall, at cam angle "), "{outer}");
    assert!(outer.ends_with("mm there, it must be above 30.000 mm"), "{outer}");
}

#[test]
fn a_mill_that_does_not_suit_the_slot_is_refused_with_figures() {
    let law = lobe(MotionLaw::Polynomial4567, 8.0, 80.0);
    let groove = PlateGroove::new(&law, &roller(10.0, 0.0), 40.0).unwrap();
    let refusal = |radius, leaves| groove.paths(radius, leaves, Coverage::Slot).unwrap_err().to_string();
    assert_eq!(
        refusal(10.1, 0.0),
        "a mill of radius 10.1 mm does not go into the groove, whose half width is 10 mm with what is to be left on its walls"
    );
    assert!(refusal(10.0, 0.3).contains("whose half width is 9.7 mm"));
    assert!(refusal(5.0, 12.0).contains("whose half width is -2 mm"));
    assert_eq!(refusal(f64::NAN, 0.0), "the radius of the mill is NaN mm, it must be a positive number");
    assert_eq!(refusal(5.0, -0.1), "what is left on the walls is -0.1 mm, it must be 0 or more");
    let tiny = refusal(1e-9, 0.0);
    assert!(tiny.starts_with("a mill of radius 0.000000001 mm needs 13333333"), "{tiny}");
    assert!(
        tiny.ends_with("paths beside each other in a groove of half width 10 mm; at most 64 are allowed"),
        "{tiny}"
    );
    assert_eq!(groove.paths(0.3, 0.0, Coverage::Walls).unwrap().len(), 2, "walls alone take two");
}
