//! The path of a turn, looked at once: derivatives and bound at equal angles, fine enough for all that has to be known of them.

use super::square_speed::to_f64;
use super::turn_request::{TurnError, TurnRequest};
use crate::numeric::hermite::Sample;
use crate::units::{TURN_RAD, deg_from_rad};
use alloc::vec::Vec;

/// Points on which the bound of the process is looked at, at least. A path has the more intervals the narrower the notches are that
/// a concave flank makes in the bound, and each interval gets a point at least.
const BOUND_POINTS: usize = 3600;

/// Points on which derivatives of the path are known, at least, and at least two in each of its intervals: third derivatives are
/// parabolas there.
const POINTS: usize = 14_400;

/// What is known of the path at one angle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Derivatives {
    /// X′, infeed included (mm/rad).
    pub(super) first: f64,
    /// X″ (mm/rad²).
    pub(super) second: f64,
    /// X‴ (mm/rad³).
    pub(super) third: f64,
}

impl From<Sample> for Derivatives {
    fn from(x: Sample) -> Self {
        Self { first: x.first, second: x.second, third: x.third }
    }
}

/// The path of a turn and its bound.
#[derive(Debug)]
pub(super) struct Table {
    points: Vec<Derivatives>,
    /// 1/bound² at every `per_bound_point`-th point.
    per_bound: Vec<f64>,
    per_bound_point: usize,
}

impl Table {
    /// # Errors
    /// An angle at which the process allows no speed.
    pub(super) fn new(request: &TurnRequest<'_>) -> Result<Self, TurnError> {
        let intervals = request.path.coefficients().len();
        let bounds = BOUND_POINTS.div_ceil(intervals);
        let per_bound_point = 2 * POINTS.div_ceil(2 * bounds * intervals);
        let samples = request.path.samples(u32::try_from(bounds * per_bound_point).unwrap_or(u32::MAX));
        let spacing = TURN_RAD / to_f64(samples.len());
        let mut per_bound = Vec::with_capacity(bounds * intervals);
        for (i, path) in samples.iter().enumerate().step_by(per_bound_point) {
            let angle = to_f64(i) * spacing;
            let per = request.per_square_bound(angle, *path);
            if per.is_nan() || per <= 0.0 || per.is_infinite() {
                let (angle_deg, speed_rad_s) = (deg_from_rad(angle), (request.bound)(angle, *path));
                return Err(TurnError::NoSpeed { angle_deg, speed_rad_s });
            }
            per_bound.push(per);
        }
        let points = samples.into_iter().map(|path| Derivatives::from(request.with_infeed(path)));
        Ok(Self { points: points.collect(), per_bound, per_bound_point })
    }

    /// Distance of its points (rad).
    pub(super) fn spacing(&self) -> f64 {
        TURN_RAD / to_f64(self.points.len())
    }

    /// Number of its points; the first is at angle 0.
    pub(super) fn count(&self) -> usize {
        self.points.len()
    }

    /// The path at a point.
    pub(super) fn path(&self, point: usize) -> Derivatives {
        self.points[point]
    }

    /// 1/bound² at a point, where it is known.
    pub(super) fn per_bound(&self, point: usize) -> Option<f64> {
        point.is_multiple_of(self.per_bound_point).then(|| self.per_bound[point / self.per_bound_point])
    }

    /// 1/bound² at equal angles from 0 on.
    pub(super) fn per_bounds(&self) -> &[f64] {
        &self.per_bound
    }
}
