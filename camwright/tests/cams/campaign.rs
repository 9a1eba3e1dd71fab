// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Random cams, legal and illegal mixed, through everything that is planned of a cam: from a seed to a verdict.

use crate::cams::{SplitMix64, segment};
use camwright::cam::contour::Contour;
use camwright::cam::follower::{ArmSide, Follower, Pivot, SwingLift};
use camwright::cam::inspection::Inspection;
use camwright::cam::lift::{LiftLaw, MotionProgram, MotionSegment};
use camwright::cam::motion_law::MotionLaw;
use camwright::machine::description::MotionLimits;
use camwright::math::hermite::Sample;
use camwright::math::units::{TURN_RAD, rad_from_deg};
use camwright::motion::speed_plan::{TurnRequest, TurnSpeed};
use camwright::toolpath::wheel_path::ToolPath;

/// Verdict on a cam.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Verdict {
    /// Refused, and where.
    Refused(&'static str),
    /// Planned to its end.
    Planned,
    /// Something that must not be.
    Wrong(String),
}

/// Mostly a law that starts and ends at rest, now and then any.
fn law(random: &mut SplitMix64) -> MotionLaw {
    const SMOOTH: [MotionLaw; 5] = [
        MotionLaw::Cycloidal,
        MotionLaw::Polynomial345,
        MotionLaw::Polynomial4567,
        MotionLaw::ModifiedSine,
        MotionLaw::ModifiedTrapezoid,
    ];
    if random.next().is_multiple_of(10) { random.one_of(&MotionLaw::ALL) } else { random.one_of(&SMOOTH) }
}

/// Random segments: most make a cam, some do not.
fn segments(random: &mut SplitMix64) -> (f64, Vec<MotionSegment>) {
    let mut segments = vec![segment(MotionLaw::Dwell, random.within(0.3, 3.0), 0.0)];
    let mut lift = 0.0;
    for _ in 0..1 + random.next() % 3 {
        let rise = random.within(-0.5, 8.0);
        lift += rise;
        segments.push(segment(law(random), random.within(0.25, 1.8), rise));
        if random.next().is_multiple_of(3) {
            segments.push(segment(MotionLaw::Dwell, random.within(0.01, 0.6), 0.0));
        }
    }
    segments.push(segment(law(random), random.within(0.4, 2.0), -lift));
    let covered: f64 = segments.iter().map(|segment| segment.angle_rad).sum();
    // One in twenty does not close.
    let turn = if random.next().is_multiple_of(20) { TURN_RAD * random.within(0.9, 1.1) } else { TURN_RAD };
    for segment in &mut segments {
        segment.angle_rad *= turn / covered;
    }
    (random.within(-1.0, 7.0), segments)
}

fn follower(random: &mut SplitMix64, base_radius_mm: f64) -> Follower {
    let radius_mm = random.within(0.5, 20.0);
    let offset_mm = if random.next().is_multiple_of(2) { 0.0 } else { random.within(-0.5, 0.5) * base_radius_mm };
    let side = if random.next().is_multiple_of(2) { ArmSide::Ahead } else { ArmSide::Behind };
    let arm_mm = random.within(20.0, 120.0);
    let pivot = Pivot { distance_mm: random.within(20.0, 140.0), side, lift: SwingLift::Arc { radius_mm: arm_mm } };
    match random.next() % 8 {
        0 => Follower::KnifeEdge { offset_mm },
        1 | 2 => Follower::Flat,
        3 => Follower::OscillatingRoller { radius_mm, arm_mm, pivot },
        4 => Follower::OscillatingFlat { face_offset_mm: random.within(-5.0, 10.0), pivot },
        5 => Follower::Mushroom { radius_mm: 4.0 * radius_mm },
        _ => Follower::Roller { radius_mm, offset_mm },
    }
}

fn limits(random: &mut SplitMix64, velocity: f64, acceleration: f64, jerk: f64) -> MotionLimits {
    let mut near = |value: f64| value * 10_f64.powf(random.within(-0.7, 0.7));
    MotionLimits { velocity: near(velocity), acceleration: near(acceleration), jerk: near(jerk) }
}

/// One cam.
pub(crate) fn judge(seed: u64) -> Verdict {
    let mut random = SplitMix64(seed);
    let (start_rad, segments) = segments(&mut random);
    let base_radius_mm = random.within(4.0, 45.0);
    let follower = follower(&mut random, base_radius_mm);
    let Ok(program) = MotionProgram::new(start_rad, &segments) else { return Verdict::Refused("segments") };
    let Ok(lift) = LiftLaw::from_program(program) else { return Verdict::Refused("lift") };
    let Ok(contour) = Contour::from_lift(&lift, &follower, base_radius_mm) else { return Verdict::Refused("contour") };
    let back = returns(&contour, &mut random).and_then(|()| rotates(&contour, start_rad, &segments, &mut random));
    if let Err(text) = back {
        return Verdict::Wrong(text);
    }
    let wheel_radius_mm = random.within(8.0, 220.0);
    let Ok(path) = ToolPath::for_wheel(&contour, wheel_radius_mm) else { return Verdict::Refused("wheel") };
    match turns(&path, &mut random) {
        Ok(()) => Verdict::Planned,
        Err(text) => Verdict::Wrong(text),
    }
}

/// The follower that the contour was made for reads its lift again.
fn returns(contour: &Contour, random: &mut SplitMix64) -> Result<(), String> {
    let gauge = Inspection::new(contour, &contour.follower()).map_err(|error| format!("its own gauge: {error}"))?;
    for _ in 0..8 {
        let angle = random.within(0.0, TURN_RAD);
        let wanted = contour.lift().sample(angle).value;
        let read = gauge.read(angle).ok_or_else(|| format!("no reading at {angle}"))?.lift;
        if (read - wanted).abs() > 1e-8 || read.is_nan() {
            return Err(format!("lift {wanted} at {angle} rad comes back as {read}"));
        }
    }
    Ok(())
}

/// Turning the lift turns the contour.
fn rotates(
    contour: &Contour,
    start_rad: f64,
    segments: &[MotionSegment],
    random: &mut SplitMix64,
) -> Result<(), String> {
    let by = random.within(0.1, 6.0);
    let program = MotionProgram::new(start_rad + by, segments).map_err(|error| format!("turned: {error}"))?;
    let lift = LiftLaw::from_program(program).map_err(|error| format!("turned: {error}"))?;
    let turned = Contour::from_lift(&lift, &contour.follower(), contour.base_radius_mm())
        .map_err(|error| format!("turned: {error}"))?;
    for _ in 0..8 {
        let angle = random.within(0.0, TURN_RAD);
        let (a, b) = (contour.point(angle), turned.point(angle + by));
        let there = (a.x * by.cos() - a.y * by.sin(), a.x * by.sin() + a.y * by.cos());
        let off = (there.0 - b.x).hypot(there.1 - b.y);
        if off > 1e-7 || off.is_nan() {
            return Err(format!("turned by {by} rad the point at {angle} rad is {off} mm off"));
        }
    }
    Ok(())
}

/// The fastest turn at a random removal rate under random limits, checked forwards.
fn turns(path: &ToolPath, random: &mut SplitMix64) -> Result<(), String> {
    let c = limits(random, 31.4, 300.0, 3e4);
    let x = limits(random, 500.0, 1e4, 1e6);
    let (rate_mm2_s, infeed_mm) = (10_f64.powf(random.within(-0.5, 1.7)), 10_f64.powf(random.within(-2.5, -0.7)));
    let cutting = crate::cams::cutting(path.wheel_radius_mm(), infeed_mm);
    let ratio = |x: Sample| cutting.removal_rate_ratio_mm2(x);
    let bound = |_: f64, x: Sample| rate_mm2_s / ratio(x);
    let request = TurnRequest { path: path.spline(), infeed_slope_mm_rad: 0.0, bound: &bound, c, x };
    let turn = TurnSpeed::fastest(&request).map_err(|error| format!("no turn: {error}"))?;
    if !(turn.turn_s() >= turn.minimum_s() && turn.turn_s() < 1e6) {
        return Err(format!("a turn of {} s, at least {} s", turn.turn_s(), turn.minimum_s()));
    }
    const POINTS: u32 = 7200;
    let d = TURN_RAD / f64::from(POINTS);
    for i in 0..POINTS {
        let angle = (f64::from(i) + 0.37) * d;
        let (here, sample) = (turn.at(angle), path.sample(angle));
        let (v, a) = (here.speed, here.acceleration);
        let uses = [
            v * ratio(sample) / rate_mm2_s,
            v / c.velocity,
            a.abs() / c.acceleration,
            sample.first.abs() * v / x.velocity,
            (sample.second * v * v + sample.first * a).abs() / x.acceleration,
        ];
        if let Some(max) = uses.iter().find(|use_of| use_of.is_nan() || **use_of > 1.001) {
            return Err(format!("{max} of a limit at {} deg: {uses:?}", rad_from_deg(1.0).recip() * angle));
        }
    }
    Ok(())
}
