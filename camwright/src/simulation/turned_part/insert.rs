// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The insert as the part sees it, and how it moves.

use crate::math::hermite::{cubic_path, cubic_slope};

/// A round insert: its edge is a circle in the rake plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Insert {
    /// R, radius of the edge (mm).
    pub radius_mm: f64,
    /// H, height of the rake plane above the part's axis (mm); below it negative.
    pub height_mm: f64,
}

/// Position of the axes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct InsertPose {
    /// θ = σ·C: azimuth of the X axis seen from the part (rad).
    pub turned_rad: f64,
    /// Distance of the insert's centre from the part's axis, along X (mm).
    pub x_mm: f64,
    /// Place of its centre along the part (mm).
    pub z_mm: f64,
}

impl InsertPose {
    fn values(&self) -> [f64; 3] {
        [self.turned_rad, self.x_mm, self.z_mm]
    }
}

/// A step of the axes: a cubic in each, over a share 0 … 1 of the step's time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InsertMove {
    from: InsertPose,
    /// Way of θ, x, z, and their derivatives by the share at either end.
    way: [f64; 3],
    slope_from: [f64; 3],
    slope_to: [f64; 3],
}

impl InsertMove {
    /// From one pose to another at constant speed.
    #[must_use]
    pub fn straight(from: InsertPose, to: InsertPose) -> Self {
        let way = core::array::from_fn(|i| to.values()[i] - from.values()[i]);
        Self { from, way, slope_from: way, slope_to: way }
    }

    /// A way of θ (rad), x and z (mm), with their speeds at both ends times the step's time.
    #[must_use]
    pub fn cubic(from: InsertPose, way: [f64; 3], slope_from: [f64; 3], slope_to: [f64; 3]) -> Self {
        Self { from, way, slope_from, slope_to }
    }

    #[must_use]
    pub fn from(&self) -> InsertPose {
        self.from
    }

    /// Position of the axes at share `s` of the step.
    #[must_use]
    pub fn at(&self, s: f64) -> InsertPose {
        let [turned, x, z] = self.gone(s);
        let InsertPose { turned_rad, x_mm, z_mm } = self.from;
        InsertPose { turned_rad: turned_rad + turned, x_mm: x_mm + x, z_mm: z_mm + z }
    }

    /// Of θ, x and z: a beginning, the way, and its slopes at both ends.
    pub(super) fn cubics(&self, from: [f64; 3]) -> [[f64; 4]; 3] {
        core::array::from_fn(|i| [from[i], self.way[i], self.slope_from[i], self.slope_to[i]])
    }

    /// Way done at share `s`; exactly the whole at 1.
    pub(super) fn gone(&self, s: f64) -> [f64; 3] {
        core::array::from_fn(|i| cubic_path(s, self.way[i], self.slope_from[i], self.slope_to[i]))
    }

    /// The part of it between two shares.
    #[must_use]
    pub fn between(&self, s0: f64, s1: f64) -> Self {
        let slope = |s: f64| {
            core::array::from_fn(|i| cubic_slope(s, self.way[i], self.slope_from[i], self.slope_to[i]) * (s1 - s0))
        };
        let (begin, end) = (self.gone(s0), self.gone(s1));
        Self {
            from: self.at(s0),
            way: core::array::from_fn(|i| end[i] - begin[i]),
            slope_from: slope(s0),
            slope_to: slope(s1),
        }
    }

    #[must_use]
    pub fn is_still(&self) -> bool {
        [self.way, self.slope_from, self.slope_to].iter().flatten().all(|value| *value == 0.0)
    }

    /// Bounds of θ (`axis` 0), x (1) or z (2) over the whole step: a Hermite cubic leaves the range of its ends by less than 4/27 of each slope.
    pub(super) fn range(&self, axis: usize) -> (f64, f64) {
        let begin = self.from.values()[axis];
        let end = begin + self.way[axis];
        let swing = 0.15 * (self.slope_from[axis].abs() + self.slope_to[axis].abs());
        (begin.min(end) - swing, begin.max(end) + swing)
    }
}
