//! Where a turn uses its limits most, between the points on which it was planned.

use super::square_speed::SquareSpeed;
use super::table::{Derivatives, Table};
use super::turn_request::TurnRequest;
use alloc::vec::Vec;

/// Largest ratios to their limits.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Peaks {
    pub(super) bound: f64,
    pub(super) c_acceleration: f64,
    pub(super) x_acceleration: f64,
    pub(super) c_jerk: f64,
    pub(super) x_jerk: f64,
}

impl Peaks {
    /// The larger of each.
    pub(super) fn larger(self, other: Self) -> Self {
        Self {
            bound: self.bound.max(other.bound),
            c_acceleration: self.c_acceleration.max(other.c_acceleration),
            x_acceleration: self.x_acceleration.max(other.x_acceleration),
            c_jerk: self.c_jerk.max(other.c_jerk),
            x_jerk: self.x_jerk.max(other.x_jerk),
        }
    }

    /// Factor by which z = Ċ² is beyond what the limits allow: accelerations go with it, jerks with its power 3/2.
    pub(super) fn excess(self) -> f64 {
        let jerk = libm::cbrt(self.c_jerk.max(self.x_jerk));
        self.bound.max(self.c_acceleration).max(self.x_acceleration).max(jerk * jerk)
    }
}

/// From which share of its limit on the jerk of X is looked at between those points too, and into how many parts they are divided.
const NEAR_JERK: f64 = 0.7;
const JERK_PARTS: u32 = 8;

/// Parts of an interval between which the bound is looked at besides: a notch that a concave flank makes in it may be narrower than
/// the table is fine, and there the knots of a turn are close.
const BOUND_PARTS: u32 = 4;

/// What peaks in each interval of a turn: at its ends, at the points of the table within, and between them
/// where jerk is near its limit.
pub(super) fn peaks(request: &TurnRequest<'_>, table: &Table, speed: &SquareSpeed) -> Vec<Peaks> {
    let knots = speed.knots();
    let at_knots: Vec<(Derivatives, f64)> = (0..knots.count())
        .map(|i| {
            let path = request.path.sample(knots.at(i));
            let x = request.with_infeed(path);
            (Derivatives::from(x), request.per_square_bound(knots.at(i), path))
        })
        .collect();
    let spacing = table.spacing();
    let mut point = 0;
    let mut in_interval = |i: usize| {
        let (begin, length) = (knots.at(i), knots.length(i));
        let start = speed.within(i, 0.0);
        // z is a parabola within the interval.
        let (first, second) = (start.first, start.second);
        let z_at = |along: f64| start.z + along * (first + 0.5 * along * second);
        let mut found = Peaks::default();
        let mut largest_c_square = 0.0_f64;
        let mut look = |along: f64, x: Derivatives, per_bound: Option<f64>| {
            let (z, slope) = (z_at(along), first + along * second);
            let x_acceleration = x.second * z + 0.5 * x.first * slope;
            let x_jerk = libm::sqrt(z) * (x.third * z + 1.5 * x.second * slope + 0.5 * x.first * second);
            found.x_acceleration = found.x_acceleration.max(x_acceleration.abs());
            found.x_jerk = found.x_jerk.max(x_jerk.abs());
            found.c_acceleration = found.c_acceleration.max(0.5 * slope.abs());
            largest_c_square = largest_c_square.max(z);
            if let Some(per) = per_bound {
                found.bound = found.bound.max(per * z);
            }
            x_jerk.abs()
        };
        let near = NEAR_JERK * request.x.jerk;
        let (x, per_bound) = at_knots[i];
        let mut before = (0.0, look(0.0, x, Some(per_bound)));
        let mut step_to = |along: f64, x: Derivatives, per_bound: Option<f64>| {
            let here = look(along, x, per_bound);
            if here.max(before.1) > near {
                for part in 1..JERK_PARTS {
                    let between = before.0 + (along - before.0) * f64::from(part) / f64::from(JERK_PARTS);
                    look(between, derivatives(request, begin + between), None);
                }
            }
            before = (along, here);
        };
        while point < table.count() {
            #[allow(clippy::cast_precision_loss, reason = "some ten thousand points")]
            let along = point as f64 * spacing - begin;
            if along >= length {
                break;
            }
            if along > 0.0 {
                step_to(along, table.path(point), table.per_bound(point));
            }
            point += 1;
        }
        let (x, per_bound) = at_knots[knots.beside(i).1];
        step_to(length, x, Some(per_bound));
        for part in 1..BOUND_PARTS {
            let along = length * f64::from(part) / f64::from(BOUND_PARTS);
            let angle = begin + along;
            found.bound = found.bound.max(z_at(along) * request.per_square_bound(angle, request.path.sample(angle)));
        }
        found.x_jerk /= request.x.jerk;
        found.c_jerk = 0.5 * libm::sqrt(largest_c_square) * second.abs() / request.c.jerk;
        found.c_acceleration /= request.c.acceleration;
        found.x_acceleration /= request.x.acceleration;
        found
    };
    (0..knots.count()).map(&mut in_interval).collect()
}

fn derivatives(request: &TurnRequest<'_>, angle_rad: f64) -> Derivatives {
    Derivatives::from(request.with_infeed(request.path.sample(angle_rad)))
}
