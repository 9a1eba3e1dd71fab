// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The lift law: lift and its derivatives at any cam angle, with what it was made from.

use super::program::{MotionProgram, ProgramError};
use super::reading::{TableMethod, TableReading};
use super::table::LiftTable;
use crate::cam::outline::Outline;
use crate::math::extremum::smallest_over_turn;
use crate::math::periodic_cubic::PeriodicCubic;
use crate::math::periodic_spline::{PeriodicSpline, Sample};
use crate::math::tube::{TubeError, smoothest_within};
use crate::math::units::{TURN_RAD, deg_from_rad, wrap_turn};
use alloc::boxed::Box;
use alloc::vec::Vec;
use thiserror::Error;

/// Why there is no lift law.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LiftLawError {
    /// The table has no curve within half a digit, in this arithmetic.
    #[error("no curve within half a digit of the table: {0}")]
    NoCurve(#[from] TubeError),
    /// A smoothing tolerance that is none.
    #[error(
        "smoothing within {tolerance_mm} mm asks for less than reading the table does: within half a digit, \
         {half_digit_mm} mm"
    )]
    ToleranceTooSmall {
        /// Requested tolerance (mm).
        tolerance_mm: f64,
        /// Half the table's resolution (mm).
        half_digit_mm: f64,
    },
    /// Segments that make no lift.
    #[error(transparent)]
    Program(#[from] ProgramError),
    /// A program that does not close.
    #[error("a lift law closes after its turns; these segments have two ends")]
    HasEnds,
    /// A number of a formula is out of its range.
    #[error("{what} is {value}, it must be {bound}")]
    BadNumber {
        what: &'static str,
        value: f64,
        /// Condition that it violates.
        bound: &'static str,
    },
    /// A formula gives a value that is not finite.
    #[error("the lift at {angle_deg:.4} deg is not a finite number")]
    NotFinite {
        /// Cam angle (deg).
        angle_deg: f64,
    },
    /// A sampled formula is not smooth enough for a spline.
    #[error("{knots} knots leave {error_mm:e} mm between them; allowed: {bound_mm:e} mm")]
    Unresolved {
        /// Largest number of knots tried.
        knots: usize,
        /// Remaining error (mm).
        error_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
    /// The lift falls below the base circle.
    #[error("the lift at {angle_deg:.3} deg is {lift_mm:.6} mm, below the base circle by more than {bound_mm} mm")]
    BelowBase {
        /// Cam angle (deg).
        angle_deg: f64,
        /// Lift (mm).
        lift_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
}

#[derive(Debug, Clone, PartialEq)]
enum LawShape {
    Spline(PeriodicSpline),
    Cubic(PeriodicCubic),
    Program(MotionProgram),
    Outline(Outline),
    EccentricFlat { eccentricity_mm: f64, nose_rad: f64 },
    EccentricRound { eccentricity_mm: f64, pitch_radius_mm: f64, nose_rad: f64 },
    Conjugate { of: Box<LiftLaw>, ratio: f64, at_rad: f64 },
}

/// Lift over the cam angle, periodic over one turn: s (mm) and its derivatives (mm/rad, …).
#[derive(Debug, Clone, PartialEq)]
pub struct LiftLaw {
    shape: LawShape,
    min_lift_mm: f64,
    max_lift_mm: f64,
    reading: Option<TableReading>,
}

/// A sampled formula is resolved when the spline between its knots is right to this (mm): a hundredth of what the
/// contour promises.
const SAMPLED_ERROR_MM: f64 = 1e-10;

/// Knots tried for a sampled formula, doubling.
const SAMPLED_KNOTS: (usize, usize) = (360, 46_080);

/// Depth that a formula may fall below the base circle (mm): rounding only.
const BELOW_BASE_MM: f64 = 1e-9;

impl LiftLaw {
    /// The smoothest periodic curve (least ∫ s‴² dφ) within half a digit of every point of a table: a periodic quintic
    /// spline with a knot at each. That is reading the table, not smoothing it: any curve within half a digit prints
    /// the same table, and the one through the rounded figures themselves has hundreds of times the true jerk.
    ///
    /// # Errors
    /// If evaluation of the result at every point does not confirm it.
    pub fn from_table(table: &LiftTable) -> Result<Self, LiftLawError> {
        Self::read_table(table, TableMethod::Smoothest)
    }

    /// A table read in a way of one's choice.
    ///
    /// # Errors
    /// If evaluation of the result at every point does not confirm it; a smoothing tolerance below half a digit.
    pub fn read_table(table: &LiftTable, reading: TableMethod) -> Result<Self, LiftLawError> {
        let half_digit_mm = 0.5 * table.resolution_mm();
        let (points, within_mm) = match reading {
            TableMethod::Smoothest => {
                (table.lifts_mm().into_iter().map(|lift| (lift, half_digit_mm)).unzip(), half_digit_mm)
            }
            TableMethod::CubicSpline => {
                let spline = PeriodicCubic::interpolate(table.lifts_mm()).ok_or(TubeError::NotFinite { index: 0 })?;
                let mut law = Self::new(LawShape::Cubic(spline), f64::INFINITY)?;
                law.reading = Some(TableReading::measure(&law, table, reading, 0.0));
                return Ok(law);
            }
            TableMethod::SmoothWithin { tolerance_mm } if tolerance_mm.is_finite() && tolerance_mm >= half_digit_mm => {
                (smoothing_tubes(table, tolerance_mm), tolerance_mm)
            }
            TableMethod::SmoothWithin { tolerance_mm } => {
                return Err(LiftLawError::ToleranceTooSmall { tolerance_mm, half_digit_mm });
            }
        };
        let (values, half_widths): (Vec<f64>, Vec<f64>) = points;
        let tube = smoothest_within(&values, &half_widths)?;
        let mut law = Self::new(LawShape::Spline(tube.spline), f64::INFINITY)?;
        law.reading = Some(TableReading {
            relative_gap: tube.relative_gap,
            iterations: tube.iterations,
            ..TableReading::measure(&law, table, reading, within_mm)
        });
        Ok(law)
    }

    /// Motion laws one after the other, evaluated exactly. A program over several turns is read over its share of them: one turn of the law
    /// is all of them.
    ///
    /// # Errors
    /// A blend that falls below the lowest lift of the program between its ends; a program with two ends.
    pub fn from_program(program: MotionProgram) -> Result<Self, LiftLawError> {
        if program.is_open() {
            return Err(LiftLawError::HasEnds);
        }
        let below_base_mm = BELOW_BASE_MM - program.lowest_mm();
        Self::new(LawShape::Program(program), below_base_mm)
    }

    /// Distance of an outline from the axis, above its smallest: the lift of a knife edge on the cam's centre line.
    ///
    /// # Errors
    /// An outline that falls below its smallest distance by more than rounding.
    pub fn from_outline(outline: Outline) -> Result<Self, LiftLawError> {
        Self::new(LawShape::Outline(outline), BELOW_BASE_MM)
    }

    /// A formula of period 2π, sampled so densely that the spline between the samples is right to 1e-10 mm.
    ///
    /// # Errors
    /// Values that are not finite, a formula with corners, a lift below the base circle.
    pub fn from_fn(formula: impl Fn(f64) -> f64) -> Result<Self, LiftLawError> {
        Self::sampled(formula, BELOW_BASE_MM)
    }

    /// The same for a formula that may fall below the base circle by so much, as the reading of a printed table may.
    pub(crate) fn sampled(formula: impl Fn(f64) -> f64, below_base_mm: f64) -> Result<Self, LiftLawError> {
        let at = |i: usize, count: usize| i as f64 * TURN_RAD / count as f64;
        let mut knots = SAMPLED_KNOTS.0;
        loop {
            let values: Vec<f64> = (0..knots).map(|i| formula(at(i, knots))).collect();
            let spline = PeriodicSpline::interpolate(&values).map_err(|_| {
                let index = values.iter().position(|value| !value.is_finite()).unwrap_or(0);
                LiftLawError::NotFinite { angle_deg: deg_from_rad(at(index, knots)) }
            })?;
            let error_mm = (0..knots)
                .map(|i| at(2 * i + 1, 2 * knots))
                .map(|angle| (spline.sample(angle).value - formula(angle)).abs())
                .fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) });
            if error_mm <= SAMPLED_ERROR_MM {
                return Self::new(LawShape::Spline(spline), below_base_mm);
            }
            if 2 * knots > SAMPLED_KNOTS.1 {
                return Err(LiftLawError::Unresolved { knots, error_mm, bound_mm: SAMPLED_ERROR_MM });
            }
            knots *= 2;
        }
    }

    /// Motion of a flat follower on a disc: s = e(1 + cos(φ − nose)). Base radius: disc radius − e.
    ///
    /// # Errors
    /// Numbers that are not finite, a negative eccentricity.
    pub fn eccentric_flat(eccentricity_mm: f64, nose_rad: f64) -> Result<Self, LiftLawError> {
        finite_eccentric(eccentricity_mm, nose_rad)?;
        Self::new(LawShape::EccentricFlat { eccentricity_mm, nose_rad }, BELOW_BASE_MM)
    }

    /// Motion of a roller on the cam's centre line on a disc: s = e cos γ + √(p² − e² sin² γ) − (p − e), γ = φ − nose,
    /// p = disc radius + roller radius (the disc radius alone for a knife edge). Base radius: disc radius − e.
    ///
    /// # Errors
    /// Numbers that are not finite, an eccentricity that is negative or not below p.
    pub fn eccentric_round(eccentricity_mm: f64, pitch_radius_mm: f64, nose_rad: f64) -> Result<Self, LiftLawError> {
        finite_eccentric(eccentricity_mm, nose_rad)?;
        if !pitch_radius_mm.is_finite() || pitch_radius_mm <= eccentricity_mm {
            let (what, bound) = ("the pitch radius (mm)", "larger than the eccentricity");
            return Err(LiftLawError::BadNumber { what, value: pitch_radius_mm, bound });
        }
        Self::new(LawShape::EccentricRound { eccentricity_mm, pitch_radius_mm, nose_rad }, BELOW_BASE_MM)
    }

    /// Lift of the second cam of a conjugate pair, whose follower is joined to that of this law: `ratio·(h − s(φ − at))` with the largest
    /// lift h of this law. The second follower rests on its base circle where the first has its largest lift.
    ///
    /// `at_rad` is the azimuth of the second follower seen from the first: π for rollers on opposite sides of a slide, 0 for two arms on one
    /// pivot. `ratio` is the lift of the second follower per lift of the first: 1 on a slide, the ratio of the arcs on two arms.
    ///
    /// # Errors
    /// Numbers that are not finite, a ratio that is not positive.
    pub fn conjugate(&self, ratio: f64, at_rad: f64) -> Result<Self, LiftLawError> {
        if !ratio.is_finite() || ratio <= 0.0 {
            let (what, bound) = ("the ratio of the lifts", "finite and positive");
            return Err(LiftLawError::BadNumber { what, value: ratio, bound });
        }
        if !at_rad.is_finite() {
            let (what, bound) = ("the azimuth of the second follower (rad)", "finite");
            return Err(LiftLawError::BadNumber { what, value: at_rad, bound });
        }
        Self::new(LawShape::Conjugate { of: Box::new(self.clone()), ratio, at_rad }, BELOW_BASE_MM)
    }

    fn new(shape: LawShape, below_base_mm: f64) -> Result<Self, LiftLawError> {
        let mut law = Self { shape, min_lift_mm: 0.0, max_lift_mm: 0.0, reading: None };
        let min = smallest_over_turn(law.grid(), &law.breaks(), |angle| law.sample(angle).value);
        if min.value.is_nan() || min.value < -below_base_mm {
            let angle_deg = deg_from_rad(min.angle_rad);
            return Err(LiftLawError::BelowBase { angle_deg, lift_mm: min.value, bound_mm: below_base_mm });
        }
        law.min_lift_mm = min.value;
        law.max_lift_mm = -smallest_over_turn(law.grid(), &law.breaks(), |angle| -law.sample(angle).value).value;
        Ok(law)
    }

    /// Lift (mm) and its derivatives (mm/rad, mm/rad², mm/rad³) at a cam angle (rad).
    #[must_use]
    pub fn sample(&self, angle_rad: f64) -> Sample {
        match &self.shape {
            LawShape::Spline(spline) => spline.sample(angle_rad),
            LawShape::Cubic(spline) => spline.sample(angle_rad),
            LawShape::Program(program) if program.turns() == 1 => program.sample(angle_rad),
            LawShape::Program(program) => stretched(program, angle_rad),
            LawShape::Outline(outline) => outline.sample(angle_rad),
            LawShape::EccentricFlat { eccentricity_mm: e, nose_rad } => {
                let (sin, cos) = (libm::sin(angle_rad - nose_rad), libm::cos(angle_rad - nose_rad));
                Sample { value: e * (1.0 + cos), first: -e * sin, second: -e * cos, third: e * sin }
            }
            LawShape::EccentricRound { eccentricity_mm: e, pitch_radius_mm: p, nose_rad } => {
                let (sin, cos) = (libm::sin(angle_rad - nose_rad), libm::cos(angle_rad - nose_rad));
                let root = libm::sqrt(p * p - e * e * sin * sin);
                // With q = root²: q' = −2e² sin cos, q'' = −2e²(cos² − sin²), q''' = 8e² sin cos.
                let (q1, q2, q3) =
                    (-2.0 * e * e * sin * cos, -2.0 * e * e * (cos * cos - sin * sin), 8.0 * e * e * sin * cos);
                let root1 = q1 / (2.0 * root);
                let root2 = (0.5 * q2 - root1 * root1) / root;
                let root3 = (0.5 * q3 - 3.0 * root1 * root2) / root;
                Sample {
                    value: e * cos + root - (p - e),
                    first: -e * sin + root1,
                    second: -e * cos + root2,
                    third: e * sin + root3,
                }
            }
            LawShape::Conjugate { of, ratio, at_rad } => {
                let first = of.sample(angle_rad - at_rad);
                Sample {
                    value: ratio * (of.max_lift_mm - first.value),
                    first: -ratio * first.first,
                    second: -ratio * first.second,
                    third: -ratio * first.third,
                }
            }
        }
    }

    /// Smallest lift (mm): below 0 where the cam has a pocket in its base circle.
    #[must_use]
    pub fn min_lift_mm(&self) -> f64 {
        self.min_lift_mm
    }

    /// Largest lift (mm).
    #[must_use]
    pub fn max_lift_mm(&self) -> f64 {
        self.max_lift_mm
    }

    /// Fidelity of the reading of a table; `None` if the law is a formula.
    #[must_use]
    pub fn reading(&self) -> Option<TableReading> {
        self.reading
    }

    /// Largest size of the third derivative (mm/rad³): the jerk of the follower at 1 rad/s.
    #[must_use]
    pub fn peak_jerk_mm_rad3(&self) -> f64 {
        -smallest_over_turn(2 * self.grid(), &self.breaks(), |angle| -self.sample(angle).third.abs()).value
    }

    /// The law as a spline, where it is one.
    #[must_use]
    pub fn spline(&self) -> Option<&PeriodicSpline> {
        match &self.shape {
            LawShape::Spline(spline) => Some(spline),
            _ => None,
        }
    }

    /// Cam angles at which acceleration or jerk may jump (rad).
    #[must_use]
    pub fn breaks(&self) -> Vec<f64> {
        match &self.shape {
            LawShape::Program(program) => {
                program.joints().map(|joint_rad| joint_rad / f64::from(program.turns())).collect()
            }
            LawShape::Outline(outline) => outline.breaks(),
            LawShape::Cubic(spline) => {
                (0..spline.knots()).map(|knot| knot as f64 * TURN_RAD / spline.knots() as f64).collect()
            }
            LawShape::Conjugate { of, at_rad, .. } => {
                of.breaks().into_iter().map(|angle_rad| wrap_turn(angle_rad + at_rad)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Steps of a grid over one turn that sees every feature of the law: at least two per knot.
    #[must_use]
    pub fn grid(&self) -> usize {
        const MIN_STEPS: usize = 7200;
        match &self.shape {
            LawShape::Spline(spline) => (2 * spline.coefficients().len()).max(MIN_STEPS),
            LawShape::Cubic(spline) => (2 * spline.knots()).max(MIN_STEPS),
            LawShape::Outline(outline) => outline.grid(),
            LawShape::Conjugate { of, .. } => of.grid(),
            LawShape::Program(program) => MIN_STEPS * usize::try_from(program.turns()).unwrap_or(1),
            _ => MIN_STEPS,
        }
    }
}

/// A program over several turns, read over its share of them.
fn stretched(program: &MotionProgram, angle_rad: f64) -> Sample {
    let turns = f64::from(program.turns());
    let sample = program.sample(turns * angle_rad);
    Sample {
        value: sample.value,
        first: turns * sample.first,
        second: turns * turns * sample.second,
        third: turns * turns * turns * sample.third,
    }
}

fn finite_eccentric(eccentricity_mm: f64, nose_rad: f64) -> Result<(), LiftLawError> {
    if !eccentricity_mm.is_finite() || eccentricity_mm < 0.0 {
        let (what, bound) = ("the eccentricity (mm)", "finite and not negative");
        return Err(LiftLawError::BadNumber { what, value: eccentricity_mm, bound });
    }
    if !nose_rad.is_finite() {
        let (what, bound) = ("the angle of the nose (rad)", "finite");
        return Err(LiftLawError::BadNumber { what, value: nose_rad, bound });
    }
    Ok(())
}

impl TableReading {
    /// Measures a law against the points of its table; solver's figures are added by who has them.
    fn measure(law: &LiftLaw, table: &LiftTable, reading: TableMethod, allowed_mm: f64) -> Self {
        let (mut max_deviation_mm, mut max_deviation_rad, mut squares) = (0.0, 0.0, 0.0);
        for block in 0..table.blocks() {
            let angle = block as f64 * table.block_rad();
            let deviation = (law.sample(angle).value - table.lift_mm(block)).abs();
            squares += deviation * deviation;
            if deviation > max_deviation_mm {
                (max_deviation_mm, max_deviation_rad) = (deviation, angle);
            }
        }
        let rms_deviation_mm = libm::sqrt(squares / table.blocks() as f64);
        Self {
            reading,
            half_digit_mm: 0.5 * table.resolution_mm(),
            allowed_mm,
            max_deviation_mm,
            max_deviation_rad,
            rms_deviation_mm,
            peak_jerk_mm_rad3: law.peak_jerk_mm_rad3(),
            relative_gap: 0.0,
            iterations: 0,
        }
    }
}

/// Centre and half width of what smoothing within a tolerance allows at each point (mm). The base circle keeps its place: a point on it
/// moves by half a digit, one below it moves up to it, and none of the others falls more than half a digit below.
fn smoothing_tubes(table: &LiftTable, tolerance_mm: f64) -> (Vec<f64>, Vec<f64>) {
    let half = 0.5 * table.resolution_mm();
    let tube = |lift: f64| {
        let (low, high) = if lift > half {
            ((lift - tolerance_mm).max(-half), lift + tolerance_mm)
        } else if lift >= -half {
            (lift - half, lift + half)
        } else {
            let high = (lift + tolerance_mm).min(half);
            let low = (lift - tolerance_mm).max(table.lowest_mm - half);
            (low.min(high - 0.1 * half), high)
        };
        (0.5 * (low + high), 0.5 * (high - low))
    };
    table.lifts_mm().into_iter().map(tube).unzip()
}

/// The table read in the ways that were not chosen, to compare their jerk.
///
/// # Errors
/// A table that cannot be read one of the ways.
pub fn alternatives(table: &LiftTable, chosen: TableMethod) -> Result<Vec<TableReading>, LiftLawError> {
    [TableMethod::Smoothest, TableMethod::CubicSpline]
        .into_iter()
        .filter(|reading| *reading != chosen)
        .filter_map(|reading| LiftLaw::read_table(table, reading).map(|law| law.reading()).transpose())
        .collect()
}
