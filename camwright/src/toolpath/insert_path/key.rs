// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Names of what an insert path is made from, for errors.

use crate::math::named::named;

named! {
    /// Number that an insert path is made from.
    InsertPathKey {
        InsertRadius = "the radius of the insert",
        Feed = "the feed per turn",
        Stock = "the stock",
        FinishingStock = "the stock for finishing",
        RoughingDepth = "the depth of a roughing pass",
        RoughingPasses = "the number of roughing passes",
        Angles = "the number of angles a turn",
        StartAngle = "the angle to begin at",
        Begin = "the z to begin at",
        End = "the z to end at",
        Knot = "a knot of the path",
        Length = "the length of the path (rad)",
        SpindleSpeed = "the speed of the spindle",
        MaxSpindleSpeed = "the fastest speed of the spindle",
        RunUpTime = "the time in which the spindle runs up",
        SpindleTime = "the time of the spindle",
        CVelocity = "the velocity limit of C",
        CAcceleration = "the acceleration limit of C",
        CJerk = "the jerk limit of C",
        Velocity = "velocity",
        Acceleration = "acceleration",
        Jerk = "jerk",
    }
}
