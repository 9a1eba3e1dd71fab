// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The motion of turning: C by a time law, X and Z by laws over its angle, and their derivatives in time.

use crate::machine::description::{AXIS_COUNT, Axis};
use crate::math::hermite::{HermiteSpline, Sample};
use crate::math::hermite_exact::ExactHermite;
use crate::math::twofold::Twofold;
use crate::motion::cut_motion::chain;
use crate::motion::plan::{Plan, SpiralSegment};

/// Motion along one spiral: what a [`SpiralSegment`] says, at any time.
#[derive(Debug, Clone, Copy)]
pub struct SpiralMotion<'a> {
    /// `x_axis` position over the angle since the start (mm over rad).
    pub path: &'a HermiteSpline,
    /// `z_axis` position over the angle since the start (mm over rad).
    pub advance: &'a HermiteSpline,
    /// Angle since the start over time (rad over s).
    pub law: &'a HermiteSpline,
}

impl SpiralMotion<'_> {
    /// Length (s).
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.law.end()
    }

    /// Angle of C from its start to its end (rad).
    #[must_use]
    pub fn angle_rad(&self) -> f64 {
        let knots = self.law.knots();
        knots[knots.len() - 1].value
    }

    /// All axes at a time, with derivatives in time: C as the angle since the start (rad), X and Z as positions (mm). Before its start and
    /// after its end they rest.
    #[must_use]
    pub fn at(&self, time_s: f64) -> [Sample; AXIS_COUNT] {
        let c = self.law.sample(time_s);
        let mut axes = [c; AXIS_COUNT];
        axes[Axis::X.index()] = chain(self.path.sample(c.value), c);
        axes[Axis::Z.index()] = chain(self.advance.sample(c.value), c);
        axes
    }
}

/// Positions along a spiral with the digits that a float loses behind many turns, for checks that difference them. Times follow each
/// other; before its start and after its end it rests.
#[derive(Debug, Clone)]
pub(crate) struct ExactSpiral<'a> {
    path: ExactHermite<'a>,
    advance: ExactHermite<'a>,
    law: ExactHermite<'a>,
}

impl<'a> ExactSpiral<'a> {
    pub(crate) fn new(motion: &SpiralMotion<'a>) -> Self {
        Self {
            path: ExactHermite::new(motion.path),
            advance: ExactHermite::new(motion.advance),
            law: ExactHermite::new(motion.law),
        }
    }

    /// Position of one axis, as of [`SpiralMotion::at`] (rad or mm).
    pub(crate) fn position(&mut self, axis: Axis, time_s: Twofold) -> Twofold {
        let c = self.law.at(time_s);
        match axis {
            Axis::C => c,
            Axis::X => self.path.at(c),
            Axis::Z => self.advance.at(c),
        }
    }
}

impl Plan {
    /// The motion of a spiral of this plan; `None` if it names splines that the plan does not have.
    #[must_use]
    pub fn motion_of_spiral(&self, spiral: &SpiralSegment) -> Option<SpiralMotion<'_>> {
        Some(SpiralMotion {
            path: self.angle_laws.get(spiral.path)?,
            advance: self.angle_laws.get(spiral.advance)?,
            law: self.time_laws.get(spiral.speed)?,
        })
    }
}
