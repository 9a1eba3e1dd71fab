// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Utilisation of the axis limits by a run: bounded interval by interval, not sampled.
//!
//! Speed, acceleration and jerk of C lie within ranges from one knot of its law to the next, the derivatives of X and Z over C within
//! others; where both overlap, ẋ = X′ω, ẍ = X″ω² + X′ω̇ and the jerk X‴ω³ + 3X″ωω̇ + X′ω̈ are no larger than with the largest magnitudes.

use crate::machine::description::{AXIS_COUNT, Axis, MotionLimits};
use crate::math::hermite::Knot;
use crate::motion::speed_plan::LimitedQuantity;
use alloc::vec::Vec;

/// Parts into which a stretch is cut in which C's speed changes: the bounds are nearer by as much.
const PARTS: u32 = 8;

/// A limit and how far it is used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Use {
    pub(super) axis: Axis,
    pub(super) quantity: LimitedQuantity,
    pub(super) value: f64,
    pub(super) allowed: f64,
    /// Angle since the start (rad).
    pub(super) at_rad: f64,
    /// C's speed changes there: a longer ramp may do.
    pub(super) ramps: bool,
}

impl Use {
    pub(super) fn ratio(&self) -> f64 {
        self.value / self.allowed
    }
}

/// Maximum of C over an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LimitRange {
    from_rad: f64,
    to_rad: f64,
    max: [f64; 3],
}

/// Motion of C, interval by interval.
#[derive(Debug, Clone)]
pub(super) struct HeadstockUse {
    stretches: Vec<LimitRange>,
}

/// A slide over the angle of C.
#[derive(Debug, Clone)]
pub(super) struct Slide {
    pub(super) axis: Axis,
    pub(super) knots: Vec<Knot>,
}

/// Largest magnitudes of the first three derivatives between two knots of a cubic.
fn maximum_between(left: &Knot, right: &Knot) -> [f64; 3] {
    let gap = right.at - left.at;
    // Where the second derivative changes its sign the first has its extremum inside, at most so much beyond the ends.
    let beyond =
        if left.second * right.second < 0.0 { 0.5 * gap * left.second.abs().min(right.second.abs()) } else { 0.0 };
    [
        left.first.abs().max(right.first.abs()) + beyond,
        left.second.abs().max(right.second.abs()),
        (right.second - left.second).abs() / gap,
    ]
}

/// A place of the cubic between two knots.
fn within(left: &Knot, right: &Knot, share: f64) -> Knot {
    let (gap, third) = (right.at - left.at, (right.second - left.second) / (right.at - left.at));
    let u = share * gap;
    Knot {
        at: left.at + u,
        value: left.value + u * (left.first + u * (0.5 * left.second + u * third / 6.0)),
        first: left.first + u * (left.second + 0.5 * u * third),
        second: left.second + u * third,
    }
}

impl HeadstockUse {
    /// From knots of C over time, between which it is a cubic.
    pub(super) fn new(knots: &[Knot]) -> Self {
        let mut stretches = Vec::with_capacity(knots.len());
        for pair in knots.windows(2) {
            let (left, right) = (pair[0], pair[1]);
            let changes = left.second.abs() > 0.0 || right.second.abs() > 0.0;
            let parts = if changes { PARTS } else { 1 };
            let place = |part: u32| match part {
                0 => left,
                part if part == parts => right,
                part => within(&left, &right, f64::from(part) / f64::from(parts)),
            };
            for part in 0..parts {
                let (from, to) = (place(part), place(part + 1));
                stretches.push(LimitRange { from_rad: from.value, to_rad: to.value, max: maximum_between(&from, &to) });
            }
        }
        Self { stretches }
    }

    pub(super) fn fastest_rad_s(&self) -> f64 {
        self.stretches.iter().map(|stretch| stretch.max[0]).fold(0.0, f64::max)
    }

    /// Largest utilisation of C's acceleration and jerk limits; its speed is an average of the programmed one.
    pub(super) fn ratio(&self, limits: &MotionLimits) -> f64 {
        let ratio = |stretch: &LimitRange| (stretch.max[1] / limits.acceleration).max(stretch.max[2] / limits.jerk);
        self.stretches.iter().map(ratio).fold(0.0, f64::max)
    }
}

/// The limit that is used most; limits in the order of [`Axis::ALL`].
pub(super) fn worst_use(turning: &HeadstockUse, slides: &[Slide; 2], limits: &[MotionLimits; AXIS_COUNT]) -> Use {
    let mut worst = Use {
        axis: Axis::C,
        quantity: LimitedQuantity::Velocity,
        value: turning.fastest_rad_s(),
        allowed: limits[Axis::C.index()].velocity,
        at_rad: 0.0,
        ramps: false,
    };
    // A sum of averages may round a digit above it.
    worst.value = worst.value.min(worst.allowed);
    let mut take = |axis: Axis, values: [f64; 3], at_rad: f64, ramps: bool| {
        for (quantity, value) in LimitedQuantity::ALL.into_iter().zip(values) {
            let allowed = quantity.limit(&limits[axis.index()]);
            if value / allowed > worst.ratio() {
                worst = Use { axis, quantity, value, allowed, at_rad, ramps };
            }
        }
    };
    for stretch in &turning.stretches {
        take(Axis::C, [0.0, stretch.max[1], stretch.max[2]], stretch.to_rad, true);
    }
    for slide in slides {
        let mut first = 0;
        for pair in slide.knots.windows(2) {
            let [a, b, c] = maximum_between(&pair[0], &pair[1]);
            while first + 1 < turning.stretches.len() && turning.stretches[first].to_rad <= pair[0].at {
                first += 1;
            }
            for stretch in turning.stretches[first..].iter().take_while(|stretch| stretch.from_rad < pair[1].at) {
                let [w, rise, bend] = stretch.max;
                let turns = [a * w, b * w * w, c * w * w * w];
                let values = [turns[0], turns[1] + a * rise, turns[2] + 3.0 * b * w * rise + a * bend];
                let at_rad = 0.5 * (stretch.from_rad.max(pair[0].at) + stretch.to_rad.min(pair[1].at));
                // What stays at constant speed no ramp will mend.
                let limit = &limits[slide.axis.index()];
                let ramps = turns[1] <= limit.acceleration && turns[2] <= limit.jerk;
                take(slide.axis, values, at_rad, ramps);
            }
        }
    }
    worst
}
