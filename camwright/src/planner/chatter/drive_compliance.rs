// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Dynamic compliance of a servo axis: motion of its tool per force on its slide.
//!
//! ```text
//!  force ──► [ slide (1 − μ) m ]──/\/\/──[ structure μ m ]── tool
//!                 ▲ position and velocity loop, once per servo step
//! ```
//! The loops are those of the machine file in the form of a sampled drive: the speed is the mean over the last step, the force is held
//! over a step, and the integral of the velocity loop follows the difference to a reference model. Friction that does not grow with the
//! speed is left out: a slide that it holds does not take part in chatter.

use crate::machine::description::{AxisDescription, AxisScale};
use crate::math::complex::{Complex, exponential};

/// Servo axis under a force on its slide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveCompliance {
    /// Period of the servo loops (s).
    step_s: f64,
    /// Acceleration per force (mm/s² per N).
    per_force: f64,
    kv_1_s: f64,
    loop_rad_s: f64,
    /// Rate of the integral (1/s²); 0: none.
    integral: f64,
    viscous_1_s: f64,
    /// Frequency (rad/s), damping and share of the mass of the structure; `None`: rigid.
    structure: Option<(f64, f64, f64)>,
}

impl DriveCompliance {
    /// Compliance of a linear axis with servo steps of this length (s); `None` of an ideal drive, which no force moves.
    #[must_use]
    pub fn new(axis: &AxisDescription, step_s: f64) -> Option<Self> {
        let AxisScale::Linear { .. } = axis.scale else { return None };
        let drive = &axis.drive;
        let loop_rad_s = drive.velocity_loop_rad_s?;
        let per_force = 1e3 / axis.inertia;
        Some(Self {
            step_s,
            per_force,
            kv_1_s: drive.kv_1_s * (1.0 + drive.gain_error),
            loop_rad_s,
            integral: drive.velocity_integral_s.map_or(0.0, |integral_s| loop_rad_s / integral_s),
            viscous_1_s: drive.viscous_friction * per_force,
            structure: drive
                .structure
                .map(|structure| (structure.frequency_rad_s, structure.damping, structure.mass_share)),
        })
    }

    /// Motion of the tool per force at a complex frequency (mm/N).
    #[must_use]
    pub fn at(&self, s: Complex<f64>) -> Complex<f64> {
        let (h, w, kv) = (self.step_s, self.loop_rad_s, self.kv_1_s);
        let one = Complex::new(1.0, 0.0);
        // Tool per slide, and the force per way of slide and structure, over the whole mass.
        let (tool, inertia) = match self.structure {
            None => (one, s * s),
            Some((rad_s, damping, share)) => {
                let spring = s * (2.0 * damping * rad_s) + rad_s * rad_s;
                let tool = spring / (s * s + spring);
                (tool, s * s * (1.0 - share) + s * s * tool * share)
            }
        };
        let slide = one / (inertia + s * self.viscous_1_s);
        // Delay by one step, difference over a step, and a force that is held over a step.
        let late = exponential(-s * h);
        let change = exponential(s * h) - 1.0;
        let held = (one - late) / (s * h);
        let mean_speed = late * change / h;
        // Reference model: behind the same gains, free of the force.
        let middle = (late + 1.0) * 0.5;
        let model = -middle * (h * w * kv) / (change + middle * (h * w));
        let motor = mean_speed * w + w * kv + (mean_speed - model) * (self.integral * h) / change;
        let held = slide * held;
        held * tool * self.per_force / (motor * held + one)
    }

    /// Natural frequencies: structure and velocity loop (rad/s).
    pub(super) fn natural_rad_s(&self) -> impl Iterator<Item = f64> + use<> {
        let structure = self.structure.map(|(rad_s, _, share)| rad_s / libm::sqrt(1.0 - share));
        [Some(self.loop_rad_s), structure].into_iter().flatten()
    }
}
