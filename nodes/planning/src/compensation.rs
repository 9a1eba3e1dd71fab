// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Form compensation of a job from part to part: what was learned, kept as text between parts, and laid over the job that is planned next.

use super::{PreparedJob, simulate_outlines_on};
use crate::{self as planning, SimulationFailed};
use camwright::cam::compensation::{
    CompensationSpec, FormCurve, Learned, LearnedError, LobeLearning, MAX_CORRECTION_MM,
};
use camwright::cam::gauge_report::{Alignment, GaugeReport, GaugeReportError};
use camwright::machine::description::MachineDescription;
use camwright::math::units::{deg_from_rad, um_from_mm};
use camwright::planner::{LobeDesign, designs};
use camwright_files::compensation_file::CurveFile;
use camwright_files::convert::machine_now::MachineNow;
use camwright_files::gauge_report_file::ReportTable;
use camwright_files::job_file::{self, Job};
use camwright_msgs::camwright_msgs::msg::LobeResult;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Newest version of the schema of what was learned that this program reads.
const SCHEMA: &str = "camwright/learned/1";

/// Azimuths at which designs are compared.
const LOOKS: u32 = 720;

/// A correction this near to what was kept is the same (mm): what a file rounds to, and ten times that.
const SAME_MM: f64 = 1e-8;

/// Learned corrections of the lobes of a job on a machine, and the number of parts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearnedJob {
    schema: String,
    machine: String,
    job: String,
    /// Finished parts of the job on the machine since it learns.
    pub parts: u64,
    lobes: Vec<LearnedLobe>,
}

/// Learned correction of a lobe.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LearnedLobe {
    lobe: String,
    /// Identifies its design.
    design: String,
    gain: f64,
    parts: u64,
    taken_back: bool,
    correction: CurveFile,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    least: Option<MinimumEntry>,
}

/// Correction with the smallest error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MinimumEntry {
    correction: CurveFile,
    error: CurveFile,
}

impl LearnedLobe {
    fn from_learning(design: &LobeDesign, learning: &LobeLearning) -> Self {
        let smallest = learning.smallest.as_ref();
        Self {
            lobe: design.name.clone(),
            design: fingerprint(design),
            gain: learning.gain,
            parts: learning.parts,
            taken_back: learning.taken_back,
            correction: CurveFile::from_curve(&learning.correction),
            least: smallest.map(|(correction, error)| MinimumEntry {
                correction: CurveFile::from_curve(correction),
                error: CurveFile::from_curve(error),
            }),
        }
    }

    /// `None` for what no learning leaves.
    fn learning(&self) -> Option<LobeLearning> {
        let smallest = match &self.least {
            Some(entry) => Some((entry.correction.curve()?, entry.error.curve()?)),
            None => None,
        };
        (0.0..=1.0).contains(&self.gain).then_some(())?;
        let (gain, parts, taken_back) = (self.gain, self.parts, self.taken_back);
        Some(LobeLearning { correction: self.correction.curve()?, gain, parts, smallest, taken_back })
    }
}

impl LearnedJob {
    #[must_use]
    pub fn new(machine: &str, job: &str) -> Self {
        Self { schema: SCHEMA.into(), machine: machine.into(), job: job.into(), parts: 0, lobes: Vec::new() }
    }

    /// Parses the text of [`Self::text`].
    ///
    /// # Errors
    /// One sentence for what is not that.
    pub fn parse(text: &str) -> Result<Self, String> {
        let read: Self = serde_saphyr::from_str(text).map_err(|error| error.without_snippet().to_string())?;
        if read.schema != SCHEMA {
            return Err(format!("schema is {:?}, this program reads {SCHEMA:?}", read.schema));
        }
        match read.lobes.iter().find(|lobe| lobe.learning().is_none()) {
            Some(lobe) => Err(format!("its correction of lobe {} was not learned", lobe.lobe)),
            None => Ok(read),
        }
    }

    /// Text of the file.
    ///
    /// # Errors
    /// What YAML says.
    pub fn text(&self) -> Result<String, String> {
        serde_saphyr::to_string(self).map_err(|error| error.to_string())
    }

    /// It was learned of this job on this machine.
    #[must_use]
    pub fn is_of(&self, machine: &str, job: &str) -> bool {
        self.machine == machine && self.job == job
    }

    /// Learned correction of a lobe for its present design, from its file.
    fn for_design(&self, design: &LobeDesign) -> Option<LobeLearning> {
        let lobe = self.lobes.iter().find(|lobe| lobe.lobe == design.name)?;
        (lobe.design == fingerprint(design)).then(|| lobe.learning())?
    }

    /// The override that lays what was learned over a job; `None` for a job that does not learn, begins afresh, says itself what was
    /// learned, or of which nothing is known.
    #[must_use]
    pub fn override_for(&self, job: &Job) -> Option<String> {
        let compensation = job.spec.compensation.as_ref()?;
        if compensation.afresh || !compensation.learned.is_empty() {
            return None;
        }
        let lobes: Vec<String> = designs(&job.spec)
            .ok()?
            .iter()
            .filter_map(|design| {
                let (correction, _) = self.for_design(design)?.correction.bounded(&compensation.spec);
                (!correction.is_zero())
                    .then(|| format!("{{lobe: {}, {}}}", design.name, CurveFile::from_curve(&correction).flow()))
            })
            .collect();
        (!lobes.is_empty()).then(|| format!("form_compensation.learned=[{}]", lobes.join(", ")))
    }

    /// Learns from the outlines of a part (mm, at equal azimuths; in the order of its lobes) that was ground with the corrections of its
    /// job, and returns a report for each lobe. If the job's correction differs from the stored one (another was written into the job, or
    /// none, afresh), learning starts anew with this part.
    ///
    /// # Errors
    /// An outline that cannot be measured.
    pub fn learn(&mut self, prepared: &PreparedJob, outlines_mm: &[Vec<f64>]) -> Result<Vec<String>, String> {
        let Some(compensation) = &prepared.job.spec.compensation else { return Ok(Vec::new()) };
        let spec = &compensation.spec;
        let mut lines = Vec::new();
        let mut lobes = Vec::new();
        for ((_, lobe), radii_mm) in prepared.finished_lobes().zip(outlines_mm) {
            let design = &lobe.design;
            let measured = FormCurve::measure(radii_mm, &design.contour, design.phase_rad, spec.harmonics)
                .map_err(|error| format!("the form of lobe {} cannot be learned: {error}", design.name))?;
            let used = curve_of_lobe(&compensation.learned, &design.name);
            let kept = self.for_design(design).filter(|kept| same(&kept.correction, &used) && !compensation.afresh);
            let mut learning = kept.unwrap_or_else(|| LobeLearning { correction: used, ..LobeLearning::new(spec) });
            learning.gain = learning.gain.min(spec.gain);
            let learned = learning.learn(spec, &measured);
            lines.push(sentence(&design.name, learned, &measured, &learning, spec));
            lobes.push(LearnedLobe::from_learning(design, &learning));
        }
        if compensation.afresh {
            self.parts = 0;
        }
        self.parts += 1;
        // Lobes that this job has not are those of an earlier version of it.
        self.lobes = lobes;
        Ok(lines)
    }
}

/// Report of a measuring machine on a lobe of a job.
#[derive(Debug, Clone)]
pub struct LobeReport {
    /// Name of the lobe.
    pub lobe: String,
    /// Name of the report in errors.
    pub file: String,
    pub table: ReportTable,
}

/// Correction of the next part from reports.
#[derive(Debug, Clone)]
pub struct ReportedCorrections {
    /// Override of the job with the corrections of all its lobes.
    pub override_text: String,
    /// Result of each report.
    pub lobes: Vec<ReportedLobe>,
}

/// Use of the report of one lobe.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReportedLobe {
    pub lobe: String,
    pub values: usize,
    /// Largest deviation in size, as reported and after the alignment (µm).
    pub largest_um: f64,
    pub aligned_largest_um: f64,
    /// Root mean square of the harmonics that are learned (µm).
    pub error_rms_um: f64,
    pub size_um: f64,
    pub eccentricity_um: f64,
    /// Azimuth of the eccentricity in the frame of the lobe (deg).
    pub eccentricity_at_deg: f64,
    /// Rotation (deg); none where it cannot be separated from the eccentricity.
    pub phase_deg: Option<f64>,
    /// Largest correction of the next part (µm).
    pub correction_um: f64,
    /// The bounds of the job made the correction smaller.
    pub is_bounded: bool,
}

/// Learns the correction of the next part from reports on a part that was ground with the corrections of this job. Lobes without a report
/// keep their correction.
///
/// # Errors
/// A lobe that the job does not have or that has two reports; a report that cannot be the lobe.
pub fn learn_reports(
    prepared: &PreparedJob,
    reports: &[LobeReport],
    alignment: Alignment,
) -> Result<ReportedCorrections, String> {
    let kept = prepared.job.spec.compensation.as_ref();
    let spec = kept.map_or_else(CompensationSpec::default, |compensation| compensation.spec);
    let mut learned = kept.map_or_else(Vec::new, |compensation| compensation.learned.clone());
    let mut lobes: Vec<ReportedLobe> = Vec::new();
    for LobeReport { lobe, file, table } in reports {
        let designs = || prepared.planned.lobes.iter().map(|planned| &planned.design);
        let Some(design) = designs().find(|design| design.name == *lobe) else {
            let known: Vec<&str> = designs().map(|design| design.name.as_str()).collect();
            return Err(format!("lobe is {lobe:?}; lobes of {}: {}", prepared.job.spec.name, known.join(", ")));
        };
        if lobes.iter().any(|reported| reported.lobe == *lobe) {
            return Err(format!("lobe {lobe} has two reports; one is needed"));
        }
        let refuse = |error: GaugeReportError| format!("{file}: lobe {lobe}: {error}{}", remedy(&error));
        let report = GaugeReport::new(table.kind, &table.values, &design.contour, design.phase_rad, spec.harmonics)
            .map_err(refuse)?;
        let aligned = report.without(alignment);
        let error = aligned.curve(spec.harmonics, MAX_CORRECTION_MM).map_err(refuse)?;
        let used = curve_of_lobe(&learned, lobe);
        let mut learning = LobeLearning { correction: used, ..LobeLearning::new(&spec) };
        let step = learning.learn(&spec, &error);
        let mounting = report.mounting();
        let eccentricity = mounting.eccentricity_mm;
        lobes.push(ReportedLobe {
            lobe: lobe.clone(),
            values: table.values.len(),
            largest_um: um_from_mm(report.largest_mm()),
            aligned_largest_um: um_from_mm(aligned.largest_mm()),
            error_rms_um: um_from_mm(error.rms_mm()),
            size_um: um_from_mm(mounting.size_mm),
            eccentricity_um: um_from_mm(eccentricity.norm()),
            eccentricity_at_deg: deg_from_rad(eccentricity.y.atan2(eccentricity.x)),
            phase_deg: mounting.phase_rad.map(deg_from_rad),
            correction_um: um_from_mm(learning.correction.largest().0),
            is_bounded: step == Learned::Bounded,
        });
        learned.retain(|learned| learned.lobe != *lobe);
        learned.push(LearnedError { lobe: lobe.clone(), correction: learning.correction });
    }
    let lobes_text: Vec<String> = (learned.iter())
        .map(|learned| format!("{{lobe: {}, {}}}", learned.lobe, CurveFile::from_curve(&learned.correction).flow()))
        .collect();
    Ok(ReportedCorrections { override_text: format!("form_compensation.learned=[{}]", lobes_text.join(", ")), lobes })
}

/// Remedy for a report that cannot be used.
fn remedy(error: &GaugeReportError) -> &'static str {
    match error {
        GaugeReportError::Gap { .. } => "; set form_compensation.harmonics, or measure more values",
        GaugeReportError::Mirrored { .. } => "; use --mirrored",
        GaugeReportError::TooLarge { .. } => {
            "; if the mounting of the part in the gauge caused that: --align eccentricity,phase"
        }
        _ => "",
    }
}

fn curve_of_lobe(learned: &[LearnedError], name: &str) -> FormCurve {
    learned.iter().find(|learned| learned.lobe == name).map(|learned| learned.correction.clone()).unwrap_or_default()
}

fn same(one: &FormCurve, other: &FormCurve) -> bool {
    one.plus(-1.0, other).largest().0 < SAME_MM
}

/// SHA-256 over the radii of a design, to the nanometre.
fn fingerprint(design: &LobeDesign) -> String {
    let mut hasher = Sha256::new();
    for i in 0..LOOKS {
        let radius_mm = design.contour.radius_at(f64::from(i) * std::f64::consts::TAU / f64::from(LOOKS));
        hasher.update(format!("{radius_mm:.6};").as_bytes());
    }
    hasher.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect()
}

fn sentence(
    lobe: &str,
    learned: Learned,
    measured: &FormCurve,
    learning: &LobeLearning,
    spec: &CompensationSpec,
) -> String {
    let (error_um, max_um) = (um_from_mm(measured.rms_mm()), um_from_mm(learning.correction.largest().0));
    let next = match learned {
        Learned::Step => format!("the next part is corrected by up to {max_um:.3} um"),
        Learned::Bounded => format!(
            "the next part is corrected by up to {max_um:.3} um, which is bounded by {:.3} um and its slope",
            um_from_mm(spec.max_mm)
        ),
        Learned::TakenBack => {
            format!("that is more than before: taken back to up to {max_um:.3} um, gain {:.3}", learning.gain)
        }
        Learned::Stopped => format!("no more is learned: every gain made it worse; up to {max_um:.3} um stay"),
    };
    format!(
        "lobe {lobe}: form error {error_um:.3} um rms over {} harmonics after {} parts; {next}",
        spec.harmonics, learning.parts
    )
}

/// The overrides of a job with what was learned for it after them.
#[must_use]
pub fn with_learned(name: &str, overrides: &[String], learned: &LearnedJob) -> Vec<String> {
    let more = job_file::load(name, overrides).ok().and_then(|job| learned.override_for(&job));
    overrides.iter().cloned().chain(more).collect()
}

/// Form error of a job on a machine after it has learned from this number of parts there, with the usual settings if it does not learn
/// itself: the part after them.
///
/// # Errors
/// A part that cannot be planned or simulated.
pub fn simulate_learned(
    prepared: &PreparedJob,
    description: &MachineDescription,
    parts: u32,
    mut each: impl FnMut(u32, &[LobeResult]),
) -> Result<Vec<LobeResult>, SimulationFailed> {
    let failed = |reason: String| SimulationFailed::new(&prepared.job.spec.name, &reason);
    let mut kept = LearnedJob::new(&description.name, &prepared.job.spec.name);
    let mut job = prepared.job.clone();
    let compensation = job.spec.compensation.get_or_insert_with(|| camwright::cam::compensation::Compensation {
        spec: CompensationSpec::default(),
        learned: Vec::new(),
        afresh: false,
    });
    (compensation.learned, compensation.afresh) = (Vec::new(), false);
    let now = MachineNow { description: prepared.machine.clone(), wheels: prepared.wheels };
    for part in 0..=parts {
        let planned = planning::plan(job.clone(), Some(&now)).map_err(|error| failed(error.to_string()))?;
        let (_, results, outlines_mm) = simulate_outlines_on(&planned, description, |_, _| {})?;
        each(part, &results);
        if part == parts {
            return Ok(results);
        }
        kept.learn(&planned, &outlines_mm).map_err(&failed)?;
        let lobes: Vec<LearnedError> = planned
            .planned
            .lobes
            .iter()
            .filter_map(|lobe| {
                let correction = kept.for_design(&lobe.design)?.correction;
                Some(LearnedError { lobe: lobe.design.name.clone(), correction })
            })
            .collect();
        if let Some(compensation) = &mut job.spec.compensation {
            compensation.learned = lobes;
        }
    }
    Err(failed("no part was ground".into()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare;
    use camwright_files::convert::mm_from_m;

    fn short(more: &[&str]) -> Vec<String> {
        ["infeed.total_mm=0.072", "stock_mm=0.06"].iter().chain(more).map(ToString::to_string).collect()
    }

    /// The default job on good drives: after three parts every lobe is within 2 µm from its highest to its lowest place.
    #[test]
    fn three_parts_on_good_drives_teach_the_default_job() {
        let prepared = prepare("four_lobe_camshaft", &short(&[]), None).unwrap();
        let good = prepared.machine.clone().with_good_drives().unwrap();
        let mut worst_um = Vec::new();
        simulate_learned(&prepared, &good, 3, |_, lobes| {
            let um = lobes.iter().map(|lobe| um_from_mm(mm_from_m(lobe.form_error_max.abs())));
            worst_um.push(um.fold(0.0, f64::max));
        })
        .unwrap();
        eprintln!("largest form error of each part: {worst_um:?} um");
        // Twice the largest deviation bounds peak to valley.
        assert!(worst_um.len() == 4 && 2.0 * worst_um[3] <= 2.0 && worst_um[3] < worst_um[0], "{worst_um:?}");
    }

    /// Radii of the simulated part as a measuring machine reports them, the part mounted 15 µm off centre: the next part, corrected by the
    /// reports, has less than half the form error (gain 0.7).
    #[test]
    fn reports_of_a_measured_part_correct_the_next_one() {
        use camwright::cam::gauge_report::{ReportKind, ReportedValue};
        let ground = |set: &[String]| {
            let prepared = prepare("four_lobe_camshaft", set, None).unwrap();
            let description = prepared.machine.clone();
            let (_, results, outlines) = simulate_outlines_on(&prepared, &description, |_, _| {}).unwrap();
            let worst = results.iter().map(|lobe| um_from_mm(mm_from_m(lobe.form_error_max.abs()))).fold(0.0, f64::max);
            (prepared, outlines, worst)
        };
        let set = short(&[]);
        let (prepared, outlines, before_um) = ground(&set);
        let value = |(index, count): (usize, usize), radius_mm: f64| {
            let azimuth = index as f64 * std::f64::consts::TAU / count as f64;
            let (x, y) = (radius_mm * azimuth.cos() + 0.012, radius_mm * azimuth.sin() - 0.009);
            ReportedValue { line: index + 1, angle_rad: y.atan2(x), value_mm: x.hypot(y) }
        };
        let reports: Vec<LobeReport> = (prepared.planned.lobes.iter().zip(&outlines))
            .map(|(lobe, radii)| {
                let values = (0..radii.len()).step_by(4).map(|i| value((i, radii.len()), radii[i])).collect();
                let table = ReportTable { kind: ReportKind::Radius, values };
                LobeReport { lobe: lobe.design.name.clone(), file: "report".into(), table }
            })
            .collect();
        let alignment = Alignment { eccentricity: true, ..Alignment::default() };
        let learned = learn_reports(&prepared, &reports, alignment).unwrap();
        for lobe in &learned.lobes {
            assert!((lobe.eccentricity_um - 15.0).abs() < 3.0 && lobe.aligned_largest_um < 1.5 * before_um, "{lobe:?}");
        }
        let (_, _, after_um) = ground(&[set, vec![learned.override_text]].concat());
        eprintln!("form error {before_um} um, after the report {after_um} um");
        assert!(after_um < 0.5 * before_um, "{before_um} {after_um}");
    }

    /// A learned correction survives its file and the job: the same corrections, the same plan, wherever it is planned.
    #[test]
    fn a_learned_job_plans_to_the_same_hash_from_its_own_recorded_text() {
        let set = short(&["form_compensation={}"]);
        let prepared = prepare("four_lobe_camshaft", &set, None).unwrap();
        let raised = |um: f64| -> Vec<Vec<f64>> {
            let lobes = prepared.planned.lobes.iter();
            let radius = |design: &LobeDesign, i: u32| design.radius_at(f64::from(i) * std::f64::consts::TAU / 3600.0);
            lobes.map(|lobe| (0..3600).map(|i| radius(&lobe.design, i) + 1e-3 * um).collect()).collect()
        };
        let mut kept = LearnedJob::new("cam_grinder", "four_lobe_camshaft");
        assert_eq!(with_learned("four_lobe_camshaft", &set, &kept), set);
        let lines = kept.learn(&prepared, &raised(1.0)).unwrap();
        assert!(lines.len() == 4 && lines[0].starts_with("lobe I1: form error"), "{lines:?}");
        let kept = LearnedJob::parse(&kept.text().unwrap()).unwrap();
        assert_eq!(kept.parts, 1);
        let overrides = with_learned("four_lobe_camshaft", &set, &kept);
        assert_eq!(overrides.len(), set.len() + 1);
        let corrected = prepare("four_lobe_camshaft", &overrides, None).unwrap();
        assert_ne!(corrected.plan_hash(), prepared.plan_hash());
        let located = camwright_files::locate::locate("jobs", "four_lobe_camshaft", "yaml", None).unwrap();
        let recorded = camwright_files::locate::Located { text: corrected.job.source.clone(), ..located };
        let again = planning::plan(job_file::parse(&recorded, &[]).unwrap(), None).unwrap();
        assert_eq!((again.plan_hash(), &again.job.hash), (corrected.plan_hash(), &corrected.job.hash));
        // The same correction is recognised, another begins anew, afresh forgets.
        let mut twice = kept.clone();
        twice.learn(&corrected, &raised(0.3)).unwrap();
        assert_eq!((twice.parts, twice.lobes[0].parts), (2, 2));
        let mut other = kept.clone();
        other.learn(&prepared, &raised(1.0)).unwrap();
        assert_eq!((other.parts, other.lobes[0].parts), (2, 1));
        let afresh = prepare("four_lobe_camshaft", &short(&["form_compensation.afresh=true"]), None).unwrap();
        assert!(kept.override_for(&afresh.job).is_none());
        let mut forgotten = twice.clone();
        forgotten.learn(&afresh, &raised(1.0)).unwrap();
        assert_eq!((forgotten.parts, forgotten.lobes[0].parts), (1, 1));
    }

    #[test]
    fn a_lobe_of_another_design_is_not_corrected_by_what_was_learned() {
        let set = short(&["form_compensation={}"]);
        let prepared = prepare("four_lobe_camshaft", &set, None).unwrap();
        let radii = |lobe: &camwright::planner::PlannedLobe| {
            (0..720).map(|i| lobe.design.radius_at(f64::from(i) * std::f64::consts::TAU / 720.0) + 0.001).collect()
        };
        let outlines: Vec<Vec<f64>> = prepared.planned.lobes.iter().map(radii).collect();
        let mut kept = LearnedJob::new("cam_grinder", "four_lobe_camshaft");
        kept.learn(&prepared, &outlines).unwrap();
        let all = kept.override_for(&prepared.job).unwrap();
        assert!(all.contains("lobe: I1") && all.contains("lobe: E2"));
        let larger = job_file::load(
            "four_lobe_camshaft",
            &short(&["form_compensation={}", "profiles.intake.base_radius_mm=16.1"]),
        );
        let some = kept.override_for(&larger.unwrap()).unwrap();
        assert!(!some.contains("lobe: I1") && some.contains("lobe: E1"), "{some}");
    }

    #[test]
    fn a_file_without_learned_parts_is_refused() {
        let text = LearnedJob::new("m", "j").text().unwrap();
        assert_eq!(LearnedJob::parse(&text).unwrap(), LearnedJob::new("m", "j"));
        let newer = text.replace("learned/1", "learned/9");
        assert!(LearnedJob::parse(&newer).unwrap_err().contains("this program reads"));
        assert!(LearnedJob::parse("schema: camwright/learned/1\n").is_err());
    }
}
