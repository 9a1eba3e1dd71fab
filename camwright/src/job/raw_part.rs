// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The raw part: how far it is off the shape that its design and an even stock would give it.
//!
//! Radii are measured from the spindle axis, azimuths from the keyway, as everywhere. A part whose centre lies off the axis by e in the
//! direction φ has, to first order in e over its radius, e cos(θ − φ) more of it at the azimuth θ; a part bent between two places has
//! that much more as half a sine wave along the axis says; lobes of a count n, as a centreless grinder leaves them, are waves cos n(θ − φ).

use crate::math::noise::Noise;
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// A wave around the part.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wave {
    /// Its amplitude (mm).
    pub mm: f64,
    /// Azimuth of a crest, measured from the keyway (rad).
    pub at_rad: f64,
}

impl Wave {
    fn value_mm(self, count: f64, azimuth_rad: f64) -> f64 {
        self.mm * libm::cos(count * (azimuth_rad - self.at_rad))
    }

    /// The same with an amplitude between nothing and its own, and a crest anywhere.
    fn drawn(self, noise: &mut Noise, count: f64) -> Self {
        Self { mm: self.mm * noise.uniform(), at_rad: TURN_RAD / count * noise.uniform() }
    }
}

/// A bend between two places of the axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bend {
    /// Offset of the middle from the axis, and its direction.
    pub wave: Wave,
    /// Positions of the stations between which the part is bent: where it is held (mm).
    pub between_mm: (f64, f64),
}

/// Deviation of a raw part from the design.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RawPart {
    /// Its centre off the axis, all along.
    pub eccentric: Wave,
    pub bend: Option<Bend>,
    /// Waves of 2 crests and more.
    pub lobes: Vec<(u32, Wave)>,
    /// Azimuth at which its keyway lies as it is clamped (rad); 0 faces the wheel where C is 0. Everything above turns with it.
    pub clamped_at_rad: f64,
    /// Additional stock all round, or missing stock below 0 (mm). The planner does not know it.
    pub unknown_mm: f64,
}

impl RawPart {
    /// Amplitudes as largest values: what a seed makes of them. The same seed gives the same part.
    #[must_use]
    pub fn drawn(&self, seed: u64) -> Self {
        let mut noise = Noise::new(seed);
        Self {
            eccentric: self.eccentric.drawn(&mut noise, 1.0),
            bend: self.bend.map(|bend| Bend { wave: bend.wave.drawn(&mut noise, 1.0), ..bend }),
            lobes: (self.lobes.iter())
                .map(|(count, wave)| (*count, wave.drawn(&mut noise, f64::from((*count).max(1)))))
                .collect(),
            clamped_at_rad: self.clamped_at_rad,
            unknown_mm: self.unknown_mm,
        }
    }

    /// Amplitude that a diameter does not show (mm): the waves that leave every diameter unchanged.
    #[must_use]
    pub fn unseen_mm(&self) -> f64 {
        let odd = self.lobes.iter().filter(|(count, _)| count % 2 == 1).map(|(_, wave)| wave.mm.abs());
        self.eccentric.mm.abs() + self.bend.map_or(0.0, |bend| bend.wave.mm.abs()) + odd.sum::<f64>()
    }

    /// Height of the part above design and stock (mm), at an azimuth (rad) and a position along the axis (mm).
    #[must_use]
    pub fn above_mm(&self, azimuth_rad: f64, z_mm: f64) -> f64 {
        let bent_mm = self.bend.map_or(0.0, |bend| {
            let (from_mm, to_mm) = bend.between_mm;
            let share = ((z_mm - from_mm) / (to_mm - from_mm)).clamp(0.0, 1.0);
            bend.wave.value_mm(1.0, azimuth_rad) * libm::sin(0.5 * TURN_RAD * share)
        });
        let lobes_mm = self.lobes.iter().map(|(count, wave)| wave.value_mm(f64::from(*count), azimuth_rad));
        self.unknown_mm + self.eccentric.value_mm(1.0, azimuth_rad) + bent_mm + lobes_mm.sum::<f64>()
    }

    /// Upper bound of that height without the unknown stock (mm): all amplitudes together.
    #[must_use]
    pub fn reach_mm(&self) -> f64 {
        let lobes_mm: f64 = self.lobes.iter().map(|(_, wave)| wave.mm.abs()).sum();
        self.eccentric.mm.abs() + self.bend.map_or(0.0, |bend| bend.wave.mm.abs()) + lobes_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    fn part() -> RawPart {
        RawPart {
            eccentric: Wave { mm: 0.02, at_rad: 1.0 },
            bend: Some(Bend { wave: Wave { mm: 0.05, at_rad: 4.0 }, between_mm: (50.0, 150.0) }),
            lobes: vec![(3, Wave { mm: 0.004, at_rad: 0.3 }), (5, Wave { mm: 0.001, at_rad: 0.0 })],
            clamped_at_rad: 0.0,
            unknown_mm: 0.0,
        }
    }

    #[test]
    fn a_bent_part_is_off_most_in_its_middle_and_not_where_it_is_held() {
        let bent = RawPart { eccentric: Wave::default(), lobes: vec![], ..part() };
        for (z_mm, share) in [(0.0, 0.0), (50.0, 0.0), (75.0, 0.5_f64.sqrt()), (100.0, 1.0), (150.0, 0.0), (400.0, 0.0)]
        {
            assert!((bent.above_mm(4.0, z_mm) - 0.05 * share).abs() < 1e-15, "{z_mm} mm");
            assert!((bent.above_mm(4.0 + 0.5 * TURN_RAD, z_mm) + 0.05 * share).abs() < 1e-15);
        }
    }

    #[test]
    fn reach_is_an_upper_bound_and_waves_have_zero_mean() {
        let part = part();
        let all: Vec<f64> = (0..3600).map(|i| part.above_mm(f64::from(i) * TURN_RAD / 3600.0, 100.0)).collect();
        let max = all.iter().fold(0.0_f64, |max, mm| max.max(mm.abs()));
        assert!(max <= part.reach_mm() && max > 0.3 * part.reach_mm(), "{max} {}", part.reach_mm());
        assert!((all.iter().sum::<f64>() / 3600.0).abs() < 1e-12);
        assert!(RawPart::default().above_mm(1.0, 2.0).abs() < 1e-300);
    }

    /// Two opposed contacts see waves of an even count alone.
    #[test]
    fn a_diameter_shows_all_but_the_listed_harmonics() {
        let mut part = part();
        part.lobes.push((4, Wave { mm: 0.007, at_rad: 1.0 }));
        part.unknown_mm = 0.05;
        assert!((part.unseen_mm() - 0.075).abs() < 1e-15, "{}", part.unseen_mm());
        for i in 0..360 {
            let at_rad = f64::from(i) * TURN_RAD / 360.0;
            let mean_mm = 0.5 * (part.above_mm(at_rad, 100.0) + part.above_mm(at_rad + 0.5 * TURN_RAD, 100.0));
            assert!((mean_mm - 0.05 - part.lobes[2].1.value_mm(4.0, at_rad)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_seed_draws_a_part_within_the_amplitudes_and_the_same_one_every_time() {
        for seed in 0..200 {
            let drawn = part().drawn(seed);
            assert_eq!(drawn, part().drawn(seed), "seed {seed}");
            assert_ne!(drawn, part().drawn(seed + 1), "seed {seed}");
            assert!(drawn.reach_mm() <= part().reach_mm(), "seed {seed}");
            assert_eq!(drawn.lobes.iter().map(|(count, _)| *count).collect::<Vec<u32>>(), [3, 5]);
        }
    }
}
