// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Files of jobs that turn: what is written, and the job it means.

use super::ConfigError;
use super::fault_file::{self, FaultFile, JobFault};
use super::job_files::JobFiles;
use super::lift_file::ProfileLift;
use super::locate::{Located, locate};
use super::machine_file::{self, MachineConfig};
use super::names;
use super::nc_file::{NcFile, NcSettings};
use super::program_file::{self, JobProgram};
use super::recorded_files::NamedFile;
use super::schema;
use super::surface_file::SurfaceFile;
use super::yaml::Document;
use camwright::cam::surface::Surface;
use camwright::cam::surface::mesh::MeshReading;
use camwright::job::turning::{TurningJob, TurningSpeed};
use camwright::math::units::{mm_from_um, rad_s_from_rpm};
use camwright::simulation::turned_part::{MAX_CELLS, MIN_AZIMUTHS, PartGrid};
use camwright::toolpath::insert_path::{InsertFeed, Passes};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// Newest version of the schema that this program reads.
pub const SCHEMA_VERSION: u32 = 1;

/// Angles a turn at which the path is computed: 1°, where exact derivatives leave 1e-10 mm between them.
const ANGLES: u32 = 360;

/// Azimuths of the grid on which the part is simulated.
const AZIMUTHS: usize = 720;

/// Columns of that grid within one feed: as many as show the height of a cusp to a fiftieth.
const COLUMNS_PER_FEED: f64 = 10.0;

/// Maximum azimuths of that grid.
const MAX_AZIMUTHS: usize = 7200;

/// Default form tolerance in addition to the cusps of the feed (µm).
const TOLERANCE_UM: f64 = 2.0;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TurningFile {
    /// Kind and version of the file.
    #[schemars(extend("const" = "camwright/turning_job/1"))]
    #[serde(rename = "schema")]
    _schema: String,
    /// Name of the job, also of its output files.
    #[schemars(schema_with = "names::schema")]
    name: String,
    /// One line about the job.
    #[serde(default)]
    title: String,
    /// Machine file with an `insert`, by name or path.
    machine: String,
    /// Surface of the part.
    surface: SurfaceFile,
    /// Length of the part that is turned.
    turned: TurnedFile,
    /// Radius of the bar, at least the largest radius of the part.
    #[schemars(range(min = 1e-6, max = 1e4))]
    bar_radius_mm: f64,
    /// Z of the part in front of the insert's centre with `z_axis` at 0.
    #[schemars(range(min = -1e5, max = 1e5))]
    part_zero_mm: f64,
    /// Passes before the finishing pass. Default: the finishing pass takes all stock.
    roughing: Option<TurningRoughingFile>,
    /// Last pass.
    finishing: FinishingFile,
    /// Angles of a turn at which the path is computed with exact derivatives.
    #[schemars(range(min = 180, max = 3600))]
    #[serde(default = "default_angles")]
    angles_per_turn: u32,
    /// Speed of `c_axis`.
    #[serde(default)]
    spindle: SpindleFile,
    /// Distance of the insert from the bar before and after a pass.
    #[schemars(range(min = 1e-6, max = 1e4))]
    #[serde(default = "default_clearance")]
    clearance_mm: f64,
    /// Speed of X on these travels.
    #[schemars(range(min = 0.01, max = 1e5))]
    rapid_speed_mm_s: f64,
    /// Grid of the simulated part.
    #[serde(default)]
    form_grid: FormGridFile,
    /// Allowed form error beyond the cusps of the feed.
    #[schemars(range(min = 1e-6, max = 1e6))]
    #[serde(default = "default_tolerance")]
    tolerance_um: f64,
    /// Faults that the simulated machine injects into the job.
    #[schemars(length(max = 100))]
    #[serde(default)]
    faults: Vec<FaultFile>,
    /// Settings of the NC program that `camwright post` makes of the job.
    #[serde(default)]
    nc: NcFile,
    /// NC program that drives the part instead of the job's own passes, for the control `nc.control`. Default: the
    /// job's own passes.
    program: Option<String>,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct TurnedFile {
    /// Z of the part at which turning begins.
    #[schemars(range(min = -1e5, max = 1e5))]
    from_mm: f64,
    /// Z of the part at which turning ends.
    #[schemars(range(min = -1e5, max = 1e5))]
    to_mm: f64,
}

impl TurnedFile {
    fn range_mm(self) -> (f64, f64) {
        (self.from_mm.min(self.to_mm), self.from_mm.max(self.to_mm))
    }
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct TurningRoughingFile {
    /// Stock on the section in the rake plane before the first pass. Default: all that the bar has over the
    /// part.
    #[schemars(range(min = 1e-6, max = 1e4))]
    stock_mm: Option<f64>,
    /// Stock that roughing leaves, along the section's normal in the rake plane.
    #[schemars(range(min = 0.0, max = 1000.0))]
    leaves_mm: f64,
    /// Maximum depth of a roughing pass; passes are equal.
    #[schemars(range(min = 1e-6, max = 1e4))]
    deepest_mm: f64,
    /// Feed per turn of `z_axis` at constant speed. Exactly one of both feeds.
    #[schemars(range(min = 1e-6, max = 1e4))]
    along_z_mm: Option<f64>,
    /// Feed per turn of the contact along the curve of the section. Exactly one of both feeds.
    #[schemars(range(min = 1e-6, max = 1e4))]
    along_curve_mm: Option<f64>,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct FinishingFile {
    /// Feed per turn of `z_axis` at constant speed. Exactly one of both feeds.
    #[schemars(range(min = 1e-6, max = 1e4))]
    along_z_mm: Option<f64>,
    /// Feed per turn of the contact along the curve of the section. Exactly one of both feeds.
    #[schemars(range(min = 1e-6, max = 1e4))]
    along_curve_mm: Option<f64>,
}

#[derive(Debug, Default, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct SpindleFile {
    /// Law of the speed of `c_axis`.
    #[serde(default)]
    law: SpindleLawFile,
    /// Speed for `law: constant`.
    #[schemars(range(min = 1e-3, max = 1e5))]
    rpm: Option<f64>,
}

#[derive(Debug, Default, Clone, Copy, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum SpindleLawFile {
    /// Fastest constant speed within all limits.
    #[default]
    Fastest,
    /// Constant speed `rpm`.
    Constant,
    /// The fastest speed within all limits at every angle.
    Varied,
}

#[derive(Debug, Default, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct FormGridFile {
    /// Azimuths of the simulated part. Default: 720.
    #[schemars(range(min = MIN_AZIMUTHS, max = MAX_AZIMUTHS))]
    azimuths: Option<usize>,
    /// Distance of the columns along the part. Default: a tenth of the finishing feed.
    #[schemars(range(min = 1e-6, max = 1e4))]
    column_mm: Option<f64>,
}

fn default_angles() -> u32 {
    ANGLES
}

fn default_clearance() -> f64 {
    1.0
}

fn default_tolerance() -> f64 {
    TOLERANCE_UM
}

/// A job that turns a part, as its files describe it.
#[derive(Debug, Clone)]
pub struct TurnedJob {
    /// Job that the files describe.
    pub spec: TurningJob,
    /// One line about it.
    pub title: String,
    /// Text of the job file, with overrides applied.
    pub source: String,
    /// SHA-256 over the job file and every file it names, 64 hexadecimal digits.
    pub hash: String,
    /// The files that it names.
    pub files: Arc<[NamedFile]>,
    /// Lifts of the profiles that its surface was made of, by their names.
    pub lifts: Vec<(String, ProfileLift)>,
    /// The file of its surface and how that was read, if it is a mesh.
    pub mesh: Option<(PathBuf, MeshReading)>,
    /// The machine it is for.
    pub machine: MachineConfig,
    /// Faults that strike in it.
    pub faults: Vec<JobFault>,
    /// Grid of the simulated part and of its form map.
    pub grid: PartGrid,
    /// Form tolerance in addition to the cusps of the feed (mm).
    pub tolerance_mm: f64,
    /// Settings of the NC program.
    pub nc: NcSettings,
    /// The NC program that turns the part, instead of the job's own passes.
    pub program: Option<JobProgram>,
    /// The job file, for messages that point into it.
    pub document: Document,
}

/// Finds, reads and understands a turning job with `key=value` overrides.
///
/// # Errors
/// The first of what [`read`] finds.
pub fn load(name: &str, overrides: &[String]) -> Result<TurnedJob, ConfigError> {
    parse(&locate("jobs", name, "yaml", None)?, overrides)
}

/// Understands a turning job that has been read.
///
/// # Errors
/// The first of what [`read`] finds.
pub fn parse(located: &Located, overrides: &[String]) -> Result<TurnedJob, ConfigError> {
    read(located, overrides).map_err(|mut findings| findings.swap_remove(0))
}

/// Understands a turning job that has been read, or says everything that is in the way.
///
/// # Errors
/// Anything that is not a turning job, at least one sentence: unknown or missing keys, values out of range, surfaces that are none.
pub fn read(located: &Located, overrides: &[String]) -> Result<TurnedJob, Vec<ConfigError>> {
    let one = |error| vec![error];
    let document = Document::with_overrides(located, overrides).map_err(one)?;
    document.require_schema("turning_job", SCHEMA_VERSION).map_err(one)?;
    let file: TurningFile = schema::read(&document)?;
    let mut findings: Vec<ConfigError> = spindle(&document, &file).into_iter().collect();
    findings.extend(lead(&document));
    let nc = file.nc.turning_settings(&document).map_err(|error| findings.push(error)).ok();
    let machine = machine_file::named(&document, &file.machine).map_err(|errors| findings.extend(errors)).ok();
    let mut files = JobFiles::from_document(&document);
    let surface = file.surface.read(&document, &mut files).map_err(|errors| findings.extend(errors)).ok();
    let faults = fault_file::read_all(&file.faults, &document, machine.as_ref(), &mut findings);
    let feeds = feeds(&document, &file).map_err(|errors| findings.extend(errors)).ok();
    let grid = feeds.and_then(|(_, feed)| grid(&document, &file, feed).map_err(|error| findings.push(error)).ok());
    let (Some(machine), Some(surface), Some((rough_feed, feed)), Some(grid), Some(nc)) =
        (machine, surface, feeds, grid, nc)
    else {
        return Err(findings);
    };
    if !findings.is_empty() {
        return Err(findings);
    }
    let program = file.program.as_deref().map(|name| program_file::read(name, &document, &nc, &mut files));
    let program = program.transpose().map_err(one)?;
    let height_mm = machine.description.insert.map_or(0.0, |insert| insert.height_mm);
    let passes = passes(&file, &surface.surface, height_mm, rough_feed);
    let spec = TurningJob {
        name: file.name,
        surface: surface.surface,
        turned_mm: (file.turned.from_mm, file.turned.to_mm),
        bar_radius_mm: file.bar_radius_mm,
        part_zero_mm: file.part_zero_mm,
        passes,
        feed,
        angles: file.angles_per_turn,
        speed: match (file.spindle.law, file.spindle.rpm) {
            (SpindleLawFile::Constant, Some(rpm)) => TurningSpeed::Constant(rad_s_from_rpm(rpm)),
            (SpindleLawFile::Varied, _) => TurningSpeed::Varied,
            _ => TurningSpeed::Fastest,
        },
        clearance_mm: file.clearance_mm,
        rapid_speed_mm_s: file.rapid_speed_mm_s,
    };
    let (hash, files) = files.finish();
    Ok(TurnedJob {
        spec,
        title: file.title,
        source: document.text.clone(),
        hash,
        files,
        lifts: surface.lifts,
        mesh: surface.mesh,
        machine,
        faults,
        grid,
        tolerance_mm: mm_from_um(file.tolerance_um),
        nc,
        program,
        document,
    })
}

/// Refuses a spindle speed that its law does not take.
fn spindle(document: &Document, file: &TurningFile) -> Option<ConfigError> {
    match (file.spindle.law, file.spindle.rpm) {
        (SpindleLawFile::Constant, None) => {
            Some(document.error("spindle", "spindle.rpm is missing: spindle.law constant needs it"))
        }
        (SpindleLawFile::Fastest | SpindleLawFile::Varied, Some(_)) => Some(
            document.error("spindle.rpm", "spindle.rpm is only for spindle.law constant; remove it or set that law"),
        ),
        _ => None,
    }
}

/// Refuses the lead of a grinding wheel: the insert enters and leaves beside the part.
fn lead(document: &Document) -> Option<ConfigError> {
    document.root.get("nc.lead_deg").map(|_| {
        let message = "nc.lead_deg does not apply to a turning job: the insert begins before the part's end and leaves along X; remove it";
        document.error("nc.lead_deg", message)
    })
}

/// Feeds of roughing and finishing.
fn feeds(document: &Document, file: &TurningFile) -> Result<(InsertFeed, InsertFeed), Vec<ConfigError>> {
    let feed = |key: &str, along_z: Option<f64>, along_curve: Option<f64>| match (along_z, along_curve) {
        (Some(feed), None) => Ok(InsertFeed::AlongZ(feed)),
        (None, Some(feed)) => Ok(InsertFeed::AlongCurve(feed)),
        (Some(_), Some(_)) => {
            Err(vec![document.error(key, format!("{key} needs one of along_z_mm and along_curve_mm, it has both"))])
        }
        (None, None) => Err(vec![
            document.error(key, format!("{key} needs one of along_z_mm and along_curve_mm, the feed per turn")),
        ]),
    };
    let finishing = feed("finishing", file.finishing.along_z_mm, file.finishing.along_curve_mm);
    let roughing = match &file.roughing {
        Some(roughing) => feed("roughing", roughing.along_z_mm, roughing.along_curve_mm),
        None => finishing.clone(),
    };
    match (roughing, finishing) {
        (Ok(roughing), Ok(finishing)) => Ok((roughing, finishing)),
        (Err(mut errors), Err(more)) if file.roughing.is_some() => {
            errors.extend(more);
            Err(errors)
        }
        (Err(errors), _) | (_, Err(errors)) => Err(errors),
    }
}

/// The passes; the stock, where the job does not say it, is all that the bar has over the part in the rake plane, where it is cut.
fn passes(file: &TurningFile, surface: &Surface, height_mm: f64, rough_feed: InsertFeed) -> Passes {
    let (from_mm, to_mm) = file.turned.range_mm();
    let in_plane = |radius_mm: f64| (radius_mm * radius_mm - height_mm * height_mm).max(0.0).sqrt();
    let max_mm = (in_plane(file.bar_radius_mm) - in_plane(surface.bounds(from_mm, to_mm).min_mm)).max(0.0);
    match file.roughing {
        Some(roughing) => Passes {
            stock_mm: roughing.stock_mm.unwrap_or(max_mm),
            finish_mm: roughing.leaves_mm,
            deepest_mm: roughing.deepest_mm,
            rough_feed,
        },
        // Nothing is left to rough.
        None => Passes { stock_mm: max_mm, finish_mm: max_mm, deepest_mm: max_mm.max(1.0), rough_feed },
    }
}

/// The grid over what is turned.
fn grid(document: &Document, file: &TurningFile, feed: InsertFeed) -> Result<PartGrid, ConfigError> {
    let (InsertFeed::AlongZ(feed_mm) | InsertFeed::AlongCurve(feed_mm)) = feed;
    let (from_mm, to_mm) = file.turned.range_mm();
    let azimuths = file.form_grid.azimuths.unwrap_or(AZIMUTHS);
    let column_mm = file.form_grid.column_mm.unwrap_or(feed_mm / COLUMNS_PER_FEED);
    let columns = ((to_mm - from_mm) / column_mm).ceil() + 1.0;
    let cells = columns * azimuths as f64;
    if columns >= 2.0 && cells <= MAX_CELLS as f64 {
        #[allow(clippy::cast_possible_truncation, reason = "within the bounds above")]
        return Ok(PartGrid { azimuths, columns: columns as usize, from_mm, to_mm });
    }
    if columns >= 2.0 {
        let message = format!(
            "the part is simulated in columns of {column_mm:.6} mm with {azimuths} azimuths, {cells:.0} cells; at most {MAX_CELLS} are \
             allowed: larger columns (form_grid.column_mm), or fewer azimuths"
        );
        return Err(document.error("form_grid", message));
    }
    let message = format!("turned from {} to {} mm; the two must differ", file.turned.from_mm, file.turned.to_mm);
    Err(document.error("turned", message))
}

#[cfg(test)]
mod tests;
