//! Files of jobs that mill: what is written, and the job it means.

use super::ConfigError;
use super::groove_file::{self, GrooveFile};
use super::job_files::{JobFiles, NamedFile};
use super::lift_file::ProfileLift;
use super::locate::{Located, locate};
use super::names;
use super::nc_file::{NcFile, NcSettings};
use super::profile_file::{self, ProfileFile, contour_key};
use super::yaml::Document;
use camwright::cam::contour::Contour;
use camwright::job::grinding::ProfileSpec;
use camwright::job::milling::{CutsWith, MillAxis, MilledCam, MilledGroove, MillingJob, MillingPass, MillingTool};
use camwright::math::units::{mm_from_um, rad_from_deg, rad_s_from_rpm};
use camwright::toolpath::groove::Coverage;
use serde::Deserialize;
use std::sync::Arc;

/// Newest version of the schema that this program reads.
pub const SCHEMA_VERSION: u32 = 1;

/// Most profiles, cams and grooves, and passes, of a job: each is looked at before anything is planned.
const MOST_OF_EACH: usize = 100;

/// Most turns at one depth.
const MOST_TURNS: u32 = 100;

/// Largest number of a tool: four digits, as controls have them.
const MOST_TOOL_NUMBER: u32 = 9999;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MillingFile {
    #[serde(rename = "schema")]
    _schema: String,
    name: String,
    #[serde(default)]
    title: String,
    tool: ToolFile,
    #[serde(default)]
    profiles: Vec<ProfileFile>,
    #[serde(default)]
    cams: Vec<CamFile>,
    #[serde(default)]
    grooves: Vec<GrooveFile>,
    passes: Vec<PassFile>,
    #[serde(default = "default_clearance")]
    clearance_mm: f64,
    blank_radius_mm: Option<f64>,
    #[serde(default)]
    nc: NcFile,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ToolFile {
    #[serde(default = "first")]
    number: u32,
    #[serde(default)]
    cuts_with: CutsWithFile,
    radius_mm: f64,
    spindle_rpm: f64,
    #[serde(default)]
    text: String,
}

#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum CutsWithFile {
    #[default]
    Periphery,
    Face,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CamFile {
    name: String,
    profile: String,
    #[serde(default)]
    phase_deg: f64,
    z_mm: f64,
    width_mm: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PassFile {
    name: String,
    leaves_mm: f64,
    work_speed_rpm: f64,
    tolerance_um: f64,
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
    /// What the files mean.
    pub spec: MillingJob,
    /// One line about it.
    pub title: String,
    /// What the job file says, with overrides written in.
    pub source: String,
    /// SHA-256 over the job file and every file it names, 64 hexadecimal digits.
    pub hash: String,
    /// The files that it names.
    pub files: Arc<[NamedFile]>,
    /// Lifts that its contours and grooves were made of, by the names of profiles and grooves.
    pub lifts: Vec<(String, ProfileLift)>,
    /// How an NC program is made of it.
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
    let document = Document::of(located, overrides).map_err(one)?;
    document.require_schema("milling_job", SCHEMA_VERSION).map_err(one)?;
    let file: MillingFile = document.read().map_err(one)?;
    // What is wrong with a number is said in its own words, before anything is made of it.
    let findings = ranges(&document, &file);
    if !findings.is_empty() {
        return Err(findings);
    }
    let mut files = JobFiles::of(&document);
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
    lies_one_way(&document, &file, tool.cuts_with, &grooves).map_err(one)?;
    let nc = file.nc.read(&document)?;
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
        match profile.read(document, "profiles", index, files) {
            Ok((spec, lift)) => {
                lifts.push((spec.name.clone(), lift));
                profiles.push(spec);
            }
            Err(errors) => findings.extend(errors),
        }
    }
    if findings.is_empty() { Ok((profiles, lifts)) } else { Err(findings) }
}

/// The profile of this name, for whoever says it under a key.
pub(super) fn named<'a>(
    document: &Document,
    profiles: &'a [ProfileSpec],
    name: &str,
    key: &str,
) -> Result<(usize, &'a ProfileSpec), ConfigError> {
    profiles.iter().enumerate().find(|(_, profile)| profile.name == name).ok_or_else(|| {
        let known = profiles.iter().map(|profile| profile.name.as_str()).collect::<Vec<_>>().join(", ");
        document.error(key, format!("there is no profile {name}; the job has {known}"))
    })
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
            let (at, profile) = named(document, profiles, &cam.profile, &format!("cams.{index}.profile"))?;
            let contour = match &contours[at] {
                Some(contour) => contour.clone(),
                None => {
                    Contour::from_lift(&profile.lift, &profile.follower, profile.base_radius_mm).map_err(|error| {
                        let key = format!("profiles.{at}.{}", contour_key(&error));
                        document.error(&key, format!("profile {}: {error}", profile.name))
                    })?
                }
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
                lifts.extend(lift.map(|lift| (groove.name.clone(), lift)));
                grooves.push(groove);
            }
            Err(errors) => findings.extend(errors),
        }
    }
    if findings.is_empty() { Ok(grooves) } else { Err(findings) }
}

/// A job has one mill, whose axis lies one way.
fn lies_one_way(
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

/// What can be said about single values, in the words and units of the file.
fn ranges(document: &Document, file: &MillingFile) -> Vec<ConfigError> {
    // Of lists that are too long nothing more is said: names are compared each with each.
    let mut findings = counts(file);
    if !findings.is_empty() {
        return findings.into_iter().map(|(key, message)| document.error(&key, message)).collect();
    }
    if !file.profiles.is_empty() {
        findings.extend(profile_file::findings("profiles", &file.profiles));
    }
    for (index, profile) in file.profiles.iter().enumerate().filter(|(_, profile)| profile.gauge().is_some()) {
        let message = format!("profile {}: gauge is about lobes that are ground; a milled part has none", profile.name);
        findings.push((format!("profiles.{index}.gauge"), message));
    }
    findings.extend(name_faults(file));
    findings.extend(numbers(file));
    for (index, groove) in file.grooves.iter().enumerate() {
        findings.extend(groove_file::findings(groove, index));
    }
    findings.into_iter().map(|(key, message)| document.error(&key, message)).collect()
}

fn counts(file: &MillingFile) -> Vec<(String, String)> {
    let mut findings = Vec::new();
    if file.cams.is_empty() && file.grooves.is_empty() {
        findings.push(("cams".to_owned(), "the job has neither cams nor grooves; it needs at least 1".to_owned()));
    }
    if file.passes.is_empty() {
        findings.push(("passes".to_owned(), "the job has no passes; it needs at least 1".to_owned()));
    }
    let lists = [
        ("profiles", file.profiles.len()),
        ("cams", file.cams.len()),
        ("grooves", file.grooves.len()),
        ("passes", file.passes.len()),
    ];
    for (key, count) in lists.into_iter().filter(|(_, count)| *count > MOST_OF_EACH) {
        findings.push((key.to_owned(), format!("the job has {count} {key}; at most {MOST_OF_EACH} are allowed")));
    }
    findings
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
    findings.extend(names::fault("job", &file.name).map(|message| ("name".to_owned(), message)));
    for (what, one, list) in [("cams or grooves", "cam or groove", &parts), ("passes", "pass", &passes)] {
        for (index, (key, name)) in list.iter().enumerate() {
            findings.extend(names::fault(one, name).map(|message| (key.clone(), message)));
            if list[..index].iter().any(|(_, other)| other == name) {
                findings.push((key.clone(), format!("there are two {what} named {name}; names must differ")));
            }
        }
    }
    findings
}

/// A number with the range in which it makes sense: above the lower end, up to the upper.
fn numbers(file: &MillingFile) -> Vec<(String, String)> {
    let mut findings = Vec::new();
    let mut within = |key: String, value: f64, from: f64, to: f64| {
        if !(value > from && value <= to) {
            findings.push((key.clone(), format!("{key} is {value}; it must be above {from}, up to {to}")));
        }
    };
    within("tool.radius_mm".into(), file.tool.radius_mm, 0.0, 1000.0);
    within("tool.spindle_rpm".into(), file.tool.spindle_rpm, 0.0, 1e6);
    within("clearance_mm".into(), file.clearance_mm, 0.0, 1000.0);
    if let Some(blank_mm) = file.blank_radius_mm {
        within("blank_radius_mm".into(), blank_mm, 0.0, 10_000.0);
    }
    for (index, pass) in file.passes.iter().enumerate() {
        within(format!("passes.{index}.work_speed_rpm"), pass.work_speed_rpm, 0.0, 10_000.0);
        within(format!("passes.{index}.tolerance_um"), pass.tolerance_um, 0.0, 1000.0);
    }
    for (index, cam) in file.cams.iter().enumerate() {
        if let Some(width) = cam.width_mm {
            within(format!("cams.{index}.width_mm"), width, 0.0, 1000.0);
        }
    }
    let mut finite = |key: String, value: f64| {
        if !(value.is_finite() && value.abs() <= 1e5) {
            findings.push((key.clone(), format!("{key} is {value}; it must be -100000 to 100000")));
        }
    };
    for (index, cam) in file.cams.iter().enumerate() {
        finite(format!("cams.{index}.phase_deg"), cam.phase_deg);
        finite(format!("cams.{index}.z_mm"), cam.z_mm);
    }
    for (index, pass) in file.passes.iter().enumerate() {
        if !(0.0..=1000.0).contains(&pass.leaves_mm) {
            let key = format!("passes.{index}.leaves_mm");
            findings.push((key.clone(), format!("{key} is {}; it must be 0 to 1000", pass.leaves_mm)));
        }
        if !(1..=MOST_TURNS).contains(&pass.turns) {
            let key = format!("passes.{index}.turns");
            findings.push((key.clone(), format!("{key} is {}; it must be 1 to {MOST_TURNS}", pass.turns)));
        }
    }
    if !(1..=MOST_TOOL_NUMBER).contains(&file.tool.number) {
        let message = format!("tool.number is {}; it must be 1 to {MOST_TOOL_NUMBER}", file.tool.number);
        findings.push(("tool.number".into(), message));
    }
    findings
}

#[cfg(test)]
mod tests;
