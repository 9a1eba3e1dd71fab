// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Parts turned under the wheel, and their setpoints.

use super::{ease, setpoint};
use camwright::machine::description::MachineDescription;
use camwright::machine::setpoint::Setpoint;
use camwright::math::units::TURN_RAD;

pub(crate) const WHEEL_MM: f64 = 60.0;

/// A disc of this radius whose centre lies this far from the axis, at azimuth 0.
#[derive(Clone, Copy)]
pub(crate) struct Eccentric {
    pub(crate) radius_mm: f64,
    pub(crate) offset_mm: f64,
}

impl Eccentric {
    /// `x_axis` and its first and second derivative over the wheel-line angle:
    /// X = E cos θ + √((r+R)² − E² sin² θ) − R.
    pub(crate) fn path(self, angle: f64) -> (f64, f64, f64) {
        let (e, l) = (self.offset_mm, self.radius_mm + WHEEL_MM);
        let (s, c) = angle.sin_cos();
        let root = (l * l - e * e * s * s).sqrt();
        let first = -e * e * s * c / root;
        let second = -e * e * (c * c - s * s) / root - first * first / root;
        (e * c + root - WHEEL_MM, -e * s + first, -e * c + second)
    }

    /// The path over an angle of C, in its sense of rotation.
    pub(crate) fn path_over_c(self, sense: f64, c: f64) -> (f64, f64, f64) {
        let (x, first, second) = self.path(sense * c);
        (x, sense * first, second)
    }

    /// Polar radius at an azimuth of the part.
    pub(crate) fn radius(self, azimuth: f64) -> f64 {
        let (s, c) = azimuth.sin_cos();
        self.offset_mm * c + (self.radius_mm.powi(2) - (self.offset_mm * s).powi(2)).sqrt()
    }
}

/// C turns so many times from 0, the table stands, X over the angle of C with two derivatives (mm over rad); at rest at both ends.
pub(crate) fn turning(
    description: &MachineDescription,
    z_mm: f64,
    turns: f64,
    ticks: u32,
    x: impl Fn(f64) -> (f64, f64, f64),
) -> Vec<Setpoint> {
    let seconds = f64::from(ticks) * description.cycle_time_s();
    (0..=ticks)
        .map(|k| {
            let (share, first, second) = ease(f64::from(k) / f64::from(ticks));
            let whole = turns * TURN_RAD;
            let (c, c1, c2) = (whole * share, whole * first / seconds, whole * second / seconds / seconds);
            let (at, x1, x2) = x(c);
            setpoint(description, [c, at, z_mm], [c1, x1 * c1, 0.0], [c2, x2 * c1 * c1 + x1 * c2, 0.0])
        })
        .collect()
}
