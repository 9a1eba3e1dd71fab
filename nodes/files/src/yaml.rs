// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! YAML with the line of every value, and overrides over it.

use super::locate::Located;
use super::recorded_files::RecordedFiles;
use super::{ConfigError, FileLocation};
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde::ser::{SerializeMap, SerializeSeq, Serializer};
use serde::{Deserialize, Serialize};
use serde_saphyr::Spanned;
use std::fmt;
use std::path::{Path, PathBuf};

/// Maximum number of characters of an override that an error repeats.
const MAX_SHOWN: usize = 80;

/// A value of a YAML file and the line it stands on.
#[derive(Debug, Clone, PartialEq)]
pub struct YamlNode {
    /// Line from 1; 0 for a value that came from an override.
    pub line: u64,
    pub value: YamlValue,
}

/// Kinds of YAML values.
#[derive(Debug, Clone, PartialEq)]
pub enum YamlValue {
    Null,
    Bool(bool),
    Integer(i64),
    Float(f64),
    Text(String),
    List(Vec<YamlNode>),
    /// A mapping, in the order of the file.
    Map(Vec<(String, YamlNode)>),
}

struct ValueVisitor;

impl<'de> Visitor<'de> for ValueVisitor {
    type Value = YamlValue;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a YAML value")
    }
    fn visit_unit<E>(self) -> Result<YamlValue, E> {
        Ok(YamlValue::Null)
    }
    fn visit_none<E>(self) -> Result<YamlValue, E> {
        Ok(YamlValue::Null)
    }
    fn visit_bool<E>(self, value: bool) -> Result<YamlValue, E> {
        Ok(YamlValue::Bool(value))
    }
    fn visit_i64<E>(self, value: i64) -> Result<YamlValue, E> {
        Ok(YamlValue::Integer(value))
    }
    fn visit_u64<E: serde::de::Error>(self, value: u64) -> Result<YamlValue, E> {
        i64::try_from(value).map(YamlValue::Integer).map_err(|_| E::custom(format!("the integer {value} is too large")))
    }
    fn visit_f64<E>(self, value: f64) -> Result<YamlValue, E> {
        Ok(YamlValue::Float(value))
    }
    fn visit_str<E>(self, value: &str) -> Result<YamlValue, E> {
        Ok(YamlValue::Text(value.to_owned()))
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<YamlValue, A::Error> {
        let mut list = Vec::new();
        while let Some(node) = seq.next_element::<YamlNode>()? {
            list.push(node);
        }
        Ok(YamlValue::List(list))
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<YamlValue, A::Error> {
        let mut entries = Vec::new();
        while let Some(entry) = map.next_entry::<String, YamlNode>()? {
            entries.push(entry);
        }
        Ok(YamlValue::Map(entries))
    }
}

impl<'de> Deserialize<'de> for YamlValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ValueVisitor)
    }
}

impl<'de> Deserialize<'de> for YamlNode {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let spanned = Spanned::<YamlValue>::deserialize(deserializer)?;
        Ok(YamlNode { line: spanned.referenced.line(), value: spanned.value })
    }
}

impl Serialize for YamlNode {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.value {
            YamlValue::Null => serializer.serialize_unit(),
            YamlValue::Bool(value) => serializer.serialize_bool(*value),
            YamlValue::Integer(value) => serializer.serialize_i64(*value),
            YamlValue::Float(value) => serializer.serialize_f64(*value),
            YamlValue::Text(value) => serializer.serialize_str(value),
            YamlValue::List(list) => {
                let mut seq = serializer.serialize_seq(Some(list.len()))?;
                for node in list {
                    seq.serialize_element(node)?;
                }
                seq.end()
            }
            YamlValue::Map(entries) => {
                let mut map = serializer.serialize_map(Some(entries.len()))?;
                for (key, node) in entries {
                    map.serialize_entry(key, node)?;
                }
                map.end()
            }
        }
    }
}

impl YamlValue {
    /// The value in one line of YAML, as an override has it.
    #[must_use]
    pub fn to_flow(&self) -> String {
        self.flow(false)
    }

    /// The value in one line of YAML; inside of brackets a comma ends a text.
    pub(super) fn flow(&self, is_inner: bool) -> String {
        match self {
            Self::Null => "null".to_owned(),
            Self::Bool(value) => value.to_string(),
            Self::Integer(value) => value.to_string(),
            // The debug form keeps the point that makes a YAML number a float.
            Self::Float(value) => format!("{value:?}"),
            Self::Text(text) => quoted(text, is_inner),
            Self::List(items) => {
                let items: Vec<String> = items.iter().map(|item| item.value.flow(true)).collect();
                format!("[{}]", items.join(", "))
            }
            Self::Map(entries) => {
                let entries: Vec<String> =
                    entries.iter().map(|(key, node)| format!("{key}: {}", node.value.flow(true))).collect();
                format!("{{{}}}", entries.join(", "))
            }
        }
    }
}

/// A text, in quotes where YAML would read it as something else. Inside of brackets a comma ends a text.
fn quoted(text: &str, is_inner: bool) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./ ".contains(c) || (c == ',' && !is_inner);
    let is_same =
        |text: &str| serde_saphyr::from_str::<YamlValue>(text).is_ok_and(|read| read == YamlValue::Text(text.into()));
    if text.chars().all(is_plain) && is_same(text) {
        text.to_owned()
    } else {
        serde_json::Value::from(text).to_string()
    }
}

impl YamlNode {
    pub(super) fn to_json(&self) -> serde_json::Value {
        use serde_json::Value as Json;
        match &self.value {
            YamlValue::Null => Json::Null,
            YamlValue::Bool(value) => Json::Bool(*value),
            YamlValue::Integer(value) => Json::from(*value),
            YamlValue::Float(value) => Json::from(*value),
            YamlValue::Text(text) => Json::String(text.clone()),
            YamlValue::List(list) => list.iter().map(YamlNode::to_json).collect(),
            YamlValue::Map(entries) => entries.iter().map(|(key, node)| (key.clone(), node.to_json())).collect(),
        }
    }

    /// The value at a dotted path; list elements are named by their index, or by their `name`.
    #[must_use]
    pub fn get(&self, path: &str) -> Option<&YamlNode> {
        match &self.value {
            YamlValue::Map(entries) => {
                let (index, rest) = entry_index(entries, path)?;
                rest.map_or(Some(&entries[index].1), |rest| entries[index].1.get(rest))
            }
            YamlValue::List(list) => {
                let (part, rest) = path.split_once('.').map_or((path, None), |(part, rest)| (part, Some(rest)));
                let node = &list[element_index(list, part)?];
                rest.map_or(Some(node), |rest| node.get(rest))
            }
            _ => None,
        }
    }

    /// Writes a value at a dotted path; the mappings on the way must exist, the last key may be new.
    fn set(&mut self, path: &str, value: YamlValue) -> Result<(), String> {
        let mut node = self;
        let mut left = Some(path);
        while let Some(from) = left {
            let (part, rest) = from.split_once('.').map_or((from, None), |(part, rest)| (part, Some(rest)));
            left = rest;
            node = match &mut node.value {
                YamlValue::Map(entries) => {
                    let index = match entry_index(entries, from) {
                        Some((index, rest)) => {
                            left = rest;
                            index
                        }
                        // What a file may leave out may be set all the same; who reads the file refuses what it does not know.
                        None => {
                            let value = if rest.is_none() { YamlValue::Null } else { YamlValue::Map(Vec::new()) };
                            entries.push((part.to_owned(), YamlNode { line: 0, value }));
                            entries.len() - 1
                        }
                    };
                    &mut entries[index].1
                }
                YamlValue::List(list) => {
                    let Some(index) = element_index(list, part) else {
                        return Err(format!("the list has no element {part:?} to set {path:?} in"));
                    };
                    &mut list[index]
                }
                _ => return Err(format!("{path:?} goes through a plain value at {part:?}")),
            };
        }
        *node = YamlNode { line: 0, value };
        node.forget_lines();
        Ok(())
    }

    /// Removes the line numbers of a value that came from an override.
    fn forget_lines(&mut self) {
        self.line = 0;
        match &mut self.value {
            YamlValue::List(list) => list.iter_mut().for_each(YamlNode::forget_lines),
            YamlValue::Map(entries) => entries.iter_mut().for_each(|(_, node)| node.forget_lines()),
            _ => {}
        }
    }
}

/// Entry of a mapping at the begin of a dotted path, and the path behind it. A key may contain dots itself, as those of a study do.
fn entry_index<'a>(entries: &[(String, YamlNode)], path: &'a str) -> Option<(usize, Option<&'a str>)> {
    let behind = |key: &str| match path.strip_prefix(key)? {
        "" => Some(None),
        rest => rest.strip_prefix('.').map(Some),
    };
    entries.iter().enumerate().find_map(|(index, (key, _))| Some((index, behind(key)?)))
}

fn element_index(list: &[YamlNode], part: &str) -> Option<usize> {
    let by_name = list.iter().position(|node| match node.get("name").map(|name| &name.value) {
        Some(YamlValue::Text(name)) => name == part,
        _ => false,
    });
    by_name.or_else(|| part.parse().ok().filter(|index| *index < list.len()))
}

/// A YAML file, read whole, with the overrides that were laid over it.
#[derive(Debug, Clone)]
pub struct Document {
    /// Path of the file.
    pub path: PathBuf,
    /// Text after the overrides; without any the file's own text.
    pub text: String,
    pub root: YamlNode,
    overrides: Vec<String>,
    /// Files that it names and that are found before any on the disk.
    pub(super) recorded: RecordedFiles,
}

impl Document {
    /// Parses a file that was found and lays `key=value` overrides over it, later ones winning.
    ///
    /// # Errors
    /// As [`Document::parse`].
    pub fn with_overrides(located: &Located, overrides: &[String]) -> Result<Self, ConfigError> {
        let document = Self::parse(&located.path, &located.text, overrides)?;
        Ok(Self { recorded: located.recorded.clone(), ..document })
    }

    /// Parses text that was read from a path and lays `key=value` overrides over it, later ones winning.
    ///
    /// # Errors
    /// Text that is not YAML; an override without `=`, with a value that is not YAML, or with a path that leads nowhere.
    pub fn parse(path: &Path, text: &str, overrides: &[String]) -> Result<Self, ConfigError> {
        let mut root: YamlNode = serde_saphyr::from_str(text).map_err(|error| yaml_error(path, &error))?;
        for over in overrides {
            let refuse =
                |message: String| ConfigError::at(FileLocation::file(path), format!("override {over:?}: {message}"));
            let (key, value) = over.split_once('=').ok_or_else(|| refuse("has no '='".into()))?;
            let value: YamlValue =
                serde_saphyr::from_str(value.trim()).map_err(|_| refuse("its value is not YAML".into()))?;
            root.set(key.trim(), value).map_err(refuse)?;
        }
        let text = if overrides.is_empty() {
            text.to_owned()
        } else {
            serde_saphyr::to_string(&root).map_err(|error| {
                ConfigError::at(FileLocation::file(path), format!("cannot be written back: {error}"))
            })?
        };
        let recorded = RecordedFiles::default();
        Ok(Self { path: path.to_path_buf(), text, root, overrides: overrides.to_vec(), recorded })
    }

    /// Position of the value at a dotted path; of the nearest enclosing value if it does not exist.
    #[must_use]
    pub fn place(&self, path: &str) -> FileLocation {
        let mut path = path;
        loop {
            if let Some(node) = self.root.get(path) {
                return FileLocation::line(&self.path, node.line);
            }
            match path.rfind('.') {
                Some(dot) => path = &path[..dot],
                None => return FileLocation::file(&self.path),
            }
        }
    }

    /// An error about the value at a dotted path.
    #[must_use]
    pub fn error(&self, path: &str, message: impl Into<String>) -> ConfigError {
        let (place, message) = (self.place(path), message.into());
        let is_about = |over: &&String| {
            let key = over.split('=').next().unwrap_or_default().trim();
            path.starts_with(key) || key.starts_with(path)
        };
        let short = |over: &String| over.chars().take(MAX_SHOWN).collect::<String>();
        let with: Vec<String> = self.overrides.iter().filter(is_about).map(short).collect();
        match place.line {
            None if !with.is_empty() => ConfigError::at(place, format!("{message} (set by {})", with.join(" "))),
            _ => ConfigError::at(place, message),
        }
    }

    /// The text at a dotted path, if it is one.
    #[must_use]
    pub fn text_at(&self, path: &str) -> Option<&str> {
        match self.root.get(path).map(|node| &node.value) {
            Some(YamlValue::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// `job` of `schema: camwright/job/1`, whatever its version; none for a file without a schema of this program.
    #[must_use]
    pub fn kind(&self) -> Option<&str> {
        self.text_at("schema")?.strip_prefix("camwright/")?.rsplit_once('/').map(|(kind, _)| kind)
    }

    /// Refuses a file that is not of this kind, or is of a newer schema version than this program reads.
    ///
    /// # Errors
    /// A missing or foreign `schema` value.
    pub fn require_schema(&self, kind: &str, newest: u32) -> Result<(), ConfigError> {
        let expected = format!("\"camwright/{kind}/{newest}\"");
        let Some(node) = self.root.get("schema") else {
            return Err(ConfigError::at(
                FileLocation::file(&self.path),
                format!("has no schema; expected schema: {expected}"),
            ));
        };
        let YamlValue::Text(schema) = &node.value else {
            return Err(self.error("schema", format!("schema must be the text {expected}")));
        };
        let version = schema.strip_prefix(&format!("camwright/{kind}/")).and_then(|v| v.parse::<u32>().ok());
        match version {
            Some(version) if (1..=newest).contains(&version) => Ok(()),
            Some(version) => Err(self.error(
                "schema",
                format!("is of schema version {version}; this program reads {kind} files up to version {newest}"),
            )),
            None => Err(self.error("schema", format!("schema is {schema:?}, expected {expected}"))),
        }
    }
}

fn yaml_error(path: &Path, error: &serde_saphyr::Error) -> ConfigError {
    let line = error.location().map(|location| location.line());
    // The message ends in its own location, in words that differ from ours.
    let message = error.without_snippet().to_string();
    let message = match message.rfind(" at line ") {
        Some(at) => message[..at].to_owned(),
        None => message,
    };
    ConfigError::at(FileLocation { file: path.to_path_buf(), line }, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "schema: camwright/job/1\ninfeed:\n  total_mm: 0.36\nlobes:\n  - name: I1\n    phase_deg: 75.0\n  - name: E1\n    phase_deg: 110.5\n";

    fn document(overrides: &[&str]) -> Result<Document, ConfigError> {
        let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
        Document::parse(Path::new("job.yaml"), TEXT, &overrides)
    }

    #[test]
    fn every_value_knows_its_line() {
        let document = document(&[]).unwrap();
        assert_eq!(document.place("infeed.total_mm").to_string(), "job.yaml:3");
        assert_eq!(document.place("lobes.E1.phase_deg").to_string(), "job.yaml:8");
        assert_eq!(document.place("lobes.1.phase_deg").to_string(), "job.yaml:8");
        assert_eq!(document.place("infeed.missing").to_string(), "job.yaml:3", "where the enclosing mapping begins");
    }

    #[test]
    fn keys_with_dots_are_found_and_set() {
        let text = "factors:\n  speed.law: [a]\n  infeed.total_mm:\n    from: 1\n";
        let read = |set: &[String]| Document::parse(Path::new("study.yaml"), text, set).unwrap();
        assert_eq!(read(&[]).place("factors.infeed.total_mm.from").to_string(), "study.yaml:4");
        assert_eq!(read(&[]).place("factors.speed.law").to_string(), "study.yaml:2");
        let set = read(&["factors.infeed.total_mm.from=7".into(), "factors.infeed.new=1".into()]);
        assert_eq!(set.root.get("factors.infeed.total_mm.from").unwrap().value, YamlValue::Integer(7));
        assert_eq!(set.root.get("factors.infeed.new").unwrap().value, YamlValue::Integer(1));
        assert_eq!(set.root.get("factors.speed"), None);
    }

    #[test]
    fn overrides_are_written_into_the_text_that_is_used() {
        let document = document(&["infeed.total_mm=0.5", "lobes.I1.phase_deg=80"]).unwrap();
        assert_eq!(document.root.get("infeed.total_mm").unwrap().value, YamlValue::Float(0.5));
        let again = Document::parse(Path::new("job.yaml"), &document.text, &[]).unwrap();
        assert_eq!(again.root.get("lobes.I1.phase_deg").unwrap().value, YamlValue::Integer(80));
    }

    #[test]
    fn an_override_makes_the_group_that_a_file_leaves_out() {
        let document = document(&["speed.law=time_optimal"]).unwrap();
        assert_eq!(document.root.get("speed.law").unwrap().value, YamlValue::Text("time_optimal".into()));
    }

    #[test]
    fn what_an_override_brings_stands_on_no_line() {
        let document = document(&["infeed={total_mm: 0.5, more: [1, 2]}"]).unwrap();
        assert_eq!(document.place("infeed.more").to_string(), "job.yaml");
        assert_eq!(document.place("infeed.total_mm").to_string(), "job.yaml");
    }

    #[test]
    fn an_override_that_leads_nowhere_is_refused() {
        let error = document(&["lobes.I9.phase_deg=1"]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "job.yaml: override \"lobes.I9.phase_deg=1\": the list has no element \"I9\" to set \"lobes.I9.phase_deg\" in"
        );
        assert!(document(&["infeed.total_mm"]).unwrap_err().to_string().contains("has no '='"));
    }

    #[test]
    fn a_newer_schema_is_refused_with_its_line() {
        let document = Document::parse(Path::new("job.yaml"), "# a job\nschema: camwright/job/7\n", &[]).unwrap();
        assert_eq!(
            document.require_schema("job", 1).unwrap_err().to_string(),
            "job.yaml:2: is of schema version 7; this program reads job files up to version 1"
        );
    }
}
