//! What a job file says about a part that runs out: what is off about the raw part, and how its journals are corrected.

use super::ConfigError;
use super::contact_file::PER_MM;
use super::yaml::Document;
use camwright::gauging::Mode;
use camwright::gauging::state::{MOST_HARMONICS, USUAL_HARMONICS};
use camwright::job::grinding::{
    CorrectionSpec, IdentificationSpec, KnownContact, MOST_ALLOWANCE_MM, MOST_MARGIN_MM, StiffnessSource, StockSpec,
};
use camwright::job::raw_part::{Bend, RawPart, Wave};
use camwright::machine::contact_law::ContactLaw;
use camwright::math::units::{mm_from_um, rad_from_deg, rad_s_from_rpm, um_from_mm};
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
    unknown_um: f64,
}

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
            unknown_mm: mm_from_um(self.unknown_um),
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
        if !(-MOST_OFF_UM..=MOST_OFF_UM).contains(&self.unknown_um) {
            let (key, value) = ("raw_part.unknown_um", self.unknown_um);
            findings.push(document.error(key, format!("{key} is {value}; it must be -{MOST_OFF_UM} to {MOST_OFF_UM}")));
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
    #[serde(default)]
    stiffness: SourceFile,
    #[serde(default)]
    contacts: Vec<KnownFile>,
}

/// By which stiffness, where it is not measured.
#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum SourceFile {
    #[default]
    Best,
    Kept,
    Nominal,
}

/// The contact of a journal, as it was kept for the machine.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct KnownFile {
    lobe: String,
    machine_n_um: f64,
    grinding_n_um: f64,
    threshold_n: f64,
}

impl KnownFile {
    fn contact(&self) -> Option<KnownContact> {
        let law = ContactLaw::new(PER_MM * self.machine_n_um, PER_MM * self.grinding_n_um, self.threshold_n).ok()?;
        Some(KnownContact { lobe: self.lobe.clone(), law })
    }
}

/// In the braces of YAML what a job file says of a contact, to a millionth of its units.
pub fn contact_flow(contact: &KnownContact) -> String {
    let (law, per_um) = (contact.law, |n_mm: f64| n_mm / PER_MM);
    format!(
        "{{lobe: {}, machine_n_um: {:.6}, grinding_n_um: {:.6}, threshold_n: {:.6}}}",
        contact.lobe,
        per_um(law.machine_n_mm()),
        per_um(law.grinding_n_mm()),
        law.threshold_n()
    )
}

/// How the stock of the journals is measured before anything is cut.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct StockFile {
    margin_um: f64,
    work_speed_rpm: f64,
}

impl Default for StockFile {
    fn default() -> Self {
        Self { margin_um: 20.0, work_speed_rpm: 60.0 }
    }
}

impl StockFile {
    pub(super) fn spec(&self) -> StockSpec {
        StockSpec { margin_mm: mm_from_um(self.margin_um), speed_rad_s: rad_s_from_rpm(self.work_speed_rpm) }
    }

    /// What can be said about single values.
    pub(super) fn findings(&self, document: &Document) -> Vec<ConfigError> {
        let ranges = [
            ("measure_stock.margin_um", self.margin_um, 1.0, um_from_mm(MOST_MARGIN_MM)),
            ("measure_stock.work_speed_rpm", self.work_speed_rpm, 1.0, 600.0),
        ];
        outside(document, &ranges)
    }
}

/// What is not within its range.
fn outside(document: &Document, ranges: &[(&str, f64, f64, f64)]) -> Vec<ConfigError> {
    let bad = ranges.iter().filter(|(_, value, low, high)| !(*low..=*high).contains(value));
    bad.map(|(key, value, low, high)| document.error(key, format!("{key} is {value}; it must be {low} to {high}")))
        .collect()
}

/// How the stiffness of machine and cut is measured before.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct IdentificationFile {
    push_um: f64,
    push_speed_um_s: f64,
    most_force_n: f64,
    only: bool,
    afresh: bool,
}

impl Default for IdentificationFile {
    fn default() -> Self {
        Self { push_um: 40.0, push_speed_um_s: 50.0, most_force_n: 1000.0, only: false, afresh: false }
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
            only: self.only,
            afresh: self.afresh,
        }
    }

    /// What can be said about single values.
    pub(super) fn findings(&self, document: &Document) -> Vec<ConfigError> {
        let ranges = [
            ("identification.push_um", self.push_um, 1.0, 500.0),
            ("identification.push_speed_um_s", self.push_speed_um_s, 1.0, 1000.0),
            ("identification.most_force_n", self.most_force_n, 1.0, 20_000.0),
        ];
        outside(document, &ranges)
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
            stiffness: match self.stiffness {
                SourceFile::Best => StiffnessSource::Best,
                SourceFile::Kept => StiffnessSource::Kept,
                SourceFile::Nominal => StiffnessSource::Nominal,
            },
            // What is no contact is a finding already.
            contacts: self.contacts.iter().filter_map(KnownFile::contact).collect(),
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
        for (index, contact) in self.contacts.iter().enumerate().filter(|(_, contact)| contact.contact().is_none()) {
            let (key, lobe) = (format!("runout_correction.contacts.{index}"), &contact.lobe);
            let message = format!(
                "lobe {lobe}: machine_n_um and grinding_n_um must be positive numbers, and threshold_n a number from 0 on"
            );
            findings.push(document.error(&key, message));
        }
        findings
    }
}
