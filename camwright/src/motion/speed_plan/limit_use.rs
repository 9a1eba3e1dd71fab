// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Utilisation of the axis limits by a motion, computed twice: by the chain rule, and by differencing positions.

use super::{PATH_SHARE, cam_angle_deg};
use crate::machine::description::{Axis, MotionLimits};
use crate::math::differences::{Extreme, largest_exact_derivatives};
use crate::math::twofold::Twofold;
use crate::motion::cut_motion::{CutMotion, ExactCut};
use alloc::string::String;
use alloc::vec::Vec;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitedQuantity {
    Velocity,
    Acceleration,
    Jerk,
}

impl LimitedQuantity {
    /// In the order of derivatives.
    pub const ALL: [LimitedQuantity; 3] =
        [LimitedQuantity::Velocity, LimitedQuantity::Acceleration, LimitedQuantity::Jerk];

    /// The limit of this quantity.
    #[must_use]
    pub const fn limit(self, limits: &MotionLimits) -> f64 {
        match self {
            LimitedQuantity::Velocity => limits.velocity,
            LimitedQuantity::Acceleration => limits.acceleration,
            LimitedQuantity::Jerk => limits.jerk,
        }
    }

    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            LimitedQuantity::Velocity => "velocity",
            LimitedQuantity::Acceleration => "acceleration",
            LimitedQuantity::Jerk => "jerk",
        }
    }

    /// Its unit on an axis.
    #[must_use]
    pub const fn unit(self, axis: Axis) -> &'static str {
        match (axis, self) {
            (Axis::C, LimitedQuantity::Velocity) => "rad/s",
            (Axis::C, LimitedQuantity::Acceleration) => "rad/s²",
            (Axis::C, LimitedQuantity::Jerk) => "rad/s³",
            (_, LimitedQuantity::Velocity) => "mm/s",
            (_, LimitedQuantity::Acceleration) => "mm/s²",
            (_, LimitedQuantity::Jerk) => "mm/s³",
        }
    }
}

/// Largest use of one limit of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitUse {
    pub axis: Axis,
    pub quantity: LimitedQuantity,
    /// Largest magnitude met (mm or rad, s).
    pub value: f64,
    /// Most allowed (mm or rad, s).
    pub allowed: f64,
    /// Cam angle at which it was met (rad): that of the wheel line in the lobe's frame.
    pub angle_rad: f64,
    /// Time since the start of the motion at which it was met (s).
    pub time_s: f64,
}

impl LimitUse {
    /// Largest magnitude over what is allowed.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.value / self.allowed
    }

    /// Speed of the motion over the largest that keeps this limit: a velocity grows with it, an acceleration with its square, a jerk with
    /// its cube.
    #[must_use]
    pub fn speed_ratio(&self) -> f64 {
        match self.quantity {
            LimitedQuantity::Velocity => self.ratio(),
            LimitedQuantity::Acceleration => libm::sqrt(self.ratio()),
            LimitedQuantity::Jerk => libm::cbrt(self.ratio()),
        }
    }
}

impl core::fmt::Display for LimitUse {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let unit = self.quantity.unit(self.axis);
        write!(
            f,
            "{} needs a {} of {} {unit} at cam angle {:.1} deg, {} {unit} are allowed",
            self.axis.joint(),
            self.quantity.name(),
            figures(self.value),
            cam_angle_deg(self.angle_rad),
            figures(self.allowed),
        )
    }
}

/// A number at five significant digits, without an exponent.
pub(crate) fn figures(value: f64) -> String {
    #[allow(clippy::cast_possible_truncation, reason = "between 0 and 9")]
    let decimals = (4.0 - libm::floor(libm::log10(value.abs().max(1e-9)))).clamp(0.0, 9.0) as usize;
    let text = alloc::format!("{value:.decimals$}");
    match text.contains('.') {
        true => String::from(text.trim_end_matches('0').trim_end_matches('.')),
        false => text,
    }
}

/// The stretches of a cut in which everything happens that can happen: ramps with a turn beside them, and the end of the
/// infeed. In between speed and infeed repeat from turn to turn.
pub(crate) fn windows(
    motion: &CutMotion<'_>,
    plateau_s: (f64, f64),
    turn_s: f64,
    blend: (f64, f64),
) -> Vec<(f64, f64)> {
    let (start, end) = (motion.start_s(), motion.end_s());
    let mut windows: Vec<(f64, f64)> = Vec::with_capacity(3);
    for (from, to) in [
        (start, plateau_s.0 + turn_s),
        (motion.time_of(blend.0) - 0.05 * turn_s, motion.time_of(blend.1) + 0.05 * turn_s),
        (plateau_s.1 - turn_s, end),
    ] {
        let (from, to) = (from.max(start), to.min(end));
        match windows.last_mut() {
            Some(last) if from <= last.1 => last.1 = last.1.max(to),
            _ => windows.push((from, to)),
        }
    }
    windows
}

fn collect(
    motion: &CutMotion<'_>,
    found: &[[Extreme; 3]; 2],
    c: &MotionLimits,
    x: &MotionLimits,
    path_share: f64,
) -> Vec<LimitUse> {
    let mut uses = Vec::with_capacity(6);
    for (axis, limits, extremes) in [(Axis::C, c, &found[0]), (Axis::X, x, &found[1])] {
        for (quantity, extreme) in LimitedQuantity::ALL.into_iter().zip(extremes) {
            let share = if quantity == LimitedQuantity::Velocity { 1.0 } else { path_share };
            uses.push(LimitUse {
                axis,
                quantity,
                value: extreme.value,
                allowed: share * quantity.limit(limits),
                angle_rad: motion.path_start_rad + motion.law.sample(extreme.at).value,
                time_s: extreme.at,
            });
        }
    }
    uses
}

/// Use of every limit by the chain rule on a grid, against the share a path may use. Angles are those of the path.
pub(super) fn uses_by_chain_rule(
    motion: &CutMotion<'_>,
    windows: &[(f64, f64)],
    step: f64,
    c: &MotionLimits,
    x: &MotionLimits,
) -> Vec<LimitUse> {
    let mut found = [[Extreme::default(); 3]; 2];
    for (from, to) in windows {
        #[allow(clippy::cast_possible_truncation, reason = "a grid of at most millions")]
        let count = libm::ceil((to - from) / step) as u64;
        for k in 0..=count {
            let at = (from + k as f64 * step).min(*to);
            let sample = motion.at(at);
            for (extremes, s) in found.iter_mut().zip([sample.c, sample.x]) {
                extremes[0].add(s.first, at);
                extremes[1].add(s.second, at);
                extremes[2].add(s.third, at);
            }
        }
    }
    collect(motion, &found, c, x, PATH_SHARE)
}

/// Use of every limit by differencing positions over time, against the whole limit. Angles are those of the path, σ times
/// cam angles.
#[must_use]
pub fn uses_by_differences(
    motion: &CutMotion<'_>,
    windows: &[(f64, f64)],
    step: f64,
    c: &MotionLimits,
    x: &MotionLimits,
) -> Vec<LimitUse> {
    let mut found = [[Extreme::default(); 3]; 2];
    for (from, to) in windows {
        // Three steps before the start and after the end, where X rests and C goes on as it does, so that a jump there would show.
        let (from, to) = (Twofold::from(from - 3.0 * step), Twofold::from(to + 3.0 * step));
        let mut exact = ExactCut::new(motion);
        let of_axes = largest_exact_derivatives(|t| exact.at(t), from, to, step);
        for (extremes, new) in found.iter_mut().zip(of_axes) {
            for (extreme, new) in extremes.iter_mut().zip(new) {
                extreme.add(new.value, new.at);
            }
        }
    }
    collect(motion, &found, c, x, 1.0)
}
