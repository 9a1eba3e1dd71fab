//! The surface of a part that is turned: what a job writes under `surface`, and the shape it means.

use super::grid_text;
use super::job_files::JobFiles;
use super::lift_file::ProfileLift;
use super::locate::LocatedBytes;
use super::profile_file::{self, ProfileFile, contour_key};
use super::stl;
use super::yaml::Document;
use super::{ConfigError, Place};
use camwright::cam::contour::Contour;
use camwright::cam::lift::LengthUnit;
use camwright::cam::surface::cams::CamAlong;
use camwright::cam::surface::mesh::{MeshReading, surface_of};
use camwright::cam::surface::solid::{Along, Harmonic, Solid};
use camwright::cam::surface::{Surface, SurfaceError};
use camwright::math::units::rad_from_deg;
use serde::Deserialize;
use serde::de::{DeserializeOwned, Deserializer, MapAccess, Visitor};
use std::fmt;
use std::path::PathBuf;

/// `surface` as written, by its `kind`.
#[derive(Debug)]
pub(super) enum SurfaceFile {
    Cams(CamsFile),
    Cylinder(CylinderFile),
    Eccentric(EccentricFile),
    EllipticCone(EllipticConeFile),
    Lobed(LobedFile),
    Grid(GridFile),
    Mesh(MeshFile),
}

/// The kinds of surfaces.
const KINDS: &str = "cams, cylinder, eccentric, elliptic_cone, lobed, grid, mesh";

/// A job file of which nothing but the surface is looked at.
#[derive(Debug, Deserialize)]
struct Only<S> {
    surface: S,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CamsFile {
    #[serde(rename = "kind")]
    _kind: String,
    profiles: Vec<ProfileFile>,
    cams: Vec<CamFile>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CylinderFile {
    #[serde(rename = "kind")]
    _kind: String,
    from_mm: f64,
    to_mm: f64,
    radius_mm: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EccentricFile {
    #[serde(rename = "kind")]
    _kind: String,
    from_mm: f64,
    to_mm: f64,
    radius_mm: f64,
    eccentricity_mm: f64,
    #[serde(default)]
    azimuth_deg: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EllipticConeFile {
    #[serde(rename = "kind")]
    _kind: String,
    from_mm: f64,
    to_mm: f64,
    first_mm: Ends,
    second_mm: Ends,
    #[serde(default)]
    azimuth_deg: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LobedFile {
    #[serde(rename = "kind")]
    _kind: String,
    from_mm: f64,
    to_mm: f64,
    mean_mm: Ends,
    waves: Vec<WaveFile>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GridFile {
    #[serde(rename = "kind")]
    _kind: String,
    file: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshFile {
    #[serde(rename = "kind")]
    _kind: String,
    file: String,
    unit: LengthFile,
    #[serde(default)]
    axis: AxisFile,
}

/// What a length of a file is, which says no unit itself.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum LengthFile {
    Mm,
    Inch,
    M,
}

impl LengthFile {
    fn mm(self) -> f64 {
        match self {
            Self::Mm => 1.0,
            Self::Inch => LengthUnit::Inch.mm(),
            Self::M => 1000.0,
        }
    }
}

/// Which axis of a file is that of the part; the next one, in the order x, y, z, x, points to the key-way.
#[derive(Debug, Default, Clone, Copy)]
enum AxisFile {
    X,
    Y,
    #[default]
    Z,
}

impl AxisFile {
    fn turned(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::X => [y, z, x],
            Self::Y => [z, x, y],
            Self::Z => [x, y, z],
        }
    }
}

impl<'de> Deserialize<'de> for AxisFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AxisVisitor)
    }
}

struct AxisVisitor;

impl Visitor<'_> for AxisVisitor {
    type Value = AxisFile;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("x, y or z")
    }
    fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<AxisFile, E> {
        match name {
            "x" => Ok(AxisFile::X),
            "y" => Ok(AxisFile::Y),
            "z" => Ok(AxisFile::Z),
            other => Err(E::invalid_value(serde::de::Unexpected::Str(other), &self)),
        }
    }
    /// To YAML a bare `y` is a yes.
    fn visit_bool<E: serde::de::Error>(self, is_yes: bool) -> Result<AxisFile, E> {
        if is_yes { Ok(AxisFile::Y) } else { Err(E::invalid_value(serde::de::Unexpected::Bool(is_yes), &self)) }
    }
}

/// A length of the part that is one cam.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CamFile {
    profile: String,
    #[serde(default)]
    phase_deg: f64,
    from_mm: f64,
    to_mm: f64,
}

/// One wave of a lobed part.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WaveFile {
    per_turn: u32,
    amplitude_mm: Ends,
    #[serde(default)]
    phase_deg: Ends,
}

/// A number that changes evenly from one end of the part to the other: `24.0`, or `{from: 24.0, to: 22.0}`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Ends {
    from: f64,
    to: f64,
}

impl Ends {
    fn along(self, from_mm: f64, to_mm: f64) -> Along {
        // The same at both ends is the same everywhere, whatever the length.
        if self.from.to_bits() == self.to.to_bits() {
            return Along::constant(self.from);
        }
        let per_mm = (self.to - self.from) / (to_mm - from_mm);
        Along { at_zero: self.from - per_mm * from_mm, per_mm }
    }

    fn in_rad(self) -> Self {
        Self { from: rad_from_deg(self.from), to: rad_from_deg(self.to) }
    }
}

impl<'de> Deserialize<'de> for Ends {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(EndsVisitor)
    }
}

struct EndsVisitor;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TwoEnds {
    from: f64,
    to: f64,
}

impl<'de> Visitor<'de> for EndsVisitor {
    type Value = Ends;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, or {from: …, to: …}")
    }
    fn visit_f64<E>(self, value: f64) -> Result<Ends, E> {
        Ok(Ends { from: value, to: value })
    }
    fn visit_i64<E>(self, value: i64) -> Result<Ends, E> {
        Ok(Ends { from: value as f64, to: value as f64 })
    }
    fn visit_u64<E>(self, value: u64) -> Result<Ends, E> {
        Ok(Ends { from: value as f64, to: value as f64 })
    }
    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Ends, A::Error> {
        let TwoEnds { from, to } = TwoEnds::deserialize(serde::de::value::MapAccessDeserializer::new(map))?;
        Ok(Ends { from, to })
    }
}

/// A surface as understood.
#[derive(Debug, Clone)]
pub(super) struct ReadSurface {
    pub(super) surface: Surface,
    /// The lifts that it was made of, with the names of their profiles.
    pub(super) lifts: Vec<(String, ProfileLift)>,
    /// How a mesh was read, and from which file.
    pub(super) mesh: Option<(PathBuf, MeshReading)>,
}

impl From<Surface> for ReadSurface {
    fn from(surface: Surface) -> Self {
        Self { surface, lifts: Vec::new(), mesh: None }
    }
}

impl SurfaceFile {
    /// What a job writes. Each kind is read as a type of its own, and not as a variant that is told apart by its tag: that would lose the
    /// lines of what is wrong in it.
    pub(super) fn of(document: &Document) -> Result<Self, ConfigError> {
        fn only<S: DeserializeOwned>(document: &Document) -> Result<S, ConfigError> {
            document.read::<Only<S>>().map(|only| only.surface)
        }
        match document.text_at("surface.kind") {
            Some("cams") => only(document).map(Self::Cams),
            Some("cylinder") => only(document).map(Self::Cylinder),
            Some("eccentric") => only(document).map(Self::Eccentric),
            Some("elliptic_cone") => only(document).map(Self::EllipticCone),
            Some("lobed") => only(document).map(Self::Lobed),
            Some("grid") => only(document).map(Self::Grid),
            Some("mesh") => only(document).map(Self::Mesh),
            Some(other) => {
                let message = format!("surface.kind is {other:?}, it must be one of {KINDS}");
                Err(document.error("surface.kind", message))
            }
            None => Err(document.error("surface", format!("surface needs a kind, one of {KINDS}"))),
        }
    }

    /// The surface it means; every file that it names is added to `files`.
    pub(super) fn read(&self, document: &Document, files: &mut JobFiles) -> Result<ReadSurface, Vec<ConfigError>> {
        let (solid, from_mm, to_mm) = match self {
            Self::Cams(file) => return read_cams(document, file, files),
            Self::Grid(file) => return read_grid(document, file, files),
            Self::Mesh(file) => return read_mesh(document, file, files),
            Self::Cylinder(file) => (Solid::Cylinder { radius_mm: file.radius_mm }, file.from_mm, file.to_mm),
            Self::Eccentric(file) => {
                let azimuth_rad = rad_from_deg(file.azimuth_deg);
                let (radius_mm, eccentricity_mm) = (file.radius_mm, file.eccentricity_mm);
                (Solid::Eccentric { radius_mm, eccentricity_mm, azimuth_rad }, file.from_mm, file.to_mm)
            }
            Self::EllipticCone(file) => {
                let along = |ends: Ends| ends.along(file.from_mm, file.to_mm);
                let (first_mm, second_mm) = (along(file.first_mm), along(file.second_mm));
                let azimuth_rad = rad_from_deg(file.azimuth_deg);
                (Solid::EllipticCone { first_mm, second_mm, azimuth_rad }, file.from_mm, file.to_mm)
            }
            Self::Lobed(file) => {
                let along = |ends: Ends| ends.along(file.from_mm, file.to_mm);
                let harmonic = |wave: &WaveFile| Harmonic {
                    waves: wave.per_turn,
                    amplitude_mm: along(wave.amplitude_mm),
                    phase_rad: along(wave.phase_deg.in_rad()),
                };
                let harmonics = file.waves.iter().map(harmonic).collect();
                (Solid::Lobed { mean_mm: along(file.mean_mm), harmonics }, file.from_mm, file.to_mm)
            }
        };
        let surface = Surface::solid(solid, from_mm, to_mm)
            .map_err(|error| vec![document.error(solid_key(&error), error.to_string())])?;
        Ok(surface.into())
    }
}

/// A file that the surface names, as part of what the job is.
fn named(
    document: &Document,
    name: &str,
    extension: &str,
    most: u64,
    files: &mut JobFiles,
) -> Result<LocatedBytes, Vec<ConfigError>> {
    let located = (document.locate_bytes("surfaces", name, extension, most))
        .map_err(|error| vec![document.error("surface.file", error.to_string())])?;
    files.add("surfaces", name, &located.bytes);
    Ok(located)
}

fn read_grid(document: &Document, file: &GridFile, files: &mut JobFiles) -> Result<ReadSurface, Vec<ConfigError>> {
    let LocatedBytes { path, bytes } = named(document, &file.file, "csv", grid_text::MOST_BYTES, files)?;
    grid_text::read(&path, &bytes).map(ReadSurface::from)
}

fn read_mesh(document: &Document, file: &MeshFile, files: &mut JobFiles) -> Result<ReadSurface, Vec<ConfigError>> {
    let LocatedBytes { path, bytes } = named(document, &file.file, "stl", stl::MOST_BYTES, files)?;
    let mut triangles = stl::read(&path, &bytes).map_err(|error| vec![error])?;
    drop(bytes);
    for corner in triangles.iter_mut().flatten() {
        *corner = file.axis.turned(corner.map(|length| length * file.unit.mm()));
    }
    match surface_of(&triangles) {
        Ok((surface, reading)) => Ok(ReadSurface { surface, lifts: Vec::new(), mesh: Some((path, reading)) }),
        Err(error) => Err(vec![ConfigError::at(Place::file(&path), error.to_string())]),
    }
}

fn solid_key(error: &SurfaceError) -> &'static str {
    match error {
        SurfaceError::NoLength { .. } => "surface.to_mm",
        SurfaceError::BadNumber { what, .. } => match *what {
            "the z at which the part begins" => "surface.from_mm",
            "the z at which the part ends" => "surface.to_mm",
            "the radius of the cylinder" | "the radius of the eccentric" => "surface.radius_mm",
            "the eccentricity" => "surface.eccentricity_mm",
            "the azimuth of the eccentric" | "the azimuth of the first half axis" => "surface.azimuth_deg",
            "the first half axis" => "surface.first_mm",
            "the second half axis" => "surface.second_mm",
            "the mean radius" => "surface.mean_mm",
            _ => "surface.waves",
        },
        SurfaceError::Count { .. } => "surface.waves",
        _ => "surface",
    }
}

fn read_cams(document: &Document, file: &CamsFile, files: &mut JobFiles) -> Result<ReadSurface, Vec<ConfigError>> {
    const PROFILES: &str = "surface.profiles";
    let CamsFile { profiles, cams, .. } = file;
    let mut findings: Vec<ConfigError> = profile_file::findings(PROFILES, profiles)
        .into_iter()
        .map(|(key, message)| document.error(&key, message))
        .collect();
    let (mut contours, mut lifts) = (Vec::new(), Vec::new());
    for (index, profile) in profiles.iter().enumerate() {
        if profile.gauge().is_some() {
            let key = format!("{PROFILES}.{index}.gauge");
            let message =
                format!("profile {}: gauge is about lobes that are ground; a turned part has none", profile.name);
            findings.push(document.error(&key, message));
        }
        match profile.read(document, PROFILES, index, files) {
            Ok((spec, lift)) => match Contour::from_lift(&spec.lift, &spec.follower, spec.base_radius_mm) {
                Ok(contour) => {
                    contours.push(Some(contour));
                    lifts.push((spec.name, lift));
                }
                Err(error) => {
                    let key = format!("{PROFILES}.{index}.{}", contour_key(&error));
                    findings.push(document.error(&key, format!("profile {}: {error}", spec.name)));
                    contours.push(None);
                }
            },
            Err(errors) => {
                findings.extend(errors);
                contours.push(None);
            }
        }
    }
    let mut along = Vec::new();
    for (index, cam) in cams.iter().enumerate() {
        let Some(profile) = profiles.iter().position(|profile| profile.name == cam.profile) else {
            let known = profiles.iter().map(|profile| profile.name.as_str()).collect::<Vec<_>>().join(", ");
            let message = format!("there is no profile {}; the surface has {known}", cam.profile);
            findings.push(document.error(&format!("surface.cams.{index}.profile"), message));
            continue;
        };
        if let Some(contour) = &contours[profile] {
            let (phase_rad, from_mm, to_mm) = (rad_from_deg(cam.phase_deg), cam.from_mm, cam.to_mm);
            along.push(CamAlong { contour, phase_rad, from_mm, to_mm });
        }
    }
    if !findings.is_empty() {
        return Err(findings);
    }
    let surface =
        Surface::cams(&along).map_err(|error| vec![document.error(&cam_key(cams, &error), error.to_string())])?;
    Ok(ReadSurface { surface, lifts, mesh: None })
}

/// The key of the cam that the core refuses.
fn cam_key(cams: &[CamFile], error: &SurfaceError) -> String {
    let cam = |index: usize, key: &str| format!("surface.cams.{index}.{key}");
    let found = |is: &dyn Fn(&CamFile) -> bool| cams.iter().position(is);
    match error {
        SurfaceError::ZNotIncreasing { row, .. } => cam(*row, "from_mm"),
        SurfaceError::RoughCam { cam: index, .. } => cam(*index, "profile"),
        SurfaceError::NoLength { .. } => {
            found(&|cam| cam.to_mm <= cam.from_mm).map_or_else(|| "surface.cams".into(), |index| cam(index, "to_mm"))
        }
        SurfaceError::BadNumber { what, .. } => {
            let is_bad = |value: f64| !(value.is_finite() && value.abs() <= 1e5);
            let at = match *what {
                "the phase of a cam" => found(&|cam| is_bad(rad_from_deg(cam.phase_deg))).map(|i| cam(i, "phase_deg")),
                "the z at which a cam begins" => found(&|cam| is_bad(cam.from_mm)).map(|i| cam(i, "from_mm")),
                "the z at which a cam ends" => found(&|cam| is_bad(cam.to_mm)).map(|i| cam(i, "to_mm")),
                _ => None,
            };
            at.unwrap_or_else(|| "surface.cams".into())
        }
        _ => "surface.cams".into(),
    }
}

#[cfg(test)]
mod tests;
