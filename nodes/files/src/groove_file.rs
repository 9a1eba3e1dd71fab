// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A groove as a milling job writes it, and the groove it means.

use super::ConfigError;
use super::job_files::JobFiles;
use super::lift_context::LiftContext;
use super::lift_file::{self, LiftFile, ProfileLift};
use super::names;
use super::profile_file::{contour_key, profile_named};
use super::yaml::Document;
use camwright::job::grinding::ProfileSpec;
use camwright::job::milling::{GrooveKind, MAX_STEPS, MilledGroove};
use camwright::math::units::rad_from_deg;
use camwright::toolpath::groove::GrooveError;
use camwright::toolpath::groove::barrel::BarrelGroove;
use camwright::toolpath::groove::plate::PlateGroove;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `grooves[]` as written. What belongs to one kind alone is refused with the other.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GrooveFile {
    /// Name of the groove, different from all cams and grooves.
    #[schemars(schema_with = "names::schema")]
    pub(super) name: String,
    /// Kind of the groove.
    kind: GrooveKindFile,
    /// Phase, as of a lobe.
    #[schemars(range(min = -1e5, max = 1e5))]
    #[serde(default)]
    phase_deg: f64,
    /// Depth from `top_mm` or from the cylinder.
    #[schemars(range(min = 1e-6, max = 1e4))]
    depth_mm: f64,
    /// Maximum depth of a step; steps are equal. Default: the depth.
    #[schemars(range(min = 1e-6, max = 1e4))]
    step_mm: Option<f64>,
    /// Plate: profile with a roller, whose base circle is that of the inner wall.
    profile: Option<String>,
    /// Plate: Z of the face. Default: 0.
    #[schemars(range(min = -1e5, max = 1e5))]
    top_mm: Option<f64>,
    /// Barrel: motion of the roller along +Z over the azimuth, as a profile's lift.
    lift: Option<LiftFile>,
    /// Barrel: radius of the roller.
    #[schemars(range(min = 1e-6, max = 1e4))]
    roller_radius_mm: Option<f64>,
    /// Barrel: radius of the cylinder.
    #[schemars(range(min = 1e-6, max = 1e4))]
    outer_radius_mm: Option<f64>,
    /// Barrel: Z of the roller at lift 0.
    #[schemars(range(min = -1e5, max = 1e5))]
    z_mm: Option<f64>,
    /// Barrel: the machine shifts the mill across, which a mill smaller than the roller needs for exact walls.
    /// Default: false.
    y_axis: Option<bool>,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum GrooveKindFile {
    /// In the face of a plate, along -Z, by a mill parallel to the part's axis.
    Plate,
    /// Round a cylinder, by a radial mill.
    Barrel,
}

/// Values of a groove that do not fit each other, as key and message.
pub(super) fn findings(groove: &GrooveFile, index: usize) -> Vec<(String, String)> {
    let mut findings = Vec::new();
    let name = &groove.name;
    let mut refuse = |key: &str, message: String| {
        findings.push((format!("grooves.{index}.{key}"), format!("groove {name}: {message}")));
    };
    let of_plates = [("profile", groove.profile.is_some()), ("top_mm", groove.top_mm.is_some())];
    let of_barrels = [
        ("lift", groove.lift.is_some()),
        ("roller_radius_mm", groove.roller_radius_mm.is_some()),
        ("outer_radius_mm", groove.outer_radius_mm.is_some()),
        ("z_mm", groove.z_mm.is_some()),
        ("y_axis", groove.y_axis.is_some()),
    ];
    let (kind, others, foreign, needed): (_, _, &[(&str, bool)], &[&str]) = match groove.kind {
        GrooveKindFile::Plate => ("plate", "barrel", &of_barrels, &["profile"]),
        GrooveKindFile::Barrel => {
            ("barrel", "plate", &of_plates, &["lift", "roller_radius_mm", "outer_radius_mm", "z_mm"])
        }
    };
    for (key, _) in foreign.iter().filter(|(_, given)| *given) {
        refuse(key, format!("{key} is about a groove of kind {others}; this one is of kind {kind}"));
    }
    let given = |key: &str| of_plates.iter().chain(&of_barrels).any(|(name, given)| *name == key && *given);
    for key in needed.iter().filter(|key| !given(key)) {
        refuse("kind", format!("a groove of kind {kind} needs {key}"));
    }
    if let Some(step) = groove.step_mm.filter(|step| groove.depth_mm / step > f64::from(MAX_STEPS)) {
        let steps = (groove.depth_mm / step).ceil();
        refuse(
            "step_mm",
            format!("step_mm is {step}, which takes {steps} steps down; at most {MAX_STEPS} are allowed"),
        );
    }
    if let Some(outer) = groove.outer_radius_mm.filter(|outer| groove.depth_mm >= *outer) {
        refuse("depth_mm", format!("depth_mm is {}; it must stay below outer_radius_mm, {outer}", groove.depth_mm));
    }
    findings
}

impl GrooveFile {
    /// Converts it to a groove with its own lift.
    pub(super) fn read(
        &self,
        document: &Document,
        index: usize,
        profiles: &[ProfileSpec],
        files: &mut JobFiles,
    ) -> Result<(MilledGroove, Option<ProfileLift>), Vec<ConfigError>> {
        let (kind, lift) = match self.kind {
            GrooveKindFile::Plate => (self.plate(document, index, profiles).map_err(|error| vec![error])?, None),
            GrooveKindFile::Barrel => {
                let (kind, lift) = self.barrel(document, index, files)?;
                (kind, Some(lift))
            }
        };
        let (name, step_mm) = (self.name.clone(), self.step_mm.unwrap_or(self.depth_mm));
        Ok((MilledGroove { name, kind, phase_rad: rad_from_deg(self.phase_deg), step_mm }, lift))
    }

    fn plate(&self, document: &Document, index: usize, profiles: &[ProfileSpec]) -> Result<GrooveKind, ConfigError> {
        let name = self.profile.as_deref().unwrap_or_default();
        let (at, profile) = profile_named(document, profiles, name, &format!("grooves.{index}.profile"))?;
        let groove = PlateGroove::new(&profile.lift, &profile.follower, profile.base_radius_mm).map_err(|error| {
            let key = match &error {
                GrooveError::NoRoller => "follower",
                GrooveError::InnerWall(error) => contour_key(error),
                _ => "base_radius_mm",
            };
            document.error(&format!("profiles.{at}.{key}"), format!("groove {}: profile {name}: {error}", self.name))
        })?;
        Ok(GrooveKind::Plate { groove, top_mm: self.top_mm.unwrap_or(0.0), depth_mm: self.depth_mm })
    }

    fn barrel(
        &self,
        document: &Document,
        index: usize,
        files: &mut JobFiles,
    ) -> Result<(GrooveKind, ProfileLift), Vec<ConfigError>> {
        let key = format!("grooves.{index}.lift");
        let needs =
            |key: &str| vec![document.error(&format!("grooves.{index}"), format!("groove {} needs {key}", self.name))];
        let file = self.lift.as_ref().ok_or_else(|| needs("lift"))?;
        let roller_radius_mm = self.roller_radius_mm.ok_or_else(|| needs("roller_radius_mm"))?;
        let outer_radius_mm = self.outer_radius_mm.ok_or_else(|| needs("outer_radius_mm"))?;
        let z_mm = self.z_mm.ok_or_else(|| needs("z_mm"))?;
        let of = LiftContext { document, key: &key, name: &self.name, follower: None, before: &[] };
        let lift = lift_file::read(file, of, files)?;
        if lift.throw_mm > 0.0 {
            return Err(of.refuse("", "a crank pin lifts no follower; a groove needs the lift of one"));
        }
        let groove = BarrelGroove::new(&lift.law, roller_radius_mm, outer_radius_mm, outer_radius_mm - self.depth_mm)
            .map_err(|error| vec![document.error(&key, format!("groove {}: {error}", self.name))])?;
        Ok((GrooveKind::Barrel { groove, z_mm, y_axis: self.y_axis.unwrap_or(false) }, lift))
    }
}
