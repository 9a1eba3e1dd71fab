//! Job files: what is written, and the job it means.

use super::lift_file::{self, AngleUnit};
use super::locate::{Located, locate};
use super::machine_file::{self, Machine};
use super::yaml::Document;
use super::{ConfigError, Place};
use camwright::follower::Follower;
use camwright::job::{HomePosition, JobSpec, LobeSpec, PassSpec, ProfileSpec, SpeedLaw};
use camwright::lift::LiftLaw;
use camwright::units::{rad_from_deg, rad_s_from_rpm};
use serde::Deserialize;
use sha2::{Digest, Sha256};
use std::path::PathBuf;

/// Newest version of the job file's schema that this program reads.
pub const SCHEMA_VERSION: u32 = 1;

/// Blocks per turn of a lift that comes from a formula: 0.1°, as on the tape of JPS6156064B2.
const FORMULA_BLOCKS: u32 = 3600;

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
    work_speed_rpm: f64,
    #[serde(default = "default_retract")]
    retract_clearance_mm: f64,
    #[serde(default)]
    rotary_indexing: bool,
    home: HomeFile,
}

fn default_retract() -> f64 {
    2.0
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ProfileFile {
    name: String,
    base_radius_mm: f64,
    follower: FollowerFile,
    lift: LiftFile,
}

#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
enum FollowerFile {
    Knife {
        #[serde(default)]
        offset_mm: f64,
    },
    Roller {
        radius_mm: f64,
        #[serde(default)]
        offset_mm: f64,
    },
    Flat {},
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LiftFile {
    table: Option<String>,
    #[serde(default)]
    angle: AngleUnit,
    resolution_mm: Option<f64>,
    eccentric: Option<EccentricFile>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct EccentricFile {
    eccentricity_mm: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LobeFile {
    name: String,
    station: String,
    profile: String,
    phase_deg: f64,
    width_mm: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct InfeedFile {
    total_mm: f64,
    per_block_um: f64,
    spark_out_turns: u32,
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
    /// One line about it.
    pub title: String,
    /// What the job file says, with overrides written in.
    pub source: String,
    /// SHA-256 over the job file and every table it names, 64 hexadecimal digits.
    pub hash: String,
    /// The machine it is for.
    pub machine: Machine,
    /// Radius of the wheel it was written for, if it says so (mm).
    pub wheel_radius_mm: Option<f64>,
    /// The job file, for messages that point into it.
    pub document: Document,
}

/// Finds, reads and understands a job with `key=value` overrides.
///
/// # Errors
/// Anything that is not a job: a file that is missing, unknown keys, values out of range, tables that are refused.
pub fn load(name: &str, overrides: &[String]) -> Result<Job, ConfigError> {
    parse(&locate("jobs", name, "yaml", None)?, overrides)
}

/// Understands a job that has been read.
///
/// # Errors
/// See [`load`].
pub fn parse(located: &Located, overrides: &[String]) -> Result<Job, ConfigError> {
    let document = Document::parse(&located.path, &located.text, overrides)?;
    document.require_schema("job", SCHEMA_VERSION)?;
    let file: JobFile = document.read()?;
    let machine_located = locate("machines", &file.machine, "yaml", Some(&located.path))
        .map_err(|error| document.error("machine", error.to_string()))?;
    let machine = machine_file::parse(&machine_located.path, &machine_located.text, &[])?;
    let mut hasher = Sha256::new();
    hasher.update(document.text.as_bytes());
    let mut profiles = Vec::new();
    let mut blocks = None;
    for (index, profile) in file.profiles.iter().enumerate() {
        let (spec, table_blocks) = read_profile(&document, index, profile, &located.path, &mut hasher)?;
        let table_blocks = table_blocks.or(blocks).unwrap_or(FORMULA_BLOCKS);
        if let Some(previous) = blocks.filter(|previous| *previous != table_blocks) {
            let message = format!("profile {} has {table_blocks} blocks per turn, the one before {previous}", profile.name);
            return Err(document.error(&format!("profiles.{index}.lift"), message));
        }
        blocks = Some(table_blocks);
        profiles.push(spec);
    }
    let spec = JobSpec {
        name: file.name.clone(),
        lobes: read_lobes(&document, &file)?,
        profiles,
        blocks_per_turn: blocks.unwrap_or(FORMULA_BLOCKS),
        rapid_advance_mm: file.rapid_advance_mm,
        rapid_speed_mm_s: file.rapid_speed_mm_s,
        stock_mm: file.stock_mm,
        passes: vec![PassSpec {
            name: "grind".into(),
            total_infeed_mm: file.infeed.total_mm,
            infeed_per_block_mm: file.infeed.per_block_um * 1e-3,
            spark_out_turns: file.infeed.spark_out_turns,
            speed: SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: rad_s_from_rpm(file.work_speed_rpm) },
        }],
        retract_clearance_mm: file.retract_clearance_mm,
        rotary_indexing: file.rotary_indexing,
        home: HomePosition { x_mm: file.home.x_mm, z_mm: file.home.z_mm },
    };
    let hash = hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    Ok(Job {
        spec,
        title: file.title,
        source: document.text.clone(),
        hash,
        machine,
        wheel_radius_mm: file.wheel_radius_mm,
        document,
    })
}

fn read_profile(
    document: &Document,
    index: usize,
    file: &ProfileFile,
    job_path: &std::path::Path,
    hasher: &mut Sha256,
) -> Result<(ProfileSpec, Option<u32>), ConfigError> {
    let key = |name: &str| format!("profiles.{index}.{name}");
    let follower = match file.follower {
        FollowerFile::Knife { offset_mm } => Follower::KnifeEdge { offset_mm },
        FollowerFile::Roller { radius_mm, offset_mm } => Follower::Roller { radius_mm, offset_mm },
        FollowerFile::Flat {} => Follower::Flat,
    };
    let (lift, blocks) = match (&file.lift.table, &file.lift.eccentric) {
        (Some(table), None) => {
            let located = locate("lifts", table, "csv", Some(job_path))
                .map_err(|error| document.error(&key("lift.table"), error.to_string()))?;
            hasher.update(located.text.as_bytes());
            let table = lift_file::parse(&located, file.lift.angle, file.lift.resolution_mm)?;
            let blocks = table.blocks();
            let law = LiftLaw::from_table(&table)
                .map_err(|error| ConfigError::at(Place::file(&located.path), error.to_string()))?;
            (law, Some(blocks))
        }
        (None, Some(eccentric)) => {
            let law = LiftLaw::eccentric(eccentric.eccentricity_mm)
                .map_err(|error| document.error(&key("lift.eccentric"), error.to_string()))?;
            (law, None)
        }
        _ => {
            let message = format!("profile {}: lift needs exactly one of: table, eccentric", file.name);
            return Err(document.error(&key("lift"), message));
        }
    };
    Ok((ProfileSpec { name: file.name.clone(), lift, follower, base_radius_mm: file.base_radius_mm }, blocks))
}

fn read_lobes(document: &Document, file: &JobFile) -> Result<Vec<LobeSpec>, ConfigError> {
    let known = || file.profiles.iter().map(|profile| profile.name.as_str()).collect::<Vec<_>>().join(", ");
    file.lobes
        .iter()
        .enumerate()
        .map(|(index, lobe)| {
            let profile = file.profiles.iter().position(|profile| profile.name == lobe.profile).ok_or_else(|| {
                let message = format!("lobe {}: there is no profile {}; the job has {}", lobe.name, lobe.profile, known());
                document.error(&format!("lobes.{index}.profile"), message)
            })?;
            Ok(LobeSpec {
                name: lobe.name.clone(),
                station: lobe.station.clone(),
                phase_rad: rad_from_deg(lobe.phase_deg),
                profile,
                width_mm: lobe.width_mm,
            })
        })
        .collect()
}

/// Names, titles and paths of the jobs that [`load`] finds by name.
#[must_use]
pub fn list() -> Vec<(String, String, PathBuf)> {
    super::locate::list("jobs")
        .into_iter()
        .filter_map(|name| {
            let located = locate("jobs", &name, "yaml", None).ok()?;
            let document = Document::parse(&located.path, &located.text, &[]).ok()?;
            let title = match document.root.get("title").map(|node| &node.value) {
                Some(super::yaml::Value::Text(title)) => title.clone(),
                _ => String::new(),
            };
            Some((name, title, located.path))
        })
        .collect()
}
