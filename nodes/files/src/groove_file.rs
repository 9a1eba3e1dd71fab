// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A groove as a milling job writes it, and the groove it means.

use super::ConfigError;
use super::job_files::JobFiles;
use super::lift_context::{GrooveContext, LiftContext};
use super::lift_file::{self, LiftFile, ProfileLift};
use super::names;
use super::profile_file::{contour_key, profile_named};
use super::yaml::Document;
use camwright::job::grinding::ProfileSpec;
use camwright::job::milling::{GrooveKind, MAX_STEPS, MilledGroove};
use camwright::math::units::rad_from_deg;
use camwright::toolpath::groove::GrooveError;
use camwright::toolpath::groove::barrel::{BarrelGroove, EndFaces};
use camwright::toolpath::groove::course::{GrooveCourse, Turret};
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
    /// Barrel: motion of the roller along +Z over the azimuth, as a profile's lift. Over several turns, and of an open groove, by
    /// segments.
    lift: Option<LiftFile>,
    /// Barrel: turns of the part over which the lift runs; its segments together make 360 times as many degrees. Default: 1.
    #[schemars(range(min = 1, max = 50))]
    turns: Option<u32>,
    /// Barrel: the groove has two ends beyond the end faces, and its lift need not close. Needs `from_mm` and `to_mm`. Default: false.
    open: Option<bool>,
    /// Barrel: the groove may cross itself. The follower must be long enough to find its way over the crossing. Needs several `turns`.
    /// Default: false.
    may_cross: Option<bool>,
    /// Barrel: radius of the roller.
    #[schemars(range(min = 1e-6, max = 1e4))]
    roller_radius_mm: Option<f64>,
    /// Barrel: radius of the cylinder.
    #[schemars(range(min = 1e-6, max = 1e4))]
    outer_radius_mm: Option<f64>,
    /// Barrel: Z of the end face of the cylinder towards -Z. Needs `to_mm`. Default: unknown.
    #[schemars(range(min = -1e5, max = 1e5))]
    from_mm: Option<f64>,
    /// Barrel: Z of the end face of the cylinder towards +Z. Needs `from_mm`. Default: unknown.
    #[schemars(range(min = -1e5, max = 1e5))]
    to_mm: Option<f64>,
    /// Barrel: turret that carries the rollers of an indexing cam, with its axis parallel to those of the rollers. The lift is the arc of a
    /// roller's centre, `rise_deg` the angle of the turret. Needs `y_axis`, `from_mm` and `to_mm`. Default: the roller is on a slide.
    turret: Option<TurretFile>,
    /// Barrel: Z of the roller at lift 0; with a turret Z of its axis.
    #[schemars(range(min = -1e5, max = 1e5))]
    z_mm: Option<f64>,
    /// Barrel: the machine shifts the mill across, which a mill smaller than the roller needs for exact walls.
    /// Default: false.
    y_axis: Option<bool>,
}

/// `turret` of a groove as written.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct TurretFile {
    /// Number of rollers.
    #[schemars(range(min = 2, max = 1000))]
    stations: u32,
    /// Distance of a roller's centre from the turret's axis.
    #[schemars(range(min = 1e-6, max = 1e4))]
    radius_mm: f64,
    /// Y of the turret's axis: its distance from the part's axis, positive towards growing azimuth.
    #[schemars(range(min = -1e4, max = 1e4))]
    axis_y_mm: f64,
    /// Angle of the roller at lift 0, from the line through both axes towards +Z. Default: 0.
    #[schemars(range(min = -90.0, max = 90.0))]
    #[serde(default)]
    start_deg: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum GrooveKindFile {
    /// In the face of a plate, along -Z, by a mill parallel to the part's axis.
    Plate,
    /// Round a cylinder, by a radial mill.
    Barrel,
    /// Not supported: a groove in a hollow blank, for the radial rollers of a turret.
    Globoid,
}

/// Refusal of a globoid cam, with what is supported.
const GLOBOID: &str = "globoid cams are not supported: their mill swings about the axis of the turret; supported are grooves round a \
                       cylinder, also for a turret with rollers parallel to its axis: kind barrel with `turret`";

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
        ("turns", groove.turns.is_some()),
        ("open", groove.open.is_some()),
        ("may_cross", groove.may_cross.is_some()),
        ("from_mm", groove.from_mm.is_some()),
        ("to_mm", groove.to_mm.is_some()),
        ("turret", groove.turret.is_some()),
        ("z_mm", groove.z_mm.is_some()),
        ("y_axis", groove.y_axis.is_some()),
    ];
    let (kind, others, foreign, needed): (_, _, &[(&str, bool)], &[&str]) = match groove.kind {
        GrooveKindFile::Plate => ("plate", "barrel", &of_barrels, &["profile"]),
        GrooveKindFile::Barrel => {
            ("barrel", "plate", &of_plates, &["lift", "roller_radius_mm", "outer_radius_mm", "z_mm"])
        }
        GrooveKindFile::Globoid => {
            refuse("kind", GLOBOID.to_owned());
            return findings;
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
    if groove.kind != GrooveKindFile::Barrel {
        return findings;
    }
    match (groove.from_mm, groove.to_mm) {
        (Some(from), Some(to)) if from >= to => {
            refuse("to_mm", format!("to_mm is {to}; it must be above from_mm, {from}"));
        }
        (Some(_), None) => refuse("from_mm", "from_mm needs to_mm, the other end face".to_owned()),
        (None, Some(_)) => refuse("to_mm", "to_mm needs from_mm, the other end face".to_owned()),
        (None, None) if groove.open == Some(true) => {
            refuse("open", "an open groove needs the end faces of the cylinder, from_mm and to_mm".to_owned());
        }
        (None, None) if groove.turret.is_some() => {
            refuse("turret", "a turret needs the end faces of the cylinder, from_mm and to_mm".to_owned());
        }
        _ => {}
    }
    if groove.turret.is_some() && groove.y_axis != Some(true) {
        let key = if groove.y_axis.is_some() { "y_axis" } else { "turret" };
        refuse(key, GrooveError::TurretNeedsY.to_string());
    }
    if groove.may_cross.is_some() && (groove.turns.unwrap_or(1) == 1 || groove.turret.is_some()) {
        refuse("may_cross", "may_cross is about a groove of several turns for a follower on a slide".to_owned());
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
            GrooveKindFile::Barrel => self.barrel(document, index, files)?,
            GrooveKindFile::Globoid => {
                let message = format!("groove {}: {GLOBOID}", self.name);
                return Err(vec![document.error(&format!("grooves.{index}.kind"), message)]);
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
    ) -> Result<(GrooveKind, Option<ProfileLift>), Vec<ConfigError>> {
        let key = format!("grooves.{index}.lift");
        let needs =
            |key: &str| vec![document.error(&format!("grooves.{index}"), format!("groove {} needs {key}", self.name))];
        let file = self.lift.as_ref().ok_or_else(|| needs("lift"))?;
        let roller_radius_mm = self.roller_radius_mm.ok_or_else(|| needs("roller_radius_mm"))?;
        let outer_radius_mm = self.outer_radius_mm.ok_or_else(|| needs("outer_radius_mm"))?;
        let z_mm = self.z_mm.ok_or_else(|| needs("z_mm"))?;
        let turns = self.turns.unwrap_or(1);
        let mm_per_deg = self.turret.map(|turret| rad_from_deg(1.0) * turret.radius_mm);
        let groove = Some(GrooveContext { turns, mm_per_deg });
        let of = LiftContext { document, key: &key, name: &self.name, follower: None, before: &[], groove };
        let refuse = |key: &str, error: GrooveError| {
            vec![document.error(&format!("grooves.{index}.{key}"), format!("groove {}: {error}", self.name))]
        };
        let (course, lift) = if self.open == Some(true) {
            let program = lift_file::read_open(file, of)?;
            (GrooveCourse::open(program).map_err(|error| refuse("open", error))?, None)
        } else {
            let lift = lift_file::read(file, of, files)?;
            if lift.throw_mm > 0.0 {
                return Err(of.refuse("", "a crank pin lifts no follower; a groove needs the lift of one"));
            }
            (GrooveCourse::closed(&lift.law, turns).map_err(|error| refuse("turns", error))?, Some(lift))
        };
        let course = match self.turret {
            None => course,
            Some(turret) => {
                let turret = Turret {
                    stations: turret.stations,
                    radius_mm: turret.radius_mm,
                    axis_y_mm: turret.axis_y_mm,
                    start_rad: rad_from_deg(turret.start_deg),
                };
                course.on_turret(turret).map_err(|error| {
                    let key = if matches!(error, GrooveError::Stations { .. }) { "lift.segments" } else { "turret" };
                    refuse(key, error)
                })?
            }
        };
        let faces = self.from_mm.zip(self.to_mm);
        let faces = faces.map(|(from_mm, to_mm)| EndFaces { from_mm, to_mm, zero_mm: z_mm });
        let radii_mm = (outer_radius_mm, outer_radius_mm - self.depth_mm);
        let groove = BarrelGroove::along(course, roller_radius_mm, radii_mm, faces).map_err(|error| {
            let key = match error {
                GrooveError::LeavesCylinder { .. } => "z_mm",
                GrooveError::BesideCylinder { .. } => "turret",
                _ => "lift",
            };
            refuse(key, error)
        })?;
        groove.check_turns(self.may_cross.unwrap_or(false)).map_err(|error| refuse("lift", error))?;
        Ok((GrooveKind::Barrel { groove, z_mm, y_axis: self.y_axis.unwrap_or(false) }, lift))
    }
}
