// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! First lobe and dry run, set by a job file or by the client of a job.

use super::ConfigError;
use super::yaml::Document;
use camwright::job::grinding::LobeSpec;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Name of a lobe, or its number from 1 in the order in which they are ground.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(untagged)]
pub(super) enum StartLobeFile {
    Number(usize),
    Name(String),
}

/// The wheel is so much farther out than it would grind.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DryRunFile {
    /// Distance by which X stays farther out. The wheel must clear stock and `clearance_mm`.
    #[schemars(range(min = 1e-6, max = 1e4))]
    pub(super) stand_off_mm: f64,
}

impl StartLobeFile {
    /// Index of the lobe; `None` for the beginning with a new part.
    pub(super) fn index(&self, document: &Document, lobes: &[LobeSpec]) -> Result<Option<usize>, ConfigError> {
        // The name of a wide lobe is that of its first plunge, the name of one with several wheels that of its first visit.
        let is_named = |lobe: &LobeSpec, name: &str| {
            lobe.name == name
                || lobe.plunge.as_ref().is_some_and(|plunge| plunge.lobe == name)
                || lobe.visit.as_ref().is_some_and(|visit| visit.lobe == name)
        };
        let named = |name: &str| lobes.iter().position(|lobe| is_named(lobe, name));
        let numbered = |number: usize| number.checked_sub(1).filter(|index| *index < lobes.len());
        let found = match self {
            StartLobeFile::Number(0) => return Ok(None),
            StartLobeFile::Name(name) if name.is_empty() => return Ok(None),
            StartLobeFile::Number(number) => named(&number.to_string()).or_else(|| numbered(*number)),
            StartLobeFile::Name(name) => named(name).or_else(|| name.parse().ok().and_then(numbered)),
        };
        let text = match self {
            StartLobeFile::Number(number) => number.to_string(),
            StartLobeFile::Name(name) => name.clone(),
        };
        let names = || lobes.iter().map(|lobe| lobe.name.as_str()).collect::<Vec<_>>().join(", ");
        found.map(Some).ok_or_else(|| {
            document.error("start_at", format!("unknown start lobe {text:?}; the lobes are {}", names()))
        })
    }
}
