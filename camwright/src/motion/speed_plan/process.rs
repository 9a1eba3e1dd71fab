// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Process limit: the largest speed of C at every path angle.

use crate::job::grinding::{InfeedDirection, SpeedLaw};
use crate::machine::description::ReferenceCut;
use crate::math::hermite::Sample;
use crate::toolpath::wheel_path::footprint_ratio;

/// Data of the wheel and the pass for a law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutting {
    /// Radius of the wheel (mm).
    pub wheel_radius_mm: f64,
    /// Speed of the wheel's surface (m/s).
    pub wheel_speed_m_s: f64,
    /// Infeed of a turn (mm).
    pub infeed_per_turn_mm: f64,
    /// Along what that is measured.
    pub infeed_direction: InfeedDirection,
}

impl Cutting {
    /// Specific removal rate Q′ per unit of C's speed where the path is at `x` (mm²/rad): depth along the contour's normal, which
    /// an infeed along X times cos β is, times the footprint speed. Exact for stock of constant normal depth;
    /// [`radial_removal_rate_ratio_mm2`](Self::radial_removal_rate_ratio_mm2) has the published law.
    #[must_use]
    pub fn removal_rate_ratio_mm2(&self, x: Sample) -> f64 {
        let contact = PathContact::at(x, self.wheel_radius_mm, self.infeed_per_turn_mm, self.infeed_direction);
        contact.depth_mm * contact.ratio_mm
    }

    /// Specific removal rate of constant radial stock per unit of C's speed where the path is at `x` (mm²/rad): the infeed of a turn times
    /// ρ dφ/dC, with the contact at the radius ρ and the azimuth φ about the spindle axis. It is the footprint times the cosine of the angle
    /// between radius and normal.
    #[must_use]
    pub fn radial_removal_rate_ratio_mm2(&self, x: Sample) -> f64 {
        let radius = self.wheel_radius_mm;
        let contact = PathContact::at(x, radius, self.infeed_per_turn_mm, self.infeed_direction);
        let centre = x.value + radius;
        let cos_beta = centre.abs() / libm::hypot(centre, x.first);
        // The contact is R along the normal from the wheel's centre, which is β off the radius.
        let along_normal_mm = centre * cos_beta - radius;
        let contact_radius_mm = libm::hypot(along_normal_mm, centre * libm::sqrt((1.0 - cos_beta * cos_beta).max(0.0)));
        self.infeed_per_turn_mm * contact.ratio_mm * (along_normal_mm / contact_radius_mm).abs()
    }

    /// The cut at a position of the path, with C at a speed (rad/s).
    #[must_use]
    pub fn cut(&self, x: Sample, c_rad_s: f64) -> ReferenceCut {
        let contact = PathContact::at(x, self.wheel_radius_mm, self.infeed_per_turn_mm, self.infeed_direction);
        ReferenceCut {
            footprint_speed_mm_s: contact.ratio_mm * c_rad_s,
            depth_mm: contact.depth_mm,
            equivalent_diameter_mm: contact.equivalent_diameter_mm,
        }
    }
}

/// The contact at one place of the path.
struct PathContact {
    /// Footprint speed per unit of C's speed (mm/rad).
    ratio_mm: f64,
    /// Depth along the normal (mm).
    depth_mm: f64,
    /// 2/(1/R + κ) (mm): diameter of the wheel that has the same contact on a flat part.
    equivalent_diameter_mm: f64,
}

impl PathContact {
    fn at(x: Sample, radius: f64, infeed_per_turn_mm: f64, direction: InfeedDirection) -> Self {
        let centre = x.value + radius;
        let square = centre * centre + x.first * x.first;
        let length = libm::sqrt(square);
        let distance = centre.abs();
        let cos_beta = distance / length;
        let ratio_mm = footprint_ratio(x, radius, centre, square, length);
        // The ratio is |W|/(cos β (1 + κR)) and |W| = distance: solved for 1 + κR = R (1/R + κ).
        let one_plus = distance / (cos_beta * ratio_mm);
        let depth_mm = match direction {
            InfeedDirection::X => infeed_per_turn_mm * cos_beta,
            InfeedDirection::Normal => infeed_per_turn_mm,
        };
        Self { ratio_mm, depth_mm, equivalent_diameter_mm: 2.0 * radius / one_plus }
    }
}

/// The largest speed of C that a law of the job allows where the path is at `x` (rad/s); not above 0 where it allows none.
///
/// Power: P′ = e·Q′ + p·√(depth·equivalent diameter)·v, the energy of the chips and rubbing over the length of contact.
/// Temperature: that of a moving source of heat at high speed goes with depth^¾·speed^½·diameter^−¼, so that speeds of equal
/// temperature go with diameter^½·depth^−3/2 (constant specific energy and share of heat).
#[must_use]
pub fn largest_speed_rad_s(law: &SpeedLaw, x: Sample, cutting: &Cutting) -> f64 {
    let contact = PathContact::at(x, cutting.wheel_radius_mm, cutting.infeed_per_turn_mm, cutting.infeed_direction);
    match *law {
        SpeedLaw::ConstantWorkSpeed { work_speed_rad_s } => work_speed_rad_s,
        SpeedLaw::TimeOptimal { max_rad_s } => max_rad_s,
        SpeedLaw::ConstantFootprintSpeed { footprint_speed_mm_s, max_rad_s } => {
            (footprint_speed_mm_s / contact.ratio_mm).min(max_rad_s)
        }
        SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s, max_rad_s } => {
            (removal_rate_mm2_s / (contact.depth_mm * contact.ratio_mm)).min(max_rad_s)
        }
        SpeedLaw::ConstantRadialRemovalRate { removal_rate_mm2_s, max_rad_s } => {
            (removal_rate_mm2_s / cutting.radial_removal_rate_ratio_mm2(x)).min(max_rad_s)
        }
        SpeedLaw::ConstantPower { power_w_mm, specific_energy_j_mm3, rubbing_n_mm2, max_rad_s } => {
            let length_mm = libm::sqrt(contact.depth_mm * contact.equivalent_diameter_mm);
            let for_chips = power_w_mm - rubbing_n_mm2 * length_mm * cutting.wheel_speed_m_s;
            (for_chips / (specific_energy_j_mm3 * contact.depth_mm * contact.ratio_mm)).min(max_rad_s)
        }
        SpeedLaw::ConstantTemperature { reference, max_rad_s } => {
            let diameters = libm::sqrt(contact.equivalent_diameter_mm / reference.equivalent_diameter_mm);
            let depths = libm::pow(contact.depth_mm / reference.depth_mm, -1.5);
            (reference.footprint_speed_mm_s * diameters * depths / contact.ratio_mm).min(max_rad_s)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::description::GrindingProcess;

    const CUTTING: Cutting = Cutting {
        wheel_radius_mm: 60.0,
        wheel_speed_m_s: 80.0,
        infeed_per_turn_mm: 0.04,
        infeed_direction: InfeedDirection::X,
    };

    /// A round part of radius 20 mm: footprint 20 mm per rad, depth the infeed, equivalent diameter 2/(1/60 + 1/20) = 30 mm.
    #[test]
    fn on_a_round_part_every_law_is_one_division() {
        let round = Sample { value: 20.0, ..Sample::default() };
        let max_rad_s = 100.0;
        let close = |law: SpeedLaw, wanted: f64| {
            let speed = largest_speed_rad_s(&law, round, &CUTTING);
            assert!((speed / wanted - 1.0).abs() < 1e-12, "{law:?}: {speed} rad/s, not {wanted}");
        };
        close(SpeedLaw::ConstantFootprintSpeed { footprint_speed_mm_s: 100.0, max_rad_s }, 5.0);
        close(SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 8.0, max_rad_s }, 10.0);
        // Contact length √(0.04 · 30) mm: rubbing takes 0.1 · 1.0954 · 80 W/mm.
        let rubbing_w_mm = 0.1 * libm::sqrt(1.2) * 80.0;
        let power_w_mm = rubbing_w_mm + 50.0 * 8.0;
        let law = SpeedLaw::ConstantPower { power_w_mm, specific_energy_j_mm3: 50.0, rubbing_n_mm2: 0.1, max_rad_s };
        close(law, 10.0);
        let reference = ReferenceCut { footprint_speed_mm_s: 40.0, depth_mm: 0.04, equivalent_diameter_mm: 30.0 };
        close(SpeedLaw::ConstantTemperature { reference, max_rad_s }, 2.0);
        // Twice the depth: 2^−1.5 of the speed.
        let reference = ReferenceCut { depth_mm: 0.02, ..reference };
        close(SpeedLaw::ConstantTemperature { reference, max_rad_s }, 2.0 * libm::pow(2.0, -1.5));
        close(SpeedLaw::TimeOptimal { max_rad_s }, 100.0);
    }

    /// On a round part depth, footprint and equivalent diameter are known on paper, and at the temperature law's speed the burn index is 1.
    #[test]
    fn the_burn_index_is_one_at_the_speed_of_constant_temperature() {
        let round = Sample { value: 20.0, ..Sample::default() };
        let cut = CUTTING.cut(round, 2.0);
        assert!((cut.depth_mm - 0.04).abs() < 1e-12 && (cut.footprint_speed_mm_s - 40.0).abs() < 1e-9, "{cut:?}");
        assert!((cut.equivalent_diameter_mm - 30.0).abs() < 1e-9, "{cut:?}");
        let safe_cut = ReferenceCut { footprint_speed_mm_s: 90.0, depth_mm: 0.03, equivalent_diameter_mm: 25.0 };
        let process = GrindingProcess { specific_energy_j_mm3: 50.0, rubbing_n_mm2: 0.0, safe_cut };
        let law = SpeedLaw::ConstantTemperature { reference: safe_cut, max_rad_s: 1e9 };
        let speed = largest_speed_rad_s(&law, round, &CUTTING);
        assert!((process.burn_index(&CUTTING.cut(round, speed)) - 1.0).abs() < 1e-12);
        // Twice the speed: √2.
        let index = process.burn_index(&CUTTING.cut(round, 2.0 * speed));
        assert!((index - libm::sqrt(2.0)).abs() < 1e-12, "{index}");
    }

    /// The published law, from its own equations for the polar contour ρ(φ) of a disc of radius r about a centre e off the axis:
    /// tan α = ρ'/ρ, S = √(ρ² + R² + 2ρR cos α), tan β = ρ sin α/(R + ρ cos α), C = φ + β − α and ω = k/(ρ dφ/dC).
    #[test]
    fn the_radial_law_is_the_published_one_on_an_eccentric() {
        const R: f64 = 60.0;
        let (r, e) = (19.0, 4.2);
        let polar = |phi: f64| {
            let root = libm::sqrt(r * r - libm::pow(e * libm::sin(phi), 2.0));
            let rho = e * libm::cos(phi) + root;
            let slope = -e * libm::sin(phi) - e * e * libm::sin(phi) * libm::cos(phi) / root;
            (rho, libm::atan2(slope, rho))
        };
        let c_of = |phi: f64| {
            let (rho, alpha) = polar(phi);
            phi + libm::atan2(rho * libm::sin(alpha), R + rho * libm::cos(alpha)) - alpha
        };
        let law = |max_rad_s| SpeedLaw::ConstantRadialRemovalRate { removal_rate_mm2_s: 8.0, max_rad_s };
        let exact = SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 8.0, max_rad_s: 1e9 };
        let mut largest_difference = 0.0_f64;
        for i in 0..720 {
            let phi = f64::from(i) * 0.5_f64.to_radians();
            let (rho, alpha) = polar(phi);
            let step = 1e-5;
            let dphi_dc = 2.0 * step / (c_of(phi + step) - c_of(phi - step));
            let published = 8.0 / CUTTING.infeed_per_turn_mm / (rho * dphi_dc);
            // The wheel's path about a disc in closed form: its centre is r + R from that of the disc.
            let c = c_of(phi);
            let root = libm::sqrt((r + R) * (r + R) - libm::pow(e * libm::sin(c), 2.0));
            let centre = e * libm::cos(c) + root;
            assert!((centre - libm::sqrt(rho * rho + R * R + 2.0 * rho * R * libm::cos(alpha))).abs() < 1e-9);
            let first = -e * libm::sin(c) * centre / root;
            // X'' from X² − 2eX cos C + e² = (r + R)², derived twice.
            let second = (-first * first - 2.0 * e * first * libm::sin(c) - e * centre * libm::cos(c)) / root;
            let x = Sample { value: centre - R, first, second, third: 0.0 };
            let planned = largest_speed_rad_s(&law(1e9), x, &CUTTING);
            assert!((planned / published - 1.0).abs() < 1e-7, "phi {phi}: {planned} rad/s, published {published}");
            assert!(largest_speed_rad_s(&law(1.5), x, &CUTTING) <= 1.5);
            largest_difference = largest_difference.max(planned / largest_speed_rad_s(&exact, x, &CUTTING) - 1.0);
        }
        // sin α is at most e/r, and cos β of the infeed along X near 1: the published speed is higher by up to 2.4 %.
        assert!((0.02..0.026).contains(&largest_difference), "{largest_difference}");
    }

    /// On a flank the infeed along X cuts less deep, by cos β; that along the normal does not.
    #[test]
    fn the_depth_of_an_infeed_along_the_normal_is_the_same_all_round() {
        let flank = Sample { value: 20.0, first: 60.0, ..Sample::default() };
        let law = SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 8.0, max_rad_s: 1e9 };
        let along_x = largest_speed_rad_s(&law, flank, &CUTTING);
        let along_normal = Cutting { infeed_direction: InfeedDirection::Normal, ..CUTTING };
        let cos_beta = 80.0 / libm::hypot(80.0, 60.0);
        assert!((largest_speed_rad_s(&law, flank, &along_normal) / (along_x * cos_beta) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn rubbing_that_takes_the_whole_power_leaves_no_speed() {
        let round = Sample { value: 20.0, ..Sample::default() };
        let law = SpeedLaw::ConstantPower {
            power_w_mm: 5.0,
            specific_energy_j_mm3: 50.0,
            rubbing_n_mm2: 0.1,
            max_rad_s: 100.0,
        };
        assert!(largest_speed_rad_s(&law, round, &CUTTING) <= 0.0);
    }
}
