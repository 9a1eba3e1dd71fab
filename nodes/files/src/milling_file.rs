// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Files of jobs that mill: what is written, and the job it means.

use super::ConfigError;
use super::groove_file::{self, GrooveFile};
use super::job_files::JobFiles;
use super::lift_file::ProfileLift;
use super::locate::{Located, locate};
use super::names;
use super::nc_file::{NcFile, NcSettings};
use super::profile_file::{self, ProfileFile, contour_key, profile_named};
use super::recorded_files::NamedFile;
use super::schema;
use super::yaml::Document;
use camwright::cam::contour::Contour;
use camwright::job::grinding::ProfileSpec;
use camwright::job::milling::{
    CutsWith, GrooveKind, MillAxis, MilledCam, MilledGroove, MillingJob, MillingPass, MillingTool,
};
use camwright::math::units::{mm_from_um, rad_from_deg, rad_s_from_rpm};
use camwright::toolpath::groove::Coverage;
use camwright::toolpath::groove::rib::PlacedGroove;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Newest version of the schema that this program reads.
pub const SCHEMA_VERSION: u32 = 1;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MillingFile {
    /// Kind and version of the file.
    #[schemars(extend("const" = "camwright/milling_job/1"))]
    #[serde(rename = "schema")]
    _schema: String,
    /// Name of the job, also of its output files.
    #[schemars(schema_with = "names::schema")]
    name: String,
    /// One line about the job.
    #[serde(default)]
    title: String,
    /// Mill.
    tool: ToolFile,
    /// Shapes of cams, and with a roller the inner walls of grooves in plates; as in grinding jobs, without
    /// `gauge`.
    #[schemars(length(max = 100))]
    #[serde(default)]
    profiles: Vec<ProfileFile>,
    /// Cams of the part.
    #[schemars(length(max = 100))]
    #[serde(default)]
    cams: Vec<MilledCamFile>,
    /// Grooves of the part.
    #[schemars(length(max = 100))]
    #[serde(default)]
    grooves: Vec<GrooveFile>,
    /// Passes around everything, in order.
    #[schemars(length(min = 1, max = 100))]
    passes: Vec<PassFile>,
    /// Distance of the mill from the part on its travels.
    #[schemars(range(min = 1e-6, max = 1000.0))]
    #[serde(default = "default_clearance")]
    clearance_mm: f64,
    /// Radius of the blank of the cams. Default: the largest radius of each cam.
    #[schemars(range(min = 1e-6, max = 1e4))]
    blank_radius_mm: Option<f64>,
    /// Settings of the NC program.
    #[serde(default)]
    nc: NcFile,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ToolFile {
    /// Number of the tool in the control.
    #[schemars(range(min = 1, max = 9999))]
    #[serde(default = "first")]
    number: u32,
    /// Part of the mill that makes cams.
    #[serde(default)]
    cuts_with: CutsWithFile,
    /// Radius of the mill.
    #[schemars(range(min = 1e-6, max = 1000.0))]
    radius_mm: f64,
    /// Speed of the spindle.
    #[schemars(range(min = 1e-3, max = 1e6))]
    spindle_rpm: f64,
    /// Description of the tool in the program.
    #[serde(default)]
    text: String,
}

#[derive(Debug, Default, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum CutsWithFile {
    /// The periphery: the axis of the mill is parallel to the part's axis.
    #[default]
    Periphery,
    /// The face: the axis of the mill lies along X. It makes no hollow.
    Face,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct MilledCamFile {
    /// Name of the cam, different from all cams and grooves.
    #[schemars(schema_with = "names::schema")]
    name: String,
    /// Name of its profile.
    profile: String,
    /// Phase, as of a lobe.
    #[schemars(range(min = -1e5, max = 1e5))]
    #[serde(default)]
    phase_deg: f64,
    /// Z of the mill.
    #[schemars(range(min = -1e5, max = 1e5))]
    z_mm: f64,
    /// Width of the cam; a face that cuts less is refused. Default: unknown.
    #[schemars(range(min = 1e-6, max = 1000.0))]
    width_mm: Option<f64>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct PassFile {
    /// Name of the pass.
    #[schemars(schema_with = "names::schema")]
    name: String,
    /// Stock that the pass leaves along the normal of contours and walls.
    #[schemars(range(min = 0.0, max = 1000.0))]
    leaves_mm: f64,
    /// Speed of the part.
    #[schemars(range(min = 1e-6, max = 1e4))]
    work_speed_rpm: f64,
    /// Tolerance of the program.
    #[schemars(range(min = 1e-3, max = 1000.0))]
    tolerance_um: f64,
    /// Turns at each depth; along a groove of several turns or with two ends, runs along the whole groove.
    #[schemars(range(min = 1, max = 100))]
    #[serde(default = "first")]
    turns: u32,
}

fn first() -> u32 {
    1
}

fn default_clearance() -> f64 {
    2.0
}

/// A job that mills, as its files describe it.
#[derive(Debug, Clone)]
pub struct MilledJob {
    /// Job that the files describe.
    pub spec: MillingJob,
    /// One line about it.
    pub title: String,
    /// Text of the job file, with overrides applied.
    pub source: String,
    /// SHA-256 over the job file and every file it names, 64 hexadecimal digits.
    pub hash: String,
    /// The files that it names.
    pub files: Arc<[NamedFile]>,
    /// Lifts that its contours and grooves were made of, by the names of profiles and grooves.
    pub lifts: Vec<(String, ProfileLift)>,
    /// Settings of the NC program.
    pub nc: NcSettings,
    /// The job file, for messages that point into it.
    pub document: Document,
}

/// Finds, reads and understands a milling job with `key=value` overrides.
///
/// # Errors
/// The first of what [`read`] finds.
pub fn load(name: &str, overrides: &[String]) -> Result<MilledJob, ConfigError> {
    parse(&locate("jobs", name, "yaml", None)?, overrides)
}

/// Understands a milling job that has been read.
///
/// # Errors
/// The first of what [`read`] finds.
pub fn parse(located: &Located, overrides: &[String]) -> Result<MilledJob, ConfigError> {
    read(located, overrides).map_err(|mut findings| findings.swap_remove(0))
}

/// Understands a milling job that has been read, or says everything that is in the way.
///
/// # Errors
/// Anything that is not a milling job, at least one sentence: unknown or missing keys, values out of range, contours and grooves that the
/// mill cannot make.
pub fn read(located: &Located, overrides: &[String]) -> Result<MilledJob, Vec<ConfigError>> {
    let one = |error| vec![error];
    let document = Document::with_overrides(located, overrides).map_err(one)?;
    document.require_schema("milling_job", SCHEMA_VERSION).map_err(one)?;
    let file: MillingFile = schema::read(&document)?;
    let findings = conflicts(&document, &file);
    if !findings.is_empty() {
        return Err(findings);
    }
    let mut files = JobFiles::from_document(&document);
    let (profiles, mut lifts) = read_profiles(&document, &file, &mut files)?;
    let tool = tool(&file.tool);
    let passes: Vec<MillingPass> = file.passes.iter().map(pass).collect();
    let (cams, grooves) = (
        cams(&document, &file, &profiles, &tool, &passes),
        grooves(&document, &file, &profiles, &tool, &passes, &mut files, &mut lifts),
    );
    let (cams, grooves) = match (cams, grooves) {
        (Ok(cams), Ok(grooves)) => (cams, grooves),
        (cams, grooves) => return Err([cams.err(), grooves.err()].into_iter().flatten().flatten().collect()),
    };
    is_monotonic(&document, &file, tool.cuts_with, &grooves).map_err(one)?;
    let nc = file.nc.settings(&document).map_err(one)?;
    let (name, clearance_mm, blank_radius_mm) = (file.name, file.clearance_mm, file.blank_radius_mm);
    let (hash, files) = files.finish();
    Ok(MilledJob {
        spec: MillingJob { name, tool, cams, grooves, passes, clearance_mm, blank_radius_mm },
        nc,
        title: file.title,
        source: document.text.clone(),
        hash,
        files,
        lifts,
        document,
    })
}

fn tool(file: &ToolFile) -> MillingTool {
    MillingTool {
        number: file.number,
        cuts_with: match file.cuts_with {
            CutsWithFile::Periphery => CutsWith::Periphery,
            CutsWithFile::Face => CutsWith::Face,
        },
        radius_mm: file.radius_mm,
        spindle_speed_rad_s: rad_s_from_rpm(file.spindle_rpm),
        text: file.text.clone(),
    }
}

fn pass(file: &PassFile) -> MillingPass {
    MillingPass {
        name: file.name.clone(),
        leaves_mm: file.leaves_mm,
        work_speed_rad_s: rad_s_from_rpm(file.work_speed_rpm),
        tolerance_mm: mm_from_um(file.tolerance_um),
        turns: file.turns,
    }
}

/// Profiles with their lifts.
type Profiles = (Vec<ProfileSpec>, Vec<(String, ProfileLift)>);

fn read_profiles(document: &Document, file: &MillingFile, files: &mut JobFiles) -> Result<Profiles, Vec<ConfigError>> {
    let (mut profiles, mut lifts, mut findings) = (Vec::new(), Vec::new(), Vec::new());
    for (index, profile) in file.profiles.iter().enumerate() {
        match profile.read(document, ("profiles", index), &profiles, files) {
            Ok((spec, lift)) => {
                let key = format!("profiles.{index}.lift");
                findings.extend(profile_file::refuse_ground(document, &key, &spec).err());
                lifts.push((spec.name.clone(), lift));
                profiles.push(spec);
            }
            Err(errors) => findings.extend(errors),
        }
    }
    if findings.is_empty() { Ok((profiles, lifts)) } else { Err(findings) }
}

/// The cams, each tried with the mill and what the pass leaves that leaves most, for which a mill is widest.
fn cams(
    document: &Document,
    file: &MillingFile,
    profiles: &[ProfileSpec],
    tool: &MillingTool,
    passes: &[MillingPass],
) -> Result<Vec<MilledCam>, Vec<ConfigError>> {
    let thickest = passes.iter().max_by(|a, b| a.leaves_mm.total_cmp(&b.leaves_mm));
    let mut contours: Vec<Option<Contour>> = vec![None; profiles.len()];
    let (mut cams, mut findings) = (Vec::new(), Vec::new());
    for (index, cam) in file.cams.iter().enumerate() {
        let mut read = || {
            let (at, profile) = profile_named(document, profiles, &cam.profile, &format!("cams.{index}.profile"))?;
            let contour = match &contours[at] {
                Some(contour) => contour.clone(),
                None => profile.contour().map_err(|error| {
                    let key = format!("profiles.{at}.{}", contour_key(&error));
                    document.error(&key, format!("profile {}: {error}", profile.name))
                })?,
            };
            contours[at] = Some(contour.clone());
            let (name, phase_rad) = (cam.name.clone(), rad_from_deg(cam.phase_deg));
            let milled = MilledCam { name, contour, phase_rad, z_mm: cam.z_mm, width_mm: cam.width_mm };
            if let Some(pass) = thickest {
                tool.fits_cam(&milled, pass.leaves_mm).map_err(|error| {
                    document.error("tool.radius_mm", format!("cam {}, pass {}: {error}", cam.name, pass.name))
                })?;
            }
            Ok(milled)
        };
        match read() {
            Ok(milled) => cams.push(milled),
            Err(error) => findings.push(error),
        }
    }
    if findings.is_empty() { Ok(cams) } else { Err(findings) }
}

/// The grooves, each tried with the mill and what every pass leaves; their own lifts are added to those of the profiles.
fn grooves(
    document: &Document,
    file: &MillingFile,
    profiles: &[ProfileSpec],
    tool: &MillingTool,
    passes: &[MillingPass],
    files: &mut JobFiles,
    lifts: &mut Vec<(String, ProfileLift)>,
) -> Result<Vec<MilledGroove>, Vec<ConfigError>> {
    let (mut grooves, mut findings) = (Vec::new(), Vec::new());
    for (index, groove) in file.grooves.iter().enumerate() {
        match groove.read(document, index, profiles, files) {
            Ok((groove, lift)) => {
                // Only what has to be cut by the first pass has to be cut from the full.
                let fits = passes.iter().enumerate().try_for_each(|(index, pass)| {
                    let coverage = if index == 0 { Coverage::Slot } else { Coverage::Walls };
                    tool.fits_groove(&groove, pass.leaves_mm, coverage).map_err(|error| {
                        document.error("tool.radius_mm", format!("groove {}, pass {}: {error}", groove.name, pass.name))
                    })
                });
                findings.extend(fits.err());
                findings.extend(ends_beyond(document, file, index, &groove).err());
                lifts.extend(lift.map(|lift| (groove.name.clone(), lift)));
                grooves.push(groove);
            }
            Err(errors) => findings.extend(errors),
        }
    }
    if findings.is_empty() {
        findings.extend(ribs(document, &grooves).err());
    }
    if findings.is_empty() { Ok(grooves) } else { Err(findings) }
}

/// The ends of an open groove lie beyond the end faces, by the roller and the clearance of the mill.
fn ends_beyond(
    document: &Document,
    file: &MillingFile,
    index: usize,
    groove: &MilledGroove,
) -> Result<(), ConfigError> {
    let GrooveKind::Barrel { groove: walls, .. } = &groove.kind else { return Ok(()) };
    walls.check_ends(file.clearance_mm).map_err(|error| {
        let message = format!("groove {}: {error} (the radius of the roller and clearance_mm)", groove.name);
        document.error(&format!("grooves.{index}.open"), message)
    })
}

/// Ribs remain between two grooves round a cylinder, and every roller of a turret has a groove.
fn ribs(document: &Document, grooves: &[MilledGroove]) -> Result<(), ConfigError> {
    let placed = grooves.iter().enumerate().filter_map(|(index, groove)| match &groove.kind {
        GrooveKind::Barrel { groove: walls, z_mm, .. } => {
            let (name, phase_rad) = (groove.name.as_str(), groove.phase_rad);
            Some((index, PlacedGroove { name, groove: walls, z_mm: *z_mm, phase_rad }))
        }
        GrooveKind::Plate { .. } => None,
    });
    let placed: Vec<_> = placed.collect();
    let all: Vec<PlacedGroove<'_>> = placed.iter().map(|(_, groove)| *groove).collect();
    for (at, (index, groove)) in placed.iter().enumerate() {
        for (_, before) in &placed[..at] {
            groove
                .check_rib_beside(before)
                .map_err(|error| document.error(&format!("grooves.{index}.z_mm"), error.to_string()))?;
        }
        groove.check_rollers(&all).map_err(|error| {
            document.error(&format!("grooves.{index}.turret"), format!("groove {}: {error}", groove.name))
        })?;
    }
    Ok(())
}

/// A job has one mill, whose axis lies one way.
fn is_monotonic(
    document: &Document,
    file: &MillingFile,
    cuts_with: CutsWith,
    grooves: &[MilledGroove],
) -> Result<(), ConfigError> {
    let cams = file.cams.iter().map(|cam| ("cam", cam.name.as_str(), cuts_with.axis(), "tool.cuts_with".to_owned()));
    let grooves = grooves
        .iter()
        .enumerate()
        .map(|(index, groove)| ("groove", groove.name.as_str(), groove.axis(), format!("grooves.{index}.kind")));
    let mut all = cams.chain(grooves);
    let Some((kind, name, axis, _)) = all.next() else { return Ok(()) };
    match all.find(|(_, _, other, _)| *other != axis) {
        None => Ok(()),
        Some((other_kind, other_name, other, key)) => {
            let say = |axis: MillAxis| axis.name();
            let message = format!(
                "the mill's axis is {} for {kind} {name} and {} for {other_kind} {other_name}; a job has one mill, whose axis lies one way",
                say(axis),
                say(other)
            );
            Err(document.error(&key, message))
        }
    }
}

/// Values that do not fit each other.
fn conflicts(document: &Document, file: &MillingFile) -> Vec<ConfigError> {
    let mut findings = Vec::new();
    if file.cams.is_empty() && file.grooves.is_empty() {
        findings.push(("cams".to_owned(), "the job has neither cams nor grooves; it needs at least 1".to_owned()));
    }
    findings.extend(profile_file::findings("profiles", &file.profiles));
    for (index, profile) in file.profiles.iter().enumerate().filter(|(_, profile)| profile.gauge().is_some()) {
        let message = format!("profile {}: gauge is for ground lobes; remove it from a milled part", profile.name);
        findings.push((format!("profiles.{index}.gauge"), message));
    }
    findings.extend(name_faults(file));
    for (index, groove) in file.grooves.iter().enumerate() {
        findings.extend(groove_file::findings(groove, index));
    }
    findings.into_iter().map(|(key, message)| document.error(&key, message)).collect()
}

/// Cams and grooves are subprograms, and passes stand in their names.
fn name_faults(file: &MillingFile) -> Vec<(String, String)> {
    let mut findings = Vec::new();
    let cams = file.cams.iter().enumerate().map(|(index, cam)| (format!("cams.{index}.name"), &cam.name));
    let grooves =
        file.grooves.iter().enumerate().map(|(index, groove)| (format!("grooves.{index}.name"), &groove.name));
    let passes = file.passes.iter().enumerate().map(|(index, pass)| (format!("passes.{index}.name"), &pass.name));
    let parts: Vec<_> = cams.chain(grooves).collect();
    let passes: Vec<_> = passes.collect();
    for (what, list) in [("cams or grooves", &parts), ("passes", &passes)] {
        for (index, (key, name)) in list.iter().enumerate() {
            if list[..index].iter().any(|(_, other)| other == name) {
                findings.push((key.clone(), format!("there are two {what} named {name}; names must differ")));
            }
        }
    }
    findings
}

#[cfg(test)]
mod tests;
