// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Form compensation in a job file: settings, and corrections learned before this part.

use camwright::cam::compensation::{
    Compensation, CompensationSpec, FormCurve, LearnedError, MAX_CORRECTION_MM, MAX_HARMONICS,
};
use camwright::math::units::{mm_from_um, rad_from_deg, um_from_mm};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Settings for learning.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(super) struct CompensationFile {
    /// Share of the measured form error by which the next part is corrected.
    #[schemars(range(min = 1e-6, max = 1.0))]
    gain: f64,
    /// Harmonics of a turn that are corrected, size included. Harmonic k at n rpm moves X at k n/60 Hz.
    #[schemars(range(min = 1, max = MAX_HARMONICS))]
    harmonics: u32,
    /// Maximum shift of the wheel path.
    #[schemars(range(min = 1e-6, max = um_from_mm(MAX_CORRECTION_MM)))]
    most_um: f64,
    /// Maximum slope of the shift.
    #[schemars(range(min = 1e-6, max = 20.0))]
    most_um_per_deg: f64,
    /// Discards what was learned before.
    afresh: bool,
    /// Learned shift of the lobes. `job_planner` writes it into the recorded job.
    #[schemars(length(max = 100))]
    learned: Vec<LearnedFile>,
}

impl Default for CompensationFile {
    fn default() -> Self {
        let spec = CompensationSpec::default();
        Self {
            gain: spec.gain,
            harmonics: spec.harmonics,
            most_um: um_from_mm(spec.max_mm),
            most_um_per_deg: um_per_deg(spec.max_slope_mm_rad),
            afresh: false,
            learned: Vec::new(),
        }
    }
}

/// A slope as files have it.
fn um_per_deg(mm_rad: f64) -> f64 {
    um_from_mm(mm_rad) * rad_from_deg(1.0)
}

/// A lobe's correction as files have it.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct LearnedFile {
    /// Name of the lobe.
    lobe: String,
    /// Mean of the shift over the cam angle.
    #[schemars(range(min = -1e6, max = 1e6))]
    mean_um: f64,
    /// Cosine and sine of every harmonic of the shift.
    #[schemars(length(max = MAX_HARMONICS))]
    waves_um: Vec<[f64; 2]>,
}

impl LearnedFile {
    fn curve(&self) -> Option<FormCurve> {
        CurveFile { mean_um: self.mean_um, waves_um: self.waves_um.clone() }.curve()
    }
}

/// A periodic curve in files: its mean, and cosine and sine of its harmonics.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CurveFile {
    mean_um: f64,
    waves_um: Vec<[f64; 2]>,
}

/// A number of a curve as files have it: to the picometre.
fn rounded_um(mm: f64) -> f64 {
    let um = (um_from_mm(mm) * 1e6).round() / 1e6;
    // No minus before a zero.
    um + 0.0
}

impl CurveFile {
    pub fn from_curve(curve: &FormCurve) -> Self {
        Self {
            mean_um: rounded_um(curve.mean_mm()),
            waves_um: curve.waves_mm().iter().map(|wave| wave.map(rounded_um)).collect(),
        }
    }

    /// `None` for what is no number, or too many.
    pub fn curve(&self) -> Option<FormCurve> {
        FormCurve::new(mm_from_um(self.mean_um), self.waves_um.iter().map(|wave| wave.map(mm_from_um)).collect())
    }

    /// In the braces of YAML, without them: `mean_um: 0.1, waves_um: [[0.2, 0.3]]`.
    pub fn flow(&self) -> String {
        let waves: Vec<String> = self.waves_um.iter().map(|[a, b]| format!("[{a:.6}, {b:.6}]")).collect();
        format!("mean_um: {:.6}, waves_um: [{}]", self.mean_um, waves.join(", "))
    }
}

impl CompensationFile {
    pub(super) fn compensation(&self) -> Compensation {
        let learned = self.learned.iter().filter(|_| !self.afresh).map(|learned| LearnedError {
            lobe: learned.lobe.clone(),
            // What is no curve is a finding already.
            correction: learned.curve().unwrap_or_default(),
        });
        Compensation {
            spec: CompensationSpec {
                gain: self.gain,
                harmonics: self.harmonics,
                max_mm: mm_from_um(self.most_um),
                max_slope_mm_rad: mm_from_um(self.most_um_per_deg) / rad_from_deg(1.0),
            },
            learned: learned.collect(),
            afresh: self.afresh,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job_file::{self, Job};

    fn load(set: &[&str]) -> Result<Job, String> {
        let set: Vec<String> = set.iter().map(ToString::to_string).collect();
        job_file::load("four_lobe_camshaft", &set).map_err(|error| error.to_string())
    }

    #[test]
    fn a_job_learns_only_on_request_with_default_settings() {
        assert!(load(&[]).unwrap().spec.compensation.is_none());
        let usual = load(&["form_compensation={}"]).unwrap().spec.compensation.unwrap();
        let (spec, wanted) = (usual.spec, CompensationSpec::default());
        assert!((spec.max_slope_mm_rad - wanted.max_slope_mm_rad).abs() < 1e-12, "{spec:?}");
        assert_eq!((spec.gain, spec.harmonics, usual.learned.len()), (wanted.gain, wanted.harmonics, 0));
    }

    #[test]
    fn a_setting_out_of_range_is_reported_with_its_bound() {
        for (set, expected) in [
            ("form_compensation.gain=1.5", "form_compensation.gain is 1.5; it must be 0.000001 to 1"),
            ("form_compensation.gain=0.0", "form_compensation.gain is 0; it must be 0.000001 to 1"),
            ("form_compensation.harmonics=400", "form_compensation.harmonics is 400; it must be 1 to 180"),
            ("form_compensation.most_um=300.0", "form_compensation.most_um is 300; it must be 0.000001 to 100"),
            ("form_compensation.most_um_per_deg=30.0", "it must be 0.000001 to 20"),
            ("form_compensation.learn=1", "form_compensation.learn is an unknown key; did you mean learned?"),
        ] {
            let error = load(&[set]).err().unwrap();
            assert!(error.contains(expected), "{set}: {error}");
        }
    }

    /// A learned curve survives its file to the picometre and changes the hash of the job; `afresh` omits it.
    #[test]
    fn a_learned_curve_survives_its_file_and_is_part_of_the_job() {
        let curve = FormCurve::new(-0.001_234_567_89, vec![[0.000_5, -1e-7], [0.0, 3.25e-4]]).unwrap();
        let file = CurveFile::from_curve(&curve);
        let set = format!("form_compensation.learned=[{{lobe: E1, {}}}]", file.flow());
        let job = load(&[&set]).unwrap();
        let learned = &job.spec.compensation.as_ref().unwrap().learned[0];
        assert_eq!((learned.lobe.as_str(), CurveFile::from_curve(&learned.correction)), ("E1", file));
        assert!(learned.correction.plus(-1.0, &curve).largest().0 < 1e-9);
        assert_ne!(job.hash, load(&["form_compensation={}"]).unwrap().hash);
        let afresh = load(&[&set, "form_compensation.afresh=true"]).unwrap();
        assert!(afresh.spec.compensation.unwrap().learned.is_empty());
    }
}
