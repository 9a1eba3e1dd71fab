// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Writes the Rust code.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::Error;
use super::load::{Library, Role, Type, nested_in};
use super::model::{Base, Constant, Field, FieldType, Kind, Multiplicity, TypeName, Value};
use super::{describe, schema};

/// Words that cannot be a field's name; Rust's own, and reserved ones.
const KEYWORDS: &[&str] = &[
    "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "crate", "do", "dyn", "else",
    "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let", "loop", "macro", "match", "mod",
    "move", "mut", "override", "priv", "pub", "ref", "return", "self", "static", "struct", "super", "trait", "true",
    "try", "type", "typeof", "unsafe", "unsized", "use", "virtual", "where", "while", "yield",
];

/// Appends formatted text; writing to a String cannot fail.
macro_rules! put {
    ($out:expr, $($arg:tt)*) => { writeln!($out, $($arg)*).expect("writing to a String cannot fail") };
}

/// Writes all types of a library as one module tree, `package::kind::Type`, and the registry of them all.
///
/// # Errors
/// Two types whose Rust names are the same.
pub(crate) fn emit(library: &Library) -> Result<String, Error> {
    let mut out = String::from("// Generated from the interface files by the build script.\n");
    let packages: BTreeSet<&str> = library.types.keys().map(|name| name.package.as_str()).collect();
    for package in packages {
        put!(out, "#[doc = {:?}]", format!("Interfaces of `{package}`."));
        put!(out, "#[allow(clippy::doc_markdown, reason = \"the texts are the comments of interface files\")]");
        put!(
            out,
            "#[allow(unused_qualifications, reason = \"paths are written whole, so that no name can be mistaken\")]"
        );
        put!(out, "pub mod {package} {{");
        for kind in Kind::ALL {
            let types: Vec<&Type> =
                library.types.values().filter(|ty| ty.name.package == package && ty.name.kind == kind).collect();
            if types.is_empty() {
                continue;
            }
            let noun = match kind {
                Kind::Msg => "Messages",
                Kind::Srv => "Services",
                Kind::Action => "Actions",
            };
            put!(out, "#[doc = {:?}]", format!("{noun} of `{package}`."));
            put!(out, "pub mod {} {{", kind.word());
            let mut names = BTreeSet::new();
            for ty in types {
                if !names.insert(ty.name.rust()) {
                    let what = format!("{} and another type would both be {} in Rust", ty.name, ty.name.rust());
                    return Err(Error { file: ty.source.file.clone(), line: 0, what });
                }
                match ty.role {
                    Role::Message => message(&mut out, library, ty),
                    Role::Service => service(&mut out, ty),
                    Role::Action => action(&mut out, ty),
                    Role::Event => {}
                }
            }
            put!(out, "}}");
        }
        put!(out, "}}");
    }
    registry(&mut out, library);
    Ok(out)
}

/// Name of the static that describes a type.
fn info_name(name: &TypeName) -> String {
    format!("{}_{}_{}", name.package, name.kind.word(), name.name).to_ascii_uppercase()
}

/// Documentation of a type: its comment, or its name when it has none.
fn type_doc(out: &mut String, ty: &Type, what: &str) {
    let name = ty.name.to_string();
    let comment = ty.definition.comment.iter().map(|line| escape_doc(line)).collect::<Vec<_>>().join("\n");
    let comment = comment.trim_matches('\n');
    if comment.is_empty() {
        put!(out, "#[doc = {:?}]", format!("{what} `{name}`."));
    } else {
        put!(out, "#[doc = {:?}]", format!("{comment}\n\n{what} `{name}`."));
    }
}

/// Documentation of a field or constant.
fn item_doc(out: &mut String, comment: &[String], what: &str) {
    let comment = comment.iter().map(|line| escape_doc(line)).collect::<Vec<_>>().join("\n");
    let text = if comment.trim().is_empty() { what.to_owned() } else { format!("{comment}\n\n{what}") };
    put!(out, "#[doc = {text:?}]");
}

/// Takes the meaning of Markdown from what a comment says, except within backquotes.
fn escape_doc(line: &str) -> String {
    let balanced = line.matches('`').count().is_multiple_of(2);
    let mut in_code = false;
    let mut escaped = String::new();
    for c in line.chars() {
        if c == '`' && balanced {
            in_code = !in_code;
        } else if !in_code && "\\`*_[]<>#|~".contains(c) {
            escaped.push('\\');
        }
        escaped.push(c);
    }
    escaped
}

fn field_name(field: &Field) -> String {
    if KEYWORDS.contains(&field.name.as_str()) { format!("{}_", field.name) } else { field.name.clone() }
}

fn rust_type(ty: &FieldType) -> String {
    let base = match &ty.base {
        Base::Primitive(primitive) => primitive.rust().to_owned(),
        Base::Text(_) => "::std::string::String".to_owned(),
        Base::Nested(name) => name.rust_path(),
    };
    match ty.shape {
        Multiplicity::One => base,
        Multiplicity::Array(n) => format!("[{base}; {n}]"),
        Multiplicity::BoundedSequence(_) | Multiplicity::Sequence => format!("::std::vec::Vec<{base}>"),
    }
}

/// Returns whether a default differs from Rust's own default.
fn is_notable(field: &Field) -> bool {
    match &field.default {
        None => false,
        Some(Value::Bool(value)) => *value,
        Some(Value::Integer(value)) => *value != 0,
        Some(Value::Float(value)) => value.to_bits() != 0,
        Some(Value::Text(value)) => !value.is_empty(),
        Some(Value::List(_)) => true,
    }
}

fn literal(base: &Base, value: &Value) -> String {
    match (base, value) {
        (Base::Primitive(primitive), Value::Float(float)) => {
            let ty = primitive.rust();
            if float.is_nan() {
                format!("{ty}::NAN")
            } else if float.is_infinite() {
                format!("{ty}::{}", if *float > 0.0 { "INFINITY" } else { "NEG_INFINITY" })
            } else {
                format!("{float:?}")
            }
        }
        (_, Value::Bool(value)) => value.to_string(),
        (_, Value::Integer(value)) => value.to_string(),
        (_, Value::Float(value)) => format!("{value:?}"),
        (_, Value::Text(value)) => format!("{value:?}"),
        (_, Value::List(values)) => {
            format!("[{}]", values.iter().map(|value| literal(base, value)).collect::<Vec<_>>().join(", "))
        }
    }
}

fn default_expression(field: &Field) -> String {
    let Some(value) = field.default.as_ref().filter(|_| is_notable(field)) else {
        return "::std::default::Default::default()".to_owned();
    };
    let one = |value: &Value| match &field.ty.base {
        Base::Text(_) => format!("::std::string::String::from({})", literal(&field.ty.base, value)),
        base => literal(base, value),
    };
    match (value, field.ty.shape) {
        (Value::List(values), shape) => {
            let inner = values.iter().map(one).collect::<Vec<_>>().join(", ");
            if matches!(shape, Multiplicity::Array(_)) { format!("[{inner}]") } else { format!("::std::vec![{inner}]") }
        }
        (value, _) => one(value),
    }
}

fn message(out: &mut String, library: &Library, ty: &Type) {
    let rust = ty.name.rust();
    let notable = ty.definition.fields.iter().any(is_notable);
    type_doc(out, ty, "Message");
    let default = if notable { "" } else { " Default," };
    put!(out, "#[derive(Debug, Clone, PartialEq,{default} ::serde::Serialize, ::serde::Deserialize)]");
    put!(out, "pub struct {rust} {{");
    for field in &ty.definition.fields {
        item_doc(out, &field.comment, &format!("`{} {}`", field.ty.word(), field.name));
        let name = field_name(field);
        if name != field.name {
            put!(out, "#[serde(rename = {:?})]", field.name);
        }
        put!(out, "pub {name}: {},", rust_type(&field.ty));
    }
    put!(out, "}}");
    if notable {
        put!(out, "impl ::std::default::Default for {rust} {{\nfn default() -> Self {{\nSelf {{");
        for field in &ty.definition.fields {
            put!(out, "{}: {},", field_name(field), default_expression(field));
        }
        put!(out, "}}\n}}\n}}");
    }
    if !ty.definition.constants.is_empty() {
        put!(out, "impl {rust} {{");
        for constant in &ty.definition.constants {
            put_constant(out, constant);
        }
        put!(out, "}}");
    }
    put!(out, "impl crate::Message for {rust} {{");
    names(out, ty);
    if has_bounds(library, ty) {
        check_bounds(out, library, ty);
    }
    put!(out, "}}");
    put!(out, "#[cfg(feature = \"ros2-client\")]\nimpl ::ros2_client::Message for {rust} {{}}");
}

fn put_constant(out: &mut String, constant: &Constant) {
    let (word, rust) = match &constant.base {
        Base::Primitive(primitive) => (primitive.word(), primitive.rust()),
        _ => ("string", "&'static str"),
    };
    item_doc(out, &constant.comment, &format!("Constant, `{word}`."));
    put!(out, "pub const {}: {rust} = {};", constant.name, literal(&constant.base, &constant.value));
}

/// Returns whether a message or anything in it has a bound that Rust's types do not hold by themselves.
fn has_bounds(library: &Library, ty: &Type) -> bool {
    let own = ty.definition.fields.iter().any(|field| {
        matches!(field.ty.shape, Multiplicity::BoundedSequence(_)) || matches!(field.ty.base, Base::Text(Some(_)))
    });
    own || nested_in(ty).any(|name| library.types.get(name).is_some_and(|nested| has_bounds(library, nested)))
}

fn check_bounds(out: &mut String, library: &Library, ty: &Type) {
    put!(out, "fn check_bounds(&self) -> ::std::result::Result<(), crate::BoundsError> {{");
    for field in &ty.definition.fields {
        let (name, label) = (field_name(field), format!("{}.{}", ty.name, field.name));
        if let Multiplicity::BoundedSequence(bound) = field.ty.shape {
            put!(out, "crate::BoundsError::check({label:?}, self.{name}.len(), {bound})?;");
        }
        let inner = match &field.ty.base {
            Base::Text(Some(bound)) => format!("crate::BoundsError::check({label:?}, element.len(), {bound})?;"),
            Base::Nested(nested) if library.types.get(nested).is_some_and(|nested| has_bounds(library, nested)) => {
                "crate::Message::check_bounds(element)?;".to_owned()
            }
            _ => continue,
        };
        if field.ty.shape == Multiplicity::One {
            put!(out, "let element = &self.{name};\n{inner}");
        } else {
            put!(out, "for element in &self.{name} {{\n{inner}\n}}");
        }
    }
    put!(out, "::std::result::Result::Ok(())\n}}");
}

fn names(out: &mut String, ty: &Type) {
    put!(out, "const PACKAGE: &'static str = {:?};", ty.name.package);
    put!(out, "const NAME: &'static str = {:?};", ty.name.name);
    put!(out, "const INFO: &'static crate::InterfaceInfo = &crate::generated_registry::{};", info_name(&ty.name));
}

fn service(out: &mut String, ty: &Type) {
    let rust = ty.name.rust();
    type_doc(out, ty, "Service");
    put!(out, "#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]\npub struct {rust};");
    put!(out, "impl crate::Service for {rust} {{");
    put!(out, "type Request = {rust}Request;\ntype Response = {rust}Response;");
    names(out, ty);
    put!(out, "}}");
}

fn action(out: &mut String, ty: &Type) {
    let rust = ty.name.rust();
    type_doc(out, ty, "Action");
    put!(out, "#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]\npub struct {rust};");
    put!(out, "impl crate::Action for {rust} {{");
    for part in ["Goal", "Result", "Feedback", "SendGoal", "GetResult", "FeedbackMessage"] {
        put!(out, "type {part} = {rust}{part};");
    }
    names(out, ty);
    let uuid = "crate::unique_identifier_msgs::msg::UUID";
    let time = "crate::builtin_interfaces::msg::Time";
    for (name, message, parts) in [
        ("send_goal_request", "SendGoalRequest", [("goal_id", uuid), ("goal", "Self::Goal")].as_slice()),
        ("send_goal_response", "SendGoalResponse", &[("accepted", "bool"), ("stamp", time)]),
        ("get_result_request", "GetResultRequest", &[("goal_id", uuid)]),
        ("get_result_response", "GetResultResponse", &[("status", "i8"), ("result", "Self::Result")]),
        ("feedback_message", "FeedbackMessage", &[("goal_id", uuid), ("feedback", "Self::Feedback")]),
    ] {
        let parameters = parts.iter().map(|(part, ty)| format!("{part}: {ty}")).collect::<Vec<_>>().join(", ");
        let fields = parts.iter().map(|(part, _)| *part).collect::<Vec<_>>().join(", ");
        put!(out, "fn {name}({parameters}) -> {rust}{message} {{\n{rust}{message} {{ {fields} }}\n}}");
        let types = parts.iter().map(|(_, ty)| *ty).collect::<Vec<_>>().join(", ");
        let values = parts.iter().map(|(part, _)| format!("message.{part}")).collect::<Vec<_>>().join(", ");
        let (types, values) =
            if parts.len() == 1 { (types, values) } else { (format!("({types})"), format!("({values})")) };
        put!(out, "fn split_{name}(message: {rust}{message}) -> {types} {{\n{values}\n}}");
    }
    put!(out, "}}");
}

fn registry(out: &mut String, library: &Library) {
    put!(out, "#[doc = \"What is known of each type, generated.\"]\nmod generated_registry {{");
    put!(out, "use crate::{{FieldInfo, InterfaceInfo, InterfaceKind}};");
    let mut all: Vec<_> = library.types.values().collect();
    all.sort_by_key(|ty| ty.name.to_string());
    for ty in &all {
        let kind = match ty.role {
            Role::Message | Role::Event => "Message",
            Role::Service => "Service",
            Role::Action => "Action",
        };
        let schema = if kind == "Message" { schema::text(library, &ty.name) } else { String::new() };
        let mut referenced: Vec<_> = library.referenced(&ty.name).iter().map(ToString::to_string).collect();
        referenced.sort();
        put!(out, "pub(crate) static {}: InterfaceInfo = InterfaceInfo {{", info_name(&ty.name));
        put!(out, "type_name: {:?}, dds_type_name: {:?},", ty.name.to_string(), ty.name.dds());
        put!(out, "type_hash: {:?}, kind: InterfaceKind::{kind},", describe::hash(library, &ty.name));
        put!(out, "schema: {schema:?},");
        put!(out, "source_encoding: {:?}, source: {:?},", ty.source.encoding, ty.source.text);
        put!(out, "fields: &[");
        for field in describe::fields(ty) {
            put!(
                out,
                "FieldInfo {{ name: {:?}, type_id: {}, capacity: {}, string_capacity: {}, nested_type_name: {:?}, \
                 default_value: {:?} }},",
                field.name,
                field.type_id,
                field.capacity,
                field.string_capacity,
                field.nested_type_name,
                field.default_value
            );
        }
        put!(out, "],\nreferenced: &{referenced:?},\n}};");
    }
    put!(out, "pub(crate) const ALL: &[&InterfaceInfo] = &[");
    for ty in &all {
        put!(out, "&{},", info_name(&ty.name));
    }
    put!(out, "];\n}}");
    for_each(out, &all);
}

/// Writes a macro that hands the Rust types of all messages to another macro, for code that wants one of each.
fn for_each(out: &mut String, all: &[&Type]) {
    put!(out, "/// Calls the named macro with the path of every message type, in the order of names.");
    put!(out, "#[macro_export]\nmacro_rules! for_each_message {{\n($callback:ident) => {{\n$callback! {{");
    for ty in all.iter().filter(|ty| matches!(ty.role, Role::Message)) {
        put!(out, "${},", ty.name.rust_path());
    }
    put!(out, "}}\n}};\n}}");
}
