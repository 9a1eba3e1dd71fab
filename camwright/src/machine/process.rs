// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Process data of grinding: energy of the chips, force of rubbing, and the cut at the burn limit.

use crate::machine::description_error::DescriptionError;

/// A cut that just does not burn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceCut {
    /// Speed of the contact along the contour (mm/s).
    pub footprint_speed_mm_s: f64,
    /// Depth along the normal (mm).
    pub depth_mm: f64,
    /// Diameter of the wheel that has the same contact on a flat part, 2/(1/R + κ) (mm).
    pub equivalent_diameter_mm: f64,
}

impl ReferenceCut {
    /// Cut of a wheel on a turning part: removal rate Q′ (mm²/s) and depth (mm); radius of the wheel and distance of its centre from the
    /// part's axis (mm), of either sign; cosine of the angle between the normal and the wheel line; speed of the wheel line about the part (rad/s).
    #[must_use]
    pub fn from_contact(
        (removal_mm2_s, depth_mm): (f64, f64),
        (wheel_radius_mm, centre_mm): (f64, f64),
        cos_beta: f64,
        omega_rad_s: f64,
    ) -> Self {
        let footprint_speed_mm_s = removal_mm2_s / depth_mm;
        let equivalent_diameter_mm =
            2.0 * wheel_radius_mm * cos_beta * footprint_speed_mm_s / (omega_rad_s * centre_mm.abs());
        Self { footprint_speed_mm_s, depth_mm, equivalent_diameter_mm }
    }

    /// Length of the contact (mm).
    #[must_use]
    pub fn contact_mm(&self) -> f64 {
        libm::sqrt(self.depth_mm * self.equivalent_diameter_mm)
    }
}

/// Process data of a wheel and a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrindingProcess {
    /// e: energy that a removed volume takes (J/mm³).
    pub specific_energy_j_mm3: f64,
    /// p: force of rubbing per area of contact (N/mm²).
    pub rubbing_n_mm2: f64,
    /// The hottest cut that is allowed.
    pub safe_cut: ReferenceCut,
}

impl GrindingProcess {
    /// Power per width (W/mm) of a removal rate Q′ (mm²/s) over a length of contact (mm): P′ = e·Q′ + p·l·v.
    #[must_use]
    pub fn power_w_mm(&self, removal_mm2_s: f64, contact_mm: f64, wheel_speed_m_s: f64) -> f64 {
        self.specific_energy_j_mm3 * removal_mm2_s + self.rubbing_n_mm2 * contact_mm * wheel_speed_m_s
    }

    /// Temperature of a cut relative to the safe one; above 1 it burns. Temperature of a moving heat source at high speed: depth^¾ ·
    /// speed^½ · diameter^−¼, with constant specific energy and share of heat.
    #[must_use]
    pub fn burn_index(&self, cut: &ReferenceCut) -> f64 {
        let safe = &self.safe_cut;
        let speeds = cut.footprint_speed_mm_s / safe.footprint_speed_mm_s;
        let diameters = safe.equivalent_diameter_mm / cut.equivalent_diameter_mm;
        libm::pow(cut.depth_mm / safe.depth_mm, 0.75) * libm::sqrt(speeds) * libm::pow(diameters, 0.25)
    }

    pub(super) fn validate(&self) -> Result<(), DescriptionError> {
        let safe = &self.safe_cut;
        for (what, value) in [
            ("specific energy (J/mm³)", self.specific_energy_j_mm3),
            ("footprint speed of the safe cut (mm/s)", safe.footprint_speed_mm_s),
            ("depth of the safe cut (mm)", safe.depth_mm),
            ("equivalent diameter of the safe cut (mm)", safe.equivalent_diameter_mm),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(DescriptionError::NotPositive { what, value });
            }
        }
        let (what, value) = ("rubbing (N/mm²)", self.rubbing_n_mm2);
        if value >= 0.0 && value.is_finite() { Ok(()) } else { Err(DescriptionError::Negative { what, value }) }
    }
}
