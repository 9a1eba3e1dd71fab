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

/// Parts of an interval between which the bound is looked at besides: a notch that a concave flank makes in it may be narrower than
/// the table is fine, and there the knots of a turn are close.
const BOUND_PARTS: u32 = 4;

/// What peaks in each interval of a turn: at its ends, at the points of the table within, and on parabolas through three of them.
pub(super) fn peaks(request: &TurnRequest<'_>, table: &Table, speed: &SquareSpeed) -> Vec<Peaks> {
    let knots = speed.knots();
    let at_knots: Vec<(Derivatives, f64)> = (0..knots.count())
        .map(|i| {
            let path = request.path.sample(knots.at(i));
            let x = request.with_infeed(path);
            let derivatives = Derivatives { first: x.first, second: x.second, third: x.third };
            (derivatives, request.per_square_bound(knots.at(i), path))
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
            x_jerk
        };
        for (along, (x, per_bound)) in [(0.0, at_knots[i]), (length, at_knots[knots.beside(i).1])] {
            look(along, x, Some(per_bound));
        }
        let (mut last, mut seen, mut between) = ([0.0; 2], 0, 0.0_f64);
        while point < table.count() {
            #[allow(clippy::cast_precision_loss, reason = "some ten thousand points")]
            let along = point as f64 * spacing - begin;
            if along >= length {
                break;
            }
            if along >= 0.0 {
                let here = look(along, table.path(point), table.per_bound(point));
                seen += 1;
                if seen > 2 {
                    between = between.max(peak_of_parabola(last[0], last[1], here));
                }
                last = [last[1], here];
            }
            point += 1;
        }
        for part in 1..BOUND_PARTS {
            let along = length * f64::from(part) / f64::from(BOUND_PARTS);
            let angle = begin + along;
            found.bound = found.bound.max(z_at(along) * request.per_square_bound(angle, request.path.sample(angle)));
        }
        found.x_jerk = found.x_jerk.max(between) / request.x.jerk;
        found.c_jerk = 0.5 * libm::sqrt(largest_c_square) * second.abs() / request.c.jerk;
        found.c_acceleration /= request.c.acceleration;
        found.x_acceleration /= request.x.acceleration;
        found
    };
    (0..knots.count()).map(&mut in_interval).collect()
}

/// Magnitude of the vertex of the parabola through three points at equal distances, if it lies between them; else 0.
fn peak_of_parabola(before: f64, middle: f64, after: f64) -> f64 {
    let (bend, slope) = (before - 2.0 * middle + after, 0.5 * (after - before));
    if slope.abs() < bend.abs() { (middle - 0.5 * slope * slope / bend).abs() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vertex_of_a_parabola_is_found_between_its_points() {
        let at = |x: f64| 3.0 - 2.0 * (x - 0.3) * (x - 0.3);
        assert!((peak_of_parabola(at(-1.0), at(0.0), at(1.0)) - 3.0).abs() < 1e-12);
        assert_eq!(peak_of_parabola(1.0, 2.0, 3.0).to_bits(), 0.0_f64.to_bits());
        assert_eq!(peak_of_parabola(at(1.0), at(2.0), at(3.0)).to_bits(), 0.0_f64.to_bits());
    }
}
