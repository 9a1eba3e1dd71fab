// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Parts with runout in a job file: deviation of the raw part, and correction of its journals.

use super::ConfigError;
use super::contact_file::PER_MM;
use super::yaml::Document;
use camwright::gauging::GaugingMode;
use camwright::gauging::finishing::{
    FinishingSpec, MAX_FINISHING_MM, MAX_FINISHING_N, MAX_FINISHING_STOCK_MM, MAX_FINISHING_TURNS,
};
use camwright::gauging::published::PublishedWindow;
use camwright::gauging::state::{MAX_HARMONICS, USUAL_HARMONICS};
use camwright::job::grinding::{
    CorrectionSpec, IdentificationSpec, KnownContact, MAX_ALLOWANCE_MM, MAX_MARGIN_MM, StiffnessSource, StockSpec,
};
use camwright::job::raw_part::{Bend, RawPart, Wave};
use camwright::machine::contact_law::ContactLaw;
use camwright::math::units::{mm_from_um, rad_from_deg, rad_s_from_rpm, um_from_mm};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Maximum error of a raw part (µm).
const MAX_RUNOUT_UM: f64 = 5000.0;

/// Deviation of the raw part from the design.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawPartFile {
    /// Distance of the part's centre from the axis.
    #[schemars(range(min = 0.0, max = MAX_RUNOUT_UM))]
    eccentric_um: f64,
    /// Direction of the centre, from the keyway.
    #[schemars(range(min = -36000.0, max = 36000.0))]
    eccentric_at_deg: f64,
    /// Distance by which the middle is bent off the axis.
    #[schemars(range(min = 0.0, max = MAX_RUNOUT_UM))]
    bent_um: f64,
    /// Direction of the bend, from the keyway.
    #[schemars(range(min = -36000.0, max = 36000.0))]
    bent_at_deg: f64,
    /// The two positions of `z_axis` between which the part is bent. Required with `bent_um`.
    bent_between_mm: Option<[f64; 2]>,
    /// Waves around the part.
    #[schemars(length(max = 100))]
    lobes: Vec<RawLobeFile>,
    /// Azimuth at which the keyway lies as the part is clamped. The planner does not know it; `find_phase`
    /// finds it.
    #[schemars(range(min = -36000.0, max = 36000.0))]
    clamped_at_deg: f64,
    /// Seed of a random part: the amplitudes above are then maxima, and directions are random. Default: the part
    /// is as written.
    seed: Option<u64>,
    /// Stock beyond `stock_mm`, negative for less. The planner does not know it.
    #[schemars(range(min = -MAX_RUNOUT_UM, max = MAX_RUNOUT_UM))]
    unknown_um: f64,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RawLobeFile {
    /// Crests of the wave around the part.
    #[schemars(range(min = 2, max = 400))]
    count: u32,
    /// Amplitude of the wave.
    #[schemars(range(min = 0.0, max = MAX_RUNOUT_UM))]
    um: f64,
    /// Azimuth of a crest, from the keyway.
    #[schemars(range(min = -36000.0, max = 36000.0))]
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

    /// Values that do not fit each other.
    pub(super) fn findings(&self, document: &Document) -> Vec<ConfigError> {
        let mut findings = Vec::new();
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

/// Runout correction of journals.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CorrectionFile {
    /// Law of the correction.
    #[serde(default)]
    mode: ModeFile,
    /// Harmonics of the part that the gauge separates; more harmonics pass more noise of the gauge.
    #[schemars(range(min = 1, max = MAX_HARMONICS))]
    #[serde(default = "usual_harmonics")]
    harmonics: u32,
    /// Turn of C over which `mode: published` reads the gauge before the wheel leaves; a longer window takes older cuts. It must fit into
    /// the spark-out turns of the last pass. Default: a turn and the angle between two readings, the 540 deg of the text with a diameter.
    #[schemars(range(min = 360.0, max = 36000.0))]
    published_window_deg: Option<f64>,
    /// Step of the readings of `mode: published`: a whole part of 360 deg.
    #[schemars(range(min = 0.05, max = 45.0))]
    #[serde(default = "published_step_deg")]
    published_step_deg: f64,
    /// Turns after the correction that take an even depth and end at the size. Default: the correcting turn ends at the size.
    finishing: Option<FinishingFile>,
    /// Stock that the passes leave for the correcting turn. They leave the depth of the finishing turns in addition.
    #[schemars(range(min = 0.0, max = um_from_mm(MAX_ALLOWANCE_MM)))]
    #[serde(default = "usual_allowance_um")]
    allowance_um: f64,
    /// Stiffness for a journal that is not measured.
    #[serde(default)]
    stiffness: SourceFile,
    /// Contact of journals with their width. `job_planner` writes it into the recorded job.
    #[schemars(length(max = 100))]
    #[serde(default)]
    contacts: Vec<KnownFile>,
}

/// Turns after the correction: `per_turn_um` and `turns`, or `stock_um` and `force_n`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct FinishingFile {
    /// Depth of a turn, in radius. Needs `turns`.
    #[schemars(range(min = 0.1, max = um_from_mm(MAX_FINISHING_MM)))]
    per_turn_um: Option<f64>,
    /// Turns with feed. One turn without feed follows.
    #[schemars(range(min = 1, max = MAX_FINISHING_TURNS))]
    turns: Option<u32>,
    /// Depth of all turns together, in radius. Needs `force_n`.
    #[schemars(range(min = 0.1, max = um_from_mm(MAX_FINISHING_STOCK_MM)))]
    stock_um: Option<f64>,
    /// Normal force that no turn exceeds. The measured contact of a journal gives the number of its turns, and the correction needs
    /// `mode: exact`.
    #[schemars(range(min = 0.1, max = MAX_FINISHING_N))]
    force_n: Option<f64>,
    /// Largest number of turns with feed by `force_n`; a journal that needs more is refused. Default: 20.
    #[schemars(range(min = 1, max = MAX_FINISHING_TURNS))]
    max_turns: Option<u32>,
}

impl FinishingFile {
    /// `None` where the keys belong to no form, or to both.
    fn spec(&self) -> Option<FinishingSpec> {
        match (self.per_turn_um, self.turns, self.stock_um, self.force_n, self.max_turns) {
            (Some(per_turn_um), Some(turns), None, None, None) => {
                Some(FinishingSpec::PerTurn { per_turn_mm: mm_from_um(per_turn_um), turns })
            }
            (None, None, Some(stock_um), Some(force_n), max_turns) => Some(FinishingSpec::ByForce {
                stock_mm: mm_from_um(stock_um),
                force_n,
                max_turns: max_turns.unwrap_or(MAX_FINISHING_TURNS),
            }),
            _ => None,
        }
    }

    /// Error where the keys belong to no form, or to both.
    fn finding(&self, document: &Document) -> Option<ConfigError> {
        if self.spec().is_some() {
            return None;
        }
        let given = |keys: [(&'static str, bool); 5]| keys.into_iter().filter(|key| key.1).map(|key| key.0);
        let given: Vec<&str> = given([
            ("per_turn_um", self.per_turn_um.is_some()),
            ("turns", self.turns.is_some()),
            ("stock_um", self.stock_um.is_some()),
            ("force_n", self.force_n.is_some()),
            ("max_turns", self.max_turns.is_some()),
        ])
        .collect();
        let has = if given.is_empty() { "none of them".to_owned() } else { given.join(", ") };
        let message = format!(
            "finishing needs per_turn_um and turns, or stock_um and force_n (with max_turns if wanted); it has {has}"
        );
        Some(document.error("runout_correction.finishing", message))
    }
}

/// Source of the stiffness where it is not measured.
#[derive(Debug, Default, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum SourceFile {
    #[default]
    /// The stiffness kept for the machine where it is known, else that of the machine file.
    Best,
    /// The stiffness kept for the machine; the job is refused where it is unknown.
    Kept,
    /// The stiffness of the machine file.
    Nominal,
}

/// The contact of a journal, as it was kept for the machine.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct KnownFile {
    /// Name of the lobe.
    lobe: String,
    /// Stiffness of machine and part.
    #[schemars(range(min = 1e-6, max = 1e9))]
    machine_n_um: f64,
    /// Normal force per depth of cut.
    #[schemars(range(min = 1e-6, max = 1e9))]
    grinding_n_um: f64,
    /// Normal force at which the wheel begins to cut.
    #[schemars(range(min = 0.0, max = 1e9))]
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

/// Measurement of the stock of the journals before anything is cut.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(super) struct StockFile {
    /// Distance above the measured stock at which the infeed begins. A gauge with two contacts does not see
    /// eccentricity, bend and odd waves of the raw part: the margin must cover them.
    #[schemars(range(min = 1.0, max = um_from_mm(MAX_MARGIN_MM)))]
    margin_um: f64,
    /// Speed of C under the gauge.
    #[schemars(range(min = 1.0, max = 600.0))]
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
}

/// Measurement of the stiffness of machine and cut before the correction.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(super) struct IdentificationFile {
    /// Travel of the push with the stopped wheel.
    #[schemars(range(min = 1.0, max = 500.0))]
    push_um: f64,
    /// Speed of the push.
    #[schemars(range(min = 1.0, max = 1000.0))]
    push_speed_um_s: f64,
    /// Maximum force of the push; the machine stops beyond it.
    #[schemars(range(min = 1.0, max = 20000.0))]
    most_force_n: f64,
    /// Measures and does not correct.
    only: bool,
    /// Discards the stiffness kept for the machine.
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
        let max_n = self.most_force_n as i64;
        IdentificationSpec {
            push_mm: mm_from_um(self.push_um),
            push_speed_mm_s: mm_from_um(self.push_speed_um_s),
            max_n,
            only: self.only,
            afresh: self.afresh,
        }
    }
}

#[derive(Debug, Default, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum ModeFile {
    #[default]
    /// The law of the contact.
    Exact,
    /// The formula of the published method; needs one gauge that reads a diameter.
    Published,
}

const fn usual_harmonics() -> u32 {
    USUAL_HARMONICS
}

/// The step of the text.
const fn published_step_deg() -> f64 {
    5.0
}

/// Steps of a turn; `None`: the step is no whole part of a turn.
fn published_phases(step_deg: f64) -> Option<u32> {
    let phases = (360.0 / step_deg).round();
    #[allow(clippy::cast_possible_truncation, reason = "a few thousand")]
    ((360.0 / phases - step_deg).abs() <= 1e-9 * step_deg).then_some(phases as u32)
}

/// More than a machine grows while it warms up.
const fn usual_allowance_um() -> f64 {
    20.0
}

impl CorrectionFile {
    /// Values that do not fit each other.
    pub(super) fn findings(&self, document: &Document) -> Vec<ConfigError> {
        let finishing = self.finishing.as_ref().and_then(|finishing| finishing.finding(document));
        self.step_finding(document).into_iter().chain(finishing).collect()
    }

    /// Error where the step of the published measurement is no whole part of a turn.
    fn step_finding(&self, document: &Document) -> Option<ConfigError> {
        let step_deg = self.published_step_deg;
        if published_phases(step_deg).is_some() {
            return None;
        }
        let nearest_deg = 360.0 / (360.0 / step_deg).round();
        let message = format!(
            "published_step_deg is {step_deg}; it must be a whole part of 360 deg, the nearest is {nearest_deg}"
        );
        Some(document.error("runout_correction.published_step_deg", message))
    }

    pub(super) fn spec(&self) -> CorrectionSpec {
        CorrectionSpec {
            mode: match self.mode {
                ModeFile::Exact => GaugingMode::Exact,
                ModeFile::Published => GaugingMode::Published,
            },
            harmonics: self.harmonics,
            published: PublishedWindow {
                turned_rad: self.published_window_deg.map(rad_from_deg),
                phases: published_phases(self.published_step_deg).unwrap_or_default(),
            },
            finishing: self.finishing.as_ref().and_then(FinishingFile::spec),
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
}
