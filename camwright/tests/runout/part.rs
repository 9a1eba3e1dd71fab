// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The reference: a part of several thousand phases, ground one phase after the other, and gauges that read it.
//!
//! The depth of every cut is found by halving an interval until spring and cut are in balance; nothing of the core is used but the
//! types in which readings and positions are handed over.

use camwright::gauging::correction::Correction;
use camwright::gauging::gauge::Gauge;
use camwright::gauging::record::RunoutReading;
use camwright::gauging::wheel_log::WheelPosition;
use camwright::machine::contact_law::ContactLaw;
use std::f64::consts::PI;

/// km/kg of the shop's usual cases: from a slender shaft on a stiff wheel to a stiff part.
pub(crate) const RATIOS: [f64; 4] = [0.05, 0.1, 0.2, 0.5];

/// Angles of the gauge (deg after the wheel).
pub(crate) const ANGLES_DEG: [u32; 5] = [90, 135, 225, 270, 315];

/// kg of every case (N/mm) and F0 (N).
pub(crate) const GRINDING_N_MM: f64 = 5.0e4;
pub(crate) const THRESHOLD_N: f64 = 15.0;

pub(crate) fn law(ratio: f64) -> ContactLaw {
    ContactLaw::new(ratio * GRINDING_N_MM, GRINDING_N_MM, THRESHOLD_N).unwrap()
}

pub(crate) fn rad(deg: f64) -> f64 {
    deg * PI / 180.0
}

/// Gaussian noise of a seed: `SplitMix64`, and the transform of Box and Muller.
#[derive(Debug, Clone)]
pub(crate) struct NoiseSource {
    state: u64,
}

impl NoiseSource {
    pub(crate) fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    pub(crate) fn unit(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn gauss(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (2.0 * PI * self.unit()).cos()
    }
}

/// Contacts of the gauge.
#[derive(Debug, Clone, Copy)]
pub(crate) enum PartContacts {
    Diameter,
    Radius { work_share: f64 },
}

/// A gauge of the reference, at a whole number of phases after the wheel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GaugeStation {
    pub(crate) contacts: PartContacts,
    pub(crate) angle_deg: f64,
    pub(crate) every_deg: f64,
    pub(crate) sigma_mm: f64,
    pub(crate) zero_mm: f64,
}

impl GaugeStation {
    pub(crate) fn diameter(angle_deg: f64, every_deg: f64) -> Self {
        Self { contacts: PartContacts::Diameter, angle_deg, every_deg, sigma_mm: 0.0, zero_mm: 0.0 }
    }
}

/// A part on the machine.
#[derive(Debug, Clone)]
pub(crate) struct GaugedPart {
    /// Radius of every phase (mm).
    pub(crate) radii: Vec<f64>,
    law: ContactLaw,
    /// Phases that have passed the wheel.
    place: i64,
    stations: Vec<GaugeStation>,
    /// Readings of every station.
    pub(crate) readings: Vec<Vec<RunoutReading>>,
    /// Position of the wheel at every phase.
    pub(crate) log: Vec<WheelPosition>,
    /// Radius with which every phase left the wheel (mm).
    pub(crate) left: Vec<f64>,
    /// Normal force at every phase (N).
    pub(crate) forces: Vec<f64>,
    noise: NoiseSource,
}

impl GaugedPart {
    /// A part of radius 20 mm with lobes of a harmonic, an amplitude (mm) and a phase (rad).
    pub(crate) fn new(
        phases: usize,
        law: ContactLaw,
        lobes: &[(f64, f64, f64)],
        stations: &[GaugeStation],
        seed: u64,
    ) -> Self {
        let angle = |k: usize| 2.0 * PI * k as f64 / phases as f64;
        let radius = |k: usize| 20.0 + lobes.iter().map(|(h, a, at)| a * (h * (angle(k) - at)).cos()).sum::<f64>();
        Self {
            radii: (0..phases).map(radius).collect(),
            law,
            place: 0,
            stations: stations.to_vec(),
            readings: vec![Vec::new(); stations.len()],
            log: Vec::new(),
            left: Vec::new(),
            forces: Vec::new(),
            noise: NoiseSource::new(seed),
        }
    }

    pub(crate) fn angle(&self, place: i64) -> f64 {
        2.0 * PI * place as f64 / self.radii.len() as f64
    }

    /// C of the phase that passes the wheel next (rad).
    pub(crate) fn c_rad(&self) -> f64 {
        self.angle(self.place)
    }

    fn index(&self, place: i64) -> usize {
        place.rem_euclid(self.radii.len() as i64) as usize
    }

    /// The next phase passes the wheel.
    pub(crate) fn pass(&mut self, wheel_mm: f64) {
        let index = self.index(self.place);
        let engagement = self.radii[index] - wheel_mm;
        let (km, kg, f0) = (self.law.machine_n_mm(), self.law.grinding_n_mm(), self.law.threshold_n());
        let (mut depth, mut more) = (0.0, engagement.max(0.0));
        // Too deep where cutting needs more than the spring has left.
        for _ in 0..60 {
            let middle = 0.5 * (depth + more);
            if kg * middle + f0 < km * (engagement - middle) { depth = middle } else { more = middle }
        }
        self.radii[index] -= depth;
        self.left.push(self.radii[index]);
        let deflection = (engagement - depth).max(0.0);
        let c_rad = self.c_rad();
        self.log.push(WheelPosition { c_rad, x_mm: wheel_mm });
        self.forces.push(km * deflection);
        for number in 0..self.stations.len() {
            self.read(number, deflection);
        }
        self.place += 1;
    }

    fn read(&mut self, number: usize, deflection: f64) {
        let station = self.stations[number];
        let per_deg = self.radii.len() as f64 / 360.0;
        if self.place % ((station.every_deg * per_deg).round() as i64) != 0 {
            return;
        }
        let near = self.place - (station.angle_deg * per_deg).round() as i64;
        let value = match station.contacts {
            PartContacts::Diameter => {
                self.radii[self.index(near)] + self.radii[self.index(near + self.radii.len() as i64 / 2)]
            }
            PartContacts::Radius { work_share } => {
                self.radii[self.index(near)] - work_share * rad(station.angle_deg).cos() * deflection
            }
        };
        let value_mm = value + station.zero_mm + station.sigma_mm * self.noise.gauss();
        let tick = u64::try_from(self.place).unwrap();
        let c_rad = self.c_rad();
        self.readings[number].push(RunoutReading { c_rad, value_mm, tick });
    }

    /// Turns with infeed, the wheel coming closer by `feed_mm` a turn in a spiral from `from_mm` on; where it ends.
    pub(crate) fn feed(&mut self, turns: f64, from_mm: f64, feed_mm: f64) -> f64 {
        let steps = (turns * self.radii.len() as f64).round() as i64;
        for step in 1..=steps {
            self.pass(from_mm - feed_mm * step as f64 / self.radii.len() as f64);
        }
        from_mm - feed_mm * turns
    }

    /// Turns at one position.
    pub(crate) fn dwell(&mut self, turns: f64, wheel_mm: f64) {
        for _ in 0..(turns * self.radii.len() as f64).round() as i64 {
            self.pass(wheel_mm);
        }
    }

    /// The wheel stays until the correction begins, is led by it for its turn, and stays another turn where that leaves it. Gives the
    /// runout at its beginning and after its end.
    pub(crate) fn correct(&mut self, correction: &Correction, stays_mm: f64) -> (f64, f64) {
        // A tiny bit early, for the start may be the very angle of a phase.
        while self.c_rad() < correction.start_rad() - 1e-9 {
            self.pass(stays_mm);
        }
        let before = self.runout();
        for _ in 0..self.radii.len() {
            let since = (self.c_rad() - correction.start_rad()).max(0.0);
            self.pass(correction.at(since).value);
        }
        self.dwell(1.0, correction.leaves_mm());
        (before, self.runout())
    }

    /// TIR (mm).
    pub(crate) fn runout(&self) -> f64 {
        let max = self.radii.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        max - self.radii.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// A journal as the tests grind it: eccentric by 20 um, three-lobed by 6 um and five-lobed by 2 um, fed by 10 um a turn for thirteen
/// turns from 30 um outside a round part, where the wheel is clear of it, then at rest for `dwell` turns. Gives the part and where the wheel stands.
pub(crate) fn journal(
    phases: usize,
    ratio: f64,
    stations: &[GaugeStation],
    dwell: f64,
    seed: u64,
) -> (GaugedPart, f64) {
    let lobes = [(1.0, 0.020, 0.7), (3.0, 0.006, 0.2), (5.0, 0.002, 1.9)];
    let mut part = GaugedPart::new(phases, law(ratio), &lobes, stations, seed);
    let wheel_mm = part.feed(13.0, 20.03, 0.010);
    part.dwell(dwell, wheel_mm);
    (part, wheel_mm)
}

/// The journal's C when its dwell begins (rad).
pub(crate) const DWELLS_FROM_RAD: f64 = 26.0 * PI;

/// Readings from an angle of the headstock on.
pub(crate) fn from(readings: &[RunoutReading], c_rad: f64) -> &[RunoutReading] {
    &readings[readings.partition_point(|reading| reading.c_rad < c_rad - 1e-9)..]
}

pub(crate) fn diameter(angle_deg: f64) -> Gauge {
    Gauge::diameter(rad(angle_deg)).unwrap()
}
