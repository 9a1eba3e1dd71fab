// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The motion of a radius under the wheel that begins with a constant, and what share the rest has in radii and depths.

use super::wheel_log::WheelLog;
use crate::machine::contact_law::ContactLaw;
use crate::math::units::TURN_RAD;

/// Rounding of an angle (rad).
pub(super) const ROUNDING_RAD: f64 = 1e-9;

/// q: what the wheel makes of a phase that began at a constant radius.
#[derive(Debug, Clone, Copy)]
pub(super) struct ReferenceMotion<'a> {
    pub(super) law: ContactLaw,
    pub(super) log: WheelLog<'a>,
    /// C at which it begins (rad).
    pub(super) from_rad: f64,
    /// The constant (mm).
    pub(super) base_mm: f64,
}

impl<'a> ReferenceMotion<'a> {
    /// With its beginning at an angle of the headstock; the constant is what the wheel there would leave in the end, so that q has no
    /// step at its beginning.
    pub(super) fn from(law: ContactLaw, log: WheelLog<'a>, from_rad: f64) -> Self {
        Self { law, log, from_rad, base_mm: log.x_mm(from_rad) + law.threshold_n() / law.machine_n_mm() }
    }

    /// λ^((C − `C_s`)/2π): what of g is in the radius at C.
    pub(super) fn share(&self, c_rad: f64) -> f64 {
        libm::pow(self.law.decay(), (c_rad - self.from_rad) / TURN_RAD)
    }

    /// q(C), less than a turn before its start the constant.
    pub(super) fn radius_mm(&self, c_rad: f64) -> f64 {
        let turns = libm::floor((c_rad - self.from_rad + ROUNDING_RAD) / TURN_RAD);
        let (keeps, rests_mm) = (self.law.decay(), self.law.threshold_n() / self.law.machine_n_mm());
        let mut above_mm = 0.0;
        let mut turn = turns;
        while turn >= 0.0 {
            let end_mm = self.log.x_mm(c_rad - turn * TURN_RAD) + rests_mm - self.base_mm;
            above_mm = keeps * above_mm + (1.0 - keeps) * end_mm;
            turn -= 1.0;
        }
        self.base_mm + above_mm
    }

    /// `U_q`(C).
    pub(super) fn depth_mm(&self, c_rad: f64) -> f64 {
        self.radius_mm(c_rad - TURN_RAD) - self.radius_mm(c_rad)
    }

    /// a(C).
    pub(super) fn weight(&self, c_rad: f64) -> f64 {
        (1.0 - self.law.decay()) * self.share(c_rad - TURN_RAD)
    }
}
