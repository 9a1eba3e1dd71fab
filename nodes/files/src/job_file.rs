// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Job files: what is written, and the job it means.

use super::ConfigError;
use super::compensation_file::CompensationFile;
use super::fault_file::{self, FaultFile, JobFault};
use super::form_tolerance_file::FormToleranceFile;
use super::job_files::JobFiles;
use super::journal_file::{CorrectionFile, IdentificationFile, RawPartFile, StockFile};
use super::lift_file::ProfileLift;
use super::limits;
use super::locate::{Located, locate};
use super::machine_file::{self, MachineConfig};
use super::names;
use super::nc_file::{NcFile, NcSettings};
use super::pass_file::{self, InfeedFile, RoughingFile, SpeedFile, SpeedVariationFile};
use super::profile_file::{self, ProfileFile};
use super::program_file::{self, JobProgram};
use super::pulse_file::{PulseSettings, PulsesFile};
use super::recorded_files::NamedFile;
use super::schema;
use super::start_file::{DryRunFile, StartLobeFile};
use super::wheel_file::{DressingFile, ObstacleFile, WheelPowerFile, wishes};
use super::workholding_file::PartSupportFile;
use super::yaml::Document;
use camwright::cam::follower::Follower;
use camwright::job::grinding::{
    BetweenLobes, HoldInCut, HomePosition, JobError, JobSpec, LobeSpec, MIN_BLOCKS, PassSpec, ProfileSpec, Subject,
};
use camwright::job::wheel_visit::MAX_WHEEL_APPROACH_MM;
use camwright::machine::axial_profile::AxialProfile;
use camwright::math::units::{TURN_RAD, mm_from_um, rad_from_deg};
use camwright::planner::{LobeOrder, fastest_order};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Newest version of the job file's schema that this program reads.
pub const SCHEMA_VERSION: u32 = 1;

/// Blocks per turn of a lift that comes from a formula: 0.1°, as on the tape of JPS6156064B2.
pub const FORMULA_BLOCKS: u32 = 3600;

/// Maximum blocks of a turn, as of a table.
const MAX_BLOCKS: u32 = 36_000;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct JobFile {
    /// Kind and version of the file.
    #[schemars(extend("const" = "camwright/job/1"))]
    #[serde(rename = "schema")]
    _schema: String,
    /// Name of the job, also of its output files.
    #[schemars(schema_with = "names::schema")]
    name: String,
    /// One line about the job.
    #[serde(default)]
    title: String,
    /// Machine file that the job is for, by name or path.
    machine: String,
    /// Radius of the wheel that the job is made for; a run with another wheel is refused. Default: the mounted
    /// wheel.
    #[schemars(range(min = 1e-6, max = 1e4))]
    wheel_radius_mm: Option<f64>,
    /// Name of the wheel of the machine's changer for every lobe and pass that names none. Default: the first wheel of the changer
    /// if a lobe or pass names one, otherwise the mounted wheel.
    wheel: Option<String>,
    /// Part of the infeed that a wheel mounted after another one on a lobe feeds in air, before it meets what that one left.
    #[serde(default = "default_wheel_approach_mm")]
    #[schemars(range(min = 1e-6, max = MAX_WHEEL_APPROACH_MM))]
    wheel_approach_mm: f64,
    /// Shapes of the lobes.
    #[schemars(length(min = 1, max = 100))]
    profiles: Vec<ProfileFile>,
    /// Lobes of the part.
    #[schemars(length(min = 1, max = 100))]
    lobes: Vec<LobeFile>,
    /// Allowed form error of the lobes. A part with a larger error is not good.
    #[serde(default)]
    form_tolerance: FormToleranceFile,
    /// Material of the blank above the contour, along its normal.
    #[schemars(range(min = 1e-6, max = 1e4))]
    stock_mm: f64,
    /// R0 (DS0), rapid advance of X from the clear position to the start of the infeed.
    #[schemars(range(min = 1e-6, max = 1e4))]
    rapid_advance_mm: f64,
    /// F0 (DS2), speed of the rapid advance.
    #[schemars(range(min = 0.01, max = 1e5))]
    rapid_speed_mm_s: f64,
    /// Infeed of the last pass.
    infeed: InfeedFile,
    /// N, blocks of a turn: the unit angle of `infeed.per_block_um` is 360/N deg. Default: that of the tables,
    /// 3600 without a table. Required where the tables of a job differ.
    #[schemars(range(min = MIN_BLOCKS, max = MAX_BLOCKS))]
    blocks_per_turn: Option<u32>,
    /// Speed of the headstock in the cut; the maximum speed with a `speed.law` other than `constant_work_speed`.
    #[schemars(range(min = 0.01, max = 95000.0))]
    work_speed_rpm: f64,
    /// Law of the headstock's speed over the lobe.
    #[serde(default)]
    speed: SpeedFile,
    /// Passes before the last one, in order. The infeed of a pass ends where that of the next one begins.
    #[schemars(length(max = 15))]
    #[serde(default)]
    roughing: Vec<RoughingFile>,
    /// Distance by which a hold or a cancel retracts the wheel from the part.
    #[schemars(range(min = 1e-6, max = 1e4))]
    #[serde(default = "default_retract")]
    retract_clearance_mm: f64,
    /// Reaction to a hold in the cut; C keeps turning. A cancel always retracts.
    #[serde(default)]
    hold_in_cut: HoldFile,
    /// Varies the work speed from turn to turn in all passes, against chatter (`camwright chatter`). Refused with `program` and by
    /// `camwright post`; `pulses` have the speed of the pass. Default: no variation.
    speed_variation: Option<SpeedVariationFile>,
    /// Limit of the spindle power for every pass. Default: no limit.
    wheel_power: Option<WheelPowerFile>,
    /// Motion of C between two lobes.
    #[serde(default)]
    c_between_lobes: BetweenLobesFile,
    /// With `c_between_lobes: turns_on`: time by which the table may arrive late without losing a turn.
    #[schemars(range(min = 0.0, max = 1000.0))]
    #[serde(default = "default_arrival_margin")]
    arrival_margin_ms: f64,
    /// Turns C to the base-circle centre of each lobe before its cut, as conventional machines do.
    #[serde(default)]
    rotary_indexing: bool,
    /// Order in which the lobes are ground.
    #[serde(default)]
    lobe_order: LobeOrderFile,
    /// Position of the axes before and after the part. The wheel travels to the dresser by `home.x_mm`.
    home: HomeFile,
    /// Rules for dressing the wheel. Default: the job never dresses.
    dressing: Option<DressingFile>,
    /// Shoulders and journals of the part that the wheel must not touch.
    #[schemars(length(max = 100))]
    #[serde(default)]
    obstacles: Vec<ObstacleFile>,
    /// Minimum distance of the wheel from lobes it does not grind, obstacles, headstock, tailstock and dresser.
    /// The table moves only with X at least this far out.
    #[schemars(range(min = 0.0, max = 1e4))]
    #[serde(default = "default_clearance")]
    clearance_mm: f64,
    /// Faults that the simulated machine injects into the job.
    #[schemars(length(max = 100))]
    #[serde(default)]
    faults: Vec<FaultFile>,
    /// Errors of the raw part that only the simulated machine knows.
    #[serde(default)]
    raw_part: RawPartFile,
    /// The part as a round shaft on the supports of the machine (`workholding`), which deflects with its lobes. Default:
    /// the part is as stiff as the machine's `contact` says.
    part_support: Option<PartSupportFile>,
    /// Measures the runout of the journals with the machine's gauge and corrects it in one turn each; `{}`
    /// selects the defaults. All lobes must be round. Default: no correction.
    runout_correction: Option<CorrectionFile>,
    /// Corrects each part by the form error measured on the part before; `{}` selects the defaults. Not with
    /// `runout_correction`. Default: no compensation.
    form_compensation: Option<CompensationFile>,
    /// Name or number (from 1) of the lobe to begin with on the part in the machine; 0 begins with a new part.
    /// Default: 0.
    start_at: Option<StartLobeFile>,
    /// Measures the stiffness of machine and cut on every journal before its correction; `{}` selects the
    /// defaults. Needs `runout_correction`. Default: no measurement.
    identification: Option<IdentificationFile>,
    /// Makes the job a dry run away from the part. Default: the job grinds.
    dry_run: Option<DryRunFile>,
    /// Azimuth of the keyway as it was found; added to the phase of every lobe.
    #[schemars(range(min = -360.0, max = 360.0))]
    #[serde(default)]
    part_phase_deg: f64,
    /// Measures the stock of every journal before the cut and leaves out infeed in air; `{}` selects the
    /// defaults. Needs a gauge and round lobes; not with `c_between_lobes: turns_on` or `rotary_indexing`.
    /// Default: no measurement.
    measure_stock: Option<StockFile>,
    /// Settings of the NC program that `camwright post` makes of the job.
    #[serde(default)]
    nc: NcFile,
    /// Pulses of C and X that `camwright plan` counts in `pulses.csv`, for a control that moves its axes by number and frequency of pulses.
    /// Default: no such file.
    pulses: Option<PulsesFile>,
    /// NC program that drives the part instead of the job's own cuts, for the control `nc.control`. Default: the
    /// job's own cuts.
    program: Option<String>,
}

/// In which order the lobes are machined.
#[derive(Debug, Default, Clone, Copy, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum LobeOrderFile {
    #[default]
    /// The order of `lobes`.
    AsWritten,
    /// The order with the shortest travel time of the table.
    Fastest,
}

/// Effect of a hold in the cut.
#[derive(Debug, Default, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum HoldFile {
    #[default]
    /// Retracts the wheel from the part.
    Retract,
    /// Stops the infeed only.
    StopInfeed,
}

/// Motion of C between two lobes.
#[derive(Debug, Default, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum BetweenLobesFile {
    #[default]
    /// Grinds every lobe from rest to rest.
    Stops,
    /// C keeps turning; the next cut begins at the phase with which C is predicted to arrive.
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

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct LobeFile {
    /// Name of the lobe.
    #[schemars(schema_with = "names::schema")]
    name: String,
    /// Limit switch of the machine at which the lobe stands.
    station: String,
    /// Name of its profile.
    profile: String,
    /// Phase angle: from the keyway to the centre of the base circle, positive in the direction in which the table is
    /// read. Instead of `alpha_deg`.
    #[schemars(range(min = -36000.0, max = 36000.0))]
    phase_deg: Option<f64>,
    /// Phase angle with the sign of JPS6156064B2 (DS4 ...): positive against the direction in which the table is read.
    /// Instead of `phase_deg`.
    #[schemars(range(min = -36000.0, max = 36000.0))]
    alpha_deg: Option<f64>,
    /// Width of the lobe.
    #[schemars(range(min = 1e-6, max = 1e4))]
    width_mm: f64,
    /// Minimum overlap of the plunges that grind a lobe wider than the wheel, side by side; at most a third of the
    /// wheel's width. Without effect on a lobe that the wheel covers. Default: a wider lobe is refused.
    #[schemars(range(min = 1e-6, max = 1e4))]
    plunge_overlap_mm: Option<f64>,
    /// Taper of the lobe: radius at the end towards the tailstock minus that at the other end. The rim of the wheel must have the opposite
    /// taper (`wheel.rim` of the machine).
    #[schemars(range(min = -500.0, max = 500.0))]
    #[serde(default)]
    taper_um: f64,
    /// Crown of the lobe: radius in the middle minus the mean of both ends, of a parabola. The rim of the wheel must have the opposite crown.
    #[schemars(range(min = -500.0, max = 500.0))]
    #[serde(default)]
    crown_um: f64,
    /// Radius of the wheel that the lobe needs. Default: the job's.
    #[schemars(range(min = 1e-6, max = 1e4))]
    wheel_radius_mm: Option<f64>,
    /// Name of the wheel of the machine's changer that grinds all passes of the lobe. Default: the wheels of the passes.
    wheel: Option<String>,
    /// Allowed form error of this lobe. Default: the job's.
    form_tolerance: Option<FormToleranceFile>,
}

const fn default_wheel_approach_mm() -> f64 {
    0.02
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct HomeFile {
    /// Home position of X.
    #[schemars(range(min = -1e4, max = 1e4))]
    x_mm: f64,
    /// Home position of Z.
    #[schemars(range(min = -1e4, max = 1e4))]
    z_mm: f64,
}

/// A job as its files describe it.
#[derive(Debug, Clone)]
pub struct Job {
    /// Job that the files describe.
    pub spec: JobSpec,
    /// The order of its lobes, where it was sought.
    pub lobe_order: Option<LobeOrder>,
    /// One line about it.
    pub title: String,
    /// Text of the job file, with overrides applied.
    pub source: String,
    /// SHA-256 over the job file and every table it names, 64 hexadecimal digits.
    pub hash: String,
    /// The files that it names.
    pub files: Arc<[NamedFile]>,
    /// Lift of each profile: its law, the table it was read from, and what is to be said about that.
    pub lifts: Vec<ProfileLift>,
    /// Inspection follower of each profile, if the job has one.
    pub gauges: Vec<Option<Follower>>,
    /// The machine it is for.
    pub machine: MachineConfig,
    /// It begins with a lobe in its middle: the part in the machine stays as it is, and the lobes before are not in `spec`.
    pub starts_in_the_middle: bool,
    /// Faults that strike in it.
    pub faults: Vec<JobFault>,
    /// Radius of the wheel it was written for, if it says so (mm).
    pub wheel_radius_mm: Option<f64>,
    /// Settings of the NC program.
    pub nc: NcSettings,
    /// Pulses to be counted.
    pub pulses: Option<PulseSettings>,
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
/// refused. What needs the result of a failed step is omitted.
pub fn read(located: &Located, overrides: &[String]) -> Result<Job, Vec<ConfigError>> {
    let document = Document::with_overrides(located, overrides).map_err(one)?;
    document.require_schema("job", SCHEMA_VERSION).map_err(one)?;
    let file: JobFile = schema::read(&document)?;
    let mut findings = file.raw_part.findings(&document);
    findings.extend(file.runout_correction.iter().flat_map(|correction| correction.findings(&document)));
    let of_passes = pass_file::findings(&file.roughing, &file.infeed);
    for (key, message) in profile_file::findings("profiles", &file.profiles).into_iter().chain(of_passes) {
        findings.push(document.error(&key, message));
    }
    let machine = machine_file::named(&document, &file.machine).map_err(|errors| findings.extend(errors)).ok();
    let mut files = JobFiles::from_document(&document);
    let (mut profiles, mut lifts) = (Vec::new(), Vec::new());
    let mut blocks: Option<u32> = None;
    for (index, profile) in file.profiles.iter().enumerate() {
        match profile.read(&document, ("profiles", index), &profiles, &mut files) {
            Ok((spec, lift)) => {
                let table_blocks = lift.table.as_ref().and_then(|table| u32::try_from(table.blocks()).ok());
                match (blocks, table_blocks) {
                    (Some(first), Some(other)) if first != other && file.blocks_per_turn.is_none() => {
                        findings.push(document.error(
                            &format!("profiles.{index}.lift"),
                            format!(
                                "profile {}: {other} blocks per turn, the first table has {first}; if tables differ, set blocks_per_turn, which infeed.per_block_um uses",
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
    let nc = file.nc.settings(&document).map_err(|error| findings.push(error)).ok();
    let Some((machine, nc)) = machine.zip(nc).filter(|_| findings.is_empty()) else { return Err(findings) };
    let program = file.program.as_deref().map(|name| program_file::read(name, &document, &nc, &mut files));
    let program = program.transpose().map_err(one)?;
    let mut spec = spec(&file, profiles, lobes, file.blocks_per_turn.or(blocks).unwrap_or(FORMULA_BLOCKS));
    let lobe_order = (file.lobe_order == LobeOrderFile::Fastest).then(|| fastest_order(&spec, &machine.description));
    if let Some(order) = &lobe_order {
        spec.lobes = order.lobes.iter().map(|lobe| spec.lobes[*lobe].clone()).collect();
    }
    let wheels = job_wheels::of_passes(&file, &machine.description, &document)?;
    let last_wheel = |lobe: &LobeSpec| {
        let wheel = wheels.iter().find(|(name, _)| *name == lobe.name).and_then(|(_, wheels)| wheels.last());
        wheel.map_or(machine.description.wheel, |wheel| machine.description.wheel_at(*wheel))
    };
    for lobe in &mut spec.lobes {
        // A rim with a profile gives every lobe a shape.
        if lobe.axial.is_none() && !last_wheel(lobe).rim.is_straight() {
            lobe.axial = Some(AxialProfile::default());
        }
    }
    let wheel_mm = |lobe: &LobeSpec| last_wheel(lobe).width_mm;
    spec.lobes = side_by_side(&file.lobes, spec.lobes, wheel_mm, &document).map_err(one)?;
    job_wheels::visit(&mut spec, &wheels, file.wheel_approach_mm, &document).map_err(one)?;
    limits::too_long(minimum_cut_s(&spec))
        .map_or(Ok(()), |message| Err(one(document.error("work_speed_rpm", message))))?;
    let start = file.start_at.as_ref().map(|start| start.index(&document, &spec.lobes)).transpose();
    let start = start.map_err(one)?.flatten();
    if let Some(start) = start {
        spec.begin_with(start);
    }
    let pulses = file.pulses.map(|pulses| pulses.settings(&document, spec.blocks_per_turn, turns(&spec)));
    let pulses = pulses.transpose().map_err(one)?;
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
        pulses,
        program,
        document,
    })
}

/// Lobes with the plunges of a wide lobe in its place, for wheels of these widths (mm).
fn side_by_side(
    files: &[LobeFile],
    lobes: Vec<LobeSpec>,
    wheel_mm: impl Fn(&LobeSpec) -> f64,
    document: &Document,
) -> Result<Vec<LobeSpec>, ConfigError> {
    let mut plunges = Vec::new();
    for lobe in lobes {
        let overlap_mm = files.iter().find(|file| file.name == lobe.name).and_then(|file| file.plunge_overlap_mm);
        let Some(overlap_mm) = overlap_mm else {
            plunges.push(lobe);
            continue;
        };
        let name = lobe.name.clone();
        let key = |error: &JobError| match error {
            JobError::PlungeOverlap { .. } => "plunge_overlap_mm",
            _ => "width_mm",
        };
        let wheel_mm = wheel_mm(&lobe);
        let divided = lobe.side_by_side(overlap_mm, wheel_mm);
        plunges.extend(
            divided.map_err(|error| document.error(&format!("lobes.{name}.{}", key(&error)), error.to_string()))?,
        );
    }
    Ok(plunges)
}

/// Turns of all passes on a lobe.
fn turns(spec: &JobSpec) -> f64 {
    spec.passes.iter().map(|pass| infeed_turns(pass, spec.blocks_per_turn) + f64::from(pass.spark_out_turns)).sum()
}

fn infeed_turns(pass: &PassSpec, blocks_per_turn: u32) -> f64 {
    pass.total_infeed_mm / (f64::from(blocks_per_turn) * pass.infeed_per_block_mm)
}

/// Time that all cuts take at least: every turn at the largest speed that its pass allows (s).
fn minimum_cut_s(spec: &JobSpec) -> f64 {
    let pass_s = |pass: &PassSpec| {
        (infeed_turns(pass, spec.blocks_per_turn) + f64::from(pass.spark_out_turns)) * TURN_RAD
            / pass.speed.maximum_rad_s()
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
        passes: pass_file::passes(&file.roughing, &file.infeed, file.work_speed_rpm, &file.speed, blocks_per_turn),
        retract_clearance_mm: file.retract_clearance_mm,
        hold_in_cut: match file.hold_in_cut {
            HoldFile::Retract => HoldInCut::Retract,
            HoldFile::StopInfeed => HoldInCut::StopInfeed,
        },
        speed_variation: file.speed_variation.map(SpeedVariationFile::variation),
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
        part_support: file.part_support.as_ref().map(PartSupportFile::support),
        correction: file.runout_correction.as_ref().map(CorrectionFile::spec),
        compensation: file.form_compensation.as_ref().map(CompensationFile::compensation),
        identification: file.identification.as_ref().map(IdentificationFile::spec),
        dry_run_mm: file.dry_run.map(|dry_run| dry_run.stand_off_mm),
        part_phase_rad: rad_from_deg(file.part_phase_deg),
        measure_stock: file.measure_stock.as_ref().map(StockFile::spec),
        wheels: wishes((file.lobes.iter().map(|lobe| (Subject::Lobe(lobe.name.clone()), lobe.wheel_radius_mm))).chain(
            file.roughing.iter().map(|rough| (Subject::Pass(rough.name().to_owned()), rough.wheel_radius_mm())),
        )),
    }
}

/// Taper and crown of a lobe; `None`: it has neither.
fn axial_profile(lobe: &LobeFile) -> Option<AxialProfile> {
    let axial = AxialProfile { taper_mm: mm_from_um(lobe.taper_um), crown_mm: mm_from_um(lobe.crown_um) };
    Some(axial).filter(|axial| !axial.is_straight())
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
        let phase_deg = match (lobe.phase_deg, lobe.alpha_deg) {
            (Some(phase_deg), None) => phase_deg,
            (None, Some(alpha_deg)) => -alpha_deg,
            (phase_deg, _) => {
                let fault = if phase_deg.is_some() { "both are given; remove one" } else { "one is needed" };
                let message = format!("lobe {}: phase_deg or alpha_deg, its negative: {fault}", lobe.name);
                findings.push(document.error(&format!("lobes.{index}"), message));
                continue;
            }
        };
        lobes.push(LobeSpec {
            name: lobe.name.clone(),
            station: lobe.station.clone(),
            phase_rad: rad_from_deg(phase_deg + file.part_phase_deg),
            profile,
            width_mm: lobe.width_mm,
            tolerance: lobe.form_tolerance.unwrap_or(file.form_tolerance).tolerance(),
            plunge: None,
            visit: None,
            axial: axial_profile(lobe),
        });
    }
    lobes
}

mod job_wheels;
#[cfg(test)]
mod tests;
