// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Suspicious but valid content of a lift table: another unit, a base circle that is not at zero.

use super::declaration::{AngleUnit, LengthUnit, LiftDeclaration};
use super::table::LiftTable;
use alloc::vec::Vec;
use thiserror::Error;

/// Something to look at before the part is made. Lengths mm, angles deg of the file.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LiftWarning {
    /// Lift so small that the values may be inches.
    #[error(
        "line {line}: the largest lift is {largest_mm} mm, cams seldom have less than {usual_mm} mm; were the figures \
         inches, it would be {as_inch_mm:.3} mm"
    )]
    MaybeInches {
        /// Line of the largest lift.
        line: usize,
        /// The largest lift (mm).
        largest_mm: f64,
        /// Usual minimum of cams (mm).
        usual_mm: f64,
        /// Value if read as inches (mm).
        as_inch_mm: f64,
    },
    /// Lift so large that the values may be millimetres.
    #[error(
        "line {line}: the largest lift is {largest_mm:.3} mm, cams seldom have more than {usual_mm} mm; were the figures \
         mm and not inches, it would be {as_mm:.3} mm"
    )]
    MaybeMillimetres {
        /// Line of the largest lift.
        line: usize,
        /// The largest lift (mm).
        largest_mm: f64,
        /// Usual maximum of cams (mm).
        usual_mm: f64,
        /// Value if read as millimetres (mm).
        as_mm: f64,
    },
    /// A half table whose flank is so long or short that its degrees may be the other ones.
    #[error(
        "line {line}: the flank takes {flank_deg:.2} deg as declared, usual are {usual_low_deg} to {usual_high_deg} cam deg; \
         were these {other} degrees, it would take {other_deg:.2} cam deg"
    )]
    MaybeOtherDegrees {
        /// Last line with a lift.
        line: usize,
        /// Cam angle from the nose to there, as declared (deg).
        flank_deg: f64,
        /// Least usual (cam deg).
        usual_low_deg: f64,
        /// Most usual (cam deg).
        usual_high_deg: f64,
        other: &'static str,
        /// Cam angle if the degrees were the other ones (deg).
        other_deg: f64,
    },
    /// No row on the base circle.
    #[error("line {line}: no row lies on the base circle; the smallest lift is {lift_mm} mm, more than {bound_mm} mm")]
    AboveBase {
        /// Line of the smallest lift.
        line: usize,
        /// The smallest lift (mm).
        lift_mm: f64,
        /// Tolerance of the base circle (mm).
        bound_mm: f64,
    },
    /// A hump on the base circle.
    #[error(
        "line {line}: the base circle is not flat: the lift rises by {height_mm:.6} mm here and falls again; \
         allowed: {bound_mm} mm"
    )]
    BaseNotFlat {
        /// Line of the top of the hump.
        line: usize,
        /// Its height above the higher of the two valleys beside it (mm).
        height_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
}

impl LiftWarning {
    /// Line of the file; none for a row that was mirrored or filled in.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        match *self {
            Self::MaybeInches { line, .. }
            | Self::MaybeMillimetres { line, .. }
            | Self::MaybeOtherDegrees { line, .. }
            | Self::AboveBase { line, .. }
            | Self::BaseNotFlat { line, .. } => (line > 0).then_some(line),
        }
    }
}

/// Lifts of cams in use (mm); small engines have 3, large ones 20.
const USUAL_LIFT_MM: (f64, f64) = (0.8, 40.0);

/// Angle from the nose to the end of the ramp of cams in use (cam deg).
const USUAL_FLANK_DEG: (f64, f64) = (35.0, 105.0);

/// The base circle with its ramps: everything below this share of the largest lift.
const BASE_SHARE: f64 = 0.02;

/// A base circle printed right and rounded goes up and down by one digit at most.
const FLAT_DIGITS: f64 = 1.5;

/// Doubts about a table in which nothing is wrong; `lines` are those of its blocks.
pub(super) fn doubts(table: &LiftTable, lines: &[usize], declaration: &LiftDeclaration) -> Vec<LiftWarning> {
    let lifts = table.lifts_mm();
    let mut doubts = Vec::new();
    let at_most = |a: &(usize, &f64), b: &(usize, &f64)| a.1.total_cmp(b.1);
    let (Some((top, &largest_mm)), Some((bottom, &min_mm))) =
        (lifts.iter().enumerate().max_by(at_most), lifts.iter().enumerate().min_by(at_most))
    else {
        return doubts;
    };
    let line = lines[top];
    if declaration.unit == LengthUnit::Millimetre && largest_mm > 0.0 && largest_mm < USUAL_LIFT_MM.0 {
        let (usual_mm, as_inch_mm) = (USUAL_LIFT_MM.0, largest_mm * LengthUnit::Inch.mm());
        doubts.push(LiftWarning::MaybeInches { line, largest_mm, usual_mm, as_inch_mm });
    }
    if declaration.unit == LengthUnit::Inch && largest_mm > USUAL_LIFT_MM.1 {
        let (usual_mm, as_mm) = (USUAL_LIFT_MM.1, largest_mm / LengthUnit::Inch.mm());
        doubts.push(LiftWarning::MaybeMillimetres { line, largest_mm, usual_mm, as_mm });
    }
    let on_base_mm = (0.5 * table.resolution_mm()).max(declaration.smooth_within_mm);
    if min_mm > on_base_mm * (1.0 + 1e-9) {
        doubts.push(LiftWarning::AboveBase { line: lines[bottom], lift_mm: min_mm, bound_mm: on_base_mm });
    }
    let flat_mm = (FLAT_DIGITS * table.resolution_mm()).max(2.0 * declaration.smooth_within_mm);
    doubts.extend(
        humps(&lifts, BASE_SHARE * largest_mm, flat_mm).into_iter().map(|(at, height_mm)| LiftWarning::BaseNotFlat {
            line: lines[at],
            height_mm,
            bound_mm: flat_mm,
        }),
    );
    doubts
}

/// Highest hump of every run of lifts below a level: place and height above the higher of the valleys beside it. On a flat
/// base circle with its ramps the lift falls, stays and rises, and never rises before it falls.
fn humps(lifts: &[f64], level: f64, allowed: f64) -> Vec<(usize, f64)> {
    let n = lifts.len();
    let Some(start) = lifts.iter().position(|lift| *lift > level) else { return Vec::new() };
    let mut found = Vec::new();
    let mut run: Vec<usize> = Vec::new();
    for step in 1..=n {
        let index = (start + step) % n;
        if lifts[index] <= level {
            run.push(index);
            continue;
        }
        let mut left = f64::INFINITY;
        let before: Vec<f64> = run
            .iter()
            .map(|&k| {
                left = left.min(lifts[k]);
                left
            })
            .collect();
        let mut right = f64::INFINITY;
        let mut highest: Option<(usize, f64)> = None;
        for (&k, before) in run.iter().zip(&before).rev() {
            right = right.min(lifts[k]);
            let height = (lifts[k] - before).min(lifts[k] - right);
            if height > allowed && highest.is_none_or(|(_, max)| height > max) {
                highest = Some((k, height));
            }
        }
        found.extend(highest);
        run.clear();
    }
    found
}

/// A doubt about the degrees of a half table whose last row with a lift stands `flank_deg` (deg of the file) from the nose.
pub(super) fn flank(line: usize, flank_deg: f64, angle_unit: AngleUnit) -> Option<LiftWarning> {
    let (usual_low_deg, usual_high_deg) = USUAL_FLANK_DEG;
    let per_turn = angle_unit.turn_deg() / AngleUnit::CamDegrees.turn_deg();
    let as_declared = flank_deg / per_turn;
    let (other, other_deg) = match angle_unit {
        AngleUnit::CamDegrees if as_declared > usual_high_deg => ("crank", 0.5 * flank_deg),
        AngleUnit::CrankDegrees if as_declared < usual_low_deg => ("cam", flank_deg),
        _ => return None,
    };
    Some(LiftWarning::MaybeOtherDegrees {
        line,
        flank_deg: as_declared,
        usual_low_deg,
        usual_high_deg,
        other,
        other_deg,
    })
}
