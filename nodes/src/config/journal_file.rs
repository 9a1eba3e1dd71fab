//! What a job file says about a part that runs out: what is off about the raw part, and how its journals are corrected.

use super::ConfigError;
use super::yaml::Document;
use camwright::job::{CorrectionSpec, IdentificationSpec, MOST_ALLOWANCE_MM};
use camwright::raw_part::{Bend, RawPart, Wave};
use camwright::runout::Mode;
use camwright::runout::state::{MOST_HARMONICS, USUAL_HARMONICS};
use camwright::units::{mm_from_um, rad_from_deg, um_from_mm};
use serde::Deserialize;

/// Largest amplitude of a raw part (µm): beyond it it is another part.
const MOST_OFF_UM: f64 = 5000.0;

/// What is off about the raw part.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawPartFile {
    eccentric_um: f64,
    eccentric_at_deg: f64,
    bent_um: f64,
    bent_at_deg: f64,
    bent_between_mm: Option<[f64; 2]>,
    lobes: Vec<RawLobeFile>,
    clamped_at_deg: f64,
    seed: Option<u64>,
}

/// Waves around it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLobeFile {
    count: u32,
    um: f64,
    #[serde(default)]
    at_deg: f64,
}

impl RawPartFile {
    pub(super) fn part(&self) -> RawPart {
        let wave = |um: f64, at_deg: f64| Wave { mm: mm_from_um(um), at_rad: rad_from_deg(at_deg) };
        let part = RawPart {
            eccentric: wave(self.eccentric_um, self.eccentric_at_deg),
            bend: self.bent_between_mm.map(|[from_mm, to_mm]| Bend {
                wave: wave(self.bent_um, self.bent_at_deg),
                between_mm: (from_mm, to_mm),
            }),
            lobes: self.lobes.iter().map(|lobe| (lobe.count, wave(lobe.um, lobe.at_deg))).collect(),
            clamped_at_rad: rad_from_deg(self.clamped_at_deg),
        };
        self.seed.map_or_else(|| part.clone(), |seed| part.drawn(seed))
    }

    /// What can be said about single values.
    pub(super) fn findings(&self, document: &Document) -> Vec<ConfigError> {
        let mut findings = Vec::new();
        let amplitudes =
            [("raw_part.eccentric_um".to_owned(), self.eccentric_um), ("raw_part.bent_um".into(), self.bent_um)]
                .into_iter()
                .chain(self.lobes.iter().enumerate().map(|(i, lobe)| (format!("raw_part.lobes.{i}.um"), lobe.um)));
        for (key, value) in amplitudes {
            if !(0.0..=MOST_OFF_UM).contains(&value) {
                findings.push(document.error(&key, format!("{key} is {value}; it must be 0 to {MOST_OFF_UM}")));
            }
        }
        let angles = [
            ("raw_part.eccentric_at_deg".to_owned(), self.eccentric_at_deg),
            ("raw_part.bent_at_deg".into(), self.bent_at_deg),
            ("raw_part.clamped_at_deg".into(), self.clamped_at_deg),
        ];
        let of_lobes = self.lobes.iter().enumerate();
        for (key, value) in
            angles.into_iter().chain(of_lobes.map(|(i, lobe)| (format!("raw_part.lobes.{i}.at_deg"), lobe.at_deg)))
        {
            if !value.is_finite() {
                findings.push(document.error(&key, format!("{key} is {value}; it must be a finite number")));
            }
        }
        for (i, lobe) in self.lobes.iter().enumerate().filter(|(_, lobe)| !(2..=100).contains(&lobe.count)) {
            let key = format!("raw_part.lobes.{i}.count");
            findings.push(document.error(&key, format!("{key} is {}; it must be 2 to 100", lobe.count)));
        }
        match self.bent_between_mm {
            None if self.bent_um > 0.0 => findings.push(document.error(
                "raw_part.bent_um",
                "a part that is bent needs raw_part.bent_between_mm: the positions of z_axis between which it is",
            )),
            Some([from_mm, to_mm]) if !(from_mm.is_finite() && to_mm.is_finite() && from_mm < to_mm) => {
                let message = format!(
                    "raw_part.bent_between_mm is {from_mm} to {to_mm}; it must go from a smaller to a larger position"
                );
                findings.push(document.error("raw_part.bent_between_mm", message));
            }
            _ => {}
        }
        findings
    }
}

/// How the runout of journals is corrected.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CorrectionFile {
    #[serde(default)]
    mode: ModeFile,
    #[serde(default = "usual_harmonics")]
    harmonics: u32,
    #[serde(default = "usual_allowance_um")]
    allowance_um: f64,
}

/// How the stiffness of machine and cut is measured before.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct IdentificationFile {
    push_um: f64,
    push_speed_um_s: f64,
    most_force_n: f64,
}

impl Default for IdentificationFile {
    fn default() -> Self {
        Self { push_um: 40.0, push_speed_um_s: 50.0, most_force_n: 1000.0 }
    }
}

impl IdentificationFile {
    pub(super) fn spec(&self) -> IdentificationSpec {
        #[allow(clippy::cast_possible_truncation, reason = "its range is checked")]
        let most_n = self.most_force_n as i64;
        IdentificationSpec {
            push_mm: mm_from_um(self.push_um),
            push_speed_mm_s: mm_from_um(self.push_speed_um_s),
            most_n,
        }
    }

    /// What can be said about single values.
    pub(super) fn findings(&self, document: &Document) -> Vec<ConfigError> {
        let ranges = [
            ("identification.push_um", self.push_um, 1.0, 500.0),
            ("identification.push_speed_um_s", self.push_speed_um_s, 1.0, 1000.0),
            ("identification.most_force_n", self.most_force_n, 1.0, 20_000.0),
        ];
        let bad = ranges.into_iter().filter(|(_, value, low, high)| !(low..=high).contains(&value));
        bad.map(|(key, value, low, high)| document.error(key, format!("{key} is {value}; it must be {low} to {high}")))
            .collect()
    }
}

#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum ModeFile {
    #[default]
    Exact,
    Published,
}

const fn usual_harmonics() -> u32 {
    USUAL_HARMONICS
}

/// More than a machine grows while it warms up.
const fn usual_allowance_um() -> f64 {
    20.0
}

impl CorrectionFile {
    pub(super) fn spec(&self) -> CorrectionSpec {
        CorrectionSpec {
            mode: match self.mode {
                ModeFile::Exact => Mode::Exact,
                ModeFile::Published => Mode::Published,
            },
            harmonics: self.harmonics,
            allowance_mm: mm_from_um(self.allowance_um),
        }
    }

    /// What can be said about single values.
    pub(super) fn findings(&self, document: &Document) -> Vec<ConfigError> {
        let mut findings = Vec::new();
        let most_um = um_from_mm(MOST_ALLOWANCE_MM);
        if !(0.0..=most_um).contains(&self.allowance_um) {
            let (key, value) = ("runout_correction.allowance_um", self.allowance_um);
            findings.push(document.error(key, format!("{key} is {value}; it must be 0 to {most_um}")));
        }
        if !(1..=MOST_HARMONICS).contains(&self.harmonics) {
            let (key, value) = ("runout_correction.harmonics", self.harmonics);
            findings.push(document.error(key, format!("{key} is {value}; it must be 1 to {MOST_HARMONICS}")));
        }
        findings
    }
}
