// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! g, the part of every phase's motion that the wheel's positions do not determine, by least squares from the gauge readings.
//!
//! From depths of cut, as published but for all turns at once: every phase has one number, a mean of its cuts weighted by a(C), and
//! harmonics are cut afterwards. Or from the readings themselves: a reading is the sum of the radii at its contacts as they last left
//! the wheel,
//!
//! ```text
//!  M(C) = Σ r(C − γ) − s cos γ·T(C) + zero
//! ```
//! which is linear in the harmonics of g and in the zero, and their least-squares answer weighs every reading as it deserves. A depth
//! is a difference and has √2 of the noise; of even harmonics, which a diameter shows without any cut, the depths see only km/(kg + km).

use super::gauge::Gauge;
use super::harmonics::FourierSeries;
use super::record::{GaugeRecord, RunoutReading};
use super::reference_motion::{ROUNDING_RAD, ReferenceMotion};
use super::runout::phase_rad;
use super::state_error::StateError;
use crate::math::noise::Noise;
use crate::math::units::{TURN_RAD, deg_from_rad};
use alloc::vec::Vec;
use nalgebra::{DMatrix, DVector};

/// Method that derives radii from readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fit {
    /// From all readings at once, as so many harmonics: the least noise.
    Readings {
        /// Harmonics of the part.
        harmonics: u32,
    },
    /// From the depths of cut, phase by phase, as `U_j` = `U_0` λ^j in a dwell.
    Depths {
        /// Harmonics kept afterwards; `None` keeps everything, noise included.
        harmonics: Option<u32>,
    },
}

impl Fit {
    /// Number of resolved harmonics; 0 if the fit keeps all of them.
    pub(super) fn harmonics(self) -> u32 {
        match self {
            Self::Readings { harmonics } => harmonics,
            Self::Depths { harmonics } => harmonics.unwrap_or(0),
        }
    }
}

/// g at equal phases.
pub(super) struct FittedLaw {
    pub(super) deviations: Vec<f64>,
    /// Standard deviation of a reading about the law (mm), where there is more to it than numbers found.
    pub(super) scatter_mm: Option<f64>,
    /// Errors of g from those of the readings; `None` for a fit to depths.
    pub(super) errors: Option<FitErrors>,
}

/// Distribution of the errors of g, if those of the readings are independent.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FitErrors {
    /// L of the normal matrix L Lᵀ.
    factor: DMatrix<f64>,
    kept: usize,
    /// Standard deviation of a reading (mm).
    reading_mm: f64,
}

impl FitErrors {
    /// A random error of g at `count` equal phases (mm).
    pub(super) fn draw(&self, noise: &mut Noise, count: usize) -> Vec<f64> {
        // With z of independent normal numbers, L⁻ᵀ z has the covariance (L Lᵀ)⁻¹ of the unknowns.
        let z = DVector::from_fn(self.factor.nrows(), |_, _| self.reading_mm * noise.normal());
        let Some(error) = self.factor.tr_solve_lower_triangular(&z) else { return alloc::vec![f64::INFINITY; count] };
        series(&error, self.kept).values(count)
    }
}

/// Mean and kept harmonics of g from the unknowns of the fit.
fn series(unknowns: &DVector<f64>, kept: usize) -> FourierSeries {
    let pairs = unknowns.as_slice()[2..2 + 2 * kept].chunks(2).map(|pair| (pair[0], pair[1]));
    FourierSeries::from_parts(unknowns[1], pairs.collect())
}

/// Angles of the headstock at which a phase is cut between two others.
pub(super) fn cuts_of(phase_rad: f64, first_rad: f64, until_rad: f64) -> impl Iterator<Item = f64> {
    let turn = libm::ceil((first_rad - ROUNDING_RAD - phase_rad) / TURN_RAD);
    let from_rad = phase_rad + turn * TURN_RAD;
    core::iter::successors(Some(from_rad), |c_rad| Some(c_rad + TURN_RAD))
        .take_while(move |c_rad| *c_rad <= until_rad + ROUNDING_RAD)
}

/// From the depths of the cuts from one angle to another.
pub(super) fn by_depths(
    record: &GaugeRecord<'_>,
    known: &ReferenceMotion<'_>,
    (first_rad, until_rad): (f64, f64),
    phases: usize,
    harmonics: Option<u32>,
) -> Result<FittedLaw, StateError> {
    let (feels, delay_rad) = (record.gauge().feels_deflection(), record.gauge().cut_after_rad());
    let ratio = known.law.grinding_n_mm() / known.law.machine_n_mm();
    let less_than_a_turn = StateError::LessThanATurn { known_deg: deg_from_rad((until_rad - first_rad).max(0.0)) };
    let mut deviations = Vec::with_capacity(phases);
    let (mut squares, mut spare) = (0.0, 0.0);
    let mut cuts: Vec<(f64, f64)> = Vec::new();
    for index in 0..phases {
        cuts.clear();
        for c_rad in cuts_of(phase_rad(index, phases), first_rad, until_rad) {
            let Some(depth_mm) = record.depth_mm(c_rad) else { return Err(less_than_a_turn) };
            let read_rad = c_rad - delay_rad;
            let felt_mm = match feels {
                0.0 => 0.0,
                _ => feels * ratio * (known.depth_mm(read_rad) - known.depth_mm(read_rad + TURN_RAD)),
            };
            cuts.push((known.weight(c_rad), depth_mm - known.depth_mm(c_rad) + felt_mm));
        }
        if cuts.is_empty() {
            return Err(less_than_a_turn);
        }
        let (mut upper, mut lower) = (0.0, 0.0);
        for (weight, rest_mm) in &cuts {
            upper += weight * rest_mm;
            lower += weight * weight;
        }
        let deviation = upper / lower;
        squares +=
            cuts.iter().map(|(weight, rest)| (rest - weight * deviation) * (rest - weight * deviation)).sum::<f64>();
        let more = (cuts.len() - 1) as f64;
        spare += more;
        deviations.push(deviation);
    }
    if harmonics.is_some() || feels != 0.0 {
        // The T of a reading is that of another cut, a part of a turn before, so that depths hold an echo of g.
        let echo = feels * known.law.decay() * libm::pow(known.law.decay(), -delay_rad / TURN_RAD);
        let kept = harmonics.map_or(phases, |harmonics| harmonics as usize);
        deviations = FourierSeries::from_values(&deviations, kept).without_echo(echo, delay_rad).values(phases);
    }
    // A depth is the difference of two readings.
    let scatter_mm = (spare > 0.0).then(|| libm::sqrt(0.5 * squares / spare));
    Ok(FittedLaw { deviations, scatter_mm, errors: None })
}

/// From all readings from an angle on.
pub(super) fn by_readings(
    record: &GaugeRecord<'_>,
    known: &ReferenceMotion<'_>,
    until_rad: f64,
    phases: usize,
    harmonics: u32,
) -> Result<FittedLaw, StateError> {
    let kept = harmonics as usize;
    // Twice as many harmonics are fitted: otherwise the part's harmonics above those kept would leak into them, mainly into the odd
    // ones, of which a diameter shows little. A turn of readings resolves no more than half their number.
    #[allow(clippy::cast_possible_truncation, reason = "a number of readings")]
    let resolvable = (0.5 * record.per_turn()) as usize;
    let fitted = (2 * kept).min(resolvable.saturating_sub(1)).max(kept);
    let unknowns = 2 * fitted + 2;
    let mut normal = Normal::new(unknowns);
    for (contacts, readings, zero_mm) in record.sources() {
        for reading in readings {
            // Of cuts after the last one seen nothing is asked: the wheel may be leaving by then.
            if reading.c_rad >= known.from_rad - ROUNDING_RAD
                && contacts.iter().flatten().all(|after_rad| reading.c_rad - after_rad <= until_rad + ROUNDING_RAD)
            {
                normal.add_reading(known, record.gauge(), contacts, *reading, zero_mm);
            }
        }
    }
    let readings = normal.count;
    let undetermined = StateError::Undetermined { readings, harmonics };
    if readings <= unknowns {
        return Err(undetermined);
    }
    let Some((solution, squares, factor)) = normal.solve() else { return Err(undetermined) };
    let reading_mm = libm::sqrt(squares.max(0.0) / (readings - unknowns) as f64);
    Ok(FittedLaw {
        deviations: series(&solution, kept).values(phases),
        scatter_mm: Some(reading_mm),
        errors: Some(FitErrors { factor, kept, reading_mm }),
    })
}

/// Least squares by normal equations: well enough conditioned, for the unknowns are harmonics over at least a turn.
struct Normal {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    row: Vec<f64>,
    level_mm: Option<f64>,
    squares: f64,
    count: usize,
}

impl Normal {
    fn new(unknowns: usize) -> Self {
        let row = alloc::vec![0.0; unknowns];
        Self {
            matrix: DMatrix::zeros(unknowns, unknowns),
            right: DVector::zeros(unknowns),
            row,
            level_mm: None,
            squares: 0.0,
            count: 0,
        }
    }

    /// One reading: the zero's coefficient, then those of the mean and of every harmonic's cosine and sine.
    fn add_reading(
        &mut self,
        known: &ReferenceMotion<'_>,
        gauge: &Gauge,
        contacts: [Option<f64>; 2],
        reading: RunoutReading,
        zero_mm: f64,
    ) {
        self.row.fill(0.0);
        self.row[0] = 1.0;
        // From the constant, so that a diameter of 40 mm costs no digits.
        let mut rest_mm = reading.value_mm - zero_mm;
        for after_rad in contacts.into_iter().flatten() {
            let c_rad = reading.c_rad - after_rad;
            rest_mm -= known.radius_mm(c_rad);
            self.add(known.share(c_rad), c_rad);
        }
        let feels = gauge.feels_deflection();
        if feels != 0.0 {
            let ratio = known.law.grinding_n_mm() / known.law.machine_n_mm();
            rest_mm += feels * ratio * known.depth_mm(reading.c_rad);
            self.add(-feels * ratio * known.weight(reading.c_rad), reading.c_rad);
        }
        // From the first, that a zero far away costs no digits either.
        rest_mm -= *self.level_mm.get_or_insert(rest_mm);
        for (i, a) in self.row.iter().enumerate() {
            for (j, b) in self.row.iter().enumerate().skip(i) {
                self.matrix[(j, i)] += a * b;
            }
            self.right[i] += a * rest_mm;
        }
        self.squares += rest_mm * rest_mm;
        self.count += 1;
    }

    /// g at an angle, so many times.
    fn add(&mut self, times: f64, c_rad: f64) {
        let (step_cos, step_sin) = (libm::cos(c_rad), libm::sin(c_rad));
        let (mut cos, mut sin) = (1.0, 0.0);
        self.row[1] += times;
        for pair in self.row[2..].chunks_mut(2) {
            (cos, sin) = (cos * step_cos - sin * step_sin, sin * step_cos + cos * step_sin);
            pair[0] += times * cos;
            pair[1] += times * sin;
        }
    }

    /// The unknowns, the sum of the squares of what they leave, and L of the normal matrix L Lᵀ.
    fn solve(self) -> Option<(DVector<f64>, f64, DMatrix<f64>)> {
        let factor = self.matrix.cholesky()?;
        let solution = factor.solve(&self.right);
        let left = self.squares - solution.dot(&self.right);
        solution.iter().all(|value| value.is_finite()).then(|| (solution, left, factor.unpack()))
    }
}
