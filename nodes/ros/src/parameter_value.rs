// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Values of parameters and their types.

use std::fmt;

/// Value of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum ParameterValue {
    /// No value: only an optional parameter may have it.
    NotSet,
    /// `bool`.
    Bool(bool),
    /// `int64`.
    Integer(i64),
    /// `float64`.
    Double(f64),
    /// `string`.
    String(String),
    /// `byte[]`.
    ByteArray(Vec<u8>),
    /// `bool[]`.
    BoolArray(Vec<bool>),
    /// `int64[]`.
    IntegerArray(Vec<i64>),
    /// `float64[]`.
    DoubleArray(Vec<f64>),
    /// `string[]`.
    StringArray(Vec<String>),
}

impl ParameterValue {
    /// `rcl_interfaces/msg/ParameterType`.
    pub fn type_id(&self) -> u8 {
        match self {
            ParameterValue::NotSet => 0,
            ParameterValue::Bool(_) => 1,
            ParameterValue::Integer(_) => 2,
            ParameterValue::Double(_) => 3,
            ParameterValue::String(_) => 4,
            ParameterValue::ByteArray(_) => 5,
            ParameterValue::BoolArray(_) => 6,
            ParameterValue::IntegerArray(_) => 7,
            ParameterValue::DoubleArray(_) => 8,
            ParameterValue::StringArray(_) => 9,
        }
    }

    /// Name of the type, for sentences.
    pub fn type_name(&self) -> &'static str {
        match self {
            ParameterValue::NotSet => "value that is not set",
            ParameterValue::Bool(_) => "bool",
            ParameterValue::Integer(_) => "integer",
            ParameterValue::Double(_) => "double",
            ParameterValue::String(_) => "string",
            ParameterValue::ByteArray(_) => "byte_array",
            ParameterValue::BoolArray(_) => "bool_array",
            ParameterValue::IntegerArray(_) => "integer_array",
            ParameterValue::DoubleArray(_) => "double_array",
            ParameterValue::StringArray(_) => "string_array",
        }
    }

    /// The value as the type of `like`, where a file or a command line can mean nothing else: `1` for a double, `[]` for any
    /// array. (A change by service must have the exact type, as with rclcpp.)
    pub(super) fn meant_as(self, like: &ParameterValue) -> ParameterValue {
        match (self, like) {
            (ParameterValue::Integer(value), ParameterValue::Double(_)) => ParameterValue::Double(value as f64),
            (ParameterValue::IntegerArray(values), ParameterValue::DoubleArray(_)) => {
                ParameterValue::DoubleArray(values.into_iter().map(|value| value as f64).collect())
            }
            (ParameterValue::StringArray(values), like) if values.is_empty() => match like {
                ParameterValue::BoolArray(_) => ParameterValue::BoolArray(Vec::new()),
                ParameterValue::IntegerArray(_) => ParameterValue::IntegerArray(Vec::new()),
                ParameterValue::DoubleArray(_) => ParameterValue::DoubleArray(Vec::new()),
                ParameterValue::ByteArray(_) => ParameterValue::ByteArray(Vec::new()),
                _ => ParameterValue::StringArray(Vec::new()),
            },
            // YAML has `.inf` and `.nan`; rcl takes the words too.
            (ParameterValue::String(text), ParameterValue::Double(_)) => match text.parse::<f64>() {
                Ok(value) if !value.is_finite() && !text.contains(|c: char| c.is_ascii_digit()) => {
                    ParameterValue::Double(value)
                }
                _ => ParameterValue::String(text),
            },
            (value, _) => value,
        }
    }
}

impl fmt::Display for ParameterValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ParameterValue::NotSet => f.write_str("not set"),
            ParameterValue::Bool(value) => write!(f, "{value}"),
            ParameterValue::Integer(value) => write!(f, "{value}"),
            ParameterValue::Double(value) => write!(f, "{value}"),
            ParameterValue::String(value) => write!(f, "'{}'", shortened(value)),
            ParameterValue::ByteArray(values) => write!(f, "{} bytes", values.len()),
            ParameterValue::BoolArray(values) => write!(f, "{} bools", values.len()),
            ParameterValue::IntegerArray(values) => write!(f, "{} integers", values.len()),
            ParameterValue::DoubleArray(values) => write!(f, "{} doubles", values.len()),
            ParameterValue::StringArray(values) => write!(f, "{} strings", values.len()),
        }
    }
}

/// The beginning of a text that a message can carry.
fn shortened(text: &str) -> String {
    const MAX_CHARS: usize = 80;
    if text.chars().nth(MAX_CHARS).is_none() {
        return text.to_owned();
    }
    text.chars().take(MAX_CHARS).chain("...".chars()).collect()
}
