// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A cam as a job writes it: base circle, follower and lift, or a lift that says the contour itself. Grinding jobs have one for each kind of
//! lobe, turning jobs one for each outline along the part, milling jobs one for each cam and for each groove in a plate.

use super::ConfigError;
use super::follower_file::FollowerFile;
use super::job_files::JobFiles;
use super::lift_context::LiftContext;
use super::lift_file::{self, LiftFile, ProfileLift};
use super::names;
use super::yaml::Document;
use camwright::cam::contour::ContourError;
use camwright::cam::follower::Follower;
use camwright::job::grinding::ProfileSpec;
use schemars::JsonSchema;
use serde::Deserialize;

/// `profiles[]` as written.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ProfileFile {
    /// Name of the profile.
    #[schemars(schema_with = "names::schema")]
    pub(super) name: String,
    /// Radius of the base circle. Not with a lift that defines the contour itself (an eccentric by its diameter,
    /// a crank pin, an outline, a polygon, tables of radii or points).
    #[schemars(range(min = 1e-6, max = 1e4))]
    base_radius_mm: Option<f64>,
    /// Follower that the lift belongs to. Not with a lift that defines the contour itself.
    follower: Option<FollowerFile>,
    /// Follower that inspects the lobes; `camwright plan` writes its readings. Default: no inspection.
    gauge: Option<FollowerFile>,
    /// Internal contour: the wall of a bore, ground with the wheel inside the part. Only in grinding jobs.
    #[serde(default)]
    internal: bool,
    /// Lift of the follower: exactly one of `table`, `half_table`, `opening_table` with `closing_table`,
    /// `segments`, `eccentric`, `crank_pin`, `outline`, `polygon`, `s_cam`, `conjugate_of`, `round: true`.
    lift: LiftFile,
}

impl ProfileFile {
    /// Follower of its inspection.
    pub(super) fn gauge(&self) -> Option<Follower> {
        self.gauge.as_ref().map(FollowerFile::follower)
    }

    /// Converts it to a profile. `list` is the key of its list, `before` holds the profiles that stand before it there.
    pub(super) fn read(
        &self,
        document: &Document,
        (list, index): (&str, usize),
        before: &[ProfileSpec],
        files: &mut JobFiles,
    ) -> Result<(ProfileSpec, ProfileLift), Vec<ConfigError>> {
        let given = self.follower.as_ref().map(FollowerFile::follower).zip(self.base_radius_mm);
        let key = format!("{list}.{index}.lift");
        let of = LiftContext { document, key: &key, name: &self.name, follower: given, before, groove: None };
        let lift = lift_file::read(&self.lift, of, files)?;
        let (follower, base_radius_mm) = self.shape(&lift, given).map_err(|(key, message)| {
            vec![document.error(&format!("{list}.{index}.{key}"), format!("profile {}: {message}", self.name))]
        })?;
        if lift.throw_mm > 0.0 && self.gauge.is_some() {
            let message = "gauge is a follower that rides on the lobe about the spindle axis; a crank pin is measured about its own centre";
            return Err(vec![
                document.error(&format!("{list}.{index}.gauge"), format!("profile {}: {message}", self.name)),
            ]);
        }
        let refuse_internal = |message: &str| {
            Err(vec![document.error(&format!("{list}.{index}.internal"), format!("profile {}: {message}", self.name))])
        };
        if self.internal && lift.throw_mm > 0.0 {
            return refuse_internal("a crank pin is an outer contour; remove internal");
        }
        if self.internal && self.gauge.is_some() {
            return refuse_internal("gauge is a follower that rides on an outer contour; remove one of both");
        }
        let (name, law, throw_mm) = (self.name.clone(), lift.law.clone(), lift.throw_mm);
        Ok((ProfileSpec { name, lift: law, follower, base_radius_mm, throw_mm, is_bore: self.internal }, lift))
    }

    /// Follower and base radius (mm): those of the profile, or those of a lift that says the cam itself.
    fn shape(
        &self,
        lift: &ProfileLift,
        given: Option<(Follower, f64)>,
    ) -> Result<(Follower, f64), (&'static str, String)> {
        let keys = [("base_radius_mm", self.base_radius_mm.is_some()), ("follower", self.follower.is_some())];
        if let Some(own) = lift.own {
            return match keys.into_iter().find(|(_, is_given)| *is_given) {
                None => Ok(own),
                Some((key, _)) => {
                    Err((key, format!("{key} is given, but the lift defines the contour itself; remove one of both")))
                }
            };
        }
        given.ok_or_else(|| {
            let missing = keys.into_iter().find(|(_, is_given)| !is_given).map_or("follower", |(key, _)| key);
            ("lift", format!("{missing} is missing; this lift needs it to define a contour"))
        })
    }
}

/// A crank pin or an internal contour where the part is not ground: only a grinding wheel follows a pin round the axis, and only
/// grinding works inside of a part.
pub(super) fn refuse_ground(document: &Document, key: &str, spec: &ProfileSpec) -> Result<(), ConfigError> {
    let ProfileSpec { name, throw_mm, .. } = spec;
    let message = match () {
        () if spec.is_pin() => format!(
            "profile {name}: its centre lies {throw_mm} mm from the axis, outside of the disc; only a grinding job makes a crank pin"
        ),
        () if spec.is_bore => {
            format!("profile {name}: internal is true; only a grinding job makes an internal contour")
        }
        () => return Ok(()),
    };
    Err(document.error(key, message))
}

/// Names of profiles under a key that are not unique, as key and message.
pub(super) fn findings(list: &str, profiles: &[ProfileFile]) -> Vec<(String, String)> {
    let is_taken = |index: usize, name: &str| profiles[..index].iter().any(|other| other.name == name);
    let taken = profiles.iter().enumerate().filter(|(index, profile)| is_taken(*index, &profile.name));
    taken
        .map(|(index, ProfileFile { name, .. })| {
            (format!("{list}.{index}.name"), format!("there are two profiles named {name}; names must differ"))
        })
        .collect()
}

/// The key of a profile that is behind a refusal of its contour.
#[must_use]
pub fn contour_key(error: &ContourError) -> &'static str {
    match error {
        ContourError::BadBaseRadius { .. } | ContourError::Undercut { .. } | ContourError::PassesAxis { .. } => {
            "base_radius_mm"
        }
        ContourError::Follower(_) | ContourError::ReachesPivot { .. } | ContourError::ContactStrays { .. } => {
            "follower"
        }
        ContourError::Lift(_)
        | ContourError::FaceTurnsBack { .. }
        | ContourError::AxisOutside { .. }
        | ContourError::BadThrow { .. }
        | ContourError::PinWithLift { .. }
        | ContourError::BoreWithThrow { .. } => "lift",
    }
}

/// Returns the profile that a key names, with its index.
///
/// # Errors
/// No profile of this name.
pub(super) fn profile_named<'a>(
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

#[cfg(test)]
mod tests;
