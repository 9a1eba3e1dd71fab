//! Files of jobs that turn: what is written, and the job it means.

use super::ConfigError;
use super::fault_file::{self, FaultFile, JobFault};
use super::job_files::{JobFiles, NamedFile};
use super::lift_file::ProfileLift;
use super::locate::{Located, locate};
use super::machine_file::{self, Machine};
use super::names;
use super::surface_file::SurfaceFile;
use super::yaml::Document;
use camwright::cam::surface::Surface;
use camwright::cam::surface::mesh::MeshReading;
use camwright::job::turning::{TurningJob, TurningSpeed};
use camwright::math::units::{mm_from_um, rad_s_from_rpm};
use camwright::simulation::turned_part::{MIN_AZIMUTHS, MOST_CELLS, PartGrid};
use camwright::toolpath::insert_path::{Feed, Passes};
use serde::Deserialize;
use serde::de::IgnoredAny;
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

const MOST_AZIMUTHS: usize = 7200;

/// How far the form may be off besides the cusps of the feed (µm).
const TOLERANCE_UM: f64 = 2.0;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TurningFile {
    #[serde(rename = "schema")]
    _schema: String,
    name: String,
    #[serde(default)]
    title: String,
    machine: String,
    #[serde(rename = "surface")]
    _surface: IgnoredAny,
    turned: TurnedFile,
    bar_radius_mm: f64,
    part_zero_mm: f64,
    roughing: Option<RoughingFile>,
    finishing: FinishingFile,
    #[serde(default = "default_angles")]
    angles_per_turn: u32,
    #[serde(default)]
    spindle: SpindleFile,
    #[serde(default = "default_clearance")]
    clearance_mm: f64,
    rapid_speed_mm_s: f64,
    #[serde(default)]
    form_grid: FormGridFile,
    #[serde(default = "default_tolerance")]
    tolerance_um: f64,
    #[serde(default)]
    faults: Vec<FaultFile>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct TurnedFile {
    from_mm: f64,
    to_mm: f64,
}

impl TurnedFile {
    fn range_mm(self) -> (f64, f64) {
        (self.from_mm.min(self.to_mm), self.from_mm.max(self.to_mm))
    }
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct RoughingFile {
    stock_mm: Option<f64>,
    leaves_mm: f64,
    deepest_mm: f64,
    along_z_mm: Option<f64>,
    along_curve_mm: Option<f64>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct FinishingFile {
    along_z_mm: Option<f64>,
    along_curve_mm: Option<f64>,
}

#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct SpindleFile {
    #[serde(default)]
    law: SpindleLawFile,
    rpm: Option<f64>,
}

#[derive(Debug, Default, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum SpindleLawFile {
    #[default]
    Fastest,
    Constant,
    Varied,
}

#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct FormGridFile {
    azimuths: Option<usize>,
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
    /// What the files mean.
    pub spec: TurningJob,
    /// One line about it.
    pub title: String,
    /// What the job file says, with overrides written in.
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
    pub machine: Machine,
    /// Faults that strike in it.
    pub faults: Vec<JobFault>,
    /// Where the part is simulated, and its form judged.
    pub grid: PartGrid,
    /// How far the form may be off, besides the cusps of the feed (mm).
    pub tolerance_mm: f64,
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
    let document = Document::of(located, overrides).map_err(one)?;
    document.require_schema("turning_job", SCHEMA_VERSION).map_err(one)?;
    let file: TurningFile = document.read().map_err(one)?;
    let shape = SurfaceFile::of(&document).map_err(one)?;
    let mut findings = ranges(&document, &file);
    let machine = machine_file::named(&document, &file.machine).map_err(|error| findings.push(error)).ok();
    let mut files = JobFiles::of(&document);
    let surface = shape.read(&document, &mut files).map_err(|errors| findings.extend(errors)).ok();
    let faults = fault_file::read_all(&file.faults, &document, machine.as_ref(), &mut findings);
    let feeds = feeds(&document, &file).map_err(|errors| findings.extend(errors)).ok();
    let grid = feeds.and_then(|(_, feed)| grid(&document, &file, feed).map_err(|error| findings.push(error)).ok());
    let (Some(machine), Some(surface), Some((rough_feed, feed)), Some(grid)) = (machine, surface, feeds, grid) else {
        return Err(findings);
    };
    if !findings.is_empty() {
        return Err(findings);
    }
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
        document,
    })
}

/// What can be said about single values, in the words and units of the file.
fn ranges(document: &Document, file: &TurningFile) -> Vec<ConfigError> {
    let mut findings = Vec::new();
    let mut refuse = |key: &str, message: String| findings.push(document.error(key, message));
    if let Some(message) = names::fault("job", &file.name) {
        refuse("name", message);
    }
    let roughing = file.roughing.iter().flat_map(|roughing| {
        [
            roughing.stock_mm.map(|stock| ("roughing.stock_mm", stock)),
            Some(("roughing.deepest_mm", roughing.deepest_mm)),
            roughing.along_z_mm.map(|feed| ("roughing.along_z_mm", feed)),
            roughing.along_curve_mm.map(|feed| ("roughing.along_curve_mm", feed)),
        ]
    });
    let given = [
        file.finishing.along_z_mm.map(|feed| ("finishing.along_z_mm", feed)),
        file.finishing.along_curve_mm.map(|feed| ("finishing.along_curve_mm", feed)),
        file.spindle.rpm.map(|rpm| ("spindle.rpm", rpm)),
        file.form_grid.column_mm.map(|column| ("form_grid.column_mm", column)),
    ];
    let positive = [
        ("bar_radius_mm", file.bar_radius_mm),
        ("clearance_mm", file.clearance_mm),
        ("rapid_speed_mm_s", file.rapid_speed_mm_s),
        ("tolerance_um", file.tolerance_um),
    ];
    for (key, value) in positive.into_iter().chain(roughing.chain(given).flatten()) {
        if !(value.is_finite() && value > 0.0) {
            refuse(key, format!("{key} is {value}; it must be a positive number"));
        }
    }
    if let Some(leaves) =
        file.roughing.map(|roughing| roughing.leaves_mm).filter(|leaves| !(0.0..=1e3).contains(leaves))
    {
        refuse("roughing.leaves_mm", format!("roughing.leaves_mm is {leaves}; it must be 0 to 1000"));
    }
    if let Some(azimuths) =
        file.form_grid.azimuths.filter(|azimuths| !(MIN_AZIMUTHS..=MOST_AZIMUTHS).contains(azimuths))
    {
        let message = format!("form_grid.azimuths is {azimuths}; it must be {MIN_AZIMUTHS} to {MOST_AZIMUTHS}");
        refuse("form_grid.azimuths", message);
    }
    match (file.spindle.law, file.spindle.rpm) {
        (SpindleLawFile::Constant, None) => {
            refuse("spindle", "spindle.law constant needs spindle.rpm, the speed to turn at".into());
        }
        (SpindleLawFile::Fastest | SpindleLawFile::Varied, Some(_)) => {
            refuse("spindle.rpm", "spindle.rpm is about law: constant; the other laws take what the axes allow".into());
        }
        _ => {}
    }
    findings
}

/// Feeds of roughing and finishing.
fn feeds(document: &Document, file: &TurningFile) -> Result<(Feed, Feed), Vec<ConfigError>> {
    let feed = |key: &str, along_z: Option<f64>, along_curve: Option<f64>| match (along_z, along_curve) {
        (Some(feed), None) => Ok(Feed::AlongZ(feed)),
        (None, Some(feed)) => Ok(Feed::AlongCurve(feed)),
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
fn passes(file: &TurningFile, surface: &Surface, height_mm: f64, rough_feed: Feed) -> Passes {
    let (from_mm, to_mm) = file.turned.range_mm();
    let in_plane = |radius_mm: f64| (radius_mm * radius_mm - height_mm * height_mm).max(0.0).sqrt();
    let most_mm = (in_plane(file.bar_radius_mm) - in_plane(surface.bounds(from_mm, to_mm).least_mm)).max(0.0);
    match file.roughing {
        Some(roughing) => Passes {
            stock_mm: roughing.stock_mm.unwrap_or(most_mm),
            finish_mm: roughing.leaves_mm,
            deepest_mm: roughing.deepest_mm,
            rough_feed,
        },
        // Nothing is left to rough.
        None => Passes { stock_mm: most_mm, finish_mm: most_mm, deepest_mm: most_mm.max(1.0), rough_feed },
    }
}

/// The grid over what is turned.
fn grid(document: &Document, file: &TurningFile, feed: Feed) -> Result<PartGrid, ConfigError> {
    let (Feed::AlongZ(feed_mm) | Feed::AlongCurve(feed_mm)) = feed;
    let (from_mm, to_mm) = file.turned.range_mm();
    let azimuths = file.form_grid.azimuths.unwrap_or(AZIMUTHS);
    let column_mm = file.form_grid.column_mm.unwrap_or(feed_mm / COLUMNS_PER_FEED);
    let columns = ((to_mm - from_mm) / column_mm).ceil() + 1.0;
    let cells = columns * azimuths as f64;
    if columns >= 2.0 && cells <= MOST_CELLS as f64 {
        #[allow(clippy::cast_possible_truncation, reason = "within the bounds above")]
        return Ok(PartGrid { azimuths, columns: columns as usize, from_mm, to_mm });
    }
    if columns >= 2.0 {
        let message = format!(
            "the part is simulated in columns of {column_mm:.6} mm with {azimuths} azimuths, {cells:.0} cells; at most {MOST_CELLS} are \
             allowed: larger columns (form_grid.column_mm), or fewer azimuths"
        );
        return Err(document.error("form_grid", message));
    }
    let message = format!("turned from {} to {} mm; the two must differ", file.turned.from_mm, file.turned.to_mm);
    Err(document.error("turned", message))
}

#[cfg(test)]
mod tests;
