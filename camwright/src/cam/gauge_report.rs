// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Report of a measuring machine on one lobe: its deviation along the normal, with the errors of mounting separated from those of form.
//!
//! A lobe that is larger by s, displaced by e, and turned by δ deviates at the point Q with the normal N, to first order, by
//!
//! ```text
//! d = s + N·e + δ (ẑ × Q)·N
//! ```
//!
//! The four are found by least squares over equal cam angles. What a measuring machine adds by its mounting can be removed so; what
//! remains is the form error.

use crate::cam::compensation::{FormCurve, SAMPLES};
use crate::cam::contour::Contour;
use crate::math::uneven_cubic::UnevenCubic;
use crate::math::units::{TURN_RAD, deg_from_rad, wrap_turn};
use alloc::vec::Vec;
use nalgebra::{Matrix4, Vector2, Vector4};
use thiserror::Error;

/// One value of a report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReportedValue {
    /// Line of the file.
    pub line: usize,
    /// Cam angle, or azimuth in the part's frame (rad).
    pub angle_rad: f64,
    /// Deviation, lift or radius (mm).
    pub value_mm: f64,
}

/// Meaning of the values of a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReportKind {
    /// Deviation along the normal over the cam angle, positive where material is left.
    Deviation,
    /// Lift of the job's follower over the cam angle. It has no size: a gauge is set to 0 on the base circle.
    Lift,
    /// Radius over the azimuth from the keyway.
    Radius,
}

/// Why a report cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum GaugeReportError {
    #[error("{count} values; at least {min} are needed")]
    TooFewValues { count: usize, min: usize },
    /// A value or angle that is not finite, or a radius that is not positive.
    #[error("line {line}: {what} is {value}, which cannot be")]
    BadValue { line: usize, what: &'static str, value: f64 },
    #[error("line {line}: two values stand at the angle {angle_deg:.4} deg, the other in line {previous_line}")]
    SameAngle { line: usize, angle_deg: f64, previous_line: usize },
    /// Values too far apart for the harmonics that are learned.
    #[error(
        "line {line}: {gap_deg:.3} deg without a value before this one; {harmonics} harmonics need a value every {max_deg:.3} deg; \
         at most {possible} harmonics can be learned"
    )]
    Gap { line: usize, gap_deg: f64, max_deg: f64, harmonics: u32, possible: u32 },
    /// Values that fit the design only against their direction.
    #[error(
        "the values lie up to {straight_um:.1} um off the design in their direction, and up to {mirrored_um:.1} um against it: the angles \
         count the other way"
    )]
    Mirrored { straight_um: f64, mirrored_um: f64 },
    /// More than a part of the job can be off.
    #[error(
        "the lobe deviates by up to {deviation_mm:.3} mm; at most {max_mm} mm are learned. A rotation by {phase_deg:.3} deg and an \
         eccentricity of {eccentricity_mm:.3} mm explain all but {left_mm:.4} mm"
    )]
    TooLarge { deviation_mm: f64, max_mm: f64, phase_deg: f64, eccentricity_mm: f64, left_mm: f64 },
}

/// Errors of mounting that are removed from a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Alignment {
    pub size: bool,
    pub eccentricity: bool,
    pub phase: bool,
}

impl Alignment {
    /// All of them.
    pub const ALL: Self = Self { size: true, eccentricity: true, phase: true };
}

/// Size, displacement and rotation of a measured lobe, by least squares.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mounting {
    /// Size error (mm), positive for a lobe that is too large.
    pub size_mm: f64,
    /// Displacement of the lobe in its own frame (mm): x towards cam angle 0.
    pub eccentricity_mm: Vector2<f64>,
    /// Rotation (rad), positive with the azimuth; `None` where it cannot be separated from an eccentricity, as on a disc.
    pub phase_rad: Option<f64>,
}

/// Deviation of one lobe as it was reported, at equal cam angles.
#[derive(Debug, Clone, PartialEq)]
pub struct GaugeReport {
    /// Deviation along the normal at the cam angles i·2π/n (mm).
    deviations_mm: Vec<f64>,
    /// Columns of the fit at those angles: size, displacement, rotation.
    columns: Vec<[f64; 4]>,
}

/// Fewest values: two for each of the four errors of mounting, and some.
const MIN_VALUES: usize = 12;

/// Angles that differ by less are the same (rad).
const SAME_RAD: f64 = 1e-9;

/// Values for each wave of the highest harmonic: a cubic spline through four is right to a few per cent.
pub(super) const VALUES_PER_WAVE: f64 = 4.0;

/// Share of a column that must remain without the others before it is fitted.
const SEPARABLE: f64 = 0.01;

/// Ratio of the deviations straight and mirrored from which on the direction is known to be wrong, and the least deviation (mm).
const MIRRORED: (f64, f64) = (4.0, 0.05);

impl GaugeReport {
    /// A report of so many values of a lobe whose cam angle 0 lies at the azimuth `phase_rad` of the part; their angles stand in any order.
    ///
    /// # Errors
    /// Values that are not finite, too few, at the same angle or too far apart for the harmonics that are learned; radii or lifts that
    /// fit only against their direction.
    pub fn new(
        kind: ReportKind,
        values: &[ReportedValue],
        contour: &Contour,
        phase_rad: f64,
        harmonics: u32,
    ) -> Result<Self, GaugeReportError> {
        let report = Self::read(kind, values, contour, phase_rad, harmonics)?;
        if kind == ReportKind::Deviation {
            return Ok(report);
        }
        let straight_mm = report.without(Alignment::ALL).largest_mm();
        if straight_mm < MIRRORED.1 {
            return Ok(report);
        }
        let against: Vec<ReportedValue> =
            values.iter().map(|value| ReportedValue { angle_rad: -value.angle_rad, ..*value }).collect();
        let mirrored = Self::read(kind, &against, contour, phase_rad, harmonics)
            .map_or(f64::INFINITY, |mirrored| mirrored.without(Alignment::ALL).largest_mm());
        if mirrored * MIRRORED.0 < straight_mm {
            let um = crate::math::units::um_from_mm;
            return Err(GaugeReportError::Mirrored { straight_um: um(straight_mm), mirrored_um: um(mirrored) });
        }
        Ok(report)
    }

    fn read(
        kind: ReportKind,
        values: &[ReportedValue],
        contour: &Contour,
        phase_rad: f64,
        harmonics: u32,
    ) -> Result<Self, GaugeReportError> {
        // A list that ends where it began has its first value twice.
        let values = match values {
            [first, .., last] if ((last.angle_rad - first.angle_rad).abs() - TURN_RAD).abs() < SAME_RAD => {
                &values[..values.len() - 1]
            }
            all => all,
        };
        if values.len() < MIN_VALUES {
            return Err(GaugeReportError::TooFewValues { count: values.len(), min: MIN_VALUES });
        }
        let mut at: Vec<(f64, f64, usize)> = Vec::with_capacity(values.len());
        for value in values {
            let (line, value_mm) = (value.line, value.value_mm);
            if !value.angle_rad.is_finite() {
                return Err(GaugeReportError::BadValue { line, what: "the angle", value: value.angle_rad });
            }
            if !value_mm.is_finite() || (kind == ReportKind::Radius && value_mm <= 0.0) {
                return Err(GaugeReportError::BadValue { line, what: "the value", value: value_mm });
            }
            let (cam_angle, deviation_mm) = match kind {
                ReportKind::Deviation => (value.angle_rad, value_mm),
                ReportKind::Lift => {
                    let lift = contour.lift().sample(value.angle_rad).value;
                    (value.angle_rad, (value_mm - lift) / contour.lift_per_depth(value.angle_rad))
                }
                ReportKind::Radius => {
                    let (deviation_mm, cam_angle) = contour.distance(value_mm, value.angle_rad - phase_rad);
                    (cam_angle, deviation_mm)
                }
            };
            at.push((wrap_turn(cam_angle), deviation_mm, line));
        }
        at.sort_by(|one, other| one.0.total_cmp(&other.0));
        let same_angle = |values: &[(f64, f64, usize)]| {
            let same = values.windows(2).find(|pair| (pair[0].0 - pair[1].0).abs() < SAME_RAD);
            same.map(|pair| (deg_from_rad(pair[1].0), pair[1].2.max(pair[0].2), pair[1].2.min(pair[0].2)))
        };
        // Two radii at one azimuth lie at slightly different cam angles.
        let mut given: Vec<(f64, f64, usize)> =
            values.iter().map(|value| (wrap_turn(value.angle_rad), value.value_mm, value.line)).collect();
        given.sort_by(|one, other| one.0.total_cmp(&other.0));
        if let Some((angle_deg, line, previous_line)) = same_angle(&given).or_else(|| same_angle(&at)) {
            return Err(GaugeReportError::SameAngle { line, angle_deg, previous_line });
        }
        let max_rad = TURN_RAD / (VALUES_PER_WAVE * f64::from(harmonics.max(1)));
        let next = |i: usize| if i + 1 < at.len() { at[i + 1] } else { (at[0].0 + TURN_RAD, at[0].1, at[0].2) };
        let widest = (0..at.len()).map(|i| (next(i).0 - at[i].0, next(i).2)).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((gap, line)) = widest.filter(|(gap, _)| *gap > max_rad * (1.0 + 1e-6)) {
            #[allow(clippy::cast_possible_truncation, reason = "below the harmonics asked for")]
            let possible = libm::floor(TURN_RAD / (VALUES_PER_WAVE * gap) + 1e-6) as u32;
            let (gap_deg, max_deg) = (deg_from_rad(gap), deg_from_rad(max_rad));
            return Err(GaugeReportError::Gap { line, gap_deg, max_deg, harmonics, possible });
        }
        let known: Vec<(f64, f64)> = at.iter().map(|(angle, deviation, _)| (*angle, *deviation)).collect();
        let Some(spline) = UnevenCubic::interpolate(&known) else {
            return Err(GaugeReportError::TooFewValues { count: at.len(), min: MIN_VALUES });
        };
        let angles = (0..SAMPLES).map(|i| f64::from(i) * TURN_RAD / f64::from(SAMPLES));
        let column = |angle: f64| {
            let (point, normal) = (contour.point(angle), contour.normal(angle));
            [1.0, normal.x, normal.y, point.x * normal.y - point.y * normal.x]
        };
        Ok(Self {
            deviations_mm: angles.clone().map(|angle| spline.value(angle)).collect(),
            columns: angles.map(column).collect(),
        })
    }

    /// Deviation along the normal at equal cam angles from 0 (mm).
    #[must_use]
    pub fn deviations_mm(&self) -> &[f64] {
        &self.deviations_mm
    }

    /// Largest deviation in size (mm).
    #[must_use]
    pub fn largest_mm(&self) -> f64 {
        self.deviations_mm.iter().fold(0.0, |largest, deviation| f64::max(largest, deviation.abs()))
    }

    /// Size, displacement and rotation that fit the report best.
    #[must_use]
    pub fn mounting(&self) -> Mounting {
        let (shares, has_phase) = self.shares(Alignment::ALL);
        Mounting {
            size_mm: shares[0],
            eccentricity_mm: Vector2::new(shares[1], shares[2]),
            phase_rad: has_phase.then_some(shares[3]),
        }
    }

    /// The report without these errors of mounting. A rotation that cannot be separated from an eccentricity remains unless the
    /// eccentricity does.
    #[must_use]
    pub fn without(&self, alignment: Alignment) -> Self {
        let (shares, _) = self.shares(alignment);
        let left = self.deviations_mm.iter().zip(&self.columns).map(|(deviation, column)| {
            deviation - column.iter().zip(shares.iter()).map(|(value, share)| value * share).sum::<f64>()
        });
        Self { deviations_mm: left.collect(), columns: self.columns.clone() }
    }

    /// Harmonics of the deviation over the cam angle.
    ///
    /// # Errors
    /// A deviation beyond what a correction may be, with the mounting that would explain it.
    pub fn curve(&self, harmonics: u32, max_mm: f64) -> Result<FormCurve, GaugeReportError> {
        let deviation_mm = self.largest_mm();
        if deviation_mm > max_mm {
            let mounting = self.mounting();
            return Err(GaugeReportError::TooLarge {
                deviation_mm,
                max_mm,
                phase_deg: deg_from_rad(mounting.phase_rad.unwrap_or(0.0)),
                eccentricity_mm: mounting.eccentricity_mm.norm(),
                left_mm: self.without(Alignment::ALL).largest_mm(),
            });
        }
        Ok(FormCurve::of_samples(&self.deviations_mm, harmonics))
    }

    /// Least squares of the chosen columns, and true if the rotation could be separated from them; else it stays 0 beside an eccentricity.
    fn shares(&self, alignment: Alignment) -> (Vector4<f64>, bool) {
        if let Some(shares) = self.fit(alignment) {
            return (shares, true);
        }
        let alone = Alignment { phase: alignment.phase && !alignment.eccentricity, ..alignment };
        (self.fit(alone).unwrap_or_default(), false)
    }

    /// Least squares of the chosen columns; `None` where they cannot be separated.
    fn fit(&self, alignment: Alignment) -> Option<Vector4<f64>> {
        let chosen = [alignment.size, alignment.eccentricity, alignment.eccentricity, alignment.phase];
        let mut matrix = Matrix4::<f64>::identity();
        let mut right = Vector4::<f64>::zeros();
        for (deviation, column) in self.deviations_mm.iter().zip(&self.columns) {
            for i in (0..4).filter(|i| chosen[*i]) {
                right[i] += column[i] * deviation;
                for j in (0..4).filter(|j| chosen[*j]) {
                    matrix[(i, j)] += column[i] * column[j];
                }
            }
        }
        for i in (0..4).filter(|i| chosen[*i]) {
            matrix[(i, i)] -= 1.0;
        }
        // The square of what is left of the last column without the others is the pivot of its elimination.
        let factor = matrix.cholesky()?;
        let pivot = factor.l()[(3, 3)];
        if alignment.phase && pivot <= SEPARABLE * libm::sqrt(matrix[(3, 3)]) {
            return None;
        }
        Some(factor.solve(&right))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cam::compensation::MAX_CORRECTION_MM;
    use crate::cam::follower::Follower;
    use crate::cam::lift::LiftLaw;
    use crate::math::units::rad_from_deg;

    fn lobe() -> Contour {
        // Two waves of unequal height, so that no rotation is a displacement.
        let lift = |angle: f64| 3.0 - 2.0 * libm::cos(angle) + 0.6 * libm::cos(3.0 * angle) + 0.4;
        let lift = LiftLaw::from_fn(lift).expect("a lift");
        Contour::from_lift(&lift, &Follower::Roller { radius_mm: 10.0, offset_mm: 0.0 }, 20.0).expect("a contour")
    }

    /// Planted form: one wave of 3 µm.
    fn form_mm(angle: f64) -> f64 {
        0.003 * libm::cos(7.0 * angle)
    }

    /// Radii of a lobe at `phase_rad` that is larger, displaced in its frame, and turned, at azimuths of the part.
    fn radii(contour: &Contour, phase_rad: f64, planted: Mounting) -> Vec<ReportedValue> {
        (0..720_u32)
            .map(|i| {
                let angle = f64::from(i) * TURN_RAD / 720.0 + 0.002 * libm::sin(f64::from(i));
                let out = planted.size_mm + form_mm(angle);
                let point = contour.point(angle) + contour.normal(angle) * out;
                let (sin, cos) = libm::sincos(planted.phase_rad.unwrap_or(0.0));
                let turned = Vector2::new(cos * point.x - sin * point.y, sin * point.x + cos * point.y);
                let placed = turned + planted.eccentricity_mm;
                let angle_rad = libm::atan2(placed.y, placed.x) + phase_rad;
                ReportedValue { line: i as usize + 2, angle_rad, value_mm: placed.norm() }
            })
            .collect()
    }

    #[test]
    fn planted_size_eccentricity_and_phase_are_recovered_and_removed() {
        let (contour, phase_rad) = (lobe(), 1.3);
        let planted = Mounting {
            size_mm: 0.004,
            eccentricity_mm: Vector2::new(0.006, -0.005),
            phase_rad: Some(rad_from_deg(0.02)),
        };
        let values = radii(&contour, phase_rad, planted);
        let report = GaugeReport::new(ReportKind::Radius, &values, &contour, phase_rad, 40).expect("a report");
        let found = report.mounting();
        assert!((found.size_mm - 0.004).abs() < 1e-5, "{found:?}");
        assert!((found.eccentricity_mm - planted.eccentricity_mm).norm() < 2e-5, "{found:?}");
        assert!((found.phase_rad.expect("separable") - rad_from_deg(0.02)).abs() < 2e-6, "{found:?}");
        let left = report.without(Alignment::ALL).curve(40, MAX_CORRECTION_MM).expect("a curve");
        for i in 0..360 {
            let angle = rad_from_deg(f64::from(i));
            let off = left.sample(angle).value - form_mm(angle);
            assert!(off.abs() < 5e-5, "{i}: {off}");
        }
        // Only the eccentricity is removed: size and phase are errors of the part.
        let part = report.without(Alignment { eccentricity: true, ..Alignment::default() });
        assert!(
            (part.mounting().size_mm - found.size_mm).abs() < 2e-3 && part.mounting().eccentricity_mm.norm() < 0.01
        );
    }

    /// The same lift as the job's follower reports it, in any order and with its first value again at the end.
    #[test]
    fn lifts_are_deviations_along_the_normal() {
        let contour = lobe();
        let lift = |angle: f64| contour.lift().sample(angle).value + form_mm(angle) * contour.lift_per_depth(angle);
        let mut values: Vec<ReportedValue> = (0..=360_u32)
            .map(|i| (i as usize + 1, rad_from_deg(f64::from(i) - 180.0)))
            .map(|(line, angle_rad)| ReportedValue { line, angle_rad, value_mm: lift(angle_rad) })
            .collect();
        for _ in 0..2 {
            let report = GaugeReport::new(ReportKind::Lift, &values, &contour, 0.0, 40).expect("a report");
            for (i, deviation) in (0_u32..).zip(report.deviations_mm()) {
                let off = deviation - form_mm(f64::from(i) * TURN_RAD / f64::from(SAMPLES));
                assert!(off.abs() < 1e-6, "{i}: {off}");
            }
            values.reverse();
        }
    }

    #[test]
    fn what_cannot_be_the_lobe_is_refused() {
        let (contour, phase_rad) = (lobe(), 1.3);
        let good = radii(&contour, phase_rad, Mounting::default());
        let check = |values: &[ReportedValue]| GaugeReport::new(ReportKind::Radius, values, &contour, phase_rad, 40);
        // Mirrored: the lobe is not its own mirror image about the keyway.
        let lobed = |angle: f64| 3.0 - 2.0 * libm::cos(angle) + 0.5 * libm::sin(2.0 * angle) + 0.5;
        let lopsided = LiftLaw::from_fn(lobed).expect("a lift");
        let lopsided = Contour::from_lift(&lopsided, &Follower::Roller { radius_mm: 10.0, offset_mm: 0.0 }, 20.0)
            .expect("a contour");
        let mut values = radii(&lopsided, phase_rad, Mounting::default());
        assert!(GaugeReport::new(ReportKind::Radius, &values, &lopsided, phase_rad, 40).is_ok());
        values.iter_mut().for_each(|value| value.angle_rad = -value.angle_rad);
        let error = GaugeReport::new(ReportKind::Radius, &values, &lopsided, phase_rad, 40).expect_err("mirrored");
        assert!(matches!(error, GaugeReportError::Mirrored { .. }), "{error}");
        // Turned by 3°: larger than any correction, and its reason is named.
        let turned = radii(&contour, phase_rad, Mounting { phase_rad: Some(rad_from_deg(3.0)), ..Mounting::default() });
        let error = check(&turned).expect("a report").curve(40, MAX_CORRECTION_MM).expect_err("too large");
        let GaugeReportError::TooLarge { phase_deg, .. } = error else { panic!("{error}") };
        assert!((phase_deg - 3.0).abs() < 0.1, "{phase_deg}");
        let mut bad = good.clone();
        bad[9].value_mm = f64::NAN;
        assert!(matches!(check(&bad), Err(GaugeReportError::BadValue { line: 11, .. })));
        bad[9].value_mm = -1.0;
        assert!(matches!(check(&bad), Err(GaugeReportError::BadValue { line: 11, .. })));
        let mut same = good.clone();
        same[20].angle_rad = same[21].angle_rad;
        assert!(matches!(check(&same), Err(GaugeReportError::SameAngle { .. })));
        assert!(matches!(check(&good[..11]), Err(GaugeReportError::TooFewValues { count: 11, .. })));
        let sparse: Vec<ReportedValue> = good.iter().step_by(8).copied().collect();
        assert!(matches!(check(&sparse), Err(GaugeReportError::Gap { harmonics: 40, possible: 20..=24, .. })));
    }

    /// A rotation of a disc is a displacement of its centre: it is reported as that.
    #[test]
    fn the_phase_of_a_disc_is_not_separated_from_its_eccentricity() {
        let disc = Contour::eccentric(2.0, 20.0).expect("a disc");
        let values: Vec<ReportedValue> = (0..360_u32)
            .map(|i| ReportedValue { line: i as usize, angle_rad: rad_from_deg(f64::from(i)), value_mm: 0.001 })
            .collect();
        let report = GaugeReport::new(ReportKind::Deviation, &values, &disc, 0.0, 40).expect("a report");
        let found = report.mounting();
        assert!(found.phase_rad.is_none() && (found.size_mm - 0.001).abs() < 1e-9, "{found:?}");
        assert!(report.without(Alignment::ALL).largest_mm() < 1e-9);
    }
}
