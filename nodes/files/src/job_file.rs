//! Job files: what is written, and the job it means.

use super::ConfigError;
use super::compensation_file::CompensationFile;
use super::fault_file::{self, FaultFile, JobFault};
use super::job_files::{JobFiles, NamedFile};
use super::journal_file::{CorrectionFile, IdentificationFile, RawPartFile, StockFile};
use super::lift_file::ProfileLift;
use super::limits::{self, MAX_SPARK_OUT_TURNS};
use super::locate::{Located, locate};
use super::machine_file::{self, Machine};
use super::names;
use super::nc_file::{NcFile, NcSettings};
use super::pass_file::{InfeedFile, RoughingFile, SpeedFile, passes, roughing_findings};
use super::profile_file::{self, ProfileFile};
use super::program_file::{self, JobProgram};
use super::start_file::{DryRunFile, StartFile};
use super::wheel_file::{DressingFile, ObstacleFile, WheelPowerFile, wishes};
use super::yaml::Document;
use camwright::cam::follower::Follower;
use camwright::job::grinding::{
    BetweenLobes, HoldInCut, HomePosition, JobSpec, LEAST_BLOCKS, LobeSpec, PassSpec, ProfileSpec,
};
use camwright::math::units::{TURN_RAD, rad_from_deg};
use camwright::planner::{LobeOrder, fastest_order};
use serde::Deserialize;
use std::sync::Arc;

/// Newest version of the job file's schema that this program reads.
pub const SCHEMA_VERSION: u32 = 1;

/// Blocks per turn of a lift that comes from a formula: 0.1°, as on the tape of JPS6156064B2.
const FORMULA_BLOCKS: u32 = 3600;

/// Most blocks per turn, as of a table.
const MOST_BLOCKS: u32 = 36_000;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct JobFile {
    #[serde(rename = "schema")]
    _schema: String,
    name: String,
    #[serde(default)]
    title: String,
    machine: String,
    wheel_radius_mm: Option<f64>,
    profiles: Vec<ProfileFile>,
    lobes: Vec<LobeFile>,
    stock_mm: f64,
    rapid_advance_mm: f64,
    rapid_speed_mm_s: f64,
    infeed: InfeedFile,
    blocks_per_turn: Option<u32>,
    work_speed_rpm: f64,
    #[serde(default)]
    speed: SpeedFile,
    #[serde(default)]
    roughing: Vec<RoughingFile>,
    #[serde(default = "default_retract")]
    retract_clearance_mm: f64,
    #[serde(default)]
    hold_in_cut: HoldFile,
    wheel_power: Option<WheelPowerFile>,
    #[serde(default)]
    c_between_lobes: BetweenLobesFile,
    #[serde(default = "default_arrival_margin")]
    arrival_margin_ms: f64,
    #[serde(default)]
    rotary_indexing: bool,
    #[serde(default)]
    lobe_order: LobeOrderFile,
    home: HomeFile,
    dressing: Option<DressingFile>,
    #[serde(default)]
    obstacles: Vec<ObstacleFile>,
    #[serde(default = "default_clearance")]
    clearance_mm: f64,
    #[serde(default)]
    faults: Vec<FaultFile>,
    #[serde(default)]
    raw_part: RawPartFile,
    runout_correction: Option<CorrectionFile>,
    form_compensation: Option<CompensationFile>,
    start_at: Option<StartFile>,
    identification: Option<IdentificationFile>,
    dry_run: Option<DryRunFile>,
    #[serde(default)]
    part_phase_deg: f64,
    measure_stock: Option<StockFile>,
    #[serde(default)]
    nc: NcFile,
    program: Option<String>,
}

/// In which order the lobes are machined.
#[derive(Debug, Default, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum LobeOrderFile {
    #[default]
    AsWritten,
    Fastest,
}

/// What a hold does in the cut.
#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum HoldFile {
    #[default]
    Retract,
    StopInfeed,
}

/// What C does between two lobes.
#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum BetweenLobesFile {
    #[default]
    Stops,
    TurnsOn,
}

fn default_arrival_margin() -> f64 {
    20.0
}

fn default_retract() -> f64 {
    2.0
}

fn default_clearance() -> f64 {
    1.0
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LobeFile {
    name: String,
    station: String,
    profile: String,
    phase_deg: f64,
    width_mm: f64,
    wheel_radius_mm: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct HomeFile {
    x_mm: f64,
    z_mm: f64,
}

/// A job as its files describe it.
#[derive(Debug, Clone)]
pub struct Job {
    /// What the files mean.
    pub spec: JobSpec,
    /// The order of its lobes, where it was sought.
    pub lobe_order: Option<LobeOrder>,
    /// One line about it.
    pub title: String,
    /// What the job file says, with overrides written in.
    pub source: String,
    /// SHA-256 over the job file and every table it names, 64 hexadecimal digits.
    pub hash: String,
    /// The files that it names.
    pub files: Arc<[NamedFile]>,
    /// Lift of each profile: its law, the table it was read from, and what is to be said about that.
    pub lifts: Vec<ProfileLift>,
    /// What each profile is inspected with, where the job says so.
    pub gauges: Vec<Option<Follower>>,
    /// The machine it is for.
    pub machine: Machine,
    /// It begins with a lobe in its middle: the part in the machine stays as it is, and the lobes before are not in `spec`.
    pub starts_in_the_middle: bool,
    /// Faults that strike in it.
    pub faults: Vec<JobFault>,
    /// Radius of the wheel it was written for, if it says so (mm).
    pub wheel_radius_mm: Option<f64>,
    /// How an NC program is made of it.
    pub nc: NcSettings,
    /// The NC program that it is ground by, instead of its own cuts.
    pub program: Option<JobProgram>,
    /// The job file, for messages that point into it.
    pub document: Document,
}

/// Finds, reads and understands a job with `key=value` overrides.
///
/// # Errors
/// The first of what [`read`] finds.
pub fn load(name: &str, overrides: &[String]) -> Result<Job, ConfigError> {
    parse(&locate("jobs", name, "yaml", None)?, overrides)
}

/// Understands a job that has been read.
///
/// # Errors
/// The first of what [`read`] finds.
pub fn parse(located: &Located, overrides: &[String]) -> Result<Job, ConfigError> {
    read(located, overrides).map_err(|mut findings| findings.swap_remove(0))
}

/// Understands a job that has been read, or says everything that is in the way.
///
/// # Errors
/// Anything that is not a job, at least one sentence: unknown or missing keys, values out of range, tables that are
/// refused. What needs the result of a failed step is left out.
pub fn read(located: &Located, overrides: &[String]) -> Result<Job, Vec<ConfigError>> {
    let document = Document::of(located, overrides).map_err(one)?;
    document.require_schema("job", SCHEMA_VERSION).map_err(one)?;
    let file: JobFile = document.read().map_err(one)?;
    let mut findings = ranges(&document, &file);
    findings.extend(file.raw_part.findings(&document));
    findings.extend(file.form_compensation.iter().flat_map(|compensation| compensation.findings(&document)));
    findings.extend(file.identification.iter().flat_map(|identification| identification.findings(&document)));
    findings.extend(file.measure_stock.iter().flat_map(|stock| stock.findings(&document)));
    findings.extend(file.runout_correction.iter().flat_map(|correction| correction.findings(&document)));
    let machine = machine_file::named(&document, &file.machine).map_err(|error| findings.push(error)).ok();
    let mut files = JobFiles::of(&document);
    let (mut profiles, mut lifts) = (Vec::new(), Vec::new());
    let mut blocks: Option<u32> = None;
    for (index, profile) in file.profiles.iter().enumerate() {
        match profile.read(&document, "profiles", index, &mut files) {
            Ok((spec, lift)) => {
                let table_blocks = lift.table.as_ref().and_then(|table| u32::try_from(table.blocks()).ok());
                match (blocks, table_blocks) {
                    (Some(first), Some(other)) if first != other && file.blocks_per_turn.is_none() => {
                        findings.push(document.error(
                            &format!("profiles.{index}.lift"),
                            format!(
                                "profile {}: {other} blocks per turn, the first table has {first}; where tables differ, \
                                 blocks_per_turn must say how many infeed.per_block_um counts",
                                profile.name
                            ),
                        ));
                    }
                    (None, Some(_)) => blocks = table_blocks,
                    _ => {}
                }
                profiles.push(spec);
                lifts.push(lift);
            }
            Err(errors) => findings.extend(errors),
        }
    }
    let lobes = read_lobes(&document, &file, &mut findings);
    let faults = fault_file::read_all(&file.faults, &document, machine.as_ref(), &mut findings);
    let nc = file.nc.read(&document).map_err(|errors| findings.extend(errors)).ok();
    let Some((machine, nc)) = machine.zip(nc).filter(|_| findings.is_empty()) else { return Err(findings) };
    let program = file.program.as_deref().map(|name| program_file::read(name, &document, &nc, &mut files));
    let program = program.transpose().map_err(one)?;
    let mut spec = spec(&file, profiles, lobes, file.blocks_per_turn.or(blocks).unwrap_or(FORMULA_BLOCKS));
    limits::too_long(least_cut_s(&spec))
        .map_or(Ok(()), |message| Err(one(document.error("work_speed_rpm", message))))?;
    let lobe_order = (file.lobe_order == LobeOrderFile::Fastest).then(|| fastest_order(&spec, &machine.description));
    if let Some(order) = &lobe_order {
        spec.lobes = order.lobes.iter().map(|lobe| spec.lobes[*lobe].clone()).collect();
    }
    let start = file.start_at.as_ref().map(|start| start.index(&document, &spec.lobes)).transpose();
    let start = start.map_err(one)?.flatten();
    if let Some(start) = start {
        spec.begin_with(start);
    }
    let (hash, files) = files.finish();
    Ok(Job {
        spec,
        starts_in_the_middle: start.is_some(),
        lobe_order,
        title: file.title,
        source: document.text.clone(),
        hash,
        files,
        lifts,
        gauges: file.profiles.iter().map(ProfileFile::gauge).collect(),
        machine,
        faults,
        wheel_radius_mm: file.wheel_radius_mm,
        nc,
        program,
        document,
    })
}

/// Time that all cuts take at least: every turn at the largest speed that its pass allows (s).
fn least_cut_s(spec: &JobSpec) -> f64 {
    let pass_s = |pass: &PassSpec| {
        let infeed_turns = pass.total_infeed_mm / (f64::from(spec.blocks_per_turn) * pass.infeed_per_block_mm);
        (infeed_turns + f64::from(pass.spark_out_turns)) * TURN_RAD / pass.speed.most_rad_s()
    };
    let lobes = spec.lobes.len() as f64;
    lobes * spec.passes.iter().map(pass_s).sum::<f64>()
}

fn one(error: ConfigError) -> Vec<ConfigError> {
    vec![error]
}

fn spec(file: &JobFile, profiles: Vec<ProfileSpec>, lobes: Vec<LobeSpec>, blocks_per_turn: u32) -> JobSpec {
    JobSpec {
        name: file.name.clone(),
        profiles,
        lobes,
        blocks_per_turn,
        rapid_advance_mm: file.rapid_advance_mm,
        rapid_speed_mm_s: file.rapid_speed_mm_s,
        stock_mm: file.stock_mm,
        passes: passes(&file.roughing, &file.infeed, file.work_speed_rpm, &file.speed),
        retract_clearance_mm: file.retract_clearance_mm,
        hold_in_cut: match file.hold_in_cut {
            HoldFile::Retract => HoldInCut::Retract,
            HoldFile::StopInfeed => HoldInCut::StopInfeed,
        },
        wheel_power: file.wheel_power.as_ref().map(WheelPowerFile::spec),
        c_between_lobes: match file.c_between_lobes {
            BetweenLobesFile::Stops => BetweenLobes::Stops,
            BetweenLobesFile::TurnsOn => BetweenLobes::TurnsOn { margin_s: file.arrival_margin_ms / 1e3 },
        },
        rotary_indexing: file.rotary_indexing,
        home: HomePosition { x_mm: file.home.x_mm, z_mm: file.home.z_mm },
        dressing: file.dressing.as_ref().map(DressingFile::spec),
        obstacles: file.obstacles.iter().map(ObstacleFile::spec).collect(),
        clearance_mm: file.clearance_mm,
        raw_part: file.raw_part.part(),
        correction: file.runout_correction.as_ref().map(CorrectionFile::spec),
        compensation: file.form_compensation.as_ref().map(CompensationFile::compensation),
        identification: file.identification.as_ref().map(IdentificationFile::spec),
        dry_run_mm: file.dry_run.map(|dry_run| dry_run.stand_off_mm),
        part_phase_rad: rad_from_deg(file.part_phase_deg),
        measure_stock: file.measure_stock.as_ref().map(StockFile::spec),
        wheels: wishes(
            (file.lobes.iter().map(|lobe| ("lobe", lobe.name.as_str(), lobe.wheel_radius_mm)))
                .chain(file.roughing.iter().map(|rough| ("pass", rough.name(), rough.wheel_radius_mm()))),
        ),
    }
}

/// What can be said about single values, in the words and units of the file.
fn ranges(document: &Document, file: &JobFile) -> Vec<ConfigError> {
    // Of lists that are too long nothing more is said: names are compared each with each.
    let lists = [
        ("profiles", file.profiles.len()),
        ("lobes", file.lobes.len()),
        ("roughing", file.roughing.len()),
        ("obstacles", file.obstacles.len()),
        ("faults", file.faults.len()),
    ];
    let mut findings: Vec<ConfigError> =
        limits::long_lists(lists).into_iter().map(|(key, message)| document.error(&key, message)).collect();
    if !findings.is_empty() {
        return findings;
    }
    let mut refuse = |key: &str, message: String| findings.push(document.error(key, message));
    if let Some(message) = names::fault("job", &file.name) {
        refuse("name", message);
    }
    let positive = [
        ("stock_mm", file.stock_mm),
        ("rapid_advance_mm", file.rapid_advance_mm),
        ("rapid_speed_mm_s", file.rapid_speed_mm_s),
        ("infeed.total_mm", file.infeed.total_mm),
        ("infeed.per_block_um", file.infeed.per_block_um),
        ("work_speed_rpm", file.work_speed_rpm),
        ("retract_clearance_mm", file.retract_clearance_mm),
    ];
    let given = file.wheel_radius_mm.map(|radius| ("wheel_radius_mm", radius)).into_iter();
    let given = given.chain(file.dry_run.map(|dry_run| ("dry_run.stand_off_mm", dry_run.stand_off_mm)));
    for (key, value) in positive.into_iter().chain(given).chain(file.speed.settings()) {
        if !(value.is_finite() && value > 0.0) {
            refuse(key, format!("{key} is {value}; it must be a positive number"));
        }
    }
    if let Some(blocks) = file.blocks_per_turn.filter(|blocks| !(LEAST_BLOCKS..=MOST_BLOCKS).contains(blocks)) {
        let message = format!("blocks_per_turn is {blocks}; it must be {LEAST_BLOCKS} to {MOST_BLOCKS}");
        refuse("blocks_per_turn", message);
    }
    if !(0.0..=1000.0).contains(&file.arrival_margin_ms) {
        let value = file.arrival_margin_ms;
        refuse("arrival_margin_ms", format!("arrival_margin_ms is {value}; it must be 0 to 1000"));
    }
    for (key, value) in [("home.x_mm", file.home.x_mm), ("home.z_mm", file.home.z_mm)] {
        if !value.is_finite() {
            refuse(key, format!("{key} is {value}; it must be a finite number"));
        }
    }
    if !(-360.0..=360.0).contains(&file.part_phase_deg) {
        let value = file.part_phase_deg;
        refuse("part_phase_deg", format!("part_phase_deg is {value}; it must be -360 to 360"));
    }
    if file.infeed.spark_out_turns == 0 {
        let message = "infeed.spark_out_turns is 0; at least 1 is needed to remove the step that the infeed leaves";
        refuse("infeed.spark_out_turns", message.into());
    }
    if file.infeed.spark_out_turns > MAX_SPARK_OUT_TURNS {
        let turns = file.infeed.spark_out_turns;
        let message = format!("infeed.spark_out_turns is {turns}; at most {MAX_SPARK_OUT_TURNS} are allowed");
        refuse("infeed.spark_out_turns", message);
    }
    for (key, message) in roughing_findings(&file.roughing) {
        refuse(&key, message);
    }
    for (key, message) in profile_file::findings("profiles", &file.profiles) {
        refuse(&key, message);
    }
    if file.lobes.is_empty() {
        refuse("lobes", "the job has no lobes; it needs at least 1".into());
    }
    for (index, lobe) in file.lobes.iter().enumerate() {
        let name = &lobe.name;
        if let Some(message) = names::fault("lobe", name) {
            refuse(&format!("lobes.{index}.name"), message);
        }
        if !lobe.phase_deg.is_finite() {
            let message = format!("lobe {name}: phase_deg is {}; it must be a finite number", lobe.phase_deg);
            refuse(&format!("lobes.{index}.phase_deg"), message);
        }
        if !(lobe.width_mm.is_finite() && lobe.width_mm > 0.0) {
            let message = format!("lobe {name}: width_mm is {}; it must be a positive number", lobe.width_mm);
            refuse(&format!("lobes.{index}.width_mm"), message);
        }
    }
    findings
}

fn read_lobes(document: &Document, file: &JobFile, findings: &mut Vec<ConfigError>) -> Vec<LobeSpec> {
    let known = || file.profiles.iter().map(|profile| profile.name.as_str()).collect::<Vec<_>>().join(", ");
    let mut lobes = Vec::new();
    for (index, lobe) in file.lobes.iter().enumerate() {
        let Some(profile) = file.profiles.iter().position(|profile| profile.name == lobe.profile) else {
            let message = format!("lobe {}: there is no profile {}; the job has {}", lobe.name, lobe.profile, known());
            findings.push(document.error(&format!("lobes.{index}.profile"), message));
            continue;
        };
        lobes.push(LobeSpec {
            name: lobe.name.clone(),
            station: lobe.station.clone(),
            phase_rad: rad_from_deg(lobe.phase_deg + file.part_phase_deg),
            profile,
            width_mm: lobe.width_mm,
        });
    }
    lobes
}

#[cfg(test)]
mod tests;
