// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Values of the factors of a study: lists, ranges and random distributions, as written.

use super::ConfigError;
use super::yaml::{Document, YamlNode, YamlValue};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Maximum number of values of a factor.
const MAX_LEVELS: u32 = 1000;

/// Values of a factor: a list, or a range or distribution.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum FactorFile {
    /// Values one by one.
    List(#[schemars(length(min = 1, max = MAX_LEVELS))] Vec<serde_json::Value>),
    Range(RangeFile),
}

/// Range, distribution or list of a factor.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RangeFile {
    /// First value; of a uniform distribution the minimum.
    #[schemars(range(min = -1e12, max = 1e12))]
    from: Option<f64>,
    /// Last value, above `from`; of a uniform distribution the maximum.
    #[schemars(range(min = -1e12, max = 1e12))]
    to: Option<f64>,
    /// Number of values of a range, both ends included. Required with the designs `grid` and `one_at_a_time`.
    #[schemars(range(min = 2, max = MAX_LEVELS))]
    steps: Option<u32>,
    /// Spacing of the values. Default: linear.
    scale: Option<ScaleFile>,
    /// Values one by one, instead of a range.
    #[schemars(length(min = 1, max = MAX_LEVELS))]
    values: Option<Vec<serde_json::Value>>,
    /// Random distribution: each case draws a value of its own. Default: the design sets the value.
    random: Option<RandomFile>,
    /// Mean of a normal distribution.
    #[schemars(range(min = -1e12, max = 1e12))]
    mean: Option<f64>,
    /// Standard deviation of a normal distribution.
    #[schemars(range(min = 1e-12, max = 1e12))]
    deviation: Option<f64>,
    /// Value while `one_at_a_time` varies another factor. Default: the value of the job or machine file.
    #[serde(rename = "base")]
    _base: Option<serde_json::Value>,
}

/// Spacing of a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum ScaleFile {
    /// Equal differences.
    Linear,
    /// Equal ratios; `from` is above 0.
    Log,
}

/// Kind of a distribution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum RandomFile {
    /// Equally distributed from `from` to `to`.
    Uniform,
    /// Normally distributed with `mean` and `deviation`.
    Normal,
}

/// Values that a factor takes.
#[derive(Debug, Clone, PartialEq)]
pub enum FactorValues {
    /// Values one by one.
    Levels(Vec<YamlValue>),
    /// Values from one to another.
    Range { from: f64, to: f64, steps: Option<u32>, is_log: bool },
    /// Random value between two others.
    Uniform { from: f64, to: f64 },
    /// Normally distributed random value.
    Normal { mean: f64, deviation: f64 },
}

impl FactorValues {
    #[must_use]
    pub const fn is_random(&self) -> bool {
        matches!(self, Self::Uniform { .. } | Self::Normal { .. })
    }

    /// Number of values of a design that varies the factor in steps; `None` for a range without steps.
    #[must_use]
    pub fn count(&self) -> Option<u64> {
        match self {
            Self::Levels(levels) => Some(levels.len() as u64),
            Self::Range { steps, .. } => steps.map(u64::from),
            Self::Uniform { .. } | Self::Normal { .. } => Some(1),
        }
    }
}

/// Reads the values of a factor and its base, or reports what is wrong with them.
pub(super) fn factor_values(
    document: &Document,
    path: &str,
    file: &FactorFile,
) -> Result<(FactorValues, Option<YamlValue>), ConfigError> {
    let refuse = |key: &str, message: String| {
        let at = if key.is_empty() { path.to_owned() } else { format!("{path}.{key}") };
        document.error(&at, format!("{at}{message}"))
    };
    let range = match file {
        FactorFile::List(written) => {
            return levels(document, path, written.len()).map(|levels| (FactorValues::Levels(levels), None));
        }
        FactorFile::Range(range) => range,
    };
    let base = document.root.get(&format!("{path}.base")).map(|node| node.value.clone());
    if base.as_ref().is_some_and(|base| !is_plain(base)) {
        return Err(refuse("base", " must be a number, a text, true or false".into()));
    }
    let RangeFile { from, to, steps, scale, values, random, mean, deviation, .. } = range;
    let used = [
        ("from", from.is_some()),
        ("to", to.is_some()),
        ("steps", steps.is_some()),
        ("scale", scale.is_some()),
        ("values", values.is_some()),
        ("mean", mean.is_some()),
        ("deviation", deviation.is_some()),
    ];
    let (form, wanted, allowed): (_, &[&str], &[&str]) = match (values, random) {
        (Some(_), None) => ("a list of values", &[], &["values"]),
        (Some(_), Some(_)) => return Err(refuse("", " has values and random; it must have one of them".into())),
        (None, Some(RandomFile::Normal)) => ("random: normal", &["mean", "deviation"], &["mean", "deviation"]),
        (None, Some(RandomFile::Uniform)) => ("random: uniform", &["from", "to"], &["from", "to"]),
        (None, None) => ("a range", &["from", "to"], &["from", "to", "steps", "scale"]),
    };
    for (key, is_there) in used {
        if is_there && !allowed.contains(&key) {
            return Err(refuse(key, format!(" does not belong to {form}; remove it")));
        }
        if !is_there && wanted.contains(&key) {
            return Err(refuse(key, format!(" is missing; {form} needs {}", wanted.join(" and "))));
        }
    }
    let ends = || {
        let (Some(from), Some(to)) = (*from, *to) else { return Err(refuse("", " has no ends".into())) };
        match from < to {
            true => Ok((from, to)),
            false => Err(refuse("", format!(" is an empty range, from {from} to {to}; from must be below to"))),
        }
    };
    let values = match (values, random, mean.zip(*deviation)) {
        (Some(written), _, _) => FactorValues::Levels(levels(document, &format!("{path}.values"), written.len())?),
        (_, Some(RandomFile::Normal), Some((mean, deviation))) => FactorValues::Normal { mean, deviation },
        (_, Some(_), _) => ends().map(|(from, to)| FactorValues::Uniform { from, to })?,
        (_, None, _) => {
            let (from, to) = ends()?;
            let is_log = *scale == Some(ScaleFile::Log);
            if is_log && from <= 0.0 {
                return Err(refuse("from", format!(" is {from}; with scale: log it must be above 0")));
            }
            FactorValues::Range { from, to, steps: *steps, is_log }
        }
    };
    Ok((values, base))
}

/// Values of a list, each different from the others.
fn levels(document: &Document, path: &str, count: usize) -> Result<Vec<YamlValue>, ConfigError> {
    let Some(YamlNode { value: YamlValue::List(nodes), .. }) = document.root.get(path) else { return Ok(Vec::new()) };
    let mut levels: Vec<YamlValue> = Vec::with_capacity(count);
    for (index, node) in nodes.iter().enumerate() {
        let refuse = |message: &str| document.error(&format!("{path}.{index}"), format!("{path}.{index} {message}"));
        if !is_plain(&node.value) {
            return Err(refuse("must be a number, a text, true or false"));
        }
        if levels.contains(&node.value) {
            return Err(refuse("repeats a value of the list; remove it"));
        }
        levels.push(node.value.clone());
    }
    Ok(levels)
}

/// Returns whether a value is neither empty, nor a list, nor keys with values.
fn is_plain(value: &YamlValue) -> bool {
    !matches!(value, YamlValue::Null | YamlValue::List(_) | YamlValue::Map(_))
}
