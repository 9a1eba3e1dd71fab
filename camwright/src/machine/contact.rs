// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Contact of wheel and part: stiffness of machine and part along the table, and stiffness of the cut.

use crate::machine::contact_law::ContactLaw;
use crate::machine::description_error::{DescriptionError, ordered};
use alloc::vec::Vec;

/// Stiffness of machine and part together, with the table at a position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StiffnessAt {
    /// Position of the table (mm).
    pub z_mm: f64,
    /// Force per deflection at the wheel, along the contact's normal (N/mm).
    pub n_mm: f64,
}

/// Vibration mode between wheel and part: a share of the compliance that has a mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactMode {
    /// Natural frequency without damping (rad/s).
    pub frequency_rad_s: f64,
    /// Damping ratio.
    pub damping: f64,
    /// Share of the static compliance 1/km that is this mode's, above 0; the rest is a spring without mass.
    pub compliance_share: f64,
}

/// Largest sum of the shares of all modes: some spring must remain between wheel and part.
const MAX_MODE_SHARE: f64 = 0.95;

/// Largest damping ratio of a mode.
const MAX_DAMPING: f64 = 0.99;

/// Deflection of wheel and part against each other.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactDescription {
    /// km along the table, in the order of its positions: straight between them, constant beyond the first and the last. A part
    /// between centres is softest in its middle.
    pub stiffness: Vec<StiffnessAt>,
    /// kg: normal force per depth of cut and width (N/mm²).
    pub grinding_n_mm2: f64,
    /// F0: normal force per width at which the wheel begins to cut (N/mm).
    pub threshold_n_mm: f64,
    /// Share of the deflection by which the part deflects and not the wheelhead, 0 to 1: a single contact on the part feels it.
    pub part_share: f64,
    /// Modes that vibrate between wheel and part; empty: wheel and part deflect without delay.
    pub modes: Vec<ContactMode>,
}

impl ContactDescription {
    /// Share of the compliance that has no mass.
    #[must_use]
    pub fn spring_share(&self) -> f64 {
        1.0 - self.modes.iter().map(|mode| mode.compliance_share).sum::<f64>()
    }

    /// km with the table at a position (N/mm).
    #[must_use]
    pub fn machine_n_mm(&self, z_mm: f64) -> f64 {
        let after = self.stiffness.partition_point(|point| point.z_mm <= z_mm);
        match (after.checked_sub(1).map(|before| self.stiffness[before]), self.stiffness.get(after)) {
            (Some(a), Some(b)) => a.n_mm + (b.n_mm - a.n_mm) * (z_mm - a.z_mm) / (b.z_mm - a.z_mm),
            (Some(only), None) => only.n_mm,
            (None, only) => only.map_or(0.0, |only| only.n_mm),
        }
    }

    /// The law of a cut of this width with the table at a position; none without a width.
    #[must_use]
    pub fn law(&self, z_mm: f64, width_mm: f64) -> Option<ContactLaw> {
        ContactLaw::new(self.machine_n_mm(z_mm), self.grinding_n_mm2 * width_mm, self.threshold_n_mm * width_mm).ok()
    }

    /// Share of the part in the deflection, with the table at a position and a part of this compliance on its supports (mm/N).
    #[must_use]
    pub fn part_share_with(&self, z_mm: f64, part_mm_n: f64) -> f64 {
        match part_mm_n > 0.0 {
            true => {
                let machine_mm_n = 1.0 / self.machine_n_mm(z_mm);
                (self.part_share * machine_mm_n + part_mm_n) / (machine_mm_n + part_mm_n)
            }
            false => self.part_share,
        }
    }

    pub(super) fn validate(&self) -> Result<(), DescriptionError> {
        let positive = |what: &'static str, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(DescriptionError::NotPositive { what, value }),
        };
        // An empty list is no stiffness at all.
        positive("number of machine stiffnesses", self.stiffness.len() as f64)?;
        for point in &self.stiffness {
            positive("machine stiffness (N/mm)", point.n_mm)?;
        }
        for pair in self.stiffness.windows(2) {
            ordered("table positions of machine stiffnesses", pair[0].z_mm, pair[1].z_mm)?;
        }
        positive("grinding stiffness (N/mm²)", self.grinding_n_mm2)?;
        if !(0.0..=1.0).contains(&self.part_share) {
            let (what, value) = ("share of the part in the deflection", self.part_share);
            return Err(DescriptionError::AboveLimit { what, value, allowed: 1.0 });
        }
        for mode in &self.modes {
            positive("frequency of a mode of the contact (rad/s)", mode.frequency_rad_s)?;
            positive("damping of a mode of the contact", mode.damping)?;
            positive("share of a mode in the compliance", mode.compliance_share)?;
            if mode.damping > MAX_DAMPING {
                let (what, value) = ("damping of a mode of the contact", mode.damping);
                return Err(DescriptionError::AboveLimit { what, value, allowed: MAX_DAMPING });
            }
        }
        let value = 1.0 - self.spring_share();
        if value > MAX_MODE_SHARE {
            let what = "share of all modes in the compliance";
            return Err(DescriptionError::AboveLimit { what, value, allowed: MAX_MODE_SHARE });
        }
        let value = self.threshold_n_mm;
        if !(value >= 0.0 && value.is_finite() && self.stiffness.iter().all(|point| point.z_mm.is_finite())) {
            return Err(DescriptionError::Negative { what: "threshold force (N/mm)", value });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    fn slender() -> ContactDescription {
        let at = |z_mm: f64, n_mm: f64| StiffnessAt { z_mm, n_mm };
        ContactDescription {
            stiffness: vec![at(0.0, 30e3), at(100.0, 10e3), at(200.0, 26e3)],
            grinding_n_mm2: 2e3,
            threshold_n_mm: 0.5,
            part_share: 0.5,
            modes: vec![],
        }
    }

    #[test]
    fn a_part_between_centres_is_softest_in_its_middle() {
        let contact = slender();
        assert_eq!(contact.validate(), Ok(()));
        for (z_mm, n_mm) in [(-50.0, 30e3), (0.0, 30e3), (50.0, 20e3), (100.0, 10e3), (150.0, 18e3), (300.0, 26e3)] {
            assert!((contact.machine_n_mm(z_mm) - n_mm).abs() < 1e-9, "{z_mm} mm");
        }
        let law = contact.law(100.0, 12.0).expect("a width");
        assert_eq!((law.machine_n_mm(), law.grinding_n_mm(), law.threshold_n()), (10e3, 24e3, 6.0));
        assert_eq!(contact.law(100.0, 0.0), None);
    }

    #[test]
    fn a_stiffness_that_is_none_is_refused() {
        let broken = |change: &dyn Fn(&mut ContactDescription)| {
            let mut contact = slender();
            change(&mut contact);
            contact.validate()
        };
        assert!(broken(&|contact| contact.stiffness.clear()).is_err());
        assert!(broken(&|contact| contact.stiffness[1].n_mm = 0.0).is_err());
        assert!(broken(&|contact| contact.stiffness[1].z_mm = 500.0).is_err());
        assert!(broken(&|contact| contact.stiffness[0].z_mm = f64::NEG_INFINITY).is_err());
        assert!(broken(&|contact| contact.grinding_n_mm2 = f64::NAN).is_err());
        assert!(broken(&|contact| contact.threshold_n_mm = -1.0).is_err());
        assert!(broken(&|contact| contact.part_share = 1.5).is_err());
        let mode = |damping: f64, compliance_share: f64| {
            broken(&|contact| {
                contact.modes = vec![ContactMode { frequency_rad_s: 1e3, damping, compliance_share }; 2];
            })
        };
        assert!(mode(0.03, 0.4).is_ok());
        assert!(mode(0.03, 0.5).is_err() && mode(0.03, 0.0).is_err() && mode(1.0, 0.4).is_err());
    }
}
