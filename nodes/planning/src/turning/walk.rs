// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A pass as it is executed: all three axes over time.

use camwright::math::hermite::Sample;
use camwright::motion::cut_motion::chain;
use camwright::planner::PlannedPass;

/// The axes at a time of a pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PassPoint {
    /// Turned angle θ of the path (rad).
    pub(crate) turned_rad: f64,
    /// C since the pass began, and its derivatives in time (rad, s).
    pub(crate) c: Sample,
    /// X (mm, s).
    pub(crate) x: Sample,
    /// Z of the insert's centre along the part (mm, s).
    pub(crate) z: Sample,
}

/// Time between two points that are looked at (s): a third of what the fastest spindle takes from one knot of a path to the next.
const STEP_S: f64 = 1e-4;

/// Fewest and most points of a pass.
const COUNT: (f64, f64) = (1e3, 2e6);

/// The axes at one time.
fn point_at(pass: &PlannedPass, time_s: f64) -> PassPoint {
    let c = pass.spindle.law.sample(time_s);
    let turned_rad = pass.path.x().start() + c.value;
    let (x, z) = (chain(pass.path.x().sample(turned_rad), c), chain(pass.path.z_at(turned_rad), c));
    PassPoint { turned_rad, c, x, z }
}

/// The axes all along a pass.
pub(crate) fn points(pass: &PlannedPass) -> impl Iterator<Item = PassPoint> {
    let end_s = pass.spindle.law.end();
    #[allow(clippy::cast_possible_truncation, reason = "within the bounds")]
    let count = (end_s / STEP_S).ceil().clamp(COUNT.0, COUNT.1) as u32;
    (0..=count).map(move |index| point_at(pass, end_s * f64::from(index) / f64::from(count)))
}
