// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A lift put together from motion laws, segment by segment over one turn or over several.

use super::error::LowestLift;
use crate::cam::motion_law::MotionLaw;
use crate::math::hermite::Sample;
use crate::math::units::{TURN_RAD, deg_from_rad, wrap_period};
use alloc::vec::Vec;
use thiserror::Error;

/// One segment of a [`MotionProgram`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionSegment {
    /// Motion law of the follower.
    pub law: MotionLaw,
    /// Cam angle it takes (rad), more than 0.
    pub angle_rad: f64,
    /// Change of lift (mm): positive rises, negative falls, 0 for a dwell.
    pub rise_mm: f64,
}

/// Why segments make no lift.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProgramError {
    /// No segments, or too many.
    #[error("a motion program has {count} segments; 1 to {max} are allowed")]
    SegmentCount { count: usize, max: usize },
    /// A number that is not finite, or an angle that is not positive.
    #[error("segment {segment}: {what} is {value}")]
    BadNumber {
        /// Number of the segment, from 1.
        segment: usize,
        what: &'static str,
        value: f64,
    },
    /// A dwell with a rise.
    #[error("segment {segment}: a dwell cannot rise by {rise_mm} mm")]
    DwellRises {
        /// Number of the segment, from 1.
        segment: usize,
        /// Its rise (mm).
        rise_mm: f64,
    },
    /// The angles are not all turns.
    #[error("the segments cover {covered_deg:.6} deg, {}", TurnsOf(*.turns))]
    AngleSpan {
        /// Sum of the angles (deg).
        covered_deg: f64,
        /// Turns that they must cover.
        turns: u32,
    },
    /// A number of turns that is none.
    #[error("a motion program runs over {turns} turns; 1 to {max} are allowed")]
    TurnCount { turns: u32, max: u32 },
    /// The lift after all turns is not the lift before.
    #[error("after {} {misclosure_mm:.9} mm of lift remain; allowed: {bound_mm:e} mm", AfterTurns(*.turns))]
    Misclosure {
        /// Turns of the program.
        turns: u32,
        /// Remaining lift (mm).
        misclosure_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
    /// Lift below the lowest that is declared.
    #[error("after segment {segment} the lift is {lift_mm:.6} mm, below {}", LowestLift(*.lowest_mm))]
    BelowBase {
        /// Number of the segment, from 1.
        segment: usize,
        /// Lift at its end (mm).
        lift_mm: f64,
        /// Lowest lift (mm); 0 is the base circle.
        lowest_mm: f64,
    },
    /// An open program that does not rest at an end.
    #[error(
        "segment {segment} ({law}) {end} with {velocity_mm_rad:.6} mm/rad and {acceleration_mm_rad2:.6} mm/rad2; the lift of an open groove \
         rests at both ends: a dwell there, or a law between dwells"
    )]
    MovesAtEnd {
        /// Number of the segment, from 1.
        segment: usize,
        /// Name of its law.
        law: &'static str,
        /// `begins` or `ends`.
        end: &'static str,
        /// Velocity there (mm/rad).
        velocity_mm_rad: f64,
        /// Acceleration there (mm/rad²).
        acceleration_mm_rad2: f64,
    },
    /// Two segments meet with different velocities.
    #[error(
        "segment {segment} begins at {begins_mm_rad:.6} mm/rad where the one before ends at {ends_mm_rad:.6} mm/rad; \
         a blend between them would take this up"
    )]
    VelocityJump {
        /// Number of the segment, from 1.
        segment: usize,
        /// Velocity at the end of the one before (mm/rad).
        ends_mm_rad: f64,
        /// Velocity at its own start (mm/rad).
        begins_mm_rad: f64,
    },
    /// Two segments meet with different accelerations.
    #[error(
        "segment {segment} ({law}) begins with an acceleration of {begins_mm_rad2:.6} mm/rad2 where the one before \
         ({law_before}) ends with {ends_mm_rad2:.6}: the jerk of the X axis would be unbounded there at any speed; \
         a law whose acceleration vanishes at its ends, or a blend between the two, keeps it finite"
    )]
    AccelerationJump {
        /// Number of the segment, from 1.
        segment: usize,
        /// Name of its law.
        law: &'static str,
        /// Name of the law before.
        law_before: &'static str,
        /// Acceleration at the end of the one before (mm/rad²).
        ends_mm_rad2: f64,
        /// Acceleration at its own start (mm/rad²).
        begins_mm_rad2: f64,
    },
}

/// Length of all turns, for a message.
struct TurnsOf(u32);

impl core::fmt::Display for TurnsOf {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.0 {
            1 => f.write_str("one turn is 360 deg"),
            turns => write!(f, "{turns} turns are {} deg", 360 * u64::from(turns)),
        }
    }
}

/// Number of turns, for a message.
struct AfterTurns(u32);

impl core::fmt::Display for AfterTurns {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.0 {
            1 => f.write_str("one turn"),
            turns => write!(f, "{turns} turns"),
        }
    }
}

/// Most segments of a program.
const MAX_SEGMENTS: usize = 1000;

/// Most turns of a program.
pub const MAX_PROGRAM_TURNS: u32 = 50;

/// Sums of decimal figures of people may be off by this much (rad, mm) and still mean what they say.
const CLOSURE: f64 = 1e-9;

/// Accelerations that meet may differ by this share of the largest of the two segments: blends are solved to some 1e-12.
const ACCELERATION_CLOSURE: f64 = 1e-8;

/// Lift as a chain of motion laws, over one turn or several. Its velocity and acceleration are continuous; its jerk is finite. It closes and
/// repeats, or it has two ends at which it rests.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionProgram {
    start_rad: f64,
    lowest_mm: f64,
    turns: u32,
    is_open: bool,
    pieces: Vec<PlacedSegment>,
}

/// A segment in place: lift(x) for x from its start, up to its length.
#[derive(Debug, Clone, PartialEq)]
struct PlacedSegment {
    begins_rad: f64,
    length_rad: f64,
    lift_mm: f64,
    shape: SegmentShape,
}

#[derive(Debug, Clone, PartialEq)]
enum SegmentShape {
    /// A law between dwells, scaled.
    Law { law: MotionLaw, rise_mm: f64 },
    /// Σ cᵢ uⁱ, u = x/length.
    Polynomial([f64; 8]),
}

impl MotionProgram {
    /// A program whose first segment begins at cam angle `start_rad` with lift 0. Where segments carry nothing over to
    /// their neighbours (laws between dwells), their velocities are 0 there.
    ///
    /// # Errors
    /// Angles that are not one turn, rises that do not close, a lift below the base circle at the end of a segment,
    /// velocities or accelerations that do not meet, numbers that are not finite.
    pub fn new(start_rad: f64, segments: &[MotionSegment]) -> Result<Self, ProgramError> {
        Self::above(0.0, start_rad, segments)
    }

    /// The same with lifts down to `lowest_mm`, which is not above 0.
    ///
    /// # Errors
    /// See [`MotionProgram::new`]; a lowest lift above 0.
    pub fn above(lowest_mm: f64, start_rad: f64, segments: &[MotionSegment]) -> Result<Self, ProgramError> {
        Self::build((1, false), lowest_mm, start_rad, segments)
    }

    /// The same over so many turns, after which it closes.
    ///
    /// # Errors
    /// See [`MotionProgram::above`]; no turns, or too many.
    pub fn over_turns(
        turns: u32,
        lowest_mm: f64,
        start_rad: f64,
        segments: &[MotionSegment],
    ) -> Result<Self, ProgramError> {
        Self::build((turns, false), lowest_mm, start_rad, segments)
    }

    /// A program over so many turns that begins at angle 0 with lift 0 and ends with another lift. It rests before its first segment and
    /// after its last one.
    ///
    /// # Errors
    /// See [`MotionProgram::over_turns`]; a first or last segment that is not at rest where it begins or ends.
    pub fn open(turns: u32, lowest_mm: f64, segments: &[MotionSegment]) -> Result<Self, ProgramError> {
        Self::build((turns, true), lowest_mm, 0.0, segments)
    }

    fn build(
        (turns, is_open): (u32, bool),
        lowest_mm: f64,
        start_rad: f64,
        segments: &[MotionSegment],
    ) -> Result<Self, ProgramError> {
        if !(1..=MAX_PROGRAM_TURNS).contains(&turns) {
            return Err(ProgramError::TurnCount { turns, max: MAX_PROGRAM_TURNS });
        }
        if !lowest_mm.is_finite() || lowest_mm > 0.0 {
            return Err(ProgramError::BadNumber { segment: 1, what: "the lowest lift", value: lowest_mm });
        }
        if segments.is_empty() || segments.len() > MAX_SEGMENTS {
            return Err(ProgramError::SegmentCount { count: segments.len(), max: MAX_SEGMENTS });
        }
        if !start_rad.is_finite() {
            return Err(ProgramError::BadNumber { segment: 1, what: "the start angle", value: start_rad });
        }
        let mut pieces = Vec::with_capacity(segments.len());
        let (mut angle, mut lift) = (0.0, 0.0);
        for (i, segment) in segments.iter().enumerate() {
            let number = i + 1;
            if !segment.angle_rad.is_finite() || segment.angle_rad <= 0.0 {
                let what = "the angle";
                return Err(ProgramError::BadNumber { segment: number, what, value: segment.angle_rad });
            }
            if !segment.rise_mm.is_finite() {
                return Err(ProgramError::BadNumber { segment: number, what: "the rise", value: segment.rise_mm });
            }
            if segment.law == MotionLaw::Dwell && segment.rise_mm.abs() > 0.0 {
                return Err(ProgramError::DwellRises { segment: number, rise_mm: segment.rise_mm });
            }
            pieces.push(PlacedSegment {
                begins_rad: angle,
                length_rad: segment.angle_rad,
                lift_mm: lift,
                shape: SegmentShape::Law { law: segment.law, rise_mm: segment.rise_mm },
            });
            angle += segment.angle_rad;
            lift += segment.rise_mm;
            if lift < lowest_mm - CLOSURE {
                return Err(ProgramError::BelowBase { segment: number, lift_mm: lift, lowest_mm });
            }
        }
        if (angle - f64::from(turns) * TURN_RAD).abs() > CLOSURE {
            return Err(ProgramError::AngleSpan { covered_deg: deg_from_rad(angle), turns });
        }
        if lift.abs() > CLOSURE && !is_open {
            return Err(ProgramError::Misclosure { turns, misclosure_mm: lift, bound_mm: CLOSURE });
        }
        // The neighbours of the first and of the last segment of an open program are dwells.
        let has_before = |i: usize| !is_open || i > 0;
        let has_after = |i: usize| !is_open || i + 1 < segments.len();
        let fixed = pieces.clone();
        for (i, piece) in pieces.iter_mut().enumerate() {
            let SegmentShape::Law { law, rise_mm } = piece.shape else { continue };
            if law.is_blend() {
                let before = &fixed[(i + fixed.len() - 1) % fixed.len()];
                let after = &fixed[(i + 1) % fixed.len()];
                let before = if has_before(i) { before.brings(before.length_rad) } else { Sample::default() };
                let after = if has_after(i) { after.brings(0.0) } else { Sample::default() };
                piece.shape = SegmentShape::Polynomial(blend(law, piece.length_rad, rise_mm, before, after));
            }
        }
        if is_open {
            Self::check_ends(&pieces, segments)?;
        }
        for i in (0..pieces.len()).filter(|i| has_before(*i)) {
            let before = &pieces[(i + pieces.len() - 1) % pieces.len()];
            let (ends, begins) = (before.sample(before.length_rad).first, pieces[i].sample(0.0).first);
            if (ends - begins).abs() > CLOSURE * (1.0 + ends.abs()) {
                let (ends_mm_rad, begins_mm_rad) = (ends, begins);
                return Err(ProgramError::VelocityJump { segment: i + 1, ends_mm_rad, begins_mm_rad });
            }
        }
        for i in (0..pieces.len()).filter(|i| has_before(*i)) {
            let earlier = (i + pieces.len() - 1) % pieces.len();
            let (before, piece) = (&pieces[earlier], &pieces[i]);
            let (ends_mm_rad2, begins_mm_rad2) = (before.sample(before.length_rad).second, piece.sample(0.0).second);
            let scale = 1.0 + before.largest_acceleration().max(piece.largest_acceleration());
            if (ends_mm_rad2 - begins_mm_rad2).abs() > ACCELERATION_CLOSURE * scale {
                let (law, law_before) = (segments[i].law.name(), segments[earlier].law.name());
                let segment = i + 1;
                return Err(ProgramError::AccelerationJump { segment, law, law_before, ends_mm_rad2, begins_mm_rad2 });
            }
        }
        Ok(Self { start_rad, lowest_mm, turns, is_open, pieces })
    }

    /// Refuses an open program that moves at one of its ends.
    fn check_ends(pieces: &[PlacedSegment], segments: &[MotionSegment]) -> Result<(), ProgramError> {
        let ends = [(0, 0.0), (pieces.len() - 1, 1.0)];
        for (index, share) in ends {
            let piece = &pieces[index];
            let there = piece.sample(share * piece.length_rad);
            let law = segments[index].law.name();
            let closes = there.first.abs() <= CLOSURE;
            if !closes || there.second.abs() > ACCELERATION_CLOSURE * (1.0 + piece.largest_acceleration()) {
                return Err(ProgramError::MovesAtEnd {
                    segment: index + 1,
                    law,
                    end: if share > 0.0 { "ends" } else { "begins" },
                    velocity_mm_rad: there.first,
                    acceleration_mm_rad2: there.second,
                });
            }
        }
        Ok(())
    }

    /// Turns over which it runs.
    #[must_use]
    pub fn turns(&self) -> u32 {
        self.turns
    }

    /// Returns whether it has two ends; else it closes after its turns.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.is_open
    }

    /// Angle over which it runs (rad).
    #[must_use]
    pub fn span_rad(&self) -> f64 {
        f64::from(self.turns) * TURN_RAD
    }

    /// Lowest lift that the program may have (mm).
    #[must_use]
    pub fn lowest_mm(&self) -> f64 {
        self.lowest_mm
    }

    /// Lift and derivatives at a cam angle (mm over rad); beyond the ends of an open program those of the nearer end.
    #[must_use]
    pub fn sample(&self, angle_rad: f64) -> Sample {
        let x = angle_rad - self.start_rad;
        let x = if self.is_open { x.clamp(0.0, self.span_rad()) } else { wrap_period(x, self.span_rad()) };
        let index = self.pieces.partition_point(|piece| piece.begins_rad <= x).max(1) - 1;
        let piece = &self.pieces[index];
        piece.sample(x - piece.begins_rad)
    }

    /// Cam angles at which segments meet (rad); acceleration or jerk may jump there.
    pub fn joints(&self) -> impl Iterator<Item = f64> {
        self.pieces.iter().map(|piece| wrap_period(self.start_rad + piece.begins_rad, self.span_rad()))
    }
}

impl PlacedSegment {
    fn sample(&self, x: f64) -> Sample {
        let per_rad = 1.0 / self.length_rad;
        let u = (x * per_rad).clamp(0.0, 1.0);
        let (normal, scale) = match &self.shape {
            SegmentShape::Law { law, rise_mm } => (law.sample(u), *rise_mm),
            SegmentShape::Polynomial(c) => (polynomial(c, u), 1.0),
        };
        Sample {
            value: self.lift_mm + scale * normal.value,
            first: scale * normal.first * per_rad,
            second: scale * normal.second * per_rad * per_rad,
            third: scale * normal.third * per_rad * per_rad * per_rad,
        }
    }

    /// Roughly, from seventeen places: a scale for rounding.
    fn largest_acceleration(&self) -> f64 {
        (0..=16).map(|i| self.sample(self.length_rad * f64::from(i) / 16.0).second.abs()).fold(0.0, f64::max)
    }

    /// Boundary condition that this piece imposes on an adjacent blend; two blends meet at rest.
    fn brings(&self, x: f64) -> Sample {
        match self.shape {
            SegmentShape::Law { law, .. } if !law.is_blend() => self.sample(x),
            _ => Sample::default(),
        }
    }
}

/// Coefficients over u of the Hermite polynomial from 0 to `rise` with given velocity and acceleration at both ends; a
/// septic has no jerk at either.
fn blend(law: MotionLaw, length: f64, rise: f64, before: Sample, after: Sample) -> [f64; 8] {
    let (c1, c2) = (before.first * length, 0.5 * before.second * length * length);
    let d0 = rise - c1 - c2;
    let d1 = after.first * length - c1 - 2.0 * c2;
    let d2 = after.second * length * length - 2.0 * c2;
    if law == MotionLaw::QuinticBlend {
        let c3 = 10.0 * d0 - 4.0 * d1 + 0.5 * d2;
        let c4 = -15.0 * d0 + 7.0 * d1 - d2;
        let c5 = 6.0 * d0 - 3.0 * d1 + 0.5 * d2;
        [0.0, c1, c2, c3, c4, c5, 0.0, 0.0]
    } else {
        let c4 = 35.0 * d0 - 15.0 * d1 + 2.5 * d2;
        let c5 = -84.0 * d0 + 39.0 * d1 - 7.0 * d2;
        let c6 = 70.0 * d0 - 34.0 * d1 + 6.5 * d2;
        let c7 = -20.0 * d0 + 10.0 * d1 - 2.0 * d2;
        [0.0, c1, c2, 0.0, c4, c5, c6, c7]
    }
}

/// Value and derivatives over u, by Horner's rule.
fn polynomial(c: &[f64; 8], u: f64) -> Sample {
    let mut sample = Sample::default();
    for &coefficient in c.iter().rev() {
        sample.third = sample.third * u + 3.0 * sample.second;
        sample.second = sample.second * u + 2.0 * sample.first;
        sample.first = sample.first * u + sample.value;
        sample.value = sample.value * u + coefficient;
    }
    sample
}
