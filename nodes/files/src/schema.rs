// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! JSON Schema of the files, derived from their types, and the check of a file against it.
//!
//! A type of a file declares each of its keys once: name (with the unit), type, range, default and description. From this declaration
//! come the check of a file with all findings at once, `camwright schema`, the tables of `docs/reference`, and the ranges of ROS
//! parameters that override a key.

use super::yaml::{Document, YamlNode, YamlValue};
use super::{ConfigError, FileLocation};
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::de::DeserializeOwned;
use serde_json::Value as Json;
use std::fmt::Write as _;

/// Maximum number of findings that are reported for one file.
const MAX_FINDINGS: usize = 50;

/// Maximum number of characters of a value that an error repeats.
const MAX_SHOWN: usize = 60;

/// Part of a path that stands for any key of a mapping.
pub(super) const ANY_KEY: &str = "KEY";

/// JSON Schema (draft 2020-12) of a type of a file, without references.
#[must_use]
pub(super) fn for_type<T: JsonSchema>() -> Json {
    let settings = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    settings.into_generator().into_root_schema_for::<T>().to_value()
}

/// Reads a document as a type of a file.
///
/// # Errors
/// Everything that the type does not declare: unknown and missing keys, values of another type or out of range, each with its line.
pub(super) fn read<T: DeserializeOwned + JsonSchema>(document: &Document) -> Result<T, Vec<ConfigError>> {
    let findings = findings(document, &for_type::<T>());
    if !findings.is_empty() {
        return Err(findings);
    }
    serde_json::from_value(document.root.to_json())
        .map_err(|error| vec![ConfigError::at(FileLocation::file(&document.path), error.to_string())])
}

/// Everything in a document that its schema does not allow, in the order of the schema.
fn findings(document: &Document, schema: &Json) -> Vec<ConfigError> {
    let mut check = SchemaCheck { document, findings: Vec::new(), more: 0 };
    check.value(schema, &document.root, &mut KeyPath::default());
    if check.more > 0 {
        let message = format!("has {} more errors; correct these first", check.more);
        check.findings.push(ConfigError::at(FileLocation::file(&document.path), message));
    }
    check.findings
}

/// Path to a value: with indices for lookups, with names of list elements for messages.
#[derive(Default)]
struct KeyPath {
    indexed: Vec<String>,
    named: Vec<String>,
}

impl KeyPath {
    fn push(&mut self, indexed: String, named: String) {
        self.indexed.push(indexed);
        self.named.push(named);
    }

    fn pop(&mut self) {
        self.indexed.pop();
        self.named.pop();
    }

    fn shown(&self) -> String {
        if self.named.is_empty() { "the file".to_owned() } else { self.named.join(".") }
    }
}

struct SchemaCheck<'a> {
    document: &'a Document,
    findings: Vec<ConfigError>,
    more: usize,
}

impl SchemaCheck<'_> {
    fn report(&mut self, path: &KeyPath, message: &str) {
        if self.findings.len() >= MAX_FINDINGS {
            self.more += 1;
            return;
        }
        self.findings.push(self.document.error(&path.indexed.join("."), format!("{}{message}", path.shown())));
    }

    fn value(&mut self, schema: &Json, node: &YamlNode, path: &mut KeyPath) {
        if let Some(alternatives) = alternatives(schema) {
            self.alternatives(&alternatives, node, path);
            return;
        }
        let types = types(schema);
        if matches!(node.value, YamlValue::Null) && types.contains(&"null") {
            return;
        }
        if !types.is_empty() && !types.iter().any(|name| is_of_type(&node.value, name)) {
            self.report(path, &format!(" is {}; it must be {}", shown(&node.value), type_names(&types)));
            return;
        }
        match &node.value {
            YamlValue::Integer(value) => self.number(schema, *value as f64, path),
            YamlValue::Float(value) => self.number(schema, *value, path),
            YamlValue::Text(text) => self.text(schema, (&node.value, text), path),
            YamlValue::List(list) => self.list(schema, list, path),
            YamlValue::Map(entries) => self.map(schema, entries, path),
            YamlValue::Bool(value) => {
                let allowed = schema["enum"].as_array();
                if allowed.is_some_and(|allowed| !allowed.contains(&Json::Bool(*value))) {
                    let words = words(schema).unwrap_or_default().join(", ");
                    self.report(path, &format!(" is {value}; it must be one of {words}"));
                }
            }
            YamlValue::Null => {}
        }
    }

    fn number(&mut self, schema: &Json, value: f64, path: &KeyPath) {
        if let Some(numbers) = schema["enum"].as_array() {
            if !numbers.iter().any(|number| number.as_f64() == Some(value)) {
                let allowed: Vec<String> = numbers.iter().map(Json::to_string).collect();
                self.report(path, &format!(" is {value}; it must be {}", allowed.join(" or ")));
            }
            return;
        }
        let range = Range::from_schema(schema);
        if !range.contains(value) {
            self.report(path, &format!(" is {value}; it must be {range}"));
        }
    }

    /// Returns whether a value is one of these words, and reports one that is not.
    fn is_word(&mut self, value: &YamlValue, words: &[&str], path: &KeyPath) -> bool {
        match value {
            YamlValue::Text(text) if words.contains(&text.as_str()) => return true,
            YamlValue::Text(text) => {
                self.report(path, &format!(" is {}; {}", shown_text(text), expected_word(text, words)));
            }
            other => self.report(path, &format!(" is {}; it must be one of {}", shown(other), words.join(", "))),
        }
        false
    }

    fn text(&mut self, schema: &Json, (value, text): (&YamlValue, &str), path: &KeyPath) {
        if let Some(words) = words(schema) {
            self.is_word(value, &words, path);
            return;
        }
        let length = text.chars().count();
        if let Some(most) = count(schema, "maxLength").filter(|most| length > *most) {
            self.report(path, &format!(" has {length} characters; it must have at most {most}"));
            return;
        }
        let matches = |pattern: &str| regex_lite::Regex::new(pattern).is_ok_and(|pattern| pattern.is_match(text));
        if let Some(pattern) = schema["pattern"].as_str().filter(|pattern| !matches(pattern)) {
            let allowed = schema["x-allowed"].as_str().unwrap_or(pattern);
            self.report(path, &format!(" is {}; it must be {allowed}", shown_text(text)));
        }
    }

    fn list(&mut self, schema: &Json, list: &[YamlNode], path: &mut KeyPath) {
        let (least, most) = (count(schema, "minItems"), count(schema, "maxItems"));
        let (is_short, is_long) = (least.is_some_and(|n| list.len() < n), most.is_some_and(|n| list.len() > n));
        if is_short || is_long {
            let allowed = match (least, most) {
                (Some(least), Some(most)) if least == most => format!("{least}"),
                (Some(least), Some(most)) => format!("{least} to {most}"),
                (None, Some(most)) => format!("at most {most}"),
                (least, None) => format!("at least {}", least.unwrap_or(0)),
            };
            let entries = if list.len() == 1 { "entry" } else { "entries" };
            self.report(path, &format!(" has {} {entries}; it must have {allowed}", list.len()));
            return;
        }
        for (index, item) in list.iter().enumerate() {
            let named = match item.get("name").map(|name| &name.value) {
                Some(YamlValue::Text(name)) if super::names::is_name(name) => name.clone(),
                _ => index.to_string(),
            };
            path.push(index.to_string(), named);
            self.value(&schema["items"], item, path);
            path.pop();
        }
    }

    fn map(&mut self, schema: &Json, entries: &[(String, YamlNode)], path: &mut KeyPath) {
        let Some(properties) = schema["properties"].as_object() else {
            if schema["additionalProperties"].is_object() {
                for (key, node) in entries {
                    path.push(key.clone(), key.clone());
                    self.value(&schema["additionalProperties"], node, path);
                    path.pop();
                }
            }
            if schema["additionalProperties"] == Json::Bool(false) && !entries.is_empty() {
                self.unknown_keys(entries, &[], path);
            }
            return;
        };
        for (key, node) in entries.iter().filter(|(key, _)| properties.contains_key(key)) {
            path.push(key.clone(), key.clone());
            self.value(&properties[key], node, path);
            path.pop();
        }
        if schema["additionalProperties"] == Json::Bool(false) {
            let known: Vec<&str> = properties.keys().map(String::as_str).collect();
            self.unknown_keys(entries, &known, path);
        }
        let required = schema["required"].as_array().into_iter().flatten().filter_map(Json::as_str);
        for key in required.filter(|key| !entries.iter().any(|(name, _)| name == key)) {
            path.push(key.to_owned(), key.to_owned());
            let description = first_sentence(&properties[key]);
            let wanted = if description.is_empty() { String::new() } else { format!(": {description}") };
            self.report(path, &format!(" is missing{wanted}"));
            path.pop();
        }
    }

    fn unknown_keys(&mut self, entries: &[(String, YamlNode)], known: &[&str], path: &mut KeyPath) {
        for (key, _) in entries.iter().filter(|(key, _)| !known.contains(&key.as_str())) {
            let hint = match nearest(key, known) {
                Some(nearest) => format!("did you mean {nearest}?"),
                None => format!("known keys here: {}", known.join(", ")),
            };
            let shown = key.chars().take(MAX_SHOWN).collect::<String>();
            path.push(key.clone(), shown);
            self.report(path, &format!(" is an unknown key; {hint}"));
            path.pop();
        }
    }

    /// A value that may have one of several forms.
    fn alternatives(&mut self, alternatives: &[&Json], node: &YamlNode, path: &mut KeyPath) {
        let (empty, forms): (Vec<&Json>, Vec<&Json>) = alternatives.iter().partition(|form| types(form) == ["null"]);
        if matches!(node.value, YamlValue::Null) && !empty.is_empty() {
            return;
        }
        let alternatives = forms.as_slice();
        if let Some(tag) = tag(alternatives) {
            self.tagged(tag, alternatives, node, path);
            return;
        }
        if let Some(words) = alternatives.iter().map(|form| form["const"].as_str()).collect::<Option<Vec<_>>>() {
            self.is_word(&node.value, &words, path);
            return;
        }
        let fits = |form: &&Json| types(form).iter().any(|name| is_of_type(&node.value, name));
        match alternatives.iter().find(|form| fits(form)) {
            Some(form) => self.value(form, node, path),
            None => {
                let names: Vec<&str> = alternatives.iter().flat_map(|form| types(form)).collect();
                self.report(path, &format!(" is {}; it must be {}", shown(&node.value), type_names(&names)));
            }
        }
    }

    /// Keys with values, of which one says which of the forms they have.
    fn tagged(&mut self, tag: &str, forms: &[&Json], node: &YamlNode, path: &mut KeyPath) {
        let YamlValue::Map(entries) = &node.value else {
            let wanted = type_names(&["object"]);
            self.report(path, &format!(" is {}; it must be {wanted}, among them {tag}", shown(&node.value)));
            return;
        };
        let words: Vec<&str> = forms.iter().filter_map(|form| form["properties"][tag]["const"].as_str()).collect();
        let word = node.get(tag).map(|node| &node.value);
        path.push(tag.to_owned(), tag.to_owned());
        let form = match word {
            Some(word) if self.is_word(word, &words, path) => forms
                .iter()
                .find(|form| matches!(word, YamlValue::Text(text) if form["properties"][tag]["const"] == **text)),
            Some(_) => None,
            None => {
                self.report(path, &format!(" is missing; it must be one of {}", words.join(", ")));
                None
            }
        };
        path.pop();
        match form {
            Some(form) => self.value(form, node, path),
            None => {
                let known: Vec<&str> = forms
                    .iter()
                    .filter_map(|form| form["properties"].as_object())
                    .flat_map(|map| map.keys())
                    .map(String::as_str)
                    .collect();
                self.unknown_keys(entries, &known, path);
            }
        }
    }
}

/// Forms that a value may have; none for a value of one form.
pub(super) fn alternatives(schema: &Json) -> Option<Vec<&Json>> {
    let list = schema["oneOf"].as_array().or_else(|| schema["anyOf"].as_array())?;
    let mut forms = Vec::new();
    for form in list {
        match alternatives(form) {
            Some(inner) => forms.extend(inner),
            None => forms.push(form),
        }
    }
    Some(forms)
}

/// The key that distinguishes the forms, if they are all keys with values and have one.
pub(super) fn tag<'a>(forms: &[&'a Json]) -> Option<&'a str> {
    let properties = forms.first()?["properties"].as_object()?;
    let is_tag = |key: &str| forms.iter().all(|form| form["properties"][key]["const"].is_string());
    properties.keys().map(String::as_str).find(|key| is_tag(key))
}

pub(super) fn types(schema: &Json) -> Vec<&str> {
    match &schema["type"] {
        Json::String(name) => vec![name],
        Json::Array(names) => names.iter().filter_map(Json::as_str).collect(),
        _ => Vec::new(),
    }
}

/// Schema of a key of a mapping, which may take any key.
pub(super) fn property<'a>(schema: &'a Json, key: &str) -> &'a Json {
    match &schema["properties"][key] {
        Json::Null => &schema["additionalProperties"],
        property => property,
    }
}

/// Returns whether the value at a dotted path of a file is a whole number; names or indices lead to the elements of lists.
pub(super) fn is_whole(schema: &Json, path: &str) -> bool {
    let forms = alternatives(schema).unwrap_or_else(|| vec![schema]);
    if path.is_empty() {
        let is_number = |form: &&Json| types(form).iter().any(|name| ["integer", "number"].contains(name));
        let mut numbers = forms.into_iter().filter(is_number).peekable();
        return numbers.peek().is_some() && numbers.all(|form| !types(form).contains(&"number"));
    }
    let (part, rest) = path.split_once('.').unwrap_or((path, ""));
    forms.into_iter().any(|form| match form["items"].is_object() {
        true => is_whole(&form["items"], rest),
        false => is_whole(property(form, part), rest),
    })
}

/// Texts that a value may be.
fn words(schema: &Json) -> Option<Vec<&str>> {
    if let Some(word) = schema["const"].as_str() {
        return Some(vec![word]);
    }
    schema["enum"].as_array().map(|words| words.iter().filter_map(Json::as_str).collect())
}

fn count(schema: &Json, key: &str) -> Option<usize> {
    schema[key].as_u64().and_then(|count| usize::try_from(count).ok())
}

fn is_of_type(value: &YamlValue, name: &str) -> bool {
    match value {
        YamlValue::Null => name == "null",
        YamlValue::Bool(_) => name == "boolean",
        YamlValue::Integer(_) => name == "integer" || name == "number",
        YamlValue::Float(_) => name == "number",
        YamlValue::Text(_) => name == "string",
        YamlValue::List(_) => name == "array",
        YamlValue::Map(_) => name == "object",
    }
}

fn type_names(types: &[&str]) -> String {
    let names: Vec<&str> = types
        .iter()
        .filter(|name| **name != "null")
        .map(|name| match *name {
            "boolean" => "true or false",
            "integer" => "a whole number",
            "number" => "a number",
            "string" => "a text",
            "array" => "a list",
            _ => "keys with values",
        })
        .collect();
    names.join(" or ")
}

fn shown(value: &YamlValue) -> String {
    match value {
        YamlValue::Null => "empty".to_owned(),
        YamlValue::Bool(value) => value.to_string(),
        YamlValue::Integer(value) => value.to_string(),
        YamlValue::Float(value) => value.to_string(),
        YamlValue::Text(text) => format!("the text {}", shown_text(text)),
        YamlValue::List(_) => "a list".to_owned(),
        YamlValue::Map(_) => "keys with values".to_owned(),
    }
}

fn shown_text(text: &str) -> String {
    let short: String = text.chars().take(MAX_SHOWN).collect();
    if short.len() < text.len() { format!("{short:?} …") } else { format!("{short:?}") }
}

fn expected_word(text: &str, words: &[&str]) -> String {
    let mut expected = match words {
        [word] => format!("it must be {word:?}"),
        _ => format!("it must be one of {}", words.join(", ")),
    };
    if let Some(nearest) = nearest(text, words).filter(|_| words.len() > 1) {
        let _ = write!(expected, "; did you mean {nearest}?");
    }
    expected
}

/// The name that a misspelt one most likely means.
#[must_use]
pub fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    // Longer names are no misspelling of any key.
    if name.len() > MAX_SHOWN {
        return None;
    }
    let distance = |known: &&&str| strsim::damerau_levenshtein(name, known);
    let near = known.iter().min_by_key(distance).filter(|known| distance(known) <= 1 + name.len() / 4);
    // A name without its unit, such as `work_speed`.
    let longer = || known.iter().filter(|known| name.len() >= MIN_PREFIX && known.starts_with(name));
    near.or_else(|| longer().min_by_key(|known| known.len())).copied()
}

/// Shortest begin of a name that means the name.
const MIN_PREFIX: usize = 4;

/// The numbers that a key takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    pub min: Option<f64>,
    pub max: Option<f64>,
}

impl Range {
    fn from_schema(schema: &Json) -> Self {
        Self { min: schema["minimum"].as_f64(), max: schema["maximum"].as_f64() }
    }

    fn contains(&self, value: f64) -> bool {
        value.is_finite() && self.min.is_none_or(|min| value >= min) && self.max.is_none_or(|max| value <= max)
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.min, self.max) {
            (Some(min), Some(max)) => write!(f, "{min} to {max}"),
            (Some(min), None) => write!(f, "at least {min}"),
            (None, Some(max)) => write!(f, "at most {max}"),
            (None, None) => f.write_str("a finite number"),
        }
    }
}

/// A key as it is declared.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// Dotted path; `[]` stands for the elements of a list.
    pub path: String,
    /// Type in words, or the words that it takes.
    pub kind: String,
    pub range: Range,
    /// Words that it takes, if it takes words.
    pub words: Vec<String>,
    /// Default as written in YAML; none: the key is required, or its description says what its absence means.
    pub default: Option<String>,
    pub is_required: bool,
    /// Words of the distinguishing key for the forms that have this key; empty: every form has it.
    pub forms: Vec<String>,
    pub description: String,
}

impl Key {
    /// Unit of the value, from the end of the key's name.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        let name = self.path.rsplit('.').next().unwrap_or_default().trim_end_matches("[]");
        UNITS.iter().find(|(suffix, _)| name == &suffix[1..] || name.ends_with(suffix)).map_or("", |(_, unit)| unit)
    }

    /// Values that it takes: range, words or type.
    #[must_use]
    pub fn allowed(&self) -> String {
        match (self.words.is_empty(), self.range) {
            (false, _) => self.words.join(", "),
            (true, Range { min: None, max: None }) => self.kind.clone(),
            (true, range) if self.kind == "a whole number" => format!("{range}, whole"),
            (true, range) if self.kind == NUMBER_OR_LIST => format!("{range}, or a list of such values"),
            (true, range) => range.to_string(),
        }
    }
}

/// Type of a key that takes a number or several.
pub const NUMBER_OR_LIST: &str = "a number or a list";

/// Ends of names of keys with their units, longer ends first.
const UNITS: [(&str, &str); 40] = [
    ("_n_m_rad", "N m/rad"),
    ("_n_um_mm", "N/µm per mm"),
    ("_rad_s2", "rad/s²"),
    ("_rad_s3", "rad/s³"),
    ("_n_m_s", "N m s/rad"),
    ("_n_s_m", "N s/m"),
    ("_um_per_deg", "µm/deg"),
    ("_energy_j_mm3", "J/mm³"),
    ("_rate_mm2_s", "mm²/s"),
    ("_kg_m2", "kg m²"),
    ("_mm_s3", "mm/s³"),
    ("_mm_s2", "mm/s²"),
    ("_n_mm2", "N/mm²"),
    ("_um_s", "µm/s"),
    ("_w_mm", "W/mm"),
    ("_mm_s", "mm/s"),
    ("_n_um", "N/µm"),
    ("_n_mm", "N/mm"),
    ("_n_m", "N m"),
    ("_m_s", "m/s"),
    ("_1_s", "1/s"),
    ("_blocks_s", "1/s"),
    ("_percent", "%"),
    ("_counts", "counts"),
    ("_per_mm", "1/mm"),
    ("_ticks", "ticks"),
    ("_turns", "turns"),
    ("_rpm", "rpm"),
    ("_gpa", "GPa"),
    ("_deg", "deg"),
    ("_us", "µs"),
    ("_ms", "ms"),
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_um", "µm"),
    ("_mm", "mm"),
    ("_s", "s"),
    ("_j", "J"),
    ("_w", "W"),
    ("_n", "N"),
];

/// Every key that a schema declares, sorted by path.
#[must_use]
pub fn keys(schema: &Json) -> Vec<Key> {
    let mut keys = Vec::new();
    collect(schema, "", &mut keys);
    keys.sort_by(|a, b| a.path.cmp(&b.path));
    keys.dedup_by(|later, earlier| later.path == earlier.path && merge(earlier, later));
    keys
}

/// Joins what several forms declare of one key: their words, and that it is not required in all of them.
fn merge(earlier: &mut Key, later: &mut Key) -> bool {
    earlier.words.extend(later.words.iter().filter(|word| !earlier.words.contains(word)).cloned().collect::<Vec<_>>());
    earlier.is_required &= later.is_required;
    earlier.forms.append(&mut later.forms);
    if !earlier.description.contains(&later.description) {
        let separator = if earlier.description.is_empty() { "" } else { " " };
        let _ = write!(earlier.description, "{separator}{}", later.description);
    }
    true
}

fn collect(schema: &Json, prefix: &str, keys: &mut Vec<Key>) {
    let forms = alternatives(schema).unwrap_or_else(|| vec![schema]);
    let forms: Vec<&Json> = forms.into_iter().filter(|form| types(form) != ["null"]).collect();
    let tag = tag(&forms).filter(|_| forms.len() > 1);
    for form in &forms {
        if form["items"].is_object() {
            collect(&form["items"], &format!("{prefix}[]"), keys);
        }
        let required: Vec<&str> = form["required"].as_array().into_iter().flatten().filter_map(Json::as_str).collect();
        for (name, property) in form["properties"].as_object().into_iter().flatten() {
            let path = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
            let mut declared = key(&path, property, required.contains(&name.as_str()));
            if let Some(word) = tag.and_then(|tag| form["properties"][tag]["const"].as_str()) {
                let is_in_all = forms.iter().all(|form| form["properties"][name].is_object());
                if Some(name.as_str()) == tag {
                    describe_word(&mut declared.description, word, &description(form));
                } else if !is_in_all {
                    declared.forms.push(word.to_owned());
                }
            }
            keys.push(declared);
            collect(property, &path, keys);
        }
        if form["additionalProperties"].is_object() {
            collect(&form["additionalProperties"], &format!("{prefix}.{ANY_KEY}"), keys);
        }
    }
}

pub(super) fn key(path: &str, schema: &Json, is_required: bool) -> Key {
    let forms = alternatives(schema).unwrap_or_else(|| vec![schema]);
    let mut words: Vec<String> =
        forms.iter().flat_map(|form| words(form).unwrap_or_default()).map(str::to_owned).collect();
    words.extend(schema["enum"].as_array().into_iter().flatten().filter(|word| word.is_number()).map(Json::to_string));
    let mut text = description(schema);
    for form in forms.iter().filter(|form| form["const"].is_string() && form["description"].is_string()) {
        describe_word(&mut text, form["const"].as_str().unwrap_or_default(), &description(form));
    }
    let mut named: Vec<&str> = Vec::new();
    for name in forms.iter().flat_map(|form| types(form)) {
        if !named.contains(&name) {
            named.push(name);
        }
    }
    let kind = type_names(&named);
    let number = forms.iter().find(|form| kind == NUMBER_OR_LIST && types(form).contains(&"number"));
    Key {
        path: path.to_owned(),
        kind,
        range: Range::from_schema(number.unwrap_or(&schema)),
        words,
        default: default_text(&schema["default"]),
        is_required,
        forms: Vec::new(),
        description: text,
    }
}

/// Adds the meaning of a word that a key takes to its description.
fn describe_word(text: &mut String, word: &str, meaning: &str) {
    let separator = if text.is_empty() { "" } else { " " };
    let _ = write!(text, "{separator}`{word}`: {meaning}");
}

fn default_text(default: &Json) -> Option<String> {
    match default {
        Json::Null => None,
        Json::String(text) if text.is_empty() => Some("empty".into()),
        Json::String(text) => Some(text.clone()),
        Json::Array(list) if list.is_empty() => Some("none".into()),
        Json::Object(_) | Json::Array(_) => None,
        other => Some(other.to_string()),
    }
}

/// Description of a key, in one line.
fn description(schema: &Json) -> String {
    schema["description"].as_str().unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ")
}

pub(super) fn first_sentence(schema: &Json) -> String {
    let text = description(schema);
    text.split_once(". ").map_or(text.trim_end_matches('.').to_owned(), |(first, _)| first.to_owned())
}

/// The keys of a schema as a Markdown table.
#[must_use]
pub fn table(schema: &Json) -> String {
    let mut table = String::from("| key | unit | allowed | default | meaning |\n|---|---|---|---|---|\n");
    for key in keys(schema) {
        let mut default = match (&key.default, key.is_required) {
            (Some(default), _) => format!("`{default}`"),
            (None, true) => "required".to_owned(),
            (None, false) => String::new(),
        };
        if !key.forms.is_empty() {
            let separator = if default.is_empty() { "" } else { " " };
            let _ = write!(default, "{separator}with {}", key.forms.join(", "));
        }
        let allowed = key.allowed();
        let _ = writeln!(table, "| `{}` | {} | {allowed} | {default} | {} |", key.path, key.unit(), key.description);
    }
    table
}

#[cfg(test)]
mod tests;
