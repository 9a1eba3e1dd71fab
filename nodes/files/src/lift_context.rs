// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Profile and file of a lift, for its errors and units.

use super::ConfigError;
use super::follower_file::mm_per_deg;
use super::yaml::Document;
use camwright::cam::follower::Follower;
use camwright::job::grinding::ProfileSpec;

/// The profile that a lift belongs to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LiftContext<'a> {
    pub document: &'a Document,
    /// Key path of its `lift`, for example `profiles.0.lift`; empty if the document is a lift only.
    pub key: &'a str,
    /// Name of the profile; empty where only the table is looked at.
    pub name: &'a str,
    /// Its follower and the radius of its base circle (mm); none where only the table is looked at.
    pub follower: Option<(Follower, f64)>,
    /// Profiles that stand before it in the file.
    pub before: &'a [ProfileSpec],
    /// Of a groove; `None` of a profile.
    pub groove: Option<GrooveContext>,
}

/// Particulars of the lift of a groove.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GrooveContext {
    /// Turns of the part over which the lift runs.
    pub turns: u32,
    /// Arc of a degree of the turret (mm); `None` for a roller on a slide.
    pub mm_per_deg: Option<f64>,
}

impl LiftContext<'_> {
    /// Arc of a degree of the follower's arm (mm); `None` for a follower on a slide.
    pub(super) fn mm_per_deg(&self) -> Option<f64> {
        match self.groove {
            Some(groove) => groove.mm_per_deg,
            None => mm_per_deg(self.follower?.0),
        }
    }

    /// Turns of the part over which the lift runs.
    pub(super) fn turns(&self) -> u32 {
        self.groove.map_or(1, |groove| groove.turns)
    }

    pub(super) fn key(&self, name: &str) -> String {
        match (self.key, name) {
            ("", name) => name.to_owned(),
            (key, "") => key.to_owned(),
            (key, name) => format!("{key}.{name}"),
        }
    }

    /// A refusal of the value at a key of the lift; of the lift itself where the key is empty.
    pub(super) fn refuse(&self, name: &str, message: impl std::fmt::Display) -> Vec<ConfigError> {
        let kind = if self.groove.is_some() { "groove" } else { "profile" };
        let profile = if self.name.is_empty() { String::new() } else { format!("{kind} {}: ", self.name) };
        vec![self.document.error(&self.key(name), format!("{profile}{message}"))]
    }
}
