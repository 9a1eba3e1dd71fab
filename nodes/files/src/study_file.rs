// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Study files: cases of a job, with factors that vary keys of job and machine.

use super::ConfigError;
use super::any_job::{self, AnyJob};
use super::file_kind::FileKind;
use super::locate::{Located, locate};
use super::machine_file;
use super::names;
use super::recorded_files::{MACHINES, NamedFile, RecordedFiles};
use super::schema;
use super::study_values::{FactorFile, factor_values};
use super::yaml::{Document, YamlValue};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

pub use super::study_values::FactorValues;

/// Newest version of the schema that this program reads.
pub const SCHEMA_VERSION: u32 = 1;

/// Maximum number of cases of a study.
pub const MAX_CASES: u32 = 100_000;

/// Maximum number of factors: the table of direction numbers of the Sobol sequence has as many dimensions.
pub const MAX_FACTORS: u32 = 20;

/// Begin of the names of keys of the machine.
const OF_MACHINE: &str = "machine.";

/// Begin that names of keys of the job may have.
const OF_JOB: &str = "job.";

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct StudyFile {
    /// Kind and version of the file.
    #[schemars(extend("const" = "camwright/study/1"))]
    #[serde(rename = "schema")]
    _schema: String,
    /// Name of the study, also of its folder.
    #[schemars(schema_with = "names::schema")]
    name: String,
    /// One line about the study.
    #[serde(default)]
    title: String,
    /// Grinding or turning job, by name or path.
    job: String,
    /// Machine file, by name or path. Default: the machine of the job.
    machine: Option<String>,
    /// Values of every case: keys of the job, and keys of the machine behind `machine.`.
    #[serde(default, rename = "fixed")]
    _fixed: BTreeMap<String, serde_json::Value>,
    /// Keys that vary: of the job, or of the machine behind `machine.`, with a list, a range or a distribution.
    /// KEY stands for such a key.
    factors: BTreeMap<String, FactorFile>,
    /// Design of the cases.
    design: StudyDesign,
    /// Repetitions of each point of the design; each draws its own random values and seeds.
    #[schemars(range(min = 1, max = MAX_CASES))]
    #[serde(default = "one")]
    replicates: u32,
    /// Keys that get a seed of their own in each case, such as `raw_part.seed` and `machine.gauge.seed`.
    #[schemars(length(max = MAX_FACTORS))]
    #[serde(default)]
    seeds: Vec<String>,
    /// Seed of the design, of random values and of the seeds of the cases.
    #[schemars(range(min = 0, max = 9007199254740991_i64))]
    #[serde(default = "first_seed")]
    seed: u64,
    /// Results that table and report show. Default: all.
    #[schemars(length(min = 1, max = 7))]
    #[serde(default = "all_responses")]
    responses: Vec<StudyResponse>,
    /// Result that the best case has the smallest of.
    #[serde(default = "job_time")]
    minimise: StudyResponse,
    /// Maxima that a feasible case keeps.
    #[serde(default)]
    limits: LimitsFile,
}

/// Maxima of results.
#[derive(Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct LimitsFile {
    /// Maximum form error.
    #[schemars(range(min = 0.0, max = 1e6))]
    form_error_max_um: Option<f64>,
    /// Maximum lift error.
    #[schemars(range(min = 0.0, max = 1e6))]
    lift_error_pv_um: Option<f64>,
    /// Maximum waviness. Default: no limit.
    #[schemars(range(min = 0.0, max = 1e6))]
    waviness_um: Option<f64>,
    /// Maximum time of the job. Default: no limit.
    #[schemars(range(min = 0.0, max = 1e6))]
    job_time_s: Option<f64>,
    /// Maximum wheel power. Default: no limit.
    #[schemars(range(min = 0.0, max = 1e9))]
    power_max_w: Option<f64>,
    /// Maximum burn index.
    #[schemars(range(min = 0.0, max = 1e6))]
    burn_index: Option<f64>,
    /// Maximum number of warnings of the machine. Default: no limit.
    #[schemars(range(min = 0.0, max = 1e6))]
    alarms: Option<f64>,
}

impl Default for LimitsFile {
    fn default() -> Self {
        Self {
            form_error_max_um: Some(5.0),
            lift_error_pv_um: None,
            waviness_um: None,
            job_time_s: None,
            power_max_w: None,
            burn_index: Some(1.0),
            alarms: None,
        }
    }
}

impl LimitsFile {
    fn maxima(&self) -> Vec<(StudyResponse, f64)> {
        let all = [
            self.form_error_max_um,
            self.lift_error_pv_um,
            self.waviness_um,
            self.job_time_s,
            self.power_max_w,
            self.burn_index,
            self.alarms,
        ];
        StudyResponse::ALL.into_iter().zip(all).filter_map(|(response, max)| Some((response, max?))).collect()
    }
}

/// Design of the cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum StudyDesign {
    /// Every combination of the values of all factors.
    Grid {},
    /// Random points, each factor with one value in each of as many strata as there are samples.
    LatinHypercube {
        /// Number of points.
        #[schemars(range(min = 1, max = MAX_CASES))]
        samples: u32,
    },
    /// First points of the Sobol sequence, which fill the ranges evenly.
    Sobol {
        /// Number of points; a power of 2 fills the ranges best.
        #[schemars(range(min = 1, max = MAX_CASES))]
        samples: u32,
    },
    /// The base values, then each factor through its values while the others keep their base.
    OneAtATime {},
}

/// Result of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum StudyResponse {
    /// Form error, the largest magnitude of all lobes (µm).
    FormErrorMaxUm,
    /// Peak-to-valley error of the lift, the largest of all lobes (µm).
    LiftErrorPvUm,
    /// Peak-to-valley form error above 15 undulations per turn, the largest of all lobes (µm).
    WavinessUm,
    /// Time of the job in the machine (s).
    JobTimeS,
    /// Peak power of the wheel (W).
    PowerMaxW,
    /// Burn index, burnt above 1.
    BurnIndex,
    /// Number of warnings of the machine.
    Alarms,
}

impl StudyResponse {
    pub const ALL: [Self; 7] = [
        Self::FormErrorMaxUm,
        Self::LiftErrorPvUm,
        Self::WavinessUm,
        Self::JobTimeS,
        Self::PowerMaxW,
        Self::BurnIndex,
        Self::Alarms,
    ];

    /// Name in files and tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::FormErrorMaxUm => "form_error_max_um",
            Self::LiftErrorPvUm => "lift_error_pv_um",
            Self::WavinessUm => "waviness_um",
            Self::JobTimeS => "job_time_s",
            Self::PowerMaxW => "power_max_w",
            Self::BurnIndex => "burn_index",
            Self::Alarms => "alarms",
        }
    }

    /// Unit, empty for a number.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::FormErrorMaxUm | Self::LiftErrorPvUm | Self::WavinessUm => "um",
            Self::JobTimeS => "s",
            Self::PowerMaxW => "W",
            Self::BurnIndex | Self::Alarms => "",
        }
    }

    /// Position in [`StudyResponse::ALL`].
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }
}

const fn one() -> u32 {
    1
}

const fn first_seed() -> u64 {
    1
}

fn all_responses() -> Vec<StudyResponse> {
    StudyResponse::ALL.to_vec()
}

const fn job_time() -> StudyResponse {
    StudyResponse::JobTimeS
}

/// Key of job or machine, and its value.
pub type StudySetting = (String, YamlValue);

/// Key that a study varies.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyFactor {
    pub key: String,
    pub values: FactorValues,
    /// Value while a design varies another factor.
    pub base: Option<YamlValue>,
    /// The key takes whole numbers.
    pub is_whole: bool,
}

impl StudyFactor {
    /// A number as the key takes it: six digits, or whole.
    #[must_use]
    pub fn number(&self, value: f64) -> YamlValue {
        #[allow(clippy::cast_possible_truncation, reason = "keys that take whole numbers have ranges far below")]
        match self.is_whole {
            true => YamlValue::Integer(value.round() as i64),
            false => YamlValue::Float(format!("{value:.5e}").parse().unwrap_or(value)),
        }
    }

    /// Values that show whether the key takes all of them.
    fn extremes(&self) -> Vec<YamlValue> {
        match &self.values {
            FactorValues::Levels(levels) => levels.clone(),
            FactorValues::Range { from, to, .. } | FactorValues::Uniform { from, to } => {
                vec![self.number(*from), self.number(*to)]
            }
            FactorValues::Normal { mean, .. } => vec![self.number(*mean)],
        }
    }
}

/// Job and machine that the cases of a study start from.
#[derive(Debug, Clone)]
pub struct StudyBase {
    job: Located,
    machine: Located,
    /// Files that the job names, as they were when the study was read.
    files: Vec<NamedFile>,
    fixed: Vec<StudySetting>,
    /// Hash of job and machine with the fixed settings.
    pub hash: String,
}

impl StudyBase {
    /// The job with these settings on top of the fixed ones.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn job_with(&self, settings: &[StudySetting]) -> Result<AnyJob, Vec<ConfigError>> {
        let (mut of_job, mut of_machine, mut machine) = (Vec::new(), Vec::new(), None);
        for (key, value) in self.fixed.iter().chain(settings) {
            let setting = |key: &str| format!("{key}={}", value.to_flow());
            match key.strip_prefix(OF_MACHINE) {
                Some(key) => of_machine.push(setting(key)),
                None => {
                    let key = key.strip_prefix(OF_JOB).unwrap_or(key);
                    if let ("machine", YamlValue::Text(name)) = (key, value) {
                        machine = Some(locate(MACHINES, name, "yaml", Some(&self.job.path)).map_err(|e| vec![e])?);
                    }
                    of_job.push(setting(key));
                }
            }
        }
        let machine = machine.as_ref().unwrap_or(&self.machine);
        let machine = machine_file::read(&machine.path, &machine.text, &of_machine)?;
        let mut files = self.files.clone();
        files.push(NamedFile {
            kind: MACHINES.to_owned(),
            name: machine.description.name.clone(),
            bytes: machine.source.as_bytes().into(),
        });
        any_job::read(&Located { recorded: RecordedFiles::new(files), ..self.job.clone() }, &of_job)
    }

    /// Job file and machine file with these settings on top of the fixed ones.
    ///
    /// # Errors
    /// Everything that is wrong with them.
    pub fn sources_with(&self, settings: &[StudySetting]) -> Result<(String, String), Vec<ConfigError>> {
        Ok(match self.job_with(settings)? {
            AnyJob::Ground(job) => (job.source, job.machine.source),
            AnyJob::Turned(job) => (job.source, job.machine.source),
            AnyJob::Milled(job) => (job.document.text, String::new()),
        })
    }

    /// Settings of every case.
    #[must_use]
    pub fn fixed(&self) -> &[StudySetting] {
        &self.fixed
    }

    /// Value of a key in the file of job or machine.
    fn value(&self, key: &str) -> Option<YamlValue> {
        if let Some((_, value)) = self.fixed.iter().rev().find(|(fixed, _)| fixed == key) {
            return Some(value.clone());
        }
        let (located, key) = match key.strip_prefix(OF_MACHINE) {
            Some(key) => (&self.machine, key),
            None => (&self.job, key.strip_prefix(OF_JOB).unwrap_or(key)),
        };
        let document = Document::parse(&located.path, &located.text, &[]).ok()?;
        document.root.get(key).map(|node| node.value.clone())
    }

    /// Returns whether a key takes whole numbers.
    fn is_whole(&self, key: &str) -> bool {
        if let Some(key) = key.strip_prefix(OF_MACHINE) {
            return schema::is_whole(&FileKind::Machine.schema(), key);
        }
        let document = Document::parse(&self.job.path, &self.job.text, &[]);
        let kind = document
            .ok()
            .and_then(|document| FileKind::ALL.into_iter().find(|kind| document.kind() == Some(kind.name())));
        kind.is_some_and(|kind| schema::is_whole(&kind.schema(), key.strip_prefix(OF_JOB).unwrap_or(key)))
    }
}

/// A study as its file describes it.
#[derive(Debug, Clone)]
pub struct Study {
    pub name: String,
    pub title: String,
    /// Name or path by which commands find the job.
    pub job: String,
    /// Machine file that the study names instead of that of the job.
    pub machine: Option<String>,
    pub base: StudyBase,
    /// Factors in the order of the file.
    pub factors: Vec<StudyFactor>,
    pub design: StudyDesign,
    pub replicates: u32,
    /// Keys that get a seed in each case.
    pub seeds: Vec<String>,
    pub seed: u64,
    pub responses: Vec<StudyResponse>,
    pub minimise: StudyResponse,
    /// Maxima of a feasible case.
    pub limits: Vec<(StudyResponse, f64)>,
    /// Number of cases.
    pub case_count: u32,
    /// Hash of the job with a value that is a text, and may name a file, by `key=value`.
    pub text_hashes: BTreeMap<String, String>,
    pub document: Document,
}

/// Finds, reads and understands a study.
///
/// # Errors
/// Everything that [`read`] finds.
pub fn load(name: &str, overrides: &[String]) -> Result<Study, Vec<ConfigError>> {
    read(&locate("studies", name, "yaml", None).map_err(|error| vec![error])?, overrides)
}

/// Name, title of the studies that [`load`] finds by name.
#[must_use]
pub fn list() -> Vec<(String, String)> {
    let title = |name: &str| {
        let located = locate("studies", name, "yaml", None).ok()?;
        Some(Document::with_overrides(&located, &[]).ok()?.text_at("title").unwrap_or_default().to_owned())
    };
    super::locate::list("studies").into_iter().filter_map(|name| title(&name).map(|title| (name, title))).collect()
}

/// Understands a study that has been read, and checks every value that its factors take with the job.
///
/// # Errors
/// Everything that is wrong with it, each with its line.
pub fn read(located: &Located, overrides: &[String]) -> Result<Study, Vec<ConfigError>> {
    let one = |error: ConfigError| vec![error];
    let document = Document::with_overrides(located, overrides).map_err(one)?;
    document.require_schema("study", SCHEMA_VERSION).map_err(one)?;
    let file: StudyFile = schema::read(&document)?;
    let mut findings = Vec::new();
    let base = read_base(&document, &file).map_err(|errors| findings.extend(errors)).ok();
    let mut factors = Vec::new();
    for key in keys_of(&document, "factors") {
        let path = format!("factors.{key}");
        let Some(values) = file.factors.get(&key) else { continue };
        match factor_values(&document, &path, values) {
            Ok((values, stated)) => {
                let is_whole = base.as_ref().is_some_and(|base| base.is_whole(&key));
                let value = || base.as_ref().and_then(|base| base.value(&key));
                factors.push(StudyFactor { values, base: stated.or_else(value), is_whole, key });
            }
            Err(error) => findings.push(error),
        }
    }
    let case_count = count_cases(&document, &file, &factors).map_err(|error| findings.push(error)).ok();
    if factors.is_empty() && findings.is_empty() {
        findings.push(document.error("factors", "factors is empty; name at least one key that varies"));
    }
    findings.extend(needed_values(&document, &file, &factors));
    let mut text_hashes = BTreeMap::new();
    if let Some(base) = &base {
        findings.extend(check_values(&document, base, &factors, &file.seeds, &mut text_hashes));
    }
    let Some((base, case_count)) = base.zip(case_count).filter(|_| findings.is_empty()) else { return Err(findings) };
    let job = match base.job.path.is_file() {
        true => base.job.path.display().to_string(),
        false => file.job,
    };
    Ok(Study {
        name: file.name,
        title: file.title,
        job,
        machine: file.machine,
        base,
        factors,
        design: file.design,
        replicates: file.replicates,
        seeds: file.seeds,
        seed: file.seed,
        responses: file.responses,
        minimise: file.minimise,
        limits: file.limits.maxima(),
        case_count,
        text_hashes,
        document,
    })
}

/// Keys of a mapping of the file, in its order.
fn keys_of(document: &Document, path: &str) -> Vec<String> {
    match document.root.get(path).map(|node| &node.value) {
        Some(YamlValue::Map(entries)) => entries.iter().map(|(key, _)| key.clone()).collect(),
        _ => Vec::new(),
    }
}

fn read_base(document: &Document, file: &StudyFile) -> Result<StudyBase, Vec<ConfigError>> {
    let find = |key: &str, kind: &str, name: &str, beside: &Document| {
        locate(kind, name, "yaml", Some(&beside.path)).map_err(|error| vec![document.error(key, error.to_string())])
    };
    let job = find("job", "jobs", &file.job, document)?;
    let job_document = Document::with_overrides(&job, &[]).map_err(|error| vec![error])?;
    let mut fixed: Vec<StudySetting> = Vec::new();
    let machine = match (&file.machine, job_document.text_at("machine")) {
        (Some(name), _) => find("machine", MACHINES, name, document)?,
        (None, Some(name)) => find("job", MACHINES, name, &job_document)?,
        (None, None) => {
            let message = format!("job {} names no machine; name a grinding or a turning job", file.job);
            return Err(vec![document.error("job", message)]);
        }
    };
    for key in keys_of(document, "fixed") {
        if let Some(node) = document.root.get(&format!("fixed.{key}")) {
            fixed.push((key, node.value.clone()));
        }
    }
    let mut base = StudyBase { job, machine, files: Vec::new(), fixed, hash: String::new() };
    let job = base.job_with(&[]).map_err(|errors| {
        errors.into_iter().map(|error| relayed(document, "fixed", &base.fixed, error)).collect::<Vec<_>>()
    })?;
    let files = match &job {
        AnyJob::Ground(job) => job.files.to_vec(),
        AnyJob::Turned(job) => job.files.to_vec(),
        AnyJob::Milled(_) => {
            let message = format!("job {} is milled on another control; name a grinding or a turning job", file.job);
            return Err(vec![document.error("job", message)]);
        }
    };
    base.files = files.into_iter().filter(|file| file.kind != MACHINES).collect();
    base.hash = hash_of(&job);
    Ok(base)
}

/// Hash of a job with its machine.
fn hash_of(job: &AnyJob) -> String {
    match job {
        AnyJob::Ground(job) => format!("{} {}", job.hash, job.machine.description.hash),
        AnyJob::Turned(job) => format!("{} {}", job.hash, job.machine.description.hash),
        AnyJob::Milled(job) => job.hash.clone(),
    }
}

/// The error of a job or machine at the line of the study whose setting causes it.
fn relayed(document: &Document, group: &str, settings: &[StudySetting], error: ConfigError) -> ConfigError {
    let bare = |key: &str| {
        let key = key.strip_prefix(OF_MACHINE).or_else(|| key.strip_prefix(OF_JOB)).unwrap_or(key);
        format!("{key}=")
    };
    let is_cause = |(key, _): &&StudySetting| error.place.line.is_none() && error.message.contains(&bare(key));
    match settings.iter().find(is_cause) {
        Some((key, _)) => document.error(&format!("{group}.{key}"), error.message),
        None => error,
    }
}

/// Number of cases, or why there are too many.
fn count_cases(document: &Document, file: &StudyFile, factors: &[StudyFactor]) -> Result<u32, ConfigError> {
    let counts = || factors.iter().filter(|factor| !factor.values.is_random()).map(|factor| factor.values.count());
    let points = match file.design {
        // A range without steps is reported elsewhere.
        StudyDesign::Grid {} => counts().fold(1_u64, |product, count| product.saturating_mul(count.unwrap_or(1))),
        StudyDesign::OneAtATime {} => counts().fold(1_u64, |sum, count| sum.saturating_add(count.unwrap_or(1))),
        StudyDesign::LatinHypercube { samples } | StudyDesign::Sobol { samples } => u64::from(samples),
    };
    let cases = points.saturating_mul(u64::from(file.replicates));
    let refuse = |key: &str| {
        let message =
            format!("the study has {cases} cases; at most {MAX_CASES} are allowed: fewer steps, samples or replicates");
        document.error(key, message)
    };
    match u32::try_from(cases) {
        Ok(cases) if cases <= MAX_CASES => Ok(cases),
        _ => Err(refuse(if points > u64::from(MAX_CASES) { "design" } else { "replicates" })),
    }
}

/// Values that the design needs and the factors do not have.
fn needed_values(document: &Document, file: &StudyFile, factors: &[StudyFactor]) -> Vec<ConfigError> {
    let (needs_steps, needs_base, design) = match file.design {
        StudyDesign::Grid {} => (true, false, "grid"),
        StudyDesign::OneAtATime {} => (true, true, "one_at_a_time"),
        StudyDesign::LatinHypercube { .. } | StudyDesign::Sobol { .. } => (false, false, ""),
    };
    let mut findings = Vec::new();
    if factors.len() > MAX_FACTORS as usize {
        let message = format!("factors has {} keys; at most {MAX_FACTORS} are allowed", factors.len());
        findings.push(document.error("factors", message));
    }
    for StudyFactor { key, values, base, .. } in factors {
        let path = format!("factors.{key}");
        if needs_steps && values.count().is_none() {
            findings.push(document.error(&path, format!("{path}.steps is missing; the design {design} needs it")));
        }
        if needs_base && base.is_none() && !values.is_random() {
            let message = format!(
                "{path}.base is missing; the files do not set {key}, and the design one_at_a_time needs its base value"
            );
            findings.push(document.error(&path, message));
        }
    }
    findings
}

/// Everything that the job or the machine does not take of the values of the factors, and hashes of values that are texts.
fn check_values(
    document: &Document,
    base: &StudyBase,
    factors: &[StudyFactor],
    seeds: &[String],
    text_hashes: &mut BTreeMap<String, String>,
) -> Vec<ConfigError> {
    let first = |factor: &StudyFactor| Some((factor.key.clone(), factor.extremes().into_iter().next()?));
    let all_first: Vec<StudySetting> = factors.iter().filter_map(first).collect();
    let mut findings: Vec<ConfigError> = Vec::new();
    for factor in factors {
        for value in factor.extremes() {
            let setting = (factor.key.clone(), value);
            let text =
                matches!(setting.1, YamlValue::Text(_)).then(|| format!("{}={}", setting.0, setting.1.to_flow()));
            let alone = [setting.clone()];
            let job = base.job_with(&alone).or_else(|errors| {
                // A key may need another factor.
                let others = all_first.iter().filter(|(key, _)| *key != factor.key).cloned();
                base.job_with(&others.chain([setting]).collect::<Vec<_>>()).map_err(|_| errors)
            });
            match job {
                Ok(job) => {
                    text_hashes.extend(text.map(|text| (text, hash_of(&job))));
                }
                Err(errors) => {
                    let is_new = |error: &ConfigError, known: &[ConfigError]| {
                        let about = |error: &ConfigError| error.message.split(" (set by ").next().map(str::to_owned);
                        known.iter().all(|known| about(known) != about(error))
                    };
                    for error in errors {
                        let error = relayed(document, "factors", &alone, error);
                        if is_new(&error, &findings) {
                            findings.push(error);
                        }
                    }
                }
            }
        }
    }
    for (index, key) in seeds.iter().enumerate() {
        let setting = [(key.clone(), YamlValue::Integer(1))];
        for error in base.job_with(&setting).err().into_iter().flatten() {
            findings.push(document.error(&format!("seeds.{index}"), error.message));
        }
    }
    findings
}

#[cfg(test)]
mod tests;
