// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Type descriptions and their hashes, RIHS01 (ROS Interface Hashing Standard, version 1).
//!
//! The hash is SHA-256 over the JSON of the description and of all descriptions it refers to, written as Python's
//! `json.dumps` would with default separators. Names, order, types and bounds enter; comments, constants and defaults
//! do not.

use std::fmt::Write as _;

use sha2::{Digest, Sha256};

use super::load::{Library, Type};
use super::model::{Base, Field, Multiplicity, Primitive, TypeName, Value};

/// A field as `type_description_interfaces/msg/Field` has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FieldDescription {
    pub(crate) name: String,
    pub(crate) type_id: u8,
    pub(crate) capacity: usize,
    pub(crate) string_capacity: usize,
    pub(crate) nested_type_name: String,
    pub(crate) default_value: String,
}

/// Describes the fields of a type.
pub(crate) fn fields(ty: &Type) -> Vec<FieldDescription> {
    ty.definition.fields.iter().map(field).collect()
}

fn field(field: &Field) -> FieldDescription {
    let base = match &field.ty.base {
        Base::Nested(_) => 1,
        Base::Primitive(primitive) => match primitive {
            Primitive::Int8 => 2,
            // A char of an interface file is an unsigned byte, not the character of IDL.
            Primitive::Uint8 | Primitive::Char => 3,
            Primitive::Int16 => 4,
            Primitive::Uint16 => 5,
            Primitive::Int32 => 6,
            Primitive::Uint32 => 7,
            Primitive::Int64 => 8,
            Primitive::Uint64 => 9,
            Primitive::Float32 => 10,
            Primitive::Float64 => 11,
            Primitive::Bool => 15,
            Primitive::Byte => 16,
        },
        Base::Text(None) => 17,
        Base::Text(Some(_)) => 21,
    };
    let (offset, capacity) = match field.ty.shape {
        Multiplicity::One => (0, 0),
        Multiplicity::Array(n) => (48, n),
        Multiplicity::BoundedSequence(n) => (96, n),
        Multiplicity::Sequence => (144, 0),
    };
    FieldDescription {
        name: field.name.clone(),
        type_id: base + offset,
        capacity,
        string_capacity: if let Base::Text(Some(bound)) = field.ty.base { bound } else { 0 },
        nested_type_name: if let Base::Nested(name) = &field.ty.base { name.to_string() } else { String::new() },
        default_value: field.default.as_ref().map(|value| python(value, true)).unwrap_or_default(),
    }
}

/// A value as rosidl writes it into descriptions, which is how Python prints it.
fn python(value: &Value, outermost: bool) -> String {
    match value {
        Value::Bool(true) => "True".to_owned(),
        Value::Bool(false) => "False".to_owned(),
        Value::Integer(integer) => integer.to_string(),
        Value::Float(float) => format!("{float:?}"),
        Value::Text(text) if outermost => text.clone(),
        Value::Text(text) if text.contains('\'') && !text.contains('"') => format!("\"{text}\""),
        Value::Text(text) => format!("'{}'", text.replace('\'', "\\'")),
        Value::List(values) => {
            let inner = values.iter().map(|value| python(value, false)).collect::<Vec<_>>().join(", ");
            // A tuple of one keeps its comma.
            if values.len() == 1 { format!("({inner},)") } else { format!("({inner})") }
        }
    }
}

/// The hash of a type, `RIHS01_` and 64 hexadecimal digits.
pub(crate) fn hash(library: &Library, name: &TypeName) -> String {
    let mut text = String::from("{\"type_description\": ");
    write_description(&mut text, library, name);
    text.push_str(", \"referenced_type_descriptions\": [");
    // By full name as text, where action stands before msg.
    let mut referenced: Vec<_> = library.referenced(name).into_iter().collect();
    referenced.sort_by_key(ToString::to_string);
    for (index, referenced) in referenced.iter().enumerate() {
        if index > 0 {
            text.push_str(", ");
        }
        write_description(&mut text, library, referenced);
    }
    text.push_str("]}");
    let mut hash = String::from("RIHS01_");
    for byte in Sha256::digest(text.as_bytes()) {
        write!(hash, "{byte:02x}").expect("writing to a String cannot fail");
    }
    hash
}

fn write_description(text: &mut String, library: &Library, name: &TypeName) {
    write!(text, "{{\"type_name\": \"{name}\", \"fields\": [").expect("writing to a String cannot fail");
    for (index, field) in library.types.get(name).map(fields).unwrap_or_default().iter().enumerate() {
        let separator = if index > 0 { ", " } else { "" };
        write!(
            text,
            "{separator}{{\"name\": \"{}\", \"type\": {{\"type_id\": {}, \"capacity\": {}, \"string_capacity\": {}, \
             \"nested_type_name\": \"{}\"}}}}",
            field.name, field.type_id, field.capacity, field.string_capacity, field.nested_type_name
        )
        .expect("writing to a String cannot fail");
    }
    text.push_str("]}");
}
