// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The surface of a part that is turned: what a job writes under `surface`, and the shape it means.

use super::grid_text;
use super::job_files::JobFiles;
use super::lift_file::ProfileLift;
use super::locate::LocatedBytes;
use super::profile_file::{self, ProfileFile, contour_key};
use super::stl;
use super::yaml::Document;
use super::{ConfigError, FileLocation};
use camwright::cam::lift::LengthUnit;
use camwright::cam::surface::cams::CamAlong;
use camwright::cam::surface::mesh::{MeshReading, surface_of};
use camwright::cam::surface::solid::{Harmonic, LinearInZ, Solid};
use camwright::cam::surface::{Surface, SurfaceError, SurfaceKey};
use camwright::math::units::rad_from_deg;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserializer, Visitor};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt;
use std::path::PathBuf;

/// `surface` as written, by its `kind`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum SurfaceFile {
    /// Cams along the part; between two of them the radius follows a 3-4-5 polynomial.
    Cams {
        /// Shapes of the cams, as in grinding jobs, without `gauge`.
        #[schemars(length(min = 1, max = 100))]
        profiles: Vec<ProfileFile>,
        /// Cams in the order of the part.
        #[schemars(length(min = 1, max = 100))]
        cams: Vec<SurfaceCamFile>,
    },
    /// Cylinder about the axis.
    Cylinder {
        /// Z of the part at which the surface begins.
        from_mm: f64,
        /// Z of the part at which the surface ends.
        to_mm: f64,
        /// Radius.
        radius_mm: f64,
    },
    /// Cylinder beside the axis.
    Eccentric {
        /// Z of the part at which the surface begins.
        from_mm: f64,
        /// Z of the part at which the surface ends.
        to_mm: f64,
        /// Radius.
        radius_mm: f64,
        /// Distance of its centre from the axis.
        eccentricity_mm: f64,
        /// Direction of the centre, or of the first half axis.
        #[serde(default)]
        azimuth_deg: f64,
    },
    /// Ellipse whose half axes change evenly along the part.
    EllipticCone {
        /// Z of the part at which the surface begins.
        from_mm: f64,
        /// Z of the part at which the surface ends.
        to_mm: f64,
        /// First half axis: a number, or `{from: 24.0, to: 22.0}` at the two ends.
        first_mm: Ends,
        /// Second half axis.
        second_mm: Ends,
        /// Direction of the centre, or of the first half axis.
        #[serde(default)]
        azimuth_deg: f64,
    },
    /// Mean radius with waves: r = mean + sum of amplitude * `cos(per_turn` * azimuth - phase).
    Lobed {
        /// Z of the part at which the surface begins.
        from_mm: f64,
        /// Z of the part at which the surface ends.
        to_mm: f64,
        /// Mean radius: a number, or `{from: 24.0, to: 22.0}` at the two ends.
        mean_mm: Ends,
        /// Waves.
        #[schemars(length(max = 256))]
        waves: Vec<WaveFile>,
    },
    /// Radii in a table over azimuth and Z.
    Grid {
        /// Table (`.csv`) or triangles (`.stl`), by name or path.
        file: String,
    },
    /// Triangles of an STL file.
    Mesh {
        /// Table (`.csv`) or triangles (`.stl`), by name or path.
        file: String,
        /// Unit of the file.
        unit: LengthFile,
        /// Axis of the part in the file; the next of x, y, z, x points to the keyway.
        #[serde(default)]
        axis: AxisFile,
    },
}

/// Unit of lengths in a file that states none.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum LengthFile {
    /// Millimetre.
    Mm,
    /// Inch.
    Inch,
    /// Metre.
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

/// Which axis of a file is that of the part; the next one, in the order x, y, z, x, points to the keyway.
#[derive(Debug, Default, Clone, Copy, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum AxisFile {
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

impl JsonSchema for AxisFile {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        "AxisFile".into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        // To YAML 1.1 a bare y is a yes.
        json_schema!({"type": ["string", "boolean"], "enum": ["x", "y", "z", true]})
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
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SurfaceCamFile {
    /// Name of its profile.
    profile: String,
    /// Azimuth of its cam angle 0.
    #[serde(default)]
    phase_deg: f64,
    /// Z of the part at which the cam begins.
    from_mm: f64,
    /// Z of the part at which the cam ends.
    to_mm: f64,
}

/// One wave of a lobed part.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WaveFile {
    /// Waves of a turn.
    #[schemars(range(min = 1, max = 720))]
    per_turn: u32,
    /// Amplitude: a number, or `{from: 0.1, to: 0.2}` at the two ends.
    amplitude_mm: Ends,
    /// Phase: a number, or `{from: 0.0, to: 30.0}` at the two ends.
    #[serde(default)]
    phase_deg: Ends,
}

/// A number that changes evenly from one end of the part to the other: `24.0`, or `{from: 24.0, to: 22.0}`.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(untagged)]
pub(super) enum Ends {
    /// The same everywhere.
    Everywhere(f64),
    /// From one end to the other.
    FromTo(FromTo),
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FromTo {
    /// Value at the first end.
    from: f64,
    /// Value at the second end.
    to: f64,
}

impl Default for Ends {
    fn default() -> Self {
        Self::Everywhere(0.0)
    }
}

impl Ends {
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        match self {
            Self::Everywhere(value) => Self::Everywhere(f(value)),
            Self::FromTo(FromTo { from, to }) => Self::FromTo(FromTo { from: f(from), to: f(to) }),
        }
    }

    fn along(self, from_mm: f64, to_mm: f64) -> LinearInZ {
        let FromTo { from, to } = match self {
            Self::Everywhere(value) => FromTo { from: value, to: value },
            Self::FromTo(ends) => ends,
        };
        // Equal ends are constant, whatever the length.
        if from.to_bits() == to.to_bits() {
            return LinearInZ::constant(from);
        }
        let per_mm = (to - from) / (to_mm - from_mm);
        LinearInZ { at_zero: from - per_mm * from_mm, per_mm }
    }
}

/// A surface as understood.
#[derive(Debug, Clone)]
pub(super) struct ReadSurface {
    pub(super) surface: Surface,
    /// The lifts that it was made of, with the names of their profiles.
    pub(super) lifts: Vec<(String, ProfileLift)>,
    /// Fidelity of the reading of a mesh, and its file.
    pub(super) mesh: Option<(PathBuf, MeshReading)>,
}

impl From<Surface> for ReadSurface {
    fn from(surface: Surface) -> Self {
        Self { surface, lifts: Vec::new(), mesh: None }
    }
}

impl SurfaceFile {
    /// Reads the surface; every file that it names is added to `files`.
    pub(super) fn read(&self, document: &Document, files: &mut JobFiles) -> Result<ReadSurface, Vec<ConfigError>> {
        let (solid, from_mm, to_mm) = match self {
            Self::Cams { profiles, cams } => return read_cams(document, profiles, cams, files),
            Self::Grid { file } => return read_grid(document, file, files),
            Self::Mesh { file, unit, axis } => return read_mesh(document, file, *unit, *axis, files),
            &Self::Cylinder { from_mm, to_mm, radius_mm } => (Solid::Cylinder { radius_mm }, from_mm, to_mm),
            &Self::Eccentric { from_mm, to_mm, radius_mm, eccentricity_mm, azimuth_deg } => {
                let azimuth_rad = rad_from_deg(azimuth_deg);
                (Solid::Eccentric { radius_mm, eccentricity_mm, azimuth_rad }, from_mm, to_mm)
            }
            &Self::EllipticCone { from_mm, to_mm, first_mm, second_mm, azimuth_deg } => {
                let (first_mm, second_mm) = (first_mm.along(from_mm, to_mm), second_mm.along(from_mm, to_mm));
                (Solid::EllipticCone { first_mm, second_mm, azimuth_rad: rad_from_deg(azimuth_deg) }, from_mm, to_mm)
            }
            Self::Lobed { from_mm, to_mm, mean_mm, waves } => {
                let along = |ends: Ends| ends.along(*from_mm, *to_mm);
                let harmonic = |wave: &WaveFile| Harmonic {
                    waves: wave.per_turn,
                    amplitude_mm: along(wave.amplitude_mm),
                    phase_rad: along(wave.phase_deg.map(rad_from_deg)),
                };
                let harmonics = waves.iter().map(harmonic).collect();
                (Solid::Lobed { mean_mm: along(*mean_mm), harmonics }, *from_mm, *to_mm)
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
    max: u64,
    files: &mut JobFiles,
) -> Result<LocatedBytes, Vec<ConfigError>> {
    let located = (document.locate_bytes("surfaces", name, extension, max))
        .map_err(|error| vec![document.error("surface.file", error.to_string())])?;
    files.add("surfaces", name, &located.bytes);
    Ok(located)
}

fn read_grid(document: &Document, file: &str, files: &mut JobFiles) -> Result<ReadSurface, Vec<ConfigError>> {
    let LocatedBytes { path, bytes } = named(document, file, "csv", grid_text::MAX_BYTES, files)?;
    grid_text::read(&path, &bytes).map(ReadSurface::from)
}

fn read_mesh(
    document: &Document,
    file: &str,
    unit: LengthFile,
    axis: AxisFile,
    files: &mut JobFiles,
) -> Result<ReadSurface, Vec<ConfigError>> {
    let LocatedBytes { path, bytes } = named(document, file, "stl", stl::MAX_BYTES, files)?;
    let mut triangles = stl::read(&path, &bytes).map_err(|error| vec![error])?;
    drop(bytes);
    for corner in triangles.iter_mut().flatten() {
        *corner = axis.turned(corner.map(|length| length * unit.mm()));
    }
    match surface_of(&triangles) {
        Ok((surface, reading)) => Ok(ReadSurface { surface, lifts: Vec::new(), mesh: Some((path, reading)) }),
        Err(error) => Err(vec![ConfigError::at(FileLocation::file(&path), error.to_string())]),
    }
}

fn solid_key(error: &SurfaceError) -> &'static str {
    match error {
        SurfaceError::NoLength { .. } => "surface.to_mm",
        SurfaceError::BadNumber { what, .. } => match what {
            SurfaceKey::Begin => "surface.from_mm",
            SurfaceKey::End => "surface.to_mm",
            SurfaceKey::CylinderRadius | SurfaceKey::EccentricRadius => "surface.radius_mm",
            SurfaceKey::Eccentricity => "surface.eccentricity_mm",
            SurfaceKey::EccentricAzimuth | SurfaceKey::HalfAxisAzimuth => "surface.azimuth_deg",
            SurfaceKey::FirstHalfAxis => "surface.first_mm",
            SurfaceKey::SecondHalfAxis => "surface.second_mm",
            SurfaceKey::MeanRadius => "surface.mean_mm",
            _ => "surface.waves",
        },
        SurfaceError::Count { .. } => "surface.waves",
        _ => "surface",
    }
}

fn read_cams(
    document: &Document,
    profiles: &[ProfileFile],
    cams: &[SurfaceCamFile],
    files: &mut JobFiles,
) -> Result<ReadSurface, Vec<ConfigError>> {
    const PROFILES: &str = "surface.profiles";
    let mut findings: Vec<ConfigError> = profile_file::findings(PROFILES, profiles)
        .into_iter()
        .map(|(key, message)| document.error(&key, message))
        .collect();
    let (mut contours, mut lifts, mut specs) = (Vec::new(), Vec::new(), Vec::new());
    for (index, profile) in profiles.iter().enumerate() {
        if profile.gauge().is_some() {
            let key = format!("{PROFILES}.{index}.gauge");
            let message = format!("profile {}: gauge is for ground lobes; remove it from a turned part", profile.name);
            findings.push(document.error(&key, message));
        }
        match profile.read(document, (PROFILES, index), &specs, files) {
            Ok((spec, _)) if spec.is_pin() => {
                let key = format!("{PROFILES}.{index}.lift");
                findings.extend(profile_file::refuse_ground(document, &key, &spec).err());
                contours.push(None);
            }
            Ok((spec, lift)) => match spec.contour() {
                Ok(contour) => {
                    contours.push(Some(contour));
                    lifts.push((spec.name.clone(), lift));
                    specs.push(spec);
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
fn cam_key(cams: &[SurfaceCamFile], error: &SurfaceError) -> String {
    let cam = |index: usize, key: &str| format!("surface.cams.{index}.{key}");
    let found = |is: &dyn Fn(&SurfaceCamFile) -> bool| cams.iter().position(is);
    match error {
        SurfaceError::ZNotIncreasing { row, .. } => cam(*row, "from_mm"),
        SurfaceError::RoughCam { cam: index, .. } => cam(*index, "profile"),
        SurfaceError::NoLength { .. } => {
            found(&|cam| cam.to_mm <= cam.from_mm).map_or_else(|| "surface.cams".into(), |index| cam(index, "to_mm"))
        }
        SurfaceError::BadNumber { what, .. } => {
            let is_bad = |value: f64| !(value.is_finite() && value.abs() <= 1e5);
            let at = match what {
                SurfaceKey::CamPhase => found(&|cam| is_bad(rad_from_deg(cam.phase_deg))).map(|i| cam(i, "phase_deg")),
                SurfaceKey::CamBegin => found(&|cam| is_bad(cam.from_mm)).map(|i| cam(i, "from_mm")),
                SurfaceKey::CamEnd => found(&|cam| is_bad(cam.to_mm)).map(|i| cam(i, "to_mm")),
                _ => None,
            };
            at.unwrap_or_else(|| "surface.cams".into())
        }
        _ => "surface.cams".into(),
    }
}

#[cfg(test)]
mod tests;
