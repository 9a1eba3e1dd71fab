// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Parameter files: YAML with node names, wildcards and `ros__parameters`, as `rcl_yaml_param_parser` reads them.

use std::{fmt, path::Path};

use serde::de::{Deserialize, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};

use super::parameter_value::ParameterValue;

/// The key below which a node's parameters stand.
const PARAMETERS: &str = "ros__parameters";

/// The parameters one entry of a file sets.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeParameters {
    /// Fully qualified node name with `*` and `**`.
    pattern: String,
    /// Flattened, `group.name`, in file order.
    pub(super) parameters: Vec<(String, ParameterValue)>,
}

impl NodeParameters {
    /// Fully qualified node name with `*` and `**`.
    #[must_use]
    pub fn pattern(&self) -> &str {
        &self.pattern
    }

    /// Names, `group.name`, and values in file order.
    #[must_use]
    pub fn parameters(&self) -> &[(String, ParameterValue)] {
        &self.parameters
    }

    pub(super) fn applies_to(&self, fully_qualified: &str) -> bool {
        let split = |name: &str| -> Vec<String> { name.split('/').skip(1).map(str::to_string).collect() };
        matches(&split(&self.pattern), &split(fully_qualified))
    }

    pub(super) fn has_wildcard(&self) -> bool {
        self.pattern.contains('*')
    }
}

/// `*` is exactly one token, `**` any number of them, none included.
fn matches(pattern: &[String], name: &[String]) -> bool {
    match pattern.split_first() {
        None => name.is_empty(),
        Some((first, rest)) if first == "**" => (0..=name.len()).any(|skip| matches(rest, &name[skip..])),
        Some((first, rest)) => match name.split_first() {
            Some((token, others)) => (first == "*" || first == token) && matches(rest, others),
            None => false,
        },
    }
}

/// YAML without a schema.
#[derive(Debug, Clone, PartialEq)]
enum Yaml {
    Null,
    Bool(bool),
    Integer(i64),
    Float(f64),
    String(String),
    List(Vec<Yaml>),
    Map(Vec<(String, Yaml)>),
}

impl<'de> Deserialize<'de> for Yaml {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = Yaml;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("YAML")
            }
            fn visit_unit<E>(self) -> Result<Yaml, E> {
                Ok(Yaml::Null)
            }
            fn visit_none<E>(self) -> Result<Yaml, E> {
                Ok(Yaml::Null)
            }
            fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Yaml, D::Error> {
                Yaml::deserialize(deserializer)
            }
            fn visit_bool<E>(self, value: bool) -> Result<Yaml, E> {
                Ok(Yaml::Bool(value))
            }
            fn visit_i64<E>(self, value: i64) -> Result<Yaml, E> {
                Ok(Yaml::Integer(value))
            }
            fn visit_u64<E>(self, value: u64) -> Result<Yaml, E> {
                Ok(i64::try_from(value).map_or(Yaml::Float(value as f64), Yaml::Integer))
            }
            fn visit_f64<E>(self, value: f64) -> Result<Yaml, E> {
                Ok(Yaml::Float(value))
            }
            fn visit_str<E>(self, value: &str) -> Result<Yaml, E> {
                Ok(Yaml::String(value.to_string()))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Yaml, A::Error> {
                let mut list = Vec::new();
                while let Some(item) = seq.next_element()? {
                    list.push(item);
                }
                Ok(Yaml::List(list))
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Yaml, A::Error> {
                let mut entries: Vec<(String, Yaml)> = Vec::new();
                while let Some(key) = map.next_key::<String>()? {
                    let value = map.next_value()?;
                    if entries.iter().any(|(other, _)| *other == key) {
                        return Err(A::Error::custom(format!("key '{key}' appears twice")));
                    }
                    entries.push((key, value));
                }
                Ok(Yaml::Map(entries))
            }
        }
        deserializer.deserialize_any(Any)
    }
}

fn read_yaml(text: &str) -> Result<Yaml, String> {
    let options = serde_saphyr::options! {
        // `.inf` is a way to switch a limit off.
        non_finite_float_policy: serde_saphyr::options::NonFiniteFloatPolicy::PassThrough,
        // rcl reads YAML 1.1, where 010 is eight.
        legacy_octal_numbers: true,
    };
    // The first line of the parser's message says it; the rest is a picture of the source.
    serde_saphyr::from_str_with_options(text, options)
        .map_err(|error| error.to_string().lines().next().unwrap_or_default().to_string())
}

/// Reads a parameter file.
pub(super) fn read(path: &Path) -> Result<Vec<NodeParameters>, String> {
    parse(&std::fs::read_to_string(path).map_err(|error| error.to_string())?)
}

/// Reads the text of a parameter file.
///
/// # Errors
/// The text is no parameter file.
pub fn parse(text: &str) -> Result<Vec<NodeParameters>, String> {
    let yaml = read_yaml(text)?;
    let Yaml::Map(entries) = yaml else { return Err("is not a mapping of node names".into()) };
    let mut found = Vec::new();
    for (name, value) in entries {
        let prefix = if name.starts_with('/') { name } else { format!("/{name}") };
        walk(&prefix, value, &mut found)?;
    }
    Ok(found)
}

/// Goes down the namespaces until `ros__parameters`.
fn walk(prefix: &str, value: Yaml, found: &mut Vec<NodeParameters>) -> Result<(), String> {
    let Yaml::Map(entries) = value else {
        return Err(format!("'{prefix}': a value without a node; write parameters below '{PARAMETERS}'"));
    };
    if entries.is_empty() {
        return Err(format!("'{prefix}' is empty"));
    }
    for (name, value) in entries {
        if name == PARAMETERS {
            let mut parameters = Vec::new();
            match value {
                Yaml::Map(entries) => flatten("", entries, &mut parameters).map_err(|e| format!("'{prefix}': {e}"))?,
                _ => return Err(format!("'{prefix}': '{PARAMETERS}' is not a mapping")),
            }
            check_pattern(prefix)?;
            found.push(NodeParameters { pattern: prefix.to_string(), parameters });
        } else {
            let child = format!("{}/{}", prefix.trim_end_matches('/'), name.trim_start_matches('/'));
            walk(&child, value, found)?;
        }
    }
    Ok(())
}

fn check_pattern(pattern: &str) -> Result<(), String> {
    for token in pattern.split('/').skip(1) {
        if token != "*" && token != "**" {
            super::names::check_node_name(token).map_err(|error| format!("'{pattern}': {error}"))?;
        }
    }
    Ok(())
}

fn flatten(prefix: &str, entries: Vec<(String, Yaml)>, into: &mut Vec<(String, ParameterValue)>) -> Result<(), String> {
    for (name, value) in entries {
        if name.is_empty() {
            return Err("a parameter without a name".into());
        }
        let name = if prefix.is_empty() { name } else { format!("{prefix}.{name}") };
        match value {
            Yaml::Map(entries) => flatten(&name, entries, into)?,
            value => {
                let value = to_value(value).map_err(|reason| format!("parameter '{name}': {reason}"))?;
                into.push((name, value));
            }
        }
    }
    Ok(())
}

/// Reads the right side of `-p name:=value`.
pub(super) fn parse_value(text: &str) -> Result<ParameterValue, String> {
    to_value(read_yaml(text)?)
}

fn to_value(yaml: Yaml) -> Result<ParameterValue, String> {
    match yaml {
        Yaml::Null => Err("has no value".into()),
        Yaml::Bool(value) => Ok(ParameterValue::Bool(value)),
        Yaml::Integer(value) => Ok(ParameterValue::Integer(value)),
        Yaml::Float(value) => Ok(ParameterValue::Double(value)),
        Yaml::String(value) => Ok(ParameterValue::String(value)),
        Yaml::List(items) => list(items),
        Yaml::Map(_) => Err("a mapping is not a value".into()),
    }
}

/// Lists hold one type only. An empty one fits any array type and reads as one of strings.
fn list(items: Vec<Yaml>) -> Result<ParameterValue, String> {
    fn all<T>(items: &[Yaml], pick: impl Fn(&Yaml) -> Option<T>) -> Result<Vec<T>, String> {
        items.iter().map(|item| pick(item).ok_or_else(|| "the elements of a list must be of one type".into())).collect()
    }
    match items.first() {
        None => Ok(ParameterValue::StringArray(Vec::new())),
        Some(Yaml::Bool(_)) => {
            all(&items, |i| if let Yaml::Bool(v) = i { Some(*v) } else { None }).map(ParameterValue::BoolArray)
        }
        Some(Yaml::Integer(_)) => {
            all(&items, |i| if let Yaml::Integer(v) = i { Some(*v) } else { None }).map(ParameterValue::IntegerArray)
        }
        Some(Yaml::Float(_)) => {
            all(&items, |i| if let Yaml::Float(v) = i { Some(*v) } else { None }).map(ParameterValue::DoubleArray)
        }
        Some(Yaml::String(_)) => all(&items, |i| if let Yaml::String(v) = i { Some(v.clone()) } else { None })
            .map(ParameterValue::StringArray),
        Some(Yaml::Null) => Err("an element of the list has no value".into()),
        Some(Yaml::List(_) | Yaml::Map(_)) => Err("a list holds plain values only".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_for(entries: &[NodeParameters], node: &str) -> Vec<String> {
        entries
            .iter()
            .filter(|entry| entry.applies_to(node))
            .flat_map(|entry| entry.parameters.iter().map(|(name, value)| format!("{name}={value:?}")))
            .collect()
    }

    #[test]
    fn wildcards_and_nested_namespaces_find_their_nodes_in_file_order() {
        let text = r#"
/**:
  ros__parameters: {a: 1}
/*:
  ros__parameters: {b: 2}
/**/planner:
  ros__parameters: {c: 3}
/cell/*/machine:
  ros__parameters: {d: 4}
/cell:
  planner:
    ros__parameters:
      group: {x: 1.0, deep: {y: text}}
      array: [1.0, 2.0]
  "*":
    ros__parameters: {e: 5}
planner:
  ros__parameters: {f: 6}
"#;
        let entries = parse(text).expect("valid");
        assert_eq!(names_for(&entries, "/planner"), ["a=Integer(1)", "b=Integer(2)", "c=Integer(3)", "f=Integer(6)"]);
        assert_eq!(
            names_for(&entries, "/cell/planner"),
            [
                "a=Integer(1)",
                "c=Integer(3)",
                "group.x=Double(1.0)",
                "group.deep.y=String(\"text\")",
                "array=DoubleArray([1.0, 2.0])",
                "e=Integer(5)"
            ]
        );
        assert_eq!(names_for(&entries, "/cell/one/machine"), ["a=Integer(1)", "d=Integer(4)"]);
        assert_eq!(names_for(&entries, "/x/y/z"), ["a=Integer(1)"]);
    }

    #[test]
    fn scalars_have_the_types_yaml_gives_them() {
        use ParameterValue as V;
        for (text, value) in [
            ("true", V::Bool(true)),
            ("-7", V::Integer(-7)),
            ("7.", V::Double(7.0)),
            (".inf", V::Double(f64::INFINITY)),
            ("'7'", V::String("7".into())),
            ("!!str 1234", V::String("1234".into())),
            ("hello world", V::String("hello world".into())),
            ("[true, false]", V::BoolArray(vec![true, false])),
            ("[]", V::StringArray(vec![])),
        ] {
            assert_eq!(parse_value(text), Ok(value), "{text}");
        }
        assert!(matches!(parse_value(".nan"), Ok(V::Double(x)) if x.is_nan()));
    }

    #[test]
    fn what_has_no_meaning_is_refused() {
        for text in [
            "a: 1",
            "node: {}",
            "node:\n  ros__parameters: 3",
            "node:\n  ros__parameters: {a: }",
            "node:\n  ros__parameters: {a: [1, 2.0]}",
            "node:\n  ros__parameters: {a: [{b: 1}]}",
            "node:\n  ros__parameters: {a: [[1]]}",
            "node:\n  ros__parameters: {a: 1, a: 2}",
            "'no de':\n  ros__parameters: {a: 1}",
            "[1, 2]",
            "node: [",
        ] {
            assert!(parse(text).is_err(), "accepted: {text}: {:?}", parse(text));
        }
    }
}
