// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Deflection of wheel and part at their contact: three parameters, and the resulting cut turn after turn.
//!
//! ```text
//!  spring  km·T ──► presses the wheel on the part ──► F0 is lost to rubbing ──► kg·U cuts:  km·T = F0 + kg·U
//! ```
//! T is the deflection (mm), U the depth of cut (mm), both along the contour's normal, and E = T + U is the engagement: how deep the
//! wheel would stand in the surface that it meets, if nothing deflected. Of a phase that was at radius r before the cut and meets a
//! wheel at L (undeflected, from the same axis) E = r − L, and after the cut
//!
//! ```text
//!  r′ = (kg·r + km·L + F0)/(kg + km)     where km·E > F0; else the wheel rubs and takes nothing.
//! ```
//! The force balance is JTEKT's (method of measuring the actual depth of cut, machining method and machine tool). T is counted from
//! the surface after the cut, where the wheel's face is; so what is left of a deviation after a turn at constant L is kg/(kg + km) of
//! it exactly, of which 1 − km/kg is the first term.

use thiserror::Error;

/// Stiffness of machine and part together, of the cut, and the force below which nothing is cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLaw {
    machine_n_mm: f64,
    grinding_n_mm: f64,
    threshold_n: f64,
}

/// A surface that a wheel presses on together with others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EngagedWidth {
    /// E, depth of the undeflected wheel in this surface along the normal (mm).
    pub engagement_mm: f64,
    /// Law of this surface alone; its machine stiffness is not used.
    pub law: ContactLaw,
}

/// Deflection of a machine of stiffness km (N/mm) that presses one wheel on several surfaces side by side (mm).
///
/// The spring carries the sum of the forces, km·T = Σ Fᵢ. A surface with Eᵢ > T is cut with Uᵢ = Eᵢ − T and Fᵢ = F0ᵢ + kgᵢ·Uᵢ; one with
/// Eᵢ = T rubs with Fᵢ up to F0ᵢ; one with Eᵢ < T is not touched. Of a single surface this is [`ContactLaw::deflection_mm`]. `surfaces` is
/// sorted by falling engagement.
#[must_use]
pub fn shared_deflection_mm(machine_n_mm: f64, surfaces: &mut [EngagedWidth]) -> f64 {
    surfaces.sort_unstable_by(|a, b| b.engagement_mm.total_cmp(&a.engagement_mm));
    // Of the surfaces that are cut: Σ (F0 + kg·E) and Σ kg.
    let (mut pressing_n, mut grinding_n_mm) = (0.0, 0.0);
    for EngagedWidth { engagement_mm, law } in surfaces.iter() {
        let carried_n = (machine_n_mm + grinding_n_mm) * engagement_mm - pressing_n;
        if carried_n <= 0.0 || *engagement_mm <= 0.0 {
            break;
        }
        if carried_n <= law.threshold_n {
            return *engagement_mm;
        }
        pressing_n += law.threshold_n + law.grinding_n_mm * engagement_mm;
        grinding_n_mm += law.grinding_n_mm;
    }
    pressing_n / (machine_n_mm + grinding_n_mm)
}

/// Why three numbers make no contact law.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ContactLawError {
    /// A stiffness must be a number above 0.
    #[error("{what} must be positive and finite, not {value_n_mm} N/mm")]
    Stiffness {
        what: &'static str,
        /// Its value (N/mm).
        value_n_mm: f64,
    },
    /// The threshold force must be a number and not negative.
    #[error("threshold force must be finite and not negative, not {value_n} N")]
    Threshold {
        /// Its value (N).
        value_n: f64,
    },
}

impl ContactLaw {
    /// From km, the stiffness of machine and part at the contact (N/mm), kg, the normal force per depth of cut (N/mm), and F0, the
    /// force at which the wheel begins to cut (N).
    ///
    /// # Errors
    /// A stiffness that is not a number above 0, a force that is not a number from 0 on.
    pub fn new(machine_n_mm: f64, grinding_n_mm: f64, threshold_n: f64) -> Result<Self, ContactLawError> {
        for (what, value_n_mm) in [("machine stiffness", machine_n_mm), ("grinding stiffness", grinding_n_mm)] {
            if !(value_n_mm > 0.0 && value_n_mm.is_finite()) {
                return Err(ContactLawError::Stiffness { what, value_n_mm });
            }
        }
        if !(threshold_n >= 0.0 && threshold_n.is_finite()) {
            return Err(ContactLawError::Threshold { value_n: threshold_n });
        }
        Ok(Self { machine_n_mm, grinding_n_mm, threshold_n })
    }

    /// The same with a further spring of this compliance (mm/N) behind the machine: the part on its supports. 0 changes nothing.
    #[must_use]
    pub fn in_series(self, compliance_mm_n: f64) -> Self {
        match compliance_mm_n > 0.0 && compliance_mm_n.is_finite() {
            true => Self { machine_n_mm: 1.0 / (1.0 / self.machine_n_mm + compliance_mm_n), ..self },
            false => self,
        }
    }

    /// km (N/mm).
    #[must_use]
    pub const fn machine_n_mm(&self) -> f64 {
        self.machine_n_mm
    }

    /// kg (N/mm).
    #[must_use]
    pub const fn grinding_n_mm(&self) -> f64 {
        self.grinding_n_mm
    }

    /// F0 (N).
    #[must_use]
    pub const fn threshold_n(&self) -> f64 {
        self.threshold_n
    }

    /// λ = kg/(kg + km): what is left of a deviation after a turn at constant wheel position.
    #[must_use]
    pub fn decay(&self) -> f64 {
        self.grinding_n_mm / (self.grinding_n_mm + self.machine_n_mm)
    }

    /// U of an engagement (mm).
    #[must_use]
    pub fn depth_of_cut_mm(&self, engagement_mm: f64) -> f64 {
        let pressing_n = self.machine_n_mm * engagement_mm - self.threshold_n;
        if pressing_n > 0.0 { pressing_n / (self.grinding_n_mm + self.machine_n_mm) } else { 0.0 }
    }

    /// T of an engagement (mm); 0 where wheel and part do not touch.
    #[must_use]
    pub fn deflection_mm(&self, engagement_mm: f64) -> f64 {
        engagement_mm.max(0.0) - self.depth_of_cut_mm(engagement_mm)
    }

    /// Normal force of a deflection (N).
    #[must_use]
    pub fn force_n(&self, deflection_mm: f64) -> f64 {
        self.machine_n_mm * deflection_mm
    }

    /// Depth of cut at a normal force (mm): (F − F0)/kg.
    #[must_use]
    pub fn depth_from_force_mm(&self, force_n: f64) -> f64 {
        ((force_n - self.threshold_n) / self.grinding_n_mm).max(0.0)
    }

    /// Radius of a phase after a cut (mm), from that before and the position of the undeflected wheel, all from one axis.
    #[must_use]
    pub fn radius_after_mm(&self, before_mm: f64, wheel_mm: f64) -> f64 {
        before_mm - self.depth_of_cut_mm(before_mm - wheel_mm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::unit_numbers;

    /// km/kg = 1/5.
    fn law(threshold_n: f64) -> ContactLaw {
        ContactLaw::new(1.0e4, 5.0e4, threshold_n).expect("three good numbers")
    }

    #[test]
    fn the_spring_carries_what_cuts_and_what_rubs() {
        let law = law(15.0);
        for engagement_mm in [1e-6, 1.4e-3, 1.6e-3, 0.01, 0.3] {
            let (depth, deflection) = (law.depth_of_cut_mm(engagement_mm), law.deflection_mm(engagement_mm));
            assert!((depth + deflection - engagement_mm).abs() < 1e-15);
            let (spring_n, cut_n) = (law.force_n(deflection), law.grinding_n_mm() * depth);
            match depth > 0.0 {
                true => {
                    assert!((spring_n - 15.0 - cut_n).abs() < 1e-9, "{spring_n} N, {cut_n} N");
                    assert!((law.depth_from_force_mm(spring_n) - depth).abs() < 1e-12);
                }
                false => assert!(spring_n <= 15.0, "{spring_n} N"),
            }
        }
        assert_eq!((law.depth_of_cut_mm(-1.0), law.deflection_mm(-1.0)), (0.0, 0.0));
    }

    /// At constant wheel position every turn leaves λ of a deviation; the end is F0/km outside the wheel.
    #[test]
    fn spark_out_decays_by_the_same_share_every_turn() {
        for (machine_n_mm, decay) in [(2.5e3, 1.0 / 1.05), (5e3, 1.0 / 1.1), (1e4, 1.0 / 1.2), (2.5e4, 1.0 / 1.5)] {
            let law = ContactLaw::new(machine_n_mm, 5.0e4, 15.0).expect("three good numbers");
            assert!((law.decay() - decay).abs() < 1e-15);
            let end_mm = 20.0 + 15.0 / machine_n_mm;
            let mut radius_mm = end_mm + 0.05;
            for turn in 1..=40 {
                radius_mm = law.radius_after_mm(radius_mm, 20.0);
                let left = (radius_mm - end_mm) / 0.05;
                assert!((left - libm::pow(decay, f64::from(turn))).abs() < 1e-12, "turn {turn}: {left}");
            }
        }
        // Euler's method, where T is counted from the surface before the cut, would leave (1 − km/kg)³ = 0.125.
        assert!((libm::pow(ContactLaw::new(1.0, 2.0, 0.0).expect("good").decay(), 3.0) - 8.0 / 27.0).abs() < 1e-15);
    }

    /// Fed by f per turn from where the force reaches F0 on, the depth of cut is f (1 − λⁿ), and at last the deflection is
    /// (kg f + F0)/km.
    #[test]
    fn a_plunge_comes_to_its_depth_of_cut_exponentially() {
        let (law, feed_mm) = (law(15.0), 0.01);
        let mut radius_mm = 20.0;
        let mut wheel_mm = radius_mm - 15.0 / law.machine_n_mm();
        for turn in 1..=200 {
            wheel_mm -= feed_mm;
            let after_mm = law.radius_after_mm(radius_mm, wheel_mm);
            let wanted_mm = feed_mm * (1.0 - libm::pow(law.decay(), f64::from(turn)));
            assert!((radius_mm - after_mm - wanted_mm).abs() < 1e-13, "turn {turn}");
            radius_mm = after_mm;
        }
        assert!((radius_mm - wheel_mm - (5.0e4 * feed_mm + 15.0) / 1.0e4).abs() < 1e-12);
    }

    /// The balance of the forces, by bisection: 0 at T = 0 from below, and decreasing from there on.
    fn balanced_mm(machine_n_mm: f64, surfaces: &[EngagedWidth]) -> f64 {
        let excess_n = |deflection_mm: f64| {
            let force_n = |surface: &EngagedWidth| match surface.engagement_mm - deflection_mm {
                depth_mm if depth_mm > 0.0 => surface.law.threshold_n + surface.law.grinding_n_mm * depth_mm,
                _ => 0.0,
            };
            surfaces.iter().map(force_n).sum::<f64>() - machine_n_mm * deflection_mm
        };
        let (mut low, mut high) = (0.0, 10.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if excess_n(middle) > 0.0 { low = middle } else { high = middle }
        }
        low
    }

    /// Any number of surfaces: the deflection balances the forces; a single surface has that of its own law.
    #[test]
    fn one_spring_carries_all_surfaces() {
        let mut random = unit_numbers(0x2545_f491);
        let (mut rubs, mut misses) = (0, 0);
        for round in 0..2000 {
            let machine_n_mm = 1e4 + 5e4 * random();
            let mut surfaces: alloc::vec::Vec<EngagedWidth> = (0..1 + round % 5)
                .map(|_| EngagedWidth {
                    engagement_mm: 0.01 * random() - 0.001,
                    law: ContactLaw::new(machine_n_mm, 1e3 + 4e4 * random(), 40.0 * random()).expect("good numbers"),
                })
                .collect();
            let (wanted_mm, single) = (balanced_mm(machine_n_mm, &surfaces), surfaces[0]);
            let found_mm = shared_deflection_mm(machine_n_mm, &mut surfaces);
            assert!((found_mm - wanted_mm).abs() < 1e-12, "{round}: {found_mm} mm, {wanted_mm} mm, {surfaces:?}");
            if surfaces.len() == 1 {
                assert!((found_mm - single.law.deflection_mm(single.engagement_mm)).abs() < 1e-15, "{round}");
            }
            rubs += u32::from(surfaces.iter().any(|surface| surface.engagement_mm.to_bits() == found_mm.to_bits()));
            misses += u32::from(surfaces.iter().any(|surface| surface.engagement_mm < found_mm));
        }
        assert!(rubs > 50 && misses > 500, "{rubs} {misses}");
    }

    #[test]
    fn numbers_that_are_no_stiffness_are_refused() {
        for (machine, grinding) in [(0.0, 1.0), (1.0, -1.0), (f64::NAN, 1.0), (1.0, f64::INFINITY)] {
            assert!(matches!(ContactLaw::new(machine, grinding, 0.0), Err(ContactLawError::Stiffness { .. })));
        }
        assert!(matches!(ContactLaw::new(1.0, 1.0, -1.0), Err(ContactLawError::Threshold { .. })));
        assert!(matches!(ContactLaw::new(1.0, 1.0, f64::NAN), Err(ContactLawError::Threshold { .. })));
    }
}
