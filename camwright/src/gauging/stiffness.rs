// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! km, kg and F0 measured on the machine, by straight lines.
//!
//! A stopped wheel pushed on the part by a travel V takes nothing, so F = km·V and a constant: km is the slope of force over travel.
//! While the part is ground, F = kg·U + F0: of several feeds kg is the slope of force over depth of cut, and F0 what remains at no
//! depth. The published formula takes one feed, kg = F/U, which is kg + F0/U: 15 % too much at 2 µm with F0 15 N and kg 50 N/µm, 3 % at 10 µm.
//! Force is what the motor's current times its thrust constant is above that of the same motion without contact.

use super::record::GaugeRecord;
use crate::machine::contact_law::{ContactLaw, ContactLawError};
use crate::math::units::{TURN_RAD, deg_from_rad};
use alloc::vec::Vec;
use thiserror::Error;

/// A measured number and its standard uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredValue {
    pub value: f64,
    /// Its standard uncertainty, in the same unit.
    pub uncertainty: f64,
}

/// Force at a travel of the wheel, or at a depth of cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForcePoint {
    /// Travel since any point in contact, or mean depth of cut over a turn (mm).
    pub way_mm: f64,
    /// Normal force (N).
    pub force_n: f64,
}

/// Reasons why points give no stiffness.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum StiffnessError {
    /// Too few points for a line and its uncertainty.
    #[error("{points} points, at least {min} are needed")]
    TooFew { points: usize, min: usize },
    /// A number that is none.
    #[error("point {index}: way or force is not a finite number")]
    NotFinite {
        /// Index of the point.
        index: usize,
    },
    /// All points at one place: a slope needs two travels, or two feeds.
    #[error("all points lie within {range_mm:e} mm: a slope needs at least two different travels or depths of cut")]
    OnePlace {
        /// Largest less least way (mm).
        range_mm: f64,
    },
    /// Force that does not grow with the way.
    #[error("force grows by {slope_n_mm} N/mm, which must be above 0")]
    NotRising {
        /// Slope found (N/mm).
        slope_n_mm: f64,
    },
    /// The wheel was not in contact over the whole way.
    #[error(
        "points bend: slope {lower_n_mm:.0} N/mm over the lower half, {upper_n_mm:.0} N/mm over the upper, standard uncertainty of the \
         difference {uncertainty_n_mm:.0} N/mm: the wheel was not in contact over the whole way"
    )]
    Bends {
        /// Slope of the lower half (N/mm).
        lower_n_mm: f64,
        /// Slope of the upper half (N/mm).
        upper_n_mm: f64,
        /// Standard uncertainty of their difference (N/mm).
        uncertainty_n_mm: f64,
    },
    /// Depths or forces do not cover a turn.
    #[error("{what} do not cover the turn up to C = {until_deg:.2} deg")]
    NotAllOfTheTurn {
        what: &'static str,
        /// End of the turn (deg).
        until_deg: f64,
    },
    #[error("depth of cut {depth_mm} mm must be above 0")]
    Depth {
        /// Given value (mm).
        depth_mm: f64,
    },
    /// The numbers make no contact law.
    #[error(transparent)]
    Law(#[from] ContactLawError),
}

/// The line of points by least squares.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RegressionLine {
    slope: MeasuredValue,
    at_zero: MeasuredValue,
}

/// Minimum number of points of a line with an uncertainty.
const FEWEST_POINTS: usize = 3;

/// Permitted difference between the slopes of a push's two halves in standard uncertainties, for a known scatter. The scatter is estimated
/// from few points, so more is allowed by 1 + 8/ν for ν degrees of freedom; about one in ten thousand straight lines exceeds it at any ν. A
/// half without contact has no slope at all.
const BEND: f64 = 6.0;

/// Share of the slope by which they may differ in any case: a contact that stiffens as it closes is no push into the air.
const BEND_SHARE: f64 = 0.05;

impl RegressionLine {
    fn through(points: &[ForcePoint]) -> Result<Self, StiffnessError> {
        if points.len() < FEWEST_POINTS {
            return Err(StiffnessError::TooFew { points: points.len(), min: FEWEST_POINTS });
        }
        if let Some(index) = points.iter().position(|point| !(point.way_mm.is_finite() && point.force_n.is_finite())) {
            return Err(StiffnessError::NotFinite { index });
        }
        let spread = RegressionSums::from_points(points);
        // A nanometre: no machine resolves it.
        if spread.range < 1e-6 {
            return Err(StiffnessError::OnePlace { range_mm: spread.range });
        }
        let slope = spread.slope();
        if slope.is_nan() || slope <= 0.0 {
            return Err(StiffnessError::NotRising { slope_n_mm: slope });
        }
        let square = spread.rest / (spread.count - 2.0);
        let (way, force) = spread.mean;
        Ok(Self {
            slope: MeasuredValue { value: slope, uncertainty: libm::sqrt(square / spread.way) },
            at_zero: MeasuredValue {
                value: force - slope * way,
                uncertainty: libm::sqrt(square * (1.0 / spread.count + way * way / spread.way)),
            },
        })
    }
}

/// Sums about the mean of points.
struct RegressionSums {
    count: f64,
    mean: (f64, f64),
    /// Σ (V − mean)².
    way: f64,
    /// Σ (V − mean)(F − mean).
    product: f64,
    /// Σ of the squares of what the line leaves.
    rest: f64,
    /// Largest less least way.
    range: f64,
}

impl RegressionSums {
    fn from_points(points: &[ForcePoint]) -> Self {
        let count = points.len() as f64;
        let mean = |of: fn(&ForcePoint) -> f64| points.iter().map(of).sum::<f64>() / count;
        let mean = (mean(|point| point.way_mm), mean(|point| point.force_n));
        let mut spread = Self { count, mean, way: 0.0, product: 0.0, rest: 0.0, range: 0.0 };
        let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
        for point in points {
            let way = point.way_mm - mean.0;
            spread.way += way * way;
            spread.product += way * (point.force_n - mean.1);
            min = min.min(point.way_mm);
            max = max.max(point.way_mm);
        }
        spread.range = max - min;
        let slope = spread.slope();
        let rest = |point: &ForcePoint| point.force_n - mean.1 - slope * (point.way_mm - mean.0);
        spread.rest = points.iter().map(|point| rest(point) * rest(point)).sum();
        spread
    }

    fn slope(&self) -> f64 {
        self.product / self.way
    }
}

/// km (N/mm) from pushing a stopped wheel: the slope of force over travel, three points or more.
///
/// # Errors
/// Points too few, at one place, not rising; or, of six and more, bent as where the wheel touches only after the first of them.
pub fn machine_stiffness(points: &[ForcePoint]) -> Result<MeasuredValue, StiffnessError> {
    let line = RegressionLine::through(points)?;
    if points.len() >= 2 * FEWEST_POINTS {
        let mut sorted: Vec<ForcePoint> = points.to_vec();
        sorted.sort_by(|a, b| a.way_mm.total_cmp(&b.way_mm));
        let (lower, upper) = sorted.split_at(sorted.len() / 2);
        let (below, above) = (RegressionSums::from_points(lower), RegressionSums::from_points(upper));
        let (lower_n_mm, upper_n_mm) = (below.slope(), above.slope());
        // The scatter of the upper half: that of one with a corner in it would hide the corner.
        let scatter_n = libm::sqrt(above.rest / (above.count - 2.0));
        let uncertainty_n_mm = scatter_n * libm::sqrt(1.0 / below.way + 1.0 / above.way);
        let coverage = BEND * (1.0 + 8.0 / (above.count - 2.0));
        let allowed_n_mm = (coverage * uncertainty_n_mm).max(BEND_SHARE * line.slope.value);
        if (upper_n_mm - lower_n_mm).abs() > allowed_n_mm {
            return Err(StiffnessError::Bends { lower_n_mm, upper_n_mm, uncertainty_n_mm });
        }
    }
    Ok(line.slope)
}

/// kg (N/mm) and F0 (N) from grinding at two feeds or more: force and mean depth of cut of every turn that had come to its depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrindingStiffness {
    /// kg (N/mm).
    pub grinding_n_mm: MeasuredValue,
    /// F0 (N).
    pub threshold_n: MeasuredValue,
}

impl GrindingStiffness {
    /// From turns at two feeds or more, three of them or more. Noise of the depths makes the slope less by its share in their variance:
    /// with turns of 360 readings of 0.2 µm at 2 and 10 µm by 1e-5 of it.
    ///
    /// # Errors
    /// Points too few, of one feed alone, not rising.
    pub fn from_feeds(points: &[ForcePoint]) -> Result<Self, StiffnessError> {
        let line = RegressionLine::through(points)?;
        Ok(Self { grinding_n_mm: line.slope, threshold_n: line.at_zero })
    }

    /// The contact law with a machine stiffness. A threshold within its uncertainty of nothing and below it counts as none.
    ///
    /// # Errors
    /// Numbers that make none: a threshold that is negative beyond its uncertainty says that force or depth has an offset.
    pub fn law(&self, machine_n_mm: MeasuredValue) -> Result<ContactLaw, StiffnessError> {
        let MeasuredValue { value, uncertainty } = self.threshold_n;
        let threshold_n = if value < 0.0 && value >= -2.0 * uncertainty { 0.0 } else { value };
        Ok(ContactLaw::new(machine_n_mm.value, self.grinding_n_mm.value, threshold_n)?)
    }
}

/// Normal force at an angle of the headstock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceReading {
    /// Angle of the headstock, counted as that of the gauge's readings (rad).
    pub c_rad: f64,
    /// Normal force (N).
    pub force_n: f64,
}

/// Mean depth of cut and mean force over the turn that ends at an angle of the headstock (rad): a point for
/// [`GrindingStiffness::from_feeds`]. Over a whole turn the runout drops out of both.
///
/// # Errors
/// Depths or forces that do not cover the turn, or forces whose angles do not increase.
pub fn mean_of_turn(
    record: &GaugeRecord<'_>,
    forces: &[ForceReading],
    until_rad: f64,
) -> Result<ForcePoint, StiffnessError> {
    let until_deg = deg_from_rad(until_rad);
    let not_covered = |what: &'static str| StiffnessError::NotAllOfTheTurn { what, until_deg };
    let steps = libm::ceil(record.per_turn()).clamp(1.0, 1e5);
    let (mut sum_mm, mut step) = (0.0, 0.0);
    while step < steps {
        sum_mm += record.depth_mm(until_rad - TURN_RAD * step / steps).ok_or(not_covered("depths of cut"))?;
        step += 1.0;
    }
    // The area under straight lines from force to force, from the start of the turn to its end.
    let from_rad = until_rad - TURN_RAD;
    let (mut area, mut covered) = (0.0, 0.0);
    for pair in forces.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let way = b.c_rad - a.c_rad;
        if way.is_nan() || way <= 0.0 {
            return Err(not_covered("forces"));
        }
        let (left, right) = (a.c_rad.max(from_rad), b.c_rad.min(until_rad));
        if right > left {
            let middle = (0.5 * (left + right) - a.c_rad) / way;
            area += (right - left) * (a.force_n + middle * (b.force_n - a.force_n));
            covered += right - left;
        }
    }
    if covered < TURN_RAD * (1.0 - 1e-9) {
        return Err(not_covered("forces"));
    }
    Ok(ForcePoint { way_mm: sum_mm / steps, force_n: area / covered })
}

/// kg by the published formula of one feed, F/U, and what it has too much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedForce {
    /// F/U (N/mm).
    pub grinding_n_mm: f64,
    /// F0/U: by how much that exceeds kg (N/mm).
    pub bias_n_mm: f64,
}

/// kg as published, of one feed, with the bias that a threshold force (N) gives it.
///
/// # Errors
/// A depth that is not above 0.
pub fn grinding_stiffness_of_one_feed(point: ForcePoint, threshold_n: f64) -> Result<FeedForce, StiffnessError> {
    let depth_mm = point.way_mm;
    if !(depth_mm > 0.0 && depth_mm.is_finite()) {
        return Err(StiffnessError::Depth { depth_mm });
    }
    if !(point.force_n.is_finite() && threshold_n.is_finite()) {
        return Err(StiffnessError::NotFinite { index: 0 });
    }
    Ok(FeedForce { grinding_n_mm: point.force_n / depth_mm, bias_n_mm: threshold_n / depth_mm })
}

/// km/kg of two measurements: their shares of uncertainty add as squares.
#[must_use]
pub fn ratio(machine_n_mm: MeasuredValue, grinding_n_mm: MeasuredValue) -> MeasuredValue {
    let value = machine_n_mm.value / grinding_n_mm.value;
    let shares =
        libm::hypot(machine_n_mm.uncertainty / machine_n_mm.value, grinding_n_mm.uncertainty / grinding_n_mm.value);
    MeasuredValue { value, uncertainty: value * shares }
}
