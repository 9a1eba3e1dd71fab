// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Cams for tests: lobes of one law, seeded random programs, and printed tables.
#![allow(dead_code, reason = "each test binary uses its part")]

use camwright::cam::contour::{Contour, ContourError};
use camwright::cam::follower::Follower;
use camwright::cam::lift::{
    AngleUnit, LengthUnit, LiftDeclaration, LiftForm, LiftLaw, LiftRow, LiftTable, MotionProgram, MotionSegment,
};
use camwright::cam::motion_law::MotionLaw;
use camwright::job::grinding::{InfeedDirection, ProfileSpec};
use camwright::math::units::{TURN_RAD, rad_from_deg};
use camwright::motion::speed_plan::Cutting;
use camwright::toolpath::wheel_path::ToolPath;

/// The `SplitMix64` generator: the same numbers on every machine.
pub(crate) struct SplitMix64(pub(crate) u64);

impl SplitMix64 {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[usize::try_from(self.next() % choices.len() as u64).expect("a small index")]
    }
}

/// The reference lobe: roller 8.5 mm, base radius 16 mm, lift 6 mm, rise and fall by 3-4-5 polynomials over 62 degrees each, nose at 180
/// degrees.
pub(crate) fn reference_contour() -> Contour {
    let follower = Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 };
    let contour = Contour::from_lift(&lobe(MotionLaw::Polynomial345, 6.0, 62.0), &follower, 16.0);
    contour.expect("a regular contour")
}

/// The path of a wheel on it.
pub(crate) fn reference_lobe(wheel_radius_mm: f64) -> ToolPath {
    ToolPath::for_wheel(&reference_contour(), wheel_radius_mm).expect("the wheel fits")
}

pub(crate) fn segment(law: MotionLaw, angle_rad: f64, rise_mm: f64) -> MotionSegment {
    MotionSegment { law, angle_rad, rise_mm }
}

/// Base centre at 0, nose at 180°, one law on both flanks.
pub(crate) fn lobe_segments(law: MotionLaw, lift_mm: f64, half_angle_deg: f64) -> Vec<MotionSegment> {
    let flank = rad_from_deg(half_angle_deg);
    let dwell = 0.5 * (TURN_RAD - 2.0 * flank);
    vec![
        segment(MotionLaw::Dwell, dwell, 0.0),
        segment(law, flank, lift_mm),
        segment(law, flank, -lift_mm),
        segment(MotionLaw::Dwell, dwell, 0.0),
    ]
}

pub(crate) fn program(start_rad: f64, segments: &[MotionSegment]) -> LiftLaw {
    let program = MotionProgram::new(start_rad, segments).expect("segments that close");
    LiftLaw::from_program(program).expect("a lift above the base circle")
}

pub(crate) fn lobe(law: MotionLaw, lift_mm: f64, half_angle_deg: f64) -> LiftLaw {
    program(0.0, &lobe_segments(law, lift_mm, half_angle_deg))
}

/// A camshaft lobe as engines have them: constant-velocity ramps blended in, a septic flank up to the nose.
pub(crate) fn camshaft_segments() -> Vec<MotionSegment> {
    let half = [
        (MotionLaw::Dwell, 90.0, 0.0),
        (MotionLaw::SepticBlend, 8.0, 0.04),
        (MotionLaw::ConstantVelocity, 12.0, 0.12),
        (MotionLaw::SepticBlend, 70.0, 8.34),
    ];
    let up = half.iter().map(|&(law, deg, rise)| segment(law, rad_from_deg(deg), rise));
    let down = half.iter().rev().map(|&(law, deg, rise)| segment(law, rad_from_deg(deg), -rise));
    up.chain(down).collect()
}

/// Random segments: one to three rises of random laws, dwells between some of them.
pub(crate) fn random_segments(random: &mut SplitMix64) -> Vec<MotionSegment> {
    const LAWS: [MotionLaw; 5] = [
        MotionLaw::Cycloidal,
        MotionLaw::Polynomial345,
        MotionLaw::Polynomial4567,
        MotionLaw::ModifiedSine,
        MotionLaw::ModifiedTrapezoid,
    ];
    let mut segments = Vec::new();
    let mut lift = 0.0;
    for _ in 0..1 + random.next() % 2 {
        segments.push(segment(MotionLaw::Dwell, random.within(0.05, 1.0), 0.0));
        let rise = random.within(0.2, 4.0);
        lift += rise;
        segments.push(segment(random.one_of(&LAWS), random.within(0.8, 1.6), rise));
    }
    if random.next().is_multiple_of(2) {
        segments.push(segment(MotionLaw::Dwell, random.within(0.05, 0.5), 0.0));
    }
    segments.push(segment(random.one_of(&LAWS), random.within(1.2, 2.0), -lift));
    let covered: f64 = segments.iter().map(|segment| segment.angle_rad).sum();
    for segment in &mut segments {
        segment.angle_rad *= TURN_RAD / covered;
    }
    segments
}

/// Random segments from a random angle on, their rises up to so many times as high.
pub(crate) fn random_law(random: &mut SplitMix64, steepest: f64) -> LiftLaw {
    let (start, steepness) = (random.within(0.0, TURN_RAD), random.within(1.0, steepest));
    let mut segments = random_segments(random);
    segments.iter_mut().for_each(|segment| segment.rise_mm *= steepness);
    program(start, &segments)
}

/// The contour of a random lift, `None` where it is undercut, which is then proven by its radius of curvature.
pub(crate) fn contour_unless_undercut(lift: &LiftLaw, follower: &Follower, base_mm: f64, seed: u64) -> Option<Contour> {
    match Contour::from_lift(lift, follower, base_mm) {
        Ok(contour) => Some(contour),
        Err(ContourError::Undercut { radius_of_curvature_mm, .. }) => {
            assert!(radius_of_curvature_mm < 1e-6, "seed {seed}");
            None
        }
        Err(other) => panic!("seed {seed}: {other}"),
    }
}

/// The rows that a law prints to `resolution_mm` at `blocks` equal steps, from line 2 on (line 1 is a header).
pub(crate) fn printed_rows(law: &LiftLaw, blocks: u32, resolution_mm: f64) -> Vec<LiftRow> {
    printed_values(|angle| law.sample(angle).value, blocks, resolution_mm)
}

/// The same of any lift over the cam angle (mm over rad).
pub(crate) fn printed_values(lift: impl Fn(f64) -> f64, blocks: u32, resolution_mm: f64) -> Vec<LiftRow> {
    let per_mm = (1.0 / resolution_mm).round();
    (0..blocks)
        .map(|k| LiftRow {
            line: k as usize + 2,
            angle_deg: Some(360.0 * f64::from(k) / f64::from(blocks)),
            value_mm: (lift(TURN_RAD * f64::from(k) / f64::from(blocks)) * per_mm).round() / per_mm,
        })
        .collect()
}

/// A lobe between dwells as its formula gives it, for laws that make no [`MotionProgram`] there: nose at 180°.
pub(crate) fn lobe_value(law: MotionLaw, lift_mm: f64, half_angle_deg: f64) -> impl Fn(f64) -> f64 {
    let flank = rad_from_deg(half_angle_deg);
    move |angle| lift_mm * law.sample(1.0 - (angle - 0.5 * TURN_RAD).abs() / flank).value
}

pub(crate) fn absolute(resolution_mm: f64) -> LiftDeclaration {
    LiftDeclaration {
        form: LiftForm::Absolute,
        angle_unit: AngleUnit::CamDegrees,
        resolution_mm,
        unit: LengthUnit::Millimetre,
        smooth_within_mm: 0.0,
        lowest_mm: 0.0,
        blocks: None,
    }
}

pub(crate) fn printed(law: &LiftLaw, blocks: u32, resolution_mm: f64) -> LiftTable {
    LiftTable::from_rows(&printed_rows(law, blocks, resolution_mm), &absolute(resolution_mm)).expect("a clean table")
}

/// A cut with an infeed along X; no law that looks at the speed of the wheel's surface.
pub(crate) fn cutting(wheel_radius_mm: f64, infeed_per_turn_mm: f64) -> Cutting {
    Cutting { wheel_radius_mm, wheel_speed_m_s: 80.0, infeed_per_turn_mm, infeed_direction: InfeedDirection::X }
}

/// Profile of a journal of this radius (mm).
pub(crate) fn journal(radius_mm: f64) -> ProfileSpec {
    ProfileSpec {
        name: "journal".into(),
        lift: LiftLaw::eccentric_round(0.0, radius_mm, 0.0).expect("no lift"),
        follower: Follower::KnifeEdge { offset_mm: 0.0 },
        base_radius_mm: radius_mm,
        throw_mm: 0.0,
        is_bore: false,
    }
}
