// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Commented files to start from. The values are those of a shipped example; meaning, unit and range of a key come from its declaration.

use super::ConfigError;
use super::file_kind::FileKind;
use super::locate::locate;
use super::names::{MAX_NAME, is_name};
use super::schema::{self, ANY_KEY, alternatives, tag, types};
use super::yaml::{Document, YamlNode, YamlValue};
use serde_json::Value as Json;
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// Maximum width of a line of comments.
const WIDTH: usize = 80;

/// Example of a kind of file, and the optional keys that a starter file offers behind a `#`.
struct Starter {
    folder: &'static str,
    example: &'static str,
    title: &'static str,
    /// Keys with the example that holds a value; empty: the default of the key.
    optional: &'static [(&'static str, &'static str)],
    /// Other keys of mappings that a starter file offers behind a `#`.
    instead: &'static [Instead],
}

/// Other keys of a mapping, once.
#[derive(Debug, Clone, Copy)]
struct Instead {
    /// Path of the mapping.
    path: &'static str,
    /// Key that they replace; empty: all keys of the mapping.
    replaced: &'static str,
    keys: &'static str,
}

/// A table instead of motion laws.
const TABLE: Instead = Instead {
    path: "profiles[].lift",
    replaced: "",
    keys: "{table: my_lift.csv, columns: [cam_angle_deg, lift_mm], decimal_comma: false}",
};

/// An infeed of its own for every turn.
const INFEED_LIST: Instead = Instead {
    path: "infeed",
    replaced: "per_block_um",
    keys: "{per_turn_um: [50, 50, 45, 45, 40, 40, 30, 30, 20, 10]}",
};

impl FileKind {
    const fn starter(self) -> Starter {
        match self {
            Self::Job => Starter {
                folder: "jobs",
                example: "plate_cam",
                title: "Grinding job",
                optional: &[
                    ("speed", ""),
                    ("retract_clearance_mm", ""),
                    ("hold_in_cut", ""),
                    ("c_between_lobes", ""),
                    ("lobe_order", ""),
                    ("clearance_mm", ""),
                    ("form_compensation", ""),
                ],
                instead: &[TABLE, INFEED_LIST],
            },
            Self::TurningJob => Starter {
                folder: "jobs",
                example: "turned_cam",
                title: "Turning job",
                optional: &[("clearance_mm", ""), ("angles_per_turn", ""), ("form_grid", "")],
                instead: &[],
            },
            Self::MillingJob => Starter {
                folder: "jobs",
                example: "plate_groove",
                title: "Milling job",
                optional: &[("clearance_mm", ""), ("nc", "")],
                instead: &[],
            },
            Self::Study => Starter {
                folder: "studies",
                example: "speed_and_infeed",
                title: "Study: cases of a job, planned and simulated without ROS",
                optional: &[
                    ("machine", "drive_mismatch"),
                    ("replicates", "drive_mismatch"),
                    ("seeds", "drive_mismatch"),
                    ("seed", ""),
                    ("minimise", ""),
                ],
                instead: &[],
            },
            Self::Machine => Starter {
                folder: "machines",
                example: "cam_grinder",
                title: "Machine",
                optional: &[
                    ("alarm_retract", ""),
                    ("wheel_changer", "cam_grinder_two_wheels"),
                    ("gauge", "journal_grinder"),
                    ("gap_detector", "journal_grinder"),
                    ("dresser", "cam_grinder_with_dresser"),
                    ("headstock", "cam_grinder_with_dresser"),
                    ("tailstock", "cam_grinder_with_dresser"),
                    ("workholding", "cam_grinder_with_steady_rest"),
                ],
                instead: &[],
            },
        }
    }

    /// Text of a complete file of this kind with a comment for each key.
    ///
    /// # Errors
    /// A shipped example was replaced by a file that cannot be read.
    pub fn starter_file(self, name: &str) -> Result<String, ConfigError> {
        let (starter, schema) = (self.starter(), self.schema());
        let YamlValue::Map(mut entries) = example(&starter, starter.example)? else { return Ok(String::new()) };
        for (_, node) in entries.iter_mut().filter(|(key, _)| key == "name") {
            node.value = YamlValue::Text(name.to_owned());
        }
        let mut writer = StarterWriter { instead: starter.instead.to_vec(), ..StarterWriter::default() };
        writer.comment(&format!("{}. Each key has its meaning, unit and range.", starter.title), 0);
        writer.comment(&format!("All keys: `camwright schema {} --table`.", self.name()), 0);
        writer.comment("A # directly in front of a key switches an optional key off: remove it.", 0);
        writer.text.push('\n');
        writer.map(&schema, &entries, "", 0, false);
        for (key, source) in starter.optional {
            if entries.iter().all(|(present, _)| present != key) {
                let value = optional_value(&starter, &schema, key, source)?;
                let mut optional = StarterWriter { seen: writer.seen.clone(), ..StarterWriter::default() };
                optional.map(&schema, &[((*key).to_owned(), YamlNode { line: 0, value })], "", 0, false);
                writer.text.push_str(&switched_off(&optional.text));
            }
        }
        Ok(writer.text)
    }
}

/// Name for a file of this kind, from the name of the file: other characters than those of names become `_`.
#[must_use]
pub fn starter_name(stem: &str) -> String {
    let allowed = |c: char| if is_name(&c.to_string()) { c } else { '_' };
    let name: String = stem.chars().take(MAX_NAME).map(allowed).collect();
    if is_name(&name) { name } else { "mine".to_owned() }
}

fn example(starter: &Starter, name: &str) -> Result<YamlValue, ConfigError> {
    // With its folder, so that a file of this name in the current folder is not taken for it.
    let located = locate(starter.folder, &format!("{}/{name}", starter.folder), "yaml", None)?;
    Ok(Document::with_overrides(&located, &[])?.root.value)
}

/// Value of an optional key: that of an example, the default, or a group of defaults.
fn optional_value(starter: &Starter, schema: &Json, key: &str, source: &str) -> Result<YamlValue, ConfigError> {
    if !source.is_empty()
        && let YamlValue::Map(entries) = example(starter, source)?
        && let Some((_, node)) = entries.into_iter().find(|(name, _)| name == key)
    {
        return Ok(node.value);
    }
    let default = &schema["properties"][key]["default"];
    let value = serde_json::from_value::<YamlNode>(default.clone()).map(|node| node.value);
    Ok(value.ok().filter(|value| *value != YamlValue::Null).unwrap_or(YamlValue::Map(Vec::new())))
}

/// Text with a `#` in front of every line that is no comment.
fn switched_off(text: &str) -> String {
    let is_comment = |line: &str| line.trim_start().starts_with('#');
    text.lines().map(|line| if is_comment(line) { format!("{line}\n") } else { format!("#{line}\n") }).collect()
}

#[derive(Default)]
struct StarterWriter {
    text: String,
    /// Paths of keys that have their comment; `[]` stands for the elements of a list.
    seen: BTreeSet<String>,
    /// Other keys of mappings that are still to be offered.
    instead: Vec<Instead>,
}

impl StarterWriter {
    /// Writes the entries of a mapping. The first key of a list element follows its dash.
    fn map(&mut self, schema: &Json, entries: &[(String, YamlNode)], path: &str, indent: usize, is_element: bool) {
        let words = tag_words(schema);
        let schema = form(schema, entries);
        for (index, (key, node)) in entries.iter().enumerate() {
            let property = schema::property(schema, key);
            let is_any = property_is_any(schema, key);
            let is_first = is_element && index == 0;
            let lead = if is_first { format!("{}- ", " ".repeat(indent - 2)) } else { " ".repeat(indent) };
            let path = joined(path, if is_any { ANY_KEY } else { key });
            if !is_any && self.seen.insert(path.clone()) {
                let about = match &words {
                    Some((tag, words)) if tag == key => format!("{words}."),
                    _ => about(key, property),
                };
                self.comment(&about, if is_first { indent - 2 } else { indent });
            }
            match &node.value {
                YamlValue::Map(inner) if !inner.is_empty() => {
                    self.line(&format!("{lead}{key}:"));
                    self.map(property, inner, &path, indent + 2, false);
                    self.offer_instead(property, inner, &path, indent + 2);
                }
                YamlValue::List(items) if items.iter().any(|item| matches!(item.value, YamlValue::Map(_))) => {
                    self.line(&format!("{lead}{key}:"));
                    let elements = &list_form(property)["items"];
                    items.iter().for_each(|item| self.element(elements, item, &format!("{path}[]"), indent + 4));
                }
                value => self.line(&format!("{lead}{key}: {}", value.to_flow())),
            }
        }
    }

    /// Writes the other keys of a mapping, each behind a `#`, once.
    fn offer_instead(&mut self, schema: &Json, present: &[(String, YamlNode)], path: &str, indent: usize) {
        let Some(place) = self.instead.iter().position(|instead| instead.path == path) else { return };
        let instead = self.instead.remove(place);
        let Ok(YamlNode { value: YamlValue::Map(keys), .. }) = serde_saphyr::from_str(instead.keys) else { return };
        let present = present.iter().filter(|(key, _)| instead.replaced.is_empty() || key == instead.replaced);
        let present: Vec<String> = present.map(|(key, _)| format!("`{key}`")).collect();
        self.comment(&format!("Instead of {}:", present.join(" and ")), indent);
        let mut other = StarterWriter::default();
        other.map(schema, &keys, path, indent, false);
        let lead = " ".repeat(indent);
        for line in other.text.lines() {
            let key = line.trim_start();
            self.line(&if key.starts_with('#') { line.to_owned() } else { format!("{lead}#{key}") });
        }
    }

    /// Writes an element of a list: in one line if each of its keys has its comment and the line fits.
    fn element(&mut self, schema: &Json, node: &YamlNode, path: &str, indent: usize) {
        let line = format!("{}- {}", " ".repeat(indent - 2), node.value.flow(true));
        match &node.value {
            YamlValue::Map(entries) if !self.knows(&node.value, path) || line.chars().count() > WIDTH => {
                self.map(schema, entries, path, indent, true);
            }
            _ => self.line(&line),
        }
    }

    fn knows(&self, value: &YamlValue, path: &str) -> bool {
        match value {
            YamlValue::Map(entries) => entries.iter().all(|(key, node)| {
                let path = joined(path, key);
                self.seen.contains(&path) && self.knows(&node.value, &path)
            }),
            YamlValue::List(items) => items.iter().all(|item| self.knows(&item.value, &format!("{path}[]"))),
            _ => true,
        }
    }

    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn comment(&mut self, text: &str, indent: usize) {
        let lead = format!("{}#", " ".repeat(indent));
        let mut line = lead.clone();
        for word in text.split_whitespace() {
            if line.chars().count() + 1 + word.chars().count() > WIDTH && line.len() > lead.len() {
                self.line(&line);
                line.clone_from(&lead);
            }
            let _infallible = write!(line, " {word}");
        }
        if line.len() > lead.len() {
            self.line(&line);
        }
    }
}

/// Returns whether a mapping takes any key, this one among them.
fn property_is_any(schema: &Json, key: &str) -> bool {
    schema["properties"][key].is_null() && !schema["additionalProperties"].is_null()
}

fn joined(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// Meaning, unit and allowed values of a key.
fn about(key: &str, property: &Json) -> String {
    let declared = schema::key(key, property, false);
    let (mut facts, meaning) = (Vec::new(), schema::first_sentence(property));
    if !declared.unit().is_empty() {
        facts.push(declared.unit().to_owned());
    }
    match (declared.words.len(), property["x-allowed"].as_str()) {
        (2.., _) => facts.push(declared.words.join(", ")),
        (_, Some(allowed)) => facts.push(allowed.to_owned()),
        _ if declared.range.min.is_some() || declared.range.max.is_some() => facts.push(declared.allowed()),
        _ => {}
    }
    match (meaning.is_empty(), facts.is_empty()) {
        (true, _) => facts.join("; "),
        (false, true) => format!("{meaning}."),
        (false, false) => format!("{meaning} ({}).", facts.join("; ")),
    }
}

/// Key that distinguishes the forms of a value, and its words.
fn tag_words(schema: &Json) -> Option<(String, String)> {
    let forms = alternatives(schema)?;
    let forms: Vec<&Json> = forms.into_iter().filter(|form| types(form) != ["null"]).collect();
    let tag = tag(&forms).filter(|_| forms.len() > 1)?;
    let words: Vec<&str> = forms.iter().filter_map(|form| form["properties"][tag]["const"].as_str()).collect();
    Some((tag.to_owned(), format!("One of {}", words.join(", "))))
}

/// Form of a mapping that may have several.
fn form<'a>(schema: &'a Json, entries: &[(String, YamlNode)]) -> &'a Json {
    let Some(forms) = alternatives(schema) else { return schema };
    let forms: Vec<&Json> = forms.into_iter().filter(|form| form["properties"].is_object()).collect();
    let word = tag(&forms).and_then(|tag| {
        let (_, node) = entries.iter().find(|(key, _)| key == tag)?;
        match &node.value {
            YamlValue::Text(word) => Some((tag, word)),
            _ => None,
        }
    });
    let fits = |form: &&&Json| word.is_none_or(|(tag, word)| form["properties"][tag]["const"] == **word);
    forms.iter().find(fits).copied().unwrap_or(schema)
}

/// Form of a value that may be a list.
fn list_form(schema: &Json) -> &Json {
    let forms = alternatives(schema).unwrap_or_default();
    forms.into_iter().find(|form| form["items"].is_object()).unwrap_or(schema)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::Located;
    use crate::{any_job, machine_file, study_file};

    fn read(kind: FileKind, text: &str) -> Result<(), Vec<ConfigError>> {
        match kind {
            FileKind::Machine => machine_file::read("my.yaml".as_ref(), text, &[]).map(drop),
            FileKind::Study => study_file::read(&Located::new("my.yaml", text), &[]).map(drop),
            _ => any_job::read(&Located::new("my.yaml", text), &[]).map(drop),
        }
    }

    /// Values of a document without its lines.
    fn values(text: &str) -> Json {
        Document::parse("my.yaml".as_ref(), text, &[]).expect("YAML").root.to_json()
    }

    #[test]
    fn a_starter_file_is_its_example_under_another_name() {
        for kind in FileKind::ALL {
            let text = kind.starter_file("mine").expect("a shipped example");
            assert_eq!(read(kind, &text), Ok(()), "{text}");
            let starter = kind.starter();
            let shipped = locate(starter.folder, starter.example, "yaml", None).expect("a shipped file").text;
            let mut expected = values(&shipped);
            expected["name"] = "mine".into();
            assert_eq!(values(&text), expected, "{text}");
        }
    }

    #[test]
    fn each_key_has_its_comment_once_and_comments_fit_the_width() {
        for kind in FileKind::ALL {
            let text = kind.starter_file("mine").expect("a shipped example");
            assert!(text.lines().all(|line| line.chars().count() <= WIDTH + 20), "{text}");
            let keys = schema::keys(&kind.schema());
            for key in keys.iter().filter(|key| key.is_required && !key.path.contains('.')) {
                let lines: Vec<&str> = text.lines().collect();
                let at = lines.iter().position(|line| line.starts_with(&format!("{}:", key.path)));
                let at = at.unwrap_or_else(|| panic!("{} is missing: {text}", key.path));
                assert!(lines[at - 1].trim_start().starts_with("# "), "{} has no comment: {text}", key.path);
            }
        }
        let text = FileKind::Machine.starter_file("mine").expect("a shipped example");
        assert!(text.contains("# Speed limit (mm/s; 0.001 to 10000).\n  max_speed_mm_s: 500.0\n"), "{text}");
        assert!(text.contains("\n  - {switch: LS2, position_mm: 125.0}\n"), "{text}");
    }

    /// A job with a table needs nothing but the name of the table.
    #[test]
    fn a_table_can_take_the_place_of_the_motion_laws() {
        let text = FileKind::Job.starter_file("mine").expect("a shipped example");
        let mut kept = Vec::new();
        let mut is_law = false;
        for line in text.lines() {
            let key = line.trim_start();
            is_law = match () {
                () if key.starts_with("segments:") => true,
                () if line.starts_with("      # Instead of ") => false,
                () => is_law,
            };
            match key.strip_prefix('#').filter(|key| !key.starts_with(' ') && line.starts_with("      #")) {
                Some(key) => kept.push(format!("      {key}")),
                None if is_law || key.starts_with("repeat:") => {}
                None => kept.push(line.to_owned()),
            }
        }
        let changed = kept.join("\n").replace("my_lift.csv", "intake");
        assert!(
            changed.contains("      table: intake\n") && changed.contains("      decimal_comma: false\n"),
            "{changed}"
        );
        assert_eq!(read(FileKind::Job, &changed), Ok(()), "{changed}");
    }

    #[test]
    fn the_name_of_a_file_becomes_a_name() {
        assert_eq!(starter_name("my_cam-2"), "my_cam-2");
        assert_eq!(starter_name("my cam.v2"), "my_cam_v2");
        assert_eq!(starter_name(""), "mine");
        assert_eq!(starter_name(&"x".repeat(200)), "x".repeat(MAX_NAME));
    }

    #[test]
    fn every_optional_key_can_be_switched_on() {
        for kind in FileKind::ALL {
            let text = kind.starter_file("mine").expect("a shipped example");
            let is_offered = |line: &str| line.starts_with('#') && !line.starts_with("# ");
            let mut count = 0;
            for (start, _) in text.lines().enumerate().filter(|(_, line)| is_offered(line)) {
                count += 1;
                // This key with the lines of its group.
                let group = text.lines().skip(start + 1);
                let group = group.take_while(|line| line.starts_with("#  ") || line.starts_with("  ")).count();
                let switch = |(index, line): (usize, &str)| match (start..=start + group).contains(&index) {
                    true => format!("{}\n", line.strip_prefix('#').unwrap_or(line)),
                    false => format!("{line}\n"),
                };
                let changed: String = text.lines().enumerate().map(switch).collect();
                assert_eq!(read(kind, &changed), Ok(()), "{changed}");
            }
            assert_eq!(count, kind.starter().optional.len(), "{text}");
        }
    }
}
