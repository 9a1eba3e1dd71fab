//! What a bag itself says of its types (`ros2msg`): enough to find every value in a message without knowing the type beforehand.

use std::collections::{BTreeMap, BTreeSet};

/// Types that a type may use: far more than any does, and few enough for a message to be read by recursion.
const MOST_TYPES: usize = 256;

/// What a field is made of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Kind {
    Bool,
    Int8,
    Uint8,
    Int16,
    Uint16,
    Int32,
    Uint32,
    Int64,
    Uint64,
    Float32,
    Float64,
    /// So many bytes at most, where a bound is told.
    Text(Option<usize>),
    /// Another type, by its number in [`Definition::types`].
    Nested(usize),
}

/// How many of it there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Count {
    One,
    Array(usize),
    /// As many as the message says, and at most so many where a bound is told.
    Sequence(Option<usize>),
}

/// A field of a type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) count: Count,
}

/// A type and those it uses; the type itself is the first.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Definition {
    pub(super) types: Vec<Vec<Field>>,
}

impl Definition {
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
        if texts.len() > MOST_TYPES {
            return Err(format!("{} types are used, {MOST_TYPES} are allowed", texts.len()));
        }
        let numbers: BTreeMap<String, usize> =
            texts.iter().enumerate().rev().map(|(index, (name, _))| (name.clone(), index)).collect();
        let types = texts.iter().map(|(name, body)| {
            let package = name.split('/').next().unwrap_or_default();
            let lines = body.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
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
                Kind::Nested(inner) => ends[inner],
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
    let (base, count) = match kind.split_once('[') {
        None => (kind, Count::One),
        Some((base, bound)) => {
            let bound = bound.strip_suffix(']').ok_or_else(|| format!("'{line}': a bracket is open"))?;
            (base, count(bound).ok_or_else(|| format!("'{line}': '{bound}' is no number of elements"))?)
        }
    };
    let (base, most) = match base.split_once("<=") {
        None => (base, None),
        Some((base, most)) => (base, Some(most.parse().map_err(|_| format!("'{line}': '{most}' is no length"))?)),
    };
    let kind = match primitive(base) {
        Some(Kind::Text(_)) => Kind::Text(most),
        Some(kind) => kind,
        None => nested(&full_name(base, package), numbers)?,
    };
    Ok(Some(Field { name, kind, count }))
}

/// What stands in the brackets of a field. ROS has no arrays of no elements, which would hold any number of types in no byte.
fn count(bound: &str) -> Option<Count> {
    match bound.strip_prefix("<=") {
        Some(most) => most.parse().ok().map(|most| Count::Sequence(Some(most))),
        None if bound.is_empty() => Some(Count::Sequence(None)),
        None => bound.parse().ok().filter(|count| *count > 0).map(Count::Array),
    }
}

/// What is no type of a package.
fn primitive(base: &str) -> Option<Kind> {
    Some(match base {
        "bool" => Kind::Bool,
        "int8" => Kind::Int8,
        "uint8" | "byte" | "char" => Kind::Uint8,
        "int16" => Kind::Int16,
        "uint16" => Kind::Uint16,
        "int32" => Kind::Int32,
        "uint32" => Kind::Uint32,
        "int64" => Kind::Int64,
        "uint64" => Kind::Uint64,
        "float32" => Kind::Float32,
        "float64" => Kind::Float64,
        "string" => Kind::Text(None),
        _ => return None,
    })
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
    let fields = definition.lines().filter_map(|line| line.split('#').next()?.split_whitespace().next());
    // Arrays and bounds belong to the field.
    let bases = fields.map(|kind| kind.split(['[', '<']).next().unwrap_or(kind));
    // These two have no values that we read, and are no types of a package either.
    let is_used = |base: &&str| primitive(base).is_none() && !matches!(*base, "wstring" | "float128");
    bases.filter(is_used).map(|base| full_name(base, package)).collect()
}

fn nested(name: &str, numbers: &BTreeMap<String, usize>) -> Result<Kind, String> {
    numbers.get(name).copied().map(Kind::Nested).ok_or_else(|| format!("the type {name} is not defined"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_of_ours_is_read_as_the_generator_reads_it() {
        for info in camwright_msgs::ALL.iter().filter(|info| !info.schema.is_empty()) {
            let definition = Definition::parse(info.type_name, info.schema).expect(info.type_name);
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
        let parse = |text: &str| Definition::parse("a/msg/A", text).expect_err("it is wrong");
        assert_eq!(parse("Riddle r\n"), "the type a/Riddle is not defined");
        assert_eq!(parse("float64[3 r\n"), "'float64[3 r': a bracket is open");
        assert_eq!(parse("float64\n"), "'float64' is no field");
        assert_eq!(parse("A a\n"), "a type holds itself");
        assert_eq!(parse("A[] a\n"), "a type holds itself");
        let line = "=".repeat(80);
        assert_eq!(parse(&format!("B b\n{line}\nB\nint8 x\n")), "'B' does not name a type");
        let good =
            Definition::parse("a/msg/A", "int8 X = 3\nint8[<=4] b 1 # c\nstring<=3[2] s\n").expect("it is right");
        let field = |name: &str, kind, count| Field { name: name.into(), kind, count };
        let fields =
            [field("b", Kind::Int8, Count::Sequence(Some(4))), field("s", Kind::Text(Some(3)), Count::Array(2))];
        assert_eq!(good.types, [fields]);
        assert_eq!(parse("int8 a\nint16 a\n"), "the field a is there twice");
        assert_eq!(parse("int8[0] a\n"), "'int8[0] a': '0' is no number of elements");
        assert_eq!(parse("int8[<=x] a\n"), "'int8[<=x] a': '<=x' is no number of elements");
        assert_eq!(parse("string<=x a\n"), "'string<=x a': 'x' is no length");
    }
}
