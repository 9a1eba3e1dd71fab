//! The bound of a turn, looked at once: at equal angles, fine enough for all that has to be known of it.

use super::square_speed::to_f64;
use super::turn_request::{TurnError, TurnRequest};
use crate::numeric::periodic_spline::Weights;
use crate::units::{TURN_RAD, deg_from_rad};
use alloc::vec::Vec;

/// Points on which the bound of the process is looked at, at least. A path has the more intervals the narrower the notches are that
/// a concave flank makes in the bound, and each interval gets a point at least.
const BOUND_POINTS: usize = 3600;

/// The bound of a turn.
#[derive(Debug)]
pub(super) struct Table {
    per_bound: Vec<f64>,
}

impl Table {
    /// # Errors
    /// An angle at which the process allows no speed.
    pub(super) fn new(request: &TurnRequest<'_>) -> Result<Self, TurnError> {
        let intervals = request.path.coefficients().len();
        let parts = BOUND_POINTS.div_ceil(intervals);
        let weights = Weights::at_parts(u32::try_from(parts).unwrap_or(u32::MAX));
        let spacing = TURN_RAD / to_f64(parts * intervals);
        let mut per_bound = Vec::with_capacity(parts * intervals);
        for knot in 0..intervals {
            for weights in &weights {
                let angle = to_f64(per_bound.len()) * spacing;
                let path = request.path.combine(knot, weights);
                let per = request.per_square_bound(angle, path);
                if per.is_nan() || per <= 0.0 || per.is_infinite() {
                    let (angle_deg, speed_rad_s) = (deg_from_rad(angle), (request.bound)(angle, path));
                    return Err(TurnError::NoSpeed { angle_deg, speed_rad_s });
                }
                per_bound.push(per);
            }
        }
        Ok(Self { per_bound })
    }

    /// Distance of its points (rad).
    pub(super) fn spacing(&self) -> f64 {
        TURN_RAD / to_f64(self.per_bound.len())
    }

    /// 1/bound² at equal angles from 0 on.
    pub(super) fn per_bounds(&self) -> &[f64] {
        &self.per_bound
    }
}
