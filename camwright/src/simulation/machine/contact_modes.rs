// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Vibration modes between wheel and part: masses on a share of the contact's compliance.
//!
//! ```text
//!  part ──[ spring ]──[ q₁ ]──[ q₂ ]── wheel        q̈ + 2 ζ ω q̇ + ω² q = ω² F/k
//! ```
//! Each step is exact for a force that changes linearly over it. The force at its end depends on where the modes are then; both are
//! found together, as a spring that is stiffer than all of the compliance, in front of a wheel that stands where the old force leaves it.

use crate::machine::contact_law::ContactLaw;
use crate::machine::description::{ContactDescription, ContactMode};
use alloc::vec::Vec;

/// Largest part of a radian of the fastest mode in a step.
const MAX_ANGLE_RAD: f64 = 0.25;

/// Amplitude below which a mode is at rest (mm).
const AT_REST_MM: f64 = 1e-9;

/// Motion of one mode.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ModeMotion {
    mode: ContactMode,
    /// Deflection along the normal (mm) and its rate (mm/s).
    at_mm: f64,
    rate_mm_s: f64,
}

crate::snapshot!(ModeMotion { at_mm, rate_mm_s } on { mode });

/// Modes of the contact.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ContactModes {
    motions: Vec<ModeMotion>,
    spring_share: f64,
    /// Force at the end of the last step (N).
    force_n: f64,
    /// Compliance of the contact in the last step (mm/N).
    compliance_mm_n: f64,
}

/// Wheel and contact law in which a step finds its force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ModeStep {
    /// Position of the modes at the end of the step if the force stayed none (mm).
    pub(super) away_mm: f64,
    /// Law of the springs that the end of the step feels.
    pub(super) law: ContactLaw,
}

/// Response of a mode over a step.
struct StepResponse {
    /// Rows: deflection and rate at the end; columns: both at the beginning.
    free: [[f64; 2]; 2],
    /// Deflection and rate at the end per change of the static deflection over the step.
    forced: [f64; 2],
}

impl StepResponse {
    fn new(mode: &ContactMode, step_s: f64) -> Self {
        let (w, z) = (mode.frequency_rad_s, mode.damping);
        let damped = w * libm::sqrt(1.0 - z * z);
        let decay = libm::exp(-z * w * step_s);
        let (sin, cos) = libm::sincos(damped * step_s);
        let (sin, cos) = (decay * sin, decay * cos);
        let free = [[cos + z * w / damped * sin, sin / damped], [-w * w / damped * sin, cos - z * w / damped * sin]];
        // A static deflection that grows by u over the step: q = u t/h − 2ζ u/(ω h), and what swings back from there.
        let lag = 2.0 * z / w;
        let forced =
            [(step_s - lag + free[0][0] * lag - free[0][1]) / step_s, (1.0 + free[1][0] * lag - free[1][1]) / step_s];
        Self { free, forced }
    }

    /// Deflection and rate at the end while the static deflection stays.
    fn without_change(&self, motion: &ModeMotion, static_mm: f64) -> [f64; 2] {
        let from = motion.at_mm - static_mm;
        let row = |row: &[f64; 2]| row[0] * from + row[1] * motion.rate_mm_s;
        [static_mm + row(&self.free[0]), row(&self.free[1])]
    }
}

impl ContactModes {
    /// At rest; `None` of a contact without modes.
    pub(super) fn new(contact: &ContactDescription) -> Option<Self> {
        let motion = |mode: &ContactMode| ModeMotion { mode: *mode, at_mm: 0.0, rate_mm_s: 0.0 };
        let motions: Vec<ModeMotion> = contact.modes.iter().map(motion).collect();
        let spring_share = contact.spring_share();
        (!motions.is_empty()).then_some(Self { motions, spring_share, force_n: 0.0, compliance_mm_n: 0.0 })
    }

    /// Steps into which a servo step is divided.
    pub(super) fn steps(&self, step_s: f64) -> f64 {
        let fastest = self.motions.iter().map(|motion| motion.mode.frequency_rad_s).fold(0.0, f64::max);
        libm::ceil(fastest * step_s / MAX_ANGLE_RAD)
    }

    /// Sum of the sizes of all deflections (mm).
    pub(super) fn reach_mm(&self) -> f64 {
        self.motions.iter().map(|motion| motion.at_mm.abs()).sum()
    }

    /// A mode has not come to rest where the force holds it.
    pub(super) fn vibrates(&self) -> bool {
        self.motions.iter().any(|motion| {
            let held_mm = motion.mode.compliance_share * self.compliance_mm_n * self.force_n;
            (motion.at_mm - held_mm).abs() > AT_REST_MM
                || motion.rate_mm_s.abs() > AT_REST_MM * motion.mode.frequency_rad_s
        })
    }

    /// Prepares a step of this length on a contact with this law, in which the part has its own compliance (mm/N); `None` where the
    /// numbers make no law. Modes belong to the machine: the part is a spring without mass beside them.
    pub(super) fn begin(&self, law: &ContactLaw, part_mm_n: f64, step_s: f64) -> Option<ModeStep> {
        let compliance = 1.0 / law.machine_n_mm() - part_mm_n;
        let (mut away_mm, mut soft) = (0.0, self.spring_share * compliance + part_mm_n);
        for motion in &self.motions {
            let (response, own) = (StepResponse::new(&motion.mode, step_s), motion.mode.compliance_share * compliance);
            let static_mm = own * self.force_n;
            away_mm += response.without_change(motion, static_mm)[0] - response.forced[0] * static_mm;
            soft += response.forced[0] * own;
        }
        let law = ContactLaw::new(1.0 / soft, law.grinding_n_mm(), law.threshold_n()).ok()?;
        Some(ModeStep { away_mm, law })
    }

    /// Ends a step of this length with a force (N).
    pub(super) fn finish(&mut self, (law, part_mm_n): (&ContactLaw, f64), step_s: f64, force_n: f64) {
        let compliance = 1.0 / law.machine_n_mm() - part_mm_n;
        self.compliance_mm_n = compliance;
        let before_n = core::mem::replace(&mut self.force_n, force_n);
        for motion in &mut self.motions {
            let (response, own) = (StepResponse::new(&motion.mode, step_s), motion.mode.compliance_share * compliance);
            let [at_mm, rate_mm_s] = response.without_change(motion, own * before_n);
            let change_mm = own * (force_n - before_n);
            motion.at_mm = at_mm + response.forced[0] * change_mm;
            motion.rate_mm_s = rate_mm_s + response.forced[1] * change_mm;
        }
    }

    /// At rest without a force.
    pub(super) fn rest(&mut self) {
        self.force_n = 0.0;
        for motion in &mut self.motions {
            (motion.at_mm, motion.rate_mm_s) = (0.0, 0.0);
        }
    }
}

impl crate::math::snapshot::Snapshot for ContactModes {
    fn snapshot(
        &mut self,
        codec: &mut crate::math::snapshot::SnapshotCodec<'_>,
    ) -> Result<(), crate::math::snapshot::SnapshotError> {
        let Self { motions, spring_share: _, force_n, compliance_mm_n } = self;
        codec.field("force_n", |codec| force_n.snapshot(codec))?;
        codec.field("compliance_mm_n", |codec| compliance_mm_n.snapshot(codec))?;
        for motion in motions {
            codec.field("motion", |codec| motion.snapshot(codec))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::description::StiffnessAt;
    use crate::math::units::TURN_RAD;
    use alloc::vec;

    fn modes() -> (ContactModes, ContactLaw) {
        let contact = ContactDescription {
            stiffness: vec![StiffnessAt { z_mm: 0.0, n_mm: 20e3 }],
            grinding_n_mm2: 2e3,
            threshold_n_mm: 0.5,
            part_share: 0.5,
            modes: vec![
                ContactMode { frequency_rad_s: 200.0 * TURN_RAD, damping: 0.03, compliance_share: 0.3 },
                ContactMode { frequency_rad_s: 90.0 * TURN_RAD, damping: 0.05, compliance_share: 0.4 },
            ],
        };
        (ContactModes::new(&contact).expect("two modes"), contact.law(0.0, 20.0).expect("a law"))
    }

    /// Under a steady engagement the modes come to rest where the contact law without them stands, behind a rigid part and a slender one:
    /// the modes have their shares of the machine's own compliance.
    #[test]
    fn at_rest_all_of_it_is_the_contact_law() {
        for part_mm_n in [0.0, 1.2e-4] {
            let (mut modes, rigid) = modes();
            let (law, engagement_mm, mut force_n) = (rigid.in_series(part_mm_n), 0.02, 0.0);
            for _ in 0..20_000 {
                let step = modes.begin(&law, part_mm_n, 1e-4).expect("a law");
                let deflection_mm = step.law.deflection_mm(engagement_mm - step.away_mm);
                force_n = step.law.force_n(deflection_mm);
                modes.finish((&law, part_mm_n), 1e-4, force_n);
            }
            let wanted_n = law.force_n(law.deflection_mm(engagement_mm));
            assert!((force_n / wanted_n - 1.0).abs() < 1e-9, "{force_n} N, {wanted_n} N");
            assert!((modes.reach_mm() * 20e3 / (0.7 * force_n) - 1.0).abs() < 1e-9, "{}", modes.reach_mm());
        }
    }

    /// Two steps with a force that grows evenly are one step of twice the length, and a step at a prepared force ends where it was
    /// prepared to.
    #[test]
    fn steps_are_exact_for_a_force_that_grows_evenly() {
        let (mut once, law) = modes();
        let (mut twice, _) = modes();
        for turn in 0..50 {
            let force_n = 40.0 * libm::sin(f64::from(turn));
            let middle_n = 0.5 * (twice.force_n + force_n);
            let step = once.begin(&law, 0.0, 4e-4).expect("a law");
            once.finish((&law, 0.0), 4e-4, force_n);
            twice.finish((&law, 0.0), 2e-4, middle_n);
            twice.finish((&law, 0.0), 2e-4, force_n);
            let spring_mm = 0.3 * force_n / 20e3;
            let total_mm: f64 = once.motions.iter().map(|motion| motion.at_mm).sum();
            assert!((step.away_mm + force_n / step.law.machine_n_mm() - total_mm - spring_mm).abs() < 1e-15);
            for (one, other) in once.motions.iter().zip(&twice.motions) {
                assert!((one.at_mm - other.at_mm).abs() < 1e-14, "{one:?} {other:?}");
                assert!((one.rate_mm_s - other.rate_mm_s).abs() < 1e-10, "{one:?} {other:?}");
            }
        }
    }

    /// A released mode rings with its frequency and damping.
    #[test]
    fn a_released_mode_rings() {
        let (mut modes, law) = modes();
        modes.motions.truncate(1);
        modes.motions[0].at_mm = 1.0;
        let (w, z) = (200.0 * TURN_RAD, 0.03);
        let damped = w * (1.0_f64 - z * z).sqrt();
        for k in 1..=400 {
            modes.finish((&law, 0.0), 1e-4, 0.0);
            let t = 1e-4 * f64::from(k);
            let wanted = (-z * w * t).exp() * ((damped * t).cos() + z * w / damped * (damped * t).sin());
            assert!((modes.motions[0].at_mm - wanted).abs() < 1e-10, "{k}");
        }
        modes.rest();
        assert!(modes.reach_mm() == 0.0);
    }
}
