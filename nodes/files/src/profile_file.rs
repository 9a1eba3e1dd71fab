//! A cam as a job writes it: base circle, follower and lift, or a lift that says the contour itself. Grinding jobs have one for each kind of
//! lobe, turning jobs one for each outline along the part, milling jobs one for each cam and for each groove in a plate.

use super::ConfigError;
use super::follower_file::FollowerFile;
use super::job_files::JobFiles;
use super::lift_file::{self, LiftFile, OfProfile, ProfileLift};
use super::names;
use super::yaml::Document;
use camwright::cam::contour::ContourError;
use camwright::cam::follower::Follower;
use camwright::job::grinding::ProfileSpec;
use serde::Deserialize;

/// `profiles[]` as written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProfileFile {
    pub(super) name: String,
    base_radius_mm: Option<f64>,
    follower: Option<FollowerFile>,
    gauge: Option<FollowerFile>,
    lift: LiftFile,
}

impl ProfileFile {
    /// What it is inspected with.
    pub(super) fn gauge(&self) -> Option<Follower> {
        self.gauge.as_ref().map(FollowerFile::follower)
    }

    /// What it means. `list` is the key of the list in which it stands.
    pub(super) fn read(
        &self,
        document: &Document,
        list: &str,
        index: usize,
        files: &mut JobFiles,
    ) -> Result<(ProfileSpec, ProfileLift), Vec<ConfigError>> {
        let given = self.follower.as_ref().map(FollowerFile::follower).zip(self.base_radius_mm);
        let of = OfProfile { document, key: &format!("{list}.{index}.lift"), name: &self.name, follower: given };
        let lift = lift_file::read(&self.lift, of, files)?;
        let (follower, base_radius_mm) = self.shape(&lift, given).map_err(|(key, message)| {
            vec![document.error(&format!("{list}.{index}.{key}"), format!("profile {}: {message}", self.name))]
        })?;
        let spec = ProfileSpec { name: self.name.clone(), lift: lift.law.clone(), follower, base_radius_mm };
        Ok((spec, lift))
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
                    Err((key, format!("{key} is given, and the lift says the contour itself; one of both must go")))
                }
            };
        }
        given.ok_or_else(|| {
            let missing = keys.into_iter().find(|(_, is_given)| !is_given).map_or("follower", |(key, _)| key);
            ("lift", format!("{missing} is missing, without which this lift says no contour"))
        })
    }
}

/// What can be said about single values of the profiles under a key, as key and message.
pub(super) fn findings(list: &str, profiles: &[ProfileFile]) -> Vec<(String, String)> {
    let mut findings = Vec::new();
    if profiles.is_empty() {
        findings.push((list.to_owned(), "the job has no profiles; it needs at least 1".to_owned()));
    }
    for (index, profile) in profiles.iter().enumerate() {
        let mut refuse = |key: &str, message: String| findings.push((format!("{list}.{index}.{key}"), message));
        let name = &profile.name;
        if let Some(message) = names::fault("profile", name) {
            refuse("name", message);
        }
        if profiles[..index].iter().any(|other| other.name == *name) {
            refuse("name", format!("there are two profiles named {name}; names must differ"));
        }
        if let Some(value) = profile.base_radius_mm.filter(|value| !(value.is_finite() && *value > 0.0)) {
            refuse(
                "base_radius_mm",
                format!("profile {name}: base_radius_mm is {value}; it must be a positive number"),
            );
        }
        let followers = [("follower", profile.follower.as_ref()), ("gauge", profile.gauge.as_ref())];
        for (which, follower) in followers.into_iter().filter_map(|(which, file)| Some((which, file?))) {
            let bad = |(_, value): &(_, f64)| !(value.is_finite() && *value > 0.0);
            for (key, value) in follower.arm_lengths().into_iter().filter(bad) {
                let message = format!("profile {name}: {which}: {key} is {value}; it must be a positive number");
                refuse(&format!("{which}.{key}"), message);
            }
        }
    }
    findings
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
        ContourError::Lift(_) | ContourError::FaceTurnsBack { .. } | ContourError::AxisOutside { .. } => "lift",
    }
}

#[cfg(test)]
mod tests;
