// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The in-process gauge: what it touches, and what it makes of it.
//!
//! Its contacts stand still in the machine at an angle γ behind the wheel, in the direction in which a positive C turns the part: what
//! passes the wheel is under the contact when the part has turned on by γ. Seen from the part, whose wheel line is at θ = σ·C, a
//! contact is at azimuth θ − σ·γ.

use crate::gauging::gauge::{self, GaugeError};
use crate::gauging::gauge_setup::GaugeSetup;
use crate::machine::description::{GaugeDescription, GaugeKind};
use crate::math::noise::Noise;
use crate::math::units::{TURN_RAD, wrap_turn};
use crate::simulation::workpiece::{Deflection, Lobe};
use core::f64::consts::PI;

impl GaugeDescription {
    /// Measurement of the depth of cut on a machine with this interpolation period (s) and this share of the part in the total
    /// deflection. Of two gauges the first is the one after which the cut passes before the other; two diameters half a turn apart are
    /// equal, so this holds in one of both orders.
    ///
    /// # Errors
    /// A contact at the wheel; two gauges in one place, or with one contact each.
    pub fn seen(&self, part_share: f64, cycle_time_s: f64) -> Result<GaugeSetup, GaugeError> {
        let behind_rad = self.behind_wheel_rad;
        let (gauge, exchanged) = match (self.kind, self.second_behind_wheel_rad) {
            (GaugeKind::Diameter, None) => (gauge::Gauge::diameter(behind_rad)?, false),
            (GaugeKind::Radius, None) => (gauge::Gauge::radius(behind_rad, part_share)?, false),
            (GaugeKind::Radius, Some(_)) => return Err(GaugeError::TwoProbes),
            (GaugeKind::Diameter, Some(second_rad)) => {
                let turned_rad = wrap_turn(second_rad - behind_rad);
                let apart_rad = if turned_rad >= PI { turned_rad - PI } else { turned_rad };
                match gauge::Gauge::two_diameters(behind_rad, apart_rad, 0.0) {
                    Err(GaugeError::NoCutBetween { .. }) => {
                        (gauge::Gauge::two_diameters(second_rad, PI - apart_rad, 0.0)?, true)
                    }
                    other => (other?, false),
                }
            }
        };
        Ok(GaugeSetup { gauge, exchanged, lag_s: self.bandwidth_rad_s.map_or(0.0, f64::recip), cycle_time_s })
    }

    /// Readings of a part without lag, noise and steps (mm), with the wheel line at this azimuth, and a part that deflects so far.
    fn touch(&self, lobe: &Lobe, line_rad: f64, sense: f64, part_gives_way: Deflection) -> [Option<f64>; 2] {
        [Some(self.behind_wheel_rad), self.second_behind_wheel_rad].map(|behind| {
            let behind = sense * behind?;
            let at = |aside: f64| lobe.radius_between_mm(line_rad - behind + aside);
            Some(match self.kind {
                GaugeKind::Diameter => at(0.0) + at(0.5 * TURN_RAD),
                GaugeKind::Radius => {
                    // The part goes the other way than the wheel.
                    let (along, across) = part_gives_way.normal;
                    let (sin, cos) = libm::sincos(behind);
                    at(0.0) - part_gives_way.mm * (along * cos - across * sin)
                }
            })
        })
    }
}

/// A gauge as it runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SimulatedGauge {
    description: GaugeDescription,
    /// Factor of a difference after one step of its lag.
    kept: f64,
    lagging_mm: Option<[f64; 2]>,
    noise: Noise,
}

crate::snapshot!(SimulatedGauge { lagging_mm, noise } on { description, kept });

impl SimulatedGauge {
    pub(super) fn new(description: GaugeDescription, cycle_time_s: f64) -> Self {
        let kept = description.bandwidth_rad_s.map_or(0.0, |bandwidth| libm::exp(-bandwidth * cycle_time_s));
        Self { description, kept, lagging_mm: None, noise: Noise::new(description.seed) }
    }

    /// A job begins: its noise is that of every job.
    pub(super) fn begin_job(&mut self) {
        self.noise = Noise::new(self.description.seed);
    }

    /// There is nothing under it, or it rests.
    pub(super) fn rest(&mut self) {
        self.lagging_mm = None;
    }

    /// One tick. See [`GaugeDescription`] for the kinds.
    pub(super) fn read(
        &mut self,
        lobe: &Lobe,
        line_rad: f64,
        sense: f64,
        part_gives_way: Deflection,
    ) -> [Option<f64>; 2] {
        let touched = self.description.touch(lobe, line_rad, sense, part_gives_way);
        let now = touched.map(|mm| mm.unwrap_or(0.0));
        let before = self.lagging_mm.unwrap_or(now);
        let lagging: [f64; 2] = core::array::from_fn(|i| now[i] + self.kept * (before[i] - now[i]));
        self.lagging_mm = Some(lagging);
        let resolution_mm = self.description.resolution_mm;
        core::array::from_fn(|i| {
            touched[i]?;
            let noisy = lagging[i] + self.description.noise_mm * self.noise.normal();
            Some(if resolution_mm > 0.0 { libm::round(noisy / resolution_mm) * resolution_mm } else { noisy })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::workpiece::DEFAULT_AZIMUTHS;
    use alloc::string::String;
    use alloc::vec::Vec;

    const PLAIN: GaugeDescription = GaugeDescription {
        kind: GaugeKind::Diameter,
        behind_wheel_rad: 0.75 * TURN_RAD,
        second_behind_wheel_rad: None,
        resolution_mm: 0.0,
        noise_mm: 0.0,
        bandwidth_rad_s: None,
        seed: 1,
    };

    fn radius(azimuth: f64) -> f64 {
        20.0 + 0.03 * libm::cos(azimuth - 0.4) + 0.01 * libm::sin(3.0 * azimuth)
    }

    fn lobed() -> Lobe {
        let azimuth = |i: usize| i as f64 * TURN_RAD / DEFAULT_AZIMUTHS as f64;
        let radii: Vec<f64> = (0..DEFAULT_AZIMUTHS).map(|i| radius(azimuth(i))).collect();
        Lobe::new(String::from("J1"), 0, 20.0, radii).expect("a journal")
    }

    /// Whichever of two is named first, the cut comes between them; of the same diameter twice, and of two probes, none does.
    #[test]
    fn the_cut_lies_between_two_gauges_in_one_order() {
        let deg = |deg: f64| deg.to_radians();
        let two = |first: f64, second: f64| {
            let second_behind_wheel_rad = Some(deg(second));
            GaugeDescription { behind_wheel_rad: deg(first), second_behind_wheel_rad, ..PLAIN }.seen(0.5, 1e-3)
        };
        for (first, second, exchanged) in [
            (330.0, 30.0, false),
            (30.0, 330.0, true),
            (200.0, 260.0, true),
            (330.0, 210.0, false),
            (150.0, 200.0, false),
        ] {
            let seen = two(first, second).unwrap();
            assert_eq!(seen.exchanged, exchanged, "{first} {second}");
            assert!(seen.gauge.is_two() && seen.gauge.known_after_rad() > 0.0);
        }
        assert!(matches!(two(270.0, 270.0), Err(GaugeError::Apart { .. })));
        assert!(matches!(two(270.0, 90.0), Err(GaugeError::Apart { .. })), "the same diameter");
        let probes = GaugeDescription { kind: GaugeKind::Radius, second_behind_wheel_rad: Some(1.0), ..PLAIN };
        assert_eq!(probes.seen(0.5, 1e-3), Err(GaugeError::TwoProbes));
    }

    const RIGID: Deflection = Deflection { mm: 0.0, normal: (1.0, 0.0) };

    /// The sum of the radii at the azimuths that have passed the wheel by γ and γ + 180°, in both senses of rotation.
    #[test]
    fn a_diameter_is_that_of_what_passed_the_wheel() {
        let lobe = lobed();
        for (sense, behind) in [(1.0, 0.75 * TURN_RAD), (-1.0, 0.75 * TURN_RAD), (1.0, 0.25 * TURN_RAD)] {
            let mut gauge = SimulatedGauge::new(GaugeDescription { behind_wheel_rad: behind, ..PLAIN }, 1e-3);
            for k in 0..50 {
                let line = 0.37 * f64::from(k) - 5.0;
                let [Some(read), None] = gauge.read(&lobe, line, sense, RIGID) else {
                    panic!("one gauge, one reading")
                };
                let at = line - sense * behind;
                assert!((read - radius(at) - radius(at + 0.5 * TURN_RAD)).abs() < 1e-7, "{read}");
            }
        }
    }

    /// Opposite the wheel a single contact reads the part's share of the deflection too, beside it nothing of it, and two opposed
    /// contacts never.
    #[test]
    fn only_a_single_contact_feels_the_part_give_way() {
        let lobe = lobed();
        let pushed = Deflection { mm: 0.02, normal: (1.0, 0.0) };
        for (behind, more) in [(0.5, 0.02), (0.25, 0.0), (0.75, 0.0), (0.0, -0.02), (0.125, -0.02 * 0.5_f64.sqrt())] {
            let behind_wheel_rad = behind * TURN_RAD;
            let mut single =
                SimulatedGauge::new(GaugeDescription { kind: GaugeKind::Radius, behind_wheel_rad, ..PLAIN }, 1e-3);
            let read = single.read(&lobe, 2.0, 1.0, pushed)[0].expect("a reading");
            assert!((read - radius(2.0 - behind_wheel_rad) - more).abs() < 1e-7, "{behind}: {read}");
            let mut opposed = SimulatedGauge::new(GaugeDescription { behind_wheel_rad, ..PLAIN }, 1e-3);
            assert_eq!(opposed.read(&lobe, 2.0, 1.0, pushed), opposed.read(&lobe, 2.0, 1.0, RIGID));
        }
    }

    /// Behind a lag of bandwidth w a sine of frequency W is smaller by 1/√(1 + (W/w)²).
    #[test]
    fn a_slow_amplifier_flattens_what_passes_quickly() {
        let (bandwidth, cycle_s) = (50.0 * TURN_RAD, 1e-4);
        let lobe = lobed();
        let description = GaugeDescription { kind: GaugeKind::Radius, bandwidth_rad_s: Some(bandwidth), ..PLAIN };
        let mut gauge = SimulatedGauge::new(description, cycle_s);
        let speed = 10.0 * TURN_RAD;
        let readings: Vec<f64> = (0..3000_u32)
            .map(|k| gauge.read(&lobe, speed * f64::from(k) * cycle_s, 1.0, RIGID)[0].expect("a reading"))
            .collect();
        // The last turn, in whose 1000 readings the third harmonic is seen.
        let of = |wave: fn(f64) -> f64| {
            let third = |k: usize| wave(3.0 * speed * k as f64 * cycle_s);
            readings[2000..].iter().enumerate().map(|(k, read)| read * third(k)).sum::<f64>() / 500.0
        };
        let amplitude = of(libm::sin).hypot(of(libm::cos));
        let wanted = 0.01 / (1.0 + (3.0 * speed / bandwidth).powi(2)).sqrt();
        assert!((amplitude - wanted).abs() < 0.01 * wanted, "{amplitude}, not {wanted}");
    }

    #[test]
    fn steps_and_noise_are_those_described_and_repeat() {
        let lobe = lobed();
        let noisy =
            GaugeDescription { noise_mm: 2e-4, resolution_mm: 1e-4, second_behind_wheel_rad: Some(3.0), ..PLAIN };
        let [mut one, mut other] = [SimulatedGauge::new(noisy, 1e-3), SimulatedGauge::new(noisy, 1e-3)];
        let exact = SimulatedGauge::new(PLAIN, 1e-3).read(&lobe, 1.0, 1.0, RIGID)[0].expect("a reading");
        let mut square = 0.0;
        for _ in 0..10_000 {
            let read = one.read(&lobe, 1.0, 1.0, RIGID);
            assert_eq!(read, other.read(&lobe, 1.0, 1.0, RIGID));
            let [Some(first), Some(_)] = read else { panic!("two gauges, two readings") };
            let steps = first / 1e-4;
            assert!((steps - steps.round()).abs() < 1e-6, "{first}");
            square += (first - exact).powi(2) / 10_000.0;
        }
        // Noise and the step's own 1/12.
        let wanted = (2e-4_f64.powi(2) + 1e-8 / 12.0).sqrt();
        assert!((square.sqrt() - wanted).abs() < 0.03 * wanted, "{}, not {wanted}", square.sqrt());
    }
}
