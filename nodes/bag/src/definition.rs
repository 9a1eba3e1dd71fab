// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Type definitions stored in a bag (`ros2msg`): sufficient to find every value in a message of an unknown type.

use camwright_msgs::syntax::{Element, Multiplicity, Primitive, TypeError, TypeText, split_comment};
use std::collections::{BTreeMap, BTreeSet};

/// Types that a type may use: far more than any does, and few enough for a message to be read by recursion.
const MAX_TYPES: usize = 256;

/// Type of one element of a field.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum FieldKind {
    Primitive(Primitive),
    /// Text, with its maximum length in bytes if it is bounded.
    Text(Option<usize>),
    /// Another type, by its number in [`TypeDefinition::types`].
    Nested(usize),
}

/// A field of a type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) kind: FieldKind,
    pub(super) shape: Multiplicity,
}

/// A type and those it uses; the type itself is the first.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct TypeDefinition {
    pub(super) types: Vec<Vec<Field>>,
}

impl TypeDefinition {
    /// Reads the text of a channel's schema.
    ///
    /// # Errors
    /// One sentence about the line that cannot be understood, or the type that is missing.
    pub(super) fn parse(type_name: &str, text: &str) -> Result<Self, String> {
        let separator = "=".repeat(80);
        let mut texts = Vec::new();
        for (index, part) in text.split(&separator).enumerate() {
            let (name, body) = match part.trim_start_matches(['\r', '\n']).split_once('\n') {
                _ if index == 0 => (short(type_name), part),
                Some((line, body)) => {
                    let name =
                        line.trim().strip_prefix("MSG:").ok_or_else(|| format!("'{line}' does not name a type"))?;
                    (short(name.trim()), body)
                }
                // A type without a field ends the text.
                None => (short(part.trim().strip_prefix("MSG:").unwrap_or_default().trim()), ""),
            };
            texts.push((name, body));
        }
        if texts.len() > MAX_TYPES {
            return Err(format!("{} types are used, {MAX_TYPES} are allowed", texts.len()));
        }
        let numbers: BTreeMap<String, usize> =
            texts.iter().enumerate().rev().map(|(index, (name, _))| (name.clone(), index)).collect();
        let types = texts.iter().map(|(name, body)| {
            let package = name.split('/').next().unwrap_or_default();
            let lines = body.lines().map(|line| split_comment(line).0.trim());
            lines
                .filter(|line| !line.is_empty())
                .filter_map(|line| field(line, package, &numbers).transpose())
                .collect()
        });
        let types: Vec<Vec<Field>> = types.collect::<Result<_, _>>()?;
        for fields in &types {
            let mut named = BTreeSet::new();
            if let Some(twice) = fields.iter().find(|field| !named.insert(field.name.as_str())) {
                return Err(format!("the field {} is there twice", twice.name));
            }
        }
        let definition = Self { types };
        definition.refuse_endless()?;
        Ok(definition)
    }

    /// A type that holds itself has no end: ROS has no such types.
    fn refuse_endless(&self) -> Result<(), String> {
        // Types of which everything within is known to end; each round finds some more, unless the rest hold each other.
        let mut ends = vec![false; self.types.len()];
        loop {
            let is_ending = |field: &Field| match field.kind {
                FieldKind::Nested(inner) => ends[inner],
                _ => true,
            };
            let found: Vec<bool> = self.types.iter().map(|fields| fields.iter().all(is_ending)).collect();
            if found == ends {
                break;
            }
            ends = found;
        }
        if ends.first().is_none_or(|ends| *ends) { Ok(()) } else { Err("a type holds itself".into()) }
    }
}

/// `package/Type`, without what stands between.
fn short(name: &str) -> String {
    let mut parts = name.split('/');
    match (parts.next(), parts.next_back()) {
        (Some(package), Some(name)) => format!("{package}/{name}"),
        _ => name.to_owned(),
    }
}

/// A line's field; none where it is a constant.
fn field(line: &str, package: &str, numbers: &BTreeMap<String, usize>) -> Result<Option<Field>, String> {
    let mut words = line.splitn(2, char::is_whitespace);
    let (kind, rest) = (words.next().unwrap_or_default(), words.next().unwrap_or_default().trim());
    let name: String = rest.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
    if name.is_empty() {
        return Err(format!("'{line}' is no field"));
    }
    if rest[name.len()..].trim_start().starts_with('=') {
        return Ok(None);
    }
    let read = TypeText::parse(kind).map_err(|error| match error {
        TypeError::Unclosed | TypeError::Unopened => format!("'{line}': a bracket is open"),
        TypeError::Size(size) => format!("'{line}': '{size}' is no number of elements"),
        TypeError::Length(length) => format!("'{line}': '{length}' is no length"),
    })?;
    let kind = match read.element {
        Element::Primitive(primitive) => FieldKind::Primitive(primitive),
        Element::Text(bound) => FieldKind::Text(bound),
        Element::Named(base) => nested(&full_name(base, package), numbers)?,
    };
    Ok(Some(Field { name, kind, shape: read.shape }))
}

/// `package/Type` of a field's type, which within a package may be named without it.
fn full_name(base: &str, package: &str) -> String {
    match base {
        "Header" => "std_msgs/Header".to_owned(),
        other if other.contains('/') => short(other),
        other => format!("{package}/{other}"),
    }
}

/// `package/Type` of every type that the fields of a definition have.
pub fn used_by(package: &str, definition: &str) -> BTreeSet<String> {
    let types = definition.lines().filter_map(|line| split_comment(line).0.split_whitespace().next());
    let elements = types.filter_map(|text| TypeText::parse(text).ok()).map(|read| read.element);
    let named = elements.filter_map(|element| match element {
        // Types without a package, whose values are not read here.
        Element::Named(base) if base.starts_with("wstring") || base == "float128" => None,
        Element::Named(base) => Some(full_name(base, package)),
        Element::Primitive(_) | Element::Text(_) => None,
    });
    named.collect()
}

fn nested(name: &str, numbers: &BTreeMap<String, usize>) -> Result<FieldKind, String> {
    numbers.get(name).copied().map(FieldKind::Nested).ok_or_else(|| format!("the type {name} is not defined"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_of_ours_is_read_as_the_generator_reads_it() {
        for info in camwright_msgs::ALL.iter().filter(|info| !info.schema.is_empty()) {
            let definition = TypeDefinition::parse(info.type_name, info.schema).expect(info.type_name);
            let names: Vec<&str> = definition.types[0].iter().map(|field| field.name.as_str()).collect();
            let expected: Vec<&str> = info.fields.iter().map(|field| field.name).collect();
            // A type without fields has one that stands for it, which no file shows.
            if expected != ["structure_needs_at_least_one_member"] {
                assert_eq!(names, expected, "{}", info.type_name);
            }
        }
    }

    #[test]
    fn what_cannot_be_understood_is_refused_with_its_line() {
        let parse = |text: &str| TypeDefinition::parse("a/msg/A", text).expect_err("it is wrong");
        assert_eq!(parse("Riddle r\n"), "the type a/Riddle is not defined");
        assert_eq!(parse("float64[3 r\n"), "'float64[3 r': a bracket is open");
        assert_eq!(parse("float64\n"), "'float64' is no field");
        assert_eq!(parse("A a\n"), "a type holds itself");
        assert_eq!(parse("A[] a\n"), "a type holds itself");
        let line = "=".repeat(80);
        assert_eq!(parse(&format!("B b\n{line}\nB\nint8 x\n")), "'B' does not name a type");
        let good =
            TypeDefinition::parse("a/msg/A", "int8 X = 3\nint8[<=4] b 1 # c\nstring<=3[2] s\n").expect("it is right");
        let field = |name: &str, kind, shape| Field { name: name.into(), kind, shape };
        let int8 = FieldKind::Primitive(Primitive::Int8);
        let fields = [
            field("b", int8, Multiplicity::BoundedSequence(4)),
            field("s", FieldKind::Text(Some(3)), Multiplicity::Array(2)),
        ];

        assert_eq!(good.types, [fields]);
        assert_eq!(parse("int8 a\nint16 a\n"), "the field a is there twice");
        assert_eq!(parse("int8[0] a\n"), "'int8[0] a': '0' is no number of elements");
        assert_eq!(parse("int8[<=x] a\n"), "'int8[<=x] a': '<=x' is no number of elements");
        assert_eq!(parse("string<=x a\n"), "'string<=x a': 'x' is no length");
    }
}
