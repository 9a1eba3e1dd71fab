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
}

impl LiftContext<'_> {
    /// Arc of a degree of the follower's arm (mm); `None` for a follower on a slide.
    pub(super) fn mm_per_deg(&self) -> Option<f64> {
        mm_per_deg(self.follower?.0)
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
        let profile = if self.name.is_empty() { String::new() } else { format!("profile {}: ", self.name) };
        vec![self.document.error(&self.key(name), format!("{profile}{message}"))]
    }
}
