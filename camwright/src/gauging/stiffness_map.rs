// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Measured contact stiffness along the machine's table, and interpolation between the positions.
//!
//! A journal deflects by 1/km per force. Between two places the compliance is taken for straight:
//!
//! ```text
//!  1/km ▲        ●  ─ measured
//!       │    ●───  ───●       with s the share of the way:  1/km = (1 − s)/km₁ + s/km₂
//!       └──────────────► z
//! ```
//! A stiff part in springs at its ends has 1/km = (1 − s)²/k₁ + s²/k₂, s from end to end: its chord between places a share Δs apart is above
//! it by Δs²/4·(1/k₁ + 1/k₂) at most, a part that bends has more, so places should lie where journals are. kg and F0 belong to the wheel
//! and the material; per width they are straight as well. Uncertainties are taken as if both places were wrong the same way, for one gauge
//! and one drive measured them. Beyond the places nothing is said: a part between centres bends between
//! them, and what it does past the last journal that was pushed nobody has looked at.

use super::stiffness::MeasuredValue;
use crate::machine::contact_law::{ContactLaw, ContactLawError};
use alloc::vec::Vec;
use thiserror::Error;

/// Places that lie no farther apart are one (mm): what a dog and its switch leave open, and far less than a wheel is wide.
pub const SAME_PLACE_MM: f64 = 1.0;

/// The contact with the table at a position, as measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredStiffness {
    /// Position of the table (mm).
    pub z_mm: f64,
    /// km (N/mm).
    pub machine_n_mm: MeasuredValue,
    /// kg per width (N/mm²).
    pub grinding_n_mm2: MeasuredValue,
    /// F0 per width (N/mm).
    pub threshold_n_mm: MeasuredValue,
}

/// Why places make no map, or a map says nothing of a place.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum StiffnessMapError {
    /// A number that is none.
    #[error("at z = {z_mm} mm: {what} {value} +- {uncertainty} is not what a measurement gives")]
    NotMeasured {
        /// Position (mm).
        z_mm: f64,
        what: &'static str,
        value: f64,
        uncertainty: f64,
    },
    #[error("z = {first_mm} mm and z = {second_mm} mm are one place: less than {min_mm} mm apart")]
    SamePlace {
        /// One (mm).
        first_mm: f64,
        /// The other (mm).
        second_mm: f64,
        /// Least distance of two (mm).
        min_mm: f64,
    },
    #[error("nothing was measured")]
    Empty,
    /// Nothing was measured beyond.
    #[error("z = {z_mm} mm lies outside the places that were measured, {from_mm} to {to_mm} mm")]
    Beyond {
        /// Asked for (mm).
        z_mm: f64,
        /// First place (mm).
        from_mm: f64,
        /// Last (mm).
        to_mm: f64,
    },
    /// Numbers that make no law.
    #[error(transparent)]
    Law(#[from] ContactLawError),
}

impl MeasuredStiffness {
    fn check(&self) -> Result<(), StiffnessMapError> {
        let good = |measured: MeasuredValue, min: f64| {
            measured.value >= min && measured.value.is_finite() && (0.0..f64::INFINITY).contains(&measured.uncertainty)
        };
        let numbers = [
            ("machine stiffness (N/mm)", self.machine_n_mm, f64::MIN_POSITIVE),
            ("grinding stiffness per width (N/mm2)", self.grinding_n_mm2, f64::MIN_POSITIVE),
            ("threshold force per width (N/mm)", self.threshold_n_mm, 0.0),
        ];
        let not = |what, measured: MeasuredValue| {
            let MeasuredValue { value, uncertainty } = measured;
            Err(StiffnessMapError::NotMeasured { z_mm: self.z_mm, what, value, uncertainty })
        };
        if !self.z_mm.is_finite() {
            return not("position", MeasuredValue { value: self.z_mm, uncertainty: 0.0 });
        }
        match numbers.into_iter().find(|(_, measured, min)| !good(*measured, *min)) {
            Some((what, measured, _)) => not(what, measured),
            None => Ok(()),
        }
    }

    /// km/kg of a cut of this width (mm): the shares of uncertainty add as squares.
    #[must_use]
    pub fn ratio(&self, width_mm: f64) -> MeasuredValue {
        let grinding = scaled(self.grinding_n_mm2, width_mm);
        super::stiffness::ratio(self.machine_n_mm, grinding)
    }
}

fn scaled(measured: MeasuredValue, by: f64) -> MeasuredValue {
    MeasuredValue { value: measured.value * by, uncertainty: measured.uncertainty * by }
}

/// Places in the order of the table.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StiffnessMap {
    places: Vec<MeasuredStiffness>,
}

impl StiffnessMap {
    /// Builds a map from positions in any order; an empty map is valid and gives no value.
    ///
    /// # Errors
    /// Numbers that no measurement gives, one place twice.
    pub fn new(mut places: Vec<MeasuredStiffness>) -> Result<Self, StiffnessMapError> {
        places.iter().try_for_each(MeasuredStiffness::check)?;
        places.sort_by(|a, b| a.z_mm.total_cmp(&b.z_mm));
        if let Some(pair) = places.windows(2).find(|pair| pair[1].z_mm - pair[0].z_mm <= SAME_PLACE_MM) {
            let (first_mm, second_mm) = (pair[0].z_mm, pair[1].z_mm);
            return Err(StiffnessMapError::SamePlace { first_mm, second_mm, min_mm: SAME_PLACE_MM });
        }
        Ok(Self { places })
    }

    /// The places that were measured.
    #[must_use]
    pub fn places(&self) -> &[MeasuredStiffness] {
        &self.places
    }

    /// The contact with the table at a position (mm).
    ///
    /// # Errors
    /// A position outside the places.
    pub fn at(&self, z_mm: f64) -> Result<MeasuredStiffness, StiffnessMapError> {
        let (Some(first), Some(last)) = (self.places.first(), self.places.last()) else {
            return Err(StiffnessMapError::Empty);
        };
        let (from_mm, to_mm) = (first.z_mm, last.z_mm);
        if !(from_mm - SAME_PLACE_MM..=to_mm + SAME_PLACE_MM).contains(&z_mm) {
            return Err(StiffnessMapError::Beyond { z_mm, from_mm, to_mm });
        }
        if let Some(same) = self.places.iter().find(|place| (place.z_mm - z_mm).abs() <= SAME_PLACE_MM) {
            return Ok(*same);
        }
        let after = self.places.partition_point(|place| place.z_mm <= z_mm);
        let (a, b) = (&self.places[after - 1], &self.places[after]);
        let share = (z_mm - a.z_mm) / (b.z_mm - a.z_mm);
        let between = |a: MeasuredValue, b: MeasuredValue| MeasuredValue {
            value: (1.0 - share) * a.value + share * b.value,
            uncertainty: (1.0 - share) * a.uncertainty + share * b.uncertainty,
        };
        Ok(MeasuredStiffness {
            z_mm,
            machine_n_mm: inverse(between(inverse(a.machine_n_mm), inverse(b.machine_n_mm))),
            grinding_n_mm2: between(a.grinding_n_mm2, b.grinding_n_mm2),
            threshold_n_mm: between(a.threshold_n_mm, b.threshold_n_mm),
        })
    }

    /// The law of a cut of this width (mm) with the table at a position (mm).
    ///
    /// # Errors
    /// A position outside the places, a width that is none.
    pub fn law(&self, z_mm: f64, width_mm: f64) -> Result<ContactLaw, StiffnessMapError> {
        let at = self.at(z_mm)?;
        let (grinding, threshold) = (scaled(at.grinding_n_mm2, width_mm), scaled(at.threshold_n_mm, width_mm));
        Ok(ContactLaw::new(at.machine_n_mm.value, grinding.value, threshold.value)?)
    }
}

/// 1/k of a k, and back.
fn inverse(measured: MeasuredValue) -> MeasuredValue {
    let value = 1.0 / measured.value;
    MeasuredValue { value, uncertainty: measured.uncertainty * value * value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::noise::Noise;
    use alloc::vec;

    fn measured(value: f64, uncertainty: f64) -> MeasuredValue {
        MeasuredValue { value, uncertainty }
    }

    fn place(z_mm: f64, machine_n_mm: f64) -> MeasuredStiffness {
        MeasuredStiffness {
            z_mm,
            machine_n_mm: measured(machine_n_mm, 0.01 * machine_n_mm),
            grinding_n_mm2: measured(1.5e3, 50.0),
            threshold_n_mm: measured(0.8, 0.2),
        }
    }

    /// Between 6 and 4 N/µm half way: 2/(1/6 + 1/4) = 4.8 N/µm, not 5.
    #[test]
    fn between_two_places_the_compliance_is_straight() {
        let map = StiffnessMap::new(vec![place(150.0, 4e3), place(80.0, 6e3)]).unwrap();
        let at = map.at(115.0).unwrap();
        assert!((at.machine_n_mm.value - 4.8e3).abs() < 1e-9, "{at:?}");
        // Both known to 1 %, so is what lies between.
        assert!((at.machine_n_mm.uncertainty / 4.8e3 - 0.01).abs() < 1e-12, "{at:?}");
        let law = map.law(115.0, 20.0).unwrap();
        assert!((law.grinding_n_mm() - 3e4).abs() < 1e-9 && (law.threshold_n() - 16.0).abs() < 1e-12);
        let ratio = at.ratio(20.0);
        assert!((ratio.value - 0.16).abs() < 1e-12 && ratio.uncertainty > 0.16 * 50.0 / 1.5e3);
        assert_eq!(map.at(80.4).unwrap().machine_n_mm.value.to_bits(), 6e3_f64.to_bits(), "that is the same place");
    }

    #[test]
    fn the_map_does_not_extrapolate() {
        let map = StiffnessMap::new(vec![place(80.0, 6e3), place(150.0, 4e3)]).unwrap();
        let beyond = |z_mm| StiffnessMapError::Beyond { z_mm, from_mm: 80.0, to_mm: 150.0 };
        assert_eq!(map.at(220.0), Err(beyond(220.0)));
        assert_eq!(map.at(78.0), Err(beyond(78.0)));
        assert!(map.at(f64::NAN).is_err());
        assert_eq!(StiffnessMap::default().at(80.0), Err(StiffnessMapError::Empty));
    }

    #[test]
    fn numbers_that_no_measurement_gives_and_places_that_are_one_are_refused() {
        let broken = |change: &dyn Fn(&mut MeasuredStiffness)| {
            let mut one = place(80.0, 6e3);
            change(&mut one);
            StiffnessMap::new(vec![one])
        };
        assert!(broken(&|_| {}).is_ok());
        assert!(broken(&|place| place.machine_n_mm.value = 0.0).is_err());
        assert!(broken(&|place| place.machine_n_mm.uncertainty = f64::NAN).is_err());
        assert!(broken(&|place| place.grinding_n_mm2.value = f64::INFINITY).is_err());
        assert!(broken(&|place| place.threshold_n_mm.value = -0.1).is_err());
        assert!(broken(&|place| place.z_mm = f64::NAN).is_err());
        let twice = StiffnessMap::new(vec![place(80.0, 6e3), place(80.5, 4e3)]);
        assert!(matches!(twice, Err(StiffnessMapError::SamePlace { .. })));
    }

    /// Everywhere between its places a map is between them, whatever they are.
    #[test]
    fn a_map_is_never_outside_its_neighbours() {
        for seed in 0..200 {
            let mut noise = Noise::new(seed);
            let places: Vec<MeasuredStiffness> =
                (0..5).map(|i| place(70.0 * f64::from(i), 1e3 + 1e4 * noise.uniform())).collect();
            let map = StiffnessMap::new(places.clone()).unwrap();
            for i in 0..280 {
                let z_mm = f64::from(i);
                let pair = &places[i as usize / 70..][..2];
                let (low, high) = crate::math::range::minimum_and_maximum(pair.iter().map(|at| at.machine_n_mm.value));
                let km = map.at(z_mm).unwrap().machine_n_mm;
                assert!((low - 1e-9..=high + 1e-9).contains(&km.value), "seed {seed}, z {z_mm}: {km:?}");
            }
        }
    }
}
