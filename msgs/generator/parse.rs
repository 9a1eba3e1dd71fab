// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Reads the text of one interface.

use super::model::{Base, Constant, Definition, Field, FieldType, Kind, Multiplicity, TypeName};
use super::syntax::{Element, TypeError, TypeText, split_comment};
use super::value;

/// Error in a text, and its line (from 1).
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Fault {
    pub(crate) line: usize,
    pub(crate) what: String,
}

/// Something with a comment that later comment lines may extend.
enum Commented {
    Field,
    Constant,
}

/// Splits a `.srv` or `.action` text at its `---` lines into exactly `parts` texts, each with its first line's number.
///
/// # Errors
/// A different number of parts.
pub(crate) fn split(text: &str, parts: usize) -> Result<Vec<(usize, String)>, Fault> {
    let mut found = vec![(1, String::new())];
    for (index, line) in text.lines().enumerate() {
        if line == "---" {
            found.push((index + 2, String::new()));
        } else if let Some((_, part)) = found.last_mut() {
            part.push_str(line);
            part.push('\n');
        }
    }
    if found.len() == parts {
        Ok(found)
    } else {
        Err(Fault { line: 0, what: format!("{} parts between --- lines where {parts} belong", found.len()) })
    }
}

/// Reads one message.
///
/// # Errors
/// The first line that is not a field, a constant or a comment, or that names something twice.
pub(crate) fn message(package: &str, text: &str) -> Result<Definition, Fault> {
    let mut definition = Definition { text: text.to_owned(), ..Definition::default() };
    let mut pending: Vec<String> = Vec::new();
    let mut last: Option<Commented> = None;
    let mut in_heading = true;
    for (index, raw) in text.lines().enumerate() {
        let fault = |what: String| Fault { line: index + 1, what };
        let raw = raw.replace('\t', " ");
        // Comment lines at the very top, up to the first other line, speak of the message.
        in_heading = in_heading && raw.starts_with('#');
        let (code, comment) = split_comment(&raw);
        let comment = comment.map(|comment| comment.trim_start_matches('#').trim().to_owned());
        if let Some(comment) = comment.filter(|comment| !comment.contains("SPDX-License-Identifier:")) {
            if in_heading {
                definition.comment.push(comment);
                continue;
            }
            if !code.is_empty() && code.trim().is_empty() {
                // An indented comment line goes on about what stands above it.
                match last {
                    Some(Commented::Field) => definition.fields.last_mut().map(|field| field.comment.push(comment)),
                    Some(Commented::Constant) => definition.constants.last_mut().map(|c| c.comment.push(comment)),
                    None => None,
                };
                continue;
            }
            pending.push(comment);
        }
        let code = code.trim_end();
        if code.is_empty() {
            continue;
        }
        let comment = std::mem::take(&mut pending);
        last = Some(element(package, code, comment, &mut definition).map_err(fault)?);
    }
    Ok(definition)
}

/// Reads a line without its comment.
fn element(package: &str, code: &str, comment: Vec<String>, definition: &mut Definition) -> Result<Commented, String> {
    let (type_text, rest) = code.split_once(' ').ok_or_else(|| format!("{code} is a type without a name"))?;
    let rest = rest.trim_start();
    if type_text.is_empty() {
        return Err(format!("{} is indented", code.trim_start()));
    }
    if rest.is_empty() {
        return Err(format!("{code} is a type without a name"));
    }
    let ty = field_type(package, type_text)?;
    if let Some((name, text)) = rest.split_once('=') {
        let (name, text) = (name.trim_end(), text.trim_start());
        if ty.shape != Multiplicity::One || matches!(ty.base, Base::Nested(_) | Base::Text(Some(_))) {
            return Err(format!("a constant cannot be a {type_text}"));
        }
        if !is_constant_name(name) {
            return Err(format!("{name} is no name for a constant (capitals, digits, single underscores)"));
        }
        if definition.constants.iter().any(|other| other.name == name) {
            return Err(format!("the constant {name} is defined twice"));
        }
        let value = value::from_base(&ty.base, text)?;
        definition.constants.push(Constant { name: name.to_owned(), base: ty.base, value, comment });
        return Ok(Commented::Constant);
    }
    let (name, text) = rest.split_once(' ').unwrap_or((rest, ""));
    if !is_field_name(name) {
        return Err(format!("{name} is no name for a field (lower case, digits, single underscores)"));
    }
    if definition.fields.iter().any(|other| other.name == name) {
        return Err(format!("the field {name} is defined twice"));
    }
    let text = text.trim_start();
    let default = if text.is_empty() { None } else { Some(value::from_field(&ty, text)?) };
    definition.fields.push(Field { name: name.to_owned(), ty, default, comment });
    Ok(Commented::Field)
}

/// Reads a type, for example `string<=32[]` or `geometry_msgs/Point[<=4]`.
///
/// # Errors
/// What is wrong with it, as a clause.
pub(crate) fn field_type(package: &str, text: &str) -> Result<FieldType, String> {
    let size = || format!("the size of {text} must be an integer above 0");
    let element_text = text.split('[').next().unwrap_or_default();
    let length = || format!("the bound of {element_text} must be an integer above 0");
    let read = TypeText::parse(text).map_err(|error| match error {
        TypeError::Unclosed => format!("{text} opens a bracket it never closes"),
        TypeError::Unopened => format!("{text} closes a bracket it never opened"),
        TypeError::Size(_) => size(),
        TypeError::Length(_) => length(),
    })?;
    if read.shape == Multiplicity::BoundedSequence(0) {
        return Err(size());
    }
    let base = match read.element {
        Element::Text(Some(0)) => return Err(length()),
        Element::Text(bound) => Base::Text(bound),
        Element::Primitive(primitive) => Base::Primitive(primitive),
        Element::Named(name) => nested(package, name)?,
    };
    Ok(FieldType { base, shape: read.shape })
}

fn nested(package: &str, text: &str) -> Result<Base, String> {
    if text.starts_with("wstring") {
        return Err("wstring does not travel between implementations; use string".to_owned());
    }
    if text == "time" || text == "duration" {
        return Err(format!("{text} is ROS 1; use builtin_interfaces/Time or Duration"));
    }
    let (package, name) = text.split_once('/').unwrap_or((package, text));
    if !is_field_name(package) {
        return Err(format!("{package} is no name for a package"));
    }
    if !is_message_name(name) {
        return Err(format!("{name} is no name for a message"));
    }
    Ok(Base::Nested(TypeName::new(package, Kind::Msg, name)))
}

fn is_field_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
        && !name.contains("__")
        && !name.ends_with('_')
}

fn is_constant_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_uppercase())
        && name.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_')
        && !name.contains("__")
        && !name.ends_with('_')
}

/// Returns whether a message, service or action may have this name.
pub(crate) fn is_message_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_uppercase()) && name.chars().all(|c| c.is_ascii_alphanumeric())
}
